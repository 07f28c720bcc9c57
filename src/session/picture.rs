//! Sessions within pictures: what a picture file says of itself, so that it can be made again.
//!
//! PNG files hold it in a text chunk of its own (tEXt or iTXt, PNG 3rd edition, 11.3.3), JPEG files in a line of the comment segment
//! (ITU-T T.81, B.2.4.5). WebP, PPM, NPY, GIF and MP4 files hold nothing.

use super::Session;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The keyword of the text.
pub const KEYWORD: &str = "ballstick-session";

/// How the picture of a session is made, by the names of the flags; what a session that was saved in the window says nothing of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// `--size`: in pixels, or in print.
    pub size: String,
    /// `--dpi`.
    pub dpi: Option<u32>,
    /// `--region`.
    pub region: Option<String>,
    /// `--crop`.
    pub crop: Option<String>,
    /// `--samples`.
    pub samples: u32,
    /// `--ao`.
    pub ao: u32,
    /// `--channel`.
    pub channel: String,
    /// `--renderer` that draws the same again: `cpu` or `gpu`.
    pub renderer: String,
    /// `--view`, which a fitted camera comes from.
    pub view: Option<String>,
    /// `--axis`, likewise.
    pub axis: Option<String>,
    /// `--record`: then the frames of files are counted in it.
    pub record: Option<String>,
    /// `--turntable`.
    #[serde(default)]
    pub turntable: Option<u32>,
    /// `--frames`.
    #[serde(default)]
    pub frames: Option<String>,
    /// `--fps`.
    #[serde(default)]
    pub fps: Option<f64>,
}

/// What a file begins with.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG: &[u8] = b"\xff\xd8\xff";

/// Whether bytes begin like a picture that may hold a session.
#[must_use]
pub(super) fn is_picture(start: &[u8]) -> bool {
    start.starts_with(PNG) || start.starts_with(JPEG)
}

/// The session in a picture; its paths are relative to this folder.
///
/// # Errors
/// [`Error::Input`] if the picture holds none, or a broken one.
pub(super) fn session_in(bytes: &[u8], folder: &Path) -> Result<Session> {
    let text = if bytes.starts_with(PNG) { png_text(bytes) } else { jpeg_text(bytes) };
    let text = text.ok_or_else(|| {
        let message = "the picture does not say how it was made: ballstick writes it into PNG and JPEG files, and programs that edit \
                       pictures often leave it out";
        Error::input(None, message)
    })?;
    Session::parse(text.as_bytes(), folder)
}

fn png_text(bytes: &[u8]) -> Option<String> {
    let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().ok()?;
    let info = reader.info();
    let latin = info.uncompressed_latin1_text.iter().find(|text| text.keyword == KEYWORD).map(|text| text.text.clone());
    latin.or_else(|| info.utf8_text.iter().find(|text| text.keyword == KEYWORD)?.get_text().ok())
}

/// Segments one after the other up to the pixels.
fn jpeg_text(bytes: &[u8]) -> Option<String> {
    let mut rest = bytes.get(2..)?;
    loop {
        let &[0xFF, marker, high, low, ..] = rest else { return None };
        if marker == 0xDA {
            return None; // the pixels
        }
        let length = usize::from(u16::from_be_bytes([high, low])).max(2);
        let content = rest.get(4..2 + length)?;
        if marker == 0xFE {
            let text = String::from_utf8_lossy(content);
            let line = text.lines().find_map(|line| line.strip_prefix(KEYWORD)?.strip_prefix(": "));
            if let Some(line) = line {
                return Some(line.to_owned());
            }
        }
        rest = rest.get(2 + length..)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::picture::{Content, PictureFormat, PictureOptions, write};
    use crate::render::Image;

    #[test]
    fn a_session_comes_back_out_of_a_picture() {
        let mut session = super::super::tests::session();
        let image = Image { width: 3, height: 2, rgba: vec![200; 24] };
        for (path, format) in
            [("a.xyz", PictureFormat::Png), ("é.xyz", PictureFormat::Png), ("é.xyz", PictureFormat::Jpeg)]
        {
            session.files[0].path = path.into();
            let texts = vec![("Software".to_owned(), "x".to_owned()), session.text(None)];
            let options = PictureOptions { texts, ..PictureOptions::default() };
            let mut bytes = Vec::new();
            write(Content::Color(&image), format, &options, &mut bytes).unwrap();
            assert!(is_picture(&bytes) && Session::is_one(&bytes));
            let read = session_in(&bytes, Path::new("/folder")).unwrap();
            assert!(read.files[0].path.ends_with(path), "{:?}", read.files);
            assert_eq!(read.picture, session.picture);
            // Cut anywhere it is an error and never a panic.
            for end in 0..bytes.len() {
                let _ = session_in(&bytes[..end], Path::new(""));
            }
        }
        let mut plain = Vec::new();
        write(Content::Color(&image), PictureFormat::Png, &PictureOptions::default(), &mut plain).unwrap();
        assert!(!Session::is_one(&plain));
        assert!(session_in(&plain, Path::new("")).unwrap_err().to_string().contains("does not say how"));
    }
}
