//! Which primitives may be seen in which tile: exact bounds, and in each tile front to back.

use crate::render::bounds::{
    BoundsCamera, PlaneRect, TORUS_PIECES, cone_rect, cylinder_rect, sphere_rect, torus_rect, triangle_rect,
};
use crate::render::outline::Outline;
use crate::render::settings::View;
use crate::render::solids::{Primitive, Solids};
use crate::scene::Region;
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
    rect: PlaneRect,
}

impl Candidate {
    /// The columns of the full picture, in pixels, that its rectangle has in the rows `top..bottom`: a superset, `left > right`
    /// where there are none.
    #[inline(always)]
    pub(super) fn span(&self, top: f32, bottom: f32) -> [f32; 2] {
        let PlaneRect { center, half, along } = self.rect;
        let (low, high) = (top - center.y, bottom - center.y);
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

/// For each tile, row by row, its candidates.
pub(super) struct Bins {
    /// Pixels on a side of a tile.
    pub(super) tile: u32,
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
        let region = view.region();
        let tiles = [region.width.div_ceil(tile), region.height.div_ceil(tile)];
        let grid = view.pixel_grid();
        let camera = BoundsCamera { orthographic: grid.orthographic, near: view.camera.near };
        let to_pixels = |rect: PlaneRect| {
            let px = 1.0 / grid.plane_per_px;
            // The picture's y runs down.
            let center = Vec2::from(grid.center_px) + Vec2::new(rect.center.x, -rect.center.y) * px;
            PlaneRect { center, half: rect.half * px, along: Vec2::new(rect.along.x, -rect.along.y) }
        };
        let candidate = |i: usize, nearest: f32, rect: PlaneRect| {
            // Rounding of a depth of this size.
            let nearest = nearest - 1e-5 * nearest.abs();
            let rect = to_pixels(rect);
            let (low, high) = rect.upright();
            // A sample is somewhere in its pixel, hence floor and ceil.
            let pixels = clip([low.x, low.y, high.x, high.y], region)?;
            Some(Candidate { index: u32::try_from(i).ok()?, nearest, pixels, rect })
        };
        let nearest_point = |points: &[(Vec3, f32)]| {
            points.iter().fold(f32::INFINITY, |least, (center, radius)| least.min(-center.z - radius))
        };
        let of = |i: usize| match solids.primitive(i) {
            Primitive::Sphere(s) => {
                let sphere = outline.map_or(solids.spheres[s], |outline| outline.sphere(&solids.spheres[s]));
                let rect = sphere_rect(sphere.center, sphere.radius, &camera)?;
                candidate(i, -sphere.center.z - sphere.radius, rect)
            }
            Primitive::Cylinder(c) => {
                let cylinder = solids.cylinders[c];
                let cylinder = outline.map_or(cylinder, |outline| outline.cylinder(&cylinder));
                let [a, b] = cylinder.ends();
                let nearest = (-a.z).min(-b.z) - cylinder.radius;
                candidate(i, nearest, cylinder_rect(a, b, cylinder.radius, cylinder.round(), &camera)?)
            }
            Primitive::Cone(c) => {
                let cone = outline.map_or(solids.cones[c], |outline| outline.cone(&solids.cones[c]));
                let ([a, b], [radius_a, radius_b]) = (cone.ends(), cone.radii);
                let nearest = nearest_point(&[(a, radius_a), (b, radius_b)]);
                candidate(i, nearest, upright(cone_rect(&cone, &camera)?.upright()))
            }
            Primitive::Torus(_) => None, // in pieces, below
            Primitive::Triangle(t) => {
                let triangle = &solids.triangles[t];
                let nearest = nearest_point(&triangle.points().map(|p| (p, 0.0)));
                candidate(i, nearest, upright(triangle_rect(triangle, &camera)?.upright()))
            }
        };
        let mut candidates: Vec<Candidate> =
            (0..solids.len()).into_par_iter().with_min_len(4096).filter_map(of).collect();
        let first_torus = solids.spheres.len() + solids.cylinders.len() + solids.cones.len();
        // A tile may get a torus twice, by two pieces: it is drawn in both, which changes nothing.
        candidates.extend(solids.tori.iter().enumerate().flat_map(|(t, torus)| {
            let torus = outline.map_or(*torus, |outline| outline.torus(torus));
            let nearest = -torus.bounds().max.z;
            let pieces = (0..TORUS_PIECES).filter_map(|piece| torus_rect(&torus, piece, &camera));
            pieces.filter_map(|rect| candidate(first_torus + t, nearest, rect)).collect::<Vec<_>>()
        }));
        let mut bins = Bins { tile, tiles, candidates, first: Vec::new(), list: Vec::new() };
        bins.fill();
        bins
    }

    /// A counting sort into tiles.
    fn fill(&mut self) {
        let mut first = vec![0u32; (self.tiles[0] * self.tiles[1]) as usize + 1];
        for candidate in &self.candidates {
            self.tiles_of(candidate, |tile| first[tile + 1] += 1);
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut list = vec![0u32; first.last().map_or(0, |&n| n as usize)];
        for (i, candidate) in self.candidates.iter().enumerate() {
            self.tiles_of(candidate, |tile| {
                list[next[tile] as usize] = i as u32;
                next[tile] += 1;
            });
        }
        (self.first, self.list) = (first, list);
    }

    /// The tiles that a candidate's rectangle meets.
    fn tiles_of(&self, candidate: &Candidate, mut tile: impl FnMut(usize)) {
        let [left, top, right, bottom] = candidate.pixels.map(u32::from);
        for y in top / self.tile..=(bottom - 1) / self.tile {
            for x in left / self.tile..=(right - 1) / self.tile {
                tile((y * self.tiles[0] + x) as usize);
            }
        }
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

/// The rectangle between two corners.
fn upright((low, high): (Vec2, Vec2)) -> PlaneRect {
    PlaneRect { center: (low + high) * 0.5, half: (high - low) * 0.5, along: Vec2::X }
}

/// Pixel bounds of the full picture as pixels of the region; `None` if they do not meet. NaN meets everything.
fn clip([left, top, right, bottom]: [f32; 4], region: Region) -> Option<[u16; 4]> {
    let (width, height) = (region.width.min(65_535), region.height.min(65_535));
    // A hundredth of a pixel covers the rounding of the way here.
    let low =
        |x: f32, origin: u32, size: u32| (f64::from(x) - 0.01 - f64::from(origin)).floor().clamp(0.0, f64::from(size));
    let high =
        |x: f32, origin: u32, size: u32| (f64::from(x) + 0.01 - f64::from(origin)).ceil().clamp(0.0, f64::from(size));
    let or = |x: f64, default: u32| if x.is_nan() { default as u16 } else { x as u16 };
    let pixels = [
        or(low(left, region.x, width), 0),
        or(low(top, region.y, height), 0),
        or(high(right, region.x, width), width),
        or(high(bottom, region.y, height), height),
    ];
    (pixels[0] < pixels[2] && pixels[1] < pixels[3]).then_some(pixels)
}
