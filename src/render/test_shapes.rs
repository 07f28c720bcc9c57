//! What the tests of the primitives share: f64 solids with an intersection of their own, and random ones of them.
//!
//! The intersection works in view space without a rotation: it lists every crossing of a ray with the side, the cap
//! planes and the end balls, drops those that are not on the surface, and takes the first.

use super::solids::{Cylinder, Sphere};
use crate::color::Srgb8;
use crate::scene::{Camera, CylinderInstance, Projection, Ray};
use glam::{Affine3A, DVec2, DVec3, Quat, Vec3};

pub(in crate::render) const OPEN: u32 = 0;
pub(in crate::render) const FLAT: u32 = 1;
pub(in crate::render) const ROUND: u32 = 2;

/// A camera that looks at the origin from 100 Å away.
pub(in crate::render) fn camera(world_from_view: Quat, projection: Projection) -> Camera {
    Camera {
        eye: world_from_view * Vec3::new(0.0, 0.0, 100.0),
        world_from_view,
        projection,
        near: 0.1,
        far: 300.0,
        target: Vec3::ZERO,
        shift: [0.0; 2],
    }
}

/// One that looks down by 0.2 rad, after a turn about the vertical.
pub(in crate::render) fn camera_around(turn_rad: f32) -> Camera {
    let world_from_view = Quat::from_rotation_y(turn_rad) * Quat::from_rotation_x(-0.2);
    camera(world_from_view, Projection::Perspective { fov_y_rad: 0.5 })
}

/// SplitMix64: the same numbers everywhere.
pub(in crate::render) struct Random(pub(super) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in `low..high`.
    pub(in crate::render) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in the logarithm.
    pub(in crate::render) fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// One of `0..count`.
    pub(in crate::render) fn below(&mut self, count: u32) -> u32 {
        (self.next() % u64::from(count)) as u32
    }

    /// A unit vector, uniform on the sphere.
    pub(in crate::render) fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let angle = self.between(0.0, std::f64::consts::TAU);
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * angle.cos(), across * angle.sin(), z)
    }

    /// A point in view space at this distance from the eye, at most `angle` off the view axis.
    pub(in crate::render) fn in_view(&mut self, distance: f64, angle: f64) -> DVec3 {
        let off = self.between(0.0, angle);
        let around = self.between(0.0, std::f64::consts::TAU);
        DVec3::new(off.sin() * around.cos(), off.sin() * around.sin(), -off.cos()) * distance
    }
}

/// Which part of a surface a hit is on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::render) enum Part {
    Side,
    Disc,
    Ball,
    Near,
}

/// A solid, or the surface of an open cylinder; a sphere has no axis.
#[derive(Debug, Clone, Copy)]
pub(in crate::render) struct Shape {
    pub(in crate::render) center: DVec3,
    pub(in crate::render) axis: Option<DVec3>,
    pub(in crate::render) half: f64,
    pub(in crate::render) radius: f64,
    pub(in crate::render) caps: [u32; 2],
}

pub(in crate::render) fn at(ray: &Ray, t: f64) -> DVec3 {
    ray.origin.as_dvec3() + ray.direction.as_dvec3() * t
}

impl Shape {
    pub(in crate::render) fn sphere(sphere: &Sphere) -> Shape {
        let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
        Shape { center, axis: None, half: 0.0, radius, caps: [ROUND; 2] }
    }

    pub(in crate::render) fn cylinder(cylinder: &Cylinder) -> Shape {
        Shape {
            center: cylinder.center.as_dvec3(),
            axis: Some(cylinder.axis().as_dvec3().normalize()),
            half: f64::from(cylinder.half_length),
            radius: f64::from(cylinder.radius),
            caps: [cylinder.caps & 3, cylinder.caps >> 2 & 3],
        }
    }

    pub(in crate::render) fn is_open(&self) -> bool {
        self.caps.contains(&OPEN)
    }

    /// The shape itself, then the eight that differ by ± `margin` in radius and length.
    pub(in crate::render) fn variants(self, margin: f64) -> impl Iterator<Item = Shape> {
        (0..9).map(move |i| {
            let by = |step: i32| [0.0, -margin, margin][step as usize];
            Shape { radius: self.radius + by(i % 3), half: (self.half + by(i / 3)).max(0.0), ..self }
        })
    }

    /// Distance along the axis from the centre, and the vector across.
    fn split(&self, p: DVec3) -> (f64, DVec3) {
        let p = p - self.center;
        self.axis.map_or((0.0, p), |axis| (axis.dot(p), p - axis * axis.dot(p)))
    }

    pub(in crate::render) fn contains(&self, p: DVec3) -> bool {
        let (y, across) = self.split(p);
        let beyond = y.abs() - self.half;
        if beyond <= 0.0 {
            return across.length() <= self.radius;
        }
        self.caps[usize::from(y > 0.0)] == ROUND && across.length_squared() + beyond * beyond <= self.radius.powi(2)
    }

    /// The first crossing with `t ≥ near`, its part, and the outward normal there.
    pub(in crate::render) fn first_hit(&self, ray: &Ray, near: f64) -> Option<(f64, Part, DVec3)> {
        let d = ray.direction.as_dvec3();
        if !self.is_open() && self.contains(at(ray, near)) {
            return Some((near, Part::Near, -d.normalize()));
        }
        // From the point nearest the centre, as f64 has no digits to waste either.
        let t0 = (self.center - ray.origin.as_dvec3()).dot(d) / d.length_squared();
        let p0 = at(ray, t0);
        let mut best: Option<(f64, Part, DVec3)> = None;
        let mut offer = |t: f64, part: Part, normal: DVec3| {
            if t0 + t >= near && best.is_none_or(|(least, ..)| t0 + t < least) {
                best = Some((t0 + t, part, normal.normalize_or(-d.normalize())));
            }
        };
        let quadratic = |p: DVec3, e: DVec3| {
            let (a, b, c) = (e.length_squared(), p.dot(e), p.length_squared() - self.radius * self.radius);
            let root = (b * b - a * c).sqrt();
            [(-b - root) / a, (-b + root) / a].into_iter().filter(|t| t.is_finite())
        };
        if let Some(axis) = self.axis {
            let (_, across) = self.split(p0);
            for t in quadratic(across, d - axis * axis.dot(d)) {
                let (y, normal) = self.split(p0 + d * t);
                if y.abs() <= self.half {
                    offer(t, Part::Side, normal);
                }
            }
        }
        for (cap, sign) in self.caps.into_iter().zip([-1.0, 1.0]) {
            let outward = self.axis.unwrap_or(DVec3::ZERO) * sign;
            let end = self.center + outward * self.half;
            if cap == ROUND {
                for t in quadratic(p0 - end, d) {
                    if (p0 + d * t - end).dot(outward) >= 0.0 {
                        offer(t, Part::Ball, p0 + d * t - end);
                    }
                }
            } else if cap == FLAT {
                let t = (end - p0).dot(outward) / d.dot(outward);
                if t.is_finite() && self.split(p0 + d * t).1.length() <= self.radius {
                    offer(t, Part::Disc, outward);
                }
            }
        }
        best
    }

    /// A point of the solid: on its surface, or anywhere in it.
    pub(in crate::render) fn point(&self, random: &mut Random, on_surface: bool) -> DVec3 {
        let Some(axis) = self.axis else {
            let depth = if on_surface { 1.0 } else { random.between(0.0, 1.0) };
            return self.center + random.direction() * self.radius * depth;
        };
        let x = axis.any_orthonormal_vector();
        let angle = random.between(0.0, std::f64::consts::TAU);
        let around = x * angle.cos() + axis.cross(x) * angle.sin();
        match random.below(4) {
            // A rim: where the bounds touch.
            0 if on_surface => {
                let sign = if random.below(2) == 0 { -1.0 } else { 1.0 };
                self.center + axis * self.half * sign + around * self.radius
            }
            end @ (1 | 2) if self.caps[end as usize - 1] == ROUND => {
                let sign = if end == 1 { -1.0 } else { 1.0 };
                let out = random.direction();
                let out = if out.dot(axis) * sign < 0.0 { -out } else { out };
                let depth = if on_surface { 1.0 } else { random.between(0.0, 1.0) };
                self.center + axis * self.half * sign + out * self.radius * depth
            }
            _ => {
                let depth = if on_surface { 1.0 } else { random.between(0.0, 1.0) };
                self.center + axis * random.between(-self.half, self.half) + around * self.radius * depth
            }
        }
    }

    /// A ray at or close by the shape, half of them within a few per cent of its silhouette.
    pub(in crate::render) fn ray(&self, random: &mut Random, orthographic: bool) -> Ray {
        let axis = self.axis.unwrap_or_else(|| random.direction());
        let along = random.between(-1.15, 1.15) * self.half;
        let target = self.center + axis * along;
        let sight = if orthographic { DVec3::NEG_Z } else { target.normalize_or(DVec3::NEG_Z) };
        let p = match random.below(4) {
            0 => target + random.direction() * self.radius * random.between(0.0, 1.4),
            1 => {
                let end = self.center + axis * self.half * if random.below(2) == 0 { -1.0 } else { 1.0 };
                let across = random.direction().cross(sight).normalize_or_zero();
                end + across * self.radius * random.between(0.9, 1.1)
            }
            _ => {
                let across = sight.cross(axis).normalize_or(random.direction().cross(sight).normalize_or_zero());
                let sign = if random.below(2) == 0 { -1.0 } else { 1.0 };
                target + across * sign * self.radius * random.between(0.95, 1.05)
            }
        };
        ray_to(p, orthographic)
    }
}

/// The view ray through a point in view space.
pub(in crate::render) fn ray_to(p: DVec3, orthographic: bool) -> Ray {
    let point = p.as_vec3();
    if orthographic {
        Ray { origin: Vec3::new(point.x, point.y, 0.0), direction: Vec3::NEG_Z }
    } else {
        let slope: DVec2 = p.truncate() / -p.z;
        Ray { origin: Vec3::ZERO, direction: slope.as_vec2().extend(-1.0) }
    }
}

/// A cylinder about a centre, as a scene would hold it.
pub(in crate::render) fn cylinder(
    center: DVec3,
    axis: DVec3,
    length: f64,
    radius: f64,
    caps: [u32; 2],
) -> Option<Cylinder> {
    let half = axis * (length * 0.5);
    // The block is centred, so that short sticks far away keep their axis.
    let instance = CylinderInstance {
        a: (-half).as_vec3().to_array(),
        radius: radius as f32,
        b: half.as_vec3().to_array(),
        id: 1,
        color_a: Srgb8::WHITE,
        color_b: Srgb8::WHITE,
        caps: caps[0] | caps[1] << 2,
        hidden: 0,
    };
    Cylinder::new(&instance, &Affine3A::from_translation(center.as_vec3()))
}
