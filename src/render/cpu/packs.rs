//! Balls, sticks and rings in packs of neighbours, so that what is out of the picture or behind something is left out pack by pack.
//!
//! The packs of a block are the same in all its placements and however the scene is turned: they are made once for a scene.
//! Neighbours are found along a space-filling curve (Morton's: the bits of the three coordinates in turn).
//!
//! A picture asks the box of every pack, and of those that may be seen each primitive: the cost is that of what is on the
//! screen, and a little for each pack. Everything else (cones, triangles) is few, and goes the way of [`super::binning`].

use super::binning::{Bins, Candidate, Framing, share_out};
use super::facts::Fact;
use super::intersect::FLAT_CAPS;
use super::lanes::{LANES, Lanes};
use super::small::{Queues, Window, draw_balls, draw_sticks};
use super::source::{Facts, Source};
use super::tile::{Place, Tile};
use crate::color::Srgb8;
use crate::math::Aabb;
use crate::render::outline::Outline;
use crate::render::settings::View;
use crate::render::solids::{Cylinder, Solids, Sphere, Torus, is_see_through};
use crate::scene::{Block, CylinderInstance, Scene, SphereInstance, TorusInstance};
use glam::{Affine3A, Vec3, Vec3A};
use rayon::prelude::*;

/// Balls, sticks and rings of a pack. Chosen, other numbers were not tried: 32 atoms of a protein with their bonds are some 9 Å wide, and a million
/// atoms make 32,000 packs.
const MEMBERS: usize = 64;

/// Some neighbours: balls, then sticks, then rings.
#[derive(Debug, Clone, Copy)]
struct Pack {
    center: Vec3,
    /// Half the size of the box, radii included.
    half: Vec3,
    /// Where its members start in [`BlockPacks::members`].
    start: u32,
    /// Where its balls and its sticks start in [`BlockPacks::balls`] and [`BlockPacks::sticks`].
    first_ball: u32,
    first_stick: u32,
    spheres: u8,
    cylinders: u8,
    tori: u8,
    /// Whether all sticks have flat caps.
    are_flat: bool,
}

/// The packs of a block, in its space.
#[derive(Debug, Default)]
struct BlockPacks {
    packs: Vec<Pack>,
    /// Indices into the spheres, the cylinders or the tori of the block.
    members: Vec<u32>,
    /// Centres and radii of the balls in the order of the packs: 16 bytes a ball so that sixteen are read at once. [`LANES`] more at the
    /// end.
    balls: [Vec<f32>; 4],
    /// Ends and radii of the sticks likewise, 28 bytes each.
    sticks: [Vec<f32>; 7],
    /// Colours of the balls and of the halves of the sticks in the same order, 4 and 8 bytes each.
    ball_colors: Vec<Srgb8>,
    stick_colors: Vec<[Srgb8; 2]>,
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
        let (spheres, cylinders, tori) = (&block.spheres, &block.cylinders, &block.tori);
        let first_torus = spheres.len() + cylinders.len();
        let count = first_torus + tori.len();
        let (Ok(first_cylinder), Ok(_)) = (u32::try_from(spheres.len()), u32::try_from(count)) else {
            return BlockPacks::default();
        };
        let kind = |i: usize| match i {
            _ if i >= first_torus => Member::Torus(&tori[i - first_torus]),
            _ if i >= spheres.len() => Member::Cylinder(&cylinders[i - spheres.len()]),
            _ => Member::Sphere(&spheres[i]),
        };
        let middle = |i: usize| match kind(i) {
            Member::Sphere(sphere) => sphere.center.into(),
            Member::Cylinder(cylinder) => (Vec3::from(cylinder.a) + Vec3::from(cylinder.b)) * 0.5,
            Member::Torus(torus) => torus.center.into(),
        };
        let bounds = |i: usize| match kind(i) {
            Member::Sphere(sphere) => sphere.bounds(),
            Member::Cylinder(cylinder) => cylinder.bounds(),
            Member::Torus(torus) => torus.bounds(),
        };
        let around = (0..count).into_par_iter().with_min_len(4096).map(|i| (middle(i), middle(i)));
        let join = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
        let (low, high) = around.reduce(|| (Vec3::INFINITY, Vec3::NEG_INFINITY), join);
        // The place on the curve, as finely as there is room beside the index: one number is sorted faster than two.
        let index_bits = usize::BITS - count.leading_zeros();
        let side = (1u32 << ((64 - index_bits) / 3)) - 1;
        let scale = side as f32 / (high - low).max_element().max(1e-6);
        // Casts clamp, and make 0 of what is no number.
        let key = |i: usize| {
            let [x, y, z] = ((middle(i) - low) * scale).to_array().map(|x| spread((x as u32).min(side)));
            (x | y << 1 | z << 2) << index_bits | i as u64
        };
        let mut keys: Vec<u64> = (0..count).into_par_iter().with_min_len(4096).map(key).collect();
        keys.par_sort_unstable();
        let index = |&key: &u64| (key & ((1 << index_bits) - 1)) as u32;
        let mut order: Vec<u32> = keys.par_iter().with_min_len(4096).map(index).collect();
        drop(keys);
        let chunk = |(number, chunk): (usize, &mut [u32])| {
            chunk.sort_unstable();
            let around = chunk.iter().fold(Aabb::EMPTY, |all, &i| all.union(bounds(i as usize)));
            let before = |end: usize| chunk.iter().filter(|&&i| (i as usize) < end).count();
            let (spheres, simple) = (before(first_cylinder as usize), before(first_torus));
            Pack {
                center: around.center(),
                half: around.size() * 0.5,
                start: (number * MEMBERS) as u32,
                first_ball: 0,
                first_stick: 0,
                spheres: spheres as u8,
                cylinders: (simple - spheres) as u8,
                tori: (chunk.len() - simple) as u8,
                are_flat: chunk[spheres..simple].iter().all(|&i| match kind(i as usize) {
                    Member::Cylinder(cylinder) => cylinder.caps == FLAT_CAPS,
                    Member::Sphere(_) | Member::Torus(_) => true,
                }),
            }
        };
        let mut packs: Vec<Pack> = order.par_chunks_mut(MEMBERS).enumerate().with_min_len(64).map(chunk).collect();
        let (mut first_ball, mut first_stick) = (0, 0);
        for pack in &mut packs {
            (pack.first_ball, pack.first_stick) = (first_ball, first_stick);
            first_ball += u32::from(pack.spheres);
            first_stick += u32::from(pack.cylinders);
        }
        // In their order.
        let (mut ball_order, mut stick_order) =
            (Vec::with_capacity(spheres.len()), Vec::with_capacity(cylinders.len()));
        for &i in &order {
            match (i as usize).checked_sub(spheres.len()) {
                None => ball_order.push(i),
                Some(i) if i < cylinders.len() => stick_order.push(i as u32),
                Some(_) => {}
            }
        }
        // With some more that nobody looks at.
        let numbers = |order: &[u32], number: &(dyn Fn(usize) -> f32 + Sync)| {
            let mut numbers = vec![0.0; order.len() + LANES];
            let places = numbers.par_iter_mut().zip(order).with_min_len(4096);
            places.for_each(|(place, &i)| *place = number(i as usize));
            numbers
        };
        let ball = |number: fn(&SphereInstance) -> f32| numbers(&ball_order, &|i| number(&spheres[i]));
        let stick = |number: fn(&CylinderInstance) -> f32| numbers(&stick_order, &|i| number(&cylinders[i]));
        let balls = [ball(|s| s.center[0]), ball(|s| s.center[1]), ball(|s| s.center[2]), ball(|s| s.radius)];
        let sticks = [
            stick(|c| c.a[0]),
            stick(|c| c.a[1]),
            stick(|c| c.a[2]),
            stick(|c| c.b[0]),
            stick(|c| c.b[1]),
            stick(|c| c.b[2]),
            stick(|c| c.radius),
        ];
        let of_ball = ball_order.par_iter().with_min_len(4096);
        let ball_colors = of_ball.map(|&i| spheres[i as usize].color).collect();
        let of_stick = stick_order.par_iter().with_min_len(4096);
        let stick_colors = of_stick.map(|&i| &cylinders[i as usize]).map(|c| [c.color_a, c.color_b]).collect();
        let own = |i: u32| match kind(i as usize) {
            Member::Sphere(_) => i,
            Member::Cylinder(_) => i - first_cylinder,
            Member::Torus(_) => i - first_torus as u32,
        };
        let members = order.par_iter().with_min_len(4096).map(|&i| own(i)).collect();
        BlockPacks { packs, members, balls, sticks, ball_colors, stick_colors }
    }
}

/// What is in a pack.
enum Member<'a> {
    Sphere(&'a SphereInstance),
    Cylinder(&'a CylinderInstance),
    Torus(&'a TorusInstance),
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
    first_id: u32,
    /// Numbers of its first ball, stick and ring in the scene.
    pub(super) first_sphere: u32,
    pub(super) first_cylinder: u32,
    pub(super) first_torus: u32,
}

impl Placed<'_> {
    /// [`LANES`] balls of the packs: coordinates of their centres, and their radii.
    #[inline(always)]
    pub(super) fn balls(&self, first: usize) -> [&Lanes; 4] {
        let [x, y, z, radius] = &self.packs.balls;
        [lanes_at(x, first), lanes_at(y, first), lanes_at(z, first), lanes_at(radius, first)]
    }

    /// The colour of a ball of the packs.
    #[inline(always)]
    pub(super) fn ball_color(&self, number: usize) -> Srgb8 {
        self.packs.ball_colors.get(number).copied().unwrap_or(Srgb8::BLACK)
    }

    /// The colours of the halves of a stick of the packs.
    #[inline(always)]
    pub(super) fn stick_colors(&self, number: usize) -> [Srgb8; 2] {
        self.packs.stick_colors.get(number).copied().unwrap_or([Srgb8::BLACK; 2])
    }

    /// [`LANES`] sticks of the packs: coordinates of both their ends, and their radii.
    #[inline(always)]
    pub(super) fn sticks(&self, first: usize) -> ([[&Lanes; 3]; 2], &Lanes) {
        let [ax, ay, az, bx, by, bz, radius] = &self.packs.sticks;
        let a = [lanes_at(ax, first), lanes_at(ay, first), lanes_at(az, first)];
        let b = [lanes_at(bx, first), lanes_at(by, first), lanes_at(bz, first)];
        ([a, b], lanes_at(radius, first))
    }
}

#[inline(always)]
fn lanes_at(lanes: &[f32], first: usize) -> &Lanes {
    // There always are as many.
    lanes.get(first..).and_then(|lanes| lanes.first_chunk()).unwrap_or(&[0.0; LANES])
}

/// The packs that a view sees, tile by tile from front to back, and everything that is neither ball, stick nor ring.
pub(super) struct Packed<'a> {
    placed: Vec<Placed<'a>>,
    /// Where sticks, cones, rings and triangles of the scene are numbered from: in this order, after the balls.
    first_cylinder: u32,
    first_cone: u32,
    first_torus: u32,
    first_triangle: u32,
    framing: Framing,
    /// Lines around things.
    outline: Option<Outline>,
    seen: Vec<Seen>,
    /// Of each tile, where its packs start in `list`.
    first: Vec<u32>,
    list: Vec<u32>,
    others: &'a Solids,
    other_bins: Bins,
}

impl<'a> Packed<'a> {
    /// `others` are all cones and triangles of the scene, in view space.
    pub(super) fn new(
        scene: &'a Scene,
        packs: &'a Packs,
        others: &'a Solids,
        outline: Option<&Outline>,
        (view, tile): (&View, u32),
    ) -> Packed<'a> {
        let framing = Framing::new(view);
        let mut placed = Vec::with_capacity(scene.placements.len());
        let (mut spheres, mut cylinders, mut tori) = (0u32, 0u32, 0u32);
        let view_from_world = view.camera.view_from_world();
        for placement in &scene.placements {
            let block = &scene.blocks[placement.block];
            placed.push(Placed {
                block,
                packs: &packs.blocks[placement.block],
                view_from_block: view_from_world * placement.world_from_block,
                first_id: placement.first_id,
                first_sphere: spheres,
                first_cylinder: cylinders,
                first_torus: tori,
            });
            spheres = spheres.saturating_add(block.spheres.len() as u32);
            cylinders = cylinders.saturating_add(block.cylinders.len() as u32);
            tori = tori.saturating_add(block.tori.len() as u32);
        }
        let first_cylinder = spheres;
        let first_cone = first_cylinder.saturating_add(cylinders);
        let first_torus = first_cone.saturating_add(others.cones.len() as u32);
        let first_triangle = first_torus.saturating_add(tori);
        for placed in &mut placed {
            placed.first_cylinder = placed.first_cylinder.saturating_add(first_cylinder);
            placed.first_torus = placed.first_torus.saturating_add(first_torus);
        }
        let seen = placed.par_iter().enumerate().flat_map(|(placement, placed)| {
            let packs = placed.packs.packs.par_iter().enumerate().with_min_len(4096);
            packs.filter_map(move |(number, pack)| {
                let center = placed.view_from_block.transform_point3(pack.center);
                let mut half: Vec3 = (placed.view_from_block.matrix3.abs() * Vec3A::from(pack.half)).into();
                if let Some(outline) = outline {
                    // No radius is greater than half the box's narrowest side, and no line wider than that of the farthest.
                    half += outline.width(center.with_z(center.z - half.z), pack.half.min_element());
                }
                let (nearest, pixels) = framing.boxed(center, half)?;
                Some(Seen { nearest, pixels, placement: placement as u32, pack: number as u32 })
            })
        });
        let mut seen: Vec<Seen> = seen.collect();
        seen.par_sort_unstable_by(|a, b| a.nearest.total_cmp(&b.nearest));
        let other_bins = Bins::new(others, outline, view, tile);
        let (first, list) = share_out(tile, other_bins.tiles, seen.iter().map(|pack| pack.pixels));
        Packed {
            placed,
            first_cylinder,
            first_cone,
            first_torus,
            first_triangle,
            framing,
            outline: outline.copied(),
            seen,
            first,
            list,
            others,
            other_bins,
        }
    }

    /// Where a ball, stick or ring stands: its placement, and its index in the block.
    #[inline(always)]
    fn place_of(&self, index: u32, first: impl Fn(&Placed<'_>) -> u32) -> (&Placed<'a>, usize) {
        let placed = match self.placed.len() {
            1 => &self.placed[0],
            // Of placements without any the last one starts where the next does.
            _ => &self.placed[self.placed.partition_point(|placed| first(placed) <= index).saturating_sub(1)],
        };
        (placed, (index - first(placed)) as usize)
    }

    /// A pack where it stands: its balls, sticks and rings by their numbers in the block.
    #[inline(always)]
    fn opened(&self, placement: u32, pack: u32) -> (&Placed<'a>, &Pack, [&[u32]; 3]) {
        let placed = &self.placed[placement as usize];
        let pack = &placed.packs.packs[pack as usize];
        let members = &placed.packs.members[pack.start as usize..];
        let (spheres, members) = members.split_at(usize::from(pack.spheres));
        let (cylinders, members) = members.split_at(usize::from(pack.cylinders));
        (placed, pack, [spheres, cylinders, &members[..usize::from(pack.tori)]])
    }

    #[inline(always)]
    fn see_as<const PARALLEL: bool>(
        &self,
        tile: &mut Tile,
        candidates: &mut Vec<Candidate>,
        place: &Place<'_>,
        number: usize,
    ) {
        let (window, mut queues) = (Window::new(place), Queues::new());
        let list = &self.list[self.first[number] as usize..self.first[number + 1] as usize];
        for (asked, &seen) in list.iter().enumerate() {
            let Seen { nearest, pixels, placement, pack } = self.seen[seen as usize];
            if asked % 16 == 15 && nearest > tile.farthest() {
                break; // the rest is behind everything
            }
            if tile.hides(place, nearest, pixels) {
                continue;
            }
            let (placed, pack, [spheres, cylinders, tori]) = self.opened(placement, pack);
            let (first_ball, first_stick) = (pack.first_ball as usize, pack.first_stick as usize);
            draw_balls::<PARALLEL>((tile, place, &mut queues), (&window, &self.framing), placed, (first_ball, spheres));
            draw_sticks::<PARALLEL>(
                (tile, place, &mut queues),
                (&window, &self.framing),
                placed,
                (first_stick, cylinders, pack.are_flat),
            );
            self.draw_rings::<PARALLEL>((tile, place), placed, tori);
        }
        queues.draw::<PARALLEL>(tile, place);
        self.other_bins.of_tile(number, candidates);
        for candidate in candidates.iter_mut() {
            let number = candidate.index;
            candidate.index = self.of_scene(number);
            tile.draw_other::<PARALLEL>(place, (self.others, number), candidate);
        }
    }

    /// What a cone or triangle of the others is in the scene.
    #[inline(always)]
    fn of_scene(&self, number: u32) -> u32 {
        let is_cone = (number as usize) < self.others.cones.len();
        let before = if is_cone { self.first_cone } else { self.first_triangle - self.others.cones.len() as u32 };
        number + before
    }

    /// Whether its members are more than opaque primitives without lines.
    pub(super) fn is_any(&self) -> bool {
        self.outline.is_some() || self.others.see_through
    }

    /// Draws some rings of a block in a tile.
    #[inline(always)]
    fn draw_rings<const PARALLEL: bool>(
        &self,
        (tile, place): (&mut Tile, &Place<'_>),
        placed: &Placed<'_>,
        members: &[u32],
    ) {
        for &i in members {
            let instance = &placed.block.tori[i as usize];
            let Some(torus) = Torus::new(instance, &placed.view_from_block) else { continue };
            let index = placed.first_torus + i;
            let around = Sphere { center: torus.center, radius: torus.ring_radius + torus.tube_radius };
            let Some(whole) = self.framing.sphere(index, &around) else { continue };
            if tile.hides(place, whole.nearest, whole.pixels) {
                continue;
            }
            if whole.pixels[2] - whole.pixels[0] <= SMALL_RING {
                tile.draw_torus::<PARALLEL>(place, &whole, (&torus, instance.color));
                continue;
            }
            for piece in self.framing.torus(index, torus) {
                tile.draw_torus::<PARALLEL>(place, &piece, (&torus, instance.color));
            }
        }
    }
}

/// Rings of no more pixels are not drawn in pieces: all would lie in the same few blocks of samples. Chosen.
const SMALL_RING: u16 = 12;

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
    fn of_shader(&self, index: u32) -> u32 {
        let is_cone = index < self.first_torus;
        if is_cone { index - self.first_cone } else { index - self.first_triangle + self.others.cones.len() as u32 }
    }

    fn tells_looks(&self) -> bool {
        true
    }

    fn fact(&self, index: u32) -> Fact {
        match self.member(index) {
            Some((placed, Member::Sphere(instance))) => {
                Fact::of_sphere(&Sphere::new(instance, &placed.view_from_block), instance.color)
            }
            Some((placed, Member::Cylinder(instance))) => {
                let stick = Cylinder::new(instance, &placed.view_from_block);
                let colors = [instance.color_a, instance.color_b];
                stick.map_or(Fact::Other, |stick| Fact::of_cylinder(&stick, colors))
            }
            Some((placed, Member::Torus(instance))) => {
                let torus = Torus::new(instance, &placed.view_from_block);
                torus.map_or(Fact::Other, |torus| Fact::of_torus(&torus, instance.color))
            }
            None => Fact::Other,
        }
    }

    fn behind(&self, outline: &Outline, index: u32) -> f32 {
        match self.member(index) {
            Some((_, Member::Sphere(instance))) => outline.behind_radius(instance.radius),
            Some((_, Member::Cylinder(instance))) => outline.behind_radius(instance.radius),
            Some((_, Member::Torus(instance))) => outline.behind_radius(instance.tube_radius),
            None => outline.behind(self.others, self.of_shader(index) as usize),
        }
    }

    fn alone(&self, index: u32) -> Option<Solids> {
        let mut alone = Solids { see_through: self.others.see_through, ..Solids::default() };
        let (placed, member) = match self.member(index) {
            Some(member) => member,
            None => {
                let number = self.of_shader(index) as usize;
                alone.push(self.others, number);
                return Some(alone);
            }
        };
        let (to_view, first_id) = (&placed.view_from_block, placed.first_id);
        match member {
            Member::Sphere(instance) => alone.push_sphere(instance, to_view, first_id),
            Member::Cylinder(instance) => _ = alone.push_cylinder(instance, to_view, first_id),
            Member::Torus(instance) => _ = alone.push_torus(instance, to_view, first_id),
        }
        Some(alone)
    }
}

impl Packed<'_> {
    /// A ball, stick or ring and where it stands; `None` for all else.
    #[inline(always)]
    fn member(&self, index: u32) -> Option<(&Placed<'_>, Member<'_>)> {
        if index < self.first_cylinder {
            let (placed, i) = self.place_of(index, |placed| placed.first_sphere);
            return Some((placed, Member::Sphere(&placed.block.spheres[i])));
        }
        if index < self.first_cone {
            let (placed, i) = self.place_of(index, |placed| placed.first_cylinder);
            return Some((placed, Member::Cylinder(&placed.block.cylinders[i])));
        }
        if (self.first_torus..self.first_triangle).contains(&index) {
            let (placed, i) = self.place_of(index, |placed| placed.first_torus);
            return Some((placed, Member::Torus(&placed.block.tori[i])));
        }
        None
    }
}

/// Packs whose members have lines or may be see-through: made in view space pack by pack. On their own, to leave the others' code short.
pub(super) struct Any<'a>(pub(super) Packed<'a>);

impl Any<'_> {
    #[inline(always)]
    fn see_as<const PARALLEL: bool>(
        &self,
        tile: &mut Tile,
        candidates: &mut Vec<Candidate>,
        place: &Place<'_>,
        number: usize,
    ) {
        let Any(packed) = self;
        let mut solids = Solids { see_through: packed.others.see_through, ..Solids::default() };
        let list = &packed.list[packed.first[number] as usize..packed.first[number + 1] as usize];
        for (asked, &seen) in list.iter().enumerate() {
            let Seen { nearest, pixels, placement, pack } = packed.seen[seen as usize];
            if asked % 16 == 15 && nearest > tile.farthest() {
                break; // the rest is behind everything
            }
            if tile.hides(place, nearest, pixels) {
                continue;
            }
            let (placed, _, members) = packed.opened(placement, pack);
            self.draw_members::<PARALLEL>((tile, place), placed, &mut solids, members);
        }
        packed.other_bins.of_tile(number, candidates);
        for candidate in candidates.iter_mut() {
            let number = candidate.index as usize;
            candidate.index = packed.of_scene(candidate.index);
            tile.draw_any::<PARALLEL>(place, (packed.others, number), candidate);
        }
    }

    /// Draws balls, sticks and rings of a block that have lines or may be see-through; `solids` is room to work in.
    #[inline(always)]
    fn draw_members<const PARALLEL: bool>(
        &self,
        (tile, place): (&mut Tile, &Place<'_>),
        placed: &Placed<'_>,
        solids: &mut Solids,
        [spheres, cylinders, tori]: [&[u32]; 3],
    ) {
        let (block, to_view, first_id) = (placed.block, &placed.view_from_block, placed.first_id);
        solids.clear_simple();
        spheres.iter().for_each(|&i| solids.push_sphere(&block.spheres[i as usize], to_view, first_id));
        let numbers = spheres.iter().map(|i| placed.first_sphere + i);
        let is_stick = |&&i: &&u32| solids.push_cylinder(&block.cylinders[i as usize], to_view, first_id);
        let sticks: Vec<u32> = cylinders.iter().filter(is_stick).map(|i| placed.first_cylinder + i).collect();
        for (number, index) in numbers.chain(sticks).enumerate() {
            let Some(mut candidate) = self.0.framing.primitive(solids, number, self.0.outline.as_ref()) else {
                continue;
            };
            candidate.index = index;
            if !tile.hides(place, candidate.nearest, candidate.pixels) {
                tile.draw_any::<PARALLEL>(place, (solids, number), &candidate);
            }
        }
        for &i in tori {
            if !solids.push_torus(&block.tori[i as usize], to_view, first_id) {
                continue;
            }
            let number = solids.len() - 1;
            let Some(torus) = solids.tori.last().map(|torus| self.0.outline.map_or(*torus, |line| line.torus(torus)))
            else {
                continue;
            };
            for piece in self.0.framing.torus(placed.first_torus + i, torus) {
                tile.draw_any::<PARALLEL>(place, (solids, number), &piece);
            }
        }
    }
}

impl Source for Any<'_> {
    fn is_empty(&self, tile: usize) -> bool {
        self.0.is_empty(tile)
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

impl Facts for Any<'_> {
    fn of_shader(&self, index: u32) -> u32 {
        self.0.of_shader(index)
    }

    fn tells_looks(&self) -> bool {
        false // lines are not told apart there
    }

    fn fact(&self, index: u32) -> Fact {
        self.0.fact(index)
    }

    fn behind(&self, outline: &Outline, index: u32) -> f32 {
        self.0.behind(outline, index)
    }

    fn alone(&self, index: u32) -> Option<Solids> {
        self.0.alone(index)
    }
}

#[cfg(test)]
#[path = "packs_tests.rs"]
mod tests;
