//! Balls and sticks of a block moved to view space, sixteen at a time: the same bits as one by one.

use super::lanes::{LANES, Lanes};
use glam::{Affine3A, Vec3};

/// Sixteen points moved by a transform: the same bits as [`Affine3A::transform_point3`] gives.
#[inline(always)]
pub(super) fn moved(by: &Affine3A, points: [&Lanes; 3]) -> [Lanes; 3] {
    let mut moved = turned(by, points);
    for (axis, moved) in moved.iter_mut().enumerate() {
        let shift = by.translation[axis];
        for moved in moved {
            *moved += shift;
        }
    }
    moved
}

/// Sixteen directions turned by a transform: the same bits as [`Affine3A::transform_vector3`] gives.
#[inline(always)]
fn turned(by: &Affine3A, directions: [&Lanes; 3]) -> [Lanes; 3] {
    let [x, y, z]: [Vec3; 3] = [by.matrix3.x_axis.into(), by.matrix3.y_axis.into(), by.matrix3.z_axis.into()];
    let mut turned = [[0.0; LANES]; 3];
    for (axis, turned) in turned.iter_mut().enumerate() {
        let (x, y, z) = (x[axis], y[axis], z[axis]);
        for lane in 0..LANES {
            turned[lane] = directions[0][lane] * x + directions[1][lane] * y + directions[2][lane] * z;
        }
    }
    turned
}

/// Sixteen sticks: the same bits as [`crate::render::solids::Cylinder::new`] gives.
pub(super) struct Axes {
    /// Middle of the axis.
    pub(super) center: [Lanes; 3],
    /// From end to end, of unit length; zero where there is no length.
    pub(super) along: [Lanes; 3],
    pub(super) half_length: Lanes,
}

impl Axes {
    /// Of the ends in the block.
    #[inline(always)]
    pub(super) fn new(view_from_block: &Affine3A, [a, b]: [[&Lanes; 3]; 2]) -> Axes {
        let (mut middle, mut between) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for axis in 0..3 {
            for lane in 0..LANES {
                middle[axis][lane] = (a[axis][lane] + b[axis][lane]) * 0.5;
                between[axis][lane] = b[axis][lane] - a[axis][lane];
            }
        }
        let mut axes = Axes {
            center: moved(view_from_block, middle.each_ref()),
            along: turned(view_from_block, between.each_ref()),
            half_length: [0.0; LANES],
        };
        let [x, y, z] = &mut axes.along;
        for lane in 0..LANES {
            let length = (x[lane] * x[lane] + y[lane] * y[lane] + z[lane] * z[lane]).sqrt();
            let is_long = length > 1e-12;
            x[lane] = if is_long { x[lane] / length } else { 0.0 };
            y[lane] = if is_long { y[lane] / length } else { 0.0 };
            z[lane] = if is_long { z[lane] / length } else { 0.0 };
            axes.half_length[lane] = if is_long { length * 0.5 } else { 0.0 };
        }
        axes
    }
}
