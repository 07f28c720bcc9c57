//! Import: bytes of a molecule file to a [`Document`].
//!
//! Way of a file: bytes → decompression (`decompress`) → text (byte order mark, UTF-16, line ends: `text`) → format
//! by content, then by extension (`detect`) → the format's reader → records and frames (`collect`).
//!
//! Triangle meshes, which are no molecules, have a way of their own: [`mesh`]. So have trajectories, whose atoms another file lists: [`trajectory`].
//! Frames come from a [`Document`] wherever they are, in memory or in a trajectory on disk: [`Document::at_frame`].
//!
//! Of large files there is a [`Glimpse`] before they are read.
//!
//! Readers never guess bonds: they hand on those the file states and say whether the list is whole. They are lenient
//! in layout and strict in values: what cannot be read is left out, with a diagnostic that names the line. An
//! [`Error`] is returned only where no molecule can be had, or a limit would be passed.
//!
//! Limits: the whole file is held in memory while it is read. It is read, not mapped: a mapped file that another
//! program shortens ends this one with a signal, and of the time for a PDB file of 79 MB reading the bytes is a fifth
//! (0.05 of 0.25 s on one core, 0.03 of 0.13 s on two, which share that too: `file`).

mod bcif;
mod cif;
mod collect;
mod cube;
mod decompress;
mod detect;
mod file;
mod glimpse;
mod gro;
mod json;
pub mod mesh;
mod mol2;
mod number;
mod pdb;
mod poscar;
mod sdf;
mod symbol;
mod text;
pub mod trajectory;
mod xyz;

use crate::error::{Error, Result};
use crate::stop::Stop;
use crate::structure::{Diagnostic, Diagnostics, Frame, Structure};
pub use glimpse::Glimpse;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use trajectory::{Trajectory, TrajectoryFormat};

/// How to read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ImportOptions {
    /// What reading may cost. Default: [`Limits::default`].
    pub limits: Limits,
    /// The format; `None` finds it out from the content, then from the extension. Default: `None`.
    pub format: Option<Format>,
    /// By which reading can be given up from another thread: it then ends soon, with [`Error::Stopped`]. Only JSON, and a mesh once it is in
    /// memory, are parsed to their end. Default: never.
    pub stop: Stop,
}

/// What reading may cost: guards against broken and hostile files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of a file after decompression. Default: 8 GiB.
    pub decompressed_bytes: u64,
    /// How many times larger than its compressed bytes a file may become, counted past the first 16 MiB.
    /// Default: 100 (coordinates compress 3 to 10 times; deflate's own bound is about 1032).
    pub ratio: u32,
    /// Atoms of one record. Default: 200,000,000.
    pub atoms: usize,
    /// Records of a file; those beyond are left out with an error. Default: 250,000 (a record takes a kilobyte
    /// beside its atoms, which a hostile file states in a dozen bytes).
    pub records: usize,
    /// Bytes of one line, in formats made of lines. Default: 1 MiB.
    pub line_bytes: usize,
    /// Levels of arrays and objects in a JSON file. Default: 64; more than 127 is as 127.
    pub json_depth: usize,
    /// Triangles of a mesh, and a third of its vertices. Default: 10,000,000 (a gigabyte when they are drawn).
    pub triangles: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            decompressed_bytes: 8 << 30,
            ratio: 100,
            atoms: 200_000_000,
            records: 250_000,
            line_bytes: 1 << 20,
            json_depth: 64,
            triangles: 10_000_000,
        }
    }
}

/// A file format that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Protein Data Bank, format version 3.3.
    Pdb,
    /// XYZ and extended XYZ.
    Xyz,
    /// MDL MOL and SD files, V2000 and V3000.
    Sdf,
    /// Tripos MOL2.
    Mol2,
    /// CIF of macromolecules and ligands (PDBx/mmCIF).
    Mmcif,
    /// CIF of small molecules and crystals.
    Cif,
    /// BinaryCIF: mmCIF with encoded columns in MessagePack.
    BinaryCif,
    /// VASP's POSCAR, CONTCAR and XDATCAR.
    Poscar,
    /// Gaussian cube (the atoms).
    Cube,
    /// GROMACS structures.
    Gro,
    /// Our own JSON.
    BallstickJson,
    /// Chemical JSON (Avogadro).
    ChemicalJson,
    /// The JSON of imolecule.
    ImoleculeJson,
    /// QCSchema: molecules, inputs and results of the MolSSI's quantum chemistry schema.
    QcSchema,
    /// PubChem's JSON of compound records.
    PubChemJson,
    /// The JSON of ChemDoodle.
    ChemDoodleJson,
}

impl Format {
    /// All formats.
    pub const ALL: [Format; 16] = [
        Format::Pdb,
        Format::Xyz,
        Format::Sdf,
        Format::Mol2,
        Format::Mmcif,
        Format::Cif,
        Format::BinaryCif,
        Format::Poscar,
        Format::Cube,
        Format::Gro,
        Format::BallstickJson,
        Format::ChemicalJson,
        Format::ImoleculeJson,
        Format::QcSchema,
        Format::PubChemJson,
        Format::ChemDoodleJson,
    ];

    /// Whether it is one of the JSON dialects.
    #[must_use]
    pub fn is_json(self) -> bool {
        matches!(
            self,
            Format::BallstickJson
                | Format::ChemicalJson
                | Format::ImoleculeJson
                | Format::QcSchema
                | Format::PubChemJson
                | Format::ChemDoodleJson
        )
    }

    /// The name on the command line and in `info --json`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Format::Pdb => "pdb",
            Format::Xyz => "xyz",
            Format::Sdf => "sdf",
            Format::Mol2 => "mol2",
            Format::Mmcif => "mmcif",
            Format::Cif => "cif",
            Format::BinaryCif => "bcif",
            Format::Poscar => "poscar",
            Format::Cube => "cube",
            Format::Gro => "gro",
            Format::BallstickJson => "json",
            Format::ChemicalJson => "cjson",
            Format::ImoleculeJson => "imolecule",
            Format::QcSchema => "qcschema",
            Format::PubChemJson => "pubchem",
            Format::ChemDoodleJson => "chemdoodle",
        }
    }

    /// The format of a name ([`Format::name`], or a file name extension such as `ent` or `mol`), in any case.
    ///
    /// ```
    /// use ballstick::import::Format;
    /// assert_eq!(Format::from_name("MOL"), Some(Format::Sdf));
    /// assert_eq!(Format::from_name("doc"), None);
    /// ```
    #[must_use]
    pub fn from_name(name: &str) -> Option<Format> {
        let name = name.to_ascii_lowercase();
        match name.as_str() {
            // `pdb1` … are biological assemblies of the PDB.
            "ent" => Some(Format::Pdb),
            _ if name.strip_prefix("pdb").is_some_and(|tail| tail.bytes().all(|b| b.is_ascii_digit())) => {
                Some(Format::Pdb)
            }
            "extxyz" | "exyz" => Some(Format::Xyz),
            "mol" | "sd" | "mdl" => Some(Format::Sdf),
            "vasp" | "contcar" | "xdatcar" => Some(Format::Poscar),
            "cub" => Some(Format::Cube),
            "ml2" | "sy2" => Some(Format::Mol2),
            // Magnetic structures.
            "mcif" => Some(Format::Cif),
            _ => Format::ALL.into_iter().find(|format| format.name() == name),
        }
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// The format it was read as.
    pub format: Format,
    /// The records, at least one. Frames (of XYZ, models of PDB) that follow one another with the same atoms are
    /// frames of one record; records of an SD file stay records.
    pub records: Vec<Structure>,
    /// Files with the positions of the first record's atoms: if there are any, their frames are those of the document.
    pub trajectories: Vec<Arc<Trajectory>>,
    /// What the reader noticed.
    pub diagnostics: Vec<Diagnostic>,
}

impl Document {
    /// Number of frames, all records together. Of trajectories those that are known so far ([`Trajectory::known_frames`]).
    #[must_use]
    pub fn frame_count(&self) -> usize {
        match self.trajectories.as_slice() {
            [] => self.records.iter().map(|record| record.frames().len()).sum(),
            trajectories => trajectories.iter().map(|trajectory| trajectory.known_frames()).sum(),
        }
    }

    /// The structure of frame `index` (from 0, all records together), with that frame alone.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no such frame, or that of a trajectory is damaged; [`Error::Io`] if it cannot be read any more.
    pub fn at_frame(&self, index: usize) -> Result<Structure> {
        let structure = match (self.trajectories.is_empty(), self.records.first()) {
            (false, Some(structure)) => Some(structure.with_frame(self.trajectory_frame(index)?).without_symmetry()),
            _ => self.frame(index).and_then(|(record, frame)| self.records.get(record)?.at_frame(frame)),
        };
        structure.ok_or_else(|| self.missing(index))
    }

    /// Record, and frame in that record, of frame `index` (from 0) of the file; `None` if there is no such frame. Frames of trajectories are in
    /// no record.
    #[must_use]
    pub fn frame(&self, index: usize) -> Option<(usize, usize)> {
        if !self.trajectories.is_empty() {
            return None;
        }
        let mut rest = index;
        for (record, structure) in self.records.iter().enumerate() {
            let frames = structure.frames().len();
            if rest < frames {
                return Some((record, rest));
            }
            rest -= frames;
        }
        None
    }

    /// Frame `index` (from 0) of the trajectories together.
    ///
    /// # Errors
    /// As [`Document::at_frame`].
    pub fn trajectory_frame(&self, index: usize) -> Result<Frame> {
        match self.trajectory_of(index)? {
            Some((trajectory, frame)) => trajectory.frame(frame),
            None => Err(self.missing(index)),
        }
    }

    /// An error that says how many frames there are if there is none of this number, from 0.
    pub(crate) fn check_frame(&self, index: usize) -> Result<()> {
        let is_there = match self.trajectories.is_empty() {
            true => self.frame(index).is_some(),
            false => self.trajectory_of(index)?.is_some(),
        };
        if is_there { Ok(()) } else { Err(self.missing(index)) }
    }

    /// The frame of this number, or the last one that is known if there is none.
    #[must_use]
    pub fn nearest_frame(&self, index: usize) -> usize {
        if self.check_frame(index).is_ok() { index } else { self.frame_count().saturating_sub(1) }
    }

    /// Whether there is more than one frame, or a trajectory.
    pub(crate) fn has_frames(&self) -> bool {
        !self.trajectories.is_empty() || self.frame_count() > 1
    }

    /// The time of frame `index` (from 0) in picoseconds, if its file says one.
    #[must_use]
    pub fn time_ps(&self, index: usize) -> Option<f64> {
        if self.trajectories.is_empty() {
            let (record, frame) = self.frame(index)?;
            return self.records.get(record)?.frames().get(frame)?.time_ps;
        }
        let (trajectory, frame) = self.trajectory_of(index).ok()??;
        trajectory.time_ps(frame).ok()?
    }

    /// The trajectory that frame `index` is in, and its number there. The frames of all but the last one with it must be counted.
    fn trajectory_of(&self, index: usize) -> Result<Option<(&Trajectory, usize)>> {
        let mut rest = index;
        for trajectory in &self.trajectories {
            if trajectory.has_frame(rest)? {
                return Ok(Some((trajectory, rest)));
            }
            rest -= trajectory.known_frames();
        }
        Ok(None)
    }

    /// What is said where there is no frame of this number, from 0.
    pub(crate) fn missing(&self, index: usize) -> Error {
        let (asked, there) = (index.saturating_add(1), self.frame_count());
        Error::input(None, format!("frame {asked} is asked for, but there are only {there}"))
    }
}

/// Reads a file; `-` is standard input.
///
/// # Errors
/// [`Error::Io`] if the file cannot be opened or read, else as [`read_bytes`].
pub fn read_path(path: &Path, options: &ImportOptions) -> Result<Document> {
    let limit = options.limits.decompressed_bytes;
    let io_error = |source| Error::Io { action: "read", path: path.to_owned(), source };
    let bytes = if path.as_os_str() == "-" {
        let mut bytes = Vec::new();
        // `take` stops at what never ends as well.
        std::io::stdin().lock().take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(io_error)?;
        bytes
    } else {
        let file = std::fs::File::open(path).map_err(io_error)?;
        trajectory::refuse_alone(path)?;
        let metadata = file.metadata().map_err(io_error)?;
        let size = metadata.len();
        if size > limit {
            return Err(too_large(limit));
        }
        let limit = file::most_bytes(&metadata, limit);
        let bytes = file::read_all(file, size, limit.saturating_add(1), &options.stop).map_err(io_error)?;
        options.stop.check()?;
        if bytes.len() as u64 > limit {
            return Err(too_large(limit));
        }
        bytes
    };
    if bytes.len() as u64 > limit {
        return Err(too_large(limit));
    }
    read_owned(bytes, &path.file_name().unwrap_or_default().to_string_lossy(), options)
}

/// Reads a file that is in memory already. `name_hint` is its name, if it has one: where the content leaves the
/// format open, the extension decides.
///
/// ```
/// use ballstick::import::{read_bytes, ImportOptions};
/// let water = b"3\nwater\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n";
/// let document = read_bytes(water, "water.xyz", &ImportOptions::default())?;
/// assert_eq!(document.records[0].atom_count(), 3);
/// # Ok::<(), ballstick::Error>(())
/// ```
///
/// # Errors
/// [`Error::Input`] if no molecule can be had from the bytes, [`Error::Limit`] if one of [`Limits`] would be passed,
/// [`Error::Unsupported`] for formats that are known but not read.
pub fn read_bytes(bytes: &[u8], name_hint: &str, options: &ImportOptions) -> Result<Document> {
    let mut diagnostics = Diagnostics::default();
    let plain = decompress::decompress(bytes, &options.limits, &options.stop, &mut diagnostics)?;
    read_plain(&plain, name_hint, options, diagnostics)
}

/// As [`read_bytes`]; compressed bytes are freed before parsing.
fn read_owned(bytes: Vec<u8>, name_hint: &str, options: &ImportOptions) -> Result<Document> {
    if !decompress::is_compressed(&bytes) {
        return read_plain(&bytes, name_hint, options, Diagnostics::default());
    }
    let mut diagnostics = Diagnostics::default();
    let plain = decompress::decompress(&bytes, &options.limits, &options.stop, &mut diagnostics)?.into_owned();
    drop(bytes);
    read_plain(&plain, name_hint, options, diagnostics)
}

fn read_plain(bytes: &[u8], name_hint: &str, options: &ImportOptions, diagnostics: Diagnostics) -> Result<Document> {
    options.stop.check()?;
    let document = parse(bytes, name_hint, options, diagnostics);
    // To a reader that is given up the text ends early: what it makes of that is nobody's.
    options.stop.check()?;
    document
}

fn parse(bytes: &[u8], name_hint: &str, options: &ImportOptions, mut diagnostics: Diagnostics) -> Result<Document> {
    if let Some(format) = TrajectoryFormat::of(bytes) {
        return Err(trajectory::needs_structure(format, name_hint));
    }
    if options.format == Some(Format::BinaryCif) || options.format.is_none() && bcif::is_binary_cif(bytes) {
        detect::warn_of_name(Format::BinaryCif, name_hint, &mut diagnostics);
        let mut records = collect::Records::new(&options.limits, &options.stop);
        bcif::read(bytes, &mut records, &mut diagnostics)?;
        return records.finish(Format::BinaryCif, diagnostics);
    }
    let text = text::normalise(bytes, &mut diagnostics);
    let format = match options.format {
        Some(format) => detect::Detected::Format(format),
        None => detect::detect(&text, name_hint, &mut diagnostics)?,
    };
    let mut records = collect::Records::new(&options.limits, &options.stop);
    let format = match format {
        detect::Detected::Json => json::read(&text, None, &mut records, &mut diagnostics)?,
        detect::Detected::Format(
            format @ (Format::BallstickJson
            | Format::ChemicalJson
            | Format::ImoleculeJson
            | Format::QcSchema
            | Format::PubChemJson
            | Format::ChemDoodleJson),
        ) => json::read(&text, Some(format), &mut records, &mut diagnostics)?,
        detect::Detected::Format(format @ Format::Pdb) => {
            pdb::read(&text, &mut records, &mut diagnostics)?;
            format
        }
        detect::Detected::Format(format @ Format::Xyz) => {
            xyz::read(&text, &mut records, &mut diagnostics)?;
            format
        }
        detect::Detected::Format(Format::Mmcif | Format::Cif) => cif::read(&text, &mut records, &mut diagnostics)?,
        detect::Detected::Format(format @ Format::BinaryCif) => {
            bcif::read(bytes, &mut records, &mut diagnostics)?;
            format
        }
        detect::Detected::Format(format @ Format::Sdf) => {
            sdf::read(&text, &mut records, &mut diagnostics)?;
            format
        }
        detect::Detected::Format(format @ Format::Mol2) => {
            mol2::read(&text, &mut records, &mut diagnostics)?;
            format
        }
        detect::Detected::Format(format @ Format::Poscar) => {
            poscar::read(&text, &mut records, &mut diagnostics)?;
            format
        }
        detect::Detected::Format(format @ Format::Cube) => {
            cube::read(&text, &mut records, &mut diagnostics)?;
            format
        }
        detect::Detected::Format(format @ Format::Gro) => {
            gro::read(&text, &mut records, &mut diagnostics)?;
            format
        }
    };
    records.finish(format, diagnostics)
}

/// Å per bohr: CODATA 2022, 5.291 772 105 44(82) × 10⁻¹¹ m.
const ANGSTROM_PER_BOHR: f64 = 0.529_177_210_544;

/// How far from the origin an atom may be, in ångström (1 cm): squares of distances stay far inside f32's range,
/// and no molecule file means it.
const FARTHEST: f64 = 1e8;

/// Whether a position is a number and not absurd; readers leave out atoms whose position is not.
#[inline]
fn is_plausible(position: glam::DVec3) -> bool {
    position.abs().max_element() <= FARTHEST && !position.is_nan()
}

fn too_large(limit: u64) -> Error {
    Error::limit(None, format!("the file has more than {limit} bytes (limit `decompressed_bytes`)"))
}

#[cfg(test)]
mod stop_tests;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back_as_formats() {
        for format in Format::ALL {
            assert_eq!(Format::from_name(format.name()), Some(format));
        }
        assert_eq!(Format::from_name("pdb1"), Some(Format::Pdb));
        assert_eq!(Format::from_name("pdbqt"), None);
    }

    #[test]
    fn frames_are_counted_across_records() {
        let text = "1\n\nC 0 0 0\n1\n\nC 1 0 0\n1\n\nN 0 0 0\n";
        let document = read_bytes(text.as_bytes(), "a.xyz", &ImportOptions::default()).unwrap();
        assert_eq!((document.records.len(), document.frame_count()), (2, 3));
        assert_eq!([0, 1, 2, 3].map(|i| document.frame(i)), [Some((0, 0)), Some((0, 1)), Some((1, 0)), None]);
    }

    #[test]
    fn a_missing_file_is_an_io_error() {
        let error = read_path(Path::new("no/such/file.pdb"), &ImportOptions::default()).unwrap_err();
        assert!(matches!(error, Error::Io { .. }), "{error}");
    }
}
