// Where a ray meets a triangle: the twins of src/render/cpu/intersect/triangle.rs. Comments stand there.
#import "intersect.wgsl"

struct Triangle {
    center: vec3<f32>,
    // From the centre.
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    slack: vec3<f32>,
}

struct TriangleRay {
    q: vec3<f32>,
    t0: f32,
}

fn triangle_ray(ray: Ray, triangle: Triangle) -> TriangleRay {
    let d = ray.direction;
    let c = triangle.center - ray.origin;
    let t0 = dot3(c, d) / dot3(d, d);
    return TriangleRay(d * t0 - c, t0);
}

fn edge_volumes(q: vec3<f32>, d: vec3<f32>, triangle: Triangle) -> vec3<f32> {
    let a = triangle.a - q;
    let b = triangle.b - q;
    let c = triangle.c - q;
    return vec3<f32>(dot3(d, cross(b, c)), dot3(d, cross(c, a)), dot3(d, cross(a, b)));
}

fn face_of(triangle: Triangle) -> vec3<f32> {
    return cross(triangle.b - triangle.a, triangle.c - triangle.a);
}

fn triangle_t(ray: Ray, triangle: Triangle, near: f32) -> f32 {
    let local = triangle_ray(ray, triangle);
    let d = ray.direction;
    let n = face_of(triangle);
    let facing = dot3(n, d);
    let side = select(1.0, -1.0, facing < 0.0);
    let volumes = edge_volumes(local.q, d, triangle) * side;
    let inside = all(volumes >= triangle.slack * (-facing * side));
    let has_width = facing * facing > 1e-12 * (dot3(n, n) * dot3(d, d));
    let t = local.t0 + dot3(n, triangle.a - local.q) / select(1.0, facing, has_width);
    return select(NO_HIT, t, inside && has_width && t >= near);
}

// As Triangle::new has it.
fn slack_of(triangle: Triangle) -> vec3<f32> {
    let double_area = length(face_of(triangle));
    let edges = vec3<f32>(
        length(triangle.c - triangle.b), length(triangle.a - triangle.c), length(triangle.b - triangle.a),
    );
    let extent = max(max(edges.x, edges.y), edges.z);
    let place = abs(triangle.center);
    let rounding = 4.0 * 1.1920929e-7 * (max(max(place.x, place.y), place.z) + extent);
    return min(edges * (rounding / select(1.0, double_area, double_area > 0.0)), vec3<f32>(0.01));
}
