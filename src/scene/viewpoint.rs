//! A view that can be written down and taken again: where the molecule stands and where the camera is.

use super::camera::{Camera, Projection};
use super::{Pose, Scene, fit};
use glam::{DVec3, Quat, Vec3};

/// The pose of a scene and the camera in it. As text, sixteen or twenty-one numbers and the projection, with commas: the centre in the
/// coordinates of the file, the turn (a quaternion x, y, z, w), the camera's turn, the target, how far the eye is behind it, how far the
/// fitted camera looks down (radians), then, if they are kept, the eye and the nearest and farthest depth, and last `p` and the opening
/// angle in degrees, or `o` and the height in ångström.
///
/// The eye and the depths follow from the other numbers but for rounding; with them a picture is the same to the last bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// How the file's coordinates become the world's.
    pub pose: Pose,
    /// Turns view directions into world directions.
    pub world_from_view: Quat,
    /// What the camera turns about, world space.
    pub target: Vec3,
    /// How far the eye is from the target's plane across the view, ångström.
    pub distance: f32,
    /// How depth is projected.
    pub projection: Projection,
    /// Eye, near and far of the camera this was taken from.
    pub exact: Option<Exact>,
}

/// What of a camera is found again from a [`Viewpoint`]'s other numbers but for rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exact {
    /// [`Camera::eye`].
    pub eye: Vec3,
    /// [`Camera::near`].
    pub near: f32,
    /// [`Camera::far`].
    pub far: f32,
}

impl Viewpoint {
    /// The view of a camera in a scene.
    #[must_use]
    pub fn of(scene: &Scene, camera: &Camera) -> Viewpoint {
        // What turning turns about is where the camera looks, at the target's depth.
        let distance = camera.depth(camera.target);
        let target = camera.eye + camera.forward() * distance;
        let Camera { world_from_view, projection, eye, near, far, .. } = *camera;
        let exact = Some(Exact { eye, near, far });
        Viewpoint { pose: scene.pose, world_from_view, target, distance, projection, exact }
    }

    /// The same view in the other projection, if it is not the one that is asked for.
    #[must_use]
    pub fn in_perspective(self, perspective: bool) -> Viewpoint {
        if perspective == matches!(self.projection, Projection::Perspective { .. }) {
            return self;
        }
        let camera = self.raw_camera().with_toggled_projection(fit::FOV_Y_RAD);
        let distance = camera.depth(self.target);
        Viewpoint { projection: camera.projection, distance, exact: None, ..self }
    }

    /// The camera in a scene of this pose.
    #[must_use]
    pub fn camera(&self, scene: &Scene) -> Camera {
        let mut camera = self.raw_camera();
        camera.fit_depths(scene);
        if let Some(Exact { eye, near, far }) = self.exact
            // Rounding and nothing else: a hand that changed one number meant it.
            && eye.distance(camera.eye) <= 1e-4 * (self.distance + self.target.length())
        {
            camera.eye = eye;
            let size = scene.bounds().size().length().max(1e-3);
            let [_, farthest] = camera.depth_range(scene.bounds());
            // Of another scene they might cut something off.
            if near <= 2e-3 * size && far >= farthest {
                (camera.near, camera.far) = (near, far);
            }
        }
        camera
    }

    /// The camera without the depths of a scene.
    fn raw_camera(&self) -> Camera {
        let Viewpoint { world_from_view, target, distance, projection, .. } = *self;
        let eye = target - world_from_view * Vec3::NEG_Z * distance;
        Camera { eye, world_from_view, projection, near: 0.0, far: 0.0, target, shift: [0.0; 2] }
    }
}

impl Camera {
    /// Sets the depths of the near plane and of what lies farthest for a scene, as those of [`Scene::fitted_camera`] are.
    pub fn fit_depths(&mut self, scene: &Scene) {
        let bounds = scene.bounds();
        let size = bounds.size().length().max(1e-3);
        let middle = (bounds.center() - self.eye).dot(self.forward());
        self.near = 1e-3 * size;
        self.far = middle.max(0.0) + (0.5 + fit::GROUND_FADE_END) * size;
    }
}

impl std::fmt::Display for Viewpoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.pose.center.to_array();
        write!(f, "{x},{y},{z}")?;
        let numbers = (self.pose.turn.to_array().into_iter())
            .chain(self.world_from_view.to_array())
            .chain(self.target.to_array())
            .chain([self.distance, self.pose.pitch_rad]);
        for number in numbers {
            write!(f, ",{number}")?;
        }
        if let Some(Exact { eye, near, far }) = self.exact {
            write!(f, ",{},{},{},{near},{far}", eye.x, eye.y, eye.z)?;
        }
        match self.projection {
            Projection::Perspective { fov_y_rad } => {
                // As few digits as give the angle back.
                let (short, long) = (fov_y_rad.to_degrees(), f64::from(fov_y_rad).to_degrees());
                let gives_it_back = radians(f64::from(short)) == fov_y_rad;
                if gives_it_back { write!(f, ",p{short}") } else { write!(f, ",p{long}") }
            }
            Projection::Orthographic { height } => write!(f, ",o{height}"),
        }
    }
}

/// Degrees as a camera has them.
fn radians(degrees: f64) -> f32 {
    degrees.to_radians() as f32
}

impl std::str::FromStr for Viewpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Viewpoint, String> {
        let wrong = || {
            "expected sixteen or twenty-one numbers and p or o with a number, with commas, as the window's \"copy command line\" writes them"
                .to_owned()
        };
        let (numbers, projection) = text.trim().rsplit_once(',').ok_or_else(wrong)?;
        let numbers: Option<Vec<f64>> =
            numbers.split(',').map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let numbers = numbers.filter(|numbers| matches!(numbers.len(), 16 | 21)).ok_or_else(wrong)?;
        let f = |index: usize| numbers[index] as f32;
        let turn = |at: usize| {
            let quat = Quat::from_xyzw(f(at), f(at + 1), f(at + 2), f(at + 3));
            let length = quat.length();
            // Digits that were cut must not scale the picture; digits that are whole stay as they are.
            if (length - 1.0).abs() < 1e-5 { Some(quat) } else { (length > 1e-3).then(|| quat.normalize()) }
        };
        let (turns, positive) = ((turn(3), turn(7)), |x: &f32| x.is_finite() && *x > 0.0);
        let (Some(pose_turn), Some(world_from_view)) = turns else { return Err(wrong()) };
        let kind = projection.trim();
        let number = |text: &str| text.parse::<f64>().ok().filter(|x| *x > 0.0);
        let height = |text: &str| text.parse::<f32>().ok().filter(positive);
        let projection = match (kind.strip_prefix('p').and_then(number), kind.strip_prefix('o').and_then(height)) {
            (Some(degrees), _) if degrees < 170.0 => Projection::Perspective { fov_y_rad: radians(degrees) },
            (_, Some(height)) => Projection::Orthographic { height },
            _ => return Err(wrong()),
        };
        let distance = Some(f(14)).filter(positive).ok_or_else(wrong)?;
        let center = DVec3::new(numbers[0], numbers[1], numbers[2]);
        let pose = Pose { center, turn: pose_turn, pitch_rad: f(15) };
        let exact =
            (numbers.len() == 21).then(|| Exact { eye: Vec3::new(f(16), f(17), f(18)), near: f(19), far: f(20) });
        let is_sound =
            |Exact { eye, near, far }: &Exact| eye.is_finite() && *near > 0.0 && far > near && far.is_finite();
        if exact.as_ref().is_some_and(|exact| !is_sound(exact)) {
            return Err(wrong());
        }
        Ok(Viewpoint { pose, world_from_view, target: Vec3::new(f(11), f(12), f(13)), distance, projection, exact })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Item, SceneOptions};

    fn scene(options: &SceneOptions) -> Scene {
        let text = b"3\n\nO 10 20 30\nO 13 20 30\nO 10 24 31\n";
        let document = crate::import::read_bytes(text, "a.xyz", &Default::default()).unwrap();
        Scene::new(&[Item::of(&document.records[0])], options)
    }

    #[test]
    fn a_view_is_the_same_after_it_was_written_down() {
        for perspective in [true, false] {
            let options = SceneOptions { perspective, ..SceneOptions::default() };
            let first = scene(&options);
            let camera = first.fitted_camera(1.5);
            let view = Viewpoint::of(&first, &camera);
            let read: Viewpoint = view.to_string().parse().unwrap();
            let again = scene(&SceneOptions { pose: Some(read.pose), ..options });
            assert_eq!(again.pose, first.pose);
            // To the last bit, but for the point that turning turns about.
            let other = read.camera(&again);
            assert_eq!(Camera { target: camera.target, ..other }, camera);
            assert_eq!(read.to_string(), view.to_string());
            // Without the eye and the depths, but for rounding.
            let other = Viewpoint { exact: None, ..read }.to_string().parse::<Viewpoint>().unwrap().camera(&again);
            assert!(other.eye.distance(camera.eye) < 1e-4 && other.world_from_view == camera.world_from_view);
            let scale = (other.angstrom_per_px(600), camera.angstrom_per_px(600));
            assert!((scale.0 / scale.1 - 1.0).abs() < 1e-5);
            assert!(other.near > 0.0 && other.far > other.depth(again.bounds().center()));
        }
    }

    #[test]
    fn another_projection_keeps_the_size_and_another_scene_is_not_cut() {
        let first = scene(&SceneOptions::default());
        let camera = first.fitted_camera(1.5);
        let view = Viewpoint::of(&first, &camera);
        assert_eq!(view.in_perspective(true), view);
        let flat = view.in_perspective(false).camera(&first);
        assert!(matches!(flat.projection, Projection::Orthographic { .. }));
        assert!((flat.angstrom_per_px(600) / view.raw_camera().angstrom_per_px(600) - 1.0).abs() < 1e-4);
        let mut far_off = view;
        far_off.exact = far_off.exact.map(|exact| Exact { near: 3.0, far: 4.0, ..exact });
        let other = far_off.camera(&first);
        assert!(other.near < 1.0 && other.far > other.depth(first.bounds().center()) + 4.0);
    }

    #[test]
    fn what_is_no_view_is_refused() {
        let good = Viewpoint::of(&scene(&SceneOptions::default()), &scene(&SceneOptions::default()).fitted_camera(1.0));
        let good = good.to_string();
        assert!(good.parse::<Viewpoint>().is_ok());
        let zeros = format!("{}p24", "0,".repeat(16));
        for bad in [
            "",
            "1,2,3",
            &good.replace(",p", ",q"),
            &good.replace(",p", ",p-"),
            &format!("1,{good}"),
            &zeros,
            &good.replace(",p", ",nan,p"),
        ] {
            assert!(bad.parse::<Viewpoint>().is_err(), "{bad}");
        }
    }
}
