//! XTC: compressed trajectories of GROMACS, positions in nanometres to a fixed precision.
//!
//! The layout is XDR (RFC 4506): big-endian numbers of four bytes, padded to four. A frame is
//!
//! | bytes | what |
//! |---|---|
//! | 4 | 1995, or 2023 where the length below has eight bytes (GROMACS 2023 on, for more than 298,261,617 atoms) |
//! | 4, 4, 4 | atoms, step, time (f32, ps) |
//! | 36 | three vectors of the cell, f32, nm |
//! | 4 | atoms again |
//! | | up to nine atoms: three f32 each, nm |
//! | | more: precision (f32), least and greatest integer position (3 × i32 each), index of the small numbers, length in bytes, packed positions |
//!
//! How positions are packed: [`super::packed`]. Sources: the GROMACS manual on file formats, and the description of the algorithm by
//! its author, F. van Hoesel, as the Europort project published it.
//!
//! Limits: the step number is not kept.

use super::bytes::{Bytes, Numbers};
use super::index::Step;
use super::packed;
use crate::error::{Error, Result};
use crate::structure::{Cell, Frame, Positions};
use glam::{DVec3, Vec3};

/// First numbers of a frame.
const MAGIC: i32 = 1995;
const MAGIC_LARGE: i32 = 2023;
/// Bytes up to where positions begin.
const HEADER: usize = 56;
/// Up to so many atoms are not packed.
const FEW: usize = 9;
/// Ångström in a nanometre.
pub(super) const ANGSTROM_PER_NM: f64 = 10.0;

/// Whether a file begins as one: the first number, and the number of atoms, which stands there twice.
pub(super) fn is_xtc(head: &[u8]) -> bool {
    let numbers = Numbers { bytes: head, big_endian: true };
    head.len() >= HEADER
        && matches!(numbers.i32(0), MAGIC | MAGIC_LARGE)
        && numbers.i32(4) > 0
        && numbers.i32(4) == numbers.i32(52)
}

/// Number of atoms of the first frame.
pub(super) fn atom_count(head: &[u8]) -> usize {
    usize::try_from(Numbers { bytes: head, big_endian: true }.i32(4)).unwrap_or(0)
}

/// Where the packed positions of a frame lie, and where it ends.
struct Layout {
    packed: u64,
    packed_bytes: u64,
    end: u64,
}

fn layout(bytes: &Bytes, offset: u64, header: &[u8; HEADER], atoms: usize) -> Result<Option<Layout>> {
    let body = offset.saturating_add(HEADER as u64);
    if atoms <= FEW {
        let packed_bytes = atoms as u64 * 12;
        return Ok(Some(Layout { packed: body, packed_bytes, end: body.saturating_add(packed_bytes) }));
    }
    let is_large = Numbers { bytes: header, big_endian: true }.i32(0) == MAGIC_LARGE;
    // Precision, extremes and index come first.
    let length_at = body.saturating_add(32);
    let Some(length) = bytes.array::<8>(length_at)? else { return Ok(None) };
    let numbers = Numbers { bytes: &length, big_endian: true };
    let (length, own) = if is_large { (numbers.i64(0), 8) } else { (i64::from(numbers.i32(0)), 4) };
    let Ok(packed_bytes) = u64::try_from(length) else { return Ok(None) };
    let packed = length_at.saturating_add(own);
    let padded = packed_bytes.checked_next_multiple_of(4).unwrap_or(u64::MAX);
    Ok(Some(Layout { packed, packed_bytes, end: packed.saturating_add(padded) }))
}

/// What stands at an offset.
pub(super) fn step(bytes: &Bytes, offset: u64, atoms: usize) -> Result<Step> {
    if offset >= bytes.len() {
        return Ok(Step::End);
    }
    let Some(header) = bytes.array::<HEADER>(offset)? else { return Ok(Step::Cut) };
    let numbers = Numbers { bytes: &header, big_endian: true };
    if !matches!(numbers.i32(0), MAGIC | MAGIC_LARGE) {
        return Ok(Step::Damaged("what is there is no frame"));
    }
    if usize::try_from(numbers.i32(4)) != Ok(atoms) || numbers.i32(4) != numbers.i32(52) {
        return Ok(Step::Damaged("the frame has another number of atoms"));
    }
    Ok(match layout(bytes, offset, &header, atoms)? {
        Some(layout) if layout.end <= bytes.len() => Step::Frame { end: layout.end },
        _ => Step::Cut,
    })
}

/// Time of a frame, ps.
pub(super) fn time_ps(bytes: &Bytes, offset: u64) -> Result<Option<f64>> {
    let header = bytes.array::<HEADER>(offset)?;
    Ok(header.map(|header| f64::from(Numbers { bytes: &header, big_endian: true }.f32(12))))
}

/// The frame at an offset that [`step`] found one at.
pub(super) fn read(bytes: &Bytes, offset: u64, atoms: usize) -> Result<Frame> {
    let cut = || Error::input(None, "the file ends in the frame");
    let header = bytes.array::<HEADER>(offset)?.ok_or_else(cut)?;
    let numbers = Numbers { bytes: &header, big_endian: true };
    let layout = layout(bytes, offset, &header, atoms)?.ok_or_else(cut)?;
    let (points, decimals) = if atoms <= FEW {
        let raw = bytes.vec(layout.packed, layout.packed_bytes)?;
        (floats(&raw, ANGSTROM_PER_NM), super::DECIMALS_OF_F32)
    } else {
        let head = bytes.array::<32>(offset.saturating_add(HEADER as u64))?.ok_or_else(cut)?;
        let packed = bytes.padded(layout.packed, layout.packed_bytes, packed::PADDING)?;
        packed::unpack(&head, &packed, atoms, ANGSTROM_PER_NM)?
    };
    let time = f64::from(numbers.f32(12));
    Ok(Frame {
        positions: Positions::from_relative(super::plausible(points)?, decimals),
        cell: cell(|number| f64::from(numbers.f32(16 + 4 * number))),
        title: String::new(),
        vectors: Vec::new(),
        time_ps: time.is_finite().then_some(time),
    })
}

/// A cell from its nine numbers in nm; no cell if all are 0.
pub(super) fn cell(number: impl Fn(usize) -> f64) -> Option<Cell> {
    let vector = |first: usize| DVec3::new(number(first), number(first + 1), number(first + 2)) * ANGSTROM_PER_NM;
    Cell::from_vectors(vector(0), vector(3), vector(6))
}

/// Big-endian f32 triples, scaled.
pub(super) fn floats(raw: &[u8], scale: f64) -> Vec<Vec3> {
    let scaled = |bytes: &[u8; 4]| (f64::from(f32::from_be_bytes(*bytes)) * scale) as f32;
    let point = |triple: &[[u8; 4]; 3]| Vec3::from(triple.each_ref().map(scaled));
    raw.as_chunks::<4>().0.as_chunks::<3>().0.iter().map(point).collect()
}
