//! The font of all text: Inter Medium, cut to Latin and Greek, compiled in. Its source and licence are in data/README.md.

use ab_glyph::{Font as _, FontRef, Glyph, OutlinedGlyph, PxScaleFactor, point};
use std::sync::LazyLock;

/// A font and its proportions.
pub(super) struct Font {
    font: FontRef<'static>,
    units_per_em: f32,
    cap_height: f32,
}

static FONT: LazyLock<Option<Font>> = LazyLock::new(|| {
    let font = FontRef::try_from_slice(include_bytes!("../../../data/font/Inter-Medium-subset.otf")).ok()?;
    let units_per_em = font.units_per_em()?;
    let cap_height = font.outline(font.glyph_id('H'))?.bounds.height().abs() / units_per_em;
    Some(Font { font, units_per_em, cap_height })
});

impl Font {
    /// The font; always there, a test says so.
    pub(super) fn get() -> Option<&'static Font> {
        FONT.as_ref()
    }

    /// Height of capitals in em.
    pub(super) fn cap_height(&self) -> f64 {
        f64::from(self.cap_height)
    }

    /// How far each character of a line is from its start, in em, and at the end how long the line is.
    pub(super) fn advances(&self, text: &str) -> Vec<f64> {
        let mut end = 0.0;
        let mut advances = vec![end];
        advances.extend(text.chars().map(|character| {
            let id = self.font.glyph_id(character);
            end += f64::from(self.font.h_advance_unscaled(id) / self.units_per_em);
            end
        }));
        advances
    }

    /// Length of a line in em.
    pub(super) fn width(&self, text: &str) -> f64 {
        self.advances(text).last().copied().unwrap_or(0.0)
    }

    /// The outline of a character at a place inside its pixel; `None` if it is blank.
    pub(super) fn outlined(&self, character: char, px_per_em: f32, [x, y]: [f32; 2]) -> Option<OutlinedGlyph> {
        let id = self.font.glyph_id(character);
        let factor = px_per_em / self.units_per_em;
        let glyph: Glyph = id.with_scale_and_position(px_per_em, point(x, y));
        let outline = self.font.outline(id)?;
        Some(OutlinedGlyph::new(glyph, outline, PxScaleFactor { horizontal: factor, vertical: factor }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_is_there_with_what_chemists_write() {
        let font = Font::get().unwrap();
        assert!((0.6..0.8).contains(&font.cap_height()), "{}", font.cap_height());
        let letters = "ABCIlO0 äÅå αβγδΔωµ ²³⁺⁻₁₂ₙ ±×·−–—… ′″ ←→ ≤≥≈ °";
        for character in letters.chars() {
            assert_ne!(font.font.glyph_id(character).0, 0, "{character}");
        }
        assert_eq!(font.width(""), 0.0);
        assert!(font.width("GLY 12") > 2.0 * font.width("GL"));
    }

    #[test]
    fn capital_i_and_small_l_differ() {
        let font = Font::get().unwrap();
        let bounds = |c| font.outlined(c, 100.0, [0.0, 0.0]).unwrap().px_bounds();
        assert!(bounds('I').width() > 1.5 * bounds('|').width(), "it has serifs");
        assert_ne!(bounds('I').width(), bounds('l').width());
    }
}
