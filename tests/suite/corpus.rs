//! Real files against what independent readers find in them.
//!
//! `BALLSTICK_CORPUS` names a folder with `good/truth.jsonl` and `bad/truth.jsonl`, one JSON object a line, beside the
//! files they speak of. Unset, the tests print SKIP. Where the readers behind the truth disagree, [`DECIDED`] says
//! what we hold right, and why.

use crate::files;
use ballstick::Error;
use ballstick::import::{Document, Format, ImportOptions, read_path};
use ballstick::structure::{BondKind, BondSource, Severity, StatedBonds, Structure};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// File, what, our number, reason.
const DECIDED: [(&str, &str, u64, &str); 1] = [(
    "pdb1tw7_step3_charmm2namd_doubled_hex.pdb.gz",
    "residues",
    15_832,
    "the truth compares the text of the numbers, in which hexadecimal 2710 (10000) is decimal 2710; the same file with \
     hybrid-36 numbers has 15832",
)];

/// File, elements as the truth has them, elements as we hold right, number of atoms, reason.
const DECIDED_ELEMENTS: [(&str, &str, &str, u64, &str); 2] = [
    ("pdb1tw7_step3_charmm2namd_doubled_h36.pdb.gz", "C", "Cl", 16, CHLORIDE),
    ("pdb1tw7_step3_charmm2namd_doubled_hex.pdb.gz", "C", "Cl", 16, CHLORIDE),
];
const CHLORIDE: &str =
    "CLA in a residue CLA is CHARMM's chloride; most readers see a carbon in the column of the letter";

/// Bad files that are sound as far as a reader can tell, with the reason.
const NOTHING_TO_SAY: [(&str, &str); 2] = [
    ("real-fuzz_regress-ant-2026-00770.sdf", "a carbon with seven bonds: odd chemistry, but what the file states"),
    ("real-fuzz_regress-cve-2026-2704.cif", "its odd table is `_chemical_conn_bond`, which is not read"),
];

/// Good files with a truth that says nothing of them, with the reason.
const NOT_KNOWN: [(&str, &str); 1] =
    [("components.cif", "none of the readers behind the truth reads the `_chem_comp_atom` of its three records")];

fn rows(folder: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(folder.join("truth.jsonl")).expect("the corpus has a truth.jsonl");
    text.lines().map(|line| serde_json::from_str(line).expect("truth.jsonl holds one JSON object a line")).collect()
}

/// Collects what differs.
struct Differences(Vec<String>);

impl Differences {
    fn compare<T: PartialEq + std::fmt::Debug>(&mut self, file: &str, what: &str, got: T, want: T) {
        if got != want {
            self.0.push(format!("{file}: {what}: got {got:?}, want {want:?}"));
        }
    }
}

/// The truth's number, or ours where its readers disagree.
fn number(row: &Value, file: &str, what: &str) -> Option<u64> {
    let decided = DECIDED.iter().find(|(name, of, ..)| *name == file && *of == what);
    decided.map(|decided| decided.2).or_else(|| row[what].as_u64())
}

/// Symbols to counts, hydrogen's isotopes as hydrogen, what is no element as X.
fn elements(row: &Value) -> BTreeMap<String, u64> {
    let mut histogram = BTreeMap::new();
    for (symbol, count) in row["elements"].as_object().into_iter().flatten() {
        let element = ballstick::element::Element::from_symbol(symbol).map_or("X", |element| element.symbol());
        *histogram.entry(element.to_owned()).or_default() += count.as_u64().unwrap_or(0);
    }
    for (_, from, to, count, _) in DECIDED_ELEMENTS.iter().filter(|(name, ..)| row["file"] == *name) {
        *histogram.entry((*from).to_owned()).or_default() -= count;
        *histogram.entry((*to).to_owned()).or_default() += count;
    }
    histogram
}

fn compare(row: &Value, file: &str, document: &Document, differences: &mut Differences) {
    let first: &Structure = &document.records[0];
    let count = |number: usize| number as u64;
    if let Some(atoms) = number(row, file, "atoms") {
        differences.compare(file, "atoms", count(first.atom_count()), atoms);
    }
    let frames = number(row, file, "models_or_frames").unwrap_or(1);
    differences.compare(file, "frames", count(document.frame_count()), frames);
    let mut histogram = BTreeMap::new();
    for element in first.elements() {
        *histogram.entry(element.symbol().to_owned()).or_default() += 1;
    }
    differences.compare(file, "elements", histogram, elements(row));
    if let Some(chains) = number(row, file, "chains") {
        differences.compare(file, "chains", count(first.chains().len()), chains);
    }
    if let Some(residues) = number(row, file, "residues") {
        let distinct: BTreeSet<_> =
            first.residues().iter().map(|r| (r.chain, r.number, r.insertion_code, r.name)).collect();
        differences.compare(file, "residues", count(distinct.len()), residues);
    }
    if let Some(bonds) = number(row, file, "explicit_bonds") {
        let listed = match first.stated_bonds() {
            StatedBonds::Complete => first.bonds().len(),
            // Of a CIF the truth counts all rows of `_struct_conn` but the hydrogen bonds.
            _ if document.format == Format::Mmcif => {
                first.bonds().iter().filter(|bond| bond.kind != BondKind::Hydrogen).count()
            }
            _ => first.bonds().iter().filter(|bond| bond.source == BondSource::File).count(),
        };
        differences.compare(file, "stated bonds", count(listed), bonds);
    }
    if let Some(want) = row["cell"].as_array() {
        let want: Vec<f64> = want.iter().filter_map(Value::as_f64).collect();
        let got = first.cell().map(|cell| [cell.lengths(), cell.angles_deg()].concat()).unwrap_or_default();
        let near = got.len() == want.len() && got.iter().zip(&want).all(|(got, want)| (got - want).abs() < 2e-3);
        differences.compare(file, "cell", near.then_some(want.clone()), Some(want));
    } else if row["has_cell"] == Value::Bool(false) {
        differences.compare(file, "cell", first.cell().is_some(), false);
    }
    // For PDB and MOL2 files the truth holds the charges that its readers infer, not what the file says.
    let inferred = row["format"] == "pdb" || row["format"] == "mol2";
    if let Some(charges) = row["formal_charges"].as_array().filter(|_| !inferred) {
        let want: Vec<(usize, i64)> = charges
            .iter()
            .filter_map(|pair| Some((usize::try_from(pair[0].as_u64()?).ok()?, pair[1].as_i64()?)))
            .collect();
        let got: Vec<(usize, i64)> = (0..first.atom_count())
            .map(|atom| (atom, i64::from(first.formal_charge(atom))))
            .filter(|&(_, charge)| charge != 0)
            .collect();
        // The truth gives the first few.
        differences.compare(file, "charges", &got[..got.len().min(want.len())], &want[..]);
    }
}

#[test]
fn good_files_hold_what_independent_readers_find() {
    let Some(folder) = files::corpus("good") else { return };
    let mut differences = Differences(Vec::new());
    let mut compared = 0;
    for row in rows(&folder) {
        let file = row["file"].as_str().expect("every row names its file");
        match read_path(&folder.join(file), &ImportOptions::default()) {
            Ok(_) if NOT_KNOWN.iter().any(|(name, _)| *name == file) => {}
            Ok(document) => {
                compare(&row, file, &document, &mut differences);
                compared += 1;
            }
            Err(error) => differences.0.push(format!("{file}: {error}")),
        }
    }
    println!("compared {compared} files");
    assert!(compared > 0, "nothing was compared");
    assert!(differences.0.is_empty(), "{:#?}", differences.0);
}

#[test]
fn bad_files_are_refused_or_read_in_part() {
    let Some(folder) = files::corpus("bad") else { return };
    let (mut compared, mut wrong) = (0, Vec::new());
    for row in rows(&folder) {
        let file = row["file"].as_str().expect("every row names its file");
        let expect = row["expect"].as_str().expect("every row says what to expect");
        let result = read_path(&folder.join(file), &ImportOptions::default());
        let fine = match (expect, &result) {
            ("partial" | "ok", Err(Error::Unsupported(_))) => false,
            ("error" | "partial", Err(_)) => true,
            // What a cut archive still holds is shown, with an error.
            ("error", Ok(document)) => {
                // The truth itself says that a generous reader may read it.
                row["what"].as_str().is_some_and(|what| what.contains("may be read"))
                    || file.contains("truncated") && document.diagnostics.iter().any(|d| d.severity == Severity::Error)
            }
            ("partial", Ok(document)) => {
                !document.diagnostics.is_empty() || NOTHING_TO_SAY.iter().any(|(name, _)| *name == file)
            }
            ("ok", Ok(document)) => document.diagnostics.iter().all(|d| d.severity == Severity::Warning),
            _ => false,
        };
        compared += 1;
        if !fine {
            let got = result.map(|document| (document.frame_count(), document.diagnostics));
            wrong.push(format!("{file}: want {expect}, got {got:?}"));
        }
    }
    println!("compared {compared} files");
    assert!(compared > 0, "nothing was compared");
    assert!(wrong.is_empty(), "{wrong:#?}");
}
