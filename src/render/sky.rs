//! Light from afar: which directions are asked whether something stands in the way, and what the answers mean.
//!
//! A surface point's ambient occlusion is sky visibility: over directions `d` spread evenly over the whole sphere and
//! fixed in world space, the sum of `max(n·d, 0)` where nothing is in the way over the sum of all `max(n·d, 0)`.
//! Its key light is the mean visibility over directions in a narrow cone about the light. Neither has a reach:
//! whatever stands in the way counts, however far away it is. The reference casts
//! rays; the product asks what stands in tubes along each direction ([`super::tubes`]), on the CPU as on the GPU; of large scenes the CPU sorts the
//! points that ask along it, and primitives ask these. All three are exact.
//!
//! The samples of a pixel share the directions out among themselves ([`Turns`]): with 16 samples and 64 directions each
//! sample asks four, well apart from one another, and the pixel has asked all of them. That costs a sixteenth of asking all
//! at every sample, and unlike asking once a pixel it is smooth wherever a pixel shows more than one thing.

use crate::math::max;
use glam::Vec3;

/// Directions about the key light that are asked. Chosen: 16 steps of a penumbra are finer than its edge is long.
pub const SHADOW_DIRECTIONS: u32 = 16;

/// Half the opening of the cone about the key light, radians: 3°, six times the sun's. Chosen: soft where atoms are far
/// apart, sharp where they touch.
pub const SHADOW_CONE_RAD: f32 = 3.0 * std::f32::consts::PI / 180.0;

/// Rays start this far above their surface point, in ångström, so that rounding does not let a surface hide itself.
pub const START_OFFSET: f32 = 1e-3;
/// And this part of the point's depth at least, which rounded the point: it counts from 1000 Å on.
pub const START_ROUNDING: f32 = 1e-6;

/// How far above a surface point at this depth its rays start, ångström.
#[inline(always)]
#[must_use]
pub fn start_offset(depth: f32) -> f32 {
    max(START_OFFSET, START_ROUNDING * depth)
}

/// How much of the light from afar reaches a surface point, 0–1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Part of the sky, weighted by the cosine to the normal.
    pub open: f32,
    /// Part of the key light.
    pub key: f32,
}

/// `count` unit directions, evenly over the whole sphere: the spherical Fibonacci lattice (Swinbank and Purser,
/// Q. J. R. Meteorol. Soc. 2006, 132, 1769). The same for the same count, in world space.
#[must_use]
pub fn directions(count: u32) -> Vec<Vec3> {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    (0..count)
        .map(|i| {
            let y = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let angle = std::f64::consts::TAU * (f64::from(i) / golden).fract();
            let across = (1.0 - y * y).max(0.0).sqrt();
            glam::DVec3::new(across * angle.cos(), y, across * angle.sin()).as_vec3()
        })
        .collect()
}

/// Directions in the cone about the key light: a sunflower's seeds on the disc.
#[must_use]
pub fn key_directions(key: Vec3) -> Vec<Vec3> {
    let [right, up] = across(key);
    let golden_angle = std::f32::consts::PI * (3.0 - 5f32.sqrt());
    (0..SHADOW_DIRECTIONS)
        .map(|i| {
            let radius = SHADOW_CONE_RAD.tan() * ((i as f32 + 0.5) / SHADOW_DIRECTIONS as f32).sqrt();
            let (sin, cos) = (golden_angle * i as f32).sin_cos();
            (key + right * (radius * cos) + up * (radius * sin)).normalize_or(key)
        })
        .collect()
}

/// Directions in the order in which the samples of a pixel ask them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Turns {
    /// Sample `s` asks `each` of them, from `s % turns · each` on. A few stand there twice if the numbers do not divide.
    pub directions: Vec<Vec3>,
    /// How many a sample asks; 0 if there are none.
    pub each: u32,
}

impl Turns {
    /// The sky's `count` directions for so many samples a pixel. A sample asks four at least: fewer could all lie behind
    /// the surface.
    #[must_use]
    pub fn of_sky(count: u32, samples: u32) -> Turns {
        let all = directions(count);
        let each = count.div_ceil(samples.max(1)).max(4).min(count);
        if each == 0 {
            return Turns::default();
        }
        // One of each stratum of the lattice, which runs from top to bottom: how far apart they are around the axis
        // depends on the shift from stratum to stratum. The best shift gives every surface much the same weight.
        let turns = count.div_ceil(each);
        let normals = directions(48);
        let weights: Vec<Vec<f32>> = normals.iter().map(|n| all.iter().map(|d| d.dot(*n).max(0.0)).collect()).collect();
        let unevenness = |shift: u32| -> f32 {
            let sum = |of: &Vec<f32>, turn| (0..each).map(|j| of[member(count, each, turn, shift, j)]).sum::<f32>();
            weights.iter().map(|of| (0..turns).map(|turn| sum(of, turn).powi(2)).sum::<f32>()).sum()
        };
        let shift = (0..turns).map(|shift| (unevenness(shift), shift)).min_by(|a, b| a.0.total_cmp(&b.0));
        let shift = shift.map_or(0, |(_, shift)| shift);
        let order = (0..turns).flat_map(|turn| (0..each).map(move |j| member(count, each, turn, shift, j)));
        Turns { directions: order.map(|i| all[i]).collect(), each }
    }

    /// The key light's directions for so many samples a pixel.
    #[must_use]
    pub fn of_key(key: Vec3, samples: u32) -> Turns {
        let all = key_directions(key);
        let each = SHADOW_DIRECTIONS.div_ceil(samples.max(1));
        let turns = SHADOW_DIRECTIONS.div_ceil(each);
        let order = (0..turns).flat_map(|turn| (0..each).map(move |j| (turn + j * turns) % SHADOW_DIRECTIONS));
        Turns { directions: order.map(|i| all[i as usize]).collect(), each }
    }

    /// Where the directions of a sample start in the list.
    #[must_use]
    pub fn start(&self, sample: u32) -> u32 {
        let turns = (self.directions.len() as u32).checked_div(self.each).unwrap_or(0);
        sample.checked_rem(turns).unwrap_or(0) * self.each
    }

    /// The directions of a sample.
    #[must_use]
    pub fn of_sample(&self, sample: u32) -> &[Vec3] {
        let start = self.start(sample) as usize;
        &self.directions[start..start + self.each as usize]
    }
}

/// The direction that is asked in stratum `j` of `each` in this turn.
fn member(count: u32, each: u32, turn: u32, shift: u32, j: u32) -> usize {
    let (start, end) = (j * count / each, (j + 1) * count / each);
    (start + (turn + shift * j) % (end - start).max(1)) as usize
}

/// Two unit vectors that make a right-handed frame with a unit direction (Duff et al., JCGT 2017, 6, 1).
#[must_use]
pub fn across(d: Vec3) -> [Vec3; 2] {
    let sign = 1f32.copysign(d.z);
    let a = -1.0 / (sign + d.z);
    let b = d.x * d.y * a;
    [Vec3::new(1.0 + sign * d.x * d.x * a, sign * b, -sign * d.x), Vec3::new(b, sign + d.y * d.y * a, -d.y)]
}

/// The reach of a point with this unit normal: `visible` says whether a direction is free. Both lists may be empty:
/// what is not asked is `unasked`.
pub fn reach(normal: Vec3, sky: &[Vec3], key: &[Vec3], unasked: Reach, visible: impl Fn(Vec3) -> bool) -> Reach {
    let (mut seen, mut all) = (0.0, 0.0);
    for &d in sky {
        let weight = normal.dot(d).max(0.0);
        all += weight;
        if weight > 0.0 && visible(d) {
            seen += weight;
        }
    }
    let lit = key.iter().filter(|&&d| normal.dot(d) > 0.0 && visible(d)).count();
    Reach {
        open: if sky.is_empty() || all <= 0.0 { unasked.open } else { seen / all },
        key: if key.is_empty() { unasked.key } else { lit as f32 / key.len() as f32 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_even_over_the_sphere() {
        for count in [64, 256] {
            let all = directions(count);
            let mean = all.iter().sum::<Vec3>() / count as f32;
            assert!(mean.length() < 0.05, "{count}: {mean}");
            // The sum over a hemisphere's cosines is a quarter of the count, whichever way it faces.
            for n in directions(50) {
                let sum: f32 = all.iter().map(|d| d.dot(n).max(0.0)).sum();
                assert!((sum / (0.25 * count as f32) - 1.0).abs() < 0.06, "{count} along {n}: {sum}");
            }
        }
    }

    #[test]
    fn the_keys_cone_is_as_wide_as_it_says_and_centred() {
        for key in directions(20) {
            let cone = key_directions(key);
            assert_eq!(cone.len(), SHADOW_DIRECTIONS as usize);
            let widest = cone.iter().map(|d| d.angle_between(key)).fold(0.0, f32::max);
            assert!(widest > 0.9 * SHADOW_CONE_RAD && widest <= SHADOW_CONE_RAD + 1e-4, "{widest}");
            assert!((cone.iter().sum::<Vec3>().normalize() - key).length() < 0.01);
        }
    }

    #[test]
    fn samples_share_out_all_directions_and_each_has_some_before_every_surface() {
        for (count, samples) in [(64, 16), (256, 64), (64, 4), (64, 1), (100, 16), (3, 16), (64, 1000), (1, 1)] {
            let turns = Turns::of_sky(count, samples);
            let asked: Vec<Vec3> = (0..samples).flat_map(|s| turns.of_sample(s).to_vec()).collect();
            for d in directions(count) {
                assert!(asked.contains(&d) || samples * turns.each < count, "{count} {samples}");
            }
            assert!(asked.len() as u32 == samples * turns.each && turns.each <= count);
        }
        // A sample of 16 that shares 64 out is never blind, and sees within a factor of two of what it should.
        let turns = Turns::of_sky(64, 16);
        assert_eq!(turns.each, 4);
        for n in directions(500) {
            for sample in 0..16 {
                let sum: f32 = turns.of_sample(sample).iter().map(|d| d.dot(n).max(0.0)).sum();
                assert!(sum > 0.15 && sum < 2.0, "{sample} along {n}: {sum}");
            }
        }
        assert!(Turns::of_sky(0, 16).of_sample(3).is_empty());
    }

    #[test]
    fn the_keys_directions_are_all_asked() {
        for samples in [1, 4, 16, 64] {
            let turns = Turns::of_key(Vec3::Y, samples);
            let asked: Vec<Vec3> = (0..samples).flat_map(|s| turns.of_sample(s).to_vec()).collect();
            assert!(key_directions(Vec3::Y).iter().all(|d| asked.contains(d)), "{samples}");
        }
    }

    #[test]
    fn frames_are_right_handed_and_square() {
        for d in directions(100).into_iter().chain([Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::NEG_Y]) {
            let [right, up] = across(d);
            assert!((right.cross(up) - d).length() < 1e-5, "{d}");
        }
    }

    #[test]
    fn a_point_in_the_open_has_all_light_and_one_under_a_lid_has_none() {
        let (sky, key) = (directions(64), key_directions(Vec3::Y));
        let unasked = Reach { open: 0.5, key: 0.25 };
        assert_eq!(reach(Vec3::Y, &sky, &key, unasked, |_| true), Reach { open: 1.0, key: 1.0 });
        assert_eq!(reach(Vec3::Y, &sky, &key, unasked, |_| false), Reach { open: 0.0, key: 0.0 });
        assert_eq!(reach(Vec3::Y, &[], &[], unasked, |_| true), unasked);
        // A wall over one half of the sky takes half of its light.
        let half = reach(Vec3::Y, &directions(1024), &[], unasked, |d| d.x > 0.0);
        assert!((half.open - 0.5).abs() < 0.01 && half.key == 0.25, "{half:?}");
    }
}
