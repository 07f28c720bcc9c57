//! Orders of the bonds of oxo acids and their ions, and of ozone: small molecules without carbon, of which the statistics
//! know nothing.
//!
//! A sulfur, phosphorus, halogen or one of their heavier relatives, with oxygen or sulfur at its end, has as many electron
//! pairs in bonds as its group number allows, less its lone pair where it has one (Gillespie and Nyholm, Quart. Rev.
//! Chem. Soc. 1957, 11, 339: three neighbours in a plane leave none, a pyramid has one). What is left
//! beyond its single bonds goes to the shortest ends, one each: two double bonds in sulfate, one in phosphate and sulfite,
//! three in perchlorate, two in chlorate, none in phosphite and silicate. So Lewis formulas are written, equal lengths or not;
//! the other ends are O⁻, or OH where hydrogens are not listed.

use super::graph::{Graph, Neighbour};
use crate::element::Element;

/// Height of an atom over the plane of its three neighbours from which it is a pyramid, in ångström. Chosen halfway: sulfite
/// has 0.5 Å, sulfur trioxide 0.
const PYRAMID: f32 = 0.25;
/// Longest double bond in ozone (1.278 Å) and ozonides (1.35 Å; Klein et al., Z. Anorg. Allg. Chem. 1999, 625), single ones
/// have 1.46 Å. Chosen between.
const LONGEST_IN_OZONE: f32 = 1.40;

/// The bonds that the rules settle, with their orders. `is_open` says of which bonds the order is not known.
pub(super) fn find(graph: &Graph<'_>, is_open: &[bool]) -> Vec<(u32, u8)> {
    let mut found = Vec::new();
    let mut molecules = Molecules::default();
    for atom in 0..graph.atom_count() {
        let around = graph.around(atom);
        let may_be = around.len() >= 2 && is_center(graph.elements[atom]);
        if !may_be || !around.iter().any(|&next| is_end(graph, next)) || molecules.has_carbon(graph, atom) {
            continue;
        }
        if around.iter().any(|next| !is_open[next.bond as usize]) {
            continue;
        }
        let mut ends: Vec<Neighbour> = around.iter().copied().filter(|&next| is_end(graph, next)).collect();
        let length = |next: &Neighbour| graph.vector(atom, *next).length();
        let rank = |next: &Neighbour| {
            let other = next.atom as usize;
            (graph.elements[other] != Element::O, graph.held(other).metals > 0)
        };
        ends.sort_by(|one, other| {
            rank(one).cmp(&rank(other)).then(length(one).total_cmp(&length(other))).then(one.bond.cmp(&other.bond))
        });
        let doubles = extra_pairs(graph, atom, length(&ends[0]));
        ends.truncate(doubles);
        found.extend(around.iter().map(|next| {
            let is_double = ends.iter().any(|end| end.bond == next.bond);
            (next.bond, if is_double { 2 } else { 1 })
        }));
    }
    found
}

fn is_center(element: Element) -> bool {
    matches!(element.z(), 8 | 15..=17 | 33..=35 | 51..=53)
}

/// Whether a neighbour ends there and may have a double bond.
fn is_end(graph: &Graph<'_>, next: Neighbour) -> bool {
    let atom = next.atom as usize;
    let held = graph.held(atom);
    matches!(graph.elements[atom].z(), 8 | 16 | 34)
        && graph.degree(atom) == 1
        && held.hydrogens == 0
        && held.others == 0
}

/// Electron pairs beyond one a bond. `shortest` is the length to the nearest end.
fn extra_pairs(graph: &Graph<'_>, atom: usize, shortest: f32) -> usize {
    let around = graph.around(atom);
    let held = graph.held(atom);
    let element = graph.elements[atom];
    if element == Element::O {
        let is_ozone = around.len() == 2 && around.iter().all(|next| graph.elements[next.atom as usize] == Element::O);
        return usize::from(is_ozone && shortest <= LONGEST_IN_OZONE);
    }
    let bonds = around.len() + usize::from(held.hydrogens) + usize::from(held.others);
    let pairs = usize::from(element.group().saturating_sub(10));
    let lone = match (bonds, around) {
        (0..=2, _) => 1,
        (3, &[a, b, c]) => {
            let [a, b, c] = [a, b, c].map(|next| graph.vector(atom, next));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            usize::from(normal.dot(a).abs() >= PYRAMID)
        }
        // A hydrogen or a metal is one of the three: phosphinates have a fourth.
        (3, _) => 1,
        _ => 0,
    };
    // Halogens with two neighbours have two lone pairs: chlorite.
    let lone = if element.group() == 17 && bonds == 2 { 2 } else { lone };
    pairs.saturating_sub(2 * lone + bonds)
}

/// Which of the molecules that were asked for have carbon; each is walked once.
#[derive(Default)]
struct Molecules {
    is_seen: Vec<bool>,
    has_carbon: Vec<bool>,
}

impl Molecules {
    fn has_carbon(&mut self, graph: &Graph<'_>, atom: usize) -> bool {
        self.is_seen.resize(graph.atom_count(), false);
        self.has_carbon.resize(graph.atom_count(), false);
        if !self.is_seen[atom] {
            let atoms = super::connected(graph, atom, &mut self.is_seen);
            let has_carbon = atoms.iter().any(|&atom| graph.elements[atom as usize] == Element::C);
            for atom in atoms {
                self.has_carbon[atom as usize] = has_carbon;
            }
        }
        self.has_carbon[atom]
    }
}
