//! The CPU renderer: the reference, and the product on machines without a GPU.
//!
//! [`mod@reference`] casts one ray after the other over a hierarchy, on one thread. [`tiles`] draws the same picture
//! tile by tile on all cores with vector instructions: primitives are binned to tiles by their exact bounds, and each tile
//! keeps a small depth buffer. Where all are opaque and nothing is outlined they are found pack by pack, as they are needed. Points that ask for light
//! from afar do so at once, packet by packet (`asking`), or, of large scenes, all together, direction by direction (`rays`).
//!
//! Large scenes of copies (assemblies, supercells) are never spread out, whatever is asked: what is seen comes from packs, light from afar
//! from `hiders`, the ground's light from the fields of the blocks ([`Field::of_copies`]), all made once for a block.

mod asking;
mod backdrop;
mod behind;
mod binning;
mod bodies;
mod casters;
mod clusters;
mod facts;
mod few;
mod ground;
mod hiders;
pub mod intersect;
mod lanes;
mod lit;
mod looks;
mod moved;
mod packs;
mod rays;
mod reach;
pub mod reference;
mod shade;
mod shader;
pub mod simd;
mod small;
mod source;
mod tile;
pub mod tiles;
mod visibility;

use super::field::{Field, GroundMap};
use super::frame::FrameConstants;
use super::solids::Solids;
use super::{GBuffer, Image, Renderer, Settings, SkyVisibility, View, overlay, sky};
use crate::error::{Error, Result};
use crate::scene::Scene;
use glam::Affine3A;
use hiders::Hiders;
use packs::Packs;
use reach::Lights;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tiles::Known;

/// Placements of a scene are spread out to primitives of their own where these are no more than so many. Chosen: 20 MB, and pictures of all
/// but the largest scenes are those of the reference to the byte.
const MOST_SPREAD: usize = 100_000;

/// Finished pictures of no more primitives are drawn from a list. Measured on two cores: of a molecule of 50 primitives a still from packs takes a
/// quarter longer, of 2,000 as long, of 20,000 a tenth less.
const MOST_LISTED: usize = 2_000;

/// Draws with all cores.
pub struct CpuRenderer {
    scene: Option<Arc<Scene>>,
    /// Whether the loaded scene is drawn from its blocks, without spreading out its placements.
    of_copies: bool,
    /// Of such a scene the distance fields of the blocks, made when light or ground first need them.
    block_fields: Vec<Arc<Field>>,
    counts: Counts,
    /// What points ask for light from afar, if they do so together, made when it is first asked for.
    hiders: Option<Hiders>,
    /// See [`MOST_SPREAD`].
    most_spread: usize,
    /// See [`asking::MOST_PRIMITIVES`].
    most_at_once: usize,
    /// The distance field of the loaded scene, made when a ground first needs it.
    field: Option<Field>,
    /// The last ground maps and the constants they were made with: in motion and at rest they differ in texels.
    ground_maps: [Option<(FrameConstants, GroundMap)>; 2],
    /// The sky's part of the ground in motion: it stays while the light turns with the camera.
    sky_map: Option<(FrameConstants, GroundMap)>,
    /// The balls and sticks of the loaded scene in packs, made when a picture first needs them.
    packs: Option<Packs>,
    /// Which directions of the sky and the key light samples ask.
    lights: Lights,
}

impl Default for CpuRenderer {
    fn default() -> CpuRenderer {
        CpuRenderer {
            scene: None,
            of_copies: false,
            block_fields: Vec::new(),
            counts: Counts::default(),
            hiders: None,
            most_spread: MOST_SPREAD,
            most_at_once: asking::MOST_PRIMITIVES,
            field: None,
            ground_maps: [None, None],
            packs: None,
            lights: Lights::none(),
            sky_map: None,
        }
    }
}

/// How many primitives there are in a scene.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    /// Of the placements.
    spread: usize,
    /// Of the blocks that stand somewhere.
    kept: usize,
    /// Those of the placements that light from afar is asked about one by one: cones, triangles and what is see-through. (Rings are few.)
    others: usize,
}

impl Counts {
    fn of(scene: &Scene) -> Counts {
        let mut stand = vec![0usize; scene.blocks.len()];
        scene.placements.iter().for_each(|placement| stand[placement.block] += 1);
        let mut counts = Counts::default();
        for (block, &stand) in scene.blocks.iter().zip(&stand) {
            let slow = block.cones.len() + block.triangles.len();
            let count = block.spheres.len() + block.cylinders.len() + block.tori.len() + slow;
            let faint = block.spheres.iter().filter(|ball| ball.color.a < u8::MAX).count()
                + block.cylinders.iter().filter(|stick| stick.color_a.a < u8::MAX).count();
            counts.spread += stand * count;
            counts.kept += stand.min(1) * count;
            counts.others += stand * (slow + faint);
        }
        counts
    }

    /// Whether the placements have more than so many primitives, and at least twice as many as the blocks.
    fn is_of_copies(self, most_spread: usize) -> bool {
        self.spread > most_spread && self.spread >= 2 * self.kept
    }
}

impl CpuRenderer {
    /// A renderer without a scene.
    #[must_use]
    pub fn new() -> CpuRenderer {
        CpuRenderer::default()
    }

    /// Whether points ask for light from afar together.
    fn asks_together(&self) -> bool {
        let Counts { spread, others, .. } = self.counts;
        self.of_copies || (spread > self.most_at_once && others as f32 <= asking::MOST_OTHERS * spread as f32)
    }

    /// Makes ready what light from afar and a ground need of the scene.
    fn find_hiders(&mut self, scene: &Scene, asks: bool, has_ground: bool) {
        if self.of_copies && (asks || has_ground) && self.block_fields.len() != scene.blocks.len() {
            let field = |block| Arc::new(Field::of_block(scene, block));
            self.block_fields = (0..scene.blocks.len()).map(field).collect();
        }
        if asks && self.hiders.is_none() {
            self.hiders = Some(match (&self.field, self.of_copies) {
                (_, true) => Hiders::of_copies(scene, &self.block_fields),
                (Some(field), false) => Hiders::new(field.solids()),
                (None, false) => Hiders::new(&Solids::new(scene, Affine3A::IDENTITY)),
            });
        }
    }

    /// The scene, or an empty one, and what its channels need to know of it.
    fn known(&mut self, asks: bool) -> (Arc<Scene>, Known<'_>) {
        let scene = self.scene.clone().unwrap_or_else(|| Arc::new(Scene::from_blocks(Vec::new(), Vec::new())));
        self.find_hiders(&scene, asks, false);
        if self.of_copies {
            self.packs.get_or_insert_with(|| Packs::new(&scene));
        }
        let known = Known { packs: self.packs.as_ref(), of_copies: self.of_copies, hiders: self.hiders.as_ref() };
        (scene, known)
    }

    /// The ground map for these constants; found anew only if something it depends on has changed.
    fn ground_map(&mut self, scene: &Scene, frame: &FrameConstants, sky_frame: Option<FrameConstants>) -> GroundMap {
        if !frame.has_ground() {
            return GroundMap::none();
        }
        let place = &mut self.ground_maps[usize::from(sky_frame.is_some())];
        let kept = place.take().filter(|(old, _)| old.same_ground_map(frame));
        let (_, map) = place.insert(kept.unwrap_or_else(|| {
            let field = self.field.get_or_insert_with(|| match self.of_copies {
                true => Field::of_copies(scene, &self.block_fields),
                false => Field::new(scene),
            });
            let Some(sky_frame) = sky_frame else { return (*frame, ground::ground_map(field, frame)) };
            let kept = self.sky_map.take().filter(|(old, _)| old.same_ground_map(&sky_frame));
            let sky = self.sky_map.insert(kept.unwrap_or_else(|| (sky_frame, field.sky_map(&sky_frame))));
            (*frame, ground::quick_ground_map(field, frame, sky))
        }));
        map.clone()
    }

    /// As [`Renderer::image`], but gives up with `None` soon after `stop` becomes true.
    #[must_use]
    pub fn image_unless(&mut self, view: &View, settings: &Settings, stop: &AtomicBool) -> Option<Image> {
        let scene = self.scene.clone().unwrap_or_else(|| Arc::new(Scene::from_blocks(Vec::new(), Vec::new())));
        let frame = FrameConstants::new(&scene, view, settings);
        // Drawing in motion does not ask, and must not throw away what the picture at rest needs again.
        let asks = settings.ao > 0 || settings.shadow;
        let is_quick = !asks && settings.samples == 1 && settings.ground_texels < Settings::QUICK_GROUND;
        let sky_frame = is_quick.then(|| frame.lit_from_above(&scene, view, settings));
        self.find_hiders(&scene, false, frame.has_ground());
        let ground_map = self.ground_map(&scene, &frame, sky_frame);
        self.find_hiders(&scene, asks && self.asks_together(), false);
        let none = Lights::none();
        if asks {
            self.lights.update(&frame, settings);
        }
        let packed = !asks || self.of_copies || self.counts.spread > MOST_LISTED;
        if packed {
            self.packs.get_or_insert_with(|| Packs::new(&scene));
        }
        let packs = self.packs.as_ref().filter(|_| packed);
        let hiders = self.hiders.as_ref().filter(|_| self.asks_together());
        let known = Known { packs, of_copies: self.of_copies, hiders };
        let lights = if asks { &self.lights } else { &none };
        let mut image = tiles::image(&scene, view, settings, (&ground_map, lights, known), stop);
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        // In motion, at one sample, the picture's own pixels are fine enough to find out what labels can be seen.
        let own_side = view.width.max(view.height).min(overlay::PROBE_SIDE);
        let probe_side = if settings.samples > 1 { overlay::PROBE_SIDE } else { own_side };
        let has_labels = !scene.overlay.labels.is_empty();
        let probe = has_labels.then(|| tiles::gbuffer(&scene, &overlay::probe_view(view, probe_side), known));
        overlay::write(&mut image, &scene, view, probe.as_ref());
        Some(image)
    }
}

impl Renderer for CpuRenderer {
    fn name(&self) -> String {
        "cpu".to_owned()
    }

    fn load(&mut self, scene: Arc<Scene>) -> Result<()> {
        let same = self
            .scene
            .as_ref()
            .is_some_and(|old| Arc::ptr_eq(&old.blocks, &scene.blocks) && old.placements == scene.placements);
        if !same {
            self.field = None;
            self.lights = Lights::none();
            self.packs = None;
            self.hiders = None;
            self.block_fields = Vec::new();
            self.ground_maps = [None, None];
            self.counts = Counts::of(&scene);
            self.of_copies = self.counts.is_of_copies(self.most_spread);
            self.sky_map = None;
        }
        self.scene = Some(scene);
        Ok(())
    }

    fn image(&mut self, view: &View, settings: &Settings) -> Result<Image> {
        let image = self.image_unless(view, settings, &AtomicBool::new(false));
        image.ok_or_else(|| Error::Unsupported("the picture was stopped".to_owned()))
    }

    fn gbuffer(&mut self, view: &View) -> Result<GBuffer> {
        let (scene, known) = self.known(false);
        Ok(tiles::gbuffer(&scene, view, known))
    }

    fn sky_visibility(&mut self, view: &View, directions: u32) -> Result<SkyVisibility> {
        let (scene, known) = self.known(true);
        let directions = sky::directions(directions.min(Settings::MOST_DIRECTIONS));
        Ok(visibility::sky_visibility(&scene, view, &directions, known))
    }
}

#[cfg(test)]
#[path = "copies_tests.rs"]
mod tests;
