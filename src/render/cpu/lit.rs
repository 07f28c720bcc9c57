//! Pictures with light from afar: what samples show is kept until it is known what light reaches it.
//!
//! Some samples at a time of a picture, or of some tiles of a large one: their surfaces are found and kept, sixteen points in a packet; all points
//! of a sample ask its directions together ([`super::rays`]); then they are shaded. A point is kept in 30 bytes.

use super::lanes::{LANES, Pass};
use super::reach::{Answers, Lights, Packets, Points, Shadows};
use super::shade::{self, Kept, Packet};
use super::shader::Shader;
use super::simd::{Work, widest};
use super::source::Source;
use super::tiles::{Picture, TileSums};
use crate::math::Aabb;
use crate::scene::PixelGrid;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Samples of a pixel that are kept at a time, if there is the memory for so many: one pass over a tile. Chosen: of a picture of 1920 × 1080 four
/// take up to 249 MB.
pub(super) const MOST_SAMPLES: u32 = 4;

/// Whether there are so many bytes, with half as many for all else. Under a limit of the process' memory (`ulimit -v`, `ulimit -d`) it
/// may not be so; a system without limits gives what is never touched.
fn can_be_had(bytes: usize) -> bool {
    Vec::<u8>::new().try_reserve_exact(bytes.saturating_add(bytes / 2)).is_ok()
}

/// Points of a part at most: of a wide strip of a large picture some tiles are worked on at a time. Chosen: as many as 1920 × 1080.
const MOST_POINTS: usize = 1 << 21;

/// Samples of some tiles that are worked on at once.
pub(super) struct Part {
    pub(super) tiles: Range<usize>,
    pub(super) samples: Range<u32>,
}

/// The samples of a picture in parts; `points` are the pixels of each tile, if anything reaches into it.
pub(super) fn parts(points: &[usize], samples: u32) -> Vec<Part> {
    let (mut parts, mut start, mut count) = (Vec::new(), 0, 0);
    for (tile, &more) in points.iter().enumerate() {
        if count + more > MOST_POINTS && tile > start {
            parts.extend(of_samples(start..tile, count, samples));
            (start, count) = (tile, 0);
        }
        count += more;
    }
    parts.extend(of_samples(start..points.len(), count, samples));
    parts
}

/// Some tiles of so many points, as many samples at a time as can be kept.
fn of_samples(tiles: Range<usize>, points: usize, samples: u32) -> impl Iterator<Item = Part> {
    let part = MOST_SAMPLES as usize * points.div_ceil(LANES) * size_of::<Packet>();
    let part = if can_be_had(part) { MOST_SAMPLES } else { 1 };
    let samples = (0..samples).step_by(part as usize).map(move |start| start..samples.min(start + part));
    samples.map(move |samples| Part { tiles: tiles.clone(), samples })
}

/// The packets of a sample, tile by tile.
struct OfSample<'a> {
    tiles: Vec<&'a [Packet]>,
    /// How many there are.
    count: usize,
    shader: &'a Shader<'a>,
    grid: &'a PixelGrid,
    /// Around all points.
    bounds: Aabb,
}

impl Packets for OfSample<'_> {
    fn runs(&self) -> usize {
        self.tiles.len()
    }

    fn len_of(&self, run: usize) -> usize {
        self.tiles[run].len()
    }

    fn bounds(&self) -> Aabb {
        self.bounds
    }

    #[inline(always)]
    fn points(&self, run: usize, packet: usize) -> Points {
        self.tiles[run][packet].points(self.shader, self.grid)
    }
}

/// Adds a part of a picture of so many samples to the sums of its tiles, unless `stop` becomes true. `kept` is room to work in: what was there
/// before does not matter.
pub(super) fn add<S: Source>(
    picture: &Picture<'_, S>,
    (part, samples): (&Part, u32),
    (shadows, lights): (&Shadows<'_>, &Lights),
    (sums, kept): (&mut [TileSums], &mut Vec<Kept>),
    stop: &AtomicBool,
) {
    let passes = Pass::all(part.samples.clone(), samples);
    let sums = &mut sums[part.tiles.clone()];
    kept.resize_with(sums.len(), || Kept::of(Vec::new()));
    kept.par_iter_mut().zip(part.tiles.clone()).with_max_len(4).for_each(|(kept, tile)| {
        *kept = Kept::of(std::mem::take(&mut kept.packets));
        if !stop.load(Ordering::Relaxed) {
            picture.keep(tile, &passes, kept);
        }
    });
    let kept = &*kept;
    let bounds = kept.iter().fold(Aabb::EMPTY, |all, kept| all.union(kept.bounds()));
    let (shader, grid) = (&picture.shader, &picture.grid);
    let of_sample = |sample| (sample, OfSample { tiles: Vec::new(), count: 0, shader, grid, bounds });
    let mut of_samples: Vec<(u32, OfSample<'_>)> = part.samples.clone().map(of_sample).collect();
    // Where the packets of each tile start in each sample.
    let mut starts: Vec<Vec<usize>> = Vec::with_capacity(kept.len());
    for Kept { packets, samples, .. } in kept {
        starts.push(of_samples.iter().map(|(_, of)| of.count).collect());
        let mut start = 0;
        for &(sample, end) in samples {
            let (_, of) = &mut of_samples[(sample - part.samples.start) as usize];
            of.tiles.push(&packets[start..end]);
            of.count += end - start;
            start = end;
        }
    }
    if stop.load(Ordering::Relaxed) {
        return;
    }
    let answers = shadows.answers(lights, &of_samples, stop);
    let side = picture.tile as usize;
    let tiles = sums.par_iter_mut().zip(kept).zip(starts);
    tiles.with_max_len(4).for_each(|((sums, Kept { packets, .. }), starts)| {
        if !packets.is_empty() && !stop.load(Ordering::Relaxed) {
            sums.resize(4 * side * side, 0.0);
            let told = Told { answers: &answers, first_sample: part.samples.start, starts };
            widest(Light { shader, grid, packets, told, sums, width: side });
        }
    });
}

/// What the packets of a tile are told.
struct Told<'a> {
    /// Of each sample.
    answers: &'a [Answers],
    first_sample: u32,
    /// Where the next packet of each sample stands.
    starts: Vec<usize>,
}

/// The light of a tile's packets, as work for [`widest`].
struct Light<'a> {
    shader: &'a Shader<'a>,
    grid: &'a PixelGrid,
    packets: &'a [Packet],
    told: Told<'a>,
    sums: &'a mut [f32],
    width: usize,
}

impl Work for Light<'_> {
    #[inline(always)]
    fn run(self) {
        let Light { shader, grid, packets, mut told, sums, width } = self;
        let unasked = shader.frame.unasked();
        for packet in packets {
            let place = (packet.sample - told.first_sample) as usize;
            let mut points = packet.points(shader, grid);
            told.answers[place].tell(told.starts[place], &mut points, unasked);
            told.starts[place] += 1;
            shade::add_packet((shader, grid), packet, &points, (sums, width));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_every_sample_of_every_tile_once_and_not_too_many_points() {
        let large = vec![64 * 64; 1600];
        let some_empty = (0..2000).map(|tile| if tile % 3 == 0 { 0 } else { 64 * 64 }).collect();
        for (points, samples) in
            [(large, 16), (some_empty, 37), (vec![4096; 7], 1), (vec![MOST_POINTS * 2; 3], 5), (vec![], 16)]
        {
            let mut seen = vec![0; points.len() * samples as usize];
            for Part { tiles, samples: some } in parts(&points, samples) {
                let count: usize = points[tiles.clone()].iter().sum();
                assert!(count <= MOST_POINTS || tiles.len() == 1, "{count} points");
                assert!(some.len() <= MOST_SAMPLES as usize);
                for (tile, sample) in tiles.flat_map(|tile| some.clone().map(move |sample| (tile, sample))) {
                    seen[tile * samples as usize + sample as usize] += 1;
                }
            }
            assert!(seen.iter().all(|&times| times == 1), "{} tiles, {samples} samples", points.len());
        }
    }
}
