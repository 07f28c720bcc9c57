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
//! In large files frames, and parts of large frames, are read at the same time ([`waves`]); the result does not depend on that.
//!
//! A frame in which a line cannot be read is left out, and reading goes on behind it; an atom whose position is written
//! as `nan`, `inf` or absurdly far away is left out alone.

mod comment;
mod frame;
mod run;
mod waves;

use super::collect::Records;
use super::number::parse_i64;
use super::text::{Lines, is_blank_line, shown};
use crate::error::{Error, Result};
use crate::structure::Diagnostics;
use frame::{Frame, Notes};
use waves::Waves;

pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    read_in_waves(text, Waves::default(), records, diagnostics)
}

fn read_in_waves(text: &[u8], mut waves: Waves, records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut lines = records.lines(text);
    let mut reader = Reader::default();
    let mut first_problem = None;
    let mut sound = 0u64;
    loop {
        sound += waves.read(&mut lines, &mut reader.notes, records, diagnostics);
        let Some(line) = lines.next() else { break };
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
    reader.notes.report(diagnostics);
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

/// Reads frames one after another.
#[derive(Debug, Default)]
struct Reader {
    notes: Notes,
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
        let mut index = 0;
        while index < count && !lines.is_given_up() {
            index += frame.plain_run(lines, count - index, &comment, &mut self.notes);
            if index == count {
                break;
            }
            let before = lines.clone();
            let Some(line) = lines.next() else {
                lines.check()?;
                let message = format!("expected {count} atoms in the frame from line {count_line} on, found {index}");
                return Err(Error::input(lines.number(), message));
            };
            let number = lines.number();
            let Err(expected) = frame.atom(line, number, &comment, &mut self.notes) else {
                index += 1;
                continue;
            };
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
        records.push_frame(frame.build(comment, self.notes.decimals, diagnostics));
        Ok(())
    }
}

#[cfg(test)]
mod tests;
