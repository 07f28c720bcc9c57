//! Light, background and ground: the numbers of the picture's look, in one place.
//!
//! All weights are ours, chosen by eye: a surface that faces the key light comes out at its own colour (the sum
//! there is 1), so that element colours are what the legend says; the fill keeps the far side from going black.

use crate::color::Srgb8;
use glam::Vec3;

/// What the lights turn with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LightFrame {
    /// The camera: they come from the same side of every picture.
    #[default]
    Camera,
    /// The molecule: they fall as in the default view, from wherever it is seen.
    World,
}

impl LightFrame {
    /// All of them.
    pub const ALL: [LightFrame; 2] = [LightFrame::Camera, LightFrame::World];

    /// The name in flags and settings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            LightFrame::Camera => "camera",
            LightFrame::World => "world",
        }
    }

    /// The one of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<LightFrame> {
        LightFrame::ALL.into_iter().find(|frame| frame.name() == name)
    }
}

/// The lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lighting {
    /// What they turn with. Default: the camera.
    pub frame: LightFrame,
    /// Direction to the key light in view space (x right, y up, z to the viewer), that of the default view if the lights do not turn with the
    /// camera. Default: upper left, 45° from the view: what faces the viewer is lit well, and shadows fall behind more than aside.
    pub key_in_view: Vec3,
    /// Strength of the key light. Default: 0.74.
    pub key: f32,
    /// Direction to the fill light, likewise. Default: right, a little below.
    pub fill_in_view: Vec3,
    /// Strength of the fill light. Default: 0.08.
    pub fill: f32,
    /// Ambient light on surfaces that face up. Default: 0.36.
    pub sky: f32,
    /// Ambient light on surfaces that face down. Default: 0.14.
    pub bounce: f32,
    /// Strength of the highlight. Default: 0.22.
    pub specular: f32,
    /// Base-2 logarithm of the highlight's Blinn–Phong exponent. Default: 6, an exponent of 64.
    pub gloss_log2: u8,
    /// How much darker a surface is at its silhouette. Default: 0.45.
    pub rim: f32,
    /// How much of the ambient light is left where no sky is seen, 0–1. Default: 0.25: crevices stay readable.
    pub ao_floor: f32,
    /// How much darker hollows are than by the part of the sky that they see: 0 for that part itself, 1 for its square. Default: 0.
    pub ao_contrast: f32,
    /// How much of the key light its shadow takes away, 0–1. Default: 0.85.
    pub shadow: f32,
    /// The part of the sky that is taken to be seen where ambient occlusion is not asked for: about what atoms of a
    /// molecule see in the mean, so that a draft is as bright as the finished picture. Default: 0.75.
    pub open_unasked: f32,
    /// How much of the background's colour the farthest point takes on (depth cueing), half-way a quarter of it. Default: 0.7: of a
    /// haemoglobin as balls and sticks the front stands before the rest, and the back is still read.
    pub fog: f32,
    /// Lines around things. Default: none.
    pub outline: Outline,
}

/// Lines around things, drawn behind the silhouette of each: see [`crate::render::outline`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outline {
    /// How wide they are, as a part of the height of the full picture; 0 for none. Default: 0.
    pub width: f32,
    /// Their colour. Default: nearly black.
    pub color: Srgb8,
    /// How far behind the silhouette they lie, in radii of the ball or stick: what is behind it by less gets no line. Default: 0.6:
    /// a stick that leaves its ball towards the viewer has lines from where it stands clear of it.
    pub behind: f32,
}

impl Default for Outline {
    fn default() -> Self {
        Outline { width: 0.0, color: Srgb8::rgb(20, 20, 24), behind: 0.6 }
    }
}

impl Default for Lighting {
    fn default() -> Self {
        Lighting {
            frame: LightFrame::Camera,
            key_in_view: Vec3::new(-0.35, 0.70, 0.75).normalize(),
            key: 0.74,
            fill_in_view: Vec3::new(0.8, -0.2, 0.55).normalize(),
            fill: 0.08,
            sky: 0.36,
            bounce: 0.14,
            specular: 0.22,
            gloss_log2: 6,
            rim: 0.45,
            ao_floor: 0.25,
            ao_contrast: 0.0,
            shadow: 0.85,
            open_unasked: 0.75,
            fog: 0.7,
            outline: Outline::default(),
        }
    }
}

/// Depth of field: what is out of focus is blurred.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthOfField {
    /// How wide a point is blurred that lies as far behind the focus as the scene is deep, as a part of the picture's height.
    pub blur: f32,
    /// What is in focus: 0 is the front of the scene, 1 its back.
    pub focus: f32,
}

/// What is behind everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Background {
    /// One colour.
    Color(Srgb8),
    /// Nothing: the picture's alpha says what is covered, the ground keeps its shadow.
    Transparent,
}

impl Default for Background {
    fn default() -> Self {
        Background::Color(Srgb8::WHITE)
    }
}

/// The ground: a horizontal plane that catches the shadow and otherwise looks like the background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    /// World y of the plane, ångström.
    pub height: f32,
    /// The point of the plane below the scene's centre, world x and z.
    pub center_xz: [f32; 2],
    /// Within this distance from the centre the ground is fully there, ångström.
    pub fade_start: f32,
    /// From this distance on it is the background, ångström.
    pub fade_end: f32,
    /// Colour; `None` takes the background's.
    pub color: Option<Srgb8>,
    /// How dark the shadow of the key light gets, 0–1. Default: 0.3.
    pub shadow: f32,
    /// How dark the occluded ground gets, 0–1. Default: 0.45.
    pub occlusion: f32,
    /// Penumbra: visibility is the smallest `sharpness · distance / t` along the way to the light. Default: 6
    /// (a light about 19° across).
    pub sharpness: f32,
    /// How far occlusion reaches, ångström; the fit takes a fifth of the scene's size.
    pub occlusion_reach: f32,
}
