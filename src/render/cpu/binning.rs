//! Which primitives may be seen in which tile: exact pixel bounds, front to back.

use crate::render::bounds::{
    BoundsCamera, TORUS_PIECES, cone_rect, cylinder_rect, sphere_rect, torus_rect, triangle_rect,
};
use crate::render::settings::View;
use crate::render::solids::{Primitive, Solids};
use crate::scene::Region;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Pixels on a side of a tile: its depth, ids and sums stay in the first-level cache.
pub(super) const TILE: u32 = 32;

/// A primitive that reaches into the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Index into the solids.
    pub(super) index: u32,
    /// No point of it is nearer than this depth.
    pub(super) nearest: f32,
    /// Pixels of the region that it may cover: left, top, right, bottom, the last two exclusive.
    pub(super) pixels: [u16; 4],
}

/// For each tile, row by row, its candidates from front to back.
pub(super) struct Bins {
    /// Tiles in x and y.
    pub(super) tiles: [u32; 2],
    /// All that reach into the picture, front to back.
    pub(super) candidates: Vec<Candidate>,
    first: Vec<u32>,
    list: Vec<u32>,
}

impl Bins {
    /// Finds the candidates of a view. Regions are at most 65,535 pixels on a side.
    pub(super) fn new(solids: &Solids, view: &View) -> Bins {
        let region = view.region();
        let tiles = [region.width.div_ceil(TILE), region.height.div_ceil(TILE)];
        let grid = view.pixel_grid();
        let camera = BoundsCamera { orthographic: grid.orthographic, near: view.camera.near };
        let to_pixels = |(low, high): (Vec2, Vec2)| {
            let px = |plane: f32| plane / grid.plane_per_px;
            let center = Vec2::from(grid.center_px);
            // The picture's y runs down. A sample is somewhere in its pixel, hence floor and ceil.
            let (left, right) = (center.x + px(low.x), center.x + px(high.x));
            let (top, bottom) = (center.y - px(high.y), center.y - px(low.y));
            clip([left, top, right, bottom], region)
        };
        let candidate = |i: usize, nearest: f32, (low, high): (Vec2, Vec2)| {
            // Rounding of a depth of this size.
            let nearest = nearest - 1e-5 * nearest.abs();
            Some(Candidate { index: u32::try_from(i).ok()?, nearest, pixels: to_pixels((low, high))? })
        };
        let nearest_point = |points: &[(Vec3, f32)]| {
            points.iter().fold(f32::INFINITY, |least, (center, radius)| least.min(-center.z - radius))
        };
        let of = |i: usize| match solids.primitive(i) {
            Primitive::Sphere(s) => {
                let sphere = &solids.spheres[s];
                let rect = sphere_rect(sphere.center, sphere.radius, &camera)?;
                candidate(i, -sphere.center.z - sphere.radius, rect.upright())
            }
            Primitive::Cylinder(c) => {
                let cylinder = &solids.cylinders[c];
                let [a, b] = cylinder.ends();
                let nearest = (-a.z).min(-b.z) - cylinder.radius;
                candidate(i, nearest, cylinder_rect(a, b, cylinder.radius, cylinder.round(), &camera)?.upright())
            }
            Primitive::Cone(c) => {
                let cone = &solids.cones[c];
                let ([a, b], [radius_a, radius_b]) = (cone.ends(), cone.radii);
                let nearest = nearest_point(&[(a, radius_a), (b, radius_b)]);
                candidate(i, nearest, cone_rect(cone, &camera)?.upright())
            }
            Primitive::Torus(_) => None, // in pieces, below
            Primitive::Triangle(t) => {
                let triangle = &solids.triangles[t];
                let nearest = nearest_point(&triangle.points().map(|p| (p, 0.0)));
                candidate(i, nearest, triangle_rect(triangle, &camera)?.upright())
            }
        };
        let mut candidates: Vec<Candidate> =
            (0..solids.len()).into_par_iter().with_min_len(4096).filter_map(of).collect();
        let first_torus = solids.spheres.len() + solids.cylinders.len() + solids.cones.len();
        // A tile may get a torus twice, by two pieces: it is drawn in both, which changes nothing.
        candidates.extend(solids.tori.iter().enumerate().flat_map(|(t, torus)| {
            let nearest = -torus.bounds().max.z;
            let pieces = (0..TORUS_PIECES).filter_map(|piece| torus_rect(torus, piece, &camera));
            pieces.filter_map(|rect| candidate(first_torus + t, nearest, rect.upright())).collect::<Vec<_>>()
        }));
        candidates.par_sort_unstable_by(|a, b| a.nearest.total_cmp(&b.nearest).then(a.index.cmp(&b.index)));
        let mut bins = Bins { tiles, candidates, first: Vec::new(), list: Vec::new() };
        bins.fill();
        bins
    }

    /// A counting sort into tiles; the order of the candidates stays.
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

    fn tiles_of(&self, candidate: &Candidate, mut tile: impl FnMut(usize)) {
        let [left, top, right, bottom] = candidate.pixels.map(u32::from);
        for y in top / TILE..=(bottom - 1) / TILE {
            for x in left / TILE..=(right - 1) / TILE {
                tile((y * self.tiles[0] + x) as usize);
            }
        }
    }

    /// The candidates of a tile, front to back.
    pub(super) fn of_tile(&self, tile: usize) -> impl Iterator<Item = &Candidate> {
        let range = self.first[tile] as usize..self.first[tile + 1] as usize;
        self.list[range].iter().map(|&i| &self.candidates[i as usize])
    }
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
