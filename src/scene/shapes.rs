//! The instance bytes of cones, tori and triangles: as [`super::instances`], for what is less frequent.
//!
//! An alpha below 255 in a colour (`color`, a cylinder's `color_a`, a triangle's first) makes the primitive see-through: it is drawn
//! in that part of the samples. Below a half it throws no shadow, hides no sky and has no id, depth or normal in a picture.

use crate::color::Srgb8;
use crate::math::Aabb;
use glam::Vec3;

/// A cone between two points, pointed or truncated, with flat caps: 48 bytes. Arrowheads and wedges.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ConeInstance {
    /// One end of the axis in the block's space, ångström.
    pub a: [f32; 3],
    /// Radius at `a` in ångström; 0 for a point.
    pub radius_a: f32,
    /// The other end.
    pub b: [f32; 3],
    /// Radius at `b` in ångström; 0 for a point.
    pub radius_b: f32,
    /// Colour.
    pub color: Srgb8,
    /// What it stands for, as in [`super::CylinderInstance`].
    pub id: u32,
    /// Zero; fills the 48 bytes.
    pub reserved: [u32; 2],
}

/// A ring of circular cross-section: 48 bytes. Aromatic rings and halos.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct TorusInstance {
    /// Centre in the block's space, ångström.
    pub center: [f32; 3],
    /// Radius of the circle that the tube follows, ångström.
    pub ring_radius: f32,
    /// Unit normal of the plane of that circle.
    pub axis: [f32; 3],
    /// Radius of the tube, ångström; less than `ring_radius`.
    pub tube_radius: f32,
    /// Colour.
    pub color: Srgb8,
    /// What it stands for, as in [`super::CylinderInstance`].
    pub id: u32,
    /// Zero; fills the 48 bytes.
    pub reserved: [u32; 2],
}

/// A triangle of a mesh, seen from both sides: 96 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct TriangleInstance {
    /// The corners in the block's space, ångström.
    pub corners: [[f32; 3]; 3],
    /// Unit normals at the corners; the surface's are interpolated between them.
    pub normals: [[f32; 3]; 3],
    /// Colours at the corners; interpolated in linear light. The opacity is that of the first.
    pub colors: [Srgb8; 3],
    /// What it stands for; all triangles of a mesh have the same.
    pub id: u32,
    /// Zero; fills the 96 bytes.
    pub reserved: [u32; 2],
}

impl ConeInstance {
    /// The box around it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb::of_sphere(self.a.into(), self.radius_a).union(Aabb::of_sphere(self.b.into(), self.radius_b))
    }
}

impl TorusInstance {
    /// The box around it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let axis = Vec3::from(self.axis);
        // A circle reaches its radius times the sine of the angle between its axis and the direction.
        let reach = (Vec3::ONE - axis * axis).max(Vec3::ZERO).map(f32::sqrt) * self.ring_radius + self.tube_radius;
        let center = Vec3::from(self.center);
        Aabb { min: center - reach, max: center + reach }
    }
}

impl TriangleInstance {
    /// The box around it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.corners.iter().fold(Aabb::EMPTY, |all, &corner| all.union(Aabb::of_sphere(corner.into(), 0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instances_have_the_sizes_that_the_device_reads() {
        assert_eq!([size_of::<ConeInstance>(), size_of::<TorusInstance>()], [48, 48]);
        assert_eq!(size_of::<TriangleInstance>(), 96);
    }

    #[test]
    fn a_torus_is_as_wide_as_its_ring_and_tube_and_as_high_as_its_tube() {
        let torus = TorusInstance {
            center: [1.0, 2.0, 3.0],
            ring_radius: 2.0,
            axis: [0.0, 1.0, 0.0],
            tube_radius: 0.25,
            color: Srgb8::WHITE,
            id: 1,
            reserved: [0; 2],
        };
        let bounds = torus.bounds();
        assert!((bounds.size() - Vec3::new(4.5, 0.5, 4.5)).length() < 1e-6, "{bounds:?}");
    }
}
