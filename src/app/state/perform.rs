//! What each action does.

use super::{AtEnd, NEAREST, Preferences, Request, State};
use crate::app::action::Action;
use crate::app::work::{AtomKey, Source, Work};
use crate::app::{animations, navigate, picking, pictures, selecting, sessions};
use crate::import::trajectory::{self, Input};
use crate::scene::{Background, Camera, fit};
use crate::session::samples::SAMPLES;
use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

impl State {
    /// Does something.
    pub(in crate::app) fn apply(&mut self, action: Action) {
        let before = self.work.clone();
        let (name, merges_as) = (action.name(), action.merges_as());
        let is_time_travel = matches!(action, Action::Undo | Action::Redo);
        self.perform(action);
        if self.work != before {
            if !is_time_travel {
                selecting::follow_files(&before, &mut self.work);
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
            Action::OpenInput(input) => self.read(Source::File(input), None),
            Action::OpenSample(number) => {
                if let Some(sample) = SAMPLES.get(number) {
                    self.read(Source::Sample(sample), None);
                }
            }
            Action::Reload => self.reload(),
            Action::Add(layer) => {
                // In the order in which they were asked for, whichever was read first.
                let at = work.layers.partition_point(|other| other.id < layer.id);
                let pose = self.preview.as_ref().and_then(|preview| preview.pose_of(layer.id));
                work.scene.pose = work.scene.pose.or(pose.filter(|_| work.layers.is_empty()));
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
                let point = picking::middle(self).unwrap_or_else(|| self.scene().bounds().center());
                self.center_on(point);
            }
            Action::CenterOn(point) => self.center_on(point),
            Action::Camera(camera) => self.move_camera(|old| *old = camera),
            Action::Turn(right, up) => {
                let upright = self.scene().ground.is_some();
                self.move_camera(|camera| {
                    // Twelve steps are half a turn.
                    navigate::orbit(camera, f32::from(right), -f32::from(up), 12.0, upright);
                });
            }
            Action::Move(right, up) => {
                let height = self.view_px[1];
                let step = height as f32 / 20.0;
                self.move_camera(|camera| {
                    navigate::pan(camera, f32::from(right) * step, -f32::from(up) * step, height)
                });
            }
            Action::Zoom(steps) => {
                let height = self.view_px[1];
                self.move_camera(|camera| navigate::zoom(camera, f32::from(steps), [0.0; 2], height, NEAREST));
            }
            Action::Perspective(on) if on != work.scene.perspective => {
                work.scene.perspective = on;
                work.camera = work.camera.with_toggled_projection(fit::FOV_Y_RAD);
            }
            Action::Perspective(_) => {}
            Action::Style(style) => work.scene.style = style,
            Action::ColorBy(by) => work.scene.color_by = by,
            Action::Look(look) => {
                // The background of a look goes with it unless another one was chosen.
                let of_old = Background::Color(work.scene.look.background());
                if work.scene.background == of_old {
                    work.scene.background = Background::Color(look.background());
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
            Action::Ions(on) => work.scene.ions = on,
            Action::BallScale(times) => work.scene.ball_scale = times.clamp(0.1, 10.0),
            Action::StickScale(times) => work.scene.stick_scale = times.clamp(0.1, 10.0),
            Action::Aromatic(how) => work.scene.aromatic = how,
            Action::Haptic(on) => work.scene.haptic = on,
            Action::Bonds(mode) => work.crystal.bonds.mode = mode,
            Action::HydrogenBonds(on) => work.crystal.bonds.hydrogen_bonds = on,
            Action::BondsPerFrame(when) => work.crystal.bonds_per_frame = when,
            Action::Cell(choice) => work.crystal.cell = choice,
            Action::Supercell(counts) => work.crystal.supercell = counts.map(|count| count.clamp(1, 100)),
            Action::Assembly(id) => work.crystal.assembly = id,
            Action::CellBox(on) => work.cell_box = on,
            Action::Quality(quality) => work.quality = quality,
            Action::Pick(key) => picking::pick(self, key),
            Action::PickAlso(key) => picking::toggle(self, key),
            Action::PickAll => picking::all(self),
            Action::PickNone => work.picked = Arc::default(),
            Action::PickMore => picking::more(self),
            Action::Choose(how) => selecting::choose(self, how),
            Action::OnPicked(deed) => selecting::act(self, deed),
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
                    layer.frame = layer.document.nearest_frame(frame);
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
            Action::AtEnd(what) => (self.playing.at_end, self.playing.back) = (what, false),
            Action::Screenshot => pictures::quick(self),
            Action::PictureDialog(on) => {
                self.shown.picture = on.then(|| pictures::Dialog::new(self));
            }
            Action::AnimationDialog(on) => {
                self.shown.animation = on.then(|| animations::Dialog::new(self));
            }
            Action::StopAnimations => self.films.stop(),
            Action::CopyPicture if self.work.layers.is_empty() => {}
            Action::CopyPicture => pictures::copy(self),
            Action::SessionDialog(on) => self.shown.session = on.then(|| sessions::proposed(self)),
            Action::SaveSession(path) => sessions::save(self, &path),
            Action::CopyCommand => match sessions::command_line(self) {
                Ok(text) => {
                    self.requests.push(Request::Copy(text));
                    self.say("The command line that makes this picture is on the clipboard.");
                }
                Err(why) => self.complain(why),
            },
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
            Action::Reloads(on) => self.prefer(|preferences| preferences.reloads = on),
            Action::Cancel => self.cancel(),
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
        } else if shown.picture.is_some()
            || shown.animation.is_some()
            || shown.session.is_some()
            || shown.open.is_some()
        {
            (shown.picture, shown.animation, shown.session, shown.open) = (None, None, None, None);
        } else if !self.loader.under_way().is_empty() || self.is_building() {
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

    fn open(&mut self, path: PathBuf) {
        if sessions::is_session(&path) {
            sessions::open(self, &path);
        } else if trajectory::is_trajectory(&path) {
            self.open_trajectory(path);
        } else {
            self.read(Source::of(path), None);
        }
    }

    /// Begins to read a file, in place of a layer or as one more.
    fn read(&mut self, source: Source, replaces: Option<u32>) {
        let preview = self.preview_options().filter(|_| replaces.is_none());
        self.loader.start(source, self.work.crystal, replaces, preview);
    }

    /// A trajectory goes with the last file that was opened, behind the trajectories that this has.
    fn open_trajectory(&mut self, path: PathBuf) {
        let of_file = self.work.layers.iter().rev().find_map(|layer| match &layer.source {
            Source::File(input) if input.structure.as_os_str() != "-" => Some((layer.id, input.clone())),
            _ => None,
        });
        match of_file {
            Some((id, mut input)) => {
                input.trajectories.push(path);
                self.read(Source::File(input), Some(id));
            }
            // It says what is missing.
            None => self.read(Source::File(Input::of(path)), None),
        }
    }

    fn reload(&mut self) {
        for layer in self.work.layers.clone() {
            if let Source::File(_) = layer.source {
                self.read(layer.source, Some(layer.id));
            }
        }
    }

    /// Reads the file of one layer again, which has changed.
    pub(in crate::app) fn reload_one(&mut self, id: u32) {
        if let Some(layer) = self.work.layer(id) {
            self.read(layer.source.clone(), Some(id));
            self.by_itself.insert(id);
        }
    }

    fn move_camera(&mut self, change: impl FnOnce(&mut Camera)) {
        let scene = Arc::clone(self.scene());
        change(&mut self.work.camera);
        self.work.camera.fit_depths(&scene);
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
        let layers = &self.work.layers;
        self.maker.forget(|document| layers.iter().any(|layer| Arc::ptr_eq(&layer.document, document)));
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

    /// On, or back, and the other way at either end, as the molecule with most frames has it.
    pub(super) fn bounce(&mut self) {
        let longest = self.work.layers.iter().max_by_key(|layer| layer.document.frame_count());
        if let Some(layer) = longest {
            let last = layer.document.frame_count().saturating_sub(1);
            self.playing.back = match self.playing.back {
                true => layer.frame > 0,
                false => layer.frame >= last,
            };
        }
        self.step(if self.playing.back { -1 } else { 1 });
    }

    pub(super) fn step(&mut self, by: i32) {
        let loops = self.playing.at_end == AtEnd::Loop;
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
}
