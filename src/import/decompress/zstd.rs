//! Zstandard frames (RFC 8878), skippable ones among them.
//!
//! Limits: frames that need a dictionary, or a window over 128 MiB (`--long=28` and more), are refused.

use super::{Damage, Output, report};
use crate::error::{Error, Result};
use crate::structure::Diagnostics;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};
use std::io::Read;

/// Largest window: what the reference decoder takes unasked, too (`ZSTD_WINDOWLOG_LIMIT_DEFAULT`, 27).
const MAX_WINDOW_BYTES: u64 = 128 << 20;
/// An empty raw block that is the last one, and room for a checksum (RFC 8878, 3.1.1.2).
const LAST_BLOCK: [u8; 7] = [1, 0, 0, 0, 0, 0, 0];

/// Whether the bytes begin with a frame, or with a skippable one as parallel compressors write.
pub(super) fn is_zstd(bytes: &[u8]) -> bool {
    matches!(bytes, [0x28, 0xb5, 0x2f, 0xfd, ..] | [0x50..=0x5f, 0x2a, 0x4d, 0x18, ..])
}

pub(super) fn inflate(bytes: &[u8], output: &mut Output<'_>, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut decoder = FrameDecoder::new();
    decoder.set_max_window_size(MAX_WINDOW_BYTES);
    let mut piece = vec![0u8; 256 << 10];
    let mut rest = bytes;
    let mut frames = 0u64;
    while !rest.is_empty() {
        let at_frame = rest;
        match decoder.init(&mut rest) {
            Ok(()) => {}
            Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                let length = usize::try_from(length).unwrap_or(usize::MAX);
                rest = rest.get(length..).unwrap_or_default();
                continue;
            }
            Err(FrameDecoderError::WindowSizeTooBig { requested, max }) => {
                let message = format!("decompressing needs a window of {requested} bytes; at most {max} are given");
                return Err(Error::limit(None, format!("{message} (compress without `--long`)")));
            }
            Err(FrameDecoderError::DictNotProvided { .. }) => {
                let message = "the file is compressed with a Zstandard dictionary; decompress it first";
                return Err(Error::Unsupported(message.to_owned()));
            }
            Err(error) => {
                let damage = match error {
                    _ if is_zstd(at_frame) && rest.is_empty() => Damage::Cut,
                    _ if frames > 0 => Damage::Trailing(at_frame.len()),
                    error => Damage::Broken(error.to_string()),
                };
                return report(&damage, "Zstandard", output, diagnostics);
            }
        }
        frames += 1;
        let damage = frame(&mut decoder, bytes, &mut rest, &mut piece, output)?;
        if let Some(damage) = damage {
            return report(&damage, "Zstandard", output, diagnostics);
        }
        let (stated, found) = (decoder.get_checksum_from_data(), decoder.get_calculated_checksum());
        if stated.is_some() && stated != found {
            let message = "the checksum of the Zstandard data is not that of its content; some of it may be wrong";
            diagnostics.error(None, message);
        }
    }
    Ok(())
}

/// Decodes the blocks of a frame.
fn frame(
    decoder: &mut FrameDecoder,
    bytes: &[u8],
    rest: &mut &[u8],
    piece: &mut [u8],
    output: &mut Output<'_>,
) -> Result<Option<Damage>> {
    let mut damage = None;
    while !decoder.is_finished() && damage.is_none() {
        if let Err(error) = decoder.decode_blocks(&mut *rest, BlockDecodingStrategy::UptoBlocks(1)) {
            damage = Some(if rest.is_empty() { Damage::Cut } else { Damage::Broken(error.to_string()) });
            // The decoder holds a window back until the frame ends: end it.
            if decoder.decode_blocks(&mut &LAST_BLOCK[..], BlockDecodingStrategy::UptoBlocks(1)).is_err() {
                break;
            }
        }
        let consumed = bytes.len() - rest.len();
        while decoder.can_collect() > 0 {
            match decoder.read(piece) {
                Ok(0) => break,
                Ok(read) => output.push(&piece[..read], consumed)?,
                Err(error) => {
                    damage = Some(Damage::Broken(error.to_string()));
                    break;
                }
            }
        }
    }
    Ok(damage)
}

#[cfg(test)]
mod tests {
    use super::super::super::Limits;
    use super::super::decompress;
    use super::*;
    use crate::stop::Stop;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};
    use std::borrow::Cow;

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        compress_to_vec(bytes, CompressionLevel::Fastest)
    }

    fn run(bytes: &[u8]) -> (Result<Vec<u8>>, usize) {
        let mut diagnostics = Diagnostics::default();
        let plain = decompress(bytes, &Limits::default(), &Stop::never(), &mut diagnostics).map(Cow::into_owned);
        (plain, diagnostics.into_list().len())
    }

    /// Text that compresses about as coordinates do.
    fn numbers() -> Vec<u8> {
        (0..60_000u32).flat_map(|i| format!("{}\n", i.wrapping_mul(2_654_435_761)).into_bytes()).collect()
    }

    #[test]
    fn frames_follow_one_another_and_nest() {
        let skippable = [&[0x5a, 0x2a, 0x4d, 0x18, 3, 0, 0, 0][..], b"any"].concat();
        let frames = [skippable.clone(), zstd(b"one "), skippable, zstd(b"two")].concat();
        let (plain, notes) = run(&frames);
        assert_eq!((plain.unwrap(), notes), (b"one two".to_vec(), 0));
        assert_eq!(run(&zstd(&zstd(b"deep"))).0.unwrap(), b"deep");
        assert!(matches!(run(&zstd(&zstd(&zstd(&zstd(b"too deep"))))).0, Err(Error::Limit { .. })));
        assert_eq!(run(&zstd(&numbers())).0.unwrap(), numbers());
    }

    #[test]
    fn a_cut_frame_gives_its_part_and_says_so() {
        let (text, packed) = (numbers(), zstd(&numbers()));
        let (plain, notes) = run(&packed[..packed.len() / 2]);
        let plain = plain.unwrap();
        assert!(plain.len() > text.len() / 4 && text.starts_with(&plain));
        assert_eq!(notes, 1);
        assert!(run(&packed[..8]).0.is_err());
        for end in 0..40 {
            let _any = run(&packed[..end]);
        }
    }

    #[test]
    fn bytes_after_the_frames_are_ignored() {
        let (plain, notes) = run(&[zstd(b"text"), b"\0\0\0\0 garbage and more garbage".to_vec()].concat());
        assert_eq!((plain.unwrap(), notes), (b"text".to_vec(), 1));
    }

    #[test]
    fn a_wrong_checksum_is_an_error_of_the_file() {
        let mut packed = zstd(&numbers());
        let last = packed.len() - 1;
        packed[last] ^= 1;
        let (plain, notes) = run(&packed);
        assert_eq!((plain.unwrap(), notes), (numbers(), 1));
    }

    #[test]
    fn bombs_stop_at_their_ratio_and_at_the_size_limit() {
        // 400 blocks of 128 KiB, four bytes each (RFC 8878, 3.1.1.2: run-length blocks).
        let mut bomb = vec![0x28, 0xb5, 0x2f, 0xfd, 0, 0x50];
        for block in 0..400 {
            let header = ((128u32 << 10) << 3) | (1 << 1) | u32::from(block == 399);
            bomb.extend_from_slice(&header.to_le_bytes()[..3]);
            bomb.push(b' ');
        }
        assert!(matches!(run(&bomb).0, Err(Error::Limit { .. })));
        assert!(matches!(run(&zstd(&bomb)).0, Err(Error::Limit { .. })));
        let limits = Limits { decompressed_bytes: 1000, ..Limits::default() };
        let result =
            decompress(&zstd(&[b'x'; 1001]), &limits, &Stop::never(), &mut Diagnostics::default()).map(Cow::into_owned);
        assert!(matches!(result, Err(Error::Limit { .. })));
    }

    #[test]
    fn a_window_too_large_is_refused() {
        let header = [0x28, 0xb5, 0x2f, 0xfd, 0, 0xff, 1, 0, 0];
        assert!(run(&header).0.is_err());
        let header = [0x28, 0xb5, 0x2f, 0xfd, 0, 0x90, 1, 0, 0];
        assert!(matches!(run(&header).0, Err(Error::Limit { .. })));
    }
}
