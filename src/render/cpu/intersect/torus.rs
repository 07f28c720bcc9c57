//! The torus' intersection: a march along the ray by its distance, `√((√(x²+z²) − R)² + y²) − r`, inside its bounds.
//!
//! Plain sphere tracing creeps where a ray grazes the tube. But on a straight way the distance to the ring's circle bends
//! down by no more than `1/ρ`, `ρ` being the distance from the axis (the Hessian's only negative eigenvalue is that of
//! the turn about the axis). From the distance and its slope follows a step that is still safe, and near the surface
//! it is Newton's: some ten steps find a hit to a hundred-thousandth of the tube's radius, and no tube is jumped.

use super::cone::towards_camera;
use super::cylinder::side_interval;
use super::{body_interval, local_ray, slab_interval};
use crate::render::solids::Torus;
use crate::scene::Ray;
use glam::{Vec2, Vec3};

/// Steps of a march at most. Chosen, well beyond what the property tests need; a ray that has not arrived then runs along
/// the tube, less than a hundred-thousandth of its radius away from touching it.
const MOST_STEPS: u32 = 96;

/// Distance from the ring's circle, and its gradient.
#[inline]
pub(super) fn ring_distance(p: Vec3, ring_radius: f32) -> (f32, Vec3) {
    let across = Vec2::new(p.x, p.z).length();
    let beside = across - ring_radius;
    let distance = Vec2::new(beside, p.y).length();
    let over = 1.0 / if distance > 0.0 { distance } else { 1.0 };
    // On the axis every direction outwards is as good.
    let outward = beside * over / if across > 0.0 { across } else { 1.0 };
    (distance, Vec3::new(p.x * outward, p.y * over, p.z * outward))
}

/// `t` of the first hit at `t ≥ near` and the same from the local origin `q` on; infinity for a miss.
pub(super) fn torus_hit(q: Vec3, e: Vec3, torus: &Torus, t0: f32, near: f32) -> (f32, f32) {
    let (ring, tube) = (torus.ring_radius, torus.tube_radius);
    // Three roundings of the coordinates of a point on the surface.
    let slack = 3.0 * f32::EPSILON * (ring + tube);
    let reached = 1e-5 * tube + slack;
    let wide = body_interval(side_interval(q, e, ring + tube + slack), slab_interval(q, e, tube + slack));
    let miss = (f32::INFINITY, f32::INFINITY);
    let start = near - t0;
    if !(wide.0 <= wide.1 && wide.1 >= start) {
        return miss;
    }
    let per_t = e.length();
    let u = e / per_t;
    let mut way = wide.0.max(start) * per_t;
    let end = wide.1 * per_t;
    let mut distance = 0.0;
    for step in 0..MOST_STEPS {
        let p = q + u * way;
        let (to_ring, gradient) = ring_distance(p, ring);
        distance = to_ring - tube;
        if distance <= reached {
            // Inside at the near plane: that is where the solid is cut.
            let cut = step == 0 && start >= wide.0;
            return if cut { (near, start) } else { (t0 + way / per_t, way / per_t) };
        }
        let slope = gradient.dot(u);
        let reach = 0.5 * Vec2::new(p.x, p.z).length();
        let bend = 1.0 / if reach > 0.0 { reach } else { 1e-30 };
        let bent = 2.0 * distance / ((slope * slope + 2.0 * bend * distance).sqrt() - slope).max(1e-30);
        way += distance.max(bent.min(reach));
        if way > end {
            return miss;
        }
    }
    if distance <= 10.0 * reached { (t0 + way / per_t, way / per_t) } else { miss }
}

/// `t` of the first hit with a torus at `t ≥ near`; `near` itself inside the solid; infinity for a miss.
#[must_use]
pub fn torus_t(ray: &Ray, torus: &Torus, near: f32) -> f32 {
    let (q, e, t0) = local_ray(ray, torus.center, &torus.torus_from_space);
    let (t, _) = torus_hit(q, e, torus, t0, near);
    if t >= near { t } else { near }
}

/// Unit normal of a torus at the hit that [`torus_t`] gave; towards the camera where the near plane cuts the solid.
#[must_use]
pub fn torus_normal(ray: &Ray, torus: &Torus, near: f32, t: f32) -> Vec3 {
    let to_camera = -ray.direction.normalize();
    if t <= near {
        return to_camera;
    }
    let (q, e, t0) = local_ray(ray, torus.center, &torus.torus_from_space);
    // The hit itself: t − t0 has been rounded.
    let (_, local) = torus_hit(q, e, torus, t0, near);
    if local == f32::INFINITY {
        return to_camera;
    }
    let (_, gradient) = ring_distance(q + e * local, torus.ring_radius);
    let normal = (torus.torus_from_space.transpose() * gradient).normalize_or(to_camera);
    if normal.dot(ray.direction) > 0.0 { towards_camera(normal, ray.direction) } else { normal }
}
