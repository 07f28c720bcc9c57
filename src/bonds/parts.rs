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
    use crate::structure::{BondOrder, BondSource};

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
}
