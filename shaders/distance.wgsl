// Distances of sticks, cones, tori and triangles, and where a way passes them closest: the twins of src/render/distance.rs. Comments
// stand there.
#import "common.wgsl"

const RARE: f32 = 1e30;

// Kind: 1 cone, 2 torus, 3 triangle, 4 stick that is open or see-through, 5 see-through ball. Cone: unit axis, half length; both
// radii. Torus: unit axis, ring's radius; tube's radius. Triangle: the corners from the centre. Stick: unit axis, half length; radius,
// Cylinder::caps. Ball: any unit vector, 0; radius.
struct Rare {
    kind: u32,
    center: vec3<f32>,
    a: vec4<f32>,
    b: vec4<f32>,
    c: vec4<f32>,
    // Lower and upper 16 bits of the id, opacity 0-255.
    look: vec4<f32>,
}

const STICK: u32 = 4u;
const BALL: u32 = 5u;

// Of a point in the half section of a stick.
fn stick_distance(across: f32, y: f32, h: f32, radius: f32, is_round: bool) -> f32 {
    let beyond = abs(y) - h;
    if is_round {
        let up = max(beyond, 0.0);
        return sqrt(across * across + up * up) - radius;
    }
    let out = across - radius;
    return min(max(out, beyond), 0.0) + length(max(vec2<f32>(out, beyond), vec2<f32>(0.0)));
}

fn cone_distance(q: vec2<f32>, h: f32, radii: vec2<f32>) -> f32 {
    let low = vec2<f32>(radii.x, -h);
    let side = vec2<f32>(radii.y - radii.x, 2.0 * h);
    let along = clamp(dot(q - low, side) / dot(side, side), 0.0, 1.0);
    let to_side = q - (low + side * along);
    let cap_radius = select(radii.y, radii.x, q.y < 0.0);
    let to_cap = vec2<f32>(q.x - min(q.x, cap_radius), abs(q.y) - h);
    let outside_of_side = dot(q - low, vec2<f32>(side.y, -side.x)) > 0.0;
    let distance = sqrt(min(dot(to_side, to_side), dot(to_cap, to_cap)));
    return select(-distance, distance, outside_of_side || to_cap.y > 0.0);
}

// What an edge changes: x the squared distance to the edges, y whether the point is over the face.
fn with_edge(found: vec2<f32>, q: vec3<f32>, n: vec3<f32>, start: vec3<f32>, end: vec3<f32>) -> vec2<f32> {
    let edge = end - start;
    let way = q - start;
    let nearest = way - edge * clamp(dot(way, edge) / max(dot(edge, edge), 1e-30), 0.0, 1.0);
    return vec2<f32>(min(found.x, dot(nearest, nearest)), select(0.0, found.y, dot(cross(n, edge), way) >= 0.0));
}

fn triangle_distance(q: vec3<f32>, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    let n = cross(b - a, c - a);
    var found = vec2<f32>(NO_HIT, 1.0);
    found = with_edge(found, q, n, a, b);
    found = with_edge(found, q, n, b, c);
    found = with_edge(found, q, n, c, a);
    return select(sqrt(found.x), abs(dot(n, q - a)) / length(n), found.y > 0.5);
}

fn rare_distance(rare: Rare, p: vec3<f32>) -> f32 {
    let q = p - rare.center;
    if rare.kind == BALL {
        return length(q) - rare.b.x;
    }
    if rare.kind == 3u {
        return triangle_distance(q, rare.a.xyz, rare.b.xyz, rare.c.xyz);
    }
    let y = dot(q, rare.a.xyz);
    let across = length(q - rare.a.xyz * y);
    if rare.kind == 2u {
        return length(vec2<f32>(across - rare.a.w, y)) - rare.b.x;
    }
    if rare.kind == STICK {
        let cap = u32(rare.b.y) >> select(0u, 2u, y > 0.0);
        return stick_distance(across, y, rare.a.w, rare.b.x, (cap & 3u) == 2u);
    }
    return cone_distance(vec2<f32>(across, y), rare.a.w, rare.b.xy);
}

fn rare_radius(rare: Rare) -> f32 {
    if rare.kind == 3u {
        return max(max(length(rare.a.xyz), length(rare.b.xyz)), length(rare.c.xyz));
    }
    return rare.a.w + select(rare.b.x, max(rare.b.x, rare.b.y), rare.kind == 1u);
}

const TORUS_STARTS: u32 = 8u;
const SEARCH_STEPS: u32 = 14u;
const GOLDEN: f32 = 0.618034;

// (t, distance).
fn least_on_way(rare: Rare, p: vec3<f32>, direction: vec3<f32>, start: f32) -> vec2<f32> {
    let radius = rare_radius(rare);
    let middle = dot(rare.center - p, direction);
    let low = max(middle - radius, start);
    let high = max(middle + radius, start);
    let parts = select(1u, TORUS_STARTS, rare.kind == 2u);
    var best = vec2<f32>(low, rare_distance(rare, p + direction * low));
    let part = (high - low) / f32(parts);
    for (var i = 0u; i < parts; i++) {
        var first = low + part * f32(i);
        var last = low + part * f32(i + 1u);
        var a = vec2<f32>(last - (last - first) * GOLDEN, 0.0);
        var b = vec2<f32>(first + (last - first) * GOLDEN, 0.0);
        a.y = rare_distance(rare, p + direction * a.x);
        b.y = rare_distance(rare, p + direction * b.x);
        for (var step = 0u; step < SEARCH_STEPS; step++) {
            if a.y * b.x < b.y * a.x {
                last = b.x;
                b = a;
                a.x = last - (last - first) * GOLDEN;
                a.y = rare_distance(rare, p + direction * a.x);
            } else {
                first = a.x;
                a = b;
                b.x = first + (last - first) * GOLDEN;
                b.y = rare_distance(rare, p + direction * b.x);
            }
        }
        let found = select(b, a, a.y * b.x < b.y * a.x);
        if found.y * best.x < best.y * found.x {
            best = found;
        }
    }
    return best;
}
