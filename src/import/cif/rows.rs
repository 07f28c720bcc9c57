//! The rows of the `_atom_site` loop in text form, which are most of a large file.
//!
//! Nearly every file has one row a line: such a line is split into its values at once. A line that is anything else
//! (a row over several lines, a text field, a comment, the end of the loop) goes through the tokens. Large loops are
//! cut at line ends and their parts read on all cores; only parts made of such lines alone count, so that the result is
//! exactly that of reading from top to bottom, and reading goes on so from the first other line.

use super::atoms::{AtomSites, Columns};
use super::text::{TextRow, find_item};
use super::token::{Token, Tokens, Value, closing_quote, is_blank};
use crate::error::{Error, Result};
use crate::import::Limits;
use crate::import::text::LOOK_EVERY;
use crate::stop::Stop;
use crate::structure::Diagnostics;
use memchr::memchr;
use rayon::prelude::*;

/// Bytes from which on reading on all cores pays (chosen: some parts for each of a few cores).
const LARGE: usize = 4 << 20;
/// Bytes of one part: small enough that the cores end a wave at nearly the same time, large enough that putting parts together
/// costs little (chosen).
const PART: usize = 1 << 19;
/// Parts that are read at the same time, for each thread.
const PARTS_A_THREAD: usize = 8;
/// Rows for which room is made in advance at most; what has more grows as it is read.
const MAX_RESERVED: usize = 4 << 20;

/// Reads the values of an `_atom_site` loop with these items, up to the token behind it.
///
/// # Errors
/// Values that do not fill whole rows, and limits. A file that ends inside the loop keeps its whole rows and is an
/// error among the diagnostics.
pub(super) fn read_loop<'a>(
    tokens: &mut Tokens<'a>,
    items: &[&'a [u8]],
    sites: &mut AtomSites,
    limits: &Limits,
    diagnostics: &mut Diagnostics,
) -> Result<()> {
    let Some(columns) = Columns::find(|item| find_item(items, item)) else {
        tokens.skip_values();
        return Ok(());
    };
    tokens.skip_line_end();
    let rest = &tokens.text[tokens.at..];
    sites.begin(&columns, expected_rows(rest));
    let mut reader = RowReader { columns: &columns, limits, values: vec![None; items.len()] };
    if rest.len() > LARGE && columns.are_independent() && rayon::current_num_threads() > 1 {
        reader.read_parts(tokens, sites, PART)?;
    }
    reader.read(tokens, sites, diagnostics)
}

pub(super) fn unclosed(line: u64) -> Error {
    Error::input(
        line,
        "expected `;` at the beginning of a line to close the text field that begins here; there is none",
    )
}

/// About how many rows there are, from the length of the first.
fn expected_rows(rest: &[u8]) -> usize {
    let first = memchr(b'\n', rest).unwrap_or(rest.len());
    (rest.len() / (first + 1)).min(MAX_RESERVED)
}

struct RowReader<'s, 'a> {
    columns: &'s Columns,
    limits: &'s Limits,
    values: Vec<Value<'a>>,
}

/// What was read of a part.
struct Part {
    sites: AtomSites,
    /// Bytes and lines of the rows read.
    bytes: usize,
    lines: u64,
}

impl<'a> RowReader<'_, 'a> {
    /// Rows from line to line, as long as each is one.
    #[inline(never)]
    fn read_lines(
        &mut self,
        text: &'a [u8],
        first_line: u64,
        sites: &mut AtomSites,
        stop: &Stop,
    ) -> Result<(usize, u64)> {
        let (mut at, mut lines) = (0, 0u64);
        while at < text.len() && !(lines.is_multiple_of(LOOK_EVERY) && stop.is_set()) {
            let end = memchr(b'\n', &text[at..]).map_or(text.len(), |length| at + length);
            // The last line of a file may have been cut; what it is the tokens tell.
            if end == text.len() || end - at > self.limits.line_bytes || !split_row(text, at, end, &mut self.values) {
                break;
            }
            sites.push(self.columns, &TextRow { values: &self.values, line: first_line + lines })?;
            at = end + 1;
            lines += 1;
        }
        Ok((at, lines))
    }

    /// Parts on all cores, up to the first line that is no row; while some are put together, the next are read.
    fn read_parts(&mut self, tokens: &mut Tokens<'a>, sites: &mut AtomSites, part_bytes: usize) -> Result<()> {
        let (columns, limits, width) = (self.columns, self.limits, self.values.len());
        let (text, stop, mut at) = (tokens.text, tokens.stop, tokens.at);
        let mut next_wave = || {
            let mut parts: Vec<&'a [u8]> = Vec::new();
            while parts.len() < PARTS_A_THREAD * rayon::current_num_threads() && at < text.len() {
                let least = (at + part_bytes).min(text.len());
                let end = memchr(b'\n', &text[least..]).map_or(text.len(), |length| least + length + 1);
                parts.push(&text[at..end]);
                at = end;
            }
            parts
        };
        // Lines are counted from the part's first one.
        let read = |text: &'a [u8]| -> (&'a [u8], Result<Part>) {
            let mut sites = AtomSites::new(limits);
            sites.begin(columns, expected_rows(text));
            let mut reader = RowReader { columns, limits, values: vec![None; width] };
            let outcome = reader.read_lines(text, 0, &mut sites, stop);
            (text, outcome.map(|(bytes, lines)| Part { sites, bytes, lines }))
        };
        let read_all = |parts: Vec<&'a [u8]>| -> Vec<_> { parts.into_par_iter().with_max_len(1).map(read).collect() };
        let mut ready = read_all(next_wave());
        while !ready.is_empty() && !tokens.stop.is_set() {
            let wave = next_wave();
            let put_together = || -> Result<bool> {
                for (text, part) in ready {
                    let part = part.map_err(|error| further_on(error, tokens.line))?;
                    sites.append(part.sites, tokens.line)?;
                    tokens.at += part.bytes;
                    tokens.line += part.lines;
                    if part.bytes < text.len() {
                        return Ok(false);
                    }
                }
                Ok(true)
            };
            let (goes_on, read) = rayon::join(put_together, || read_all(wave));
            if !goes_on? {
                return Ok(());
            }
            ready = read;
        }
        Ok(())
    }

    /// Rows however they stand, up to what is no value.
    fn read(&mut self, tokens: &mut Tokens<'a>, sites: &mut AtomSites, diagnostics: &mut Diagnostics) -> Result<()> {
        let width = self.values.len();
        // The first row that began or ended within a line: where a value is missing or one too many.
        let mut first_odd = None;
        loop {
            let at_line = tokens.at == 0 || tokens.text[tokens.at - 1] == b'\n';
            if at_line {
                let (bytes, lines) = self.read_lines(&tokens.text[tokens.at..], tokens.line, sites, tokens.stop)?;
                tokens.at += bytes;
                tokens.line += lines;
            }
            // What follows would be read row by row up to where the tokens look next.
            if tokens.stop.is_set() {
                return Ok(());
            }
            let mut row_line = None;
            for index in 0..width {
                let before = *tokens;
                let token = tokens.next();
                let line = *row_line.get_or_insert(tokens.token_line);
                match token {
                    Token::Value(value) => {
                        if tokens.at - before.at > self.limits.line_bytes && tokens.line == before.line {
                            let message =
                                format!("the line has more than {} bytes (limit `line_bytes`)", self.limits.line_bytes);
                            return Err(Error::limit(tokens.line, message));
                        }
                        self.values[index] = value;
                    }
                    _ if index == 0 => {
                        *tokens = before;
                        return Ok(());
                    }
                    Token::End | Token::Unclosed if first_odd.is_none_or(|odd| odd >= line) => {
                        let found = format!("expected {width} values, found {index}");
                        if sites.is_empty() {
                            return Err(Error::input(
                                line,
                                format!("the file ends in the first row of _atom_site ({found})"),
                            ));
                        }
                        let message = format!(
                            "the file ends in the middle of a row of _atom_site ({found}); the whole rows before it are kept"
                        );
                        diagnostics.error(Some(line), message);
                        return Ok(());
                    }
                    _ => return Err(out_of_step(first_odd.unwrap_or(line), width)),
                }
            }
            let line = row_line.unwrap_or(tokens.line);
            tokens.skip_line_end();
            let ends_line = tokens.at == tokens.text.len() || tokens.text[tokens.at - 1] == b'\n';
            if !ends_line && first_odd.is_none() {
                first_odd = Some(line);
            }
            sites.push(self.columns, &TextRow { values: &self.values, line })?;
        }
    }
}

/// An error whose lines were counted from another one on.
fn further_on(error: Error, lines: u64) -> Error {
    match error {
        Error::Limit { line, message } => Error::limit(line.map(|line| line + lines), message),
        other => other,
    }
}

fn out_of_step(line: u64, width: usize) -> Error {
    let message = format!(
        "the loop _atom_site is out of step: expected {width} values, one for each of its columns, in every row; from \
         this line on they do not fill whole rows, so that a value is missing or one too many"
    );
    Error::input(line, message)
}

/// Splits the line from `at` to `end` into values; `false` if it is not exactly one row of them and nothing else.
///
/// Eight bytes at a time: which of them are no blanks becomes bits, and the bits that differ from their neighbour are
/// where values begin and end.
#[inline]
pub(in crate::import) fn split_row<'a>(text: &'a [u8], at: usize, end: usize, values: &mut [Value<'a>]) -> bool {
    let line = &text[at..end];
    // Lines shorter than a word, or too near the end of the text to be taken in words.
    if line.first() == Some(&b';') || text.len() - end < 8 {
        return split_slowly(line, values);
    }
    let mut slots = values.iter_mut();
    let mut start = 0;
    let mut inside = 0;
    let mut base = 0;
    while base <= line.len() {
        let Some(Ok(word)) = text.get(at + base..at + base + 8).map(<[u8; 8]>::try_from) else { return false };
        let mut solid = solid_bytes(u64::from_le_bytes(word));
        // The line's end is a blank; what lies behind it is not looked at.
        if line.len() - base < 8 {
            solid &= (1 << (line.len() - base)) - 1;
        }
        let mut edges = solid ^ (solid << 1 | inside);
        inside = solid >> 7 & 1;
        edges &= 0xff;
        while edges != 0 {
            let edge = base + edges.trailing_zeros() as usize;
            edges &= edges - 1;
            if start == 0 {
                start = edge + 1; // one more, so that 0 is none
                continue;
            }
            let word = &line[start - 1..edge];
            start = 0;
            let Some(slot) = slots.next() else { return false };
            *slot = if IS_SPECIAL[usize::from(word[0])] {
                match special(word) {
                    Some(value) => value,
                    None => return split_slowly(line, values),
                }
            } else {
                Some(word)
            };
        }
        base += 8;
    }
    slots.next().is_none()
}

/// Which of eight bytes are above the blank, a bit each.
#[inline]
fn solid_bytes(word: u64) -> u64 {
    const LOW: u64 = 0x7f7f_7f7f_7f7f_7f7f;
    // 0x7f − 0x20 added to a byte without its top bit sets that bit from 0x21 on.
    let above = (word & LOW).wrapping_add(0x5f5f_5f5f_5f5f_5f5f) | word;
    // The eight top bits side by side: bit 8i times 2^(7(8 − i)) is bit 56 + i, and no two of the others meet.
    (above >> 7 & 0x0101_0101_0101_0101).wrapping_mul(0x0102_0408_1020_4080) >> 56
}

/// First bytes of what may be more than a plain value.
static IS_SPECIAL: [bool; 256] = {
    let mut special = [false; 256];
    let bytes = b"_#'\".?dDlLsSgG";
    let mut at = 0;
    while at < bytes.len() {
        special[bytes[at] as usize] = true;
        at += 1;
    }
    special
};

/// The value of a word with a special first byte; `None` if it is none, or has blanks in its quotes.
#[inline]
fn special(word: &[u8]) -> Option<Value<'_>> {
    match (word[0], word) {
        (b'_' | b'#', _) => None,
        (b'.' | b'?', [_]) => Some(None),
        (quote @ (b'\'' | b'"'), [_, inner @ .., last]) if *last == quote => Some(Some(inner)),
        (b'\'' | b'"', _) => None,
        // `loop_`, `data_…`, `save_…`, `stop_`, `global_`.
        _ if word.get(4) == Some(&b'_') || word.get(6) == Some(&b'_') => None,
        _ => Some(Some(word)),
    }
}

/// As [`split_row`], byte by byte.
#[cold]
fn split_slowly<'a>(line: &'a [u8], values: &mut [Value<'a>]) -> bool {
    if line.first() == Some(&b';') {
        return false;
    }
    let mut at = 0;
    let mut slots = values.iter_mut();
    loop {
        while at < line.len() && is_blank(line[at]) {
            at += 1;
        }
        if at == line.len() {
            return slots.next().is_none();
        }
        let Some(slot) = slots.next() else { return false };
        let start = at;
        if let first @ (b'\'' | b'"') = line[at] {
            let Some(length) = closing_quote(&line[at + 1..], first) else { return false };
            *slot = Some(&line[at + 1..at + 1 + length]);
            at += length + 2;
            continue;
        }
        while at < line.len() && !is_blank(line[at]) {
            at += 1;
        }
        match special(&line[start..at]).filter(|_| IS_SPECIAL[usize::from(line[start])]) {
            Some(value) => *slot = value,
            None if IS_SPECIAL[usize::from(line[start])] => return false,
            None => *slot = Some(&line[start..at]),
        }
    }
}

#[cfg(test)]
mod tests;
