//! Files that are being written and do not have their name yet.
//!
//! On Linux they have no name at all until they are whole (`O_TMPFILE`, open(2)), so that nothing can be left of a run that is
//! killed, whatever kills it. Where the system or the file system does not know that, and where another program writes, they
//! are temporary files beside their target; those are listed here, and [`abandon`] takes them away when the program is told to end.
//! So are the programs that write them.
//!
//! Limits: such a temporary file stays if the program is killed outright (SIGKILL) or runs out of memory.

use std::ffi::OsStr;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// Temporary files, and process ids of the programs that write them.
#[derive(Debug, Default)]
struct Unfinished {
    files: Vec<PathBuf>,
    writers: Vec<u32>,
}

static UNFINISHED: Mutex<Unfinished> = Mutex::new(Unfinished { files: Vec::new(), writers: Vec::new() });

fn unfinished() -> MutexGuard<'static, Unfinished> {
    // A list of names cannot be half changed.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes away all files that are not finished, for a program that is about to end: no file can be begun or finished
/// after this, whoever tries waits for the end.
pub fn abandon() {
    let list = unfinished();
    list.writers.iter().for_each(|&writer| kill(writer));
    for file in &list.files {
        drop(std::fs::remove_file(file)); // if it cannot be, nobody is left to tell
    }
    std::mem::forget(list);
}

#[cfg(unix)]
fn kill(process: u32) {
    use rustix::process::{Pid, Signal, kill_process};
    if let Some(pid) = i32::try_from(process).ok().and_then(Pid::from_raw) {
        let _ = kill_process(pid, Signal::KILL); // it may have ended by itself
    }
}

#[cfg(not(unix))]
fn kill(_process: u32) {}

/// A program that writes an unfinished file, as long as this lives.
#[derive(Debug)]
pub(super) struct Writer(u32);

impl Writer {
    pub(super) fn new(process: u32) -> Writer {
        unfinished().writers.push(process);
        Writer(process)
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        unfinished().writers.retain(|&process| process != self.0);
    }
}

/// A temporary file with a name; gone when it is dropped.
#[derive(Debug)]
pub(super) struct Named(Option<NamedTempFile>);

impl Named {
    /// Makes one called `PREFIX` and six random letters, `.tmp` behind them.
    pub(super) fn new(folder: &Path, prefix: &OsStr) -> io::Result<Named> {
        Named::made(folder, prefix, |builder| {
            #[cfg(unix)]
            {
                use std::os::unix::fs::PermissionsExt;
                builder.permissions(std::fs::Permissions::from_mode(MODE));
            }
            builder.tempfile_in(folder)
        })
    }

    fn made(
        folder: &Path,
        prefix: &OsStr,
        make: impl FnOnce(&mut tempfile::Builder<'_, '_>) -> io::Result<NamedTempFile>,
    ) -> io::Result<Named> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(prefix).suffix(".tmp");
        let mut list = unfinished();
        let file = make(&mut builder).map_err(|error| plain(error, folder))?;
        list.files.push(file.path().to_owned());
        Ok(Named(Some(file)))
    }

    pub(super) fn path(&self) -> &Path {
        self.0.as_ref().map_or(Path::new(""), NamedTempFile::path)
    }

    pub(super) fn file(&self) -> Option<&File> {
        self.0.as_ref().map(NamedTempFile::as_file)
    }

    /// Gives it the target's name, in place of what has it now.
    pub(super) fn persist(mut self, target: &Path) -> io::Result<()> {
        let mut list = unfinished();
        let Some(file) = self.0.take() else { return Ok(()) };
        let path = file.path().to_owned();
        let done = file.persist(target).map(drop).map_err(|error| error.error);
        list.files.retain(|listed| *listed != path);
        done
    }
}

impl Drop for Named {
    fn drop(&mut self) {
        if let Some(file) = self.0.take() {
            let mut list = unfinished();
            let path = file.path().to_owned();
            drop(file);
            list.files.retain(|listed| *listed != path);
        }
    }
}

/// Permissions of any new file, less the umask.
#[cfg(unix)]
const MODE: u32 = 0o666;

/// An error without tempfile's own words about its temporary name: the caller names the target.
fn plain(error: io::Error, folder: &Path) -> io::Error {
    let kind = error.kind();
    let text = error.to_string();
    let own = text.split(" at path ").next().unwrap_or_default();
    if kind == io::ErrorKind::PermissionDenied || kind == io::ErrorKind::ReadOnlyFilesystem {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        return io::Error::new(kind, format!("{own}; nothing may be written in the folder {}", folder.display()));
    }
    if own.len() == text.len() { error } else { io::Error::new(kind, own) }
}

/// A file that is written by this program, with or without a name.
#[derive(Debug)]
pub(super) enum Written {
    /// It has none yet.
    #[cfg(target_os = "linux")]
    Nameless(nameless::Nameless),
    /// It has that of a temporary file.
    Named(Named),
}

impl Written {
    /// Makes one in the folder; `prefix` begins the name of a temporary file, if there must be one.
    pub(super) fn new(folder: &Path, prefix: &OsStr) -> io::Result<Written> {
        #[cfg(target_os = "linux")]
        if let Some(file) = nameless::Nameless::new(folder, prefix) {
            return Ok(Written::Nameless(file));
        }
        Named::new(folder, prefix).map(Written::Named)
    }

    pub(super) fn file(&self) -> io::Result<&File> {
        match self {
            #[cfg(target_os = "linux")]
            Written::Nameless(file) => Ok(&file.file),
            Written::Named(file) => file.file().ok_or_else(|| io::ErrorKind::NotFound.into()),
        }
    }

    /// Gives it the target's name, in place of what has it now.
    pub(super) fn persist(self, target: &Path) -> io::Result<()> {
        match self {
            #[cfg(target_os = "linux")]
            Written::Nameless(file) => file.persist(target),
            Written::Named(file) => file.persist(target),
        }
    }
}

#[cfg(target_os = "linux")]
mod nameless {
    use super::{MODE, Named, unfinished};
    use rustix::fs::{AtFlags, CWD, OFlags, linkat};
    use std::ffi::{OsStr, OsString};
    use std::fs::File;
    use std::io::{self, Seek};
    use std::os::fd::AsRawFd;
    use std::os::unix::fs::OpenOptionsExt;
    use std::path::{Path, PathBuf};

    /// Where the system shows a process its open files by number: what has no name is named by it.
    const OPEN_FILES: &str = "/proc/self/fd";

    /// A file without a name.
    #[derive(Debug)]
    pub(in super::super) struct Nameless {
        pub(super) file: File,
        folder: PathBuf,
        prefix: OsString,
    }

    impl Nameless {
        /// `None` where the system or this file system knows no such files, or would not name them later.
        pub(super) fn new(folder: &Path, prefix: &OsStr) -> Option<Nameless> {
            let flags = i32::try_from((OFlags::TMPFILE | OFlags::CLOEXEC).bits()).ok()?;
            // Read as well: it may have to be copied.
            let file = File::options().read(true).write(true).mode(MODE).custom_flags(flags).open(folder).ok()?;
            let is_shown = std::fs::symlink_metadata(format!("{OPEN_FILES}/{}", file.as_raw_fd())).is_ok();
            is_shown.then(|| Nameless { file, folder: folder.to_owned(), prefix: prefix.to_owned() })
        }

        pub(super) fn persist(mut self, target: &Path) -> io::Result<()> {
            let shown = format!("{OPEN_FILES}/{}", self.file.as_raw_fd());
            let link = |path: &Path| linkat(CWD, &shown, CWD, path, AtFlags::SYMLINK_FOLLOW).map_err(io::Error::from);
            let first = {
                let _list = unfinished();
                link(target)
            };
            let there = match first {
                Ok(()) => return Ok(()),
                Err(error) => error.kind() == io::ErrorKind::AlreadyExists,
            };
            // A name cannot be taken from another file, only be given by one that has a name: for a moment it has one of its own.
            let linked = Named::made(&self.folder, &self.prefix, |builder| {
                builder.make_in(&self.folder, |path| {
                    link(path)?;
                    self.file.try_clone()
                })
            });
            match linked {
                Ok(named) => named.persist(target),
                Err(error) if there && error.kind() == io::ErrorKind::StorageFull => Err(error),
                // A file system that makes nameless files and cannot name them.
                Err(_) => {
                    let copy = Named::new(&self.folder, &self.prefix)?;
                    self.file.rewind()?;
                    if let Some(mut to) = copy.file() {
                        io::copy(&mut self.file, &mut to)?;
                        to.set_permissions(self.file.metadata()?.permissions())?;
                    }
                    copy.persist(target)
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_named_file_is_beside_its_target_and_listed_until_it_is_done() {
        let folder = tempfile::tempdir().unwrap();
        let listed = |path: &Path| unfinished().files.iter().any(|file| file == path);
        let file = Named::new(folder.path(), OsStr::new(".fig.png.")).unwrap();
        let (path, name) = (file.path().to_owned(), names(folder.path()).remove(0));
        assert!(name.starts_with(".fig.png.") && name.ends_with(".tmp"), "{name}");
        assert!(listed(&path));
        file.persist(&folder.path().join("fig.png")).unwrap();
        assert!(!listed(&path));
        assert_eq!(names(folder.path()), ["fig.png"]);
        let file = Named::new(folder.path(), OsStr::new("x")).unwrap();
        let path = file.path().to_owned();
        drop(file);
        assert!(!listed(&path) && !path.exists());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_nameless_file_takes_a_new_name_and_one_that_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("fig.png");
        for text in ["first", "second, in place of the first"] {
            let Some(nameless) = nameless::Nameless::new(folder.path(), OsStr::new(".fig.png.")) else {
                println!("SKIP: the file system of {} has no nameless files", folder.path().display());
                return;
            };
            (&nameless.file).write_all(text.as_bytes()).unwrap();
            assert!(!names(folder.path()).iter().any(|name| name.ends_with(".tmp")));
            nameless.persist(&target).unwrap();
            assert_eq!(std::fs::read_to_string(&target).unwrap(), text);
            assert_eq!(names(folder.path()), ["fig.png"]);
        }
    }

    #[test]
    fn errors_do_not_speak_of_temporary_names() {
        let error = Named::new(Path::new("/nonexistent-folder"), OsStr::new("x")).unwrap_err().to_string();
        assert!(!error.contains(".tmp") && error.contains("No such file"), "{error}");
    }
}
