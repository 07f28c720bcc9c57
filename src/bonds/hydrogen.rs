//! A hydrogen takes one bond.
//!
//! Its partner is the nearest nonmetal (by excess over the covalent radii); without one, another such hydrogen as H₂;
//! without that, the nearest metal. Bridges between two borons keep both bonds, and two borons that share two such
//! bridges have none of their own: diborane has eight bonds.

use super::contacts::{Contacts, State};
use super::sites::Sites;
use crate::element::Element;

/// Leaves every hydrogen the bonds it has.
pub(super) fn settle(contacts: &mut Contacts, elements: &[Element], sites: &Sites<'_>) {
    let hydrogens: Vec<usize> = (0..contacts.atom_count())
        .filter(|&atom| elements[atom] == Element::H && !contacts.numbers(atom).is_empty())
        .collect();
    let mut lost = Vec::new();
    for &atom in hydrogens.iter().filter(|&&atom| contacts.numbers(atom).len() > 1) {
        lose_to_nonmetals(contacts, elements, sites, atom, &mut lost);
    }
    contacts.drop_all(lost);
    pair_up(contacts, elements, &hydrogens);
    let mut lost = Vec::new();
    for &atom in &hydrogens {
        // What is left is one nonmetal, another hydrogen, a boron bridge, or metals.
        let best = contacts
            .of(atom)
            .map(|(number, contact, other)| (elements[other].is_metal(), contact.rank(), number))
            .min();
        let others = contacts
            .of(atom)
            .filter(|&(number, _, other)| elements[other].is_metal() && best.is_none_or(|(_, _, kept)| kept != number));
        lost.extend(others.map(|(number, ..)| number));
    }
    contacts.drop_all(lost);
    unbridge(contacts, elements);
}

/// Lists what a hydrogen with a stated bond or a nonmetal in range loses: all but the best of these.
fn lose_to_nonmetals(contacts: &Contacts, elements: &[Element], sites: &Sites<'_>, atom: usize, lost: &mut Vec<u32>) {
    let is_stated = contacts.of(atom).any(|(_, contact, _)| contact.state == State::Stated);
    let heavy = |other: usize| !elements[other].is_metal() && elements[other] != Element::H;
    let mut best: Vec<_> = contacts
        .of(atom)
        .filter(|&(_, contact, other)| if is_stated { contact.state == State::Stated } else { heavy(other) })
        .map(|(number, contact, other)| (contact.rank(), number, other))
        .collect();
    if best.is_empty() {
        return;
    }
    best.sort_unstable_by_key(|&(rank, ..)| rank);
    if !is_stated {
        // Of a bridge the two nearest borons stay. Nothing else has two, but for alternate locations of the partner.
        let first = best[0].2;
        let is_boron = |other: usize| elements[other] == Element::B;
        let bridged = best[1..].iter().map(|&(_, _, other)| other).find(|&other| is_boron(first) && is_boron(other));
        best.retain(|&(_, _, other)| other == first || Some(other) == bridged || sites.are_alternatives(first, other));
    }
    let kept = |number: u32| best.iter().any(|&(_, kept, _)| kept == number);
    lost.extend(contacts.of(atom).filter(|&(number, ..)| !kept(number)).map(|(number, ..)| number));
}

/// Pairs hydrogens that have no nonmetal in range, the nearest first. A paired one has no metal.
fn pair_up(contacts: &mut Contacts, elements: &[Element], hydrogens: &[usize]) {
    let mut pairs: Vec<_> = hydrogens
        .iter()
        .flat_map(|&atom| contacts.of(atom).filter(move |&(_, _, other)| other > atom))
        .filter(|&(_, contact, other)| elements[other] == Element::H && elements[contact.other(other)] == Element::H)
        .map(|(number, contact, _)| (contact.rank(), number))
        .collect();
    pairs.sort_unstable();
    for (_, number) in pairs {
        let pair = contacts.list()[number as usize];
        if pair.state == State::Dropped {
            continue;
        }
        for atom in [pair.a as usize, pair.b as usize] {
            let others: Vec<u32> =
                contacts.of(atom).map(|(other, ..)| other).filter(|&other| other != number).collect();
            contacts.drop_all(others);
        }
    }
}

/// Drops the boron–boron contact under two hydrogen bridges: diborane's 1.77 Å is in range of a bond but holds no
/// electrons of its own.
fn unbridge(contacts: &mut Contacts, elements: &[Element]) {
    let mut lost = Vec::new();
    for atom in (0..contacts.atom_count()).filter(|&atom| elements[atom] == Element::B) {
        for (number, contact, other) in contacts.of(atom) {
            let is_pair = elements[other] == Element::B && other > atom;
            if is_pair && contacts.common(*contact).filter(|&(bridge, _)| elements[bridge] == Element::H).count() >= 2 {
                lost.push(number);
            }
        }
    }
    contacts.drop_all(lost);
}
