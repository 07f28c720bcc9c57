// What was drawn so far, and whether it hides what lies behind: the depth buffer, and three levels over it, each texel the farthest of
// sixteen of the level below.

@group(3) @binding(0) var depth_texels: texture_depth_2d;
// The levels, one after the other, row by row. Depths are reversed: the farthest is the smallest.
@group(3) @binding(1) var<storage, read_write> pyramid: array<f32>;

fn level_size(level: u32) -> vec2<u32> {
    var size = textureDimensions(depth_texels);
    for (var i = 0u; i < level; i++) {
        size = (size + 3u) / 4u;
    }
    return size;
}

fn level_start(level: u32) -> u32 {
    var start = 0u;
    for (var i = 1u; i < level; i++) {
        let size = level_size(i);
        start += size.x * size.y;
    }
    return start;
}

// Whether something with this depth value or a smaller one is behind all that stands in these pixels, both corners included.
fn is_behind_all(low: vec2<u32>, high: vec2<u32>, depth: f32) -> bool {
    let span = max(high.x - low.x, high.y - low.y);
    if span < 4u {
        for (var y = low.y; y <= high.y; y++) {
            for (var x = low.x; x <= high.x; x++) {
                if textureLoad(depth_texels, vec2<u32>(x, y), 0) <= depth {
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
            if pyramid[start + y * width + x] <= depth {
                return false;
            }
        }
    }
    return true;
}
