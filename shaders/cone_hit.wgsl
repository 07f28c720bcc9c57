// Where a ray meets a cone: the twins of src/render/cpu/intersect/cone.rs. Comments stand there.
#import "intersect.wgsl"

struct Cone {
    center: vec3<f32>,
    // Rows of the rotation that turns the axis onto +Y.
    row_x: vec3<f32>,
    row_y: vec3<f32>,
    row_z: vec3<f32>,
    half_length: f32,
    middle_radius: f32,
    slope: f32,
}

fn nappe_interval(q: vec3<f32>, e: vec3<f32>, middle: f32, slope: f32) -> vec2<f32> {
    let rho = middle + slope * q.y;
    let sigma = slope * e.y;
    let ee = e.x * e.x + e.z * e.z;
    let a = ee - sigma * sigma;
    let half_b = q.x * e.x + q.z * e.z - sigma * rho;
    let qq = q.x * q.x + q.z * q.z;
    let c = qq - rho * rho;
    let wx = rho * e.x - sigma * q.x;
    let wz = rho * e.z - sigma * q.z;
    let across = q.x * e.z - q.z * e.x;
    let discriminant = wx * wx + wz * wz - across * across;
    if ee + sigma * sigma <= 1e-12 * (ee + e.y * e.y) {
        return select(vec2<f32>(NO_HIT, -NO_HIT), vec2<f32>(-NO_HIT, NO_HIT), c <= 0.0);
    }
    if a > 0.0 && discriminant < 0.0 {
        return vec2<f32>(NO_HIT, -NO_HIT);
    }
    let root = sqrt(max(discriminant, 0.0));
    let sum = select(root - half_b, -half_b - root, half_b > 0.0);
    // No infinity: a root farther away than the slab ever is.
    let far = clamp(sum / select(a, -1e-30, abs(a) < 1e-30), -1e30, 1e30);
    let near = select(c / select(sum, 1.0, sum == 0.0), far, sum == 0.0);
    let first = min(far, near);
    let second = max(far, near);
    if a > 0.0 {
        return vec2<f32>(first, second);
    }
    return select(vec2<f32>(-NO_HIT, first), vec2<f32>(second, NO_HIT), sigma > 0.0);
}

fn cone_t(ray: Ray, cone: Cone, near: f32) -> f32 {
    let local = local_ray(ray, cone.center, cone.row_x, cone.row_y, cone.row_z);
    let nappe = nappe_interval(local.q, local.e, cone.middle_radius, cone.slope);
    let body = body_interval(nappe, slab_interval(local.q, local.e, cone.half_length));
    return visible_t(local.t0 + body.x, local.t0 + body.y, near);
}
