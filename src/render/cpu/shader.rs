//! From a hit to a colour: what the reference and the tiles share, so that they cannot differ.

use super::intersect::{cylinder_half, primitive_normal, triangle_weights};
use super::lanes::{LANES, Lanes};
use crate::render::field::GroundMap;
use crate::render::frame::{
    FrameConstants, Surface, ground_t, shade_background, shade_ground, shade_outline, shade_surface,
};
use crate::render::image::GBuffer;
use crate::render::outline::{Outline, RIM};
use crate::render::sky::Reach;
use crate::render::solids::{Primitive, Solids};
use crate::scene::Ray;
use glam::{Affine3A, Vec3, Vec4};

/// What shading a sample needs.
#[derive(Clone, Copy)]
pub(super) struct Shader<'a> {
    pub(super) frame: &'a FrameConstants,
    pub(super) solids: &'a Solids,
    pub(super) ground_map: &'a GroundMap,
    pub(super) outlined: Option<Outline>,
    world_from_view: Affine3A,
}

impl<'a> Shader<'a> {
    pub(super) fn new(frame: &'a FrameConstants, solids: &'a Solids, ground_map: &'a GroundMap) -> Shader<'a> {
        Shader { frame, solids, ground_map, outlined: Outline::of(frame), world_from_view: frame.world_from_view() }
    }

    /// The same shading of other solids.
    pub(super) fn of<'b>(&self, solids: &'b Solids) -> Shader<'b>
    where
        'a: 'b,
    {
        Shader { solids, ..*self }
    }

    /// Depth at which a ray meets the ground, infinity if it does not.
    fn ground_depth(&self, ray: &Ray) -> f32 {
        if !self.frame.has_ground() {
            return f32::INFINITY;
        }
        let origin = self.world_from_view.transform_point3(ray.origin);
        ground_t(self.frame, origin, self.world_from_view.transform_vector3(ray.direction))
    }

    /// Normal in view space and linear colour of a hit.
    pub(super) fn surface(&self, ray: &Ray, index: u32, t: f32) -> Surface {
        let index = index as usize;
        let normal = primitive_normal(ray, self.solids, index, self.frame.depth[2], t);
        let color = match self.solids.primitive(index) {
            Primitive::Sphere(i) => self.solids.sphere_looks[i].0,
            Primitive::Cylinder(i) => {
                let (a, b, _) = self.solids.cylinder_looks[i];
                if cylinder_half(ray, &self.solids.cylinders[i], t) { b } else { a }
            }
            Primitive::Cone(i) => self.solids.cone_looks[i].0,
            Primitive::Torus(i) => self.solids.torus_looks[i].0,
            Primitive::Triangle(i) => {
                let weights = triangle_weights(ray, &self.solids.triangles[i]);
                let [a, b, c] = self.solids.triangle_looks[i].0.map(|color| Vec3::from(color.to_linear()));
                return Surface { depth: t, normal, albedo: a * weights.x + b * weights.y + c * weights.z };
            }
        };
        Surface { depth: t, normal, albedo: color.to_linear().into() }
    }

    /// Whether a primitive's hit is seen: not if the ground is nearer. Of a line its silhouette counts: moved back, it may lie
    /// under the ground.
    pub(super) fn is_seen(&self, ray: &Ray, index: u32, t: f32) -> bool {
        t - self.behind(index) <= self.ground_depth(ray)
    }

    /// How far behind its silhouette a primitive's line lies; 0 if this is no line's index.
    #[inline(always)]
    pub(super) fn behind(&self, index: u32) -> f32 {
        match &self.outlined {
            Some(outline) if index & RIM != 0 => outline.behind(self.solids, (index & !RIM) as usize),
            _ => 0.0,
        }
    }

    /// Colour of a line at this depth of a ray.
    pub(super) fn outline(&self, ray: &Ray, t: f32) -> Vec4 {
        Vec4::from((shade_outline(self.frame, ray.origin + ray.direction * t), 1.0))
    }

    /// Linear colour of a primitive's hit that is seen.
    pub(super) fn primitive(&self, ray: &Ray, index: u32, t: f32, reach: Reach) -> Vec4 {
        let surface = self.surface(ray, index, t);
        Vec4::from((shade_surface(self.frame, &surface, reach, ray), 1.0))
    }

    /// Depths at which the rays of plane coordinates meet the ground, infinity where they do not.
    #[inline(always)]
    pub(super) fn ground_beyond(&self, parallel: bool, u: &Lanes, v: &Lanes) -> Lanes {
        let mut depth = [f32::INFINITY; LANES];
        if !self.frame.has_ground() {
            return depth;
        }
        let [height, near] = [self.frame.ground[0], self.frame.depth[2]];
        // World y of the view's axes and of the eye.
        let m = &self.frame.world_from_view;
        let [right, up, back, eye] = [m[0][1], m[1][1], m[2][1], m[3][1]];
        for lane in 0..LANES {
            let aside = right * u[lane] + up * v[lane];
            let (origin, fall) = if parallel { (eye + aside, -back) } else { (eye, aside - back) };
            let t = (height - origin) / fall;
            let meets = (fall <= -1e-6) & (origin > height) & (t >= near);
            depth[lane] = if meets { t } else { f32::INFINITY };
        }
        depth
    }

    /// Premultiplied linear colour and alpha behind the primitives, ground or background. It is smooth, so it is found
    /// once a pixel, at its centre, and serves all samples that see no primitive.
    pub(super) fn backdrop(&self, center_ray: &Ray) -> Vec4 {
        let t = self.ground_depth(center_ray);
        if !t.is_finite() {
            return shade_background(self.frame);
        }
        let point = self.world_from_view.transform_point3(center_ray.origin + center_ray.direction * t);
        let [visible, open] = self.ground_map.at(self.frame, point);
        shade_ground(self.frame, point, visible, open)
    }

    /// Id, depth and normal of what is seen, given the nearest primitive and its depth.
    pub(super) fn facts(&self, ray: &Ray, nearest: Option<(u32, f32)>) -> (u32, f32, [f32; 3]) {
        let ground = self.ground_depth(ray);
        match nearest {
            Some((index, t)) if t <= ground => {
                (self.solids.id(index as usize), t, self.surface(ray, index, t).normal.to_array())
            }
            _ if ground.is_finite() => {
                let up = Vec3::new(self.frame.up[0], self.frame.up[1], self.frame.up[2]);
                (GBuffer::GROUND, ground, up.to_array())
            }
            _ => (GBuffer::BACKGROUND, f32::INFINITY, [0.0; 3]),
        }
    }
}
