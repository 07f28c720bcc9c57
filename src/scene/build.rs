//! Builds a [`Scene`] from structures: which atoms are drawn, their balls and sticks, the turn and the ground.

use super::coloring::ColorBy;
use super::instances::{CylinderInstance, SphereInstance};
use super::light::{Background, Ground};
use super::sticks::{Neighbours, StickContext};
use super::{Block, Placement, Scene, Style, fit};
use crate::math::{Aabb, direction_or};
use crate::structure::{Structure, atom_flags};
use glam::{Affine3A, DVec3, Mat3, Quat, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// A structure and where it stands.
#[derive(Debug, Clone, Copy)]
pub struct Item<'a> {
    /// The structure; its first frame is drawn.
    pub structure: &'a Structure,
    /// Shift in ångström, for structures side by side.
    pub offset: Vec3,
}

impl<'a> Item<'a> {
    /// A structure where its file puts it.
    #[must_use]
    pub fn of(structure: &'a Structure) -> Item<'a> {
        Item { structure, offset: Vec3::ZERO }
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
    /// Longest axis across, thinnest to the viewer, looked down on by 17°.
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
        }
    }
}

pub(super) fn build(items: &[Item<'_>], options: &SceneOptions) -> Scene {
    // One centre for all items, so that numbers stay small wherever the file puts its molecule.
    let center = common_center(items);
    let mut blocks = Vec::with_capacity(items.len());
    let mut placements = Vec::with_capacity(items.len());
    let mut next_id = 0u32;
    for (index, item) in items.iter().enumerate() {
        let block = build_block(item.structure, options);
        let shift = item.structure.positions().origin() - center + item.offset.as_dvec3();
        placements.push(Placement {
            block: index,
            world_from_block: Affine3A::from_translation(shift.as_vec3()),
            first_id: next_id,
        });
        next_id = next_id.saturating_add(block.id_count);
        blocks.push(block);
    }
    let mut scene = Scene::from_blocks(blocks, placements);
    let (turn, pitch) = match options.orientation {
        Orientation::Auto => {
            let turn = fit::principal_rotation(scene.world_spheres().map(|(center, _)| center));
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

fn build_block(structure: &Structure, options: &SceneOptions) -> Block {
    let positions = structure.positions().relative();
    let atom_count = structure.atom_count();
    let shown = shown_atoms(structure, options.altloc);
    let is_shown = |atom: u32| shown.as_ref().is_none_or(|shown| shown[atom as usize]);
    let colors = options.color_by.colors(structure);
    let neighbours = Neighbours::new(atom_count, structure.bonds(), |bond| is_shown(bond.a) && is_shown(bond.b));
    let radius_of = |atom: u32| {
        let bonded = !neighbours.of(atom).is_empty();
        let radius = options.style.atom_radius(structure.elements()[atom as usize], bonded);
        // Lone pairs and the like are drawn small, whatever the style.
        if structure.flags(atom as usize) & atom_flags::PARTICLE == 0 { radius } else { radius.min(0.12) }
    };
    let last = u32::try_from(atom_count).unwrap_or(u32::MAX);
    let spheres: Vec<SphereInstance> = (0..last)
        .into_par_iter()
        .with_min_len(4096)
        .filter(|&atom| is_shown(atom))
        .map(|atom| SphereInstance {
            center: positions[atom as usize].to_array(),
            radius: radius_of(atom),
            color: colors[atom as usize],
            id: atom + 1,
        })
        .collect();
    let cylinders: Vec<CylinderInstance> = structure
        .bonds()
        .par_iter()
        .enumerate()
        .with_min_len(4096)
        .filter(|(_, bond)| is_shown(bond.a) && is_shown(bond.b))
        .flat_map_iter(|(index, bond)| {
            let mut sticks = Vec::new();
            if let Some(stick_radius) = options.style.stick_radius(bond.kind) {
                let round_ends = options.style != Style::BallAndStick;
                let ball_radius: &dyn Fn(u32) -> f32 = &radius_of;
                let context = StickContext {
                    positions,
                    neighbours: &neighbours,
                    ball_radius,
                    stick_radius,
                    multiple_radius: stick_radius.min(options.style.multiple_radius()),
                    round_ends,
                };
                let template = CylinderInstance {
                    id: last.saturating_add(u32::try_from(index + 1).unwrap_or(u32::MAX)),
                    color_a: colors[bond.a as usize],
                    color_b: colors[bond.b as usize],
                    ..bytemuck::Zeroable::zeroed()
                };
                context.sticks(bond, template, |stick| sticks.push(stick));
            }
            sticks
        })
        .collect();
    let id_count = last.saturating_add(u32::try_from(structure.bonds().len()).unwrap_or(u32::MAX));
    Block { spheres, cylinders, id_count }
}

/// Which atoms are drawn; `None` for all of them.
fn shown_atoms(structure: &Structure, choice: AltlocChoice) -> Option<Vec<bool>> {
    if choice == AltlocChoice::All || !structure.has_altlocs() {
        return None;
    }
    // One alternate a residue position: mixing them atom by atom would join halves of different conformers.
    let site = |atom: usize| {
        structure.residue_index(atom).map(|index| {
            let residue = structure.residues()[index];
            (residue.chain, residue.number, residue.insertion_code)
        })
    };
    let mut occupancy: HashMap<_, Vec<(u8, f64)>> = HashMap::new();
    for atom in (0..structure.atom_count()).filter(|&atom| structure.altloc(atom) != b' ') {
        let codes = occupancy.entry(site(atom)).or_default();
        let code = structure.altloc(atom);
        let weight = f64::from(structure.occupancy(atom));
        match codes.iter_mut().find(|(other, _)| *other == code) {
            Some((_, sum)) => *sum += weight,
            None => codes.push((code, weight)),
        }
    }
    let chosen: HashMap<_, u8> = occupancy
        .into_iter()
        .map(|(site, mut codes)| {
            codes.sort_by(|(code_a, sum_a), (code_b, sum_b)| sum_b.total_cmp(sum_a).then(code_a.cmp(code_b)));
            let wanted = codes.iter().map(|&(code, _)| code).find(|&code| choice == AltlocChoice::Code(code));
            (site, wanted.unwrap_or(codes[0].0))
        })
        .collect();
    let shown =
        |atom: usize| structure.altloc(atom) == b' ' || chosen.get(&site(atom)) == Some(&structure.altloc(atom));
    Some((0..structure.atom_count()).map(shown).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, Bond, BondOrder, BondSource, Diagnostics, StructureBuilder};

    fn altloc_structure() -> Structure {
        let mut builder = StructureBuilder::new();
        let residue = Some(("A", 7, b' ', "SER"));
        for (name, altloc, occupancy) in
            [("CA", b' ', 1.0), ("CB", b'A', 0.4), ("CB", b'B', 0.6), ("OG", b'A', 0.4), ("OG", b'B', 0.6)]
        {
            builder.push_atom(&AtomRecord {
                element: Element::C,
                name,
                altloc,
                occupancy,
                residue,
                ..AtomRecord::default()
            });
        }
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn one_alternate_location_is_drawn() {
        let structure = altloc_structure();
        let shown = |choice| shown_atoms(&structure, choice).unwrap();
        assert_eq!(shown(AltlocChoice::Highest), [true, false, true, false, true]);
        assert_eq!(shown(AltlocChoice::Code(b'A')), [true, true, false, true, false]);
        assert_eq!(shown(AltlocChoice::Code(b'Z')), [true, false, true, false, true]);
        assert_eq!(shown_atoms(&structure, AltlocChoice::All), None);
    }

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
