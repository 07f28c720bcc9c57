//! One set of atoms whose orders depend on each other, as a graph of choices.

use super::features::{self, Pair, Weights};
use super::graph::Graph;
use super::lengths;
use super::rings::Ring;
use super::sites::{RingKinds, Site, is_flat_ring};
use super::solve::Problem;
use super::states::{self, MOST_NEIGHBOURS, State};
use crate::element::Element;
use rayon::prelude::*;

/// How much shorter than a triple bond two atoms may be and still have more than one bond, in ångström: 3.5 times the error
/// of a length from positions with errors of 0.03 Å. Nearer than that no bond of any order is: the positions are wrong
/// (side chains built without density, as in PDB entry 4HHB, C–C from 0.58 Å), and say nothing of orders.
const SHORTER: f32 = 0.15;
/// How much longer than expected a double or triple bond may be, in ångström: 5 times the error of a length from
/// positions with errors of 0.03 Å, and for aromatic rings, whose bonds lie between single and double, 0.08 Å more.
const LONGER: f32 = 0.18;
const LONGER_IN_RING: f32 = 0.28;

/// A molecule or several, with all that is known before the orders.
pub(super) struct Setup<'a> {
    pub(super) graph: Graph<'a>,
    pub(super) kinds: RingKinds,
    sites: Vec<Site>,
    /// Extra pairs that each bond may have beyond its first; empty bonds are those whose order stands.
    limits: Vec<u8>,
}

impl<'a> Setup<'a> {
    /// Prepares a graph. `is_open` says of which bonds (by index) the order is to be found; `rings` are those of at
    /// least all atoms in reach of such bonds.
    pub(super) fn new(
        graph: Graph<'a>,
        rings: &[Ring],
        hydrogens_known: &(impl Fn(usize) -> bool + Sync),
        is_open: &(impl Fn(usize) -> bool + Sync),
    ) -> Setup<'a> {
        let kinds = RingKinds::new(&graph, rings);
        let sites: Vec<Site> = (0..graph.atom_count())
            .into_par_iter()
            .with_min_len(4096)
            .map(|atom| Site::new(&graph, &kinds, atom, hydrogens_known(atom)))
            .collect();
        let mut setup = Setup { graph, kinds, sites, limits: Vec::new() };
        setup.limits = setup.bond_limits(is_open);
        setup
    }

    fn bond_limits(&self, is_open: &(impl Fn(usize) -> bool + Sync)) -> Vec<u8> {
        let most: Vec<u8> =
            (0..self.graph.atom_count()).into_par_iter().with_min_len(4096).map(|atom| self.most_extra(atom)).collect();
        let limit = |atom: usize, neighbour: super::graph::Neighbour| {
            let other = neighbour.atom as usize;
            if !is_open(neighbour.bond as usize) {
                return 0;
            }
            let most = most[atom].min(most[other]).min(2);
            let elements = [self.graph.elements[atom], self.graph.elements[other]];
            // Carbon and sulfur share no three pairs in anything that keeps (thiolates that clash in a rough model would).
            let is_thio = elements.contains(&Element::C) && elements.contains(&Element::S);
            let most = if is_thio { most.min(1) } else { most };
            let longer = if is_flat_ring(self.kinds.bond(neighbour.bond)) { LONGER_IN_RING } else { LONGER };
            let length = self.graph.vector(atom, neighbour).length();
            let [a, b] = elements;
            // Of heavier atoms the radii are good to 0.1 Å only: S=O has 1.43 Å for 1.51 Å.
            let is_of_second_period = a.period() == 2 && b.period() == 2;
            if self.graph.has_geometry() && is_of_second_period && length < lengths::expected(a, b, 3) - SHORTER {
                return 0;
            }
            (0..=most)
                .rev()
                .find(|&extra| {
                    extra == 0
                        || !self.graph.has_geometry()
                        || length <= lengths::expected(a, b, usize::from(extra) + 1) + longer
                })
                .unwrap_or(0)
        };
        let mut limits = vec![0u8; self.graph.bonds().len()];
        for atom in (0..self.graph.atom_count()).filter(|&atom| most[atom] > 0) {
            for &neighbour in self.graph.around(atom).iter().filter(|neighbour| neighbour.atom as usize > atom) {
                limits[neighbour.bond as usize] = limit(atom, neighbour);
            }
        }
        limits
    }

    /// Extra pairs of the bonds whose order stands.
    fn fixed_extra(&self, atom: usize) -> usize {
        let extra = |neighbour: &super::graph::Neighbour| {
            let order = self.graph.bonds()[neighbour.bond as usize].order.number();
            if self.limits.get(neighbour.bond as usize).is_some_and(|&limit| limit > 0) {
                0
            } else {
                usize::from(order.saturating_sub(1))
            }
        };
        self.graph.around(atom).iter().map(extra).sum()
    }

    fn most_extra(&self, atom: usize) -> u8 {
        let held = self.graph.held(atom);
        let taken = usize::from(held.others) + usize::from(held.hydrogens);
        let degree = self.graph.degree(atom);
        if degree > MOST_NEIGHBOURS {
            return 0;
        }
        states::most_extra(self.graph.elements[atom], degree, taken, is_flat_ring(self.kinds.atom(atom)))
    }

    /// The sets of atoms that have a choice and depend on each other, each in ascending order.
    pub(super) fn components(&self) -> Vec<Vec<u32>> {
        let count = self.graph.atom_count();
        let mut is_open = vec![false; count];
        for (bond, _) in self.limits.iter().enumerate().filter(|&(_, &limit)| limit > 0) {
            let bond = &self.graph.bonds()[bond];
            is_open[bond.a as usize] = true;
            is_open[bond.b as usize] = true;
        }
        let mut components = Vec::new();
        for start in 0..count {
            if !is_open[start] {
                continue;
            }
            is_open[start] = false;
            let mut atoms = vec![start as u32];
            let mut at = 0;
            while let Some(&atom) = atoms.get(at) {
                at += 1;
                for neighbour in self.graph.around(atom as usize) {
                    let other = neighbour.atom as usize;
                    if is_open[other] {
                        is_open[other] = false;
                        atoms.push(neighbour.atom);
                    }
                }
            }
            atoms.sort_unstable();
            components.push(atoms);
        }
        components
    }
}

/// States that cost more than this are left out at first: radicals, carbocations, bare nitrogen.
const USUAL_COST: f32 = 8.5;

/// A set of atoms with their states.
pub(super) struct Component<'s, 'a> {
    setup: &'s Setup<'a>,
    pub(super) atoms: Vec<u32>,
    /// States and their costs.
    pub(super) states: Vec<Vec<(State, f32)>>,
    /// Places in `atoms`, the places of the bond around each, and what is seen of the bond.
    edges: Vec<(u32, u32, u8, u8, Pair)>,
    /// Place in `atoms`, and the bond to an atom outside.
    rims: Vec<(u32, u8, Pair)>,
}

impl<'s, 'a> Component<'s, 'a> {
    /// The states and bonds of these atoms.
    pub(super) fn new(setup: &'s Setup<'a>, atoms: Vec<u32>, most_cost: f32) -> Component<'s, 'a> {
        let graph = &setup.graph;
        let site_of = |atom: usize| setup.sites[atom];
        let mut all = Vec::with_capacity(atoms.len());
        let (mut edges, mut rims) = (Vec::new(), Vec::new());
        for (place, &atom) in atoms.iter().enumerate() {
            let atom = atom as usize;
            let around = graph.around(atom);
            let (hydrogens, fixed) = (setup.sites[atom].hydrogens, setup.fixed_extra(atom));
            let within = |most_cost: f32| {
                states::states(graph, &setup.kinds, atom, hydrogens, fixed, most_cost, |slot| {
                    setup.limits[around[slot].bond as usize]
                })
            };
            let mut states = within(most_cost);
            if states.is_empty() {
                states = within(f32::INFINITY);
            }
            all.push(states);
            for (slot, neighbour) in around.iter().enumerate().take(MOST_NEIGHBOURS) {
                match atoms.binary_search(&neighbour.atom) {
                    Ok(other) if other > place => {
                        let back =
                            graph.around(neighbour.atom as usize).iter().position(|back| back.bond == neighbour.bond);
                        let back = back.unwrap_or(usize::MAX).min(255) as u8;
                        edges.push((
                            place as u32,
                            other as u32,
                            slot as u8,
                            back,
                            Pair::new(graph, &setup.kinds, &site_of, atom, slot),
                        ));
                    }
                    Ok(_) => {}
                    Err(_) => {
                        rims.push((place as u32, slot as u8, Pair::new(graph, &setup.kinds, &site_of, atom, slot)))
                    }
                }
            }
        }
        Component { setup, atoms, states: all, edges, rims }
    }

    /// The orders of the bonds between these atoms that score best: bond and order.
    pub(super) fn best(setup: &'s Setup<'a>, atoms: Vec<u32>, weights: &impl Weights) -> Vec<(u32, u8)> {
        if let Some(pair) = diatomic(setup, &atoms) {
            return vec![pair];
        }
        let component = Component::new(setup, atoms, USUAL_COST);
        let problem = component.problem(weights);
        let chosen = problem.solve();
        if problem.score(&chosen).is_finite() {
            return component.orders(&chosen);
        }
        let component = Component::new(setup, component.atoms, f32::INFINITY);
        let chosen = component.problem(weights).solve();
        component.orders(&chosen)
    }

    /// The bonds and orders of a choice of states.
    pub(super) fn orders(&self, chosen: &[u8]) -> Vec<(u32, u8)> {
        let order = |(a, _, slot, ..): &(u32, u32, u8, u8, Pair)| {
            let (place, slot) = (*a as usize, usize::from(*slot));
            let bond = self.setup.graph.around(self.atoms[place] as usize)[slot].bond;
            (self.setup.limits[bond as usize] > 0)
                .then(|| (bond, 1 + self.states[place][usize::from(chosen[place])].0.extra(slot)))
        };
        self.edges.iter().filter_map(order).collect()
    }

    /// The features of a choice of states: what the score is made of, and what the weights were fitted through.
    #[cfg(test)]
    pub(super) fn features(&self, chosen: &[u8], sink: &mut impl FnMut(u64, f32)) {
        let state = |place: usize| self.states[place][usize::from(chosen[place])].0;
        let site_of = |atom: usize| self.setup.sites[atom];
        for (place, &atom) in self.atoms.iter().enumerate() {
            let graph = &self.setup.graph;
            let atom = (atom as usize, features::opposite_angles(graph, atom as usize));
            features::of_atom(graph, &self.setup.kinds, &site_of, atom, state(place), sink);
        }
        for (a, b, slot, _, pair) in &self.edges {
            let (one, other) = (state(*a as usize), state(*b as usize));
            pair.features(one.extra(usize::from(*slot)), [one.pi, other.pi], sink);
        }
        for (a, _, pair) in &self.rims {
            pair.features(0, [state(*a as usize).pi, 0], sink);
        }
    }

    /// The choices with their scores by a model.
    pub(super) fn problem(&self, weights: &impl Weights) -> Problem {
        let (graph, kinds) = (&self.setup.graph, &self.setup.kinds);
        let site_of = |atom: usize| self.setup.sites[atom];
        let mut problem = Problem::default();
        for (&atom, states) in self.atoms.iter().zip(&self.states) {
            let atom = (atom as usize, features::opposite_angles(graph, atom as usize));
            let score = |&(state, cost): &(State, f32)| {
                let mut score = -cost;
                features::of_atom(graph, kinds, &site_of, atom, state, &mut |feature, value| {
                    score += weights.weight(feature) * value;
                });
                score
            };
            problem.unary.push(states.iter().map(score).collect());
        }
        let scores_of = |pair: &Pair, elements: [usize; 2]| {
            let [a, b] = elements.map(|atom| graph.elements[atom]);
            let mut known = [[[f32::NAN; 8]; 8]; 3];
            let length = pair.length();
            let (has_geometry, weights) = (graph.has_geometry(), weights);
            move |pair: &Pair, extra: u8, pi: [u8; 2]| {
                let slot = &mut known[usize::from(extra.min(2))][usize::from(pi[0] & 7)][usize::from(pi[1] & 7)];
                if slot.is_nan() {
                    let mut score =
                        if has_geometry { -lengths::penalty(a, b, usize::from(extra) + 1, length) } else { 0.0 };
                    pair.features(extra, pi, &mut |feature, value| score += weights.weight(feature) * value);
                    *slot = score;
                }
                *slot
            }
        };
        for (place, slot, pair) in &self.rims {
            let atom = self.atoms[*place as usize] as usize;
            let mut score = scores_of(pair, [atom, graph.around(atom)[usize::from(*slot)].atom as usize]);
            for (sum, (state, _)) in problem.unary[*place as usize].iter_mut().zip(&self.states[*place as usize]) {
                *sum += score(pair, 0, [state.pi, 0]);
            }
        }
        for (a, b, slot, back, pair) in &self.edges {
            let mut score = scores_of(pair, [*a, *b].map(|place| self.atoms[place as usize] as usize));
            let (ours, theirs) = (&self.states[*a as usize], &self.states[*b as usize]);
            let mut scores = Vec::with_capacity(ours.len() * theirs.len());
            for (one, _) in ours {
                for (other, _) in theirs {
                    let extra = one.extra(usize::from(*slot));
                    let fits = usize::from(*back) >= MOST_NEIGHBOURS && extra == 0
                        || usize::from(*back) < MOST_NEIGHBOURS && other.extra(usize::from(*back)) == extra;
                    scores.push(if fits { score(pair, extra, [one.pi, other.pi]) } else { f32::NEG_INFINITY });
                }
            }
            problem.pairs.push((*a, *b, scores));
        }
        problem
    }
}

/// Degrees between metal, nitrogen and oxygen from which nitrosyl is linear, NO⁺ with a triple bond. Bent ones, NO⁻, have
/// 120–140°, linear ones 160–180° (Enemark and Feltham, Coord. Chem. Rev. 1974, 13, 339).
const LINEAR_NITROSYL_DEG: f32 = 150.0;

/// The bond of a molecule of two atoms and nothing else (N₂, O₂, CO), free or on a metal (carbonyls, cyanides, nitrosyls):
/// the order whose expected length is nearest. Nothing in the statistics, which are of organic molecules, is like it.
/// Carbon monoxide between two metals or more has a double bond, as a ketone has, and nitric oxide on a metal that of its angle.
fn diatomic(setup: &Setup<'_>, atoms: &[u32]) -> Option<(u32, u8)> {
    let &[a, b] = atoms else { return None };
    let graph = &setup.graph;
    let is_bare = |atom: u32| {
        let held = graph.held(atom as usize);
        graph.degree(atom as usize) == 1 && held.hydrogens + held.others == 0
    };
    if !is_bare(a) || !is_bare(b) || !graph.has_geometry() {
        return None;
    }
    let next = graph.around(a as usize)[0];
    let length = graph.vector(a as usize, next).length();
    let elements = [a, b].map(|atom| graph.elements[atom as usize]);
    let most = 1 + setup.limits[next.bond as usize];
    let most = match elements {
        [Element::C, Element::O] if graph.held(a as usize).metals > 1 => most.min(2),
        [Element::O, Element::C] if graph.held(b as usize).metals > 1 => most.min(2),
        _ => most,
    };
    let nitrogen = match elements {
        [Element::N, Element::O] => Some(a as usize),
        [Element::O, Element::N] => Some(b as usize),
        _ => None,
    };
    if let Some((nitrogen, metal)) = nitrogen.and_then(|atom| Some((atom, graph.metals(atom).next()?))) {
        let to_oxygen = graph.vector(nitrogen, graph.around(nitrogen)[0]);
        let angle = graph.vector(nitrogen, metal).angle_between(to_oxygen).to_degrees();
        return Some((next.bond, most.min(if angle >= LINEAR_NITROSYL_DEG { 3 } else { 2 })));
    }
    let off = |order: u8| (length - lengths::expected(elements[0], elements[1], usize::from(order))).abs();
    (1..=most).min_by(|&one, &other| off(one).total_cmp(&off(other))).map(|order| (next.bond, order))
}
