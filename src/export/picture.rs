//! Picture files: what a renderer hands back, in the format the name asks for.
//!
//! | format | colour | channels | metadata |
//! |---|---|---|---|
//! | PNG | 8-bit RGB, RGBA (straight alpha) if any pixel is not opaque; sRGB chunk | 16-bit, below | text chunks |
//! | JPEG | quality 92, alpha flattened | – | a comment |
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
//!
//! Flattening composites the stored sRGB values over the background, as browsers and viewers do with the PNG.

use super::{npy, png};
use crate::color::Srgb8;
use crate::error::{Error, Result};
use crate::render::image::{GBuffer, Image};
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

    /// Whether the file holds depth, normals and ids.
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

/// What goes into the file.
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
}

impl Content<'_> {
    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        match self {
            Content::Color(image) => (image.width, image.height),
            Content::Depth(buffer) | Content::Normal(buffer) | Content::Id(buffer) => (buffer.width, buffer.height),
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
        };
        pixels == Some(found) && found > 0
    }
}

/// How a picture file is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PictureOptions {
    /// What see-through pixels are flattened on where the format has no alpha. Default: white.
    pub background: Srgb8,
    /// Metadata: keyword (1–79 ASCII characters) and text. Default: none.
    pub texts: Vec<(String, String)>,
}

impl Default for PictureOptions {
    fn default() -> Self {
        PictureOptions { background: Srgb8::WHITE, texts: Vec::new() }
    }
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
    let refuse = |message: String| Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    if !content.is_consistent() {
        return refuse("the picture has no pixels, or another number than its width and height say".to_owned());
    }
    let (width, height) = content.size();
    if width.max(height) > format.max_side() {
        let (name, limit) = (format.extensions()[0], format.max_side());
        return refuse(format!(
            "{width}×{height} pixels are too many for {name}: it has at most {limit} a side; use png"
        ));
    }
    match (content, format) {
        (_, PictureFormat::Npy) => npy::write(content, out),
        (_, PictureFormat::Png) => png::write(content, options, out),
        (Content::Color(image), _) => match format {
            PictureFormat::Jpeg => write_jpeg(image, options, out),
            PictureFormat::WebP => {
                let (pixels, color) = match opaque_rgb(image) {
                    Some(rgb) => (rgb.into(), image::ExtendedColorType::Rgb8),
                    None => (std::borrow::Cow::from(&image.rgba), image::ExtendedColorType::Rgba8),
                };
                image::codecs::webp::WebPEncoder::new_lossless(out)
                    .write_image(&pixels, width, height, color)
                    .map_err(io_error)
            }
            _ => {
                let subtype = image::codecs::pnm::PnmSubtype::Pixmap(image::codecs::pnm::SampleEncoding::Binary);
                image::codecs::pnm::PnmEncoder::new(out)
                    .with_subtype(subtype)
                    .write_image(&flattened(image, options.background), width, height, image::ExtendedColorType::Rgb8)
                    .map_err(io_error)
            }
        },
        _ => refuse(format!("{} holds no channels; use png or npy", format.extensions()[0])),
    }
}

/// The metadata goes into a comment segment (ITU-T T.81, B.2.4.5) right after the start of image.
fn write_jpeg(image: &Image, options: &PictureOptions, out: &mut dyn Write) -> io::Result<()> {
    let mut bytes = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
        .write_image(&flattened(image, options.background), image.width, image.height, image::ExtendedColorType::Rgb8)
        .map_err(io_error)?;
    let comment = options.texts.iter().map(|(key, text)| format!("{key}: {text}")).collect::<Vec<_>>().join("\n");
    let start = bytes.len().min(2);
    out.write_all(&bytes[..start])?;
    // A segment's length is 16 bits and counts its own two bytes; a longer text is left out, not cut in the middle.
    if let Some(length) = u16::try_from(comment.len() + 2).ok().filter(|_| !comment.is_empty()) {
        out.write_all(&[0xFF, 0xFE])?;
        out.write_all(&length.to_be_bytes())?;
        out.write_all(comment.as_bytes())?;
    }
    out.write_all(&bytes[start..])
}

fn io_error(error: image::ImageError) -> io::Error {
    match error {
        image::ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// The pixels without alpha, if all are opaque.
pub(super) fn opaque_rgb(image: &Image) -> Option<Vec<u8>> {
    let opaque = image.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255);
    opaque.then(|| flattened(image, Srgb8::WHITE))
}

/// The pixels over a background.
fn flattened(image: &Image, background: Srgb8) -> Vec<u8> {
    let background = [background.r, background.g, background.b];
    let mut rgb = Vec::with_capacity(image.rgba.len() / 4 * 3);
    for pixel in image.rgba.chunks_exact(4) {
        let alpha = u32::from(pixel[3]);
        for (&over, under) in pixel.iter().zip(background) {
            let sum = u32::from(over) * alpha + u32::from(under) * (255 - alpha);
            rgb.push(((sum + 127) / 255) as u8);
        }
    }
    rgb
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
        let half = Image { width: 1, height: 1, rgba: vec![200, 0, 0, 128] };
        assert_eq!(flattened(&half, Srgb8::rgb(0, 100, 0)), [100, 50, 0]);
    }

    #[test]
    fn webp_keeps_every_pixel() {
        for rgba in [vec![255, 0, 0, 255, 9, 8, 7, 255], vec![255, 0, 0, 255, 1, 2, 3, 100]] {
            let image = Image { width: 2, height: 1, rgba };
            let file = bytes(Content::Color(&image), PictureFormat::WebP, &PictureOptions::default());
            let back = image::load_from_memory_with_format(&file, image::ImageFormat::WebP).unwrap();
            assert_eq!(back.to_rgba8().as_raw(), &image.rgba);
        }
    }

    #[test]
    fn a_jpeg_carries_its_metadata_as_a_comment_and_still_decodes() {
        let options =
            PictureOptions { texts: vec![("Software".into(), "ballstick".into())], ..PictureOptions::default() };
        let file = bytes(Content::Color(&image()), PictureFormat::Jpeg, &options);
        assert_eq!(&file[2..6], [0xFF, 0xFE, 0, 21]);
        assert_eq!(&file[6..25], b"Software: ballstick");
        let back = image::load_from_memory_with_format(&file, image::ImageFormat::Jpeg).unwrap();
        assert_eq!((back.width(), back.height()), (2, 1));
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
