//! Marks about chosen atoms: a ring round the ball, as the viewer sees it.

use super::Scene;
use super::shapes::TorusInstance;
use crate::color::Srgb8;
use crate::math::direction_or;
use glam::Vec3;

/// Radius of the ring in radii of the ball, and of its tube, with the tube's least in ångström (chosen: a clear gap to the ball, and
/// to be seen about the thin wires, too).
const RING: f32 = 1.35;
const TUBE: (f32, f32) = (0.12, 0.03);

impl Scene {
    /// Rings about the balls with these ids (1 + index of the atom, behind the first id of their placement), in world
    /// space, across the view axis `view_axis`; ids that no ball has give none. Each has the id of its ball.
    ///
    /// They turn with the view: make them anew when the camera has turned.
    #[must_use]
    pub fn halos(&self, ids: &[u32], view_axis: Vec3, color: Srgb8) -> Vec<TorusInstance> {
        let axis = direction_or(view_axis, Vec3::Z).to_array();
        let mut halos = Vec::with_capacity(ids.len());
        for &id in ids {
            let Some((center, radius)) = self.ball(id) else { continue };
            let tube_radius = (TUBE.0 * radius).max(TUBE.1);
            let ring_radius = (RING * radius).max(radius + 2.0 * tube_radius);
            let center = center.to_array();
            halos.push(TorusInstance { center, ring_radius, axis, tube_radius, color, id, reserved: [0; 2] });
        }
        halos
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Item, SceneOptions};

    #[test]
    fn a_halo_goes_round_the_ball_clear_of_it_across_the_view() {
        let document = crate::import::read_bytes(b"2\n\nC 0 0 0\nI 2.1 0 0\n", "a.xyz", &Default::default()).unwrap();
        let molecule = &document.records[0];
        // The same molecule twice, the second one beside the first.
        let items = [Item::of(molecule), Item { offset: Vec3::Y * 5.0, ..Item::of(molecule) }];
        for style in crate::scene::Style::ALL {
            let scene = Scene::new(&items, &SceneOptions { style, ..SceneOptions::default() });
            let halos = scene.halos(&[4, 9, 1, 0, u32::MAX], Vec3::new(0.0, 0.0, -2.0), Srgb8::WHITE);
            assert_eq!(halos.iter().map(|halo| halo.id).collect::<Vec<_>>(), [4, 1]);
            let balls: Vec<(Vec3, f32)> = scene.world_spheres().collect();
            for (halo, (center, radius)) in halos.iter().zip([balls[3], balls[0]]) {
                assert_eq!((Vec3::from(halo.center), halo.axis), (center, [0.0, 0.0, -1.0]));
                assert!(halo.ring_radius - halo.tube_radius > radius && halo.tube_radius < 0.5 * halo.ring_radius);
            }
        }
    }
}
