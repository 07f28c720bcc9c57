//! Molecules of any size for measuring: the same atoms every time.
//!
//! A chain is folded row by row into a ball, every atom 1.5 Å from the next and every second one to the side, rows
//! 3.6 Å apart: 0.06 atoms per Å³, as heavy atoms in a protein, and one bond an atom. All atoms are moved a little, so
//! that no coordinate repeats.

#![allow(dead_code, reason = "each bench uses a part of it")]
#![allow(clippy::expect_used, reason = "without the file there is nothing to measure")]

pub(crate) mod bcif;

use ballstick::element::Element;
use ballstick::structure::{AtomRecord, Diagnostics, Structure, StructureBuilder};
use glam::DVec3;
use std::fmt::Write;

/// The sizes all benches measure.
pub(crate) const SIZES: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// Elements along the chain, about as frequent as in a protein.
const ELEMENTS: [&str; 8] = ["N", "C", "C", "O", "C", "C", "N", "S"];
/// Atoms of a residue.
const RESIDUE: usize = 8;

/// Å between neighbours along a row, how far every second atom is to the side, and between rows.
const STEP: f64 = 1.27;
const ASIDE: f64 = 0.8;
const ROW: f64 = 3.6;

/// Symbol and position of each atom.
pub(crate) fn atoms(count: usize) -> Vec<(&'static str, DVec3)> {
    // A ball that holds a few more, cut to the count.
    let volume = STEP * ROW * ROW * (count as f64 * 1.1 + 60.0);
    let radius = (volume * 0.75 / std::f64::consts::PI).cbrt();
    let rows = (radius / ROW) as i64 + 1;
    let mut atoms = Vec::with_capacity(count);
    for layer in -rows..=rows {
        for row in -rows..=rows {
            // Back and forth: the next row begins where this one ends.
            let row = if layer % 2 == 0 { row } else { -row };
            let forward = (layer + row) % 2 == 0;
            let (y, z) = (row as f64 * ROW, layer as f64 * ROW);
            let half = (radius * radius - y * y - z * z).max(0.0).sqrt();
            let steps = (half / STEP) as i64;
            for step in -steps..=steps {
                if atoms.len() == count {
                    return atoms;
                }
                let step = if forward { step } else { -step };
                let aside = if step % 2 == 0 { 0.0 } else { ASIDE };
                let n = atoms.len();
                let position = DVec3::new(step as f64 * STEP, y + aside, z) + shift(n as u64);
                atoms.push((ELEMENTS[n % ELEMENTS.len()], position));
            }
        }
    }
    atoms
}

/// Up to 0.06 Å in each direction, to three decimals as files have them.
fn shift(n: u64) -> DVec3 {
    let mix = (n + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let part = |bits: u64| ((mix >> bits) % 121) as f64 * 1e-3 - 0.06;
    DVec3::new(part(8), part(24), part(40))
}

/// Residue number and its place in the four digits that PDB has.
fn residue(n: usize) -> usize {
    n / RESIDUE % 9999 + 1
}

/// The atoms as a structure, without bonds.
pub(crate) fn structure(count: usize) -> Structure {
    let mut builder = StructureBuilder::new();
    builder.set_decimals(3);
    for (n, (symbol, position)) in atoms(count).into_iter().enumerate() {
        builder.push_atom(&AtomRecord {
            element: Element::from_symbol(symbol).unwrap_or_default(),
            position,
            name: symbol,
            residue: Some(("A", residue(n) as i32, b' ', "UNL")),
            ..AtomRecord::default()
        });
    }
    builder.build(&mut Diagnostics::default())
}

/// Copies of crambin (`data/1crn.pdb`, 327 atoms) side by side, cut to the count, without bonds.
pub(crate) fn protein(count: usize) -> Structure {
    let text = include_bytes!("../../data/1crn.pdb");
    let mut document = ballstick::import::read_bytes(text, "1crn.pdb", &Default::default()).expect("it is sound");
    let crambin = document.records.remove(0);
    let edge = (1..).find(|edge| edge * edge * edge * crambin.atom_count() >= count).unwrap_or(1);
    let mut builder = StructureBuilder::new();
    builder.set_decimals(3);
    for n in 0..count {
        let (copy, atom) = (n / crambin.atom_count(), n % crambin.atom_count());
        let place = DVec3::new((copy % edge) as f64, (copy / edge % edge) as f64, (copy / edge / edge) as f64);
        let residue = crambin.residue_index(atom).map(|index| crambin.residues()[index]).expect("it has residues");
        // Chains of one copy after the other: the last residue of one is not linked to the first of the next.
        let chain = ["A", "B"][copy % 2];
        builder.push_atom(&AtomRecord {
            element: crambin.elements()[atom],
            position: crambin.positions().get(atom) + place * 35.0,
            name: crambin.atom_name(atom),
            residue: Some((chain, residue.number, b' ', crambin.name(residue.name))),
            ..AtomRecord::default()
        });
    }
    builder.build(&mut Diagnostics::default())
}

/// The atoms as PDB text: hybrid-36 is not needed, serials wrap as many programs let them.
pub(crate) fn pdb(count: usize) -> String {
    let mut text = String::with_capacity(count * 81);
    for (n, (symbol, p)) in atoms(count).into_iter().enumerate() {
        let (serial, residue) = (n % 99_999 + 1, residue(n));
        let _ = writeln!(
            text,
            "ATOM  {serial:5}  {symbol:<3} UNL A{residue:4}    {:8.3}{:8.3}{:8.3}  1.00 20.00          {symbol:>2}  ",
            p.x, p.y, p.z
        );
    }
    text.push_str("END\n");
    text
}

/// The atoms as mmCIF text, with the columns that the PDB gives out.
pub(crate) fn cif(count: usize) -> String {
    let mut text = String::with_capacity(count * 100);
    text.push_str("data_bench\n#\nloop_\n");
    for item in [
        "group_PDB",
        "id",
        "type_symbol",
        "label_atom_id",
        "label_alt_id",
        "label_comp_id",
        "label_asym_id",
        "label_entity_id",
        "label_seq_id",
        "pdbx_PDB_ins_code",
        "Cartn_x",
        "Cartn_y",
        "Cartn_z",
        "occupancy",
        "B_iso_or_equiv",
        "pdbx_formal_charge",
        "auth_seq_id",
        "auth_comp_id",
        "auth_asym_id",
        "auth_atom_id",
        "pdbx_PDB_model_num",
    ] {
        let _ = writeln!(text, "_atom_site.{item}");
    }
    for (n, (symbol, p)) in atoms(count).into_iter().enumerate() {
        let residue = residue(n);
        let _ = writeln!(
            text,
            "ATOM {:<7} {symbol} {symbol:<4} . UNL A 1 {residue:<4} ? {:.3} {:.3} {:.3} 1.00 20.00 ? {residue:<4} UNL A {symbol:<4} 1",
            n + 1,
            p.x,
            p.y,
            p.z
        );
    }
    text.push_str("#\n");
    text
}

/// The atoms as XYZ text.
pub(crate) fn xyz(count: usize) -> String {
    let mut text = format!("{count}\na folded chain\n");
    for (symbol, p) in atoms(count) {
        let _ = writeln!(text, "{symbol} {:.3} {:.3} {:.3}", p.x, p.y, p.z);
    }
    text
}

/// The atoms as SD records (V2000) of 50 atoms, as in a file of small molecules, the chain as their bonds.
pub(crate) fn sdf(count: usize) -> String {
    let mut text = String::with_capacity(count * 90);
    for (record, atoms) in atoms(count).chunks(50).enumerate() {
        let _ = writeln!(text, "chain {record}\n  bench\n");
        let _ = writeln!(text, "{:3}{:3}  0  0  0  0            999 V2000", atoms.len(), atoms.len() - 1);
        for (symbol, p) in atoms {
            let zeros = "  0".repeat(11);
            let _ = writeln!(text, "{:10.4}{:10.4}{:10.4} {symbol:<3} 0{zeros}", p.x, p.y, p.z);
        }
        for n in 1..atoms.len() {
            let _ = writeln!(text, "{n:3}{:3}  1  0", n + 1);
        }
        text.push_str("M  END\n$$$$\n");
    }
    text
}

/// The atoms as one V3000 record, the chain as its bonds.
pub(crate) fn v3000(count: usize) -> String {
    let mut text = String::from("chain\n  bench\n\n  0  0  0     0  0            999 V3000\nM  V30 BEGIN CTAB\n");
    let _ = writeln!(text, "M  V30 COUNTS {count} {} 0 0 0\nM  V30 BEGIN ATOM", count - 1);
    for (n, (symbol, p)) in atoms(count).into_iter().enumerate() {
        let _ = writeln!(text, "M  V30 {} {symbol} {:.4} {:.4} {:.4} 0", n + 1, p.x, p.y, p.z);
    }
    text.push_str("M  V30 END ATOM\nM  V30 BEGIN BOND\n");
    for n in 1..count {
        let _ = writeln!(text, "M  V30 {n} 1 {n} {}", n + 1);
    }
    text.push_str("M  V30 END BOND\nM  V30 END CTAB\nM  END\n$$$$\n");
    text
}

/// The atoms as one MOL2 molecule with residues and charges, the chain as its bonds.
pub(crate) fn mol2(count: usize) -> String {
    let mut text =
        format!("@<TRIPOS>MOLECULE\nchain\n{count} {} 0\nPROTEIN\nUSER_CHARGES\n\n@<TRIPOS>ATOM\n", count - 1);
    for (n, (symbol, p)) in atoms(count).into_iter().enumerate() {
        let (atom, substructure, residue) = (n + 1, n / RESIDUE + 1, residue(n));
        let _ = writeln!(
            text,
            "{atom:7} {symbol:<4} {:10.4} {:10.4} {:10.4} {symbol}.3 {substructure:6} UNL{residue} -0.1250",
            p.x, p.y, p.z
        );
    }
    text.push_str("@<TRIPOS>BOND\n");
    for n in 1..count {
        let _ = writeln!(text, "{n:7} {n:7} {:7} 1", n + 1);
    }
    text
}

/// The atoms as our own JSON list, the chain as its bonds.
pub(crate) fn json(count: usize) -> String {
    let mut text = String::from("{\"atoms\":[");
    for (n, (symbol, p)) in atoms(count).into_iter().enumerate() {
        let comma = if n == 0 { "" } else { "," };
        let _ = write!(text, "{comma}{{\"element\":\"{symbol}\",\"position\":[{:.3},{:.3},{:.3}]}}", p.x, p.y, p.z);
    }
    text.push_str("],\"bonds\":[");
    for n in 1..count {
        let comma = if n == 1 { "" } else { "," };
        let _ = write!(text, "{comma}{{\"atoms\":[{},{n}],\"order\":1}}", n - 1);
    }
    text.push_str("]}\n");
    text
}

/// The atoms as a POSCAR of one element, in Cartesian coordinates.
pub(crate) fn poscar(count: usize) -> String {
    let mut text = format!("a folded chain\n1.0\n900 0 0\n0 900 0\n0 0 900\nC\n{count}\nCartesian\n");
    for (_, p) in atoms(count) {
        let _ = writeln!(text, "{:19.16} {:19.16} {:19.16}", p.x, p.y, p.z);
    }
    text
}

/// The atoms as a cube file with a grid of nothing.
pub(crate) fn cube(count: usize) -> String {
    let mut text = format!("a folded chain\n\n{count} 0.0 0.0 0.0\n-1 1.0 0.0 0.0\n1 0.0 1.0 0.0\n1 0.0 0.0 1.0\n");
    for (symbol, p) in atoms(count) {
        let z = Element::from_symbol(symbol).unwrap_or_default().z();
        let _ = writeln!(text, "{z:5} {:11.6} {:11.6} {:11.6} {:11.6}", f64::from(z), p.x, p.y, p.z);
    }
    text.push_str("0.0\n");
    text
}

/// The atoms as a GRO file without velocities.
pub(crate) fn gro(count: usize) -> String {
    let mut text = format!("a folded chain\n{count}\n");
    for (n, (symbol, p)) in atoms(count).into_iter().enumerate() {
        let p = p * 0.1;
        let (residue, serial) = (residue(n), (n + 1) % 100_000);
        let _ = writeln!(text, "{residue:5}{:<5}{symbol:>5}{serial:5}{:8.3}{:8.3}{:8.3}", "UNL", p.x, p.y, p.z);
    }
    text.push_str("90.0 90.0 90.0\n");
    text
}
