//! Too many or too narrow bonds of a nonmetal: the longest goes first.
//!
//! As in Open Babel and ChimeraX, contacts are taken from the best (least excess over the covalent radii) to the worst,
//! and one that would overfill an atom or stand too near beside a better one is no bond. Before that, diagonals of
//! four-membered rings are recognised for what they are. Contacts of metals are not counted here.

use super::contacts::{Contact, Contacts, State};
use super::rules;
use super::sites::Sites;
use crate::element::Element;
use glam::Vec3;
use rayon::prelude::*;

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
pub(super) fn settle(contacts: &mut Contacts, elements: &[Element], positions: &[Vec3], sites: &Sites<'_>) {
    drop_diagonals(contacts, elements);
    let cap_of = |atom: usize| {
        let is_overfull = is_overfull(contacts, elements, positions, sites, atom);
        if is_overfull { cap(contacts, elements, atom) } else { ALL_FIT }
    };
    let caps: Vec<u8> = (0..contacts.atom_count()).into_par_iter().with_min_len(16_384).map(cap_of).collect();
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
            if caps[atom] == ALL_FIT {
                return true;
            }
            let new = contact.other(atom);
            let others = contacts
                .of(atom)
                .filter(|&(number, _, other)| accepted[number as usize] && !sites.are_alternatives(new, other));
            let at_once = sites.most_at_once(others.clone().map(|(_, _, other)| other));
            let is_beside = |(_, beside, other): (u32, &Contact, usize)| {
                let here = positions[atom];
                beside.state == State::Open && is_narrow(positions[new] - here, positions[other] - here)
            };
            at_once < usize::from(caps[atom]) && !others.clone().any(is_beside)
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
fn is_overfull(contacts: &Contacts, elements: &[Element], positions: &[Vec3], sites: &Sites<'_>, atom: usize) -> bool {
    // Most atoms have one contact, or none.
    if contacts.numbers(atom).len() < 2 || elements[atom].is_metal() {
        return false;
    }
    let mut count = 0;
    // A stated bond may be of any length and direction; it is no reason to refuse another. Eight directions are more than
    // an atom has that is not overfull; of more, the first eight are enough to find two that are too near each other.
    let mut near = [(Vec3::ZERO, 0); 8];
    let mut open = 0;
    for (_, contact, other) in contacts.of(atom).filter(|&(_, _, other)| !elements[other].is_metal()) {
        count += 1;
        if contact.state == State::Open && open < near.len() {
            near[open] = (positions[other] - positions[atom], other);
            open += 1;
        }
    }
    if count > usize::from(rules::valence_cap(elements[atom]).unwrap_or(ALL_FIT)) {
        let at_once = sites.most_at_once(partners(contacts, elements, atom));
        if at_once > usize::from(cap(contacts, elements, atom)) {
            return true;
        }
    }
    let are_narrow =
        |one: (Vec3, usize), other: (Vec3, usize)| is_narrow(one.0, other.0) && !sites.are_alternatives(one.1, other.1);
    (1..open).any(|i| near[..i].iter().any(|&other| are_narrow(near[i], other)))
}

/// Whether the angle between two directions is too narrow for two bonds.
fn is_narrow(one: Vec3, other: Vec3) -> bool {
    let dot = one.dot(other);
    let limit = NARROWEST_ANGLE_COSINE * NARROWEST_ANGLE_COSINE * one.length_squared() * other.length_squared();
    dot > 0.0 && dot * dot > limit
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
