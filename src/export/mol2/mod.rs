//! Tripos MOL2 files.
//!
//! Every frame of every record becomes a molecule. SYBYL types follow from elements, bonds and aromaticity (see `types`);
//! a bond of unknown order that is not aromatic is `un` (`du` with a metal), coordination `un`, aromatic ones are `ar` whatever their Kekulé order.
//! Residues are substructures (name and number in one, the name again in the section, with the chain); formal charges
//! stand in UNITY_ATOM_ATTR; the cell as CRYSIN, without its space group.
//! Atoms without a name get their element and a number; a residue without a name is `UNL`.

mod types;

use super::formats::{Part, StructureFormat};
use super::text::{AtomNames, Position, frame_title, is_standard, metals, parameters, plain_bonds};
use crate::structure::{BondKind, BondOrder, Frame, Structure};
use std::io::{self, Write};
use types::Types;

/// The format's line in the table.
pub static FORMAT: StructureFormat = StructureFormat {
    name: "mol2",
    extensions: &["mol2", "ml2"],
    description: "Tripos MOL2 (all records and frames)",
    all_frames: true,
    holds: &[
        Part::Title,
        Part::FrameTitles,
        Part::Frames,
        Part::Bonds,
        Part::CoordinationBonds,
        Part::Cell,
        Part::FrameCells,
        Part::AtomNames,
        Part::Residues,
        Part::Particles,
        Part::FormalCharges,
        Part::PartialCharges,
    ],
    limits,
    write,
};

fn limits(structure: &Structure) -> Vec<&'static str> {
    let cells = || structure.frames().iter().filter_map(|frame| frame.cell.as_ref());
    let between = |bond: &crate::structure::Bond| bond.kind == BondKind::Coordination && metals(structure, bond) != 1;
    let found = [
        (cells().any(|cell| !is_standard(cell)), "the orientation of the cell"),
        (plain_bonds(structure).any(between), "coordination other than of a metal and a donor"),
    ];
    found.into_iter().filter(|(found, _)| *found).map(|(_, phrase)| phrase).collect()
}

/// Writes all frames of all records.
///
/// # Errors
/// What the writer returns, and `InvalidData` for a position that is not a number.
pub fn write(records: &[Structure], out: &mut dyn Write) -> io::Result<()> {
    for structure in records {
        let types = Types::of(structure);
        for frame in structure.frames() {
            write_molecule(structure, frame, &types, out)?;
        }
    }
    Ok(())
}

fn write_molecule(structure: &Structure, frame: &Frame, types: &Types, out: &mut dyn Write) -> io::Result<()> {
    let count = structure.atom_count();
    let residues = structure.residues();
    let bond_count = plain_bonds(structure).count();
    let title = frame_title(structure, frame);
    let charged = (0..count).any(|atom| structure.partial_charge(atom).is_some());
    writeln!(out, "@<TRIPOS>MOLECULE\n{}", if title.is_empty() { "****".to_owned() } else { shielded(&title) })?;
    writeln!(out, "{count} {bond_count} {} 0 0", residues.len())?;
    writeln!(out, "{}", if residues.len() > 1 { "BIOPOLYMER" } else { "SMALL" })?;
    writeln!(out, "{}\n", if charged { "USER_CHARGES" } else { "NO_CHARGES" })?;

    writeln!(out, "@<TRIPOS>ATOM")?;
    // The format lets them be any numbers, but not every reader does: RDKit takes them for 1, 2, 3, ….
    let id = |atom: usize| atom + 1;
    let mut names = AtomNames::new(structure);
    for (atom, kind) in types.names().iter().enumerate() {
        let [x, y, z] = Position::new(&frame.positions, atom)?.numbers(4);
        let name = names.next(atom);
        let charge = structure.partial_charge(atom).filter(|charge| charge.is_finite()).unwrap_or(0.0);
        let charge = if charged { number(charge) } else { "0.0000".to_owned() };
        let (number, residue) = match structure.residue_index(atom) {
            Some(index) => (index + 1, residue_name(structure, index)),
            None => (1, "****".to_owned()),
        };
        writeln!(
            out,
            "{:7} {name:<6} {x:>10} {y:>10} {z:>10} {kind:<5} {number:5} {residue:<8} {charge:>9}",
            id(atom)
        )?;
    }

    writeln!(out, "@<TRIPOS>BOND")?;
    for (index, bond) in plain_bonds(structure).enumerate() {
        let kind = match (bond.kind, bond.order) {
            (BondKind::Coordination, _) => "un",
            _ if bond.aromatic => "ar",
            (_, BondOrder::Single) => "1",
            (_, BondOrder::Double) => "2",
            (_, BondOrder::Triple) => "3",
            (_, BondOrder::Quadruple) => "4",
            // `un` with a metal would be coordination.
            (_, BondOrder::Unknown) if metals(structure, bond) == 1 => "du",
            (_, BondOrder::Unknown) => "un",
        };
        let [a, b] = [bond.a, bond.b].map(|atom| atom as usize);
        let kind = if types.is_amide(structure, bond) { "am" } else { kind };
        writeln!(out, "{:7} {:6} {:6} {kind}", index + 1, id(a), id(b))?;
    }

    if !residues.is_empty() {
        writeln!(out, "@<TRIPOS>SUBSTRUCTURE")?;
        let chains: Vec<&str> = structure.chains().collect();
        for (index, residue) in residues.iter().enumerate() {
            let name = word(structure.name(residue.name), "UNL");
            let chain = word(chains.get(residue.chain as usize).copied().unwrap_or(""), "****");
            let root = id(residue.first_atom as usize);
            let full = residue_name(structure, index);
            writeln!(out, "{:6} {full:<8} {root:6} RESIDUE 4 {chain} {name}", index + 1)?;
        }
    }
    if (0..count).any(|atom| structure.formal_charge(atom) != 0) {
        writeln!(out, "@<TRIPOS>UNITY_ATOM_ATTR")?;
        for atom in (0..count).filter(|&atom| structure.formal_charge(atom) != 0) {
            writeln!(out, "{} 1\ncharge {}", id(atom), structure.formal_charge(atom))?;
        }
    }
    if let Some(cell) = &frame.cell {
        let ([a, b, c], [alpha, beta, gamma]) = parameters(cell);
        // Space group 1, setting 1: what is listed is all there is.
        writeln!(out, "@<TRIPOS>CRYSIN\n{a} {b} {c} {alpha} {beta} {gamma} 1 1")?;
    }
    out.write_all(b"\n")
}

/// A title that is no comment and no head of a section.
fn shielded(title: &str) -> String {
    if title.starts_with(['#', '@']) || title == "****" { format!(" {title}") } else { title.to_owned() }
}

/// All digits of a charge, at least four decimals.
fn number(value: f32) -> String {
    let short = format!("{value:.4}");
    if short.parse() == Ok(value) { short } else { value.to_string() }
}

/// A text as one word.
fn word(text: &str, empty: &str) -> String {
    let text = text.trim();
    if text.is_empty() {
        return empty.to_owned();
    }
    text.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect()
}

/// Name, number and insertion code in one.
fn residue_name(structure: &Structure, index: usize) -> String {
    let Some(residue) = structure.residues().get(index) else { return "****".to_owned() };
    let name = word(structure.name(residue.name), "UNL");
    let code = if residue.insertion_code.is_ascii_graphic() {
        char::from(residue.insertion_code).to_string()
    } else {
        String::new()
    };
    format!("{name}{}{code}", residue.number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, Bond, BondSource, Cell, Diagnostics, StructureBuilder};
    use glam::DVec3;

    #[test]
    fn all_sections_are_written() {
        let mut builder = StructureBuilder::new();
        builder.set_decimals(2);
        builder.set_title("# acetamide");
        builder.set_cell(Cell::from_parameters([4.0, 5.5, 6.0], [90.0, 95.0, 90.0]));
        for (element, x, name) in [(Element::C, 0.0, "C1"), (Element::O, 1.25, ""), (Element::N, -1.25, "N X")] {
            builder.push_atom(&AtomRecord {
                element,
                position: DVec3::new(x, 0.0, 0.0),
                name,
                residue: Some(("", 7, b'A', "SO4")),
                partial_charge: Some(0.125),
                formal_charge: i8::from(element == Element::N),
                ..AtomRecord::default()
            });
        }
        builder.push_bond(Bond::new(0, 1, BondOrder::Double, BondSource::File));
        builder.push_bond(Bond::new(0, 2, BondOrder::Single, BondSource::File));
        let got = crate::export::tests::written(|out| write(&[builder.build(&mut Diagnostics::default())], out));
        let expected = concat!(
            "@<TRIPOS>MOLECULE\n # acetamide\n3 2 1 0 0\nSMALL\nUSER_CHARGES\n\n@<TRIPOS>ATOM\n",
            "      1 C1         0.0000     0.0000     0.0000 C.2       1 SO47A       0.1250\n",
            "      2 O1         1.2500     0.0000     0.0000 O.2       1 SO47A       0.1250\n",
            "      3 N_X       -1.2500     0.0000     0.0000 N.am      1 SO47A       0.1250\n",
            "@<TRIPOS>BOND\n      1      1      2 2\n      2      1      3 am\n",
            "@<TRIPOS>SUBSTRUCTURE\n     1 SO47A         1 RESIDUE 4 **** SO4\n",
            "@<TRIPOS>UNITY_ATOM_ATTR\n3 1\ncharge 1\n@<TRIPOS>CRYSIN\n4 5.5 6 90 95 90 1 1\n\n",
        );
        assert_eq!(got, expected);
    }
}
