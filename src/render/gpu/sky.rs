//! Light from afar on the device: the tubes of [`crate::render::tubes`] as textures, which `shaders/sky.wgsl` asks for the
//! directions that are a sample's turn. The same numbers as on the CPU.
//!
//! Tubes of all directions are uploaded at once, and kept as long as scene, light, directions and samples stay, or,
//! where those would be large, made anew for each sample, for its directions only.
//!
//! Limits: nothing is asked, and all light taken to come as where it is not, where the primitives or the tubes of one sample do not
//! fit the device's textures. With textures of 2048 texels a side, and the 16 samples and 64 directions of a still, those
//! of about 200,000 atoms do.

use super::device::{Gpu, view_of};
use super::ground::{Casters, write_rows};
use super::layout::{FIELD_FORMAT, WORD_FORMAT};
use super::passes::Passes;
use crate::error::Result;
use crate::render::settings::Settings;
use crate::render::sky::Turns;
use crate::render::tubes::{Tubes, tubes};
use glam::Vec3;
use std::sync::atomic::{AtomicBool, Ordering};

/// Words of a light's tubes up to which all directions are uploaded at once. Chosen: 64 MiB.
const ALL_AT_ONCE: usize = 16 << 20;
/// Words of the tubes of one sample at most. Chosen: 512 MiB.
const MOST_WORDS: usize = 128 << 20;
/// Texels of a row at most: a device that has more does not need them for [`MOST_WORDS`].
const WIDEST_ROW: u32 = 16_384;

/// What a light's directions are found from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    Sky { count: u32, samples: u32 },
    Key { toward: Vec3, samples: u32 },
}

impl Source {
    /// Of the sky and of the key light.
    fn wanted(key_in_world: Vec3, settings: &Settings) -> [Option<Source>; 2] {
        let (count, samples) = (settings.ao.min(Settings::MOST_DIRECTIONS), settings.samples);
        let sky = (count > 0).then_some(Source::Sky { count, samples });
        [sky, settings.shadow.then_some(Source::Key { toward: key_in_world, samples })]
    }
}

/// Tubes of some directions on the device.
#[derive(Debug)]
struct Texels {
    words: wgpu::TextureView,
    directions: wgpu::TextureView,
}

/// One of the two lights.
#[derive(Debug, Default)]
struct Light {
    source: Option<Source>,
    turns: Turns,
    /// Tubes of all directions; `None` if nothing is asked, or each sample has tubes of its own.
    whole: Option<Texels>,
    is_split: bool,
}

/// What the shade pass asks.
#[derive(Debug)]
pub(super) struct Sky {
    lights: [Light; 2],
    casters: Option<Casters>,
    center: Vec3,
    /// Bound where nothing is asked.
    none: Texels,
    no_casters: wgpu::TextureView,
    idle: wgpu::BindGroup,
    /// All that is asked, unless a light is split.
    group: Option<wgpu::BindGroup>,
    /// Whether something that was asked did not fit the device.
    lacks: AtomicBool,
}

impl Sky {
    pub(super) fn new(gpu: &Gpu, passes: &Passes) -> Sky {
        let blank = |label, format| view_of(&gpu.texture(label, [1, 1], format, wgpu::TextureUsages::TEXTURE_BINDING));
        // Zeros: a sample asks no directions.
        let none = Texels { words: blank("no tubes", WORD_FORMAT), directions: blank("no directions", FIELD_FORMAT) };
        let no_casters = blank("no casters", FIELD_FORMAT);
        let idle = bind(gpu, passes, [&none, &none], &no_casters);
        let (lights, center) = (Default::default(), Vec3::ZERO);
        Sky { lights, casters: None, center, none, no_casters, idle, group: None, lacks: AtomicBool::new(false) }
    }

    /// Forgets the scene.
    pub(super) fn clear(&mut self) {
        (self.lights, self.casters, self.group) = (Default::default(), None, None);
    }

    /// Makes the tubes of these settings and this key light unless they are there. `center` is the scene's.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        passes: &Passes,
        casters: Option<&Casters>,
        (center, key_in_world): (Vec3, Vec3),
        settings: &Settings,
    ) -> Result<()> {
        self.hold(casters, center);
        if casters.is_none() {
            self.lacks.store(true, Ordering::Relaxed);
        }
        for (light, wanted) in self.lights.iter_mut().zip(Source::wanted(key_in_world, settings)) {
            if light.source != wanted {
                self.group = None;
                *light = Light::default(); // the old one goes first
                if let (Some(source), Some(casters)) = (wanted, casters) {
                    *light = gpu.guard("uploading the light", || Ok(Light::new(gpu, casters, center, source)))?;
                }
            }
        }
        if self.group.is_none() && !self.is_split() {
            let [sky, key] = self.lights.each_ref().map(|light| light.whole.as_ref().unwrap_or(&self.none));
            self.group = Some(self.bound(gpu, passes, [sky, key]));
        }
        Ok(())
    }

    /// Whether each sample has tubes of its own, which may be large.
    pub(super) fn is_split(&self) -> bool {
        self.lights.iter().any(|light| light.is_split)
    }

    /// Group 2 of the shade pass for a sample, after [`Sky::prepare`] if anything is asked.
    pub(super) fn group(&self, gpu: &Gpu, passes: &Passes, asks: bool, sample: u32) -> wgpu::BindGroup {
        if !asks {
            return self.idle.clone();
        }
        if let Some(group) = &self.group {
            return group.clone();
        }
        let own = self.lights.each_ref().map(|light| self.of_sample(gpu, light, sample));
        let both = [0, 1].map(|i| own[i].as_ref().or(self.lights[i].whole.as_ref()).unwrap_or(&self.none));
        self.bound(gpu, passes, both)
    }

    /// Takes what hides the light; `center` is the scene's.
    pub(super) fn hold(&mut self, casters: Option<&Casters>, center: Vec3) {
        (self.casters, self.center) = (casters.cloned(), center);
    }

    /// Group 2 of the shade pass for these directions of the sky alone, after [`Sky::hold`]; `None` if their tubes do not fit.
    pub(super) fn of_directions(&self, gpu: &Gpu, passes: &Passes, directions: &[Vec3]) -> Option<wgpu::BindGroup> {
        let casters = self.casters.as_ref()?;
        if casters.bounds.is_empty() {
            return Some(self.idle.clone());
        }
        let tubes = tubes(&casters.bounds, self.center, directions);
        let texels = Texels::new(gpu, &Packed::new(&tubes, [directions.len() as u32, 1], MOST_WORDS)?)?;
        Some(self.bound(gpu, passes, [&texels, &self.none]))
    }

    /// Tubes of the directions of one sample, if the light is split and they fit.
    fn of_sample(&self, gpu: &Gpu, light: &Light, sample: u32) -> Option<Texels> {
        let casters = self.casters.as_ref().filter(|_| light.is_split)?;
        let tubes = tubes(&casters.bounds, self.center, light.turns.of_sample(sample));
        let texels =
            Packed::new(&tubes, [light.turns.each, 1], MOST_WORDS).and_then(|packed| Texels::new(gpu, &packed));
        if texels.is_none() {
            self.lacks.store(true, Ordering::Relaxed);
        }
        texels
    }

    /// Whether something that was asked since the last call did not fit the device, so that it is not in the picture.
    pub(super) fn take_lack(&self) -> bool {
        self.lacks.swap(false, Ordering::Relaxed)
    }

    fn bound(&self, gpu: &Gpu, passes: &Passes, lights: [&Texels; 2]) -> wgpu::BindGroup {
        let casters = self.casters.as_ref().map_or(&self.no_casters, |casters| &casters.texels);
        bind(gpu, passes, lights, casters)
    }
}

impl Light {
    fn new(gpu: &Gpu, casters: &Casters, center: Vec3, source: Source) -> Light {
        let turns = match source {
            Source::Sky { count, samples } => Turns::of_sky(count, samples),
            Source::Key { toward, samples } => Turns::of_key(toward, samples),
        };
        let mut light = Light { source: Some(source), turns, ..Light::default() };
        let directions = &light.turns.directions;
        if casters.bounds.is_empty() || directions.is_empty() {
            return light;
        }
        // The tubes of all directions are about as large.
        let first = tubes(&casters.bounds, center, &directions[..1]);
        let estimate = first.iter().map(words_of).sum::<usize>().saturating_mul(directions.len());
        if estimate <= ALL_AT_ONCE {
            let all = tubes(&casters.bounds, center, directions);
            let turns = directions.len() as u32 / light.turns.each.max(1);
            let packed = Packed::new(&all, [light.turns.each, turns], 2 * ALL_AT_ONCE);
            light.whole = packed.and_then(|packed| Texels::new(gpu, &packed));
        }
        light.is_split = light.whole.is_none();
        light
    }
}

fn words_of(tubes: &Tubes) -> usize {
    tubes.first.len() + tubes.list.len()
}

/// Tubes as the words and texels that shaders/tubes.wgsl describes.
#[derive(Debug)]
struct Packed {
    words: Vec<u32>,
    /// Of the first row: directions a sample asks, and turns.
    turns: [u32; 2],
    rows: Vec<[[f32; 4]; 4]>,
}

impl Packed {
    /// `None` if that is more than so many words.
    fn new(tubes: &[Tubes], turns: [u32; 2], most: usize) -> Option<Packed> {
        let size: usize = tubes.iter().map(words_of).sum();
        if size > most {
            return None;
        }
        let mut words = Vec::with_capacity(size);
        let mut rows = Vec::with_capacity(tubes.len());
        let mut list_start = tubes.iter().map(|t| t.first.len()).sum::<usize>() as u32;
        for t in tubes {
            let first = words.len() as u32;
            words.extend(t.first.iter().map(|start| start + list_start));
            list_start += t.list.len() as u32;
            // Halves of the number: f32 holds no more than 24 bits.
            rows.push([
                t.right.extend(t.corner[0]).to_array(),
                t.up.extend(t.corner[1]).to_array(),
                t.toward.extend(t.per_angstrom).to_array(),
                [t.size[0] as f32, t.size[1] as f32, (first & 0xffff) as f32, (first >> 16) as f32],
            ]);
        }
        tubes.iter().for_each(|t| words.extend(&t.list));
        Some(Packed { words, turns, rows })
    }
}

impl Texels {
    /// `None` if it does not fit the device's textures.
    fn new(gpu: &Gpu, packed: &Packed) -> Option<Texels> {
        let limit = gpu.limits.max_texture_dimension_2d;
        let widest = WIDEST_ROW.min(1 << limit.max(1).ilog2());
        let square = (packed.words.len() as f64).sqrt() as u32;
        let width = square.next_power_of_two().clamp(256.min(widest), widest);
        let height = u32::try_from(packed.words.len().div_ceil(width as usize).max(1)).ok()?;
        let [each, turns] = packed.turns;
        let size = [4, packed.rows.len() as u32 + 1];
        if height > limit || size[1] > limit {
            return None;
        }
        let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
        let words = gpu.texture("tubes", [width, height], WORD_FORMAT, usage);
        let whole = packed.words.len() / width as usize;
        let (rows, rest) = packed.words.split_at(whole * width as usize);
        write_rows(gpu, &words, 0, [width, whole as u32], bytemuck::cast_slice(rows));
        if !rest.is_empty() {
            let mut last = rest.to_vec();
            last.resize(width as usize, 0);
            write_rows(gpu, &words, whole as u32, [width, 1], bytemuck::cast_slice(&last));
        }
        let mut texels = vec![[[each as f32, turns as f32, width.ilog2() as f32, 0.0], [0.0; 4], [0.0; 4], [0.0; 4]]];
        texels.extend(&packed.rows);
        let directions = gpu.texture("directions", size, FIELD_FORMAT, usage);
        write_rows(gpu, &directions, 0, size, bytemuck::cast_slice(&texels));
        Some(Texels { words: view_of(&words), directions: view_of(&directions) })
    }
}

fn bind(gpu: &Gpu, passes: &Passes, [sky, key]: [&Texels; 2], casters: &wgpu::TextureView) -> wgpu::BindGroup {
    passes.shade.sky(gpu, [&sky.words, &sky.directions, &key.words, &key.directions, casters])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::solids::{Solids, Sphere};
    use crate::render::tubes::Bounds;

    #[test]
    fn packed_words_lead_to_the_lists_of_every_tube() {
        let centers = (0..200u32).map(|i| Vec3::new((i % 7) as f32, (i % 11) as f32, (i % 13) as f32) * 1.7);
        let spheres = centers.map(|center| Sphere { center, radius: 0.9 }).collect();
        let bounds = Bounds::new(&Solids { spheres, ..Solids::default() });
        let all = tubes(&bounds, Vec3::ONE, &crate::render::sky::directions(9));
        let packed = Packed::new(&all, [3, 3], 1 << 20).unwrap();
        assert_eq!(packed.words.len(), all.iter().map(words_of).sum::<usize>());
        for (tubes, [right, up, toward, grid]) in all.iter().zip(&packed.rows) {
            assert_eq!([right[3], up[3]], tubes.corner);
            assert_eq!(toward[3], tubes.per_angstrom);
            assert_eq!([grid[0] as u32, grid[1] as u32], tubes.size);
            let start = grid[2] as usize + ((grid[3] as usize) << 16);
            for tube in 0..(tubes.size[0] * tubes.size[1]) as usize {
                let [from, to] = [packed.words[start + tube], packed.words[start + tube + 1]];
                assert_eq!(&packed.words[from as usize..to as usize], tubes.of(tube));
            }
        }
        assert!(Packed::new(&all, [3, 3], 100).is_none());
    }
}
