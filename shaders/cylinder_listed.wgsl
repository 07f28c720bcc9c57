// Cylinders that a list names: the same as cylinder.wgsl, their instances fetched by number.
#import "cylinder.wgsl"

// CylinderInstances, six of these each.
@group(2) @binding(0) var<storage, read> cylinders: array<vec2<u32>>;

struct Listed {
    a_radius: vec4<f32>,
    b: vec3<f32>,
    id: u32,
    // Colours of the halves a and b, caps.
    look: vec3<u32>,
}

fn listed(number: u32) -> Listed {
    let first = 6u * number;
    let a_radius = vec4<f32>(bitcast<vec2<f32>>(cylinders[first]), bitcast<vec2<f32>>(cylinders[first + 1u]));
    let z_id = cylinders[first + 3u];
    let b = vec3<f32>(bitcast<vec2<f32>>(cylinders[first + 2u]), bitcast<f32>(z_id.x));
    return Listed(a_radius, b, z_id.y, vec3<u32>(cylinders[first + 4u], cylinders[first + 5u].x));
}

@vertex
fn vs_cylinder_listed(@builtin(vertex_index) corner: u32, @location(0) number: u32) -> CylinderVertex {
    let stick = listed(number);
    return cylinder_vertex(corner, stick.a_radius, stick.b, stick.id, stick.look);
}
