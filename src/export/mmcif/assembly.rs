//! `_pdbx_struct_assembly`, `_pdbx_struct_assembly_gen` and `_pdbx_struct_oper_list`.
//!
//! The format says which chains an assembly is made of, so that one of parts of chains has no place in it and is left out.

use super::Residues;
use super::value::Value;
use crate::export::text::one_line;
use crate::structure::{Assembly, Structure};
use glam::DAffine3;
use std::collections::HashMap;
use std::io::{self, Write};

/// Whether all assemblies can be written.
pub(super) fn is_whole(structure: &Structure, residues: &Residues<'_>) -> bool {
    let counts = counts(residues);
    structure.assemblies().iter().all(|assembly| parts(structure, assembly, residues, &counts).is_some())
}

/// How many atoms each chain has, by its label.
fn counts<'r>(residues: &'r Residues<'_>) -> HashMap<&'r str, usize> {
    let mut counts = HashMap::new();
    for residue in 0..residues.count() {
        *counts.entry(residues.label_chain(residue)).or_default() += residues.atoms(residue).len();
    }
    counts
}

/// The labels of the chains of each part; `None` if a chain is only partly in one.
fn parts<'r>(
    structure: &Structure,
    assembly: &Assembly,
    residues: &'r Residues<'_>,
    counts: &HashMap<&'r str, usize>,
) -> Option<Vec<Vec<&'r str>>> {
    let of_part = |atoms: &[std::ops::Range<u32>]| {
        let mut found: HashMap<&str, usize> = HashMap::new();
        let mut order: Vec<&str> = Vec::new();
        for run in atoms {
            let end = (run.end as usize).min(structure.atom_count());
            let mut atom = run.start as usize;
            while atom < end {
                let residue = residues.index(atom);
                let last = residues.atoms(residue).end.clamp(atom + 1, end.max(atom + 1)).min(end);
                let chain = residues.label_chain(residue);
                *found.entry(chain).or_insert_with(|| {
                    order.push(chain);
                    0
                }) += last - atom;
                atom = last;
            }
        }
        // In a list they stand between commas.
        let is_whole =
            |chain: &&str| found.get(chain) == counts.get(chain) && !chain.is_empty() && !chain.contains(',');
        order.iter().all(is_whole).then_some(order)
    };
    assembly.parts.iter().map(|part| of_part(&part.atoms)).collect()
}

/// Writes them, operations that several have once.
pub(super) fn write(structure: &Structure, residues: &Residues<'_>, out: &mut dyn Write) -> io::Result<()> {
    let counts = counts(residues);
    let written: Vec<(&Assembly, Vec<Vec<&str>>)> = (structure.assemblies().iter())
        .filter_map(|assembly| Some((assembly, parts(structure, assembly, residues, &counts)?)))
        .collect();
    if written.is_empty() {
        return Ok(());
    }
    out.write_all(b"loop_\n_pdbx_struct_assembly.id\n_pdbx_struct_assembly.details\n")?;
    for (assembly, _) in &written {
        let description = one_line(&assembly.description);
        let description = if description.is_empty() { "?".to_owned() } else { Value(&description).to_string() };
        writeln!(out, "{} {description}", Value(&one_line(&assembly.id)))?;
    }
    let key = |operation: &DAffine3| operation.to_cols_array().map(f64::to_bits);
    let mut numbers: HashMap<[u64; 12], usize> = HashMap::new();
    let mut operations: Vec<&DAffine3> = Vec::new();
    out.write_all(b"#\nloop_\n")?;
    for item in ["assembly_id", "oper_expression", "asym_id_list"] {
        writeln!(out, "_pdbx_struct_assembly_gen.{item}")?;
    }
    for (assembly, parts) in &written {
        for (part, chains) in assembly.parts.iter().zip(parts) {
            let own = part.operations.iter().filter_map(|&index| assembly.operations.get(index as usize));
            let own: Vec<usize> = own
                .map(|operation| {
                    *numbers.entry(key(operation)).or_insert_with(|| {
                        operations.push(operation);
                        operations.len()
                    })
                })
                .collect();
            let (expression, chains) = (expression(&own), chains.join(","));
            writeln!(out, "{} {} {}", Value(&one_line(&assembly.id)), Value(&expression), Value(&chains))?;
        }
    }
    out.write_all(b"#\nloop_\n_pdbx_struct_oper_list.id\n")?;
    for row in 1..=3 {
        for column in 1..=3 {
            writeln!(out, "_pdbx_struct_oper_list.matrix[{row}][{column}]")?;
        }
        writeln!(out, "_pdbx_struct_oper_list.vector[{row}]")?;
    }
    for (index, operation) in operations.iter().enumerate() {
        write!(out, "{}", index + 1)?;
        for row in 0..3 {
            let [x, y, z] = operation.matrix3.row(row).to_array();
            write!(out, " {x} {y} {z} {}", operation.translation[row])?;
        }
        out.write_all(b"\n")?;
    }
    out.write_all(b"#\n")
}

/// Numbers as `1-3,5`.
fn expression(numbers: &[usize]) -> String {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == number => *last = number,
            _ => runs.push([number; 2]),
        }
    }
    let run = |[first, last]: &[usize; 2]| if first == last { first.to_string() } else { format!("{first}-{last}") };
    runs.iter().map(run).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, Diagnostics, StructureBuilder};
    use glam::DVec3;

    fn structure() -> Structure {
        let mut builder = StructureBuilder::new();
        for (chain, number) in [("A", 1), ("A", 2), ("B", 1)] {
            let position = DVec3::new(f64::from(number), 0.0, 0.0);
            builder.push_atom(&AtomRecord {
                position,
                residue: Some((chain, number, b' ', "GLY")),
                ..AtomRecord::default()
            });
        }
        let mut structure = builder.build(&mut Diagnostics::default());
        let turn = DAffine3 { translation: DVec3::new(0.1, -20.0, 0.0), ..DAffine3::from_rotation_y(0.7) };
        let shift = |x: f64| DAffine3::from_translation(DVec3::X * x);
        let mut first = Assembly::new("1", "author defined assembly, dimeric");
        first.push(vec![0..2], &[DAffine3::IDENTITY, turn]);
        first.push(vec![2..3], &[DAffine3::IDENTITY]);
        let mut second = Assembly::new("a b", "");
        second.push(vec![0..3], &[DAffine3::IDENTITY, shift(1.0), shift(2.0), turn]);
        structure.assemblies = vec![first, second];
        structure
    }

    #[test]
    fn assemblies_read_back_equal() {
        let structure = structure();
        let mut text = Vec::new();
        super::super::write(std::slice::from_ref(&structure), &mut text).unwrap();
        let document = crate::import::read_bytes(&text, "a.cif", &Default::default()).unwrap();
        assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
        assert_eq!(document.records[0].assemblies(), structure.assemblies(), "{}", String::from_utf8_lossy(&text));
        assert!(super::super::limits(&structure).is_empty());
    }

    #[test]
    fn parts_of_chains_are_left_out_and_said() {
        let mut structure = structure();
        structure.assemblies[0].parts[0].atoms = vec![0..1];
        let mut text = Vec::new();
        super::super::write(std::slice::from_ref(&structure), &mut text).unwrap();
        let document = crate::import::read_bytes(&text, "a.cif", &Default::default()).unwrap();
        let ids: Vec<&str> = document.records[0].assemblies().iter().map(|one| one.id.as_str()).collect();
        assert_eq!(ids, ["a b"]);
        assert!(super::super::limits(&structure)[0].contains("parts of chains"));
        assert_eq!(expression(&[1, 2, 3, 5, 7, 8]), "1-3,5,7-8");
    }
}
