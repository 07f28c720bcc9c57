//! The reference's picture, tile by tile on all cores: visibility with the same bits, colours within 1/255.
//!
//! For each pass over a tile's samples the candidates are drawn front to back into a small depth buffer
//! ([`super::tile`]), then what is seen is lit sixteen samples at a time ([`super::shade`]).

use super::backdrop::Row;
use super::binning::{Bins, Candidate};
use super::lanes::Pass;
use super::reach::{Lights, Questions};
use super::shade::{self, Shading};
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
    /// Planes of [`super::backdrop::Sums`], one after the other, rows of the tile's width.
    sums: Vec<f32>,
    shading: Shading,
}

impl Bench {
    fn new() -> Bench {
        Bench { tile: Tile::new(), candidates: Vec::new(), sums: Vec::new(), shading: Shading::default() }
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
    /// What is asked, for colours; without, only what is seen is found.
    questions: Option<&'w Questions<'w>>,
}

impl Work for Samples<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Samples { picture, bench, place, questions } = self;
        bench.tile.see(&place, picture.shader.solids, &bench.candidates);
        let Some(questions) = questions else { return };
        let Bench { tile, sums, shading, .. } = bench;
        let sums = (sums.as_mut_slice(), picture.bins.tile as usize);
        shade::add(&picture.shader, questions, &place, tile, sums, shading);
    }
}

impl Picture<'_> {
    /// Writes the finished pixels of a tile to its rows in a band of the picture.
    fn color_tile(
        &self,
        bench: &mut Bench,
        tile: usize,
        (passes, questions): (&[Pass], &Questions<'_>),
        samples: u32,
    ) -> Vec<Srgb8> {
        let side = self.bins.tile as usize;
        bench.sums.clear();
        bench.sums.resize(4 * side * side, 0.0);
        if !self.bins.is_empty(tile) {
            self.bins.of_tile(tile, &mut bench.candidates);
            for pass in passes {
                let place = self.place(tile, pass);
                widest(Samples { picture: self, bench, place, questions: Some(questions) });
            }
        }
        let (x, y) = (tile as u32 % self.bins.tiles[0] * side as u32, tile as u32 / self.bins.tiles[0] * side as u32);
        let (width, height) = ((self.region.width - x).min(side as u32), (self.region.height - y).min(side as u32));
        let mut pixels = vec![Srgb8::BLACK; (width * height) as usize];
        widest(Finish {
            picture: self,
            sums: &bench.sums,
            corner: [self.region.x + x, self.region.y + y],
            width,
            samples,
            pixels: &mut pixels,
        });
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
    (ground_map, lights): (&GroundMap, &Lights),
    stop: &AtomicBool,
) -> Image {
    if let Some(lens) = Lens::of(scene, view) {
        return image_through(&lens, scene, view, settings, (ground_map, lights), stop);
    }
    let frame = FrameConstants::new(scene, view, settings);
    let region = view.region();
    let samples = settings.samples.clamp(1, 4096);
    let passes = Pass::all(samples);
    let tile = passes.first().map_or(1, |pass| pass.side) * SIDE as u32;
    let row_bytes = region.width as usize * 4;
    let mut rgba = vec![0u8; row_bytes * region.height as usize];
    let solids = Solids::new(scene, view.camera.view_from_world());
    let questions = lights.questions(scene, view, &solids);
    let picture = Picture::new(Shader::new(&frame, &solids, ground_map), view, tile);
    let across = picture.bins.tiles[0] as usize;
    rgba.par_chunks_mut(row_bytes * tile as usize).enumerate().for_each(|(tile_row, band)| {
        // Tiles of a band differ much in cost: they are shared out in small groups.
        let tiles: Vec<_> = (0..across)
            .into_par_iter()
            .with_max_len(4)
            .map_init(Bench::new, |bench, column| match stop.load(Ordering::Relaxed) {
                true => Vec::new(),
                false => picture.color_tile(bench, tile_row * across + column, (&passes, &questions), samples),
            })
            .collect();
        for (column, pixels) in tiles.iter().enumerate() {
            let left = column * tile as usize;
            let width = (tile as usize).min(region.width as usize - left);
            for (from, line) in pixels.chunks_exact(width).zip(band.chunks_mut(row_bytes)) {
                line[left * 4..(left + width) * 4].copy_from_slice(bytemuck::cast_slice(from));
            }
        }
    });
    Image { width: region.width, height: region.height, rgba }
}

/// The finished picture through a lens: each sample with a camera of its own, then all of them together.
fn image_through(
    lens: &Lens,
    scene: &Scene,
    view: &View,
    settings: &Settings,
    (ground_map, lights): (&GroundMap, &Lights),
    stop: &AtomicBool,
) -> Image {
    let region = view.region();
    let samples = settings.samples.clamp(1, 4096);
    let side = 4 * SIDE;
    let across = (region.width as usize).div_ceil(side);
    let mut sums = vec![Vec::new(); across * (region.height as usize).div_ceil(side)];
    for sample in 0..samples {
        let view = lens.view(view, sample, samples);
        let frame = FrameConstants::new(scene, &view, settings);
        let solids = Solids::new(scene, view.camera.view_from_world());
        let questions = lights.questions(scene, &view, &solids);
        let picture = Picture::new(Shader::new(&frame, &solids, ground_map), &view, side as u32);
        let pass = Pass::of_one(sample, samples);
        sums.par_iter_mut().enumerate().with_max_len(4).for_each_init(Bench::new, |bench, (tile, sums)| {
            if picture.bins.is_empty(tile) || stop.load(Ordering::Relaxed) {
                return;
            }
            sums.resize(4 * side * side, 0.0);
            std::mem::swap(&mut bench.sums, sums);
            picture.bins.of_tile(tile, &mut bench.candidates);
            let place = picture.place(tile, &pass);
            widest(Samples { picture: &picture, bench, place, questions: Some(&questions) });
            std::mem::swap(&mut bench.sums, sums);
        });
    }
    let (frame, none) = (FrameConstants::new(scene, view, settings), Solids::default());
    let picture = Picture::new(Shader::new(&frame, &none, ground_map), view, side as u32);
    let row_bytes = region.width as usize * 4;
    let mut rgba = vec![0u8; row_bytes * region.height as usize];
    let bands = rgba.par_chunks_mut(row_bytes * side).zip(sums.par_chunks_mut(across)).enumerate();
    bands.for_each(|(tile_row, (band, sums))| {
        for (column, sums) in sums.iter_mut().enumerate() {
            sums.resize(4 * side * side, 0.0);
            let left = column * side;
            let (width, height) = (side.min(region.width as usize - left), band.len() / row_bytes);
            let mut pixels = vec![Srgb8::BLACK; width * height];
            let corner = [region.x + left as u32, region.y + (tile_row * side) as u32];
            widest(Finish { picture: &picture, sums, corner, width: width as u32, samples, pixels: &mut pixels });
            for (from, line) in pixels.chunks_exact(width).zip(band.chunks_mut(row_bytes)) {
                line[left * 4..(left + width) * 4].copy_from_slice(bytemuck::cast_slice(from));
            }
            *sums = Vec::new();
        }
    });
    Image { width: region.width, height: region.height, rgba }
}

/// What is seen at the pixel centres.
#[must_use]
pub fn gbuffer(scene: &Scene, view: &View) -> GBuffer {
    let frame = FrameConstants::new(scene, view, &Settings::default()).without_outlines();
    let region = view.region();
    let none = GroundMap::none();
    let solids = Solids::new(scene, view.camera.view_from_world());
    let passes = Pass::all(1);
    let pass = &passes[0];
    let picture = Picture::new(Shader::new(&frame, &solids, &none), view, pass.side * SIDE as u32);
    let across = picture.bins.tiles[0] as usize;
    let tiles: Vec<Box<Tile>> = (0..across * picture.bins.tiles[1] as usize)
        .into_par_iter()
        .map(|tile| {
            let mut bench = Bench::new();
            picture.bins.of_tile(tile, &mut bench.candidates);
            let place = picture.place(tile, pass);
            widest(Samples { picture: &picture, bench: &mut bench, place, questions: None });
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
