//! Elements of PDB atoms: the element column, or else the atom name as the format means it.
//!
//! The format aligns names: the element symbol ends in the second of the four columns, so ` CA ` is a carbon and
//! `CA  ` calcium, except that names of four characters (`HG11`) begin in the first. Not every program keeps to it,
//! so what is known of the residue goes first, and in files that align nothing the alignment is not asked.

use super::super::text::columns;
use crate::element::Element;

/// What a name means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::import) struct Guess {
    pub(in crate::import) element: Element,
    pub(in crate::import) isotope: u16,
    /// Lone pair, Drude particle, mass-less site of a water model.
    pub(in crate::import) particle: bool,
}

impl Guess {
    const UNKNOWN: Guess = Guess { element: Element::DUMMY, isotope: 0, particle: false };
    pub(in crate::import) const PARTICLE: Guess = Guess { element: Element::DUMMY, isotope: 0, particle: true };

    pub(super) fn of(symbol: &[u8]) -> Option<Guess> {
        let (element, isotope) = Element::from_symbol_bytes(symbol)?;
        Some(Guess { element, isotope, particle: false })
    }
}

/// The first letters of a name, digits before them left out (`1HB` → `HB`).
fn letters(name: &[u8]) -> &[u8] {
    let start = name.iter().position(|byte| !byte.is_ascii_digit() && *byte != b' ').unwrap_or(name.len());
    let rest = &name[start..];
    &rest[..rest.iter().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(rest.len())]
}

/// Residues whose atoms are H, C, N, O, S, P (and Se): amino acids, nucleotides, caps, with their force-field names.
pub(super) fn is_polymer(residue: &[u8]) -> bool {
    match residue.len() {
        1 => matches!(residue[0], b'A' | b'C' | b'G' | b'U' | b'T' | b'I' | b'N'),
        2 => matches!(
            residue,
            b"DA"
                | b"DC"
                | b"DG"
                | b"DT"
                | b"DU"
                | b"DI"
                | b"RA"
                | b"RC"
                | b"RG"
                | b"RU"
                | b"A3"
                | b"A5"
                | b"C3"
                | b"C5"
                | b"G3"
                | b"G5"
                | b"U3"
                | b"U5"
        ),
        3 => matches!(
            residue,
            b"ALA"
                | b"ARG"
                | b"ASN"
                | b"ASP"
                | b"CYS"
                | b"GLN"
                | b"GLU"
                | b"GLY"
                | b"HIS"
                | b"ILE"
                | b"LEU"
                | b"LYS"
                | b"MET"
                | b"PHE"
                | b"PRO"
                | b"SER"
                | b"THR"
                | b"TRP"
                | b"TYR"
                | b"VAL"
                | b"MSE"
                | b"SEC"
                | b"PYL"
                | b"ASX"
                | b"GLX"
                | b"UNK"
                | b"ASH"
                | b"GLH"
                | b"LYN"
                | b"CYX"
                | b"CYM"
                | b"HID"
                | b"HIE"
                | b"HIP"
                | b"HSD"
                | b"HSE"
                | b"HSP"
                | b"HYP"
                | b"SEP"
                | b"TPO"
                | b"PTR"
                | b"ACE"
                | b"NME"
                | b"NMA"
                | b"NH2"
                | b"ADE"
                | b"CYT"
                | b"GUA"
                | b"THY"
                | b"URA"
                | b"DA3"
                | b"DA5"
                | b"DC3"
                | b"DC5"
                | b"DG3"
                | b"DG5"
                | b"DT3"
                | b"DT5"
                | b"RA3"
                | b"RA5"
                | b"RC3"
                | b"RC5"
                | b"RG3"
                | b"RG5"
                | b"RU3"
                | b"RU5"
        ),
        _ => false,
    }
}

fn is_water(residue: &[u8]) -> bool {
    matches!(
        residue,
        b"HOH"
            | b"WAT"
            | b"DOD"
            | b"H2O"
            | b"SOL"
            | b"TIP"
            | b"TIP3"
            | b"TIP4"
            | b"TIP5"
            | b"TP3"
            | b"TP4"
            | b"TP5"
            | b"T3P"
            | b"T4P"
            | b"T4E"
            | b"SPC"
            | b"SPCE"
            | b"SWM4"
            | b"SWM6"
            | b"SWM"
            | b"OPC"
    )
}

/// Ions under their CHARMM names: residue and atom are called the same.
fn force_field_ion(name: &[u8]) -> Option<&'static [u8]> {
    Some(match name {
        b"SOD" => b"NA",
        b"CLA" => b"CL",
        b"POT" => b"K",
        b"CAL" => b"CA",
        b"CES" => b"CS",
        b"LIT" => b"LI",
        b"RUB" => b"RB",
        b"BAR" => b"BA",
        b"CAD" => b"CD",
        _ => return None,
    })
}

/// Two-letter symbols that are hardly ever anything else, wherever in the columns they stand. Left out are those that
/// remoteness letters or labels imitate (CA, CB, CD, CE, CO, CR, HE, HG, HO, NA, NB, ND, NE, OS, PA, PB, SB, SC, SG…).
fn is_unmistakable(symbol: &[u8]) -> bool {
    const SYMBOLS: [&[u8; 2]; 20] = [
        b"CL", b"BR", b"FE", b"ZN", b"MG", b"MN", b"MO", b"CU", b"NI", b"SI", b"SE", b"LI", b"AL", b"AU", b"PT", b"RU",
        b"IR", b"AS", b"TI", b"RE",
    ];
    SYMBOLS.iter().any(|other| symbol.eq_ignore_ascii_case(*other))
}

/// The element of an atom from its name (the four columns as they are) and its residue's. `aligned` says, when
/// asked, whether the file aligns its names.
pub(in crate::import) fn guess(name: &[u8], residue: &[u8], aligned: impl FnOnce() -> bool) -> Guess {
    let letters = letters(name);
    let Some(&first) = letters.first() else { return Guess::UNKNOWN };
    let trimmed = name.trim_ascii();
    if residue == b"UNX" {
        return Guess::UNKNOWN; // wwPDB's residue of one atom, named UNK, that nobody knows the element of
    }
    if letters.starts_with(b"LP") {
        return Guess::PARTICLE; // lone pairs of force fields: LP1, LPA
    }
    if let Some(ion) = force_field_ion(trimmed).filter(|_| residue == trimmed || residue == b"ION") {
        return Guess::of(ion).unwrap_or(Guess::UNKNOWN);
    }
    if residue == b"ION"
        && letters.len() <= 2
        && let Some(ion) = Guess::of(letters)
    {
        return ion; // NA, CL- in GROMOS topologies
    }
    let residue_letters = self::letters(residue);
    if residue_letters.eq_ignore_ascii_case(letters)
        && letters.len() <= 2
        && let Some(ion) = Guess::of(letters)
    {
        return ion; // CA in residue CA, FE in FE2, NA in `Na+`
    }
    if is_water(residue) {
        return match first.to_ascii_uppercase() {
            b'O' if !letters.starts_with(b"OM") => Guess::of(b"O"),
            b'H' => Guess::of(b"H"),
            b'D' if !letters.starts_with(b"DO") => Guess::of(b"D"),
            _ => None, // M, MW, EP, EPW, OM, DOH2
        }
        .unwrap_or(Guess::PARTICLE);
    }
    if is_polymer(residue) {
        if letters.starts_with(b"SE") && matches!(residue, b"MSE" | b"SEC") {
            return Guess::of(b"SE").unwrap_or(Guess::UNKNOWN);
        }
        match first.to_ascii_uppercase() {
            letter @ (b'H' | b'C' | b'N' | b'O' | b'S' | b'P' | b'D') => {
                return Guess::of(&[letter]).unwrap_or(Guess::UNKNOWN);
            }
            b'Q' | b'M' => return Guess::PARTICLE, // pseudo-atoms of NMR restraints
            _ => {}
        }
    }
    guess_by_columns(name, letters, first, aligned)
}

fn guess_by_columns(name: &[u8], letters: &[u8], first: u8, aligned: impl FnOnce() -> bool) -> Guess {
    let one = Guess::of(&[first]);
    let two = letters.get(..2).and_then(Guess::of);
    let exactly_two = letters.len() == 2;
    let begins_left = name.first().is_some_and(u8::is_ascii_alphabetic);
    let four = name.len() >= 4 && name[3] != b' ';
    let hydrogen = matches!(first, b'H' | b'h');
    let by_letters = || match () {
        () if exactly_two && is_unmistakable(letters) => two.or(one),
        () => one.or(two),
    };
    let guess = if !begins_left {
        // The symbol's one letter stands in the second column. ` FE ` and ` BR1` are iron and bromine all the same:
        // fluorine and boron do not come with such letters.
        if exactly_two && matches!(letters.to_ascii_uppercase().as_slice(), b"FE" | b"BR") { two } else { one.or(two) }
    } else if hydrogen && (four || !letters.eq_ignore_ascii_case(b"HG")) {
        one // HG11, HE2, HO5': four characters, or not aligned; helium, hafnium, holmium come as residues of their name
    } else if four || !exactly_two || two.is_none() {
        by_letters()
    } else if aligned() {
        two
    } else {
        by_letters()
    };
    guess.unwrap_or(Guess::UNKNOWN)
}

/// Whether the names of a file are aligned: `false` if any name of a one-letter element begins in the first column.
pub(super) fn is_aligned<'a>(atom_lines: impl Iterator<Item = &'a [u8]>) -> bool {
    for line in atom_lines {
        let name = columns(line, 12, 16);
        let residue = columns(line, 17, 20).trim_ascii();
        if name.len() < 4 || name[3] != b' ' || !name[0].is_ascii_alphabetic() {
            continue;
        }
        let letters = letters(name);
        let ion = letters.eq_ignore_ascii_case(self::letters(residue));
        let one_letter = Guess::of(&name[..1]).is_some() && (letters.len() == 1 || is_polymer(residue));
        if one_letter && !ion && letters != b"SE" {
            return false;
        }
    }
    true
}

/// Whether the element column contradicts a name that can mean only one thing: programs that copy the first two
/// letters of the name give the Cα of an amino acid as calcium.
pub(super) fn contradicts(symbol: &[u8], name: &[u8], residue: &[u8]) -> bool {
    symbol.len() == 2
        && name.trim_ascii().get(..2).is_some_and(|head| head.eq_ignore_ascii_case(symbol))
        && is_polymer(residue)
        && !symbol.eq_ignore_ascii_case(b"SE")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn symbol(name: &str, residue: &str, aligned: bool) -> String {
        let guess = guess(name.as_bytes(), residue.as_bytes(), || aligned);
        match (guess.element.symbol(), guess.isotope, guess.particle) {
            ("H", 2, false) => "D".to_owned(),
            ("X", _, true) => "particle".to_owned(),
            (symbol, _, _) => symbol.to_owned(),
        }
    }

    #[test]
    fn alignment_tells_carbon_from_calcium() {
        for (name, residue, want) in [
            (" CA ", "LIG", "C"),
            ("CA  ", "LIG", "Ca"),
            ("CA  ", "ALA", "C"),
            ("CA  ", " CA", "Ca"),
            (" CD1", "LIG", "C"),
            ("CL1 ", "LIG", "Cl"),
            ("CL12", "LIG", "Cl"),
            ("C10A", "LIG", "C"),
            ("HG11", "VAL", "H"),
            ("HG1 ", "THR", "H"),
            ("HG  ", "LIG", "Hg"),
            ("HG  ", "HG", "Hg"),
            ("1HB ", "ALA", "H"),
            ("HO5'", "DA", "H"),
            ("FE  ", "HEM", "Fe"),
            (" FE ", "HEM", "Fe"),
            (" NA ", "HEM", "N"),
            ("NA  ", "NA", "Na"),
            ("Na+ ", "Na+", "Na"),
            ("SE  ", "MSE", "Se"),
            (" SD ", "MET", "S"),
            (" D  ", "ALA", "D"),
            ("DD11", "LEU", "D"),
            (" K  ", "K", "K"),
            ("SOD ", "SOD", "Na"),
            (" CLA", "CLA", "Cl"),
            ("CLA ", "LIG", "C"),
            (" H1 ", "TIP3", "H"),
            (" OH2", "TIP3", "O"),
            (" MW ", "SOL", "particle"),
            (" EPW", "WAT", "particle"),
            (" LP1", "LIG", "particle"),
            (" A  ", "XXX", "X"),
            (" UNK", "UNX", "X"),
            ("    ", "LIG", "X"),
            ("1234", "LIG", "X"),
        ] {
            assert_eq!(symbol(name, residue.trim(), true), want, "{name:?} in {residue:?}");
        }
    }

    #[test]
    fn ordinary_names_are_no_exotic_metals() {
        for (name, want) in [
            ("CO  ", "C"),
            ("CB  ", "C"),
            ("NB  ", "N"),
            ("HO  ", "H"),
            ("OS  ", "O"),
            ("PB  ", "P"),
            ("CL1 ", "Cl"),
            ("ZN  ", "Zn"),
            ("C1  ", "C"),
            ("RHA ", "Rh"), // nothing else begins with R
        ] {
            assert_eq!(symbol(name, "LIG", false), want, "{name:?}");
        }
        for name in ["CO1A", "TB  ", "AG  "] {
            let residue = "ALA";
            assert!(!["Co"].contains(&symbol(name, residue, false).as_str()), "{name:?}");
        }
    }

    #[test]
    fn files_that_align_nothing_are_told() {
        let line = |name: &str, residue: &str| format!("ATOM      1 {name} {residue} A   1 ");
        let aligned = |lines: &[String]| is_aligned(lines.iter().map(|line| line.as_bytes()));
        assert!(aligned(&[line(" CA ", "ALA"), line("CL1 ", "LIG"), line("HG11", "VAL"), line("K   ", "  K")]));
        assert!(!aligned(&[line(" CA ", "LIG"), line("C1  ", "LIG")]));
        assert!(!aligned(&[line("CA  ", "ALA")]));
    }

    #[test]
    fn only_impossible_columns_are_contradicted() {
        assert!(contradicts(b"CA", b" CA ", b"GLY"));
        assert!(!contradicts(b"CA", b"CA  ", b"CA"));
        assert!(!contradicts(b"SE", b"SE  ", b"MSE"));
        assert!(!contradicts(b"C", b" CA ", b"GLY"));
    }
}
