//! The camera under the mouse: orbit, pan, zoom to the pointer.

use crate::scene::{Camera, Projection};
use glam::{Quat, Vec3};

/// What dragging does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Drag {
    /// Turns about the target.
    Orbit,
    /// Moves along the picture plane.
    Pan,
    /// Comes nearer (downwards) or goes away.
    Zoom,
    /// Turns about the line of sight.
    Roll,
    /// Draws a rectangle about what is to be selected.
    Select,
}

/// A drag across the shorter side of the window turns by half a turn.
const TURN_PER_SIDE_RAD: f32 = std::f32::consts::PI;
/// One notch of the wheel brings the pointer's place nearer by this factor.
pub(super) const ZOOM_PER_NOTCH: f32 = 1.15;

/// Turns the camera about its target. With a ground it stays upright (turntable) and above it; without, it turns freely.
pub(super) fn orbit(camera: &mut Camera, dx_px: f32, dy_px: f32, shorter_side_px: f32, upright: bool) {
    let per_px = TURN_PER_SIDE_RAD / shorter_side_px.max(1.0);
    let (yaw, mut pitch) = (-dx_px * per_px, -dy_px * per_px);
    let turn = if upright {
        // How far the camera looks down now; it may look from the horizon to straight down.
        let down = (-camera.forward().y).clamp(-1.0, 1.0).asin();
        let limit = std::f32::consts::FRAC_PI_2 - 0.01;
        let wanted = (down - pitch).clamp(0.0_f32.min(down), limit);
        pitch = down - wanted;
        Quat::from_rotation_y(yaw) * Quat::from_axis_angle(camera.world_from_view * Vec3::X, pitch)
    } else {
        let axis = camera.world_from_view * Vec3::new(pitch, yaw, 0.0);
        Quat::from_scaled_axis(axis)
    };
    camera.eye = camera.target + turn * (camera.eye - camera.target);
    camera.world_from_view = (turn * camera.world_from_view).normalize();
}

/// Turns about the line of sight, clockwise by a drag to the right.
pub(super) fn roll(camera: &mut Camera, dx_px: f32, shorter_side_px: f32) {
    let angle = dx_px * TURN_PER_SIDE_RAD / shorter_side_px.max(1.0);
    let turn = Quat::from_axis_angle(camera.world_from_view * Vec3::Z, angle);
    camera.eye = camera.target + turn * (camera.eye - camera.target);
    camera.world_from_view = (turn * camera.world_from_view).normalize();
}

/// Moves the camera so that what is at the target's depth follows the pointer.
pub(super) fn pan(camera: &mut Camera, dx_px: f32, dy_px: f32, height_px: u32) {
    let scale = camera.angstrom_per_px(height_px);
    let shift = camera.world_from_view * Vec3::new(-dx_px * scale, dy_px * scale, 0.0);
    camera.eye += shift;
    camera.target += shift;
}

/// Zooms by notches of the wheel; the point under the pointer, at the target's depth, stays where it is.
/// `pointer_px` is relative to the window's centre, y up. `smallest` is the nearest the target may come, in ångström.
pub(super) fn zoom(camera: &mut Camera, notches: f32, pointer_px: [f32; 2], height_px: u32, smallest: f32) {
    let before = camera.angstrom_per_px(height_px);
    let factor = ZOOM_PER_NOTCH.powf(-notches.clamp(-20.0, 20.0));
    match &mut camera.projection {
        Projection::Orthographic { height } => *height = (*height * factor).clamp(smallest, 1e7),
        Projection::Perspective { .. } => {
            let forward = camera.world_from_view * Vec3::NEG_Z;
            let depth = (camera.target - camera.eye).dot(forward).max(smallest);
            camera.eye += forward * (depth - (depth * factor).clamp(smallest, 1e7));
        }
    }
    let change = before - camera.angstrom_per_px(height_px);
    let shift = camera.world_from_view * Vec3::new(pointer_px[0] * change, pointer_px[1] * change, 0.0);
    camera.eye += shift;
    camera.target += shift;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::fit;

    fn camera(perspective: bool) -> Camera {
        let tilt = Quat::from_rotation_x(-fit::PITCH_RAD);
        fit::frame([(Vec3::ZERO, 5.0)].into_iter(), tilt, perspective, 1.5)
    }

    fn on_screen(camera: &Camera, point: Vec3) -> [f32; 2] {
        let p = camera.view_from_world().transform_point3(point);
        let grid = camera.pixel_grid(900, 600);
        let depth = if grid.orthographic { 1.0 } else { -p.z };
        [p.x / depth / grid.plane_per_px, p.y / depth / grid.plane_per_px]
    }

    #[test]
    fn orbit_keeps_the_target_and_its_distance() {
        for upright in [true, false] {
            let mut c = camera(true);
            let distance = c.eye.distance(c.target);
            orbit(&mut c, 80.0, -35.0, 600.0, upright);
            assert!((c.eye.distance(c.target) - distance).abs() < 1e-3);
            assert!(on_screen(&c, c.target).iter().all(|x| x.abs() < 0.05));
        }
    }

    #[test]
    fn roll_turns_the_picture_about_its_middle() {
        let mut c = camera(true);
        let right = c.target + c.world_from_view * Vec3::X;
        let before = on_screen(&c, right);
        roll(&mut c, 300.0, 600.0);
        let [x, y] = on_screen(&c, right);
        // A quarter of a turn to the right: what was on the right is below.
        assert!(x.abs() < 0.05 && (y + before[0]).abs() < 0.05, "{x} {y}");
    }

    #[test]
    fn a_drag_to_the_right_brings_the_left_side_forward() {
        let mut c = camera(true);
        let front = c.target + (c.eye - c.target).normalize();
        let before = on_screen(&c, front)[0];
        orbit(&mut c, 50.0, 0.0, 600.0, true);
        assert!(on_screen(&c, front)[0] > before + 1.0, "the near side follows the pointer");
    }

    #[test]
    fn the_turntable_stays_upright_and_above_the_ground() {
        let mut c = camera(true);
        for step in 0..100 {
            orbit(&mut c, 13.0, if step < 50 { 40.0 } else { -40.0 }, 600.0, true);
            let right = c.world_from_view * Vec3::X;
            assert!(right.y.abs() < 1e-3, "{right}");
            assert!(c.forward().y <= 1e-3);
        }
    }

    #[test]
    fn pan_moves_the_target_with_the_pointer() {
        for perspective in [true, false] {
            let mut c = camera(perspective);
            let target = c.target;
            pan(&mut c, 30.0, 12.0, 600);
            let [x, y] = on_screen(&c, target);
            assert!((x - 30.0).abs() < 0.1 && (y + 12.0).abs() < 0.1, "{x} {y}");
        }
    }

    #[test]
    fn zoom_keeps_what_is_under_the_pointer() {
        for perspective in [true, false] {
            for notches in [3.0, -4.0] {
                let mut c = camera(perspective);
                let scale = c.angstrom_per_px(600);
                let under = c.target + c.world_from_view * Vec3::new(120.0 * scale, 70.0 * scale, 0.0);
                zoom(&mut c, notches, [120.0, 70.0], 600, 0.5);
                let [x, y] = on_screen(&c, under);
                assert!((x - 120.0).abs() < 0.2 && (y - 70.0).abs() < 0.2, "{perspective} {notches}: {x} {y}");
                assert!((c.angstrom_per_px(600) < scale) == (notches > 0.0));
            }
        }
    }

    #[test]
    fn zooming_for_ever_stays_finite() {
        for perspective in [true, false] {
            for notches in [20.0, -20.0] {
                let mut c = camera(perspective);
                for _ in 0..200 {
                    zoom(&mut c, notches, [10.0, -10.0], 600, 0.5);
                }
                assert!(c.eye.is_finite() && c.target.is_finite() && c.angstrom_per_px(600) > 0.0);
            }
        }
    }
}
