use super::*;
use crate::color::Srgb8;
use crate::render::cpu::reach::Lights;
use crate::render::cpu::tiles::{self, Known};
use crate::render::field::{Field, GroundMap};
use crate::render::frame::FrameConstants;
use crate::render::settings::Settings;
use crate::render::test_shapes::Random;
use crate::render::{Image, Quality};
use crate::scene::{
    Background, Camera, ConeInstance, CylinderInstance, Placement, Projection, Region, SphereInstance, TorusInstance,
};
use glam::Quat;
use std::sync::atomic::AtomicBool;

fn some_color(random: &mut Random) -> Srgb8 {
    let mut part = || random.below(256) as u8;
    Srgb8::rgb(part(), part(), part())
}

/// Balls and sticks of many sizes with every kind of end, some cones and rings.
fn block(seed: u64, count: u32, size: f64) -> Block {
    let mut random = Random(seed);
    let mut place = |reach: f64| (random.direction() * random.between(0.0, reach)).as_vec3();
    let places: Vec<[Vec3; 2]> = (0..count).map(|_| [place(size), place(1.5)]).collect();
    let (mut spheres, mut cylinders, mut cones, mut tori) = (vec![], vec![], vec![], vec![]);
    for (id, &[at, aside]) in (1..).zip(&places) {
        let (center, radius) = (at.to_array(), random.log_between(0.05, 1.5) as f32);
        let [color, color_b] = [some_color(&mut random), some_color(&mut random)];
        let b = (at + aside).to_array();
        match id % 16 {
            0 => {
                cones.push(ConeInstance { a: center, radius_a: radius, b, radius_b: 0.1, color, id, reserved: [0; 2] })
            }
            1 => tori.push(TorusInstance {
                center,
                ring_radius: 2.0 * radius,
                axis: aside.normalize_or(Vec3::Y).to_array(),
                tube_radius: 0.2,
                color,
                id,
                reserved: [0; 2],
            }),
            2..8 => spheres.push(SphereInstance { center, radius, color, id }),
            _ => {
                let caps = random.below(3) | random.below(3) << 2;
                // One in a hundred has no length.
                let b = if id % 101 == 0 { center } else { b };
                let radius = radius * 0.3;
                cylinders.push(CylinderInstance { a: center, radius, b, id, color_a: color, color_b, caps, hidden: 0 });
            }
        }
    }
    Block { spheres, cylinders, cones, tori, id_count: count + 1, ..Block::default() }
}

/// Two blocks, one of them drawn twice and turned, and one without anything between.
fn scene() -> Scene {
    let turned = |angle: f32, at: Vec3| Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), at);
    let place = |block, world_from_block, first_id| Placement { block, world_from_block, first_id };
    let placements = vec![
        place(0, turned(0.0, Vec3::ZERO), 0),
        place(1, turned(1.0, Vec3::new(9.0, 1.0, 0.0)), 5000),
        place(2, turned(0.3, Vec3::ZERO), 9000),
        place(0, turned(2.0, Vec3::new(-12.0, 0.0, -7.0)), 10_000),
    ];
    Scene::from_blocks(vec![block(1, 3000, 9.0), Block::default(), block(2, 700, 6.0)], placements)
}

fn camera(eye: Vec3, target: Vec3, projection: Projection) -> Camera {
    let back = (eye - target).normalize();
    let right = Vec3::Y.cross(back).normalize();
    let world_from_view = Quat::from_mat3(&glam::Mat3::from_cols(right, back.cross(right), back));
    Camera { eye, world_from_view, projection, near: 0.5, far: 2000.0, target, shift: [0.0; 2] }
}

/// The picture of packs, and that of all primitives in view space.
fn both(scene: &Scene, view: &View, samples: u32) -> [Image; 2] {
    let settings = Settings { samples, ao: 0, shadow: false, ..Quality::Draft.settings() };
    let frame = FrameConstants::new(scene, view, &settings);
    let ground = if frame.has_ground() { Field::new(scene).ground_map(&frame) } else { GroundMap::none() };
    let (packs, go_on) = (Packs::new(scene), AtomicBool::new(false));
    [Some(&packs), None].map(|packs| {
        let known = Known { packs, ..Known::default() };
        tiles::image(scene, view, &settings, (&ground, &Lights::none(), known), &go_on)
    })
}

#[test]
fn packs_draw_the_picture_of_all_primitives() {
    let mut scene = scene();
    let perspective = Projection::Perspective { fov_y_rad: 0.6 };
    let views = [
        // From outside, from within, from afar (things smaller than a pixel), off to the side, and with parallel rays.
        (Vec3::new(5.0, 9.0, 45.0), Vec3::ZERO, perspective),
        (Vec3::new(1.0, 0.5, 2.0), Vec3::new(-6.0, 0.0, -9.0), perspective),
        (Vec3::new(300.0, 100.0, 900.0), Vec3::ZERO, perspective),
        (Vec3::new(5.0, 4.0, 20.0), Vec3::new(14.0, 0.0, 0.0), Projection::Perspective { fov_y_rad: 2.0 }),
        (Vec3::new(3.0, 9.0, 50.0), Vec3::ZERO, Projection::Orthographic { height: 30.0 }),
        (Vec3::new(3.0, 0.0, 1.0), Vec3::ZERO, Projection::Orthographic { height: 300.0 }),
    ];
    for (number, (eye, target, projection)) in views.into_iter().enumerate() {
        let mut view = View::new(camera(eye, target, projection), 203, 141);
        for (samples, ground, background, region) in [
            (1, false, Background::Color(Srgb8::WHITE), None),
            (1, true, Background::Color(Srgb8::rgb(20, 30, 40)), None),
            (1, true, Background::Transparent, Some(Region { x: 33, y: 50, width: 130, height: 77 })),
            (4, false, Background::Color(Srgb8::WHITE), None),
            (5, true, Background::Transparent, Some(Region { x: 100, y: 9, width: 61, height: 90 })),
        ] {
            scene.set_ground(ground);
            (scene.background, view.region) = (background, region);
            let [packed, listed] = both(&scene, &view, samples);
            let differ = packed.rgba.iter().zip(&listed.rgba).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "view {number}, {samples} samples, ground {ground}");
            let plain = packed.rgba.chunks_exact(4).filter(|pixel| *pixel == &packed.rgba[..4]).count();
            assert!(plain < packed.rgba.len() / 4, "view {number} shows nothing");
        }
    }
}

#[test]
fn every_ball_stick_and_ring_is_in_one_pack_and_in_its_box() {
    let block = block(3, 5000, 40.0);
    let of_block = BlockPacks::new(&block);
    let BlockPacks { packs, members, balls, sticks, ball_colors, stick_colors } = &of_block;
    let (mut spheres, mut cylinders) = (vec![0; block.spheres.len()], vec![0; block.cylinders.len()]);
    let mut tori = vec![0; block.tori.len()];
    for pack in packs {
        let start = pack.start as usize;
        let middle = start + usize::from(pack.spheres);
        let around = Aabb { min: pack.center - pack.half, max: pack.center + pack.half }.grown(1e-4);
        let holds = |inner: Aabb| {
            assert!(around.union(inner) == around, "{inner:?} is not in {around:?}");
        };
        let end = middle + usize::from(pack.cylinders);
        for (&i, at) in members[start..middle].iter().zip(pack.first_ball as usize..) {
            spheres[i as usize] += 1;
            let ball = &block.spheres[i as usize];
            holds(ball.bounds());
            assert_eq!([balls[0][at], balls[1][at], balls[2][at]], ball.center);
            assert_eq!((balls[3][at], ball_colors[at]), (ball.radius, ball.color));
        }
        for (&i, at) in members[middle..end].iter().zip(pack.first_stick as usize..) {
            cylinders[i as usize] += 1;
            let stick = &block.cylinders[i as usize];
            holds(stick.bounds());
            assert_eq!([sticks[0][at], sticks[1][at], sticks[2][at]], stick.a);
            assert_eq!([sticks[3][at], sticks[4][at], sticks[5][at]], stick.b);
            assert_eq!((sticks[6][at], stick_colors[at]), (stick.radius, [stick.color_a, stick.color_b]));
        }
        for &i in &members[end..end + usize::from(pack.tori)] {
            tori[i as usize] += 1;
            holds(block.tori[i as usize].bounds());
        }
    }
    assert!(spheres.iter().chain(&cylinders).chain(&tori).all(|&count| count == 1));
    // Neighbours: the boxes together take little more than all of it does.
    let volume = |half: Vec3| f64::from(half.x * half.y * half.z);
    let whole = packs
        .iter()
        .fold(Aabb::EMPTY, |all, pack| all.union(Aabb { min: pack.center - pack.half, max: pack.center + pack.half }));
    let boxes: f64 = packs.iter().map(|pack| volume(pack.half)).sum();
    assert!(boxes < 4.0 * volume(whole.size() * 0.5), "{boxes}");
}
