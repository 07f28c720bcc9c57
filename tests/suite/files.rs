//! The molecules that tests run over: `data/`, and a corpus where `BALLSTICK_CORPUS` names one.

use std::path::{Path, PathBuf};

/// The project's own molecules.
pub(crate) fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data")
}

/// A folder of the corpus; `None`, with `SKIP` printed, if there is no corpus.
pub(crate) fn corpus(folder: &str) -> Option<PathBuf> {
    let root = std::env::var_os("BALLSTICK_CORPUS");
    if root.is_none() {
        println!("SKIP of the corpus: BALLSTICK_CORPUS is not set");
    }
    root.map(|root| Path::new(&root).join(folder))
}

/// The files of `data/` and of the corpus up to a size in bytes, sorted.
pub(crate) fn molecules(max_bytes: u64) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = [Some(data()), corpus("good")]
        .into_iter()
        .flatten()
        .flat_map(|folder| std::fs::read_dir(folder).expect("the folder is there").flatten())
        .filter(|entry| entry.metadata().is_ok_and(|data| data.is_file() && data.len() <= max_bytes))
        .map(|entry| entry.path())
        .collect();
    files.sort();
    files
}

/// A path's last part.
pub(crate) fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
