//! What may hide the light from afar: neighbouring balls and sticks, sixteen together, and boxes around them.
//!
//! All of it in the space of the block that has them, and made once for it. Looked at along a direction, sixteen primitives become
//! discs and stripes at once ([`Cluster::seen`]); a tree of boxes, sixteen neighbours in a node, says which clusters are worth it.

use super::bodies::{Axes, Body};
use super::lanes::{LANES, Lanes};
use crate::math::{Aabb, max, min};
use crate::render::solids::Solids;
use glam::Vec3;
use rayon::prelude::*;

/// Balls and sticks; of a short cluster the last one stands in all further lanes.
#[derive(Debug)]
pub(super) struct Cluster {
    middle: [Lanes; 3],
    /// From the middle to an end of the axis; zero for a ball.
    half: [Lanes; 3],
    pub(super) radius: Lanes,
}

/// A cluster as it looks along a direction: places along its axes.
pub(super) struct Seen {
    pub(super) middle: [Lanes; 3],
    pub(super) half: [Lanes; 3],
    /// One over the squared length of `half` in the plane.
    pub(super) over: Lanes,
}

/// All primitives of a block.
#[derive(Debug)]
pub(super) struct Clusters {
    simple: Vec<Cluster>,
    /// What is asked one by one, a leaf of the boxes each, after the clusters.
    others: Solids,
    /// Levels of boxes: each has one node for [`LANES`] of the level before; the last level has one. The leaves are the clusters and the
    /// others.
    levels: Vec<Vec<Node>>,
    /// Mean radius of the balls and sticks.
    mean_radius: f32,
}

/// Boxes of up to [`LANES`] neighbours.
#[derive(Debug)]
struct Node {
    center: [Lanes; 3],
    half: [Lanes; 3],
    /// Bits of those that there are.
    all: u32,
}

/// Where sixteen things lie along a direction: lowest and highest place along `right` and `up`, and how high they reach.
pub(super) struct Spans {
    pub(super) low: [Lanes; 2],
    pub(super) high: [Lanes; 2],
    pub(super) top: Lanes,
}

/// Something of a block.
pub(super) enum Leaf<'a> {
    Cluster(&'a Cluster),
    /// Its number among [`Clusters::others`].
    Other(usize),
}

impl Clusters {
    /// Of all these.
    pub(super) fn new(solids: &Solids) -> Clusters {
        let (mut bodies, mut others): (Vec<Body>, Vec<Body>) =
            Body::all(solids).into_iter().partition(|body| body.radius >= 0.0);
        let mut one_by_one = Solids { see_through: solids.see_through, ..Solids::default() };
        gather(&mut others, 1);
        others.iter().for_each(|body| one_by_one.push(solids, body.index as usize));
        gather(&mut bodies, LANES);
        let simple: Vec<Cluster> = bodies.par_chunks(LANES).with_min_len(256).map(Cluster::new).collect();
        let mut leaves: Vec<Aabb> = simple.par_iter().with_min_len(256).map(Cluster::bounds).collect();
        leaves.extend((0..one_by_one.len()).map(|index| one_by_one.box_of(index)));
        let radii = bodies.iter().map(|body| f64::from(body.radius)).sum::<f64>();
        let mean_radius = (radii / bodies.len().max(1) as f64) as f32;
        Clusters { simple, others: one_by_one, levels: levels(leaves), mean_radius }
    }

    /// What is asked one by one.
    pub(super) fn others(&self) -> &Solids {
        &self.others
    }

    /// Mean radius of the balls and sticks, 0 if there are none.
    pub(super) fn mean_radius(&self) -> f32 {
        self.mean_radius
    }

    /// The number of the highest level of boxes; `None` if there is nothing.
    pub(super) fn top(&self) -> Option<usize> {
        self.levels.len().checked_sub(1)
    }

    /// Where the boxes of a node lie along a direction, and bits of those that there are.
    #[inline(always)]
    pub(super) fn spans(&self, level: usize, node: usize, axes: &Axes) -> Option<(Spans, u32)> {
        let node = self.levels.get(level)?.get(node)?;
        Some((node.spans(axes), node.all))
    }

    /// A leaf by its number.
    pub(super) fn leaf(&self, leaf: usize) -> Leaf<'_> {
        match self.simple.get(leaf) {
            Some(cluster) => Leaf::Cluster(cluster),
            None => Leaf::Other(leaf - self.simple.len()),
        }
    }
}

/// Boxes around leaves, and around these, up to one node.
fn levels(leaves: Vec<Aabb>) -> Vec<Vec<Node>> {
    let (mut levels, mut below) = (Vec::new(), leaves);
    while !below.is_empty() {
        levels.push(below.chunks(LANES).map(Node::new).collect());
        if below.len() <= LANES {
            break;
        }
        let around = |chunk: &[Aabb]| chunk.iter().fold(Aabb::EMPTY, |all, &child| all.union(child));
        below = below.chunks(LANES).map(around).collect();
    }
    levels
}

/// Puts neighbours next to one another: halves the members across their longest extent, so that every run of [`LANES`] clusters, and of as many
/// of these runs, and so on, is of neighbours.
fn gather(members: &mut [Body], cluster: usize) {
    if members.len() <= cluster {
        return;
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for body in members.iter() {
        (low, high) = (low.min(body.middle), high.max(body.middle));
    }
    let axis = (high - low).max_position();
    let mut whole = cluster;
    while whole * LANES < members.len() {
        whole *= LANES;
    }
    let half = (members.len().div_ceil(2)).div_ceil(whole) * whole;
    let half = if half < members.len() { half } else { whole };
    members.select_nth_unstable_by(half, |a, b| a.middle[axis].total_cmp(&b.middle[axis]).then(a.index.cmp(&b.index)));
    let (a, b) = members.split_at_mut(half);
    if half > 4096 {
        rayon::join(|| gather(a, cluster), || gather(b, cluster));
    } else {
        gather(a, cluster);
        gather(b, cluster);
    }
}

impl Node {
    fn new(children: &[Aabb]) -> Node {
        let mut node = Node { center: [[0.0; LANES]; 3], half: [[0.0; LANES]; 3], all: (1 << children.len()) - 1 };
        for (lane, child) in children.iter().enumerate() {
            let (center, half) = (child.center(), child.size() * 0.5);
            for axis in 0..3 {
                (node.center[axis][lane], node.half[axis][lane]) = (center[axis], half[axis]);
            }
        }
        node
    }

    #[inline(always)]
    fn spans(&self, axes: &Axes) -> Spans {
        let (mut low, mut high) = ([[0.0f32; LANES]; 3], [[0.0f32; LANES]; 3]);
        let (c, [x, y, z], [a, b, d]) = (axes.center, &self.center, &self.half);
        for (part, axis) in [axes.right, axes.up, axes.toward].into_iter().enumerate() {
            let size = axis.abs();
            for lane in 0..LANES {
                let middle = (x[lane] - c.x) * axis.x + (y[lane] - c.y) * axis.y + (z[lane] - c.z) * axis.z;
                let reach = a[lane] * size.x + b[lane] * size.y + d[lane] * size.z;
                (low[part][lane], high[part][lane]) = (middle - reach, middle + reach);
            }
        }
        Spans { low: [low[0], low[1]], high: [high[0], high[1]], top: high[2] }
    }
}

impl Cluster {
    /// Of up to [`LANES`].
    fn new(members: &[Body]) -> Cluster {
        let mut cluster = Cluster { middle: [[0.0; LANES]; 3], half: [[0.0; LANES]; 3], radius: [0.0; LANES] };
        for lane in 0..LANES {
            let body = &members[lane.min(members.len() - 1)];
            for axis in 0..3 {
                cluster.middle[axis][lane] = body.middle[axis];
                cluster.half[axis][lane] = body.half[axis];
            }
            cluster.radius[lane] = body.radius;
        }
        cluster
    }

    /// The box around it.
    fn bounds(&self) -> Aabb {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for lane in 0..LANES {
            for axis in 0..3 {
                let reach = self.half[axis][lane].abs() + self.radius[lane];
                low[axis] = min(self.middle[axis][lane] - reach, low[axis]);
                high[axis] = max(self.middle[axis][lane] + reach, high[axis]);
            }
        }
        Aabb { min: low, max: high }
    }

    /// How it looks along a direction.
    #[inline(always)]
    pub(super) fn seen(&self, axes: &Axes) -> Seen {
        let mut seen = Seen { middle: [[0.0; LANES]; 3], half: [[0.0; LANES]; 3], over: [0.0; LANES] };
        for (part, axis) in [axes.right, axes.up, axes.toward].into_iter().enumerate() {
            let (c, [x, y, z], [a, b, c2]) = (axes.center, &self.middle, &self.half);
            for lane in 0..LANES {
                seen.middle[part][lane] =
                    (x[lane] - c.x) * axis.x + (y[lane] - c.y) * axis.y + (z[lane] - c.z) * axis.z;
                seen.half[part][lane] = a[lane] * axis.x + b[lane] * axis.y + c2[lane] * axis.z;
            }
        }
        for lane in 0..LANES {
            let (a, b) = (seen.half[0][lane], seen.half[1][lane]);
            // Of a stick that is seen from its end any point of the axis will do: all are in one place.
            seen.over[lane] = 1.0 / max(a * a + b * b, 1e-12);
        }
        seen
    }
}
