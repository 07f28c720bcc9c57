//! A texture of egui's in memory.

use super::blend::packed;
use egui::epaint::ImageData;
use egui::{TextureFilter, TextureOptions};

/// Premultiplied texels `0xAARRGGBB`, rows from the top.
pub(super) struct Texture {
    size: [usize; 2],
    texels: Vec<u32>,
    is_nearest: bool,
}

impl Texture {
    pub(super) fn new(image: &ImageData, options: TextureOptions) -> Texture {
        let ImageData::Color(image) = image;
        let is_nearest = options.magnification == TextureFilter::Nearest;
        Texture { size: image.size, texels: image.pixels.iter().map(|&texel| packed(texel)).collect(), is_nearest }
    }

    /// Overwrites a part.
    pub(super) fn patch(&mut self, [left, top]: [usize; 2], image: &ImageData) {
        let ImageData::Color(image) = image;
        let [width, height] = image.size;
        if width == 0 || left + width > self.size[0] || top + height > self.size[1] {
            return;
        }
        for (y, row) in image.pixels.chunks_exact(width).enumerate() {
            let start = (top + y) * self.size[0] + left;
            for (texel, &color) in self.texels[start..start + width].iter_mut().zip(row) {
                *texel = packed(color);
            }
        }
    }

    pub(super) fn size(&self) -> [usize; 2] {
        self.size
    }

    /// A row from a texel on.
    pub(super) fn row(&self, x: usize, y: usize, width: usize) -> Option<&[u32]> {
        let start = y * self.size[0] + x;
        if x + width > self.size[0] { None } else { self.texels.get(start..start + width) }
    }

    /// The colour at texture coordinates (0–1).
    pub(super) fn at(&self, u: f32, v: f32) -> u32 {
        let [width, height] = self.size;
        if width == 0 || height == 0 {
            return 0;
        }
        let texel = |x: usize, y: usize| self.texels[y.min(height - 1) * width + x.min(width - 1)];
        let (x, y) = (u * width as f32, v * height as f32);
        if self.is_nearest {
            return texel(x.max(0.0) as usize, y.max(0.0) as usize);
        }
        let (x, y) = ((x - 0.5).max(0.0), (y - 0.5).max(0.0));
        let (left, top) = (x as usize, y as usize);
        let (right, down) = (x - left as f32, y - top as f32);
        let corners = [texel(left, top), texel(left + 1, top), texel(left, top + 1), texel(left + 1, top + 1)];
        if corners == [corners[0]; 4] {
            return corners[0];
        }
        let weights = [(1.0 - right) * (1.0 - down), right * (1.0 - down), (1.0 - right) * down, right * down];
        [0, 8, 16, 24].into_iter().fold(0, |color, shift| {
            let sum: f32 = corners.iter().zip(weights).map(|(c, weight)| (c >> shift & 0xFF) as f32 * weight).sum();
            color | ((sum + 0.5) as u32).min(255) << shift
        })
    }
}
