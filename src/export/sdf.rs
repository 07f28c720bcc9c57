//! MOL and SD files: V2000 by default; V3000 for a record with more than 999 atoms or bonds, or with positions that do
//! not fit V2000's columns, and for all of them as `sdf-v3000`.
//!
//! Every frame of every record becomes a record. V2000 has four decimals, V3000 as many as the file. Bonds with an order
//! have it, aromatic ones without are type 4; dative ones are type 9, hydrogen bonds 10, coordination 8 where one of the atoms
//! is a metal, else 9; bonds of unknown order are 8, between metals 5. Charges, radicals and isotopes are property lines.
//! What has no element is written by its name where that is one of the format's (`R#`, `Q`, `LP`, …), else as `*`.
//! Data fields lose their blank lines, which would end them.

use super::formats::{Part, StructureFormat};
use super::text::{Position, frame_title, metals, one_line};
use crate::element::Element;
use crate::structure::{Bond, BondKind, BondOrder, BondStereo, Frame, Structure};
use std::collections::HashMap;
use std::io::{self, Write};

const HOLDS: &[Part] = &[
    Part::Title,
    Part::FrameTitles,
    Part::Frames,
    Part::Bonds,
    Part::CoordinationBonds,
    Part::DativeBonds,
    Part::HydrogenBonds,
    Part::BondStereo,
    Part::Particles,
    Part::FormalCharges,
    Part::HydrogenIsotopes,
    Part::Isotopes,
    Part::Radicals,
    Part::Properties,
];

/// The format's line in the table.
pub static FORMAT: StructureFormat = StructureFormat {
    name: "sdf",
    extensions: &["sdf", "sd", "mol", "mdl"],
    description: "MOL and SD files, V2000, larger records V3000 (all records and frames)",
    all_frames: true,
    holds: HOLDS,
    limits: |structure| limits(structure, true),
    write: |records, out| write(records, false, out),
};

/// The same in V3000.
pub static FORMAT_V3000: StructureFormat = StructureFormat {
    name: "sdf-v3000",
    extensions: &[],
    description: "MOL and SD files, V3000 (all records and frames)",
    all_frames: true,
    holds: HOLDS,
    limits: |structure| limits(structure, false),
    write: |records, out| write(records, true, out),
};

/// Decimals of a V2000 position.
const DECIMALS: u8 = 4;

fn limits(structure: &Structure, v2000: bool) -> Vec<&'static str> {
    let mut limits = Vec::new();
    if v2000 && structure.frames().iter().any(|f| fits_v2000(structure, f) && f.positions.decimals() > DECIMALS) {
        limits.push("digits of positions beyond the fourth decimal (--to sdf-v3000 keeps them)");
    }
    if structure.bonds().iter().any(|bond| bond.order == BondOrder::Quadruple) {
        limits.push("the order of quadruple bonds");
    }
    let blank = |value: &str| value.split('\n').any(|line| line.trim().is_empty()) && !value.is_empty();
    if structure.properties().iter().any(|(_, value)| blank(value)) {
        limits.push("blank lines in data fields");
    }
    limits
}

/// Writes all frames of all records.
///
/// # Errors
/// What the writer returns, and `InvalidData` for a position that is not a number.
pub fn write(records: &[Structure], v3000: bool, out: &mut dyn Write) -> io::Result<()> {
    for structure in records {
        for frame in structure.frames() {
            let title = frame_title(structure, frame);
            let flat = frame.positions.relative().iter().all(|p| f64::from(p.z) + frame.positions.origin().z == 0.0);
            // Initials, program, date, dimensions, in their columns.
            writeln!(out, "{title}\n  ballstic          {}\n", if flat { "2D" } else { "3D" })?;
            if v3000 || !fits_v2000(structure, frame) {
                write_v3000(structure, frame, out)?;
            } else {
                write_v2000(structure, frame, out)?;
            }
            out.write_all(b"M  END\n")?;
            for (name, value) in structure.properties() {
                write_property(name, value, out)?;
            }
            out.write_all(b"$$$$\n")?;
        }
    }
    Ok(())
}

fn bonds(structure: &Structure) -> impl Iterator<Item = (usize, &Bond)> {
    structure.bonds().iter().enumerate().filter(|(_, bond)| !bond.is_periodic())
}

fn fits_v2000(structure: &Structure, frame: &Frame) -> bool {
    let positions = &frame.positions;
    let fits = |x: f64| !x.is_finite() || (-9_999.999_95..99_999.999_95).contains(&x);
    structure.atom_count() <= 999
        && bonds(structure).count() <= 999
        && (0..positions.len()).all(|atom| positions.get(atom).to_array().into_iter().all(fits))
}

/// The symbol of an atom, or of what is none.
fn symbol(structure: &Structure, atom: usize) -> &str {
    const SORTS: [&str; 12] = ["A", "Q", "X", "M", "L", "LP", "*", "R", "R#", "Du", "Xx", "Bq"];
    let element = structure.elements()[atom];
    if element != Element::DUMMY {
        return element.symbol();
    }
    let name = structure.atom_name(atom);
    let group = name.len() > 1 && name.starts_with('R') && name[1..].bytes().all(|byte| byte.is_ascii_digit());
    if SORTS.contains(&name) || (group && name.len() <= 3) { name } else { "*" }
}

/// Type of a bond, as the module says.
fn bond_type(structure: &Structure, bond: &Bond) -> u8 {
    match (bond.kind, bond.order) {
        (BondKind::Hydrogen, _) => 10,
        (BondKind::Dative, _) => 9,
        (BondKind::Coordination, _) => 9 - u8::from(metals(structure, bond) > 0),
        (BondKind::Covalent, BondOrder::Single | BondOrder::Double | BondOrder::Triple) => bond.order.number(),
        (BondKind::Covalent, _) if bond.aromatic => 4,
        (BondKind::Covalent, _) => 8 - 3 * u8::from(metals(structure, bond) > 0),
    }
}

/// Each bond's first atom and mark, where it has one.
fn marks(structure: &Structure) -> HashMap<usize, (u32, BondStereo)> {
    structure.bond_stereo().iter().map(|mark| (mark.bond as usize, (mark.from, mark.stereo))).collect()
}

/// The atoms of a bond, the marked one first.
fn ends(bond: &Bond, mark: Option<&(u32, BondStereo)>) -> (u32, u32) {
    if mark.is_some_and(|(from, _)| *from == bond.b) { (bond.b, bond.a) } else { (bond.a, bond.b) }
}

fn write_v2000(structure: &Structure, frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    let count = structure.atom_count();
    writeln!(out, "{count:3}{:3}  0  0  0  0  0  0  0  0999 V2000", bonds(structure).count())?;
    for atom in 0..count {
        let p = Position::new(&frame.positions, atom)?.point();
        let symbol = symbol(structure, atom);
        let zeros = "  0".repeat(11);
        writeln!(out, "{:10.4}{:10.4}{:10.4} {symbol:<3} 0{zeros}", plus(p.x), plus(p.y), plus(p.z))?;
    }
    let marks = marks(structure);
    for (index, bond) in bonds(structure) {
        let mark = marks.get(&index);
        let (from, to) = ends(bond, mark);
        let stereo = match mark.map(|(_, stereo)| stereo) {
            None => 0,
            Some(BondStereo::Up) => 1,
            Some(BondStereo::Down) => 6,
            Some(BondStereo::Either) => 4,
            Some(BondStereo::CisTransEither) => 3,
        };
        writeln!(out, "{:3}{:3}{:3}{stereo:3}  0  0  0", from + 1, to + 1, bond_type(structure, bond))?;
    }
    write_values("CHG", (0..count).map(|atom| i32::from(structure.formal_charge(atom))), out)?;
    write_values("RAD", (0..count).map(|atom| i32::from(structure.radical(atom))), out)?;
    write_values("ISO", (0..count).map(|atom| i32::from(structure.isotope(atom))), out)
}

/// What rounds to zero without its sign.
fn plus(x: f64) -> f64 {
    if x.abs() < 0.5e-4 { 0.0 } else { x }
}

/// Property lines, eight atoms each, for values that are not 0.
fn write_values(name: &str, values: impl Iterator<Item = i32>, out: &mut dyn Write) -> io::Result<()> {
    let values: Vec<(usize, i32)> = values.enumerate().filter(|(_, value)| *value != 0).collect();
    for chunk in values.chunks(8) {
        write!(out, "M  {name}{:3}", chunk.len())?;
        for (atom, value) in chunk {
            write!(out, " {:3} {value:3}", atom + 1)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

fn write_v3000(structure: &Structure, frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    let count = structure.atom_count();
    let bond_count = bonds(structure).count();
    writeln!(out, "  0  0  0     0  0            999 V3000")?;
    writeln!(out, "M  V30 BEGIN CTAB\nM  V30 COUNTS {count} {bond_count} 0 0 0\nM  V30 BEGIN ATOM")?;
    for atom in 0..count {
        let [x, y, z] = Position::new(&frame.positions, atom)?.numbers(DECIMALS);
        let mut line = format!("{} {} {x} {y} {z} 0", atom + 1, symbol(structure, atom));
        for (key, value) in [
            ("CHG", i32::from(structure.formal_charge(atom))),
            ("RAD", i32::from(structure.radical(atom))),
            ("MASS", i32::from(structure.isotope(atom))),
        ] {
            if value != 0 {
                line += &format!(" {key}={value}");
            }
        }
        write_entry(&line, out)?;
    }
    writeln!(out, "M  V30 END ATOM")?;
    if bond_count > 0 {
        writeln!(out, "M  V30 BEGIN BOND")?;
        let marks = marks(structure);
        for (number, (index, bond)) in bonds(structure).enumerate() {
            let mark = marks.get(&index);
            let (from, to) = ends(bond, mark);
            let configuration = match mark.map(|(_, stereo)| stereo) {
                None => "",
                Some(BondStereo::Up) => " CFG=1",
                Some(BondStereo::Either | BondStereo::CisTransEither) => " CFG=2",
                Some(BondStereo::Down) => " CFG=3",
            };
            let kind = bond_type(structure, bond);
            write_entry(&format!("{} {kind} {} {}{configuration}", number + 1, from + 1, to + 1), out)?;
        }
        writeln!(out, "M  V30 END BOND")?;
    }
    writeln!(out, "M  V30 END CTAB")
}

/// A line of the table, which goes on in the next where it is over 80 characters.
fn write_entry(text: &str, out: &mut dyn Write) -> io::Result<()> {
    const ROOM: usize = 80 - "M  V30 ".len() - 1;
    let mut rest = text;
    while rest.len() > ROOM + 1 {
        // Behind a blank, which then ends the first part; names of atoms hold none. All of it is ASCII.
        let at = rest[..ROOM].rfind(' ').map_or(ROOM, |at| at + 1);
        writeln!(out, "M  V30 {}-", &rest[..at])?;
        rest = &rest[at..];
    }
    writeln!(out, "M  V30 {rest}")
}

fn write_property(name: &str, value: &str, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, ">  <{}>", one_line(name))?;
    for line in value.split('\n').filter(|line| !line.trim().is_empty()) {
        // The end mark of a record inside a value would end the record.
        let shield = if line.starts_with("$$$$") { " " } else { "" };
        writeln!(out, "{shield}{}", line.trim_end())?;
    }
    out.write_all(b"\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::written;
    use crate::structure::{AtomRecord, BondSource, Diagnostics, StructureBuilder, atom_flags};
    use glam::DVec3;

    fn text(records: &[Structure], v3000: bool) -> String {
        written(|out| write(records, v3000, out))
    }

    fn sample(decimals: u8) -> Structure {
        let mut builder = StructureBuilder::new();
        builder.set_title("a\nb");
        builder.set_decimals(decimals);
        let atom = |element, x| AtomRecord { element, position: DVec3::new(x, -0.00001, 1.0), ..AtomRecord::default() };
        builder.push_atom(&AtomRecord { formal_charge: -1, radical: 2, ..atom(Element::C, 0.5) });
        builder.push_atom(&AtomRecord { isotope: 2, ..atom(Element::H, -12.25) });
        builder.push_atom(&AtomRecord { name: "R#", flags: atom_flags::PARTICLE, ..atom(Element::DUMMY, 3.0) });
        builder.push_atom(&atom(Element::from_z(26).unwrap(), 4.0));
        let bond = |a, b, order| Bond::new(a, b, order, BondSource::File);
        builder.push_bond(bond(0, 1, BondOrder::Single));
        builder.push_bond(Bond { aromatic: true, ..bond(0, 2, BondOrder::Unknown) });
        builder.push_bond(Bond { kind: BondKind::Coordination, ..bond(0, 3, BondOrder::Unknown) });
        builder.push_bond_stereo(1, 0, BondStereo::Down);
        builder.push_property("A", "x\n\n$$$$");
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn v2000_keeps_to_its_columns() {
        let expected = "a b\n  ballstic          3D\n\n  4  3  0  0  0  0  0  0  0  0999 V2000\n    \
                        0.5000    0.0000    1.0000 C   0  0  0  0  0  0  0  0  0  0  0  0\n  \
                        -12.2500    0.0000    1.0000 H   0  0  0  0  0  0  0  0  0  0  0  0\n    \
                        3.0000    0.0000    1.0000 R#  0  0  0  0  0  0  0  0  0  0  0  0\n    \
                        4.0000    0.0000    1.0000 Fe  0  0  0  0  0  0  0  0  0  0  0  0\n  \
                        2  1  1  6  0  0  0\n  1  3  4  0  0  0  0\n  1  4  8  0  0  0  0\n\
                        M  CHG  1   1  -1\nM  RAD  1   1   2\nM  ISO  1   2   2\nM  END\n\
                        >  <A>\nx\n $$$$\n\n$$$$\n";
        assert_eq!(text(&[sample(5)], false), expected);
        let losses = FORMAT.losses(&[sample(5)]).join("\n");
        assert!(losses.contains("fourth decimal") && losses.contains("blank lines in data"), "{losses}");
        assert!(!FORMAT_V3000.losses(&[sample(5)]).join("\n").contains("decimal"));
    }

    #[test]
    fn v3000_has_all_digits_and_wraps_its_lines() {
        let text = text(&[sample(14)], true);
        assert!(text.contains("M  V30 COUNTS 4 3 0 0 0\n") && text.contains("M  V30 2 H -12.25 -0.00001 1 0 MASS=2\n"));
        assert!(text.contains("M  V30 1 1 2 1 CFG=3\n"), "{text}");
        let long = "1 C 12345.12345678901 -12345.12345678901 -12345.12345678901 0 CHG=-1 RAD=2 MASS=13";
        let wrapped = written(|out| write_entry(long, out));
        assert!(wrapped.lines().count() == 2 && wrapped.lines().all(|line| line.len() <= 80), "{wrapped}");
        assert_eq!(wrapped.replace("-\nM  V30 ", ""), format!("M  V30 {long}\n"));
    }

    #[test]
    fn records_too_large_for_v2000_are_v3000() {
        let mut builder = StructureBuilder::new();
        for x in 0..1000 {
            let position = DVec3::splat(f64::from(x));
            builder.push_atom(&AtomRecord { element: Element::C, position, ..AtomRecord::default() });
        }
        let large = builder.build(&mut Diagnostics::default());
        let mut builder = StructureBuilder::new();
        builder.push_atom(&AtomRecord { position: DVec3::splat(-10_000.0), ..AtomRecord::default() });
        let far = builder.build(&mut Diagnostics::default());
        assert_eq!(text(&[sample(4), large, far], false).matches("999 V3000").count(), 2);
    }
}
