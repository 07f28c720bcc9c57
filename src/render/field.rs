//! The scene's signed distance field, and the ground's shadow and occlusion found from it.
//!
//! `map(p)` is the smallest distance from `p` to any primitive (a union by `min`, with the primitive that gives it). A
//! hierarchy asks only primitives nearer than what matters. The ground's light is found once per texel of a map on
//! the plane (see [`super::frame::GroundGrid`]) and interpolated. What is see-through takes the share of its opacity of the light that it
//! would take if it were opaque: of things that shade one another the darkest counts, so that the many triangles of one surface are one
//! shadow.
//! `shaders/ground_map.wgsl` and `shaders/field.wgsl` hold the twins.

use super::distance::{cone_distance, cylinder_distance, sphere_distance, torus_distance, triangle_distance};
use super::distance::{least_on_way, nearest_on_way};
use super::frame::{FrameConstants, ground_light};
use super::hierarchy::Hierarchy;
use super::solids::{Primitive, Solids};
use super::standings::{Standing, Standings};
use crate::math::{Aabb, whole};
use crate::scene::Scene;
use glam::{Affine3A, Vec2, Vec3};
use rayon::prelude::*;
use std::sync::{Arc, LazyLock};

/// The distance field of a scene, world space, or that of a block in its own.
#[derive(Debug)]
pub struct Field {
    solids: Solids,
    hierarchy: Hierarchy,
    /// The highest opacity in each box of the hierarchy; empty where nothing is see-through. No more than its share of the light is taken
    /// away there: without that a ray through thousands of triangles asks them all.
    highest: Vec<u8>,
    /// In place of primitives of its own, those of blocks that are placed many times.
    copies: Standings,
}

/// Parts of the way past a torus that are searched each on its own: through a ring it comes near the tube twice.
const TORUS_STARTS: u32 = 8;

/// Texels of the ground that are found one after the other, each beginning with what was found for the one before. Chosen.
const NEIGHBOURS: usize = 64;

/// By how much the shadow of a picture in motion may be too light, before it is eased: of full light 0.7 percent where it is dark, and 7.5 at the
/// most. Measured: no channel of a picture of 100,000 atoms differs by more than 2 of 255, and its map takes half the time.
pub(super) const QUICK_SHADOW: f32 = 0.05;

/// The primitives that shaded a point of the ground: they may well shade its neighbour.
#[derive(Default)]
struct Nearby {
    shadow: Option<u32>,
    taps: [Option<u32>; OCCLUSION_TAPS.len()],
}

/// Distances above the ground at which the field is asked for occlusion, as fractions of the reach.
pub const OCCLUSION_TAPS: [f32; 6] = [0.03, 0.07, 0.16, 0.33, 0.6, 1.0];

impl Field {
    /// The field of all primitives of a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Field {
        let solids = Solids::new(scene, Affine3A::IDENTITY);
        Field::of_solids(solids)
    }

    /// The field of a block in its own space.
    #[must_use]
    pub fn of_block(scene: &Scene, block: usize) -> Field {
        Field::of_solids(Solids::of_block(scene, block))
    }

    /// The field of a scene, asked of its blocks' fields (numbered as the blocks are) where they are placed: the same as [`Field::new`]'s
    /// within rounding, in the memory of one copy. [`Field::solids`] and [`Field::hierarchy`] are empty.
    #[must_use]
    pub fn of_copies(scene: &Scene, blocks: &[Arc<Field>]) -> Field {
        let see_through = blocks.iter().any(|field| field.solids.see_through);
        let solids = Solids { see_through, ..Solids::default() };
        Field { copies: Standings::new(scene, blocks), ..Field::of_solids(solids) }
    }

    fn of_solids(solids: Solids) -> Field {
        let hierarchy = Hierarchy::new(&solids.bounds());
        let highest = match solids.see_through {
            true => hierarchy.highest(|index| solids.opacity(index as usize)),
            false => Vec::new(),
        };
        Field { solids, hierarchy, highest, copies: Standings::default() }
    }

    /// The primitives, world space.
    #[must_use]
    pub fn solids(&self) -> &Solids {
        &self.solids
    }

    /// The hierarchy over the primitives.
    #[must_use]
    pub fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    /// The field that has primitive `index`, its index there, and the space of that field.
    fn home(&self, index: usize) -> (&Field, usize, Affine3A) {
        match self.copies.of(index) {
            Some((standing, own)) => (&standing.field, own, standing.block_from_world),
            None => (self, index, Affine3A::IDENTITY),
        }
    }

    /// The distance of primitive `index`.
    pub(super) fn distance(&self, index: usize, p: Vec3) -> f32 {
        if !self.copies.is_empty() {
            let (field, own, block_from_world) = self.home(index);
            return field.distance(own, block_from_world.transform_point3(p));
        }
        match self.solids.primitive(index) {
            Primitive::Sphere(i) => sphere_distance(p, &self.solids.spheres[i]),
            Primitive::Cylinder(i) => cylinder_distance(p, &self.solids.cylinders[i]),
            Primitive::Cone(i) => cone_distance(p, &self.solids.cones[i]),
            Primitive::Torus(i) => torus_distance(p, &self.solids.tori[i]),
            Primitive::Triangle(i) => triangle_distance(p, &self.solids.triangles[i]),
        }
    }

    /// Where on the way `p + t·direction`, `t ≥ start`, primitive `index` lets least light through, and its distance there.
    fn least_on_way(&self, index: usize, p: Vec3, direction: Vec3, start: f32) -> (f32, f32) {
        let way = (p, direction, start);
        match self.solids.primitive(index) {
            Primitive::Sphere(i) => {
                let sphere = &self.solids.spheres[i];
                let t = (sphere.center - p).dot(direction).max(start);
                (t, sphere_distance(p + direction * t, sphere))
            }
            Primitive::Cylinder(i) => {
                let cylinder = &self.solids.cylinders[i];
                let t = nearest_on_way(p, direction, cylinder).max(start);
                (t, cylinder_distance(p + direction * t, cylinder))
            }
            Primitive::Cone(i) => {
                let (center, radius) = self.ball(index);
                least_on_way(way, center, radius, 1, |p| cone_distance(p, &self.solids.cones[i]))
            }
            Primitive::Torus(i) => {
                let (center, radius) = self.ball(index);
                least_on_way(way, center, radius, TORUS_STARTS, |p| torus_distance(p, &self.solids.tori[i]))
            }
            Primitive::Triangle(i) => {
                let (center, radius) = self.ball(index);
                least_on_way(way, center, radius, 1, |p| triangle_distance(p, &self.solids.triangles[i]))
            }
        }
    }

    /// Whether a primitive takes so long to ask that the ball around it is asked before: others are as quick as that.
    fn is_slow(&self, index: usize) -> bool {
        index >= self.solids.spheres.len() + self.solids.cylinders.len()
    }

    /// The opacity of a primitive; costs nothing where all are opaque.
    fn opacity(&self, index: usize) -> u8 {
        if !self.solids.see_through {
            return u8::MAX;
        }
        let (field, own, _) = self.home(index);
        field.solids.opacity(own)
    }

    /// The ball around a slow one.
    pub(super) fn ball(&self, index: usize) -> (Vec3, f32) {
        match self.solids.primitive(index) {
            Primitive::Cone(i) => {
                let cone = &self.solids.cones[i];
                (cone.center, cone.half_length + cone.radii[0].max(cone.radii[1]))
            }
            Primitive::Torus(i) => {
                let torus = &self.solids.tori[i];
                (torus.center, torus.ring_radius + torus.tube_radius)
            }
            Primitive::Triangle(i) => {
                let triangle = &self.solids.triangles[i];
                (triangle.center, triangle.corners.iter().fold(0.0, |most, corner| corner.length().max(most)))
            }
            Primitive::Sphere(_) | Primitive::Cylinder(_) => (Vec3::ZERO, f32::INFINITY),
        }
    }

    /// The signed distance at `p` and the primitive (index into [`Field::solids`]) that gives it; only primitives nearer
    /// than `limit` are asked: `(limit, None)` where there is none.
    #[must_use]
    pub fn map(&self, p: Vec3, limit: f32) -> (f32, Option<u32>) {
        self.nearest(p, (limit, None), None)
    }

    /// The distance at a point so high above the ground, as far as it shades the ground: what is see-through is farther away. `near` is a
    /// primitive that may be the nearest, which saves most of the search, and becomes the one that is.
    fn over_ground(&self, p: Vec3, height: f32, limit: f32, near: &mut Option<u32>) -> f32 {
        let of = |index: usize, distance: f32| dimmed_distance(distance, height, self.opacity(index));
        let known = near.map(|near| (of(near as usize, self.distance(near as usize, p)), Some(near)));
        let known = known.filter(|known| known.0 < limit).unwrap_or((limit, None));
        let (distance, found) = self.nearest(p, known, Some(height));
        *near = found.or(*near);
        distance
    }

    /// The smallest of the primitives' distances, at so high above the ground dimmed, and the primitive, if it is less than what is known.
    fn nearest(&self, p: Vec3, known: (f32, Option<u32>), height: Option<f32>) -> (f32, Option<u32>) {
        if self.copies.is_empty() {
            return self.nearest_own(p, known, height);
        }
        let mut best = known;
        self.copies.hierarchy.visit(
            &mut best,
            |best, b: &Aabb| Some(b.distance(p)).filter(|&d| d < best.0 || d == 0.0),
            |best, number| {
                let Standing { field, block_from_world, first } = &self.copies.standings[number as usize];
                let p = block_from_world.transform_point3(p);
                let (distance, found) = field.nearest_own(p, (best.0, None), height);
                *best = found.map_or(*best, |own| (distance, Some(first + own)));
            },
        );
        best
    }

    /// As [`Field::nearest`], among its own primitives.
    fn nearest_own(&self, p: Vec3, known: (f32, Option<u32>), height: Option<f32>) -> (f32, Option<u32>) {
        let dimmed = |distance: f32, opacity: u8| height.map_or(distance, |h| dimmed_distance(distance, h, opacity));
        let mut best = known;
        self.hierarchy.visit_numbered(
            &mut best,
            |best, number, b: &Aabb| {
                let (distance, opacity) = (b.distance(p), self.highest_in(number));
                // Inside a box the distance to what it holds may be negative, unless it is dimmed: it is always entered.
                let is_open = distance == 0.0 && (height.is_none() || opacity == u8::MAX);
                (is_open || dimmed(distance, opacity) < best.0).then_some(distance)
            },
            |best, index| {
                let i = index as usize;
                if self.is_slow(i) {
                    let (center, radius) = self.ball(i);
                    if center.distance(p) - radius >= best.0 {
                        return;
                    }
                }
                let distance = dimmed(self.distance(i, p), self.opacity(i));
                if distance < best.0 {
                    *best = (distance, Some(index));
                }
            },
        );
        best
    }

    /// How much of the key light reaches a point of the ground: the smallest `sharpness · distance / t` of any primitive
    /// along the way to the light, at most 1, eased at both ends as the disc of an area light fills.
    ///
    /// Each primitive is asked once, at the point of the way that is nearest to it, instead of wherever a march happens
    /// to stop: one walk through the hierarchy, and no bands in the penumbra.
    #[must_use]
    pub fn ground_shadow(&self, frame: &FrameConstants, p: Vec3) -> f32 {
        self.shadow_near(frame, p, &mut None, 0.0)
    }

    /// As [`Field::ground_shadow`]; `near` is a primitive that may give the shadow, which saves most of the search, and becomes the
    /// one that does. What would make the least by no more than `slack` less is not looked for.
    fn shadow_near(&self, frame: &FrameConstants, p: Vec3, near: &mut Option<u32>, slack: f32) -> f32 {
        let Some(way) = Way::to_light(frame, p, slack) else {
            return 1.0; // the light is below: it lights no ground, it casts no shadow on it
        };
        let mut darkest = (1.0f32, None);
        if let Some(near) = *near {
            let (field, own, block_from_world) = self.home(near as usize);
            darkest = (field.light_past(&way.moved(&block_from_world), own).min(1.0), Some(near));
        }
        if self.copies.is_empty() {
            self.darken(&way, &mut darkest);
        } else {
            self.copies.hierarchy.visit(
                &mut darkest,
                |&(visible, _), b: &Aabb| way.may_darken(b, visible),
                |darkest, number| {
                    let Standing { field, block_from_world, first } = &self.copies.standings[number as usize];
                    let mut own = (darkest.0, None);
                    field.darken(&way.moved(block_from_world), &mut own);
                    *darkest = own.1.map_or(*darkest, |found: u32| (own.0, Some(first + found)));
                },
            );
        }
        let (visible, found) = darkest;
        *near = found.or(*near);
        eased(visible)
    }

    /// The light that one of its own primitives lets through on the way to the light.
    #[inline(always)]
    fn light_past(&self, way: &Way, index: usize) -> f32 {
        let (t, distance) = self.least_on_way(index, way.p, way.to_light, way.start);
        let opacity = if self.solids.see_through { self.solids.opacity(index) } else { u8::MAX };
        dimmed_way((way.sharpness * distance / t).max(0.0), opacity)
    }

    /// The least light that its own primitives let through on the way to the light, and the primitive, if it is less than what is known.
    fn darken(&self, way: &Way, darkest: &mut (f32, Option<u32>)) {
        self.hierarchy.visit_numbered(
            darkest,
            |&(visible, _), number, b: &Aabb| {
                way.may_darken(b, visible).filter(|_| self.least_light_in(number) < visible - way.slack)
            },
            |darkest, index| self.darken_by(way, index, darkest),
        );
    }

    /// The highest opacity in a box of its hierarchy.
    #[inline(always)]
    fn highest_in(&self, number: usize) -> u8 {
        self.highest.get(number).copied().unwrap_or(u8::MAX)
    }

    /// The least light that anything in a box of its hierarchy lets through, before it is eased.
    #[inline(always)]
    fn least_light_in(&self, number: usize) -> f32 {
        self.highest.get(number).map_or(0.0, |&opacity| LEAST_LIGHT[usize::from(opacity)])
    }

    /// As [`Field::ground_shadow`] has it of one of its own primitives: the light that it lets through, if that is less than what is known.
    pub(super) fn darken_by(&self, way: &Way, index: u32, darkest: &mut (f32, Option<u32>)) {
        let (Way { p, to_light, start, sharpness, slack }, i) = (*way, index as usize);
        if self.is_slow(i) {
            let (center, radius) = self.ball(i);
            let along = (center - p).dot(to_light);
            let beside = (center - p - to_light * along).length() - radius;
            if sharpness * beside >= (darkest.0 - slack) * (along + radius).max(start) {
                return;
            }
        }
        let light = self.light_past(way, i);
        if light < darkest.0 {
            *darkest = (light, Some(index));
        }
    }

    /// How much of the sky a point of the ground sees, 0–1: by how much the field above it falls short of the height.
    #[must_use]
    pub fn ground_open(&self, frame: &FrameConstants, p: Vec3) -> f32 {
        self.open_near(frame, p, &mut Nearby::default())
    }

    /// As [`Field::ground_open`], beginning with what is nearby.
    fn open_near(&self, frame: &FrameConstants, p: Vec3, nearby: &mut Nearby) -> f32 {
        let reach = frame.ground_map_size[3];
        let (mut closed, mut below) = (0.0, 0.0);
        let mut bound = f32::INFINITY;
        for (tap, near) in OCCLUSION_TAPS.into_iter().zip(&mut nearby.taps) {
            let height = tap * reach;
            // The field grows by no more than the way: the tap below bounds this one, and most of the walk is saved. (A
            // thousandth more, for rounding.)
            let limit = height.min(1.001 * (bound + (height - below)));
            let distance = self.over_ground(p + Vec3::Y * height, height, limit, near);
            (bound, below) = (distance.max(0.0), height);
            closed += (height - distance.max(0.0)) / height;
        }
        1.0 - closed / OCCLUSION_TAPS.len() as f32
    }

    /// The ground map: key light and open sky of every texel centre, rows along world x.
    #[must_use]
    pub fn ground_map(&self, frame: &FrameConstants) -> GroundMap {
        self.map_of(frame, |p, nearby| {
            [self.shadow_near(frame, p, &mut nearby.shadow, 0.0), self.open_near(frame, p, nearby)]
        })
    }

    /// A ground map of the open sky alone, the key light everywhere full: for `frame` of [`FrameConstants::lit_from_above`], it holds however
    /// the light turns.
    #[must_use]
    pub fn sky_map(&self, frame: &FrameConstants) -> GroundMap {
        self.map_of(frame, |p, nearby| [1.0, self.open_near(frame, p, nearby)])
    }

    /// A ground map for pictures in motion: the open sky is interpolated from a map of it, and the shadow is found within
    /// [`QUICK_SHADOW`].
    #[must_use]
    pub fn quick_ground_map(
        &self,
        frame: &FrameConstants,
        (sky_frame, sky): &(FrameConstants, GroundMap),
    ) -> GroundMap {
        self.map_of(frame, |p, nearby| {
            [self.shadow_near(frame, p, &mut nearby.shadow, QUICK_SHADOW), sky.at(sky_frame, p)[1]]
        })
    }

    /// What `of` finds of the centre of each texel.
    fn map_of(&self, frame: &FrameConstants, of: impl Fn(Vec3, &mut Nearby) -> [f32; 2] + Sync) -> GroundMap {
        let grid = frame.ground_grid();
        let [width, height] = grid.size;
        let mut texels = vec![[1.0f32; 2]; width as usize * height as usize];
        if !(self.solids.is_empty() && self.copies.is_empty()) && frame.has_ground() {
            let step = 1.0 / grid.texels_per_angstrom;
            texels.par_chunks_mut(NEIGHBOURS).enumerate().for_each(|(run, texels)| {
                let mut nearby = Nearby::default();
                for (i, texel) in (run * NEIGHBOURS..).zip(texels) {
                    let (x, z) = ((i % width as usize) as f32, (i / width as usize) as f32);
                    let (x, z) = (grid.corner[0] + (x + 0.5) * step, grid.corner[1] + (z + 0.5) * step);
                    *texel = of(Vec3::new(x, frame.ground[0], z), &mut nearby);
                }
            });
        }
        GroundMap { size: grid.size, texels }
    }
}

/// The light that reaches the ground where so much is let through (0–1): as the disc of an area light fills.
pub(super) fn eased(visible: f32) -> f32 {
    visible * visible * (3.0 - 2.0 * visible)
}

/// A way from a point to the light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    pub(super) p: Vec3,
    /// Unit.
    pub(super) to_light: Vec3,
    /// Where it begins.
    pub(super) start: f32,
    /// Of the penumbra.
    pub(super) sharpness: f32,
    /// By how much the least light may be missed.
    pub(super) slack: f32,
}

impl Way {
    /// From a point of the ground; `None` if the light is below it.
    pub(super) fn to_light(frame: &FrameConstants, p: Vec3, slack: f32) -> Option<Way> {
        let to_light = Vec3::new(frame.key_in_world[0], frame.key_in_world[1], frame.key_in_world[2]);
        // What touches the ground shadows it at once; the way starts at a small part of the scene all the same.
        let low = Vec3::new(frame.bounds_min[0], frame.bounds_min[1], frame.bounds_min[2]);
        let high = Vec3::new(frame.bounds_max[0], frame.bounds_max[1], frame.bounds_max[2]);
        let start = 1e-3 * (high - low).length();
        (to_light.y > 0.0).then_some(Way { p, to_light, start, sharpness: frame.ground_map_size[2], slack })
    }

    /// The same way in another space.
    fn moved(&self, space_from_world: &Affine3A) -> Way {
        let p = space_from_world.transform_point3(self.p);
        Way { p, to_light: space_from_world.transform_vector3(self.to_light), ..*self }
    }

    /// Whether what is in a box may leave less than so much light, and how near to the way it may be.
    #[inline(always)]
    fn may_darken(&self, b: &Aabb, visible: f32) -> Option<f32> {
        // Nothing in the ball around the box is nearer to the way than this, nor farther along it.
        let center = (b.min + b.max) * 0.5 - self.p;
        let radius = (b.max - b.min).length() * 0.5;
        let t = center.dot(self.to_light);
        let beside = (center - self.to_light * t).length() - radius;
        let farthest = t + radius;
        // What is dark cannot get darker.
        let visible = visible - self.slack;
        (visible > 0.0 && farthest > 0.0 && self.sharpness * beside < visible * farthest).then_some(beside)
    }
}

/// Where on the scale that [`Field::ground_shadow`] eases (0 dark, 1 light) a shadow stands of which the opacity (0–255) takes its share:
/// the easing turned round (the root between 0 and 1 of its cubic, by the angle that it is the third part of).
fn dimmed_way(x: f32, opacity: u8) -> f32 {
    if opacity == u8::MAX || x >= 1.0 {
        return x;
    }
    let light = 1.0 - f32::from(opacity) / 255.0 * (1.0 - x * x * (3.0 - 2.0 * x));
    0.5 - ((1.0 - 2.0 * light).clamp(-1.0, 1.0).asin() / 3.0).sin()
}

/// What is left by what takes away all it can, for every opacity.
static LEAST_LIGHT: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|opacity| dimmed_way(0.0, opacity as u8)));

/// A distance found so high above the ground that falls short of the height by the opacity's share only.
fn dimmed_distance(distance: f32, height: f32, opacity: u8) -> f32 {
    if opacity == u8::MAX {
        return distance;
    }
    height - f32::from(opacity) / 255.0 * (height - distance.max(0.0))
}

/// Light on the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundMap {
    /// Texels along world x and z.
    pub size: [u32; 2],
    /// Part of the key light and part of the sky that reach each texel, 0–1.
    pub texels: Vec<[f32; 2]>,
}

impl GroundMap {
    /// No map: full light everywhere.
    #[must_use]
    pub fn none() -> GroundMap {
        GroundMap { size: [0, 0], texels: Vec::new() }
    }

    /// [`ground_light`] at points of the ground, the same as with [`GroundMap::at`] one by one.
    #[inline(always)]
    #[must_use]
    pub fn light<const N: usize>(
        &self,
        frame: &FrameConstants,
        x_in_world: &[f32; N],
        z_in_world: &[f32; N],
    ) -> [f32; N] {
        let grid = frame.ground_grid();
        let mut light = [1.0; N];
        let [width, height] = self.size;
        if width < 2 || height < 2 {
            return light;
        }
        let (mut at, mut part) = ([0u32; N], [[0.0f32; N]; 2]);
        let mut inside = [false; N];
        for i in 0..N {
            let x = (x_in_world[i] - grid.corner[0]) * grid.texels_per_angstrom - 0.5;
            let z = (z_in_world[i] - grid.corner[1]) * grid.texels_per_angstrom - 0.5;
            inside[i] = (x >= 0.0) & (z >= 0.0) & (x <= width as f32 - 1.0) & (z <= height as f32 - 1.0);
            let (x, z) = if inside[i] { (x, z) } else { (0.0, 0.0) };
            let (x0, z0) = (x.floor(), z.floor());
            part[0][i] = x - x0;
            part[1][i] = z - z0;
            at[i] = whole(z0) * width + whole(x0);
        }
        if inside.iter().all(|&inside| !inside) {
            return light;
        }
        let (last, stride) = (self.texels.len() - 1, width as usize);
        let around = |at: usize| [at, at + 1, at + stride, at + stride + 1].map(|at| self.texels[at.min(last)]);
        let mut corners = [[[1.0f32; N]; 2]; 4];
        if at.iter().all(|other| *other == at[0]) {
            // Neighbouring pixels mostly lie between the same texels.
            for (corners, texel) in corners.iter_mut().zip(around(at[0] as usize)) {
                (corners[0], corners[1]) = ([texel[0]; N], [texel[1]; N]);
            }
        } else {
            for i in 0..N {
                for (corners, texel) in corners.iter_mut().zip(around(at[i] as usize)) {
                    (corners[0][i], corners[1][i]) = (texel[0], texel[1]);
                }
            }
        }
        for i in 0..N {
            let mix = |kind: usize| {
                let near = corners[0][kind][i] + (corners[1][kind][i] - corners[0][kind][i]) * part[0][i];
                let far = corners[2][kind][i] + (corners[3][kind][i] - corners[2][kind][i]) * part[0][i];
                near + (far - near) * part[1][i]
            };
            let mixed = ground_light(frame, mix(0), mix(1));
            light[i] = if inside[i] { mixed } else { 1.0 };
        }
        light
    }

    /// Key light and open sky at a world point, interpolated between texel centres; full light outside the map.
    #[must_use]
    pub fn at(&self, frame: &FrameConstants, point_in_world: Vec3) -> [f32; 2] {
        let grid = frame.ground_grid();
        let x = (point_in_world.x - grid.corner[0]) * grid.texels_per_angstrom - 0.5;
        let z = (point_in_world.z - grid.corner[1]) * grid.texels_per_angstrom - 0.5;
        let [width, height] = self.size;
        if !(x >= 0.0 && z >= 0.0 && x <= width as f32 - 1.0 && z <= height as f32 - 1.0) {
            return [1.0, 1.0];
        }
        let (x0, z0) = (x.floor(), z.floor());
        let (fx, fz) = (x - x0, z - z0);
        let texel = |x: f32, z: f32| {
            let (x, z) = ((x as u32).min(width - 1), (z as u32).min(height - 1));
            Vec2::from(self.texels[(z * width + x) as usize])
        };
        let near = texel(x0, z0) + (texel(x0 + 1.0, z0) - texel(x0, z0)) * fx;
        let far = texel(x0, z0 + 1.0) + (texel(x0 + 1.0, z0 + 1.0) - texel(x0, z0 + 1.0)) * fx;
        (near + (far - near) * fz).to_array()
    }
}

#[cfg(test)]
#[path = "field_shape_tests.rs"]
mod shape_tests;
#[cfg(test)]
#[path = "field_tests.rs"]
mod tests;
