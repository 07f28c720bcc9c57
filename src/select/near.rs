//! Which points have a target within reach: a tree of boxes over the targets.
//!
//! Unlike the cell list of bonds (`bonds::grid`), whose cells suit the few ångström of a bond, it takes any reach: a box that is
//! farther away than the reach is passed over, one that lies inside it settles the point, so that neither a large reach nor a pile
//! of atoms in one place costs more than a few boxes. Targets are sorted by halving the box along its longest side.

use crate::math::Aabb;
use glam::Vec3;
use rayon::prelude::*;

/// Targets in a leaf (chosen: eight distances cost about as much as two boxes).
const LEAF: usize = 8;
/// Smaller parts are sorted on the spot, larger ones by two cores.
const PARALLEL: usize = 1 << 14;
/// Points in one piece of work.
const POINTS_PER_TASK: usize = 1 << 14;

/// A box of the tree. The children of node `i` are `2 i + 1` and `2 i + 2`, its targets a half each of its own.
struct Tree {
    targets: Vec<Vec3>,
    boxes: Vec<Aabb>,
    levels: u32,
}

/// The half of `start..end` that is the first child's.
fn middle(start: usize, end: usize) -> usize {
    start + (end - start) / 2
}

impl Tree {
    fn new(mut targets: Vec<Vec3>) -> Tree {
        targets.retain(|target| target.is_finite());
        let leaves = targets.len().div_ceil(LEAF).next_power_of_two();
        let levels = leaves.trailing_zeros();
        sort(&mut targets, levels);
        let mut boxes = vec![Aabb::EMPTY; 2 * leaves - 1];
        fill(&targets, &mut boxes, 0, 0, targets.len(), levels);
        Tree { targets, boxes, levels }
    }

    /// Whether a target is not farther from a point than the square root of `reach2`.
    fn has_near(&self, point: Vec3, reach2: f32) -> bool {
        // Of each level at most one sibling waits.
        let mut stack = [(0usize, 0usize, 0usize, 0u32); 40];
        stack[0] = (0, 0, self.targets.len(), 0);
        let mut length = 1;
        while length > 0 {
            length -= 1;
            let (node, start, end, level) = stack[length];
            let bounds = self.boxes[node];
            let (low, high) = (bounds.min - point, point - bounds.max);
            if low.max(high).max(Vec3::ZERO).length_squared() > reach2 || start == end {
                continue;
            }
            if low.abs().max(high.abs()).length_squared() <= reach2 {
                return true;
            }
            if level == self.levels {
                if self.targets[start..end].iter().any(|target| target.distance_squared(point) <= reach2) {
                    return true;
                }
                continue;
            }
            let half = middle(start, end);
            let children = [(2 * node + 2, half, end, level + 1), (2 * node + 1, start, half, level + 1)];
            stack[length..length + 2].copy_from_slice(&children);
            length += 2;
        }
        false
    }
}

/// Sorts targets so that each half of each half, and so on, lies together.
fn sort(targets: &mut [Vec3], levels: u32) {
    if levels == 0 || targets.len() < 2 {
        return;
    }
    let size = bounds_of(targets).size();
    let axis = if size.x >= size.y.max(size.z) {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let half = middle(0, targets.len());
    targets.select_nth_unstable_by(half, |a, b| a[axis].total_cmp(&b[axis]));
    let is_large = targets.len() > PARALLEL;
    let (first, second) = targets.split_at_mut(half);
    if is_large {
        rayon::join(|| sort(first, levels - 1), || sort(second, levels - 1));
    } else {
        sort(first, levels - 1);
        sort(second, levels - 1);
    }
}

fn bounds_of(points: &[Vec3]) -> Aabb {
    points.iter().fold(Aabb::EMPTY, |bounds, &point| bounds.union(Aabb::of_sphere(point, 0.0)))
}

fn fill(targets: &[Vec3], boxes: &mut [Aabb], node: usize, start: usize, end: usize, levels: u32) -> Aabb {
    let bounds = if levels == 0 {
        bounds_of(&targets[start..end])
    } else {
        let half = middle(start, end);
        let first = fill(targets, boxes, 2 * node + 1, start, half, levels - 1);
        first.union(fill(targets, boxes, 2 * node + 2, half, end, levels - 1))
    };
    boxes[node] = bounds;
    bounds
}

/// For every point whether a target is not farther away than `reach`. Points and targets that are not finite are near nothing.
pub(super) fn within(points: &[Vec3], is_target: &[bool], reach: f64) -> Vec<bool> {
    let targets: Vec<Vec3> = points.iter().zip(is_target).filter(|&(_, &is)| is).map(|(&point, _)| point).collect();
    if targets.is_empty() {
        return vec![false; points.len()];
    }
    let tree = Tree::new(targets);
    // A reach that a sum of written decimals falls short of by rounding is one.
    let reach = (reach as f32).min(1e15) * (1.0 + 1e-6);
    let tasks = points.par_iter().with_min_len(POINTS_PER_TASK).zip(is_target);
    tasks.map(|(&point, &is_target)| point.is_finite() && (is_target || tree.has_near(point, reach * reach))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(count: usize, seed: u32) -> Vec<Vec3> {
        let mut state = u64::from(seed);
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32 * 30.0
        };
        (0..count).map(|_| Vec3::new(next(), next(), next())).collect()
    }

    #[test]
    fn it_finds_what_the_double_loop_finds_for_any_reach_and_any_number_of_targets() {
        let mut points = cloud(700, 3);
        points.extend([Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::splat(1e6)]);
        // Piles.
        points.extend([Vec3::splat(15.0); 40]);
        for every in [1, 7, 100, 699] {
            let is_target: Vec<bool> = (0..points.len()).map(|index| index % every == 0).collect();
            for reach in [0.0, 0.9, 5.0, 60.0, 1e30] {
                let found = within(&points, &is_target, reach);
                for (index, point) in points.iter().enumerate() {
                    let near = |target: &Vec3| f64::from(target.distance(*point)) <= reach && point.is_finite();
                    let expected =
                        points.iter().zip(&is_target).any(|(target, &is)| is && target.is_finite() && near(target));
                    assert_eq!(found[index], expected, "{index} {every} {reach}");
                }
            }
        }
        assert_eq!(within(&points, &vec![false; points.len()], 1e9), vec![false; points.len()]);
    }
}
