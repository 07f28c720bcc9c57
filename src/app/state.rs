//! The state of the window, and the only way to change it: [`State::apply`].
//!
//! Nothing here knows windows, pixels on a screen or egui, so that keys, panel, palette and tests drive the same thing.

mod perform;

use super::action::Action;
use super::build::{Builder, Built, Maker, Spec, Waker};
use super::history::History;
use super::loader::{Loaded, Loader};
use super::preferences::Preferences;
use super::preview::Preview;
use super::watch::Watch;
use super::work::{AtomKey, Layer, Source, Work};
use super::{Options, animations, picking, pictures, sessions};
use crate::error::Error;
use crate::import::Document;
use crate::import::trajectory::Input;
use crate::render::{Image, Quality, Settings, View};
use crate::scene::{AtomPlace, Camera, Measurement};
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Something to be said to the person.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Notice {
    pub(super) text: String,
    pub(super) is_error: bool,
    pub(super) since: Instant,
}

/// What only the window can do.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Request {
    /// Ask for files to open.
    Open,
    /// Put a text on the clipboard.
    Copy(String),
    /// Put a picture on the clipboard.
    CopyImage(Image),
    Quit,
}

/// What is open on the screen beside the molecule.
#[derive(Debug, Default)]
pub(super) struct Shown {
    pub(super) palette: bool,
    pub(super) keys: bool,
    pub(super) picture: Option<pictures::Dialog>,
    pub(super) animation: Option<animations::Dialog>,
    /// The path to save a session to, as it is being typed.
    pub(super) session: Option<String>,
    /// Whether a selection is about to be written.
    pub(super) write_selection: bool,
    /// The path to open, as it is being typed, where the system has no dialog.
    pub(super) open: Option<String>,
}

impl Shown {
    /// Whether something stands before the molecule.
    pub(super) fn is_before(&self) -> bool {
        let asks = self.picture.is_some() || self.animation.is_some() || self.session.is_some() || self.open.is_some();
        self.palette || self.keys || asks
    }
}

/// What happens where the frames end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AtEnd {
    Stop,
    Loop,
    /// Back the way they came.
    Bounce,
}

impl AtEnd {
    pub(super) const ALL: [AtEnd; 3] = [AtEnd::Stop, AtEnd::Loop, AtEnd::Bounce];

    pub(super) fn name(self) -> &'static str {
        match self {
            AtEnd::Stop => "Once",
            AtEnd::Loop => "Loop",
            AtEnd::Bounce => "Bounce",
        }
    }
}

/// How frames are played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Playing {
    pub(super) on: bool,
    /// Frames a second.
    pub(super) speed: f32,
    pub(super) at_end: AtEnd,
    /// Whether they go back at the moment.
    pub(super) back: bool,
    /// When the frame that is shown was asked for.
    pub(super) last: Option<Instant>,
}

/// All of it.
pub(super) struct State {
    pub(super) work: Work,
    pub(super) history: History,
    pub(super) built: Arc<Built>,
    /// What is on the screen in its place as long as nothing is there but a large file that is being read.
    pub(super) preview: Option<Preview>,
    pub(super) preferences: Preferences,
    pub(super) shown: Shown,
    pub(super) playing: Playing,
    /// Whether clicks gather atoms to measure.
    pub(super) measuring: bool,
    pub(super) notices: Vec<Notice>,
    pub(super) requests: Vec<Request>,
    pub(super) options: Options,
    pub(super) pictures: pictures::Pictures,
    pub(super) films: animations::Films,
    pub(super) watch: Watch,
    pub(super) loader: Loader,
    /// What a session that is being opened still has to put in place when its files are read.
    pub(super) opening: Option<sessions::Opening>,
    maker: Arc<Maker>,
    /// Layers whose files are being read again without having been asked for.
    by_itself: HashSet<u32>,
    builder: Builder,
    /// The specification that the builder works on.
    asked: Option<Spec>,
    /// Width and height of the view in pixels.
    pub(super) view_px: [u32; 2],
    /// Counts changes of the picture.
    pub(super) version: u64,
    /// The view and quality that it was last made for.
    seen: Option<(Camera, Quality)>,
    /// When it changed last.
    changed: Instant,
    /// Whether a button is held down that moves the picture.
    pub(super) dragging: bool,
}

impl State {
    /// With nothing open; `wake` is called from other threads when there is something new.
    pub(super) fn new(options: Options, preferences: Preferences, wake: Waker) -> State {
        let maker = Arc::new(Maker::default());
        let work = Work {
            layers: Vec::new(),
            scene: options.scene.clone(),
            overlay: Arc::new(options.overlay.clone()),
            crystal: options.crystal,
            cell_box: options.cell_box,
            quality: options.quality,
            picked: Arc::default(),
            picked_by: None,
            measurements: Vec::new(),
            camera: crate::scene::Scene::from_blocks(Vec::new(), Vec::new()).fitted_camera(1.5),
            fitted: true,
        };
        State {
            built: Arc::new(Built::empty(&work)),
            preview: None,
            work,
            history: History::default(),
            preferences,
            shown: Shown::default(),
            playing: Playing { on: false, speed: 12.0, at_end: AtEnd::Loop, back: false, last: None },
            measuring: false,
            notices: Vec::new(),
            requests: Vec::new(),
            pictures: pictures::Pictures::new(Arc::clone(&wake)),
            films: animations::Films::new(Arc::clone(&wake)),
            watch: Watch::default(),
            loader: Loader::new(Arc::clone(&maker), Arc::clone(&wake)),
            opening: None,
            builder: Builder::start(Arc::clone(&maker), wake),
            maker,
            by_itself: HashSet::new(),
            asked: None,
            view_px: [960, 640],
            version: 1,
            seen: None,
            changed: Instant::now(),
            dragging: false,
            options,
        }
    }

    /// The view on the screen.
    pub(super) fn view(&self) -> View {
        View::new(self.work.camera, self.view_px[0], self.view_px[1])
    }

    /// What makes scenes.
    pub(super) fn maker(&self) -> Arc<Maker> {
        Arc::clone(&self.maker)
    }

    /// Notes that the picture is another one.
    pub(super) fn touch(&mut self) {
        self.version += 1;
        self.changed = Instant::now();
        self.seen = Some((self.work.camera, self.work.quality));
    }

    /// How long it is until the picture counts as at rest, so that the finished one is worth its time; `None` as long as something moves
    /// by itself or is being dragged.
    pub(super) fn until_rest(&self, now: Instant) -> Option<Duration> {
        let moves = self.dragging || self.playing.on;
        (!moves).then(|| REST.saturating_sub(now.saturating_duration_since(self.changed)))
    }

    /// The title of the window.
    pub(super) fn title(&self) -> String {
        let names: Vec<String> = self.work.layers.iter().map(|layer| layer.source.name()).collect();
        if names.is_empty() { "ballstick".to_owned() } else { format!("{} – ballstick", names.join(", ")) }
    }

    /// Whether a large scene is being made.
    pub(super) fn is_building(&self) -> bool {
        self.asked.is_some() && self.builder.is_busy()
    }

    /// Gives up what is being read or made.
    pub(super) fn cancel(&mut self) {
        self.loader.cancel();
        self.builder.cancel();
        self.opening = None;
        self.drop_preview(None);
        if self.asked.take().is_some() {
            self.say("Stopped: the picture is still the one before.");
        }
    }

    /// Says something.
    pub(super) fn say(&mut self, text: impl Into<String>) {
        self.notices.push(Notice { text: text.into(), is_error: false, since: Instant::now() });
    }

    /// Says that something went wrong.
    pub(super) fn complain(&mut self, text: impl Into<String>) {
        let notice = Notice { text: text.into(), is_error: true, since: Instant::now() };
        // The same once is enough.
        self.notices.retain(|other| other.text != notice.text);
        self.notices.push(notice);
    }

    /// Takes in what other threads have finished.
    pub(super) fn poll(&mut self) {
        for preview in self.loader.previews() {
            self.show_preview(preview);
        }
        for (loaded, replaces) in self.loader.finished() {
            self.take_in(loaded, replaces);
        }
        self.measure_as_asked();
        if let Some(done) = self.builder.take() {
            self.asked = None;
            match done {
                Ok(built) => self.accept(built),
                Err(error) => self.give_up_frame(&error),
            }
        }
        for problem in self.loader.problems() {
            self.say(problem);
        }
        pictures::poll(self);
        animations::poll(self);
        if self.opening.is_some() {
            sessions::finish(self);
        }
    }

    /// Takes in a file that was read before there was a window.
    pub(super) fn take_first(&mut self, file: Input, document: Arc<Document>) {
        let load = self.loader.number();
        self.take_in(Loaded { load, source: Source::of_input(file), result: Ok(document) }, None);
    }

    /// Takes in all that is being read, waiting for it: for what comes before the first picture.
    pub(super) fn wait_for_files(&mut self) {
        for (loaded, replaces) in self.loader.wait() {
            self.take_in(loaded, replaces);
        }
        self.measure_as_asked();
    }

    fn take_in(&mut self, loaded: Loaded, replaces: Option<u32>) {
        let Loaded { load, source, result } = loaded;
        let document = match result {
            Ok(document) => document,
            Err(_) if replaces.is_some_and(|id| self.by_itself.remove(&id) && self.watch.is_tried_again(id)) => return,
            Err(error) => {
                let named = match (&error, &source) {
                    // Its message names the file.
                    (Error::Io { .. }, _) => error.to_string(),
                    _ => format!("{}: {error}", source.name()),
                };
                sessions::failed(self);
                self.drop_preview(Some(load));
                return self.complain(named);
            }
        };
        if let Some(path) = source.path() {
            self.preferences.opened(path);
        }
        for diagnostic in document.diagnostics.iter().filter(|d| d.severity == crate::structure::Severity::Error) {
            self.complain(format!("{}: {diagnostic}", source.name()));
        }
        match replaces.and_then(|id| self.work.layer(id).cloned()) {
            Some(old) => {
                if let Some(path) = source.path() {
                    self.watch.was_read(old.id, path);
                }
                if self.by_itself.remove(&old.id) {
                    self.say(format!("{} has changed and was read again.", source.name()));
                }
                let frame = document.nearest_frame(old.frame);
                self.apply(Action::Replace(Box::new(Layer { source, document, frame, ..old })));
            }
            None => {
                if let Some(path) = source.path() {
                    self.watch.was_read(load, path);
                }
                let layer = Layer { id: load, source, document, frame: 0, visible: true };
                if sessions::arrived(self, &layer) {
                    return;
                }
                self.apply(Action::Add(Box::new(layer)));
            }
        }
    }

    /// Measures what the command line asks for, once all its files are there: they were the first to be read, in its order.
    fn measure_as_asked(&mut self) {
        if self.options.measurements.is_empty() || !self.loader.under_way().is_empty() {
            return;
        }
        for Measurement { atoms } in std::mem::take(&mut self.options.measurements) {
            let key = |place: &AtomPlace| {
                let layer = self.work.layer(place.item.checked_add(1)?)?;
                let atoms = layer.document.records.first()?.atom_count();
                // What is drawn of a crystal or an assembly has other numbers than the file.
                let has_others = layer.document.records[0].cell().is_some() || self.work.crystal.assembly.is_some();
                let is_there = (place.atom as usize) < atoms || has_others;
                is_there.then_some(AtomKey { layer: layer.id, atom: place.atom })
            };
            match atoms.iter().map(key).collect::<Option<Vec<AtomKey>>>() {
                Some(keys) => self.work.measurements.push(keys),
                None => {
                    let named: Vec<String> = atoms.iter().map(|p| format!("{}:{}", p.item + 1, p.atom + 1)).collect();
                    self.complain(format!("--measure {}: not all of these atoms are there", named.join(",")));
                }
            }
        }
        self.update();
    }

    /// Makes the picture show the work.
    pub(super) fn update(&mut self) {
        let spec = Spec::of(&self.work);
        let seen = (self.work.camera, self.work.quality);
        let is_same_view = self.seen.replace(seen) == Some(seen);
        if self.asked.is_none() && is_same_view && spec.same_picture(&self.built.spec) {
            return; // what is picked, say, is none of the picture's business
        }
        self.touch();
        self.relight_preview();
        if self.asked.is_none() && spec.same_primitives(&self.built.spec) {
            self.built = Arc::new(self.built.relit(spec));
            if self.work.fitted {
                self.fit();
            }
            return;
        }
        if spec.is_small() {
            self.builder.cancel();
            self.asked = None;
            match self.maker.build(spec) {
                Ok(built) => self.accept(built),
                Err(error) => self.give_up_frame(&error),
            }
        } else if !self.asked.as_ref().is_some_and(|asked| asked.same_primitives(&spec)) {
            self.builder.ask(spec.clone());
            self.asked = Some(spec);
        }
    }

    /// Shows a scene that was made.
    fn accept(&mut self, built: Built) {
        self.touch();
        // Light may have changed while it was made.
        let built = built.relit(Spec::of(&self.work).with_primitives_of(&built.spec));
        // Of other frames it may not be so; that was asked for.
        if built.spec.selects_anew(&self.built.spec) {
            for flag in &built.scene.unmatched {
                self.complain(format!("{flag}: there is no such atom."));
            }
        }
        // A view that followed every frame would tremble.
        let is_next_frame = built.spec.differs_by_frames(&self.built.spec);
        self.work.scene.pose = if built.drawn.is_empty() { None } else { Some(built.scene.pose) };
        self.built = Arc::new(built);
        if !self.work.layers.is_empty() {
            self.preview = None;
        }
        picking::keep_what_is_there(self);
        if self.work.fitted && !is_next_frame {
            self.fit();
        } else {
            let scene = Arc::clone(self.scene());
            self.work.camera.fit_depths(&scene);
        }
        if let Some(viewpoint) = self.options.viewpoint.take() {
            self.work.camera = viewpoint.camera(&self.built.scene);
            self.work.fitted = false;
        }
        self.touch();
    }

    /// Says why there is no picture of what was asked for, and stops playing: a damaged frame would be met in every round.
    fn give_up_frame(&mut self, error: &Error) {
        self.playing.on = false;
        self.drop_preview(None);
        self.complain(error.to_string());
    }

    /// The camera that has everything in the picture.
    pub(super) fn fit(&mut self) {
        let scene = self.fitted_scene();
        let is_other = self.work.scene.perspective != scene.perspective;
        let mut camera = scene.fitted_camera(self.view_px[0] as f32 / self.view_px[1] as f32);
        if is_other {
            camera = camera.with_toggled_projection(crate::scene::fit::FOV_Y_RAD);
        }
        if let Some(preview) = &self.preview {
            preview.reach(&mut camera);
        }
        self.work.camera = camera;
        self.touch();
    }

    /// Follows the window to a new size.
    pub(super) fn set_view_px(&mut self, size: [u32; 2]) {
        let size = size.map(|side| side.max(1));
        if size != self.view_px {
            self.view_px = size;
            self.touch();
            if self.work.fitted {
                self.fit();
            }
        }
    }

    /// Shows the next frame if it is its time; in how many seconds it is, if frames are played.
    pub(super) fn play(&mut self, now: Instant) -> Option<f64> {
        if !self.playing.on {
            return None;
        }
        let pause = 1.0 / f64::from(self.playing.speed);
        let since = self.playing.last.map_or(pause, |last| (now - last).as_secs_f64());
        // A frame that is still being made is waited for, not skipped.
        if since < pause || self.is_building() {
            return Some((pause - since).max(0.002));
        }
        self.playing.last = Some(now);
        let before = self.work.layers.clone();
        // Played frames are nothing to undo.
        match self.playing.at_end {
            AtEnd::Bounce => self.bounce(),
            AtEnd::Stop | AtEnd::Loop => self.step(1),
        }
        self.update();
        let is_at_end = |layer: &Layer| layer.frame + 1 == layer.document.frame_count();
        let is_over = self.playing.at_end == AtEnd::Stop && self.work.layers.iter().all(is_at_end);
        if self.work.layers == before || is_over {
            self.playing.on = false;
            return None;
        }
        Some(pause)
    }

    /// The effort of a finished picture.
    pub(super) fn fine(&self, quality: Quality) -> Settings {
        // What is gone soon is not worth light from afar, for which the file would have to wait.
        let quality = if self.preview.is_some() { Quality::Draft } else { quality };
        let settings = quality.settings();
        if self.work.scene.depth_of_field.is_some() { settings.through_lens() } else { settings }
    }

    /// What saved files are called after: the first file.
    pub(super) fn stem(&self) -> String {
        let first = self.work.layers.first().map(|layer| layer.source.name());
        let name = first.unwrap_or_else(|| "ballstick".to_owned());
        Path::new(&name).file_stem().map_or(name.clone(), |stem| stem.to_string_lossy().into_owned()).to_lowercase()
    }
}

/// So long after the last change the picture is at rest (chosen: longer than the pauses between two notches of a wheel).
const REST: Duration = Duration::from_millis(120);
/// The nearest that zooming brings the target, ångström: half an atom fills the window.
pub(super) const NEAREST: f32 = 0.5;

#[cfg(test)]
pub(super) mod tests;
