//! Sky visibility of what is seen at the pixel centres, on all cores: all directions, one part of them after the other.

use super::lanes::LANES;
use super::reach::{Answers, Lights, Packets, Points, Shadows};
use super::simd::{Work, widest};
use super::tiles::{self, Known};
use crate::math::{Aabb, max};
use crate::render::image::{GBuffer, SkyVisibility};
use crate::render::settings::View;
use crate::render::sky::{Reach, start_offset};
use crate::scene::{Ray, Scene};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;

/// Directions that are asked at a time: the points of each are there as it sees them.
const DIRECTIONS_AT_A_TIME: usize = 8;
/// Blocks of points that a thread asks for together.
const BLOCKS_TOGETHER: usize = 64;

/// Points that ask, and the weights of the directions that were free, and of all.
#[derive(Clone, Default)]
struct Block {
    points: Points,
    weights: [[f32; LANES]; 2],
}

/// How much of the sky the surface at the pixel centres sees, over so many directions.
pub(super) fn sky_visibility(scene: &Scene, view: &View, directions: &[Vec3], known: Known<'_>) -> SkyVisibility {
    let seen = tiles::gbuffer(scene, view, known);
    let covered: Vec<u32> = (seen.id.iter().zip(&seen.depth).zip(0..))
        .filter(|((id, depth), _)| !matches!(**id, GBuffer::BACKGROUND | GBuffer::GROUND) && **depth > view.camera.near)
        .map(|(_, pixel)| pixel)
        .collect();
    let mut open = vec![1.0; seen.id.len()];
    let mut blocks: Vec<Block> = covered.par_chunks(LANES).map(|pixels| block_of(view, &seen, pixels)).collect();
    if let Some(hiders) = known.hiders {
        let shadows = Shadows::new(scene, view, hiders);
        let bounds = blocks.iter().fold(Aabb::EMPTY, |all, block| all.union(block.bounds()));
        for part in directions.chunks(DIRECTIONS_AT_A_TIME) {
            let answers =
                shadows.answers(&Lights::of_sky(part), &[(0, Blocks(&blocks, bounds))], &AtomicBool::new(false));
            blocks.par_chunks_mut(BLOCKS_TOGETHER).enumerate().for_each(|(some, blocks)| {
                let first = some * BLOCKS_TOGETHER;
                widest(Tell { answers: &answers, blocks, first });
                blocks.iter_mut().for_each(|block| block.add(view, part));
            });
        }
    }
    for (pixels, block) in covered.chunks(LANES).zip(&blocks) {
        for (lane, &pixel) in pixels.iter().enumerate() {
            let [free, all] = block.weights.map(|weights| weights[lane]);
            open[pixel as usize] = if all > 0.0 { free / all } else { 1.0 };
        }
    }
    SkyVisibility { width: seen.width, height: seen.height, open }
}

/// The points of up to sixteen pixels, in view space.
fn block_of(view: &View, seen: &GBuffer, pixels: &[u32]) -> Block {
    let (grid, region) = (view.pixel_grid(), view.region());
    let mut points = Points::default();
    for (lane, &pixel) in pixels.iter().enumerate() {
        let (x, y) = (pixel % region.width + region.x, pixel / region.width + region.y);
        let (t, normal) = (seen.depth[pixel as usize], Vec3::from(seen.normal[pixel as usize]));
        let Ray { origin, direction } = grid.ray(grid.plane(x as f32 + 0.5, y as f32 + 0.5));
        let start = origin + direction * t + normal * start_offset(t);
        for axis in 0..3 {
            points.position[axis][lane] = start[axis];
            points.normal[axis][lane] = normal[axis];
        }
        points.asks[lane] = 1.0;
    }
    Block { points, ..Block::default() }
}

impl Block {
    /// Around its points.
    fn bounds(&self) -> Aabb {
        let [x, y, z] = &self.points.position;
        let asking = (0..LANES).filter(|&lane| self.points.asks[lane] > 0.0);
        let at = asking.map(|lane| Vec3::new(x[lane], y[lane], z[lane]));
        at.fold(Aabb::EMPTY, |all, p| all.union(Aabb { min: p, max: p }))
    }

    /// Adds what a part of the directions told of the sky.
    fn add(&mut self, view: &View, directions: &[Vec3]) {
        let view_from_world = view.camera.view_from_world();
        let mut all = [0.0; LANES];
        for direction in directions {
            let d = view_from_world.transform_vector3(*direction);
            let [x, y, z] = &self.points.normal;
            for (lane, all) in all.iter_mut().enumerate() {
                *all += max(x[lane] * d.x + y[lane] * d.y + z[lane] * d.z, 0.0);
            }
        }
        for (lane, all) in all.into_iter().enumerate() {
            self.weights[0][lane] += self.points.told[0][lane] * all;
            self.weights[1][lane] += all;
        }
    }
}

/// The points of all blocks, and the box around them.
struct Blocks<'a>(&'a [Block], Aabb);

impl Packets for Blocks<'_> {
    fn runs(&self) -> usize {
        1
    }

    fn len_of(&self, _run: usize) -> usize {
        self.0.len()
    }

    fn bounds(&self) -> Aabb {
        self.1
    }

    #[inline(always)]
    fn points(&self, _run: usize, packet: usize) -> Points {
        self.0[packet].points
    }
}

/// What some blocks, numbered from `first` on, are told, as work for [`widest`].
struct Tell<'a> {
    answers: &'a [Answers],
    blocks: &'a mut [Block],
    first: usize,
}

impl Work for Tell<'_> {
    #[inline(always)]
    fn run(self) {
        for (packet, block) in (self.first..).zip(self.blocks) {
            // Where nothing hides anything nobody asks.
            if let Some(answers) = self.answers.first() {
                answers.tell(packet, &mut block.points, Reach { open: 1.0, key: 1.0 });
            }
        }
    }
}
