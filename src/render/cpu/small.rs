//! Small balls and sticks of a pack, sixteen at a time: where they lie in a tile.
//!
//! What covers no sample of the tile is found out before anything else is: in pictures of large structures that is most. What covers few is
//! drawn by [`super::few`].

use super::behind::Mask;
use super::binning::{Candidate, Framing};
use super::few::{Ball, FEW, SLACK, Stick, Waiting};
use super::intersect::FLAT_CAPS;
use super::lanes::{LANES, Lanes};
use super::moved::{Axes, moved};
use super::packs::Placed;
use super::tile::{Place, Tile};
use crate::math::{max, min, whole};
use crate::render::bounds::PlaneRect;
use crate::render::solids::{Cylinder, Sphere};
use glam::{Vec2, Vec3};

/// A tile for things whose places are in pixels of the full picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// Its upper left corner.
    corner: [f32; 2],
    /// Its pixels.
    size: [f32; 2],
    /// The least and the greatest place of a sample in its pixel.
    samples: [[f32; 2]; 2],
    /// Whether there is one sample a pixel.
    pub(super) is_simple: bool,
}

impl Window {
    #[inline(always)]
    pub(super) fn new(place: &Place<'_>) -> Window {
        let side = place.pass.side;
        let range = |at: &Lanes| {
            let places = at.map(f32::fract);
            [places.into_iter().fold(1.0, min), places.into_iter().fold(0.0, max)]
        };
        Window {
            corner: place.corner.map(|at| at as f32),
            size: place.blocks.map(|blocks| (blocks as u32 * side) as f32),
            samples: [range(&place.pass.x), range(&place.pass.y)],
            is_simple: side == 4,
        }
    }

    /// The pixels of the tile that have samples between two places, the last exclusive.
    #[inline(always)]
    fn pixels(&self, axis: usize, low: &Lanes, high: &Lanes) -> [[u32; LANES]; 2] {
        let ([first, last], size) = (self.samples[axis], self.size[axis]);
        let (low_origin, high_origin) = (self.corner[axis] + last, self.corner[axis] + first);
        let mut pixels = [[0; LANES]; 2];
        for lane in 0..LANES {
            // Rounded up, and rounded down and one more.
            let from = low[lane] - low_origin + (0.5 - SLACK);
            let to = high[lane] - high_origin + (0.5 + SLACK);
            pixels[0][lane] = whole(min(max(from, 0.0), size));
            pixels[1][lane] = whole(min(max(to, 0.0), size));
        }
        pixels
    }
}

/// Where things lie in the picture. Of what is not small nothing else is said.
struct Bounds {
    is_small: Mask,
    nearest: Lanes,
    /// Pixels of the tile: left, right, top, bottom, the second of each exclusive.
    pixels: [[[u32; LANES]; 2]; 2],
}

impl Bounds {
    /// Of rectangles in pixels of the full picture: the least and the greatest x and y.
    #[inline(always)]
    fn new(window: &Window, is_small: Mask, nearest: Lanes, [low, high]: [[Lanes; 2]; 2]) -> Bounds {
        let pixels = [window.pixels(0, &low[0], &high[0]), window.pixels(1, &low[1], &high[1])];
        Bounds { is_small, nearest, pixels }
    }

    /// A bit for each of the first `count` that is not small, or has pixels.
    #[inline(always)]
    fn asked(&self, count: usize) -> u32 {
        let [[left, right], [top, bottom]] = &self.pixels;
        let mut bits = 0;
        for lane in 0..LANES {
            let has_pixels = (left[lane] < right[lane]) & (top[lane] < bottom[lane]);
            bits |= u32::from(has_pixels | (self.is_small[lane] == 0)) << lane;
        }
        bits & ((1 << count.min(LANES)) - 1)
    }

    /// The pixels of one of them, from the tile's corner: left, top, right, bottom.
    #[inline(always)]
    fn of(&self, lane: usize) -> [u32; 4] {
        let [[left, right], [top, bottom]] = &self.pixels;
        [left[lane], top[lane], right[lane], bottom[lane]]
    }
}

/// Things that wait to be drawn together.
pub(super) struct Queues {
    balls: Waiting<Ball, 8>,
    sticks: Waiting<Stick, 16>,
}

impl Queues {
    #[inline(always)]
    pub(super) fn new() -> Queues {
        Queues { balls: Waiting::new(), sticks: Waiting::new() }
    }

    /// Draws all of them.
    #[inline(always)]
    pub(super) fn draw<const PARALLEL: bool>(&mut self, tile: &mut Tile, place: &Place<'_>) {
        self.balls.draw::<PARALLEL>(tile, place);
        self.sticks.draw::<PARALLEL>(tile, place);
    }
}

/// Draws some balls of a block in a tile, or has them wait: their numbers in the block, and where the first of them stands in the packs.
#[inline(always)]
pub(super) fn draw_balls<const PARALLEL: bool>(
    (tile, place, queues): (&mut Tile, &Place<'_>, &mut Queues),
    (window, framing): (&Window, &Framing),
    placed: &Placed<'_>,
    (first, members): (usize, &[u32]),
) {
    for (members, first) in members.chunks(LANES).zip((first..).step_by(LANES)) {
        let [x, y, z, radius] = placed.balls(first);
        let center = moved(&placed.view_from_block, [x, y, z]);
        let (at, reach, is_small) = framing.small_ones(&center, radius);
        let (mut low, mut high, mut nearest) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2], [0.0; LANES]);
        for lane in 0..LANES {
            for axis in 0..2 {
                low[axis][lane] = at[axis][lane] - reach[lane];
                high[axis][lane] = at[axis][lane] + reach[lane];
            }
            nearest[lane] = Framing::no_nearer(-center[2][lane] - radius[lane]);
        }
        let bounds = Bounds::new(window, is_small, nearest, [low, high]);
        let mut asked = bounds.asked(members.len());
        while asked != 0 {
            let lane = asked.trailing_zeros() as usize % LANES;
            asked &= asked - 1;
            let center_of = Vec3::new(center[0][lane], center[1][lane], center[2][lane]);
            let sphere = Sphere { center: center_of, radius: radius[lane] };
            let (index, color) = (placed.first_sphere + members[lane], placed.ball_color(first + lane));
            if bounds.is_small[lane] == 0 {
                if let Some(candidate) = framing.sphere(index, &sphere)
                    && !tile.hides(place, candidate.nearest, candidate.pixels)
                {
                    tile.draw_sphere::<PARALLEL>(place, &candidate, (&sphere, color));
                }
                continue;
            }
            let pixels = bounds.of(lane);
            let (middle, reach, nearest) = ([at[0][lane], at[1][lane]], reach[lane], bounds.nearest[lane]);
            if window.is_simple && (pixels[2] - pixels[0]) * (pixels[3] - pixels[1]) <= FEW {
                let [x, y, z] = center_of.to_array();
                let square = (reach + SLACK) * (reach + SLACK);
                let color = f32::from_bits(bytemuck::cast(color));
                let numbers = [middle[0], middle[1], square, x, y, z, sphere.radius, color];
                queues.balls.add::<PARALLEL>((tile, place), pixels, (nearest, index), &numbers);
                continue;
            }
            let rect = PlaneRect { center: middle.into(), half: Vec2::splat(reach), along: Vec2::X };
            let pixels = place.in_the_region(pixels);
            if !tile.hides(place, nearest, pixels) {
                let candidate = Candidate { index, nearest, pixels, rect, is_round: true };
                tile.draw_sphere::<PARALLEL>(place, &candidate, (&sphere, color));
            }
        }
    }
}

/// Draws some sticks of a block in a tile, see [`draw_balls`]; whether all have flat caps (which saves a look at each).
#[inline(always)]
pub(super) fn draw_sticks<const PARALLEL: bool>(
    (tile, place, queues): (&mut Tile, &Place<'_>, &mut Queues),
    (window, framing): (&Window, &Framing),
    placed: &Placed<'_>,
    (first, members, are_flat): (usize, &[u32], bool),
) {
    for (members, first) in members.chunks(LANES).zip((first..).step_by(LANES)) {
        let (ends, radius) = placed.sticks(first);
        let Axes { center, along, half_length } = Axes::new(&placed.view_from_block, ends);
        let [mut a, mut b] = [[[0.0; LANES]; 3]; 2];
        for axis in 0..3 {
            for lane in 0..LANES {
                let half = along[axis][lane] * half_length[lane];
                (a[axis][lane], b[axis][lane]) = (center[axis][lane] - half, center[axis][lane] + half);
            }
        }
        let ((at_a, reach_a, small_a), (at_b, reach_b, small_b)) =
            (framing.small_ones(&a, radius), framing.small_ones(&b, radius));
        let (mut low, mut high, mut nearest) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2], [0.0; LANES]);
        let (mut reach, mut is_small) = ([0.0; LANES], [0; LANES]);
        for lane in 0..LANES {
            // Around the balls at both ends.
            reach[lane] = max(reach_a[lane], reach_b[lane]);
            is_small[lane] = small_a[lane] & small_b[lane];
            for axis in 0..2 {
                let (a, b) = (at_a[axis][lane], at_b[axis][lane]);
                low[axis][lane] = min(a, b) - reach[lane];
                high[axis][lane] = max(a, b) + reach[lane];
            }
            nearest[lane] = Framing::no_nearer(min(-a[2][lane], -b[2][lane]) - radius[lane]);
        }
        let bounds = Bounds::new(window, is_small, nearest, [low, high]);
        // The rectangle around a small one.
        let (mut middle, mut half, mut run) = ([[0.0; LANES]; 2], [0.0; LANES], [[0.0; LANES]; 2]);
        for lane in 0..LANES {
            let between = [at_b[0][lane] - at_a[0][lane], at_b[1][lane] - at_a[1][lane]];
            let length = (between[0] * between[0] + between[1] * between[1]).sqrt();
            let over = if length > 1e-3 { 1.0 / length } else { 0.0 };
            run[0][lane] = if length > 1e-3 { between[0] * over } else { 1.0 };
            run[1][lane] = between[1] * over;
            half[lane] = length * 0.5 + reach[lane];
            for axis in 0..2 {
                middle[axis][lane] = (at_a[axis][lane] + at_b[axis][lane]) * 0.5;
            }
        }
        let mut asked = bounds.asked(members.len());
        while asked != 0 {
            let lane = asked.trailing_zeros() as usize % LANES;
            asked &= asked - 1;
            let instance = &placed.block.cylinders[members[lane] as usize];
            let (index, colors) = (placed.first_cylinder + members[lane], placed.stick_colors(first + lane));
            if bounds.is_small[lane] == 0 {
                if let Some(cylinder) = Cylinder::new(instance, &placed.view_from_block)
                    && let Some(candidate) = framing.cylinder(index, &cylinder)
                    && !tile.hides(place, candidate.nearest, candidate.pixels)
                {
                    tile.draw_cylinder::<PARALLEL>(place, &candidate, (&cylinder, colors));
                }
                continue;
            }
            if !(half_length[lane] > 0.0 && radius[lane] > 0.0) {
                continue; // nothing to see
            }
            let pixels = bounds.of(lane);
            let nearest = bounds.nearest[lane];
            let ([x, y], half, [along_x, along_y]) =
                ([middle[0][lane], middle[1][lane]], [half[lane], reach[lane]], [run[0][lane], run[1][lane]]);
            let is_few = (pixels[2] - pixels[0]) * (pixels[3] - pixels[1]) <= FEW;
            if window.is_simple && is_few && (are_flat || instance.caps == FLAT_CAPS) {
                let ([cx, cy, cz], [ax, ay, az]) = (
                    [center[0][lane], center[1][lane], center[2][lane]],
                    [along[0][lane], along[1][lane], along[2][lane]],
                );
                let [first, second] = colors.map(|color| f32::from_bits(bytemuck::cast(color)));
                let (half_length, radius) = (half_length[lane], radius[lane]);
                let numbers = [
                    x,
                    y,
                    half[0],
                    half[1],
                    along_x,
                    along_y,
                    cx,
                    cy,
                    cz,
                    ax,
                    ay,
                    az,
                    half_length,
                    radius,
                    first,
                    second,
                ];
                queues.sticks.add::<PARALLEL>((tile, place), pixels, (nearest, index), &numbers);
                continue;
            }
            let rect = PlaneRect { center: Vec2::new(x, y), half: half.into(), along: Vec2::new(along_x, along_y) };
            let pixels = place.in_the_region(pixels);
            if !tile.hides(place, nearest, pixels)
                && let Some(cylinder) = Cylinder::new(instance, &placed.view_from_block)
            {
                let candidate = Candidate { index, nearest, pixels, rect, is_round: false };
                tile.draw_cylinder::<PARALLEL>(place, &candidate, (&cylinder, colors));
            }
        }
    }
}

#[cfg(test)]
#[path = "small_tests.rs"]
mod tests;
