//! Formal charges from bonds and hydrogens.

use super::graph::{Graph, is_heavy};
use super::states;
use crate::element::Element;

/// Bonds of an uncharged atom of the elements that end groups are made of.
fn usual_valence(element: Element) -> usize {
    match element.z() {
        6 => 4,
        7 => 3,
        _ => 2,
    }
}

/// The formal charge of every atom that has one by its bonds.
///
/// Where hydrogens are not known, only charges that no hydrogen takes away: nitrogen with four bonds, oxygen with three,
/// and the atom beside such a one that ends the molecule with a bond too few (nitro groups, N-oxides, azides,
/// isocyanides, carbon monoxide). Carbon without its fourth bond has a charge only there and beside metals
/// (cyclopentadienide): elsewhere it may as well be a radical.
pub(super) fn find(graph: &Graph<'_>, order: &dyn Fn(u32) -> u8, is_known: &dyn Fn(usize) -> bool) -> Vec<(u32, i8)> {
    let mut charges = Vec::new();
    let valence = |atom: usize| {
        let held = graph.held(atom);
        let orders = graph.around(atom).iter().map(|neighbour| usize::from(order(neighbour.bond).max(1)));
        usize::from(held.hydrogens) + usize::from(held.others) + orders.sum::<usize>()
    };
    let of = |atom: usize| {
        let held = graph.held(atom);
        let bonds = usize::from(held.hydrogens) + usize::from(held.others) + graph.degree(atom);
        // An atom without any bond is an ion of unknown charge, or the oxygen of a water.
        if bonds == 0 {
            return 0;
        }
        let hydrogens = is_known(atom).then_some(held.hydrogens);
        let cost = states::cost(graph.elements[atom], valence(atom), bonds, hydrogens, held.metals > 0);
        let charge = cost.map_or(0, |(_, charge)| charge);
        if graph.elements[atom] == Element::C && held.metals == 0 { 0 } else { charge }
    };
    for atom in (0..graph.atom_count()).filter(|&atom| is_heavy(graph.elements[atom])) {
        let mut charge = of(atom);
        let element = graph.elements[atom];
        let may_end = charge == 0 && matches!(element.z(), 6..=8) && graph.held(atom).hydrogens == 0;
        if let ([only], true) = (graph.around(atom), may_end) {
            let beside = only.atom as usize;
            let is_positive = matches!(graph.elements[beside].z(), 7 | 8) && of(beside) == 1;
            let is_short = valence(atom) + 1 == usual_valence(element);
            charge = if is_positive && is_short { -1 } else { 0 };
        }
        if charge != 0 {
            charges.push((atom as u32, charge));
        }
    }
    charges
}
