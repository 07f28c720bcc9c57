//! Picture files: what a renderer hands back, in the format the name asks for.
//!
//! | format | colour | channels | metadata |
//! |---|---|---|---|
//! | PNG | 8-bit RGB, or RGBA with straight alpha; sRGB chunk | 16-bit, below | text chunks, resolution |
//! | JPEG | quality 92, alpha flattened | – | a comment, resolution |
//! | WebP | lossless RGB or RGBA | – | – |
//! | PPM | binary `P6`, alpha flattened | – | – |
//! | NPY | `(h, w, 4)` `|u1` | `(h, w)` or `(h, w, 3)` | – |
//!
//! Channels hold the visible surface at the pixel centres, rows from the top.
//! - **depth**, distance along the view direction: 16-bit grey PNG, linear from 65535 at `near_angstrom` to 1 at
//!   `far_angstrom` (the smallest and largest depth in this picture, in two text chunks of these names), 0 for the
//!   background; `depth = far − (value − 1) / 65534 · (far − near)`. NPY `<f4` in ångström,
//!   infinity for the background.
//! - **normal**, unit vector in view space (x right, y up, z to the viewer): 16-bit RGB PNG of `n · 0.5 + 0.5`,
//!   `(0, 0, 0)` for the background. NPY `<f4 (h, w, 3)`, zero for the background.
//! - **id**, 0 background, 1 + index of an atom, 1 + number of atoms + index of a bond, 4294967295 ground: 16-bit RGB
//!   PNG with `R = id >> 16`, `G = id & 0xffff`, `B = 0`. NPY `<u4`.
//! - **ao**, the part of the sky that the surface sees, 1 where there is none: 16-bit grey PNG, 65535 for 1. NPY `<f4`.
//!
//! A file has an alpha channel if [`PictureOptions::alpha`] says so, whatever the pixels are: that is known before the first of
//! them. So [`PictureFile`] can write a picture strip by strip as it is drawn. JPEG and WebP are gathered in memory, 3 or
//! 4 bytes a pixel.
//!
//! Flattening composites the stored sRGB values over the background, as browsers and viewers do with the PNG.

use super::npy;
use super::png::PngFile;
use crate::color::Srgb8;
use crate::error::{Error, Result};
use crate::render::image::{GBuffer, Image, SkyVisibility};
use image::ImageEncoder;
use std::io::{self, Write};
use std::path::Path;

/// JPEG quality: ours, and high, as sharp coloured edges on white are where JPEG shows its blocks.
const JPEG_QUALITY: u8 = 92;

/// A kind of picture file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PictureFormat {
    /// Portable Network Graphics.
    Png,
    /// JPEG.
    Jpeg,
    /// WebP, lossless.
    WebP,
    /// Portable pixmap.
    Ppm,
    /// NumPy array.
    Npy,
}

impl PictureFormat {
    /// All of them.
    pub const ALL: [PictureFormat; 5] =
        [PictureFormat::Png, PictureFormat::Jpeg, PictureFormat::WebP, PictureFormat::Ppm, PictureFormat::Npy];

    /// The file name extensions, the usual one first.
    #[must_use]
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            PictureFormat::Png => &["png"],
            PictureFormat::Jpeg => &["jpg", "jpeg"],
            PictureFormat::WebP => &["webp"],
            PictureFormat::Ppm => &["ppm"],
            PictureFormat::Npy => &["npy"],
        }
    }

    /// The format of a name such as `png`, in any case.
    #[must_use]
    pub fn from_name(name: &str) -> Option<PictureFormat> {
        let name = name.to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.extensions().contains(&name.as_str()))
    }

    /// The format that the extension of a file name asks for.
    ///
    /// # Errors
    /// [`Error::Unsupported`] naming the extensions there are.
    pub fn from_path(path: &Path) -> Result<PictureFormat> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().into_owned());
        let known = ".png, .jpg, .webp, .ppm or .npy";
        match extension {
            Some(extension) => Self::from_name(&extension).ok_or_else(|| {
                let name = path.display();
                Error::Unsupported(format!("{name}: .{extension} is no picture format; use {known}"))
            }),
            None => {
                Err(Error::Unsupported(format!("{}: the name says no picture format; use {known}", path.display())))
            }
        }
    }

    /// Whether the file can be see-through.
    #[must_use]
    pub fn holds_alpha(self) -> bool {
        matches!(self, PictureFormat::Png | PictureFormat::WebP | PictureFormat::Npy)
    }

    /// Whether the file says how many pixels make an inch.
    #[must_use]
    pub fn holds_resolution(self) -> bool {
        matches!(self, PictureFormat::Png | PictureFormat::Jpeg)
    }

    /// Whether the file holds depth, normals, ids and the sky's part.
    #[must_use]
    pub fn holds_channels(self) -> bool {
        matches!(self, PictureFormat::Png | PictureFormat::Npy)
    }

    /// The longest side in pixels.
    #[must_use]
    pub fn max_side(self) -> u32 {
        match self {
            PictureFormat::Jpeg => 65_535,         // ITU-T T.81: 16 bits
            PictureFormat::WebP => 16_383,         // RFC 9649: 14 bits
            PictureFormat::Png => i32::MAX as u32, // PNG 3rd edition, 4.1: 31 bits
            PictureFormat::Ppm | PictureFormat::Npy => u32::MAX,
        }
    }
}

/// What a picture shows, as it has to be known before the first row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Layer {
    /// The picture.
    Color,
    /// Depth in ångström; a PNG scales it from the smallest to the largest depth of the whole picture ([`depth_range`]).
    Depth {
        /// The smallest.
        near: f32,
        /// The largest.
        far: f32,
    },
    /// Normals in view space.
    Normal,
    /// What is seen.
    Id,
    /// How much of the sky the surface sees.
    Ao,
}

/// The pixels of a picture or of some of its rows.
#[derive(Debug, Clone, Copy)]
pub enum Content<'a> {
    /// The picture.
    Color(&'a Image),
    /// Depth in ångström.
    Depth(&'a GBuffer),
    /// Normals in view space.
    Normal(&'a GBuffer),
    /// What is seen.
    Id(&'a GBuffer),
    /// How much of the sky the surface sees.
    Ao(&'a SkyVisibility),
}

impl Content<'_> {
    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        match self {
            Content::Color(image) => (image.width, image.height),
            Content::Ao(sky) => (sky.width, sky.height),
            Content::Depth(buffer) | Content::Normal(buffer) | Content::Id(buffer) => (buffer.width, buffer.height),
        }
    }

    /// What it shows; the range of depths is its own.
    #[must_use]
    pub fn layer(&self) -> Layer {
        match self {
            Content::Color(_) => Layer::Color,
            Content::Depth(buffer) => {
                let (near, far) = depth_range(&buffer.depth).unwrap_or((0.0, 0.0));
                Layer::Depth { near, far }
            }
            Content::Normal(_) => Layer::Normal,
            Content::Id(_) => Layer::Id,
            Content::Ao(_) => Layer::Ao,
        }
    }

    /// Whether width, height and the number of values agree.
    fn is_consistent(&self) -> bool {
        let (width, height) = self.size();
        let pixels = (width as usize).checked_mul(height as usize);
        let found = match self {
            Content::Color(image) if image.rgba.len().is_multiple_of(4) => image.rgba.len() / 4,
            Content::Color(_) => return false,
            Content::Depth(buffer) => buffer.depth.len(),
            Content::Normal(buffer) => buffer.normal.len(),
            Content::Id(buffer) => buffer.id.len(),
            Content::Ao(sky) => sky.open.len(),
        };
        pixels == Some(found) && found > 0
    }
}

/// How a picture file is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PictureOptions {
    /// Whether the file has an alpha channel, if its format can have one (NPY always has). Default: no.
    pub alpha: bool,
    /// What see-through pixels are flattened on in a file without alpha. Default: white.
    pub background: Srgb8,
    /// Pixels an inch, where the format has a place for it. Default: none.
    pub dpi: Option<u32>,
    /// Metadata: keyword (1–79 ASCII characters) and text. Default: none.
    pub texts: Vec<(String, String)>,
}

impl Default for PictureOptions {
    fn default() -> Self {
        PictureOptions { alpha: false, background: Srgb8::WHITE, dpi: None, texts: Vec::new() }
    }
}

/// Said of pixels that are no picture, or not of this one.
const TORN: &str = "the picture has no pixels, or another number than its width and height say";

/// The smallest and largest depth that is not the background's; `None` if there is none.
#[must_use]
pub fn depth_range(depths: &[f32]) -> Option<(f32, f32)> {
    let finite = depths.iter().copied().filter(|depth| depth.is_finite());
    finite.fold(None, |range: Option<(f32, f32)>, depth| {
        Some(range.map_or((depth, depth), |(near, far)| (near.min(depth), far.max(depth))))
    })
}

/// Writes a picture.
///
/// # Errors
/// What the writer returns, and `InvalidInput` where the format cannot hold the picture (a channel in a JPEG, too
/// many pixels).
pub fn write(
    content: Content<'_>,
    format: PictureFormat,
    options: &PictureOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    if !content.is_consistent() {
        return refuse(TORN.to_owned()); // before anything is written
    }
    let mut file = PictureFile::new(content.size(), content.layer(), format, options, out)?;
    file.strip(content)?;
    file.finish()
}

/// A picture file that gets its rows in strips from the top. All but JPEG and WebP are written as the strips come.
pub struct PictureFile<'a> {
    width: u32,
    rows_left: u32,
    layer: Layer,
    sink: Sink<'a>,
}

/// Where strips go.
enum Sink<'a> {
    Png(Box<PngFile<'a>>),
    Npy(&'a mut dyn Write),
    Ppm(&'a mut dyn Write, Srgb8),
    /// Gathered for an encoder that wants all at once.
    Whole(Whole<'a>),
}

impl<'a> PictureFile<'a> {
    /// Starts a file of `size` (width and height) pixels. A depth's range matters for PNG only.
    ///
    /// # Errors
    /// What the writer returns, and `InvalidInput` where the format cannot hold the picture.
    pub fn new(
        size: (u32, u32),
        layer: Layer,
        format: PictureFormat,
        options: &PictureOptions,
        out: &'a mut dyn Write,
    ) -> io::Result<PictureFile<'a>> {
        let (width, height) = size;
        let name = format.extensions()[0];
        if width == 0 || height == 0 {
            return refuse("the picture has no pixels".to_owned());
        }
        if width.max(height) > format.max_side() {
            let limit = format.max_side();
            return refuse(format!(
                "{width}×{height} pixels are too many for {name}: it has at most {limit} a side; use png"
            ));
        }
        if layer != Layer::Color && !format.holds_channels() {
            return refuse(format!("{name} holds no channels; use png or npy"));
        }
        let sink = match format {
            PictureFormat::Png => Sink::Png(Box::new(PngFile::new(size, layer, options, out)?)),
            PictureFormat::Npy => {
                npy::begin(size, layer, out)?;
                Sink::Npy(out)
            }
            PictureFormat::Ppm => {
                write!(out, "P6\n{width} {height}\n255\n")?;
                Sink::Ppm(out, options.background)
            }
            PictureFormat::Jpeg | PictureFormat::WebP => {
                let channels = if format.holds_alpha() && options.alpha { 4 } else { 3 };
                let bytes = u64::from(width) * u64::from(height) * u64::from(channels);
                let mut pixels = Vec::new();
                let has_room = usize::try_from(bytes).is_ok_and(|bytes| pixels.try_reserve_exact(bytes).is_ok());
                if !has_room {
                    return refuse(format!("{width}×{height} pixels of {name} do not fit into memory; use png"));
                }
                Sink::Whole(Whole { pixels, channels, size, format, out, options: options.clone() })
            }
        };
        Ok(PictureFile { width, rows_left: height, layer, sink })
    }

    /// Writes the next rows, as wide as the picture.
    ///
    /// # Errors
    /// What the writer returns, and `InvalidInput` if this is no strip of this picture.
    pub fn strip(&mut self, content: Content<'_>) -> io::Result<()> {
        let (width, height) = content.size();
        let same_layer = matches!(
            (content, self.layer),
            (Content::Color(_), Layer::Color)
                | (Content::Depth(_), Layer::Depth { .. })
                | (Content::Normal(_), Layer::Normal)
                | (Content::Id(_), Layer::Id)
                | (Content::Ao(_), Layer::Ao)
        );
        if !content.is_consistent() || !same_layer || width != self.width || height > self.rows_left {
            return refuse(TORN.to_owned());
        }
        self.rows_left -= height;
        match (&mut self.sink, content) {
            (Sink::Png(file), _) => file.strip(content),
            (Sink::Npy(out), _) => npy::strip(content, out),
            (Sink::Ppm(out, background), Content::Color(image)) => {
                let mut rgb = vec![0; width as usize * 3];
                for row in image.rgba.chunks_exact(width as usize * 4) {
                    flattened(row, *background, &mut rgb);
                    out.write_all(&rgb)?;
                }
                Ok(())
            }
            (Sink::Whole(whole), Content::Color(image)) => {
                whole.add(image);
                Ok(())
            }
            _ => refuse("this format holds no channels; use png or npy".to_owned()),
        }
    }

    /// Ends the file.
    ///
    /// # Errors
    /// What the writer returns, and `InvalidInput` if rows are missing.
    pub fn finish(self) -> io::Result<()> {
        if self.rows_left > 0 {
            return refuse(format!("{} rows of the picture are missing", self.rows_left));
        }
        match self.sink {
            Sink::Png(file) => file.finish(),
            Sink::Npy(_) | Sink::Ppm(..) => Ok(()),
            Sink::Whole(whole) => whole.write(),
        }
    }
}

/// All pixels of a JPEG or WebP.
struct Whole<'a> {
    pixels: Vec<u8>,
    /// 4 with alpha, else 3.
    channels: u8,
    size: (u32, u32),
    format: PictureFormat,
    out: &'a mut dyn Write,
    options: PictureOptions,
}

impl Whole<'_> {
    fn add(&mut self, image: &Image) {
        if self.channels == 4 {
            self.pixels.extend_from_slice(&image.rgba);
        } else {
            let start = self.pixels.len();
            self.pixels.resize(start + image.rgba.len() / 4 * 3, 0);
            flattened(&image.rgba, self.options.background, &mut self.pixels[start..]);
        }
    }

    fn write(self) -> io::Result<()> {
        let (width, height) = self.size;
        if self.format == PictureFormat::Jpeg {
            return write_jpeg(&self.pixels, self.size, &self.options, self.out);
        }
        let color = if self.channels == 4 { image::ExtendedColorType::Rgba8 } else { image::ExtendedColorType::Rgb8 };
        let encoder = image::codecs::webp::WebPEncoder::new_lossless(self.out);
        encoder.write_image(&self.pixels, width, height, color).map_err(io_error)
    }
}

/// The metadata goes into a comment segment (ITU-T T.81, B.2.4.5) after JFIF's, which has to be the first.
fn write_jpeg(
    rgb: &[u8],
    (width, height): (u32, u32),
    options: &PictureOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut bytes = Vec::new();
    let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY);
    if let Some(dpi) = options.dpi.and_then(|dpi| u16::try_from(dpi).ok()) {
        encoder.set_pixel_density(image::codecs::jpeg::PixelDensity::dpi(dpi));
    }
    encoder.write_image(rgb, width, height, image::ExtendedColorType::Rgb8).map_err(io_error)?;
    let comment = options.texts.iter().map(|(key, text)| format!("{key}: {text}")).collect::<Vec<_>>().join("\n");
    let start = match bytes.get(2..6) {
        Some(&[0xFF, 0xE0, high, low]) => 4 + usize::from(u16::from_be_bytes([high, low])),
        _ => 2,
    };
    let start = start.min(bytes.len());
    out.write_all(&bytes[..start])?;
    // A segment's length is 16 bits and counts its own two bytes; a longer text is left out, not cut in the middle.
    if let Some(length) = u16::try_from(comment.len() + 2).ok().filter(|_| !comment.is_empty()) {
        out.write_all(&[0xFF, 0xFE])?;
        out.write_all(&length.to_be_bytes())?;
        out.write_all(comment.as_bytes())?;
    }
    out.write_all(&bytes[start..])
}

fn refuse<T>(message: String) -> io::Result<T> {
    Err(io::Error::new(io::ErrorKind::InvalidInput, message))
}

fn io_error(error: image::ImageError) -> io::Error {
    match error {
        image::ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// Straight sRGB pixels over a background, as RGB.
pub(super) fn flattened(rgba: &[u8], background: Srgb8, rgb: &mut [u8]) {
    let background = [background.r, background.g, background.b];
    for (pixel, out) in rgba.chunks_exact(4).zip(rgb.chunks_exact_mut(3)) {
        if pixel[3] == 255 {
            out.copy_from_slice(&pixel[..3]);
            continue;
        }
        let alpha = u32::from(pixel[3]);
        for ((out, &over), under) in out.iter_mut().zip(pixel).zip(background) {
            let sum = u32::from(over) * alpha + u32::from(under) * (255 - alpha);
            *out = ((sum + 127) / 255) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> Image {
        Image { width: 2, height: 1, rgba: vec![255, 0, 0, 255, 0, 0, 0, 0] }
    }

    fn bytes(content: Content<'_>, format: PictureFormat, options: &PictureOptions) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(content, format, options, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn the_extension_chooses_and_an_unknown_one_is_an_error_that_lists_them() {
        assert_eq!(PictureFormat::from_path(Path::new("a/b.JPEG")).unwrap(), PictureFormat::Jpeg);
        let error = PictureFormat::from_path(Path::new("fig.tiff")).unwrap_err().to_string();
        assert!(error.contains(".tiff") && error.contains(".png"), "{error}");
        assert!(PictureFormat::from_path(Path::new("fig")).unwrap_err().to_string().contains("says no picture format"));
    }

    #[test]
    fn formats_without_alpha_flatten_on_the_background() {
        let options = PictureOptions { background: Srgb8::rgb(0, 0, 255), ..PictureOptions::default() };
        let ppm = bytes(Content::Color(&image()), PictureFormat::Ppm, &options);
        assert!(ppm.starts_with(b"P6"));
        assert!(ppm.ends_with(&[255, 0, 0, 0, 0, 255]));
        let jpeg = bytes(Content::Color(&image()), PictureFormat::Jpeg, &options);
        assert_eq!(jpeg[..3], [0xFF, 0xD8, 0xFF]);
    }

    #[test]
    fn half_transparent_is_half_way() {
        let mut rgb = [9; 3];
        flattened(&[200, 0, 0, 128], Srgb8::rgb(0, 100, 0), &mut rgb);
        assert_eq!(rgb, [100, 50, 0]);
    }

    #[test]
    fn webp_keeps_every_pixel() {
        for rgba in [vec![255, 0, 0, 255, 9, 8, 7, 255], vec![255, 0, 0, 255, 1, 2, 3, 100]] {
            let image = Image { width: 2, height: 1, rgba };
            let options = PictureOptions { alpha: true, ..PictureOptions::default() };
            let file = bytes(Content::Color(&image), PictureFormat::WebP, &options);
            let back = image::load_from_memory_with_format(&file, image::ImageFormat::WebP).unwrap();
            assert_eq!(back.to_rgba8().as_raw(), &image.rgba);
        }
    }

    #[test]
    fn a_jpeg_carries_its_metadata_as_a_comment_and_still_decodes() {
        let options =
            PictureOptions { texts: vec![("Software".into(), "ballstick".into())], ..PictureOptions::default() };
        let file = bytes(Content::Color(&image()), PictureFormat::Jpeg, &options);
        assert_eq!(&file[2..11], b"\xFF\xE0\0\x10JFIF\0");
        assert_eq!(&file[20..24], [0xFF, 0xFE, 0, 21]);
        assert_eq!(&file[24..43], b"Software: ballstick");
        let back = image::load_from_memory_with_format(&file, image::ImageFormat::Jpeg).unwrap();
        assert_eq!((back.width(), back.height()), (2, 1));
    }

    #[test]
    fn a_jpeg_says_its_resolution() {
        let options = PictureOptions { dpi: Some(600), ..PictureOptions::default() };
        let file = bytes(Content::Color(&image()), PictureFormat::Jpeg, &options);
        // JFIF 1.02: the unit 1 is the inch, then 16 bits across and down.
        assert_eq!(file[13..18], [1, 2, 88, 2, 88]);
    }

    /// A picture and its channels, all different in every row.
    fn large(width: u32, height: u32) -> (Image, GBuffer) {
        let pixels = width * height;
        let id = (0..pixels).collect();
        let depth = (0..pixels).map(|i| if i % 7 == 0 { f32::INFINITY } else { i as f32 * 0.25 }).collect();
        let normal = (0..pixels).map(|i| [(i as f32).sin(), (i as f32).cos(), 0.0]).collect();
        let rgba =
            (0..pixels).flat_map(|i| [i as u8, (i / width) as u8, (i >> 8) as u8, 255 - (i % 5) as u8]).collect();
        (Image { width, height, rgba }, GBuffer { width, height, id, depth, normal })
    }

    fn rows(image: &Image, buffer: &GBuffer, start: u32, count: u32) -> (Image, GBuffer) {
        let width = image.width;
        let (from, to) = ((start * width) as usize, ((start + count) * width) as usize);
        let surface = GBuffer {
            width,
            height: count,
            id: buffer.id[from..to].to_vec(),
            depth: buffer.depth[from..to].to_vec(),
            normal: buffer.normal[from..to].to_vec(),
        };
        (Image { width, height: count, rgba: image.rgba[from * 4..to * 4].to_vec() }, surface)
    }

    #[test]
    fn a_file_made_of_strips_is_the_one_made_at_once() {
        let (image, buffer) = large(1500, 384);
        fn make<'a>(image: &'a Image, buffer: &'a GBuffer) -> [Content<'a>; 4] {
            [Content::Color(image), Content::Depth(buffer), Content::Normal(buffer), Content::Id(buffer)]
        }
        for (index, content) in make(&image, &buffer).into_iter().enumerate() {
            for format in PictureFormat::ALL {
                if index > 0 && !format.holds_channels() {
                    continue;
                }
                for alpha in [false, true] {
                    let options = PictureOptions { alpha, ..PictureOptions::default() };
                    let mut file = Vec::new();
                    let mut writer =
                        PictureFile::new(content.size(), content.layer(), format, &options, &mut file).unwrap();
                    for start in (0..384).step_by(128) {
                        let (image, buffer) = rows(&image, &buffer, start, 128);
                        writer.strip(make(&image, &buffer)[index]).unwrap();
                    }
                    writer.finish().unwrap();
                    assert!(file == bytes(content, format, &options), "{format:?} {index} {alpha}");
                }
            }
        }
    }

    #[test]
    fn strips_that_do_not_fit_and_missing_rows_are_refused() {
        let (image, buffer) = large(4, 8);
        let (part, _) = rows(&image, &buffer, 0, 5);
        let options = PictureOptions::default();
        for format in PictureFormat::ALL {
            let mut file = Vec::new();
            let mut writer = PictureFile::new((4, 8), Layer::Color, format, &options, &mut file).unwrap();
            writer.strip(Content::Color(&part)).unwrap();
            assert!(writer.strip(Content::Color(&part)).is_err(), "too many rows");
            assert!(writer.strip(Content::Id(&buffer)).is_err(), "another layer");
            let narrow = Image { width: 2, height: 1, rgba: vec![0; 8] };
            assert!(writer.strip(Content::Color(&narrow)).is_err(), "another width");
            assert!(writer.finish().unwrap_err().to_string().contains("3 rows"));
        }
        assert!(PictureFile::new((0, 8), Layer::Color, PictureFormat::Png, &options, &mut Vec::new()).is_err());
    }

    #[test]
    fn what_a_format_cannot_hold_is_refused() {
        let buffer = GBuffer { width: 1, height: 1, id: vec![1], depth: vec![1.0], normal: vec![[0.0, 0.0, 1.0]] };
        let mut out = Vec::new();
        let error = write(Content::Id(&buffer), PictureFormat::Jpeg, &PictureOptions::default(), &mut out).unwrap_err();
        assert!(error.to_string().contains("png or npy"));
        let wide = Image { width: 20_000, height: 1, rgba: vec![0; 80_000] };
        let error =
            write(Content::Color(&wide), PictureFormat::WebP, &PictureOptions::default(), &mut out).unwrap_err();
        assert!(error.to_string().contains("16383"), "{error}");
        let torn = Image { width: 3, height: 3, rgba: vec![0; 5] };
        assert!(write(Content::Color(&torn), PictureFormat::Png, &PictureOptions::default(), &mut out).is_err());
        assert!(out.is_empty());
    }
}
