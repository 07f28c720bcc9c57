//! Trajectories: files of many frames that hold positions and no atoms, whose atoms are those of a structure read before.
//!
//! | format | written by | what is read |
//! |---|---|---|
//! | XTC (`xtc`, `packed`) | GROMACS | positions, cell, time; also with lengths of 64 bits |
//! | TRR (`trr`) | GROMACS | positions, velocities, forces, cell, time, in f32 or f64 |
//! | DCD (`dcd`) | CHARMM, X-PLOR, NAMD, LAMMPS, OpenMM | positions, cell, time; both byte orders, markers of 4 and 8 bytes, fixed atoms |
//!
//! A [`Trajectory`] stays on disk. It is opened once, its frames are found as far as they are asked for (`index`), and each is read by
//! itself, in any order and by several threads. Whatever is compressed is unpacked into memory. Lengths become ångström, times picoseconds.
//!
//! A file that ends in a frame, or in which something stands that is no frame, has the frames before it, and
//! [`Trajectory::problem`] says what happened. Nothing is set aside for what a header says before the bytes are there.

mod bytes;
mod dcd;
mod index;
mod input;
mod packed;
mod trr;
mod xtc;

pub use input::{Input, inputs, is_trajectory, read_input};
pub(super) use input::{needs_structure, refuse_alone};

use super::{FARTHEST, Limits};
use crate::error::{Error, Result};
use crate::stop::Stop;
use crate::structure::Frame;
use bytes::Bytes;
use glam::Vec3;
use index::{Ending, Index, Step};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Bytes at the beginning of a file that tell what it is.
const HEAD: usize = 128;
/// Headers that are gone over at a time (chosen: a few milliseconds where the file is in memory).
const AT_A_TIME: usize = 1000;
/// Decimals in ångström that single precision holds: 100 Å to 0.00001 Å (24 bits).
const DECIMALS_OF_F32: u8 = 5;

/// A trajectory format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TrajectoryFormat {
    /// Compressed, of GROMACS.
    Xtc,
    /// Full precision, of GROMACS.
    Trr,
    /// Of CHARMM, X-PLOR, NAMD.
    Dcd,
}

impl TrajectoryFormat {
    /// All of them.
    pub const ALL: [TrajectoryFormat; 3] = [TrajectoryFormat::Xtc, TrajectoryFormat::Trr, TrajectoryFormat::Dcd];

    /// The format by the first bytes of a file (128 are enough); `None` if it is no trajectory.
    #[must_use]
    pub fn of(head: &[u8]) -> Option<TrajectoryFormat> {
        if xtc::is_xtc(head) {
            Some(TrajectoryFormat::Xtc)
        } else if trr::is_trr(head) {
            Some(TrajectoryFormat::Trr)
        } else {
            dcd::is_dcd(head).then_some(TrajectoryFormat::Dcd)
        }
    }

    /// `xtc`, `trr` or `dcd`: the extension.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            TrajectoryFormat::Xtc => "xtc",
            TrajectoryFormat::Trr => "trr",
            TrajectoryFormat::Dcd => "dcd",
        }
    }
}

impl std::fmt::Display for TrajectoryFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name().to_ascii_uppercase())
    }
}

/// A trajectory on disk.
#[derive(Debug)]
pub struct Trajectory {
    bytes: Bytes,
    format: TrajectoryFormat,
    atoms: usize,
    /// What DCD files say once for all frames.
    dcd: Option<dcd::Header>,
    /// Where the frames of the others are.
    index: Mutex<Index>,
}

/// Two are equal if they are the same one.
impl PartialEq for Trajectory {
    fn eq(&self, other: &Trajectory) -> bool {
        std::ptr::eq(self, other)
    }
}

impl Trajectory {
    /// Opens a file and finds its first frame.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read, [`Error::Input`] if it is no trajectory or has no whole frame, [`Error::Limit`] if it has
    /// more atoms than [`Limits::atoms`], or is compressed and larger than the limits.
    pub fn open(path: &Path, limits: &Limits) -> Result<Trajectory> {
        Trajectory::open_unless(path, limits, &Stop::never())
    }

    /// The same unless it is given up meanwhile, which matters to compressed ones.
    pub(in crate::import) fn open_unless(path: &Path, limits: &Limits, stop: &Stop) -> Result<Trajectory> {
        Trajectory::new(Bytes::open(path, limits, stop)?, limits)
    }

    /// The same for what is in memory; `name` is what it is called in messages.
    ///
    /// # Errors
    /// As [`Trajectory::open`].
    pub fn of_bytes(bytes: Vec<u8>, name: &str, limits: &Limits) -> Result<Trajectory> {
        Trajectory::new(Bytes::of(bytes, Path::new(name)), limits)
    }

    fn new(bytes: Bytes, limits: &Limits) -> Result<Trajectory> {
        let head = bytes.vec(0, bytes.len().min(HEAD as u64))?;
        let format = TrajectoryFormat::of(&head)
            .ok_or_else(|| Error::input(None, "this is no trajectory that can be read: not XTC, TRR or DCD"))?;
        let dcd = match format {
            TrajectoryFormat::Dcd => Some(dcd::Header::read(&bytes)?),
            _ => None,
        };
        let atoms = match (&dcd, format) {
            (Some(header), _) => header.atoms,
            (None, TrajectoryFormat::Xtc) => xtc::atom_count(&head),
            (None, _) => trr::atom_count(&head),
        };
        if atoms > limits.atoms {
            let message = format!("the trajectory has more than {} atoms (limit `atoms`)", limits.atoms);
            return Err(Error::limit(None, message));
        }
        let trajectory = Trajectory { bytes, format, atoms, dcd, index: Mutex::new(Index::new(0)) };
        if trajectory.has_frame(0)? {
            trajectory.frame(0)?;
            return Ok(trajectory);
        }
        let why = trajectory.problem().unwrap_or_else(|| "it has none".to_owned());
        Err(Error::input(None, format!("there is no frame in this {format} file: {why}")))
    }

    /// The format.
    #[must_use]
    pub fn format(&self) -> TrajectoryFormat {
        self.format
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.bytes.path()
    }

    /// Number of atoms of each frame.
    #[must_use]
    pub fn atom_count(&self) -> usize {
        self.atoms
    }

    /// Number of frames that are known so far, at least one. They are all once [`Trajectory::is_counted`].
    #[must_use]
    pub fn known_frames(&self) -> usize {
        match &self.dcd {
            Some(header) => header.frames_in(self.bytes.len()).0,
            None => self.lock().count(),
        }
    }

    /// Whether all frames are known.
    #[must_use]
    pub fn is_counted(&self) -> bool {
        self.dcd.is_some() || self.lock().ending().is_some()
    }

    /// Counts all frames, with calls to `goes_on` from time to time, which ends it early with `false`; the number of frames known then.
    /// Other threads may read frames meanwhile.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read any more.
    pub fn count_frames(&self, mut goes_on: impl FnMut() -> bool) -> Result<usize> {
        while !self.is_counted() && goes_on() {
            let mut index = self.lock();
            let more = index.count() + AT_A_TIME;
            index.extend(more, &|offset| self.step(offset))?;
        }
        Ok(self.known_frames())
    }

    /// Whether there is a frame of this number, from 0; looks no further than it must.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read any more.
    pub fn has_frame(&self, frame: usize) -> Result<bool> {
        if self.dcd.is_none() {
            self.lock().extend(frame.saturating_add(1), &|offset| self.step(offset))?;
        }
        Ok(frame < self.known_frames())
    }

    /// A frame by its number, from 0.
    ///
    /// # Errors
    /// [`Error::Input`] if there is none or it is damaged, [`Error::Io`] if the file cannot be read any more.
    pub fn frame(&self, frame: usize) -> Result<Frame> {
        let read = match &self.dcd {
            Some(header) if frame < self.known_frames() => header.frame(&self.bytes, frame),
            Some(_) => return Err(self.missing(frame)),
            None => {
                let offset = self.offset(frame)?.ok_or_else(|| self.missing(frame))?;
                match self.format {
                    TrajectoryFormat::Trr => trr::read(&self.bytes, offset, self.atoms),
                    _ => xtc::read(&self.bytes, offset, self.atoms),
                }
            }
        };
        let named = |error| match error {
            Error::Input { message, .. } => {
                Error::input(None, format!("{}: frame {}: {message}", self.path().display(), frame.saturating_add(1)))
            }
            other => other,
        };
        read.map_err(named)
    }

    /// The time of a frame in picoseconds, if the file says one; its positions are not read.
    ///
    /// # Errors
    /// As [`Trajectory::frame`].
    pub fn time_ps(&self, frame: usize) -> Result<Option<f64>> {
        let time = match &self.dcd {
            Some(header) => header.time_ps(frame),
            None => {
                let offset = self.offset(frame)?.ok_or_else(|| self.missing(frame))?;
                match self.format {
                    TrajectoryFormat::Trr => trr::time_ps(&self.bytes, offset, self.atoms)?,
                    _ => xtc::time_ps(&self.bytes, offset)?,
                }
            }
        };
        Ok(time.filter(|time| time.is_finite()))
    }

    /// What ended the frames, if it was not the file's end, as far as is known; a sentence.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let cut = |frames: usize| match frames {
            0 => "the file is cut off in it".to_owned(),
            _ => format!("the file is cut off in frame {}; the {frames} before it are there", frames + 1),
        };
        if let Some(header) = &self.dcd {
            let (frames, is_cut) = header.frames_in(self.bytes.len());
            let promised = usize::try_from(header.promised).unwrap_or(0);
            return match is_cut {
                true => Some(cut(frames)),
                false if promised > frames => {
                    Some(format!("the header speaks of {promised} frames, and {frames} are there"))
                }
                false => None,
            };
        }
        let index = self.lock();
        let frames = index.count();
        match index.ending()? {
            Ending::Clean => None,
            Ending::Cut => Some(cut(frames)),
            Ending::Damaged { offset, what } => {
                Some(format!("after frame {frames}, at byte {offset}: {what}; the frames before are there"))
            }
        }
    }

    fn missing(&self, frame: usize) -> Error {
        let (asked, there) = (frame.saturating_add(1), self.known_frames());
        Error::input(None, format!("frame {asked} is asked for, but there are only {there}"))
    }

    /// What stands at an offset.
    fn step(&self, offset: u64) -> Result<Step> {
        match self.format {
            TrajectoryFormat::Trr => trr::step(&self.bytes, offset, self.atoms),
            _ => xtc::step(&self.bytes, offset, self.atoms),
        }
    }

    fn offset(&self, frame: usize) -> Result<Option<u64>> {
        let mut index = self.lock();
        let step = |offset| self.step(offset);
        index.extend(frame.saturating_add(1), &step)?;
        index.offset(frame, &step)
    }

    fn lock(&self) -> MutexGuard<'_, Index> {
        // A panic of another thread leaves plain data behind, which is still good.
        self.index.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The positions, if all are numbers and none is absurd.
fn plausible(points: Vec<Vec3>) -> Result<Vec<Vec3>> {
    let is_odd = |point: &Vec3| point.abs().max_element() > FARTHEST as f32 || point.is_nan();
    match points.iter().position(is_odd) {
        None => Ok(points),
        Some(atom) => {
            let [x, y, z] = points[atom].to_array();
            Err(Error::input(None, format!("atom {} is at {x}, {y}, {z} Å, which is no position", atom + 1)))
        }
    }
}
