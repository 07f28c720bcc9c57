//! Numbers in text: exact, quick for the usual short decimals, and able to read Fortran's.
//!
//! Method: a decimal of at most 15 significant digits and 22 decimals is an integer below 2⁵³ divided by a power of
//! ten that an f64 holds exactly, so one division rounds correctly (Clinger, "How to read floating point numbers
//! accurately", PLDI 1990). Everything else goes to the standard library's parser, which is exact too.

use super::text::{field, next_word};
use glam::DVec3;

/// Powers of ten that an f64 holds exactly.
const TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// A number and the decimals it was written with. `nan` and `inf` are numbers here: callers test with `is_finite`.
/// `None` for what is no number, blanks around it included.
#[inline]
pub(super) fn parse_f64(text: &[u8]) -> Option<(f64, u8)> {
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    };
    let mut mantissa = 0u64;
    let mut length = 0usize;
    let mut point = usize::MAX;
    for (index, &byte) in digits.iter().enumerate() {
        let digit = byte.wrapping_sub(b'0');
        if digit < 10 {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            length += 1;
        } else if byte == b'.' && point == usize::MAX {
            point = index;
        } else {
            return parse_slowly(text);
        }
    }
    if length == 0 {
        return None;
    }
    if length > 15 {
        return parse_slowly(text);
    }
    let decimals = if point == usize::MAX { 0 } else { length - point };
    let value = mantissa as f64 / TEN[decimals];
    Some((if negative { -value } else { value }, decimals as u8))
}

/// The number right-aligned in eight bytes, with a decimal point, and its decimals: `  -1.250`. `None` for anything
/// else, which [`parse_f64`] is to read; where both read a number it is the same.
///
/// Method: all eight digits at once, as pairs, fours and eights are put together by multiplications ("SIMD within a
/// register"; Lemire, "Number parsing at a gigabyte per second", Softw. Pract. Exp. 2021, 51, 1700).
#[inline]
pub(super) fn fixed_f64(text: [u8; 8]) -> Option<(f64, u8)> {
    const ONES: u64 = 0x0101_0101_0101_0101;
    let word = u64::from_le_bytes(text);
    // The lowest byte that is 0 after this is the point.
    let point = word ^ (ONES * u64::from(b'.'));
    let zero = point.wrapping_sub(ONES) & !point & (ONES << 7);
    if zero == 0 {
        return None;
    }
    let at = zero.trailing_zeros() & !7; // in bits
    let below = (1u64 << at) - 1;
    // Without the point, behind one more blank.
    let digits = (word & below) | ((word >> at >> 8) << at);
    let mut digits = (digits << 8) | u64::from(b' ');
    let blanks = (digits ^ (ONES * u64::from(b' '))).trailing_zeros() & !7;
    if blanks >= 64 {
        return None;
    }
    let negative = (digits >> blanks) as u8 == b'-';
    // Blanks and the sign stand before the point: `at` and the blank put in front are what there is before it.
    if blanks > at + 8 || negative && blanks == at + 8 {
        return None;
    }
    let skip = blanks + if negative { 8 } else { 0 };
    if skip >= 64 {
        return None;
    }
    let blank = (1u64 << skip) - 1;
    digits = (digits & !blank) | ((ONES * u64::from(b'0')) & blank);
    let values = digits ^ (ONES * u64::from(b'0'));
    // Each byte is a digit: neither it nor it plus six has a high half.
    if (values | values.wrapping_add(ONES * 6)) & (ONES * 0xf0) != 0 {
        return None;
    }
    let decimals = 7 - at / 8;
    let value = eight_digits(values) as f64 / TEN[decimals as usize];
    Some((if negative { -value } else { value }, decimals as u8))
}

/// The number of eight digits, the first one in the lowest byte.
#[inline(always)]
fn eight_digits(values: u64) -> u64 {
    let pairs = values.wrapping_mul(10).wrapping_add(values >> 8) & 0x00ff_00ff_00ff_00ff;
    let fours = pairs.wrapping_mul(100).wrapping_add(pairs >> 16) & 0x0000_ffff_0000_ffff;
    fours.wrapping_mul(10_000).wrapping_add(fours >> 32) & 0xffff_ffff
}

/// The number at the start of a text, with a decimal point, digits and at most a minus before them; its decimals and its
/// length. What follows it is no digit. `None` for anything else, for more than 14 digits, and near the end of the text; where
/// [`parse_f64`] of the same bytes reads a number it is the same.
///
/// Method: as [`fixed_f64`]; the first two bytes that are no digits are the point and what follows the number.
#[inline(always)]
pub(super) fn leading_decimal(text: &[u8]) -> Option<(f64, u8, usize)> {
    const ONES: u64 = 0x0101_0101_0101_0101;
    // Both are loaded before it is known which of them counts.
    let nine: &[u8; 9] = text.first_chunk()?;
    let negative = nine[0] == b'-';
    let [from_first, from_second] = [nine.first_chunk()?, nine.last_chunk()?].map(|bytes| u64::from_le_bytes(*bytes));
    let word = if negative { from_second } else { from_first };
    let values = word ^ (ONES * u64::from(b'0'));
    // The top bit of what is no digit. A byte beyond ASCII carries into those behind it, but is no point itself.
    let others = (values.wrapping_add(ONES * 0x76) | values) & (ONES << 7);
    let end = (others & others.wrapping_sub(1)).trailing_zeros() & !7; // in bits
    if end >= 64 {
        return leading_long_decimal(&text[usize::from(negative)..], negative);
    }
    let point = others.trailing_zeros() & !7;
    if (word >> point) as u8 != b'.' || end < 16 {
        return None;
    }
    let below = (1u64 << point) - 1;
    let joined = (values & below) | ((values >> point >> 8) << point);
    // Moved to the end, behind zeros; what follows the number falls off.
    let mantissa = eight_digits(joined << (72 - end));
    Some(signed_decimal(mantissa, (end - point) / 8 - 1, negative, end / 8))
}

/// [`leading_decimal`] behind the sign, of up to 15 bytes.
#[inline(never)]
fn leading_long_decimal(digits: &[u8], negative: bool) -> Option<(f64, u8, usize)> {
    const ONES: u128 = u128::MAX / 0xff;
    let word = u128::from_le_bytes(*digits.first_chunk()?);
    let values = word ^ (ONES * u128::from(b'0'));
    let others = (values.wrapping_add(ONES * 0x76) | values) & (ONES << 7);
    let end = (others & others.wrapping_sub(1)).trailing_zeros() & !7;
    let point = others.trailing_zeros() & !7;
    if end >= 128 || (word >> point) as u8 != b'.' || end < 16 {
        return None;
    }
    let below = (1u128 << point) - 1;
    let joined = ((values & below) | ((values >> point >> 8) << point)) << (136 - end);
    let mantissa = eight_digits(joined as u64) * 100_000_000 + eight_digits((joined >> 64) as u64);
    Some(signed_decimal(mantissa, (end - point) / 8 - 1, negative, end / 8))
}

#[inline(always)]
fn signed_decimal(mantissa: u64, decimals: u32, negative: bool, length: u32) -> (f64, u8, usize) {
    let value = mantissa as f64 / TEN[decimals as usize];
    let value = f64::from_bits(value.to_bits() ^ (u64::from(negative) << 63));
    (value, decimals as u8, length as usize + usize::from(negative))
}

/// [`fixed_f64`] of the columns `from..to` (at most eight of them, the last one no earlier than the eighth of the line),
/// else [`parse_f64`] of what stands there.
#[inline(always)]
pub(super) fn column_f64(line: &[u8], from: usize, to: usize) -> Option<(f64, u8)> {
    let width = to.saturating_sub(from);
    if (1..=8).contains(&width)
        && let Some(text) = line.get(to.wrapping_sub(8)..to).and_then(|text| text.first_chunk())
    {
        // Eight bytes are loaded at once, and those of the column before are made blanks.
        let before = (1u64 << (8 * (8 - width))) - 1;
        let word = (u64::from_le_bytes(*text) & !before) | (u64::from_le_bytes([b' '; 8]) & before);
        if let Some(found) = fixed_f64(word.to_le_bytes()) {
            return Some(found);
        }
    }
    column_slowly(line, from, to)
}

#[cold]
fn column_slowly(line: &[u8], from: usize, to: usize) -> Option<(f64, u8)> {
    parse_f64(field(line, from, to))
}

/// The next blank-separated number of a line, its decimals, and what follows it: [`parse_f64`] of the next word, but in
/// one walk over the bytes where it is a usual one.
#[inline]
pub(super) fn next_f64(line: &[u8]) -> Option<(f64, u8, &[u8])> {
    let start = line.iter().position(|&byte| byte != b' ')?;
    if let Some(found) = next_short(line, start) {
        return Some(found);
    }
    let (negative, first) = match line[start] {
        b'-' => (true, start + 1),
        b'+' => (false, start + 1),
        _ => (false, start),
    };
    let mut mantissa = 0u64;
    let mut point = usize::MAX;
    let mut index = first;
    while let Some(&byte) = line.get(index) {
        let digit = byte.wrapping_sub(b'0');
        if digit < 10 {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        } else if byte == b'.' && point == usize::MAX {
            point = index;
        } else {
            break;
        }
        index += 1;
    }
    let has_point = point != usize::MAX;
    let length = index - first - usize::from(has_point);
    let ended = matches!(line.get(index), None | Some(b' '));
    if !ended || length == 0 || length > 15 {
        let (word, rest) = next_word(line)?;
        let (value, decimals) = parse_f64(word)?;
        return Some((value, decimals, rest));
    }
    let decimals = if has_point { index - point - 1 } else { 0 };
    let value = mantissa as f64 / TEN[decimals];
    Some((if negative { -value } else { value }, decimals as u8, &line[index..]))
}

/// [`next_f64`] by [`fixed_f64`]: of a number that begins at `start` and ends within eight bytes, or with the line.
#[inline]
fn next_short(line: &[u8], start: usize) -> Option<(f64, u8, &[u8])> {
    const ONES: u64 = 0x0101_0101_0101_0101;
    const BLANKS: u64 = ONES * b' ' as u64;
    if let Some(text) = line.get(start..).and_then(|rest| rest.first_chunk()) {
        let word = u64::from_le_bytes(*text);
        // The lowest byte that is 0 after this is the first blank.
        let blank = word ^ BLANKS;
        let zero = blank.wrapping_sub(ONES) & !blank & (ONES << 7);
        let bits = zero.trailing_zeros() & !7;
        if !(8..64).contains(&bits) {
            return None;
        }
        // Moved to the end, behind blanks.
        let (value, decimals) = fixed_f64((word << (64 - bits) | BLANKS >> bits).to_le_bytes())?;
        return Some((value, decimals, &line[start + bits as usize / 8..]));
    }
    let width = line.len() - start; // 1 to 7
    let before = (1u64 << (8 * (8 - width))) - 1;
    let word = (u64::from_le_bytes(*line.last_chunk()?) & !before) | (BLANKS & before);
    let (value, decimals) = fixed_f64(word.to_le_bytes())?;
    Some((value, decimals, &[]))
}

/// Three numbers, the most decimals among them, and what follows.
#[inline]
pub(super) fn next_vector(rest: &[u8]) -> Option<(DVec3, u8, &[u8])> {
    let (x, dx, rest) = next_f64(rest)?;
    let (y, dy, rest) = next_f64(rest)?;
    let (z, dz, rest) = next_f64(rest)?;
    Some((DVec3::new(x, y, z), dx.max(dy).max(dz), rest))
}

/// Exponents (Fortran's `D` too), long numbers, `nan`, `inf`.
#[cold]
fn parse_slowly(text: &[u8]) -> Option<(f64, u8)> {
    // The longest f64 that is written out in full has about 770 digits; more is no number of a molecule file.
    if text.len() > 800 {
        return None;
    }
    let text = std::str::from_utf8(text).ok()?.replace(['d', 'D'], "e");
    let value: f64 = text.parse().ok()?;
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((&text, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len()) as i64;
    let exponent: i64 = exponent.parse().unwrap_or(0);
    Some((value, u8::try_from(decimals.saturating_sub(exponent).max(0)).unwrap_or(u8::MAX)))
}

/// A decimal integer with an optional sign; `None` for anything else and for what an i64 does not hold.
#[inline]
pub(super) fn parse_i64(text: &[u8]) -> Option<i64> {
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    };
    if digits.is_empty() {
        return None;
    }
    // Eighteen digits fit whatever they are.
    let (sure, rest) = digits.split_at(digits.len().min(18));
    let mut value = 0i64;
    for &byte in sure {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value * 10 + i64::from(digit);
    }
    for &byte in rest {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value.checked_mul(10)?.checked_add(i64::from(digit))?;
    }
    Some(if negative { -value } else { value })
}

/// The decimals needed to write these values, at least `at_least`: for numbers that come without their text (JSON).
pub(super) fn decimals_of(values: &[f64], at_least: u8) -> u8 {
    let most = crate::structure::Positions::MAX_DECIMALS;
    let mut decimals = at_least.min(most);
    for &value in values {
        while decimals < most {
            let scale = TEN[usize::from(decimals)];
            if (value * scale).round() / scale == value {
                break;
            }
            decimals += 1;
        }
    }
    decimals
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn usual_and_odd_numbers_read_exactly() {
        for (text, value, decimals) in [
            ("0", 0.0, 0),
            ("-1.500", -1.5, 3),
            (".5", 0.5, 1),
            ("5.", 5.0, 0),
            ("+7.25", 7.25, 2),
            ("1.5e-3", 0.0015, 4),
            ("1.5D+02", 150.0, 0),
            ("1d0", 1.0, 0),
            ("0.1234567890123456789", 0.123_456_789_012_345_68, 19),
            ("-9999999999999999", -9_999_999_999_999_999.0, 0),
        ] {
            assert_eq!(parse_f64(text.as_bytes()), Some((value, decimals)), "{text}");
        }
        assert!(parse_f64(b"nan").unwrap().0.is_nan() && parse_f64(b"-inf").unwrap().0.is_infinite());
    }

    #[test]
    fn what_is_no_number_is_none() {
        for text in ["", "-", ".", "+.", "1.2.3", "1,5", " 1", "1 ", "0x10", "1e", "********", "1_0", "--1"] {
            assert_eq!(parse_f64(text.as_bytes()), None, "{text:?}");
        }
        for text in ["", "-", "1.0", " 1", "99999999999999999999"] {
            assert_eq!(parse_i64(text.as_bytes()), None, "{text:?}");
        }
        assert_eq!(parse_i64(b"-12"), Some(-12));
    }

    #[test]
    fn numbers_follow_one_another() {
        let mut line: &[u8] = b"  1.50 -2\t3d1  +.25";
        let mut found = Vec::new();
        while let Some((value, decimals, rest)) = next_f64(line) {
            found.push((value, decimals));
            line = rest;
        }
        assert_eq!(found, [(1.5, 2), (-2.0, 0), (30.0, 0), (0.25, 2)]);
        for text in ["", "   ", "-", "x", " 1x", "1.2.3 4"] {
            assert_eq!(next_f64(text.as_bytes()), None, "{text:?}");
        }
    }

    #[test]
    fn decimals_of_bare_numbers_are_found() {
        assert_eq!(decimals_of(&[1.0, -2.0], 0), 0);
        assert_eq!(decimals_of(&[1.5, 0.123], 0), 3);
        assert_eq!(decimals_of(&[1.5], 6), 6);
        assert_eq!(decimals_of(&[1.0 / 3.0], 0), crate::structure::Positions::MAX_DECIMALS);
    }

    #[test]
    fn decimals_are_read_from_where_they_begin() {
        for (text, want) in [
            ("1.250 2", Some((1.25, 3, 5))),
            ("-12.5\nC", Some((-12.5, 1, 5))),
            (".5\t", Some((0.5, 1, 2))),
            ("5. ", Some((5.0, 0, 2))),
            ("-1234567.1234567 ", Some((-1_234_567.123_456_7, 7, 16))),
            ("12345.6 ", Some((12345.6, 1, 7))),
            ("123456.7x", Some((123_456.7, 1, 8))),
            ("12345678.1234567 ", None),
            (". ", None),
            ("-. ", None),
            ("- 1.5", None),
            ("+1.5 ", None),
            ("15 ", None),
            ("1e5 ", None),
            ("", None),
        ] {
            let padded = format!("{text}{:20}", "");
            assert_eq!(leading_decimal(padded.as_bytes()), want, "{text}");
        }
        assert_eq!(leading_decimal(b"1.5 7"), None);
    }

    #[test]
    fn eight_columns_are_read_at_once() {
        for text in
            ["   1.250", "-999.999", "9999.999", "      .5", "      5.", "  -0.000", "12345678", "1.234567", "-.123456"]
        {
            let want = parse_f64(text.trim().as_bytes());
            let got = fixed_f64(text.as_bytes().try_into().unwrap());
            assert_eq!(got, if text.contains('.') { want } else { None }, "{text}");
        }
        for text in [
            "        ", "       .", "      -.", "1.2.3456", "  1 .500", "  1.5   ", "  +1.500", " 1.5E+01", "   - 1.5",
            "     -  ", " . -0000", "   . 500", ".-123456", "    .-.5",
        ] {
            assert_eq!(fixed_f64(text.as_bytes().try_into().unwrap()), None, "{text}");
        }
        assert_eq!(column_f64(b"12  1.50", 2, 8), Some((1.5, 2)));
        assert_eq!((column_f64(b"12  1.5", 2, 8), column_f64(b"12+1.5E0", 2, 8)), (Some((1.5, 1)), Some((1.5, 1))));
        assert_eq!(
            (column_f64(b"1.5", 0, 3), column_f64(b"", 0, 8), column_f64(b"123456789", 3, 3)),
            (Some((1.5, 1)), None, None)
        );
    }

    proptest! {
        #[test]
        fn eight_columns_are_read_as_any_number_is(text in "[ 0-9.+-]{8}|  ?-?[0-9]{1,4}\\.[0-9]{0,3}") {
            let text = format!("{text:>8}");
            if let Ok(bytes) = <[u8; 8]>::try_from(text.as_bytes())
                && let Some((value, decimals)) = fixed_f64(bytes)
            {
                let want = parse_f64(text.trim_ascii().as_bytes());
                prop_assert_eq!(want, Some((value, decimals)));
                prop_assert_eq!(want.unwrap().0.to_bits(), value.to_bits());
            }
        }

        #[test]
        fn leading_decimals_are_those_of_the_word(text in "-?[0-9]{0,8}\\.[0-9]{0,8}[ 0-9a.\n\u{e9}-]{0,2}|[ 0-9.-]{1,20}") {
            let padded = format!("{text}  1.25 -6.5 and more");
            if let Some((value, decimals, length)) = leading_decimal(padded.as_bytes()) {
                let (want, want_decimals) = parse_f64(&padded.as_bytes()[..length]).unwrap();
                prop_assert_eq!((value.to_bits(), decimals), (want.to_bits(), want_decimals));
                prop_assert!(!padded.as_bytes()[length].is_ascii_digit());
            }
        }

        #[test]
        fn numbers_in_a_row_are_those_of_the_words(line in "( {0,3}(-?[0-9]{0,5}\\.[0-9]{0,5}|[0-9+-]{1,9}|[0-9.e-]{1,7}) {0,2}\t?){1,4}") {
            let mut rest = line.as_bytes();
            while let Some((word, behind)) = next_word(rest) {
                let want = parse_f64(word);
                let got = next_f64(rest);
                prop_assert_eq!(got.map(|(value, decimals, _)| (value.to_bits(), decimals)), want.map(|(value, decimals)| (value.to_bits(), decimals)));
                prop_assert_eq!(got.map_or(behind, |(.., rest)| rest), behind);
                rest = behind;
            }
        }

        #[test]
        fn the_quick_way_gives_what_the_standard_library_gives(text in "-?[0-9]{1,9}\\.[0-9]{0,9}") {
            prop_assert_eq!(parse_f64(text.as_bytes()).unwrap().0, text.parse::<f64>().unwrap());
            let (value, decimals, rest) = next_f64(text.as_bytes()).unwrap();
            prop_assert_eq!((value, decimals), parse_f64(text.as_bytes()).unwrap());
            prop_assert!(rest.is_empty());
        }
    }
}
