//! A list for every atom, all of them in one: bonds and neighbours, which everything that walks a molecule asks for.

/// Entries by atom; those of one atom are in the order in which they were given.
#[derive(Debug, Clone)]
pub(crate) struct ByAtom<T> {
    /// The entries of atom `i` are `all[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    all: Vec<T>,
}

impl<T: Copy> ByAtom<T> {
    /// From atoms (below `atom_count`) and entries; `entries` is gone through twice, once to count.
    pub(crate) fn new<I: Iterator<Item = (u32, T)>>(atom_count: usize, entries: impl Fn() -> I) -> ByAtom<T> {
        let mut first = vec![0u32; atom_count + 1];
        for (atom, _) in entries() {
            first[atom as usize + 1] += 1;
        }
        for atom in 0..atom_count {
            first[atom + 1] += first[atom];
        }
        // Whatever stands there is written over.
        let mut all = entries().next().map_or(Vec::new(), |(_, entry)| vec![entry; first[atom_count] as usize]);
        for (atom, entry) in entries() {
            let slot = &mut first[atom as usize];
            all[*slot as usize] = entry;
            *slot += 1;
        }
        // Each has moved to where the next one's begin.
        first.rotate_right(1);
        first[0] = 0;
        ByAtom { first, all }
    }

    /// The entries of an atom.
    #[inline]
    pub(crate) fn of(&self, atom: usize) -> &[T] {
        &self.all[self.first[atom] as usize..self.first[atom + 1] as usize]
    }

    /// The number of atoms.
    pub(crate) fn atom_count(&self) -> usize {
        self.first.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::ByAtom;

    #[test]
    fn entries_are_found_by_their_atom_in_their_order() {
        let entries = [(3, 'a'), (1, 'b'), (3, 'c'), (0, 'd'), (3, 'e')];
        let by_atom = ByAtom::new(5, || entries.into_iter());
        let of = |atom| by_atom.of(atom).iter().collect::<String>();
        assert_eq!([of(0), of(1), of(2), of(3), of(4)], ["d", "b", "", "ace", ""]);
        assert_eq!(by_atom.atom_count(), 5);
        let none = ByAtom::<char>::new(2, std::iter::empty);
        assert!(none.of(0).is_empty() && none.of(1).is_empty());
    }
}
