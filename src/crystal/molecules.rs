//! The molecules of a periodic structure: walks along the bonds, counting cells.

use super::holds;
use crate::structure::{Bond, ByAtom, Structure};
use glam::IVec3;

/// The bonds of every atom, with the cells they step over.
pub(super) struct Neighbours {
    steps: ByAtom<(u32, IVec3, u32)>,
    is_weak: Vec<bool>,
}

impl Neighbours {
    pub(super) fn new(structure: &Structure) -> Neighbours {
        let ends = |(number, bond): (u32, &Bond)| {
            let image = IVec3::from_array(bond.image.map(i32::from));
            [(bond.a, (bond.b, image, number)), (bond.b, (bond.a, -image, number))]
        };
        let steps = ByAtom::new(structure.atom_count(), || (0u32..).zip(structure.bonds()).flat_map(ends));
        // A hydrogen bond is drawn, but makes no molecule of two.
        let is_weak = structure.bonds().iter().map(|bond| !holds(bond)).collect();
        Neighbours { steps, is_weak }
    }

    /// Partner, cells on the way to it, number of the bond.
    pub(super) fn of(&self, atom: u32) -> impl Iterator<Item = (u32, IVec3, u32)> + '_ {
        self.steps.of(atom as usize).iter().copied()
    }
}

/// Atoms held together by bonds.
#[derive(Debug, PartialEq)]
pub(super) struct Molecule {
    /// Each atom once, and the cell in which it is bonded to the first, whose own is 0; the first has the lowest index.
    pub(super) atoms: Vec<(u32, IVec3)>,
    /// Whether it is bonded to its own image: a chain, layer or network without end.
    pub(super) is_endless: bool,
}

/// All molecules, by their first atoms.
pub(super) fn find(neighbours: &Neighbours, atom_count: usize) -> Vec<Molecule> {
    let mut cell_of: Vec<Option<IVec3>> = vec![None; atom_count];
    let mut molecules = Vec::new();
    for root in 0..atom_count {
        if cell_of[root].is_some() {
            continue;
        }
        cell_of[root] = Some(IVec3::ZERO);
        let mut molecule = Molecule { atoms: vec![(root as u32, IVec3::ZERO)], is_endless: false };
        let mut at = 0;
        while let Some(&(atom, cell)) = molecule.atoms.get(at) {
            at += 1;
            for (other, step, _) in neighbours.of(atom).filter(|&(.., bond)| !neighbours.is_weak[bond as usize]) {
                match cell_of[other as usize] {
                    Some(known) => molecule.is_endless |= known != cell + step,
                    None => {
                        cell_of[other as usize] = Some(cell + step);
                        molecule.atoms.push((other, cell + step));
                    }
                }
            }
        }
        molecule.atoms[1..].sort_unstable_by_key(|&(atom, _)| atom);
        molecules.push(molecule);
    }
    molecules
}
