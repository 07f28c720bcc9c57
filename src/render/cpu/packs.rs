//! Balls and sticks in packs of neighbours, so that what is out of the picture or behind something is left out pack by pack.
//!
//! The packs of a block are the same in all its placements and however the scene is turned: they are made once for a scene.
//! Neighbours are found along a space-filling curve (Morton's: the bits of the three coordinates in turn).
//!
//! A picture asks the box of every pack, and of those that may be seen each primitive: the cost is that of what is on the
//! screen, and a little for each pack. Everything else (cones, tori, triangles) is few, and goes the way of [`super::binning`].

use super::binning::{Bins, Candidate, Framing, share_out};
use super::facts::Fact;
use super::small::{Window, draw_balls, draw_sticks};
use super::source::{Facts, Source};
use super::tile::{Place, Tile};
use crate::math::Aabb;
use crate::render::settings::View;
use crate::render::solids::{Cylinder, Solids, Sphere, is_see_through};
use crate::scene::{Block, Scene};
use glam::{Affine3A, Vec3, Vec3A};
use rayon::prelude::*;

/// Balls and sticks of a pack. Chosen, other numbers were not tried: 32 atoms of a protein with their bonds are some 9 Å wide, and a million
/// atoms make 32,000 packs.
const MEMBERS: usize = 64;

/// Some neighbours: balls, then sticks.
#[derive(Debug, Clone, Copy)]
struct Pack {
    center: Vec3,
    /// Half the size of the box, radii included.
    half: Vec3,
    /// Where its members start in [`BlockPacks::members`].
    start: u32,
    spheres: u8,
    cylinders: u8,
}

/// The packs of a block, in its space.
#[derive(Debug, Default)]
struct BlockPacks {
    packs: Vec<Pack>,
    /// Indices into the spheres or the cylinders of the block.
    members: Vec<u32>,
}

/// The packs of a scene's blocks.
#[derive(Debug, Default)]
pub(super) struct Packs {
    blocks: Vec<BlockPacks>,
    is_opaque: bool,
}

impl Packs {
    pub(super) fn new(scene: &Scene) -> Packs {
        Packs { blocks: scene.blocks.iter().map(BlockPacks::new).collect(), is_opaque: !is_see_through(scene) }
    }

    /// Whether nothing in the scene is see-through.
    pub(super) fn is_opaque(&self) -> bool {
        self.is_opaque
    }
}

/// The lowest 21 bits, with two zeros between any two.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x) & 0x1f_ffff;
    for (shift, mask) in [
        (32, 0x1f_0000_0000_ffff),
        (16, 0x1f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

impl BlockPacks {
    fn new(block: &Block) -> BlockPacks {
        let (spheres, cylinders) = (&block.spheres, &block.cylinders);
        let Ok(first_cylinder) = u32::try_from(spheres.len()) else { return BlockPacks::default() };
        let middle = |i: usize| match cylinders.get(i.wrapping_sub(spheres.len())) {
            Some(cylinder) => (Vec3::from(cylinder.a) + Vec3::from(cylinder.b)) * 0.5,
            None => spheres[i].center.into(),
        };
        let bounds = |i: usize| match cylinders.get(i.wrapping_sub(spheres.len())) {
            Some(cylinder) => cylinder.bounds(),
            None => spheres[i].bounds(),
        };
        let count = spheres.len() + cylinders.len();
        let around = (0..count).into_par_iter().with_min_len(4096).map(|i| (middle(i), middle(i)));
        let join = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
        let (low, high) = around.reduce(|| (Vec3::INFINITY, Vec3::NEG_INFINITY), join);
        let scale = 2_097_151.0 / (high - low).max_element().max(1e-6);
        // Casts clamp, and make 0 of what is no number.
        let key = |i: usize| {
            let [x, y, z] = ((middle(i) - low) * scale).to_array().map(|x| spread(x as u32));
            (x | y << 1 | z << 2, i as u32)
        };
        let mut order: Vec<(u64, u32)> = (0..count).into_par_iter().with_min_len(4096).map(key).collect();
        order.par_sort_unstable();
        let chunk = |(number, chunk): (usize, &mut [(u64, u32)])| {
            chunk.sort_unstable_by_key(|&(_, i)| i);
            let around = chunk.iter().fold(Aabb::EMPTY, |all, &(_, i)| all.union(bounds(i as usize)));
            let spheres = chunk.iter().filter(|&&(_, i)| i < first_cylinder).count();
            Pack {
                center: around.center(),
                half: around.size() * 0.5,
                start: (number * MEMBERS) as u32,
                spheres: spheres as u8,
                cylinders: (chunk.len() - spheres) as u8,
            }
        };
        let packs = order.par_chunks_mut(MEMBERS).enumerate().with_min_len(64).map(chunk).collect();
        let member = |&(_, i): &(u64, u32)| if i < first_cylinder { i } else { i - first_cylinder };
        BlockPacks { packs, members: order.iter().map(member).collect() }
    }
}

/// A pack that reaches into the picture.
#[derive(Debug, Clone, Copy)]
struct Seen {
    nearest: f32,
    pixels: [u16; 4],
    placement: u32,
    pack: u32,
}

/// A block where a view sees it.
pub(super) struct Placed<'a> {
    pub(super) block: &'a Block,
    packs: &'a BlockPacks,
    pub(super) view_from_block: Affine3A,
    /// Numbers of its first ball and stick in the scene.
    pub(super) first_sphere: u32,
    pub(super) first_cylinder: u32,
}

/// The packs that a view sees, tile by tile from front to back, and everything that is neither ball nor stick.
pub(super) struct Packed<'a> {
    placed: Vec<Placed<'a>>,
    /// Balls and sticks in the scene.
    spheres: u32,
    simple: u32,
    framing: Framing,
    seen: Vec<Seen>,
    /// Of each tile, where its packs start in `list`.
    first: Vec<u32>,
    list: Vec<u32>,
    others: &'a Solids,
    other_bins: Bins,
}

impl<'a> Packed<'a> {
    /// `others` are all cones, tori and triangles of the scene, in view space.
    pub(super) fn new(scene: &'a Scene, packs: &'a Packs, others: &'a Solids, view: &View, tile: u32) -> Packed<'a> {
        let framing = Framing::new(view);
        let (mut placed, mut spheres, mut cylinders) = (Vec::with_capacity(scene.placements.len()), 0u32, 0u32);
        let view_from_world = view.camera.view_from_world();
        for placement in &scene.placements {
            let block = &scene.blocks[placement.block];
            placed.push(Placed {
                block,
                packs: &packs.blocks[placement.block],
                view_from_block: view_from_world * placement.world_from_block,
                first_sphere: spheres,
                first_cylinder: cylinders,
            });
            spheres = spheres.saturating_add(block.spheres.len() as u32);
            cylinders = cylinders.saturating_add(block.cylinders.len() as u32);
        }
        for placed in &mut placed {
            placed.first_cylinder = placed.first_cylinder.saturating_add(spheres);
        }
        let seen = placed.par_iter().enumerate().flat_map(|(placement, placed)| {
            let packs = placed.packs.packs.par_iter().enumerate().with_min_len(4096);
            packs.filter_map(move |(number, pack)| {
                let half = (placed.view_from_block.matrix3.abs() * Vec3A::from(pack.half)).into();
                let (nearest, pixels) = framing.boxed(placed.view_from_block.transform_point3(pack.center), half)?;
                Some(Seen { nearest, pixels, placement: placement as u32, pack: number as u32 })
            })
        });
        let mut seen: Vec<Seen> = seen.collect();
        seen.par_sort_unstable_by(|a, b| a.nearest.total_cmp(&b.nearest));
        let other_bins = Bins::new(others, None, view, tile);
        let (first, list) = share_out(tile, other_bins.tiles, seen.iter().map(|pack| pack.pixels));
        let simple = spheres.saturating_add(cylinders);
        Packed { placed, spheres, simple, framing, seen, first, list, others, other_bins }
    }

    /// Where a ball or stick stands: its placement, and its index in the block.
    #[inline(always)]
    fn place_of(&self, index: u32) -> (&Placed<'a>, usize) {
        let first =
            |placed: &Placed<'_>| if index < self.spheres { placed.first_sphere } else { placed.first_cylinder };
        let placed = match self.placed.len() {
            1 => &self.placed[0],
            // Of placements without any the last one starts where the next does.
            _ => &self.placed[self.placed.partition_point(|placed| first(placed) <= index).saturating_sub(1)],
        };
        (placed, (index - first(placed)) as usize)
    }

    #[inline(always)]
    fn see_as<const PARALLEL: bool>(
        &self,
        tile: &mut Tile,
        candidates: &mut Vec<Candidate>,
        place: &Place<'_>,
        number: usize,
    ) {
        let window = Window::new(place);
        let list = &self.list[self.first[number] as usize..self.first[number + 1] as usize];
        for (asked, &seen) in list.iter().enumerate() {
            let Seen { nearest, pixels, placement, pack } = self.seen[seen as usize];
            if asked % 16 == 15 && nearest > tile.farthest() {
                break; // the rest is behind everything
            }
            if tile.hides(place, nearest, pixels) {
                continue;
            }
            let placed = &self.placed[placement as usize];
            let pack = &placed.packs.packs[pack as usize];
            let members =
                &placed.packs.members[pack.start as usize..][..usize::from(pack.spheres) + usize::from(pack.cylinders)];
            let (spheres, cylinders) = members.split_at(usize::from(pack.spheres));
            draw_balls::<PARALLEL>((tile, place), (&window, &self.framing), placed, spheres);
            draw_sticks::<PARALLEL>((tile, place), (&window, &self.framing), placed, cylinders);
        }
        self.other_bins.of_tile(number, candidates);
        for candidate in candidates.iter_mut() {
            candidate.index += self.simple;
            tile.draw_other::<PARALLEL>(place, self.others, self.simple, candidate);
        }
    }
}

impl Source for Packed<'_> {
    fn is_empty(&self, tile: usize) -> bool {
        self.first[tile] == self.first[tile + 1] && self.other_bins.is_empty(tile)
    }

    #[inline(always)]
    fn see(&self, tile: &mut Tile, candidates: &mut Vec<Candidate>, place: &Place<'_>, number: usize) {
        tile.clear(place);
        if place.grid.orthographic {
            self.see_as::<true>(tile, candidates, place, number);
        } else {
            self.see_as::<false>(tile, candidates, place, number);
        }
    }
}

impl Facts for Packed<'_> {
    fn simple(&self) -> u32 {
        self.simple
    }

    fn first_of_shader(&self) -> u32 {
        self.simple
    }

    fn fact(&self, index: u32) -> Fact {
        let (placed, i) = self.place_of(index);
        if index < self.spheres {
            let instance = &placed.block.spheres[i];
            return Fact::of_sphere(&Sphere::new(instance, &placed.view_from_block), instance.color);
        }
        let instance = &placed.block.cylinders[i];
        match Cylinder::new(instance, &placed.view_from_block) {
            Some(cylinder) => Fact::of_cylinder(&cylinder, [instance.color_a, instance.color_b]),
            None => Fact::Other,
        }
    }
}

#[cfg(test)]
#[path = "packs_tests.rs"]
mod tests;
