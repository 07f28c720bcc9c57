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
use std::time::Instant;

/// A picture to draw.
#[derive(Clone)]
pub(super) struct Job {
    pub(super) scene: Arc<Scene>,
    pub(super) view: View,
    /// The size in which it is shown; its pixels are made as large as it takes to fill it.
    pub(super) size: [u32; 2],
    pub(super) settings: Settings,
    /// Whether a newer job may stop it half-way.
    pub(super) may_stop: bool,
    /// Counts changes of the view; a frame says which one it shows.
    pub(super) version: u64,
    /// When it was asked for.
    pub(super) posted: Instant,
}

/// A finished picture, as the window shows it.
pub(super) struct Frame {
    /// `0x00RRGGBB`, laid on white where it is transparent.
    pixels: Vec<u32>,
    size: [u32; 2],
    pub(super) version: u64,
    /// Whether it was the fine one.
    pub(super) fine: bool,
    /// When it was asked for, begun, and finished.
    pub(super) posted: Instant,
    pub(super) begun: Instant,
    pub(super) drawn: Instant,
}

impl Frame {
    /// A row of pixels.
    pub(super) fn row(&self, y: usize) -> Option<&[u32]> {
        let width = self.size[0] as usize;
        self.pixels.get(y * width..(y + 1) * width)
    }
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
        let begun = Instant::now();
        if renderer.load(Arc::clone(&job.scene)).is_err() {
            continue;
        }
        let never = AtomicBool::new(false);
        let stop = if job.may_stop { &shared.stop } else { &never };
        let Some(image) = renderer.image_unless(&job.view, &job.settings, stop) else { continue };
        let drawn = Instant::now();
        let pixels = shown(&image, job.size);
        let Job { size, version, may_stop: fine, posted, .. } = job;
        lock(shared).frame = Some(Frame { pixels, size, version, fine, posted, begun, drawn });
        notify();
    }
}

/// The nearest pixels of a picture, on white where it is transparent.
fn shown(image: &Image, [width, height]: [u32; 2]) -> Vec<u32> {
    let from = |to: u32, to_size: u32, from_size: u32| u64::from(to) * u64::from(from_size) / u64::from(to_size);
    let columns: Vec<usize> = (0..width).map(|x| from(x, width, image.width) as usize * 4).collect();
    let is_same = [image.width, image.height] == [width, height];
    let pixel = |texel: &[u8]| {
        let [r, g, b, a] = [texel[0], texel[1], texel[2], texel[3]].map(u32::from);
        let on_white = |c: u32| (c * a + 255 * (255 - a) + 127) / 255;
        if a == 255 { r << 16 | g << 8 | b } else { on_white(r) << 16 | on_white(g) << 8 | on_white(b) }
    };
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        let start = from(y, height, image.height) as usize * image.width as usize * 4;
        let line = &image.rgba[start..start + image.width as usize * 4];
        if is_same {
            pixels.extend(line.chunks_exact(4).map(pixel));
        } else {
            pixels.extend(columns.iter().map(|&column| pixel(&line[column..column + 4])));
        }
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;
    use std::time::Duration;

    fn job(version: u64, may_stop: bool, samples: u32) -> Job {
        let scene = Arc::new(Scene::from_blocks(Vec::new(), Vec::new()));
        let view = View::new(scene.fitted_camera(1.0), 64, 64);
        let settings = Settings { samples, ground_texels: 16, ao: 0, shadow: false };
        Job { scene, view, size: [64, 64], settings, may_stop, version, posted: Instant::now() }
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
                assert_eq!((frame.row(63).map(<[u32]>::len), frame.fine), (Some(64), true));
                assert!(frame.row(64).is_none());
            }
        }
        assert!(worker.take_frame().is_none());
    }

    #[test]
    fn pictures_fill_the_window_whatever_their_size() {
        let image = Image { width: 2, height: 1, rgba: vec![255, 0, 0, 255, 0, 0, 255, 0] };
        let pixels = shown(&image, [4, 2]);
        assert_eq!(pixels[..4], [0xFF_00_00, 0xFF_00_00, 0xFF_FF_FF, 0xFF_FF_FF]);
        assert_eq!(pixels[..4], pixels[4..]);
        assert_eq!(shown(&image, [2, 1]), [0xFF_00_00, 0xFF_FF_FF]);
    }
}
