//! The primitives of a scene in one space (world or view), all placements applied.

use crate::color::Srgb8;
use crate::math::{Aabb, rotation_to_y};
use crate::scene::{CylinderInstance, Scene, SphereInstance};
use glam::{Affine3A, Mat3, Vec3};
use rayon::prelude::*;

/// A ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius in ångström.
    pub radius: f32,
}

/// A stick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Middle of the axis.
    pub center: Vec3,
    /// Turns the axis (from end a to end b) onto +Y.
    pub cylinder_from_space: Mat3,
    /// Half the length of the axis, > 0.
    pub half_length: f32,
    /// Radius in ångström.
    pub radius: f32,
    /// Cap of end a (y = −half_length), and of end b times 4, as [`crate::scene::Cap`].
    pub caps: u32,
}

impl Sphere {
    /// An instance moved to the space of `space_from_block` (rigid).
    #[must_use]
    pub fn new(instance: &SphereInstance, space_from_block: &Affine3A) -> Sphere {
        Sphere { center: space_from_block.transform_point3(instance.center.into()), radius: instance.radius }
    }

    /// The box around it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb::of_sphere(self.center, self.radius)
    }
}

impl Cylinder {
    /// An instance moved to the space of `space_from_block` (rigid); `None` if it has no length or no radius.
    #[must_use]
    pub fn new(instance: &CylinderInstance, space_from_block: &Affine3A) -> Option<Cylinder> {
        let (a, b) = (Vec3::from(instance.a), Vec3::from(instance.b));
        // The axis before the translation: a difference of large numbers would lose its digits.
        let axis = space_from_block.transform_vector3(b - a);
        let length = axis.length();
        if !(length > 1e-12 && instance.radius > 0.0) {
            return None;
        }
        Some(Cylinder {
            center: space_from_block.transform_point3((a + b) * 0.5),
            cylinder_from_space: rotation_to_y(axis / length),
            half_length: length * 0.5,
            radius: instance.radius,
            caps: instance.caps,
        })
    }

    /// Unit axis, from end a to end b.
    #[must_use]
    pub fn axis(&self) -> Vec3 {
        self.cylinder_from_space.row(1)
    }

    /// The ends of the axis.
    #[must_use]
    pub fn ends(&self) -> [Vec3; 2] {
        let half = self.axis() * self.half_length;
        [self.center - half, self.center + half]
    }

    /// Which ends are round.
    #[must_use]
    pub fn round(&self) -> [bool; 2] {
        [self.caps & 3 == 2, (self.caps >> 2) & 3 == 2]
    }

    /// The box around it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let [a, b] = self.ends();
        Aabb::of_sphere(a, self.radius).union(Aabb::of_sphere(b, self.radius))
    }
}

/// All primitives: spheres, then cylinders; "primitive `i`" counts through both.
#[derive(Debug, Clone, Default)]
pub struct Solids {
    /// All spheres.
    pub spheres: Vec<Sphere>,
    /// Colour and id of each sphere.
    pub sphere_looks: Vec<(Srgb8, u32)>,
    /// All cylinders that have a length.
    pub cylinders: Vec<Cylinder>,
    /// Colours of the halves a and b, and id, of each cylinder.
    pub cylinder_looks: Vec<(Srgb8, Srgb8, u32)>,
}

impl Solids {
    /// All primitives of a scene in the space of `space_from_world`.
    #[must_use]
    pub fn new(scene: &Scene, space_from_world: Affine3A) -> Solids {
        let mut solids = Solids::default();
        for placement in &scene.placements {
            let block = &scene.blocks[placement.block];
            let space_from_block = space_from_world * placement.world_from_block;
            let id = |local: u32| placement.first_id.saturating_add(local);
            solids
                .spheres
                .par_extend(block.spheres.par_iter().with_min_len(4096).map(|s| Sphere::new(s, &space_from_block)));
            solids.sphere_looks.extend(block.spheres.iter().map(|s| (s.color, id(s.id))));
            let sticks = block.cylinders.par_iter().with_min_len(4096);
            let sticks: Vec<_> = sticks
                .filter_map(|c| Some((Cylinder::new(c, &space_from_block)?, (c.color_a, c.color_b, id(c.id)))))
                .collect();
            solids.cylinders.extend(sticks.iter().map(|(stick, _)| *stick));
            solids.cylinder_looks.extend(sticks.iter().map(|(_, looks)| *looks));
        }
        solids
    }

    /// Number of primitives.
    #[must_use]
    pub fn len(&self) -> usize {
        self.spheres.len() + self.cylinders.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Boxes of all primitives.
    #[must_use]
    pub fn bounds(&self) -> Vec<Aabb> {
        let spheres = self.spheres.iter().map(Sphere::bounds);
        spheres.chain(self.cylinders.iter().map(Cylinder::bounds)).collect()
    }

    /// The id of primitive `index`.
    #[must_use]
    pub fn id(&self, index: usize) -> u32 {
        match index.checked_sub(self.spheres.len()) {
            None => self.sphere_looks[index].1,
            Some(cylinder) => self.cylinder_looks[cylinder].2,
        }
    }
}
