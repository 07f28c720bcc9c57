// Cones of one sample: a trapezium an instance, an exact ray intersection a fragment. cone_normal is the
// twin of that in src/render/cpu/intersect/cone.rs.
#import "cone_hit.wgsl"
#import "outline.wgsl"
#import "trapezoid.wgsl"

fn cone_normal(ray: Ray, cone: Cone, near: f32, t: f32) -> vec3<f32> {
    let to_camera = -normalize(ray.direction);
    if t <= near {
        return to_camera;
    }
    let local = local_ray(ray, cone.center, cone.row_x, cone.row_y, cone.row_z);
    let slab = slab_interval(local.q, local.e, cone.half_length);
    let entry = body_interval(nappe_interval(local.q, local.e, cone.middle_radius, cone.slope), slab).x;
    var local_normal = vec3<f32>(0.0, select(1.0, -1.0, local.e.y > 0.0), 0.0);
    if entry != slab.x {
        let p = local.q + local.e * entry;
        let out = normalize_or(vec3<f32>(p.x, 0.0, p.z), vec3<f32>(0.0));
        local_normal = vec3<f32>(out.x, -cone.slope, out.z);
    }
    let n = cone.row_x * local_normal.x + cone.row_y * local_normal.y + cone.row_z * local_normal.z;
    return towards_camera(normalize_or(n, to_camera), ray.direction);
}

// Twins of outline::cone_radius, Outline::cone and cone_middle_t.
fn cone_radius(cone: Cone) -> f32 {
    return cone.middle_radius + abs(cone.slope) * cone.half_length;
}

fn outlined_cone(cone: Cone) -> Cone {
    let width = outline_width(cone.center, cone_radius(cone));
    var grown = cone;
    grown.half_length += width;
    grown.middle_radius += width * sqrt(1.0 + cone.slope * cone.slope);
    return grown;
}

fn cone_middle_t(ray: Ray, cone: Cone, near: f32) -> f32 {
    let local = local_ray(ray, cone.center, cone.row_x, cone.row_y, cone.row_z);
    let nappe = nappe_interval(local.q, local.e, cone.middle_radius, cone.slope);
    return middle(local.t0 + body_interval(nappe, slab_interval(local.q, local.e, cone.half_length)), near);
}

struct ConeVertex {
    @builtin(position) position: vec4<f32>,
    // Centre in view space, half length.
    @location(0) @interpolate(flat, either) center: vec4<f32>,
    // The rotation onto the cone's space by rows; in w the radius in the middle, and the slope.
    @location(1) @interpolate(flat, either) row_x: vec4<f32>,
    @location(2) @interpolate(flat, either) row_y: vec4<f32>,
    @location(3) @interpolate(flat, either) row_z: vec3<f32>,
    // Colour, id.
    @location(4) @interpolate(flat, either) look: vec2<u32>,
}

@vertex
fn vs_cone(
    @builtin(vertex_index) corner: u32,
    @location(0) a_radius: vec4<f32>,
    @location(1) b_radius: vec4<f32>,
    @location(2) color_id: vec2<u32>,
) -> ConeVertex {
    // Twin of Cone::new.
    let between = view_vector(b_radius.xyz - a_radius.xyz);
    let length = length(between);
    let radii = vec2<f32>(a_radius.w, b_radius.w);
    let is_solid = length > 1e-12 && radii.x >= 0.0 && radii.y >= 0.0 && radii.x + radii.y > 0.0;
    let axis = select(vec3<f32>(0.0, 1.0, 0.0), between / select(1.0, length, is_solid), is_solid);
    let rows = rotation_to_y(axis);
    var cone: Cone;
    cone.center = view_point((a_radius.xyz + b_radius.xyz) * 0.5);
    cone.row_x = rows[0];
    cone.row_y = rows[1];
    cone.row_z = rows[2];
    cone.half_length = length * 0.5;
    cone.middle_radius = (radii.x + radii.y) * 0.5;
    cone.slope = (radii.y - radii.x) / select(1.0, length, is_solid);

    let grown = outlined_cone(cone);
    let a = cone.center - axis * grown.half_length;
    let b = cone.center + axis * grown.half_length;
    // As given where nothing is added: the middle and the slope have been rounded.
    let change = grown.slope * grown.half_length * vec2<f32>(-1.0, 1.0);
    let reach = select(radii, max(grown.middle_radius + change, vec2<f32>(0.0)), has_outlines());
    var bounds = cone_rect(a, b, axis, reach, frame.depth.z);
    let id = placed_id(color_id.y);
    bounds.seen = bounds.seen && is_solid && is_drawn_in_sample(id, color_id.x);
    var vertex: ConeVertex;
    vertex.position = trapezoid_corner(bounds, corner, min(-a.z - reach.x, -b.z - reach.y));
    vertex.center = vec4<f32>(cone.center, cone.half_length);
    vertex.row_x = vec4<f32>(cone.row_x, cone.middle_radius);
    vertex.row_y = vec4<f32>(cone.row_y, cone.slope);
    vertex.row_z = cone.row_z;
    vertex.look = vec2<u32>(color_id.x, id);
    return vertex;
}

fn cone_of(vertex: ConeVertex) -> Cone {
    return Cone(
        vertex.center.xyz, vertex.row_x.xyz, vertex.row_y.xyz, vertex.row_z, vertex.center.w, vertex.row_x.w, vertex.row_y.w,
    );
}

@fragment
fn fs_cone(vertex: ConeVertex) -> Surface {
    let ray = pixel_ray(vertex.position, one_sample.offset);
    let cone = cone_of(vertex);
    let near = frame.depth.z;
    let t = cone_t(ray, cone, near);
    if !(t < NO_HIT) {
        let middle = cone_middle_t(ray, outlined_cone(cone), near);
        if !has_outlines() || !(middle < NO_HIT) {
            discard;
        }
        return rim(vertex.look.y, middle, cone_radius(cone));
    }
    return surface(vertex.look.y, t, cone_normal(ray, cone, near, t), color_from_srgb8(vertex.look.x));
}
