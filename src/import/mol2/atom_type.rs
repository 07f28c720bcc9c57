//! Elements from MOL2 atom types and, where the types are a force field's, from atom names.
//!
//! A SYBYL type is a symbol, or a symbol with a suffix behind a dot (`C.3`, `N.pl3`, `Co.oh`, `H.spc`). AMBER and GAFF
//! types have neither the dot nor the meaning: GAFF's `ca` is an aromatic carbon, AMBER's `CA` too, `Ho`/`HO` the hydrogen
//! of a hydroxyl group. They are told apart for the molecule as a whole ([`is_foreign`]): one type that no SYBYL file can
//! have makes them all a force field's.

use super::super::symbol::{Label, LabelKind, read_label};
use crate::element::Element;

/// Whether a type is one that SYBYL does not have.
pub(super) fn is_foreign(kind: &[u8]) -> bool {
    if kind.contains(&b'.') || is_particle(kind) {
        return false;
    }
    // SYBYL writes symbols as chemists do; a force field's types are all capitals, all small, or have digits and signs.
    match kind {
        [first] => !first.is_ascii_uppercase() || symbol(kind).is_none(),
        [first, second] => !(first.is_ascii_uppercase() && second.is_ascii_lowercase()) || symbol(kind).is_none(),
        _ => true,
    }
}

/// Types that are no atoms: dummies, lone pairs, and those of queries.
fn is_particle(kind: &[u8]) -> bool {
    const PARTICLES: [&[u8]; 9] = [b"Du", b"LP", b"Lp", b"ANY", b"Any", b"HAL", b"HET", b"HEV", b"****"];
    PARTICLES.iter().any(|particle| particle.eq_ignore_ascii_case(kind))
}

fn symbol(text: &[u8]) -> Option<(Element, u16)> {
    std::str::from_utf8(text).ok().and_then(Element::from_symbol_isotope)
}

/// The element of an atom. `foreign` says that the molecule's types are a force field's.
pub(super) fn element(kind: &[u8], name: &[u8], foreign: bool) -> Label {
    if foreign {
        return of_name(kind, name);
    }
    let head = kind.split(|&byte| byte == b'.').next().unwrap_or_default();
    if is_particle(head) {
        return Label { element: Element::DUMMY, isotope: 0, particle: true, kind: LabelKind::Symbol };
    }
    match symbol(head) {
        Some((element, isotope)) => Label { element, isotope, particle: false, kind: LabelKind::Symbol },
        None => of_name(head, name),
    }
}

/// By the atom's name, which begins with its symbol. Two letters are a symbol only where the type begins with them too
/// or leaves no other reading: `CA` of an amino acid is carbon, `CL1` of type `cl` chlorine.
fn of_name(kind: &[u8], name: &[u8]) -> Label {
    if is_particle(kind) || kind.eq_ignore_ascii_case(b"EP") {
        return Label { element: Element::DUMMY, isotope: 0, particle: true, kind: LabelKind::Symbol };
    }
    let start = name.iter().position(u8::is_ascii_alphabetic).unwrap_or(name.len());
    let letters = &name[start..];
    let letters = &letters[..letters.iter().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(letters.len())];
    let of = |(element, isotope)| Label { element, isotope, particle: false, kind: LabelKind::Symbol };
    if let Some(two) = letters.get(..2).and_then(symbol)
        && (same_element(kind, letters) || letters.get(..1).and_then(symbol).is_none())
    {
        return of(two);
    }
    match letters.get(..1).and_then(symbol) {
        Some(one) => of(one),
        None => Label { kind: LabelKind::Unknown, ..read_label(kind) },
    }
}

/// Whether type and name agree on an element of two letters: halogens and ions. All other types of two letters are a
/// symbol of one letter and what it is bonded to; GAFF's `na` and `cu` are nitrogen and carbon, so that sodium and
/// caesium count only as AMBER writes them (`Na+`).
fn same_element(kind: &[u8], letters: &[u8]) -> bool {
    const TWO: [&[u8]; 10] = [b"cl", b"br", b"li", b"mg", b"zn", b"fe", b"mn", b"rb", b"si", b"se"];
    let head = |text: &[u8]| text.get(..2).map(<[u8]>::to_ascii_lowercase);
    let Some(named) = head(letters) else { return false };
    let ion = kind.get(1).is_some_and(u8::is_ascii_lowercase) && kind.last() == Some(&b'+');
    (ion || TWO.contains(&named.as_slice())) && head(kind).as_ref() == Some(&named)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sybyl_types_are_symbols_with_suffixes() {
        for (kind, want) in [
            ("C.ar", "C"),
            ("N.pl3", "N"),
            ("H.spc", "H"),
            ("Co.oh", "Co"),
            ("Cl", "Cl"),
            ("S.O2", "S"),
            ("CL", "Cl"),
            ("Any", "X"),
            ("Hal", "X"),
            ("Du.C", "X"),
            ("LP", "X"),
        ] {
            let got = element(kind.as_bytes(), b"Q9", false);
            assert_eq!(got.element.symbol(), want, "{kind}");
            assert_eq!(got.particle, want == "X", "{kind}");
        }
        for kind in ["C.ar", "Cl", "H", "Du", "LP", "Any", "Ca", "Du.C"] {
            assert!(!is_foreign(kind.as_bytes()), "{kind}");
        }
    }

    #[test]
    fn force_field_types_are_read_by_name() {
        for kind in ["CT", "c3", "ca", "OH", "N*", "hn", "o", "CA", "cl", "IP"] {
            assert!(is_foreign(kind.as_bytes()), "{kind}");
        }
        for (kind, name, want) in [
            ("ca", "C1", "C"),
            ("CA", "CA", "C"),
            ("HO", "HO2'", "H"),
            ("cl", "CL1", "Cl"),
            ("br", "Br", "Br"),
            ("OS", "O5*", "O"),
            ("nb", "NB", "N"),
            ("na", "NA", "N"),
            ("cu", "CU1", "C"),
            ("Na+", "NA", "Na"),
            ("hc", "1HB", "H"),
            ("EP", "EP1", "X"),
            ("p5", "P", "P"),
        ] {
            let got = element(kind.as_bytes(), name.as_bytes(), true).element.symbol();
            assert_eq!(got, want, "{kind} {name}");
        }
    }
}
