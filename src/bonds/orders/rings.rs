//! Small rings: the shortest ones through each bond.
//!
//! For every bond of the ring systems all shortest rings through it are taken, up to [`LARGEST_RING`] atoms. That is the
//! symmetrised smallest set of rings wherever each ring of that set has a bond of its own shortest length, which no
//! molecule of small rings misses; large rings whose bonds all lie in smaller ones (the inner ring of coronene's
//! relatives, cycloparaphenylene) are not listed.

use super::graph::Graph;
use crate::stop::Stop;
use glam::Vec3;
use rayon::prelude::*;

/// Atoms of the largest ring that is looked for.
pub(super) const LARGEST_RING: usize = 8;
/// Rings of equal length taken through one bond: more is a cage, of which these are enough.
const MOST_THROUGH_BOND: usize = 6;
/// Atoms visited from one bond before it counts as ringless: a ball of eight bonds in diamond has 500.
const MOST_VISITED: usize = 2_000;

/// A ring: atoms and bonds in order, bond `i` from atom `i` to the next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Ring {
    pub(crate) atoms: Vec<u32>,
    pub(crate) bonds: Vec<u32>,
}

impl Ring {
    /// Number of atoms.
    pub(super) fn len(&self) -> usize {
        self.atoms.len()
    }

    /// Root mean square distance of the atoms from their plane in ångström.
    pub(super) fn unevenness(&self, graph: &Graph<'_>) -> f32 {
        let mut points = vec![Vec3::ZERO];
        for (i, &atom) in self.atoms.iter().enumerate().take(self.len() - 1) {
            let last = points[i];
            let step = graph.around(atom as usize).iter().find(|neighbour| neighbour.bond == self.bonds[i]);
            points.push(last + step.map_or(Vec3::ZERO, |&neighbour| graph.vector(atom as usize, neighbour)));
        }
        let center = points.iter().sum::<Vec3>() / points.len() as f32;
        let next = |i: usize| points[(i + 1) % points.len()] - center;
        let normal = (0..points.len()).map(|i| (points[i] - center).cross(next(i))).sum::<Vec3>().normalize_or_zero();
        let squares = points.iter().map(|&point| (point - center).dot(normal).powi(2)).sum::<f32>();
        (squares / points.len() as f32).sqrt()
    }
}

/// What a search needs beside the graph; made once a thread.
#[derive(Default)]
struct Search {
    queue: Vec<u32>,
    /// Steps from the start, [`UNSEEN`] for what is not in `queue`.
    steps: Vec<u8>,
}

const UNSEEN: u8 = u8::MAX;

/// The rings among the atoms for which `takes_part` holds, each once, in an order that depends on the atoms only.
/// If it is given up, some are missing.
pub(super) fn find(
    graph: &Graph<'_>,
    takes_part: impl Fn(usize) -> bool + Sync,
    largest: usize,
    stop: &Stop,
) -> Vec<Ring> {
    let core = core(graph, takes_part);
    let is_in = |atom: usize| core[atom] >= 2;
    let starts: Vec<u32> = (0..graph.atom_count()).filter(|&atom| is_in(atom)).map(|atom| atom as u32).collect();
    let mut rings: Vec<Ring> = starts
        .par_chunks(512)
        .map_init(Search::default, |search, chunk| {
            search.steps.resize(graph.atom_count(), UNSEEN);
            let mut rings = Vec::new();
            let chunk = if stop.is_set() { &[] } else { chunk };
            for &atom in chunk {
                for neighbour in graph.around(atom as usize) {
                    if neighbour.atom > atom && is_in(neighbour.atom as usize) {
                        search.through(graph, &is_in, atom, *neighbour, largest, &mut rings);
                    }
                }
            }
            rings
        })
        .flatten_iter()
        .collect();
    let key = |ring: &Ring| {
        let mut bonds = ring.bonds.clone();
        bonds.sort_unstable();
        bonds
    };
    rings.sort_by_cached_key(|ring| (ring.len(), key(ring)));
    rings.dedup_by_key(|ring| key(ring));
    rings
}

/// For every atom the number of neighbours left when all ends are cut off until none is left: 2 and more in rings and
/// between them.
fn core(graph: &Graph<'_>, takes_part: impl Fn(usize) -> bool) -> Vec<u8> {
    let count = graph.atom_count();
    let mut left = vec![0u8; count];
    for atom in (0..count).filter(|&atom| graph.degree(atom) >= 2 && takes_part(atom)) {
        left[atom] = graph.degree(atom).min(255) as u8;
    }
    // Neighbours that never took part do not count.
    let mut ends = Vec::new();
    for atom in 0..count {
        if left[atom] > 0 {
            let missing = graph.around(atom).iter().filter(|neighbour| left[neighbour.atom as usize] == 0).count();
            left[atom] = left[atom].saturating_sub(missing.min(255) as u8).max(1);
            if left[atom] < 2 {
                ends.push(atom);
            }
        }
    }
    while let Some(end) = ends.pop() {
        if left[end] == 0 {
            continue;
        }
        left[end] = 0;
        for neighbour in graph.around(end) {
            let next = neighbour.atom as usize;
            if left[next] > 0 {
                left[next] -= 1;
                if left[next] < 2 {
                    left[next] = left[next].max(1);
                    ends.push(next);
                }
            }
        }
    }
    left
}

impl Search {
    /// Adds the shortest rings through a bond.
    fn through(
        &mut self,
        graph: &Graph<'_>,
        is_in: &impl Fn(usize) -> bool,
        from: u32,
        to: super::graph::Neighbour,
        largest: usize,
        rings: &mut Vec<Ring>,
    ) {
        for &atom in &self.queue {
            self.steps[atom as usize] = UNSEEN;
        }
        // From `to` outwards until `from` is met.
        self.queue.clear();
        self.queue.push(to.atom);
        self.steps[to.atom as usize] = 0;
        let mut at = 0;
        let mut found = None;
        while let Some(&atom) = self.queue.get(at) {
            at += 1;
            let steps = self.steps[atom as usize];
            if usize::from(steps) + 1 >= largest || found.is_some_and(|found| steps >= found) {
                break;
            }
            if self.queue.len() > MOST_VISITED {
                return;
            }
            for neighbour in graph.around(atom as usize) {
                if neighbour.bond == to.bond || !is_in(neighbour.atom as usize) {
                    continue;
                }
                if neighbour.atom == from {
                    found = Some(steps + 1);
                } else if self.steps[neighbour.atom as usize] == UNSEEN {
                    self.steps[neighbour.atom as usize] = steps + 1;
                    self.queue.push(neighbour.atom);
                }
            }
        }
        let Some(found) = found else { return };
        // Back from `from` by falling steps, every way.
        let mut paths: Vec<(Vec<u32>, Vec<u32>)> = vec![(vec![from], Vec::new())];
        for left in (0..found).rev() {
            let mut longer = Vec::new();
            for (atoms, bonds) in &paths {
                let last = atoms.last().copied().unwrap_or(from);
                for neighbour in graph.around(last as usize) {
                    let falls = self.steps[neighbour.atom as usize] == left;
                    if falls && neighbour.bond != to.bond && longer.len() < MOST_THROUGH_BOND {
                        let (mut atoms, mut bonds) = (atoms.clone(), bonds.clone());
                        atoms.push(neighbour.atom);
                        bonds.push(neighbour.bond);
                        longer.push((atoms, bonds));
                    }
                }
            }
            paths = longer;
        }
        rings.extend(paths.into_iter().map(|(atoms, mut bonds)| {
            bonds.push(to.bond);
            Ring { atoms, bonds }
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{Bond, BondOrder, BondSource};

    fn sizes(atoms: usize, pairs: &[(u32, u32)]) -> Vec<usize> {
        let bonds: Vec<Bond> =
            pairs.iter().map(|&(a, b)| Bond::new(a, b, BondOrder::Single, BondSource::File)).collect();
        let elements = vec![Element::C; atoms];
        let graph = Graph::new(&elements, &[], &bonds, None);
        find(&graph, |_| true, LARGEST_RING, &Stop::never()).iter().map(Ring::len).collect()
    }

    #[test]
    fn fused_bridged_and_cage_rings_are_found_once_each() {
        let six = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (0, 5)];
        assert_eq!(sizes(6, &six), [6]);
        let naphthalene = [&six[..], &[(4, 6), (6, 7), (7, 8), (8, 9), (5, 9)]].concat();
        assert_eq!(sizes(10, &naphthalene), [6, 6]);
        let norbornane = [&six[..], &[(0, 6), (3, 6)]].concat();
        assert_eq!(sizes(7, &norbornane), [5, 5]);
        let cubane: Vec<(u32, u32)> =
            (0..8u32).flat_map(|i| [1, 2, 4].map(|bit| (i, i ^ bit))).filter(|&(a, b)| a < b).collect();
        assert_eq!(sizes(8, &cubane), [4; 6]);
        let chain: Vec<(u32, u32)> = (0..9).map(|i| (i, i + 1)).collect();
        assert_eq!(sizes(10, &chain), [0; 0]);
        let large: Vec<(u32, u32)> = (0..9).map(|i| (i.min((i + 1) % 9), i.max((i + 1) % 9))).collect();
        assert_eq!(sizes(9, &large), [0; 0]);
    }
}
