//! From what the samples of a tile see to light: the vector twin of [`super::shader::Shader`].
//!
//! A vector holds 4 × 4 pixels, one sample of each: they ask the same directions of the sky.

use super::backdrop::Backdrop;
use super::behind::Mask;
use super::facts::{Looks, Memo};
use super::lanes::{LANES, Lanes};
use super::reach::{NOBODY, Points, Questions};
use super::shader::Shader;
use super::source::Facts;
use super::tile::{Place, SIDE, Tile};
use crate::color::Srgb8;
use crate::math::max;
use crate::render::frame::{self, shade_outline, shade_surfaces};
use crate::render::outline::RIM;
use crate::render::sky::start_offset;
use crate::scene::PixelGrid;
use glam::Vec3;

/// Pixels on a side of what is worked on together.
pub(super) const GROUP: usize = 4;

/// One sample of each pixel of a group.
struct Samples {
    u: Lanes,
    v: Lanes,
    t: Lanes,
    index: [u32; LANES],
    /// Which of them see a primitive.
    seen: Mask,
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
    (shader, source): (&Shader<'_>, &dyn Facts),
    questions: &Questions<'_>,
    place: &Place<'_>,
    tile: &Tile,
    (sums, width): (&mut [f32], usize),
) {
    let (blocks, mut memo) = (GROUP / place.pass.side as usize, Memo::new(source));
    for sample in 0..place.pass.per_pixel() {
        let (number, unasked) = (place.pass.sample[sample], shader.frame.unasked());
        for row in 0..width / GROUP {
            for column in 0..width / GROUP {
                let columns = column * blocks..(column + 1) * blocks;
                let touched = &tile.touched[row * blocks..(row + 1) * blocks];
                if !touched.iter().any(|row| row[columns.clone()].contains(&true)) {
                    continue;
                }
                let samples = gather((shader, source), place, tile, sample, [row, column]);
                if !any(&samples.seen) {
                    continue;
                }
                let told = told(source, place, tile, (sample, &samples.seen), [row, column]);
                let (surfaces, mut points) = surfaces((shader, &mut memo), place, (samples, told));
                questions.ask(&mut points, number, unasked);
                let light = light(shader, place.grid.orthographic, &surfaces, &points);
                let seen: Lanes = surfaces.samples.seen.map(|seen| if seen != 0 { 1.0 } else { 0.0 });
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

/// Finishes the pixels of a tile that have but one sample, and ask nothing: `rows` are those of the picture, cut to the tile. Of an
/// empty one (`is_empty`) `tile` says nothing.
#[inline(always)]
pub(super) fn finish(
    (shader, source): (&Shader<'_>, &dyn Facts),
    place: &Place<'_>,
    (tile, is_empty): (&Tile, bool),
    rows: &mut [&mut [Srgb8]],
) {
    let (mut backdrop, mut memo) = (Backdrop::new(shader, &place.grid), Memo::new(source));
    if backdrop.is_plain() {
        rows.iter_mut().for_each(|line| line.fill(backdrop.plain()));
    }
    for (row, lines) in rows.chunks_mut(GROUP).enumerate() {
        let width = lines.first().map_or(0, |line| line.len());
        let [left, top] = [place.corner[0], place.corner[1] + (row * GROUP) as u32];
        let flat = if backdrop.is_plain() {
            None
        } else {
            backdrop.flat_in([left, top, left + width as u32, top + lines.len() as u32])
        };
        if let Some(flat) = flat {
            lines.iter_mut().for_each(|line| line.fill(flat));
        }
        for (column, start) in (0..width).step_by(GROUP).enumerate() {
            let is_touched = !is_empty && tile.touched[row][column];
            if !is_touched && (backdrop.is_plain() || flat.is_some()) {
                continue;
            }
            let pixels = if is_touched {
                let samples = gather((shader, source), place, tile, 0, [row, column]);
                let ([u, v], seen) = ([samples.u, samples.v], samples.seen);
                let mut lit = [[0.0; LANES]; 3];
                if any(&seen) {
                    let told = told(source, place, tile, (0, &seen), [row, column]);
                    let (surfaces, mut points) = surfaces((shader, &mut memo), place, (samples, told));
                    points.asks = [0.0; LANES];
                    lit = light(shader, place.grid.orthographic, &surfaces, &points);
                }
                backdrop.under(&lit, &seen, [&u, &v])
            } else {
                let [u, v] = centers(place, 0, [row, column]);
                backdrop.alone([&u, &v])
            };
            let count = GROUP.min(width - start);
            for (line, pixels) in lines.iter_mut().zip(pixels.chunks_exact(GROUP)) {
                if let Some(line) = line.get_mut(start..).and_then(|line| line.first_chunk_mut::<GROUP>()) {
                    line.copy_from_slice(pixels);
                } else {
                    line[start..].copy_from_slice(&pixels[..count]);
                }
            }
        }
    }
}

/// Whether any lane of a mask is set.
#[inline(always)]
fn any(mask: &Mask) -> bool {
    let mut any = 0;
    for &lane in mask {
        any |= lane;
    }
    any != 0
}

/// Plane coordinates of one sample of each pixel of a group.
#[inline(always)]
fn centers(place: &Place<'_>, sample: usize, [row, column]: [usize; 2]) -> [Lanes; 2] {
    // The first pixel's sample is as far from its corner as every other's.
    let (dx, dy) = (place.pass.x[sample], place.pass.y[sample]);
    let (left, top) = (place.corner[0] + (column * GROUP) as u32, place.corner[1] + (row * GROUP) as u32);
    let PixelGrid { center_px, plane_per_px, .. } = place.grid;
    let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let (x, y) = ((left + (lane % GROUP) as u32) as f32 + dx, (top + (lane / GROUP) as u32) as f32 + dy);
        u[lane] = (x - center_px[0]) * plane_per_px;
        v[lane] = (center_px[1] - y) * plane_per_px;
    }
    [u, v]
}

/// One sample of each pixel of a group.
#[inline(always)]
fn gather(
    (shader, source): (&Shader<'_>, &dyn Facts),
    place: &Place<'_>,
    tile: &Tile,
    sample: usize,
    [row, column]: [usize; 2],
) -> Samples {
    let blocks = GROUP / place.pass.side as usize;
    let mut samples =
        Samples { u: [0.0; LANES], v: [0.0; LANES], t: [f32::INFINITY; LANES], index: [0; LANES], seen: [0; LANES] };
    if blocks == 1 {
        // The group is a block, its samples in the same order.
        (samples.t, samples.index) = (tile.t[row][column], tile.index[row][column]);
    } else {
        let (t, index) = (tile.t.as_flattened().as_flattened(), tile.index.as_flattened().as_flattened());
        let start = (row * blocks * SIDE + column * blocks) * LANES + sample;
        for lane in 0..LANES {
            let at = start + place.pass.group[lane];
            samples.t[lane] = t[at];
            samples.index[lane] = index[at];
        }
    }
    [samples.u, samples.v] = centers(place, sample, [row, column]);
    let beyond = shader.ground_beyond(place.grid.orthographic, &samples.u, &samples.v);
    for (lane, ground) in beyond.into_iter().enumerate() {
        let t = samples.t[lane];
        let is_seen = (t < f32::INFINITY) & (t - behind(shader, source, samples.index[lane]) <= ground);
        samples.seen[lane] = if is_seen { u32::MAX } else { 0 };
    }
    samples
}

/// What one sample of each pixel of a group was told of what it sees, if samples are told.
#[inline(always)]
fn told(
    source: &dyn Facts,
    place: &Place<'_>,
    tile: &Tile,
    (sample, seen): (usize, &Mask),
    [row, column]: [usize; 2],
) -> Option<Looks> {
    if !source.tells_looks() {
        return None;
    }
    let blocks = GROUP / place.pass.side as usize;
    if blocks == 1 {
        let [x, y, z] = &tile.normal[row][column];
        return Some(Looks::told([x, y, z], &tile.color[row][column], seen));
    }
    let (normal, color) = (tile.normal.as_flattened(), tile.color.as_flattened().as_flattened());
    let start = (row * blocks * SIDE + column * blocks) * LANES + sample;
    let (mut normals, mut colors) = ([[0.0; LANES]; 3], [0; LANES]);
    for lane in 0..LANES {
        let at = start + place.pass.group[lane];
        colors[lane] = color[at];
        for part in 0..3 {
            normals[part][lane] = normal[at / LANES][part][at % LANES];
        }
    }
    Some(Looks::told(normals.each_ref(), &colors, seen))
}

/// [`Shader::behind`] of a primitive that the shader may not have.
#[inline(always)]
fn behind(shader: &Shader<'_>, source: &dyn Facts, index: u32) -> f32 {
    match &shader.outlined {
        Some(outline) if index & RIM != 0 => source.behind(outline, index & !RIM),
        _ => 0.0,
    }
}

/// The surfaces of samples.
#[inline(always)]
fn surfaces(
    (shader, memo): (&Shader<'_>, &mut Memo<'_>),
    place: &Place<'_>,
    (samples, told): (Samples, Option<Looks>),
) -> (Surfaces, Points) {
    let near = shader.frame.depth[2];
    let Samples { u, v, t, seen, index } = &samples;
    // Rays start at (u, v, 0) and run along −z, or start at the eye and run along (u, v, −1).
    let (start, slope) = if place.grid.orthographic { (1.0, 0.0) } else { (0.0, 1.0) };
    let (mut points, mut hit, mut depth) = (Points::default(), [[0.0f32; LANES]; 3], [0.0f32; LANES]);
    for lane in 0..LANES {
        depth[lane] = if seen[lane] != 0 { t[lane] } else { near };
        let aside = start + slope * depth[lane];
        (hit[0][lane], hit[1][lane], hit[2][lane]) = (u[lane] * aside, v[lane] * aside, -depth[lane]);
    }
    let mut surfaces = told.unwrap_or_else(|| Looks::of(memo, index, seen, &hit));
    for lane in 0..LANES {
        let d = Vec3::new(u[lane] * slope, v[lane] * slope, -1.0);
        let toward = -1.0 / (d.x * d.x + d.y * d.y + d.z * d.z).sqrt();
        let cut = depth[lane] <= near;
        let [nx, ny, nz] = &surfaces.normal;
        let pick = |n: f32, d: f32| if cut { d * toward } else { n };
        let n = Vec3::new(pick(nx[lane], d.x), pick(ny[lane], d.y), pick(nz[lane], d.z));
        let over = 1.0 / max((n.x * n.x + n.y * n.y + n.z * n.z).sqrt(), 1e-20);
        // Seen from inside, an open cylinder shows its back.
        let n = n * if n.x * d.x + n.y * d.y + n.z * d.z > 0.0 { -over } else { over };
        for part in 0..3 {
            points.position[part][lane] = hit[part][lane] + n[part] * start_offset(depth[lane]);
            points.normal[part][lane] = n[part];
        }
        let is_line = index[lane] & RIM != 0;
        points.asks[lane] = if (seen[lane] != 0) & !cut & !is_line { 1.0 } else { 0.0 };
        points.own[lane] = if shader.solids.see_through { NOBODY } else { index[lane] };
    }
    if any(&surfaces.others) {
        others((shader, memo.source()), place, &samples, &mut points, &mut surfaces);
    }
    (Surfaces { samples, albedo: surfaces.albedo }, points)
}

/// Normals and colours of what is neither ball, stick nor ring, one by one.
#[inline(always)]
fn others(
    (shader, source): (&Shader<'_>, &dyn Facts),
    place: &Place<'_>,
    samples: &Samples,
    points: &mut Points,
    Looks { albedo, others, .. }: &mut Looks,
) {
    for (lane, &index) in samples.index.iter().enumerate() {
        if others[lane] == 0 || index & RIM != 0 {
            continue;
        }
        let ray = place.grid.ray((samples.u[lane], samples.v[lane]));
        let surface = shader.surface(&ray, source.of_shader(index), samples.t[lane]);
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
        seen[lane] = if samples.seen[lane] != 0 { 1.0 } else { 0.0 };
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
