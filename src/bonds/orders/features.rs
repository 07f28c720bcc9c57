//! What speaks for and against a state of an atom and of a pair of neighbours: features, each with a weight of the model.
//!
//! A feature is a number of a few packed facts. Every feature comes in a coarse form, of which the training set has
//! many, and in finer ones that only correct it, so that what was never seen is judged by the coarse facts and by
//! [`super::lengths`].

use super::graph::Graph;
use super::lengths;
use super::sites::{NO_RING, RingKinds, Site, angle_interval, is_flat_ring, twist};
use super::states::{MOST_NEIGHBOURS, State};

/// Where the weights come from.
pub(super) trait Weights {
    /// The weight of a feature, 0 if it has none.
    fn weight(&self, feature: u64) -> f32;
}

/// Packs facts of at most so many bits each.
fn pack(kind: u64, facts: &[(u64, u32)]) -> u64 {
    facts.iter().fold(0, |key, &(value, bits)| key << bits | value) | kind << 60
}

/// Surroundings coarser than ring kinds: none, five, six, fused, other.
fn coarse_ring(kind: u8) -> u64 {
    match kind {
        NO_RING => 0,
        2 | 3 => 1,
        5 | 6 => 2,
        10 | 11 => 3,
        4 | 7 => 4,
        _ => 5,
    }
}

/// What is the same for all states of an atom.
pub(super) struct Surroundings {
    site: Site,
    degree: usize,
    has_geometry: bool,
    /// One and the element of each neighbour, whether it is an end, and whether the bond is in a flat ring.
    codes: [u64; MOST_NEIGHBOURS],
    /// The same in ascending order.
    sorted_codes: [u64; MOST_NEIGHBOURS],
    /// What is seen of each neighbour of three: element, rings, and the interval of the angle opposite to its bond.
    opposite: [[u64; 3]; 3],
}

impl Surroundings {
    /// Reads an atom.
    pub(super) fn new(
        graph: &Graph<'_>,
        kinds: &RingKinds,
        site_of: &impl Fn(usize) -> Site,
        atom: usize,
    ) -> Surroundings {
        let around = graph.around(atom);
        let mut codes = [0u64; MOST_NEIGHBOURS];
        for (code, neighbour) in codes.iter_mut().zip(around) {
            let beside = site_of(neighbour.atom as usize);
            let is_end = beside.degree == 1;
            let in_ring = u64::from(is_flat_ring(kinds.bond(neighbour.bond)));
            *code = (u64::from(beside.element) << 2 | u64::from(is_end) << 1 | in_ring) + 1;
        }
        let mut sorted_codes = codes;
        sorted_codes.sort_unstable();
        let mut opposite = [[0; 3]; 3];
        if around.len() == 3 && graph.has_geometry() {
            // The angle opposite to a double bond is narrow.
            opposite = std::array::from_fn(|slot| {
                let angle = angle_interval(graph, atom, (slot + 1) % 3, (slot + 2) % 3);
                let beside = site_of(around[slot].atom as usize);
                [u64::from(beside.element), coarse_ring(kinds.bond(around[slot].bond)), u64::from(angle)]
            });
        }
        let has_geometry = graph.has_geometry();
        Surroundings { site: site_of(atom), degree: around.len(), has_geometry, codes, sorted_codes, opposite }
    }

    /// The features of the atom in one state: each is passed to `sink` with its value.
    pub(super) fn features(&self, state: State, sink: &mut impl FnMut(u64, f32)) {
        let site = self.site;
        let (class, pi, ring) = (site.class(), u64::from(state.pi), u64::from(site.ring));
        sink(pack(1, &[(class, 10), (pi, 3), (ring, 4)]), 1.0);
        sink(
            pack(
                2,
                &[
                    (u64::from(site.element), 4),
                    (u64::from(site.degree), 3),
                    (pi, 3),
                    (coarse_ring(site.ring), 3),
                    (u64::from(site.shape), 4),
                ],
            ),
            1.0,
        );
        // The neighbours, and which of them has the extra pairs.
        let extra = |slot: usize| u64::from(state.extra(slot));
        let partners: u64 = self.codes.iter().enumerate().map(|(slot, code)| code * extra(slot) * 67).sum();
        let step = |mix: u64, &code: &u64| mix.wrapping_mul(0x9E37_79B9).wrapping_add(code);
        let mix = self.sorted_codes.iter().fold(partners, step) & 0xFFFF_FFFF;
        sink(pack(3, &[(class, 10), (pi, 3), (mix, 32)]), 1.0);
        if self.degree == 3 && (state.pi == 0 || state.sum() == 1) && self.has_geometry {
            for (slot, &[element, ring, angle]) in self.opposite.iter().enumerate() {
                let facts = [
                    (u64::from(site.element), 4),
                    (element, 4),
                    (extra(slot), 1),
                    (u64::from(state.pi != 0), 1),
                    (coarse_ring(site.ring), 3),
                    (ring, 3),
                    (angle, 4),
                ];
                sink(pack(4, &facts), 1.0);
            }
        }
    }
}

/// What is the same for all states of two neighbours.
pub(super) struct Pair {
    sites: [Site; 2],
    ring: u8,
    twist: u8,
    /// Length in ångström.
    length: f32,
    /// Knots of [`lengths::knots`] around the length.
    knots: [(u8, f32); 2],
    offset: f32,
}

impl Pair {
    /// Reads the bond from an atom to its neighbour in a place.
    pub(super) fn new(
        graph: &Graph<'_>,
        kinds: &RingKinds,
        site_of: &impl Fn(usize) -> Site,
        atom: usize,
        slot: usize,
    ) -> Pair {
        let to = graph.around(atom)[slot];
        let length = graph.vector(atom, to).length();
        let single = lengths::expected(graph.elements[atom], graph.elements[to.atom as usize], 1);
        let offset = length - single;
        Pair {
            sites: [site_of(atom), site_of(to.atom as usize)],
            ring: kinds.bond(to.bond),
            twist: twist(graph, atom, slot),
            length,
            knots: lengths::knots(offset),
            offset: ((offset + 0.08) * 10.0).clamp(-2.5, 2.5),
        }
    }

    /// Length in ångström.
    pub(super) fn length(&self) -> f32 {
        self.length
    }

    /// The features of the pair with so many extra pairs on its bond and these kinds of extra pairs on its atoms.
    pub(super) fn features(&self, extra: u8, pi: [u8; 2], sink: &mut impl FnMut(u64, f32)) {
        let [a, b] = self.sites;
        let end = |site: Site, pi: u8| (site.class() << 3) | u64::from(pi);
        let (mut one, mut other) = ((end(a, pi[0]), a, pi[0]), (end(b, pi[1]), b, pi[1]));
        if one.0 > other.0 {
            std::mem::swap(&mut one, &mut other);
        }
        let extra = u64::from(extra);
        let coarse = coarse_ring(self.ring);
        let element = |end: (u64, Site, u8)| u64::from(end.1.element) << 1 | u64::from(end.2 != 0);
        let (low, high) = (element(one).min(element(other)), element(one).max(element(other)));
        for (knot, share) in self.knots {
            sink(pack(5, &[(low, 5), (high, 5), (extra, 2), (coarse, 3), (u64::from(knot), 4)]), share);
        }
        sink(pack(6, &[(low, 5), (high, 5), (extra, 2), (coarse, 3), (u64::from(self.twist), 3)]), 1.0);
        let medium =
            |end: (u64, Site, u8)| u64::from(end.1.element) << 6 | u64::from(end.1.degree) << 3 | u64::from(end.2);
        let (low, high) = (medium(one).min(medium(other)), medium(one).max(medium(other)));
        let facts = [(low, 10), (high, 10), (extra, 2)];
        sink(pack(7, &facts), 1.0);
        sink(pack(8, &facts), self.offset);
        sink(pack(9, &facts), self.offset * self.offset);
    }
}
