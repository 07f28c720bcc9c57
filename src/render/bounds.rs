//! Tight bounds of primitives on the picture's plane, exact for any projection, off-centre ones included.
//!
//! All in plane coordinates (slopes in perspective, ångström in orthographic projection). In a plane that holds the
//! view axis and the direction `x` a solid of revolution about the unit axis `a` covers the slopes `s` with
//! `(cx − s·cw)² ≤ r²·(1 + s² − (ax − s·aw)²)` for each of its end circles: a quadratic in `s`; for a
//! sphere the last term is missing. Where the near plane cuts the solid, simpler bounds hold that are wider but lose nothing.
//!
//!
//! A cone is the hull of its two end circles, and seen from the side a triangle or a trapezium: so are its bounds, as
//! those of triangles ([`PlaneTrapezoid`]). A ring is mostly hole: its tube is bounded in pieces, each by the cylinder around it.
//!
//! `shaders/bounds.wgsl` and `shaders/trapezoid.wgsl` hold the twins.

use super::solids::{Cone, Torus, Triangle};
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

/// A quadrilateral on the plane with two parallel sides: `x` runs along `along`, `y` across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneTrapezoid {
    /// Unit direction of x.
    pub along: Vec2,
    /// Where the parallel sides are.
    pub x: [f32; 2],
    /// Their lower ends.
    pub lower: [f32; 2],
    /// Their upper ends.
    pub upper: [f32; 2],
}

impl PlaneTrapezoid {
    fn rectangle(along: Vec2, low: Vec2, high: Vec2) -> PlaneTrapezoid {
        PlaneTrapezoid { along, x: [low.x, high.x], lower: [low.y; 2], upper: [high.y; 2] }
    }

    /// The four corners: the lower ends, then the upper ones.
    #[must_use]
    pub fn corners(&self) -> [Vec2; 4] {
        let at = |x: f32, y: f32| self.along * x + self.along.perp() * y;
        let ([x0, x1], [a, b], [c, d]) = (self.x, self.lower, self.upper);
        [at(x0, a), at(x1, b), at(x0, c), at(x1, d)]
    }

    /// The upright box around it: lower and upper corner.
    #[must_use]
    pub fn upright(&self) -> (Vec2, Vec2) {
        let corners = self.corners();
        corners.iter().fold((corners[0], corners[0]), |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// A millionth wider on all sides, for the rounding of what it was found from.
    fn widened(self) -> PlaneTrapezoid {
        let ([x0, x1], lower, upper) = (self.x, self.lower, self.upper);
        let most =
            [x0, x1, lower[0], lower[1], upper[0], upper[1]].into_iter().fold(0.0, |most: f32, v| most.max(v.abs()));
        let slack = 1e-6 * most;
        // The sloping sides move out by as much: so much at right angles to x.
        let run = (x1 - x0).max(1e-30);
        let rise = |[y0, y1]: [f32; 2]| (y1 - y0) / run;
        let (below, above) = (rise(lower), rise(upper));
        let out = |slope: f32| slack * (1.0 + slope * slope).sqrt();
        PlaneTrapezoid {
            x: [x0 - slack, x1 + slack],
            lower: [lower[0] - below * slack - out(below), lower[1] + below * slack - out(below)],
            upper: [upper[0] - above * slack + out(above), upper[1] + above * slack + out(above)],
            ..self
        }
    }
}

/// Sides steeper than this make the upright rectangle instead: what a corner moves out by to cover rounding is as many times more.
const STEEPEST_SIDE: f32 = 8.0;

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

/// Interval along `direction` of a circle in space: end of a cone, `axis` unit. The circle lies beyond the near plane in perspective.
fn circle_extent(center: Vec3, radius: f32, axis: Vec3, direction: Vec2, orthographic: bool) -> (f32, f32) {
    let cx = direction.dot(center.truncate());
    let (ax, ay, aw) = (direction.dot(axis.truncate()), direction.perp().dot(axis.truncate()), -axis.z);
    if orthographic {
        let extent = radius * (ay * ay + aw * aw).sqrt();
        return (cx - extent, cx + extent);
    }
    circle_slopes(cx, -center.z, radius, ax, ay, aw)
}

/// Bounds of a cone in view space; `None` if all of it is nearer than the near plane.
#[must_use]
pub fn cone_rect(cone: &Cone, camera: &BoundsCamera) -> Option<PlaneTrapezoid> {
    let [a, b] = cone.ends();
    let [radius_a, radius_b] = cone.radii;
    let (reach_a, reach_b) = (-a.z + radius_a, -b.z + radius_b);
    if reach_a.max(reach_b) < camera.near {
        return None;
    }
    let crosses_near = (-a.z - radius_a).min(-b.z - radius_b) < camera.near;
    if crosses_near && !camera.orthographic {
        // Inside the cylinder that is as wide as its wider end.
        let rect = cylinder_rect(a, b, radius_a.max(radius_b), [false; 2], camera)?;
        let middle = Vec2::new(rect.along.dot(rect.center), rect.along.perp().dot(rect.center));
        return Some(PlaneTrapezoid::rectangle(rect.along, middle - rect.half, middle + rect.half));
    }
    let axis = cone.axis();
    let project = |p: Vec3| if camera.orthographic { p.truncate() } else { p.truncate() / -p.z };
    let between = project(b) - project(a);
    let along = between.try_normalize().unwrap_or(Vec2::X);
    let extent = |direction: Vec2| {
        let of_a = circle_extent(a, radius_a, axis, direction, camera.orthographic);
        let of_b = circle_extent(b, radius_b, axis, direction, camera.orthographic);
        [of_a, of_b]
    };
    let [along_a, along_b] = extent(along);
    let [across_a, across_b] = extent(along.perp());
    let low = Vec2::new(along_a.0.min(along_b.0), across_a.0.min(across_b.0));
    let high = Vec2::new(along_a.1.max(along_b.1), across_a.1.max(across_b.1));
    let rectangle = PlaneTrapezoid::rectangle(along, low, high);
    // The sides that touch both end ellipses, as if those were of one shape; what they do not touch by that is put right below.
    let half = |(low, high): (f32, f32)| (high - low) * 0.5;
    let (wide_a, wide_b) = (half(across_a), half(across_b));
    let (wide, flat) = if wide_a > wide_b { (wide_a, half(along_a)) } else { (wide_b, half(along_b)) };
    let narrows = (wide_a - wide_b) / between.length().max(1e-30);
    let sine = narrows * flat / wide.max(1e-30);
    if !(sine.abs() < 0.95 && narrows.abs() < STEEPEST_SIDE * (1.0 - sine * sine).sqrt()) {
        return Some(rectangle.widened());
    }
    let cosine = (1.0 - sine * sine).sqrt();
    let size = (narrows * narrows + cosine * cosine).sqrt();
    let (sx, sy) = (narrows / size, cosine / size);
    let side = |direction: Vec2| {
        let [of_a, of_b] = extent(direction);
        of_a.1.max(of_b.1)
    };
    let above = side(along * sx + along.perp() * sy);
    let below = side(along * sx - along.perp() * sy);
    let upper = rectangle.x.map(|x| (above - sx * x) / sy);
    let lower = rectangle.x.map(|x| (sx * x - below) / sy);
    Some(PlaneTrapezoid { upper, lower, ..rectangle }.widened())
}

/// Bounds of a triangle in view space; `None` if all of it is nearer than the near plane.
#[must_use]
pub fn triangle_rect(triangle: &Triangle, camera: &BoundsCamera) -> Option<PlaneTrapezoid> {
    let points = triangle.points();
    let deepest = points.iter().fold(f32::NEG_INFINITY, |most, p| most.max(-p.z));
    if deepest < camera.near {
        return None;
    }
    let nearest = points.iter().fold(f32::INFINITY, |least, p| least.min(-p.z));
    if nearest < camera.near && !camera.orthographic {
        // The box of what is left of it: corners beyond the near plane, and where its edges cross that.
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let mut cover = |p: Vec3| {
            let slope = p.truncate() / (-p.z).max(camera.near);
            (low, high) = (low.min(slope), high.max(slope));
        };
        for (i, &p) in points.iter().enumerate() {
            let next = points[(i + 1) % 3];
            let is_beyond = -p.z >= camera.near;
            if is_beyond {
                cover(p);
            }
            if is_beyond != (-next.z >= camera.near) {
                cover(p + (next - p) * ((camera.near + p.z) / (p.z - next.z)).clamp(0.0, 1.0));
            }
        }
        return Some(PlaneTrapezoid::rectangle(Vec2::X, low, high).widened());
    }
    let [a, b, c] = points.map(|p| if camera.orthographic { p.truncate() } else { p.truncate() / -p.z });
    // One parallel side is the longest edge, the other the corner opposite.
    let edges = [(b - c).length_squared(), (c - a).length_squared(), (a - b).length_squared()];
    let (tip, from, to) = if edges[0] >= edges[1] && edges[0] >= edges[2] {
        (a, b, c)
    } else if edges[1] >= edges[2] {
        (b, c, a)
    } else {
        (c, a, b)
    };
    let up = (to - from).try_normalize().unwrap_or(Vec2::Y);
    // x runs from the edge to the tip: `along` is `up` turned back, so that its perpendicular is `up` again.
    let (up, from, to) = if (tip - from).dot(-up.perp()) < 0.0 { (-up, to, from) } else { (up, from, to) };
    let along = -up.perp();
    let (base, end) = (along.dot(from).min(along.dot(to)), along.dot(tip).max(along.dot(from)));
    let (bottom, top, middle) = (up.dot(from), up.dot(to), up.dot(tip));
    let is_flat = top - bottom > STEEPEST_SIDE * (end - base);
    if is_flat {
        let (low, high) = (Vec2::new(base, bottom.min(middle)), Vec2::new(end, top.max(middle)));
        return Some(PlaneTrapezoid::rectangle(along, low, high).widened());
    }
    Some(PlaneTrapezoid { along, x: [base, end], lower: [bottom, middle], upper: [top, middle] }.widened())
}

/// Pieces that a torus' tube is bounded in. Chosen: of 10 to 24 the one with the least area for tubes of 0.05 to 0.6 ring radii.
pub const TORUS_PIECES: u32 = 16;

/// Cosine and sine of half a piece's turn.
const HALF_TURN: (f32, f32) = (0.980_785_3, 0.195_090_32);

/// Whether a torus is bounded better as a whole: where the tube is thick, or the ring is seen from the side, its near half in front
/// of the far one. Compares the areas of the whole and of the pieces, which overlap by 0.6 of what they cover.
fn is_whole(torus: &Torus, camera: &BoundsCamera) -> bool {
    let (ring, tube) = (torus.ring_radius, torus.tube_radius);
    let sight = if camera.orthographic { Vec3::Z } else { torus.center.normalize_or(Vec3::Z) };
    let open = ring * torus.axis().dot(sight).abs();
    let pieces = 1.6 * 2.0 * tube * std::f32::consts::PI * (ring + open);
    tube > 0.6 * ring || 4.0 * (ring + tube) * (open + tube) < pieces
}

/// Bounds of piece `piece` of a torus in view space, one of [`TORUS_PIECES`]; `None` if all of it is nearer than the near plane. A
/// torus that pieces would not bound better is bounded as a whole by the first.
#[must_use]
pub fn torus_rect(torus: &Torus, piece: u32, camera: &BoundsCamera) -> Option<PlaneRect> {
    let (ring, tube) = (torus.ring_radius, torus.tube_radius);
    let axis = torus.axis();
    if is_whole(torus, camera) {
        if piece > 0 {
            return None;
        }
        let half = axis * tube;
        return cylinder_rect(torus.center - half, torus.center + half, ring + tube, [false; 2], camera);
    }
    let (cosine, sine) = HALF_TURN;
    let angle = std::f32::consts::TAU / TORUS_PIECES as f32 * piece as f32;
    let (x, z) = (torus.torus_from_space.row(0), torus.torus_from_space.row(2));
    let outward = x * angle.cos() + z * angle.sin();
    let onward = z * angle.cos() - x * angle.sin();
    // A cylinder about the chord, moved out by half of what the arc bulges over it; its ends reach as far as the tube's tilt there.
    let bulge = ring * (1.0 - cosine) * 0.5;
    let middle = torus.center + outward * (ring - bulge);
    let reach = onward * (ring * sine + tube * sine);
    cylinder_rect(middle - reach, middle + reach, tube + bulge, [false; 2], camera)
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
#[path = "bounds_shape_tests.rs"]
mod shape_tests;
#[cfg(test)]
#[path = "bounds_tests.rs"]
mod tests;
