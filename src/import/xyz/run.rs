//! Runs of plain atom lines, `C 1.234 -5.678 9.012`: most of nearly every file.
//!
//! Such a line is read in one walk, without a look for its end before, and its atom goes to the builder with others. A line
//! that is anything else (further columns, labels, integers, exponents, tabs, dummies, a position that cannot be used) ends
//! the run and is left to [`Frame::atom`], which makes the same atoms of plain lines.

use super::super::is_plausible;
use super::super::number::leading_decimal;
use super::super::text::Lines;
use super::comment::Comment;
use super::frame::{Frame, Notes};
use crate::element::Element;
use glam::DVec3;

/// Atoms that go to the builder at once (chosen: they stay in the nearest cache).
const SOME: usize = 128;

impl Frame {
    /// Reads lines as long as they are plain, `most` of them; how many there were.
    pub(super) fn plain_run(
        &mut self,
        lines: &mut Lines<'_>,
        most: usize,
        comment: &Comment,
        notes: &mut Notes,
    ) -> usize {
        if !comment.is_plain() || !self.expects_nothing_more(comment) {
            return 0;
        }
        let text = lines.rest();
        let (mut at, mut count, mut decimals) = (0, 0, notes.decimals);
        let mut elements = [Element::DUMMY; SOME];
        let mut points = [DVec3::ZERO; SOME];
        while !lines.is_given_up() {
            let mut filled = 0;
            let room = SOME.min(most - count);
            while filled < room
                && let Some(line) = text.get(at..).and_then(plain_line)
                && line.bytes <= lines.max_bytes()
            {
                (elements[filled], points[filled]) = (line.element, line.position);
                decimals = decimals.max(line.decimals);
                at += line.bytes;
                filled += 1;
            }
            self.builder.push_bare_atoms(&elements[..filled], &points[..filled]);
            count += filled;
            if filled < SOME {
                break;
            }
        }
        notes.decimals = decimals;
        lines.advance(at, count);
        count
    }
}

struct PlainLine {
    element: Element,
    position: DVec3,
    /// Most decimals of a coordinate.
    decimals: u8,
    /// With the line's end.
    bytes: usize,
}

/// The line that a text begins with; `None` if it is not plain, or the last one or nearly so.
#[inline(always)]
fn plain_line(text: &[u8]) -> Option<PlainLine> {
    let start = if *text.first()? == b' ' { skip_blanks(text, 0)? } else { 0 };
    let length = match text.get(start..start + 3)? {
        [_, b' ', _] => 1,
        [_, _, b' '] => 2,
        _ => return None,
    };
    let (element, isotope) = Element::from_symbol_bytes(text.get(start..start + length)?)?;
    let (x, x_decimals, at) = coordinate(text, start + length)?;
    let (y, y_decimals, at) = coordinate(text, at)?;
    let (z, z_decimals, at) = coordinate(text, at)?;
    let at = if text[at] == b'\n' { at } else { line_end(text, at)? };
    let position = DVec3::new(x, y, z);
    // D and T are isotopes.
    let is_plain = isotope == 0 && is_plausible(position);
    let decimals = x_decimals.max(y_decimals).max(z_decimals);
    is_plain.then_some(PlainLine { element, position, decimals, bytes: at + 1 })
}

/// The number behind blanks, its decimals, and where it ends: before a blank or the line's end.
#[inline(always)]
fn coordinate(text: &[u8], at: usize) -> Option<(f64, u8, usize)> {
    // A blank alone is stepped over without waiting for a count of blanks.
    let at = if text.get(at + 1).is_some_and(|&byte| byte != b' ') && text[at] == b' ' {
        at + 1
    } else {
        skip_blanks(text, at)?
    };
    let (value, decimals, length) = leading_decimal(text.get(at..)?)?;
    let end = at + length;
    matches!(text.get(end), Some(b' ' | b'\n' | b'\r')).then_some((value, decimals, end))
}

/// Where the blanks at `at` end.
#[inline(always)]
fn skip_blanks(text: &[u8], mut at: usize) -> Option<usize> {
    loop {
        let word = u64::from_le_bytes(*text.get(at..)?.first_chunk()?);
        let blanks = (word ^ u64::from_le_bytes([b' '; 8])).trailing_zeros() as usize / 8;
        at += blanks;
        if blanks < 8 {
            return Some(at);
        }
    }
}

/// Where the line ends that has nothing but blanks and a carriage return from `at` on.
#[cold]
fn line_end(text: &[u8], at: usize) -> Option<usize> {
    let at = skip_blanks(text, at)?;
    match text.get(at..)? {
        [b'\n', ..] => Some(at),
        [b'\r', b'\n', ..] => Some(at + 1),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::comment;
    use super::*;
    use crate::structure::Diagnostics;

    #[test]
    fn a_run_ends_at_the_first_line_that_is_not_plain() {
        let comment = comment::read(b"", 2, &mut Diagnostics::default());
        let padding = "C 1.0 1.0 1.0\n".repeat(4);
        for (odd, want) in [
            ("Fe -1.5 .25 100.125\r\n", 5),
            ("  c   1.123456789   2.5  -3.5  \n", 5),
            ("C 1 2.5 3.5\n", 1),
            ("C 1.5 2.5 3.5 0.1\n", 1),
            ("C\t1.5 2.5 3.5\n", 1),
            ("CA1 1.5 2.5 3.5\n", 1),
            ("D 1.5 2.5 3.5\n", 1),
            ("C 1.5 2.5e0 3.5\n", 1),
            ("C 1.5 2.5\nC 3.5 1.0 1.0\n", 1),
            ("C 999999999.5 2.5 3.5\n", 1),
            ("\n", 1),
        ] {
            let text = format!("N 0.5 0.25 -7.0\n{odd}{padding}{:20}", "");
            let mut lines = Lines::new(text.as_bytes(), 1 << 20);
            let (mut frame, mut notes) = (Frame::new(&comment), Notes::default());
            assert!(frame.begin(b"N 0.5 0.25 -7.0", &comment));
            assert_eq!(frame.plain_run(&mut lines, 5, &comment, &mut notes), want, "{odd:?}");
            assert_eq!((frame.builder.atom_count(), lines.number()), (want, want as u64));
            let behind = if want == 1 { odd.lines().next() } else { Some("C 1.0 1.0 1.0") };
            assert_eq!(lines.next(), behind.map(str::as_bytes), "{odd:?}");
        }
    }
}
