//! XYZ: a count, a comment, then symbol and position of every atom, frame after frame.
//!
//! With a unit cell the comment is that of extended XYZ (`Lattice="…" Properties=species:S:1:pos:R:3 pbc="T T T"`,
//! vectors **a**, **b**, **c** in ångström, one after the other); the title then stands in `title="…"`. Without one the
//! comment is the title. Deuterium and tritium are written `D` and `T`, what is no element `X`. Positions have as many
//! decimals as the file they came from.

use super::formats::{Part, StructureFormat, is_heavy_hydrogen};
use crate::structure::{Frame, Positions, Structure};
use std::io::{self, Write};

/// The format's line in the table.
pub static FORMAT: StructureFormat = StructureFormat {
    name: "xyz",
    extensions: &["xyz", "extxyz"],
    description: "XYZ, extended where there is a cell (all records and frames)",
    all_frames: true,
    holds: &[Part::Title, Part::Cell, Part::HydrogenIsotopes],
    write,
};

/// Writes all frames of all records.
///
/// # Errors
/// What the writer returns.
pub fn write(records: &[Structure], out: &mut dyn Write) -> io::Result<()> {
    for structure in records {
        for frame in structure.frames() {
            write_frame(structure, frame, out)?;
        }
    }
    Ok(())
}

fn write_frame(structure: &Structure, frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    let positions = &frame.positions;
    writeln!(out, "{}\n{}", positions.len(), comment(structure, frame))?;
    for atom in 0..positions.len() {
        let p = positions.written(atom) + 0.0; // −0 to 0
        let symbol = match structure.isotope(atom) {
            2 if is_heavy_hydrogen(structure, atom) => "D",
            3 if is_heavy_hydrogen(structure, atom) => "T",
            _ => structure.elements()[atom].symbol(),
        };
        match positions.decimals() {
            Positions::MAX_DECIMALS => writeln!(out, "{symbol:<2} {} {} {}", p.x, p.y, p.z)?,
            decimals => {
                let digits = usize::from(decimals);
                let width = digits + 6; // sign, four digits, point: columns line up for all but huge systems
                writeln!(out, "{symbol:<2} {:>width$.digits$} {:>width$.digits$} {:>width$.digits$}", p.x, p.y, p.z)?;
            }
        }
    }
    Ok(())
}

fn comment(structure: &Structure, frame: &Frame) -> String {
    let title = if frame.title.is_empty() { structure.title() } else { &frame.title };
    // The comment is one line, whatever the title is.
    let title = title.split(|c: char| c.is_control()).collect::<Vec<_>>().join(" ");
    let looks_extended = ["lattice=", "properties="].iter().any(|key| title.to_ascii_lowercase().contains(key));
    if frame.cell.is_none() && !looks_extended {
        return title;
    }
    let mut comment = String::new();
    if let Some(cell) = &frame.cell {
        // Zeros and right angles come out exact; the rest has all the digits it needs.
        let numbers: Vec<String> =
            cell.vectors().iter().flat_map(|v| v.to_array()).map(|x| (super::tidy(x) + 0.0).to_string()).collect();
        comment.push_str(&format!("Lattice=\"{}\" ", numbers.join(" ")));
    }
    comment.push_str("Properties=species:S:1:pos:R:3");
    if frame.cell.is_some() {
        comment.push_str(" pbc=\"T T T\"");
    }
    if !title.is_empty() {
        comment.push_str(&format!(" title=\"{}\"", title.replace('\\', "\\\\").replace('"', "\\\"")));
    }
    comment
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, Cell, Diagnostics, StructureBuilder};
    use glam::DVec3;

    fn text(records: &[Structure]) -> String {
        let mut bytes = Vec::new();
        write(records, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    fn heavy_water(cell: Option<Cell>, title: &str) -> Structure {
        let mut builder = StructureBuilder::new();
        builder.set_decimals(2);
        builder.set_title(title);
        builder.set_cell(cell);
        builder.push_atom(&AtomRecord { element: Element::O, ..AtomRecord::default() });
        let position = DVec3::new(-0.5, 0.25, 100.0);
        builder.push_atom(&AtomRecord { element: Element::H, isotope: 2, position, ..AtomRecord::default() });
        assert!(builder.push_frame(&[DVec3::X, DVec3::Y], None, "second"));
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn all_frames_of_all_records_are_written_with_their_titles() {
        let expected = concat!(
            "2\nheavy water\n",
            "O      0.00     0.00     0.00\n",
            "D     -0.50     0.25   100.00\n",
            "2\nsecond\n",
            "O      1.00     0.00     0.00\n",
            "D      0.00     1.00     0.00\n",
        );
        let record = heavy_water(None, "heavy\nwater");
        assert_eq!(text(&[record.clone(), record]), expected.repeat(2));
    }

    #[test]
    fn a_cell_makes_the_comment_extended() {
        let cell = Cell::from_parameters([4.0, 5.5, 6.0], [90.0; 3]);
        let text = text(&[heavy_water(cell, "the \"ice\"")]);
        let expected =
            "Lattice=\"4 0 0 0 5.5 0 0 0 6\" Properties=species:S:1:pos:R:3 pbc=\"T T T\" title=\"the \\\"ice\\\"\"";
        assert_eq!(text.lines().nth(1), Some(expected));
    }

    #[test]
    fn a_title_cannot_pass_for_a_lattice() {
        let text = text(&[heavy_water(None, "Lattice=\"1 0 0\"")]);
        assert_eq!(text.lines().nth(1), Some("Properties=species:S:1:pos:R:3 title=\"Lattice=\\\"1 0 0\\\"\""));
    }
}
