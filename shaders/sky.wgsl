// What reaches a surface point from afar: the twin of src/render/sky.rs and of src/render/cpu/reach.rs.
#import "shade.wgsl"
#import "tubes.wgsl"

// As in src/render/sky.rs.
const START_OFFSET: f32 = 1e-3;
const START_ROUNDING: f32 = 1e-6;

// Of a light's directions that are this sample's turn: the weights of those that a point (from the scene's centre) with this
// normal sees, and of all. The sky's are weighted by their cosine.
fn weights_seen(is_key: bool, p: vec3<f32>, n: vec3<f32>) -> vec2<f32> {
    let head = direction_texel(is_key, 0, 0);
    let each = i32(head.x);
    var seen = 0.0;
    var all = 0.0;
    if each > 0 {
        let first = i32(one_sample.done % u32(head.y)) * each + 1;
        for (var row = first; row < first + each; row++) {
            let cosine = max(dot3(n, direction_texel(is_key, 2, row).xyz), 0.0);
            let weight = select(cosine, 1.0, is_key);
            all += weight;
            if cosine > 0.0 {
                seen += select(0.0, weight, is_free(is_key, u32(head.z), row, p));
            }
        }
    }
    return vec2<f32>(seen, all);
}

fn part_seen(is_key: bool, p: vec3<f32>, n: vec3<f32>, unasked: f32) -> f32 {
    let weights = weights_seen(is_key, p, n);
    return select(unasked, weights.x / max(weights.y, 1e-30), weights.y > 0.0);
}

// Where the rays of a surface point with this normal (both in world space) start, from the scene's centre.
fn reach_start(ray: Ray, t: f32, n: vec3<f32>) -> vec3<f32> {
    let eye = frame.world_from_view[3].xyz - scene_center();
    return world_vector(ray.origin + ray.direction * t) + eye + n * max(START_OFFSET, START_ROUNDING * t);
}

// Where the near plane cuts a solid there is no surface to reach.
fn reach_of(ray: Ray, t: f32, normal: vec3<f32>) -> Reach {
    if t <= frame.depth.z {
        return Reach(frame.sky.z, 1.0);
    }
    let n = world_vector(normal);
    let p = reach_start(ray, t, n);
    return Reach(part_seen(false, p, n, frame.sky.z), part_seen(true, p, n, 1.0));
}
