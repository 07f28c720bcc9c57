//! Balls and sticks of few pixels, sixteen of them together, in a tile with one sample a pixel.
//!
//! Whole blocks of samples ([`super::tile`]) are not worth it for these. They wait until there are sixteen; then one pixel after the other of
//! all of them is asked at once whether they may cover it, and whether something nearer was seen there. Those that are left are listed, and
//! the depths of sixteen found together. Which were drawn before others makes no difference: the nearest is seen.

use super::intersect::FLAT_CAPS;
use super::intersect::{flat_cylinder_t, sphere_entry};
use super::lanes::{LANES, Lanes};
use super::looks::{NO_ENDS, StickSurface};
use super::tile::{Place, SAMPLES, SIDE, Tile, hit_at, ray};
use crate::math::rotation_to_y;
use crate::render::solids::{Cylinder, Sphere};
use glam::Vec3;

/// Pixels of the rectangle around a thing that is drawn pixel by pixel, at most. Chosen, other numbers were not tried.
pub(super) const FEW: u32 = 24;

/// Pixels by which bounds are wider, for the rounding of the way here.
pub(super) const SLACK: f32 = 0.02;

/// Something small, told by so many numbers.
pub(super) trait Kind<const N: usize> {
    /// Whether the depth is found of all sixteen at once, although not all of them cover a pixel: of what is quickly found. Else samples that
    /// may be covered are listed first.
    const AT_ONCE: bool;

    /// Whether it may cover a point of the full picture. Of each number that of one thing.
    fn covers(numbers: &[f32; N], x: f32, y: f32) -> bool;

    /// Its depth along the ray of plane coordinates; it lies beyond `near`.
    fn t<const PARALLEL: bool>(numbers: &[f32; N], u: f32, v: f32, near: f32) -> f32;

    /// Its normal, and the bytes of its colour, where it is hit.
    fn looks(numbers: &[f32; N], hit: Vec3) -> (Vec3, u32);
}

/// A ball: its middle and the square of its radius in the picture, pixels; centre in view space, and radius; the bits of its colour.
pub(super) enum Ball {}

impl Kind<8> for Ball {
    const AT_ONCE: bool = true;

    #[inline(always)]
    fn covers(&[middle_x, middle_y, reach, ..]: &[f32; 8], x: f32, y: f32) -> bool {
        let (x, y) = (x - middle_x, y - middle_y);
        x * x + y * y <= reach
    }

    #[inline(always)]
    fn t<const PARALLEL: bool>(&[_, _, _, x, y, z, radius, _]: &[f32; 8], u: f32, v: f32, _near: f32) -> f32 {
        sphere_entry(&ray::<PARALLEL>(u, v), &Sphere { center: Vec3::new(x, y, z), radius })
    }

    #[inline(always)]
    fn looks(&[_, _, _, x, y, z, _, color]: &[f32; 8], hit: Vec3) -> (Vec3, u32) {
        (hit - Vec3::new(x, y, z), color.to_bits())
    }
}

/// A stick with flat caps: the rectangle around it in the picture, pixels (its middle, its half sides, the direction of the first); its
/// centre in view space, its axis from end to end, of unit length, half its length, and radius; the bits of the colours of its halves.
pub(super) enum Stick {}

impl Kind<16> for Stick {
    const AT_ONCE: bool = false;

    #[inline(always)]
    fn covers(&[middle_x, middle_y, half_x, half_y, along_x, along_y, ..]: &[f32; 16], x: f32, y: f32) -> bool {
        let (x, y) = (x - middle_x, y - middle_y);
        let (run, aside) = (x * along_x + y * along_y, x * along_y - y * along_x);
        (run.abs() <= half_x + SLACK) & (aside.abs() <= half_y + SLACK)
    }

    #[inline(always)]
    fn t<const PARALLEL: bool>(numbers: &[f32; 16], u: f32, v: f32, near: f32) -> f32 {
        let &[_, _, _, _, _, _, x, y, z, axis_x, axis_y, axis_z, half_length, radius, ..] = numbers;
        let cylinder = Cylinder {
            center: Vec3::new(x, y, z),
            cylinder_from_space: rotation_to_y(Vec3::new(axis_x, axis_y, axis_z)),
            half_length,
            radius,
            caps: FLAT_CAPS,
            hidden: 0,
        };
        flat_cylinder_t(&ray::<PARALLEL>(u, v), &cylinder, near)
    }

    #[inline(always)]
    fn looks(numbers: &[f32; 16], hit: Vec3) -> (Vec3, u32) {
        let &[_, _, _, _, _, _, x, y, z, axis_x, axis_y, axis_z, half_length, radius, first, second] = numbers;
        let (center, axis) = (Vec3::new(x, y, z), Vec3::new(axis_x, axis_y, axis_z));
        let surface = StickSurface { center, axis, radius, caps: [-half_length, half_length], ends: NO_ENDS };
        let (normal, is_second) = surface.at_one(hit);
        (normal, if is_second { second.to_bits() } else { first.to_bits() })
    }
}

/// Things of one kind that wait to be drawn.
pub(super) struct Waiting<K, const N: usize> {
    count: usize,
    /// Their numbers in the scene.
    index: [u32; LANES],
    /// No point of them is nearer.
    nearest: Lanes,
    /// Pixels of the tile: left, top, right, bottom, the last two exclusive.
    pixels: [[u32; LANES]; 4],
    numbers: [Lanes; N],
    kind: std::marker::PhantomData<K>,
}

/// Samples that things may cover: sixteen that are worked on, and up to as many more.
struct Listed {
    count: usize,
    /// Which of the things.
    of: [u32; 2 * LANES],
    /// Where they stand in the tile's samples.
    at: [u32; 2 * LANES],
    u: [f32; 2 * LANES],
    v: [f32; 2 * LANES],
}

impl<K: Kind<N>, const N: usize> Waiting<K, N> {
    #[inline(always)]
    pub(super) fn new() -> Waiting<K, N> {
        Waiting {
            count: 0,
            index: [0; LANES],
            nearest: [0.0; LANES],
            pixels: [[0; LANES]; 4],
            numbers: [[0.0; LANES]; N],
            kind: std::marker::PhantomData,
        }
    }

    /// Adds something, and draws all that waits if that makes sixteen.
    #[inline(always)]
    pub(super) fn add<const PARALLEL: bool>(
        &mut self,
        (tile, place): (&mut Tile, &Place<'_>),
        pixels: [u32; 4],
        (nearest, index): (f32, u32),
        numbers: &[f32; N],
    ) {
        let lane = self.count % LANES;
        (self.index[lane], self.nearest[lane]) = (index, nearest);
        for (lanes, pixel) in self.pixels.iter_mut().zip(pixels) {
            lanes[lane] = pixel;
        }
        for (lanes, number) in self.numbers.iter_mut().zip(numbers) {
            lanes[lane] = *number;
        }
        self.count += 1;
        if self.count == LANES {
            self.draw::<PARALLEL>(tile, place);
        }
    }

    /// Draws all that waits.
    #[inline(always)]
    pub(super) fn draw<const PARALLEL: bool>(&mut self, tile: &mut Tile, place: &Place<'_>) {
        let [left, top, right, bottom] = &self.pixels;
        let (mut x, mut y, mut end) = (*left, *top, *bottom);
        for (lane, end) in end.iter_mut().enumerate() {
            *end = if lane < self.count { *end } else { 0 };
        }
        let mut listed =
            Listed { count: 0, of: [0; 2 * LANES], at: [0; 2 * LANES], u: [0.0; 2 * LANES], v: [0.0; 2 * LANES] };
        let grid = &place.grid;
        // The first sample of a block is as far from its corner as every other's.
        let (dx, dy) = (place.pass.x[0], place.pass.y[0]);
        let (corner_x, corner_y) = (place.corner[0], place.corner[1]);
        loop {
            let (mut at, mut u, mut v) = ([0u32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
            let (mut is_left, mut may) = (0u32, [0u32; LANES]);
            for lane in 0..LANES {
                let ([x, y], is_there) = ([x[lane], y[lane]], y[lane] < end[lane]);
                is_left |= u32::from(is_there);
                at[lane] = ((y >> 2) * SIDE as u32 + (x >> 2)) * LANES as u32 + (y & 3) * 4 + (x & 3);
                // The same bits as of [`Place::u`].
                let px = (corner_x + (x & !3)) as i32 as f32 + ((x & 3) as i32 as f32 + dx);
                let py = (corner_y + (y & !3)) as i32 as f32 + ((y & 3) as i32 as f32 + dy);
                u[lane] = (px - grid.center_px[0]) * grid.plane_per_px;
                v[lane] = (grid.center_px[1] - py) * grid.plane_per_px;
                let mut numbers = [0.0; N];
                for (number, lanes) in numbers.iter_mut().zip(&self.numbers) {
                    *number = lanes[lane];
                }
                let is_asked = is_there & K::covers(&numbers, px, py);
                may[lane] = if is_asked { u32::MAX } else { 0 };
            }
            if is_left == 0 {
                break;
            }
            let depths = tile.depths();
            let mut before = [0.0f32; LANES];
            for lane in 0..LANES {
                before[lane] = depths[at[lane] as usize % SAMPLES];
            }
            let mut bits = 0u32;
            for lane in 0..LANES {
                let is_asked = (may[lane] != 0) & (self.nearest[lane] <= before[lane]);
                bits |= u32::from(is_asked) << lane;
            }
            if K::AT_ONCE && bits != 0 {
                self.see_at_once::<PARALLEL>((&at, &u, &v), (bits, &before), tile, place.near);
                bits = 0;
            }
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize % LANES;
                bits &= bits - 1;
                let slot = listed.count % (2 * LANES);
                (listed.of[slot], listed.at[slot]) = (lane as u32, at[lane]);
                (listed.u[slot], listed.v[slot]) = (u[lane], v[lane]);
                listed.count += 1;
            }
            if listed.count >= LANES {
                self.see::<PARALLEL>(&mut listed, tile, place.near);
            }
            for lane in 0..LANES {
                let next = x[lane] + 1;
                let is_over = next >= right[lane];
                x[lane] = if is_over { left[lane] } else { next };
                y[lane] += u32::from(is_over);
            }
        }
        if listed.count > 0 {
            self.see::<PARALLEL>(&mut listed, tile, place.near);
        }
        self.count = 0;
    }

    /// Finds the depths of all sixteen where they are asked in samples `at`, and of those with a bit sees what is no farther than `before`.
    #[inline(always)]
    fn see_at_once<const PARALLEL: bool>(
        &self,
        (at, u, v): (&[u32; LANES], &Lanes, &Lanes),
        (asked, before): (u32, &Lanes),
        tile: &mut Tile,
        near: f32,
    ) {
        let (mut depth, mut normal, mut color) = ([0.0f32; LANES], [[0.0f32; LANES]; 3], [0u32; LANES]);
        let mut bits = 0u32;
        for lane in 0..LANES {
            let mut numbers = [0.0; N];
            for (number, lanes) in numbers.iter_mut().zip(&self.numbers) {
                *number = lanes[lane];
            }
            depth[lane] = K::t::<PARALLEL>(&numbers, u[lane], v[lane], near);
            let (n, c) = K::looks(&numbers, hit_at::<PARALLEL>(u[lane], v[lane], depth[lane]));
            (normal[0][lane], normal[1][lane], normal[2][lane], color[lane]) = (n.x, n.y, n.z, c);
            bits |= u32::from(depth[lane] <= before[lane]) << lane;
        }
        bits &= asked;
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
            bits &= bits - 1;
            let looks = ([normal[0][lane], normal[1][lane], normal[2][lane]], color[lane]);
            tile.see_at(at[lane] as usize, (depth[lane], self.index[lane]), looks);
        }
    }

    /// Finds the depths of the first sixteen that are listed, and takes them from the list.
    #[inline(always)]
    fn see<const PARALLEL: bool>(&self, listed: &mut Listed, tile: &mut Tile, near: f32) {
        let (mut depth, mut normal, mut color) = ([0.0f32; LANES], [[0.0f32; LANES]; 3], [0u32; LANES]);
        for lane in 0..LANES {
            let of = listed.of[lane] as usize % LANES;
            let mut numbers = [0.0; N];
            for (number, lanes) in numbers.iter_mut().zip(&self.numbers) {
                *number = lanes[of];
            }
            let (u, v) = (listed.u[lane], listed.v[lane]);
            depth[lane] = K::t::<PARALLEL>(&numbers, u, v, near);
            let (n, c) = K::looks(&numbers, hit_at::<PARALLEL>(u, v, depth[lane]));
            (normal[0][lane], normal[1][lane], normal[2][lane], color[lane]) = (n.x, n.y, n.z, c);
        }
        let count = listed.count.min(LANES);
        for (lane, &depth) in depth.iter().enumerate().take(count) {
            let of = listed.of[lane] as usize % LANES;
            let looks = ([normal[0][lane], normal[1][lane], normal[2][lane]], color[lane]);
            tile.see_at(listed.at[lane] as usize, (depth, self.index[of]), looks);
        }
        listed.count -= count;
        for lane in 0..LANES {
            let next = lane + LANES;
            (listed.of[lane], listed.at[lane]) = (listed.of[next], listed.at[next]);
            (listed.u[lane], listed.v[lane]) = (listed.u[next], listed.v[next]);
        }
    }
}
