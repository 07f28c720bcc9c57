//! Values as CIF text: quoted where they need it.

use std::fmt::{self, Display};

/// A value; an empty one is `?`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Value<'a>(pub(super) &'a str);

impl Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0;
        if text.is_empty() {
            return f.write_str("?");
        }
        if is_plain(text) {
            return f.write_str(text);
        }
        // A quote closes only before a blank.
        let closes = |quote: char| {
            let mut after = false;
            text.chars().any(|c| std::mem::replace(&mut after, c == quote) && c.is_ascii_whitespace())
        };
        let one_line = !text.contains(['\n', '\r']);
        match ['\'', '"'].into_iter().find(|&quote| one_line && !closes(quote)) {
            Some(quote) => write!(f, "{quote}{text}{quote}"),
            // A text field ends at the next line that begins with a semicolon.
            None => write!(f, "\n;{}\n;\n", text.replace('\r', " ").replace("\n;", "\n ;")),
        }
    }
}

/// Whether it may stand without quotes.
fn is_plain(text: &str) -> bool {
    const WORDS: [&str; 5] = ["data_", "save_", "loop_", "stop_", "global_"];
    let begins = |word: &str| text.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
    !text.starts_with(['_', '#', '$', '\'', '"', '[', ']', ';'])
        && !text.contains(|c: char| c <= ' ' || c == '\u{7f}')
        && !matches!(text, "." | "?")
        && !WORDS.iter().any(|word| begins(word))
}

/// A number as short as it reads back, with two decimals at least; `?` for what is none.
pub(super) struct Number(pub(super) f32);

impl Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let two = format!("{:.2}", self.0);
        match () {
            () if !self.0.is_finite() => f.write_str("?"),
            () if two.parse() == Ok(self.0) => f.write_str(&two),
            () => self.0.fmt(f),
        }
    }
}

/// A one-character code, `.` for none.
pub(super) struct Code(pub(super) u8);

impl Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            b' ' => f.write_str("."),
            code => Value(char::from(code).encode_utf8(&mut [0; 4])).fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_needs_quotes_has_them() {
        for (value, want) in [
            ("CA", "CA"),
            ("O5'", "O5'"),
            ("", "?"),
            (".", "'.'"),
            ("_a", "'_a'"),
            ("a b", "'a b'"),
            ("5' end", "\"5' end\""),
            ("\"H\"", "'\"H\"'"),
            ("Loop_", "'Loop_'"),
            ("looped", "looped"),
            ("a' \" b", "\n;a' \" b\n;\n"),
            ("a\n;b", "\n;a\n ;b\n;\n"),
        ] {
            assert_eq!(Value(value).to_string(), want, "{value:?}");
        }
    }

    #[test]
    fn numbers_read_back() {
        for (value, want) in [(1.0, "1.00"), (0.35, "0.35"), (0.333, "0.333"), (f32::NAN, "?"), (20.125, "20.125")] {
            assert_eq!(Number(value).to_string(), want);
        }
        assert_eq!((Code(b' ').to_string(), Code(b'_').to_string()), (".".to_owned(), "'_'".to_owned()));
    }
}
