//! What is wrong with a selection, and where.

use super::words::NameOf;
use std::fmt;
use std::ops::Range;

/// What could have stood there; completions are made of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Expected {
    /// Nothing that can be listed.
    Nothing,
    /// A word that names atoms, or `not`, or a parenthesis.
    Term,
    /// `and`, `or`, or the end.
    Joint,
    /// A name of this kind.
    Name(NameOf),
    Element,
    /// `of` after a distance.
    Of,
    /// `to` after `bonded`.
    To,
    /// `residue`, `chain` or `molecule` after `same`.
    Group,
    /// `as` after these.
    As,
    /// A sign such as `<`.
    Compare,
}

/// What is wrong with a selection. Its `Display` shows the text with a mark under the place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParseError {
    /// The selection.
    pub text: String,
    /// The bytes of it that are wrong; empty at its end where something is missing.
    pub span: Range<usize>,
    /// What was expected and what was found.
    pub message: String,
    /// What was likely meant, if that can be told: a text that can stand in the place.
    pub instead: Option<String>,
    pub(super) expected: Expected,
}

impl ParseError {
    pub(super) fn new(text: &str, span: Range<usize>, message: impl Into<String>, expected: Expected) -> ParseError {
        ParseError { text: text.to_owned(), span, message: message.into(), instead: None, expected }
    }

    pub(super) fn instead(mut self, instead: Option<String>) -> ParseError {
        self.instead = instead;
        self
    }

    /// What is wrong, in a line.
    #[must_use]
    pub fn line(&self) -> String {
        match &self.instead {
            Some(instead) => format!("{}; did you mean `{instead}`?", self.message),
            None => self.message.clone(),
        }
    }
}

/// Characters that are shown of a long selection, before the place and behind it.
const SHOWN: (usize, usize) = (60, 40);

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // One column a character, whatever control characters are in it.
        let plain = |text: &str| text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<Vec<char>>();
        let before = plain(self.text.get(..self.span.start).unwrap_or_default());
        let marked = plain(self.text.get(self.span.clone()).unwrap_or_default());
        let after = plain(self.text.get(self.span.end..).unwrap_or_default());
        let cut = before.len().saturating_sub(SHOWN.0);
        let dots = if cut > 0 { "…" } else { "" };
        let shown: String = before[cut..].iter().chain(&marked).chain(&after).take(SHOWN.0 + SHOWN.1).collect();
        let pad = " ".repeat(before.len() - cut + dots.chars().count());
        let marks = "^".repeat(marked.len().clamp(1, SHOWN.1));
        write!(f, "{}\n  {dots}{shown}\n  {pad}{marks}", self.line())
    }
}

impl std::error::Error for ParseError {}
