//! From text to tokens with their places.

use super::error::{Expected, ParseError};
use std::ops::Range;

/// How a quantity is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compare {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    Different,
}

/// What a token is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Open,
    Close,
    Comma,
    Compare(Compare),
    And,
    Or,
    Not,
    Word,
    /// In quotes, which are not part of its text.
    Quoted,
}

/// A token.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Token<'a> {
    pub(super) kind: Kind,
    pub(super) text: &'a str,
    /// Bytes of the whole text, quotes included.
    pub(super) span: Range<usize>,
}

/// Signs, longer ones before those that they begin with.
const SIGNS: [(&str, Kind); 14] = [
    ("(", Kind::Open),
    (")", Kind::Close),
    (",", Kind::Comma),
    ("<=", Kind::Compare(Compare::LessOrEqual)),
    ("<", Kind::Compare(Compare::Less)),
    (">=", Kind::Compare(Compare::GreaterOrEqual)),
    (">", Kind::Compare(Compare::Greater)),
    ("==", Kind::Compare(Compare::Equal)),
    ("=", Kind::Compare(Compare::Equal)),
    ("!=", Kind::Compare(Compare::Different)),
    ("!", Kind::Not),
    ("&", Kind::And),
    ("|", Kind::Or),
    ("≠", Kind::Compare(Compare::Different)),
];

/// The tokens of a text.
pub(super) fn tokens(text: &str) -> Result<Vec<Token<'_>>, ParseError> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(next) = text[at..].chars().next() {
        let rest = &text[at..];
        if next.is_whitespace() {
            at += next.len_utf8();
        } else if let Some((sign, kind)) = SIGNS.iter().find(|(sign, _)| rest.starts_with(sign)) {
            // `&&` and `||` as programs have them.
            let length = if matches!(kind, Kind::And | Kind::Or) && rest[sign.len()..].starts_with(sign) {
                2
            } else {
                sign.len()
            };
            tokens.push(Token { kind: *kind, text: &rest[..length], span: at..at + length });
            at += length;
        } else if matches!(next, '"' | '\'') {
            let Some(length) = rest[1..].find(next) else {
                let message = format!("this quote is not closed: {next} is missing at the end");
                return Err(ParseError::new(text, at..text.len(), message, Expected::Nothing));
            };
            tokens.push(Token { kind: Kind::Quoted, text: &rest[1..1 + length], span: at..at + length + 2 });
            at += length + 2;
        } else {
            let ends = |c: char| c.is_whitespace() || "(),<>=!&|≠".contains(c);
            let length = rest.find(ends).unwrap_or(rest.len());
            tokens.push(Token { kind: Kind::Word, text: &rest[..length], span: at..at + length });
            at += length;
        }
    }
    Ok(tokens)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primes_are_letters_inside_names_and_quotes_before_them() {
        let texts =
            |text: &str| tokens(text).unwrap().into_iter().map(|t| (t.text.to_owned(), t.span)).collect::<Vec<_>>();
        assert_eq!(
            texts("name O5',C5*"),
            [("name".into(), 0..4), ("O5'".into(), 5..8), (",".into(), 8..9), ("C5*".into(), 9..12)]
        );
        assert_eq!(texts("chain 'a b'")[1], ("a b".to_owned(), 6..11));
        assert_eq!(texts("x<=-1.5")[1..], [("<=".into(), 1..3), ("-1.5".into(), 3..7)]);
        assert_eq!(texts("é≠ü").len(), 3);
        assert!(tokens("chain 'a").unwrap_err().to_string().contains("not closed"));
    }
}
