//! The window: `ballstick FILE` opens the molecule, drag to turn it.
//!
//! Everything a person can do is an [`action`], and [`state`] does it: keys, panel, palette, undo, sessions and tests all drive the same
//! thing, without a window. [`work`] is what undo and sessions keep. [`loader`] reads files and [`build`] makes scenes, on threads of
//! their own where it takes long; of large files there is a [`preview`] meanwhile; frames of trajectories are decoded [`ahead`]. [`selecting`] selects, and writes down as selections what is
//! done with that. [`commands`] is the one table of what there is to do. [`ui`] shows the state with egui and turns input into actions.
//!
//! [`window`] joins this to the system: winit's events go to egui, what egui draws goes to the [`screen`] with the picture behind it. With a
//! real GPU the picture is drawn there and the interface over it; otherwise the CPU renderer draws on a thread ([`worker`]) and the interface
//! is painted by [`paint`], so that the window needs no GPU at all. Nothing is drawn while nothing changes.
//!
//! Limits: a reader that is given up finishes the file it is in, unseen.

mod action;
mod ahead;
mod animations;
mod assemblies;
mod build;
mod clipboard;
mod commands;
mod files;
mod history;
mod loader;
mod mouse;
mod navigate;
mod pace;
mod paint;
mod picking;
mod pictures;
mod preferences;
mod preview;
mod screen;
mod selecting;
mod sessions;
mod state;
mod timings;
mod ui;
mod watch;
mod window;
mod work;
mod worker;

use crate::crystal::CrystalOptions;
use crate::error::Result;
use crate::import::Document;
use crate::render::{Choice, Quality};
use crate::scene::{Measurement, SceneOptions, Viewpoint};
use std::path::PathBuf;
use std::sync::Arc;

/// What the window starts with.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Style, colours, ground, background.
    pub scene: SceneOptions,
    /// Where its meshes come from.
    pub overlay: Vec<PathBuf>,
    /// What is measured; items are the files in their order.
    pub measurements: Vec<Measurement>,
    /// What of crystals is drawn, and how bonds are found.
    pub crystal: CrystalOptions,
    /// Whether the edges of the unit cell are drawn; `None` leaves it to what is drawn.
    pub cell_box: Option<bool>,
    /// Quality of the picture at rest.
    pub quality: Quality,
    /// Which renderer draws.
    pub renderer: Choice,
    /// The view to begin with; `None` for the fitted one.
    pub viewpoint: Option<Viewpoint>,
    /// The first of the files, if it was read already: standard input can be read only once.
    pub first: Option<Arc<Document>>,
    /// Whether what the window does is counted and timed.
    pub timings: bool,
}

/// What there is to say when the window has been closed.
#[derive(Debug, Clone, Default)]
pub struct Ended {
    /// What could not be opened at the start.
    pub failures: Vec<String>,
    /// Counts and durations as one JSON object, if they were asked for.
    pub timings: Option<String>,
}

/// Opens a window on files (molecules, or a session), or one that shows how to open some, and returns when it is closed.
///
/// # Errors
/// If there is no display (the message names the `render` command), if none of the files can be read and all are small, or if the window
/// fails.
pub fn run(files: Vec<PathBuf>, options: Options) -> Result<Ended> {
    window::run(files, options)
}
