//! BinaryCIF: mmCIF with its columns encoded and packed as MessagePack.
//!
//! Specification: `encoding.md` of <https://github.com/molstar/BinaryCIF>, version 0.3; Sehnal et al., "BinaryCIF and
//! CIFTools", PLoS Comput. Biol. 2020, 16(10), e1008247.
//!
//! Way: MessagePack tokens ([`msgpack`]) → categories with their columns as they lie in the file ([`table`]) → those
//! that a consumer asks for decoded ([`encoding`], [`column`]) → the consumers of mmCIF ([`super::cif`]). The atoms of a
//! usual file never become rows: their columns are decoded at the same time and become the structure's ([`sites`]).
//!
//! Read are all encodings of the specification, in any order in which one can undo what another did, and masks.
//! Accepted beyond it: keys in any order, unknown keys, a missing ByteArray (bytes), offsets of texts that count bytes,
//! characters or UTF-16 units, column and category names in any case.
//!
//! A column that cannot be decoded is left out with an error that names it; of a cut file the whole categories before
//! the cut are read. Limits: what columns decode to is bounded by the ratio of [`Limits`](super::Limits) past the first
//! 16 MiB, as with compressed files; lengths that the file only claims cost nothing.

mod column;
#[cfg(test)]
mod encoder;
mod encoding;
mod msgpack;
mod sites;
mod table;
#[cfg(test)]
mod tests;

use super::cif::atoms::AtomSites;
use super::cif::block;
use super::cif::table::{Block, Category};
use super::collect::Records;
use crate::error::{Error, Result};
use crate::structure::Diagnostics;
use msgpack::{Cursor, Malformed, Token};
use table::{BinaryBlock, Context};

/// Decoded bytes up to which the ratio is not looked at.
const FREE_BYTES: u64 = 16 << 20;

/// Whether the bytes begin as a BinaryCIF file does: a map with one of its keys.
pub(super) fn is_binary_cif(bytes: &[u8]) -> bool {
    let mut cursor = Cursor::new(bytes);
    matches!(cursor.token(), Ok(Token::Map(_)))
        && matches!(cursor.token(), Ok(Token::Text(b"encoder" | b"version" | b"dataBlocks")))
}

pub(super) fn read(bytes: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let limits = *records.limits();
    let budget = FREE_BYTES.saturating_add((bytes.len() as u64).saturating_mul(u64::from(limits.ratio.max(1))));
    let context = Context::new(encoding::Budget::new(budget).until(records.stop()), limits.ratio);
    let mut first_problem = None;
    let outcome = read_blocks(&mut Cursor::new(bytes), &context, |block| {
        let sites = match (block.plain_sites(&limits), block.table(Category::AtomSite)) {
            (Some(sites), _) => Ok(sites),
            (None, Some(table)) => AtomSites::from_table(&table, &limits),
            (None, None) => Ok(AtomSites::new(&limits)),
        };
        let result = sites.and_then(|sites| block::finish(block, sites, records, diagnostics));
        if let Some(limit) = context.limit() {
            return Err(limit);
        }
        // A column that cannot be decoded is why it is missing.
        for problem in context.take_problems() {
            first_problem.get_or_insert_with(|| Error::input(None, problem.clone()));
            diagnostics.error(None, problem);
        }
        match result {
            Err(limit @ Error::Limit { .. }) => Err(limit),
            Err(problem) => {
                diagnostics.error(None, format!("block `{}` is left out: {problem}", block.name()));
                first_problem.get_or_insert(problem);
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    })?;
    if let Err(malformed) = outcome {
        let problem = Error::input(None, format!("this is no sound BinaryCIF file: {malformed}"));
        if !records.is_empty() {
            diagnostics.error(None, format!("{malformed}; what stands behind that is lost"));
        }
        first_problem.get_or_insert(problem);
    }
    match first_problem {
        Some(problem) if records.is_empty() => Err(problem),
        _ => Ok(()),
    }
}

/// Hands all data blocks on, the part of one in which the file breaks off included. The outer result is that of
/// `consume`, the inner one tells whether the bytes are sound.
fn read_blocks(
    cursor: &mut Cursor<'_>,
    context: &Context,
    mut consume: impl FnMut(&BinaryBlock<'_, '_>) -> Result<()>,
) -> Result<Result<(), Malformed>> {
    let mut step = || -> Result<bool, Malformed> {
        // Keys of the file up to its blocks.
        for _ in 0..cursor.map("a map with `dataBlocks`")? {
            if cursor.text("a key")? == b"dataBlocks" {
                return Ok(true);
            }
            cursor.skip()?;
        }
        Ok(false)
    };
    match step() {
        Ok(true) => {}
        Ok(false) => return Ok(Err(Malformed::Unexpected(0, "a map with `dataBlocks`"))),
        Err(malformed) => return Ok(Err(malformed)),
    }
    let count = match cursor.array("the data blocks") {
        Ok(count) => count,
        Err(malformed) => return Ok(Err(malformed)),
    };
    for _ in 0..count {
        let (block, outcome) = BinaryBlock::read(cursor, context);
        consume(&block)?;
        if let Err(malformed) = outcome {
            return Ok(Err(malformed));
        }
    }
    Ok(Ok(()))
}
