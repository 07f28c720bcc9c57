// Cylinders that a list names: the same as cylinder.wgsl, their instances fetched by number.
#import "cylinder.wgsl"

// CylinderInstances, six of these each.
@group(2) @binding(0) var<storage, read> cylinders: array<vec2<u32>>;

@vertex
fn vs_cylinder_listed(@builtin(vertex_index) corner: u32, @location(0) number: u32) -> CylinderVertex {
    let first = 6u * number;
    let a_radius = vec4<f32>(bitcast<vec2<f32>>(cylinders[first]), bitcast<vec2<f32>>(cylinders[first + 1u]));
    let z_id = cylinders[first + 3u];
    let b = vec3<f32>(bitcast<vec2<f32>>(cylinders[first + 2u]), bitcast<f32>(z_id.x));
    let colors_caps = vec3<u32>(cylinders[first + 4u], cylinders[first + 5u].x);
    return cylinder_vertex(corner, a_radius, b, z_id.y, colors_caps);
}
