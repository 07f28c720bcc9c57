//! Bonds: what the file states, completed by what the geometry says.
//!
//! The sources in the order of their word, each giving only bonds that no earlier one has settled:
//!
//! 1. the file's own list. A complete one (SDF, MOL2, JSON) is exactly the bonds and nothing is added; of a partial one
//!    (CONECT, LINK, SSBOND, `_struct_conn`) every bond stays as it is, however long;
//! 2. residue knowledge (component dictionary, polymer links) stands here in the order;
//! 3. distance (`distance`): every pair that no source above has settled.
//!
//! Orders and aromaticity are a further step after these (`orders`): distances give single bonds
//! ([`BondOrder::Single`]) and coordination without an order ([`BondOrder::Unknown`]).
//!
//! The result is the same for every order of the atoms, up to ties, which the lower index wins, and for every
//! number of threads.
//!
//! Limits: distances are taken in f32 about the structure's origin (an error of 0.001 Å at 10,000 Å from it);
//! periodic images are not looked at; atoms piled up beyond any physical density (`grid`) get no inferred bonds.

mod contacts;
mod distance;
mod grid;
mod hydrogen;
mod metal;
mod orders;
mod rules;
mod sites;
mod valence;

#[cfg(test)]
mod tests;

pub use orders::aromatic_rings;

use crate::structure::{Bond, BondKind, BondOrder, StatedBonds, Structure};

/// Where bonds come from; the names are those of `--bonds`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum BondMode {
    /// The file's bonds, completed by perception where the file does not give all.
    #[default]
    Auto,
    /// Only the bonds the file states.
    File,
    /// Only perception: neither the file's bonds nor residue knowledge.
    Perceive,
    /// No bonds at all.
    None,
}

impl BondMode {
    /// All modes.
    pub const ALL: [BondMode; 4] = [BondMode::Auto, BondMode::File, BondMode::Perceive, BondMode::None];

    /// `auto`, `file`, `perceive` or `none`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            BondMode::Auto => "auto",
            BondMode::File => "file",
            BondMode::Perceive => "perceive",
            BondMode::None => "none",
        }
    }

    /// The mode of a name; `None` for any other text.
    #[must_use]
    pub fn from_name(name: &str) -> Option<BondMode> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }
}

/// How bonds are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BondOptions {
    /// Where bonds come from. Default: [`BondMode::Auto`].
    pub mode: BondMode,
    /// Ångström added to the sum of the covalent radii of two nonmetals, −1 to 1. Default: 0.45, as in Open Babel
    /// (O'Boyle et al., J. Cheminform. 2011, 3, 33) and Jmol; N–N of N₂O₃ (1.86 Å, 0.44 Å over the sum) needs it.
    pub tolerance: f32,
    /// The same between a metal and a donor other than hydrogen. Default: 0.5: galena, PbS, has 2.97 Å (0.46 Å over
    /// the sum), the axial water of Cu(II) 2.4 Å (0.42 Å over), and Harding (Acta Cryst. D 2004, 60, 849) counts donors
    /// up to 0.75 Å beyond the usual distance.
    pub metal_tolerance: f32,
}

impl Default for BondOptions {
    fn default() -> Self {
        BondOptions { mode: BondMode::Auto, tolerance: 0.45, metal_tolerance: 0.5 }
    }
}

impl BondOptions {
    /// The same with tolerances that have a meaning: −1 to 1 Å, the default for what is not a number.
    fn sane(&self) -> BondOptions {
        let default = BondOptions::default();
        let sane = |value: f32, default: f32| if value.is_nan() { default } else { value.clamp(-1.0, 1.0) };
        BondOptions {
            mode: self.mode,
            tolerance: sane(self.tolerance, default.tolerance),
            metal_tolerance: sane(self.metal_tolerance, default.metal_tolerance),
        }
    }
}

/// The bonds of a structure, sorted by `(a, b)`, inferred ones from the positions of frame `frame`. For a frame that is
/// not there, only what the file states.
#[must_use]
pub fn find(structure: &Structure, frame: usize, options: &BondOptions) -> Vec<Bond> {
    let options = options.sane();
    let stated = match options.mode {
        BondMode::None => return Vec::new(),
        BondMode::File => return with_kekule_form(structure),
        BondMode::Perceive => &[],
        BondMode::Auto if structure.stated_bonds() == StatedBonds::Complete => return with_kekule_form(structure),
        BondMode::Auto => structure.bonds(),
    };
    let Some(frame) = structure.frames().get(frame) else { return merge(stated, Vec::new(), structure) };
    let inferred = distance::find(structure, frame.positions.relative(), stated, &options);
    let mut bonds = merge(stated, inferred, structure);
    orders::perceive(structure.elements(), frame.positions.relative(), frame.cell.as_ref(), &mut bonds);
    orders::kekulise(structure, &mut bonds);
    bonds
}

/// The file's bonds; aromatic ones without an order get one.
fn with_kekule_form(structure: &Structure) -> Vec<Bond> {
    let mut bonds = structure.bonds().to_vec();
    orders::kekulise(structure, &mut bonds);
    bonds
}

/// The structure with the bonds of its first frame. Where it states no formal charges and its bonds are found, not
/// listed, it also gets the charges that follow from these.
#[must_use]
pub fn assign(structure: Structure, options: &BondOptions) -> Structure {
    let bonds = find(&structure, 0, options);
    let is_listed = match options.mode {
        BondMode::Auto => structure.stated_bonds() == StatedBonds::Complete,
        BondMode::Perceive => false,
        BondMode::File | BondMode::None => true,
    };
    // Alternate locations would count as bonds too many.
    let charges = if is_listed || structure.has_formal_charges() || structure.has_altlocs() {
        Vec::new()
    } else {
        orders::charges(&structure, &bonds)
    };
    let structure = structure.with_bonds(bonds);
    if charges.is_empty() {
        return structure;
    }
    let mut of_atom = vec![0i8; structure.atom_count()];
    for (atom, charge) in charges {
        of_atom[atom as usize] = charge;
    }
    structure.with_formal_charges(of_atom)
}

/// Both sorted lists as one. They have no pair in common.
fn merge(stated: &[Bond], inferred: Vec<Bond>, structure: &Structure) -> Vec<Bond> {
    if stated.is_empty() {
        return inferred;
    }
    let mut bonds = Vec::with_capacity(stated.len() + inferred.len());
    bonds.extend(stated.iter().map(|&bond| with_kind(bond, structure)));
    bonds.extend(inferred);
    bonds.sort_by_key(Bond::key);
    bonds
}

/// CONECT and LINK say that there is a bond but not of which kind: between a metal and a donor it is coordination, as
/// everywhere else. The order stays the file's.
fn with_kind(bond: Bond, structure: &Structure) -> Bond {
    let element = |atom: u32| structure.elements().get(atom as usize).copied().unwrap_or_default();
    let untold = bond.kind == BondKind::Covalent && bond.order <= BondOrder::Single && !bond.aromatic;
    if untold && metal::is_coordination(element(bond.a), element(bond.b)) {
        return Bond { kind: BondKind::Coordination, ..bond };
    }
    bond
}
