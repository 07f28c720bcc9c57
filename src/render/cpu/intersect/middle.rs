//! Where a ray is midway through a solid: the depth of a silhouette, for outlines ([`crate::render::outline`]).

use super::cone::nappe_interval;
use super::cylinder::{capped_interval, cylinder_ray, side_interval};
use super::sphere::sphere_interval;
use super::torus::{ring_distance, torus_hit};
use super::{FLAT_CAPS, body_interval, local_ray, max, primitive_t, select, slab_interval};
use crate::render::outline::{Outline, RIM};
use crate::render::solids::{Cone, Cylinder, Primitive, Solids, Sphere, Torus};
use crate::scene::Ray;

/// The middle of what lies beyond `near`; infinity for a miss.
#[inline(always)]
fn middle((entry, exit): (f32, f32), near: f32) -> f32 {
    let hit = entry <= exit && exit >= near;
    select(hit, 0.5 * (max(entry, near) + exit), f32::INFINITY)
}

/// `t` midway through a sphere; infinity for a miss.
#[inline(always)]
#[must_use]
pub fn sphere_middle_t(ray: &Ray, sphere: &Sphere, near: f32) -> f32 {
    middle(sphere_interval(ray, sphere), near)
}

/// `t` midway through a cylinder, open or not; infinity for a miss.
#[inline(always)]
#[must_use]
pub fn cylinder_middle_t(ray: &Ray, cylinder: &Cylinder, near: f32) -> f32 {
    if cylinder.caps == FLAT_CAPS {
        return flat_cylinder_middle_t(ray, cylinder, near);
    }
    let (q, e, t0) = cylinder_ray(ray, cylinder);
    let (solid, _) = capped_interval(q, e, cylinder);
    middle((t0 + solid.0, t0 + solid.1), near)
}

/// [`cylinder_middle_t`] where both caps are known to be flat.
#[inline(always)]
#[must_use]
pub fn flat_cylinder_middle_t(ray: &Ray, cylinder: &Cylinder, near: f32) -> f32 {
    let (q, e, t0) = cylinder_ray(ray, cylinder);
    let side = side_interval(q, e, cylinder.radius);
    let (entry, exit) = body_interval(side, slab_interval(q, e, cylinder.half_length));
    middle((t0 + entry, t0 + exit), near)
}

/// `t` midway through a cone; infinity for a miss.
#[inline(always)]
#[must_use]
pub fn cone_middle_t(ray: &Ray, cone: &Cone, near: f32) -> f32 {
    let (q, e, t0) = local_ray(ray, cone.center, &cone.cone_from_space);
    let nappe = nappe_interval(q, e, cone.middle_radius, cone.slope);
    let (entry, exit) = body_interval(nappe, slab_interval(q, e, cone.half_length));
    middle((t0 + entry, t0 + exit), near)
}

/// `t` midway through the tube of a torus where the ray first meets it, about; infinity for a miss.
#[must_use]
pub fn torus_middle_t(ray: &Ray, torus: &Torus, near: f32) -> f32 {
    let (q, e, t0) = local_ray(ray, torus.center, &torus.torus_from_space);
    let (t, local) = torus_hit(q, e, torus, t0, near);
    if t == f32::INFINITY || t <= near {
        return max(t, near);
    }
    let p = q + e * local;
    let (_, out) = ring_distance(p, torus.ring_radius);
    let across = (p.x * p.x + p.z * p.z).sqrt();
    let over = 1.0 / select(across > 0.0, across, 1.0);
    let along = (p.x * e.z - p.z * e.x) * over;
    let ee = e.x * e.x + e.y * e.y + e.z * e.z;
    // Half the chord of a surface that bends as this one does along the ray: as the tube across, as the ring along; no longer than about
    // three radii where the two cancel.
    let inwards = max(-(out.x * e.x + out.y * e.y + out.z * e.z), 0.0);
    let ring_bend = along * along * (p.x * out.x + p.z * out.z) * over * over;
    let tube_bend = (ee - along * along) / torus.tube_radius;
    t + inwards / max(tube_bend + ring_bend, 0.1 * ee / torus.tube_radius)
}

/// Depth of the line around primitive `index`; infinity where the ray misses it.
fn rim_t(ray: &Ray, solids: &Solids, outline: &Outline, index: usize, near: f32) -> f32 {
    let middle = match solids.primitive(index) {
        Primitive::Sphere(i) => sphere_middle_t(ray, &outline.sphere(&solids.spheres[i]), near),
        Primitive::Cylinder(i) => cylinder_middle_t(ray, &outline.cylinder(&solids.cylinders[i]), near),
        Primitive::Cone(i) => cone_middle_t(ray, &outline.cone(&solids.cones[i]), near),
        Primitive::Torus(i) => torus_middle_t(ray, &outline.torus(&solids.tori[i]), near),
        Primitive::Triangle(_) => f32::INFINITY,
    };
    middle + outline.behind(solids, index)
}

/// `t` of the first hit with primitive `index` or, beside it, with its line, and the index, marked with [`RIM`] for the line; infinity for
/// a miss.
#[must_use]
pub fn outlined_t(ray: &Ray, solids: &Solids, outline: Option<&Outline>, index: u32, near: f32) -> (f32, u32) {
    let t = primitive_t(ray, solids, index as usize, near);
    match outline {
        Some(outline) if t == f32::INFINITY => (rim_t(ray, solids, outline, index as usize, near), index | RIM),
        _ => (t, index),
    }
}

#[cfg(test)]
#[path = "middle_tests.rs"]
mod tests;
