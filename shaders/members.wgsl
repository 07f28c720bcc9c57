// The balls and sticks of a chunk, in clusters of 64 that are neighbours in space, and what the steps of cull.wgsl do with each.
#import "small.wgsl"

const MEMBERS: u32 = 64u;
// Twin of render::gpu::clusters::OUTLINED.
const OUTLINED: f32 = 1.4;

// Instances, three (spheres) or six (cylinders) of these each.
@group(2) @binding(0) var<storage, read> instances: array<vec2<u32>>;
// Two for each cluster, in block space: the middle of its box, and the number of members; half the size of the box.
@group(2) @binding(1) var<storage, read> boxes: array<vec4<f32>>;
// Of each cluster, a bit for each member: seen last time or so far (two words), to be drawn now (two), found to be seen (two).
@group(2) @binding(2) var<storage, read_write> masks: array<atomic<u32>>;
// Of each cluster, where its members start in the list.
@group(2) @binding(3) var<storage, read_write> starts: array<u32>;
// Clusters to visit, then members to draw.
@group(2) @binding(4) var<storage, read_write> list: array<u32>;
// Of an indirect draw of the list (four words); how many clusters there are to visit, the number of the first instance among all, how many
// there are, nothing; of the draw that shades what is small (four words), and the pixels that holds: how far the first is from FAR, and
// the one after the last.
@group(2) @binding(5) var<storage, read_write> arguments: array<atomic<u32>, 16>;
// Twin of that in owner.wgsl.
const FAR: u32 = 65535u;

const WORDS: u32 = 6u;
const SEEN: u32 = 0u;
const DRAWN: u32 = 2u;
const FOUND: u32 = 4u;

fn bits_of(cluster: u32, which: u32) -> vec2<u32> {
    let at = WORDS * cluster + which;
    return vec2<u32>(atomicLoad(&masks[at]), atomicLoad(&masks[at + 1u]));
}

fn set_bits(cluster: u32, which: u32, bits: vec2<u32>) {
    let at = WORDS * cluster + which;
    atomicStore(&masks[at], bits.x);
    atomicStore(&masks[at + 1u], bits.y);
}

fn add_bit(cluster: u32, which: u32, member: u32) {
    atomicOr(&masks[WORDS * cluster + which + member / 32u], 1u << (member % 32u));
}

fn count_of(bits: vec2<u32>) -> u32 {
    return countOneBits(bits.x) + countOneBits(bits.y);
}

// The place of the bit that has `before` set bits below it.
fn bit_after(bits: vec2<u32>, before: u32) -> u32 {
    let low = countOneBits(bits.x);
    var rest = select(before, before - low, before >= low);
    var word = select(bits.x, bits.y, before >= low);
    var at = select(0u, 32u, before >= low);
    for (var half = 16u; half > 0u; half /= 2u) {
        let below = countOneBits(word & ((1u << half) - 1u));
        let is_above = rest >= below;
        rest -= select(0u, below, is_above);
        at += select(0u, half, is_above);
        word = select(word, word >> half, is_above);
    }
    return at;
}

fn visit_later(cluster: u32) {
    list[atomicAdd(&arguments[4], 1u)] = cluster;
}

// What is done with the members of a cluster: those seen last time are laid down, of the others what the first do not hide, and
// what is nearest claims its pixels.
const LAY: u32 = 0u;
const FIND: u32 = 1u;
const CLAIM: u32 = 2u;

struct Member {
    cluster: u32,
    place: u32,
    number: u32,
    exists: bool,
    // Whether it was laid down before.
    was_seen: bool,
}

// The member that an invocation takes: to find, any; else those that are seen, without gaps.
fn member_of(cluster: u32, lane: u32, task: u32) -> Member {
    let seen = bits_of(cluster, SEEN);
    if task == FIND {
        let word = select(seen.x, seen.y, lane >= 32u);
        let exists = lane < u32(boxes[2u * cluster].w);
        return Member(cluster, lane, cluster * MEMBERS + lane, exists, ((word >> (lane % 32u)) & 1u) != 0u);
    }
    let exists = lane < count_of(seen);
    let place = select(0u, bit_after(seen, lane), exists);
    return Member(cluster, place, cluster * MEMBERS + place, exists, true);
}

// Numbers from high to low, so that the first of equals has the highest; never 0.
fn key_of(member: Member, task: u32) -> u32 {
    return select(0u, 0xffffffffu - (atomicLoad(&arguments[5]) + member.number), task == CLAIM);
}

fn goes(member: Member, task: u32, id: u32, color: u32) -> bool {
    return member.exists && !(task == FIND && member.was_seen) && is_drawn_in_sample(placed_id(id), color);
}

fn grow(word: u32, value: u32) {
    // Few grow it.
    if atomicLoad(&arguments[word]) < value {
        atomicMax(&arguments[word], value);
    }
}

// Has the pixels of something small shaded.
fn cover(print: Footprint) {
    let at = vec4<u32>(cells(print));
    grow(9u, 1u);
    grow(12u, FAR - at.x);
    grow(13u, FAR - at.y);
    grow(14u, at.z + 1u);
    grow(15u, at.w + 1u);
}

// What a walk has shown of something small; what is not small is drawn if it was seen.
fn note(member: Member, task: u32, print: Footprint, is_nearest: bool) -> Footprint {
    if member.exists && is_small(print) && is_nearest && task != LAY {
        add_bit(member.cluster, select(SEEN, FOUND, task == CLAIM), member.place);
        if task == CLAIM {
            cover(print);
        }
    }
    if member.exists && !is_small(print) && task == LAY {
        add_bit(member.cluster, DRAWN, member.place);
    }
    return print;
}

// Finds what is not small.
fn find_large(member: Member, print: Footprint) {
    if member.exists && !is_small(print) && is_seen(print) {
        add_bit(member.cluster, FOUND, member.place);
        if !member.was_seen {
            add_bit(member.cluster, DRAWN, member.place);
        }
    }
}

fn sphere(member: Member, task: u32) -> Footprint {
    let number = member.number;
    let first = 3u * number;
    let last = bitcast<vec2<f32>>(instances[first + 1u]);
    let look = instances[first + 2u];
    let ball = Sphere(view_point(vec3<f32>(bitcast<vec2<f32>>(instances[first]), last.x)), last.y);
    let print = sphere_footprint(ball);
    let walks = goes(member, task, look.y, look.x) && is_small(print);
    return note(member, task, print, put_sphere(ball, print, walks, key_of(member, task)));
}

fn cylinder(member: Member, task: u32) -> Footprint {
    let number = member.number;
    let first = 6u * number;
    let a_radius = vec4<f32>(bitcast<vec2<f32>>(instances[first]), bitcast<vec2<f32>>(instances[first + 1u]));
    let z_id = instances[first + 3u];
    let b = vec3<f32>(bitcast<vec2<f32>>(instances[first + 2u]), bitcast<f32>(z_id.x));
    let stick = placed_cylinder(a_radius, b, instances[first + 5u].x);
    let print = cylinder_footprint(stick);
    let walks = goes(member, task, z_id.y, instances[first + 4u].x) && is_small(print);
    return note(member, task, print, put_cylinder(stick, print, walks, key_of(member, task)));
}
