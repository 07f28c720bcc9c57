//! Bonds from distances: find the contacts, let the rules drop what is none, name the rest.
//!
//! The order of the rules matters: hydrogens choose first, then nonmetals shed what they cannot hold, then metals take
//! what has electrons left. Within a rule nothing depends on the order of the atoms: each looks at the contacts as they
//! were before it, or takes them from the best to the worst. So parts of a structure that no contact joins are settled at the same time.

use super::contacts::{Contact, Contacts, State};
use super::grid::Grid;
use super::residues::Known;
use super::rules::{self, PairTable};
use super::sites::{Role, Sites};
use super::{BondOptions, hydrogen, metal, parts, valence};
use crate::element::Element;
use crate::stop::Stop;
use crate::structure::{Bond, BondKind, BondOrder, BondSource, Structure, atom_flags};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// How much longer than the covalent radii a bond between two residues may be that takes the place of hydrogens which are
/// not in the model, at a carbon of the dictionary. Our choice: a sound one that no record states (the thioethers of haem
/// and cysteine, C–S 1.82 Å) has 0.01 Å, and the full tolerance would bond side chains that merely clash.
const CARBON_LINK_EXCESS: f32 = 0.2;

/// The bonds between atoms at these positions that are not among the settled ones (sorted), sorted. `known` says of
/// which atoms the partners are known already.
pub(super) fn find(
    structure: &Structure,
    positions: &[Vec3],
    settled: &[Bond],
    known: &Known,
    options: &BondOptions,
    stop: &Stop,
) -> Vec<Bond> {
    let elements = structure.elements();
    if positions.len() != elements.len() {
        return Vec::new();
    }
    let sites = Sites::new(structure);
    let table = PairTable::new(elements, options);
    let takes_part = |atom: usize| {
        let element = elements[atom];
        let is_atom = element != Element::DUMMY && structure.flags(atom) & atom_flags::PARTICLE == 0;
        // A lone halide ion takes part: metals bond to it.
        // A hydrogen that has its bond takes no other.
        let is_done = element == Element::H && known.standing(atom).is_full();
        is_atom && !is_done && table.reach(table.species(element)) > 0.0
    };
    let grid = Grid::new(positions, elements, &table, takes_part);
    let near = |a: u32, b: u32, distance: f32| {
        let (element_a, element_b) = (elements[a as usize], elements[b as usize]);
        let excess = distance - rules::radii(element_a, element_b);
        // What is known comes first: of a protein it settles most pairs.
        let may_be = !rules::is_too_near(distance)
            && is_open(structure, known, [a as usize, b as usize], excess)
            && sites.may_bond(a as usize, b as usize);
        may_be.then_some(Contact { a, b, excess, state: State::Open })
    };
    let found = grid.pieces_of_pairs(near, stop);
    drop(grid);
    let ends = found.iter().flatten().map(|contact| (contact.a, contact.b));
    let parts = parts::split(elements.len(), parts::LEAST, ends.chain(settled.iter().map(|bond| (bond.a, bond.b))));
    let contacts = by_part(&parts, found);
    let find = |(part, found): (Range<usize>, Vec<Contact>)| {
        if stop.is_set() {
            return Vec::new();
        }
        let first = part.start as u32; // a structure has fewer than 2^32 atoms
        let of_part = |bonds: &[Bond], end: usize| bonds.partition_point(|bond| (bond.a as usize) < end);
        let settled = &settled[of_part(settled, part.start)..of_part(settled, part.end)];
        let settled = settled.iter().map(|&bond| parts::renumbered(bond, |atom| atom - first)).collect();
        let mut bonds =
            settle(&elements[part.clone()], &positions[part.clone()], settled, found, &sites.from(part.start));
        for bond in &mut bonds {
            *bond = parts::renumbered(*bond, |atom| atom + first);
        }
        bonds
    };
    let mut bonds: Vec<Vec<Bond>> = parts.into_par_iter().zip(contacts).with_max_len(1).map(find).collect();
    if bonds.len() == 1 { bonds.pop().unwrap_or_default() } else { bonds.concat() }
}

/// The contacts of each part, by the numbers of its own atoms.
fn by_part(parts: &[Range<usize>], found: Vec<Vec<Contact>>) -> Vec<Vec<Contact>> {
    let mut counts = vec![0usize; parts.len()];
    let mut at = 0;
    // Contacts that are found one after the other are near each other, and so mostly of one part.
    let mut part_of = |contact: &Contact| {
        let atom = contact.a as usize;
        if !parts[at].contains(&atom) {
            at = parts.partition_point(|part| part.end <= atom);
        }
        at
    };
    found.iter().flatten().for_each(|contact| counts[part_of(contact)] += 1);
    let mut sorted: Vec<Vec<Contact>> = counts.into_iter().map(Vec::with_capacity).collect();
    for contact in found.into_iter().flatten() {
        let part = part_of(&contact);
        let first = parts[part].start as u32;
        sorted[part].push(Contact { a: contact.a - first, b: contact.b - first, ..contact });
    }
    sorted
}

/// The bonds among these contacts of atoms that nothing joins to others.
fn settle(
    elements: &[Element],
    positions: &[Vec3],
    settled: Vec<Bond>,
    found: Vec<Contact>,
    sites: &Sites<'_>,
) -> Vec<Bond> {
    // The rules look at atoms with contacts and all that these are bonded to: bonds of others are left out, most of a
    // structure whose residues are known.
    let mut has_contact = vec![false; elements.len()];
    for atom in found.iter().flat_map(|contact| [contact.a, contact.b]) {
        has_contact[atom as usize] = true;
    }
    let matters =
        |bond: &Bond| bond.kind != BondKind::Hydrogen && (has_contact[bond.a as usize] || has_contact[bond.b as usize]);
    let settled: Vec<Bond> = settled.into_iter().filter(matters).collect();
    let mut contacts = Contacts::new(elements, &settled, found);
    hydrogen::settle(&mut contacts, elements, sites);
    valence::settle(&mut contacts, elements, positions, sites);
    metal::settle(&mut contacts, elements, sites);
    bonds(&contacts, elements, sites)
}

/// Whether what is known of the residues of two atoms leaves room for a bond between them.
fn is_open(structure: &Structure, known: &Known, [a, b]: [usize; 2], excess: f32) -> bool {
    let standing = [known.standing(a), known.standing(b)];
    if !standing.iter().any(|standing| standing.is_known()) {
        return true;
    }
    let are_known = standing.iter().all(|standing| standing.is_known());
    let same_residue = structure.residue_index(a) == structure.residue_index(b);
    if same_residue {
        return !are_known; // what the component does not list is no bond
    }
    let elements = [a, b].map(|atom| structure.elements()[atom]);
    if elements.iter().any(|element| element.is_metal()) {
        return true;
    }
    let at_carbon = standing.iter().any(|standing| standing.lacks_only_hydrogens_of_carbon());
    !standing.iter().any(|standing| standing.is_full()) && (!at_carbon || excess <= CARBON_LINK_EXCESS)
}

/// The open contacts that are left, as bonds.
fn bonds(contacts: &Contacts, elements: &[Element], sites: &Sites<'_>) -> Vec<Bond> {
    let mut bonds = Vec::with_capacity(contacts.list().len());
    for atom in 0..contacts.atom_count() {
        let first = bonds.len();
        let open = contacts.of(atom).filter(|&(_, contact, other)| contact.state == State::Open && other > atom);
        for (_, contact, _) in open {
            let [one, other] = [contact.a, contact.b].map(|atom| elements[atom as usize]);
            let is_of_ion = |atom: u32| sites.role(atom as usize) == Role::Ion;
            let is_donation = one.is_metal() != other.is_metal() && one != Element::H && other != Element::H;
            // What of it shares a pair after all, is found when all bonds are known.
            let kind = match is_donation && (is_of_ion(contact.a) || is_of_ion(contact.b))
                || metal::is_coordination(one, other)
            {
                true => BondKind::Coordination,
                false => BondKind::Covalent,
            };
            let order = if kind == BondKind::Coordination { BondOrder::Unknown } else { BondOrder::Single };
            bonds.push(Bond { kind, ..Bond::new(contact.a, contact.b, order, BondSource::Distance) });
        }
        bonds[first..].sort_unstable_by_key(|bond| bond.b);
    }
    bonds
}
