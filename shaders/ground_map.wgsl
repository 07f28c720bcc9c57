// Key light and open sky of every texel of the ground map: the twins of src/render/field.rs. Comments stand there.
#import "fullscreen.wgsl"
#import "field.wgsl"

fn ground_shadow(p: vec3<f32>) -> f32 {
    let to_light = frame.key_in_world.xyz;
    if to_light.y <= 0.0 {
        return 1.0;
    }
    let start = 1e-3 * length(frame.bounds_max.xyz - frame.bounds_min.xyz);
    let visible = visit(Query(p, to_light, start, frame.ground_map_size.z), 1.0);
    return visible * visible * (3.0 - 2.0 * visible);
}

fn ground_open(p: vec3<f32>) -> f32 {
    var taps = array<f32, 6>(0.03, 0.07, 0.16, 0.33, 0.6, 1.0);
    let reach = frame.ground_map_size.w;
    var closed = 0.0;
    var below = 0.0;
    var bound = 1.0e30;
    for (var tap = 0u; tap < 6u; tap++) {
        let height = taps[tap] * reach;
        let limit = min(height, 1.001 * (bound + (height - below)));
        let distance = max(over_ground(p + vec3<f32>(0.0, height, 0.0), height, limit), 0.0);
        bound = distance;
        below = height;
        closed += (height - distance) / height;
    }
    return 1.0 - closed / 6.0;
}

@fragment
fn fs_ground_map(@builtin(position) fragment: vec4<f32>) -> @location(0) vec2<u32> {
    let texel = floor(fragment.xy);
    let step = 1.0 / frame.ground_map.z;
    let corner = frame.ground_map.xy;
    let p = vec3<f32>(corner.x + (texel.x + 0.5) * step, frame.ground.x, corner.y + (texel.y + 0.5) * step);
    return vec2<u32>(bitcast<u32>(ground_shadow(p)), bitcast<u32>(ground_open(p)));
}
