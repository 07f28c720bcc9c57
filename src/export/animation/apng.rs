//! Animated PNG (PNG 3rd edition, 4.9): each frame after the first is the rectangle that changed.

use super::{AnimationOptions, Film, changed};
use crate::export::picture::flattened;
use crate::render::Image;
use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, SrgbRenderingIntent, Writer};
use std::io::{self, Write};

pub(super) struct Apng<'a> {
    writer: Writer<&'a mut dyn Write>,
    options: AnimationOptions,
    /// Bytes a pixel.
    channels: usize,
    /// The frame before, as it is in the file.
    before: Vec<u8>,
}

impl<'a> Apng<'a> {
    pub(super) fn new(options: &AnimationOptions, out: &'a mut dyn Write) -> io::Result<Apng<'a>> {
        let mut encoder = Encoder::new(out, options.size.0, options.size.1);
        let (color, channels) = if options.alpha { (ColorType::Rgba, 4) } else { (ColorType::Rgb, 3) };
        encoder.set_color(color);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Fast);
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        encoder.set_animated(options.frames, 0).map_err(io_error)?;
        // Thousandths of frames a second: 1000 of them last as many seconds.
        let per_1000_s = (options.fps * 1000.0).round().clamp(1.0, 65_535.0) as u16;
        encoder.set_frame_delay(1000, per_1000_s).map_err(io_error)?;
        for (keyword, text) in &options.texts {
            if text.is_ascii() {
                encoder.add_text_chunk(keyword.clone(), text.clone()).map_err(io_error)?;
            } else {
                encoder.add_itxt_chunk(keyword.clone(), text.clone()).map_err(io_error)?;
            }
        }
        let writer = encoder.write_header().map_err(io_error)?;
        Ok(Apng { writer, options: options.clone(), channels, before: Vec::new() })
    }
}

impl Film for Apng<'_> {
    fn frame(&mut self, image: &Image) -> io::Result<()> {
        let (width, n) = (image.width as usize, self.channels);
        let mut now = vec![0; image.rgba.len() / 4 * n];
        if n == 4 {
            now.copy_from_slice(&image.rgba);
        } else {
            flattened(&image.rgba, self.options.background, &mut now);
        }
        if self.before.is_empty() {
            self.writer.write_image_data(&now).map_err(io_error)?;
        } else {
            let before = &self.before;
            let differs = |i: usize| now[i * n..(i + 1) * n] != before[i * n..(i + 1) * n];
            // A frame has at least one pixel.
            let [x, y, w, h] = changed(width, differs, now.len() / n).unwrap_or([0, 0, 1, 1]);
            let rows = (y..y + h).flat_map(|y| &now[(y * width + x) * n..(y * width + x + w) * n]);
            let part: Vec<u8> = rows.copied().collect();
            let px = |x: usize| u32::try_from(x).unwrap_or(u32::MAX);
            // The place first, as a size is checked against it.
            self.writer.set_frame_position(0, 0).map_err(io_error)?;
            self.writer.set_frame_dimension(px(w), px(h)).map_err(io_error)?;
            self.writer.set_frame_position(px(x), px(y)).map_err(io_error)?;
            self.writer.write_image_data(&part).map_err(io_error)?;
        }
        self.before = now;
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.writer.finish().map_err(io_error)
    }
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
