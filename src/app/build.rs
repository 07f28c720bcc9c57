//! From the work to a scene, at once for small molecules and on a thread for large ones.

use super::ahead::Ahead;
use super::loader::guarded;
use super::work::Work;
use crate::crystal::{self, CrystalOptions, Drawn, Fixed};
use crate::error::Result;
use crate::import::Document;
use crate::render::{Hit, Picker, View};
use crate::scene::{Item, Rig, Scene, SceneOptions};
use crate::stop::Stop;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

/// Tells the window that there is something for it; called from other threads.
pub(super) type Waker = Arc<dyn Fn() + Send + Sync>;

/// Scenes of up to so many atoms are made at once: about 10 ms of a core.
const AT_ONCE: usize = 8_000;
/// What is drawn of frames is kept for so many of them, as long as it has no more atoms than this in all.
const KEPT: (usize, usize) = (64, 2_000_000);

/// Molecules of which the bonds in all frames are kept.
const MOST_FIXED: usize = 8;

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

    /// Whether nothing but the frames that are shown is another.
    pub(super) fn differs_by_frames(&self, other: &Spec) -> bool {
        let same_layer = |(a, b): (&Layer, &Layer)| a.0 == b.0 && Arc::ptr_eq(&a.1, &b.1);
        self.layers.len() == other.layers.len()
            && self.layers.iter().zip(&other.layers).all(same_layer)
            && self.layers.iter().zip(&other.layers).any(|(a, b)| a.2 != b.2)
            && self.scene == other.scene
            && self.crystal == other.crystal
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
        let atoms = |(_, document, _): &Layer| {
            let Some(structure) = document.records.first() else { return 0 };
            let assembly = self.crystal.assembly.and_then(|id| structure.assembly(id.as_str()));
            structure.atom_count().saturating_mul(assembly.map_or(1, |assembly| assembly.operations.len()))
        };
        self.layers.iter().map(atoms).sum::<usize>().saturating_mul(cells) <= AT_ONCE
    }
}

/// A scene and what it was made from.
pub(super) struct Built {
    pub(super) spec: Spec,
    pub(super) scene: Arc<Scene>,
    pub(super) picker: Arc<LazyPicker>,
    /// What is drawn of each layer, by its id, in the order of the scene's items.
    pub(super) drawn: Vec<(u32, Arc<Drawn>)>,
}

impl Built {
    /// Nothing at all.
    pub(super) fn empty(work: &Work) -> Built {
        let mut scene = Scene::from_blocks(Vec::new(), Vec::new());
        scene.relight(&work.scene);
        let scene = Arc::new(scene);
        Built { spec: Spec::of(work), picker: LazyPicker::of(&scene), scene, drawn: Vec::new() }
    }

    /// The same primitives in the light of other options.
    pub(super) fn relit(&self, spec: Spec) -> Built {
        let mut scene = (*self.scene).clone();
        scene.relight(&spec.scene);
        Built { spec, scene: Arc::new(scene), picker: Arc::clone(&self.picker), drawn: self.drawn.clone() }
    }
}

/// Finds what is under the pointer; made when it is first asked, which it is not while frames are played.
pub(super) struct LazyPicker {
    scene: Arc<Scene>,
    picker: OnceLock<Picker>,
}

impl LazyPicker {
    fn of(scene: &Arc<Scene>) -> Arc<LazyPicker> {
        Arc::new(LazyPicker { scene: Arc::clone(scene), picker: OnceLock::new() })
    }

    /// As [`Picker::pick`].
    pub(super) fn pick(&self, view: &View, at_px: [f32; 2]) -> Option<Hit> {
        self.picker.get_or_init(|| Picker::new(&self.scene)).pick(view, at_px)
    }
}

struct Kept {
    document: Arc<Document>,
    frame: usize,
    crystal: CrystalOptions,
    drawn: Arc<Drawn>,
}

/// A molecule whose bonds are the same in all frames.
struct KeptFixed {
    document: Arc<Document>,
    record: usize,
    crystal: CrystalOptions,
    fixed: Arc<Fixed>,
}

/// Makes scenes; keeps what is drawn of frames, and what all frames have in common.
#[derive(Default)]
pub(super) struct Maker {
    kept: Mutex<Vec<Kept>>,
    fixed: Mutex<Vec<KeptFixed>>,
    rig: Mutex<Option<Arc<Rig>>>,
    ahead: Ahead,
}

impl Maker {
    /// What is drawn of a frame.
    pub(super) fn drawn(&self, document: &Arc<Document>, frame: usize, crystal: &CrystalOptions) -> Result<Arc<Drawn>> {
        self.drawn_unless(document, frame, crystal, &Stop::never())
    }

    /// The same unless it is given up.
    pub(super) fn drawn_unless(
        &self,
        document: &Arc<Document>,
        frame: usize,
        crystal: &CrystalOptions,
        stop: &Stop,
    ) -> Result<Arc<Drawn>> {
        let mut kept = lock(&self.kept);
        let is_it = |one: &Kept| Arc::ptr_eq(&one.document, document) && one.frame == frame && one.crystal == *crystal;
        if let Some(index) = kept.iter().position(is_it) {
            let one = kept.remove(index);
            let drawn = Arc::clone(&one.drawn);
            kept.push(one);
            return Ok(drawn);
        }
        drop(kept);
        let is_trajectory = !document.trajectories.is_empty();
        let drawn = if document.has_frames() && crystal.bonds_per_frame.is_fixed(is_trajectory) {
            self.drawn_fixed(document, frame, crystal, stop)?
        } else {
            crystal::draw_unless(document.at_frame(frame)?, crystal, stop)?
        };
        let drawn = Arc::new(drawn);
        let mut kept = lock(&self.kept);
        let one = Kept { document: Arc::clone(document), frame, crystal: *crystal, drawn: Arc::clone(&drawn) };
        kept.push(one);
        let atoms = |kept: &[Kept]| kept.iter().map(|one| one.drawn.structure.atom_count()).sum::<usize>();
        if is_trajectory {
            // Frames that are decoded are kept elsewhere, and cost little to draw; two are there for undo and reload.
            let is_its = |one: &Kept| Arc::ptr_eq(&one.document, document);
            while kept.iter().filter(|one| is_its(one)).count() > 2 {
                let Some(first) = kept.iter().position(is_its) else { break };
                kept.remove(first);
            }
        }
        while kept.len() > 1 && (kept.len() > KEPT.0 || atoms(&kept) > KEPT.1) {
            kept.remove(0);
        }
        Ok(drawn)
    }

    /// What is drawn of a frame with the bonds of another one.
    fn drawn_fixed(
        &self,
        document: &Arc<Document>,
        frame: usize,
        crystal: &CrystalOptions,
        stop: &Stop,
    ) -> Result<Drawn> {
        if !document.trajectories.is_empty() {
            let frame = self.ahead.frame(document, frame)?;
            return self.fixed(document, 0, crystal, stop)?.draw((*frame).clone());
        }
        let (record, frame) = document.frame(frame).ok_or_else(|| document.missing(frame))?;
        let frame = document.records[record].frames()[frame].clone();
        self.fixed(document, record, crystal, stop)?.draw(frame)
    }

    fn fixed(
        &self,
        document: &Arc<Document>,
        record: usize,
        crystal: &CrystalOptions,
        stop: &Stop,
    ) -> Result<Arc<Fixed>> {
        let is_it =
            |one: &&KeptFixed| Arc::ptr_eq(&one.document, document) && one.record == record && one.crystal == *crystal;
        if let Some(one) = lock(&self.fixed).iter().find(is_it) {
            return Ok(Arc::clone(&one.fixed));
        }
        let first = document.records.get(record).and_then(|structure| structure.at_frame(0));
        let first = first.ok_or_else(|| document.missing(0))?;
        let fixed = Arc::new(Fixed::new_unless(first, crystal, stop)?);
        let mut all = lock(&self.fixed);
        // Files with other settings, and of other records, are few and far between.
        if all.len() >= MOST_FIXED {
            all.remove(0);
        }
        all.push(KeptFixed { document: Arc::clone(document), record, crystal: *crystal, fixed: Arc::clone(&fixed) });
        Ok(fixed)
    }

    /// What the scene has in common with the one before it, if that is all but positions; else made anew.
    fn rig(&self, items: &[Item<'_>], options: &SceneOptions) -> Arc<Rig> {
        let mut kept = lock(&self.rig);
        if let Some(rig) = kept.as_ref().filter(|rig| rig.fits(items, options)) {
            return Arc::clone(rig);
        }
        let rig = Arc::new(Rig::new(items, options));
        // One that fits no other scene is not worth its memory.
        *kept = rig.fits(items, options).then(|| Arc::clone(&rig));
        rig
    }

    /// How many frames are kept as they are drawn.
    #[cfg(test)]
    pub(super) fn kept_count(&self) -> usize {
        lock(&self.kept).len()
    }

    /// Forgets what was kept of files that are closed.
    pub(super) fn forget(&self, is_open: impl Fn(&Arc<Document>) -> bool) {
        self.ahead.forget(&is_open);
        lock(&self.kept).retain(|one| is_open(&one.document));
        lock(&self.fixed).retain(|one| is_open(&one.document));
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
        let scene = Arc::new(self.rig(&items, &spec.scene).scene(&items, &spec.scene));
        Ok(Built { spec: spec.posed(&scene), picker: LazyPicker::of(&scene), scene, drawn })
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
