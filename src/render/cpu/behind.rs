//! Whether a primitive hides the light of one direction from sixteen points at a time, wherever they lie.
//!
//! Loops over lanes without branches, which become vector code (see [`super::simd`]). What a triangle and a direction give
//! is found once for all lanes; cones and open sticks ask the same functions as a single ray does. A ray starts at its point: what
//! lies behind that hides nothing.

use super::intersect::{cone_t, cylinder_t, torus_ts};
use super::lanes::{LANES, Lanes};
use super::simd::{Work, widest};
use crate::math::{max, min};
use crate::render::solids::{Cone, Cylinder, Primitive, Solids, Torus, Triangle};
use crate::scene::Ray;
use glam::Vec3;

/// All bits of a lane, or none.
pub(super) type Mask = [u32; LANES];

/// Clears the lanes that primitive `index` hides the light from; bits of those that are left.
#[inline(always)]
pub(super) fn behind(solids: &Solids, index: u32, d: Vec3, position: &[Lanes; 3], free: &mut Mask) -> u32 {
    match solids.primitive(index as usize) {
        Primitive::Sphere(s) => {
            let sphere = &solids.spheres[s];
            behind_sphere(sphere.center, sphere.radius, d, position, free)
        }
        Primitive::Cylinder(c) if solids.cylinders[c].is_open() => {
            behind_open_stick(&solids.cylinders[c], d, position, free)
        }
        Primitive::Cylinder(c) => {
            let cylinder = &solids.cylinders[c];
            let mut left = behind_cylinder(cylinder, cylinder.axis().dot(d), d, position, free);
            for (end, round) in cylinder.ends().into_iter().zip(cylinder.round()) {
                if round {
                    left = behind_sphere(end, cylinder.radius, d, position, free);
                }
            }
            left
        }
        Primitive::Cone(c) => behind_cone(&solids.cones[c], d, position, free),
        Primitive::Triangle(t) => behind_triangle(&solids.triangles[t], d, position, free),
        Primitive::Torus(t) => behind_torus(&solids.tori[t], d, position, free),
    }
}

/// Clears the lanes that a ball hides the light from; bits of those that are left.
#[inline(always)]
fn behind_sphere(c: Vec3, radius: f32, d: Vec3, position: &[Lanes; 3], free: &mut Mask) -> u32 {
    let r2 = radius * radius;
    let [px, py, pz] = position;
    let mut left = 0;
    for lane in 0..LANES {
        let (x, y, z) = (c.x - px[lane], c.y - py[lane], c.z - pz[lane]);
        let along = x * d.x + y * d.y + z * d.z;
        let away = x * x + y * y + z * z;
        // Either the ray starts inside, or the ball is ahead and near enough to the ray.
        let hides = (away < r2) | ((along > 0.0) & (away - along * along < r2));
        free[lane] = if hides { 0 } else { free[lane] };
        left |= free[lane];
    }
    left
}

/// Clears the lanes that a torus hides the light from; bits of those that are left. It may hide itself. On its own, for it is long and
/// seldom asked.
#[inline(never)]
fn behind_torus(torus: &Torus, d: Vec3, position: &[Lanes; 3], free: &mut Mask) -> u32 {
    widest(BehindTorus { torus, d, position, free });
    free.iter().fold(0, |left, free| left | free)
}

/// See [`behind_torus`].
struct BehindTorus<'a> {
    torus: &'a Torus,
    d: Vec3,
    position: &'a [Lanes; 3],
    free: &'a mut Mask,
}

impl Work for BehindTorus<'_> {
    #[inline(always)]
    fn run(self) {
        let [px, py, pz] = self.position;
        let ray = |lane: usize| Ray { origin: Vec3::new(px[lane], py[lane], pz[lane]), direction: self.d };
        let ts = torus_ts::<LANES>(ray, self.torus, 0.0);
        for (free, t) in self.free.iter_mut().zip(ts) {
            *free = if t < f32::INFINITY { 0 } else { *free };
        }
    }
}

/// Clears the lanes that a cylinder hides the light from (its ends taken as flat and closed); bits of those that are left.
/// `cosine` is that of axis and direction. A ray is free where the part of it inside of the endless cylinder (about its point
/// nearest to the axis) and the one between the planes of the ends do not overlap beyond its start.
#[inline(always)]
fn behind_cylinder(cylinder: &Cylinder, cosine: f32, d: Vec3, position: &[Lanes; 3], free: &mut Mask) -> u32 {
    let (c, a, h, radius) = (cylinder.center, cylinder.axis(), cylinder.half_length, cylinder.radius);
    let n = a.cross(d);
    let sine2 = n.dot(n);
    // Along the axis within 1e-3 rad a ray is inside for ever or never.
    let (parallel, flat) = (sine2 < 1e-6, cosine.abs() < 1e-6);
    let over_sine2 = if parallel { 0.0 } else { 1.0 / sine2 };
    let over_cosine = if flat { 0.0 } else { 1.0 / cosine };
    let wide = f32::MAX;
    let [px, py, pz] = position;
    let mut left = 0;
    for lane in 0..LANES {
        let (x, y, z) = (px[lane] - c.x, py[lane] - c.y, pz[lane] - c.z);
        let across = x * n.x + y * n.y + z * n.z;
        let up = x * a.x + y * a.y + z * a.z;
        let ahead = x * d.x + y * d.y + z * d.z;
        let away = x * x + y * y + z * z - ahead * ahead;
        let inside = if parallel { radius * radius - away } else { radius * radius * sine2 - across * across };
        let middle = (up * cosine - ahead) * over_sine2;
        let half = if parallel { wide } else { max(inside, 0.0).sqrt() * over_sine2 };
        let (to_a, to_b) = ((-h - up) * over_cosine, (h - up) * over_cosine);
        let level = if up.abs() < h { wide } else { -wide };
        let (near, far) = (min(to_a, to_b), max(to_a, to_b));
        let (near, far) = (if flat { -level } else { near }, if flat { level } else { far });
        let (entry, exit) = (max(middle - half, near), min(middle + half, far));
        let hides = (inside > 0.0) & (entry < exit) & (exit > 0.0);
        free[lane] = if hides { 0 } else { free[lane] };
        left |= free[lane];
    }
    left
}

/// Clears the lanes of `free` that a triangle hides the light from; bits of those that are left. The triangle is as wide as
/// [`super::intersect::triangle_t`] has it: by its slack, so that the light finds no gap between two of a mesh. One that is part of a
/// surface with smooth normals may hide itself.
#[inline(always)]
fn behind_triangle(triangle: &Triangle, d: Vec3, position: &[Lanes; 3], free: &mut Mask) -> u32 {
    let ([a, b, c], n) = (triangle.corners, triangle.face);
    let facing = n.dot(d);
    // Within 1e-6 rad of its plane it has no width.
    let has_width = facing * facing > 1e-12 * (n.dot(n) * d.dot(d));
    // The volume of the direction with two corners as seen from the point is linear in the point: a constant and a gradient.
    let sign = if facing < 0.0 { -1.0 } else { 1.0 };
    let edge = |from: Vec3, to: Vec3| (sign * d.dot(from.cross(to)), d.cross(to - from) * sign);
    let [(ka, ga), (kb, gb), (kc, gc)] = [edge(b, c), edge(c, a), edge(a, b)];
    let size = facing * sign;
    let [sa, sb, sc] = (triangle.slack * -size).to_array();
    // The way to the plane, times `size`.
    let (up, n) = (n.dot(a) * sign, n * sign);
    let center = triangle.center;
    let [px, py, pz] = position;
    let mut left = 0;
    for lane in 0..LANES {
        let (x, y, z) = (px[lane] - center.x, py[lane] - center.y, pz[lane] - center.z);
        let along = |v: Vec3| x * v.x + y * v.y + z * v.z;
        let inside = (ka + along(ga) >= sa) & (kb + along(gb) >= sb) & (kc + along(gc) >= sc);
        let hides = inside & (up - along(n) >= 0.0) & has_width;
        free[lane] = if hides { 0 } else { free[lane] };
        left |= free[lane];
    }
    left
}

/// The same for a cone.
#[inline(always)]
fn behind_cone(cone: &Cone, d: Vec3, position: &[Lanes; 3], free: &mut Mask) -> u32 {
    clear(d, position, free, |ray| cone_t(ray, cone, 0.0) < f32::INFINITY)
}

/// The same for a stick with an open end, whose inside it may hide itself from.
#[inline(always)]
fn behind_open_stick(cylinder: &Cylinder, d: Vec3, position: &[Lanes; 3], free: &mut Mask) -> u32 {
    clear(d, position, free, |ray| cylinder_t(ray, cylinder, 0.0) < f32::INFINITY)
}

#[inline(always)]
fn clear(d: Vec3, position: &[Lanes; 3], free: &mut Mask, hides: impl Fn(&Ray) -> bool) -> u32 {
    let [px, py, pz] = position;
    let mut left = 0;
    for lane in 0..LANES {
        let ray = Ray { origin: Vec3::new(px[lane], py[lane], pz[lane]), direction: d };
        free[lane] = if hides(&ray) { 0 } else { free[lane] };
        left |= free[lane];
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::cpu::intersect::{primitive_t, triangle_t};
    use crate::render::test_shapes::{Random, cylinder};
    use crate::render::test_solids::{Body, Drawn, random_drawn, triangle};
    use glam::DVec3;

    const ALL: Mask = [u32::MAX; LANES];

    /// Sixteen starts whose rays pass by a point of the body, half of them close to its edges; some start beyond it.
    fn starts(body: &Body, d: DVec3, random: &mut Random) -> [Lanes; 3] {
        let start = |_| {
            let off = random.direction() * body.width() * random.log_between(0.001, 1.0);
            (body.point(random) + off - d * random.between(-2.0, 60.0)).as_vec3()
        };
        lanes(std::array::from_fn(start))
    }

    fn lanes(points: [Vec3; LANES]) -> [Lanes; 3] {
        std::array::from_fn(|axis| points.map(|p| p[axis]))
    }

    /// What lanes say against what one ray says, and where they differ, whether it is a matter of rounding.
    fn compare(drawn: &Drawn, random: &mut Random) -> [u32; 3] {
        let body = drawn.body();
        let d = random.direction().as_vec3();
        let position = starts(&body, d.as_dvec3(), random);
        let mut free = ALL;
        let mut solids = Solids::default();
        let left = match drawn {
            Drawn::Triangle(triangle) => {
                solids.triangles.push(*triangle);
                behind_triangle(triangle, d, &position, &mut free)
            }
            Drawn::Cone(cone) => {
                solids.cones.push(*cone);
                behind_cone(cone, d, &position, &mut free)
            }
            Drawn::Torus(torus) => {
                solids.tori.push(*torus);
                behind_torus(torus, d, &position, &mut free)
            }
        };
        assert_eq!(left, free.iter().fold(0, |all, bits| all | bits));
        let (mut hidden, mut other) = (0, 0);
        for lane in 0..LANES {
            let ray = Ray { origin: Vec3::from_array(position.map(|axis| axis[lane])), direction: d };
            let want = primitive_t(&ray, &solids, 0, 0.0) < f32::INFINITY;
            hidden += u32::from(want);
            if want == (free[lane] == 0) {
                continue;
            }
            other += 1;
            // Only where a body a little larger or smaller, or a start a little farther on, says otherwise, too.
            let margin = 16.0 * f64::from(f32::EPSILON) * (100.0 + body.center().length() + body.reach());
            let hits: Vec<bool> = [-margin, 0.0, margin]
                .into_iter()
                .flat_map(|near| body.variants(margin).into_iter().map(move |b| b.first_hit(&ray, near).is_some()))
                .collect();
            assert!(hits.contains(&true) && hits.contains(&false), "{body:?} {ray:?} want {want}");
        }
        [hidden, other, LANES as u32]
    }

    fn many(kind: u32) {
        let mut random = Random(u64::from(kind) + 71);
        let [mut hidden, mut other, mut all] = [0; 3];
        for _ in 0..4000 {
            let center = random.direction() * random.between(0.0, 100.0);
            let drawn = random_drawn(&mut random, kind, center);
            let [h, o, a] = compare(&drawn, &mut random);
            (hidden, other, all) = (hidden + h, other + o, all + a);
        }
        println!("{kind}: {hidden} of {all} hidden, {other} otherwise");
        assert!(hidden * 5 > all && hidden * 20 < all * 19, "{hidden} of {all}");
        assert!(other * 1000 < all, "{other} of {all}");
    }

    #[test]
    fn triangles_hide_what_a_ray_says_they_do() {
        many(2);
    }

    #[test]
    fn rings_hide_what_a_ray_says_they_do() {
        many(1);
    }

    #[test]
    fn cones_hide_what_a_ray_says_they_do() {
        many(0);
    }

    #[test]
    fn what_is_not_free_stays_so() {
        let mut random = Random(5);
        let Drawn::Cone(cone) = random_drawn(&mut random, 0, DVec3::ZERO) else { unreachable!() };
        let at = |p: Vec3| p.to_array().map(|x| [x; LANES]);
        let mut free = [0; LANES];
        assert_eq!(behind_cone(&cone, Vec3::X, &at(Vec3::splat(1e3)), &mut free), 0);
        let stick = cylinder(DVec3::ZERO, DVec3::Y, 2.0, 0.5, [0, 0]).unwrap();
        // Through the open tube, and at its wall from within.
        let mut free = ALL;
        assert_eq!(behind_open_stick(&stick, Vec3::Y, &at(Vec3::NEG_Y * 3.0), &mut free), u32::MAX);
        assert_eq!(behind_open_stick(&stick, Vec3::X, &at(Vec3::ZERO), &mut free), 0);
    }

    /// A fan of thin triangles about a corner: light falls through none of the edges that two of them share.
    #[test]
    fn no_light_falls_between_two_triangles() {
        let center = DVec3::new(31.0, -57.0, 12.0);
        let corner = |i: u32| {
            let angle = std::f64::consts::TAU * f64::from(i) / 40.0;
            DVec3::new(angle.cos(), 0.1 * (7.0 * angle).sin(), angle.sin())
        };
        let fan: Vec<Triangle> =
            (0..40).map(|i| triangle(center, [DVec3::ZERO, corner(i), corner(i + 1)]).unwrap()).collect();
        let mut random = Random(12);
        for _ in 0..2000 {
            let d = (DVec3::Y + random.direction() * 0.4).normalize().as_vec3();
            // On an edge.
            let start = |_| {
                let p = center + corner(random.below(40)) * random.between(0.0, 0.95);
                p.as_vec3() - d * random.between(1.0, 50.0) as f32
            };
            let position = lanes(std::array::from_fn(start));
            let mut free = ALL;
            fan.iter().for_each(|triangle| _ = behind_triangle(triangle, d, &position, &mut free));
            assert_eq!(free, [0; LANES], "{d}");
            let ray = Ray { origin: Vec3::from_array(position.map(|axis| axis[0])), direction: d };
            assert!(fan.iter().any(|triangle| triangle_t(&ray, triangle, 0.0) < f32::INFINITY));
        }
    }
}
