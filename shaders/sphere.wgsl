// Spheres of one sample: a quad an instance, an exact ray intersection a fragment.
#import "outline.wgsl"

struct SphereVertex {
    @builtin(position) position: vec4<f32>,
    // Centre in view space, radius.
    @location(0) @interpolate(flat, either) ball: vec4<f32>,
    // Colour, id.
    @location(1) @interpolate(flat, either) look: vec2<u32>,
}

@vertex
fn vs_sphere(
    @builtin(vertex_index) corner: u32,
    @location(0) center_radius: vec4<f32>,
    @location(1) color_id: vec2<u32>,
) -> SphereVertex {
    return sphere_vertex(corner, center_radius, color_id);
}

fn sphere_vertex(corner: u32, center_radius: vec4<f32>, color_id: vec2<u32>) -> SphereVertex {
    let center = view_point(center_radius.xyz);
    let radius = center_radius.w;
    let id = placed_id(color_id.y);
    let reach = radius + outline_width(center, radius);
    var rect = sphere_rect(center, reach, frame.depth.z);
    rect.seen = rect.seen && is_drawn_in_sample(id, color_id.x);
    var vertex: SphereVertex;
    vertex.position = quad_corner(rect, corner, -center.z - reach);
    vertex.ball = vec4<f32>(center, radius);
    vertex.look = vec2<u32>(color_id.x, id);
    return vertex;
}

@fragment
fn fs_sphere(vertex: SphereVertex) -> Surface {
    return sphere_surface(vertex);
}

fn sphere_surface(vertex: SphereVertex) -> Surface {
    let ray = pixel_ray(vertex.position, one_sample.offset);
    let sphere = Sphere(vertex.ball.xyz, vertex.ball.w);
    let near = frame.depth.z;
    let t = sphere_t(ray, sphere, near);
    if !(t < NO_HIT) {
        let grown = Sphere(sphere.center, sphere.radius + outline_width(sphere.center, sphere.radius));
        let middle = sphere_middle_t(ray, grown, near);
        if !has_outlines() || !(middle < NO_HIT) {
            discard;
        }
        return rim(vertex.look.y, middle, sphere.radius);
    }
    return surface(vertex.look.y, t, sphere_normal(ray, sphere, near, t), color_from_srgb8(vertex.look.x));
}
