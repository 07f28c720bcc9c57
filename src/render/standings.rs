//! Where the blocks of a scene stand, for questions that are brought to the block instead of the block to the world.
//!
//! Primitives are numbered through all placements, one after the other.

use super::field::Field;
use super::hierarchy::Hierarchy;
use crate::math::Aabb;
use crate::scene::Scene;
use glam::Affine3A;
use std::sync::Arc;

/// A block where it stands.
#[derive(Debug)]
pub(super) struct Standing {
    pub(super) field: Arc<Field>,
    pub(super) block_from_world: Affine3A,
    /// Number of its first primitive.
    pub(super) first: u32,
}

/// All of a scene, and a hierarchy over their boxes. Empty for a scene that is asked primitive by primitive.
#[derive(Debug, Default)]
pub(super) struct Standings {
    pub(super) standings: Vec<Standing>,
    pub(super) hierarchy: Hierarchy,
}

impl Standings {
    /// Those of the placements whose block (by its number in `blocks`) is not empty.
    pub(super) fn new(scene: &Scene, blocks: &[Arc<Field>]) -> Standings {
        let mut first = 0u32;
        let (standings, boxes): (Vec<Standing>, Vec<Aabb>) = (scene.placements.iter())
            .filter_map(|placement| {
                let (field, world_from_block) = (&blocks[placement.block], &placement.world_from_block);
                let bounds = field.hierarchy().boxes.last()?;
                let block_from_world = world_from_block.inverse();
                let standing = Standing { field: Arc::clone(field), block_from_world, first };
                first = first.saturating_add(field.solids().len() as u32);
                Some((standing, bounds.moved(world_from_block)))
            })
            .unzip();
        let hierarchy = Hierarchy::new(&boxes);
        Standings { standings, hierarchy }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.standings.is_empty()
    }

    /// Where primitive `index` stands, and its number in its block.
    pub(super) fn of(&self, index: usize) -> Option<(&Standing, usize)> {
        let after = self.standings.partition_point(|standing| standing.first as usize <= index);
        let standing = self.standings.get(after.checked_sub(1)?)?;
        Some((standing, index - standing.first as usize))
    }
}
