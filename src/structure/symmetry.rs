//! Crystal symmetry: the operations of a space group as the file lists them.

use glam::{DMat3, DVec3};

/// The symmetry of a crystal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Symmetry {
    /// The symbol of the space group as the file writes it (`P 21/c`), empty if it gives none.
    pub space_group: String,
    /// All operations that the file lists, centring included; empty if it lists none.
    pub operations: Vec<SymmetryOperation>,
}

/// One operation, in fractional coordinates: `rotation · x + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SymmetryOperation {
    /// The linear part.
    pub rotation: DMat3,
    /// The translation, in cell vectors.
    pub translation: DVec3,
}

impl SymmetryOperation {
    /// Leaves everything in its place.
    pub const IDENTITY: SymmetryOperation = SymmetryOperation { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// From a triplet as CIF files write it; `None` for what is none, or has a linear part that is not invertible.
    ///
    /// ```
    /// use ballstick::structure::SymmetryOperation;
    /// use glam::DVec3;
    /// let screw = SymmetryOperation::from_triplet("-x, 1/2+y, 0.5-z").unwrap();
    /// assert_eq!(screw.apply(DVec3::new(0.1, 0.2, 0.3)), DVec3::new(-0.1, 0.7, 0.2));
    /// assert_eq!(SymmetryOperation::from_triplet("x, y"), None);
    /// ```
    #[must_use]
    pub fn from_triplet(text: &str) -> Option<SymmetryOperation> {
        let mut rows = [DVec3::ZERO; 3];
        let mut translation = DVec3::ZERO;
        let mut parts = text.split(',');
        for axis in 0..3 {
            (rows[axis], translation[axis]) = linear_form(parts.next()?)?;
        }
        let rotation = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        let whole = parts.next().is_none() && (rotation.determinant().abs() - 1.0).abs() < 1e-6;
        whole.then_some(SymmetryOperation { rotation, translation })
    }

    /// The image of a point in fractional coordinates.
    #[must_use]
    pub fn apply(&self, fractional: DVec3) -> DVec3 {
        self.rotation * fractional + self.translation
    }
}

/// One part of a triplet: coefficients of x, y, z and the constant.
fn linear_form(text: &str) -> Option<(DVec3, f64)> {
    let text: Vec<u8> = text.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
    let (mut coefficients, mut constant) = (DVec3::ZERO, 0.0);
    let mut at = 0;
    while at < text.len() {
        let mut sign = 1.0;
        while let Some(&byte @ (b'+' | b'-')) = text.get(at) {
            sign = if byte == b'-' { -sign } else { sign };
            at += 1;
        }
        let factor = number(&text, &mut at);
        if text.get(at) == Some(&b'*') {
            at += 1;
        }
        let axis = text.get(at).and_then(|byte| b"xyz".iter().position(|axis| *axis == byte.to_ascii_lowercase()));
        match axis {
            Some(axis) => {
                at += 1;
                coefficients[axis] += sign * factor.unwrap_or(1.0);
            }
            None => constant += sign * factor?,
        }
        if !matches!(text.get(at), None | Some(b'+' | b'-')) {
            return None;
        }
    }
    (!text.is_empty()).then_some((coefficients, constant))
}

/// A decimal number or a fraction of two.
fn number(text: &[u8], at: &mut usize) -> Option<f64> {
    let decimal = |at: &mut usize| {
        let start = *at;
        while text.get(*at).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.') {
            *at += 1;
        }
        std::str::from_utf8(&text[start..*at]).ok()?.parse::<f64>().ok()
    };
    let value = decimal(at)?;
    if text.get(*at) != Some(&b'/') {
        return Some(value);
    }
    *at += 1;
    decimal(at).filter(|&below| below != 0.0).map(|below| value / below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triplets_of_all_spellings_are_read() {
        let x = DVec3::new(0.1, 0.25, 0.4);
        for (text, image) in [
            ("x,y,z", x),
            ("X, Y, Z", x),
            ("+x,+y,+z", x),
            ("y,x-y,1/3+z", DVec3::new(0.25, -0.15, 0.4 + 1.0 / 3.0)),
            ("-x+.5,2/4-y,z-1", DVec3::new(0.4, 0.25, -0.6)),
        ] {
            let got = SymmetryOperation::from_triplet(text).unwrap().apply(x);
            assert!((got - image).length() < 1e-12, "{text}: {got}");
        }
    }

    #[test]
    fn what_is_no_operation_is_none() {
        for text in ["", "x,y", "x,y,z,x", "x,y,w", "x,x,z", "x,y,1/0", "x,y,z z2", "2x,y,z"] {
            assert_eq!(SymmetryOperation::from_triplet(text), None, "{text}");
        }
    }
}
