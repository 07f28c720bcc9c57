// What reaches a surface point from afar: the twin of src/render/sky.rs, asked of depth maps as src/render/cpu/maps.rs does.
#import "shade.wgsl"

// A layer a direction: how far the scene reaches towards the light, in steps; 0 where there is nothing.
@group(2) @binding(0) var sky_maps: texture_2d_array<u32>;
// A row a direction: its maps' right, up, and the direction itself. Row 0: number of directions, texels on a side,
// texels per angstrom; steps per angstrom, height of the scene's centre in steps.
@group(2) @binding(1) var sky_directions: texture_2d<f32>;
@group(2) @binding(2) var key_maps: texture_2d_array<u32>;
@group(2) @binding(3) var key_directions: texture_2d<f32>;

const LIFT: f32 = 2.0;
const STEEPEST: f32 = 64.0;

// Where a point falls in a map: texel, and the steps that its tangent plane has at the texel's centre.
struct Place {
    texel: vec2<i32>,
    level: f32,
}

fn place_in_map(p: vec3<f32>, n: vec3<f32>, axes: mat3x3<f32>, size: vec4<f32>, steps: vec4<f32>) -> Place {
    let side = size.y;
    let at = vec2<f32>(dot(p, axes[0]), -dot(p, axes[1])) * size.z + side * 0.5;
    let texel = clamp(floor(at), vec2<f32>(0.0), vec2<f32>(side - 1.0));
    let way = texel + 0.5 - at;
    let rise = dot(n, axes[0]) * way.x - dot(n, axes[1]) * way.y;
    let shift = clamp(-rise / max(dot(n, axes[2]), 0.02), -STEEPEST, STEEPEST);
    let height = dot(p, axes[2]) * steps.x + steps.y;
    return Place(vec2<i32>(texel), height + LIFT + shift * steps.x / size.z);
}

fn sky_open(p: vec3<f32>, n: vec3<f32>) -> f32 {
    let size = textureLoad(sky_directions, vec2<i32>(0, 0), 0);
    let steps = textureLoad(sky_directions, vec2<i32>(1, 0), 0);
    let count = i32(size.x);
    var seen = 0.0;
    var all = 0.0;
    for (var i = 0; i < count; i++) {
        let toward = textureLoad(sky_directions, vec2<i32>(2, i + 1), 0).xyz;
        let weight = max(dot(n, toward), 0.0);
        all += weight;
        if weight > 0.0 {
            let right = textureLoad(sky_directions, vec2<i32>(0, i + 1), 0).xyz;
            let up = textureLoad(sky_directions, vec2<i32>(1, i + 1), 0).xyz;
            let place = place_in_map(p, n, mat3x3<f32>(right, up, toward), size, steps);
            let stored = f32(textureLoad(sky_maps, place.texel, i, 0).x);
            seen += select(0.0, weight, stored <= place.level);
        }
    }
    return select(frame.sky.z, seen / max(all, 1e-6), count > 0 && all > 0.0);
}

fn key_seen(p: vec3<f32>, n: vec3<f32>) -> f32 {
    let size = textureLoad(key_directions, vec2<i32>(0, 0), 0);
    let steps = textureLoad(key_directions, vec2<i32>(1, 0), 0);
    let count = i32(size.x);
    var seen = 0.0;
    for (var i = 0; i < count; i++) {
        let toward = textureLoad(key_directions, vec2<i32>(2, i + 1), 0).xyz;
        if dot(n, toward) > 0.0 {
            let right = textureLoad(key_directions, vec2<i32>(0, i + 1), 0).xyz;
            let up = textureLoad(key_directions, vec2<i32>(1, i + 1), 0).xyz;
            let place = place_in_map(p, n, mat3x3<f32>(right, up, toward), size, steps);
            let stored = f32(textureLoad(key_maps, place.texel, i, 0).x);
            seen += select(0.0, 1.0, stored <= place.level);
        }
    }
    return select(1.0, seen / f32(max(count, 1)), count > 0);
}

// Twin of Lights and Reaches of the CPU renderer. Where the near plane cuts a solid there is no surface to reach.
fn reach_of(ray: Ray, t: f32, normal: vec3<f32>) -> Reach {
    if t <= frame.depth.z {
        return Reach(frame.sky.z, 1.0);
    }
    let center = 0.5 * (frame.bounds_min.xyz + frame.bounds_max.xyz);
    let p = world_point(ray.origin + ray.direction * t) - center;
    let n = world_vector(normal);
    return Reach(sky_open(p, n), key_seen(p, n));
}
