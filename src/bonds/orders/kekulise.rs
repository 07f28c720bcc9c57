//! Kekulé forms for bonds that a file calls aromatic without an order (SDF type 4, MOL2 `ar`).
//!
//! Only valences count, not the geometry, which may be a drawing's: as many atoms as can have one double bond among their
//! aromatic bonds get one, so that stated charges, hydrogens and the orders of the other bonds fit. This covers what
//! MOL2 calls aromatic beside rings: carboxylates, guanidinium, phosphates. What cannot be matched stays single.

use super::graph::Graph;
use super::sites::{RingKinds, UNKNOWN};
use super::solve::{Problem, Solver};
use super::states::{self, MOST_NEIGHBOURS, State};
use crate::element::Element;
use crate::structure::{Bond, BondOrder, Structure};

/// For a carbon without a double bond: there is nearly always one.
const BARE_CARBON: f32 = 12.0;
/// For a charge other than the stated one. Where a file states none, nitrogen and oxygen still may have one: pyridinium
/// without its charge is more usual than a carbon without its double bond.
const WRONG_CHARGE: f32 = 5.0;
/// For each atom with a double bond, so that more is better where all else is equal.
const DOUBLE: f32 = -0.25;

/// Gives aromatic bonds of unknown order one of a Kekulé form. All other bonds stay as they are.
pub(in super::super) fn kekulise(structure: &Structure, bonds: &mut [Bond]) {
    let is_open = |bond: &Bond| bond.aromatic && bond.order == BondOrder::Unknown;
    if !bonds.iter().any(is_open) {
        return;
    }
    let orders = orders(structure, bonds, &|bond| is_open(&bonds[bond as usize]));
    for (bond, order) in orders {
        bonds[bond as usize].order = BondOrder::from_number(u32::from(order));
    }
}

fn orders(structure: &Structure, bonds: &[Bond], is_open: &dyn Fn(u32) -> bool) -> Vec<(u32, u8)> {
    let graph = Graph::new(structure.elements(), &[], bonds, None);
    let kinds = RingKinds::new(&graph, &[]);
    let known = super::hydrogens_known(&graph, &vec![true; graph.atom_count()]);
    let mut is_seen = vec![false; graph.atom_count()];
    let mut orders = Vec::new();
    let (mut problem, mut solver) = (Problem::default(), Solver::default());
    for start in 0..graph.atom_count() {
        let mut atoms = vec![start as u32];
        if std::mem::replace(&mut is_seen[start], true) || !graph.around(start).iter().any(|next| is_open(next.bond)) {
            continue;
        }
        let mut at = 0;
        while let Some(&atom) = atoms.get(at) {
            at += 1;
            for next in graph.around(atom as usize).iter().filter(|next| is_open(next.bond)) {
                if !std::mem::replace(&mut is_seen[next.atom as usize], true) {
                    atoms.push(next.atom);
                }
            }
        }
        problem.clear();
        let mut all: Vec<Vec<State>> = Vec::new();
        for &atom in &atoms {
            let atom = atom as usize;
            let (states, scores) = choices(&graph, &kinds, structure, atom, known[atom], is_open);
            all.push(states);
            problem.push_variable(scores);
        }
        let place: std::collections::HashMap<u32, usize> =
            atoms.iter().enumerate().map(|(place, &atom)| (atom, place)).collect();
        let mut edges = Vec::new();
        for (here, &atom) in atoms.iter().enumerate() {
            for (slot, next) in graph.around(atom as usize).iter().enumerate().filter(|(_, next)| is_open(next.bond)) {
                let Some(&there) = place.get(&next.atom).filter(|&&there| there > here) else { continue };
                let back = graph.around(next.atom as usize).iter().position(|back| back.bond == next.bond).unwrap_or(0);
                let extra = |state: &State, slot: usize| if slot < MOST_NEIGHBOURS { state.extra(slot) } else { 0 };
                let pairs = all[here].iter().flat_map(|one| all[there].iter().map(move |other| (one, other)));
                let fits = pairs
                    .map(|(one, other)| if extra(one, slot) == extra(other, back) { 0.0 } else { f32::NEG_INFINITY });
                problem.push_pair(here as u32, there as u32);
                problem.push_scores(fits);
                edges.push((next.bond, here, slot));
            }
        }
        let chosen = solver.solve(&problem);
        orders.extend(edges.into_iter().map(|(bond, here, slot)| {
            let state = all[here][usize::from(chosen[here])];
            (bond, 1 + if slot < MOST_NEIGHBOURS { state.extra(slot) } else { 0 })
        }));
    }
    orders
}

/// The states of an atom with their scores.
fn choices(
    graph: &Graph<'_>,
    kinds: &RingKinds,
    structure: &Structure,
    atom: usize,
    is_known: bool,
    is_open: &dyn Fn(u32) -> bool,
) -> (Vec<State>, Vec<f32>) {
    let around = graph.around(atom);
    let element = graph.elements[atom];
    let fixed = |order: BondOrder| usize::from(order.number().saturating_sub(1));
    let fixed_extra: usize = around.iter().map(|next| fixed(graph.bonds()[next.bond as usize].order)).sum();
    let hydrogens = if is_known { graph.held(atom).hydrogens } else { UNKNOWN };
    let allowed = |slot: usize| u8::from(is_open(around[slot].bond));
    let mut found = Vec::new();
    states::states(graph, kinds, atom, hydrogens, fixed_extra, f32::INFINITY, allowed, &mut found);
    // Only the heavier elements have two double bonds in such groups: sulfonates, perchlorate.
    found.retain(|(state, _)| state.sum() <= 1 || element.period() > 2);
    let stated = structure.formal_charge(atom);
    let score = |&(state, cost): &(State, f32)| {
        let mut cost = cost;
        if stated != 0 {
            // The charge is known: it costs nothing, all others do.
            cost = if state.charge == stated { 0.0 } else { WRONG_CHARGE };
        }
        if element == Element::C && state.sum() == 0 && fixed_extra == 0 && stated == 0 {
            cost += BARE_CARBON;
        }
        -cost - if state.sum() > 0 { DOUBLE } else { 0.0 }
    };
    let scores = found.iter().map(score).collect();
    (found.into_iter().map(|(state, _)| state).collect(), scores)
}
