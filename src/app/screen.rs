//! How the picture and the interface over it get to the window.
//!
//! With a real GPU the scene is drawn straight to the window's surface, one sample a frame until the picture is finished, and the
//! interface over it. Without one the CPU renderer's pictures are copied there (softbuffer): coarse while something moves, finished
//! when it rests; the interface is painted over them, and only what changed is touched. If the GPU is lost the window goes on with the CPU
//! and says so.

use super::build::Waker;
use super::pace::Pace;
use super::paint::{Canvas, Painter, PxRect, pixel_of};
use super::state::State;
use super::timings::{Stage, Timings};
use super::worker::{Frame, Job, Worker};
use crate::error::{Error, Result};
use crate::render::{Choice, Settings, View};
use egui::TexturesDelta;
use egui::epaint::ClippedPrimitive;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::window::Window;

/// What egui wants to be seen.
#[derive(Default)]
pub(super) struct Interface {
    /// What of textures is new to a device.
    textures: TexturesDelta,
    /// Has all textures whoever draws: if a device is lost, egui does not send them again.
    painter: Painter,
    pub(super) primitives: Vec<ClippedPrimitive>,
    /// Pixels a point.
    pub(super) scale: f32,
    /// Where the molecule is, in points.
    view: Option<egui::Rect>,
    /// Whether all of the window is to be painted anew.
    all: bool,
}

impl Interface {
    /// Takes what is to be seen from now on.
    pub(super) fn set(
        &mut self,
        textures: TexturesDelta,
        primitives: Vec<ClippedPrimitive>,
        scale: f32,
        view: egui::Rect,
    ) {
        self.painter.update(&mut textures.clone());
        self.textures.append(textures);
        (self.primitives, self.scale) = (primitives, scale);
        self.view = view.is_positive().then_some(view);
    }

    /// Lets go of what nobody has taken.
    pub(super) fn close(&mut self) {
        self.textures.clear();
    }

    /// Forgets what is on the screen.
    pub(super) fn forget(&mut self) {
        self.all = true;
    }

    /// Where the molecule is in a window of this size, in pixels.
    fn view_px(&self, size: [u32; 2]) -> PxRect {
        let size = size.map(|side| side as usize);
        let whole = PxRect { left: 0, top: 0, right: size[0], bottom: size[1] };
        self.view.and_then(|view| PxRect::of(view, self.scale, size).cut(whole)).unwrap_or(whole)
    }

    /// How large that is.
    pub(super) fn view_size(&self, size: [u32; 2]) -> [u32; 2] {
        let rect = self.view_px(size);
        [rect.right - rect.left, rect.bottom - rect.top].map(|side| u32::try_from(side).unwrap_or(u32::MAX))
    }
}

/// What shows pictures in the window.
pub(super) struct Screen {
    kind: Kind,
    window: Arc<Window>,
    #[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "for the CPU when a GPU is lost"))]
    wake: Waker,
    notice: Option<String>,
}

enum Kind {
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuScreen>),
    Cpu(Box<CpuScreen>),
}

#[cfg(feature = "gpu")]
struct GpuScreen {
    renderer: crate::render::gpu::GpuRenderer,
    surface: crate::render::gpu::WindowSurface,
    /// Samples of a version that are in the picture.
    done: (u64, u32),
    size_px: [u32; 2],
    /// Pictures until a test has the device destroyed.
    lose_in: Option<u32>,
    /// Pictures until a test has its memory used up.
    exhaust_in: Option<u32>,
}

/// The variable by which tests have the device destroyed before a picture of this number: what a driver that is reset does to a window.
#[cfg(feature = "gpu")]
const LOSE_DEVICE: &str = "BALLSTICK_LOSE_DEVICE";

/// The same for a device that is out of memory.
#[cfg(feature = "gpu")]
const EXHAUST_DEVICE: &str = "BALLSTICK_EXHAUST_DEVICE";

struct CpuScreen {
    surface: softbuffer::Surface<Arc<Window>, Arc<Window>>,
    worker: Worker,
    /// The version last posted, and whether its fine picture was.
    posted: (u64, bool),
    /// The picture in motion that was posted last, until it has come.
    awaited: Option<u64>,
    /// How long the last picture in motion took.
    took: Duration,
    /// The version whose coarse picture is on the screen.
    coarse: u64,
    /// The picture on the screen.
    shown: Option<Frame>,
    /// Whether it is not on the screen yet.
    has_new: bool,
    /// The size of the window when it was last painted.
    size_px: [u32; 2],
    /// What was painted in the last frame, for buffers that are two frames old.
    last_damage: Vec<PxRect>,
    /// How coarse pictures in motion are.
    pace: Pace,
}

/// Samples and ground texels of a picture in motion. The light turns with the camera, so that the ground's map is made anew in each: with 96 texels
/// an orbit about 10,000 atoms took half as long again, and beside each other the two shadows are hard to tell apart.
const IN_MOTION: Settings = Settings { samples: 1, ground_texels: 48, ao: 0, shadow: false };
/// The mouse is looked at so often while it is not known when a picture will be finished.
const IN_BETWEEN: Duration = Duration::from_millis(4);

impl Screen {
    /// A screen, and what there is to say of it.
    pub(super) fn new(window: Arc<Window>, choice: Choice, wake: Waker) -> Result<(Screen, Option<String>)> {
        let (kind, notice) = match gpu_screen(&window, choice) {
            Ok(Some(kind)) => (kind, None),
            Err(error) if choice == Choice::Gpu => {
                (cpu_kind(&window, &wake)?, Some(format!("{error}; the CPU renderer draws instead")))
            }
            Ok(None) | Err(_) => (cpu_kind(&window, &wake)?, None),
        };
        Ok((Screen { kind, window, wake, notice: None }, notice))
    }

    /// As long as a picture in motion is on its way: when to ask for the next one. That is `lead` before it will be finished: so the next begins at
    /// once, and shows the newest there is.
    pub(super) fn next_wish(&self, lead: Duration) -> Option<Instant> {
        match &self.kind {
            #[cfg(feature = "gpu")]
            Kind::Gpu(_) => None,
            Kind::Cpu(cpu) => cpu.next_wish(lead),
        }
    }

    /// Takes what was drawn meanwhile.
    pub(super) fn collect(&mut self, timings: &mut Timings) {
        match &mut self.kind {
            #[cfg(feature = "gpu")]
            Kind::Gpu(_) => {}
            Kind::Cpu(cpu) => cpu.collect(timings),
        }
    }

    /// What happened to the screen, once.
    pub(super) fn take_notice(&mut self) -> Option<String> {
        self.notice.take()
    }

    /// Brings the window up to date; whether it should be called again at once.
    pub(super) fn draw(&mut self, state: &State, interface: &mut Interface, timings: &mut Timings) -> Result<bool> {
        let size = self.window.inner_size();
        let size = [size.width, size.height];
        match &mut self.kind {
            #[cfg(feature = "gpu")]
            Kind::Gpu(gpu) => match gpu.draw(state, interface, size, timings) {
                Ok(more) => Ok(more),
                Err(error) => {
                    self.notice = Some(format!("{error}; the CPU renderer takes over"));
                    self.kind = cpu_kind(&self.window, &self.wake)?;
                    interface.forget();
                    Ok(true)
                }
            },
            Kind::Cpu(cpu) => {
                timings.drawn_by("cpu");
                cpu.draw(state, interface, size, timings).map(|()| false)
            }
        }
    }
}

fn cpu_kind(window: &Arc<Window>, wake: &Waker) -> Result<Kind> {
    Ok(Kind::Cpu(Box::new(CpuScreen::new(window, wake)?)))
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
    let [lose_in, exhaust_in] =
        [LOSE_DEVICE, EXHAUST_DEVICE].map(|name| std::env::var(name).ok().and_then(|number| number.parse().ok()));
    Ok(Some(Kind::Gpu(Box::new(GpuScreen { renderer, surface, done: (0, 0), size_px, lose_in, exhaust_in }))))
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
    fn draw(
        &mut self,
        state: &State,
        interface: &mut Interface,
        size_px: [u32; 2],
        timings: &mut Timings,
    ) -> Result<bool> {
        use crate::render::Renderer as _;
        use crate::render::gpu::UserInterface;
        let began = Instant::now();
        self.lose_in = self.lose_in.map(|pictures| pictures.saturating_sub(1));
        if self.lose_in == Some(0) {
            self.renderer.lose_device();
        }
        self.exhaust_in = self.exhaust_in.map(|pictures| pictures.saturating_sub(1));
        if self.exhaust_in == Some(0) {
            self.renderer.exhaust_device();
        }
        let size_px = size_px.map(|side| side.max(1));
        if size_px != self.size_px {
            self.renderer.resize(&mut self.surface, size_px);
            (self.size_px, self.done) = (size_px, (0, 0));
        }
        if self.done.0 != state.version {
            self.done = (state.version, 0);
        }
        let fine = state.fine(state.work.quality);
        let samples = fine.samples;
        let is_at_rest = state.until_rest(Instant::now()).is_some_and(|rest| rest.is_zero());
        // First one sample in motion: coarse ground, no light from afar. At rest the sum begins anew with fine ones.
        let (settings, done, add) = match self.done.1 {
            0 => (&IN_MOTION, 0, 1),
            1 if !is_at_rest => (&IN_MOTION, 1, 0),
            count if is_at_rest && count <= samples => (&fine, count - 1, 1),
            count => (&fine, count - 1, 0),
        };
        let place = interface.view_px(size_px);
        let over = UserInterface {
            textures: std::mem::take(&mut interface.textures),
            primitives: &interface.primitives,
            pixels_per_point: interface.scale,
            place: [place.left, place.top].map(|side| side as u32),
        };
        self.renderer.load(Arc::clone(&state.built.scene))?;
        self.renderer.present(&mut self.surface, &state.view(), settings, done, add, over)?;
        self.done.1 += add;
        timings.spent(Stage::Present, began.elapsed());
        timings.drawn_by("gpu");
        timings.presented((add > 0).then_some((state.version, is_at_rest)));
        Ok(is_at_rest && self.done.1 <= samples)
    }
}

impl CpuScreen {
    fn new(window: &Arc<Window>, wake: &Waker) -> Result<CpuScreen> {
        let failed = |error: softbuffer::SoftBufferError| {
            Error::Unsupported(format!("the window takes no pictures: {error}; try: ballstick render"))
        };
        let context = softbuffer::Context::new(Arc::clone(window)).map_err(failed)?;
        let surface = softbuffer::Surface::new(&context, Arc::clone(window)).map_err(failed)?;
        let wake = Arc::clone(wake);
        let worker = Worker::start(move || wake())
            .ok_or_else(|| Error::Unsupported("the system gives no thread to draw on".to_owned()))?;
        Ok(CpuScreen {
            surface,
            worker,
            posted: (0, false),
            awaited: None,
            took: Duration::ZERO,
            has_new: false,
            coarse: 0,
            shown: None,
            size_px: [0; 2],
            last_damage: Vec::new(),
            pace: Pace::default(),
        })
    }

    fn draw(&mut self, state: &State, interface: &mut Interface, size: [u32; 2], timings: &mut Timings) -> Result<()> {
        self.collect(timings);
        self.wish(state);
        self.paint(interface, size, state, timings)
    }

    fn next_wish(&self, lead: Duration) -> Option<Instant> {
        self.awaited?;
        // Until a finished picture is given up that is being drawn, or while the next one has been asked for already.
        let soon = || Instant::now() + IN_BETWEEN;
        Some(self.worker.moving_since().map_or_else(soon, |since| since + self.took.saturating_sub(lead)))
    }

    /// Takes a finished picture.
    fn collect(&mut self, timings: &mut Timings) {
        let Some(frame) = self.worker.take_frame() else { return };
        let took = frame.drawn - frame.begun;
        if frame.fine {
            timings.spent(Stage::Still, took);
        } else {
            timings.spent(Stage::Wait, frame.begun - frame.posted);
            timings.spent(Stage::Render, took);
            if frame.coarseness > 1.0 {
                timings.coarser();
            }
            timings.spent(Stage::Wake, frame.drawn.elapsed());
            self.took = took;
            self.pace.took(took.as_secs_f32(), frame.coarseness);
            self.coarse = frame.version;
            self.awaited = self.awaited.filter(|&version| version != frame.version);
        }
        self.has_new = true;
        self.shown = Some(frame);
    }

    /// Asks for the next picture.
    fn wish(&mut self, state: &State) {
        let view = state.view();
        let job = |settings: Settings, may_stop, drawn: View, coarseness: f32| Job {
            scene: Arc::clone(&state.built.scene),
            view: drawn,
            size: [view.width, view.height],
            settings,
            coarseness,
            may_stop,
            version: state.version,
            posted: Instant::now(),
        };
        if state.work.layers.is_empty() {
            // The start page covers it, and what is opened next must not begin with it.
            (self.shown, self.awaited) = (None, None);
            self.posted = (state.version, true);
        } else if self.posted.0 != state.version {
            let coarseness = self.pace.coarseness();
            let coarser = |number: u32| ((number as f32 / coarseness).round() as u32).max(1);
            // The light on the ground costs as its texels.
            let motion = Settings { ground_texels: coarser(IN_MOTION.ground_texels), ..IN_MOTION };
            let drawn = View::new(view.camera, coarser(view.width), coarser(view.height));
            self.worker.post(job(motion, false, drawn, coarseness));
            (self.posted, self.awaited) = ((state.version, false), Some(state.version));
        } else if !self.posted.1
            && self.coarse == state.version
            && state.until_rest(Instant::now()).is_some_and(|rest| rest.is_zero())
        {
            self.worker.post(job(state.fine(state.work.quality), true, view, 1.0));
            self.posted = (state.version, true);
        }
    }

    /// Paints what changed.
    fn paint(&mut self, interface: &mut Interface, size: [u32; 2], state: &State, timings: &mut Timings) -> Result<()> {
        let failed = |error: softbuffer::SoftBufferError| {
            Error::Unsupported(format!("the window takes no more pictures: {error}"))
        };
        let (Some(width), Some(height)) = (NonZeroU32::new(size[0]), NonZeroU32::new(size[1])) else { return Ok(()) };
        let canvas_size = size.map(|side| side as usize);
        let whole = PxRect { left: 0, top: 0, right: canvas_size[0], bottom: canvas_size[1] };
        let place = interface.view_px(size);
        interface.textures.clear();
        let mut damage = interface.painter.damage(&interface.primitives, interface.scale, canvas_size);
        let has_new = std::mem::take(&mut self.has_new);
        if has_new {
            place.add_to(&mut damage);
        }
        let is_new_size = std::mem::replace(&mut self.size_px, size) != size;
        if std::mem::take(&mut interface.all) || is_new_size {
            damage = vec![whole];
        }
        if damage.is_empty() {
            return Ok(());
        }
        let began = Instant::now();
        self.surface.resize(width, height).map_err(failed)?;
        let mut buffer = self.surface.buffer_mut().map_err(failed)?;
        let ready = Instant::now();
        let mut stale = damage.clone();
        match buffer.age() {
            1 => {}
            2 => self.last_damage.iter().for_each(|rect| rect.add_to(&mut stale)),
            _ => stale = vec![whole],
        }
        let behind = match state.work.scene.background {
            crate::scene::Background::Color(color) => pixel_of(egui::Color32::from_rgb(color.r, color.g, color.b)),
            crate::scene::Background::Transparent => 0x00FF_FFFF,
        };
        let mut canvas = Canvas { pixels: &mut buffer, size: canvas_size };
        for &rect in &stale {
            let Some(rect) = rect.cut(whole) else { continue };
            background(&mut canvas, rect, place, self.shown.as_ref(), behind);
            interface.painter.paint(&mut canvas, rect, &interface.primitives, interface.scale);
        }
        let px = |x: usize| u32::try_from(x).unwrap_or(u32::MAX);
        let rect_of = |rect: &PxRect| {
            let rect = rect.cut(whole)?;
            let width = NonZeroU32::new(px(rect.right - rect.left))?;
            let height = NonZeroU32::new(px(rect.bottom - rect.top))?;
            Some(softbuffer::Rect { x: px(rect.left), y: px(rect.top), width, height })
        };
        let rects: Vec<softbuffer::Rect> = stale.iter().filter_map(rect_of).collect();
        self.last_damage = damage;
        let painted = Instant::now();
        buffer.present_with_damage(&rects).map_err(failed)?;
        timings.spent(Stage::Paint, painted - ready);
        timings.spent(Stage::Present, painted.elapsed() + (ready - began));
        let picture = self.shown.as_ref().filter(|_| has_new);
        timings.presented(picture.map(|frame| (frame.version, frame.fine)));
        Ok(())
    }
}

/// Puts the picture behind the interface, and one colour where it is not (yet).
fn background(canvas: &mut Canvas<'_>, rect: PxRect, place: PxRect, shown: Option<&Frame>, color: u32) {
    let width = canvas.size[0];
    for y in rect.top..rect.bottom {
        let row = &mut canvas.pixels[y * width + rect.left..y * width + rect.right];
        let (Some(frame), Some(line)) = (shown, y.checked_sub(place.top)) else {
            row.fill(color);
            continue;
        };
        // The row's part in the picture's place; what of the picture is left of it.
        let (start, end) = (rect.left.max(place.left), rect.right.min(place.right).min(place.left + frame.width()));
        if start >= end || !frame.copy_row(line, start - place.left, &mut row[start - rect.left..end - rect.left]) {
            row.fill(color);
            continue;
        }
        row[..start - rect.left].fill(color);
        row[end - rect.left..].fill(color);
    }
}
