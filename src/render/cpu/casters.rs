//! What may hide the light that comes along one direction, as it looks from there: lists of all primitives in tubes along it, for points that ask
//! sixteen at a time, wherever they lie ([`super::bodies`] says which question that is).
//!
//! Good for up to some ten thousand primitives, which stay in the caches for all directions; beyond that see [`super::rays`]. What is
//! neither ball nor stick, or see-through, is met only by its bounding disc here, and asked exactly where that is met.

use super::bodies::{Axes, Body, Places};
use super::lanes::{LANES, bits, low_of};
use crate::math::{max, min};
use crate::render::solids::Solids;
use crate::render::tubes::{Bound, Span, Tubes};
use glam::Vec3;

/// A primitive seen along the direction: 32 bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub(super) struct Caster {
    /// The higher end of its axis across the direction: along `right`, along `up`.
    x: f32,
    y: f32,
    /// Height of that end; nothing of the axis is higher. Of a bounding disc: the top of what it bounds.
    height: f32,
    /// Unit vector across the direction from there to the lower end.
    ux: f32,
    uy: f32,
    /// Distance of the ends across the direction; negative for a bounding disc.
    length: f32,
    /// Rise of the axis per ångström across, not above 0.
    slope: f32,
    radius_squared: f32,
}

/// All that may hide the light along one direction.
#[derive(Debug, Default)]
pub(super) struct Sight {
    pub(super) tubes: Tubes,
    casters: Vec<Caster>,
}

impl Caster {
    fn ball(center: [f32; 3], radius: f32) -> Caster {
        let [x, y, height] = center;
        Caster { x, y, height, ux: 1.0, uy: 0.0, length: 0.0, slope: 0.0, radius_squared: radius * radius }
    }

    fn stick(middle: [f32; 3], half: [f32; 3], radius: f32) -> Caster {
        // From the middle to the lower end.
        let half = if half[2] > 0.0 { half.map(|x| -x) } else { half };
        let across = (half[0] * half[0] + half[1] * half[1]).sqrt();
        let [x, y, height] = std::array::from_fn(|i| middle[i] - half[i]);
        if across < 1e-6 {
            return Caster::ball([x, y, height], radius);
        }
        let over = 1.0 / across;
        Caster {
            x,
            y,
            height,
            ux: half[0] * over,
            uy: half[1] * over,
            length: 2.0 * across,
            slope: half[2] * over,
            radius_squared: radius * radius,
        }
    }

    /// Of a primitive, and where it lies.
    #[inline(always)]
    fn of(body: &Body, solids: &Solids, axes: &Axes) -> (Caster, Span) {
        if body.radius < 0.0 {
            return Caster::disc(&Bound::of(solids, body.index as usize), axes);
        }
        let along = |v: Vec3| [axes.right, axes.up, axes.toward].map(|axis| v.x * axis.x + v.y * axis.y + v.z * axis.z);
        let middle = along(body.middle - axes.center);
        let caster = Caster::stick(middle, along(body.half), body.radius);
        let Caster { x, y, ux, uy, length, height, .. } = caster;
        let (x2, y2) = (x + ux * length, y + uy * length);
        let low = [min(x, x2) - body.radius, min(y, y2) - body.radius];
        let high = [max(x, x2) + body.radius, max(y, y2) + body.radius];
        (caster, Span { low, high, top: height })
    }

    /// The disc around what is neither ball nor stick.
    #[inline(never)]
    fn disc(bound: &Bound, axes: &Axes) -> (Caster, Span) {
        let span = bound.span(axes.center, [axes.right, axes.up, axes.toward]);
        let [x, y] = [0, 1].map(|axis| 0.5 * (span.low[axis] + span.high[axis]));
        let (a, b) = (span.high[0] - x, span.high[1] - y);
        let disc = Caster::ball([x, y, span.top], 1.0);
        (Caster { length: -1.0, radius_squared: 1.001 * (a * a + b * b), ..disc }, span)
    }
}

impl Sight {
    /// Of all primitives; `width` is that of the tubes.
    pub(super) fn new(bodies: &[Body], solids: &Solids, axes: &Axes, width: f32) -> Sight {
        let (casters, spans): (Vec<Caster>, Vec<Span>) = bodies.iter().map(|b| Caster::of(b, solids, axes)).unzip();
        let tubes = Tubes::of_spans(&spans, width, [axes.right, axes.up, axes.toward]);
        Sight { tubes, casters }
    }

    /// About how many bytes that many primitives take: a caster, and its number in some four tubes.
    pub(super) fn bytes(primitives: usize) -> usize {
        (size_of::<Caster>() + 4 * size_of::<u32>()) * primitives
    }

    /// Clears the bits of `free` whose light something in a tube stands in the way of. `exactly` does so for a primitive of
    /// which only the bounding disc is known here.
    #[inline(always)]
    pub(super) fn walk(&self, tube: u32, at: &Places, free: &mut u32, exactly: impl Fn(u32, &mut u32)) {
        let mut heights = [0.0f32; LANES];
        for (lane, height) in heights.iter_mut().enumerate() {
            *height = if *free >> lane & 1 != 0 { at.height[lane] } else { f32::INFINITY };
        }
        let low = low_of(&heights);
        for &index in self.tubes.of(tube as usize) {
            let caster = &self.casters[index as usize];
            // Where one does not reach up to the points, none of those after it does.
            if caster.height <= low {
                break;
            }
            if caster.length >= 0.0 {
                *free &= !caster.hides(at);
            } else if caster.is_near(at, *free) {
                exactly(index, free);
            }
            if *free == 0 {
                break;
            }
        }
    }
}

impl Caster {
    /// The lanes in its shadow.
    #[inline(always)]
    fn hides(&self, at: &Places) -> u32 {
        bits(|lane| {
            let (dx, dy) = (at.x[lane] - self.x, at.y[lane] - self.y);
            let along = dx * self.ux + dy * self.uy;
            let aside = dx * self.uy - dy * self.ux;
            let nearest = min(max(along, 0.0), self.length);
            let beyond = along - nearest;
            let axis = self.height + nearest * self.slope;
            (beyond * beyond + aside * aside < self.radius_squared) & (at.height[lane] < axis)
        })
    }

    /// Whether a free lane is in its bounding disc.
    #[inline(always)]
    fn is_near(&self, at: &Places, free: u32) -> bool {
        let near = bits(|lane| {
            let (dx, dy) = (at.x[lane] - self.x, at.y[lane] - self.y);
            dx * dx + dy * dy <= self.radius_squared
        });
        near & free != 0
    }
}
