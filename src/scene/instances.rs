//! The instance bytes: what both renderers draw from.
//!
//! The GPU reads these structs as vertex buffers and, for the ground's distance field, as texels (RG32Uint for
//! spheres, RGBA32Uint for cylinders: hence sizes that are multiples of 8 and 16). A test reads the offsets out
//! of the shaders and compares.

use crate::color::Srgb8;
use crate::math::Aabb;
use glam::Vec3;

/// A ball: 24 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SphereInstance {
    /// Centre in the block's space, ångström.
    pub center: [f32; 3],
    /// Radius in ångström.
    pub radius: f32,
    /// Colour.
    pub color: Srgb8,
    /// What it stands for: 1 + atom index (a placement adds its own first id).
    pub id: u32,
}

/// How a cylinder ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Cap {
    /// Open: one sees the inside.
    None = 0,
    /// A disc.
    Flat = 1,
    /// A half ball beyond the end point.
    Round = 2,
}

/// A stick between two points: 48 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct CylinderInstance {
    /// One end of the axis in the block's space, ångström.
    pub a: [f32; 3],
    /// Radius in ångström.
    pub radius: f32,
    /// The other end.
    pub b: [f32; 3],
    /// What it stands for: 1 + number of atoms + bond index (a placement adds its own first id).
    pub id: u32,
    /// Colour of the half at `a`.
    pub color_a: Srgb8,
    /// Colour of the half at `b`.
    pub color_b: Srgb8,
    /// [`Cap`] of end `a`, and of end `b` times 4.
    pub caps: u32,
    /// Bit 0: the cap of end `a` lies inside of an opaque ball of the scene, bit 1: that of end `b` does. What is nowhere seen need
    /// not be computed; 0 is never wrong.
    pub hidden: u32,
}

impl CylinderInstance {
    /// Caps as they are packed.
    #[must_use]
    pub const fn pack_caps(a: Cap, b: Cap) -> u32 {
        a as u32 | (b as u32) << 2
    }

    /// The box around the cylinder, its round caps included.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let (a, b) = (Vec3::from(self.a), Vec3::from(self.b));
        Aabb::of_sphere(a, self.radius).union(Aabb::of_sphere(b, self.radius))
    }
}

impl SphereInstance {
    /// The box around the sphere.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb::of_sphere(self.center.into(), self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instances_stay_small() {
        assert_eq!(size_of::<SphereInstance>(), 24);
        assert_eq!(size_of::<CylinderInstance>(), 48);
    }
}
