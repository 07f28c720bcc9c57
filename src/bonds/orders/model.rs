//! The weights of the features.

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
