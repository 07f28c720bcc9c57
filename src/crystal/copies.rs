//! What stands several times in a picture without being copied: assemblies, and the cells of a supercell that no bond leaves.

use crate::structure::{Assembly, Bond};
use glam::{BVec3, DAffine3, DVec3, IVec3};

/// The name of an assembly, short enough to be part of options that are copied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct AssemblyId {
    bytes: [u8; AssemblyId::MOST],
    length: u8,
}

impl AssemblyId {
    /// Bytes that a name may have: those of the PDB have one to three.
    pub const MOST: usize = 31;

    /// From a name; `None` for an empty one, and one that is too long.
    ///
    /// ```
    /// use ballstick::crystal::AssemblyId;
    /// assert_eq!(AssemblyId::new("PAU").unwrap().as_str(), "PAU");
    /// assert_eq!(AssemblyId::new(""), None);
    /// ```
    #[must_use]
    pub fn new(name: &str) -> Option<AssemblyId> {
        let name = name.trim();
        let length = u8::try_from(name.len()).ok().filter(|&length| length > 0)?;
        let mut bytes = [0; AssemblyId::MOST];
        bytes.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
        Some(AssemblyId { bytes, length })
    }

    /// The name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        // It was a text, and is whole.
        std::str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }
}

impl std::fmt::Display for AssemblyId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Where the copies of a structure's atoms stand. All atoms of a set have the same copies; a bond has those that both of its atoms have.
#[derive(Debug, Clone, PartialEq)]
pub struct Copies {
    /// Motions that keep distances, in the coordinates of the file, ångström. The number of a copy is its index here.
    pub operations: Vec<DAffine3>,
    /// Sets of operations: indices, ascending.
    pub sets: Vec<Vec<u32>>,
    /// For every atom its set, [`Copies::NOWHERE`] for atoms that are not drawn; empty if all are of the first.
    pub set_of: Vec<u32>,
}

impl Copies {
    /// The set of atoms that stand nowhere.
    pub const NOWHERE: u32 = u32::MAX;

    /// Those of an assembly.
    #[must_use]
    pub fn of_assembly(assembly: &Assembly, atom_count: usize) -> Copies {
        let (sets, mut set_of) = assembly.sets(atom_count);
        if set_of.iter().all(|&set| set == 0) {
            set_of = Vec::new();
        }
        Copies { operations: assembly.operations.clone(), sets, set_of }
    }

    /// All atoms in each of these cells.
    pub(super) fn of_cells(cells: impl Iterator<Item = IVec3>, [a, b, c]: [DVec3; 3]) -> Copies {
        let shift = |cell: IVec3| a * f64::from(cell.x) + b * f64::from(cell.y) + c * f64::from(cell.z);
        let operations: Vec<DAffine3> = cells.map(|cell| DAffine3::from_translation(shift(cell))).collect();
        let all = (0u32..).take(operations.len()).collect();
        Copies { operations, sets: vec![all], set_of: Vec::new() }
    }

    /// The set of an atom.
    #[must_use]
    pub fn set_of(&self, atom: u32) -> u32 {
        if self.set_of.is_empty() { 0 } else { self.set_of.get(atom as usize).copied().unwrap_or(Self::NOWHERE) }
    }

    /// The operations of atoms of one set, or of bonds between two.
    #[must_use]
    pub fn common(&self, a: u32, b: u32) -> Vec<u32> {
        let set = |number: u32| self.sets.get(number as usize).map_or(&[][..], Vec::as_slice);
        if a == b {
            return set(a).to_vec();
        }
        set(a).iter().copied().filter(|operation| set(b).binary_search(operation).is_ok()).collect()
    }

    /// A box around all copies of a box: never too small.
    #[must_use]
    pub fn extent(&self, [low, high]: [DVec3; 2]) -> [DVec3; 2] {
        let mut all = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for operation in &self.operations {
            for corner in 0..8u8 {
                let is_high = BVec3::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0);
                let there = operation.transform_point3(DVec3::select(is_high, high, low));
                all = [all[0].min(there), all[1].max(there)];
            }
        }
        all
    }

    /// How often each atom stands there, all atoms together.
    #[must_use]
    pub fn atom_count(&self, atom_count: usize) -> usize {
        let times = |set: u32| self.sets.get(set as usize).map_or(0, Vec::len);
        match self.set_of.is_empty() {
            true => atom_count.saturating_mul(times(0)),
            false => self.set_of.iter().fold(0usize, |sum, &set| sum.saturating_add(times(set))),
        }
    }

    /// How often each bond stands there, all bonds together.
    #[must_use]
    pub fn bond_count(&self, bonds: &[Bond]) -> usize {
        if self.set_of.is_empty() {
            return bonds.len().saturating_mul(self.sets.first().map_or(0, Vec::len));
        }
        let mut known = std::collections::HashMap::new();
        let times = bonds.iter().map(|bond| {
            let (a, b) = (self.set_of(bond.a), self.set_of(bond.b));
            *known.entry((a.min(b), a.max(b))).or_insert_with(|| self.common(a, b).len())
        });
        times.fold(0usize, usize::saturating_add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{BondOrder, BondSource};

    #[test]
    fn names_are_short_texts() {
        assert_eq!(AssemblyId::new(" 1 ").map(|id| id.to_string()).as_deref(), Some("1"));
        assert_eq!(AssemblyId::new(&"é".repeat(15)).map(|id| id.as_str().len()), Some(30));
        assert_eq!(AssemblyId::new(&"x".repeat(32)), None);
    }

    #[test]
    fn a_bond_between_sets_has_the_copies_of_both() {
        let shift = |x: f64| DAffine3::from_translation(DVec3::X * x);
        let mut assembly = Assembly::new("1", "");
        assembly.push(vec![0..2], &[shift(0.0), shift(10.0), shift(20.0)]);
        assembly.push(vec![2..3], &[shift(0.0), shift(20.0)]);
        let copies = Copies::of_assembly(&assembly, 4);
        assert_eq!((copies.atom_count(4), copies.set_of(3)), (8, Copies::NOWHERE));
        assert_eq!(copies.common(copies.set_of(0), copies.set_of(2)), [0, 2]);
        let bond = |a, b| Bond::new(a, b, BondOrder::Single, BondSource::File);
        assert_eq!(copies.bond_count(&[bond(0, 1), bond(1, 2), bond(2, 3)]), 5);
        let all = Copies::of_cells([IVec3::ZERO, IVec3::X].into_iter(), [DVec3::X, DVec3::Y, DVec3::Z]);
        assert_eq!((all.atom_count(3), all.bond_count(&[bond(0, 1)]), all.set_of(2)), (6, 2, 0));
    }
}
