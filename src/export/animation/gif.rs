//! GIF (GIF89a) with one palette for all frames: one of its own for each would make still parts flicker.
//!
//! The palette is learned (NeuQuant) from some of the frames before the first is written. In between its colours a pattern
//! that stands still mixes them (ordered dithering, Bayer 1973): noise that is spread from pixel to pixel would crawl. What is as it was in the frame
//! before is left out.
//!
//! Limit: a pixel is there or not, so that edges on a transparent background are hard and faint shadows are lost.

use super::{AnimationOptions, Film, changed, rgb_of};
use crate::error::Result;
use crate::render::Image;
use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Write};

/// Frames that the palette is learned from, at most.
const SAMPLED: u32 = 8;
/// Pixels of each of them (chosen: some of every colour even of thin sticks).
const PIXELS: usize = 1 << 16;
/// How often a colour counts, at most: the background is most of a picture and needs one colour.
const COUNTED: usize = 4;
/// NeuQuant looks at one in so many of the pixels, which are few already: at all.
const FACTION: i32 = 1;
/// The index of what is not there; the others are colours.
const NOTHING: u8 = 255;
/// How far the pattern moves a colour, of 255 (chosen: about half the distance of neighbours in palettes of lit molecules).
const SPREAD: i32 = 5;
/// Colours nearer to one of the palette than this (squared, over the three channels) are that one, without a pattern.
const NEAR: i32 = 6;
/// Colours whose place in the palette is remembered, at most.
const REMEMBERED: usize = 1 << 20;

/// Bayer's 4×4 matrix of thresholds.
const BAYER: [[i32; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

/// The numbers of the frames that the palette is learned from.
pub(super) fn sampled(frames: u32) -> impl Iterator<Item = u32> {
    let count = frames.min(SAMPLED);
    (0..count).map(move |n| (u64::from(n) * u64::from(frames) / u64::from(count)) as u32)
}

/// The colours for all frames, up to 255.
pub(super) fn palette(options: &AnimationOptions, draw: &mut dyn FnMut(u32) -> Result<Image>) -> Result<Vec<[u8; 3]>> {
    let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
    for index in sampled(options.frames) {
        let image = draw(index)?;
        let step = (image.rgba.len() / 4 / PIXELS).max(1);
        for pixel in image.rgba.chunks_exact(4).step_by(step) {
            if let Some(color) = shown(pixel, options) {
                *counts.entry(color).or_default() += 1;
            }
        }
    }
    let mut colors: Vec<([u8; 3], usize)> = counts.into_iter().collect();
    // The same pictures give the same palette.
    colors.sort_unstable();
    let background = rgb_of(options.background);
    let most = usize::from(NOTHING);
    let mut palette: Vec<[u8; 3]> = if colors.len() < most {
        colors.iter().map(|(color, _)| *color).collect()
    } else {
        let repeated =
            |(color, count): &([u8; 3], usize)| vec![[color[0], color[1], color[2], 255]; COUNTED.min(*count)];
        let pixels: Vec<u8> = colors.iter().flat_map(repeated).flatten().collect();
        let learned = NeuQuant::new(FACTION, most - 1, &pixels).color_map_rgb();
        learned.chunks_exact(3).map(|color| [color[0], color[1], color[2]]).take(most - 1).collect()
    };
    // Exact, as it is most of the picture.
    if !palette.contains(&background) {
        palette.push(background);
    }
    Ok(palette)
}

/// The colour that a pixel has in the film; `None` where there is none.
fn shown(pixel: &[u8], options: &AnimationOptions) -> Option<[u8; 3]> {
    let alpha = u32::from(pixel[3]);
    if options.alpha {
        return (alpha >= 128).then(|| [pixel[0], pixel[1], pixel[2]]);
    }
    let under = rgb_of(options.background);
    let over = |c: usize| ((u32::from(pixel[c]) * alpha + u32::from(under[c]) * (255 - alpha) + 127) / 255) as u8;
    Some([over(0), over(1), over(2)])
}

pub(super) struct GifFile<'a> {
    encoder: Encoder<&'a mut dyn Write>,
    options: AnimationOptions,
    palette: Vec<[u8; 3]>,
    /// The nearest of the palette to a colour, and how near it is.
    known: HashMap<[u8; 3], (u8, i32)>,
    before: Vec<u8>,
    count: u32,
}

impl<'a> GifFile<'a> {
    pub(super) fn new(
        palette: Vec<[u8; 3]>,
        options: &AnimationOptions,
        out: &'a mut dyn Write,
    ) -> io::Result<GifFile<'a>> {
        let mut colors: Vec<u8> = palette.iter().flatten().copied().collect();
        colors.resize(256 * 3, 0);
        let [width, height] = [options.size.0, options.size.1].map(|side| side as u16); // `write` has checked them
        let mut encoder = Encoder::new(out, width, height, &colors).map_err(io_error)?;
        encoder.set_repeat(Repeat::Infinite).map_err(io_error)?;
        Ok(GifFile { encoder, options: options.clone(), palette, known: HashMap::new(), before: Vec::new(), count: 0 })
    }

    fn nearest(&mut self, color: [u8; 3]) -> (u8, i32) {
        if let Some(&known) = self.known.get(&color) {
            return known;
        }
        let distance = |other: &[u8; 3]| -> i32 {
            color.iter().zip(other).map(|(a, b)| (i32::from(*a) - i32::from(*b)).pow(2)).sum()
        };
        let all = self.palette.iter().enumerate().map(|(index, other)| (index as u8, distance(other)));
        let found = all.min_by_key(|(_, distance)| *distance).unwrap_or((0, 0));
        if self.known.len() >= REMEMBERED {
            self.known.clear();
        }
        self.known.insert(color, found);
        found
    }

    /// The picture by numbers of the palette.
    fn indices(&mut self, image: &Image) -> Vec<u8> {
        let width = image.width as usize;
        let mut indices = Vec::with_capacity(image.rgba.len() / 4);
        for (at, pixel) in image.rgba.chunks_exact(4).enumerate() {
            let index = match shown(pixel, &self.options) {
                None => NOTHING,
                Some(color) => match self.nearest(color) {
                    (index, distance) if distance <= NEAR => index,
                    _ => {
                        let step = BAYER[at / width % 4][at % width % 4];
                        let moved = |c: u8| (i32::from(c) + (2 * step - 15) * SPREAD / 15).clamp(0, 255) as u8;
                        self.nearest(color.map(moved)).0
                    }
                },
            };
            indices.push(index);
        }
        indices
    }

    /// Hundredths of a second that the next frame lasts; what rounding takes from one the next one gets.
    fn delay(&self) -> u16 {
        let at = |count: u32| (f64::from(count) * 100.0 / self.options.fps).round();
        (at(self.count + 1) - at(self.count)).clamp(2.0, 65_535.0) as u16
    }
}

impl Film for GifFile<'_> {
    fn frame(&mut self, image: &Image) -> io::Result<()> {
        let width = image.width as usize;
        let now = self.indices(image);
        let mut frame = Frame { delay: self.delay(), transparent: Some(NOTHING), ..Frame::default() };
        let is_first = self.before.is_empty();
        if self.options.alpha || is_first {
            // What was there must go where nothing is now.
            frame.dispose = if self.options.alpha { DisposalMethod::Background } else { DisposalMethod::Keep };
            (frame.width, frame.height) = (image.width as u16, image.height as u16);
            frame.buffer = Cow::Owned(now.clone());
        } else {
            let before = &self.before;
            let [x, y, w, h] = changed(width, |at| now[at] != before[at], now.len()).unwrap_or([0, 0, 1, 1]);
            let left_out = |at: usize| if now[at] == before[at] { NOTHING } else { now[at] };
            frame.dispose = DisposalMethod::Keep;
            (frame.left, frame.top, frame.width, frame.height) = (x as u16, y as u16, w as u16, h as u16);
            let rows = (y..y + h).flat_map(|y| (y * width + x..y * width + x + w).map(left_out));
            frame.buffer = Cow::Owned(rows.collect());
        }
        self.encoder.write_frame(&frame).map_err(io_error)?;
        (self.before, self.count) = (now, self.count + 1);
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.encoder.into_inner().map(drop).map_err(io_error)
    }
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::Io(error) => error,
        other => io::Error::other(other),
    }
}
