use super::*;
use crate::color::Srgb8;
use crate::render::sky;
use crate::render::sky::{START_OFFSET, reach};
use crate::render::test_shapes::{Random, Shape, at};
use crate::scene::{Block, CylinderInstance, Placement, Ray, SphereInstance};
use glam::DVec3;

/// A chain of balls and sticks, folded at random into a ball: as dense as atoms are in a protein.
fn chain(seed: u64, count: u32, caps: u32, hidden: u32) -> Scene {
    let mut random = Random(seed);
    let limit = 2.0 * f64::from(count).cbrt();
    let mut points: Vec<DVec3> = vec![DVec3::ZERO];
    while points.len() < count as usize {
        let next = points[points.len() - 1] + random.direction() * 1.5;
        if next.length() < limit {
            points.push(next);
        }
    }
    let (color, place) = (Srgb8::WHITE, |p: &DVec3| p.as_vec3().to_array());
    let spheres = (points.iter().zip(1..))
        .map(|(p, id)| SphereInstance { center: place(p), radius: random.between(0.25, 0.4) as f32, color, id })
        .collect();
    let cylinders = (points.windows(2).zip(count + 1..))
        .map(|(ends, id)| CylinderInstance {
            a: place(&ends[0]),
            radius: 0.13,
            b: place(&ends[1]),
            id,
            color_a: color,
            color_b: color,
            caps,
            hidden,
        })
        .collect();
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    Scene::from_blocks(vec![Block { spheres, cylinders, id_count: 2 * count, ..Block::default() }], vec![placement])
}

fn shapes(scene: &Scene) -> Vec<Shape> {
    let solids = Solids::new(scene, Affine3A::IDENTITY);
    solids.spheres.iter().map(Shape::sphere).chain(solids.cylinders.iter().map(Shape::cylinder)).collect()
}

/// The first hit of any shape, f64, one after the other.
fn first_hit(shapes: &[Shape], ray: &Ray) -> Option<(DVec3, DVec3)> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3().normalize());
    let near = |shape: &&Shape| {
        let to = shape.center - origin;
        (to - direction * to.dot(direction)).length() <= shape.half + shape.radius
    };
    let hits = shapes.iter().filter(near).filter_map(|shape| shape.first_hit(ray, 0.0));
    hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(t, _, normal)| (at(ray, t), normal))
}

/// Points of the scene that are seen from somewhere outside, and their normals.
fn visible_points(scene: &Scene, shapes: &[Shape], count: usize) -> Vec<(DVec3, DVec3)> {
    let mut random = Random(11);
    let radius = f64::from(scene.bounds().size().length());
    let mut points = Vec::new();
    while points.len() < count {
        let from = random.direction() * radius;
        let to = random.direction() * random.between(0.0, 0.45 * radius);
        let ray = Ray { origin: from.as_vec3(), direction: (to - from).normalize().as_vec3() };
        points.extend(first_hit(shapes, &ray));
    }
    points
}

/// All directions, asked by the only sample of a pixel.
fn at_once(directions: Vec<Vec3>) -> Turns {
    Turns { each: directions.len() as u32, directions }
}

const UNASKED: Reach = Reach { open: -1.0, key: -2.0 };

/// What points with normals are told of these directions of the sky and of the key light; asked in clusters from so many
/// primitives on.
fn ask(scene: &Scene, sky: &Turns, key: &Turns, points: &[(Vec3, Vec3)], many: usize) -> Vec<Reach> {
    let center = scene.bounds().center();
    let mut lights =
        Lights { sky: Light::new(sky.clone()), key: Light::new(key.clone()), samples: 1, ..Lights::default() };
    // A view with the world's axes, so that its space is the world's but for the eye.
    let camera = crate::scene::Camera {
        eye: Vec3::new(1.0, -2.0, 30.0),
        world_from_view: glam::Quat::IDENTITY,
        projection: crate::scene::Projection::Orthographic { height: 10.0 },
        near: 0.1,
        far: 100.0,
        target: center,
        shift: [0.0; 2],
    };
    let in_view = Solids::new(scene, camera.view_from_world());
    let shadows = Shadows::with(scene, &View::new(camera, 10, 10), &in_view, &mut lights, many);
    let questions = shadows.look(&mut lights, &(0..1));
    let told = points.chunks(LANES).flat_map(|chunk| {
        let mut block = Points { own: [NOBODY; LANES], ..Points::default() };
        for (lane, (p, n)) in chunk.iter().enumerate() {
            let start = *p - camera.eye + *n * START_OFFSET;
            for axis in 0..3 {
                block.position[axis][lane] = start[axis];
                block.normal[axis][lane] = n[axis];
            }
            block.asks[lane] = 1.0;
        }
        questions.ask(&mut block, 0, UNASKED);
        (0..chunk.len()).map(move |lane| Reach { open: block.told[0][lane], key: block.told[1][lane] })
    });
    told.collect()
}

/// What visible points are told, and what rays find, one after the other through the whole scene.
fn compare(scene: &Scene, sky: &Turns, key: &Turns, count: usize, many: usize) -> Vec<(Reach, Reach)> {
    let shapes = shapes(scene);
    let points = visible_points(scene, &shapes, count);
    let asked: Vec<_> = points.iter().map(|(p, n)| (p.as_vec3(), n.as_vec3())).collect();
    let told = ask(scene, sky, key, &asked, many);
    let by_rays = |&(p, n): &(DVec3, DVec3)| {
        let free = |d: Vec3| {
            let origin = (p + n * f64::from(START_OFFSET)).as_vec3();
            first_hit(&shapes, &Ray { origin, direction: d }).is_none()
        };
        reach(n.as_vec3(), &sky.directions, &key.directions, UNASKED, free)
    };
    points.par_iter().map(by_rays).zip(told).collect()
}

fn rms(pairs: &[(Reach, Reach)], of: fn(&Reach) -> f32) -> f64 {
    let squares = pairs.iter().map(|(want, got)| f64::from(of(want) - of(got)).powi(2));
    (squares.sum::<f64>() / pairs.len() as f64).sqrt()
}

#[test]
fn what_points_are_told_is_what_rays_find() {
    // Sticks whose flat ends lie in balls, said so or not, and round ones; one by one and in clusters.
    let scenes = [(30, 5, 3), (300, 5, 0), (300, 10, 0), (3000, 5, 3)];
    for ((count, caps, hidden), many) in scenes.into_iter().flat_map(|scene| [(scene, usize::MAX), (scene, 0)]) {
        let scene = chain(u64::from(count), count, caps, hidden);
        let key = Turns::of_key(Vec3::new(-0.5, 0.7, 0.5).normalize(), 1);
        let pairs = compare(&scene, &at_once(sky::directions(64)), &key, 1000, many);
        let (open, lit) = (rms(&pairs, |r| r.open), rms(&pairs, |r| r.key));
        println!("{count} atoms: rms {open:.5} of the sky, {lit:.5} of the key light");
        let mean = pairs.iter().map(|(want, _)| want.open).sum::<f32>() / pairs.len() as f32;
        assert!(mean > 0.2 && mean < 0.95, "{mean}: there is something to see, and something in the way");
        assert!(pairs.iter().any(|p| p.0.key > 0.9) && pairs.iter().any(|p| p.0.key < 0.1));
        // f32 against f64, at edges: a direction of 64 now and then.
        assert!(open < 0.005 && lit < 0.01, "{count}: {open} {lit}");
    }
}

#[test]
fn a_ball_alone_hides_nothing_from_itself_however_grazing() {
    let spheres = vec![SphereInstance { center: [300.0, -200.0, 100.0], radius: 1.3, color: Srgb8::WHITE, id: 1 }];
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    let scene = Scene::from_blocks(vec![Block { spheres, id_count: 1, ..Block::default() }], vec![placement]);
    let center = Vec3::new(300.0, -200.0, 100.0);
    let points: Vec<(Vec3, Vec3)> = sky::directions(2000).into_iter().map(|n| (center + n * 1.3, n)).collect();
    for told in ask(&scene, &at_once(sky::directions(64)), &Turns::default(), &points, usize::MAX) {
        assert_eq!(told, Reach { open: 1.0, key: UNASKED.key });
    }
}

#[test]
fn nothing_is_asked_of_an_empty_scene() {
    let scene = Scene::from_blocks(Vec::new(), Vec::new());
    let told = ask(&scene, &at_once(sky::directions(4)), &Turns::default(), &[(Vec3::ZERO, Vec3::Y)], 0);
    assert_eq!(told, [UNASKED]);
}
