//! Everything a person can do, as values: keys, panel, palette, undo and tests all speak through these.

use super::selecting::{Deed, How};
use super::state::AtEnd;
use super::work::{AtomKey, Layer};
use crate::bonds::BondMode;
use crate::crystal::{AssemblyId, BondsPerFrame, CellChoice};
use crate::import::trajectory::Input;
use crate::render::Quality;
use crate::scene::{Aromatic, Background, Camera, ColorBy, LabelContent, Look, Style};
use glam::Vec3;
use std::path::PathBuf;

/// Something to do.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Action {
    /// Ask for a file to open.
    OpenDialog,
    /// Open a molecule or a session, or a trajectory of what was opened last.
    Open(PathBuf),
    /// Open a molecule with its trajectories.
    OpenInput(Input),
    /// Open the sample of this number.
    OpenSample(usize),
    /// Read all files again.
    Reload,
    /// Add what was read.
    Add(Box<Layer>),
    /// Put what was read anew in the place of what it was.
    Replace(Box<Layer>),
    /// Close one molecule.
    Close(u32),
    CloseAll,
    ShowLayer(u32, bool),
    Quit,

    /// Back to the fitted view.
    ResetView,
    /// Turn about what is picked, or about everything.
    Center,
    CenterOn(Vec3),
    /// The camera after a drag, a turn of the wheel or a key.
    Camera(Camera),
    /// Turn by keys, in steps to the right and up.
    Turn(i8, i8),
    /// Move by keys, in steps to the right and up.
    Move(i8, i8),
    /// Zoom by keys, in steps.
    Zoom(i8),
    Perspective(bool),

    Style(Style),
    ColorBy(ColorBy),
    Look(Look),
    Background(Background),
    Ground(bool),
    Axes(bool),
    Labels(LabelContent),
    LabelSize(f32),
    Legend(bool),
    ScaleBar(bool),
    Hydrogens(bool),
    Water(bool),
    Ions(bool),
    BallScale(f32),
    StickScale(f32),
    Aromatic(Aromatic),
    Haptic(bool),
    Bonds(BondMode),
    HydrogenBonds(bool),
    BondsPerFrame(BondsPerFrame),
    Cell(CellChoice),
    Supercell([u32; 3]),
    /// The assembly that is drawn, or none.
    Assembly(Option<AssemblyId>),
    CellBox(Option<bool>),
    Quality(Quality),

    /// Pick an atom alone, or nothing.
    Pick(Option<AtomKey>),
    /// Add an atom to the picked ones, or take it away.
    PickAlso(AtomKey),
    PickAll,
    PickNone,
    /// From the picked atoms to their residues, from these to their chains, then to all.
    PickMore,
    /// Select in other ways.
    Choose(How),
    /// Do something with what is selected.
    OnPicked(Deed),
    /// Whether clicks gather atoms to measure.
    Measuring(bool),
    /// Keep the distance, angle or dihedral of the picked atoms.
    Measure,
    ForgetMeasurement(usize),
    ForgetMeasurements,

    /// Show a frame (from 0) of a molecule.
    Frame(u32, usize),
    /// Go on or back by frames in all molecules that have several.
    Step(i32),
    FirstFrame,
    LastFrame,
    Play(bool),
    Speed(f32),
    AtEnd(AtEnd),

    /// Save the picture on the screen at once.
    Screenshot,
    PictureDialog(bool),
    AnimationDialog(bool),
    /// Give up the films that are being made.
    StopAnimations,
    /// Put the picture on the clipboard.
    CopyPicture,
    SessionDialog(bool),
    SaveSession(PathBuf),
    CopyCommand,

    Undo,
    Redo,
    Palette(bool),
    Keys(bool),
    Panel(bool),
    Theme(super::preferences::Theme),
    Mouse(super::mouse::Preset),
    /// Whether files that change are read again by themselves.
    Reloads(bool),
    /// Give up what is being read or made.
    Cancel,
    /// Leave what is going on: a dialog, measuring, loading, the picked atoms.
    Escape,
}

impl Action {
    /// Changes of one kind that follow one another are undone as one.
    pub(super) fn merges_as(&self) -> Option<&'static str> {
        match self {
            Action::Camera(_) | Action::Turn(..) | Action::Move(..) | Action::Zoom(_) => Some("view"),
            Action::Frame(..) | Action::Step(_) => Some("frame"),
            Action::Background(_) => Some("background"),
            Action::LabelSize(_) => Some("label size"),
            Action::BallScale(_) | Action::StickScale(_) => Some("sizes"),
            Action::OnPicked(Deed::Color(_)) => Some("colour of selected atoms"),
            _ => None,
        }
    }

    /// What undoing it says.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Action::Add(_) => "open",
            Action::Replace(_) => "reload",
            Action::Close(_) | Action::CloseAll => "close",
            Action::ShowLayer(..) => "show or hide",
            Action::ResetView
            | Action::Center
            | Action::CenterOn(_)
            | Action::Camera(_)
            | Action::Turn(..)
            | Action::Move(..)
            | Action::Zoom(_) => "view",
            Action::Perspective(_) => "projection",
            Action::Style(_) => "representation",
            Action::ColorBy(_) => "colours",
            Action::Look(_) => "light",
            Action::Background(_) => "background",
            Action::Ground(_) => "ground",
            Action::Axes(_) => "axes",
            Action::Labels(_) | Action::LabelSize(_) | Action::Legend(_) | Action::ScaleBar(_) => "text",
            Action::BallScale(_) | Action::StickScale(_) => "sizes",
            Action::Hydrogens(_) | Action::Water(_) | Action::Ions(_) => "atoms shown",
            Action::OnPicked(deed) => match deed {
                Deed::Hide | Deed::ShowOnly | Deed::ShowAll => "atoms shown",
                Deed::Color(_) => "colour of selected atoms",
                Deed::Style(_) => "style of selected atoms",
                Deed::Label => "labels of selected atoms",
                Deed::Forget(..) | Deed::ForgetAll => "what selections say",
            },
            Action::Aromatic(_)
            | Action::Haptic(_)
            | Action::Bonds(_)
            | Action::HydrogenBonds(_)
            | Action::BondsPerFrame(_) => "bonds",
            Action::Cell(_) | Action::Supercell(_) | Action::CellBox(_) => "cell",
            Action::Assembly(_) => "assembly",
            Action::Quality(_) => "quality",
            Action::Pick(_)
            | Action::PickAlso(_)
            | Action::PickAll
            | Action::PickNone
            | Action::PickMore
            | Action::Choose(_) => "selection",
            Action::Measure | Action::ForgetMeasurement(_) | Action::ForgetMeasurements => "measurement",
            Action::Frame(..) | Action::Step(_) | Action::FirstFrame | Action::LastFrame => "frame",
            _ => "change",
        }
    }
}
