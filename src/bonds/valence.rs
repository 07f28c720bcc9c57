//! Too many or too narrow bonds of a nonmetal: the longest goes first.
//!
//! As in Open Babel and ChimeraX, contacts are taken from the best (least excess over the covalent radii) to the worst,
//! and one that would overfill an atom or stand too near beside a better one is no bond. Before that, diagonals of
//! four-membered rings are recognised for what they are. Contacts of metals are not counted here.

use super::contacts::{Contact, Contacts, State};
use super::rules;
use crate::element::Element;
use glam::Vec3;

/// Cosine of the narrowest angle between two bonds of a nonmetal, 38°. Open Babel's 45° would open the rings of thiirene
/// (C–S–C 40.6° by its lengths 1.27 and 1.83 Å) and tellurirane (41°).
const NARROWEST_ANGLE_COSINE: f32 = 0.788;
/// A diagonal exceeds the radii by this much more than all four sides. Measured on the real diagonals that are within
/// range: S···S of S₂N₂ (2.33 Å against 1.65 Å sides) 0.33 Å, Si···Si of cyclodisiloxane (2.4 Å) 0.25 Å,
/// C···C of bicyclo[1.1.1]pentane (1.87 Å) 0.32 Å; and on a bond that is one, that of [1.1.1]propellane
/// (1.60 Å), 0.07 Å.
const DIAGONAL_EXCESS: f32 = 0.2;

/// The cap of an atom that can hold all that is near it.
const ALL_FIT: u8 = u8::MAX;

/// Drops what the nonmetals cannot hold.
pub(super) fn settle(contacts: &mut Contacts, elements: &[Element], positions: &[Vec3]) {
    drop_diagonals(contacts, elements);
    let caps: Vec<u8> = (0..contacts.atom_count())
        .map(
            |atom| {
                if is_overfull(contacts, elements, positions, atom) { cap(contacts, elements, atom) } else { ALL_FIT }
            },
        )
        .collect();
    // An atom that can hold all its contacts never refuses one: only those of the others are weighed.
    let is_weighed = |contact: &Contact| {
        contact.state != State::Dropped
            && is_covalent(elements, contact.a as usize, contact.b as usize)
            && (caps[contact.a as usize] != ALL_FIT || caps[contact.b as usize] != ALL_FIT)
    };
    let mut weighed: Vec<_> = (contacts.list().iter().enumerate())
        .filter(|(_, contact)| is_weighed(contact))
        .map(|(number, contact)| (contact.rank(), number as u32))
        .collect();
    weighed.sort_unstable();
    let mut accepted: Vec<bool> = vec![false; if weighed.is_empty() { 0 } else { contacts.list().len() }];
    for (_, number) in weighed {
        let contact = contacts.list()[number as usize];
        let fits = |atom: usize| {
            let others = || contacts.of(atom).filter(|&(other, ..)| accepted[other as usize]);
            let is_beside = |(_, beside, other): (u32, &Contact, usize)| {
                beside.state == State::Open && is_narrow(positions, atom, contact.other(atom), other)
            };
            caps[atom] == ALL_FIT || (others().count() < usize::from(caps[atom]) && !others().any(is_beside))
        };
        if contact.state == State::Stated || (fits(contact.a as usize) && fits(contact.b as usize)) {
            accepted[number as usize] = true;
        } else {
            contacts.drop(number);
        }
    }
}

fn is_covalent(elements: &[Element], a: usize, b: usize) -> bool {
    !elements[a].is_metal() && !elements[b].is_metal()
}

/// The nonmetals around a nonmetal.
fn partners<'a>(
    contacts: &'a Contacts,
    elements: &'a [Element],
    atom: usize,
) -> impl Iterator<Item = usize> + Clone + 'a {
    contacts.of(atom).map(|(_, _, other)| other).filter(move |&other| is_covalent(elements, atom, other))
}

/// How many covalent partners an atom takes here, [`ALL_FIT`] for any number.
fn cap(contacts: &Contacts, elements: &[Element], atom: usize) -> u8 {
    let borons = || partners(contacts, elements, atom).filter(|&other| elements[other] == Element::B);
    match elements[atom] {
        // Hydrogens are settled: what they have, they keep.
        Element::H => ALL_FIT,
        // Clusters and boranes: boron has up to 7 partners, and C and N among borons 6 (icosahedral carboranes).
        Element::B if borons().nth(1).is_some() || has_bridge(contacts, elements, atom) => ALL_FIT,
        Element::C | Element::N if borons().nth(1).is_some() => 6,
        element => rules::valence_cap(element).unwrap_or(ALL_FIT),
    }
}

fn has_bridge(contacts: &Contacts, elements: &[Element], boron: usize) -> bool {
    partners(contacts, elements, boron)
        .filter(|&other| elements[other] == Element::H)
        .any(|hydrogen| partners(contacts, elements, hydrogen).nth(1).is_some())
}

/// Whether an atom has more or narrower contacts than it can hold.
fn is_overfull(contacts: &Contacts, elements: &[Element], positions: &[Vec3], atom: usize) -> bool {
    // Most atoms have one contact, or none.
    if contacts.numbers(atom).len() < 2 || elements[atom].is_metal() {
        return false;
    }
    let count = partners(contacts, elements, atom).count();
    if count > usize::from(rules::valence_cap(elements[atom]).unwrap_or(ALL_FIT))
        && count > usize::from(cap(contacts, elements, atom))
    {
        return true;
    }
    // A stated bond may be of any length and direction; it is no reason to refuse another.
    let mut rest = contacts
        .of(atom)
        .filter(|(_, contact, other)| contact.state == State::Open && is_covalent(elements, atom, *other))
        .map(|(_, _, other)| other);
    while let Some(one) = rest.next() {
        if rest.clone().any(|other| is_narrow(positions, atom, one, other)) {
            return true;
        }
    }
    false
}

/// Whether the angle `one`–`atom`–`other` is too narrow for two bonds.
fn is_narrow(positions: &[Vec3], atom: usize, one: usize, other: usize) -> bool {
    let (one, other) = (positions[one] - positions[atom], positions[other] - positions[atom]);
    one.dot(other) > NARROWEST_ANGLE_COSINE * (one.length_squared() * other.length_squared()).sqrt()
}

/// Drops contacts across four-membered rings.
fn drop_diagonals(contacts: &mut Contacts, elements: &[Element]) {
    // No side is shorter than its radii by more than 0.2 Å among heavy single bonds, so that a diagonal has some excess.
    let may_be = |contact: &Contact| {
        contact.state == State::Open
            && contact.excess > 0.5 * DIAGONAL_EXCESS
            && is_covalent(elements, contact.a as usize, contact.b as usize)
            && elements[contact.a as usize] != Element::H
            && elements[contact.b as usize] != Element::H
    };
    let is_diagonal = |contact: &Contact| {
        let sides = contacts.common(*contact).filter(|&(atom, side)| {
            !elements[atom].is_metal() && elements[atom] != Element::H && side <= contact.excess - DIAGONAL_EXCESS
        });
        sides.count() >= 2
    };
    let lost: Vec<u32> = (contacts.list().iter().enumerate())
        .filter(|(_, contact)| may_be(contact) && is_diagonal(contact))
        .map(|(number, _)| number as u32)
        .collect();
    contacts.drop_all(lost);
}
