//! The reference's picture, tile by tile on all cores: visibility with the same bits, colours within 1/255.
//!
//! For each pass over a tile's samples the candidates are drawn front to back into a small depth buffer
//! ([`super::tile`]), then what is seen is lit sixteen samples at a time ([`super::shade`]). Samples that ask for light from afar are
//! kept until it is known ([`super::lit`]), some of all tiles at a time.

use super::asking::{Asking, Questions};
use super::backdrop::Row;
use super::binning::Candidate;
use super::hiders::Hiders;
use super::lanes::Pass;
use super::lit::{self, Part};
use super::packs::{Any, Packed, Packs};
use super::reach::{Lights, Shadows};
use super::shade::{self, Kept};
use super::shader::Shader;
use super::simd::{Work, widest};
use super::source::{Facts, Listed, Source};
use super::tile::{Place, SIDE, Tile};
use crate::color::Srgb8;
use crate::render::field::GroundMap;
use crate::render::frame::{FrameConstants, resolve, shade_background};
use crate::render::lens::Lens;
use crate::render::outline::Outline;
use crate::render::solids::Solids;
use crate::render::{GBuffer, Image, Settings, View};
use crate::scene::{PixelGrid, Region, Scene};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// What all tiles of a picture share.
pub(super) struct Picture<'a, S> {
    pub(super) shader: Shader<'a>,
    source: S,
    /// Pixels on a side of a tile.
    pub(super) tile: u32,
    /// Tiles in x and y.
    tiles: [u32; 2],
    pub(super) grid: PixelGrid,
    region: Region,
    near: f32,
    benches: Benches,
}

/// What a thread needs for a tile, and uses again for the next.
struct Bench {
    tile: Box<Tile>,
    candidates: Vec<Candidate>,
}

/// Benches that no thread works at: as many are made as there are threads.
#[derive(Default)]
struct Benches(Mutex<Vec<Bench>>);

impl Benches {
    /// Does something at one of them.
    fn at_one<R>(&self, work: impl FnOnce(&mut Bench) -> R) -> R {
        // Nobody leaves the list half-changed behind.
        let free = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = free().pop();
        let mut bench = taken.unwrap_or_else(|| Bench { tile: Tile::new(), candidates: Vec::new() });
        let done = work(&mut bench);
        free().push(bench);
        done
    }
}

impl<'a, S: Source> Picture<'a, S> {
    fn new(shader: Shader<'a>, source: S, view: &View, tile: u32) -> Picture<'a, S> {
        let region = view.region();
        let tiles = [region.width.div_ceil(tile), region.height.div_ceil(tile)];
        let (grid, near, benches) = (view.pixel_grid(), view.camera.near, Benches::default());
        Picture { shader, source, tile, tiles, grid, region, near, benches }
    }

    fn place<'p>(&'p self, tile: usize, pass: &'p Pass) -> Place<'p> {
        let tile = u32::try_from(tile).unwrap_or(u32::MAX);
        let in_region = [tile % self.tiles[0] * self.tile, tile / self.tiles[0] * self.tile];
        let blocks = |at: u32, end: u32| ((end - at).min(self.tile).div_ceil(pass.side)) as usize;
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

/// What is to be found in a tile, as work for [`widest`].
struct See<'w, S> {
    source: &'w S,
    bench: &'w mut Bench,
    tile: usize,
    place: &'w Place<'w>,
}

impl<S: Source> Work for See<'_, S> {
    #[inline(always)]
    fn run(self) {
        let See { source, bench: Bench { tile, candidates }, tile: number, place } = self;
        source.see(tile, candidates, place, number);
    }
}

/// What becomes of what is seen in a tile, as work for [`widest`]. For all sources one: it is long.
struct Shade<'w, 'r> {
    shader: &'w Shader<'w>,
    source: &'w dyn Facts,
    tile: &'w Tile,
    place: &'w Place<'w>,
    then: Then<'w, 'r>,
}

/// What becomes of what is seen.
enum Then<'w, 'r> {
    /// Its light is added to sums with rows of so many pixels.
    Add(Option<&'w Questions<'w>>, &'w mut [f32], usize),
    /// It is kept, of a tile of so many pixels' width, until it is known what light reaches it.
    Keep(&'w mut Kept, usize),
    /// It is the only sample, asks nothing, and makes the pixels; whether nothing is seen.
    Finish(&'w mut [&'r mut [Srgb8]], bool),
}

impl Work for Shade<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Shade { shader, source, tile, place, then } = self;
        match then {
            Then::Add(questions, sums, width) => {
                shade::add((shader, source), questions, place, tile, (sums, width));
            }
            Then::Keep(kept, width) => shade::keep((shader, source), place, tile, (kept, width)),
            Then::Finish(rows, is_empty) => shade::finish((shader, source), place, (tile, is_empty), rows),
        }
    }
}

/// What the samples of a tile gave: planes of [`super::backdrop::Sums`], one after the other, rows of the tile's width. Empty
/// where nothing was added yet.
pub(super) type TileSums = Vec<f32>;

impl<S: Source> Picture<'_, S> {
    /// The sums of all tiles before anything is added.
    fn nothing(&self) -> Vec<TileSums> {
        vec![TileSums::new(); (self.tiles[0] * self.tiles[1]) as usize]
    }

    /// Finds what is seen in a tile, and makes something of it.
    fn draw(&self, bench: &mut Bench, tile: usize, place: &Place<'_>, then: Then<'_, '_>) {
        if !matches!(then, Then::Finish(_, true)) {
            widest(See { source: &self.source, bench, tile, place });
        }
        widest(Shade { shader: &self.shader, source: &self.source, tile: &bench.tile, place, then });
    }

    /// How many pixels each tile has, if anything reaches into it.
    fn reached(&self) -> Vec<usize> {
        let (tiles, pixels) = ((self.tiles[0] * self.tiles[1]) as usize, (self.tile * self.tile) as usize);
        (0..tiles).map(|tile| if self.source.is_empty(tile) { 0 } else { pixels }).collect()
    }

    /// Adds samples of a tile, which ask at once or not at all.
    fn add(&self, bench: &mut Bench, tile: usize, (passes, questions): AtOnce<'_>, sums: &mut TileSums) {
        if self.source.is_empty(tile) {
            return;
        }
        let side = self.tile as usize;
        sums.resize(4 * side * side, 0.0);
        for pass in passes {
            let place = self.place(tile, pass);
            self.draw(bench, tile, &place, Then::Add(questions, sums, side));
        }
    }

    /// Adds samples of all tiles, which ask at once or not at all, unless `stop` becomes true.
    fn add_to_all(&self, passes: AtOnce<'_>, sums: &mut [TileSums], stop: &AtomicBool) {
        sums.par_iter_mut().enumerate().with_max_len(4).for_each(|(tile, sums)| {
            if !stop.load(Ordering::Relaxed) {
                self.benches.at_one(|bench| self.add(bench, tile, passes, sums));
            }
        });
    }

    /// Keeps what samples of a tile show.
    pub(super) fn keep(&self, tile: usize, passes: &[Pass], kept: &mut Kept) {
        if self.source.is_empty(tile) {
            return;
        }
        self.benches.at_one(|bench| {
            for pass in passes {
                let place = self.place(tile, pass);
                self.draw(bench, tile, &place, Then::Keep(kept, self.tile as usize));
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
        let (side, across, row_bytes) = (self.tile as usize, self.tiles[0] as usize, width as usize * 4);
        let mut rgba = vec![0u8; row_bytes * height as usize];
        let bands = rgba.par_chunks_mut(row_bytes * side).zip(sums.par_chunks_mut(across));
        bands.enumerate().for_each(|(tile_row, (band, sums))| {
            // Tiles of a band differ much in cost: they are shared out in small groups.
            let tiles: Vec<_> = (sums.par_iter_mut().enumerate().with_max_len(4))
                .map(|(column, sums)| match stop.load(Ordering::Relaxed) {
                    true => Vec::new(),
                    false => {
                        self.benches.at_one(|bench| pixels(bench, tile_row * across + column, std::mem::take(sums)))
                    }
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

    /// The finished picture of one sample a pixel that asks nothing, each tile written at once.
    fn finished(&self, stop: &AtomicBool) -> Image {
        let Region { width, height, .. } = self.region;
        let (side, across) = (self.tile as usize, self.tiles[0] as usize);
        let mut rgba = vec![0u8; width as usize * height as usize * 4];
        let pixels: &mut [Srgb8] = bytemuck::cast_slice_mut(&mut rgba);
        let mut tiles: Vec<Vec<&mut [Srgb8]>> = vec![];
        for band in pixels.chunks_mut(side * width as usize) {
            let first = tiles.len();
            tiles.resize_with(first + across, || Vec::with_capacity(side));
            for line in band.chunks_mut(width as usize) {
                for (tile, part) in tiles[first..].iter_mut().zip(line.chunks_mut(side)) {
                    tile.push(part);
                }
            }
        }
        let pass = Pass::of_one(0, 1);
        tiles.par_iter_mut().enumerate().with_max_len(2).for_each(|(tile, rows)| {
            if !stop.load(Ordering::Relaxed) {
                let (place, is_empty) = (self.place(tile, &pass), self.source.is_empty(tile));
                self.benches.at_one(|bench| self.draw(bench, tile, &place, Then::Finish(rows, is_empty)));
            }
        });
        Image { width, height, rgba }
    }

    /// The finished pixels of a tile.
    fn finish(&self, tile: usize, mut sums: TileSums, samples: u32) -> Vec<Srgb8> {
        let side = self.tile;
        sums.resize(4 * (side * side) as usize, 0.0);
        let (x, y) = (tile as u32 % self.tiles[0] * side, tile as u32 / self.tiles[0] * side);
        let (width, height) = ((self.region.width - x).min(side), (self.region.height - y).min(side));
        let mut pixels = vec![Srgb8::BLACK; (width * height) as usize];
        let corner = [self.region.x + x, self.region.y + y];
        widest(Finish { picture: self, sums: &sums, corner, width, samples, pixels: &mut pixels });
        pixels
    }
}

/// The pixels of a tile, as work for [`widest`].
struct Finish<'w, 'a, S> {
    picture: &'w Picture<'a, S>,
    sums: &'w [f32],
    corner: [u32; 2],
    width: u32,
    samples: u32,
    pixels: &'w mut [Srgb8],
}

impl<S: Source> Work for Finish<'_, '_, S> {
    #[inline(always)]
    fn run(self) {
        let (side, width) = (self.picture.tile as usize, self.width as usize);
        let background = resolve(shade_background(self.picture.shader.frame), 1);
        for ((row, pixels), y) in self.pixels.chunks_exact_mut(width).enumerate().zip(self.corner[1]..) {
            let plane = |plane: usize| &self.sums[(plane * side + row) * side..][..width];
            let (shader, grid) = (&self.picture.shader, &self.picture.grid);
            let row = Row { shader, grid, corner: [self.corner[0], y], samples: self.samples, background };
            row.finish([plane(0), plane(1), plane(2), plane(3)], pixels);
        }
    }
}

/// What is known of a scene's blocks, whatever the view.
#[derive(Clone, Copy, Default)]
pub(super) struct Known<'a> {
    /// Its packs.
    pub(super) packs: Option<&'a Packs>,
    /// Whether its placements must not be spread out: its packs are then what is drawn, whatever it is.
    pub(super) of_copies: bool,
    /// What points ask for light from afar if they do so together; without it each packet asks at once.
    pub(super) hiders: Option<&'a Hiders>,
}

impl<'a> Known<'a> {
    /// The packs of a scene whose placements are not spread out.
    fn packs_of_copies(&self) -> Option<&'a Packs> {
        self.packs.filter(|_| self.of_copies)
    }
}

/// Passes, and what their samples ask as soon as they are found.
type AtOnce<'a> = (&'a [Pass], Option<&'a Questions<'a>>);

/// How points ask for light from afar.
enum Asked<'a> {
    /// Packet by packet, as soon as they are found.
    AtOnce(Box<Asking>),
    /// All of a sample.
    Together(Shadows<'a>),
}

/// The finished picture; unfinished, and of no use, if `stop` became true meanwhile.
#[must_use]
pub(super) fn image(
    scene: &Scene,
    view: &View,
    settings: &Settings,
    (ground_map, lights, known): (&GroundMap, &Lights, Known<'_>),
    stop: &AtomicBool,
) -> Image {
    if let Some(lens) = Lens::of(scene, view) {
        return image_through(&lens, scene, view, settings, (ground_map, lights, known), stop);
    }
    let frame = FrameConstants::new(scene, view, settings);
    let outline = Outline::of(&frame);
    let plain = known.packs.filter(|packs| outline.is_none() && packs.is_opaque());
    let packs = known.packs_of_copies().or(plain);
    let samples = settings.samples.clamp(1, 4096);
    let solids = solids_of(scene, view, packs);
    let asked = asked(scene, view, (lights, known));
    // A tile holds the passes of the most samples that are drawn at a time.
    let most = match &asked {
        Some(Asked::AtOnce(asking)) => asking.parts(lights, samples).first().map_or(samples, |part| part.end),
        Some(Asked::Together(_)) => samples.min(lit::MOST_SAMPLES),
        None => samples,
    };
    let tile = Pass::all(0..most, samples).first().map_or(1, |pass| pass.side) * SIDE as u32;
    let shader = Shader::new(&frame, &solids, ground_map);
    match packs {
        Some(packs) => {
            let source = Packed::new(scene, packs, &solids, outline.as_ref(), (view, tile));
            if source.is_any() {
                return sampled(&Picture::new(shader, Any(source), view, tile), samples, (asked, lights), stop);
            }
            sampled(&Picture::new(shader, source, view, tile), samples, (asked, lights), stop)
        }
        None => {
            let source = Listed::new(&solids, outline.as_ref(), view, tile);
            sampled(&Picture::new(shader, source, view, tile), samples, (asked, lights), stop)
        }
    }
}

/// How points of a view ask for light from afar, if they do.
fn asked<'a>(scene: &Scene, view: &View, (lights, known): (&Lights, Known<'a>)) -> Option<Asked<'a>> {
    lights.asks().then(|| match known.hiders {
        Some(hiders) => Asked::Together(Shadows::new(scene, view, hiders)),
        None => Asked::AtOnce(Box::new(Asking::new(scene, view))),
    })
}

/// What is not drawn from packs, in view space.
fn solids_of(scene: &Scene, view: &View, packs: Option<&Packs>) -> Solids {
    let view_from_world = view.camera.view_from_world();
    match packs {
        Some(packs) => Solids::others(scene, view_from_world, !packs.is_opaque()),
        None => Solids::new(scene, view_from_world),
    }
}

/// The picture of all samples.
fn sampled<S: Source>(
    picture: &Picture<'_, S>,
    samples: u32,
    (asked, lights): (Option<Asked<'_>>, &Lights),
    stop: &AtomicBool,
) -> Image {
    if samples == 1 && asked.is_none() {
        return picture.finished(stop);
    }
    let mut sums = picture.nothing();
    let (passes, questions) = match &asked {
        None => (Pass::all(0..samples, samples), None),
        Some(Asked::AtOnce(asking)) => {
            let parts = asking.parts(lights, samples);
            let (last, before) = parts.split_last().unwrap_or((&(0..0), &[]));
            for part in before {
                if stop.load(Ordering::Relaxed) {
                    break;
                }
                let questions = asking.look(lights, part);
                picture.add_to_all((&Pass::all(part.clone(), samples), Some(&questions)), &mut sums, stop);
            }
            // The last samples of a tile finish it.
            let last = if stop.load(Ordering::Relaxed) { &(0..0) } else { last };
            (Pass::all(last.clone(), samples), Some(asking.look(lights, last)))
        }
        Some(Asked::Together(shadows)) => {
            let mut room = Vec::new();
            for part in lit::parts(&picture.reached(), samples) {
                if stop.load(Ordering::Relaxed) {
                    break;
                }
                lit::add(picture, (&part, samples), (shadows, lights), (&mut sums, &mut room), stop);
            }
            (Vec::new(), None)
        }
    };
    picture.put_together(sums, stop, |bench, tile, mut sums| {
        picture.add(bench, tile, (&passes, questions.as_ref()), &mut sums);
        picture.finish(tile, sums, samples)
    })
}

/// The finished picture through a lens: each sample with a camera of its own, then all of them together.
fn image_through(
    lens: &Lens,
    scene: &Scene,
    view: &View,
    settings: &Settings,
    (ground_map, lights, known): (&GroundMap, &Lights, Known<'_>),
    stop: &AtomicBool,
) -> Image {
    let samples = settings.samples.clamp(1, 4096);
    let packs = known.packs_of_copies();
    let side = 4 * SIDE as u32;
    let (frame, none) = (FrameConstants::new(scene, view, settings), Solids::default());
    let picture =
        Picture::new(Shader::new(&frame, &none, ground_map), Listed::new(&none, None, view, side), view, side);
    let mut sums = picture.nothing();
    for sample in 0..samples {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let view = lens.view(view, sample, samples);
        let frame = FrameConstants::new(scene, &view, settings);
        let solids = solids_of(scene, &view, packs);
        let (outline, asked) = (Outline::of(&frame), asked(scene, &view, (lights, known)));
        let (shader, of) = (Shader::new(&frame, &solids, ground_map), (sample, samples));
        if let Some(packs) = packs {
            let source = Any(Packed::new(scene, packs, &solids, outline.as_ref(), (&view, side)));
            add_sample(&Picture::new(shader, source, &view, side), of, (asked, lights), &mut sums, stop);
        } else {
            let source = Listed::new(&solids, outline.as_ref(), &view, side);
            add_sample(&Picture::new(shader, source, &view, side), of, (asked, lights), &mut sums, stop);
        }
    }
    picture.put_together(sums, stop, |_, tile, sums| picture.finish(tile, sums, samples))
}

/// Adds one of so many samples to all tiles.
fn add_sample<S: Source>(
    picture: &Picture<'_, S>,
    (sample, samples): (u32, u32),
    (asked, lights): (Option<Asked<'_>>, &Lights),
    sums: &mut [TileSums],
    stop: &AtomicBool,
) {
    let (part, passes) = (sample..sample + 1, [Pass::of_one(sample, samples)]);
    match asked {
        Some(Asked::AtOnce(asking)) => {
            picture.add_to_all((&passes, Some(&asking.look(lights, &part))), sums, stop);
        }
        Some(Asked::Together(shadows)) => {
            let part = Part { tiles: 0..sums.len(), samples: part };
            lit::add(picture, (&part, samples), (&shadows, lights), (sums, &mut Vec::new()), stop);
        }
        None => picture.add_to_all((&passes, None), sums, stop),
    }
}

/// What is seen at the pixel centres.
#[must_use]
pub(super) fn gbuffer(scene: &Scene, view: &View, known: Known<'_>) -> GBuffer {
    let frame = FrameConstants::new(scene, view, &Settings::default()).without_outlines();
    let none = GroundMap::none();
    let packs = known.packs_of_copies();
    let solids = solids_of(scene, view, packs);
    let pass = Pass::of_one(0, 1);
    let tile = pass.side * SIDE as u32;
    let shader = Shader::new(&frame, &solids, &none);
    match packs {
        Some(packs) => {
            let source = Any(Packed::new(scene, packs, &solids, None, (view, tile)));
            facts(&Picture::new(shader, source, view, tile), &pass)
        }
        None => {
            let source = Listed::new(&solids, None, view, tile);
            facts(&Picture::new(shader, source, view, tile), &pass)
        }
    }
}

/// What the one sample of a pass sees in every pixel.
fn facts<S: Source>(picture: &Picture<'_, S>, pass: &Pass) -> GBuffer {
    let region = picture.region;
    let across = picture.tiles[0] as usize;
    let tiles: Vec<_> = (0..across * picture.tiles[1] as usize)
        .into_par_iter()
        .map(|tile| {
            let place = picture.place(tile, pass);
            picture.benches.at_one(|bench| {
                widest(See { source: &picture.source, bench, tile, place: &place });
                (bench.tile.t.to_vec(), bench.tile.index.to_vec())
            })
        })
        .collect();
    let mut buffer = GBuffer::with_capacity(region.width, region.height);
    for y in 0..region.height {
        for x in 0..region.width {
            let of = |at: u32| (at % picture.tile, at / picture.tile);
            let ((column, tile_column), (row, tile_row)) = (of(x), of(y));
            let (ts, indices) = &tiles[tile_row as usize * across + tile_column as usize];
            let block = |at: u32| (at / pass.side) as usize;
            let lane = (row % pass.side * pass.side + column % pass.side) as usize;
            let (t, index) = (ts[block(row)][block(column)][lane], indices[block(row)][block(column)][lane]);
            let center = picture.grid.plane((region.x + x) as f32 + 0.5, (region.y + y) as f32 + 0.5);
            let ray = picture.grid.ray(center);
            buffer.push(if t == f32::INFINITY {
                picture.shader.facts(&ray, None)
            } else if let Some(alone) = picture.source.alone(index) {
                picture.shader.of(&alone).facts(&ray, Some((0, t)))
            } else {
                picture.shader.facts(&ray, Some((index, t)))
            });
        }
    }
    buffer
}
