//! Atom names of other times and programs, as the dictionary has them.
//!
//! Sources: the remediation of the Protein Data Bank (Henrick et al., Nucleic Acids Res. 2008, 36, D426) for names before
//! 2007 (`1HB`, `O1P`, `C5*`, `C5M`); the residue topologies named in [`super::alias`] for those of force fields.
//!
//! A hydrogen that is renamed wrongly among those of one atom does no harm, as these are all bonded alike; one that finds
//! no name is bonded by distance.

use crate::element::Element;

/// What an atom of this name may be called in the dictionary, the likeliest first; its own name is not among them.
pub(super) fn variants(name: &str, element: Element) -> Vec<String> {
    let mut out = Vec::new();
    let primed = name.replace('*', "'");
    if primed != name {
        out.push(primed.clone());
    }
    let fixed: &[&str] = match primed.as_str() {
        "O1P" => &["OP1"],
        "O2P" => &["OP2"],
        "O3P" | "O3T" => &["OP3"],
        "C5M" => &["C7"],
        "OT1" | "OC1" | "OT" => &["O"],
        "OT2" | "OC2" => &["OXT"],
        "O1" => &["O"],
        "O2" => &["OXT"],
        "CD" => &["CD1"],
        "CH3" | "CAT" => &["C"],
        "OW" | "OH2" => &["O"],
        "HW" | "HW1" => &["H1"],
        "HW2" => &["H2"],
        "HN" | "HT1" | "H1" | "HN1" | "HNT" => &["H"],
        "HT2" | "HN2" => &["H2", "HN2"],
        "HT3" => &["H3"],
        "H5T" => &["HO5'"],
        "H3T" => &["HO3'"],
        "HO'2" | "HO2" => &["HO2'"],
        "H5'1" => &["H5'"],
        "H5'2" => &["H5''"],
        "H2'1" => &["H2'"],
        "H2'2" => &["H2''", "HO2'"],
        "H5M1" | "H51" => &["H71"],
        "H5M2" | "H52" => &["H72"],
        "H5M3" | "H53" => &["H73"],
        "HG1" => &["HG"],
        _ => &[],
    };
    out.extend(fixed.iter().map(|&name| name.to_owned()));
    if element != Element::H {
        return out;
    }
    // Neutron structures: D in place of H. Names before 2007: the number first.
    let mut stem = primed;
    if let Some(rest) = stem.strip_prefix('D') {
        stem = format!("H{rest}");
        out.push(stem.clone());
    }
    let digits = stem.bytes().take_while(u8::is_ascii_digit).count();
    if digits > 0 {
        let (number, rest) = stem.split_at(digits);
        let rest = rest.replacen('D', "H", usize::from(rest.starts_with('D')));
        stem = match (rest.as_str(), number) {
            ("H5'", "2") => "H5''".to_owned(),
            ("H2'", "2") => "H2''".to_owned(),
            ("H5'" | "H2'", "1") => rest.clone(),
            ("H5M", _) => format!("H7{number}"),
            ("H" | "HT", "1") => "H".to_owned(),
            ("HT", _) => format!("H{number}"),
            ("HO'", "2") => "HO2'".to_owned(),
            _ => format!("{rest}{number}"),
        };
        out.push(stem.clone());
    }
    if stem == "HN" {
        out.push("H".to_owned());
    }
    // The two hydrogens of CH₂ are 2 and 3 in the dictionary, 1 and 2 elsewhere.
    if let Some(rest) = stem.strip_suffix('1') {
        out.push(format!("{rest}3"));
    }
    // CD of isoleucine: HD1, HD2, HD3 are HD11 and so on.
    if let Some(number) = stem.strip_prefix("HD").filter(|rest| rest.len() == 1) {
        out.push(format!("HD1{number}"));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_and_foreign_names_find_theirs() {
        for (name, element, expected) in [
            ("1HB", Element::H, "HB1"),
            ("1HB", Element::H, "HB3"),
            ("2HG1", Element::H, "HG12"),
            ("HB1", Element::H, "HB3"),
            ("HN", Element::H, "H"),
            ("1H", Element::H, "H"),
            ("D", Element::H, "H"),
            ("1DB", Element::H, "HB1"),
            ("2H5*", Element::H, "H5''"),
            ("H5'1", Element::H, "H5'"),
            ("O1P", Element::O, "OP1"),
            ("C5*", Element::C, "C5'"),
            ("C5M", Element::C, "C7"),
            ("CD", Element::C, "CD1"),
            ("OT2", Element::O, "OXT"),
            ("OW", Element::O, "O"),
            ("HW2", Element::H, "H2"),
            ("HD2", Element::H, "HD12"),
        ] {
            assert!(variants(name, element).iter().any(|variant| variant == expected), "{name} {expected}");
        }
        assert!(variants("CA", Element::C).is_empty());
        assert!(variants("", Element::H).is_empty());
    }
}
