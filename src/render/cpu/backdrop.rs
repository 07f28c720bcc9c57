//! What is behind the primitives, and the finished pixels, a row of sixteen at a time: the vector twins of
//! [`super::shader::Shader::backdrop`] and [`crate::render::frame::resolve`].

use super::lanes::{LANES, Lanes};
use super::shader::Shader;
use crate::color::{Srgb8, bytes_from_linear};
use crate::render::frame::{ground_fade, resolve, shade_background};
use crate::scene::PixelGrid;
use glam::Vec4;

/// A row of pixels.
pub(super) struct Row<'a> {
    pub(super) shader: &'a Shader<'a>,
    pub(super) grid: &'a PixelGrid,
    /// Its first pixel in the full picture.
    pub(super) corner: [u32; 2],
    pub(super) samples: u32,
    /// The background's colour, opaque.
    pub(super) background: Srgb8,
}

/// What the samples of some pixels gave: sums of premultiplied linear red, green and blue, and how many saw a primitive.
pub(super) type Sums<'a> = [&'a [f32]; 4];

impl Row<'_> {
    /// Finishes pixels of which the samples are known.
    #[inline(always)]
    pub(super) fn finish(&self, sums: Sums<'_>, pixels: &mut [Srgb8]) {
        for (start, pixels) in (0..).step_by(LANES).zip(pixels.chunks_mut(LANES)) {
            let part = sums.map(|sums| &sums[start..start + pixels.len()]);
            self.finish_some(self.corner[0] + start as u32, part, pixels);
        }
    }

    #[inline(always)]
    fn finish_some(&self, x: u32, sums: Sums<'_>, pixels: &mut [Srgb8]) {
        let all = self.samples as f32;
        let frame = self.shader.frame;
        let seen = sums[3];
        if frame.ambient[3] > 0.5 {
            // See-through ground: alpha takes a power, which is no vector code.
            for (i, pixel) in pixels.iter_mut().enumerate() {
                let mut sum = Vec4::from_array(sums.map(|sums| sums[i]));
                if sum.w < all {
                    let center = self.grid.plane((x + i as u32) as f32 + 0.5, self.corner[1] as f32 + 0.5);
                    sum += self.shader.backdrop(&self.grid.ray(center)) * (all - sum.w);
                }
                *pixel = resolve(sum, self.samples);
            }
            return;
        }
        let (mut least, mut most) = (all, 0.0f32);
        for &seen in seen {
            least = if seen < least { seen } else { least };
            most = if seen > most { seen } else { most };
        }
        if most == 0.0 && !frame.has_ground() {
            pixels.fill(self.background);
            return;
        }
        let behind = if least >= all { [[0.0; LANES]; 3] } else { self.opaque(x) };
        let first = behind.map(|part| part[0]);
        if most == 0.0 && (0..3).all(|part| behind[part].iter().all(|&c| c == first[part])) {
            pixels.fill(Srgb8::from_linear(first, 1.0));
            return;
        }
        let mut unseen = [0.0f32; LANES];
        for (unseen, &seen) in unseen.iter_mut().zip(seen) {
            *unseen = all - seen;
        }
        let mut rgb = [[0u8; LANES]; 3];
        for part in 0..3 {
            let mut mean = [0.0f32; LANES];
            for (mean, &sum) in mean.iter_mut().zip(sums[part]) {
                *mean = sum;
            }
            for lane in 0..LANES {
                mean[lane] = (mean[lane] + behind[part][lane] * unseen[lane]) / all;
            }
            rgb[part] = bytes_from_linear(&mean);
        }
        for (i, pixel) in pixels.iter_mut().enumerate() {
            *pixel = Srgb8::rgb(rgb[0][i], rgb[1][i], rgb[2][i]);
        }
    }

    /// Linear colour of ground or background.
    #[inline(always)]
    fn opaque(&self, x: u32) -> [Lanes; 3] {
        let frame = self.shader.frame;
        let background = shade_background(frame).to_array();
        let mut color: [Lanes; 3] = std::array::from_fn(|part| [background[part]; LANES]);
        if !frame.has_ground() {
            return color;
        }
        let (mut u, mut v) = ([0.0f32; LANES], [0.0f32; LANES]);
        for lane in 0..LANES {
            u[lane] = ((x + lane as u32) as f32 + 0.5 - self.grid.center_px[0]) * self.grid.plane_per_px;
            v[lane] = (self.grid.center_px[1] - (self.corner[1] as f32 + 0.5)) * self.grid.plane_per_px;
        }
        let t = self.shader.ground_beyond(self.grid.orthographic, &u, &v);
        if t.iter().all(|&t| t == f32::INFINITY) {
            return color;
        }
        let m = &frame.world_from_view;
        let (mut px, mut pz) = ([0.0f32; LANES], [0.0f32; LANES]);
        for lane in 0..LANES {
            let depth = if t[lane] < f32::INFINITY { t[lane] } else { 0.0 };
            // The ray's point is (u, v, 0) − t z with parallel rays, t (u, v, −1) otherwise.
            let aside = if self.grid.orthographic { 1.0 } else { depth };
            let at = |axis: usize| m[0][axis] * (u[lane] * aside) + m[1][axis] * (v[lane] * aside) - m[2][axis] * depth;
            (px[lane], pz[lane]) = (at(0) + m[3][0], at(2) + m[3][2]);
        }
        let light = self.shader.ground_map.light(frame, &px, &pz);
        for lane in 0..LANES {
            let fade = ground_fade(frame, px[lane], pz[lane]);
            let fade = if t[lane] < f32::INFINITY { fade } else { 0.0 };
            for part in 0..3 {
                color[part][lane] =
                    background[part] + (frame.ground_color[part] * light[lane] - background[part]) * fade;
            }
        }
        color
    }
}
