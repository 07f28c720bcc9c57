//! Light from afar for sixteen points at a time: which directions the samples of a picture ask, and which of the points see
//! the light along them.

use super::behind::{Mask, behind};
use super::bunches::{Copies, InView};
use super::casters::{self, Axes, Body, Starts};
use super::clusters::{self, Clusters, Order};
use super::lanes::{LANES, Lanes};
use crate::math::{max, min, whole};
use crate::render::frame::FrameConstants;
use crate::render::settings::{Settings, View};
use crate::render::sky::{Reach, Turns, across};
use crate::render::solids::Solids;
use crate::render::tubes::{Tubes, width_of};
use crate::scene::Scene;
use glam::{Affine3A, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Bytes of sights of clusters that are kept at once. Chosen: proteins of some 300,000 atoms keep all of 64 + 16 directions.
const MOST_BYTES: usize = 256 << 20;

/// The same of primitives one by one, which are asked all over. Measured on a protein of 10,000 atoms with 32 MB of cache on two cores: 24 MB
/// take a tenth less than everything at once (77 MB), 6 MB as much.
const MOST_BYTES_EACH: usize = 24 << 20;

/// The same of bunches of copies. Chosen: what 60 copies of 100,000 atoms ask in four samples at a time, as much as one copy keeps of all.
const MOST_BYTES_COPIES: usize = 96 << 20;

/// From so many primitives on they are asked in clusters. Chosen between what was measured on proteins: with 20,000 primitives a still
/// takes a third longer so, with 200,000 a quarter less, with two million a third of the time.
const MANY: usize = 100_000;

/// What is asked of a scene under one light, and what was found out about it.
#[derive(Debug, Default)]
pub(super) struct Lights {
    sky: Light,
    /// Directions and samples that `sky` is for.
    sky_of: [u32; 2],
    key: Light,
    /// The light that `key` is for, and samples.
    key_of: (Vec3, u32),
    /// Samples of a pixel.
    samples: u32,
    /// Of a large scene, which primitives make clusters.
    order: Order,
}

/// Directions that samples ask in turn.
#[derive(Debug, Default)]
struct Light {
    turns: Turns,
    /// What each direction shows, of those that samples ask at the moment.
    sights: Vec<Option<Sight>>,
}

/// What a direction shows: each primitive, clusters of them, or bunches of clusters.
#[derive(Debug)]
enum Sight {
    Each(casters::Sight),
    Clusters(clusters::Sight),
    Bunches(clusters::Sight),
}

impl Sight {
    #[inline(always)]
    fn tubes(&self) -> &Tubes {
        match self {
            Sight::Each(sight) => &sight.tubes,
            Sight::Clusters(sight) | Sight::Bunches(sight) => &sight.tubes,
        }
    }
}

impl Light {
    fn new(turns: Turns) -> Light {
        let sights = turns.directions.iter().map(|_| None).collect();
        Light { turns, sights }
    }
}

/// Places of the directions that a sample asks.
fn of_sample(turns: &Turns, sample: u32) -> Range<usize> {
    let start = turns.start(sample) as usize;
    start..start + turns.each as usize
}

/// Whether there are so many bytes, with half as many for all else. Under a limit of the process' memory (`ulimit -v`, `ulimit -d`) it
/// may not be so; a system without limits gives what is never touched.
fn can_be_had(bytes: usize) -> bool {
    Vec::<u8>::new().try_reserve_exact(bytes.saturating_add(bytes / 2)).is_ok()
}

impl Lights {
    /// Nothing is asked.
    pub(super) fn none() -> Lights {
        Lights::default()
    }

    /// These directions of the sky alone, all asked by the one sample of a pixel.
    pub(super) fn of_sky(directions: &[Vec3]) -> Lights {
        let turns = Turns { directions: directions.to_vec(), each: directions.len() as u32 };
        Lights { sky: Light::new(turns), samples: 1, ..Lights::default() }
    }

    /// Whether anything is asked.
    pub(super) fn asks(&self) -> bool {
        self.sky.turns.each + self.key.turns.each > 0
    }

    /// Sets what is asked, and keeps what was found out if it still holds for this scene.
    pub(super) fn update(&mut self, frame: &FrameConstants, settings: &Settings) {
        self.samples = settings.samples;
        let sky = [settings.ao.min(Settings::MOST_DIRECTIONS), settings.samples];
        if sky != self.sky_of {
            (self.sky, self.sky_of) = (Light::new(Turns::of_sky(sky[0], sky[1])), sky);
        }
        let key = (if settings.shadow { frame.key_in_world() } else { Vec3::ZERO }, settings.samples);
        if key != self.key_of {
            let turns = if settings.shadow { Turns::of_key(key.0, key.1) } else { Turns::default() };
            (self.key, self.key_of) = (Light::new(turns), key);
        }
    }

    /// The samples of a picture in parts whose directions are looked along at once.
    pub(super) fn parts(&self, shadows: &Shadows<'_>, samples: u32) -> Vec<Range<u32>> {
        let (bytes, most_bytes) = match &shadows.crowd {
            Crowd::Each(bodies) => (casters::Sight::bytes(bodies.len()), MOST_BYTES_EACH),
            Crowd::Clusters(clusters) => (clusters::Sight::bytes(clusters.len()), MOST_BYTES),
            Crowd::Copies(copies) => (clusters::Sight::bytes(copies.len()), MOST_BYTES_COPIES),
        };
        let all = (self.sky.sights.len() + self.key.sights.len()) * bytes;
        let one = (self.sky.turns.each + self.key.turns.each) as usize * bytes;
        let is_possible = |bytes: usize| bytes <= most_bytes && can_be_had(bytes);
        let most = [16, 4].into_iter().find(|&part| is_possible(part as usize * one)).unwrap_or(1);
        let part = if is_possible(all) { samples } else { most };
        (0..samples).step_by(part as usize).map(|start| start..samples.min(start + part)).collect()
    }
}

/// What may hide the light in a view.
pub(super) struct Shadows<'a> {
    /// In view space.
    solids: &'a Solids,
    view_from_world: Affine3A,
    center_in_view: Vec3,
    crowd: Crowd<'a>,
}

/// The primitives one by one, in clusters, or in bunches of them as they stand in their blocks.
enum Crowd<'a> {
    Each(Vec<Body>),
    Clusters(Clusters),
    Copies(InView<'a>),
}

impl Crowd<'_> {
    fn is_empty(&self) -> bool {
        match self {
            Crowd::Each(bodies) => bodies.is_empty(),
            Crowd::Clusters(clusters) => clusters.len() == 0,
            Crowd::Copies(copies) => copies.len() == 0,
        }
    }
}

impl<'a> Shadows<'a> {
    /// For what `lights` ask: of the copies, if these are known, else of the solids, which are all primitives.
    pub(super) fn new(
        scene: &Scene,
        view: &View,
        (solids, copies): (&'a Solids, Option<&'a Copies>),
        lights: &mut Lights,
    ) -> Shadows<'a> {
        let Some(copies) = copies else { return Shadows::with(scene, view, solids, lights, MANY) };
        let view_from_world = view.camera.view_from_world();
        let center_in_view = view_from_world.transform_point3(scene.bounds().center());
        let crowd = Crowd::Copies(copies.in_view(&view_from_world.inverse()));
        Shadows { crowd, solids, view_from_world, center_in_view }
    }

    /// In clusters from so many primitives on.
    fn with(scene: &Scene, view: &View, solids: &'a Solids, lights: &mut Lights, many: usize) -> Shadows<'a> {
        let view_from_world = view.camera.view_from_world();
        let center_in_view = view_from_world.transform_point3(scene.bounds().center());
        let bodies = if lights.asks() { Body::all(solids) } else { Vec::new() };
        let crowd = if bodies.len() < many {
            Crowd::Each(bodies)
        } else {
            if lights.order.len() != bodies.len() {
                lights.order = Order::new(&bodies);
            }
            Crowd::Clusters(Clusters::new(&bodies, &lights.order, solids))
        };
        Shadows { crowd, solids, view_from_world, center_in_view }
    }

    fn axes(&self, toward_in_world: Vec3) -> Axes {
        let [right, up] = across(toward_in_world);
        let [right, up, toward] = [right, up, toward_in_world].map(|v| self.view_from_world.transform_vector3(v));
        Axes { right, up, toward, center: self.center_in_view }
    }

    /// Looks along the directions that these samples ask and no others.
    pub(super) fn look<'l>(&'l self, lights: &'l mut Lights, samples: &Range<u32>) -> Questions<'l> {
        let Lights { sky, key, samples: of_pixel, .. } = lights;
        let mut wanted = Vec::new();
        for Light { turns, sights } in [&mut *sky, &mut *key] {
            for (direction, sight) in sights.iter_mut().enumerate() {
                let is_asked = samples.clone().any(|sample| of_sample(turns, sample).contains(&direction));
                match sight {
                    Some(_) if !is_asked => *sight = None,
                    None if is_asked && !self.crowd.is_empty() => wanted.push((turns.directions[direction], sight)),
                    _ => {}
                }
            }
        }
        // Of all primitives: not where everything is known.
        let width = if wanted.is_empty() { 0.0 } else { width_of(self.solids) };
        wanted.into_par_iter().with_max_len(1).for_each(|(toward, sight)| {
            let axes = self.axes(toward);
            *sight = Some(match &self.crowd {
                Crowd::Each(bodies) => Sight::Each(casters::Sight::new(bodies, self.solids, &axes, width)),
                Crowd::Clusters(clusters) => Sight::Clusters(clusters::Sight::new(clusters, &axes)),
                Crowd::Copies(copies) => Sight::Bunches(copies.sight(&axes)),
            });
        });
        let of = |toward: Vec3, sight: &'l Option<Sight>| {
            let (axes, sight) = (self.axes(toward), sight.as_ref()?);
            let of_copies = if let Crowd::Copies(copies) = &self.crowd { copies.axes(&axes) } else { Vec::new() };
            Some(Along { axes, of_copies, sight })
        };
        let seen = |light: &'l Light| Seen {
            turns: &light.turns,
            sights: (light.turns.directions.iter().zip(&light.sights))
                .map(|(&toward, sight)| of(toward, sight))
                .collect(),
        };
        Questions { sky: seen(sky), key: seen(key), solids: self.solids, samples: *of_pixel, crowd: &self.crowd }
    }
}

/// A light whose directions were looked along.
struct Seen<'a> {
    turns: &'a Turns,
    sights: Vec<Option<Along<'a>>>,
}

/// A direction that was looked along.
struct Along<'a> {
    axes: Axes,
    /// The same as each placement's block sees them, if copies are asked.
    of_copies: Vec<Axes>,
    sight: &'a Sight,
}

/// What the samples of a view ask.
pub(super) struct Questions<'a> {
    sky: Seen<'a>,
    key: Seen<'a>,
    /// What may hide the light, view space.
    solids: &'a Solids,
    /// Samples of a pixel.
    samples: u32,
    /// What the sights are of.
    crowd: &'a Crowd<'a>,
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

impl Questions<'_> {
    /// Tells points how much of the sky and of the key light they see, as far as this sample of their pixels asks; `unasked`
    /// where nothing is asked, or all of it is behind the surface.
    #[inline(always)]
    pub(super) fn ask(&self, points: &mut Points, sample: u32, unasked: Reach) {
        for (kind, light, unasked) in [(0, &self.sky, unasked.open), (1, &self.key, unasked.key)] {
            let (mut seen, mut all) = ([0.0f32; LANES], [0.0f32; LANES]);
            for along in light.sights[of_sample(light.turns, sample)].iter().flatten() {
                self.ask_one(along, [u32::from(kind == 0), sample], points, (&mut seen, &mut all));
            }
            let told = &mut points.told[kind];
            for lane in 0..LANES {
                told[lane] = if all[lane] > 0.0 { seen[lane] / all[lane] } else { unasked };
            }
        }
    }

    /// Asks one direction: adds its weight to `all`, and to `seen` where it is free.
    #[inline(always)]
    fn ask_one(
        &self,
        Along { axes, of_copies, sight }: &Along<'_>,
        [is_weighted, sample]: [u32; 2],
        points: &Points,
        (seen, all): (&mut Lanes, &mut Lanes),
    ) {
        let (tubes, Axes { right, up, toward, center }) = (sight.tubes(), axes);
        let most = [(tubes.size[0] - 1) as f32, (tubes.size[1] - 1) as f32];
        let (mut weight, mut free, mut tube) = ([0.0f32; LANES], [0u32; LANES], [0u32; LANES]);
        let mut at = Starts { x: [0.0; LANES], y: [0.0; LANES], height: [0.0; LANES] };
        let mut asking = 0;
        for lane in 0..LANES {
            let [nx, ny, nz] = [points.normal[0][lane], points.normal[1][lane], points.normal[2][lane]];
            let facing = max(nx * toward.x + ny * toward.y + nz * toward.z, 0.0);
            weight[lane] = if is_weighted != 0 { facing } else { 1.0 };
            all[lane] += weight[lane];
            free[lane] = if facing * points.asks[lane] > 0.0 { u32::MAX } else { 0 };
            asking |= free[lane];
        }
        if asking == 0 {
            return;
        }
        for (lane, tube) in tube.iter_mut().enumerate() {
            let x = points.position[0][lane] - center.x;
            let y = points.position[1][lane] - center.y;
            let z = points.position[2][lane] - center.z;
            at.x[lane] = x * right.x + y * right.y + z * right.z;
            at.y[lane] = x * up.x + y * up.y + z * up.z;
            at.height[lane] = x * toward.x + y * toward.y + z * toward.z;
            let column = (at.x[lane] - tubes.corner[0]) * tubes.per_angstrom;
            let row = (at.y[lane] - tubes.corner[1]) * tubes.per_angstrom;
            let (column, row) = (min(max(column.floor(), 0.0), most[0]), min(max(row.floor(), 0.0), most[1]));
            *tube = whole(row) * tubes.size[0] + whole(column);
        }
        let exactly = |index: u32, free: &mut Mask| {
            if self.solids.hides(index as usize, sample, self.samples) {
                behind(self.solids, index, *toward, points, free);
            }
        };
        // The lanes of one tube at a time; neighbouring pixels mostly share one.
        for lane in 0..LANES {
            if free[lane] == 0 {
                continue;
            }
            let (mut here, mut others) = ([0u32; LANES], 0);
            for other in 0..LANES {
                let same = tube[other] == tube[lane];
                here[other] = if same { free[other] } else { 0 };
                others |= if same { 0 } else { free[other] };
                free[other] = if same { 0 } else { free[other] };
            }
            match (sight, self.crowd) {
                (Sight::Each(sight), _) => sight.walk(tube[lane], &at, &mut here, exactly),
                (Sight::Clusters(sight), Crowd::Clusters(of)) => {
                    sight.walk(of, axes, tube[lane], &at, &mut here, exactly);
                }
                (Sight::Bunches(sight), Crowd::Copies(of)) => {
                    of.walk((sight, of_copies), tube[lane], (&at, points), [sample, self.samples], &mut here);
                }
                _ => {}
            }
            for other in 0..LANES {
                seen[other] += if here[other] != 0 { weight[other] } else { 0.0 };
            }
            if others == 0 {
                break;
            }
        }
    }
}

#[cfg(test)]
#[path = "reach_tests.rs"]
mod tests;
