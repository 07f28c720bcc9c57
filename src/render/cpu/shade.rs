//! From what the samples of a tile see to light: the vector twin of [`super::shader::Shader`].
//!
//! A vector holds 4 × 4 pixels, one sample of each: they ask the same directions of the sky.

use super::asking::Questions;
use super::backdrop::Backdrop;
use super::behind::Mask;
use super::facts::{Looks, Memo};
use super::lanes::{LANES, Lanes, bits};
use super::reach::Points;
use super::shader::Shader;
use super::source::Facts;
use super::tile::{Place, SIDE, Tile};
use crate::color::Srgb8;
use crate::math::{Aabb, max, min};
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

/// What a group of pixels shows in one sample, kept until it is known what light reaches it.
pub(super) struct Packet {
    t: Lanes,
    normal: [Lanes; 3],
    albedo: [Lanes; 3],
    /// Upper left pixel in the full picture, and the place of the sample in each.
    corner: [u32; 2],
    offset_px: [f32; 2],
    /// Number of the sample in the pixel's sequence.
    pub(super) sample: u32,
    /// Row and column of the group in its tile.
    group: [u8; 2],
    /// Bits of the lanes that see a primitive, that ask, and that see a line.
    seen: u16,
    asks: u16,
    lines: u16,
}

/// The packets of a tile, and what box their points are in, view space.
pub(super) struct Kept {
    pub(super) packets: Vec<Packet>,
    /// Samples in the order of the packets, and where those of each end.
    pub(super) samples: Vec<(u32, usize)>,
    low: [Lanes; 3],
    high: [Lanes; 3],
}

impl Kept {
    /// Without packets, in the room of those before.
    pub(super) fn of(mut packets: Vec<Packet>) -> Kept {
        packets.clear();
        Kept { packets, samples: Vec::new(), low: [[f32::INFINITY; LANES]; 3], high: [[f32::NEG_INFINITY; LANES]; 3] }
    }

    /// The box around all points.
    pub(super) fn bounds(&self) -> Aabb {
        if self.packets.is_empty() {
            return Aabb::EMPTY;
        }
        let of = |of: fn(f32, f32) -> f32, lanes: &Lanes| lanes.iter().copied().fold(lanes[0], of);
        let [low, high] = [self.low.map(|lanes| of(min, &lanes)), self.high.map(|lanes| of(max, &lanes))];
        Aabb { min: low.into(), max: high.into() }
    }

    #[inline(always)]
    fn around(&mut self, points: &Points) {
        for axis in 0..3 {
            for lane in 0..LANES {
                let (x, asks) = (points.position[axis][lane], points.asks[lane] > 0.0);
                let (low, high) = (&mut self.low[axis][lane], &mut self.high[axis][lane]);
                *low = min(if asks { x } else { *low }, *low);
                *high = max(if asks { x } else { *high }, *high);
            }
        }
    }
}

impl Packet {
    /// Where its points are and which way they face, view space; they were told nothing.
    #[inline(always)]
    pub(super) fn points(&self, shader: &Shader<'_>, grid: &PixelGrid) -> Points {
        let [u, v] = plane(grid, self.corner, self.offset_px);
        let seen = self.mask(self.seen);
        let (hit, depth) = hits(shader, grid, [&u, &v], &self.t, &seen);
        let mut points = Points { normal: self.normal, ..Points::default() };
        for lane in 0..LANES {
            let offset = start_offset(depth[lane]);
            for (position, (hit, normal)) in points.position.iter_mut().zip(hit.iter().zip(&self.normal)) {
                position[lane] = hit[lane] + normal[lane] * offset;
            }
            points.asks[lane] = if self.asks >> lane & 1 != 0 { 1.0 } else { 0.0 };
        }
        points
    }

    #[inline(always)]
    fn mask(&self, bits: u16) -> Mask {
        std::array::from_fn(|lane| if bits >> lane & 1 != 0 { u32::MAX } else { 0 })
    }
}

/// The groups of pixels of a tile that may see something, sample by sample: sample, and row and column.
#[inline(always)]
fn groups(place: &Place<'_>, tile: &Tile, width: usize) -> Vec<(usize, [usize; 2])> {
    let blocks = GROUP / place.pass.side as usize;
    let mut groups = Vec::new();
    for sample in 0..place.pass.per_pixel() {
        for row in 0..width / GROUP {
            for column in 0..width / GROUP {
                let columns = column * blocks..(column + 1) * blocks;
                let touched = &tile.touched[row * blocks..(row + 1) * blocks];
                if touched.iter().any(|row| row[columns.clone()].contains(&true)) {
                    groups.push((sample, [row, column]));
                }
            }
        }
    }
    groups
}

/// Keeps what a tile of so many pixels' width shows, sample by sample.
#[inline(always)]
pub(super) fn keep(
    (shader, source): (&Shader<'_>, &dyn Facts),
    place: &Place<'_>,
    tile: &Tile,
    (kept, width): (&mut Kept, usize),
) {
    let (mut memo, groups) = (Memo::new(source), groups(place, tile, width));
    kept.packets.reserve(groups.len());
    for (sample, group) in groups {
        let samples = gather((shader, source), place, tile, sample, group);
        if !any(&samples.seen) {
            continue;
        }
        let told = told(source, place, tile, (sample, &samples.seen), group);
        let (surfaces, points) = surfaces((shader, &mut memo), place, (samples, told));
        let Surfaces { samples, albedo } = surfaces;
        kept.around(&points);
        let number = place.pass.sample[sample];
        match kept.samples.last_mut() {
            Some((last, end)) if *last == number => *end += 1,
            _ => kept.samples.push((number, kept.packets.len() + 1)),
        }
        kept.packets.push(Packet {
            t: samples.t,
            normal: points.normal,
            albedo,
            corner: corner(place, group),
            offset_px: [place.pass.x[sample], place.pass.y[sample]],
            sample: number,
            group: group.map(|place| place as u8),
            seen: bits(|lane| samples.seen[lane] != 0) as u16,
            asks: bits(|lane| points.asks[lane] > 0.0) as u16,
            lines: bits(|lane| samples.index[lane] & RIM != 0) as u16,
        });
    }
}

/// Adds the light of a packet whose points were told what reaches them to the sums of its tile.
#[inline(always)]
pub(super) fn add_packet(
    (shader, grid): (&Shader<'_>, &PixelGrid),
    packet: &Packet,
    points: &Points,
    (sums, width): (&mut [f32], usize),
) {
    let [u, v] = plane(grid, packet.corner, packet.offset_px);
    let (seen, lines) = (packet.mask(packet.seen), packet.mask(packet.lines));
    let index = lines.map(|line| line & RIM);
    let samples = Samples { u, v, t: packet.t, index, seen };
    let surfaces = Surfaces { samples, albedo: packet.albedo };
    let light = light(shader, grid.orthographic, &surfaces, points);
    let [row, column] = packet.group.map(usize::from);
    add_to(&light, &seen, [row, column], (sums, width));
}

/// Adds the light of a group of pixels to the sums of its tile (planes of [`super::backdrop::Sums`], rows of `width` pixels).
#[inline(always)]
fn add_to(light: &[Lanes; 3], seen: &Mask, [row, column]: [usize; 2], (sums, width): (&mut [f32], usize)) {
    let seen: Lanes = seen.map(|seen| if seen != 0 { 1.0 } else { 0.0 });
    for (plane, lanes) in [&light[0], &light[1], &light[2], &seen].into_iter().enumerate() {
        for y in 0..GROUP {
            let start = (plane * width + row * GROUP + y) * width + column * GROUP;
            for (sum, lane) in sums[start..start + GROUP].iter_mut().zip(&lanes[y * GROUP..(y + 1) * GROUP]) {
                *sum += lane;
            }
        }
    }
}

/// Adds the light of a tile to its sums; it asks at once for light from afar, or for none.
#[inline(always)]
pub(super) fn add(
    (shader, source): (&Shader<'_>, &dyn Facts),
    questions: Option<&Questions<'_>>,
    place: &Place<'_>,
    tile: &Tile,
    (sums, width): (&mut [f32], usize),
) {
    let mut memo = Memo::new(source);
    for (sample, group) in groups(place, tile, width) {
        let samples = gather((shader, source), place, tile, sample, group);
        if !any(&samples.seen) {
            continue;
        }
        let told = told(source, place, tile, (sample, &samples.seen), group);
        let (surfaces, mut points) = surfaces((shader, &mut memo), place, (samples, told));
        match questions {
            Some(questions) => questions.ask(&mut points, place.pass.sample[sample], shader.frame.unasked()),
            None => points.asks = [0.0; LANES],
        }
        let light = light(shader, place.grid.orthographic, &surfaces, &points);
        add_to(&light, &surfaces.samples.seen, group, (sums, width));
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

/// The upper left pixel of a group.
#[inline(always)]
fn corner(place: &Place<'_>, [row, column]: [usize; 2]) -> [u32; 2] {
    [place.corner[0] + (column * GROUP) as u32, place.corner[1] + (row * GROUP) as u32]
}

/// Plane coordinates of one sample of each pixel of a group.
#[inline(always)]
fn centers(place: &Place<'_>, sample: usize, group: [usize; 2]) -> [Lanes; 2] {
    // The first pixel's sample is as far from its corner as every other's.
    plane(&place.grid, corner(place, group), [place.pass.x[sample], place.pass.y[sample]])
}

/// Plane coordinates of the samples at a place in each pixel of a group.
#[inline(always)]
fn plane(grid: &PixelGrid, [left, top]: [u32; 2], [dx, dy]: [f32; 2]) -> [Lanes; 2] {
    let PixelGrid { center_px, plane_per_px, .. } = *grid;
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

/// Where samples hit, and how deep; on the near plane where they see nothing.
#[inline(always)]
fn hits(shader: &Shader<'_>, grid: &PixelGrid, [u, v]: [&Lanes; 2], t: &Lanes, seen: &Mask) -> ([Lanes; 3], Lanes) {
    let near = shader.frame.depth[2];
    // Rays start at (u, v, 0) and run along −z, or start at the eye and run along (u, v, −1).
    let (start, slope) = if grid.orthographic { (1.0, 0.0) } else { (0.0, 1.0) };
    let (mut hit, mut depth) = ([[0.0f32; LANES]; 3], [0.0f32; LANES]);
    for lane in 0..LANES {
        depth[lane] = if seen[lane] != 0 { t[lane] } else { near };
        let aside = start + slope * depth[lane];
        (hit[0][lane], hit[1][lane], hit[2][lane]) = (u[lane] * aside, v[lane] * aside, -depth[lane]);
    }
    (hit, depth)
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
    let slope = if place.grid.orthographic { 0.0 } else { 1.0 };
    let (hit, depth) = hits(shader, &place.grid, [u, v], t, seen);
    let mut points = Points::default();
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
    // As in `hits`.
    let (unasked, [start, slope]) = (shader.frame.unasked(), if parallel { [1.0, 0.0] } else { [0.0, 1.0] });
    let (mut open, mut key, mut direction) = ([0.0f32; LANES], [0.0f32; LANES], [[0.0f32; LANES]; 2]);
    let (mut seen, mut position) = ([0.0f32; LANES], [[0.0f32; LANES]; 3]);
    for lane in 0..LANES {
        open[lane] = if points.asks[lane] > 0.0 { points.told[0][lane] } else { unasked.open };
        key[lane] = if points.asks[lane] > 0.0 { points.told[1][lane] } else { unasked.key };
        let aside = start + slope * samples.t[lane];
        (position[0][lane], position[1][lane]) = (samples.u[lane] * aside, samples.v[lane] * aside);
        position[2][lane] = -samples.t[lane];
        direction[0][lane] = samples.u[lane] * slope;
        direction[1][lane] = samples.v[lane] * slope;
        seen[lane] = if samples.seen[lane] != 0 { 1.0 } else { 0.0 };
    }
    let (position, normal) = (&position, &points.normal);
    let told = frame::Surfaces { position, normal, albedo, open: &open, key: &key, direction: &direction };
    let mut light = shade_surfaces(shader.frame, &told);
    if shader.outlined.is_some() {
        for (lane, &index) in samples.index.iter().enumerate() {
            if index & RIM != 0 {
                let line = shade_outline(shader.frame, position.map(|part| part[lane]).into());
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
