//! XYZ: a count, a comment, then symbol and position of every atom, frame after frame.
//!
//! With a unit cell the comment is that of extended XYZ (`Lattice="…" Properties=species:S:1:pos:R:3 pbc="T T T"`,
//! vectors **a**, **b**, **c** in ångström, one after the other); the title then stands in `title="…"`. Without one the
//! comment is the title. Deuterium and tritium are written `D` and `T`, what is no element `X`. Positions have as many
//! decimals as the file they came from.
//!
//! As `extxyz` the comment is always that, and holds more: partial charges as a column `charge`, vectors under their names
//! (with the first frame, whose they are), data fields as pairs of the first frame. In quoted values `\"`, `\\` and `\n`
//! stand for a quote, a backslash and a line end.

use super::formats::{Part, StructureFormat};
use super::text::{frame_title, symbol_with_isotope};
use crate::structure::{Frame, Positions, Structure, VectorField};
use std::io::{self, Write};

/// The format's line in the table.
pub static FORMAT: StructureFormat = StructureFormat {
    name: "xyz",
    extensions: &["xyz"],
    description: "XYZ, extended where there is a cell (all records and frames)",
    all_frames: true,
    holds: &[
        Part::Title,
        Part::FrameTitles,
        Part::Frames,
        Part::Cell,
        Part::FrameCells,
        Part::Particles,
        Part::HydrogenIsotopes,
    ],
    limits: super::formats::no_limits,
    write,
};

/// Extended XYZ's line in the table.
pub static FORMAT_EXTENDED: StructureFormat = StructureFormat {
    name: "extxyz",
    extensions: &["extxyz"],
    description: "extended XYZ: cell, vectors, partial charges, data fields (all records and frames)",
    all_frames: true,
    holds: &[
        Part::Title,
        Part::FrameTitles,
        Part::Frames,
        Part::Cell,
        Part::FrameCells,
        Part::Particles,
        Part::HydrogenIsotopes,
        Part::PartialCharges,
        Part::Vectors,
        Part::Properties,
    ],
    limits: super::formats::no_limits,
    write: write_extended,
};

/// Writes all frames of all records.
///
/// # Errors
/// What the writer returns.
pub fn write(records: &[Structure], out: &mut dyn Write) -> io::Result<()> {
    write_frames(records, false, out)
}

/// Writes all frames of all records as extended XYZ.
///
/// # Errors
/// What the writer returns.
pub fn write_extended(records: &[Structure], out: &mut dyn Write) -> io::Result<()> {
    write_frames(records, true, out)
}

fn write_frames(records: &[Structure], extended: bool, out: &mut dyn Write) -> io::Result<()> {
    for structure in records {
        for (index, frame) in structure.frames().iter().enumerate() {
            let columns = if extended { Columns::of(structure, frame) } else { Columns::default() };
            let pairs = if extended && index == 0 { structure.properties() } else { &[] };
            write_frame(structure, frame, &columns, pairs, extended, out)?;
        }
    }
    Ok(())
}

/// Columns behind the position.
#[derive(Default)]
struct Columns<'a> {
    charges: bool,
    vectors: &'a [VectorField],
}

impl<'a> Columns<'a> {
    fn of(structure: &Structure, frame: &'a Frame) -> Columns<'a> {
        Columns { charges: Part::PartialCharges.is_in(structure), vectors: &frame.vectors }
    }
}

fn write_frame(
    structure: &Structure,
    frame: &Frame,
    columns: &Columns<'_>,
    pairs: &[(String, String)],
    extended: bool,
    out: &mut dyn Write,
) -> io::Result<()> {
    let positions = &frame.positions;
    writeln!(out, "{}\n{}", positions.len(), comment(structure, frame, columns, pairs, extended))?;
    for atom in 0..positions.len() {
        let p = positions.written(atom) + 0.0; // −0 to 0
        let symbol = symbol_with_isotope(structure, atom);
        match positions.decimals() {
            Positions::MAX_DECIMALS => write!(out, "{symbol:<2} {} {} {}", p.x, p.y, p.z)?,
            decimals => {
                let digits = usize::from(decimals);
                let width = digits + 6; // sign, four digits, point: columns line up for all but huge systems
                write!(out, "{symbol:<2} {:>width$.digits$} {:>width$.digits$} {:>width$.digits$}", p.x, p.y, p.z)?;
            }
        }
        if columns.charges {
            write!(out, " {}", structure.partial_charge(atom).unwrap_or(0.0))?;
        }
        for field in columns.vectors {
            let v = field.vectors[atom];
            write!(out, " {} {} {}", v.x, v.y, v.z)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

fn comment(
    structure: &Structure,
    frame: &Frame,
    columns: &Columns<'_>,
    pairs: &[(String, String)],
    extended: bool,
) -> String {
    // The comment is one line, whatever the title is.
    let title = frame_title(structure, frame);
    let looks_extended = ["lattice=", "properties="].iter().any(|key| title.to_ascii_lowercase().contains(key));
    if frame.cell.is_none() && !looks_extended && !extended {
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
    if columns.charges {
        comment.push_str(":charge:R:1");
    }
    for field in columns.vectors {
        let name: String =
            field.name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect();
        comment.push_str(&format!(":{name}:R:3"));
    }
    let has = |key: &str| pairs.iter().any(|(name, _)| name.eq_ignore_ascii_case(key));
    if frame.cell.is_some() && !has("pbc") {
        comment.push_str(" pbc=\"T T T\"");
    }
    let mut said = "";
    for (name, value) in pairs {
        let reserved = ["lattice", "properties"].iter().any(|key| name.eq_ignore_ascii_case(key));
        let name = if reserved { format!("{name}_") } else { name.clone() };
        comment.push_str(&format!(" {}={}", key(&name), quoted(value)));
        if ["title", "name", "comment"].iter().any(|key| name.eq_ignore_ascii_case(key)) {
            said = value;
        }
    }
    if !title.is_empty() && title != said {
        comment.push_str(&format!(" title={}", always_quoted(&title)));
    }
    comment
}

fn is_plain(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || "_-+.:/".contains(c))
}

fn key(name: &str) -> String {
    let name: String = name.chars().map(|c| if c.is_control() || c == '"' { '_' } else { c }).collect();
    if is_plain(&name) { name } else { always_quoted(&name) }
}

fn quoted(value: &str) -> String {
    if is_plain(value) { value.to_owned() } else { always_quoted(value) }
}

fn always_quoted(text: &str) -> String {
    let text = text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
    format!("\"{}\"", text.replace(|c: char| c.is_control(), " "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::export::tests::written;
    use crate::structure::{AtomRecord, Cell, Diagnostics, StructureBuilder};
    use glam::DVec3;

    fn text(records: &[Structure]) -> String {
        written(|out| write(records, out))
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
    fn extended_columns_and_pairs_are_written_with_the_first_frame() {
        let mut builder = StructureBuilder::new();
        builder.set_decimals(1);
        builder.set_title("t");
        builder.push_atom(&AtomRecord { element: Element::O, partial_charge: Some(-0.5), ..AtomRecord::default() });
        let vectors = vec![glam::Vec3::new(0.5, 0.0, -1.0)];
        assert!(builder.push_vectors(VectorField { name: "my force".to_owned(), vectors }));
        for (name, value) in [("energy", "-1.5"), ("a b", "say \"x\"\n\\"), ("Lattice", "fcc")] {
            builder.push_property(name, value);
        }
        assert!(builder.push_frame(&[DVec3::X], None, ""));
        let got = written(|out| write_extended(&[builder.build(&mut Diagnostics::default())], out));
        let expected = concat!(
            "1\nProperties=species:S:1:pos:R:3:charge:R:1:my_force:R:3 energy=-1.5 \"a b\"=\"say \\\"x\\\"\\n\\\\\" ",
            "Lattice_=fcc title=\"t\"\nO      0.0     0.0     0.0 -0.5 0.5 0 -1\n",
            "1\nProperties=species:S:1:pos:R:3:charge:R:1 title=\"t\"\nO      1.0     0.0     0.0 -0.5\n",
        );
        assert_eq!(got, expected);
    }

    #[test]
    fn a_title_cannot_pass_for_a_lattice() {
        let text = text(&[heavy_water(None, "Lattice=\"1 0 0\"")]);
        assert_eq!(text.lines().nth(1), Some("Properties=species:S:1:pos:R:3 title=\"Lattice=\\\"1 0 0\\\"\""));
    }
}
