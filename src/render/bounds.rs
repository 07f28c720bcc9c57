//! Tight bounds of spheres and cylinders on the picture's plane, exact for any projection, off-centre ones included.
//!
//! All in plane coordinates (slopes in perspective, ångström in orthographic projection). In a plane that holds the
//! view axis and the direction `x` a solid of revolution about the unit axis `a` covers the slopes `s` with
//! `(cx − s·cw)² ≤ r²·(1 + s² − (ax − s·aw)²)` for each of its end circles: a quadratic in `s`; for a
//! sphere the last term is missing. Where the near plane cuts the solid, simpler bounds hold that are wider but lose nothing.
//!
//! `shaders/bounds.wgsl` holds the twins.

use glam::{Vec2, Vec3};

/// A rectangle on the plane: centre, half extents, and the unit direction of its first side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneRect {
    /// Centre in plane coordinates.
    pub center: Vec2,
    /// Half extents along `along` and across it.
    pub half: Vec2,
    /// Unit direction of the first side.
    pub along: Vec2,
}

impl PlaneRect {
    /// The upright box around it: lower and upper corner.
    #[must_use]
    pub fn upright(&self) -> (Vec2, Vec2) {
        let extent = (self.along.abs() * self.half.x) + (self.along.perp().abs() * self.half.y);
        (self.center - extent, self.center + extent)
    }
}

/// What bounds need to know of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundsCamera {
    /// Parallel rays.
    pub orthographic: bool,
    /// Depth of the near plane.
    pub near: f32,
}

/// Interval of the slopes `x / w` of a disc of radius `r` about `(cx, cw)`, of which the part with `w ≥ near` counts.
/// The disc reaches beyond `near`.
fn disc_slopes(cx: f32, cw: f32, r: f32, near: f32) -> (f32, f32) {
    let slope_up = |cx: f32| {
        // The largest slope; the smallest is the mirror image's, negated.
        let outside = cx * cx + cw * cw - r * r;
        if outside > 0.0 {
            let root = outside.sqrt();
            // The tangent point: the centre's direction turned by asin(r / distance).
            let tangent_w = root * (cw * root - cx * r) / (cx * cx + cw * cw);
            if tangent_w >= near {
                return (cx * root + cw * r) / (cw * root - cx * r);
            }
        }
        let chord = (r * r - (near - cw) * (near - cw)).max(0.0).sqrt();
        (cx + chord) / near
    };
    (-slope_up(-cx), slope_up(cx))
}

/// Bounds of a sphere; `None` if all of it is nearer than the near plane. `center` is in view space.
#[must_use]
pub fn sphere_rect(center: Vec3, radius: f32, camera: &BoundsCamera) -> Option<PlaneRect> {
    let depth = -center.z;
    if depth + radius < camera.near {
        return None;
    }
    let (x, y) = if camera.orthographic {
        ((center.x - radius, center.x + radius), (center.y - radius, center.y + radius))
    } else {
        (disc_slopes(center.x, depth, radius, camera.near), disc_slopes(center.y, depth, radius, camera.near))
    };
    Some(rect_from(x, y, Vec2::X))
}

fn rect_from((x0, x1): (f32, f32), (y0, y1): (f32, f32), along: Vec2) -> PlaneRect {
    // A millionth of slack covers the rounding of the lines above.
    let half = Vec2::new(x1 - x0, y1 - y0) * 0.5;
    let middle = Vec2::new(x0 + x1, y0 + y1) * 0.5;
    let slack = 1e-6 * (middle.abs().max_element() + half.max_element());
    PlaneRect { center: along * middle.x + along.perp() * middle.y, half: half + slack, along }
}

/// Interval of the slopes of a circle of radius `r` about `(cx, cw)` perpendicular to the unit axis `(ax, ay, aw)`, `ay`
/// being the part of the axis outside the plane; a sphere for `(0, 1, 0)`. The circle lies beyond the near plane.
fn circle_slopes(cx: f32, cw: f32, r: f32, ax: f32, ay: f32, aw: f32) -> (f32, f32) {
    let r2 = r * r;
    let a = cw * cw - r2 * (1.0 - aw * aw);
    let half_b = cx * cw + r2 * ax * aw;
    // half_b² − a·c with the terms that cancel left out: as it stands, f32 has no digit of it left at 1,000 Å.
    let facing = cx * ax + cw * aw;
    let root = r * (facing * facing + ay * ay * (cx * cx + cw * cw - r2)).max(0.0).sqrt();
    ((half_b - root) / a, (half_b + root) / a)
}

/// Bounds of a cylinder with axis ends `a` and `b` in view space and round or flat caps (`round[i]` for end `i`);
/// `None` if all of it is nearer than the near plane.
#[must_use]
pub fn cylinder_rect(a: Vec3, b: Vec3, radius: f32, round: [bool; 2], camera: &BoundsCamera) -> Option<PlaneRect> {
    let axis = b - a;
    let length = axis.length();
    if length.is_nan() || length <= 0.0 {
        return None;
    }
    let axis = axis / length;
    let depths = [-a.z, -b.z];
    if depths[0].max(depths[1]) + radius < camera.near {
        return None;
    }
    let crosses_near = depths[0].min(depths[1]) - radius < camera.near;
    let project = |p: Vec3| if camera.orthographic { p.truncate() } else { p.truncate() / -p.z };
    let across = if crosses_near && !camera.orthographic { axis.truncate() } else { project(b) - project(a) };
    let along = across.try_normalize().unwrap_or(Vec2::X);
    let mut low = Vec2::INFINITY;
    let mut high = Vec2::NEG_INFINITY;
    let mut cover = |side: usize, (from, to): (f32, f32)| {
        low[side] = low[side].min(from);
        high[side] = high[side].max(to);
    };
    let aw = -axis.z;
    for (side, direction) in [along, along.perp()].into_iter().enumerate() {
        let ax = direction.dot(axis.truncate());
        let ay = direction.perp().dot(axis.truncate());
        if crosses_near && !camera.orthographic {
            for end in near_ends(a, b, axis, radius, camera.near) {
                cover(side, loose_slopes(direction.dot(end.truncate()), -end.z, radius, camera.near));
            }
            continue;
        }
        for ((end, round), depth) in [a, b].into_iter().zip(round).zip(depths) {
            let cx = direction.dot(end.truncate());
            let (ax, ay, aw) = if round { (0.0f32, 1.0f32, 0.0f32) } else { (ax, ay, aw) };
            if camera.orthographic {
                let extent = radius * (ay * ay + aw * aw).sqrt();
                cover(side, (cx - extent, cx + extent));
            } else {
                cover(side, circle_slopes(cx, depth, radius, ax, ay, aw));
            }
        }
    }
    Some(rect_from((low.x, high.x), (low.y, high.y), along))
}

/// The points of the axis between which a solid that crosses the near plane can be seen: where the part that reaches
/// beyond it begins, where all of a cross-section is beyond it, and the far end.
fn near_ends(a: Vec3, b: Vec3, axis: Vec3, radius: f32, near: f32) -> [Vec3; 3] {
    let (front, back) = if a.z > b.z { (a, b) } else { (b, a) };
    let at_depth = |depth: f32| {
        if -front.z >= depth || axis.z.abs() < 1e-12 {
            front
        } else {
            let t = ((depth + front.z) / (front.z - back.z)).clamp(0.0, 1.0);
            front + (back - front) * t
        }
    };
    [at_depth(near - radius), at_depth(near + radius), back]
}

/// Slopes that hold the part of a ball beyond the near plane; wide, but right for every point between two balls too.
fn loose_slopes(cx: f32, cw: f32, r: f32, near: f32) -> (f32, f32) {
    let nearest = (cw - r).max(near);
    let farthest = (cw + r).max(near);
    let (x0, x1) = (cx - r, cx + r);
    (x0 / if x0 < 0.0 { nearest } else { farthest }, x1 / if x1 > 0.0 { nearest } else { farthest })
}

#[cfg(test)]
#[path = "bounds_tests.rs"]
mod tests;
