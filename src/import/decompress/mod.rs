//! Decompression: gzip (RFC 1952) and Zstandard (RFC 8878), with several members or frames one after another, and
//! either within the other.
//!
//! Inflated in pieces with the limits checked after each: a file is never trusted about its size. The ratio is taken
//! of what was inflated to what was consumed for it, so that a bomb stops at 16 MiB, not at its end.

mod gzip;
mod zstd;

use super::Limits;
use crate::error::{Error, Result};
use crate::stop::Stop;
use crate::structure::Diagnostics;
use std::borrow::Cow;

/// Output up to which the ratio is not looked at: small files may be as repetitive as they like.
const FREE_BYTES: u64 = 16 << 20;
/// Layers of compression: one is usual, two happen (a server compressing a `.gz`), more is no accident.
const MAX_LAYERS: usize = 3;

/// Whether [`decompress`] has anything to do.
pub(super) fn is_compressed(bytes: &[u8]) -> bool {
    gzip::is_gzip(bytes) || zstd::is_zstd(bytes) || other_archive(bytes).is_some()
}

/// Archives we know but do not open.
fn other_archive(bytes: &[u8]) -> Option<&'static str> {
    const MAGICS: [(&[u8], &str); 5] = [
        (b"BZh", "bzip2"),
        (&[0xfd, b'7', b'z', b'X', b'Z', 0], "xz"),
        (b"PK\x03\x04", "ZIP"),
        (&[b'7', b'z', 0xbc, 0xaf, 0x27, 0x1c], "7-Zip"),
        (&[0x1f, 0x9d], "compress (.Z)"),
    ];
    MAGICS.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|&(_, name)| name)
}

/// The plain bytes. What is left of a damaged file is returned with an error diagnostic.
pub(super) fn decompress<'a>(
    bytes: &'a [u8],
    limits: &Limits,
    stop: &Stop,
    diagnostics: &mut Diagnostics,
) -> Result<Cow<'a, [u8]>> {
    let mut plain = Cow::Borrowed(bytes);
    for layer in 0.. {
        if let Some(archive) = other_archive(&plain) {
            return Err(Error::Unsupported(format!(
                "the file is compressed with {archive}, which is not read; decompress it first"
            )));
        }
        let inflate = match &plain {
            plain if gzip::is_gzip(plain) => gzip::inflate,
            plain if zstd::is_zstd(plain) => zstd::inflate,
            _ => break,
        };
        if layer == MAX_LAYERS {
            return Err(Error::limit(None, format!("compressed more than {MAX_LAYERS} times over")));
        }
        let mut output = Output { plain: Vec::new(), file_bytes: bytes.len(), limits, stop };
        inflate(&plain, &mut output, diagnostics)?;
        plain = Cow::Owned(output.plain);
    }
    Ok(plain)
}

/// What was inflated so far, kept within the limits.
struct Output<'a> {
    plain: Vec<u8>,
    /// Bytes of the file as it lies on disk: of nested compression the ratio of the whole counts, too.
    file_bytes: usize,
    limits: &'a Limits,
    stop: &'a Stop,
}

impl Output<'_> {
    /// Adds a piece for which `consumed` bytes of the compressed data were read in all.
    fn push(&mut self, piece: &[u8], consumed: usize) -> Result<()> {
        self.stop.check()?;
        let inflated = (self.plain.len() + piece.len()) as u64;
        if inflated > self.limits.decompressed_bytes {
            let limit = self.limits.decompressed_bytes;
            return Err(Error::limit(
                None,
                format!("the file has more than {limit} bytes when decompressed (limit `decompressed_bytes`)"),
            ));
        }
        let consumed = consumed.min(self.file_bytes) as u64;
        let ratio = self.limits.ratio;
        if inflated > FREE_BYTES && inflated / u64::from(ratio.max(1)) > consumed {
            return Err(Error::limit(
                None,
                format!("the compressed file inflates to more than {ratio} times its size (limit `ratio`)"),
            ));
        }
        self.plain.extend_from_slice(piece);
        Ok(())
    }
}

/// What became of a stream that is not whole.
enum Damage {
    /// It ends before its end.
    Cut,
    /// So many bytes behind its end are something else.
    Trailing(usize),
    /// Something in it cannot be; what the decoder said.
    Broken(String),
}

/// Says what is left of a damaged stream, or refuses it if nothing is.
fn report(damage: &Damage, format: &str, output: &Output<'_>, diagnostics: &mut Diagnostics) -> Result<()> {
    let kept = output.plain.len();
    match damage {
        Damage::Cut if kept == 0 => {
            return Err(Error::input(None, format!("the {format} data ends before anything can be decompressed")));
        }
        Damage::Broken(why) if kept == 0 => {
            return Err(Error::input(None, format!("the {format} data is damaged from its start ({why})")));
        }
        Damage::Cut => diagnostics.error(
            None,
            format!("the compressed file ends too early; the {kept} bytes that could be decompressed are read"),
        ),
        Damage::Trailing(rest) => {
            diagnostics.warn(None, format!("{rest} bytes or more after the {format} data are ignored"));
        }
        Damage::Broken(why) => diagnostics
            .error(None, format!("the {format} data is damaged ({why}); the {kept} bytes before the damage are read")),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    fn run(bytes: &[u8]) -> (Result<Vec<u8>>, usize) {
        let mut diagnostics = Diagnostics::default();
        let plain = decompress(bytes, &Limits::default(), &Stop::never(), &mut diagnostics).map(Cow::into_owned);
        (plain, diagnostics.into_list().len())
    }

    #[test]
    fn members_follow_one_another_and_nest() {
        let two = [gzip(b"one "), gzip(b"two")].concat();
        assert_eq!(run(&two).0.unwrap(), b"one two");
        assert_eq!(run(&gzip(&gzip(b"deep"))).0.unwrap(), b"deep");
        assert!(matches!(run(&gzip(&gzip(&gzip(&gzip(b"too deep"))))).0, Err(Error::Limit { .. })));
    }

    #[test]
    fn a_cut_stream_gives_its_part_and_says_so() {
        let text: Vec<u8> =
            (0..20_000u32).flat_map(|i| format!("{}\n", i.wrapping_mul(2_654_435_761)).into_bytes()).collect();
        let packed = gzip(&text);
        let (plain, notes) = run(&packed[..packed.len() / 2]);
        let plain = plain.unwrap();
        assert!(!plain.is_empty() && text.starts_with(&plain));
        assert_eq!(notes, 1);
        assert!(run(&packed[..8]).0.is_err());
    }

    #[test]
    fn bytes_after_the_stream_are_ignored() {
        let (plain, notes) = run(&[gzip(b"text"), b"\0\0\0\0 garbage and more garbage".to_vec()].concat());
        assert_eq!((plain.unwrap(), notes), (b"text".to_vec(), 1));
    }

    #[test]
    fn bombs_stop_at_their_ratio() {
        let bomb = gzip(&vec![b' '; 40 << 20]);
        assert!(matches!(run(&bomb).0, Err(Error::Limit { .. })));
        assert!(matches!(run(&gzip(&bomb)).0, Err(Error::Limit { .. })));
        assert_eq!(run(&gzip(&vec![b' '; 1 << 20])).0.unwrap().len(), 1 << 20);
    }

    #[test]
    fn the_size_limit_holds() {
        let limits = Limits { decompressed_bytes: 1000, ..Limits::default() };
        let result =
            decompress(&gzip(&[b'x'; 1001]), &limits, &Stop::never(), &mut Diagnostics::default()).map(Cow::into_owned);
        assert!(matches!(result, Err(Error::Limit { .. })));
    }

    #[test]
    fn other_archives_are_named() {
        let error = run(b"PK\x03\x04....").0.unwrap_err().to_string();
        assert!(error.contains("ZIP"), "{error}");
    }
}
