// Spheres that a list names: the same as sphere.wgsl, their instances fetched by number.
#import "sphere.wgsl"

// SphereInstances, three of these each.
@group(2) @binding(0) var<storage, read> spheres: array<vec2<u32>>;

@vertex
fn vs_sphere_listed(@builtin(vertex_index) corner: u32, @location(0) number: u32) -> SphereVertex {
    let first = 3u * number;
    let center_radius = vec4<f32>(bitcast<vec2<f32>>(spheres[first]), bitcast<vec2<f32>>(spheres[first + 1u]));
    return sphere_vertex(corner, center_radius, spheres[first + 2u]);
}
