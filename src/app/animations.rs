//! Films to files: a turn of what is seen, or the frames of a trajectory, drawn on a thread of their own while the window goes on.

use super::build::{Maker, Spec, Waker};
use super::pictures::{self, free_name};
use super::state::State;
use super::work::Work;
use crate::error::{Error, Result};
use crate::export::animation::{self, AnimationFormat, AnimationOptions};
use crate::render::{Choice, Quality, Settings, View, select};
use crate::scene::{Background, Camera, Scene};
use crate::session::Session;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

/// The longest side of a film from the window in pixels; larger ones are for `render`.
pub(super) const MOST_SIDE: u32 = 4096;
/// The most frames of a turn.
pub(super) const MOST_FRAMES: u32 = 3600;

/// What a film shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A turn of so many frames.
    Turntable(u32),
    /// Frames from the first to the last, from 1, in steps.
    Frames { first: u32, last: u32, step: u32 },
}

/// What is asked before a film is saved.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dialog {
    pub(super) path: String,
    pub(super) kind: Kind,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) fps: f64,
    pub(super) quality: Quality,
    pub(super) transparent: bool,
}

impl Dialog {
    /// A GIF of the frames, if there are several, else of a turn, as large as the view up to 800 pixels.
    pub(super) fn new(state: &State) -> Dialog {
        let [width, height] = state.view_px;
        // Chosen: what a slide or a page shows; GIFs of whole screens are large.
        let scale = (800.0 / f64::from(width.max(height))).min(1.0);
        let side = |px: u32| ((f64::from(px) * scale).round() as u32).max(16);
        let frames = u32::try_from(state.work.frame_count()).unwrap_or(u32::MAX);
        let kind = if frames > 1 { Kind::Frames { first: 1, last: frames, step: 1 } } else { Kind::Turntable(100) };
        Dialog {
            path: free_name(&state.stem(), "gif", &[]).display().to_string(),
            kind,
            width: side(width),
            height: side(height),
            fps: if frames > 1 { f64::from(state.playing.speed) } else { animation::FPS },
            quality: state.work.quality,
            transparent: state.work.scene.background == Background::Transparent,
        }
    }

    /// How many frames it has.
    pub(super) fn frames(&self) -> u32 {
        match self.kind {
            Kind::Turntable(frames) => frames,
            Kind::Frames { first, last, step } => last.saturating_sub(first) / step.max(1) + 1,
        }
    }

    /// Gives the file the name of another format.
    pub(super) fn set_format(&mut self, format: AnimationFormat) {
        self.path = PathBuf::from(self.path.trim()).with_extension(format.extension()).display().to_string();
    }
}

/// A film that is being made.
pub(super) struct Film {
    pub(super) path: PathBuf,
    /// Frames that are drawn, of so many.
    pub(super) done: Arc<AtomicU32>,
    pub(super) total: u32,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// Films that are being made.
pub(super) struct Films {
    wake: Waker,
    sender: Sender<(PathBuf, Result<()>)>,
    receiver: Receiver<(PathBuf, Result<()>)>,
    pub(super) under_way: Vec<Film>,
}

impl Drop for Films {
    /// A film takes minutes: one that is not finished is given up with the window, and leaves nothing.
    fn drop(&mut self) {
        self.stop();
        for thread in self.under_way.iter_mut().filter_map(|film| film.thread.take()) {
            // It has said what there is to say.
            let _ = thread.join();
        }
    }
}

impl Films {
    pub(super) fn new(wake: Waker) -> Films {
        let (sender, receiver) = channel();
        Films { wake, sender, receiver, under_way: Vec::new() }
    }

    /// Gives up all of them.
    pub(super) fn stop(&self) {
        self.under_way.iter().for_each(|film| film.stop.store(true, Ordering::Relaxed));
    }
}

/// What a thread needs to draw the frames.
struct Job {
    work: Work,
    scene: Arc<Scene>,
    camera: Camera,
    maker: Arc<Maker>,
    choice: Choice,
    settings: Settings,
    session: Session,
    kind: Kind,
    size: [u32; 2],
    fps: f64,
    frames: u32,
}

/// Draws and saves what a dialog asks for.
pub(super) fn save(state: &mut State, dialog: &Dialog) {
    let path = PathBuf::from(dialog.path.trim());
    let Some(format) = AnimationFormat::from_path(&path) else {
        return state.complain(format!("{}: the name of a film ends in .gif, .apng or .mp4", path.display()));
    };
    if state.films.under_way.iter().any(|film| film.path == path) {
        return state.complain(format!("{} is being made already: choose another name.", path.display()));
    }
    let mut work = state.work.clone();
    let mut scene = (*state.built.scene).clone();
    if dialog.transparent {
        (work.scene.background, scene.background) = (Background::Transparent, Background::Transparent);
    }
    let turns = matches!(dialog.kind, Kind::Turntable(_));
    let camera = match turns && work.fitted {
        true => scene.turntable_camera(dialog.width as f32 / dialog.height as f32),
        false => work.camera,
    };
    let settings = state.fine(dialog.quality);
    let described = pictures::Dialog {
        path: dialog.path.clone(),
        width: dialog.width,
        height: dialog.height,
        transparent: dialog.transparent,
        quality: dialog.quality,
        keeps_shape: false,
    };
    let mut session = pictures::described(state, &described, &settings);
    if let Some(picture) = &mut session.picture {
        picture.fps = Some(dialog.fps);
        match dialog.kind {
            Kind::Turntable(frames) => picture.turntable = Some(frames),
            Kind::Frames { first, last, step } => picture.frames = Some(format!("{first}-{last}:{step}")),
        }
    }
    let job = Job {
        work,
        scene: Arc::new(scene),
        camera,
        maker: state.maker(),
        choice: state.options.renderer,
        settings,
        session,
        kind: dialog.kind,
        size: [dialog.width, dialog.height],
        fps: dialog.fps,
        frames: dialog.frames(),
    };
    let (done, stop) = (Arc::new(AtomicU32::new(0)), Arc::new(AtomicBool::new(false)));
    let total = animation::drawn_frames(format, job.frames);
    let (sender, wake) = (state.films.sender.clone(), Arc::clone(&state.films.wake));
    let (counted, stopped, place) = (Arc::clone(&done), Arc::clone(&stop), path.clone());
    let draw = move || {
        let made = super::loader::guarded(|| draw(&job, format, &place, &counted, &stopped));
        // The window may be gone.
        let _ = sender.send((place, made));
        wake();
    };
    match std::thread::Builder::new().name("film".to_owned()).spawn(draw) {
        Ok(thread) => state.films.under_way.push(Film { path, done, total, stop, thread: Some(thread) }),
        Err(error) => state.complain(format!("The system gives no thread to draw on: {error}")),
    }
}

/// Said by a frame that is not drawn any more.
const STOPPED: &str = "stopped";

fn draw(job: &Job, format: AnimationFormat, path: &std::path::Path, done: &AtomicU32, stop: &AtomicBool) -> Result<()> {
    let background = job.work.scene.background;
    let alpha = background == Background::Transparent;
    if alpha && !format.holds_alpha() {
        return Err(Error::Unsupported(
            "mp4 keeps no transparent background; save as gif or apng, or choose a colour".to_owned(),
        ));
    }
    let mut renderer = select(job.choice)?.renderer;
    renderer.load(Arc::clone(&job.scene))?;
    let [width, height] = job.size;
    let options = AnimationOptions {
        size: (width, height),
        frames: job.frames,
        fps: job.fps,
        alpha,
        background: match background {
            Background::Color(color) => color,
            Background::Transparent => crate::color::Srgb8::WHITE,
        },
        texts: pictures::texts(job.session.clone(), &renderer.name(), path),
    };
    let mut work = job.work.clone();
    animation::write(path, format, &options, &mut |index| {
        if stop.load(Ordering::Relaxed) {
            return Err(Error::Unsupported(STOPPED.to_owned()));
        }
        let camera = match job.kind {
            Kind::Turntable(frames) => {
                let part = f64::from(index) / f64::from(frames.max(1));
                job.camera.turned((part * std::f64::consts::TAU) as f32)
            }
            Kind::Frames { first, step, .. } => {
                let frame = (first.saturating_sub(1) + index * step) as usize;
                for layer in work.layers.iter_mut().filter(|layer| layer.document.frame_count() > 1) {
                    layer.frame = frame.min(layer.document.frame_count() - 1);
                }
                let built = job.maker.build(Spec::of(&work))?;
                renderer.load(Arc::clone(&built.scene))?;
                let mut camera = job.camera;
                camera.fit_depths(&built.scene);
                camera
            }
        };
        let image = renderer.image(&View::new(camera, width, height), &job.settings)?;
        done.fetch_add(1, Ordering::Relaxed);
        Ok(image)
    })
}

/// Says which films are there.
pub(super) fn poll(state: &mut State) {
    while let Ok((path, made)) = state.films.receiver.try_recv() {
        state.films.under_way.retain(|film| film.path != path);
        match made {
            Ok(()) => state.say(format!("Saved {}", path.display())),
            Err(Error::Unsupported(why)) if why == STOPPED => {
                state.say(format!("Stopped: {} is not written.", path.display()));
            }
            Err(error) => state.complain(error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::action::Action;
    use crate::app::state::tests::{opened, settle};

    fn small(state: &State, path: PathBuf) -> Dialog {
        let quality = Quality::Draft;
        Dialog { path: path.display().to_string(), width: 32, height: 24, quality, ..Dialog::new(state) }
    }

    #[test]
    fn a_film_of_a_molecule_turns_and_one_of_frames_plays() {
        let folder = tempfile::tempdir().unwrap();
        for (name, frames) in [("caffeine.sdf", None), ("ethane-rotation.xyz", Some(3))] {
            let mut state = opened(&[name]);
            let path = folder.path().join("film.apng");
            let mut dialog = small(&state, path.clone());
            match &mut dialog.kind {
                Kind::Turntable(count) if frames.is_none() => *count = 3,
                Kind::Frames { last, step, .. } if frames.is_some() => (*last, *step) = (5, 2),
                other => panic!("{name}: {other:?}"),
            }
            save(&mut state, &dialog);
            assert_eq!(state.films.under_way.len(), 1);
            settle(&mut state);
            assert!(state.notices.iter().all(|notice| !notice.is_error), "{:?}", state.notices);
            let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
            let reader = png::Decoder::new(file).read_info().unwrap();
            assert_eq!(reader.info().animation_control.unwrap().num_frames, 3);
            let session = Session::read(&path).unwrap();
            let picture = session.picture.unwrap();
            assert_eq!(
                (picture.turntable, picture.frames.is_some()),
                (frames.map_or(Some(3), |_| None), frames.is_some())
            );
            assert!(session.files[0].sha256.is_some());
        }
    }

    #[test]
    fn a_film_that_is_stopped_leaves_nothing_and_wrong_names_are_said() {
        let folder = tempfile::tempdir().unwrap();
        let mut state = opened(&["caffeine.sdf"]);
        let mut dialog = small(&state, folder.path().join("film.gif"));
        dialog.kind = Kind::Turntable(MOST_FRAMES);
        save(&mut state, &dialog);
        state.apply(Action::StopAnimations);
        settle(&mut state);
        assert!(state.notices[0].text.contains("not written"), "{:?}", state.notices);
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
        dialog.path = "film.webm".to_owned();
        save(&mut state, &dialog);
        assert!(state.notices[1].text.contains(".mp4"));
        dialog.set_format(AnimationFormat::Mp4);
        assert_eq!(dialog.path, "film.mp4");
    }
}
