//! `info --explain-bonds`: every bond with its reason, and near pairs that are none.

use super::args::BondArgs;
use super::load::bond_options;
use super::report::printable;
use crate::bonds::{Explained, NotBonded, explain, not_bonded};
use crate::structure::Structure;
use serde::Serialize;
use std::fmt::Write as _;

/// The bonds of a structure, explained.
#[derive(Debug, Serialize)]
pub(super) struct Explanations {
    bond_list: Vec<BondLine>,
    not_bonded: Vec<NearLine>,
}

#[derive(Debug, Serialize)]
struct BondLine {
    atoms: [u32; 2],
    labels: [String; 2],
    /// Ångström, to 0.001.
    length: f64,
    order: u8,
    kind: &'static str,
    aromatic: bool,
    source: &'static str,
    reason: String,
    #[serde(skip)]
    order_name: &'static str,
}

#[derive(Debug, Serialize)]
struct NearLine {
    atoms: [u32; 2],
    labels: [String; 2],
    length: f64,
    reason: &'static str,
}

impl Explanations {
    /// Explains the bonds of the first frame.
    pub(super) fn new(structure: &Structure, args: BondArgs) -> Explanations {
        let options = bond_options(args);
        let bond_list = explain(structure, 0, &options).into_iter().map(|explained| bond_line(structure, explained));
        let near_line = |pair: NotBonded| NearLine {
            atoms: [pair.a, pair.b],
            labels: [label(structure, pair.a), label(structure, pair.b)],
            length: rounded(pair.length),
            reason: pair.reason,
        };
        let not_bonded = not_bonded(structure, 0, &options).into_iter().map(near_line);
        Explanations { bond_list: bond_list.collect(), not_bonded: not_bonded.collect() }
    }

    /// One line a bond, for people.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        for BondLine { labels: [a, b], length, order_name, kind, source, reason, .. } in &self.bond_list {
            let line = format!("  {a} – {b}  {length:.3} Å  {order_name}  {kind}  {source}  ({reason})");
            let _ = writeln!(text, "{}", printable(&line)); // writing to a String cannot fail
        }
        for NearLine { labels: [a, b], length, reason, .. } in &self.not_bonded {
            let _ = writeln!(text, "{}", printable(&format!("  {a} · {b}  {length:.3} Å  not bonded  ({reason})")));
        }
        text
    }
}

fn bond_line(structure: &Structure, explained: Explained) -> BondLine {
    let bond = explained.bond;
    BondLine {
        atoms: [bond.a, bond.b],
        labels: [label(structure, bond.a), label(structure, bond.b)],
        length: rounded(explained.length),
        order: bond.order.number(),
        kind: bond.kind.name(),
        aromatic: bond.aromatic,
        source: bond.source.name(),
        order_name: explained.order_name(),
        reason: explained.reason,
    }
}

fn rounded(length: f32) -> f64 {
    (f64::from(length) * 1000.0).round() / 1000.0
}

/// `A:HEM154:FE`, with `/B` for an alternate location; `C7`, the element and the atom's number, in files without residues.
fn label(structure: &Structure, atom: u32) -> String {
    let atom = atom as usize;
    let symbol = structure.elements().get(atom).map_or("X", |element| element.symbol());
    let name = structure.atom_name(atom);
    let mut text = String::new();
    if let Some(residue) = structure.residue_index(atom).and_then(|index| structure.residues().get(index)) {
        let chain = structure.chains().nth(residue.chain as usize).unwrap_or_default();
        let code =
            if residue.insertion_code == b' ' { String::new() } else { char::from(residue.insertion_code).into() };
        let _ = write!(text, "{chain}:{}{}{code}:", structure.name(residue.name), residue.number);
    } else if name.is_empty() {
        return format!("{symbol}{}", atom + 1);
    }
    text.push_str(if name.is_empty() { symbol } else { name });
    if structure.altloc(atom) != b' ' {
        let _ = write!(text, "/{}", char::from(structure.altloc(atom)));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::args::BondsArg;
    use super::*;
    use crate::import::{ImportOptions, read_bytes};

    #[test]
    fn a_bond_says_where_it_comes_from() {
        let pdb = "\
ATOM      1  N   GLY A   1       0.000   0.000   0.000  1.00  0.00           N
ATOM      2  CA  GLY A   1       1.458   0.000   0.000  1.00  0.00           C
ATOM      3  C   GLY A   1       2.009   1.420   0.000  1.00  0.00           C
ATOM      4  N   ALA A   2       3.332   1.536   0.000  1.00  0.00           N
ATOM      5  C1 ALIG B   1      10.000   0.000   0.000  0.50  0.00           C
ATOM      6  C1 BLIG B   1      10.000   0.900   0.000  0.50  0.00           C
ATOM      7  O1  LIG B   1      11.400   0.400   0.000  1.00  0.00           O
";
        let document = read_bytes(pdb.as_bytes(), "a.pdb", &ImportOptions::default()).unwrap();
        let bonds = BondArgs { bonds: BondsArg::Auto, hbonds: false, no_hbonds: false };
        let text = Explanations::new(&document.records[0], bonds).text();
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        assert_eq!(
            lines,
            [
                "A:GLY1:N – A:GLY1:CA  1.458 Å  single  covalent  dictionary  (dictionary: GLY)",
                "A:GLY1:CA – A:GLY1:C  1.523 Å  single  covalent  dictionary  (dictionary: GLY)",
                "A:GLY1:C – A:ALA2:N  1.328 Å  single  covalent  dictionary  (dictionary: peptide link)",
                "B:LIG1:C1/A – B:LIG1:O1  1.456 Å  single  covalent  distance  (distance: 1.46 Å ≤ 0.76+0.66+0.45)",
                "B:LIG1:C1/B – B:LIG1:O1  1.487 Å  single  covalent  distance  (distance: 1.49 Å ≤ 0.76+0.66+0.45)",
                "B:LIG1:C1/A · B:LIG1:C1/B  0.900 Å  not bonded  (alternate locations)",
            ]
        );
    }
}
