//! Normals and colours of what the samples of a group see, one primitive after the other: neighbours mostly see the same few.

use super::behind::Mask;
use super::lanes::{LANES, Lanes};
use super::moved::Axes;
use super::shade::GROUP;
use super::source::Facts;
use crate::color::Srgb8;
use crate::math::{max, min};
use crate::render::outline::RIM;
use crate::render::solids::{Cylinder, Sphere, Torus};
use glam::{Affine3A, Vec3};

/// What shading needs of a primitive.
#[derive(Clone, Copy)]
pub(super) enum Fact {
    /// A ball: its centre and linear colour.
    Ball(Vec3, [f32; 3]),
    /// A stick.
    Stick(Stick),
    /// A ring.
    Ring(Ring),
    /// What is found one by one.
    Other,
}

/// What shading needs of a stick.
#[derive(Clone, Copy)]
pub(super) struct Stick {
    center: Vec3,
    /// Unit.
    axis: Vec3,
    radius: f32,
    /// Where flat caps are along the axis; infinite where there are none.
    caps: [f32; 2],
    /// Where the axis ends for the normal: at the ends of a round stick; infinite at others.
    ends: [f32; 2],
    /// Linear colour of the halves.
    colors: [[f32; 3]; 2],
}

/// What shading needs of a ring.
#[derive(Clone, Copy)]
pub(super) struct Ring {
    center: Vec3,
    /// Unit.
    axis: Vec3,
    /// Of the circle that the tube follows.
    radius: f32,
    /// Linear.
    color: [f32; 3],
}

impl Fact {
    /// Of a ring.
    #[inline(always)]
    pub(super) fn of_torus(torus: &Torus, color: Srgb8) -> Fact {
        let color = color.to_linear();
        Fact::Ring(Ring { center: torus.center, axis: torus.axis(), radius: torus.ring_radius, color })
    }

    /// Of a ball.
    #[inline(always)]
    pub(super) fn of_sphere(sphere: &Sphere, color: Srgb8) -> Fact {
        Fact::Ball(sphere.center, color.to_linear())
    }

    /// Of a stick with the colours of its halves.
    #[inline(always)]
    pub(super) fn of_cylinder(cylinder: &Cylinder, colors: [Srgb8; 2]) -> Fact {
        let h = cylinder.half_length;
        let end = |kind: u32| {
            let at = |cap: u32| if cap & 3 == kind { h } else { f32::INFINITY };
            [-at(cylinder.caps), at(cylinder.caps >> 2)]
        };
        Fact::Stick(Stick {
            center: cylinder.center,
            axis: cylinder.axis(),
            radius: cylinder.radius,
            caps: end(1),
            ends: end(2),
            colors: colors.map(Srgb8::to_linear),
        })
    }
}

/// Balls and sticks of a block, one a lane, and no two need be the same.
pub(super) struct Raw<'a> {
    view_from_block: &'a Affine3A,
    /// Which lanes hold one.
    pub(super) lanes: Mask,
    /// Ends of the axis in the block; the centre twice for a ball.
    pub(super) ends: [[Lanes; 3]; 2],
    pub(super) radius: Lanes,
    /// Colours of the halves: the bytes of an [`Srgb8`].
    pub(super) colors: [[u32; LANES]; 2],
    /// As [`Cylinder::caps`]; 0 for a ball.
    pub(super) caps: [u32; LANES],
}

impl<'a> Raw<'a> {
    /// None yet.
    #[inline(always)]
    pub(super) fn new(view_from_block: &'a Affine3A) -> Raw<'a> {
        let (zero, none) = ([0.0; LANES], [0; LANES]);
        Raw { view_from_block, lanes: none, ends: [[zero; 3]; 2], radius: zero, colors: [none; 2], caps: none }
    }
}

/// Facts that [`Memo`] keeps. Chosen: a row of a tile's groups shows fewer primitives at 10,000 atoms, and so do neighbouring rows.
const KEPT: usize = 256;

/// The facts that were asked last: neighbouring groups show the same primitives.
pub(super) struct Memo<'a> {
    source: &'a dyn Facts,
    /// By the lowest bits of the index: whose facts these are.
    of: [u32; KEPT],
    facts: [Fact; KEPT],
}

impl<'a> Memo<'a> {
    #[inline(always)]
    pub(super) fn new(source: &'a dyn Facts) -> Memo<'a> {
        Memo { source, of: [u32::MAX; KEPT], facts: [Fact::Other; KEPT] }
    }

    /// Whose facts they are.
    #[inline(always)]
    pub(super) fn source(&self) -> &'a dyn Facts {
        self.source
    }

    #[inline(always)]
    fn fact(&mut self, index: u32) -> &Fact {
        let at = index as usize % KEPT;
        if self.of[at] != index {
            (self.of[at], self.facts[at]) = (index, self.source.fact(index));
        }
        &self.facts[at]
    }
}

/// Of so many patches on the looks of balls and sticks are found for all lanes together, not one primitive after the other. Measured.
const MANY: u32 = 6;

/// In how many places of a group of 4 × 4 the primitive is another than to the left and above: about how many primitives it shows.
#[inline(always)]
fn patches(indices: &[u32; LANES]) -> u32 {
    let mut count = 0;
    for lane in 0..LANES {
        let is_left = lane % GROUP > 0 && indices[lane] == indices[lane.wrapping_sub(1) % LANES];
        let is_above = lane >= GROUP && indices[lane] == indices[lane.wrapping_sub(GROUP) % LANES];
        count += u32::from(!is_left & !is_above);
    }
    count
}

/// Of the samples of a group, what they see.
pub(super) struct Looks {
    /// Normals of any length.
    pub(super) normal: [Lanes; 3],
    /// Linear.
    pub(super) albedo: [Lanes; 3],
    /// Lanes that see something else.
    pub(super) others: Mask,
}

impl Looks {
    /// Of balls, sticks and rings where they are hit; zero for everything else.
    #[inline(always)]
    pub(super) fn of(memo: &mut Memo<'_>, indices: &[u32; LANES], seen: &Mask, hit: &[Lanes; 3]) -> Looks {
        let mut looks = Looks { normal: [[0.0; LANES]; 3], albedo: [[0.0; LANES]; 3], others: [0; LANES] };
        let (mut left, mut lane) = (*seen, 0);
        if patches(indices) >= MANY
            && let Some(raw) = memo.source.raw(indices, seen)
        {
            looks.add_raw(&raw, hit);
            for (left, known) in left.iter_mut().zip(&raw.lanes) {
                *left &= !known;
            }
        }
        while lane < LANES {
            if left[lane] == 0 {
                lane += 1;
                continue;
            }
            let index = indices[lane];
            let mut same = [0u32; LANES];
            for lane in 0..LANES {
                let is_same = if indices[lane] == index { u32::MAX } else { 0 };
                same[lane] = left[lane] & is_same;
                left[lane] &= !is_same;
            }
            match memo.fact(index & !RIM) {
                Fact::Ball(center, color) => looks.add_ball(&same, hit, *center, *color),
                Fact::Stick(stick) => looks.add_stick(&same, hit, stick),
                Fact::Ring(ring) => looks.add_ring(&same, hit, ring),
                Fact::Other => {
                    for (other, same) in looks.others.iter_mut().zip(same) {
                        *other |= same;
                    }
                }
            }
        }
        looks
    }

    /// What [`Looks::add_ball`] and [`Looks::add_stick`] do, for each lane something else.
    #[inline(always)]
    fn add_raw(&mut self, raw: &Raw<'_>, hit: &[Lanes; 3]) {
        let [a, b] = &raw.ends;
        let Axes { center, along: axis, half_length } = Axes::new(raw.view_from_block, [a.each_ref(), b.each_ref()]);
        let (mut normal, mut color) = ([[0.0; LANES]; 3], [0u32; LANES]);
        for lane in 0..LANES {
            let (h, [cap_a, cap_b]) = (half_length[lane], [raw.caps[lane] & 3, raw.caps[lane] >> 2 & 3]);
            let at = |is_there: bool| if is_there { h } else { f32::INFINITY };
            let (caps, ends) = ([-at(cap_a == 1), at(cap_b == 1)], [-at(cap_a == 2), at(cap_b == 2)]);
            let is_round = (cap_a == 2) | (cap_b == 2);
            let axis = [axis[0][lane], axis[1][lane], axis[2][lane]];
            let p = [hit[0][lane] - center[0][lane], hit[1][lane] - center[1][lane], hit[2][lane] - center[2][lane]];
            let along = p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2];
            let side = [p[0] - axis[0] * along, p[1] - axis[1] * along, p[2] - axis[2] * along];
            let out = (side[0] * side[0] + side[1] * side[1] + side[2] * side[2]).sqrt();
            let off_side = (raw.radius[lane] - out).abs();
            let (off_a, off_b) = ((along - caps[0]).abs(), (along - caps[1]).abs());
            let inner = min(max(along, ends[0]), ends[1]);
            let by_a = (off_a < off_side) & (off_a <= off_b);
            let by_b = (off_b < off_side) & !by_a;
            let cap = if by_a { -1.0 } else { 1.0 };
            color[lane] = if along > 0.0 { raw.colors[1][lane] } else { raw.colors[0][lane] };
            for part in 0..3 {
                let n = if is_round { p[part] - axis[part] * inner } else { side[part] };
                normal[part][lane] = if by_a | by_b { axis[part] * cap } else { n };
            }
        }
        let mut light = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let color: Srgb8 = bytemuck::cast(color[lane]);
            [light[0][lane], light[1][lane], light[2][lane]] = color.to_linear();
        }
        for part in 0..3 {
            for lane in 0..LANES {
                let (own, albedo) = (&mut self.normal[part][lane], &mut self.albedo[part][lane]);
                *own = if raw.lanes[lane] != 0 { normal[part][lane] } else { *own };
                *albedo = if raw.lanes[lane] != 0 { light[part][lane] } else { *albedo };
            }
        }
    }

    #[inline(always)]
    fn add_ball(&mut self, lanes: &Mask, hit: &[Lanes; 3], center: Vec3, color: [f32; 3]) {
        for part in 0..3 {
            for lane in 0..LANES {
                let (normal, albedo) = (&mut self.normal[part][lane], &mut self.albedo[part][lane]);
                *normal = if lanes[lane] != 0 { hit[part][lane] - center[part] } else { *normal };
                *albedo = if lanes[lane] != 0 { color[part] } else { *albedo };
            }
        }
    }

    #[inline(always)]
    fn add_stick(&mut self, lanes: &Mask, hit: &[Lanes; 3], stick: &Stick) {
        let Stick { center, axis, radius, caps, ends, colors } = stick;
        let is_round = ends[0] > f32::NEG_INFINITY || ends[1] < f32::INFINITY;
        for lane in 0..LANES {
            let p = Vec3::new(hit[0][lane], hit[1][lane], hit[2][lane]) - *center;
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
            let is_b = along > 0.0;
            for part in 0..3 {
                let n = if is_round { round[part] } else { side[part] };
                let n = if by_a | by_b { axis[part] * cap } else { n };
                let color = if is_b { colors[1][part] } else { colors[0][part] };
                let (normal, albedo) = (&mut self.normal[part][lane], &mut self.albedo[part][lane]);
                *normal = if lanes[lane] != 0 { n } else { *normal };
                *albedo = if lanes[lane] != 0 { color } else { *albedo };
            }
        }
    }

    #[inline(always)]
    fn add_ring(&mut self, lanes: &Mask, hit: &[Lanes; 3], ring: &Ring) {
        let Ring { center, axis, radius, color } = ring;
        for lane in 0..LANES {
            let p = Vec3::new(hit[0][lane], hit[1][lane], hit[2][lane]) - *center;
            let along = p.x * axis.x + p.y * axis.y + p.z * axis.z;
            let out = p - *axis * along;
            // From the nearest point of the circle.
            let to_circle = radius / max((out.x * out.x + out.y * out.y + out.z * out.z).sqrt(), 1e-20);
            let n = p - out * to_circle;
            for part in 0..3 {
                let (normal, albedo) = (&mut self.normal[part][lane], &mut self.albedo[part][lane]);
                *normal = if lanes[lane] != 0 { n[part] } else { *normal };
                *albedo = if lanes[lane] != 0 { color[part] } else { *albedo };
            }
        }
    }
}
