//! What a picture file says of itself: enough to make it again with `--from`.

use super::args::{Named, RenderArgs, SelectArgs};
use super::picture::Draw;
use super::values::{MeasureArg, RecordChoice};
use super::{load, render};
use crate::crystal::Drawn;
use crate::export::atomic;
use crate::import::trajectory::Input;
use crate::render::Quality;
use crate::scene::SceneOptions;
use crate::session::{self, Overlay, Session, sums};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;

/// Sums of files, found while they are read and drawn.
pub(super) enum Sums {
    /// By a thread of their own.
    Begun(JoinHandle<HashMap<PathBuf, String>>),
    /// At the end, as there was no thread.
    Later(Vec<PathBuf>),
}

impl Sums {
    /// Begins to find them.
    pub(super) fn begin<'a>(files: impl Iterator<Item = &'a PathBuf>) -> Sums {
        let files: Vec<PathBuf> = files.cloned().collect();
        let theirs = files.clone();
        match std::thread::Builder::new().name("sums".to_owned()).spawn(move || find(theirs)) {
            Ok(thread) => Sums::Begun(thread),
            Err(_) => Sums::Later(files),
        }
    }

    /// The sums by path.
    pub(super) fn finish(self) -> HashMap<PathBuf, String> {
        match self {
            Sums::Begun(thread) => thread.join().unwrap_or_default(),
            Sums::Later(files) => find(files),
        }
    }
}

fn find(files: Vec<PathBuf>) -> HashMap<PathBuf, String> {
    // What cannot be read is said by its reader.
    let sum = |path: PathBuf| Some((path.clone(), sums::of_file(&path).ok()??));
    files.into_iter().filter_map(sum).collect()
}

/// What is needed to make the picture again. No dates: the same command gives the same bytes.
pub(super) fn metadata(
    args: &RenderArgs,
    output: &Path,
    inputs: &[(&Input, SelectArgs)],
    drawn: &[Drawn],
    draw: &dyn Draw,
    sums: &HashMap<PathBuf, String>,
) -> Vec<(String, String)> {
    let mut texts = vec![("Software".to_owned(), concat!("ballstick ", env!("CARGO_PKG_VERSION")).to_owned())];
    let title = drawn.first().map_or("", |drawn| drawn.structure.title());
    if !title.is_empty() {
        texts.push(("Title".to_owned(), super::report::printable(title)));
    }
    let renderer = draw.renderer();
    texts.push(("ballstick-renderer".to_owned(), renderer.clone()));
    let mut session = session(args, drawn, draw);
    if let Some(picture) = &mut session.picture {
        // Which one `auto` took: the other one's picture is not the same to the last bit.
        picture.renderer = if renderer.starts_with("gpu") { "gpu" } else { "cpu" }.to_owned();
    }
    session.files = inputs
        .iter()
        .map(|(input, select)| session::File {
            path: input.structure.clone(),
            trajectories: input.trajectories.clone(),
            frame: select.frame.map_or(1, std::num::NonZeroU32::get),
            visible: true,
            sha256: sums.get(&input.structure).cloned(),
        })
        .collect();
    session.overlay =
        args.look.overlay.iter().map(|path| Overlay { path: path.clone(), sha256: sums.get(path).cloned() }).collect();
    let folder = (!atomic::is_stdout(output)).then(|| output.parent().unwrap_or(Path::new("")));
    // A relative folder that is none is the one we are in.
    let folder = folder.map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    // Empty where a name is not text, which is said elsewhere.
    texts.extend(Some(session.text(folder)).filter(|(_, text)| !text.is_empty()));
    texts
}

/// The arguments as a session, without its files.
fn session(args: &RenderArgs, drawn: &[Drawn], draw: &dyn Draw) -> Session {
    let RenderArgs { look, select, .. } = args;
    let text = |value: Option<&dyn std::fmt::Display>| value.map(ToString::to_string);
    let settings = session::Settings {
        // What could go wrong did so when it was drawn.
        scene: render::scene_options(look, drawn).unwrap_or_else(|_| SceneOptions::default()),
        crystal: load::crystal_options(args.bonds, args.crystal),
        cell_box: args.crystal.has_box(),
        quality: Quality::from_name(&args.quality.name()).unwrap_or_default(),
        viewpoint: draw.viewpoint(),
    };
    let effort = render::settings(args);
    Session {
        // As they were typed: what is made of them has other last digits.
        outline: look.outline,
        depth_of_field: look.depth_of_field,
        focus: look.depth_of_field.map(|_| look.focus),
        fitted: look.camera.is_none() || args.origin.fitted,
        measurements: look.measure.iter().map(|MeasureArg(atoms)| atoms.clone()).collect(),
        picture: Some(session::Picture {
            size: args.size.to_string(),
            dpi: args.dpi,
            region: text(args.region.as_ref().map(|r| r as _)),
            crop: text(args.crop.as_ref().map(|c| c as _)),
            samples: effort.samples,
            ao: effort.ao,
            channel: args.channel.name(),
            renderer: String::new(),
            view: text(look.view.as_ref().map(|v| v as _)),
            axis: text(look.axis.as_ref().map(|a| a as _)),
            record: select.record.as_ref().map(RecordChoice::to_string),
            turntable: args.turntable,
            frames: args.frames.as_ref().map(ToString::to_string),
            fps: args.fps,
        }),
        ..Session::of(&settings)
    }
}
