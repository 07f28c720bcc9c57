//! The bytes of a file, large ones read by all cores: of the time that reading takes most goes to copying and to
//! the memory's first use, which several cores share.

use crate::stop::Stop;
use rayon::prelude::*;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

/// Bytes that one core reads on end (chosen: a few milliseconds).
const PIECE: usize = 4 << 20;

/// All bytes of a file that is said to have `size`, at most `most` of them. A file that is longer or shorter than it said is
/// read as it is; of one that is given up there is a part.
pub(super) fn read_all(mut file: File, size: u64, most: u64, stop: &Stop) -> io::Result<Vec<u8>> {
    let said = usize::try_from(size.min(most)).unwrap_or(0);
    let mut bytes = Vec::new();
    if said >= 2 * PIECE && rayon::current_num_threads() > 1 {
        bytes = read_pieces(&file, said, PIECE, stop).unwrap_or_default();
        file.seek(SeekFrom::Start(bytes.len() as u64))?;
    }
    if bytes.is_empty() {
        bytes.try_reserve_exact(said.saturating_add(1)).map_err(|_| io::ErrorKind::OutOfMemory)?;
    }
    // `take` stops at what never ends (a device) as well.
    let mut rest = file.take(most - bytes.len() as u64);
    while !stop.is_set() && rest.by_ref().take(PIECE as u64).read_to_end(&mut bytes)? > 0 {}
    Ok(bytes)
}

/// Most bytes that are read of a device, such as a terminal (chosen: no one types as many).
const DEVICE_BYTES: u64 = 1 << 26;

/// How many bytes may be read of what has this metadata, if files may have `limit`: devices need have no end.
pub(super) fn most_bytes(metadata: &std::fs::Metadata, limit: u64) -> u64 {
    if is_device(metadata) { limit.min(DEVICE_BYTES) } else { limit }
}

/// Whether it is a device that gives bytes one after another, `/dev/zero` or a terminal.
#[cfg(unix)]
pub(super) fn is_device(metadata: &std::fs::Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_char_device(&metadata.file_type())
}

#[cfg(not(unix))]
pub(super) fn is_device(_: &std::fs::Metadata) -> bool {
    false
}

/// The first `size` bytes, those behind where it is given up 0; an error if there are fewer, or if they can only be read one after another.
fn read_pieces(file: &File, size: usize, piece_bytes: usize, stop: &Stop) -> io::Result<Vec<u8>> {
    // A vector of zeros is memory that the system has cleared already; whether there is as much is asked first.
    Vec::<u8>::new().try_reserve_exact(size).map_err(|_| io::ErrorKind::OutOfMemory)?;
    let mut bytes = vec![0; size];
    let pieces = bytes.par_chunks_mut(piece_bytes).enumerate();
    pieces.try_for_each(|(index, piece)| match stop.is_set() {
        true => Ok(()),
        false => read_exact_at(file, piece, (index * piece_bytes) as u64),
    })?;
    Ok(bytes)
}

/// All of `bytes` from a place of the file on, wherever others read.
#[cfg(unix)]
pub(super) fn read_exact_at(file: &File, bytes: &mut [u8], offset: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, offset)
}

#[cfg(windows)]
pub(super) fn read_exact_at(file: &File, bytes: &mut [u8], offset: u64) -> io::Result<()> {
    let mut done = 0;
    while done < bytes.len() {
        match std::os::windows::fs::FileExt::seek_read(file, &mut bytes[done..], offset + done as u64) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(count) => done += count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[cfg(not(any(unix, windows)))]
pub(super) fn read_exact_at(_: &File, _: &mut [u8], _: u64) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_and_wrong_sizes_give_the_file() {
        let path = std::env::temp_dir().join(format!("ballstick-file-{}", std::process::id()));
        let content: Vec<u8> = (0..1000u32).flat_map(u32::to_le_bytes).collect();
        std::fs::write(&path, &content).unwrap();
        let (open, never) = (|| File::open(&path).unwrap(), Stop::never());
        for piece_bytes in [1, 7, 4000, 5000] {
            assert!(read_pieces(&open(), 4000, piece_bytes, &never).unwrap() == content, "{piece_bytes}");
        }
        assert!(read_pieces(&open(), 4001, 7, &never).is_err());
        for size in [0, 10, 4000, 9999, 3 * PIECE as u64] {
            assert!(read_all(open(), size, u64::MAX, &never).unwrap() == content, "{size}");
        }
        assert!(read_all(open(), 4000, 1001, &never).unwrap() == content[..1001]);
        std::fs::remove_file(&path).unwrap();
    }
}
