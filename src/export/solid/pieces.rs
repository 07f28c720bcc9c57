//! What a scene is made of, as unit meshes and where they stand.
//!
//! A ball is a ball, a stick one tube or, in two colours, two, with a dome at each round end; cones and rings are one piece each. As closed shells (for
//! printing) a stick is one closed tube whatever its colours, with a whole ball at each round end; of balls at one place, as where sticks meet, there is one,
//! since shells with corners in common are no solids to many programs.
//!
//! Two spaces: `model` is that of the files' axes about the middle of the scene ([`Frame`]), in ångström, in which numbers are small; the writers
//! place it in the file they write.

use super::shape::{Shape, Tessellation, UnitMesh};
use super::{Coordinates, SolidOptions};
use crate::color::Srgb8;
use crate::scene::{Cap, ConeInstance, CylinderInstance, Placement, Scene, SphereInstance, TorusInstance};
use glam::{Affine3A, DVec3, Quat, Vec3};
use std::collections::{HashMap, HashSet};

/// Sticks and cones shorter than this draw nothing (as in the renderers).
const LEAST_LENGTH: f32 = 1e-6;

/// What a piece is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Kind {
    Ball,
    Stick,
    Cone,
    Ring,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Kind::Ball => "balls",
            Kind::Stick => "sticks",
            Kind::Cone => "cones",
            Kind::Ring => "rings",
        }
    }
}

/// A unit mesh in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub(super) shape: Shape,
    pub(super) kind: Kind,
    pub(super) color: Srgb8,
    /// In the block, as its primitive's.
    pub(super) id: u32,
    /// `model = rotation · (scale · unit) + translation`.
    pub(super) translation: Vec3,
    pub(super) rotation: Quat,
    pub(super) scale: Vec3,
}

impl Piece {
    pub(super) fn point(&self, unit: Vec3) -> Vec3 {
        self.rotation * (self.scale * unit) + self.translation
    }

    pub(super) fn normal(&self, unit: Vec3) -> Vec3 {
        self.rotation * (unit / self.scale).normalize_or(unit)
    }

    /// Its corners in the model, in a buffer that is used again.
    pub(super) fn points(&self, mesh: &UnitMesh, points: &mut Vec<Vec3>) {
        points.clear();
        points.extend(mesh.positions.iter().map(|&unit| self.point(unit)));
    }
}

/// How the world becomes the model, and where the model is in the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    model_from_world: Quat,
    /// The model's middle in the coordinates that are written, ångström.
    pub(super) origin: DVec3,
}

impl Frame {
    pub(super) fn new(scene: &Scene, coordinates: Coordinates) -> Frame {
        match coordinates {
            Coordinates::File => Frame { model_from_world: scene.pose.turn.inverse(), origin: scene.pose.center },
            Coordinates::Picture => Frame { model_from_world: Quat::IDENTITY, origin: DVec3::ZERO },
        }
    }

    pub(super) fn model_from_block(&self, placement: &Placement) -> Affine3A {
        Affine3A::from_quat(self.model_from_world) * placement.world_from_block
    }
}

/// Cuts primitives into pieces.
pub(super) struct Cutter {
    tessellation: Tessellation,
    closed: bool,
    /// Of closed shells, where balls are and how large.
    balls: HashSet<([i64; 3], u32)>,
}

/// Balls nearer than this, in ångström, are at one place: less than the least error of a mesh.
const SAME_PLACE: f32 = 1e-4;

impl Cutter {
    /// `closed` makes a closed shell of every piece.
    pub(super) fn new(options: &SolidOptions, closed: bool) -> Cutter {
        Cutter { tessellation: Tessellation::new(options.tolerance), closed, balls: HashSet::new() }
    }

    /// Whether a ball is to be written; of closed ones at the same place the first is.
    fn is_new_ball(&mut self, center: Vec3, radius: f32) -> bool {
        let place = (center / SAME_PLACE).round().to_array().map(|x| x as i64);
        !self.closed || self.balls.insert((place, radius.to_bits()))
    }

    /// Every piece of a placement, in the order of the block.
    pub(super) fn placement<E>(
        &mut self,
        scene: &Scene,
        (frame, placement): (&Frame, &Placement),
        mut push: impl FnMut(Piece) -> Result<(), E>,
    ) -> Result<(), E> {
        let block = &scene.blocks[placement.block];
        let model_from_block = frame.model_from_block(placement);
        for sphere in &block.spheres {
            self.sphere(&model_from_block, sphere, &mut push)?;
        }
        for stick in &block.cylinders {
            self.stick(&model_from_block, stick, &mut push)?;
        }
        for cone in &block.cones {
            self.cone(&model_from_block, cone, &mut push)?;
        }
        for torus in &block.tori {
            self.torus(&model_from_block, torus, &mut push)?;
        }
        Ok(())
    }

    fn sphere<E>(
        &mut self,
        to_model: &Affine3A,
        sphere: &SphereInstance,
        push: &mut impl FnMut(Piece) -> Result<(), E>,
    ) -> Result<(), E> {
        let center = to_model.transform_point3(sphere.center.into());
        if !center.is_finite() || !is_length(sphere.radius) || !self.is_new_ball(center, sphere.radius) {
            return Ok(());
        }
        push(Piece {
            shape: self.tessellation.ball(sphere.radius),
            kind: Kind::Ball,
            color: sphere.color,
            id: sphere.id,
            translation: center,
            rotation: Quat::IDENTITY,
            scale: Vec3::splat(sphere.radius),
        })
    }

    fn stick<E>(
        &mut self,
        to_model: &Affine3A,
        stick: &CylinderInstance,
        push: &mut impl FnMut(Piece) -> Result<(), E>,
    ) -> Result<(), E> {
        let [a, b] = [stick.a, stick.b].map(|end| to_model.transform_point3(end.into()));
        let Some((rotation, length)) = turned_to(a, b) else { return Ok(()) };
        let radius = stick.radius;
        if !is_length(radius) {
            return Ok(());
        }
        let caps = [stick.caps & 3, stick.caps >> 2 & 3];
        let [is_round, is_flat] = [Cap::Round, Cap::Flat].map(|cap| caps.map(|own| own == cap as u32));
        let has_round = is_round[0] || is_round[1];
        // The opacity of a stick is that of its first half.
        let colors = [stick.color_a, Srgb8 { a: stick.color_a.a, ..stick.color_b }];
        let tube = |from: f32, to: f32, caps: [bool; 2], color| Piece {
            shape: self.tessellation.tube(radius, caps, has_round && !self.closed),
            kind: Kind::Stick,
            color,
            id: stick.id,
            translation: a.lerp(b, from),
            rotation,
            scale: Vec3::new(radius, length * (to - from), radius),
        };
        if self.closed {
            push(tube(0.0, 1.0, [true; 2], colors[0]))?;
        } else if colors[0] == colors[1] {
            push(tube(0.0, 1.0, is_flat, colors[0]))?;
        } else {
            push(tube(0.0, 0.5, [is_flat[0], false], colors[0]))?;
            push(tube(0.5, 1.0, [false, is_flat[1]], colors[1]))?;
        }
        for end in [0, 1] {
            if !is_round[end] || !self.is_new_ball([a, b][end], radius) {
                continue;
            }
            let shape = match self.closed {
                true => self.tessellation.ball(radius),
                false => self.tessellation.dome(radius),
            };
            // Half a turn about x: +Y becomes −Y, and the rim's corners are those of the tube's other end.
            let rotation = if end == 0 { rotation * Quat::from_xyzw(1.0, 0.0, 0.0, 0.0) } else { rotation };
            let (kind, color, scale) = (Kind::Stick, colors[end], Vec3::splat(radius));
            push(Piece { shape, kind, color, id: stick.id, translation: [a, b][end], rotation, scale })?;
        }
        Ok(())
    }

    fn cone<E>(
        &mut self,
        to_model: &Affine3A,
        cone: &ConeInstance,
        push: &mut impl FnMut(Piece) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut ends = [(cone.a, cone.radius_a), (cone.b, cone.radius_b)]
            .map(|(end, radius)| (to_model.transform_point3(end.into()), radius.max(0.0)));
        if ends[0].1 < ends[1].1 {
            ends.swap(0, 1);
        }
        let [(from, wide), (to, narrow)] = ends;
        let Some((rotation, length)) = turned_to(from, to) else { return Ok(()) };
        if !is_length(wide) || !narrow.is_finite() {
            return Ok(());
        }
        push(Piece {
            shape: self.tessellation.cone(wide, narrow),
            kind: Kind::Cone,
            color: cone.color,
            id: cone.id,
            translation: from,
            rotation,
            scale: Vec3::new(wide, length, wide),
        })
    }

    fn torus<E>(
        &mut self,
        to_model: &Affine3A,
        torus: &TorusInstance,
        push: &mut impl FnMut(Piece) -> Result<(), E>,
    ) -> Result<(), E> {
        let center = to_model.transform_point3(torus.center.into());
        let axis = to_model.transform_vector3(torus.axis.into());
        let Some((rotation, _)) = turned_to(Vec3::ZERO, axis) else { return Ok(()) };
        if !center.is_finite() || !is_length(torus.ring_radius) || !is_length(torus.tube_radius) {
            return Ok(());
        }
        push(Piece {
            shape: self.tessellation.ring(torus.ring_radius, torus.tube_radius.min(torus.ring_radius)),
            kind: Kind::Ring,
            color: torus.color,
            id: torus.id,
            translation: center,
            rotation,
            scale: Vec3::splat(torus.ring_radius),
        })
    }
}

fn is_length(x: f32) -> bool {
    x.is_finite() && x > 0.0
}

/// The rotation that takes +Y to the way from one point to another, and how far that is.
fn turned_to(a: Vec3, b: Vec3) -> Option<(Quat, f32)> {
    let length = a.distance(b);
    let way = (b - a).try_normalize()?;
    (length.is_finite() && length > LEAST_LENGTH).then(|| (Quat::from_rotation_arc(Vec3::Y, way), length))
}

/// The triangles of a placement as one mesh, vertices that are the same being one.
#[derive(Debug, Default)]
pub(super) struct Surface {
    /// In the model, ångström.
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) colors: Vec<Srgb8>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Surface {
    pub(super) fn of(scene: &Scene, frame: &Frame, placement: &Placement) -> Surface {
        let triangles = &scene.blocks[placement.block].triangles;
        let to_model = frame.model_from_block(placement);
        let is_mirrored = to_model.matrix3.determinant() < 0.0;
        let mut surface = Surface::default();
        let mut seen: HashMap<([u32; 6], Srgb8), u32> = HashMap::new();
        for triangle in triangles {
            let mut corners = [0, 1, 2].map(|corner| {
                // The opacity is that of the first corner.
                let color = Srgb8 { a: triangle.colors[0].a, ..triangle.colors[corner] };
                let (position, normal) = (triangle.corners[corner], triangle.normals[corner]);
                let mut key = [0; 6];
                let numbers = position.iter().chain(&normal);
                key.iter_mut().zip(numbers).for_each(|(slot, x)| *slot = (x + 0.0).to_bits());
                *seen.entry((key, color)).or_insert_with(|| {
                    surface.positions.push(to_model.transform_point3(position.into()));
                    surface.normals.push(to_model.transform_vector3(normal.into()).normalize_or(Vec3::Y));
                    surface.colors.push(color);
                    surface.positions.len() as u32 - 1
                })
            });
            if is_mirrored {
                corners.swap(1, 2);
            }
            surface.triangles.push(corners);
        }
        surface
    }

    pub(super) fn is_see_through(&self) -> bool {
        self.colors.iter().any(|color| color.a < 255)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Block;

    const RED: Srgb8 = Srgb8::rgb(255, 0, 0);
    const BLUE: Srgb8 = Srgb8::rgb(0, 0, 255);

    fn pieces(block: Block, closed: bool) -> Vec<Piece> {
        let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
        let scene = Scene::from_blocks(vec![block], vec![placement]);
        let options = SolidOptions::default();
        let frame = Frame::new(&scene, Coordinates::File);
        let mut pieces = Vec::new();
        let result: Result<(), ()> = Cutter::new(&options, closed).placement(&scene, (&frame, &placement), |piece| {
            pieces.push(piece);
            Ok(())
        });
        assert!(result.is_ok());
        pieces
    }

    fn stick(caps: [Cap; 2], colors: [Srgb8; 2], b: [f32; 3]) -> Block {
        let caps = CylinderInstance::pack_caps(caps[0], caps[1]);
        let [color_a, color_b] = colors;
        let stick = CylinderInstance { a: [0.0; 3], radius: 0.1, b, id: 7, color_a, color_b, caps, hidden: 0 };
        Block { cylinders: vec![stick], id_count: 7, ..Block::default() }
    }

    #[test]
    fn a_stick_of_two_colours_is_two_halves_and_its_round_ends_reach_beyond() {
        let pieces_of = pieces(stick([Cap::Round, Cap::None], [RED, BLUE], [0.0, 0.0, 2.0]), false);
        assert_eq!(pieces_of.iter().map(|piece| piece.color).collect::<Vec<_>>(), [RED, BLUE, RED]);
        let mut meshes = super::super::shape::Meshes::default();
        let mut extent = |piece: &Piece| {
            let mut points = Vec::new();
            piece.points(meshes.of(piece.shape), &mut points);
            let z = points.iter().map(|point| point.z);
            [z.clone().fold(f32::MAX, f32::min), z.fold(f32::MIN, f32::max)]
        };
        let extents: Vec<[f32; 2]> = pieces_of.iter().map(&mut extent).collect();
        for (found, wanted) in extents.iter().zip([[0.0, 1.0], [1.0, 2.0], [-0.1, 0.0]]) {
            assert!((found[0] - wanted[0]).abs() < 0.005 && (found[1] - wanted[1]).abs() < 0.005, "{extents:?}");
        }
        assert!(pieces_of.iter().all(|piece| piece.id == 7));
    }

    #[test]
    fn round_ends_meet_the_tube_without_a_gap() {
        let pieces = pieces(stick([Cap::Round, Cap::Round], [RED, RED], [1.0, 2.0, 3.0]), false);
        let mut meshes = super::super::shape::Meshes::default();
        let mut points_of = |piece: &Piece| {
            let mut points = Vec::new();
            piece.points(meshes.of(piece.shape), &mut points);
            points
        };
        let tube = points_of(&pieces[0]);
        let around = tube.len() / 2;
        for dome in &pieces[1..] {
            let rim = &points_of(dome)[..around];
            let near = |point: &Vec3| tube.iter().any(|other| other.distance(*point) < 1e-5);
            assert!(rim.iter().all(near), "{dome:?}");
        }
    }

    #[test]
    fn closed_sticks_are_whole_whatever_their_colours() {
        let pieces = pieces(stick([Cap::None, Cap::Round], [RED, BLUE], [0.0, -1.0, 0.0]), true);
        assert!(matches!(pieces[0].shape, Shape::Tube(_, [true, true])), "{pieces:?}");
        assert!(matches!(pieces[1].shape, Shape::Ball(_)));
        assert_eq!(pieces.len(), 2);
    }

    #[test]
    fn where_closed_sticks_meet_there_is_one_ball() {
        let mut block = stick([Cap::Round; 2], [RED; 2], [0.0, 0.0, 2.0]);
        block.cylinders.push(CylinderInstance { b: [0.0, 2.0, 0.0], ..block.cylinders[0] });
        block.spheres.push(SphereInstance { center: [0.0; 3], radius: 0.1, color: RED, id: 1 });
        let balls =
            |closed| pieces(block.clone(), closed).iter().filter(|piece| matches!(piece.shape, Shape::Ball(_))).count();
        assert_eq!((balls(true), balls(false)), (3, 1));
    }

    #[test]
    fn what_has_no_length_or_is_no_number_is_left_out() {
        assert!(pieces(stick([Cap::Flat; 2], [RED; 2], [0.0; 3]), false).is_empty());
        assert!(pieces(stick([Cap::Flat; 2], [RED; 2], [f32::NAN; 3]), false).is_empty());
        let ball = |radius| SphereInstance { center: [0.0; 3], radius, color: RED, id: 1 };
        let block = Block { spheres: vec![ball(0.0), ball(f32::NAN), ball(1.0)], id_count: 1, ..Block::default() };
        assert_eq!(pieces(block, false).len(), 1);
    }

    #[test]
    fn a_cone_stands_on_its_wide_end() {
        let cone = ConeInstance {
            a: [0.0; 3],
            radius_a: 0.0,
            b: [3.0, 0.0, 0.0],
            radius_b: 1.0,
            color: RED,
            id: 1,
            reserved: [0; 2],
        };
        let pieces = pieces(Block { cones: vec![cone], id_count: 1, ..Block::default() }, false);
        assert!((pieces[0].point(Vec3::Y) - Vec3::ZERO).length() < 1e-5);
        assert_eq!(pieces[0].translation, Vec3::new(3.0, 0.0, 0.0));
        // Steeper than 45° from the axis: the cone is long.
        let normal = pieces[0].normal(Vec3::new(1.0, 1.0, 0.0));
        assert!((normal.x + 1.0 / 10.0f32.sqrt()).abs() < 1e-4, "{normal}");
    }
}
