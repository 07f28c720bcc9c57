//! Sessions in the window: what is saved, what is opened, and the command line of the picture.
//!
//! The files of a session are read one after the other as they come; the settings, the picked atoms and the measurements are put in
//! place when the last one is there, as one step that can be undone.

use super::picking;
use super::state::State;
use super::work::{AtomKey, Layer, Source, Work};
use crate::scene::Viewpoint;
use crate::session::{Atom, File, Session, Settings};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A session that is being opened.
pub(super) struct Opening {
    session: Session,
    settings: Settings,
    /// A place for each file, in their order.
    layers: Vec<Option<Layer>>,
}

/// Whether a file is a session.
pub(super) fn is_session(path: &Path) -> bool {
    use std::io::Read;
    let Ok(file) = std::fs::File::open(path) else { return false };
    let mut start = Vec::new();
    // Where it cannot be read the reader of molecules says so.
    file.take(4096).read_to_end(&mut start).is_ok() && Session::is_one(&start)
}

/// The work as a session.
pub(super) fn of(state: &State) -> Session {
    let work = &state.work;
    let viewpoint = (!state.built.drawn.is_empty()).then(|| Viewpoint::of(&state.built.scene, &work.camera));
    let settings = Settings {
        scene: work.scene.clone(),
        crystal: work.crystal,
        cell_box: work.cell_box,
        quality: work.quality,
        viewpoint,
    };
    let mut session = Session::of(&settings);
    let absolute = |path: &PathBuf| std::path::absolute(path).unwrap_or_else(|_| path.clone());
    let file = |layer: &Layer| File {
        path: match &layer.source {
            Source::File(input) => absolute(&input.structure),
            Source::Sample(name) => PathBuf::from(name),
        },
        trajectories: match &layer.source {
            Source::File(input) => input.trajectories.iter().map(absolute).collect(),
            Source::Sample(_) => Vec::new(),
        },
        frame: u32::try_from(layer.frame + 1).unwrap_or(u32::MAX),
        visible: layer.visible,
    };
    session.files = work.layers.iter().map(file).collect();
    session.fitted = work.fitted;
    session.picked = work.picked.iter().filter_map(|key| place(work, key)).collect();
    session.measurements = places(work, work.measurements.iter());
    session
}

/// An atom by the numbers of a session.
fn place(work: &Work, key: &AtomKey) -> Option<Atom> {
    let file = work.layers.iter().position(|layer| layer.id == key.layer)?;
    Some([u32::try_from(file + 1).ok()?, key.atom.checked_add(1)?])
}

fn places<'a>(work: &Work, measurements: impl Iterator<Item = &'a Vec<AtomKey>>) -> Vec<Vec<Atom>> {
    let whole = |atoms: &Vec<AtomKey>| atoms.iter().map(|key| place(work, key)).collect::<Option<Vec<Atom>>>();
    measurements.filter_map(whole).collect()
}

/// The command line that makes the picture on the screen; an error says why there is none.
pub(super) fn command_line(state: &State) -> Result<String, &'static str> {
    let shown: Vec<&Layer> = state.work.shown().collect();
    if shown.iter().any(|layer| layer.source.path().is_none()) {
        return Err(
            "A command line names files, and a sample or standard input has no name: open the molecule from a file.",
        );
    }
    if shown.windows(2).any(|pair| pair[0].frame != pair[1].frame) {
        return Err("The molecules show different frames, and a command line has one --frame for all: save a session.");
    }
    let mut session = of(state);
    // What is measured on atoms that are not drawn is not in the picture.
    let is_drawn = |atoms: &&Vec<AtomKey>| atoms.iter().all(|&key| picking::ball(state, key).is_some());
    session.measurements = places(&state.work, state.work.measurements.iter().filter(is_drawn));
    Ok(session.command_line(state.view_px))
}

/// Where a session would be saved: beside no other of its name.
pub(super) fn proposed(state: &State) -> String {
    let stem = state.stem();
    let plain = PathBuf::from(format!("{stem}.ballstick.json"));
    let path = if plain.exists() { super::pictures::free_name(&stem, "ballstick.json", &[]) } else { plain };
    path.display().to_string()
}

/// Saves the session.
pub(super) fn save(state: &mut State, path: &Path) {
    if state.work.layers.iter().any(|layer| layer.source.path().is_none()) {
        return state.complain(
            "A session keeps the paths of files, and a sample or standard input has none: open the molecule from a file.",
        );
    }
    if path.exists() && !is_session(path) {
        let path = path.display();
        return state.complain(format!("{path} is there and is no session: choose another name."));
    }
    let session = of(state);
    match session.write(path) {
        Ok(()) => {
            state.shown.session = None;
            state.say(format!("Saved the session {}", path.display()));
        }
        Err(error) => state.complain(error.to_string()),
    }
}

/// Opens a session in place of what is there.
pub(super) fn open(state: &mut State, path: &Path) {
    let read = Session::read(path).and_then(|session| Ok((session.settings()?, session)));
    let (settings, session) = match read {
        Ok(read) => read,
        Err(error) => return state.complain(format!("{}: {error}", path.display())),
    };
    state.preferences.opened(path);
    for file in &session.files {
        state.loader.start(Source::File(file.input()), settings.crystal, None);
    }
    let layers = session.files.iter().map(|_| None).collect();
    state.opening = Some(Opening { session, settings, layers });
    finish(state);
}

/// A file could not be read: a session that waits for it is not opened.
pub(super) fn failed(state: &mut State) {
    if state.opening.take().is_some() {
        state.loader.cancel();
        state.complain("The session is not opened: one of its files cannot be read.");
    }
}

/// Takes a file that was read if a session waits for it.
pub(super) fn arrived(state: &mut State, layer: &Layer) -> bool {
    let Some(opening) = &mut state.opening else { return false };
    let is_it =
        |(file, place): &(&File, &mut Option<Layer>)| place.is_none() && layer.source == Source::File(file.input());
    let Some((file, place)) = opening.session.files.iter().zip(&mut opening.layers).find(is_it) else { return false };
    let frame = layer.document.nearest_frame((file.frame as usize).saturating_sub(1));
    *place = Some(Layer { frame, visible: file.visible, ..layer.clone() });
    finish(state);
    true
}

/// Puts the session in place once all its files are there.
fn finish(state: &mut State) {
    let is_whole = state.opening.as_ref().is_some_and(|opening| opening.layers.iter().all(Option::is_some));
    let Some(Opening { session, settings, layers }) = state.opening.take_if(|_| is_whole) else { return };
    let layers: Vec<Layer> = layers.into_iter().flatten().collect();
    let key = |&[file, atom]: &Atom| -> Option<AtomKey> {
        let layer = layers.get(file.checked_sub(1)? as usize)?;
        Some(AtomKey { layer: layer.id, atom: atom.checked_sub(1)? })
    };
    let before = state.work.clone();
    let measurement = |atoms: &Vec<Atom>| atoms.iter().map(key).collect::<Option<Vec<_>>>();
    let work = Work {
        picked: Arc::new(session.picked.iter().filter_map(key).collect()),
        picked_by: None,
        measurements: session.measurements.iter().filter_map(measurement).collect(),
        scene: crate::scene::SceneOptions { overlay: before.scene.overlay.clone(), ..settings.scene },
        crystal: settings.crystal,
        cell_box: settings.cell_box,
        quality: settings.quality,
        camera: before.camera,
        fitted: session.fitted || settings.viewpoint.is_none(),
        layers,
    };
    state.options.viewpoint = settings.viewpoint.filter(|_| !session.fitted);
    state.work = work;
    state.history.push(before, "open session", None);
    state.update();
}
