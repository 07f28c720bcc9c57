//! Light from afar for sixteen points at a time: the tubes of a scene, and which of the points see the light along them.

use super::intersect::primitive_t;
use super::lanes::{LANES, Lanes, max, min, whole};
use crate::render::frame::FrameConstants;
use crate::render::settings::{Settings, View};
use crate::render::sky::{Reach, Turns};
use crate::render::solids::{Cylinder, Primitive, Solids};
use crate::render::tubes::{Bound, Bounds, Tubes, tubes};
use crate::scene::{Ray, Scene};
use glam::{Affine3A, Vec3};

/// The tubes of a scene under one light.
#[derive(Debug, Default)]
pub(super) struct Lights {
    sky: (Turns, Vec<Tubes>),
    /// Directions and samples that `sky` is made for.
    sky_of: [u32; 2],
    key: (Turns, Vec<Tubes>),
    /// The light that `key` is made for, and samples.
    key_of: (Vec3, u32),
    center: Vec3,
}

impl Lights {
    /// Nothing is asked.
    pub(super) fn none() -> Lights {
        Lights::default()
    }

    /// Makes the tubes that are wanted, and keeps those that still hold for this scene.
    pub(super) fn update(&mut self, scene: &Scene, frame: &FrameConstants, settings: &Settings) {
        self.center = scene.bounds().center();
        let sky = [settings.ao.min(Settings::MOST_DIRECTIONS), settings.samples];
        let key = (if settings.shadow { frame.key_in_world() } else { Vec3::ZERO }, settings.samples);
        if sky == self.sky_of && key == self.key_of {
            return;
        }
        let bounds = Bounds::new(&Solids::new(scene, Affine3A::IDENTITY));
        if sky != self.sky_of {
            self.sky = Default::default(); // the old ones go first
            let turns = Turns::of_sky(sky[0], sky[1]);
            let tubes = tubes(&bounds, self.center, &turns.directions);
            (self.sky, self.sky_of) = ((turns, tubes), sky);
        }
        if key != self.key_of {
            self.key = Default::default();
            let turns = if settings.shadow { Turns::of_key(key.0, key.1) } else { Turns::default() };
            let tubes = tubes(&bounds, self.center, &turns.directions);
            (self.key, self.key_of) = ((turns, tubes), key);
        }
    }

    /// What the samples of a view ask.
    pub(super) fn questions(&self, view: &View, solids: &Solids) -> Questions<'_> {
        let view_from_world = view.camera.view_from_world();
        let turned = |(turns, tubes): &'_ (Turns, Vec<Tubes>)| {
            let axis = |v: Vec3| view_from_world.transform_vector3(v);
            let directions = tubes.iter().map(|t| [axis(t.right), axis(t.up), axis(t.toward)]).collect();
            (if tubes.is_empty() || solids.is_empty() { Turns::default() } else { turns.clone() }, directions)
        };
        let ((sky_turns, sky_axes), (key_turns, key_axes)) = (turned(&self.sky), turned(&self.key));
        Questions {
            sky: Light { turns: sky_turns, tubes: &self.sky.1, axes: sky_axes },
            key: Light { turns: key_turns, tubes: &self.key.1, axes: key_axes },
            center_in_view: view_from_world.transform_point3(self.center),
        }
    }
}

/// Directions that samples ask in turn, their tubes, and the axes of these in view space.
struct Light<'a> {
    turns: Turns,
    tubes: &'a [Tubes],
    axes: Vec<[Vec3; 3]>,
}

/// What the samples of a view ask.
pub(super) struct Questions<'a> {
    sky: Light<'a>,
    key: Light<'a>,
    center_in_view: Vec3,
}

/// Points that are asked together, view space.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Points {
    /// Where rays start.
    pub(super) position: [Lanes; 3],
    /// Unit normals.
    pub(super) normal: [Lanes; 3],
    /// The primitive whose surface it is: being convex it does not hide itself.
    pub(super) own: [u32; LANES],
    /// 1 for points that ask, 0 for others.
    pub(super) asks: Lanes,
}

impl Questions<'_> {
    /// Open sky and key light of each point, asked by this sample of their pixels; `unasked` where nothing is asked, or all of
    /// it is behind the surface.
    #[inline(always)]
    pub(super) fn ask(&self, solids: &Solids, points: &Points, sample: u32, unasked: Reach) -> [Lanes; 2] {
        [
            self.part::<true>(&self.sky, solids, points, sample, unasked.open),
            self.part::<false>(&self.key, solids, points, sample, unasked.key),
        ]
    }

    #[inline(always)]
    fn part<const WEIGHTED: bool>(
        &self,
        light: &Light<'_>,
        solids: &Solids,
        points: &Points,
        sample: u32,
        unasked: f32,
    ) -> Lanes {
        let (mut seen, mut all) = ([0.0f32; LANES], [0.0f32; LANES]);
        let start = light.turns.start(sample) as usize;
        for direction in start..start + light.turns.each as usize {
            let axes = &light.axes[direction];
            let d = axes[2];
            let (mut weight, mut any) = ([0.0f32; LANES], 0u32);
            for lane in 0..LANES {
                let cosine = points.normal[0][lane] * d.x + points.normal[1][lane] * d.y + points.normal[2][lane] * d.z;
                let facing = if cosine > 0.0 { cosine } else { 0.0 };
                all[lane] += if WEIGHTED { facing } else { 1.0 };
                weight[lane] = facing * points.asks[lane];
                any |= u32::from(weight[lane] > 0.0);
            }
            if any != 0 {
                let free = self.free(&light.tubes[direction], axes, solids, points, &weight);
                for lane in 0..LANES {
                    let full = if WEIGHTED { weight[lane] } else { 1.0 };
                    seen[lane] += if free[lane] != 0 { full } else { 0.0 };
                }
            }
        }
        let mut part = [unasked; LANES];
        for lane in 0..LANES {
            part[lane] = if all[lane] > 0.0 { seen[lane] / all[lane] } else { unasked };
        }
        part
    }

    /// Of the points with a weight, which see the light: all bits set, or none.
    #[inline(always)]
    fn free(&self, tubes: &Tubes, axes: &[Vec3; 3], solids: &Solids, points: &Points, weight: &Lanes) -> Mask {
        let (mut height, mut tube) = ([0.0f32; LANES], [0i32; LANES]);
        let center = self.center_in_view;
        let most = [(tubes.size[0] - 1) as f32, (tubes.size[1] - 1) as f32];
        let mut free = [0u32; LANES];
        for lane in 0..LANES {
            let x = points.position[0][lane] - center.x;
            let y = points.position[1][lane] - center.y;
            let z = points.position[2][lane] - center.z;
            let along = |v: Vec3| x * v.x + y * v.y + z * v.z;
            height[lane] = along(axes[2]);
            let column = (along(axes[0]) - tubes.corner[0]) * tubes.per_angstrom;
            let row = (along(axes[1]) - tubes.corner[1]) * tubes.per_angstrom;
            let column = min(max(column.floor(), 0.0), most[0]);
            let row = min(max(row.floor(), 0.0), most[1]);
            tube[lane] = (whole(row) * tubes.size[0] + whole(column)) as i32;
            free[lane] = if weight[lane] > 0.0 { u32::MAX } else { 0 };
        }
        // Neighbours on the picture are mostly in one tube; where not, one tube after the other.
        let mut waiting = free;
        for lane in 0..LANES {
            if waiting[lane] == 0 {
                continue;
            }
            let this = tube[lane];
            let (mut here, mut low) = ([0u32; LANES], [f32::INFINITY; 4]);
            for other in 0..LANES {
                let same = if tube[other] == this { waiting[other] } else { 0 };
                here[other] = same;
                waiting[other] &= !same;
            }
            for other in 0..LANES {
                let height = if here[other] != 0 { height[other] } else { f32::INFINITY };
                low[other % 4] = min(height, low[other % 4]);
            }
            let low = min(min(low[0], low[1]), min(low[2], low[3]));
            let asking = here;
            walk(tubes.of(this as usize), axes[2], low + center.dot(axes[2]), solids, points, &mut here);
            for other in 0..LANES {
                free[other] &= here[other] | !asking[other];
            }
        }
        free
    }
}

/// All bits of a lane, or none.
type Mask = [u32; LANES];

/// Clears the lanes of `free` whose ray something in the list stands in the way of; `low` is the lowest start of theirs.
#[inline(always)]
fn walk(list: &[u32], d: Vec3, low: f32, solids: &Solids, points: &Points, free: &mut Mask) {
    for &index in list {
        let i = index as usize;
        let left = match solids.primitive(i) {
            Primitive::Sphere(i) => {
                let sphere = &solids.spheres[i];
                if sphere.center.dot(d) + sphere.radius <= low {
                    break; // neither this one nor those after it reach up to the points
                }
                behind_sphere(sphere.center, sphere.radius, index, d, points, free)
            }
            Primitive::Cylinder(c) => {
                let cylinder = &solids.cylinders[c];
                let cosine = cylinder.axis().dot(d);
                if cylinder.center.dot(d) + cylinder.half_length * cosine.abs() + cylinder.radius <= low {
                    break;
                }
                if cylinder.is_open() {
                    if behind_other(solids, i, d, points, free) == 0 {
                        break;
                    }
                    continue;
                }
                let mut left = behind_cylinder(cylinder, cosine, index, d, points, free);
                for (end, round) in cylinder.ends().into_iter().zip(cylinder.round()) {
                    if round {
                        left = behind_sphere(end, cylinder.radius, index, d, points, free);
                    }
                }
                left
            }
            _ => {
                if Bound::of(solids, i).top(d) <= low {
                    break;
                }
                behind_other(solids, i, d, points, free)
            }
        };
        if left == 0 {
            break;
        }
    }
}

/// Clears the lanes that a ball hides the light from; bits of those that are left.
#[inline(always)]
fn behind_sphere(c: Vec3, radius: f32, index: u32, d: Vec3, points: &Points, free: &mut Mask) -> u32 {
    let r2 = radius * radius;
    let [px, py, pz] = &points.position;
    let mut left = 0;
    for lane in 0..LANES {
        let (x, y, z) = (c.x - px[lane], c.y - py[lane], c.z - pz[lane]);
        let along = x * d.x + y * d.y + z * d.z;
        let away = x * x + y * y + z * z;
        // Either the ray starts inside, or the ball is ahead and near enough to the ray.
        let hit = (away < r2) | ((along > 0.0) & (away - along * along < r2));
        let hides = hit & (points.own[lane] != index);
        free[lane] = if hides { 0 } else { free[lane] };
        left |= free[lane];
    }
    left
}

/// Clears the lanes that a cone, torus, triangle or open stick hides the light from; bits of those that are left. A torus, a
/// mesh and the inside of a stick may hide themselves.
fn behind_other(solids: &Solids, index: usize, d: Vec3, points: &Points, free: &mut Mask) -> u32 {
    let mut left = 0;
    for lane in 0..LANES {
        if free[lane] != 0 {
            let origin = Vec3::new(points.position[0][lane], points.position[1][lane], points.position[2][lane]);
            if primitive_t(&Ray { origin, direction: d }, solids, index, 0.0).is_finite() {
                free[lane] = 0;
            }
        }
        left |= free[lane];
    }
    left
}

/// Clears the lanes that a cylinder hides the light from (its ends taken as flat and closed); bits of those that are left.
/// `cosine` is that of axis and direction. A ray is free where the part of it inside of the endless cylinder (about its point
/// nearest to the axis) and the one between the planes of the ends do not overlap beyond its start.
#[inline(always)]
fn behind_cylinder(cylinder: &Cylinder, cosine: f32, index: u32, d: Vec3, points: &Points, free: &mut Mask) -> u32 {
    let (c, a, h, radius) = (cylinder.center, cylinder.axis(), cylinder.half_length, cylinder.radius);
    let n = a.cross(d);
    let sine2 = n.dot(n);
    // Along the axis within 1e-3 rad a ray is inside for ever or never.
    let (parallel, flat) = (sine2 < 1e-6, cosine.abs() < 1e-6);
    let over_sine2 = if parallel { 0.0 } else { 1.0 / sine2 };
    let over_cosine = if flat { 0.0 } else { 1.0 / cosine };
    let wide = f32::MAX;
    let [px, py, pz] = &points.position;
    let mut left = 0;
    for lane in 0..LANES {
        let (x, y, z) = (px[lane] - c.x, py[lane] - c.y, pz[lane] - c.z);
        let across = x * n.x + y * n.y + z * n.z;
        let up = x * a.x + y * a.y + z * a.z;
        let ahead = x * d.x + y * d.y + z * d.z;
        let away = x * x + y * y + z * z - ahead * ahead;
        let inside = if parallel { radius * radius - away } else { radius * radius * sine2 - across * across };
        let middle = (up * cosine - ahead) * over_sine2;
        let half = if parallel { wide } else { max(inside, 0.0).sqrt() * over_sine2 };
        let (to_a, to_b) = ((-h - up) * over_cosine, (h - up) * over_cosine);
        let level = if up.abs() < h { wide } else { -wide };
        let (near, far) = (min(to_a, to_b), max(to_a, to_b));
        let (near, far) = (if flat { -level } else { near }, if flat { level } else { far });
        let (entry, exit) = (max(middle - half, near), min(middle + half, far));
        let hides = (inside > 0.0) & (entry < exit) & (exit > 0.0) & (points.own[lane] != index);
        free[lane] = if hides { 0 } else { free[lane] };
        left |= free[lane];
    }
    left
}
