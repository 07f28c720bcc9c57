// Triangles of one sample: drawn as they are, an exact ray intersection a fragment. The functions are the twins of
// src/render/cpu/intersect/triangle.rs. Comments stand there.
#import "triangle_hit.wgsl"
#import "trapezoid.wgsl"
#import "color.wgsl"

fn triangle_weights(ray: Ray, triangle: Triangle) -> vec3<f32> {
    let volumes = edge_volumes(triangle_ray(ray, triangle).q, ray.direction, triangle);
    let sum = volumes.x + volumes.y + volumes.z;
    let weights = clamp(volumes / select(sum, 1.0, sum == 0.0), vec3<f32>(0.0), vec3<f32>(1.0));
    let total = weights.x + weights.y + weights.z;
    return select(vec3<f32>(1.0 / 3.0), weights / max(total, 1e-30), total > 0.0);
}

fn triangle_normal(ray: Ray, triangle: Triangle, weights: vec3<f32>, normals: mat3x3<f32>) -> vec3<f32> {
    let to_camera = -normalize(ray.direction);
    let face = normalize_or(face_of(triangle), to_camera);
    let smooth_normal = normalize_or(normals[0] * weights.x + normals[1] * weights.y + normals[2] * weights.z, face);
    let outwards = select(face, -face, dot3(smooth_normal, face) < 0.0);
    let normal = select(smooth_normal, -smooth_normal, dot3(outwards, ray.direction) > 0.0);
    return towards_camera(normal, ray.direction);
}

struct TriangleVertex {
    @builtin(position) position: vec4<f32>,
    // In view space: centre; the corners from there, in w what their weights may fall short of 0 by.
    @location(0) @interpolate(flat, either) center: vec3<f32>,
    @location(1) @interpolate(flat, either) a: vec4<f32>,
    @location(2) @interpolate(flat, either) b: vec4<f32>,
    @location(3) @interpolate(flat, either) c: vec4<f32>,
    @location(4) @interpolate(flat, either) normal_a: vec3<f32>,
    @location(5) @interpolate(flat, either) normal_b: vec3<f32>,
    @location(6) @interpolate(flat, either) normal_c: vec3<f32>,
    // Colours of the corners, id.
    @location(7) @interpolate(flat, either) look: vec4<u32>,
}

@vertex
fn vs_triangle(
    @builtin(vertex_index) corner: u32,
    @location(0) a_block: vec3<f32>,
    @location(1) b_block: vec3<f32>,
    @location(2) c_block: vec3<f32>,
    @location(3) normal_a: vec3<f32>,
    @location(4) normal_b: vec3<f32>,
    @location(5) normal_c: vec3<f32>,
    @location(6) colors_id: vec4<u32>,
) -> TriangleVertex {
    // Twin of Triangle::new.
    let middle = (a_block + b_block + c_block) * (1.0 / 3.0);
    var triangle: Triangle;
    triangle.center = view_point(middle);
    triangle.a = view_vector(a_block - middle);
    triangle.b = view_vector(b_block - middle);
    triangle.c = view_vector(c_block - middle);
    let double_area = length(face_of(triangle));
    let is_solid = double_area > 0.0 && double_area < NO_HIT;
    triangle.slack = slack_of(triangle);

    let a = triangle.center + triangle.a;
    let b = triangle.center + triangle.b;
    let c = triangle.center + triangle.c;
    var bounds = triangle_rect(a, b, c, frame.depth.z);
    let id = placed_id(colors_id.w);
    bounds.seen = bounds.seen && is_solid && is_drawn_in_sample(id, colors_id.x);
    var vertex: TriangleVertex;
    vertex.position = trapezoid_corner(bounds, corner, min(min(-a.z, -b.z), -c.z));
    vertex.center = triangle.center;
    vertex.a = vec4<f32>(triangle.a, triangle.slack.x);
    vertex.b = vec4<f32>(triangle.b, triangle.slack.y);
    vertex.c = vec4<f32>(triangle.c, triangle.slack.z);
    vertex.normal_a = view_vector(normal_a);
    vertex.normal_b = view_vector(normal_b);
    vertex.normal_c = view_vector(normal_c);
    vertex.look = vec4<u32>(colors_id.xyz, id);
    return vertex;
}

fn triangle_of(vertex: TriangleVertex) -> Triangle {
    let slack = vec3<f32>(vertex.a.w, vertex.b.w, vertex.c.w);
    return Triangle(vertex.center, vertex.a.xyz, vertex.b.xyz, vertex.c.xyz, slack);
}

// The nearest sRGB of a linear colour that the texel holds.
fn color_from_linear(linear: vec3<f32>) -> u32 {
    let steps = COLOR_STEPS * vec3<f32>(srgb_from_linear(linear.x), srgb_from_linear(linear.y), srgb_from_linear(linear.z)) + 0.5;
    return u32(steps.x) | (u32(steps.y) << 10u) | (u32(steps.z) << 20u);
}

@fragment
fn fs_triangle(vertex: TriangleVertex) -> Surface {
    let ray = pixel_ray(vertex.position, one_sample.offset);
    let triangle = triangle_of(vertex);
    let t = triangle_t(ray, triangle, frame.depth.z);
    if !(t < NO_HIT) {
        discard;
    }
    let weights = triangle_weights(ray, triangle);
    let linear = linear_from_srgb8(vertex.look.x) * weights.x + linear_from_srgb8(vertex.look.y) * weights.y
        + linear_from_srgb8(vertex.look.z) * weights.z;
    let normals = mat3x3<f32>(vertex.normal_a, vertex.normal_b, vertex.normal_c);
    return surface(vertex.look.w, t, triangle_normal(ray, triangle, weights, normals), color_from_linear(linear));
}
