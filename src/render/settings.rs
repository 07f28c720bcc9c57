//! What a picture is asked to be.

use crate::scene::{Camera, PixelGrid, Region};

/// A camera and the picture it fills.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Where it is taken from.
    pub camera: Camera,
    /// Width of the full picture in pixels.
    pub width: u32,
    /// Height of the full picture in pixels.
    pub height: u32,
    /// The part of it that is wanted; `None` for all.
    pub region: Option<Region>,
}

impl View {
    /// The whole picture.
    #[must_use]
    pub fn new(camera: Camera, width: u32, height: u32) -> View {
        View { camera, width: width.max(1), height: height.max(1), region: None }
    }

    /// The wanted part, cut to the picture.
    #[must_use]
    pub fn region(&self) -> Region {
        let all = Region { x: 0, y: 0, width: self.width, height: self.height };
        self.region.map_or(all, |r| {
            let (x, y) = (r.x.min(self.width - 1), r.y.min(self.height - 1));
            let (width, height) = (r.width.clamp(1, self.width - x), r.height.clamp(1, self.height - y));
            Region { x, y, width, height }
        })
    }

    /// From pixels of the full picture to rays.
    #[must_use]
    pub fn pixel_grid(&self) -> PixelGrid {
        self.camera.pixel_grid(self.width, self.height)
    }
}

/// How much work goes into it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Samples per pixel, 1 to 4096. Default: 16.
    pub samples: u32,
    /// Texels along the longer side of the ground's shadow map, 16 to 2046. Default: 256. Of fewer than [`Settings::QUICK_GROUND`] a picture of
    /// one sample that asks no light from afar takes the shadow less exactly: it is in motion.
    pub ground_texels: u32,
    /// Directions of the sky that ambient occlusion is found from, 0 to [`Settings::MOST_DIRECTIONS`]; 0 for none.
    /// Default: 64.
    pub ao: u32,
    /// Whether the molecule throws a shadow on itself. Default: yes.
    pub shadow: bool,
}

impl Settings {
    /// The same with samples enough for a depth of field: through few points of the lens one sees as many pictures.
    #[must_use]
    pub fn through_lens(self) -> Settings {
        Settings { samples: self.samples.max(64), ..self }
    }

    /// More directions than this change nothing that can be seen (chosen: quality `high` asks as many).
    pub const MOST_DIRECTIONS: u32 = 256;

    /// See [`Settings::ground_texels`]. Chosen: half of what a draft has.
    pub const QUICK_GROUND: u32 = 64;
}

impl Default for Settings {
    fn default() -> Self {
        Quality::Standard.settings()
    }
}

/// Settings by one name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quality {
    /// 4 samples a pixel, no ambient occlusion, no shadow but the ground's, which is coarse.
    Draft,
    /// 16 samples a pixel, ambient occlusion from 64 directions, shadows.
    #[default]
    Standard,
    /// 64 samples a pixel, ambient occlusion from 256 directions, shadows, fine ground.
    High,
}

impl Quality {
    /// All of them.
    pub const ALL: [Quality; 3] = [Quality::Draft, Quality::Standard, Quality::High];

    /// The name in flags and settings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Standard => "standard",
            Quality::High => "high",
        }
    }

    /// The quality of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Quality> {
        Quality::ALL.into_iter().find(|quality| quality.name() == name)
    }

    /// What it stands for.
    #[must_use]
    pub fn settings(self) -> Settings {
        match self {
            Quality::Draft => Settings { samples: 4, ground_texels: 128, ao: 0, shadow: false },
            Quality::Standard => Settings { samples: 16, ground_texels: 256, ao: 64, shadow: true },
            Quality::High => Settings { samples: 64, ground_texels: 512, ao: 256, shadow: true },
        }
    }
}

/// Place of sample `index` of `samples` in its pixel, 0–1 in x and y: the (0,2)-sequence of Sobol (the radical inverse
/// in base 2 and its second dimension), moved by half the step of its finest stratum, so that 1 sample sits in the
/// pixel's centre and 4, 16 or 64 have it as their mean.
#[must_use]
pub fn sample_offset(index: u32, samples: u32) -> [f32; 2] {
    let mut sobol = 0u32;
    let (mut direction, mut rest) = (1u32 << 31, index);
    while rest != 0 {
        if rest & 1 == 1 {
            sobol ^= direction;
        }
        direction ^= direction >> 1;
        rest >>= 1;
    }
    let half_step = (1u64 << 31) / u64::from(samples.next_power_of_two().max(1));
    [index.reverse_bits(), sobol].map(|x| {
        // Multiples of 1/512: positions up to pixel 32,768 hold them exactly in f32, so every tile agrees.
        ((u64::from(x) + half_step) >> 23) as f32 / 512.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fill_the_pixel_evenly_about_its_centre() {
        assert_eq!(sample_offset(0, 1), [0.5, 0.5]);
        for count in [4u32, 16, 64] {
            let points: Vec<[f32; 2]> = (0..count).map(|i| sample_offset(i, count)).collect();
            for axis in 0..2 {
                let mean = points.iter().map(|p| p[axis]).sum::<f32>() / count as f32;
                assert_eq!(mean, 0.5);
                // One sample in every stratum of 1/count.
                let mut strata: Vec<u32> = points.iter().map(|p| (p[axis] * count as f32) as u32).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..count).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn regions_are_cut_to_the_picture() {
        let scene = crate::scene::Scene::from_blocks(vec![], vec![]);
        let mut view = View::new(scene.fitted_camera(1.0), 100, 50);
        assert_eq!(view.region(), Region { x: 0, y: 0, width: 100, height: 50 });
        view.region = Some(Region { x: 90, y: 60, width: 20, height: 0 });
        assert_eq!(view.region(), Region { x: 90, y: 49, width: 10, height: 1 });
    }
}
