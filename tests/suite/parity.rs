//! The GPU's picture against the CPU's: ids, depths, normals, colours, over the pixels that either covers.
//!
//! Without an adapter the tests print `SKIP` and the reason; `BALLSTICK_GPU=require` turns that into a failure.

use crate::scenes::{self, Case, molecules};
use ballstick::import::{ImportOptions, read_path};
use ballstick::render::cpu::{CpuRenderer, reference};
use ballstick::render::gpu::layout::SampleConstants;
use ballstick::render::gpu::{Accumulation, AdapterWish, GpuRenderer, Work, adapters};
use ballstick::render::{GBuffer, Image, Renderer, Settings, View};
use ballstick::scene::{
    Background, Block, Item, LabelContent, OverlayOptions, Placement, Projection, Region, Scene, SceneOptions, Style,
};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

const SETTINGS: Settings = Settings { samples: 4, ground_texels: 96, ao: 0, shadow: false };

/// With all light from afar.
const FINISHED: Settings = Settings { samples: 16, ground_texels: 96, ao: 64, shadow: true };
/// The same with a quarter of the work, for scenes by the dozen.
const QUICK: Settings = Settings { samples: 4, ground_texels: 96, ao: 16, shadow: true };

fn skip_or_fail(reason: &str) {
    println!("SKIP: {reason}");
    let required = std::env::var("BALLSTICK_GPU").is_ok_and(|wish| wish == "require");
    assert!(!required, "BALLSTICK_GPU=require, but {reason}");
}

/// A renderer; `None` only where there is no adapter at all. An adapter that cannot be used is a failure.
pub(crate) fn gpu() -> Option<GpuRenderer> {
    if adapters().is_empty() {
        skip_or_fail("there is no graphics adapter");
        return None;
    }
    Some(GpuRenderer::new(AdapterWish::Any).unwrap())
}

/// The same on OpenGL; `None` only where no adapter is reached by it.
fn opengl() -> Option<GpuRenderer> {
    if !adapters().iter().any(|adapter| adapter.backend == "gl") {
        skip_or_fail("there is no OpenGL adapter (on Linux: EGL and a driver)");
        return None;
    }
    let gpu = GpuRenderer::new(AdapterWish::OpenGl).unwrap();
    assert_eq!(gpu.adapter().unwrap().backend, "gl");
    Some(gpu)
}

/// Of so many pixels, so many agree.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Share {
    of: usize,
    good: usize,
}

impl Share {
    fn count(&mut self, good: bool) {
        self.of += 1;
        self.good += usize::from(good);
    }

    fn part(self) -> f64 {
        self.good as f64 / self.of.max(1) as f64
    }
}

/// Ids are compared where the 3×3 pixels around show one thing, the rest where the ids are the same.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Surfaces {
    covered: usize,
    id: Share,
    depth: Share,
    normal: Share,
}

fn is_primitive(id: u32) -> bool {
    id != GBuffer::BACKGROUND && id != GBuffer::GROUND
}

/// Counts where two G-buffers agree; an error if they have not the same size or show nothing.
fn compare_surfaces(want: &GBuffer, got: &GBuffer) -> Result<Surfaces, String> {
    let (width, height) = (want.width as usize, want.height as usize);
    let same_size = (want.width, want.height) == (got.width, got.height);
    if !same_size || [got.id.len(), got.depth.len(), got.normal.len()] != [width * height; 3] {
        return Err(format!("{width}×{height} against {}×{}", got.width, got.height));
    }
    let mut surfaces = Surfaces::default();
    for i in 0..width * height {
        if !is_primitive(want.id[i]) && !is_primitive(got.id[i]) {
            continue;
        }
        surfaces.covered += 1;
        let (x, y) = (i % width, i / width);
        let around = (y.saturating_sub(1)..=(y + 1).min(height - 1))
            .flat_map(|y| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |x| y * width + x));
        if around.into_iter().any(|j| want.id[j] != want.id[i]) {
            continue;
        }
        surfaces.id.count(want.id[i] == got.id[i]);
        if want.id[i] == got.id[i] {
            surfaces.depth.count((want.depth[i] - got.depth[i]).abs() <= 1e-4 * want.depth[i].abs());
            let apart = Vec3::from(want.normal[i]) - Vec3::from(got.normal[i]);
            surfaces.normal.count(apart.length() <= 1e-3);
        }
    }
    if surfaces.covered == 0 {
        return Err("nothing to compare".to_owned());
    }
    Ok(surfaces)
}

/// What is wrong with two G-buffers, if anything. The ground is compared wherever both show it.
fn judge_surfaces(want: &GBuffer, got: &GBuffer) -> Result<Surfaces, String> {
    let surfaces = compare_surfaces(want, got)?;
    let Surfaces { covered, id, depth, normal } = surfaces;
    if (id.of as f64) < 0.2 * covered as f64 {
        return Err(format!("only {} of {covered} covered pixels can be compared", id.of));
    }
    for (what, share) in [("ids", id), ("depths", depth), ("normals", normal)] {
        if share.part() < 0.999 {
            return Err(format!("{what} agree on {} of {} pixels", share.good, share.of));
        }
    }
    let ground = |i: &usize| want.id[*i] == GBuffer::GROUND && got.id[*i] == GBuffer::GROUND;
    let off = |i: &usize| (want.depth[*i] - got.depth[*i]).abs() > 1e-4 * want.depth[*i];
    match (0..want.id.len()).filter(ground).find(off) {
        Some(i) => Err(format!("the ground is at {} instead of {}", got.depth[i], want.depth[i])),
        None => Ok(surfaces),
    }
}

/// Share of the pixels that either G-buffer covers (the ground counts) in which every channel is within 2/255.
fn compare_colors(want: &Image, got: &Image, seen: [&GBuffer; 2]) -> Result<Share, String> {
    let pixels = want.width as usize * want.height as usize;
    let same_size = (want.width, want.height) == (got.width, got.height);
    if !same_size || seen.iter().any(|seen| seen.id.len() != pixels) || got.rgba.len() != 4 * pixels {
        return Err(format!("{}×{} against {}×{}", want.width, want.height, got.width, got.height));
    }
    let mut share = Share::default();
    for (i, (a, b)) in want.rgba.chunks(4).zip(got.rgba.chunks(4)).enumerate() {
        if seen.iter().any(|seen| seen.id[i] != GBuffer::BACKGROUND) {
            share.count(a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 2));
        }
    }
    if share.of == 0 { Err("nothing to compare".to_owned()) } else { Ok(share) }
}

fn judge_colors(want: &Image, got: &Image, seen: [&GBuffer; 2]) -> Result<Share, String> {
    let share = compare_colors(want, got, seen)?;
    if share.part() < 0.995 {
        return Err(format!("colours agree on {} of {} pixels", share.good, share.of));
    }
    Ok(share)
}

/// Two finished pictures, over the pixels that either covers: how far apart in the mean of all channels, and the share of
/// pixels in which every channel is within 4/255. Which points see a light is the same but for rounding.
fn compare_finished(want: &Image, got: &Image, seen: [&GBuffer; 2]) -> Result<(f64, f64), String> {
    compare_colors(want, got, seen)?;
    let (mut sum, mut share) = (0u64, Share::default());
    for (i, (a, b)) in want.rgba.chunks(4).zip(got.rgba.chunks(4)).enumerate() {
        if seen.iter().any(|seen| seen.id[i] != GBuffer::BACKGROUND) {
            let apart = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
            sum += apart.clone().map(u64::from).sum::<u64>();
            share.count(apart.max().unwrap_or(0) <= 4);
        }
    }
    Ok((sum as f64 / (4 * share.of) as f64, share.part()))
}

fn judge_finished(want: &Image, got: &Image, seen: [&GBuffer; 2]) -> Result<(f64, f64), String> {
    let (mean, part) = compare_finished(want, got, seen)?;
    if mean > 1.0 || part < 0.995 {
        return Err(format!(
            "finished pictures are {mean:.3}/255 apart in the mean, {:.2} % within 4/255",
            100.0 * part
        ));
    }
    Ok((mean, part))
}

/// Both renderers on one scene; the message says what differs.
fn judge(gpu: &mut GpuRenderer, name: &str, scene: &Arc<Scene>, view: &View) -> Result<(), String> {
    judge_with(gpu, name, scene, view, &QUICK)
}

fn judge_with(
    gpu: &mut GpuRenderer,
    name: &str,
    scene: &Arc<Scene>,
    view: &View,
    finished: &Settings,
) -> Result<(), String> {
    let failed = |error: ballstick::Error| error.to_string();
    let mut cpu = CpuRenderer::new();
    cpu.load(Arc::clone(scene)).map_err(failed)?;
    gpu.load(Arc::clone(scene)).map_err(failed)?;
    let (want, got) = (cpu.gbuffer(view).map_err(failed)?, gpu.gbuffer(view).map_err(failed)?);
    let surfaces = judge_surfaces(&want, &got)?;
    let images = (cpu.image(view, &SETTINGS).map_err(failed)?, gpu.image(view, &SETTINGS).map_err(failed)?);
    let colors = judge_colors(&images.0, &images.1, [&want, &got])?;
    let images = (cpu.image(view, finished).map_err(failed)?, gpu.image(view, finished).map_err(failed)?);
    let (mean, part) = judge_finished(&images.0, &images.1, [&want, &got])?;
    println!("{name}: finished {mean:.3}/255 apart in the mean, {:.3} % within 4/255", 100.0 * part);
    println!(
        "{name}: {} covered, {} compared; wrong: {} ids, {} depths, {} normals, {} of {} colours",
        surfaces.covered,
        surfaces.id.of,
        surfaces.id.of - surfaces.id.good,
        surfaces.depth.of - surfaces.depth.good,
        surfaces.normal.of - surfaces.normal.good,
        colors.of - colors.good,
        colors.of,
    );
    Ok(())
}

/// The scenes of the golden pictures, twice as large, without the one that shows nothing.
fn cases() -> Vec<Case> {
    let mut cases = scenes::all();
    cases.retain(|case| case.name != "nothing");
    for case in &mut cases {
        if case.name == "molecule_wireframe" {
            // Sticks must be wide enough to have an inside.
            (case.view.width, case.view.height) = (16 * case.view.width, 16 * case.view.height);
            case.view.region = Some(Region { x: 800, y: 600, width: 320, height: 240 });
        } else if case.view.region.is_none() {
            (case.view.width, case.view.height) = (2 * case.view.width, 2 * case.view.height);
        }
    }
    cases
}

fn case(name: &str) -> Case {
    cases().into_iter().find(|case| case.name == name).unwrap()
}

fn judge_all_scenes(mut gpu: GpuRenderer) {
    let mut wrong = Vec::new();
    let cases = cases();
    assert!(cases.len() > 20);
    for case in &cases {
        if let Err(error) = judge(&mut gpu, case.name, &Arc::new(case.scene.clone()), &case.view) {
            wrong.push(format!("{}: {error}", case.name));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", gpu.name(), wrong.join("\n"));
}

#[test]
fn gpu_and_cpu_draw_the_same_scenes() {
    let Some(gpu) = gpu() else { return };
    judge_all_scenes(gpu);
}

#[test]
fn opengl_and_cpu_draw_the_same_scenes() {
    let Some(gpu) = opengl() else { return };
    judge_all_scenes(gpu);
}

/// Under the limits of the smallest devices, which is what old OpenGL drivers have, in tiles.
#[test]
fn opengl_finishes_a_picture_wider_than_a_texture() {
    let Some(mut whole) = opengl() else { return };
    let mut small = GpuRenderer::with_limits(AdapterWish::OpenGl, &wgpu::Limits::downlevel_webgl2_defaults()).unwrap();
    draws_the_same_in_tiles(&mut whole, &mut small);
}

/// All molecules of data/, in turn as balls and sticks, sticks, and space-filling, in both projections. Large ones are
/// looked at through a part of a larger picture, where their atoms are wide enough to have an inside.
#[test]
fn gpu_and_cpu_draw_the_same_molecules() {
    let Some(mut gpu) = gpu() else { return };
    let mut wrong = Vec::new();
    for (i, (name, drawn)) in molecules().into_iter().enumerate() {
        let style = [Style::BallAndStick, Style::Licorice, Style::SpaceFilling][i % 3];
        let options = SceneOptions { style, perspective: i % 2 == 0, ..SceneOptions::default() };
        let scene = Scene::new(&[Item::drawn(&drawn, None)], &options);
        let scale = if drawn.structure.atom_count() > 200 { 8 } else { 2 };
        let mut view = View::new(scene.fitted_camera(16.0 / 9.0), 320 * scale, 180 * scale);
        view.region = Some(Region { x: 160 * (scale - 1), y: 90 * (scale - 1), width: 320, height: 180 });
        if let Err(error) = judge(&mut gpu, &name, &Arc::new(scene), &view) {
            wrong.push(format!("{name}: {error}"));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", gpu.name(), wrong.join("\n"));
}

/// As [`judge_with`] at full quality, for scenes of other files.
pub(crate) fn judge_whole(gpu: &mut GpuRenderer, name: &str, scene: &Arc<Scene>, view: &View) -> Result<(), String> {
    judge_with(gpu, name, scene, view, &FINISHED)
}

/// At full quality: the scene of a molecule on its ground, seen whole.
#[test]
fn gpu_and_cpu_finish_the_same_picture() {
    let Some(mut gpu) = gpu() else { return };
    for name in ["molecule_on_ground", "molecule_licorice", "placements"] {
        let case = case(name);
        judge_with(&mut gpu, name, &Arc::new(case.scene.clone()), &case.view, &FINISHED).unwrap();
    }
}

/// Where the two draw the same without text, they do with it.
#[test]
fn gpu_and_cpu_write_the_same_text() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = CpuRenderer::new();
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/caffeine.sdf");
    let molecule = read_path(&path, &ImportOptions::default()).unwrap().records.remove(0);
    let labels = LabelContent { element: true, index: true, ..LabelContent::default() };
    let overlay = OverlayOptions { labels, legend: true, scale_bar: true, ..OverlayOptions::default() };
    let pictures = [OverlayOptions::default(), overlay].map(|overlay| {
        let options = SceneOptions { text: overlay, background: Background::Transparent, ..SceneOptions::default() };
        let scene = Arc::new(Scene::new(&[Item::of(&molecule)], &options));
        let view = View::new(scene.fitted_camera(16.0 / 9.0), 480, 270);
        cpu.load(Arc::clone(&scene)).unwrap();
        gpu.load(scene).unwrap();
        [cpu.image(&view, &SETTINGS).unwrap(), gpu.image(&view, &SETTINGS).unwrap()]
    });
    let [[plain_cpu, plain_gpu], [cpu, gpu]] = pictures.each_ref().map(|pair| pair.each_ref().map(|image| &image.rgba));
    let mut written = 0;
    for i in (0..cpu.len()).step_by(4).map(|start| start..start + 4) {
        if plain_cpu[i.clone()] == plain_gpu[i.clone()] {
            written += usize::from(cpu[i.clone()] != plain_cpu[i.clone()]);
            assert_eq!(cpu[i.clone()], gpu[i.clone()], "pixel {}", i.start / 4);
        }
    }
    assert!(written > 2000, "{written} pixels with text");
}

#[test]
fn nothing_is_nothing_on_both() {
    let Some(mut gpu) = gpu() else { return };
    let empty = scenes::all().into_iter().find(|case| case.name == "nothing").unwrap();
    let mut cpu = CpuRenderer::new();
    // Before any scene is loaded, and with an empty one.
    assert_eq!(gpu.image(&empty.view, &SETTINGS).unwrap(), cpu.image(&empty.view, &SETTINGS).unwrap());
    let mut scene = empty.scene;
    for background in [Background::default(), Background::Transparent] {
        scene.background = background;
        let shared = Arc::new(scene.clone());
        cpu.load(Arc::clone(&shared)).unwrap();
        gpu.load(shared).unwrap();
        assert_eq!(gpu.image(&empty.view, &SETTINGS).unwrap(), cpu.image(&empty.view, &SETTINGS).unwrap());
        assert_eq!(gpu.gbuffer(&empty.view).unwrap(), cpu.gbuffer(&empty.view).unwrap());
    }
}

#[test]
fn regions_of_a_picture_are_pieces_of_it() {
    let Some(mut gpu) = gpu() else { return };
    let case = case("molecule_on_ground");
    gpu.load(Arc::new(case.scene.clone())).unwrap();
    let whole = gpu.image(&case.view, &SETTINGS).unwrap();
    let row = |image: &Image, y: u32, x0: u32, x1: u32| {
        let at = |x: u32| (y as usize * image.width as usize + x as usize) * 4;
        image.rgba[at(x0)..at(x1)].to_vec()
    };
    let (width, height) = (case.view.width, case.view.height);
    for (x, y, w, h) in [(0, 0, 100, 77), (100, 0, width - 100, 77), (0, 77, width, height - 77), (131, 93, 1, 1)] {
        let region = Region { x, y, width: w, height: h };
        let piece = gpu.image(&View { region: Some(region), ..case.view }, &SETTINGS).unwrap();
        assert_eq!((piece.width, piece.height), (w, h));
        for line in 0..h {
            assert_eq!(row(&piece, line, 0, w), row(&whole, y + line, x, x + w), "row {line} of {region:?}");
        }
    }
}

#[test]
fn small_devices_draw_the_same_picture_in_tiles() {
    let Some(mut gpu) = gpu() else { return };
    let mut small = GpuRenderer::with_limits(AdapterWish::Any, &wgpu::Limits::downlevel_webgl2_defaults()).unwrap();
    draws_the_same_in_tiles(&mut gpu, &mut small);
}

/// `small` is the same device under the smallest limits.
fn draws_the_same_in_tiles(gpu: &mut GpuRenderer, small: &mut GpuRenderer) {
    let case = case("molecule_on_ground");
    let scene = Arc::new(case.scene.clone());
    // Wider than a texture of the small device, and only a strip of it, to be quick.
    let mut view = View::new(scene.fitted_camera(4.0), 2600, 650);
    view.region = Some(Region { x: 0, y: 300, width: 2600, height: 40 });
    for renderer in [&mut *gpu, &mut *small] {
        renderer.load(Arc::clone(&scene)).unwrap();
    }
    for settings in [SETTINGS, QUICK] {
        let (want, got) = (gpu.image(&view, &settings).unwrap(), small.image(&view, &settings).unwrap());
        assert!(want == got, "the tiles show");
    }
}

#[test]
fn small_devices_that_ask_one_sample_at_a_time_see_the_same_light() {
    let Some(mut gpu) = gpu() else { return };
    let mut small = GpuRenderer::with_limits(AdapterWish::Any, &wgpu::Limits::downlevel_webgl2_defaults()).unwrap();
    let block: Block = case("molecule_on_ground").scene.blocks[0].clone();
    // Tubes of 64 directions are more than 2048 × 2048 words, those of a quarter of them are not.
    let placements = (0..1600)
        .map(|i| Placement {
            block: 0,
            world_from_block: Affine3A::from_translation(
                Vec3::new((i % 40) as f32, (i % 3) as f32, (i / 40) as f32) * 6.0,
            ) * Affine3A::from_rotation_y(i as f32),
            first_id: i * block.id_count,
        })
        .collect();
    let scene = Arc::new(Scene::from_blocks(vec![block], placements));
    let mut view = View::new(scene.fitted_camera(1.5), 960, 640);
    view.region = Some(Region { x: 450, y: 300, width: 60, height: 40 });
    let settings = Settings { samples: 4, ground_texels: 96, ao: 64, shadow: true };
    for renderer in [&mut gpu, &mut small] {
        renderer.load(Arc::clone(&scene)).unwrap();
    }
    let (want, got) = (gpu.image(&view, &settings).unwrap(), small.image(&view, &settings).unwrap());
    assert!(want == got);
    assert!(want != gpu.image(&view, &SETTINGS).unwrap(), "light from afar shows");
}

/// A view of a scene from so far away that it fills the picture as in the case.
fn from_afar(case: &Case, distance: f32) -> View {
    let mut view = case.view;
    let camera = &mut view.camera;
    let height = match camera.projection {
        Projection::Perspective { fov_y_rad } => 2.0 * (fov_y_rad / 2.0).tan() * camera.eye.distance(camera.target),
        Projection::Orthographic { height } => height,
    };
    camera.eye = camera.target + camera.world_from_view * Vec3::Z * distance;
    camera.projection = Projection::Perspective { fov_y_rad: 2.0 * (0.5 * height / distance).atan() };
    (camera.near, camera.far) = (0.5 * distance, 2.0 * distance);
    view
}

#[test]
fn surfaces_far_away_do_not_hide_their_own_light() {
    let Some(mut gpu) = gpu() else { return };
    for distance in [30.0, 300.0, 3000.0, 10_000.0] {
        let case = case("molecule");
        let view = from_afar(&case, distance);
        // Alone, a ball and a stick see all light on the side that is turned to it: a wrong point is dark.
        let [ball, stick] = [|block: &mut Block| block.cylinders.clear(), |block: &mut Block| block.spheres.clear()];
        for (name, keep) in [("ball", ball as fn(&mut Block)), ("stick", stick)] {
            let mut block = case.scene.blocks[0].clone();
            keep(&mut block);
            block.spheres.truncate(1);
            block.cylinders.truncate(1);
            let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
            let scene = Arc::new(Scene::from_blocks(vec![block], vec![placement]));
            gpu.load(Arc::clone(&scene)).unwrap();
            let want = reference::image(&scene, &view, &QUICK);
            let got = gpu.image(&view, &QUICK).unwrap();
            let off = |(a, b): (&[u8], &[u8])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 4);
            let wrong = want.rgba.chunks(4).zip(got.rgba.chunks(4)).filter(|pair| off(*pair)).count();
            println!("{name} at {distance} Å: {wrong} pixels are off");
            assert!(wrong <= 2, "{name} at {distance} Å: {wrong} pixels");
        }
        // Farther away the rounding of depths moves the edges of shadows by more than a colour may differ.
        if distance < 1000.0 {
            let name = format!("molecule at {distance} Å");
            judge(&mut gpu, &name, &Arc::new(case.scene.clone()), &view).unwrap();
        }
    }
}

#[test]
fn many_placements_and_another_light_need_no_new_upload() {
    let Some(mut gpu) = gpu() else { return };
    let molecule = case("molecule_on_ground").scene;
    let block: Block = molecule.blocks[0].clone();
    let placements = (0..25)
        .map(|i| Placement {
            block: 0,
            world_from_block: Affine3A::from_translation(Vec3::new((i % 5) as f32 * 7.0, 0.0, (i / 5) as f32 * -6.0))
                * Affine3A::from_rotation_y(i as f32),
            first_id: i * block.id_count,
        })
        .collect();
    let mut scene = Scene::from_blocks(vec![block], placements);
    scene.world_from_view = glam::Quat::from_rotation_x(-0.3);
    scene.set_ground(true);
    let view = View::new(scene.fitted_camera(1.5), 360, 240);
    judge(&mut gpu, "25 placements", &Arc::new(scene.clone()), &view).unwrap();
    scene.lighting.key_in_view = Vec3::new(0.6, 0.6, 0.5).normalize();
    judge(&mut gpu, "light from the right", &Arc::new(scene), &view).unwrap();
}

/// What was made between two looks at the counters.
fn made(before: Work, after: Work) -> Work {
    Work {
        pipelines: after.pipelines - before.pipelines,
        textures: after.textures - before.textures,
        buffers: after.buffers - before.buffers,
        bytes: after.bytes - before.bytes,
    }
}

#[test]
fn the_same_picture_again_makes_nothing_but_what_it_is_handed_back_in() {
    let Some(mut gpu) = gpu() else { return };
    let case = case("all_primitives_on_ground");
    gpu.load(Arc::new(case.scene.clone())).unwrap();
    let first = gpu.image(&case.view, &QUICK).unwrap();
    let before = gpu.work();
    gpu.load(Arc::new(case.scene.clone())).unwrap();
    assert!(gpu.image(&case.view, &QUICK).unwrap() == first);
    // The constants of four samples and of their mean; the picture and the buffer it is read from.
    let bytes = 5 * size_of::<SampleConstants>() as u64;
    assert_eq!(made(before, gpu.work()), Work { pipelines: 0, textures: 1, buffers: 1, bytes });
}

#[test]
fn frames_of_a_resting_window_add_samples_and_nothing_else_and_end_at_the_still() {
    let Some(mut gpu) = gpu() else { return };
    for name in ["all_primitives_on_ground", "molecule_on_ground", "fog", "depth_of_field"] {
        let case = case(name);
        gpu.load(Arc::new(case.scene.clone())).unwrap();
        // In motion, then at rest, sample by sample and a few at a time.
        let mut sum = Accumulation::default();
        let in_motion = Settings { samples: 1, ground_texels: 96, ao: 0, shadow: false };
        gpu.accumulate(&mut sum, &case.view, &in_motion, 0, 1).unwrap();
        let glance = gpu.shown(&sum).unwrap();
        let opaque = |image: &Image| image.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255);
        assert!(opaque(&glance) && glance.rgba.chunks_exact(4).any(|pixel| pixel[..3] != glance.rgba[..3]));
        gpu.accumulate(&mut sum, &case.view, &FINISHED, 0, 1).unwrap();
        let before = gpu.work();
        for (done, add) in [(1, 1), (2, 1), (3, 4), (7, 2), (9, 7)] {
            gpu.accumulate(&mut sum, &case.view, &FINISHED, done, add).unwrap();
        }
        let bytes = 15 * size_of::<SampleConstants>() as u64;
        // Through a lens every sample has a camera.
        if case.scene.depth_of_field.is_none() {
            assert_eq!(made(before, gpu.work()), Work { bytes, ..Work::default() }, "{name}");
        }
        let still = gpu.image(&case.view, &FINISHED).unwrap();
        assert!(gpu.shown(&sum).unwrap() == still, "{name}: the window ends at another picture than the still");
        assert!(glance != still);
    }
}

#[test]
fn a_lost_device_is_an_error_of_every_call() {
    let Some(mut gpu) = gpu() else { return };
    let case = case("molecule");
    let scene = Arc::new(case.scene.clone());
    gpu.load(Arc::clone(&scene)).unwrap();
    gpu.image(&case.view, &SETTINGS).unwrap();
    gpu.lose_device();
    assert!(gpu.image(&case.view, &SETTINGS).is_err());
    assert!(gpu.gbuffer(&case.view).is_err());
    assert!(gpu.sky_visibility(&case.view, 4).is_err());
    assert!(gpu.load(Arc::new(Scene::from_blocks(vec![Block::default()], vec![]))).is_err());
}

/// What the CPU shows of a scene, as something to spoil.
fn shown() -> (GBuffer, Image) {
    let case = case("molecule_on_ground");
    let mut cpu = CpuRenderer::new();
    cpu.load(Arc::new(case.scene)).unwrap();
    (cpu.gbuffer(&case.view).unwrap(), cpu.image(&case.view, &SETTINGS).unwrap())
}

#[test]
fn the_comparer_accepts_what_is_the_same() {
    let (seen, image) = shown();
    let surfaces = judge_surfaces(&seen, &seen).unwrap();
    assert_eq!(surfaces.id.good, surfaces.id.of);
    assert!(judge_colors(&image, &image, [&seen, &seen]).is_ok());
}

#[test]
fn the_comparer_refuses_other_sizes_and_emptiness() {
    let (seen, image) = shown();
    let mut cut = seen.clone();
    cut.height -= 1;
    cut.id.truncate((cut.width * cut.height) as usize);
    assert!(judge_surfaces(&seen, &cut).is_err());
    assert!(judge_finished(&image, &image, [&seen, &seen]).is_ok());
    let darker = Image { rgba: image.rgba.iter().map(|c| c.saturating_sub(3)).collect(), ..image.clone() };
    assert!(judge_finished(&image, &darker, [&seen, &seen]).unwrap_err().contains("mean"));
    let mut short = image.clone();
    short.rgba.truncate(40);
    assert!(judge_colors(&image, &short, [&seen, &seen]).is_err());
    let mut empty = seen.clone();
    empty.id.fill(GBuffer::BACKGROUND);
    assert!(judge_surfaces(&empty, &empty).unwrap_err().contains("nothing"));
    assert!(judge_colors(&image, &image, [&empty, &empty]).unwrap_err().contains("nothing"));
    assert!(judge_surfaces(&seen, &empty).is_err() && judge_surfaces(&empty, &seen).is_err());
}

#[test]
fn the_comparer_sees_a_shift_and_a_swap() {
    let (seen, image) = shown();
    let mut shifted = seen.clone();
    shifted.id.rotate_right(1);
    shifted.depth.rotate_right(1);
    shifted.normal.rotate_right(1);
    assert!(judge_surfaces(&seen, &shifted).is_err());
    let mut moved = image.clone();
    moved.rgba.rotate_right(4);
    assert!(judge_colors(&image, &moved, [&seen, &seen]).is_err());
    let mut swapped = image.clone();
    swapped.rgba.chunks_mut(4).for_each(|pixel| pixel.swap(0, 2));
    assert!(judge_colors(&image, &swapped, [&seen, &seen]).is_err());
    let mut faded = image.clone();
    faded.rgba.chunks_mut(4).for_each(|pixel| pixel[3] = pixel[3].saturating_sub(9));
    assert!(judge_colors(&image, &faded, [&seen, &seen]).is_err());
    for spoil in [|n: &mut [f32; 3]| n[2] = -n[2], |n: &mut [f32; 3]| n.swap(0, 1)] {
        let mut turned = seen.clone();
        turned.normal.iter_mut().for_each(spoil);
        assert!(judge_surfaces(&seen, &turned).unwrap_err().contains("normals"));
    }
    let mut nearer = seen.clone();
    nearer.depth.iter_mut().for_each(|depth| *depth *= 0.999);
    assert!(judge_surfaces(&seen, &nearer).unwrap_err().contains("depths"));
}

/// Tens of thousands of see-through triangles above one another: a shader that asks them all at every point of the ground takes so long that
/// devices stop it half-way.
#[test]
fn fine_see_through_meshes_darken_the_ground_alike() {
    let Some(mut gpu) = gpu() else { return };
    let mut block = Block { id_count: 1, ..Block::default() };
    let corner =
        |x: i32, z: i32, layer: i32| [0.1 * x as f32, 0.15 * layer as f32 + 0.05 * (x as f32).sin(), 0.1 * z as f32];
    let color = ballstick::color::Srgb8 { a: 100, ..ballstick::color::Srgb8::rgb(90, 140, 220) };
    for (layer, x, z) in (0..30).flat_map(|layer| (0..30).flat_map(move |x| (0..30).map(move |z| (layer, x, z)))) {
        let [a, b, c, d] = [(x, z), (x + 1, z), (x + 1, z + 1), (x, z + 1)].map(|(x, z)| corner(x, z, layer));
        block.triangles.extend([[a, b, c], [a, c, d]].map(|corners| ballstick::scene::TriangleInstance {
            corners,
            normals: [[0.0; 3]; 3],
            colors: [color; 3],
            id: 1,
            reserved: [0; 2],
        }));
    }
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    let mut scene = Scene::from_blocks(vec![block], vec![placement]);
    scene.set_ground(true);
    let scene = Arc::new(scene);
    let view = View::new(scene.fitted_camera(1.5), 90, 60);
    let mut cpu = CpuRenderer::new();
    let [want, got] = [&mut cpu as &mut dyn Renderer, &mut gpu].map(|renderer| {
        renderer.load(Arc::clone(&scene)).unwrap();
        renderer.image(&view, &SETTINGS).unwrap()
    });
    let apart = want.rgba.iter().zip(&got.rgba).filter(|(a, b)| a.abs_diff(**b) > 4).count();
    assert!(apart * 1000 < want.rgba.len(), "{apart} of {}", want.rgba.len());
}
