// Where a ray meets a torus: the twins of src/render/cpu/intersect/torus.rs. Comments stand there.
#import "intersect.wgsl"

struct Torus {
    center: vec3<f32>,
    // Rows of the rotation that turns the axis onto +Y.
    row_x: vec3<f32>,
    row_y: vec3<f32>,
    row_z: vec3<f32>,
    ring_radius: f32,
    tube_radius: f32,
}

const MOST_STEPS: u32 = 96u;

// Gradient, and in w the distance.
fn ring_distance(p: vec3<f32>, ring_radius: f32) -> vec4<f32> {
    let across = length(p.xz);
    let beside = across - ring_radius;
    let distance = length(vec2<f32>(beside, p.y));
    let over = 1.0 / select(1.0, distance, distance > 0.0);
    let outward = beside * over / select(1.0, across, across > 0.0);
    return vec4<f32>(p.x * outward, p.y * over, p.z * outward, distance);
}

fn torus_hit(q: vec3<f32>, e: vec3<f32>, torus: Torus, t0: f32, near: f32) -> vec2<f32> {
    let ring = torus.ring_radius;
    let tube = torus.tube_radius;
    let slack = 3.0 * 1.1920929e-7 * (ring + tube);
    let reached = 1e-5 * tube + slack;
    let wide = body_interval(side_interval(q, e, ring + tube + slack), slab_interval(q, e, tube + slack));
    let miss = vec2<f32>(NO_HIT);
    let start = near - t0;
    if !(wide.x <= wide.y && wide.y >= start) {
        return miss;
    }
    let per_t = length(e);
    let u = e / per_t;
    var way = max(wide.x, start) * per_t;
    let end = wide.y * per_t;
    var distance = 0.0;
    for (var step = 0u; step < MOST_STEPS; step++) {
        let p = q + u * way;
        let to_ring = ring_distance(p, ring);
        distance = to_ring.w - tube;
        if distance <= reached {
            if step == 0u && start >= wide.x {
                return vec2<f32>(near, start);
            }
            return vec2<f32>(t0 + way / per_t, way / per_t);
        }
        let slope = dot3(to_ring.xyz, u);
        let reach = 0.5 * length(p.xz);
        let bend = 1.0 / select(1e-30, reach, reach > 1e-30);
        let bent = 2.0 * distance / max(sqrt(slope * slope + 2.0 * bend * distance) - slope, 1e-30);
        way += max(distance, min(bent, reach));
        if way > end {
            return miss;
        }
    }
    return select(miss, vec2<f32>(t0 + way / per_t, way / per_t), distance <= 10.0 * reached);
}

fn torus_ray(ray: Ray, torus: Torus) -> LocalRay {
    return local_ray(ray, torus.center, torus.row_x, torus.row_y, torus.row_z);
}

fn torus_t(ray: Ray, torus: Torus, near: f32) -> f32 {
    let local = torus_ray(ray, torus);
    return max(torus_hit(local.q, local.e, torus, local.t0, near).x, near);
}
