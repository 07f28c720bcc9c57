//! Chemical JSON, version 1, as Avogadro reads it: the first record, further frames as coordinate sets.
//!
//! The unit cell has lengths, angles and `cellVectors`, which are exact. Aromatic bonds have the order of their Kekulé
//! form, 1.5 where none is known; bonds of unknown order and coordination have 0. What has no element is number 0.

use super::formats::{Part, StructureFormat, title};
use super::json::{Number, Text};
use super::text::{Position, one_line, parameters, plain_bonds};
use crate::structure::{BondOrder, Frame, Structure};
use std::io::{self, Write};

/// The format's line in the table.
pub static FORMAT: StructureFormat = StructureFormat {
    name: "cjson",
    extensions: &["cjson"],
    description: "Chemical JSON (the first record with all its frames)",
    all_frames: false,
    holds: &[
        Part::Title,
        Part::Frames,
        Part::Bonds,
        Part::Cell,
        Part::AtomNames,
        Part::Particles,
        Part::FormalCharges,
        Part::PartialCharges,
    ],
    limits: super::formats::no_limits,
    write: |records, out| records.first().map_or(Ok(()), |structure| write(structure, out)),
};

/// Writes a structure.
///
/// # Errors
/// What the writer returns, and `InvalidData` for a position that is not a number (JSON has none for it).
pub fn write(structure: &Structure, out: &mut dyn Write) -> io::Result<()> {
    let count = structure.atom_count();
    write!(out, "{{\n\"chemicalJson\": 1,\n\"name\": {},\n", Text(&one_line(title(structure))))?;
    out.write_all(b"\"atoms\": {\n\"elements\": {\"number\": [")?;
    write_list(structure.elements().iter().map(|element| element.z()), out)?;
    out.write_all(b"]},\n\"coords\": {\"3d\": [")?;
    if let Some(first) = structure.frames().first() {
        write_positions(first, out)?;
    }
    out.write_all(b"]")?;
    if structure.frames().len() > 1 {
        out.write_all(b",\n\"3dSets\": [")?;
        for (index, frame) in structure.frames().iter().enumerate() {
            out.write_all(if index == 0 { b"\n[" } else { b",\n[" })?;
            write_positions(frame, out)?;
            out.write_all(b"]")?;
        }
        out.write_all(b"]")?;
    }
    out.write_all(b"}")?;
    if Part::FormalCharges.is_in(structure) {
        out.write_all(b",\n\"formalCharges\": [")?;
        write_list((0..count).map(|atom| structure.formal_charge(atom)), out)?;
        out.write_all(b"]")?;
    }
    if (0..count).any(|atom| !structure.atom_name(atom).is_empty()) {
        out.write_all(b",\n\"labels\": [")?;
        write_list((0..count).map(|atom| Text(structure.atom_name(atom))), out)?;
        out.write_all(b"]")?;
    }
    out.write_all(b"\n},\n\"bonds\": {\"connections\": {\"index\": [")?;
    write_list(plain_bonds(structure).flat_map(|bond| [bond.a, bond.b]), out)?;
    out.write_all(b"]},\n\"order\": [")?;
    write_list(
        plain_bonds(structure).map(|bond| match bond.order {
            BondOrder::Unknown if bond.aromatic => "1.5".to_owned(),
            order => order.number().to_string(),
        }),
        out,
    )?;
    out.write_all(b"]}")?;
    if Part::PartialCharges.is_in(structure) {
        out.write_all(b",\n\"partialCharges\": {\"charges\": [")?;
        write_list(
            (0..count).map(|atom| Number(structure.partial_charge(atom).filter(|c| c.is_finite()).unwrap_or(0.0))),
            out,
        )?;
        out.write_all(b"]}")?;
    }
    if let Some(cell) = structure.cell() {
        let ([a, b, c], [alpha, beta, gamma]) = parameters(cell);
        write!(out, ",\n\"unitCell\": {{\"a\": {a}, \"b\": {b}, \"c\": {c}, ")?;
        write!(out, "\"alpha\": {alpha}, \"beta\": {beta}, \"gamma\": {gamma}, \"cellVectors\": [")?;
        write_list(cell.vectors().iter().flat_map(|vector| vector.to_array()).map(|x| x + 0.0), out)?;
        out.write_all(b"]}")?;
    }
    out.write_all(b"\n}\n")
}

fn write_list<T: std::fmt::Display>(items: impl Iterator<Item = T>, out: &mut dyn Write) -> io::Result<()> {
    for (index, item) in items.enumerate() {
        let separator = if index == 0 { "" } else { ", " };
        write!(out, "{separator}{item}")?;
    }
    Ok(())
}

fn write_positions(frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    for atom in 0..frame.positions.len() {
        let [x, y, z] = Position::new(&frame.positions, atom)?.numbers(0);
        let separator = if atom == 0 { "" } else { ", " };
        write!(out, "{separator}{x}, {y}, {z}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, Bond, BondSource, Cell, Diagnostics, StructureBuilder};
    use glam::DVec3;
    use serde_json::{Value, json};

    #[test]
    fn columns_sets_and_cell_are_written() {
        let mut builder = StructureBuilder::new();
        builder.set_decimals(2);
        builder.set_cell(Cell::from_vectors(DVec3::new(0.0, 2.0, 0.0), DVec3::X, DVec3::Z * 3.0));
        builder.push_atom(&AtomRecord { element: Element::C, name: "C1", formal_charge: -1, ..AtomRecord::default() });
        builder.push_atom(&AtomRecord { position: DVec3::new(1.25, 0.0, 0.0), ..AtomRecord::default() });
        let bond = Bond::new(0, 1, BondOrder::Unknown, BondSource::File);
        builder.push_bond(Bond { aromatic: true, ..bond });
        assert!(builder.push_frame(&[DVec3::ZERO, DVec3::Y], None, ""));
        let mut bytes = Vec::new();
        write(&builder.build(&mut Diagnostics::default()), &mut bytes).unwrap();
        let got: Value = serde_json::from_slice(&bytes).unwrap();
        let expected = json!({
            "chemicalJson": 1, "name": "", "atoms": {
                "elements": {"number": [6, 0]}, "formalCharges": [-1, 0], "labels": ["C1", ""],
                "coords": {"3d": [0.0, 0.0, 0.0, 1.25, 0.0, 0.0],
                           "3dSets": [[0.0, 0.0, 0.0, 1.25, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]]}
            },
            "bonds": {"connections": {"index": [0, 1]}, "order": [1.5]},
            "unitCell": {"a": 2, "b": 1, "c": 3, "alpha": 90, "beta": 90, "gamma": 90,
                         "cellVectors": [0, 2, 0, 1, 0, 0, 0, 0, 3]}
        });
        assert_eq!(got, expected);
    }
}
