//! The unit cell.

use glam::{DMat3, DVec3};

/// A unit cell: three vectors in ångström. Made from lengths and angles it has **a** along x and **b** in the
/// xy plane, as PDB and CIF files mean it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    cartesian_from_fractional: DMat3,
}

impl Cell {
    /// From edge lengths (Å) and angles (degrees); `None` if they do not span a cell (zero, negative, not finite, flat).
    ///
    /// ```
    /// use ballstick::structure::Cell;
    /// let cell = Cell::from_parameters([2.0, 3.0, 4.0], [90.0, 90.0, 90.0]).unwrap();
    /// assert!((cell.volume() - 24.0).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn from_parameters(lengths: [f64; 3], angles_deg: [f64; 3]) -> Option<Cell> {
        let [a, b, c] = lengths;
        let [cos_alpha, cos_beta, cos_gamma] = angles_deg.map(cos_deg);
        let sin_gamma = (1.0 - cos_gamma * cos_gamma).max(0.0).sqrt();
        if sin_gamma < 1e-6 {
            return None;
        }
        let cx = cos_beta;
        let cy = (cos_alpha - cos_beta * cos_gamma) / sin_gamma;
        let cz = (1.0 - cx * cx - cy * cy).max(0.0).sqrt();
        Self::from_vectors(
            DVec3::new(a, 0.0, 0.0),
            DVec3::new(b * cos_gamma, b * sin_gamma, 0.0),
            DVec3::new(c * cx, c * cy, c * cz),
        )
        .filter(|_| a > 0.0 && b > 0.0 && c > 0.0)
    }

    /// From the three vectors; `None` if they are not finite or span no volume (under 1e-6 of the box of their lengths).
    #[must_use]
    pub fn from_vectors(a: DVec3, b: DVec3, c: DVec3) -> Option<Cell> {
        let matrix = DMat3::from_cols(a, b, c);
        let volume = matrix.determinant().abs();
        let spans = volume.is_finite() && volume > 1e-6 * a.length() * b.length() * c.length();
        (spans && matrix.is_finite()).then_some(Cell { cartesian_from_fractional: matrix })
    }

    /// The vectors **a**, **b**, **c** in ångström.
    #[must_use]
    pub fn vectors(&self) -> [DVec3; 3] {
        let m = self.cartesian_from_fractional;
        [m.x_axis, m.y_axis, m.z_axis]
    }

    /// Columns are the cell vectors.
    #[must_use]
    pub fn cartesian_from_fractional(&self) -> DMat3 {
        self.cartesian_from_fractional
    }

    /// The inverse of [`Cell::cartesian_from_fractional`].
    #[must_use]
    pub fn fractional_from_cartesian(&self) -> DMat3 {
        self.cartesian_from_fractional.inverse()
    }

    /// Edge lengths in ångström.
    #[must_use]
    pub fn lengths(&self) -> [f64; 3] {
        self.vectors().map(DVec3::length)
    }

    /// Angles α (between **b** and **c**), β, γ in degrees.
    #[must_use]
    pub fn angles_deg(&self) -> [f64; 3] {
        let [a, b, c] = self.vectors();
        let angle = |u: DVec3, v: DVec3| {
            let degrees = u.cross(v).length().atan2(u.dot(v)).to_degrees();
            let rounded = (degrees * 1e6).round() / 1e6; // 90.00000000000001 helps nobody
            if (degrees - rounded).abs() < 1e-9 { rounded } else { degrees }
        };
        [angle(b, c), angle(a, c), angle(a, b)]
    }

    /// Distances between opposite faces in ångström: those that **a**, **b** and **c** lead from and to.
    #[must_use]
    pub fn face_distances(&self) -> DVec3 {
        let [a, b, c] = self.vectors();
        let across = |u: DVec3, v: DVec3| self.volume() / u.cross(v).length();
        DVec3::new(across(b, c), across(c, a), across(a, b))
    }

    /// Volume in Å³.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.cartesian_from_fractional.determinant().abs()
    }
}

/// Cosine of an angle in degrees, exactly 0 at 90°: most cells are right-angled and should stay so.
fn cos_deg(angle_deg: f64) -> f64 {
    if angle_deg == 90.0 { 0.0 } else { angle_deg.to_radians().cos() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_survive_the_way_through_vectors() {
        let cell = Cell::from_parameters([10.0, 11.5, 7.25], [92.5, 101.25, 118.0]).unwrap();
        for (got, want) in cell.lengths().iter().zip([10.0, 11.5, 7.25]) {
            assert!((got - want).abs() < 1e-12);
        }
        for (got, want) in cell.angles_deg().iter().zip([92.5, 101.25, 118.0]) {
            assert!((got - want).abs() < 1e-9);
        }
    }

    #[test]
    fn what_spans_no_cell_is_none() {
        assert_eq!(Cell::from_parameters([0.0, 1.0, 1.0], [90.0; 3]), None);
        assert_eq!(Cell::from_parameters([-1.0, 1.0, 1.0], [90.0; 3]), None);
        assert_eq!(Cell::from_parameters([1.0; 3], [0.0, 90.0, 90.0]), None);
        assert_eq!(Cell::from_parameters([1.0; 3], [90.0, 90.0, 180.0]), None);
        assert_eq!(Cell::from_parameters([f64::NAN, 1.0, 1.0], [90.0; 3]), None);
        assert_eq!(Cell::from_parameters([f64::INFINITY, 1.0, 1.0], [90.0; 3]), None);
        assert_eq!(Cell::from_vectors(DVec3::X, DVec3::X, DVec3::Z), None);
    }
}
