//! The reference's picture, bit for bit, tile by tile on all cores.
//!
//! For each sample of a tile the candidates are drawn front to back into a small depth buffer, eight pixels at a time
//! (plain loops over the branch-free `*_t` functions, which compile to vector code), then what is seen is shaded by
//! the same [`Shader`] as in the reference. Ties in depth go to the first primitive, as there.

use super::binning::{Bins, Candidate, TILE};
use super::intersect::{cone_t, cylinder_t, sphere_t, torus_t, triangle_t};
use super::reach::{Lights, Reaches};
use super::shader::Shader;
use super::simd::{Work, widest};
use crate::color::Srgb8;
use crate::render::field::GroundMap;
use crate::render::frame::{FrameConstants, resolve};
use crate::render::settings::sample_offset;
use crate::render::solids::{Cone, Cylinder, Primitive, Solids, Sphere, Torus, Triangle};
use crate::render::{GBuffer, Image, Settings, View};
use crate::scene::{PixelGrid, Ray, Region, Scene};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

const PIXELS: usize = (TILE * TILE) as usize;
const LANES: usize = 8;
const BLOCKS: usize = TILE as usize / LANES;

/// The depth of a primitive at plane coordinates. (A trait, not a closure: it must be inlined wherever it is used.)
trait DepthAt {
    fn t(&self, u: f32, v: f32) -> f32;
}

/// A primitive seen with parallel rays (`PARALLEL`) or in perspective.
struct Drawn<S, const PARALLEL: bool> {
    solid: S,
    near: f32,
}

#[inline(always)]
fn ray<const PARALLEL: bool>(u: f32, v: f32) -> Ray {
    if PARALLEL {
        Ray { origin: Vec3::new(u, v, 0.0), direction: Vec3::new(0.0, 0.0, -1.0) }
    } else {
        Ray { origin: Vec3::ZERO, direction: Vec3::new(u, v, -1.0) }
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Sphere, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        sphere_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Cylinder, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        cylinder_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Cone, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        cone_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Torus, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        torus_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Triangle, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        triangle_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

/// One sample of every pixel of a tile: depth and primitive of what is nearest.
struct TileDepth {
    t: [[f32; TILE as usize]; TILE as usize],
    index: [[u32; TILE as usize]; TILE as usize],
    /// The farthest depth of each block of [`LANES`] × [`LANES`] pixels, as of the last update.
    farthest: [[f32; BLOCKS]; BLOCKS],
    /// Plane coordinates of the sample in each column and row.
    u: [f32; TILE as usize],
    v: [f32; TILE as usize],
}

impl TileDepth {
    fn new() -> TileDepth {
        TileDepth {
            t: [[f32::INFINITY; TILE as usize]; TILE as usize],
            index: [[0; TILE as usize]; TILE as usize],
            farthest: [[f32::INFINITY; BLOCKS]; BLOCKS],
            u: [0.0; TILE as usize],
            v: [0.0; TILE as usize],
        }
    }

    /// Empties it and places its samples.
    fn restart(&mut self, grid: &PixelGrid, x_px: u32, y_px: u32, [dx, dy]: [f32; 2]) {
        self.t.iter_mut().for_each(|row| row.fill(f32::INFINITY));
        self.farthest = [[f32::INFINITY; BLOCKS]; BLOCKS];
        for i in 0..TILE {
            let (u, v) = grid.plane((x_px + i) as f32 + dx, (y_px + i) as f32 + dy);
            self.u[i as usize] = u;
            self.v[i as usize] = v;
        }
    }

    /// Finds the farthest depth of each block anew; infinity where a pixel is empty.
    #[inline(always)]
    fn update_farthest(&mut self) {
        for (rows, farthest) in self.t.chunks_exact(LANES).zip(&mut self.farthest) {
            let mut column = [0.0f32; TILE as usize];
            for row in rows {
                for (most, &t) in column.iter_mut().zip(row) {
                    *most = if t > *most { t } else { *most };
                }
            }
            for (block, most) in column.chunks_exact(LANES).zip(farthest) {
                *most = block.iter().fold(0.0, |most, &t| if t > most { t } else { most });
            }
        }
    }

    /// Draws one primitive into the pixels `columns × rows` (whole groups of [`LANES`] columns are touched), but not into
    /// blocks that are full of what is nearer than `nearest`.
    #[inline(always)]
    fn draw(&mut self, ((index, nearest), columns, rows): ((u32, f32), [usize; 2], [usize; 2]), drawn: impl DepthAt) {
        for band in rows[0] / LANES..rows[1].div_ceil(LANES) {
            let rows = rows[0].max(band * LANES)..rows[1].min((band + 1) * LANES);
            for group in columns[0] / LANES..columns[1].div_ceil(LANES) {
                if nearest > self.farthest[band][group] {
                    continue;
                }
                let start = group * LANES;
                for row in rows.clone() {
                    let v = self.v[row];
                    // Arrays of a fixed size, one simple loop each: the form that is turned into vector code.
                    let u: [f32; LANES] = std::array::from_fn(|lane| self.u[start + lane]);
                    let mut new = [0.0f32; LANES];
                    for lane in 0..LANES {
                        new[lane] = drawn.t(u[lane], v);
                    }
                    let t = &mut self.t[row][start..start + LANES];
                    let seen = &mut self.index[row][start..start + LANES];
                    for lane in 0..LANES {
                        let tie = (new[lane] == t[lane]) & (new[lane] < f32::INFINITY) & (index < seen[lane]);
                        let closer = (new[lane] < t[lane]) | tie;
                        t[lane] = if closer { new[lane] } else { t[lane] };
                        seen[lane] = if closer { index } else { seen[lane] };
                    }
                }
            }
        }
    }
}

/// [`Picture::see`] as work for [`widest`].
struct See<'a, 'b> {
    picture: &'a Picture<'b>,
    depth: &'a mut TileDepth,
    tile: usize,
    /// Index and number of all.
    sample: [u32; 2],
}

impl Work for See<'_, '_> {
    #[inline(always)]
    fn run(self) {
        self.picture.see_here(self.depth, self.tile, self.sample);
    }
}

/// What all tiles of a picture share.
struct Picture<'a> {
    shader: Shader<'a>,
    bins: Bins,
    grid: PixelGrid,
    region: Region,
    near: f32,
}

impl Picture<'_> {
    /// Finds what every pixel of a tile sees in one sample.
    fn see(&self, depth: &mut TileDepth, tile: usize, sample: [u32; 2]) {
        widest(See { picture: self, depth, tile, sample });
    }

    #[inline(always)]
    fn see_here(&self, depth: &mut TileDepth, tile: usize, [sample, samples]: [u32; 2]) {
        let (x, y) = self.corner(tile);
        depth.restart(&self.grid, self.region.x + x, self.region.y + y, sample_offset(sample, samples));
        for (drawn, candidate) in self.bins.of_tile(tile).enumerate() {
            // Looking for the farthest depths costs about as much as drawing a small primitive.
            if drawn % 16 == 15 {
                depth.update_farthest();
                let farthest = depth.farthest.as_flattened().iter().fold(0.0f32, |most, &t| most.max(t));
                if candidate.nearest > farthest {
                    break; // the rest is behind everything
                }
            }
            if self.shader.solids.is_drawn(candidate.index as usize, sample, samples) {
                self.draw(depth, candidate, x, y);
            }
        }
    }

    #[inline(always)]
    fn draw(&self, depth: &mut TileDepth, candidate: &Candidate, x: u32, y: u32) {
        let [left, top, right, bottom] = candidate.pixels.map(u32::from);
        let columns = [left.saturating_sub(x) as usize, (right - x).min(TILE) as usize];
        let rows = [top.saturating_sub(y) as usize, (bottom - y).min(TILE) as usize];
        let (solids, near) = (self.shader.solids, self.near);
        let place = ((candidate.index, candidate.nearest), columns, rows);
        macro_rules! draw {
            ($solid:expr) => {{
                let solid = $solid;
                if self.grid.orthographic {
                    depth.draw(place, Drawn::<_, true> { solid, near });
                } else {
                    depth.draw(place, Drawn::<_, false> { solid, near });
                }
            }};
        }
        match solids.primitive(candidate.index as usize) {
            Primitive::Sphere(i) => draw!(solids.spheres[i]),
            Primitive::Cylinder(i) => draw!(solids.cylinders[i]),
            Primitive::Cone(i) => draw!(solids.cones[i]),
            Primitive::Torus(i) => draw!(solids.tori[i]),
            Primitive::Triangle(i) => draw!(solids.triangles[i]),
        }
    }

    /// Upper left pixel of a tile in the region.
    fn corner(&self, tile: usize) -> (u32, u32) {
        let tile = u32::try_from(tile).unwrap_or(u32::MAX);
        (tile % self.bins.tiles[0] * TILE, tile / self.bins.tiles[0] * TILE)
    }

    /// Calls `pixel` with the place in the tile, of each pixel of the tile that is in the picture.
    fn for_each_pixel(&self, tile: usize, mut pixel: impl FnMut(usize, usize)) {
        let (x, y) = self.corner(tile);
        for row in 0..TILE.min(self.region.height - y) {
            for column in 0..TILE.min(self.region.width - x) {
                pixel(column as usize, row as usize);
            }
        }
    }

    fn center_ray(&self, tile: usize, column: usize, row: usize) -> Ray {
        let (x, y) = self.corner(tile);
        let px = (self.region.x + x) as f32 + column as f32 + 0.5;
        let py = (self.region.y + y) as f32 + row as f32 + 0.5;
        self.grid.ray(self.grid.plane(px, py))
    }

    /// Notes what a sample shows that was not seen in its pixel before.
    fn note(&self, reaches: &mut Reaches, depth: &TileDepth, tile: usize) {
        let unasked = self.shader.frame.unasked();
        self.for_each_pixel(tile, |column, row| {
            let t = depth.t[row][column];
            let ray = self.grid.ray((depth.u[column], depth.v[row]));
            if t < f32::INFINITY && self.shader.is_seen(&ray, t) {
                let (pixel, index) = (row * TILE as usize + column, depth.index[row][column]);
                reaches.note(pixel, index, unasked, || self.shader.point_in_world(&ray, index, t));
            }
        });
    }

    /// The finished pixels of a tile.
    fn color_tile(&self, tile: usize, samples: u32, lights: &Lights) -> [Srgb8; PIXELS] {
        let mut depth = TileDepth::new();
        let mut sums = [Vec4::ZERO; PIXELS];
        let mut unseen = [samples; PIXELS];
        let unasked = self.shader.frame.unasked();
        if self.bins.of_tile(tile).next().is_some() {
            let mut reaches = Reaches::new(if lights.is_empty() { 0 } else { PIXELS });
            for sample in 0..samples {
                self.see(&mut depth, tile, [sample, samples]);
                if !lights.is_empty() {
                    self.note(&mut reaches, &depth, tile);
                    reaches.ask(lights);
                }
                self.for_each_pixel(tile, |column, row| {
                    let t = depth.t[row][column];
                    if t == f32::INFINITY {
                        return;
                    }
                    let ray = self.grid.ray((depth.u[column], depth.v[row]));
                    if self.shader.is_seen(&ray, t) {
                        let (pixel, index) = (row * TILE as usize + column, depth.index[row][column]);
                        let reach = if lights.is_empty() { unasked } else { reaches.of(pixel, index, unasked) };
                        sums[pixel] += self.shader.primitive(&ray, index, t, reach);
                        unseen[pixel] -= 1;
                    }
                });
            }
        }
        let mut pixels = [Srgb8::BLACK; PIXELS];
        // Neighbours in the backdrop are mostly equal.
        let mut last = (Vec4::NAN, Srgb8::BLACK);
        self.for_each_pixel(tile, |column, row| {
            let pixel = row * TILE as usize + column;
            let mut sum = sums[pixel];
            if unseen[pixel] > 0 {
                sum += self.shader.backdrop(&self.center_ray(tile, column, row)) * unseen[pixel] as f32;
            }
            if sum != last.0 {
                last = (sum, resolve(sum, samples));
            }
            pixels[pixel] = last.1;
        });
        pixels
    }
}

/// Sorts a scene into the tiles of a view and calls `draw` with the picture.
fn with_picture<R>(
    scene: &Scene,
    view: &View,
    frame: &FrameConstants,
    ground_map: &GroundMap,
    draw: impl FnOnce(&Picture<'_>) -> R,
) -> R {
    let solids = Solids::new(scene, view.camera.view_from_world());
    let picture = Picture {
        bins: Bins::new(&solids, view),
        shader: Shader::new(frame, &solids, ground_map),
        grid: view.pixel_grid(),
        region: view.region(),
        near: view.camera.near,
    };
    draw(&picture)
}

/// The finished picture; unfinished, and of no use, if `stop` became true meanwhile.
#[must_use]
pub(super) fn image(
    scene: &Scene,
    view: &View,
    settings: &Settings,
    (ground_map, lights): (&GroundMap, &Lights),
    stop: &AtomicBool,
) -> Image {
    let frame = FrameConstants::new(scene, view, settings);
    let region = view.region();
    let samples = settings.samples.clamp(1, 4096);
    let row_bytes = region.width as usize * 4;
    let mut rgba = vec![0u8; row_bytes * region.height as usize];
    with_picture(scene, view, &frame, ground_map, |picture| {
        let across = picture.bins.tiles[0] as usize;
        rgba.par_chunks_mut(row_bytes * TILE as usize).enumerate().for_each(|(tile_row, band)| {
            // Tiles of a band differ much in cost: they are shared out one by one.
            let tiles: Vec<_> = (0..across)
                .into_par_iter()
                .with_max_len(1)
                .map(|column| match stop.load(Ordering::Relaxed) {
                    true => [Srgb8::BLACK; PIXELS],
                    false => picture.color_tile(tile_row * across + column, samples, lights),
                })
                .collect();
            for (column, pixels) in tiles.iter().enumerate() {
                let left = column * TILE as usize;
                let width = (TILE as usize).min(region.width as usize - left);
                for (row, line) in band.chunks_mut(row_bytes).enumerate() {
                    let from = &pixels[row * TILE as usize..row * TILE as usize + width];
                    line[left * 4..(left + width) * 4].copy_from_slice(bytemuck::cast_slice(from));
                }
            }
        });
    });
    Image { width: region.width, height: region.height, rgba }
}

/// What is seen at the pixel centres.
#[must_use]
pub fn gbuffer(scene: &Scene, view: &View) -> GBuffer {
    let frame = FrameConstants::new(scene, view, &Settings::default());
    let region = view.region();
    let none = GroundMap::none();
    with_picture(scene, view, &frame, &none, |picture| {
        let across = picture.bins.tiles[0] as usize;
        let tiles: Vec<Box<TileDepth>> = (0..across * picture.bins.tiles[1] as usize)
            .into_par_iter()
            .map(|tile| {
                let mut depth = Box::new(TileDepth::new());
                picture.see(&mut depth, tile, [0, 1]);
                depth
            })
            .collect();
        let mut buffer = GBuffer::with_capacity(region.width, region.height);
        for y in 0..region.height {
            for x in 0..region.width {
                let tile = &tiles[(y / TILE) as usize * across + (x / TILE) as usize];
                let (column, row) = ((x % TILE) as usize, (y % TILE) as usize);
                let t = tile.t[row][column];
                let nearest = (t < f32::INFINITY).then(|| (tile.index[row][column], t));
                let ray = picture.grid.ray((tile.u[column], tile.v[row]));
                buffer.push(picture.shader.facts(&ray, nearest));
            }
        }
        buffer
    })
}
