//! Parts of a structure that nothing joins: each is worked on by itself, all cores at work, and what the work needs stays in a core's caches.
//!
//! A part is a run of atoms, so that it is cut out of any list of atoms or of sorted bonds by its ends, and its own numbers are those of the whole
//! less the first one. Files list molecule by molecule, so that there are as many such runs as one likes. Where they do not, and in a network
//! without end, all is one part, and nothing is lost.

use crate::structure::Bond;
use std::ops::Range;

/// Fewest atoms of a part but for the last one. Chosen: what is kept of so many while their orders are found takes some megabytes, and a core some
/// 50 ms.
pub(super) const LEAST: usize = 32_768;

/// Splits so many atoms where no pair joins those before with those behind.
pub(super) fn split(atoms: usize, least: usize, pairs: impl Iterator<Item = (u32, u32)>) -> Vec<Range<usize>> {
    if atoms < 2 * least {
        return vec![0..atoms];
    }
    // The last atom that each is paired with.
    let mut farthest = vec![0u32; atoms];
    for (a, b) in pairs {
        if let Some(slot) = farthest.get_mut(a.min(b) as usize) {
            *slot = (*slot).max(a.max(b));
        }
    }
    let mut parts = Vec::new();
    let (mut first, mut last_joined) = (0, 0);
    for (atom, &farthest) in farthest.iter().enumerate() {
        if atom > last_joined && atom - first >= least {
            parts.push(first..atom);
            first = atom;
        }
        last_joined = last_joined.max(farthest as usize);
    }
    parts.push(first..atoms);
    parts
}

/// Those between which there is no bond, each with its bonds' places in the list. Of a list that is not in the order of its atoms it is all.
pub(super) fn of_bonds(atoms: usize, bonds: &[Bond]) -> Vec<(Range<usize>, Range<usize>)> {
    let is_in_order = atoms >= 2 * LEAST && bonds.is_sorted_by_key(|bond| bond.a) && bonds.iter().all(|b| b.a <= b.b);
    if !is_in_order {
        return vec![(0..atoms, 0..bonds.len())];
    }
    let parts = split(atoms, LEAST, bonds.iter().map(|bond| (bond.a, bond.b)));
    let mut at = 0;
    let with_bonds = |part: Range<usize>| {
        let first = at;
        at += bonds[first..].partition_point(|bond| (bond.a as usize) < part.end);
        (part, first..at)
    };
    parts.into_iter().map(with_bonds).collect()
}

/// A bond by the numbers of its atoms in a part that begins so many further on, or back.
pub(super) fn renumbered(bond: Bond, number: impl Fn(u32) -> u32) -> Bond {
    Bond { a: number(bond.a), b: number(bond.b), ..bond }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bonds::{BondOptions, assign, assign_unless};
    use crate::error::Error;
    use crate::import::{ImportOptions, read_path};
    use crate::stop::Stop;
    use crate::structure::{AtomRecord, BondOrder, BondSource, Diagnostics, Structure, StructureBuilder};
    use glam::DVec3;
    use std::path::Path;

    #[test]
    fn parts_are_cut_where_nothing_joins() {
        let pairs = [(4, 2), (2, 3), (0, 1), (5, 5), (6, 9)];
        assert_eq!(split(12, 1, pairs.into_iter()), [0..2, 2..5, 5..6, 6..10, 10..11, 11..12]);
        assert_eq!(split(12, 3, pairs.into_iter()), [0..5, 5..10, 10..12]);
        assert_eq!(split(12, 3, [(0, 11)].into_iter()), [0..12]);
        assert_eq!(split(12, 7, pairs.into_iter()), [0..12]);
        assert_eq!(split(0, 1, std::iter::empty()), [0..0]);
    }

    #[test]
    fn each_part_has_its_bonds() {
        let atoms = 4 * LEAST;
        let bond = |a: usize, b: usize| Bond::new(a as u32, b as u32, BondOrder::Single, BondSource::Distance);
        let ends = [LEAST - 1, 2 * LEAST, 2 * LEAST + 1];
        let bonds = [bond(0, 7), bond(ends[0], ends[1]), bond(ends[1] - 1, ends[1]), bond(ends[2], ends[2] + 1)];
        let last = 3 * LEAST + 1;
        let want = vec![(0..ends[2], 0..3), (ends[2]..last, 3..4), (last..atoms, 4..4)];
        assert_eq!(of_bonds(atoms, &bonds), want);
        let turned = bonds.iter().rev().copied().collect::<Vec<_>>();
        assert_eq!(of_bonds(atoms, &turned), vec![(0..atoms, 0..4)]);
    }

    /// Copies of molecules of `data/` side by side, without their bonds: all atoms of a copy after each other, or of all copies in turn.
    fn copies(names: &[&str], count: usize, in_turn: bool) -> Structure {
        let mut atoms = Vec::new();
        for name in names {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
            let document = read_path(&path, &ImportOptions::default()).unwrap();
            let molecule = document.at_frame(0).unwrap();
            let shift = DVec3::Y * 40.0 * atoms.len() as f64;
            atoms.extend(
                (0..molecule.atom_count())
                    .map(|atom| (molecule.elements()[atom], molecule.positions().get(atom) + shift)),
            );
        }
        let mut builder = StructureBuilder::new();
        for index in 0..count * atoms.len() {
            let (copy, atom) = match in_turn {
                true => (index % count, index / count),
                false => (index / atoms.len(), index % atoms.len()),
            };
            let (element, position) = atoms[atom];
            let shift = DVec3::new((copy % 64) as f64, 0.0, (copy / 64) as f64) * 20.0;
            builder.push_atom(&AtomRecord { element, position: position + shift, ..AtomRecord::default() });
        }
        builder.build(&mut Diagnostics::default())
    }

    /// Without the orders of aromatic bonds: of two Kekulé forms that are as good as each other either may be found.
    fn certain(bonds: &[Bond]) -> Vec<Bond> {
        let order = |bond: &Bond| if bond.aromatic { BondOrder::Single } else { bond.order };
        bonds.iter().map(|bond| Bond { order: order(bond), ..*bond }).collect()
    }

    #[test]
    fn a_molecule_has_the_same_bonds_alone_and_in_a_part_of_many() {
        let names = ["caffeine.sdf", "ferrocene.xyz", "aspirin.sdf"];
        let one = assign(copies(&names, 1, false), &BondOptions::default());
        let size = one.atom_count();
        let count = 2 * LEAST / size + 2;
        let split = assign(copies(&names, count, false), &BondOptions::default());
        let of = |bonds: &[Bond]| super::of_bonds(count * size, bonds).len();
        assert!(of(split.bonds()) > 1, "there is more than one part");
        let (one, all) = (certain(one.bonds()), certain(split.bonds()));
        assert_eq!(all.len(), count * one.len());
        for (copy, bonds) in all.chunks(one.len()).enumerate() {
            let want: Vec<Bond> =
                one.iter().map(|&bond| renumbered(bond, |atom| atom + (copy * size) as u32)).collect();
            assert_eq!(bonds, want);
        }
        // Where the copies of a molecule are listed in turn, no part ends among them.
        let mixed = assign(copies(&names, count, true), &BondOptions::default());
        let apart = |bond: &Bond| renumbered(*bond, |atom| atom % count as u32 * size as u32 + atom / count as u32);
        let mut bonds: Vec<Bond> = certain(mixed.bonds()).iter().map(apart).collect();
        bonds.sort_by_key(|bond| (bond.a, bond.b));
        assert_eq!(bonds, all);
    }

    #[test]
    fn the_search_can_be_given_up_at_any_question() {
        let names = ["caffeine.sdf", "ferrocene.xyz", "aspirin.sdf"];
        let structure = copies(&names, 2 * LEAST / 66 + 2, false);
        let asked = Stop::at_question(usize::MAX);
        let found = assign_unless(structure.clone(), &BondOptions::default(), &asked).unwrap();
        assert_eq!(found.bonds(), assign(structure.clone(), &BondOptions::default()).bonds());
        let questions = asked.questions();
        assert!(questions > 1000, "{questions}");
        for question in [1, 2, questions / 3, questions / 2, questions - 1, questions] {
            let stop = Stop::at_question(question);
            let result = assign_unless(structure.clone(), &BondOptions::default(), &stop);
            assert!(matches!(result, Err(Error::Stopped)), "question {question}");
            assert_eq!(stop.handles(), 1);
        }
    }
}
