//! The distance field against asking every primitive in f64, against the hits of rays, and the ground's light in cases
//! whose answer is known.

use super::*;
use crate::color::Srgb8;
use crate::render::cpu::intersect::{cylinder_t, sphere_t};
use crate::render::frame::ground_fade;
use crate::render::settings::{Settings, View};
use crate::render::test_shapes::{FLAT, ROUND, Random, camera, camera_around};
use crate::scene::{Block, CylinderInstance, Placement, Projection, Ray, SphereInstance};
use glam::{DVec2, DVec3, Quat};

fn sphere(center: Vec3, radius: f32, id: u32) -> SphereInstance {
    SphereInstance { center: center.to_array(), radius, color: Srgb8::WHITE, id }
}

fn scene(spheres: Vec<SphereInstance>, cylinders: Vec<CylinderInstance>) -> Scene {
    let id_count = (spheres.len() + cylinders.len()) as u32;
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    Scene::from_blocks(vec![Block { spheres, cylinders, id_count, ..Block::default() }], vec![placement])
}

/// Balls and sticks in a cube of 20 Å, overlapping here and there, with flat and round caps.
fn random_scene(seed: u64, count: u32) -> Scene {
    let mut random = Random(seed);
    let point = |random: &mut Random| Vec3::from_array(std::array::from_fn(|_| random.between(-10.0, 10.0) as f32));
    let spheres = (0..count).map(|i| sphere(point(&mut random), random.between(0.2, 1.0) as f32, 1 + i)).collect();
    let sticks = (0..count).map(|i| {
        let a = point(&mut random);
        let b = a + (random.direction() * random.between(0.1, 3.0)).as_vec3();
        let caps = [random.below(2), random.below(2)].map(|cap| [FLAT, ROUND][cap as usize]);
        CylinderInstance {
            a: a.to_array(),
            radius: random.between(0.05, 0.4) as f32,
            b: b.to_array(),
            id: 1 + count + i,
            color_a: Srgb8::WHITE,
            color_b: Srgb8::WHITE,
            caps: caps[0] | caps[1] << 2,
            hidden: 0,
        }
    });
    scene(spheres, sticks.collect())
}

/// Distance to primitive `index`, from its instance. Another way than the field's: outside a flat cylinder the nearest
/// point of its half section, a rectangle, is found by clamping.
fn distance(scene: &Scene, index: usize, p: DVec3) -> f64 {
    let block = &scene.blocks[0];
    let Some(i) = index.checked_sub(block.spheres.len()) else {
        let sphere = &block.spheres[index];
        return p.distance(Vec3::from(sphere.center).as_dvec3()) - f64::from(sphere.radius);
    };
    let stick = &block.cylinders[i];
    let (a, b) = (Vec3::from(stick.a).as_dvec3(), Vec3::from(stick.b).as_dvec3());
    let (radius, length) = (f64::from(stick.radius), a.distance(b));
    let axis = (b - a) / length;
    let y = (p - a).dot(axis);
    let across = (p - a - axis * y).length();
    let end = usize::from(y > length * 0.5);
    if (stick.caps >> (2 * end)) & 3 == ROUND {
        return (p - (a + axis * y.clamp(0.0, length))).length() - radius;
    }
    let nearest = DVec2::new(across.min(radius), y.clamp(0.0, length));
    let outside = DVec2::new(across, y).distance(nearest);
    if outside > 0.0 { outside } else { -(radius - across).min(y.min(length - y)) }
}

/// The two smallest distances, the least with its primitive.
fn brute_force(scene: &Scene, p: DVec3) -> (f64, u32, f64) {
    let count = scene.sphere_count() + scene.cylinder_count();
    let (mut best, mut second) = ((f64::INFINITY, 0), f64::INFINITY);
    for index in 0..count {
        let d = distance(scene, index, p);
        if d < best.0 {
            second = best.0;
            best = (d, index as u32);
        } else {
            second = second.min(d);
        }
    }
    (best.0, best.1, second)
}

#[test]
fn the_field_is_the_least_distance_of_all_primitives() {
    let scene = random_scene(1, 60);
    let field = Field::new(&scene);
    let mut random = Random(2);
    let mut inside = 0;
    for _ in 0..5000 {
        let p = DVec3::from_array(std::array::from_fn(|_| random.between(-10.0, 10.0))).as_vec3();
        let (want, index, second) = brute_force(&scene, p.as_dvec3());
        let (got, found) = field.map(p, f32::INFINITY);
        assert!((f64::from(got) - want).abs() < 1e-5, "{p}: {got} {want}");
        assert!(found == Some(index) || second - want < 1e-5, "{p}: {found:?} {index}");
        inside += u32::from(want < 0.0);
    }
    assert!(inside > 15, "{inside}");
}

#[test]
fn only_what_is_nearer_than_the_limit_is_found() {
    let scene = random_scene(3, 40);
    let field = Field::new(&scene);
    let mut random = Random(4);
    let mut limited = 0;
    for _ in 0..3000 {
        let p = DVec3::from_array(std::array::from_fn(|_| random.between(-14.0, 14.0))).as_vec3();
        let limit = random.between(0.01, 2.0) as f32;
        let all = field.map(p, f32::INFINITY);
        let (got, found) = field.map(p, limit);
        if all.0 < limit {
            assert_eq!((got, found), all, "{p} {limit}");
        } else {
            assert_eq!((got, found), (limit, None), "{p}");
            limited += 1;
        }
    }
    assert!(limited > 500, "{limited}");
    assert_eq!(Field::new(&scene_of_nothing()).map(Vec3::ZERO, 3.0), (3.0, None));
}

fn scene_of_nothing() -> Scene {
    scene(Vec::new(), Vec::new())
}

#[test]
fn the_field_never_grows_faster_than_the_way() {
    let scene = random_scene(5, 60);
    let field = Field::new(&scene);
    let mut random = Random(6);
    for _ in 0..5000 {
        let p = DVec3::from_array(std::array::from_fn(|_| random.between(-12.0, 12.0))).as_vec3();
        let step = (random.direction() * random.log_between(1e-3, 3.0)).as_vec3();
        // Outside: inside a stick shorter than wide the distances to a flat and a round end do not join up.
        let (from, to) = (field.map(p, f32::INFINITY).0.max(0.0), field.map(p + step, f32::INFINITY).0.max(0.0));
        assert!((to - from).abs() <= step.length() + 1e-5, "{p} {step}: {from} {to}");
    }
}

#[test]
fn at_every_hit_the_field_is_zero_and_names_the_primitive() {
    let scene = random_scene(7, 60);
    let field = Field::new(&scene);
    let solids = field.solids();
    let mut random = Random(8);
    let (mut checked, mut on_sticks) = (0, 0);
    for _ in 0..20_000 {
        // Parallel rays down the z axis, in the space of the solids themselves.
        let (x, y) = (random.between(-10.0, 10.0), random.between(-10.0, 10.0));
        let ray = Ray { origin: Vec3::new(x as f32, y as f32, 20.0), direction: Vec3::NEG_Z };
        let spheres = solids.spheres.iter().map(|sphere| sphere_t(&ray, sphere, 0.1));
        let hits = spheres.chain(solids.cylinders.iter().map(|cylinder| cylinder_t(&ray, cylinder, 0.1)));
        let hit = hits.enumerate().filter(|(_, t)| t.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((index, t)) = hit else { continue };
        let p = ray.origin + ray.direction * t;
        let (d, found) = field.map(p, f32::INFINITY);
        assert!(d.abs() < 1e-3, "{p}: {d}");
        let (_, _, second) = brute_force(&scene, p.as_dvec3());
        if second < 2e-3 {
            continue; // a seam of two primitives
        }
        assert_eq!(found, Some(index as u32), "{p}");
        assert_eq!(found.map(|i| solids.id(i as usize)), Some(index as u32 + 1));
        checked += 1;
        on_sticks += u32::from(index >= solids.spheres.len());
    }
    assert!(checked > 5000 && on_sticks > 500, "{checked} {on_sticks}");
}

/// A camera straight down −z; the key light above the ground is then that of the default lighting.
fn frame(scene: &Scene) -> FrameConstants {
    let camera = camera(Quat::IDENTITY, Projection::Orthographic { height: 20.0 });
    FrameConstants::new(scene, &View::new(camera, 100, 100), &Settings::default())
}

/// One sphere over the ground, its radius, and the frame.
fn ball_on_ground(radius: f32, height: f32) -> (Field, FrameConstants) {
    let mut scene = scene(vec![sphere(Vec3::ZERO, radius, 1)], Vec::new());
    scene.set_ground(true);
    if let Some(ground) = &mut scene.ground {
        ground.height = -height;
    }
    (Field::new(&scene), frame(&scene))
}

#[test]
fn the_quick_map_of_pictures_in_motion_is_nearly_the_exact_one_and_its_sky_stays_while_the_light_turns() {
    let mut scene = random_scene(9, 400);
    scene.set_ground(true);
    let (field, settings) = (Field::new(&scene), Settings { ground_texels: 48, ..Settings::default() });
    let seen = |turn: f32| {
        let view = View::new(camera_around(turn), 64, 64);
        (FrameConstants::new(&scene, &view, &settings), view)
    };
    let (first, view) = seen(0.0);
    let above = first.lit_from_above(&scene, &view, &settings);
    let sky = (above, field.sky_map(&above));
    let (mut shaded, mut worst) = (0, [0.0f32; 2]);
    for turn in [0.0, 0.7, 2.5] {
        let (frame, view) = seen(turn);
        assert!(above.same_ground_map(&frame.lit_from_above(&scene, &view, &settings)), "it need not be found again");
        assert!(turn == 0.0 || !first.same_ground_map(&frame), "the light turns with the camera");
        let (quick, exact) = (field.quick_ground_map(&frame, &sky), field.ground_map(&frame));
        assert_eq!(quick.size, exact.size);
        for (quick, exact) in quick.texels.iter().zip(&exact.texels) {
            shaded += u32::from(exact[0] < 0.5);
            assert!(quick[0] >= exact[0], "never darker: {quick:?}, {exact:?}");
            worst = [worst[0].max(quick[0] - exact[0]), worst[1].max((quick[1] - exact[1]).abs())];
        }
    }
    assert!(shaded > 100 && worst[0] <= 1.5 * QUICK_SHADOW + 1e-5 && worst[1] < 0.05, "{shaded} {worst:?}");
}

fn to_light(frame: &FrameConstants) -> Vec3 {
    Vec3::new(frame.key_in_world[0], frame.key_in_world[1], frame.key_in_world[2])
}

#[test]
fn the_shadow_is_dark_in_the_umbra_bright_outside_and_monotone_between() {
    let (radius, height) = (2.0, 5.0);
    let (field, frame) = ball_on_ground(radius, height);
    let light = to_light(&frame);
    // Where the light's ray through the centre meets the ground; from there straight across the light's plane.
    let middle = light * (-height / light.y);
    let across = light.cross(Vec3::Y).normalize();
    let visible: Vec<f32> =
        (0..400).map(|i| field.ground_shadow(&frame, middle + across * (i as f32 * 0.02))).collect();
    let distance = middle.length();
    let sharpness = frame.ground_map_size[2];
    for (i, &v) in visible.iter().enumerate() {
        let beside = i as f32 * 0.02 - radius;
        if beside < 0.0 {
            assert_eq!(v, 0.0, "umbra, {beside}");
        } else if beside > distance / sharpness * 1.01 {
            assert_eq!(v, 1.0, "in full light, {beside}");
        } else if (0.05 * distance..0.95 * distance).contains(&(beside * sharpness)) {
            assert!(0.0 < v && v < 1.0, "penumbra, {beside}: {v}");
        }
    }
    assert!(visible.windows(2).all(|pair| pair[0] <= pair[1]));
    assert!(visible.windows(2).all(|pair| pair[1] - pair[0] < 0.1), "the edge is soft");
    assert_eq!(field.ground_shadow(&frame, -middle.with_y(height) - across), 1.0, "nothing stands on the light's side");
}

#[test]
fn the_shadow_is_that_of_the_darkest_point_of_the_way() {
    let mut scene = random_scene(9, 40);
    scene.set_ground(true);
    let field = Field::new(&scene);
    let frame = frame(&scene);
    let light = to_light(&frame);
    let (sharpness, start) = (frame.ground_map_size[2], 1e-3 * scene.bounds().size().length());
    let mut random = Random(10);
    let (mut dark, mut half, mut worst) = (0, 0, 0.0f32);
    for _ in 0..400 {
        let (x, z) = (random.between(-15.0, 15.0) as f32, random.between(-15.0, 15.0) as f32);
        let p = Vec3::new(x, frame.ground[0], z);
        let ways = (0..6000).map(|i| start + i as f32 * 0.01);
        let least =
            ways.map(|t| sharpness * field.map(p + light * t, f32::INFINITY).0 / t).fold(1.0, f32::min).max(0.0);
        let want = least * least * (3.0 - 2.0 * least);
        let got = field.ground_shadow(&frame, p);
        worst = worst.max((got - want).abs());
        dark += u32::from(want == 0.0);
        half += u32::from((0.05..0.95).contains(&want));
    }
    println!("ground shadow against a march of 0.01 Å: at most {worst} off; {dark} dark, {half} in penumbra");
    assert!(worst < 0.06 && dark > 15 && half > 40, "{worst} {dark} {half}");
}

#[test]
fn the_ground_is_open_far_away_and_closed_where_a_ball_touches_it() {
    let (field, frame) = ball_on_ground(5.0, 5.0);
    let at = |x: f32| field.ground_open(&frame, Vec3::new(x, -5.0, 0.0));
    assert!(at(0.0) < 0.1, "{}", at(0.0));
    assert_eq!(at(1000.0), 1.0);
    let open: Vec<f32> = (0..200).map(|i| at(i as f32 * 0.1)).collect();
    assert!(open.windows(2).all(|pair| pair[0] <= pair[1] + 1e-5), "less and less closed on the way out");
}

#[test]
fn the_ground_map_holds_the_light_of_its_texels() {
    let (field, frame) = ball_on_ground(2.0, 3.0);
    let map = field.ground_map(&frame);
    let grid = frame.ground_grid();
    assert_eq!(map.texels.len(), (map.size[0] * map.size[1]) as usize);
    let mut random = Random(12);
    for _ in 0..500 {
        let (x, z) = (random.below(grid.size[0] - 1), random.below(grid.size[1] - 1));
        let at = |corner: f32, i: u32| corner + (i as f32 + 0.5) / grid.texels_per_angstrom;
        let p = Vec3::new(at(grid.corner[0], x), frame.ground[0], at(grid.corner[1], z));
        let want = [field.ground_shadow(&frame, p), field.ground_open(&frame, p)];
        let got = map.at(&frame, p);
        assert!((got[0] - want[0]).abs() < 2e-2 && (got[1] - want[1]).abs() < 2e-2, "{p}: {got:?} {want:?}");
    }
    // The border texels are in full light, or where the ground has faded, so that the map has no edge.
    let [width, height] = map.size;
    for x in 0..width {
        for z in [0, height - 1] {
            let at = |axis: usize, i: u32| grid.corner[axis] + (i as f32 + 0.5) / grid.texels_per_angstrom;
            let light = map.texels[(z * width + x) as usize][0];
            assert!(light == 1.0 || ground_fade(&frame, at(0, x), at(1, z)) == 0.0, "{x} {z}: {light}");
        }
    }
    assert_eq!(map.at(&frame, Vec3::new(1e4, -3.0, 0.0)), [1.0, 1.0]);
    assert_eq!(GroundMap::none().at(&frame, Vec3::ZERO), [1.0, 1.0]);
}
