//! What belongs together of the files on a command line, and reading it: a structure and the trajectories behind it.

use super::{HEAD, Trajectory, TrajectoryFormat};
use crate::error::{Error, Result};
use crate::import::{Document, ImportOptions, decompress, read_path};
use crate::structure::{Diagnostics, Structure};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A structure file and the trajectories of its atoms.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Input {
    /// The file with the atoms; `-` is standard input.
    pub structure: PathBuf,
    /// Files with their positions, whose frames follow one another; none for the structure's own frames.
    pub trajectories: Vec<PathBuf>,
}

impl Input {
    /// A structure with its own frames.
    #[must_use]
    pub fn of(structure: PathBuf) -> Input {
        Input { structure, trajectories: Vec::new() }
    }

    /// All files, the structure first.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        std::iter::once(&self.structure).chain(&self.trajectories)
    }
}

/// Whether a file is a trajectory: by its content; where that is compressed, cut off or cannot be read, by its name.
#[must_use]
pub fn is_trajectory(path: &Path) -> bool {
    if path.as_os_str() == "-" {
        return false;
    }
    let head = head(path);
    if TrajectoryFormat::of(&head).is_some() {
        return true;
    }
    let is_open = head.len() >= HEAD && !decompress::is_compressed(&head);
    !is_open && is_named_as_one(path)
}

fn head(path: &Path) -> Vec<u8> {
    let mut head = Vec::new();
    // What is read from a pipe is gone. What cannot be read is said by whoever reads it.
    if std::fs::metadata(path).is_ok_and(|metadata| metadata.is_file())
        && let Ok(file) = std::fs::File::open(path)
    {
        let _ = file.take(HEAD as u64).read_to_end(&mut head);
    }
    head
}

fn is_named_as_one(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let name = [".gz", ".gzip", ".zst", ".zstd"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(&name);
    let named = |format: &TrajectoryFormat| name.rsplit_once('.').is_some_and(|(_, end)| end == format.name());
    TrajectoryFormat::ALL.iter().any(named)
}

/// Groups files: each trajectory goes with the structure before it. One without is an input by itself, which
/// [`read_input`] refuses with a word on what to do.
#[must_use]
pub fn inputs(files: &[PathBuf]) -> Vec<Input> {
    let mut inputs: Vec<Input> = Vec::new();
    let mut has_structure = false;
    for file in files {
        let is_trajectory = is_trajectory(file);
        match inputs.last_mut().filter(|_| is_trajectory && has_structure) {
            Some(input) => input.trajectories.push(file.clone()),
            None => {
                has_structure = !is_trajectory;
                inputs.push(Input::of(file.clone()));
            }
        }
    }
    inputs
}

/// What is said of a trajectory that is given alone.
pub(in crate::import) fn needs_structure(format: TrajectoryFormat, name: &str) -> Error {
    let message = format!(
        "this is a trajectory ({format}): it holds positions and no elements or names; give the structure before it: \
         ballstick STRUCTURE {name}"
    );
    Error::input(None, message)
}

/// Says so if a file is a trajectory, before all of it is read.
pub(in crate::import) fn refuse_alone(path: &Path) -> Result<()> {
    match TrajectoryFormat::of(&head(path)) {
        Some(format) => Err(needs_structure(format, &path.display().to_string())),
        None => Ok(()),
    }
}

/// Reads a structure and opens its trajectories.
///
/// With trajectories, the atoms are those of the structure's first record, and the frames those of the trajectories alone. In these the
/// symmetry of a crystal counts no more: a simulation's cell is another one, and all that is in it is listed.
///
/// # Errors
/// As [`read_path`]; as [`Trajectory::open`], with the name of the file; [`Error::Input`] with both names and both counts if the numbers of atoms
/// differ.
pub fn read_input(input: &Input, options: &ImportOptions) -> Result<Document> {
    let document = read_path(&input.structure, options)?;
    if input.trajectories.is_empty() {
        return Ok(document);
    }
    let mut diagnostics = Diagnostics::default();
    let only = document.records.into_iter().next().and_then(|record| record.with_only_frame(0));
    let structure = only.ok_or_else(|| Error::input(None, "there is no molecule in it"))?;
    let mut trajectories = Vec::with_capacity(input.trajectories.len());
    for path in &input.trajectories {
        let named = |error: Error| match error {
            Error::Input { message, .. } => Error::input(None, format!("{}: {message}", path.display())),
            Error::Limit { message, .. } => Error::limit(None, format!("{}: {message}", path.display())),
            other => other,
        };
        let trajectory = Trajectory::open_unless(path, &options.limits, &options.stop).map_err(named)?;
        check_atoms(&structure, &input.structure, &trajectory)?;
        if let Some(problem) = trajectory.is_counted().then(|| trajectory.problem()).flatten() {
            diagnostics.warn(None, format!("{}: {problem}", path.display()));
        }
        trajectories.push(Arc::new(trajectory));
    }
    let mut all = document.diagnostics;
    all.extend(diagnostics.into_list());
    Ok(Document { format: document.format, records: vec![structure], trajectories, diagnostics: all })
}

fn check_atoms(structure: &Structure, path: &Path, trajectory: &Trajectory) -> Result<()> {
    let (atoms, there) = (structure.atom_count(), trajectory.atom_count());
    if atoms == there {
        return Ok(());
    }
    let message = format!(
        "{} has {there} atoms a frame, but {} has {atoms} atoms: a trajectory goes with a structure of the same atoms in the \
         same order",
        trajectory.path().display(),
        path.display()
    );
    Err(Error::input(None, message))
}
