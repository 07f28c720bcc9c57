//! gzip members (RFC 1952).

use super::{Damage, Output, report};
use crate::error::Result;
use crate::structure::Diagnostics;
use flate2::bufread::MultiGzDecoder;
use std::io::{ErrorKind, Read};

pub(super) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

pub(super) fn inflate(bytes: &[u8], output: &mut Output<'_>, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut decoder = MultiGzDecoder::new(bytes);
    let mut piece = vec![0u8; 256 << 10];
    loop {
        match decoder.read(&mut piece) {
            Ok(0) => return Ok(()),
            Ok(read) => output.push(&piece[..read], bytes.len() - decoder.get_ref().len())?,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => {
                let damage = match error.kind() {
                    ErrorKind::UnexpectedEof => Damage::Cut,
                    // The decoder failed on the header of a further member: padding or other bytes after the last one.
                    _ if !output.plain.is_empty() && error.to_string().contains("header") => {
                        Damage::Trailing(decoder.get_ref().len())
                    }
                    _ => Damage::Broken(error.to_string()),
                };
                return report(&damage, "gzip", output, diagnostics);
            }
        }
    }
}
