//! Molecules that are part of the program, to begin with. Where a file is named, `sample:` and the name of one will do.

use crate::error::Result;
use crate::import::{self, Document, ImportOptions};
use std::path::{Path, PathBuf};

/// A molecule that is part of the program.
#[derive(Debug, PartialEq, Eq)]
pub struct Sample {
    /// What it is called.
    pub name: &'static str,
    /// What it shows.
    pub says: &'static str,
    /// The name of its file.
    pub file: &'static str,
    /// What is in that.
    pub bytes: &'static [u8],
}

macro_rules! sample {
    ($name:literal, $says:literal, $file:literal) => {
        Sample { name: $name, says: $says, file: $file, bytes: include_bytes!(concat!("../../data/", $file)) }
    };
}

/// All of them.
pub const SAMPLES: [Sample; 6] = [
    sample!("Caffeine", "a small molecule with its bonds", "caffeine.sdf"),
    sample!("Crambin", "a protein of 46 residues", "1crn.pdb"),
    sample!("DNA", "with a protein that reads it", "1lcd.pdb.gz"),
    sample!("Ferrocene", "iron between two rings", "ferrocene.xyz"),
    sample!("Quartz", "a crystal, its cell drawn", "quartz.cif"),
    sample!("Ethane", "a methyl group turns, frame by frame", "ethane-rotation.xyz"),
];

/// What stands before a sample's name in place of a path.
const PREFIX: &str = "sample:";

impl Sample {
    /// What stands for it where a path is expected.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        PathBuf::from(format!("{PREFIX}{}", self.name.to_lowercase()))
    }
}

/// The sample that a path such as `sample:caffeine` stands for, in any case.
#[must_use]
pub fn of_path(path: &Path) -> Option<&'static Sample> {
    let name = path.to_str()?.strip_prefix(PREFIX)?;
    SAMPLES.iter().find(|sample| sample.name.eq_ignore_ascii_case(name))
}

/// Reads a sample, a file, or standard input (`-`).
///
/// # Errors
/// As [`import::read_path`].
pub fn read(path: &Path, options: &ImportOptions) -> Result<Document> {
    match of_path(path) {
        Some(sample) => import::read_bytes(sample.bytes, sample.file, options),
        None => import::read_path(path, options),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_found_by_its_path_and_can_be_read() {
        for sample in &SAMPLES {
            assert_eq!(of_path(&sample.path()).unwrap().name, sample.name);
            assert!(read(&sample.path(), &ImportOptions::default()).unwrap().frame_count() > 0);
        }
        assert_eq!(of_path(Path::new("sample:CRAMBIN")).unwrap().name, "Crambin");
        assert!(of_path(Path::new("sample:none")).is_none() && of_path(Path::new("Crambin")).is_none());
    }
}
