//! Cones, tori and triangles against the f64 shapes of [`crate::render::test_solids`], from 1 Å to 10,000 Å; the rules of what is
//! wrong are those of the tests of spheres and cylinders.

use super::*;
use crate::render::test_shapes::{Random, at, ray_to};
use crate::render::test_solids::{Body, Drawn, cone, random_drawn, torus, triangle};
use glam::DVec3;
use proptest::prelude::*;

fn t_of(ray: &Ray, drawn: &Drawn, near: f32) -> f32 {
    match drawn {
        Drawn::Cone(cone) => cone_t(ray, cone, near),
        Drawn::Torus(torus) => torus_t(ray, torus, near),
        Drawn::Triangle(triangle) => triangle_t(ray, triangle, near),
    }
}

fn normal_of(ray: &Ray, drawn: &Drawn, near: f32, t: f32) -> Vec3 {
    match drawn {
        Drawn::Cone(cone) => cone_normal(ray, cone, near, t),
        Drawn::Torus(torus) => torus_normal(ray, torus, near, t),
        Drawn::Triangle(triangle) => triangle_normal(ray, triangle),
    }
}

#[derive(Default)]
struct Tally {
    rays: u32,
    hits: u32,
    /// Hits, misses, depths, normals.
    wrong: [u32; 4],
    example: String,
}

impl Tally {
    fn count(&mut self, which: usize, message: String) {
        self.wrong[which] += 1;
        if self.example.is_empty() {
            self.example = message;
        }
    }

    fn compare(&mut self, ray: &Ray, drawn: &Drawn, near: f32) {
        self.rays += 1;
        let body = drawn.body();
        let t = t_of(ray, drawn, near);
        let case = || format!("{body:?}\n{ray:?} near {near}, t {t}");
        assert!(!t.is_nan() && t >= near, "{}", case());
        let hits = |margin: f64| -> Vec<_> {
            body.variants(margin).into_iter().map(|body| body.first_hit(ray, f64::from(near))).collect()
        };
        let resolved = 4.0 * f64::from(f32::EPSILON) * (body.center().length() + body.reach());
        // Triangles are made wider by as much as that, for their neighbours.
        let wide = hits((0.01 * body.width()).max(2.0 * resolved));
        if t == f32::INFINITY {
            if wide.iter().all(Option::is_some) {
                self.count(1, format!("missed: {} want {:?}", case(), wide[0]));
            }
            return;
        }
        self.hits += 1;
        if wide.iter().all(Option::is_none) {
            return self.count(0, format!("hit nothing: {}", case()));
        }
        let close: Vec<_> = hits(resolved).into_iter().flatten().collect();
        if close.len() < body.variants(0.0).len() || close.iter().any(|hit| hit.1 != close[0].1) {
            return; // along the silhouette or an edge
        }
        let facing = close[0].2.dot(ray.direction.as_dvec3().normalize()).abs();
        if facing < 0.05 {
            return; // grazing
        }
        let search = if matches!(body, Body::Torus { .. }) { 1e-3 * body.width() } else { 0.0 };
        let slack = search + 2.0 * resolved * (1.0 + 1.0 / facing);
        let least = close.iter().fold(f64::INFINITY, |least, hit| least.min(hit.0)) - slack;
        let most = close.iter().fold(f64::NEG_INFINITY, |most, hit| most.max(hit.0)) + slack;
        if !(least..=most).contains(&f64::from(t)) {
            return self.count(2, format!("depth: {} want {least}..{most} {:?}", case(), close[0]));
        }
        let normal = normal_of(ray, drawn, near, t).as_dvec3();
        let spread = close.iter().map(|hit| (hit.2 - close[0].2).length()).fold(0.0, f64::max);
        let off = (normal - close[0].2).length();
        // The surface's radius of curvature: near the tip of a cone that goes to nothing.
        let curved = match body {
            Body::Cone { center, axis, .. } => (at(ray, f64::from(t)) - center).cross(axis).length(),
            _ => body.width(),
        };
        let allowed = 1e-3 + 4.0 * spread + 2.0 * slack / curved;
        if !((normal.length() - 1.0).abs() < 1e-5 && off < allowed) {
            self.count(3, format!("normal: {} {normal} off {off} allowed {allowed}, {:?}", case(), close[0]));
        }
    }

    fn assert_clean(&self, what: &str) {
        println!("{what}: {} rays, {} hits", self.rays, self.hits);
        assert!(self.hits * 5 > self.rays && self.hits * 50 < self.rays * 49, "{what}: {} of {}", self.hits, self.rays);
        assert_eq!(self.wrong, [0; 4], "{what}: hits, misses, depths, normals of {}; {}", self.rays, self.example);
    }
}

/// A ray at or close by the body, most of them near its edges.
fn ray_at(body: &Body, random: &mut Random, orthographic: bool) -> Ray {
    let off = random.direction() * body.width() * random.log_between(0.001, 0.3);
    ray_to(body.point(random) + off, orthographic)
}

const DISTANCES: [(f64, f64); 6] =
    [(3.0, 1.0), (10.0, 1.0), (100.0, 1.0), (1000.0, 1.0), (3000.0, 0.6), (10_000.0, 0.35)];

fn at_any_distance(kind: u32, what: &str) {
    for orthographic in [false, true] {
        for (distance, angle) in DISTANCES {
            let mut random = Random(distance as u64 ^ 1234);
            let mut tally = Tally::default();
            for _ in 0..2000 {
                let center = random.in_view(distance, angle);
                let drawn = random_drawn(&mut random, kind, center);
                for _ in 0..6 {
                    let ray = ray_at(&drawn.body(), &mut random, orthographic);
                    if ray.direction.is_finite() && ray.direction.length() < 30.0 {
                        tally.compare(&ray, &drawn, 0.05);
                    }
                }
            }
            tally.assert_clean(&format!("{what} at {distance} Å, orthographic {orthographic}"));
        }
    }
}

#[test]
fn cones_are_hit_where_they_are_at_any_distance() {
    at_any_distance(0, "cones");
}

#[test]
fn tori_are_hit_where_they_are_at_any_distance() {
    at_any_distance(1, "tori");
}

#[test]
fn triangles_are_hit_where_they_are_at_any_distance() {
    at_any_distance(2, "triangles");
}

#[test]
fn what_the_near_plane_cuts_is_solid() {
    for kind in 0..3 {
        let (mut tally, mut random) = (Tally::default(), Random(9));
        for i in 0..4000 {
            let near = random.between(0.3, 2.0);
            let center = DVec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), -near);
            let drawn = random_drawn(&mut random, kind, center);
            for _ in 0..4 {
                let mut p = drawn.body().point(&mut random) + random.direction() * drawn.body().width() * 0.2;
                p.z = p.z.min(-0.2);
                tally.compare(&ray_to(p, i % 2 == 0), &drawn, near as f32);
            }
        }
        let wrong = (tally.wrong, tally.example);
        assert_eq!(wrong.0, [0; 4], "{kind}: {}", wrong.1);
        assert!(tally.hits > 2000);
    }
}

#[test]
fn inside_a_solid_the_hit_is_the_near_plane_and_faces_the_camera() {
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::new(0.3, -0.2, -1.0) };
    let to_camera = -ray.direction.normalize();
    for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8)] {
        let drawn = [
            Drawn::Cone(cone(DVec3::ZERO, axis, 6.0, [2.0, 1.0]).unwrap()),
            Drawn::Torus(torus(axis.any_orthonormal_vector() * 3.0, axis, 3.0, 1.0).unwrap()),
        ];
        for solid in drawn {
            assert_eq!(t_of(&ray, &solid, 0.25), 0.25, "{solid:?}");
            assert!((normal_of(&ray, &solid, 0.25, 0.25) - to_camera).length() < 1e-6);
        }
    }
    // A triangle is no solid: behind the near plane it is gone.
    let corners = [DVec3::new(-9.0, -9.0, 0.0), DVec3::new(9.0, -9.0, 0.0), DVec3::new(0.0, 9.0, 0.0)];
    let flat = triangle(DVec3::new(0.0, 0.0, -1.0), corners).unwrap();
    assert!((triangle_t(&ray, &flat, 0.25) - 1.0).abs() < 1e-6);
    assert_eq!(triangle_t(&ray, &flat, 1.5), f32::INFINITY);
}

#[test]
fn a_ray_along_the_axis_meets_the_cap_the_tip_or_goes_through_the_ring() {
    let ray = |x: f32| Ray { origin: Vec3::new(x, 0.0, 0.0), direction: Vec3::NEG_Z };
    let center = DVec3::new(0.0, 0.0, -10.0);
    // End a is the near one.
    for (radii, x, want) in [
        ([0.0, 1.0], 0.0, 9.0),
        ([0.0, 1.0], 0.5, 10.0),
        ([1.0, 0.0], 0.5, 9.0),
        ([0.5, 0.5], 0.4, 9.0),
        ([0.5, 0.5], 0.6, f32::INFINITY),
        ([0.5, 1.0], 0.75, 10.0),
    ] {
        let t = cone_t(&ray(x), &cone(center, DVec3::NEG_Z, 2.0, radii).unwrap(), 0.1);
        assert!(t == want || (t - want).abs() < 1e-5, "{radii:?} {x}: {t}");
    }
    let ring = torus(center, DVec3::Z, 2.0, 0.25).unwrap();
    assert_eq!(torus_t(&ray(0.0), &ring, 0.1), f32::INFINITY);
    assert!((torus_t(&ray(2.0), &ring, 0.1) - 9.75).abs() < 1e-5);
    assert!((torus_normal(&ray(2.0), &ring, 0.1, 9.75) - Vec3::Z).length() < 1e-4);
}

#[test]
fn along_a_line_of_the_cone_nothing_is_divided_by_nothing() {
    let solid = cone(DVec3::new(0.0, 0.0, -10.0), DVec3::NEG_Z, 2.0, [0.0, 2.0]).unwrap();
    // Parallel to a line of the surface: a = 0 exactly.
    for (x, hits) in [(8.5f32, false), (9.5, true), (10.5, true), (12.5, true), (13.5, false)] {
        let ray = Ray { origin: Vec3::new(x, 0.0, 0.0), direction: Vec3::new(-1.0, 0.0, -1.0) };
        let t = cone_t(&ray, &solid, 0.1);
        assert_eq!(t.is_finite(), hits, "{x}: {t}");
        assert!(!hits || (cone_normal(&ray, &solid, 0.1, t).length() - 1.0).abs() < 1e-5);
    }
}

#[test]
fn what_has_no_extent_is_nothing() {
    let (x, nan) = (DVec3::X, f64::NAN);
    for radii in [[0.0, 0.0], [-1.0, 1.0], [nan, 1.0]] {
        assert!(cone(DVec3::ZERO, x, 1.0, radii).is_none(), "{radii:?}");
    }
    assert!(cone(DVec3::ZERO, x, 0.0, [1.0; 2]).is_none() && cone(DVec3::ZERO, x * nan, 1.0, [1.0; 2]).is_none());
    assert!(torus(DVec3::ZERO, DVec3::ZERO, 1.0, 0.1).is_none() && torus(DVec3::ZERO, x, nan, 0.1).is_none());
    assert!(torus(DVec3::ZERO, x, 1.0, 0.0).is_none() && torus(DVec3::ZERO, x, 1.0, nan).is_none());
    for corners in [[x, x, x], [x, x * 2.0, x * 3.0], [x, DVec3::Y, x * nan]] {
        assert!(triangle(DVec3::ZERO, corners).is_none(), "{corners:?}");
    }
}

#[test]
fn normals_are_interpolated_and_face_the_camera_from_both_sides() {
    let corners = [DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 0.0)];
    let mut face = triangle(DVec3::new(0.0, 0.0, -5.0), corners).unwrap();
    let lean = Vec3::new(0.3, 0.0, 1.0).normalize();
    for side in [1.0, -1.0] {
        face.normals = [lean * side, Vec3::Z * side, Vec3::Z * side];
        let at_corner = ray_to(DVec3::new(-0.999, -0.9985, -5.0), false);
        let normal = triangle_normal(&at_corner, &face);
        assert!((normal - lean).length() < 2e-3, "{side}: {normal}");
        let weights = triangle_weights(&ray_to(DVec3::new(0.0, -1.0 / 3.0, -5.0), false), &face);
        assert!((weights - Vec3::splat(1.0 / 3.0)).length() < 1e-5, "{weights}");
    }
}

#[test]
fn triangles_that_share_an_edge_leave_no_gap() {
    let mut random = Random(21);
    for distance in [5.0, 100.0, 3000.0] {
        let mut missed = 0;
        for _ in 0..20_000 {
            let center = random.in_view(distance, 0.8);
            let corners = [0; 4].map(|_| random.direction().as_vec3());
            let [a, b, c, d] = corners.map(Vec3::as_dvec3);
            let side = |p: DVec3| (a + center).dot((b + center).cross(p + center));
            if side(c) * side(d) >= 0.0 {
                continue;
            }
            let (Some(left), Some(right)) = (triangle(center, [a, b, c]), triangle(center, [b, a, d])) else {
                continue;
            };
            let on_edge = center + a + (b - a) * random.between(0.05, 0.95);
            let ray = ray_to(on_edge, false);
            let widths = [&left, &right].map(|t| t.face.normalize().dot(ray.direction.normalize()).abs());
            if widths[0].min(widths[1]) > 0.05 {
                missed += u32::from(
                    triangle_t(&ray, &left, 0.1).is_infinite() && triangle_t(&ray, &right, 0.1).is_infinite(),
                );
            }
        }
        assert_eq!(missed, 0, "{distance}");
    }
}

proptest! {
    #[test]
    fn nothing_is_ever_not_a_number(
        center in prop::array::uniform3(-1e4f64..1e4),
        axis in prop::array::uniform3(-1.0f64..1.0),
        exponents in prop::array::uniform3(-9.0f64..4.0),
        corners in prop::array::uniform3(prop::array::uniform3(-1.0f64..1.0)),
        plane in prop::array::uniform2(-2.0f32..2.0),
        aimed in any::<bool>(),
        orthographic in any::<bool>(),
    ) {
        let (center, axis) = (DVec3::from(center), DVec3::from(axis).normalize_or(DVec3::Y));
        let [length, one, other] = exponents.map(|exponent| 10f64.powf(exponent));
        let ray = match (aimed && center.z < -0.1, orthographic) {
            (true, _) => ray_to(center, orthographic),
            (_, true) => Ray { origin: Vec3::new(plane[0], plane[1], 0.0), direction: Vec3::NEG_Z },
            _ => Ray { origin: Vec3::ZERO, direction: Vec3::new(plane[0], plane[1], -1.0) },
        };
        let corners = corners.map(|corner| DVec3::from(corner) * one);
        let drawn = [
            cone(center, axis, length, [one, other]).map(Drawn::Cone),
            cone(center, axis, length, [0.0, other]).map(Drawn::Cone),
            torus(center, axis, one, other).map(Drawn::Torus),
            torus(center, axis, 0.0, other).map(Drawn::Torus),
            triangle(center, corners).map(Drawn::Triangle),
        ];
        for shape in drawn.iter().flatten() {
            let t = t_of(&ray, shape, 0.1);
            prop_assert!(t >= 0.1, "{t}");
            let normal = normal_of(&ray, shape, 0.1, t);
            prop_assert!(t == f32::INFINITY || (normal.length() - 1.0).abs() < 1e-4, "{shape:?} {t} {normal}");
            prop_assert!(t == f32::INFINITY || normal.dot(ray.direction) < 1e-4, "{shape:?} {t} {normal}");
        }
    }
}
