//! Scenes drawn from their blocks against the same spread out.

use super::*;
use crate::color::Srgb8;
use crate::render::Quality;
use crate::render::test_shapes::Random;
use crate::scene::{
    Block, Camera, ConeInstance, CylinderInstance, DepthOfField, Placement, Projection, SphereInstance, TorusInstance,
};
use glam::{Affine3A, Mat3, Quat, Vec3};

/// A folded chain of balls and sticks with all kinds of ends, rings and cones about it; `opacity` of every eleventh.
fn chain(seed: u64, count: u32, opacity: u8) -> Block {
    let mut random = Random(seed);
    let mut at = Vec3::ZERO;
    let limit = 2.2 * (count as f32).cbrt();
    let mut block = Block { id_count: 2 * count, ..Block::default() };
    while block.spheres.len() < count as usize {
        let next = at + random.direction().as_vec3() * 1.5;
        if next.length() > limit {
            continue;
        }
        let id = block.spheres.len() as u32 + 1;
        let a = if id.is_multiple_of(11) { opacity } else { 255 };
        let color = Srgb8 { a, ..Srgb8::rgb((id * 37 % 256) as u8, (id * 59 % 256) as u8, 120) };
        block.spheres.push(SphereInstance { center: next.to_array(), radius: 0.4, color, id });
        let caps = [5, 10, 0, 6][id as usize % 4];
        let [color_a, color_b] = [color, Srgb8 { a, ..Srgb8::WHITE }];
        let (a, b, hidden) = (at.to_array(), next.to_array(), if id.is_multiple_of(3) { 0 } else { 3 });
        block.cylinders.push(CylinderInstance { a, radius: 0.15, b, id: count + id, color_a, color_b, caps, hidden });
        if id.is_multiple_of(40) {
            let axis = (next - at).normalize().to_array();
            let (ring_radius, tube_radius, reserved) = (1.5, 0.2, [0; 2]);
            block.tori.push(TorusInstance { center: b, ring_radius, axis, tube_radius, color, id, reserved });
            let far = (next * 1.3).to_array();
            block.cones.push(ConeInstance { a: b, radius_a: 0.5, b: far, radius_b: 0.0, color, id, reserved: [0; 2] });
        }
        at = next;
    }
    block
}

/// Seven copies, some of them mirrored, and a block that stands once; a quarter of it in the picture's corner.
fn scene(opacity: u8) -> Arc<Scene> {
    let blocks = vec![chain(1, 900, opacity), chain(2, 150, 255)];
    let mut placements = vec![];
    for copy in 0..7u32 {
        let turn = Mat3::from_quat(Quat::from_rotation_y(copy as f32) * Quat::from_rotation_x(0.4 * copy as f32));
        let mirror = Mat3::from_diagonal(Vec3::new(if copy % 3 == 2 { -1.0 } else { 1.0 }, 1.0, 1.0));
        let to = Quat::from_rotation_y(0.9 * copy as f32) * Vec3::new(33.0, 3.0 * copy as f32 - 9.0, 0.0);
        let world_from_block = Affine3A::from_mat3_translation(turn * mirror, to);
        placements.push(Placement { block: 0, world_from_block, first_id: copy * 1800 });
    }
    placements.push(Placement { block: 1, world_from_block: Affine3A::IDENTITY, first_id: 7 * 1800 });
    let mut scene = Scene::from_blocks(blocks, placements);
    scene.set_ground(true);
    Arc::new(scene)
}

fn renderer(scene: &Arc<Scene>, most_spread: usize) -> CpuRenderer {
    let mut renderer = CpuRenderer { most_spread, ..CpuRenderer::default() };
    renderer.load(Arc::clone(scene)).unwrap();
    assert_eq!(renderer.of_copies, most_spread == 0);
    renderer
}

/// One that spreads all out, and whose points ask together.
fn asking_together(scene: &Arc<Scene>) -> CpuRenderer {
    let mut renderer = CpuRenderer { most_spread: usize::MAX, most_at_once: 0, ..CpuRenderer::default() };
    renderer.load(Arc::clone(scene)).unwrap();
    assert!(renderer.asks_together() && !renderer.of_copies, "{:?}", renderer.counts);
    renderer
}

fn view(scene: &Scene, projection: Option<Projection>) -> View {
    let camera = scene.fitted_camera(1.5);
    View::new(Camera { projection: projection.unwrap_or(camera.projection), ..camera }, 240, 160)
}

/// Mean difference of the channels, in steps of 1/255.
fn apart(a: &Image, b: &Image) -> f64 {
    let sum: f64 = a.rgba.iter().zip(&b.rgba).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    assert_eq!(a.rgba.len(), b.rgba.len());
    sum / a.rgba.len() as f64
}

#[test]
fn copies_look_as_they_do_spread_out() {
    let lens = DepthOfField { blur: 0.03, focus: 0.3 };
    let settings = [Quality::Draft.settings(), Quality::Standard.settings()];
    let settings = [settings[0], Settings { samples: 4, ground_texels: 64, ..settings[1] }];
    for (case, opacity, outline, lens, projection) in [
        ("plain", 255, 0.0, None, None),
        ("parallel", 255, 0.0, None, Some(Projection::Orthographic { height: 70.0 })),
        ("see-through", 90, 0.0, None, None),
        ("with lines", 255, 0.006, None, None),
        ("all at once", 90, 0.006, Some(lens), None),
    ] {
        let mut scene = scene(opacity);
        let inner = Arc::get_mut(&mut scene).unwrap();
        (inner.lighting.outline.width, inner.depth_of_field) = (outline, lens);
        let view = view(&scene, projection);
        for settings in settings {
            let [of_copies, spread] =
                [0, usize::MAX].map(|most| renderer(&scene, most).image(&view, &settings).unwrap());
            let off = apart(&of_copies, &spread);
            println!("{case}, {} directions: {off:.4} of 255", settings.ao);
            assert!(off < 0.25, "{case}, {} directions: {off}", settings.ao);
            // And where points ask together, as those of large scenes do.
            let mut renderer = asking_together(&scene);
            let off = apart(&renderer.image(&view, &settings).unwrap(), &spread);
            println!("{case}, together: {off:.4} of 255");
            assert!(off < if settings.ao > 0 { 0.05 } else { 1e-9 }, "{case}, together: {off}");
            let plain = spread.rgba.chunks_exact(4).filter(|pixel| *pixel == &spread.rgba[..4]).count();
            assert!(plain < spread.rgba.len() * 7 / 32, "{case} shows little");
        }
    }
}

#[test]
fn any_number_of_samples_can_ask_together() {
    let scene = scene(255);
    let view = view(&scene, None);
    for samples in [1, 3, 16, 37, 64] {
        let settings = Settings { samples, ao: 8, ground_texels: 64, ..Quality::Standard.settings() };
        let [together, at_once] = [asking_together(&scene), renderer(&scene, usize::MAX)]
            .map(|mut renderer| renderer.image(&view, &settings).unwrap());
        let off = apart(&together, &at_once);
        assert!(off < 0.05, "{samples} samples: {off}");
    }
}

#[test]
fn parts_of_a_picture_whose_points_ask_together_are_those_of_the_whole() {
    let scene = scene(90);
    let whole = view(&scene, None);
    let settings = Settings { samples: 4, ground_texels: 64, ..Quality::Standard.settings() };
    let mut renderer = asking_together(&scene);
    let want = renderer.image(&whole, &settings).unwrap();
    let region = crate::scene::Region { x: 70, y: 30, width: 90, height: 70 };
    let got = renderer.image(&View { region: Some(region), ..whole }, &settings).unwrap();
    for y in 0..region.height {
        let row = |image: &Image, x: u32, y: u32| {
            let start = ((y * image.width + x) * 4) as usize;
            image.rgba[start..start + region.width as usize * 4].to_vec()
        };
        assert_eq!(row(&got, 0, y), row(&want, region.x, region.y + y), "row {y}");
    }
}

#[test]
fn copies_have_the_ids_depths_and_sky_that_they_have_spread_out() {
    for opacity in [255, 90] {
        let scene = scene(opacity);
        let view = view(&scene, None);
        let [of_copies, spread] = [0, usize::MAX].map(|most| renderer(&scene, most).gbuffer(&view).unwrap());
        assert_eq!(of_copies.id, spread.id);
        assert_eq!((&of_copies.depth, &of_copies.normal), (&spread.depth, &spread.normal));
        assert!(spread.id.iter().filter(|&&id| id != GBuffer::BACKGROUND && id != GBuffer::GROUND).count() > 4000);
        let [of_copies, spread] = [0, usize::MAX].map(|most| renderer(&scene, most).sky_visibility(&view, 64).unwrap());
        let off: f32 = of_copies.open.iter().zip(&spread.open).map(|(a, b)| (a - b).abs()).sum();
        let off = off / spread.open.len() as f32;
        println!("sky: {off}");
        assert!(off < 1e-3, "{off}");
    }
}

#[test]
fn only_what_is_placed_often_and_is_large_is_drawn_from_its_blocks() {
    let scene = scene(255);
    let counts = Counts::of(&scene);
    assert!(counts.is_of_copies(10_000) && !counts.is_of_copies(MOST_SPREAD));
    let mut once = Scene::clone(&scene);
    once.placements.drain(..6);
    assert!(!Counts::of(&once).is_of_copies(0));
}
