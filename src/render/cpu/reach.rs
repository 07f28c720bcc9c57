//! Light from afar: which directions the samples of a picture ask, and what points are told that asked them.

use super::behind::Mask;
use super::bodies::{Axes, InView};
use super::hiders::Hiders;
use super::lanes::{LANES, Lanes, bits};
use super::rays::{Gathered, Rays, Starts};
use super::simd::{Work, widest};
use crate::math::{Aabb, max};
use crate::render::frame::FrameConstants;
use crate::render::settings::{Settings, View};
use crate::render::sky::{Reach, Turns};
use crate::scene::Scene;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// The directions that the samples of a picture ask.
#[derive(Debug, Default)]
pub(super) struct Lights {
    sky: Turns,
    /// Directions and samples that `sky` is for.
    sky_of: [u32; 2],
    key: Turns,
    /// The light that `key` is for, and samples.
    key_of: (Vec3, u32),
    /// Samples of a pixel.
    samples: u32,
}

impl Lights {
    /// Nothing is asked.
    pub(super) fn none() -> Lights {
        Lights::default()
    }

    /// These directions of the sky alone, all asked by the one sample of a pixel.
    pub(super) fn of_sky(directions: &[Vec3]) -> Lights {
        let sky = Turns { directions: directions.to_vec(), each: directions.len() as u32 };
        Lights { sky, samples: 1, ..Lights::default() }
    }

    /// Those of the sky and of the key light.
    pub(super) fn directions(&self) -> [&Turns; 2] {
        [&self.sky, &self.key]
    }

    /// Samples of a pixel.
    pub(super) fn samples(&self) -> u32 {
        self.samples
    }

    /// Whether anything is asked.
    pub(super) fn asks(&self) -> bool {
        self.sky.each + self.key.each > 0
    }

    /// Sets what is asked.
    pub(super) fn update(&mut self, frame: &FrameConstants, settings: &Settings) {
        self.samples = settings.samples;
        let sky = [settings.ao.min(Settings::MOST_DIRECTIONS), settings.samples];
        if sky != self.sky_of {
            (self.sky, self.sky_of) = (Turns::of_sky(sky[0], sky[1]), sky);
        }
        let key = (if settings.shadow { frame.key_in_world() } else { Vec3::ZERO }, settings.samples);
        if key != self.key_of {
            let turns = if settings.shadow { Turns::of_key(key.0, key.1) } else { Turns::default() };
            (self.key, self.key_of) = (turns, key);
        }
    }
}

/// Points that ask, view space.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Points {
    /// Where rays start.
    pub(super) position: [Lanes; 3],
    /// Unit normals.
    pub(super) normal: [Lanes; 3],
    /// 1 for points that ask, 0 for others.
    pub(super) asks: Lanes,
    /// What they were told: parts of the sky and of the key light.
    pub(super) told: [Lanes; 2],
}

/// Points that ask together, sixteen in a packet.
pub(super) trait Packets: Sync {
    /// How many runs of packets there are. The packets are numbered through all of them.
    fn runs(&self) -> usize;

    /// How many packets a run has.
    fn len_of(&self, run: usize) -> usize;

    /// The box around all that ask, view space.
    fn bounds(&self) -> Aabb;

    /// One of them; what its points were told does not matter.
    fn points(&self, run: usize, packet: usize) -> Points;
}

/// What may hide the light in a view.
pub(super) struct Shadows<'a> {
    hiders: &'a Hiders,
    in_view: InView,
    rooms: Mutex<Rooms>,
}

/// Room to work in that no thread uses.
#[derive(Default)]
struct Rooms {
    rays: Vec<Rays>,
    points: Vec<Vec<Starts>>,
}

/// A direction that was asked, view space, and of each packet the points that see the light along it.
struct Answer {
    toward: Vec3,
    free: Vec<u16>,
}

/// What the points of a sample are told.
#[derive(Default)]
pub(super) struct Answers {
    sky: Vec<Answer>,
    key: Vec<Answer>,
}

impl<'a> Shadows<'a> {
    pub(super) fn new(scene: &Scene, view: &View, hiders: &'a Hiders) -> Shadows<'a> {
        Shadows { hiders, in_view: InView::new(scene, view), rooms: Mutex::default() }
    }

    /// Does something with the rooms that are free.
    fn room<R>(&self, work: impl FnOnce(&mut Rooms) -> R) -> R {
        // Nobody leaves the lists half-changed behind.
        work(&mut self.rooms.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// What the points of some samples, given with their numbers, are told; of no use if `stop` became true meanwhile.
    pub(super) fn answers<P: Packets>(&self, lights: &Lights, samples: &[(u32, P)], stop: &AtomicBool) -> Vec<Answers> {
        let mut all: Vec<Answers> = samples.iter().map(|_| Answers::default()).collect();
        if self.hiders.is_empty() {
            return all;
        }
        let world_from_view = self.in_view.view_from_world.inverse();
        let tell = |(answers, (sample, packets)): (&mut Answers, &(u32, P))| {
            let sky = lights.sky.of_sample(*sample);
            let directions = [sky, lights.key.of_sample(*sample)].concat();
            let bounds = packets.bounds();
            let mut asked: Vec<(Axes, Gathered)> = directions
                .iter()
                .map(|&toward| {
                    let (axes, room) = (self.in_view.axes(toward), self.room(|rooms| rooms.points.pop()));
                    (axes, Gathered::new(axes.extent(&bounds), room.unwrap_or_default()))
                })
                .collect();
            widest(Gather { packets, asked: &mut asked });
            let count = (0..packets.runs()).map(|run| packets.len_of(run)).sum();
            let ask = |(axes, points): (Axes, Gathered)| {
                let mut free = vec![0u16; count];
                if stop.load(Ordering::Relaxed) {
                    return Answer { toward: axes.toward, free };
                }
                let see = |number: u32| free[number as usize / LANES] |= 1 << (number % LANES as u32);
                let mut rays = self.room(|rooms| rooms.rays.pop()).unwrap_or_default();
                let of = [*sample, lights.samples];
                self.hiders.free((&points, &mut rays), (&axes, &world_from_view), of, see);
                self.room(|rooms| {
                    rooms.rays.push(rays);
                    rooms.points.push(points.into_room());
                });
                Answer { toward: axes.toward, free }
            };
            let mut found: Vec<Answer> = asked.into_par_iter().with_max_len(1).map(ask).collect();
            answers.key = found.split_off(sky.len());
            answers.sky = found;
        };
        // No more samples at a time than threads: the points of each take some 40 MB at 1920 × 1080.
        let some = rayon::current_num_threads().max(1);
        for (answers, samples) in all.chunks_mut(some).zip(samples.chunks(some)) {
            answers.par_iter_mut().zip(samples).with_max_len(1).for_each(tell);
        }
        all
    }
}

impl Answers {
    /// Tells points, those of a packet, how much of the sky and of the key light they see, as far as their sample asked;
    /// `unasked` where nothing is asked, or all of it is behind the surface.
    #[inline(always)]
    pub(super) fn tell(&self, packet: usize, points: &mut Points, unasked: Reach) {
        for (kind, answers, unasked) in [(0, &self.sky, unasked.open), (1, &self.key, unasked.key)] {
            let (mut seen, mut all) = ([0.0f32; LANES], [0.0f32; LANES]);
            for Answer { toward, free } in answers {
                let (facing, is_asked) = facing(points, *toward);
                let free = free.get(packet).map_or(0, |&free| u32::from(free));
                for lane in 0..LANES {
                    let weight = if kind == 0 { facing[lane] } else { 1.0 };
                    all[lane] += weight;
                    let sees = (is_asked[lane] != 0) & (free >> lane & 1 != 0);
                    seen[lane] += if sees { weight } else { 0.0 };
                }
            }
            points.told[kind] = share(&seen, &all, unasked);
        }
    }
}

/// What points are told that see so much of all that they asked; `unasked` where that is nothing.
#[inline(always)]
pub(super) fn share(seen: &Lanes, all: &Lanes, unasked: f32) -> Lanes {
    let mut told = [0.0; LANES];
    for lane in 0..LANES {
        told[lane] = if all[lane] > 0.0 { seen[lane] / all[lane] } else { unasked };
    }
    told
}

/// Cosines of points' normals with a direction, not below 0, and which points ask it.
#[inline(always)]
pub(super) fn facing(points: &Points, toward: Vec3) -> (Lanes, Mask) {
    let (mut facing, mut asks) = ([0.0f32; LANES], [0u32; LANES]);
    for lane in 0..LANES {
        let [nx, ny, nz] = [points.normal[0][lane], points.normal[1][lane], points.normal[2][lane]];
        facing[lane] = max(nx * toward.x + ny * toward.y + nz * toward.z, 0.0);
        asks[lane] = if facing[lane] * points.asks[lane] > 0.0 { u32::MAX } else { 0 };
    }
    (facing, asks)
}

/// The points of packets along some directions, as work for [`widest`].
struct Gather<'a, P> {
    packets: &'a P,
    asked: &'a mut [(Axes, Gathered)],
}

impl<P: Packets> Work for Gather<'_, P> {
    #[inline(always)]
    fn run(self) {
        let runs = (0..self.packets.runs()).flat_map(|run| (0..self.packets.len_of(run)).map(move |at| (run, at)));
        for (packet, (run, at)) in runs.enumerate() {
            let points = self.packets.points(run, at);
            for (axes, gathered) in &mut *self.asked {
                let (_, asks) = facing(&points, axes.toward);
                let (asks, first) = (bits(|lane| asks[lane] != 0), (packet * LANES) as u32);
                gathered.add(&Starts { at: axes.places(&points.position), asks, first });
            }
        }
    }
}

#[cfg(test)]
#[path = "reach_tests.rs"]
mod tests;
