//! From the work to a scene, at once for small molecules and on a thread for large ones.

use super::loader::guarded;
use super::work::Work;
use crate::crystal::{self, CrystalOptions, Drawn};
use crate::error::{Error, Result};
use crate::import::Document;
use crate::render::Picker;
use crate::scene::{Item, Scene, SceneOptions};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Tells the window that there is something for it; called from other threads.
pub(super) type Waker = Arc<dyn Fn() + Send + Sync>;

/// Scenes of up to so many atoms are made at once: about 10 ms of a core.
const AT_ONCE: usize = 8_000;
/// What is drawn of frames is kept for so many of them, as long as it has no more atoms than this in all.
const KEPT: (usize, usize) = (64, 2_000_000);

/// A file's number, what is in it, and the frame that is shown.
type Layer = (u32, Arc<Document>, usize);

/// All that decides on the primitives of a scene.
#[derive(Clone)]
pub(super) struct Spec {
    layers: Vec<Layer>,
    /// The places of their files among all, from 1.
    files: Vec<u32>,
    scene: SceneOptions,
    crystal: CrystalOptions,
    cell_box: Option<bool>,
}

impl Spec {
    pub(super) fn of(work: &Work) -> Spec {
        let layers = work.shown().map(|layer| (layer.id, Arc::clone(&layer.document), layer.frame)).collect();
        let files = work.layers.iter().zip(1u32..).filter(|(layer, _)| layer.visible).map(|(_, file)| file).collect();
        let scene = SceneOptions { measurements: work.scene_measurements(), ..work.scene.clone() };
        Spec { layers, files, scene, crystal: work.crystal, cell_box: work.cell_box }
    }

    /// Whether a scene of the other has the same primitives, so that only its light may differ.
    pub(super) fn same_primitives(&self, other: &Spec) -> bool {
        let same_layer = |(a, b): (&Layer, &Layer)| a.0 == b.0 && Arc::ptr_eq(&a.1, &b.1) && a.2 == b.2;
        self.layers.len() == other.layers.len()
            && self.layers.iter().zip(&other.layers).all(same_layer)
            && self.files == other.files
            && self.scene.lit_as(&other.scene) == other.scene
            && self.crystal == other.crystal
            && self.cell_box == other.cell_box
    }

    /// Whether selections of the other were asked of something else, frames aside, or are others.
    pub(super) fn selects_anew(&self, other: &Spec) -> bool {
        let same_layer = |(a, b): (&Layer, &Layer)| a.0 == b.0 && Arc::ptr_eq(&a.1, &b.1);
        self.scene.by_selection != other.scene.by_selection
            || self.layers.len() != other.layers.len()
            || !self.layers.iter().zip(&other.layers).all(same_layer)
    }

    /// Whether the picture is the same.
    pub(super) fn same_picture(&self, other: &Spec) -> bool {
        self.same_primitives(other) && self.scene == other.scene
    }

    /// The primitives of another one, in this one's light.
    pub(super) fn with_primitives_of(self, other: &Spec) -> Spec {
        Spec { scene: other.scene.lit_as(&self.scene), ..other.clone() }
    }

    /// The same with the pose that the scene got.
    fn posed(mut self, scene: &Scene) -> Spec {
        self.scene.pose = Some(scene.pose);
        self
    }

    /// Whether it is done in no time.
    pub(super) fn is_small(&self) -> bool {
        let cells = self.crystal.supercell.into_iter().fold(1usize, |all, n| all.saturating_mul(n as usize));
        let atoms =
            |(_, document, _): &Layer| document.records.first().map_or(0, crate::structure::Structure::atom_count);
        self.layers.iter().map(atoms).sum::<usize>().saturating_mul(cells) <= AT_ONCE
    }
}

/// A scene and what it was made from.
pub(super) struct Built {
    pub(super) spec: Spec,
    pub(super) scene: Arc<Scene>,
    pub(super) picker: Arc<Picker>,
    /// What is drawn of each layer, by its id, in the order of the scene's items.
    pub(super) drawn: Vec<(u32, Arc<Drawn>)>,
}

impl Built {
    /// Nothing at all.
    pub(super) fn empty(work: &Work) -> Built {
        let mut scene = Scene::from_blocks(Vec::new(), Vec::new());
        scene.relight(&work.scene);
        let picker = Arc::new(Picker::new(&scene));
        Built { spec: Spec::of(work), scene: Arc::new(scene), picker, drawn: Vec::new() }
    }

    /// The same primitives in the light of other options.
    pub(super) fn relit(&self, spec: Spec) -> Built {
        let mut scene = (*self.scene).clone();
        scene.relight(&spec.scene);
        Built { spec, scene: Arc::new(scene), picker: Arc::clone(&self.picker), drawn: self.drawn.clone() }
    }
}

struct Kept {
    document: Arc<Document>,
    frame: usize,
    crystal: CrystalOptions,
    drawn: Arc<Drawn>,
}

/// Makes scenes; keeps what is drawn of frames.
#[derive(Default)]
pub(super) struct Maker {
    kept: Mutex<Vec<Kept>>,
}

impl Maker {
    /// What is drawn of a frame.
    pub(super) fn drawn(&self, document: &Arc<Document>, frame: usize, crystal: &CrystalOptions) -> Result<Arc<Drawn>> {
        let mut kept = lock(&self.kept);
        let is_it = |one: &Kept| Arc::ptr_eq(&one.document, document) && one.frame == frame && one.crystal == *crystal;
        if let Some(index) = kept.iter().position(is_it) {
            let one = kept.remove(index);
            let drawn = Arc::clone(&one.drawn);
            kept.push(one);
            return Ok(drawn);
        }
        drop(kept);
        let structure = document.at_frame(frame).ok_or_else(|| {
            Error::input(
                None,
                format!("frame {} is asked for, but there are only {}", frame + 1, document.frame_count()),
            )
        })?;
        let drawn = Arc::new(crystal::draw(structure, crystal)?);
        let mut kept = lock(&self.kept);
        let one = Kept { document: Arc::clone(document), frame, crystal: *crystal, drawn: Arc::clone(&drawn) };
        kept.push(one);
        let atoms = |kept: &[Kept]| kept.iter().map(|one| one.drawn.structure.atom_count()).sum::<usize>();
        while kept.len() > 1 && (kept.len() > KEPT.0 || atoms(&kept) > KEPT.1) {
            kept.remove(0);
        }
        Ok(drawn)
    }

    /// The scene of a specification.
    pub(super) fn build(&self, spec: Spec) -> Result<Built> {
        let drawn: Result<Vec<(u32, Arc<Drawn>)>> = (spec.layers.iter())
            .map(|(id, document, frame)| Ok((*id, self.drawn(document, *frame, &spec.crystal)?)))
            .collect();
        let drawn = drawn?;
        let items: Vec<Item<'_>> = (drawn.iter().zip(&spec.files))
            .map(|((_, drawn), &file)| Item { file: Some(file), ..Item::drawn(drawn, spec.cell_box) })
            .collect();
        let scene = Scene::new(&items, &spec.scene);
        let picker = Arc::new(Picker::new(&scene));
        Ok(Built { spec: spec.posed(&scene), scene: Arc::new(scene), picker, drawn })
    }
}

#[derive(Default)]
struct Slot {
    wanted: Option<Spec>,
    /// Counts what was asked for and given up: a scene that was begun before is not wanted any more.
    turn: u64,
    /// Whether the newest scene that was asked for is still to come.
    busy: bool,
    done: Option<Result<Built>>,
    closing: bool,
}

/// A thread that makes the newest of the scenes that were asked for.
pub(super) struct Builder {
    shared: Arc<(Mutex<Slot>, Condvar)>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A panic of the other side leaves plain data behind, which is still good.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Builder {
    /// Starts the thread, which ends with the builder.
    pub(super) fn start(maker: Arc<Maker>, wake: Waker) -> Builder {
        let shared = Arc::new((Mutex::new(Slot::default()), Condvar::new()));
        let theirs = Arc::clone(&shared);
        let run = move || {
            let (slot, turn) = &*theirs;
            loop {
                let mut state = lock(slot);
                let spec = loop {
                    if state.closing {
                        return;
                    }
                    if let Some(spec) = state.wanted.take() {
                        break spec;
                    }
                    state = turn.wait(state).unwrap_or_else(PoisonError::into_inner);
                };
                let begun = state.turn;
                drop(state);
                let done = guarded(|| maker.build(spec));
                let mut state = lock(slot);
                if state.turn == begun {
                    (state.done, state.busy) = (Some(done), false);
                    drop(state);
                    wake();
                }
            }
        };
        // Without a thread nothing is ever built there; the window then says that it still works on it.
        let _ = std::thread::Builder::new().name("scene".to_owned()).spawn(run);
        Builder { shared }
    }

    /// Asks for a scene in place of any that waits.
    pub(super) fn ask(&self, spec: Spec) {
        let mut slot = lock(&self.shared.0);
        slot.turn += 1;
        (slot.wanted, slot.done, slot.busy) = (Some(spec), None, true);
        self.shared.1.notify_one();
    }

    /// Whether something is being made.
    pub(super) fn is_busy(&self) -> bool {
        let slot = lock(&self.shared.0);
        slot.busy || slot.done.is_some()
    }

    /// Forgets what was asked for.
    pub(super) fn cancel(&self) {
        let mut slot = lock(&self.shared.0);
        slot.turn += 1;
        (slot.wanted, slot.done, slot.busy) = (None, None, false);
    }

    /// What is finished, once.
    pub(super) fn take(&self) -> Option<Result<Built>> {
        lock(&self.shared.0).done.take()
    }
}

impl Drop for Builder {
    fn drop(&mut self) {
        lock(&self.shared.0).closing = true;
        self.shared.1.notify_one();
    }
}
