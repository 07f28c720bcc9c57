// A stick of a placement in view space.
#import "outline.wgsl"

// Twin of Cylinder::new.
fn placed_cylinder(a_radius: vec4<f32>, b_block: vec3<f32>, caps: u32) -> Cylinder {
    let radius = a_radius.w;
    let between = view_vector(b_block - a_radius.xyz);
    let length = length(between);
    let is_solid = length > 1e-12 && radius > 0.0;
    let axis = between / select(1.0, length, is_solid);
    let center = view_point((a_radius.xyz + b_block) * 0.5);
    let rows = rotation_to_y(select(vec3<f32>(0.0, 1.0, 0.0), axis, is_solid));
    return Cylinder(center, rows[0], rows[1], rows[2], length * 0.5, radius, caps);
}

// Without length or width there is nothing to draw.
fn is_solid(cylinder: Cylinder) -> bool {
    return cylinder.half_length > 0.5e-12 && cylinder.radius > 0.0;
}
