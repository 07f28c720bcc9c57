//! Pictures to files, drawn on a thread of their own by the renderer that draws the window.

use super::build::Waker;
use super::sessions;
use super::state::{Request, State};
use crate::error::{Error, Result};
use crate::export::{atomic, picture};
use crate::render::{Choice, Image, Quality, Settings, View, select};
use crate::scene::{Background, Scene};
use crate::session::{self, Session, sums};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

/// Sides of a picture that is gathered in memory; larger ones are for `render`.
const MOST_SIDE: u32 = 16_384;

/// What is asked before a picture is saved.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dialog {
    pub(super) path: String,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) transparent: bool,
    pub(super) quality: Quality,
    /// Whether the height follows the width, so that the picture has the shape of the window.
    pub(super) keeps_shape: bool,
}

impl Dialog {
    /// The picture on the screen, at its size.
    pub(super) fn new(state: &State) -> Dialog {
        Dialog {
            path: free_name(&state.stem(), "png", &state.pictures.under_way).display().to_string(),
            width: state.view_px[0],
            height: state.view_px[1],
            transparent: state.work.scene.background == Background::Transparent,
            quality: state.work.quality,
            keeps_shape: true,
        }
    }
}

/// Pictures that are being drawn.
pub(super) struct Pictures {
    wake: Waker,
    sender: Sender<(PathBuf, Result<()>)>,
    receiver: Receiver<(PathBuf, Result<()>)>,
    /// Pictures for the clipboard.
    copies: (Sender<Result<Image>>, Receiver<Result<Image>>),
    /// Whether one is being drawn.
    pub(super) is_copying: bool,
    /// Paths of pictures that are being drawn, and the threads that draw them.
    pub(super) under_way: Vec<(PathBuf, Option<JoinHandle<()>>)>,
}

impl Drop for Pictures {
    /// A picture that was asked for is saved, whatever becomes of the window.
    fn drop(&mut self) {
        for thread in self.under_way.iter_mut().filter_map(|(_, thread)| thread.take()) {
            // It has said what there is to say.
            let _ = thread.join();
        }
    }
}

impl Pictures {
    pub(super) fn new(wake: Waker) -> Pictures {
        let (sender, receiver) = channel();
        Pictures { wake, sender, receiver, copies: channel(), is_copying: false, under_way: Vec::new() }
    }

    /// What tells the window that there is something new.
    pub(super) fn waker(&self) -> Waker {
        Arc::clone(&self.wake)
    }
}

/// `stem-1.png`, or the next number that no file has, and none that is being written.
pub(super) fn free_name(stem: &str, extension: &str, taken: &[(PathBuf, Option<JoinHandle<()>>)]) -> PathBuf {
    let name = |n: u32| PathBuf::from(format!("{stem}-{n}.{extension}"));
    let is_free = |path: &PathBuf| !path.exists() && taken.iter().all(|(other, _)| other != path);
    (1..10_000).map(name).find(is_free).unwrap_or_else(|| PathBuf::from(format!("{stem}.{extension}")))
}

/// Saves the picture on the screen beside no other of its name.
pub(super) fn quick(state: &mut State) {
    let dialog = Dialog::new(state);
    save(state, &dialog);
}

/// Draws and saves what a dialog asks for.
pub(super) fn save(state: &mut State, dialog: &Dialog) {
    let path = PathBuf::from(dialog.path.trim());
    if let Err(error) = picture::PictureFormat::from_path(&path) {
        return state.complain(error.to_string());
    }
    if dialog.width.max(dialog.height) > MOST_SIDE {
        return state.complain(format!(
            "A picture from the window has at most {MOST_SIDE} pixels a side; ballstick render draws larger ones."
        ));
    }
    let mut scene = (*state.built.scene).clone();
    if dialog.transparent {
        scene.background = Background::Transparent;
    }
    let view = View::new(state.work.camera, dialog.width, dialog.height);
    let (choice, settings) = (state.options.renderer, state.fine(dialog.quality));
    let session = described(state, dialog, &settings);
    let (sender, wake) = (state.pictures.sender.clone(), Arc::clone(&state.pictures.wake));
    let name = path.clone();
    let draw = move || {
        let done = draw(Arc::new(scene), view, choice, &settings, session, &path);
        // The window may be gone.
        let _ = sender.send((path, done));
        wake();
    };
    match std::thread::Builder::new().name("picture".to_owned()).spawn(draw) {
        Ok(thread) => state.pictures.under_way.push((name, Some(thread))),
        Err(error) => state.complain(format!("The system gives no thread to draw on: {error}")),
    }
}

/// What the picture says of itself.
pub(super) fn described(state: &State, dialog: &Dialog, settings: &Settings) -> Session {
    let mut session = sessions::of_picture(state);
    if dialog.transparent {
        session.background = "transparent".to_owned();
    }
    session.quality = dialog.quality.name().to_owned();
    session.picture = Some(session::Picture {
        size: format!("{}x{}", dialog.width, dialog.height),
        dpi: None,
        region: None,
        crop: None,
        samples: settings.samples,
        ao: settings.ao,
        channel: "color".to_owned(),
        renderer: String::new(),
        view: None,
        axis: None,
        record: None,
        turntable: None,
        frames: None,
        fps: None,
    });
    session
}

/// The texts of a picture in its folder, once it is known who draws.
pub(super) fn texts(mut session: Session, renderer: &str, path: &Path) -> Vec<(String, String)> {
    if let Some(picture) = &mut session.picture {
        picture.renderer = if renderer.starts_with("gpu") { "gpu" } else { "cpu" }.to_owned();
    }
    for file in &mut session.files {
        // What is gone by now has no sum to compare with.
        file.sha256 = sums::of_file(&file.path).ok().flatten();
    }
    for mesh in &mut session.overlay {
        mesh.sha256 = sums::of_file(&mesh.path).ok().flatten();
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    vec![
        ("Software".to_owned(), concat!("ballstick ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("ballstick-renderer".to_owned(), renderer.to_owned()),
        session.text(Some(folder)),
    ]
}

fn draw(
    scene: Arc<Scene>,
    view: View,
    choice: Choice,
    settings: &Settings,
    session: Session,
    path: &Path,
) -> Result<()> {
    let format = picture::PictureFormat::from_path(path)?;
    let alpha = scene.background == Background::Transparent;
    if alpha && !format.holds_alpha() {
        let message = "this format keeps no transparent background; save as PNG or WebP, or choose a colour";
        return Err(Error::Unsupported(message.to_owned()));
    }
    let mut renderer = select(choice)?.renderer;
    renderer.load(scene)?;
    let image = renderer.image(&view, settings)?;
    let texts = texts(session, &renderer.name(), path);
    let options = picture::PictureOptions { alpha, texts, ..picture::PictureOptions::default() };
    atomic::write(path, |out| picture::write(picture::Content::Color(&image), format, &options, out))
}

/// Draws the picture on the screen for the clipboard.
pub(super) fn copy(state: &mut State) {
    if std::mem::replace(&mut state.pictures.is_copying, true) {
        return;
    }
    let scene = Arc::clone(&state.built.scene);
    let (view, choice, settings) = (state.view(), state.options.renderer, state.fine(state.work.quality));
    let (sender, wake) = (state.pictures.copies.0.clone(), Arc::clone(&state.pictures.wake));
    let draw = move || {
        let image = super::loader::guarded(|| {
            let mut renderer = select(choice)?.renderer;
            renderer.load(scene)?;
            renderer.image(&view, &settings)
        });
        // The window may be gone.
        let _ = sender.send(image);
        wake();
    };
    if let Err(error) = std::thread::Builder::new().name("picture".to_owned()).spawn(draw) {
        state.pictures.is_copying = false;
        state.complain(format!("The system gives no thread to draw on: {error}"));
    }
}

/// Says which pictures are there.
pub(super) fn poll(state: &mut State) {
    while let Ok(drawn) = state.pictures.copies.1.try_recv() {
        state.pictures.is_copying = false;
        match drawn {
            Ok(image) => state.requests.push(Request::CopyImage(image)),
            Err(error) => state.complain(error.to_string()),
        }
    }
    while let Ok((path, done)) = state.pictures.receiver.try_recv() {
        state.pictures.under_way.retain(|(other, _)| *other != path);
        match done {
            Ok(()) => state.say(format!("Saved {}", path.display())),
            Err(error) => state.complain(error.to_string()),
        }
    }
}
