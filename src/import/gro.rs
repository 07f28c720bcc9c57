//! GROMACS structure files (GRO, also known as gromos87).
//!
//! Specification: <https://manual.gromacs.org/current/reference-manual/file-formats.html#gro>: a title, the number of
//! atoms, an atom a line (residue number and name, atom name, atom number in five columns each, position in nm, perhaps
//! velocity in nm/ps), the box; again for each frame. The distance of the decimal points is the width of the numbers'
//! columns, so that files may have any precision.
//!
//! Elements come from the names, as in PDB files without an element column; virtual sites are particles. Numbers that
//! wrapped around at 100,000 count on. Velocities are kept in nm/ps. The box may be missing at the end of a file.

use super::collect::Records;
use super::is_plausible;
use super::number::{next_f64, parse_f64, parse_i64};
use super::pdb::element;
use super::text::{Lines, Repeated, columns, field, is_blank_line, lossy, shown};
use crate::error::{Error, Result};
use crate::structure::{AtomRecord, Cell, Diagnostics, StructureBuilder, VectorField, atom_flags};
use glam::{DVec3, Vec3};

/// Where the numbers begin.
const NUMBERS: usize = 20;

/// Whether lines begin as a GRO file does.
pub(super) fn is_gro(lines: &[&[u8]]) -> bool {
    let counts = lines.get(1).is_some_and(|line| parse_i64(line.trim_ascii()).is_some_and(|count| count >= 0));
    counts && lines.get(2).is_some_and(|line| is_atom(line))
}

/// Whether a line looks like an atom: labels in their columns, and a position behind them.
pub(super) fn is_atom(line: &[u8]) -> bool {
    let number = field(line, 15, 20);
    let has_labels = (number.is_empty() || parse_i64(number).is_some())
        && columns(line, 0, 5).iter().all(|byte| byte.is_ascii_digit() || *byte == b' ')
        && columns(line, 5, 15).iter().any(u8::is_ascii_alphabetic);
    has_labels && width_of(line).is_some_and(|width| position(line, width).is_some())
}

/// The width of the numbers' columns: the distance of the first two decimal points.
fn width_of(line: &[u8]) -> Option<usize> {
    let numbers = line.get(NUMBERS..)?;
    let mut points = memchr::memchr_iter(b'.', numbers);
    let (first, second) = (points.next()?, points.next()?);
    Some(second - first)
}

/// Three numbers from a column on.
fn vector(line: &[u8], from: usize, width: usize) -> Option<(DVec3, u8)> {
    let number = |index: usize| parse_f64(field(line, from + index * width, from + (index + 1) * width));
    let ((x, dx), (y, dy), (z, dz)) = (number(0)?, number(1)?, number(2)?);
    Some((DVec3::new(x, y, z), dx.max(dy).max(dz)))
}

fn position(line: &[u8], width: usize) -> Option<(DVec3, u8)> {
    vector(line, NUMBERS, width)
}

/// From nm to Å: the point of the decimal number moves by one.
fn angstrom(nm: DVec3, decimals: u8) -> DVec3 {
    let scale = 10f64.powi(i32::from(decimals));
    let moved = (nm * scale).round() / (scale / 10.0);
    if decimals == 0 || !moved.is_finite() { nm * 10.0 } else { moved }
}

pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut lines = records.lines(text);
    let mut notes = Notes::default();
    let mut decimals = 0;
    let mut outcome = Ok(());
    while let Some(title) = lines.next() {
        // A blank title is a title, but blank lines at the end are the end.
        if is_blank_line(title) && lines.rest().iter().all(u8::is_ascii_whitespace) {
            break;
        }
        match frame(title, &mut lines, &mut decimals, records, &mut notes, diagnostics) {
            Ok(()) => {}
            Err(Error::Input { line, message }) if !records.is_empty() => {
                diagnostics.error(line, format!("{message}; this frame and what follows it are left out"));
                break;
            }
            Err(error) => {
                outcome = Err(error);
                break;
            }
        }
    }
    lines.check()?;
    notes.unknown.warn(diagnostics);
    notes.lost.error(diagnostics);
    notes.no_box.warn(diagnostics);
    outcome
}

#[derive(Default)]
struct Notes {
    unknown: Repeated,
    lost: Repeated,
    no_box: Repeated,
}

/// Numbers of five digits that begin again behind 99999.
#[derive(Default)]
struct Wrapped {
    last: i64,
    turns: i64,
}

impl Wrapped {
    fn read(&mut self, text: &[u8]) -> Option<i32> {
        let written = parse_i64(text)?;
        if written < self.last {
            self.turns = if self.last == 99_999 { self.turns + 1 } else { 0 };
        }
        self.last = written;
        i32::try_from(written.checked_add(self.turns.checked_mul(100_000)?)?).ok()
    }
}

fn frame(
    title: &[u8],
    lines: &mut Lines<'_>,
    decimals: &mut u8,
    records: &mut Records,
    notes: &mut Notes,
    diagnostics: &mut Diagnostics,
) -> Result<()> {
    let line = lines.next().unwrap_or_default();
    lines.check()?;
    let count_line = lines.number();
    let count = parse_i64(line.trim_ascii()).and_then(|count| usize::try_from(count).ok());
    let Some(count) = count else {
        return Err(Error::input(count_line, format!("expected the number of atoms, found `{}`", shown(line))));
    };
    if count == 0 {
        return Err(Error::input(count_line, "the frame has 0 atoms"));
    }
    records.check_atoms(count.min(lines.rest().len()), count_line)?;
    let mut atoms = Atoms { decimals: *decimals, ..Atoms::default() };
    for index in 0..count {
        let line = lines.next();
        lines.check()?;
        let Some(line) = line else {
            let message = format!("expected {count} atoms in the frame from line {count_line} on, found {index}");
            return Err(Error::input(lines.number(), message));
        };
        atoms.push(line, lines.number(), notes)?;
    }
    if atoms.builder.atom_count() == 0 {
        return Err(Error::input(count_line, "no atom of the frame has a position that can be used"));
    }
    *decimals = atoms.decimals;
    let cell_line = lines.next();
    lines.check()?;
    let cell = match cell_line.map(cell) {
        Some(Some(cell)) => cell,
        _ => {
            let found = shown(cell_line.unwrap_or_default());
            let message = || format!("expected the box (three or nine numbers), found `{found}`; there is no cell");
            notes.no_box.note(lines.number(), message);
            None
        }
    };
    let Atoms { mut builder, velocities, .. } = atoms;
    // nm to Å takes one away.
    builder.set_decimals(decimals.saturating_sub(1));
    let title = lossy(title.trim_ascii());
    builder.set_title(title.clone());
    builder.set_frame_title(title);
    builder.set_cell(cell);
    if velocities.len() == builder.atom_count() {
        let field = VectorField { name: "velocities".to_owned(), vectors: velocities };
        let _fits = builder.push_vectors(field);
    } else if !velocities.is_empty() {
        diagnostics.warn(Some(count_line), "velocities that only some atoms have are left out");
    }
    records.push_frame(builder.build(diagnostics));
    Ok(())
}

#[derive(Default)]
struct Atoms {
    builder: StructureBuilder,
    velocities: Vec<Vec3>,
    decimals: u8,
    residue_numbers: Wrapped,
    serials: Wrapped,
}

impl Atoms {
    fn push(&mut self, line: &[u8], number: u64, notes: &mut Notes) -> Result<()> {
        let width = width_of(line);
        let Some((width, (nm, decimals))) = width.and_then(|width| Some((width, position(line, width)?))) else {
            let expected = "expected an atom (number and name of its residue, name, number, x, y, z in nm)";
            return Err(Error::input(number, format!("{expected}, found `{}`", shown(line))));
        };
        let position = angstrom(nm, decimals);
        if !is_plausible(position) {
            notes.lost.note(number, || format!("the position {nm} cannot be used; the atom is left out"));
            return Ok(());
        }
        self.decimals = self.decimals.max(decimals);
        let (residue, name) = (field(line, 5, 10), field(line, 10, 15));
        let meaning =
            if is_bead(name, residue) { element::Guess::PARTICLE } else { element::guess(name, residue, || false) };
        if meaning.element.z() == 0 && !meaning.particle {
            notes.unknown.note(number, || {
                format!("no element is known for the atom named `{}`; it is kept without one", shown(name))
            });
        }
        let residue_number = self.residue_numbers.read(field(line, 0, 5)).unwrap_or(0);
        self.builder.push_atom(&AtomRecord {
            element: meaning.element,
            isotope: meaning.isotope,
            position,
            name: &lossy(name),
            serial: self.serials.read(field(line, 15, 20)),
            residue: Some(("", residue_number, b' ', &lossy(residue))),
            flags: if meaning.particle { atom_flags::PARTICLE } else { 0 },
            ..AtomRecord::default()
        });
        if let Some((velocity, _)) = vector(line, NUMBERS + 3 * width, width) {
            self.velocities.push(velocity.as_vec3());
        }
        Ok(())
    }
}

/// Water beads of the MARTINI force field, four waters each, which are called like tungsten.
fn is_bead(name: &[u8], residue: &[u8]) -> bool {
    matches!((name, residue), (b"W" | b"WF" | b"WP" | b"WM", b"W" | b"WF" | b"PW"))
}

/// The box: `None` if the line is none, `Some(None)` if it says that there is none.
fn cell(line: &[u8]) -> Option<Option<Cell>> {
    let mut numbers = [0.0; 9];
    let mut rest = line;
    let mut count = 0;
    while count < 9
        && let Some((value, decimals, after)) = next_f64(rest)
    {
        numbers[count] = angstrom(DVec3::splat(value), decimals).x;
        rest = after;
        count += 1;
    }
    let [ax, by, cz, ay, az, bx, bz, cx, cy] = numbers;
    match count {
        3 | 9 => Some(Cell::from_vectors(DVec3::new(ax, ay, az), DVec3::new(bx, by, bz), DVec3::new(cx, cy, cz))),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use crate::import::{Document, Format, ImportOptions, read_bytes};
    use crate::structure::{Severity, atom_flags};
    use glam::DVec3;

    fn read(text: &str) -> crate::Result<Document> {
        let document = read_bytes(text.as_bytes(), "", &ImportOptions::default())?;
        assert_eq!(document.format, Format::Gro);
        Ok(document)
    }

    const WATER: &str = "water, t= 0.0\n    4\n    1SOL     OW    1   0.126   1.624   1.679  0.1227 -0.0580  0.0434\n    \
                         1SOL    HW1    2   0.190   1.661   1.747  0.8085  0.3191 -0.7791\n    1SOL    HW2    3   0.177   \
                         1.568   1.613 -0.9045 -2.6469  1.3180\n    1SOL     MW    4   0.130   1.620   1.680  0.0000  \
                         0.0000  0.0000\n   1.82060   1.82060   1.82060\n";

    #[test]
    fn nanometres_become_angstrom_digit_for_digit() {
        let document = read(WATER).unwrap();
        let water = &document.records[0];
        assert_eq!(water.positions().written(0), DVec3::new(1.26, 16.24, 16.79));
        assert_eq!(water.positions().decimals(), 2);
        assert_eq!(water.elements().iter().map(|e| e.symbol()).collect::<Vec<_>>(), ["O", "H", "H", "X"]);
        assert_eq!(water.flags(3), atom_flags::PARTICLE);
        assert_eq!(water.vectors()[0].vectors[1].to_array(), [0.8085, 0.3191, -0.7791]);
        assert_eq!(water.cell().unwrap().lengths(), [18.206, 18.206, 18.206]);
        assert_eq!((water.title(), water.residues().len()), ("water, t= 0.0", 1));
        assert!(document.diagnostics.is_empty());
    }

    #[test]
    fn the_decimal_points_give_the_columns() {
        let text = "\n1\n    1ALA     CA    1   1.123456  -0.234567  12.345678\n 1 2 3 0 0 0.5 0 0.25 0.125\n";
        let document = read(text).unwrap();
        let atom = &document.records[0];
        assert_eq!(atom.positions().written(0), DVec3::new(11.23456, -2.34567, 123.45678));
        assert_eq!(atom.elements()[0].symbol(), "C");
        let [a, b, c] = atom.cell().unwrap().vectors();
        let want = [DVec3::new(10.0, 0.0, 0.0), DVec3::new(5.0, 20.0, 0.0), DVec3::new(2.5, 1.25, 30.0)];
        assert_eq!([a, b, c], want);
    }

    #[test]
    fn names_mean_elements_by_their_residues() {
        let names = [
            ("ALA", "CA", "C"),
            ("CA", "CA", "Ca"),
            ("CL", "CL", "Cl"),
            ("NA", "NA", "Na"),
            ("NALA", "HA", "H"),
            ("ION", "NA", "Na"),
            ("ION", "CL-", "Cl"),
            ("CLA", "CLA", "Cl"),
            ("LYS", "MNZ1", "X"),
            ("W", "W", "X"),
            ("LIG", "C12", "C"),
        ];
        let mut text = format!("names\n{}\n", names.len());
        for (index, (residue, name, _)) in names.iter().enumerate() {
            text +=
                &format!("{:5}{residue:<5}{name:>5}{index:5}{:8.3}{:8.3}{:8.3}\n", index + 1, 0.0, 0.0, index as f64);
        }
        let document = read(&format!("{text}0 0 0\n")).unwrap();
        for (element, (residue, name, want)) in document.records[0].elements().iter().zip(names) {
            assert_eq!(element.symbol(), want, "{name} of {residue}");
        }
        assert!(document.records[0].cell().is_none());
    }

    #[test]
    fn numbers_wrap_around() {
        let line = |residue: u32, atom: u32| format!("{residue:5}SOL     OW{atom:5}   0.000   0.000   0.000\n");
        let lines: String = [(99_999, 99_998), (0, 99_999), (1, 0), (1, 1)].map(|(r, a)| line(r, a)).concat();
        let document = read(&format!("t\n4\n{lines}1 1 1\n")).unwrap();
        let first = &document.records[0];
        assert_eq!([0, 1, 2, 3].map(|atom| first.serial(atom)), [99_998, 99_999, 100_000, 100_001]);
        let residues: Vec<i32> = first.residues().iter().map(|residue| residue.number).collect();
        assert_eq!(residues, [99_999, 100_000, 100_001]);
    }

    #[test]
    fn frames_follow_one_another_and_a_cut_one_is_left_out() {
        let document = read(&format!("{WATER}{WATER}\n\n")).unwrap();
        assert_eq!((document.records.len(), document.frame_count()), (1, 2));
        assert!(document.diagnostics.is_empty());
        let document = read(&format!("{WATER}{}", &WATER[..150])).unwrap();
        assert_eq!(document.frame_count(), 1);
        assert_eq!(document.diagnostics[0].severity, Severity::Error);
        assert!(read(&WATER[..150]).is_err());
        let no_box = read(&WATER[..WATER.len() - 31]).unwrap();
        assert!(no_box.records[0].cell().is_none() && no_box.diagnostics.len() == 1);
    }
}
