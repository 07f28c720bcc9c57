//! The CPU renderer on a thread of its own.
//!
//! The window posts what it wants drawn; the worker always takes the newest wish, and drops a fine picture half-way when
//! a new one comes. A coarse picture in motion is always finished, so that something moves on the screen.

use crate::render::cpu::CpuRenderer;
use crate::render::{Image, Renderer, Settings, View};
use crate::scene::Scene;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// A picture to draw.
#[derive(Clone)]
pub(super) struct Job {
    pub(super) scene: Arc<Scene>,
    pub(super) view: View,
    pub(super) settings: Settings,
    /// Whether a newer job may stop it half-way.
    pub(super) may_stop: bool,
    /// Counts changes of the view; a frame says which one it shows.
    pub(super) version: u64,
}

/// A finished picture.
pub(super) struct Frame {
    pub(super) image: Image,
    pub(super) version: u64,
    /// Whether it was the fine one.
    pub(super) fine: bool,
    /// Seconds it took.
    pub(super) seconds: f64,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    wake: Condvar,
    stop: AtomicBool,
}

#[derive(Default)]
struct State {
    job: Option<Job>,
    frame: Option<Frame>,
    closing: bool,
}

/// The thread and what it shares with the window.
pub(super) struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// A panic of the other side leaves plain data behind, which is still good.
fn lock(shared: &Shared) -> MutexGuard<'_, State> {
    shared.state.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Worker {
    /// Starts the thread; `notify` is called from it when a frame is ready. `None` if the system gives no thread.
    pub(super) fn start(notify: impl Fn() + Send + 'static) -> Option<Worker> {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("draw".to_owned()).spawn(move || run(&theirs, &notify)).ok()?;
        Some(Worker { shared, thread: Some(thread) })
    }

    /// Asks for a picture in place of any that waits.
    pub(super) fn post(&self, job: Job) {
        let mut state = lock(&self.shared);
        state.job = Some(job);
        // Under the lock: the worker clears it when it takes the job, and must not be stopped by the wish it is serving.
        self.shared.stop.store(true, Ordering::Relaxed);
        self.shared.wake.notify_one();
    }

    /// The newest finished picture, once.
    pub(super) fn take_frame(&self) -> Option<Frame> {
        lock(&self.shared).frame.take()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        lock(&self.shared).closing = true;
        self.shared.stop.store(true, Ordering::Relaxed);
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            // The thread ends with what it draws now; its result is of no interest.
            let _ = thread.join();
        }
    }
}

fn run(shared: &Shared, notify: &dyn Fn()) {
    let mut renderer = CpuRenderer::new();
    loop {
        let job = {
            let mut state = lock(shared);
            loop {
                if state.closing {
                    return;
                }
                if let Some(job) = state.job.take() {
                    shared.stop.store(false, Ordering::Relaxed);
                    break job;
                }
                state = shared.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let started = std::time::Instant::now();
        if renderer.load(Arc::clone(&job.scene)).is_err() {
            continue;
        }
        let never = AtomicBool::new(false);
        let stop = if job.may_stop { &shared.stop } else { &never };
        let Some(image) = renderer.image_unless(&job.view, &job.settings, stop) else { continue };
        let seconds = started.elapsed().as_secs_f64();
        lock(shared).frame = Some(Frame { image, version: job.version, fine: job.may_stop, seconds });
        notify();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;
    use std::time::Duration;

    fn job(version: u64, may_stop: bool, samples: u32) -> Job {
        let scene = Arc::new(Scene::from_blocks(Vec::new(), Vec::new()));
        let view = View::new(scene.fitted_camera(1.0), 64, 64);
        Job { scene, view, settings: Settings { samples, ground_texels: 16, ao: 0, shadow: false }, may_stop, version }
    }

    #[test]
    fn frames_come_back_with_their_version_and_the_newest_wish_wins() {
        let (sender, receiver) = mpsc::channel();
        let worker = Worker::start(move || {
            let _ = sender.send(());
        })
        .unwrap();
        for version in 1..=5 {
            worker.post(job(version, true, 4));
        }
        let mut last = 0;
        while last < 5 {
            receiver.recv_timeout(Duration::from_secs(20)).unwrap();
            if let Some(frame) = worker.take_frame() {
                assert!(frame.version > last, "frames never go back");
                last = frame.version;
                assert_eq!((frame.image.width, frame.fine), (64, true));
            }
        }
        assert!(worker.take_frame().is_none());
    }
}
