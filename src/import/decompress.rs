//! Decompression: gzip (RFC 1952), with several members one after another, and gzip within gzip.
//!
//! Inflated in pieces with the limits checked after each: a file is never trusted about its size. The ratio is taken
//! of what was inflated to what was consumed for it, so that a bomb stops at 16 MiB, not at its end.

use super::Limits;
use crate::error::{Error, Result};
use crate::structure::Diagnostics;
use flate2::bufread::MultiGzDecoder;
use std::borrow::Cow;
use std::io::{ErrorKind, Read};

/// Output up to which the ratio is not looked at: small files may be as repetitive as they like.
const FREE_BYTES: u64 = 16 << 20;
/// Layers of gzip in gzip: one is usual, two happen (a server compressing a `.gz`), more is no accident.
const MAX_LAYERS: usize = 3;

fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// Whether [`decompress`] has anything to do.
pub(super) fn is_compressed(bytes: &[u8]) -> bool {
    is_gzip(bytes) || other_archive(bytes).is_some()
}

/// Archives we know but do not open.
fn other_archive(bytes: &[u8]) -> Option<&'static str> {
    const MAGICS: [(&[u8], &str); 6] = [
        (&[0x28, 0xb5, 0x2f, 0xfd], "Zstandard"),
        (b"BZh", "bzip2"),
        (&[0xfd, b'7', b'z', b'X', b'Z', 0], "xz"),
        (b"PK\x03\x04", "ZIP"),
        (&[b'7', b'z', 0xbc, 0xaf, 0x27, 0x1c], "7-Zip"),
        (&[0x1f, 0x9d], "compress (.Z)"),
    ];
    MAGICS.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|&(_, name)| name)
}

/// The plain bytes. What is left of a damaged file is returned with an error diagnostic.
pub(super) fn decompress<'a>(bytes: &'a [u8], limits: &Limits, diagnostics: &mut Diagnostics) -> Result<Cow<'a, [u8]>> {
    let mut plain = Cow::Borrowed(bytes);
    for layer in 0.. {
        if let Some(archive) = other_archive(&plain) {
            return Err(Error::Unsupported(format!(
                "the file is compressed with {archive}, which is not read; decompress it first"
            )));
        }
        if !is_gzip(&plain) {
            break;
        }
        if layer == MAX_LAYERS {
            return Err(Error::limit(None, format!("gzip within gzip more than {MAX_LAYERS} times")));
        }
        // Of nested files the ratio of the whole counts, too.
        plain = Cow::Owned(gunzip(&plain, bytes.len(), limits, diagnostics)?);
    }
    Ok(plain)
}

fn gunzip(bytes: &[u8], file_bytes: usize, limits: &Limits, diagnostics: &mut Diagnostics) -> Result<Vec<u8>> {
    let mut decoder = MultiGzDecoder::new(bytes);
    let mut plain = Vec::new();
    let mut piece = vec![0u8; 256 << 10];
    loop {
        let read = match decoder.read(&mut piece) {
            Ok(0) => break,
            Ok(read) => read,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) => {
                damaged(&error, &plain, decoder.get_ref(), diagnostics)?;
                break;
            }
        };
        let inflated = (plain.len() + read) as u64;
        if inflated > limits.decompressed_bytes {
            let limit = limits.decompressed_bytes;
            return Err(Error::limit(
                None,
                format!("the file has more than {limit} bytes when decompressed (limit `decompressed_bytes`)"),
            ));
        }
        let consumed = (bytes.len() - decoder.get_ref().len()).min(file_bytes) as u64;
        if inflated > FREE_BYTES && inflated / u64::from(limits.ratio.max(1)) > consumed {
            return Err(Error::limit(
                None,
                format!("the compressed file inflates to more than {} times its size (limit `ratio`)", limits.ratio),
            ));
        }
        plain.extend_from_slice(&piece[..read]);
    }
    Ok(plain)
}

/// A damaged stream: says what is left of it, or refuses if nothing is.
fn damaged(error: &std::io::Error, plain: &[u8], rest: &[u8], diagnostics: &mut Diagnostics) -> Result<()> {
    if plain.is_empty() {
        return Err(Error::input(None, format!("the gzip data is damaged from its start ({error})")));
    }
    let kept = plain.len();
    match error.kind() {
        ErrorKind::UnexpectedEof => diagnostics.error(
            None,
            format!("the compressed file ends too early; the {kept} bytes that could be decompressed are read"),
        ),
        // The decoder failed on the header of a further member: padding or other bytes after the last one.
        _ if error.to_string().contains("header") => {
            diagnostics.warn(None, format!("{} bytes or more after the gzip data are ignored", rest.len()));
        }
        _ => diagnostics
            .error(None, format!("the gzip data is damaged ({error}); the {kept} bytes before the damage are read")),
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
        let plain = decompress(bytes, &Limits::default(), &mut diagnostics).map(Cow::into_owned);
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
        let result = decompress(&gzip(&[b'x'; 1001]), &limits, &mut Diagnostics::default()).map(Cow::into_owned);
        assert!(matches!(result, Err(Error::Limit { .. })));
    }

    #[test]
    fn other_archives_are_named() {
        let error = run(b"PK\x03\x04....").0.unwrap_err().to_string();
        assert!(error.contains("ZIP"), "{error}");
    }
}
