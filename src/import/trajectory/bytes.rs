//! The bytes of a trajectory, any part of them at any time: those of a file stay on disk.

use crate::error::{Error, Result};
use crate::import::{Limits, decompress, file};
use crate::stop::Stop;
use crate::structure::Diagnostics;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Bytes that may be asked for anywhere.
#[derive(Debug)]
pub(super) struct Bytes {
    path: PathBuf,
    place: Place,
    len: u64,
}

#[derive(Debug)]
enum Place {
    Disk(File),
    Memory(Vec<u8>),
}

impl Bytes {
    /// Of a file. One that is compressed is unpacked into memory, within the limits.
    pub(super) fn open(path: &Path, limits: &Limits, stop: &Stop) -> Result<Bytes> {
        let failed = |source| Error::Io { action: "read", path: path.to_owned(), source };
        let file = File::open(path).map_err(failed)?;
        let len = file.metadata().map_err(failed)?.len();
        let on_disk = Bytes { path: path.to_owned(), place: Place::Disk(file), len };
        let head = on_disk.vec(0, len.min(16))?;
        if !decompress::is_compressed(&head) {
            return Ok(on_disk);
        }
        let packed = on_disk.vec(0, len)?;
        let plain = decompress::decompress(&packed, limits, stop, &mut Diagnostics::default())?.into_owned();
        Ok(Bytes::of(plain, path))
    }

    /// Of what is in memory; the path is only a name.
    pub(super) fn of(bytes: Vec<u8>, path: &Path) -> Bytes {
        Bytes { path: path.to_owned(), len: bytes.len() as u64, place: Place::Memory(bytes) }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn len(&self) -> u64 {
        self.len
    }

    /// The `len` bytes from `offset` on, with room for `spare` more.
    fn part(&self, offset: u64, len: u64, spare: usize) -> Result<Vec<u8>> {
        let past_end = || Error::input(None, format!("the file ends before byte {}", offset.saturating_add(len)));
        // Nothing is set aside for bytes that are not there.
        let end = offset.checked_add(len).filter(|&end| end <= self.len).ok_or_else(past_end)?;
        let count = usize::try_from(len).map_err(|_| past_end())?;
        match &self.place {
            Place::Memory(bytes) => {
                let range = usize::try_from(offset).unwrap_or(usize::MAX)..usize::try_from(end).unwrap_or(usize::MAX);
                let mut part = Vec::with_capacity(count.saturating_add(spare));
                part.extend_from_slice(bytes.get(range).ok_or_else(past_end)?);
                Ok(part)
            }
            Place::Disk(file) => {
                let mut part = Vec::with_capacity(count.saturating_add(spare));
                part.resize(count, 0);
                let failed = |source| Error::Io { action: "read", path: self.path.clone(), source };
                file::read_exact_at(file, &mut part, offset).map_err(failed)?;
                Ok(part)
            }
        }
    }

    /// The `len` bytes from `offset` on.
    pub(super) fn vec(&self, offset: u64, len: u64) -> Result<Vec<u8>> {
        self.part(offset, len, 0)
    }

    /// The same with `zeros` zero bytes behind.
    pub(super) fn padded(&self, offset: u64, len: u64, zeros: usize) -> Result<Vec<u8>> {
        let mut part = self.part(offset, len, zeros)?;
        part.resize(part.len() + zeros, 0);
        Ok(part)
    }

    /// `N` bytes; `None` if the file ends before them.
    pub(super) fn array<const N: usize>(&self, offset: u64) -> Result<Option<[u8; N]>> {
        if offset.checked_add(N as u64).is_none_or(|end| end > self.len) {
            return Ok(None);
        }
        let mut array = [0; N];
        match &self.place {
            Place::Memory(bytes) => {
                let from = usize::try_from(offset).unwrap_or(usize::MAX);
                match bytes.get(from..from.saturating_add(N)) {
                    Some(part) => array.copy_from_slice(part),
                    None => return Ok(None),
                }
            }
            Place::Disk(file) => {
                let failed = |source| Error::Io { action: "read", path: self.path.clone(), source };
                file::read_exact_at(file, &mut array, offset).map_err(failed)?;
            }
        }
        Ok(Some(array))
    }
}

/// Numbers in one byte order at places of a short header; 0 where it is too short.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbers<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) big_endian: bool,
}

impl Numbers<'_> {
    fn at<const N: usize>(self, at: usize) -> [u8; N] {
        let mut array = [0; N];
        if let Some(part) = self.bytes.get(at..at.saturating_add(N)) {
            array.copy_from_slice(part);
        }
        if !self.big_endian {
            array.reverse();
        }
        array
    }

    pub(super) fn i32(self, at: usize) -> i32 {
        i32::from_be_bytes(self.at(at))
    }

    pub(super) fn i64(self, at: usize) -> i64 {
        i64::from_be_bytes(self.at(at))
    }

    pub(super) fn f32(self, at: usize) -> f32 {
        f32::from_be_bytes(self.at(at))
    }

    pub(super) fn f64(self, at: usize) -> f64 {
        f64::from_be_bytes(self.at(at))
    }
}
