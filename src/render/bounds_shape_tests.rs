//! Bounds of cones, tori and triangles: against points of f64 bodies, and against the area that rays find covered.

use super::*;
use crate::render::cpu::intersect::{cone_t, torus_t, triangle_t};
use crate::render::test_shapes::Random;
use crate::render::test_solids::{Drawn, random_drawn};
use crate::scene::Ray;
use glam::{DVec2, DVec3};

/// The pieces that bound one.
fn pieces(drawn: &Drawn, camera: &BoundsCamera) -> Vec<PlaneTrapezoid> {
    match drawn {
        Drawn::Cone(cone) => cone_rect(cone, camera).into_iter().collect(),
        Drawn::Triangle(triangle) => triangle_rect(triangle, camera).into_iter().collect(),
        Drawn::Torus(torus) => (0..TORUS_PIECES)
            .filter_map(|piece| torus_rect(torus, piece, camera))
            .map(|rect| {
                let middle = Vec2::new(rect.along.dot(rect.center), rect.along.perp().dot(rect.center));
                PlaneTrapezoid::rectangle(rect.along, middle - rect.half, middle + rect.half)
            })
            .collect(),
    }
}

/// By how much a plane point lies outside.
fn outside(bounds: &PlaneTrapezoid, point: DVec2) -> f64 {
    let along = bounds.along.as_dvec2();
    let (x, y) = (along.dot(point), along.perp().dot(point));
    let [x0, x1] = bounds.x.map(f64::from);
    let beyond = |[at0, at1]: [f32; 2]| {
        let (at0, rise) = (f64::from(at0), f64::from(at1) - f64::from(at0));
        let run = (x1 - x0).max(1e-30);
        (y - (at0 + rise * (x - x0) / run)) / (1.0 + (rise / run).powi(2)).sqrt()
    };
    (x0 - x).max(x - x1).max(beyond(bounds.upper)).max(-beyond(bounds.lower))
}

fn area(bounds: &PlaneTrapezoid) -> f64 {
    let width = |end: usize| f64::from(bounds.upper[end] - bounds.lower[end]);
    0.5 * f64::from(bounds.x[1] - bounds.x[0]) * (width(0) + width(1))
}

fn assert_holds(drawn: &Drawn, camera: &BoundsCamera, random: &mut Random) -> u32 {
    let (body, pieces) = (drawn.body(), pieces(drawn, camera));
    let mut seen = 0;
    for _ in 0..60 {
        let p = body.point(random);
        if -p.z < f64::from(camera.near) * (1.0 + 1e-6) + 1e-6 * body.reach() {
            continue;
        }
        seen += 1;
        let point = if camera.orthographic { p.truncate() } else { p.truncate() / -p.z };
        let excess = pieces.iter().map(|piece| outside(piece, point)).fold(f64::INFINITY, f64::min);
        // A millionth of the coordinates; and what the rounding of the ends to f32 tilts a cap by.
        let tilt = f64::from(f32::EPSILON) * body.center().length() / body.reach().min(0.1);
        let per_angstrom = if camera.orthographic { 1.0 } else { 1.0 / -p.z };
        let allowed = 2e-6 * point.abs().max_element() + (tilt + 1e-6) * body.width() * per_angstrom;
        assert!(excess <= allowed, "{drawn:?} {camera:?}: {point} outside {pieces:?} by {excess}, not {allowed}");
    }
    seen
}

#[test]
fn no_covered_point_is_outside() {
    let (mut random, mut seen) = (Random(1), 0);
    for i in 0..10_000 {
        let distance = random.log_between(6.0, 10_000.0);
        let center = random.in_view(distance, 60f64.to_radians());
        let drawn = random_drawn(&mut random, i % 3, center);
        let camera = BoundsCamera { orthographic: random.below(3) == 0, near: 0.1 };
        seen += assert_holds(&drawn, &camera, &mut random);
    }
    assert!(seen > 500_000, "{seen}");
}

#[test]
fn what_crosses_the_near_plane_is_not_lost() {
    let (mut random, mut seen) = (Random(2), 0);
    for i in 0..10_000 {
        let near = random.log_between(0.05, 2.0);
        let depth = near + random.between(-4.0, 4.0);
        let center = DVec3::new(random.between(-4.0, 4.0), random.between(-4.0, 4.0), -depth);
        let drawn = random_drawn(&mut random, i % 3, center);
        let camera = BoundsCamera { orthographic: random.below(3) == 0, near: near as f32 };
        seen += assert_holds(&drawn, &camera, &mut random);
    }
    assert!(seen > 100_000, "{seen}");
}

/// Rays for the covered area: a grid of this many on a side.
const GRID: u32 = 32;

/// Area of the bounds, pieces one by one, over the part of the plane that rays find covered.
fn excess(drawn: &Drawn, camera: &BoundsCamera) -> f64 {
    let pieces = pieces(drawn, camera);
    // A ring is seen as an ellipse, longest across its axis.
    let along = match drawn {
        Drawn::Torus(torus) => torus.axis().truncate().try_normalize().unwrap_or(Vec2::X),
        _ => pieces[0].along,
    };
    let corners = pieces.iter().flat_map(PlaneTrapezoid::corners);
    let turned = corners.map(|p| Vec2::new(along.dot(p), along.perp().dot(p)));
    let (low, high) = turned.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let mut covered = 0;
    for i in 0..GRID * GRID {
        let part = (Vec2::new((i % GRID) as f32, (i / GRID) as f32) + 0.5) / GRID as f32;
        let at = low + (high - low) * part;
        let p = along * at.x + along.perp() * at.y;
        let ray = if camera.orthographic {
            Ray { origin: p.extend(0.0), direction: Vec3::NEG_Z }
        } else {
            Ray { origin: Vec3::ZERO, direction: p.extend(-1.0) }
        };
        let t = match drawn {
            Drawn::Cone(cone) => cone_t(&ray, cone, camera.near),
            Drawn::Torus(torus) => torus_t(&ray, torus, camera.near),
            Drawn::Triangle(triangle) => triangle_t(&ray, triangle, camera.near),
        };
        covered += u32::from(t.is_finite());
    }
    let whole = f64::from((high - low).x) * f64::from((high - low).y);
    let seen = whole * f64::from(covered.max(1)) / f64::from(GRID * GRID);
    pieces.iter().map(area).sum::<f64>() / seen
}

#[test]
fn bounds_are_tight() {
    for (kind, what) in [(0, "cones"), (1, "tori"), (2, "triangles")] {
        let (mut random, mut sum, mut count, mut worst) = (Random(3), 0.0, 0, 0.0f64);
        while count < 10_000 {
            let distance = random.log_between(8.0, 1000.0);
            let center = random.in_view(distance, 60f64.to_radians());
            let drawn = random_drawn(&mut random, kind, center);
            let camera = BoundsCamera { orthographic: count % 3 == 0, near: 0.1 };
            if -center.z - drawn.body().reach() < 0.1 {
                continue;
            }
            let excess = excess(&drawn, &camera);
            (sum, count, worst) = (sum + excess, count + 1, worst.max(excess));
        }
        let mean = sum / f64::from(count);
        println!("{what}: {mean:.3} times the covered area, at most {worst:.1}");
        assert!((0.95..1.6).contains(&mean), "{what}: {mean}");
    }
}

#[test]
fn slivers_and_bodies_seen_end_on_have_bounds_without_nan() {
    use crate::render::test_solids::{cone, torus, triangle};
    let at = DVec3::new(0.5, 0.0, -5.0);
    let thin = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-6, 0.0)];
    let edge_on = [DVec3::ZERO, at, at * 0.5 + DVec3::Y * 1e-5];
    let drawn = [
        Drawn::Cone(cone(at, at.normalize(), 1.0, [0.3, 0.0]).unwrap()),
        Drawn::Cone(cone(at, at.normalize(), 1.0, [0.0, 0.3]).unwrap()),
        Drawn::Cone(cone(at, DVec3::X, 1e-6, [0.0, 0.3]).unwrap()),
        Drawn::Cone(cone(at, DVec3::X, 1.0, [0.0, 1e-6]).unwrap()),
        Drawn::Torus(torus(at, at.normalize(), 1.0, 1e-4).unwrap()),
        Drawn::Torus(torus(at, at.any_orthonormal_vector(), 0.0, 0.5).unwrap()),
        Drawn::Triangle(triangle(at, thin).unwrap()),
        Drawn::Triangle(triangle(at, edge_on).unwrap()),
    ];
    for solid in &drawn {
        for camera in [true, false].map(|orthographic| BoundsCamera { orthographic, near: 0.1 }) {
            let pieces = pieces(solid, &camera);
            assert!(!pieces.is_empty());
            for piece in pieces {
                assert!(piece.corners().iter().all(|corner| corner.is_finite()), "{solid:?} {piece:?}");
                assert!((piece.along.length() - 1.0).abs() < 1e-5 && area(&piece) >= 0.0, "{solid:?} {piece:?}");
            }
            assert_holds(solid, &camera, &mut Random(5));
        }
    }
}
