//! The window: `ballstick FILE` opens the molecule, drag to turn it.
//!
//! [`navigate`] is the camera under the mouse, [`keys`] what each key does, [`model`] the files, the scene and its
//! settings, [`screen`] how frames get to the window: by a real GPU, or from the CPU renderer on a thread of its own,
//! so that input never waits for a picture. This file holds the event loop that joins them.

mod keys;
mod model;
mod navigate;
mod screen;
mod worker;

use crate::crystal::Drawn;
use crate::error::{Error, Result};
use crate::render::{Choice, Settings};
use crate::scene::SceneOptions;
use keys::{Action, action_of};
use model::Model;
use navigate::Drag;
use screen::Screen;
use std::path::PathBuf;
use std::sync::Arc;
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalPosition};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

/// What the window starts with.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Style, colours, ground, background.
    pub scene: SceneOptions,
    /// Whether the edges of the unit cell are drawn; `None` leaves it to what is drawn.
    pub cell_box: Option<bool>,
    /// Quality of the picture at rest.
    pub settings: Settings,
    /// Which renderer draws.
    pub renderer: Choice,
}

/// What other threads tell the event loop.
#[derive(Debug)]
enum Wake {
    /// The worker has finished a frame.
    Frame,
}

/// Opens a window on what is drawn of structures and returns when it is closed; `files` are where they come from.
///
/// # Errors
/// If there is no display (the message names the `render` command), or the window fails.
pub fn run(files: Vec<PathBuf>, drawn: Vec<Drawn>, options: Options) -> Result<()> {
    let model = Model::new(files, drawn, &options);
    // What winit says of it names its own source files; what helps is which display was tried.
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(|_| {
        let named = |name: &str| std::env::var_os(name).map(|value| format!("{name}={}", value.display()));
        let tried: Vec<String> = ["WAYLAND_DISPLAY", "DISPLAY"].into_iter().filter_map(named).collect();
        let why = if tried.is_empty() { "none is set".to_owned() } else { format!("{} gives none", tried.join(", ")) };
        let file = model.first_file().display().to_string();
        Error::Unsupported(format!(
            "there is no display to open a window on ({why}); to make a picture instead: ballstick render {file} -o picture.png"
        ))
    })?;
    event_loop.set_control_flow(ControlFlow::Wait);
    let mut app = App {
        proxy: event_loop.create_proxy(),
        options,
        model,
        screen: None,
        window: None,
        drag: None,
        pointer: PhysicalPosition::new(0.0, 0.0),
        failure: None,
    };
    event_loop.run_app(&mut app).map_err(|error| Error::Unsupported(format!("the window failed: {error}")))?;
    app.failure.map_or(Ok(()), Err)
}

struct App {
    proxy: EventLoopProxy<Wake>,
    options: Options,
    model: Model,
    screen: Option<Screen>,
    window: Option<Arc<Window>>,
    drag: Option<Drag>,
    pointer: PhysicalPosition<f64>,
    failure: Option<Error>,
}

impl App {
    fn open_window(&mut self, event_loop: &ActiveEventLoop) -> Result<()> {
        let attributes = Window::default_attributes()
            .with_title(self.model.title())
            .with_inner_size(LogicalSize::new(1280.0, 800.0))
            .with_min_inner_size(LogicalSize::new(64.0, 64.0));
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| Error::Unsupported(format!("the system opens no window: {error}")))?;
        let window = Arc::new(window);
        let size = window.inner_size();
        self.model.resize([size.width, size.height]);
        self.screen = Some(Screen::new(Arc::clone(&window), self.options.renderer, self.proxy.clone())?);
        self.window = Some(window);
        Ok(())
    }

    /// Has the picture drawn anew after something changed.
    fn refresh(&mut self) {
        if let (Some(screen), Some(window)) = (&mut self.screen, &self.window) {
            screen.changed(self.drag.is_some());
            window.request_redraw();
        }
    }

    fn act(&mut self, action: Action, event_loop: &ActiveEventLoop) {
        match action {
            Action::Quit => return event_loop.exit(),
            Action::Reset => self.model.reset_view(),
            Action::ToggleProjection => self.model.toggle_projection(),
            Action::ToggleGround => self.model.toggle_ground(),
            Action::Style(style) => self.model.set_style(style),
            Action::Screenshot => {
                match self.model.screenshot(self.options.renderer, &self.options.settings) {
                    Ok(path) => eprintln!("saved {}", path.display()),
                    Err(error) => eprintln!("ballstick: screenshot: {error}"),
                }
                return;
            }
        }
        self.refresh();
    }

    fn draw(&mut self, event_loop: &ActiveEventLoop) {
        let (Some(screen), Some(window)) = (&mut self.screen, &self.window) else { return };
        match screen.draw(&self.model, &self.options.settings) {
            Ok(true) => window.request_redraw(), // the picture still gets better
            Ok(false) => {}
            Err(error) => {
                self.failure = Some(error);
                event_loop.exit();
            }
        }
    }
}

impl ApplicationHandler<Wake> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.window.is_none()
            && let Err(error) = self.open_window(event_loop)
        {
            self.failure = Some(error);
            event_loop.exit();
        }
    }

    fn user_event(&mut self, _event_loop: &ActiveEventLoop, wake: Wake) {
        match (wake, &self.window) {
            (Wake::Frame, Some(window)) => window.request_redraw(),
            (Wake::Frame, None) => {}
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _id: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => self.draw(event_loop),
            WindowEvent::Resized(size) => {
                self.model.resize([size.width, size.height]);
                self.refresh();
            }
            WindowEvent::CursorMoved { position, .. } => {
                let (dx, dy) = (position.x - self.pointer.x, position.y - self.pointer.y);
                self.pointer = position;
                if let Some(drag) = self.drag {
                    self.model.drag(drag, dx as f32, dy as f32);
                    self.refresh();
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let drag = match button {
                    MouseButton::Left => Drag::Orbit,
                    MouseButton::Right | MouseButton::Middle => Drag::Pan,
                    _ => return,
                };
                match state {
                    ElementState::Pressed => self.drag = Some(drag),
                    ElementState::Released if self.drag == Some(drag) => {
                        self.drag = None;
                        self.refresh();
                    }
                    ElementState::Released => {}
                }
            }
            WindowEvent::MouseWheel { delta, .. } => {
                // A notch of a wheel is one line; touchpads send pixels, about 50 to a line.
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, y) => y,
                    MouseScrollDelta::PixelDelta(position) => position.y as f32 / 50.0,
                };
                self.model.zoom(lines, self.pointer.x as f32, self.pointer.y as f32);
                self.refresh();
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } if event.state == ElementState::Pressed => {
                if let Some(action) = action_of(&event.logical_key, event.repeat) {
                    self.act(action, event_loop);
                }
            }
            WindowEvent::Focused(false) => self.drag = None,
            _ => {}
        }
    }

    fn exiting(&mut self, _event_loop: &ActiveEventLoop) {
        // The surface must go before the window's connection does.
        self.screen = None;
        self.window = None;
    }
}
