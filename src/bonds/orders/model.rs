//! The weights of the features, from `weights.txt`.
//!
//! The numbers are those of a structured perceptron, fitted to the ideal coordinates of the wwPDB
//! Chemical Component Dictionary, which is in the public domain (CC0); how, the header of [`super`] says. They are bound
//! to the packing of facts in [`super::features`]: a change there needs a new fit.

use super::features::Weights;
use std::sync::LazyLock;

/// One line a feature: its number in hexadecimal and its weight in thousandths.
const TEXT: &str = include_str!("weights.txt");

/// Weights by feature, in a table that is full by half: open addressing.
pub(super) struct Model {
    slots: Vec<(u64, f32)>,
    mask: usize,
}

/// The model of this program.
pub(super) static MODEL: LazyLock<Model> = LazyLock::new(|| Model::read(TEXT));

/// No feature has this number: kinds start at 1.
const EMPTY: u64 = 0;

impl Model {
    fn read(text: &str) -> Model {
        let row = |line: &str| {
            let (feature, weight) = line.split_once(' ')?;
            Some((u64::from_str_radix(feature, 16).ok()?, weight.parse::<i16>().ok()?))
        };
        let rows: Vec<(u64, i16)> = text.lines().filter_map(row).collect();
        let size = (2 * rows.len()).next_power_of_two().max(2);
        let mut model = Model { slots: vec![(EMPTY, 0.0); size], mask: size - 1 };
        for (feature, weight) in rows {
            let mut at = model.start(feature);
            while model.slots[at].0 != EMPTY && model.slots[at].0 != feature {
                at = (at + 1) & model.mask;
            }
            model.slots[at] = (feature, f32::from(weight) * 1e-3);
        }
        model
    }

    fn start(&self, feature: u64) -> usize {
        let mixed = feature.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        ((mixed ^ mixed >> 32) as usize) & self.mask
    }
}

impl Weights for Model {
    fn weight(&self, feature: u64) -> f32 {
        let mut at = self.start(feature);
        loop {
            let (known, weight) = self.slots[at];
            if known == feature {
                return weight;
            }
            if known == EMPTY {
                return 0.0;
            }
            at = (at + 1) & self.mask;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_text_is_found_again_and_nothing_else() {
        let mut count = 0;
        for line in TEXT.lines() {
            let (feature, weight) = line.split_once(' ').unwrap();
            let feature = u64::from_str_radix(feature, 16).unwrap();
            assert_ne!(feature, EMPTY);
            assert_eq!(MODEL.weight(feature), weight.parse::<i16>().map(f32::from).unwrap() * 1e-3, "{line}");
            count += 1;
        }
        assert!(count > 1000);
        assert_eq!(MODEL.weight(u64::MAX), 0.0);
    }
}
