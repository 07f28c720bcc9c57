//! Bonds from distances: find the contacts, let the rules drop what is none, name the rest.
//!
//! The order of the rules matters: hydrogens choose first, then nonmetals shed what they cannot hold, then metals take
//! what has electrons left. Within a rule nothing depends on the order of the atoms: each looks at the contacts as they
//! were before it, or takes them from the best to the worst.

use super::contacts::{Contact, Contacts, State};
use super::grid::Grid;
use super::rules::{self, PairTable};
use super::sites::{Role, Sites};
use super::{BondOptions, hydrogen, metal, valence};
use crate::element::Element;
use crate::structure::{Bond, BondKind, BondOrder, BondSource, Structure, atom_flags};
use glam::Vec3;

/// The bonds between atoms at these positions that are not among the stated ones (sorted), sorted.
pub(super) fn find(structure: &Structure, positions: &[Vec3], stated: &[Bond], options: &BondOptions) -> Vec<Bond> {
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
        is_atom && table.reach(table.species(element)) > 0.0
    };
    let grid = Grid::new(positions, elements, &table, takes_part);
    let found = grid.pairs(|a, b, distance| {
        let (element_a, element_b) = (elements[a as usize], elements[b as usize]);
        if rules::is_too_near(distance) || !sites.may_bond(a as usize, b as usize) {
            return None;
        }
        Some(Contact { a, b, excess: distance - rules::radii(element_a, element_b), state: State::Open })
    });
    let stated: Vec<Bond> = stated.iter().copied().filter(|bond| bond.kind != BondKind::Hydrogen).collect();
    let mut contacts = Contacts::new(elements, &stated, found);
    hydrogen::settle(&mut contacts, elements, &sites);
    valence::settle(&mut contacts, elements, positions, &sites);
    metal::settle(&mut contacts, elements, &sites);
    bonds(&contacts, elements, &sites)
}

/// The open contacts that are left, as bonds.
fn bonds(contacts: &Contacts, elements: &[Element], sites: &Sites<'_>) -> Vec<Bond> {
    let is_ion = |atom: u32| sites.role(atom as usize) == Role::Ion && !elements[atom as usize].is_metal();
    let mut bonds = Vec::with_capacity(contacts.list().len());
    for atom in 0..contacts.atom_count() {
        let first = bonds.len();
        let open = contacts.of(atom).filter(|&(_, contact, other)| contact.state == State::Open && other > atom);
        for (_, contact, _) in open {
            let kind = if is_ion(contact.a) || is_ion(contact.b) {
                BondKind::Coordination
            } else {
                metal::kind(contacts, elements, sites, contact)
            };
            let order = if kind == BondKind::Coordination { BondOrder::Unknown } else { BondOrder::Single };
            bonds.push(Bond { kind, ..Bond::new(contact.a, contact.b, order, BondSource::Distance) });
        }
        bonds[first..].sort_unstable_by_key(|bond| bond.b);
    }
    bonds
}
