//! The scene's signed distance field, and the ground's shadow and occlusion found from it.
//!
//! `map(p)` is the smallest distance from `p` to any primitive (a union by `min`, with the primitive that gives it). A
//! hierarchy asks only primitives nearer than what matters. The ground's light is found once per texel of a map on
//! the plane (see [`super::frame::GroundGrid`]) and interpolated. `shaders/ground_map.wgsl` holds the twins.

use super::frame::FrameConstants;
use super::hierarchy::Hierarchy;
use super::solids::{Cylinder, Solids, Sphere};
use crate::math::Aabb;
use crate::scene::Scene;
use glam::{Affine3A, Vec2, Vec3};
use rayon::prelude::*;

/// Distance to a sphere, negative inside.
#[inline]
#[must_use]
pub fn sphere_distance(p: Vec3, sphere: &Sphere) -> f32 {
    (p - sphere.center).length() - sphere.radius
}

/// Distance to a capped cylinder, negative inside. Round caps count, open ends are taken as closed: the field bounds solids.
#[inline]
#[must_use]
pub fn cylinder_distance(p: Vec3, cylinder: &Cylinder) -> f32 {
    let q = cylinder.cylinder_from_space * (p - cylinder.center);
    let beyond = q.y.abs() - cylinder.half_length;
    let across = (q.x * q.x + q.z * q.z).sqrt();
    let round = (cylinder.caps >> if q.y > 0.0 { 2 } else { 0 }) & 3 == 2;
    if round {
        let up = beyond.max(0.0);
        return (across * across + up * up).sqrt() - cylinder.radius;
    }
    let out = across - cylinder.radius;
    out.max(beyond).min(0.0) + Vec2::new(out, beyond).max(Vec2::ZERO).length()
}

/// The distance field of a scene, world space.
#[derive(Debug)]
pub struct Field {
    solids: Solids,
    hierarchy: Hierarchy,
}

/// Steps of the march to the light; with a step of at least 1/`sharpness` of the way come so far, 64 steps of a
/// penumbra of 6 reach 19,000 times the first step.
pub const MAX_STEPS: u32 = 64;
/// Distances above the ground at which the field is asked for occlusion, as fractions of the reach.
pub const OCCLUSION_TAPS: [f32; 6] = [0.03, 0.07, 0.16, 0.33, 0.6, 1.0];

impl Field {
    /// The field of all primitives of a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Field {
        let solids = Solids::new(scene, Affine3A::IDENTITY);
        let hierarchy = Hierarchy::new(&solids.bounds());
        Field { solids, hierarchy }
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

    /// The signed distance at `p` and the primitive (index into [`Field::solids`]) that gives it; only primitives nearer
    /// than `limit` are asked: `(limit, None)` where there is none.
    #[must_use]
    pub fn map(&self, p: Vec3, limit: f32) -> (f32, Option<u32>) {
        let mut best = (limit, None);
        self.hierarchy.visit(
            &mut best,
            // Inside a box the distance to what it holds may be negative: it is always entered.
            |best, b: &Aabb| Some(b.distance(p)).filter(|&d| d < best.0 || d == 0.0),
            |best, index| {
                let i = index as usize;
                let distance = match i.checked_sub(self.solids.spheres.len()) {
                    None => sphere_distance(p, &self.solids.spheres[i]),
                    Some(cylinder) => cylinder_distance(p, &self.solids.cylinders[cylinder]),
                };
                if distance < best.0 {
                    *best = (distance, Some(index));
                }
            },
        );
        best
    }

    /// How much of the key light reaches a point of the ground: the smallest `sharpness · distance / t` along the way,
    /// at most 1, smoothed as the disc of an area light fills.
    #[must_use]
    pub fn ground_shadow(&self, frame: &FrameConstants, p: Vec3) -> f32 {
        let to_light = Vec3::new(frame.key_in_world[0], frame.key_in_world[1], frame.key_in_world[2]);
        let sharpness = frame.ground_map_size[2];
        if to_light.y <= 0.0 {
            return 1.0; // the light is below: it lights no ground, it casts no shadow on it
        }
        let low = Vec3::new(frame.bounds_min[0], frame.bounds_min[1], frame.bounds_min[2]);
        let high = Vec3::new(frame.bounds_max[0], frame.bounds_max[1], frame.bounds_max[2]);
        // Rays that pass beside the box within the penumbra count too.
        let far_corner = (high.y - frame.ground[0]) / to_light.y.max(0.05);
        let grown = Aabb { min: low, max: high }.grown(far_corner / sharpness);
        let Some((enter, leave)) = grown.slab(p, to_light.recip()) else { return 1.0 };
        // What touches the ground shadows it at once: t starts at a small part of the scene.
        let start = 1e-3 * (high - low).length();
        let mut t = enter.max(start);
        let mut visible = 1.0f32;
        for _ in 0..MAX_STEPS {
            if t > leave || visible <= 0.0 {
                break;
            }
            // Farther than this nothing darkens the point more than it is.
            let limit = visible * t / sharpness;
            let (distance, _) = self.map(p + to_light * t, limit);
            visible = visible.min((sharpness * distance / t).max(0.0));
            t += distance.max(limit * 0.5).max(start);
        }
        visible * visible * (3.0 - 2.0 * visible)
    }

    /// How much of the sky a point of the ground sees, 0–1: by how much the field above it falls short of the height.
    #[must_use]
    pub fn ground_open(&self, frame: &FrameConstants, p: Vec3) -> f32 {
        let reach = frame.ground_map_size[3];
        let mut closed = 0.0;
        for tap in OCCLUSION_TAPS {
            let height = tap * reach;
            let (distance, _) = self.map(p + Vec3::Y * height, height);
            closed += (height - distance.max(0.0)) / height;
        }
        1.0 - closed / OCCLUSION_TAPS.len() as f32
    }

    /// The ground map: key light and open sky of every texel centre, rows along world x.
    #[must_use]
    pub fn ground_map(&self, frame: &FrameConstants) -> GroundMap {
        let grid = frame.ground_grid();
        let [width, height] = grid.size;
        let mut texels = vec![[1.0f32; 2]; width as usize * height as usize];
        if !self.solids.is_empty() && frame.has_ground() {
            texels.par_iter_mut().with_min_len(64).enumerate().for_each(|(i, texel)| {
                let (x, z) = ((i % width as usize) as f32, (i / width as usize) as f32);
                let step = 1.0 / grid.texels_per_angstrom;
                let p =
                    Vec3::new(grid.corner[0] + (x + 0.5) * step, frame.ground[0], grid.corner[1] + (z + 0.5) * step);
                *texel = [self.ground_shadow(frame, p), self.ground_open(frame, p)];
            });
        }
        GroundMap { size: grid.size, texels }
    }
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
