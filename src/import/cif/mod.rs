//! CIF: macromolecules (mmCIF), small molecules and crystals, ligands.
//!
//! Specifications: the syntax in [`token`]; the PDBx/mmCIF dictionary (<https://mmcif.wwpdb.org>) and the core
//! dictionary (<https://www.iucr.org/resources/cif/dictionaries/cif_core>) for names, which are read in any case and
//! with a dot or an underscore behind the category.
//!
//! Read are `_atom_site` ([`atoms`]; columns in any order, all but the coordinates optional, Cartesian or fractional),
//! models, `_cell`, `_symmetry` and `_space_group` with their operations ([`crystal`]), `_struct_conn` ([`links`]),
//! `_chem_comp_bond` and, in files without `_atom_site`, `_chem_comp_atom` ([`component`]), `_struct_conf` and
//! `_struct_sheet_range`, titles ([`block`]), `_pdbx_struct_assembly` with what makes it ([`assembly`]). Each data block with atoms is a record, models of the same atoms are frames
//! of one; blocks without atoms (publication texts) are passed over. Save frames are passed over.
//!
//! Small molecules: standard uncertainties are dropped, disordered alternatives get alternate-location codes
//! ([`label::DisorderCodes`]), atoms are those listed, so that copies on special positions that a file lists twice are there
//! twice. `_geom_bond` is a table of distances, with symmetry codes, that leaves out and adds what its author chose: it is
//! no list of bonds and is not read as one.
//!
//! Accepted beyond the specification: see [`token`]; items without a category they belong to, values without a name
//! (left out with a warning), text before the first `data_`.
//!
//! Not read: anisotropic displacements, bonds to symmetry mates.

mod assembly;
pub(super) mod atoms;
pub(super) mod block;
mod component;
mod crystal;
pub(super) mod label;
mod links;
pub(super) mod rows;
pub(super) mod table;
mod text;
mod token;

use super::collect::Records;
use super::text::{Repeated, shown};
use super::{Format, Limits};
use crate::error::{Error, Result};
use crate::structure::Diagnostics;
use atoms::AtomSites;
use table::{Block, Category};
use text::{TextBlock, TextTable, split_name};
use token::{Token, Tokens};

/// Reads all blocks; returns which of the two kinds of CIF it is.
pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<Format> {
    let stop = records.stop().clone();
    let mut reader = Reader {
        tokens: Tokens::new(text, &stop),
        block: TextBlock::default(),
        sites: AtomSites::new(records.limits()),
        in_block: false,
        small_molecule: false,
        components: false,
        problem: None,
        oddities: Oddities::default(),
    };
    if let Err(error) = reader.read(records, diagnostics) {
        match error {
            // What was read before stays.
            Error::Input { .. } if !records.is_empty() => {
                diagnostics.error(error.line(), format!("reading stops here: {}", message(&error)));
            }
            error => return Err(error),
        }
    }
    let oddities = &reader.oddities;
    for oddity in [&oddities.no_block, &oddities.stray, &oddities.no_value, &oddities.short_loop, &oddities.again] {
        oddity.warn(diagnostics);
    }
    if records.is_empty() {
        return Err(reader.problem.unwrap_or_else(|| {
            Error::input(None, "the file has no atoms: neither `_atom_site` nor `_chem_comp_atom` with coordinates")
        }));
    }
    Ok(if reader.small_molecule && !reader.components { Format::Cif } else { Format::Mmcif })
}

fn message(error: &Error) -> String {
    match error {
        Error::Input { message, .. } => message.clone(),
        other => other.to_string(),
    }
}

/// What may occur at many places.
#[derive(Debug, Default)]
struct Oddities {
    no_block: Repeated,
    stray: Repeated,
    no_value: Repeated,
    short_loop: Repeated,
    again: Repeated,
}

/// The category of a name in a loop. Without a dot only the tables count: `_chemical_conn_bond_type` is no item of
/// `_chemical`.
fn loop_category(name: &[u8]) -> Option<Category> {
    let (category, _) = split_name(name)?;
    let is_table = matches!(category, Category::AtomSite | Category::SymmetryEquiv | Category::SpaceGroupSymop);
    (is_table || name.contains(&b'.')).then_some(category)
}

struct Reader<'a> {
    tokens: Tokens<'a>,
    block: TextBlock<'a>,
    sites: AtomSites,
    in_block: bool,
    /// A record with fractional coordinates was read; one with any others.
    small_molecule: bool,
    components: bool,
    /// Why the first block that was left out was.
    problem: Option<Error>,
    oddities: Oddities,
}

impl<'a> Reader<'a> {
    fn read(&mut self, records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
        loop {
            let token = self.tokens.next();
            let line = self.tokens.token_line;
            if !self.in_block && matches!(token, Token::Name(_) | Token::Loop) {
                self.in_block = true;
                self.oddities
                    .no_block
                    .note(line, || "expected `data_` and a name before this; read all the same".to_owned());
            }
            match token {
                Token::Data(name) => {
                    self.finish_block(records, diagnostics)?;
                    self.block = TextBlock::new(name);
                    self.in_block = true;
                }
                Token::Save(name) if !name.is_empty() => self.skip_frame(),
                Token::Save(_) | Token::Reserved => {}
                Token::Name(name) => self.item(name, line),
                Token::Loop => self.read_loop(records.limits(), diagnostics)?,
                Token::Value(value) => {
                    let message = || format!("`{}` belongs to no name; it is left out", shown(value.unwrap_or(b"?")));
                    self.oddities.stray.note(line, message);
                }
                Token::Unclosed => {
                    self.finish_cut(line, records, diagnostics)?;
                    return Ok(());
                }
                Token::End => return self.finish_block(records, diagnostics),
            }
        }
    }

    /// A text field that does not end took the rest of the file with it.
    fn finish_cut(&mut self, line: u64, records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
        if self.sites.is_empty() && records.is_empty() {
            return Err(rows::unclosed(line));
        }
        let message =
            "expected `;` at the beginning of a line to close the text field that begins here; the file ends in it";
        diagnostics.error(Some(line), message);
        self.finish_block(records, diagnostics)
    }

    fn item(&mut self, name: &'a [u8], line: u64) {
        let before = self.tokens;
        match self.tokens.next() {
            Token::Value(value) => {
                if let Some((category, item)) = split_name(name) {
                    self.block.push_item(category, item, value, line);
                }
            }
            _ => {
                self.tokens = before;
                self.oddities.no_value.note(line, || format!("the item {} has no value", shown(name)));
            }
        }
    }

    /// Past a save frame, to its end or to the next block.
    fn skip_frame(&mut self) {
        loop {
            let before = self.tokens;
            match self.tokens.next() {
                Token::Save(b"") => return,
                Token::Data(_) | Token::End | Token::Unclosed => {
                    self.tokens = before;
                    return;
                }
                _ => {}
            }
        }
    }

    fn read_loop(&mut self, limits: &Limits, diagnostics: &mut Diagnostics) -> Result<()> {
        let mut names: Vec<&'a [u8]> = Vec::new();
        let loop_line = self.tokens.token_line;
        loop {
            let before = self.tokens;
            match self.tokens.next() {
                Token::Name(name) => names.push(name),
                _ => {
                    self.tokens = before;
                    break;
                }
            }
        }
        let category = names.iter().find_map(|name| loop_category(name));
        let Some(category) = category else {
            self.tokens.skip_values();
            return Ok(());
        };
        // Columns of other categories, which no loop should have, find no name.
        let item = |name: &&'a [u8]| {
            split_name(name).filter(|(other, _)| *other == category).map_or(&b""[..], |(_, item)| item)
        };
        let items: Vec<&'a [u8]> = names.iter().map(item).collect();
        if category == Category::AtomSite {
            return rows::read_loop(&mut self.tokens, &items, &mut self.sites, limits, diagnostics);
        }
        if self.block.table(category).is_some() {
            let message = || format!("the category _{} comes again; only the first is read", category.name());
            self.oddities.again.note(loop_line, message);
            self.tokens.skip_values();
            return Ok(());
        }
        let (table, whole) = self.read_table(items);
        if !whole {
            self.oddities.short_loop.note(loop_line, || {
                format!(
                    "the values of the loop _{} do not fill whole rows; the last, short one is left out",
                    category.name()
                )
            });
        }
        self.block.tables.push((category, table));
        Ok(())
    }

    /// The values of a loop, and whether they fill whole rows.
    fn read_table(&mut self, items: Vec<&'a [u8]>) -> (TextTable<'a>, bool) {
        let width = items.len();
        let mut table = TextTable { items, ..TextTable::default() };
        loop {
            let before = self.tokens;
            let Token::Value(value) = self.tokens.next() else {
                self.tokens = before;
                break;
            };
            if table.values.len().is_multiple_of(width) {
                table.lines.push(self.tokens.token_line);
            }
            table.values.push(value);
        }
        let whole = table.values.len().is_multiple_of(width);
        if !whole {
            table.lines.pop();
        }
        (table, whole)
    }

    fn finish_block(&mut self, records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
        let mut sites = std::mem::replace(&mut self.sites, AtomSites::new(records.limits()));
        // A single atom may be given as items, without a loop.
        if let Some(table) = self.block.table(Category::AtomSite).filter(|_| sites.is_empty()) {
            sites = AtomSites::from_table(&table, records.limits())?;
        }
        let fractional = sites.fractional;
        let before = records.len();
        let result = block::finish(&self.block, sites, records, diagnostics);
        if records.len() > before {
            self.small_molecule |= fractional;
            self.components |= !fractional;
        }
        match result {
            Err(limit @ Error::Limit { .. }) => Err(limit),
            Err(problem) => {
                let name = shown(self.block.name);
                diagnostics.error(problem.line(), format!("the data block {name} is left out: {}", message(&problem)));
                self.problem.get_or_insert(problem);
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
