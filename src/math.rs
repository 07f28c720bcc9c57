//! Geometry that several layers share: bounds, safe directions, perpendicular frames.

use glam::{Affine3A, Mat3, Vec3, Vec3A};

/// The smaller of two numbers, the second beside NaN: one instruction, where `f32::min` takes several for NaN's sake.
#[inline(always)]
#[must_use]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers, the second beside NaN. See [`min`].
#[inline(always)]
#[must_use]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// An axis-aligned box. The empty one has `min > max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Aabb {
    /// Holds nothing.
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box around a sphere.
    #[must_use]
    pub fn of_sphere(center: Vec3, radius: f32) -> Aabb {
        Aabb { min: center - radius, max: center + radius }
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether it holds nothing.
    #[must_use]
    pub fn is_empty(self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Centre; the origin for an empty box.
    #[must_use]
    pub fn center(self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { (self.min + self.max) * 0.5 }
    }

    /// Edge lengths; zero for an empty box.
    #[must_use]
    pub fn size(self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// The same box with every face moved outwards.
    #[must_use]
    pub fn grown(self, by: f32) -> Aabb {
        Aabb { min: self.min - by, max: self.max + by }
    }

    /// A box around this one where a motion brings it.
    #[must_use]
    pub fn moved(self, motion: &Affine3A) -> Aabb {
        let (middle, half) = (motion.transform_point3((self.min + self.max) * 0.5), (self.max - self.min) * 0.5);
        let reach = Vec3::from(motion.matrix3.abs() * Vec3A::from(half));
        // Rounding must not cut what lies on its faces.
        let reach = reach + (middle.abs() + reach) * 1e-5;
        Aabb { min: middle - reach, max: middle + reach }
    }

    /// Distance from a point to the box, 0 inside.
    #[must_use]
    pub fn distance(self, point: Vec3) -> f32 {
        (self.min - point).max(point - self.max).max(Vec3::ZERO).length()
    }

    /// The interval of `t` in which `origin + t·direction` is inside, `None` if it never is. `inverse_direction` is
    /// `1/direction` by components; infinities (axis-parallel rays) are right, except on a face, where the box counts as hit.
    #[must_use]
    pub fn slab(self, origin: Vec3, inverse_direction: Vec3) -> Option<(f32, f32)> {
        let t0 = (self.min - origin) * inverse_direction;
        let t1 = (self.max - origin) * inverse_direction;
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        for axis in 0..3 {
            if t0[axis].is_nan() || t1[axis].is_nan() {
                continue; // 0·∞: in the plane of a face, where no t leaves the slab
            }
            near = near.max(t0[axis].min(t1[axis]));
            far = far.min(t0[axis].max(t1[axis]));
        }
        (near <= far).then_some((near, far))
    }
}

/// `v / |v|`, or `fallback` where that has no meaning (zero or not finite).
#[must_use]
pub fn direction_or(v: Vec3, fallback: Vec3) -> Vec3 {
    v.try_normalize().unwrap_or(fallback)
}

/// A rotation whose rows are `x`, `axis`, `z`: it turns the unit vector `axis` onto +Y. No case is degenerate
/// (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017), `axis` = −Y included.
#[must_use]
pub fn rotation_to_y(axis: Vec3) -> Mat3 {
    // Duff's frame about n = axis, with its z taken as our y.
    let sign = if axis.z >= 0.0 { 1.0f32 } else { -1.0 };
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let x = Vec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    let w = Vec3::new(b, sign + axis.y * axis.y * a, -axis.y);
    // (x, w, axis) is right-handed, so (x, axis, −w) is.
    Mat3::from_cols(x, axis, -w).transpose()
}

/// A whole number of 0 to 2²³ − 1, rounded: its bits after 2²³ was added. A cast would check for more.
#[inline(always)]
#[must_use]
pub fn whole(x: f32) -> u32 {
    (x + 8_388_608.0).to_bits() & 0x7f_ffff
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn assert_is_rotation_to_y(axis: Vec3) {
        let m = rotation_to_y(axis);
        assert!((m * axis - Vec3::Y).length() < 2e-6, "{axis}");
        assert!((m.determinant() - 1.0).abs() < 2e-6, "{axis}");
        assert!((m * m.transpose()).abs_diff_eq(Mat3::IDENTITY, 2e-6), "{axis}");
    }

    #[test]
    fn rotation_has_no_degenerate_axis() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
            assert_is_rotation_to_y(axis);
        }
    }

    proptest! {
        #[test]
        fn rotation_turns_any_axis_to_y(x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0) {
            let v = Vec3::new(x, y, z);
            prop_assume!(v.length() > 1e-3);
            assert_is_rotation_to_y(v.normalize());
        }
    }

    #[test]
    fn slab_handles_axis_parallel_rays() {
        let cube = Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
        let inverse = |d: Vec3| d.recip();
        assert_eq!(cube.slab(Vec3::new(-3.0, 0.0, 0.0), inverse(Vec3::X)), Some((2.0, 4.0)));
        assert_eq!(cube.slab(Vec3::new(-3.0, 2.0, 0.0), inverse(Vec3::X)), None);
        assert!(cube.slab(Vec3::new(-3.0, 1.0, 0.0), inverse(Vec3::X)).is_some());
    }

    #[test]
    fn an_empty_box_is_harmless() {
        assert!(Aabb::EMPTY.is_empty());
        assert_eq!((Aabb::EMPTY.center(), Aabb::EMPTY.size()), (Vec3::ZERO, Vec3::ZERO));
        let unit = Aabb::of_sphere(Vec3::ZERO, 1.0);
        assert_eq!(Aabb::EMPTY.union(unit), unit);
    }

    #[test]
    fn whole_numbers_are_rounded() {
        assert_eq!([0.0, 0.4, 0.6, 65_535.2, 8_388_607.0].map(whole), [0, 0, 1, 65_535, 8_388_607]);
    }
}
