//! Hydrogen bonds, by geometry.
//!
//! Donor and acceptor are N, O, S or F no farther apart than 3.5 Å. Where the donor has its hydrogens, D–H···A is at least
//! 120°, and the bond goes from the hydrogen; each hydrogen takes its nearest acceptor. Where the model has none, the
//! angles at both ends decide: from an atom that the donor is bonded to, over donor and acceptor, and from the donor over
//! the acceptor to an atom that this is bonded to, at least 90° each; the bond goes from the donor, which
//! has as many as it lacks hydrogens, the nearest first.
//!
//! Sources: Baker and Hubbard, Prog. Biophys. Mol. Biol. 1984, 44, 97 (3.5 Å, 120°); McDonald and Thornton, J. Mol. Biol.
//! 1994, 238, 777 (HBPLUS: the 90° at the antecedents; which atoms of proteins give and accept); Dunitz and Taylor, Chem.
//! Eur. J. 1997, 3, 89 (fluorine on carbon hardly ever accepts).
//!
//! Limits: a residue has all its hydrogens or none; carboxylates and phosphates without hydrogens count as ionised,
//! amines at the end of a chain as ammonium. Images across the faces of a cell are the caller's (`periodic`).

use super::contacts::OrderedF32;
use super::grid::Grid;
use super::rules::PairTable;
use super::sites::Sites;
use crate::element::Element;
use crate::structure::{Bond, BondKind, BondOrder, BondSource, ByAtom, Structure, atom_flags};
use glam::Vec3;

/// Longest distance between donor and acceptor in ångström.
pub(super) const LONGEST: f32 = 3.5;
/// The shortest: F–H–F⁻, the strongest of all, has 2.26 Å (Emsley, Chem. Soc. Rev. 1980, 9, 91). Nearer than that stand
/// atoms of one group.
const SHORTEST: f32 = 2.2;
/// Cosine of the narrowest D–H···A, 120°.
const HYDROGEN_COSINE: f32 = -0.5;
/// Longest D–H.
const LONGEST_TO_HYDROGEN: f32 = 1.5;

/// The covalent neighbours of the atoms.
struct Neighbours(ByAtom<(u32, BondOrder, bool)>);

impl Neighbours {
    fn new(atom_count: usize, bonds: &[Bond]) -> Neighbours {
        let covalent = || bonds.iter().filter(|bond| bond.kind != BondKind::Hydrogen && !bond.is_periodic());
        let ends = |bond: &Bond| {
            let order = if bond.kind == BondKind::Coordination { BondOrder::Unknown } else { bond.order };
            [(bond.a, (bond.b, order, bond.aromatic)), (bond.b, (bond.a, order, bond.aromatic))]
        };
        Neighbours(ByAtom::new(atom_count, || covalent().flat_map(ends)))
    }

    fn of(&self, atom: usize) -> &[(u32, BondOrder, bool)] {
        self.0.of(atom)
    }

    fn are_bonded(&self, a: usize, b: usize) -> bool {
        self.of(a).iter().any(|&(other, ..)| other as usize == b)
    }

    /// Whether two atoms are bonded, or to a third one both.
    fn are_near(&self, a: usize, b: usize) -> bool {
        self.are_bonded(a, b) || self.of(a).iter().any(|&(other, ..)| self.are_bonded(other as usize, b))
    }
}

/// What an atom can do.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    /// Has hydrogens in the model.
    gives: bool,
    /// Hydrogens that it has but for the model.
    lacks: u8,
    accepts: bool,
}

/// The hydrogen bonds among atoms with these bonds, sorted.
pub(super) fn find(structure: &Structure, positions: &[Vec3], bonds: &[Bond]) -> Vec<Bond> {
    let elements = structure.elements();
    if positions.len() != elements.len() {
        return Vec::new();
    }
    let neighbours = Neighbours::new(elements.len(), bonds);
    let parts = parts(structure, &neighbours);
    let table = PairTable::with_limits(elements, |a, b| (is_polar(a) && is_polar(b)).then_some(LONGEST));
    let takes_part = |atom: usize| parts[atom].gives || parts[atom].lacks > 0 || parts[atom].accepts;
    let grid = Grid::new(positions, elements, &table, takes_part);
    let sites = Sites::new(structure);
    let pairs = grid.pairs(|a, b, distance| {
        let (one, other) = (a as usize, b as usize);
        let may_be = distance >= SHORTEST && !sites.are_alternatives(one, other) && !neighbours.are_near(one, other);
        may_be.then_some((OrderedF32(distance), a, b))
    });
    let by_hydrogens = pairs.iter().flat_map(|&(_, a, b)| {
        [(a, b), (b, a)].into_iter().flat_map(|(donor, acceptor)| {
            let (parts, neighbours, sites) = (&parts, &neighbours, &sites);
            let donates = parts[donor as usize].gives && parts[acceptor as usize].accepts;
            let hydrogens = if donates { neighbours.of(donor as usize) } else { &[] };
            hydrogens.iter().filter_map(move |&(hydrogen, ..)| {
                let acceptor_at = positions[acceptor as usize];
                let at = positions[hydrogen as usize];
                let fits = elements[hydrogen as usize] == Element::H
                    && !sites.are_alternatives(hydrogen as usize, acceptor as usize)
                    && at.distance(positions[donor as usize]) <= LONGEST_TO_HYDROGEN
                    && cosine(positions[donor as usize], at, acceptor_at) <= HYDROGEN_COSINE;
                fits.then(|| (hydrogen, OrderedF32(at.distance(acceptor_at)), acceptor))
            })
        })
    });
    let mut by_hydrogens: Vec<(u32, OrderedF32, u32)> = by_hydrogens.collect();
    by_hydrogens.sort_unstable();
    by_hydrogens.dedup_by_key(|&mut (hydrogen, ..)| hydrogen);
    let mut found: Vec<Bond> = by_hydrogens.iter().map(|&(hydrogen, _, acceptor)| bond(hydrogen, acceptor)).collect();
    let mut pairs = pairs;
    pairs.retain(|&(_, a, b)| parts[a as usize].lacks > 0 || parts[b as usize].lacks > 0);
    pairs.sort_unstable();
    let mut left: Vec<u8> = parts.iter().map(|part| part.lacks).collect();
    for (_, a, b) in pairs {
        let direction = [(a, b), (b, a)].into_iter().find(|&(donor, acceptor)| {
            left[donor as usize] > 0
                && parts[acceptor as usize].accepts
                && opens(donor as usize, acceptor as usize, positions, &neighbours)
                && opens(acceptor as usize, donor as usize, positions, &neighbours)
        });
        if let Some((donor, acceptor)) = direction {
            left[donor as usize] -= 1;
            found.push(bond(donor, acceptor));
        }
    }
    found.sort_unstable_by_key(Bond::key);
    found.dedup_by_key(|bond| bond.key());
    found
}

fn bond(a: u32, b: u32) -> Bond {
    Bond { kind: BondKind::Hydrogen, ..Bond::new(a, b, BondOrder::Unknown, BondSource::Distance) }
}

fn is_polar(element: Element) -> bool {
    matches!(element, Element::N | Element::O | Element::S | Element::F)
}

/// Cosine of the angle at `apex`; 1 where two points coincide.
fn cosine(one: Vec3, apex: Vec3, other: Vec3) -> f32 {
    let (to_one, to_other) = (one - apex, other - apex);
    let cosine = to_one.dot(to_other) / (to_one.length() * to_other.length());
    if cosine.is_nan() { 1.0 } else { cosine }
}

/// Whether an atom's neighbours are all on the other side than its partner: at angles of 90° and more.
fn opens(atom: usize, partner: usize, positions: &[Vec3], neighbours: &Neighbours) -> bool {
    let mut heavy = neighbours.of(atom).iter().map(|&(other, ..)| other as usize);
    heavy.all(|other| cosine(positions[other], positions[atom], positions[partner]) <= 0.0)
}

/// The angle in degrees at a hydrogen between its donor and the acceptor, these as seen from the hydrogen.
pub(super) fn angle_deg(to_donor: Vec3, to_acceptor: Vec3) -> f32 {
    cosine(to_donor, Vec3::ZERO, to_acceptor).clamp(-1.0, 1.0).acos().to_degrees()
}

/// What every atom can do.
fn parts(structure: &Structure, neighbours: &Neighbours) -> Vec<Part> {
    let elements = structure.elements();
    // Of every residue, whether the model has its hydrogens; of a structure without residues, of all.
    let mut has_hydrogens = vec![false; structure.residues().len().max(1)];
    let residue = |atom: usize| structure.residue_index(atom).unwrap_or(0);
    for (atom, _) in elements.iter().enumerate().filter(|&(_, &element)| element == Element::H) {
        has_hydrogens[residue(atom)] = true;
    }
    let part = |atom: usize| {
        if !is_polar(elements[atom]) || structure.flags(atom) & atom_flags::PARTICLE != 0 {
            return Part::default();
        }
        let gives = neighbours.of(atom).iter().any(|&(other, ..)| elements[other as usize] == Element::H);
        let lacks = if has_hydrogens[residue(atom)] { 0 } else { lacking(structure, neighbours, atom) };
        Part { gives, lacks: if gives { 0 } else { lacks }, accepts: accepts(structure, neighbours, atom) }
    };
    (0..elements.len()).map(part).collect()
}

/// Partners, and the sum of the orders of the bonds to those that are no metals.
fn valence(structure: &Structure, neighbours: &Neighbours, atom: usize) -> (usize, u8) {
    let own = neighbours.of(atom).iter().filter(|&&(other, ..)| !structure.elements()[other as usize].is_metal());
    // With alternate locations of one partner that of the first counts.
    let mut names: Vec<&str> = Vec::new();
    let mut sum = 0;
    let mut count = 0;
    for &(other, order, aromatic) in own {
        let name = structure.atom_name(other as usize);
        if structure.altloc(other as usize) != b' ' && names.contains(&name) {
            continue;
        }
        names.push(name);
        count += 1;
        sum += if order == BondOrder::Unknown && aromatic { 1 } else { order.number().max(1) };
    }
    (count, sum)
}

/// How many hydrogens an atom has that are not in the model.
fn lacking(structure: &Structure, neighbours: &Neighbours, atom: usize) -> u8 {
    let (partners, sum) = valence(structure, neighbours, atom);
    let charge = structure.formal_charge(atom);
    match structure.elements()[atom] {
        // Ammonium at the end of a chain.
        Element::N if partners == 1 && sum == 1 && !is_conjugated(structure, neighbours, atom) => 3,
        Element::N => (3 + charge.clamp(-2, 1)).saturating_sub(sum as i8).max(0) as u8,
        Element::O if partners == 1 && is_acid(structure, neighbours, atom) => 0,
        Element::O | Element::S => (2 + charge.clamp(-2, 1)).saturating_sub(sum as i8).max(0) as u8,
        _ => 0,
    }
}

/// Whether a neighbour of the atom has a multiple bond.
fn is_conjugated(structure: &Structure, neighbours: &Neighbours, atom: usize) -> bool {
    let is_multiple = |&(_, order, aromatic): &(u32, BondOrder, bool)| aromatic || order >= BondOrder::Double;
    neighbours.of(atom).iter().any(|&(other, ..)| {
        structure.elements()[other as usize] != Element::H && neighbours.of(other as usize).iter().any(is_multiple)
    })
}

/// Whether an oxygen is of a carboxylate, phosphate, sulfate or the like: its one partner has a double bond to oxygen.
fn is_acid(structure: &Structure, neighbours: &Neighbours, atom: usize) -> bool {
    let is_oxo = |&(other, order, _): &(u32, BondOrder, bool)| {
        order == BondOrder::Double && structure.elements()[other as usize] == Element::O
    };
    neighbours.of(atom).iter().any(|&(other, ..)| neighbours.of(other as usize).iter().any(is_oxo))
}

fn accepts(structure: &Structure, neighbours: &Neighbours, atom: usize) -> bool {
    let own = neighbours.of(atom);
    let (partners, sum) = valence(structure, neighbours, atom);
    let has_hydrogen = own.iter().any(|&(other, ..)| structure.elements()[other as usize] == Element::H);
    match structure.elements()[atom] {
        Element::O | Element::S => partners <= 2 && structure.formal_charge(atom) <= 0,
        Element::F => !own.iter().any(|&(other, ..)| structure.elements()[other as usize] == Element::C),
        Element::N if structure.formal_charge(atom) > 0 => false,
        // Imines, pyridines, nitriles; amines that no double bond draws on. An amine with one partner is ammonium.
        Element::N if sum >= 3 && partners <= 2 => !(has_hydrogen && own.iter().any(|&(_, _, aromatic)| aromatic)),
        Element::N => (2..=3).contains(&partners) && sum <= 3 && !is_conjugated(structure, neighbours, atom),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BondOptions, find};
    use super::*;
    use crate::structure::{AtomRecord, Diagnostics, StructureBuilder};
    use glam::DVec3;

    /// Name, element, position, residue name, alternate location; each residue name change begins a residue.
    type Atom = (&'static str, &'static str, [f64; 3], &'static str, u8);

    fn hydrogen_bonds(atoms: &[Atom]) -> Vec<(u32, u32)> {
        let mut builder = StructureBuilder::new();
        let mut number = 0;
        for (index, &(name, symbol, position, residue, altloc)) in atoms.iter().enumerate() {
            if index == 0 || residue != atoms[index - 1].3 || name == "O" && residue == "HOH" {
                number += 10; // no neighbours in a chain
            }
            builder.push_atom(&AtomRecord {
                element: Element::from_symbol(symbol).unwrap(),
                position: DVec3::from(position),
                name,
                residue: Some(("A", number, b' ', residue)),
                altloc,
                ..AtomRecord::default()
            });
        }
        let structure = builder.build(&mut Diagnostics::default());
        let options = BondOptions { hydrogen_bonds: true, ..BondOptions::default() };
        let bonds = find(&structure, 0, &options);
        assert!(bonds.is_sorted_by_key(Bond::key));
        bonds.iter().filter(|bond| bond.kind == BondKind::Hydrogen).map(|bond| (bond.a, bond.b)).collect()
    }

    #[test]
    fn waters_with_hydrogens_bond_from_the_hydrogen() {
        let dimer = |h: [f64; 3]| {
            [
                ("O", "O", [0.0; 3], "HOH", b' '),
                ("H1", "H", h, "HOH", b' '),
                ("H2", "H", [-0.24, 0.93, 0.0], "HOH", b' '),
                ("O", "O", [2.9, 0.0, 0.0], "HOH", b' '),
                ("H1", "H", [3.3, 0.5, 0.7], "HOH", b' '),
                ("H2", "H", [3.3, 0.5, -0.7], "HOH", b' '),
            ]
        };
        assert_eq!(hydrogen_bonds(&dimer([0.96, 0.0, 0.0])), [(1, 3)]);
        // 114° at the hydrogen.
        assert!(hydrogen_bonds(&dimer([0.48, 0.0, 0.83])).is_empty());
    }

    #[test]
    fn without_hydrogens_the_angles_at_both_ends_decide() {
        let waters = [("O", "O", [0.0; 3], "HOH", b' '), ("O", "O", [2.8, 0.0, 0.0], "HOH", b' ')];
        assert_eq!(hydrogen_bonds(&waters), [(0, 1)]);
        let amide = |n: [f64; 3]| {
            [
                ("C", "C", [0.0; 3], "GLY", b' '),
                ("O", "O", [1.23, 0.0, 0.0], "GLY", b' '),
                ("N", "N", n, "ALA", b' '),
                ("CA", "C", [n[0] + 0.8, n[1] + 1.2, 0.0], "ALA", b' '),
            ]
        };
        assert_eq!(hydrogen_bonds(&amide([3.9, 1.0, 0.0])), [(1, 2)]);
        assert!(hydrogen_bonds(&amide([5.0, 0.0, 0.0])).is_empty()); // 3.77 Å
        assert!(hydrogen_bonds(&amide([0.4, 2.8, 0.0])).is_empty()); // behind the oxygen
    }

    #[test]
    fn what_has_nothing_to_give_or_to_take_has_none() {
        // Two carbonyls; two ends of one carboxylate; two alternatives.
        let carbonyls = [
            ("C", "C", [0.0; 3], "GLY", b' '),
            ("O", "O", [1.23, 0.0, 0.0], "GLY", b' '),
            ("C", "C", [5.2, 0.0, 0.0], "ALA", b' '),
            ("O", "O", [3.97, 0.0, 0.0], "ALA", b' '),
        ];
        assert!(hydrogen_bonds(&carbonyls).is_empty());
        let carboxylate = [
            ("CG", "C", [0.0; 3], "ASP", b' '),
            ("OD1", "O", [0.6, 1.1, 0.0], "ASP", b' '),
            ("OD2", "O", [0.6, -1.15, 0.0], "ASP", b' '),
        ];
        assert!(hydrogen_bonds(&carboxylate).is_empty());
        let alternatives = [("O", "O", [0.0; 3], "HOH", b'A'), ("O", "O", [2.8, 0.0, 0.0], "HOH", b'B')];
        assert!(hydrogen_bonds(&alternatives).is_empty());
    }
}
