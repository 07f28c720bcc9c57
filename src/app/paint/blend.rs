//! Colours as the window's pixels have them.

use egui::Color32;

/// Premultiplied colour as `0xAARRGGBB`.
#[inline(always)]
pub(super) fn packed(color: Color32) -> u32 {
    let [r, g, b, a] = color.to_array().map(u32::from);
    a << 24 | r << 16 | g << 8 | b
}

/// An opaque colour as a pixel.
pub(in crate::app) fn pixel_of(color: Color32) -> u32 {
    packed(color) & 0x00FF_FFFF
}

/// All four bytes times `factor / 255`, rounded.
#[inline(always)]
pub(super) fn scaled(color: u32, factor: u32) -> u32 {
    // Two bytes at a time; x/255 = (x + 128 + (x + 128)/256)/256 for products of bytes.
    let half = |pair: u32| {
        let product = pair * factor + 0x0080_0080;
        (product + ((product >> 8) & 0x00FF_00FF)) >> 8 & 0x00FF_00FF
    };
    half(color & 0x00FF_00FF) | half(color >> 8 & 0x00FF_00FF) << 8
}

/// Each byte times the other's.
#[inline(always)]
pub(super) fn modulated(a: u32, b: u32) -> u32 {
    if a == u32::MAX {
        return b;
    }
    if b == u32::MAX {
        return a;
    }
    let byte = |shift: u32| {
        let product = (a >> shift & 0xFF) * (b >> shift & 0xFF) + 128;
        (product + (product >> 8)) >> 8 << shift
    };
    byte(0) | byte(8) | byte(16) | byte(24)
}

/// A premultiplied colour over a pixel. Bytes that would pass 255 stay there: egui's additive colours have less alpha than colour.
#[inline(always)]
pub(super) fn over(color: u32, pixel: u32) -> u32 {
    match color >> 24 {
        255 => color & 0x00FF_FFFF,
        alpha => {
            let below = scaled(pixel & 0x00FF_FFFF, 255 - alpha);
            let byte = |shift: u32| ((color >> shift & 0xFF) + (below >> shift & 0xFF)).min(255) << shift;
            byte(0) | byte(8) | byte(16)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_scaled_and_blended_to_the_nearest() {
        for value in [0u32, 1, 77, 128, 200, 255] {
            for factor in [0u32, 1, 100, 128, 254, 255] {
                let exact = (f64::from(value * factor) / 255.0).round() as u32;
                let all = value << 24 | value << 16 | value << 8 | value;
                assert_eq!(scaled(all, factor), exact << 24 | exact << 16 | exact << 8 | exact, "{value} {factor}");
                let other = factor << 24 | factor << 16 | factor << 8 | factor;
                assert_eq!(modulated(all, other), scaled(all, factor));
            }
        }
        assert_eq!(over(0xFF12_3456, 0x00AB_CDEF), 0x0012_3456);
        assert_eq!(over(0, 0x00AB_CDEF), 0x00AB_CDEF);
        assert_eq!(over(0x8040_0000, 0x00FF_FFFF), 0x00BF_7F7F);
        assert_eq!(over(0x00FF_0000, 0x0080_8080), 0x00FF_8080, "additive");
    }
}
