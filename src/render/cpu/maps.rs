//! Depth maps of the scene from the directions of the sky and of the key light: the product's way to ask which of them
//! a surface point sees.
//!
//! A map is seen along parallel rays from infinity. Its texel holds how far the scene reaches towards the light,
//! in 65,534 steps over the scene's depth. A point is compared with the four texels around it where the tangent plane at it
//! passes through their centres: a convex solid lies behind its tangent planes, so it never shadows itself, at any
//! angle, and no bias has to be guessed. The four answers are interpolated, which takes two thirds off the squared error of
//! asking the nearest.
//!
//! Limits: edges of shadows are as fine as a texel ([`Maps::new`] says how large it is).

use super::lanes::{LANES, Lanes, Pass, max, min, whole};
use super::simd::{Work, pairs, widest};
use crate::render::sky::{Turns, across};
use crate::render::solids::{Cylinder, Solids, Sphere};
use crate::scene::Scene;
use glam::{Affine3A, Mat3A, Vec3};
use rayon::prelude::*;

/// Texels of all maps together (2 bytes each). Chosen: 64 MiB.
const MAX_TEXELS: f32 = 32.0 * 1024.0 * 1024.0;
/// No texel is finer, in ångström: a tenth of a stick's radius.
const MIN_TEXEL: f32 = 0.013;
/// Steps of height; 0 is kept for texels where nothing is seen.
const STEPS: f32 = 65_534.0;
/// A point is lifted by so many steps, for rounding.
const LIFT: f32 = 2.0;
/// Along the tangent plane a point rises by no more than so many texels from one texel to the next.
const STEEPEST: f32 = 50.0;

/// One direction's map.
#[derive(Debug, Clone)]
struct Map {
    /// Unit vectors along its rows and columns, and towards the light.
    right: Vec3,
    up: Vec3,
    toward: Vec3,
    /// The scene's centre in texels.
    center: [f32; 2],
    size: [u32; 2],
    /// Where its texels start.
    first: usize,
}

/// Maps of one scene.
#[derive(Debug, Clone, Default)]
pub(super) struct Maps {
    maps: Vec<Map>,
    texels: Vec<u16>,
    scale: Scale,
}

/// From ångström to texels and steps.
#[derive(Debug, Clone, Copy, Default)]
struct Scale {
    texels_per_angstrom: f32,
    steps_per_angstrom: f32,
    /// Height of the scene's centre in steps.
    center: f32,
}

impl Scale {
    fn steps_per_texel(self) -> f32 {
        self.steps_per_angstrom / self.texels_per_angstrom
    }
}

/// Points that are asked together, in the space of the [`Asked`], relative to the scene's centre.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Points {
    pub(super) position: [Lanes; 3],
    /// Unit normals.
    pub(super) normal: [Lanes; 3],
}

/// What the lanes of a pass ask, one direction each.
#[derive(Debug, Clone)]
pub(super) struct Asked {
    right: [Lanes; 3],
    up: [Lanes; 3],
    toward: [Lanes; 3],
    center: [Lanes; 2],
    /// Last column and row that has a neighbour.
    last: [Lanes; 2],
    width: [u32; LANES],
    first: [u32; LANES],
}

impl Maps {
    /// Maps of the scene from unit directions. A texel is as large as memory asks for, but at least
    /// [`MIN_TEXEL`]; of points relative to the centre of [`Scene::bounds`].
    pub(super) fn new(scene: &Scene, directions: &[Vec3]) -> Maps {
        let bounds = scene.bounds();
        if bounds.is_empty() || directions.is_empty() {
            return Maps::default();
        }
        let half = bounds.size() * 0.5;
        let extents: Vec<[f32; 3]> = directions
            .iter()
            .map(|&d| {
                let [right, up] = across(d);
                [right, up, d].map(|axis| axis.abs().dot(half))
            })
            .collect();
        let area: f32 = extents.iter().map(|[x, y, _]| 4.0 * x * y).sum();
        let texel = (area / MAX_TEXELS).sqrt().max(MIN_TEXEL);
        let radius = half.length().max(1e-3);
        let steps = STEPS / (2.0 * radius);
        let scale = Scale { texels_per_angstrom: 1.0 / texel, steps_per_angstrom: steps, center: 1.0 + radius * steps };
        let mut first = 0;
        let maps: Vec<Map> = (directions.iter().zip(extents))
            .map(|(&toward, [x, y, _])| {
                let [right, up] = across(toward);
                // A texel of free border on each side.
                let size = [x, y].map(|extent| (2.0 * extent / texel).ceil() as u32 + 2);
                let map = Map { right, up, toward, center: size.map(|side| side as f32 * 0.5), size, first };
                first += size[0] as usize * size[1] as usize;
                map
            })
            .collect();
        let mut texels = vec![0u16; first];
        let solids = Solids::new(scene, Affine3A::from_translation(-bounds.center()));
        let mut parts = Vec::with_capacity(maps.len());
        let mut rest = texels.as_mut_slice();
        for map in &maps {
            let (part, after) = rest.split_at_mut(map.size[0] as usize * map.size[1] as usize);
            parts.push((map, part));
            rest = after;
        }
        parts.into_par_iter().with_max_len(1).for_each(|(map, texels)| {
            widest(DrawMap { map, texels, solids: &solids, scale });
        });
        Maps { maps, texels, scale }
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.maps.is_empty()
    }

    /// The questions of a pass: one for each direction that a sample asks, seen from a space that `space_from_world` turns to.
    pub(super) fn asked(&self, turns: &Turns, pass: &Pass, space_from_world: Mat3A) -> Vec<Asked> {
        if self.is_empty() {
            return Vec::new();
        }
        let question = |j: u32| {
            let map = |lane: usize| &self.maps[(turns.start(pass.sample[lane]) + j) as usize];
            let axis = |of: fn(&Map) -> Vec3| -> [Lanes; 3] {
                let turned: [Vec3; LANES] = std::array::from_fn(|lane| space_from_world * of(map(lane)));
                std::array::from_fn(|part| turned.map(|axis| axis[part]))
            };
            let each = |of: &dyn Fn(&Map) -> f32| -> Lanes { std::array::from_fn(|lane| of(map(lane))) };
            Asked {
                right: axis(|map| map.right),
                up: axis(|map| map.up),
                toward: axis(|map| map.toward),
                center: [each(&|map| map.center[0]), each(&|map| map.center[1])],
                last: [each(&|map| (map.size[0] - 2) as f32), each(&|map| (map.size[1] - 2) as f32)],
                width: std::array::from_fn(|lane| map(lane).size[0]),
                first: std::array::from_fn(|lane| map(lane).first as u32),
            }
        };
        (0..turns.each).map(question).collect()
    }

    /// Which part of the directions asked the points see: weighted by the cosine to the normal, or (`!WEIGHTED`) each that is
    /// above the surface the same. `unasked` where all are behind the surface or none is asked.
    #[inline(always)]
    pub(super) fn part<const WEIGHTED: bool>(&self, asked: &[Asked], points: &Points, unasked: f32) -> Lanes {
        let (mut seen, mut all) = ([0.0f32; LANES], [0.0f32; LANES]);
        for question in asked {
            self.ask::<WEIGHTED>(question, points, &mut seen, &mut all);
        }
        let mut part = [unasked; LANES];
        for lane in 0..LANES {
            part[lane] = if all[lane] > 0.0 { seen[lane] / all[lane] } else { unasked };
        }
        part
    }

    #[inline(always)]
    fn ask<const WEIGHTED: bool>(&self, asked: &Asked, points: &Points, seen: &mut Lanes, all: &mut Lanes) {
        let [px, py, pz] = &points.position;
        let [nx, ny, nz] = &points.normal;
        let Scale { texels_per_angstrom, steps_per_angstrom, center } = self.scale;
        let steps_per_texel = self.scale.steps_per_texel();
        let mut index = [0u32; LANES];
        let (mut weight, mut level) = ([0.0f32; LANES], [0.0f32; LANES]);
        let (mut part_x, mut part_y) = ([0.0f32; LANES], [0.0f32; LANES]);
        let (mut slope_x, mut slope_y) = ([0.0f32; LANES], [0.0f32; LANES]);
        for lane in 0..LANES {
            let dot = |v: &[Lanes; 3], x: f32, y: f32, z: f32| v[0][lane] * x + v[1][lane] * y + v[2][lane] * z;
            let cosine = dot(&asked.toward, nx[lane], ny[lane], nz[lane]);
            weight[lane] = max(cosine, 0.0);
            all[lane] += if WEIGHTED { weight[lane] } else { 1.0 };
            // From the centre of the texel to the lower left.
            let x = dot(&asked.right, px[lane], py[lane], pz[lane]) * texels_per_angstrom + asked.center[0][lane] - 0.5;
            let y = dot(&asked.up, px[lane], py[lane], pz[lane]) * texels_per_angstrom + asked.center[1][lane] - 0.5;
            let column = min(max(x.floor(), 0.0), asked.last[0][lane]);
            let row = min(max(y.floor(), 0.0), asked.last[1][lane]);
            index[lane] = asked.first[lane] + whole(row) * asked.width[lane] + whole(column);
            part_x[lane] = min(max(x - column, 0.0), 1.0);
            part_y[lane] = min(max(y - row, 0.0), 1.0);
            // How the tangent plane rises from texel to texel, in steps. Where it is steep it weighs little.
            let over = -1.0 / max(cosine, 0.02);
            let rise = |axis: &[Lanes; 3]| {
                min(max(dot(axis, nx[lane], ny[lane], nz[lane]) * over, -STEEPEST), STEEPEST) * steps_per_texel
            };
            (slope_x[lane], slope_y[lane]) = (rise(&asked.right), rise(&asked.up));
            let height = dot(&asked.toward, px[lane], py[lane], pz[lane]) * steps_per_angstrom + center;
            level[lane] = height + LIFT - slope_x[lane] * part_x[lane] - slope_y[lane] * part_y[lane];
        }
        let mut next = index;
        for lane in 0..LANES {
            next[lane] += asked.width[lane];
        }
        let (this, next) = (pairs(&self.texels, &index), pairs(&self.texels, &next));
        for lane in 0..LANES {
            let free = |stored: u32, level: f32| if (stored & 0xffff) as i32 as f32 <= level { 1.0f32 } else { 0.0 };
            let right = level[lane] + slope_x[lane];
            let (here, beside) = (free(this[lane], level[lane]), free(this[lane] >> 16, right));
            let (above, aside) =
                (free(next[lane], level[lane] + slope_y[lane]), free(next[lane] >> 16, right + slope_y[lane]));
            let near = here + (beside - here) * part_x[lane];
            let far = above + (aside - above) * part_x[lane];
            let open = near + (far - near) * part_y[lane];
            let above_surface = if weight[lane] > 0.0 { 1.0 } else { 0.0 };
            let full = if WEIGHTED { weight[lane] } else { above_surface };
            seen[lane] += open * full;
        }
    }
}

/// [`Map`]'s drawing as work for [`widest`].
struct DrawMap<'a> {
    map: &'a Map,
    texels: &'a mut [u16],
    solids: &'a Solids,
    scale: Scale,
}

impl Work for DrawMap<'_> {
    #[inline(always)]
    fn run(mut self) {
        for sphere in &self.solids.spheres {
            self.ball(sphere);
        }
        for cylinder in &self.solids.cylinders {
            self.stick(cylinder);
            for (end, round) in cylinder.ends().into_iter().zip(cylinder.round()) {
                if round {
                    self.ball(&Sphere { center: end, radius: cylinder.radius });
                }
            }
        }
    }
}

impl DrawMap<'_> {
    /// Texel coordinates and height, all in texels; the height from the scene's centre.
    #[inline(always)]
    fn place(&self, p: Vec3) -> [f32; 3] {
        let texels = self.scale.texels_per_angstrom;
        [
            p.dot(self.map.right) * texels + self.map.center[0],
            p.dot(self.map.up) * texels + self.map.center[1],
            p.dot(self.map.toward) * texels,
        ]
    }

    /// Texels whose centres are within `reach` of `at`, along axis 0 or 1: first and end.
    #[inline(always)]
    fn span(&self, axis: usize, at: f32, reach: f32) -> [usize; 2] {
        let most = self.map.size[axis] as f32;
        let low = min(max((at - reach + 0.5).floor(), 0.0), most);
        let high = min(max((at + reach + 0.5).floor(), 0.0), most);
        [whole(low) as usize, whole(high) as usize]
    }

    #[inline(always)]
    fn ball(&mut self, sphere: &Sphere) {
        let [x, y, height] = self.place(sphere.center);
        let radius = sphere.radius * self.scale.texels_per_angstrom;
        let (scale, base) = (self.scale.steps_per_texel(), self.scale.center);
        let width = self.map.size[0] as usize;
        let [top, bottom] = self.span(1, y, radius);
        for row in top..bottom {
            let dy = row as f32 + 0.5 - y;
            let left = radius * radius - dy * dy;
            let [start, end] = self.span(0, x, max(left, 0.0).sqrt());
            let from = start as f32 + 0.5 - x;
            let line = &mut self.texels[row * width + start.min(end)..row * width + end];
            for (i, texel) in line.iter_mut().enumerate() {
                let dx = from + i as u32 as f32;
                let up = max(left - dx * dx, 0.0).sqrt();
                let new = whole(base + scale * (height + up)) as u16;
                *texel = if new > *texel { new } else { *texel };
            }
        }
    }

    #[inline(always)]
    fn stick(&mut self, cylinder: &Cylinder) {
        let texels = self.scale.texels_per_angstrom;
        let [x, y, height] = self.place(cylinder.center);
        let (radius, half) = (cylinder.radius * texels, cylinder.half_length * texels);
        let (axis, map) = (cylinder.axis(), self.map);
        let mut u = [axis.dot(map.right), axis.dot(map.up), axis.dot(map.toward)];
        if u[2] < 0.0 {
            u = u.map(|part| -part); // seen from the light, end b is in front
        }
        let [ux, uy, uh] = u;
        let flat = ux * ux + uy * uy;
        let (scale, base) = (self.scale.steps_per_texel(), self.scale.center);
        let reach = |part: f32| half * part.abs() + radius * max(1.0 - part * part, 0.0).sqrt();
        let [top, bottom] = self.span(1, y, reach(uy));
        let [left, right] = self.span(0, x, reach(ux));
        let width = map.size[0] as usize;
        // Nearly along the light one sees the cap: side and cap swap at this height.
        let (steep, over_flat, over_h) = (flat < 1e-5, 1.0 / max(flat, 1e-5), 1.0 / max(uh, 1e-5));
        let strip = radius * flat.sqrt();
        for row in top..bottom {
            let qy = row as f32 + 0.5 - y;
            let [mut start, mut end] = [left, right];
            if uy.abs() > 1e-3 && !steep {
                let near = self.span(0, x + qy * ux / uy, strip / uy.abs());
                [start, end] = [start.max(near[0]), end.min(near[1])];
            }
            if start >= end {
                continue;
            }
            let from = start as f32 + 0.5 - x;
            let line = &mut self.texels[row * width + start..row * width + end];
            for (i, texel) in line.iter_mut().enumerate() {
                let qx = from + i as u32 as f32;
                let aside = qx * uy - qy * ux;
                let inside = flat * radius * radius - aside * aside;
                let along = qx * ux + qy * uy;
                let side = (along * uh + max(inside, 0.0).sqrt()) * over_flat;
                let place = along + side * uh;
                let cap = (half - along) * over_h;
                let on_cap = qx * qx + qy * qy + cap * cap - half * half <= radius * radius;
                let by_cap = steep | (place > half);
                let hit = if by_cap { on_cap } else { (place >= -half) & (inside >= 0.0) };
                let new = whole(base + scale * (height + if by_cap { cap } else { side })) as u16;
                *texel = if hit & (new > *texel) { new } else { *texel };
            }
        }
    }
}

#[cfg(test)]
#[path = "maps_tests.rs"]
mod tests;
