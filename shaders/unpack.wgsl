// Reading the packed texel of a visible surface; gpu::gbuffer unpacks the same bits on the CPU.
#import "color.wgsl"

fn unpack_normal(bits: u32) -> vec3<f32> {
    let p = unpack2x16snorm(bits);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let signs = select(vec2<f32>(-1.0), vec2<f32>(1.0), p >= vec2<f32>(0.0));
    let xy = select(p, (1.0 - abs(p.yx)) * signs, z < 0.0);
    return normalize(vec3<f32>(xy, z));
}

// Linear light of the texel's colour.
fn unpack_color(color: u32) -> vec3<f32> {
    let r = linear_from_srgb(f32(color & 0x3ffu) / COLOR_STEPS);
    let g = linear_from_srgb(f32((color >> 10u) & 0x3ffu) / COLOR_STEPS);
    let b = linear_from_srgb(f32((color >> 20u) & 0x3ffu) / COLOR_STEPS);
    return vec3<f32>(r, g, b);
}
