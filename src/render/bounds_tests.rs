//! Bounds against points of f64 solids, and against the area that rays find covered.

use super::*;
use crate::render::cpu::intersect::{cylinder_t, sphere_t};
use crate::render::solids::{Cylinder, Sphere};
use crate::render::test_shapes::{FLAT, ROUND, Random, Shape, cylinder};
use crate::scene::Ray;
use glam::{DVec2, DVec3};

/// Rays for the covered area: a grid of this many on a side.
const GRID: u32 = 24;

#[derive(Clone, Copy)]
enum Solid {
    Ball(Sphere),
    Stick(Cylinder),
}

impl Solid {
    fn shape(&self) -> Shape {
        match self {
            Solid::Ball(sphere) => Shape::sphere(sphere),
            Solid::Stick(cylinder) => Shape::cylinder(cylinder),
        }
    }

    fn rect(&self, camera: &BoundsCamera) -> Option<PlaneRect> {
        match self {
            Solid::Ball(sphere) => sphere_rect(sphere.center, sphere.radius, camera),
            Solid::Stick(stick) => {
                let [a, b] = stick.ends();
                cylinder_rect(a, b, stick.radius, stick.round(), camera)
            }
        }
    }

    fn t(&self, ray: &Ray, near: f32) -> f32 {
        match self {
            Solid::Ball(sphere) => sphere_t(ray, sphere, near),
            Solid::Stick(stick) => cylinder_t(ray, stick, near),
        }
    }
}

/// By how much a plane point lies outside the rectangle.
fn outside(rect: &PlaneRect, point: DVec2) -> f64 {
    let along = rect.along.as_dvec2();
    let from_center = point - rect.center.as_dvec2();
    let beyond = DVec2::new(along.dot(from_center).abs(), along.perp().dot(from_center).abs()) - rect.half.as_dvec2();
    beyond.max_element()
}

/// What may be outside: a millionth of the coordinates, as slopes themselves are f32; and what the rounding of the
/// axis ends to f32 tilts a cap by.
fn tolerance(rect: &PlaneRect, point: DVec2, shape: &Shape, depth: f64, orthographic: bool) -> f64 {
    let tilt = shape.axis.map_or(0.0, |_| f64::from(f32::EPSILON) * shape.center.length() / shape.half);
    let per_angstrom = if orthographic { 1.0 } else { 1.0 / depth };
    1e-6 * point.abs().max_element().max(rect.half.as_dvec2().max_element()) + tilt * shape.radius * per_angstrom
}

fn assert_holds(solid: &Solid, camera: &BoundsCamera, random: &mut Random) -> u32 {
    let shape = solid.shape();
    let rect = solid.rect(camera);
    let mut seen = 0;
    for i in 0..60 {
        let p = shape.point(random, i % 4 != 0);
        if -p.z < f64::from(camera.near) * (1.0 + 1e-6) + 1e-6 * shape.radius {
            continue;
        }
        seen += 1;
        let point = if camera.orthographic { p.truncate() } else { p.truncate() / -p.z };
        let Some(rect) = rect else { panic!("no bounds of {shape:?} with {camera:?}, but {p} is seen") };
        let (excess, allowed) = (outside(&rect, point), tolerance(&rect, point, &shape, -p.z, camera.orthographic));
        assert!(excess <= allowed, "{shape:?} {camera:?}: {point} outside {rect:?} by {excess}, not {allowed}");
    }
    seen
}

fn random_solid(random: &mut Random, center: DVec3) -> Solid {
    let radius = random.log_between(0.03, 3.0);
    if random.below(3) == 0 {
        return Solid::Ball(Sphere { center: center.as_vec3(), radius: radius as f32 });
    }
    let caps = [random.below(3), random.below(3)];
    let length = random.log_between(0.05, 10.0);
    let axis = match random.below(6) {
        0 => center.normalize_or(DVec3::Z),
        1 => [DVec3::X, DVec3::NEG_Y, DVec3::Z][random.below(3) as usize],
        _ => random.direction(),
    };
    Solid::Stick(cylinder(center, axis, length, radius, caps).unwrap())
}

#[test]
fn no_covered_point_is_outside() {
    let mut random = Random(1);
    let mut seen = 0;
    for i in 0..10_000 {
        let distance = random.log_between(2.0, 10_000.0);
        let center = random.in_view(distance, 60f64.to_radians());
        let solid = random_solid(&mut random, center);
        let camera = BoundsCamera { orthographic: i % 3 == 0, near: 0.1 };
        seen += assert_holds(&solid, &camera, &mut random);
    }
    assert!(seen > 500_000, "{seen}");
}

#[test]
fn what_crosses_the_near_plane_is_not_lost() {
    let mut random = Random(2);
    let (mut seen, mut gone) = (0, 0);
    for i in 0..10_000 {
        let near = random.log_between(0.05, 2.0);
        let depth = near + random.between(-4.0, 4.0);
        let center = DVec3::new(random.between(-4.0, 4.0), random.between(-4.0, 4.0), -depth);
        let solid = random_solid(&mut random, center);
        let camera = BoundsCamera { orthographic: i % 3 == 0, near: near as f32 };
        seen += assert_holds(&solid, &camera, &mut random);
        gone += u32::from(solid.rect(&camera).is_none());
    }
    assert!(seen > 100_000 && gone > 500, "{seen} {gone}");
}

/// Area of the rectangle over the part of it that rays find covered.
fn excess(solid: &Solid, camera: &BoundsCamera) -> f64 {
    let rect = solid.rect(camera).unwrap();
    let mut covered = 0;
    for i in 0..GRID * GRID {
        let at = |n: u32| (n as f32 + 0.5) / GRID as f32 * 2.0 - 1.0;
        let (x, y) = (at(i % GRID) * rect.half.x, at(i / GRID) * rect.half.y);
        let p = rect.center + rect.along * x + rect.along.perp() * y;
        let ray = if camera.orthographic {
            Ray { origin: p.extend(0.0), direction: Vec3::NEG_Z }
        } else {
            Ray { origin: Vec3::ZERO, direction: p.extend(-1.0) }
        };
        covered += u32::from(solid.t(&ray, camera.near).is_finite());
    }
    f64::from(GRID * GRID) / f64::from(covered.max(1))
}

fn mean_excess(what: &str, mut solid: impl FnMut(&mut Random) -> Solid) {
    let mut random = Random(3);
    let (mut sum, mut count, mut worst) = (0.0, 0, 0.0f64);
    for i in 0..10_000 {
        let solid = solid(&mut random);
        let (shape, camera) = (solid.shape(), BoundsCamera { orthographic: i % 3 == 0, near: 0.1 });
        if -shape.center.z - shape.half - shape.radius > f64::from(camera.near) {
            let excess = excess(&solid, &camera);
            (sum, count, worst) = (sum + excess, count + 1, worst.max(excess));
        }
    }
    let mean = sum / f64::from(count);
    println!("{what}: {mean:.3} times the covered area, at most {worst:.1}, {count} solids");
    assert!(count > 5000 && (1.0..1.6).contains(&mean), "{what}: {mean}");
}

#[test]
fn bounds_are_tight() {
    let center = |random: &mut Random| {
        let distance = random.log_between(4.0, 1000.0);
        random.in_view(distance, 60f64.to_radians())
    };
    mean_excess("spheres", |random| {
        let radius = random.log_between(0.1, 3.0) as f32;
        Solid::Ball(Sphere { center: center(random).as_vec3(), radius })
    });
    mean_excess("sticks of bonds", |random| {
        let length = random.between(0.5, 2.0);
        Solid::Stick(cylinder(center(random), random.direction(), length, 0.13, [FLAT, FLAT]).unwrap())
    });
    for caps in [[ROUND, ROUND], [ROUND, FLAT]] {
        mean_excess(&format!("any cylinder, caps {caps:?}"), |random| {
            let (length, radius) = (random.log_between(0.1, 4.0), random.log_between(0.03, 1.0));
            Solid::Stick(cylinder(center(random), random.direction(), length, radius, caps).unwrap())
        });
    }
}

#[test]
fn degenerate_cylinders_have_bounds_or_none_but_no_nan() {
    let camera = BoundsCamera { orthographic: false, near: 0.1 };
    let a = Vec3::new(0.0, 0.0, -5.0);
    assert_eq!(cylinder_rect(a, a, 0.1, [false; 2], &camera), None);
    assert_eq!(cylinder_rect(a, a * f32::NAN, 0.1, [false; 2], &camera), None);
    for b in [a + Vec3::Z * 1e-6, a + Vec3::X * 1e-6, a - Vec3::Z, a * 1.5] {
        for round in [[false; 2], [true; 2], [true, false]] {
            let rect = cylinder_rect(a, b, 0.1, round, &camera).unwrap();
            assert!(rect.center.is_finite() && rect.half.is_finite() && rect.half.min_element() >= 0.0, "{rect:?}");
            assert!((rect.along.length() - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn the_upright_box_holds_the_turned_rectangle() {
    let rect = PlaneRect { center: Vec2::new(1.0, 2.0), half: Vec2::new(2.0, 1.0), along: Vec2::new(0.6, 0.8) };
    let (low, high) = rect.upright();
    for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let corner = rect.center + rect.along * rect.half.x * x + rect.along.perp() * rect.half.y * y;
        assert!(corner.cmpge(low - 1e-6).all() && corner.cmple(high + 1e-6).all());
    }
}
