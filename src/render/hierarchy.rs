//! A bounding hierarchy: boxes in Morton order, each node over [`WIDTH`] neighbours of the level below.
//!
//! Level 0 holds one box per leaf of [`WIDTH`] primitives; nothing stores pointers, node `i` of a level covers
//! nodes `WIDTH·i …` of the level below. Building is a sort and a sweep (a million primitives in a fraction of
//! a second), and the same arrays serve a shader as texels.

use crate::math::Aabb;
use glam::Vec3;
use rayon::prelude::*;

/// Children of a node, and primitives of a leaf.
pub const WIDTH: usize = 4;

/// The hierarchy over a list of primitives.
#[derive(Debug, Clone, Default)]
pub struct Hierarchy {
    /// Primitive indices in Morton order.
    pub order: Vec<u32>,
    /// Boxes of all levels, level 0 (leaves) first.
    pub boxes: Vec<Aabb>,
    /// Where each level starts in `boxes`; the last entry is the end. The highest level has one box.
    pub levels: Vec<u32>,
}

impl Hierarchy {
    /// Over primitives with these boxes.
    #[must_use]
    pub fn new(bounds: &[Aabb]) -> Hierarchy {
        if bounds.is_empty() {
            return Hierarchy::default();
        }
        let centers = bounds.par_iter().with_min_len(8192).map(|b| (b.min + b.max) * 0.5);
        let centers = centers.map(|center| Aabb { min: center, max: center });
        let all = centers.reduce(|| Aabb::EMPTY, Aabb::union);
        let scale = 1023.0 / all.size().max_element().max(1e-12);
        // The place on the curve, and the index: one number is sorted faster than two.
        let keyed = |(index, b): (usize, &Aabb)| {
            u64::from(morton(((b.min + b.max) * 0.5 - all.min) * scale)) << 32 | index as u64
        };
        let mut keyed: Vec<u64> = bounds.par_iter().with_min_len(8192).enumerate().map(keyed).collect();
        keyed.par_sort_unstable();
        let order: Vec<u32> = keyed.par_iter().with_min_len(8192).map(|&keyed| keyed as u32).collect();
        let mut boxes: Vec<Aabb> = order
            .par_chunks(WIDTH)
            .with_min_len(2048)
            .map(|leaf| leaf.iter().fold(Aabb::EMPTY, |all, &index| all.union(bounds[index as usize])))
            .collect();
        let mut levels = vec![0u32];
        let mut start = 0;
        loop {
            let end = boxes.len();
            levels.push(end as u32);
            if end - start <= 1 {
                break;
            }
            for node in (start..end).step_by(WIDTH) {
                let children = &boxes[node..(node + WIDTH).min(end)];
                let around = children.iter().fold(Aabb::EMPTY, |all, &child| all.union(child));
                boxes.push(around);
            }
            start = end;
        }
        Hierarchy { order, boxes, levels }
    }

    /// Number of levels; 0 for no primitives.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.levels.len().saturating_sub(1)
    }

    /// The highest of what `of` gives for the primitives in each box, in the order of the boxes.
    #[must_use]
    pub fn highest(&self, of: impl Fn(u32) -> u8) -> Vec<u8> {
        let most = |values: &[u8]| values.iter().copied().max().unwrap_or(0);
        let mut highest = Vec::with_capacity(self.boxes.len());
        for leaf in self.order.chunks(WIDTH) {
            highest.push(leaf.iter().map(|&index| of(index)).max().unwrap_or(0));
        }
        for level in self.levels.windows(2).take(self.depth().saturating_sub(1)) {
            for node in (level[0] as usize..level[1] as usize).step_by(WIDTH) {
                highest.push(most(&highest[node..(node + WIDTH).min(level[1] as usize)]));
            }
        }
        highest
    }

    /// Visits leaves that `enter` lets through, nearest first by the key it gives (smaller is nearer; `None` skips the
    /// node and all below). `leaf` gets primitive indices; what it changes, `enter` sees at later nodes.
    pub fn visit<S>(&self, state: &mut S, enter: impl Fn(&S, &Aabb) -> Option<f32>, leaf: impl FnMut(&mut S, u32)) {
        self.visit_numbered(state, |state, _, own| enter(state, own), leaf);
    }

    /// As [`Hierarchy::visit`]; `enter` is given the number of the box in `boxes`, too.
    pub fn visit_numbered<S>(
        &self,
        state: &mut S,
        enter: impl Fn(&S, usize, &Aabb) -> Option<f32>,
        mut leaf: impl FnMut(&mut S, u32),
    ) {
        if self.order.is_empty() {
            return;
        }
        let top = self.depth() - 1;
        // Every level leaves at most WIDTH − 1 nodes waiting; 16 levels hold 4^17 primitives.
        let mut stack = [(0u8, 0u32, 0f32); 16 * WIDTH];
        let root = self.levels[top] as usize;
        let Some(key) = enter(state, root, &self.boxes[root]) else { return };
        stack[0] = (top as u8, 0, key);
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (level, node, _) = stack[waiting];
            // The bound may have tightened since the node was pushed.
            let own = self.levels[level as usize] as usize + node as usize;
            if enter(state, own, &self.boxes[own]).is_none() {
                continue;
            }
            if level == 0 {
                let first = node as usize * WIDTH;
                for &primitive in &self.order[first..(first + WIDTH).min(self.order.len())] {
                    leaf(state, primitive);
                }
                continue;
            }
            let below = level as usize - 1;
            let (start, end) = (self.levels[below] as usize, self.levels[below + 1] as usize);
            let base = waiting;
            for child in (start + node as usize * WIDTH)..(start + (node as usize + 1) * WIDTH).min(end) {
                if let Some(key) = enter(state, child, &self.boxes[child]) {
                    // Insertion keeps the nearest on top.
                    let mut at = waiting;
                    while at > base && stack[at - 1].2 < key {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = (below as u8, (child - start) as u32, key);
                    waiting += 1;
                }
            }
        }
    }
}

/// Interleaves the bits of three coordinates of 0–1023.
fn morton(cell: Vec3) -> u32 {
    let spread = |x: f32| {
        let mut x = (x as u32).min(1023);
        x = (x | x << 16) & 0x0300_00FF;
        x = (x | x << 8) & 0x0300_F00F;
        x = (x | x << 4) & 0x030C_30C3;
        (x | x << 2) & 0x0924_9249
    };
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(count: usize) -> Vec<Aabb> {
        (0..count)
            .map(|i| {
                let f = i as f32;
                let center = Vec3::new((f * 0.37).sin(), (f * 0.73).cos(), (f * 1.91).sin()) * 20.0;
                Aabb::of_sphere(center, 0.3 + (f * 0.11).sin().abs())
            })
            .collect()
    }

    #[test]
    fn every_primitive_is_in_one_leaf_and_every_box_holds_its_children() {
        for count in [0, 1, 3, 4, 5, 16, 17, 1000] {
            let bounds = cloud(count);
            let hierarchy = Hierarchy::new(&bounds);
            let mut seen = vec![0; count];
            hierarchy.visit(&mut (), |(), _| Some(0.0), |(), i| seen[i as usize] += 1);
            assert!(seen.iter().all(|&n| n == 1), "{count}");
            let highest = hierarchy.highest(|index| (index % 251) as u8);
            assert_eq!(highest.len(), hierarchy.boxes.len(), "{count}");
            assert_eq!(highest.last().copied(), (0..count).map(|index| (index % 251) as u8).max());
            let Some(root) = hierarchy.boxes.last() else { continue };
            assert!(bounds.iter().all(|b| root.union(*b) == *root));
        }
    }

    #[test]
    fn nearest_query_agrees_with_asking_all() {
        let bounds = cloud(500);
        let hierarchy = Hierarchy::new(&bounds);
        for i in 0..50 {
            let f = i as f32;
            let p = Vec3::new(f - 25.0, (f * 3.0).sin() * 25.0, f * 0.5);
            let mut best = f32::INFINITY;
            hierarchy.visit(
                &mut best,
                |best, b| Some(b.distance(p)).filter(|d| d < best),
                |best, i| *best = best.min(bounds[i as usize].distance(p)),
            );
            let want = bounds.iter().map(|b| b.distance(p)).fold(f32::INFINITY, f32::min);
            assert_eq!(best, want);
        }
    }
}
