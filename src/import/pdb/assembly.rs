//! REMARK 350: biological assemblies, as chains and the matrices that are applied to them.
//!
//! ```text
//! REMARK 350 BIOMOLECULE: 1
//! REMARK 350 AUTHOR DETERMINED BIOLOGICAL UNIT: DIMERIC
//! REMARK 350 APPLY THE FOLLOWING TO CHAINS: A, B
//! REMARK 350                    AND CHAINS: C
//! REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
//! ```
//!
//! and so on: three rows an operation, several operations, perhaps further chains with operations of their own. One row that is
//! missing or wrong spoils its assembly: half of one would look like another.

use super::super::number::parse_f64;
use super::super::text::{Repeated, columns, lossy, shown};
use crate::structure::{Assembly, Structure, is_rigid};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;
use std::ops::Range;

/// Operations of all assemblies of an entry together. Chosen: as many as of an mmCIF file.
const MAX_OPERATIONS: usize = 50_000;
/// Lists of chains of all assemblies of an entry together.
const MAX_PARTS: usize = 1000;
/// Characters of a description that are kept.
const MAX_DESCRIPTION: usize = 300;

/// Whether a line belongs to it.
pub(super) fn is_line(line: &[u8]) -> bool {
    columns(line, 0, 10) == b"REMARK 350"
}

/// What is read of one assembly.
#[derive(Debug, Default)]
struct Stated {
    id: String,
    description: String,
    is_spoilt: bool,
    parts: Vec<Part>,
}

/// Chains and what is applied to them.
#[derive(Debug, Default)]
struct Part {
    chains: Vec<String>,
    /// Rows of matrices: three factors and a shift.
    rows: Vec<[f64; 4]>,
    line: u64,
}

/// The remark as far as it was read.
#[derive(Debug, Default)]
pub(super) struct Lines {
    assemblies: Vec<Stated>,
    row_count: usize,
    part_count: usize,
    chain_count: usize,
}

impl Lines {
    /// Adds a line that [`is_line`].
    pub(super) fn push(&mut self, line: &[u8], number: u64, odd: &mut Repeated) {
        let text = lossy(columns(line, 10, line.len()));
        let text = text.trim();
        if let Some(id) = text.strip_prefix("BIOMOLECULE:") {
            if self.part_count + self.assemblies.len() < MAX_PARTS {
                self.assemblies.push(Stated { id: id.trim().to_owned(), ..Stated::default() });
            } else {
                self.spoil(number, odd, || "there are too many of them".to_owned());
            }
            return;
        }
        let Some(last) = self.assemblies.last_mut() else {
            // Files that have one only may not count it.
            if text.starts_with("APPLY THE FOLLOWING") || text.starts_with("BIOMT") {
                self.assemblies.push(Stated { id: "1".to_owned(), ..Stated::default() });
                self.push(line, number, odd);
            }
            return;
        };
        if text.starts_with("BIOMT") {
            self.row(text, number, odd);
        } else if let Some((_, chains)) = text.split_once("CHAINS:") {
            if text.starts_with("APPLY") {
                self.part_count += 1;
                if self.part_count > MAX_PARTS {
                    self.spoil(number, odd, || "there are too many lists of chains".to_owned());
                    return;
                }
                last.parts.push(Part { line: number, ..Part::default() });
            }
            let Some(part) = last.parts.last_mut() else { return };
            let names = chains.split(',').map(str::trim).filter(|name| !name.is_empty());
            let before = part.chains.len();
            part.chains.extend(names.map(|name| if name == "NULL" { String::new() } else { name.to_owned() }));
            self.chain_count += part.chains.len() - before;
        } else if let Some((what, kind)) = text.split_once(':')
            && (what.ends_with("BIOLOGICAL UNIT") || what.ends_with("QUATERNARY STRUCTURE"))
            && last.description.len() + text.len() < MAX_DESCRIPTION
        {
            let words = format!("{}: {}", what.to_ascii_lowercase(), kind.trim().to_ascii_lowercase());
            if !last.description.is_empty() {
                last.description.push_str(", ");
            }
            last.description.push_str(&words);
        }
    }

    /// A row `BIOMT1   1  1.000000  0.000000  0.000000        0.00000`.
    fn row(&mut self, text: &str, number: u64, odd: &mut Repeated) {
        self.row_count += 1;
        let is_full = self.row_count > 3 * MAX_OPERATIONS;
        let Some(last) = self.assemblies.last_mut().filter(|last| !last.is_spoilt) else { return };
        let part = last.parts.last_mut();
        let axis = part.as_ref().map_or(0, |part| part.rows.len() % 3);
        match (row(text, axis).filter(|_| !is_full), part) {
            (Some(row), Some(part)) => part.rows.push(row),
            _ if is_full => self.spoil(number, odd, || format!("there are more than {MAX_OPERATIONS} operations")),
            _ => self.spoil(number, odd, || {
                let found = shown(text.as_bytes());
                format!(
                    "`{found}` is not the row expected here (BIOMT{}, a number, three factors and a shift, behind APPLY THE \
                     FOLLOWING TO CHAINS)",
                    axis + 1
                )
            }),
        }
    }

    fn spoil(&mut self, number: u64, odd: &mut Repeated, why: impl FnOnce() -> String) {
        let Some(last) = self.assemblies.last_mut() else { return };
        last.is_spoilt = true;
        let id = shown(last.id.as_bytes());
        odd.note(number, || format!("assembly {id} of REMARK 350 is left out: {}", why()));
    }

    /// Says what is wrong with operations; to be called once, when the remark is whole.
    pub(super) fn check(&mut self, odd: &mut Repeated) {
        for stated in self.assemblies.iter_mut().filter(|stated| !stated.is_spoilt) {
            for part in &stated.parts {
                if part.rows.len() % 3 != 0 || !part.operations().iter().all(is_rigid) {
                    stated.is_spoilt = true;
                    let id = shown(stated.id.as_bytes());
                    odd.note(part.line, || {
                        format!(
                            "assembly {id} of REMARK 350 is left out: its BIOMT rows are not three each, or no rotations and \
                             reflections with a shift"
                        )
                    });
                    break;
                }
            }
        }
    }

    /// How much a record takes over.
    pub(super) fn cost(&self) -> usize {
        self.row_count + self.chain_count + self.part_count
    }

    /// The assemblies of a structure.
    pub(super) fn resolve(&self, structure: &Structure) -> Vec<Assembly> {
        if self.assemblies.is_empty() {
            return Vec::new();
        }
        let mut runs: HashMap<&str, Vec<Range<u32>>> = HashMap::new();
        let residues = structure.residues();
        let chains: Vec<&str> = structure.chains().collect();
        let atom_count = u32::try_from(structure.atom_count()).unwrap_or(u32::MAX);
        for (index, residue) in residues.iter().enumerate() {
            let chain = chains.get(residue.chain as usize).copied().unwrap_or("").trim();
            let end = residues.get(index + 1).map_or(atom_count, |next| next.first_atom);
            let runs = runs.entry(chain).or_default();
            match runs.last_mut() {
                Some(last) if last.end == residue.first_atom => last.end = end,
                _ => runs.push(residue.first_atom..end),
            }
        }
        let assemblies = self.assemblies.iter().filter(|stated| !stated.is_spoilt).map(|stated| {
            let mut assembly = Assembly::new(&stated.id, &stated.description);
            for part in &stated.parts {
                let mut names: Vec<&str> = part.chains.iter().map(String::as_str).collect();
                names.sort_unstable();
                names.dedup();
                let mut atoms: Vec<Range<u32>> =
                    names.iter().filter_map(|chain| runs.get(chain)).flatten().cloned().collect();
                atoms.sort_unstable_by_key(|run| run.start);
                assembly.push(atoms, &part.operations());
            }
            assembly
        });
        assemblies.filter(|assembly| !assembly.parts.is_empty()).collect()
    }
}

impl Part {
    fn operations(&self) -> Vec<DAffine3> {
        let operation = |rows: &[[f64; 4]]| {
            let [x, y, z] = [0, 1, 2].map(|column| DVec3::new(rows[0][column], rows[1][column], rows[2][column]));
            let translation = DVec3::new(rows[0][3], rows[1][3], rows[2][3]);
            DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation }
        };
        self.rows.chunks_exact(3).map(operation).collect()
    }
}

fn row(text: &str, axis: usize) -> Option<[f64; 4]> {
    let rest = text.strip_prefix("BIOMT")?.strip_prefix(['1', '2', '3'][axis])?;
    let mut words = rest.split_ascii_whitespace();
    words.next()?;
    let mut next = || parse_f64(words.next()?.as_bytes()).map(|(value, _)| value).filter(|value| value.is_finite());
    Some([next()?, next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use crate::import::{Document, ImportOptions};
    use glam::DVec3;

    const ATOMS: &str = "ATOM      1  CA  GLY A   1       1.000   2.000   3.000  1.00  0.00           C\n\
        ATOM      2  CA  GLY B   1       4.000   2.000   3.000  1.00  0.00           C\n\
        HETATM    3  O   HOH A   2       9.000   2.000   3.000  1.00  0.00           O\nEND\n";

    fn read(remarks: &[&str]) -> Document {
        let remarks: String = remarks.iter().map(|line| format!("REMARK 350 {line}\n")).collect();
        crate::import::read_bytes((remarks + ATOMS).as_bytes(), "a.pdb", &ImportOptions::default()).unwrap()
    }

    const IDENTITY: [&str; 3] = [
        "  BIOMT1   1  1.000000  0.000000  0.000000        0.00000",
        "  BIOMT2   1  0.000000  1.000000  0.000000        0.00000",
        "  BIOMT3   1  0.000000  0.000000  1.000000        0.00000",
    ];
    const TURN: [&str; 3] = [
        "  BIOMT1   2 -1.000000  0.000000  0.000000       50.00000",
        "  BIOMT2   2  0.000000 -1.000000  0.000000        0.00000",
        "  BIOMT3   2  0.000000  0.000000  1.000000        0.00000",
    ];

    #[test]
    fn chains_and_matrices_of_several_assemblies_are_read() {
        let (apply, and) = ("APPLY THE FOLLOWING TO CHAINS: A,", "                   AND CHAINS: B");
        let head = ["BIOMOLECULE: 1", "AUTHOR DETERMINED BIOLOGICAL UNIT: DIMERIC", apply, and];
        let second = ["BIOMOLECULE: 2", "APPLY THE FOLLOWING TO CHAINS: B"];
        let third = ["APPLY THE FOLLOWING TO CHAINS: A"];
        let lines = [&head[..], &IDENTITY, &TURN, &second, &IDENTITY, &third, &TURN].concat();
        let document = read(&lines);
        let structure = &document.records[0];
        let [one, two] = structure.assemblies() else { panic!("{:?}", structure.assemblies()) };
        assert_eq!((one.id.as_str(), one.parts.len(), one.operations.len()), ("1", 1, 2));
        assert_eq!(one.description, "author determined biological unit: dimeric");
        assert_eq!(one.operations[1].transform_point3(DVec3::new(1.0, 2.0, 3.0)), DVec3::new(49.0, -2.0, 3.0));
        assert_eq!((one.atom_count(3), two.atom_count(3), two.parts.len()), (6, 3, 2));
        // The water is listed behind chain B and belongs to A.
        assert_eq!(two.parts[1].atoms, [0..1, 2..3]);
        assert_eq!(document.diagnostics.len(), 0);
    }

    #[test]
    fn a_row_that_is_wrong_or_missing_spoils_its_assembly_alone() {
        let apply = "APPLY THE FOLLOWING TO CHAINS: A";
        let good = [&["BIOMOLECULE: 2", apply][..], &IDENTITY].concat();
        let wrong = "  BIOMT2   1  0.000000  1.0x0000  0.000000        0.00000";
        let stretched = "  BIOMT1   1  2.000000  0.000000  0.000000        0.00000";
        for bad in [
            vec!["BIOMOLECULE: 1", apply, IDENTITY[0], wrong, IDENTITY[2]],
            vec!["BIOMOLECULE: 1", apply, IDENTITY[0], IDENTITY[1]],
            vec!["BIOMOLECULE: 1", apply, stretched, IDENTITY[1], IDENTITY[2]],
            vec!["BIOMOLECULE: 1", IDENTITY[0], IDENTITY[1], IDENTITY[2]],
        ] {
            let document = read(&[&bad[..], &good].concat());
            let ids: Vec<&str> = document.records[0].assemblies().iter().map(|one| one.id.as_str()).collect();
            assert_eq!((ids, document.diagnostics.len()), (vec!["2"], 1), "{bad:?}");
            assert!(document.diagnostics[0].message.contains("assembly 1 of REMARK 350"));
        }
    }

    #[test]
    fn a_remark_without_a_number_is_assembly_1() {
        let document = read(&[&["APPLY THE FOLLOWING TO CHAINS: A, B"][..], &IDENTITY].concat());
        assert_eq!(document.records[0].assembly("1").map(|one| one.atom_count(3)), Some(3));
        assert!(
            read(&["GENERATING THE BIOMOLECULE", "COORDINATES FOR A COMPLETE MULTIMER"]).records[0]
                .assemblies()
                .is_empty()
        );
    }
}
