// Whose a pixel is: what small.wgsl left, for the draws that shade it.

#import "common.wgsl"

// As in members.wgsl.
@group(2) @binding(1) var<storage, read> arguments: array<u32, 16>;
const FAR: u32 = 65535u;
// As in hidden.wgsl.
@group(3) @binding(1) var<storage, read> pixels: array<u32>;

const NOBODY: u32 = 0xffffffffu;

// A corner of two triangles over the pixels that are anyone's of the chunk.
fn small_corner(corner: u32) -> vec4<f32> {
    let low = FAR - vec2<u32>(arguments[12], arguments[13]);
    let high = vec2<u32>(arguments[14], arguments[15]);
    let is_high = vec2<bool>(corner == 1u || corner >= 4u, corner == 2u || corner == 3u || corner == 5u);
    let at = vec2<f32>(select(low, high, is_high)) / vec2<f32>(one_sample.size) * 2.0 - 1.0;
    return vec4<f32>(at.x, -at.y, 0.5, 1.0);
}

// The number in the chunk of what has the pixel; NOBODY if that is nothing, or of another chunk.
fn owner_of(fragment: vec4<f32>) -> u32 {
    let at = vec2<u32>(fragment.xy);
    let key = pixels[4u + pixels[0] * pixels[1] + at.y * pixels[0] + at.x];
    let number = (0xffffffffu - key) - arguments[5];
    return select(NOBODY, number, key != 0u && number < arguments[6]);
}
