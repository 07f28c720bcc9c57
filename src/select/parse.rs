//! The grammar, by recursive descent:
//!
//! ```text
//! either  = both { "or" both }
//! both    = term { "and" term }
//! term    = "not" term | "(" either ")" | word with its values
//! ```
//!
//! `within 5 of`, `bonded to`, `same residue as` and `byres` take one term, as `not` does. Values of a list stand behind commas or
//! blanks; behind a blank a keyword is none of them, so that a forgotten `and` is told.

use super::error::{Expected, ParseError};
use super::token::{Compare, Kind, Token, tokens};
use super::words::{self, GROUPS, Group, Meaning, NameOf, Near, NumberOf, Quantity, Set};
use crate::element::Element;
use std::ops::{Range, RangeInclusive};

/// A pattern for names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Pattern {
    pub(super) text: String,
    /// Whether `*` and `?` stand for other letters.
    pub(super) is_wild: bool,
}

/// The first or last residue of a range; without a letter all of its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ResidueEnd {
    pub(super) number: i32,
    pub(super) code: Option<u8>,
}

/// What a selection means.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Expr {
    Set(Set),
    Names(NameOf, Vec<Pattern>),
    /// With mass numbers, 0 for any.
    Elements(Vec<(Element, u16)>),
    Residues(Vec<(ResidueEnd, ResidueEnd)>),
    /// With their place in the text, from the word to the last number.
    Numbers(NumberOf, Vec<RangeInclusive<i64>>, Range<usize>),
    Compare(Quantity, Compare, f64),
    Near(Near, f64, Box<Expr>),
    Bonded(Box<Expr>),
    Same(Group, Box<Expr>),
    Not(Box<Expr>),
    And(Vec<Expr>),
    Or(Vec<Expr>),
}

impl Expr {
    /// As [`super::Selection::asks_places`].
    pub(super) fn asks_places(&self) -> bool {
        match self {
            Expr::Near(..) | Expr::Compare(Quantity::X | Quantity::Y | Quantity::Z, ..) => true,
            Expr::Bonded(inner) | Expr::Same(_, inner) | Expr::Not(inner) => inner.asks_places(),
            Expr::And(all) | Expr::Or(all) => all.iter().any(Expr::asks_places),
            Expr::Compare(..)
            | Expr::Set(_)
            | Expr::Names(..)
            | Expr::Elements(_)
            | Expr::Residues(_)
            | Expr::Numbers(..) => false,
        }
    }
}

/// Terms inside one another; deeper ones are no selection that anybody writes.
const DEEPEST: usize = 64;

/// Reads a selection.
pub(super) fn parse(text: &str) -> Result<Expr, ParseError> {
    let tokens = tokens(text)?;
    let mut parser = Parser { text, tokens: &tokens, at: 0, depth: 0 };
    let expr = parser.either()?;
    match parser.peek() {
        None => Ok(expr),
        Some(token) if token.kind == Kind::Close => Err(parser.wrong("this parenthesis closes none", Expected::Joint)),
        Some(token) => {
            let instead = words::find(token.text)
                .filter(|_| token.kind == Kind::Word)
                .map(|word| format!("and {}", word.name))
                .or_else(|| near_joint(token.text));
            Err(parser.wrong("expected and, or, or the end", Expected::Joint).instead(instead))
        }
    }
}

/// `and` or `or` with letters in another order; in small letters, as NAD and DNA are names.
fn near_joint(text: &str) -> Option<String> {
    let is_like = |joint: &str| {
        let mut letters: Vec<char> = text.chars().collect();
        let mut own: Vec<char> = joint.chars().collect();
        letters.sort_unstable();
        own.sort_unstable();
        letters == own
    };
    ["and", "or"].into_iter().find(|joint| is_like(joint)).map(str::to_owned)
}

struct Parser<'t> {
    text: &'t str,
    tokens: &'t [Token<'t>],
    at: usize,
    depth: usize,
}

impl<'t> Parser<'t> {
    fn peek(&self) -> Option<&'t Token<'t>> {
        self.tokens.get(self.at)
    }

    fn next(&mut self) -> Option<&'t Token<'t>> {
        let token = self.tokens.get(self.at)?;
        self.at += 1;
        Some(token)
    }

    /// An error at the next token.
    fn wrong(&self, message: &str, expected: Expected) -> ParseError {
        match self.peek() {
            Some(token) => {
                let found = self.text.get(token.span.clone()).unwrap_or_default();
                ParseError::new(self.text, token.span.clone(), format!("{message}; found {found}"), expected)
            }
            None => {
                let end = self.text.len();
                ParseError::new(self.text, end..end, format!("{message}; the selection ends here"), expected)
            }
        }
    }

    /// An error at a token that was read.
    fn wrong_at(&self, token: &Token<'_>, message: impl Into<String>, expected: Expected) -> ParseError {
        ParseError::new(self.text, token.span.clone(), message, expected)
    }

    /// Whether the next token is this joint, which is then read.
    fn takes(&mut self, kind: Kind, meaning: Meaning) -> bool {
        let is_it = self.peek().is_some_and(|token| {
            token.kind == kind
                || token.kind == Kind::Word && words::find(token.text).is_some_and(|word| word.meaning == meaning)
        });
        self.at += usize::from(is_it);
        is_it
    }

    /// Whether the next token is this word, which is then read.
    fn takes_word(&mut self, word: &str) -> bool {
        let is_it = self.peek().is_some_and(|token| token.kind == Kind::Word && token.text.eq_ignore_ascii_case(word));
        self.at += usize::from(is_it);
        is_it
    }

    fn either(&mut self) -> Result<Expr, ParseError> {
        let mut all = vec![self.both()?];
        while self.takes(Kind::Or, Meaning::Or) {
            all.push(self.both()?);
        }
        Ok(if all.len() > 1 { Expr::Or(all) } else { all.swap_remove(0) })
    }

    fn both(&mut self) -> Result<Expr, ParseError> {
        let mut all = vec![self.term()?];
        while self.takes(Kind::And, Meaning::And) {
            all.push(self.term()?);
        }
        Ok(if all.len() > 1 { Expr::And(all) } else { all.swap_remove(0) })
    }

    /// A term inside another one.
    fn term(&mut self) -> Result<Expr, ParseError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.wrong(&format!("more than {DEEPEST} terms inside one another"), Expected::Nothing));
        }
        let term = self.term_inside();
        self.depth -= 1;
        term
    }

    fn term_inside(&mut self) -> Result<Expr, ParseError> {
        const WANTED: &str = "expected what to select, such as chain A or water";
        let Some(token) = self.peek() else { return Err(self.wrong(WANTED, Expected::Term)) };
        match token.kind {
            Kind::Open => {
                self.at += 1;
                let inner = self.either()?;
                match self.peek() {
                    Some(close) if close.kind == Kind::Close => self.at += 1,
                    _ => return Err(self.wrong("expected and, or, or a closing parenthesis", Expected::Joint)),
                }
                Ok(inner)
            }
            Kind::Not => {
                self.at += 1;
                Ok(Expr::Not(Box::new(self.term()?)))
            }
            Kind::Word => match words::find(token.text) {
                Some(word) if !word.is_joint() => {
                    self.at += 1;
                    self.word(token, word.meaning)
                }
                _ => {
                    let error = self.wrong(WANTED, Expected::Term);
                    Err(error.instead(words::likely(token.text)))
                }
            },
            _ => Err(self.wrong(WANTED, Expected::Term)),
        }
    }

    /// What stands behind a word.
    fn word(&mut self, token: &'t Token<'t>, meaning: Meaning) -> Result<Expr, ParseError> {
        Ok(match meaning {
            Meaning::Set(set) => Expr::Set(set),
            Meaning::Names(of) => {
                let (wanted, expected) = (wanted_name(of), Expected::Name(of));
                Expr::Names(of, self.list(wanted, expected, |_, value| Ok(pattern(value)))?)
            }
            Meaning::Elements => Expr::Elements(self.list("an element, such as Fe", Expected::Element, element)?),
            Meaning::Residues => match self.comparison(Quantity::Residue)? {
                Some(comparison) => comparison,
                None => {
                    let wanted = "the number of a residue, such as 12 or 10-20";
                    Expr::Residues(self.list(wanted, Expected::Nothing, residues)?)
                }
            },
            Meaning::Numbers(of) => match self.comparison(Quantity::Number(of))? {
                Some(comparison) => comparison,
                None => {
                    let ranges = self.list("a number, such as 12 or 10-20", Expected::Nothing, integers)?;
                    let end = self.tokens[self.at - 1].span.end;
                    Expr::Numbers(of, ranges, token.span.start..end)
                }
            },
            Meaning::Quantity(quantity) => match self.comparison(quantity)? {
                Some(comparison) => comparison,
                None => {
                    let message = format!("expected <, <=, >, >=, = or != behind {}", token.text);
                    return Err(self.wrong(&message, Expected::Compare));
                }
            },
            Meaning::Near(near) => {
                let reach = self.number("a distance in ångström, such as 5")?;
                if reach < 0.0 {
                    let last = &self.tokens[self.at - 1];
                    return Err(self.wrong_at(last, "a distance is 0 or more", Expected::Nothing));
                }
                // `5 Å of` as people write it.
                let _ = self.takes_word("Å") || self.takes_word("A") || self.takes_word("angstrom");
                if !self.takes_word("of") {
                    return Err(self.wrong("expected of, as in within 5 of ligand", Expected::Of));
                }
                Expr::Near(near, reach, Box::new(self.term()?))
            }
            Meaning::Bonded => {
                let has_to = self.takes_word("to");
                if !has_to && token.text.eq_ignore_ascii_case("bonded") {
                    return Err(self.wrong("expected to, as in bonded to element Fe", Expected::To));
                }
                Expr::Bonded(Box::new(self.term()?))
            }
            Meaning::Same => {
                let group = self.peek().filter(|token| token.kind == Kind::Word).and_then(|token| {
                    GROUPS.iter().find(|(name, _)| name.eq_ignore_ascii_case(token.text)).map(|&(_, group)| group)
                });
                let Some(group) = group else {
                    return Err(
                        self.wrong("expected residue, chain or molecule, as in same residue as", Expected::Group)
                    );
                };
                self.at += 1;
                if !self.takes_word("as") {
                    return Err(self.wrong("expected as, as in same residue as name SG", Expected::As));
                }
                Expr::Same(group, Box::new(self.term()?))
            }
            Meaning::By(group) => Expr::Same(group, Box::new(self.term()?)),
            Meaning::Not => Expr::Not(Box::new(self.term()?)),
            // Not asked for: they begin no term.
            Meaning::And | Meaning::Or => return Err(self.wrong("expected what to select", Expected::Term)),
        })
    }

    /// A comparison, if a sign of one follows.
    fn comparison(&mut self, quantity: Quantity) -> Result<Option<Expr>, ParseError> {
        let Some(Token { kind: Kind::Compare(compare), .. }) = self.peek() else { return Ok(None) };
        self.at += 1;
        Ok(Some(Expr::Compare(quantity, *compare, self.number("a number, such as 30")?)))
    }

    fn number(&mut self, wanted: &str) -> Result<f64, ParseError> {
        let number = self.peek().and_then(|token| token.text.parse::<f64>().ok()).filter(|number| number.is_finite());
        let Some(number) = number else { return Err(self.wrong(&format!("expected {wanted}"), Expected::Nothing)) };
        self.at += 1;
        Ok(number)
    }

    /// One value and those that follow it.
    fn list<T>(
        &mut self,
        wanted: &str,
        expected: Expected,
        read: impl Fn(&mut Parser<'t>, &'t Token<'t>) -> Result<T, ParseError>,
    ) -> Result<Vec<T>, ParseError> {
        let is_value = |token: &Token<'_>| matches!(token.kind, Kind::Word | Kind::Quoted);
        let mut all = Vec::new();
        loop {
            let is_first = all.is_empty();
            match self.peek() {
                // A joint is never a name unless it is quoted.
                Some(token)
                    if is_value(token)
                        && (token.kind == Kind::Quoted
                            || !words::find(token.text).is_some_and(words::Word::is_joint)) =>
                {
                    self.at += 1;
                    let value = read(self, token).map_err(|mut error| {
                        error.expected = expected;
                        error
                    })?;
                    all.push(value);
                }
                _ if is_first => return Err(self.wrong(&format!("expected {wanted}"), expected)),
                _ => return Err(self.wrong(&format!("expected {wanted} behind the comma"), expected)),
            }
            match self.peek() {
                Some(token) if token.kind == Kind::Comma => self.at += 1,
                Some(token) if token.kind == Kind::Quoted => {}
                Some(token) if token.kind == Kind::Word => match words::find(token.text) {
                    Some(word) if word.is_joint() => return Ok(all),
                    // `chain X Y`: coordinates have signs behind them.
                    Some(word) if word.name.len() == 1 => {}
                    Some(word) => {
                        let message = format!("expected and, or, or a comma before {}", token.text);
                        let error = self.wrong(&message, Expected::Joint);
                        return Err(error.instead(Some(format!("and {}", word.name))));
                    }
                    None if near_joint(token.text).is_some() => return Ok(all),
                    None => {}
                },
                _ => return Ok(all),
            }
        }
    }
}

fn wanted_name(of: NameOf) -> &'static str {
    match of {
        NameOf::Chain => "a chain, such as A",
        NameOf::Residue => "the name of a residue, such as ALA",
        NameOf::Atom => "the name of an atom, such as CA",
        NameOf::Altloc => "the letter of an alternate location, such as A",
    }
}

fn pattern(token: &Token<'_>) -> Pattern {
    let is_wild = token.kind == Kind::Word && token.text.contains(['*', '?']);
    Pattern { text: token.text.to_owned(), is_wild }
}

fn element(parser: &mut Parser<'_>, token: &Token<'_>) -> Result<(Element, u16), ParseError> {
    let by_name = || {
        let mut all = (1..=Element::MAX_Z).filter_map(Element::from_z);
        all.find(|element| element.name().eq_ignore_ascii_case(token.text)).map(|element| (element, 0))
    };
    Element::from_symbol_isotope(token.text)
        .or_else(by_name)
        .ok_or_else(|| parser.wrong_at(token, format!("{} is no element", token.text), Expected::Element))
}

/// The two ends of `10-20`, `10:20` or `10 to 20`; the same twice for one number. A minus before the first digit is a sign.
fn ends<'t>(parser: &mut Parser<'t>, token: &'t Token<'t>) -> [&'t str; 2] {
    let text = token.text;
    if let Some((at, sign)) = text.char_indices().skip(1).find(|&(_, c)| matches!(c, '-' | ':' | '–')) {
        return [&text[..at], &text[at + sign.len_utf8()..]];
    }
    if parser.takes_word("to") {
        return [text, parser.next().map_or("", |last| last.text)];
    }
    [text, text]
}

fn integers<'t>(parser: &mut Parser<'t>, token: &'t Token<'t>) -> Result<RangeInclusive<i64>, ParseError> {
    let [first, last] = ends(parser, token).map(|text| text.parse::<i64>().ok());
    match (first, last) {
        (Some(first), Some(last)) if first <= last => Ok(first..=last),
        (Some(first), Some(last)) => {
            let error = parser.wrong_at(token, "a range goes from the lower number to the higher", Expected::Nothing);
            Err(error.instead(Some(format!("{last}-{first}"))))
        }
        _ => {
            let message = format!("expected a number, such as 12 or 10-20; found {}", token.text);
            Err(parser.wrong_at(token, message, Expected::Nothing))
        }
    }
}

fn residues<'t>(parser: &mut Parser<'t>, token: &'t Token<'t>) -> Result<(ResidueEnd, ResidueEnd), ParseError> {
    let end = |text: &str| -> Option<ResidueEnd> {
        let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let code = match &text.as_bytes()[number.len()..] {
            [] => None,
            &[code] => Some(code),
            _ => return None,
        };
        Some(ResidueEnd { number: number.parse().ok()?, code })
    };
    let [first, last] = ends(parser, token).map(end);
    match (first, last) {
        (Some(first), Some(last)) if (first.number, first.code) <= (last.number, last.code.or(Some(u8::MAX))) => {
            Ok((first, last))
        }
        (Some(_), Some(_)) => {
            Err(parser.wrong_at(token, "a range goes from the lower number to the higher", Expected::Nothing))
        }
        _ => {
            let message = format!("expected the number of a residue, such as 12 or 10-20; found {}", token.text);
            let error = parser.wrong_at(token, message, Expected::Nothing);
            let is_name = token.text.starts_with(|c: char| c.is_ascii_alphabetic());
            Err(error.instead(is_name.then(|| format!("resname {}", token.text))))
        }
    }
}
