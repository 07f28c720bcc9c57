//! The numbers of a glTF file: which column comes where, and each written as it is made.

use super::super::pieces::Surface;
use super::super::shape::{Meshes, Shape};
use super::Group;
use crate::color::linear_from_srgb;
use glam::Vec3;
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::validation::Checked::Valid;
use gltf_json::{Accessor, Index};
use serde_json::{Value, json};
use std::io::{self, Write};

/// What a buffer view holds; numbers are those of groups or surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Column {
    UnitPositions(Shape),
    UnitNormals(Shape),
    UnitCorners(Shape),
    Translations(usize),
    Rotations(usize),
    Scales(usize),
    Positions(usize),
    Normals(usize),
    Corners(usize),
    SurfacePositions(usize),
    SurfaceNormals(usize),
    SurfaceColors(usize),
    SurfaceCorners(usize),
}

/// Hands out places in the buffer.
#[derive(Default)]
pub(super) struct Packer {
    pub(super) accessors: Vec<Accessor>,
    pub(super) views: Vec<View>,
    columns: Vec<Column>,
    length: u64,
}

/// What the numbers are made from.
pub(super) struct Numbers<'a> {
    pub(super) groups: &'a [Group],
    pub(super) surfaces: &'a [(usize, Surface)],
}

impl Packer {
    /// Bytes of all columns.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Vectors of f32 that are no vertices.
    pub(super) fn vectors(
        &mut self,
        column: Column,
        count: u64,
        components: u64,
        bounds: Option<[Vec3; 2]>,
    ) -> Index<Accessor> {
        let type_ = if components == 4 { Type::Vec4 } else { Type::Vec3 };
        self.push(column, count, (ComponentType::F32, type_), 4 * components, bounds, None)
    }

    /// Vectors of f32 of vertices.
    pub(super) fn vertices(
        &mut self,
        column: Column,
        count: u64,
        components: u64,
        bounds: Option<[Vec3; 2]>,
    ) -> Index<Accessor> {
        let type_ = if components == 4 { Type::Vec4 } else { Type::Vec3 };
        let target = Some(Target::ArrayBuffer);
        self.push(column, count, (ComponentType::F32, type_), 4 * components, bounds, target)
    }

    /// Colours of vertices: linear, as 16 bits a channel, since 8 would show steps where it is dark.
    pub(super) fn colors(&mut self, column: Column, count: u64) -> Index<Accessor> {
        let index = self.push(column, count, (ComponentType::U16, Type::Vec4), 8, None, Some(Target::ArrayBuffer));
        if let Some(accessor) = self.accessors.last_mut() {
            accessor.normalized = true;
        }
        index
    }

    /// Corners of triangles by the numbers of so many vertices.
    pub(super) fn corners(&mut self, column: Column, count: u64, vertices: u64) -> Index<Accessor> {
        let kind = if is_short(vertices) { ComponentType::U16 } else { ComponentType::U32 };
        self.push(column, count, (kind, Type::Scalar), kind.size() as u64, None, Some(Target::ElementArrayBuffer))
    }

    /// Corners as 32 bits whatever their number.
    pub(super) fn wide_corners(&mut self, column: Column, count: u64) -> Index<Accessor> {
        self.corners(column, count, u64::MAX)
    }

    fn push(
        &mut self,
        column: Column,
        count: u64,
        (component, type_): (ComponentType, Type),
        size: u64,
        bounds: Option<[Vec3; 2]>,
        target: Option<Target>,
    ) -> Index<Accessor> {
        let view = View {
            buffer: Index::new(0),
            byte_length: (count * size).into(),
            byte_offset: Some(self.length.into()),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: None,
        };
        // Every column begins at a multiple of 4.
        self.length += (count * size).next_multiple_of(4);
        self.columns.push(column);
        self.views.push(view);
        let three = |v: Vec3| -> Value { json!(v.to_array().map(f64::from)) };
        self.accessors.push(Accessor {
            buffer_view: Some(Index::new(self.views.len() as u32 - 1)),
            byte_offset: None,
            count: count.into(),
            component_type: Valid(GenericComponentType(component)),
            extensions: None,
            extras: None,
            type_: Valid(type_),
            min: bounds.map(|[low, _]| three(low)),
            max: bounds.map(|[_, high]| three(high)),
            name: None,
            normalized: false,
            sparse: None,
        });
        Index::new(self.accessors.len() as u32 - 1)
    }

    /// All columns in their order.
    pub(super) fn write(&self, numbers: &Numbers<'_>, out: &mut dyn Write) -> io::Result<()> {
        let mut meshes = Meshes::default();
        for &column in &self.columns {
            let mut counted = Counted { out: &mut *out, count: 0 };
            numbers.write(column, &mut meshes, &mut counted)?;
            let filling = counted.count.next_multiple_of(4) - counted.count;
            out.write_all(&[0; 3][..filling as usize])?;
        }
        Ok(())
    }
}

/// Whether 16 bits number so many vertices; the last number is reserved.
fn is_short(vertices: u64) -> bool {
    vertices < u64::from(u16::MAX)
}

struct Counted<'a> {
    out: &'a mut dyn Write,
    count: u64,
}

impl Counted<'_> {
    fn floats<const N: usize>(&mut self, numbers: [f32; N]) -> io::Result<()> {
        self.count += 4 * N as u64;
        self.out.write_all(bytemuck::cast_slice(&numbers.map(|x| x.to_bits().to_le())))
    }

    fn words(&mut self, words: &[u32]) -> io::Result<()> {
        self.count += 4 * words.len() as u64;
        words.iter().try_for_each(|word| self.out.write_all(&word.to_le_bytes()))
    }

    fn shorts(&mut self, shorts: &[u16]) -> io::Result<()> {
        self.count += 2 * shorts.len() as u64;
        shorts.iter().try_for_each(|short| self.out.write_all(&short.to_le_bytes()))
    }
}

impl Numbers<'_> {
    fn write(&self, column: Column, meshes: &mut Meshes, out: &mut Counted<'_>) -> io::Result<()> {
        let mut all = |points: &[Vec3]| points.iter().try_for_each(|point| out.floats(point.to_array()));
        match column {
            Column::UnitPositions(shape) => all(&meshes.of(shape).positions),
            Column::UnitNormals(shape) => all(&meshes.of(shape).normals),
            Column::SurfacePositions(number) => all(&self.surfaces[number].1.positions),
            Column::SurfaceNormals(number) => all(&self.surfaces[number].1.normals),
            Column::UnitCorners(shape) => {
                let mesh = meshes.of(shape);
                if is_short(mesh.positions.len() as u64) {
                    let short = |corners: &[u32; 3]| out.shorts(&corners.map(|corner| corner as u16));
                    mesh.triangles.iter().try_for_each(short)
                } else {
                    mesh.triangles.iter().try_for_each(|corners| out.words(corners))
                }
            }
            Column::SurfaceCorners(number) => {
                self.surfaces[number].1.triangles.iter().try_for_each(|corners| out.words(corners))
            }
            Column::SurfaceColors(number) => self.surfaces[number].1.colors.iter().try_for_each(|color| {
                let linear = |byte: u8| (linear_from_srgb(f32::from(byte) / 255.0) * 65535.0).round() as u16;
                let [r, g, b] = [color.r, color.g, color.b].map(linear);
                out.shorts(&[r, g, b, u16::from(color.a) * 257])
            }),
            Column::Translations(group) => {
                self.groups[group].pieces.iter().try_for_each(|piece| out.floats(piece.translation.to_array()))
            }
            Column::Rotations(group) => {
                self.groups[group].pieces.iter().try_for_each(|piece| out.floats(piece.rotation.to_array()))
            }
            Column::Scales(group) => {
                self.groups[group].pieces.iter().try_for_each(|piece| out.floats(piece.scale.to_array()))
            }
            Column::Positions(group) => self.groups[group].pieces.iter().try_for_each(|piece| {
                let positions = &meshes.of(piece.shape).positions;
                positions.iter().try_for_each(|&unit| out.floats(piece.point(unit).to_array()))
            }),
            Column::Normals(group) => self.groups[group].pieces.iter().try_for_each(|piece| {
                let normals = &meshes.of(piece.shape).normals;
                normals.iter().try_for_each(|&unit| out.floats(piece.normal(unit).to_array()))
            }),
            Column::Corners(group) => {
                let mut first = 0;
                self.groups[group].pieces.iter().try_for_each(|piece| {
                    let mesh = meshes.of(piece.shape);
                    let base = first;
                    first += mesh.positions.len() as u32;
                    mesh.triangles.iter().try_for_each(|corners| out.words(&corners.map(|corner| base + corner)))
                })
            }
        }
    }
}
