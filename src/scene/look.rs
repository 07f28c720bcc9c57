//! Looks: the numbers of light and background that belong together, under one name. A page each.
//!
//! All numbers are ours, chosen by eye on a small molecule, a protein and a crystal.

use super::light::{Lighting, Outline};
use crate::color::Srgb8;
use glam::Vec3;

/// How light falls on a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Look {
    /// A key light with shadow, a little fill, a highlight: balls that one could take in the hand.
    #[default]
    Studio,
    /// Light from all around as under a cloudy sky: ambient occlusion shows the shape, shadows are faint.
    Soft,
    /// The colours as they are, hardly shaded: for small pictures, schemes and figures that are read by colour.
    Flat,
    /// Before a dark background, with a light that comes from behind as well.
    Dark,
    /// Shaded lightly, with a thin dark line around everything: as journals print.
    Outline,
    /// Flat colours, strong lines and soft shade in the hollows: as illustrators draw large molecules.
    Illustrative,
}

impl Look {
    /// All of them.
    pub const ALL: [Look; 6] = [Look::Studio, Look::Soft, Look::Flat, Look::Dark, Look::Outline, Look::Illustrative];

    /// The name in flags and settings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Look::Studio => "studio",
            Look::Soft => "soft",
            Look::Flat => "flat",
            Look::Dark => "dark",
            Look::Outline => "outline",
            Look::Illustrative => "illustrative",
        }
    }

    /// The look of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Look> {
        Look::ALL.into_iter().find(|look| look.name() == name)
    }

    /// The background where none is asked for.
    #[must_use]
    pub fn background(self) -> Srgb8 {
        match self {
            Look::Studio | Look::Soft | Look::Flat | Look::Outline | Look::Illustrative => Srgb8::WHITE,
            // Nearly black, a little blue: black itself looks like a hole beside a page or a slide.
            Look::Dark => Srgb8::rgb(16, 18, 24),
        }
    }

    /// The lights.
    #[must_use]
    pub fn lighting(self) -> Lighting {
        match self {
            Look::Studio => Lighting::default(),
            Look::Soft => Lighting {
                key: 0.34,
                fill: 0.10,
                sky: 0.72,
                bounce: 0.42,
                specular: 0.06,
                gloss_log2: 4,
                rim: 0.3,
                ao_floor: 0.08,
                shadow: 0.6,
                fog: 0.75,
                ..Lighting::default()
            },
            Look::Flat => Lighting {
                key: 0.10,
                fill: 0.0,
                sky: 0.95,
                bounce: 0.88,
                specular: 0.0,
                rim: 0.5,
                ao_floor: 0.7,
                shadow: 0.5,
                fog: 0.75,
                ..Lighting::default()
            },
            Look::Dark => Lighting {
                key: 0.80,
                fill_in_view: Vec3::new(0.75, 0.35, -0.35).normalize(),
                fill: 0.40,
                sky: 0.26,
                bounce: 0.10,
                specular: 0.3,
                rim: 0.2,
                fog: 0.75,
                ..Lighting::default()
            },
            Look::Outline => Lighting {
                key: 0.42,
                fill: 0.06,
                sky: 0.66,
                bounce: 0.42,
                specular: 0.10,
                rim: 0.15,
                ao_floor: 0.35,
                shadow: 0.6,
                fog: 0.75,
                outline: Outline { width: 0.0016, ..Outline::default() },
                ..Lighting::default()
            },
            Look::Illustrative => Lighting {
                key: 0.14,
                fill: 0.0,
                sky: 0.92,
                bounce: 0.80,
                specular: 0.0,
                rim: 0.0,
                ao_floor: 0.12,
                ao_contrast: 0.8,
                shadow: 0.4,
                fog: 0.5,
                // Lines nearer to the silhouette than usual: large balls are drawn apart.
                outline: Outline { width: 0.0026, behind: 0.25, ..Outline::default() },
                ..Lighting::default()
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_flags_and_come_back() {
        for look in Look::ALL {
            assert_eq!(Look::from_name(look.name()), Some(look));
        }
        assert_eq!(Look::from_name("Studio"), None);
    }

    #[test]
    fn in_every_look_a_surface_that_faces_the_light_has_about_its_own_colour() {
        // Element colours are to be what the legend says: no look makes them glaring or murky where they are best lit.
        for look in Look::ALL {
            let light = look.lighting();
            let facing_up = 0.5 + 0.5 * light.key_in_view.y;
            let ambient = light.bounce + (light.sky - light.bounce) * facing_up;
            let sum = light.key + light.fill * light.fill_in_view.dot(light.key_in_view).max(0.0) + ambient;
            assert!((0.93..1.12).contains(&sum), "{look:?}: {sum}");
        }
    }
}
