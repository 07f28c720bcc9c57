//! The V3000 connection table: `M  V30` lines of words and `KEY=value` pairs.
//!
//! A line that ends in `-` goes on in the next. Values are bare, in double quotes (a doubled quote is one), or lists
//! in parentheses. Read is the first CTAB of the record: its ATOM block (CHG, RAD, MASS) and its BOND block (CFG, ENDPTS,
//! ATTACH). Atoms may have any numbers. Atom lists (`[N,O]`, `NOT[…]`) and `R#` are particles. All other blocks, and all
//! that comes behind the CTAB (R-groups, templates), are passed over up to `M  END`.
//!
//! `ENDPTS=(n a b …) ATTACH=ALL` says that a metal binds the atoms a, b, … together, through an atom that only marks
//! the middle: it becomes a coordination bond to each of them. With `ATTACH=ANY` (one of them, it is not said which)
//! the bond is the one to the middle.

use super::super::collect::Records;
use super::super::number::{parse_f64, parse_i64};
use super::super::symbol::{Label, LabelKind};
use super::super::text::shown;
use super::molfile::{Stated, Table, read_symbol};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::structure::BondStereo;
use glam::DVec3;
use std::collections::HashMap;

/// Reads the lines from `start` on; returns the index of the line behind `M  END`.
pub(super) fn read(
    table: &mut Table,
    lines: &[&[u8]],
    start: usize,
    first_line: u64,
    records: &Records,
) -> Result<usize> {
    let mut reader = Reader { table, numbers: HashMap::new(), consecutive: true, promised: None };
    let mut block = Block::Outside;
    let mut done = false;
    let mut index = start;
    while index < lines.len() {
        let number = first_line + index as u64;
        let line = lines[index];
        index += 1;
        if line.starts_with(b"M  END") {
            reader.finish(block, done, number)?;
            return Ok(index);
        }
        if line.starts_with(b">") {
            index -= 1; // no `M  END`
            break;
        }
        let Some(text) = entry(line) else { continue };
        let joined = join(text, lines, &mut index);
        let text = joined.as_deref().unwrap_or(text);
        let mut words = Words(text);
        match (words.next().unwrap_or_default(), block) {
            (b"BEGIN", _) => match words.next().unwrap_or_default() {
                b"CTAB" if !done && block == Block::Outside => block = Block::Table,
                b"ATOM" if block == Block::Table => block = Block::Atoms,
                b"BOND" if block == Block::Table => block = Block::Bonds,
                name => index = skip_block(lines, index, name),
            },
            (b"END", Block::Atoms | Block::Bonds) => block = Block::Table,
            (b"END", Block::Table) => {
                block = Block::Outside;
                done = true;
            }
            (b"COUNTS", Block::Table) => {
                let mut count = || parse_i64(words.next()?).and_then(|count| usize::try_from(count).ok());
                let Some(promised) = count().zip(count()) else {
                    let message =
                        format!("expected COUNTS with the numbers of atoms and bonds, found `{}`", shown(text));
                    return Err(Error::input(number, message));
                };
                reader.promised = Some(promised);
            }
            (first, Block::Atoms) => {
                reader.atom(first, words, text, number)?;
                records.check_atoms(reader.table.builder.atom_count(), number)?;
            }
            (first, Block::Bonds) => reader.bond(first, words, text, number)?,
            _ => {}
        }
    }
    reader.finish(block, done, first_line + index as u64)?;
    Ok(index)
}

/// Where in the table a line stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Block {
    Outside,
    Table,
    Atoms,
    Bonds,
}

/// What follows `M  V30`.
fn entry(line: &[u8]) -> Option<&[u8]> {
    line.strip_prefix(b"M  V30").map(<[u8]>::trim_ascii)
}

/// The text with its continuation lines, if it has any.
fn join(text: &[u8], lines: &[&[u8]], index: &mut usize) -> Option<Vec<u8>> {
    let mut joined = text.strip_suffix(b"-")?.to_vec();
    while let Some(more) = lines.get(*index).and_then(|line| line.strip_prefix(b"M  V30")) {
        *index += 1;
        // One blank belongs to the prefix; further ones may belong to a quoted text.
        let more = more.strip_prefix(b" ").unwrap_or(more).trim_ascii_end();
        let Some(head) = more.strip_suffix(b"-") else {
            joined.extend_from_slice(more);
            break;
        };
        joined.extend_from_slice(head);
    }
    Some(joined)
}

/// The index behind the `END` of a block that is passed over, and all blocks inside it.
fn skip_block(lines: &[&[u8]], start: usize, name: &[u8]) -> usize {
    let mut depth = 1usize;
    for (index, line) in lines.iter().enumerate().skip(start) {
        if line.starts_with(b"M  END") {
            return index;
        }
        let mut words = Words(entry(line).unwrap_or_default());
        match (words.next(), words.next()) {
            (Some(b"BEGIN"), Some(inner)) if inner == name => depth += 1,
            (Some(b"END"), Some(inner)) if inner == name => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return index + 1;
        }
    }
    lines.len()
}

/// Words of an entry: blanks inside quotes, parentheses and brackets do not separate.
struct Words<'a>(&'a [u8]);

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let text = self.0.trim_ascii_start();
        if text.is_empty() {
            return None;
        }
        let (mut quoted, mut depth) = (false, 0usize);
        let end = text.iter().position(|&byte| {
            match byte {
                b'"' => quoted = !quoted,
                b'(' | b'[' if !quoted => depth += 1,
                b')' | b']' if !quoted => depth = depth.saturating_sub(1),
                _ => {}
            }
            !quoted && depth == 0 && byte.is_ascii_whitespace()
        });
        let (word, rest) = text.split_at(end.unwrap_or(text.len()));
        self.0 = rest;
        Some(word)
    }
}

/// Key and value of `KEY=value`, the value without its quotes.
fn pair(word: &[u8]) -> Option<(&[u8], &[u8])> {
    let at = word.iter().position(|&byte| byte == b'=')?;
    Some((&word[..at], unquoted(&word[at + 1..])))
}

fn unquoted(word: &[u8]) -> &[u8] {
    word.strip_prefix(b"\"").and_then(|word| word.strip_suffix(b"\"")).unwrap_or(word)
}

/// The numbers of `(n a b …)`, without n.
fn list(value: &[u8]) -> Option<Vec<i64>> {
    let inner = value.strip_prefix(b"(")?.strip_suffix(b")")?;
    let mut numbers = Words(inner).map(parse_i64);
    let _count = numbers.next()??; // programs get it wrong, and the parenthesis ends the list anyway
    numbers.collect()
}

struct Reader<'t> {
    table: &'t mut Table,
    /// Index of each atom by its number, once the numbers are not 1, 2, 3, ….
    numbers: HashMap<i64, u32>,
    consecutive: bool,
    /// Atoms and bonds that COUNTS speaks of.
    promised: Option<(usize, usize)>,
}

impl Reader<'_> {
    fn atom(&mut self, first: &[u8], words: Words<'_>, text: &[u8], number: u64) -> Result<()> {
        let mut words = words;
        let mut fields = || {
            let atom = parse_i64(first)?;
            let symbol = unquoted(words.next()?);
            let mut coordinate = || parse_f64(words.next()?);
            let ((x, dx), (y, dy), (z, dz)) = (coordinate()?, coordinate()?, coordinate()?);
            Some((atom, symbol, DVec3::new(x, y, z), dx.max(dy).max(dz)))
        };
        let Some((atom, symbol, position, decimals)) = fields() else {
            let message = format!("expected an atom (number, symbol, x, y, z), found `{}`", shown(text));
            return Err(Error::input(number, message));
        };
        let listed = symbol.starts_with(b"[") || symbol.starts_with(b"NOT");
        let label = if listed {
            Label { element: Element::DUMMY, isotope: 0, particle: true, kind: LabelKind::Symbol }
        } else {
            read_symbol(symbol)
        };
        let mut stated = Stated { isotope: label.isotope, ..Stated::default() };
        for (key, value) in words.filter_map(pair) {
            let number_of = || parse_i64(value);
            let understood = match key {
                b"CHG" => number_of().and_then(|v| i8::try_from(v).ok()).map(|v| stated.formal_charge = v),
                b"RAD" => {
                    number_of().and_then(|v| u8::try_from(v).ok()).filter(|&v| v <= 3).map(|v| stated.radical = v)
                }
                // Some programs write the exact mass. The heaviest nuclide known has 295 nucleons.
                b"MASS" => parse_f64(value)
                    .filter(|(mass, _)| (0.0..=400.0).contains(mass))
                    .map(|(mass, _)| stated.isotope = mass.round() as u16),
                _ => Some(()),
            };
            if understood.is_none() {
                let message = || format!("`{}={}` of an atom cannot be; it is ignored", shown(key), shown(value));
                self.table.odd_field.note(number, message);
            }
        }
        let index = self.table.builder.atom_count();
        self.table.push_atom(symbol, label, position, decimals, stated, number)?;
        if self.consecutive && atom != index as i64 + 1 {
            self.consecutive = false;
            self.numbers = (0..index).map(|index| (index as i64 + 1, index as u32)).collect();
        }
        if !self.consecutive && self.numbers.insert(atom, index as u32).is_some() {
            return Err(Error::input(number, format!("two atoms have the number {atom}")));
        }
        Ok(())
    }

    fn index(&self, atom: i64) -> Option<u32> {
        if !self.consecutive {
            return self.numbers.get(&atom).copied();
        }
        let count = self.table.builder.atom_count();
        usize::try_from(atom).ok().filter(|atom| (1..=count).contains(atom)).map(|atom| (atom - 1) as u32)
    }

    fn bond(&mut self, first: &[u8], words: Words<'_>, text: &[u8], number: u64) -> Result<()> {
        let mut words = words;
        let mut next = || parse_i64(words.next()?);
        let (Some(_), Some(kind), Some(a), Some(b)) = (parse_i64(first), next(), next(), next()) else {
            let message = format!("expected a bond (number, type, two atoms), found `{}`", shown(text));
            return Err(Error::input(number, message));
        };
        let (mut configuration, mut end_points, mut all) = (0, None, true);
        for (key, value) in words.filter_map(pair) {
            match key {
                b"CFG" => configuration = parse_i64(value).unwrap_or(0),
                b"ENDPTS" => end_points = list(value),
                b"ATTACH" => all = value.eq_ignore_ascii_case(b"ALL"),
                _ => {}
            }
        }
        let (Some(first), Some(second)) = (self.index(a).filter(|_| a != b), self.index(b)) else {
            self.table.refuse_bond([a, b], number);
            return Ok(());
        };
        if let Some(points) = end_points.filter(|points| all && !points.is_empty()) {
            // The atom that marks the middle has no element; the other end is what binds.
            let is_mark = |atom: u32| self.table.builder.elements()[atom as usize] == Element::DUMMY;
            let (binding, binding_number) = if is_mark(first) { (second, b) } else { (first, a) };
            for point in points {
                match self.index(point).filter(|&point| point != binding) {
                    Some(point) => self.table.push_coordination(binding, point),
                    None => self.table.refuse_bond([binding_number, point], number),
                }
            }
            return Ok(());
        }
        let stereo = match (configuration, kind) {
            (1, _) => Some(BondStereo::Up),
            (3, _) => Some(BondStereo::Down),
            (2, 2) => Some(BondStereo::CisTransEither),
            (2, _) => Some(BondStereo::Either),
            _ => None,
        };
        self.table.push_bond([first, second], kind, stereo, number);
        Ok(())
    }

    /// Whether the table is whole.
    fn finish(&mut self, block: Block, done: bool, number: u64) -> Result<()> {
        let found = self.table.builder.atom_count();
        if !done || block != Block::Outside {
            let message = match self.promised {
                Some((atoms, _)) if block != Block::Outside => {
                    format!("the table of {atoms} atoms ends without its END line, after {found} atoms")
                }
                _ => "the record has no table (`M  V30 BEGIN CTAB`)".to_owned(),
            };
            return Err(Error::input(number, message));
        }
        match self.promised {
            Some((atoms, _)) if atoms != found => {
                Err(Error::input(number, format!("expected {atoms} atoms as COUNTS says, found {found}")))
            }
            _ if found == 0 => Err(Error::input(number, "the molecule has 0 atoms")),
            _ => Ok(()),
        }
    }
}
