//! The covalent graph of the heavy nonmetals, with what else each of them holds.

use crate::element::Element;
use crate::structure::{Bond, BondKind, ByAtom, Cell};
use glam::{Mat3, Vec3};

/// A neighbour of an atom.
#[derive(Debug, Clone, Copy)]
pub(super) struct Neighbour {
    /// The other atom.
    pub(super) atom: u32,
    /// The index of the bond.
    pub(super) bond: u32,
}

/// Heavy nonmetals and their covalent bonds; hydrogens and metals are counted at their partners.
pub(super) struct Graph<'a> {
    pub(super) elements: &'a [Element],
    positions: &'a [Vec3],
    bonds: &'a [Bond],
    lattice: Option<Mat3>,
    around: ByAtom<Neighbour>,
    held: Vec<Held>,
    /// Nonmetals and their coordination bonds to metals, sorted.
    to_metals: Vec<(u32, u32)>,
}

/// What an atom holds beside its heavy neighbours.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Held {
    /// Hydrogens.
    pub(super) hydrogens: u8,
    /// Partners by coordination or dative bonds: no valence.
    pub(super) metals: u8,
    /// Electron pairs shared with metals and dummies.
    pub(super) others: u8,
}

/// Whether an atom is a vertex of the graph.
pub(super) fn is_heavy(element: Element) -> bool {
    element != Element::DUMMY && element != Element::H && !element.is_metal()
}

impl<'a> Graph<'a> {
    /// The graph of these bonds. `positions` may be empty: then there is no geometry. Bonds to atoms that are not there
    /// are none.
    pub(super) fn new(
        elements: &'a [Element],
        positions: &'a [Vec3],
        bonds: &'a [Bond],
        cell: Option<&Cell>,
    ) -> Graph<'a> {
        let count = elements.len();
        let mut held = vec![Held::default(); count];
        let mut to_metals = Vec::new();
        let is_edge = |bond: &Bond| is_edge(elements, bond);
        for (index, bond) in bonds.iter().enumerate() {
            let ends = [bond.a as usize, bond.b as usize];
            if ends.iter().any(|&end| end >= count) || ends[0] == ends[1] || bond.kind == BondKind::Hydrogen {
                continue;
            }
            if is_edge(bond) {
                continue;
            }
            for (end, other) in [(ends[0], ends[1]), (ends[1], ends[0])] {
                let held = &mut held[end];
                let (slot, count) = match elements[other] {
                    Element::H => (&mut held.hydrogens, 1),
                    _ if is_shared(bond) => (&mut held.others, bond.order.number().max(1)),
                    _ => (&mut held.metals, 1),
                };
                *slot = slot.saturating_add(count);
                if !is_shared(bond) && is_heavy(elements[end]) && elements[other].is_metal() {
                    to_metals.push((end as u32, index as u32));
                }
            }
        }
        // Indices: 16 bytes a bond, below 2^32.
        let edges = || (0u32..).zip(bonds).filter(|(_, bond)| is_edge(bond));
        let around = ByAtom::new(count, || {
            edges().flat_map(|(bond, &Bond { a, b, .. })| {
                [(a, Neighbour { atom: b, bond }), (b, Neighbour { atom: a, bond })]
            })
        });
        let is_periodic = bonds.iter().any(Bond::is_periodic);
        let lattice = cell.filter(|_| is_periodic).map(|cell| cell.cartesian_from_fractional().as_mat3());
        let positions = if positions.len() == count { positions } else { &[] };
        to_metals.sort_unstable();
        Graph { elements, positions, bonds, lattice, around, held, to_metals }
    }

    /// The number of atoms, hydrogens and metals too.
    pub(super) fn atom_count(&self) -> usize {
        self.elements.len()
    }

    /// Whether there are positions.
    pub(super) fn has_geometry(&self) -> bool {
        !self.positions.is_empty()
    }

    /// All bonds, those that are no edges too.
    pub(super) fn bonds(&self) -> &'a [Bond] {
        self.bonds
    }

    /// An edge as the atom of lower index has it; `None` for a bond that is no edge.
    pub(super) fn edge(&self, bond: u32) -> Option<(usize, Neighbour)> {
        let ends = &self.bonds[bond as usize];
        let (low, high) = (ends.a.min(ends.b), ends.a.max(ends.b));
        is_edge(self.elements, ends).then_some((low as usize, Neighbour { atom: high, bond }))
    }

    /// The heavy neighbours of an atom.
    pub(super) fn around(&self, atom: usize) -> &[Neighbour] {
        self.around.of(atom)
    }

    /// The number of heavy neighbours.
    pub(super) fn degree(&self, atom: usize) -> usize {
        self.around(atom).len()
    }

    /// What an atom holds beside them.
    pub(super) fn held(&self, atom: usize) -> Held {
        self.held[atom]
    }

    /// The metals that an atom gives electrons to.
    pub(super) fn metals(&self, atom: usize) -> impl Iterator<Item = Neighbour> + '_ {
        let first = self.to_metals.partition_point(|&(other, _)| (other as usize) < atom);
        let own = self.to_metals[first..].iter().take_while(move |&&(other, _)| other as usize == atom);
        own.map(move |&(_, bond)| {
            let ends = &self.bonds[bond as usize];
            Neighbour { atom: if ends.a as usize == atom { ends.b } else { ends.a }, bond }
        })
    }

    /// From an atom to its neighbour; zero without geometry.
    pub(super) fn vector(&self, from: usize, to: Neighbour) -> Vec3 {
        if self.positions.is_empty() {
            return Vec3::ZERO;
        }
        let between = self.positions[to.atom as usize] - self.positions[from];
        let bond = &self.bonds[to.bond as usize];
        match &self.lattice {
            Some(lattice) if bond.is_periodic() => {
                let shift = *lattice * Vec3::from_array(bond.image.map(f32::from));
                if bond.a as usize == from { between + shift } else { between - shift }
            }
            _ => between,
        }
    }
}

/// Whether a bond is an edge of the graph.
fn is_edge(elements: &[Element], bond: &Bond) -> bool {
    let heavy = |atom: u32| elements.get(atom as usize).is_some_and(|&element| is_heavy(element));
    is_shared(bond) && bond.a != bond.b && heavy(bond.a) && heavy(bond.b)
}

/// Whether a bond is an electron pair to which both atoms gave; a dative one is a donor's, as that to a metal.
fn is_shared(bond: &Bond) -> bool {
    bond.kind == BondKind::Covalent
}
