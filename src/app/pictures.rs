//! Pictures to files, drawn on a thread of their own by the renderer that draws the window.

use super::build::Waker;
use super::state::State;
use crate::error::{Error, Result};
use crate::export::{atomic, picture};
use crate::render::{Choice, Quality, Settings, View, select};
use crate::scene::{Background, Scene};
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
        Pictures { wake, sender, receiver, under_way: Vec::new() }
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
    let (sender, wake) = (state.pictures.sender.clone(), Arc::clone(&state.pictures.wake));
    let name = path.clone();
    let draw = move || {
        let done = draw(Arc::new(scene), view, choice, &settings, &path);
        // The window may be gone.
        let _ = sender.send((path, done));
        wake();
    };
    match std::thread::Builder::new().name("picture".to_owned()).spawn(draw) {
        Ok(thread) => state.pictures.under_way.push((name, Some(thread))),
        Err(error) => state.complain(format!("The system gives no thread to draw on: {error}")),
    }
}

fn draw(scene: Arc<Scene>, view: View, choice: Choice, settings: &Settings, path: &Path) -> Result<()> {
    let format = picture::PictureFormat::from_path(path)?;
    let alpha = scene.background == Background::Transparent;
    if alpha && !format.holds_alpha() {
        let message = "this format keeps no transparent background; save as PNG or WebP, or choose a colour";
        return Err(Error::Unsupported(message.to_owned()));
    }
    let mut renderer = select(choice)?.renderer;
    renderer.load(scene)?;
    let image = renderer.image(&view, settings)?;
    let options = picture::PictureOptions { alpha, ..picture::PictureOptions::default() };
    atomic::write(path, |out| picture::write(picture::Content::Color(&image), format, &options, out))
}

/// Says which pictures are there.
pub(super) fn poll(state: &mut State) {
    while let Ok((path, done)) = state.pictures.receiver.try_recv() {
        state.pictures.under_way.retain(|(other, _)| *other != path);
        match done {
            Ok(()) => state.say(format!("Saved {}", path.display())),
            Err(error) => state.complain(error.to_string()),
        }
    }
}
