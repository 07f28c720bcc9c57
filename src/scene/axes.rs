//! The directions of the axes as three arrows: **a**, **b**, **c** of a unit cell, else x, y, z of the file.
//!
//! They stand at the corner of the cell where one is drawn, else free: left of everything in the picture and in front, at the
//! height of its lowest part. Red, green and blue in this order, as everywhere.

use super::arrows::ArrowShape;
use super::{Block, cell_box};
use crate::math::{Aabb, direction_or};
use glam::Vec3;

/// Where the arrows are, in world space, for labels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    /// Where they begin.
    pub origin: Vec3,
    /// Where they end.
    pub tips: [Vec3; 3],
    /// What they are called: `x`, `y`, `z` or `a`, `b`, `c`.
    pub names: [&'static str; 3],
}

/// Length of an arrow as a part of the scene's diagonal, and its least in ångström (chosen: a glance finds them, and they take little
/// of the picture).
const LENGTH: (f32, f32) = (0.14, 0.8);
/// Room between the arrows and what they stand beside, in lengths of an arrow.
const GAP: f32 = 0.3;

/// Length of the arrows beside a scene of these bounds, ångström.
pub(super) fn length(bounds: Aabb) -> f32 {
    (LENGTH.0 * bounds.size().length()).max(LENGTH.1)
}

/// The free place for arrows in these directions: their rightmost and lowest and foremost points touch the left, lower and front
/// faces of the scene's bounds, but for a gap to the left.
pub(super) fn beside(bounds: Aabb, directions: [Vec3; 3]) -> Vec3 {
    let length = length(bounds);
    let reach = directions.iter().fold(Aabb { min: Vec3::ZERO, max: Vec3::ZERO }, |all, &direction| {
        all.union(Aabb::of_sphere(direction * length, 0.0))
    });
    // Heads are wider than their axes.
    let reach = reach.grown(HEAD_RADIUS * length);
    Vec3::new(bounds.min.x - GAP * length - reach.max.x, bounds.min.y - reach.min.y, bounds.max.z - reach.max.z)
}

/// Radius of a head and of a shaft, and length of a head, in lengths of an arrow; by eye.
const HEAD_RADIUS: f32 = 0.1;
const SHAFT_RADIUS: f32 = 0.04;
const HEAD_LENGTH: f32 = 0.3;

/// The three arrows, with ids from 1 to 3.
pub(super) fn block(origin: Vec3, directions: [Vec3; 3], length: f32) -> Block {
    let shape = ArrowShape {
        shaft_radius: SHAFT_RADIUS * length,
        head_radius: HEAD_RADIUS * length,
        head_length: HEAD_LENGTH * length,
    };
    let mut block = Block { id_count: 3, ..Block::default() };
    for ((id, direction), color) in (1..).zip(directions).zip(cell_box::AXES) {
        if let Some((stick, cone)) = shape.arrow(origin, 0.0, direction * length, color, id) {
            block.cylinders.push(stick);
            block.cones.push(cone);
        }
    }
    block
}

/// Unit vectors along these.
pub(super) fn directions(vectors: [Vec3; 3]) -> [Vec3; 3] {
    let [a, b, c] = vectors;
    [direction_or(a, Vec3::X), direction_or(b, Vec3::Y), direction_or(c, Vec3::Z)]
}
