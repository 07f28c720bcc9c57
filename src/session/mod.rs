//! Sessions: all that makes a picture, written down as JSON, and as the command line that draws it. Picture files hold theirs
//! ([`mod@picture`]), with the SHA-256 sums of what they were made of ([`sums`]).
//!
//! Every setting has the name of its flag, and stands there even where it is the usual one, so that a session draws the same picture with
//! a later version that has other defaults. Reading is strict: a name, field or number that means nothing is an error that says
//! where. Paths are kept relative to the session's folder where the files lie in or below it, so that both can be moved together.
//!
//! Limits: atoms are kept by number, so a file that was changed may have others there.

mod command;
pub mod picture;
pub mod samples;
pub mod sums;
mod upgrade;

pub use command::Flag;
pub use picture::Picture;

use crate::bonds::{BondMode, BondOptions};
use crate::color::Srgb8;
use crate::crystal::{AssemblyId, BondsPerFrame, CellChoice, CrystalOptions};
use crate::error::{Error, Result};
use crate::export::atomic;
use crate::import::trajectory::Input;
use crate::render::Quality;
use crate::scene::{
    AltlocChoice, Aromatic, Background, BySelection, ColorBy, DepthOfField, LabelContent, LightFrame, Look,
    OverlayOptions, SceneOptions, Style, VectorChoice, Viewpoint,
};
use crate::select::Selection;
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Most bytes of a file that may hold a session: more than pictures of ours have that compress at all (chosen).
const MOST_BYTES: u64 = 1 << 30;

/// The same of what is no regular file (chosen).
const MOST_STREAM_BYTES: u64 = 1 << 26;

/// Most measurements of a session: their numbers are kept from one another's way, which takes the square of them (chosen; nobody reads as many).
const MOST_MEASUREMENTS: usize = 1000;

/// The version of the format that is written, and the newest that is read; what older ones mean says `upgrade`.
pub const VERSION: u32 = 2;

/// A file of a session.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    /// Where it is: a file, `-` for standard input, or `sample:` and the name of one of [`samples`].
    pub path: PathBuf,
    /// Trajectories of its atoms.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trajectories: Vec<PathBuf>,
    /// The frame that is shown, counted from 1 through all records (or in [`Picture::record`]).
    pub frame: u32,
    /// Whether it is shown.
    pub visible: bool,
    /// What its sum was ([`sums`]), if it must be the same file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
}

/// A triangle mesh of a session (`--overlay`).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Overlay {
    /// Where it is.
    pub path: PathBuf,
    /// What its sum was, if it must be the same file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
}

impl File {
    /// What is read.
    #[must_use]
    pub fn input(&self) -> Input {
        Input { structure: self.path.clone(), trajectories: self.trajectories.clone() }
    }
}

/// An atom: the number of its file in the session and its own in what is drawn of that, both from 1.
pub type Atom = [u32; 2];

/// All that makes a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Session {
    /// The version of the format: [`VERSION`].
    pub ballstick_session: u32,
    /// The molecules.
    pub files: Vec<File>,
    /// `--style`.
    pub style: String,
    /// `--style` of selections: `ligand=licorice`.
    #[serde(default)]
    pub styles: Vec<String>,
    /// `--color-by`.
    pub color_by: String,
    /// `--color`: `chain A=#4682b4`.
    #[serde(default)]
    pub color: Vec<String>,
    /// `--show`.
    #[serde(default)]
    pub show: Vec<String>,
    /// `--hide`.
    #[serde(default)]
    pub hide: Vec<String>,
    /// `--ball-scale`.
    pub ball_scale: f32,
    /// `--stick-scale`.
    pub stick_scale: f32,
    /// `--look`.
    pub look: String,
    /// `--light`.
    pub light: String,
    /// `--fog`; `null` for the look's.
    #[serde(default)]
    pub fog: Option<f32>,
    /// `--outline`; `null` for the look's.
    #[serde(default)]
    pub outline: Option<f32>,
    /// `--outline-color`; `null` for the look's.
    #[serde(default)]
    pub outline_color: Option<String>,
    /// `--depth-of-field`; `null` for a picture that is sharp everywhere.
    #[serde(default)]
    pub depth_of_field: Option<f32>,
    /// `--focus`, if there is a depth of field.
    #[serde(default)]
    pub focus: Option<f32>,
    /// `--background`.
    pub background: String,
    /// `--ground`.
    pub ground: bool,
    /// `--projection`.
    pub projection: String,
    /// Where the molecule stands and the camera is (`--camera`); `null` for the fitted view.
    pub camera: Option<String>,
    /// Whether the view follows the shape of the window.
    pub fitted: bool,
    /// `--no-hydrogens` if false.
    pub hydrogens: bool,
    /// `--no-water` if false.
    pub water: bool,
    /// `--no-ions` if false.
    pub ions: bool,
    /// `--altloc`.
    pub altloc: String,
    /// `--aromatic`.
    pub aromatic: String,
    /// `--haptic`.
    pub haptic: bool,
    /// `--vectors`.
    pub vectors: String,
    /// `--vector-scale`; `null` for one that is chosen.
    pub vector_scale: Option<f32>,
    /// `--axes`.
    pub axes: bool,
    /// `--label`.
    pub label: Vec<String>,
    /// `--label-only`.
    #[serde(default)]
    pub label_only: Vec<String>,
    /// `--label-size`.
    pub label_size: f32,
    /// `--legend`.
    pub legend: bool,
    /// `--scale-bar`.
    pub scale_bar: bool,
    /// `--bonds`.
    pub bonds: String,
    /// `--hbonds`.
    pub hbonds: bool,
    /// `--bonds-per-frame`.
    pub bonds_per_frame: String,
    /// `--cell`.
    pub cell: String,
    /// `--supercell`.
    pub supercell: [u32; 3],
    /// `--assembly`; `null` for none.
    #[serde(default)]
    pub assembly: Option<String>,
    /// `--cell-box`, `--no-cell-box`; `null` leaves it to what is drawn.
    pub cell_box: Option<bool>,
    /// `--overlay`.
    #[serde(default)]
    pub overlay: Vec<Overlay>,
    /// `--overlay-opacity`; `null` for the meshes' own.
    #[serde(default)]
    pub overlay_opacity: Option<f32>,
    /// `--overlay-wireframe`.
    #[serde(default)]
    pub overlay_wireframe: bool,
    /// `--overlay-color`; `null` for the meshes' own.
    #[serde(default)]
    pub overlay_color: Option<String>,
    /// `--quality`.
    pub quality: String,
    /// The picked atoms in their order.
    pub picked: Vec<Atom>,
    /// `--measure`: two, three or four atoms each.
    pub measurements: Vec<Vec<Atom>>,
    /// How the picture is made that this session is in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture: Option<Picture>,
}

/// What is in focus where nothing is said.
const FOCUS: f32 = 0.3;

/// A part of the picture's height as flags have it, without the digits that rounding adds.
fn thousandths(part: f32) -> f32 {
    (part * 1e6).round() / 1e3
}

/// The settings of a session as the library knows them.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// What is built.
    pub scene: SceneOptions,
    /// What is drawn of crystals, and how bonds are found.
    pub crystal: CrystalOptions,
    /// Whether the cell's edges are drawn.
    pub cell_box: Option<bool>,
    /// Effort.
    pub quality: Quality,
    /// The view; `None` for the fitted one.
    pub viewpoint: Option<Viewpoint>,
}

impl Session {
    /// With these settings and nothing else.
    #[must_use]
    pub fn of(settings: &Settings) -> Session {
        let Settings { scene, crystal, cell_box, quality, viewpoint } = settings;
        let labels = scene.text.labels;
        let named =
            [("element", labels.element), ("index", labels.index), ("name", labels.name), ("residue", labels.residue)];
        Session {
            ballstick_session: VERSION,
            files: Vec::new(),
            style: scene.style.name().to_owned(),
            styles: scene
                .by_selection
                .styles
                .iter()
                .map(|(atoms, style)| format!("{atoms}={}", style.name()))
                .collect(),
            color_by: scene.color_by.name().to_owned(),
            color: scene.by_selection.colors.iter().map(|(atoms, color)| format!("{atoms}={color}")).collect(),
            show: texts(&scene.by_selection.show),
            hide: texts(&scene.by_selection.hide),
            ball_scale: scene.ball_scale,
            stick_scale: scene.stick_scale,
            look: scene.look.name().to_owned(),
            light: scene.light.name().to_owned(),
            fog: scene.fog,
            outline: scene.outline.map(thousandths),
            outline_color: scene.outline_color.map(|color| color.to_string()),
            depth_of_field: scene.depth_of_field.map(|wanted| thousandths(wanted.blur)),
            focus: scene.depth_of_field.map(|wanted| wanted.focus),
            background: match scene.background {
                Background::Color(color) => color.to_string(),
                Background::Transparent => TRANSPARENT.to_owned(),
            },
            ground: scene.ground,
            projection: if scene.perspective { PERSPECTIVE } else { ORTHOGRAPHIC }.to_owned(),
            camera: viewpoint.map(|viewpoint| viewpoint.to_string()),
            fitted: false,
            hydrogens: scene.hydrogens,
            water: scene.water,
            ions: scene.ions,
            altloc: match scene.altloc {
                AltlocChoice::Highest => "highest".to_owned(),
                AltlocChoice::All => "all".to_owned(),
                AltlocChoice::Code(code) => char::from(code).to_string(),
            },
            aromatic: scene.aromatic.name().to_owned(),
            haptic: scene.haptic,
            vectors: scene.vectors.name().to_owned(),
            vector_scale: scene.vector_scale,
            axes: scene.axes,
            label: named.into_iter().filter(|&(_, on)| on).map(|(name, _)| name.to_owned()).collect(),
            label_only: texts(&scene.by_selection.labels),
            label_size: scene.text.size,
            legend: scene.text.legend,
            scale_bar: scene.text.scale_bar,
            bonds: crystal.bonds.mode.name().to_owned(),
            hbonds: crystal.bonds.hydrogen_bonds,
            bonds_per_frame: crystal.bonds_per_frame.name().to_owned(),
            cell: crystal.cell.name().to_owned(),
            supercell: crystal.supercell,
            assembly: crystal.assembly.map(|id| id.to_string()),
            cell_box: *cell_box,
            overlay: Vec::new(),
            overlay_opacity: scene.overlay_opacity,
            overlay_wireframe: scene.overlay_wireframe,
            overlay_color: scene.overlay_color.map(|color| color.to_string()),
            quality: quality.name().to_owned(),
            picked: Vec::new(),
            measurements: Vec::new(),
            picture: None,
        }
    }

    /// The settings.
    ///
    /// # Errors
    /// [`Error::Input`] that names the field whose value means nothing.
    pub fn settings(&self) -> Result<Settings> {
        let labels = self.labels()?;
        let size = self.label_size;
        if !(0.2..=5.0).contains(&size) {
            return Err(wrong("label_size", &size.to_string(), "a number from 0.2 to 5"));
        }
        if self.vector_scale.is_some_and(|scale| !(scale.is_finite() && scale > 0.0)) {
            return Err(wrong("vector_scale", "this number", "a number above 0"));
        }
        if !self.supercell.iter().all(|count| (1..=10_000).contains(count)) {
            let found = format!("{:?}", self.supercell);
            return Err(wrong("supercell", &found, "three numbers of cells from 1 to 10000"));
        }
        let within = |field: &str, value: Option<f32>, most: f32| match value {
            Some(number) if !(0.0..=most).contains(&number) => {
                Err(wrong(field, &number.to_string(), &format!("a number from 0 to {most}")))
            }
            value => Ok(value),
        };
        let (fog, outline) = (within("fog", self.fog, 1.0)?, within("outline", self.outline, 50.0)?);
        let (blur, focus) = (
            within("depth_of_field", self.depth_of_field.filter(|&blur| blur != 0.0), 200.0)?,
            within("focus", self.focus, 1.0)?,
        );
        let opacity = within("overlay_opacity", self.overlay_opacity, 1.0)?;
        let color = |field: &str, text: &Option<String>| match text {
            None => Ok(None),
            Some(text) => match Srgb8::parse(text) {
                Some(color) if color.a == 255 => Ok(Some(color)),
                _ => Err(wrong(field, text, &format!("#rrggbb, or a name of a colour{}", Srgb8::instead_of(text)))),
            },
        };
        let viewpoint = match &self.camera {
            Some(text) => Some(
                text.parse::<Viewpoint>()
                    .map_err(|error| wrong("camera", text, error.trim_start_matches("expected ")))?,
            ),
            None => None,
        };
        let times = |field: &str, value: f32| match value {
            value if (0.1..=10.0).contains(&value) => Ok(value),
            value => Err(wrong(field, &value.to_string(), "a number from 0.1 to 10")),
        };
        let scene = SceneOptions {
            style: named("style", &self.style, Style::from_name, &Style::ALL.map(Style::name))?,
            color_by: named("color_by", &self.color_by, ColorBy::from_name, &ColorBy::ALL.map(ColorBy::name))?,
            altloc: match (self.altloc.as_str(), self.altloc.as_bytes()) {
                ("highest", _) => AltlocChoice::Highest,
                ("all", _) => AltlocChoice::All,
                (_, &[code]) if code.is_ascii_graphic() => AltlocChoice::Code(code),
                (other, _) => return Err(wrong("altloc", other, "highest, all, or one letter")),
            },
            pose: viewpoint.map(|viewpoint| viewpoint.pose),
            hydrogens: self.hydrogens,
            water: self.water,
            ions: self.ions,
            by_selection: self.by_selection()?,
            ball_scale: times("ball_scale", self.ball_scale)?,
            stick_scale: times("stick_scale", self.stick_scale)?,
            perspective: match self.projection.as_str() {
                PERSPECTIVE => true,
                ORTHOGRAPHIC => false,
                other => return Err(wrong("projection", other, "perspective or orthographic")),
            },
            ground: self.ground,
            background: match (self.background.as_str(), Srgb8::parse(&self.background)) {
                (TRANSPARENT, _) => Background::Transparent,
                (_, Some(color)) if color.a == 255 => Background::Color(color),
                (other, _) => return Err(wrong("background", other, "transparent, #rrggbb, or a name of a colour")),
            },
            haptic: self.haptic,
            text: OverlayOptions { labels, legend: self.legend, scale_bar: self.scale_bar, size },
            look: named("look", &self.look, Look::from_name, &Look::ALL.map(Look::name))?,
            light: named("light", &self.light, LightFrame::from_name, &LightFrame::ALL.map(LightFrame::name))?,
            fog,
            // As the flags have it: to the last bit.
            outline: outline.map(|width| width * 1e-3),
            outline_color: color("outline_color", &self.outline_color)?,
            depth_of_field: blur.map(|blur| DepthOfField { blur: blur * 1e-3, focus: focus.unwrap_or(FOCUS) }),
            aromatic: named("aromatic", &self.aromatic, Aromatic::from_name, &Aromatic::ALL.map(Aromatic::name))?,
            vectors: VectorChoice::from_name(&self.vectors),
            vector_scale: self.vector_scale,
            axes: self.axes,
            overlay_opacity: opacity,
            overlay_wireframe: self.overlay_wireframe,
            overlay_color: color("overlay_color", &self.overlay_color)?,
            ..SceneOptions::default()
        };
        let mode = named("bonds", &self.bonds, BondMode::from_name, &BondMode::ALL.map(BondMode::name))?;
        let per_frame = &BondsPerFrame::ALL.map(BondsPerFrame::name);
        let crystal = CrystalOptions {
            bonds_per_frame: named("bonds_per_frame", &self.bonds_per_frame, BondsPerFrame::from_name, per_frame)?,
            cell: named("cell", &self.cell, CellChoice::from_name, &CellChoice::ALL.map(CellChoice::name))?,
            supercell: self.supercell,
            assembly: self.assembly()?,
            bonds: BondOptions { mode, hydrogen_bonds: self.hbonds, ..BondOptions::default() },
            ..CrystalOptions::default()
        };
        let quality = named("quality", &self.quality, Quality::from_name, &Quality::ALL.map(Quality::name))?;
        Ok(Settings { scene, crystal, cell_box: self.cell_box, quality, viewpoint })
    }

    fn assembly(&self) -> Result<Option<AssemblyId>> {
        let Some(text) = &self.assembly else { return Ok(None) };
        let expected = format!("the id of an assembly, of 1 to {} letters", AssemblyId::MOST);
        AssemblyId::new(text).map(Some).ok_or_else(|| wrong("assembly", text, &expected))
    }

    fn by_selection(&self) -> Result<BySelection> {
        let atoms = |field: &str, text: &str| {
            Selection::parse(text).map_err(|error| Error::input(None, format!("session: {field}: {error}")))
        };
        let all = |field: &str, texts: &[String]| texts.iter().map(|text| atoms(field, text)).collect::<Result<_>>();
        // The last = as in the flags.
        let sides = |field: &str, text: &str| -> Result<(Selection, String)> {
            match text.rsplit_once('=') {
                Some((own, value)) => Ok((atoms(field, own)?, value.trim().to_owned())),
                None => Err(wrong(field, text, "a selection, = and a value")),
            }
        };
        let color = |text: &String| {
            let (atoms, value) = sides("color", text)?;
            match Srgb8::parse(&value) {
                Some(color) if color.a == 255 => Ok((atoms, color)),
                _ => {
                    let expected = format!("#rrggbb, or a name of a colour{}", Srgb8::instead_of(&value));
                    Err(wrong("color", &value, &expected))
                }
            }
        };
        let style = |text: &String| {
            let (atoms, value) = sides("styles", text)?;
            Ok((atoms, named("styles", &value, Style::from_name, &Style::ALL.map(Style::name))?))
        };
        Ok(BySelection {
            show: all("show", &self.show)?,
            hide: all("hide", &self.hide)?,
            colors: self.color.iter().map(color).collect::<Result<_>>()?,
            styles: self.styles.iter().map(style).collect::<Result<_>>()?,
            labels: all("label_only", &self.label_only)?,
        })
    }

    fn labels(&self) -> Result<LabelContent> {
        let mut labels = LabelContent::default();
        for name in &self.label {
            match name.as_str() {
                "element" => labels.element = true,
                "index" => labels.index = true,
                "name" => labels.name = true,
                "residue" => labels.residue = true,
                other => return Err(wrong("label", other, "element, index, name or residue")),
            }
        }
        Ok(labels)
    }

    /// Whether bytes look like a session: a JSON object that says so, or a picture that has one. The first [`HEAD_BYTES`] are enough.
    #[must_use]
    pub fn is_one(bytes: &[u8]) -> bool {
        let start = &bytes[..bytes.len().min(HEAD_BYTES)];
        (start.trim_ascii_start().first() == Some(&b'{') || picture::is_picture(start))
            && start.windows(NAME.len()).any(|window| window == NAME.as_bytes())
    }

    /// Whether a file looks like one. What cannot be read does not.
    #[must_use]
    pub fn is_at(path: &Path) -> bool {
        // To open a pipe waits for its writer, and what is read from it here its reader does not get.
        if !std::fs::metadata(path).is_ok_and(|metadata| metadata.is_file()) {
            return false;
        }
        let Ok(file) = std::fs::File::open(path) else { return false };
        let mut start = Vec::new();
        file.take(HEAD_BYTES as u64).read_to_end(&mut start).is_ok() && Session::is_one(&start)
    }

    /// From JSON; paths are relative to this folder.
    ///
    /// # Errors
    /// [`Error::Input`] with the line and what was expected.
    pub fn parse(bytes: &[u8], folder: &Path) -> Result<Session> {
        #[derive(Deserialize)]
        struct Head {
            ballstick_session: u32,
        }
        let failed = |error: serde_json::Error| {
            let text = error.to_string();
            let message = text.split(" at line ").next().unwrap_or(&text).to_owned();
            Error::input((error.line() > 0).then_some(error.line() as u64), format!("this is no session: {message}"))
        };
        let head: Head = serde_json::from_slice(bytes).map_err(failed)?;
        let bytes = upgrade::upgraded(bytes, head.ballstick_session)?;
        let mut session: Session = serde_json::from_slice(&bytes).map_err(failed)?;
        session.ballstick_session = VERSION;
        for file in &mut session.files {
            if file.frame == 0 {
                return Err(wrong("frame", "0", "a number from 1 on"));
            }
            file.path = found_in(folder, &file.path);
            file.trajectories.iter_mut().for_each(|path| *path = found_in(folder, &*path));
        }
        for mesh in &mut session.overlay {
            mesh.path = found_in(folder, &mesh.path);
        }
        let files = u32::try_from(session.files.len()).unwrap_or(u32::MAX);
        // Of a file with all its records every one counts.
        let has_records = session.picture.as_ref().is_some_and(|picture| picture.record.is_some());
        let most = if has_records { u32::MAX } else { files };
        let is_atom = |&[file, atom]: &Atom| (1..=most).contains(&file) && atom > 0;
        if !session.picked.iter().chain(session.measurements.iter().flatten()).all(is_atom) {
            return Err(wrong(
                "picked or measurements",
                "an atom of no file",
                "pairs of the number of a file and of an atom, from 1",
            ));
        }
        if session.measurements.len() > MOST_MEASUREMENTS {
            let found = session.measurements.len().to_string();
            return Err(wrong("measurements", &found, &format!("at most {MOST_MEASUREMENTS} of them")));
        }
        if !session.measurements.iter().all(|atoms| (2..=4).contains(&atoms.len())) {
            return Err(wrong("measurements", "another number of atoms", "two, three or four atoms each"));
        }
        session.settings()?;
        Ok(session)
    }

    /// Reads a session, or that of a picture.
    ///
    /// # Errors
    /// If the file cannot be read or is no session.
    pub fn read(path: &Path) -> Result<Session> {
        let failed = |source| Error::Io { action: "read", path: path.to_owned(), source };
        let file = std::fs::File::open(path).map_err(failed)?;
        // What is no regular file may have no end.
        let is_regular = file.metadata().is_ok_and(|metadata| metadata.is_file());
        let most = if is_regular { MOST_BYTES } else { MOST_STREAM_BYTES };
        let mut bytes = Vec::new();
        file.take(most + 1).read_to_end(&mut bytes).map_err(failed)?;
        if bytes.len() as u64 > most {
            return Err(Error::limit(None, format!("more than {} MiB are no session", most >> 20)));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        if picture::is_picture(&bytes) { picture::session_in(&bytes, folder) } else { Session::parse(&bytes, folder) }
    }

    /// Keyword and text for a picture in this folder (`None` if it goes to standard output).
    #[must_use]
    pub fn text(&self, folder: Option<&Path>) -> (String, String) {
        let written = self.with_paths_for(folder);
        // Numbers that JSON does not have are refused before: nothing can fail.
        (picture::KEYWORD.to_owned(), serde_json::to_string(&written).unwrap_or_default())
    }

    /// With paths relative to a folder where the files lie in or below it, else absolute.
    fn with_paths_for(&self, folder: Option<&Path>) -> Session {
        let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let folder = folder.map(absolute);
        let kept = |path: &mut PathBuf| {
            if is_file(path) {
                let whole = absolute(path);
                let below = folder.as_ref().and_then(|folder| whole.strip_prefix(folder).ok());
                *path = below.map_or(whole.clone(), Path::to_owned);
            }
        };
        let mut written = self.clone();
        for file in &mut written.files {
            kept(&mut file.path);
            file.trajectories.iter_mut().for_each(kept);
        }
        written.overlay.iter_mut().for_each(|mesh| kept(&mut mesh.path));
        written
    }

    /// Writes a session, whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let place = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let written = self.with_paths_for(place.parent());
        let text = serde_json::to_string_pretty(&written)
            .map_err(|error| Error::Unsupported(format!("the session cannot be written down: {error}")))?;
        atomic::write(path, |out| writeln!(out, "{text}"))
    }
}

/// Bytes of a file that tell whether it is a session: texts stand before the pixels of a picture, after a title at most.
pub const HEAD_BYTES: usize = 4096;

/// Whether a path is that of a file, and not a name for something else.
fn is_file(path: &Path) -> bool {
    path.as_os_str() != "-" && samples::of_path(path).is_none()
}

/// Where the path of a session in this folder leads.
fn found_in(folder: &Path, path: &Path) -> PathBuf {
    if is_file(path) { folder.join(path) } else { path.to_owned() }
}

const NAME: &str = "\"ballstick_session\"";
const TRANSPARENT: &str = "transparent";
const PERSPECTIVE: &str = "perspective";
const ORTHOGRAPHIC: &str = "orthographic";

fn texts(all: &[Selection]) -> Vec<String> {
    all.iter().map(Selection::to_string).collect()
}

fn wrong(field: &str, found: &str, expected: &str) -> Error {
    Error::input(None, format!("session: {field}: found {found}, expected {expected}"))
}

fn named<T>(field: &str, name: &str, from_name: impl Fn(&str) -> Option<T>, all: &[&str]) -> Result<T> {
    from_name(name).ok_or_else(|| wrong(field, &format!("\"{name}\""), &format!("one of {}", all.join(", "))))
}

#[cfg(test)]
mod tests;
