//! Light from afar for sixteen points at a time: the tubes of a scene, and which of the points see the light along them.

use super::behind::{Mask, behind_cone, behind_open_stick, behind_triangle};
use super::intersect::primitive_t;
use super::lanes::{LANES, Lanes, whole};
use crate::math::{max, min};
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
    /// Samples of a pixel.
    samples: u32,
}

impl Lights {
    /// Nothing is asked.
    pub(super) fn none() -> Lights {
        Lights::default()
    }

    /// Makes the tubes that are wanted, and keeps those that still hold for this scene.
    pub(super) fn update(&mut self, scene: &Scene, frame: &FrameConstants, settings: &Settings) {
        (self.center, self.samples) = (scene.bounds().center(), settings.samples);
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

    /// These directions of the sky alone, all asked by the one sample of a pixel.
    pub(super) fn of_sky(bounds: &Bounds, center: Vec3, directions: &[Vec3]) -> Lights {
        let turns = Turns { directions: directions.to_vec(), each: directions.len() as u32 };
        Lights { sky: (turns, tubes(bounds, center, directions)), center, samples: 1, ..Lights::default() }
    }

    /// What the samples of a view ask.
    pub(super) fn questions<'a>(&'a self, view: &View, solids: &'a Solids) -> Questions<'a> {
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
            solids,
            samples: self.samples,
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
    /// What may hide the light, view space: the primitives of the tubes.
    solids: &'a Solids,
    /// Samples of a pixel.
    samples: u32,
    center_in_view: Vec3,
}

/// Points that ask, view space.
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
    /// What they were told: parts of the sky and of the key light.
    pub(super) told: [Lanes; 2],
}

/// In place of [`Points::own`]: everything may hide the light.
pub(super) const NOBODY: u32 = u32::MAX;

/// Room for asking, used again and again.
#[derive(Debug, Default)]
pub(super) struct Asking {
    /// Weights of the directions that were free, and of all.
    seen: Vec<Lanes>,
    all: Vec<Lanes>,
    entries: Vec<Entry>,
    /// The first entry of each bucket of tubes, and those that have one.
    first: Vec<u32>,
    used: Vec<u32>,
}

/// A point that asks a direction.
#[derive(Debug, Clone, Copy)]
struct Entry {
    tube: u32,
    /// Which point: block and lane.
    point: u32,
    height: f32,
    weight: f32,
    /// The next of its bucket, or [`NONE`].
    next: u32,
}

const NONE: u32 = u32::MAX;
/// Buckets on a side: tubes this far apart share one.
const BUCKETS: u32 = 16;

impl Questions<'_> {
    /// Tells points how much of the sky and of the key light they see, as far as this sample of their pixels asks; `unasked`
    /// where nothing is asked, or all of it is behind the surface.
    #[inline(always)]
    pub(super) fn ask(&self, asking: &mut Asking, blocks: &mut [Points], sample: u32, unasked: Reach) {
        for (kind, light, unasked) in [(0, &self.sky, unasked.open), (1, &self.key, unasked.key)] {
            asking.seen.clear();
            asking.seen.resize(blocks.len(), [0.0; LANES]);
            asking.all.clear();
            asking.all.resize(blocks.len(), [0.0; LANES]);
            let start = light.turns.start(sample) as usize;
            for direction in start..start + light.turns.each as usize {
                let (tubes, axes) = (&light.tubes[direction], &light.axes[direction]);
                asking.entries.clear();
                for (points, number) in blocks.iter().zip(0..) {
                    self.enter(tubes, axes, kind == 0, points, number, asking);
                }
                self.answer(tubes, axes[2], asking, blocks, sample);
            }
            for ((block, seen), all) in blocks.iter_mut().zip(&asking.seen).zip(&asking.all) {
                let told = &mut block.told[kind];
                for lane in 0..LANES {
                    told[lane] = if all[lane] > 0.0 { seen[lane] / all[lane] } else { unasked };
                }
            }
        }
    }

    /// Finds the tubes of the points of a block that face a direction.
    #[inline(always)]
    fn enter(
        &self,
        tubes: &Tubes,
        [right, up, d]: &[Vec3; 3],
        is_weighted: bool,
        points: &Points,
        block: u32,
        asking: &mut Asking,
    ) {
        let center = self.center_in_view;
        let most = [(tubes.size[0] - 1) as f32, (tubes.size[1] - 1) as f32];
        let (mut weight, mut height, mut tube) = ([0.0f32; LANES], [0.0f32; LANES], [0u32; LANES]);
        let all = &mut asking.all[block as usize];
        for lane in 0..LANES {
            let n = [points.normal[0][lane], points.normal[1][lane], points.normal[2][lane]];
            let facing = max(n[0] * d.x + n[1] * d.y + n[2] * d.z, 0.0);
            all[lane] += if is_weighted { facing } else { 1.0 };
            weight[lane] = facing * points.asks[lane];
            let x = points.position[0][lane] - center.x;
            let y = points.position[1][lane] - center.y;
            let z = points.position[2][lane] - center.z;
            let along = |v: &Vec3| x * v.x + y * v.y + z * v.z;
            height[lane] = along(d);
            let column = (along(right) - tubes.corner[0]) * tubes.per_angstrom;
            let row = (along(up) - tubes.corner[1]) * tubes.per_angstrom;
            tube[lane] =
                whole(min(max(row.floor(), 0.0), most[1])) << 16 | whole(min(max(column.floor(), 0.0), most[0]));
        }
        for lane in 0..LANES {
            if weight[lane] > 0.0 {
                let weight = if is_weighted { weight[lane] } else { 1.0 };
                let point = block * LANES as u32 + lane as u32;
                asking.entries.push(Entry { tube: tube[lane], point, height: height[lane], weight, next: NONE });
            }
        }
    }

    /// Walks the tubes of the entries, up to [`LANES`] of one tube at a time.
    #[inline(always)]
    fn answer(&self, tubes: &Tubes, d: Vec3, asking: &mut Asking, blocks: &[Points], sample: u32) {
        let Asking { seen, entries, first, used, .. } = asking;
        first.resize((BUCKETS * BUCKETS) as usize, NONE);
        for (entry, at) in entries.iter_mut().zip(0..) {
            let bucket = (entry.tube >> 16) % BUCKETS * BUCKETS + entry.tube % BUCKETS;
            let head = &mut first[bucket as usize];
            if *head == NONE {
                used.push(bucket);
            }
            entry.next = *head;
            *head = at;
        }
        let base = self.center_in_view.dot(d);
        while let Some(bucket) = used.pop() {
            let mut head = std::mem::replace(&mut first[bucket as usize], NONE);
            while head != NONE {
                // The entries of one tube into the lanes; the others of the bucket wait for the next round.
                let tube = entries[head as usize].tube;
                let (mut count, mut waiting, mut low) = (0, NONE, f32::INFINITY);
                let mut lanes = [0u32; LANES];
                while head != NONE {
                    let entry = entries[head as usize];
                    if entry.tube == tube && count < LANES {
                        lanes[count] = head;
                        count += 1;
                        low = min(entry.height, low);
                    } else {
                        entries[head as usize].next = waiting;
                        waiting = head;
                    }
                    head = entry.next;
                }
                head = waiting;
                let (mut starts, mut free) = (Starts::default(), [0u32; LANES]);
                for (lane, &entry) in lanes[..count].iter().enumerate() {
                    let point = entries[entry as usize].point as usize;
                    let (of, at) = (&blocks[point / LANES], point % LANES);
                    for axis in 0..3 {
                        starts.position[axis][lane] = of.position[axis][at];
                    }
                    starts.own[lane] = of.own[at];
                    free[lane] = u32::MAX;
                }
                let list = tubes.of(((tube >> 16) * tubes.size[0] + (tube & 0xffff)) as usize);
                walk(list, d, low + base, (self.solids, [sample, self.samples]), &starts, &mut free);
                for (lane, &entry) in lanes[..count].iter().enumerate() {
                    let Entry { point, weight, .. } = entries[entry as usize];
                    let sum = &mut seen[point as usize / LANES][point as usize % LANES];
                    *sum += if free[lane] != 0 { weight } else { 0.0 };
                }
            }
        }
    }
}

/// Where the rays of one tube start.
#[derive(Debug, Clone, Copy, Default)]
struct Starts {
    position: [Lanes; 3],
    own: [u32; LANES],
}

/// Clears the lanes of `free` whose ray something in the list stands in the way of; `low` is the lowest start of theirs.
#[inline(always)]
fn walk(
    list: &[u32],
    d: Vec3,
    low: f32,
    (solids, [sample, samples]): (&Solids, [u32; 2]),
    points: &Starts,
    free: &mut Mask,
) {
    for &index in list {
        let i = index as usize;
        if !solids.hides(i, sample, samples) {
            continue;
        }
        let left = match solids.primitive(i) {
            Primitive::Sphere(s) => {
                let sphere = &solids.spheres[s];
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
                    if behind_open_stick(cylinder, d, &points.position, free) == 0 {
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
            other => {
                if Bound::of(solids, i).top(d) <= low {
                    break;
                }
                match other {
                    Primitive::Cone(c) => behind_cone(&solids.cones[c], index, d, &points.position, &points.own, free),
                    Primitive::Triangle(t) => behind_triangle(&solids.triangles[t], d, &points.position, free),
                    _ => behind_torus(solids, index, d, points, free),
                }
            }
        };
        if left == 0 {
            break;
        }
    }
}

/// Clears the lanes that a ball hides the light from; bits of those that are left.
#[inline(always)]
fn behind_sphere(c: Vec3, radius: f32, index: u32, d: Vec3, points: &Starts, free: &mut Mask) -> u32 {
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

/// Clears the lanes that a torus hides the light from, one by one, for it is searched for; bits of those that are left. It may hide
/// itself.
#[inline(never)]
fn behind_torus(solids: &Solids, index: u32, d: Vec3, points: &Starts, free: &mut Mask) -> u32 {
    let mut left = 0;
    for lane in 0..LANES {
        if free[lane] != 0 {
            let origin = Vec3::from(points.position.map(|axis| axis[lane]));
            let ray = Ray { origin, direction: d };
            free[lane] = if primitive_t(&ray, solids, index as usize, 0.0).is_finite() { 0 } else { free[lane] };
        }
        left |= free[lane];
    }
    left
}

/// Clears the lanes that a cylinder hides the light from (its ends taken as flat and closed); bits of those that are left.
/// `cosine` is that of axis and direction. A ray is free where the part of it inside of the endless cylinder (about its point
/// nearest to the axis) and the one between the planes of the ends do not overlap beyond its start.
#[inline(always)]
fn behind_cylinder(cylinder: &Cylinder, cosine: f32, index: u32, d: Vec3, points: &Starts, free: &mut Mask) -> u32 {
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

#[cfg(test)]
#[path = "reach_tests.rs"]
mod tests;
