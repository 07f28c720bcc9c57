//! What residues are called elsewhere: the names of force fields and programs, as components of the dictionary.
//!
//! The dictionary knows other molecules under some of these names (SOL is a sugar, HSD a cyclitol, CLA chlorophyll a): the
//! atoms decide, see [`super::layout`]. Names of ions are not here, as one atom has no bonds inside itself.
//!
//! Sources: the residue topologies of CHARMM36 (`top_all36_prot.rtf`, `top_all36_na.rtf`), AMBER (`amino12.lib`,
//! `aminont12.lib`, `aminoct12.lib`, `nucleic12.lib`), GROMOS 54A7 and OPLS-AA (`aminoacids.rtp` and `residuetypes.dat` of
//! GROMACS).

/// Protonation states and the like: one component each.
const ALIASES: [(&str, &[&str]); 9] = [
    (
        "HIS",
        &[
            "HSD", "HSE", "HSP", "HID", "HIE", "HIP", "HISD", "HISE", "HISP", "HISH", "HISA", "HISB", "HIS1", "HIS2",
            "HSH",
        ],
    ),
    ("CYS", &["CYX", "CYM", "CYS2", "CYS1", "CYSH", "CYSS", "CYN"]),
    ("ASP", &["ASH", "ASPP", "ASPH"]),
    ("GLU", &["GLH", "GLUP", "GLUH"]),
    ("LYS", &["LYN", "LSN", "LYSH", "LYP", "LYSN"]),
    ("ARG", &["ARN", "ARGN"]),
    ("TYR", &["TYM", "TYRU"]),
    ("NME", &["NMA", "NAC", "CT3"]),
    ("NH2", &["NHE"]),
];

/// Nucleotides that may be of DNA or RNA: the base, its letter, and the names that do not say of which.
const BASES: [(&str, &str, &[&str]); 5] = [
    ("A", "DA", &["ADE", "A5", "A3", "AN", "DADE"]),
    ("C", "DC", &["CYT", "C5", "C3", "CN", "DCYT"]),
    ("G", "DG", &["GUA", "G5", "G3", "GN", "DGUA"]),
    ("U", "DU", &["URA", "U5", "U3", "UN"]),
    ("T", "DT", &["THY", "T5", "T3", "DTHY"]),
];

/// Histidines whose only ring hydrogen is on ND1: the double bond is then CE1=NE2, not ND1=CE1 as in the dictionary's HIS.
const DELTA_HISTIDINES: [&str; 4] = ["HSD", "HID", "HISD", "HISA"];

/// The components that a residue name may mean beside the one of that id, the likeliest first.
pub(super) fn components(name: &str) -> Vec<&'static str> {
    let mut out = Vec::new();
    if super::super::sites::is_water_name(name) {
        out.push("HOH");
    }
    out.extend(ALIASES.iter().filter(|(_, names)| names.contains(&name)).map(|&(component, _)| component));
    for (ribo, deoxy, names) in BASES {
        if names.contains(&name) {
            out.extend([ribo, deoxy]);
        }
        // AMBER: DA, DA5, DA3, DAN of DNA, and with R of RNA.
        let letter = |prefix: &str| {
            let rest = name.strip_prefix(prefix)?;
            let end = rest.strip_prefix(&deoxy[1..])?;
            matches!(end, "" | "5" | "3" | "N").then_some(())
        };
        out.extend(letter("D").map(|()| deoxy));
        out.extend(letter("R").filter(|()| ribo != "T").map(|()| ribo));
    }
    if out.is_empty()
        && let Some(inner) = terminal(name)
    {
        out.extend(components(inner));
        out.extend(AMINO_ACIDS.iter().find(|&&acid| acid == inner));
    }
    out
}

/// Whether a residue of this name has the double bond of its ring at NE2.
pub(super) fn is_delta_histidine(name: &str) -> bool {
    DELTA_HISTIDINES.contains(&terminal(name).unwrap_or(name))
}

const AMINO_ACIDS: [&str; 21] = [
    "ALA", "ARG", "ASN", "ASP", "CYS", "GLN", "GLU", "GLY", "HIS", "ILE", "LEU", "LYS", "MET", "PHE", "PRO", "SER",
    "THR", "TRP", "TYR", "VAL", "HYP",
];

/// AMBER's names of terminal residues: N or C before the residue's (`NALA`, `CHIE`).
fn terminal(name: &str) -> Option<&str> {
    let inner = name.strip_prefix(['N', 'C'])?;
    (inner.len() == 3).then_some(inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_force_fields_mean_what_they_say() {
        for (name, first) in [
            ("HSD", "HIS"),
            ("CYX", "CYS"),
            ("ASH", "ASP"),
            ("GLH", "GLU"),
            ("LYN", "LYS"),
            ("NALA", "ALA"),
            ("CHIE", "HIS"),
            ("SOL", "HOH"),
            ("TIP3", "HOH"),
            ("WAT", "HOH"),
            ("DA5", "DA"),
            ("DT3", "DT"),
            ("DU", "DU"),
            ("RG", "G"),
            ("RU5", "U"),
            ("ADE", "A"),
            ("NMA", "NME"),
        ] {
            assert_eq!(components(name).first(), Some(&first), "{name}");
        }
        assert_eq!(components("GUA"), ["G", "DG"]);
        for name in ["ALA", "LIG", "CLA", "POT", "NAG", "NAN", "", "CALX"] {
            assert!(components(name).is_empty(), "{name}: {:?}", components(name));
        }
        assert!(is_delta_histidine("HSD") && is_delta_histidine("NHID") && !is_delta_histidine("HIE"));
    }
}
