//! Serial and residue numbers, and what programs write when they no longer fit their columns.
//!
//! Read: decimals; hybrid-36 (`A0000` follows 99999; Grosse-Kunstleve, <http://cci.lbl.gov/hybrid_36/>); hexadecimal
//! (`186a0` follows 99999, `2710` follows 9999, as VMD writes). Digits alone can be either decimal or hexadecimal, so
//! that the numbers before decide: once hexadecimal, numbers stay it until one is shorter than its columns.

use super::super::number::parse_i64;

/// Reads one column of numbers from atom to atom.
#[derive(Debug, Clone)]
pub(super) struct NumberColumn {
    width: u32,
    hexadecimal: bool,
    previous: Option<i64>,
    /// Whether hexadecimal was ever met.
    pub(super) met_hexadecimal: bool,
}

impl NumberColumn {
    /// A column that is `width` characters wide.
    pub(super) fn new(width: u32) -> NumberColumn {
        NumberColumn { width, hexadecimal: false, previous: None, met_hexadecimal: false }
    }

    /// A new model begins: numbers start again.
    pub(super) fn restart(&mut self) {
        self.hexadecimal = false;
        self.previous = None;
    }

    /// Whether the numbers that follow mean the same in both.
    pub(super) fn goes_on_as(&self, other: &NumberColumn) -> bool {
        self.hexadecimal == other.hexadecimal && self.previous == other.previous
    }

    /// The number of trimmed text; `None` if it is none.
    #[inline]
    pub(super) fn read(&mut self, text: &[u8]) -> Option<i64> {
        let overflow = 10i64.pow(self.width);
        let full = text.len() == self.width as usize;
        let value = match parse_i64(text) {
            Some(decimal) if !full => {
                self.hexadecimal = false;
                decimal
            }
            Some(decimal) if !self.hexadecimal && self.previous != Some(overflow - 1) => decimal,
            decimal => self.read_odd(text, decimal, overflow)?,
        };
        self.previous = Some(value);
        Some(value)
    }

    /// Full columns that are no decimal, or a decimal where it might be hexadecimal.
    fn read_odd(&mut self, text: &[u8], decimal: Option<i64>, overflow: i64) -> Option<i64> {
        let may_be = self.hexadecimal || text.first().is_some_and(u8::is_ascii_digit);
        let hexadecimal = if may_be { hexadecimal(text) } else { None };
        let hexadecimal = hexadecimal.filter(|&value| {
            let follows = match self.previous {
                _ if text.len() != self.width as usize => false,
                // A hexadecimal without a letter must follow exactly.
                Some(previous) if decimal.is_some() && !self.hexadecimal => value == previous + 1,
                // A thousand numbers may be left out (TER records, atoms left out).
                Some(previous) => self.hexadecimal || previous >= overflow - 1000,
                None => text[0].is_ascii_digit(),
            };
            value >= overflow && follows
        });
        if let Some(value) = hexadecimal {
            self.hexadecimal = true;
            self.met_hexadecimal = true;
            return Some(value);
        }
        decimal.or_else(|| hybrid36(text, self.width))
    }

    /// The next number where the file has none that can be read.
    pub(super) fn count_on(&mut self) -> i64 {
        let value = self.previous.map_or(1, |previous| previous + 1);
        self.previous = Some(value);
        value
    }
}

/// A hexadecimal number in either case.
pub(super) fn hexadecimal(text: &[u8]) -> Option<i64> {
    if text.is_empty() || text.len() > 8 || !text.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    i64::from_str_radix(std::str::from_utf8(text).ok()?, 16).ok()
}

/// A hybrid-36 number that begins with a letter.
pub(super) fn hybrid36(text: &[u8], width: u32) -> Option<i64> {
    if text.len() != width as usize || width > 6 {
        return None;
    }
    let upper = text[0].is_ascii_uppercase();
    if !text[0].is_ascii_alphabetic() {
        return None;
    }
    let a = if upper { b'A' } else { b'a' };
    let mut value = 0;
    for &byte in text {
        let digit = match byte.wrapping_sub(b'0') {
            digit @ 0..=9 => digit,
            _ => match byte.wrapping_sub(a) {
                letter @ 0..=25 => letter + 10,
                _ => return None,
            },
        };
        value = value * 36 + i64::from(digit); // six of them at most
    }
    let block = 36i64.pow(width - 1);
    // Upper case goes from A000… on; its 26 blocks come before those of lower case.
    Some(value - 10 * block + 10i64.pow(width) + if upper { 0 } else { 26 * block })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(width: u32, texts: &[&str]) -> Vec<Option<i64>> {
        let mut column = NumberColumn::new(width);
        texts.iter().map(|text| column.read(text.as_bytes())).collect()
    }

    #[test]
    fn hybrid36_counts_as_its_authors_do() {
        // From the table in the hybrid-36 description.
        for (text, value) in [
            ("A0000", 100_000),
            ("A0001", 100_001),
            ("ZZZZZ", 43_770_015),
            ("a0000", 43_770_016),
            ("zzzzz", 87_440_031),
        ] {
            assert_eq!(hybrid36(text.as_bytes(), 5), Some(value), "{text}");
        }
        assert_eq!(hybrid36(b"A000", 4), Some(10_000));
        assert_eq!(hybrid36(b"zzzz", 4), Some(2_436_111));
        for text in ["Aa000", "A000", "0A000", "A 000", "*****"] {
            assert_eq!(hybrid36(text.as_bytes(), 5), None, "{text}");
        }
    }

    #[test]
    fn hexadecimal_follows_the_last_decimal() {
        let got = run(5, &["99999", "186a0", "186a9", "18700", "a0000", "1", "18700"]);
        assert_eq!(got, [99_999, 100_000, 100_009, 100_096, 655_360, 1, 18_700].map(Some));
        assert_eq!(
            run(4, &["9998", "9999", "9999", "2710", "2711", "271a"]),
            [9998, 9999, 9999, 10000, 10001, 10010].map(Some)
        );
    }

    #[test]
    fn decimals_stay_decimals() {
        assert_eq!(run(4, &["2710", "-999", "9999", "0", "2710"]), [2710, -999, 9999, 0, 2710].map(Some));
        assert_eq!(run(5, &["99999", "00000", "100000"]), [99_999, 0, 100_000].map(Some));
        // An insertion code that slipped into the number's columns is no hexadecimal number.
        assert_eq!(run(4, &["100", "100A", "*****", ""]), [Some(100), None, None, None]);
    }

    #[test]
    fn hybrid36_goes_on_after_the_decimals() {
        assert_eq!(run(5, &["99999", "A0000", "A000Z"]), [99_999, 100_000, 100_035].map(Some));
        assert_eq!(run(4, &["9999", "A000", "A1UE"]), [9999, 10_000, 10_000 + 36 * 36 + 30 * 36 + 14].map(Some));
    }
}
