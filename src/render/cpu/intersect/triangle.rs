//! The triangle's intersection, by the volumes that the ray spans with its edges: two triangles give the edge that they
//! share the same volume, and each is wider by the rounding of its coordinates, so that a mesh has no pinholes.

use super::cone::towards_camera;
use super::select;
use crate::render::solids::Triangle;
use crate::scene::Ray;
use glam::Vec3;

/// The ray's point nearest the triangle's centre, from that centre, and its `t`.
#[inline(always)]
fn triangle_ray(ray: &Ray, triangle: &Triangle) -> (Vec3, f32) {
    let d = ray.direction;
    let dd = d.x * d.x + d.y * d.y + d.z * d.z;
    let c = triangle.center - ray.origin;
    let t0 = (c.x * d.x + c.y * d.y + c.z * d.z) / dd;
    (d * t0 - c, t0)
}

#[inline(always)]
fn cross(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

#[inline(always)]
fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Volumes of the direction with each pair of corners as seen from `q`: the weights of the corners times their sum.
#[inline(always)]
fn edge_volumes(q: Vec3, d: Vec3, triangle: &Triangle) -> Vec3 {
    let [a, b, c] = triangle.corners;
    let (a, b, c) = (a - q, b - q, c - q);
    Vec3::new(dot(d, cross(b, c)), dot(d, cross(c, a)), dot(d, cross(a, b)))
}

/// `t` of the hit with a triangle at `t ≥ near`; infinity for a miss, and for a triangle seen edge-on or without area.
#[inline(always)]
#[must_use]
pub fn triangle_t(ray: &Ray, triangle: &Triangle, near: f32) -> f32 {
    let (q, t0) = triangle_ray(ray, triangle);
    let d = ray.direction;
    let volumes = edge_volumes(q, d, triangle);
    let n = triangle.face;
    let facing = dot(n, d);
    // Weights within −slack of the edges; both sides, hence times the sign.
    let sign = select(facing < 0.0, -1.0, 1.0);
    let size = facing * sign;
    let inside = (volumes.x * sign >= -triangle.slack.x * size)
        & (volumes.y * sign >= -triangle.slack.y * size)
        & (volumes.z * sign >= -triangle.slack.z * size);
    // Within 1e-6 rad of its plane it has no width.
    let has_width = facing * facing > 1e-12 * (dot(n, n) * dot(d, d));
    let t = t0 + dot(n, triangle.corners[0] - q) / select(has_width, facing, 1.0);
    select(inside & has_width & (t >= near), t, f32::INFINITY)
}

/// The weights of the corners at the hit that [`triangle_t`] gave: each 0–1, together 1.
#[must_use]
pub fn triangle_weights(ray: &Ray, triangle: &Triangle) -> Vec3 {
    let (q, _) = triangle_ray(ray, triangle);
    let volumes = edge_volumes(q, ray.direction, triangle);
    let sum = volumes.x + volumes.y + volumes.z;
    let weights = (volumes / if sum == 0.0 { 1.0 } else { sum }).clamp(Vec3::ZERO, Vec3::ONE);
    let total = weights.x + weights.y + weights.z;
    if total > 0.0 { weights / total } else { Vec3::splat(1.0 / 3.0) }
}

/// Unit normal of a triangle at the hit that [`triangle_t`] gave: interpolated between the corners' and turned towards
/// the camera, by the side of the plane that is seen. Corners without normals give that of the plane.
#[must_use]
pub fn triangle_normal(ray: &Ray, triangle: &Triangle) -> Vec3 {
    let weights = triangle_weights(ray, triangle);
    let [a, b, c] = triangle.normals;
    let to_camera = -ray.direction.normalize();
    let face = triangle.face.normalize_or(to_camera);
    let smooth = (a * weights.x + b * weights.y + c * weights.z).normalize_or(face);
    // The face may be listed either way round; what counts is the side of it that the corners' normals are on.
    let out = if smooth.dot(face) < 0.0 { -face } else { face };
    let normal = if out.dot(ray.direction) > 0.0 { -smooth } else { smooth };
    // Near a silhouette the interpolated normal may point away from a face that is seen.
    if normal.dot(ray.direction) > 0.0 { towards_camera(normal, ray.direction) } else { normal }
}
