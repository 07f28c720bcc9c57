//! What residues are: protein, nucleic acid, water, ion, or anything else, which is a ligand.
//!
//! A residue is of a protein if it has the backbone of an amino acid (N, CA and C), or the name of one: models of Cα atoms alone
//! have names only. It is of a nucleic acid if it has the sugar of a nucleotide, or its name. One that the file lists as hetero atoms
//! is of a chain only if a bond leads to another such residue: selenomethionine in a protein is protein, a free amino acid or ATP is
//! a ligand. Without residues everything is a ligand but water and atoms that stand alone and are metals or halogens.
//!
//! Limits: where bonds are not found (`--bonds none`) hetero residues go by their names alone. Sugars and lipids are ligands.

use crate::bonds;
use crate::element::Element;
use crate::structure::{BondKind, NameId, Structure, atom_flags};

/// What a residue is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ResidueKind {
    /// An amino acid of a chain.
    Protein,
    /// A nucleotide of a chain.
    Nucleic,
    /// A water molecule.
    Water,
    /// An ion, single or of a few atoms.
    Ion,
    /// Anything else.
    Other,
}

/// One-letter codes of amino acids: the twenty-two that are coded, and usual modifications with the letter of what they
/// are made of (their parents in the wwPDB's Chemical Component Dictionary).
const AMINO: [(&str, char); 46] = [
    ("ALA", 'A'),
    ("ARG", 'R'),
    ("ASN", 'N'),
    ("ASP", 'D'),
    ("CYS", 'C'),
    ("GLN", 'Q'),
    ("GLU", 'E'),
    ("GLY", 'G'),
    ("HIS", 'H'),
    ("ILE", 'I'),
    ("LEU", 'L'),
    ("LYS", 'K'),
    ("MET", 'M'),
    ("PHE", 'F'),
    ("PRO", 'P'),
    ("SER", 'S'),
    ("THR", 'T'),
    ("TRP", 'W'),
    ("TYR", 'Y'),
    ("VAL", 'V'),
    ("SEC", 'U'),
    ("PYL", 'O'),
    ("MSE", 'M'),
    ("SEP", 'S'),
    ("TPO", 'T'),
    ("PTR", 'Y'),
    ("HYP", 'P'),
    ("CSO", 'C'),
    ("CME", 'C'),
    ("OCS", 'C'),
    ("CSD", 'C'),
    ("CSS", 'C'),
    ("KCX", 'K'),
    ("LLP", 'K'),
    ("MLY", 'K'),
    ("M3L", 'K'),
    ("ALY", 'K'),
    ("PCA", 'E'),
    ("CGU", 'E'),
    ("TYS", 'Y'),
    ("NEP", 'H'),
    ("HIC", 'H'),
    ("FME", 'M'),
    ("AIB", 'A'),
    ("ASX", 'B'),
    ("GLX", 'Z'),
];
/// Names of nucleotides with their letters.
const NUCLEIC: [(&str, char); 14] = [
    ("A", 'A'),
    ("C", 'C'),
    ("G", 'G'),
    ("U", 'U'),
    ("I", 'I'),
    ("DA", 'A'),
    ("DC", 'C'),
    ("DG", 'G'),
    ("DT", 'T'),
    ("DU", 'U'),
    ("DI", 'I'),
    ("PSU", 'U'),
    ("5MC", 'C'),
    ("T", 'T'),
];
/// Caps of peptides: parts of the chain without a letter of their own.
const CAPS: [&str; 3] = ["ACE", "NME", "NH2"];
/// Ions of several atoms that crystals are grown from and cells hold, by their ids in the Chemical Component Dictionary.
const IONS: [&str; 16] =
    ["SO4", "PO4", "PI", "HPO", "PO3", "2HP", "NO3", "NO2", "CO3", "BCT", "NH4", "OH", "CLO", "LCP", "ACT", "VO4"];

/// Atoms of a backbone without its hydrogens, at either end of a chain as well, in the names of the dictionary and of force fields.
const PROTEIN_BACKBONE: [&str; 9] = ["N", "CA", "C", "O", "OXT", "OT1", "OT2", "OC1", "OC2"];
const NUCLEIC_BACKBONE: [&str; 24] = [
    "P", "OP1", "OP2", "OP3", "O1P", "O2P", "O3P", "O5'", "C5'", "C4'", "O4'", "C3'", "O3'", "C2'", "O2'", "C1'",
    "O5*", "C5*", "C4*", "O4*", "C3*", "O3*", "C2*", "C1*",
];
/// Hydrogens of a backbone where no bond says what they are on.
const BACKBONE_HYDROGENS: [&str; 11] = ["H", "HN", "HA", "HA2", "HA3", "HA1", "H1", "H2", "H3", "1HA", "2HA"];

/// The letter of a residue of a chain, by its name; `None` for what is no residue of a chain or has none.
#[must_use]
pub fn one_letter(name: &str) -> Option<char> {
    let of = |name: &str| {
        let all = || AMINO.iter().chain(&NUCLEIC);
        all().find(|(own, _)| *own == name).map(|&(_, letter)| letter)
    };
    of(name).or_else(|| bonds::standard_name(name).and_then(of))
}

/// Whether residues may be called so: for a hint to what was meant.
pub(super) fn is_residue_name(text: &str) -> bool {
    let text = text.to_ascii_uppercase();
    text.len() == 3
        && (one_letter(&text).is_some() || ["HEM", "HOH", "ATP", "NAG", "GOL", "EDO"].contains(&text.as_str()))
}

/// Names as this structure has them, marked by their ids.
struct Marked(Vec<bool>);

impl Marked {
    fn new(structure: &Structure, is_one: impl Fn(&str) -> bool) -> Marked {
        Marked(structure.names.texts().map(|text| is_one(text.trim())).collect())
    }

    fn has(&self, name: NameId) -> bool {
        self.0.get(name.index()).is_some_and(|&is| is)
    }
}

/// The kinds of all residues.
#[must_use]
pub fn residue_kinds(structure: &Structure) -> Vec<ResidueKind> {
    let residues = structure.residues();
    if residues.is_empty() {
        return Vec::new();
    }
    let is_name_in = |table: &[(&str, char)], name: &str| {
        let is_in = |name: &str| table.iter().any(|(own, _)| *own == name);
        is_in(name) || bonds::standard_name(name).is_some_and(is_in)
    };
    let amino = Marked::new(structure, |name| is_name_in(&AMINO, name) || CAPS.contains(&name));
    let nucleotides = Marked::new(structure, |name| is_name_in(&NUCLEIC, name));
    let ions = Marked::new(structure, |name| IONS.contains(&name));
    let backbone = ["N", "CA", "C"].map(|name| structure.find_name(name));
    let sugar =
        [["C1'", "C1*"], ["C3'", "C3*"], ["C4'", "C4*"]].map(|names| names.map(|name| structure.find_name(name)));
    let waters = bonds::waters(structure);
    let mut kinds: Vec<ResidueKind> = Vec::with_capacity(residues.len());
    let mut is_hetero = vec![false; residues.len()];
    for (index, residue) in residues.iter().enumerate() {
        let atoms = bonds::residue_atoms(structure, index);
        let names = structure.atom_names().get(atoms.clone()).unwrap_or_default();
        let elements = &structure.elements()[atoms.clone()];
        // Of the element, too: CA is calcium elsewhere.
        let has = |name: Option<NameId>, element: Element| {
            name.is_some_and(|name| names.iter().zip(elements).any(|(&own, &is)| own == name && is == element))
        };
        let is_peptide =
            || backbone.into_iter().zip([Element::N, Element::C, Element::C]).all(|(name, element)| has(name, element));
        let is_sugar = || sugar.iter().all(|names| names.iter().any(|&name| has(name, Element::C)));
        is_hetero[index] = atoms.clone().any(|atom| structure.flags(atom) & atom_flags::HETERO != 0);
        kinds.push(match () {
            () if atoms.clone().any(|atom| waters[atom]) => ResidueKind::Water,
            () if is_ion(elements) || ions.has(residue.name) => ResidueKind::Ion,
            () if is_peptide() => ResidueKind::Protein,
            () if is_sugar() => ResidueKind::Nucleic,
            () if amino.has(residue.name) => ResidueKind::Protein,
            () if nucleotides.has(residue.name) => ResidueKind::Nucleic,
            () => ResidueKind::Other,
        });
    }
    free_ligands(structure, &is_hetero, &mut kinds);
    kinds
}

/// One atom, alternate locations and particles aside, that is a metal or a halogen.
fn is_ion(elements: &[Element]) -> bool {
    let mut real = elements.iter().filter(|&&element| element != Element::DUMMY);
    match real.next() {
        Some(first) => {
            (first.is_metal() || first.is_halogen()) && elements.len() <= 4 && real.all(|other| other == first)
        }
        None => false,
    }
}

/// Hetero residues without a bond to another residue of a chain are none.
fn free_ligands(structure: &Structure, is_hetero: &[bool], kinds: &mut [ResidueKind]) {
    let is_chain = |kind: ResidueKind| matches!(kind, ResidueKind::Protein | ResidueKind::Nucleic);
    let is_doubtful: Vec<bool> =
        kinds.iter().zip(is_hetero).map(|(&kind, &is_hetero)| is_hetero && is_chain(kind)).collect();
    if structure.bonds().is_empty() || !is_doubtful.contains(&true) {
        return;
    }
    let mut is_linked = vec![false; kinds.len()];
    for bond in structure.bonds().iter().filter(|bond| bond.kind == BondKind::Covalent) {
        let [a, b] = [bond.a, bond.b].map(|atom| structure.residue_index(atom as usize));
        if let (Some(a), Some(b)) = (a, b)
            && a != b
            && is_chain(kinds[a])
            && is_chain(kinds[b])
        {
            (is_linked[a], is_linked[b]) = (true, true);
        }
    }
    for ((kind, is_doubtful), is_linked) in kinds.iter_mut().zip(is_doubtful).zip(is_linked) {
        if is_doubtful && !is_linked {
            *kind = ResidueKind::Other;
        }
    }
}

/// For every atom whether it is of an ion: of a residue that is one, or, where the file has none, a metal or halogen that
/// stands alone.
#[must_use]
pub fn ions(structure: &Structure) -> Vec<bool> {
    if structure.residues().is_empty() {
        let mut alone: Vec<bool> =
            structure.elements().iter().map(|element| element.is_metal() || element.is_halogen()).collect();
        for atom in structure.bonds().iter().flat_map(|bond| [bond.a, bond.b]) {
            alone[atom as usize] = false;
        }
        return alone;
    }
    of_kind(structure, &residue_kinds(structure), |kind| kind == ResidueKind::Ion)
}

/// The atoms of residues of a kind.
pub(super) fn of_kind(structure: &Structure, kinds: &[ResidueKind], is_it: impl Fn(ResidueKind) -> bool) -> Vec<bool> {
    let is_it: Vec<bool> = kinds.iter().map(|&kind| is_it(kind)).collect();
    (0..structure.atom_count())
        .map(|atom| structure.residue_index(atom).is_some_and(|residue| is_it[residue]))
        .collect()
}

/// The atoms of backbones.
pub(super) fn backbone(structure: &Structure, kinds: &[ResidueKind]) -> Vec<bool> {
    let marks = |names: &[&str]| Marked::new(structure, |name| names.contains(&name));
    let heavy = [marks(&PROTEIN_BACKBONE), marks(&NUCLEIC_BACKBONE)];
    let light = marks(&BACKBONE_HYDROGENS);
    let elements = structure.elements();
    let names = structure.atom_names();
    let mut is_backbone: Vec<bool> = (0..structure.atom_count())
        .map(|atom| {
            let (Some(residue), Some(&name)) = (structure.residue_index(atom), names.get(atom)) else { return false };
            match (kinds[residue], elements[atom] == Element::H) {
                (ResidueKind::Protein, false) => heavy[0].has(name),
                (ResidueKind::Nucleic, false) => heavy[1].has(name),
                (ResidueKind::Protein, true) => light.has(name),
                _ => false,
            }
        })
        .collect();
    // Hydrogens go with what they are on.
    for bond in structure.bonds().iter().filter(|bond| bond.kind == BondKind::Covalent) {
        for (hydrogen, other) in [(bond.a as usize, bond.b as usize), (bond.b as usize, bond.a as usize)] {
            if elements[hydrogen] == Element::H && elements[other] != Element::H {
                is_backbone[hydrogen] = is_backbone[other];
            }
        }
    }
    is_backbone
}
