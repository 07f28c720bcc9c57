//! What is seen of an atom before any order is known: element, neighbours, hydrogens, rings and angles.

use super::graph::Graph;
use super::rings::Ring;
use crate::element::Element;
use glam::Vec3;

/// Hydrogens of an atom of which they are not known.
pub(super) const UNKNOWN: u8 = 7;

/// Ring surroundings of bonds and atoms, from the smallest and flattest ring they are in.
pub(super) struct RingKinds {
    bonds: Vec<u8>,
    atoms: Vec<u8>,
}

/// Not in a ring of up to eight atoms.
pub(super) const NO_RING: u8 = 0;
/// Rings of three and four atoms.
const SMALL: u8 = 1;
/// Rings of five and six atoms that are flat, nearly, or not: three numbers each.
pub(super) const FIVE: u8 = 2;
pub(super) const SIX: u8 = 5;
/// Rings of seven and eight atoms, flat or not.
const LARGE: u8 = 8;
/// In two flat rings, at least one of five atoms, or both of six.
const FUSED_FIVE: u8 = 10;
const FUSED_SIX: u8 = 11;

/// Root mean square distance from the plane below which a ring is flat, and nearly flat, in ångström. Aromatic rings in
/// positions with errors of 0.03 Å have 0.02–0.03 Å, envelopes 0.15 Å, half chairs 0.17 Å, chairs 0.23 Å.
const FLAT: f32 = 0.06;
const NEARLY_FLAT: f32 = 0.12;

impl RingKinds {
    /// The kinds by these rings.
    pub(super) fn new(graph: &Graph<'_>, rings: &[Ring]) -> RingKinds {
        let mut kinds = RingKinds { bonds: Vec::new(), atoms: Vec::new() };
        if rings.is_empty() {
            return kinds;
        }
        kinds.bonds = vec![NO_RING; graph.bonds().len()];
        kinds.atoms = vec![NO_RING; graph.atom_count()];
        for ring in rings {
            let unevenness = ring.unevenness(graph);
            let bumps = u8::from(unevenness > FLAT) + u8::from(unevenness > NEARLY_FLAT);
            let kind = match ring.len() {
                3 | 4 => SMALL,
                5 => FIVE + bumps,
                6 => SIX + bumps,
                _ => LARGE + bumps / 2,
            };
            for &bond in &ring.bonds {
                let slot = &mut kinds.bonds[bond as usize];
                *slot = joined(*slot, kind);
            }
            for &atom in &ring.atoms {
                let slot = &mut kinds.atoms[atom as usize];
                *slot = joined(*slot, kind);
            }
        }
        kinds
    }

    /// The kind of a bond.
    pub(super) fn bond(&self, bond: u32) -> u8 {
        self.bonds.get(bond as usize).copied().unwrap_or(NO_RING)
    }

    /// The kind of an atom.
    pub(super) fn atom(&self, atom: usize) -> u8 {
        self.atoms.get(atom).copied().unwrap_or(NO_RING)
    }
}

/// The kind of what is in a ring of each of two kinds.
fn joined(one: u8, other: u8) -> u8 {
    let is_flat = |kind: u8| matches!(kind, 2 | 3 | 5 | 6 | FUSED_FIVE | FUSED_SIX);
    let has_five = |kind: u8| matches!(kind, 2 | 3 | FUSED_FIVE);
    match (one, other) {
        (NO_RING, kind) | (kind, NO_RING) => kind,
        (SMALL, _) | (_, SMALL) => SMALL,
        (one, other) if is_flat(one) && is_flat(other) => {
            if has_five(one) || has_five(other) {
                FUSED_FIVE
            } else {
                FUSED_SIX
            }
        }
        (one, other) if is_flat(other) && !is_flat(one) => other,
        (one, other) if is_flat(one) && !is_flat(other) => one,
        (one, other) => one.min(other),
    }
}

/// Whether a kind is a flat ring of five or six atoms, where double bonds may alternate.
pub(super) fn is_flat_ring(kind: u8) -> bool {
    matches!(kind, 2 | 3 | 5 | 6 | FUSED_FIVE | FUSED_SIX)
}

/// An element in four bits: those of which there are statistics, and one for all others.
pub(super) fn element_code(element: Element) -> u8 {
    match element.z() {
        6 => 1,
        7 => 2,
        8 => 3,
        16 => 4,
        15 => 5,
        9 => 6,
        17 => 7,
        35 => 8,
        53 => 9,
        5 => 10,
        14 => 11,
        34 => 12,
        33 => 13,
        _ => 14,
    }
}

/// An atom as it is before any order is known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Site {
    /// [`element_code`].
    pub(super) element: u8,
    /// Heavy neighbours, at most 7.
    pub(super) degree: u8,
    /// Hydrogens, at most 6, or [`UNKNOWN`].
    pub(super) hydrogens: u8,
    /// Ring kind.
    pub(super) ring: u8,
    /// Interval of the bond angle (two neighbours) or of the height over the plane of three.
    pub(super) shape: u8,
}

impl Site {
    /// Reads an atom.
    pub(super) fn new(graph: &Graph<'_>, kinds: &RingKinds, atom: usize, hydrogens_known: bool) -> Site {
        Site {
            element: element_code(graph.elements[atom]),
            degree: graph.degree(atom).min(7) as u8,
            hydrogens: if hydrogens_known { graph.held(atom).hydrogens.min(6) } else { UNKNOWN },
            ring: kinds.atom(atom),
            shape: shape(graph, atom),
        }
    }

    /// Element, neighbours and hydrogens in ten bits.
    pub(super) fn class(&self) -> u64 {
        u64::from(self.element) << 6 | u64::from(self.degree) << 3 | u64::from(self.hydrogens)
    }
}

/// The number of limits that a value exceeds.
fn interval(value: f32, limits: &[f32]) -> u8 {
    limits.iter().take_while(|&&limit| value > limit).count() as u8
}

/// Intervals of angles in degrees: fine between 100° and 132°, where five-membered rings, sp³ and sp² follow each other.
const ANGLES_DEG: [f32; 14] =
    [95.0, 102.0, 105.0, 108.0, 111.0, 114.0, 117.0, 120.0, 123.0, 126.0, 130.0, 140.0, 155.0, 168.0];

/// The interval of the angle at an atom.
pub(super) fn angle_interval(graph: &Graph<'_>, atom: usize, one: usize, other: usize) -> u8 {
    let around = graph.around(atom);
    let angle = graph.vector(atom, around[one]).angle_between(graph.vector(atom, around[other])).to_degrees();
    interval(angle, &ANGLES_DEG)
}

fn shape(graph: &Graph<'_>, atom: usize) -> u8 {
    if !graph.has_geometry() {
        return 15;
    }
    match graph.around(atom) {
        [_, _] => angle_interval(graph, atom, 0, 1),
        &[a, b, c] => {
            let [a, b, c] = [a, b, c].map(|neighbour| graph.vector(atom, neighbour));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            // An sp³ carbon is 0.5 Å over the plane of its neighbours, an sp² atom within errors in it.
            interval(normal.dot(a).abs(), &[0.04, 0.08, 0.12, 0.17, 0.23, 0.3, 0.38])
        }
        _ => 0,
    }
}

/// Neighbours at the far end of a bond whose directions are kept while those at the near end are gone through.
const KEPT: usize = 4;

/// The interval of how far a bond is twisted out of plane: 0 where there is nothing to tell it from, 1 flat to 6.
pub(super) fn twist(graph: &Graph<'_>, atom: usize, slot: usize) -> u8 {
    let to = graph.around(atom)[slot];
    let (near, far) = (graph.around(atom), graph.around(to.atom as usize));
    if near.len() < 2 || far.len() < 2 {
        return 0;
    }
    let axis = graph.vector(atom, to).normalize_or_zero();
    let across = |vector: Vec3| vector.reject_from_normalized(axis).normalize_or_zero();
    let there = |at: usize| across(graph.vector(to.atom as usize, far[at]));
    let kept: [Vec3; KEPT] = std::array::from_fn(|at| if at < far.len() { there(at) } else { Vec3::ZERO });
    let mut sum = 0.0;
    let mut count = 0u8;
    for &one in near.iter().filter(|one| one.bond != to.bond) {
        let here = across(graph.vector(atom, one));
        for at in (0..far.len()).filter(|&at| far[at].bond != to.bond) {
            let there = if at < KEPT { kept[at] } else { there(at) };
            sum += here.cross(there).length().atan2(here.dot(there).abs()).to_degrees();
            count += 1;
        }
    }
    if count == 0 { 0 } else { 1 + interval(sum / f32::from(count), &[6.0, 12.0, 20.0, 32.0, 48.0]) }
}
