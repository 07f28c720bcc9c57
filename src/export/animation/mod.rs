//! Films: frames that are drawn one after the other, encoded as they come, so that their number costs no memory.
//!
//! | format | colour | see-through | made by |
//! |---|---|---|---|
//! | GIF | 255 colours, the same for all frames | yes or no | [`gif`] |
//! | APNG (`.apng`, `.png`) | 8-bit RGB or RGBA | as PNG | [`apng`] |
//! | MP4 | H.264, 4:2:0 | no | the program `ffmpeg`, if it is there ([`mp4`]) |
//!
//! All repeat for ever but MP4, which leaves that to the player. The file takes its name when all is written ([`super::atomic`]).

mod apng;
mod gif;
mod mp4;

use super::atomic;
use crate::color::Srgb8;
use crate::error::{Error, Result};
use crate::render::Image;
use std::io::{self, Write};
use std::path::Path;

/// Frames a second where nothing is said: a GIF counts hundredths of a second, of which 25 frames take four each.
pub const FPS: f64 = 25.0;

/// The most frames a second: GIF viewers show frames that are shorter than two hundredths as if they had ten.
pub const MOST_FPS: f64 = 50.0;

/// A kind of film.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AnimationFormat {
    /// Graphics Interchange Format.
    Gif,
    /// Animated PNG.
    Apng,
    /// MPEG-4 with H.264.
    Mp4,
}

impl AnimationFormat {
    /// All of them.
    pub const ALL: [AnimationFormat; 3] = [AnimationFormat::Gif, AnimationFormat::Apng, AnimationFormat::Mp4];

    /// The file name extension.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            AnimationFormat::Gif => "gif",
            AnimationFormat::Apng => "apng",
            AnimationFormat::Mp4 => "mp4",
        }
    }

    /// The format of a name such as `gif`, in any case.
    #[must_use]
    pub fn from_name(name: &str) -> Option<AnimationFormat> {
        Self::ALL.into_iter().find(|format| format.extension().eq_ignore_ascii_case(name))
    }

    /// The format that the extension of a file name asks for. `.png` is one of pictures; an animated one may have it as well.
    #[must_use]
    pub fn from_path(path: &Path) -> Option<AnimationFormat> {
        Self::from_name(path.extension()?.to_str()?)
    }

    /// Whether the file can be see-through.
    #[must_use]
    pub fn holds_alpha(self) -> bool {
        self != AnimationFormat::Mp4
    }

    /// The longest side in pixels.
    #[must_use]
    pub fn max_side(self) -> u32 {
        match self {
            AnimationFormat::Gif => 65_535,           // GIF89a, 18: 16 bits
            AnimationFormat::Apng => i32::MAX as u32, // PNG 3rd edition, 4.1: 31 bits
            AnimationFormat::Mp4 => 8_192,            // H.264, level 6.2 (table A-1), to the next power of two below
        }
    }
}

/// How a film is written.
#[derive(Debug, Clone, PartialEq)]
pub struct AnimationOptions {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// How many frames there are.
    pub frames: u32,
    /// Frames a second, up to [`MOST_FPS`].
    pub fps: f64,
    /// Whether see-through pixels stay so, if the format can.
    pub alpha: bool,
    /// What they are flattened on otherwise.
    pub background: Srgb8,
    /// Metadata, which APNG keeps.
    pub texts: Vec<(String, String)>,
}

/// What takes the frames.
trait Film {
    fn frame(&mut self, image: &Image) -> io::Result<()>;

    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// Writes a film of the frames that `draw` draws, by their numbers from 0; those that a palette is made from are drawn twice. An error of
/// `draw` ends it and leaves no file.
///
/// # Errors
/// What `draw` returns; [`Error::Io`] if the file cannot be written; [`Error::Unsupported`] if the format cannot hold it, or if
/// there is no `ffmpeg` for an MP4.
pub fn write(
    path: &Path,
    format: AnimationFormat,
    options: &AnimationOptions,
    draw: &mut dyn FnMut(u32) -> Result<Image>,
) -> Result<()> {
    let (width, height) = options.size;
    let limit = format.max_side();
    if options.frames == 0 || width == 0 || height == 0 || width.max(height) > limit {
        let name = format.extension();
        return Err(Error::Unsupported(format!(
            "{} frames of {width}×{height} pixels: {name} has at least one frame and at most {limit} pixels a side",
            options.frames
        )));
    }
    match format {
        AnimationFormat::Mp4 => {
            if atomic::is_stdout(path) {
                let message = "an mp4 is finished by going back in it, which standard output cannot; use gif or apng";
                return Err(Error::Unsupported(message.to_owned()));
            }
            let ffmpeg = mp4::find()?;
            keeping_errors(draw, |draw| {
                atomic::write_by_path(path, |place| {
                    run(Box::new(mp4::Mp4::new(&ffmpeg, options, place)?), options, draw)
                })
            })
        }
        AnimationFormat::Gif => {
            let palette = gif::palette(options, draw)?;
            keeping_errors(draw, |draw| {
                atomic::write(path, |out| run(Box::new(gif::GifFile::new(palette, options, out)?), options, draw))
            })
        }
        AnimationFormat::Apng => keeping_errors(draw, |draw| {
            atomic::write(path, |out: &mut dyn Write| run(Box::new(apng::Apng::new(options, out)?), options, draw))
        }),
    }
}

/// How many frames are drawn in all, those for the palette included.
#[must_use]
pub fn drawn_frames(format: AnimationFormat, frames: u32) -> u32 {
    if format == AnimationFormat::Gif { frames.saturating_add(gif::sampled(frames).count() as u32) } else { frames }
}

/// A drawing that fails as writing does.
type Drawing<'a> = dyn FnMut(u32) -> io::Result<Image> + 'a;

/// Lets `work` draw, and gives an error of drawing back as it was.
fn keeping_errors(
    draw: &mut dyn FnMut(u32) -> Result<Image>,
    work: impl FnOnce(&mut Drawing<'_>) -> Result<()>,
) -> Result<()> {
    let mut failed = None;
    let written = work(&mut |index| {
        draw(index).map_err(|error| {
            failed = Some(error);
            io::Error::other("a frame could not be drawn")
        })
    });
    failed.map_or(written, Err)
}

fn run(mut film: Box<dyn Film + '_>, options: &AnimationOptions, draw: &mut Drawing<'_>) -> io::Result<()> {
    for index in 0..options.frames {
        let image = draw(index)?;
        let pixels = image.width as usize * image.height as usize;
        if (image.width, image.height) != options.size || image.rgba.len() != pixels * 4 {
            return Err(io::Error::other("a frame has another size than the film"));
        }
        film.frame(&image)?;
    }
    film.finish()
}

fn rgb_of(color: Srgb8) -> [u8; 3] {
    [color.r, color.g, color.b]
}

/// The part of a picture that differs from another one: x, y, width, height; `None` if nothing does.
fn changed(width: usize, differs: impl Fn(usize) -> bool, pixels: usize) -> Option<[usize; 4]> {
    let (mut left, mut right, mut top, mut bottom) = (usize::MAX, 0, usize::MAX, 0);
    for index in (0..pixels).filter(|&index| differs(index)) {
        let (x, y) = (index % width, index / width);
        (left, right) = (left.min(x), right.max(x));
        (top, bottom) = (top.min(y), bottom.max(y));
    }
    (left <= right).then(|| [left, top, right + 1 - left, bottom + 1 - top])
}

#[cfg(test)]
mod tests;
