//! What type symbols, labels and disorder groups of CIF files mean.

use super::super::pdb::element;
use crate::element::Element;
use std::collections::HashMap;

/// What a type symbol or a label means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::import) struct Meaning {
    pub(in crate::import) element: Element,
    /// 2 or 3 for deuterium and tritium, else 0.
    pub(in crate::import) isotope: u16,
    pub(in crate::import) charge: i8,
}

impl Meaning {
    fn of(symbol: &[u8]) -> Option<Meaning> {
        let (element, isotope) = Element::from_symbol_isotope(std::str::from_utf8(symbol).ok()?)?;
        Some(Meaning { element, isotope, charge: 0 })
    }
}

/// A type symbol: an element, with what small-molecule files put behind it: charges (`Fe3+`, `O2-`, `Cu+2`, `Na+`)
/// and numbers of types of their own (`C1`). `None` for what begins with no element.
#[inline]
pub(in crate::import) fn type_symbol(text: &str) -> Option<Meaning> {
    Meaning::of(text.as_bytes()).or_else(|| decorated(text.trim_ascii()))
}

#[cold]
fn decorated(text: &str) -> Option<Meaning> {
    let end = text.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (letters, rest) = text.split_at(end);
    // `Cval`, `Owat`: types named after their element.
    let meaning = [letters, letters.get(..2).unwrap_or(""), letters.get(..1).unwrap_or("")]
        .iter()
        .find_map(|letters| Meaning::of(letters.as_bytes()))?;
    Some(Meaning { charge: charge(rest).unwrap_or(0), ..meaning })
}

/// `3+`, `+3`, `+`, `1-`.
fn charge(text: &str) -> Option<i8> {
    let sign_at = text.find(['+', '-'])?;
    let (before, after) = text.split_at(sign_at);
    let digits = if before.is_empty() { &after[1..] } else { before };
    let size: i8 = if digits.is_empty() { 1 } else { digits.parse().ok()? };
    Some(if after.starts_with('-') { -size } else { size })
}

/// The element of a label without a type symbol (`Fe1`, `C12A`, `O1W`, `CU2`): by the definition of labels the letters
/// they begin with, though labels in capitals are often letter and site (`CA`, `HO2`), so that there two letters
/// count only if nothing else can be meant.
pub(super) fn element_of_label(label: &str) -> Option<Meaning> {
    let letters = &label[..label.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(label.len())];
    let two = letters.get(..2).filter(|two| two.as_bytes()[1].is_ascii_lowercase());
    two.and_then(|two| Meaning::of(two.as_bytes())).or_else(|| element_of_name(label, ""))
}

/// The element of an atom of a residue by its name.
pub(super) fn element_of_name(name: &str, residue: &str) -> Option<Meaning> {
    let guess = element::guess(name.as_bytes(), residue.as_bytes(), || false);
    (guess.element.z() != 0).then_some(Meaning { element: guess.element, isotope: guess.isotope, charge: 0 })
}

/// Letters and digits for the alternatives of a small-molecule structure.
///
/// A CIF names alternatives by assembly (which atoms are disordered together) and group (which of their alternatives):
/// each pair gets a code of its own. Groups without an assembly keep their number.
#[derive(Debug, Default)]
pub(super) struct DisorderCodes {
    codes: HashMap<(String, i64), u8>,
}

impl DisorderCodes {
    /// The code of a pair; the sign of the group, which says that the alternatives lie about a symmetry element, does
    /// not count. Beyond 62 pairs all get `~`.
    pub(super) fn code(&mut self, assembly: &str, group: i64) -> u8 {
        let key = (assembly.to_owned(), group.saturating_abs());
        if let Some(&code) = self.codes.get(&key) {
            return code;
        }
        let taken = |code: &u8| self.codes.values().any(|other| other == code);
        let digit = u8::try_from(key.1).ok().filter(|group| (1..=9).contains(group) && assembly.is_empty());
        let preferred = digit.map(|digit| b'0' + digit);
        let all = preferred.into_iter().chain(b'A'..=b'Z').chain(b'a'..=b'z').chain(b'1'..=b'9');
        let code = all.into_iter().find(|code| !taken(code)).unwrap_or(b'~');
        if code != b'~' {
            self.codes.insert(key, code);
        }
        code
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn type_symbols_carry_charges() {
        for (text, symbol, charge) in [
            ("C", "C", 0),
            ("FE", "Fe", 0),
            ("Fe3+", "Fe", 3),
            ("O2-", "O", -2),
            ("O1-", "O", -1),
            ("Cu+2", "Cu", 2),
            ("Na+", "Na", 1),
            ("Cl-", "Cl", -1),
            ("C1", "C", 0),
            ("D", "H", 0),
            ("Cval", "C", 0),
        ] {
            let meaning = type_symbol(text).unwrap();
            assert_eq!((meaning.element.symbol(), meaning.charge), (symbol, charge), "{text}");
        }
        assert_eq!(type_symbol("D").unwrap().isotope, 2);
        for text in ["", "X", "?", "12", "+"] {
            assert_eq!(type_symbol(text), None, "{text}");
        }
    }

    #[test]
    fn labels_begin_with_their_element() {
        for (label, symbol) in [
            ("C12A", "C"),
            ("Fe1", "Fe"),
            ("CU2", "Cu"),
            ("Na1", "Na"),
            ("O1W", "O"),
            ("HO2", "H"),
            ("Ho1", "Ho"),
            ("H12A", "H"),
            ("CA1", "C"),
            ("CL1", "Cl"),
        ] {
            assert_eq!(element_of_label(label).unwrap().element.symbol(), symbol, "{label}");
        }
        assert_eq!(element_of_label("Q1"), None);
        assert_eq!(element_of_label(""), None);
    }

    #[test]
    fn each_disordered_alternative_has_its_own_code() {
        let mut codes = DisorderCodes::default();
        let pairs = [("", 1), ("", 2), ("A", 1), ("A", 2), ("", -1), ("B", 1), ("", 12)];
        let got: Vec<u8> = pairs.iter().map(|&(assembly, group)| codes.code(assembly, group)).collect();
        assert_eq!(got, b"12AB1CD");
        let many: Vec<u8> = (100..200).map(|group| codes.code("", group)).collect();
        assert_eq!(many.iter().filter(|&&code| code == b'~').count(), 100 - (61 - 6));
    }
}
