//! SHA-256 sums of files (FIPS 180-4): they tell whether a file is the one that a picture was made of.

use crate::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::Path;

/// Bytes that are read at once (chosen: large enough that the calls do not matter).
const PIECE: usize = 1 << 18;

/// The sum of bytes, in hexadecimal.
#[must_use]
pub fn of_bytes(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// The sum of a file as it lies on the disk (packed, if it is), or of a sample. `None` for standard input, which cannot be read twice, and
/// for what is no regular file.
///
/// # Errors
/// [`Error::Io`] if it cannot be read.
pub fn of_file(path: &Path) -> Result<Option<String>> {
    if let Some(sample) = super::samples::of_path(path) {
        return Ok(Some(of_bytes(sample.bytes)));
    }
    if path.as_os_str() == "-" {
        return Ok(None);
    }
    let failed = |source| Error::Io { action: "read", path: path.to_owned(), source };
    // A pipe was read already and gives nothing more, or waits for ever.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Ok(None);
    }
    let mut file = std::fs::File::open(path).map_err(failed)?;
    let (mut sum, mut piece) = (Sha256::new(), vec![0; PIECE]);
    loop {
        match file.read(&mut piece) {
            Ok(0) => return Ok(Some(hexadecimal(&sum.finalize()))),
            Ok(count) => sum.update(&piece[..count]),
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(failed(error)),
        }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_standard() {
        // FIPS 180-2, appendix B.1.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(of_bytes(b"abc"), abc);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc");
        std::fs::write(&path, "abc").unwrap();
        assert_eq!(of_file(&path).unwrap().as_deref(), Some(abc));
        let large = vec![7; PIECE * 2 + 5];
        std::fs::write(&path, &large).unwrap();
        assert_eq!(of_file(&path).unwrap(), Some(of_bytes(&large)));
        assert!(of_file(&folder.path().join("none")).is_err());
        assert_eq!(of_file(Path::new("-")).unwrap(), None);
        assert!(of_file(Path::new("sample:caffeine")).unwrap().is_some());
    }
}
