// Which balls and sticks a sample draws. First those that were seen last time, then, of the others, those that the first do not hide: the
// small ones here (small.wgsl), the others as lists for indirect draws. Lists keep the order of the instances, so that the same is drawn
// every time.
//
// The box of a cluster is asked first, and the clusters that matter are gathered, so that workgroups take one after the other.
#import "members.wgsl"

// Seen so far is what was found last time.
@compute @workgroup_size(64)
fn recall(@builtin(global_invocation_id) at: vec3<u32>) {
    let cluster = at.x;
    if cluster >= arrayLength(&starts) {
        return;
    }
    let found = bits_of(cluster, FOUND);
    set_bits(cluster, SEEN, found);
    set_bits(cluster, DRAWN, vec2<u32>(0u));
    set_bits(cluster, FOUND, vec2<u32>(0u));
    if any(found != vec2<u32>(0u)) {
        visit_later(cluster);
    }
}

// Of hidden clusters nothing is seen.
@compute @workgroup_size(64)
fn ask(@builtin(global_invocation_id) at: vec3<u32>) {
    let cluster = at.x;
    if cluster >= arrayLength(&starts) {
        return;
    }
    set_bits(cluster, DRAWN, vec2<u32>(0u));
    if is_cluster_seen(cluster) {
        visit_later(cluster);
    } else {
        set_bits(cluster, SEEN, vec2<u32>(0u));
    }
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

@compute @workgroup_size(64)
fn lay_spheres(
    @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    for (var i = group.x; i < atomicLoad(&arguments[4]); i += groups.x) {
        let print = sphere(member_of(list[i], lane, LAY), LAY);
    }
}

@compute @workgroup_size(64)
fn find_spheres(
    @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    for (var i = group.x; i < atomicLoad(&arguments[4]); i += groups.x) {
        let member = member_of(list[i], lane, FIND);
        find_large(member, sphere(member, FIND));
    }
}

@compute @workgroup_size(64)
fn claim_spheres(
    @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    for (var i = group.x; i < atomicLoad(&arguments[4]); i += groups.x) {
        let print = sphere(member_of(list[i], lane, CLAIM), CLAIM);
    }
}

@compute @workgroup_size(64)
fn lay_cylinders(
    @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    for (var i = group.x; i < atomicLoad(&arguments[4]); i += groups.x) {
        let print = cylinder(member_of(list[i], lane, LAY), LAY);
    }
}

@compute @workgroup_size(64)
fn find_cylinders(
    @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    for (var i = group.x; i < atomicLoad(&arguments[4]); i += groups.x) {
        let member = member_of(list[i], lane, FIND);
        find_large(member, cylinder(member, FIND));
    }
}

@compute @workgroup_size(64)
fn claim_cylinders(
    @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    for (var i = group.x; i < atomicLoad(&arguments[4]); i += groups.x) {
        let print = cylinder(member_of(list[i], lane, CLAIM), CLAIM);
    }
}

const SCANNERS: u32 = 256u;
var<workgroup> sums: array<u32, 256>;

// From members to be drawn to where they start in the list, and to the arguments of the draw: one workgroup, each invocation a run of
// clusters.
@compute @workgroup_size(256)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let count = arrayLength(&starts);
    let run = (count + SCANNERS - 1u) / SCANNERS;
    let first = min(lane * run, count);
    let end = min(first + run, count);
    var sum = 0u;
    for (var i = first; i < end; i++) {
        sum += count_of(bits_of(i, DRAWN));
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
        starts[i] = start;
        start += count_of(bits_of(i, DRAWN));
    }
    if lane == SCANNERS - 1u {
        atomicStore(&arguments[0], 4u);
        atomicStore(&arguments[1], sums[lane]);
        atomicStore(&arguments[2], 0u);
        atomicStore(&arguments[3], 0u);
    }
}

@compute @workgroup_size(64)
fn scatter(@builtin(global_invocation_id) at: vec3<u32>) {
    let cluster = at.x;
    if cluster >= arrayLength(&starts) {
        return;
    }
    let drawn = bits_of(cluster, DRAWN);
    let start = starts[cluster];
    for (var i = 0u; i < count_of(drawn); i++) {
        list[start + i] = cluster * MEMBERS + bit_after(drawn, i);
    }
}
