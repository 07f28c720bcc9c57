//! The middle of the way through a solid against the f64 shapes: their first hit from the front and from behind.

use super::*;
use crate::render::test_shapes::{FLAT, ROUND, Random, Shape, at, cylinder, ray_to};
use crate::render::test_solids::{Body, Drawn, random_drawn};

/// Entry and exit by the first hits of the ray and of its reverse from beyond the solid.
fn way_through(ray: &Ray, reach: f64, first: impl Fn(&Ray) -> Option<f64>) -> Option<(f64, f64)> {
    let end = at(ray, reach).as_vec3();
    let back = Ray { origin: end, direction: -ray.direction };
    Some((first(ray)?, reach - first(&back)?))
}

/// The function that is tested, for one solid.
type MiddleOf = Box<dyn Fn(&Ray) -> f32>;

/// How far f32 may be off: what a shift of the solid by its rounding moves the ends of a chord of this length.
fn allowed(size: f64, radius: f64, chord: f64) -> f64 {
    let resolved = 16.0 * f64::from(f32::EPSILON) * size;
    resolved * (1.0 + 4.0 * radius / chord.max(1e-9))
}

#[test]
fn balls_and_sticks_are_passed_midway() {
    for orthographic in [false, true] {
        for distance in [1.0, 10.0, 100.0, 1000.0] {
            let mut random = Random(distance as u64 + 7);
            let (mut hits, mut rays) = (0, 0);
            for case in 0..4000 {
                let stick = case % 2 == 0;
                let (shape, t): (Shape, MiddleOf) = if stick {
                    let caps = [FLAT, ROUND][case / 2 % 2];
                    let (length, radius) = (random.between(0.5, 3.0), random.log_between(0.03, 0.5));
                    let (center, axis) = (random.in_view(distance, 0.5), random.direction());
                    let solid = cylinder(center, axis, length, radius, [caps, caps]).unwrap();
                    (Shape::cylinder(&solid), Box::new(move |ray| cylinder_middle_t(ray, &solid, 0.01)))
                } else {
                    let center = random.in_view(distance, 0.5).as_vec3();
                    let solid = Sphere { center, radius: random.log_between(0.03, 3.0) as f32 };
                    (Shape::sphere(&solid), Box::new(move |ray| sphere_middle_t(ray, &solid, 0.01)))
                };
                let ray = shape.ray(&mut random, orthographic);
                let size = shape.center.length() + shape.half + shape.radius;
                let found = way_through(&ray, 3.0 * size, |ray| Some(shape.first_hit(ray, 0.0)?.0));
                let got = f64::from(t(&ray));
                rays += 1;
                let Some((entry, exit)) =
                    found.filter(|(entry, exit)| *entry > 0.01 && exit - entry > 0.02 * shape.radius)
                else {
                    continue; // a miss, the silhouette, or the near plane
                };
                hits += 1;
                let slack = allowed(size, shape.radius, exit - entry);
                assert!((got - 0.5 * (entry + exit)).abs() < slack, "{shape:?} {ray:?}: {got} of {entry}..{exit}");
            }
            assert!(3 * hits > rays / 2, "{hits} of {rays}");
        }
    }
}

#[test]
fn cones_are_passed_midway_and_rings_inside_their_tube() {
    let mut random = Random(11);
    let (mut cones, mut rings) = (0, 0);
    for case in 0..20_000 {
        let center = random.in_view(20.0, 0.5);
        let drawn = random_drawn(&mut random, case % 2, center);
        let body = drawn.body();
        let ray = ray_to(body.point(&mut random) + random.direction() * 0.05 * body.width(), false);
        let (size, width) = (body.center().length() + body.reach(), body.width());
        let found = way_through(&ray, 3.0 * size, |ray| Some(body.first_hit(ray, 0.0)?.0));
        let Some((entry, exit)) = found.filter(|(entry, exit)| *entry > 0.01 && exit - entry > 0.05 * width) else {
            continue;
        };
        match &drawn {
            Drawn::Cone(cone) => {
                cones += 1;
                let got = f64::from(cone_middle_t(&ray, cone, 0.01));
                assert!((got - 0.5 * (entry + exit)).abs() < 1e-3 * size, "{body:?} {ray:?}: {got} of {entry}..{exit}");
            }
            Drawn::Torus(torus) => {
                // The tube bends away from a chord along it, so that only short ones end inside.
                let Body::Torus { center, axis, ring, tube } = body else { continue };
                if exit - entry > 0.7 * tube || tube > 0.3 * ring {
                    continue;
                }
                rings += 1;
                let p = at(&ray, f64::from(torus_middle_t(&ray, torus, 0.01))) - center;
                let (up, out) = (p.dot(axis), p.cross(axis).length() - ring);
                assert!(up.hypot(out) < 1.02 * tube, "{body:?} {ray:?}");
            }
            Drawn::Triangle(_) => {}
        }
    }
    assert!(cones > 1000 && rings > 100, "{cones} {rings}");
}

#[test]
fn a_miss_is_a_miss_and_the_near_plane_cuts_the_way() {
    let ball = Sphere { center: glam::Vec3::new(0.0, 0.0, -5.0), radius: 1.0 };
    let ray = |x: f32| Ray { origin: glam::Vec3::new(x, 0.0, 0.0), direction: glam::Vec3::NEG_Z };
    assert_eq!(sphere_middle_t(&ray(1.1), &ball, 0.1), f32::INFINITY);
    assert_eq!(sphere_middle_t(&ray(0.0), &ball, 0.1), 5.0);
    assert_eq!(sphere_middle_t(&ray(0.0), &ball, 5.0), 5.5);
    assert_eq!(sphere_middle_t(&ray(0.0), &ball, 6.1), f32::INFINITY);
}
