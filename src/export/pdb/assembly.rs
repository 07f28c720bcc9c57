//! REMARK 350: assemblies as chains and matrices. One of parts of chains has no place there and is left out.

use super::ChainNames;
use crate::export::text::one_line;
use crate::structure::{Assembly, Structure};
use std::collections::{BTreeSet, HashMap};
use std::io::{self, Write};

/// Whether all assemblies can be written.
pub(super) fn is_whole(structure: &Structure) -> bool {
    let chains = Chains::new(structure);
    structure.assemblies().iter().all(|assembly| chains.parts(assembly).is_some())
}

/// Whether matrices have digits that the columns do not hold.
pub(super) fn is_rounded(structure: &Structure) -> bool {
    let fits = |value: f64, scale: f64| (value * scale - (value * scale).round()).abs() < 1e-9 * scale.max(value.abs());
    let mut operations = structure.assemblies().iter().flat_map(|assembly| &assembly.operations);
    operations.any(|operation| {
        let factors = operation.matrix3.to_cols_array();
        !factors.iter().all(|&x| fits(x, 1e6)) || !operation.translation.to_array().iter().all(|&x| fits(x, 1e5))
    })
}

/// The character of every residue's chain.
struct Chains<'a> {
    structure: &'a Structure,
    of_residue: Vec<u8>,
    counts: HashMap<u8, usize>,
}

impl Chains<'_> {
    fn new(structure: &Structure) -> Chains<'_> {
        let names = ChainNames::new(structure);
        let bytes: Vec<u8> = structure.chains().map(|chain| names.of(chain)).collect();
        let of = |chain: u32| bytes.get(chain as usize).copied().unwrap_or(b' ');
        let of_residue: Vec<u8> = structure.residues().iter().map(|residue| of(residue.chain)).collect();
        let mut chains = Chains { structure, of_residue, counts: HashMap::new() };
        chains.counts = chains.atoms(&[0..u32::try_from(structure.atom_count()).unwrap_or(u32::MAX)]);
        chains
    }

    /// How many atoms of these runs are in each chain.
    fn atoms(&self, runs: &[std::ops::Range<u32>]) -> HashMap<u8, usize> {
        let mut counts = HashMap::new();
        for run in runs {
            for atom in run.start as usize..(run.end as usize).min(self.structure.atom_count()) {
                let chain = self.structure.residue_index(atom).and_then(|residue| self.of_residue.get(residue));
                *counts.entry(chain.copied().unwrap_or(b' ')).or_default() += 1;
            }
        }
        counts
    }

    /// The chains of each part; `None` if one is only partly in it.
    fn parts(&self, assembly: &Assembly) -> Option<Vec<BTreeSet<u8>>> {
        let of_part = |runs: &[std::ops::Range<u32>]| {
            let found = self.atoms(runs);
            let is_whole = found.iter().all(|(chain, count)| self.counts.get(chain) == Some(count));
            is_whole.then(|| found.into_keys().collect())
        };
        assembly.parts.iter().map(|part| of_part(&part.atoms)).collect()
    }
}

/// Writes the remark.
pub(super) fn write(structure: &Structure, out: &mut dyn Write) -> io::Result<()> {
    if structure.assemblies().is_empty() {
        return Ok(());
    }
    let chains = Chains::new(structure);
    for assembly in structure.assemblies() {
        let Some(parts) = chains.parts(assembly) else { continue };
        writeln!(out, "REMARK 350")?;
        writeln!(out, "REMARK 350 BIOMOLECULE: {}", one_line(&assembly.id))?;
        let mut number = 0;
        for (part, names) in assembly.parts.iter().zip(parts) {
            let name = |byte: &u8| if *byte == b' ' { "NULL".to_owned() } else { char::from(*byte).to_string() };
            let names: Vec<String> = names.iter().map(name).collect();
            // As many as fit into 80 columns with a comma and a blank each.
            let lines = names.chunks(9).count();
            for (line, names) in names.chunks(9).enumerate() {
                let head = if line == 0 { "APPLY THE FOLLOWING TO CHAINS:" } else { "                   AND CHAINS:" };
                let comma = if line + 1 < lines { "," } else { "" };
                writeln!(out, "REMARK 350 {head} {}{comma}", names.join(", "))?;
            }
            let own = part.operations.iter().filter_map(|&index| assembly.operations.get(index as usize));
            for operation in own {
                number += 1;
                for row in 0..3 {
                    // Without the sign of what rounds to zero.
                    let [x, y, z] =
                        operation.matrix3.row(row).map(|factor| (factor * 1e6).round() / 1e6 + 0.0).to_array();
                    let shift = (operation.translation[row] * 1e5).round() / 1e5 + 0.0;
                    writeln!(out, "REMARK 350   BIOMT{}{number:>4}{x:10.6}{y:10.6}{z:10.6}{shift:15.5}", row + 1)?;
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::structure::{Assembly, AtomRecord, Diagnostics, Structure, StructureBuilder};
    use glam::{DAffine3, DMat3, DVec3};

    fn structure() -> Structure {
        let mut builder = StructureBuilder::new();
        for chain in ["A", "B", ""] {
            let (position, residue) = (DVec3::new(1.0, 2.0, 3.0), Some((chain, 1, b' ', "GLY")));
            let element = crate::element::Element::C;
            builder.push_atom(&AtomRecord { element, position, residue, name: "CA", ..AtomRecord::default() });
        }
        let mut structure = builder.build(&mut Diagnostics::default());
        let turn = DAffine3 {
            matrix3: DMat3::from_cols(
                DVec3::new(0.309017, 0.951057, 0.0),
                DVec3::new(-0.951057, 0.309017, 0.0),
                DVec3::Z,
            ),
            translation: DVec3::new(12.5, -3.25, 0.12345),
        };
        let mut first = Assembly::new("1", "");
        first.push(vec![0..2], &[DAffine3::IDENTITY, turn]);
        first.push(vec![2..3], &[turn]);
        structure.assemblies = vec![first];
        structure
    }

    #[test]
    fn the_remark_reads_back_equal() {
        let structure = structure();
        let mut text = Vec::new();
        super::super::write(std::slice::from_ref(&structure), &mut text).unwrap();
        let document = crate::import::read_bytes(&text, "a.pdb", &Default::default()).unwrap();
        assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
        assert_eq!(document.records[0].assemblies(), structure.assemblies(), "{}", String::from_utf8_lossy(&text));
        assert!(super::is_whole(&structure) && !super::is_rounded(&structure));
    }

    #[test]
    fn what_does_not_fit_is_known() {
        let mut structure = structure();
        structure.assemblies[0].operations[1].translation.x = 1.000_001;
        assert!(super::is_rounded(&structure));
        structure.assemblies[0].operations[1].matrix3 = DMat3::from_rotation_z(1.0);
        assert!(super::is_rounded(&structure) && super::is_whole(&structure));
    }
}
