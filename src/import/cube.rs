//! Gaussian cube files: the atoms.
//!
//! Specification: <https://gaussian.com/cubegen/>, and `cubeplugin.c` of VMD for what is left open there: two lines of
//! comment; number of atoms and origin; number of points along each of three axes and the step along it; an atom a line
//! (atomic number, nuclear charge, position). A negative number of atoms says that orbitals follow, a negative number of
//! points that lengths are in ångström; else they are in bohr.
//!
//! The values on the grid are passed over unread. The box of the grid is no unit cell: it is a window around the
//! molecule. Atomic numbers of 0 or less are dummies.

use super::collect::Records;
use super::number::{next_f64, next_vector, parse_i64};
use super::text::{Repeated, lossy, next_word, shown};
use super::{ANGSTROM_PER_BOHR, is_plausible};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::structure::{AtomRecord, Diagnostics, StructureBuilder, atom_flags};

/// What an atom's line says: atomic number, position, and its decimals.
fn atom_line(line: &[u8]) -> Option<(i64, glam::DVec3, u8)> {
    let (number, rest) = next_word(line)?;
    let (_charge, _, rest) = next_f64(rest)?;
    let (position, decimals, _) = next_vector(rest)?;
    Some((parse_i64(number)?, position, decimals))
}

/// A whole number and a vector: the line of the atoms' number, or of an axis.
fn count_line(line: &[u8]) -> Option<i64> {
    let (count, rest) = next_word(line)?;
    next_vector(rest)?;
    parse_i64(count)
}

/// Whether lines begin as a cube file does.
pub(super) fn is_cube(lines: &[&[u8]]) -> bool {
    let axes = lines.get(2..6).is_some_and(|lines| lines.iter().all(|line| count_line(line).is_some()));
    axes && lines.get(6).is_none_or(|line| atom_line(line).is_some())
}

pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut lines = records.lines(text);
    let title = lossy(lines.next().unwrap_or_default().trim_ascii()).into_owned();
    lines.next();
    let mut counts = [0; 4];
    let whats = ["the number of atoms and the origin", "the first axis", "the second axis", "the third axis"];
    for (count, what) in counts.iter_mut().zip(whats) {
        let line = lines.next().unwrap_or_default();
        lines.check()?;
        *count = count_line(line).ok_or_else(|| {
            let message = format!("expected {what} (a whole number and three lengths), found `{}`", shown(line));
            Error::input(lines.number(), message)
        })?;
    }
    let line = lines.number() - 3;
    let atoms = usize::try_from(counts[0].unsigned_abs()).unwrap_or(usize::MAX);
    if atoms == 0 {
        return Err(Error::input(line, "the file has 0 atoms"));
    }
    records.check_atoms(atoms.min(lines.rest().len()), line)?;
    let scale = if counts[1] < 0 { 1.0 } else { ANGSTROM_PER_BOHR };
    let mut builder = StructureBuilder::new();
    let mut decimals = 0;
    let (mut unknown, mut lost) = (Repeated::default(), Repeated::default());
    for index in 0..atoms {
        let line = lines.next().unwrap_or_default();
        lines.check()?;
        let number = lines.number();
        let Some((z, position, written)) = atom_line(line) else {
            let expected = format!("expected atom {} of {atoms} (atomic number, charge, x, y, z)", index + 1);
            let message = format!("{expected}, found `{}`", shown(line));
            if builder.atom_count() == 0 {
                return Err(Error::input(number, message));
            }
            diagnostics.error(Some(number), format!("{message}; the atoms before it are read"));
            break;
        };
        let position = position * scale;
        if !is_plausible(position) {
            lost.note(number, || format!("the position {position} cannot be used; the atom is left out"));
            continue;
        }
        decimals = decimals.max(written);
        let element = u8::try_from(z).ok().and_then(Element::from_z);
        if element.is_none() && z > 0 {
            unknown.note(number, || format!("no element has the atomic number {z}; kept without an element"));
        }
        builder.push_atom(&AtomRecord {
            element: element.unwrap_or(Element::DUMMY),
            position,
            flags: if z <= 0 { atom_flags::PARTICLE } else { 0 },
            ..AtomRecord::default()
        });
    }
    unknown.warn(diagnostics);
    lost.error(diagnostics);
    if builder.atom_count() == 0 {
        return Err(Error::input(line, "no atom has a position that can be used"));
    }
    // A bohr is more than half an ångström: one decimal more tells what the last one told.
    builder.set_decimals(decimals.saturating_add(u8::from(scale != 1.0)));
    builder.set_title(title);
    records.push(builder.build(diagnostics));
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::import::{Document, Format, ImportOptions, read_bytes};
    use crate::structure::{Severity, atom_flags};
    use glam::DVec3;

    fn read(text: &str) -> crate::Result<Document> {
        let document = read_bytes(text.as_bytes(), "", &ImportOptions::default())?;
        assert_eq!(document.format, Format::Cube);
        Ok(document)
    }

    fn cube(atoms: &str, axis: &str, lines: &str) -> String {
        format!("water\ndensity\n {atoms} -1.0 -1.0 -1.0\n {axis} 0.1 0 0\n 2 0 0.1 0\n 2 0 0 0.1\n{lines}")
    }

    const WATER: &str = " 8 8.0 0.000000 0.000000 1.0\n 1 1.0 0 1.5 -1\n 1 1.0 0 -1.5 -1\n 1.0E-3 2.0E-3 3.0E-3\n";

    #[test]
    fn lengths_are_in_bohr_or_in_angstrom() {
        let document = read(&cube("3", "2", WATER)).unwrap();
        let water = &document.records[0];
        assert_eq!((water.title(), water.atom_count()), ("water", 3));
        let error = water.positions().get(0) - DVec3::new(0.0, 0.0, 0.529_177_210_903);
        assert!(error.length() < 5e-8, "{error}");
        assert_eq!(water.positions().decimals(), 7);
        assert!(water.cell().is_none());
        let angstrom = read(&cube("3", "-2", WATER)).unwrap();
        assert_eq!(angstrom.records[0].positions().written(1), DVec3::new(0.0, 1.5, -1.0));
    }

    #[test]
    fn orbitals_come_with_a_negative_number_of_atoms() {
        let document = read(&cube("-3", "2", &WATER.replace(" 1.0E-3", " 1 5\n 1.0E-3"))).unwrap();
        assert_eq!(document.records[0].atom_count(), 3);
        assert!(document.diagnostics.is_empty());
    }

    #[test]
    fn dummies_and_unknown_numbers_are_kept() {
        let document = read(&cube("3", "2", " 0 0.0 0 0 0\n 119 1.0 0 0 1\n 6 6 0 0 2\n")).unwrap();
        let first = &document.records[0];
        assert_eq!([0, 1, 2].map(|atom| first.flags(atom)), [atom_flags::PARTICLE, 0, 0]);
        assert_eq!(document.diagnostics.len(), 1);
    }

    #[test]
    fn what_is_cut_off_is_said() {
        let document = read(&cube("3", "2", " 8 8.0 0 0 0\n 1 1.0 0\n")).unwrap();
        assert_eq!(document.records[0].atom_count(), 1);
        assert_eq!((document.diagnostics[0].severity, document.diagnostics[0].line), (Severity::Error, Some(8)));
        assert!(read(&cube("0", "2", WATER)).is_err());
        assert!(read(&cube("9223372036854775807", "2", WATER)).is_ok());
    }
}
