//! Where atoms begin and end in a file, and what a smaller file with some of them looks like: one function for each format, which gives
//! its text and about how many atoms there are in the large one.

use super::sample::{Bytes, Found, Line, Sample, WHOLE_BYTES, find, sample};
use crate::import::cif::rows::split_row;
use crate::import::number::{parse_f64, parse_i64};
use crate::import::text::{Lines, is_blank_line};
use crate::import::{gro, pdb};
use std::time::Instant;

/// A frame may be so much longer than its first lines say, as numbers grow by a digit.
const LONGER: f64 = 1.25;
/// So far the number of atoms that a file states may be from the one that its size says.
const MOST_OFF: f64 = 0.05;
/// Bytes in which the names of the columns of an `_atom_site` loop must be.
const NAMES_BYTES: usize = 64 << 10;

type Small = Option<(Sample, u64)>;

/// The small file: something, the atoms' lines, something.
fn framed(mut atoms: Sample, before: &[u8], after: &[u8]) -> Sample {
    atoms.text = [before, &atoms.text, after].concat();
    atoms
}

/// Lines of a frame that states how many atoms it has, whose first one begins `head`, at `start`.
fn counted(
    source: &dyn Bytes,
    (count, start): (u64, u64),
    head: &[u8],
    deadline: Option<Instant>,
    judge: impl Fn(&[u8]) -> Line,
) -> Option<Sample> {
    let lines = memchr::memchr_iter(b'\n', head).take(usize::try_from(count).ok()?);
    let (number, bytes) = lines.enumerate().last().map(|(index, end)| (index + 1, end + 1))?;
    let rest = source.len().checked_sub(start)?;
    let take = |bytes: f64| {
        let mut seen = 0;
        sample(source, start..start + rest.min(bytes as u64), deadline, |line| {
            if seen == count {
                return Line::End;
            }
            let what = judge(line);
            seen += u64::from(what == Line::Atom);
            what
        })
    };
    let mut expected = count as f64 * bytes as f64 / number as f64;
    // With the line of a cell, and some more.
    let longest = expected * LONGER + 1000.0;
    if longest <= WHOLE_BYTES as f64 {
        return take(longest).filter(|atoms| atoms.seen as u64 == count);
    }
    if longest >= rest as f64 {
        // Nothing but this frame.
        let is_whole = |atoms: &Sample| {
            let off = rest as f64 / atoms.bytes_an_atom() / count as f64 - 1.0;
            off.abs() < MOST_OFF && atoms.end == source.len()
        };
        return take(rest as f64).filter(is_whole);
    }
    for _ in 0..3 {
        let atoms = take(expected)?;
        let better = count as f64 * atoms.bytes_an_atom();
        if (better / expected - 1.0).abs() < MOST_OFF {
            return Some(atoms);
        }
        expected = better;
    }
    None
}

/// Two lines, one of which is the number of atoms: that, and where the atoms begin.
fn count_of(head: &[u8], line: usize) -> Option<(u64, usize)> {
    let mut ends = memchr::memchr_iter(b'\n', head);
    let (first, second) = (ends.next()?, ends.next()?);
    let line = if line == 0 { &head[..first] } else { &head[first + 1..second] };
    let count = u64::try_from(parse_i64(line.trim_ascii())?).ok().filter(|&count| count > 0)?;
    Some((count, second + 1))
}

pub(super) fn xyz(source: &dyn Bytes, head: &[u8], deadline: Option<Instant>) -> Small {
    let (count, start) = count_of(head, 0)?;
    let judge = |line: &[u8]| match line.trim_ascii() {
        blank if is_blank_line(blank) => Line::Other,
        // The next frame.
        number if parse_i64(number).is_some() => Line::End,
        _ => Line::Atom,
    };
    let atoms = counted(source, (count, start as u64), &head[start..], deadline, judge)?;
    let comment = Lines::new(head, usize::MAX).nth(1)?;
    let before = [format!("{}\n", atoms.atoms).as_bytes(), comment, b"\n"].concat();
    Some((framed(atoms, &before, b""), count))
}

pub(super) fn gro(source: &dyn Bytes, head: &[u8], deadline: Option<Instant>) -> Small {
    let (count, start) = count_of(head, 1)?;
    let judge = |line: &[u8]| if gro::is_atom(line) { Line::Atom } else { Line::Other };
    let atoms = counted(source, (count, start as u64), &head[start..], deadline, judge)?;
    let before = format!("\n{}\n", atoms.atoms);
    Some((framed(atoms, before.as_bytes(), b"0 0 0\n"), count))
}

pub(super) fn pdb(source: &dyn Bytes, head: &[u8], deadline: Option<Instant>) -> Small {
    let starts: [&[u8]; 2] = [b"ATOM  ", b"HETATM"];
    let is_atom = |line: &[u8]| starts.iter().any(|start| line.starts_with(start)) && pdb::has_position(line);
    let start = if starts.iter().any(|start| head.starts_with(start)) {
        0
    } else {
        let Found::At(start) = find(source, 0, &starts, deadline) else { return None };
        start
    };
    // Whatever ends the first model, or begins another.
    let end = match find(source, start, &[b"END", b"MODEL ", b"HEADER"], deadline) {
        Found::At(end) => end,
        Found::Nowhere => source.len(),
        Found::Late => return None,
    };
    let judge = |line: &[u8]| if is_atom(line) { Line::Atom } else { Line::Other };
    let atoms = sample(source, start..end, deadline, judge)?;
    let about = (atoms.end - start) as f64 / atoms.bytes_an_atom();
    Some((atoms, about as u64))
}

pub(super) fn mmcif(source: &dyn Bytes, deadline: Option<Instant>) -> Small {
    let Found::At(names_at) = find(source, 0, &[b"_atom_site."], deadline) else { return None };
    let before_at = names_at.saturating_sub(80);
    let before = source.some(before_at, usize::try_from(names_at - before_at).ok()?)?;
    let opens = before.split(|&byte| byte == b'\n').rfind(|line| !is_blank_line(line))?;
    if !opens.trim_ascii().eq_ignore_ascii_case(b"loop_") {
        return None;
    }
    let text = source.some(names_at, NAMES_BYTES)?;
    let mut names: Vec<String> = Vec::new();
    let mut start = 0;
    for end in memchr::memchr_iter(b'\n', &text) {
        let line = text[start..end].trim_ascii();
        let Some(name) = line.strip_prefix(b"_atom_site.") else { break };
        names.push(String::from_utf8_lossy(name).to_ascii_lowercase());
        start = end + 1;
    }
    let column = |name: &str| names.iter().position(|other| other == name);
    let axes = [column("cartn_x")?, column("cartn_y")?, column("cartn_z")?];
    let model = column("pdbx_pdb_model_num");
    let head = [b"data_glimpse\nloop_\n", &text[..start]].concat();
    let start = names_at + start as u64;
    let mut first_model: Option<Vec<u8>> = None;
    let judge = |line: &[u8]| {
        let is_end = |text: &[u8]| line.len() >= text.len() && line[..text.len()].eq_ignore_ascii_case(text);
        if [&b"#"[..], b"_", b"loop_", b"data_", b"save_"].into_iter().any(is_end) {
            return Line::End;
        }
        let mut values = vec![None; names.len()];
        let is_row = split_row(line, 0, line.len(), &mut values);
        if !is_row || !axes.iter().all(|&axis| values[axis].is_some_and(|value| parse_f64(value).is_some())) {
            return Line::Other;
        }
        let of = model.and_then(|model| values[model]).unwrap_or_default();
        if first_model.get_or_insert_with(|| of.to_vec()) == of { Line::Atom } else { Line::End }
    };
    let atoms = sample(source, start..source.len(), deadline, judge)?;
    let about = (atoms.end - start) as f64 / atoms.bytes_an_atom();
    Some((framed(atoms, &head, b""), about as u64))
}
