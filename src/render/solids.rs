//! The primitives of a scene in one space (world or view), all placements applied.
//!
//! What has no extent (no length, no radius, no area, or numbers that are none) is left out here, so that nobody who draws has to
//! ask.

use super::opacity::{hides_in_sample, is_drawn_in_sample};
use crate::color::Srgb8;
use crate::math::{Aabb, rotation_to_y};
use crate::scene::{ConeInstance, CylinderInstance, Placement, Scene, SphereInstance, TorusInstance, TriangleInstance};
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
    /// Which caps lie inside of balls, as [`CylinderInstance::hidden`].
    pub hidden: u32,
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
        let axis = Cylinder::extent(instance, space_from_block)?;
        Some(Cylinder::along(axis, instance, space_from_block))
    }

    /// From one end of an instance to the other in that space, and how far that is; `None` if it has no length or no radius.
    fn extent(instance: &CylinderInstance, space_from_block: &Affine3A) -> Option<(Vec3, f32)> {
        // The axis before the translation: a difference of large numbers would lose its digits.
        let axis = space_from_block.transform_vector3(Vec3::from(instance.b) - Vec3::from(instance.a));
        let length = axis.length();
        (length > 1e-12 && instance.radius > 0.0).then_some((axis, length))
    }

    fn along((axis, length): (Vec3, f32), instance: &CylinderInstance, space_from_block: &Affine3A) -> Cylinder {
        let (a, b) = (Vec3::from(instance.a), Vec3::from(instance.b));
        Cylinder {
            center: space_from_block.transform_point3((a + b) * 0.5),
            cylinder_from_space: rotation_to_y(axis / length),
            half_length: length * 0.5,
            radius: instance.radius,
            caps: instance.caps,
            hidden: instance.hidden,
        }
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

    /// Whether one sees into it at an end.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.caps & 3 == 0 || (self.caps >> 2) & 3 == 0
    }

    /// The box around it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let [a, b] = self.ends();
        Aabb::of_sphere(a, self.radius).union(Aabb::of_sphere(b, self.radius))
    }
}

/// A cone, truncated or pointed, with flat caps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Middle of the axis.
    pub center: Vec3,
    /// Turns the axis (from end a to end b) onto +Y.
    pub cone_from_space: Mat3,
    /// Half the length of the axis, > 0.
    pub half_length: f32,
    /// Radius in the middle, ångström.
    pub middle_radius: f32,
    /// What the radius gains per ångström towards end b.
    pub slope: f32,
    /// Radii of the ends a and b.
    pub radii: [f32; 2],
}

/// A ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Torus {
    /// Centre.
    pub center: Vec3,
    /// Turns the ring's axis onto +Y.
    pub torus_from_space: Mat3,
    /// Radius of the circle that the tube follows.
    pub ring_radius: f32,
    /// Radius of the tube.
    pub tube_radius: f32,
}

/// A triangle of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// Middle of the corners.
    pub center: Vec3,
    /// The corners from there.
    pub corners: [Vec3; 3],
    /// Unit normals at the corners.
    pub normals: [Vec3; 3],
    /// The plane's normal, as long as twice the area.
    pub face: Vec3,
    /// By how much a weight may be below 0: what the rounding of coordinates of this size moves the edge opposite the corner, so that
    /// triangles that share an edge leave no gap.
    pub slack: Vec3,
}

impl Cone {
    /// An instance moved to the space of `space_from_block` (rigid); `None` if it has no length or no radius.
    #[must_use]
    pub fn new(instance: &ConeInstance, space_from_block: &Affine3A) -> Option<Cone> {
        let (a, b) = (Vec3::from(instance.a), Vec3::from(instance.b));
        let axis = space_from_block.transform_vector3(b - a);
        let length = axis.length();
        let radii = [instance.radius_a, instance.radius_b];
        if !(length > 1e-12 && radii[0] >= 0.0 && radii[1] >= 0.0 && radii[0] + radii[1] > 0.0) {
            return None;
        }
        Some(Cone {
            center: space_from_block.transform_point3((a + b) * 0.5),
            cone_from_space: rotation_to_y(axis / length),
            half_length: length * 0.5,
            middle_radius: (radii[0] + radii[1]) * 0.5,
            slope: (radii[1] - radii[0]) / length,
            radii,
        })
    }

    /// Unit axis, from end a to end b.
    #[must_use]
    pub fn axis(&self) -> Vec3 {
        self.cone_from_space.row(1)
    }

    /// The ends of the axis.
    #[must_use]
    pub fn ends(&self) -> [Vec3; 2] {
        let half = self.axis() * self.half_length;
        [self.center - half, self.center + half]
    }

    /// The box around it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let [a, b] = self.ends();
        Aabb::of_sphere(a, self.radii[0]).union(Aabb::of_sphere(b, self.radii[1]))
    }
}

impl Torus {
    /// An instance moved to the space of `space_from_block` (rigid); `None` if it has no axis or no tube.
    #[must_use]
    pub fn new(instance: &TorusInstance, space_from_block: &Affine3A) -> Option<Torus> {
        let axis = space_from_block.transform_vector3(instance.axis.into());
        let length = axis.length();
        if !(length > 1e-12 && instance.ring_radius >= 0.0 && instance.tube_radius > 0.0) {
            return None;
        }
        Some(Torus {
            center: space_from_block.transform_point3(instance.center.into()),
            torus_from_space: rotation_to_y(axis / length),
            ring_radius: instance.ring_radius,
            tube_radius: instance.tube_radius,
        })
    }

    /// Unit axis of the ring.
    #[must_use]
    pub fn axis(&self) -> Vec3 {
        self.torus_from_space.row(1)
    }

    /// The box around it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let axis = self.axis();
        // A circle reaches its radius times the sine of the angle between its axis and the direction.
        let reach = (Vec3::ONE - axis * axis).max(Vec3::ZERO).map(f32::sqrt) * self.ring_radius + self.tube_radius;
        Aabb { min: self.center - reach, max: self.center + reach }
    }
}

impl Triangle {
    /// An instance moved to the space of `space_from_block` (rigid); `None` if it has no area.
    #[must_use]
    pub fn new(instance: &TriangleInstance, space_from_block: &Affine3A) -> Option<Triangle> {
        let [a, b, c] = instance.corners.map(Vec3::from);
        let middle = (a + b + c) * (1.0 / 3.0);
        let center = space_from_block.transform_point3(middle);
        // The corners before the translation: differences of large numbers would lose their digits.
        let corners = [a, b, c].map(|corner| space_from_block.transform_vector3(corner - middle));
        let edges = [corners[2] - corners[1], corners[0] - corners[2], corners[1] - corners[0]];
        let face = edges[2].cross(-edges[1]);
        let double_area = face.length();
        if !(double_area > 0.0 && double_area.is_finite() && center.is_finite()) {
            return None;
        }
        let extent = edges.iter().fold(0.0, |most, edge| edge.length().max(most));
        // A corner of two triangles is rounded four times on each way to the ray.
        let rounding = 4.0 * f32::EPSILON * (center.abs().max_element() + extent);
        let slack = Vec3::from(edges.map(|edge| (rounding * edge.length() / double_area).min(0.01)));
        let normals = instance.normals.map(|normal| space_from_block.transform_vector3(normal.into()));
        Some(Triangle { center, corners, normals, face, slack })
    }

    /// The corners in the triangle's space.
    #[must_use]
    pub fn points(&self) -> [Vec3; 3] {
        self.corners.map(|corner| self.center + corner)
    }

    /// The box around it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.points().into_iter().fold(Aabb::EMPTY, |all, point| all.union(Aabb::of_sphere(point, 0.0)))
    }
}

/// What primitive `i` of [`Solids`] is: index into the list of its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Primitive {
    /// Of [`Solids::spheres`].
    Sphere(usize),
    /// Of [`Solids::cylinders`].
    Cylinder(usize),
    /// Of [`Solids::cones`].
    Cone(usize),
    /// Of [`Solids::tori`].
    Torus(usize),
    /// Of [`Solids::triangles`].
    Triangle(usize),
}

/// All primitives: spheres, cylinders, cones, tori, triangles; "primitive `i`" counts through all of them, in this order.
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
    /// All cones.
    pub cones: Vec<Cone>,
    /// Colour and id of each cone.
    pub cone_looks: Vec<(Srgb8, u32)>,
    /// All tori.
    pub tori: Vec<Torus>,
    /// Colour and id of each torus.
    pub torus_looks: Vec<(Srgb8, u32)>,
    /// All triangles.
    pub triangles: Vec<Triangle>,
    /// Colours of the corners, and id, of each triangle.
    pub triangle_looks: Vec<([Srgb8; 3], u32)>,
    /// Whether any primitive is see-through.
    pub see_through: bool,
}

/// Whether any primitive of a scene is see-through.
#[must_use]
pub fn is_see_through(scene: &Scene) -> bool {
    let is_placed = |block: usize| scene.placements.iter().any(|placement| placement.block == block);
    scene.blocks.iter().enumerate().filter(|(number, _)| is_placed(*number)).any(|(_, block)| {
        let opacities = (block.spheres.iter().map(|s| s.color.a))
            .chain(block.cylinders.iter().map(|c| c.color_a.a))
            .chain(block.cones.iter().map(|c| c.color.a))
            .chain(block.tori.iter().map(|t| t.color.a))
            .chain(block.triangles.iter().map(|t| t.colors[0].a));
        // All of them, without a way out: a loop over a million that becomes vector code.
        opacities.fold(u8::MAX, u8::min) < u8::MAX
    })
}

impl Solids {
    /// All primitives of a scene in the space of `space_from_world`.
    #[must_use]
    pub fn new(scene: &Scene, space_from_world: Affine3A) -> Solids {
        let mut solids = Solids { see_through: is_see_through(scene), ..Solids::default() };
        for placement in &scene.placements {
            let space_from_block = space_from_world * placement.world_from_block;
            solids.add_simple(scene, placement, space_from_block);
            solids.add_cones(scene, placement, space_from_block);
            solids.add_tori(scene, placement, space_from_block);
            solids.add_triangles(scene, placement, space_from_block);
        }
        solids
    }

    /// All primitives of a block, in its own space; ids are those of its first copy if that began with 0.
    #[must_use]
    pub fn of_block(scene: &Scene, block: usize) -> Solids {
        let mut alone = scene.clone();
        alone.placements = vec![Placement { block, world_from_block: Affine3A::IDENTITY, first_id: 0 }];
        Solids::new(&alone, Affine3A::IDENTITY)
    }

    /// All cones and triangles of a scene of which some may be `see_through`.
    #[must_use]
    pub fn others(scene: &Scene, space_from_world: Affine3A, see_through: bool) -> Solids {
        let mut solids = Solids { see_through, ..Solids::default() };
        for placement in &scene.placements {
            let space_from_block = space_from_world * placement.world_from_block;
            solids.add_cones(scene, placement, space_from_block);
            solids.add_triangles(scene, placement, space_from_block);
        }
        solids
    }

    fn add_simple(&mut self, scene: &Scene, placement: &Placement, space_from_block: Affine3A) {
        let block = &scene.blocks[placement.block];
        let id = |local: u32| placement.first_id.saturating_add(local);
        let spheres = block.spheres.par_iter().with_min_len(4096);
        self.spheres.par_extend(spheres.map(|s| Sphere::new(s, &space_from_block)));
        let spheres = block.spheres.par_iter().with_min_len(4096);
        self.sphere_looks.par_extend(spheres.map(|s| (s.color, id(s.id))));
        // Nearly always all sticks have an extent: then each has its place, and nothing is copied together afterwards.
        let extent = |c: &CylinderInstance| Cylinder::extent(c, &space_from_block);
        let sticks = block.cylinders.par_iter().with_min_len(4096);
        if !sticks.clone().all(|c| extent(c).is_some()) {
            block.cylinders.iter().for_each(|c| {
                self.push_cylinder(c, &space_from_block, placement.first_id);
            });
            return;
        }
        let stick = |c| Cylinder::along(extent(c).unwrap_or((Vec3::Y, 1.0)), c, &space_from_block);
        self.cylinders.par_extend(sticks.clone().map(stick));
        self.cylinder_looks.par_extend(sticks.map(|c| (c.color_a, c.color_b, id(c.id))));
    }

    /// Adds a ball of a placement with this first id.
    pub fn push_sphere(&mut self, instance: &SphereInstance, space_from_block: &Affine3A, first_id: u32) {
        self.spheres.push(Sphere::new(instance, space_from_block));
        self.sphere_looks.push((instance.color, first_id.saturating_add(instance.id)));
    }

    /// Adds a stick, if it has an extent; whether it has.
    pub fn push_cylinder(&mut self, instance: &CylinderInstance, space_from_block: &Affine3A, first_id: u32) -> bool {
        let cylinder = Cylinder::new(instance, space_from_block);
        self.cylinders.extend(cylinder);
        let looks = (instance.color_a, instance.color_b, first_id.saturating_add(instance.id));
        self.cylinder_looks.extend(cylinder.map(|_| looks));
        cylinder.is_some()
    }

    /// Adds a ring, if it has an extent; whether it has.
    pub fn push_torus(&mut self, instance: &TorusInstance, space_from_block: &Affine3A, first_id: u32) -> bool {
        let torus = Torus::new(instance, space_from_block);
        self.tori.extend(torus);
        self.torus_looks.extend(torus.map(|_| (instance.color, first_id.saturating_add(instance.id))));
        torus.is_some()
    }

    /// Adds a primitive of other solids.
    pub fn push(&mut self, of: &Solids, index: usize) {
        match of.primitive(index) {
            Primitive::Sphere(i) => {
                self.spheres.push(of.spheres[i]);
                self.sphere_looks.push(of.sphere_looks[i]);
            }
            Primitive::Cylinder(i) => {
                self.cylinders.push(of.cylinders[i]);
                self.cylinder_looks.push(of.cylinder_looks[i]);
            }
            Primitive::Cone(i) => {
                self.cones.push(of.cones[i]);
                self.cone_looks.push(of.cone_looks[i]);
            }
            Primitive::Torus(i) => {
                self.tori.push(of.tori[i]);
                self.torus_looks.push(of.torus_looks[i]);
            }
            Primitive::Triangle(i) => {
                self.triangles.push(of.triangles[i]);
                self.triangle_looks.push(of.triangle_looks[i]);
            }
        }
    }

    /// Takes all balls, sticks and rings away.
    pub fn clear_simple(&mut self) {
        self.spheres.clear();
        self.sphere_looks.clear();
        self.cylinders.clear();
        self.cylinder_looks.clear();
        self.tori.clear();
        self.torus_looks.clear();
    }

    fn add_cones(&mut self, scene: &Scene, placement: &Placement, space_from_block: Affine3A) {
        let id = |local: u32| placement.first_id.saturating_add(local);
        for instance in &scene.blocks[placement.block].cones {
            if let Some(cone) = Cone::new(instance, &space_from_block) {
                self.cones.push(cone);
                self.cone_looks.push((instance.color, id(instance.id)));
            }
        }
    }

    fn add_tori(&mut self, scene: &Scene, placement: &Placement, space_from_block: Affine3A) {
        for instance in &scene.blocks[placement.block].tori {
            self.push_torus(instance, &space_from_block, placement.first_id);
        }
    }

    fn add_triangles(&mut self, scene: &Scene, placement: &Placement, space_from_block: Affine3A) {
        let block = &scene.blocks[placement.block];
        let id = |local: u32| placement.first_id.saturating_add(local);
        let triangles = block.triangles.par_iter().with_min_len(4096);
        let triangles: Vec<_> =
            triangles.filter_map(|t| Some((Triangle::new(t, &space_from_block)?, (t.colors, id(t.id))))).collect();
        self.triangles.extend(triangles.iter().map(|(triangle, _)| *triangle));
        self.triangle_looks.extend(triangles.iter().map(|(_, looks)| *looks));
    }

    /// Number of primitives.
    #[must_use]
    pub fn len(&self) -> usize {
        self.spheres.len() + self.cylinders.len() + self.cones.len() + self.tori.len() + self.triangles.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Boxes of all primitives.
    #[must_use]
    pub fn bounds(&self) -> Vec<Aabb> {
        (0..self.len()).into_par_iter().with_min_len(4096).map(|index| self.box_of(index)).collect()
    }

    /// The box of primitive `index`.
    #[must_use]
    pub fn box_of(&self, index: usize) -> Aabb {
        match self.primitive(index) {
            Primitive::Sphere(i) => self.spheres[i].bounds(),
            Primitive::Cylinder(i) => self.cylinders[i].bounds(),
            Primitive::Cone(i) => self.cones[i].bounds(),
            Primitive::Torus(i) => self.tori[i].bounds(),
            Primitive::Triangle(i) => self.triangles[i].bounds(),
        }
    }

    /// What primitive `index` is.
    #[inline]
    #[must_use]
    pub fn primitive(&self, index: usize) -> Primitive {
        let Some(index) = index.checked_sub(self.spheres.len()) else { return Primitive::Sphere(index) };
        let Some(index) = index.checked_sub(self.cylinders.len()) else { return Primitive::Cylinder(index) };
        let Some(index) = index.checked_sub(self.cones.len()) else { return Primitive::Cone(index) };
        let Some(index) = index.checked_sub(self.tori.len()) else { return Primitive::Torus(index) };
        Primitive::Triangle(index)
    }

    /// The id of primitive `index`.
    #[must_use]
    pub fn id(&self, index: usize) -> u32 {
        match self.primitive(index) {
            Primitive::Sphere(i) => self.sphere_looks[i].1,
            Primitive::Cylinder(i) => self.cylinder_looks[i].2,
            Primitive::Cone(i) => self.cone_looks[i].1,
            Primitive::Torus(i) => self.torus_looks[i].1,
            Primitive::Triangle(i) => self.triangle_looks[i].1,
        }
    }

    /// The opacity of primitive `index`, 0–255.
    #[must_use]
    pub fn opacity(&self, index: usize) -> u8 {
        match self.primitive(index) {
            Primitive::Sphere(i) => self.sphere_looks[i].0.a,
            Primitive::Cylinder(i) => self.cylinder_looks[i].0.a,
            Primitive::Cone(i) => self.cone_looks[i].0.a,
            Primitive::Torus(i) => self.torus_looks[i].0.a,
            Primitive::Triangle(i) => self.triangle_looks[i].0[0].a,
        }
    }

    /// Whether primitive `index` is there in a sample; costs nothing where all are opaque.
    #[inline]
    #[must_use]
    pub fn is_drawn(&self, index: usize, sample: u32, samples: u32) -> bool {
        !self.see_through || is_drawn_in_sample(sample, samples, self.id(index), self.opacity(index))
    }

    /// Whether primitive `index` hides light in a sample; costs nothing where all are opaque.
    #[inline]
    #[must_use]
    pub fn hides(&self, index: usize, sample: u32, samples: u32) -> bool {
        !self.see_through || hides_in_sample(sample, samples, self.id(index), self.opacity(index))
    }
}
