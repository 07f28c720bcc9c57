//! Protein Data Bank files.
//!
//! Specification: wwPDB, "Protein Data Bank Contents Guide: Atomic Coordinate Entry Format Description", version 3.30
//! (2012), <https://www.wwpdb.org/documentation/file-format-content/format33/v3.3.html>.
//! Read are TITLE, CRYST1, MODEL, ATOM, HETATM, ENDMDL, CONECT, SSBOND, LINK, HELIX, SHEET, END, HEADER (begins a
//! further entry); all other records are passed over.
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
//! Not read: bonds to symmetry mates (they have no atoms here), SCALE and ORIGX, ANISOU, hydrogen bonds of old CONECT.

mod bonds;
pub(super) mod element;
mod fields;
mod number;

use super::collect::Records;
use super::number::{parse_f64, parse_i64};
use super::text::{Lines, Repeated, columns, field, lossy, shown};
use crate::error::{Error, Result};
use crate::structure::{
    AtomRecord, Cell, Diagnostics, SecondaryElement, StatedBonds, StructureBuilder, Symmetry, atom_flags,
};
use bonds::{Budget, Conect, Link, LinkEnd, Serial};
use element::Guess;
use fields::{charge, no_position_message, position, residue_and_chain, text_of};
use number::NumberColumn;

pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut lines = Lines::new(text, records.limits().line_bytes);
    let mut reader = Reader::new(text);
    while let Some(line) = lines.next() {
        let number = lines.number();
        match columns(line, 0, 6) {
            [b'A', b'T', b'O', b'M', b' ' | b'0'..=b'9', b' ' | b'0'..=b'9'] => reader.atom(line, number, 0),
            b"HETATM" => reader.atom(line, number, atom_flags::HETERO),
            // Everything else begins neither with these nor, in a large file, is there much of it.
            record => {
                reader.other_record(record.trim_ascii_end(), line, number, records, diagnostics);
                continue;
            }
        }
        records.check_atoms(reader.builder.atom_count(), number)?;
    }
    lines.check()?;
    reader.end_model(records, diagnostics);
    reader.end_entry(records, diagnostics);
    reader.oddities.report(diagnostics);
    if records.is_empty() {
        return Err(reader
            .oddities
            .error()
            .unwrap_or_else(|| Error::input(None, "the file has no ATOM or HETATM record")));
    }
    Ok(())
}

/// Helices and strands that all records of a file together may hold.
const MAX_COPIES: usize = 1_000_000;

/// What may occur on many lines.
#[derive(Debug, Default)]
struct Oddities {
    no_position: Repeated,
    short: Repeated,
    no_element: Repeated,
    serial: Repeated,
    residue_number: Repeated,
    unknown_element: Repeated,
    guessed_element: Repeated,
    wrong_element: Repeated,
    model: Repeated,
    conect: Repeated,
    link: Repeated,
}

impl Oddities {
    fn report(&self, diagnostics: &mut Diagnostics) {
        self.no_position.error(diagnostics);
        for oddity in [
            &self.short,
            &self.no_element,
            &self.serial,
            &self.residue_number,
            &self.unknown_element,
            &self.guessed_element,
            &self.wrong_element,
            &self.model,
            &self.conect,
            &self.link,
        ] {
            oddity.warn(diagnostics);
        }
    }

    fn error(&self) -> Option<Error> {
        self.no_position.message().map(|(line, message)| Error::input(line, message))
    }
}

struct Reader<'a> {
    text: &'a [u8],
    builder: StructureBuilder,
    decimals: u8,
    serials: NumberColumn,
    residue_numbers: NumberColumn,
    aligned: Option<bool>,
    /// Inside MODEL … ENDMDL: CONECT there concerns this model alone.
    in_model: bool,
    model_number: Option<i64>,
    title: String,
    cell: Option<Cell>,
    space_group: String,
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

impl<'a> Reader<'a> {
    fn new(text: &'a [u8]) -> Reader<'a> {
        Reader {
            text,
            builder: StructureBuilder::new(),
            decimals: 0,
            serials: NumberColumn::new(5),
            residue_numbers: NumberColumn::new(4),
            aligned: None,
            in_model: false,
            model_number: None,
            title: String::new(),
            cell: None,
            space_group: String::new(),
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

    #[inline]
    fn atom(&mut self, line: &[u8], line_number: u64, flags: u8) {
        let Some((position, decimals)) = position(line) else {
            self.oddities.no_position.note(line_number, || no_position_message(line));
            return;
        };
        self.decimals = self.decimals.max(decimals);
        let serial = self.serial(line, line_number);
        let (residue_name, chain) = residue_and_chain(line);
        let (residue_number, insertion_code) = self.residue_number(line, line_number);
        let meaning = self.element(line, residue_name, line_number);
        if line.len() < 60 {
            self.oddities.short.note(line_number, || "the line has no occupancy; taken as 1".to_owned());
        }
        let name = text_of(field(line, 12, 16));
        let (residue_name, chain) = (text_of(residue_name), text_of(chain));
        let value =
            |from, to| parse_f64(field(line, from, to)).map(|(value, _)| value as f32).filter(|v| v.is_finite());
        self.builder.push_atom(&AtomRecord {
            element: meaning.element,
            position,
            name: &name,
            serial: Some(serial),
            residue: Some((&chain, residue_number, insertion_code, &residue_name)),
            flags: flags | if meaning.particle { atom_flags::PARTICLE } else { 0 },
            altloc: line.get(16).copied().unwrap_or(b' '),
            occupancy: value(54, 60).unwrap_or(1.0),
            b_factor: value(60, 66).unwrap_or(0.0),
            formal_charge: charge(columns(line, 78, 80)),
            isotope: meaning.isotope,
            ..AtomRecord::default()
        });
    }

    #[inline]
    fn serial(&mut self, line: &[u8], line_number: u64) -> i32 {
        // Columns 5 and 6 of ATOM and 12 are blank, unless the number needed them.
        let from = if line[0] == b'A' { 4 } else { 6 };
        let to = if line.get(11).is_some_and(u8::is_ascii_digit) { 12 } else { 11 };
        let text = field(line, from, to);
        let serial = self.serials.read(text).and_then(|serial| i32::try_from(serial).ok());
        serial.unwrap_or_else(|| {
            // Stars and blanks are how programs say that they ran out of digits.
            if !text.is_empty() && !text.contains(&b'*') {
                let message = || format!("the serial number `{}` is no number; counted on instead", shown(text));
                self.oddities.serial.note(line_number, message);
            }
            i32::try_from(self.serials.count_on()).unwrap_or(i32::MAX)
        })
    }

    #[inline]
    fn residue_number(&mut self, line: &[u8], line_number: u64) -> (i32, u8) {
        let insertion_code = line.get(26).copied().unwrap_or(b' ');
        let text = columns(line, 22, 26);
        if insertion_code.is_ascii_digit() && text.last().is_some_and(u8::is_ascii_digit) {
            // A number of five digits has run over into the column of the insertion code.
            if let Some(number) = parse_i64(field(line, 22, 27)).and_then(|number| i32::try_from(number).ok()) {
                return (number, b' ');
            }
        }
        let text = text.trim_ascii();
        let number = self.residue_numbers.read(text).and_then(|number| i32::try_from(number).ok());
        let number = number.unwrap_or_else(|| {
            if !text.is_empty() {
                let message = || format!("the residue number `{}` is no number; taken as 0", shown(text));
                self.oddities.residue_number.note(line_number, message);
            }
            0
        });
        (number, insertion_code)
    }

    #[inline]
    fn element(&mut self, line: &[u8], residue: &[u8], line_number: u64) -> Guess {
        let symbol = field(line, 76, 78);
        let name = columns(line, 12, 16);
        if let Some(guess) = Guess::of(symbol) {
            if symbol.len() < 2 || !element::contradicts(symbol, name, residue) {
                return guess;
            }
            self.oddities.wrong_element.note(line_number, || {
                let (symbol, name, residue) = (shown(symbol), shown(name), shown(residue));
                format!("element {symbol} is impossible for atom {name} of {residue}; the name is believed")
            });
            return self.guess(name, residue);
        }
        let guess = self.guess(name, residue);
        // Digits are line numbers of files before version 2.
        if symbol.is_empty() || symbol.iter().any(u8::is_ascii_digit) {
            let message = || "the line has no element column; the element is taken from the atom's name".to_owned();
            self.oddities.no_element.note(line_number, message);
        } else {
            self.oddities.guessed_element.note(line_number, || {
                format!("`{}` is no element symbol; the element is taken from the atom's name", shown(symbol))
            });
        }
        if guess.element.z() == 0 && !guess.particle {
            self.oddities.unknown_element.note(line_number, || {
                format!("no element is known for the atom named `{}`; it is kept without one", shown(name.trim_ascii()))
            });
        }
        guess
    }

    fn guess(&mut self, name: &[u8], residue: &[u8]) -> Guess {
        let (text, aligned) = (self.text, &mut self.aligned);
        element::guess(name, residue, || {
            *aligned.get_or_insert_with(|| {
                let atoms = |line: &&[u8]| line.starts_with(b"ATOM  ") || line.starts_with(b"HETATM");
                element::is_aligned(Lines::new(text, usize::MAX).filter(atoms))
            })
        })
    }

    #[inline(never)]
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
            b"CRYST1" => self.cell(line, number, diagnostics),
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
            let local = self.in_model || self.builder.atom_count() > 0;
            let list = if local { &mut self.conects } else { &mut self.entry_conects };
            list.push(Conect { line: number, from, to });
        }
    }

    /// A serial number of a CONECT record.
    fn conect_serial(&self, text: &[u8]) -> Option<Serial> {
        let narrow = |value: i64| i32::try_from(value).ok();
        let hexadecimal =
            if self.serials.met_hexadecimal && text.len() == 5 { number::hexadecimal(text) } else { None };
        let hexadecimal = hexadecimal.filter(|&value| value > 99_999).and_then(narrow);
        match parse_i64(text).or_else(|| number::hybrid36(text, 5).filter(|_| hexadecimal.is_none())).and_then(narrow) {
            Some(serial) => Some((serial, hexadecimal)),
            None => Some((hexadecimal.or_else(|| number::hexadecimal(text).and_then(narrow))?, None)),
        }
    }

    /// Closes the model being read, if it has atoms.
    fn end_model(&mut self, records: &mut Records, diagnostics: &mut Diagnostics) {
        self.serials.restart();
        self.residue_numbers.restart();
        let conects = std::mem::take(&mut self.conects);
        if self.builder.atom_count() == 0 {
            return;
        }
        let mut builder = std::mem::replace(&mut self.builder, StructureBuilder::new());
        builder.set_decimals(self.decimals);
        builder.set_title(self.title.clone());
        builder.set_cell(self.cell);
        if self.cell.is_some() && !self.space_group.is_empty() {
            let space_group = self.space_group.clone();
            builder.set_symmetry(Some(Symmetry { space_group, operations: Vec::new() }));
        }
        // Every record gets its copy, so that the number of copies is bounded, too.
        if self.copies.spend(self.secondary.len()) {
            for element in &self.secondary {
                builder.push_secondary(element.clone());
            }
        }
        let Some(record) = records.push_frame(builder.build(diagnostics)) else { return };
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
        self.entry_conects.clear();
        self.links.clear();
        self.secondary.clear();
        self.states_bonds = false;
    }
}

#[cfg(test)]
mod tests;
