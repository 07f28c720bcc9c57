//! The camera, and the one definition of which ray belongs to which point of the picture.
//!
//! View space is right-handed: x right, y up, the camera looks down −z. A ray is `origin + t·direction` with
//! `direction.z = −1` in both projections, so that `t` *is* the depth along the view axis in ångström.

use crate::math::Aabb;
use glam::{Affine3A, Mat3, Quat, Vec3};

/// How depth is projected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Rays through one point.
    Perspective {
        /// Full vertical opening angle in radians.
        fov_y_rad: f32,
    },
    /// Parallel rays.
    Orthographic {
        /// Height of the picture in ångström.
        height: f32,
    },
}

/// Where the picture is taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position in world space, ångström.
    pub eye: Vec3,
    /// Turns view directions into world directions.
    pub world_from_view: Quat,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// Depth of the near plane in ångström; nothing nearer is drawn, what crosses it is cut.
    pub near: f32,
    /// A depth in ångström that nothing drawn exceeds; it scales depth values, nothing is cut there.
    pub far: f32,
    /// The point that orbiting turns about, world space.
    pub target: Vec3,
    /// The place in the plane (slopes, or ångström in orthographic projection) that the middle of the picture shows: 0 but for a part of
    /// a lens, see [`crate::render::lens`].
    pub shift: [f32; 2],
}

/// A part of the picture, in pixels from the upper left corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// Left edge.
    pub x: u32,
    /// Upper edge.
    pub y: u32,
    /// Width, at least 1.
    pub width: u32,
    /// Height, at least 1.
    pub height: u32,
}

impl std::fmt::Display for Region {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{},{},{},{}", self.x, self.y, self.width, self.height)
    }
}

impl std::str::FromStr for Region {
    type Err = String;

    fn from_str(text: &str) -> Result<Region, String> {
        let wrong = || "expected X,Y,W,H in pixels from the upper left corner, such as 0,0,640,360".to_owned();
        let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Region { x, y, width, height }),
            _ => Err(wrong()),
        }
    }
}

/// A ray in view space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Origin: the eye, or a point of the eye's plane in orthographic projection.
    pub origin: Vec3,
    /// Direction with z = −1.
    pub direction: Vec3,
}

/// From pixels to rays: plane coordinates are the slopes `x/depth`, `y/depth` in perspective, ångström in
/// orthographic projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelGrid {
    /// Plane units per pixel.
    pub plane_per_px: f32,
    /// The centre of the full picture in pixels.
    pub center_px: [f32; 2],
    /// Whether rays are parallel.
    pub orthographic: bool,
}

impl PixelGrid {
    /// Plane coordinates of a point of the full picture, in pixels from its upper left corner.
    #[inline(always)]
    #[must_use]
    pub fn plane(&self, x_px: f32, y_px: f32) -> (f32, f32) {
        ((x_px - self.center_px[0]) * self.plane_per_px, (self.center_px[1] - y_px) * self.plane_per_px)
    }

    /// The ray of plane coordinates.
    #[inline(always)]
    #[must_use]
    pub fn ray(&self, (u, v): (f32, f32)) -> Ray {
        if self.orthographic {
            Ray { origin: Vec3::new(u, v, 0.0), direction: Vec3::new(0.0, 0.0, -1.0) }
        } else {
            Ray { origin: Vec3::ZERO, direction: Vec3::new(u, v, -1.0) }
        }
    }
}

impl Camera {
    /// The pixel grid of a picture of `width × height` pixels.
    #[must_use]
    pub fn pixel_grid(&self, width: u32, height: u32) -> PixelGrid {
        let (span, orthographic) = match self.projection {
            Projection::Perspective { fov_y_rad } => (2.0 * (fov_y_rad * 0.5).tan(), false),
            Projection::Orthographic { height } => (height, true),
        };
        let plane_per_px = span / height as f32;
        let [right, up] = self.shift.map(|shift| shift / plane_per_px);
        let center_px = [width as f32 * 0.5 - right, height as f32 * 0.5 + up];
        PixelGrid { plane_per_px, center_px, orthographic }
    }

    /// Rigid transform from world to view space.
    #[must_use]
    pub fn view_from_world(&self) -> Affine3A {
        let view_from_world = Mat3::from_quat(self.world_from_view).transpose();
        Affine3A::from_mat3_translation(view_from_world, -(view_from_world * self.eye))
    }

    /// The direction the camera looks, world space.
    #[must_use]
    pub fn forward(&self) -> Vec3 {
        self.world_from_view * Vec3::NEG_Z
    }

    /// Depth of a world point along the view direction.
    #[must_use]
    pub fn depth(&self, point_in_world: Vec3) -> f32 {
        (point_in_world - self.eye).dot(self.forward())
    }

    /// Depths of the nearest and the farthest corner of a box in world space.
    #[must_use]
    pub fn depth_range(&self, bounds: Aabb) -> [f32; 2] {
        let (middle, half) = (self.depth(bounds.center()), bounds.size() * 0.5);
        let reach = self.forward().abs().dot(half);
        [middle - reach, middle + reach]
    }

    /// Ångström per pixel at the depth of the target.
    #[must_use]
    pub fn angstrom_per_px(&self, height: u32) -> f32 {
        let grid = self.pixel_grid(1, height);
        if grid.orthographic { grid.plane_per_px } else { grid.plane_per_px * self.depth(self.target).max(self.near) }
    }

    /// The camera after the scene has turned on a turntable by so much, its front to the right: about the upright axis through the target,
    /// or, where the camera looks from above or below, about the picture's own.
    #[must_use]
    pub fn turned(mut self, angle_rad: f32) -> Camera {
        let up = self.world_from_view * Vec3::Y;
        // 60°: a look down on the ground of up to that much still has a front.
        let axis = if up.y.abs() >= 0.5 { Vec3::Y * up.y.signum() } else { up };
        let turn = Quat::from_axis_angle(axis, -angle_rad);
        self.eye = self.target + turn * (self.eye - self.target);
        self.world_from_view = (turn * self.world_from_view).normalize();
        self
    }

    /// The same view in the other projection: what is at the target's depth keeps its size.
    #[must_use]
    pub fn with_toggled_projection(mut self, fov_y_rad: f32) -> Camera {
        let depth = self.depth(self.target).max(self.near);
        match self.projection {
            Projection::Perspective { fov_y_rad } => {
                self.projection = Projection::Orthographic { height: 2.0 * depth * (fov_y_rad * 0.5).tan() };
            }
            Projection::Orthographic { height } => {
                let wanted = height * 0.5 / (fov_y_rad * 0.5).tan();
                self.eye = self.target - self.forward() * wanted;
                self.projection = Projection::Perspective { fov_y_rad };
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{FRAC_PI_2, TAU};

    #[test]
    fn a_turntable_takes_the_front_to_the_right_and_comes_back() {
        let camera = Camera {
            eye: Vec3::new(1.0, 3.0, 10.0),
            world_from_view: Quat::from_rotation_x(-0.3),
            projection: Projection::Orthographic { height: 5.0 },
            near: 0.1,
            far: 50.0,
            target: Vec3::new(1.0, 0.0, 0.0),
            shift: [0.0; 2],
        };
        let front = camera.target + Vec3::Z;
        let in_view = |camera: &Camera, point: Vec3| camera.view_from_world().transform_point3(point);
        assert!(in_view(&camera, front).x.abs() < 1e-5);
        let turned = camera.turned(FRAC_PI_2);
        assert!((in_view(&turned, front).x - 1.0).abs() < 1e-5, "{}", in_view(&turned, front));
        assert!((turned.eye.y - 3.0).abs() < 1e-5, "the camera stays as high");
        assert!(camera.turned(TAU).eye.distance(camera.eye) < 1e-4);
        let from_above = Camera { world_from_view: Quat::from_rotation_x(-FRAC_PI_2), ..camera };
        let up = |camera: &Camera| camera.world_from_view * Vec3::Y;
        assert!(up(&from_above.turned(1.0)).distance(up(&from_above)) < 1e-5, "the picture does not spin");
    }
}
