// The levels over the depth buffer, one dispatch each.
#import "hidden.wgsl"

@compute @workgroup_size(8, 8)
fn level_1(@builtin(global_invocation_id) at: vec3<u32>) {
    let size = level_size(1u);
    if at.x >= size.x || at.y >= size.y {
        return;
    }
    let below = target_size();
    let first = at.xy * 4u;
    let end = min(first + 4u, below);
    var farthest = 1.0;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            farthest = min(farthest, depth_at(vec2<u32>(x, y), below.x));
        }
    }
    atomicStore(&pyramid[level_start(1u) + at.y * size.x + at.x], bitcast<u32>(farthest));
}

fn reduce(level: u32, at: vec2<u32>) {
    let size = level_size(level);
    if at.x >= size.x || at.y >= size.y {
        return;
    }
    let below = level_size(level - 1u);
    let start = level_start(level - 1u);
    let first = at * 4u;
    let end = min(first + 4u, below);
    var farthest = 1.0;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            farthest = min(farthest, bitcast<f32>(atomicLoad(&pyramid[start + y * below.x + x])));
        }
    }
    atomicStore(&pyramid[level_start(level) + at.y * size.x + at.x], bitcast<u32>(farthest));
}

@compute @workgroup_size(8, 8)
fn level_2(@builtin(global_invocation_id) at: vec3<u32>) {
    reduce(2u, at.xy);
}

@compute @workgroup_size(8, 8)
fn level_3(@builtin(global_invocation_id) at: vec3<u32>) {
    reduce(3u, at.xy);
}
