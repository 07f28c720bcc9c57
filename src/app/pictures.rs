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
            path: free_name(Path::new(""), &state.stem(), "png").display().to_string(),
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
    pub(super) under_way: usize,
}

impl Pictures {
    pub(super) fn new(wake: Waker) -> Pictures {
        let (sender, receiver) = channel();
        Pictures { wake, sender, receiver, under_way: 0 }
    }
}

/// `stem-1.png`, or the next number that no file has.
fn free_name(folder: &Path, stem: &str, extension: &str) -> PathBuf {
    let name = |n: u32| folder.join(format!("{stem}-{n}.{extension}"));
    (1..10_000).map(name).find(|path| !path.exists()).unwrap_or_else(|| folder.join(format!("{stem}.{extension}")))
}

/// Saves the picture on the screen beside no other of its name.
pub(super) fn quick(state: &mut State) {
    let mut dialog = Dialog::new(state);
    // A second press before the first picture is there gets a name of its own.
    let stem = state.stem();
    if state.pictures.under_way > 0 {
        dialog.path =
            free_name(Path::new(""), &format!("{stem}-{}", state.pictures.under_way + 1), "png").display().to_string();
    }
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
    let (choice, settings) = (state.options.renderer, dialog.quality.settings());
    let (sender, wake) = (state.pictures.sender.clone(), Arc::clone(&state.pictures.wake));
    let draw = move || {
        let done = draw(Arc::new(scene), view, choice, &settings, &path);
        // The window may be gone.
        let _ = sender.send((path, done));
        wake();
    };
    match std::thread::Builder::new().name("picture".to_owned()).spawn(draw) {
        Ok(_) => state.pictures.under_way += 1,
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
        state.pictures.under_way = state.pictures.under_way.saturating_sub(1);
        match done {
            Ok(()) => state.say(format!("Saved {}", path.display())),
            Err(error) => state.complain(error.to_string()),
        }
    }
}
