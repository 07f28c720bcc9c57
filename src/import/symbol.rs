//! Elements from the labels that XYZ, SD and JSON files give their atoms (PDB names follow rules of their own).

use super::number::parse_i64;
use crate::element::Element;

/// What a label means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Label {
    pub(super) element: Element,
    /// Mass number if the label says one (`D`, `T`), else 0.
    pub(super) isotope: u16,
    /// Not an atom: dummy, lone pair, extra point.
    pub(super) particle: bool,
    pub(super) kind: LabelKind,
}

/// How sure the meaning is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LabelKind {
    /// A symbol or an atomic number.
    Symbol,
    /// A symbol with more behind it (`C12`, `Fe2+`): worth keeping as the atom's name.
    Name,
    /// The label begins with what may be a symbol (`OW`): a guess.
    Guess,
    /// No element known.
    Unknown,
}

impl Label {
    fn new(element: Element, isotope: u16, kind: LabelKind) -> Label {
        Label { element, isotope, particle: false, kind }
    }

    fn particle(kind: LabelKind) -> Label {
        Label { element: Element::DUMMY, isotope: 0, particle: true, kind }
    }
}

/// Reads a label: a symbol in any case, an atomic number, a symbol with a number or more behind it.
#[inline]
pub(super) fn read_label(label: &[u8]) -> Label {
    if let Some((element, isotope)) = Element::from_symbol_bytes(label) {
        return Label::new(element, isotope, LabelKind::Symbol);
    }
    read_odd_label(label)
}

fn read_odd_label(label: &[u8]) -> Label {
    if let Some(number) = parse_i64(label) {
        return match u8::try_from(number) {
            // 0 and −1 are how programs number dummies.
            Ok(0) => Label::particle(LabelKind::Symbol),
            Ok(z) => Element::from_z(z).map_or(Label::new(Element::DUMMY, 0, LabelKind::Unknown), |element| {
                Label::new(element, 0, LabelKind::Symbol)
            }),
            Err(_) if number == -1 => Label::particle(LabelKind::Symbol),
            Err(_) => Label::new(Element::DUMMY, 0, LabelKind::Unknown),
        };
    }
    let letters = &label[..label.iter().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(label.len())];
    let symbol = Element::from_symbol_bytes;
    if let Some((element, isotope)) = symbol(letters) {
        return Label::new(element, isotope, LabelKind::Name);
    }
    // Dummies and ghosts: X, Xx (many programs), Du (SYBYL), Bq (ghost of Gaussian, NWChem), Gh, Lp/LP (lone pairs),
    // Q, EP, M, MW (extra points of water models), Vac.
    let dummies: [&[u8]; 13] =
        [b"x", b"xx", b"du", b"bq", b"gh", b"lp", b"q", b"ep", b"m", b"mw", b"vac", b"dum", b"xxx"];
    let lower = letters.to_ascii_lowercase();
    if dummies.contains(&lower.as_slice()) || label == b"*" {
        let plain = letters.len() == label.len() || label == b"*";
        return Label::particle(if plain { LabelKind::Symbol } else { LabelKind::Name });
    }
    // A force-field type such as OW, HW, CT, Cax: the first letter, if that is a symbol; two letters only in the
    // usual case (`Clx`), since CA, CO, HO … are carbon and hydrogen types far more often.
    let two = letters.get(..2).filter(|two| two[1].is_ascii_lowercase()).and_then(symbol);
    match two.or_else(|| letters.get(..1).and_then(symbol)) {
        Some((element, isotope)) => Label::new(element, isotope, LabelKind::Guess),
        None => Label::new(Element::DUMMY, 0, LabelKind::Unknown),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_mean_what_chemists_mean() {
        for (label, symbol, isotope, kind) in [
            ("C", "C", 0, LabelKind::Symbol),
            ("cl", "Cl", 0, LabelKind::Symbol),
            ("FE", "Fe", 0, LabelKind::Symbol),
            ("D", "H", 2, LabelKind::Symbol),
            ("6", "C", 0, LabelKind::Symbol),
            ("C12", "C", 0, LabelKind::Name),
            ("Fe3+", "Fe", 0, LabelKind::Name),
            ("Cl1", "Cl", 0, LabelKind::Name),
            ("OW", "O", 0, LabelKind::Guess),
            ("HW1", "H", 0, LabelKind::Guess),
            ("Clx", "Cl", 0, LabelKind::Guess),
            ("Zz", "X", 0, LabelKind::Unknown),
            ("119", "X", 0, LabelKind::Unknown),
            ("é", "X", 0, LabelKind::Unknown),
        ] {
            let got = read_label(label.as_bytes());
            assert_eq!((got.element.symbol(), got.isotope, got.kind), (symbol, isotope, kind), "{label}");
            assert!(!got.particle);
        }
    }

    #[test]
    fn dummies_are_particles() {
        for label in ["X", "xx", "Du", "LP", "0", "-1", "*", "Bq", "X1"] {
            assert!(read_label(label.as_bytes()).particle, "{label}");
        }
    }
}
