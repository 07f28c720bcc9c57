//! Work in a process of its own, where the memory of processes is limited (`ulimit -v`, `ulimit -d`).
//!
//! A program that gets no memory is ended where it stands: in Rust by a signal, in a driver or a library however they like. What a picture
//! needs cannot be told to the byte beforehand, so under a limit it is tried: the program begins itself once for each input, waits,
//! and hands on what it says. Where memory ran out, it is tried once more with little of everything, that is one thread and
//! thin strips ([`is_sparing`]), which draw the same bytes; then it is an error of that input, and the others are done.
//!
//! Measured, with files of 24, 642 and 5,700 atoms, `ulimit -v`, on Linux with two cores: the system loads the program from 38 MB on (below, signal 11 or
//! the loader's own message), structures are read and written from 50 MB on, a picture of 640 × 480 with light from afar is drawn
//! from 51, 54 and 61 MB on, and of any other size from about the same (without the second trial: 64 to 112 MB). `ulimit -d` does not count
//! the program itself: 20 to 24 MB are enough for all of these.
//!
//! Limits: what is read or written by a pipe is tried once only. What wants no files (`devices`, help, the window) is done in
//! this process. Only Unix has such limits. A process and its reading of the same files cost some 10 ms an input,
//! so that it is done only below [`ENOUGH_BYTES`].

use super::report::Report;
use crate::error::{Error, Result};
use crate::export::atomic;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// By which the program tells the one that it begins which of the inputs is its own, counted from 0, and whether to be sparing.
const VARIABLE: &str = "BALLSTICK_APART";

/// What follows the number of the input in the variable.
const SPARING: &str = "sparing";

/// From such a limit on work is done in this process. Chosen: eight times what the largest picture of a million atoms takes; and
/// graphics devices, which are slow to open, are used from there on only.
pub(super) const ENOUGH_BYTES: u64 = 8 << 30;

/// Begins the line with which Rust says that memory has run out; what follows it until the end is noise.
const RUN_OUT: &str = "memory allocation of ";

/// Whether this process is the program, and not another one that uses the library.
static IS_PROGRAM: AtomicBool = AtomicBool::new(false);

/// Says that this process is the program, so that it may begin itself.
pub(super) fn allow() {
    IS_PROGRAM.store(true, Ordering::Relaxed);
}

/// What another process left to this one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Part {
    input: usize,
    is_sparing: bool,
}

impl Part {
    fn from_text(text: &str) -> Option<Part> {
        let (number, sparing) = text.split_once(' ').unwrap_or((text, ""));
        Some(Part { input: number.parse().ok()?, is_sparing: sparing == SPARING })
    }

    fn text(self) -> String {
        if self.is_sparing { format!("{} {SPARING}", self.input) } else { self.input.to_string() }
    }
}

fn part() -> Option<Part> {
    static PART: OnceLock<Option<Part>> = OnceLock::new();
    *PART.get_or_init(|| Part::from_text(&std::env::var(VARIABLE).ok()?))
}

/// The only input that this process works on; `None` if it works on all.
pub(super) fn own_input() -> Option<usize> {
    part().map(|part| part.input)
}

/// Whether to do with as little memory as there may be, at the cost of time.
pub(super) fn is_sparing() -> bool {
    part().is_some_and(|part| part.is_sparing)
}

/// Whether work is to be done by [`run`].
pub(super) fn is_wanted() -> bool {
    IS_PROGRAM.load(Ordering::Relaxed)
        && part().is_none()
        && super::memory::process_bound().is_some_and(|(bytes, _)| bytes < ENOUGH_BYTES)
}

/// From such a limit on this process may have threads of its own beside those that it begins. Chosen; a thread takes 2 MB.
const ROOMY_BYTES: u64 = 256 << 20;

/// Whether [`run`] does the work and this process has no room for threads: where one does not get what it begins with, Rust ends
/// the program.
pub(super) fn is_tight() -> bool {
    is_wanted() && super::memory::process_bound().is_some_and(|(bytes, _)| bytes < ROOMY_BYTES)
}

/// Ends this process when the one that began it ends, as if the signal had been for both.
pub(super) fn follow_parent() {
    #[cfg(target_os = "linux")]
    if part().is_some() {
        use rustix::process::{Signal, set_parent_process_death_signal};
        let _ = set_parent_process_death_signal(Some(Signal::TERM));
    }
}

/// Has a process of its own work on an input, and says what it says. `true` if all of it was done; where it was not, that was said
/// by the process.
///
/// # Errors
/// [`Error::Unsupported`] where memory ran out or another signal ended the process; [`Error::Io`] where none could be begun.
pub(super) fn run(input: usize, files: &[&Path], output: Option<&Path>, report: &Report) -> Result<bool> {
    let can_repeat = files.iter().all(|file| !file.exists() || file.is_file())
        && output.is_none_or(|output| !atomic::is_stdout(output) && (!output.exists() || output.is_file()));
    let mut said = Vec::new();
    let mut status = begin(Part { input, is_sparing: false }, report, &mut said)?;
    if has_run_out(status) && can_repeat {
        status = begin(Part { input, is_sparing: true }, report, &mut said)?;
    }
    match status.code() {
        Some(0) => Ok(true),
        Some(_) => {
            report.count_failure();
            Ok(false)
        }
        None => Err(Error::Unsupported(end_of(status))),
    }
}

/// Begins a process and hands on what it says, lines that were said before and the noise at an end of memory excepted.
fn begin(part: Part, report: &Report, said: &mut Vec<String>) -> Result<ExitStatus> {
    let failed = |source| Error::Io { action: "begin a process for", path: "itself".into(), source };
    let program = std::env::current_exe().map_err(failed)?;
    let mut arguments = std::env::args_os();
    let name: Option<OsString> = arguments.next();
    let mut command = Command::new(program);
    #[cfg(unix)]
    if let Some(name) = name {
        use std::os::unix::process::CommandExt;
        command.arg0(name);
    }
    command.args(arguments).env(VARIABLE, part.text());
    if part.is_sparing || !is_tight() {
        let threads = if part.is_sparing { 1 } else { rayon::current_num_threads() };
        command.env("RAYON_NUM_THREADS", threads.to_string());
    }
    let mut child = command.stderr(Stdio::piped()).spawn().map_err(failed)?;
    let mut held = Vec::new();
    if let Some(stream) = child.stderr.take() {
        let before = said.len();
        each_line(stream, |line| {
            if !held.is_empty() || line.starts_with(RUN_OUT) {
                held.push(line);
            } else if !said[..before].contains(&line) {
                report.line(&line);
                said.push(line);
            }
        });
    }
    let status = child.wait().map_err(failed)?;
    if !has_run_out(status) {
        held.iter().for_each(|line| report.line(line));
    }
    Ok(status)
}

fn each_line(stream: impl std::io::Read, mut take: impl FnMut(String)) {
    use std::io::BufRead;
    // What is read after an error is lost; the status tells how it ended all the same.
    for line in std::io::BufReader::with_capacity(1 << 10, stream).split(b'\n').map_while(std::io::Result::ok) {
        take(String::from_utf8_lossy(&line).into_owned());
    }
}

#[cfg(unix)]
fn signal_of(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}

#[cfg(not(unix))]
fn signal_of(_status: ExitStatus) -> Option<i32> {
    None
}

/// Whether a process ended as those do that get no memory: by itself (6), by a place in memory that is not there (7, 11: a stack
/// that could not grow, a driver that did not look), or by the system (9).
fn has_run_out(status: ExitStatus) -> bool {
    matches!(signal_of(status), Some(6 | 7 | 9 | 11))
}

fn end_of(status: ExitStatus) -> String {
    match super::memory::process_bound() {
        Some((bytes, name)) if has_run_out(status) => format!(
            "memory ran out in the middle of the work: it needs more than the {} MB that the limit of this process ({name}) allows",
            bytes / 1_000_000
        ),
        _ => format!("the work was ended in the middle ({status})"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_handed_on_as_text() {
        for part in [Part { input: 0, is_sparing: false }, Part { input: 17, is_sparing: true }] {
            assert_eq!(Part::from_text(&part.text()), Some(part));
        }
        assert_eq!((Part::from_text(""), Part::from_text("x sparing")), (None, None));
    }

    #[test]
    fn a_program_that_uses_the_library_is_never_begun_anew() {
        assert!(!is_wanted() && !is_sparing() && own_input().is_none());
    }

    #[cfg(unix)]
    #[test]
    fn ends_are_told_apart() {
        use std::os::unix::process::ExitStatusExt;
        for (signal, expected) in [(6, true), (7, true), (9, true), (11, true), (2, false), (15, false)] {
            assert_eq!(has_run_out(ExitStatus::from_raw(signal)), expected, "{signal}");
        }
        assert!(!has_run_out(ExitStatus::from_raw(1 << 8)));
        assert!(end_of(ExitStatus::from_raw(15)).contains("15"));
    }
}
