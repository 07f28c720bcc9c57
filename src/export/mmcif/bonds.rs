//! Which bonds go where: into the bonds of residue names (`_chem_comp_bond`), or one by one into `_struct_conn`.
//!
//! A bond inside a residue stands under the residue's name if every residue of that name in which both atoms occur has
//! it, with the same order. All others between atoms that can be told by their names get a row of their own. So do, beside their
//! place under the residue's name, bonds of metals, for which an order does not tell covalent from coordination: the row's
//! type does. The links of a polymer (C–N, O3'–P) that were inferred are left to the reader, as in the files of
//! the PDB. A list that is not whole (only what a file stated) is written row by row, since under a residue's name it would
//! say that there are no other bonds.

use super::Residues;
use crate::export::text::metals;
use crate::structure::{
    Bond, BondKind, BondOrder, BondSource, ComponentBond, ComponentBonds, NameId, StatedBonds, Structure,
};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Where every bond goes.
#[derive(Debug, Default)]
pub(super) struct Plan {
    pub(super) components: Vec<ComponentBonds>,
    /// Indices of the bonds with a row of their own.
    pub(super) rows: Vec<usize>,
    /// Whether bonds are left out because their atoms cannot be told by name.
    pub(super) unnamed: bool,
    /// Whether rows have orders that have no name there: aromatic without a Kekulé order, or unknown.
    pub(super) unordered: bool,
}

/// Residue name and the two atom names, the smaller first.
type Key = (NameId, NameId, NameId);

impl Plan {
    pub(super) fn new(structure: &Structure, residues: &Residues<'_>) -> Plan {
        let bonds = structure.bonds();
        let mut plan = Plan { components: structure.components().to_vec(), ..Plan::default() };
        let inside = |bond: &Bond| {
            let (a, b) = (bond.a as usize, bond.b as usize);
            let same = residues.index(a) == residues.index(b);
            let has_order = matches!(bond.kind, BondKind::Covalent | BondKind::Coordination);
            (same && has_order && !bond.is_periodic()).then(|| {
                let [a, b] = [a, b].map(|atom| residues.atom_name(atom));
                (residues.name(residues.index(bond.a as usize)), a.min(b), a.max(b))
            })
        };
        let is_whole = structure.stated_bonds() == StatedBonds::Complete
            || bonds.iter().any(|bond| matches!(bond.source, BondSource::Dictionary | BondSource::Distance));
        let stated: HashSet<Key> = keys_of(&plan.components, residues);
        let mut everywhere: BTreeMap<Key, Option<(BondOrder, bool)>> = BTreeMap::new();
        if is_whole {
            let own: HashSet<&str> = plan.components.iter().map(|component| component.name.as_str()).collect();
            for bond in bonds {
                let Some(key) = inside(bond).filter(|key| key.1 != key.2) else { continue };
                if own.contains(residues.text(key.0)) {
                    continue;
                }
                let value = match bond.kind {
                    BondKind::Coordination => (BondOrder::Single, false), // as in the component dictionary
                    _ => (bond.order, bond.aromatic),
                };
                let entry = everywhere.entry(key).or_insert(Some(value));
                if *entry != Some(value) {
                    *entry = None;
                }
            }
            drop_where_missing(&mut everywhere, residues, bonds, &inside);
        }
        for (index, bond) in bonds.iter().enumerate() {
            if bond.is_periodic() {
                continue; // `Part::PeriodicBonds` says so
            }
            let settled = inside(bond)
                .is_some_and(|key| stated.contains(&key) || everywhere.get(&key).is_some_and(|value| value.is_some()));
            if is_polymer_link(bond, residues) || (settled && !needs_kind(bond, structure)) {
                continue;
            }
            if [bond.a, bond.b].iter().all(|&atom| residues.is_unique(atom as usize)) {
                plan.unordered |=
                    bond.kind == BondKind::Covalent && (bond.order == BondOrder::Unknown || bond.aromatic);
                plan.rows.push(index);
            } else {
                plan.unnamed = true;
            }
        }
        let mut index: HashMap<NameId, usize> = HashMap::new();
        for ((residue, a, b), value) in everywhere {
            let Some((order, aromatic)) = value else { continue };
            let components = &mut plan.components;
            let at = *index.entry(residue).or_insert_with(|| {
                components.push(ComponentBonds { name: residues.text(residue).to_owned(), bonds: Vec::new() });
                components.len() - 1
            });
            let [a, b] = [a, b].map(|name| residues.text(name).to_owned());
            components[at].bonds.push(ComponentBond { a, b, order, aromatic });
        }
        plan
    }
}

/// Whether the order of a bond does not tell its kind.
fn needs_kind(bond: &Bond, structure: &Structure) -> bool {
    let is_single = bond.kind == BondKind::Covalent && bond.order == BondOrder::Single;
    bond.kind == BondKind::Coordination || (is_single && metals(structure, bond) == 1)
}

fn keys_of(components: &[ComponentBonds], residues: &Residues<'_>) -> HashSet<Key> {
    let mut keys = HashSet::new();
    for component in components {
        for bond in &component.bonds {
            let ids = [&component.name, &bond.a, &bond.b].map(|name| residues.find(name));
            if let [Some(residue), Some(a), Some(b)] = ids {
                keys.insert((residue, a.min(b), a.max(b)));
            }
        }
    }
    keys
}

/// Takes out the pairs that some residue has the atoms of, in alternate locations that go together, but not the bond.
fn drop_where_missing(
    everywhere: &mut BTreeMap<Key, Option<(BondOrder, bool)>>,
    residues: &Residues<'_>,
    bonds: &[Bond],
    inside: &impl Fn(&Bond) -> Option<Key>,
) {
    let bonded: HashSet<(u32, u32)> =
        bonds.iter().filter(|bond| inside(bond).is_some()).map(|bond| (bond.a, bond.b)).collect();
    let mut atoms: HashMap<NameId, Vec<u32>> = HashMap::new();
    for residue in 0..residues.count() {
        atoms.clear();
        for atom in residues.atoms(residue) {
            atoms.entry(residues.atom_name(atom)).or_default().push(u32::try_from(atom).unwrap_or(u32::MAX));
        }
        let of = |name: &NameId| atoms.get(name).map_or(&[][..], Vec::as_slice);
        let name = residues.name(residue);
        let lowest = NameId::default();
        for (key, value) in everywhere.range_mut((name, lowest, lowest)..) {
            if key.0 != name {
                break;
            }
            // Beside an entry that is settled already nothing is to be found; this bounds the work on odd residues.
            if value.is_none() {
                continue;
            }
            let mut pairs = of(&key.1).iter().flat_map(|&a| of(&key.2).iter().map(move |&b| (a.min(b), a.max(b))));
            if pairs.any(|(a, b)| residues.may_meet(a, b) && !bonded.contains(&(a, b))) {
                *value = None;
            }
        }
    }
}

/// An inferred link between neighbours of a chain, which every reader makes again.
fn is_polymer_link(bond: &Bond, residues: &Residues<'_>) -> bool {
    let inferred = matches!(bond.source, BondSource::Dictionary | BondSource::Distance);
    let [a, b] =
        [bond.a, bond.b].map(|atom| (residues.index(atom as usize), residues.text(residues.atom_name(atom as usize))));
    let (first, second) = if a.0 < b.0 { (a, b) } else { (b, a) };
    inferred
        && bond.kind == BondKind::Covalent
        && bond.order <= BondOrder::Single
        && first.0 + 1 == second.0
        && matches!((first.1, second.1), ("C", "N") | ("O3'", "P"))
}
