//! Primitives as triangles: meshes of unit size, as fine as an error in ångström asks for.
//!
//! Method: a chord lies inside its arc. All vertices stand so far outside the true surface that the middles of the triangles are as far inside: no
//! point is farther from it than the error, and half as many triangles do as with vertices on the surface. The numbers of segments follow from
//! error and radius:
//!
//! - A polygon of n sides around a circle of radius r, its corners at 2r / (1 + cos(π/n)), is nowhere farther from it than r·tan²(π/2n).
//! - A ball is an icosahedron whose faces are divided into n² triangles, pushed out onto a sphere; how far its triangles are from the
//!   middle is found from the triangles themselves.
//! - What is bent in two directions has a part of the error for each: rings, whose vertices stand outside for both, somewhat less than a half; round ends of sticks,
//!   whose rim is that of the stick and stands outside for one, a third, as chords in two directions are as far inside as two of them.
//! - Rings and truncated cones are no stretched copies of one another. The ratio of their radii is rounded to steps of a quarter of the
//!   error, so that few meshes serve many of them.

use glam::{Quat, Vec3};
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

/// Least segments around: below that a stick shows its edges whatever the error (chosen).
const LEAST_AROUND: u16 = 6;
/// Most segments around, and edges of a ball's faces: errors of 1e-4 Å at 10 Å (chosen; `--tolerance` goes no lower).
const MOST_AROUND: u16 = 720;
const MOST_FREQUENCY: u16 = 180;

/// The part of the error that each direction of a round end has: a third, less what the squares of small numbers add.
const DOME_SHARE: f32 = 0.32;

/// A mesh of unit size by what it is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Shape {
    /// A ball of radius 1: how many parts an edge of the icosahedron has.
    Ball(u16),
    /// Half a ball of radius 1, y ≥ 0, open below: segments around.
    Dome(u16),
    /// A cylinder of radius 1 about +Y from 0 to 1: segments around, and whether there is a disc at 0 and at 1.
    Tube(u16, [bool; 2]),
    /// A cone about +Y, radius 1 at 0 and this many 65535ths of it at 1, closed: segments around.
    Cone(u16, u16),
    /// A torus about +Y of ring radius 1: segments along the ring and around its tube, the tube's radius in 65535ths.
    Ring(u16, u16, u16),
}

/// Triangles with a normal at every vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct UnitMesh {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Makes every mesh once.
#[derive(Default)]
pub(super) struct Meshes {
    made: HashMap<Shape, UnitMesh>,
}

impl Meshes {
    pub(super) fn of(&mut self, shape: Shape) -> &UnitMesh {
        self.made.entry(shape).or_insert_with(|| shape.mesh())
    }
}

/// Chooses shapes for an error in ångström.
pub(super) struct Tessellation {
    tolerance: f32,
    /// For every number of parts of an edge from 1 on, by how much of its radius the ball is wrong.
    balls: Vec<f32>,
}

impl Tessellation {
    pub(super) fn new(tolerance: f32) -> Tessellation {
        Tessellation { tolerance: if tolerance > 0.0 { tolerance } else { f32::MIN_POSITIVE }, balls: Vec::new() }
    }

    pub(super) fn ball(&mut self, radius: f32) -> Shape {
        let wanted = self.tolerance / radius;
        let mut parts = self.balls.partition_point(|&error| error > wanted);
        while parts == self.balls.len() && parts < usize::from(MOST_FREQUENCY) {
            let error = ball_error(nearest(parts as u16 + 1));
            self.balls.push(error);
            parts += usize::from(error > wanted);
        }
        Shape::Ball((parts as u16 + 1).min(MOST_FREQUENCY))
    }

    /// Segments around a circle.
    fn around(&self, radius: f32, share: f32) -> u16 {
        let tangent = (share * self.tolerance / radius).sqrt();
        let count = (0.5 * PI / tangent.atan()).ceil();
        // `as` is 0 for what is no number.
        (count as u16).clamp(LEAST_AROUND, MOST_AROUND)
    }

    pub(super) fn tube(&self, radius: f32, caps: [bool; 2], is_round: bool) -> Shape {
        Shape::Tube(self.around(radius, if is_round { DOME_SHARE } else { 1.0 }), caps)
    }

    /// The round end of a tube with as many segments.
    pub(super) fn dome(&self, radius: f32) -> Shape {
        Shape::Dome(self.around(radius, DOME_SHARE))
    }

    /// `narrow` is at most `wide`.
    pub(super) fn cone(&self, wide: f32, narrow: f32) -> Shape {
        Shape::Cone(self.around(wide, 0.75), self.ratio(narrow / wide, wide))
    }

    pub(super) fn ring(&self, ring_radius: f32, tube_radius: f32) -> Shape {
        let ratio = self.ratio(tube_radius / ring_radius, ring_radius).max(1);
        Shape::Ring(self.around(ring_radius + tube_radius, 0.375), self.around(tube_radius, 0.375), ratio)
    }

    /// A part of a radius in 65535ths, in steps that are no more than half of the error.
    fn ratio(&self, part: f32, radius: f32) -> u16 {
        let step = (0.5 * self.tolerance / radius * 65535.0).clamp(1.0, 8192.0).log2().floor().exp2();
        ((part * 65535.0 / step).round() * step).min(65535.0) as u16
    }
}

impl Shape {
    /// Numbers of vertices and triangles, without making them.
    pub(super) fn counts(self) -> [u64; 2] {
        match self {
            Shape::Ball(parts) => {
                let n = u64::from(parts);
                [10 * n * n + 2, 20 * n * n]
            }
            Shape::Dome(around) => {
                let (n, rows) = (u64::from(around), u64::from(rows(around)));
                [n * rows + 1, n * (2 * rows - 1)]
            }
            Shape::Tube(around, caps) => {
                let (n, caps) = (u64::from(around), caps.iter().filter(|&&cap| cap).count() as u64);
                [2 * n + caps * n, 2 * n + caps * (n - 2)]
            }
            Shape::Cone(around, ratio) => {
                let n = u64::from(around);
                if ratio == 0 { [3 * n, n + n - 2] } else { [4 * n, 2 * n + 2 * (n - 2)] }
            }
            Shape::Ring(along, around, _) => {
                let (along, around) = (u64::from(along), u64::from(around));
                [along * around, 2 * along * around]
            }
        }
    }

    fn mesh(self) -> UnitMesh {
        match self {
            Shape::Ball(parts) => ball_mesh(parts),
            Shape::Dome(around) => dome(around),
            Shape::Tube(around, caps) => tube(around, caps),
            Shape::Cone(around, ratio) => cone(around, f32::from(ratio) / 65535.0),
            Shape::Ring(along, around, ratio) => ring(along, around, f32::from(ratio) / 65535.0),
        }
    }
}

/// How far outside corners of a polygon of so many sides stand.
fn outside(sides: u16) -> f32 {
    2.0 / (1.0 + (PI / f32::from(sides)).cos())
}

/// Directions of the corners, about +Y from +X towards −Z: seen from +Y they go around to the left.
fn circle(sides: u16) -> impl Iterator<Item = Vec3> + Clone {
    (0..sides).map(move |side| {
        let (sin, cos) = (TAU * f32::from(side) / f32::from(sides)).sin_cos();
        Vec3::new(cos, 0.0, -sin)
    })
}

/// From the distance of the nearest triangle from the middle, the vertices at 1: the error once the two are balanced, in radii.
fn ball_error(nearest: f32) -> f32 {
    (1.0 - nearest) / (1.0 + nearest)
}

fn ball_mesh(parts: u16) -> UnitMesh {
    let mut mesh = ball(parts);
    let outside = 1.0 + ball_error(nearest(parts));
    for position in &mut mesh.positions {
        *position *= outside;
    }
    mesh
}

/// The corners of an icosahedron at a distance of 1: those of three rectangles.
fn corners() -> [Vec3; 12] {
    let golden = 0.5 * (1.0 + 5.0f32.sqrt());
    [
        [-1.0, golden, 0.0],
        [1.0, golden, 0.0],
        [-1.0, -golden, 0.0],
        [1.0, -golden, 0.0],
        [0.0, -1.0, golden],
        [0.0, 1.0, golden],
        [0.0, -1.0, -golden],
        [0.0, 1.0, -golden],
        [golden, 0.0, -1.0],
        [golden, 0.0, 1.0],
        [-golden, 0.0, -1.0],
        [-golden, 0.0, 1.0],
    ]
    .map(|corner| Vec3::from(corner).normalize())
}

/// How near the triangles of a ball with its vertices at 1 come to its middle: those of one face, as all are alike.
fn nearest(parts: u16) -> f32 {
    let corners = corners();
    let n = parts.max(1);
    let point = |i: u16, j: u16| {
        let [a, b, c] = [n - i - j, i, j].map(f32::from);
        (corners[0] * a + corners[11] * b + corners[5] * c).normalize()
    };
    let mut nearest = 1.0f32;
    for i in 0..n {
        for j in 0..n - i {
            let [a, b, c] = [point(i, j), point(i + 1, j), point(i, j + 1)];
            nearest = nearest.min((b - a).cross(c - a).normalize_or_zero().dot(a).abs());
            if i + j + 1 < n {
                let d = point(i + 1, j + 1);
                nearest = nearest.min((d - b).cross(c - b).normalize_or_zero().dot(b).abs());
            }
        }
    }
    nearest
}

/// A ball with its vertices at 1.
fn ball(parts: u16) -> UnitMesh {
    let corners = corners();
    // The faces, their corners from outside to the left.
    const FACES: [[usize; 3]; 20] = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let n = parts.max(1);
    let mut mesh = UnitMesh::default();
    // Points of edges and corners belong to several faces: found by the corners that they are made of, with their weights.
    let mut shared: HashMap<[(usize, u16); 2], u32> = HashMap::new();
    for face in FACES {
        let mut rows: Vec<Vec<u32>> = Vec::with_capacity(usize::from(n) + 1);
        for i in 0..=n {
            let mut row = Vec::with_capacity(usize::from(n - i) + 1);
            for j in 0..=n - i {
                let weights = [(face[0], n - i - j), (face[1], i), (face[2], j)];
                let mut used: Vec<(usize, u16)> = weights.into_iter().filter(|(_, weight)| *weight > 0).collect();
                used.sort_unstable();
                let mut push = || {
                    // In a fixed order, so that neighbours agree to the last bit.
                    let sum: Vec3 = used.iter().map(|&(corner, weight)| corners[corner] * f32::from(weight)).sum();
                    mesh.positions.push(sum.normalize());
                    mesh.positions.len() as u32 - 1
                };
                row.push(match used[..] {
                    [one] => *shared.entry([one, one]).or_insert_with(push),
                    [one, other] => *shared.entry([one, other]).or_insert_with(push),
                    _ => push(),
                });
            }
            rows.push(row);
        }
        for pair in rows.windows(2) {
            for (j, &next) in pair[1].iter().enumerate() {
                mesh.triangles.push([pair[0][j], next, pair[0][j + 1]]);
                if let Some(&after) = pair[1].get(j + 1) {
                    mesh.triangles.push([next, after, pair[0][j + 1]]);
                }
            }
        }
    }
    mesh.normals.clone_from(&mesh.positions);
    mesh
}

/// Rows of triangles of half a ball with so many segments around.
fn rows(around: u16) -> u16 {
    around.div_ceil(4)
}

fn dome(around: u16) -> UnitMesh {
    let rows = rows(around);
    let mut mesh = UnitMesh::default();
    // The rim is that of a tube. Upwards a quarter has `rows` chords.
    let wide = outside(around);
    let high = outside(4 * rows);
    for row in 0..rows {
        let (sin, cos) = (0.5 * PI * f32::from(row) / f32::from(rows)).sin_cos();
        // At the rim no higher, so that there is no gap.
        for direction in circle(around) {
            let normal = direction * cos + Vec3::Y * sin;
            mesh.positions.push(direction * (cos * wide) + Vec3::Y * (sin * high));
            mesh.normals.push(normal);
        }
    }
    mesh.positions.push(Vec3::Y * high);
    mesh.normals.push(Vec3::Y);
    let (n, top) = (u32::from(around), u32::from(around) * u32::from(rows));
    for row in 0..u32::from(rows) - 1 {
        push_band(&mut mesh.triangles, row * n, (row + 1) * n, n);
    }
    for side in 0..n {
        mesh.triangles.push([top - n + side, top - n + (side + 1) % n, top]);
    }
    mesh
}

/// Triangles between a ring of vertices and the one above it.
fn push_band(triangles: &mut Vec<[u32; 3]>, low: u32, high: u32, n: u32) {
    for side in 0..n {
        let next = (side + 1) % n;
        triangles.push([low + side, low + next, high + next]);
        triangles.push([low + side, high + next, high + side]);
    }
}

/// A disc that faces up or down.
fn push_disc(mesh: &mut UnitMesh, around: u16, radius: f32, y: f32, faces_up: bool) {
    let first = mesh.positions.len() as u32;
    let normal = if faces_up { Vec3::Y } else { Vec3::NEG_Y };
    for direction in circle(around) {
        mesh.positions.push(direction * radius + Vec3::Y * y);
        mesh.normals.push(normal);
    }
    for side in 1..u32::from(around) - 1 {
        let [b, c] = if faces_up { [side, side + 1] } else { [side + 1, side] };
        mesh.triangles.push([first, first + b, first + c]);
    }
}

fn tube(around: u16, caps: [bool; 2]) -> UnitMesh {
    let mut mesh = UnitMesh::default();
    let radius = outside(around);
    for y in [0.0, 1.0] {
        for direction in circle(around) {
            mesh.positions.push(direction * radius + Vec3::Y * y);
            mesh.normals.push(direction);
        }
    }
    let n = u32::from(around);
    push_band(&mut mesh.triangles, 0, n, n);
    if caps[0] {
        push_disc(&mut mesh, around, radius, 0.0, false);
    }
    if caps[1] {
        push_disc(&mut mesh, around, radius, 1.0, true);
    }
    mesh
}

/// Stretched along y and x, z by different numbers its normals stay right, as they are divided by them.
fn cone(around: u16, narrow: f32) -> UnitMesh {
    let mut mesh = UnitMesh::default();
    let wide = outside(around);
    let slope = |direction: Vec3| (direction + Vec3::Y * (1.0 - narrow)).normalize();
    let n = u32::from(around);
    for direction in circle(around) {
        mesh.positions.push(direction * wide);
        mesh.normals.push(slope(direction));
    }
    for direction in circle(around) {
        mesh.positions.push(direction * (wide * narrow) + Vec3::Y);
        // A tip has a vertex for each side, with the normal of its middle.
        let turned = Quat::from_rotation_y(PI / f32::from(around)) * direction;
        mesh.normals.push(slope(if narrow > 0.0 { direction } else { turned }));
    }
    if narrow > 0.0 {
        push_band(&mut mesh.triangles, 0, n, n);
        push_disc(&mut mesh, around, wide * narrow, 1.0, true);
    } else {
        mesh.triangles.extend((0..n).map(|side| [side, (side + 1) % n, n + side]));
    }
    push_disc(&mut mesh, around, wide, 0.0, false);
    mesh
}

fn ring(along: u16, around: u16, tube: f32) -> UnitMesh {
    let mut mesh = UnitMesh::default();
    let (far, thick) = (outside(along), tube * outside(around));
    for direction in circle(along) {
        for side in 0..around {
            let (sin, cos) = (TAU * f32::from(side) / f32::from(around)).sin_cos();
            mesh.positions.push(direction * (far * (1.0 + thick * cos)) + Vec3::Y * (thick * sin));
            mesh.normals.push(direction * cos + Vec3::Y * sin);
        }
    }
    let (along, around) = (u32::from(along), u32::from(around));
    for step in 0..along {
        let (here, there) = (step * around, (step + 1) % along * around);
        for side in 0..around {
            let next = (side + 1) % around;
            mesh.triangles.push([here + side, there + side, there + next]);
            mesh.triangles.push([here + side, there + next, here + next]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(tolerance: f32) -> Vec<(Shape, f32)> {
        let mut tessellation = Tessellation::new(tolerance);
        vec![
            (tessellation.ball(1.0), 1.0),
            (tessellation.dome(1.0), 1.0),
            (tessellation.tube(1.0, [true, false], false), 1.0),
            (tessellation.tube(1.0, [true, true], true), 1.0),
            (tessellation.cone(1.0, 0.0), 1.0),
            (tessellation.cone(1.0, 0.5), 1.0),
            (tessellation.ring(1.0, 0.25), 1.0),
        ]
    }

    /// How far a point is from the true surface (without discs).
    fn distance(shape: Shape, p: Vec3) -> f32 {
        let across = p.x.hypot(p.z);
        match shape {
            Shape::Ball(_) | Shape::Dome(_) => (p.length() - 1.0).abs(),
            Shape::Tube(..) => (across - 1.0).abs(),
            Shape::Cone(_, ratio) => {
                let narrow = f32::from(ratio) / 65535.0;
                (across - (1.0 - p.y * (1.0 - narrow))).abs()
            }
            Shape::Ring(_, _, ratio) => ((across - 1.0).hypot(p.y) - f32::from(ratio) / 65535.0).abs(),
        }
    }

    #[test]
    fn no_point_is_farther_from_the_surface_than_the_error() {
        for tolerance in [0.1, 0.02, 0.002] {
            for (shape, _) in all(tolerance) {
                let mesh = shape.mesh();
                let mut worst = 0.0f32;
                for triangle in &mesh.triangles {
                    let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
                    let normal = (b - a).cross(c - a);
                    let mean: Vec3 = triangle.iter().map(|&vertex| mesh.normals[vertex as usize]).sum();
                    assert!(normal.dot(mean) > 0.0, "{shape:?}: a triangle faces inwards");
                    let is_disc = triangle.iter().all(|&vertex| mesh.normals[vertex as usize].y.abs() == 1.0);
                    if is_disc && !matches!(shape, Shape::Ring(..)) {
                        continue;
                    }
                    for (u, v) in [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (1.0 / 3.0, 1.0 / 3.0)] {
                        worst = worst.max(distance(shape, a + (b - a) * u + (c - a) * v));
                    }
                }
                assert!(worst <= tolerance * 1.001 + 1e-6, "{shape:?}: {worst} for {tolerance}");
                // Not much finer than asked for either, unless the least segments are.
                let is_least = mesh.triangles.len() < 200;
                assert!(is_least || worst > 0.2 * tolerance, "{shape:?}: {worst} for {tolerance}");
            }
        }
    }

    #[test]
    fn counts_are_those_of_the_meshes() {
        for tolerance in [0.3, 0.01] {
            for (shape, _) in all(tolerance) {
                let mesh = shape.mesh();
                let counts = [mesh.positions.len() as u64, mesh.triangles.len() as u64];
                assert_eq!(shape.counts(), counts, "{shape:?}");
                assert_eq!(mesh.normals.len(), mesh.positions.len());
                assert!(mesh.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5), "{shape:?}");
            }
        }
    }

    #[test]
    fn closed_shapes_have_every_edge_twice_and_the_volume_of_the_true_ones() {
        let mut tessellation = Tessellation::new(0.002);
        let full = PI;
        for (shape, volume) in [
            (tessellation.ball(1.0), 4.0 / 3.0 * PI),
            (tessellation.tube(1.0, [true; 2], false), full),
            (tessellation.cone(1.0, 0.0), full / 3.0),
            (tessellation.cone(1.0, 0.5), full * 1.75 / 3.0),
            (tessellation.ring(1.0, 0.25), 2.0 * PI * PI * 0.0625),
        ] {
            let mesh = shape.mesh();
            let key = |vertex: u32| (mesh.positions[vertex as usize] + 0.0).to_array().map(f32::to_bits);
            let mut edges: HashMap<_, i32> = HashMap::new();
            let mut found = 0.0;
            for &[a, b, c] in &mesh.triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *edges.entry((key(from), key(to))).or_default() += 1;
                    *edges.entry((key(to), key(from))).or_default() -= 1;
                }
                let [a, b, c] = [a, b, c].map(|vertex| mesh.positions[vertex as usize]);
                found += a.dot(b.cross(c)) / 6.0;
            }
            assert!(edges.values().all(|&sum| sum == 0), "{shape:?} is not closed");
            assert!((found / volume - 1.0).abs() < 0.01, "{shape:?}: {found} for {volume}");
        }
    }

    #[test]
    fn rings_that_differ_by_less_than_the_error_share_a_mesh() {
        let tessellation = Tessellation::new(0.01);
        let shapes: std::collections::HashSet<Shape> =
            (0..100).map(|step| tessellation.ring(1.1 + step as f32 * 2e-4, 0.06)).collect();
        assert!(shapes.len() <= 3, "{shapes:?}");
    }

    #[test]
    fn errors_that_make_no_sense_end() {
        for tolerance in [f32::NAN, 0.0, -1.0, 1e30] {
            for (shape, _) in all(tolerance) {
                assert!(shape.counts()[1] > 0, "{shape:?}");
            }
        }
    }
}
