//! What is under the pointer: one ray against all primitives, through a hierarchy of their boxes.
//!
//! The same intersections as in the picture, so that a pick costs the logarithm of the scene and needs neither a picture
//! nor a device. The primitives of a block are kept once, in its own space, however often it is placed: the ray is brought there, through a hierarchy of the
//! placements' boxes. What is mostly see-through (below an opacity of a half) is looked through, as in the channel of ids.

use super::View;
use super::cpu::intersect::primitive_t;
use super::hierarchy::Hierarchy;
use super::solids::Solids;
use crate::math::Aabb;
use crate::scene::{Ray, Scene};
use glam::{Affine3A, Vec3};

/// Answers what is seen along a ray.
#[derive(Debug)]
pub struct Picker {
    blocks: Vec<Own>,
    placed: Vec<Placed>,
    hierarchy: Hierarchy,
}

/// A block in its own space.
#[derive(Debug)]
struct Own {
    solids: Solids,
    hierarchy: Hierarchy,
}

/// Where one stands.
#[derive(Debug)]
struct Placed {
    block: usize,
    block_from_world: Affine3A,
    first_id: u32,
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
        let own = |block: usize| {
            let solids = Solids::of_block(scene, block);
            let hierarchy = Hierarchy::new(&solids.bounds());
            Own { solids, hierarchy }
        };
        let blocks: Vec<Own> = (0..scene.blocks.len()).map(own).collect();
        let (placed, boxes): (Vec<Placed>, Vec<Aabb>) = (scene.placements.iter())
            .filter_map(|placement| {
                let bounds = blocks[placement.block].hierarchy.boxes.last()?;
                let world_from_block = placement.world_from_block;
                let placed = Placed {
                    block: placement.block,
                    block_from_world: world_from_block.inverse(),
                    first_id: placement.first_id,
                };
                Some((placed, bounds.moved(&world_from_block)))
            })
            .unzip();
        let hierarchy = Hierarchy::new(&boxes);
        Picker { blocks, placed, hierarchy }
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
        // The id and the depth of what is nearest so far.
        let mut best: (f32, Option<u32>) = (f32::INFINITY, None);
        let enter = |ray: &Ray| {
            let (origin, inverse) = (ray.origin, ray.direction.recip());
            move |best: &(f32, Option<u32>), bounds: &Aabb| {
                let (near, far) = bounds.slab(origin, inverse)?;
                (far >= camera.near && near < best.0).then_some(near)
            }
        };
        self.hierarchy.visit(&mut best, enter(&ray), |best, number| {
            let placed = &self.placed[number as usize];
            let own = &self.blocks[placed.block];
            // Motions that keep distances keep the depth as well.
            let ray = Ray {
                origin: placed.block_from_world.transform_point3(ray.origin),
                direction: placed.block_from_world.transform_vector3(ray.direction),
            };
            own.hierarchy.visit(best, enter(&ray), |best, index| {
                let t = primitive_t(&ray, &own.solids, index as usize, camera.near);
                // Through what is see-through by more than a half one picks what is behind it, as ids have it.
                if t < best.0 && own.solids.is_drawn(index as usize, 0, 1) {
                    *best = (t, Some(placed.first_id.saturating_add(own.solids.id(index as usize))));
                }
            });
        });
        let (depth, id) = (best.0, best.1?);
        Some(Hit { id, depth, point: ray.origin + ray.direction * depth })
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
    fn copies_are_picked_where_they_stand() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/caffeine.sdf");
        let document = crate::import::read_path(&path, &Default::default()).unwrap();
        let molecule = crate::bonds::assign(document.records[0].clone(), &Default::default());
        let mut assembly = crate::structure::Assembly::new("1", "");
        let mirror =
            glam::DAffine3 { translation: glam::DVec3::Z * 9.0, ..glam::DAffine3::from_scale((1.0, 1.0, -1.0).into()) };
        let turn = glam::DAffine3 { translation: glam::DVec3::X * 8.0, ..glam::DAffine3::from_rotation_y(1.1) };
        assembly.push(vec![0..24], &[glam::DAffine3::IDENTITY, turn, mirror]);
        let copies = crate::crystal::Copies::of_assembly(&assembly, molecule.atom_count());
        let item = Item { copies: Some(&copies), ..Item::of(&molecule) };
        let scene = Arc::new(Scene::new(&[item], &SceneOptions::default()));
        let picker = Picker::new(&scene);
        assert_eq!((picker.blocks.len(), picker.placed.len()), (1, 3));
        let view = View::new(scene.fitted_camera(1.5), 120, 80);
        let mut renderer = CpuRenderer::new();
        renderer.load(Arc::clone(&scene)).unwrap();
        let seen = renderer.gbuffer(&view).unwrap();
        let (mut agree, mut copies) = (0, std::collections::HashSet::new());
        for (pixel, &id) in seen.id.iter().enumerate() {
            let hit = picker.pick(&view, [(pixel % 120) as f32 + 0.5, (pixel / 120) as f32 + 0.5]);
            let id = if id == GBuffer::GROUND { GBuffer::BACKGROUND } else { id };
            agree += usize::from(hit.map_or(GBuffer::BACKGROUND, |hit| hit.id) == id);
            copies.extend(scene.item_of(id).map(|(_, copy, _)| copy));
        }
        assert!(agree >= seen.id.len() - 20 && copies.len() == 3, "{agree} {copies:?}");
    }

    #[test]
    fn an_empty_scene_has_nothing_to_pick() {
        let scene = Scene::from_blocks(Vec::new(), Vec::new());
        assert_eq!(Picker::new(&scene).pick(&View::new(scene.fitted_camera(1.0), 9, 9), [4.0, 4.0]), None);
    }
}
