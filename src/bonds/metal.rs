//! Metals: which contacts are bonds.
//!
//! A metal bonds to every donor in range, that is to every nonmetal that has electrons left to give and is not merely
//! the far end of a better donor (the carbon of a carboxylate). An ion, which is a residue of its own, floats unless it
//! has three donors. Metals bond to metals by distance, but not across the bridges of oxides, sulfides and salts.
//!
//! Which of these bonds are covalent and which coordination, [`super::ligands`] says.

use super::contacts::{Contact, Contacts, State};
use super::rules;
use super::sites::{Role, Sites};
use crate::element::Element;

/// Donors that an ion needs to bond at all: fewer are chance contacts of a crystal or a simulation.
const FEWEST_DONORS_OF_ION: usize = 3;
/// How much farther over its radii an atom may be from the metal than its neighbour that is a donor. Side-on ligands
/// (peroxide, alkenes, aldehydes) differ by up to 0.05 Å; the carbon of a chelating carboxylate by 0.25 Å (Cd,
/// Na) to 0.31 Å (U), the nitrogen of a nitrate on lanthanum by 0.4 Å.
const FAR_END_EXCESS: f32 = 0.15;
/// Metal–metal bonds under two or more bridges of nonmetals are shorter than the radii by this factor. With: W₂Cl₉³⁻ 0.74,
/// Fe₂(CO)₉ 0.83, Mo₆Cl₈⁴⁺ 0.84. Without: Fe₂S₂ 0.89, rutile 0.93, wüstite and MgO 1.0.
const BRIDGED_RATIO: f32 = 0.85;
/// Under one bridge. Chosen: metals in a row of M–O–M are not bonded (in rutile, titanium at the shared corners of
/// octahedra is 3.57 Å apart, 0.37 Å over the radii). Coinage metals under one heavy donor, sulfur or a halogen, are
/// bonded as far as without it ([`rules`]): in thiolate-covered gold such pairs are as near as the bare ones beside them
/// (both 3.0 to 3.15 Å).
const BRIDGED_ONCE_EXCESS: f32 = 0.3;

/// Drops what is no bond of a metal.
pub(super) fn settle(contacts: &mut Contacts, elements: &[Element], sites: &Sites<'_>) {
    let metals: Vec<usize> = (0..contacts.atom_count())
        .filter(|&atom| elements[atom].is_metal() && !contacts.numbers(atom).is_empty())
        .collect();
    let mut lost = Vec::new();
    for &metal in &metals {
        for (number, contact, other) in contacts.of(metal) {
            if contact.state == State::Open
                && !elements[other].is_metal()
                && !is_donor(contacts, elements, sites, metal, other, contact)
            {
                lost.push(number);
            }
        }
    }
    contacts.drop_all(lost);
    let mut lost = Vec::new();
    for &metal in metals.iter().filter(|&&metal| sites.role(metal) == Role::Ion) {
        let floats =
            contacts.of(metal).filter(|&(_, _, other)| !elements[other].is_metal()).count() < FEWEST_DONORS_OF_ION;
        let contacts = contacts.of(metal).filter(|&(_, _, other)| floats || elements[other].is_metal());
        lost.extend(contacts.map(|(number, ..)| number));
    }
    contacts.drop_all(lost);
    let mut lost = Vec::new();
    for &metal in &metals {
        let pairs = contacts.of(metal).filter(|&(_, _, other)| other > metal && elements[other].is_metal());
        lost.extend(
            pairs.filter(|(_, contact, _)| is_bridged_apart(contacts, elements, contact)).map(|(number, ..)| number),
        );
    }
    contacts.drop_all(lost);
}

/// Whether a nonmetal in range of a metal gives it electrons.
fn is_donor(
    contacts: &Contacts,
    elements: &[Element],
    sites: &Sites<'_>,
    metal: usize,
    atom: usize,
    contact: &Contact,
) -> bool {
    let element = elements[atom];
    if element == Element::H {
        return true; // the hydrogens have chosen already
    }
    // Carbon does not bind the ions of biomolecules; without its hydrogens it would look as if it could.
    if element == Element::C && sites.role(metal) == Role::Ion {
        return false;
    }
    let partners = || contacts.of(atom).map(|(_, _, other)| other).filter(|&other| !elements[other].is_metal());
    if rules::is_saturated(element, sites.most_at_once(partners()))
        || (element.is_halogen() && partners().any(|other| elements[other] == Element::C))
    {
        return false;
    }
    let is_far_end = |donor: usize| {
        let is_hetero = matches!(elements[donor].group(), 15..=17);
        is_hetero
            && contacts
                .of(metal)
                .any(|(_, nearer, other)| other == donor && nearer.excess < contact.excess - FAR_END_EXCESS)
    };
    !partners().any(is_far_end)
}

/// Whether two metals in range are held apart by what is between them.
fn is_bridged_apart(contacts: &Contacts, elements: &[Element], contact: &Contact) -> bool {
    let radii = rules::radii(elements[contact.a as usize], elements[contact.b as usize]);
    let is_bridge = |&(atom, _): &(usize, f32)| !elements[atom].is_metal() && elements[atom] != Element::H;
    let mut bridges = contacts.common(*contact).filter(is_bridge);
    match (bridges.next(), bridges.next()) {
        (None, _) => false,
        (Some((bridge, _)), None) => {
            let are_coinage = [contact.a, contact.b].iter().all(|&atom| elements[atom as usize].group() == 11);
            // From sodium on: the second period ends with neon.
            let is_heavy = elements[bridge].z() > 10;
            contact.excess > BRIDGED_ONCE_EXCESS && !(are_coinage && is_heavy)
        }
        _ => contact.excess > (BRIDGED_RATIO - 1.0) * radii,
    }
}

/// Whether a bond of these two elements is coordination as a rule, nothing else known.
pub(super) fn is_coordination(a: Element, b: Element) -> bool {
    let (metal, other) = if a.is_metal() { (a, b) } else { (b, a) };
    metal.is_metal() && !other.is_metal() && other != Element::H && !matches!(metal.group(), 13..=16)
}
