//! Depth maps of the scene from the directions of the sky and of the key light: the product's way to ask which of them
//! a surface point sees.
//!
//! A map is seen along parallel rays from infinity. Its texel holds how far the scene reaches towards the light,
//! in 65,534 steps over the scene's depth. A point is compared where the tangent plane at it passes through the texel's
//! centre: a convex solid lies behind its tangent planes, so it never shadows itself, at any angle, and
//! no bias has to be guessed.
//!
//! Limits: edges of shadows are as fine as a texel ([`Maps::new`] says how large it is).

use super::intersect::primitive_t;
use super::simd::{Work, widest};
use crate::render::sky::across;
use crate::render::solids::{Cylinder, Primitive, Solids, Sphere};
use crate::scene::{Ray, Scene};
use glam::{Affine3A, Vec3};
use rayon::prelude::*;

/// Texels of all maps together (2 bytes each). Chosen: 64 MiB.
const MAX_TEXELS: f32 = 32.0 * 1024.0 * 1024.0;
/// No texel is finer, in ångström: a tenth of a stick's radius.
const MIN_TEXEL: f32 = 0.013;
/// Steps of height; 0 is kept for texels where nothing is seen.
const STEPS: f32 = 65_534.0;
/// A point is lifted by so many steps, for rounding.
const LIFT: f32 = 2.0;
/// On the way along the tangent plane to a texel's centre a point rises by no more than so many texels.
const STEEPEST: f32 = 64.0;
/// Triangles are lowered by so many texels at most. Chosen: steeper ones weigh little.
const MESH_LOWERED: f32 = 4.0;
/// Points that are asked together.
pub(super) const LANES: usize = 8;

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

/// Points that are asked together, and what they were told.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Points {
    pub(super) position: [[f32; LANES]; 3],
    pub(super) normal: [[f32; LANES]; 3],
    /// Sum of the weights of free directions, and of all.
    seen: [f32; LANES],
    all: [f32; LANES],
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
        let solids = Solids::casting(scene, Affine3A::from_translation(-bounds.center()));
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

    /// Which part of the directions the points see: weighted by the cosine to the normal, or each the same.
    #[inline(always)]
    pub(super) fn ask<const WEIGHTED: bool>(&self, points: &mut Points) {
        points.seen = [0.0; LANES];
        points.all = [0.0; LANES];
        for map in &self.maps {
            self.ask_one::<WEIGHTED>(map, points);
        }
    }

    #[inline(always)]
    fn ask_one<const WEIGHTED: bool>(&self, map: &Map, points: &mut Points) {
        let [px, py, pz] = &points.position;
        let [nx, ny, nz] = &points.normal;
        let mut weight = [0.0f32; LANES];
        let d = map.toward;
        for lane in 0..LANES {
            let cosine = nx[lane] * d.x + ny[lane] * d.y + nz[lane] * d.z;
            weight[lane] = if cosine > 0.0 { cosine } else { 0.0 };
        }
        for lane in 0..LANES {
            points.all[lane] += if WEIGHTED { weight[lane] } else { 1.0 };
        }
        if weight == [0.0; LANES] {
            return;
        }
        let Scale { texels_per_angstrom, steps_per_angstrom, center } = self.scale;
        let steps_per_texel = self.scale.steps_per_texel();
        let last = [(map.size[0] - 1) as f32, (map.size[1] - 1) as f32];
        let (mut index, mut level) = ([0u32; LANES], [0.0f32; LANES]);
        for lane in 0..LANES {
            let along = |v: Vec3| px[lane] * v.x + py[lane] * v.y + pz[lane] * v.z;
            let x = along(map.right) * texels_per_angstrom + map.center[0];
            let y = along(map.up) * texels_per_angstrom + map.center[1];
            let height = along(d) * steps_per_angstrom + center;
            let column = min(max(x.floor(), 0.0), last[0]);
            let row = min(max(y.floor(), 0.0), last[1]);
            // Along the tangent plane to the texel's centre. At a grazing angle the way would be long; it weighs little.
            let lean = |v: Vec3| nx[lane] * v.x + ny[lane] * v.y + nz[lane] * v.z;
            let rise = lean(map.right) * (column + 0.5 - x) + lean(map.up) * (row + 0.5 - y);
            let shift = min(max(-rise / max(weight[lane], 0.02), -STEEPEST), STEEPEST);
            level[lane] = height + LIFT + shift * steps_per_texel;
            index[lane] = whole(row) * map.size[0] + whole(column);
        }
        let texels = &self.texels[map.first..map.first + map.size[0] as usize * map.size[1] as usize];
        let stored: [u16; LANES] = std::array::from_fn(|lane| texels[index[lane] as usize]);
        for lane in 0..LANES {
            let free = f32::from(stored[lane]) <= level[lane];
            let full = if WEIGHTED { weight[lane] } else { f32::from(u8::from(weight[lane] > 0.0)) };
            points.seen[lane] += if free { full } else { 0.0 };
        }
    }
}

impl Points {
    /// A point and its unit normal, relative to the scene's centre.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, position: Vec3, normal: Vec3) {
        for axis in 0..3 {
            self.position[axis][lane] = position[axis];
            self.normal[axis][lane] = normal[axis];
        }
    }

    /// The part that was seen.
    #[inline(always)]
    pub(super) fn part(&self, lane: usize) -> f32 {
        if self.all[lane] > 0.0 { self.seen[lane] / self.all[lane] } else { 1.0 }
    }
}

// `f32::min` and `max` keep a number beside NaN, which costs; these become one instruction.
#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// A whole number of 0 to 2²³ − 1, rounded: its bits after 2²³ was added. A cast would check for more.
#[inline(always)]
fn whole(x: f32) -> u32 {
    (x + 8_388_608.0).to_bits() & 0x7f_ffff
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
        let rare = self.solids.spheres.len() + self.solids.cylinders.len()..self.solids.len();
        if !rare.is_empty() {
            self.by_rays(rare);
        }
    }
}

impl DrawMap<'_> {
    /// Primitives that are few, a ray through each texel of their boxes.
    #[inline(never)]
    fn by_rays(&mut self, primitives: std::ops::Range<usize>) {
        let (map, width) = (self.map, self.map.size[0] as usize);
        let texels = self.scale.texels_per_angstrom;
        let (scale, base) = (self.scale.steps_per_texel(), self.scale.center);
        for index in primitives {
            let bounds = self.solids.box_of(index);
            let half = (bounds.max - bounds.min) * (0.5 * texels);
            let [x, y, height] = self.place((bounds.min + bounds.max) * 0.5);
            let [left, right] = self.span(0, x, map.right.abs().dot(half) + 1.0);
            let [top, bottom] = self.span(1, y, map.up.abs().dot(half) + 1.0);
            // Rays start above the primitive, in ångström.
            let start = height / texels + map.toward.abs().dot(half) / texels + 1.0;
            let lower = self.lower_by(index);
            for row in top..bottom {
                for column in left..right {
                    let at = |place: usize, center: f32| (place as f32 + 0.5 - center) / texels;
                    let (u, v) = (at(column, map.center[0]), at(row, map.center[1]));
                    let origin = map.right * u + map.up * v + map.toward * start;
                    let t = primitive_t(&Ray { origin, direction: -map.toward }, self.solids, index, 0.0);
                    if t < f32::INFINITY {
                        let new = whole(base + scale * ((start - t) * texels - lower)).min(65_535) as u16;
                        let texel = &mut self.texels[row * width + column];
                        *texel = (*texel).max(new);
                    }
                }
            }
        }
    }

    /// By how many texels a primitive is taken to be lower: a triangle by what it rises over half a texel, as the tangent plane
    /// that a point of a mesh is compared on is that of the interpolated normal, not its own.
    fn lower_by(&self, index: usize) -> f32 {
        let Primitive::Triangle(i) = self.solids.primitive(index) else { return 0.0 };
        let face = self.solids.triangles[i].face;
        let lean = face.dot(self.map.right).abs() + face.dot(self.map.up).abs();
        (0.5 * lean / face.dot(self.map.toward).abs().max(1e-6)).min(MESH_LOWERED)
    }

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
