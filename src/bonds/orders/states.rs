//! The ways an atom can share its electrons, and what each of them costs before statistics have a word.

use super::graph::{Graph, Neighbour};
use super::lengths;
use super::sites::{RingKinds, UNKNOWN, is_flat_ring};
use crate::element::Element;

/// Heavy neighbours of an atom that has more than one state: more neighbours leave no electrons for a double bond.
pub(super) const MOST_NEIGHBOURS: usize = 4;

/// Extra electron pairs on each bond of an atom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct State {
    /// Two bits a neighbour, in the order of [`Graph::around`]: order less one.
    pub(super) extra: u8,
    /// What the extra pairs are, 0–7: see [`pi_kind`].
    pub(super) pi: u8,
    /// Formal charge.
    pub(super) charge: i8,
}

impl State {
    /// Extra pairs of the bond to a neighbour.
    pub(super) fn extra(self, slot: usize) -> u8 {
        (self.extra >> (2 * slot)) & 3
    }

    /// Extra pairs of all bonds.
    pub(super) fn sum(self) -> u8 {
        (0..MOST_NEIGHBOURS).map(|slot| self.extra(slot)).sum()
    }
}

/// The most extra pairs an atom of an element with so many heavy neighbours and `taken` further bonds has.
pub(super) fn most_extra(element: Element, degree: usize, taken: usize, in_flat_ring: bool) -> u8 {
    let bonds = degree + taken;
    let most = match element.z() {
        6 | 14 | 32 => 4usize.saturating_sub(bonds).min(2),
        5 => usize::from(bonds <= 2),
        7 => 4usize.saturating_sub(bonds).min(2),
        8 => match bonds {
            1 => 2,
            2 if in_flat_ring => 1, // pyrylium
            _ => 0,
        },
        15 | 33 | 51 => match bonds {
            1 | 2 => 2,
            3 => 2,
            4 => 1,
            _ => 0,
        },
        16 | 34 | 52 => match bonds {
            1 => 1,
            2 => 2,
            3 => 3,
            4 => 2,
            5 => 1,
            _ => 0,
        },
        17 | 35 | 53 => match bonds {
            1 => 0,
            2 => 1,
            3 => 2,
            4 => 3,
            _ => 0,
        },
        54 => match bonds {
            3 => 3,
            4 => 4,
            _ => 0,
        },
        _ => 0,
    };
    if degree > MOST_NEIGHBOURS { 0 } else { most as u8 }
}

/// Cost of a carbon without a double bond that a metal holds by its neighbours, too. Chosen so that cyclopentadienyl has one
/// and two double bonds, not five: ferrocene's lengths (1.43 Å) alone would leave all single.
const PI_CARBANION: f32 = 5.0;

/// Cost and charge of an atom by the electron pairs it shares; `None` where it cannot be. Costs are in units of a
/// log-likelihood: 7 is a case in a thousand. `hydrogens` is `None` where they are not known: then free valences hold
/// hydrogens.
pub(super) fn cost(
    element: Element,
    valence: usize,
    bonds: usize,
    hydrogens: Option<u8>,
    has_metals: bool,
) -> Option<(f32, i8)> {
    let known = hydrogens.is_some();
    let free = |cost: f32, charge: i8| if known { (cost, charge) } else { (0.0, 0) };
    // A lone pair that a metal takes up is a charge that costs little.
    let given = |cost: f32| if has_metals { 0.5 } else { cost };
    Some(match (element.z(), valence) {
        (6 | 14 | 32, 4) => (0.0, 0),
        (6, 3) if bonds == 1 => free(given(5.0), -1), // isocyanide, carbon monoxide
        // Beside a metal one of a ring or chain that it holds; all others there have double bonds.
        (6, 3) => free(if has_metals { PI_CARBANION } else { 9.0 }, if bonds == 3 && !has_metals { 1 } else { -1 }),
        (6 | 14 | 32, 0..=3) => free(given(14.0), 0),
        (7, 3) => (0.0, 0),
        (7, 4) => (if known { 2.0 } else { 4.0 }, 1),
        (7, 2) => free(given(5.0), -1),
        (7, 0 | 1) => free(given(12.0), -2),
        (8, 2) => (0.0, 0),
        (8, 1) => free(given(2.0), -1),
        (8, 3) => (8.0, 1),
        (8, 0) => free(given(9.0), -2),
        (5, 3) => (0.0, 0),
        (5, 4) => (2.0, -1),
        (5, 0..=2) => free(8.0, 0),
        (9 | 17 | 35 | 53, 1) => (0.0, 0),
        (17 | 35 | 53, 3 | 5 | 7) => (2.0, 0),
        (17 | 35 | 53, 2) => (4.0, 1),
        (17 | 35 | 53, 4 | 6) => (8.0, -1), // ICl₄⁻, BrF₆⁻
        (14 | 32, 5) => (0.0, -1),
        (14 | 32, 6) => (0.0, -2),
        (15 | 33 | 51, 3 | 5) => (0.0, 0),
        (15 | 33 | 51, 4) => (if bonds == 4 { 3.0 } else { 6.0 }, 1),
        (15 | 33 | 51, 0..=2) => free(given(6.0), 0),
        (15 | 33 | 51, 6) => (4.0, -1),
        (16 | 34 | 52, 2 | 6) => (0.0, 0),
        (16 | 34 | 52, 4) => (1.0, 0),
        (16 | 34 | 52, 1) => free(given(3.0), -1),
        (16 | 34 | 52, 3) => (4.0, 1),
        (16 | 34 | 52, 5) => (7.0, 1),
        (16 | 34 | 52, 0) => free(given(8.0), -2),
        (54, 2 | 4 | 6 | 8) => (0.0, 0),
        (5..=9 | 14..=17 | 32..=35 | 51..=54, _) => return None,
        _ => (0.0, 0),
    })
}

/// What extra pairs are, seen from an atom: 0 none; 1–3 a double bond out of flat rings to carbon, to nitrogen, to
/// another element; 4 and 5 one in a flat ring to carbon, to another element; 6 a triple bond; 7 several double bonds.
pub(super) fn pi_kind(graph: &Graph<'_>, kinds: &RingKinds, atom: usize, extra: u8) -> u8 {
    let around = graph.around(atom);
    let at = |slot: usize| (extra >> (2 * slot)) & 3;
    let multiple = (0..around.len().min(MOST_NEIGHBOURS)).filter(|&slot| at(slot) > 0);
    let (count, first) = (multiple.clone().count(), multiple.clone().next());
    let Some(slot) = first else { return 0 };
    if count > 1 {
        return 7;
    }
    if at(slot) > 1 {
        return 6;
    }
    let neighbour = around[slot];
    let z = graph.elements[neighbour.atom as usize].z();
    if is_flat_ring(kinds.bond(neighbour.bond)) {
        return if z == 6 { 4 } else { 5 };
    }
    match z {
        6 => 1,
        7 => 2,
        _ => 3,
    }
}

/// Degrees below which an atom of carbon or nitrogen between two others has neither a triple nor two double bonds:
/// 158° in cyclooctyne (Haase and Krebs 1971), less 3 standard errors of an angle between positions with errors of
/// 0.03 Å.
const LINEAR_DEG: f32 = 145.0;
/// How much longer than single the other bond of such an atom is at most, in ångström: 4 times the error of a length.
const LONGER_THAN_SINGLE: f32 = 0.18;
/// How much shorter than double a bond may be that is not triple, where the atom has two extra pairs: 3 times the error of
/// a length. A bond as short as a triple one beside another is a badly placed atom (PDB entry 4HHB).
const SHORTER_THAN_DOUBLE: f32 = 0.12;
/// C=O beside another double bond, in ångström: in carbon dioxide 1.160 (Herzberg, Electronic Spectra of Polyatomic Molecules,
/// 1966), isocyanates and ketenes 1.16–1.17, for 1.24 by the radii.
const CUMULATED_C_O: f32 = 1.16;

/// Which extra pairs geometry allows an atom of carbon or nitrogen with two neighbours.
#[derive(Clone, Copy)]
struct Linear {
    /// Whether it may have two.
    may_be: bool,
    /// Whether each bond is too short to be anything but triple then.
    is_short: [bool; 2],
}

impl Linear {
    fn new(graph: &Graph<'_>, atom: usize) -> Linear {
        let element = graph.elements[atom];
        let (&[one, other], true, 6 | 7) = (graph.around(atom), graph.has_geometry(), element.z()) else {
            return Linear { may_be: true, is_short: [false; 2] };
        };
        let vectors = [one, other].map(|next| graph.vector(atom, next));
        let expected = |order: usize| {
            [one, other].map(|next| lengths::expected(element, graph.elements[next.atom as usize], order))
        };
        let (single, double) = (expected(1), expected(2));
        let is_long = |slot: usize| vectors[slot].length() > single[slot] + LONGER_THAN_SINGLE;
        // In azides both bonds between nitrogens are as short as triple ones (1.13 and 1.24 Å).
        let has_carbon = |next: Neighbour| element == Element::C || graph.elements[next.atom as usize] == Element::C;
        let is_short = |slot: usize| {
            let next = [one, other][slot];
            let has_oxygen = graph.elements[next.atom as usize] == Element::O;
            let usual = if has_oxygen { CUMULATED_C_O } else { double[slot] };
            has_carbon(next) && vectors[slot].length() < usual - SHORTER_THAN_DOUBLE
        };
        let is_bent = vectors[0].angle_between(vectors[1]).to_degrees() < LINEAR_DEG;
        Linear { may_be: !is_bent && !is_long(0) && !is_long(1), is_short: [is_short(0), is_short(1)] }
    }

    /// Whether these extra pairs on the two bonds fit.
    fn fits(self, extra: [u8; 2]) -> bool {
        extra[0] + extra[1] < 2
            || self.may_be && (extra[0] == 2 || !self.is_short[0]) && (extra[1] == 2 || !self.is_short[1])
    }
}

/// Adds all states of an atom that cost no more than `most_cost` to `out`. `allowed` says which extra pairs a bond (by its
/// place around the atom) may have; without extra pairs is the first.
#[allow(clippy::too_many_arguments, reason = "what is known of one atom, and the list that serves all")]
pub(super) fn states(
    graph: &Graph<'_>,
    kinds: &RingKinds,
    atom: usize,
    hydrogens: u8,
    fixed_extra: usize,
    most_cost: f32,
    allowed: impl Fn(usize) -> u8,
    out: &mut Vec<(State, f32)>,
) {
    let held = graph.held(atom);
    let element = graph.elements[atom];
    let degree = graph.degree(atom);
    let known = (hydrogens != UNKNOWN).then_some(held.hydrogens);
    let taken = usize::from(held.others) + usize::from(held.hydrogens);
    let bonds = degree + taken;
    let most = usize::from(most_extra(element, degree, taken, is_flat_ring(kinds.atom(atom)))).max(fixed_extra);
    let linear = Linear::new(graph, atom);
    let has_metals = held.metals > 0;
    let limits: [u8; MOST_NEIGHBOURS] =
        std::array::from_fn(|slot| if slot < degree && degree <= MOST_NEIGHBOURS { allowed(slot).min(3) } else { 0 });
    let mut of = [0u8; MOST_NEIGHBOURS];
    loop {
        let sum: usize = of.iter().map(|&extra| usize::from(extra)).sum();
        if sum + fixed_extra <= most && linear.fits([of[0], of[1]]) {
            let extra = of.iter().rev().fold(0, |extra, &of| extra << 2 | of);
            let pi = pi_kind(graph, kinds, atom, extra);
            match cost(element, bonds + fixed_extra + sum, bonds, known, has_metals) {
                Some((cost, charge)) if cost <= most_cost => out.push((State { extra, pi, charge }, cost)),
                None if extra == 0 => out.push((State { extra, pi, charge: 0 }, 0.0)),
                _ => {}
            }
        }
        // The next choice: the first bond runs fastest.
        let Some(slot) = (0..MOST_NEIGHBOURS).find(|&slot| of[slot] < limits[slot]) else { return };
        of[slot] += 1;
        of[..slot].fill(0);
    }
}
