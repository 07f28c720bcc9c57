//! Atom positions: f32 about an f64 origin, with the digits that do not fit kept beside them.
//!
//! `position = origin + coarse + fine`. Drawing needs only `coarse`. `fine` is there only where the file's
//! digits do not fit 24 bits (quantum chemistry output with ten decimals, say): then coarse + fine are the f64 that was read, and
//! it can be written back digit for digit.

use glam::{DVec3, Vec3};

/// Positions of all atoms in ångström.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Positions {
    origin: DVec3,
    coarse: Vec<Vec3>,
    fine: Vec<DVec3>,
    decimals: u8,
}

impl Positions {
    /// Decimals that an f64 of molecular size holds. With so many, or an unknown number, writers give the shortest digits that read
    /// back as the same f64.
    pub const MAX_DECIMALS: u8 = 14;

    /// From f64 positions and the number of decimals they were written with ([`Positions::MAX_DECIMALS`] where
    /// unknown, as in computed ones). Returns the positions and whether written digits were lost.
    ///
    /// The origin is the centre of the bounds rounded to a multiple of 1024 Å, so it is 0 for all but displaced molecules.
    #[must_use]
    pub fn from_f64(points: &[DVec3], decimals: u8) -> (Positions, bool) {
        let mut all = Points::default();
        points.iter().for_each(|&point| all.push(point));
        all.into_positions(decimals)
    }

    /// Number of atoms.
    #[must_use]
    pub fn len(&self) -> usize {
        self.coarse.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.coarse.is_empty()
    }

    /// What all of [`Positions::relative`] is relative to.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Positions relative to the origin, to f32's accuracy: what is drawn and what bonds are found from.
    #[must_use]
    pub fn relative(&self) -> &[Vec3] {
        &self.coarse
    }

    /// One position with all the digits kept.
    #[must_use]
    pub fn get(&self, atom: usize) -> DVec3 {
        let fine = self.fine.get(atom).copied().unwrap_or(DVec3::ZERO);
        self.origin + (self.coarse[atom].as_dvec3() + fine)
    }

    /// How many decimals the file had; writers give as many.
    #[must_use]
    pub fn decimals(&self) -> u8 {
        self.decimals
    }

    /// One position as written: rounded to [`Positions::decimals`].
    #[must_use]
    pub fn written(&self, atom: usize) -> DVec3 {
        let scale = 10f64.powi(i32::from(self.decimals));
        let position = self.get(atom);
        let rounded = (position * scale).round() / scale;
        if self.decimals >= Self::MAX_DECIMALS || !rounded.is_finite() { position } else { rounded }
    }
}

/// Positions as they are read, which become [`Positions`] in the memory they are in: a file of nothing but positions
/// takes at its peak what the f64 take, not that and the result.
#[derive(Debug, Default)]
pub(super) struct Points {
    /// The bits of each position in two halves, so that either half has room for a position in f32.
    halves: Vec<[u32; 3]>,
}

impl Points {
    pub(super) fn len(&self) -> usize {
        self.halves.len() / 2
    }

    pub(super) fn reserve(&mut self, points: usize) {
        self.halves.reserve(points.saturating_mul(2));
    }

    #[inline]
    pub(super) fn push(&mut self, point: DVec3) {
        let halves: [[u32; 3]; 2] = bytemuck::cast(point.to_array());
        self.halves.extend_from_slice(&halves);
    }

    pub(super) fn append(&mut self, other: &Points) {
        self.halves.extend_from_slice(&other.halves);
    }

    #[inline]
    fn get(&self, index: usize) -> DVec3 {
        let halves = [self.halves[2 * index], self.halves[2 * index + 1]];
        DVec3::from_array(bytemuck::cast(halves))
    }

    /// Replaces each; `false` at the first that `keeps` does not hold for.
    pub(super) fn map(&mut self, map: impl Fn(DVec3) -> DVec3, keeps: impl Fn(DVec3) -> bool) -> bool {
        (0..self.len()).all(|index| {
            let point = map(self.get(index));
            let halves: [[u32; 3]; 2] = bytemuck::cast(point.to_array());
            self.halves[2 * index..2 * index + 2].copy_from_slice(&halves);
            keeps(point)
        })
    }

    /// As [`Positions::from_f64`].
    pub(super) fn into_positions(mut self, decimals: u8) -> (Positions, bool) {
        let decimals = decimals.min(Positions::MAX_DECIMALS);
        let count = self.len();
        let (low, high) = (0..count)
            .map(|index| self.get(index))
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)));
        let centre = if count == 0 { DVec3::ZERO } else { (low + high) * 0.5 };
        let origin = (centre / 1024.0).round() * 1024.0;
        let reach = if count == 0 { 0.0 } else { (low - origin).abs().max((high - origin).abs()).max_element() };
        let steps = reach * 10f64.powi(i32::from(decimals));
        // Half a unit of the last written digit must survive rounding to nearest.
        let fits_f32 = steps < 2f64.powi(23);
        // Only a molecule spread over thousands of ångström about its origin can lose what f64 held.
        let half_unit = 0.5 * 10f64.powi(-i32::from(decimals));
        let mut lost = false;
        let mut fine = Vec::with_capacity(if fits_f32 { 0 } else { count });
        for index in 0..count {
            let point = self.get(index);
            let coarse = (point - origin).as_vec3();
            if !fits_f32 {
                let rest = point - origin - coarse.as_dvec3();
                let kept = origin + (coarse.as_dvec3() + rest);
                lost |= (kept - point).abs().max_element() >= half_unit;
                fine.push(rest);
            }
            // What stood here was read before.
            self.halves[index] = bytemuck::cast(coarse.to_array());
        }
        self.halves.truncate(count);
        self.halves.shrink_to_fit();
        let coarse: Vec<Vec3> = bytemuck::allocation::cast_vec(self.halves);
        (Positions { origin, coarse, fine, decimals }, lost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round_trip(text: &str, decimals: u8) -> String {
        let value: f64 = text.parse().unwrap();
        let (positions, lost) = Positions::from_f64(&[DVec3::new(value, 0.0, -value)], decimals);
        assert!(!lost);
        let back = positions.written(0);
        assert_eq!(back.x, -back.z);
        format!("{:.*}", usize::from(decimals), back.x)
    }

    #[test]
    fn written_digits_read_back_equal() {
        for (text, decimals) in [
            ("1.234", 3),
            ("-999.999", 3),
            ("9999.999", 3),
            ("123456.789", 3),
            ("0.1234567891", 10),
            ("-12.34567891234", 11),
            ("4095.999", 3),
            ("0.000", 3),
        ] {
            assert_eq!(round_trip(text, decimals), text);
        }
    }

    #[test]
    fn sixteen_digits_are_the_f64_that_was_read() {
        for text in ["1.613900000000000", "-0.762100000000000", "12.345678901234567", "0.1"] {
            let value: f64 = text.parse().unwrap();
            let (positions, lost) = Positions::from_f64(&[DVec3::splat(value)], 15);
            assert!(!lost);
            assert_eq!(positions.written(0).x, value, "{text}");
        }
    }

    #[test]
    fn digits_that_cannot_be_kept_are_reported() {
        // The origin is far from the first atom, whose last decimals f64 cannot hold beside it.
        let points = [DVec3::splat(0.123_456_789_012_34), DVec3::splat(2e9)];
        assert!(Positions::from_f64(&points, 14).1);
        assert!(!Positions::from_f64(&points[..1], 14).1);
    }

    #[test]
    fn only_long_numbers_pay_for_their_digits() {
        assert!(Positions::from_f64(&[DVec3::splat(12.345)], 3).0.fine.is_empty());
        assert!(!Positions::from_f64(&[DVec3::splat(12.345_678_9)], 7).0.fine.is_empty());
    }

    #[test]
    fn far_away_molecules_keep_their_shape() {
        let points = [DVec3::new(1e6, 2e6, -3e6), DVec3::new(1e6 + 1.5, 2e6, -3e6)];
        let (positions, _) = Positions::from_f64(&points, 3);
        assert_eq!(positions.relative()[1].x - positions.relative()[0].x, 1.5);
    }
}
