//! The pairs of atoms that are near enough to bond, as a graph from which the rules drop what is none.

use crate::element::Element;
use crate::structure::{Bond, ByAtom};

/// Contacts of a nonmetal beyond which it lies in a pile and has no inferred bonds. Twelve is the most of any real
/// solid (boron clusters have 6 to 8), 24 leaves room for unlabelled disorder. The limit keeps the work on a
/// pile of atoms in proportion to their number.
const MOST_AROUND_NONMETAL: u32 = 24;
/// The same for a metal: caesium in a cryptate or between arene rings has up to 30 atoms in range.
const MOST_AROUND_METAL: u32 = 48;

/// How a contact stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// A bond, unless a rule drops it.
    Open,
    /// The file states it: nothing drops it.
    Stated,
    /// No bond.
    Dropped,
}

/// Two atoms in bonding range, `a < b`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    pub(super) a: u32,
    pub(super) b: u32,
    /// Distance less the sum of the covalent radii in ångström; −∞ for a stated bond, which goes before all others.
    pub(super) excess: f32,
    pub(super) state: State,
}

impl Contact {
    /// The other atom.
    pub(super) fn other(&self, atom: usize) -> usize {
        if self.a as usize == atom { self.b as usize } else { self.a as usize }
    }

    /// What ranks contacts: the best first, ties by index.
    pub(super) fn rank(&self) -> (OrderedF32, u32, u32) {
        (OrderedF32(self.excess), self.a, self.b)
    }
}

/// An f32 in its total order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OrderedF32(pub(super) f32);

impl Eq for OrderedF32 {}

impl PartialOrd for OrderedF32 {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for OrderedF32 {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// All contacts, and those of each atom.
pub(super) struct Contacts {
    list: Vec<Contact>,
    around: ByAtom<u32>,
}

impl Contacts {
    /// The graph of the stated bonds and the contacts found, of which the stated pairs are left out.
    pub(super) fn new(elements: &[Element], stated: &[Bond], mut found: Vec<Contact>) -> Contacts {
        drop_piles(elements, &mut found);
        if !stated.is_empty() {
            found.retain(|contact| {
                stated.binary_search_by_key(&(contact.a, contact.b), |bond| (bond.a, bond.b)).is_err()
            });
            found.extend(stated.iter().map(|bond| Contact {
                a: bond.a,
                b: bond.b,
                excess: f32::NEG_INFINITY,
                state: State::Stated,
            }));
        }
        // Fewer than 2^32: each takes 16 bytes.
        let numbers = || (0u32..).zip(&found).flat_map(|(number, contact)| [(contact.a, number), (contact.b, number)]);
        let around = ByAtom::new(elements.len(), numbers);
        Contacts { list: found, around }
    }

    /// The number of atoms.
    pub(super) fn atom_count(&self) -> usize {
        self.around.atom_count()
    }

    /// All contacts, the dropped ones too, by their numbers.
    pub(super) fn list(&self) -> &[Contact] {
        &self.list
    }

    /// The numbers of all contacts of an atom, the dropped ones too.
    pub(super) fn numbers(&self, atom: usize) -> &[u32] {
        self.around.of(atom)
    }

    /// The contacts of an atom that are not dropped: number, contact, other atom.
    pub(super) fn of(&self, atom: usize) -> impl Iterator<Item = (u32, &Contact, usize)> + Clone {
        self.numbers(atom).iter().filter_map(move |&number| {
            let contact = &self.list[number as usize];
            (contact.state != State::Dropped).then(|| (number, contact, contact.other(atom)))
        })
    }

    /// Drops a contact, unless the file states it.
    pub(super) fn drop(&mut self, number: u32) {
        let contact = &mut self.list[number as usize];
        if contact.state == State::Open {
            contact.state = State::Dropped;
        }
    }

    /// Drops many.
    pub(super) fn drop_all(&mut self, numbers: impl IntoIterator<Item = u32>) {
        for number in numbers {
            self.drop(number);
        }
    }

    /// The atoms in contact with both ends of a contact, with the excess of the worse of the two sides.
    pub(super) fn common(&self, contact: Contact) -> impl Iterator<Item = (usize, f32)> {
        self.of(contact.a as usize).filter_map(move |(_, left, atom)| {
            let (_, right, _) = self.of(contact.b as usize).find(|&(_, _, other)| other == atom)?;
            Some((atom, left.excess.max(right.excess)))
        })
    }
}

/// Drops the contacts of atoms that have too many.
fn drop_piles(elements: &[Element], found: &mut Vec<Contact>) {
    let mut counts = vec![0u32; elements.len()];
    for contact in found.iter() {
        counts[contact.a as usize] += 1;
        counts[contact.b as usize] += 1;
    }
    let most = |atom: usize| if elements[atom].is_metal() { MOST_AROUND_METAL } else { MOST_AROUND_NONMETAL };
    if (0..counts.len()).any(|atom| counts[atom] > most(atom)) {
        let is_sound = |atom: u32| counts[atom as usize] <= most(atom as usize);
        found.retain(|contact| is_sound(contact.a) && is_sound(contact.b));
    }
}
