//! A glimpse of a large file: some of its atoms, spread evenly over it, long before all of it is read.
//!
//! No reader is asked to be quick. Instead a small file is made of lines of the large one, and its reader reads that: what the file begins
//! with as far as atoms need it, and atom lines of many small blocks ([`sample`]). Where atoms begin and end each format says
//! ([`plan`]): XYZ, PDB, mmCIF and GRO, of which the first frame, model or block counts. There are elements, positions and residues, and no bonds.
//!
//! It is for the eye while one waits, so that on any doubt there is none: of small files, compressed and binary ones (only whole ones can be unpacked),
//! other formats, other text than ASCII and UTF-8, devices, files whose number of atoms does not agree with their size, and where a disk is too slow.

mod plan;
mod sample;

use super::trajectory::TrajectoryFormat;
use super::{Format, ImportOptions, Limits, bcif, decompress, detect, read_plain};
use crate::structure::{Diagnostics, Structure};
use sample::{Bytes, FileBytes};
use std::path::Path;
use std::time::{Duration, Instant};

/// Smaller files have no glimpse: 8 MB of mmCIF are a scene after 0.15 s on two cores, and 12 MB of XYZ after 0.7 to 0.9.
const LEAST_BYTES: u64 = 8 << 20;
/// Bytes of the beginning that tell the format (chosen: a file's first atoms are usually in them).
const HEAD_BYTES: usize = 1 << 18;
/// So long it may take (chosen: something is to be seen within a second of the program's start).
const BUDGET: Duration = Duration::from_millis(250);
/// Of the lines that look like atoms so large a part must be some.
const LEAST_READ: f64 = 0.9;

/// Some of a file's atoms.
#[derive(Debug, Clone)]
pub struct Glimpse {
    /// Every so many-th atom of the first frame, without bonds.
    pub structure: Structure,
    /// How many atoms that frame has, about.
    pub about_atoms: u64,
}

impl Glimpse {
    /// Of a file that is large and of a format with a glimpse; `None` if there is any doubt about it. It takes a quarter of a second at most.
    #[must_use]
    pub fn of_file(path: &Path) -> Option<Glimpse> {
        if path.as_os_str() == "-" {
            return None;
        }
        // What is opened must not wait for anybody, as a pipe does.
        let is_fit = |metadata: &std::fs::Metadata| {
            let sizes = LEAST_BYTES..=Limits::default().decompressed_bytes;
            metadata.is_file() && sizes.contains(&metadata.len())
        };
        let size = std::fs::metadata(path).ok().filter(is_fit)?.len();
        let file = FileBytes::new(std::fs::File::open(path).ok()?, size);
        Glimpse::of(&file, &path.file_name()?.to_string_lossy(), Some(Instant::now() + BUDGET))
    }

    /// Of bytes of any number. After the deadline it makes do with what it has, if that is enough.
    fn of(source: &dyn Bytes, name: &str, deadline: Option<Instant>) -> Option<Glimpse> {
        let head = source.some(0, HEAD_BYTES)?;
        let is_text = !decompress::is_compressed(&head)
            && TrajectoryFormat::of(&head).is_none()
            && !bcif::is_binary_cif(&head)
            && !head.starts_with(b"\xef\xbb\xbf")
            && !head.contains(&0);
        if !is_text {
            return None;
        }
        let whole_lines = &head[..=memchr::memrchr(b'\n', &head)?];
        let detected = detect::detect(whole_lines, name, &mut Diagnostics::default()).ok()?;
        let detect::Detected::Format(format) = detected else { return None };
        let (small, about_atoms) = match format {
            Format::Xyz => plan::xyz(source, whole_lines, deadline),
            Format::Gro => plan::gro(source, whole_lines, deadline),
            Format::Pdb => plan::pdb(source, whole_lines, deadline),
            Format::Mmcif => plan::mmcif(source, deadline),
            _ => None,
        }?;
        let options = ImportOptions { format: Some(format), ..ImportOptions::default() };
        let document = read_plain(&small.text, name, &options, Diagnostics::default()).ok()?;
        let structure = document.records.into_iter().next()?.at_frame(0)?;
        let is_read = structure.atom_count() as f64 >= LEAST_READ * small.atoms as f64;
        is_read.then_some(Glimpse { structure, about_atoms })
    }
}

#[cfg(test)]
mod tests;
