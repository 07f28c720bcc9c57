//! Formal charges from bonds and hydrogens.
//!
//! # The rule
//!
//! An atom has the charge that its bonds leave it with by the octet rule, if it is known which hydrogens it has. It is
//!
//! - for all atoms of a molecule that lists hydrogens on carbon, and for those other than carbon where it lists polar ones;
//! - in a molecule that lists none, if nothing lacks any but oxygen, sulfur and selenium at its ends (sulfate,
//!   carbonate, nitrate, oxalate, permanganate): the list counts as complete, so that these are O⁻, but for
//!   ends that are longer than the shortest one beside them, as only OH is (the fourth oxygen of hydrogen sulfate);
//! - always where no hydrogen would take the charge away: nitrogen with four bonds, oxygen with three, the atom
//!   beside such a one that ends the molecule with a bond too few (nitro groups, N-oxides, azides, carbon monoxide).
//!
//! Of all other molecules without hydrogens (acetate, a protein's side chains) nothing is said: acid or anion, it is the
//! same to the eye.
//!
//! Carbon without its fourth bond has a charge at a lone pair's place (isocyanides, cyanide on a metal) and in rings
//! that are aromatic by it (Hückel): cyclopentadienide and indenide −1, tropylium and cyclopropenylium +1; elsewhere it
//! may as well be a radical. Boron in polyhedra and under bridging hydrogens has no charge, as its bonds have no two
//! electrons each; metals have none, as their ligands do not tell it.

use super::graph::{Graph, Neighbour, is_heavy};
use super::rings::Ring;
use super::states;
use crate::element::Element;

/// How much longer than the shortest end an end with a hydrogen is at least, in ångström. P–OH is 0.06–0.08 Å longer than
/// P–O⁻ (1.57, 1.51 and 1.49 Å), S–OH 0.12 Å, C–OH 0.10 Å (hydrogen carbonate); ends of one kind differ by 0.03 Å in crystals.
const LONGER_WITH_HYDROGEN: f32 = 0.05;
/// Degrees between two neighbours of a halogen from which it is linear, with three lone pairs: I₃⁻ and ICl₂⁻ have 180°,
/// iodonium 90–100°.
const LINEAR_HALOGEN_DEG: f32 = 150.0;
/// Degrees at the nitrogen of two oxygens from which they are nitrogen dioxide, a radical (134°), and not nitrite (115°).
const NITROGEN_DIOXIDE_DEG: f32 = 125.0;

/// Bonds of an uncharged atom of the elements that end groups are made of.
fn usual_valence(element: Element) -> usize {
    match element.z() {
        6 => 4,
        7 => 3,
        _ => 2,
    }
}

/// Electron pairs that an atom shares.
fn valence(graph: &Graph<'_>, order: &dyn Fn(u32) -> u8, atom: usize) -> usize {
    let held = graph.held(atom);
    let orders = graph.around(atom).iter().map(|neighbour| usize::from(order(neighbour.bond).max(1)));
    usize::from(held.hydrogens) + usize::from(held.others) + orders.sum::<usize>()
}

/// The formal charge of every atom that has one by its bonds. `rings` are those of carbons that are flat ([`is_flat_carbon`]), at
/// least.
pub(super) fn find(
    graph: &Graph<'_>,
    rings: &[Ring],
    order: &dyn Fn(u32) -> u8,
    is_known: &dyn Fn(usize) -> bool,
) -> Vec<(u32, i8)> {
    let shares = |atom: usize| valence(graph, order, atom);
    let without_pairs = electron_poor_borons(graph);
    let of = |atom: usize| {
        let held = graph.held(atom);
        let element = graph.elements[atom];
        let bonds = usize::from(held.hydrogens) + usize::from(held.others) + graph.degree(atom);
        // An atom without any bond is an ion of unknown charge, or the oxygen of a water.
        if bonds == 0 || without_pairs.binary_search(&(atom as u32)).is_ok() {
            return 0;
        }
        let hydrogens = (is_known(atom) || is_bare_on_metal(graph, atom)).then_some(held.hydrogens);
        let cost = states::cost(element, shares(atom), bonds, hydrogens, held.metals > 0);
        let charge = cost.map_or(0, |(_, charge)| charge);
        match element.z() {
            6 if !is_bare_on_metal(graph, atom) => 0,
            7 if is_nitrogen_dioxide(graph, atom) => 0,
            8 if is_of_nitrogen_dioxide(graph, atom) => 0,
            17 | 35 | 53 if charge > 0 && is_linear(graph, atom) => -1,
            // A bond to a metal may be the metal's gain, not this atom's loss.
            _ if held.others > 0 => charge.min(0),
            _ => charge,
        }
    };
    let mut charges = Vec::new();
    for atom in (0..graph.atom_count()).filter(|&atom| is_heavy(graph.elements[atom])) {
        let mut charge = of(atom);
        let element = graph.elements[atom];
        let may_end = charge == 0 && matches!(element.z(), 6..=8) && graph.held(atom).hydrogens == 0;
        if let ([only], true) = (graph.around(atom), may_end) {
            let beside = only.atom as usize;
            let is_positive = matches!(graph.elements[beside].z(), 7 | 8) && of(beside) == 1;
            let is_short = shares(atom) + 1 == usual_valence(element);
            charge = if is_positive && is_short && !is_hydroxide(graph, beside, *only, atom) { -1 } else { 0 };
        }
        if charge != 0 {
            charges.push((atom as u32, charge));
        }
    }
    let of_rings = ions_of_rings(graph, rings, order, is_known);
    if !of_rings.is_empty() {
        charges.retain(|(atom, _)| of_rings.binary_search_by_key(atom, |&(other, _)| other).is_err());
        charges.extend(of_rings);
        charges.sort_unstable();
    }
    charges
}

/// Marks as known the hydrogens of molecules that list none and look complete so, by the rule of this module.
pub(super) fn complete(graph: &Graph<'_>, order: &dyn Fn(u32) -> u8, known: &mut [bool]) {
    let mut is_seen = vec![false; graph.atom_count()];
    for start in (0..graph.atom_count()).filter(|&atom| is_heavy(graph.elements[atom])) {
        let held = graph.held(start);
        if is_seen[start] || graph.degree(start) + usize::from(held.others) == 0 {
            continue;
        }
        let atoms = super::connected(graph, start, &mut is_seen);
        let lacks_none = |&atom: &u32| {
            let atom = atom as usize;
            let held = graph.held(atom);
            let element = graph.elements[atom];
            let bonds = graph.degree(atom) + usize::from(held.others);
            let is_end = matches!(element.z(), 8 | 16 | 34) && bonds == 1;
            let charge = states::cost(element, valence(graph, order, atom), bonds, Some(0), held.metals > 0);
            let is_full = charge.is_none_or(|(_, charge)| charge >= 0) || is_linear(graph, atom);
            let is_carbon_short = element == Element::C && valence(graph, order, atom) < 4;
            held.hydrogens == 0 && (is_end || is_bare_on_metal(graph, atom) || is_full && !is_carbon_short)
        };
        if known[start] || !atoms.iter().all(lacks_none) {
            continue;
        }
        for &atom in &atoms {
            let is_oh = match graph.around(atom as usize) {
                &[only] => is_hydroxide(graph, only.atom as usize, only, atom as usize),
                _ => false,
            };
            known[atom as usize] = !is_oh;
        }
    }
}

/// Whether an end is so much longer than the shortest one beside it that it has a hydrogen. `bond` is its bond as it has it.
fn is_hydroxide(graph: &Graph<'_>, center: usize, bond: Neighbour, end: usize) -> bool {
    let length = graph.vector(end, bond).length();
    let is_like = |next: &&Neighbour| {
        graph.elements[next.atom as usize] == graph.elements[end] && graph.degree(next.atom as usize) == 1
    };
    let lengths = graph.around(center).iter().filter(is_like).map(|&next| graph.vector(center, next).length());
    graph.has_geometry() && length > lengths.fold(f32::INFINITY, f32::min) + LONGER_WITH_HYDROGEN
}

/// Whether an atom at an end has its lone pair on a metal, where no hydrogen can be: carbonyls, cyanides.
fn is_bare_on_metal(graph: &Graph<'_>, atom: usize) -> bool {
    let held = graph.held(atom);
    graph.elements[atom] == Element::C && held.metals > 0 && held.hydrogens == 0 && graph.degree(atom) == 1
}

fn angle_deg(graph: &Graph<'_>, atom: usize) -> Option<f32> {
    match *graph.around(atom) {
        [one, other] if graph.has_geometry() => {
            Some(graph.vector(atom, one).angle_between(graph.vector(atom, other)).to_degrees())
        }
        _ => None,
    }
}

/// Whether a halogen stands in line with two neighbours.
fn is_linear(graph: &Graph<'_>, atom: usize) -> bool {
    matches!(graph.elements[atom].z(), 17 | 35 | 53)
        && angle_deg(graph, atom).is_some_and(|angle| angle >= LINEAR_HALOGEN_DEG)
}

fn is_nitrogen_dioxide(graph: &Graph<'_>, atom: usize) -> bool {
    let held = graph.held(atom);
    held.hydrogens + held.metals + held.others == 0
        && graph.degree(atom) == 2
        && graph.around(atom).iter().all(|next| is_end_oxygen(graph, next.atom as usize))
        && angle_deg(graph, atom).is_some_and(|angle| (NITROGEN_DIOXIDE_DEG..LINEAR_HALOGEN_DEG).contains(&angle))
}

fn is_end_oxygen(graph: &Graph<'_>, atom: usize) -> bool {
    graph.elements[atom] == Element::O && graph.degree(atom) == 1
}

fn is_of_nitrogen_dioxide(graph: &Graph<'_>, atom: usize) -> bool {
    match *graph.around(atom) {
        [only] => graph.elements[only.atom as usize] == Element::N && is_nitrogen_dioxide(graph, only.atom as usize),
        _ => false,
    }
}

/// The borons of polyhedra and under bridging hydrogens, ascending.
fn electron_poor_borons(graph: &Graph<'_>) -> Vec<u32> {
    let is_boron = |atom: usize| graph.elements[atom] == Element::B;
    if !graph.elements.contains(&Element::B) {
        return Vec::new();
    }
    let mut bonds_of_hydrogen = std::collections::HashMap::new();
    let ends = || {
        let bonds = graph.bonds().iter().map(|bond| [bond.a, bond.b]);
        bonds.flat_map(|[a, b]| [(a, b), (b, a)]).filter(|&(hydrogen, boron)| {
            graph.elements.get(hydrogen as usize) == Some(&Element::H)
                && graph.elements.get(boron as usize) == Some(&Element::B)
        })
    };
    for (hydrogen, _) in ends() {
        *bonds_of_hydrogen.entry(hydrogen).or_insert(0u32) += 1;
    }
    let bridged = ends().filter(|(hydrogen, _)| bonds_of_hydrogen[hydrogen] > 1).map(|(_, boron)| boron);
    let borons = (0..graph.atom_count()).filter(|&atom| is_boron(atom));
    let in_cages =
        borons.filter(|&atom| graph.around(atom).iter().filter(|next| is_boron(next.atom as usize)).count() > 1);
    let mut poor: Vec<u32> = bridged.chain(in_cages.map(|atom| atom as u32)).collect();
    poor.sort_unstable();
    poor.dedup();
    poor
}

/// Whether there may be a ring that is aromatic by a charge: a carbon with three partners and without a double bond.
pub(super) fn may_have_ions_of_rings(
    graph: &Graph<'_>,
    order: &dyn Fn(u32) -> u8,
    is_known: &dyn Fn(usize) -> bool,
) -> bool {
    let may_be = |atom: usize| {
        let held = graph.held(atom);
        is_flat_carbon(graph, atom)
            && is_bare(graph, order, atom)
            && (held.metals > 0 || is_known(atom) && graph.degree(atom) + usize::from(held.hydrogens) == 3)
    };
    (0..graph.atom_count()).any(may_be)
}

/// Whether an atom is a carbon that may be in such a ring.
pub(super) fn is_flat_carbon(graph: &Graph<'_>, atom: usize) -> bool {
    let held = graph.held(atom);
    graph.elements[atom] == Element::C
        && held.others == 0
        && (2..=3).contains(&(graph.degree(atom) + usize::from(held.hydrogens)))
}

/// Whether no bond of an atom is more than single.
fn is_bare(graph: &Graph<'_>, order: &dyn Fn(u32) -> u8, atom: usize) -> bool {
    graph.around(atom).iter().all(|next| order(next.bond) <= 1)
}

/// The one carbon without a double bond of each ring that a charge on it makes aromatic.
fn ions_of_rings(
    graph: &Graph<'_>,
    rings: &[Ring],
    order: &dyn Fn(u32) -> u8,
    is_known: &dyn Fn(usize) -> bool,
) -> Vec<(u32, i8)> {
    let mut charges: Vec<(u32, i8)> = Vec::new();
    for ring in rings {
        let atoms = || ring.atoms.iter().map(|&atom| atom as usize);
        if !atoms().all(|atom| is_flat_carbon(graph, atom)) {
            continue;
        }
        let mut bare = atoms().filter(|&atom| is_bare(graph, order, atom));
        let (Some(ion), None) = (bare.next(), bare.next()) else { continue };
        // Not listed hydrogens leave open whether it has one or two; a metal that holds the whole ring does not.
        let is_on_metal = atoms().all(|atom| graph.held(atom).metals > 0);
        let held = graph.held(ion);
        let is_short = graph.degree(ion) + usize::from(held.hydrogens) == 3 && is_known(ion);
        if !(is_short || is_on_metal && held.hydrogens == 0) {
            continue;
        }
        let has_double_in_rings = |atom: usize| {
            graph.around(atom).iter().any(|next| order(next.bond) == 2 && is_flat_carbon(graph, next.atom as usize))
        };
        if !atoms().filter(|&atom| atom != ion).all(has_double_in_rings) {
            continue;
        }
        // Every other atom gives one electron; the ion two or none.
        let charge = match ring.len() % 4 {
            1 => -1,
            3 => 1,
            _ => continue,
        };
        charges.push((ion as u32, charge));
    }
    // An atom of several such rings: the first, as they are sorted by size.
    charges.sort_by_key(|&(atom, _)| atom);
    charges.dedup_by_key(|&mut (atom, _)| atom);
    charges
}
