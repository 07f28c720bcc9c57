//! `ballstick convert FILE… -o x.glb`: the scene that `render` would draw, as triangles for other programs.

use super::args::{BondArgs, CrystalArgs, LightArg, LookArg, LookArgs, Named, SelectArgs};
use super::from::Origin;
use super::load::{LoadSeconds, load_as};
use super::render::{Asked, overlay, scene_of};
use super::report::Report;
use super::values::{RecordChoice, positive};
use crate::crystal::Drawn;
use crate::error::Result;
use crate::export::solid::{Coordinates, SolidFormat, SolidOptions, Source, TOLERANCES, Unit, Written, write};
use crate::import::Format;
use crate::import::trajectory::inputs;
use crate::session::Session;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// How thin a printed part may be, millimetres: about what a nozzle of 0.4 mm lays down in two lines.
const LEAST_PRINTED_MM: f64 = 0.8;

/// What stands below the flags of `convert`.
const AFTER_CONVERT: &str = "\
Formats: json, cjson, mmcif, mol2, pdb, sdf, sdf-v3000, xyz, extxyz hold one
molecule file's atoms and bonds; glb, gltf, obj (with mtl), stl, ply hold what would be drawn, with the
same flags as render (those of light, lines and background have no effect).

Examples:
  ballstick convert 1crn.pdb crambin.json
  ballstick convert 1crn.pdb -o crambin.glb --style licorice --color-by residue
  ballstick convert quartz.cif -o quartz.stl --supercell 2x2x2 --scale 5
  ballstick convert session.json -o figure.glb

In STL each ball and stick is a closed shell that reaches into its neighbours;
slicers unite them. An obj has its colours in an mtl of the same name beside it;
one that another program wrote is never replaced.";

/// `ballstick convert`.
#[derive(Debug, Clone, Args)]
#[command(after_help = AFTER_CONVERT)]
pub struct ConvertArgs {
    /// Molecule file, and without -o the file to write behind it; - is standard input and output. For meshes several, all into one
    /// scene, as in render; or one session, or picture that ballstick drew
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// File to write; - is standard output [default: the last FILE]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Format, where the name of OUT does not say, see below
    #[arg(long, value_name = "FORMAT")]
    pub to: Option<String>,
    /// Format of FILE, where neither its content nor its name tells
    #[arg(long, value_name = "FORMAT")]
    pub from: Option<String>,
    /// Meshes.
    #[command(flatten)]
    pub solid: SolidArgs,
    /// Look, of meshes, and which atoms.
    #[command(flatten)]
    pub look: LookArgs,
    /// Bonds.
    #[command(flatten)]
    pub bonds: BondArgs,
    /// Crystal, of meshes.
    #[command(flatten)]
    pub crystal: CrystalArgs,
    /// Record and frame.
    #[command(flatten)]
    pub select: SelectArgs,
    /// What of a session is no flag.
    #[arg(skip)]
    pub origin: Origin,
}

impl ConvertArgs {
    /// What is read, and what is written; `None` if one of them is not named.
    pub(super) fn places(&self) -> Option<(&[PathBuf], &Path)> {
        match (&self.output, self.files.as_slice()) {
            (Some(output), files) => Some((files, output)),
            (None, [files @ .., output]) if !files.is_empty() => Some((files, output)),
            _ => None,
        }
    }

    /// The format of the mesh to write; `None` if it is none.
    pub(super) fn solid_format(&self) -> Option<SolidFormat> {
        match &self.to {
            Some(name) => SolidFormat::from_name(name),
            None => SolidFormat::from_path(self.places()?.1),
        }
    }

    /// The session, or picture with one, that is to become a mesh, and that.
    pub(super) fn session(&self) -> Option<(&Path, &Path)> {
        match self.places()? {
            ([file], output) if self.solid_format().is_some() && Session::is_at(file) => Some((file, output)),
            _ => None,
        }
    }
}

/// Whether `convert` has this flag; the names have no dashes.
pub(super) fn has_flag(name: &str) -> bool {
    use clap::CommandFactory;
    let command = super::args::Cli::command();
    let convert = command.find_subcommand("convert");
    convert.is_some_and(|convert| convert.get_arguments().any(|argument| argument.get_long() == Some(name)))
}

/// How meshes are written.
#[derive(Debug, Clone, Copy, PartialEq, Args)]
pub struct SolidArgs {
    /// How far triangles may be from the true surface, in ångström, 0.0001 to 1; smaller makes more of them
    #[arg(long, value_name = "X", value_parser = tolerance, default_value = "0.004", help_heading = "Mesh")]
    pub tolerance: f32,
    /// What one unit of coordinates is; glTF has it in its extras. (STL is in millimetres, see --scale)
    #[arg(long, value_name = "UNIT", default_value = "angstrom", help_heading = "Mesh")]
    pub unit: UnitArg,
    /// Which coordinates are written
    #[arg(long, value_name = "WHICH", default_value = "file", help_heading = "Mesh")]
    pub coordinates: CoordinatesArg,
    /// Plain meshes in glTF and GLB, for programs that do not know instances (EXT_mesh_gpu_instancing): much larger files
    #[arg(long, help_heading = "Mesh")]
    pub compat: bool,
    /// Millimetres an ångström is long in STL [default: such that the longest side is 100 mm]
    #[arg(long, value_name = "MM", value_parser = print_scale, help_heading = "Mesh")]
    pub scale: Option<f32>,
}

/// `--scale`: from a hundredth of a micrometre to ten metres.
fn print_scale(text: &str) -> Result<f32, String> {
    let scale = positive(text)?;
    if (1e-5..=1e4).contains(&scale) { Ok(scale) } else { Err("expected millimetres from 0.00001 to 10000".to_owned()) }
}

/// `--unit`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum UnitArg {
    /// 1 Å, as overlays are read
    Angstrom,
    /// 10 Å
    Nanometre,
    /// As glTF says; too small for most programs to show
    Metre,
}

/// `--coordinates`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CoordinatesArg {
    /// Those of the molecule's file
    File,
    /// Turned as in the picture (--view, --axis, --camera), y up, the middle at 0
    Picture,
}

fn tolerance(text: &str) -> std::result::Result<f32, String> {
    let (least, most) = (TOLERANCES.start(), TOLERANCES.end());
    let number = text.trim().parse().ok().filter(|x: &f32| TOLERANCES.contains(x));
    number.ok_or_else(|| format!("expected a number of ångström from {least} to {most}, such as 0.01"))
}

impl SolidArgs {
    fn options(&self) -> SolidOptions {
        SolidOptions {
            tolerance: self.tolerance,
            unit: Unit::from_name(&self.unit.name()).unwrap_or_default(),
            compat: self.compat,
            mm_per_angstrom: self.scale.map(f64::from),
            coordinates: Coordinates::from_name(&self.coordinates.name()).unwrap_or_default(),
        }
    }

    /// Whether anything is asked for.
    pub(super) fn is_usual(&self) -> bool {
        self.options() == SolidOptions::default()
    }

    /// Flags that do not count for a format.
    fn without_effect(&self, format: SolidFormat) -> Option<String> {
        let is_gltf = matches!(format, SolidFormat::Glb | SolidFormat::Gltf);
        let is_stl = format == SolidFormat::Stl;
        let flags = [
            ("--compat", self.compat && !is_gltf),
            ("--scale", self.scale.is_some() && !is_stl),
            ("--unit", self.unit != UnitArg::Angstrom && is_stl),
        ];
        let lost: Vec<&str> = flags.into_iter().filter(|(_, lost)| *lost).map(|(name, _)| name).collect();
        let has = if lost.len() > 1 { "have" } else { "has" };
        (!lost.is_empty()).then(|| format!("{} {has} no effect on {}", lost.join(" and "), format.name()))
    }
}

/// Files to one file; what fails is said.
pub(super) fn run(
    args: &ConvertArgs,
    (files, output): (&[PathBuf], &Path),
    format: SolidFormat,
    from: Option<Format>,
    report: &mut Report,
) {
    if let Some(lost) = args.solid.without_effect(format) {
        report.warn(output, &lost);
    }
    report.start(1);
    let mut drawn: Vec<(String, Drawn)> = Vec::new();
    for (index, input) in inputs(files).into_iter().enumerate() {
        // Each file of a session has a frame of its own.
        let frame = args.select.frame.or(args.origin.frames.get(index).copied());
        let select = SelectArgs { frame, ..args.select };
        let load = || {
            let flags = (args.bonds, args.crystal);
            load_as((&input, from), &select, flags, report, &mut LoadSeconds::default())
        };
        match super::guarded(load) {
            Ok(loaded) => {
                let name = input.structure.file_name().unwrap_or_default().to_string_lossy().into_owned();
                drawn.extend(loaded.into_iter().map(|one| (name.clone(), one)));
            }
            Err(error) => report.fail(&input.structure, &error),
        }
    }
    if drawn.is_empty() {
        return; // said above, input by input
    }
    let side_by_side = args.select.record == Some(RecordChoice::All);
    match super::guarded(|| export(args, (drawn, side_by_side), (format, output), report)) {
        Err(error) if !crate::export::atomic::is_broken_pipe(&error) => report.fail(output, &error),
        _ => {}
    }
}

fn export(
    args: &ConvertArgs,
    (drawn, side_by_side): (Vec<(String, Drawn)>, bool),
    (format, output): (SolidFormat, &Path),
    report: &Report,
) -> Result<()> {
    let (names, drawn): (Vec<String>, Vec<Drawn>) = drawn.into_iter().unzip();
    let mut notices = Vec::new();
    let meshes = overlay(&args.look, &mut notices)?;
    let asked = Asked { look: &args.look, crystal: args.crystal, pose: args.origin.pose, meshes, side_by_side };
    let (scene, notes) = scene_of(&drawn, asked)?;
    notices.extend(scene.unmatched.iter().map(|flag| format!("{flag}: there is no such atom")));
    notices.extend(texts(&args.look));
    notices.extend(of_pictures(&args.look));
    notices.iter().for_each(|notice| report.warn(output, notice));
    notes.iter().for_each(|note| report.note(output, note));
    let sources: Vec<Source<'_>> =
        names.iter().zip(&drawn).map(|(name, drawn)| Source { name, structure: &drawn.structure }).collect();
    let written = write(format, &scene, &sources, &args.solid.options(), output)?;
    if let Some(size) = printed(&written, args.solid.scale.is_some()) {
        report.note(output, &size);
    }
    Ok(())
}

/// Texts that were asked for: there are none in meshes.
fn texts(look: &LookArgs) -> Option<String> {
    let text = &look.text;
    let has_labels = text.label.iter().any(|label| label.name() != "none");
    let has_any = has_labels || text.legend || text.scale_bar;
    has_any.then(|| "labels, legend and scale bar are a picture's, and not written".to_owned())
}

/// Flags that say how light falls and what is behind the molecule, by their names: meshes have neither.
pub(super) const OF_PICTURES: [&str; 8] =
    ["look", "outline", "outline-color", "fog", "depth-of-field", "light", "background", "ground"];

/// What was asked for of [`OF_PICTURES`].
fn of_pictures(look: &LookArgs) -> Option<String> {
    let is_asked = [
        look.look != LookArg::Studio,
        look.outline.is_some(),
        look.outline_color.is_some(),
        look.fog.is_some(),
        look.depth_of_field.is_some(),
        look.light != LightArg::Camera,
        look.background.is_some(),
        look.ground,
    ];
    let asked = OF_PICTURES.iter().zip(is_asked).filter(|(_, is_asked)| *is_asked);
    let asked: Vec<String> = asked.map(|(name, _)| format!("--{name}")).collect();
    let [are, have] = if asked.len() > 1 { ["are", "have"] } else { ["is", "has"] };
    (!asked.is_empty()).then(|| format!("{} {are} for pictures and {have} no effect on meshes", asked.join(", ")))
}

/// How large a print is, where that was chosen here, and whether it is thin.
fn printed(written: &Written, is_asked: bool) -> Option<String> {
    let mut said = Vec::new();
    if let Some(scale) = written.mm_per_angstrom.filter(|_| !is_asked) {
        said.push(format!(
            "an ångström is {scale:.3} mm long, so that the longest side is 100 mm; --scale sets another length"
        ));
    }
    if let Some(thin) = written.thinnest_mm.filter(|&thin| thin < LEAST_PRINTED_MM) {
        said.push(format!(
            "the thinnest parts are {thin:.2} mm thick and may break; --stick-scale makes sticks thicker"
        ));
    }
    (!said.is_empty()).then(|| said.join("; "))
}

/// Whether flags ask for something that a list of atoms has no place for.
pub(super) fn asks_for_looks(look: &LookArgs, mut crystal: CrystalArgs, solid: &SolidArgs) -> bool {
    use clap::Parser;
    #[derive(Parser)]
    struct Usual {
        #[command(flatten)]
        look: LookArgs,
        #[command(flatten)]
        crystal: CrystalArgs,
    }
    let Ok(usual) = Usual::try_parse_from(["ballstick"]) else { return false };
    // What is shown, and of which assembly, counts for atoms, too.
    crystal.assembly = usual.crystal.assembly;
    let mut look = look.clone();
    look.atoms.shown = usual.look.atoms.shown.clone();
    !solid.is_usual()
        || format!("{look:?}") != format!("{:?}", usual.look)
        || format!("{crystal:?}") != format!("{:?}", usual.crystal)
}
