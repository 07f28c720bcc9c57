//! What may hide the light from afar in a scene of copies, asked of one copy of each block.
//!
//! As in [`super::clusters`] sixteen neighbours are a cluster, and here sixteen clusters a bunch, both in the space of their block and
//! made once for it. A direction has only the boxes of the placements' bunches in its tubes, some hundredth of the bytes of what
//! they stand for. The points' coordinates along the direction's axes are the same numbers in every space that keeps distances: of a bunch
//! that is near, the clusters are asked along the axes as its block sees them, and no primitive is ever moved.
//!
//! Limit: what is neither ball nor stick, or see-through, is asked one by one, and of points that ask nothing is known about whose surface
//! they lie on: they start above it ([`crate::render::sky::start_offset`]), as in the reference.

use super::behind::{Mask, behind};
use super::casters::{Axes, Body, Starts};
use super::clusters::{Around, Asked, Cluster, Sight, bits, gather, lanes_of};
use super::lanes::{LANES, Lanes};
use super::reach::{NOBODY, Points};
use crate::math::Aabb;
use crate::render::field::Field;
use crate::render::opacity::hides_in_sample;
use crate::render::tubes::Span;
use crate::scene::Scene;
use glam::{Affine3A, Vec3, Vec3A};
use rayon::prelude::*;
use std::sync::Arc;

/// Members of a bunch.
const BUNCH: usize = LANES;

/// Up to [`BUNCH`] clusters, or as many lots of [`LANES`] primitives that are asked one by one, and their boxes.
#[derive(Debug)]
struct Bunch {
    around: Aabb,
    center: [Lanes; 3],
    half: [Lanes; 3],
    /// Number of its first member: clusters first, then lots of others.
    first: u32,
    count: u32,
}

/// What is asked one by one: its number in the block, and a ball around it.
#[derive(Debug, Clone, Copy)]
struct Other {
    center: Vec3,
    reach: f32,
    index: u32,
}

/// A block in its own space.
#[derive(Debug)]
struct OfBlock {
    field: Arc<Field>,
    clusters: Vec<Cluster>,
    others: Vec<Other>,
    bunches: Vec<Bunch>,
}

/// A block where it stands.
#[derive(Debug)]
struct Placed {
    block: usize,
    block_from_world: Affine3A,
    first_id: u32,
}

/// The bunches of a scene.
#[derive(Debug)]
pub(super) struct Copies {
    blocks: Vec<OfBlock>,
    placed: Vec<Placed>,
    /// Placement and number of each bunch.
    bunches: Vec<(u32, u32)>,
}

/// The same in a view.
pub(super) struct InView<'a> {
    copies: &'a Copies,
    block_from_view: Vec<Affine3A>,
}

/// The bunches of a view, asked along a direction in a sample of so many.
struct AskBunches<'a> {
    view: &'a InView<'a>,
    /// See [`InView::axes`].
    axes: &'a [Axes],
    at: &'a Starts,
    points: &'a Points,
    of: [u32; 2],
}

impl Asked for AskBunches<'_> {
    #[inline(always)]
    fn leave(&self, number: u32, around: &Around, mut alive: u32) -> u32 {
        let copies = self.view.copies;
        let (placement, bunch) = copies.bunches[number as usize];
        let axes = &self.axes[placement as usize];
        let block = &copies.blocks[copies.placed[placement as usize].block];
        let bunch = &block.bunches[bunch as usize];
        let mut near = bunch.near(axes, around);
        while near != 0 {
            let member = bunch.first as usize + near.trailing_zeros() as usize;
            near &= near - 1;
            alive = match block.clusters.get(member) {
                Some(cluster) => cluster.seen(axes).leave(self.at, alive),
                None => self.leave_others(block, member - block.clusters.len(), placement, alive),
            };
            if alive == 0 {
                return 0;
            }
        }
        alive
    }
}

impl AskBunches<'_> {
    /// As [`Asked::leave`], of a lot of what is asked one by one. On its own, for it is seldom.
    #[inline(never)]
    fn leave_others(&self, block: &OfBlock, lot: usize, placement: u32, mut alive: u32) -> u32 {
        let axes = &self.axes[placement as usize];
        for other in block.others.get(lot * LANES..).unwrap_or_default().iter().take(LANES) {
            let near = alive & other.near(axes, self.at);
            if near != 0 {
                let mut free = lanes_of(near);
                self.view.exactly([placement, other.index], axes.toward, self.points, self.of, &mut free);
                alive = (alive & !near) | bits(|lane| free[lane] != 0);
            }
        }
        alive
    }
}

impl OfBlock {
    fn new(field: &Arc<Field>) -> OfBlock {
        let solids = field.solids();
        let (mut simple, mut others): (Vec<Body>, Vec<Body>) =
            Body::all(solids).into_iter().partition(|body| body.radius >= 0.0);
        for bodies in [&mut simple, &mut others] {
            gather(bodies, BUNCH * LANES);
            bodies.par_chunks_mut(BUNCH * LANES).for_each(|bunch| gather(bunch, LANES));
        }
        let mut bunches = Vec::new();
        let mut first = 0u32;
        for bodies in [&simple, &others] {
            for bunch in bodies.chunks(BUNCH * LANES) {
                let box_of = |members: &[Body]| {
                    members.iter().fold(Aabb::EMPTY, |all, body| all.union(solids.box_of(body.index as usize)))
                };
                let boxes: Vec<Aabb> = bunch.chunks(LANES).map(box_of).collect();
                bunches.push(Bunch::new(&boxes, first));
                first += boxes.len() as u32;
            }
        }
        let other = |body: &Body| {
            let around = solids.box_of(body.index as usize);
            Other { center: around.center(), reach: 0.5 * around.size().length(), index: body.index }
        };
        OfBlock {
            field: Arc::clone(field),
            clusters: simple.par_chunks(LANES).map(Cluster::new).collect(),
            others: others.iter().map(other).collect(),
            bunches,
        }
    }
}

impl Bunch {
    fn new(boxes: &[Aabb], first: u32) -> Bunch {
        let (mut center, mut half) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for (lane, around) in boxes.iter().enumerate().take(LANES) {
            let (middle, reach) = (around.center(), around.size() * 0.5);
            for axis in 0..3 {
                (center[axis][lane], half[axis][lane]) = (middle[axis], reach[axis]);
            }
        }
        let around = boxes.iter().fold(Aabb::EMPTY, |all, one| all.union(*one));
        Bunch { around, center, half, first, count: boxes.len() as u32 }
    }

    /// Bits of the members that may lie between some of the points and the light.
    #[inline(always)]
    fn near(&self, axes: &Axes, around: &Around) -> u32 {
        let (mut low, mut high) = ([[0.0f32; LANES]; 3], [[0.0f32; LANES]; 3]);
        let (c, [x, y, z], [a, b, d]) = (axes.center, &self.center, &self.half);
        for (part, axis) in [axes.right, axes.up, axes.toward].into_iter().enumerate() {
            let reach = axis.abs();
            for lane in 0..LANES {
                let middle = (x[lane] - c.x) * axis.x + (y[lane] - c.y) * axis.y + (z[lane] - c.z) * axis.z;
                let reach = a[lane] * reach.x + b[lane] * reach.y + d[lane] * reach.z;
                (low[part][lane], high[part][lane]) = (middle - reach, middle + reach);
            }
        }
        let near = around.near([&low[0], &low[1], &high[0], &high[1], &high[2]]);
        near & if self.count < LANES as u32 { (1 << self.count) - 1 } else { u32::MAX }
    }
}

impl Other {
    /// Bits of the lanes that it may lie above.
    #[inline(always)]
    fn near(&self, axes: &Axes, at: &Starts) -> u32 {
        let [x, y, height] = axes.along(self.center - axes.center);
        bits(|lane| {
            let (dx, dy) = (at.x[lane] - x, at.y[lane] - y);
            (dx * dx + dy * dy <= 1.001 * self.reach * self.reach) & (at.height[lane] < height + self.reach)
        })
    }
}

impl Copies {
    /// Of the fields of a scene's blocks.
    pub(super) fn new(scene: &Scene, fields: &[Arc<Field>]) -> Copies {
        let blocks: Vec<OfBlock> = fields.iter().map(OfBlock::new).collect();
        let mut copies = Copies { blocks, placed: Vec::new(), bunches: Vec::new() };
        for (number, placement) in (0..).zip(&scene.placements) {
            let block_from_world = placement.world_from_block.inverse();
            copies.placed.push(Placed { block: placement.block, block_from_world, first_id: placement.first_id });
            let count = copies.blocks[placement.block].bunches.len() as u32;
            copies.bunches.extend((0..count).map(|bunch| (number, bunch)));
        }
        copies
    }

    /// In a view.
    pub(super) fn in_view(&self, world_from_view: &Affine3A) -> InView<'_> {
        let block_from_view = self.placed.iter().map(|placed| placed.block_from_world * *world_from_view).collect();
        InView { copies: self, block_from_view }
    }
}

impl InView<'_> {
    /// How many bunches there are.
    pub(super) fn len(&self) -> usize {
        self.copies.bunches.len()
    }

    /// A direction's axes, given in view space, as each placement's block sees them.
    pub(super) fn axes(&self, axes: &Axes) -> Vec<Axes> {
        let moved = |block_from_view: &Affine3A| Axes {
            right: block_from_view.transform_vector3(axes.right),
            up: block_from_view.transform_vector3(axes.up),
            toward: block_from_view.transform_vector3(axes.toward),
            center: block_from_view.transform_point3(axes.center),
        };
        self.block_from_view.iter().map(moved).collect()
    }

    /// Looks along a direction.
    pub(super) fn sight(&self, axes: &Axes) -> Sight {
        let of_placed = self.axes(axes);
        let span = |&(placement, bunch): &(u32, u32)| {
            let axes = &of_placed[placement as usize];
            let around = self.copies.blocks[self.copies.placed[placement as usize].block].bunches[bunch as usize].around;
            let (middle, half) = (around.center() - axes.center, around.size() * 0.5);
            let [low, high] = [-1.0, 1.0].map(|side| {
                [axes.right, axes.up, axes.toward].map(|axis| middle.dot(axis) + side * half.dot(axis.abs()))
            });
            Span { low: [low[0], low[1]], high: [high[0], high[1]], top: high[2] }
        };
        let spans: Vec<Span> = self.copies.bunches.iter().map(span).collect();
        Sight::of_spans(&spans, [axes.right, axes.up, axes.toward])
    }

    /// Clears the lanes of `free` whose light something in a tube stands in the way of, in a sample of so many; `axes` are those of
    /// [`InView::axes`].
    #[inline(always)]
    pub(super) fn walk(
        &self,
        (sight, axes): (&Sight, &[Axes]),
        tube: u32,
        (at, points): (&Starts, &Points),
        of: [u32; 2],
        free: &mut Mask,
    ) {
        sight.walk_boxes(tube, at, free, &AskBunches { view: self, axes, at, points, of });
    }

    /// Clears the lanes that a primitive (placement and number in the block) hides the light from.
    #[inline(never)]
    fn exactly(&self, [placement, own]: [u32; 2], toward: Vec3, points: &Points, of: [u32; 2], free: &mut Mask) {
        let placed = &self.copies.placed[placement as usize];
        let solids = self.copies.blocks[placed.block].field.solids();
        let (index, [sample, samples]) = (own as usize, of);
        let id = placed.first_id.saturating_add(solids.id(index));
        if solids.see_through && !hides_in_sample(sample, samples, id, solids.opacity(index)) {
            return;
        }
        let mut in_block = Points { own: [NOBODY; LANES], ..Points::default() };
        let [x, y, z] = &points.position;
        for lane in 0..LANES {
            let point = Vec3A::new(x[lane], y[lane], z[lane]);
            let point = self.block_from_view[placement as usize].transform_point3a(point);
            for axis in 0..3 {
                in_block.position[axis][lane] = point[axis];
            }
        }
        behind(solids, own, toward, &in_block, free);
    }
}
