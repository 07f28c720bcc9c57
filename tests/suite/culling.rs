//! What the GPU leaves out shows nowhere: pictures with and without culling are the same to the byte.

use crate::parity::gpu;
use ballstick::color::Srgb8;
use ballstick::render::gpu::{AdapterWish, Culling, GpuRenderer};
use ballstick::render::{Image, Renderer, Settings, View};
use ballstick::scene::{
    Block, Camera, Cap, CylinderInstance, Outline, Placement, Projection, Region, Scene, SphereInstance,
};
use glam::{Affine3A, Quat, Vec3};
use std::sync::Arc;

/// 50,653 balls, no two of which meet, and as many sticks from each to the next in a box; every tenth ball lets light through if asked.
fn crowd(see_through: bool) -> Block {
    let mut state = 1u64;
    let mut random = move || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (state >> 40) as f32 / (1u32 << 24) as f32
    };
    let (mut spheres, mut cylinders) = (Vec::new(), Vec::new());
    const SIDE: u32 = 37;
    let mut place = |i: u32| {
        let cell = Vec3::new((i % SIDE) as f32, (i / SIDE % SIDE) as f32, (i / SIDE / SIDE) as f32);
        (cell + Vec3::new(random(), random(), random()) * 0.4) * 2.7 - 50.0
    };
    let places: Vec<Vec3> = (0..=SIDE * SIDE * SIDE).map(&mut place).collect();
    for i in 0..SIDE * SIDE * SIDE {
        let center = places[i as usize];
        // The last of a row ends in the open: sticks do not meet but in balls.
        let end = if i % SIDE == SIDE - 1 { center + Vec3::X } else { places[i as usize + 1] };
        let color = |a: u8| Srgb8 { a, ..Srgb8::rgb((i % 251) as u8, (i / 251) as u8, 120) };
        let ball = color(if see_through && i % 10 == 0 { 100 } else { 255 });
        spheres.push(SphereInstance {
            center: center.to_array(),
            radius: 0.3 + (i % 7) as f32 * 0.07,
            color: ball,
            id: i + 1,
        });
        cylinders.push(CylinderInstance {
            a: center.to_array(),
            b: end.to_array(),
            radius: 0.08 + (i % 5) as f32 * 0.04,
            id: 60_001 + i,
            color_a: color(255),
            color_b: Srgb8::rgb(200, 90, 20),
            caps: CylinderInstance::pack_caps([Cap::Flat, Cap::Round, Cap::None][i as usize % 3], Cap::Flat),
            hidden: 0,
        });
    }
    Block { spheres, cylinders, id_count: 120_000, ..Block::default() }
}

fn scene_of(block: Block) -> Scene {
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    Scene::from_blocks(vec![block], vec![placement])
}

/// Whole, turned, near, from within, parallel, and a part of a larger picture.
fn views(scene: &Scene) -> Vec<View> {
    let whole = scene.fitted_camera(1.5);
    let within = Camera { eye: Vec3::new(3.0, 1.0, 2.0), ..whole };
    let narrow = Camera { projection: Projection::Perspective { fov_y_rad: 0.05 }, ..whole };
    let parallel = Camera { projection: Projection::Orthographic { height: 70.0 }, ..whole };
    let part = Region { x: 700, y: 500, width: 200, height: 160 };
    let mut views: Vec<View> =
        [whole, whole.turned(0.3), narrow, within, parallel].map(|camera| View::new(camera, 240, 160)).to_vec();
    views.push(View { region: Some(part), ..View::new(whole, 2400, 1600) });
    views
}

fn is_anything_seen(image: &Image) -> bool {
    image.rgba.chunks_exact(4).any(|pixel| pixel != &image.rgba[..4])
}

/// Draws all views without culling, and with it twice in a row, each time with what is known of the view before.
fn draws_the_same(gpu: &mut GpuRenderer, scene: Scene, settings: &Settings, what: &str) {
    let views = views(&scene);
    gpu.load(Arc::new(scene)).unwrap();
    let mut draw = |culling: Culling| -> Vec<Image> {
        gpu.set_culling(culling);
        views.iter().flat_map(|view| [view, view]).map(|view| gpu.image(view, settings).unwrap()).collect()
    };
    let whole = draw(Culling::None);
    for culling in [Culling::Frustum, Culling::Full, Culling::Full] {
        for (index, (want, got)) in whole.iter().zip(draw(culling)).enumerate() {
            assert!(is_anything_seen(want), "view {index} of {what} shows nothing");
            let differ = want.rgba.chunks_exact(4).zip(got.rgba.chunks_exact(4)).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "pixels of view {index} of {what} with {culling:?}");
        }
    }
}

const QUICK: Settings = Settings { samples: 3, ground_texels: 64, ao: 0, shadow: false };

#[test]
fn culling_changes_no_picture() {
    let Some(mut gpu) = gpu() else { return };
    draws_the_same(&mut gpu, scene_of(crowd(false)), &QUICK, "a crowd");
    draws_the_same(&mut gpu, scene_of(crowd(true)), &QUICK, "a crowd with see-through balls");
    let mut outlined = scene_of(crowd(false));
    outlined.lighting.outline = Outline { width: 0.004, ..Outline::default() };
    draws_the_same(&mut gpu, outlined, &QUICK, "a crowd with outlines");
}

#[test]
fn culling_changes_no_picture_of_turned_and_mirrored_copies() {
    let Some(mut gpu) = gpu() else { return };
    let turn = Affine3A::from_rotation_translation(Quat::from_rotation_x(0.7), Vec3::new(90.0, 20.0, -60.0));
    let mirror = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    for transforms in [vec![turn], vec![turn, mirror, Affine3A::from_translation(Vec3::Y * 120.0)]] {
        let place = |(i, world_from_block): (usize, &Affine3A)| Placement {
            block: 0,
            world_from_block: *world_from_block,
            first_id: 120_000 * i as u32,
        };
        let placements: Vec<_> = transforms.iter().enumerate().map(place).collect();
        let what = format!("{} copies", placements.len());
        draws_the_same(&mut gpu, Scene::from_blocks(vec![crowd(false)], placements), &QUICK, &what);
    }
}

#[test]
fn devices_that_do_not_compute_draw_the_same_picture() {
    let Some(mut gpu) = gpu() else { return };
    let mut small = GpuRenderer::with_limits(AdapterWish::Any, &wgpu::Limits::downlevel_webgl2_defaults()).unwrap();
    let scene = Arc::new(scene_of(crowd(false)));
    for view in views(&scene) {
        let draw = |renderer: &mut GpuRenderer| {
            renderer.load(Arc::clone(&scene)).unwrap();
            renderer.image(&view, &QUICK).unwrap()
        };
        assert!(draw(&mut gpu) == draw(&mut small));
    }
}

#[test]
fn frames_of_an_orbit_are_the_same_with_and_without_culling() {
    let Some(mut gpu) = gpu() else { return };
    let scene = Arc::new(scene_of(crowd(false)));
    gpu.load(Arc::clone(&scene)).unwrap();
    let whole = scene.fitted_camera(1.5);
    let narrow = Camera { projection: Projection::Perspective { fov_y_rad: 0.1 }, ..whole };
    let settings = Settings { samples: 1, ..QUICK };
    for camera in [whole, narrow] {
        let mut orbit = |culling| -> Vec<Image> {
            gpu.set_culling(culling);
            let frame = |step: u8| View::new(camera.turned(0.03 * f32::from(step)), 240, 160);
            (0..8).map(|step| gpu.image(&frame(step), &settings).unwrap()).collect()
        };
        let plain = orbit(Culling::None);
        assert!(plain[0] != plain[1], "the camera moves");
        assert!(orbit(Culling::Full) == plain);
    }
}

#[test]
fn of_what_is_small_just_what_is_seen_is_found() {
    let Some(mut gpu) = gpu() else { return };
    if !gpu.lists() {
        println!("SKIP: the device does not compute");
        return;
    }
    let scene = Arc::new(scene_of(crowd(false)));
    gpu.load(Arc::clone(&scene)).unwrap();
    for turn in [0.0, 0.4] {
        let view = View::new(scene.fitted_camera(1.5).turned(turn), 240, 160);
        let ids = gpu.gbuffer(&view).unwrap().id;
        let seen: std::collections::HashSet<u32> = ids.into_iter().filter(|&id| id <= 120_000 && id > 0).collect();
        assert!(seen.len() > 1000);
        assert_eq!(gpu.listed_instances().unwrap(), seen.len() as u64);
    }
}

#[test]
fn what_others_hide_is_not_drawn() {
    let Some(mut gpu) = gpu() else { return };
    if !gpu.lists() {
        println!("SKIP: the device does not compute");
        return;
    }
    // A wall before the crowd.
    let mut block = crowd(false);
    let wall = SphereInstance { center: [0.0, 0.0, 500.0], radius: 400.0, color: Srgb8::rgb(1, 2, 3), id: 120_001 };
    block.spheres.push(wall);
    block.id_count += 1;
    let scene = scene_of(block);
    let camera = Camera { eye: Vec3::Z * 2000.0, world_from_view: Quat::IDENTITY, ..scene.fitted_camera(1.5) };
    let view = View::new(camera, 240, 160);
    gpu.load(Arc::new(scene)).unwrap();
    for _ in 0..3 {
        gpu.image(&view, &QUICK).unwrap();
    }
    let drawn = gpu.listed_instances().unwrap();
    assert!((1..2_000).contains(&drawn), "{drawn} of 101,307 are drawn");
}

#[test]
fn copies_are_on_the_device_once() {
    let written = |copies: u16| {
        let mut gpu = GpuRenderer::noop(&wgpu::Limits::downlevel_webgl2_defaults()).unwrap();
        let place = |i: u16| Placement {
            block: 0,
            world_from_block: Affine3A::from_translation(Vec3::X * 120.0 * f32::from(i)),
            first_id: 120_000 * u32::from(i),
        };
        let scene = Scene::from_blocks(vec![crowd(false)], (0..copies).map(place).collect());
        let view = View::new(scene.fitted_camera(1.5), 24, 16);
        gpu.load(Arc::new(scene)).unwrap();
        gpu.image(&view, &QUICK).unwrap();
        gpu.work().bytes as f64
    };
    let (one, sixty) = (written(1), written(60));
    assert!(one > 50_653.0 * 72.0 && sixty < 1.1 * one, "{one} bytes, {sixty} of sixty copies");
}
