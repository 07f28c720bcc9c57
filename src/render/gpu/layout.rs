//! Bytes that cross to the device: uniforms, instance attributes, texel packing. Tests compare them with the WGSL.

use crate::render::bounds::TORUS_PIECES;
use crate::render::opacity::{backwards, sample_turn};
use glam::{Affine3A, Vec2, Vec3};

/// Twin of the WGSL `SampleConstants`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SampleConstants {
    /// Upper left pixel of the target in the full picture.
    pub origin: [u32; 2],
    /// Pixels of the target that are drawn to.
    pub size: [u32; 2],
    /// Place of the sample in its pixel, 0–1.
    pub offset: [f32; 2],
    /// Samples summed before this one; in the resolve pass, all of them.
    pub done: u32,
    /// The sample's turns and their number, as [`SampleConstants::pack_turn`] has them.
    pub turn: u32,
}

impl SampleConstants {
    /// Turn of sample `index` of `count` by which see-through primitives are drawn, in 12 bits, that by which they hide light, in 12
    /// bits, and log2 of the number of turns.
    #[must_use]
    pub fn pack_turn(index: u32, count: u32) -> u32 {
        let (turn, turns) = sample_turn(index, count.min(4096));
        turn | backwards(turn, turns) << 12 | turns.trailing_zeros() << 24
    }
}

/// Twin of the WGSL `PlacementConstants`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PlacementConstants {
    /// Columns of the transform from block to view space, and the translation; fourth components are 0.
    pub columns: [[f32; 4]; 4],
    /// First: added to the ids of the block.
    pub first_id: [u32; 4],
}

impl PlacementConstants {
    /// Of a placement.
    #[must_use]
    pub fn new(view_from_block: &Affine3A, first_id: u32) -> PlacementConstants {
        let column = |v: Vec3| [v.x, v.y, v.z, 0.0];
        let m = view_from_block.matrix3;
        PlacementConstants {
            columns: [m.x_axis.into(), m.y_axis.into(), m.z_axis.into(), view_from_block.translation.into()]
                .map(column),
            first_id: [first_id, 0, 0, 0],
        }
    }
}

/// Twin of the WGSL `FieldConstants`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct FieldConstants {
    /// Where each level of the hierarchy starts; the last entry is the end.
    pub levels: [u32; 20],
    /// Number of levels, number of primitives.
    pub counts: [u32; 4],
}

/// Attributes of a [`crate::scene::SphereInstance`], as `vs_sphere` reads them.
pub const SPHERE_ATTRIBUTES: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x4, 1 => Uint32x2];

/// Attributes of a [`crate::scene::CylinderInstance`], as `vs_cylinder` reads them.
pub const CYLINDER_ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x3, 2 => Uint32, 3 => Uint32x3];

/// Attributes of a [`crate::scene::ConeInstance`], as `vs_cone` reads them.
pub const CONE_ATTRIBUTES: [wgpu::VertexAttribute; 3] =
    wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x4, 2 => Uint32x2];

/// Attributes of a [`crate::scene::TorusInstance`], as `vs_torus` reads them.
pub const TORUS_ATTRIBUTES: [wgpu::VertexAttribute; 3] =
    wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x4, 2 => Uint32x2];

/// Attributes of a [`crate::scene::TriangleInstance`], as `vs_triangle` reads them.
pub const TRIANGLE_ATTRIBUTES: [wgpu::VertexAttribute; 7] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x3, 4 => Float32x3, 5 => Float32x3, 6 => Uint32x4
];

/// Number of an instance in its buffer, as `vs_sphere_listed` and `vs_cylinder_listed` read it.
pub const LISTED_ATTRIBUTES: [wgpu::VertexAttribute; 1] = wgpu::vertex_attr_array![0 => Uint32];

/// Vertices of an instance of each kind: a quad, and for a torus six a piece of its tube.
pub const VERTICES: [u32; KINDS] = [4, 4, 4, 6 * TORUS_PIECES, 4];

/// Kinds of primitives, each with a pipeline of its own: spheres, cylinders, cones, tori, triangles.
pub const KINDS: usize = 5;

/// Texels of the surface target: id, depth, normal, colour.
pub const SURFACE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
/// Depth of the geometry pass.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Tubes of a light: numbers of primitives, and where their lists start.
pub const WORD_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Sums of samples, floats in integer bits.
pub const SUM_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
/// The finished picture.
pub const IMAGE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Text over a picture in a window: sRGB, straight alpha.
pub const TEXT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Uint;
/// Light on the ground, floats in integer bits.
pub const GROUND_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;
/// Boxes and primitives of the distance field.
pub const FIELD_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Texels in a row of the field's textures.
pub const FIELD_ROW: u32 = 2048;

/// Twin of the WGSL `unpack_normal`.
#[must_use]
pub fn unpack_normal(bits: u32) -> Vec3 {
    let part = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let p = Vec2::new(part(bits), part(bits >> 16));
    let z = 1.0 - p.x.abs() - p.y.abs();
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let xy = if z < 0.0 { Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)) } else { p };
    xy.extend(z).normalize_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `pack_normal` in shaders/geometry.wgsl has it.
    fn pack_normal(n: Vec3) -> u32 {
        let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
        let sign = |x: f32| if x >= 0.0 { 1.0f32 } else { -1.0 };
        let folded = Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y));
        let p = if n.z < 0.0 { folded } else { p };
        let part = |x: f32| u32::from((0.5 + 32767.0 * x.clamp(-1.0, 1.0)).floor() as i16 as u16);
        part(p.x) | part(p.y) << 16
    }

    #[test]
    fn packed_turns_hold_both_orders_and_their_number() {
        for samples in [1, 2, 16, 64, 4096, 9999] {
            let count = samples.min(4096);
            for sample in (0..count).step_by(1 + count as usize / 64) {
                let (turn, turns) = sample_turn(sample, count);
                let packed = SampleConstants::pack_turn(sample, samples);
                assert_eq!((packed & 0xfff, 1 << (packed >> 24)), (turn, turns));
                assert_eq!(packed >> 12 & 0xfff, backwards(turn, turns));
            }
        }
    }

    #[test]
    fn packed_normals_come_back() {
        let mut worst = 0.0f32;
        for i in 0..2000 {
            let f = i as f32;
            let n = Vec3::new((f * 0.7).sin(), (f * 1.3).cos(), (f * 0.37).sin()).normalize();
            worst = worst.max((unpack_normal(pack_normal(n)) - n).length());
        }
        for n in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
            worst = worst.max((unpack_normal(pack_normal(n)) - n).length());
        }
        assert!(worst < 1e-4, "{worst}");
    }
}
