//! What is said on standard error, how far the work is, and how it ended.

use crate::error::Error;
use crate::structure::Diagnostic;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Work shorter than this shows no progress bar.
const BAR_AFTER: Duration = Duration::from_secs(1);

/// Speaks on standard error and counts failures.
#[derive(Default)]
pub(super) struct Report {
    failures: AtomicUsize,
    /// Whether warnings and notes are left out: another process has said them.
    is_mute: AtomicBool,
    bar: Option<(ProgressBar, Sender<()>)>,
}

impl Report {
    /// Something went on with a loss.
    pub(super) fn warn(&self, path: &Path, message: &str) {
        self.remark(&format!("ballstick: {}: warning: {message}", path.display()));
    }

    /// Something that is worth knowing and no loss.
    pub(super) fn note(&self, path: &Path, message: &str) {
        self.remark(&format!("ballstick: {}: note: {message}", path.display()));
    }

    /// Leaves warnings and notes out until [`Report::speak`].
    pub(super) fn mute(&self) {
        self.is_mute.store(true, Ordering::Relaxed);
    }

    /// Says warnings and notes again.
    pub(super) fn speak(&self) {
        self.is_mute.store(false, Ordering::Relaxed);
    }

    fn remark(&self, text: &str) {
        if !self.is_mute.load(Ordering::Relaxed) {
            self.line(text);
        }
    }

    /// What a reader noticed.
    pub(super) fn diagnostic(&self, path: &Path, diagnostic: &Diagnostic) {
        self.line(&format!("ballstick: {}: {diagnostic}", path.display()));
    }

    /// An input failed; the run goes on and ends with 1.
    pub(super) fn fail(&self, path: &Path, error: &Error) {
        match error {
            // Its message names the file, which may be another one.
            Error::Io { .. } => self.fail_with(&error.to_string()),
            _ => self.fail_with(&format!("{}: {error}", path.display())),
        }
    }

    /// As [`Report::fail`], in other words.
    pub(super) fn fail_with(&self, message: &str) {
        self.count_failure();
        self.line(&format!("ballstick: error: {message}"));
    }

    /// An input failed, and that was said.
    pub(super) fn count_failure(&self) {
        self.failures.fetch_add(1, Ordering::Relaxed);
    }

    /// A line as it is, but for control characters: texts from files must not steer the terminal.
    /// A standard error that is closed is no reason to stop.
    pub(super) fn line(&self, text: &str) {
        let text = printable(text);
        let write = || drop(writeln!(std::io::stderr(), "{text}"));
        match &self.bar {
            Some((bar, _)) => bar.suspend(write),
            None => write(),
        }
    }

    /// Shows a bar on a terminal once the work has taken a second; `total` steps, or a spinner for one.
    pub(super) fn start(&mut self, total: usize) {
        if !std::io::stderr().is_terminal() {
            return;
        }
        let bar = ProgressBar::with_draw_target(Some(total as u64), ProgressDrawTarget::hidden());
        let template =
            if total > 1 { "{spinner} {wide_bar} {pos}/{len} {eta} {msg}" } else { "{spinner} {elapsed} {msg}" };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let (stop, stopped) = channel();
        let shown = bar.clone();
        let show = move || {
            if stopped.recv_timeout(BAR_AFTER) == Err(RecvTimeoutError::Timeout) {
                shown.set_draw_target(ProgressDrawTarget::stderr());
                shown.enable_steady_tick(Duration::from_millis(100));
            }
        };
        if std::thread::Builder::new().name("progress".to_owned()).spawn(show).is_err() {
            return; // a system without room for a thread has none for a bar
        }
        self.bar = Some((bar, stop));
    }

    /// What is being worked on.
    pub(super) fn step(&self, done: usize, message: &str) {
        if let Some((bar, _)) = &self.bar {
            bar.set_position(done as u64);
            bar.set_message(printable(message));
        }
    }

    /// How far one long step is.
    pub(super) fn within_step(&self, message: &str) {
        if let Some((bar, _)) = &self.bar {
            bar.set_message(printable(message));
        }
    }

    /// Takes the bar away and gives the exit status: 0, or 1 if some input failed.
    pub(super) fn finish(mut self) -> u8 {
        self.clear();
        u8::from(self.failures.load(Ordering::Relaxed) > 0)
    }

    fn clear(&mut self) {
        if let Some((bar, stop)) = self.bar.take() {
            drop(stop); // wakes the thread, if it still waits
            bar.finish_and_clear();
        }
    }

    /// How many inputs failed.
    #[cfg(test)]
    pub(super) fn failures(&self) -> usize {
        self.failures.load(Ordering::Relaxed)
    }
}

/// Marks that show text in another order than it stands (Unicode Standard Annex 9, 2.1 to 2.5): a name that is not what it seems.
fn turns_text(c: char) -> bool {
    matches!(c, '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}' | '\u{2028}' | '\u{2029}')
}

/// The text with everything that could steer a terminal replaced.
pub(super) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || turns_text(c) { '\u{FFFD}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_failure_makes_the_status_1() {
        let report = Report::default();
        report.warn(Path::new("a"), "odd");
        assert_eq!(report.finish(), 0);
        let report = Report::default();
        report.fail(Path::new("a"), &Error::input(3, "bad"));
        assert_eq!((report.failures(), report.finish()), (1, 1));
    }

    #[test]
    fn texts_from_files_cannot_steer_the_terminal() {
        assert_eq!(printable("a\x1b[2Jb\rc"), "a\u{FFFD}[2Jb\u{FFFD}c");
        assert_eq!(printable("\u{202E}bdp.scr é"), "\u{FFFD}bdp.scr é");
    }
}
