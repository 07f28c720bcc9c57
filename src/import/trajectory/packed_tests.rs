//! What is packed is unpacked: a packer of our own that makes use of everything the format allows, by chance.

use super::*;
use proptest::prelude::*;

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    bits: usize,
}

impl Writer {
    fn put(&mut self, value: u128, bits: u32) {
        for bit in (0..bits).rev() {
            if self.bits.is_multiple_of(8) {
                self.bytes.push(0);
            }
            let last = self.bytes.len() - 1;
            self.bytes[last] |= ((value >> bit & 1) as u8) << (7 - self.bits % 8);
            self.bits += 1;
        }
    }

    /// Lowest byte first, the rest of a byte last.
    fn put_triple(&mut self, triple: [u32; 3], sizes: [u32; 3], bits: u32) {
        let all =
            triple.iter().zip(sizes).fold(0u128, |all, (&number, size)| all * u128::from(size) + u128::from(number));
        for byte in 0..bits / 8 {
            self.put(all >> (8 * byte) & 0xff, 8);
        }
        self.put(all >> (bits / 8 * 8), bits % 8);
    }
}

/// Packs integers; `choices` decide where groups end and how ranges change.
fn pack(points: &[[i32; 3]], mut index: usize, choices: &[u8]) -> ([u8; 32], Vec<u8>) {
    let least: [i32; 3] = std::array::from_fn(|axis| points.iter().map(|p| p[axis]).min().unwrap());
    let greatest: [i32; 3] = std::array::from_fn(|axis| points.iter().map(|p| p[axis]).max().unwrap());
    let sizes: [u32; 3] = std::array::from_fn(|axis| (i64::from(greatest[axis]) - i64::from(least[axis]) + 1) as u32);
    let is_wide = sizes.iter().any(|&size| size > 0xff_ffff);
    let product: u128 = sizes.iter().map(|&size| u128::from(size)).product();
    let mut head = [0; 32];
    head[..4].copy_from_slice(&1000f32.to_be_bytes());
    for axis in 0..3 {
        head[4 + 4 * axis..8 + 4 * axis].copy_from_slice(&least[axis].to_be_bytes());
        head[16 + 4 * axis..20 + 4 * axis].copy_from_slice(&greatest[axis].to_be_bytes());
    }
    head[28..].copy_from_slice(&(index as u32).to_be_bytes());
    let mut writer = Writer::default();
    let (mut at, mut run) = (0, 0);
    let mut choice = choices.iter().copied().cycle();
    let mut choose = |below: usize| usize::from(choice.next().unwrap()) % below;
    while at < points.len() {
        // The list has the first small one before the whole one.
        let near = |from: [i32; 3], to: [i32; 3]| {
            let half = i64::from(SMALL[index] / 2);
            (0..3).all(|axis| {
                let away = i64::from(to[axis]) - i64::from(from[axis]) + half;
                (0..i64::from(SMALL[index])).contains(&away)
            })
        };
        let mut wanted = choose(10).min(points.len() - at - 1);
        let order = |count: usize| -> Vec<[i32; 3]> {
            let mut order: Vec<[i32; 3]> = points[at..=at + count].to_vec();
            if count > 0 {
                order.swap(0, 1);
            }
            order
        };
        while wanted > 0 && !order(wanted).windows(2).all(|pair| near(pair[0], pair[1])) {
            wanted -= 1;
        }
        let group = order(wanted);
        let stored: [u32; 3] = std::array::from_fn(|axis| (i64::from(group[0][axis]) - i64::from(least[axis])) as u32);
        if is_wide {
            (0..3).for_each(|axis| writer.put(stored[axis].into(), bit_length(sizes[axis])));
        } else {
            writer.put_triple(stored, sizes, 128 - product.leading_zeros());
        }
        let change = match choose(3) {
            0 if index > FIRST => 0,
            2 if index + 1 < SMALL.len() => 2,
            _ => 1,
        };
        if change == 1 && wanted == run {
            writer.put(0, 1);
        } else {
            writer.put(1, 1);
            writer.put((wanted * 3 + change) as u128, 5);
            run = wanted;
        }
        for pair in group.windows(2) {
            let half = i64::from(SMALL[index] / 2);
            let away = |axis: usize| (i64::from(pair[1][axis]) - i64::from(pair[0][axis]) + half) as u32;
            writer.put_triple(std::array::from_fn(away), [SMALL[index]; 3], index as u32);
        }
        at += wanted + 1;
        index = index + change - 1;
    }
    writer.bytes.resize(writer.bytes.len() + PADDING, 0);
    (head, writer.bytes)
}

fn points(most: i32) -> impl Strategy<Value = Vec<[i32; 3]>> {
    // Walks, so that some follow closely.
    let step = prop_oneof![8 => -30..30i32, 1 => -most..most];
    prop::collection::vec([step.clone(), step.clone(), step], 1..120).prop_map(move |steps| {
        let mut at = [0i32; 3];
        let walk = |step: [i32; 3]| {
            at = std::array::from_fn(|axis| (at[axis] + step[axis]).clamp(-most, most));
            at
        };
        steps.into_iter().map(walk).collect()
    })
}

proptest! {
    #[test]
    fn what_is_packed_is_unpacked(
        points in prop_oneof![points(1000), points(2_000_000), points(1_000_000_000)],
        index in FIRST..SMALL.len(),
        choices in prop::collection::vec(any::<u8>(), 1..40),
    ) {
        let (head, packed) = pack(&points, index, &choices);
        let (got, decimals) = unpack(&head, &packed, points.len(), 10.0).unwrap();
        prop_assert_eq!(decimals, 2);
        prop_assert_eq!(got.len(), points.len());
        for (got, want) in got.iter().zip(&points) {
            let want = Vec3::from(want.map(|number| (f64::from(number) * 0.01) as f32));
            prop_assert_eq!(*got, want);
        }
    }

    #[test]
    fn nothing_that_is_packed_wrong_panics(
        head in prop::array::uniform32(any::<u8>()),
        index in 0u8..80,
        mut packed in prop::collection::vec(any::<u8>(), 0..200),
        atoms in 0usize..2000,
        calm in any::<bool>(),
    ) {
        let mut head = head;
        head[..4].copy_from_slice(&1000f32.to_be_bytes());
        head[28..].copy_from_slice(&u32::from(index).to_be_bytes());
        if calm {
            // Ranges that are none too often would hide what comes behind them.
            head[4..16].fill(0);
            (0..3).for_each(|axis| head[16 + 4 * axis] = 0);
        }
        packed.resize(packed.len() + PADDING, 0);
        if let Ok((points, _)) = unpack(&head, &packed, atoms, 10.0) {
            prop_assert_eq!(points.len(), atoms);
        }
    }
}

#[test]
fn sizes_of_triples_are_their_bits() {
    for (bits, &size) in SMALL.iter().enumerate().skip(FIRST) {
        let product = u128::from(size).pow(3) - 1;
        assert!(128 - product.leading_zeros() <= bits as u32, "{bits}");
    }
}
