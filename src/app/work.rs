//! What is worked on: what undo brings back and sessions keep.

use crate::crystal::CrystalOptions;
use crate::import::Document;
use crate::import::trajectory::Input;
use crate::render::Quality;
use crate::scene::{AtomPlace, Camera, Measurement, SceneOptions};
use crate::select::Selection;
use crate::session::samples::{self, Sample};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a molecule comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Source {
    /// A structure, and trajectories of its atoms.
    File(Input),
    /// A molecule that is part of the program.
    Sample(&'static Sample),
}

impl Source {
    /// What a path stands for.
    pub(super) fn of(path: PathBuf) -> Source {
        Source::of_input(Input::of(path))
    }

    /// What a structure with its trajectories stands for.
    pub(super) fn of_input(input: Input) -> Source {
        let sample = samples::of_path(&input.structure).filter(|_| input.trajectories.is_empty());
        sample.map_or(Source::File(input), Source::Sample)
    }

    /// Where it lies; standard input and what is part of the program lie nowhere.
    pub(super) fn path(&self) -> Option<&Path> {
        match self {
            Source::File(input) if input.structure.as_os_str() != "-" => Some(&input.structure),
            _ => None,
        }
    }

    /// What a command line or a session calls it.
    pub(super) fn named(&self) -> PathBuf {
        match self {
            Source::File(input) => input.structure.clone(),
            Source::Sample(sample) => sample.path(),
        }
    }

    /// Whether it cannot be read again.
    pub(super) fn is_gone(&self) -> bool {
        matches!(self, Source::File(input) if input.structure.as_os_str() == "-")
    }

    /// A short name for people.
    pub(super) fn name(&self) -> String {
        match self {
            Source::File(input) => {
                let name = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
                input.files().map(name).collect::<Vec<_>>().join(" + ")
            }
            Source::Sample(sample) => sample.name.to_owned(),
        }
    }
}

/// One file of those that are open.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    /// Tells it from others as long as the window is open.
    pub(super) id: u32,
    pub(super) source: Source,
    pub(super) document: Arc<Document>,
    /// Frames of all records in their order, from 0.
    pub(super) frame: usize,
    pub(super) visible: bool,
}

impl PartialEq for Layer {
    fn eq(&self, other: &Layer) -> bool {
        (self.id, self.frame, self.visible) == (other.id, other.frame, other.visible)
            && Arc::ptr_eq(&self.document, &other.document)
    }
}

/// An atom of what is drawn of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct AtomKey {
    pub(super) layer: u32,
    pub(super) atom: u32,
}

/// The whole of it.
#[derive(Clone, PartialEq)]
pub(super) struct Work {
    pub(super) layers: Vec<Layer>,
    /// Without measurements, which have their atoms by layer here.
    pub(super) scene: SceneOptions,
    /// Where the meshes come from that are laid over the molecule.
    pub(super) overlay: Arc<Vec<PathBuf>>,
    pub(super) crystal: CrystalOptions,
    pub(super) cell_box: Option<bool>,
    pub(super) quality: Quality,
    /// In the order in which they were picked.
    pub(super) picked: Arc<Vec<AtomKey>>,
    /// The words that a list of atoms was picked by; of no meaning once another list is.
    pub(super) picked_by: Option<(Arc<Vec<AtomKey>>, Selection)>,
    pub(super) measurements: Vec<Vec<AtomKey>>,
    pub(super) camera: Camera,
    /// Whether the view is still the fitted one: then it follows the window's shape.
    pub(super) fitted: bool,
}

impl Work {
    /// The layer of an id.
    pub(super) fn layer(&self, id: u32) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.id == id)
    }

    /// The layers that are drawn, in order: the items of the scene.
    pub(super) fn shown(&self) -> impl Iterator<Item = &Layer> {
        self.layers.iter().filter(|layer| layer.visible)
    }

    /// The measurements as the scene knows them; those on hidden layers are left out.
    pub(super) fn scene_measurements(&self) -> Vec<Measurement> {
        let shown: Vec<u32> = self.shown().map(|layer| layer.id).collect();
        let place = |key: &AtomKey| {
            let item = shown.iter().position(|&id| id == key.layer)?;
            Some(AtomPlace { item: u32::try_from(item).ok()?, atom: key.atom })
        };
        let measurement =
            |atoms: &Vec<AtomKey>| Some(Measurement { atoms: atoms.iter().map(place).collect::<Option<_>>()? });
        self.measurements.iter().filter_map(measurement).collect()
    }

    /// Most frames of any layer.
    pub(super) fn frame_count(&self) -> usize {
        self.layers.iter().map(|layer| layer.document.frame_count()).max().unwrap_or(0)
    }
}
