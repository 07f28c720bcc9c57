//! What the tests of cones, tori and triangles share: f64 shapes with intersections of their own, and random ones of them.
//!
//! As in [`super::test_shapes`] the intersections work in view space without a rotation. The torus' is the quartic, its roots
//! found between those of its derivatives.

use super::solids::{Cone, Torus, Triangle};
use super::test_shapes::{Random, at};
use crate::color::Srgb8;
use crate::scene::{ConeInstance, Ray, TorusInstance, TriangleInstance};
use glam::{Affine3A, DVec3, Vec3};

/// A hit: depth, which part of the surface, the normal on the side of the ray.
pub(in crate::render) type Hit = (f64, u32, DVec3);

/// A solid, or a triangle.
#[derive(Debug, Clone, Copy)]
pub(in crate::render) enum Body {
    Cone { center: DVec3, axis: DVec3, half: f64, radii: [f64; 2] },
    Torus { center: DVec3, axis: DVec3, ring: f64, tube: f64 },
    Triangle { center: DVec3, corners: [DVec3; 3] },
}

impl Body {
    pub(in crate::render) fn cone(cone: &Cone) -> Body {
        let (center, axis) = (cone.center.as_dvec3(), cone.axis().as_dvec3().normalize());
        Body::Cone { center, axis, half: f64::from(cone.half_length), radii: cone.radii.map(f64::from) }
    }

    pub(in crate::render) fn torus(torus: &Torus) -> Body {
        let (center, axis) = (torus.center.as_dvec3(), torus.axis().as_dvec3().normalize());
        Body::Torus { center, axis, ring: f64::from(torus.ring_radius), tube: f64::from(torus.tube_radius) }
    }

    pub(in crate::render) fn triangle(triangle: &Triangle) -> Body {
        Body::Triangle { center: triangle.center.as_dvec3(), corners: triangle.corners.map(Vec3::as_dvec3) }
    }

    pub(in crate::render) fn center(&self) -> DVec3 {
        let (Body::Cone { center, .. } | Body::Torus { center, .. } | Body::Triangle { center, .. }) = self;
        *center
    }

    /// What a hundredth of is a fair error: the radius of a cone or tube, the extent of a triangle.
    pub(in crate::render) fn width(&self) -> f64 {
        match self {
            Body::Cone { radii, .. } => radii[0].max(radii[1]),
            Body::Torus { tube, .. } => *tube,
            Body::Triangle { corners, .. } => corners.iter().map(|c| c.length()).fold(0.0, f64::max),
        }
    }

    /// Nothing of it is farther from its centre.
    pub(in crate::render) fn reach(&self) -> f64 {
        match self {
            Body::Cone { half, radii, .. } => half + radii[0].max(radii[1]),
            Body::Torus { ring, tube, .. } => ring + tube,
            Body::Triangle { .. } => self.width(),
        }
    }

    /// The body itself, and those that are smaller and larger by `margin`.
    pub(in crate::render) fn variants(self, margin: f64) -> Vec<Body> {
        let mut all = Vec::new();
        for by in [0.0, -margin, margin] {
            match self {
                Body::Cone { center, axis, half, radii } => {
                    for longer in [0.0, -margin, margin] {
                        let half = (half + longer).max(0.0);
                        all.push(Body::Cone { center, axis, half, radii: radii.map(|r| (r + by).max(0.0)) });
                    }
                }
                Body::Torus { center, axis, ring, tube } => {
                    all.push(Body::Torus { center, axis, ring, tube: (tube + by).max(0.0) });
                }
                Body::Triangle { center, corners } => {
                    // Every edge moved out by so much, or in: about the centre of the inscribed circle.
                    let [a, b, c] = corners;
                    let edges = [b.distance(c), c.distance(a), a.distance(b)];
                    let around: f64 = edges.iter().sum();
                    let middle = (a * edges[0] + b * edges[1] + c * edges[2]) / around;
                    let radius = (b - a).cross(c - a).length() / around;
                    let scale = ((radius + by) / radius).max(0.0);
                    all.push(Body::Triangle { center, corners: corners.map(|p| middle + (p - middle) * scale) });
                }
            }
        }
        all
    }

    pub(in crate::render) fn contains(&self, p: DVec3) -> bool {
        let q = p - self.center();
        match self {
            Body::Cone { axis, half, radii, .. } => {
                let y = q.dot(*axis);
                let radius = radii[0] + (radii[1] - radii[0]) * (y + half) / (2.0 * half);
                y.abs() <= *half && (q - *axis * y).length() <= radius
            }
            Body::Torus { axis, ring, tube, .. } => {
                let y = q.dot(*axis);
                ((q - *axis * y).length() - ring).hypot(y) <= *tube
            }
            Body::Triangle { .. } => false,
        }
    }

    /// The first crossing with `t ≥ near`.
    pub(in crate::render) fn first_hit(&self, ray: &Ray, near: f64) -> Option<Hit> {
        let d = ray.direction.as_dvec3();
        if self.contains(at(ray, near)) {
            return Some((near, 9, -d.normalize()));
        }
        let t0 = (self.center() - ray.origin.as_dvec3()).dot(d) / d.length_squared();
        let q = at(ray, t0) - self.center();
        let crossings = match self {
            Body::Cone { axis, half, radii, .. } => cone_crossings(q, d, *axis, *half, *radii),
            Body::Torus { axis, ring, tube, .. } => torus_crossings(q, d, *axis, *ring, *tube),
            Body::Triangle { corners, .. } => triangle_crossings(q, d, *corners),
        };
        let seen = crossings.into_iter().map(|(t, part, n)| (t0 + t, part, n)).filter(|(t, ..)| *t >= near);
        let first = seen.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let normal = first.2.normalize_or(-d.normalize());
        Some((first.0, first.1, if normal.dot(d) > 0.0 { -normal } else { normal }))
    }

    /// A point of the surface, or of the inside.
    pub(in crate::render) fn point(&self, random: &mut Random) -> DVec3 {
        let angle = random.between(0.0, std::f64::consts::TAU);
        let around = |axis: &DVec3, angle: f64| {
            let x = axis.any_orthonormal_vector();
            x * angle.cos() + axis.cross(x) * angle.sin()
        };
        match self {
            Body::Cone { center, axis, half, radii } => {
                let part = [0.0, 1.0, random.between(0.0, 1.0)][random.below(3) as usize];
                let radius = radii[0] + (radii[1] - radii[0]) * part;
                *center + *axis * *half * (2.0 * part - 1.0) + around(axis, angle) * radius
            }
            Body::Torus { center, axis, ring, tube } => {
                let out = around(axis, angle);
                let turn = random.between(0.0, std::f64::consts::TAU);
                *center + out * (ring + tube * turn.cos()) + *axis * (tube * turn.sin())
            }
            Body::Triangle { center, corners } => {
                let (mut u, mut v) = (random.between(0.0, 1.0), random.between(0.0, 1.0));
                if random.below(3) == 0 {
                    v = 0.0;
                }
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                *center + corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v
            }
        }
    }
}

fn cone_crossings(q: DVec3, d: DVec3, axis: DVec3, half: f64, radii: [f64; 2]) -> Vec<Hit> {
    let mut found = Vec::new();
    let (qy, dy) = (q.dot(axis), d.dot(axis));
    let (qa, da) = (q - axis * qy, d - axis * dy);
    let slope = (radii[1] - radii[0]) / (2.0 * half);
    let (rho, sigma) = (0.5 * (radii[0] + radii[1]) + slope * qy, slope * dy);
    let (a, b, c) = (da.length_squared() - sigma * sigma, qa.dot(da) - sigma * rho, qa.length_squared() - rho * rho);
    let root = (b * b - a * c).sqrt();
    for t in [(-b - root) / a, (-b + root) / a, -c / (2.0 * b)] {
        let (y, across) = (qy + dy * t, qa + da * t);
        let on_it = (across.length() - (rho + sigma * t)).abs() < 1e-6 * (radii[0] + radii[1]);
        if t.is_finite() && y.abs() <= half && on_it {
            found.push((t, 0, across.normalize_or_zero() - axis * slope));
        }
    }
    for (sign, radius, part) in [(-1.0, radii[0], 1), (1.0, radii[1], 2)] {
        let t = (sign * half - qy) / dy;
        if t.is_finite() && (qa + da * t).length() <= radius {
            found.push((t, part, axis * sign));
        }
    }
    found
}

fn torus_crossings(q: DVec3, d: DVec3, axis: DVec3, ring: f64, tube: f64) -> Vec<Hit> {
    let size = d.length();
    let u = d / size;
    let (b, c, m, n) = (q.dot(u), q.length_squared(), q.dot(axis), u.dot(axis));
    let k = c + ring * ring - tube * tube;
    let r4 = 4.0 * ring * ring;
    let quartic = [
        k * k - r4 * (c - m * m),
        4.0 * b * k - r4 * (2.0 * b - 2.0 * m * n),
        4.0 * b * b + 2.0 * k - r4 * (1.0 - n * n),
        4.0 * b,
        1.0,
    ];
    let reach = 1.1 * (ring + tube) + q.length();
    let hit = |s: f64| {
        let p = q + u * s;
        let across = p - axis * p.dot(axis);
        (s / size, 0, p - across.normalize_or_zero() * ring)
    };
    roots(&quartic, -reach, reach).into_iter().map(hit).collect()
}

/// The roots of a polynomial (constant first) in an interval, by bisection between those of its derivative.
fn roots(polynomial: &[f64], low: f64, high: f64) -> Vec<f64> {
    if polynomial.len() < 2 {
        return Vec::new();
    }
    let value = |x: f64| polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let derivative: Vec<f64> = (1..polynomial.len()).map(|i| polynomial[i] * i as f64).collect();
    let mut ends = vec![low];
    ends.extend(roots(&derivative, low, high));
    ends.push(high);
    let mut found = Vec::new();
    for pair in ends.windows(2) {
        let (mut a, mut b) = (pair[0], pair[1]);
        if (value(a) > 0.0) == (value(b) > 0.0) {
            continue;
        }
        let rises = value(b) > 0.0;
        for _ in 0..100 {
            let middle = 0.5 * (a + b);
            if (value(middle) > 0.0) == rises { b = middle } else { a = middle }
        }
        found.push(0.5 * (a + b));
    }
    found
}

fn triangle_crossings(q: DVec3, d: DVec3, [a, b, c]: [DVec3; 3]) -> Vec<Hit> {
    let n = (b - a).cross(c - a);
    let t = (a - q).dot(n) / d.dot(n);
    let p = q + d * t;
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (*to - *from).cross(p - *from).dot(n) >= 0.0);
    if t.is_finite() && inside { vec![(t, 0, n)] } else { Vec::new() }
}

/// A cone about a centre, as a scene would hold it.
pub(in crate::render) fn cone(center: DVec3, axis: DVec3, length: f64, radii: [f64; 2]) -> Option<Cone> {
    let half = axis * (length * 0.5);
    let instance = ConeInstance {
        a: (-half).as_vec3().to_array(),
        radius_a: radii[0] as f32,
        b: half.as_vec3().to_array(),
        radius_b: radii[1] as f32,
        color: Srgb8::WHITE,
        id: 1,
        reserved: [0; 2],
    };
    Cone::new(&instance, &Affine3A::from_translation(center.as_vec3()))
}

/// The same for a torus.
pub(in crate::render) fn torus(center: DVec3, axis: DVec3, ring: f64, tube: f64) -> Option<Torus> {
    let instance = TorusInstance {
        center: [0.0; 3],
        ring_radius: ring as f32,
        axis: axis.as_vec3().to_array(),
        tube_radius: tube as f32,
        color: Srgb8::WHITE,
        id: 1,
        reserved: [0; 2],
    };
    Torus::new(&instance, &Affine3A::from_translation(center.as_vec3()))
}

/// And for a triangle, without normals.
pub(in crate::render) fn triangle(center: DVec3, corners: [DVec3; 3]) -> Option<Triangle> {
    let instance = TriangleInstance {
        corners: corners.map(|corner| corner.as_vec3().to_array()),
        normals: [[0.0; 3]; 3],
        colors: [Srgb8::WHITE; 3],
        id: 1,
        reserved: [0; 2],
    };
    Triangle::new(&instance, &Affine3A::from_translation(center.as_vec3()))
}

/// Any of the three, as the renderer holds it.
#[derive(Debug, Clone, Copy)]
pub(in crate::render) enum Drawn {
    Cone(Cone),
    Torus(Torus),
    Triangle(Triangle),
}

impl Drawn {
    pub(in crate::render) fn body(&self) -> Body {
        match self {
            Drawn::Cone(cone) => Body::cone(cone),
            Drawn::Torus(torus) => Body::torus(torus),
            Drawn::Triangle(triangle) => Body::triangle(triangle),
        }
    }
}

/// A cone (one in three pointed), a torus or a triangle, as large as what molecules are drawn with.
pub(in crate::render) fn random_drawn(random: &mut Random, kind: u32, center: DVec3) -> Drawn {
    let axis = match random.below(6) {
        0 => center.normalize_or(DVec3::Z),
        1 => [DVec3::X, DVec3::NEG_Y, DVec3::Z][random.below(3) as usize],
        _ => random.direction(),
    };
    match kind {
        0 => {
            let radius = random.log_between(0.05, 2.0);
            let other = [0.0, random.between(0.0, radius), random.log_between(0.05, 2.0)][random.below(3) as usize];
            let radii = if random.below(2) == 0 { [radius, other] } else { [other, radius] };
            Drawn::Cone(cone(center, axis, random.log_between(0.1, 5.0), radii).unwrap())
        }
        1 => {
            let ring = random.log_between(0.3, 3.0);
            Drawn::Torus(torus(center, axis, ring, ring * random.log_between(0.05, 0.6)).unwrap())
        }
        _ => {
            let size = random.log_between(0.1, 3.0);
            loop {
                let corners = [0; 3].map(|_| random.direction() * size);
                let [a, b, c] = corners;
                // Slivers have tests of their own.
                if (b - a).cross(c - a).length() > 0.15 * size * size {
                    return Drawn::Triangle(triangle(center, corners).unwrap());
                }
            }
        }
    }
}
