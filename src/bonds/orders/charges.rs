//! Formal charges from bonds.

use super::graph::{Graph, is_heavy};
use super::states;
use crate::element::Element;

/// The formal charge of every atom that has one by its bonds. Where hydrogens are not known, only charges that no hydrogen
/// could take away: four bonds of nitrogen, three of oxygen, and the oxide on such a nitrogen.
pub(super) fn find(graph: &Graph<'_>, order: &dyn Fn(u32) -> u8, is_known: &dyn Fn(usize) -> bool) -> Vec<(u32, i8)> {
    let mut charges = Vec::new();
    let of = |atom: usize, known: bool| {
        let held = graph.held(atom);
        let single = usize::from(held.hydrogens) + usize::from(held.others);
        let valence = single + graph.around(atom).iter().map(|neighbour| usize::from(order(neighbour.bond).max(1))).sum::<usize>();
        let bonds = single + graph.degree(atom);
        // An atom without any bond is an ion of unknown charge, or a solvent oxygen.
        if bonds == 0 {
            return 0;
        }
        let hydrogens = known.then_some(held.hydrogens);
        states::cost(graph.elements[atom], valence, bonds, hydrogens, held.metals > 0).map_or(0, |(_, charge)| charge)
    };
    for atom in (0..graph.atom_count()).filter(|&atom| is_heavy(graph.elements[atom])) {
        let mut charge = of(atom, is_known(atom));
        if charge == 0 && !is_known(atom) && graph.elements[atom] == Element::O && graph.held(atom).hydrogens == 0 {
            if let [only] = graph.around(atom) {
                let nitrogen = only.atom as usize;
                let is_oxide = order(only.bond) == 1 && graph.elements[nitrogen] == Element::N && of(nitrogen, false) == 1;
                let is_free = graph.around(nitrogen).iter().any(|beside| order(beside.bond) > 1) || graph.degree(nitrogen) == 4;
                charge = if is_oxide && is_free { -1 } else { 0 };
            }
        }
        if charge != 0 {
            charges.push((atom as u32, charge));
        }
    }
    charges
}
