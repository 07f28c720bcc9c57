//! tiles (being written)
use super::super::field::GroundMap;
use super::super::{GBuffer, Image, Settings, View};
use crate::scene::Scene;

/// The finished picture.
#[must_use]
pub fn image(scene: &Scene, view: &View, settings: &Settings, _ground_map: &GroundMap) -> Image {
    super::reference::image(scene, view, settings)
}

/// What is seen at the pixel centres.
#[must_use]
pub fn gbuffer(scene: &Scene, view: &View) -> GBuffer {
    super::reference::gbuffer(scene, view)
}
