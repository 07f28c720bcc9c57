//! Atom positions: f32 about an f64 origin, with the digits that do not fit kept beside them.
//!
//! `position = origin + coarse + fine`. Drawing needs only `coarse`. `fine` is there only where the file's
//! digits do not fit 24 bits (quantum chemistry output with ten decimals, say): then coarse + fine are the f64 that was read, and
//! it can be written back digit for digit.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

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

    /// From positions in single precision about the file's own origin, and how many of their decimals mean something.
    #[must_use]
    pub fn from_relative(points: Vec<Vec3>, decimals: u8) -> Positions {
        Positions { origin: DVec3::ZERO, coarse: points, fine: Vec::new(), decimals: decimals.min(Self::MAX_DECIMALS) }
    }

    /// Moves an atom, if it is there.
    pub(crate) fn shift(&mut self, atom: usize, by: DVec3) {
        if let Some(coarse) = self.coarse.get_mut(atom) {
            let whole = coarse.as_dvec3() + by;
            *coarse = whole.as_vec3();
            if let Some(fine) = self.fine.get_mut(atom) {
                *fine += whole - coarse.as_dvec3();
            }
        }
    }

    /// Bytes set aside.
    pub(super) fn memory(&self) -> usize {
        self.coarse.capacity() * size_of::<Vec3>() + self.fine.capacity() * size_of::<DVec3>()
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
///
/// They lie in pieces, so that neither growing nor putting parts together moves any, and all cores share the rest.
#[derive(Debug, Default)]
pub(crate) struct Points {
    /// The pieces that are done.
    full: Vec<Piece>,
    /// The one that grows.
    open: Piece,
}

/// The bits of each position in two halves, so that either half has room for a position in f32.
type Piece = Vec<[u32; 3]>;

/// Positions of a piece (chosen: 1.5 MB, so that a million atoms are some for each core).
const PIECE: usize = 1 << 16;
/// Parts of fewer positions are copied, so that many small ones do not become many small pieces (chosen).
const SMALL: usize = 1 << 12;

#[inline]
fn halves(point: DVec3) -> [[u32; 3]; 2] {
    bytemuck::cast(point.to_array())
}

#[inline]
fn whole(halves: [[u32; 3]; 2]) -> DVec3 {
    DVec3::from_array(bytemuck::cast(halves))
}

impl Points {
    pub(super) fn reserve(&mut self, points: usize) {
        self.open.reserve(2 * points.min(PIECE));
    }

    #[inline]
    pub(super) fn push(&mut self, point: DVec3) {
        if self.open.len() >= 2 * PIECE {
            self.close();
        }
        self.open.extend_from_slice(&halves(point));
    }

    pub(super) fn extend(&mut self, mut points: &[DVec3]) {
        while !points.is_empty() {
            if self.open.len() >= 2 * PIECE {
                self.close();
            }
            let (now, later) = points.split_at(points.len().min(PIECE - self.open.len() / 2));
            self.open.extend_from_slice(bytemuck::cast_slice(now));
            points = later;
        }
    }

    #[cold]
    fn close(&mut self) {
        let next = Vec::with_capacity(2 * PIECE);
        self.full.push(std::mem::replace(&mut self.open, next));
    }

    pub(super) fn append(&mut self, mut other: Points) {
        if other.full.is_empty() && other.open.len() < 2 * SMALL && self.open.len() < 2 * PIECE {
            self.open.extend_from_slice(&other.open);
            return;
        }
        if !self.open.is_empty() {
            self.full.push(std::mem::take(&mut self.open));
        }
        self.full.append(&mut other.full);
        self.open = other.open;
    }

    /// So many positions, some at a time by all cores: `fill` is told the number of the first one and where to write them.
    /// `None` as soon as it returns `false`.
    pub(crate) fn filled(count: usize, fill: impl Fn(usize, &mut [DVec3]) -> bool + Sync) -> Option<Points> {
        let piece = |number: usize| {
            let from = number * PIECE;
            let to = count.min(from + PIECE);
            let mut piece = Vec::with_capacity(2 * (to - from));
            let mut some = [DVec3::ZERO; 256];
            for first in (from..to).step_by(some.len()) {
                let some = &mut some[..(to - first).min(256)];
                if !fill(first, some) {
                    return None;
                }
                some.iter().for_each(|&point| piece.extend_from_slice(&halves(point)));
            }
            Some(piece)
        };
        let full = (0..count.div_ceil(PIECE)).into_par_iter().map(piece).collect::<Option<_>>()?;
        Some(Points { full, open: Vec::new() })
    }

    /// Replaces each; `false` at the first that `keeps` does not hold for.
    pub(super) fn map(&mut self, map: impl Fn(DVec3) -> DVec3, keeps: impl Fn(DVec3) -> bool) -> bool {
        self.full.iter_mut().chain([&mut self.open]).flat_map(|piece| piece.as_chunks_mut().0).all(|both| {
            let point = map(whole(*both));
            *both = halves(point);
            keeps(point)
        })
    }

    /// As [`Positions::from_f64`].
    pub(super) fn into_positions(self, decimals: u8) -> (Positions, bool) {
        let decimals = decimals.min(Positions::MAX_DECIMALS);
        let Points { full: mut pieces, open } = self;
        pieces.push(open);
        let count = pieces.iter().map(Vec::len).sum::<usize>() / 2;
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let wider = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
        let bounds_of = |piece: &Piece| {
            piece.as_chunks().0.iter().map(|&both| whole(both)).fold(none, |all, point| wider(all, (point, point)))
        };
        let (low, high) = match pieces.as_slice() {
            [only] => bounds_of(only),
            pieces => pieces.par_iter().map(bounds_of).reduce(|| none, wider),
        };
        let centre = if count == 0 { DVec3::ZERO } else { (low + high) * 0.5 };
        let origin = (centre / 1024.0).round() * 1024.0;
        let reach = if count == 0 { 0.0 } else { (low - origin).abs().max((high - origin).abs()).max_element() };
        let steps = reach * 10f64.powi(i32::from(decimals));
        // Half a unit of the last written digit must survive rounding to nearest.
        let fits_f32 = steps < 2f64.powi(23);
        // Only a molecule spread over thousands of ångström about its origin can lose what f64 held.
        let half_unit = 0.5 * 10f64.powi(-i32::from(decimals));
        let narrow = |piece: Piece| narrowed(piece, origin, (!fits_f32).then_some(half_unit));
        // One piece, as of most molecules, wakes no other core.
        let mut narrow_pieces: Vec<Narrowed> = match pieces.len() {
            1 => pieces.into_iter().map(narrow).collect(),
            _ => pieces.into_par_iter().map(narrow).collect(),
        };
        let lost = narrow_pieces.iter().any(|piece| piece.lost);
        let fine: Vec<DVec3> = match narrow_pieces.as_mut_slice() {
            [only] => std::mem::take(&mut only.fine),
            pieces => pieces.iter_mut().flat_map(|piece| std::mem::take(&mut piece.fine)).collect(),
        };
        let coarse = joined(narrow_pieces.into_iter().map(|piece| piece.coarse).collect());
        (Positions { origin, coarse, fine, decimals }, lost)
    }
}

/// A piece about an origin.
struct Narrowed {
    coarse: Vec<Vec3>,
    fine: Vec<DVec3>,
    lost: bool,
}

/// A piece in f32, in its own memory; with `half_unit`, half of the last written digit's unit, what f32 does not hold beside it.
fn narrowed(mut piece: Piece, origin: DVec3, half_unit: Option<f64>) -> Narrowed {
    let count = piece.len() / 2;
    let mut lost = false;
    let mut fine = Vec::with_capacity(if half_unit.is_some() { count } else { 0 });
    for index in 0..count {
        let point = whole([piece[2 * index], piece[2 * index + 1]]);
        let coarse = (point - origin).as_vec3();
        if let Some(half_unit) = half_unit {
            let rest = point - origin - coarse.as_dvec3();
            let kept = origin + (coarse.as_dvec3() + rest);
            lost |= (kept - point).abs().max_element() >= half_unit;
            fine.push(rest);
        }
        // What stood here was read before.
        piece[index] = bytemuck::cast(coarse.to_array());
    }
    piece.truncate(count);
    piece.shrink_to_fit();
    Narrowed { coarse: bytemuck::allocation::cast_vec(piece), fine, lost }
}

/// Pieces one behind the other, put there by all cores; each is freed once it is copied.
pub(crate) fn joined<T: bytemuck::Pod + Send>(mut pieces: Vec<Vec<T>>) -> Vec<T> {
    if let [only] = pieces.as_mut_slice() {
        return std::mem::take(only);
    }
    let count = pieces.iter().map(Vec::len).sum();
    let mut all: Vec<T> = bytemuck::allocation::zeroed_vec(count);
    let mut rest = all.as_mut_slice();
    let mut places = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let Some((place, behind)) = std::mem::take(&mut rest).split_at_mut_checked(piece.len()) else { break };
        places.push((place, piece));
        rest = behind;
    }
    places.into_par_iter().for_each(|(place, piece)| place.copy_from_slice(&piece));
    all
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
    fn pieces_and_parts_are_the_whole() {
        let point =
            |n: usize| DVec3::new((n % 4000) as f64 * 0.25, -((n % 999) as f64), 0.123_456_789_01 * (n % 77) as f64);
        let points: Vec<DVec3> = (0..3 * PIECE + 5).map(point).collect();
        for decimals in [2, 11] {
            let whole = Positions::from_f64(&points, decimals);
            assert_eq!(whole.0.fine.is_empty(), decimals == 2);
            assert!((0..points.len()).step_by(997).all(|n| (whole.0.get(n) - points[n]).length() < 0.01));
            for cuts in [&[0, 1, 2 * SMALL][..], &[PIECE + 3, PIECE + 9], &[SMALL - 1, 2 * PIECE, 3 * PIECE + 4]] {
                let mut all = Points::default();
                let mut from = 0;
                for &to in cuts.iter().chain([&points.len()]) {
                    let mut part = Points::default();
                    if from == 0 {
                        points[from..to].iter().for_each(|&point| part.push(point));
                    } else {
                        points[from..to].chunks(1000).for_each(|some| part.extend(some));
                    }
                    all.append(part);
                    from = to;
                }
                assert!(all.into_positions(decimals) == whole, "{cuts:?}");
            }
            let fill = |first: usize, some: &mut [DVec3]| {
                some.iter_mut().enumerate().for_each(|(n, slot)| *slot = point(first + n));
                true
            };
            assert!(Points::filled(points.len(), fill).unwrap().into_positions(decimals) == whole);
        }
        assert!(Points::filled(3 * PIECE, |first, _| first < 2 * PIECE).is_none());
    }

    #[test]
    fn far_away_molecules_keep_their_shape() {
        let points = [DVec3::new(1e6, 2e6, -3e6), DVec3::new(1e6 + 1.5, 2e6, -3e6)];
        let (positions, _) = Positions::from_f64(&points, 3);
        assert_eq!(positions.relative()[1].x - positions.relative()[0].x, 1.5);
    }
}
