//! Colours: sRGB in files and flags, linear in shading. This module is the only one that converts. `names` has those with names.

mod names;

/// An sRGB colour of 8 bits a channel with straight (un-premultiplied) alpha, as it stands in files and flags.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Srgb8 {
    /// Red, 0–255.
    pub r: u8,
    /// Green, 0–255.
    pub g: u8,
    /// Blue, 0–255.
    pub b: u8,
    /// Opacity, 0–255.
    pub a: u8,
}

impl Srgb8 {
    /// Black, opaque.
    pub const BLACK: Srgb8 = Srgb8::rgb(0, 0, 0);
    /// White, opaque.
    pub const WHITE: Srgb8 = Srgb8::rgb(255, 255, 255);

    /// An opaque colour.
    #[must_use]
    pub const fn rgb(r: u8, g: u8, b: u8) -> Srgb8 {
        Srgb8 { r, g, b, a: 255 }
    }

    /// An opaque colour from `0xRRGGBB`.
    #[must_use]
    pub const fn from_rgb_u32(rgb: u32) -> Srgb8 {
        Srgb8::rgb((rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8)
    }

    /// Linear red, green and blue, 0–1.
    ///
    /// ```
    /// use ballstick::color::Srgb8;
    /// let grey = Srgb8::rgb(188, 188, 188).to_linear();
    /// assert!((grey[0] - 0.5).abs() < 0.005);
    /// ```
    #[inline]
    #[must_use]
    pub fn to_linear(self) -> [f32; 3] {
        let linear = linear_levels();
        [linear[usize::from(self.r)], linear[usize::from(self.g)], linear[usize::from(self.b)]]
    }

    /// The nearest colour to a linear one; channels outside 0–1 (and NaN, as 0) are clamped.
    #[must_use]
    pub fn from_linear(rgb: [f32; 3], alpha: f32) -> Srgb8 {
        let [r, g, b] = bytes_from_linear(&rgb);
        Srgb8 {
            r,
            g,
            b,
            a: (alpha * 255.0 + 0.5) as u8, // `as` clamps and turns NaN into 0
        }
    }

    /// A colour by `#rgb`, `#rrggbb`, `#rrggbbaa` (the `#` may be left out), or a name of CSS (`steelblue`) or PyMOL (`marine`, `grey50`).
    /// `None` for anything else; [`Srgb8::instead_of`] says what was likely meant.
    #[must_use]
    pub fn parse(text: &str) -> Option<Srgb8> {
        let text = text.trim().to_ascii_lowercase();
        if let Some(color) = names::of(&text) {
            return Some(color);
        }
        let hex = text.strip_prefix('#').unwrap_or(&text);
        if !hex.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return None;
        }
        let digit = |i: usize| hex.get(i..=i).and_then(|d| u8::from_str_radix(d, 16).ok());
        let pair = |i: usize| hex.get(i..i + 2).and_then(|d| u8::from_str_radix(d, 16).ok());
        match hex.len() {
            3 => Some(Srgb8::rgb(digit(0)? * 17, digit(1)? * 17, digit(2)? * 17)),
            6 => Some(Srgb8::rgb(pair(0)?, pair(2)?, pair(4)?)),
            8 => Some(Srgb8 { r: pair(0)?, g: pair(2)?, b: pair(4)?, a: pair(6)? }),
            _ => None,
        }
    }
}

impl Srgb8 {
    /// What to say behind a message about a text that is no colour: `; did you mean marine?`, or nothing.
    ///
    /// ```
    /// use ballstick::color::Srgb8;
    /// assert_eq!(Srgb8::instead_of("marin"), "; did you mean marine?");
    /// ```
    #[must_use]
    pub fn instead_of(text: &str) -> String {
        names::likely(text).map_or_else(String::new, |name| format!("; did you mean {name}?"))
    }
}

impl std::fmt::Display for Srgb8 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.r, self.g, self.b)?;
        if self.a == 255 { Ok(()) } else { write!(f, "{:02x}", self.a) }
    }
}

/// One channel, IEC 61966-2-1: linear 0–1 (clamped to it) to sRGB 0–1.
#[must_use]
pub fn srgb_from_linear(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// One channel, IEC 61966-2-1: sRGB 0–1 to linear 0–1.
#[must_use]
pub fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// Bytes of linear values (clamped to 0–1; NaN is 0): `srgb_from_linear(x) * 255`, rounded. Pictures convert millions of them:
/// without a branch or a call, so that it becomes vector code.
#[inline(always)]
#[must_use]
pub fn bytes_from_linear<const N: usize>(linear: &[f32; N]) -> [u8; N] {
    levels_from_linear(linear).map(|level| level as u8)
}

/// [`bytes_from_linear`] as words, which vector code puts together faster.
#[inline(always)]
#[must_use]
pub fn levels_from_linear<const N: usize>(linear: &[f32; N]) -> [u32; N] {
    let mut levels = [0u32; N];
    for i in 0..N {
        let x = if linear[i] > 0.0 { linear[i] } else { 0.0 };
        let x = if x < 1.0 { x } else { 1.0 };
        let power = power_5_12(if x > 0.003 { x } else { 0.003 });
        let curve = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * power - 0.055 };
        // Adding 2²³ rounds to a whole number, which then stands in the lowest bits.
        levels[i] = (curve * 255.0 + 8_388_608.0).to_bits() & 0xFF;
    }
    levels
}

/// `x.powf(5.0 / 12.0)` for 0.003–1, to 3e-7: 2^(log2(x) · 5/12), the logarithm by the series of the area tangent, the
/// power by that of the exponential.
#[inline(always)]
fn power_5_12(x: f32) -> f32 {
    // x = 2^e · m, m from √½ to √2 (whose bits are subtracted).
    let bits = x.to_bits();
    let e = (bits.wrapping_sub(0x3F35_04F3) as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((e << 23) as u32));
    let f = (m - 1.0) / (m + 1.0);
    let f2 = f * f;
    let ln = 2.0 * f * (1.0 + f2 * (1.0 / 3.0 + f2 * (0.2 + f2 * (1.0 / 7.0 + f2 * (1.0 / 9.0)))));
    let p = (e as f32 + ln * std::f32::consts::LOG2_E) * (5.0 / 12.0);
    let n = (p + 0.5).floor();
    let r = (p - n) * std::f32::consts::LN_2;
    let series = 1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0));
    let exp = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * series)));
    // Times 2^n.
    f32::from_bits(exp.to_bits().wrapping_add(((n + 8_388_608.0 + 256.0).to_bits() << 23).wrapping_sub(256 << 23)))
}

/// The linear value of each sRGB byte. For many colours it is fetched once.
#[inline]
#[must_use]
pub fn linear_levels() -> &'static [f32; 256] {
    &SRGB_TO_LINEAR
}

static SRGB_TO_LINEAR: std::sync::LazyLock<[f32; 256]> =
    std::sync::LazyLock::new(|| std::array::from_fn(|i| linear_from_srgb(i as f32 / 255.0)));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_the_way_to_linear_and_back() {
        for i in 0..=255u8 {
            let color = Srgb8::rgb(i, i, i);
            assert_eq!(Srgb8::from_linear(color.to_linear(), 1.0), color);
        }
    }

    #[test]
    fn bytes_are_the_rounded_curve() {
        for i in 0..=100_000 {
            let x = i as f32 / 100_000.0;
            let exact = srgb_from_linear(x) * 255.0;
            let byte = Srgb8::from_linear([x; 3], 1.0).r;
            assert!((f32::from(byte) - exact).abs() <= 0.5 + 1e-3, "{x}: {byte} for {exact}");
        }
    }

    #[test]
    fn parses_names_and_hex_and_refuses_the_rest() {
        assert_eq!(Srgb8::parse("white"), Some(Srgb8::WHITE));
        assert_eq!(Srgb8::parse("#f80"), Some(Srgb8::rgb(255, 136, 0)));
        assert_eq!(Srgb8::parse("102030"), Some(Srgb8::rgb(16, 32, 48)));
        assert_eq!(Srgb8::parse("#10203040"), Some(Srgb8 { r: 16, g: 32, b: 48, a: 64 }));
        for text in ["", "#", "#12", "#12345", "#ggg", "whit", "+12345", "é12"] {
            assert_eq!(Srgb8::parse(text), None, "{text:?}");
        }
    }

    #[test]
    fn out_of_range_and_nan_are_clamped() {
        assert_eq!(Srgb8::from_linear([f32::NAN, -1.0, 9.0], 2.0), Srgb8 { r: 0, g: 0, b: 255, a: 255 });
    }
}
