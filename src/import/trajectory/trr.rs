//! TRR: trajectories of GROMACS in full precision, with velocities and forces.
//!
//! XDR (RFC 4506): big-endian numbers in multiples of four bytes. A frame is the number 1993, the version `GMX_trn_file` as a string
//! with its length before it, ten sizes in bytes (input record, energies, cell, virial, pressure, topology, symbols, positions,
//! velocities, forces), number of atoms, step, a number that is not used, time (ps) and lambda; then the parts with a size above 0 in that
//! order. Real numbers have four or eight bytes, which the sizes of cell and positions tell. Lengths are nanometres.
//!
//! Velocities and forces become vectors of the frame, in the file's units (nm/ps; kJ/mol/nm). Frames without positions (runs
//! write velocities or forces more often than positions) are passed over.
//!
//! Source: the GROMACS manual on file formats.
//!
//! Limits: lambda and the step number are not kept.

use super::bytes::{Bytes, Numbers};
use super::index::Step;
use super::xtc::{ANGSTROM_PER_NM, cell};
use crate::error::{Error, Result};
use crate::structure::{Frame, Positions, VectorField};
use glam::Vec3;

const MAGIC: i32 = 1993;
const VERSION: &[u8; 12] = b"GMX_trn_file";
/// Bytes up to the time.
const HEADER: usize = 76;

/// Whether a file begins as one.
pub(super) fn is_trr(head: &[u8]) -> bool {
    head.get(12..24) == Some(VERSION) && Numbers { bytes: head, big_endian: true }.i32(0) == MAGIC
}

/// Number of atoms of the first frame.
pub(super) fn atom_count(head: &[u8]) -> usize {
    usize::try_from(Numbers { bytes: head, big_endian: true }.i32(64)).unwrap_or(0)
}

/// A frame as its header has it. Places are offsets in the file.
struct Header {
    is_double: bool,
    time_ps: f64,
    cell: Option<u64>,
    positions: Option<u64>,
    velocities: Option<u64>,
    forces: Option<u64>,
    end: u64,
}

/// The header at an offset, or what stands there in place of one.
fn header(bytes: &Bytes, offset: u64, atoms: usize) -> Result<std::result::Result<Header, Step>> {
    if offset >= bytes.len() {
        return Ok(Err(Step::End));
    }
    let Some(header) = bytes.array::<HEADER>(offset)? else { return Ok(Err(Step::Cut)) };
    if !is_trr(&header) {
        return Ok(Err(Step::Damaged("what is there is no frame")));
    }
    let numbers = Numbers { bytes: &header, big_endian: true };
    if usize::try_from(numbers.i32(64)) != Ok(atoms) {
        return Ok(Err(Step::Damaged("the frame has another number of atoms")));
    }
    let mut sizes = [0u64; 10];
    for (number, size) in sizes.iter_mut().enumerate() {
        match u64::try_from(numbers.i32(24 + 4 * number)) {
            Ok(bytes) => *size = bytes,
            Err(_) => return Ok(Err(Step::Damaged("a part of the frame has a negative length"))),
        }
    }
    let [record, energies, cell, virial, pressure, topology, symbols, positions, velocities, forces] = sizes;
    let of_atoms = |real: u64| atoms as u64 * 3 * real;
    // The first part that is there tells how long a real number is.
    let parts = [(cell, 9), (positions, of_atoms(1)), (velocities, of_atoms(1)), (forces, of_atoms(1))];
    let real = parts.iter().find(|(size, _)| *size > 0).map_or(4, |(size, count)| size / (*count).max(1));
    let fits = |&(size, count): &(u64, u64)| size == 0 || size == count * real;
    if !matches!(real, 4 | 8) || !parts.iter().all(fits) {
        return Ok(Err(Step::Damaged("the lengths of its parts do not go together")));
    }
    let Some(time) = bytes.array::<8>(offset + HEADER as u64)? else { return Ok(Err(Step::Cut)) };
    let time = Numbers { bytes: &time, big_endian: true };
    let mut at = offset + HEADER as u64 + 2 * real;
    let mut part = |size: u64| {
        let place = (size > 0).then_some(at);
        at += size;
        place
    };
    let _: [Option<u64>; 2] = [part(record), part(energies)];
    let cell = part(cell);
    let _: [Option<u64>; 4] = [part(virial), part(pressure), part(topology), part(symbols)];
    let [positions, velocities, forces] = [part(positions), part(velocities), part(forces)];
    if at > bytes.len() {
        return Ok(Err(Step::Cut));
    }
    let is_double = real == 8;
    let time_ps = if is_double { time.f64(0) } else { f64::from(time.f32(0)) };
    Ok(Ok(Header { is_double, time_ps, cell, positions, velocities, forces, end: at }))
}

/// What stands at an offset.
pub(super) fn step(bytes: &Bytes, offset: u64, atoms: usize) -> Result<Step> {
    Ok(match header(bytes, offset, atoms)? {
        Ok(Header { positions: Some(_), end, .. }) => Step::Frame { end },
        Ok(Header { end, .. }) => Step::Other { end },
        Err(step) => step,
    })
}

/// Time of a frame, ps.
pub(super) fn time_ps(bytes: &Bytes, offset: u64, atoms: usize) -> Result<Option<f64>> {
    Ok(header(bytes, offset, atoms)?.ok().map(|header| header.time_ps))
}

/// The frame at an offset that [`step`] found one at.
pub(super) fn read(bytes: &Bytes, offset: u64, atoms: usize) -> Result<Frame> {
    let gone = || Error::input(None, "there is no frame any more");
    let header = header(bytes, offset, atoms)?.map_err(|_| gone())?;
    let triples = |place: u64, scale: f64| -> Result<Vec<Vec3>> {
        let real = if header.is_double { 8 } else { 4 };
        let raw = bytes.vec(place, atoms as u64 * 3 * real)?;
        Ok(if header.is_double { doubles(&raw, scale) } else { super::xtc::floats(&raw, scale) })
    };
    let points = triples(header.positions.ok_or_else(gone)?, ANGSTROM_PER_NM)?;
    let mut vectors = Vec::new();
    for (name, place) in [("velocities", header.velocities), ("forces", header.forces)] {
        if let Some(place) = place {
            vectors.push(VectorField { name: name.to_owned(), vectors: triples(place, 1.0)? });
        }
    }
    let cell = match header.cell {
        None => None,
        Some(place) => {
            let raw = bytes.vec(place, if header.is_double { 72 } else { 36 })?;
            let numbers = Numbers { bytes: &raw, big_endian: true };
            cell(|number| if header.is_double { numbers.f64(8 * number) } else { f64::from(numbers.f32(4 * number)) })
        }
    };
    Ok(Frame {
        positions: Positions::from_relative(super::plausible(points)?, super::DECIMALS_OF_F32),
        cell,
        title: String::new(),
        vectors,
        time_ps: header.time_ps.is_finite().then_some(header.time_ps),
    })
}

fn doubles(raw: &[u8], scale: f64) -> Vec<Vec3> {
    let scaled = |bytes: &[u8; 8]| (f64::from_be_bytes(*bytes) * scale) as f32;
    raw.as_chunks::<8>().0.as_chunks::<3>().0.iter().map(|triple| Vec3::from(triple.each_ref().map(scaled))).collect()
}
