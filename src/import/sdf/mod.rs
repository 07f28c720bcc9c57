//! MDL MOL and SD files, V2000 and V3000, each record in its own version.
//!
//! Specification: BIOVIA, "CTfile Formats" (2020): the V2000 connection table and its property block ([`molfile`]), the
//! V3000 table ([`v3000`]), and SD data items.
//!
//! Accepted beyond it: counts and atom lines whose fields are separated by blanks but not in their columns; a header
//! with lines too many or too few (the counts line is known by its version tag); no-break spaces; a missing version
//! tag; a missing `M  END`; symbols in any case; element numbers; counts of query lists that are no numbers.
//!
//! Bond types 1–3 are orders; 4 is aromatic; 5–8 are query types (6 and 7 aromatic) of unknown order, 8 to a metal
//! is coordination as CDK and ChEBI write it; 9 is dative, 10 a hydrogen bond (V3000's meaning of the numbers).
//! Query atoms, R-groups and lone pairs are kept as particles. The list is complete: no bond is to be added to it.
//!
//! A record that is not sound is left out with an error and the others are read. Sgroups, the members of atom lists,
//! parities, collections, reaction fields, R-groups' own tables and 3D features are passed over.

mod molfile;
mod v3000;

use super::collect::Records;
use super::text::{columns, is_blank_line};
use crate::error::{Error, Result};
use crate::structure::Diagnostics;

/// Whether a line ends as a counts line does: with a version tag in its columns, or a little beside them.
pub(super) fn is_counts_line(line: &[u8]) -> bool {
    let tail = columns(line, 30, 48).trim_ascii();
    (tail.ends_with(b"V2000") || tail.ends_with(b"V3000")) && columns(line, 0, 30).is_ascii()
        || molfile::without_no_break_spaces(line).is_some_and(|line| is_counts_line(&line))
}

pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut lines = records.lines(text);
    let mut record: Vec<&[u8]> = Vec::new();
    let mut first_problem = None;
    let mut index = 0u64;
    loop {
        record.clear();
        let first_line = lines.number() + 1;
        let mut ended = false;
        for line in lines.by_ref() {
            if line.starts_with(b"$$$$") {
                ended = true;
                break;
            }
            record.push(line);
        }
        lines.check()?;
        if record.iter().all(|line| is_blank_line(line)) {
            if !ended {
                break;
            }
            let problem = || Error::input(first_line, "the record is empty");
            diagnostics.warn(Some(first_line), "an empty record is left out");
            first_problem.get_or_insert_with(problem);
            continue;
        }
        index += 1;
        let read = molfile::read(&record, first_line, records, diagnostics);
        let problem = records.push_or_leave_out(read, &format!("record {index}"), first_line, diagnostics)?;
        first_problem = first_problem.or(problem);
        if !ended {
            break;
        }
    }
    match first_problem {
        Some(problem) if records.is_empty() => Err(problem),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
