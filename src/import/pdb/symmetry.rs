//! REMARK 290: the symmetry operations of the crystal, as matrices for the coordinates of the file.
//!
//! ```text
//! REMARK 290   SMTRY1   2 -1.000000  0.000000  0.000000        0.00000
//! REMARK 290   SMTRY2   2  0.000000  1.000000  0.000000        9.32505
//! REMARK 290   SMTRY3   2  0.000000  0.000000 -1.000000        0.00000
//! ```
//!
//! is the second operation: three rows of a rotation, and the translation in ångström. They are turned into fractional
//! coordinates of the cell of CRYST1, where a rotation has whole numbers and the translations of all conventional settings are
//! 24ths; the file's digits are good enough to find these. One row that is missing or wrong spoils the whole list:
//! half a crystal would look like another one.

use super::super::number::parse_f64;
use super::super::text::{Repeated, columns, shown};
use crate::structure::{Cell, SymmetryOperation};
use glam::{DMat3, DVec3};

/// Operations that are kept: a space group has at most 192 in a conventional cell; more are of larger cells.
const MAX_OPERATIONS: usize = 4096;
/// How far a number of a rotation in fractional coordinates may be from a whole one. Chosen: six decimals in a cell of
/// edges like 1 : 100 leave 1e-4; rotations that are none of the lattice are off by far more.
const WHOLE: f64 = 0.01;
/// How near a translation has to be to a 24th of a cell vector to be one. Chosen: five decimals, and three of the cell's lengths,
/// leave 2e-4 in the smallest cell of a salt.
const NEAR: f64 = 1e-3;

/// The rows of REMARK 290 as they come.
#[derive(Debug, Default)]
pub(super) struct Rows {
    rows: Vec<Row>,
    is_spoilt: bool,
}

#[derive(Debug, Clone, Copy)]
struct Row {
    operation: u32,
    /// 0 to 2.
    axis: usize,
    factors: DVec3,
    translation: f64,
    line: u64,
}

/// Whether a line is one of these rows.
pub(super) fn is_row(line: &[u8]) -> bool {
    columns(line, 0, 10) == b"REMARK 290" && columns(line, 13, 18) == b"SMTRY"
}

impl Rows {
    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Adds a line that [`is_row`].
    pub(super) fn push(&mut self, line: &[u8], number: u64, odd: &mut Repeated) {
        if self.rows.len() >= 3 * MAX_OPERATIONS {
            self.is_spoilt = true;
            odd.note(number, || format!("more than {MAX_OPERATIONS} symmetry operations; none of them is used"));
            return;
        }
        match row(line, number) {
            Some(row) => self.rows.push(row),
            None => {
                self.is_spoilt = true;
                odd.note(number, || {
                    let found = shown(columns(line, 13, 80).trim_ascii_end());
                    format!(
                        "`{found}` of REMARK 290 is no row of a symmetry operation (expected SMTRY1, 2 or 3, a number, three \
                         factors and a translation); the symmetry of the crystal is left out"
                    )
                });
            }
        }
    }

    /// The operations in fractional coordinates of the cell; none if the rows are not whole, or not of this cell.
    pub(super) fn operations(&self, cell: &Cell, odd: &mut Repeated) -> Vec<SymmetryOperation> {
        if self.is_spoilt {
            return Vec::new();
        }
        let (to_fractional, from_fractional) = (cell.fractional_from_cartesian(), cell.cartesian_from_fractional());
        let mut operations = Vec::new();
        for rows in self.rows.chunks(3) {
            let first = rows[0];
            let is_whole = rows.len() == 3
                && rows.iter().enumerate().all(|(axis, row)| row.axis == axis && row.operation == first.operation);
            if !is_whole {
                let number = first.operation;
                odd.note(first.line, || {
                    format!(
                        "operation {number} of REMARK 290 does not have its rows SMTRY1, 2 and 3 in this order; the symmetry of \
                         the crystal is left out"
                    )
                });
                return Vec::new();
            }
            let rotation = DMat3::from_cols(rows[0].factors, rows[1].factors, rows[2].factors).transpose();
            let translation = DVec3::new(rows[0].translation, rows[1].translation, rows[2].translation);
            let Some(rotation) = whole(to_fractional * rotation * from_fractional) else {
                let number = first.operation;
                odd.note(first.line, || {
                    format!(
                        "operation {number} of REMARK 290 does not turn the cell of CRYST1 into itself; the symmetry of the \
                         crystal is left out"
                    )
                });
                return Vec::new();
            };
            operations.push(SymmetryOperation { rotation, translation: (to_fractional * translation).map(fraction) });
        }
        operations
    }
}

fn row(line: &[u8], number: u64) -> Option<Row> {
    let axis = match line.get(18)? {
        digit @ b'1'..=b'3' => usize::from(digit - b'1'),
        _ => return None,
    };
    let text = std::str::from_utf8(line.get(19..)?).ok()?;
    let mut words = text.split_ascii_whitespace();
    let operation = words.next()?.parse().ok()?;
    let mut next = || parse_f64(words.next()?.as_bytes()).map(|(value, _)| value).filter(|value| value.is_finite());
    let row =
        Row { operation, axis, factors: DVec3::new(next()?, next()?, next()?), translation: next()?, line: number };
    Some(row)
}

/// The matrix with whole numbers, if it is one of these that keeps volumes.
fn whole(matrix: DMat3) -> Option<DMat3> {
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|column| column.round() + 0.0);
    let rounded = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let is_near = rounded.abs_diff_eq(matrix, WHOLE);
    (is_near && (rounded.determinant().abs() - 1.0).abs() < 1e-6).then_some(rounded)
}

/// The 24th that a translation is, or itself.
fn fraction(translation: f64) -> f64 {
    let nearest = (translation * 24.0).round() / 24.0;
    if (nearest - translation).abs() < NEAR { nearest + 0.0 } else { translation }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(lines: &[&str], cell: &Cell) -> (Vec<SymmetryOperation>, Option<(u64, String)>) {
        let (mut rows, mut odd) = (Rows::default(), Repeated::default());
        for (number, line) in (1..).zip(lines) {
            assert!(is_row(line.as_bytes()), "{line}");
            rows.push(line.as_bytes(), number, &mut odd);
        }
        let operations = rows.operations(cell, &mut odd);
        (operations, odd.message())
    }

    const SCREW: [&str; 3] = [
        "REMARK 290   SMTRY1   2 -1.000000  0.000000  0.000000        0.00000            ",
        "REMARK 290   SMTRY2   2  0.000000  1.000000  0.000000        9.32505",
        "REMARK 290   SMTRY3   2  0.000000  0.000000 -1.000000        0.00000",
    ];

    #[test]
    fn rows_in_angstrom_are_operations_in_fractions_of_the_cell() {
        // Crambin's own cell: 9.32505 Å is half of b but for the last digits.
        let cell = Cell::from_parameters([40.96, 18.65, 22.52], [90.0, 90.77, 90.0]).unwrap();
        let (got, odd) = read(&SCREW, &cell);
        assert_eq!((got, odd), (vec![SymmetryOperation::from_triplet("-x,y+1/2,-z").unwrap()], None));
        // A third of a turn about c, with a third of c: the first operation of P 31 beyond the identity.
        let cell = Cell::from_parameters([76.5, 76.5, 201.0], [90.0, 90.0, 120.0]).unwrap();
        let (got, _) = read(
            &[
                "REMARK 290   SMTRY1   2 -0.500000 -0.866025  0.000000        0.00000",
                "REMARK 290   SMTRY2   2  0.866025 -0.500000  0.000000        0.00000",
                "REMARK 290   SMTRY3   2  0.000000  0.000000  1.000000       67.00000",
            ],
            &cell,
        );
        assert_eq!(got, [SymmetryOperation::from_triplet("-y,x-y,z+1/3").unwrap()]);
    }

    #[test]
    fn a_row_that_is_wrong_or_missing_leaves_the_whole_out_and_is_said() {
        let cell = Cell::from_parameters([40.96, 18.65, 22.52], [90.0, 90.77, 90.0]).unwrap();
        let bad = "REMARK 290   SMTRY2   2  0.000000  1.0x0000  0.000000        9.32505";
        for (lines, line, word) in [
            (vec![SCREW[0], bad, SCREW[2]], 2, "1.0x0000"),
            (vec![SCREW[0], SCREW[2]], 1, "SMTRY1, 2 and 3"),
            (vec!["REMARK 290   SMTRY4   2  0.0 0.0 1.0 0.0"], 1, "SMTRY4"),
            (vec!["REMARK 290   SMTRY1"], 1, "SMTRY1"),
        ] {
            let (got, odd) = read(&lines, &cell);
            let (at, message) = odd.unwrap();
            assert!(got.is_empty() && at == line && message.contains(word), "{at}: {message}");
        }
        // A third of a turn is none of a monoclinic cell.
        let turn = [
            "REMARK 290   SMTRY1   2 -0.500000 -0.866025  0.000000        0.00000",
            "REMARK 290   SMTRY2   2  0.866025 -0.500000  0.000000        0.00000",
            "REMARK 290   SMTRY3   2  0.000000  0.000000  1.000000        0.00000",
        ];
        let (got, odd) = read(&turn, &cell);
        assert!(got.is_empty() && odd.unwrap().1.contains("CRYST1"));
    }
}
