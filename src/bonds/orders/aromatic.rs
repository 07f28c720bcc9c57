//! Aromatic rings by Hückel's rule, in the manner of RDKit's default model (rdkit.org, The RDKit Book, "Aromaticity").
//!
//! Every atom of a ring gives electrons: one where it has a double bond in a ring, two where it has a lone pair beside
//! single bonds only, none where its double bond leads out of the rings to a more electronegative atom, or where it has
//! an empty orbital (boron, carbocation). A ring, or the outline of fused rings, with 4n + 2 electrons is aromatic.
//! Kekulé form and hydrogens decide; the geometry has no word here.
//!
//! Limits: rings of three to eight atoms, outlines of up to six rings and 24 atoms. Larger rings (the inner ring of
//! porphin) are not looked at: of porphin the pyrroles with three double bonds' worth of electrons are aromatic.

use super::graph::Graph;
use super::rings::Ring;

/// Rings in an outline.
const MOST_FUSED: usize = 6;
/// Atoms of an outline.
const LARGEST_OUTLINE: usize = 24;
/// Outlines tried in one fused system: a bound on the work, which no drug-like system reaches.
const MOST_OUTLINES: usize = 2_000;

/// What the rule needs to know beside the graph.
pub(super) struct Orders<'o> {
    /// Order of each bond by index, 0 where it is not known.
    pub(super) order: &'o (dyn Fn(u32) -> u8 + Sync),
    /// Formal charge of an atom.
    pub(super) charge: &'o (dyn Fn(usize) -> i8 + Sync),
    /// Whether free valences of an atom are hydrogens that are not listed.
    pub(super) fills_up: &'o (dyn Fn(usize) -> bool + Sync),
}

/// The bonds (by index) of each aromatic ring or outline.
pub(super) fn find(graph: &Graph<'_>, rings: &[Ring], orders: &Orders<'_>) -> Vec<Vec<u32>> {
    let mut in_ring = vec![false; graph.bonds().len()];
    for &bond in rings.iter().flat_map(|ring| &ring.bonds) {
        in_ring[bond as usize] = true;
    }
    let gives = |atom: u32| electrons(graph, orders, &in_ring, atom as usize);
    let candidates: Vec<&Ring> =
        rings.iter().filter(|ring| ring.atoms.iter().all(|&atom| gives(atom).is_some())).collect();
    let count = |atoms: &[u32]| atoms.iter().filter_map(|&atom| gives(atom)).map(u32::from).sum::<u32>();
    let mut found: Vec<Vec<u32>> = Vec::new();
    let mut is_aromatic = vec![false; candidates.len()];
    // Of lone pairs alone nothing is shared: P₃, S₃, As₅ are chains of single bonds.
    let is_conjugated = |atoms: &[u32]| atoms.iter().any(|&atom| gives(atom) != Some(2));
    for (ring, is_aromatic) in candidates.iter().zip(&mut is_aromatic) {
        if count(&ring.atoms) % 4 == 2 && is_conjugated(&ring.atoms) {
            *is_aromatic = true;
            found.push(ring.bonds.clone());
        }
    }
    if is_aromatic.iter().all(|&is| is) {
        return found;
    }
    let beside = neighbours(&candidates);
    let mut done = vec![false; graph.bonds().len()];
    for &bond in found.iter().flatten() {
        done[bond as usize] = true;
    }
    for start in (0..candidates.len()).filter(|&ring| !is_aromatic[ring]) {
        if candidates[start].bonds.iter().all(|&bond| done[bond as usize]) {
            continue;
        }
        if let Some(outline) = outline_through(start, &candidates, &beside, &|outline| {
            let mut atoms: Vec<u32> = outline.iter().flat_map(|&bond| ends(graph, bond)).collect();
            atoms.sort_unstable();
            atoms.dedup();
            atoms.len() <= LARGEST_OUTLINE && count(&atoms) % 4 == 2 && is_conjugated(&atoms)
        }) {
            for &bond in &outline {
                done[bond as usize] = true;
            }
            // The other rings of an outline find it again.
            if !found.contains(&outline) {
                found.push(outline);
            }
        }
    }
    found
}

fn ends(graph: &Graph<'_>, bond: u32) -> [u32; 2] {
    let bond = &graph.bonds()[bond as usize];
    [bond.a, bond.b]
}

/// For each ring those that share a bond with it.
fn neighbours(rings: &[&Ring]) -> Vec<Vec<usize>> {
    let mut of_bond: std::collections::HashMap<u32, Vec<usize>> = std::collections::HashMap::new();
    for (index, ring) in rings.iter().enumerate() {
        for &bond in &ring.bonds {
            of_bond.entry(bond).or_default().push(index);
        }
    }
    let beside = |(index, ring): (usize, &&Ring)| {
        let mut others: Vec<usize> = ring
            .bonds
            .iter()
            .filter_map(|bond| of_bond.get(bond))
            .flatten()
            .copied()
            .filter(|&other| other != index)
            .collect();
        others.sort_unstable();
        others.dedup();
        others
    };
    rings.iter().enumerate().map(beside).collect()
}

/// The bonds that only one of a growing set of fused rings has: the smallest set about `start` that `fits`.
fn outline_through(
    start: usize,
    rings: &[&Ring],
    beside: &[Vec<usize>],
    fits: &dyn Fn(&[u32]) -> bool,
) -> Option<Vec<u32>> {
    let mut sets: Vec<Vec<usize>> = vec![vec![start]];
    let mut tried = 0;
    for _ in 1..MOST_FUSED {
        let mut larger: Vec<Vec<usize>> = Vec::new();
        for set in &sets {
            for &next in set.iter().flat_map(|&ring| &beside[ring]) {
                if set.contains(&next) {
                    continue;
                }
                let mut with = set.clone();
                with.push(next);
                with.sort_unstable();
                if larger.contains(&with) {
                    continue;
                }
                tried += 1;
                if tried > MOST_OUTLINES {
                    return None;
                }
                let mut bonds: Vec<u32> = with.iter().flat_map(|&ring| rings[ring].bonds.iter().copied()).collect();
                bonds.sort_unstable();
                let once = |&bond: &u32| {
                    bonds.binary_search(&bond).is_ok() && bonds.iter().filter(|&&other| other == bond).count() == 1
                };
                let outline: Vec<u32> = bonds.iter().copied().filter(once).collect();
                if fits(&outline) {
                    return Some(outline);
                }
                larger.push(with);
            }
        }
        sets = larger;
    }
    None
}

/// The electrons that an atom gives to a ring; `None` if it cannot be part of an aromatic one.
fn electrons(graph: &Graph<'_>, orders: &Orders<'_>, in_ring: &[bool], atom: usize) -> Option<u8> {
    let element = graph.elements[atom];
    if !matches!(element.z(), 5..=8 | 14..=16 | 33 | 34 | 52) {
        return None;
    }
    let held = graph.held(atom);
    let bonds = graph.degree(atom) + usize::from(held.hydrogens) + usize::from(held.others);
    let (mut inside, mut outside, mut valence) = (0, None, usize::from(held.hydrogens) + usize::from(held.others));
    for neighbour in graph.around(atom) {
        let order = (orders.order)(neighbour.bond).max(1);
        valence += usize::from(order);
        match (order, in_ring[neighbour.bond as usize]) {
            (1, _) => {}
            (2, true) => inside += 1,
            (2, false) if outside.is_none() => outside = Some(graph.elements[neighbour.atom as usize]),
            // A triple bond in a ring gives one electron pair, as benzyne shows; out of it, or a second double bond, none.
            (3, true) => inside += 1,
            _ => return None,
        }
    }
    let charge = (orders.charge)(atom);
    // Sulfur(IV), phosphorus(V) and the like have no electrons to give.
    let most = match element.z() {
        5 => 3,
        6 | 14 => 4,
        7 | 15 | 33 => 3,
        _ => 2,
    };
    let most = most + if matches!(element.group(), 15 | 16) { i32::from(charge) } else { -i32::from(charge.abs()) };
    if valence as i32 > most || bonds > 3 {
        return None;
    }
    match (inside, outside) {
        (1, None) => Some(1),
        (0, Some(other)) => {
            let steals = electronegativity(other.z()) > electronegativity(element.z());
            Some(if steals { 0 } else { 1 })
        }
        (0, None) => match element.group() {
            13 => Some(0),
            14 => match charge {
                -1 => Some(2),
                1 => Some(0),
                _ => None,
            },
            15 | 16 => {
                let is_full = valence as i32 == most || (orders.fills_up)(atom);
                is_full.then_some(2)
            }
            _ => None,
        },
        _ => None,
    }
}

/// Pauling's scale, as far as elements of rings and their partners go.
fn electronegativity(z: u8) -> f32 {
    match z {
        5 => 2.04,
        6 => 2.55,
        7 => 3.04,
        8 => 3.44,
        9 => 3.98,
        14 => 1.90,
        15 => 2.19,
        16 => 2.58,
        33 => 2.18,
        34 => 2.55,
        52 => 2.10,
        _ => 2.2,
    }
}
