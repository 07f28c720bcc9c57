//! What is seen of a large file while it is being read: a [`Glimpse`] of its atoms, as balls so large that they fill the gaps between them.
//!
//! It stands in an empty window only; where something is open, that stays until the file is there. It is the first file's that was opened, and goes
//! when anything is there to be shown, when that file cannot be read, or when reading is given up. Nobody but the picture on the screen knows it: it is
//! no layer, and none of its atoms can be picked, listed, saved or exported. The molecule comes in the pose of its preview and, if nobody has
//! turned it, fitted anew, so that nothing jumps. Of a file that states a unit cell, which may decide how the molecule stands, it is the molecule's own pose.

use super::state::State;
use crate::crystal::{CellChoice, CrystalOptions};
use crate::import::Glimpse;
use crate::scene::{BySelection, Camera, Item, OverlayOptions, Pose, Scene, SceneOptions, Style};
use std::path::Path;
use std::sync::Arc;

/// A ball is as large as the atoms together that it stands for, and its radius this times more (chosen by eye, of a box of ten million atoms: 0.7 left gaps).
const FILLED: f64 = 1.0;

/// A glimpse of a file that is being read.
pub(super) struct Preview {
    /// The number that the file's layer will have.
    pub(super) load: u32,
    scene: Arc<Scene>,
    /// The same atoms as large as they will be, by which the view is fitted.
    frame: Arc<Scene>,
    /// Whether the molecule will stand as this does.
    is_pose_kept: bool,
    atoms: usize,
    about_atoms: u64,
}

impl Preview {
    /// Of a file that is large enough to be waited for.
    pub(super) fn of_file(load: u32, path: &Path, options: &SceneOptions) -> Option<Preview> {
        Glimpse::of_file(path).map(|glimpse| Preview::of(load, &glimpse, options))
    }

    pub(super) fn of(load: u32, glimpse: &Glimpse, options: &SceneOptions) -> Preview {
        let structure = &glimpse.structure;
        let atoms = structure.atom_count();
        let item = Item { cell_box: structure.cell(), ..Item::of(structure) };
        let frame = Scene::new(&[item], options);
        let times = (glimpse.about_atoms as f64 / atoms.max(1) as f64).max(1.0).cbrt();
        let large = SceneOptions {
            style: Style::SpaceFilling,
            ball_scale: (FILLED * times).max(1.0) as f32,
            pose: Some(frame.pose),
            ..options.clone()
        };
        Preview {
            load,
            scene: Arc::new(Scene::new(&[Item::of(structure)], &large)),
            frame: Arc::new(frame),
            is_pose_kept: structure.cell().is_none(),
            atoms,
            about_atoms: glimpse.about_atoms,
        }
    }

    /// What it is, in words.
    pub(super) fn says(&self) -> String {
        let mut unit = 1;
        while self.about_atoms / unit >= 1000 {
            unit *= 10;
        }
        let about = (self.about_atoms + unit / 2) / unit * unit;
        format!("Preview: {} of about {} atoms", grouped(self.atoms as u64), grouped(about))
    }

    /// Has all of it before and within the camera's depths: its balls reach further than those it is fitted by.
    pub(super) fn reach(&self, camera: &mut Camera) {
        camera.fit_depths(&self.scene);
    }

    /// How the molecule of a layer has to stand so that it stands as this does.
    pub(super) fn pose_of(&self, layer: u32) -> Option<Pose> {
        (self.is_pose_kept && self.load == layer).then_some(self.scene.pose)
    }
}

/// With commas between thousands.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

impl State {
    /// What previews look like; `None` if a file that is opened now has none.
    pub(super) fn preview_options(&self) -> Option<SceneOptions> {
        let CrystalOptions { cell, supercell, assembly, .. } = self.work.crystal;
        let is_as_listed = cell != CellChoice::Full && supercell == [1; 3] && assembly.is_none();
        let is_empty = self.work.layers.is_empty() && self.opening.is_none() && self.preview.is_none();
        (is_empty && is_as_listed).then(|| {
            let (by_selection, text) = (BySelection::default(), OverlayOptions::default());
            SceneOptions { by_selection, text, ..self.work.scene.clone() }
        })
    }

    /// What the window shows.
    pub(super) fn scene(&self) -> &Arc<Scene> {
        self.preview.as_ref().map_or(&self.built.scene, |preview| &preview.scene)
    }

    /// What the view is fitted to.
    pub(super) fn fitted_scene(&self) -> &Scene {
        self.preview.as_ref().map_or(&self.built.scene, |preview| &preview.frame)
    }

    /// Shows a preview if there is nothing else to be seen.
    pub(super) fn show_preview(&mut self, preview: Preview) {
        let is_awaited = self.loader.under_way().iter().any(|load| load.id == preview.load);
        if !is_awaited || self.preview_options().is_none() {
            return;
        }
        self.preview = Some(preview);
        self.relight_preview();
        if self.work.fitted {
            self.fit();
        }
        if let (Some(viewpoint), Some(preview)) = (&self.options.viewpoint, &self.preview) {
            self.work.camera = viewpoint.camera(&preview.scene);
        }
        self.touch();
    }

    /// Takes over light and background.
    pub(super) fn relight_preview(&mut self) {
        if let Some(preview) = &mut self.preview {
            Arc::make_mut(&mut preview.scene).relight(&self.work.scene);
            Arc::make_mut(&mut preview.frame).relight(&self.work.scene);
        }
    }

    /// Takes the preview away, if it is that of a file; there is something better, or nothing.
    pub(super) fn drop_preview(&mut self, of_load: Option<u32>) {
        if self.preview.take_if(|preview| of_load.is_none_or(|load| load == preview.load)).is_some() {
            if self.work.layers.is_empty() {
                self.work.fitted = true;
                self.fit();
            }
            self.touch();
        }
    }
}

#[cfg(test)]
mod tests;
