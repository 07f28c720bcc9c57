//! Arrows: a stick and a pointed cone.

use super::instances::{Cap, CylinderInstance};
use super::shapes::ConeInstance;
use crate::color::Srgb8;
use glam::Vec3;

/// What all arrows of a kind have in common, ångström.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ArrowShape {
    pub(super) shaft_radius: f32,
    pub(super) head_radius: f32,
    pub(super) head_length: f32,
}

impl ArrowShape {
    /// An arrow that begins `hidden` (the radius of a ball about `from`) away from a point and goes on by `vector`. One that
    /// is shorter than two heads is smaller as a whole. `None` for one without length.
    pub(super) fn arrow(
        self,
        from: Vec3,
        hidden: f32,
        vector: Vec3,
        color: Srgb8,
        id: u32,
    ) -> Option<(CylinderInstance, ConeInstance)> {
        let along = vector.try_normalize()?;
        let length = vector.length();
        let scale = (length / (2.0 * self.head_length)).min(1.0);
        let [shaft, head, head_length] = [self.shaft_radius, self.head_radius, self.head_length].map(|x| x * scale);
        // Inside the ball, so that its flat end does not show.
        let start = from + along * (hidden * hidden - shaft * shaft).max(0.0).sqrt();
        let tip = from + along * (hidden + length);
        let base = tip - along * head_length;
        let stick = CylinderInstance {
            a: start.to_array(),
            radius: shaft,
            // A little into the head, whose base is then the only disc in its plane.
            b: (base + along * (0.2 * head_length)).to_array(),
            id,
            color_a: color,
            color_b: color,
            caps: CylinderInstance::pack_caps(Cap::Flat, Cap::Flat),
            hidden: 0,
        };
        let (a, b) = (base.to_array(), tip.to_array());
        Some((stick, ConeInstance { a, radius_a: head, b, radius_b: 0.0, color, id, reserved: [0; 2] }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: ArrowShape = ArrowShape { shaft_radius: 0.05, head_radius: 0.15, head_length: 0.4 };

    #[test]
    fn an_arrow_ends_at_the_length_of_its_vector_beyond_the_ball() {
        let vector = Vec3::new(0.0, 3.0, 0.0);
        let (stick, cone) = SHAPE.arrow(Vec3::X, 0.3, vector, Srgb8::WHITE, 7).unwrap();
        assert!((Vec3::from(cone.b) - Vec3::new(1.0, 3.3, 0.0)).length() < 1e-6);
        assert!((Vec3::from(cone.a) - Vec3::new(1.0, 2.9, 0.0)).length() < 1e-6);
        assert!(stick.a[1] > 0.28 && stick.a[1] < 0.3 && stick.b[1] > cone.a[1] && stick.b[1] < cone.b[1]);
        assert_eq!((stick.id, cone.id, cone.radius_b), (7, 7, 0.0));
    }

    #[test]
    fn a_short_arrow_is_small_and_none_has_no_length() {
        let (stick, cone) = SHAPE.arrow(Vec3::ZERO, 0.0, Vec3::X * 0.2, Srgb8::WHITE, 1).unwrap();
        assert!((cone.b[0] - 0.2).abs() < 1e-6 && (cone.a[0] - 0.1).abs() < 1e-6);
        assert!(stick.radius < cone.radius_a && cone.radius_a < 0.04);
        for nothing in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            assert_eq!(SHAPE.arrow(Vec3::ZERO, 0.3, nothing, Srgb8::WHITE, 1), None);
        }
    }
}
