//! Molecules of any size for measuring: the same atoms every time.
//!
//! A chain is folded row by row into a ball, every atom 1.5 Å from the next and every second one to the side, rows
//! 3.6 Å apart: 0.06 atoms per Å³, as heavy atoms in a protein, and one bond an atom. All atoms are moved a little, so
//! that no coordinate repeats.

#![allow(dead_code, reason = "each bench uses a part of it")]
#![allow(clippy::expect_used, reason = "without the file there is nothing to measure")]

pub(crate) mod bcif;

use ballstick::element::Element;
use ballstick::export::formats::StructureFormat;
use ballstick::structure::{AtomRecord, Bond, BondOrder, BondSource, Diagnostics, Structure, StructureBuilder};
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

/// The atoms as a file of this format as the program writes it; without bonds where a structure's own are not listed as
/// a rule, else with the chain as its bonds, and in SDF as records of 50 atoms, as in a file of small molecules.
pub(crate) fn written(format: &str, count: usize) -> Vec<u8> {
    let whole = structure(count);
    let records = match format {
        "pdb" | "cif" | "xyz" => vec![whole],
        "sdf" => (0..count).step_by(50).map(|first| chain(&whole, first..count.min(first + 50))).collect(),
        _ => vec![chain(&whole, 0..count)],
    };
    let format = StructureFormat::from_name(format).expect("a format that is written");
    let mut file = Vec::new();
    (format.write)(&records, &mut file).expect("memory takes everything");
    file
}

/// Some of the atoms, each bonded to the next.
fn chain(whole: &Structure, atoms: std::ops::Range<usize>) -> Structure {
    let sources: Vec<(u32, DVec3)> = atoms.map(|atom| (atom as u32, whole.positions().get(atom))).collect();
    let bonds = (1..sources.len() as u32).map(|n| Bond::new(n - 1, n, BondOrder::Single, BondSource::File)).collect();
    whole.gather(&sources, None).with_bonds(bonds)
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
