//! The system's dialogs for files, each on a thread of its own: the window goes on while one is open.

use super::build::Waker;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// Nobody closes a dialog faster than this: then the system has none.
const NO_DIALOG: Duration = Duration::from_millis(150);

/// Asks for files.
pub(super) struct Dialogs {
    wake: Waker,
    sender: Sender<Option<Vec<PathBuf>>>,
    receiver: Receiver<Option<Vec<PathBuf>>>,
    is_open: bool,
}

impl Dialogs {
    pub(super) fn new(wake: Waker) -> Dialogs {
        let (sender, receiver) = channel();
        Dialogs { wake, sender, receiver, is_open: false }
    }

    /// Opens a dialog for files to read, unless one is open.
    pub(super) fn open(&mut self) {
        if std::mem::replace(&mut self.is_open, true) {
            return;
        }
        let (sender, wake) = (self.sender.clone(), Arc::clone(&self.wake));
        let ask = move || {
            let started = Instant::now();
            let files = rfd::FileDialog::new().set_title("Open molecules").pick_files();
            let has_none = files.is_none() && started.elapsed() < NO_DIALOG;
            // The window may be gone.
            let _ = sender.send(if has_none { None } else { Some(files.unwrap_or_default()) });
            wake();
        };
        if std::thread::Builder::new().name("dialog".to_owned()).spawn(ask).is_err() {
            let _ = self.sender.send(None);
        }
    }

    /// What was chosen: files, or `None` within if the system has no dialog.
    pub(super) fn take(&mut self) -> Option<Option<Vec<PathBuf>>> {
        let answer = self.receiver.try_recv().ok()?;
        self.is_open = false;
        Some(answer)
    }
}
