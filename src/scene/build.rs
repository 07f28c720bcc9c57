//! Builds a [`Scene`] from structures: where they stand, the turn and the ground.

use super::coloring::ColorBy;
use super::light::{Background, Ground};
use super::overlay::{self, OverlayOptions};
use super::{Block, Placement, Scene, Style, block, cell_box, fit};
use crate::crystal::{Drawn, Stub};
use crate::math::{Aabb, direction_or};
use crate::structure::{Cell, Structure};
use glam::{Affine3A, DVec3, Mat3, Quat, Vec3};
use std::sync::Arc;

/// A structure and where it stands.
#[derive(Debug, Clone, Copy)]
pub struct Item<'a> {
    /// The structure; its first frame is drawn.
    pub structure: &'a Structure,
    /// Shift in ångström, for structures side by side.
    pub offset: Vec3,
    /// Bonds that are cut at the faces of the cell.
    pub stubs: &'a [Stub],
    /// Atoms of a lattice, whose coordination is drawn solid; empty if there are none.
    pub lattice: &'a [bool],
    /// For every atom which one of its file it is, from 0; empty if all are as listed.
    pub listed: &'a [u32],
    /// The cell to be drawn around it, a corner at the file's origin.
    pub cell_box: Option<&'a Cell>,
}

impl<'a> Item<'a> {
    /// A structure where its file puts it.
    #[must_use]
    pub fn of(structure: &'a Structure) -> Item<'a> {
        Item { structure, offset: Vec3::ZERO, stubs: &[], lattice: &[], listed: &[], cell_box: None }
    }

    /// What is drawn of a crystal; with its box if that is asked for, or, nothing being said, if cells are shown.
    #[must_use]
    pub fn drawn(drawn: &'a Drawn, cell_box: Option<bool>) -> Item<'a> {
        let cell = drawn.cell.as_ref().filter(|_| cell_box.unwrap_or(drawn.is_cell_content));
        Item {
            structure: &drawn.structure,
            offset: Vec3::ZERO,
            stubs: &drawn.stubs,
            lattice: &drawn.lattice,
            listed: &drawn.listed,
            cell_box: cell,
        }
    }
}

/// Which of the alternate locations of an atom are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AltlocChoice {
    /// In each residue the one with the highest occupancy, the first of equals.
    #[default]
    Highest,
    /// This one where a residue has it, else the highest.
    Code(u8),
    /// All.
    All,
}

/// How the molecule stands in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Orientation {
    /// Longest axis across, thinnest to the viewer, looked down on by 17°; where a cell is drawn that is not flat, **c** up
    /// and **a** to the viewer, turned by 25°.
    #[default]
    Auto,
    /// The file's axes, looked at along `direction`, with `up` upwards as far as it goes.
    Along {
        /// The direction the viewer looks, in the file's axes.
        direction: Vec3,
        /// What is up, in the file's axes.
        up: Vec3,
    },
}

/// What to build.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneOptions {
    /// Representation. Default: ball-and-stick.
    pub style: Style,
    /// Colour scheme. Default: element.
    pub color_by: ColorBy,
    /// Alternate locations. Default: the highest occupancy.
    pub altloc: AltlocChoice,
    /// Turn. Default: automatic.
    pub orientation: Orientation,
    /// Whether the default camera is a perspective one. Default: true.
    pub perspective: bool,
    /// Whether there is a ground. Default: true.
    pub ground: bool,
    /// Background. Default: white.
    pub background: Background,
    /// Whether a metal has one stick to the middle of a ring or double bond that it holds, in place of one to each
    /// atom. Default: false.
    pub haptic: bool,
    /// What is written over the picture. Default: nothing.
    pub overlay: OverlayOptions,
}

impl Default for SceneOptions {
    fn default() -> Self {
        SceneOptions {
            style: Style::default(),
            color_by: ColorBy::default(),
            altloc: AltlocChoice::default(),
            orientation: Orientation::default(),
            perspective: true,
            ground: true,
            background: Background::default(),
            haptic: false,
            overlay: OverlayOptions::default(),
        }
    }
}

pub(super) fn build(items: &[Item<'_>], options: &SceneOptions) -> Scene {
    // One centre for all items, so that numbers stay small wherever the file puts its molecule.
    let center = common_center(items);
    let mut blocks = Vec::with_capacity(items.len());
    let mut placements = Vec::with_capacity(items.len());
    let mut next_id = 0u32;
    let mut place = |block: Block, shift: DVec3| {
        placements.push(Placement {
            block: blocks.len(),
            world_from_block: Affine3A::from_translation(shift.as_vec3()),
            first_id: next_id,
        });
        next_id = next_id.saturating_add(block.id_count);
        blocks.push(block);
        blocks.len() - 1
    };
    let mut places = Vec::with_capacity(items.len());
    for item in items {
        let shift = item.structure.positions().origin() - center + item.offset.as_dvec3();
        places.push((item, place(block::build(item, options), shift)));
        if let Some(cell) = item.cell_box {
            let corner = -item.structure.positions().origin().as_vec3();
            place(cell_box::block(cell, corner), shift);
        }
    }
    let mut scene = Scene::from_blocks(blocks, placements);
    let (turn, pitch) = match options.orientation {
        Orientation::Auto => {
            let centers = || scene.world_spheres().map(|(center, _)| center);
            let turn = fit::principal_rotation(centers());
            let cell = items.iter().find_map(|item| item.cell_box);
            let turn = match cell.filter(|_| !fit::is_flat(centers(), turn)) {
                Some(cell) => fit::cell_rotation(cell.vectors().map(|vector| vector.as_vec3())),
                None => turn,
            };
            (turn, fit::PITCH_RAD)
        }
        Orientation::Along { direction, up } => {
            let back = direction_or(-direction, Vec3::Z);
            let right = direction_or(up.cross(back), back.any_orthonormal_vector());
            let world_from_file = Mat3::from_cols(right, back.cross(right), back).transpose();
            (Quat::from_mat3(&world_from_file), 0.0)
        }
    };
    for placement in &mut scene.placements {
        placement.world_from_block = Affine3A::from_quat(turn) * placement.world_from_block;
    }
    scene.bounds = scene.find_bounds();
    scene.world_from_view = Quat::from_rotation_x(-pitch);
    scene.perspective = options.perspective;
    scene.background = options.background;
    scene.set_ground(options.ground);
    scene.overlay = Arc::new(overlay::build(&scene, &places, &options.overlay, options.color_by));
    scene
}

/// The middle of the box around all atoms.
fn common_center(items: &[Item<'_>]) -> DVec3 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for item in items {
        let positions = item.structure.positions();
        let bounds = positions.relative().iter().fold(Aabb::EMPTY, |bounds, &p| bounds.union(Aabb::of_sphere(p, 0.0)));
        if !bounds.is_empty() {
            let shift = positions.origin() + item.offset.as_dvec3();
            low = low.min(bounds.min.as_dvec3() + shift);
            high = high.max(bounds.max.as_dvec3() + shift);
        }
    }
    if low.cmple(high).all() { (low + high) * 0.5 } else { DVec3::ZERO }
}

/// The ground under a scene of these bounds: 2 % of its size below its lowest surface.
pub(super) fn ground_under(bounds: Aabb) -> Ground {
    let size = bounds.size().length();
    Ground {
        height: bounds.min.y - 0.02 * size,
        center_xz: [bounds.center().x, bounds.center().z],
        fade_start: 1.5 * size,
        fade_end: fit::GROUND_FADE_END * size,
        color: None,
        shadow: 0.42,
        occlusion: 0.5,
        sharpness: 6.0,
        occlusion_reach: 0.2 * size,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, Bond, BondOrder, BondSource, Diagnostics, StructureBuilder};

    #[test]
    fn ids_are_atoms_then_bonds_and_bare_atoms_are_visible_in_every_style() {
        let mut builder = StructureBuilder::new();
        for x in [0.0, 1.4, 9.0] {
            let position = DVec3::new(x + 5000.0, 0.0, 0.0);
            builder.push_atom(&AtomRecord { element: Element::O, position, ..AtomRecord::default() });
        }
        builder.push_bond(Bond::new(0, 1, BondOrder::Single, BondSource::File));
        let structure = builder.build(&mut Diagnostics::default());
        for style in Style::ALL {
            let scene = Scene::new(&[Item::of(&structure)], &SceneOptions { style, ..SceneOptions::default() });
            assert_eq!(scene.sphere_count(), 3);
            assert!(scene.blocks[0].spheres.iter().all(|sphere| sphere.radius > 0.03));
            assert!(scene.blocks[0].cylinders.iter().all(|stick| stick.id == 4));
            assert!(scene.bounds().center().length() < 0.5, "scenes are centred");
            assert!(scene.ground.is_some_and(|ground| ground.height < scene.bounds().min.y));
        }
    }

    #[test]
    fn an_empty_structure_gives_an_empty_scene() {
        let structure = StructureBuilder::new().build(&mut Diagnostics::default());
        let scene = Scene::new(&[Item::of(&structure)], &SceneOptions::default());
        assert!(scene.bounds().is_empty() && scene.ground.is_none());
        assert!(scene.fitted_camera(1.5).eye.is_finite());
    }
}
