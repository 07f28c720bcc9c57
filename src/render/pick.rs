//! What is under the pointer: one ray against all primitives, through a hierarchy of their boxes.
//!
//! The same intersections as in the picture, in world space, so that a pick costs the logarithm of the scene and needs neither a picture
//! nor a device. What is mostly see-through (below an opacity of a half) is looked through, as in the channel of ids.

use super::View;
use super::cpu::intersect::primitive_t;
use super::hierarchy::Hierarchy;
use super::solids::Solids;
use crate::scene::{Ray, Scene};
use glam::{Affine3A, Vec3};

/// Answers what is seen along a ray.
#[derive(Debug)]
pub struct Picker {
    solids: Solids,
    hierarchy: Hierarchy,
}

/// What a ray meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The id, as in [`super::GBuffer`].
    pub id: u32,
    /// Depth along the view direction, ångström.
    pub depth: f32,
    /// Where, world space.
    pub point: Vec3,
}

impl Picker {
    /// For the primitives of a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Picker {
        let solids = Solids::new(scene, Affine3A::IDENTITY);
        let hierarchy = Hierarchy::new(&solids.bounds());
        Picker { solids, hierarchy }
    }

    /// What is seen at a point of the picture, in pixels from its upper left corner; `None` for ground and background.
    #[must_use]
    pub fn pick(&self, view: &View, [x_px, y_px]: [f32; 2]) -> Option<Hit> {
        let camera = &view.camera;
        let grid = view.pixel_grid();
        let in_view = grid.ray(grid.plane(x_px, y_px));
        let ray = Ray {
            origin: camera.eye + camera.world_from_view * in_view.origin,
            direction: camera.world_from_view * in_view.direction,
        };
        let inverse = ray.direction.recip();
        let mut best: (f32, Option<u32>) = (f32::INFINITY, None);
        self.hierarchy.visit(
            &mut best,
            |best, bounds| {
                let (near, far) = bounds.slab(ray.origin, inverse)?;
                (far >= camera.near && near < best.0).then_some(near)
            },
            |best, index| {
                let t = primitive_t(&ray, &self.solids, index as usize, camera.near);
                // Through what is see-through by more than a half one picks what is behind it, as ids have it.
                if t < best.0 && self.solids.is_drawn(index as usize, 0, 1) {
                    *best = (t, Some(index));
                }
            },
        );
        let (depth, index) = (best.0, best.1?);
        Some(Hit { id: self.solids.id(index as usize), depth, point: ray.origin + ray.direction * depth })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::cpu::CpuRenderer;
    use crate::render::{GBuffer, Renderer};
    use crate::scene::{Item, SceneOptions};
    use std::sync::Arc;

    #[test]
    fn a_pick_finds_what_the_picture_shows() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/caffeine.sdf");
        let document = crate::import::read_path(&path, &Default::default()).unwrap();
        let molecule = crate::bonds::assign(document.records[0].clone(), &Default::default());
        for perspective in [true, false] {
            let options = SceneOptions { perspective, ..SceneOptions::default() };
            let scene = Arc::new(Scene::new(&[Item::of(&molecule)], &options));
            let view = View::new(scene.fitted_camera(1.5), 90, 60);
            let picker = Picker::new(&scene);
            let mut renderer = CpuRenderer::new();
            renderer.load(Arc::clone(&scene)).unwrap();
            let seen = renderer.gbuffer(&view).unwrap();
            let (mut agree, mut covered) = (0, 0);
            for y in 0..60 {
                for x in 0..90 {
                    let id = seen.id[y * 90 + x];
                    let hit = picker.pick(&view, [x as f32 + 0.5, y as f32 + 0.5]);
                    let picked = hit.map_or(GBuffer::BACKGROUND, |hit| hit.id);
                    let id = if id == GBuffer::GROUND { GBuffer::BACKGROUND } else { id };
                    covered += u32::from(id != GBuffer::BACKGROUND);
                    agree += u32::from(id == picked);
                    if let Some(hit) = hit.filter(|_| id == picked) {
                        assert!((hit.depth - seen.depth[y * 90 + x]).abs() < 1e-3);
                    }
                }
            }
            // A ray through the very edge of a primitive may be decided by the last bit.
            assert!(covered > 300 && agree >= 5400 - 5, "{covered} {agree}");
        }
    }

    #[test]
    fn an_empty_scene_has_nothing_to_pick() {
        let scene = Scene::from_blocks(Vec::new(), Vec::new());
        assert_eq!(Picker::new(&scene).pick(&View::new(scene.fitted_camera(1.0), 9, 9), [4.0, 4.0]), None);
    }
}
