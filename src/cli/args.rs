//! The command line, as it is typed. Nothing here acts; names and defaults are what others script against.

use super::assembly::AssemblyArgs;
use super::atoms::AtomArgs;
use super::batch::BatchArgs;
use super::size::{Crop, PictureSize};
use super::solid::ConvertArgs;
use super::values::{
    Altloc, Axis, Backdrop, Direction, MeasureArg, RecordChoice, Region, Supercell, blur, color, counted_from_1, fog,
    opacity, outline_width, part, positive, text_size,
};
use crate::color::Srgb8;
use crate::scene::{Projection, Viewpoint};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::num::NonZeroU32;
use std::path::PathBuf;

/// Shows molecules as balls and sticks: in a window, or as a picture on any machine, with or without a graphics card.
#[derive(Debug, Parser)]
#[command(
    name = "ballstick",
    version,
    max_term_width = 100,
    args_conflicts_with_subcommands = true,
    // Without a window there is nothing to show without a file.
    arg_required_else_help = cfg!(not(feature = "window")),
    after_help = super::manual::AFTER_HELP
)]
pub struct Cli {
    /// What to do; viewing, if nothing is said.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Viewing is what happens without a command.
    #[command(flatten)]
    pub view: ViewArgs,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show molecules in a window (the default)
    View(Box<ViewArgs>),
    /// Draw pictures
    Render(Box<RenderArgs>),
    /// Say what is in files
    Info(InfoArgs),
    /// Write a structure in another format, or the scene as a mesh for other programs
    Convert(Box<ConvertArgs>),
    /// Write the manual, as pages for man
    Manual(super::manual::ManualArgs),
    /// Write what a shell needs to complete commands and flags
    Completions(super::manual::CompletionsArgs),
    /// List graphics devices, and which one is used and why
    ///
    /// Best first. WGPU_BACKEND=vulkan, gl, dx12 or metal narrows the choice to one interface, here and in pictures
    Devices,
}

/// `ballstick view`.
#[derive(Debug, Clone, Args)]
pub struct ViewArgs {
    /// Molecule files, all into one scene, or a session; - is standard input; without any the window shows how to open one. A
    /// trajectory (XTC, TRR, DCD) stands behind the structure whose atoms it moves
    #[arg(value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Look.
    #[command(flatten)]
    pub look: LookArgs,
    /// Molecule.
    #[command(flatten)]
    pub bonds: BondArgs,
    /// Crystal.
    #[command(flatten)]
    pub crystal: CrystalArgs,
    /// Renderer.
    #[command(flatten)]
    pub renderer: RendererArgs,
    /// Count and time what the window does, and print it as JSON on standard error when it is closed: pictures, and milliseconds by stage
    #[arg(long, help_heading = "Running")]
    pub timings: bool,
}

/// What stands below the flags of `render`.
const AFTER_RENDER: &str = "\
Examples:
  ballstick render caffeine.sdf -o caffeine.png
  ballstick render 1crn.pdb -o fig.png --size 3000x2000 --background transparent
  ballstick render 1crn.pdb -o fig.png --size 85mmx60mm --dpi 600 --crop auto
  ballstick render *.sdf -o pictures/            one each: pictures/NAME.png
  ballstick render *.sdf -o 'out/{stem}.webp'    the same with names of your own
  ballstick render 1crn.pdb -o fig.png --hide water --style 'ligand=licorice'
  ballstick render top.pdb run.xtc -o last.png --frame 500
  curl … | ballstick render - -o - > fig.png
  ballstick render 1crn.pdb -o turn.gif --turntable=72 --size 640x480
  ballstick render relax.xyz -o relax.mp4 --frames 1-500:5 --fps 30
  ballstick render --from fig.png -o again.png --size 6000x4000

Channels (--channel) as 16-bit PNG, or as plain numbers in NPY (-o depth.npy):
  depth   PNG: grey, linear from 65535 at the text chunk near_angstrom to 1 at
          far_angstrom; 0 is the background. NPY: f4 (h,w) in ångström; inf is
          the background
  normal  in view space: x right, y up, z to the viewer. PNG: RGB of
          n*0.5+0.5; 0,0,0 is the background. NPY: f4 (h,w,3)
  id      0 background, 1 + atom index, 1 + number of atoms + bond index,
          4294967295 ground. PNG: R = id >> 16, G = id & 65535, B = 0.
          NPY: u4 (h,w)
  ao      ambient occlusion: the part of the sky that the surface sees, over
          all directions (--ao, 64 where the quality says none); 1 where there
          is no surface. PNG: grey, 65535 is 1. NPY: f4 (h,w)

Timings (--timings), one JSON object a picture: seconds for read, bonds, scene,
render, encode and total; peak_memory, structure_memory and scene_memory in
bytes (the first null where the system does not tell); atom_count, bond_count,
renderer and output.";

/// `ballstick render`.
#[derive(Debug, Clone, Args)]
#[command(after_help = AFTER_RENDER, after_long_help = format!("{AFTER_RENDER}\n\n{}", crate::select::help()))]
pub struct RenderArgs {
    /// Molecule files, or a session; - is standard input, sample:caffeine a molecule of the program's own; a trajectory (XTC, TRR,
    /// DCD) stands behind the structure whose atoms it moves
    #[arg(value_name = "FILE", required_unless_present = "from")]
    pub files: Vec<PathBuf>,
    /// Make a picture again, or that of a session: a PNG or JPEG file that ballstick wrote, or the JSON file of a session. Other flags change
    /// what they say; FILEs take the place of its files, in their order
    #[arg(long, value_name = "PICTURE")]
    pub from: Option<PathBuf>,
    /// What `--from` says and no flag does.
    #[arg(skip)]
    pub origin: super::from::Origin,
    /// Picture: a file takes all FILEs into one scene; a folder (there, or ending in /) or a name with {stem} makes
    /// one picture of each; - is standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Format where OUT does not say: png, jpg, webp, ppm or npy; gif, apng or mp4 (by ffmpeg) for films [default: png]
    #[arg(long, value_name = "FORMAT")]
    pub to: Option<String>,
    /// Width and height of the picture in pixels, up to 32768 each, or in print (see --dpi): 85mmx60mm, 8cmx6cm,
    /// 3.3inx2.5in; 85mm alone is the width of a picture of the usual shape
    #[arg(long, value_name = "WxH", default_value = "1920x1080", help_heading = "Picture")]
    pub size: PictureSize,
    /// Pixels an inch: what lengths in --size become, and what PNG and JPEG files say [default: 300 for lengths]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=9600), help_heading = "Picture")]
    pub dpi: Option<u32>,
    /// Draw only this part of the full picture, in pixels from its upper left corner
    #[arg(long, value_name = "X,Y,W,H", conflicts_with = "crop", help_heading = "Picture")]
    pub region: Option<Region>,
    /// Cut the picture to what is not background, shadow included: auto, or auto,MARGIN with the space that stays around
    /// it in pixels (auto,20) or percent of its longer side (auto,5%) [default margin: 2%]
    #[arg(long, value_name = "HOW", help_heading = "Picture")]
    pub crop: Option<Crop>,
    /// Effort: samples, ambient occlusion and shadows
    #[arg(long, value_name = "LEVEL", default_value = "standard", help_heading = "Picture")]
    pub quality: QualityArg,
    /// Samples a pixel, 1 to 4096, in place of what the quality says
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), help_heading = "Picture")]
    pub samples: Option<u32>,
    /// Directions of the sky that ambient occlusion is found from, 0 (none) to 256, in place of what the quality says
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=256), help_heading = "Picture")]
    pub ao: Option<u32>,
    /// Turn once about the upright axis in a film of N frames (gif, apng, mp4; what has one frame does so by itself) [default: 100]
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "100",
        value_parser = clap::value_parser!(u32).range(1..=100_000), conflicts_with = "frames", help_heading = "Film")]
    pub turntable: Option<u32>,
    /// Play these frames of a trajectory in a film: FIRST-LAST or FIRST-LAST:STEP, such as 1-100:2, 50-, :10 [default: all]
    #[arg(long, value_name = "RANGE", conflicts_with = "frame", help_heading = "Film")]
    pub frames: Option<super::frames::FrameRange>,
    /// Frames a second, up to 50 [default: 25]
    #[arg(long, value_name = "N", value_parser = super::values::frame_rate, help_heading = "Film")]
    pub fps: Option<f64>,
    /// What the picture shows; all but color are numbers, see below
    #[arg(long, value_name = "WHAT", default_value = "color", help_heading = "Picture")]
    pub channel: Channel,
    /// Look.
    #[command(flatten)]
    pub look: LookArgs,
    /// Bonds.
    #[command(flatten)]
    pub bonds: BondArgs,
    /// Crystal.
    #[command(flatten)]
    pub crystal: CrystalArgs,
    /// Record and frame.
    #[command(flatten)]
    pub select: SelectArgs,
    /// Renderer.
    #[command(flatten)]
    pub renderer: RendererArgs,
    /// Batch.
    #[command(flatten)]
    pub batch: BatchArgs,
    /// Device.
    #[command(flatten)]
    pub limits: super::limits::LimitsArgs,
    /// Print timings as JSON on standard error, see below
    #[arg(long, help_heading = "Running")]
    pub timings: bool,
}

/// How things look.
#[derive(Debug, Clone, Args)]
pub struct LookArgs {
    /// Atoms.
    #[command(flatten)]
    pub atoms: AtomArgs,
    /// What the colours of atoms say
    #[arg(long, value_name = "SCHEME", default_value = "element", help_heading = "Look")]
    pub color_by: ColorByArg,
    /// Light and lines
    #[arg(long, value_name = "LOOK", default_value = "studio", help_heading = "Look")]
    pub look: LookArg,
    /// Draw lines around things, as wide as so many thousandths of the picture's height; 0 for none [default: the look's, which
    /// is none for studio, soft, flat and dark]
    #[arg(long, value_name = "WIDTH", value_parser = outline_width, help_heading = "Look")]
    pub outline: Option<f32>,
    /// Colour of these lines, #rrggbb or a name [default: nearly black]
    #[arg(long, value_name = "COLOR", value_parser = color, help_heading = "Look")]
    pub outline_color: Option<Srgb8>,
    /// How much of the background's colour the farthest point takes on, 0 to 1, in pictures of what is larger than about
    /// 15 Å [default: the look's]
    #[arg(long, value_name = "AMOUNT", value_parser = fog, help_heading = "Look")]
    pub fog: Option<f32>,
    /// Blur what is out of focus: what lies as far behind the focus as the molecule is deep, over so many thousandths of the
    /// picture's height; needs perspective; 64 samples unless --samples says otherwise
    #[arg(long, value_name = "BLUR", value_parser = blur, help_heading = "Look")]
    pub depth_of_field: Option<f32>,
    /// What is in focus: 0 is the front of the molecule, 1 its back
    #[arg(long, value_name = "WHERE", value_parser = part, default_value = "0.3", requires = "depth_of_field", help_heading = "Look")]
    pub focus: f32,
    /// What the lights turn with
    #[arg(long, value_name = "WITH", default_value = "camera", help_heading = "Look")]
    pub light: LightArg,
    /// Background: transparent, #rrggbb, or a name such as white [default: white; with --look dark nearly black]
    #[arg(long, value_name = "COLOR", help_heading = "Look")]
    pub background: Option<Backdrop>,
    /// Put a ground under the molecule (the default in pictures)
    #[arg(long, overrides_with = "no_ground", help_heading = "Look")]
    pub ground: bool,
    /// Leave the ground out
    #[arg(long, overrides_with = "ground", help_heading = "Look")]
    pub no_ground: bool,
    /// Projection
    #[arg(long, value_name = "KIND", default_value = "perspective", help_heading = "Look")]
    pub projection: ProjectionArg,
    /// Keep the file's axes and look along x,y,z, or at the front, back, left, right, top or bottom (front looks
    /// along -z with y up) [default: longest axis across, thinnest to the viewer; small
    /// molecules whose atoms would hide one another a little aside]
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true, conflicts_with = "axis", help_heading = "Look")]
    pub view: Option<Direction>,
    /// Look down the lattice direction UVW, which points to the viewer: 111, 1-10 or 1,-1,0; needs a unit cell
    #[arg(long, value_name = "UVW", allow_hyphen_values = true, help_heading = "Look")]
    pub axis: Option<Axis>,
    /// Take the view that the window's "copy the command line" wrote down, in place of the fitted one
    #[arg(long, value_name = "NUMBERS", allow_hyphen_values = true, conflicts_with_all = ["view", "axis", "projection"], help_heading = "Look")]
    pub camera: Option<Viewpoint>,
    /// Mark a distance, angle or dihedral: two, three or four atoms by their numbers in what is drawn, from 1, such as 1,5 or,
    /// with the number of the FILE (trajectories do not count), 2:7,2:9,2:12; may be given several times
    #[arg(long, value_name = "ATOMS", help_heading = "Text")]
    pub measure: Vec<MeasureArg>,
    /// Leave hydrogens out
    #[arg(long, overrides_with = "hydrogens", help_heading = "Molecule")]
    pub no_hydrogens: bool,
    /// Leave water molecules out
    #[arg(long, overrides_with = "water", help_heading = "Molecule")]
    pub no_water: bool,
    /// Leave ions out
    #[arg(long, overrides_with = "ions", help_heading = "Molecule")]
    pub no_ions: bool,
    /// Alternate locations drawn: highest (occupancy), all, or one letter such as B
    #[arg(long, value_name = "WHICH", default_value = "highest", help_heading = "Molecule")]
    pub altloc: Altloc,
    /// Draw one stick from a metal to the middle of a ring or double bond that it holds, not one to each atom
    #[arg(long, overrides_with = "no_haptic", help_heading = "Molecule")]
    pub haptic: bool,
    /// How aromatic bonds look
    #[arg(long, value_name = "HOW", default_value = "ring", help_heading = "Look")]
    pub aromatic: AromaticArg,
    /// Draw vectors of the file (forces, velocities) as arrows on the atoms: the name of a field, auto for all, or none
    #[arg(long, value_name = "NAME", default_value = "none", help_heading = "Look")]
    pub vectors: String,
    /// Ångström that one unit of the vectors is long [default: such that the longest is 2 Å]
    #[arg(long, value_name = "X", value_parser = positive, help_heading = "Look")]
    pub vector_scale: Option<f32>,
    /// Show the directions of the axes: x red, y green, z blue; a, b, c where there is a unit cell
    #[arg(long, overrides_with = "no_axes", help_heading = "Look")]
    pub axes: bool,
    /// Lay a triangle mesh (OBJ, glTF, GLB) over the molecule, in ångström and the coordinates of its file; may be given
    /// several times
    #[arg(long, value_name = "FILE", help_heading = "Overlay")]
    pub overlay: Vec<PathBuf>,
    /// Opacity of overlays, 0 to 1, times their own
    #[arg(long, value_name = "X", value_parser = opacity, requires = "overlay", help_heading = "Overlay")]
    pub overlay_opacity: Option<f32>,
    /// Draw the edges of overlays, not their triangles
    #[arg(long, requires = "overlay", overrides_with = "no_overlay_wireframe", help_heading = "Overlay")]
    pub overlay_wireframe: bool,
    /// Colour of overlays, #rrggbb or a name, in place of their own
    #[arg(long, value_name = "COLOR", value_parser = color, requires = "overlay", help_heading = "Overlay")]
    pub overlay_color: Option<Srgb8>,
    /// Text.
    #[command(flatten)]
    pub text: TextArgs,
    /// What takes others back.
    #[command(flatten)]
    pub opposite: super::opposite::OppositeArgs,
}

/// What is written over the picture.
#[derive(Debug, Clone, Args)]
pub struct TextArgs {
    /// Label atoms or residues, several with commas: element,index gives C12. Only what is seen is labelled, and of labels that
    /// would overlap the nearest
    #[arg(long, value_name = "WHAT", value_delimiter = ',', default_value = "none", help_heading = "Text")]
    pub label: Vec<LabelArg>,
    /// Size of all text, 0.2 to 5; at 1 capitals are 2 % of the picture's height
    #[arg(long, value_name = "X", value_parser = text_size, default_value = "1", help_heading = "Text")]
    pub label_size: f64,
    /// Say which colour is which, in the lower left corner
    #[arg(long, overrides_with = "no_legend", help_heading = "Text")]
    pub legend: bool,
    /// Draw a bar of a round length, in the lower right corner; in perspective it holds in the depth of the molecule's
    /// centre
    #[arg(long, overrides_with = "no_scale_bar", help_heading = "Text")]
    pub scale_bar: bool,
}

impl LookArgs {
    /// Whether the picture is in perspective: a camera that was written down brings its projection.
    #[must_use]
    pub fn is_perspective(&self) -> bool {
        match &self.camera {
            Some(viewpoint) => matches!(viewpoint.projection, Projection::Perspective { .. }),
            None => self.projection == ProjectionArg::Perspective,
        }
    }

    /// Whether there is a ground.
    #[must_use]
    pub fn has_ground(&self) -> bool {
        !self.no_ground
    }

    /// The background, the look's where none is asked for.
    #[must_use]
    pub fn backdrop(&self) -> Backdrop {
        let of_look = || crate::scene::Look::from_name(&self.look.name()).unwrap_or_default().background();
        self.background.unwrap_or_else(|| Backdrop(Some(of_look())))
    }

    /// The colour behind the molecule; white where the background is transparent.
    #[must_use]
    pub fn solid_background(&self) -> Srgb8 {
        self.backdrop().0.unwrap_or(Srgb8::WHITE)
    }
}

/// Where bonds come from.
#[derive(Debug, Clone, Copy, Args)]
pub struct BondArgs {
    /// Where bonds come from
    #[arg(long, value_name = "FROM", default_value = "auto", help_heading = "Molecule")]
    pub bonds: BondsArg,
    /// Find hydrogen bonds, too: N, O, S, F up to 3.5 Å apart, at least 120° at the hydrogen
    #[arg(long, overrides_with = "no_hbonds", help_heading = "Molecule")]
    pub hbonds: bool,
    /// No hydrogen bonds but those of the file (the default): takes --hbonds back
    #[arg(long, overrides_with = "hbonds", help_heading = "Molecule", hide_short_help = true)]
    pub no_hbonds: bool,
}

/// What of a crystal, and of several frames, is drawn.
#[derive(Debug, Clone, Copy, Args)]
pub struct CrystalArgs {
    /// Find the bonds of each frame anew; alone it means always
    #[arg(long, value_name = "WHEN", num_args = 0..=1, require_equals = true, default_value = "auto",
          default_missing_value = "always", help_heading = "Molecule")]
    pub bonds_per_frame: PerFrameArg,
    /// What of a structure with a unit cell is drawn
    #[arg(long, value_name = "WHAT", default_value = "molecule", help_heading = "Crystal")]
    pub cell: CellArg,
    /// Cells along a, b and c, such as 2x2x1; whole cells, unless --cell asym is given
    #[arg(long, value_name = "AxBxC", default_value = "1x1x1", help_heading = "Crystal")]
    pub supercell: Supercell,
    /// Assembly.
    #[command(flatten)]
    pub assembly: AssemblyArgs,
    /// Draw the edges of the unit cell (the default where cells are drawn and not single molecules)
    #[arg(long, overrides_with = "no_cell_box", help_heading = "Crystal")]
    pub cell_box: bool,
    /// Leave the edges of the unit cell out
    #[arg(long, overrides_with = "cell_box", help_heading = "Crystal")]
    pub no_cell_box: bool,
}

impl CrystalArgs {
    /// Whether the cell's edges are drawn; `None` leaves it to what is drawn.
    #[must_use]
    pub fn has_box(&self) -> Option<bool> {
        (self.cell_box || self.no_cell_box).then_some(self.cell_box)
    }
}

/// Which part of a file.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct SelectArgs {
    /// Frame (XYZ frame, PDB model, SDF record, frame of a trajectory), counted from 1; with --record the frame of that record
    #[arg(long, value_name = "N", value_parser = counted_from_1, help_heading = "Molecule")]
    pub frame: Option<NonZeroU32>,
    /// Record of a file with several molecules, counted from 1; all takes every one (a picture shows them side by side)
    #[arg(long, value_name = "N|all", help_heading = "Molecule")]
    pub record: Option<RecordChoice>,
}

/// Who draws.
#[derive(Debug, Clone, Copy, Args)]
pub struct RendererArgs {
    /// Who draws
    #[arg(long, value_name = "WHO", default_value = "auto", help_heading = "Running")]
    pub renderer: RendererArg,
}

/// `ballstick info`.
#[derive(Debug, Clone, Args)]
pub struct InfoArgs {
    /// Molecule files; - is standard input; a trajectory (XTC, TRR, DCD) behind its structure is told of with it, one object for both
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// One JSON object a file, one a line; a file that cannot be read gives {"path", "error": {"line", "message"}}
    #[arg(long)]
    pub json: bool,
    /// Say of every bond where it comes from and why, and of near pairs why they are none; in JSON as bond_list
    /// and not_bonded
    #[arg(long)]
    pub explain_bonds: bool,
    /// Bonds.
    #[command(flatten)]
    pub bonds: BondArgs,
}

/// A set of names a flag takes; [`Named::name`] is the one that is typed.
pub trait Named: ValueEnum {
    /// The name.
    fn name(&self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

impl<T: ValueEnum> Named for T {}

/// `--style`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StyleArg {
    /// Balls and sticks
    BallAndStick,
    /// Thick sticks
    Licorice,
    /// Full van der Waals spheres
    SpaceFilling,
    /// Thin sticks
    Wireframe,
}

/// `--color-by`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ColorByArg {
    /// Which element it is, in the usual colours
    Element,
    /// Which chain it belongs to
    Chain,
    /// What its residue is called
    Residue,
}

/// `--label`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LabelArg {
    /// The symbol of each atom's element
    Element,
    /// The number of each atom in its file, from 1
    Index,
    /// The name of each atom; where the file gives none, its element
    Name,
    /// Name and number of each residue, such as GLY 12
    Residue,
    /// Nothing
    None,
}

/// `--look`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LookArg {
    /// A key light with shadow, a little fill, highlights
    Studio,
    /// Light from all around: ambient occlusion shows the shape
    Soft,
    /// The colours as they are, hardly shaded
    Flat,
    /// Before a dark background
    Dark,
    /// Lightly shaded, thin dark lines around everything, as journals print
    Outline,
    /// Flat colours, strong lines, soft shade in the hollows
    Illustrative,
}

/// `--light`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LightArg {
    /// The camera: they come from the upper left of every picture
    Camera,
    /// The molecule: they fall as in the default view, from wherever one looks
    World,
}

/// `--aromatic`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AromaticArg {
    /// Single sticks and a thin ring inside each flat ring; single and double bonds where a C=O leaves it, and in fullerenes
    Ring,
    /// A stick and a dashed one inside the ring
    Dashes,
    /// Single and double bonds of one Kekulé form
    Kekule,
}

/// `--projection`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ProjectionArg {
    /// What is farther is smaller
    Perspective,
    /// Parallel rays
    Orthographic,
}

/// `--bonds`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BondsArg {
    /// The file's; what it leaves open from the dictionary of residues and ligands, then by distance
    Auto,
    /// The file's and no others
    File,
    /// By distance, whatever the file says and the residues are called
    Perceive,
    /// None
    None,
}

/// `--bonds-per-frame`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PerFrameArg {
    /// Of files that list the atoms of each frame (XYZ, PDB models); frames of a trajectory have the bonds of its structure
    Auto,
    /// Of all files
    Always,
    /// Of none: all frames have the bonds of the structure, or of the first one
    Never,
}

/// `--cell`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CellArg {
    /// The atoms as the file lists them
    Asym,
    /// The molecules that these atoms belong to, whole; of an endless network, what is in the cell
    Molecule,
    /// All that is in the cell, molecules whole
    Full,
}

/// `--channel`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Channel {
    /// The picture
    Color,
    /// Which way the surface faces
    Normal,
    /// How far away it is
    Depth,
    /// Which atom or bond it is
    Id,
    /// How much of the sky it sees
    Ao,
}

/// `--quality`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum QualityArg {
    /// 4 samples a pixel
    Draft,
    /// 16 samples a pixel
    Standard,
    /// 64 samples a pixel
    High,
}

/// `--renderer`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RendererArg {
    /// A real GPU if there is one, else the CPU
    Auto,
    /// All cores of the CPU
    Cpu,
    /// A graphics device; where there is none, or it is lost, this is said and the CPU draws
    Gpu,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    fn render(flags: &[&str]) -> Result<RenderArgs, clap::Error> {
        let line = ["ballstick", "render", "a.sdf", "-o", "a.png"].iter().chain(flags);
        Cli::try_parse_from(line).map(|cli| match cli.command {
            Some(Command::Render(args)) => *args,
            other => panic!("{other:?}"),
        })
    }

    #[test]
    fn files_without_a_command_are_viewed() {
        let cli = Cli::try_parse_from(["ballstick", "a.sdf", "./render"]).unwrap();
        assert!(cli.command.is_none());
        assert_eq!(cli.view.files, [PathBuf::from("a.sdf"), PathBuf::from("./render")]);
        let cli = Cli::try_parse_from(["ballstick", "view", "render"]).unwrap();
        assert!(matches!(cli.command, Some(Command::View(view)) if view.files == [PathBuf::from("render")]));
    }

    #[test]
    fn flags_that_others_script_against_keep_their_names() {
        let flags = [
            "--renderer=cpu",
            "--size=640x480",
            "--samples=4",
            "--turntable=72",
            "--fps=30",
            "--style=space-filling",
            "--color-by=chain",
            "--background=transparent",
            "--no-ground",
            "--projection=orthographic",
            "--view=-1,0,0",
            "--bonds=perceive",
            "--frame=2",
            "--record=all",
            "--channel=ao",
            "--ao=64",
            "--region=0,0,10,10",
            "--dpi=600",
            "--quality=high",
            "--timings",
            "--skip-existing",
            "--shard=2/8",
            "--altloc=B",
            "--cell=full",
            "--supercell=2x2x1",
            "--assembly=PAU",
            "--bonds-per-frame=never",
            "--haptic",
            "--label=element,index",
            "--label=residue",
            "--label-size=1.5",
            "--legend",
            "--scale-bar",
            "--look=soft",
            "--outline=1.5",
            "--outline-color=navy",
            "--fog=0.8",
            "--light=world",
            "--depth-of-field=20",
            "--focus=0.5",
            "--aromatic=dashes",
            "--vectors=forces",
            "--vector-scale=0.5",
            "--axes",
            "--measure=1,5",
            "--measure=2:1,2:2,1:3",
            "--no-hydrogens",
            "--no-water",
            "--no-ions",
            "--show=chain A",
            "--show=ligand",
            "--hide=within 5 of element Fe",
            "--color=chain A=steelblue",
            "--style=ligand=licorice",
            "--label-only=backbone",
            "--ball-scale=1.5",
            "--stick-scale=0.5",
            "--overlay=a.obj",
            "--overlay=b.glb",
            "--overlay-opacity=0.5",
            "--overlay-wireframe",
            "--overlay-color=steelblue",
        ];
        let args = render(&flags).unwrap();
        assert_eq!((args.look.atoms.style().name(), args.look.has_ground()), ("space-filling".to_owned(), false));
        assert_eq!(args.look.text.label, [LabelArg::Element, LabelArg::Index, LabelArg::Residue]);
        assert_eq!(args.look.view, Some(Direction([-1.0, 0.0, 0.0])));
        assert_eq!(render(&["--axis", "-1,1,0"]).unwrap().look.axis, Some(Axis([-1, 1, 0])));
        assert!(render(&["--no-ground", "--ground"]).unwrap().look.has_ground());
    }

    /// What the window copies is a command line of ours, whatever the projection.
    #[test]
    fn the_command_line_of_a_session_is_one() {
        let document = crate::import::read_bytes(b"2\n\nO 0 0 0\nO 1 2 0\n", "a.xyz", &Default::default()).unwrap();
        for perspective in [true, false] {
            let options = crate::scene::SceneOptions { perspective, ..Default::default() };
            let scene = crate::scene::Scene::new(&[crate::scene::Item::of(&document.records[0])], &options);
            let viewpoint = Some(Viewpoint::of(&scene, &scene.fitted_camera(1.5)));
            let mut session = crate::session::Session::of(&crate::session::Settings {
                scene: options,
                crystal: Default::default(),
                cell_box: None,
                quality: Default::default(),
                viewpoint,
            });
            session.files =
                vec![crate::session::File { path: "a.xyz".into(), frame: 1, visible: true, ..Default::default() }];
            let line = session.command_line([300, 200]);
            let cli = Cli::try_parse_from(line.split(' ')).unwrap();
            let Some(Command::Render(args)) = cli.command else { panic!("{line}") };
            let pose = |viewpoint: Option<Viewpoint>| viewpoint.map(|viewpoint| viewpoint.pose);
            assert_eq!((pose(args.look.camera), args.look.is_perspective()), (pose(viewpoint), perspective), "{line}");
        }
    }

    #[test]
    fn what_is_not_there_is_refused() {
        for flags in [
            &["--ao=257"][..],
            &["--samples=0"],
            &["--turntable=0"],
            &["--turntable", "--frames=1-5"],
            &["--frame=2", "--frames=1-5"],
            &["--fps=0"],
            &["--fps=51"],
            &["--samples=5000"],
            &["--frame=0"],
            &["--style=cartoon"],
            &["--show=chian A"],
            &["--hide="],
            &["--color=red"],
            &["--ball-scale=0"],
            &["--label=element,colour"],
            &["--label-size=0"],
            &["--label-size=nan"],
            &["--look=glossy"],
            &["--outline=51"],
            &["--outline=-1"],
            &["--fog=1.2"],
            &["--light=sun"],
            &["--depth-of-field=0"],
            &["--depth-of-field=10", "--focus=2"],
            &["--focus=0.5"],
            &["--aromatic=circle"],
            &["--vector-scale=0"],
            &["--overlay=a.obj", "--overlay-opacity=1.5"],
            &["--overlay-wireframe"],
            &["--view=front", "--axis=111"],
            &["--camera=1,2,3"],
            &["--measure=1"],
            &["--size=32769x10"],
            &["--dpi=0"],
            &["--crop=auto", "--region=0,0,10,10"],
        ] {
            let error = render(flags).expect_err(&format!("{flags:?}"));
            assert_eq!(error.exit_code(), 2, "{flags:?}");
        }
    }
}
