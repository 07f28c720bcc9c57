//! The packed positions of XTC frames.
//!
//! Positions are integers: nanometres times the precision, rounded. All lie between a least and a greatest triple. The first of
//! each group is stored whole, less the least; those that follow it closely (the atoms of a water, say) as differences within a
//! small range, of which there are 64 to choose from ([`SMALL`]). A triple of numbers below `s₀`, `s₁`, `s₂` is the one number
//! `(n₀ s₁ + n₁) s₂ + n₂`, in as many bits as `s₀ s₁ s₂` has, lowest byte first. A group is
//!
//! - the whole triple; where a range exceeds 24 bits, each number by itself;
//! - one bit; if it is set, five bits that say anew how many numbers (a multiple of three) of small triples follow and, by the
//!   remainder by three, whether the range of the next group is the next smaller (0), the same (1) or the next larger (2);
//! - the small triples. The first one stands before the whole triple in the list of atoms: oxygen, the middle of a water, is
//!   stored first that way.
//!
//! Bits are taken from the highest of each byte on.

use super::bytes::Numbers;
use crate::error::{Error, Result};
use glam::Vec3;

/// Zero bytes that must stand behind the packed ones, so that a load never ends outside.
pub(super) const PADDING: usize = 32;

/// The sizes of small ranges: the cube root of two to its index, so that an index is the number of bits of a triple.
const SMALL: [u32; 73] = [
    0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 10, 12, 16, 20, 25, 32, 40, 50, 64, 80, 101, 128, 161, 203, 256, 322, 406, 512, 645,
    812, 1024, 1290, 1625, 2048, 2580, 3250, 4096, 5060, 6501, 8192, 10321, 13003, 16384, 20642, 26007, 32768, 41285,
    52015, 65536, 82570, 104031, 131072, 165140, 208063, 262144, 330280, 416127, 524287, 660561, 832255, 1048576,
    1321122, 1664510, 2097152, 2642245, 3329021, 4194304, 5284491, 6658042, 8388607, 10568983, 13316085, 16777216,
];
/// The least index of a range that has a size.
const FIRST: usize = 9;

fn damaged(what: &str) -> Error {
    Error::input(None, format!("the packed positions are damaged: {what}"))
}

/// Bits of a byte string, highest first.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Bits<'_> {
    /// The bits from here on, 57 of them and more, at the top.
    #[inline]
    fn word(&self) -> u64 {
        let from = self.at >> 3;
        let word = self.bytes.get(from..from + 8).and_then(|part| part.first_chunk::<8>());
        word.map_or(0, |word| u64::from_be_bytes(*word)) << (self.at & 7)
    }

    /// The same, 121 of them and more.
    #[inline]
    fn double_word(&self) -> u128 {
        let from = self.at >> 3;
        let word = self.bytes.get(from..from + 16).and_then(|part| part.first_chunk::<16>());
        word.map_or(0, |word| u128::from_be_bytes(*word)) << (self.at & 7)
    }

    /// Up to 32 bits as a number.
    #[inline]
    fn take(&mut self, bits: u32) -> u32 {
        let word = self.word();
        self.at += bits as usize;
        if bits == 0 { 0 } else { (word >> (64 - bits)) as u32 }
    }

    /// A number of up to 56 bits, lowest byte first; a last part of a byte is its top.
    #[inline]
    fn take_swapped(&mut self, bits: u32) -> u64 {
        let word = self.word();
        self.at += bits as usize;
        let (whole, rest) = (bits & !7, bits & 7);
        let low = word.swap_bytes() & ((1 << whole) - 1);
        let high = if rest == 0 { 0 } else { (word << whole) >> (64 - rest) };
        low | high << whole
    }

    /// The same of up to 120 bits.
    #[inline]
    fn take_swapped_long(&mut self, bits: u32) -> u128 {
        let word = self.double_word();
        self.at += bits as usize;
        let (whole, rest) = (bits & !7, bits & 7);
        let low = word.swap_bytes() & ((1 << whole) - 1);
        let high = if rest == 0 { 0 } else { (word << whole) >> (128 - rest) };
        low | high << whole
    }

    /// Three numbers below `sizes` that are packed as one of this many bits.
    #[inline]
    fn triple(&mut self, bits: u32, [_, b, c]: [u32; 3]) -> [i32; 3] {
        if bits <= 32 {
            let all = self.take_swapped(bits) as u32;
            let rest = all / c;
            [(rest / b) as i32, (rest % b) as i32, (all % c) as i32]
        } else if bits <= 56 {
            let (all, b, c) = (self.take_swapped(bits), u64::from(b), u64::from(c));
            let rest = all / c;
            [(rest / b) as i32, (rest % b) as i32, (all % c) as i32]
        } else {
            let (all, b, c) = (self.take_swapped_long(bits), u128::from(b), u128::from(c));
            let rest = all / c;
            [(rest / b) as i32, (rest % b) as i32, (all % c) as i32]
        }
    }
}

/// How whole triples are stored.
enum Whole {
    /// As one number of so many bits.
    Together(u32),
    /// Each number with its own bits.
    Apart([u32; 3]),
}

fn bit_length(size: u32) -> u32 {
    32 - size.leading_zeros()
}

/// The positions of `atoms` atoms in ångström and their decimals. `head` is what stands before the length: precision, least and greatest
/// triple, index of the small range; `packed` has [`PADDING`] zero bytes behind it.
pub(super) fn unpack(head: &[u8; 32], packed: &[u8], atoms: usize, angstrom_per_unit: f64) -> Result<(Vec<Vec3>, u8)> {
    let numbers = Numbers { bytes: head, big_endian: true };
    let precision = f64::from(numbers.f32(0));
    if !(precision.is_finite() && precision > 0.0) {
        return Err(damaged("the precision is no number above 0"));
    }
    let least = [4, 8, 12].map(|at| numbers.i32(at));
    let greatest = [16, 20, 24].map(|at| numbers.i32(at));
    let mut sizes = [0u32; 3];
    for axis in 0..3 {
        let size = i64::from(greatest[axis]) - i64::from(least[axis]) + 1;
        sizes[axis] = u32::try_from(size).ok().filter(|&size| size > 0).ok_or_else(|| damaged("the range is none"))?;
    }
    let whole = if sizes.iter().any(|&size| size > 0xFF_FFFF) {
        Whole::Apart(sizes.map(bit_length))
    } else {
        let product = sizes.iter().fold(1u128, |all, &size| all * u128::from(size));
        Whole::Together(128 - product.leading_zeros())
    };
    let known = |index: i64| usize::try_from(index).ok().filter(|index| (FIRST..SMALL.len()).contains(index));
    let unknown = || damaged("the range of differences is unknown");
    let mut index = known(i64::from(numbers.i32(28))).ok_or_else(unknown)?;
    let data_bits = packed.len().saturating_sub(PADDING).saturating_mul(8);
    // An atom takes a bit at the least: nothing is set aside for more than there can be.
    if atoms > data_bits {
        return Err(damaged("there are fewer bytes than atoms need"));
    }
    let scale = angstrom_per_unit / precision;
    let to_point = |triple: [i32; 3]| Vec3::from(triple.map(|number| (f64::from(number) * scale) as f32));
    let add = |a: [i32; 3], b: [i32; 3]| std::array::from_fn(|axis| a[axis].wrapping_add(b[axis]));
    let mut points: Vec<Vec3> = Vec::with_capacity(atoms);
    let mut bits = Bits { bytes: packed, at: 0 };
    let mut run = 0;
    while points.len() < atoms {
        let stored = match whole {
            Whole::Together(count) => bits.triple(count, sizes),
            Whole::Apart(counts) => counts.map(|count| bits.take(count) as i32),
        };
        let first: [i32; 3] = add(stored, least);
        let mut change = 1;
        if bits.take(1) == 1 {
            let code = bits.take(5) as usize;
            (run, change) = (code / 3, code % 3);
        }
        if run > atoms - points.len() - 1 {
            return Err(damaged("more atoms are packed than the frame has"));
        }
        if run == 0 {
            points.push(to_point(first));
        } else {
            let size = SMALL[index];
            let middle = (size / 2) as i32;
            let mut last = first;
            for number in 0..run {
                let difference = bits.triple(index as u32, [size; 3]);
                let next = add(last, difference.map(|number| number.wrapping_sub(middle)));
                points.push(to_point(next));
                if number == 0 {
                    points.push(to_point(first));
                }
                last = next;
            }
        }
        if bits.at > data_bits {
            return Err(damaged("they end too early"));
        }
        index = known(index as i64 + change as i64 - 1).ok_or_else(unknown)?;
    }
    Ok((points, decimals_of(scale)))
}

/// Decimals of a step in ångström: two for 0.01.
fn decimals_of(step: f64) -> u8 {
    let decimals = (-step.log10() - 1e-6).ceil();
    if decimals.is_finite() { decimals.clamp(0.0, 12.0) as u8 } else { 0 }
}

#[cfg(test)]
#[path = "packed_tests.rs"]
mod tests;
