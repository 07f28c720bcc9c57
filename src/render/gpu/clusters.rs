//! Balls and sticks in clusters of neighbours, so that what is out of the picture is left out cluster by cluster.
//!
//! Instances lie on the device along a space-filling curve (that of [`Hierarchy`], whose third level of boxes is that of the clusters).
//! The boxes serve the compute pass of [`super::passes::cull`], and where there is none the CPU, which asks all boxes of a frame: a
//! million balls and sticks have 31,000.

use crate::math::Aabb;
use crate::render::frame::FrameConstants;
use crate::render::hierarchy::{Hierarchy, WIDTH};
use crate::scene::Region;
use glam::{Affine3A, Vec3, Vec3A};
use rayon::prelude::*;

/// Instances of a cluster: as many as three levels of the hierarchy hold. Twin of `MEMBERS` in shaders/cull.wgsl.
pub const MEMBERS: usize = WIDTH * WIDTH * WIDTH;

/// Twin of `OUTLINED` in shaders/cull.wgsl: an outline makes anything wider by no more than this (see [`crate::render::outline`]), and
/// a box that holds it no more than as many times larger.
pub const OUTLINED: f32 = 1.4;

/// Fewer instances of a kind than this are drawn all, in the order of the block. Chosen. On lavapipe (benches/gpu_frame.rs) lists change a frame's
/// processor time by −6 to −13 % at 100,000 atoms and by −47 to −57 % at 1,000,000; on a real GPU this was not measured.
pub(super) const FEWEST: usize = 16_384;

/// What a cluster lies in, in the space of its block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ClusterBox {
    pub(super) center: Vec3,
    /// Half the size.
    pub(super) half: Vec3,
}

/// The order in which instances with these boxes are clustered, and the clusters' boxes; `None` for few.
pub(super) fn clusters(bounds: &[Aabb]) -> Option<(Vec<u32>, Vec<ClusterBox>)> {
    if bounds.len() < FEWEST {
        return None;
    }
    let hierarchy = Hierarchy::new(bounds);
    let &[_, _, first, end, ..] = &*hierarchy.levels else { return None };
    let of = |b: &Aabb| ClusterBox { center: b.center(), half: b.size() * 0.5 };
    let boxes = hierarchy.boxes[first as usize..end as usize].iter().map(of).collect();
    Some((hierarchy.order, boxes))
}

/// What a part of a picture shows, in view space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frustum {
    /// Normals, which point outwards, and how far out the origin is.
    sides: [(Vec3, f32); 4],
    near: f32,
    growth: f32,
}

impl Frustum {
    pub(super) fn new(frame: &FrameConstants, region: Region) -> Frustum {
        let [per_px, center_x, center_y, orthographic] = frame.grid;
        // Samples may lie anywhere in their pixels, and corners of quads are snapped.
        let slack = 2.0;
        let x = |px: f32| (px - center_x) * per_px;
        let y = |px: f32| (center_y - px) * per_px;
        let (left, right) = (x(region.x as f32 - slack), x((region.x + region.width) as f32 + slack));
        let (top, bottom) = (y(region.y as f32 - slack), y((region.y + region.height) as f32 + slack));
        let side = |direction: Vec3, at: f32| {
            let at = at * (direction.x + direction.y);
            if orthographic > 0.5 { (direction, -at) } else { (direction + Vec3::Z * at, 0.0) }
        };
        let sides = [side(Vec3::NEG_X, left), side(Vec3::X, right), side(Vec3::NEG_Y, bottom), side(Vec3::Y, top)];
        let has_outlines = frame.outline[0] + frame.outline[1] > 0.0;
        Frustum { sides, near: frame.depth[2], growth: if has_outlines { OUTLINED } else { 1.0 } }
    }

    /// Whether anything of a box may be seen.
    pub(super) fn shows(&self, cluster: &ClusterBox, view_from_block: &Affine3A) -> bool {
        let center = view_from_block.transform_point3(cluster.center);
        let half = Vec3::from(view_from_block.matrix3.abs() * Vec3A::from(cluster.half)) * self.growth;
        // The rounding of the line above.
        let half = half + 1e-5 * center.abs();
        let is_outside = |&(normal, offset): &(Vec3, f32)| normal.dot(center) + offset > normal.abs().dot(half);
        half.z - center.z >= self.near && !self.sides.iter().any(is_outside)
    }

    /// Runs of instances, `count` in all, whose clusters may be seen.
    pub(super) fn runs(&self, boxes: &[ClusterBox], count: u32, view_from_block: &Affine3A) -> Vec<[u32; 2]> {
        let shown: Vec<bool> =
            boxes.par_iter().with_min_len(4096).map(|cluster| self.shows(cluster, view_from_block)).collect();
        let mut runs: Vec<[u32; 2]> = Vec::new();
        for (index, _) in shown.iter().enumerate().filter(|(_, is_shown)| **is_shown) {
            let start = (index * MEMBERS) as u32;
            let end = (start + MEMBERS as u32).min(count);
            match runs.last_mut() {
                // A draw costs more than what lies between.
                Some(last) if start - last[1] <= 4 * MEMBERS as u32 => last[1] = end,
                _ => runs.push([start, end]),
            }
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::settings::View;
    use crate::render::{Quality, bounds};
    use crate::scene::{Camera, Projection, Scene};
    use glam::Quat;

    fn balls() -> Vec<Aabb> {
        let at = |i: u32| Vec3::new((i % 41) as f32, (i / 41 % 41) as f32, (i / 1681) as f32) - 20.0;
        (0..40_000).map(|i| Aabb::of_sphere(at(i) * 2.0, 0.5)).collect()
    }

    #[test]
    fn clusters_hold_all_instances_once_in_their_boxes() {
        let balls = balls();
        assert!(clusters(&balls[..FEWEST - 1]).is_none());
        let (mut order, boxes) = clusters(&balls).unwrap();
        assert_eq!(boxes.len(), balls.len().div_ceil(MEMBERS));
        for (members, cluster) in order.chunks(MEMBERS).zip(&boxes) {
            for &i in members {
                let ball = balls[i as usize];
                let reach = (ball.center() - cluster.center).abs() + ball.size() * 0.5;
                assert!((cluster.half + 1e-4 - reach).min_element() >= 0.0);
            }
        }
        let size: f32 = boxes.iter().map(|b| b.half.max_element()).sum::<f32>() / boxes.len() as f32;
        assert!(size < 10.0, "clusters are neighbours: {size}");
        order.sort_unstable();
        assert!(order.iter().enumerate().all(|(i, &index)| i as u32 == index));
    }

    #[test]
    fn a_frustum_shows_all_that_reaches_into_the_picture_and_little_else() {
        let all = balls();
        let (order, boxes) = clusters(&all).unwrap();
        let scene = Scene::from_blocks(Vec::new(), Vec::new());
        for projection in [Projection::Perspective { fov_y_rad: 0.6 }, Projection::Orthographic { height: 90.0 }] {
            for (eye, distance) in [(Vec3::new(3.0, 5.0, 150.0), 150.0), (Vec3::new(1.0, 2.0, 3.0), 20.0)] {
                let target = eye - Vec3::Z * distance;
                let (near, far, shift) = (0.1, 400.0, [0.01, 0.02]);
                let camera = Camera { eye, world_from_view: Quat::IDENTITY, projection, near, far, target, shift };
                let view = View::new(camera, 300, 200);
                let region = Region { x: 100, y: 80, width: 90, height: 60 };
                let frame = FrameConstants::new(&scene, &view, &Quality::Draft.settings());
                let frustum = Frustum::new(&frame, region);
                let view_from_world = view.camera.view_from_world();
                let grid = view.pixel_grid();
                let camera = bounds::BoundsCamera { orthographic: grid.orthographic, near: view.camera.near };
                let runs = frustum.runs(&boxes, order.len() as u32, &view_from_world);
                let (mut inside, mut drawn) = (0, 0);
                for (place, &i) in order.iter().enumerate() {
                    let center = view_from_world.transform_point3(all[i as usize].center());
                    let is_drawn = runs.iter().any(|run| (run[0]..run[1]).contains(&(place as u32)));
                    drawn += usize::from(is_drawn);
                    let Some(rect) = bounds::sphere_rect(center, 0.5, &camera) else { continue };
                    let x = rect.center.x / grid.plane_per_px + grid.center_px[0];
                    let y = grid.center_px[1] - rect.center.y / grid.plane_per_px;
                    let half = rect.half / grid.plane_per_px;
                    let is_inside = x + half.x > 100.0 && x - half.x < 190.0 && y + half.y > 80.0 && y - half.y < 140.0;
                    inside += usize::from(is_inside);
                    assert!(is_drawn || !is_inside, "{center}");
                }
                // The region is a fifth of what is there, and runs take in what lies between.
                assert!(inside > 10 && drawn * 5 < order.len() * 3, "{inside} {drawn}");
            }
        }
    }
}
