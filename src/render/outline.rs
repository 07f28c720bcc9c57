//! Outlines: what widens a primitive by a line, and where the line lies.
//!
//! Every primitive wears a rim: a ray that misses it but meets the primitive grown by the line's width meets the line, a
//! flat thing of one colour at the depth of the silhouette: midway between where the ray enters and leaves the grown
//! primitive, moved back by a part of the primitive's radius ([`crate::scene::Outline::behind`]). From there on it is hidden and hides as anything
//! else, at every sample. So a line needs no neighbouring pixels: it is as smooth as the picture, the same in
//! tiles and regions, breaks nowhere, and where two sticks cross, the front one has its line over the back one. What a primitive
//! stands in or touches is nearer than the line, so that the ball and the sticks of an atom are drawn around as one.
//!
//! The width is that of the primitive's middle, and never more than [`MOST_WIDTH`] of the radius, so that thin sticks
//! keep their colour in pictures of large molecules.
//!
//! Limits: triangles have no outlines. Through the openings of a stick without caps one sees its line.  A stick that runs far into the depth has lines of one width, not narrower ones at its far end.
//!
//! `shaders/outline.wgsl` holds the twin.

use super::frame::FrameConstants;
use super::solids::{Cone, Cylinder, Primitive, Solids, Sphere, Torus};
use crate::math::{Aabb, max, min};
use glam::Vec3;

/// The most that a line is wide, in radii. Chosen: of a stick with its lines five ninths are its own colour.
pub const MOST_WIDTH: f32 = 0.4;

/// Marks an index of a primitive as that of its line. Of equal depths a line comes last.
pub const RIM: u32 = 1 << 31;

/// Width and place of the lines of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outline {
    per_depth: f32,
    fixed: f32,
    near: f32,
    behind: f32,
}

impl Outline {
    /// Those of a picture; `None` if it has none.
    #[must_use]
    pub fn of(frame: &FrameConstants) -> Option<Outline> {
        let [per_depth, fixed, behind, _] = frame.outline;
        (per_depth + fixed > 0.0).then_some(Outline { per_depth, fixed, near: frame.depth[2], behind })
    }

    /// Width of the line around a primitive with this middle in view space and this radius, ångström.
    #[inline(always)]
    #[must_use]
    pub fn width(&self, center: Vec3, radius: f32) -> f32 {
        min(self.per_depth * max(-center.z, self.near) + self.fixed, MOST_WIDTH * radius)
    }

    /// A ball with its line.
    #[inline(always)]
    #[must_use]
    pub fn sphere(&self, sphere: &Sphere) -> Sphere {
        Sphere { radius: sphere.radius + self.width(sphere.center, sphere.radius), ..*sphere }
    }

    /// A stick with its line; round ends grow as balls do, others get longer.
    #[inline(always)]
    #[must_use]
    pub fn cylinder(&self, cylinder: &Cylinder) -> Cylinder {
        let width = self.width(cylinder.center, cylinder.radius);
        let longer = if cylinder.round() == [false; 2] { width } else { 0.0 };
        Cylinder { radius: cylinder.radius + width, half_length: cylinder.half_length + longer, ..*cylinder }
    }

    /// A cone with its line.
    #[must_use]
    pub fn cone(&self, cone: &Cone) -> Cone {
        let width = self.width(cone.center, cone_radius(cone));
        // A slanted side moves out at right angles to itself.
        let out = width * (1.0 + cone.slope * cone.slope).sqrt();
        let half_length = cone.half_length + width;
        let middle_radius = cone.middle_radius + out;
        let change = cone.slope * half_length;
        // Never below 0: the side is moved by more than it falls over one width.
        let radii = [middle_radius - change, middle_radius + change].map(|radius| radius.max(0.0));
        Cone { half_length, middle_radius, radii, ..*cone }
    }

    /// A ring with its line.
    #[must_use]
    pub fn torus(&self, torus: &Torus) -> Torus {
        Torus { tube_radius: torus.tube_radius + self.width(torus.center, torus.tube_radius), ..*torus }
    }

    /// How far behind the silhouette the line around primitive `index` lies, ångström.
    #[inline]
    #[must_use]
    pub fn behind(&self, solids: &Solids, index: usize) -> f32 {
        self.behind_radius(radius_of(solids, index))
    }

    /// The same of a ball, stick or ring with this radius.
    #[inline]
    #[must_use]
    pub fn behind_radius(&self, radius: f32) -> f32 {
        self.behind * radius
    }

    /// The box of primitive `index` and its line.
    #[must_use]
    pub fn box_of(&self, solids: &Solids, index: usize) -> Aabb {
        match solids.primitive(index) {
            Primitive::Sphere(i) => self.sphere(&solids.spheres[i]).bounds(),
            Primitive::Cylinder(i) => self.cylinder(&solids.cylinders[i]).bounds(),
            Primitive::Cone(i) => self.cone(&solids.cones[i]).bounds(),
            Primitive::Torus(i) => self.torus(&solids.tori[i]).bounds(),
            Primitive::Triangle(i) => solids.triangles[i].bounds(),
        }
    }
}

/// The larger radius of a cone.
fn cone_radius(cone: &Cone) -> f32 {
    cone.middle_radius + cone.slope.abs() * cone.half_length
}

fn radius_of(solids: &Solids, index: usize) -> f32 {
    match solids.primitive(index) {
        Primitive::Sphere(i) => solids.spheres[i].radius,
        Primitive::Cylinder(i) => solids.cylinders[i].radius,
        Primitive::Cone(i) => cone_radius(&solids.cones[i]),
        Primitive::Torus(i) => solids.tori[i].tube_radius,
        Primitive::Triangle(_) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Srgb8;
    use crate::render::cpu::reference;
    use crate::render::{Image, Settings, View};
    use crate::scene::{Block, Camera, CylinderInstance, Placement, Projection, Scene, SphereInstance};
    use glam::{Affine3A, Quat};

    const SETTINGS: Settings = Settings { samples: 4, ground_texels: 16, ao: 0, shadow: false };
    const LINE: Srgb8 = Srgb8::rgb(0, 0, 255);

    fn stick(a: [f32; 3], b: [f32; 3], radius: f32) -> CylinderInstance {
        let (color_a, color_b) = (Srgb8::rgb(255, 0, 0), Srgb8::rgb(255, 0, 0));
        CylinderInstance { a, radius, b, id: 1, color_a, color_b, caps: 5, hidden: 0 }
    }

    /// Red sticks and green balls with blue lines, seen down z with parallel rays, 4 Å high.
    fn view_of(spheres: &[([f32; 3], f32)], cylinders: Vec<CylinderInstance>, width: f32) -> (Scene, Camera) {
        let ball = |&(center, radius)| SphereInstance { center, radius, color: Srgb8::rgb(0, 255, 0), id: 1 };
        let spheres = spheres.iter().map(ball).collect();
        let block = Block { spheres, cylinders, id_count: 9, ..Block::default() };
        let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
        let mut scene = Scene::from_blocks(vec![block], vec![placement]);
        scene.lighting.outline = crate::scene::Outline { width, color: LINE, ..Default::default() };
        scene.lighting.fog = 0.0;
        let camera = Camera {
            eye: Vec3::new(0.0, 0.0, 10.0),
            world_from_view: Quat::IDENTITY,
            projection: Projection::Orthographic { height: 4.0 },
            near: 0.1,
            far: 100.0,
            target: Vec3::ZERO,
            shift: [0.0; 2],
        };
        (scene, camera)
    }

    fn pixel(image: &Image, x: f32, y: f32) -> [u8; 4] {
        let scale = image.height as f32 / 4.0;
        let (px, py) = ((x * scale) as i32 + image.width as i32 / 2, image.height as i32 / 2 - (y * scale) as i32);
        let at = (py as usize * image.width as usize + px as usize) * 4;
        image.rgba[at..at + 4].try_into().unwrap()
    }

    fn is_line(rgba: [u8; 4]) -> bool {
        rgba == [LINE.r, LINE.g, LINE.b, 255]
    }

    #[test]
    fn of_two_sticks_the_front_one_has_its_lines_over_the_back_one() {
        let sticks = vec![stick([-1.5, 0.0, 0.0], [1.5, 0.0, 0.0], 0.3), stick([0.0, -1.5, 0.8], [0.0, 1.5, 0.8], 0.3)];
        let (scene, camera) = view_of(&[], sticks, 0.02);
        let image = reference::image(&scene, &View::new(camera, 200, 200), &SETTINGS);
        for y in [-1.0, -0.2, 0.0, 0.2, 1.0] {
            assert!(is_line(pixel(&image, 0.34, y)) && is_line(pixel(&image, -0.34, y)), "{y}");
            assert!(!is_line(pixel(&image, 0.0, y)));
        }
        assert!(is_line(pixel(&image, 1.0, 0.34)) && !is_line(pixel(&image, 0.2, 0.34)));
    }

    #[test]
    fn a_ball_and_its_sticks_have_one_line_around_them_all() {
        let sticks =
            vec![stick([0.0, 0.0, 0.0], [1.5, 0.0, 0.3], 0.15), stick([0.0, 0.0, 0.0], [-1.4, 0.0, -0.6], 0.15)];
        let (scene, camera) = view_of(&[([0.0, 0.0, 0.0], 0.5)], sticks, 0.015);
        let image = reference::image(&scene, &View::new(camera, 400, 400), &SETTINGS);
        // Round the ball, but not where the sticks leave it, neither towards the viewer nor away.
        for turn in 1..40 {
            let angle = std::f32::consts::TAU * turn as f32 / 40.0;
            let (x, y) = (0.53 * angle.cos(), 0.53 * angle.sin());
            let beside = y.abs() > 0.24;
            let on_stick = y.abs() < 0.12;
            assert!(is_line(pixel(&image, x, y)) == beside || !(beside || on_stick), "{x} {y}");
        }
        assert!(is_line(pixel(&image, 1.0, 0.18)) && is_line(pixel(&image, -1.0, -0.18)));
    }

    #[test]
    fn lines_are_as_wide_in_proportion_at_every_size_and_in_both_projections() {
        let share = |camera: Camera, side: u32| {
            let (scene, _) = view_of(&[([0.0; 3], 1.0)], vec![], 0.02);
            let image = reference::image(&scene, &View::new(camera, side, side), &SETTINGS);
            let linear = |byte: u8| f64::from(crate::color::linear_from_srgb(f32::from(byte) / 255.0));
            let blue = |p: &[u8]| (linear(p[2]) - linear(p[0].max(p[1]))).max(0.0);
            image.rgba.chunks_exact(4).map(blue).sum::<f64>() / f64::from(side * side)
        };
        let (_, camera) = view_of(&[], vec![], 0.02);
        // A ring of radius 1.04 and width 0.08 in a square of 4: π(1.08² − 1) / 16.
        let want = std::f64::consts::PI * (1.08f64.powi(2) - 1.0) / 16.0;
        let perspective = Camera { projection: Projection::Perspective { fov_y_rad: 2.0 * 0.2f32.atan() }, ..camera };
        for (camera, side) in [(camera, 200), (camera, 800), (perspective, 800)] {
            assert!((share(camera, side) / want - 1.0).abs() < 0.06, "{side}: {} {want}", share(camera, side));
        }
    }

    #[test]
    fn a_line_takes_no_more_than_a_part_of_a_thin_stick() {
        let (scene, camera) = view_of(&[], vec![stick([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.05)], 0.05);
        let frame = FrameConstants::new(&scene, &View::new(camera, 100, 100), &SETTINGS);
        let outline = Outline::of(&frame).unwrap();
        assert_eq!(outline.width(Vec3::ZERO, 0.05), MOST_WIDTH * 0.05);
        assert!((outline.width(Vec3::ZERO, 2.0) - 0.05 * 4.0).abs() < 1e-6);
        assert_eq!(Outline::of(&frame.without_outlines()), None);
    }

    #[test]
    fn a_grown_cone_is_wider_by_the_line_everywhere() {
        let outline = Outline { per_depth: 0.0, fixed: 0.1, near: 0.1, behind: 0.5 };
        for radii in [[0.5, 0.0], [0.0, 1.0], [0.7, 0.3], [2.0, 0.0]] {
            let instance = crate::scene::ConeInstance {
                a: [0.0, -1.0, 0.0],
                radius_a: radii[0],
                b: [0.0, 1.0, 0.0],
                radius_b: radii[1],
                color: Srgb8::WHITE,
                id: 1,
                reserved: [0; 2],
            };
            let cone = Cone::new(&instance, &Affine3A::IDENTITY).unwrap();
            let grown = outline.cone(&cone);
            assert!((grown.half_length - 1.1).abs() < 1e-6);
            assert!(grown.radii.iter().all(|&radius| radius > 0.0));
            // Distance of the slanted sides in the plane of the axis.
            let apart = (grown.middle_radius - cone.middle_radius) / (1.0 + cone.slope * cone.slope).sqrt();
            assert!((apart - 0.1).abs() < 1e-6 && grown.slope == cone.slope);
            let ends = [-1.1f32, 1.1].map(|y| grown.middle_radius + grown.slope * y);
            assert!(ends.iter().zip(grown.radii).all(|(end, radius)| (end - radius).abs() < 1e-6));
        }
    }
}
