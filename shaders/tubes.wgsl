// Whether something hides the light of a direction from a point: the tubes of src/render/tubes.rs, and in them, one point at a
// time, the functions of src/render/cpu/behind.rs. (Balls and sticks the CPU asks by other means, src/render/cpu/casters.rs.)
#import "distance.wgsl"
#import "opacity.wgsl"
#import "cone_hit.wgsl"
#import "torus_hit.wgsl"
#import "triangle_hit.wgsl"

// Of the sky and of the key light: first, for all directions one after the other, where the list of each tube starts and
// the last one ends; then the lists.
@group(2) @binding(0) var sky_words: texture_2d<u32>;
// Row 0: how many directions a sample asks, in how many turns, log2 of the words in a row. Then a row a direction: right, and
// the place of the grid's corner along it; the same of up; the direction, tubes per angstrom; tubes along right and up, and
// the number of its first word, lower and upper 16 bits.
@group(2) @binding(1) var sky_directions: texture_2d<f32>;
@group(2) @binding(2) var key_words: texture_2d<u32>;
@group(2) @binding(3) var key_directions: texture_2d<f32>;
// The primitives, packed as those of field.wgsl, which are the same.
@group(2) @binding(4) var casters: texture_2d<f32>;

fn caster_texel(index: u32) -> vec4<f32> {
    return textureLoad(casters, vec2<u32>(index & 2047u, index >> 11u), 0);
}

fn direction_texel(is_key: bool, column: i32, row: i32) -> vec4<f32> {
    if is_key {
        return textureLoad(key_directions, vec2<i32>(column, row), 0);
    }
    return textureLoad(sky_directions, vec2<i32>(column, row), 0);
}

fn word(is_key: bool, row_bits: u32, index: u32) -> u32 {
    let at = vec2<u32>(index & ((1u << row_bits) - 1u), index >> row_bits);
    if is_key {
        return textureLoad(key_words, at, 0).x;
    }
    return textureLoad(sky_words, at, 0).x;
}

// Twin of behind_sphere; `to` leads from the point to the centre.
fn is_behind_sphere(to: vec3<f32>, radius: f32, d: vec3<f32>) -> bool {
    let along = dot3(to, d);
    let away = dot3(to, to);
    let radius2 = radius * radius;
    return away < radius2 || (along > 0.0 && away - along * along < radius2);
}

// Twin of behind_cylinder; `p` is the point from the cylinder's centre.
fn is_behind_cylinder(p: vec3<f32>, a: vec3<f32>, h: f32, radius: f32, d: vec3<f32>) -> bool {
    let cosine = dot3(a, d);
    let n = cross(a, d);
    let sine2 = dot3(n, n);
    let parallel = sine2 < 1e-6;
    let flat_on = abs(cosine) < 1e-6;
    let over_sine2 = select(1.0 / sine2, 0.0, parallel);
    let over_cosine = select(1.0 / cosine, 0.0, flat_on);
    let across = dot3(p, n);
    let up = dot3(p, a);
    let ahead = dot3(p, d);
    let away = dot3(p, p) - ahead * ahead;
    let inside = select(radius * radius * sine2 - across * across, radius * radius - away, parallel);
    let middle = (up * cosine - ahead) * over_sine2;
    let half = select(sqrt(max(inside, 0.0)) * over_sine2, NO_HIT, parallel);
    let to_a = (-h - up) * over_cosine;
    let to_b = (h - up) * over_cosine;
    let level = select(-NO_HIT, NO_HIT, abs(up) < h);
    let near = select(min(to_a, to_b), -level, flat_on);
    let far = select(max(to_a, to_b), level, flat_on);
    let entry = max(middle - half, near);
    let exit = min(middle + half, far);
    return inside > 0.0 && entry < exit && exit > 0.0;
}

// How far a rare primitive reaches along the direction from its centre. Twin of Bound::top.
fn rare_top(rare: Rare, d: vec3<f32>) -> f32 {
    if rare.kind == 3u {
        return max(max(dot3(rare.a.xyz, d), dot3(rare.b.xyz, d)), dot3(rare.c.xyz, d));
    }
    let cosine = dot3(rare.a.xyz, d);
    if rare.kind == 2u {
        return rare.a.w * sqrt(max(1.0 - cosine * cosine, 0.0)) + rare.b.x;
    }
    return rare.a.w * abs(cosine) + select(rare.b.x, max(rare.b.x, rare.b.y), rare.kind == 1u);
}

// As `behind` in src/render/cpu/behind.rs; the point is the ray's origin, from the primitive's centre.
fn is_behind_rare(rare: Rare, p: vec3<f32>, d: vec3<f32>) -> bool {
    let ray = Ray(p, d);
    let center = vec3<f32>(0.0);
    if rare.kind == 3u {
        var triangle = Triangle(rare.center, rare.a.xyz, rare.b.xyz, rare.c.xyz, center);
        triangle.slack = slack_of(triangle);
        triangle.center = center;
        return triangle_t(ray, triangle, 0.0) < NO_HIT;
    }
    if rare.kind == BALL {
        return is_behind_sphere(-p, rare.b.x, d);
    }
    let rows = rotation_to_y(rare.a.xyz);
    if rare.kind == 2u {
        return torus_t(ray, Torus(center, rows[0], rows[1], rows[2], rare.a.w, rare.b.x), 0.0) < NO_HIT;
    }
    if rare.kind == STICK {
        let stick = Cylinder(center, rows[0], rows[1], rows[2], rare.a.w, rare.b.x, u32(rare.b.y));
        return cylinder_t(ray, stick, 0.0) < NO_HIT;
    }
    let slope = (rare.b.y - rare.b.x) / (2.0 * rare.a.w);
    let cone = Cone(center, rows[0], rows[1], rows[2], rare.a.w, (rare.b.x + rare.b.y) * 0.5, slope);
    return cone_t(ray, cone, 0.0) < NO_HIT;
}

const PAST: u32 = 0u;
const HIDES: u32 = 1u;
// Neither this primitive nor those after it reach up to the point.
const BELOW: u32 = 2u;

// What a primitive is to a point (from the scene's centre) and a direction; `low` is the point's place along it.
fn ask_caster(index: u32, p: vec3<f32>, d: vec3<f32>, low: f32) -> u32 {
    let first = caster_texel(2u * index);
    let second = caster_texel(2u * index + 1u);
    let c = first.xyz - scene_center();
    if first.w >= RARE {
        let at = u32(second.x);
        let kind = u32(first.w / RARE + 0.5);
        let rare = Rare(kind, first.xyz, caster_texel(at), caster_texel(at + 1u), caster_texel(at + 2u), caster_texel(at + 3u));
        if dot3(c, d) + rare_top(rare, d) <= low {
            return BELOW;
        }
        if !hides_in_sample(u32(rare.look.x) + (u32(rare.look.y) << 16u), u32(rare.look.z)) {
            return PAST;
        }
        return select(PAST, HIDES, is_behind_rare(rare, p - c, d));
    }
    let radius = abs(first.w);
    let h = abs(second.w);
    if dot3(c, d) + h * abs(dot3(second.xyz, d)) + radius <= low {
        return BELOW;
    }
    if h == 0.0 {
        return select(PAST, HIDES, is_behind_sphere(c - p, radius, d));
    }
    let end = second.xyz * h;
    if is_behind_cylinder(p - c, second.xyz, h, radius, d)
        || (first.w < 0.0 && is_behind_sphere(c - end - p, radius, d))
        || (second.w < 0.0 && is_behind_sphere(c + end - p, radius, d)) {
        return HIDES;
    }
    return PAST;
}

// Tubes are about this point.
fn scene_center() -> vec3<f32> {
    return (frame.bounds_min.xyz + frame.bounds_max.xyz) * 0.5;
}

// Whether a point (from the scene's centre) sees the light of the direction in this row.
fn is_free(is_key: bool, row_bits: u32, row: i32, p: vec3<f32>) -> bool {
    let right = direction_texel(is_key, 0, row);
    let up = direction_texel(is_key, 1, row);
    let toward = direction_texel(is_key, 2, row);
    let grid = direction_texel(is_key, 3, row);
    let place = (vec2<f32>(dot3(p, right.xyz), dot3(p, up.xyz)) - vec2<f32>(right.w, up.w)) * toward.w;
    let tube = vec2<u32>(clamp(floor(place), vec2<f32>(0.0), grid.xy - 1.0));
    let at = u32(grid.z) + (u32(grid.w) << 16u) + tube.y * u32(grid.x) + tube.x;
    let low = dot3(p, toward.xyz);
    let end = word(is_key, row_bits, at + 1u);
    for (var i = word(is_key, row_bits, at); i < end; i++) {
        let answer = ask_caster(word(is_key, row_bits, i), p, toward.xyz, low);
        if answer != PAST {
            return answer == BELOW;
        }
    }
    return true;
}
