//! Bonds that PDB files state: CONECT by serial numbers, SSBOND and LINK by residues.
//!
//! A bond repeated in one CONECT direction is a multiple bond (a habit of programs, not of the format); A→B together
//! with B→A is one bond said twice. A bond listed once is single, though wwPDB files list double bonds once too. A bond to a metal is coordination: neither CONECT nor LINK says the kind.
//!
//! Serials that more than one atom has (numbers that wrapped around) mean, for each of the atoms, its nearest partner.

use super::super::text::{Repeated, field, shown};
use crate::structure::{Bond, BondKind, BondOrder, BondSource, Diagnostics, Structure};
use std::collections::HashMap;

/// One bond of a CONECT record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Conect {
    pub(super) line: u64,
    pub(super) from: Serial,
    pub(super) to: Serial,
}

/// A serial number, and what else its digits may mean in a file with hexadecimal numbers.
pub(super) type Serial = (i32, Option<i32>);

/// How far apart atoms that share serials with others may be bonded, in ångström: longer than any bond a CONECT
/// record states (Hg–I 2.8), shorter than the distance of unrelated molecules' like atoms.
const NEAR: f32 = 3.0;
/// Steps that one file may take for its bonds, which bounds the time of hostile ones: a capsid of 3 million
/// atoms with a CONECT each takes 12 million.
const MAX_STEPS: usize = 100_000_000;

/// The steps that are left.
#[derive(Debug)]
pub(super) struct Budget(usize);

impl Default for Budget {
    fn default() -> Budget {
        Budget(MAX_STEPS)
    }
}

impl Budget {
    pub(super) fn new(steps: usize) -> Budget {
        Budget(steps)
    }

    /// Takes some steps; `false` if there are not as many left.
    pub(super) fn spend(&mut self, steps: usize) -> bool {
        let enough = steps <= self.0;
        self.0 = if enough { self.0 - steps } else { 0 };
        enough
    }
}

/// One end of a LINK or SSBOND.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LinkEnd {
    pub(super) atom: String,
    pub(super) altloc: u8,
    pub(super) residue: String,
    pub(super) chain: String,
    pub(super) number: i32,
    pub(super) insertion_code: u8,
}

/// A LINK or SSBOND record.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Link {
    pub(super) line: u64,
    pub(super) ends: [LinkEnd; 2],
    pub(super) disulfide: bool,
}

/// Whether both symmetry operators of a LINK or SSBOND are the identity (or not given): others bond to atoms that are
/// not in the file.
pub(super) fn stays_in_asymmetric_unit(line: &[u8]) -> bool {
    [field(line, 59, 65), field(line, 66, 72)].iter().all(|operator| matches!(*operator, b"" | b"1555"))
}

/// All bonds the records state between atoms of this structure.
pub(super) fn resolve(
    structure: &Structure,
    conects: &[&[Conect]],
    links: &[Link],
    budget: &mut Budget,
    diagnostics: &mut Diagnostics,
) -> Vec<Bond> {
    let mut bonds = resolve_conects(structure, conects, budget, diagnostics);
    resolve_links(structure, links, &mut bonds, budget, diagnostics);
    for bond in &mut bonds {
        let metal = |atom: u32| structure.elements().get(atom as usize).is_some_and(|element| element.is_metal());
        if metal(bond.a) != metal(bond.b) {
            bond.kind = BondKind::Coordination;
            bond.order = BondOrder::Unknown;
        }
    }
    bonds
}

fn resolve_conects(
    structure: &Structure,
    conects: &[&[Conect]],
    budget: &mut Budget,
    diagnostics: &mut Diagnostics,
) -> Vec<Bond> {
    if conects.iter().all(|list| list.is_empty()) {
        return Vec::new();
    }
    let mut by_serial: Vec<(i32, u32)> = (0..structure.atom_count())
        .map(|atom| (structure.serial(atom), u32::try_from(atom).unwrap_or(u32::MAX)))
        .collect();
    by_serial.sort_unstable();
    let atoms_of = |serial: i32| {
        let start = by_serial.partition_point(|&(other, _)| other < serial);
        let end = start + by_serial[start..].partition_point(|&(other, _)| other == serial);
        by_serial[start..end].iter().map(|&(_, atom)| atom)
    };
    let positions = structure.positions().relative();
    let (mut dangling, mut unclear) = (Repeated::default(), Repeated::default());
    let (mut directed, mut shared) = (Vec::new(), Vec::new());
    let (mut from, mut to) = (Vec::new(), Vec::new());
    for conect in conects.iter().copied().flatten() {
        if !budget.spend(1) {
            unclear.note(conect.line, too_much);
            break;
        }
        for (atoms, (serial, also)) in [(&mut from, conect.from), (&mut to, conect.to)] {
            atoms.clear();
            atoms.extend(atoms_of(serial));
            atoms.extend(also.into_iter().flat_map(atoms_of));
        }
        match (from.as_slice(), to.as_slice()) {
            ([], _) | (_, []) => dangling.note(conect.line, || {
                let serial = if from.is_empty() { conect.from.0 } else { conect.to.0 };
                format!("CONECT names serial {serial}, which no atom has; that bond is left out")
            }),
            (&[a], &[b]) => directed.push((a, b)),
            _ => {
                if !budget.spend(from.len().saturating_mul(to.len())) {
                    unclear.note(conect.line, too_much);
                    break;
                }
                nearest_pairs(&from, &to, positions, &mut shared);
            }
        }
    }
    dangling.warn(diagnostics);
    unclear.warn(diagnostics);
    count_repeats(directed, shared)
}

fn too_much() -> String {
    "too many atoms or models share the numbers of CONECT and LINK; bonds from here on are left out".to_owned()
}

/// For each atom of `from` the nearest of `to`, if it is near enough; if none is, the one nearest pair of all.
fn nearest_pairs(from: &[u32], to: &[u32], positions: &[glam::Vec3], pairs: &mut Vec<(u32, u32)>) {
    let mut best: Option<(f32, u32, u32)> = None;
    let before = pairs.len();
    for &a in from {
        let distance = |b: u32| positions[a as usize].distance(positions[b as usize]);
        let nearest = to.iter().filter(|&&b| b != a).map(|&b| (distance(b), b)).min_by(|x, y| x.0.total_cmp(&y.0));
        let Some((length, b)) = nearest else { continue };
        if length <= NEAR {
            pairs.push((a, b));
        }
        if best.is_none_or(|(shortest, ..)| length < shortest) {
            best = Some((length, a, b));
        }
    }
    if let Some((_, a, b)) = best.filter(|_| pairs.len() == before) {
        pairs.push((a, b));
    }
}

/// Bonds of directed pairs: as often as one direction is repeated is the order.
fn count_repeats(mut directed: Vec<(u32, u32)>, shared: Vec<(u32, u32)>) -> Vec<Bond> {
    directed.sort_unstable();
    let runs = directed.chunk_by(|a, b| a == b).map(|run| (run[0], run.len()));
    // Pairs from shared serials come once for every record that could mean them, so their repeats say nothing.
    let all = runs.chain(shared.into_iter().map(|pair| (pair, 1)));
    let mut counted: Vec<(u32, u32, usize)> = all.map(|((a, b), count)| (a.min(b), a.max(b), count)).collect();
    counted.sort_unstable_by_key(|&(a, b, count)| (a, b, std::cmp::Reverse(count)));
    counted.dedup_by_key(|&mut (a, b, _)| (a, b));
    let order = |count: usize| BondOrder::from_number(u32::try_from(count.min(4)).unwrap_or(4));
    counted.iter().map(|&(a, b, count)| Bond::new(a, b, order(count), BondSource::File)).collect()
}

/// Adds the bonds of LINK and SSBOND behind those of CONECT.
fn resolve_links(
    structure: &Structure,
    links: &[Link],
    bonds: &mut Vec<Bond>,
    budget: &mut Budget,
    diagnostics: &mut Diagnostics,
) {
    if links.is_empty() {
        return;
    }
    let chains: Vec<&str> = structure.chains().collect();
    let mut residues: HashMap<(&str, i32, u8), Vec<usize>> = HashMap::new();
    for (index, residue) in structure.residues().iter().enumerate() {
        let chain = chains.get(residue.chain as usize).copied().unwrap_or_default();
        residues.entry((chain, residue.number, residue.insertion_code)).or_default().push(index);
    }
    let atoms_of = |end: &LinkEnd, budget: &mut Budget| {
        let found = residues.get(&(end.chain.as_str(), end.number, end.insertion_code)).map_or(&[][..], Vec::as_slice);
        let all = structure.residues();
        let mut atoms = Vec::new();
        for &index in found.iter().filter(|&&index| structure.name(all[index].name) == end.residue) {
            let first = all[index].first_atom as usize;
            let until = all.get(index + 1).map_or(structure.atom_count(), |next| next.first_atom as usize);
            if !budget.spend(found.len() + until - first) {
                return None;
            }
            let named = (first..until)
                .filter(|&atom| structure.atom_name(atom) == end.atom)
                .filter(|&atom| end.altloc == b' ' || structure.altloc(atom) == end.altloc);
            atoms.extend(named.filter_map(|atom| u32::try_from(atom).ok()));
            // Alternate locations; more atoms of one name in one residue are an error of the file.
            atoms.truncate(16);
        }
        // Hashing the key costs about as much as eight comparisons.
        budget.spend(found.len() + 8).then_some(atoms)
    };
    let mut missing = Repeated::default();
    for link in links {
        let (Some(from), Some(to)) = (atoms_of(&link.ends[0], budget), atoms_of(&link.ends[1], budget)) else {
            missing.note(link.line, too_much);
            break;
        };
        if from.is_empty() || to.is_empty() {
            let end = &link.ends[usize::from(!from.is_empty())];
            missing.note(link.line, || {
                let LinkEnd { atom, residue, chain, number, .. } = end;
                let atom = shown(format!("{atom} of {residue} {chain} {number}").as_bytes());
                format!("the bond is left out: there is no atom {atom}")
            });
        }
        for &a in &from {
            for &b in &to {
                let [one, other] = [a, b].map(|atom| structure.altloc(atom as usize));
                if one == other || one == b' ' || other == b' ' {
                    bonds.push(Bond::new(a, b, BondOrder::Single, BondSource::Link));
                }
            }
        }
    }
    missing.warn(diagnostics);
}
