//! The soft edge around letters: their coverage, blurred. In whole numbers, so that a pixel has the same value whichever
//! part of the picture is drawn.

/// Times the box is run over the picture in each direction: three make a bell to within 3 %.
const PASSES: usize = 3;

/// A blur of a certain width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blur {
    /// Half-width of the box beyond its middle pixel in 1/256 pixels.
    reach: u64,
}

impl Blur {
    /// One with this standard deviation in pixels.
    pub(super) fn new(sigma_px: f64) -> Blur {
        // Variances of the passes add up. A box of the pixels −m to m has m (m + 1) / 3; the rest comes from the part of the
        // pixels m + 1 to either side that makes the variance right.
        let variance = sigma_px * sigma_px / PASSES as f64;
        let whole = ((0.25 + 3.0 * variance).sqrt() - 0.5).floor().max(0.0);
        let missing = (variance - whole * (whole + 1.0) / 3.0) * (2.0 * whole + 1.0);
        let part = missing / (2.0 * ((whole + 1.0) * (whole + 1.0) - variance));
        Blur { reach: ((whole + part) * 256.0).round() as u64 }
    }

    /// Pixels beyond which nothing is felt.
    pub(super) fn margin(self) -> i64 {
        PASSES as i64 * (self.reach / 256 + 1) as i64
    }

    /// Blurs rows of this width; what is outside is 0.
    pub(super) fn run(self, values: &mut [u16], width: usize) {
        if width == 0 || self.reach == 0 {
            return;
        }
        let height = values.len() / width;
        let mut sums = vec![0u64; width.max(height) + 1];
        for _ in 0..PASSES {
            for row in values.chunks_exact_mut(width) {
                self.line(row, 0, 1, width, &mut sums);
            }
            for column in 0..width {
                self.line(values, column, width, height, &mut sums);
            }
        }
    }

    /// One box over `count` values.
    fn line(self, values: &mut [u16], start: usize, step: usize, count: usize, sums: &mut [u64]) {
        let mut sum = 0u64;
        for i in 0..count {
            sum += u64::from(values[start + i * step]);
            sums[i + 1] = sum;
        }
        if sum == 0 {
            return;
        }
        let (whole, part) = ((self.reach / 256) as usize, self.reach % 256);
        let total = 2 * self.reach + 256;
        for i in 0..count {
            let (low, high) = (i.saturating_sub(whole), (i + whole + 1).min(count));
            let outer = |present: bool, at: usize| if present { sums[at + 1] - sums[at] } else { 0 };
            let left = outer(i > whole, i.wrapping_sub(whole + 1));
            let right = outer(i + whole + 1 < count, i + whole + 1);
            let inside = sums[high] - sums[low];
            values[start + i * step] = ((inside * 256 + (left + right) * part + total / 2) / total) as u16;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_becomes_a_bell_of_the_width_asked_for() {
        for sigma in [0.3, 0.8, 2.0, 5.5] {
            let blur = Blur::new(sigma);
            let side = 2 * blur.margin() as usize + 9;
            let mut values = vec![0; side * side];
            values[side / 2 * side + side / 2] = u16::MAX;
            blur.run(&mut values, side);
            let middle = (side / 2) as f64;
            let all: f64 = values.iter().map(|&v| f64::from(v)).sum();
            let of_row = |i: usize| (i % side) as f64 - middle;
            let variance: f64 =
                values.iter().enumerate().map(|(i, &v)| f64::from(v) * of_row(i).powi(2)).sum::<f64>() / all;
            assert!((variance.sqrt() / sigma - 1.0).abs() < 0.05, "{sigma}: {}", variance.sqrt());
            assert!((all / 65535.0 - 1.0).abs() < 0.05, "{sigma}: nothing is lost");
            assert!(values[..side * 4].iter().all(|&v| v == 0), "{sigma}: the margin holds it all");
        }
    }

    #[test]
    fn a_part_with_its_margin_blurs_as_the_whole() {
        let blur = Blur::new(1.7);
        let margin = blur.margin() as usize;
        let (width, height) = (60, 40);
        let whole: Vec<u16> = (0..width * height).map(|i| ((i * 7919) % 65536) as u16).collect();
        let (x, part_width) = (20 - margin, 15 + 2 * margin);
        let mut part: Vec<u16> = whole.chunks_exact(width).flat_map(|row| row[x..x + part_width].to_vec()).collect();
        let mut whole = whole;
        blur.run(&mut whole, width);
        blur.run(&mut part, part_width);
        for y in 0..height {
            assert_eq!(whole[y * width + 20..][..15], part[y * part_width + margin..][..15]);
        }
    }
}
