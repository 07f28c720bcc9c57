// The scene's signed distance field over its hierarchy: the twins of src/render/field.rs and Hierarchy::visit. Boxes and
// primitives are texels in rows of 2048: two a box (lower corner, highest opacity; upper corner), and two a primitive in the hierarchy's
// order (centre, radius; unit axis, half length). A sphere is a cylinder of no length and no axis. A radius below 0 marks a
// round end a, a half length below 0 a round end b. Others, open sticks and all that is see-through too, have a radius of RARE times
// their kind, and in place of the axis the number of the first of four texels that hold the rest.
#import "common.wgsl"
#import "distance.wgsl"

struct FieldConstants {
    // Where each level of the hierarchy starts, four levels a row; the last entry is the end.
    levels: array<vec4<u32>, 5>,
    // x: number of levels, y: number of primitives.
    counts: vec4<u32>,
}

@group(1) @binding(0) var<uniform> field: FieldConstants;
@group(1) @binding(1) var boxes: texture_2d<f32>;
@group(1) @binding(2) var primitives: texture_2d<f32>;

const WIDTH: u32 = 4u;

fn texel_at(index: u32) -> vec2<u32> {
    return vec2<u32>(index & 2047u, index >> 11u);
}

fn level_start(level: u32) -> u32 {
    return field.levels[level >> 2u][level & 3u];
}

fn rare_of(first: vec4<f32>, second: vec4<f32>) -> Rare {
    let at = u32(second.x);
    return Rare(
        u32(first.w / RARE + 0.5),
        first.xyz,
        textureLoad(primitives, texel_at(at), 0),
        textureLoad(primitives, texel_at(at + 1u), 0),
        textureLoad(primitives, texel_at(at + 2u), 0),
        textureLoad(primitives, texel_at(at + 3u), 0),
    );
}

// Twin of sphere_distance and cylinder_distance, from both texels.
fn stick_or_ball_distance(first: vec4<f32>, second: vec4<f32>, p: vec3<f32>) -> f32 {
    let radius = abs(first.w);
    let from_center = p - first.xyz;
    let y = dot(from_center, second.xyz);
    let across = length(from_center - second.xyz * y);
    let round_a = first.w < 0.0;
    let round_b = second.w < 0.0;
    let is_round = select(round_a, round_b, y > 0.0);
    return stick_distance(across, y, abs(second.w), radius, is_round);
}

// Twin of dimmed_way: the place on the scale of light that a share of a shadow has.
fn dimmed_way(x: f32, opacity: f32) -> f32 {
    if opacity >= 255.0 || x >= 1.0 {
        return x;
    }
    let light = 1.0 - opacity / 255.0 * (1.0 - x * x * (3.0 - 2.0 * x));
    return 0.5 - sin(asin(clamp(1.0 - 2.0 * light, -1.0, 1.0)) / 3.0);
}

// Twin of dimmed_distance.
fn dimmed_distance(distance: f32, height: f32, opacity: f32) -> f32 {
    if opacity >= 255.0 {
        return distance;
    }
    return height - opacity / 255.0 * (height - max(distance, 0.0));
}

// Twin of nearest_on_way; a sphere has no axis, so that its centre counts.
fn nearest_on_way(center: vec3<f32>, axis: vec4<f32>, p: vec3<f32>, direction: vec3<f32>) -> f32 {
    let to_center = center - p;
    let along = dot(direction, to_center);
    let across = dot(axis.xyz, to_center);
    let cosine = dot(direction, axis.xyz);
    let sine_squared = 1.0 - cosine * cosine;
    let s = select(0.0, (cosine * along - across) / max(sine_squared, 1e-6), sine_squared > 1e-6);
    return along + cosine * clamp(s, -abs(axis.w), abs(axis.w));
}

// What is asked of the field: the distance at a point, or the least light on the way from it.
struct Query {
    p: vec3<f32>,
    // Unit direction of the way; zero asks for the distance.
    direction: vec3<f32>,
    // The way starts here; of a distance, how high the point is above the ground.
    start: f32,
    sharpness: f32,
}

fn is_way(query: Query) -> bool {
    return query.sharpness > 0.0;
}

// No primitive of a box answers with less than this. What is see-through never answers with much less: without that a ray through thousands
// of triangles would ask them all, and a device may stop a shader that takes so long.
fn box_bound(index: u32, query: Query) -> f32 {
    let first = textureLoad(boxes, texel_at(2u * index), 0);
    let low = first.xyz;
    let high = textureLoad(boxes, texel_at(2u * index + 1u), 0).xyz;
    if is_way(query) {
        let center = (low + high) * 0.5 - query.p;
        let radius = length(high - low) * 0.5;
        let t = dot(center, query.direction);
        let beside = length(center - query.direction * t) - radius;
        let farthest = t + radius;
        let least = select(0.0, dimmed_way(0.0, first.w), first.w < 255.0);
        return select(NO_HIT, max(query.sharpness * beside / farthest, least), farthest > 0.0);
    }
    // Twin of Aabb::distance. Inside a box the distance to what it holds may be negative: it is always entered.
    let distance = length(max(max(low - query.p, query.p - high), vec3<f32>(0.0)));
    return select(distance, select(-NO_HIT, dimmed_distance(0.0, query.start, first.w), first.w < 255.0), distance == 0.0);
}

// What is not below `best` may be anything above it.
fn answer(index: u32, query: Query, best: f32) -> f32 {
    let first = textureLoad(primitives, texel_at(2u * index), 0);
    let second = textureLoad(primitives, texel_at(2u * index + 1u), 0);
    if first.w >= RARE {
        return rare_answer(rare_of(first, second), query, best);
    }
    if is_way(query) {
        let t = max(nearest_on_way(first.xyz, second, query.p, query.direction), query.start);
        return light_at(stick_or_ball_distance(first, second, query.p + query.direction * t), t, query);
    }
    return stick_or_ball_distance(first, second, query.p);
}

// The light that is left where something passes the way at this distance.
fn light_at(distance: f32, t: f32, query: Query) -> f32 {
    return max(query.sharpness * distance / t, 0.0);
}

fn rare_answer(rare: Rare, query: Query, best: f32) -> f32 {
    // Twin of Field::ball.
    let radius = rare_radius(rare);
    let to = rare.center - query.p;
    let along = dot(to, query.direction);
    let beside = length(to - query.direction * along) - radius;
    if select(beside >= best, query.sharpness * beside >= best * max(along + radius, query.start), is_way(query)) {
        return best;
    }
    if !is_way(query) {
        return dimmed_distance(rare_distance(rare, query.p), query.start, rare.look.z);
    }
    if rare.kind >= STICK {
        let t = max(nearest_on_way(rare.center, rare.a, query.p, query.direction), query.start);
        return dimmed_way(light_at(rare_distance(rare, query.p + query.direction * t), t, query), rare.look.z);
    }
    let least = least_on_way(rare, query.p, query.direction, query.start);
    return dimmed_way(light_at(least.y, least.x, query), rare.look.z);
}

// The smallest answer below `limit`, else `limit`. Twin of Hierarchy::visit: nearest first.
fn visit(query: Query, limit: f32) -> f32 {
    var best = limit;
    if field.counts.y == 0u {
        return best;
    }
    let top = field.counts.x - 1u;
    // Every level leaves at most WIDTH - 1 nodes waiting; 16 levels hold 4^17 primitives.
    var node_at: array<u32, 64>;
    var level_at: array<u32, 64>;
    var bound_at: array<f32, 64>;
    node_at[0] = 0u;
    level_at[0] = top;
    bound_at[0] = box_bound(level_start(top), query);
    var waiting = 1u;
    while waiting > 0u {
        waiting -= 1u;
        let level = level_at[waiting];
        let node = node_at[waiting];
        if bound_at[waiting] >= best {
            continue;
        }
        if level == 0u {
            let last = min((node + 1u) * WIDTH, field.counts.y);
            for (var i = node * WIDTH; i < last; i++) {
                best = min(best, answer(i, query, best));
            }
            if is_way(query) && best <= 0.0 {
                return 0.0;
            }
            continue;
        }
        let start = level_start(level - 1u);
        let last = min(start + (node + 1u) * WIDTH, level_start(level));
        let base = waiting;
        for (var child = start + node * WIDTH; child < last; child++) {
            let bound = box_bound(child, query);
            if bound < best {
                var at = waiting;
                while at > base {
                    if bound_at[at - 1u] >= bound {
                        break;
                    }
                    node_at[at] = node_at[at - 1u];
                    level_at[at] = level_at[at - 1u];
                    bound_at[at] = bound_at[at - 1u];
                    at -= 1u;
                }
                node_at[at] = child - start;
                level_at[at] = level - 1u;
                bound_at[at] = bound;
                waiting += 1u;
            }
        }
    }
    return best;
}

// Twin of Field::over_ground.
fn over_ground(p: vec3<f32>, height: f32, limit: f32) -> f32 {
    return visit(Query(p, vec3<f32>(0.0), height, 0.0), limit);
}
