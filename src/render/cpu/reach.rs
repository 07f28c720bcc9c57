//! What reaches the points that a tile shows: asked once for each primitive in each pixel, at the first sample that sees it.
//!
//! Light from afar changes little within a pixel, unlike what is seen and how it is turned; asking it at every
//! sample would cost sixteen times as much.

use super::maps::{LANES, Maps, Points};
use super::simd::{Work, widest};
use crate::render::frame::FrameConstants;
use crate::render::settings::Settings;
use crate::render::sky::{self, Reach};
use crate::scene::Scene;
use glam::Vec3;

/// The maps of a scene under one light.
#[derive(Debug, Default)]
pub(super) struct Lights {
    sky: Maps,
    /// Directions that `sky` is made of.
    sky_count: u32,
    key: Maps,
    /// The light that `key` is made for.
    key_in_world: Vec3,
    center: Vec3,
}

impl Lights {
    /// No maps: nothing is asked.
    pub(super) fn none() -> Lights {
        Lights::default()
    }

    /// Makes the maps that are wanted, and keeps those that still hold for this scene.
    pub(super) fn update(&mut self, scene: &Scene, frame: &FrameConstants, settings: &Settings) {
        self.center = scene.bounds().center();
        let wanted = settings.ao.min(Settings::MOST_DIRECTIONS);
        if wanted != self.sky_count {
            self.sky = Maps::default(); // the old ones go first
            self.sky = Maps::new(scene, &sky::directions(wanted));
            self.sky_count = wanted;
        }
        let key = if settings.shadow { frame.key_in_world() } else { Vec3::ZERO };
        if key != self.key_in_world {
            self.key = Maps::default();
            self.key = if settings.shadow { Maps::new(scene, &sky::key_directions(key)) } else { Maps::default() };
            self.key_in_world = key;
        }
    }

    /// Whether anything is asked at all.
    pub(super) fn is_empty(&self) -> bool {
        self.sky.is_empty() && self.key.is_empty()
    }
}

/// One primitive in one pixel.
#[derive(Debug, Clone, Copy)]
struct Seen {
    primitive: u32,
    /// Another primitive in the same pixel, or [`NONE`].
    next: u32,
    reach: Reach,
}

const NONE: u32 = u32::MAX;

/// What reaches the primitives in the pixels of a tile.
#[derive(Debug)]
pub(super) struct Reaches {
    first: Vec<u32>,
    seen: Vec<Seen>,
    /// Points still to be asked: which entry of `seen`, where in the world, unit normal.
    waiting: Vec<(u32, Vec3, Vec3)>,
}

impl Reaches {
    /// Of a tile of so many pixels.
    pub(super) fn new(pixels: usize) -> Reaches {
        Reaches { first: vec![NONE; pixels], seen: Vec::new(), waiting: Vec::new() }
    }

    fn entry(&self, pixel: usize, primitive: u32) -> Option<&Seen> {
        let mut at = self.first[pixel];
        while let Some(seen) = self.seen.get(at as usize) {
            if seen.primitive == primitive {
                return Some(seen);
            }
            at = seen.next;
        }
        None
    }

    /// What reaches a primitive in a pixel; `unasked` if that is not known.
    #[inline]
    pub(super) fn of(&self, pixel: usize, primitive: u32, unasked: Reach) -> Reach {
        self.entry(pixel, primitive).map_or(unasked, |seen| seen.reach)
    }

    /// Notes a primitive in a pixel; `point` gives its place and normal in the world if it is new there, or `None` if there is
    /// nothing to ask.
    pub(super) fn note(
        &mut self,
        pixel: usize,
        primitive: u32,
        unasked: Reach,
        point: impl FnOnce() -> Option<(Vec3, Vec3)>,
    ) {
        if self.entry(pixel, primitive).is_some() {
            return;
        }
        let index = self.seen.len() as u32;
        self.seen.push(Seen { primitive, next: self.first[pixel], reach: unasked });
        self.first[pixel] = index;
        if let Some((position, normal)) = point() {
            self.waiting.push((index, position, normal));
        }
    }

    /// Asks for all points noted since.
    pub(super) fn ask(&mut self, lights: &Lights) {
        if !self.waiting.is_empty() {
            widest(Ask { reaches: self, lights });
            self.waiting.clear();
        }
    }
}

struct Ask<'a> {
    reaches: &'a mut Reaches,
    lights: &'a Lights,
}

impl Work for Ask<'_> {
    #[inline(always)]
    fn run(self) {
        let Reaches { seen, waiting, .. } = self.reaches;
        for group in waiting.chunks(LANES) {
            let mut points = Points::default();
            for (lane, &(_, position, normal)) in group.iter().enumerate() {
                points.set(lane, position - self.lights.center, normal);
            }
            if !self.lights.sky.is_empty() {
                self.lights.sky.ask::<true>(&mut points);
                for (lane, &(index, ..)) in group.iter().enumerate() {
                    seen[index as usize].reach.open = points.part(lane);
                }
            }
            if !self.lights.key.is_empty() {
                self.lights.key.ask::<false>(&mut points);
                for (lane, &(index, ..)) in group.iter().enumerate() {
                    seen[index as usize].reach.key = points.part(lane);
                }
            }
        }
    }
}
