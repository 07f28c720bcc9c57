//! DCD: trajectories of CHARMM, X-PLOR, NAMD and others, positions in ångström.
//!
//! A Fortran file of unformatted records, each between two markers that say its length, in the byte order of the machine that wrote it;
//! markers have four bytes, or eight with some compilers. The first record is `CORD` and twenty integers ([`Header`]), the
//! second the title, the third the number of atoms; where atoms are fixed, a fourth lists those that are free, and all frames
//! but the first hold only these. A frame is an optional record with the cell, then one of all x, one of all y, one of all
//! z, and, where there is a fourth dimension, one more.
//!
//! CHARMM says its version in the last of the integers; X-PLOR has 0 there, no cell, and the time step as f64 in place of f32. Cells have six
//! f64, of which programs mean different things ([`cell`]). Times are `(first + frame · every) · step` in units of 48.88821 fs
//! (CHARMM's AKMA system: ångström, kcal/mol and atomic masses; the CHARMM manual, usage).
//!
//! The number of frames is told from the length of the file: the header's is 0 or old where a run was ended early.
//!
//! Limits: programs that write another unit of time (LAMMPS with `units metal`) cannot be told from the others.

use super::bytes::{Bytes, Numbers};
use crate::error::{Error, Result};
use crate::structure::{Cell, Frame, Positions};
use glam::{DVec3, Vec3};
use std::sync::OnceLock;

/// Picoseconds in CHARMM's unit of time.
const PS_PER_AKMA: f64 = 0.048_888_21;
/// Lengths of the first record and of that of the cell.
const FIRST: u64 = 84;
const CELL: u64 = 48;

/// How a file of this kind is laid out, from its first bytes; `None` if it is another.
fn layout(head: &[u8]) -> Option<(bool, u64)> {
    let is = |marker: usize| matches!(head.get(marker..marker + 4), Some(b"CORD" | b"VELD"));
    for big_endian in [false, true] {
        let numbers = Numbers { bytes: head, big_endian };
        if is(4) && numbers.i32(0) == FIRST as i32 {
            return Some((big_endian, 4));
        }
        if is(8) && numbers.i64(0) == FIRST as i64 {
            return Some((big_endian, 8));
        }
    }
    None
}

/// Whether a file begins as one.
pub(super) fn is_dcd(head: &[u8]) -> bool {
    layout(head).is_some()
}

/// What the records before the frames say.
#[derive(Debug)]
pub(super) struct Header {
    big_endian: bool,
    /// Bytes of a marker.
    marker: u64,
    /// Frames as the header has it.
    pub(super) promised: i32,
    first_step: i32,
    every: i32,
    /// In units of CHARMM.
    time_step: f64,
    version: i32,
    has_cell: bool,
    has_fourth: bool,
    pub(super) atoms: usize,
    /// The atoms that move, from 0; empty if all do.
    free: Vec<u32>,
    /// Where frames begin.
    start: u64,
    /// The positions of the first frame, which fixed atoms keep.
    first: OnceLock<Vec<Vec3>>,
}

impl Header {
    /// Reads the records before the frames.
    pub(super) fn read(bytes: &Bytes) -> Result<Header> {
        let cut = || Error::input(None, "the DCD file ends in its header");
        let head = bytes.array::<12>(0)?.ok_or_else(cut)?;
        let (big_endian, marker) = layout(&head).ok_or_else(|| Error::input(None, "this is no DCD file"))?;
        let record = |at: u64| record(bytes, at, big_endian, marker);
        let (first, at) = record(0)?.ok_or_else(cut)?;
        let first = bytes.vec(first, FIRST)?;
        if first.starts_with(b"VELD") {
            return Err(Error::input(None, "the DCD file holds velocities, not positions"));
        }
        let numbers = Numbers { bytes: &first, big_endian };
        let number = |index: usize| numbers.i32(4 + 4 * index);
        let version = number(19);
        let is_charmm = version != 0;
        let time_step = if is_charmm { f64::from(numbers.f32(40)) } else { numbers.f64(40) };
        let (_, at) = record(at)?.ok_or_else(cut)?; // the title
        let (place, at) = record(at)?.ok_or_else(cut)?;
        let count = bytes.array::<4>(place)?.ok_or_else(cut)?;
        let count = Numbers { bytes: &count, big_endian }.i32(0);
        let atoms = usize::try_from(count).ok().filter(|&atoms| atoms > 0);
        let atoms = atoms.ok_or_else(|| Error::input(None, format!("the DCD file says that it has {count} atoms")))?;
        let mut header = Header {
            big_endian,
            marker,
            promised: number(0),
            first_step: number(1),
            every: number(2),
            time_step,
            version,
            has_cell: is_charmm && number(10) != 0,
            has_fourth: is_charmm && number(11) != 0,
            atoms,
            free: Vec::new(),
            start: at,
            first: OnceLock::new(),
        };
        let fixed = number(8);
        if fixed != 0 {
            header.read_free(bytes, fixed)?;
        }
        Ok(header)
    }

    fn read_free(&mut self, bytes: &Bytes, fixed: i32) -> Result<()> {
        let wrong = |what: &str| Error::input(None, format!("the DCD file's list of atoms that move {what}"));
        let free = usize::try_from(fixed).ok().and_then(|fixed| self.atoms.checked_sub(fixed)).filter(|&free| free > 0);
        let free = free.ok_or_else(|| wrong("would be empty"))?;
        let (place, at) =
            record(bytes, self.start, self.big_endian, self.marker)?.ok_or_else(|| wrong("is cut off"))?;
        if at - place - self.marker != free as u64 * 4 {
            return Err(wrong("has another length than the header says"));
        }
        let raw = bytes.vec(place, free as u64 * 4)?;
        let numbers = Numbers { bytes: &raw, big_endian: self.big_endian };
        let index = |number: usize| u32::try_from(numbers.i32(4 * number)).ok()?.checked_sub(1);
        let is_there = |index: &u32| (*index as usize) < self.atoms;
        let list: Option<Vec<u32>> = (0..free).map(|number| index(number).filter(is_there)).collect();
        self.free = list.ok_or_else(|| wrong("names an atom that is not there"))?;
        self.start = at;
        Ok(())
    }

    /// Atoms whose positions a frame holds.
    fn held(&self, is_first: bool) -> u64 {
        if is_first || self.free.is_empty() { self.atoms as u64 } else { self.free.len() as u64 }
    }

    fn frame_bytes(&self, is_first: bool) -> u64 {
        let axis = self.held(is_first) * 4 + 2 * self.marker;
        let axes = if self.has_fourth { 4 } else { 3 };
        axes * axis + if self.has_cell { CELL + 2 * self.marker } else { 0 }
    }

    /// Frames in a file of this length, and whether more bytes follow them.
    pub(super) fn frames_in(&self, len: u64) -> (usize, bool) {
        let Some(rest) = len.saturating_sub(self.start).checked_sub(self.frame_bytes(true)) else {
            return (0, len > self.start);
        };
        let one = self.frame_bytes(false);
        (usize::try_from(rest / one).unwrap_or(usize::MAX).saturating_add(1), rest % one != 0)
    }

    /// Where a frame begins.
    pub(super) fn offset(&self, frame: usize) -> u64 {
        match frame {
            0 => self.start,
            _ => self.start + self.frame_bytes(true) + (frame as u64 - 1).saturating_mul(self.frame_bytes(false)),
        }
    }

    /// Time of a frame, ps; `None` where the header says none.
    pub(super) fn time_ps(&self, frame: usize) -> Option<f64> {
        let step = f64::from(self.first_step) + frame as f64 * f64::from(self.every);
        let time = step * self.time_step * PS_PER_AKMA;
        (self.time_step > 0.0 && self.every > 0 && time.is_finite()).then_some(time)
    }

    /// A frame that is there.
    pub(super) fn frame(&self, bytes: &Bytes, frame: usize) -> Result<Frame> {
        let (held, cell) = self.held_points(bytes, frame)?;
        let points = if frame == 0 || self.free.is_empty() {
            held
        } else {
            let mut all = match self.first.get() {
                Some(first) => first.clone(),
                None => {
                    let first = self.held_points(bytes, 0)?.0;
                    // Another thread may have been faster with the same.
                    let _ = self.first.set(first.clone());
                    first
                }
            };
            for (&atom, point) in self.free.iter().zip(held) {
                all[atom as usize] = point;
            }
            all
        };
        Ok(Frame {
            positions: Positions::from_relative(super::plausible(points)?, super::DECIMALS_OF_F32),
            cell,
            title: String::new(),
            vectors: Vec::new(),
            time_ps: self.time_ps(frame),
        })
    }

    /// The positions that a frame holds, and its cell.
    fn held_points(&self, bytes: &Bytes, frame: usize) -> Result<(Vec<Vec3>, Option<Cell>)> {
        let mut at = self.offset(frame);
        let mut part = |len: u64| -> Result<Vec<u8>> {
            let (place, next) = record(bytes, at, self.big_endian, self.marker)?
                .filter(|(place, next)| next - place - self.marker == len)
                .ok_or_else(|| Error::input(None, format!("a record at byte {at} has not the length of its kind")))?;
            at = next;
            bytes.vec(place, len)
        };
        let cell = if self.has_cell {
            let raw = part(CELL)?;
            let numbers = Numbers { bytes: &raw, big_endian: self.big_endian };
            cell(std::array::from_fn(|number| numbers.f64(8 * number)), self.version)
        } else {
            None
        };
        let held = self.held(frame == 0) as usize;
        let axis = held as u64 * 4;
        let [x, y, z] = [part(axis)?, part(axis)?, part(axis)?];
        let number = |raw: &[u8; 4]| if self.big_endian { f32::from_be_bytes(*raw) } else { f32::from_le_bytes(*raw) };
        let numbers = |raw| <[u8]>::as_chunks::<4>(raw).0.iter().map(number);
        let points = numbers(&x).zip(numbers(&y)).zip(numbers(&z)).map(|((x, y), z)| Vec3::new(x, y, z));
        Ok((points.collect(), cell))
    }
}

/// Where the content of a record begins, and where the next record does; `None` if there is no whole record.
fn record(bytes: &Bytes, at: u64, big_endian: bool, marker: u64) -> Result<Option<(u64, u64)>> {
    let length = |at: u64| -> Result<Option<u64>> {
        Ok(if marker == 8 {
            bytes.array::<8>(at)?.and_then(|raw| u64::try_from(Numbers { bytes: &raw, big_endian }.i64(0)).ok())
        } else {
            bytes.array::<4>(at)?.and_then(|raw| u64::try_from(Numbers { bytes: &raw, big_endian }.i32(0)).ok())
        })
    };
    let Some(len) = length(at)? else { return Ok(None) };
    let Some(behind) = (at + marker).checked_add(len).filter(|&behind| behind < bytes.len()) else { return Ok(None) };
    Ok((length(behind)? == Some(len)).then_some((at + marker, behind + marker)))
}

/// The cell of six numbers, by which programs mean three different things: `A γ B β α C` with angles in degrees or with
/// their cosines (NAMD, VMD and what follows them, under the version 24), or the lower triangle of a symmetric matrix (CHARMM from
/// version 25 on), whose rows are the vectors. With cosines all three are at most 1; a matrix is known by the version where it
/// is one (its determinants are above 0), and by what cannot be an angle.
fn cell(numbers: [f64; 6], version: i32) -> Option<Cell> {
    let [a, gamma, b, beta, alpha, c] = numbers;
    let angles = [alpha, beta, gamma];
    let [xx, xy, yy, xz, yz, zz] = numbers;
    let is_matrix = xx > 0.0
        && xx * yy - xy * xy > 0.0
        && xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz) > 0.0;
    let are_angles = angles.iter().all(|&angle| angle > 0.0 && angle < 180.0);
    let are_cosines = angles.iter().all(|cosine| cosine.abs() <= 1.0);
    if is_matrix && (version > 24 || !are_cosines && !are_angles) {
        Cell::from_vectors(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
    } else if are_cosines {
        let degrees = |cosine: f64| if cosine == 0.0 { 90.0 } else { cosine.acos().to_degrees() };
        Cell::from_parameters([a, b, c], angles.map(degrees))
    } else if are_angles {
        Cell::from_parameters([a, b, c], angles)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angles(numbers: [f64; 6], version: i32) -> Option<[f64; 6]> {
        let cell = cell(numbers, version)?;
        let ([a, b, c], [alpha, beta, gamma]) = (cell.lengths(), cell.angles_deg());
        Some([a, b, c, alpha, beta, gamma].map(|x| (x * 1e6).round() / 1e6))
    }

    #[test]
    fn degrees_cosines_and_matrices_are_told_apart() {
        let hexagonal = Some([50.0, 60.0, 70.0, 90.0, 90.0, 120.0]);
        assert_eq!(angles([50.0, 120.0, 60.0, 90.0, 90.0, 70.0], 24), hexagonal);
        assert_eq!(angles([50.0, -0.5, 60.0, 0.0, 0.0, 70.0], 24), hexagonal);
        // Degrees from a program that calls itself CHARMM 35: no matrix.
        assert_eq!(angles([50.0, 120.0, 60.0, 90.0, 90.0, 70.0], 35), hexagonal);
        assert_eq!(angles([50.0, 0.0, 60.0, 0.0, 0.0, 70.0], 35), Some([50.0, 60.0, 70.0, 90.0, 90.0, 90.0]));
        // A sheared cell as CHARMM has it.
        let got = angles([50.0, -2.0, 60.0, 0.5, 0.25, 70.0], 40).unwrap();
        let matrix = [DVec3::new(50.0, -2.0, 0.5), DVec3::new(-2.0, 60.0, 0.25), DVec3::new(0.5, 0.25, 70.0)];
        assert!((0..3).all(|axis| (got[axis] - matrix[axis].length()).abs() < 1e-5), "{got:?}");
        // What is no angle can only be a matrix, whatever the version.
        assert!(angles([50.0, -2.0, 60.0, 0.5, 3.0, 70.0], 24).is_some());
        assert_eq!(angles([0.0; 6], 24), None);
        assert_eq!(angles([f64::NAN; 6], 35), None);
    }
}
