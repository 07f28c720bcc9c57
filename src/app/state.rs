//! The state of the window, and the only way to change it: [`State::apply`].
//!
//! Nothing here knows windows, pixels on a screen or egui, so that keys, panel, palette and tests drive the same thing.

use super::action::Action;
use super::build::{Builder, Built, Maker, Spec, Waker};
use super::history::History;
use super::loader::{Loaded, Loader, SAMPLES};
use super::preferences::Preferences;
use super::work::{AtomKey, Layer, Source, Work};
use super::{Options, navigate, pictures, picking, sessions};
use crate::error::Error;
use crate::render::View;
use crate::scene::{AtomPlace, Camera, Measurement};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

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
    Quit,
}

/// What is open on the screen beside the molecule.
#[derive(Debug, Default)]
pub(super) struct Shown {
    pub(super) palette: bool,
    pub(super) keys: bool,
    pub(super) picture: Option<pictures::Dialog>,
    /// The path to save a session to, as it is being typed.
    pub(super) session: Option<String>,
    /// The path to open, as it is being typed, where the system has no dialog.
    pub(super) open: Option<String>,
}

/// How frames are played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Playing {
    pub(super) on: bool,
    /// Frames a second.
    pub(super) speed: f32,
    pub(super) loops: bool,
    /// When the frame that is shown was asked for.
    pub(super) last: Option<Instant>,
}

/// All of it.
pub(super) struct State {
    pub(super) work: Work,
    pub(super) history: History,
    pub(super) built: Arc<Built>,
    pub(super) preferences: Preferences,
    pub(super) shown: Shown,
    pub(super) playing: Playing,
    /// Whether clicks gather atoms to measure.
    pub(super) measuring: bool,
    pub(super) notices: Vec<Notice>,
    pub(super) requests: Vec<Request>,
    pub(super) options: Options,
    pub(super) pictures: pictures::Pictures,
    pub(super) loader: Loader,
    /// What a session that is being opened still has to put in place when its files are read.
    pub(super) opening: Option<sessions::Opening>,
    maker: Arc<Maker>,
    builder: Builder,
    /// The specification that the builder works on.
    asked: Option<Spec>,
    /// Width and height of the view in pixels.
    pub(super) view_px: [u32; 2],
    /// Counts changes of the picture.
    pub(super) version: u64,
}

impl State {
    /// With nothing open; `wake` is called from other threads when there is something new.
    pub(super) fn new(options: Options, preferences: Preferences, wake: Waker) -> State {
        let maker = Arc::new(Maker::default());
        let work = Work {
            layers: Vec::new(),
            scene: options.scene.clone(),
            crystal: options.crystal,
            cell_box: options.cell_box,
            quality: options.quality,
            picked: Arc::default(),
            measurements: Vec::new(),
            camera: crate::scene::Scene::from_blocks(Vec::new(), Vec::new()).fitted_camera(1.5),
            fitted: true,
        };
        State {
            built: Arc::new(Built::empty(&work)),
            work,
            history: History::default(),
            preferences,
            shown: Shown::default(),
            playing: Playing { on: false, speed: 12.0, loops: true, last: None },
            measuring: false,
            notices: Vec::new(),
            requests: Vec::new(),
            pictures: pictures::Pictures::new(Arc::clone(&wake)),
            loader: Loader::new(Arc::clone(&maker), Arc::clone(&wake)),
            opening: None,
            builder: Builder::start(Arc::clone(&maker), wake),
            maker,
            asked: None,
            view_px: [960, 640],
            version: 1,
            options,
        }
    }

    /// The view on the screen.
    pub(super) fn view(&self) -> View {
        View::new(self.work.camera, self.view_px[0], self.view_px[1])
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

    /// Does something.
    pub(super) fn apply(&mut self, action: Action) {
        let before = self.work.clone();
        let (name, merges_as) = (action.name(), action.merges_as());
        let is_time_travel = matches!(action, Action::Undo | Action::Redo);
        self.perform(action);
        if self.work != before {
            if !is_time_travel {
                self.history.push(before, name, merges_as);
            }
            self.update();
        }
    }

    fn perform(&mut self, action: Action) {
        let work = &mut self.work;
        match action {
            Action::OpenDialog => self.requests.push(Request::Open),
            Action::Open(path) => self.open(path),
            Action::OpenSample(number) => {
                if let Some(sample) = SAMPLES.get(number) {
                    self.loader.start(Source::Sample(sample.name), self.work.crystal, None);
                }
            }
            Action::Reload => self.reload(),
            Action::Add(layer) => {
                // In the order in which they were asked for, whichever was read first.
                let at = work.layers.partition_point(|other| other.id < layer.id);
                work.layers.insert(at, *layer);
            }
            Action::Replace(layer) => {
                if let Some(old) = work.layers.iter_mut().find(|old| old.id == layer.id) {
                    *old = *layer;
                }
            }
            Action::Close(id) => {
                work.layers.retain(|layer| layer.id != id);
                self.forget_closed();
            }
            Action::CloseAll => {
                work.layers.clear();
                self.forget_closed();
            }
            Action::ShowLayer(id, visible) => {
                work.layers.iter_mut().filter(|layer| layer.id == id).for_each(|layer| layer.visible = visible);
            }
            Action::Quit => self.requests.push(Request::Quit),
            Action::ResetView => {
                work.fitted = true;
                self.fit();
            }
            Action::Center => {
                let point = picking::middle(self).unwrap_or_else(|| self.built.scene.bounds().center());
                self.center_on(point);
            }
            Action::CenterOn(point) => self.center_on(point),
            Action::Camera(camera) => self.move_camera(|old| *old = camera),
            Action::Turn(right, up) => {
                let upright = self.built.scene.ground.is_some();
                self.move_camera(|camera| {
                    // Twelve steps are half a turn.
                    navigate::orbit(camera, f32::from(right), -f32::from(up), 12.0, upright);
                });
            }
            Action::Move(right, up) => {
                let height = self.view_px[1];
                let step = height as f32 / 20.0;
                self.move_camera(|camera| navigate::pan(camera, f32::from(right) * step, -f32::from(up) * step, height));
            }
            Action::Zoom(steps) => {
                let height = self.view_px[1];
                self.move_camera(|camera| navigate::zoom(camera, f32::from(steps), [0.0; 2], height, NEAREST));
            }
            Action::Perspective(on) if on != work.scene.perspective => {
                work.scene.perspective = on;
                work.camera = work.camera.with_toggled_projection(crate::scene::fit::FOV_Y_RAD);
            }
            Action::Perspective(_) => {}
            Action::Style(style) => work.scene.style = style,
            Action::ColorBy(by) => work.scene.color_by = by,
            Action::Look(look) => {
                // The background of a look goes with it unless another one was chosen.
                let of_old = crate::scene::Background::Color(work.scene.look.background());
                if work.scene.background == of_old {
                    work.scene.background = crate::scene::Background::Color(look.background());
                }
                work.scene.look = look;
            }
            Action::Background(background) => work.scene.background = background,
            Action::Ground(on) => work.scene.ground = on,
            Action::Axes(on) => work.scene.axes = on,
            Action::Labels(labels) => work.scene.text.labels = labels,
            Action::LabelSize(size) => work.scene.text.size = size.clamp(0.2, 5.0),
            Action::Legend(on) => work.scene.text.legend = on,
            Action::ScaleBar(on) => work.scene.text.scale_bar = on,
            Action::Hydrogens(on) => work.scene.hydrogens = on,
            Action::Water(on) => work.scene.water = on,
            Action::Aromatic(how) => work.scene.aromatic = how,
            Action::Haptic(on) => work.scene.haptic = on,
            Action::Bonds(mode) => work.crystal.bonds.mode = mode,
            Action::HydrogenBonds(on) => work.crystal.bonds.hydrogen_bonds = on,
            Action::Cell(choice) => work.crystal.cell = choice,
            Action::Supercell(counts) => work.crystal.supercell = counts.map(|count| count.clamp(1, 100)),
            Action::CellBox(on) => work.cell_box = on,
            Action::Quality(quality) => work.quality = quality,
            Action::Pick(key) => picking::pick(self, key),
            Action::PickAlso(key) => picking::toggle(self, key),
            Action::PickAll => picking::all(self),
            Action::PickNone => work.picked = Arc::default(),
            Action::PickMore => picking::more(self),
            Action::Measuring(on) => {
                self.measuring = on;
                self.work.picked = Arc::default();
            }
            Action::Measure => self.measure(),
            Action::ForgetMeasurement(index) if index < work.measurements.len() => {
                work.measurements.remove(index);
            }
            Action::ForgetMeasurement(_) => {}
            Action::ForgetMeasurements => work.measurements.clear(),
            Action::Frame(id, frame) => {
                for layer in work.layers.iter_mut().filter(|layer| layer.id == id) {
                    layer.frame = frame.min(layer.document.frame_count().saturating_sub(1));
                }
            }
            Action::Step(by) => self.step(by),
            Action::FirstFrame => self.go_to(|_| 0),
            Action::LastFrame => self.go_to(|count| count - 1),
            Action::Play(on) => {
                self.playing.on = on && self.work.frame_count() > 1;
                self.playing.last = None;
            }
            Action::Speed(speed) => self.playing.speed = speed.clamp(0.5, 60.0),
            Action::Loop(on) => self.playing.loops = on,
            Action::Screenshot => pictures::quick(self),
            Action::PictureDialog(on) => {
                self.shown.picture = on.then(|| pictures::Dialog::new(self));
            }
            Action::SessionDialog(on) => self.shown.session = on.then(|| sessions::proposed(self)),
            Action::SaveSession(path) => sessions::save(self, &path),
            Action::CopyCommand => {
                let text = sessions::command_line(self);
                self.requests.push(Request::Copy(text));
                self.say("The command line that makes this picture is on the clipboard.");
            }
            Action::Undo => {
                if let Some(old) = self.history.undo(&self.work) {
                    self.travel(old);
                }
            }
            Action::Redo => {
                if let Some(new) = self.history.redo(&self.work) {
                    self.travel(new);
                }
            }
            Action::Palette(on) => self.shown.palette = on,
            Action::Keys(on) => self.shown.keys = on,
            Action::Panel(on) => self.prefer(|preferences| preferences.panel = on),
            Action::Theme(theme) => self.prefer(|preferences| preferences.theme = theme),
            Action::Mouse(preset) => self.prefer(|preferences| preferences.mouse = preset),
            Action::Escape => self.escape(),
        }
    }

    fn prefer(&mut self, change: impl FnOnce(&mut Preferences)) {
        change(&mut self.preferences);
        self.preferences.save();
    }

    /// Takes a state of the history.
    fn travel(&mut self, work: Work) {
        self.work = work;
        if self.work.fitted {
            self.fit();
        }
    }

    fn escape(&mut self) {
        let shown = &mut self.shown;
        if shown.palette || shown.keys {
            (shown.palette, shown.keys) = (false, false);
        } else if shown.picture.is_some() || shown.session.is_some() || shown.open.is_some() {
            (shown.picture, shown.session, shown.open) = (None, None, None);
        } else if !self.loader.under_way().is_empty() {
            self.cancel();
        } else if self.measuring {
            self.measuring = false;
            self.work.picked = Arc::default();
        } else if !self.work.picked.is_empty() {
            self.work.picked = Arc::default();
        } else {
            self.notices.clear();
        }
    }

    /// Gives up what is being read or made.
    pub(super) fn cancel(&mut self) {
        self.loader.cancel();
        self.builder.cancel();
        self.opening = None;
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

    fn open(&mut self, path: PathBuf) {
        if sessions::is_session(&path) {
            sessions::open(self, &path);
        } else {
            self.loader.start(Source::File(path), self.work.crystal, None);
        }
    }

    fn reload(&mut self) {
        for layer in &self.work.layers {
            if let Source::File(_) = layer.source {
                self.loader.start(layer.source.clone(), self.work.crystal, Some(layer.id));
            }
        }
    }

    /// Takes in what other threads have finished.
    pub(super) fn poll(&mut self) {
        for (loaded, replaces) in self.loader.finished() {
            self.take_in(loaded, replaces);
        }
        if let Some(done) = self.builder.take() {
            let asked = self.asked.take();
            match done {
                Ok(built) => {
                    // Something newer may have been asked for in the meantime; it comes next.
                    if self.builder.is_busy() {
                        self.asked = asked;
                    }
                    self.accept(built);
                }
                Err(error) => self.complain(error.to_string()),
            }
        }
        pictures::poll(self);
    }

    /// Takes in all that is being read, waiting for it: for what comes before the first picture.
    pub(super) fn wait_for_files(&mut self) {
        for (loaded, replaces) in self.loader.wait() {
            self.take_in(loaded, replaces);
        }
    }

    fn take_in(&mut self, loaded: Loaded, replaces: Option<u32>) {
        let Loaded { load, source, result } = loaded;
        let document = match result {
            Ok(document) => document,
            Err(error) => {
                let named = match (&error, &source) {
                    // Its message names the file.
                    (Error::Io { .. }, _) => error.to_string(),
                    _ => format!("{}: {error}", source.name()),
                };
                sessions::failed(self);
                return self.complain(named);
            }
        };
        if let Source::File(path) = &source {
            self.preferences.opened(path);
        }
        for diagnostic in document.diagnostics.iter().filter(|d| d.severity == crate::structure::Severity::Error) {
            self.complain(format!("{}: {diagnostic}", source.name()));
        }
        match replaces.and_then(|id| self.work.layer(id).cloned()) {
            Some(old) => {
                let frame = old.frame.min(document.frame_count().saturating_sub(1));
                self.apply(Action::Replace(Box::new(Layer { document, frame, ..old })));
            }
            None => {
                let layer = Layer { id: load, source, document, frame: 0, visible: true };
                if sessions::arrived(self, &layer) {
                    return;
                }
                self.apply(Action::Add(Box::new(layer)));
                self.measure_as_asked();
            }
        }
    }

    /// Measures what the command line asks for, once all its files are there.
    fn measure_as_asked(&mut self) {
        if !self.loader.under_way().is_empty() {
            return;
        }
        let layers: Vec<u32> = self.work.layers.iter().map(|layer| layer.id).collect();
        for Measurement { atoms } in std::mem::take(&mut self.options.measurements) {
            let key = |place: &AtomPlace| {
                Some(AtomKey { layer: *layers.get(place.item as usize)?, atom: place.atom })
            };
            self.work.measurements.extend(atoms.iter().map(key).collect::<Option<Vec<AtomKey>>>());
        }
        self.update();
    }

    /// Makes the picture show the work.
    pub(super) fn update(&mut self) {
        self.version += 1;
        let spec = Spec::of(&self.work);
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
                Err(error) => self.complain(error.to_string()),
            }
        } else if !self.asked.as_ref().is_some_and(|asked| asked.same_primitives(&spec)) {
            self.builder.ask(spec.clone());
            self.asked = Some(spec);
        }
    }

    /// Shows a scene that was made.
    fn accept(&mut self, built: Built) {
        self.version += 1;
        // Light may have changed while it was made.
        let built = built.relit(Spec::of(&self.work).with_primitives_of(&built.spec));
        self.work.scene.pose = if built.drawn.is_empty() { None } else { Some(built.scene.pose) };
        self.built = Arc::new(built);
        picking::keep_what_is_there(self);
        if self.work.fitted {
            self.fit();
        } else {
            self.work.camera.fit_depths(&self.built.scene);
        }
        if let Some(viewpoint) = self.options.viewpoint.take() {
            self.work.camera = viewpoint.camera(&self.built.scene);
            self.work.fitted = false;
        }
    }

    /// The camera that has everything in the picture.
    fn fit(&mut self) {
        self.work.camera = self.built.scene.fitted_camera(self.view_px[0] as f32 / self.view_px[1] as f32);
        if self.work.scene.perspective != self.built.scene.perspective {
            self.work.camera = self.work.camera.with_toggled_projection(crate::scene::fit::FOV_Y_RAD);
        }
        self.version += 1;
    }

    /// Follows the window to a new size.
    pub(super) fn set_view_px(&mut self, size: [u32; 2]) {
        let size = size.map(|side| side.max(1));
        if size != self.view_px {
            self.view_px = size;
            self.version += 1;
            if self.work.fitted {
                self.fit();
            }
        }
    }

    fn move_camera(&mut self, change: impl FnOnce(&mut Camera)) {
        change(&mut self.work.camera);
        self.work.camera.fit_depths(&self.built.scene);
        self.work.fitted = false;
    }

    fn center_on(&mut self, point: glam::Vec3) {
        self.move_camera(|camera| {
            camera.eye += point - camera.target;
            camera.target = point;
        });
    }

    fn forget_closed(&mut self) {
        let open: HashSet<u32> = self.work.layers.iter().map(|layer| layer.id).collect();
        let is_open = |key: &AtomKey| open.contains(&key.layer);
        self.work.measurements.retain(|atoms| atoms.iter().all(is_open));
        if !self.work.picked.iter().all(is_open) {
            self.work.picked = Arc::new(self.work.picked.iter().copied().filter(is_open).collect());
        }
        if self.work.layers.is_empty() {
            self.work.scene.pose = None;
            self.work.fitted = true;
            self.playing.on = false;
        }
    }

    fn measure(&mut self) {
        match self.work.picked.len() {
            2..=4 => {
                let atoms = self.work.picked.to_vec();
                self.work.picked = Arc::default();
                if !self.work.measurements.contains(&atoms) {
                    self.work.measurements.push(atoms);
                }
            }
            _ => {
                self.measuring = !self.measuring;
                self.work.picked = Arc::default();
            }
        }
    }

    fn step(&mut self, by: i32) {
        let loops = self.playing.loops;
        for layer in self.work.layers.iter_mut().filter(|layer| layer.document.frame_count() > 1) {
            let count = layer.document.frame_count() as i64;
            let next = layer.frame as i64 + i64::from(by);
            let next = if loops { next.rem_euclid(count) } else { next.clamp(0, count - 1) };
            layer.frame = usize::try_from(next).unwrap_or(0);
        }
    }

    fn go_to(&mut self, frame_of: impl Fn(usize) -> usize) {
        for layer in self.work.layers.iter_mut().filter(|layer| layer.document.frame_count() > 1) {
            layer.frame = frame_of(layer.document.frame_count());
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
        self.apply(Action::Step(1));
        let is_at_end = |layer: &Layer| layer.frame + 1 == layer.document.frame_count();
        if self.work.layers == before || (!self.playing.loops && self.work.layers.iter().all(is_at_end)) {
            self.playing.on = false;
            return None;
        }
        Some(pause)
    }

    /// The folder that files are saved to unless another one is said: that of the first file, else the current one.
    pub(super) fn stem(&self) -> String {
        let first = self.work.layers.first().map(|layer| layer.source.name());
        let name = first.unwrap_or_else(|| "ballstick".to_owned());
        Path::new(&name).file_stem().map_or(name.clone(), |stem| stem.to_string_lossy().into_owned()).to_lowercase()
    }
}

/// The nearest that zooming brings the target, ångström: half an atom fills the window.
pub(super) const NEAREST: f32 = 0.5;

#[cfg(test)]
pub(super) mod tests;
