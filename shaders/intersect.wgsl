// Exact intersections of a view ray with the primitives: the twins, function for function, of
// src/render/cpu/intersect.rs, with NO_HIT for infinity. Comments stand there.
#import "common.wgsl"

struct Sphere {
    center: vec3<f32>,
    radius: f32,
}

struct Cylinder {
    center: vec3<f32>,
    // Rows of the rotation that turns the axis onto +Y.
    row_x: vec3<f32>,
    row_y: vec3<f32>,
    row_z: vec3<f32>,
    half_length: f32,
    radius: f32,
    caps: u32,
}

// Twin of math::rotation_to_y: the rows x, axis, z.
fn rotation_to_y(axis: vec3<f32>) -> mat3x3<f32> {
    let side = select(-1.0, 1.0, axis.z >= 0.0);
    let a = -1.0 / (side + axis.z);
    let b = axis.x * axis.y * a;
    let x = vec3<f32>(1.0 + side * axis.x * axis.x * a, side * b, -side * axis.x);
    let w = vec3<f32>(b, side + axis.y * axis.y * a, -axis.y);
    return mat3x3<f32>(x, axis, -w);
}

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn visible_t(entry: f32, exit: f32, near: f32) -> f32 {
    let hit = entry <= exit && exit >= near;
    return select(NO_HIT, max(entry, near), hit);
}

fn sphere_t(ray: Ray, sphere: Sphere, near: f32) -> f32 {
    let d = ray.direction;
    let dd = dot3(d, d);
    let c = sphere.center - ray.origin;
    let t0 = dot3(c, d) / dd;
    let p = d * t0 - c;
    let pd = dot3(p, d);
    let outside = dot3(p, p) - sphere.radius * sphere.radius;
    let discriminant = pd * pd - dd * outside;
    let root = sqrt(max(discriminant, 0.0));
    let entry = t0 + (-pd - root) / dd;
    let exit = t0 + (-pd + root) / dd;
    return select(NO_HIT, visible_t(entry, exit, near), discriminant >= 0.0);
}

fn sphere_normal(ray: Ray, sphere: Sphere, near: f32, t: f32) -> vec3<f32> {
    let d = ray.direction;
    if t <= near {
        return -normalize(d);
    }
    let c = sphere.center - ray.origin;
    let dd = dot3(d, d);
    let t0 = dot3(c, d) / dd;
    let p = d * t0 - c;
    let pd = dot3(p, d);
    let discriminant = pd * pd - dd * (dot3(p, p) - sphere.radius * sphere.radius);
    let local = (-pd - sqrt(max(discriminant, 0.0))) / dd;
    return normalize_or((p + d * local) / sphere.radius, -d);
}

fn normalize_or(v: vec3<f32>, fallback: vec3<f32>) -> vec3<f32> {
    let length = length(v);
    if length > 1e-30 && length < NO_HIT {
        return v / length;
    }
    return fallback;
}

// The ray in the cylinder's space: origin, direction, and the t of its origin.
struct LocalRay {
    q: vec3<f32>,
    e: vec3<f32>,
    t0: f32,
}

fn cylinder_ray(ray: Ray, cylinder: Cylinder) -> LocalRay {
    let d = ray.direction;
    let dd = dot3(d, d);
    let c = cylinder.center - ray.origin;
    let t0 = dot3(c, d) / dd;
    let p = d * t0 - c;
    let q = vec3<f32>(dot3(cylinder.row_x, p), dot3(cylinder.row_y, p), dot3(cylinder.row_z, p));
    let e = vec3<f32>(dot3(cylinder.row_x, d), dot3(cylinder.row_y, d), dot3(cylinder.row_z, d));
    return LocalRay(q, e, t0);
}

// Intervals are (entry, exit).
fn side_interval(q: vec3<f32>, e: vec3<f32>, radius: f32) -> vec2<f32> {
    let a = e.x * e.x + e.z * e.z;
    let parallel = a <= 1e-12 * (a + e.y * e.y);
    let across = q.x * e.z - q.z * e.x;
    let discriminant = radius * radius * a - across * across;
    let root = sqrt(max(discriminant, 0.0));
    let qe = q.x * e.x + q.z * e.z;
    let over_a = 1.0 / select(a, 1.0, parallel);
    let inside = q.x * q.x + q.z * q.z <= radius * radius;
    if parallel {
        return select(vec2<f32>(NO_HIT, -NO_HIT), vec2<f32>(-NO_HIT, NO_HIT), inside);
    }
    let crossing = vec2<f32>((-qe - root) * over_a, (-qe + root) * over_a);
    return select(crossing, vec2<f32>(NO_HIT, -NO_HIT), discriminant < 0.0);
}

fn slab_interval(q: vec3<f32>, e: vec3<f32>, half_length: f32) -> vec2<f32> {
    let along = abs(e.y) <= 1e-20;
    let over = 1.0 / select(e.y, 1.0, along);
    let y0 = (-half_length - q.y) * over;
    let y1 = (half_length - q.y) * over;
    if along {
        return select(vec2<f32>(NO_HIT, -NO_HIT), vec2<f32>(-NO_HIT, NO_HIT), abs(q.y) <= half_length);
    }
    return vec2<f32>(min(y0, y1), max(y0, y1));
}

fn end_interval(q: vec3<f32>, e: vec3<f32>, y: f32, radius: f32) -> vec2<f32> {
    let p = vec3<f32>(q.x, q.y - y, q.z);
    let dd = dot3(e, e);
    let pd = dot3(p, e);
    let discriminant = pd * pd - dd * (dot3(p, p) - radius * radius);
    let root = sqrt(max(discriminant, 0.0));
    let crossing = vec2<f32>((-pd - root) / dd, (-pd + root) / dd);
    return select(crossing, vec2<f32>(NO_HIT, -NO_HIT), discriminant < 0.0);
}

fn has_cap(caps: u32, end: u32, kind: u32) -> bool {
    return ((caps >> (2u * end)) & 3u) == kind;
}

fn is_open(caps: u32) -> bool {
    return has_cap(caps, 0u, 0u) || has_cap(caps, 1u, 0u);
}

struct SolidInterval {
    entry: f32,
    exit: f32,
    from_side: bool,
}

fn solid_interval(q: vec3<f32>, e: vec3<f32>, cylinder: Cylinder) -> SolidInterval {
    let side = side_interval(q, e, cylinder.radius);
    let slab = slab_interval(q, e, cylinder.half_length);
    let entry = max(side.x, slab.x);
    let exit = min(side.y, slab.y);
    let hit = entry <= exit;
    return SolidInterval(select(NO_HIT, entry, hit), select(-NO_HIT, exit, hit), side.x >= slab.x);
}

// Both caps flat.
const FLAT_CAPS: u32 = 5u;

fn cylinder_t(ray: Ray, cylinder: Cylinder, near: f32) -> f32 {
    let local = cylinder_ray(ray, cylinder);
    let local_near = near - local.t0;
    var t: f32;
    if cylinder.caps == FLAT_CAPS {
        let solid = solid_interval(local.q, local.e, cylinder);
        t = visible_t(solid.entry, solid.exit, local_near);
    } else {
        t = capped_t(local.q, local.e, cylinder, local_near);
    }
    return select(NO_HIT, local.t0 + t, t < NO_HIT);
}

fn capped_t(q: vec3<f32>, e: vec3<f32>, cylinder: Cylinder, near: f32) -> f32 {
    let solid = solid_interval(q, e, cylinder);
    var entry = solid.entry;
    var exit = solid.exit;
    for (var end = 0u; end < 2u; end++) {
        if has_cap(cylinder.caps, end, 2u) {
            let y = select(cylinder.half_length, -cylinder.half_length, end == 0u);
            let ball = end_interval(q, e, y, cylinder.radius);
            entry = min(entry, ball.x);
            exit = max(exit, ball.y);
        }
    }
    if !is_open(cylinder.caps) {
        return visible_t(entry, exit, near);
    }
    let side = side_interval(q, e, cylinder.radius);
    if passes_closed(q, e, cylinder, side, entry, near) {
        return entry;
    }
    if passes_closed(q, e, cylinder, side, exit, near) {
        return exit;
    }
    return NO_HIT;
}

// Whether the crossing at `t` is visible and not through an open end.
fn passes_closed(q: vec3<f32>, e: vec3<f32>, cylinder: Cylinder, side: vec2<f32>, t: f32, near: f32) -> bool {
    if !(abs(t) < NO_HIT && t >= near) {
        return false;
    }
    let y = q.y + t * e.y;
    let end = select(0u, 1u, y > 0.0);
    let on_side = (t == side.x || t == side.y) && abs(y) <= cylinder.half_length;
    return on_side || !has_cap(cylinder.caps, end, 0u);
}
