//! What the consumers of CIF data see of a file: blocks of tables of rows, whether the file is text or binary.
//!
//! A category (`_atom_site`) is a [`Table`]; single items (`_cell.length_a 10`) are a table of one row. Consumers find
//! their columns by name once and then ask rows for values by column. All of it is generic, so that nothing is paid
//! for the abstraction, and a binary file's numbers never become text.

use std::borrow::Cow;

/// Index of a column in its table, or [`ABSENT`].
pub(in crate::import) type Column = usize;

/// A column that the table does not have; every row answers `None` for it.
pub(in crate::import) const ABSENT: Column = usize::MAX;

/// The categories that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::import) enum Category {
    AtomSite,
    Cell,
    Chemical,
    ChemComp,
    ChemCompAtom,
    ChemCompBond,
    Entry,
    StructAssembly,
    StructAssemblyGen,
    StructOperList,
    SpaceGroup,
    SpaceGroupSymop,
    Struct,
    StructConf,
    StructConn,
    StructSheetRange,
    Symmetry,
    SymmetryEquiv,
}

impl Category {
    /// All of them.
    pub(in crate::import) const ALL: [Category; 18] = [
        Category::AtomSite,
        Category::Cell,
        Category::Chemical,
        Category::ChemComp,
        Category::ChemCompAtom,
        Category::ChemCompBond,
        Category::Entry,
        Category::StructAssembly,
        Category::StructAssemblyGen,
        Category::StructOperList,
        Category::SpaceGroup,
        Category::SpaceGroupSymop,
        Category::Struct,
        Category::StructConf,
        Category::StructConn,
        Category::StructSheetRange,
        Category::Symmetry,
        Category::SymmetryEquiv,
    ];

    /// The name without the underscore in front (`atom_site`).
    pub(in crate::import) fn name(self) -> &'static str {
        match self {
            Category::AtomSite => "atom_site",
            Category::Cell => "cell",
            Category::Chemical => "chemical",
            Category::ChemComp => "chem_comp",
            Category::ChemCompAtom => "chem_comp_atom",
            Category::ChemCompBond => "chem_comp_bond",
            Category::Entry => "entry",
            Category::StructAssembly => "pdbx_struct_assembly",
            Category::StructAssemblyGen => "pdbx_struct_assembly_gen",
            Category::StructOperList => "pdbx_struct_oper_list",
            Category::SpaceGroup => "space_group",
            Category::SpaceGroupSymop => "space_group_symop",
            Category::Struct => "struct",
            Category::StructConf => "struct_conf",
            Category::StructConn => "struct_conn",
            Category::StructSheetRange => "struct_sheet_range",
            Category::Symmetry => "symmetry",
            Category::SymmetryEquiv => "symmetry_equiv",
        }
    }

    /// The category of a name without the underscore in front, in any case.
    pub(in crate::import) fn from_name(name: &[u8]) -> Option<Category> {
        Category::ALL.into_iter().find(|category| category.name().as_bytes().eq_ignore_ascii_case(name))
    }
}

/// A data block.
pub(in crate::import) trait Block {
    /// Its name (`1ABC` of `data_1ABC`).
    fn name(&self) -> Cow<'_, str>;

    /// A category, if the block has it. Rows of `_atom_site` need not be here if they were read another way
    /// (see [`super::block::finish`]).
    fn table(&self, category: Category) -> Option<impl Table + '_>;
}

/// A category: rows of values.
pub(in crate::import) trait Table {
    /// The column of an item, by its name behind the dot (`Cartn_x`) in any case, or [`ABSENT`].
    fn column(&self, item: &str) -> Column;

    /// Number of whole rows.
    fn row_count(&self) -> usize;

    /// A row below [`Table::row_count`].
    fn row(&self, index: usize) -> impl Row + '_;
}

/// One row. A value that is missing (`.`, `?`, a masked one, an [`ABSENT`] column) is `None` from all of these.
pub(in crate::import) trait Row {
    /// The value as text, without quotes; a number as it would be written.
    fn text(&self, column: Column) -> Option<Cow<'_, str>>;

    /// The value as a number, and the decimals it is written with (for a fixed-point column those of its factor);
    /// `None` as well for text that is no number. A standard uncertainty in parentheses is dropped.
    fn number(&self, column: Column) -> Option<(f64, u8)>;

    /// The value as a whole number; `None` as well for what is none.
    fn integer(&self, column: Column) -> Option<i64>;

    /// Whether the value is this text; `None` for a missing one. Overridden where texts can be compared more cheaply.
    #[inline]
    fn is(&self, column: Column, text: &str) -> Option<bool> {
        self.text(column).map(|value| value == text)
    }

    /// The line of the file it stands on, in text files.
    fn line(&self) -> Option<u64>;
}
