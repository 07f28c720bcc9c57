//! What is behind the primitives, and the finished pixels, a row of sixteen at a time: the vector twins of
//! [`super::shader::Shader::backdrop`] and [`crate::render::frame::resolve`].

use super::behind::Mask;
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

    /// Linear colour of ground or background in the pixels from `x` on.
    #[inline(always)]
    fn behind(&self, x: u32) -> [Lanes; 3] {
        let (mut u, mut v) = ([0.0f32; LANES], [0.0f32; LANES]);
        for lane in 0..LANES {
            u[lane] = ((x + lane as u32) as f32 + 0.5 - self.grid.center_px[0]) * self.grid.plane_per_px;
            v[lane] = (self.grid.center_px[1] - (self.corner[1] as f32 + 0.5)) * self.grid.plane_per_px;
        }
        opaque(self.shader, self.grid, &u, &v)
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
        let behind = if least >= all { [[0.0; LANES]; 3] } else { self.behind(x) };
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
}

/// What is behind the primitives of a picture.
pub(super) struct Backdrop<'a> {
    shader: &'a Shader<'a>,
    grid: &'a PixelGrid,
    /// The background's colour.
    plain: Srgb8,
    /// The last colour of a whole group, and how it is shown.
    last: ([u32; 3], Srgb8),
}

impl<'a> Backdrop<'a> {
    #[inline(always)]
    pub(super) fn new(shader: &'a Shader<'a>, grid: &'a PixelGrid) -> Backdrop<'a> {
        let background = shade_background(shader.frame);
        let plain = resolve(background, 1);
        let last = (
            background.truncate().to_array().map(f32::to_bits),
            Srgb8::from_linear(background.truncate().to_array(), 1.0),
        );
        Backdrop { shader, grid, plain, last }
    }

    /// Whether it is one colour everywhere.
    #[inline(always)]
    pub(super) fn is_plain(&self) -> bool {
        !self.shader.frame.has_ground()
    }

    /// That colour.
    #[inline(always)]
    pub(super) fn plain(&self) -> Srgb8 {
        self.plain
    }

    /// Pixels in which nothing is seen; `u`, `v` are the plane coordinates of their centres.
    #[inline(always)]
    pub(super) fn alone(&mut self, [u, v]: [&Lanes; 2]) -> [Srgb8; LANES] {
        if self.shader.frame.ambient[3] > 0.5 {
            return self.under(&[[0.0; LANES]; 3], &[0; LANES], [u, v]);
        }
        let color = opaque(self.shader, self.grid, u, v);
        let mut differ = 0u32;
        for part in &color {
            for &light in part {
                differ |= light.to_bits() ^ part[0].to_bits();
            }
        }
        if differ == 0 {
            let first = color.map(|part| part[0]);
            let key = first.map(f32::to_bits);
            if key != self.last.0 {
                self.last = (key, Srgb8::from_linear(first, 1.0));
            }
            return [self.last.1; LANES];
        }
        bytes(&color)
    }

    /// Pixels of one sample: the linear light of what is seen, what is behind it where nothing is. `u`, `v` are the plane
    /// coordinates of their centres.
    #[inline(always)]
    pub(super) fn under(&self, light: &[Lanes; 3], seen: &Mask, [u, v]: [&Lanes; 2]) -> [Srgb8; LANES] {
        if self.shader.frame.ambient[3] > 0.5 {
            let mut pixels = [self.plain; LANES];
            // See-through ground: alpha takes a power, which is no vector code.
            for (lane, pixel) in pixels.iter_mut().enumerate() {
                let behind = || self.shader.backdrop(&self.grid.ray((u[lane], v[lane])));
                let light = Vec4::new(light[0][lane], light[1][lane], light[2][lane], 1.0);
                *pixel = resolve(if seen[lane] != 0 { light } else { behind() }, 1);
            }
            return pixels;
        }
        let mut color = *light;
        if seen.contains(&0) {
            let behind = opaque(self.shader, self.grid, u, v);
            for part in 0..3 {
                for lane in 0..LANES {
                    color[part][lane] = if seen[lane] != 0 { light[part][lane] } else { behind[part][lane] };
                }
            }
        }
        bytes(&color)
    }
}

/// Linear colours as they are shown.
#[inline(always)]
fn bytes(color: &[Lanes; 3]) -> [Srgb8; LANES] {
    let [red, green, blue] = color;
    let mut differ = 0;
    for lane in 0..LANES {
        differ |= (red[lane].to_bits() ^ green[lane].to_bits()) | (red[lane].to_bits() ^ blue[lane].to_bits());
    }
    let red = bytes_from_linear(red);
    // The ground mostly is grey.
    let rgb = if differ == 0 { [red; 3] } else { [red, bytes_from_linear(green), bytes_from_linear(blue)] };
    let mut pixels = [Srgb8::BLACK; LANES];
    for (lane, pixel) in pixels.iter_mut().enumerate() {
        *pixel = Srgb8::rgb(rgb[0][lane], rgb[1][lane], rgb[2][lane]);
    }
    pixels
}

/// Linear colour of ground or background at plane coordinates.
#[inline(always)]
fn opaque(shader: &Shader<'_>, grid: &PixelGrid, u: &Lanes, v: &Lanes) -> [Lanes; 3] {
    let frame = shader.frame;
    let background = shade_background(frame).to_array();
    let mut color: [Lanes; 3] = std::array::from_fn(|part| [background[part]; LANES]);
    if !frame.has_ground() {
        return color;
    }
    let t = shader.ground_beyond(grid.orthographic, u, v);
    if t.iter().all(|&t| t == f32::INFINITY) {
        return color;
    }
    let m = &frame.world_from_view;
    let (mut px, mut pz) = ([0.0f32; LANES], [0.0f32; LANES]);
    for lane in 0..LANES {
        let depth = if t[lane] < f32::INFINITY { t[lane] } else { 0.0 };
        // The ray's point is (u, v, 0) − t z with parallel rays, t (u, v, −1) otherwise.
        let aside = if grid.orthographic { 1.0 } else { depth };
        let at = |axis: usize| m[0][axis] * (u[lane] * aside) + m[1][axis] * (v[lane] * aside) - m[2][axis] * depth;
        (px[lane], pz[lane]) = (at(0) + m[3][0], at(2) + m[3][2]);
    }
    let light = shader.ground_map.light(frame, &px, &pz);
    for lane in 0..LANES {
        let fade = ground_fade(frame, px[lane], pz[lane]);
        let fade = if t[lane] < f32::INFINITY { fade } else { 0.0 };
        for part in 0..3 {
            color[part][lane] = background[part] + (frame.ground_color[part] * light[lane] - background[part]) * fade;
        }
    }
    color
}
