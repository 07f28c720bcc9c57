//! Light from afar for the samples of a tile: the maps of a scene, and what a block of samples is told by them.

use super::lanes::{Lanes, Pass};
use super::maps::{Asked, Maps, Points};
use crate::render::frame::FrameConstants;
use crate::render::settings::{Settings, View};
use crate::render::sky::{self, Turns};
use crate::scene::Scene;
use glam::Vec3;

/// The maps of a scene under one light.
#[derive(Debug, Default)]
pub(super) struct Lights {
    sky: (Turns, Maps),
    /// Directions and samples that `sky` is made for.
    sky_of: [u32; 2],
    key: (Turns, Maps),
    /// The light that `key` is made for, and samples.
    key_of: (Vec3, u32),
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
        let wanted = [settings.ao.min(Settings::MOST_DIRECTIONS), settings.samples];
        if wanted != self.sky_of {
            self.sky = Default::default(); // the old ones go first
            let turns = Turns::of_sky(wanted[0], wanted[1]);
            let maps = Maps::new(scene, &turns.directions);
            (self.sky, self.sky_of) = ((turns, maps), wanted);
        }
        let key = (if settings.shadow { frame.key_in_world() } else { Vec3::ZERO }, settings.samples);
        if key != self.key_of {
            self.key = Default::default();
            let turns = if settings.shadow { Turns::of_key(key.0, key.1) } else { Turns::default() };
            let maps = Maps::new(scene, &turns.directions);
            (self.key, self.key_of) = ((turns, maps), key);
        }
    }

    /// Whether anything is asked at all.
    pub(super) fn is_empty(&self) -> bool {
        self.sky.1.is_empty() && self.key.1.is_empty()
    }

    /// What a pass of a view asks.
    pub(super) fn questions(&self, view: &View, pass: &Pass) -> Questions<'_> {
        let view_from_world = view.camera.view_from_world();
        let asked = |(turns, maps): &(Turns, Maps)| maps.asked(turns, pass, view_from_world.matrix3);
        Questions {
            sky: &self.sky.1,
            key: &self.key.1,
            sky_asked: asked(&self.sky),
            key_asked: asked(&self.key),
            center_in_view: view_from_world.transform_point3(self.center),
        }
    }
}

/// What the blocks of a pass ask.
pub(super) struct Questions<'a> {
    sky: &'a Maps,
    key: &'a Maps,
    sky_asked: Vec<Asked>,
    key_asked: Vec<Asked>,
    pub(super) center_in_view: Vec3,
}

impl Questions<'_> {
    /// Open sky and key light of each point (view space, relative to the scene's centre).
    #[inline(always)]
    pub(super) fn ask(&self, points: &Points, unasked: sky::Reach) -> [Lanes; 2] {
        [
            self.sky.part::<true>(&self.sky_asked, points, unasked.open),
            self.key.part::<false>(&self.key_asked, points, unasked.key),
        ]
    }

    /// Whether anything is asked at all.
    pub(super) fn is_empty(&self) -> bool {
        self.sky_asked.is_empty() && self.key_asked.is_empty()
    }
}
