//! One record: header, connection table, property block, data items.

use super::super::collect::Records;
use super::super::is_plausible;
use super::super::number::{parse_f64, parse_i64};
use super::super::symbol::{Label, LabelKind, read_label};
use super::super::text::{Repeated, columns, field, lossy, shown, words};
use super::{is_counts_line, v3000};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::structure::{
    AtomRecord, Bond, BondKind, BondOrder, BondSource, BondStereo, Diagnostics, StatedBonds, Structure,
    StructureBuilder, atom_flags,
};
use glam::DVec3;

/// The line with each UTF-8 no-break space as one blank; `None` if there is none (editors and web pages leave them).
pub(super) fn without_no_break_spaces(line: &[u8]) -> Option<Vec<u8>> {
    let text = std::str::from_utf8(line).ok()?;
    text.contains('\u{a0}').then(|| text.replace('\u{a0}', " ").into_bytes())
}

/// Reads the lines of a record (without its `$$$$`).
pub(super) fn read(
    lines: &[&[u8]],
    first_line: u64,
    records: &Records,
    diagnostics: &mut Diagnostics,
) -> Result<Structure> {
    let number = |index: usize| first_line + index as u64;
    let counts_index = find_counts(lines);
    if counts_index != 3 {
        diagnostics.warn(Some(number(counts_index)), "the counts line should be the fourth line of its record");
    }
    let Some(&counts_line) = lines.get(counts_index) else {
        return Err(Error::input(number(lines.len()), "the record ends before its counts line (its fourth line)"));
    };
    let mut table = Table::default();
    table.builder.set_stated_bonds(StatedBonds::Complete);
    let title = counts_index.checked_sub(3).and_then(|index| lines.get(index)).copied().unwrap_or_default();
    table.builder.set_title(lossy(title.trim_ascii()));
    if says_v3000(counts_line) {
        let next = v3000::read(&mut table, lines, counts_index + 1, first_line, records)?;
        table.data_items(lines.get(next..).unwrap_or_default());
        return Ok(table.finish(diagnostics));
    }
    let (atom_count, bond_count) = read_counts(counts_line, number(counts_index))?;
    records.check_atoms(atom_count, number(counts_index))?;
    if atom_count == 0 {
        return Err(Error::input(number(counts_index), "the molecule has 0 atoms"));
    }

    let mut next = counts_index + 1;
    for index in 0..atom_count {
        let Some(line) = lines.get(next) else {
            let message = format!("expected {atom_count} atoms as the counts line says, the record ends after {index}");
            return Err(Error::input(number(next), message));
        };
        table.atom(line, number(next))?;
        next += 1;
    }
    for index in 0..bond_count {
        let Some(line) = lines.get(next) else {
            let message = format!("expected {bond_count} bonds as the counts line says, the record ends after {index}");
            return Err(Error::input(number(next), message));
        };
        table.bond(line, number(next))?;
        next += 1;
    }
    let next = table.properties(lines, next, first_line);
    table.data_items(lines.get(next..).unwrap_or_default());
    Ok(table.finish(diagnostics))
}

/// Index of the counts line: the fourth, or one near it that has a version tag where the fourth has none.
fn find_counts(lines: &[&[u8]]) -> usize {
    if lines.get(3).is_some_and(|line| is_counts_line(line)) {
        return 3;
    }
    lines.iter().take(12).position(|line| is_counts_line(line)).unwrap_or(3)
}

/// Whether the counts line hands over to a V3000 table.
fn says_v3000(line: &[u8]) -> bool {
    let cleaned = without_no_break_spaces(line);
    cleaned.as_deref().unwrap_or(line).trim_ascii().ends_with(b"V3000")
}

fn read_counts(line: &[u8], number: u64) -> Result<(usize, usize)> {
    let cleaned = without_no_break_spaces(line);
    let line = cleaned.as_deref().unwrap_or(line);
    let count = |text: &[u8]| parse_i64(text).and_then(|count| usize::try_from(count).ok());
    let in_columns = match (count(field(line, 0, 3)), field(line, 3, 6)) {
        (Some(atoms), b"") => Some((atoms, 0)),
        (Some(atoms), bonds) => count(bonds).map(|bonds| (atoms, bonds)),
        _ => None,
    };
    let by_words = || {
        let mut words = words(line);
        Some((count(words.next()?)?, count(words.next()?)?))
    };
    in_columns.or_else(by_words).ok_or_else(|| {
        Error::input(
            number,
            format!("expected the counts line (atoms and bonds, three columns each), found `{}`", shown(line)),
        )
    })
}

/// A connection table being read.
#[derive(Debug, Default)]
pub(super) struct Table {
    pub(super) builder: StructureBuilder,
    decimals: u8,
    /// Charges and radicals, or isotopes, of the atom block are superseded.
    charges_replaced: bool,
    isotopes_replaced: bool,
    unknown: Repeated,
    pub(super) odd_field: Repeated,
    bad_bond: Repeated,
    bad_property: Repeated,
    pairs: Vec<(u32, u32)>,
}

impl Table {
    fn atom(&mut self, line: &[u8], number: u64) -> Result<()> {
        let atom = atom_in_columns(line).or_else(|| atom_by_words(line));
        let Some((position, decimals, symbol)) = atom else {
            let message = format!("expected an atom (x, y, z in ten columns each, symbol), found `{}`", shown(line));
            return Err(Error::input(number, message));
        };
        let label = read_symbol(symbol);
        let mass_difference = self.small_number(field(line, 34, 36), number);
        let charge_code = self.small_number(field(line, 36, 39), number);
        let isotope = match mass_difference {
            // Relative to the mass number nearest the atomic weight.
            -3..=4 if mass_difference != 0 && label.element != Element::DUMMY => {
                u16::try_from(i64::from(label.element.mass().round() as i32) + mass_difference).unwrap_or(0)
            }
            _ => label.isotope,
        };
        let (formal_charge, radical) = match charge_code {
            1..=3 => (4 - charge_code as i8, 0),
            4 => (0, 2),
            5..=7 => (4 - charge_code as i8, 0),
            _ => (0, 0),
        };
        let stated = Stated { isotope, formal_charge, radical };
        self.push_atom(symbol, label, position, decimals, stated, number)
    }

    /// Adds an atom.
    pub(super) fn push_atom(
        &mut self,
        symbol: &[u8],
        label: Label,
        position: DVec3,
        decimals: u8,
        stated: Stated,
        number: u64,
    ) -> Result<()> {
        if !is_plausible(position) {
            return Err(Error::input(number, format!("the position {position} cannot be used")));
        }
        self.decimals = self.decimals.max(decimals);
        if label.kind == LabelKind::Unknown {
            self.unknown.note(number, || format!("`{}` is no element symbol; kept without an element", shown(symbol)));
        }
        let name = lossy(symbol);
        self.builder.push_atom(&AtomRecord {
            element: label.element,
            position,
            name: if label.element == Element::DUMMY { &name } else { "" },
            flags: if label.particle { atom_flags::PARTICLE } else { 0 },
            isotope: stated.isotope,
            formal_charge: stated.formal_charge,
            radical: stated.radical,
            ..AtomRecord::default()
        });
        Ok(())
    }

    /// An optional field of an atom line; 0 if it is blank or no number.
    fn small_number(&mut self, text: &[u8], number: u64) -> i64 {
        if text.is_empty() {
            return 0;
        }
        parse_i64(text).unwrap_or_else(|| {
            self.odd_field.note(number, || format!("`{}` in the atom line is no number; taken as 0", shown(text)));
            0
        })
    }

    fn bond(&mut self, line: &[u8], number: u64) -> Result<()> {
        let in_columns =
            || Some([parse_i64(field(line, 0, 3))?, parse_i64(field(line, 3, 6))?, parse_i64(field(line, 6, 9))?]);
        let by_words = || {
            let mut words = words(line).map(parse_i64);
            Some([words.next()??, words.next()??, words.next()??])
        };
        let Some([a, b, kind]) = in_columns().or_else(by_words) else {
            let message =
                format!("expected a bond (two atoms and a type, three columns each), found `{}`", shown(line));
            return Err(Error::input(number, message));
        };
        let count = self.builder.atom_count();
        let index = |atom: i64| {
            usize::try_from(atom).ok().filter(|atom| (1..=count).contains(atom)).map(|atom| (atom - 1) as u32)
        };
        let stereo = match parse_i64(field(line, 9, 12)) {
            Some(1) => Some(BondStereo::Up),
            Some(6) => Some(BondStereo::Down),
            Some(4) => Some(BondStereo::Either),
            Some(3) if kind == 2 => Some(BondStereo::CisTransEither),
            _ => None,
        };
        match (index(a).filter(|_| a != b), index(b)) {
            (Some(a), Some(b)) => self.push_bond([a, b], kind, stereo, number),
            _ => self.refuse_bond([a, b], number),
        }
        Ok(())
    }

    /// Notes that a bond names atoms that are not there.
    pub(super) fn refuse_bond(&mut self, [a, b]: [i64; 2], number: u64) {
        let count = self.builder.atom_count();
        self.bad_bond.note(number, || format!("a bond between atoms {a} and {b} of {count} cannot be; it is left out"));
    }

    /// Adds a bond of a type, 1 to 10.
    pub(super) fn push_bond(&mut self, [a, b]: [u32; 2], kind: i64, stereo: Option<BondStereo>, number: u64) {
        let metal = [a, b].iter().any(|&atom| self.builder.elements()[atom as usize].is_metal());
        let (order, kind, aromatic) = match kind {
            1..=3 => (BondOrder::from_number(kind as u32), BondKind::Covalent, false),
            4 | 6 | 7 => (BondOrder::Unknown, BondKind::Covalent, true),
            0 | 8 if metal => (BondOrder::Unknown, BondKind::Coordination, false),
            9 => (BondOrder::Unknown, BondKind::Dative, false),
            10 => (BondOrder::Unknown, BondKind::Hydrogen, false),
            0 | 5 | 8 => (BondOrder::Unknown, BondKind::Covalent, false),
            _ => {
                let message = || format!("bond type {kind} is none of 1 to 10; taken as a bond of unknown order");
                self.odd_field.note(number, message);
                (BondOrder::Unknown, BondKind::Covalent, false)
            }
        };
        self.pairs.push((a.min(b), a.max(b)));
        self.builder.push_bond(Bond { kind, aromatic, ..Bond::new(a, b, order, BondSource::File) });
        if let Some(stereo) = stereo {
            self.builder.push_bond_stereo(a, b, stereo);
        }
    }

    /// Adds a bond between a metal and one atom of a ligand that it binds as a whole.
    pub(super) fn push_coordination(&mut self, a: u32, b: u32) {
        self.pairs.push((a.min(b), a.max(b)));
        let bond = Bond::new(a, b, BondOrder::Unknown, BondSource::File);
        self.builder.push_bond(Bond { kind: BondKind::Coordination, ..bond });
    }

    /// The property block; returns the index of the line behind it.
    fn properties(&mut self, lines: &[&[u8]], start: usize, first_line: u64) -> usize {
        let mut next = start;
        while let Some(&line) = lines.get(next) {
            let number = first_line + next as u64;
            next += 1;
            match columns(line, 0, 6) {
                [b'>', ..] => return next - 1, // no `M  END`
                b"M  END" => return next,
                b"M  CHG" => {
                    self.replace_charges();
                    self.property(line, number, |builder, atom, value| {
                        i8::try_from(value).map(|value| builder.set_formal_charge(atom, value)).is_ok()
                    });
                }
                b"M  RAD" => {
                    self.replace_charges();
                    self.property(line, number, |builder, atom, value| {
                        u8::try_from(value).ok().filter(|&v| v <= 3).map(|v| builder.set_radical(atom, v)).is_some()
                    });
                }
                b"M  ISO" => {
                    self.replace_isotopes();
                    self.property(line, number, |builder, atom, value| {
                        // The heaviest nuclide known has 295 nucleons.
                        u16::try_from(value).ok().filter(|&v| v <= 400).map(|v| builder.set_isotope(atom, v)).is_some()
                    });
                }
                // An alias or abbreviation has its text on the next line, which must not be taken for a property.
                [b'A' | b'G', b' ', b' ', ..] => next += 1,
                b"S  SKP" => {
                    let skipped = parse_i64(field(line, 6, 9)).and_then(|count| usize::try_from(count).ok());
                    next += skipped.unwrap_or(0).min(lines.len());
                }
                _ => {}
            }
        }
        next
    }

    /// `M  CHG` and `M  RAD` supersede all charges and radicals of the atom block.
    fn replace_charges(&mut self) {
        if !std::mem::replace(&mut self.charges_replaced, true) {
            self.builder.clear_formal_charges();
            for atom in 0..self.builder.atom_count() {
                self.builder.set_radical(atom, 0);
            }
        }
    }

    /// `M  ISO` supersedes all mass differences of the atom block (what D and T say is no mass difference).
    fn replace_isotopes(&mut self) {
        if !std::mem::replace(&mut self.isotopes_replaced, true) {
            for atom in 0..self.builder.atom_count() {
                if self.builder.elements()[atom] != Element::H {
                    self.builder.set_isotope(atom, 0);
                }
            }
        }
    }

    /// The `atom value` pairs of a property line.
    fn property(&mut self, line: &[u8], number: u64, set: impl Fn(&mut StructureBuilder, usize, i64) -> bool) {
        let mut numbers = words(columns(line, 6, line.len())).map(parse_i64);
        let pairs = numbers.next().flatten().unwrap_or(0);
        let count = self.builder.atom_count();
        for _ in 0..pairs {
            let (Some(atom), Some(value)) = (numbers.next().flatten(), numbers.next().flatten()) else {
                self.bad_property.note(number, || format!("`{}` holds fewer pairs than it says", shown(line)));
                return;
            };
            let index = usize::try_from(atom).ok().filter(|atom| (1..=count).contains(atom));
            if !index.is_some_and(|atom| set(&mut self.builder, atom - 1, value)) {
                self.bad_property.note(number, || format!("{value} for atom {atom} in `{}` cannot be", shown(line)));
            }
        }
    }

    /// `> <NAME>`, its lines, a blank line.
    fn data_items(&mut self, lines: &[&[u8]]) {
        let mut lines = lines.iter().peekable();
        while let Some(line) = lines.next() {
            if !line.starts_with(b">") {
                continue;
            }
            let name = data_name(line);
            let mut value = String::new();
            while let Some(line) = lines.next_if(|line| !line.trim_ascii().is_empty()) {
                if !value.is_empty() {
                    value.push('\n');
                }
                value.push_str(&lossy(line));
            }
            self.builder.push_property(name, value);
        }
    }

    fn finish(mut self, diagnostics: &mut Diagnostics) -> Structure {
        self.pairs.sort_unstable();
        let distinct = self.pairs.chunk_by(|a, b| a == b).count();
        if distinct < self.pairs.len() {
            let message = format!("{} bonds are listed twice; the first of each is used", self.pairs.len() - distinct);
            diagnostics.warn(None, message);
        }
        self.bad_bond.error(diagnostics);
        for oddity in [&self.unknown, &self.odd_field, &self.bad_property] {
            oddity.warn(diagnostics);
        }
        self.builder.set_decimals(self.decimals);
        self.builder.build(diagnostics)
    }
}

/// What a table says of an atom beside symbol and position.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Stated {
    pub(super) isotope: u16,
    pub(super) formal_charge: i8,
    pub(super) radical: u8,
}

type AtomFields<'a> = (DVec3, u8, &'a [u8]);

fn atom_in_columns(line: &[u8]) -> Option<AtomFields<'_>> {
    let coordinate = |from| parse_f64(field(line, from, from + 10));
    let ((x, dx), (y, dy), (z, dz)) = (coordinate(0)?, coordinate(10)?, coordinate(20)?);
    let symbol = field(line, 30, 34);
    (!symbol.is_empty()).then_some((DVec3::new(x, y, z), dx.max(dy).max(dz), symbol))
}

fn atom_by_words(line: &[u8]) -> Option<AtomFields<'_>> {
    let mut words = words(line);
    let mut coordinate = || parse_f64(words.next()?);
    let ((x, dx), (y, dy), (z, dz)) = (coordinate()?, coordinate()?, coordinate()?);
    // A number there shows that this is a bond line, not an atom out of its columns.
    let symbol = words.next().filter(|symbol| symbol[0].is_ascii_alphabetic() || *symbol == b"*")?;
    Some((DVec3::new(x, y, z), dx.max(dy).max(dz), symbol))
}

/// The element of a symbol; query atoms, R-groups, lone pairs and polymer beads are particles.
pub(super) fn read_symbol(symbol: &[u8]) -> Label {
    let query: [&[u8]; 16] =
        [b"A", b"Q", b"X", b"M", b"L", b"LP", b"*", b"R", b"R#", b"AH", b"QH", b"XH", b"MH", b"Pol", b"Mod", b"Du"];
    let group = |symbol: &[u8]| symbol.len() > 1 && symbol[0] == b'R' && symbol[1..].iter().all(u8::is_ascii_digit);
    if query.contains(&symbol) || group(symbol) {
        return Label { element: Element::DUMMY, isotope: 0, particle: true, kind: LabelKind::Symbol };
    }
    match read_label(symbol) {
        guess @ Label { kind: LabelKind::Guess, .. } => {
            Label { element: Element::DUMMY, isotope: 0, kind: LabelKind::Unknown, ..guess }
        }
        label => label,
    }
}

/// The name of a data item: what stands in angle brackets, else the field number, else nothing.
fn data_name(line: &[u8]) -> String {
    let text = lossy(&line[1..]);
    match (text.find('<'), text.rfind('>')) {
        (Some(open), Some(close)) if open < close => text[open + 1..close].to_owned(),
        _ => text.trim().to_owned(),
    }
}
