//! How pictures get to the window.
//!
//! With a real GPU the scene is drawn straight to the window's surface, one sample a frame until the picture is
//! finished. Without one the CPU renderer's pictures are copied there (softbuffer): coarse while something moves, finished
//! when it rests. If the GPU is lost the window goes on with the CPU and says so.

use super::Wake;
use super::model::Model;
use super::worker::{Job, Worker};
use crate::error::{Error, Result};
use crate::render::{Choice, Image, Settings};
use std::num::NonZeroU32;
use std::sync::Arc;
use winit::event_loop::EventLoopProxy;
use winit::window::Window;

/// What shows pictures in the window.
pub(super) struct Screen {
    kind: Kind,
    window: Arc<Window>,
    proxy: EventLoopProxy<Wake>,
    /// Counts changes of what is to be seen.
    version: u64,
    moving: bool,
}

enum Kind {
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuScreen>),
    Cpu(CpuScreen),
}

#[cfg(feature = "gpu")]
struct GpuScreen {
    renderer: crate::render::gpu::GpuRenderer,
    surface: crate::render::gpu::WindowSurface,
    /// Samples of the current version that are in the picture.
    done: u32,
    size_px: [u32; 2],
}

struct CpuScreen {
    surface: softbuffer::Surface<Arc<Window>, Arc<Window>>,
    worker: Worker,
    /// The version last posted, and whether its fine picture was.
    posted: (u64, bool),
    /// The picture on the screen.
    shown: Option<Image>,
    /// Pixels of a picture in motion are this many times larger when the machine cannot keep up.
    coarseness: u32,
}

/// Samples and ground texels of a picture in motion.
const IN_MOTION: Settings = Settings { samples: 1, ground_texels: 96, ao: 0, shadow: false };
/// A frame in motion that takes longer than this is made coarser next time, one under a quarter of it finer (seconds).
const SLOW_FRAME: f64 = 0.060;

impl Screen {
    pub(super) fn new(window: Arc<Window>, choice: Choice, proxy: EventLoopProxy<Wake>) -> Result<Screen> {
        let kind = match gpu_screen(&window, choice) {
            Ok(Some(kind)) => kind,
            Ok(None) => Kind::Cpu(CpuScreen::new(&window, &proxy)?),
            Err(error) if choice == Choice::Gpu => {
                eprintln!("ballstick: {error}; the CPU renderer draws instead");
                Kind::Cpu(CpuScreen::new(&window, &proxy)?)
            }
            Err(_) => Kind::Cpu(CpuScreen::new(&window, &proxy)?),
        };
        Ok(Screen { kind, window, proxy, version: 1, moving: false })
    }

    /// Notes that the picture is out of date; `moving` says that more changes are to be expected.
    pub(super) fn changed(&mut self, moving: bool) {
        self.version += 1;
        self.moving = moving;
        #[cfg(feature = "gpu")]
        if let Kind::Gpu(gpu) = &mut self.kind {
            gpu.done = 0;
        }
    }

    /// Brings the window up to date; whether it should be called again at once.
    pub(super) fn draw(&mut self, model: &Model, settings: &Settings) -> Result<bool> {
        match &mut self.kind {
            #[cfg(feature = "gpu")]
            Kind::Gpu(gpu) => match gpu.draw(model, settings, self.moving) {
                Ok(more) => Ok(more),
                Err(error) => {
                    eprintln!("ballstick: {error}; the CPU renderer takes over");
                    self.kind = Kind::Cpu(CpuScreen::new(&self.window, &self.proxy)?);
                    Ok(true)
                }
            },
            Kind::Cpu(cpu) => cpu.draw(model, settings, self.version).map(|()| false),
        }
    }
}

/// The GPU's screen if the choice allows one; `None` if the CPU is to draw.
#[cfg(feature = "gpu")]
fn gpu_screen(window: &Arc<Window>, choice: Choice) -> Result<Option<Kind>> {
    use crate::render::gpu::{AdapterWish, GpuRenderer};
    let wish = match choice {
        Choice::Cpu => return Ok(None),
        Choice::Auto => AdapterWish::Hardware,
        Choice::Gpu => AdapterWish::Any,
    };
    let size = window.inner_size();
    let size_px = [size.width.max(1), size.height.max(1)];
    let (renderer, surface) = GpuRenderer::for_window(Arc::clone(window), size_px, wish)?;
    Ok(Some(Kind::Gpu(Box::new(GpuScreen { renderer, surface, done: 0, size_px }))))
}

#[cfg(not(feature = "gpu"))]
fn gpu_screen(_window: &Arc<Window>, choice: Choice) -> Result<Option<Kind>> {
    match choice {
        Choice::Gpu => Err(Error::Unsupported("this build has no GPU renderer".to_owned())),
        Choice::Auto | Choice::Cpu => Ok(None),
    }
}

#[cfg(feature = "gpu")]
impl GpuScreen {
    fn draw(&mut self, model: &Model, settings: &Settings, moving: bool) -> Result<bool> {
        use crate::render::Renderer as _;
        let view = model.view();
        let size_px = [view.width, view.height];
        if size_px != self.size_px {
            self.renderer.resize(&mut self.surface, size_px);
            self.size_px = size_px;
            self.done = 0;
        }
        // In motion one sample and a coarse ground; at rest all samples of the finished picture.
        let settings = if moving { &IN_MOTION } else { settings };
        if self.done >= settings.samples && !moving {
            return Ok(false);
        }
        self.renderer.load(Arc::clone(model.scene()))?;
        self.renderer.present(&mut self.surface, &view, settings, self.done.min(settings.samples - 1), 1)?;
        self.done += 1;
        Ok(!moving && self.done < settings.samples)
    }
}

impl CpuScreen {
    fn new(window: &Arc<Window>, proxy: &EventLoopProxy<Wake>) -> Result<CpuScreen> {
        let failed = |error: softbuffer::SoftBufferError| {
            Error::Unsupported(format!("the window takes no pictures: {error}; try: ballstick render"))
        };
        let context = softbuffer::Context::new(Arc::clone(window)).map_err(failed)?;
        let surface = softbuffer::Surface::new(&context, Arc::clone(window)).map_err(failed)?;
        let proxy = proxy.clone();
        let notify = move || {
            // The loop is gone only when the window is closing.
            let _ = proxy.send_event(Wake::Frame);
        };
        let worker = Worker::start(notify)
            .ok_or_else(|| Error::Unsupported("the system gives no thread to draw on".to_owned()))?;
        Ok(CpuScreen { surface, worker, posted: (0, false), shown: None, coarseness: 1 })
    }

    fn draw(&mut self, model: &Model, settings: &Settings, version: u64) -> Result<()> {
        let view = model.view();
        let mut fine_next = false;
        if let Some(frame) = self.worker.take_frame() {
            if !frame.fine {
                self.coarseness = match frame.seconds {
                    slow if slow > SLOW_FRAME => (self.coarseness + 1).min(4),
                    fast if fast < SLOW_FRAME * 0.25 => (self.coarseness - 1).max(1),
                    _ => self.coarseness,
                };
            }
            fine_next = frame.version == version && !frame.fine;
            self.shown = Some(frame.image);
        }
        let job = |settings: Settings, may_stop, view| Job {
            scene: Arc::clone(model.scene()),
            view,
            settings,
            may_stop,
            version,
        };
        if self.posted.0 != version {
            let coarse = (view.width / self.coarseness, view.height / self.coarseness);
            let view = crate::render::View::new(view.camera, coarse.0, coarse.1);
            self.worker.post(job(IN_MOTION, false, view));
            self.posted = (version, false);
        } else if fine_next && !self.posted.1 {
            self.worker.post(job(*settings, true, view));
            self.posted = (version, true);
        }
        self.show([view.width, view.height])
    }

    /// Copies the picture to the window, each pixel as large as it takes to fill it.
    fn show(&mut self, [width, height]: [u32; 2]) -> Result<()> {
        let failed = |error: softbuffer::SoftBufferError| {
            Error::Unsupported(format!("the window takes no more pictures: {error}"))
        };
        let (Some(w), Some(h)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else { return Ok(()) };
        self.surface.resize(w, h).map_err(failed)?;
        let mut pixels = self.surface.buffer_mut().map_err(failed)?;
        match &self.shown {
            None => pixels.fill(0x00FF_FFFF),
            Some(image) => copy(image, &mut pixels, [width, height]),
        }
        pixels.present().map_err(failed)
    }
}

/// Nearest pixels of the picture as `0x00RRGGBB`, laid on white where it is transparent.
fn copy(image: &Image, pixels: &mut [u32], [width, height]: [u32; 2]) {
    let from = |to: u32, to_size: u32, from_size: u32| u64::from(to) * u64::from(from_size) / u64::from(to_size);
    let columns: Vec<usize> = (0..width).map(|x| from(x, width, image.width) as usize * 4).collect();
    for (y, row) in pixels.chunks_exact_mut(width as usize).enumerate() {
        let start = from(y as u32, height, image.height) as usize * image.width as usize * 4;
        let line = &image.rgba[start..start + image.width as usize * 4];
        for (pixel, &column) in row.iter_mut().zip(&columns) {
            let [r, g, b, a] = [line[column], line[column + 1], line[column + 2], line[column + 3]].map(u32::from);
            let on_white = |c: u32| (c * a + 255 * (255 - a) + 127) / 255;
            *pixel = on_white(r) << 16 | on_white(g) << 8 | on_white(b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_fill_the_window_whatever_their_size() {
        let image = Image { width: 2, height: 1, rgba: vec![255, 0, 0, 255, 0, 0, 255, 0] };
        let mut pixels = vec![0; 8];
        copy(&image, &mut pixels, [4, 2]);
        assert_eq!(pixels[..4], [0xFF_00_00, 0xFF_00_00, 0xFF_FF_FF, 0xFF_FF_FF]);
        assert_eq!(pixels[..4], pixels[4..]);
    }
}
