//! Measured distances, angles and dihedrals: what they are, and how they are marked in a scene.
//!
//! Marks are rows of thin dashes from centre to centre of the atoms, for an angle an arc as well, with the number as a label in the middle:
//! of the two atoms, of the arc, or of the bond that the dihedral turns about. They belong to the scene, so that pictures of it have them.

use super::dashes::dashes;
use super::instances::{Cap, CylinderInstance};
use super::{Block, Label, Scene};
use crate::color::Srgb8;
use glam::{DVec3, Vec3};

/// An atom of one of the structures that a scene is built from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct AtomPlace {
    /// Which structure, from 0.
    pub item: u32,
    /// Which of its atoms, from 0; those of further copies are counted on.
    pub atom: u32,
}

/// Two atoms for a distance, three for an angle, four for a dihedral; any other number measures nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measurement {
    /// The atoms in their order.
    pub atoms: Vec<AtomPlace>,
}

/// Radius of the dashes in ångström (chosen: half of a hydrogen bond's in ball-and-stick, so that the two are told apart).
const RADIUS: f32 = 0.035;
/// Colour of the dashes (chosen: none of the common elements has it, and it is seen on white and on black).
const COLOR: Srgb8 = Srgb8::rgb(214, 120, 16);

/// What is measured between points, as text: `1.523 Å`, `109.5°`. `None` for a number of points that measures nothing, and where an
/// angle has none.
#[must_use]
pub fn measured(points: &[DVec3]) -> Option<String> {
    match *points {
        [a, b] => Some(format!("{:.3} Å", a.distance(b))),
        [a, b, c] => angle(a - b, c - b).map(|degrees| format!("{degrees:.1}°")),
        [a, b, c, d] => dihedral([a, b, c, d]).map(|degrees| format!("{degrees:.1}°")),
        _ => None,
    }
}

/// Degrees between two vectors; `None` if one has no length. By the arctangent, which keeps its digits near 0° and 180°.
fn angle(u: DVec3, v: DVec3) -> Option<f64> {
    (u.length_squared() > 0.0 && v.length_squared() > 0.0).then(|| u.cross(v).length().atan2(u.dot(v)).to_degrees())
}

/// Degrees from −180 to 180, positive where the far bond is clockwise of the near one (IUPAC); `None` where three points are in line.
fn dihedral([a, b, c, d]: [DVec3; 4]) -> Option<f64> {
    let (first, axis, last) = (b - a, c - b, d - c);
    let (n1, n2) = (first.cross(axis), axis.cross(last));
    let defined = n1.length_squared() > 1e-12 && n2.length_squared() > 1e-12;
    defined.then(|| (axis.length() * first.dot(n2)).atan2(n1.dot(n2)).to_degrees())
}

/// How far an arc is from the apex: as a part of the shorter leg, and at most, in ångström (chosen: clear of the balls and sticks of
/// bonded atoms, and not lost between far ones). Its pieces, from 0° to 180°.
const ARC: (f32, f32) = (0.62, 1.6);
const ARC_PIECES: f32 = 24.0;

/// An arc between the legs of an angle, every other piece of it; where it has its middle. Legs in line have none.
fn arc([a, apex, b]: [Vec3; 3], id: u32, block: &mut Block) -> Vec3 {
    let (u, v) = (a - apex, b - apex);
    let radius = (ARC.0 * u.length().min(v.length())).min(ARC.1);
    let (Some(along), Some(side)) = (u.try_normalize(), v.reject_from(u).try_normalize()) else {
        return apex + u.normalize_or_zero() * radius;
    };
    let whole = u.angle_between(v);
    let at = |part: f32| apex + (along * (part * whole).cos() + side * (part * whole).sin()) * radius;
    // An odd number, so that it begins and ends with a piece.
    let pieces = ((whole / std::f32::consts::PI * ARC_PIECES) as u32).max(2) | 1;
    for piece in (0..pieces).step_by(2) {
        let [start, end] = [piece, piece + 1].map(|n| at(n as f32 / pieces as f32).to_array());
        block.cylinders.push(CylinderInstance {
            a: start,
            b: end,
            radius: RADIUS,
            id,
            color_a: COLOR,
            color_b: COLOR,
            caps: CylinderInstance::pack_caps(Cap::Round, Cap::Round),
            hidden: 0,
        });
    }
    at(0.5)
}

/// The marks of measurements.
pub(super) struct Marks {
    pub(super) block: Block,
    pub(super) labels: Vec<Label>,
}

/// Marks between the balls of a scene; a measurement with an atom that is not drawn has none. Ids in the block count the measurements.
pub(super) fn marks(scene: &Scene, measurements: &[Measurement]) -> Marks {
    let mut marks = Marks { block: Block::default(), labels: Vec::new() };
    for (id, measurement) in (1..).zip(measurements) {
        let balls: Option<Vec<(u32, Vec3, f32)>> = (measurement.atoms.iter())
            .map(|&place| {
                let id = scene.id_of(place)?;
                scene.ball(id).map(|(center, radius)| (id, center, radius))
            })
            .collect();
        let Some(balls) = balls else { continue };
        let points: Vec<DVec3> = balls.iter().map(|(_, center, _)| center.as_dvec3()).collect();
        let Some(text) = measured(&points) else { continue };
        marks.block.id_count = id;
        for pair in balls.windows(2) {
            let template =
                CylinderInstance { radius: RADIUS, id, color_a: COLOR, color_b: COLOR, ..bytemuck::Zeroable::zeroed() };
            dashes(pair[0].1, pair[1].1, template, |dash| marks.block.cylinders.push(dash));
        }
        let middle = |a: usize, b: usize| (balls[a].1 + balls[b].1) * 0.5;
        let anchor = match balls.len() {
            2 => middle(0, 1),
            3 => arc([balls[0].1, balls[1].1, balls[2].1], id, &mut marks.block),
            _ => middle(1, 2),
        };
        // Seen where any of the atoms or whatever else is at the anchor: a number that was asked for is not hidden.
        let radius = balls.iter().map(|(_, center, radius)| center.distance(anchor) + radius).fold(0.0, f32::max);
        marks.labels.push(Label { text: text.into_boxed_str(), anchor, ids: [1, u32::MAX - 1], radius });
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Item, SceneOptions};

    #[test]
    fn distances_angles_and_dihedrals() {
        let [o, x, y] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert_eq!(measured(&[o, x * 1.5]).as_deref(), Some("1.500 Å"));
        assert_eq!(measured(&[x, o, y]).as_deref(), Some("90.0°"));
        assert_eq!(measured(&[x, o, -x]).as_deref(), Some("180.0°"));
        // From a over the axis b→c: the far bond is turned clockwise, seen from b.
        assert_eq!(measured(&[y, o, x, x + DVec3::Z]).as_deref(), Some("90.0°"));
        assert_eq!(measured(&[y, o, x, x - DVec3::Z]).as_deref(), Some("-90.0°"));
        assert_eq!(measured(&[y, o, x, x + y]).as_deref(), Some("0.0°"));
        for nothing in [&[o][..], &[o, o, x], &[o, x, x * 2.0, y], &[o; 5]] {
            assert_eq!(measured(nothing), None);
        }
    }

    #[test]
    fn marks_stand_between_the_balls_and_the_number_in_their_middle() {
        let document = crate::import::read_bytes(b"3\n\nO 0 0 0\nO 3 0 0\nO 0 4 0\n", "a.xyz", &Default::default());
        let molecule = &document.unwrap().records[0];
        let place = |atom| AtomPlace { item: 0, atom };
        let of = |atoms: &[u32]| Measurement { atoms: atoms.iter().map(|&atom| place(atom)).collect() };
        let options = SceneOptions {
            measurements: vec![of(&[0, 1]), of(&[1, 0, 2]), of(&[0, 7]), of(&[0])],
            ..SceneOptions::default()
        };
        let scene = Scene::new(&[Item::of(molecule)], &options);
        let texts: Vec<&str> = scene.overlay.labels.iter().map(|label| &*label.text).collect();
        assert_eq!(texts, ["3.000 Å", "90.0°"]);
        let balls: Vec<_> = scene.world_spheres().map(|(center, _)| center).collect();
        assert!((scene.overlay.labels[0].anchor - (balls[0] + balls[1]) * 0.5).length() < 1e-5);
        let block = &scene.blocks[scene.blocks.len() - 1];
        let reach = |id: u32| {
            let own = block.cylinders.iter().filter(|dash| dash.id == id);
            own.map(|dash| Vec3::from(dash.a).distance(dash.b.into())).sum::<f32>()
        };
        assert!(reach(1) > 1.0 && reach(1) < 3.0 && reach(2) > 2.0 && block.id_count == 2);
        // The arc of the angle: 1.6 Å about the apex, in its plane, its middle between the legs.
        let apex = balls[0];
        let [u, v] = [balls[1] - apex, balls[2] - apex].map(Vec3::normalize);
        let middle = scene.overlay.labels[1].anchor - apex;
        assert!((middle.length() - 1.6).abs() < 1e-4 && (middle.dot(u) - middle.dot(v)).abs() < 1e-4);
        // Their ids are nobody else's.
        assert_eq!(scene.item_of(scene.placements[1].first_id + 1), None);
        assert_eq!(scene.item_of(2), Some((0, 0, 1)));
    }
}
