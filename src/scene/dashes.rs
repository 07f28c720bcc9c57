//! Bonds that are no shared electron pair, as rows of short cylinders: coordination, dative and hydrogen bonds.
//!
//! The first and the last dash start at the balls; all dashes and all gaps of a bond are equally long.

use super::instances::{Cap, CylinderInstance};
use crate::structure::BondKind;
use glam::Vec3;

/// Length of a dash and of a gap in radii of the stick, and their least in ångström. By eye: shorter dashes read as dots,
/// longer ones as sticks.
const DASH: (f32, f32) = (3.4, 0.15);
const GAP: (f32, f32) = (2.2, 0.1);

/// Whether a kind of bond is drawn as dashes.
pub(super) fn is_dashed(kind: BondKind) -> bool {
    kind != BondKind::Covalent
}

/// The dashes from one point to another. `template` gives radius, colours of the two halves, and id.
pub(super) fn dashes(from: Vec3, to: Vec3, template: CylinderInstance, mut push: impl FnMut(CylinderInstance)) {
    let length = from.distance(to);
    let radius = template.radius;
    let (dash, gap) = ((DASH.0 * radius).max(DASH.1), (GAP.0 * radius).max(GAP.1));
    if length.is_nan() || length < 1e-3 {
        return;
    }
    let count = ((length + gap) / (dash + gap)).round().clamp(1.0, 1000.0);
    let scale = length / (count * (dash + gap) - gap);
    let (dash, period) = (dash * scale, (dash + gap) * scale);
    let along = (to - from) / length;
    for number in 0..count as u32 {
        let start = number as f32 * period;
        let middle = start + 0.5 * dash - 0.5 * length;
        // The dash in the middle has both colours, the others that of their half.
        let (color_a, color_b) = match middle {
            m if m < -0.25 * dash => (template.color_a, template.color_a),
            m if m > 0.25 * dash => (template.color_b, template.color_b),
            _ => (template.color_a, template.color_b),
        };
        push(CylinderInstance {
            a: (from + along * start).to_array(),
            b: (from + along * (start + dash)).to_array(),
            color_a,
            color_b,
            caps: CylinderInstance::pack_caps(Cap::Flat, Cap::Flat),
            ..template
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(length: f32) -> Vec<CylinderInstance> {
        let template = CylinderInstance {
            radius: 0.065,
            color_a: crate::color::Srgb8::rgb(255, 0, 0),
            color_b: crate::color::Srgb8::rgb(0, 0, 255),
            id: 7,
            ..bytemuck::Zeroable::zeroed()
        };
        let mut row = Vec::new();
        dashes(Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0 + length, 3.0), template, |dash| row.push(dash));
        row
    }

    #[test]
    fn dashes_fill_the_bond_evenly_and_keep_its_colours() {
        for length in [0.1f32, 0.9, 2.0, 3.3] {
            let row = row(length);
            assert!((row[0].a[1] - 2.0).abs() < 1e-6 && (row[row.len() - 1].b[1] - 2.0 - length).abs() < 1e-5);
            let dash = row[0].b[1] - row[0].a[1];
            assert!(row.iter().all(|other| (other.b[1] - other.a[1] - dash).abs() < 1e-5 && other.id == 7));
            assert!(row.windows(2).all(|pair| pair[1].a[1] - pair[0].b[1] > 0.05), "{length}");
            if row.len() > 1 {
                assert_eq!((row[0].color_a, row[0].color_b), (row[0].color_a, row[0].color_a));
                assert_eq!(row[row.len() - 1].color_a, row[row.len() - 1].color_b);
            }
        }
        assert_eq!(row(2.0).len(), 6);
        assert!(row(0.0).is_empty() && row(f32::NAN).is_empty());
    }
}
