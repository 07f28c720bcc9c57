//! What a hit shows of a ball, stick or ring: its normal, and which of its two colours.
//!
//! The normal comes from the hit's place, not from solving again, so that it is off by the rounding of the depth: 1e-4 of a stick's radius
//! at 100 Å, less than a colour can show.

use super::behind::Mask;
use super::intersect::FLAT_CAPS;
use super::lanes::{LANES, Lanes};
use crate::math::{max, min};
use crate::render::solids::{Cylinder, Torus};
use glam::Vec3;

/// A surface whose normals are known from places on it.
pub(super) trait Surface {
    /// Normals of any length at sixteen places, and at which of them it has its second colour.
    fn at(&self, hit: &[Lanes; 3]) -> ([Lanes; 3], Mask);
}

/// A ball.
#[derive(Clone, Copy)]
pub(super) struct BallSurface {
    pub(super) center: Vec3,
}

impl Surface for BallSurface {
    #[inline(always)]
    fn at(&self, hit: &[Lanes; 3]) -> ([Lanes; 3], Mask) {
        let mut normal = [[0.0; LANES]; 3];
        for part in 0..3 {
            for lane in 0..LANES {
                normal[part][lane] = hit[part][lane] - self.center[part];
            }
        }
        (normal, [0; LANES])
    }
}

/// A stick. It has its second colour in the half that its axis points to.
#[derive(Clone, Copy)]
pub(super) struct StickSurface {
    pub(super) center: Vec3,
    /// Unit.
    pub(super) axis: Vec3,
    pub(super) radius: f32,
    /// Where flat caps are along the axis; infinite where there are none.
    pub(super) caps: [f32; 2],
    /// Where the axis ends for the normal: at the ends of a round stick; infinite at others.
    pub(super) ends: [f32; 2],
}

impl StickSurface {
    /// Of a stick.
    #[inline(always)]
    pub(super) fn new(cylinder: &Cylinder) -> StickSurface {
        let h = cylinder.half_length;
        let end = |kind: u32| {
            let at = |cap: u32| if cap & 3 == kind { h } else { f32::INFINITY };
            [-at(cylinder.caps), at(cylinder.caps >> 2)]
        };
        let (caps, ends) = if cylinder.caps == FLAT_CAPS { ([-h, h], NO_ENDS) } else { (end(1), end(2)) };
        StickSurface { center: cylinder.center, axis: cylinder.axis(), radius: cylinder.radius, caps, ends }
    }

    /// The normal at one place, and whether it has its second colour there.
    #[inline(always)]
    pub(super) fn at_one(&self, hit: Vec3) -> (Vec3, bool) {
        let StickSurface { center, axis, radius, caps, ends } = self;
        let is_round = ends[0] > f32::NEG_INFINITY || ends[1] < f32::INFINITY;
        let p = hit - *center;
        let along = p.x * axis.x + p.y * axis.y + p.z * axis.z;
        let side = p - *axis * along;
        let out = (side.x * side.x + side.y * side.y + side.z * side.z).sqrt();
        // The side or a cap, whichever is nearer to the hit.
        let off_side = (radius - out).abs();
        let (off_a, off_b) = ((along - caps[0]).abs(), (along - caps[1]).abs());
        let round = p - *axis * min(max(along, ends[0]), ends[1]);
        let by_a = (off_a < off_side) & (off_a <= off_b);
        let by_b = (off_b < off_side) & !by_a;
        let cap = if by_a { -1.0 } else { 1.0 };
        let pick = |side: f32, round: f32, axis: f32| {
            let n = if is_round { round } else { side };
            if by_a | by_b { axis * cap } else { n }
        };
        (
            Vec3::new(pick(side.x, round.x, axis.x), pick(side.y, round.y, axis.y), pick(side.z, round.z, axis.z)),
            along > 0.0,
        )
    }
}

/// [`StickSurface::ends`] of a stick that is not round.
pub(super) const NO_ENDS: [f32; 2] = [f32::NEG_INFINITY, f32::INFINITY];

impl Surface for StickSurface {
    #[inline(always)]
    fn at(&self, hit: &[Lanes; 3]) -> ([Lanes; 3], Mask) {
        let (mut normal, mut second) = ([[0.0; LANES]; 3], [0; LANES]);
        for lane in 0..LANES {
            let (n, is_second) = self.at_one(Vec3::new(hit[0][lane], hit[1][lane], hit[2][lane]));
            (normal[0][lane], normal[1][lane], normal[2][lane]) = (n.x, n.y, n.z);
            second[lane] = if is_second { u32::MAX } else { 0 };
        }
        (normal, second)
    }
}

/// A ring.
#[derive(Clone, Copy)]
pub(super) struct RingSurface {
    center: Vec3,
    /// Unit.
    axis: Vec3,
    /// Of the circle that the tube follows.
    radius: f32,
}

impl RingSurface {
    /// Of a ring.
    #[inline(always)]
    pub(super) fn new(torus: &Torus) -> RingSurface {
        RingSurface { center: torus.center, axis: torus.axis(), radius: torus.ring_radius }
    }
}

impl Surface for RingSurface {
    #[inline(always)]
    fn at(&self, hit: &[Lanes; 3]) -> ([Lanes; 3], Mask) {
        let RingSurface { center, axis, radius } = self;
        let mut normal = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let p = Vec3::new(hit[0][lane], hit[1][lane], hit[2][lane]) - *center;
            let along = p.x * axis.x + p.y * axis.y + p.z * axis.z;
            let out = p - *axis * along;
            // From the nearest point of the circle.
            let to_circle = radius / max((out.x * out.x + out.y * out.y + out.z * out.z).sqrt(), 1e-20);
            let n = p - out * to_circle;
            (normal[0][lane], normal[1][lane], normal[2][lane]) = (n.x, n.y, n.z);
        }
        (normal, [0; LANES])
    }
}
