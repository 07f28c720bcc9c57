//! What may hide the light from afar in a scene, made once for it, whatever the view.
//!
//! The primitives of a scene are one block in world space. A scene of copies is never spread out: each block is there once, in its own
//! space. The points' coordinates along a direction's axes are the same numbers in every space that keeps distances: a block is asked along the
//! axes as they look from there, once for each place where it stands.

use super::bodies::Axes;
use super::clusters::Clusters;
use super::rays::{Gathered, Hider, Rays};
use crate::render::field::Field;
use crate::render::opacity::hides_in_sample;
use crate::render::solids::Solids;
use crate::scene::Scene;
use glam::Affine3A;
use std::sync::Arc;

/// Where a block stands.
#[derive(Debug)]
struct Placed {
    block: usize,
    block_from_world: Affine3A,
    first_id: u32,
}

/// All that may hide light.
#[derive(Debug)]
pub(super) struct Hiders {
    blocks: Vec<Clusters>,
    placed: Vec<Placed>,
}

impl Hiders {
    /// Of all primitives of a scene, world space.
    pub(super) fn new(solids: &Solids) -> Hiders {
        let placed = Placed { block: 0, block_from_world: Affine3A::IDENTITY, first_id: 0 };
        Hiders { blocks: vec![Clusters::new(solids)], placed: vec![placed] }
    }

    /// Of a scene's blocks, which have these fields.
    pub(super) fn of_copies(scene: &Scene, fields: &[Arc<Field>]) -> Hiders {
        let placed = scene.placements.iter().map(|placement| Placed {
            block: placement.block,
            block_from_world: placement.world_from_block.inverse(),
            first_id: placement.first_id,
        });
        let blocks = fields.iter().map(|field| Clusters::new(field.solids())).collect();
        Hiders { blocks, placed: placed.collect() }
    }

    /// Whether there is nothing.
    pub(super) fn is_empty(&self) -> bool {
        self.placed.iter().all(|placed| self.blocks[placed.block].top().is_none())
    }

    /// The points that see the light along these axes, given in view space, in a sample of so many.
    pub(super) fn free(
        &self,
        (points, rays): (&Gathered, &mut Rays),
        (axes, world_from_view): (&Axes, &Affine3A),
        [sample, samples]: [u32; 2],
        see: impl FnMut(u32),
    ) {
        let radii = self.blocks.iter().map(Clusters::mean_radius);
        rays.set(points, radii.fold(0.0, f32::max));
        for placed in &self.placed {
            let (clusters, others) = (&self.blocks[placed.block], self.blocks[placed.block].others());
            let counts = |index: usize| {
                let id = placed.first_id.saturating_add(others.id(index));
                !others.see_through || hides_in_sample(sample, samples, id, others.opacity(index))
            };
            let axes = axes.moved(&(placed.block_from_world * *world_from_view));
            rays.hide(&Hider { clusters, axes, counts: &counts });
        }
        rays.for_each_free(see);
    }
}
