// Normal and half of a cylinder at a hit: the twins of src/render/cpu/intersect.rs.
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
    let solid = solid_interval(q, e, cylinder);
    var local = t - ray_in_cylinder.t0;
    var on_side = solid.from_side;
    if !open && solid.entry <= solid.exit {
        local = solid.entry;
    } else if open {
        let side = side_interval(q, e, cylinder.radius);
        let slab = slab_interval(q, e, cylinder.half_length);
        let from_side = min(abs(local - side.x), abs(local - side.y));
        on_side = from_side <= min(abs(local - slab.x), abs(local - slab.y));
    }
    var p = q + e * local;
    var center = vec3<f32>(0.0, p.y, 0.0);
    for (var end = 0u; end < 2u; end++) {
        if has_cap(cylinder.caps, end, 2u) {
            let y = select(cylinder.half_length, -cylinder.half_length, end == 0u);
            let ball = end_interval(q, e, y, cylinder.radius);
            if ball.x < NO_HIT && (ball.x < solid.entry || solid.entry > solid.exit) {
                let at = q + e * ball.x;
                let outside = select(at.y >= y, at.y <= y, end == 0u);
                if outside {
                    p = at;
                    center = vec3<f32>(0.0, y, 0.0);
                    on_side = true;
                }
            }
        }
    }
    var local_normal = vec3<f32>(0.0, select(1.0, -1.0, e.y > 0.0), 0.0);
    if on_side {
        local_normal = normalize_or(p - center, -e);
    }
    let n = cylinder.row_x * local_normal.x + cylinder.row_y * local_normal.y + cylinder.row_z * local_normal.z;
    let from_inside = open && dot3(n, ray.direction) > 0.0;
    return normalize_or(select(n, -n, from_inside), to_camera);
}

fn cylinder_half(ray: Ray, cylinder: Cylinder, t: f32) -> bool {
    let local = cylinder_ray(ray, cylinder);
    return local.q.y + (t - local.t0) * local.e.y > 0.0;
}
