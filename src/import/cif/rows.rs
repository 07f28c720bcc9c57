//! The rows of the `_atom_site` loop in text form, which are most of a large file.
//!
//! Nearly every file has one row a line: such a line is split into its values at once. A line that is anything else
//! (a row over several lines, a text field, a comment, the end of the loop) goes through the tokens. Large loops are
//! cut at line ends and their parts read on all cores; only parts made of such lines alone count, so that the result is
//! exactly that of reading from top to bottom, and reading goes on so from the first other line.

use super::atoms::{AtomSites, Columns};
use super::text::{TextRow, find_item};
use super::token::{Token, Tokens, Value, closing_quote, is_blank, unquoted};
use crate::error::{Error, Result};
use crate::import::Limits;
use crate::structure::Diagnostics;
use memchr::{memchr, memchr_iter};
use rayon::prelude::*;

/// Bytes from which on reading on all cores pays (a tenth of a second of one core's work).
const LARGE: usize = 20 << 20;
/// Bytes of one part: many enough for the cores to share, large enough that putting them together costs nothing.
const PART: usize = 4 << 20;
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
    fn read_lines(&mut self, text: &'a [u8], first_line: u64, sites: &mut AtomSites) -> Result<(usize, u64)> {
        let (mut at, mut lines) = (0, 0);
        while at < text.len() {
            let end = memchr(b'\n', &text[at..]).map_or(text.len(), |length| at + length);
            // The last line of a file may have been cut; what it is the tokens tell.
            if end == text.len() || end - at > self.limits.line_bytes || !split_row(&text[at..end], &mut self.values) {
                break;
            }
            sites.push(self.columns, &TextRow { values: &self.values, line: first_line + lines })?;
            at = end + 1;
            lines += 1;
        }
        Ok((at, lines))
    }

    /// Parts on all cores, up to the first line that is no row.
    fn read_parts(&mut self, tokens: &mut Tokens<'a>, sites: &mut AtomSites, part_bytes: usize) -> Result<()> {
        let (columns, limits, width) = (self.columns, self.limits, self.values.len());
        loop {
            let mut parts = Vec::new();
            let (mut at, mut line) = (tokens.at, tokens.line);
            while parts.len() < 2 * rayon::current_num_threads() && at < tokens.text.len() {
                let least = (at + part_bytes).min(tokens.text.len());
                let end = memchr(b'\n', &tokens.text[least..]).map_or(tokens.text.len(), |length| least + length + 1);
                let text = &tokens.text[at..end];
                parts.push((text, line));
                line += memchr_iter(b'\n', text).count() as u64;
                at = end;
            }
            if parts.is_empty() {
                return Ok(());
            }
            let read = |&(text, line): &(&'a [u8], u64)| -> Result<Part> {
                let mut sites = AtomSites::new(limits);
                sites.begin(columns, expected_rows(text));
                let mut reader = RowReader { columns, limits, values: vec![None; width] };
                let (bytes, lines) = reader.read_lines(text, line, &mut sites)?;
                Ok(Part { sites, bytes, lines })
            };
            let results: Vec<Result<Part>> = parts.par_iter().map(read).collect();
            for (result, (text, _)) in results.into_iter().zip(&parts) {
                let part = result?;
                sites.append(part.sites)?;
                tokens.at += part.bytes;
                tokens.line += part.lines;
                if part.bytes < text.len() {
                    return Ok(());
                }
            }
        }
    }

    /// Rows however they stand, up to what is no value.
    fn read(&mut self, tokens: &mut Tokens<'a>, sites: &mut AtomSites, diagnostics: &mut Diagnostics) -> Result<()> {
        let width = self.values.len();
        // The first row that began or ended within a line: where a value is missing or one too many.
        let mut first_odd = None;
        loop {
            let at_line = tokens.at == 0 || tokens.text[tokens.at - 1] == b'\n';
            if at_line {
                let (bytes, lines) = self.read_lines(&tokens.text[tokens.at..], tokens.line, sites)?;
                tokens.at += bytes;
                tokens.line += lines;
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

fn out_of_step(line: u64, width: usize) -> Error {
    let message = format!(
        "the loop _atom_site is out of step: expected {width} values, one for each of its columns, in every row; from \
         this line on they do not fill whole rows, so that a value is missing or one too many"
    );
    Error::input(line, message)
}

/// Splits a line into values; `false` if it is not exactly one row of them and nothing else.
#[inline]
fn split_row<'a>(line: &'a [u8], values: &mut [Value<'a>]) -> bool {
    if line.first() == Some(&b';') {
        return false;
    }
    let mut at = 0;
    let mut count = 0;
    loop {
        while at < line.len() && is_blank(line[at]) {
            at += 1;
        }
        if at == line.len() {
            return count == values.len();
        }
        let Some(slot) = values.get_mut(count) else { return false };
        let start = at;
        let first = line[at];
        match first {
            b'_' | b'#' => return false,
            b'\'' | b'"' => {
                let Some(length) = closing_quote(&line[at + 1..], first) else { return false };
                *slot = Some(&line[at + 1..at + 1 + length]);
                at += length + 2;
                count += 1;
                continue;
            }
            _ => {}
        }
        while at < line.len() && !is_blank(line[at]) {
            at += 1;
        }
        let word = &line[start..at];
        // `loop_`, `data_…`, `save_…`, `stop_`; `global_` is the only other word of the language.
        if word.len() >= 5 && (word[4] == b'_' || word.get(6) == Some(&b'_')) && first.is_ascii_alphabetic() {
            return false;
        }
        *slot = if word.len() == 1 { unquoted(word) } else { Some(word) };
        count += 1;
    }
}

#[cfg(test)]
mod tests;
