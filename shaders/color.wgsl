// sRGB and linear light, IEC 61966-2-1: the twins of src/color.rs.

fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.04045 {
        return x / 12.92;
    }
    return pow((x + 0.055) / 1.055, 2.4);
}

fn srgb_from_linear(linear: f32) -> f32 {
    let x = clamp(linear, 0.0, 1.0);
    if x <= 0.0031308 {
        return 12.92 * x;
    }
    return 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

// Linear light of 8-bit sRGB, red in the lowest byte.
fn linear_from_srgb8(rgb: u32) -> vec3<f32> {
    let r = linear_from_srgb(f32(rgb & 255u) / 255.0);
    let g = linear_from_srgb(f32((rgb >> 8u) & 255u) / 255.0);
    let b = linear_from_srgb(f32((rgb >> 16u) & 255u) / 255.0);
    return vec3<f32>(r, g, b);
}

// The nearest of the 256 steps, exactly as 8-bit targets store them.
fn quantise(x: f32) -> f32 {
    return floor(clamp(x, 0.0, 1.0) * 255.0 + 0.5) / 255.0;
}

// Steps of a channel of the surface target: four times those of 8 bits, so that these are exact.
const COLOR_STEPS: f32 = 1020.0;
