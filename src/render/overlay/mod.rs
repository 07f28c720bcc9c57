//! Text on a finished picture: labels, legend and scale bar, the same from both renderers.
//!
//! [`layout`] decides what is written where, in parts of the full picture's height, so that neither the size of the picture
//! nor the region of it that is drawn changes anything; [`draw`] makes pixels of it, each the same whichever region it is in. What a
//! label stands for must be seen at its anchor; that is looked up in a G-buffer of the full picture, at most
//! [`PROBE_SIDE`] pixels wide or high.
//!
//! Limits: one line a label, no shaping or kerning, Latin and Greek letters (others are drawn as a box); capitals end
//! at 4000 pixels' height.

mod blur;
mod draw;
mod font;
mod layout;

use super::{GBuffer, Image, View};
use crate::color::Srgb8;
use crate::scene::{Background, Scene};

/// Longer side in pixels of the G-buffer in which it is looked up what is seen. Chosen: 10,000 atoms in a picture are still 5 pixels
/// wide each, and a small molecule's probe costs about a tenth of a second.
pub const PROBE_SIDE: u32 = 1280;

/// Writes what the scene has to say onto its picture. `probe` is what is seen by a [`probe_view`]; without it there are no labels.
pub fn write(image: &mut Image, scene: &Scene, view: &View, probe: Option<&GBuffer>) {
    if !scene.overlay.is_empty() {
        let layout = layout::Layout::new(&scene.overlay, view, probe);
        draw::draw(image, view, &layout, Ink::on(scene.background));
    }
}

/// The full picture of a view, its longer side so many pixels long.
#[must_use]
pub fn probe_view(view: &View, longer_side: u32) -> View {
    let scale = f64::from(longer_side) / f64::from(view.width.max(view.height));
    let side = |side: u32| (f64::from(side) * scale).round() as u32;
    View::new(view.camera, side(view.width), side(view.height))
}

/// What text is drawn with.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ink {
    text: Srgb8,
    halo: Srgb8,
}

impl Ink {
    /// Dark with a light halo where the background is light or nothing, else the reverse.
    fn on(background: Background) -> Ink {
        /// Relative luminance at which black and white text have the same contrast, √(1.05 · 0.05) − 0.05, by the contrast
        /// ratio of WCAG 2.1, (L₁ + 0.05) / (L₂ + 0.05).
        const MIDDLE: f32 = 0.179;
        let (dark, light) = (Srgb8::rgb(24, 24, 28), Srgb8::rgb(255, 255, 255));
        let is_light = match background {
            Background::Transparent => true,
            Background::Color(color) => {
                // Rec. 709.
                let [r, g, b] = color.to_linear();
                0.2126 * r + 0.7152 * g + 0.0722 * b > MIDDLE
            }
        };
        if is_light { Ink { text: dark, halo: light } } else { Ink { text: light, halo: dark } }
    }
}

#[cfg(test)]
mod tests;
