//! Records as they are read, and which of them are frames of one molecule.

use super::text::Lines;
use super::{Document, Format, Limits};
use crate::error::{Error, Result};
use crate::stop::Stop;
use crate::structure::{Diagnostics, Structure};

/// The records read so far.
#[derive(Debug)]
pub(super) struct Records {
    limits: Limits,
    stop: Stop,
    list: Vec<Structure>,
    left_out: u64,
}

impl Records {
    pub(super) fn new(limits: &Limits, stop: &Stop) -> Records {
        Records { limits: *limits, stop: stop.clone(), list: Vec::new(), left_out: 0 }
    }

    pub(super) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// By which reading is given up. A reader may end wherever it sees that.
    pub(super) fn stop(&self) -> &Stop {
        &self.stop
    }

    /// The lines of a text that is read into these records: they end when reading is given up.
    pub(super) fn lines<'a>(&self, text: &'a [u8]) -> Lines<'a> {
        Lines::new(text, self.limits.line_bytes).until(&self.stop)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// An error once a record of this many atoms has too many.
    #[inline]
    pub(super) fn check_atoms(&self, atoms: usize, line: u64) -> Result<()> {
        if atoms > self.limits.atoms {
            let message = format!("the record has more than {} atoms (limit `atoms`)", self.limits.atoms);
            return Err(Error::limit(line, message));
        }
        Ok(())
    }

    /// Adds a record of its own.
    pub(super) fn push(&mut self, structure: Structure) {
        if self.list.len() < self.limits.records {
            self.list.push(structure);
        } else {
            self.left_out += 1;
        }
    }

    /// Adds what a reader made of a part of the file called `what`, if it could read it; else that is left out with an error at
    /// its line, or at `first_line` where it names none, and the problem is handed back. A limit ends the reading.
    pub(super) fn push_or_leave_out(
        &mut self,
        read: Result<Structure>,
        what: &str,
        first_line: u64,
        diagnostics: &mut Diagnostics,
    ) -> Result<Option<Error>> {
        let problem = match read {
            Ok(structure) => {
                self.push(structure);
                return Ok(None);
            }
            Err(limit @ Error::Limit { .. }) => return Err(limit),
            Err(problem) => problem,
        };
        let message = match &problem {
            Error::Input { message, .. } => message.clone(),
            other => other.to_string(),
        };
        diagnostics.error(problem.line().or(Some(first_line)), format!("{what} is left out: {message}"));
        Ok(Some(problem))
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// As [`Records::push`]; the index of the record, `None` if it is left out, being one too many.
    pub(super) fn push_record(&mut self, structure: Structure) -> Option<usize> {
        let before = self.left_out;
        self.push(structure);
        (self.left_out == before).then(|| self.list.len() - 1)
    }

    /// Adds a model or frame: a further frame of the last record if that has the same atoms, else a new record.
    /// What a further frame says beside positions, cell, title and vectors (bonds, charges) is the first one's.
    /// Returns the index of the record; `None` if it is left out, being one too many.
    pub(super) fn push_frame(&mut self, structure: Structure) -> Option<usize> {
        match self.list.last_mut() {
            Some(last) if same_atoms(last, &structure) => {
                last.frames.extend(structure.frames);
                self.list.len().checked_sub(1)
            }
            _ => self.push_record(structure),
        }
    }

    /// Replaces a record by what `change` makes of it.
    pub(super) fn update(&mut self, index: usize, change: impl FnOnce(Structure) -> Structure) {
        if index < self.list.len() {
            let structure = self.list.swap_remove(index);
            let last = self.list.len();
            self.list.push(change(structure));
            self.list.swap(index, last); // `swap_remove` had put the last one at `index`
        }
    }

    pub(super) fn finish(self, format: Format, mut diagnostics: Diagnostics) -> Result<Document> {
        if self.left_out > 0 {
            let (left_out, limit) = (self.left_out, self.limits.records);
            diagnostics
                .error(None, format!("{left_out} records behind the first {limit} are left out (limit `records`)"));
        }
        if self.list.is_empty() {
            return Err(Error::input(None, format!("no molecule was found in the file (read as {format})")));
        }
        Ok(Document { format, records: self.list, trajectories: Vec::new(), diagnostics: diagnostics.into_list() })
    }
}

/// Same elements, isotopes, names and residues in the same order.
fn same_atoms(a: &Structure, b: &Structure) -> bool {
    // Names are interned in the order they appear, so equal atoms have equal identifiers.
    a.element == b.element
        && a.isotope == b.isotope
        && a.atom_name == b.atom_name
        && a.residue_of_atom == b.residue_of_atom
        && a.altloc == b.altloc
        && a.residues == b.residues
        && a.chains == b.chains
        && a.names == b.names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, StructureBuilder};

    fn molecule(elements: &[Element], name: &str) -> Structure {
        let mut builder = StructureBuilder::new();
        for &element in elements {
            builder.push_atom(&AtomRecord { element, name, ..AtomRecord::default() });
        }
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn only_the_same_atoms_are_frames_of_one_record() {
        let mut records = Records::new(&Limits::default(), &Stop::never());
        for (elements, name, want) in [
            (vec![Element::C, Element::O], "", 0),
            (vec![Element::C, Element::O], "", 0),
            (vec![Element::O, Element::C], "", 1),
            (vec![Element::O, Element::C], "A", 2),
            (vec![Element::O], "A", 3),
        ] {
            assert_eq!(records.push_frame(molecule(&elements, name)), Some(want));
        }
    }

    #[test]
    fn records_beyond_the_limit_are_counted() {
        let mut records = Records::new(&Limits { records: 1, ..Limits::default() }, &Stop::never());
        assert_eq!(records.push_frame(molecule(&[Element::C], "")), Some(0));
        assert_eq!(records.push_frame(molecule(&[Element::O], "")), None);
        assert_eq!(records.push_frame(molecule(&[Element::C], "")), Some(0));
        let document = records.finish(Format::Xyz, Diagnostics::default()).unwrap();
        assert_eq!((document.frame_count(), document.diagnostics.len()), (2, 1));
    }

    #[test]
    fn update_keeps_the_order() {
        let mut records = Records::new(&Limits::default(), &Stop::never());
        for element in [Element::C, Element::N, Element::O] {
            records.push(molecule(&[element], ""));
        }
        records.update(1, |_| molecule(&[Element::S], ""));
        let symbols: Vec<_> = records.list.iter().map(|record| record.elements()[0]).collect();
        assert_eq!(symbols, [Element::C, Element::S, Element::O]);
    }
}
