//! One set of atoms whose orders depend on each other, as a graph of choices.

use super::features::{Pair, Surroundings, Weights};
use super::graph::Graph;
use super::lengths;
use super::rings::Ring;
use super::sites::{RingKinds, Site, is_flat_ring};
use super::solve::{Problem, Solver};
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
    /// The atoms that have a choice, one set after the other of those that depend on each other, ascending in each.
    members: Vec<u32>,
    /// The atoms of set `i` are `members[first_member[i]..first_member[i + 1]]`.
    first_member: Vec<usize>,
    /// The place of each atom in its set, or [`OUTSIDE`].
    place: Vec<u32>,
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
        let (limits, members, place) = (Vec::new(), Vec::new(), Vec::new());
        let mut setup = Setup { graph, kinds, sites, limits, members, first_member: vec![0], place };
        setup.limits = setup.bond_limits(is_open);
        setup.list_components();
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
        let bonds = (0..self.graph.bonds().len() as u32).into_par_iter().with_min_len(4096);
        bonds.map(|bond| self.graph.edge(bond).map_or(0, |(atom, neighbour)| limit(atom, neighbour))).collect()
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

    /// Finds the sets of atoms that have a choice and depend on each other.
    fn list_components(&mut self) {
        let count = self.graph.atom_count();
        let mut is_open = vec![false; count];
        for (bond, _) in self.limits.iter().enumerate().filter(|&(_, &limit)| limit > 0) {
            let bond = &self.graph.bonds()[bond];
            is_open[bond.a as usize] = true;
            is_open[bond.b as usize] = true;
        }
        self.place.resize(count, OUTSIDE);
        for start in 0..count {
            if !std::mem::replace(&mut is_open[start], false) {
                continue;
            }
            let first = self.members.len();
            self.members.push(start as u32);
            let mut at = first;
            while let Some(&atom) = self.members.get(at) {
                at += 1;
                for neighbour in self.graph.around(atom as usize) {
                    if std::mem::replace(&mut is_open[neighbour.atom as usize], false) {
                        self.members.push(neighbour.atom);
                    }
                }
            }
            self.members[first..].sort_unstable();
            for (place, &atom) in self.members[first..].iter().enumerate() {
                self.place[atom as usize] = place as u32;
            }
            self.first_member.push(self.members.len());
        }
    }

    /// The number of sets of atoms that have a choice and depend on each other.
    pub(super) fn component_count(&self) -> usize {
        self.first_member.len() - 1
    }

    /// The atoms of one of these sets in ascending order.
    fn members(&self, component: usize) -> &[u32] {
        &self.members[self.first_member[component]..self.first_member[component + 1]]
    }
}

/// The place of an atom that is in no set.
const OUTSIDE: u32 = u32::MAX;

/// States that cost more than this are left out at first: radicals, carbocations, bare nitrogen.
const USUAL_COST: f32 = 8.5;

/// Two neighbours of a component.
struct Edge {
    /// Their places among the atoms.
    places: [u32; 2],
    /// The places of their bond around each; of the other end none from [`MOST_NEIGHBOURS`] on.
    slots: [u8; 2],
    pair: Pair,
}

/// An atom beside one outside.
struct Rim {
    place: u32,
    /// The place of the bond around the atom.
    slot: u8,
    pair: Pair,
}

/// A set of atoms with their states; its memory serves one set after the other.
pub(super) struct Component<'s, 'a> {
    setup: &'s Setup<'a>,
    atoms: &'s [u32],
    /// States and their costs, one atom after the other.
    states: Vec<(State, f32)>,
    /// The states of the atom at place `i` are `first[i]..first[i + 1]`.
    first: Vec<u32>,
    edges: Vec<Edge>,
    rims: Vec<Rim>,
}

impl<'s, 'a> Component<'s, 'a> {
    /// No atoms yet.
    pub(super) fn new(setup: &'s Setup<'a>) -> Component<'s, 'a> {
        Component { setup, atoms: &[], states: Vec::new(), first: Vec::new(), edges: Vec::new(), rims: Vec::new() }
    }

    /// The states and bonds of a set of atoms.
    pub(super) fn read(&mut self, component: usize, most_cost: f32) {
        let setup = self.setup;
        let graph = &setup.graph;
        let site_of = |atom: usize| setup.sites[atom];
        self.atoms = setup.members(component);
        self.states.clear();
        self.first.clear();
        self.first.push(0);
        self.edges.clear();
        self.rims.clear();
        for (place, &atom) in self.atoms.iter().enumerate() {
            let atom = atom as usize;
            let around = graph.around(atom);
            let (hydrogens, fixed) = (setup.sites[atom].hydrogens, setup.fixed_extra(atom));
            let before = self.states.len();
            for most_cost in [most_cost, f32::INFINITY] {
                if self.states.len() == before {
                    let allowed = |slot: usize| setup.limits[around[slot].bond as usize];
                    let out = &mut self.states;
                    states::states(graph, &setup.kinds, atom, hydrogens, fixed, most_cost, allowed, out);
                }
            }
            self.first.push(self.states.len() as u32);
            for (slot, neighbour) in around.iter().enumerate().take(MOST_NEIGHBOURS) {
                let other = setup.place[neighbour.atom as usize];
                if other != OUTSIDE && other as usize <= place {
                    continue;
                }
                let pair = Pair::new(graph, &setup.kinds, &site_of, atom, slot);
                let (place, slot) = (place as u32, slot as u8);
                if other == OUTSIDE {
                    self.rims.push(Rim { place, slot, pair });
                    continue;
                }
                let back = graph.around(neighbour.atom as usize).iter().position(|back| back.bond == neighbour.bond);
                let back = back.unwrap_or(usize::MAX).min(255) as u8;
                self.edges.push(Edge { places: [place, other], slots: [slot, back], pair });
            }
        }
    }

    /// The states of the atom at a place, with their costs.
    fn states(&self, place: u32) -> &[(State, f32)] {
        &self.states[self.first[place as usize] as usize..self.first[place as usize + 1] as usize]
    }

    /// Lists the bonds and orders of a choice of states.
    fn list_orders(&self, chosen: &[u8], out: &mut Vec<(u32, u8)>) {
        let order = |edge: &Edge| {
            let (place, slot) = (edge.places[0], usize::from(edge.slots[0]));
            let bond = self.setup.graph.around(self.atoms[place as usize] as usize)[slot].bond;
            (self.setup.limits[bond as usize] > 0)
                .then(|| (bond, 1 + self.states(place)[usize::from(chosen[place as usize])].0.extra(slot)))
        };
        out.extend(self.edges.iter().filter_map(order));
    }

    /// The features of a choice of states: what the score is made of, and what the weights were fitted through.
    #[cfg(test)]
    pub(super) fn features(&self, chosen: &[u8], sink: &mut impl FnMut(u64, f32)) {
        let state = |place: u32| self.states(place)[usize::from(chosen[place as usize])].0;
        for (place, &atom) in self.atoms.iter().enumerate() {
            self.surroundings(atom as usize).features(state(place as u32), sink);
        }
        for Edge { places, slots, pair } in &self.edges {
            let [one, other] = places.map(state);
            pair.features(one.extra(usize::from(slots[0])), [one.pi, other.pi], sink);
        }
        for Rim { place, pair, .. } in &self.rims {
            pair.features(0, [state(*place).pi, 0], sink);
        }
    }

    fn surroundings(&self, atom: usize) -> Surroundings {
        Surroundings::new(&self.setup.graph, &self.setup.kinds, &|atom| self.setup.sites[atom], atom)
    }

    /// The choices with their scores by a model.
    pub(super) fn state_problem(&self, weights: &impl Weights, problem: &mut Problem) {
        let graph = &self.setup.graph;
        problem.clear();
        for (place, &atom) in self.atoms.iter().enumerate() {
            let surroundings = self.surroundings(atom as usize);
            problem.push_variable(self.states(place as u32).iter().map(|&(state, cost)| {
                let mut score = -cost;
                surroundings.features(state, &mut |feature, value| score += weights.weight(feature) * value);
                score
            }));
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
        for Rim { place, slot, pair } in &self.rims {
            let atom = self.atoms[*place as usize] as usize;
            let mut score = scores_of(pair, [atom, graph.around(atom)[usize::from(*slot)].atom as usize]);
            for (sum, (state, _)) in problem.unary_mut(*place).iter_mut().zip(self.states(*place)) {
                *sum += score(pair, 0, [state.pi, 0]);
            }
        }
        for Edge { places: [a, b], slots, pair } in &self.edges {
            let mut score = scores_of(pair, [*a, *b].map(|place| self.atoms[place as usize] as usize));
            let [slot, back] = slots.map(usize::from);
            let mut score = |one: State, other: State| {
                let extra = one.extra(slot);
                let fits = if back < MOST_NEIGHBOURS { other.extra(back) == extra } else { extra == 0 };
                if fits { score(pair, extra, [one.pi, other.pi]) } else { f32::NEG_INFINITY }
            };
            problem.push_pair(*a, *b);
            for &(one, _) in self.states(*a) {
                problem.push_scores(self.states(*b).iter().map(|&(other, _)| score(one, other)));
            }
        }
    }
}

/// Finds the best orders of one component after the other.
pub(super) struct Finder<'s, 'a> {
    component: Component<'s, 'a>,
    problem: Problem,
    solver: Solver,
    /// The bonds so far and their orders.
    pub(super) orders: Vec<(u32, u8)>,
}

impl<'s, 'a> Finder<'s, 'a> {
    /// Nothing found yet.
    pub(super) fn new(setup: &'s Setup<'a>) -> Finder<'s, 'a> {
        let component = Component::new(setup);
        Finder { component, problem: Problem::default(), solver: Solver::default(), orders: Vec::new() }
    }

    /// Adds the orders of the bonds between the atoms of a component that score best.
    pub(super) fn add_best(&mut self, component: usize, weights: &impl Weights) {
        let setup = self.component.setup;
        if let Some(pair) = diatomic(setup, setup.members(component)) {
            self.orders.push(pair);
            return;
        }
        for most_cost in [USUAL_COST, f32::INFINITY] {
            self.component.read(component, most_cost);
            self.component.state_problem(weights, &mut self.problem);
            let chosen = self.solver.solve(&self.problem);
            if most_cost == f32::INFINITY || self.problem.score(chosen).is_finite() {
                self.component.list_orders(chosen, &mut self.orders);
                return;
            }
        }
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
