//! Text of any origin as lines: byte order marks, UTF-16, the line ends of all systems, lines with their numbers, fields.

use crate::error::{Error, Result};
use crate::stop::Stop;
use crate::structure::Diagnostics;
use memchr::{memchr, memchr_iter};
use rayon::prelude::*;
use std::borrow::Cow;

/// The bytes with `\n` (or `\r\n`) line ends, without a byte order mark, UTF-16 turned into UTF-8. Almost always the
/// bytes as they are.
pub(super) fn normalise<'a>(bytes: &'a [u8], diagnostics: &mut Diagnostics) -> Cow<'a, [u8]> {
    let bytes: Cow<'a, [u8]> = if let Some(rest) = bytes.strip_prefix(b"\xff\xfe") {
        Cow::Owned(from_utf16(rest, u16::from_le_bytes, diagnostics))
    } else if let Some(rest) = bytes.strip_prefix(b"\xfe\xff") {
        Cow::Owned(from_utf16(rest, u16::from_be_bytes, diagnostics))
    } else {
        Cow::Borrowed(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
    };
    // Without any line feed each carriage return ends a line (old Mac). Else one that no line feed follows does;
    // those of `\r\r\n` belong to one line end.
    let mac = memchr(b'\n', &bytes).is_none();
    let lone = |bytes: &[u8], at: usize| mac || !matches!(bytes.get(at + 1), Some(b'\n' | b'\r'));
    if !has_return(&bytes) || !memchr_iter(b'\r', &bytes).any(|at| lone(&bytes, at)) {
        return bytes;
    }
    let mut owned = bytes.into_owned();
    for at in 0..owned.len() {
        if owned[at] == b'\r' && lone(&owned, at) {
            owned[at] = b'\n';
        }
    }
    Cow::Owned(owned)
}

/// Whether there is a carriage return; all cores look through what is large.
fn has_return(bytes: &[u8]) -> bool {
    const PART: usize = 4 << 20;
    let has = |part: &[u8]| memchr(b'\r', part).is_some();
    if bytes.len() <= PART { has(bytes) } else { bytes.par_chunks(PART).any(has) }
}

fn from_utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16, diagnostics: &mut Diagnostics) -> Vec<u8> {
    diagnostics.warn(None, "the text is UTF-16; read as if it were UTF-8");
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let text: String = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    text.into_bytes()
}

/// Lines between two looks whether reading is given up: some milliseconds.
pub(super) const LOOK_EVERY: u64 = 4096;

/// Lines with their numbers. A line longer than the limit ends the iteration; [`Lines::check`] then says so. So does giving up ([`Lines::until`]), soon,
/// which whoever began to read knows.
#[derive(Debug, Clone)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
    max_bytes: usize,
    too_long: bool,
    stop: Stop,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a [u8], max_bytes: usize) -> Lines<'a> {
        Lines { rest: text, number: 0, max_bytes, too_long: false, stop: Stop::never() }
    }

    /// The same until reading is given up.
    pub(super) fn until(self, stop: &Stop) -> Lines<'a> {
        Lines { stop: stop.clone(), ..self }
    }

    /// Whether reading is given up.
    pub(super) fn is_given_up(&self) -> bool {
        self.stop.is_set()
    }

    /// 1-based number of the line that `next` gave last, 0 before the first.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// What is still to come.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Most bytes of a line.
    pub(super) fn max_bytes(&self) -> usize {
        self.max_bytes
    }

    /// Goes on behind so many bytes, which are so many lines.
    pub(super) fn advance(&mut self, bytes: usize, lines: usize) {
        self.rest = self.rest.get(bytes..).unwrap_or_default();
        self.number += lines as u64;
    }

    /// Passes over so many lines without looking at them, not even at how long they are; `false` if there are fewer.
    pub(super) fn pass_over(&mut self, count: usize) -> bool {
        /// Bytes in which line ends are counted at once (chosen: they stay in the nearest cache).
        const SOME: usize = 1 << 14;
        if self.is_given_up() {
            return false;
        }
        let (mut at, mut left) = (0, count);
        while left > 0 && at < self.rest.len() {
            let some = &self.rest[at..self.rest.len().min(at + SOME)];
            let ends = memchr_iter(b'\n', some).count();
            if ends < left {
                left -= ends;
                at += some.len();
            } else {
                at += memchr_iter(b'\n', some).nth(left - 1).map_or(some.len(), |end| end + 1);
                left = 0;
            }
        }
        // The last line of a text may be without an end.
        if left > 0 && self.rest.last().is_some_and(|&byte| byte != b'\n') {
            left -= 1;
        }
        self.number += (count - left) as u64;
        self.rest = &self.rest[at..];
        left == 0
    }

    /// The limit error if a line was too long.
    pub(super) fn check(&self) -> Result<()> {
        if self.too_long {
            let message = format!("the line has more than {} bytes (limit `line_bytes`)", self.max_bytes);
            return Err(Error::limit(self.number, message));
        }
        Ok(())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    /// The next line without its end.
    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        if self.number.is_multiple_of(LOOK_EVERY) && self.is_given_up() {
            self.rest = &[];
            return None;
        }
        let (line, rest) = match memchr(b'\n', self.rest) {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.number += 1;
        if line.len() > self.max_bytes {
            self.too_long = true;
            self.rest = &[];
            return None;
        }
        self.rest = rest;
        let mut line = line;
        while let [head @ .., b'\r'] = line {
            line = head;
        }
        Some(line)
    }
}

/// Columns `from..to` (0-based) as far as the line has them.
#[inline]
pub(super) fn columns(line: &[u8], from: usize, to: usize) -> &[u8] {
    let to = to.min(line.len());
    if from < to { &line[from..to] } else { &[] }
}

/// Columns `from..to` without blanks around.
#[inline]
pub(super) fn field(line: &[u8], from: usize, to: usize) -> &[u8] {
    columns(line, from, to).trim_ascii()
}

#[inline]
fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c | b'\r' | 0)
}

/// The next blank-separated word and what follows it; `None` at the end of the line.
#[inline]
pub(super) fn next_word(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let mut start = 0;
    while start < line.len() && is_blank(line[start]) {
        start += 1;
    }
    let mut end = start;
    while end < line.len() && !is_blank(line[end]) {
        end += 1;
    }
    (end > start).then(|| line.split_at(end)).map(|(head, rest)| (&head[start..], rest))
}

/// All blank-separated words.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = line;
    std::iter::from_fn(move || {
        let (word, after) = next_word(rest)?;
        rest = after;
        Some(word)
    })
}

/// Whether there is nothing but blanks.
pub(super) fn is_blank_line(line: &[u8]) -> bool {
    line.iter().all(|&byte| is_blank(byte))
}

/// Text of bytes; what is no UTF-8 becomes U+FFFD.
pub(super) fn lossy(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}

/// Text of bytes for a message: no control characters, not too long.
pub(super) fn shown(bytes: &[u8]) -> String {
    const MOST: usize = 40;
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * MOST)]);
    let mut shown: String = text.chars().take(MOST).map(|c| if c.is_control() { '·' } else { c }).collect();
    if text.chars().nth(MOST).is_some() {
        shown.push('…');
    }
    shown
}

/// One kind of oddity that may occur on many lines: one diagnostic for all of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Repeated {
    first_line: u64,
    count: u64,
    example: String,
}

impl Repeated {
    /// Notes one more (line 0 for what stands on no line); `example` is asked for the first time only.
    #[cold]
    pub(super) fn note(&mut self, line: u64, example: impl FnOnce() -> String) {
        if self.count == 0 {
            self.first_line = line;
            self.example = example();
        }
        self.count += 1;
    }

    /// Adds what was noted elsewhere, further on in the file.
    pub(super) fn absorb(&mut self, later: Repeated) {
        let count = self.count + later.count;
        if self.count == 0 {
            *self = later;
        }
        self.count = count;
    }

    /// The same, with lines counted from so many lines earlier on.
    pub(super) fn shifted(mut self, lines: u64) -> Repeated {
        self.first_line += lines;
        self
    }

    /// The message with how often, and the line of the first; `None` if there was none.
    pub(super) fn message(&self) -> Option<(u64, String)> {
        let times = if self.count > 1 { format!(" ({} times, this is the first)", self.count) } else { String::new() };
        (self.count > 0).then(|| (self.first_line, format!("{}{times}", self.example)))
    }

    pub(super) fn warn(&self, diagnostics: &mut Diagnostics) {
        if let Some((line, message)) = self.message() {
            diagnostics.warn((line > 0).then_some(line), message);
        }
    }

    pub(super) fn error(&self, diagnostics: &mut Diagnostics) {
        if let Some((line, message)) = self.message() {
            diagnostics.error((line > 0).then_some(line), message);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &[u8]) -> Vec<Vec<u8>> {
        let text = normalise(text, &mut Diagnostics::default());
        Lines::new(&text, 100).map(<[u8]>::to_vec).collect()
    }

    #[test]
    fn line_ends_of_all_systems_are_line_ends() {
        let want: Vec<Vec<u8>> = [b"a".as_slice(), b"", b"b"].iter().map(|line| line.to_vec()).collect();
        for text in ["a\n\nb", "a\r\n\r\nb\r\n", "a\r\rb\r", "\u{feff}a\n\nb", "a\n\nb\r", "a\r\r\n\nb"] {
            assert_eq!(lines(text.as_bytes()), want, "{text:?}");
        }
        assert_eq!(lines(b"a\rb\nc"), [b"a", b"b", b"c"]);
    }

    #[test]
    fn utf16_is_read() {
        let text: Vec<u8> = "\u{feff}å\n1".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(lines(&text), ["å".as_bytes(), b"1"]);
        let text: Vec<u8> = "\u{feff}å\n1".encode_utf16().flat_map(u16::to_be_bytes).collect();
        assert_eq!(lines(&text), ["å".as_bytes(), b"1"]);
    }

    #[test]
    fn a_long_line_is_refused_by_its_number() {
        let mut lines = Lines::new(b"ab\nabcdef\nab", 3);
        assert_eq!(lines.by_ref().count(), 1);
        assert_eq!(lines.check().unwrap_err().line(), Some(2));
    }

    #[test]
    fn passed_over_lines_are_those_that_come_one_by_one() {
        let short: String =
            (0..30_000).map(|n| if n % 7 == 0 { "\n".to_owned() } else { format!("{n}\r\n") }).collect();
        for text in [short.as_str(), "a\nb", "a\nb\n", "\n", "a", ""] {
            let all = Lines::new(text.as_bytes(), 100);
            let count = all.clone().count();
            for skipped in [0, 1, 2, count / 2, count.saturating_sub(1), count] {
                let (mut one_by_one, mut at_once) = (all.clone(), all.clone());
                let found = one_by_one.by_ref().take(skipped).count() == skipped;
                assert_eq!(at_once.pass_over(skipped), found);
                assert_eq!((at_once.number(), at_once.rest()), (one_by_one.number(), one_by_one.rest()));
            }
            assert!(!all.clone().pass_over(count + 1));
        }
    }

    #[test]
    fn words_and_columns_do_not_run_over_the_line() {
        assert_eq!(words(b" a\tbc  d").collect::<Vec<_>>(), [b"a".as_slice(), b"bc", b"d"]);
        assert_eq!(next_word(b"  "), None);
        assert_eq!((field(b"abc d", 3, 99), field(b"abc", 9, 12)), (b"d".as_slice(), b"".as_slice()));
    }

    #[test]
    fn repeated_oddities_make_one_message() {
        let mut repeated = Repeated::default();
        assert_eq!(repeated.message(), None);
        for line in 5..9 {
            repeated.note(line, || format!("odd at {line}"));
        }
        assert_eq!(repeated.message(), Some((5, "odd at 5 (4 times, this is the first)".to_owned())));
    }
}
