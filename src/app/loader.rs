//! Files are read on threads of their own: the window never waits for a disk, and a large file can be given up.

use super::build::{Maker, Waker};
use super::preview::Preview;
use super::work::Source;
use crate::crystal::CrystalOptions;
use crate::error::{Error, Result};
use crate::import::{Document, ImportOptions, trajectory};
use crate::scene::SceneOptions;
use crate::session::samples;
use crate::stop::Stop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often the bar of frames learns of more of them (chosen).
const TELL_EVERY: Duration = Duration::from_millis(250);

/// How far a file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    Reading = 0,
    Bonds = 1,
    Done = 2,
}

/// A file that was read: what was loaded, and what there is to say.
pub(super) struct Loaded {
    pub(super) load: u32,
    pub(super) source: Source,
    pub(super) result: Result<Arc<Document>>,
}

/// A file that is being read.
pub(super) struct Load {
    pub(super) id: u32,
    pub(super) source: Source,
    pub(super) started: Instant,
    /// The layer in whose place it comes, with the frame that was shown.
    pub(super) replaces: Option<u32>,
    stage: Arc<AtomicU8>,
    stop: Stop,
}

impl Load {
    pub(super) fn stage(&self) -> Stage {
        match self.stage.load(Ordering::Relaxed) {
            0 => Stage::Reading,
            1 => Stage::Bonds,
            _ => Stage::Done,
        }
    }
}

/// All files that are being read.
pub(super) struct Loader {
    maker: Arc<Maker>,
    wake: Waker,
    sender: Sender<Loaded>,
    receiver: Receiver<Loaded>,
    previews: (Sender<Preview>, Receiver<Preview>),
    under_way: Vec<Load>,
    next: u32,
    /// What is to be said of trajectories since the last call.
    problems: Arc<Mutex<Vec<String>>>,
}

impl Loader {
    pub(super) fn new(maker: Arc<Maker>, wake: Waker) -> Loader {
        let (sender, receiver) = channel();
        let (previews, problems) = (channel(), Arc::default());
        Loader { maker, wake, sender, receiver, previews, under_way: Vec::new(), next: 1, problems }
    }

    /// A number for what comes without being read here.
    pub(super) fn number(&mut self) -> u32 {
        self.next += 1;
        self.next - 1
    }

    /// Begins to read; with a look for a preview if there is to be one.
    pub(super) fn start(
        &mut self,
        source: Source,
        crystal: CrystalOptions,
        replaces: Option<u32>,
        preview: Option<SceneOptions>,
    ) {
        let (stage, stop) = (Arc::new(AtomicU8::new(0)), Stop::new());
        let id = self.next;
        self.next += 1;
        let load = Load {
            id,
            source: source.clone(),
            started: Instant::now(),
            replaces,
            stage: Arc::clone(&stage),
            stop: stop.clone(),
        };
        let (maker, wake, sender) = (Arc::clone(&self.maker), Arc::clone(&self.wake), self.sender.clone());
        let (problems, previews) = (Arc::clone(&self.problems), self.previews.0.clone());
        let work = move || {
            // The atoms of a structure are elsewhere in the frames of its trajectories.
            if let (Some(options), Source::File(input)) = (preview, &source)
                && input.trajectories.is_empty()
                && let Ok(Some(preview)) = guarded(|| Ok(Preview::of_file(id, &input.structure, &options)))
            {
                // The window may be gone.
                let _ = previews.send(preview);
                wake();
            }
            let result = guarded(|| read(&source, &crystal, &maker, &stage, &stop));
            stage.store(Stage::Done as u8, Ordering::Relaxed);
            if stop.is_set() {
                // Freeing it may take a while, and nobody waits for this thread.
                if let Ok(document) = &result {
                    maker.forget(|other| !Arc::ptr_eq(other, document));
                }
                return;
            }
            let document = result.as_ref().ok().map(Arc::clone);
            // The window may be gone.
            let _ = sender.send(Loaded { load: id, source, result });
            wake();
            if let Some(document) = document {
                count_frames(&document, &wake, &problems);
            }
        };
        match std::thread::Builder::new().name("read".to_owned()).spawn(work) {
            Ok(_) => self.under_way.push(load),
            Err(error) => {
                let result = Err(Error::Unsupported(format!("the system gives no thread to read on: {error}")));
                let _ = self.sender.send(Loaded { load: id, source: load.source, result });
            }
        }
    }

    /// What is being read.
    pub(super) fn under_way(&self) -> &[Load] {
        &self.under_way
    }

    /// Gives up all that is being read: readers and the search for bonds end soon, and nobody sees what they had.
    pub(super) fn cancel(&mut self) {
        for load in self.under_way.drain(..) {
            load.stop.set();
        }
    }

    /// The previews that were made since the last call.
    pub(super) fn previews(&self) -> Vec<Preview> {
        self.previews.1.try_iter().collect()
    }

    /// The files that were read since the last call, with what each replaces; none that was given up.
    pub(super) fn finished(&mut self) -> Vec<(Loaded, Option<u32>)> {
        let mut finished = Vec::new();
        while let Ok(loaded) = self.receiver.try_recv() {
            self.sort(loaded, &mut finished);
        }
        finished
    }

    /// What turned out about the frames of trajectories since the last call.
    pub(super) fn problems(&mut self) -> Vec<String> {
        std::mem::take(&mut *self.problems.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Waits until all is read.
    pub(super) fn wait(&mut self) -> Vec<(Loaded, Option<u32>)> {
        let mut finished = Vec::new();
        while !self.under_way.is_empty() {
            match self.receiver.recv() {
                Ok(loaded) => self.sort(loaded, &mut finished),
                Err(_) => break,
            }
        }
        finished
    }

    fn sort(&mut self, loaded: Loaded, finished: &mut Vec<(Loaded, Option<u32>)>) {
        match self.under_way.iter().position(|load| load.id == loaded.load) {
            Some(index) => {
                let load = self.under_way.remove(index);
                finished.push((loaded, load.replaces));
            }
            // One that could not even start is told; one that was given up is not.
            None if loaded.result.is_err() && loaded.load + 1 == self.next => finished.push((loaded, None)),
            None => {
                // What is drawn of one that was given up is kept for nobody.
                if let Ok(document) = &loaded.result {
                    self.maker.forget(|other| !Arc::ptr_eq(other, document));
                }
            }
        }
    }
}

fn read(
    source: &Source,
    crystal: &CrystalOptions,
    maker: &Maker,
    stage: &AtomicU8,
    stop: &Stop,
) -> Result<Arc<Document>> {
    let options = ImportOptions { stop: stop.clone(), ..ImportOptions::default() };
    let document = match source {
        Source::File(input) => trajectory::read_input(input, &options)?,
        Source::Sample(_) => samples::read(&source.named(), &options)?,
    };
    let document = Arc::new(document);
    stage.store(Stage::Bonds as u8, Ordering::Relaxed);
    maker.drawn_unless(&document, 0, crystal, stop)?;
    Ok(document)
}

/// Finds all frames of trajectories; meanwhile those that are known can be looked at. Ends when nobody else has the document any more.
fn count_frames(document: &Arc<Document>, wake: &Waker, problems: &Mutex<Vec<String>>) {
    for trajectory in &document.trajectories {
        if trajectory.is_counted() {
            continue;
        }
        let mut told = Instant::now();
        let goes_on = || {
            if told.elapsed() > TELL_EVERY {
                told = Instant::now();
                wake();
            }
            Arc::strong_count(document) > 1
        };
        // Where the file cannot be read any more, the frame that is asked for says so.
        let _ = trajectory.count_frames(goes_on);
        if let Some(problem) = trajectory.problem() {
            let name = trajectory.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
            problems.lock().unwrap_or_else(PoisonError::into_inner).push(format!("{name}: {problem}"));
        }
        wake();
    }
}

/// A panic, which is a bug of ours, becomes an error: the window stays open.
pub(super) fn guarded<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|_| Err(Error::Unsupported("a bug in ballstick; please report it with the file".to_owned())))
}
