// Tight bounds of primitives on the picture's plane: the twins of src/render/bounds.rs. Comments stand there.
#import "common.wgsl"

struct PlaneRect {
    center: vec2<f32>,
    half: vec2<f32>,
    along: vec2<f32>,
    // False where all of the primitive is nearer than the near plane.
    seen: bool,
}

fn unseen_rect() -> PlaneRect {
    return PlaneRect(vec2<f32>(0.0), vec2<f32>(0.0), vec2<f32>(1.0, 0.0), false);
}

fn perp(v: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(-v.y, v.x);
}

fn slope_up(cx: f32, cw: f32, r: f32, near: f32) -> f32 {
    let outside = cx * cx + cw * cw - r * r;
    if outside > 0.0 {
        let root = sqrt(outside);
        let tangent_w = root * (cw * root - cx * r) / (cx * cx + cw * cw);
        if tangent_w >= near {
            return (cx * root + cw * r) / (cw * root - cx * r);
        }
    }
    let chord = sqrt(max(r * r - (near - cw) * (near - cw), 0.0));
    return (cx + chord) / near;
}

fn disc_slopes(cx: f32, cw: f32, r: f32, near: f32) -> vec2<f32> {
    return vec2<f32>(-slope_up(-cx, cw, r, near), slope_up(cx, cw, r, near));
}

fn sphere_rect(center: vec3<f32>, radius: f32, near: f32) -> PlaneRect {
    let depth = -center.z;
    if depth + radius < near {
        return unseen_rect();
    }
    if is_orthographic() {
        let x = vec2<f32>(center.x - radius, center.x + radius);
        return rect_from(x, vec2<f32>(center.y - radius, center.y + radius), vec2<f32>(1.0, 0.0));
    }
    let x = disc_slopes(center.x, depth, radius, near);
    return rect_from(x, disc_slopes(center.y, depth, radius, near), vec2<f32>(1.0, 0.0));
}

fn rect_from(x: vec2<f32>, y: vec2<f32>, along: vec2<f32>) -> PlaneRect {
    let half = vec2<f32>(x.y - x.x, y.y - y.x) * 0.5;
    let middle = vec2<f32>(x.x + x.y, y.x + y.y) * 0.5;
    let slack = 1e-6 * (max(abs(middle.x), abs(middle.y)) + max(half.x, half.y));
    return PlaneRect(along * middle.x + perp(along) * middle.y, half + slack, along, true);
}

fn circle_slopes(cx: f32, cw: f32, r: f32, ax: f32, ay: f32, aw: f32) -> vec2<f32> {
    let r2 = r * r;
    let a = cw * cw - r2 * (1.0 - aw * aw);
    let half_b = cx * cw + r2 * ax * aw;
    let facing = cx * ax + cw * aw;
    let root = r * sqrt(max(facing * facing + ay * ay * (cx * cx + cw * cw - r2), 0.0));
    return vec2<f32>((half_b - root) / a, (half_b + root) / a);
}

fn project(p: vec3<f32>) -> vec2<f32> {
    if is_orthographic() {
        return p.xy;
    }
    return p.xy / -p.z;
}

// What one end adds to the interval of slopes along `direction`.
fn end_slopes(end: vec3<f32>, radius: f32, is_round: bool, axis: vec3<f32>, direction: vec2<f32>) -> vec2<f32> {
    let cx = dot(direction, end.xy);
    let ax = select(dot(direction, axis.xy), 0.0, is_round);
    let ay = select(dot(perp(direction), axis.xy), 1.0, is_round);
    let aw = select(-axis.z, 0.0, is_round);
    if is_orthographic() {
        let extent = radius * sqrt(ay * ay + aw * aw);
        return vec2<f32>(cx - extent, cx + extent);
    }
    return circle_slopes(cx, -end.z, radius, ax, ay, aw);
}

fn join(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(min(a.x, b.x), max(a.y, b.y));
}

// `axis` is the unit axis from `a` to `b`; a cylinder without length is left out before.
fn cylinder_rect(
    a: vec3<f32>, b: vec3<f32>, axis: vec3<f32>, radius: f32, round_a: bool, round_b: bool, near: f32,
) -> PlaneRect {
    if max(-a.z, -b.z) + radius < near {
        return unseen_rect();
    }
    let crosses_near = min(-a.z, -b.z) - radius < near && !is_orthographic();
    var across = axis.xy;
    if !crosses_near {
        across = project(b) - project(a);
    }
    var along = vec2<f32>(1.0, 0.0);
    let size = length(across);
    if size > 1e-30 && size < NO_HIT {
        along = across / size;
    }
    let second = perp(along);
    if crosses_near {
        let front = select(b, a, a.z > b.z);
        let back = select(a, b, a.z > b.z);
        let e0 = near_end(front, back, axis, near - radius);
        let e1 = near_end(front, back, axis, near + radius);
        let x = join(
            join(loose_slopes(dot(along, e0.xy), -e0.z, radius, near), loose_slopes(dot(along, e1.xy), -e1.z, radius, near)),
            loose_slopes(dot(along, back.xy), -back.z, radius, near),
        );
        let y = join(
            join(loose_slopes(dot(second, e0.xy), -e0.z, radius, near), loose_slopes(dot(second, e1.xy), -e1.z, radius, near)),
            loose_slopes(dot(second, back.xy), -back.z, radius, near),
        );
        return rect_from(x, y, along);
    }
    let x = join(end_slopes(a, radius, round_a, axis, along), end_slopes(b, radius, round_b, axis, along));
    let y = join(end_slopes(a, radius, round_a, axis, second), end_slopes(b, radius, round_b, axis, second));
    return rect_from(x, y, along);
}

// Twin of near_ends' at_depth.
fn near_end(front: vec3<f32>, back: vec3<f32>, axis: vec3<f32>, depth: f32) -> vec3<f32> {
    if -front.z >= depth || abs(axis.z) < 1e-12 {
        return front;
    }
    let t = clamp((depth + front.z) / (front.z - back.z), 0.0, 1.0);
    return front + (back - front) * t;
}

fn loose_slopes(cx: f32, cw: f32, r: f32, near: f32) -> vec2<f32> {
    let nearest = max(cw - r, near);
    let farthest = max(cw + r, near);
    let x0 = cx - r;
    let x1 = cx + r;
    return vec2<f32>(x0 / select(farthest, nearest, x0 < 0.0), x1 / select(farthest, nearest, x1 > 0.0));
}
