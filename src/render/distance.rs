//! Signed distances of the primitives, and where a way passes them closest: what [`super::field`] is made of.
//! `shaders/field.wgsl` and `shaders/distance.wgsl` hold the twins.

use super::solids::{Cone, Cylinder, Sphere, Torus, Triangle};
use glam::{Vec2, Vec3};

/// Distance to a sphere, negative inside.
#[inline]
#[must_use]
pub fn sphere_distance(p: Vec3, sphere: &Sphere) -> f32 {
    (p - sphere.center).length() - sphere.radius
}

/// Distance to a capped cylinder, negative inside. Round caps count, open ends are taken as closed: the field bounds solids.
#[inline]
#[must_use]
pub fn cylinder_distance(p: Vec3, cylinder: &Cylinder) -> f32 {
    let q = cylinder.cylinder_from_space * (p - cylinder.center);
    let beyond = q.y.abs() - cylinder.half_length;
    let across = (q.x * q.x + q.z * q.z).sqrt();
    let round = (cylinder.caps >> if q.y > 0.0 { 2 } else { 0 }) & 3 == 2;
    if round {
        let up = beyond.max(0.0);
        return (across * across + up * up).sqrt() - cylinder.radius;
    }
    let out = across - cylinder.radius;
    out.max(beyond).min(0.0) + Vec2::new(out, beyond).max(Vec2::ZERO).length()
}

/// The `t` at which `p + t·direction` (a unit vector) is nearest to the axis of a cylinder.
#[inline]
#[must_use]
pub fn nearest_on_way(p: Vec3, direction: Vec3, cylinder: &Cylinder) -> f32 {
    let axis = cylinder.axis();
    let to_center = cylinder.center - p;
    let (along, across) = (direction.dot(to_center), axis.dot(to_center));
    let cosine = direction.dot(axis);
    let sine_squared = 1.0 - cosine * cosine;
    // Parallel: every point of the axis is as near as the middle.
    let s = if sine_squared > 1e-6 { (cosine * along - across) / sine_squared } else { 0.0 };
    along + cosine * s.clamp(-cylinder.half_length, cylinder.half_length)
}

/// Distance to a cone with its caps, negative inside: in the half section, a quadrilateral with one side on the axis.
#[inline]
#[must_use]
pub fn cone_distance(p: Vec3, cone: &Cone) -> f32 {
    let q = cone.cone_from_space * (p - cone.center);
    let at = Vec2::new(Vec2::new(q.x, q.z).length(), q.y);
    let (h, [radius_a, radius_b]) = (cone.half_length, cone.radii);
    // The nearest points of the side and of the nearer cap.
    let (low, side) = (Vec2::new(radius_a, -h), Vec2::new(radius_b - radius_a, 2.0 * h));
    let along = ((at - low).dot(side) / side.length_squared()).clamp(0.0, 1.0);
    let to_side = at - (low + side * along);
    let cap_radius = if at.y < 0.0 { radius_a } else { radius_b };
    let to_cap = Vec2::new(at.x - at.x.min(cap_radius), at.y.abs() - h);
    let outside_of_side = (at - low).dot(Vec2::new(side.y, -side.x)) > 0.0;
    let distance = to_side.length_squared().min(to_cap.length_squared()).sqrt();
    if outside_of_side || to_cap.y > 0.0 { distance } else { -distance }
}

/// Distance to a torus, negative inside the tube.
#[inline]
#[must_use]
pub fn torus_distance(p: Vec3, torus: &Torus) -> f32 {
    let q = torus.torus_from_space * (p - torus.center);
    Vec2::new(Vec2::new(q.x, q.z).length() - torus.ring_radius, q.y).length() - torus.tube_radius
}

/// Distance to a triangle; it has no inside.
#[inline]
#[must_use]
pub fn triangle_distance(p: Vec3, triangle: &Triangle) -> f32 {
    let q = p - triangle.center;
    let n = triangle.face;
    let mut over_face = true;
    let mut to_edge = f32::INFINITY;
    for i in 0..3 {
        let (from, to) = (triangle.corners[i], triangle.corners[(i + 1) % 3]);
        let (edge, way) = (to - from, q - from);
        over_face &= n.cross(edge).dot(way) >= 0.0;
        let nearest = way - edge * (way.dot(edge) / edge.length_squared().max(1e-30)).clamp(0.0, 1.0);
        to_edge = to_edge.min(nearest.length_squared());
    }
    let above = n.dot(q - triangle.corners[0]);
    if over_face { above.abs() / n.length() } else { to_edge.sqrt() }
}

/// Steps of the search of a part of a way: it is down to 1.6⁻¹⁴, a thousandth, of it then.
const SEARCH_STEPS: u32 = 14;

/// Where on a way (`p`, unit direction, first `t`) past a primitive, that is inside a ball, the distance is the smallest part of
/// `t`, and the distance there. Along a straight way past a convex primitive that part falls and then rises, so that
/// golden sections find it; others are searched in `parts`.
pub fn least_on_way(
    (p, direction, start): (Vec3, Vec3, f32),
    center: Vec3,
    radius: f32,
    parts: u32,
    distance: impl Fn(Vec3) -> f32,
) -> (f32, f32) {
    const GOLDEN: f32 = 0.618_034;
    let middle = (center - p).dot(direction);
    let (low, high) = ((middle - radius).max(start), (middle + radius).max(start));
    let at = |t: f32| distance(p + direction * t);
    let mut best = (low, at(low));
    let part = (high - low) / parts as f32;
    for i in 0..parts {
        let (mut from, mut to) = (low + part * i as f32, low + part * (i + 1) as f32);
        let (mut a, mut b) = (to - (to - from) * GOLDEN, from + (to - from) * GOLDEN);
        let (mut at_a, mut at_b) = (at(a), at(b));
        for _ in 0..SEARCH_STEPS {
            if at_a * b < at_b * a {
                (to, b, at_b) = (b, a, at_a);
                a = to - (to - from) * GOLDEN;
                at_a = at(a);
            } else {
                (from, a, at_a) = (a, b, at_b);
                b = from + (to - from) * GOLDEN;
                at_b = at(b);
            }
        }
        let found = if at_a * b < at_b * a { (a, at_a) } else { (b, at_b) };
        if found.1 * best.0 < best.1 * found.0 {
            best = found;
        }
    }
    best
}
