//! `_atom_site`: rows to atoms, one builder a model.
//!
//! Author identifiers are what people know, so they are what is shown: `auth_asym_id`, `auth_seq_id`, `auth_comp_id`,
//! `auth_atom_id`, each with its label twin in its place if it is missing. Label identifiers still count: a change of
//! `label_asym_id` or `label_seq_id` begins a residue, as neighbouring waters may share their author numbers, and
//! `_struct_conn` is resolved by both.
//!
//! Temperature factors: B, or U as B = 8π²U (Trueblood et al., Acta Cryst. A 1996, 52, 770).

use super::label::{DisorderCodes, element_of_label, element_of_name, type_symbol};
use super::table::{ABSENT, Column, Row, Table};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::import::Limits;
use crate::import::text::{Repeated, shown};
use crate::structure::{AtomRecord, Diagnostics, NameId, Names, StructureBuilder, atom_flags};
use glam::DVec3;
use std::borrow::Cow;
use std::collections::HashMap;

/// B of U = 1 Å².
const B_OF_U: f64 = 8.0 * std::f64::consts::PI * std::f64::consts::PI;

/// The columns of `_atom_site` that are read.
#[derive(Debug, Clone)]
pub(in crate::import) struct Columns {
    pub(in crate::import) position: [Column; 3],
    pub(in crate::import) fractional: bool,
    pub(in crate::import) group: Column,
    pub(in crate::import) id: Column,
    pub(in crate::import) symbol: Column,
    /// The label of a small-molecule file.
    pub(in crate::import) label: Column,
    pub(in crate::import) name: [Column; 2],
    pub(in crate::import) altloc: Column,
    pub(in crate::import) residue_name: [Column; 2],
    pub(in crate::import) chain: [Column; 2],
    pub(in crate::import) number: [Column; 2],
    pub(in crate::import) label_chain: Column,
    pub(in crate::import) label_number: Column,
    pub(in crate::import) insertion_code: Column,
    pub(in crate::import) occupancy: Column,
    pub(in crate::import) b_factor: Column,
    pub(in crate::import) u_factor: Column,
    pub(in crate::import) charge: Column,
    pub(in crate::import) model: Column,
    pub(in crate::import) assembly: Column,
    pub(in crate::import) group_of_disorder: Column,
    pub(in crate::import) calculated: Column,
    pub(in crate::import) has_residues: bool,
}

impl Columns {
    /// From what tells the column of an item ([`Table::column`]); `None` if there are no coordinates.
    pub(in crate::import) fn find(column: impl Fn(&str) -> Column) -> Option<Columns> {
        let cartesian = ["Cartn_x", "Cartn_y", "Cartn_z"].map(&column);
        let fractional = ["fract_x", "fract_y", "fract_z"].map(&column);
        let whole = |columns: &[Column; 3]| !columns.contains(&ABSENT);
        let is_fractional = !whole(&cartesian);
        let position = if is_fractional { fractional } else { cartesian };
        let pair = |item: &str| {
            // The author's, then the label; both the same column where there is one.
            let [author, label] = [column(&format!("auth_{item}")), column(&format!("label_{item}"))];
            if author == ABSENT { [label, ABSENT] } else { [author, label] }
        };
        let (chain, number, residue_name) = (pair("asym_id"), pair("seq_id"), pair("comp_id"));
        let has_residues = [chain, number, residue_name].iter().flatten().any(|&column| column != ABSENT);
        whole(&position).then(|| Columns {
            position,
            fractional: is_fractional,
            group: column("group_PDB"),
            id: column("id"),
            symbol: column("type_symbol"),
            label: column("label"),
            name: pair("atom_id"),
            altloc: column("label_alt_id"),
            residue_name,
            chain,
            number,
            label_chain: column("label_asym_id"),
            label_number: column("label_seq_id"),
            insertion_code: column("pdbx_PDB_ins_code"),
            occupancy: column("occupancy"),
            b_factor: column("B_iso_or_equiv"),
            u_factor: column("U_iso_or_equiv"),
            charge: column("pdbx_formal_charge"),
            model: column("pdbx_PDB_model_num"),
            assembly: column("disorder_assembly"),
            group_of_disorder: column("disorder_group"),
            calculated: column("calc_flag"),
            has_residues,
        })
    }

    /// Whether rows can be read in parts without knowing those before: codes of disorder are given out in order.
    pub(super) fn are_independent(&self) -> bool {
        self.group_of_disorder == ABSENT && self.assembly == ABSENT
    }
}

/// Label identifiers of a residue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::import) struct ResidueLabel {
    /// `label_asym_id`, in [`Model::label_names`].
    pub(in crate::import) chain: NameId,
    /// `label_seq_id`.
    pub(in crate::import) number: Option<i64>,
}

/// One model: its atoms so far.
#[derive(Debug)]
pub(super) struct Model {
    number: i64,
    pub(super) builder: StructureBuilder,
    /// One a residue.
    pub(super) labels: Vec<ResidueLabel>,
    pub(super) label_names: Names,
    /// The residue being read, for comparing.
    last: ResidueKey,
    /// The residue that its first atom belongs to: whether two parts join there.
    first: Option<ResidueKey>,
}

/// What tells residues apart.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct ResidueKey {
    chain: String,
    number: i32,
    insertion_code: u8,
    name: String,
    label_chain: String,
    label_number: Option<i64>,
    /// In files without any numbers: the name of the first atom, which begins a residue when it comes again.
    first_atom: Option<String>,
}

impl Model {
    fn new(number: i64) -> Model {
        Model {
            number,
            builder: StructureBuilder::new(),
            labels: Vec::new(),
            label_names: Names::default(),
            last: ResidueKey::default(),
            first: None,
        }
    }
}

/// What may occur on many rows.
#[derive(Debug, Default)]
struct Oddities {
    no_position: Repeated,
    unknown_element: Repeated,
    guessed_element: Repeated,
    residue_number: Repeated,
    long_altloc: Repeated,
    models: Repeated,
}

/// The atoms of a data block, read so far.
#[derive(Debug)]
pub(in crate::import) struct AtomSites {
    pub(super) models: Vec<Model>,
    by_number: HashMap<i64, usize>,
    current: usize,
    pub(super) fractional: bool,
    pub(super) decimals: u8,
    limits: Limits,
    codes: DisorderCodes,
    oddities: Oddities,
}

impl AtomSites {
    pub(in crate::import) fn new(limits: &Limits) -> AtomSites {
        AtomSites {
            models: Vec::new(),
            by_number: HashMap::new(),
            current: 0,
            fractional: false,
            decimals: 0,
            limits: *limits,
            codes: DisorderCodes::default(),
            oddities: Oddities::default(),
        }
    }

    /// The atoms of one model that were read another way than by rows, with their residues' labels and the decimals of
    /// their positions.
    pub(in crate::import) fn of_one_model(
        builder: StructureBuilder,
        labels: Vec<ResidueLabel>,
        label_names: Names,
        decimals: u8,
        limits: &Limits,
    ) -> AtomSites {
        let model = Model { builder, labels, label_names, ..Model::new(1) };
        AtomSites { models: vec![model], decimals, ..AtomSites::new(limits) }
    }

    /// All rows of a table.
    ///
    /// # Errors
    /// A limit would be passed.
    pub(in crate::import) fn from_table(table: &impl Table, limits: &Limits) -> Result<AtomSites> {
        let mut sites = AtomSites::new(limits);
        if let Some(columns) = Columns::find(|item| table.column(item)) {
            sites.begin(&columns, table.row_count());
            for index in 0..table.row_count() {
                sites.push(&columns, &table.row(index))?;
            }
        }
        Ok(sites)
    }

    /// Before the rows of a table; about how many there are going to be (0 if nobody knows).
    pub(in crate::import) fn begin(&mut self, columns: &Columns, rows: usize) {
        self.fractional = columns.fractional;
        if self.models.is_empty() {
            self.models.push(Model::new(i64::MIN));
            self.models[0].builder.reserve(rows);
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.models.iter().all(|model| model.builder.atom_count() == 0)
    }

    /// Rows that were left out for want of a position: the first one's line and what was said of it.
    pub(super) fn no_position(&self) -> Option<(u64, String)> {
        self.oddities.no_position.message()
    }

    /// One row.
    ///
    /// # Errors
    /// A limit would be passed.
    #[inline]
    pub(in crate::import) fn push(&mut self, columns: &Columns, row: &impl Row) -> Result<()> {
        let [x, y, z] = columns.position;
        let (Some(x), Some(y), Some(z)) = (row.number(x), row.number(y), row.number(z)) else {
            self.note_no_position(columns, row);
            return Ok(());
        };
        let position = DVec3::new(x.0, y.0, z.0);
        if !crate::import::is_plausible(position) {
            self.note_no_position(columns, row);
            return Ok(());
        }
        if columns.model != ABSENT || self.models.is_empty() {
            let number = row.integer(columns.model).unwrap_or(1);
            if self.models.get(self.current).is_none_or(|model| model.number != number)
                && !self.enter_model(number, row)
            {
                return Ok(());
            }
        }
        self.decimals = self.decimals.max(x.1).max(y.1).max(z.1);
        let model = &mut self.models[self.current];
        if model.builder.atom_count() >= self.limits.atoms {
            let message = format!("the model has more than {} atoms (limit `atoms`)", self.limits.atoms);
            return Err(Error::limit(row.line(), message));
        }
        let name = if columns.name[0] == ABSENT { row.text(columns.label) } else { either(row, columns.name) };
        let name = name.unwrap_or_default();
        if columns.has_residues {
            model.enter_residue(columns, row, &name, &mut self.oddities);
        }
        let (element, isotope, charge) = element(columns, row, &name, &mut self.oddities);
        let mut flags = 0;
        if columns.group != ABSENT && row.is(columns.group, "HETATM") == Some(true) {
            flags |= atom_flags::HETERO;
        }
        let mut altloc = b' ';
        if let Some(text) = row.text(columns.altloc) {
            altloc = code(&text).unwrap_or(b' ');
            if text.len() > 1 {
                let line = row.line().unwrap_or(0);
                let message =
                    || format!("of the alternate location `{}` the first letter is kept", shown(text.as_bytes()));
                self.oddities.long_altloc.note(line, message);
            }
        }
        if columns.group_of_disorder != ABSENT || columns.calculated != ABSENT {
            let (more, disorder) = core_marks(columns, row, &mut self.codes);
            flags |= more;
            altloc = disorder.unwrap_or(altloc);
        }
        let value = |column: Column| row.number(column).map(|(value, _)| value).filter(|value| value.abs() < 1e30);
        let u = if columns.u_factor == ABSENT { None } else { value(columns.u_factor).map(|u| u * B_OF_U) };
        let charge = if columns.charge == ABSENT { None } else { row.integer(columns.charge) }
            .and_then(|charge| i8::try_from(charge).ok())
            .unwrap_or(charge);
        let record = AtomRecord {
            element,
            position,
            name: &name,
            serial: row.integer(columns.id).and_then(|id| i32::try_from(id).ok()),
            flags,
            altloc,
            occupancy: value(columns.occupancy).map_or(1.0, |value| value as f32),
            b_factor: value(columns.b_factor).or(u).map_or(0.0, |value| value as f32),
            formal_charge: charge,
            isotope,
            ..AtomRecord::default()
        };
        if columns.has_residues {
            model.builder.push_residue_atom(&record);
        } else {
            model.builder.push_atom(&record);
        }
        Ok(())
    }

    #[cold]
    fn note_no_position(&mut self, columns: &Columns, row: &impl Row) {
        self.oddities.no_position.note(row.line().unwrap_or(0), || {
            let [x, y, z] = columns.position.map(|column| row.text(column).unwrap_or(Cow::Borrowed("?")).into_owned());
            let name = either(row, columns.name).or_else(|| row.text(columns.label));
            let found = shown(format!("{x} {y} {z}").as_bytes());
            let name = shown(name.unwrap_or_default().as_bytes());
            format!("the atom {name} is left out: expected three coordinates, found `{found}`")
        });
    }

    /// Makes the model of a number the current one; `false` if there are too many.
    #[cold]
    fn enter_model(&mut self, number: i64, row: &impl Row) -> bool {
        if let Some(&index) = self.by_number.get(&number) {
            self.current = index;
            return true;
        }
        // The one that was made for room.
        if let [model] = self.models.as_mut_slice()
            && model.number == i64::MIN
        {
            model.number = number;
            self.by_number.insert(number, 0);
            return true;
        }
        if self.models.len() >= self.limits.records {
            let limit = self.limits.records;
            let message = || format!("the atoms of models behind the first {limit} are left out (limit `records`)");
            self.oddities.models.note(row.line().unwrap_or(0), message);
            return false;
        }
        self.current = self.models.len();
        self.by_number.insert(number, self.current);
        self.models.push(Model::new(number));
        true
    }

    /// Adds what was read from the rows that follow, whose lines were counted from line `base` on.
    ///
    /// # Errors
    /// A limit would be passed.
    pub(super) fn append(&mut self, later: AtomSites, base: u64) -> Result<()> {
        self.fractional |= later.fractional;
        self.decimals = self.decimals.max(later.decimals);
        for (mine, theirs) in [
            (&mut self.oddities.no_position, later.oddities.no_position),
            (&mut self.oddities.unknown_element, later.oddities.unknown_element),
            (&mut self.oddities.guessed_element, later.oddities.guessed_element),
            (&mut self.oddities.residue_number, later.oddities.residue_number),
            (&mut self.oddities.long_altloc, later.oddities.long_altloc),
            (&mut self.oddities.models, later.oddities.models),
        ] {
            mine.absorb(theirs.shifted(base));
        }
        for model in later.models {
            if model.builder.atom_count() == 0 {
                continue;
            }
            let index = match self.by_number.get(&model.number) {
                Some(&index) => index,
                None if matches!(self.models.as_slice(), [only] if only.builder.atom_count() == 0) => {
                    self.models[0].number = model.number;
                    0
                }
                None => {
                    self.models.push(Model::new(model.number));
                    self.models.len() - 1
                }
            };
            self.by_number.insert(model.number, index);
            self.current = index;
            self.models[index].append(model);
            let atoms = self.models[index].builder.atom_count();
            if atoms > self.limits.atoms || self.models.len() > self.limits.records {
                return Err(Error::limit(
                    None,
                    format!("the file has more than {} atoms (limit `atoms`)", self.limits.atoms),
                ));
            }
        }
        Ok(())
    }

    pub(super) fn report(&self, diagnostics: &mut Diagnostics) {
        let oddities = &self.oddities;
        oddities.no_position.error(diagnostics);
        oddities.models.error(diagnostics);
        for oddity in
            [&oddities.unknown_element, &oddities.guessed_element, &oddities.residue_number, &oddities.long_altloc]
        {
            oddity.warn(diagnostics);
        }
    }
}

impl Model {
    /// Begins a residue unless the row belongs to the last one.
    #[inline]
    fn enter_residue<R: Row>(&mut self, columns: &Columns, row: &R, atom_name: &str, oddities: &mut Oddities) {
        let mut insertion_code = None;
        if columns.insertion_code != ABSENT {
            insertion_code = row.text(columns.insertion_code).and_then(|text| code(&text));
        }
        let stated = residue_number(columns, row, &mut insertion_code, oddities);
        let number = stated.unwrap_or(0);
        let insertion_code = insertion_code.unwrap_or(b' ');
        // Where there is but the label's, it is what is shown.
        let own_label = columns.label_number != columns.number[0];
        let label_number = if own_label { row.integer(columns.label_number) } else { None };
        let last = &self.last;
        let same = last.number == number
            && last.label_number == label_number
            && last.insertion_code == insertion_code
            && self.first.is_some()
            && either_is(row, columns.chain, &last.chain)
            && either_is(row, columns.residue_name, &last.name)
            && either_is(row, [columns.label_chain, ABSENT], &last.label_chain)
            && (stated.is_some() || last.first_atom.as_deref() != Some(atom_name));
        if !same {
            let text = |columns: [Column; 2]| either(row, columns).unwrap_or_default().into_owned();
            self.begin_residue(ResidueKey {
                chain: text(columns.chain),
                number,
                insertion_code,
                name: text(columns.residue_name),
                label_chain: text([columns.label_chain, ABSENT]),
                label_number,
                first_atom: stated.is_none().then(|| atom_name.to_owned()),
            });
        }
    }

    #[inline(never)]
    fn begin_residue(&mut self, residue: ResidueKey) {
        let chain = self.label_names.intern(&residue.label_chain);
        self.labels.push(ResidueLabel { chain, number: residue.label_number });
        self.builder.begin_residue(&residue.chain, residue.number, residue.insertion_code, &residue.name);
        if self.first.is_none() {
            self.first = Some(residue.clone());
        }
        self.last = residue;
    }

    fn append(&mut self, later: Model) {
        let joins = later.first.as_ref().is_some_and(|first| first.first_atom.is_none() && *first == self.last)
            && self.first.is_some();
        let names: Vec<NameId> = later.label_names.texts().map(|text| self.label_names.intern(text)).collect();
        self.labels.extend(later.labels.iter().skip(usize::from(joins)).map(|label| ResidueLabel {
            chain: names.get(label.chain.index()).copied().unwrap_or_default(),
            ..*label
        }));
        self.builder.append(later.builder, joins);
        if self.first.is_none() {
            self.first = later.first;
        }
        self.last = later.last;
    }
}

/// The value of the first column, else of the second.
#[inline]
fn either<R: Row>(row: &R, [first, second]: [Column; 2]) -> Option<Cow<'_, str>> {
    row.text(first).or_else(|| if second == ABSENT { None } else { row.text(second) })
}

/// Whether [`either`], empty if there is none, is this text.
#[inline]
fn either_is(row: &impl Row, [first, second]: [Column; 2], text: &str) -> bool {
    row.is(first, text).or_else(|| row.is(second, text)).unwrap_or(text.is_empty())
}

/// The one character of a code.
#[inline]
pub(in crate::import) fn code(text: &str) -> Option<u8> {
    text.as_bytes().first().copied().filter(|byte| byte.is_ascii_graphic())
}

/// The author's number of the residue, else its label's.
#[inline]
fn residue_number(
    columns: &Columns,
    row: &impl Row,
    insertion_code: &mut Option<u8>,
    oddities: &mut Oddities,
) -> Option<i32> {
    let number = row.integer(columns.number[0]).and_then(|number| i32::try_from(number).ok());
    number.or_else(|| odd_residue_number(columns, row, insertion_code, oddities))
}

#[cold]
fn odd_residue_number(
    columns: &Columns,
    row: &impl Row,
    insertion_code: &mut Option<u8>,
    oddities: &mut Oddities,
) -> Option<i32> {
    let Some(text) = row.text(columns.number[0]) else {
        return row.integer(columns.number[1]).and_then(|number| i32::try_from(number).ok());
    };
    // `12A`: a number with its insertion code.
    let end = text.bytes().rposition(|byte| byte.is_ascii_digit()).map_or(0, |at| at + 1);
    if let (Ok(number), [letter]) = (text[..end].parse(), &text.as_bytes()[end..]) {
        insertion_code.get_or_insert(*letter);
        return Some(number);
    }
    let message = || format!("the residue number `{}` is no whole number; taken as 0", shown(text.as_bytes()));
    oddities.residue_number.note(row.line().unwrap_or(0), message);
    Some(0)
}

/// Element, isotope and charge: by the type symbol, else by the name.
#[inline]
fn element(columns: &Columns, row: &impl Row, name: &str, oddities: &mut Oddities) -> (Element, u16, i8) {
    let symbol = row.text(columns.symbol);
    if let Some(meaning) = symbol.as_deref().and_then(type_symbol) {
        return (meaning.element, meaning.isotope, meaning.charge);
    }
    let residue_name = either(row, columns.residue_name).unwrap_or_default();
    element_by_name(columns, symbol.as_deref(), name, &residue_name, row.line().unwrap_or(0), oddities)
}

#[cold]
fn element_by_name(
    columns: &Columns,
    symbol: Option<&str>,
    name: &str,
    residue_name: &str,
    line: u64,
    oddities: &mut Oddities,
) -> (Element, u16, i8) {
    // X is how wwPDB marks atoms that nobody knows.
    if symbol.is_some_and(|symbol| symbol.eq_ignore_ascii_case("x")) {
        return (Element::DUMMY, 0, 0);
    }
    let meaning = if columns.has_residues { element_of_name(name, residue_name) } else { element_of_label(name) };
    let Some(meaning) = meaning else {
        let message = || {
            let (symbol, name) = (shown(symbol.unwrap_or("?").as_bytes()), shown(name.as_bytes()));
            format!(
                "neither the type symbol `{symbol}` nor the name `{name}` is of an element; the atom is kept without one"
            )
        };
        oddities.unknown_element.note(line, message);
        return (Element::DUMMY, 0, 0);
    };
    if let Some(symbol) = symbol {
        let message = || {
            format!("`{}` is no element symbol; the element is taken from the atom's name", shown(symbol.as_bytes()))
        };
        oddities.guessed_element.note(line, message);
    }
    (meaning.element, meaning.isotope, meaning.charge)
}

/// What only small-molecule files say: flags, and the code of a disordered alternative.
#[cold]
fn core_marks(columns: &Columns, row: &impl Row, codes: &mut DisorderCodes) -> (u8, Option<u8>) {
    let mut flags = 0;
    if row.text(columns.calculated).is_some_and(|flag| flag.eq_ignore_ascii_case("dum")) {
        flags |= atom_flags::PARTICLE;
    }
    let Some(text) = row.text(columns.group_of_disorder) else { return (flags, None) };
    let assembly = row.text(columns.assembly).unwrap_or_default();
    let group = row.integer(columns.group_of_disorder);
    if group.is_some_and(|group| group < 0) {
        flags |= atom_flags::SYMMETRY_DISORDER;
    }
    match group {
        // 0 is how some programs write that there is no disorder.
        Some(0) => (flags, None),
        Some(group) => (flags, Some(codes.code(&assembly, group))),
        // Groups named by letters: they stand for assembly and group together.
        None => (flags, Some(codes.code(&format!("{assembly}\n{text}"), 0))),
    }
}
