//! Depth of field: a lens of some width in place of a point.
//!
//! Each sample looks through another point of the lens ([`Lens::view`]): the eye moves aside and the picture with it, so that what
//! lies in the plane of focus stays where it is. A sample's camera is a camera like any other, so that nothing else in the
//! renderers knows of lenses. What is out of focus by much shows as so many faint copies as there are samples: 64 or more of them look smooth.
//!
//! Limits: only in perspective; ground and background, found once a pixel, stay sharp. Ids, depths, normals and labels are those of the
//! eye in the middle.

use super::settings::View;
use crate::scene::{Projection, Scene};
use glam::Vec2;

/// The lens of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Radius, ångström.
    pub radius: f32,
    /// Depth of the plane of focus, ångström.
    pub focus: f32,
}

impl Lens {
    /// That of a scene and a view; `None` if the picture is sharp everywhere.
    #[must_use]
    pub fn of(scene: &Scene, view: &View) -> Option<Lens> {
        let wanted = scene.depth_of_field.filter(|wanted| wanted.blur > 0.0)?;
        let (bounds, camera) = (scene.bounds(), view.camera);
        let Projection::Perspective { fov_y_rad } = camera.projection else { return None };
        if bounds.is_empty() {
            return None;
        }
        let [front, back] = camera.depth_range(bounds);
        let (front, depth) = (front.max(camera.near), (back - front).max(1e-3));
        let focus = front + wanted.focus * (back - front);
        // A point behind the focus by the scene's depth is spread over 2 · radius · (1 / focus − 1 / depth) of the plane.
        let plane_height = 2.0 * (fov_y_rad * 0.5).tan();
        let radius = 0.5 * wanted.blur * plane_height * focus * (focus + depth) / depth;
        (focus > 0.0 && radius.is_finite()).then_some(Lens { radius, focus })
    }

    /// The point of the lens that sample `sample` of `samples` looks through: a sunflower's seeds, evenly over the disc (Vogel, Math.
    /// Biosci. 1979, 44, 179). With the places of the samples in their pixel, radical inverses of the same number, they make a Hammersley set.
    /// One sample alone looks through the middle.
    #[must_use]
    pub fn point(&self, sample: u32, samples: u32) -> Vec2 {
        if samples <= 1 {
            return Vec2::ZERO;
        }
        let golden_angle = std::f32::consts::PI * (3.0 - 5f32.sqrt());
        let radius = self.radius * ((sample as f32 + 0.5) / samples.max(1) as f32).sqrt();
        Vec2::from_angle(golden_angle * sample as f32) * radius
    }

    /// The view of one sample.
    #[must_use]
    pub fn view(&self, view: &View, sample: u32, samples: u32) -> View {
        let point = self.point(sample, samples);
        let mut view = *view;
        view.camera.eye += view.camera.world_from_view * point.extend(0.0);
        view.camera.shift = (Vec2::from(view.camera.shift) - point / self.focus).to_array();
        view
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Srgb8;
    use crate::render::cpu::reference;
    use crate::render::{Image, Settings};
    use crate::scene::{Block, Camera, DepthOfField, Placement, SphereInstance};
    use glam::{Affine3A, Quat, Vec3};

    /// Balls at z = 2, 0 and −2, seen from z = 20 along −z.
    fn scene(blur: f32) -> (Scene, View) {
        let ball =
            |x: f32, z: f32| SphereInstance { center: [x, 0.0, z], radius: 0.5, color: Srgb8::rgb(200, 0, 0), id: 1 };
        let block =
            Block { spheres: vec![ball(-2.0, 2.0), ball(0.0, 0.0), ball(2.0, -2.0)], id_count: 3, ..Block::default() };
        let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
        let mut scene = Scene::from_blocks(vec![block], vec![placement]);
        scene.depth_of_field = Some(DepthOfField { blur, focus: 0.5 });
        let camera = Camera {
            eye: Vec3::new(0.0, 0.0, 20.0),
            world_from_view: Quat::IDENTITY,
            projection: Projection::Perspective { fov_y_rad: 0.3 },
            near: 0.1,
            far: 100.0,
            target: Vec3::ZERO,
            shift: [0.0; 2],
        };
        (scene, View::new(camera, 240, 120))
    }

    /// Pixel of a world point.
    fn pixel(view: &View, p: Vec3) -> Vec2 {
        let (q, grid) = (view.camera.view_from_world().transform_point3(p), view.pixel_grid());
        let plane = q.truncate() / -q.z / grid.plane_per_px;
        Vec2::from(grid.center_px) + Vec2::new(plane.x, -plane.y)
    }

    #[test]
    fn the_plane_of_focus_stays_and_the_rest_moves_by_as_much_as_was_asked() {
        let (scene, mut view) = scene(0.05);
        view.camera.world_from_view = Quat::from_rotation_z(0.7);
        let lens = Lens::of(&scene, &view).unwrap();
        assert!((lens.focus - 20.0).abs() < 1e-4);
        // The balls reach from z = 2.5 to −2.5.
        let mut widest = 0.0f32;
        for sample in 0..256 {
            let of_sample = lens.view(&view, sample, 256);
            for p in [Vec3::new(1.0, 0.5, 0.0), Vec3::new(-3.0, 1.0, 0.0)] {
                assert!((pixel(&of_sample, p) - pixel(&view, p)).length() < 1e-2);
            }
            let behind = Vec3::new(0.3, 0.2, -5.0);
            widest = widest.max((pixel(&of_sample, behind) - pixel(&view, behind)).length());
        }
        // Half of 0.05 of 120 pixels.
        assert!((widest - 3.0).abs() < 0.05, "{widest}");
    }

    #[test]
    fn points_fill_the_lens_evenly() {
        let lens = Lens { radius: 2.0, focus: 9.0 };
        assert_eq!(lens.point(0, 1), Vec2::ZERO);
        for samples in [16, 64, 256] {
            let points: Vec<Vec2> = (0..samples).map(|sample| lens.point(sample, samples)).collect();
            let mean = points.iter().fold(Vec2::ZERO, |sum, p| sum + *p) / samples as f32;
            let spread = points.iter().map(|p| p.length_squared()).sum::<f32>() / samples as f32;
            // The mean square distance from the middle of a disc is half the square of its radius.
            assert!(mean.length() < 0.2 && (spread - 2.0).abs() < 1e-3, "{samples}: {mean} {spread}");
        }
    }

    #[test]
    fn what_is_in_focus_is_sharp_and_what_is_not_is_blurred() {
        let settings = Settings { samples: 64, ground_texels: 16, ao: 0, shadow: false };
        let picture = |blur: f32| {
            let (scene, view) = scene(blur);
            (reference::image(&scene, &view, &settings), view)
        };
        let ((sharp, view), (blurred, _)) = (picture(0.0), picture(0.2));
        // The steepest step from one pixel of the ball's row to the next, as a part of the whole.
        let edge = |image: &Image, x: f32, z: f32| {
            let at = pixel(&view, Vec3::new(x, 0.0, z));
            let row = |px: i32| i32::from(image.rgba[(at.y as usize * 240 + px.clamp(0, 239) as usize) * 4 + 1]);
            let near = at.x as i32;
            (near..near + 20).map(|px| (row(px + 1) - row(px)).abs()).max().unwrap_or(0)
        };
        assert!(edge(&sharp, -2.0, 2.0) > 90 && edge(&sharp, 0.0, 0.0) > 90 && edge(&sharp, 2.0, -2.0) > 90);
        assert!(edge(&blurred, 0.0, 0.0) > 60 && edge(&blurred, -2.0, 2.0) < 60 && edge(&blurred, 2.0, -2.0) < 60);
    }

    #[test]
    fn there_is_no_lens_unless_it_is_asked_for_and_none_with_parallel_rays() {
        let (mut scene, mut view) = scene(0.0);
        assert_eq!(Lens::of(&scene, &view), None);
        scene.depth_of_field = Some(DepthOfField { blur: 0.1, focus: 0.0 });
        assert!((Lens::of(&scene, &view).unwrap().focus - 17.5).abs() < 1e-3);
        view.camera.projection = Projection::Orthographic { height: 5.0 };
        assert_eq!(Lens::of(&scene, &view), None);
        scene.depth_of_field = None;
        assert_eq!(Lens::of(&scene, &view), None);
    }
}
