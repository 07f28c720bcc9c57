//! The cylinder's intersection: a side and two ends, each open, flat or round.

use super::{body_interval, local_ray, max, min, select, slab_interval, visible_t};
use crate::render::solids::Cylinder;
use crate::scene::Ray;
use glam::Vec3;

/// The ray in the cylinder's space, its origin moved to the point nearest the cylinder's centre.
#[inline(always)]
pub(super) fn cylinder_ray(ray: &Ray, cylinder: &Cylinder) -> (Vec3, Vec3, f32) {
    local_ray(ray, cylinder.center, &cylinder.cylinder_from_space)
}

/// Entry and exit of the infinite cylinder `x² + z² = r²`; an empty interval for a miss. A ray within 1e-6 rad of the
/// axis is inside for ever or never (over a stick's length it drifts less than f32 resolves).
#[inline(always)]
pub(super) fn side_interval(q: Vec3, e: Vec3, radius: f32) -> (f32, f32) {
    let a = e.x * e.x + e.z * e.z;
    let parallel = a <= 1e-12 * (a + e.y * e.y);
    let across = q.x * e.z - q.z * e.x;
    // r²a − (q×e)²: the discriminant without the cancellation of b² − ac.
    let discriminant = radius * radius * a - across * across;
    let root = max(discriminant, 0.0).sqrt();
    let qe = q.x * e.x + q.z * e.z;
    let over_a = 1.0 / select(parallel, 1.0, a);
    let inside = q.x * q.x + q.z * q.z <= radius * radius;
    let entry = select(parallel, select(inside, f32::NEG_INFINITY, f32::INFINITY), (-qe - root) * over_a);
    let exit = select(parallel, select(inside, f32::INFINITY, f32::NEG_INFINITY), (-qe + root) * over_a);
    let miss = !parallel && discriminant < 0.0;
    (select(miss, f32::INFINITY, entry), select(miss, f32::NEG_INFINITY, exit))
}

/// Entry and exit of the ball at the end `y` of a cylinder; an empty interval for a miss.
#[inline(always)]
fn end_interval(q: Vec3, e: Vec3, y: f32, radius: f32) -> (f32, f32) {
    let p = Vec3::new(q.x, q.y - y, q.z);
    let dd = e.x * e.x + e.y * e.y + e.z * e.z;
    // From the ray's point nearest the ball: the cylinder's centre may be a thousand radii away.
    let middle = -(p.x * e.x + p.y * e.y + p.z * e.z) / dd;
    let m = p + e * middle;
    let left = radius * radius - (m.x * m.x + m.y * m.y + m.z * m.z);
    let half = (max(left, 0.0) / dd).sqrt();
    let miss = left < 0.0;
    (select(miss, f32::INFINITY, middle - half), select(miss, f32::NEG_INFINITY, middle + half))
}

/// Whether cap `end` (0 for a, 1 for b) is `kind`.
#[inline(always)]
fn has_cap(caps: u32, end: u32, kind: u32) -> bool {
    (caps >> (2 * end)) & 3 == kind
}

/// `t` of the first hit with a cylinder at `t ≥ near`; `near` itself inside the solid; infinity for a miss.
#[inline(always)]
#[must_use]
pub fn cylinder_t(ray: &Ray, cylinder: &Cylinder, near: f32) -> f32 {
    if cylinder.caps == FLAT_CAPS {
        return flat_cylinder_t(ray, cylinder, near);
    }
    let (q, e, t0) = cylinder_ray(ray, cylinder);
    capped_t(q, e, cylinder, t0, near)
}

/// [`cylinder_t`] where both caps are known to be flat.
#[inline(always)]
#[must_use]
pub fn flat_cylinder_t(ray: &Ray, cylinder: &Cylinder, near: f32) -> f32 {
    let (q, e, t0) = cylinder_ray(ray, cylinder);
    let side = side_interval(q, e, cylinder.radius);
    let (entry, exit) = body_interval(side, slab_interval(q, e, cylinder.half_length));
    visible_t(t0 + entry, t0 + exit, near)
}

/// [`Cylinder::caps`] of two flat ends, as in all styles with balls.
pub const FLAT_CAPS: u32 = 1 | 1 << 2;

/// Entry and exit of a cylinder with its half balls, and those of its slab: where they are equal the ray passes a cap's plane.
#[inline(always)]
pub(super) fn capped_interval(q: Vec3, e: Vec3, cylinder: &Cylinder) -> ((f32, f32), (f32, f32)) {
    let h = cylinder.half_length;
    let slab = slab_interval(q, e, h);
    let (mut entry, mut exit) = body_interval(side_interval(q, e, cylinder.radius), slab);
    for end in 0..2 {
        let is_round = has_cap(cylinder.caps, end, 2);
        let sign = if end == 0 { -1.0 } else { 1.0 };
        let (mut ball_in, mut ball_out) = end_interval(q, e, sign * h, cylinder.radius);
        // A ball wider than the stick is long must not come out of the other end.
        let cut = !has_cap(cylinder.caps, 1 - end, 2);
        let across = e.y.abs() <= 1e-20;
        let inward = sign * e.y > 0.0;
        let beside = select(sign * q.y >= -h, ball_in, f32::INFINITY);
        ball_in = select(cut && across, beside, select(cut && inward, max(ball_in, slab.0), ball_in));
        ball_out = select(cut && !across && !inward, min(ball_out, slab.1), ball_out);
        let hit = is_round && ball_in <= ball_out;
        entry = select(hit, min(entry, ball_in), entry);
        exit = select(hit, max(exit, ball_out), exit);
    }
    ((entry, exit), slab)
}

/// Whether the ray enters, and whether it leaves, through an open end.
#[inline(always)]
fn through_open_ends(e: Vec3, caps: u32, solid: (f32, f32), slab: (f32, f32)) -> (bool, bool) {
    let first = u32::from(e.y <= 0.0);
    (solid.0 == slab.0 && has_cap(caps, first, 0), solid.1 == slab.1 && has_cap(caps, 1 - first, 0))
}

/// The general case: every end open, flat or round.
#[inline(always)]
fn capped_t(q: Vec3, e: Vec3, cylinder: &Cylinder, t0: f32, near: f32) -> f32 {
    let (solid, slab) = capped_interval(q, e, cylinder);
    let (entry, exit) = (t0 + solid.0, t0 + solid.1);
    let closed = !has_cap(cylinder.caps, 0, 0) && !has_cap(cylinder.caps, 1, 0);
    // An open end makes a surface, not a solid: the first of the crossings that is not through an open end.
    let (open_in, open_out) = through_open_ends(e, cylinder.caps, solid, slab);
    let far = select(solid.0 <= solid.1 && !open_out && exit >= near, exit, f32::INFINITY);
    let through = select(solid.0 <= solid.1 && !open_in && entry >= near, entry, far);
    select(closed, visible_t(entry, exit, near), through)
}

/// Unit normal of a cylinder at the hit that [`cylinder_t`] gave. On the side it is perpendicular to the axis; where
/// one sees the inside of an open cylinder, and where the near plane cuts the solid, it points to the camera.
#[must_use]
pub fn cylinder_normal(ray: &Ray, cylinder: &Cylinder, near: f32, t: f32) -> Vec3 {
    let to_camera = -ray.direction.normalize();
    let open = has_cap(cylinder.caps, 0, 0) || has_cap(cylinder.caps, 1, 0);
    if t <= near && !open {
        return to_camera;
    }
    let (q, e, t0) = cylinder_ray(ray, cylinder);
    let (solid, slab) = capped_interval(q, e, cylinder);
    let (open_in, _) = through_open_ends(e, cylinder.caps, solid, slab);
    let leaving = open && (open_in || t0 + solid.0 < near);
    // The crossing itself: t − t0 has been rounded.
    let (local, plane) = if leaving { (solid.1, slab.1) } else { (solid.0, slab.0) };
    let local_normal = if local == plane {
        Vec3::new(0.0, if e.y > 0.0 { -1.0 } else { 1.0 }, 0.0)
    } else {
        let p = q + e * local;
        let round = has_cap(cylinder.caps, u32::from(p.y > 0.0), 2);
        let axial = if round { p.y.clamp(-cylinder.half_length, cylinder.half_length) } else { p.y };
        (p - Vec3::new(0.0, axial, 0.0)).normalize_or(-e)
    };
    let normal = cylinder.cylinder_from_space.transpose() * local_normal;
    // Seen from inside, an open cylinder shows its back.
    let towards = if open && normal.dot(ray.direction) > 0.0 { -normal } else { normal };
    towards.normalize_or(to_camera)
}

/// Whether the hit is on the half of end b.
#[must_use]
pub fn cylinder_half(ray: &Ray, cylinder: &Cylinder, t: f32) -> bool {
    let (q, e, t0) = cylinder_ray(ray, cylinder);
    q.y + (t - t0) * e.y > 0.0
}
