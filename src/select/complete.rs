//! What can be written next: words of the grammar, and names that the structures have.
//!
//! The text before the word that is being typed goes through the grammar; where that stops, it says what it expected there.

use super::Scope;
use super::error::Expected;
use super::parse;
use super::token::{self, Kind};
use super::words::{self, GROUPS, Meaning, NameOf, WORDS};
use crate::element::Element;
use crate::structure::NameId;
use std::ops::Range;

/// Something that can be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Completion {
    /// What takes the place of the word that is being typed.
    pub text: String,
    /// What it finds, or an example; empty for names of the structure.
    pub help: &'static str,
}

/// What can be written at a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Completions {
    /// The bytes of the word that is being typed; empty where none is.
    pub span: Range<usize>,
    /// What can take its place, the likeliest first.
    pub all: Vec<Completion>,
}

/// Most of them that are given.
const MOST: usize = 200;

/// What can be written at a byte of a text, about these structures.
#[must_use]
pub fn completions(text: &str, at: usize, scopes: &[Scope<'_>]) -> Completions {
    let at = (0..=at.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
    let before = &text[..at];
    let nothing = || Completions { span: at..at, all: Vec::new() };
    // Inside quotes nobody knows better.
    let Ok(tokens) = token::tokens(before) else { return nothing() };
    // A word that ends here is still being typed.
    let typed = tokens.last().filter(|token| token.kind == Kind::Word && token.span.end == at);
    let span = typed.map_or(at..at, |token| token.span.clone());
    let (head, word) = (&before[..span.start], &before[span.start..]);
    let expected = match parse::parse(head) {
        // Behind a list another name may stand, too; the joint is likelier.
        Ok(_) => Expected::Joint,
        Err(error) if error.span.start >= head.trim_end().len() => error.expected,
        Err(_) => return nothing(),
    };
    let mut all = Vec::new();
    let mut add = |text: &str, help: &'static str| {
        let has_start = text.len() >= word.len()
            && text.is_char_boundary(word.len())
            && text[..word.len()].eq_ignore_ascii_case(word);
        if has_start && text != word && all.len() < MOST {
            all.push(Completion { text: text.to_owned(), help });
        }
    };
    match expected {
        Expected::Nothing => {}
        Expected::Term => {
            let terms = || WORDS.iter().filter(|word| !word.is_joint());
            terms().for_each(|term| add(term.name, term.help));
            // What only another name of it begins with is found as well, once something is typed.
            for term in terms().filter(|_| !word.is_empty()) {
                term.aliases.iter().for_each(|alias| add(alias, term.help));
            }
        }
        Expected::Joint => {
            add("and", "what is both");
            add("or", "what is one of the two");
        }
        Expected::Of => add("of", "within 5 of ligand"),
        Expected::To => add("to", "bonded to element Fe"),
        Expected::As => add("as", "same residue as name SG"),
        Expected::Group => GROUPS.iter().for_each(|(name, _)| add(name, "same residue as name SG")),
        Expected::Compare => ["<", "<=", ">", ">=", "=", "!="].into_iter().for_each(|sign| add(sign, "bfactor > 30")),
        Expected::Element => elements(scopes).iter().for_each(|element| add(element.symbol(), element.name())),
        Expected::Name(of) => {
            for name in names(of, scopes) {
                add(&quoted(&name), "");
            }
        }
    }
    Completions { span, all }
}

/// The elements of structures, the most frequent first.
fn elements(scopes: &[Scope<'_>]) -> Vec<Element> {
    let mut counts = [0usize; Element::MAX_Z as usize + 1];
    for element in scopes.iter().flat_map(|scope| scope.structure.elements()) {
        counts[usize::from(element.z())] += 1;
    }
    let mut all: Vec<(usize, Element)> = (1..=Element::MAX_Z)
        .filter_map(|z| Some((counts[usize::from(z)], Element::from_z(z)?)))
        .filter(|&(count, _)| count > 0)
        .collect();
    all.sort_by_key(|&(count, _)| std::cmp::Reverse(count));
    all.into_iter().map(|(_, element)| element).collect()
}

/// The names of this kind in structures, each once, in their order.
fn names(of: NameOf, scopes: &[Scope<'_>]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for scope in scopes {
        let structure = scope.structure;
        let mut once = |ids: &mut dyn Iterator<Item = NameId>| {
            let mut seen = Vec::new();
            for id in ids {
                if seen.len() <= id.index() {
                    seen.resize(id.index() + 1, false);
                }
                if !std::mem::replace(&mut seen[id.index()], true) {
                    all.push(structure.name(id).trim().to_owned());
                }
            }
        };
        match of {
            NameOf::Atom => once(&mut structure.atom_names().iter().copied()),
            NameOf::Residue => once(&mut structure.residues().iter().map(|residue| residue.name)),
            NameOf::Chain => all.extend(structure.chains().map(|chain| chain.trim().to_owned())),
            NameOf::Altloc => {
                let mut seen = [false; 256];
                (0..structure.atom_count()).for_each(|atom| seen[usize::from(structure.altloc(atom))] = true);
                all.extend(
                    (b'!'..=b'~').filter(|&code| seen[usize::from(code)]).map(|code| char::from(code).to_string()),
                );
            }
        }
    }
    let mut seen = std::collections::HashSet::new();
    all.retain(|name| seen.insert(name.clone()));
    if of != NameOf::Chain {
        all.sort_unstable();
    }
    all
}

/// A name as a list takes it.
fn quoted(name: &str) -> String {
    let is_plain =
        matches!(token::tokens(name).as_deref(), Ok([token]) if token.kind == Kind::Word && token.text == name);
    let is_keyword =
        words::find(name).is_some_and(|word| word.name.len() > 1 || matches!(word.meaning, Meaning::And | Meaning::Or));
    match (is_plain && !is_keyword && !name.contains(['*', '?']), name.contains('"')) {
        (true, _) => name.to_owned(),
        (false, false) => format!("\"{name}\""),
        (false, true) => format!("'{name}'"),
    }
}
