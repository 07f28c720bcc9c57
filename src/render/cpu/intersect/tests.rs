//! Intersections against an independent f64 reference, from 1 Å to 10,000 Å.
//!
//! A hit or a miss is wrong if the solid and all solids 1 % of the radius larger or smaller (in radius, length or both)
//! agree on the contrary. A depth has to lie among those of the solids that differ by what f32 resolves at that distance.

use super::*;
use crate::render::solids::{Cylinder, Sphere};
use crate::render::test_shapes::{FLAT, OPEN, Part, ROUND, Random, Shape, cylinder, ray_to};
use glam::DVec3;
use proptest::prelude::*;

const CAPS: [u32; 3] = [OPEN, FLAT, ROUND];

/// What was compared and what went wrong.
#[derive(Default)]
struct Tally {
    rays: u32,
    hits: u32,
    wrong_hits: u32,
    wrong_misses: u32,
    wrong_depths: u32,
    wrong_normals: u32,
    example: String,
}

impl Tally {
    fn note(&mut self, message: impl FnOnce() -> String) {
        if self.example.is_empty() {
            self.example = message();
        }
    }

    fn compare(&mut self, ray: &Ray, shape: &Shape, near: f32, t: f32, normal: impl FnOnce(f32) -> Vec3) {
        self.rays += 1;
        let case = || format!("{shape:?}\n{ray:?} near {near}, t {t}");
        assert!(!t.is_nan() && t >= near, "{}", case());
        let hits = |margin: f64| shape.variants(margin).map(|s| s.first_hit(ray, f64::from(near))).collect::<Vec<_>>();
        let wide = hits(0.01 * shape.radius);
        if t == f32::INFINITY {
            if wide.iter().all(Option::is_some) {
                self.wrong_misses += 1;
                self.note(|| format!("missed: {} want {:?}", case(), wide[0]));
            }
            return;
        }
        self.hits += 1;
        if wide.iter().all(Option::is_none) {
            self.wrong_hits += 1;
            return self.note(|| format!("hit nothing: {}", case()));
        }
        let size = shape.center.length() + shape.half + shape.radius;
        let close: Vec<_> = hits(4.0 * f64::from(f32::EPSILON) * size).into_iter().flatten().collect();
        if close.len() < 9 {
            return; // a ray along the silhouette or an edge
        }
        // A shift of the surface moves the hit by more the more the ray grazes it.
        let resolved = 4.0 * f64::from(f32::EPSILON) * size;
        let facing = close[0].2.normalize().dot(ray.direction.as_dvec3().normalize()).abs();
        let slack = resolved * (1.0 + 1.0 / facing.max(1e-3));
        let least = close.iter().fold(f64::INFINITY, |least, hit| least.min(hit.0)) - slack;
        let most = close.iter().fold(f64::NEG_INFINITY, |most, hit| most.max(hit.0)) + slack;
        if !(least..=most).contains(&f64::from(t)) {
            self.wrong_depths += 1;
            return self.note(|| format!("depth: {} want {least}..{most} {:?}", case(), close[0]));
        }
        let normal = normal(t).as_dvec3();
        let part = close[0].1;
        if close.iter().any(|hit| hit.1 != part) {
            return; // on an edge
        }
        let want = |normal: DVec3| if normal.dot(ray.direction.as_dvec3()) > 0.0 { -normal } else { normal };
        let spread = close.iter().map(|hit| (want(hit.2) - want(close[0].2)).length()).fold(0.0, f64::max);
        let off = (normal - want(close[0].2)).length();
        let tilt = shape.axis.filter(|_| part == Part::Side).map_or(0.0, |axis| axis.dot(normal).abs());
        let away = normal.dot(ray.direction.as_dvec3());
        let unit = (normal.length() - 1.0).abs();
        if !(unit < 1e-5 && tilt < 1e-5 && away < 1e-3 && off < 1e-4 + 2.0 * spread + resolved / shape.radius) {
            self.wrong_normals += 1;
            self.note(|| format!("normal: {} {normal} want {:?} ± {spread} tilt {tilt}", case(), close[0]));
        }
    }

    fn sphere(&mut self, ray: &Ray, sphere: &Sphere, near: f32) {
        let t = sphere_t(ray, sphere, near);
        self.compare(ray, &Shape::sphere(sphere), near, t, |t| sphere_normal(ray, sphere, near, t));
    }

    fn cylinder(&mut self, ray: &Ray, cylinder: &Cylinder, near: f32) {
        let t = cylinder_t(ray, cylinder, near);
        self.compare(ray, &Shape::cylinder(cylinder), near, t, |t| cylinder_normal(ray, cylinder, near, t));
    }

    fn assert_clean(&self, what: &str) {
        println!("{what}: {} rays, {} hits", self.rays, self.hits);
        assert!(self.hits * 5 > self.rays && self.hits * 20 < self.rays * 19, "{what}: {} of {}", self.hits, self.rays);
        let wrong = [self.wrong_hits, self.wrong_misses, self.wrong_depths, self.wrong_normals];
        assert_eq!(wrong, [0; 4], "{what}: hits, misses, depths, normals of {} rays; {}", self.rays, self.example);
    }
}

/// Distances from the eye, and how far off the view axis: at 10,000 Å a thin stick 1 % of its radius is 3e-4 Å, finer
/// than an f32 coordinate there unless the stick is near the axis.
const DISTANCES: [(f64, f64); 6] =
    [(1.0, 1.0), (10.0, 1.0), (100.0, 1.0), (1000.0, 1.0), (3000.0, 0.6), (10_000.0, 0.35)];

fn random_length(random: &mut Random) -> f64 {
    if random.below(4) == 0 { random.log_between(0.01, 100.0) } else { random.between(0.5, 3.0) }
}

#[test]
fn spheres_are_hit_where_they_are_at_any_distance() {
    for orthographic in [false, true] {
        for (distance, angle) in DISTANCES {
            let mut random = Random(distance as u64);
            let mut tally = Tally::default();
            for _ in 0..3000 {
                let radius = random.log_between(0.03, 3.0) as f32;
                let sphere = Sphere { center: random.in_view(distance, angle).as_vec3(), radius };
                for _ in 0..4 {
                    tally.sphere(&Shape::sphere(&sphere).ray(&mut random, orthographic), &sphere, 0.05);
                }
            }
            tally.assert_clean(&format!("spheres at {distance} Å, orthographic {orthographic}"));
        }
    }
}

#[test]
fn cylinders_with_all_caps_are_hit_where_they_are_at_any_distance() {
    for orthographic in [false, true] {
        for caps in CAPS.into_iter().flat_map(|a| CAPS.map(|b| [a, b])) {
            for (distance, angle) in DISTANCES {
                let mut random = Random(distance as u64 ^ 77);
                let mut tally = Tally::default();
                for _ in 0..400 {
                    let center = random.in_view(distance, angle);
                    let axis = random.direction();
                    let (length, radius) = (random_length(&mut random), random.log_between(0.03, 3.0));
                    let stick = cylinder(center, axis, length, radius, caps).unwrap();
                    for _ in 0..8 {
                        tally.cylinder(&Shape::cylinder(&stick).ray(&mut random, orthographic), &stick, 0.05);
                    }
                }
                tally.assert_clean(&format!("caps {caps:?} at {distance} Å, orthographic {orthographic}"));
            }
        }
    }
}

#[test]
fn no_direction_of_the_axis_is_special() {
    for orthographic in [false, true] {
        for caps in [[FLAT, FLAT], [ROUND, ROUND], [FLAT, ROUND], [OPEN, OPEN], [OPEN, FLAT]] {
            let mut tally = Tally::default();
            let mut random = Random(5);
            for distance in [2.0, 30.0, 300.0, 5000.0] {
                for i in 0..80 {
                    let on_view_axis = i % 2 == 0;
                    let center = random.in_view(distance, if on_view_axis { 0.0 } else { 0.5 });
                    let towards = center.normalize();
                    let across = towards.any_orthonormal_vector();
                    let nearly = (towards + across * random.log_between(1e-9, 1e-2)).normalize();
                    let axes = [DVec3::X, DVec3::Y, DVec3::Z, towards, across, nearly];
                    for axis in axes.into_iter().flat_map(|axis| [axis, -axis]) {
                        let stick = cylinder(center, axis, 1.5, 0.15, caps).unwrap();
                        let shape = Shape::cylinder(&stick);
                        for _ in 0..8 {
                            tally.cylinder(&shape.ray(&mut random, orthographic), &stick, 0.05);
                        }
                    }
                }
            }
            tally.assert_clean(&format!("special axes, caps {caps:?}, orthographic {orthographic}"));
        }
    }
}

#[test]
fn rays_exactly_along_the_axis_hit_the_near_cap_or_nothing() {
    let ray = |x: f32| Ray { origin: Vec3::new(x, 0.0, 0.0), direction: Vec3::NEG_Z };
    for (caps, inside) in [
        ([FLAT, FLAT], 9.0),
        ([ROUND, ROUND], 9.0 - 0.1f64.mul_add(-0.1, 0.15 * 0.15).sqrt()),
        ([OPEN, FLAT], 11.0),
        ([FLAT, OPEN], 9.0),
        ([OPEN, OPEN], f64::INFINITY),
    ] {
        // End a is the near one.
        let stick = cylinder(DVec3::new(0.0, 0.0, -10.0), DVec3::NEG_Z, 2.0, 0.15, caps).unwrap();
        let t = cylinder_t(&ray(0.1), &stick, 0.1);
        assert!(f64::from(t) == inside || (f64::from(t) - inside).abs() < 2e-6, "{caps:?}: {t}");
        assert_eq!(cylinder_t(&ray(0.1502), &stick, 0.1), f32::INFINITY, "{caps:?}");
        if t.is_finite() && caps[0] != ROUND {
            assert!((cylinder_normal(&ray(0.1), &stick, 0.1, t) - Vec3::Z).length() < 1e-5, "{caps:?}");
        }
    }
}

#[test]
fn what_the_near_plane_cuts_is_solid() {
    for orthographic in [false, true] {
        let mut tally = Tally::default();
        let mut random = Random(9);
        for _ in 0..3000 {
            let near = random.between(0.3, 2.0);
            let radius = random.log_between(0.03, 3.0);
            let center = DVec3::new(random.between(-0.5, 0.5), random.between(-0.5, 0.5), -near) * (1.0 + radius);
            let sphere = Sphere { center: center.as_vec3(), radius: radius as f32 };
            let ends = [random.below(2), random.below(2)].map(|cap| [FLAT, ROUND][cap as usize]);
            let length = random_length(&mut random).min(4.0);
            let stick = cylinder(center, random.direction(), length, radius, ends).unwrap();
            for _ in 0..4 {
                let (ball, tube) = (Shape::sphere(&sphere), Shape::cylinder(&stick));
                for shape in [ball, tube] {
                    let mut p = shape.point(&mut random, false);
                    p.z = p.z.min(-0.1);
                    let ray = ray_to(p, orthographic);
                    if shape.axis.is_none() {
                        tally.sphere(&ray, &sphere, near as f32);
                    } else {
                        tally.cylinder(&ray, &stick, near as f32);
                    }
                }
            }
        }
        tally.assert_clean(&format!("near plane, orthographic {orthographic}"));
    }
}

#[test]
fn inside_a_solid_the_hit_is_the_near_plane_and_faces_the_camera() {
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::new(0.3, -0.2, -1.0) };
    let to_camera = -ray.direction.normalize();
    let sphere = Sphere { center: Vec3::new(0.1, 0.0, 0.2), radius: 2.0 };
    assert_eq!(sphere_t(&ray, &sphere, 0.25), 0.25);
    assert!((sphere_normal(&ray, &sphere, 0.25, 0.25) - to_camera).length() < 1e-6);
    for caps in [[FLAT, FLAT], [ROUND, ROUND], [ROUND, FLAT]] {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8)] {
            let stick = cylinder(DVec3::ZERO, axis, 6.0, 1.0, caps).unwrap();
            assert_eq!(cylinder_t(&ray, &stick, 0.25), 0.25, "{caps:?} {axis}");
            assert!((cylinder_normal(&ray, &stick, 0.25, 0.25) - to_camera).length() < 1e-6);
        }
    }
    // An open tube has no inside to fill: one sees its wall.
    let tube = cylinder(DVec3::ZERO, DVec3::Z, 6.0, 0.5, [OPEN, OPEN]).unwrap();
    let t = cylinder_t(&ray, &tube, 0.25);
    assert!((ray.direction * t).truncate().length() - 0.5 < 1e-6 && t > 0.25);
    assert!(cylinder_normal(&ray, &tube, 0.25, t).dot(ray.direction) < 0.0);
}

#[test]
fn the_colour_changes_in_the_middle() {
    let mut random = Random(3);
    for _ in 0..2000 {
        let stick = cylinder(random.in_view(50.0, 0.5), random.direction(), 1.5, 0.15, [FLAT, FLAT]).unwrap();
        let shape = Shape::cylinder(&stick);
        let ray = shape.ray(&mut random, false);
        let t = cylinder_t(&ray, &stick, 0.1);
        if t.is_finite() {
            let y = (ray.direction.as_dvec3() * f64::from(t) - shape.center).dot(shape.axis.unwrap());
            assert!(y.abs() < 1e-4 || cylinder_half(&ray, &stick, t) == (y > 0.0), "{y}");
        }
    }
}

#[test]
fn what_has_no_length_or_radius_is_no_cylinder() {
    assert!(cylinder(DVec3::ZERO, DVec3::X, 0.0, 0.1, [FLAT, FLAT]).is_none());
    assert!(cylinder(DVec3::ZERO, DVec3::X, 1.0, 0.0, [FLAT, FLAT]).is_none());
    assert!(cylinder(DVec3::ZERO, DVec3::X * f64::NAN, 1.0, 0.1, [FLAT, FLAT]).is_none());
    assert!(cylinder(DVec3::ZERO, DVec3::X, 1.0, f64::NAN, [FLAT, FLAT]).is_none());
}

#[test]
fn a_stick_of_hardly_any_length_is_a_disc_or_a_ball() {
    for caps in [[FLAT, FLAT], [ROUND, ROUND], [ROUND, FLAT], [OPEN, FLAT]] {
        let mut tally = Tally::default();
        let mut random = Random(11);
        for _ in 0..1500 {
            let stick = cylinder(random.in_view(20.0, 0.5), random.direction(), 1e-7, 0.5, caps).unwrap();
            for _ in 0..4 {
                tally.cylinder(&Shape::cylinder(&stick).ray(&mut random, false), &stick, 0.1);
            }
        }
        tally.assert_clean(&format!("length 1e-7, caps {caps:?}"));
    }
}

proptest! {
    #[test]
    fn nothing_is_ever_not_a_number(
        center in prop::array::uniform3(-1e4f64..1e4),
        axis in prop::array::uniform3(-1.0f64..1.0),
        exponents in prop::array::uniform2(-7.0f64..3.0),
        caps in prop::array::uniform2(0u32..3),
        plane in prop::array::uniform2(-2.0f32..2.0),
        aimed in any::<bool>(),
        orthographic in any::<bool>(),
    ) {
        let center = DVec3::from(center);
        let axis = DVec3::from(axis).normalize_or(DVec3::Y);
        let [length, radius] = exponents.map(|exponent| 10f64.powf(exponent));
        let Some(stick) = cylinder(center, axis, length, radius, caps) else { return Ok(()) };
        let sphere = Sphere { center: stick.center, radius: stick.radius };
        let ray = match (aimed && center.z < -0.1, orthographic) {
            (true, _) => ray_to(center, orthographic),
            (_, true) => Ray { origin: Vec3::new(plane[0], plane[1], 0.0), direction: Vec3::NEG_Z },
            _ => Ray { origin: Vec3::ZERO, direction: Vec3::new(plane[0], plane[1], -1.0) },
        };
        for (t, normal) in [
            (sphere_t(&ray, &sphere, 0.1), sphere_normal(&ray, &sphere, 0.1, sphere_t(&ray, &sphere, 0.1))),
            (cylinder_t(&ray, &stick, 0.1), cylinder_normal(&ray, &stick, 0.1, cylinder_t(&ray, &stick, 0.1))),
        ] {
            prop_assert!(t >= 0.1, "{t}");
            prop_assert!(t == f32::INFINITY || (normal.length() - 1.0).abs() < 1e-4, "{t} {normal}");
        }
    }
}
