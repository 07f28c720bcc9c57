//! Protein Data Bank files.
//!
//! Specification: wwPDB, "Protein Data Bank Contents Guide: Atomic Coordinate Entry Format Description", version 3.30
//! (2012), <https://www.wwpdb.org/documentation/file-format-content/format33/v3.3.html>.
//! Read are TITLE, CRYST1, REMARK 290 ([`symmetry`]) and 350 ([`assembly`]), MODEL, ATOM, HETATM, ENDMDL, CONECT, SSBOND, LINK, HELIX, SHEET, END,
//! HEADER (begins a further entry); all other records are passed over.
//!
//! Accepted beyond the specification:
//! - lines of any length from the z coordinate on; missing occupancy is 1, missing B is 0;
//! - serial and residue numbers in hybrid-36 or hexadecimal, stars, seven-digit serials, five-digit residue numbers
//!   (see [`number`]); serials that repeat; CONECT without blanks between numbers;
//! - residue names of four letters (`TIP3`), chain names of two where the residue's name is a standard one;
//! - missing or wrong element columns (see [`element`]), charges as `2+`, `+2`, `+`;
//! - ENDMDL without MODEL, END between models, models with differing atoms (they become records of their own);
//! - CRYST1 of 1 × 1 × 1 Å is no cell (the placeholder of structures without one).
//!
//! Large files are read in chunks at the same time ([`chunks`]); the result does not depend on that.
//!
//! Not read: bonds to symmetry mates (they have no atoms here), SCALE and ORIGX, ANISOU, hydrogen bonds of old CONECT.

mod assembly;
mod atoms;
mod bonds;
mod chunks;
pub(super) mod element;
mod fields;
mod number;
mod symmetry;

use super::collect::Records;
use super::number::{parse_f64, parse_i64};
use super::text::{Repeated, columns, field, lossy, shown};
use crate::error::{Error, Result};
use crate::structure::{
    Cell, Diagnostics, SecondaryElement, StatedBonds, StructureBuilder, Symmetry, SymmetryOperation,
};
use atoms::{AtomReader, Numbers};
use bonds::{Budget, Conect, Link, LinkEnd, Serial};
use chunks::{Event, Most, Scan};
use number::NumberColumn;
use rayon::prelude::*;
use std::sync::OnceLock;

/// Whether an atom line has its position.
pub(super) fn has_position(line: &[u8]) -> bool {
    fields::position(line).is_some()
}

pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    read_in_chunks(text, chunks::CHUNK_BYTES, rayon::current_num_threads(), records, diagnostics)
}

/// Chunks that are read at the same time, for each thread: while they are put together, as many are being read.
const CHUNKS_A_THREAD: usize = 8;

fn read_in_chunks(
    text: &[u8],
    chunk_bytes: usize,
    threads: usize,
    records: &mut Records,
    diagnostics: &mut Diagnostics,
) -> Result<()> {
    let aligned = OnceLock::new();
    let stop = records.stop().clone();
    let most = Most { line_bytes: records.limits().line_bytes, atoms: records.limits().atoms };
    let mut whole = Whole { reader: Reader::new(), atoms: AtomReader::new(text, &aligned), lines: 0, most };
    let mut chunks = chunks::split(text, chunk_bytes);
    if threads < 2 || text.len() <= chunk_bytes {
        for chunk in chunks.take_while(|_| !stop.is_set()) {
            let scan = whole.scan_on(chunk);
            whole.take(scan, records, diagnostics)?;
        }
    } else {
        let fresh = whole.atoms.fresh();
        // Each with what its reader begins with; the next ones are read while these are put together.
        let mut next_wave = || -> Vec<(&[u8], Numbers)> {
            let wave = chunks.by_ref().take(threads * CHUNKS_A_THREAD);
            wave.map(|chunk| (chunk, chunks::guess_numbers(before(text, chunk)))).collect()
        };
        let mut ready = scan_all(next_wave(), &fresh, most);
        while !ready.is_empty() && !stop.is_set() {
            let wave = next_wave();
            let put_together = || {
                ready.into_iter().try_for_each(|(chunk, numbers, scan)| {
                    let scan = if whole.accepts(&numbers, &scan) { scan } else { whole.scan_on(chunk) };
                    whole.take(scan, records, diagnostics)
                })
            };
            let (outcome, scanned) = rayon::join(put_together, || scan_all(wave, &fresh, most));
            outcome?;
            ready = scanned;
        }
    }
    stop.check()?;
    let Whole { mut reader, mut atoms, .. } = whole;
    reader.builder = atoms.end_model();
    reader.end_model(records, diagnostics);
    reader.end_entry(records, diagnostics);
    atoms.oddities.report(diagnostics);
    reader.oddities.report(diagnostics);
    if records.is_empty() {
        return Err(atoms
            .oddities
            .error()
            .unwrap_or_else(|| Error::input(None, "the file has no ATOM or HETATM record")));
    }
    Ok(())
}

/// A chunk, what its reader took for granted, and what it read.
type Guessed<'a> = (&'a [u8], Numbers, Scan<'a>);

fn scan_all<'a>(wave: Vec<(&'a [u8], Numbers)>, fresh: &AtomReader<'a>, most: Most) -> Vec<Guessed<'a>> {
    let scan = |(chunk, numbers): (&'a [u8], Numbers)| {
        let mut reader = fresh.fresh();
        reader.numbers = numbers.clone();
        (chunk, numbers, chunks::scan(chunk, reader, most))
    };
    // One by one, so that a thread that is done first takes from what the others have left.
    wave.into_par_iter().with_max_len(1).map(scan).collect()
}

/// What stands before a part of a text.
fn before<'a>(text: &'a [u8], part: &[u8]) -> &'a [u8] {
    let at = (part.as_ptr() as usize).saturating_sub(text.as_ptr() as usize);
    text.get(..at).unwrap_or_default()
}

/// A file as far as it was put together.
struct Whole<'a> {
    reader: Reader,
    /// Holds the atoms of the model that is not yet at its end.
    atoms: AtomReader<'a>,
    lines: u64,
    most: Most,
}

impl<'a> Whole<'a> {
    /// Reads a chunk behind all that was read.
    fn scan_on(&mut self, chunk: &'a [u8]) -> Scan<'a> {
        let fresh = self.atoms.fresh();
        let mut reader = std::mem::replace(&mut self.atoms, fresh);
        // Lines of a chunk are counted from its own first one; what was noted before is not of this chunk.
        self.atoms.oddities = std::mem::take(&mut reader.oddities);
        chunks::scan(chunk, reader, self.most)
    }

    /// Whether a chunk was read as it would have been behind all that was read.
    fn accepts(&self, numbers: &Numbers, scan: &Scan<'_>) -> bool {
        let first = scan.events.iter().find_map(|event| match event {
            Event::Atoms(builder, _) => Some(builder.atom_count()),
            Event::Record(_) => None,
        });
        let added = first.unwrap_or(scan.reader.builder.atom_count());
        // Which line passes a limit is found by reading again.
        self.atoms.numbers.goes_on_as(numbers) && self.atoms.builder.atom_count() + added <= self.most.atoms
    }

    fn take(&mut self, scan: Scan<'a>, records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
        let base = self.lines;
        self.lines += scan.lines;
        for event in scan.events {
            match event {
                Event::Atoms(builder, decimals) => {
                    self.atoms.builder.append_runs(*builder);
                    self.reader.decimals = self.reader.decimals.max(decimals);
                }
                Event::Record(record) => {
                    let name = columns(record.line, 0, 6).trim_ascii_end();
                    if chunks::ends_model(name) {
                        self.reader.builder = std::mem::take(&mut self.atoms.builder);
                    }
                    self.reader.met_hexadecimal |= record.met_hexadecimal;
                    self.reader.atoms_before = self.atoms.builder.atom_count() + record.atoms;
                    self.reader.other_record(name, record.line, base + record.number, records, diagnostics);
                }
            }
        }
        let tail = scan.reader;
        self.atoms.builder.append_runs(tail.builder);
        self.reader.decimals = self.reader.decimals.max(tail.decimals);
        self.reader.met_hexadecimal |= tail.numbers.serials.met_hexadecimal;
        self.atoms.numbers = tail.numbers;
        self.atoms.oddities.absorb(tail.oddities, base);
        scan.outcome.map_err(|error| match error {
            Error::Limit { line, message } => Error::limit(line.map(|line| line + base), message),
            other => other,
        })
    }
}

/// Helices and strands that all records of a file together may hold.
const MAX_COPIES: usize = 1_000_000;

/// What may occur on many lines beside those of atoms.
#[derive(Debug, Default)]
struct Oddities {
    model: Repeated,
    conect: Repeated,
    link: Repeated,
    symmetry: Repeated,
    assembly: Repeated,
}

impl Oddities {
    fn report(&self, diagnostics: &mut Diagnostics) {
        for oddity in [&self.model, &self.conect, &self.link, &self.symmetry, &self.assembly] {
            oddity.warn(diagnostics);
        }
    }
}

/// Reads all that is no atom, in the order of the file.
struct Reader {
    /// The atoms of a model at its end.
    builder: StructureBuilder,
    decimals: u8,
    /// Whether a hexadecimal serial number was met, and how many atoms of the model stand before the record.
    met_hexadecimal: bool,
    atoms_before: usize,
    /// Inside MODEL … ENDMDL: CONECT there concerns this model alone.
    in_model: bool,
    model_number: Option<i64>,
    title: String,
    cell: Option<Cell>,
    space_group: String,
    operations: Vec<SymmetryOperation>,
    /// REMARK 290 that no CRYST1 was read with yet.
    symmetry_rows: symmetry::Rows,
    /// REMARK 350, and whether it was checked.
    assemblies: assembly::Lines,
    has_checked_assemblies: bool,
    /// CONECT of the model being read.
    conects: Vec<Conect>,
    /// CONECT of all models of the entry.
    entry_conects: Vec<Conect>,
    links: Vec<Link>,
    secondary: Vec<SecondaryElement>,
    /// Records of this entry with their own CONECT, for which bonds are still to be found.
    pending: Vec<(usize, Vec<Conect>)>,
    states_bonds: bool,
    budget: Budget,
    copies: Budget,
    oddities: Oddities,
}

impl Reader {
    fn new() -> Reader {
        Reader {
            builder: StructureBuilder::new(),
            decimals: 0,
            met_hexadecimal: false,
            atoms_before: 0,
            in_model: false,
            model_number: None,
            title: String::new(),
            cell: None,
            space_group: String::new(),
            operations: Vec::new(),
            symmetry_rows: symmetry::Rows::default(),
            assemblies: assembly::Lines::default(),
            has_checked_assemblies: false,
            conects: Vec::new(),
            entry_conects: Vec::new(),
            links: Vec::new(),
            secondary: Vec::new(),
            pending: Vec::new(),
            states_bonds: false,
            budget: Budget::default(),
            copies: Budget::new(MAX_COPIES),
            oddities: Oddities::default(),
        }
    }

    fn other_record(
        &mut self,
        record: &[u8],
        line: &[u8],
        number: u64,
        records: &mut Records,
        diagnostics: &mut Diagnostics,
    ) {
        match record {
            b"HEADER" => {
                self.end_model(records, diagnostics);
                if !self.pending.is_empty() {
                    self.end_entry(records, diagnostics);
                    self.begin_entry();
                }
            }
            b"TITLE" => {
                let text = lossy(field(line, 10, 80));
                if !self.title.is_empty() && !text.is_empty() {
                    self.title.push(' ');
                }
                // A title is some lines; a file of nothing but TITLE records must not make it grow without end.
                if self.title.len() < 1000 {
                    self.title.push_str(&text);
                }
            }
            b"CRYST1" => {
                self.operations.clear();
                self.cell(line, number, diagnostics);
                self.take_symmetry();
            }
            b"REMARK" if assembly::is_line(line) => self.assemblies.push(line, number, &mut self.oddities.assembly),
            b"REMARK" => self.symmetry_rows.push(line, number, &mut self.oddities.symmetry),
            b"MODEL" => {
                self.end_model(records, diagnostics);
                self.in_model = true;
                let model = parse_i64(field(line, 6, 14));
                if let Some(model) = model.filter(|_| model == self.model_number) {
                    self.oddities.model.note(number, || format!("model {model} follows another model {model}"));
                }
                self.model_number = model;
            }
            b"ENDMDL" | b"END" => {
                self.end_model(records, diagnostics);
                self.in_model = false;
            }
            b"CONECT" => self.conect(line, number),
            b"SSBOND" => {
                let end = |at: usize, number_at: usize| LinkEnd {
                    atom: "SG".to_owned(),
                    altloc: b' ',
                    residue: lossy(field(line, at, at + 3)).into_owned(),
                    chain: lossy(field(line, at + 4, at + 5)).into_owned(),
                    number: self.link_number(columns(line, number_at, number_at + 4)),
                    insertion_code: line.get(number_at + 4).copied().unwrap_or(b' '),
                };
                let ends = [end(11, 17), end(25, 31)];
                self.link(Link { line: number, ends, disulfide: true }, line);
            }
            b"LINK" | b"LINKR" => {
                let end = |at: usize| LinkEnd {
                    atom: lossy(field(line, at, at + 4)).into_owned(),
                    altloc: line.get(at + 4).copied().unwrap_or(b' '),
                    residue: lossy(field(line, at + 5, at + 8)).into_owned(),
                    chain: lossy(field(line, at + 9, at + 10)).into_owned(),
                    number: self.link_number(columns(line, at + 10, at + 14)),
                    insertion_code: line.get(at + 14).copied().unwrap_or(b' '),
                };
                let ends = [end(12), end(42)];
                self.link(Link { line: number, ends, disulfide: false }, line);
            }
            b"HELIX" => self.secondary(line, true, (19, 21), (31, 33)),
            b"SHEET" => self.secondary(line, false, (21, 22), (32, 33)),
            _ => {}
        }
    }

    fn link_number(&self, text: &[u8]) -> i32 {
        let number = NumberColumn::new(4).read(text.trim_ascii());
        number.and_then(|number| i32::try_from(number).ok()).unwrap_or(i32::MIN)
    }

    fn link(&mut self, link: Link, line: &[u8]) {
        if bonds::stays_in_asymmetric_unit(line) {
            self.states_bonds = true;
            self.links.push(link);
        } else {
            self.oddities.link.note(link.line, || "the bond goes to a symmetry mate and is left out".to_owned());
        }
    }

    fn secondary(&mut self, line: &[u8], helix: bool, first: (usize, usize), last: (usize, usize)) {
        let end = |at: usize| {
            let number = parse_i64(field(line, at, at + 4)).and_then(|number| i32::try_from(number).ok());
            number.map(|number| (number, line.get(at + 4).copied().unwrap_or(b' ')))
        };
        if let (Some(start), Some(end)) = (end(first.1), end(last.1)) {
            let chain = lossy(field(line, first.0, first.0 + 1)).into_owned();
            self.secondary.push(SecondaryElement { helix, chain, first: start, last: end });
        }
    }

    fn cell(&mut self, line: &[u8], number: u64, diagnostics: &mut Diagnostics) {
        let value = |from, to| parse_f64(field(line, from, to)).map(|(value, _)| value);
        let lengths = [value(6, 15), value(15, 24), value(24, 33)];
        let angles = [value(33, 40), value(40, 47), value(47, 54)];
        let ([Some(a), Some(b), Some(c)], [Some(alpha), Some(beta), Some(gamma)]) = (lengths, angles) else {
            diagnostics.warn(Some(number), "CRYST1 does not hold three lengths and three angles; there is no cell");
            self.cell = None;
            return;
        };
        // 1 × 1 × 1 (wwPDB, for NMR and electron microscopy) and 0 × 0 × 0 (programs) say that there is no cell.
        if [a, b, c].iter().all(|&length| length == 1.0) || [a, b, c].iter().all(|&length| length == 0.0) {
            self.cell = None;
            return;
        }
        self.cell = Cell::from_parameters([a, b, c], [alpha, beta, gamma]);
        if self.cell.is_none() {
            diagnostics.warn(Some(number), format!("CRYST1 {a} {b} {c} {alpha} {beta} {gamma} spans no cell"));
        }
        self.space_group = lossy(field(line, 55, 66)).into_owned();
    }

    /// The operations of REMARK 290, if it was met and there is a cell.
    fn take_symmetry(&mut self) {
        if let Some(cell) = self.cell.filter(|_| !self.symmetry_rows.is_empty()) {
            let rows = std::mem::take(&mut self.symmetry_rows);
            self.operations = rows.operations(&cell, &mut self.oddities.symmetry);
        }
    }

    fn conect(&mut self, line: &[u8], number: u64) {
        self.states_bonds = true;
        let from_text = field(line, 6, 11);
        let from = self.conect_serial(from_text);
        for at in [11, 16, 21, 26] {
            let text = field(line, at, at + 5);
            if text.is_empty() {
                continue;
            }
            let (Some(from), Some(to)) = (from, self.conect_serial(text)) else {
                let record = || {
                    format!("`{}` of CONECT is no serial number; that bond is left out", shown(columns(line, 6, 31)))
                };
                self.oddities.conect.note(number, record);
                continue;
            };
            // Inside a model, or behind the atoms of a file without models.
            let local = self.in_model || self.atoms_before > 0;
            let list = if local { &mut self.conects } else { &mut self.entry_conects };
            list.push(Conect { line: number, from, to });
        }
    }

    /// A serial number of a CONECT record.
    fn conect_serial(&self, text: &[u8]) -> Option<Serial> {
        let narrow = |value: i64| i32::try_from(value).ok();
        let hexadecimal = if self.met_hexadecimal && text.len() == 5 { number::hexadecimal(text) } else { None };
        let hexadecimal = hexadecimal.filter(|&value| value > 99_999).and_then(narrow);
        match parse_i64(text).or_else(|| number::hybrid36(text, 5).filter(|_| hexadecimal.is_none())).and_then(narrow) {
            Some(serial) => Some((serial, hexadecimal)),
            None => Some((hexadecimal.or_else(|| number::hexadecimal(text).and_then(narrow))?, None)),
        }
    }

    /// Closes the model being read, if it has atoms.
    fn end_model(&mut self, records: &mut Records, diagnostics: &mut Diagnostics) {
        let conects = std::mem::take(&mut self.conects);
        if self.builder.atom_count() == 0 {
            return;
        }
        let mut builder = std::mem::replace(&mut self.builder, StructureBuilder::new());
        builder.set_decimals(self.decimals);
        builder.set_title(self.title.clone());
        builder.set_cell(self.cell);
        // REMARK 290 may also stand behind CRYST1.
        self.take_symmetry();
        if self.cell.is_some() && !(self.space_group.is_empty() && self.operations.is_empty()) {
            let (space_group, operations) = (self.space_group.clone(), self.operations.clone());
            builder.set_symmetry(Some(Symmetry { space_group, operations }));
        }
        // Every record gets its copy, so that the number of copies is bounded, too.
        if self.copies.spend(self.secondary.len()) {
            for element in &self.secondary {
                builder.push_secondary(element.clone());
            }
        }
        let mut structure = builder.build(diagnostics);
        if !std::mem::replace(&mut self.has_checked_assemblies, true) {
            self.assemblies.check(&mut self.oddities.assembly);
        }
        if self.copies.spend(self.assemblies.cost()) {
            structure.assemblies = self.assemblies.resolve(&structure);
        }
        let Some(record) = records.push_frame(structure) else { return };
        match self.pending.last() {
            // A further frame of the last record: what the first frame says holds.
            Some(&(last, _)) if last == record => {}
            _ => self.pending.push((record, conects)),
        }
    }

    /// Closes the entry: finds the atoms of its bonds.
    fn end_entry(&mut self, records: &mut Records, diagnostics: &mut Diagnostics) {
        let stated = if self.states_bonds { StatedBonds::Partial } else { StatedBonds::None };
        for (record, conects) in std::mem::take(&mut self.pending) {
            if !self.states_bonds {
                continue;
            }
            records.update(record, |structure| {
                let lists = [conects.as_slice(), &self.entry_conects];
                let bonds = bonds::resolve(&structure, &lists, &self.links, &mut self.budget, diagnostics);
                let mut structure = structure.with_bonds(bonds);
                structure.stated_bonds = stated;
                structure
            });
        }
    }

    /// A further entry in the same file: nothing of the last one's header holds for it.
    fn begin_entry(&mut self) {
        self.title.clear();
        self.cell = None;
        self.space_group.clear();
        self.operations.clear();
        self.symmetry_rows = symmetry::Rows::default();
        self.assemblies = assembly::Lines::default();
        self.has_checked_assemblies = false;
        self.entry_conects.clear();
        self.links.clear();
        self.secondary.clear();
        self.states_bonds = false;
    }
}

#[cfg(test)]
mod tests;
