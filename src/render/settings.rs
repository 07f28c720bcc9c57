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
    /// Texels along the longer side of the ground's shadow map, 16 to 2048. Default: 384.
    pub ground_texels: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Quality::Standard.settings()
    }
}

/// Settings by one name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quality {
    /// 4 samples a pixel, coarse ground.
    Draft,
    /// 16 samples a pixel.
    #[default]
    Standard,
    /// 64 samples a pixel, fine ground.
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
            Quality::Draft => Settings { samples: 4, ground_texels: 192 },
            Quality::Standard => Settings { samples: 16, ground_texels: 384 },
            Quality::High => Settings { samples: 64, ground_texels: 768 },
        }
    }
}

/// Place of sample `index` in its pixel, 0–1 in x and y: Roberts's R2 sequence (additive recurrence with the plastic
/// number, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018). Sample 0 is the pixel's centre.
#[must_use]
pub fn sample_offset(index: u32) -> [f32; 2] {
    // 1/p and 1/p² for the plastic number p = 1.32471795724474602596.
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    STEP.map(|step| {
        let x = 0.5 + f64::from(index) * step;
        // Multiples of 1/256: positions up to pixel 32,768 hold them exactly in f32, so every tile agrees.
        (((x - x.floor()) * 256.0).floor() / 256.0) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fill_the_pixel_evenly_and_start_at_its_centre() {
        assert_eq!(sample_offset(0), [0.5, 0.5]);
        for count in [4u32, 16, 64] {
            let points: Vec<[f32; 2]> = (0..count).map(sample_offset).collect();
            assert!(points.iter().flatten().all(|x| (0.0..1.0).contains(x)));
            for axis in 0..2 {
                let mean = points.iter().map(|p| p[axis]).sum::<f32>() / count as f32;
                assert!((mean - 0.5).abs() < 0.08, "{count}: {mean}");
            }
            let mut quadrants = [0; 4];
            for p in &points {
                quadrants[usize::from(p[0] >= 0.5) + 2 * usize::from(p[1] >= 0.5)] += 1;
            }
            assert!(quadrants.iter().all(|&n| n * 8 >= count), "{count}: {quadrants:?}");
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
