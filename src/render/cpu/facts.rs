//! Normals and colours of what the samples of a group see, one primitive after the other: neighbours mostly see the same few.

use super::behind::Mask;
use super::lanes::{LANES, Lanes};
use super::looks::{BallSurface, RingSurface, StickSurface, Surface};
use super::source::Facts;
use crate::color::{Srgb8, linear_levels};
use crate::render::outline::RIM;
use crate::render::solids::{Cylinder, Sphere, Torus};

/// What shading needs of a primitive.
#[derive(Clone, Copy)]
pub(super) enum Fact {
    /// A ball and its linear colour.
    Ball(BallSurface, [f32; 3]),
    /// A stick and the linear colours of its halves.
    Stick(StickSurface, [[f32; 3]; 2]),
    /// A ring and its linear colour.
    Ring(RingSurface, [f32; 3]),
    /// What is found one by one.
    Other,
}

impl Fact {
    /// Of a ring.
    #[inline(always)]
    pub(super) fn of_torus(torus: &Torus, color: Srgb8) -> Fact {
        Fact::Ring(RingSurface::new(torus), color.to_linear())
    }

    /// Of a ball.
    #[inline(always)]
    pub(super) fn of_sphere(sphere: &Sphere, color: Srgb8) -> Fact {
        Fact::Ball(BallSurface { center: sphere.center }, color.to_linear())
    }

    /// Of a stick with the colours of its halves.
    #[inline(always)]
    pub(super) fn of_cylinder(cylinder: &Cylinder, colors: [Srgb8; 2]) -> Fact {
        Fact::Stick(StickSurface::new(cylinder), colors.map(Srgb8::to_linear))
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
                Fact::Ball(ball, color) => looks.add(&same, hit, ball, &[*color; 2]),
                Fact::Stick(stick, colors) => looks.add(&same, hit, stick, colors),
                Fact::Ring(ring, color) => looks.add(&same, hit, ring, &[*color; 2]),
                Fact::Other => {
                    for (other, same) in looks.others.iter_mut().zip(same) {
                        *other |= same;
                    }
                }
            }
        }
        looks
    }

    /// Of samples that were told what they see when they were drawn ([`super::tile::Tile::normal`]).
    #[inline(always)]
    pub(super) fn told(normal: [&Lanes; 3], colors: &[u32; LANES], seen: &Mask) -> Looks {
        let (mut albedo, mut others) = ([[0.0; LANES]; 3], [0; LANES]);
        let linear = linear_levels();
        for lane in 0..LANES {
            others[lane] = if colors[lane] == 0 { seen[lane] } else { 0 };
            for part in 0..3 {
                albedo[part][lane] = linear[(colors[lane] >> (8 * part) & 0xFF) as usize];
            }
        }
        Looks { normal: normal.map(|part| *part), albedo, others }
    }

    #[inline(always)]
    fn add(&mut self, lanes: &Mask, hit: &[Lanes; 3], surface: &impl Surface, colors: &[[f32; 3]; 2]) {
        let (normal, second) = surface.at(hit);
        for part in 0..3 {
            for lane in 0..LANES {
                let color = if second[lane] != 0 { colors[1][part] } else { colors[0][part] };
                let (own, albedo) = (&mut self.normal[part][lane], &mut self.albedo[part][lane]);
                *own = if lanes[lane] != 0 { normal[part][lane] } else { *own };
                *albedo = if lanes[lane] != 0 { color } else { *albedo };
            }
        }
    }
}
