// Which balls and sticks a sample draws, as lists for indirect draws: first those that were seen last time, then, of the others, those
// that the first do not hide. Lists keep the order of the instances, so that the same is drawn every time.
//
// A cluster is 64 instances one after the other, neighbours in space: its box is asked first.
#import "outline.wgsl"
#import "hidden.wgsl"

const MEMBERS: u32 = 64u;
// Twin of render::gpu::clusters::OUTLINED.
const OUTLINED: f32 = 1.4;

// Instances, three (spheres) or six (cylinders) of these each.
@group(2) @binding(0) var<storage, read> instances: array<vec2<u32>>;
// Two for each cluster, in block space: the middle of its box, and the number of members; half the size of the box.
@group(2) @binding(1) var<storage, read> boxes: array<vec4<f32>>;
// Of each cluster, a bit for each member: seen at the last look (x, y), to be drawn now (z, w).
@group(2) @binding(2) var<storage, read_write> masks: array<vec4<u32>>;
// Of each cluster, how many members are to be drawn; after `scan`, where they start in the list.
@group(2) @binding(3) var<storage, read_write> starts: array<u32>;
@group(2) @binding(4) var<storage, read_write> list: array<u32>;
// Of an indirect draw.
@group(2) @binding(5) var<storage, read_write> arguments: array<u32, 4>;

fn count_of(bits: vec2<u32>) -> u32 {
    return countOneBits(bits.x) + countOneBits(bits.y);
}

// To be drawn is what was seen.
@compute @workgroup_size(64)
fn recall(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x < arrayLength(&masks) {
        let seen = masks[at.x].xy;
        masks[at.x] = vec4<u32>(seen, seen);
        starts[at.x] = count_of(seen);
    }
}

// Pixels of the target that something may cover (all of it if that is unknown), and its nearest depth.
struct Footprint {
    low: vec2<f32>,
    high: vec2<f32>,
    nearest: f32,
}

// Of an interval of the picture plane: see quad_corner.
fn footprint(low: vec2<f32>, high: vec2<f32>, nearest: f32) -> Footprint {
    let grid = frame.grid;
    let shift = grid.yz + 0.5 - one_sample.offset - vec2<f32>(one_sample.origin);
    let slack = 2.0 * SNAP_SLACK_PX;
    let first = vec2<f32>(low.x, -high.y) / grid.x + shift - slack;
    let last = vec2<f32>(high.x, -low.y) / grid.x + shift + slack;
    return Footprint(first, last, nearest);
}

// Whether any pixel's centre lies there and shows nothing nearer.
fn is_seen(print: Footprint) -> bool {
    let size = vec2<f32>(one_sample.size);
    let low = max(ceil(print.low - 0.5), vec2<f32>(0.0));
    let high = min(floor(print.high - 0.5), size - 1.0);
    if any(high < low) {
        return false;
    }
    // The wide, and what is no number.
    if !all(print.high - print.low < vec2<f32>(256.0)) {
        return true;
    }
    // A depth that rounding makes no nearer.
    let nearest = max(print.nearest - 1e-5 * abs(print.nearest) - 1e-4, frame.depth.z);
    return !is_behind_all(vec2<u32>(low), vec2<u32>(high), depth_value(nearest));
}

fn is_cluster_seen(cluster: u32) -> bool {
    let center = view_point(boxes[2u * cluster].xyz);
    var half = boxes[2u * cluster + 1u].xyz;
    half = abs(placement.x_axis.xyz) * half.x + abs(placement.y_axis.xyz) * half.y + abs(placement.z_axis.xyz) * half.z;
    half = half * select(1.0, OUTLINED, has_outlines()) + 1e-5 * abs(center);
    let near = frame.depth.z;
    let depths = -center.z + vec2<f32>(-half.z, half.z);
    if depths.y < near {
        return false;
    }
    let low = center.xy - half.xy;
    let high = center.xy + half.xy;
    if is_orthographic() {
        return is_seen(footprint(low, high, depths.x));
    }
    if depths.x < 1.01 * near {
        return true;
    }
    let slopes = min(low / depths.x, low / depths.y);
    return is_seen(footprint(slopes, max(high / depths.x, high / depths.y), depths.x));
}

fn is_sphere_seen(number: u32) -> bool {
    let first = 3u * number;
    let last = bitcast<vec2<f32>>(instances[first + 1u]);
    let center = view_point(vec3<f32>(bitcast<vec2<f32>>(instances[first]), last.x));
    let reach = last.y + outline_width(center, last.y);
    let rect = sphere_rect(center, reach, frame.depth.z);
    return rect.seen && is_seen(footprint(rect.center - rect.half, rect.center + rect.half, -center.z - reach));
}

// By balls about its two ends, between which it lies.
fn is_cylinder_seen(number: u32) -> bool {
    let first = 6u * number;
    let a_end = bitcast<vec2<f32>>(instances[first + 1u]);
    let a_block = vec3<f32>(bitcast<vec2<f32>>(instances[first]), a_end.x);
    let b_z = bitcast<f32>(instances[first + 3u].x);
    let b_block = vec3<f32>(bitcast<vec2<f32>>(instances[first + 2u]), b_z);
    let a = view_point(a_block);
    let b = view_point(b_block);
    // Round ends of a line with an outline begin farther out by the line's width.
    let width = outline_width((a + b) * 0.5, a_end.y);
    let reach = a_end.y + 2.0 * width;
    let near = frame.depth.z;
    let rect_a = sphere_rect(a, reach, near);
    let rect_b = sphere_rect(b, reach, near);
    if !rect_a.seen || !rect_b.seen || min(-a.z, -b.z) - reach < near {
        // It may cross the near plane, where its ends say too little.
        return rect_a.seen || rect_b.seen;
    }
    let low = min(rect_a.center - rect_a.half, rect_b.center - rect_b.half);
    let high = max(rect_a.center + rect_a.half, rect_b.center + rect_b.half);
    return is_seen(footprint(low, high, min(-a.z, -b.z) - reach));
}

var<workgroup> is_any: u32;
var<workgroup> found: array<atomic<u32>, 2>;

// To be drawn is what is seen now and was not before.
fn find(cluster: u32, lane: u32, is_cylinder: bool) {
    if lane == 0u {
        is_any = select(0u, 1u, is_cluster_seen(cluster));
        atomicStore(&found[0], 0u);
        atomicStore(&found[1], 0u);
    }
    workgroupBarrier();
    let members = u32(boxes[2u * cluster].w);
    if is_any != 0u && lane < members {
        let number = cluster * MEMBERS + lane;
        var seen = false;
        if is_cylinder {
            seen = is_cylinder_seen(number);
        } else {
            seen = is_sphere_seen(number);
        }
        if seen {
            atomicOr(&found[lane / 32u], 1u << (lane % 32u));
        }
    }
    workgroupBarrier();
    if lane == 0u {
        let now = vec2<u32>(atomicLoad(&found[0]), atomicLoad(&found[1]));
        let fresh = now & ~masks[cluster].xy;
        masks[cluster] = vec4<u32>(now, fresh);
        starts[cluster] = count_of(fresh);
    }
}

@compute @workgroup_size(64)
fn find_spheres(@builtin(workgroup_id) cluster: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    find(cluster.x, lane, false);
}

@compute @workgroup_size(64)
fn find_cylinders(@builtin(workgroup_id) cluster: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    find(cluster.x, lane, true);
}

const SCANNERS: u32 = 256u;
var<workgroup> sums: array<u32, 256>;

// From numbers of members to where they start, and to the arguments of the draw: one workgroup, each invocation a run of clusters.
@compute @workgroup_size(256)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let count = arrayLength(&masks);
    let run = (count + SCANNERS - 1u) / SCANNERS;
    let first = min(lane * run, count);
    let end = min(first + run, count);
    var sum = 0u;
    for (var i = first; i < end; i++) {
        sum += starts[i];
    }
    sums[lane] = sum;
    workgroupBarrier();
    for (var step = 1u; step < SCANNERS; step *= 2u) {
        var before = 0u;
        if lane >= step {
            before = sums[lane - step];
        }
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }
    var start = sums[lane] - sum;
    for (var i = first; i < end; i++) {
        let members = starts[i];
        starts[i] = start;
        start += members;
    }
    if lane == SCANNERS - 1u {
        arguments = array<u32, 4>(4u, sums[lane], 0u, 0u);
    }
}

@compute @workgroup_size(64)
fn scatter(@builtin(workgroup_id) cluster: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let drawn = masks[cluster.x].zw;
    let word = select(drawn.x, drawn.y, lane >= 32u);
    let bit = 1u << (lane % 32u);
    if (word & bit) != 0u {
        let before = select(0u, countOneBits(drawn.x), lane >= 32u) + countOneBits(word & (bit - 1u));
        list[starts[cluster.x] + before] = cluster.x * MEMBERS + lane;
    }
}
