//! Reads many files and converts what can be read, one bad file not stopping the others:
//! `cargo run --release --example many_files -- data/*.sdf data/*.pdb`

use ballstick::export::{atomic, formats::StructureFormat};
use std::error::Error;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let mut paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    if paths.is_empty() {
        paths = ["data/caffeine.sdf", "data/README.md", "data/1crn.pdb"].map(PathBuf::from).to_vec();
    }
    let folder = std::env::temp_dir().join("ballstick-many-files");
    std::fs::create_dir_all(&folder)?;
    let format = StructureFormat::from_name("xyz")?;
    let mut failures = 0;
    for path in &paths {
        match convert(path, &folder, format) {
            Ok(atoms) => println!("{}: {atoms} atoms", path.display()),
            Err(error) => {
                failures += 1;
                eprintln!("{}: {error}", path.display());
            }
        }
    }
    println!("{} of {} files are in {}", paths.len() - failures, paths.len(), folder.display());
    Ok(())
}

fn convert(path: &Path, folder: &Path, format: &StructureFormat) -> ballstick::Result<usize> {
    let document = ballstick::import::read_path(path, &Default::default())?;
    let output = folder.join(path.file_stem().unwrap_or_default()).with_extension("xyz");
    atomic::write(&output, |out| (format.write)(&document.records, out))?;
    Ok(document.records.iter().map(|record| record.atom_count()).sum())
}
