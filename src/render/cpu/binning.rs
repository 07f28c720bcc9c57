//! Which primitives may be seen in which tile: exact bounds, and in each tile front to back.

use super::behind::Mask;
use super::lanes::{LANES, Lanes};
use crate::math::max;
use crate::render::bounds::{
    BoundsCamera, PlaneRect, TORUS_PIECES, cone_rect, cylinder_rect, sphere_rect, torus_rect, triangle_rect,
};
use crate::render::outline::Outline;
use crate::render::settings::View;
use crate::render::solids::{Cylinder, Primitive, Solids, Sphere, Torus};
use crate::scene::{PixelGrid, Region};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// A primitive that reaches into the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Index into the solids.
    pub(super) index: u32,
    /// No point of it is nearer than this depth.
    pub(super) nearest: f32,
    /// Pixels of the region that it may cover: left, top, right, bottom, the last two exclusive.
    pub(super) pixels: [u16; 4],
    /// The turned rectangle that it covers, in pixels of the full picture, y down.
    pub(super) rect: PlaneRect,
    /// Whether it is all in the circle in the rectangle, a square.
    pub(super) is_round: bool,
}

impl Candidate {
    /// The columns of the full picture, in pixels, that its rectangle has in the rows `top..bottom`: a superset, `left > right`
    /// where there are none.
    #[inline(always)]
    pub(super) fn span(&self, top: f32, bottom: f32) -> [f32; 2] {
        let PlaneRect { center, half, along } = self.rect;
        let (low, high) = (top - center.y, bottom - center.y);
        if self.is_round {
            let off = max(max(low, -high), 0.0);
            let reach = max(half.x * half.x - off * off, 0.0).sqrt() + 0.01;
            return [center.x - reach, center.x + reach];
        }
        let mut span = [f32::NEG_INFINITY, f32::INFINITY];
        // |along · p| ≤ half.x and |across · p| ≤ half.y, each an interval of x for these y.
        for (x, y, half) in [(along.x, along.y, half.x), (-along.y, along.x, half.y)] {
            let (a, b) = (y * low, y * high);
            let (least, most) = if a < b { (a, b) } else { (b, a) };
            if x.abs() > 1e-4 {
                let (p, q) = ((-half - most) / x, (half - least) / x);
                let (from, to) = if p < q { (p, q) } else { (q, p) };
                span = [if from > span[0] { from } else { span[0] }, if to < span[1] { to } else { span[1] }];
            }
        }
        // A hundredth of a pixel covers the rounding of the way here.
        [span[0] + center.x - 0.01, span[1] + center.x + 0.01]
    }
}

/// How primitives in view space lie in a picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Framing {
    camera: BoundsCamera,
    grid: PixelGrid,
    region: Region,
    /// Pixels that a small thing's radius covers, at depth 1 in perspective, at most.
    px_of_radius: f32,
}

/// Of a thing whose radius is no greater a part of its depth the size in the picture is that at its middle, within [`SMALL_SLACK`].
const SMALL: f32 = 0.01;
/// The nearer side of such a thing is larger by 1 in 99 than its middle, and it is seen up to `SMALL` radians farther from the axis.
/// The rest is for the rounding.
const SMALL_SLACK: f32 = 1.03;

impl Framing {
    pub(super) fn new(view: &View) -> Framing {
        let grid = view.pixel_grid();
        let camera = BoundsCamera { orthographic: grid.orthographic, near: view.camera.near };
        let region = view.region();
        // The slope of the farthest corner: there a ball is seen as an ellipse.
        let corner = |low: u32, size: u32, center: f32| (low as f32 - center).abs().max((low + size) as f32 - center);
        let x = corner(region.x, region.width, grid.center_px[0]) * grid.plane_per_px;
        let y = corner(region.y, region.height, grid.center_px[1]) * grid.plane_per_px;
        let stretch = if grid.orthographic { 1.0 } else { (1.0 + x * x + y * y).sqrt() * SMALL_SLACK };
        Framing { camera, grid, region, px_of_radius: stretch / grid.plane_per_px }
    }

    /// Where small things lie that fit in balls of view space: their middles and radii in pixels of the full picture, the latter
    /// somewhat greater, and whether they are small and away from the near plane.
    #[inline(always)]
    pub(super) fn small_ones(&self, center: &[Lanes; 3], radius: &Lanes) -> ([Lanes; 2], Lanes, Mask) {
        let (mut at, mut reach, mut is_small) = ([[0.0; LANES]; 2], [0.0; LANES], [0; LANES]);
        let per_plane = 1.0 / self.grid.plane_per_px;
        for lane in 0..LANES {
            let depth = -center[2][lane];
            let over = if self.camera.orthographic { 1.0 } else { 1.0 / depth };
            at[0][lane] = self.grid.center_px[0] + center[0][lane] * over * per_plane;
            at[1][lane] = self.grid.center_px[1] - center[1][lane] * over * per_plane;
            reach[lane] = radius[lane] * over * self.px_of_radius;
            let small = (depth - radius[lane] > 1.01 * self.camera.near) & (radius[lane] <= SMALL * depth);
            is_small[lane] = if small { u32::MAX } else { 0 };
        }
        (at, reach, is_small)
    }

    /// A depth that rounding makes no nearer.
    #[inline(always)]
    pub(super) fn no_nearer(depth: f32) -> f32 {
        depth - 1e-5 * depth.abs()
    }

    /// What covers a rectangle of the plane, and is nowhere nearer than `nearest`; `None` if it is not in the picture.
    #[inline(always)]
    fn candidate(&self, index: u32, nearest: f32, rect: PlaneRect) -> Option<Candidate> {
        let px = 1.0 / self.grid.plane_per_px;
        // The picture's y runs down.
        let center = Vec2::from(self.grid.center_px) + Vec2::new(rect.center.x, -rect.center.y) * px;
        let rect = PlaneRect { center, half: rect.half * px, along: Vec2::new(rect.along.x, -rect.along.y) };
        let (low, high) = rect.upright();
        // A sample is somewhere in its pixel, hence whole pixels.
        let pixels = clip([low.x, low.y, high.x, high.y], self.region)?;
        Some(Candidate { index, nearest: Framing::no_nearer(nearest), pixels, rect, is_round: false })
    }

    /// A ball.
    #[inline(always)]
    pub(super) fn sphere(&self, index: u32, sphere: &Sphere) -> Option<Candidate> {
        let rect = sphere_rect(sphere.center, sphere.radius, &self.camera)?;
        self.candidate(index, -sphere.center.z - sphere.radius, rect)
    }

    /// A stick.
    #[inline(always)]
    pub(super) fn cylinder(&self, index: u32, cylinder: &Cylinder) -> Option<Candidate> {
        let [a, b] = cylinder.ends();
        let nearest = (-a.z).min(-b.z) - cylinder.radius;
        self.candidate(index, nearest, cylinder_rect(a, b, cylinder.radius, cylinder.round(), &self.camera)?)
    }

    /// Everything in a box whose sides are along the axes of view space, as [`Framing::candidate`] says it.
    #[inline(always)]
    pub(super) fn boxed(&self, center: Vec3, half: Vec3) -> Option<(f32, [u16; 4])> {
        let (depth, near) = (-center.z, self.camera.near);
        if depth + half.z < near {
            return None;
        }
        let nearest = depth - half.z;
        // Farthest out are the points of the front, or of the back where a side is beyond the middle.
        let (front, back) = (1.0 / max(nearest, near), 1.0 / (depth + half.z));
        let slope = |x: f32, is_high: bool| match (self.camera.orthographic, (x > 0.0) == is_high) {
            (true, _) => x,
            (false, true) => x * front,
            (false, false) => x * back,
        };
        let (low, high) = (center - half, center + half);
        let (x, y) = ([slope(low.x, false), slope(high.x, true)], [slope(low.y, false), slope(high.y, true)]);
        let rect = PlaneRect {
            center: Vec2::new(x[0] + x[1], y[0] + y[1]) * 0.5,
            half: Vec2::new(x[1] - x[0], y[1] - y[0]) * 0.5,
            along: Vec2::X,
        };
        let candidate = self.candidate(0, nearest, rect)?;
        Some((candidate.nearest, candidate.pixels))
    }

    /// Primitive `index`, with its line where there are lines; none for tori, which are bounded in pieces.
    pub(super) fn primitive(&self, solids: &Solids, index: usize, outline: Option<&Outline>) -> Option<Candidate> {
        let nearest_point = |points: &[(Vec3, f32)]| {
            points.iter().fold(f32::INFINITY, |least, (center, radius)| least.min(-center.z - radius))
        };
        let number = u32::try_from(index).ok()?;
        match solids.primitive(index) {
            Primitive::Sphere(s) => {
                let sphere = solids.spheres[s];
                self.sphere(number, &outline.map_or(sphere, |outline| outline.sphere(&sphere)))
            }
            Primitive::Cylinder(c) => {
                let cylinder = solids.cylinders[c];
                self.cylinder(number, &outline.map_or(cylinder, |outline| outline.cylinder(&cylinder)))
            }
            Primitive::Cone(c) => {
                let cone = outline.map_or(solids.cones[c], |outline| outline.cone(&solids.cones[c]));
                let ([a, b], [radius_a, radius_b]) = (cone.ends(), cone.radii);
                let nearest = nearest_point(&[(a, radius_a), (b, radius_b)]);
                self.candidate(number, nearest, upright(cone_rect(&cone, &self.camera)?.upright()))
            }
            Primitive::Torus(_) => None,
            Primitive::Triangle(t) => {
                let triangle = &solids.triangles[t];
                let nearest = nearest_point(&triangle.points().map(|p| (p, 0.0)));
                self.candidate(number, nearest, upright(triangle_rect(triangle, &self.camera)?.upright()))
            }
        }
    }

    /// The pieces of a ring.
    #[inline(always)]
    pub(super) fn torus(&self, index: u32, torus: Torus) -> impl Iterator<Item = Candidate> {
        let (framing, nearest) = (*self, -torus.bounds().max.z);
        let pieces = (0..TORUS_PIECES).filter_map(move |piece| torus_rect(&torus, piece, &framing.camera));
        pieces.filter_map(move |rect| framing.candidate(index, nearest, rect))
    }
}

/// For each tile, row by row, its candidates.
pub(super) struct Bins {
    /// Tiles in x and y.
    pub(super) tiles: [u32; 2],
    /// All that reach into the picture.
    candidates: Vec<Candidate>,
    first: Vec<u32>,
    list: Vec<u32>,
}

impl Bins {
    /// Finds the candidates of a view for tiles of so many pixels. Regions are at most 65,535 pixels on a side.
    pub(super) fn new(solids: &Solids, outline: Option<&Outline>, view: &View, tile: u32) -> Bins {
        let framing = Framing::new(view);
        let region = view.region();
        let tiles = [region.width.div_ceil(tile), region.height.div_ceil(tile)];
        let of = |i: usize| framing.primitive(solids, i, outline);
        let mut candidates: Vec<Candidate> =
            (0..solids.len()).into_par_iter().with_min_len(4096).filter_map(of).collect();
        let first_torus = solids.spheres.len() + solids.cylinders.len() + solids.cones.len();
        // A tile may get a torus twice, by two pieces: it is drawn in both, which changes nothing.
        candidates.extend((first_torus as u32..).zip(&solids.tori).flat_map(|(index, torus)| {
            let torus = outline.map_or(*torus, |outline| outline.torus(torus));
            framing.torus(index, torus)
        }));
        let (first, list) = share_out(tile, tiles, candidates.iter().map(|candidate| candidate.pixels));
        Bins { tiles, candidates, first, list }
    }

    /// Whether nothing reaches into a tile.
    pub(super) fn is_empty(&self, tile: usize) -> bool {
        self.first[tile] == self.first[tile + 1]
    }

    /// The candidates of a tile, front to back, of equals the first primitive first.
    pub(super) fn of_tile(&self, tile: usize, sorted: &mut Vec<Candidate>) {
        let range = self.first[tile] as usize..self.first[tile + 1] as usize;
        sorted.clear();
        sorted.extend(self.list[range].iter().map(|&i| self.candidates[i as usize]));
        sorted.sort_unstable_by(|a, b| a.nearest.total_cmp(&b.nearest).then(a.index.cmp(&b.index)));
    }
}

/// Which rectangles of pixels meet each tile, in their order: where each tile's start in the list of their numbers.
pub(super) fn share_out(
    tile: u32,
    tiles: [u32; 2],
    rects: impl Iterator<Item = [u16; 4]> + Clone,
) -> (Vec<u32>, Vec<u32>) {
    let met = |rect: [u16; 4]| {
        let [left, top, right, bottom] = rect.map(u32::from);
        let columns = left / tile..=(right - 1) / tile;
        let rows = top / tile..=(bottom - 1) / tile;
        rows.flat_map(move |y| columns.clone().map(move |x| (y * tiles[0] + x) as usize))
    };
    let mut first = vec![0u32; (tiles[0] * tiles[1]) as usize + 1];
    for rect in rects.clone() {
        met(rect).for_each(|tile| first[tile + 1] += 1);
    }
    for i in 1..first.len() {
        first[i] += first[i - 1];
    }
    let mut next = first.clone();
    let mut list = vec![0u32; first.last().map_or(0, |&n| n as usize)];
    for (number, rect) in (0..).zip(rects) {
        met(rect).for_each(|tile| {
            list[next[tile] as usize] = number;
            next[tile] += 1;
        });
    }
    (first, list)
}

/// The rectangle between two corners.
fn upright((low, high): (Vec2, Vec2)) -> PlaneRect {
    PlaneRect { center: (low + high) * 0.5, half: (high - low) * 0.5, along: Vec2::X }
}

/// Pixel bounds of the full picture as pixels of the region; `None` if they do not meet. NaN meets everything.
#[inline(always)]
fn clip([left, top, right, bottom]: [f32; 4], region: Region) -> Option<[u16; 4]> {
    let (width, height) = (region.width.min(65_535), region.height.min(65_535));
    // A fiftieth of a pixel covers the rounding of the way here, in pictures of 32,768 pixels as well. Casts cut to whole
    // numbers, clamp at 0, and make 0 of NaN.
    let low = |x: f32, origin: u32, size: u32| ((x - origin as f32 - 0.02) as u32).min(size);
    let high = |x: f32, origin: u32, size: u32| {
        let past = x - origin as f32 + 0.02;
        if past <= 0.0 {
            0
        } else if past < size as f32 {
            (past as u32 + 1).min(size)
        } else {
            size
        }
    };
    let pixels = [
        low(left, region.x, width) as u16,
        low(top, region.y, height) as u16,
        high(right, region.x, width) as u16,
        high(bottom, region.y, height) as u16,
    ];
    (pixels[0] < pixels[2] && pixels[1] < pixels[3]).then_some(pixels)
}
