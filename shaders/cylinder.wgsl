// Cylinders of one sample: a quad an instance, an exact ray intersection a fragment.
#import "normal.wgsl"
#import "placed.wgsl"

struct CylinderVertex {
    @builtin(position) position: vec4<f32>,
    // Centre in view space, half length.
    @location(0) @interpolate(flat, either) center: vec4<f32>,
    // The rotation camera_to_cylinder by rows; in the first row's w the radius.
    @location(1) @interpolate(flat, either) row_x: vec4<f32>,
    @location(2) @interpolate(flat, either) row_y: vec3<f32>,
    @location(3) @interpolate(flat, either) row_z: vec3<f32>,
    // Colours of the halves a and b, caps, id.
    @location(4) @interpolate(flat, either) look: vec4<u32>,
}

@vertex
fn vs_cylinder(
    @builtin(vertex_index) corner: u32,
    @location(0) a_radius: vec4<f32>,
    @location(1) b_block: vec3<f32>,
    @location(2) id: u32,
    @location(3) colors_caps: vec3<u32>,
) -> CylinderVertex {
    return cylinder_vertex(corner, a_radius, b_block, id, colors_caps);
}

fn cylinder_vertex(
    corner: u32, a_radius: vec4<f32>, b_block: vec3<f32>, id: u32, colors_caps: vec3<u32>,
) -> CylinderVertex {
    let cylinder = placed_cylinder(a_radius, b_block, colors_caps.z);
    let grown = outlined_cylinder(cylinder);
    let axis = cylinder.row_y;
    let caps = cylinder.caps;
    let a = cylinder.center - axis * grown.half_length;
    let b = cylinder.center + axis * grown.half_length;
    var rect = cylinder_rect(a, b, axis, grown.radius, has_cap(caps, 0u, 2u), has_cap(caps, 1u, 2u), frame.depth.z);
    let placed = placed_id(id);
    rect.seen = rect.seen && is_solid(cylinder) && is_drawn_in_sample(placed, colors_caps.x);
    let position = quad_corner(rect, corner, min(-a.z, -b.z) - grown.radius);
    return vertex_of(cylinder, position, vec4<u32>(colors_caps, placed));
}

fn vertex_of(cylinder: Cylinder, position: vec4<f32>, look: vec4<u32>) -> CylinderVertex {
    var vertex: CylinderVertex;
    vertex.position = position;
    vertex.center = vec4<f32>(cylinder.center, cylinder.half_length);
    vertex.row_x = vec4<f32>(cylinder.row_x, cylinder.radius);
    vertex.row_y = cylinder.row_y;
    vertex.row_z = cylinder.row_z;
    vertex.look = look;
    return vertex;
}

fn cylinder_of(vertex: CylinderVertex) -> Cylinder {
    return Cylinder(
        vertex.center.xyz, vertex.row_x.xyz, vertex.row_y, vertex.row_z, vertex.center.w, vertex.row_x.w, vertex.look.z,
    );
}

@fragment
fn fs_cylinder(vertex: CylinderVertex) -> Surface {
    return cylinder_surface(vertex);
}

fn cylinder_surface(vertex: CylinderVertex) -> Surface {
    let ray = pixel_ray(vertex.position, one_sample.offset);
    let cylinder = cylinder_of(vertex);
    let near = frame.depth.z;
    let t = cylinder_t(ray, cylinder, near);
    if !(t < NO_HIT) {
        let middle = cylinder_middle_t(ray, outlined_cylinder(cylinder), near);
        if !has_outlines() || !(middle < NO_HIT) {
            discard;
        }
        return rim(vertex.look.w, middle, cylinder.radius);
    }
    let rgb = select(vertex.look.x, vertex.look.y, cylinder_half(ray, cylinder, t));
    return surface(vertex.look.w, t, cylinder_normal(ray, cylinder, near, t), color_from_srgb8(rgb));
}
