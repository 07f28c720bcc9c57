//! What an atom's residue says about its bonds: waters stay waters, ions float, alternate locations keep apart.

use crate::element::Element;
use crate::structure::{BondKind, NameId, Residue, Structure, atom_flags};
use std::borrow::Cow;

/// Residue names of water in the PDB and in the common force fields and programs (CHARMM, AMBER, GROMACS, OPLS, Tinker).
/// A residue counts as water only if all its atoms are O, H or particles: `W` may be tungsten.
const WATER_NAMES: [&str; 27] = [
    "HOH", "DOD", "WAT", "H2O", "D2O", "SOL", "TIP", "TIP2", "TIP3", "TIP4", "TIP5", "TIP3P", "TIP4P", "TIP5P", "TP3",
    "TP4", "TP5", "T3P", "T4P", "SPC", "SPCE", "OPC", "HHO", "OHH", "OH2", "WTR", "W",
];

/// Whether water goes by this name.
pub(super) fn is_water_name(name: &str) -> bool {
    WATER_NAMES.contains(&name)
}

/// The part an atom plays by its residue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// None in particular.
    Plain,
    /// An atom of a water molecule.
    Water,
    /// A metal or halide that is a residue of its own.
    Ion,
}

/// The roles of all atoms, and who may meet whom.
pub(super) struct Sites<'a> {
    structure: &'a Structure,
    /// Empty where every atom is plain.
    roles: Cow<'a, [Role]>,
    has_altlocs: bool,
    /// The atom that is called 0 here.
    first: usize,
}

impl<'a> Sites<'a> {
    /// Reads the residues of a structure.
    pub(super) fn new(structure: &'a Structure) -> Sites<'a> {
        Sites { structure, roles: Cow::Owned(roles(structure)), has_altlocs: structure.has_altlocs(), first: 0 }
    }

    /// Those of the atoms from this one on, which is called 0 then.
    pub(super) fn from(&self, first: usize) -> Sites<'_> {
        Sites { roles: Cow::Borrowed(&self.roles), first: self.first + first, ..*self }
    }

    /// Alternate location of an atom.
    fn altloc(&self, atom: usize) -> u8 {
        self.structure.altloc(self.first + atom)
    }

    /// The part an atom plays.
    pub(super) fn role(&self, atom: usize) -> Role {
        self.roles.get(self.first + atom).copied().unwrap_or(Role::Plain)
    }

    /// Whether two atoms are alternatives: in different alternate locations, so that never both are there.
    pub(super) fn are_alternatives(&self, a: usize, b: usize) -> bool {
        if !self.has_altlocs {
            return false;
        }
        let (code_a, code_b) = (self.altloc(a), self.altloc(b));
        code_a != code_b && code_a != b' ' && code_b != b' '
    }

    /// How many of these atoms are there at once: those without an alternate location and those of the fullest one.
    pub(super) fn most_at_once(&self, atoms: impl Iterator<Item = usize> + Clone) -> usize {
        if !self.has_altlocs {
            return atoms.count();
        }
        let codes = atoms.map(|atom| self.altloc(atom));
        let of_code = |wanted: u8| codes.clone().filter(|&code| code == wanted).count();
        let fullest = codes.clone().filter(|&code| code != b' ').map(of_code).max();
        of_code(b' ') + fullest.unwrap_or(0)
    }

    /// Whether two atoms belong to one residue, or to copies of one: of a water that a periodic box has cut in two, one
    /// atom may be an image.
    fn is_same_residue(&self, a: usize, b: usize) -> bool {
        let [a, b] = [a, b].map(|atom| self.first + atom);
        let residue = |atom: usize| {
            let residue = self.structure.residues()[self.structure.residue_index(atom)?];
            Some((residue.name, residue.number, residue.insertion_code, residue.chain))
        };
        self.structure.residue_index(a) == self.structure.residue_index(b) || residue(a) == residue(b)
    }

    /// Whether two atoms may bond as far as residues and alternate locations go.
    pub(super) fn may_bond(&self, a: usize, b: usize) -> bool {
        if self.are_alternatives(a, b) {
            return false;
        }
        if self.roles.is_empty() {
            return true;
        }
        let element = |atom: usize| self.structure.elements()[self.first + atom];
        match (self.role(a), self.role(b)) {
            (Role::Plain, Role::Plain) => true,
            (Role::Water, Role::Water) => {
                // O–H of one molecule. Of hydrogens within reach of two oxygens the nearest wins later on.
                (element(a) == Element::H) != (element(b) == Element::H) && self.is_same_residue(a, b)
            }
            (Role::Water, _) | (_, Role::Water) => false,
            _ => element(a).is_metal() || element(b).is_metal(),
        }
    }
}

/// For every atom whether it is of a water molecule: by its residue, or, where the file has none, an oxygen with two hydrogens
/// and no other bonds.
#[must_use]
pub fn waters(structure: &Structure) -> Vec<bool> {
    if !structure.residues().is_empty() {
        let roles = roles(structure);
        return (0..structure.atom_count()).map(|atom| roles.get(atom) == Some(&Role::Water)).collect();
    }
    let elements = structure.elements();
    // Bonds and the hydrogens among their partners.
    let mut counts = vec![(0u32, 0u32); structure.atom_count()];
    for bond in structure.bonds().iter().filter(|bond| bond.kind != BondKind::Hydrogen) {
        for (atom, other) in [(bond.a, bond.b), (bond.b, bond.a)] {
            counts[atom as usize].0 += 1;
            counts[atom as usize].1 += u32::from(elements[other as usize] == Element::H);
        }
    }
    let mut waters: Vec<bool> =
        (elements.iter().zip(&counts)).map(|(&element, &counts)| element == Element::O && counts == (2, 2)).collect();
    for bond in structure.bonds().iter().filter(|bond| bond.kind != BondKind::Hydrogen) {
        for (atom, other) in [(bond.a as usize, bond.b as usize), (bond.b as usize, bond.a as usize)] {
            if elements[atom] == Element::O && waters[atom] && elements[other] == Element::H && counts[other].0 == 1 {
                waters[other] = true;
            }
        }
    }
    waters
}

/// The role of every atom; empty if all are plain.
fn roles(structure: &Structure) -> Vec<Role> {
    let waters: Vec<NameId> = WATER_NAMES.iter().filter_map(|name| structure.names.find(name)).collect();
    let residues = structure.residues();
    let mut roles = Vec::new();
    let mut ion_atoms = 0;
    for (index, residue) in residues.iter().enumerate() {
        let first = residue.first_atom as usize;
        let end = residues.get(index + 1).map_or(structure.atom_count(), |next| next.first_atom as usize);
        let role = residue_role(structure, residue, first, end, &waters);
        if role == Role::Plain || first >= end {
            continue;
        }
        roles.resize(structure.atom_count(), Role::Plain);
        roles[first..end].fill(role);
        ion_atoms += if role == Role::Ion { end - first } else { 0 };
    }
    // Where most atoms are residues of their own, the file is of a metal or a salt and numbers its atoms so:
    // there is nothing that they could float beside.
    if ion_atoms * 2 > structure.atom_count() {
        for role in &mut roles {
            if *role == Role::Ion {
                *role = Role::Plain;
            }
        }
    }
    roles
}

fn residue_role(structure: &Structure, residue: &Residue, first: usize, end: usize, waters: &[NameId]) -> Role {
    let elements = &structure.elements()[first..end];
    let is_particle = |offset: usize| {
        structure.flags(first + offset) & atom_flags::PARTICLE != 0 || elements[offset] == Element::DUMMY
    };
    if waters.contains(&residue.name) {
        let is_water_atom = |offset: usize| matches!(elements[offset], Element::O | Element::H) || is_particle(offset);
        if elements.contains(&Element::O) && (0..elements.len()).all(is_water_atom) {
            return Role::Water;
        }
    }
    // One ion, maybe in several alternate locations, maybe with its Drude particle.
    let mut atoms = (0..elements.len()).filter(|&offset| !is_particle(offset));
    let Some(ion) = atoms.next() else { return Role::Plain };
    let element = elements[ion];
    let one_place = |offset: usize| elements[offset] == element && structure.altloc(first + offset) != b' ';
    let monatomic = match atoms.next() {
        None => true,
        Some(second) => one_place(ion) && one_place(second) && atoms.all(one_place),
    };
    if monatomic && (element.is_metal() || element.is_halogen()) { Role::Ion } else { Role::Plain }
}
