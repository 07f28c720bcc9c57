//! Lattices that coordination alone holds together: rock salt, rutile, a metal oxide cluster. There the sticks from
//! metal to neighbour are all that shows the structure, and are drawn like bonds.

use crate::structure::{Bond, BondKind, Structure};

/// For every atom, whether it is one of such a lattice: two bonds or more, those to images counted, and all of them
/// coordination. Empty if there are none.
pub(super) fn atoms(structure: &Structure) -> Vec<bool> {
    let bonds = structure.bonds();
    if !bonds.iter().any(|bond| bond.kind == BondKind::Coordination) {
        return Vec::new();
    }
    let mut count = vec![0u32; structure.atom_count()];
    let mut has_other = vec![false; structure.atom_count()];
    let mut note = |atom: u32, bond: &Bond| match bond.kind {
        BondKind::Coordination => count[atom as usize] += 1,
        BondKind::Hydrogen => {}
        BondKind::Covalent | BondKind::Dative => has_other[atom as usize] = true,
    };
    for bond in bonds {
        note(bond.a, bond);
        note(bond.b, bond);
    }
    (count.into_iter().zip(has_other)).map(|(count, has_other)| count >= 2 && !has_other).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, BondOrder, BondSource, Diagnostics, StructureBuilder};

    #[test]
    fn only_what_is_all_coordination_is_a_lattice() {
        let lattice = |bonds: &[(u32, u32, BondKind)]| {
            let mut builder = StructureBuilder::new();
            for _ in 0..6 {
                builder.push_atom(&AtomRecord::default());
            }
            for &(a, b, kind) in bonds {
                builder.push_bond(Bond { kind, ..Bond::new(a, b, BondOrder::Unknown, BondSource::Distance) });
            }
            atoms(&builder.build(&mut Diagnostics::default()))
        };
        let (metal, bound) = (BondKind::Coordination, BondKind::Covalent);
        // 0 and 1 bridged by 2 and 3; 3 also has a covalent neighbour 4; 5 is a water on 0.
        let bonds = [(0, 2, metal), (1, 2, metal), (0, 3, metal), (1, 3, metal), (3, 4, bound), (0, 5, metal)];
        assert_eq!(lattice(&bonds), [true, true, true, false, false, false]);
        assert!(lattice(&bonds[4..5]).is_empty());
    }
}
