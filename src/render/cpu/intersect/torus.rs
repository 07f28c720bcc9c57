//! The torus' intersection: a march along the ray by its distance, `√((√(x²+z²) − R)² + y²) − r`, inside its bounds.
//!
//! Plain sphere tracing creeps where a ray grazes the tube. But on a straight way the distance to the ring's circle bends
//! down by no more than `1/ρ`, `ρ` being the distance from the axis (the Hessian's only negative eigenvalue is that of
//! the turn about the axis). From the distance and its slope follows a step that is still safe, and near the surface
//! it is Newton's: some ten steps find a hit to a hundred-thousandth of the tube's radius, and no tube is jumped.

use super::cone::towards_camera;
use super::cylinder::side_interval;
use super::{body_interval, local_ray, slab_interval};
use crate::math::{max, min};
use crate::render::solids::Torus;
use crate::scene::Ray;
use glam::{Vec2, Vec3};

/// Steps of a march at most. Chosen, well beyond what the property tests need; a ray that has not arrived then runs along
/// the tube, less than a hundred-thousandth of its radius away from touching it.
const MOST_STEPS: u32 = 96;

/// Distance from the ring's circle, and its gradient.
#[inline(always)]
pub(super) fn ring_distance(p: Vec3, ring_radius: f32) -> (f32, Vec3) {
    let across = Vec2::new(p.x, p.z).length();
    let beside = across - ring_radius;
    let distance = Vec2::new(beside, p.y).length();
    let over = 1.0 / if distance > 0.0 { distance } else { 1.0 };
    // On the axis every direction outwards is as good.
    let outward = beside * over / if across > 0.0 { across } else { 1.0 };
    (distance, Vec3::new(p.x * outward, p.y * over, p.z * outward))
}

/// Rays in a torus' space, one a lane: their origins, moved to the point nearest the centre, their directions, and the `t` of the
/// origins.
struct LocalRays<const N: usize> {
    q: [[f32; N]; 3],
    e: [[f32; N]; 3],
    t0: [f32; N],
}

impl<const N: usize> LocalRays<N> {
    #[inline(always)]
    fn new(torus: &Torus, ray: impl Fn(usize) -> Ray) -> LocalRays<N> {
        let mut rays = LocalRays { q: [[0.0; N]; 3], e: [[0.0; N]; 3], t0: [0.0; N] };
        for lane in 0..N {
            let (q, e, t0) = local_ray(&ray(lane), torus.center, &torus.torus_from_space);
            (rays.q[0][lane], rays.q[1][lane], rays.q[2][lane]) = (q.x, q.y, q.z);
            (rays.e[0][lane], rays.e[1][lane], rays.e[2][lane]) = (e.x, e.y, e.z);
            rays.t0[lane] = t0;
        }
        rays
    }

    #[inline(always)]
    fn q(&self, lane: usize) -> Vec3 {
        Vec3::new(self.q[0][lane], self.q[1][lane], self.q[2][lane])
    }

    #[inline(always)]
    fn e(&self, lane: usize) -> Vec3 {
        Vec3::new(self.e[0][lane], self.e[1][lane], self.e[2][lane])
    }

    /// `t` of the first hit at `t ≥ near` and the same from the local origin on; infinity for a miss. All lanes march together,
    /// each as it would alone.
    #[inline(always)]
    fn hits(&self, torus: &Torus, near: f32) -> [[f32; N]; 2] {
        let (ring, tube) = (torus.ring_radius, torus.tube_radius);
        // Three roundings of the coordinates of a point on the surface.
        let slack = 3.0 * f32::EPSILON * (ring + tube);
        let reached = 1e-5 * tube + slack;
        let mut hits = [[f32::INFINITY; N]; 2];
        let (mut per_t, mut way, mut end, mut distance) = ([1.0f32; N], [0.0f32; N], [0.0f32; N], [0.0f32; N]);
        // Lanes on their way, and those that start between entry and exit.
        let (mut left, mut inside, mut any) = ([0u32; N], [0u32; N], 0);
        let mut u = [[0.0f32; N]; 3];
        for lane in 0..N {
            let (q, e) = (self.q(lane), self.e(lane));
            let wide = body_interval(side_interval(q, e, ring + tube + slack), slab_interval(q, e, tube + slack));
            let start = near - self.t0[lane];
            let meets = (wide.0 <= wide.1) & (wide.1 >= start);
            per_t[lane] = e.length();
            let along = e / per_t[lane];
            (u[0][lane], u[1][lane], u[2][lane]) = (along.x, along.y, along.z);
            way[lane] = max(wide.0, start) * per_t[lane];
            end[lane] = wide.1 * per_t[lane];
            left[lane] = if meets { u32::MAX } else { 0 };
            inside[lane] = if start >= wide.0 { u32::MAX } else { 0 };
            any |= left[lane];
        }
        let mut step = 0;
        while any != 0 && step < MOST_STEPS {
            // Inside at the near plane: that is where the solid is cut.
            let first = if step == 0 { u32::MAX } else { 0 };
            any = 0;
            for lane in 0..N {
                let u = Vec3::new(u[0][lane], u[1][lane], u[2][lane]);
                let p = self.q(lane) + u * way[lane];
                let (to_ring, gradient) = ring_distance(p, ring);
                let off = to_ring - tube;
                let local = way[lane] / per_t[lane];
                let cut = inside[lane] & first != 0;
                let (t, local) = if cut { (near, near - self.t0[lane]) } else { (self.t0[lane] + local, local) };
                let arrives = (off <= reached) & (left[lane] != 0);
                hits[0][lane] = if arrives { t } else { hits[0][lane] };
                hits[1][lane] = if arrives { local } else { hits[1][lane] };
                let slope = gradient.x * u.x + gradient.y * u.y + gradient.z * u.z;
                let reach = 0.5 * (p.x * p.x + p.z * p.z).sqrt();
                let bend = 1.0 / if reach > 0.0 { reach } else { 1e-30 };
                let bent = 2.0 * off / max((slope * slope + 2.0 * bend * off).sqrt() - slope, 1e-30);
                let next = way[lane] + max(off, min(bent, reach));
                let stays = (left[lane] != 0) & !arrives & (next <= end[lane]);
                way[lane] = if stays { next } else { way[lane] };
                distance[lane] = off;
                left[lane] = if stays { u32::MAX } else { 0 };
                any |= left[lane];
            }
            step += 1;
        }
        for lane in 0..N {
            let grazes = (left[lane] != 0) & (distance[lane] <= 10.0 * reached);
            let local = way[lane] / per_t[lane];
            hits[0][lane] = if grazes { self.t0[lane] + local } else { hits[0][lane] };
            hits[1][lane] = if grazes { local } else { hits[1][lane] };
        }
        hits
    }
}

/// `t` of the first hit at `t ≥ near` and the same from the local origin `q` on; infinity for a miss.
pub(super) fn torus_hit(q: Vec3, e: Vec3, torus: &Torus, t0: f32, near: f32) -> (f32, f32) {
    let rays = LocalRays { q: [[q.x], [q.y], [q.z]], e: [[e.x], [e.y], [e.z]], t0: [t0] };
    let [[t], [local]] = rays.hits(torus, near);
    (t, local)
}

/// As [`torus_t`], of several rays at once.
#[inline(always)]
pub(in crate::render::cpu) fn torus_ts<const N: usize>(
    ray: impl Fn(usize) -> Ray,
    torus: &Torus,
    near: f32,
) -> [f32; N] {
    let rays = LocalRays::new(torus, ray);
    let [mut t, _] = rays.hits(torus, near);
    for t in &mut t {
        *t = max(*t, near);
    }
    t
}

/// `t` of the first hit with a torus at `t ≥ near`; `near` itself inside the solid; infinity for a miss.
#[must_use]
pub fn torus_t(ray: &Ray, torus: &Torus, near: f32) -> f32 {
    let [t] = torus_ts(|_| *ray, torus, near);
    t
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
