//! Light from afar for sixteen points at a time, of scenes whose primitives stay in the caches: what stands between a point and the light is asked
//! as soon as the point is found ([`super::casters`]). Of larger scenes all points ask together ([`super::lit`]).

use super::behind::{Mask, behind};
use super::bodies::{Axes, Body, InView};
use super::casters::Sight;
use super::lanes::{LANES, Lanes, bits};
use super::reach::{Lights, Points, facing, share};
use crate::math::{max, min, whole};
use crate::render::settings::View;
use crate::render::sky::{Reach, Turns};
use crate::render::solids::Solids;
use crate::render::tubes::width_of;
use crate::scene::Scene;
use rayon::prelude::*;
use std::ops::Range;

/// Scenes with no more primitives ask so. Measured on proteins, on two cores: with 2,000 and 20,000 primitives a still takes a quarter and a tenth
/// less than when points ask together, with 200,000 a half more.
pub(super) const MOST_PRIMITIVES: usize = 50_000;

/// Scenes of which more than this share are neither balls nor sticks, or see-through, ask so, too. Chosen; measured: 54,000 triangles take 1.0 s so,
/// 4.5 s when points ask together.
pub(super) const MOST_OTHERS: f32 = 0.25;

/// Bytes of what directions show that are kept at once. Measured on a protein of 10,000 atoms with 32 MB of cache on two cores: 24 MB take a tenth
/// less than everything at once (77 MB), 6 MB as much.
const MOST_BYTES: usize = 24 << 20;

/// What may hide the light in a view, one by one.
pub(super) struct Asking {
    /// In view space.
    solids: Solids,
    bodies: Vec<Body>,
    in_view: InView,
    /// Of the tubes, ångström.
    width: f32,
}

/// A direction that was looked along.
struct Along {
    axes: Axes,
    sight: Sight,
}

/// A light, and what its directions show, of those that some samples ask.
struct Seen<'a> {
    turns: &'a Turns,
    along: Vec<Option<Along>>,
}

impl Seen<'_> {
    /// The directions of a sample.
    #[inline(always)]
    fn of_sample(&self, sample: u32) -> impl Iterator<Item = &Along> {
        let start = self.turns.start(sample) as usize;
        self.along[start..start + self.turns.each as usize].iter().flatten()
    }
}

/// What some samples of a view ask.
pub(super) struct Questions<'a> {
    asking: &'a Asking,
    sky: Seen<'a>,
    key: Seen<'a>,
    /// Samples of a pixel.
    samples: u32,
}

impl Asking {
    /// Of all primitives of a scene.
    pub(super) fn new(scene: &Scene, view: &View) -> Asking {
        let in_view = InView::new(scene, view);
        let solids = Solids::new(scene, in_view.view_from_world);
        Asking { bodies: Body::all(&solids), in_view, width: width_of(&solids), solids }
    }

    /// The samples of a picture in parts whose directions are looked along at once.
    pub(super) fn parts(&self, lights: &Lights, samples: u32) -> Vec<Range<u32>> {
        let bytes = Sight::bytes(self.bodies.len());
        let [all, one] = [
            lights.directions().map(|turns| turns.directions.len()),
            lights.directions().map(|turns| turns.each as usize),
        ]
        .map(|[sky, key]| (sky + key) * bytes);
        let part = [16, 4].into_iter().find(|&part| part as usize * one <= MOST_BYTES).unwrap_or(1);
        let part = if all <= MOST_BYTES { samples } else { part };
        (0..samples).step_by(part.max(1) as usize).map(|start| start..samples.min(start + part)).collect()
    }

    /// Looks along the directions that these samples ask and no others.
    pub(super) fn look<'a>(&'a self, lights: &'a Lights, samples: &Range<u32>) -> Questions<'a> {
        let [sky, key] = lights.directions().map(|turns| {
            let starts: Vec<usize> = samples.clone().map(|sample| turns.start(sample) as usize).collect();
            let is_asked = |at: usize| starts.iter().any(|&start| (start..start + turns.each as usize).contains(&at));
            let look = |at: usize| {
                (is_asked(at) && !self.bodies.is_empty()).then(|| {
                    let axes = self.in_view.axes(turns.directions[at]);
                    Along { axes, sight: Sight::new(&self.bodies, &self.solids, &axes, self.width) }
                })
            };
            Seen { turns, along: (0..turns.directions.len()).into_par_iter().with_max_len(1).map(look).collect() }
        });
        Questions { asking: self, sky, key, samples: lights.samples() }
    }
}

impl Questions<'_> {
    /// Tells points how much of the sky and of the key light they see, as far as this sample of their pixels asks; `unasked`
    /// where nothing is asked, or all of it is behind the surface.
    #[inline(always)]
    pub(super) fn ask(&self, points: &mut Points, sample: u32, unasked: Reach) {
        for (kind, light, unasked) in [(0, &self.sky, unasked.open), (1, &self.key, unasked.key)] {
            let (mut seen, mut all) = ([0.0f32; LANES], [0.0f32; LANES]);
            for along in light.of_sample(sample) {
                self.ask_one(along, [u32::from(kind == 0), sample], points, (&mut seen, &mut all));
            }
            points.told[kind] = share(&seen, &all, unasked);
        }
    }

    /// Asks one direction: adds its weight to `all`, and to `seen` where it is free.
    #[inline(always)]
    fn ask_one(
        &self,
        Along { axes, sight }: &Along,
        [is_weighted, sample]: [u32; 2],
        points: &Points,
        (seen, all): (&mut Lanes, &mut Lanes),
    ) {
        let tubes = &sight.tubes;
        let most = [(tubes.size[0] - 1) as f32, (tubes.size[1] - 1) as f32];
        let (facing, asks) = facing(points, axes.toward);
        let mut left = bits(|lane| asks[lane] != 0);
        let mut weight = [1.0; LANES];
        if is_weighted != 0 {
            weight = facing;
        }
        for lane in 0..LANES {
            all[lane] += weight[lane];
        }
        if left == 0 {
            return;
        }
        let (at, mut tube) = (axes.places(&points.position), [0u32; LANES]);
        for (lane, tube) in tube.iter_mut().enumerate() {
            let column = (at.x[lane] - tubes.corner[0]) * tubes.per_angstrom;
            let row = (at.y[lane] - tubes.corner[1]) * tubes.per_angstrom;
            let (column, row) = (min(max(column.floor(), 0.0), most[0]), min(max(row.floor(), 0.0), most[1]));
            *tube = whole(row) * tubes.size[0] + whole(column);
        }
        let exactly = |index: u32, free: &mut u32| {
            if self.asking.solids.hides(index as usize, sample, self.samples) {
                let mut lanes: Mask = std::array::from_fn(|lane| if *free >> lane & 1 != 0 { u32::MAX } else { 0 });
                behind(&self.asking.solids, index, axes.toward, &points.position, &mut lanes);
                *free = bits(|lane| lanes[lane] != 0);
            }
        };
        // The lanes of one tube at a time; neighbouring pixels mostly share one.
        let mut sees = 0;
        while left != 0 {
            let first = tube[left.trailing_zeros() as usize % LANES];
            let mut here = bits(|lane| tube[lane] == first) & left;
            left &= !here;
            sight.walk(first, &at, &mut here, exactly);
            sees |= here;
        }
        for lane in 0..LANES {
            seen[lane] += if sees >> lane & 1 != 0 { weight[lane] } else { 0.0 };
        }
    }
}
