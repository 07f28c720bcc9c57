//! What hides light from afar, as simple as can be: balls, and sticks that look like balls drawn out.
//!
//! Seen along a direction a ball is a disc, and a stick whose ends are round, or lie in balls, a stripe with round ends.
//! Where a line through the inside of a convex body meets the body, it meets one stretch of it. So a point outside of it is in
//! its shadow exactly if it is lower than some point of the line inside of the body, whichever that is: for a ball one
//! at the height of its centre, for a stick one at the height of its axis. Whether light reaches a point is then a
//! question of distances in the plane and of two heights, without a root or a division.
//!
//! Limits: it holds for points that lie outside of all these bodies, as visible ones do. What is neither of the two, or
//! see-through, is asked by itself ([`super::behind`]).

use super::lanes::{LANES, Lanes};
use crate::math::Aabb;
use crate::render::settings::View;
use crate::render::sky::across;
use crate::render::solids::{Cylinder, Primitive, Solids};
use crate::scene::Scene;
use glam::{Affine3A, Vec3};
use rayon::prelude::*;

/// Sixteen points along the axes of a direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Places {
    pub(super) x: Lanes,
    pub(super) y: Lanes,
    pub(super) height: Lanes,
}

/// A view, as directions of the world are seen in it.
pub(super) struct InView {
    pub(super) view_from_world: Affine3A,
    center: Vec3,
}

impl InView {
    pub(super) fn new(scene: &Scene, view: &View) -> InView {
        let view_from_world = view.camera.view_from_world();
        InView { view_from_world, center: view_from_world.transform_point3(scene.bounds().center()) }
    }

    /// The axes of a direction of the world, view space.
    pub(super) fn axes(&self, toward: Vec3) -> Axes {
        let [right, up] = across(toward);
        let [right, up, toward] = [right, up, toward].map(|v| self.view_from_world.transform_vector3(v));
        Axes { right, up, toward, center: self.center }
    }
}

/// The axes of a direction, and the point that all its coordinates are relative to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    pub(super) right: Vec3,
    pub(super) up: Vec3,
    pub(super) toward: Vec3,
    pub(super) center: Vec3,
}

impl Axes {
    /// Lowest and highest place along `right` and `up` of what is in a box.
    pub(super) fn extent(&self, bounds: &Aabb) -> [[f32; 2]; 2] {
        let (center, half) = (bounds.center() - self.center, bounds.size() * 0.5);
        let [x, y] = [self.right, self.up].map(|axis| (center.dot(axis), half.dot(axis.abs())));
        [[x.0 - x.1, y.0 - y.1], [x.0 + x.1, y.0 + y.1]]
    }

    /// Where points are along each.
    #[inline(always)]
    pub(super) fn places(&self, position: &[Lanes; 3]) -> Places {
        let (Axes { right, up, toward, center }, [xs, ys, zs]) = (self, position);
        let mut places = Places { x: [0.0; LANES], y: [0.0; LANES], height: [0.0; LANES] };
        for lane in 0..LANES {
            let (x, y, z) = (xs[lane] - center.x, ys[lane] - center.y, zs[lane] - center.z);
            places.x[lane] = x * right.x + y * right.y + z * right.z;
            places.y[lane] = x * up.x + y * up.y + z * up.z;
            places.height[lane] = x * toward.x + y * toward.y + z * toward.z;
        }
        places
    }

    /// The same in the space of a block. What lies where along the axes are the same numbers there.
    pub(super) fn moved(&self, block_from_view: &Affine3A) -> Axes {
        Axes {
            right: block_from_view.transform_vector3(self.right),
            up: block_from_view.transform_vector3(self.up),
            toward: block_from_view.transform_vector3(self.toward),
            center: block_from_view.transform_point3(self.center),
        }
    }
}

/// A primitive: 32 bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    pub(super) middle: Vec3,
    /// Negative for what is neither ball nor such a stick, or see-through.
    pub(super) radius: f32,
    /// From the middle to an end of the axis; zero for a ball.
    pub(super) half: Vec3,
    pub(super) index: u32,
}

impl Body {
    /// Of all primitives.
    pub(super) fn all(solids: &Solids) -> Vec<Body> {
        let other = |index: usize| (solids.box_of(index).center(), -1.0, Vec3::ZERO);
        let body = |index: usize| {
            let (middle, radius, half) = match solids.primitive(index) {
                _ if solids.see_through && solids.opacity(index) < u8::MAX => other(index),
                Primitive::Sphere(i) => (solids.spheres[i].center, solids.spheres[i].radius, Vec3::ZERO),
                Primitive::Cylinder(i) if is_capsule(&solids.cylinders[i]) => {
                    let stick = &solids.cylinders[i];
                    (stick.center, stick.radius, stick.axis() * stick.half_length)
                }
                _ => other(index),
            };
            Body { middle, radius, half, index: index as u32 }
        };
        (0..solids.len()).into_par_iter().with_min_len(4096).map(body).collect()
    }
}

/// Whether both ends of a stick are round or hidden.
fn is_capsule(stick: &Cylinder) -> bool {
    let [a, b] = stick.round();
    (a || stick.hidden & 1 != 0) && (b || stick.hidden & 2 != 0)
}
