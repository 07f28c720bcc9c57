// What was drawn so far, and whether it hides what lies behind: the depth buffer, what small.wgsl laid over it, and three levels over both,
// each texel the farthest of sixteen of the level below.

@group(3) @binding(0) var depth_texels: texture_depth_2d;
// Width and height of the target, two words of nothing; of each pixel the nearest depth of what is small, then its number, as
// small.wgsl has them; then the levels, one after the other, row by row: floats in their bits. Depths are reversed: the farthest is the
// smallest, and as they are not negative their bits are in the same order.
@group(3) @binding(1) var<storage, read_write> pyramid: array<atomic<u32>>;

// Where the pixels start.
const PIXELS: u32 = 4u;

fn target_size() -> vec2<u32> {
    return vec2<u32>(atomicLoad(&pyramid[0]), atomicLoad(&pyramid[1]));
}

fn level_size(level: u32) -> vec2<u32> {
    var size = target_size();
    for (var i = 0u; i < level; i++) {
        size = (size + 3u) / 4u;
    }
    return size;
}

fn level_start(level: u32) -> u32 {
    let pixels = target_size();
    var start = PIXELS + 2u * pixels.x * pixels.y;
    for (var i = 1u; i < level; i++) {
        let size = level_size(i);
        start += size.x * size.y;
    }
    return start;
}

// Of a pixel.
fn depth_at(at: vec2<u32>, width: u32) -> f32 {
    let small = bitcast<f32>(atomicLoad(&pyramid[PIXELS + at.y * width + at.x]));
    return max(textureLoad(depth_texels, at, 0), small);
}

// Whether something with this depth value or a smaller one is behind all that stands in these pixels, both corners included.
fn is_behind_all(low: vec2<u32>, high: vec2<u32>, depth: f32) -> bool {
    let span = max(high.x - low.x, high.y - low.y);
    if span < 4u {
        let width = target_size().x;
        for (var y = low.y; y <= high.y; y++) {
            for (var x = low.x; x <= high.x; x++) {
                if depth_at(vec2<u32>(x, y), width) <= depth {
                    return false;
                }
            }
        }
        return true;
    }
    // As fine as shows no more than five texels a side.
    let level = select(select(3u, 2u, span < 64u), 1u, span < 16u);
    if span >= 256u {
        return false;
    }
    let first = low >> vec2<u32>(2u * level);
    let last = high >> vec2<u32>(2u * level);
    let start = level_start(level);
    let width = level_size(level).x;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            if bitcast<f32>(atomicLoad(&pyramid[start + y * width + x])) <= depth {
                return false;
            }
        }
    }
    return true;
}
