//! SYBYL atom types from elements and bonds.
//!
//! The types are those of the Tripos Mol2 format description: hybridisation from the bond orders (`C.3`, `C.2`, `C.1`),
//! `.ar` in aromatic rings, amide nitrogen, planar nitrogen beside an unsaturated atom, carboxylate and phosphate oxygen,
//! the carbon of guanidinium, sulfoxide and sulfone. An atom whose bonds have no orders is taken as saturated.

use super::super::text::plain_bonds;
use crate::element::Element;
use crate::structure::{Bond, BondKind, BondOrder, Structure, atom_flags};

/// What an atom's bonds amount to.
#[derive(Debug, Clone, Default)]
struct Bonded {
    neighbors: Vec<u32>,
    doubles: u8,
    triples: u8,
    aromatic: u8,
    /// Neighbours at the other end of a double bond.
    double_to: Vec<u32>,
}

impl Bonded {
    fn is_unsaturated(&self) -> bool {
        self.doubles > 0 || self.triples > 0 || self.aromatic > 0
    }
}

/// The types of a structure's atoms.
pub(super) struct Types {
    names: Vec<String>,
    bonded: Vec<Bonded>,
}

impl Types {
    pub(super) fn of(structure: &Structure) -> Types {
        let mut bonded = vec![Bonded::default(); structure.atom_count()];
        for bond in plain_bonds(structure).filter(|bond| bond.kind == BondKind::Covalent) {
            for (from, to) in [(bond.a, bond.b), (bond.b, bond.a)] {
                let atom = &mut bonded[from as usize];
                atom.neighbors.push(to);
                match bond.order {
                    _ if bond.aromatic => atom.aromatic = atom.aromatic.saturating_add(1),
                    BondOrder::Double => {
                        atom.doubles = atom.doubles.saturating_add(1);
                        atom.double_to.push(to);
                    }
                    BondOrder::Triple => atom.triples = atom.triples.saturating_add(1),
                    _ => {}
                }
            }
        }
        let names = (0..structure.atom_count()).map(|atom| kind(structure, &bonded, atom)).collect();
        Types { names, bonded }
    }

    /// The type of each atom.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// Whether a bond is the one between carbonyl carbon and amide nitrogen.
    pub(super) fn is_amide(&self, structure: &Structure, bond: &Bond) -> bool {
        let pair = |nitrogen: u32, carbon: u32| {
            self.names[nitrogen as usize] == "N.am"
                && is_carbonyl(structure.elements(), &self.bonded[carbon as usize], carbon)
        };
        let single = bond.kind == BondKind::Covalent && bond.order == BondOrder::Single && !bond.aromatic;
        single && (pair(bond.a, bond.b) || pair(bond.b, bond.a))
    }
}

fn kind(structure: &Structure, bonded: &[Bonded], atom: usize) -> String {
    let elements = structure.elements();
    let element = elements[atom];
    let here = &bonded[atom];
    let of = |suffix: &str| format!("{}.{suffix}", element.symbol());
    let aromatic = here.aromatic >= 2;
    match element {
        Element::DUMMY => {
            let lone_pair = structure.atom_name(atom).to_ascii_uppercase().starts_with("LP");
            let particle = structure.flags(atom) & atom_flags::PARTICLE != 0;
            if lone_pair && particle { "LP".to_owned() } else { "Du".to_owned() }
        }
        Element::C if aromatic => of("ar"),
        Element::C if here.triples > 0 || here.doubles > 1 => of("1"),
        Element::C if is_guanidinium(elements, here, structure, atom) => of("cat"),
        Element::C if here.is_unsaturated() => of("2"),
        Element::N if aromatic => of(if here.neighbors.len() > 2 { "pl3" } else { "ar" }),
        Element::N if here.triples > 0 || here.doubles > 1 && here.neighbors.len() < 3 => of("1"),
        Element::N if here.neighbors.len() > 3 => of("4"),
        // Nitro groups: both oxygens, and the nitrogen, are planar.
        Element::N if here.doubles > 0 && here.neighbors.len() == 3 => of("pl3"),
        Element::N if here.doubles > 0 => of("2"),
        Element::N if here.neighbors.iter().any(|&near| is_carbonyl(elements, &bonded[near as usize], near)) => {
            of("am")
        }
        Element::N if here.neighbors.len() == 3 && unsaturated_neighbor(bonded, here) => of("pl3"),
        Element::O if is_carboxylate(elements, bonded, structure, atom) => of("co2"),
        Element::O if here.doubles > 0 || aromatic => of("2"),
        Element::S => {
            let oxygens = here.double_to.iter().filter(|&&near| elements[near as usize] == Element::O).count();
            match oxygens {
                0 if here.doubles > 0 || aromatic => of("2"),
                0 => of("3"),
                1 => "S.o".to_owned(),
                _ => "S.o2".to_owned(),
            }
        }
        Element::C | Element::N | Element::O | Element::P => of("3"),
        // The two metals whose plain symbol the format does not list.
        _ if element.z() == 24 => "Cr.oh".to_owned(),
        _ if element.z() == 27 => "Co.oh".to_owned(),
        _ => element.symbol().to_owned(),
    }
}

fn unsaturated_neighbor(bonded: &[Bonded], here: &Bonded) -> bool {
    here.neighbors.iter().any(|&near| bonded[near as usize].is_unsaturated())
}

fn is_carbonyl(elements: &[Element], carbon: &Bonded, index: u32) -> bool {
    elements[index as usize] == Element::C
        && carbon.double_to.iter().any(|&to| matches!(elements[to as usize], Element::O | Element::S))
}

/// Three nitrogens about a carbon, and a charge.
fn is_guanidinium(elements: &[Element], here: &Bonded, structure: &Structure, atom: usize) -> bool {
    let nitrogens = || here.neighbors.iter().filter(|&&near| elements[near as usize] == Element::N);
    here.doubles == 1
        && here.neighbors.len() == 3
        && nitrogens().count() == 3
        && (structure.formal_charge(atom) > 0 || nitrogens().any(|&near| structure.formal_charge(near as usize) > 0))
}

/// An oxygen of a carboxylate or phosphate: it ends there, and of its like at the same atom one has a double bond and
/// another a charge.
fn is_carboxylate(elements: &[Element], bonded: &[Bonded], structure: &Structure, atom: usize) -> bool {
    let &[centre] = bonded[atom].neighbors.as_slice() else { return false };
    if !matches!(elements[centre as usize], Element::C | Element::P) {
        return false;
    }
    let ends: Vec<u32> = bonded[centre as usize]
        .neighbors
        .iter()
        .copied()
        .filter(|&near| elements[near as usize] == Element::O && bonded[near as usize].neighbors.len() == 1)
        .collect();
    ends.iter().any(|&near| bonded[near as usize].doubles > 0)
        && ends.iter().any(|&near| structure.formal_charge(near as usize) < 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, BondSource, Diagnostics, StructureBuilder};

    /// Types of atoms (symbol, charge) with bonds (a, b, order; 5 is aromatic).
    fn types(atoms: &[(&str, i8)], bonds: &[(u32, u32, u32)]) -> String {
        let mut builder = StructureBuilder::new();
        for &(symbol, formal_charge) in atoms {
            let element = Element::from_symbol(symbol).unwrap_or_default();
            builder.push_atom(&AtomRecord { element, formal_charge, ..AtomRecord::default() });
        }
        for &(a, b, order) in bonds {
            let bond = Bond::new(a, b, BondOrder::from_number(order % 5), BondSource::File);
            builder.push_bond(Bond { aromatic: order == 5, ..bond });
        }
        Types::of(&builder.build(&mut Diagnostics::default())).names().join(" ")
    }

    #[test]
    fn types_follow_from_bonds() {
        let amide = types(&[("C", 0), ("C", 0), ("O", 0), ("N", 0)], &[(0, 1, 1), (1, 2, 2), (1, 3, 1)]);
        assert_eq!(amide, "C.3 C.2 O.2 N.am");
        let acetate = types(&[("C", 0), ("C", 0), ("O", 0), ("O", -1)], &[(0, 1, 1), (1, 2, 2), (1, 3, 1)]);
        assert_eq!(acetate, "C.3 C.2 O.co2 O.co2");
        let guanidinium = types(&[("C", 0), ("N", 1), ("N", 0), ("N", 0)], &[(0, 1, 2), (0, 2, 1), (0, 3, 1)]);
        assert!(guanidinium.starts_with("C.cat N.2"), "{guanidinium}");
        let sulfone = types(&[("C", 0), ("S", 0), ("O", 0), ("O", 0)], &[(0, 1, 1), (1, 2, 2), (1, 3, 2)]);
        assert_eq!(sulfone, "C.3 S.o2 O.2 O.2");
        assert_eq!(types(&[("C", 0), ("N", 0)], &[(0, 1, 3)]), "C.1 N.1");
        let ring: Vec<_> = (0..6).map(|n| (n, (n + 1) % 6, 5)).collect();
        let pyridine = types(&[("N", 0), ("C", 0), ("C", 0), ("C", 0), ("C", 0), ("C", 0)], &ring);
        assert_eq!(pyridine, "N.ar C.ar C.ar C.ar C.ar C.ar");
        assert_eq!(types(&[("Fe", 2), ("Cl", -1), ("H", 0), ("?", 0), ("Co", 0)], &[]), "Fe Cl H Du Co.oh");
    }
}
