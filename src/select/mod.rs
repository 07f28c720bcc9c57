//! Selections: atoms by words, as in `chain A and not water` or `within 5 of ligand`.
//!
//! A text is cut into tokens (`token`), read by a grammar (`parse`) and asked of a structure (`eval`), which gives one truth an
//! atom. All words stand in one table (`words`), of which [`help`] and [`completions`] are made too. What protein, ligand and
//! ion mean is said in [`ResidueKind`]; distances are found by a tree of boxes (`near`), whatever the reach.
//!
//! A selection is of what is drawn ([`Scope`]): in a crystal with its copies, and by the distances there, as measurements are. It is
//! asked anew for every frame, so that `within 5 of ligand` follows the atoms.
//!
//! Limits: distances do not go across the faces of a unit cell; bonds that are cut there join nothing. Helices and strands are those
//! that the file states, and copies in a crystal have none.

mod complete;
mod error;
mod eval;
mod kinds;
mod near;
mod parse;
#[cfg(test)]
mod tests;
mod token;
mod words;

pub use complete::{Completion, Completions, completions};
pub use error::ParseError;
pub use kinds::{ResidueKind, ions, one_letter, residue_kinds};
pub use words::help;

use crate::crystal::Drawn;
use crate::structure::Structure;
use parse::Expr;
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::sync::Arc;
use words::NumberOf;

/// A selection as it was written, and what it means. Cheap to copy; equal if written the same.
#[derive(Debug, Clone)]
pub struct Selection {
    text: Arc<str>,
    expr: Arc<Expr>,
}

/// What a selection is asked of.
#[derive(Debug, Clone, Copy)]
pub struct Scope<'a> {
    /// The atoms, with the bonds among them.
    pub structure: &'a Structure,
    /// For every atom which one of its file it is, from 0; empty if all are as listed.
    pub listed: &'a [u32],
    /// The place of its file among all, from 1.
    pub file: u32,
}

impl<'a> Scope<'a> {
    /// A structure as its file lists it, the only one.
    #[must_use]
    pub fn of(structure: &'a Structure) -> Scope<'a> {
        Scope { structure, listed: &[], file: 1 }
    }

    /// What is drawn of a file.
    #[must_use]
    pub fn drawn(drawn: &'a Drawn, file: u32) -> Scope<'a> {
        Scope { structure: &drawn.structure, listed: &drawn.listed, file }
    }
}

impl Selection {
    /// Reads a selection.
    ///
    /// ```
    /// use ballstick::select::{Scope, Selection};
    /// let file = b"3\nwater\nO 0 0 0.12\nH 0 0.76 -0.47\nH 0 -0.76 -0.47\n";
    /// let document = ballstick::import::read_bytes(file, "water.xyz", &Default::default())?;
    /// let molecule = ballstick::bonds::assign(document.records[0].clone(), &Default::default());
    /// let selection = Selection::parse("bonded to element O").unwrap();
    /// assert_eq!(selection.atoms(Scope::of(&molecule)), [false, true, true]);
    /// assert!(Selection::parse("elemnt O").unwrap_err().to_string().contains("did you mean `element`?"));
    /// # Ok::<(), ballstick::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`ParseError`] that says where, what was expected, and what was likely meant.
    pub fn parse(text: &str) -> Result<Selection, ParseError> {
        let text = text.trim();
        Ok(Selection { expr: Arc::new(parse::parse(text)?), text: text.into() })
    }

    /// The selection as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether each atom is selected.
    #[must_use]
    pub fn atoms(&self, scope: Scope<'_>) -> Vec<bool> {
        eval::Context::new(scope).atoms(&self.expr)
    }

    /// Whether the places of atoms decide what is selected: another frame may have others.
    #[must_use]
    pub fn asks_places(&self) -> bool {
        self.expr.asks_places()
    }

    /// These atoms of a file (numbers from 1, ascending) by their numbers: in the file where `by_index`, else among those drawn.
    #[must_use]
    pub fn of_numbers(file: u32, numbers: &[u32], by_index: bool) -> Selection {
        let mut ranges: Vec<RangeInclusive<i64>> = Vec::new();
        for number in numbers.iter().map(|&number| i64::from(number)) {
            match ranges.last_mut() {
                Some(last) if number <= *last.end() + 1 => *last = *last.start()..=number.max(*last.end()),
                _ => ranges.push(number..=number),
            }
        }
        let texts: Vec<String> = (ranges.iter())
            .map(|range| match (range.start(), range.end()) {
                (first, last) if first == last => first.to_string(),
                (first, last) => format!("{first}-{last}"),
            })
            .collect();
        let word = if by_index { "index" } else { "drawn" };
        let text =
            if texts.is_empty() { "none".to_owned() } else { format!("file {file} and {word} {}", texts.join(",")) };
        Selection::ours(&text)
    }

    /// What any of these select.
    #[must_use]
    pub fn any_of(all: &[Selection]) -> Selection {
        match all {
            [] => Selection::ours("none"),
            [one] => one.clone(),
            several => {
                let texts: Vec<String> = several.iter().map(|one| format!("({one})")).collect();
                Selection::ours(&texts.join(" or "))
            }
        }
    }

    /// A text that was written here; one that is none selects nothing.
    fn ours(text: &str) -> Selection {
        Selection::parse(text)
            .unwrap_or_else(|_| Selection { text: "none".into(), expr: Arc::new(Expr::Or(Vec::new())) })
    }

    /// The same where files have other places: `new` gives the new place of an old one, `None` for a file that is not there any more.
    #[must_use]
    pub fn with_files(&self, new: impl Fn(u32) -> Option<u32>) -> Selection {
        let mut places = Vec::new();
        collect_files(&self.expr, &mut places);
        let mut text = self.text.to_string();
        // From behind, so that places before stay where they are.
        places.sort_unstable_by_key(|(span, _)| std::cmp::Reverse(span.start));
        for (span, ranges) in places {
            // More files than anybody opens are not looked for.
            let old = ranges.iter().flat_map(|range| *range.start().max(&1)..=*range.end().min(&10_000));
            let mut new: Vec<u32> = old.filter_map(|file| new(u32::try_from(file).ok()?)).collect();
            new.sort_unstable();
            new.dedup();
            let numbers: Vec<String> = new.iter().map(u32::to_string).collect();
            let instead = if new.is_empty() { "none".to_owned() } else { format!("file {}", numbers.join(",")) };
            text.replace_range(span, &instead);
        }
        if text == *self.text { self.clone() } else { Selection::ours(&text) }
    }
}

type FilePlace<'a> = (std::ops::Range<usize>, &'a [RangeInclusive<i64>]);

fn collect_files<'a>(expr: &'a Expr, places: &mut Vec<FilePlace<'a>>) {
    match expr {
        Expr::Numbers(NumberOf::File, ranges, span) => places.push((span.clone(), ranges)),
        Expr::Near(_, _, inner) | Expr::Bonded(inner) | Expr::Same(_, inner) | Expr::Not(inner) => {
            collect_files(inner, places);
        }
        Expr::And(all) | Expr::Or(all) => all.iter().for_each(|inner| collect_files(inner, places)),
        Expr::Set(_)
        | Expr::Names(..)
        | Expr::Elements(_)
        | Expr::Residues(_)
        | Expr::Numbers(..)
        | Expr::Compare(..) => {}
    }
}

impl PartialEq for Selection {
    fn eq(&self, other: &Selection) -> bool {
        self.text == other.text
    }
}

impl Eq for Selection {}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl FromStr for Selection {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Selection, ParseError> {
        Selection::parse(text)
    }
}
