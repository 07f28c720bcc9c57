// Outlines: the twins of src/render/outline.rs and, for balls and sticks, of src/render/cpu/intersect/middle.rs. Comments stand there.
#import "intersect.wgsl"
#import "geometry.wgsl"

const MOST_WIDTH: f32 = 0.4;

fn has_outlines() -> bool {
    return frame.outline.x + frame.outline.y > 0.0;
}

fn outline_width(center: vec3<f32>, radius: f32) -> f32 {
    return min(frame.outline.x * max(-center.z, frame.depth.z) + frame.outline.y, MOST_WIDTH * radius);
}

fn middle(way: vec2<f32>, near: f32) -> f32 {
    let hit = way.x <= way.y && way.y >= near;
    return select(NO_HIT, 0.5 * (max(way.x, near) + way.y), hit);
}

// The line around something of this radius, its silhouette at depth `t`.
fn rim(id: u32, t: f32, radius: f32) -> Surface {
    let depth = t + frame.outline.z * radius;
    return Surface(vec4<u32>(id, bitcast<u32>(depth), bitcast<u32>(t), RIM), depth_value(depth));
}

fn sphere_middle_t(ray: Ray, sphere: Sphere, near: f32) -> f32 {
    return middle(sphere_interval(ray, sphere), near);
}

fn cylinder_middle_t(ray: Ray, cylinder: Cylinder, near: f32) -> f32 {
    let local = cylinder_ray(ray, cylinder);
    let solid = capped_interval(local.q, local.e, cylinder).solid;
    return middle(local.t0 + solid, near);
}

// Twin of Outline::cylinder.
fn outlined_cylinder(cylinder: Cylinder) -> Cylinder {
    let width = outline_width(cylinder.center, cylinder.radius);
    var grown = cylinder;
    grown.radius += width;
    let is_round = has_cap(cylinder.caps, 0u, 2u) || has_cap(cylinder.caps, 1u, 2u);
    grown.half_length += select(width, 0.0, is_round);
    return grown;
}
