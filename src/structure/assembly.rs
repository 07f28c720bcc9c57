//! Assemblies: what of the listed atoms stands together in nature, as the file states it, in compact form: which atoms are
//! repeated by which rigid motions. Nothing is copied until somebody asks for atoms ([`Structure::assembled`]).

use super::{Bond, NameId, Structure};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;
use std::ops::Range;

/// How far a product of a matrix and its transpose may be from unity for it to count as a rotation or reflection. Chosen: six written
/// decimals leave 1e-5, programs that write three leave 1e-3; a scaled or sheared cell is off by far more.
const RIGID: f64 = 5e-3;

/// One assembly of a file (`_pdbx_struct_assembly`, BIOMOLECULE).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Assembly {
    /// What the file calls it (`1`, `PAU`).
    pub id: String,
    /// What the file says of it (`complete icosahedral assembly`), or nothing.
    pub description: String,
    /// All motions, each once: ångström in the coordinates of the file.
    pub operations: Vec<DAffine3>,
    /// Which atoms they apply to.
    pub parts: Vec<AssemblyPart>,
}

/// Atoms with the same operations.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AssemblyPart {
    /// Runs of atoms, ascending.
    pub atoms: Vec<Range<u32>>,
    /// Indices into [`Assembly::operations`].
    pub operations: Vec<u32>,
}

impl Assembly {
    /// An assembly without parts.
    #[must_use]
    pub fn new(id: &str, description: &str) -> Assembly {
        Assembly { id: id.to_owned(), description: description.to_owned(), ..Assembly::default() }
    }

    /// Adds runs of atoms, of which neighbours become one, and what is applied to them; no atoms, or no operations, are no part.
    pub fn push(&mut self, atoms: Vec<Range<u32>>, operations: &[DAffine3]) {
        if atoms.is_empty() || operations.is_empty() {
            return;
        }
        let key = |operation: &DAffine3| operation.to_cols_array().map(f64::to_bits);
        let mut known: HashMap<[u64; 12], u32> = self.operations.iter().map(key).zip(0..).collect();
        let mut runs: Vec<Range<u32>> = Vec::with_capacity(atoms.len());
        for run in atoms {
            match runs.last_mut() {
                Some(last) if last.end == run.start => last.end = run.end,
                _ => runs.push(run),
            }
        }
        let mut part = AssemblyPart { atoms: runs, operations: Vec::with_capacity(operations.len()) };
        for operation in operations {
            let next = u32::try_from(self.operations.len()).unwrap_or(u32::MAX);
            let index = *known.entry(key(operation)).or_insert(next);
            if index == next {
                self.operations.push(*operation);
            }
            part.operations.push(index);
        }
        part.operations.sort_unstable();
        part.operations.dedup();
        self.parts.push(part);
    }

    /// Whether it is nothing but the atoms as they are listed, each once.
    #[must_use]
    pub fn is_as_listed(&self, atom_count: usize) -> bool {
        let ranges = self.parts.iter().flat_map(|part| &part.atoms);
        let atoms = ranges.fold(0usize, |sum, range| sum.saturating_add(range.len()));
        self.operations == [DAffine3::IDENTITY] && atoms >= atom_count
    }

    /// Which atoms have which operations: the sets of operations that occur (indices, ascending), and for every atom the number of its
    /// set, from 0; `u32::MAX` for atoms that are not in the assembly.
    #[must_use]
    pub fn sets(&self, atom_count: usize) -> (Vec<Vec<u32>>, Vec<u32>) {
        // Atoms of several parts have the operations of all of them: sets of parts first, which are few.
        let mut parts_of: Vec<u32> = vec![u32::MAX; atom_count];
        let mut combinations: Vec<Vec<u32>> = Vec::new();
        let mut joined: HashMap<(u32, u32), u32> = HashMap::new();
        for (number, part) in (0u32..).zip(&self.parts) {
            for range in &part.atoms {
                let end = (range.end as usize).min(atom_count);
                let atoms = parts_of.get_mut((range.start as usize).min(end)..end).unwrap_or_default();
                for of in atoms {
                    let old = *of;
                    *of = *joined.entry((old, number)).or_insert_with(|| {
                        let mut all = combinations.get(old as usize).cloned().unwrap_or_default();
                        if all.last() != Some(&number) {
                            all.push(number);
                        }
                        combinations.push(all);
                        combinations.len() as u32 - 1
                    });
                }
            }
        }
        let mut sets: Vec<Vec<u32>> = Vec::new();
        let mut number_of: HashMap<Vec<u32>, u32> = HashMap::new();
        let set_of: Vec<u32> = (combinations.iter())
            .map(|parts| {
                let mut all: Vec<u32> =
                    parts.iter().flat_map(|&part| self.parts[part as usize].operations.iter().copied()).collect();
                all.sort_unstable();
                all.dedup();
                *number_of.entry(all).or_insert_with_key(|all| {
                    sets.push(all.clone());
                    sets.len() as u32 - 1
                })
            })
            .collect();
        parts_of.iter_mut().filter(|of| **of != u32::MAX).for_each(|of| *of = set_of[*of as usize]);
        (sets, parts_of)
    }

    /// Atoms in all copies together.
    #[must_use]
    pub fn atom_count(&self, listed: usize) -> usize {
        let (sets, set_of) = self.sets(listed);
        set_of.iter().fold(0usize, |sum, &set| sum.saturating_add(sets.get(set as usize).map_or(0, Vec::len)))
    }

    /// The same of a structure of some of these atoms; `place` is the new number of each atom, `u32::MAX` for those that go.
    pub(super) fn subset(&self, place: &[u32]) -> Assembly {
        let run = |range: &Range<u32>| {
            let end = (range.end as usize).min(place.len());
            let kept = place.get((range.start as usize).min(end)..end)?.iter().filter(|&&new| new != u32::MAX);
            // Places grow as the atoms do.
            let (first, last) = kept.fold((u32::MAX, 0), |(first, last), &new| (first.min(new), last.max(new)));
            (first != u32::MAX).then(|| first..last + 1)
        };
        let part = |part: &AssemblyPart| {
            let atoms: Vec<Range<u32>> = part.atoms.iter().filter_map(run).collect();
            (!atoms.is_empty()).then(|| AssemblyPart { atoms, operations: part.operations.clone() })
        };
        let parts = self.parts.iter().filter_map(part).collect();
        Assembly {
            id: self.id.clone(),
            description: self.description.clone(),
            operations: self.operations.clone(),
            parts,
        }
    }
}

/// Whether a matrix and a vector are a motion that keeps all distances (a rotation, perhaps with a reflection) and goes nowhere absurd.
#[must_use]
pub fn is_rigid(operation: &DAffine3) -> bool {
    let matrix = operation.matrix3;
    let unity = matrix.transpose() * matrix;
    operation.is_finite()
        && unity.abs_diff_eq(DMat3::IDENTITY, RIGID)
        && operation.translation.abs().max_element() < 1e6
}

impl Structure {
    /// The assemblies that the file states, in its order.
    #[must_use]
    pub fn assemblies(&self) -> &[Assembly] {
        &self.assemblies
    }

    /// The assembly of an id.
    #[must_use]
    pub fn assembly(&self, id: &str) -> Option<&Assembly> {
        self.assemblies.iter().find(|assembly| assembly.id == id)
    }

    /// All atoms of an assembly, copied, with the bonds inside of the copies: copy by copy. Chains of the copies but the first are called
    /// after it and the number of the copy (`A-2`). The first frame alone, without symmetry and assemblies.
    #[must_use]
    pub fn assembled(&self, assembly: &Assembly) -> Structure {
        let (sets, set_of) = assembly.sets(self.atom_count());
        let has = |atom: usize, operation: u32| {
            sets.get(set_of[atom] as usize).is_some_and(|set| set.binary_search(&operation).is_ok())
        };
        let mut sources: Vec<(u32, DVec3)> = Vec::new();
        let mut bonds: Vec<Bond> = Vec::new();
        let mut copy_begins = Vec::with_capacity(assembly.operations.len());
        let mut place = vec![u32::MAX; self.atom_count()];
        for (number, operation) in (0u32..).zip(&assembly.operations) {
            copy_begins.push(sources.len());
            for (atom, place) in place.iter_mut().enumerate() {
                *place = u32::MAX;
                if has(atom, number) {
                    *place = sources.len() as u32;
                    sources.push((atom as u32, operation.transform_point3(self.positions().get(atom))));
                }
            }
            bonds.extend(self.bonds().iter().filter(|bond| !bond.is_periodic()).filter_map(|bond| {
                let (a, b) = (place[bond.a as usize], place[bond.b as usize]);
                (a != u32::MAX && b != u32::MAX).then_some(Bond { a, b, ..*bond })
            }));
        }
        let mut whole = self.gather(&sources, None).with_bonds(bonds);
        whole.stated_bonds = self.stated_bonds;
        whole.name_copies(&copy_begins);
        whole
    }

    /// Gives the chains of all copies but the first names of their own.
    fn name_copies(&mut self, copy_begins: &[usize]) {
        let mut chain_of: HashMap<(u32, u32), u32> = HashMap::new();
        for residue in &mut self.residues {
            let copy = copy_begins.partition_point(|&begin| begin <= residue.first_atom as usize);
            let key = (residue.chain, copy as u32);
            if copy <= 1 {
                continue;
            }
            let chains = &mut self.chains;
            let names = &mut self.names;
            residue.chain = *chain_of.entry(key).or_insert_with(|| {
                let old: NameId = chains.get(key.0 as usize).copied().unwrap_or_default();
                let name = format!("{}-{copy}", names.get(old));
                chains.push(names.intern(&name));
                chains.len() as u32 - 1
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, BondOrder, BondSource, Diagnostics, StructureBuilder};

    fn shift(x: f64) -> DAffine3 {
        DAffine3::from_translation(DVec3::X * x)
    }

    /// Two atoms of chain A, one of B, one of C; A–A and A–B are bonded.
    fn structure() -> Structure {
        let mut builder = StructureBuilder::new();
        for (chain, x) in [("A", 0.0), ("A", 1.0), ("B", 2.0), ("C", 3.0)] {
            let (position, residue) = (DVec3::new(x, 0.0, 0.0), Some((chain, 1, b' ', "GLY")));
            builder.push_atom(&AtomRecord { position, residue, ..AtomRecord::default() });
        }
        for (a, b) in [(0, 1), (1, 2)] {
            builder.push_bond(Bond::new(a, b, BondOrder::Single, BondSource::File));
        }
        builder.build(&mut Diagnostics::default())
    }

    fn assembly() -> Assembly {
        let mut assembly = Assembly::new("1", "a row");
        assembly.push(vec![0..2], &[shift(0.0), shift(10.0), shift(20.0)]);
        assembly.push(vec![2..3], &[shift(0.0), shift(20.0)]);
        assembly.push(vec![0..1], &[shift(30.0)]);
        assembly
    }

    #[test]
    fn operations_are_kept_once_and_atoms_of_several_parts_have_all_of_theirs() {
        let assembly = assembly();
        assert_eq!(assembly.operations.len(), 4);
        let (sets, set_of) = assembly.sets(4);
        let of = |atom: usize| sets.get(set_of[atom] as usize).cloned();
        assert_eq!(of(0), Some(vec![0, 1, 2, 3]));
        assert_eq!((of(1), of(2), of(3)), (Some(vec![0, 1, 2]), Some(vec![0, 2]), None));
        assert_eq!(assembly.atom_count(4), 9);
        // Ranges that are too long end with the atoms.
        let mut far = Assembly::new("2", "");
        far.push(vec![3..9, 20..30], &[shift(1.0)]);
        assert_eq!(far.atom_count(4), 1);
        let mut listed = Assembly::new("3", "");
        listed.push(vec![0..3, 3..4], &[shift(0.0)]);
        assert!(listed.is_as_listed(4) && !far.is_as_listed(4) && !assembly.is_as_listed(4));
    }

    #[test]
    fn copies_have_bonds_where_both_atoms_are_copied_and_chains_of_their_own() {
        let whole = structure().assembled(&assembly());
        let x: Vec<f64> = (0..whole.atom_count()).map(|atom| whole.positions().get(atom).x).collect();
        assert_eq!(x, [0.0, 1.0, 2.0, 10.0, 11.0, 20.0, 21.0, 22.0, 30.0]);
        let bonds: Vec<_> = whole.bonds().iter().map(|bond| (bond.a, bond.b)).collect();
        assert_eq!(bonds, [(0, 1), (1, 2), (3, 4), (5, 6), (6, 7)]);
        let chain = |atom: usize| {
            let residue = whole.residues()[whole.residue_index(atom).unwrap()];
            whole.chains().nth(residue.chain as usize).unwrap().to_owned()
        };
        assert_eq!([0, 2, 3, 5, 7, 8].map(chain), ["A", "B", "A-2", "A-3", "B-3", "A-4"]);
    }

    #[test]
    fn a_subset_keeps_the_assembly_of_what_is_left() {
        let mut structure = structure();
        structure.assemblies = vec![assembly()];
        let some = structure.subset(&[false, true, true, true]);
        let parts: Vec<_> = some.assemblies()[0].parts.iter().map(|part| part.atoms.clone()).collect();
        assert_eq!(parts, [vec![0..1], vec![1..2]]);
        assert_eq!(some.assembly("1").map(|found| found.atom_count(3)), Some(5));
    }

    #[test]
    fn only_motions_that_keep_distances_are_rigid() {
        let turn = DAffine3::from_rotation_z(1.0);
        assert!(is_rigid(&turn) && is_rigid(&DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0))));
        assert!(!is_rigid(&DAffine3::from_scale(DVec3::splat(1.01))) && !is_rigid(&shift(1e7)));
        assert!(!is_rigid(&DAffine3::from_translation(DVec3::NAN)) && !is_rigid(&DAffine3::from_scale(DVec3::ZERO)));
    }
}
