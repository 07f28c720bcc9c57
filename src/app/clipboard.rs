//! Pictures to the clipboard. Text goes there with the rest of the interface (egui-winit).
//!
//! Limit: Wayland gives programs without its data-control protocol no place for pictures; there they go by X11, if Xwayland is there.

use crate::render::Image;
use std::borrow::Cow;

/// The clipboard, once a picture was put there. On X11 a program keeps what it has copied, so this has to stay as long as the window.
#[derive(Default)]
pub(super) struct Clipboard {
    system: Option<arboard::Clipboard>,
}

impl Clipboard {
    /// Puts a picture there; an error says why it cannot be, and what else can be done.
    pub(super) fn picture(&mut self, image: &Image) -> Result<(), String> {
        let failed = |error: arboard::Error| {
            let wayland = std::env::var_os("WAYLAND_DISPLAY").is_some() && std::env::var_os("DISPLAY").is_none();
            let why = if wayland {
                "Wayland gives this program no clipboard for pictures".to_owned()
            } else {
                error.to_string()
            };
            format!("The picture cannot be copied: {why}. Save it with S.")
        };
        let system = match self.system.take() {
            Some(system) => system,
            None => arboard::Clipboard::new().map_err(failed)?,
        };
        let data = arboard::ImageData {
            width: image.width as usize,
            height: image.height as usize,
            bytes: Cow::Borrowed(&image.rgba),
        };
        self.system.insert(system).set_image(data).map_err(failed)
    }
}
