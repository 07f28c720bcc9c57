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
use crate::math::{Aabb, min};
use crate::render::field::Field;
use crate::render::opacity::hides_in_sample;
use crate::render::solids::Solids;
use crate::render::tubes::Span;
use crate::scene::Scene;
use glam::{Affine3A, Vec3, Vec3A};
use rayon::prelude::*;
use std::sync::Arc;

/// Members of a bunch.
const BUNCH: usize = LANES;

/// Up to [`BUNCH`] clusters, or as many primitives that are asked one by one, and their boxes.
#[derive(Debug)]
struct Bunch {
    whole: Extent,
    center: [Lanes; 3],
    half: [Lanes; 3],
    /// Of balls about the same centres. Seen aslant these are smaller than the boxes.
    reach: Lanes,
    /// Number of its first member: clusters first, then others.
    first: u32,
    count: u32,
}

/// What holds some primitives: a box, and a ball about its middle.
#[derive(Debug, Clone, Copy)]
struct Extent {
    center: Vec3,
    half: Vec3,
    reach: f32,
}

/// A block in its own space.
#[derive(Debug)]
struct OfBlock {
    field: Arc<Field>,
    clusters: Vec<Cluster>,
    /// What is asked one by one: numbers in the block.
    others: Vec<u32>,
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
                None => match block.others.get(member - block.clusters.len()) {
                    Some(&own) => self.view.exactly([placement, own], axes.toward, self.points, self.of, alive),
                    None => alive,
                },
            };
            if alive == 0 {
                return 0;
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
        gather(&mut simple, BUNCH * LANES);
        simple.par_chunks_mut(BUNCH * LANES).for_each(|bunch| gather(bunch, LANES));
        gather(&mut others, BUNCH);
        let (mut bunches, mut first) = (Vec::new(), 0u32);
        for (bodies, member) in [(&simple, LANES), (&others, 1)] {
            for bunch in bodies.chunks(BUNCH * member) {
                let members: Vec<Extent> = bunch.chunks(member).map(|bodies| Extent::of(bodies, solids)).collect();
                bunches.push(Bunch::new(Extent::of(bunch, solids), &members, first));
                first += members.len() as u32;
            }
        }
        OfBlock {
            field: Arc::clone(field),
            clusters: simple.par_chunks(LANES).map(Cluster::new).collect(),
            others: others.iter().map(|body| body.index).collect(),
            bunches,
        }
    }
}

impl Extent {
    fn of(bodies: &[Body], solids: &Solids) -> Extent {
        let box_of = |body: &Body| solids.box_of(body.index as usize);
        let around = bodies.iter().fold(Aabb::EMPTY, |all, body| all.union(box_of(body)));
        let (center, half) = (around.center(), around.size() * 0.5);
        let reach = |body: &Body| {
            if body.radius < 0.0 {
                return box_of(body).center().distance(center) + 0.5 * box_of(body).size().length();
            }
            let [a, b] = [body.half, -body.half].map(|half| (body.middle + half).distance(center));
            a.max(b) + body.radius
        };
        Extent { center, half, reach: bodies.iter().map(reach).fold(0.0, f32::max) }
    }

    /// Where it lies along a direction.
    fn span(&self, axes: &Axes) -> Span {
        let middle = axes.along(self.center - axes.center);
        let half = [axes.right, axes.up, axes.toward].map(|axis| min(self.half.dot(axis.abs()), self.reach));
        let [low, high] = [-1.0, 1.0].map(|side| [0, 1, 2].map(|part| middle[part] + side * half[part]));
        Span { low: [low[0], low[1]], high: [high[0], high[1]], top: high[2] }
    }
}

impl Bunch {
    fn new(whole: Extent, members: &[Extent], first: u32) -> Bunch {
        let (mut center, mut half, mut reach) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3], [0.0; LANES]);
        for (lane, member) in members.iter().enumerate().take(LANES) {
            for axis in 0..3 {
                (center[axis][lane], half[axis][lane]) = (member.center[axis], member.half[axis]);
            }
            reach[lane] = member.reach;
        }
        Bunch { whole, center, half, reach, first, count: members.len() as u32 }
    }

    /// Bits of the members that may lie between some of the points and the light.
    #[inline(always)]
    fn near(&self, axes: &Axes, around: &Around) -> u32 {
        let (mut low, mut high) = ([[0.0f32; LANES]; 3], [[0.0f32; LANES]; 3]);
        let (c, [x, y, z], [a, b, d]) = (axes.center, &self.center, &self.half);
        for (part, axis) in [axes.right, axes.up, axes.toward].into_iter().enumerate() {
            let size = axis.abs();
            for lane in 0..LANES {
                let middle = (x[lane] - c.x) * axis.x + (y[lane] - c.y) * axis.y + (z[lane] - c.z) * axis.z;
                let reach = min(a[lane] * size.x + b[lane] * size.y + d[lane] * size.z, self.reach[lane]);
                (low[part][lane], high[part][lane]) = (middle - reach, middle + reach);
            }
        }
        let near = around.near([&low[0], &low[1], &high[0], &high[1], &high[2]]);
        near & if self.count < LANES as u32 { (1 << self.count) - 1 } else { u32::MAX }
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
            let block = self.copies.placed[placement as usize].block;
            self.copies.blocks[block].bunches[bunch as usize].whole.span(&of_placed[placement as usize])
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

    /// Which of the lanes `alive`, as bits, a primitive (placement and number in the block) leaves in a sample of so many. On its own, for it
    /// is long and seldom asked.
    #[inline(never)]
    fn exactly(
        &self,
        [placement, own]: [u32; 2],
        toward: Vec3,
        points: &Points,
        [sample, samples]: [u32; 2],
        alive: u32,
    ) -> u32 {
        let placed = &self.copies.placed[placement as usize];
        let solids = self.copies.blocks[placed.block].field.solids();
        let index = own as usize;
        let id = placed.first_id.saturating_add(solids.id(index));
        if solids.see_through && !hides_in_sample(sample, samples, id, solids.opacity(index)) {
            return alive;
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
        let mut free = lanes_of(alive);
        behind(solids, own, toward, &in_block, &mut free);
        bits(|lane| free[lane] != 0)
    }
}
