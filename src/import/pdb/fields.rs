//! The columns of an atom line, and where they run over.

use super::super::is_plausible;
use super::super::number::column_f64;
use super::super::text::{columns, field, shown};
use super::element;
use glam::DVec3;

/// The position and its most decimals; `None` if a coordinate is missing, no number, or absurd.
#[inline]
pub(super) fn position(line: &[u8]) -> Option<(DVec3, u8)> {
    if line.len() < 47 {
        return None;
    }
    let (x, x_decimals) = column_f64(line, 30, 38)?;
    let (y, y_decimals) = column_f64(line, 38, 46)?;
    let (z, z_decimals) = column_f64(line, 46, 54)?;
    let position = DVec3::new(x, y, z);
    is_plausible(position).then_some((position, x_decimals.max(y_decimals).max(z_decimals)))
}

pub(super) fn no_position_message(line: &[u8]) -> String {
    if line.len() < 47 {
        return format!("the atom is left out: its line ends at column {}, before the z coordinate", line.len());
    }
    let found = shown(columns(line, 30, 54));
    format!("the atom is left out: columns 31 to 54 should hold three coordinates, found `{found}`")
}

/// Residue name and chain identifier, which compete for column 21.
#[inline]
pub(super) fn residue_and_chain(line: &[u8]) -> (&[u8], &[u8]) {
    if matches!(line.get(20), None | Some(b' ')) {
        return (field(line, 17, 20), field(line, 21, 22));
    }
    let standard = field(line, 17, 20);
    if standard.len() <= 3 && element::is_polymer(standard) && line.get(21).is_some_and(|&byte| byte != b' ') {
        return (standard, field(line, 20, 22));
    }
    (field(line, 17, 21), field(line, 21, 22))
}

/// A formal charge: a digit and a sign in either order, or a sign alone. Anything else is 0: without a sign it is the
/// line number of an old file.
#[inline]
pub(super) fn charge(text: &[u8]) -> i8 {
    let (digit, sign) = match *text {
        [digit @ b'0'..=b'9', sign] => (digit, sign),
        [sign @ (b'+' | b'-'), digit @ b'0'..=b'9'] => (digit, sign),
        [b' ', b' '] => return 0,
        [sign @ (b'+' | b'-'), b' '] | [b' ', sign] | [sign] => (b'1', sign),
        _ => return 0,
    };
    let value = (digit - b'0') as i8;
    match sign {
        b'+' => value,
        b'-' => -value,
        _ => 0,
    }
}
