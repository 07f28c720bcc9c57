//! PNG: pictures with 8 bits a channel, depth, normals and ids with 16 (described in [`super::picture`]).
//!
//! Rows are compressed as they come. Of what was tried on pictures of proteins at 1920 × 1080 (megabytes for a second's wait) the
//! Paeth filter alone before fdeflate was best: 10 ms and 640 kB where the adaptive filter takes 16 ms and zlib-rs on
//! two cores 19 ms (level 2, 520 kB) to 25 ms (level 4, 480 kB).

use super::picture::{Content, Layer, PictureOptions, flattened};
use ::png::{BitDepth, ColorType, Encoder, EncodingError, PixelDimensions, SrgbRenderingIntent, Unit, Writer, chunk};
use fdeflate::Compressor;
use std::io::{self, Write};

/// Bytes of a chunk of compressed pixels. Chosen: the 12 bytes around it do not count, nor does the memory.
const CHUNK_BYTES: usize = 1 << 16;

/// A PNG file that gets its rows in strips from the top.
pub(super) struct PngFile<'a> {
    compressor: Compressor<Chunks<'a>>,
    layer: Layer,
    options: PictureOptions,
    /// Bytes a pixel: how far the filter reaches to the left.
    pixel_bytes: usize,
    row: Vec<u8>,
    /// The row above, zeros at first.
    above: Vec<u8>,
    /// The number of the filter and the filtered row.
    filtered: Vec<u8>,
}

/// Compressed pixels on their way into chunks.
struct Chunks<'a> {
    writer: Writer<&'a mut dyn Write>,
    waiting: Vec<u8>,
}

impl Chunks<'_> {
    fn finish(mut self) -> io::Result<()> {
        self.writer.write_chunk(chunk::IDAT, &self.waiting).map_err(io_error)?;
        self.writer.finish().map_err(io_error)
    }
}

impl Write for Chunks<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= CHUNK_BYTES {
            self.writer.write_chunk(chunk::IDAT, &self.waiting).map_err(io_error)?;
            self.waiting.clear();
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<'a> PngFile<'a> {
    /// Writes all that comes before the pixels.
    pub(super) fn new(
        (width, height): (u32, u32),
        layer: Layer,
        options: &PictureOptions,
        out: &'a mut dyn Write,
    ) -> io::Result<PngFile<'a>> {
        let mut texts = options.texts.clone();
        let (color, depth, pixel_bytes) = match layer {
            Layer::Color if options.alpha => (ColorType::Rgba, BitDepth::Eight, 4),
            Layer::Color => (ColorType::Rgb, BitDepth::Eight, 3),
            Layer::Depth { near, far } => {
                texts.push(("near_angstrom".to_owned(), near.to_string()));
                texts.push(("far_angstrom".to_owned(), far.to_string()));
                (ColorType::Grayscale, BitDepth::Sixteen, 2)
            }
            Layer::Ao => (ColorType::Grayscale, BitDepth::Sixteen, 2),
            Layer::Normal | Layer::Id => (ColorType::Rgb, BitDepth::Sixteen, 6),
        };
        let mut encoder = Encoder::new(out, width, height);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if layer == Layer::Color {
            encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        }
        if let Some(dpi) = options.dpi {
            let per_meter = (f64::from(dpi) / 0.0254).round() as u32;
            encoder.set_pixel_dims(Some(PixelDimensions { xppu: per_meter, yppu: per_meter, unit: Unit::Meter }));
        }
        for (keyword, text) in texts {
            // tEXt holds Latin-1, which only ASCII is the same in; the rest goes into iTXt, which holds UTF-8.
            if text.is_ascii() {
                encoder.add_text_chunk(keyword, text).map_err(io_error)?;
            } else {
                encoder.add_itxt_chunk(keyword, text).map_err(io_error)?;
            }
        }
        let writer = encoder.write_header().map_err(io_error)?;
        let compressor = Compressor::new(Chunks { writer, waiting: Vec::new() })?;
        let row = vec![0; width as usize * pixel_bytes];
        let (above, filtered) = (row.clone(), vec![PAETH; row.len() + 1]);
        Ok(PngFile { compressor, layer, options: options.clone(), pixel_bytes, row, above, filtered })
    }

    /// Writes the next rows.
    pub(super) fn strip(&mut self, content: Content<'_>) -> io::Result<()> {
        let (width, height) = (content.size().0 as usize, content.size().1 as usize);
        for y in 0..height {
            let out = &mut self.row;
            let pixels = y * width..(y + 1) * width;
            match content {
                Content::Color(image) => {
                    let rgba = &image.rgba[pixels.start * 4..pixels.end * 4];
                    match self.options.alpha {
                        true => out.copy_from_slice(rgba),
                        false => flattened(rgba, self.options.background, out),
                    }
                }
                Content::Depth(buffer) => {
                    let Layer::Depth { near, far } = self.layer else { continue };
                    words(out, buffer.depth[pixels].iter().map(|&depth| depth_value(depth, near, far)));
                }
                Content::Ao(sky) => words(out, sky.open[pixels].iter().map(|&open| unit_value(open))),
                Content::Normal(buffer) => {
                    words(out, buffer.normal[pixels].iter().flat_map(|&normal| normal_value(normal)));
                }
                Content::Id(buffer) => {
                    words(out, buffer.id[pixels].iter().flat_map(|&id| [(id >> 16) as u16, id as u16, 0]));
                }
            }
            filter(self.pixel_bytes, &self.above, &self.row, &mut self.filtered[1..]);
            self.compressor.write_data(&self.filtered)?;
            std::mem::swap(&mut self.above, &mut self.row);
        }
        Ok(())
    }

    /// Ends the file.
    pub(super) fn finish(self) -> io::Result<()> {
        self.compressor.finish()?.finish()
    }
}

/// The number of the Paeth filter.
const PAETH: u8 = 4;

/// A row less what the Paeth filter (PNG 3rd edition, 9.4) predicts from the bytes to the left and above.
fn filter(pixel_bytes: usize, above: &[u8], row: &[u8], out: &mut [u8]) {
    // Left of the row are zeros: the nearest is the byte above.
    for ((out, x), above) in out.iter_mut().zip(row).zip(above).take(pixel_bytes) {
        *out = x.wrapping_sub(*above);
    }
    let beside = row.iter().zip(above).zip(&above[pixel_bytes..]);
    for ((out, x), ((left, upper_left), above)) in out[pixel_bytes..].iter_mut().zip(&row[pixel_bytes..]).zip(beside) {
        *out = x.wrapping_sub(paeth(*left, *above, *upper_left));
    }
}

/// The neighbour nearest to left + above − upper left. Without branches, which become vector code.
#[inline(always)]
fn paeth(left: u8, above: u8, upper_left: u8) -> u8 {
    let [a, b, c] = [left, above, upper_left].map(i16::from);
    let (to_left, to_above, to_upper_left) = ((b - c).abs(), (a - c).abs(), (a + b - 2 * c).abs());
    let other = if to_above <= to_upper_left { above } else { upper_left };
    if (to_left <= to_above) & (to_left <= to_upper_left) { left } else { other }
}

/// Fills `out` with words, the high byte first.
fn words(out: &mut [u8], values: impl Iterator<Item = u16>) {
    for (bytes, value) in out.chunks_exact_mut(2).zip(values) {
        bytes.copy_from_slice(&value.to_be_bytes());
    }
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

fn depth_value(depth: f32, near: f32, far: f32) -> u16 {
    if !depth.is_finite() {
        return 0;
    }
    let (depth, near, far) = (f64::from(depth), f64::from(near), f64::from(far));
    let nearness = if far > near { (far - depth) / (far - near) } else { 1.0 };
    1 + (nearness * 65534.0).round() as u16
}

/// 0 to 1 in all 16 bits.
fn unit_value(x: f32) -> u16 {
    (x * 65535.0).round() as u16 // `as` clamps
}

fn normal_value(normal: [f32; 3]) -> [u16; 3] {
    if normal == [0.0; 3] {
        return [0; 3];
    }
    normal.map(|x| unit_value(x * 0.5 + 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Srgb8;
    use crate::export::picture::{self, PictureFormat};
    use crate::render::image::{GBuffer, Image, SkyVisibility};

    fn decode(content: Content<'_>, options: &PictureOptions) -> (::png::Info<'static>, Vec<u8>) {
        let mut file = Vec::new();
        picture::write(content, PictureFormat::Png, options, &mut file).unwrap();
        let mut reader = ::png::Decoder::new(io::Cursor::new(file)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        (reader.info().clone(), data)
    }

    fn words(bytes: &[u8]) -> Vec<u16> {
        bytes.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()
    }

    fn buffer() -> GBuffer {
        GBuffer {
            width: 3,
            height: 1,
            id: vec![0, 70_000, GBuffer::GROUND],
            depth: vec![f32::INFINITY, 10.0, 20.0],
            normal: vec![[0.0; 3], [0.0, 0.0, 1.0], [-1.0, 1.0, 0.0]],
        }
    }

    #[test]
    fn files_have_alpha_exactly_if_asked_for_pixel_for_pixel() {
        let image = Image { width: 1, height: 2, rgba: vec![1, 2, 3, 0, 4, 5, 6, 255] };
        let (info, data) = decode(Content::Color(&image), &PictureOptions { alpha: true, ..PictureOptions::default() });
        assert_eq!((info.color_type, data), (ColorType::Rgba, image.rgba.clone()));
        assert_eq!((info.srgb, info.pixel_dims.is_none()), (Some(SrgbRenderingIntent::Perceptual), true));
        let options = PictureOptions { background: Srgb8::rgb(7, 8, 9), ..PictureOptions::default() };
        let (info, data) = decode(Content::Color(&image), &options);
        assert_eq!((info.color_type, data), (ColorType::Rgb, vec![7, 8, 9, 4, 5, 6]));
    }

    #[test]
    fn sky_visibility_takes_all_sixteen_bits() {
        let sky = SkyVisibility { width: 3, height: 1, open: vec![0.0, 0.5, 1.0] };
        let (info, data) = decode(Content::Ao(&sky), &PictureOptions::default());
        assert_eq!((info.color_type, info.bit_depth), (ColorType::Grayscale, BitDepth::Sixteen));
        assert_eq!(words(&data), [0, 32768, 65535]);
    }

    #[test]
    fn the_resolution_is_in_pixels_a_metre() {
        let image = Image { width: 1, height: 1, rgba: vec![0; 4] };
        let (info, _) = decode(Content::Color(&image), &PictureOptions { dpi: Some(300), ..PictureOptions::default() });
        let dims = info.pixel_dims.unwrap();
        assert_eq!((dims.xppu, dims.yppu, dims.unit), (11811, 11811, Unit::Meter));
    }

    #[test]
    fn a_disk_that_is_full_is_noticed_wherever_it_is_full() {
        struct Full(usize);
        impl Write for Full {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
                Ok(bytes.len())
            }

            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let image = Image { width: 40, height: 40, rgba: (0..6400u32).map(|i| (i * i) as u8).collect() };
        let write = |out: &mut dyn Write| {
            picture::write(Content::Color(&image), PictureFormat::Png, &PictureOptions::default(), out)
        };
        let mut file = Vec::new();
        write(&mut file).unwrap();
        assert!(write(&mut Full(file.len())).is_ok());
        for room in 0..file.len() {
            assert!(write(&mut Full(room)).is_err(), "{room} of {}", file.len());
        }
    }

    #[test]
    fn texts_come_back_in_any_script() {
        let texts = vec![("Software".into(), "ballstick".into()), ("Title".into(), "Koffein 咖啡因".into())];
        let options = PictureOptions { texts, ..PictureOptions::default() };
        let image = Image { width: 1, height: 1, rgba: vec![0; 4] };
        let (info, _) = decode(Content::Color(&image), &options);
        assert_eq!(info.uncompressed_latin1_text[0].text, "ballstick");
        assert_eq!(info.utf8_text[0].get_text().unwrap(), "Koffein 咖啡因");
    }

    #[test]
    fn depth_runs_from_near_65535_to_far_1_and_the_background_is_0() {
        let (info, data) = decode(Content::Depth(&buffer()), &PictureOptions::default());
        assert_eq!((info.color_type, info.bit_depth), (ColorType::Grayscale, BitDepth::Sixteen));
        assert_eq!(words(&data), [0, 65535, 1]);
        let texts: Vec<_> =
            info.uncompressed_latin1_text.iter().map(|t| (t.keyword.as_str(), t.text.as_str())).collect();
        assert_eq!(texts, [("near_angstrom", "10"), ("far_angstrom", "20")]);
        assert_eq!(depth_value(15.0, 10.0, 20.0), 32768);
        assert_eq!(depth_value(5.0, 5.0, 5.0), 65535);
    }

    #[test]
    fn normals_are_half_n_plus_half_and_ids_are_split_into_two_words() {
        let (_, data) = decode(Content::Normal(&buffer()), &PictureOptions::default());
        assert_eq!(words(&data), [0, 0, 0, 32768, 32768, 65535, 0, 65535, 32768]);
        let (_, data) = decode(Content::Id(&buffer()), &PictureOptions::default());
        assert_eq!(words(&data), [0, 0, 0, 1, 4464, 0, 65535, 65535, 0]);
    }
}
