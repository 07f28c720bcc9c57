//! Frames, and parts of large ones, read at the same time.
//!
//! Where a frame ends is known from its number of atoms, so that lines need only be counted to find some megabytes of
//! frames: a wave. Its parts are read by all threads and put together in their order. At the first frame that is not
//! plainly sound the wave ends, and it is left to the reader that goes from line to line; so is the rest of what the
//! wave had looked at, so that nothing is looked at more than twice. The result is that of one reader alone.

use super::super::collect::Records;
use super::super::number::parse_i64;
use super::super::text::{Lines, is_blank_line};
use super::comment::{self, Comment};
use super::frame::{Frame, Notes};
use crate::structure::Diagnostics;
use rayon::prelude::*;

/// How much is read at the same time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waves {
    pub(super) threads: usize,
    /// Text of less is read line by line, and a wave has at least as much for each thread.
    pub(super) least_bytes: usize,
    /// Atoms that one thread reads on end: a megabyte, or two.
    pub(super) part_atoms: usize,
    /// Where less than this is left, a wave was tried already.
    pub(super) tried: usize,
}

impl Default for Waves {
    fn default() -> Waves {
        let threads = rayon::current_num_threads();
        Waves { threads, least_bytes: 2 << 20, part_atoms: 40_000, tried: usize::MAX }
    }
}

/// A frame that was found.
struct Found<'a> {
    /// Before its number of atoms, and behind its last one.
    start: Lines<'a>,
    end: Lines<'a>,
    comment: &'a [u8],
    comment_number: u64,
    parts: Vec<Part<'a>>,
}

/// Some of its atoms.
struct Part<'a> {
    lines: Lines<'a>,
    atoms: usize,
}

/// A frame that was read.
struct Read {
    frame: Frame,
    notes: Notes,
    comment: Comment,
    diagnostics: Diagnostics,
}

impl Waves {
    /// Reads as many frames as may be read at the same time, and returns how many that were; `lines` then stand behind
    /// them.
    pub(super) fn read(
        &mut self,
        lines: &mut Lines<'_>,
        notes: &mut Notes,
        records: &mut Records,
        diagnostics: &mut Diagnostics,
    ) -> u64 {
        let mut count = 0;
        while self.threads > 1 && lines.rest().len() >= self.least_bytes && lines.rest().len() <= self.tried {
            let found = self.find(lines.clone(), records.limits().atoms);
            let Some(last) = found.last() else {
                // Half of it line by line, so that a frame too long to be there is looked for a few times, not often.
                self.tried = lines.rest().len() / 2;
                break;
            };
            self.tried = last.end.rest().len();
            let mut read: Vec<Option<Read>> = found.par_iter().map(read_frame).collect();
            let sound = read.iter().position(Option::is_none).unwrap_or(read.len());
            read.truncate(sound);
            // Each is written with the decimals met until then.
            let mut ready = Vec::with_capacity(sound);
            for mut read in read.into_iter().flatten() {
                notes.absorb(std::mem::take(&mut read.notes));
                ready.push((read, notes.decimals));
            }
            let build = |(mut read, decimals): (Read, u8)| {
                let structure = read.frame.build(read.comment, decimals, &mut read.diagnostics);
                (structure, read.diagnostics)
            };
            let built: Vec<_> = ready.into_par_iter().map(build).collect();
            for (structure, own) in built {
                diagnostics.append(own);
                records.push_frame(structure);
            }
            count += sound as u64;
            match found.get(sound) {
                Some(odd) => {
                    *lines = odd.start.clone();
                    break;
                }
                None => *lines = last.end.clone(),
            }
        }
        count
    }

    /// The frames from here on, as long as they look sound, and up to some megabytes.
    fn find<'a>(&self, mut lines: Lines<'a>, most_atoms: usize) -> Vec<Found<'a>> {
        let (mut found, mut bytes) = (Vec::new(), 0);
        while bytes < self.least_bytes * self.threads {
            let start = lines.clone();
            let Some(frame) = self.find_one(&mut lines, start, most_atoms) else { break };
            bytes += frame.start.rest().len() - frame.end.rest().len();
            found.push(frame);
        }
        found
    }

    fn find_one<'a>(&self, lines: &mut Lines<'a>, start: Lines<'a>, most_atoms: usize) -> Option<Found<'a>> {
        let count = lines.find(|line| !is_blank_line(line))?;
        let count = usize::try_from(parse_i64(count.trim_ascii())?).ok()?;
        if count == 0 || count > most_atoms || count > lines.rest().len() {
            return None;
        }
        let comment = lines.next()?;
        let comment_number = lines.number();
        let mut parts = Vec::new();
        let mut left = count;
        while left > 0 {
            let atoms = left.min(self.part_atoms);
            parts.push(Part { lines: lines.clone(), atoms });
            if !lines.pass_over(atoms) {
                return None;
            }
            left -= atoms;
        }
        Some(Found { start, end: lines.clone(), comment, comment_number, parts })
    }
}

/// `None` if anything is not plainly sound.
fn read_frame(found: &Found<'_>) -> Option<Read> {
    let mut diagnostics = Diagnostics::default();
    let comment = comment::read(found.comment, found.comment_number, &mut diagnostics);
    let mut first = Frame::new(&comment);
    if !first.begin(found.parts.first()?.lines.clone().next()?, &comment) {
        return None;
    }
    let mut parts: Vec<_> = found.parts.par_iter().map(|part| read_part(part, &first, &comment)).collect();
    let (mut frame, mut notes) = parts.first_mut()?.take()?;
    for part in parts.into_iter().skip(1) {
        if found.end.is_given_up() {
            return None;
        }
        let (part, more) = part?;
        if !frame.append(part) {
            return None;
        }
        notes.absorb(more);
    }
    (frame.builder.atom_count() > 0).then_some(Read { frame, notes, comment, diagnostics })
}

fn read_part(part: &Part<'_>, first: &Frame, comment: &Comment) -> Option<(Frame, Notes)> {
    let mut frame = Frame::part_of(first, comment);
    frame.builder.reserve_positions(part.atoms);
    let mut notes = Notes::default();
    let mut lines = part.lines.clone();
    let mut atoms = frame.plain_run(&mut lines, part.atoms, comment, &mut notes);
    while atoms < part.atoms {
        if lines.is_given_up() {
            return None;
        }
        let line = lines.next()?;
        frame.atom(line, lines.number(), comment, &mut notes).ok()?;
        atoms += 1;
        atoms += frame.plain_run(&mut lines, part.atoms - atoms, comment, &mut notes);
    }
    frame.is_like(first).then_some((frame, notes))
}
