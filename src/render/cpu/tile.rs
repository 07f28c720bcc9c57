//! What every sample of a tile sees: a small depth buffer, filled front to back.
//!
//! A tile is 32 × 32 blocks of [`LANES`] samples. Each block knows the depth of its farthest sample, so that what lies behind
//! it is left out at once. Ties in depth go to the first primitive, as in the reference.

use super::behind::Mask;
use super::binning::Candidate;
use super::intersect::{
    FLAT_CAPS, cone_middle_t, cone_t, cylinder_middle_t, cylinder_t, flat_cylinder_middle_t, flat_cylinder_t,
    sphere_entry, sphere_middle_t, sphere_t, torus_middle_t, torus_t, torus_ts, triangle_t,
};
use super::lanes::{LANES, Lanes, Pass};
use super::looks::{BallSurface, NO_ENDS, RingSurface, StickSurface, Surface};
use crate::color::Srgb8;
use crate::render::outline::{Outline, RIM};
use crate::render::solids::{Cone, Cylinder, Primitive, Solids, Sphere, Torus, Triangle};
use crate::scene::{PixelGrid, Ray};
use glam::Vec3;
use std::alloc::Layout;
use std::ops::Range;

/// Blocks on a side of a tile, at most.
pub(super) const SIDE: usize = 32;

/// Samples of a tile.
pub(super) const SAMPLES: usize = SIDE * SIDE * LANES;

/// The depth of a primitive along the ray of plane coordinates. (A trait, not a closure: it must be inlined wherever it is used.)
pub(super) trait DepthAt {
    /// Whether it has a line around it.
    const OUTLINED: bool = false;

    fn t(&self, u: f32, v: f32) -> f32;

    /// The same for all samples of a block.
    #[inline(always)]
    fn ts(&self, u: &Lanes, v: &Lanes) -> Lanes {
        let mut ts = [0.0; LANES];
        for lane in 0..LANES {
            ts[lane] = self.t(u[lane], v[lane]);
        }
        ts
    }

    /// Midway through it.
    fn middle(&self, _u: f32, _v: f32) -> f32 {
        f32::INFINITY
    }

    /// Whether the tile is told what it looks like.
    const TOLD: bool = false;

    /// Its normals at these depths, and its colours there as [`Tile::color`] has them.
    fn looks(&self, _u: &Lanes, _v: &Lanes, _t: &Lanes) -> ([Lanes; 3], [u32; LANES]) {
        ([[0.0; LANES]; 3], [0; LANES])
    }
}

/// A primitive of which the tile is told what it looks like: its surface, and the bytes of its two colours.
pub(super) struct Told<D, S, const PARALLEL: bool> {
    pub(super) drawn: D,
    pub(super) surface: S,
    pub(super) colors: [Srgb8; 2],
}

impl<D: DepthAt, S: Surface, const PARALLEL: bool> DepthAt for Told<D, S, PARALLEL> {
    const TOLD: bool = true;

    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        self.drawn.t(u, v)
    }

    #[inline(always)]
    fn ts(&self, u: &Lanes, v: &Lanes) -> Lanes {
        self.drawn.ts(u, v)
    }

    #[inline(always)]
    fn looks(&self, u: &Lanes, v: &Lanes, t: &Lanes) -> ([Lanes; 3], [u32; LANES]) {
        let (mut hit, mut color) = ([[0.0; LANES]; 3], [0; LANES]);
        for lane in 0..LANES {
            [hit[0][lane], hit[1][lane], hit[2][lane]] = hit_at::<PARALLEL>(u[lane], v[lane], t[lane]).to_array();
        }
        let (normal, second) = self.surface.at(&hit);
        let [first, other]: [u32; 2] = bytemuck::cast(self.colors);
        for lane in 0..LANES {
            color[lane] = if second[lane] != 0 { other } else { first };
        }
        (normal, color)
    }
}

/// Where the ray of plane coordinates is at a depth: the same bits as shading has it.
#[inline(always)]
pub(super) fn hit_at<const PARALLEL: bool>(u: f32, v: f32, t: f32) -> Vec3 {
    let aside = if PARALLEL { 1.0 } else { t };
    Vec3::new(u * aside, v * aside, -t)
}

/// What is found one by one when it is shaded.
#[derive(Clone, Copy)]
pub(super) struct Untold;

impl Surface for Untold {
    #[inline(always)]
    fn at(&self, _hit: &[Lanes; 3]) -> ([Lanes; 3], Mask) {
        ([[0.0; LANES]; 3], [0; LANES])
    }
}

/// In [`Tile::color`], of what is found one by one.
const UNTOLD: Srgb8 = Srgb8 { r: 0, g: 0, b: 0, a: 0 };

/// A primitive with its line: itself, itself grown by the line, and how far behind the silhouette the line lies.
struct Outlined<D> {
    own: D,
    grown: D,
    behind: f32,
}

impl<D: DepthAt> DepthAt for Outlined<D> {
    const OUTLINED: bool = true;

    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        self.own.t(u, v)
    }

    #[inline(always)]
    fn ts(&self, u: &Lanes, v: &Lanes) -> Lanes {
        self.own.ts(u, v)
    }

    #[inline(always)]
    fn middle(&self, u: f32, v: f32) -> f32 {
        self.grown.middle(u, v) + self.behind
    }
}

/// A primitive seen with parallel rays (`PARALLEL`) or in perspective.
#[derive(Clone, Copy)]
pub(super) struct Drawn<S, const PARALLEL: bool> {
    pub(super) solid: S,
    pub(super) near: f32,
}

/// The ray of plane coordinates.
#[inline(always)]
pub(super) fn ray<const PARALLEL: bool>(u: f32, v: f32) -> Ray {
    if PARALLEL {
        Ray { origin: Vec3::new(u, v, 0.0), direction: Vec3::new(0.0, 0.0, -1.0) }
    } else {
        Ray { origin: Vec3::ZERO, direction: Vec3::new(u, v, -1.0) }
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Sphere, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        sphere_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }

    #[inline(always)]
    fn middle(&self, u: f32, v: f32) -> f32 {
        sphere_middle_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

/// A ball that lies beyond the near plane: less to find out.
#[derive(Clone, Copy)]
pub(super) struct Beyond(pub(super) Sphere);

impl<const PARALLEL: bool> DepthAt for Drawn<Beyond, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        sphere_entry(&ray::<PARALLEL>(u, v), &self.solid.0)
    }
}

/// A cylinder with two flat caps: less to find out.
#[derive(Clone, Copy)]
pub(super) struct Flat(pub(super) Cylinder);

impl<const PARALLEL: bool> DepthAt for Drawn<Flat, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        flat_cylinder_t(&ray::<PARALLEL>(u, v), &self.solid.0, self.near)
    }

    #[inline(always)]
    fn middle(&self, u: f32, v: f32) -> f32 {
        flat_cylinder_middle_t(&ray::<PARALLEL>(u, v), &self.solid.0, self.near)
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Cylinder, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        cylinder_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }

    #[inline(always)]
    fn middle(&self, u: f32, v: f32) -> f32 {
        cylinder_middle_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Cone, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        cone_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }

    #[inline(always)]
    fn middle(&self, u: f32, v: f32) -> f32 {
        cone_middle_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Torus, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        torus_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }

    #[inline(always)]
    fn ts(&self, u: &Lanes, v: &Lanes) -> Lanes {
        torus_ts(|lane| ray::<PARALLEL>(u[lane], v[lane]), &self.solid, self.near)
    }

    #[inline(always)]
    fn middle(&self, u: f32, v: f32) -> f32 {
        torus_middle_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

impl<const PARALLEL: bool> DepthAt for Drawn<Triangle, PARALLEL> {
    #[inline(always)]
    fn t(&self, u: f32, v: f32) -> f32 {
        triangle_t(&ray::<PARALLEL>(u, v), &self.solid, self.near)
    }
}

/// Where a tile lies in the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) pass: &'a Pass,
    pub(super) grid: PixelGrid,
    /// Upper left pixel in the full picture.
    pub(super) corner: [u32; 2],
    /// Upper left pixel in the region.
    pub(super) in_region: [u32; 2],
    /// Blocks in x and y that are in the picture.
    pub(super) blocks: [usize; 2],
    pub(super) near: f32,
    /// Lines around things.
    pub(super) outline: Option<&'a Outline>,
}

impl Place<'_> {
    /// Pixels counted from the tile's corner, left, top, right and bottom, as pixels of the region.
    #[inline(always)]
    pub(super) fn in_the_region(&self, pixels: [u32; 4]) -> [u16; 4] {
        std::array::from_fn(|side| (pixels[side] + self.in_region[side % 2]) as u16)
    }

    /// Plane coordinates of the samples of a block: the same bits as [`PixelGrid::plane`] gives.
    #[inline(always)]
    pub(super) fn u(&self, column: usize) -> Lanes {
        let corner = (self.corner[0] + column as u32 * self.pass.side) as f32;
        std::array::from_fn(|lane| (corner + self.pass.x[lane] - self.grid.center_px[0]) * self.grid.plane_per_px)
    }

    #[inline(always)]
    pub(super) fn v(&self, row: usize) -> Lanes {
        let corner = (self.corner[1] + row as u32 * self.pass.side) as f32;
        std::array::from_fn(|lane| (self.grid.center_px[1] - (corner + self.pass.y[lane])) * self.grid.plane_per_px)
    }
}

/// Depth and primitive of what is nearest in each sample.
#[derive(bytemuck::Zeroable)]
pub(super) struct Tile {
    pub(super) t: [[Lanes; SIDE]; SIDE],
    /// Marked with [`RIM`] where it is the primitive's line.
    pub(super) index: [[[u32; LANES]; SIDE]; SIDE],
    /// The farthest depth of each block; infinity while a sample of it is empty.
    farthest: [[f32; SIDE]; SIDE],
    /// Samples of each block in which nothing is seen.
    empty: [[u8; SIDE]; SIDE],
    /// Whether anything is seen in each block.
    pub(super) touched: [[bool; SIDE]; SIDE],
    /// Of samples in which something is seen, if the tile is told what it looks like: normals of any length.
    pub(super) normal: [[[Lanes; 3]; SIDE]; SIDE],
    /// Likewise the bytes of its colour, an opaque [`Srgb8`]; 0 of what is found one by one.
    pub(super) color: [[[u32; LANES]; SIDE]; SIDE],
}

impl Tile {
    /// Room for a tile, which [`Tile::clear`] makes ready.
    pub(super) fn new() -> Box<Tile> {
        // Without memory the end is that of all others, not a panic.
        bytemuck::try_zeroed_box().unwrap_or_else(|()| std::alloc::handle_alloc_error(Layout::new::<Tile>()))
    }

    /// Takes away what was seen before.
    #[inline(always)]
    pub(super) fn clear(&mut self, place: &Place<'_>) {
        // Groups of 4 × 4 pixels may reach out of the picture by three blocks.
        let [columns, rows] = place.blocks.map(|blocks| (blocks + 3).min(SIDE));
        for row in 0..rows {
            self.t[row][..columns].fill([f32::INFINITY; LANES]);
            self.index[row][..columns].fill([0; LANES]);
        }
        self.farthest = [[f32::INFINITY; SIDE]; SIDE];
        // What lies out of the picture hides nothing, and is hidden by everything.
        for row in 0..SIDE {
            let end = if row < place.blocks[1] { place.blocks[0] } else { 0 };
            self.farthest[row][end..].fill(0.0);
        }
        self.empty = [[LANES as u8; SIDE]; SIDE];
        self.touched = [[false; SIDE]; SIDE];
    }

    /// Finds what is seen; `candidates` are front to back.
    #[inline(always)]
    pub(super) fn see(&mut self, place: &Place<'_>, solids: &Solids, candidates: &[Candidate]) {
        self.clear(place);
        for (drawn, candidate) in candidates.iter().enumerate() {
            if drawn % 16 == 15 && candidate.nearest > self.farthest() {
                break; // the rest is behind everything
            }
            if place.grid.orthographic {
                self.draw_any::<true>(place, (solids, candidate.index as usize), candidate);
            } else {
                self.draw_any::<false>(place, (solids, candidate.index as usize), candidate);
            }
        }
    }

    /// Draws primitive `number` of `solids` with its line, if there are lines, in the samples in which it is there.
    #[inline(always)]
    pub(super) fn draw_any<const PARALLEL: bool>(
        &mut self,
        place: &Place<'_>,
        (solids, number): (&Solids, usize),
        candidate: &Candidate,
    ) {
        let mut mask = [true; LANES];
        if solids.see_through {
            mask = place.pass.sample.map(|sample| solids.is_drawn(number, sample, place.pass.samples));
        }
        self.draw_candidate::<PARALLEL>(place, (solids, number), candidate, &mask);
    }

    /// The farthest depth of the tile.
    #[inline(always)]
    pub(super) fn farthest(&self) -> f32 {
        let mut most = [0.0f32; SIDE];
        for row in &self.farthest {
            for (most, &t) in most.iter_mut().zip(row) {
                *most = if t > *most { t } else { *most };
            }
        }
        most.into_iter().fold(0.0f32, |most, t| if t > most { t } else { most })
    }

    /// Blocks of a tile that a rectangle of the region's pixels meets: columns and rows, empty where it meets none.
    #[inline(always)]
    fn blocks_of(place: &Place<'_>, pixels: [u16; 4]) -> [Range<usize>; 2] {
        let [left, top, right, bottom] = pixels.map(u32::from);
        let range = |low: u32, high: u32, axis: usize| {
            let (origin, side) = (place.in_region[axis], place.pass.side);
            let end = (high.saturating_sub(origin).div_ceil(side) as usize).min(place.blocks[axis]);
            (low.saturating_sub(origin) / side).min(end as u32) as usize..end
        };
        [range(left, right, 0), range(top, bottom, 1)]
    }

    /// Whether what is seen lies in front of everything in a rectangle of the region's pixels that is not nearer than `nearest`.
    #[inline(always)]
    pub(super) fn hides(&self, place: &Place<'_>, nearest: f32, pixels: [u16; 4]) -> bool {
        let [columns, rows] = Tile::blocks_of(place, pixels);
        let mut behind = true;
        for row in &self.farthest[rows] {
            for &farthest in &row[columns.clone()] {
                behind &= nearest > farthest;
            }
        }
        behind
    }

    /// Draws an opaque ball.
    #[inline(always)]
    pub(super) fn draw_sphere<const PARALLEL: bool>(
        &mut self,
        place: &Place<'_>,
        candidate: &Candidate,
        (solid, color): (&Sphere, Srgb8),
    ) {
        let (near, surface, colors) = (place.near, BallSurface { center: solid.center }, [color; 2]);
        if candidate.nearest > near {
            let drawn = Drawn::<_, PARALLEL> { solid: Beyond(*solid), near };
            self.draw(place, candidate, &[true; LANES], &Told::<_, _, PARALLEL> { drawn, surface, colors });
        } else {
            let drawn = Drawn::<_, PARALLEL> { solid: *solid, near };
            self.draw(place, candidate, &[true; LANES], &Told::<_, _, PARALLEL> { drawn, surface, colors });
        }
    }

    /// Draws an opaque stick.
    #[inline(always)]
    pub(super) fn draw_cylinder<const PARALLEL: bool>(
        &mut self,
        place: &Place<'_>,
        candidate: &Candidate,
        (solid, colors): (&Cylinder, [Srgb8; 2]),
    ) {
        let (near, surface) = (place.near, StickSurface::new(solid));
        if solid.caps == FLAT_CAPS {
            let surface = StickSurface { ends: NO_ENDS, ..surface };
            let drawn = Drawn::<_, PARALLEL> { solid: Flat(*solid), near };
            self.draw(place, candidate, &[true; LANES], &Told::<_, _, PARALLEL> { drawn, surface, colors });
        } else {
            let drawn = Drawn::<_, PARALLEL> { solid: *solid, near };
            self.draw(place, candidate, &[true; LANES], &Told::<_, _, PARALLEL> { drawn, surface, colors });
        }
    }

    /// Draws an opaque ring.
    #[inline(always)]
    pub(super) fn draw_torus<const PARALLEL: bool>(
        &mut self,
        place: &Place<'_>,
        candidate: &Candidate,
        (solid, color): (&Torus, Srgb8),
    ) {
        let drawn = Drawn::<_, PARALLEL> { solid: *solid, near: place.near };
        let (surface, colors) = (RingSurface::new(solid), [color; 2]);
        self.draw(place, candidate, &[true; LANES], &Told::<_, _, PARALLEL> { drawn, surface, colors });
    }

    /// Draws a cone or triangle, `number` of `solids`, all opaque and without lines.
    #[inline(always)]
    pub(super) fn draw_other<const PARALLEL: bool>(
        &mut self,
        place: &Place<'_>,
        (solids, number): (&Solids, u32),
        candidate: &Candidate,
    ) {
        let (near, mask, surface, colors) = (place.near, [true; LANES], Untold, [UNTOLD; 2]);
        match solids.primitive(number as usize) {
            Primitive::Cone(i) => {
                let drawn = Drawn::<_, PARALLEL> { solid: solids.cones[i], near };
                self.draw(place, candidate, &mask, &Told::<_, _, PARALLEL> { drawn, surface, colors });
            }
            Primitive::Triangle(i) => {
                let drawn = Drawn::<_, PARALLEL> { solid: solids.triangles[i], near };
                self.draw(place, candidate, &mask, &Told::<_, _, PARALLEL> { drawn, surface, colors });
            }
            Primitive::Sphere(_) | Primitive::Cylinder(_) | Primitive::Torus(_) => {}
        }
    }

    #[inline(always)]
    fn draw_candidate<const PARALLEL: bool>(
        &mut self,
        place: &Place<'_>,
        (solids, number): (&Solids, usize),
        candidate: &Candidate,
        mask: &[bool; LANES],
    ) {
        let near = place.near;
        match solids.primitive(number) {
            Primitive::Sphere(i) => {
                let of = |solid| Drawn::<_, PARALLEL> { solid, near };
                let solid = solids.spheres[i];
                self.draw_lined(place, (solids, number), candidate, mask, |outline| {
                    of(outline.map_or(solid, |o| o.sphere(&solid)))
                });
            }
            Primitive::Cylinder(i) => {
                let solid = solids.cylinders[i];
                let grown = |outline: Option<&Outline>| outline.map_or(solid, |outline| outline.cylinder(&solid));
                if solid.caps == FLAT_CAPS {
                    let of = |outline: Option<&Outline>| Drawn::<_, PARALLEL> { solid: Flat(grown(outline)), near };
                    self.draw_lined(place, (solids, number), candidate, mask, of);
                } else {
                    let of = |outline: Option<&Outline>| Drawn::<_, PARALLEL> { solid: grown(outline), near };
                    self.draw_lined(place, (solids, number), candidate, mask, of);
                }
            }
            Primitive::Cone(i) => {
                let of = |solid| Drawn::<_, PARALLEL> { solid, near };
                let solid = solids.cones[i];
                self.draw_lined(place, (solids, number), candidate, mask, |outline| {
                    of(outline.map_or(solid, |o| o.cone(&solid)))
                });
            }
            Primitive::Torus(i) => {
                let of = |solid| Drawn::<_, PARALLEL> { solid, near };
                let solid = solids.tori[i];
                self.draw_lined(place, (solids, number), candidate, mask, |outline| {
                    of(outline.map_or(solid, |o| o.torus(&solid)))
                });
            }
            Primitive::Triangle(i) => {
                self.draw(place, candidate, mask, &Drawn::<_, PARALLEL> { solid: solids.triangles[i], near });
            }
        }
    }

    /// Draws a primitive, with its line where there are lines; `of` makes it, grown by the line if it is given one.
    #[inline(always)]
    fn draw_lined<D: DepthAt>(
        &mut self,
        place: &Place<'_>,
        (solids, number): (&Solids, usize),
        candidate: &Candidate,
        mask: &[bool; LANES],
        of: impl Fn(Option<&Outline>) -> D,
    ) {
        match place.outline {
            None => self.draw(place, candidate, mask, &of(None)),
            Some(outline) => {
                let behind = outline.behind(solids, number);
                let lined = Outlined { own: of(None), grown: of(Some(outline)), behind };
                self.draw(place, candidate, mask, &lined);
            }
        }
    }

    /// The depths of all samples, through the rows of blocks.
    #[inline(always)]
    pub(super) fn depths(&self) -> &[f32] {
        self.t.as_flattened().as_flattened()
    }

    /// Sees a primitive at this depth in sample `at`, counted through the rows of blocks, if it is nearer than what was seen there; what it
    /// looks like there is told.
    #[inline(always)]
    pub(super) fn see_at(&mut self, at: usize, (t, index): (f32, u32), (normal, color): ([f32; 3], u32)) {
        let (block, lane) = (at / LANES % (SIDE * SIDE), at % LANES);
        let depths = &mut self.t.as_flattened_mut()[block];
        let seen = &mut self.index.as_flattened_mut()[block][lane];
        let before = depths[lane];
        if t < before || (t == before && index < *seen) {
            (depths[lane], *seen) = (t, index);
            let normals = &mut self.normal.as_flattened_mut()[block];
            (normals[0][lane], normals[1][lane], normals[2][lane]) = (normal[0], normal[1], normal[2]);
            self.color.as_flattened_mut()[block][lane] = color;
            self.touched.as_flattened_mut()[block] = true;
            let empty = &mut self.empty.as_flattened_mut()[block];
            *empty -= u8::from(before == f32::INFINITY);
            let farthest = &mut self.farthest.as_flattened_mut()[block];
            if *empty == 0 && (before == *farthest || *farthest == f32::INFINITY) {
                *farthest = farthest_of(depths);
            }
        }
    }

    #[inline(always)]
    fn draw(&mut self, place: &Place<'_>, candidate: &Candidate, mask: &[bool; LANES], drawn: &impl DepthAt) {
        let side = place.pass.side;
        let [columns, rows] = Tile::blocks_of(place, candidate.pixels);
        let per_block = 1.0 / side as f32;
        for row in rows {
            let y = (place.corner[1] + row as u32 * side) as f32;
            let [from, to] = candidate.span(y, y + side as f32).map(|x| (x - place.corner[0] as f32) * per_block);
            // `as` clamps, and makes 0 of NaN.
            let start = columns.start.max(from as usize);
            let end = columns.end.min(if to < 0.0 { 0 } else { to as usize + 1 });
            if start >= end {
                continue;
            }
            let v = place.v(row);
            for column in start..end {
                if candidate.nearest <= self.farthest[row][column] {
                    self.draw_block([row, column], candidate.index, mask, [&place.u(column), &v], drawn);
                }
            }
        }
    }

    #[inline(always)]
    fn draw_block<D: DepthAt>(
        &mut self,
        [row, column]: [usize; 2],
        index: u32,
        mask: &[bool; LANES],
        [u, v]: [&Lanes; 2],
        drawn: &D,
    ) {
        let (mut new, mut what) = (drawn.ts(u, v), [index; LANES]);
        for lane in 0..LANES {
            new[lane] = if mask[lane] { new[lane] } else { f32::INFINITY };
        }
        if D::OUTLINED {
            for lane in 0..LANES {
                let t = drawn.middle(u[lane], v[lane]);
                let beside = (new[lane] == f32::INFINITY) & mask[lane];
                new[lane] = if beside { t } else { new[lane] };
                what[lane] = if beside { index | RIM } else { index };
            }
        }
        let t = &mut self.t[row][column];
        let seen = &mut self.index[row][column];
        let mut closer = [0u32; LANES];
        let mut any = 0u32;
        for lane in 0..LANES {
            // An empty sample has index 0: nothing ties with it.
            let is_closer = (new[lane] < t[lane]) | ((new[lane] == t[lane]) & (what[lane] < seen[lane]));
            closer[lane] = if is_closer { u32::MAX } else { 0 };
            any |= closer[lane];
        }
        if any != 0 {
            if D::TOLD {
                let (looks, colors) = drawn.looks(u, v, &new);
                let (normal, color) = (&mut self.normal[row][column], &mut self.color[row][column]);
                for lane in 0..LANES {
                    for part in 0..3 {
                        normal[part][lane] = if closer[lane] != 0 { looks[part][lane] } else { normal[part][lane] };
                    }
                    color[lane] = if closer[lane] != 0 { colors[lane] } else { color[lane] };
                }
            }
            for lane in 0..LANES {
                t[lane] = if closer[lane] != 0 { new[lane] } else { t[lane] };
                seen[lane] = if closer[lane] != 0 { what[lane] } else { seen[lane] };
            }
            self.touched[row][column] = true;
            self.farthest[row][column] = farthest_of(t);
            let mut empty = 0;
            for t in t {
                empty += u32::from(*t == f32::INFINITY);
            }
            self.empty[row][column] = empty as u8;
        }
    }
}

/// The greatest of the depths of a block.
#[inline(always)]
fn farthest_of(t: &Lanes) -> f32 {
    // Halved again and again: each step is one instruction for all.
    let (mut eight, mut four, mut two) = ([0.0f32; 8], [0.0f32; 4], [0.0f32; 2]);
    for lane in 0..8 {
        eight[lane] = if t[lane] > t[lane + 8] { t[lane] } else { t[lane + 8] };
    }
    for lane in 0..4 {
        four[lane] = if eight[lane] > eight[lane + 4] { eight[lane] } else { eight[lane + 4] };
    }
    for lane in 0..2 {
        two[lane] = if four[lane] > four[lane + 2] { four[lane] } else { four[lane + 2] };
    }
    if two[0] > two[1] { two[0] } else { two[1] }
}
