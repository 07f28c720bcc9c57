//! Tripos MOL2 files, of one or many molecules.
//!
//! Specification: Tripos, "Tripos Mol2 File Format" (SYBYL 7.1, 2005). Read are MOLECULE, ATOM, BOND, SUBSTRUCTURE,
//! CRYSIN and UNITY_ATOM_ATTR (its `charge` lines); all other sections are passed over. Comments (`#`), blank lines and
//! continuations (`\` at the end) may stand anywhere the specification lets them.
//!
//! - Elements come from the SYBYL type (`C.ar`, `Co.oh`), see [`atom_type`]; in a molecule whose types are those of a
//!   force field (AMBER's `CA`, GAFF's `ca`) from the atom names.
//! - `1` `2` `3` are orders, `am` is single, `ar` aromatic (but at `O.co2` and `C.cat`, where it is one double bond shared:
//!   the first is double, the others single), `du` and `un` are bonds of unknown order, `nc` is no bond; `un`
//!   between a metal and another atom is coordination. The list is complete: no bond is to be added to it.
//! - Residues are the substructures: name and number from a name such as `ALA12`, the chain from the SUBSTRUCTURE section.
//! - Charges are partial ones, unless the molecule says NO_CHARGES; UNITY_ATOM_ATTR gives formal ones.
//! - Status bits, sets, features, comments of atoms and the space group's setting are not kept.
//!
//! A molecule that is not sound is left out with an error and the others are read.

mod atom_type;
mod molecule;

use super::collect::Records;
use super::text::{Lines, is_blank_line};
use crate::error::{Error, Result};
use crate::structure::Diagnostics;

/// Where a molecule begins.
const MOLECULE: &[u8] = b"@<TRIPOS>MOLECULE";

pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut lines = records.lines(text).peekable_lines();
    let mut first_problem: Option<Error> = None;
    let mut index = 0u64;
    while let Some((_, line)) = lines.peek() {
        if !line.starts_with(MOLECULE) {
            lines.skip();
            continue;
        }
        index += 1;
        let first_line = lines.number();
        let read = molecule::read(&mut lines, records, diagnostics);
        let problem = records.push_or_leave_out(read, &format!("molecule {index}"), first_line, diagnostics)?;
        first_problem = first_problem.or(problem);
    }
    lines.check()?;
    match first_problem {
        Some(problem) if records.is_empty() => Err(problem),
        None if records.is_empty() => Err(Error::input(None, "the file has no `@<TRIPOS>MOLECULE`")),
        _ => Ok(()),
    }
}

/// Lines with one of look-ahead, and their numbers.
#[derive(Debug, Clone)]
struct Peekable<'a> {
    lines: Lines<'a>,
    next: Option<&'a [u8]>,
}

impl<'a> Lines<'a> {
    fn peekable_lines(mut self) -> Peekable<'a> {
        let next = self.next();
        Peekable { lines: self, next }
    }
}

impl<'a> Peekable<'a> {
    /// The next line and its number, which stays the next.
    fn peek(&self) -> Option<(u64, &'a [u8])> {
        self.next.map(|line| (self.lines.number(), line))
    }

    /// Number of the line that `peek` gives; at the end, of the last one.
    fn number(&self) -> u64 {
        self.lines.number()
    }

    fn skip(&mut self) {
        self.next = self.lines.next();
    }

    /// The limit error if a line was too long.
    fn check(&self) -> Result<()> {
        self.lines.check()
    }

    /// The next line of the section, whatever it is; `None` at the next section's head.
    fn in_section(&mut self) -> Option<(u64, &'a [u8])> {
        let found = self.peek().filter(|(_, line)| !line.starts_with(b"@"))?;
        self.skip();
        Some(found)
    }

    /// The next line of the section that holds data: no comment, not blank.
    fn data(&mut self) -> Option<(u64, &'a [u8])> {
        loop {
            let (number, line) = self.in_section()?;
            if !line.starts_with(b"#") && !is_blank_line(line) {
                return Some((number, line));
            }
        }
    }

    /// What `\` at the end of the line goes on with.
    fn joined(&mut self, line: &[u8]) -> Option<Vec<u8>> {
        let mut joined = line.trim_ascii_end().strip_suffix(b"\\")?.to_vec();
        while let Some((_, more)) = self.in_section() {
            joined.push(b' ');
            let Some(head) = more.trim_ascii_end().strip_suffix(b"\\") else {
                joined.extend_from_slice(more);
                break;
            };
            joined.extend_from_slice(head);
        }
        Some(joined)
    }
}

#[cfg(test)]
mod tests;
