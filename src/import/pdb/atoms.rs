//! Atom lines, one after another.

use super::super::number::{column_f64, parse_i64};
use super::super::text::{Lines, Repeated, columns, field, shown};
use super::element::{self, Guess};
use super::fields::{charge, no_position_message, position, residue_and_chain};
use super::number::NumberColumn;
use crate::error::Error;
use crate::structure::{AtomRecord, Diagnostics, StructureBuilder, atom_flags};
use std::sync::OnceLock;

/// What may occur on many atom lines.
#[derive(Debug, Default)]
pub(super) struct Oddities {
    no_position: Repeated,
    short: Repeated,
    no_element: Repeated,
    serial: Repeated,
    residue_number: Repeated,
    unknown_element: Repeated,
    guessed_element: Repeated,
    wrong_element: Repeated,
}

impl Oddities {
    fn all(&mut self) -> [&mut Repeated; 8] {
        [
            &mut self.no_position,
            &mut self.short,
            &mut self.no_element,
            &mut self.serial,
            &mut self.residue_number,
            &mut self.unknown_element,
            &mut self.guessed_element,
            &mut self.wrong_element,
        ]
    }

    /// Takes over those of lines that begin behind line `base`.
    pub(super) fn absorb(&mut self, mut later: Oddities, base: u64) {
        for (kept, later) in self.all().into_iter().zip(later.all()) {
            kept.absorb(std::mem::take(later).shifted(base));
        }
    }

    pub(super) fn report(&mut self, diagnostics: &mut Diagnostics) {
        let [errors, warnings @ ..] = self.all();
        errors.error(diagnostics);
        for oddity in warnings {
            oddity.warn(diagnostics);
        }
    }

    pub(super) fn error(&self) -> Option<Error> {
        self.no_position.message().map(|(line, message)| Error::input(line, message))
    }
}

/// The columns whose meaning depends on the lines before.
#[derive(Debug, Clone)]
pub(super) struct Numbers {
    pub(super) serials: NumberColumn,
    pub(super) residues: NumberColumn,
}

impl Default for Numbers {
    fn default() -> Numbers {
        Numbers { serials: NumberColumn::new(5), residues: NumberColumn::new(4) }
    }
}

impl Numbers {
    /// A new model begins: numbers start again.
    pub(super) fn restart(&mut self) {
        self.serials.restart();
        self.residues.restart();
    }

    /// Whether the lines that follow mean the same behind both.
    pub(super) fn goes_on_as(&self, other: &Numbers) -> bool {
        self.serials.goes_on_as(&other.serials) && self.residues.goes_on_as(&other.residues)
    }

    /// Reads those of one line, as if no other had gone before.
    pub(super) fn read(&mut self, line: &[u8]) {
        if self.serials.read(serial_text(line)).is_none() {
            self.serials.count_on();
        }
        self.residues.read(field(line, 22, 26));
    }
}

#[inline]
fn serial_text(line: &[u8]) -> &[u8] {
    // Columns 5 and 6 of ATOM and 12 are blank, unless the number needed them.
    let from = if line[0] == b'A' { 4 } else { 6 };
    let to = if line.get(11).is_some_and(u8::is_ascii_digit) { 12 } else { 11 };
    field(line, from, to)
}

/// Reads the atom lines of a model, or of a part of it.
#[derive(Debug)]
pub(super) struct AtomReader<'a> {
    text: &'a [u8],
    /// Whether the file aligns its names, once anybody had to know.
    aligned: &'a OnceLock<bool>,
    pub(super) builder: StructureBuilder,
    /// Most decimals met.
    pub(super) decimals: u8,
    pub(super) numbers: Numbers,
    /// The columns of the residue that the last atom is in; `None` where they have to be looked at.
    residue: Option<[u8; 10]>,
    pub(super) oddities: Oddities,
}

impl<'a> AtomReader<'a> {
    /// `text` is the whole file's.
    pub(super) fn new(text: &'a [u8], aligned: &'a OnceLock<bool>) -> AtomReader<'a> {
        AtomReader {
            text,
            aligned,
            builder: StructureBuilder::new(),
            decimals: 0,
            numbers: Numbers::default(),
            residue: None,
            oddities: Oddities::default(),
        }
    }

    /// One for the same file that has met nothing.
    pub(super) fn fresh(&self) -> AtomReader<'a> {
        AtomReader::new(self.text, self.aligned)
    }

    /// The atoms so far, which a new model follows.
    pub(super) fn end_model(&mut self) -> StructureBuilder {
        self.numbers.restart();
        self.residue = None;
        std::mem::replace(&mut self.builder, StructureBuilder::new())
    }

    #[inline]
    pub(super) fn atom(&mut self, line: &[u8], line_number: u64, flags: u8) {
        let Some((position, decimals)) = position(line) else {
            self.oddities.no_position.note(line_number, || no_position_message(line));
            return;
        };
        self.decimals = self.decimals.max(decimals);
        let serial = self.serial(line, line_number);
        let (residue_name, chain) = residue_and_chain(line);
        // Most atoms are in the residue of the one before.
        let residue = line.get(17..27).and_then(|columns| <[u8; 10]>::try_from(columns).ok());
        if residue.is_none() || residue != self.residue {
            let (number, insertion_code, is_sound) = self.residue_number(line, line_number);
            self.builder.enter_residue(chain, number, insertion_code, residue_name);
            self.residue = residue.filter(|_| is_sound);
        }
        let meaning = self.element(line, residue_name, line_number);
        if line.len() < 60 {
            self.oddities.short.note(line_number, || "the line has no occupancy; taken as 1".to_owned());
        }
        let name = self.builder.name_id(field(line, 12, 16));
        let value = |from, to| column_f64(line, from, to).map(|(value, _)| value as f32).filter(|v| v.is_finite());
        let atom = AtomRecord {
            element: meaning.element,
            position,
            serial: Some(serial),
            flags: flags | if meaning.particle { atom_flags::PARTICLE } else { 0 },
            altloc: line.get(16).copied().unwrap_or(b' '),
            occupancy: value(54, 60).unwrap_or(1.0),
            b_factor: value(60, 66).unwrap_or(0.0),
            formal_charge: charge(columns(line, 78, 80)),
            isotope: meaning.isotope,
            ..AtomRecord::default()
        };
        self.builder.push_named_atom(&atom, name);
    }

    #[inline]
    fn serial(&mut self, line: &[u8], line_number: u64) -> i32 {
        let text = serial_text(line);
        let serial = self.numbers.serials.read(text).and_then(|serial| i32::try_from(serial).ok());
        serial.unwrap_or_else(|| {
            // Stars and blanks are how programs say that they ran out of digits.
            if !text.is_empty() && !text.contains(&b'*') {
                let message = || format!("the serial number `{}` is no number; counted on instead", shown(text));
                self.oddities.serial.note(line_number, message);
            }
            i32::try_from(self.numbers.serials.count_on()).unwrap_or(i32::MAX)
        })
    }

    /// Residue number, insertion code, and whether the same columns mean the same on the next line.
    #[inline]
    fn residue_number(&mut self, line: &[u8], line_number: u64) -> (i32, u8, bool) {
        let insertion_code = line.get(26).copied().unwrap_or(b' ');
        let text = columns(line, 22, 26);
        if insertion_code.is_ascii_digit() && text.last().is_some_and(u8::is_ascii_digit) {
            // A number of five digits has run over into the column of the insertion code.
            if let Some(number) = parse_i64(field(line, 22, 27)).and_then(|number| i32::try_from(number).ok()) {
                return (number, b' ', true);
            }
        }
        let text = text.trim_ascii();
        let number = self.numbers.residues.read(text).and_then(|number| i32::try_from(number).ok());
        let is_sound = number.is_some();
        let number = number.unwrap_or_else(|| {
            if !text.is_empty() {
                let message = || format!("the residue number `{}` is no number; taken as 0", shown(text));
                self.oddities.residue_number.note(line_number, message);
            }
            0
        });
        (number, insertion_code, is_sound)
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
        element::guess(name, residue, || {
            *self.aligned.get_or_init(|| {
                let atoms = |line: &&[u8]| line.starts_with(b"ATOM  ") || line.starts_with(b"HETATM");
                element::is_aligned(Lines::new(self.text, usize::MAX).filter(atoms))
            })
        })
    }
}
