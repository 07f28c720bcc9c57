// Exact intersections of a view ray with spheres and cylinders: the twins, function for function, of
// src/render/cpu/intersect, with NO_HIT for infinity. Comments stand there; cones, tori and triangles have files of their own.
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

fn sphere_interval(ray: Ray, sphere: Sphere) -> vec2<f32> {
    let d = ray.direction;
    let dd = dot3(d, d);
    let c = sphere.center - ray.origin;
    let t0 = dot3(c, d) / dd;
    let p = d * t0 - c;
    let pd = dot3(p, d);
    let outside = dot3(p, p) - sphere.radius * sphere.radius;
    let discriminant = pd * pd - dd * outside;
    let root = sqrt(max(discriminant, 0.0));
    let way = vec2<f32>(t0 + (-pd - root) / dd, t0 + (-pd + root) / dd);
    return vec2<f32>(select(NO_HIT, way.x, discriminant >= 0.0), way.y);
}

fn sphere_t(ray: Ray, sphere: Sphere, near: f32) -> f32 {
    let way = sphere_interval(ray, sphere);
    return visible_t(way.x, way.y, near);
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

// Twin of cone::towards_camera.
fn towards_camera(normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    if dot3(normal, direction) <= 0.0 {
        return normal;
    }
    let back = -normalize(direction);
    return normalize_or(normal - back * dot3(normal, back), back);
}

// The ray in a primitive's space: origin, direction, and the t of its origin.
struct LocalRay {
    q: vec3<f32>,
    e: vec3<f32>,
    t0: f32,
}

fn local_ray(ray: Ray, center: vec3<f32>, row_x: vec3<f32>, row_y: vec3<f32>, row_z: vec3<f32>) -> LocalRay {
    let d = ray.direction;
    let dd = dot3(d, d);
    let c = center - ray.origin;
    let t0 = dot3(c, d) / dd;
    let p = d * t0 - c;
    let q = vec3<f32>(dot3(row_x, p), dot3(row_y, p), dot3(row_z, p));
    let e = vec3<f32>(dot3(row_x, d), dot3(row_y, d), dot3(row_z, d));
    return LocalRay(q, e, t0);
}

fn cylinder_ray(ray: Ray, cylinder: Cylinder) -> LocalRay {
    return local_ray(ray, cylinder.center, cylinder.row_x, cylinder.row_y, cylinder.row_z);
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
    let middle = -dot3(p, e) / dd;
    let m = p + e * middle;
    let left = radius * radius - dot3(m, m);
    let half = sqrt(max(left, 0.0) / dd);
    return select(vec2<f32>(middle - half, middle + half), vec2<f32>(NO_HIT, -NO_HIT), left < 0.0);
}

fn has_cap(caps: u32, end: u32, kind: u32) -> bool {
    return ((caps >> (2u * end)) & 3u) == kind;
}

fn is_open(caps: u32) -> bool {
    return has_cap(caps, 0u, 0u) || has_cap(caps, 1u, 0u);
}

fn body_interval(side: vec2<f32>, slab: vec2<f32>) -> vec2<f32> {
    let entry = max(side.x, slab.x);
    let exit = min(side.y, slab.y);
    return select(vec2<f32>(NO_HIT, -NO_HIT), vec2<f32>(entry, exit), entry <= exit);
}

// Both caps flat.
const FLAT_CAPS: u32 = 5u;

fn cylinder_t(ray: Ray, cylinder: Cylinder, near: f32) -> f32 {
    let local = cylinder_ray(ray, cylinder);
    if cylinder.caps == FLAT_CAPS {
        let side = side_interval(local.q, local.e, cylinder.radius);
        let body = body_interval(side, slab_interval(local.q, local.e, cylinder.half_length));
        return visible_t(local.t0 + body.x, local.t0 + body.y, near);
    }
    return capped_t(local.q, local.e, cylinder, local.t0, near);
}

struct CappedInterval {
    solid: vec2<f32>,
    slab: vec2<f32>,
}

fn capped_interval(q: vec3<f32>, e: vec3<f32>, cylinder: Cylinder) -> CappedInterval {
    let h = cylinder.half_length;
    let slab = slab_interval(q, e, h);
    var solid = body_interval(side_interval(q, e, cylinder.radius), slab);
    for (var end = 0u; end < 2u; end++) {
        if !has_cap(cylinder.caps, end, 2u) {
            continue;
        }
        let side = select(1.0, -1.0, end == 0u);
        var ball = end_interval(q, e, side * h, cylinder.radius);
        if !has_cap(cylinder.caps, 1u - end, 2u) {
            if abs(e.y) <= 1e-20 {
                ball.x = select(NO_HIT, ball.x, side * q.y >= -h);
            } else if side * e.y > 0.0 {
                ball.x = max(ball.x, slab.x);
            } else {
                ball.y = min(ball.y, slab.y);
            }
        }
        if ball.x <= ball.y {
            solid = vec2<f32>(min(solid.x, ball.x), max(solid.y, ball.y));
        }
    }
    return CappedInterval(solid, slab);
}

// Whether the ray enters, and whether it leaves, through an open end.
fn through_open_ends(e: vec3<f32>, caps: u32, solid: vec2<f32>, slab: vec2<f32>) -> vec2<bool> {
    let first = select(0u, 1u, e.y <= 0.0);
    return vec2<bool>(
        solid.x == slab.x && has_cap(caps, first, 0u), solid.y == slab.y && has_cap(caps, 1u - first, 0u),
    );
}

fn capped_t(q: vec3<f32>, e: vec3<f32>, cylinder: Cylinder, t0: f32, near: f32) -> f32 {
    let capped = capped_interval(q, e, cylinder);
    let solid = capped.solid;
    let entry = t0 + solid.x;
    let exit = t0 + solid.y;
    if !is_open(cylinder.caps) {
        return visible_t(entry, exit, near);
    }
    let open = through_open_ends(e, cylinder.caps, solid, capped.slab);
    let far = select(NO_HIT, exit, solid.x <= solid.y && !open.y && exit >= near);
    return select(far, entry, solid.x <= solid.y && !open.x && entry >= near);
}
