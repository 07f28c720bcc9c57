//! Bonds: what the file states, completed by what residues are known to be and by what the geometry says.
//!
//! The sources in the order of their word, each giving only bonds that no earlier one has settled:
//!
//! 1. the file's own list. A complete one (SDF, MOL2, JSON) is exactly the bonds and nothing is added; of a partial one
//!    (CONECT, LINK, SSBOND, `_struct_conn`) every bond stays, however long. A bond there that has no order of its own (CONECT
//!    listed once, LINK) takes that of the next source, if this knows it;
//! 2. the residues ([`residues`]): the file's own `_chem_comp_bond`, then the wwPDB Chemical Component Dictionary
//!    ([`dictionary`]) by atom names, elements and plausible lengths, and the links of polymers ([`links`]);
//! 3. distance ([`distance`]): every pair that no source above has settled. Two atoms that a component knows have no other
//!    bonds inside their residue; one whose partners are all there has none outside but to metals, and a carbon that
//!    lacks only hydrogens none but close ones;
//! 4. hydrogen bonds ([`hbonds`]), if asked for, among the atoms with all these bonds.
//!
//! Bonds of metals to donors are [`BondKind::Coordination`] without an order, whoever names them; those to ligands that bring
//! one electron (alkyls, terminal halogens, oxides) are covalent (`ligands`).
//!
//! Orders and aromaticity of what no residue knows are a further step after these (`orders`): distances give single bonds
//! ([`BondOrder::Single`]) and coordination without an order ([`BondOrder::Unknown`]).
//!
//! [`BondMode::File`] takes 1 and the file's own part of 2, [`BondMode::Perceive`] 3 alone. [`explain`] says of each bond
//! where it comes from.
//!
//! Parts of a structure that nothing joins are worked on at the same time (`parts`), and all of it can be given up ([`assign_unless`]).
//!
//! The result is the same for every order of the atoms, up to ties, which the lower index wins, and for every
//! number of threads.
//!
//! Where a frame has a unit cell by which its atoms repeat, bonds go across its faces (`periodic`). Where a file lists an
//! asymmetric unit with its symmetry operations, bonds, orders and charges are found in the content of the whole cell, and
//! those among the listed atoms are given: silicon of quartz has four oxygens, listed or not.
//!
//! Limits: distances are taken in f32 about the structure's origin (an error of 0.001 Å at 10,000 Å from it);
//! atoms piled up beyond any physical density (`grid`) get no inferred bonds.

mod contacts;
mod dictionary;
mod distance;
mod explain;
mod grid;
mod hbonds;
mod hydrogen;
mod ligands;
mod links;
mod metal;
mod orders;
mod parts;
mod periodic;
mod residues;
mod rules;
mod sites;
mod valence;

#[cfg(test)]
mod tests;

pub use explain::{Explained, NotBonded, explain, length, not_bonded, order_in_words, source_in_words};
pub use orders::aromatic_rings;
pub(crate) use orders::{Ring, small_rings};
pub(crate) use residues::{atoms_of as residue_atoms, standard_name};
pub use sites::waters;

use crate::error::Result;
use crate::stop::Stop;
use crate::structure::{Bond, BondKind, BondOrder, BondSource, StatedBonds, Structure, apply_symmetry};
use glam::Vec3;
use residues::Known;

/// Where bonds come from; the names are those of `--bonds`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum BondMode {
    /// The file's bonds, completed by the component dictionary and by distance where the file does not give all.
    #[default]
    Auto,
    /// Only the bonds the file states, those inside residues by atom names (`_chem_comp_bond`) among them.
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
    /// Whether hydrogen bonds are found, too ([`crate::structure::BondKind::Hydrogen`]); in no mode but
    /// [`BondMode::None`] are they left out then. Default: `false`.
    pub hydrogen_bonds: bool,
}

impl Default for BondOptions {
    fn default() -> Self {
        BondOptions { mode: BondMode::Auto, tolerance: 0.45, metal_tolerance: 0.5, hydrogen_bonds: false }
    }
}

impl BondOptions {
    /// The same with tolerances that have a meaning: −1 to 1 Å, the default for what is not a number.
    fn sane(&self) -> BondOptions {
        let default = BondOptions::default();
        let sane = |value: f32, default: f32| if value.is_nan() { default } else { value.clamp(-1.0, 1.0) };
        BondOptions {
            mode: self.mode,
            hydrogen_bonds: self.hydrogen_bonds,
            tolerance: sane(self.tolerance, default.tolerance),
            metal_tolerance: sane(self.metal_tolerance, default.metal_tolerance),
        }
    }
}

/// The bonds of a structure, sorted by `(a, b)`, inferred ones from the positions of frame `frame`. For a frame that is
/// not there, only what the file states.
#[must_use]
pub fn find(structure: &Structure, frame: usize, options: &BondOptions) -> Vec<Bond> {
    find_all(structure, frame, options).0
}

/// The bonds, and what is known of the residues.
fn find_all(structure: &Structure, frame: usize, options: &BondOptions) -> (Vec<Bond>, Known) {
    match whole_cell(structure, frame, options) {
        Some(whole) => {
            let found = find_listed(&whole, 0, options, &Stop::never()).0;
            (among_first(found, structure.atom_count()), Known::default())
        }
        None => find_listed(structure, frame, options, &Stop::never()),
    }
}

/// Most atoms of a whole cell in which the surroundings of the listed ones are looked at. Chosen: the largest frameworks and
/// small-molecule crystals have some 20,000; proteins, whose molecules are whole as listed, are not expanded.
const MOST_IN_CELL: usize = 200_000;

/// The content of the cell of a file that lists an asymmetric unit, its symmetry and no bonds, the listed atoms first.
fn whole_cell(structure: &Structure, frame: usize, options: &BondOptions) -> Option<Structure> {
    let finds = matches!(options.mode, BondMode::Auto | BondMode::Perceive);
    let is_unit = structure.symmetry().is_some_and(|symmetry| symmetry.operations.len() > 1);
    if frame != 0 || !finds || !is_unit || !structure.residues().is_empty() || !structure.bonds().is_empty() {
        return None;
    }
    let (whole, original) = apply_symmetry(structure.clone(), MOST_IN_CELL).ok()?;
    // A cell that is a mere placeholder repeats nothing.
    (original.is_some() && whole.lattice(0).is_some()).then_some(whole)
}

/// The bonds among the first atoms as they stand.
fn among_first(bonds: Vec<Bond>, count: usize) -> Vec<Bond> {
    let is_listed = |bond: &Bond| (bond.b.max(bond.a) as usize) < count && !bond.is_periodic();
    bonds.into_iter().filter(is_listed).collect()
}

/// The same among the atoms as listed; if it is given up, only some.
fn find_listed(structure: &Structure, frame: usize, options: &BondOptions, stop: &Stop) -> (Vec<Bond>, Known) {
    let options = options.sane();
    let stated = match options.mode {
        BondMode::None => return (Vec::new(), Known::default()),
        BondMode::Perceive => Vec::new(),
        BondMode::Auto | BondMode::File => periodic::with_images(structure, frame, structure.bonds()),
    };
    let Some(positions) = structure.frames().get(frame).map(|frame| frame.positions.relative()) else {
        return (stated, Known::default());
    };
    let is_complete = structure.stated_bonds() == StatedBonds::Complete;
    let (mut bonds, known) = match options.mode {
        BondMode::Auto | BondMode::File if is_complete => (stated, Known::default()),
        BondMode::Perceive | BondMode::None => {
            let known = Known::default();
            (periodic::find(structure, frame, &[], &known, &options, stop), known)
        }
        BondMode::File => described(structure, positions, stated, false, stop),
        BondMode::Auto => {
            let (settled, known) = described(structure, positions, stated, true, stop);
            let inferred = periodic::find(structure, frame, &settled, &known, &options, stop);
            (merge(settled, inferred), known)
        }
    };
    if stop.is_set() {
        return (bonds, known);
    }
    let is_perceived = options.mode == BondMode::Perceive || options.mode == BondMode::Auto && !is_complete;
    if !is_complete || options.mode == BondMode::Perceive {
        ligands::settle(structure, positions, structure.lattice(frame), &mut bonds, is_perceived);
    }
    if is_perceived {
        orders::perceive(structure.elements(), positions, structure.lattice(frame), &mut bonds, stop);
    }
    orders::kekulise(structure, &mut bonds);
    if !options.hydrogen_bonds || stop.is_set() {
        return (bonds, known);
    }
    let more = periodic::hydrogen_bonds(structure, frame, &bonds);
    let mut bonds = merge(bonds, more);
    // What the file states as a hydrogen bond is not found again.
    bonds.dedup_by_key(|bond| bond.key());
    (bonds, known)
}

/// What the file states, completed by what the residues are known to be: from the file alone or from the dictionary, too.
fn described(
    structure: &Structure,
    positions: &[Vec3],
    stated: Vec<Bond>,
    with_dictionary: bool,
    stop: &Stop,
) -> (Vec<Bond>, Known) {
    let stated = stated.into_iter().map(|bond| with_kind(bond, structure)).collect();
    let mut known = residues::find(structure, positions, with_dictionary, stop);
    let links =
        if with_dictionary && !stop.is_set() { links::find(structure, positions, &mut known) } else { Vec::new() };
    let inside = std::mem::take(&mut known.bonds);
    (settle(stated, inside, links, &mut known), known)
}

/// The structure with the bonds of its first frame. Where it states no formal charges and its bonds are found, not
/// listed, it also gets the charges that follow from these.
#[must_use]
pub fn assign(structure: Structure, options: &BondOptions) -> Structure {
    assign_until(structure, options, &Stop::never())
}

/// The same unless it is given up.
///
/// # Errors
/// [`Error::Stopped`](crate::Error::Stopped).
pub fn assign_unless(structure: Structure, options: &BondOptions, stop: &Stop) -> Result<Structure> {
    let structure = assign_until(structure, options, stop);
    stop.check()?;
    Ok(structure)
}

/// The same; if it is given up, with some of the bonds.
pub(crate) fn assign_until(structure: Structure, options: &BondOptions, stop: &Stop) -> Structure {
    let count = structure.atom_count();
    let whole = whole_cell(&structure, 0, options);
    let surroundings = whole.as_ref().unwrap_or(&structure);
    let bonds = find_listed(surroundings, 0, options, stop).0;
    let is_listed = match options.mode {
        BondMode::Auto => structure.stated_bonds() == StatedBonds::Complete,
        BondMode::Perceive => false,
        BondMode::File | BondMode::None => true,
    };
    // Alternate locations would count as bonds too many.
    let charges = if is_listed || structure.has_formal_charges() || surroundings.has_altlocs() {
        Vec::new()
    } else {
        orders::charges(surroundings, &bonds, stop)
    };
    let bonds = if whole.is_some() { among_first(bonds, count) } else { bonds };
    let structure = structure.with_bonds(bonds);
    let mut of_atom = vec![0i8; if charges.is_empty() { 0 } else { count }];
    for (atom, charge) in charges {
        if let Some(slot) = of_atom.get_mut(atom as usize) {
            *slot = charge;
        }
    }
    if of_atom.is_empty() { structure } else { structure.with_formal_charges(of_atom) }
}

/// The structure with the hydrogen bonds of its first frame beside those it has.
#[must_use]
pub fn with_hydrogen_bonds(structure: Structure) -> Structure {
    let more = periodic::hydrogen_bonds(&structure, 0, structure.bonds());
    let bonds = structure.bonds().iter().copied().chain(more).collect();
    // What is stated as one is not there twice: the first of a pair stays.
    structure.with_bonds(bonds)
}

/// What the file states, completed by what is known of the residues.
fn settle(stated: Vec<Bond>, inside: Vec<Bond>, links: Vec<Bond>, known: &mut Known) -> Vec<Bond> {
    let mut bonds = merge(inside, links);
    if stated.is_empty() {
        return bonds;
    }
    let mut more = Vec::new();
    for bond in stated {
        match bonds.binary_search_by_key(&bond.key(), Bond::key) {
            Ok(at) => bonds[at] = united(bond, bonds[at]),
            Err(_) => {
                for atom in [bond.a as usize, bond.b as usize] {
                    if let Some(standing) = known.standing.get_mut(atom) {
                        *standing = standing.with_partner();
                    }
                }
                more.push(bond);
            }
        }
    }
    merge(bonds, more)
}

/// One bond that the file states and the dictionary describes. A CONECT record that is there once, and LINK, say that there
/// is a bond and nothing more; a row of `_struct_conn` also says of which kind.
fn united(stated: Bond, described: Bond) -> Bond {
    let untold = stated.order <= BondOrder::Single && !stated.aromatic;
    if !untold {
        return Bond { aromatic: described.aromatic, ..stated };
    }
    if stated.source == BondSource::Link && stated.kind != described.kind {
        return stated;
    }
    Bond { source: stated.source, ..described }
}

/// Both sorted lists as one. They have no pair in common.
fn merge(one: Vec<Bond>, other: Vec<Bond>) -> Vec<Bond> {
    if one.is_empty() {
        return other;
    }
    if other.is_empty() {
        return one;
    }
    let mut bonds = one;
    bonds.extend(other);
    bonds.sort_by_key(Bond::key); // finds the two sorted runs and merges them
    bonds
}

/// CONECT and LINK say that there is a bond but not of which kind: between a metal and a donor it is coordination, as
/// everywhere else; the order stays the file's. A row of `_struct_conn` that calls it covalent and gives its order is told,
/// one that gives none is not.
fn with_kind(bond: Bond, structure: &Structure) -> Bond {
    let element = |atom: u32| structure.elements().get(atom as usize).copied().unwrap_or_default();
    let is_link = bond.source == BondSource::Link;
    let longest_untold = if is_link { BondOrder::Unknown } else { BondOrder::Single };
    if bond.kind != BondKind::Covalent || bond.order > longest_untold || bond.aromatic {
        return bond;
    }
    if metal::is_coordination(element(bond.a), element(bond.b)) {
        // A link stays without an order, by which `ligands` sees that it is not told.
        return if is_link { bond } else { Bond { kind: BondKind::Coordination, ..bond } };
    }
    if is_link { Bond { order: BondOrder::Single, ..bond } } else { bond }
}
