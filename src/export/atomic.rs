//! Writing a file whole or not at all.
//!
//! The bytes go to a file without a name, or where the system has no such files to a temporary one `.NAME.XXXXXX.tmp`, in the
//! folder of the target, which takes the target's name when all is written ([`super::unfinished`]). A run that fails or is killed
//! leaves the old file as it was; at worst such a temporary file stays.
//!
//! - `-` and `/dev/stdout` are standard output.
//! - What is not a regular file (`/dev/null`, pipes, sockets) and everything under `/dev` and `/proc` is written
//!   directly.
//! - A symbolic link stays one: the file it points to is replaced.
//! - A new file gets the permissions any new file gets (umask), an old one keeps its own; a write-protected
//!   one is refused.
//!
//! Limit: the data is not forced to the disk before the rename, so this protects from failing and killed
//! runs, not from power cuts.

use super::unfinished::{Named, Written};
use crate::error::{Error, Result};
use std::ffi::OsString;
use std::fs::{File, Metadata};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Bytes gathered before a system call; large enough that the calls do not matter.
const BUFFER_BYTES: usize = 1 << 18;

/// Links followed before a chain of them counts as a loop: Linux's own limit, path_resolution(7).
const MAX_LINKS: usize = 40;

/// Whether the path means standard output.
#[must_use]
pub fn is_stdout(path: &Path) -> bool {
    path == Path::new("-") || path == Path::new("/dev/stdout")
}

/// Writes what `body` writes to `path`, as the module describes.
///
/// ```
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("note.txt");
/// ballstick::export::atomic::write(&path, |out| out.write_all(b"done"))?;
/// assert_eq!(std::fs::read(&path)?, b"done");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Error::Io`] with the path, for what the system refuses and for what `body` returns. Standard output whose
/// reader has gone gives [`ErrorKind::BrokenPipe`]; see [`is_broken_pipe`].
pub fn write(path: &Path, body: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let failed = |source| Error::Io { action: "write", path: path.to_owned(), source };
    if is_stdout(path) {
        return buffered(io::stdout().lock(), body).map_err(failed);
    }
    let target = follow_links(path).map_err(failed)?;
    let old = match std::fs::metadata(&target) {
        Ok(metadata) => Some(metadata),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(failed(error)),
    };
    match old {
        Some(metadata) if metadata.is_dir() => {
            Err(failed(io::Error::new(ErrorKind::IsADirectory, "it is a folder; give the name of a file")))
        }
        Some(metadata) if !metadata.is_file() || is_system_path(path) => {
            let file = File::options().write(true).truncate(metadata.is_file()).open(&target).map_err(failed)?;
            buffered(file, body).map_err(failed)
        }
        old => replace(&target, old.as_ref(), body).map_err(failed),
    }
}

/// Whether an error only says that nobody reads standard output any more, as in `ballstick info x | head -1`.
#[must_use]
pub fn is_broken_pipe(error: &Error) -> bool {
    matches!(error, Error::Io { path, source, .. } if is_stdout(path) && source.kind() == ErrorKind::BrokenPipe)
}

fn buffered<W: Write>(out: W, body: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER_BYTES, out);
    body(&mut out)?;
    out.flush()
}

fn replace(
    target: &Path,
    old: Option<&Metadata>,
    body: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let folder = folder_of(target, old)?;
    let file = Written::new(folder, &temporary_prefix(target))?;
    buffered(file.file()?, body)?;
    if let Some(old) = old {
        file.file()?.set_permissions(old.permissions())?;
    }
    file.persist(target)
}

/// As [`write()`], for another program that writes: `body` gets the path of the temporary file. Only files will do.
///
/// # Errors
/// As [`write()`].
pub fn write_by_path(path: &Path, body: impl FnOnce(&Path) -> io::Result<()>) -> Result<()> {
    let failed = |source| Error::Io { action: "write", path: path.to_owned(), source };
    let target = follow_links(path).map_err(failed)?;
    let old = std::fs::metadata(&target).ok();
    if old.as_ref().is_some_and(|old| !old.is_file()) || is_stdout(path) || is_system_path(path) {
        return Err(failed(io::Error::new(ErrorKind::InvalidInput, "it is no file; give the name of one")));
    }
    let written = || {
        let file = Named::new(folder_of(&target, old.as_ref())?, &temporary_prefix(&target))?;
        body(file.path())?;
        if let (Some(old), Some(file)) = (&old, file.file()) {
            file.set_permissions(old.permissions())?;
        }
        file.persist(&target)
    };
    written().map_err(failed)
}

/// The folder of a target that may be written.
fn folder_of<'a>(target: &'a Path, old: Option<&Metadata>) -> io::Result<&'a Path> {
    if old.is_some_and(|metadata| metadata.permissions().readonly()) {
        let message = "the file is there and write-protected; remove the protection or choose another name";
        return Err(io::Error::new(ErrorKind::PermissionDenied, message));
    }
    let folder = match target.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        let message = format!("there is no folder {}; make it first", folder.display());
        return Err(io::Error::new(ErrorKind::NotFound, message));
    }
    Ok(folder)
}

/// `.NAME.`, cut so that the temporary name stays within the 255 bytes that file systems allow.
fn temporary_prefix(target: &Path) -> OsString {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let mut end = name.len().min(200);
    while !name.is_char_boundary(end) {
        end -= 1;
    }
    format!(".{}.", &name[..end]).into()
}

/// Files of the system that stand for something else (`/dev/fd/3`): replacing them would miss what they stand for.
fn is_system_path(path: &Path) -> bool {
    path.starts_with("/dev") || path.starts_with("/proc")
}

/// The path a chain of symbolic links ends at, which need not exist.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    if is_system_path(&path) {
        return Ok(path);
    }
    for _ in 0..MAX_LINKS {
        match std::fs::symlink_metadata(&path) {
            Ok(metadata) if metadata.is_symlink() => {
                let link = std::fs::read_link(&path)?;
                path = path.parent().map_or_else(|| link.clone(), |parent| parent.join(&link));
            }
            _ => return Ok(path), // what is wrong with it, if anything, the write says
        }
    }
    Err(io::Error::other("the symbolic links go in a circle"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn listing(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fig.png");
        fs::write(&path, "old").unwrap();
        let result = write(&path, |out| {
            out.write_all(b"half a picture")?;
            Err(io::Error::other("broke"))
        });
        assert!(result.unwrap_err().to_string().contains("broke"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(listing(folder.path()), ["fig.png"]);
    }

    #[test]
    fn a_panic_in_the_middle_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fig.png");
        let result = std::panic::catch_unwind(|| write(&path, |_| panic!("on purpose")));
        assert!(result.is_err());
        assert!(listing(folder.path()).is_empty());
    }

    #[test]
    fn another_program_gets_a_temporary_name_in_the_same_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film.mp4");
        write_by_path(&path, |place| {
            let names = listing(folder.path());
            assert!(names.len() == 1 && names[0].starts_with(".film.mp4.") && names[0].ends_with(".tmp"), "{names:?}");
            fs::write(place, "a film")
        })
        .unwrap();
        assert_eq!(
            (listing(folder.path()), fs::read(&path).unwrap()),
            (vec!["film.mp4".to_owned()], b"a film".to_vec())
        );
    }

    #[test]
    fn names_as_long_as_file_systems_allow_can_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("é".repeat(127));
        write(&path, |out| out.write_all(b"x")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"x");
    }

    #[test]
    fn a_missing_folder_and_a_folder_are_said_to_be_that() {
        let folder = tempfile::tempdir().unwrap();
        let missing = write(&folder.path().join("no/fig.png"), |_| Ok(())).unwrap_err().to_string();
        assert!(missing.contains("there is no folder"), "{missing}");
        let is_folder = write(folder.path(), |_| Ok(())).unwrap_err().to_string();
        assert!(is_folder.contains("it is a folder"), "{is_folder}");
    }

    #[cfg(unix)]
    mod unix {
        use super::*;
        use std::os::unix::fs::{PermissionsExt, symlink};

        #[test]
        fn permissions_are_those_of_any_new_file_and_old_ones_stay() {
            let folder = tempfile::tempdir().unwrap();
            let (plain, ours) = (folder.path().join("plain"), folder.path().join("ours"));
            fs::write(&plain, "").unwrap();
            write(&ours, |_| Ok(())).unwrap();
            let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
            assert_eq!(mode(&ours), mode(&plain));
            fs::set_permissions(&ours, fs::Permissions::from_mode(0o640)).unwrap();
            write(&ours, |out| out.write_all(b"new")).unwrap();
            assert_eq!(mode(&ours) & 0o777, 0o640);
        }

        #[test]
        fn a_write_protected_file_is_refused() {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("fig.png");
            fs::write(&path, "old").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
            assert!(write(&path, |_| Ok(())).unwrap_err().to_string().contains("write-protected"));
            assert_eq!(fs::read(&path).unwrap(), b"old");
        }

        #[test]
        fn links_are_followed_and_stay() {
            let folder = tempfile::tempdir().unwrap();
            let (link, again, file) =
                (folder.path().join("link"), folder.path().join("again"), folder.path().join("sub/file"));
            fs::create_dir(folder.path().join("sub")).unwrap();
            symlink("again", &link).unwrap();
            symlink("sub/file", &again).unwrap(); // dangling until the first write
            for text in [b"one", b"two"] {
                write(&link, |out| out.write_all(text)).unwrap();
                assert_eq!(fs::read(&file).unwrap(), text);
                assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            }
        }

        #[test]
        fn links_in_a_circle_are_an_error() {
            let folder = tempfile::tempdir().unwrap();
            let (a, b) = (folder.path().join("a"), folder.path().join("b"));
            symlink(&a, &b).unwrap();
            symlink(&b, &a).unwrap();
            assert!(write(&a, |_| Ok(())).unwrap_err().to_string().contains("circle"));
        }

        #[test]
        fn devices_are_written_directly() {
            write(Path::new("/dev/null"), |out| out.write_all(b"gone")).unwrap();
            assert!(!fs::metadata("/dev/null").unwrap().is_file());
        }
    }
}
