//! Sessions in the window: what is saved, what is opened, and the command line of the picture.
//!
//! The files of a session are read one after the other as they come; the settings, the picked atoms and the measurements are put in
//! place when the last one is there, as one step that can be undone.

use super::build::Waker;
use super::picking;
use super::state::State;
use super::work::{AtomKey, Layer, Source, Work};
use crate::scene::Viewpoint;
use crate::session::{Atom, File, Overlay, Session, Settings};
use crate::structure::Mesh;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// A session that is being opened.
pub(super) struct Opening {
    session: Session,
    settings: Settings,
    /// A place for each file, in their order.
    layers: Vec<Option<Layer>>,
    meshes: Meshes,
}

/// The meshes that a session lays over its molecules.
enum Meshes {
    /// They are being read.
    Read(Receiver<Result<Vec<Arc<Mesh>>, String>>),
    There(Vec<Arc<Mesh>>),
}

/// Reads meshes on a thread of their own.
fn read_meshes(overlay: &[Overlay], wake: Waker) -> Meshes {
    if overlay.is_empty() {
        return Meshes::There(Vec::new());
    }
    let paths: Vec<PathBuf> = overlay.iter().map(|mesh| mesh.path.clone()).collect();
    let (sender, receiver) = channel();
    let read = move || {
        let read = |path: &PathBuf| match crate::import::mesh::read_path(path, &Default::default()) {
            Ok((mesh, _)) => Ok(Arc::new(mesh)),
            Err(error @ crate::Error::Io { .. }) => Err(error.to_string()),
            Err(error) => Err(format!("{}: {error}", path.display())),
        };
        // The window may be gone, or the session given up.
        let _ = sender.send(paths.iter().map(read).collect());
        wake();
    };
    // Without a thread the sender goes, and with it the session.
    let _ = std::thread::Builder::new().name("meshes".to_owned()).spawn(read);
    Meshes::Read(receiver)
}

/// Whether a file is a session.
pub(super) fn is_session(path: &Path) -> bool {
    // Where it cannot be read the reader of molecules says so.
    Session::is_at(path)
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
            sample => sample.named(),
        },
        trajectories: match &layer.source {
            Source::File(input) => input.trajectories.iter().map(absolute).collect(),
            Source::Sample(_) => Vec::new(),
        },
        frame: u32::try_from(layer.frame + 1).unwrap_or(u32::MAX),
        visible: layer.visible,
        sha256: None,
    };
    session.files = work.layers.iter().map(file).collect();
    session.overlay = work.overlay.iter().map(|path| Overlay { path: path.clone(), sha256: None }).collect();
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
    if shown.iter().any(|layer| layer.source.is_gone()) {
        return Err("A command line names files, and standard input has no name: open the molecule from a file.");
    }
    if shown.windows(2).any(|pair| pair[0].frame != pair[1].frame) {
        return Err("The molecules show different frames, and a command line has one --frame for all: save a session.");
    }
    Ok(of_picture(state).command_line(state.view_px))
}

/// What the picture on the screen shows of the work.
pub(super) fn of_picture(state: &State) -> Session {
    let mut session = of(state);
    // What is measured on atoms that are not drawn is not in the picture.
    let is_drawn = |atoms: &&Vec<AtomKey>| atoms.iter().all(|&key| picking::ball(state, key).is_some());
    session.measurements = places(&state.work, state.work.measurements.iter().filter(is_drawn));
    session
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
    if state.work.layers.iter().any(|layer| layer.source.is_gone()) {
        return state.complain(
            "A session keeps the paths of files, and standard input has none: open the molecule from a file.",
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
        state.loader.start(Source::of_input(file.input()), settings.crystal, None, None);
    }
    state.drop_preview(None);
    let layers = session.files.iter().map(|_| None).collect();
    let meshes = read_meshes(&session.overlay, state.pictures.waker());
    state.opening = Some(Opening { session, settings, layers, meshes });
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
        |(file, place): &(&File, &mut Option<Layer>)| place.is_none() && layer.source == Source::of_input(file.input());
    let Some((file, place)) = opening.session.files.iter().zip(&mut opening.layers).find(is_it) else { return false };
    // The frames of a record come after those of all before it.
    let record = opening.session.picture.as_ref().and_then(|picture| picture.record.as_ref()?.parse::<usize>().ok());
    let before = layer.document.records.iter().take(record.map_or(0, |record| record.saturating_sub(1)));
    let before: usize = before.map(|record| record.frames().len()).sum();
    let frame = layer.document.nearest_frame(before + (file.frame as usize).saturating_sub(1));
    *place = Some(Layer { frame, visible: file.visible, ..layer.clone() });
    finish(state);
    true
}

/// Puts the session in place once all its files are there.
pub(super) fn finish(state: &mut State) {
    let Some(opening) = &mut state.opening else { return };
    if let Meshes::Read(receiver) = &opening.meshes {
        match receiver.try_recv() {
            Ok(Ok(meshes)) => opening.meshes = Meshes::There(meshes),
            Err(TryRecvError::Empty) => {}
            Ok(Err(problem)) => {
                state.complain(problem);
                return failed(state);
            }
            Err(TryRecvError::Disconnected) => return failed(state),
        }
    }
    let is_whole = opening.layers.iter().all(Option::is_some) && matches!(opening.meshes, Meshes::There(_));
    let Some(Opening { session, settings, layers, meshes: Meshes::There(meshes) }) =
        state.opening.take_if(|_| is_whole)
    else {
        return;
    };
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
        scene: crate::scene::SceneOptions { overlay: meshes, ..settings.scene },
        overlay: Arc::new(session.overlay.iter().map(|mesh| mesh.path.clone()).collect()),
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
