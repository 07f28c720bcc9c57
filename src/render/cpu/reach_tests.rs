use super::*;
use crate::color::Srgb8;
use crate::render::sky;
use crate::render::sky::{START_OFFSET, reach};
use crate::render::solids::Solids;
use crate::render::test_shapes::{Random, Shape, at};
use crate::scene::{Block, CylinderInstance, Placement, Ray, SphereInstance};
use glam::{Affine3A, DVec3};

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

/// Points in packets.
struct Given(Vec<Points>);

impl Packets for Given {
    fn runs(&self) -> usize {
        2
    }

    fn len_of(&self, run: usize) -> usize {
        let half = self.0.len() / 2;
        if run == 0 { half } else { self.0.len() - half }
    }

    fn bounds(&self) -> Aabb {
        let [low, high] = [f32::min as fn(f32, f32) -> f32, f32::max].map(|of| {
            let axis = |axis: usize| self.0.iter().flat_map(|p| p.position[axis]).reduce(of).unwrap_or_default();
            Vec3::new(axis(0), axis(1), axis(2))
        });
        Aabb { min: low, max: high }
    }

    fn points(&self, run: usize, packet: usize) -> Points {
        self.0[run * (self.0.len() / 2) + packet]
    }
}

/// What points with normals are told of these directions of the sky and of the key light.
fn ask(scene: &Scene, sky: &Turns, key: &Turns, points: &[(Vec3, Vec3)]) -> Vec<Reach> {
    let center = scene.bounds().center();
    let lights = Lights { sky: sky.clone(), key: key.clone(), samples: 1, ..Lights::default() };
    let camera = crate::scene::Camera {
        eye: Vec3::new(1.0, -2.0, 30.0),
        world_from_view: glam::Quat::from_rotation_y(0.4),
        projection: crate::scene::Projection::Orthographic { height: 10.0 },
        near: 0.1,
        far: 100.0,
        target: center,
        shift: [0.0; 2],
    };
    let view_from_world = camera.view_from_world();
    let hiders = Hiders::new(&Solids::new(scene, Affine3A::IDENTITY));
    let shadows = Shadows::new(scene, &View::new(camera, 10, 10), &hiders);
    let packet = |chunk: &[(Vec3, Vec3)]| {
        // The last stands in all further lanes, and does not ask there.
        let mut packet = Points::default();
        for lane in 0..LANES {
            let (p, n) = chunk[lane.min(chunk.len() - 1)];
            let start = view_from_world.transform_point3(p + n * START_OFFSET);
            let n = view_from_world.transform_vector3(n);
            for axis in 0..3 {
                packet.position[axis][lane] = start[axis];
                packet.normal[axis][lane] = n[axis];
            }
            packet.asks[lane] = if lane < chunk.len() { 1.0 } else { 0.0 };
        }
        packet
    };
    let given = Given(points.chunks(LANES).map(packet).collect());
    let mut packets = given.0.clone();
    let answers = shadows.answers(&lights, &[(0, given)], &AtomicBool::new(false));
    for (number, packet) in packets.iter_mut().enumerate() {
        answers[0].tell(number, packet, UNASKED);
    }
    let told = |i: usize| packets[i / LANES].told.map(|told| told[i % LANES]);
    (0..points.len()).map(told).map(|[open, key]| Reach { open, key }).collect()
}

/// What visible points are told, and what rays find, one after the other through the whole scene.
fn compare(scene: &Scene, sky: &Turns, key: &Turns, count: usize) -> Vec<(Reach, Reach)> {
    let shapes = shapes(scene);
    let points = visible_points(scene, &shapes, count);
    let asked: Vec<_> = points.iter().map(|(p, n)| (p.as_vec3(), n.as_vec3())).collect();
    let told = ask(scene, sky, key, &asked);
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
    // Sticks whose flat ends lie in balls, said so or not, and round ones.
    let scenes = [(30, 5, 3), (300, 5, 0), (300, 10, 0), (3000, 5, 3)];
    for (count, caps, hidden) in scenes {
        let scene = chain(u64::from(count), count, caps, hidden);
        let key = Turns::of_key(Vec3::new(-0.5, 0.7, 0.5).normalize(), 1);
        let pairs = compare(&scene, &at_once(sky::directions(64)), &key, 1000);
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
    for told in ask(&scene, &at_once(sky::directions(64)), &Turns::default(), &points) {
        assert_eq!(told, Reach { open: 1.0, key: UNASKED.key });
    }
}

#[test]
fn nothing_is_asked_of_an_empty_scene() {
    let scene = Scene::from_blocks(Vec::new(), Vec::new());
    let told = ask(&scene, &at_once(sky::directions(4)), &Turns::default(), &[(Vec3::ZERO, Vec3::Y)]);
    assert_eq!(told, [UNASKED]);
}

/// Points in two small heaps very far apart, and a row of them: the cells must not become more than the points are worth, nor too wide to be
/// right.
#[test]
fn points_far_apart_are_told_the_same() {
    let heap = chain(9, 200, 5, 3);
    let shapes = shapes(&heap);
    let points: Vec<(Vec3, Vec3)> =
        visible_points(&heap, &shapes, 300).into_iter().map(|(p, n)| (p.as_vec3(), n.as_vec3())).collect();
    let sky = at_once(sky::directions(64));
    let alone = ask(&heap, &sky, &Turns::default(), &points);
    let far = Vec3::new(20_000.0, 3.0, -5.0);
    let with_far: Vec<_> = points.iter().copied().chain((0..40).map(|i| (far * (i as f32 / 40.0), Vec3::Y))).collect();
    let told = ask(&heap, &sky, &Turns::default(), &with_far);
    // Seen from far away places are rounded more coarsely.
    let apart = alone.iter().zip(&told).filter(|(a, b)| (a.open - b.open).abs() > 0.05).count();
    assert!(apart < 5, "{apart} of {}", points.len());
    assert!(told[points.len() + 20..].iter().all(|told| told.open > 0.99), "{:?}", &told[points.len() + 20..]);
}
