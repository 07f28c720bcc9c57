// Tori of one sample: some quads an instance around the tube, an exact ray intersection a fragment. The functions are the twins of
// torus_normal in src/render/cpu/intersect/torus.rs and of bounds::torus_rect. Comments stand there.
#import "torus_hit.wgsl"
#import "outline.wgsl"

fn torus_normal(ray: Ray, torus: Torus, near: f32, t: f32) -> vec3<f32> {
    let to_camera = -normalize(ray.direction);
    if t <= near {
        return to_camera;
    }
    let local = torus_ray(ray, torus);
    let way = torus_hit(local.q, local.e, torus, local.t0, near).y;
    if !(way < NO_HIT) {
        return to_camera;
    }
    let gradient = ring_distance(local.q + local.e * way, torus.ring_radius);
    let n = torus.row_x * gradient.x + torus.row_y * gradient.y + torus.row_z * gradient.z;
    return towards_camera(normalize_or(n, to_camera), ray.direction);
}

// Twins of Outline::torus and torus_middle_t.
fn outlined_torus(torus: Torus) -> Torus {
    var grown = torus;
    grown.tube_radius += outline_width(torus.center, torus.tube_radius);
    return grown;
}

fn torus_middle_t(ray: Ray, torus: Torus, near: f32) -> f32 {
    let local = torus_ray(ray, torus);
    let hit = torus_hit(local.q, local.e, torus, local.t0, near);
    if !(hit.x < NO_HIT) || hit.x <= near {
        return max(hit.x, near);
    }
    let p = local.q + local.e * hit.y;
    let out = ring_distance(p, torus.ring_radius).xyz;
    let across = length(p.xz);
    let over = 1.0 / select(1.0, across, across > 0.0);
    let along = (p.x * local.e.z - p.z * local.e.x) * over;
    let ee = dot3(local.e, local.e);
    let ring_bend = along * along * (p.x * out.x + p.z * out.z) * over * over;
    let tube_bend = (ee - along * along) / torus.tube_radius;
    return hit.x + max(-dot3(out, local.e), 0.0) / max(tube_bend + ring_bend, 0.1 * ee / torus.tube_radius);
}

const TORUS_PIECES: u32 = 16u;

fn is_whole(torus: Torus) -> bool {
    let ring = torus.ring_radius;
    let tube = torus.tube_radius;
    let up = vec3<f32>(0.0, 0.0, 1.0);
    let sight = select(normalize_or(torus.center, up), up, is_orthographic());
    let open = ring * abs(dot3(torus.row_y, sight));
    let pieces = 1.6 * 2.0 * tube * 3.1415927 * (ring + open);
    return tube > 0.6 * ring || 4.0 * (ring + tube) * (open + tube) < pieces;
}

fn torus_rect(torus: Torus, piece: u32, near: f32) -> PlaneRect {
    let ring = torus.ring_radius;
    let tube = torus.tube_radius;
    if is_whole(torus) {
        if piece > 0u {
            return unseen_rect();
        }
        let half = torus.row_y * tube;
        return cylinder_rect(torus.center - half, torus.center + half, torus.row_y, ring + tube, false, false, near);
    }
    let cosine = 0.9807853;
    let sine = 0.19509032;
    let angle = 6.2831855 / f32(TORUS_PIECES) * f32(piece);
    let outward = torus.row_x * cos(angle) + torus.row_z * sin(angle);
    let onward = torus.row_z * cos(angle) - torus.row_x * sin(angle);
    let bulge = ring * (1.0 - cosine) * 0.5;
    let middle = torus.center + outward * (ring - bulge);
    let reach = onward * (ring * sine + tube * sine);
    return cylinder_rect(middle - reach, middle + reach, onward, tube + bulge, false, false, near);
}

struct TorusVertex {
    @builtin(position) position: vec4<f32>,
    // Centre in view space, radius of the ring.
    @location(0) @interpolate(flat, either) center: vec4<f32>,
    // The rotation onto the torus' space by rows; in the first row's w the radius of the tube.
    @location(1) @interpolate(flat, either) row_x: vec4<f32>,
    @location(2) @interpolate(flat, either) row_y: vec3<f32>,
    @location(3) @interpolate(flat, either) row_z: vec3<f32>,
    // Colour, id.
    @location(4) @interpolate(flat, either) look: vec2<u32>,
}

// Six vertices a piece: the first and the last corner twice, so that the strip draws nothing between the quads.
@vertex
fn vs_torus(
    @builtin(vertex_index) vertex_index: u32,
    @location(0) center_ring: vec4<f32>,
    @location(1) axis_tube: vec4<f32>,
    @location(2) color_id: vec2<u32>,
) -> TorusVertex {
    let corner = clamp(vertex_index % 6u, 1u, 4u) - 1u;
    // Twin of Torus::new.
    let axis = view_vector(axis_tube.xyz);
    let length = length(axis);
    let is_solid = length > 1e-12 && center_ring.w >= 0.0 && axis_tube.w > 0.0;
    let unit = select(vec3<f32>(0.0, 1.0, 0.0), axis / select(1.0, length, is_solid), is_solid);
    let rows = rotation_to_y(unit);
    let center = view_point(center_ring.xyz);
    let torus = Torus(center, rows[0], rows[1], rows[2], center_ring.w, axis_tube.w);
    let grown = outlined_torus(torus);
    var rect = torus_rect(grown, vertex_index / 6u, frame.depth.z);
    let id = placed_id(color_id.y);
    rect.seen = rect.seen && is_solid && is_drawn_in_sample(id, color_id.x);
    var vertex: TorusVertex;
    let nearest = -center.z - sqrt(max(1.0 - unit.z * unit.z, 0.0)) * center_ring.w - grown.tube_radius;
    vertex.position = quad_corner(rect, corner, nearest);
    vertex.center = vec4<f32>(center, center_ring.w);
    vertex.row_x = vec4<f32>(rows[0], axis_tube.w);
    vertex.row_y = rows[1];
    vertex.row_z = rows[2];
    vertex.look = vec2<u32>(color_id.x, id);
    return vertex;
}

fn torus_of(vertex: TorusVertex) -> Torus {
    return Torus(vertex.center.xyz, vertex.row_x.xyz, vertex.row_y, vertex.row_z, vertex.center.w, vertex.row_x.w);
}

@fragment
fn fs_torus(vertex: TorusVertex) -> Surface {
    let ray = pixel_ray(vertex.position, one_sample.offset);
    let torus = torus_of(vertex);
    let near = frame.depth.z;
    let t = torus_t(ray, torus, near);
    if !(t < NO_HIT) {
        let middle = torus_middle_t(ray, outlined_torus(torus), near);
        if !has_outlines() || !(middle < NO_HIT) {
            discard;
        }
        return rim(vertex.look.y, middle, torus.tube_radius);
    }
    return surface(vertex.look.y, t, torus_normal(ray, torus, near, t), color_from_srgb8(vertex.look.x));
}
