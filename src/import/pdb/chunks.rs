//! A file in chunks, whose atom lines are read at the same time.
//!
//! A chunk ends at a line's end. Its atoms are read into builders of their own, its other records are set aside with the
//! number of atoms before them; then the chunks are put together in their order ([`super::read`]). What a line means depends
//! on those before it in one way: how serial and residue numbers go on where they no longer fit their columns. A chunk's
//! reader guesses that from the last atom line before it; where the guess turns out wrong (hexadecimal numbers, stars),
//! the chunk is read again. So the result is that of one reader alone, whatever the number of threads.

use super::super::text::{Lines, columns};
use super::atoms::{AtomReader, Numbers};
use super::{assembly, symmetry};
use crate::error::{Error, Result};
use crate::structure::{StructureBuilder, atom_flags};

/// Bytes of a chunk: some 6,000 atoms, so that threads end a wave at nearly the same time and what waits to be put
/// together stays small.
pub(super) const CHUNK_BYTES: usize = 1 << 19;
/// Lines before a chunk that are searched for its last atom: a TER, or a few records between atoms.
const LOOK_BACK_LINES: usize = 20;

/// Splits text at line ends.
pub(super) fn split(mut text: &[u8], bytes: usize) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        if text.is_empty() {
            return None;
        }
        let least = bytes.clamp(1, text.len());
        let end = memchr::memchr(b'\n', &text[least - 1..]).map_or(text.len(), |at| least + at);
        let (chunk, rest) = text.split_at(end);
        text = rest;
        Some(chunk)
    })
}

/// What a chunk holds, in its order.
pub(super) enum Event<'a> {
    /// The rest of a model, and the most decimals met in the chunk until then; the record that ends it follows.
    Atoms(Box<StructureBuilder>, u8),
    Record(Record<'a>),
}

/// A record that is no atom.
pub(super) struct Record<'a> {
    pub(super) line: &'a [u8],
    /// 1-based, in the chunk.
    pub(super) number: u64,
    /// Atoms of its model before it, in the chunk.
    pub(super) atoms: usize,
    /// Whether a hexadecimal serial number was met before it.
    pub(super) met_hexadecimal: bool,
}

/// A chunk as it was read.
pub(super) struct Scan<'a> {
    pub(super) events: Vec<Event<'a>>,
    /// Holds the atoms behind the last event.
    pub(super) reader: AtomReader<'a>,
    pub(super) lines: u64,
    pub(super) outcome: Result<()>,
}

/// Limits of lines and models.
#[derive(Debug, Clone, Copy)]
pub(super) struct Most {
    pub(super) line_bytes: usize,
    pub(super) atoms: usize,
}

/// Reads a chunk with what `reader` knows of the lines before it.
pub(super) fn scan<'a>(chunk: &'a [u8], mut reader: AtomReader<'a>, most: Most) -> Scan<'a> {
    let mut lines = Lines::new(chunk, most.line_bytes);
    let mut events = Vec::new();
    let mut outcome = Ok(());
    while let Some(line) = lines.next() {
        let number = lines.number();
        match columns(line, 0, 6) {
            [b'A', b'T', b'O', b'M', b' ' | b'0'..=b'9', b' ' | b'0'..=b'9'] => reader.atom(line, number, 0),
            b"HETATM" => reader.atom(line, number, atom_flags::HETERO),
            // Everything else begins neither with these nor, in a large file, is there much of it.
            record => {
                let record = record.trim_ascii_end();
                if !is_read(record) && !symmetry::is_row(line) && !assembly::is_line(line) {
                    continue;
                }
                if ends_model(record) {
                    let decimals = reader.decimals;
                    let builder = reader.end_model();
                    if builder.atom_count() > 0 {
                        events.push(Event::Atoms(Box::new(builder), decimals));
                    }
                }
                events.push(Event::Record(Record {
                    line,
                    number,
                    atoms: reader.builder.atom_count(),
                    met_hexadecimal: reader.numbers.serials.met_hexadecimal,
                }));
                continue;
            }
        }
        if reader.builder.atom_count() > most.atoms {
            let message = format!("the record has more than {} atoms (limit `atoms`)", most.atoms);
            outcome = Err(Error::limit(number, message));
            break;
        }
    }
    if outcome.is_ok() {
        outcome = lines.check();
    }
    Scan { events, reader, lines: lines.number(), outcome }
}

/// Records that are looked at.
fn is_read(record: &[u8]) -> bool {
    matches!(
        record,
        b"HEADER"
            | b"TITLE"
            | b"CRYST1"
            | b"MODEL"
            | b"ENDMDL"
            | b"END"
            | b"CONECT"
            | b"SSBOND"
            | b"LINK"
            | b"LINKR"
            | b"HELIX"
            | b"SHEET"
    )
}

/// Records with which a model begins or ends.
pub(super) fn ends_model(record: &[u8]) -> bool {
    matches!(record, b"HEADER" | b"MODEL" | b"ENDMDL" | b"END")
}

/// How the numbers probably go on behind the text.
pub(super) fn guess_numbers(before: &[u8]) -> Numbers {
    let mut numbers = Numbers::default();
    let mut rest = before;
    for _ in 0..LOOK_BACK_LINES {
        let line_end = rest.strip_suffix(b"\n").unwrap_or(rest);
        let start = memchr::memrchr(b'\n', line_end).map_or(0, |at| at + 1);
        let line = &line_end[start..];
        let record = columns(line, 0, 6).trim_ascii_end();
        if ends_model(record) || line_end.is_empty() {
            break;
        }
        if (record.starts_with(b"ATOM") || record == b"HETATM") && line.len() > 46 {
            numbers.read(line);
            break;
        }
        rest = &rest[..start];
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_end_where_lines_do_and_are_the_whole() {
        let text = b"one\ntwo\n\nthree\nfour";
        for bytes in 1..30 {
            let chunks: Vec<&[u8]> = split(text, bytes).collect();
            assert_eq!(chunks.concat(), text);
            assert!(chunks[..chunks.len() - 1].iter().all(|chunk| chunk.ends_with(b"\n") && chunk.len() >= bytes));
        }
        assert_eq!(split(b"", 5).count(), 0);
    }
}
