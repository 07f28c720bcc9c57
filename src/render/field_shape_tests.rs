//! The distance field of cones, tori and triangles: against points of their surfaces, against the hits of rays, and the shadow
//! against a march.

use super::*;
use crate::color::Srgb8;
use crate::render::cpu::intersect::primitive_t;
use crate::render::settings::{Settings, View};
use crate::render::test_shapes::{Random, camera};
use crate::render::test_solids::{Body, Drawn, random_drawn};
use crate::scene::{Block, ConeInstance, Placement, Projection, Ray, TorusInstance, TriangleInstance};
use glam::{DVec3, Quat};

/// `count` of each in a cube of 20 Å.
fn random_scene(seed: u64, count: u32, opacity: u8) -> Scene {
    let mut random = Random(seed);
    let point = |random: &mut Random| Vec3::from_array(std::array::from_fn(|_| random.between(-10.0, 10.0) as f32));
    let color = Srgb8 { a: opacity, ..Srgb8::WHITE };
    let mut block = Block { id_count: 3 * count, ..Block::default() };
    for i in 0..count {
        let a = point(&mut random);
        let b = a + (random.direction() * random.between(0.3, 3.0)).as_vec3();
        let radius = random.between(0.1, 1.0) as f32;
        let other = [0.0, random.between(0.1, 1.0) as f32][random.below(2) as usize];
        let (a, b) = (a.to_array(), b.to_array());
        block.cones.push(ConeInstance { a, radius_a: radius, b, radius_b: other, color, id: 1 + i, reserved: [0; 2] });
        let ring = random.between(0.5, 1.5) as f32;
        block.tori.push(TorusInstance {
            center: point(&mut random).to_array(),
            ring_radius: ring,
            axis: random.direction().as_vec3().to_array(),
            tube_radius: ring * random.between(0.1, 0.5) as f32,
            color,
            id: 1 + count + i,
            reserved: [0; 2],
        });
        let middle = point(&mut random);
        let corners = [0; 3].map(|_| (middle + (random.direction() * 1.5).as_vec3()).to_array());
        let (normals, colors, id) = ([[0.0; 3]; 3], [color; 3], 1 + 2 * count + i);
        block.triangles.push(TriangleInstance { corners, normals, colors, id, reserved: [0; 2] });
    }
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    Scene::from_blocks(vec![block], vec![placement])
}

/// Points of the whole surface, evenly enough: the inside of caps and faces too.
fn surface(body: &Body, random: &mut Random) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = (0..6000).map(|_| body.point(random)).collect();
    if let Body::Cone { center, axis, half, .. } = body {
        let some: Vec<DVec3> = points[..3000].to_vec();
        for p in some {
            let y = (p - *center).dot(*axis);
            if y.abs() > half - 1e-9 {
                let on_axis = *center + *axis * y;
                points.push(on_axis + (p - on_axis) * random.between(0.0, 1.0).sqrt());
            }
        }
    }
    points
}

#[test]
fn distances_are_those_to_the_nearest_point_of_the_surface() {
    let mut random = Random(31);
    for i in 0..150 {
        let drawn = random_drawn(&mut random, i % 3, DVec3::new(1.0, 2.0, -3.0));
        let body = drawn.body();
        let points = surface(&body, &mut random);
        for _ in 0..20 {
            let p = body.center() + random.direction() * body.reach() * random.between(0.0, 2.0);
            let want = points.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
            let at = p.as_vec3();
            let got = f64::from(match &drawn {
                Drawn::Cone(cone) => cone_distance(at, cone),
                Drawn::Torus(torus) => torus_distance(at, torus),
                Drawn::Triangle(triangle) => triangle_distance(at, triangle),
            });
            // Between the points one is at most so far from the nearest.
            let spacing = 0.12 * body.reach();
            assert!(got.abs() <= want + 1e-4 && got.abs() >= want - spacing, "{drawn:?} {p}: {got} {want}");
            assert!((got < 0.0) == body.contains(p) || got.abs() < 1e-4, "{drawn:?} {p}: {got}");
        }
    }
}

#[test]
fn at_every_hit_the_field_is_zero_and_names_the_primitive() {
    let scene = random_scene(7, 40, 255);
    let field = Field::new(&scene);
    let solids = field.solids();
    let mut random = Random(8);
    let mut checked = [0; 3];
    for _ in 0..20_000 {
        let (x, y) = (random.between(-10.0, 10.0), random.between(-10.0, 10.0));
        let ray = Ray { origin: Vec3::new(x as f32, y as f32, 20.0), direction: Vec3::NEG_Z };
        let hits = (0..solids.len()).map(|index| primitive_t(&ray, solids, index, 0.1));
        let hit = hits.enumerate().filter(|(_, t)| t.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((index, t)) = hit else { continue };
        let p = ray.origin + ray.direction * t;
        let (d, found) = field.map(p, f32::INFINITY);
        assert!(d.abs() < 1e-3, "{p}: {d}");
        let others = (0..solids.len()).filter(|&i| i != index).map(|i| field.distance(i, p));
        if others.fold(f32::INFINITY, f32::min) < 2e-3 {
            continue; // a seam of two primitives
        }
        assert_eq!(found, Some(index as u32), "{p}");
        assert_eq!(found.map(|i| solids.id(i as usize)), Some(index as u32 + 1));
        checked[index / 40] += 1;
    }
    assert!(checked.iter().all(|&n| n > 500), "{checked:?}");
}

/// The constants of a scene seen from the front.
fn looked_at(scene: &Scene) -> FrameConstants {
    let camera = camera(Quat::IDENTITY, Projection::Orthographic { height: 20.0 });
    FrameConstants::new(scene, &View::new(camera, 100, 100), &Settings::default())
}

#[test]
fn the_shadow_is_that_of_the_darkest_point_of_the_way() {
    let mut scene = random_scene(9, 12, 255);
    scene.set_ground(true);
    let field = Field::new(&scene);
    let frame = looked_at(&scene);
    let light = frame.key_in_world();
    let (sharpness, start) = (frame.ground_map_size[2], 1e-3 * scene.bounds().size().length());
    let mut random = Random(10);
    let (mut dark, mut half, mut worst) = (0, 0, 0.0f32);
    for _ in 0..600 {
        let p = Vec3::new(random.between(-15.0, 15.0) as f32, frame.ground[0], random.between(-15.0, 15.0) as f32);
        let ways = (0..6000).map(|i| start + i as f32 * 0.01);
        let least =
            ways.map(|t| sharpness * field.map(p + light * t, f32::INFINITY).0 / t).fold(1.0, f32::min).max(0.0);
        let want = least * least * (3.0 - 2.0 * least);
        worst = worst.max((field.ground_shadow(&frame, p) - want).abs());
        dark += u32::from(want == 0.0);
        half += u32::from((0.05..0.95).contains(&want));
    }
    println!("ground shadow against a march of 0.01 Å: at most {worst} off; {dark} dark, {half} in penumbra");
    assert!(worst < 0.06 && dark > 15 && half > 25, "{worst} {dark} {half}");
}

#[test]
fn what_is_see_through_takes_its_share_of_the_light_on_the_ground() {
    let of = |opacity| {
        let mut scene = random_scene(9, 12, opacity);
        scene.set_ground(true);
        let frame = looked_at(&scene);
        (Field::new(&scene), frame)
    };
    let ((opaque, frame), mut random, mut shaded) = (of(255), Random(10), [0; 2]);
    for opacity in [0, 64, 128, 230] {
        let (field, same) = of(opacity);
        assert_eq!(frame, same);
        let share = f32::from(opacity) / 255.0;
        for _ in 0..200 {
            let p = Vec3::new(random.between(-15.0, 15.0) as f32, frame.ground[0], random.between(-15.0, 15.0) as f32);
            let (full, part) = (opaque.ground_shadow(&frame, p), field.ground_shadow(&frame, p));
            assert!((part - (1.0 - share * (1.0 - full))).abs() < 1e-3, "shadow {full} {part} at {opacity}");
            shaded[0] += u32::from(full < 0.9);
            let (full, part) = (opaque.ground_open(&frame, p), field.ground_open(&frame, p));
            assert!((part - (1.0 - share * (1.0 - full))).abs() < 1e-3, "open {full} {part} at {opacity}");
            shaded[1] += u32::from(full < 0.9);
        }
    }
    assert!(shaded.iter().all(|&n| n > 80), "{shaded:?}");
}
