//! One picture, two renderers.
//!
//! [`frame`] and [`settings`] define the picture, [`cpu`] and `gpu` compute it, each on its own; [`mod@select`] is
//! the only place that knows both. What is written over the picture, [`mod@overlay`] draws for either. [`cpu::reference`] is the truth the others are measured against.

pub mod bounds;
pub mod cpu;
pub mod crop;
pub mod distance;
pub mod field;
pub mod frame;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod hierarchy;
pub mod image;
pub mod lens;
pub mod opacity;
pub mod outline;
pub mod overlay;
pub mod pick;
pub mod select;
pub mod settings;
pub mod sky;
pub mod solids;
mod standings;
#[cfg(test)]
mod test_shapes;
#[cfg(test)]
mod test_solids;
pub mod tubes;

pub use image::{GBuffer, Image, SkyVisibility};
pub use pick::{Hit, Picker};
pub use select::{Choice, DeviceLimits, Selection, select, select_under};
pub use settings::{Quality, Settings, View};

use crate::error::Result;
use crate::scene::Scene;
use std::sync::Arc;

/// What draws scenes.
pub trait Renderer {
    /// What it is and what it runs on, for people and metadata (`cpu`, `gpu: NVIDIA …, Vulkan`).
    fn name(&self) -> String;

    /// Takes a scene to draw. Loading a scene with the same blocks and placements again is cheap.
    ///
    /// # Errors
    /// If the device cannot hold it.
    fn load(&mut self, scene: Arc<Scene>) -> Result<()>;

    /// Draws the finished picture of the loaded scene, text included; an empty background if none was loaded.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    fn image(&mut self, view: &View, settings: &Settings) -> Result<Image>;

    /// What is seen at the pixel centres of the loaded scene.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    fn gbuffer(&mut self, view: &View) -> Result<GBuffer>;

    /// How much of the sky the surface at the pixel centres of the loaded scene sees, over so many directions (at most
    /// [`Settings::MOST_DIRECTIONS`]).
    ///
    /// # Errors
    /// If the device is lost or refuses, or cannot hold what hides the sky.
    fn sky_visibility(&mut self, view: &View, directions: u32) -> Result<SkyVisibility>;

    /// What the user should know since the last call: that a device was lost, say, and what draws in its place.
    fn take_notices(&mut self) -> Vec<String> {
        Vec::new()
    }
}
