//! Tables of a CIF in text form: values are slices of the file.

use super::super::number::{parse_f64, parse_i64};
use super::super::text::lossy;
use super::table::{ABSENT, Block, Category, Column, Row, Table};
use super::token::Value;
use std::borrow::Cow;

/// The data block being read: its tables but for the atoms, which do not wait here.
#[derive(Debug, Default)]
pub(super) struct TextBlock<'a> {
    pub(super) name: &'a [u8],
    pub(super) tables: Vec<(Category, TextTable<'a>)>,
}

impl<'a> TextBlock<'a> {
    pub(super) fn new(name: &'a [u8]) -> TextBlock<'a> {
        TextBlock { name, tables: Vec::new() }
    }

    /// Adds a single item to the table of its category, which has one row.
    pub(super) fn push_item(&mut self, category: Category, item: &'a [u8], value: Value<'a>, line: u64) {
        let found = self.tables.iter().position(|(other, table)| *other == category && table.lines.len() == 1);
        let index = found.unwrap_or_else(|| {
            self.tables.push((category, TextTable { lines: vec![line], ..TextTable::default() }));
            self.tables.len() - 1
        });
        let table = &mut self.tables[index].1;
        table.items.push(item);
        table.values.push(value);
    }
}

impl Block for TextBlock<'_> {
    fn name(&self) -> Cow<'_, str> {
        lossy(self.name)
    }

    fn table(&self, category: Category) -> Option<impl Table + '_> {
        self.tables.iter().find(|(other, _)| *other == category).map(|(_, table)| table)
    }
}

/// Category and item of a name: `_cell.length_a` and, as in small-molecule files, `_cell_length_a`. `None` for
/// categories that are not read.
pub(super) fn split_name(name: &[u8]) -> Option<(Category, &[u8])> {
    let name = name.strip_prefix(b"_")?;
    if let Some(dot) = memchr::memchr(b'.', name) {
        return Some((Category::from_name(&name[..dot])?, &name[dot + 1..]));
    }
    // The longest category that fits: `_symmetry_equiv_pos_as_xyz` is none of `symmetry`.
    let begins = |category: &Category| {
        let length = category.name().len();
        name.get(length) == Some(&b'_') && name[..length].eq_ignore_ascii_case(category.name().as_bytes())
    };
    let category = Category::ALL.into_iter().filter(begins).max_by_key(|category| category.name().len())?;
    let item = &name[category.name().len() + 1..];
    let aniso = category == Category::AtomSite && item.len() >= 6 && item[..6].eq_ignore_ascii_case(b"aniso_");
    (!aniso).then_some((category, item))
}

/// Position of an item among the names of a loop, in any case.
pub(super) fn find_item(items: &[&[u8]], item: &str) -> Column {
    items.iter().position(|other| other.eq_ignore_ascii_case(item.as_bytes())).unwrap_or(ABSENT)
}

#[derive(Debug, Default)]
pub(super) struct TextTable<'a> {
    pub(super) items: Vec<&'a [u8]>,
    /// Row by row.
    pub(super) values: Vec<Value<'a>>,
    /// Where each whole row begins.
    pub(super) lines: Vec<u64>,
}

impl Table for &TextTable<'_> {
    fn column(&self, item: &str) -> Column {
        find_item(&self.items, item)
    }

    fn row_count(&self) -> usize {
        self.lines.len()
    }

    fn row(&self, index: usize) -> impl Row + '_ {
        let width = self.items.len();
        let values = self.values.get(index * width..(index + 1) * width).unwrap_or_default();
        TextRow { values, line: self.lines.get(index).copied().unwrap_or(0) }
    }
}

/// One row of a table in text form.
#[derive(Debug, Clone, Copy)]
pub(super) struct TextRow<'r, 'a> {
    pub(super) values: &'r [Value<'a>],
    pub(super) line: u64,
}

impl TextRow<'_, '_> {
    #[inline]
    fn bytes(&self, column: Column) -> Option<&[u8]> {
        self.values.get(column).copied().flatten()
    }
}

impl Row for TextRow<'_, '_> {
    #[inline]
    fn text(&self, column: Column) -> Option<Cow<'_, str>> {
        // Almost always it is UTF-8, which `from_utf8` sees sooner.
        self.bytes(column).map(|bytes| std::str::from_utf8(bytes).map_or_else(|_| lossy(bytes), Cow::Borrowed))
    }

    #[inline]
    fn number(&self, column: Column) -> Option<(f64, u8)> {
        let text = self.bytes(column)?;
        parse_f64(text).or_else(|| without_uncertainty(text))
    }

    #[inline]
    fn integer(&self, column: Column) -> Option<i64> {
        let text = self.bytes(column)?;
        parse_i64(text).or_else(|| whole(text))
    }

    #[inline]
    fn is(&self, column: Column, text: &str) -> Option<bool> {
        self.bytes(column).map(|value| value == text.as_bytes())
    }

    fn line(&self) -> Option<u64> {
        Some(self.line)
    }
}

/// `0.1234(5)`, and numbers in text fields.
#[cold]
fn without_uncertainty(text: &[u8]) -> Option<(f64, u8)> {
    let text = text.trim_ascii();
    let end = text.iter().position(|&byte| byte == b'(').unwrap_or(text.len());
    parse_f64(&text[..end])
}

/// `1.0`, or a number in a text field.
#[cold]
fn whole(text: &[u8]) -> Option<i64> {
    let (value, _) = without_uncertainty(text)?;
    (value.fract() == 0.0 && value.abs() < 1e15).then_some(value as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_spellings_of_a_name_mean_the_same() {
        for (name, category, item) in [
            ("_cell.length_a", Category::Cell, "length_a"),
            ("_cell_length_a", Category::Cell, "length_a"),
            ("_ATOM_SITE.Cartn_x", Category::AtomSite, "Cartn_x"),
            ("_atom_site_fract_x", Category::AtomSite, "fract_x"),
            ("_symmetry_equiv_pos_as_xyz", Category::SymmetryEquiv, "pos_as_xyz"),
            ("_symmetry_equiv.pos_as_xyz", Category::SymmetryEquiv, "pos_as_xyz"),
            ("_symmetry_space_group_name_H-M", Category::Symmetry, "space_group_name_H-M"),
            ("_space_group_symop.operation_xyz", Category::SpaceGroupSymop, "operation_xyz"),
            ("_space_group_name_H-M_alt", Category::SpaceGroup, "name_H-M_alt"),
        ] {
            assert_eq!(split_name(name.as_bytes()), Some((category, item.as_bytes())), "{name}");
        }
        for name in
            ["_atom_site_aniso_label", "_atom_sites_solution_primary", "_atom_site_anisotrop.id", "_x", "cell.a"]
        {
            assert_eq!(split_name(name.as_bytes()), None, "{name}");
        }
    }

    #[test]
    fn values_are_read_as_what_they_are() {
        let values: [Value<'_>; 5] = [Some(b"0.1234(5)"), Some(b"-12"), None, Some(b"\n 3.0\n"), Some(b"x(1)")];
        let row = TextRow { values: &values, line: 7 };
        assert_eq!(row.number(0), Some((0.1234, 4)));
        assert_eq!((row.number(1), row.integer(1)), (Some((-12.0, 0)), Some(-12)));
        assert_eq!((row.text(2), row.number(2), row.integer(2)), (None, None, None));
        assert_eq!((row.number(3), row.integer(3)), (Some((3.0, 1)), Some(3)));
        assert_eq!((row.number(4), row.integer(0), row.text(ABSENT)), (None, None, None));
    }
}
