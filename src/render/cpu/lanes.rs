//! Sixteen samples that are worked on together, and how they lie in the picture.
//!
//! A block is one pixel with 16 samples, 2 × 2 pixels with 4, or 4 × 4 pixels with 1: a small primitive touches few
//! blocks whatever the number of samples. Loops over lanes are plain Rust that becomes vector code (see [`super::simd`]).

use super::tile::SIDE;
use crate::math::min;
use crate::render::settings::sample_offset;
use std::ops::Range;

/// Samples in a block: one vector register of AVX-512, two of AVX2.
pub(super) const LANES: usize = 16;

/// One number of each sample.
pub(super) type Lanes = [f32; LANES];

/// A bit for each lane.
#[inline(always)]
pub(super) fn bits(is_set: impl Fn(usize) -> bool) -> u32 {
    let mut bits = 0;
    for lane in 0..LANES {
        bits |= u32::from(is_set(lane)) << lane;
    }
    bits
}

/// The smallest of the lanes, by halves: one after the other would wait for each.
#[inline(always)]
pub(super) fn low_of(x: &Lanes) -> f32 {
    let mut x = *x;
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            x[lane] = min(x[lane], x[lane + half]);
        }
        half /= 2;
    }
    x[0]
}

/// One pass over the picture: which samples the lanes of a block are.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pass {
    /// Pixels on a side of a block: 1, 2 or 4.
    pub(super) side: u32,
    /// Place of each lane's sample from the block's upper left corner, pixels.
    pub(super) x: Lanes,
    pub(super) y: Lanes,
    /// Its number in the sequence of the pixel's samples.
    pub(super) sample: [u32; LANES],
    /// Samples of a pixel in all passes.
    pub(super) samples: u32,
    /// Of 4 × 4 neighbouring pixels: where in a tile's blocks (rows of [`super::tile::SIDE`], counted from that of the first
    /// pixel) the first sample of each stands, in samples.
    pub(super) group: [usize; LANES],
}

impl Pass {
    /// Samples of one pixel in a block; the lanes of a pixel are neighbours.
    pub(super) fn per_pixel(&self) -> usize {
        LANES / (self.side * self.side) as usize
    }

    /// Samples `first ..` of `samples`, as many as fit before `end`.
    fn new(first: u32, end: u32, samples: u32) -> Pass {
        let side = match end - first {
            16.. => 1,
            4.. => 2,
            _ => 4,
        };
        Pass::with_side(first, samples, side)
    }

    /// One sample of each pixel.
    pub(super) fn of_one(sample: u32, samples: u32) -> Pass {
        Pass::with_side(sample, samples, 4)
    }

    fn with_side(first: u32, samples: u32, side: u32) -> Pass {
        let per_pixel = LANES as u32 / (side * side);
        let group = std::array::from_fn(|pixel| {
            let (x, y) = (pixel as u32 % 4, pixel as u32 / 4);
            let block = (y / side) as usize * SIDE + (x / side) as usize;
            block * LANES + ((y % side * side + x % side) * per_pixel) as usize
        });
        let mut pass = Pass { side, x: [0.0; LANES], y: [0.0; LANES], sample: [0; LANES], samples, group };
        for lane in 0..LANES as u32 {
            let (pixel, sample) = (lane / per_pixel, first + lane % per_pixel);
            let [dx, dy] = sample_offset(sample, samples);
            let at = lane as usize;
            (pass.x[at], pass.y[at]) = ((pixel % side) as f32 + dx, (pixel / side) as f32 + dy);
            pass.sample[at] = sample;
        }
        pass
    }

    /// The passes for these of so many samples a pixel; the first has the smallest blocks.
    pub(super) fn all(of: Range<u32>, samples: u32) -> Vec<Pass> {
        let (mut passes, mut done) = (Vec::new(), of.start);
        while done < of.end {
            let pass = Pass::new(done, of.end, samples);
            done += pass.per_pixel() as u32;
            passes.push(pass);
        }
        passes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_take_every_sample_of_every_pixel_once() {
        for samples in [1, 2, 3, 4, 5, 9, 16, 20, 37, 64] {
            let mut seen = Vec::new();
            for pass in Pass::all(0..samples, samples) {
                assert_eq!(pass.per_pixel() * (pass.side * pass.side) as usize, LANES);
                for lane in 0..LANES {
                    let [dx, dy] = sample_offset(pass.sample[lane], samples);
                    let pixel = (pass.x[lane] - dx, pass.y[lane] - dy);
                    assert!(pixel.0.fract() == 0.0 && pixel.1.fract() == 0.0);
                    assert_eq!(pixel.1 as usize * pass.side as usize + pixel.0 as usize, lane / pass.per_pixel());
                }
                seen.extend(pass.sample[..pass.per_pixel()].iter().copied());
            }
            assert_eq!(seen, (0..samples).collect::<Vec<_>>());
        }
    }
}
