//! Stereo marks of a flat drawing: a wedge towards the viewer, a row of widening discs away.
//!
//! Only where all atoms lie in the plane z = 0: a structure in space shows its stereochemistry itself. Wavy bonds and double
//! bonds of unknown geometry are drawn as others are.

use super::Style;
use super::instances::{Cap, CylinderInstance};
use super::shapes::ConeInstance;
use crate::structure::{BondStereo, Structure};
use glam::Vec3;
use std::collections::HashMap;

/// Radius of the narrow end in radii of the stick (chosen: a point, but not a needle).
const NARROW: f32 = 0.25;
/// Discs of a hashed bond, and the part of their distance that is disc (as in printed formulas, by eye).
const DISCS: u32 = 6;
const DISC: f32 = 0.45;

/// A wedge from one atom of a bond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Wedge {
    /// The atom at the narrow end.
    pub(super) from: u32,
    /// Whether it is hashed.
    pub(super) is_hashed: bool,
}

/// The wedges of a drawing by bond; none where the structure is in space.
pub(super) fn wedges(structure: &Structure) -> HashMap<u32, Wedge> {
    let marks = structure.bond_stereo();
    let is_flat = || (0..structure.atom_count()).all(|atom| structure.positions().get(atom).z == 0.0);
    if marks.is_empty() || !is_flat() {
        return HashMap::new();
    }
    let wedge = |stereo| match stereo {
        BondStereo::Up => Some(false),
        BondStereo::Down => Some(true),
        BondStereo::Either | BondStereo::CisTransEither => None,
    };
    marks
        .iter()
        .filter_map(|mark| Some((mark.bond, Wedge { from: mark.from, is_hashed: wedge(mark.stereo)? })))
        .collect()
}

/// Radius of a wedge's wide end: nearly twice the stick's, but hidden in the rounded corners of licorice and wider than thin wires,
/// by eye.
pub(super) fn wide_radius(style: Style, stick_radius: f32) -> f32 {
    match style {
        Style::BallAndStick | Style::SpaceFilling => 1.8 * stick_radius,
        Style::Licorice => stick_radius,
        Style::Wireframe => 3.0 * stick_radius,
    }
}

/// The two halves of a wedge between the surfaces of its balls, or the discs of a hashed one. `template` gives the radius of the
/// stick, id, and the colours at the narrow and the wide end.
pub(super) fn draw(
    [narrow, wide]: [Vec3; 2],
    wide_radius: f32,
    is_hashed: bool,
    template: CylinderInstance,
    mut push_cone: impl FnMut(ConeInstance),
    mut push_disc: impl FnMut(CylinderInstance),
) {
    let radius_at = |part: f32| {
        let least = NARROW * template.radius;
        least + (wide_radius - least) * part
    };
    let point = |part: f32| narrow.lerp(wide, part).to_array();
    if is_hashed {
        let period = 1.0 / (DISCS as f32 - 1.0 + DISC);
        for number in 0..DISCS {
            let start = number as f32 * period;
            let end = start + DISC * period;
            let color = if start + end < 1.0 { template.color_a } else { template.color_b };
            push_disc(CylinderInstance {
                a: point(start),
                b: point(end),
                radius: radius_at(0.5 * (start + end)),
                color_a: color,
                color_b: color,
                caps: CylinderInstance::pack_caps(Cap::Flat, Cap::Flat),
                ..template
            });
        }
        return;
    }
    for (start, end, color) in [(0.0, 0.5, template.color_a), (0.5, 1.0, template.color_b)] {
        push_cone(ConeInstance {
            a: point(start),
            radius_a: radius_at(start),
            b: point(end),
            radius_b: radius_at(end),
            color,
            id: template.id,
            reserved: [0; 2],
        });
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{Item, Scene, SceneOptions};

    /// A carbon with four neighbours, the first of them up and the second down.
    fn scene(z: &str) -> Scene {
        let mut text = format!("\n\n\n  5  4  0  0  1  0  0  0  0  0999 V2000\n    0.0000    0.0000    {z} C   0  0\n");
        for (x, y, symbol) in [
            ("1.5000", "0.0000", "F"),
            ("0.0000", "1.5000", "Cl"),
            ("-1.500", "0.0000", "Br"),
            ("0.0000", "-1.500", "H"),
        ] {
            text += &format!("{x:>10}{y:>10}    0.0000 {symbol:<3} 0  0\n");
        }
        text += "  1  2  1  1\n  3  1  1  0\n  1  4  1  0\n  1  5  1  6\nM  END\n";
        let document = crate::import::read_bytes(text.as_bytes(), "a.mol", &Default::default()).unwrap();
        Scene::new(&[Item::of(&document.records[0])], &SceneOptions::default())
    }

    #[test]
    fn a_flat_drawing_has_wedges_that_widen_from_the_marked_atom() {
        let block = &scene("0.0000").blocks[0];
        let cones = &block.cones;
        assert_eq!(cones.len(), 2);
        assert!(cones[0].radius_a < 0.05 && cones[0].radius_b == cones[1].radius_a && cones[1].radius_b > 0.2);
        assert!(cones[0].a[0] > 0.1 && cones[0].b == cones[1].a && cones[1].b[0] < 1.4, "{cones:?}");
        assert_eq!((cones[0].color, cones[1].color), (block.spheres[0].color, block.spheres[1].color));
        assert!(cones.iter().all(|cone| cone.id == 6));
        let discs: Vec<_> = block.cylinders.iter().filter(|stick| stick.id == 9).collect();
        assert!(discs.len() == 6 && discs.windows(2).all(|two| two[0].radius < two[1].radius));
        assert!(discs.iter().all(|disc| disc.a[1] > disc.b[1] && disc.b[1] > -1.5), "downwards from the carbon");
        assert_eq!(block.cylinders.len(), 2 + 6);
    }

    #[test]
    fn a_structure_in_space_has_none() {
        let block = &scene("0.1000").blocks[0];
        assert_eq!((block.cones.len(), block.cylinders.len()), (0, 4));
    }

    #[test]
    fn a_drawing_with_wedges_is_seen_from_the_front() {
        // Else left and right, and with them the meaning of the wedges, would change places.
        let scene = scene("0.0000");
        let turn = scene.placements[0].world_from_block;
        assert!(turn.transform_vector3(glam::Vec3::Z).z > 0.9);
    }
}
