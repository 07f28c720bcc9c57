//! Files that a mesh names: materials and buffers. A mesh may come from anywhere, so it gets at nothing but what lies in its own
//! folder or below, links followed; and all such files together count as bytes of the mesh.

use super::super::{Limits, file, too_large};
use crate::error::{Error, Result};
use crate::stop::Stop;
use std::cell::Cell;
use std::path::{Component, Path};

/// The folder of a mesh.
pub(super) struct Folder<'a> {
    path: Option<&'a Path>,
    /// Bytes that may still be read.
    bytes_left: Cell<u64>,
    limit: u64,
}

impl<'a> Folder<'a> {
    pub(super) fn new(path: Option<&'a Path>, limits: &Limits) -> Folder<'a> {
        let limit = limits.decompressed_bytes;
        Folder { path, bytes_left: Cell::new(limit), limit }
    }

    /// All bytes of a file.
    pub(super) fn read(&self, name: &str) -> Result<Vec<u8>> {
        let Some(folder) = self.path else {
            return Err(Error::input(
                None,
                format!("the mesh needs the file {name}, but it was not read from a folder"),
            ));
        };
        // Some tools write the separator of their own system.
        let relative = name.replace('\\', "/");
        let is_below =
            Path::new(&relative).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        let has_scheme = relative.split('/').next().is_some_and(|first| first.contains(':'));
        let outside = || {
            Error::input(
                None,
                format!("the mesh names the file {name}; only files in its own folder or below are read"),
            )
        };
        if !is_below || has_scheme || relative.is_empty() {
            return Err(outside());
        }
        let path = folder.join(&relative);
        let io_error = |source| Error::Io { action: "read", path: path.clone(), source };
        // Links may lead out of the folder.
        let real = path.canonicalize().map_err(io_error)?;
        if !real.starts_with(folder.canonicalize().map_err(io_error)?) {
            return Err(outside());
        }
        // Asked before it is opened: that waits for the writer of a pipe.
        let metadata = std::fs::metadata(&real).map_err(io_error)?;
        if !metadata.is_file() {
            return Err(Error::input(None, format!("the mesh names {name}, which is no file")));
        }
        let opened = std::fs::File::open(&real).map_err(io_error)?;
        let left = self.bytes_left.get();
        let bytes = file::read_all(opened, metadata.len().min(left), left.saturating_add(1), &Stop::never())
            .map_err(io_error)?;
        let count = bytes.len() as u64;
        if count > left {
            return Err(too_large(self.limit));
        }
        self.bytes_left.set(left - count);
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_outside_the_folder_is_read() {
        let outer = tempfile::tempdir().unwrap();
        let inner = outer.path().join("mesh");
        std::fs::create_dir_all(inner.join("sub")).unwrap();
        std::fs::write(outer.path().join("secret"), "s").unwrap();
        std::fs::write(inner.join("sub/a.bin"), "abc").unwrap();
        let limits = Limits { decompressed_bytes: 5, ..Limits::default() };
        let folder = Folder::new(Some(&inner), &limits);
        assert_eq!(folder.read("sub\\a.bin").unwrap(), b"abc");
        let absolute = outer.path().join("secret").to_string_lossy().into_owned();
        #[cfg(unix)]
        std::os::unix::fs::symlink(outer.path().join("secret"), inner.join("link")).unwrap();
        for name in ["../secret", "sub/../../secret", &absolute, "http://example.org/a", "file:a", "", "sub", "link"] {
            assert!(matches!(folder.read(name), Err(Error::Input { .. } | Error::Io { .. })), "{name}");
        }
        // What was read before counts.
        assert!(matches!(folder.read("sub/a.bin"), Err(Error::Limit { .. })));
        assert!(Folder::new(None, &limits).read("sub/a.bin").is_err());
    }
}
