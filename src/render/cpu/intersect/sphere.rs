//! The sphere's intersection.

use super::{max, select, visible_t};
use crate::render::solids::Sphere;
use crate::scene::Ray;
use glam::Vec3;

/// Where a ray is inside a sphere; an empty interval for a miss.
#[inline(always)]
pub(super) fn sphere_interval(ray: &Ray, sphere: &Sphere) -> (f32, f32) {
    let d = ray.direction;
    let dd = d.x * d.x + d.y * d.y + d.z * d.z;
    let c = sphere.center - ray.origin;
    let t0 = (c.x * d.x + c.y * d.y + c.z * d.z) / dd;
    let p = d * t0 - c;
    let pd = p.x * d.x + p.y * d.y + p.z * d.z;
    let outside = p.x * p.x + p.y * p.y + p.z * p.z - sphere.radius * sphere.radius;
    let discriminant = pd * pd - dd * outside;
    let root = max(discriminant, 0.0).sqrt();
    let (entry, exit) = (t0 + (-pd - root) / dd, t0 + (-pd + root) / dd);
    (select(discriminant >= 0.0, entry, f32::INFINITY), exit)
}

/// `t` of the first hit with a sphere at `t ≥ near`; `near` itself inside the sphere; infinity for a miss.
#[inline(always)]
#[must_use]
pub fn sphere_t(ray: &Ray, sphere: &Sphere, near: f32) -> f32 {
    let (entry, exit) = sphere_interval(ray, sphere);
    visible_t(entry, exit, near)
}

/// [`sphere_t`] of a sphere that lies beyond the near plane.
#[inline(always)]
#[must_use]
pub fn sphere_entry(ray: &Ray, sphere: &Sphere) -> f32 {
    sphere_interval(ray, sphere).0
}

/// Unit normal of a sphere at the hit that [`sphere_t`] gave; towards the camera where the near plane cuts the solid.
#[must_use]
pub fn sphere_normal(ray: &Ray, sphere: &Sphere, near: f32, t: f32) -> Vec3 {
    if t <= near {
        return -ray.direction.normalize();
    }
    // The way through the local origin again: `origin + t·direction − center` from the eye would lose digits.
    let d = ray.direction;
    let c = sphere.center - ray.origin;
    let dd = d.dot(d);
    let t0 = c.dot(d) / dd;
    let p = d * t0 - c;
    let pd = p.dot(d);
    let discriminant = pd * pd - dd * (p.dot(p) - sphere.radius * sphere.radius);
    let local = (-pd - discriminant.max(0.0).sqrt()) / dd;
    ((p + d * local) / sphere.radius).normalize_or(-d)
}
