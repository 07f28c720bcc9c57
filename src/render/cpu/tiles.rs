//! The reference's picture, tile by tile on all cores: visibility with the same bits, colours within 1/255.
//!
//! For each pass over a tile's samples the candidates are drawn front to back into a small depth buffer
//! ([`super::tile`]), then what is seen is lit sixteen samples at a time ([`super::shade`]). Of a large scene only what some
//! samples ask is known at once: these samples are added up in all tiles before the next are.

use super::backdrop::Row;
use super::binning::{Bins, Candidate};
use super::lanes::Pass;
use super::reach::{Lights, Questions, Shadows};
use super::shade;
use super::shader::Shader;
use super::simd::{Work, widest};
use super::tile::{Place, SIDE, Tile};
use crate::color::Srgb8;
use crate::render::field::GroundMap;
use crate::render::frame::{FrameConstants, resolve, shade_background};
use crate::render::lens::Lens;
use crate::render::solids::Solids;
use crate::render::{GBuffer, Image, Settings, View};
use crate::scene::{PixelGrid, Region, Scene};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// What all tiles of a picture share.
struct Picture<'a> {
    shader: Shader<'a>,
    bins: Bins,
    grid: PixelGrid,
    region: Region,
    near: f32,
}

/// What a thread needs for a tile, and uses again for the next.
struct Bench {
    tile: Box<Tile>,
    candidates: Vec<Candidate>,
}

impl Bench {
    fn new() -> Bench {
        Bench { tile: Tile::new(), candidates: Vec::new() }
    }
}

impl<'a> Picture<'a> {
    fn new(shader: Shader<'a>, view: &View, tile: u32) -> Picture<'a> {
        Picture {
            bins: Bins::new(shader.solids, shader.outlined.as_ref(), view, tile),
            shader,
            grid: view.pixel_grid(),
            region: view.region(),
            near: view.camera.near,
        }
    }

    fn place<'p>(&'p self, tile: usize, pass: &'p Pass) -> Place<'p> {
        let tile = u32::try_from(tile).unwrap_or(u32::MAX);
        let in_region = [tile % self.bins.tiles[0] * self.bins.tile, tile / self.bins.tiles[0] * self.bins.tile];
        let blocks = |at: u32, end: u32| ((end - at).min(self.bins.tile).div_ceil(pass.side)) as usize;
        Place {
            pass,
            grid: self.grid,
            corner: [self.region.x + in_region[0], self.region.y + in_region[1]],
            in_region,
            blocks: [blocks(in_region[0], self.region.width), blocks(in_region[1], self.region.height)],
            near: self.near,
            outline: self.shader.outlined.as_ref(),
        }
    }
}

/// The samples of a tile, as work for [`widest`].
struct Samples<'w, 'a> {
    picture: &'w Picture<'a>,
    bench: &'w mut Bench,
    place: Place<'w>,
    /// What is asked, and where light is added to; without, only what is seen is found.
    lit: Option<(&'w Questions<'w>, &'w mut [f32])>,
}

impl Work for Samples<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Samples { picture, bench, place, lit } = self;
        bench.tile.see(&place, picture.shader.solids, &bench.candidates);
        if let Some((questions, sums)) = lit {
            shade::add(&picture.shader, questions, &place, &bench.tile, (sums, picture.bins.tile as usize));
        }
    }
}

/// What the samples of a tile gave: planes of [`super::backdrop::Sums`], one after the other, rows of the tile's width. Empty
/// where nothing was added yet.
type TileSums = Vec<f32>;

impl Picture<'_> {
    /// The sums of all tiles before anything is added.
    fn nothing(&self) -> Vec<TileSums> {
        vec![TileSums::new(); (self.bins.tiles[0] * self.bins.tiles[1]) as usize]
    }

    /// Adds samples of a tile.
    fn add(&self, bench: &mut Bench, tile: usize, (passes, questions): (&[Pass], &Questions<'_>), sums: &mut TileSums) {
        if self.bins.is_empty(tile) {
            return;
        }
        let side = self.bins.tile as usize;
        sums.resize(4 * side * side, 0.0);
        self.bins.of_tile(tile, &mut bench.candidates);
        for pass in passes {
            let place = self.place(tile, pass);
            widest(Samples { picture: self, bench, place, lit: Some((questions, sums)) });
        }
    }

    /// Adds samples of all tiles, unless `stop` becomes true.
    fn add_to_all(&self, asked: (&[Pass], &Questions<'_>), sums: &mut [TileSums], stop: &AtomicBool) {
        sums.par_iter_mut().enumerate().with_max_len(4).for_each_init(Bench::new, |bench, (tile, sums)| {
            if !stop.load(Ordering::Relaxed) {
                self.add(bench, tile, asked, sums);
            }
        });
    }

    /// The picture of what `pixels` makes of the tiles.
    fn put_together(
        &self,
        mut sums: Vec<TileSums>,
        stop: &AtomicBool,
        pixels: impl Fn(&mut Bench, usize, TileSums) -> Vec<Srgb8> + Sync,
    ) -> Image {
        let Region { width, height, .. } = self.region;
        let (side, across, row_bytes) = (self.bins.tile as usize, self.bins.tiles[0] as usize, width as usize * 4);
        let mut rgba = vec![0u8; row_bytes * height as usize];
        let bands = rgba.par_chunks_mut(row_bytes * side).zip(sums.par_chunks_mut(across));
        bands.enumerate().for_each(|(tile_row, (band, sums))| {
            // Tiles of a band differ much in cost: they are shared out in small groups.
            let tiles: Vec<_> = (sums.par_iter_mut().enumerate().with_max_len(4))
                .map_init(Bench::new, |bench, (column, sums)| match stop.load(Ordering::Relaxed) {
                    true => Vec::new(),
                    false => pixels(bench, tile_row * across + column, std::mem::take(sums)),
                })
                .collect();
            for (column, pixels) in tiles.iter().enumerate() {
                let left = column * side;
                let width = side.min(width as usize - left);
                for (from, line) in pixels.chunks_exact(width).zip(band.chunks_mut(row_bytes)) {
                    line[left * 4..(left + width) * 4].copy_from_slice(bytemuck::cast_slice(from));
                }
            }
        });
        Image { width, height, rgba }
    }

    /// The finished pixels of a tile.
    fn finish(&self, tile: usize, mut sums: TileSums, samples: u32) -> Vec<Srgb8> {
        let side = self.bins.tile;
        sums.resize(4 * (side * side) as usize, 0.0);
        let (x, y) = (tile as u32 % self.bins.tiles[0] * side, tile as u32 / self.bins.tiles[0] * side);
        let (width, height) = ((self.region.width - x).min(side), (self.region.height - y).min(side));
        let mut pixels = vec![Srgb8::BLACK; (width * height) as usize];
        let corner = [self.region.x + x, self.region.y + y];
        widest(Finish { picture: self, sums: &sums, corner, width, samples, pixels: &mut pixels });
        pixels
    }
}

/// The pixels of a tile, as work for [`widest`].
struct Finish<'w, 'a> {
    picture: &'w Picture<'a>,
    sums: &'w [f32],
    corner: [u32; 2],
    width: u32,
    samples: u32,
    pixels: &'w mut [Srgb8],
}

impl Work for Finish<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let (side, width) = (self.picture.bins.tile as usize, self.width as usize);
        let background = resolve(shade_background(self.picture.shader.frame), 1);
        for ((row, pixels), y) in self.pixels.chunks_exact_mut(width).enumerate().zip(self.corner[1]..) {
            let plane = |plane: usize| &self.sums[(plane * side + row) * side..][..width];
            let (shader, grid) = (&self.picture.shader, &self.picture.grid);
            let row = Row { shader, grid, corner: [self.corner[0], y], samples: self.samples, background };
            row.finish([plane(0), plane(1), plane(2), plane(3)], pixels);
        }
    }
}

/// The finished picture; unfinished, and of no use, if `stop` became true meanwhile.
#[must_use]
pub(super) fn image(
    scene: &Scene,
    view: &View,
    settings: &Settings,
    (ground_map, lights): (&GroundMap, &mut Lights),
    stop: &AtomicBool,
) -> Image {
    if let Some(lens) = Lens::of(scene, view) {
        return image_through(&lens, scene, view, settings, (ground_map, lights), stop);
    }
    let frame = FrameConstants::new(scene, view, settings);
    let samples = settings.samples.clamp(1, 4096);
    let solids = Solids::new(scene, view.camera.view_from_world());
    let shadows = Shadows::new(scene, view, &solids, lights);
    let parts = lights.parts(&shadows, samples);
    let side = Pass::all(parts[0].clone(), samples).first().map_or(1, |pass| pass.side);
    let picture = Picture::new(Shader::new(&frame, &solids, ground_map), view, side * SIDE as u32);
    let mut sums = picture.nothing();
    let (last, before) = parts.split_last().unwrap_or((&(0..0), &[]));
    for part in before {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let questions = shadows.look(lights, part);
        picture.add_to_all((&Pass::all(part.clone(), samples), &questions), &mut sums, stop);
    }
    if stop.load(Ordering::Relaxed) {
        // Nobody looks at it, and what is known of other directions is kept.
        return picture.put_together(sums, stop, |_, _, _| Vec::new());
    }
    let questions = shadows.look(lights, last);
    let passes = Pass::all(last.clone(), samples);
    picture.put_together(sums, stop, |bench, tile, mut sums| {
        picture.add(bench, tile, (&passes, &questions), &mut sums);
        picture.finish(tile, sums, samples)
    })
}

/// The finished picture through a lens: each sample with a camera of its own, then all of them together.
fn image_through(
    lens: &Lens,
    scene: &Scene,
    view: &View,
    settings: &Settings,
    (ground_map, lights): (&GroundMap, &mut Lights),
    stop: &AtomicBool,
) -> Image {
    let samples = settings.samples.clamp(1, 4096);
    let side = 4 * SIDE as u32;
    let (frame, none) = (FrameConstants::new(scene, view, settings), Solids::default());
    let picture = Picture::new(Shader::new(&frame, &none, ground_map), view, side);
    let mut sums = picture.nothing();
    for sample in 0..samples {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let view = lens.view(view, sample, samples);
        let frame = FrameConstants::new(scene, &view, settings);
        let solids = Solids::new(scene, view.camera.view_from_world());
        let shadows = Shadows::new(scene, &view, &solids, lights);
        // Directions hold for every point of the lens: those of a part are found once.
        let parts = lights.parts(&shadows, samples);
        let part = parts.into_iter().find(|part| part.contains(&sample)).unwrap_or(sample..sample + 1);
        let questions = shadows.look(lights, &part);
        let seen = Picture::new(Shader::new(&frame, &solids, ground_map), &view, side);
        seen.add_to_all((&[Pass::of_one(sample, samples)], &questions), &mut sums, stop);
    }
    picture.put_together(sums, stop, |_, tile, sums| picture.finish(tile, sums, samples))
}

/// What is seen at the pixel centres.
#[must_use]
pub fn gbuffer(scene: &Scene, view: &View) -> GBuffer {
    let frame = FrameConstants::new(scene, view, &Settings::default()).without_outlines();
    let region = view.region();
    let none = GroundMap::none();
    let solids = Solids::new(scene, view.camera.view_from_world());
    let passes = Pass::all(0..1, 1);
    let pass = &passes[0];
    let picture = Picture::new(Shader::new(&frame, &solids, &none), view, pass.side * SIDE as u32);
    let across = picture.bins.tiles[0] as usize;
    let tiles: Vec<Box<Tile>> = (0..across * picture.bins.tiles[1] as usize)
        .into_par_iter()
        .map(|tile| {
            let mut bench = Bench::new();
            picture.bins.of_tile(tile, &mut bench.candidates);
            let place = picture.place(tile, pass);
            widest(Samples { picture: &picture, bench: &mut bench, place, lit: None });
            bench.tile
        })
        .collect();
    let mut buffer = GBuffer::with_capacity(region.width, region.height);
    for y in 0..region.height {
        for x in 0..region.width {
            let of = |at: u32| (at % picture.bins.tile, at / picture.bins.tile);
            let ((column, tile_column), (row, tile_row)) = (of(x), of(y));
            let tile = &tiles[tile_row as usize * across + tile_column as usize];
            let block = |at: u32| (at / pass.side) as usize;
            let lane = (row % pass.side * pass.side + column % pass.side) as usize;
            let (t, index) = (tile.t[block(row)][block(column)][lane], tile.index[block(row)][block(column)][lane]);
            let nearest = (t < f32::INFINITY).then_some((index, t));
            let center = picture.grid.plane((region.x + x) as f32 + 0.5, (region.y + y) as f32 + 0.5);
            buffer.push(picture.shader.facts(&picture.grid.ray(center), nearest));
        }
    }
    buffer
}
