//! Builds a [`Scene`] from structures: where they stand, the turn and the ground.

use super::aromatic::Aromatic;
use super::axes::{self, Axes};
use super::chosen::{self, BySelection, Chosen};
use super::coloring::ColorBy;
use super::copies::{self, ItemIds};
use super::light::{Background, DepthOfField, Ground, LightFrame, Lighting};
use super::look::Look;
use super::measure::{self, Measurement};
use super::overlay::{self, OverlayOptions};
use super::vectors::{self, VectorChoice};
use super::{Block, Placement, Scene, Style, block, cell_box, fit, meshes, wedges};
use crate::color::Srgb8;
use crate::crystal::{Copies, Drawn, Stub};
use crate::math::{Aabb, direction_or};
use crate::structure::{Cell, Mesh, Structure};
use glam::{Affine3A, DAffine3, DVec3, Mat3, Quat, Vec3};
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
    /// Where its atoms stand; `None` for once, where they are.
    pub copies: Option<&'a Copies>,
    /// The cell to be drawn around it, a corner at the file's origin.
    pub cell_box: Option<&'a Cell>,
    /// The place of its file among all, from 1, for selections; `None` for its place among the items.
    pub file: Option<u32>,
    /// Tells structures that differ in their positions alone from others ([`Drawn::kind`]); 0 for none.
    pub kind: u64,
}

impl<'a> Item<'a> {
    /// A structure where its file puts it.
    #[must_use]
    pub fn of(structure: &'a Structure) -> Item<'a> {
        Item {
            structure,
            offset: Vec3::ZERO,
            stubs: &[],
            lattice: &[],
            listed: &[],
            copies: None,
            cell_box: None,
            file: None,
            kind: 0,
        }
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
            copies: drawn.copies.as_ref(),
            cell_box: cell,
            file: None,
            kind: drawn.kind,
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

/// How coordinates of the file become those of the world: `world = turn · (file − center)`.
///
/// A scene that is built with the pose of another one stands as that does, whatever of it is shown: frames of a trajectory and
/// molecules that come and go do not move the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// What comes to the middle of the world, in the coordinates of the file, ångström.
    pub center: DVec3,
    /// The turn.
    pub turn: Quat,
    /// How far the default camera looks down, radians.
    pub pitch_rad: f32,
}

/// What to build.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneOptions {
    /// Representation. Default: ball-and-stick.
    pub style: Style,
    /// Colour scheme. Default: element.
    pub color_by: ColorBy,
    /// Alternate locations. Default: the highest occupancy.
    pub altloc: AltlocChoice,
    /// Turn. Default: automatic.
    pub orientation: Orientation,
    /// Where everything stands, in place of what the orientation says. Default: `None`.
    pub pose: Option<Pose>,
    /// Whether hydrogens are drawn. Default: true.
    pub hydrogens: bool,
    /// Whether water molecules are drawn. Default: true.
    pub water: bool,
    /// Whether ions are drawn ([`crate::select::ions`]). Default: true.
    pub ions: bool,
    /// What selections show, hide, colour and so on. Default: nothing.
    pub by_selection: BySelection,
    /// How much larger than usual balls are. Default: 1.
    pub ball_scale: f32,
    /// How much thicker than usual sticks are. Default: 1.
    pub stick_scale: f32,
    /// Distances, angles and dihedrals that are marked and labelled. Default: none.
    pub measurements: Vec<Measurement>,
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
    pub text: OverlayOptions,
    /// How light falls. Default: studio. (The background is a setting of its own: see [`Look::background`].)
    pub look: Look,
    /// Width of outlines as a part of the picture's height, 0 for none. Default: `None`, the look's.
    pub outline: Option<f32>,
    /// Colour of outlines. Default: `None`, the look's.
    pub outline_color: Option<Srgb8>,
    /// How much of the background's colour the farthest point takes on, 0–1. Default: `None`, the look's.
    pub fog: Option<f32>,
    /// What the lights turn with. Default: the camera.
    pub light: LightFrame,
    /// Depth of field, in perspective. Default: none.
    pub depth_of_field: Option<DepthOfField>,
    /// How aromatic bonds look. Default: a ring in each ring.
    pub aromatic: Aromatic,
    /// Which vectors on atoms are drawn as arrows. Default: none.
    pub vectors: VectorChoice,
    /// Ångström that one unit of these is long; `None` makes the longest of each field 2 Å. Default: `None`.
    pub vector_scale: Option<f32>,
    /// Whether arrows show the directions of the axes. Default: false.
    pub axes: bool,
    /// Meshes that are drawn with the molecules, in the coordinates of their files. Default: none.
    pub overlay: Vec<Arc<Mesh>>,
    /// Opacity of the meshes, 0 to 1, by which their own is multiplied. Default: `None`, their own.
    pub overlay_opacity: Option<f32>,
    /// Whether the edges of the meshes are drawn in place of their triangles. Default: false.
    pub overlay_wireframe: bool,
    /// Colour of the meshes. Default: `None`, their own.
    pub overlay_color: Option<Srgb8>,
}

impl Default for SceneOptions {
    fn default() -> Self {
        SceneOptions {
            style: Style::default(),
            color_by: ColorBy::default(),
            altloc: AltlocChoice::default(),
            orientation: Orientation::default(),
            pose: None,
            hydrogens: true,
            water: true,
            ions: true,
            by_selection: BySelection::default(),
            ball_scale: 1.0,
            stick_scale: 1.0,
            measurements: Vec::new(),
            perspective: true,
            ground: true,
            background: Background::default(),
            haptic: false,
            text: OverlayOptions::default(),
            look: Look::default(),
            outline: None,
            outline_color: None,
            fog: None,
            light: LightFrame::default(),
            depth_of_field: None,
            aromatic: Aromatic::default(),
            vectors: VectorChoice::default(),
            vector_scale: None,
            axes: false,
            overlay: Vec::new(),
            overlay_opacity: None,
            overlay_wireframe: false,
            overlay_color: None,
        }
    }
}

/// What scenes of one molecule in many frames have in common: all that positions do not decide, so that another frame only moves balls, sticks and
/// rings.
pub struct Rig {
    options: SceneOptions,
    items: Vec<block::Rig>,
    /// As [`Scene::unmatched`].
    unmatched: Vec<String>,
}

impl Rig {
    /// Of structures and options.
    #[must_use]
    pub fn new(items: &[Item<'_>], options: &SceneOptions) -> Rig {
        let (chosen, unmatched) = chosen::choose(items, options);
        let items = items.iter().zip(chosen).map(|(item, chosen)| block::Rig::new(item, options, chosen)).collect();
        Rig { options: SceneOptions { pose: None, ..options.clone() }, items, unmatched }
    }

    /// Whether [`Rig::scene`] of these would be what [`Scene::new`] makes, but for aromatic rings that have been bent since.
    #[must_use]
    pub fn fits(&self, items: &[Item<'_>], options: &SceneOptions) -> bool {
        let is_same = SceneOptions { pose: None, ..options.clone() } == self.options;
        // What is near to what is another in each frame.
        let is_still = !options.by_selection.all().any(|(_, selection)| selection.asks_places());
        is_same
            && is_still
            && self.items.len() == items.len()
            && self.items.iter().zip(items).all(|(rig, item)| rig.fits(item))
    }

    /// The scene with everything where the items have it. They must fit, or be those that the rig was made of.
    #[must_use]
    pub fn scene(&self, items: &[Item<'_>], options: &SceneOptions) -> Scene {
        build(items, options, self)
    }
}

fn build(items: &[Item<'_>], options: &SceneOptions, rig: &Rig) -> Scene {
    // One centre for all items, so that numbers stay small wherever the file puts its molecule.
    let center = options.pose.map_or_else(|| common_center(items), |pose| pose.center);
    let mut blocks = Vec::with_capacity(items.len());
    let mut placements = Vec::with_capacity(items.len());
    let mut next_id = 0u32;
    // Each block in some copies of its own, `id_count` ids apart.
    let mut place = |own: Vec<(Block, Vec<(u32, Affine3A)>)>, (id_count, copies): (u32, u32), atoms: u32| {
        let (first_id, first) = (next_id, placements.len());
        for (block, places) in own {
            placements.extend(places.into_iter().map(|(copy, world_from_block)| Placement {
                block: blocks.len(),
                world_from_block,
                first_id: first_id.saturating_add(copy.saturating_mul(id_count)),
            }));
            blocks.push(block);
        }
        next_id = next_id.saturating_add(id_count.saturating_mul(copies));
        ItemIds { first_id, id_count, atoms, copies, placements: first..placements.len() }
    };
    let alone = |block: Block, shift: DVec3| {
        let count = (block.id_count, 1);
        (vec![(block, vec![(0, Affine3A::from_translation(shift.as_vec3()))])], count)
    };
    let mut places = Vec::with_capacity(items.len());
    let scales = vectors::vector_scales(items, options);
    for (item, rig) in items.iter().zip(&rig.items) {
        let origin = item.structure.positions().origin();
        let offset = item.offset.as_dvec3() - center;
        let shift = origin + offset;
        let mut block = rig.pose(item, options);
        vectors::draw(&mut block, item.structure, options, &scales);
        let atoms = u32::try_from(item.structure.atom_count()).unwrap_or(u32::MAX);
        let (own, count) = match item.copies {
            None => alone(block, shift),
            Some(copies) => {
                let count = (block.id_count, u32::try_from(copies.operations.len()).unwrap_or(u32::MAX));
                let there = |number: u32| {
                    let operation = copies.operations.get(number as usize).unwrap_or(&DAffine3::IDENTITY);
                    (number, copies::world_from_block(operation, origin, offset))
                };
                let own = copies::blocks(block, item.structure, copies).into_iter();
                (own.map(|(block, numbers)| (block, numbers.into_iter().map(there).collect())).collect(), count)
            }
        };
        places.push((item, place(own, count, atoms)));
        if let Some(cell) = item.cell_box {
            let (own, count) = alone(cell_box::block(cell, -origin.as_vec3()), shift);
            place(own, count, 0);
        }
    }
    for mesh in &options.overlay {
        let (own, count) = alone(meshes::block(mesh, center, options), DVec3::ZERO);
        place(own, count, 0);
    }
    let mut scene = Scene::from_blocks(blocks, placements);
    let (turn, pitch) = match options.orientation {
        _ if options.pose.is_some_and(|pose| pose.turn.is_finite()) => {
            options.pose.map_or((Quat::IDENTITY, 0.0), |pose| (pose.turn, pose.pitch_rad))
        }
        Orientation::Auto => {
            let centers = || scene.world_spheres().map(|(center, _)| center);
            let turn = fit::principal_rotation(centers());
            let cell = items.iter().find_map(|item| item.cell_box);
            let turn = match cell.filter(|_| !fit::is_flat(centers(), turn)) {
                Some(cell) => fit::cell_rotation(cell.vectors().map(|vector| vector.as_vec3())),
                // From behind, wedges would say the opposite.
                None if (turn * Vec3::Z).z < 0.0
                    && items.iter().any(|item| !wedges::wedges(item.structure).is_empty()) =>
                {
                    Quat::from_rotation_y(std::f32::consts::PI) * turn
                }
                None => fit::turn_aside(scene.world_spheres(), turn) * turn,
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
    scene.pose = Pose { center, turn, pitch_rad: pitch };
    scene.unmatched.clone_from(&rig.unmatched);
    scene.items = places.iter().map(|(_, ids)| ids.clone()).collect();
    scene.bounds = scene.find_bounds();
    if options.axes {
        add_axes(&mut scene, items, center, turn, next_id);
    }
    let marks = measure::marks(&scene, &options.measurements);
    if !marks.block.cylinders.is_empty() {
        let first_id = scene.placements.iter().fold(0, |last, placement| {
            last.max(placement.first_id.saturating_add(scene.blocks[placement.block].id_count))
        });
        let blocks = Arc::make_mut(&mut scene.blocks);
        blocks.push(marks.block);
        let placement = Placement { block: blocks.len() - 1, world_from_block: Affine3A::IDENTITY, first_id };
        scene.placements.push(placement);
    }
    scene.world_from_view = Quat::from_rotation_x(-pitch);
    scene.perspective = options.perspective;
    scene.lighting = lighting(options);
    scene.depth_of_field = options.depth_of_field;
    scene.background = options.background;
    scene.set_ground(options.ground);
    let chosen: Vec<&Chosen> = rig.items.iter().map(block::Rig::chosen).collect();
    let mut overlay = overlay::build(&scene, &places, &chosen, options);
    // Before those of atoms: they were asked for one by one.
    overlay.labels.splice(0..0, marks.labels);
    scene.overlay = Arc::new(overlay);
    scene
}

impl SceneOptions {
    /// The same primitives in the light of other options: what [`Scene::relight`] takes from them.
    #[must_use]
    pub fn lit_as(&self, other: &SceneOptions) -> SceneOptions {
        SceneOptions {
            perspective: other.perspective,
            look: other.look,
            light: other.light,
            fog: other.fog,
            outline: other.outline,
            outline_color: other.outline_color,
            depth_of_field: other.depth_of_field,
            background: other.background,
            ground: other.ground,
            ..self.clone()
        }
    }
}

/// The look's lights, with what is asked to be otherwise.
pub(super) fn lighting(options: &SceneOptions) -> Lighting {
    let mut light = options.look.lighting();
    light.frame = options.light;
    light.fog = options.fog.unwrap_or(light.fog);
    light.outline.width = options.outline.unwrap_or(light.outline.width);
    light.outline.color = options.outline_color.unwrap_or(light.outline.color);
    light
}

/// Adds the arrows along the axes: at the corner of the first cell that is drawn, else beside everything.
fn add_axes(scene: &mut Scene, items: &[Item<'_>], center: DVec3, turn: Quat, first_id: u32) {
    if scene.bounds.is_empty() {
        return;
    }
    let boxed = items.iter().find_map(|item| Some((item.cell_box?, item.offset)));
    let cell = boxed.map(|(cell, _)| cell).or(items.iter().find_map(|item| item.structure.cell()));
    let (vectors, names) = match cell {
        Some(cell) => (cell.vectors().map(|vector| vector.as_vec3()), ["a", "b", "c"]),
        None => ([Vec3::X, Vec3::Y, Vec3::Z], ["x", "y", "z"]),
    };
    let directions = axes::directions(vectors.map(|vector| turn * vector));
    let (origin, length) = match boxed {
        Some((cell, offset)) => {
            let shortest = cell.lengths().into_iter().fold(f64::INFINITY, f64::min) as f32;
            (turn * (offset - center.as_vec3()), axes::length(scene.bounds).min(0.5 * shortest))
        }
        None => (axes::beside(scene.bounds, directions), axes::length(scene.bounds)),
    };
    let blocks = Arc::make_mut(&mut scene.blocks);
    blocks.push(axes::block(origin, directions, length));
    scene.placements.push(Placement { block: blocks.len() - 1, world_from_block: Affine3A::IDENTITY, first_id });
    scene.axes = Some(Axes { origin, tips: directions.map(|direction| origin + direction * length), names });
    scene.bounds = scene.find_bounds();
}

/// The middle of the box around all atoms.
fn common_center(items: &[Item<'_>]) -> DVec3 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for item in items {
        let positions = item.structure.positions();
        let bounds = positions.relative().iter().fold(Aabb::EMPTY, |bounds, &p| bounds.union(Aabb::of_sphere(p, 0.0)));
        if !bounds.is_empty() {
            let mut own = [bounds.min, bounds.max].map(|corner| corner.as_dvec3() + positions.origin());
            if let Some(copies) = item.copies {
                own = copies.extent(own);
            }
            low = low.min(own[0] + item.offset.as_dvec3());
            high = high.max(own[1] + item.offset.as_dvec3());
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
        fade_start: fit::GROUND_FADE_START * size,
        fade_end: fit::GROUND_FADE_END * size,
        color: None,
        shadow: 0.3,
        occlusion: 0.45,
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

    /// Atoms, whether there is a cell of 4 × 5 × 6 Å, and whether it is drawn.
    fn with_axes(cell: Option<bool>) -> (Scene, Scene) {
        let mut builder = StructureBuilder::new();
        for position in [DVec3::new(1.0, 0.0, 0.0), DVec3::new(9.0, 0.5, 0.0), DVec3::new(3.0, 4.0, 2.0)] {
            builder.push_atom(&AtomRecord { element: Element::O, position, ..AtomRecord::default() });
        }
        let cell_box = Cell::from_parameters([4.0, 5.0, 6.0], [90.0, 90.0, 110.0]);
        builder.set_cell(cell_box.filter(|_| cell.is_some()));
        let structure = builder.build(&mut Diagnostics::default());
        let cell_box = cell_box.as_ref().filter(|_| cell == Some(true));
        let item = Item { cell_box, ..Item::of(&structure) };
        let scene = |axes| Scene::new(&[item], &SceneOptions { axes, ..SceneOptions::default() });
        (scene(false), scene(true))
    }

    #[test]
    fn axes_stand_left_of_everything_and_turn_with_the_molecule() {
        for cell in [None, Some(false)] {
            let (bare, scene) = with_axes(cell);
            let axes = scene.axes.unwrap();
            assert_eq!(axes.names, if cell.is_some() { ["a", "b", "c"] } else { ["x", "y", "z"] });
            let block = &scene.blocks[scene.blocks.len() - 1];
            assert_eq!((block.cones.len(), block.cylinders.len(), block.id_count), (3, 3, 3));
            for (cone, tip) in block.cones.iter().zip(axes.tips) {
                assert!((Vec3::from(cone.b) - tip).length() < 1e-5);
                assert!(cone.bounds().max.x < bare.bounds().min.x && cone.bounds().min.y > bare.bounds().min.y - 1e-4);
            }
            // From the first atom to the second is nearly along the first axis.
            let at = |atom: usize| {
                scene.placements[0].world_from_block.transform_point3(scene.blocks[0].spheres[atom].center.into())
            };
            let along = (at(1) - at(0)).normalize();
            assert!(along.dot((axes.tips[0] - axes.origin).normalize()) > 0.99);
            assert!(scene.bounds().min.x < bare.bounds().min.x && bare.axes.is_none());
        }
    }

    #[test]
    fn axes_of_a_drawn_cell_stand_at_its_corner() {
        let (_, scene) = with_axes(Some(true));
        let axes = scene.axes.unwrap();
        let edges = &scene.blocks[1].cylinders;
        for (axis, tip) in axes.tips.into_iter().enumerate() {
            let edge = edges.iter().find(|edge| edge.color_a == cell_box::AXES[axis]).unwrap();
            let [from, to] = [edge.a, edge.b].map(|p| scene.placements[1].world_from_block.transform_point3(p.into()));
            assert!((from - axes.origin).length() < 1e-4);
            assert!((to - from).normalize().dot((tip - axes.origin).normalize()) > 0.999_99);
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

#[cfg(test)]
#[path = "rig_tests.rs"]
mod rig_tests;
