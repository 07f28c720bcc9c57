//! The cone's intersection: `x² + z² = (m + s·y)²` between two planes, on which both end radii are at least 0, so that the
//! second nappe is never met. A cone whose radii are equal (`s = 0`) is a cylinder and no special case.

use super::{body_interval, local_ray, max, min, select, slab_interval, visible_t};
use crate::render::solids::Cone;
use crate::scene::Ray;
use glam::Vec3;

/// Entry and exit of the infinite nappe; an empty interval for a miss. `slope` is the radius' change per ångström of y.
/// A ray along which neither the way across nor the radius changes by 1e-6 of its length is inside for ever or never.
#[inline(always)]
pub(super) fn nappe_interval(q: Vec3, e: Vec3, middle: f32, slope: f32) -> (f32, f32) {
    // Radius at the local origin, and how it changes along the ray.
    let rho = middle + slope * q.y;
    let sigma = slope * e.y;
    let ee = e.x * e.x + e.z * e.z;
    let a = ee - sigma * sigma;
    let half_b = q.x * e.x + q.z * e.z - sigma * rho;
    let qq = q.x * q.x + q.z * q.z;
    let c = qq - rho * rho;
    // half_b² − a·c as a difference of squares: as it stands, its terms cancel.
    let (wx, wz) = (rho * e.x - sigma * q.x, rho * e.z - sigma * q.z);
    let across = q.x * e.z - q.z * e.x;
    let discriminant = wx * wx + wz * wz - across * across;
    let root = max(discriminant, 0.0).sqrt();
    // The two roots without cancellation. With a → 0 (the ray is parallel to a line of the cone) the first goes to infinity.
    let sum = select(half_b > 0.0, -half_b - root, root - half_b);
    let far = sum / select(a == 0.0, -1e-30, a);
    let near = select(sum == 0.0, far, c / select(sum == 0.0, 1.0, sum));
    let (first, second) = (min(far, near), max(far, near));
    // Steeper than the cone (a ≤ 0) the ray crosses each nappe once; on ours the radius grows away from the crossing.
    let across_both = a > 0.0;
    let widens = sigma > 0.0;
    let entry = select(across_both, first, select(widens, second, f32::NEG_INFINITY));
    let exit = select(across_both, second, select(widens, f32::INFINITY, first));
    let miss = across_both & (discriminant < 0.0);
    let parallel = ee + sigma * sigma <= 1e-12 * (ee + e.y * e.y);
    let inside = c <= 0.0;
    let entry = select(parallel, select(inside, f32::NEG_INFINITY, f32::INFINITY), entry);
    let exit = select(parallel, select(inside, f32::INFINITY, f32::NEG_INFINITY), exit);
    let miss = miss & !parallel;
    (select(miss, f32::INFINITY, entry), select(miss, f32::NEG_INFINITY, exit))
}

/// `t` of the first hit with a cone at `t ≥ near`; `near` itself inside the solid; infinity for a miss.
#[inline(always)]
#[must_use]
pub fn cone_t(ray: &Ray, cone: &Cone, near: f32) -> f32 {
    let (q, e, t0) = local_ray(ray, cone.center, &cone.cone_from_space);
    let nappe = nappe_interval(q, e, cone.middle_radius, cone.slope);
    let (entry, exit) = body_interval(nappe, slab_interval(q, e, cone.half_length));
    visible_t(t0 + entry, t0 + exit, near)
}

/// Unit normal of a cone at the hit that [`cone_t`] gave; towards the camera where the near plane cuts the solid.
#[must_use]
pub fn cone_normal(ray: &Ray, cone: &Cone, near: f32, t: f32) -> Vec3 {
    let to_camera = -ray.direction.normalize();
    if t <= near {
        return to_camera;
    }
    let (q, e, _) = local_ray(ray, cone.center, &cone.cone_from_space);
    let slab = slab_interval(q, e, cone.half_length);
    // The crossing itself: t − t0 has been rounded.
    let (entry, _) = body_interval(nappe_interval(q, e, cone.middle_radius, cone.slope), slab);
    let local_normal = if entry == slab.0 {
        Vec3::new(0.0, if e.y > 0.0 { -1.0 } else { 1.0 }, 0.0)
    } else {
        let p = q + e * entry;
        // Outwards, and towards the tip; at the tip itself there is no direction outwards.
        let out = Vec3::new(p.x, 0.0, p.z).normalize_or_zero();
        Vec3::new(out.x, -cone.slope, out.z)
    };
    let normal = (cone.cone_from_space.transpose() * local_normal).normalize_or(to_camera);
    if normal.dot(ray.direction) > 0.0 { towards_camera(normal, ray.direction) } else { normal }
}

/// A normal that rounding turned away from the ray, at right angles to it.
pub(super) fn towards_camera(normal: Vec3, direction: Vec3) -> Vec3 {
    let back = -direction.normalize();
    (normal - back * normal.dot(back)).normalize_or(back)
}
