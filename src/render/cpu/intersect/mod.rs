//! Exact intersections of a view ray with the primitives. `shaders/intersect.wgsl` and the files that it is cut into by
//! primitive hold the twin of each function, under the same name.
//!
//! In each, the ray's origin is first moved to its point nearest the primitive's centre (`t = t0 + t_local`): solving
//! from the eye loses the digits that decide hit or miss at a few hundred ångström. The `*_t` functions are written
//! without branches, so that loops over pixels become vector code with the same bits as one call alone (the torus', a
//! search, is not).

mod cone;
mod cylinder;
mod middle;
mod sphere;
mod torus;
mod triangle;

pub use cone::{cone_normal, cone_t};
pub use cylinder::{FLAT_CAPS, cylinder_half, cylinder_normal, cylinder_t, flat_cylinder_t};
pub use middle::{
    cone_middle_t, cylinder_middle_t, flat_cylinder_middle_t, outlined_t, sphere_middle_t, torus_middle_t,
};
pub use sphere::{sphere_entry, sphere_normal, sphere_t};
pub(super) use torus::torus_ts;
pub use torus::{torus_normal, torus_t};
pub use triangle::{triangle_normal, triangle_t, triangle_weights};

use crate::math::{max, min};
use crate::render::solids::{Primitive, Solids};
use crate::scene::Ray;
use glam::{Mat3, Vec3};

/// `a` where the condition holds, else `b`; becomes a blend in vector code.
#[inline(always)]
fn select(condition: bool, a: f32, b: f32) -> f32 {
    if condition { a } else { b }
}

/// Where a solid's entry and exit give a hit at or beyond `near`: the entry, or `near` inside the solid, else infinity.
#[inline(always)]
fn visible_t(entry: f32, exit: f32, near: f32) -> f32 {
    let hit = entry <= exit && exit >= near;
    select(hit, max(entry, near), f32::INFINITY)
}

/// The ray in a primitive's space: its origin, moved to the point nearest the primitive's centre, its direction, and the `t` of
/// that origin.
#[inline(always)]
fn local_ray(ray: &Ray, center: Vec3, local_from_space: &Mat3) -> (Vec3, Vec3, f32) {
    let d = ray.direction;
    let dd = d.x * d.x + d.y * d.y + d.z * d.z;
    let c = center - ray.origin;
    let t0 = (c.x * d.x + c.y * d.y + c.z * d.z) / dd;
    let p = d * t0 - c;
    (*local_from_space * p, *local_from_space * d, t0)
}

/// Entry and exit of the slab `−h ≤ y ≤ h`.
#[inline(always)]
fn slab_interval(q: Vec3, e: Vec3, half_length: f32) -> (f32, f32) {
    let along = e.y.abs() <= 1e-20;
    let over = 1.0 / select(along, 1.0, e.y);
    let (y0, y1) = ((-half_length - q.y) * over, (half_length - q.y) * over);
    let inside = q.y.abs() <= half_length;
    (
        select(along, select(inside, f32::NEG_INFINITY, f32::INFINITY), min(y0, y1)),
        select(along, select(inside, f32::INFINITY, f32::NEG_INFINITY), max(y0, y1)),
    )
}

/// Entry and exit of the solid between the side and two flat caps; an empty interval for a miss.
#[inline(always)]
fn body_interval(side: (f32, f32), slab: (f32, f32)) -> (f32, f32) {
    let (entry, exit) = (max(side.0, slab.0), min(side.1, slab.1));
    let hit = entry <= exit;
    (select(hit, entry, f32::INFINITY), select(hit, exit, f32::NEG_INFINITY))
}

/// `t` of the first hit with primitive `index` at `t ≥ near`; infinity for a miss.
#[must_use]
pub fn primitive_t(ray: &Ray, solids: &Solids, index: usize, near: f32) -> f32 {
    match solids.primitive(index) {
        Primitive::Sphere(i) => sphere_t(ray, &solids.spheres[i], near),
        Primitive::Cylinder(i) => cylinder_t(ray, &solids.cylinders[i], near),
        Primitive::Cone(i) => cone_t(ray, &solids.cones[i], near),
        Primitive::Torus(i) => torus_t(ray, &solids.tori[i], near),
        Primitive::Triangle(i) => triangle_t(ray, &solids.triangles[i], near),
    }
}

/// Unit normal of primitive `index` at the hit that [`primitive_t`] gave.
#[must_use]
pub fn primitive_normal(ray: &Ray, solids: &Solids, index: usize, near: f32, t: f32) -> Vec3 {
    match solids.primitive(index) {
        Primitive::Sphere(i) => sphere_normal(ray, &solids.spheres[i], near, t),
        Primitive::Cylinder(i) => cylinder_normal(ray, &solids.cylinders[i], near, t),
        Primitive::Cone(i) => cone_normal(ray, &solids.cones[i], near, t),
        Primitive::Torus(i) => torus_normal(ray, &solids.tori[i], near, t),
        Primitive::Triangle(i) => triangle_normal(ray, &solids.triangles[i]),
    }
}

#[cfg(test)]
mod shape_tests;
#[cfg(test)]
mod tests;
