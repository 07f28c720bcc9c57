//! From arguments to scene and renderer: the only module of the command line that knows them.

use super::args::{CrystalArgs, LabelArg, LookArgs, Named, RenderArgs, RendererArgs, TextArgs};
use super::atoms::style;
use super::devices::{Adapter, Devices};
use super::limits::LimitsArgs;
use super::picture::{Draw, Pixels};
use super::size::Size;
use super::values::{Altloc, Axis, Direction, MeasureArg, Region};
use crate::cli::args::Channel;
use crate::crystal::Drawn;
use crate::error::{Error, Result};
use crate::import;
use crate::render::cpu::simd::{Level, VARIABLE};
use crate::render::{Choice, DeviceLimits, Quality, Renderer, Selection, Settings, View, crop, select, select_under};
use crate::scene::{
    AltlocChoice, Aromatic, AtomPlace, Background, Camera, ColorBy, DepthOfField, Item, LabelContent, LightFrame, Look,
    Measurement, Orientation, OverlayOptions, Pose, Scene, SceneOptions, VectorChoice, Viewpoint, vector_scales,
};
#[cfg(feature = "window")]
use crate::session::Session;
use crate::structure::Mesh;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Ångström between structures that stand side by side: the gap between molecules that just touch, 2 × 1.7 Å of
/// carbon (Bondi, J. Phys. Chem. 1964, 68, 441), rounded up.
const GAP: f32 = 4.0;

/// Picks a renderer at the first picture and keeps it for all.
pub(super) struct Drawer {
    choice: Choice,
    limits: DeviceLimits,
    selection: Option<Selection>,
    loaded: Option<Loaded>,
    /// What is to be said of the loaded structures.
    missing: Option<String>,
    /// The meshes of `--overlay`, once they are read, and what is to be said of them.
    meshes: Option<Vec<Arc<Mesh>>>,
    notices: Vec<String>,
    /// What was chosen for the user.
    notes: Vec<String>,
}

/// The picture that is being drawn.
struct Loaded {
    scene: Arc<Scene>,
    view: View,
    viewpoint: Viewpoint,
    settings: Settings,
    /// Where a turn begins.
    start: Camera,
}

impl Drawer {
    pub(super) fn new(args: RendererArgs, limits: LimitsArgs) -> Drawer {
        Drawer::with(Choice::from_name(&args.renderer.name()).unwrap_or_default(), limits.of_device())
    }

    fn with(choice: Choice, limits: DeviceLimits) -> Drawer {
        Drawer {
            choice,
            limits,
            selection: None,
            loaded: None,
            missing: None,
            meshes: None,
            notices: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Picks the renderer.
    fn choose(&mut self) -> Result<Selection> {
        if let Some(reason) = super::memory::too_little_for_drivers().filter(|_| self.choice != Choice::Cpu) {
            if self.choice == Choice::Gpu {
                self.notices.push(format!("{reason}; the CPU renderer takes over"));
            }
            self.choice = Choice::Cpu;
        }
        select_under(self.choice, self.limits)
    }

    /// The renderer and what it has loaded, brought up to date if it was not.
    fn ready(&mut self) -> Result<(&mut dyn Renderer, &Loaded)> {
        let selection = match self.selection.take() {
            Some(selection) => selection,
            None => self.choose()?,
        };
        let renderer = self.selection.insert(selection).renderer.as_mut();
        let loaded = self.loaded.as_ref().ok_or_else(|| Error::Unsupported("nothing was loaded".to_owned()))?;
        renderer.load(Arc::clone(&loaded.scene))?;
        Ok((renderer, loaded))
    }
}

impl Draw for Drawer {
    fn load(&mut self, drawn: &[Drawn], side_by_side: bool, args: &RenderArgs, size: Size) -> Result<()> {
        let meshes = match self.meshes.take() {
            Some(read) => read,
            None => overlay(&args.look, &mut self.notices)?,
        };
        self.meshes = Some(meshes.clone());
        self.loaded = None; // the old one goes first
        let asked = Asked { look: &args.look, crystal: args.crystal, pose: args.origin.pose, meshes, side_by_side };
        let (scene, notes) = scene_of(drawn, asked)?;
        self.notes = notes;
        let scene = Arc::new(scene);
        let camera = match &args.look.camera {
            Some(viewpoint) => viewpoint.camera(&scene),
            None => scene.fitted_camera(size.width as f32 / size.height as f32),
        };
        let viewpoint = match args.look.camera {
            // With the digits that were asked for, so that a picture made again says the same of itself.
            Some(asked) => Viewpoint { exact: Viewpoint::of(&scene, &camera).exact, ..asked },
            None => Viewpoint::of(&scene, &camera),
        };
        self.notices.extend(scene.unmatched.iter().map(|flag| format!("{flag}: there is no such atom")));
        let view = View::new(camera, size.width, size.height);
        self.missing = missing_labels(&args.look.text, drawn);
        self.loaded = Some(Loaded { scene, view, viewpoint, settings: settings(args), start: camera });
        Ok(())
    }

    fn part(&mut self, region: Region, channel: Channel) -> Result<Pixels> {
        let (renderer, loaded) = self.ready()?;
        let view = View { region: Some(region), ..loaded.view };
        Ok(match channel {
            Channel::Color => Pixels::Image(renderer.image(&view, &loaded.settings)?),
            Channel::Depth | Channel::Normal | Channel::Id => Pixels::Surface(renderer.gbuffer(&view)?),
            Channel::Ao => {
                let asked = if loaded.settings.ao > 0 { loaded.settings } else { Settings::default() };
                Pixels::Sky(renderer.sky_visibility(&view, asked.ao)?)
            }
        })
    }

    fn seen(&mut self) -> Result<Option<Region>> {
        let (renderer, loaded) = self.ready()?;
        crop::seen_region(renderer, &loaded.scene, &loaded.view, &loaded.settings)
    }

    fn turntable(&mut self, fitted: bool, size: Size) {
        let Some(loaded) = &mut self.loaded else { return };
        if fitted {
            loaded.view.camera = loaded.scene.turntable_camera(size.width as f32 / size.height as f32);
            loaded.viewpoint = Viewpoint::of(&loaded.scene, &loaded.view.camera);
        }
        loaded.start = loaded.view.camera;
    }

    fn turn(&mut self, angle_rad: f32) {
        if let Some(loaded) = &mut self.loaded {
            loaded.view.camera = loaded.start.turned(angle_rad);
        }
    }

    fn scene_memory(&self) -> usize {
        self.loaded.as_ref().map_or(0, |loaded| loaded.scene.memory())
    }

    fn viewpoint(&self) -> Option<Viewpoint> {
        self.loaded.as_ref().map(|loaded| loaded.viewpoint)
    }

    fn renderer(&self) -> String {
        self.selection.as_ref().map_or_else(String::new, |selection| selection.renderer.name())
    }

    fn notices(&mut self) -> Vec<String> {
        let mut notices = self.selection.as_mut().map_or_else(Vec::new, |selection| selection.renderer.take_notices());
        notices.append(&mut self.notices);
        notices.extend(self.missing.take());
        notices
    }

    fn notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    fn reset(&mut self) {
        self.selection = None;
        self.loaded = None;
    }

    fn workers(&mut self) -> Option<Box<dyn Fn() -> Box<dyn Draw> + Sync>> {
        if self.selection.is_none() {
            // What goes wrong here does so at the first picture as well, and is said there.
            self.selection = Some(self.choose().ok()?);
        }
        let is_cpu = self.selection.as_ref().is_some_and(|selection| selection.renderer.name() == "cpu");
        let new = || -> Box<dyn Draw> { Box::new(Drawer::with(Choice::Cpu, DeviceLimits::Full)) };
        is_cpu.then(|| Box::new(new) as Box<dyn Fn() -> Box<dyn Draw> + Sync>)
    }
}

/// What is wrong with the environment variables that the renderers read.
pub(super) fn environment_warning() -> Option<String> {
    let unknown = Level::unknown()?;
    let names = Level::ALL.map(Level::name).join(", ");
    let used = Level::used().name();
    Some(format!("{VARIABLE}={unknown} is none of {names}, and counts for nothing: {used} is used"))
}

/// Samples and directions of the sky.
pub(super) fn settings(args: &RenderArgs) -> Settings {
    let mut settings = Quality::from_name(&args.quality.name()).unwrap_or_default().settings();
    if args.look.depth_of_field.is_some() {
        settings = settings.through_lens();
    }
    settings.samples = args.samples.unwrap_or(settings.samples);
    settings.ao = args.ao.unwrap_or(settings.ao);
    settings
}

/// What a scene is made from beside the molecules.
pub(super) struct Asked<'a> {
    pub(super) look: &'a LookArgs,
    pub(super) crystal: CrystalArgs,
    /// How it stands if the look does not say.
    pub(super) pose: Option<Pose>,
    /// The meshes of `--overlay`.
    pub(super) meshes: Vec<Arc<Mesh>>,
    /// Whether structures stand next to one another, not where their files put them.
    pub(super) side_by_side: bool,
}

/// The scene of what is drawn, and what was chosen for the user.
pub(super) fn scene_of(drawn: &[Drawn], asked: Asked<'_>) -> Result<(Scene, Vec<String>)> {
    let Asked { look, crystal, pose, meshes, side_by_side } = asked;
    let mut options = scene_options(look, drawn)?;
    if side_by_side && !look.overlay.is_empty() {
        let message =
            "--overlay stands in the coordinates of the file, and --record all moves the records: give one --record";
        return Err(Error::input(None, message));
    }
    options.pose = options.pose.or(pose);
    options.overlay = meshes;
    if side_by_side && options.orientation == Orientation::Auto {
        // The automatic turn would turn the sheet and with it the order of the records.
        options.orientation = Orientation::Along { direction: Vec3::NEG_Z, up: Vec3::Y };
    }
    let offsets = if side_by_side { grid(drawn) } else { vec![Vec3::ZERO; drawn.len()] };
    let items: Vec<Item<'_>> = (drawn.iter().zip(offsets))
        .map(|(drawn, offset)| Item { offset, ..Item::drawn(drawn, crystal.has_box()) })
        .collect();
    let scene = Scene::new(&items, &options);
    check_measurements(look, &scene)?;
    let notes = vector_notes(&items, &options);
    Ok((scene, notes))
}

/// The meshes of `--overlay`; what their readers noticed goes to `notices`.
pub(super) fn overlay(look: &LookArgs, notices: &mut Vec<String>) -> Result<Vec<Arc<Mesh>>> {
    let read = |path: &std::path::PathBuf| -> Result<Arc<Mesh>> {
        let named = |error: Error| match error {
            Error::Io { .. } => error,
            other => Error::input(None, format!("--overlay {}: {other}", path.display())),
        };
        let (mesh, diagnostics) = import::mesh::read_path(path, &Default::default()).map_err(named)?;
        notices.extend(diagnostics.iter().map(|diagnostic| format!("--overlay {}: {diagnostic}", path.display())));
        Ok(Arc::new(mesh))
    };
    look.overlay.iter().map(read).collect()
}

/// How long vectors are drawn, where that was chosen here.
fn vector_notes(items: &[Item<'_>], options: &SceneOptions) -> Vec<String> {
    let note = |scale: crate::scene::VectorScale| match (scale.scale, options.vector_scale) {
        (0.0, _) => Some(format!("{} are all zero: there is nothing to draw", scale.name)),
        (_, Some(_)) => None,
        (per_unit, None) => Some(format!(
            "{} are drawn {} Å long per unit, the longest ({}) 2 Å; --vector-scale sets another length",
            scale.name,
            four_digits(per_unit),
            four_digits(scale.longest)
        )),
    };
    vector_scales(items, options).into_iter().filter_map(note).collect()
}

/// A number above 0 with four digits that count.
fn four_digits(x: f64) -> String {
    let decimals = 3 - x.log10().floor().clamp(-9.0, 9.0) as i32;
    if (1e-4..1e6).contains(&x) { format!("{x:.*}", decimals.max(0) as usize) } else { format!("{x:.3e}") }
}

/// The scene that the look's flags ask for, without overlays; `--axis` is that of the first structure's cell.
pub(super) fn scene_options(look: &LookArgs, drawn: &[Drawn]) -> Result<SceneOptions> {
    let vectors = VectorChoice::from_name(&look.vectors);
    vectors.check(drawn.iter().map(|drawn| &drawn.structure))?;
    Ok(SceneOptions {
        style: style(look.atoms.style()),
        color_by: ColorBy::from_name(&look.color_by.name()).unwrap_or_default(),
        altloc: match look.altloc {
            Altloc::Highest => AltlocChoice::Highest,
            Altloc::All => AltlocChoice::All,
            Altloc::Code(code) => AltlocChoice::Code(code),
        },
        orientation: match (look.view, look.axis) {
            (Some(direction), _) => along(direction),
            (None, Some(axis)) => down_axis(axis, drawn)?,
            (None, None) => Orientation::Auto,
        },
        perspective: look.is_perspective(),
        pose: look.camera.map(|viewpoint| viewpoint.pose),
        hydrogens: !look.no_hydrogens,
        water: !look.no_water,
        ions: !look.no_ions,
        by_selection: look.atoms.by_selection(),
        ball_scale: look.atoms.ball_scale,
        stick_scale: look.atoms.stick_scale,
        measurements: look.measure.iter().map(measurement).collect(),
        ground: look.has_ground(),
        background: look.backdrop().0.map_or(Background::Transparent, Background::Color),
        look: Look::from_name(&look.look.name()).unwrap_or_default(),
        outline: look.outline.map(|thousandths| thousandths * 1e-3),
        outline_color: look.outline_color,
        fog: look.fog,
        light: LightFrame::from_name(&look.light.name()).unwrap_or_default(),
        depth_of_field: look
            .depth_of_field
            .map(|thousandths| DepthOfField { blur: thousandths * 1e-3, focus: look.focus }),
        haptic: look.haptic,
        text: text_options(&look.text),
        aromatic: Aromatic::from_name(&look.aromatic.name()).unwrap_or_default(),
        vectors,
        vector_scale: look.vector_scale,
        axes: look.axes,
        overlay: Vec::new(),
        overlay_opacity: look.overlay_opacity,
        overlay_wireframe: look.overlay_wireframe,
        overlay_color: look.overlay_color,
    })
}

fn measurement(MeasureArg(atoms): &MeasureArg) -> Measurement {
    let place = |&[file, atom]: &[u32; 2]| AtomPlace { item: file - 1, atom: atom - 1 };
    Measurement { atoms: atoms.iter().map(place).collect() }
}

/// An atom that is to be measured and is not in the picture is an error: nobody would see that the number is missing.
fn check_measurements(look: &LookArgs, scene: &Scene) -> Result<()> {
    for measure in &look.measure {
        for place in measurement(measure).atoms {
            if scene.id_of(place).and_then(|id| scene.ball(id)).is_none() {
                let (file, atom) = (place.item + 1, place.atom + 1);
                let message = format!("--measure {measure}: there is no atom {atom} in the picture of file {file}");
                return Err(Error::input(None, message));
            }
        }
    }
    Ok(())
}

fn text_options(text: &TextArgs) -> OverlayOptions {
    let asked = |what| text.label.contains(&what);
    OverlayOptions {
        labels: LabelContent {
            element: asked(LabelArg::Element),
            index: asked(LabelArg::Index),
            name: asked(LabelArg::Name),
            residue: asked(LabelArg::Residue),
        },
        legend: text.legend,
        scale_bar: text.scale_bar,
        size: text.label_size as f32,
    }
}

/// Labels that were asked for and cannot be.
fn missing_labels(text: &TextArgs, drawn: &[Drawn]) -> Option<String> {
    let has_none = drawn.iter().all(|drawn| drawn.structure.residues().is_empty());
    (text.label.contains(&LabelArg::Residue) && has_none)
        .then(|| "--label residue has no effect: the file gives no residues".to_owned())
}

/// What the window starts with. A direction of the lattice needs a cell, so with `--axis` the first file is read here, for the window as well.
#[cfg(feature = "window")]
pub(super) fn window_options(
    args: &super::args::ViewArgs,
    report: &super::report::Report,
) -> Result<crate::app::Options> {
    let needs_structure = args.look.axis.is_some() || VectorChoice::from_name(&args.look.vectors) != VectorChoice::None;
    // A session has a view and vectors of its own.
    let inputs = import::trajectory::inputs(&args.files);
    let first = inputs.first().filter(|input| needs_structure && !Session::is_at(&input.structure));
    let (mut drawn, mut document) = (Vec::new(), None);
    if let Some(input) = first {
        let read = super::load::read_input(input, report)?;
        let crystal = super::load::crystal_options(args.bonds, args.crystal);
        drawn.push(crate::crystal::draw(read.at_frame(0)?, &crystal)?);
        document = Some(Arc::new(read));
    }
    let mut scene = scene_options(&args.look, &drawn)?;
    let mut notices = Vec::new();
    scene.overlay = overlay(&args.look, &mut notices)?;
    let items: Vec<Item<'_>> = drawn.iter().map(|drawn| Item::drawn(drawn, None)).collect();
    let file = args.files.first().map_or(std::path::Path::new("-"), std::path::PathBuf::as_path);
    notices.iter().for_each(|notice| report.warn(file, notice));
    vector_notes(&items, &scene).iter().for_each(|note| report.note(file, note));
    let measurements = std::mem::take(&mut scene.measurements);
    Ok(crate::app::Options {
        scene,
        overlay: args.look.overlay.clone(),
        measurements,
        crystal: super::load::crystal_options(args.bonds, args.crystal),
        cell_box: args.crystal.has_box(),
        quality: Quality::default(),
        renderer: Choice::from_name(&args.renderer.renderer.name()).unwrap_or_default(),
        viewpoint: args.look.camera,
        first: document,
        timings: args.timings,
    })
}

/// Looking along a direction with +y up, or, where that is (nearly) the direction itself, with −z up from above and
/// +z up from below, as if the viewer of the front leant over.
fn along(Direction(direction): Direction) -> Orientation {
    let direction = DVec3::from(direction).normalize_or(DVec3::NEG_Z);
    let up = if direction.y.abs() < 0.999 { DVec3::Y } else { DVec3::Z * direction.y.signum() };
    Orientation::Along { direction: direction.as_vec3(), up: up.as_vec3() }
}

/// Looking down [uvw], which points to the viewer; **c** is up, **b** where we look along **c**.
fn down_axis(axis: Axis, drawn: &[Drawn]) -> Result<Orientation> {
    let cell = drawn.iter().find_map(|drawn| drawn.cell.as_ref()).ok_or_else(|| {
        let message = format!("--axis {axis} is a direction of the unit cell, but there is none; use --view x,y,z");
        Error::Input { line: None, message }
    })?;
    let [a, b, c] = cell.vectors();
    let [u, v, w] = axis.0.map(f64::from);
    let towards = (a * u + b * v + c * w).normalize_or(DVec3::Z);
    let up = if towards.cross(c).length() > 0.01 * c.length() { c } else { b };
    Ok(Orientation::Along { direction: (-towards).as_vec3(), up: up.normalize_or(DVec3::Y).as_vec3() })
}

/// Shifts that put structures next to one another: rows from the upper left in the xy plane, half as many more
/// columns as rows, as pictures are wider than high, every one in a field of the size of the largest.
fn grid(drawn: &[Drawn]) -> Vec<Vec3> {
    let boxes: Vec<(DVec3, DVec3)> = drawn
        .iter()
        .map(|drawn| {
            let [low, high] = drawn.extent();
            if low.cmple(high).all() { (low, high) } else { (DVec3::ZERO, DVec3::ZERO) }
        })
        .collect();
    let largest = boxes.iter().fold(DVec3::ZERO, |largest, (low, high)| largest.max(*high - *low));
    let step = largest + f64::from(GAP);
    let columns = ((drawn.len() as f64 * 1.5).sqrt().ceil() as usize).max(1);
    let place = |(index, (low, high)): (usize, &(DVec3, DVec3))| {
        let (column, row) = ((index % columns) as f64, (index / columns) as f64);
        (DVec3::new(column * step.x, -row * step.y, 0.0) - (*low + *high) * 0.5).as_vec3()
    };
    boxes.iter().enumerate().map(place).collect()
}

/// What there is to draw with.
pub(super) fn devices() -> Devices {
    let choice = match select(Choice::Auto) {
        Ok(Selection { renderer, reason }) => Ok((renderer.name(), reason)),
        Err(error) => Err(error.to_string()),
    };
    let note = (!cfg!(feature = "gpu")).then(|| "This ballstick was built without the GPU renderer.".to_owned());
    Devices { simd: Level::used().name(), adapters: adapters(), note, choice }
}

#[cfg(feature = "gpu")]
fn adapters() -> Vec<Adapter> {
    let found = crate::render::gpu::adapters().into_iter();
    let driver = |name: String, version: String| [name, version].join(" ").trim().to_owned();
    found
        .map(|report| Adapter {
            name: report.name,
            backend: report.backend,
            kind: report.device_type,
            driver: driver(report.driver, report.driver_info),
        })
        .collect()
}

#[cfg(not(feature = "gpu"))]
fn adapters() -> Vec<Adapter> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::{AromaticArg, CellArg, ColorByArg, LookArg, QualityArg, RendererArg, StyleArg};
    use crate::scene::Style;
    use crate::structure::{AtomRecord, Cell, Diagnostics, StructureBuilder};
    use clap::ValueEnum;

    #[test]
    fn every_name_of_a_flag_is_one_of_the_library() {
        for value in CellArg::value_variants() {
            assert!(crate::crystal::CellChoice::from_name(&value.name()).is_some(), "{value:?}");
        }
        for value in StyleArg::value_variants() {
            assert!(Style::from_name(&value.name()).is_some(), "{value:?}");
        }
        for value in AromaticArg::value_variants() {
            assert!(Aromatic::from_name(&value.name()).is_some(), "{value:?}");
        }
        for value in LookArg::value_variants() {
            assert!(Look::from_name(&value.name()).is_some(), "{value:?}");
        }
        for value in ColorByArg::value_variants() {
            assert!(ColorBy::from_name(&value.name()).is_some(), "{value:?}");
        }
        for value in QualityArg::value_variants() {
            assert!(Quality::from_name(&value.name()).is_some(), "{value:?}");
        }
        for value in RendererArg::value_variants() {
            assert!(Choice::from_name(&value.name()).is_some(), "{value:?}");
        }
    }

    fn structure(points: &[[f64; 3]], cell: Option<Cell>) -> Drawn {
        let mut builder = StructureBuilder::new();
        for &point in points {
            builder.push_atom(&AtomRecord { position: point.into(), ..AtomRecord::default() });
        }
        builder.set_cell(cell);
        Drawn::as_listed(builder.build(&mut Diagnostics::default()))
    }

    #[test]
    fn the_axis_points_to_the_viewer_in_the_cells_own_directions() {
        let hexagonal = structure(&[], Cell::from_parameters([2.0, 2.0, 5.0], [90.0, 90.0, 120.0]));
        let got = down_axis(Axis([0, 1, 0]), &[hexagonal]).unwrap();
        let Orientation::Along { direction, up } = got else { panic!("{got:?}") };
        assert!((direction - Vec3::new(0.5, -0.866_025_4, 0.0)).length() < 1e-6, "{direction}");
        assert!((up - Vec3::Z).length() < 1e-6, "{up}");
        let cubic = structure(&[], Cell::from_parameters([2.0; 3], [90.0; 3]));
        let got = down_axis(Axis([0, 0, 2]), &[cubic]).unwrap();
        assert_eq!(got, Orientation::Along { direction: Vec3::NEG_Z, up: Vec3::Y });
        assert!(down_axis(Axis([1, 1, 1]), &[structure(&[], None)]).unwrap_err().to_string().contains("--view"));
    }

    #[test]
    fn numbers_have_four_digits() {
        let got = [0.001_234_56, 1.0, 12_345.6, 1e-7, 0.25].map(four_digits);
        assert_eq!(got, ["0.001235", "1.000", "12346", "1.000e-7", "0.2500"]);
    }

    #[test]
    fn from_the_top_the_front_is_below() {
        assert_eq!(along(Direction([0.0, -2.0, 0.0])), Orientation::Along { direction: Vec3::NEG_Y, up: Vec3::NEG_Z });
        assert_eq!(along(Direction([0.0, 0.0, -1.0])), Orientation::Along { direction: Vec3::NEG_Z, up: Vec3::Y });
    }

    #[test]
    fn side_by_side_nothing_overlaps_wherever_the_files_put_it() {
        let long = structure(&[[100.0, 0.0, 0.0], [110.0, 2.0, 1.0]], None);
        let records = [long.clone(), structure(&[[-5.0, -5.0, -5.0]], None), structure(&[], None), long];
        let offsets = grid(&records);
        // Three columns: 0, 1, 2, then the next row.
        assert_eq!(offsets[0], Vec3::new(-105.0, -1.0, -0.5));
        assert_eq!(offsets[1], Vec3::new(14.0 + 5.0, 5.0, 5.0));
        assert_eq!(offsets[3], Vec3::new(-105.0, -6.0 - 1.0, -0.5));
    }
}
