//! The system's window: its events to egui and the state, what they give to the screen.

use super::action::Action;
use super::build::Waker;
use super::clipboard::Clipboard;
use super::files::Dialogs;
use super::preferences::Preferences;
use super::screen::{Interface, Screen};
use super::state::{Request, State};
use super::timings::{Stage, Timings};
use super::{Ended, Options, ui, watch};
use crate::error::{Error, Result};
use crate::import::trajectory::{inputs, is_trajectory};
use crate::session::Session;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

/// What other threads tell the event loop.
#[derive(Debug)]
pub(super) enum Wake {
    /// A picture, a file or a scene is finished.
    Work,
    /// A screen reader asks.
    Access(egui_winit::accesskit_winit::Event),
}

impl From<egui_winit::accesskit_winit::Event> for Wake {
    fn from(event: egui_winit::accesskit_winit::Event) -> Wake {
        Wake::Access(event)
    }
}

/// The bytes of a file; of a session those of the molecules it names.
fn bytes_of(file: &Path) -> u64 {
    let bytes = |path: &Path| std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    if !Session::is_at(file) {
        return bytes(file);
    }
    // One that cannot be read is said at once.
    let session = Session::read(file);
    session.map_or(0, |session| session.files.iter().map(|file| bytes(&file.path)).fold(0, u64::saturating_add))
}

/// Files of up to so many bytes in all are read before the window opens: they take less time than opening it (2 MB of PDB are 10 ms of
/// reading and 20 of bonds), and one that cannot be read is said on the terminal.
const BEFORE_OPENING: u64 = 2 << 20;

pub(super) fn run(files: Vec<PathBuf>, options: Options) -> Result<Ended> {
    // What winit says of it names its own source files; what helps is which display was tried.
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(|_| {
        let named = |name: &str| std::env::var_os(name).map(|value| format!("{name}={}", value.display()));
        let tried: Vec<String> = ["WAYLAND_DISPLAY", "DISPLAY"].into_iter().filter_map(named).collect();
        let why = if tried.is_empty() { "none is set".to_owned() } else { format!("{} gives none", tried.join(", ")) };
        let file = files.first().map_or(Path::new("FILE"), PathBuf::as_path).display();
        Error::Unsupported(format!(
            "there is no display to open a window on ({why}); to make a picture instead: ballstick render {file} -o picture.png"
        ))
    })?;
    let proxy = event_loop.create_proxy();
    let waker = proxy.clone();
    let wake: Waker = Arc::new(move || {
        // The loop is gone only when the window is closing.
        let _ = waker.send_event(Wake::Work);
    });
    let is_timed = options.timings;
    let mut state = State::new(options, Preferences::of_user(), Arc::clone(&wake));
    // Of trajectories one frame is read at first.
    let molecules = files.iter().filter(|file| !is_trajectory(file));
    let all_bytes = molecules.map(|file| bytes_of(file)).fold(0, u64::saturating_add);
    let is_small = all_bytes <= BEFORE_OPENING && !files.iter().any(|f| f == Path::new("-"));
    let is_some = !files.is_empty();
    let mut inputs = inputs(&files).into_iter();
    if let Some(document) = state.options.first.take()
        && let Some(input) = inputs.next()
    {
        state.take_first(input, document);
    }
    for input in inputs {
        state.apply(match input.trajectories.is_empty() {
            true => Action::Open(input.structure),
            false => Action::OpenInput(input),
        });
    }
    if is_small {
        state.wait_for_files();
    }
    let errors = |state: &State| -> Vec<String> {
        state.notices.iter().filter(|notice| notice.is_error).map(|notice| notice.text.clone()).collect()
    };
    let failures = errors(&state);
    // A session may still wait for its meshes.
    if is_small && is_some && state.work.layers.is_empty() && state.opening.is_none() {
        return Ok(Ended { failures, timings: None });
    }
    let egui_ctx = egui::Context::default();
    ui::theme::set_up(&egui_ctx);
    let mut app = App {
        dialogs: Dialogs::new(Arc::clone(&wake)),
        proxy,
        state,
        memory: ui::Memory::default(),
        egui_ctx,
        clipboard: Clipboard::default(),
        open: None,
        wake,
        next_frame: None,
        stale: true,
        took: Duration::ZERO,
        failure: None,
        first_event: None,
        timings: Timings::new(is_timed),
    };
    event_loop.set_control_flow(ControlFlow::Wait);
    event_loop.run_app(&mut app).map_err(|error| Error::Unsupported(format!("the window failed: {error}")))?;
    let timings = app.timings.line();
    app.failure.map_or(Ok(Ended { failures, timings }), Err)
}

/// What the next picture in motion shows is settled so long before the last one will be finished, beside what settling takes (chosen: by so much
/// drawing the same again varies).
const SPARE: Duration = Duration::from_millis(1);

/// What there is once the window is open.
struct Open {
    window: Arc<Window>,
    egui: egui_winit::State,
    screen: Screen,
    interface: Interface,
    title: String,
}

struct App {
    proxy: EventLoopProxy<Wake>,
    wake: Waker,
    state: State,
    memory: ui::Memory,
    egui_ctx: egui::Context,
    dialogs: Dialogs,
    clipboard: Clipboard,
    open: Option<Open>,
    /// When the interface wants to be shown anew by itself.
    next_frame: Option<Instant>,
    /// Whether the interface has to be shown anew, and not only the picture.
    stale: bool,
    /// How long showing it took last.
    took: Duration,
    failure: Option<Error>,
    /// When the first of the events came that the interface has not been shown.
    first_event: Option<Instant>,
    timings: Timings,
}

impl App {
    fn open_window(&mut self, event_loop: &ActiveEventLoop) -> Result<()> {
        let title = self.state.title();
        let attributes = Window::default_attributes()
            .with_title(title.clone())
            .with_inner_size(LogicalSize::new(1280.0, 800.0))
            .with_min_inner_size(LogicalSize::new(240.0, 180.0))
            // Screen readers must be told of the window before it is seen.
            .with_visible(false);
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| Error::Unsupported(format!("the system opens no window: {error}")))?;
        let window = Arc::new(window);
        let mut egui = egui_winit::State::new(
            self.egui_ctx.clone(),
            egui::ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            None,
        );
        egui.init_accesskit(event_loop, &window, self.proxy.clone());
        window.set_visible(true);
        let (screen, notice) = Screen::new(Arc::clone(&window), self.state.options.renderer, Arc::clone(&self.wake))?;
        if let Some(notice) = notice {
            self.state.complain(notice);
        }
        let interface = Interface::default();
        self.open = Some(Open { window, egui, screen, interface, title });
        Ok(())
    }

    /// Shows the interface anew and notes what it asks for.
    fn show_interface(&mut self, event_loop: &ActiveEventLoop) {
        let Some(open) = &mut self.open else { return };
        let (began, version) = (Instant::now(), self.state.version);
        let input = open.egui.take_egui_input(&open.window);
        let (state, memory) = (&mut self.state, &mut self.memory);
        state.poll();
        let mut next = state.play(Instant::now());
        let mut rect = egui::Rect::NOTHING;
        let output = self.egui_ctx.run_ui(input, |ui| rect = ui::show(ui, state, memory));
        open.egui.handle_platform_output(&open.window, output.platform_output);
        let scale = output.pixels_per_point;
        let size = open.window.inner_size();
        open.interface.set(output.textures_delta, self.egui_ctx.tessellate(output.shapes, scale), scale, rect);
        let [width, height] = open.interface.view_size([size.width, size.height]);
        self.state.set_view_px([width, height]);
        let delay = output.viewport_output.get(&egui::ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        if let Some(delay) = delay.filter(|delay| *delay < Duration::from_secs(3600)) {
            let delay = delay.as_secs_f64();
            next = Some(next.map_or(delay, |next| next.min(delay)));
        }
        if self.state.playing.on && next.is_none() {
            next = Some(0.0);
        }
        if let Some(rest) = self.state.until_rest(Instant::now()).filter(|rest| !rest.is_zero()) {
            next = Some(next.map_or(rest.as_secs_f64(), |next| next.min(rest.as_secs_f64())));
        }
        self.took = began.elapsed();
        self.next_frame = next.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
        let title = self.state.title();
        if title != open.title {
            open.window.set_title(&title);
            open.title = title;
        }
        if let Some(since) = self.first_event.take()
            && self.state.version != version
        {
            self.timings.awaits(self.state.version, since);
        }
        self.timings.spent(Stage::Interface, self.took);
        for request in std::mem::take(&mut self.state.requests) {
            match request {
                Request::Open => self.dialogs.open(),
                Request::Copy(text) => open.egui.set_clipboard_text(text),
                Request::CopyImage(image) => match self.clipboard.picture(&image) {
                    Ok(()) => self
                        .state
                        .say(format!("The picture is on the clipboard: {} × {} pixels.", image.width, image.height)),
                    Err(why) => self.state.complain(why),
                },
                Request::Quit => event_loop.exit(),
            }
        }
    }

    fn draw(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(open) = &mut self.open {
            open.screen.collect(&mut self.timings);
        }
        let is_due = self.next_frame.is_some_and(|at| at <= Instant::now());
        if std::mem::take(&mut self.stale) || is_due {
            self.show_interface(event_loop);
        }
        let Some(open) = &mut self.open else { return };
        match open.screen.draw(&self.state, &mut open.interface, &mut self.timings) {
            Ok(again) => {
                // What moves by itself in the interface moves with the pictures, and not more often.
                let wish = open.screen.next_wish(self.took + SPARE);
                self.next_frame = self.next_frame.map(|at| wish.map_or(at, |wish| at.max(wish)));
                if again {
                    open.window.request_redraw(); // the picture still gets better
                }
            }
            Err(error) => {
                self.failure = Some(error);
                return event_loop.exit();
            }
        }
        if let Some(notice) = open.screen.take_notice() {
            self.state.complain(notice);
            self.refresh();
        }
    }

    /// Has the interface shown anew.
    fn refresh(&mut self) {
        self.stale = true;
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }
}

impl ApplicationHandler<Wake> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_none()
            && let Err(error) = self.open_window(event_loop)
        {
            self.failure = Some(error);
            event_loop.exit();
        }
    }

    fn user_event(&mut self, _event_loop: &ActiveEventLoop, wake: Wake) {
        match wake {
            Wake::Work => {
                match self.dialogs.take() {
                    Some(Some(files)) => files.into_iter().for_each(|file| self.state.apply(Action::Open(file))),
                    Some(None) => self.state.shown.open = Some(String::new()),
                    None => {}
                }
                let version = self.state.version;
                let notices = self.state.notices.len();
                let under_way = |state: &State| {
                    state.loader.under_way().len() + state.pictures.under_way.len() + state.films.under_way.len()
                };
                let before = under_way(&self.state);
                self.state.poll();
                let changed = self.state.version != version
                    || self.state.notices.len() != notices
                    || under_way(&self.state) != before
                    || !self.state.requests.is_empty()
                    || self.state.shown.open.is_some();
                // A finished picture alone needs no new interface.
                self.stale |= changed;
                if let Some(open) = &self.open {
                    open.window.request_redraw();
                }
            }
            Wake::Access(event) => {
                use egui_winit::accesskit_winit::WindowEvent as Access;
                match event.window_event {
                    Access::InitialTreeRequested => self.egui_ctx.enable_accesskit(),
                    Access::ActionRequested(request) => {
                        if let Some(open) = &mut self.open {
                            open.egui.on_accesskit_action_request(request);
                        }
                    }
                    Access::AccessibilityDeactivated => self.egui_ctx.disable_accesskit(),
                }
                self.refresh();
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _id: WindowId, event: WindowEvent) {
        match &event {
            WindowEvent::CloseRequested => return event_loop.exit(),
            WindowEvent::RedrawRequested => return self.draw(event_loop),
            WindowEvent::DroppedFile(path) => self.state.apply(Action::Open(path.clone())),
            _ => {}
        }
        let Some(open) = &mut self.open else { return };
        if let WindowEvent::Resized(_) | WindowEvent::Occluded(false) = event {
            open.interface.forget();
        }
        if open.egui.on_window_event(&open.window, &event).repaint {
            self.first_event.get_or_insert_with(Instant::now);
            let wish = open.screen.next_wish(self.took + SPARE);
            match wish.filter(|_| matches!(event, WindowEvent::CursorMoved { .. })) {
                // A mouse tells of every step. They are taken together when the picture will soon come that is being drawn.
                Some(wish) => self.next_frame = Some(self.next_frame.map_or(wish, |at| at.min(wish))),
                None => self.refresh(),
            }
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let now = Instant::now();
        if watch::look(&mut self.state, now) {
            self.refresh();
        }
        // To look at files draws nothing.
        let looks = self.state.watch.next();
        let wait = |until: Option<Instant>| until.map_or(ControlFlow::Wait, ControlFlow::WaitUntil);
        match self.next_frame {
            Some(at) if at <= now => {
                if let Some(open) = &self.open {
                    open.window.request_redraw();
                }
                event_loop.set_control_flow(wait(looks));
            }
            Some(at) => event_loop.set_control_flow(wait(Some(looks.map_or(at, |looks| looks.min(at))))),
            None => event_loop.set_control_flow(wait(looks)),
        }
    }

    fn exiting(&mut self, _event_loop: &ActiveEventLoop) {
        if let Some(open) = &mut self.open {
            open.interface.close();
        }
        // The surface must go before the window's connection does.
        self.open = None;
    }
}
