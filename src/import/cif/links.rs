//! `_struct_conn`: bonds that a file states one by one.
//!
//! Atoms are found by the author's identifiers of their residue, narrowed by the label's, or by the label's alone where
//! the file gives no others; without an alternate location a row means all of them. Rows whose partners are in
//! different symmetry copies bond to atoms that are not listed and are left out.

use super::atoms::ResidueLabel;
use super::table::{Block, Category, Row, Table};
use crate::import::text::{Repeated, shown};
use crate::structure::{Bond, BondKind, BondOrder, BondSource, Diagnostics, NameId, Names, Structure};
use std::collections::HashMap;

/// A row.
#[derive(Debug)]
pub(super) struct Link {
    line: u64,
    kind: BondKind,
    order: BondOrder,
    ends: [End; 2],
}

/// One of its partners.
#[derive(Debug, Default)]
struct End {
    chain: Option<String>,
    number: Option<i32>,
    insertion_code: Option<u8>,
    residue: Option<String>,
    label_chain: Option<String>,
    label_number: Option<i64>,
    atoms: [Option<String>; 2],
    altloc: Option<u8>,
}

/// Residues that share chain and number are looked through up to so many: alternatives, waters with equal numbers.
const MAX_RESIDUES: usize = 256;
/// Atoms of one name in one residue: its alternate locations.
const MAX_ATOMS: usize = 16;

/// The bonds of a block; rows that are no bonds (salt bridges, mismatches) are passed over.
pub(super) fn read(block: &impl Block, diagnostics: &mut Diagnostics) -> Vec<Link> {
    let Some(table) = block.table(Category::StructConn) else { return Vec::new() };
    let mut mates = Repeated::default();
    let kind = table.column("conn_type_id");
    let order = table.column("pdbx_value_order");
    let symmetry = ["ptnr1_symmetry", "ptnr2_symmetry"].map(|item| table.column(item));
    let columns = ["1", "2"].map(|n| {
        [
            format!("ptnr{n}_auth_asym_id"),
            format!("ptnr{n}_auth_seq_id"),
            format!("pdbx_ptnr{n}_PDB_ins_code"),
            format!("ptnr{n}_auth_comp_id"),
            format!("ptnr{n}_label_comp_id"),
            format!("ptnr{n}_label_asym_id"),
            format!("ptnr{n}_label_seq_id"),
            format!("ptnr{n}_label_atom_id"),
            format!("ptnr{n}_auth_atom_id"),
            format!("pdbx_ptnr{n}_label_alt_id"),
        ]
        .map(|item| table.column(&item))
    });
    let mut links = Vec::new();
    for index in 0..table.row_count() {
        let row = table.row(index);
        let Some(kind) = row.text(kind).and_then(|kind| kind_of(&kind)) else { continue };
        let copies =
            symmetry.map(|column| row.text(column).map_or_else(|| "1_555".to_owned(), |code| code.into_owned()));
        if copies[0] != copies[1] {
            let message =
                || "the bond goes to a symmetry mate, which is not among the atoms, and is left out".to_owned();
            mates.note(row.line().unwrap_or(0), message);
            continue;
        }
        let order = match (kind, row.text(order)) {
            (BondKind::Covalent, Some(order)) => {
                super::component::order_of(&order).map_or(BondOrder::Unknown, |(order, _)| order)
            }
            _ => BondOrder::Unknown,
        };
        let ends = columns.map(
            |[chain, number, insertion, residue, label_residue, label_chain, label_number, atom, auth_atom, altloc]| {
                let text = |column| row.text(column).map(|text| text.into_owned());
                let code = |column| row.text(column).and_then(|text| text.bytes().next());
                End {
                    chain: text(chain),
                    number: row.integer(number).and_then(|number| i32::try_from(number).ok()),
                    insertion_code: code(insertion),
                    residue: text(residue).or_else(|| text(label_residue)),
                    label_chain: text(label_chain),
                    label_number: row.integer(label_number),
                    atoms: [text(atom), text(auth_atom)],
                    altloc: code(altloc),
                }
            },
        );
        links.push(Link { line: row.line().unwrap_or(0), kind, order, ends });
    }
    mates.warn(diagnostics);
    links
}

/// The kinds of `_struct_conn_type.id` that are bonds.
fn kind_of(id: &str) -> Option<BondKind> {
    let id = id.to_ascii_lowercase();
    match id.as_str() {
        "metalc" => Some(BondKind::Coordination),
        "hydrog" => Some(BondKind::Hydrogen),
        _ if id.starts_with("covale") || id == "disulf" => Some(BondKind::Covalent),
        _ => None,
    }
}

/// The residues of a structure by what rows call them.
struct Index<'s> {
    structure: &'s Structure,
    labels: &'s [ResidueLabel],
    label_names: &'s Names,
    by_author: HashMap<(NameId, i32), Vec<usize>>,
    by_label: HashMap<(NameId, Option<i64>), Vec<usize>>,
}

impl<'s> Index<'s> {
    fn new(structure: &'s Structure, labels: &'s [ResidueLabel], label_names: &'s Names) -> Index<'s> {
        let mut index = Index { structure, labels, label_names, by_author: HashMap::new(), by_label: HashMap::new() };
        for (at, residue) in structure.residues().iter().enumerate() {
            let chain = structure.chains.get(residue.chain as usize).copied().unwrap_or_default();
            let mut lists = vec![index.by_author.entry((chain, residue.number)).or_default()];
            if let Some(label) = labels.get(at) {
                lists.push(index.by_label.entry((label.chain, label.number)).or_default());
            }
            for list in lists.into_iter().filter(|list| list.len() < MAX_RESIDUES) {
                list.push(at);
            }
        }
        index
    }

    /// The atoms an end means: all alternate locations unless it names one.
    fn atoms(&self, end: &End) -> Vec<u32> {
        let mut residues = self.by_author(end);
        if residues.is_empty() {
            residues = self.by_label(end);
        }
        // Residues of one number are alternatives in one place; many are waters that the row does not tell apart.
        if residues.len() > 1 && end.number.is_none() && end.label_number.is_none() {
            return Vec::new();
        }
        let mut atoms = Vec::new();
        for &residue in &residues {
            let all = self.structure.residues();
            let first = all[residue].first_atom as usize;
            let until = all.get(residue + 1).map_or(self.structure.atom_count(), |next| next.first_atom as usize);
            let named = |atom: &usize| {
                let name = self.structure.atom_name(*atom);
                end.atoms.iter().flatten().any(|other| other == name)
                    && end.altloc.is_none_or(|altloc| self.structure.altloc(*atom) == altloc)
            };
            // No residue of a sound file has more atoms; this bounds the time of hostile ones.
            atoms.extend((first..until).take(4096).filter(named).filter_map(|atom| u32::try_from(atom).ok()));
            atoms.truncate(MAX_ATOMS);
        }
        atoms
    }

    fn by_author(&self, end: &End) -> Vec<usize> {
        let key = self.structure.names.find(end.chain.as_deref().unwrap_or("")).zip(end.number);
        let found = key.and_then(|key| self.by_author.get(&key)).map_or(&[][..], Vec::as_slice);
        let insertion_code = end.insertion_code.unwrap_or(b' ');
        let fits = |&at: &usize| self.structure.residues()[at].insertion_code == insertion_code && self.fits(end, at);
        found.iter().copied().filter(fits).collect()
    }

    fn by_label(&self, end: &End) -> Vec<usize> {
        let chain = end.label_chain.as_deref().or(end.chain.as_deref()).unwrap_or("");
        let chain = self.label_names.find(chain);
        let key = chain.map(|chain| (chain, end.label_number));
        let found = key.and_then(|key| self.by_label.get(&key)).map_or(&[][..], Vec::as_slice);
        found.iter().copied().filter(|&at| self.fits(end, at)).collect()
    }

    /// Whether residue name and label identifiers, where both are known, do not contradict.
    fn fits(&self, end: &End, at: usize) -> bool {
        let name = self.structure.name(self.structure.residues()[at].name);
        let label = self.labels.get(at);
        let chain = label.map(|label| self.label_names.get(label.chain)).filter(|chain| !chain.is_empty());
        end.residue.as_deref().is_none_or(|residue| residue == name)
            && end.label_chain.as_deref().zip(chain).is_none_or(|(one, other)| one == other)
            && end.label_number.zip(label.and_then(|label| label.number)).is_none_or(|(one, other)| one == other)
    }
}

/// The bonds that rows state between the atoms of a structure.
pub(super) fn resolve(
    links: &[Link],
    structure: &Structure,
    labels: &[ResidueLabel],
    label_names: &Names,
    missing: &mut Repeated,
) -> Vec<Bond> {
    if links.is_empty() {
        return Vec::new();
    }
    let index = Index::new(structure, labels, label_names);
    let mut bonds = Vec::new();
    for link in links {
        let [from, to] = [0, 1].map(|end| index.atoms(&link.ends[end]));
        if from.is_empty() || to.is_empty() {
            let end = &link.ends[usize::from(!from.is_empty())];
            missing.note(link.line, || {
                let text = |text: &Option<String>| text.clone().unwrap_or_else(|| "?".to_owned());
                let number = end.number.map(i64::from).or(end.label_number).map_or("?".to_owned(), |n| n.to_string());
                let chain = if end.chain.is_some() { &end.chain } else { &end.label_chain };
                let atom = if end.atoms[0].is_some() { &end.atoms[0] } else { &end.atoms[1] };
                let atom = format!("{} of {} {} {number}", text(atom), text(&end.residue), text(chain));
                format!("the bond is left out: there is no atom {}", shown(atom.as_bytes()))
            });
        }
        for &a in &from {
            for &b in &to {
                let [one, other] = [a, b].map(|atom| structure.altloc(atom as usize));
                // What a row names itself, it means.
                let named = link.ends.iter().all(|end| end.altloc.is_some());
                if named || one == other || one == b' ' || other == b' ' {
                    // Without an order it is a single bond, except to a metal, where it may be of another kind.
                    let has_metal = [a, b].iter().any(|&atom| structure.elements()[atom as usize].is_metal());
                    let is_single = link.kind == BondKind::Covalent && link.order == BondOrder::Unknown && !has_metal;
                    let order = if is_single { BondOrder::Single } else { link.order };
                    bonds.push(Bond { kind: link.kind, ..Bond::new(a, b, order, BondSource::Link) });
                }
            }
        }
    }
    bonds
}
