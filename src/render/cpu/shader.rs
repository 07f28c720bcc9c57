//! From a hit to a colour: what the reference and the tiles share, so that they cannot differ.

use super::intersect::{cylinder_half, cylinder_normal, sphere_normal};
use crate::render::field::GroundMap;
use crate::render::frame::{FrameConstants, Surface, ground_t, shade_background, shade_ground, shade_surface};
use crate::render::image::GBuffer;
use crate::render::solids::Solids;
use crate::scene::Ray;
use glam::{Affine3A, Vec3, Vec4};

/// What a ray sees first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Seen {
    /// Primitive and depth.
    Primitive(u32, f32),
    /// The ground, at this depth.
    Ground(f32),
    /// Nothing.
    Nothing,
}

/// What shading a sample needs.
pub(super) struct Shader<'a> {
    pub(super) frame: &'a FrameConstants,
    pub(super) solids: &'a Solids,
    pub(super) ground_map: &'a GroundMap,
    world_from_view: Affine3A,
}

impl<'a> Shader<'a> {
    pub(super) fn new(frame: &'a FrameConstants, solids: &'a Solids, ground_map: &'a GroundMap) -> Shader<'a> {
        Shader { frame, solids, ground_map, world_from_view: frame.world_from_view() }
    }

    /// What is seen, given the nearest primitive (or none) and its depth.
    pub(super) fn seen(&self, ray: &Ray, nearest: Option<(u32, f32)>) -> Seen {
        let ground = self.ground_depth(ray);
        match nearest {
            Some((index, t)) if t <= ground => Seen::Primitive(index, t),
            _ if ground.is_finite() => Seen::Ground(ground),
            _ => Seen::Nothing,
        }
    }

    fn ground_depth(&self, ray: &Ray) -> f32 {
        if !self.frame.has_ground() {
            return f32::INFINITY;
        }
        let origin = self.world_from_view.transform_point3(ray.origin);
        ground_t(self.frame, origin, self.world_from_view.transform_vector3(ray.direction))
    }

    /// Normal in view space and linear colour of a hit.
    pub(super) fn surface(&self, ray: &Ray, index: u32, t: f32) -> Surface {
        let near = self.frame.depth[2];
        let index = index as usize;
        let (normal, color) = match index.checked_sub(self.solids.spheres.len()) {
            None => (sphere_normal(ray, &self.solids.spheres[index], near, t), self.solids.sphere_looks[index].0),
            Some(i) => {
                let cylinder = &self.solids.cylinders[i];
                let (a, b, _) = self.solids.cylinder_looks[i];
                let color = if cylinder_half(ray, cylinder, t) { b } else { a };
                (cylinder_normal(ray, cylinder, near, t), color)
            }
        };
        Surface { depth: t, normal, albedo: color.to_linear().into() }
    }

    /// Premultiplied linear colour and alpha of what is seen.
    pub(super) fn shade(&self, ray: &Ray, seen: Seen) -> Vec4 {
        match seen {
            Seen::Primitive(index, t) => {
                let surface = self.surface(ray, index, t);
                Vec4::from((shade_surface(self.frame, &surface, ray.direction), 1.0))
            }
            Seen::Ground(t) => {
                let point = self.world_from_view.transform_point3(ray.origin + ray.direction * t);
                let [visible, open] = self.ground_map.at(self.frame, point);
                shade_ground(self.frame, point, visible, open)
            }
            Seen::Nothing => shade_background(self.frame),
        }
    }

    /// Id, depth and normal of what is seen.
    pub(super) fn facts(&self, ray: &Ray, seen: Seen) -> (u32, f32, [f32; 3]) {
        match seen {
            Seen::Primitive(index, t) => {
                (self.solids.id(index as usize), t, self.surface(ray, index, t).normal.to_array())
            }
            Seen::Ground(t) => {
                let up = Vec3::new(self.frame.up[0], self.frame.up[1], self.frame.up[2]);
                (GBuffer::GROUND, t, up.to_array())
            }
            Seen::Nothing => (GBuffer::BACKGROUND, f32::INFINITY, [0.0; 3]),
        }
    }
}

