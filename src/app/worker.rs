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
    /// How many times larger than the window's its pixels are.
    pub(super) coarseness: f32,
    /// Whether a newer job may stop it half-way.
    pub(super) may_stop: bool,
    /// Counts changes of the view; a frame says which one it shows.
    pub(super) version: u64,
    /// When it was asked for.
    pub(super) posted: Instant,
}

/// A finished picture, as the window shows it.
pub(super) struct Frame {
    image: Image,
    size: [u32; 2],
    /// Where the picture has the pixels of a row of the window, if it is not as wide.
    columns: Option<Vec<usize>>,
    /// That of its job.
    pub(super) coarseness: f32,
    pub(super) version: u64,
    /// Whether it was the fine one.
    pub(super) fine: bool,
    /// When it was asked for, begun, and finished.
    pub(super) posted: Instant,
    pub(super) begun: Instant,
    pub(super) drawn: Instant,
}

/// The nearest of `from_size` pixels to one of `to_size`.
fn nearest(to: u32, to_size: u32, from_size: u32) -> usize {
    (u64::from(to) * u64::from(from_size) / u64::from(to_size.max(1))) as usize
}

/// A pixel of the window, `0x00RRGGBB`, on white where the picture is transparent.
fn on_white([r, g, b, a]: [u8; 4]) -> u32 {
    if a == 0xFF {
        return u32::from_be_bytes([0, r, g, b]);
    }
    let on_white = |c: u8| (u32::from(c) * u32::from(a) + 255 * (255 - u32::from(a)) + 127) / 255;
    on_white(r) << 16 | on_white(g) << 8 | on_white(b)
}

impl Frame {
    fn new(image: Image, job: &Job, begun: Instant) -> Frame {
        let [width, _] = job.size;
        let columns = (image.width != width).then(|| (0..width).map(|x| nearest(x, width, image.width)).collect());
        let (size, coarseness, version, fine) = (job.size, job.coarseness, job.version, job.may_stop);
        Frame { image, size, columns, coarseness, version, fine, posted: job.posted, begun, drawn: Instant::now() }
    }

    /// How wide it is shown, pixels of the window.
    pub(super) fn width(&self) -> usize {
        self.size[0] as usize
    }

    /// Writes row `y` of the window's pixels, from column `x` on, as far as `pixels` go; false below the picture. `x` and what is written must lie
    /// within its width.
    pub(super) fn copy_row(&self, y: usize, x: usize, pixels: &mut [u32]) -> bool {
        let Some(y) = u32::try_from(y).ok().filter(|&y| y < self.size[1]) else { return false };
        let width = self.image.width as usize;
        let start = nearest(y, self.size[1], self.image.height) * width;
        let texels: &[[u8; 4]] = bytemuck::cast_slice(&self.image.rgba);
        let Some(line) = texels.get(start..start + width) else { return false };
        match &self.columns {
            None => {
                let Some(line) = line.get(x..x + pixels.len()) else { return false };
                // Nearly all pictures are opaque: then this is a turning of bytes, many pixels at once.
                let mut all = u32::MAX;
                for (pixel, &texel) in pixels.iter_mut().zip(line) {
                    let abgr = u32::from_le_bytes(texel);
                    *pixel = (abgr & 0xFF) << 16 | abgr & 0xFF00 | abgr >> 16 & 0xFF;
                    all &= abgr;
                }
                if all >> 24 != 0xFF {
                    pixels.iter_mut().zip(line).for_each(|(pixel, &texel)| *pixel = on_white(texel));
                }
            }
            Some(columns) => {
                let Some(columns) = columns.get(x..x + pixels.len()) else { return false };
                for (pixel, &column) in pixels.iter_mut().zip(columns) {
                    *pixel = line.get(column).map_or(0, |&texel| on_white(texel));
                }
            }
        }
        true
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
    /// When the picture in motion was begun that is being drawn.
    begun: Option<Instant>,
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

    /// When the picture in motion was begun that is being drawn, as long as no other one waits for it.
    pub(super) fn moving_since(&self) -> Option<Instant> {
        let state = lock(&self.shared);
        state.begun.filter(|_| state.job.is_none())
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
                    state.begun = (!job.may_stop).then(Instant::now);
                    break job;
                }
                state = shared.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let begun = Instant::now();
        if renderer.load(Arc::clone(&job.scene)).is_err() {
            lock(shared).begun = None;
            continue;
        }
        let never = AtomicBool::new(false);
        let stop = if job.may_stop { &shared.stop } else { &never };
        let Some(image) = renderer.image_unless(&job.view, &job.settings, stop) else { continue };
        let frame = Frame::new(image, &job, begun);
        let mut state = lock(shared);
        // What was not taken is dropped by this thread, which has the time.
        let missed = state.frame.replace(frame);
        state.begun = None;
        drop(state);
        drop(missed);
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
        let settings = Settings { samples, ground_texels: 16, ao: 0, shadow: false };
        Job { scene, view, size: [64, 64], settings, coarseness: 1.0, may_stop, version, posted: Instant::now() }
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
                let mut row = [1; 64];
                assert!(frame.fine && frame.copy_row(63, 0, &mut row) && !frame.copy_row(64, 0, &mut row));
                assert!(!frame.copy_row(0, 1, &mut row), "a row ends where the picture does");
            }
        }
        assert!(worker.take_frame().is_none());
    }

    #[test]
    fn pictures_fill_the_window_whatever_their_size() {
        let image = Image { width: 2, height: 1, rgba: vec![255, 0, 0, 255, 0, 0, 255, 0] };
        let rows = |size: [u32; 2]| -> Vec<Vec<u32>> {
            let frame = Frame::new(image.clone(), &Job { size, ..job(1, true, 1) }, Instant::now());
            let row = |y: u32| {
                let mut row = vec![0; size[0] as usize];
                assert!(frame.copy_row(y as usize, 0, &mut row));
                row
            };
            (0..size[1]).map(row).collect()
        };
        let [red, white] = [0xFF_00_00, 0xFF_FF_FF];
        assert_eq!(rows([4, 2]), [[red, red, white, white], [red, red, white, white]]);
        assert_eq!(rows([2, 1]), [[red, white]]);
        let frame = Frame::new(image.clone(), &Job { size: [2, 1], ..job(1, true, 1) }, Instant::now());
        let mut last = [0];
        assert!(frame.copy_row(0, 1, &mut last) && last == [white]);
    }
}
