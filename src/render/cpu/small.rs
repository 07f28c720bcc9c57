//! Small balls and sticks of a pack, sixteen at a time: where they lie in a tile, and those of few pixels pixel by pixel.
//!
//! What covers no sample of the tile is found out before anything else is: in pictures of large structures that is most. What
//! covers a few is not worth whole blocks of samples ([`super::tile`]): the samples that it may cover are listed, those behind
//! something are left out, and the depths of the rest found together.

use super::behind::Mask;
use super::binning::{Candidate, Framing};
use super::intersect::FLAT_CAPS;
use super::lanes::{LANES, Lanes};
use super::packs::Placed;
use super::tile::{Beyond, DepthAt, Drawn, Flat, Place, SIDE, Tile};
use crate::math::{max, min, whole};
use crate::render::bounds::PlaneRect;
use crate::render::solids::{Cylinder, Sphere};
use crate::scene::CylinderInstance;
use glam::{Affine3A, Vec2, Vec3};

/// Pixels of the rectangle around a thing that is drawn pixel by pixel, at most. Chosen, other numbers were not tried.
const FEW: u32 = 24;

/// Pixels by which bounds are wider, for the rounding of the way here.
const SLACK: f32 = 0.02;

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

    /// The pixels of one of them, from the tile's corner: left, top, right, bottom; `None` if there are none.
    #[inline(always)]
    fn of(&self, lane: usize) -> Option<[u32; 4]> {
        let [[left, right], [top, bottom]] = self.pixels.map(|axis| axis.map(|lanes| lanes[lane]));
        (left < right && top < bottom).then_some([left, top, right, bottom])
    }
}

/// Sixteen points moved by a transform: the same bits as [`Affine3A::transform_point3`] gives.
#[inline(always)]
fn transform(by: &Affine3A, points: [&Lanes; 3]) -> [Lanes; 3] {
    let [x, y, z] = [by.matrix3.x_axis, by.matrix3.y_axis, by.matrix3.z_axis];
    std::array::from_fn(|axis| {
        let (x, y, z, shift) = (x[axis], y[axis], z[axis], by.translation[axis]);
        let mut moved = [0.0; LANES];
        for lane in 0..LANES {
            moved[lane] = points[0][lane] * x + points[1][lane] * y + points[2][lane] * z + shift;
        }
        moved
    })
}

/// The samples that something small may cover.
struct Few {
    count: usize,
    u: Lanes,
    v: Lanes,
    /// Where they stand in the tile's samples.
    at: [usize; LANES],
}

/// Something small.
trait Small {
    type Solid: DepthAt;

    /// Whether it may cover a point of the full picture.
    fn covers(&self, x: f32, y: f32) -> bool;

    /// What has depths, if it has any.
    fn solid(&self) -> Option<Self::Solid>;
}

/// Draws something small of few pixels in a tile with one sample a pixel.
#[inline(always)]
fn draw_few(
    tile: &mut Tile,
    place: &Place<'_>,
    [left, top, right, bottom]: [u32; 4],
    (nearest, index): (f32, u32),
    thing: &impl Small,
) {
    let mut few = Few { count: 0, u: [0.0; LANES], v: [0.0; LANES], at: [0; LANES] };
    let pass = place.pass;
    for y in top..bottom {
        let (row, lane_y) = (y / 4, y % 4 * 4);
        let y = (place.corner[1] + row * 4) as f32 + pass.y[lane_y as usize];
        for x in left..right {
            let (column, lane) = (x / 4, (lane_y + x % 4) as usize);
            let x = (place.corner[0] + column * 4) as f32 + pass.x[lane];
            let at = (row as usize * SIDE + column as usize) * LANES + lane;
            if !thing.covers(x, y) || nearest > tile.t.as_flattened().as_flattened()[at] {
                continue;
            }
            few.at[few.count] = at;
            few.u[few.count] = (x - place.grid.center_px[0]) * place.grid.plane_per_px;
            few.v[few.count] = (place.grid.center_px[1] - y) * place.grid.plane_per_px;
            few.count += 1;
            if few.count == LANES {
                few.draw(tile, index, thing);
                few.count = 0;
            }
        }
    }
    if few.count > 0 {
        few.draw(tile, index, thing);
    }
}

impl Few {
    #[inline(always)]
    fn draw(&self, tile: &mut Tile, index: u32, thing: &impl Small) {
        let Some(solid) = thing.solid() else { return };
        let mut depth = [0.0f32; LANES];
        for (lane, depth) in depth.iter_mut().enumerate() {
            *depth = solid.t(self.u[lane], self.v[lane]);
        }
        for (&at, &t) in self.at.iter().zip(&depth).take(self.count) {
            tile.see_at(at, t, index);
        }
    }
}

/// A ball beyond the near plane.
struct SmallBall<const PARALLEL: bool> {
    solid: Drawn<Beyond, PARALLEL>,
    center: [f32; 2],
    /// Squared, pixels.
    reach: f32,
}

impl<const PARALLEL: bool> Small for SmallBall<PARALLEL> {
    type Solid = Drawn<Beyond, PARALLEL>;

    #[inline(always)]
    fn covers(&self, x: f32, y: f32) -> bool {
        let (x, y) = (x - self.center[0], y - self.center[1]);
        x * x + y * y <= self.reach
    }

    #[inline(always)]
    fn solid(&self) -> Option<Drawn<Beyond, PARALLEL>> {
        Some(self.solid)
    }
}

/// A stick with flat caps.
struct SmallStick<'a, const PARALLEL: bool> {
    instance: &'a CylinderInstance,
    view_from_block: &'a Affine3A,
    rect: PlaneRect,
    near: f32,
}

impl<const PARALLEL: bool> Small for SmallStick<'_, PARALLEL> {
    type Solid = Drawn<Flat, PARALLEL>;

    #[inline(always)]
    fn covers(&self, x: f32, y: f32) -> bool {
        let PlaneRect { center, half, along } = self.rect;
        let (x, y) = (x - center.x, y - center.y);
        let (run, aside) = (x * along.x + y * along.y, x * along.y - y * along.x);
        run.abs() <= half.x + SLACK && aside.abs() <= half.y + SLACK
    }

    #[inline(always)]
    fn solid(&self) -> Option<Drawn<Flat, PARALLEL>> {
        let cylinder = Cylinder::new(self.instance, self.view_from_block)?;
        Some(Drawn { solid: Flat(cylinder), near: self.near })
    }
}

/// Draws some balls of a block in a tile: their numbers in the block, and where the first of them stands in the packs.
#[inline(always)]
pub(super) fn draw_balls<const PARALLEL: bool>(
    (tile, place): (&mut Tile, &Place<'_>),
    (window, framing): (&Window, &Framing),
    placed: &Placed<'_>,
    (first, members): (usize, &[u32]),
) {
    for (members, first) in members.chunks(LANES).zip((first..).step_by(LANES)) {
        let [x, y, z, radius] = placed.balls(first);
        let center = transform(&placed.view_from_block, [x, y, z]);
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
        for (lane, &i) in members.iter().enumerate() {
            let center_of = Vec3::new(center[0][lane], center[1][lane], center[2][lane]);
            let sphere = Sphere { center: center_of, radius: radius[lane] };
            let index = placed.first_sphere + i;
            if bounds.is_small[lane] == 0 {
                if let Some(candidate) = framing.sphere(index, &sphere)
                    && !tile.hides(place, candidate.nearest, candidate.pixels)
                {
                    tile.draw_sphere::<PARALLEL>(place, &candidate, &sphere);
                }
                continue;
            }
            let Some(pixels) = bounds.of(lane) else { continue };
            let (center, reach, nearest) = ([at[0][lane], at[1][lane]], reach[lane], bounds.nearest[lane]);
            if window.is_simple && (pixels[2] - pixels[0]) * (pixels[3] - pixels[1]) <= FEW {
                let solid = Drawn { solid: Beyond(sphere), near: place.near };
                let ball = SmallBall::<PARALLEL> { solid, center, reach: (reach + SLACK) * (reach + SLACK) };
                draw_few(tile, place, pixels, (nearest, index), &ball);
                continue;
            }
            let rect = PlaneRect { center: center.into(), half: Vec2::splat(reach), along: Vec2::X };
            let pixels = place.in_the_region(pixels);
            if !tile.hides(place, nearest, pixels) {
                let candidate = Candidate { index, nearest, pixels, rect, is_round: true };
                tile.draw_sphere::<PARALLEL>(place, &candidate, &sphere);
            }
        }
    }
}

/// Draws some sticks of a block in a tile; see [`draw_balls`].
#[inline(always)]
pub(super) fn draw_sticks<const PARALLEL: bool>(
    (tile, place): (&mut Tile, &Place<'_>),
    (window, framing): (&Window, &Framing),
    placed: &Placed<'_>,
    (first, members): (usize, &[u32]),
) {
    for (members, first) in members.chunks(LANES).zip((first..).step_by(LANES)) {
        let (ends, radius) = placed.sticks(first);
        let [a, b] = ends.map(|end| transform(&placed.view_from_block, end));
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
        for (lane, &i) in members.iter().enumerate() {
            let instance = &placed.block.cylinders[i as usize];
            let index = placed.first_cylinder + i;
            if bounds.is_small[lane] == 0 {
                if let Some(cylinder) = Cylinder::new(instance, &placed.view_from_block)
                    && let Some(candidate) = framing.cylinder(index, &cylinder)
                    && !tile.hides(place, candidate.nearest, candidate.pixels)
                {
                    tile.draw_cylinder::<PARALLEL>(place, &candidate, &cylinder);
                }
                continue;
            }
            let Some(pixels) = bounds.of(lane) else { continue };
            let (from, to) = (Vec2::new(at_a[0][lane], at_a[1][lane]), Vec2::new(at_b[0][lane], at_b[1][lane]));
            let (between, reach, nearest) = (to - from, reach[lane], bounds.nearest[lane]);
            let length = between.length();
            let along = if length > 1e-3 { between / length } else { Vec2::X };
            let rect = PlaneRect { center: (from + to) * 0.5, half: Vec2::new(length * 0.5 + reach, reach), along };
            let is_few = (pixels[2] - pixels[0]) * (pixels[3] - pixels[1]) <= FEW;
            if window.is_simple && is_few && instance.caps == FLAT_CAPS {
                let view_from_block = &placed.view_from_block;
                let stick = SmallStick::<PARALLEL> { instance, view_from_block, rect, near: place.near };
                draw_few(tile, place, pixels, (nearest, index), &stick);
                continue;
            }
            let pixels = place.in_the_region(pixels);
            if !tile.hides(place, nearest, pixels)
                && let Some(cylinder) = Cylinder::new(instance, &placed.view_from_block)
            {
                let candidate = Candidate { index, nearest, pixels, rect, is_round: false };
                tile.draw_cylinder::<PARALLEL>(place, &candidate, &cylinder);
            }
        }
    }
}

#[cfg(test)]
#[path = "small_tests.rs"]
mod tests;
