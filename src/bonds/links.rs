//! The bonds that make residues a polymer: C–N of peptides, O3'–P of nucleic acids.
//!
//! They go from a residue to the next in its chain; where two residues share a place (two amino acids as alternate
//! locations), from each and to each. The file's order says what is next; where the numbers say otherwise (a gap, an
//! insertion code), the distance has to be that of any bond. All other bonds between residues (disulfides, rings
//! closed head to tail, sugars, isopeptides) are stated by the file or found by distance.
//!
//! A residue belongs to a polymer by its atoms: N, CA and C (caps have one end of these), or P and O3'.

use super::residues::{Known, atoms_of};
use super::rules;
use crate::element::Element;
use crate::structure::{Bond, BondOrder, BondSource, NameId, Structure};
use glam::Vec3;
use std::ops::Range;

/// Longest C–N in ångström: one and a half times 1.341 Å, as in gemmi (`polyheur.hpp`); 1.33 to 1.34 Å is usual. The next
/// nearest atoms of two residues in sequence, C and CA, are 2.4 Å apart.
const LONGEST_PEPTIDE: f32 = 2.01;
/// Longest O3'–P: one and a half times the usual 1.607 Å (Gelbin et al., J. Am. Chem. Soc. 1996, 118, 519; the Nucleic Acid
/// Database's table of the phosphodiester linkage).
const LONGEST_PHOSPHODIESTER: f32 = 2.41;

/// The two kinds of links.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Link {
    /// C–N.
    Peptide,
    /// O3'–P.
    Phosphodiester,
}

/// The names of the atoms at the ends of residues, as this structure has them.
struct Ends {
    c: Vec<NameId>,
    n: Vec<NameId>,
    o3: Vec<NameId>,
    p: Vec<NameId>,
}

impl Ends {
    fn new(structure: &Structure) -> Ends {
        let ids = |names: &[&str]| names.iter().filter_map(|name| structure.find_name(name)).collect();
        Ends { c: ids(&["C"]), n: ids(&["N"]), o3: ids(&["O3'", "O3*"]), p: ids(&["P"]) }
    }
}

/// The links between the residues, sorted, and their atoms one partner less short.
pub(super) fn find(structure: &Structure, positions: &[Vec3], known: &mut Known) -> Vec<Bond> {
    let ends = Ends::new(structure);
    let has_none = (ends.c.is_empty() || ends.n.is_empty()) && (ends.o3.is_empty() || ends.p.is_empty());
    if has_none || known.standing.is_empty() {
        return Vec::new();
    }
    let residues = structure.residues();
    let place = |index: usize| {
        let residue = &residues[index];
        (residue.chain, residue.number, residue.insertion_code)
    };
    let mut bonds = Vec::new();
    let mut here = 0..0;
    while here.end < residues.len() {
        // The residues at one place, and those at the next.
        let next = run(here.end, residues.len(), place);
        if !here.is_empty() && residues[here.start].chain == residues[next.start].chain {
            let is_gap = residues[next.start].number != residues[here.start].number + 1;
            for one in here {
                for other in next.clone() {
                    link(structure, positions, [one, other], is_gap, &ends, &mut bonds);
                }
            }
        }
        here = next;
    }
    bonds.sort_unstable_by_key(Bond::key);
    bonds.dedup_by_key(|bond| bond.key());
    for bond in &bonds {
        for atom in [bond.a as usize, bond.b as usize] {
            known.standing[atom] = known.standing[atom].with_partner();
        }
    }
    bonds
}

/// Residues at one place in a row: the most that are looked at as alternatives is 8, as a hostile file may have any number.
fn run<T: PartialEq>(first: usize, end: usize, place: impl Fn(usize) -> T) -> Range<usize> {
    let start = place(first);
    let length = (first..end).take(8).take_while(|&index| place(index) == start).count();
    first..first + length
}

fn link(
    structure: &Structure,
    positions: &[Vec3],
    [one, other]: [usize; 2],
    is_gap: bool,
    ends: &Ends,
    bonds: &mut Vec<Bond>,
) {
    let named = |residue: usize, names: &[NameId], element: Element| {
        let atoms = atoms_of(structure, residue);
        let found = atoms.filter(|&atom| {
            structure.atom_names().get(atom).is_some_and(|name| names.contains(name))
                && structure.elements()[atom] == element
        });
        // Alternate locations.
        found.take(16).collect::<Vec<usize>>()
    };
    for (from, to, elements, longest) in [
        (&ends.c, &ends.n, [Element::C, Element::N], LONGEST_PEPTIDE),
        (&ends.o3, &ends.p, [Element::O, Element::P], LONGEST_PHOSPHODIESTER),
    ] {
        if from.is_empty() || to.is_empty() {
            continue;
        }
        let by_distance = rules::radii(elements[0], elements[1]) + 0.45;
        let longest = if is_gap { longest.min(by_distance) } else { longest };
        let to = named(other, to, elements[1]);
        if to.is_empty() {
            continue;
        }
        for a in named(one, from, elements[0]) {
            for &b in &to {
                let (code, other_code) = (structure.altloc(a), structure.altloc(b));
                let are_alternatives = code != other_code && code != b' ' && other_code != b' ';
                let length = positions[a].distance(positions[b]);
                if !are_alternatives && length <= longest && !rules::is_too_near(length) {
                    bonds.push(Bond::new(a as u32, b as u32, BondOrder::Single, BondSource::Dictionary));
                }
            }
        }
    }
}

/// Which link a bond between two residues is.
pub(super) fn of(structure: &Structure, bond: &Bond) -> Link {
    let is_phosphorus =
        [bond.a, bond.b].iter().any(|&atom| structure.elements().get(atom as usize) == Some(&Element::P));
    if is_phosphorus { Link::Phosphodiester } else { Link::Peptide }
}
