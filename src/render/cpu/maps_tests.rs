use super::*;
use crate::color::Srgb8;
use crate::render::sky;
use crate::render::test_shapes::{Random, Shape, at};
use crate::scene::{Block, CylinderInstance, Placement, Ray, SphereInstance};
use glam::DVec3;

/// A chain of balls and sticks, folded at random into a ball: as dense as atoms are in a protein.
fn chain(seed: u64, count: u32, caps: u32) -> Scene {
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
            reserved: 0,
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

/// Parts of the directions that points see, by rays and by maps.
fn compare<const WEIGHTED: bool>(scene: &Scene, directions: &[Vec3], count: usize) -> Vec<(f64, f64)> {
    let shapes = shapes(scene);
    let maps = Maps::new(scene, directions);
    let center = scene.bounds().center();
    let points = visible_points(scene, &shapes, count);
    let ask = |&(p, n): &(DVec3, DVec3)| {
        let mut eight = Points::default();
        eight.set(3, p.as_vec3() - center, n.as_vec3());
        maps.ask::<WEIGHTED>(&mut eight);
        let free = |d: Vec3| {
            let origin = (p + n * f64::from(sky::START_OFFSET)).as_vec3();
            first_hit(&shapes, &Ray { origin, direction: d }).is_none()
        };
        let unasked = sky::Reach { open: -1.0, key: -1.0 };
        let want = match WEIGHTED {
            true => sky::reach(n.as_vec3(), directions, &[], unasked, free).open,
            false => sky::reach(n.as_vec3(), &[], directions, unasked, free).key,
        };
        (f64::from(want), f64::from(eight.part(3)))
    };
    points.par_iter().map(ask).collect()
}

fn rms(pairs: &[(f64, f64)]) -> f64 {
    (pairs.iter().map(|(want, got)| (want - got).powi(2)).sum::<f64>() / pairs.len() as f64).sqrt()
}

#[test]
fn sky_visibility_is_that_of_rays() {
    for (count, caps) in [(30, 5), (300, 5), (300, 10), (3000, 5)] {
        let scene = chain(u64::from(count), count, caps);
        let pairs = compare::<true>(&scene, &sky::directions(64), 600);
        let mean = |part: fn(&(f64, f64)) -> f64| pairs.iter().map(part).sum::<f64>() / pairs.len() as f64;
        let (want, got) = (mean(|p| p.0), mean(|p| p.1));
        println!("{count} atoms: rms {:.4}, means {want:.4} and {got:.4}", rms(&pairs));
        assert!(want > 0.2 && want < 0.95, "{want}: there is something to see, and something in the way");
        assert!(rms(&pairs) < 0.03, "{count}: {}", rms(&pairs));
        assert!((want - got).abs() < 0.006, "{count}: the maps are {got} in the mean, rays {want}");
    }
}

#[test]
fn the_keys_visibility_is_that_of_rays() {
    let scene = chain(4, 300, 5);
    let pairs = compare::<false>(&scene, &sky::key_directions(Vec3::new(-0.5, 0.7, 0.5).normalize()), 600);
    assert!(pairs.iter().any(|p| p.0 > 0.9) && pairs.iter().any(|p| p.0 < 0.1));
    assert!(rms(&pairs) < 0.06, "{}", rms(&pairs));
}

#[test]
fn a_ball_alone_hides_nothing_from_itself_however_grazing() {
    let spheres = vec![SphereInstance { center: [300.0, -200.0, 100.0], radius: 1.3, color: Srgb8::WHITE, id: 1 }];
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    let scene = Scene::from_blocks(vec![Block { spheres, id_count: 1, ..Block::default() }], vec![placement]);
    let maps = Maps::new(&scene, &sky::directions(64));
    for n in sky::directions(2000) {
        let mut eight = Points::default();
        eight.set(0, n * 1.3, n);
        maps.ask::<true>(&mut eight);
        assert!(eight.part(0) > 0.999, "{n}: {}", eight.part(0));
    }
}

#[test]
fn an_empty_scene_has_no_maps() {
    let scene = Scene::from_blocks(Vec::new(), Vec::new());
    assert!(Maps::new(&scene, &sky::directions(4)).is_empty());
    assert!(Maps::new(&chain(1, 3, 5), &[]).is_empty());
}

/// Cones, rings and a coarse ball of triangles with the ball's normals, heaped up.
fn heap(opacity: u8) -> Scene {
    use crate::scene::{ConeInstance, TorusInstance, TriangleInstance};
    let mut random = Random(77);
    let color = Srgb8 { a: opacity, ..Srgb8::WHITE };
    let mut block = Block { id_count: 100, ..Block::default() };
    for i in 0..25 {
        let place = |random: &mut Random| random.direction() * random.between(0.0, 3.5);
        let a = place(&mut random);
        let b = a + random.direction() * 1.5;
        let [a, b] = [a, b].map(|p| p.as_vec3().to_array());
        block.cones.push(ConeInstance { a, radius_a: 0.5, b, radius_b: 0.0, color, id: 1 + i, reserved: [0; 2] });
        block.tori.push(TorusInstance {
            center: place(&mut random).as_vec3().to_array(),
            ring_radius: 0.8,
            axis: random.direction().as_vec3().to_array(),
            tube_radius: 0.2,
            color,
            id: 26 + i,
            reserved: [0; 2],
        });
    }
    let at = |row: i32, column: i32| {
        let (up, around) = (row as f32 * std::f32::consts::PI / 12.0, column as f32 * std::f32::consts::PI / 12.0);
        Vec3::new(up.sin() * around.cos(), up.cos(), up.sin() * around.sin())
    };
    for (row, column) in (0..12).flat_map(|row| (0..24).map(move |column| (row, column))) {
        let [a, b, c, d] = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
        for normals in [[a, b, c], [a, c, d]] {
            let corners = normals.map(|n| (n * 2.0).to_array());
            let (normals, colors) = (normals.map(|n| n.to_array()), [color; 3]);
            block.triangles.push(TriangleInstance { corners, normals, colors, id: 60, reserved: [0; 2] });
        }
    }
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    Scene::from_blocks(vec![block], vec![placement])
}

#[test]
fn cones_tori_and_meshes_hide_the_sky_as_rays_say() {
    use super::super::intersect::{primitive_normal, primitive_t};
    let (scene, directions) = (heap(255), sky::directions(64));
    let maps = Maps::new(&scene, &directions);
    let solids = Solids::new(&scene, Affine3A::IDENTITY);
    let first = |ray: &Ray| {
        let hits = (0..solids.len()).map(|index| (primitive_t(ray, &solids, index, 0.0), index));
        hits.filter(|hit| hit.0.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let mut random = Random(12);
    let mut pairs: [Vec<(f64, f64)>; 3] = Default::default();
    while pairs.iter().map(Vec::len).sum::<usize>() < 600 {
        let from = (random.direction() * 20.0).as_vec3();
        let to = (random.direction() * random.between(0.0, 4.0)).as_vec3();
        let ray = Ray { origin: from, direction: (to - from).normalize() };
        let Some((t, index)) = first(&ray) else { continue };
        let normal = primitive_normal(&ray, &solids, index, 0.0, t);
        let p = ray.origin + ray.direction * t;
        let mut eight = Points::default();
        eight.set(3, p - scene.bounds().center(), normal);
        maps.ask::<true>(&mut eight);
        let origin = p + normal * sky::START_OFFSET;
        let free = |direction: Vec3| first(&Ray { origin, direction }).is_none();
        let unasked = sky::Reach { open: -1.0, key: -1.0 };
        let want = sky::reach(normal, &directions, &[], unasked, free).open;
        pairs[(index / 25).min(2)].push((f64::from(want), f64::from(eight.part(3))));
    }
    for (pairs, what) in pairs.iter().zip(["cones", "tori", "mesh"]) {
        let mean = |part: fn(&(f64, f64)) -> f64| pairs.iter().map(part).sum::<f64>() / pairs.len() as f64;
        println!(
            "{what}: {} points, rms {:.4}, means {:.4} and {:.4}",
            pairs.len(),
            rms(pairs),
            mean(|p| p.0),
            mean(|p| p.1)
        );
        assert!(pairs.len() > 40 && rms(pairs) < 0.04, "{what}: {}", rms(pairs));
    }
}

#[test]
fn what_is_hardly_there_hides_no_sky() {
    for (opacity, hides) in [(100, false), (200, true)] {
        let maps = Maps::new(&heap(opacity), &sky::directions(16));
        assert_eq!(maps.texels.iter().any(|&height| height > 0), hides);
    }
}
