//! Bonds inside residues by the names of their atoms: from the file itself, or from the Chemical Component Dictionary.
//!
//! For every residue name there are templates ([`template`]): what the file says of it (`_chem_comp_bond`), what the name
//! means in a force field ([`alias`]), the component of that id. The residue's atoms are laid over that which fits best
//! ([`layout`]); residues of the same atoms in the same order share the result, so that a protein of 100,000 residues
//! compares some hundred with the dictionary. Then every residue looks at its own lengths:
//!
//! - a bond that is too long or too short to be one is left out; its hydrogens are given back to the distances;
//! - where more than one of three is doubtful, the residue is not what its name says, and all of it is, unless it has the
//!   backbone of an amino acid: then its side chain is only out of shape.
//!
//! Hydrogens that have other names are bonded by distance, as are atoms that the component does not have.

mod alias;
mod layout;
mod names;
mod template;

#[cfg(test)]
mod tests;

pub(super) use layout::Standing;

use super::rules;
use crate::element::Element;
use crate::stop::Stop;
use crate::structure::{Bond, BondSource, Structure};
use glam::Vec3;
use layout::{Atoms, Layout};
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;
use template::Template;

/// A residue with more than this part of its bonds doubtful is another molecule: 1/3. Our choice, so that a side chain with
/// a bad bond or two, as in PDB entry 4HHB, stays what it is called; of a molecule that shares only the name and the atom
/// names (C1, C2, …) with a component, most bonds are far too long.
const WRONG: (usize, usize) = (1, 3);
/// How much longer than the covalent radii a bond of a sound backbone may be, in ångström: the tolerance of distances.
const BACKBONE_EXCESS: f32 = 0.45;
/// Residues in one piece of work.
const RESIDUES_PER_TASK: usize = 4096;

/// What is known of the residues of a structure.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// The bonds, sorted.
    pub(super) bonds: Vec<Bond>,
    /// One an atom; empty if nothing is known of any.
    pub(super) standing: Vec<Standing>,
    templates: Vec<Template>,
    layouts: Vec<Layout>,
    /// The layout of each residue.
    of_residue: Vec<u32>,
}

impl Known {
    /// What is known of an atom.
    pub(super) fn standing(&self, atom: usize) -> Standing {
        self.standing.get(atom).copied().unwrap_or(Standing::UNKNOWN)
    }

    /// What is known of copies of these atoms.
    pub(super) fn of_copies(&self, atoms: impl Iterator<Item = u32>) -> Known {
        let standing = if self.standing.is_empty() {
            Vec::new()
        } else {
            atoms.map(|atom| self.standing(atom as usize)).collect()
        };
        Known { standing, ..Known::default() }
    }

    /// The component that a residue was taken for, and who describes it.
    pub(super) fn component(&self, residue: usize) -> Option<(&str, BondSource)> {
        let layout = self.layouts.get(*self.of_residue.get(residue)? as usize)?;
        let template = self.templates.get(layout.template? as usize)?;
        Some((&template.id, template.source))
    }
}

/// What a residue of a force field's name is in the dictionary, the likeliest; `None` where the name means itself.
pub(crate) fn standard_name(name: &str) -> Option<&'static str> {
    alias::components(name).first().copied()
}

/// The atoms of a residue.
pub(crate) fn atoms_of(structure: &Structure, residue: usize) -> Range<usize> {
    let residues = structure.residues();
    let first = residues.get(residue).map_or(0, |residue| residue.first_atom as usize);
    let end = residues.get(residue + 1).map_or(structure.atom_count(), |next| next.first_atom as usize);
    first..end.max(first)
}

/// The bonds inside the residues, at these positions. Without the dictionary only what the file itself says of them.
pub(super) fn find(structure: &Structure, positions: &[Vec3], with_dictionary: bool, stop: &Stop) -> Known {
    let nothing = structure.residues().is_empty()
        || structure.atom_names().is_empty()
        || positions.len() != structure.atom_count()
        || (!with_dictionary && structure.components().is_empty());
    if nothing {
        return Known::default();
    }
    let mut known = lay_out_all(structure, with_dictionary, stop);
    if known.layouts.iter().all(|layout| layout.template.is_none()) {
        return Known::default();
    }
    let tasks: Vec<Range<usize>> = (0..known.of_residue.len())
        .step_by(RESIDUES_PER_TASK)
        .map(|first| first..(first + RESIDUES_PER_TASK).min(known.of_residue.len()))
        .collect();
    let parts: Vec<(Vec<Bond>, Vec<Standing>)> =
        tasks.into_par_iter().map(|residues| apply(&known, structure, positions, residues)).collect();
    known.bonds.reserve_exact(parts.iter().map(|(bonds, _)| bonds.len()).sum());
    known.standing.reserve_exact(structure.atom_count());
    for (bonds, standing) in parts {
        known.bonds.extend(bonds);
        known.standing.extend(standing);
    }
    known
}

/// Finds the layout of every residue.
fn lay_out_all(structure: &Structure, with_dictionary: bool, stop: &Stop) -> Known {
    let mut known = Known { of_residue: Vec::with_capacity(structure.residues().len()), ..Known::default() };
    // Of each residue name its templates; of each name and fingerprint the layouts, by a residue that has them.
    let mut templates_of = HashMap::new();
    let mut layouts_of: HashMap<_, Vec<(u32, usize)>> = HashMap::new();
    for (index, residue) in structure.residues().iter().enumerate() {
        if index.is_multiple_of(RESIDUES_PER_TASK) && stop.is_set() {
            return Known::default();
        }
        let range = atoms_of(structure, index);
        let alike = layouts_of.entry((residue.name, fingerprint(structure, &range))).or_default();
        let same = alike.iter().find(|&&(_, other)| are_alike(structure, &range, &atoms_of(structure, other)));
        if let Some(&(layout, _)) = same {
            known.of_residue.push(layout);
            continue;
        }
        let templates: Range<usize> = templates_of
            .entry(residue.name)
            .or_insert_with(|| {
                let first = known.templates.len();
                let name = structure.name(residue.name);
                known.templates.extend(template::candidates(name, structure.components(), with_dictionary));
                first..known.templates.len()
            })
            .clone();
        let first = templates.start as u32; // at most three for each name
        let layout = layout::lay_out(&Atoms::new(structure, range), &known.templates[templates], first);
        let number = known.layouts.len() as u32; // at most one a residue
        known.layouts.push(layout);
        known.of_residue.push(number);
        alike.push((number, index));
    }
    known
}

/// A number that residues of the same atoms have in common.
fn fingerprint(structure: &Structure, range: &Range<usize>) -> u64 {
    // FNV-1a over whole names: they are few and short-lived, and equal numbers are compared in full.
    range.clone().fold(0xcbf2_9ce4_8422_2325, |sum: u64, atom| {
        let id = structure.atom_names().get(atom).map_or(0, |name| name.index() as u64);
        (sum ^ id ^ u64::from(structure.altloc(atom)) << 40).wrapping_mul(0x100_0000_01b3)
    })
}

fn are_alike(structure: &Structure, one: &Range<usize>, other: &Range<usize>) -> bool {
    let same =
        |a: usize, b: usize| structure.altloc(a) == structure.altloc(b) && structure.flags(a) == structure.flags(b);
    let (names, elements) = (structure.atom_names(), structure.elements());
    names.get(one.clone()) == names.get(other.clone())
        && elements.get(one.clone()) == elements.get(other.clone())
        && one.clone().zip(other.clone()).all(|(a, b)| same(a, b))
}

/// Whether N–CA, CA–C and C–O are among the bonds and as long as bonds are. Names like these are nobody's by chance, and a
/// side chain that was built without density (PDB entry 4HHB, lysine 65 of chain B: C–C 0.58 to 2.49 Å) is still what it is called.
fn has_backbone(structure: &Structure, positions: &[Vec3], bonds: &[Bond]) -> bool {
    [["N", "CA"], ["CA", "C"], ["C", "O"]].iter().all(|pair| {
        bonds.iter().any(|bond| {
            let [a, b] = [bond.a, bond.b].map(|atom| atom as usize);
            let longest = rules::radii(structure.elements()[a], structure.elements()[b]) + BACKBONE_EXCESS;
            let names = [structure.atom_name(a), structure.atom_name(b)];
            let is_pair = names == *pair || names == [pair[1], pair[0]];
            is_pair && positions[a].distance(positions[b]) <= longest
        })
    })
}

/// The bonds of some residues, and how their atoms stand.
fn apply(
    known: &Known,
    structure: &Structure,
    positions: &[Vec3],
    residues: Range<usize>,
) -> (Vec<Bond>, Vec<Standing>) {
    let atoms = atoms_of(structure, residues.start).start..atoms_of(structure, residues.end - 1).end;
    let mut standing = Vec::with_capacity(atoms.len());
    let mut bonds: Vec<Bond> = Vec::with_capacity(atoms.len());
    for residue in residues {
        let range = atoms_of(structure, residue);
        let layout = &known.layouts[known.of_residue[residue] as usize];
        let first = standing.len();
        standing.resize(first + range.len(), Standing::UNKNOWN);
        let Some(template) = layout.template else { continue };
        let source = known.templates[template as usize].source;
        let standing = &mut standing[first..];
        standing.copy_from_slice(&layout.standing);
        let first_bond = bonds.len();
        let (mut heavy, mut wrong) = (0, 0);
        for bond in &layout.bonds {
            let (a, b) = (range.start + bond.a as usize, range.start + bond.b as usize);
            let squared = positions[a].distance_squared(positions[b]);
            // Not a number is neither.
            let is_plausible = squared <= bond.longest_squared && !rules::is_too_near(squared.sqrt());
            heavy += usize::from(!bond.hydrogen);
            wrong += usize::from(!bond.hydrogen && (squared > bond.doubtful_squared || squared.is_nan()));
            if is_plausible {
                let new = Bond::new(a as u32, b as u32, bond.order, source);
                bonds.push(Bond { kind: bond.kind, aromatic: bond.aromatic, ..new });
            } else {
                // A hydrogen has the name of another: its nearest atom is to be found.
                for (atom, place) in [(a, bond.a as usize), (b, bond.b as usize)] {
                    let is_hydrogen = structure.elements()[atom] == Element::H;
                    standing[place] = if is_hydrogen { Standing::UNKNOWN } else { standing[place].without_partner() };
                }
            }
        }
        let is_doubtful = wrong > 1 && wrong * WRONG.1 > heavy * WRONG.0;
        if is_doubtful && !has_backbone(structure, positions, &bonds[first_bond..]) {
            bonds.truncate(first_bond);
            standing.fill(Standing::UNKNOWN);
        }
    }
    (bonds, standing)
}
