//! What is written over the picture: labels, legend, scale bar. As data; `render::overlay` places and draws it.

mod labels;
mod legend;

pub use labels::{Label, LabelContent};
pub use legend::LegendRow;

use super::build::{Item, SceneOptions};
use super::chosen::Chosen;
use super::copies::ItemIds;
use super::{Placement, Scene};

/// What is to be written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverlayOptions {
    /// What labels say. Default: nothing, there are none.
    pub labels: LabelContent,
    /// Whether it is said which colour is what. Default: no.
    pub legend: bool,
    /// Whether there is a bar of a round length. Default: no.
    pub scale_bar: bool,
    /// Size of all text; at 1 capitals are 2 % of the picture's height. Default: 1.
    pub size: f32,
}

impl Default for OverlayOptions {
    fn default() -> Self {
        OverlayOptions { labels: LabelContent::default(), legend: false, scale_bar: false, size: 1.0 }
    }
}

/// The texts of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlay {
    /// Texts in space; of two at the same depth the first one is drawn.
    pub labels: Vec<Label>,
    /// The rows of the legend, empty for none.
    pub legend: Vec<LegendRow>,
    /// Whether there is a scale bar.
    pub scale_bar: bool,
    /// Size of all text; at 1 capitals are 2 % of the picture's height.
    pub size: f32,
}

impl Default for Overlay {
    fn default() -> Self {
        Overlay { labels: Vec::new(), legend: Vec::new(), scale_bar: false, size: 1.0 }
    }
}

impl Overlay {
    /// Whether nothing is written.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty() && self.legend.is_empty() && !self.scale_bar
    }
}

/// The texts for items of the scene, drawn as chosen.
pub(super) fn build(
    scene: &Scene,
    items: &[(&Item<'_>, ItemIds)],
    chosen: &[&Chosen],
    SceneOptions { text: options, color_by, by_selection, .. }: &SceneOptions,
) -> Overlay {
    let placed = || {
        items.iter().zip(chosen).flat_map(|((item, ids), &chosen)| {
            let placements = scene.placements.get(ids.placements.clone()).unwrap_or_default();
            placements.iter().map(move |placement| (*item, placement, chosen))
        })
    };
    let spheres = |placement: &Placement| &scene.blocks[placement.block].spheres[..];
    let mut labels = Vec::new();
    for (item, placement, chosen) in placed() {
        let is_labelled = |atom: usize| chosen.is_labelled(atom);
        labels::of_item(item, placement, spheres(placement), options.labels, is_labelled, &mut labels);
    }
    let legend = if options.legend {
        // Each block once: what stands several times says nothing new.
        let mut seen = std::collections::HashSet::new();
        let drawn = placed().filter(|(_, placement, _)| seen.insert(placement.block));
        let drawn = drawn.map(|(item, placement, chosen)| (item.structure, spheres(placement), chosen));
        legend::rows(*color_by, &by_selection.colors, drawn)
    } else {
        Vec::new()
    };
    Overlay { labels, legend, scale_bar: options.scale_bar, size: options.size }
}
