//! From the layout to pixels.
//!
//! Text is covered exactly, pixel by pixel, wherever it stands; around it lies a soft edge of the other colour. Everything
//! is laid over the picture in sRGB, as browsers lay pictures over pages, with straight alpha.

use super::Ink;
use super::blur::Blur;
use super::font::Font;
use super::layout::{Disc, Layout, Line, Rect};
use crate::color::Srgb8;
use crate::render::{Image, View};
use crate::scene::Region;
use rayon::prelude::*;

/// Standard deviation of the soft edge in em, how much it is raised, and its opacity; chosen by eye on grey, red and blue atoms.
const HALO_SIGMA: f64 = 0.09;
const HALO_GAIN: f32 = 3.0;
const HALO_OPACITY: f32 = 0.9;
/// No larger letters are drawn, in pixels to the em, so that memory has a bound: capitals of 4000 pixels.
const MOST_PX_PER_EM: f64 = 5500.0;
/// Pixels of lines that are prepared together.
const BATCH: f64 = 4e6;

/// Draws a layout of the full picture onto the region of it that the image shows.
pub(super) fn draw(image: &mut Image, view: &View, layout: &Layout, ink: Ink) {
    let Some(font) = Font::get() else { return };
    let region = view.region();
    let height = f64::from(view.height);
    let px_per_em = (layout.em * height).min(MOST_PX_PER_EM);
    let blur = Blur::new(HALO_SIGMA * px_per_em);
    // At most so many lines at a time are held in memory.
    let batch = (BATCH / (8.0 * px_per_em * px_per_em)).clamp(1.0, 4096.0) as usize;
    for lines in layout.lines.chunks(batch) {
        let masks: Vec<Mask> =
            lines.par_iter().filter_map(|line| Mask::of_line(font, line, (height, px_per_em), region, blur)).collect();
        masks.iter().for_each(|mask| mask.lay_over(image, region, ink));
    }
    if let Some(mask) = Mask::of_bars(&layout.bars, height, region, blur) {
        mask.lay_over(image, region, ink);
    }
    for disc in &layout.discs {
        lay_disc(image, region, height, disc, ink.halo);
    }
}

/// Coverage of letters and of their soft edge over a rectangle of the full picture.
struct Mask {
    x: i64,
    y: i64,
    width: usize,
    text: Vec<u8>,
    halo: Vec<u16>,
}

impl Mask {
    /// An empty mask over what a rectangle (in pixels) and its soft edge cover, as far as the region is concerned.
    fn new(bounds: Rect, region: Region, blur: Blur) -> Option<Mask> {
        let margin = blur.margin();
        let [left, top, right, bottom] = bounds;
        let low = |edge: f64, start: u32| (edge.floor() as i64 - margin).max(i64::from(start) - margin);
        let high = |edge: f64, start: u32, length: u32| {
            (edge.ceil() as i64 + margin).min(i64::from(start) + i64::from(length) + margin)
        };
        let (x, y) = (low(left, region.x), low(top, region.y));
        let width = usize::try_from(high(right, region.x, region.width) - x).ok()?;
        let rows = usize::try_from(high(bottom, region.y, region.height) - y).ok()?;
        let text = vec![0; width.checked_mul(rows).filter(|&pixels| pixels > 0)?];
        Some(Mask { x, y, width, text, halo: Vec::new() })
    }

    fn of_line(font: &Font, line: &Line, (height, px_per_em): (f64, f64), region: Region, blur: Blur) -> Option<Mask> {
        let [left, base] = line.at.map(|x| x * height);
        let width = line.width * height;
        // Accents and descenders stay inside these; a letter may lean a little out of its advance.
        let bounds =
            [left - 0.1 * px_per_em, base - 1.1 * px_per_em, left + width + 0.1 * px_per_em, base + 0.4 * px_per_em];
        let mut mask = Mask::new(bounds, region, blur)?;
        for (character, advance) in line.text.chars().zip(font.advances(&line.text)) {
            let x = left + advance * px_per_em;
            let inside = [(x - x.floor()) as f32, (base - base.floor()) as f32];
            let Some(glyph) = font.outlined(character, px_per_em as f32, inside) else { continue };
            let corner = glyph.px_bounds().min;
            let (x, y) = (x.floor() as i64 + corner.x as i64, base.floor() as i64 + corner.y as i64);
            let (x, y) = (x - mask.x, y - mask.y);
            let (columns, rows) = (glyph.px_bounds().width() as i64, glyph.px_bounds().height() as i64);
            if x + columns <= 0 || y + rows <= 0 || x >= mask.width as i64 || y >= mask.rows() as i64 {
                continue;
            }
            glyph.draw(|dx, dy, coverage| mask.add(x + i64::from(dx), y + i64::from(dy), coverage));
        }
        mask.finish(blur)
    }

    fn of_bars(bars: &[Rect], height: f64, region: Region, blur: Blur) -> Option<Mask> {
        let bars: Vec<Rect> = bars.iter().map(|bar| bar.map(|x| x * height)).collect();
        let around =
            bars.iter().copied().reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]);
        let mut mask = Mask::new(around?, region, blur)?;
        let overlap = |at: i64, low: f64, high: f64| ((at + 1) as f64).min(high) - (at as f64).max(low);
        for bar in &bars {
            for y in 0..mask.rows() as i64 {
                let covered_y = overlap(y + mask.y, bar[1], bar[3]);
                for x in 0..mask.width as i64 {
                    let covered_x = overlap(x + mask.x, bar[0], bar[2]);
                    if covered_x > 0.0 && covered_y > 0.0 {
                        mask.add(x, y, (covered_x * covered_y) as f32);
                    }
                }
            }
        }
        mask.finish(blur)
    }

    fn rows(&self) -> usize {
        self.text.len() / self.width
    }

    fn add(&mut self, x: i64, y: i64, coverage: f32) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x < self.width
            && let Some(value) = self.text.get_mut(y * self.width + x)
        {
            *value = value.saturating_add((coverage * 255.0 + 0.5) as u8);
        }
    }

    fn finish(mut self, blur: Blur) -> Option<Mask> {
        self.halo = self.text.iter().map(|&coverage| u16::from(coverage) * 257).collect();
        blur.run(&mut self.halo, self.width);
        Some(self)
    }

    fn lay_over(&self, image: &mut Image, region: Region, ink: Ink) {
        let [text_color, halo_color] = [ink.text, ink.halo].map(channels);
        for (index, (&text, &halo)) in self.text.iter().zip(&self.halo).enumerate() {
            if halo == 0 && text == 0 {
                continue;
            }
            let at = [self.x + (index % self.width) as i64, self.y + (index / self.width) as i64];
            let Some(pixel) = pixel_at(image, region, at) else { continue };
            let text = f32::from(text) / 255.0;
            let halo = HALO_OPACITY * (HALO_GAIN * f32::from(halo) / 65535.0).min(1.0) * (1.0 - text);
            let layer = [0, 1, 2].map(|c| text_color[c] * text + halo_color[c] * halo);
            over(pixel, layer, text + halo);
        }
    }
}

/// A small ball of the legend, lit from the upper left like those of the picture.
fn lay_disc(image: &mut Image, region: Region, height: f64, disc: &Disc, halo: Srgb8) {
    let ([cx, cy], radius) = (disc.center.map(|x| x * height), disc.radius * height);
    let soft = 0.18 * radius;
    let reach = radius + 2.0 * soft + 1.0;
    let (color, halo) = (channels(disc.color), channels(halo));
    let first = |center: f64, start: u32| ((center - reach).floor() as i64).max(i64::from(start));
    let last = |center: f64, start: u32, length: u32| {
        ((center + reach).ceil() as i64).min(i64::from(start) + i64::from(length))
    };
    for y in first(cy, region.y)..last(cy, region.y, region.height) {
        for x in first(cx, region.x)..last(cx, region.x, region.width) {
            let Some(pixel) = pixel_at(image, region, [x, y]) else { continue };
            let (dx, dy) = ((x as f64 + 0.5 - cx) / radius, (y as f64 + 0.5 - cy) / radius);
            let from_center = dx.hypot(dy);
            let covered = (0.5 + (1.0 - from_center) * radius).clamp(0.0, 1.0) as f32;
            let beyond = ((from_center - 1.0) * radius / soft).max(0.0);
            let around = HALO_OPACITY * (-beyond * beyond).exp() as f32 * (1.0 - covered);
            // Chosen by eye: the middle has the colour itself, the lower right edge is darker, so that white stays a disc on white.
            let up = (1.0 - from_center * from_center).max(0.0).sqrt();
            let lit = (-0.4 * dx - 0.5 * dy + 0.77 * up).max(0.0);
            let light = (0.62 + 0.45 * lit).min(1.0) as f32;
            let layer = [0, 1, 2].map(|c| color[c] * light * covered + halo[c] * around);
            over(pixel, layer, covered + around);
        }
    }
}

fn channels(color: Srgb8) -> [f32; 3] {
    [color.r, color.g, color.b].map(f32::from)
}

/// The four bytes of a pixel of the full picture; `None` outside the region.
fn pixel_at(image: &mut Image, region: Region, [x, y]: [i64; 2]) -> Option<&mut [u8]> {
    let column = u32::try_from(x - i64::from(region.x)).ok().filter(|&column| column < image.width)?;
    let row = u32::try_from(y - i64::from(region.y)).ok().filter(|&row| row < image.height)?;
    let start = (row as usize * image.width as usize + column as usize) * 4;
    image.rgba.get_mut(start..start + 4)
}

/// Lays a colour, multiplied by its alpha, over a pixel of straight alpha.
fn over(pixel: &mut [u8], layer: [f32; 3], alpha: f32) {
    let below = f32::from(pixel[3]) / 255.0 * (1.0 - alpha);
    let all = alpha + below;
    if alpha <= 0.0 || all <= 0.0 {
        return;
    }
    for (channel, value) in pixel.iter_mut().zip(layer) {
        *channel = ((value + f32::from(*channel) * below) / all + 0.5) as u8;
    }
    pixel[3] = (all * 255.0 + 0.5) as u8;
}
