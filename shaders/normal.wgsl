// Normal and half of a cylinder at a hit: the twins of src/render/cpu/intersect/cylinder.rs.
#import "intersect.wgsl"

fn cylinder_normal(ray: Ray, cylinder: Cylinder, near: f32, t: f32) -> vec3<f32> {
    let to_camera = -normalize(ray.direction);
    let open = is_open(cylinder.caps);
    if t <= near && !open {
        return to_camera;
    }
    let ray_in_cylinder = cylinder_ray(ray, cylinder);
    let q = ray_in_cylinder.q;
    let e = ray_in_cylinder.e;
    let capped = capped_interval(q, e, cylinder);
    let solid = capped.solid;
    let open_ends = through_open_ends(e, cylinder.caps, solid, capped.slab);
    let leaving = open && (open_ends.x || ray_in_cylinder.t0 + solid.x < near);
    let local = select(solid.x, solid.y, leaving);
    let cap_plane = select(capped.slab.x, capped.slab.y, leaving);
    var local_normal = vec3<f32>(0.0, select(1.0, -1.0, e.y > 0.0), 0.0);
    if local != cap_plane {
        let p = q + e * local;
        let is_round = has_cap(cylinder.caps, select(0u, 1u, p.y > 0.0), 2u);
        let axial = select(p.y, clamp(p.y, -cylinder.half_length, cylinder.half_length), is_round);
        local_normal = normalize_or(p - vec3<f32>(0.0, axial, 0.0), -e);
    }
    let n = cylinder.row_x * local_normal.x + cylinder.row_y * local_normal.y + cylinder.row_z * local_normal.z;
    let from_inside = open && dot3(n, ray.direction) > 0.0;
    return normalize_or(select(n, -n, from_inside), to_camera);
}

fn cylinder_half(ray: Ray, cylinder: Cylinder, t: f32) -> bool {
    let local = cylinder_ray(ray, cylinder);
    return local.q.y + (t - local.t0) * local.e.y > 0.0;
}
