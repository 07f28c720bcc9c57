//! Bond lengths of single, double and triple bonds of any two elements.
//!
//! Sums of covalent radii: Pyykkö and Atsumi, Chem. Eur. J. 2009, 15, 186 (single) and 12770 (double); Pyykkö, Riedel and
//! Patzschke, Chem. Eur. J. 2005, 11, 3511 (triple). They hold within 0.03 Å on average; conjugation and what the
//! neighbours do is for the model.

use crate::element::Element;

/// Radii in picometre for order 1, 2 and 3 by atomic number.
const RADII_PM: [(u8, [u8; 3]); 17] = [
    (5, [85, 78, 73]),
    (6, [75, 67, 60]),
    (7, [71, 60, 54]),
    (8, [63, 57, 53]),
    (9, [64, 59, 53]),
    (14, [116, 107, 102]),
    (15, [111, 102, 94]),
    (16, [103, 94, 95]),
    (17, [99, 95, 93]),
    (32, [121, 111, 114]),
    (33, [121, 114, 106]),
    (34, [116, 107, 107]),
    (35, [114, 109, 110]),
    (51, [140, 133, 127]),
    (52, [136, 128, 121]),
    (53, [133, 129, 125]),
    (54, [131, 135, 122]),
];

/// [`RADII_PM`] by atomic number, 0 for what is not in it.
const BY_Z: [[u8; 3]; 64] = {
    let mut by_z = [[0; 3]; 64];
    let mut row = 0;
    while row < RADII_PM.len() {
        by_z[RADII_PM[row].0 as usize] = RADII_PM[row].1;
        row += 1;
    }
    by_z
};

/// Expected length in ångström of a bond of order 1, 2 or 3.
pub(super) fn expected(a: Element, b: Element, order: usize) -> f32 {
    if a == Element::O && b == Element::O {
        // Lone pairs face each other: 1.46 Å in peroxides (Allen et al., J. Chem. Soc. Perkin Trans. 2 1987, S1), 1.21 Å
        // in O₂ (Huber and Herzberg 1979), where the radii give 1.26 and 1.14 Å.
        return if order == 1 { 1.46 } else { 1.21 };
    }
    let radius = |element: Element| match BY_Z.get(usize::from(element.z())) {
        Some(radii) if radii[0] > 0 => f32::from(radii[order.clamp(1, 3) - 1]) * 0.01,
        _ => element.covalent_radius(),
    };
    radius(a) + radius(b)
}

/// Spread of lengths about the expectation in ångström: what the radii leave open, and errors of positions.
const SPREAD: f32 = 0.07;
/// The most that a length speaks against an order: an impossible length is a wrong position, not a reason to break
/// valences.
const WORST: f32 = 6.0;

/// How much a length speaks against an order.
pub(super) fn penalty(a: Element, b: Element, order: usize, length: f32) -> f32 {
    let off = (length - expected(a, b, order)) / SPREAD;
    (0.5 * off * off).min(WORST)
}

/// Knots of the length dependence, from −0.38 Å about the single bond's length in steps of 0.04 Å.
const FIRST_KNOT: f32 = -0.38;
const KNOT_STEP: f32 = 0.04;
const LAST_KNOT: f32 = 13.0;

/// The two knots about a length (given as the excess over the single bond's) with their shares.
pub(super) fn knots(excess: f32) -> [(u8, f32); 2] {
    let at = ((excess - FIRST_KNOT) / KNOT_STEP).clamp(0.0, LAST_KNOT);
    let low = at.floor().min(LAST_KNOT - 1.0);
    [(low as u8, 1.0 - (at - low)), (low as u8 + 1, at - low)]
}
