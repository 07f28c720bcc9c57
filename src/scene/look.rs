//! Looks: the numbers of light and background that belong together, under one name. A page each.
//!
//! All numbers are ours, chosen by eye on a small molecule, a protein and a crystal.

use super::light::Lighting;
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
}

impl Look {
    /// All of them.
    pub const ALL: [Look; 4] = [Look::Studio, Look::Soft, Look::Flat, Look::Dark];

    /// The name in flags and settings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Look::Studio => "studio",
            Look::Soft => "soft",
            Look::Flat => "flat",
            Look::Dark => "dark",
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
            Look::Studio | Look::Soft | Look::Flat => Srgb8::WHITE,
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
                fog: 0.6,
                ..Lighting::default()
            },
            Look::Flat => Lighting {
                key: 0.10,
                fill: 0.0,
                sky: 0.95,
                bounce: 0.88,
                specular: 0.0,
                rim: 0.35,
                ao_floor: 0.7,
                shadow: 0.5,
                fog: 0.6,
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
                fog: 0.7,
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
