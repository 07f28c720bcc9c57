//! Unit cell and symmetry of a block, in both spellings of their names.

use super::table::{Block, Category, Row, Table};
use crate::import::text::{Repeated, shown};
use crate::structure::{Cell, Diagnostics, Symmetry, SymmetryOperation};

/// Operations that are kept: a space group has at most 192 in a conventional cell; more are of larger cells.
const MAX_OPERATIONS: usize = 4096;

/// The unit cell, uncertainties dropped. Angles that are missing are 90° (the dictionary's default). 1 × 1 × 1 Å is no
/// cell where positions are in ångström: wwPDB's placeholder for structures without one.
pub(super) fn cell(block: &impl Block, fractional: bool, diagnostics: &mut Diagnostics) -> Option<Cell> {
    let table = block.table(Category::Cell).filter(|table| table.row_count() > 0)?;
    let row = table.row(0);
    let value = |item: &str| row.number(table.column(item)).map(|(value, _)| value);
    let lengths = ["length_a", "length_b", "length_c"].map(value);
    let angles = ["angle_alpha", "angle_beta", "angle_gamma"];
    let angles = angles.map(|item| value(item).or(row.text(table.column(item)).is_none().then_some(90.0)));
    let [Some(a), Some(b), Some(c)] = lengths else {
        let stated = ["length_a", "length_b", "length_c"].iter().any(|item| row.text(table.column(item)).is_some());
        if stated {
            diagnostics.warn(row.line(), "the cell does not have three lengths that are numbers; it is left out");
        }
        return None;
    };
    if !fractional && ([a, b, c] == [1.0; 3] || [a, b, c] == [0.0; 3]) {
        return None;
    }
    let cell = match angles {
        [Some(alpha), Some(beta), Some(gamma)] => Cell::from_parameters([a, b, c], [alpha, beta, gamma]),
        _ => None,
    };
    if cell.is_none() {
        let [alpha, beta, gamma] = angles.map(|angle| angle.map_or("?".to_owned(), |angle| angle.to_string()));
        diagnostics
            .warn(row.line(), format!("the cell {a} {b} {c} {alpha} {beta} {gamma} spans no volume; it is left out"));
    }
    cell
}

/// Space group and operations. In a small-molecule file missing operations are warned of: without them the crystal
/// cannot be drawn.
pub(super) fn symmetry(block: &impl Block, small_molecule: bool, diagnostics: &mut Diagnostics) -> Option<Symmetry> {
    let name = |category: Category, items: &[&str]| {
        let table = block.table(category).filter(|table| table.row_count() > 0)?;
        let row = table.row(0);
        items.iter().find_map(|item| {
            let text = row.text(table.column(item))?.trim().to_owned();
            (!matches!(text.as_str(), "" | "?" | ".")).then_some(text)
        })
    };
    let space_group = name(Category::Symmetry, &["space_group_name_H-M"])
        .or_else(|| name(Category::SpaceGroup, &["name_H-M_alt", "name_H-M_full", "name_H-M_ref"]))
        .or_else(|| name(Category::Symmetry, &["space_group_name_Hall"]))
        .or_else(|| name(Category::SpaceGroup, &["name_Hall"]))
        .unwrap_or_default();
    let mut operations = operations(block, diagnostics);
    if operations.is_empty() {
        let number =
            name(Category::Symmetry, &["Int_Tables_number"]).or_else(|| name(Category::SpaceGroup, &["IT_number"]));
        let symbol: String = space_group.chars().filter(|c| !c.is_whitespace()).collect();
        if symbol.eq_ignore_ascii_case("P1") || (symbol.is_empty() && number.as_deref() == Some("1")) {
            operations.push(SymmetryOperation::IDENTITY);
        } else if small_molecule {
            let of = if space_group.is_empty() {
                String::new()
            } else {
                format!(" of space group {}", shown(space_group.as_bytes()))
            };
            diagnostics.warn(
                None,
                format!("the file does not list the symmetry operations{of}: only the atoms that it lists are known"),
            );
        }
    }
    (!space_group.is_empty() || !operations.is_empty()).then_some(Symmetry { space_group, operations })
}

fn operations(block: &impl Block, diagnostics: &mut Diagnostics) -> Vec<SymmetryOperation> {
    let mut operations = Vec::new();
    let mut odd = Repeated::default();
    for (category, item) in [(Category::SpaceGroupSymop, "operation_xyz"), (Category::SymmetryEquiv, "pos_as_xyz")] {
        let Some(table) = block.table(category).filter(|_| operations.is_empty()) else { continue };
        let column = table.column(item);
        for index in 0..table.row_count() {
            let row = table.row(index);
            let Some(text) = row.text(column) else { continue };
            let line = row.line().unwrap_or(0);
            match SymmetryOperation::from_triplet(&text) {
                Some(_) if operations.len() >= MAX_OPERATIONS => {
                    odd.note(line, || {
                        format!("the symmetry operations behind the first {MAX_OPERATIONS} are left out")
                    });
                }
                Some(operation) => operations.push(operation),
                None => odd.note(line, || {
                    format!(
                        "`{}` is no symmetry operation (expected one like `-x,y+1/2,-z`); it is left out",
                        shown(text.as_bytes())
                    )
                }),
            }
        }
    }
    odd.warn(diagnostics);
    operations
}
