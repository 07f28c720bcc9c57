//! From what the samples of a tile see to light: the vector twin of [`super::shader::Shader`].
//!
//! A vector holds 4 × 4 pixels, one sample of each: they ask the same directions of the sky.
//!
//! The primitives' facts are gathered lane by lane, everything after that is the same for balls and sticks: a ball is a
//! stick whose axis has no length. The normal comes from the hit's place, not from solving again, so that it is off by
//! the rounding of the depth: 1e-4 of a stick's radius at 100 Å, less than a colour can show.

use super::lanes::{LANES, Lanes};
use super::reach::{NOBODY, Points, Questions};
use super::shader::Shader;
use super::tile::{Place, SIDE, Tile};
use crate::math::{max, min};
use crate::render::frame::{self, shade_outline, shade_surfaces};
use crate::render::outline::RIM;
use crate::render::sky::start_offset;
use crate::render::solids::Primitive;
use crate::scene::PixelGrid;
use glam::Vec3;

/// Facts of the primitives that the lanes of a block see.
struct Facts {
    center: [Lanes; 3],
    /// Unit axis; zero for a ball.
    axis: [Lanes; 3],
    radius: Lanes,
    /// Where flat caps are along the axis; infinite where there are none.
    caps: [Lanes; 2],
    /// Where the axis ends for the normal: at the ends of a round stick; infinite at others.
    ends: [Lanes; 2],
    /// Linear colour of the halves.
    colors: [[Lanes; 3]; 2],
}

impl Facts {
    fn new() -> Facts {
        Facts {
            center: [[0.0; LANES]; 3],
            axis: [[0.0; LANES]; 3],
            radius: [1.0; LANES],
            caps: [[f32::NEG_INFINITY; LANES], [f32::INFINITY; LANES]],
            ends: [[f32::NEG_INFINITY; LANES], [f32::INFINITY; LANES]],
            colors: [[[0.0; LANES]; 3]; 2],
        }
    }

    /// Puts a primitive into one lane.
    #[inline(always)]
    fn set(&mut self, lane: usize, of: &Fact) {
        for part in 0..3 {
            self.center[part][lane] = of.center[part];
            self.axis[part][lane] = of.axis[part];
            self.colors[0][part][lane] = of.colors[0][part];
            self.colors[1][part][lane] = of.colors[1][part];
        }
        for end in 0..2 {
            self.caps[end][lane] = of.caps[end];
            self.ends[end][lane] = of.ends[end];
        }
        self.radius[lane] = of.radius;
    }

    /// One primitive in all lanes.
    #[inline(always)]
    fn all(of: &Fact) -> Facts {
        let three = |v: [f32; 3]| v.map(|x| [x; LANES]);
        Facts {
            center: three(of.center),
            axis: three(of.axis),
            radius: [of.radius; LANES],
            caps: of.caps.map(|x| [x; LANES]),
            ends: of.ends.map(|x| [x; LANES]),
            colors: of.colors.map(three),
        }
    }
}

/// Facts of one primitive.
struct Fact {
    center: [f32; 3],
    axis: [f32; 3],
    radius: f32,
    caps: [f32; 2],
    ends: [f32; 2],
    colors: [[f32; 3]; 2],
}

impl Fact {
    #[inline(always)]
    fn of(shader: &Shader<'_>, index: u32) -> Fact {
        let solids = shader.solids;
        let index = index as usize;
        let none = [f32::NEG_INFINITY, f32::INFINITY];
        match solids.primitive(index) {
            Primitive::Sphere(i) => {
                let sphere = &solids.spheres[i];
                let color = solids.sphere_looks[i].0.to_linear();
                let (center, radius) = (sphere.center.to_array(), sphere.radius);
                Fact { center, axis: [0.0; 3], radius, caps: none, ends: none, colors: [color, color] }
            }
            Primitive::Cylinder(i) => {
                let cylinder = &solids.cylinders[i];
                let (a, b, _) = solids.cylinder_looks[i];
                let h = cylinder.half_length;
                let end = |kind: u32| {
                    let at = |cap: u32| if cap & 3 == kind { h } else { f32::INFINITY };
                    [-at(cylinder.caps), at(cylinder.caps >> 2)]
                };
                Fact {
                    center: cylinder.center.to_array(),
                    axis: cylinder.axis().to_array(),
                    radius: cylinder.radius,
                    caps: end(1),
                    ends: end(2),
                    colors: [a.to_linear(), b.to_linear()],
                }
            }
            // Found one by one: see `others`.
            _ => Fact { center: [0.0; 3], axis: [0.0; 3], radius: 1.0, caps: none, ends: none, colors: [[0.0; 3]; 2] },
        }
    }
}

/// Pixels on a side of what is worked on together.
pub(super) const GROUP: usize = 4;

/// One sample of each pixel of a group.
struct Samples {
    u: Lanes,
    v: Lanes,
    t: Lanes,
    index: [u32; LANES],
    /// Which of them see a primitive.
    seen: [bool; LANES],
}

/// The surfaces that a group of pixels shows in one sample.
pub(super) struct Surfaces {
    samples: Samples,
    albedo: [Lanes; 3],
}

/// Adds the light of a tile to its sums (planes of [`super::backdrop::Sums`], rows of `width` pixels): sample by sample, as all
/// pixels ask the same directions in one sample.
#[inline(always)]
pub(super) fn add(
    shader: &Shader<'_>,
    questions: &Questions<'_>,
    place: &Place<'_>,
    tile: &Tile,
    (sums, width): (&mut [f32], usize),
) {
    let blocks = GROUP / place.pass.side as usize;
    for sample in 0..place.pass.per_pixel() {
        let (number, unasked) = (place.pass.sample[sample], shader.frame.unasked());
        for row in 0..width / GROUP {
            for column in 0..width / GROUP {
                let columns = column * blocks..(column + 1) * blocks;
                let touched = &tile.touched[row * blocks..(row + 1) * blocks];
                if !touched.iter().any(|row| row[columns.clone()].contains(&true)) {
                    continue;
                }
                let samples = gather(shader, place, tile, sample, [row, column]);
                if !samples.seen.contains(&true) {
                    continue;
                }
                let (surfaces, mut points) = surfaces(shader, place, samples);
                questions.ask(&mut points, number, unasked);
                let light = light(shader, place.grid.orthographic, &surfaces, &points);
                let seen: Lanes = surfaces.samples.seen.map(|seen| if seen { 1.0 } else { 0.0 });
                for (plane, lanes) in [&light[0], &light[1], &light[2], &seen].into_iter().enumerate() {
                    for y in 0..GROUP {
                        let start = (plane * width + row * GROUP + y) * width + column * GROUP;
                        for (sum, lane) in sums[start..start + GROUP].iter_mut().zip(&lanes[y * GROUP..(y + 1) * GROUP])
                        {
                            *sum += lane;
                        }
                    }
                }
            }
        }
    }
}

/// One sample of each pixel of a group.
#[inline(always)]
fn gather(shader: &Shader<'_>, place: &Place<'_>, tile: &Tile, sample: usize, [row, column]: [usize; 2]) -> Samples {
    let blocks = GROUP / place.pass.side as usize;
    let mut samples = Samples {
        u: [0.0; LANES],
        v: [0.0; LANES],
        t: [f32::INFINITY; LANES],
        index: [0; LANES],
        seen: [false; LANES],
    };
    let (t, index) = (tile.t.as_flattened().as_flattened(), tile.index.as_flattened().as_flattened());
    let start = (row * blocks * SIDE + column * blocks) * LANES + sample;
    for lane in 0..LANES {
        let at = start + place.pass.group[lane];
        samples.t[lane] = t[at];
        samples.index[lane] = index[at];
    }
    // The first pixel's sample is as far from its corner as every other's.
    let (dx, dy) = (place.pass.x[sample], place.pass.y[sample]);
    let (left, top) = (place.corner[0] + (column * GROUP) as u32, place.corner[1] + (row * GROUP) as u32);
    let PixelGrid { center_px, plane_per_px, .. } = place.grid;
    for lane in 0..LANES {
        let (x, y) = ((left + (lane % GROUP) as u32) as f32 + dx, (top + (lane / GROUP) as u32) as f32 + dy);
        samples.u[lane] = (x - center_px[0]) * plane_per_px;
        samples.v[lane] = (center_px[1] - y) * plane_per_px;
    }
    let beyond = shader.ground_beyond(place.grid.orthographic, &samples.u, &samples.v);
    for (lane, ground) in beyond.into_iter().enumerate() {
        let t = samples.t[lane];
        samples.seen[lane] = (t < f32::INFINITY) & (t - shader.behind(samples.index[lane]) <= ground);
    }
    samples
}

/// The surfaces of samples.
#[inline(always)]
fn surfaces(shader: &Shader<'_>, place: &Place<'_>, samples: Samples) -> (Surfaces, Points) {
    let first = samples.index[0];
    let mut same = true;
    for lane in 0..LANES {
        same &= samples.seen[lane] & (samples.index[lane] == first);
    }
    let facts = if same {
        Facts::all(&Fact::of(shader, first & !RIM))
    } else {
        let mut facts = Facts::new();
        for lane in 0..LANES {
            if samples.seen[lane] {
                facts.set(lane, &Fact::of(shader, samples.index[lane] & !RIM));
            }
        }
        facts
    };
    let near = shader.frame.depth[2];
    let Samples { u, v, t, seen, .. } = &samples;
    // Rays start at (u, v, 0) and run along −z, or start at the eye and run along (u, v, −1).
    let (start, slope) = if place.grid.orthographic { (1.0, 0.0) } else { (0.0, 1.0) };
    let (mut points, mut albedo) = (Points::default(), [[0.0f32; LANES]; 3]);
    for lane in 0..LANES {
        let d = Vec3::new(u[lane] * slope, v[lane] * slope, -1.0);
        let depth = if seen[lane] { t[lane] } else { near };
        let hit = Vec3::new(u[lane] * start, v[lane] * start, 0.0) + d * depth;
        let p = hit - Vec3::new(facts.center[0][lane], facts.center[1][lane], facts.center[2][lane]);
        let axis = Vec3::new(facts.axis[0][lane], facts.axis[1][lane], facts.axis[2][lane]);
        let along = p.x * axis.x + p.y * axis.y + p.z * axis.z;
        let side = p - axis * along;
        let out = (side.x * side.x + side.y * side.y + side.z * side.z).sqrt();
        // The side or a cap, whichever is nearer to the hit.
        let off_side = (facts.radius[lane] - out).abs();
        let (off_a, off_b) = ((along - facts.caps[0][lane]).abs(), (along - facts.caps[1][lane]).abs());
        let round = p - axis * min(max(along, facts.ends[0][lane]), facts.ends[1][lane]);
        let is_round = facts.ends[0][lane] > f32::NEG_INFINITY || facts.ends[1][lane] < f32::INFINITY;
        let by_a = (off_a < off_side) & (off_a <= off_b);
        let by_b = (off_b < off_side) & !by_a;
        let cap = if by_a { -1.0 } else { 1.0 };
        let capped = by_a | by_b;
        let toward = -1.0 / (d.x * d.x + d.y * d.y + d.z * d.z).sqrt();
        let cut = depth <= near;
        let pick = |side: f32, round: f32, axis: f32, d: f32| {
            let n = if is_round { round } else { side };
            if cut {
                d * toward
            } else if capped {
                axis * cap
            } else {
                n
            }
        };
        let n = Vec3::new(
            pick(side.x, round.x, axis.x, d.x),
            pick(side.y, round.y, axis.y, d.y),
            pick(side.z, round.z, axis.z, d.z),
        );
        let over = 1.0 / max((n.x * n.x + n.y * n.y + n.z * n.z).sqrt(), 1e-20);
        // Seen from inside, an open cylinder shows its back.
        let n = n * if n.x * d.x + n.y * d.y + n.z * d.z > 0.0 { -over } else { over };
        let is_b = along > 0.0;
        for part in 0..3 {
            points.position[part][lane] = hit[part] + n[part] * start_offset(depth);
            points.normal[part][lane] = n[part];
            albedo[part][lane] = if is_b { facts.colors[1][part][lane] } else { facts.colors[0][part][lane] };
        }
        let is_line = samples.index[lane] & RIM != 0;
        points.asks[lane] = if seen[lane] & !cut & !is_line { 1.0 } else { 0.0 };
        points.own[lane] = if shader.solids.see_through { NOBODY } else { samples.index[lane] };
    }
    others(shader, place, &samples, &mut points, &mut albedo);
    (Surfaces { samples, albedo }, points)
}

/// Normals and colours of what is neither ball nor stick, one by one.
#[inline(always)]
fn others(shader: &Shader<'_>, place: &Place<'_>, samples: &Samples, points: &mut Points, albedo: &mut [Lanes; 3]) {
    let simple = (shader.solids.spheres.len() + shader.solids.cylinders.len()) as u32;
    for (lane, &index) in samples.index.iter().enumerate() {
        if index < simple || index & RIM != 0 || !samples.seen[lane] {
            continue;
        }
        let ray = place.grid.ray((samples.u[lane], samples.v[lane]));
        let surface = shader.surface(&ray, index, samples.t[lane]);
        let start = ray.origin + ray.direction * samples.t[lane] + surface.normal * start_offset(samples.t[lane]);
        for (part, albedo) in albedo.iter_mut().enumerate() {
            points.position[part][lane] = start[part];
            points.normal[part][lane] = surface.normal[part];
            albedo[lane] = surface.albedo[part];
        }
    }
}

/// The light of surfaces that were told what reaches them; black where there are none.
#[inline(always)]
fn light(shader: &Shader<'_>, parallel: bool, surfaces: &Surfaces, points: &Points) -> [Lanes; 3] {
    let Surfaces { samples, albedo, .. } = surfaces;
    let (unasked, slope) = (shader.frame.unasked(), if parallel { 0.0 } else { 1.0 });
    let (mut open, mut key, mut direction) = ([0.0f32; LANES], [0.0f32; LANES], [[0.0f32; LANES]; 2]);
    let mut seen = [0.0f32; LANES];
    for lane in 0..LANES {
        open[lane] = if points.asks[lane] > 0.0 { points.told[0][lane] } else { unasked.open };
        key[lane] = if points.asks[lane] > 0.0 { points.told[1][lane] } else { unasked.key };
        direction[0][lane] = samples.u[lane] * slope;
        direction[1][lane] = samples.v[lane] * slope;
        seen[lane] = if samples.seen[lane] { 1.0 } else { 0.0 };
    }
    let (depth, normal) = (&samples.t, &points.normal);
    let told = frame::Surfaces { depth, normal, albedo, open: &open, key: &key, direction: &direction };
    let mut light = shade_surfaces(shader.frame, &told);
    if shader.outlined.is_some() {
        for (lane, &index) in samples.index.iter().enumerate() {
            if index & RIM != 0 {
                let line = shade_outline(shader.frame, samples.t[lane]);
                light.iter_mut().zip(line.to_array()).for_each(|(part, line)| part[lane] = line);
            }
        }
    }
    for part in &mut light {
        for lane in 0..LANES {
            part[lane] = if seen[lane] > 0.0 { part[lane] } else { 0.0 };
        }
    }
    light
}
