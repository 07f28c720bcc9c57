//! From structures to something to draw: primitives, placements, camera, light, ground.
//!
//! A [`Scene`] is blocks of primitives × placements (rigid transforms), so that assemblies, symmetry mates and
//! supercells draw one copy many times; a plain molecule is one block placed once. Nothing here knows how it is drawn.
//!
//! Scenes of many frames of one molecule share a [`Rig`]: what positions do not decide is found once.

mod aromatic;
mod arrows;
mod axes;
mod block;
mod build;
mod camera;
mod cell_box;
mod chosen;
mod coloring;
mod copies;
mod dashes;
pub mod fit;
mod halo;
mod haptic;
mod instances;
mod light;
mod look;
mod measure;
mod meshes;
mod overlay;
mod shapes;
mod sticks;
mod style;
mod vectors;
mod viewpoint;
mod wedges;

pub use aromatic::Aromatic;
pub use axes::Axes;
pub use build::{AltlocChoice, Item, Orientation, Pose, Rig, SceneOptions};
pub use camera::{Camera, PixelGrid, Projection, Ray, Region};
pub use chosen::BySelection;
pub use coloring::ColorBy;
pub use copies::ItemIds;
pub use instances::{Cap, CylinderInstance, SphereInstance};
pub use light::{Background, DepthOfField, Ground, LightFrame, Lighting, Outline};
pub use look::Look;
pub use measure::{AtomPlace, Measurement, measured};
pub use overlay::{Label, LabelContent, LegendRow, Overlay, OverlayOptions};
pub use shapes::{ConeInstance, TorusInstance, TriangleInstance};
pub use style::Style;
pub use vectors::{VectorChoice, VectorScale, vector_scales};
pub use viewpoint::Viewpoint;

use crate::math::Aabb;
use glam::{Affine3A, DVec3, Quat, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Primitives in a space of their own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Block {
    /// Balls.
    pub spheres: Vec<SphereInstance>,
    /// Sticks.
    pub cylinders: Vec<CylinderInstance>,
    /// Arrowheads and wedges.
    pub cones: Vec<ConeInstance>,
    /// Rings.
    pub tori: Vec<TorusInstance>,
    /// Meshes.
    pub triangles: Vec<TriangleInstance>,
    /// Ids in this block are 1 ..= `id_count`; a placement shifts them.
    pub id_count: u32,
}

/// One copy of a block in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Index into [`Scene::blocks`].
    pub block: usize,
    /// Rigid transform (a rotation or reflection and a translation; no scaling).
    pub world_from_block: Affine3A,
    /// Added to the ids of the block.
    pub first_id: u32,
}

/// All there is to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Primitives, each once; shared, so that a scene with another light or ground costs nothing.
    pub blocks: Arc<Vec<Block>>,
    /// Where they stand.
    pub placements: Vec<Placement>,
    /// The lights.
    pub lighting: Lighting,
    /// What is behind.
    pub background: Background,
    /// The ground, if there is one.
    pub ground: Option<Ground>,
    /// Depth of field, if there is any.
    pub depth_of_field: Option<DepthOfField>,
    /// What is written over the picture.
    pub overlay: Arc<Overlay>,
    /// How the default camera is turned.
    pub world_from_view: Quat,
    /// Whether the default camera is a perspective one.
    pub perspective: bool,
    /// The arrows along the axes, if there are any.
    pub axes: Option<Axes>,
    /// How coordinates of the files became those of the world.
    pub pose: Pose,
    /// What is what of every structure that the scene was built from.
    pub items: Vec<ItemIds>,
    /// The flags whose selections find no atom, such as `--hide chain Q`.
    pub unmatched: Vec<String>,
    bounds: Aabb,
}

impl Scene {
    /// From structures (their first frames) and options.
    ///
    /// ```
    /// use ballstick::scene::{Item, Scene, SceneOptions};
    /// let file = b"2\nhydrogen\nH 0 0 0\nH 0 0 0.74\n";
    /// let document = ballstick::import::read_bytes(file, "h2.xyz", &Default::default())?;
    /// let molecule = ballstick::bonds::assign(document.records[0].clone(), &Default::default());
    /// let scene = Scene::new(&[Item::of(&molecule)], &SceneOptions::default());
    /// assert_eq!((scene.sphere_count(), scene.cylinder_count()), (2, 1));
    /// # Ok::<(), ballstick::Error>(())
    /// ```
    #[must_use]
    pub fn new(items: &[Item<'_>], options: &SceneOptions) -> Scene {
        Rig::new(items, options).scene(items, options)
    }

    /// From parts: placements of blocks that do not exist are left out; bounds are found.
    #[must_use]
    pub fn from_blocks(blocks: Vec<Block>, mut placements: Vec<Placement>) -> Scene {
        placements.retain(|placement| placement.block < blocks.len());
        let mut scene = Scene {
            blocks: Arc::new(blocks),
            placements,
            lighting: Lighting::default(),
            background: Background::default(),
            ground: None,
            depth_of_field: None,
            overlay: Arc::default(),
            world_from_view: Quat::IDENTITY,
            perspective: true,
            axes: None,
            pose: Pose { center: DVec3::ZERO, turn: Quat::IDENTITY, pitch_rad: 0.0 },
            items: Vec::new(),
            unmatched: Vec::new(),
            bounds: Aabb::EMPTY,
        };
        scene.bounds = scene.find_bounds();
        scene
    }

    /// The box around everything but the ground, world space.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Bytes that its primitives and placements have set aside: 24 a ball, 48 a stick, each once however often it is placed.
    #[must_use]
    pub fn memory(&self) -> usize {
        let block = |block: &Block| {
            block.spheres.capacity() * size_of::<SphereInstance>()
                + block.cylinders.capacity() * size_of::<CylinderInstance>()
                + block.cones.capacity() * size_of::<ConeInstance>()
                + block.tori.capacity() * size_of::<TorusInstance>()
                + block.triangles.capacity() * size_of::<TriangleInstance>()
        };
        self.blocks.iter().map(block).sum::<usize>() + self.placements.capacity() * size_of::<Placement>()
    }

    /// Number of spheres drawn, over all placements.
    #[must_use]
    pub fn sphere_count(&self) -> usize {
        self.placements.iter().map(|placement| self.blocks[placement.block].spheres.len()).sum()
    }

    /// Number of cylinders drawn, over all placements.
    #[must_use]
    pub fn cylinder_count(&self) -> usize {
        self.placements.iter().map(|placement| self.blocks[placement.block].cylinders.len()).sum()
    }

    /// Centres and radii of all spheres in world space.
    pub fn world_spheres(&self) -> impl Iterator<Item = (Vec3, f32)> + Clone {
        self.placements.iter().flat_map(|placement| {
            self.blocks[placement.block]
                .spheres
                .iter()
                .map(|sphere| (placement.world_from_block.transform_point3(sphere.center.into()), sphere.radius))
        })
    }

    /// What has to be in the picture: all spheres, cones and triangles, and sticks and tori in blocks without spheres (else they
    /// are between the balls).
    fn world_extent(&self) -> impl Iterator<Item = (Vec3, f32)> + Clone {
        let bare = |placement: &&Placement| self.blocks[placement.block].spheres.is_empty();
        let ends = self.placements.iter().filter(bare).flat_map(|placement| {
            self.blocks[placement.block].cylinders.iter().flat_map(|stick| {
                [stick.a, stick.b].map(|end| (placement.world_from_block.transform_point3(end.into()), stick.radius))
            })
        });
        let rings = self.placements.iter().filter(bare).flat_map(|placement| {
            self.blocks[placement.block].tori.iter().map(|torus| {
                let center = placement.world_from_block.transform_point3(torus.center.into());
                (center, torus.ring_radius + torus.tube_radius)
            })
        });
        let shapes = self.placements.iter().flat_map(|placement| {
            let block = &self.blocks[placement.block];
            let cones = block.cones.iter().flat_map(|cone| [(cone.a, cone.radius_a), (cone.b, cone.radius_b)]);
            let corners = block.triangles.iter().flat_map(|triangle| triangle.corners.map(|corner| (corner, 0.0)));
            cones
                .chain(corners)
                .map(|(point, radius)| (placement.world_from_block.transform_point3(point.into()), radius))
        });
        self.world_spheres().chain(ends).chain(rings).chain(shapes)
    }

    /// The default camera for a picture of this shape (width / height): everything in it, the broadest side to the viewer.
    #[must_use]
    pub fn fitted_camera(&self, aspect: f32) -> Camera {
        fit::frame(self.world_extent(), self.world_from_view, self.perspective, aspect)
    }

    /// The default camera for a film of this shape in which the scene turns about the upright axis through its middle: everything in the
    /// picture all the time. Its target is on that axis.
    #[must_use]
    pub fn turntable_camera(&self, aspect: f32) -> Camera {
        let middle = self.bounds.center();
        let turns =
            (0..fit::TURNS).map(|turn| Quat::from_rotation_y(std::f32::consts::TAU * turn as f32 / fit::TURNS as f32));
        let turned = turns.flat_map(move |turn| {
            self.world_extent().map(move |(center, radius)| (middle + turn * (center - middle), radius))
        });
        let camera = fit::frame(turned, self.world_from_view, self.perspective, aspect);
        Camera { target: middle, ..camera }
    }

    /// The structure, its copy and the number in it, all from 0, of the atom or bond of an id: first all atoms, then the bonds. `None` for
    /// what is no structure's.
    #[must_use]
    pub fn item_of(&self, id: u32) -> Option<(usize, u32, u32)> {
        self.items.iter().enumerate().find_map(|(item, ids)| ids.own(id).map(|(copy, own)| (item, copy, own)))
    }

    /// The id of an atom of a structure.
    #[must_use]
    pub fn id_of(&self, AtomPlace { item, atom }: AtomPlace) -> Option<u32> {
        self.items.get(item as usize)?.id_of(atom)
    }

    /// Centre and radius of the ball of an id, world space; `None` if there is none.
    #[must_use]
    pub fn ball(&self, id: u32) -> Option<(Vec3, f32)> {
        self.placements.iter().find_map(|placement| {
            let block = &self.blocks[placement.block];
            let own = id.checked_sub(placement.first_id).filter(|own| (1..=block.id_count).contains(own))?;
            // Balls stand in the order of their ids wherever structures were drawn.
            let found = block.spheres.binary_search_by_key(&own, |sphere| sphere.id).ok();
            let found = found.or_else(|| block.spheres.iter().position(|sphere| sphere.id == own))?;
            let sphere = &block.spheres[found];
            Some((placement.world_from_block.transform_point3(sphere.center.into()), sphere.radius))
        })
    }

    /// Takes light, background, projection and whether there is a ground from options that ask for the same primitives.
    pub fn relight(&mut self, options: &SceneOptions) {
        self.perspective = options.perspective;
        self.lighting = build::lighting(options);
        self.depth_of_field = options.depth_of_field;
        self.background = options.background;
        self.set_ground(options.ground);
    }

    /// Puts a ground under the scene, or takes it away.
    pub fn set_ground(&mut self, on: bool) {
        self.ground = (on && !self.bounds.is_empty()).then(|| build::ground_under(self.bounds));
    }

    fn find_bounds(&self) -> Aabb {
        self.placements.par_iter().map(|placement| self.bounds_of(placement)).reduce(|| Aabb::EMPTY, Aabb::union)
    }

    fn bounds_of(&self, placement: &Placement) -> Aabb {
        let block = &self.blocks[placement.block];
        let to_world = |p: [f32; 3]| placement.world_from_block.transform_point3(p.into());
        let ball = |center: [f32; 3], radius: f32| Aabb::of_sphere(to_world(center), radius);
        let spheres = block.spheres.par_iter().with_min_len(4096).map(|sphere| ball(sphere.center, sphere.radius));
        let sticks = block.cylinders.par_iter().with_min_len(4096);
        let sticks = sticks.map(|stick| ball(stick.a, stick.radius).union(ball(stick.b, stick.radius)));
        let mut bounds = spheres.chain(sticks).reduce(|| Aabb::EMPTY, Aabb::union);
        for cone in &block.cones {
            bounds = bounds.union(ball(cone.a, cone.radius_a)).union(ball(cone.b, cone.radius_b));
        }
        for torus in &block.tori {
            let axis = placement.world_from_block.transform_vector3(torus.axis.into()).to_array();
            let torus = TorusInstance { center: to_world(torus.center).to_array(), axis, ..*torus };
            bounds = bounds.union(torus.bounds());
        }
        let corners = block.triangles.par_iter().with_min_len(4096).flat_map_iter(|triangle| triangle.corners);
        let corners = corners.map(|corner| ball(corner, 0.0)).reduce(|| Aabb::EMPTY, Aabb::union);
        bounds.union(corners)
    }
}
