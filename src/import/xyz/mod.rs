//! XYZ and extended XYZ.
//!
//! Specification: XYZ has none of its own; it is what XMol wrote (`count`, comment, `symbol x y z [charge] [vx vy vz]`
//! in ångström) and Open Babel's and Jmol's pages describe. Extended XYZ as the `libAtoms/extxyz` description has it
//! (`Lattice`, `Properties`, quoted values), see [`comment`].
//!
//! Accepted beyond that: atomic numbers or labels (`C12`, `OW`) in place of symbols, blank lines between and after
//! frames, further columns (three numbers behind the position are taken as a vector, four as a charge and a vector, as
//! XMol means them; others are ignored), Fortran exponents, differing atoms from frame to frame.
//!
//! A frame in which a line cannot be read is left out, and reading goes on behind it; an atom whose position is written
//! as `nan`, `inf` or absurdly far away is left out alone.

mod comment;

use super::collect::Records;
use super::is_plausible;
use super::number::{next_vector, parse_f64, parse_i64};
use super::symbol::{LabelKind, read_label};
use super::text::{Lines, Repeated, is_blank_line, lossy, next_word, shown, words};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::structure::{AtomRecord, Diagnostics, StructureBuilder, VectorField};
use comment::{Column, Comment, Role};
use glam::DVec3;

pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut lines = Lines::new(text, records.limits().line_bytes);
    let mut reader = Reader::default();
    let mut first_problem = None;
    let mut sound = 0u64;
    while let Some(line) = lines.next() {
        if is_blank_line(line) {
            continue;
        }
        let count_line = lines.number();
        let outcome = match parse_i64(line.trim_ascii()).and_then(|count| usize::try_from(count).ok()) {
            Some(count) => reader.frame(count, &mut lines, records, diagnostics),
            None => {
                let problem = Error::input(
                    count_line,
                    format!("expected the number of atoms of a frame, found `{}`", shown(line)),
                );
                skip_to_count(&mut lines);
                Err(problem)
            }
        };
        lines.check()?;
        match outcome {
            Ok(()) => sound += 1,
            Err(limit @ Error::Limit { .. }) => return Err(limit),
            Err(problem) => {
                let Error::Input { line, message } = &problem else { return Err(problem) };
                diagnostics.error(*line, format!("{message}; this part is left out"));
                first_problem.get_or_insert(problem);
            }
        }
    }
    lines.check()?;
    reader.unknown.warn(diagnostics);
    reader.guessed.warn(diagnostics);
    reader.lost.error(diagnostics);
    match first_problem {
        Some(problem) if sound == 0 => Err(problem),
        _ => Ok(()),
    }
}

/// Moves on to before the next line that holds an integer alone.
fn skip_to_count(lines: &mut Lines<'_>) {
    loop {
        let before = lines.clone();
        match lines.next() {
            Some(line) if parse_i64(line.trim_ascii()).is_some() => {
                *lines = before;
                return;
            }
            Some(_) => {}
            None => return,
        }
    }
}

#[derive(Debug, Default)]
struct Reader {
    /// Most decimals seen; all frames are written back with as many.
    decimals: u8,
    unknown: Repeated,
    guessed: Repeated,
    lost: Repeated,
}

impl Reader {
    /// Reads the comment and the atoms of a frame.
    fn frame(
        &mut self,
        count: usize,
        lines: &mut Lines<'_>,
        records: &mut Records,
        diagnostics: &mut Diagnostics,
    ) -> Result<()> {
        let count_line = lines.number();
        records.check_atoms(count.min(lines.rest().len()), count_line)?;
        let comment_line = lines.next().unwrap_or_default();
        if count == 0 {
            diagnostics.warn(Some(count_line), "a frame of 0 atoms is left out");
            return if records.is_empty() { Err(Error::input(count_line, "the frame has 0 atoms")) } else { Ok(()) };
        }
        let comment = comment::read(comment_line, lines.number(), diagnostics);
        let mut frame = Frame::new(&comment);
        for index in 0..count {
            let before = lines.clone();
            let Some(line) = lines.next() else {
                lines.check()?;
                let message = format!("expected {count} atoms in the frame from line {count_line} on, found {index}");
                return Err(Error::input(lines.number(), message));
            };
            let number = lines.number();
            let Err(expected) = frame.atom(line, number, &comment, self) else { continue };
            // The count of the next frame (alone on its line) shows that this one is short.
            if parse_i64(line.trim_ascii()).is_some() {
                *lines = before;
                let message = format!("expected {count} atoms in the frame from line {count_line} on, found {index}");
                return Err(Error::input(number, message));
            }
            for _ in index + 1..count {
                if lines.next().is_none() {
                    break;
                }
            }
            return Err(Error::input(number, format!("expected {expected}, found `{}`", shown(line))));
        }
        if frame.builder.atom_count() == 0 {
            return Err(Error::input(count_line, "no atom of the frame has a position that can be used"));
        }
        frame.finish(comment, self.decimals, records, diagnostics);
        Ok(())
    }
}

/// A frame being read.
struct Frame {
    builder: StructureBuilder,
    vectors: Vec<VectorField>,
    /// Number of columns behind the position that are read as XMol means them; 0, 3 or 4.
    plain_extra: usize,
}

impl Frame {
    fn new(comment: &Comment) -> Frame {
        let vectors = comment.vector_names().map(|name| VectorField { name, vectors: Vec::new() }).collect();
        Frame { builder: StructureBuilder::new(), vectors, plain_extra: 0 }
    }

    /// Reads one atom. The error says what was expected.
    #[inline]
    fn atom(&mut self, line: &[u8], number: u64, comment: &Comment, reader: &mut Reader) -> Result<(), String> {
        if !comment.columns.is_empty() {
            return self.atom_of_columns(line, number, &comment.columns, reader);
        }
        let plain = || "an atom (symbol x y z)".to_owned();
        let (label, rest) = next_word(line).ok_or_else(plain)?;
        let (position, decimals, rest) = next_vector(rest).ok_or_else(plain)?;
        let mut charge = None;
        if !rest.is_empty() {
            if self.builder.atom_count() == 0 {
                self.begin_plain_extra(rest);
            }
            charge = self.plain_extra(rest);
        }
        self.push(label, position, decimals, charge, number, reader);
        Ok(())
    }

    /// Looks at what follows the first atom's position.
    fn begin_plain_extra(&mut self, rest: &[u8]) {
        let count = words(rest).count();
        let numbers = words(rest).all(|word| parse_f64(word).is_some());
        if numbers && (count == 3 || count == 4) {
            self.plain_extra = count;
            self.vectors.push(VectorField { name: "vector".to_owned(), vectors: Vec::new() });
        }
    }

    /// Charge and vector behind a position, of every atom or of none.
    fn plain_extra(&mut self, rest: &[u8]) -> Option<f64> {
        if self.plain_extra == 0 {
            return None;
        }
        let mut values = [0.0; 4];
        let mut count = 0;
        for word in words(rest) {
            let (Some(slot), Some((value, _))) = (values.get_mut(count), parse_f64(word)) else {
                count = usize::MAX;
                break;
            };
            *slot = value;
            count += 1;
        }
        if count != self.plain_extra {
            self.plain_extra = 0;
            self.vectors.clear();
            return None;
        }
        let at = count - 3;
        let vector = DVec3::new(values[at], values[at + 1], values[at + 2]).as_vec3();
        self.vectors[0].vectors.push(vector);
        (at == 1).then_some(values[0])
    }

    fn atom_of_columns(
        &mut self,
        line: &[u8],
        number: u64,
        columns: &[Column],
        reader: &mut Reader,
    ) -> Result<(), String> {
        let mut rest = line;
        let (mut label, mut by_number): (&[u8], &[u8]) = (b"", b"");
        let (mut position, mut decimals) = (DVec3::NAN, 0);
        let mut charge = None;
        let mut vector_index = 0;
        for column in columns {
            let bad = || column.expected();
            if matches!(column.role, Role::Position | Role::Vector) {
                let (vector, vector_decimals, after) = next_vector(rest).ok_or_else(bad)?;
                rest = after;
                if column.role == Role::Position {
                    (position, decimals) = (vector, vector_decimals);
                } else {
                    self.vectors[vector_index].vectors.push(vector.as_vec3());
                    vector_index += 1;
                }
                continue;
            }
            for _ in 0..column.count {
                let (word, after) = next_word(rest).ok_or_else(bad)?;
                rest = after;
                if !column.accepts(word) {
                    return Err(bad());
                }
                match column.role {
                    Role::Species => label = word,
                    Role::AtomicNumber => by_number = word,
                    Role::Charge => charge = parse_f64(word).map(|(value, _)| value),
                    Role::Position | Role::Vector | Role::Other => {}
                }
            }
        }
        let label = if label.is_empty() { by_number } else { label };
        self.push(label, position, decimals, charge, number, reader);
        Ok(())
    }

    #[inline]
    fn push(
        &mut self,
        label: &[u8],
        position: DVec3,
        decimals: u8,
        charge: Option<f64>,
        number: u64,
        reader: &mut Reader,
    ) {
        if !is_plausible(position) {
            reader.lost.note(number, || format!("the position {position} cannot be used; the atom is left out"));
            for field in &mut self.vectors {
                field.vectors.truncate(self.builder.atom_count());
            }
            return;
        }
        reader.decimals = reader.decimals.max(decimals);
        let meaning = read_label(label);
        let mut record = AtomRecord {
            element: meaning.element,
            isotope: meaning.isotope,
            position,
            partial_charge: charge.map(|charge| charge as f32).filter(|charge| charge.is_finite()),
            ..AtomRecord::default()
        };
        if meaning.kind == LabelKind::Symbol && !meaning.particle {
            self.builder.push_atom(&record);
            return;
        }
        let symbol = meaning.element.symbol();
        match meaning.kind {
            LabelKind::Unknown => reader.unknown.note(number, || {
                format!("`{}` is no element symbol; the atom is kept without an element", shown(label))
            }),
            LabelKind::Guess => reader.guessed.note(number, || {
                format!("`{}` is no element symbol; taken as {symbol} from its first letters", shown(label))
            }),
            LabelKind::Symbol | LabelKind::Name => {}
        }
        if meaning.particle {
            record.flags = crate::structure::atom_flags::PARTICLE;
        }
        let name = lossy(label);
        if meaning.kind != LabelKind::Symbol || meaning.element == Element::DUMMY {
            record.name = &name;
        }
        self.builder.push_atom(&record);
    }

    fn finish(self, comment: Comment, decimals: u8, records: &mut Records, diagnostics: &mut Diagnostics) {
        let mut builder = self.builder;
        builder.set_decimals(decimals);
        builder.set_frame_title(comment.title.clone());
        builder.set_title(comment.title);
        builder.set_cell(comment.cell);
        for field in self.vectors {
            if !builder.push_vectors(field) {
                diagnostics.warn(None, "vectors that only some atoms have are left out");
            }
        }
        for (name, value) in comment.pairs {
            builder.push_property(name, value);
        }
        records.push_frame(builder.build(diagnostics));
    }
}

#[cfg(test)]
mod tests;
