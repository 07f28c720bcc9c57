//! Bond orders, formal charges and aromaticity from coordinates alone.
//!
//! # Method
//!
//! Which atoms are bonded is known here; how many electron pairs each bond has is chosen, for all atoms that depend on
//! each other at once:
//!
//! 1. Atoms whose neighbours and hydrogens use up all their electrons are settled; where no two neighbours are left that
//!    could share a further pair (water, alkanes) nothing more is done. Bonds too long for a second pair are single.
//! 2. Every other atom has a few states: which of its bonds have one or two extra pairs (`states`). A state has a
//!    cost by the charge it implies. Where the hydrogens of a molecule are listed (any carbon has one), valences count
//!    exactly; where only polar ones are, those of carbon are unknown; where none are, free valences are hydrogens.
//! 3. Lengths speak by how far they are from sums of Pyykkö's radii (`lengths`). Beyond these physical terms,
//!    statistics (`features`, `model`) correct each state by element, neighbours, rings, angles and height over the plane,
//!    and each pair of neighbouring states by length and twist.
//! 4. The best sum is found exactly by eliminating atom after atom; in sheets and cages, where that would take too long,
//!    nearly so, in time and memory proportional to the atoms (`solve`).
//! 5. Oxo acids, ozone and the like, without carbon, have the orders of their Lewis formulas (`inorganic`); two atoms alone
//!    those of their length.
//! 6. Aromatic are rings and fused systems by Hückel's rule on the result, as RDKit counts (`aromatic`). Nitro groups are
//!    N⁺–O⁻, phosphates have one P=O and sulfones two S=O, as the component dictionary writes them.
//!
//! # Sources and figures
//!
//! The weights were fitted to the ideal coordinates of the wwPDB Chemical Component Dictionary (CC0): 35,900 components
//! without metals, with all hydrogens, none and polar ones, moved anew by normal noise of mostly 0.03 Å each time; a
//! structured perceptron with margin 1, averaged over five passes; weights below 0.1 left out. Of 5,000 other components
//! that neither the fit nor any choice has seen, moved by 0.03 Å, connectivity is right in 99.82 % with hydrogens and
//! 99.82 % without; orders, compared after RDKit's aromaticity and up to symmetry, in 99.48 % and 97.06 %.
//! What is wrong without hydrogens is mostly what only hydrogens tell: which nitrogen of an azole or amidine has one, enol
//! or ketone in a conjugated system, imine or amine.
//!
//! # Limits
//!
//! Ties between equal forms (the two of benzene) are broken by the last digits of the positions. Alternate locations
//! count as neighbours at once, and atoms with too many of them get single bonds. Radicals are not looked for.

mod aromatic;
mod charges;
mod component;
mod features;
mod graph;
mod inorganic;
mod kekulise;
mod lengths;
mod model;
mod rings;
mod sites;
mod solve;
mod states;

#[cfg(test)]
mod tests;

use super::parts;
use crate::element::Element;
use crate::stop::Stop;
use crate::structure::{Bond, BondKind, BondOrder, BondSource, Cell, Structure};
use component::{Finder, Setup};
use glam::Vec3;
use graph::Graph;
use model::MODEL;
use rayon::prelude::*;
use std::ops::Range;

pub(super) use kekulise::kekulise;
pub(crate) use rings::Ring;

/// Gives an order to every covalent bond of heavy nonmetals that has none yet: those found by distance, and those of a
/// partial list of the file that says nothing but which atoms are bonded. Marks the aromatic ones among these. If it is given up, some have none.
pub(super) fn perceive(elements: &[Element], positions: &[Vec3], cell: Option<&Cell>, bonds: &mut [Bond], stop: &Stop) {
    if positions.len() != elements.len() {
        return;
    }
    // No bond's order depends on another molecule's.
    let mut rest = &mut *bonds;
    let mut tasks = Vec::new();
    for (atoms, own) in parts::of_bonds(elements.len(), rest) {
        let (head, tail) = rest.split_at_mut(own.len());
        tasks.push((atoms, head));
        rest = tail;
    }
    tasks.into_par_iter().with_max_len(1).for_each(|(atoms, bonds)| {
        let first = atoms.start as u32; // a structure has fewer than 2^32 atoms
        bonds.iter_mut().for_each(|bond| *bond = parts::renumbered(*bond, |atom| atom - first));
        perceive_part(&elements[atoms.clone()], &positions[atoms], cell, bonds, stop);
        bonds.iter_mut().for_each(|bond| *bond = parts::renumbered(*bond, |atom| atom + first));
    });
}

/// The same for what nothing joins to the rest.
fn perceive_part(elements: &[Element], positions: &[Vec3], cell: Option<&Cell>, bonds: &mut [Bond], stop: &Stop) {
    if stop.is_set() {
        return;
    }
    let mut is_open = open_bonds(elements, bonds);
    if !is_open.contains(&true) {
        return;
    }
    let graph = Graph::new(elements, positions, bonds, cell);
    let by_rule = inorganic::find(&graph, &is_open);
    let graph = if by_rule.is_empty() {
        graph
    } else {
        for (bond, order) in by_rule {
            bonds[bond as usize].order = BondOrder::from_number(u32::from(order));
            is_open[bond as usize] = false;
        }
        Graph::new(elements, positions, bonds, cell)
    };
    let Found { orders, aromatic } = by_model(graph, &is_open, stop).unwrap_or_default();
    for (bond, order) in orders {
        bonds[bond as usize].order = BondOrder::from_number(u32::from(order));
    }
    for bond in aromatic {
        let bond_of = &mut bonds[bond as usize];
        bond_of.aromatic |= is_open[bond as usize];
    }
    // What no double bond has reached is single.
    for (bond, _) in bonds.iter_mut().zip(&is_open).filter(|(bond, open)| **open && bond.order == BondOrder::Unknown) {
        bond.order = BondOrder::Single;
    }
}

/// What the model says of bonds.
#[derive(Default)]
struct Found {
    /// Bond and order.
    orders: Vec<(u32, u8)>,
    aromatic: Vec<u32>,
}

/// What the model says of the open bonds; `None` where no bond may be more than single, or if it is given up.
fn by_model(graph: Graph<'_>, is_open: &[bool], stop: &Stop) -> Option<Found> {
    let reach = reach(&graph, is_open)?;
    let rings = rings::find(&graph, |atom| reach[atom], rings::LARGEST_RING, stop);
    if stop.is_set() {
        return None;
    }
    let known = hydrogens_known(&graph, &reach);
    let setup = Setup::new(graph, &rings, &|atom| known[atom], &|bond| is_open[bond]);
    let orders = best_orders(&setup, stop);
    if stop.is_set() {
        return None;
    }
    let aromatic = aromatic_bonds(&setup.graph, &rings, &orders, &|atom| known[atom]);
    Some(Found { orders, aromatic })
}

/// The bonds whose orders are to be found.
fn open_bonds(elements: &[Element], bonds: &[Bond]) -> Vec<bool> {
    let is_covalent = |bond: &Bond| {
        let heavy = |atom: u32| elements.get(atom as usize).is_some_and(|&element| graph::is_heavy(element));
        bond.kind == BondKind::Covalent && heavy(bond.a) && heavy(bond.b)
    };
    let mut is_open: Vec<bool> = bonds
        .iter()
        .map(|bond| is_covalent(bond) && matches!(bond.source, BondSource::Distance | BondSource::File))
        .collect();
    // CONECT is a list of neighbours. Only where it repeats a bond, in the same molecule, does it speak of orders.
    let says_more = |bond: &Bond| bond.source == BondSource::File && (bond.order > BondOrder::Single || bond.aromatic);
    if bonds.iter().any(says_more) {
        let graph = Graph::new(elements, &[], bonds, None);
        let speaks: Vec<bool> = bonds.iter().map(says_more).collect();
        for atoms in molecules(&graph) {
            let of = |atom: &u32| graph.around(*atom as usize).iter().map(|neighbour| neighbour.bond as usize);
            if atoms.iter().flat_map(of).any(|bond| speaks[bond]) {
                for bond in atoms.iter().flat_map(of) {
                    is_open[bond] &= bonds[bond].source != BondSource::File;
                }
            }
        }
    }
    is_open
}

/// The atoms of each connected part of the graph.
fn molecules(graph: &Graph<'_>) -> Vec<Vec<u32>> {
    let mut is_seen = vec![false; graph.atom_count()];
    let starts = 0..graph.atom_count();
    starts
        .filter_map(|start| {
            (graph.degree(start) > 0).then(|| connected(graph, start, &mut is_seen)).filter(|atoms| !atoms.is_empty())
        })
        .collect()
}

/// The atoms connected with one that were not seen before.
fn connected(graph: &Graph<'_>, start: usize, is_seen: &mut [bool]) -> Vec<u32> {
    if std::mem::replace(&mut is_seen[start], true) {
        return Vec::new();
    }
    let mut atoms = vec![start as u32];
    let mut at = 0;
    while let Some(&atom) = atoms.get(at) {
        at += 1;
        for neighbour in graph.around(atom as usize) {
            if !std::mem::replace(&mut is_seen[neighbour.atom as usize], true) {
                atoms.push(neighbour.atom);
            }
        }
    }
    atoms
}

/// The atoms of the molecules in which any bond may be more than single; `None` if there is no such bond: water, alkanes.
fn reach(graph: &Graph<'_>, is_open: &[bool]) -> Option<Vec<bool>> {
    let may_be_more = |atom: usize| {
        let held = graph.held(atom);
        let taken = usize::from(held.hydrogens) + usize::from(held.others);
        graph.degree(atom) > 0 && states::most_extra(graph.elements[atom], graph.degree(atom), taken, false) > 0
    };
    let mut reach = vec![false; graph.atom_count()];
    let mut any = false;
    for (bond, _) in graph.bonds().iter().zip(is_open).filter(|(_, open)| **open) {
        let (a, b) = (bond.a as usize, bond.b as usize);
        if !reach[a] && may_be_more(a) && may_be_more(b) {
            any = true;
            connected(graph, a, &mut reach);
        }
    }
    any.then_some(reach)
}

/// The order of every bond in reach, by the model.
fn best_orders(setup: &Setup<'_>, stop: &Stop) -> Vec<(u32, u8)> {
    let components = (0..setup.component_count()).into_par_iter().with_min_len(8);
    let found = components.fold(
        || Finder::new(setup),
        |mut finder, component| {
            if !stop.is_set() {
                finder.add_best(component, &*MODEL);
            }
            finder
        },
    );
    // Every bond is in one component: their order does not matter.
    found.map(|finder| finder.orders).collect::<Vec<_>>().concat()
}

/// The aromatic bonds with these orders; the others have the order that they state.
fn aromatic_bonds(
    graph: &Graph<'_>,
    rings: &[rings::Ring],
    orders: &[(u32, u8)],
    hydrogens_known: &(dyn Fn(usize) -> bool + Sync),
) -> Vec<u32> {
    if rings.is_empty() {
        return Vec::new();
    }
    let mut order_of: Vec<u8> = graph.bonds().iter().map(|bond| bond.order.number()).collect();
    for &(bond, order) in orders {
        order_of[bond as usize] = order;
    }
    let order = |bond: u32| order_of[bond as usize];
    let mut charge_of = vec![0i8; graph.atom_count()];
    for (atom, charge) in charges::find(graph, rings, &order, &hydrogens_known) {
        charge_of[atom as usize] = charge;
    }
    let orders =
        aromatic::Orders { order: &order, charge: &|atom| charge_of[atom], fills_up: &|atom| !hydrogens_known(atom) };
    aromatic::find(graph, rings, &orders).concat()
}

/// The formal charges that follow from the bonds, where the structure states none: atom and charge. If it is given up, some are missing.
pub(super) fn charges(structure: &Structure, bonds: &[Bond], stop: &Stop) -> Vec<(u32, i8)> {
    let (elements, positions) = (structure.elements(), structure.positions().relative());
    let lattice = structure.lattice(0);
    let of_part = |(atoms, own): (Range<usize>, Range<usize>)| {
        let first = atoms.start as u32; // a structure has fewer than 2^32 atoms
        let own = bonds[own].iter().map(|&bond| parts::renumbered(bond, |atom| atom - first)).collect::<Vec<_>>();
        let found = match stop.is_set() {
            true => Vec::new(),
            false => charges_of_part(&elements[atoms.clone()], &positions[atoms], lattice, &own, stop),
        };
        found.into_iter().map(|(atom, charge)| (atom + first, charge)).collect::<Vec<_>>()
    };
    parts::of_bonds(elements.len(), bonds).into_par_iter().with_max_len(1).map(of_part).collect::<Vec<_>>().concat()
}

fn charges_of_part(
    elements: &[Element],
    positions: &[Vec3],
    lattice: Option<&Cell>,
    bonds: &[Bond],
    stop: &Stop,
) -> Vec<(u32, i8)> {
    let graph = Graph::new(elements, positions, bonds, lattice);
    let mut known = hydrogens_known(&graph, &vec![true; graph.atom_count()]);
    let order = |bond: u32| bonds[bond as usize].order.number();
    charges::complete(&graph, &order, &mut known);
    let rings = match charges::may_have_ions_of_rings(&graph, &order, &|atom| known[atom]) {
        true => rings::find(&graph, |atom| charges::is_flat_carbon(&graph, atom), rings::LARGEST_RING, stop),
        false => Vec::new(),
    };
    charges::find(&graph, &rings, &order, &|atom| known[atom])
}

/// The bonds (by index into `bonds`) of every aromatic ring of a structure, found by the bonds' orders alone: what a file
/// that is written in Kekulé form does not say. Fused rings that are aromatic only together count as one. Nothing is
/// altered.
///
/// `bonds` are those of `structure`, or others between its atoms.
#[must_use]
pub fn aromatic_rings(structure: &Structure, bonds: &[Bond]) -> Vec<Vec<u32>> {
    let graph = Graph::new(structure.elements(), &[], bonds, None);
    let rings = rings::find(&graph, |_| true, rings::LARGEST_RING, &Stop::never());
    let known = hydrogens_known(&graph, &vec![true; graph.atom_count()]);
    let orders = aromatic::Orders {
        order: &|bond| bonds[bond as usize].order.number(),
        charge: &|atom| structure.formal_charge(atom),
        fills_up: &|atom| !known[atom],
    };
    aromatic::find(&graph, &rings, &orders)
}

/// The shortest rings through each of these bonds, up to `largest` atoms, each once: bonds (by index into `bonds`) and atoms in
/// order. Rings with hydrogens or metals are none. Linear in the number of atoms.
pub(crate) fn small_rings(structure: &Structure, bonds: &[Bond], largest: usize) -> Vec<Ring> {
    rings::find(&Graph::new(structure.elements(), &[], bonds, None), |_| true, largest, &Stop::never())
}

/// For each atom of the graph's marked molecules whether its hydrogens are in the structure.
///
/// They are where any carbon of the same molecule has one. Where only other atoms have (polar hydrogens), these are
/// known and those of carbon are not; where no atom has, none is known.
fn hydrogens_known(graph: &Graph<'_>, marked: &[bool]) -> Vec<bool> {
    let count = graph.atom_count();
    let mut known = vec![false; count];
    let mut is_seen = vec![false; count];
    for start in (0..count).filter(|&start| marked[start] && graph::is_heavy(graph.elements[start])) {
        if graph.degree(start) == 0 {
            known[start] = graph.held(start).hydrogens > 0;
            continue;
        }
        let atoms = connected(graph, start, &mut is_seen);
        let has = |of_carbon: bool| {
            let is_one = |atom: &u32| {
                graph.held(*atom as usize).hydrogens > 0 && (graph.elements[*atom as usize] == Element::C) == of_carbon
            };
            atoms.iter().any(is_one)
        };
        let (on_carbon, on_others) = (has(true), has(false));
        for &atom in &atoms {
            let is_carbon = graph.elements[atom as usize] == Element::C;
            known[atom as usize] = on_carbon || (on_others && !is_carbon);
        }
    }
    known
}
