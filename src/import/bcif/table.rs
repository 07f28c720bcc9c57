//! Blocks and tables of a BinaryCIF file as the consumers of CIF data see them.
//!
//! A column is decoded when a consumer asks for it by name, so that the columns nobody reads cost nothing. One that
//! cannot be decoded is as if it were absent, and is remembered as a problem.

use super::super::Limits;
use super::super::cif::atoms::AtomSites;
use super::super::cif::table::{ABSENT, Block, Category, Column as Index, Row, Table};
use super::column::Column;
use super::encoding::{Budget, Data, Problem};
use super::msgpack::{Cursor, Malformed};
use super::sites;
use crate::error::Error;
use std::borrow::Cow;
use std::cell::{Cell, OnceCell, RefCell};

/// Columns that one category may have; the dictionary's largest has some sixty.
const MAX_COLUMNS: u32 = 10_000;

/// What all tables of a file share.
#[derive(Debug)]
pub(super) struct Context {
    budget: Budget,
    /// What could not be decoded.
    problems: RefCell<Vec<String>>,
    too_large: Cell<bool>,
    ratio: u32,
}

impl Context {
    /// `budget` bounds the bytes of all decoded columns; `ratio` is the limit it comes from.
    pub(super) fn new(budget: Budget, ratio: u32) -> Context {
        Context { budget, problems: RefCell::default(), too_large: Cell::new(false), ratio }
    }

    /// The problems since the last call.
    pub(super) fn take_problems(&self) -> Vec<String> {
        self.problems.take()
    }

    /// The limit error, if a column was too large.
    pub(super) fn limit(&self) -> Option<Error> {
        let message =
            || format!("the columns decode to more than {} times the size of the file (limit `ratio`)", self.ratio);
        self.too_large.get().then(|| Error::limit(None, message()))
    }
}

/// A data block.
#[derive(Debug)]
pub(super) struct BinaryBlock<'a, 'c> {
    name: Cow<'a, str>,
    tables: Vec<BinaryTable<'a, 'c>>,
}

/// A category.
#[derive(Debug)]
pub(super) struct BinaryTable<'a, 'c> {
    category: Category,
    rows: usize,
    columns: Vec<LazyColumn<'a>>,
    context: &'c Context,
}

#[derive(Debug)]
struct LazyColumn<'a> {
    name: &'a [u8],
    data: Data<'a>,
    mask: Option<Data<'a>>,
    decoded: OnceCell<Option<Column<'a>>>,
}

impl<'a, 'c> BinaryBlock<'a, 'c> {
    /// Reads a block; where the bytes are malformed, what came before that, and why.
    pub(super) fn read(cursor: &mut Cursor<'a>, context: &'c Context) -> (BinaryBlock<'a, 'c>, Result<(), Malformed>) {
        let mut block = BinaryBlock { name: Cow::Borrowed(""), tables: Vec::new() };
        let outcome = block.fill(cursor, context);
        (block, outcome)
    }

    /// The atoms, where they can be read column by column ([`sites`]).
    pub(super) fn plain_sites(&self, limits: &Limits) -> Option<AtomSites> {
        let table = self.tables.iter().find(|table| table.category == Category::AtomSite)?;
        let columns: Vec<sites::Encoded<'_, 'a>> =
            table.columns.iter().map(|column| (column.name, &column.data, column.mask.as_ref())).collect();
        // What is read in vain here is not taken off.
        sites::read(&columns, table.rows, &table.context.budget.again(), limits)
    }

    fn fill(&mut self, cursor: &mut Cursor<'a>, context: &'c Context) -> Result<(), Malformed> {
        for _ in 0..cursor.map("a data block")? {
            match cursor.text("a key")? {
                b"header" => self.name = String::from_utf8_lossy(cursor.text("the name of a data block")?),
                b"categories" => {
                    for _ in 0..cursor.array("the categories")? {
                        let known = |category| self.tables.iter().any(|table| table.category == category);
                        if let Some(table) = BinaryTable::read(cursor, context, known)? {
                            self.tables.push(table);
                        }
                    }
                }
                _ => cursor.skip()?,
            }
        }
        Ok(())
    }
}

impl<'a, 'c> BinaryTable<'a, 'c> {
    /// Reads a category; `None` if nobody reads it, or it was there before.
    fn read(
        cursor: &mut Cursor<'a>,
        context: &'c Context,
        known: impl Fn(Category) -> bool,
    ) -> Result<Option<BinaryTable<'a, 'c>>, Malformed> {
        let (mut category, mut rows, mut columns_at) = (None, 0, None);
        for _ in 0..cursor.map("a category")? {
            match cursor.text("a key")? {
                b"name" => {
                    let name = cursor.text("the name of a category")?;
                    category = Category::from_name(name.strip_prefix(b"_").unwrap_or(name));
                }
                b"rowCount" => rows = cursor.number("the number of rows")?,
                b"columns" => {
                    // The name may come behind them.
                    columns_at = Some(cursor.clone());
                    cursor.skip()?;
                }
                _ => cursor.skip()?,
            }
        }
        let (Some(category), Some(mut at)) = (category.filter(|&category| !known(category)), columns_at) else {
            return Ok(None);
        };
        let mut columns = Vec::new();
        for _ in 0..at.array("the columns of a category")?.min(MAX_COLUMNS) {
            columns.push(LazyColumn::read(&mut at)?);
        }
        Ok(Some(BinaryTable { category, rows, columns, context }))
    }

    /// Decodes a column if it was not yet; whether it can be read.
    fn prepare(&self, column: &LazyColumn<'a>) -> bool {
        let decode = || {
            let budget = &self.context.budget;
            match Column::decode(&column.data, column.mask.as_ref(), self.rows, budget) {
                Ok(column) => Some(column),
                Err(Problem::TooLarge) => {
                    self.context.too_large.set(true);
                    None
                }
                Err(Problem::Wrong(why)) => {
                    let name = super::super::text::shown(column.name);
                    let category = self.category.name();
                    self.context
                        .problems
                        .borrow_mut()
                        .push(format!("the column `_{category}.{name}` cannot be decoded ({why}); it is left out"));
                    None
                }
            }
        };
        column.decoded.get_or_init(decode).is_some()
    }
}

impl<'a> LazyColumn<'a> {
    fn read(cursor: &mut Cursor<'a>) -> Result<LazyColumn<'a>, Malformed> {
        let mut column = LazyColumn { name: b"", data: Data::default(), mask: None, decoded: OnceCell::new() };
        for _ in 0..cursor.map("a column")? {
            match cursor.text("a key")? {
                b"name" => column.name = cursor.text("the name of a column")?,
                b"data" => column.data = Data::read(cursor)?.unwrap_or_default(),
                b"mask" => column.mask = Data::read(cursor)?,
                _ => cursor.skip()?,
            }
        }
        Ok(column)
    }
}

impl Block for BinaryBlock<'_, '_> {
    fn name(&self) -> Cow<'_, str> {
        Cow::Borrowed(&self.name)
    }

    fn table(&self, category: Category) -> Option<impl Table + '_> {
        self.tables.iter().find(|table| table.category == category)
    }
}

impl Table for &BinaryTable<'_, '_> {
    /// A column without any value is as good as none, but for those of positions, without which nothing can be had.
    fn column(&self, item: &str) -> Index {
        let found = self.columns.iter().position(|column| column.name.eq_ignore_ascii_case(item.as_bytes()));
        let has_values = |index: usize| {
            let is_void = |column: &Column<'_>| column.is_void();
            self.columns[index].decoded.get().and_then(Option::as_ref).is_some_and(|column| !is_void(column))
                || item.starts_with("Cartn_")
                || item.starts_with("fract_")
        };
        found.filter(|&index| self.prepare(&self.columns[index]) && has_values(index)).unwrap_or(ABSENT)
    }

    /// What the file claims, if a column has as many values; else 0.
    fn row_count(&self) -> usize {
        let decoded = |column: &LazyColumn<'_>| matches!(column.decoded.get(), Some(Some(_)));
        let proven = self.columns.iter().any(decoded) || self.columns.iter().any(|column| self.prepare(column));
        if proven { self.rows } else { 0 }
    }

    fn row(&self, index: usize) -> impl Row + '_ {
        BinaryRow { columns: &self.columns, index }
    }
}

struct BinaryRow<'t, 'a> {
    columns: &'t [LazyColumn<'a>],
    index: usize,
}

impl<'t, 'a> BinaryRow<'t, 'a> {
    #[inline]
    fn column(&self, column: Index) -> Option<&'t Column<'a>> {
        self.columns.get(column)?.decoded.get()?.as_ref()
    }
}

impl Row for BinaryRow<'_, '_> {
    #[inline]
    fn text(&self, column: Index) -> Option<Cow<'_, str>> {
        self.column(column)?.text(self.index)
    }

    #[inline]
    fn number(&self, column: Index) -> Option<(f64, u8)> {
        self.column(column)?.number(self.index)
    }

    #[inline]
    fn integer(&self, column: Index) -> Option<i64> {
        self.column(column)?.integer(self.index)
    }

    fn line(&self) -> Option<u64> {
        None
    }
}
