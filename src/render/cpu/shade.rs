//! From what the samples of a block see to light: the vector twin of [`super::shader::Shader`].
//!
//! The primitives' facts are gathered lane by lane, everything after that is the same for balls and sticks: a ball is a
//! stick whose axis has no length. The normal comes from the hit's place, not from solving again, so that it is off by
//! the rounding of the depth: 1e-4 of a stick's radius at 100 Å, less than a colour can show.

use super::lanes::{LANES, Lanes, max, min};
use super::maps::Points;
use super::reach::Questions;
use super::shader::Shader;
use super::tile::{Place, Tile, ray};
use crate::render::frame::{Surface, shade_surface};
use crate::render::sky::Reach;
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
        match index.checked_sub(solids.spheres.len()) {
            None => {
                let sphere = &solids.spheres[index];
                let color = solids.sphere_looks[index].0.to_linear();
                let (center, radius) = (sphere.center.to_array(), sphere.radius);
                Fact { center, axis: [0.0; 3], radius, caps: none, ends: none, colors: [color, color] }
            }
            Some(i) => {
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
        }
    }
}

/// Light of the samples of a block; `seen` says which of them see a primitive.
pub(super) struct Lit {
    pub(super) color: [Lanes; 3],
    pub(super) seen: [bool; LANES],
    pub(super) any: bool,
}

/// The light of a block.
#[inline(always)]
pub(super) fn light(
    shader: &Shader<'_>,
    questions: &Questions<'_>,
    place: &Place<'_>,
    tile: &Tile,
    [row, column]: [usize; 2],
) -> Lit {
    let (t, index) = (&tile.t[row][column], &tile.index[row][column]);
    let mut lit = Lit { color: [[0.0; LANES]; 3], seen: [false; LANES], any: false };
    let first = index[0];
    let (mut hits, mut same) = (0u32, 0u32);
    for lane in 0..LANES {
        hits += u32::from(t[lane] < f32::INFINITY);
        same += u32::from(index[lane] == first);
    }
    if hits == 0 {
        return lit;
    }
    let (u, v) = (place.u(column), place.v(row));
    let beyond = shader.ground_beyond(place.grid.orthographic, &u, &v);
    for lane in 0..LANES {
        lit.seen[lane] = (t[lane] < f32::INFINITY) & (t[lane] <= beyond[lane]);
        lit.any |= lit.seen[lane];
    }
    if !lit.any {
        return lit;
    }
    let facts = if hits as usize == LANES && same as usize == LANES {
        Facts::all(&Fact::of(shader, first))
    } else {
        let mut facts = Facts::new();
        for lane in 0..LANES {
            if lit.seen[lane] {
                facts.set(lane, &Fact::of(shader, index[lane]));
            }
        }
        facts
    };
    if place.grid.orthographic {
        finish::<true>(shader, questions, (&u, &v, t), &facts, &mut lit);
    } else {
        finish::<false>(shader, questions, (&u, &v, t), &facts, &mut lit);
    }
    lit
}

#[inline(always)]
fn finish<const PARALLEL: bool>(
    shader: &Shader<'_>,
    questions: &Questions<'_>,
    (u, v, t): (&Lanes, &Lanes, &Lanes),
    facts: &Facts,
    lit: &mut Lit,
) {
    let near = shader.frame.depth[2];
    let center = questions.center_in_view;
    let mut points = Points::default();
    let mut half = [0.0f32; LANES];
    for lane in 0..LANES {
        let ray = ray::<PARALLEL>(u[lane], v[lane]);
        let d = ray.direction;
        let depth = if lit.seen[lane] { t[lane] } else { near };
        let hit = ray.origin + d * depth;
        let p = hit - Vec3::new(facts.center[0][lane], facts.center[1][lane], facts.center[2][lane]);
        let axis = Vec3::new(facts.axis[0][lane], facts.axis[1][lane], facts.axis[2][lane]);
        let along = p.x * axis.x + p.y * axis.y + p.z * axis.z;
        half[lane] = along;
        let side = p - axis * along;
        let out = (side.x * side.x + side.y * side.y + side.z * side.z).sqrt();
        // The side or a cap, whichever is nearer to the hit.
        let off_side = (facts.radius[lane] - out).abs();
        let (off_a, off_b) = ((along - facts.caps[0][lane]).abs(), (along - facts.caps[1][lane]).abs());
        let round = p - axis * min(max(along, facts.ends[0][lane]), facts.ends[1][lane]);
        let is_round = facts.ends[0][lane] > f32::NEG_INFINITY || facts.ends[1][lane] < f32::INFINITY;
        let mut n = Vec3::new(
            if is_round { round.x } else { side.x },
            if is_round { round.y } else { side.y },
            if is_round { round.z } else { side.z },
        );
        let by_a = (off_a < off_side) & (off_a <= off_b);
        let by_b = (off_b < off_side) & !by_a;
        let cap = if by_a { -1.0 } else { 1.0 };
        let capped = by_a | by_b;
        let toward = -1.0 / (d.x * d.x + d.y * d.y + d.z * d.z).sqrt();
        let cut = depth <= near;
        let pick = |n: f32, axis: f32, d: f32| if cut { d * toward } else if capped { axis * cap } else { n };
        n = Vec3::new(pick(n.x, axis.x, d.x), pick(n.y, axis.y, d.y), pick(n.z, axis.z, d.z));
        let over = 1.0 / max((n.x * n.x + n.y * n.y + n.z * n.z).sqrt(), 1e-20);
        // Seen from inside, an open cylinder shows its back.
        let over = if n.x * d.x + n.y * d.y + n.z * d.z > 0.0 { -over } else { over };
        points.position[0][lane] = hit.x - center.x;
        points.position[1][lane] = hit.y - center.y;
        points.position[2][lane] = hit.z - center.z;
        points.normal[0][lane] = n.x * over;
        points.normal[1][lane] = n.y * over;
        points.normal[2][lane] = n.z * over;
    }
    let unasked = shader.frame.unasked();
    let [open, key] = questions.ask(&points, unasked);
    for lane in 0..LANES {
        let ray = ray::<PARALLEL>(u[lane], v[lane]);
        let is_b = half[lane] > 0.0;
        let albedo = |part: usize| if is_b { facts.colors[1][part][lane] } else { facts.colors[0][part][lane] };
        let surface = Surface {
            depth: t[lane],
            normal: Vec3::new(points.normal[0][lane], points.normal[1][lane], points.normal[2][lane]),
            albedo: Vec3::new(albedo(0), albedo(1), albedo(2)),
        };
        let cut = t[lane] <= near;
        let reach = Reach {
            open: if cut { unasked.open } else { open[lane] },
            key: if cut { unasked.key } else { key[lane] },
        };
        let color = shade_surface(shader.frame, &surface, reach, ray.direction);
        lit.color[0][lane] = if lit.seen[lane] { color.x } else { 0.0 };
        lit.color[1][lane] = if lit.seen[lane] { color.y } else { 0.0 };
        lit.color[2][lane] = if lit.seen[lane] { color.z } else { 0.0 };
    }
}

/// Adds a block's light to the sums of its pixels (planes of [`super::backdrop::Sums`] of a tile of `width` pixels).
#[inline(always)]
pub(super) fn add(lit: &Lit, place: &Place<'_>, sums: &mut [f32], width: usize, [row, column]: [usize; 2]) {
    match place.pass.side {
        1 => add_pixels::<1>(lit, sums, width, [row, column]),
        2 => add_pixels::<2>(lit, sums, width, [row, column]),
        _ => add_pixels::<4>(lit, sums, width, [row, column]),
    }
}

/// Of a block of `SIDE` × `SIDE` pixels, whose lanes lie one after the other.
#[inline(always)]
fn add_pixels<const SIDE: usize>(lit: &Lit, sums: &mut [f32], width: usize, [row, column]: [usize; 2]) {
    let per_pixel = LANES / (SIDE * SIDE);
    let seen: Lanes = lit.seen.map(|seen| if seen { 1.0 } else { 0.0 });
    for (plane, lanes) in [&lit.color[0], &lit.color[1], &lit.color[2], &seen].into_iter().enumerate() {
        for y in 0..SIDE {
            let start = (plane * width + row * SIDE + y) * width + column * SIDE;
            let line = &mut sums[start..start + SIDE];
            for x in 0..SIDE {
                let first = (y * SIDE + x) * per_pixel;
                // In pairs, and pairs of pairs: no chain of sixteen additions, each of which waits for the one before.
                let mut sum = [0.0f32; 4];
                for i in 0..per_pixel {
                    sum[i % 4] += lanes[first + i];
                }
                line[x] += (sum[0] + sum[1]) + (sum[2] + sum[3]);
            }
        }
    }
}
