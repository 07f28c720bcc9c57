// Bounds of cones and triangles: the twins of src/render/bounds.rs. Comments stand there.
#import "geometry.wgsl"

// Corners are (x.x, lower.x), (x.y, lower.y), (x.x, upper.x), (x.y, upper.y) along `along` and across it.
struct PlaneTrapezoid {
    along: vec2<f32>,
    x: vec2<f32>,
    lower: vec2<f32>,
    upper: vec2<f32>,
    seen: bool,
}

const STEEPEST_SIDE: f32 = 8.0;

fn unseen_trapezoid() -> PlaneTrapezoid {
    return PlaneTrapezoid(vec2<f32>(1.0, 0.0), vec2<f32>(0.0), vec2<f32>(0.0), vec2<f32>(0.0), false);
}

// Intervals along x and across it.
fn upright_trapezoid(along: vec2<f32>, x: vec2<f32>, y: vec2<f32>) -> PlaneTrapezoid {
    return PlaneTrapezoid(along, x, vec2<f32>(y.x), vec2<f32>(y.y), true);
}

// Every side moved out by `by`. Twin of PlaneTrapezoid::widened.
fn grown(t: PlaneTrapezoid, by: f32) -> PlaneTrapezoid {
    let run = max(t.x.y - t.x.x, 1e-30);
    let below = (t.lower.y - t.lower.x) / run;
    let above = (t.upper.y - t.upper.x) / run;
    let out_below = by * sqrt(1.0 + below * below);
    let out_above = by * sqrt(1.0 + above * above);
    let sides = vec2<f32>(-by, by);
    return PlaneTrapezoid(t.along, t.x + sides, t.lower + sides * below - out_below, t.upper + sides * above + out_above, t.seen);
}

fn widened(t: PlaneTrapezoid) -> PlaneTrapezoid {
    let most = max(max(abs(t.x), abs(t.lower)), abs(t.upper));
    return grown(t, 1e-6 * max(most.x, most.y));
}

// A corner in the clip space of the target, as quad_corner.
fn trapezoid_corner(bounds: PlaneTrapezoid, corner: u32, nearest_depth: f32) -> vec4<f32> {
    if !bounds.seen {
        return NOWHERE;
    }
    let wide = grown(bounds, SNAP_SLACK_PX * frame.grid.x);
    let along = wide.along;
    let across = perp(along);
    let at = array<vec2<f32>, 4>(
        along * wide.x.x + across * wide.lower.x,
        along * wide.x.y + across * wide.lower.y,
        along * wide.x.x + across * wide.upper.x,
        along * wide.x.y + across * wide.upper.y,
    );
    let shift = frame.grid.yz + 0.5 - one_sample.offset - vec2<f32>(one_sample.origin);
    let to_px = vec2<f32>(1.0, -1.0) / frame.grid.x;
    let low = min(min(at[0], at[1]), min(at[2], at[3]));
    let high = max(max(at[0], at[1]), max(at[2], at[3]));
    var own = at[0];
    if corner == 1u {
        own = at[1];
    } else if corner == 2u {
        own = at[2];
    } else if corner == 3u {
        own = at[3];
    }
    let ends = array<vec2<f32>, 2>(low * to_px + shift, high * to_px + shift);
    return target_corner(own * to_px + shift, min(ends[0], ends[1]), max(ends[0], ends[1]), corner, nearest_depth);
}

// The extents of both ends along a direction.
fn ends_extent(a: vec3<f32>, b: vec3<f32>, axis: vec3<f32>, radii: vec2<f32>, direction: vec2<f32>) -> vec4<f32> {
    return vec4<f32>(end_slopes(a, radii.x, false, axis, direction), end_slopes(b, radii.y, false, axis, direction));
}

// `axis` is the unit axis from `a` to `b`.
fn cone_rect(a: vec3<f32>, b: vec3<f32>, axis: vec3<f32>, radii: vec2<f32>, near: f32) -> PlaneTrapezoid {
    if max(-a.z + radii.x, -b.z + radii.y) < near {
        return unseen_trapezoid();
    }
    if min(-a.z - radii.x, -b.z - radii.y) < near && !is_orthographic() {
        let rect = cylinder_rect(a, b, axis, max(radii.x, radii.y), false, false, near);
        if !rect.seen {
            return unseen_trapezoid();
        }
        let x = dot(rect.along, rect.center);
        let y = dot(perp(rect.along), rect.center);
        let sides = vec2<f32>(-1.0, 1.0);
        return upright_trapezoid(rect.along, x + sides * rect.half.x, y + sides * rect.half.y);
    }
    let between = project(b) - project(a);
    let size = length(between);
    var along = vec2<f32>(1.0, 0.0);
    if size > 1e-30 && size < NO_HIT {
        along = between / size;
    }
    let across = perp(along);
    let x = ends_extent(a, b, axis, radii, along);
    let y = ends_extent(a, b, axis, radii, across);
    let rectangle = upright_trapezoid(along, join(x.xy, x.zw), join(y.xy, y.zw));
    let wide_a = (y.y - y.x) * 0.5;
    let wide_b = (y.w - y.z) * 0.5;
    let flat = select((x.w - x.z) * 0.5, (x.y - x.x) * 0.5, wide_a > wide_b);
    let narrows = (wide_a - wide_b) / max(size, 1e-30);
    let sine = narrows * flat / max(max(wide_a, wide_b), 1e-30);
    let cosine = sqrt(max(1.0 - sine * sine, 0.0));
    if !(abs(sine) < 0.95 && abs(narrows) < STEEPEST_SIDE * cosine) {
        return widened(rectangle);
    }
    let side = vec2<f32>(narrows, cosine) / length(vec2<f32>(narrows, cosine));
    let up = ends_extent(a, b, axis, radii, along * side.x + across * side.y);
    let down = ends_extent(a, b, axis, radii, along * side.x - across * side.y);
    let upper = (max(up.y, up.w) - side.x * rectangle.x) / side.y;
    let lower = (side.x * rectangle.x - max(down.y, down.w)) / side.y;
    return widened(PlaneTrapezoid(along, rectangle.x, lower, upper, true));
}

// What an edge adds to the box of what is beyond the near plane: its first corner, or where it crosses. As (low, high).
fn near_box(all: vec4<f32>, p: vec3<f32>, next: vec3<f32>, near: f32) -> vec4<f32> {
    var bounds = all;
    let is_beyond = -p.z >= near;
    if is_beyond {
        let slope = p.xy / -p.z;
        bounds = vec4<f32>(min(bounds.xy, slope), max(bounds.zw, slope));
    }
    if is_beyond != (-next.z >= near) {
        let crossing = p + (next - p) * clamp((near + p.z) / (p.z - next.z), 0.0, 1.0);
        let slope = crossing.xy / max(-crossing.z, near);
        bounds = vec4<f32>(min(bounds.xy, slope), max(bounds.zw, slope));
    }
    return bounds;
}

fn triangle_rect(p: vec3<f32>, q: vec3<f32>, r: vec3<f32>, near: f32) -> PlaneTrapezoid {
    if max(max(-p.z, -q.z), -r.z) < near {
        return unseen_trapezoid();
    }
    if min(min(-p.z, -q.z), -r.z) < near && !is_orthographic() {
        let none = vec4<f32>(NO_HIT, NO_HIT, -NO_HIT, -NO_HIT);
        let all = near_box(near_box(near_box(none, p, q, near), q, r, near), r, p, near);
        return widened(upright_trapezoid(vec2<f32>(1.0, 0.0), all.xz, all.yw));
    }
    let a = project(p);
    let b = project(q);
    let c = project(r);
    let edges = vec3<f32>(dot(b - c, b - c), dot(c - a, c - a), dot(a - b, a - b));
    var tip = c;
    var first = a;
    var last = b;
    if edges.x >= edges.y && edges.x >= edges.z {
        tip = a;
        first = b;
        last = c;
    } else if edges.y >= edges.z {
        tip = b;
        first = c;
        last = a;
    }
    let size = length(last - first);
    var up = vec2<f32>(0.0, 1.0);
    if size > 1e-30 && size < NO_HIT {
        up = (last - first) / size;
    }
    if dot(tip - first, -perp(up)) < 0.0 {
        up = -up;
        let swapped = first;
        first = last;
        last = swapped;
    }
    let along = -perp(up);
    let x = vec2<f32>(min(dot(along, first), dot(along, last)), max(dot(along, tip), dot(along, first)));
    let bottom = dot(up, first);
    let top = dot(up, last);
    let middle = dot(up, tip);
    if top - bottom > STEEPEST_SIDE * (x.y - x.x) {
        return widened(upright_trapezoid(along, x, vec2<f32>(min(bottom, middle), max(top, middle))));
    }
    return widened(PlaneTrapezoid(along, x, vec2<f32>(bottom, middle), vec2<f32>(top, middle), true));
}
