// Small balls and sticks, drawn by a compute pass, an invocation each: rasterisers shade blocks of pixels for each half of a quad, many
// times what such a thing covers. First all are laid down, which leaves the nearest depth of each pixel; then whatever has that depth
// claims the pixel by its number, of equals the first. The same rays and intersections as in the draws of quads find both.
#import "footprint.wgsl"

// Whatever covers no more pixels than this a side. Chosen: see render::gpu::passes::cull.
const SMALL_PX: f32 = 12.0;

// Outlines are the draws' of quads.
fn is_small(print: Footprint) -> bool {
    return all(print.high - print.low < vec2<f32>(SMALL_PX)) && !has_outlines();
}

// Where a walk over the pixels of something stands.
struct Walk {
    at: vec2<i32>,
    first: i32,
    last: vec2<i32>,
    // Of a strip that holds it: its normal, where the middle is along it, half the width.
    strip: vec4<f32>,
    // Bits of its nearest depth.
    nearest: u32,
    width: u32,
    pixels: u32,
}

fn walk(print: Footprint, strip: vec4<f32>, goes: bool) -> Walk {
    let at = cells(print);
    let size = target_size();
    let begins = goes && print.seen && all(at.zw >= at.xy);
    let nearest = bitcast<u32>(nearest_value(print));
    let first = vec2<i32>(at.x, select(at.w + 1, at.y, begins));
    var walk = Walk(first, at.x, at.zw, strip, nearest, size.x, size.x * size.y);
    seek(&walk);
    return walk;
}

fn is_over(walk: Walk) -> bool {
    return walk.at.y > walk.last.y;
}

fn pixel_of(walk: Walk) -> u32 {
    return PIXELS + u32(walk.at.y) * walk.width + u32(walk.at.x);
}

fn advance(walk: ptr<function, Walk>) {
    (*walk).at.x += 1;
    if (*walk).at.x > (*walk).last.x {
        (*walk).at = vec2<i32>((*walk).first, (*walk).at.y + 1);
    }
}

// On to the next pixel in the strip where nothing is nearer than all of it: much less than to intersect a ray.
fn seek(walk: ptr<function, Walk>) {
    while !is_over(*walk) {
        let across = dot((*walk).strip.xy, vec2<f32>((*walk).at)) - (*walk).strip.z;
        if abs(across) <= (*walk).strip.w && atomicLoad(&pyramid[pixel_of(*walk)]) <= (*walk).nearest {
            return;
        }
        advance(walk);
    }
}

fn ray_at(at: vec2<i32>) -> Ray {
    return pixel_ray(vec4<f32>(vec2<f32>(at) + 0.5, 0.0, 1.0), one_sample.offset);
}

// Lays a hit down (without a key) or claims its pixel; whether it was as near as any so far.
fn put(walk: ptr<function, Walk>, t: f32, key: u32) -> bool {
    let pixel = pixel_of(*walk);
    let bits = bitcast<u32>(depth_value(t));
    if !(t < NO_HIT) || bits < atomicLoad(&pyramid[pixel]) {
        return false;
    }
    if key == 0u {
        return atomicMax(&pyramid[pixel], bits) <= bits;
    }
    atomicMax(&pyramid[pixel + (*walk).pixels], key);
    return true;
}

fn put_sphere(ball: Sphere, print: Footprint, goes: bool, key: u32) -> bool {
    var walk = walk(print, vec4<f32>(0.0), goes);
    var is_nearest = false;
    while !is_over(walk) {
        is_nearest = put(&walk, sphere_t(ray_at(walk.at), ball, frame.depth.z), key) || is_nearest;
        advance(&walk);
        seek(&walk);
    }
    return is_nearest;
}

fn put_cylinder(stick: Cylinder, print: Footprint, goes: bool, key: u32) -> bool {
    var walk = walk(print, strip_of(stick), goes);
    var is_nearest = false;
    while !is_over(walk) {
        is_nearest = put(&walk, cylinder_t(ray_at(walk.at), stick, frame.depth.z), key) || is_nearest;
        advance(&walk);
        seek(&walk);
    }
    return is_nearest;
}
