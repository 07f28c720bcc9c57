//! Ligands that a metal holds by several neighbouring atoms (cyclopentadienyl, arenes, alkenes): on request one stick to
//! the middle of these atoms in place of one to each.

use crate::structure::{Bond, BondKind, ByAtom, Structure};
use glam::Vec3;

/// Bonds of one metal to atoms that are bonded to one another.
#[derive(Debug, PartialEq)]
pub(super) struct Group {
    /// The metal.
    pub(super) metal: u32,
    /// The atoms it holds, two or more, in the order of their indices.
    pub(super) atoms: Vec<u32>,
    /// The middle of these.
    pub(super) middle: Vec3,
    /// Indices of the bonds, the lowest first.
    pub(super) bonds: Vec<u32>,
}

/// The groups among the bonds for which `keep` holds. `neighbours` are those of all kept bonds.
pub(super) fn groups(
    structure: &Structure,
    positions: &[Vec3],
    neighbours: &ByAtom<u32>,
    keep: impl Fn(&Bond) -> bool,
) -> Vec<Group> {
    let is_metal = |atom: u32| structure.elements()[atom as usize].is_metal();
    let mut ends: Vec<(u32, u32, u32)> = (structure.bonds().iter().enumerate())
        .filter(|(_, bond)| bond.kind == BondKind::Coordination && keep(bond) && is_metal(bond.a) != is_metal(bond.b))
        .map(|(index, bond)| match is_metal(bond.a) {
            true => (bond.a, bond.b, index as u32),
            false => (bond.b, bond.a, index as u32),
        })
        .collect();
    ends.sort_unstable();
    let mut groups = Vec::new();
    for of_metal in ends.chunk_by(|one, other| one.0 == other.0) {
        let mut left: Vec<(u32, u32)> = of_metal.iter().map(|&(_, atom, bond)| (atom, bond)).collect();
        while let Some(first) = left.pop() {
            let mut group = vec![first];
            let mut at = 0;
            while let Some(&(atom, _)) = group.get(at) {
                at += 1;
                let beside = |&mut (other, _): &mut (u32, u32)| neighbours.of(atom as usize).contains(&other);
                group.extend(left.extract_if(.., beside));
            }
            if group.len() > 1 {
                group.sort_unstable();
                let sum: Vec3 = group.iter().map(|&(atom, _)| positions[atom as usize]).sum();
                let mut bonds: Vec<u32> = group.iter().map(|&(_, bond)| bond).collect();
                bonds.sort_unstable();
                groups.push(Group {
                    metal: of_metal[0].0,
                    middle: sum / group.len() as f32,
                    atoms: group.into_iter().map(|(atom, _)| atom).collect(),
                    bonds,
                });
            }
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, BondOrder, BondSource, Diagnostics, StructureBuilder};

    #[test]
    fn a_metal_over_an_alkene_and_beside_a_carbonyl_has_one_group() {
        let mut builder = StructureBuilder::new();
        let at = [("Fe", 0.0, 0.0), ("C", 2.0, -0.7), ("C", 2.0, 0.7), ("C", -1.8, 0.0), ("O", -2.95, 0.0)];
        for (symbol, x, y) in at {
            let element = Element::from_symbol(symbol).unwrap();
            builder.push_atom(&AtomRecord { element, position: glam::DVec3::new(x, y, 0.0), ..AtomRecord::default() });
        }
        for (a, b, kind) in [
            (0, 1, BondKind::Coordination),
            (0, 2, BondKind::Coordination),
            (0, 3, BondKind::Coordination),
            (1, 2, BondKind::Covalent),
            (3, 4, BondKind::Covalent),
        ] {
            builder.push_bond(Bond { kind, ..Bond::new(a, b, BondOrder::Single, BondSource::File) });
        }
        let structure = builder.build(&mut Diagnostics::default());
        let positions = structure.positions().relative();
        let neighbours = super::super::sticks::neighbours(5, structure.bonds(), |_| true);
        let got = groups(&structure, positions, &neighbours, |_| true);
        assert_eq!(got, [Group { metal: 0, atoms: vec![1, 2], middle: Vec3::new(2.0, 0.0, 0.0), bonds: vec![0, 1] }]);
    }
}
