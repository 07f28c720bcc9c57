//! What every sample of a tile sees: a small depth buffer, filled front to back.
//!
//! A tile is 32 × 32 blocks of [`LANES`] samples. Each block knows the depth of its farthest sample, so that what lies behind
//! it is left out at once. Ties in depth go to the first primitive, as in the reference.

use super::binning::Candidate;
use super::intersect::{
    FLAT_CAPS, cone_middle_t, cone_t, cylinder_middle_t, cylinder_t, flat_cylinder_middle_t, flat_cylinder_t,
    sphere_middle_t, sphere_t, torus_middle_t, torus_t, triangle_t,
};
use super::lanes::{LANES, Lanes, Pass};
use crate::render::outline::{Outline, RIM};
use crate::render::solids::{Cone, Cylinder, Primitive, Solids, Sphere, Torus, Triangle};
use crate::scene::{PixelGrid, Ray};
use glam::Vec3;

/// Blocks on a side of a tile, at most.
pub(super) const SIDE: usize = 32;

/// The depth of a primitive along the ray of plane coordinates. (A trait, not a closure: it must be inlined wherever it is used.)
trait DepthAt {
    /// Whether it has a line around it.
    const OUTLINED: bool = false;

    fn t(&self, u: f32, v: f32) -> f32;

    /// Midway through it.
    fn middle(&self, _u: f32, _v: f32) -> f32 {
        f32::INFINITY
    }
}

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
    fn middle(&self, u: f32, v: f32) -> f32 {
        self.grown.middle(u, v) + self.behind
    }
}

/// A primitive seen with parallel rays (`PARALLEL`) or in perspective.
struct Drawn<S, const PARALLEL: bool> {
    solid: S,
    near: f32,
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

/// A cylinder with two flat caps: less to find out.
struct Flat(Cylinder);

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
pub(super) struct Tile {
    pub(super) t: [[Lanes; SIDE]; SIDE],
    /// Marked with [`RIM`] where it is the primitive's line.
    pub(super) index: [[[u32; LANES]; SIDE]; SIDE],
    /// The farthest depth of each block; infinity while a sample of it is empty.
    farthest: [[f32; SIDE]; SIDE],
    /// Whether anything is seen in each block.
    pub(super) touched: [[bool; SIDE]; SIDE],
}

impl Tile {
    pub(super) fn new() -> Box<Tile> {
        Box::new(Tile {
            t: [[[f32::INFINITY; LANES]; SIDE]; SIDE],
            index: [[[0; LANES]; SIDE]; SIDE],
            farthest: [[f32::INFINITY; SIDE]; SIDE],
            touched: [[false; SIDE]; SIDE],
        })
    }

    /// Finds what is seen; `candidates` are front to back.
    #[inline(always)]
    pub(super) fn see(&mut self, place: &Place<'_>, solids: &Solids, candidates: &[Candidate]) {
        self.t.as_flattened_mut().fill([f32::INFINITY; LANES]);
        self.index.as_flattened_mut().fill([0; LANES]);
        self.farthest = [[f32::INFINITY; SIDE]; SIDE];
        self.touched = [[false; SIDE]; SIDE];
        for (drawn, candidate) in candidates.iter().enumerate() {
            if drawn % 16 == 15 && candidate.nearest > self.farthest(place) {
                break; // the rest is behind everything
            }
            let mut mask = [true; LANES];
            if solids.see_through {
                let drawn = |sample| solids.is_drawn(candidate.index as usize, sample, place.pass.samples);
                mask = place.pass.sample.map(drawn);
            }
            if place.grid.orthographic {
                self.draw_candidate::<true>(place, solids, candidate, &mask);
            } else {
                self.draw_candidate::<false>(place, solids, candidate, &mask);
            }
        }
    }

    /// The farthest depth of the tile.
    #[inline(always)]
    fn farthest(&self, place: &Place<'_>) -> f32 {
        let rows = self.farthest[..place.blocks[1]].iter();
        rows.flat_map(|row| &row[..place.blocks[0]]).fold(0.0f32, |most, &t| if t > most { t } else { most })
    }

    #[inline(always)]
    fn draw_candidate<const PARALLEL: bool>(
        &mut self,
        place: &Place<'_>,
        solids: &Solids,
        candidate: &Candidate,
        mask: &[bool; LANES],
    ) {
        let near = place.near;
        match solids.primitive(candidate.index as usize) {
            Primitive::Sphere(i) => {
                let of = |solid| Drawn::<_, PARALLEL> { solid, near };
                let solid = solids.spheres[i];
                self.draw_lined((place, solids), candidate, mask, |outline| {
                    of(outline.map_or(solid, |o| o.sphere(&solid)))
                });
            }
            Primitive::Cylinder(i) => {
                let solid = solids.cylinders[i];
                let grown = |outline: Option<&Outline>| outline.map_or(solid, |outline| outline.cylinder(&solid));
                if solid.caps == FLAT_CAPS {
                    let of = |outline: Option<&Outline>| Drawn::<_, PARALLEL> { solid: Flat(grown(outline)), near };
                    self.draw_lined((place, solids), candidate, mask, of);
                } else {
                    let of = |outline: Option<&Outline>| Drawn::<_, PARALLEL> { solid: grown(outline), near };
                    self.draw_lined((place, solids), candidate, mask, of);
                }
            }
            Primitive::Cone(i) => {
                let of = |solid| Drawn::<_, PARALLEL> { solid, near };
                let solid = solids.cones[i];
                self.draw_lined((place, solids), candidate, mask, |outline| {
                    of(outline.map_or(solid, |o| o.cone(&solid)))
                });
            }
            Primitive::Torus(i) => {
                let of = |solid| Drawn::<_, PARALLEL> { solid, near };
                let solid = solids.tori[i];
                self.draw_lined((place, solids), candidate, mask, |outline| {
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
        (place, solids): (&Place<'_>, &Solids),
        candidate: &Candidate,
        mask: &[bool; LANES],
        of: impl Fn(Option<&Outline>) -> D,
    ) {
        match place.outline {
            None => self.draw(place, candidate, mask, &of(None)),
            Some(outline) => {
                let behind = outline.behind(solids, candidate.index as usize);
                let lined = Outlined { own: of(None), grown: of(Some(outline)), behind };
                self.draw(place, candidate, mask, &lined);
            }
        }
    }

    #[inline(always)]
    fn draw(&mut self, place: &Place<'_>, candidate: &Candidate, mask: &[bool; LANES], drawn: &impl DepthAt) {
        let side = place.pass.side;
        let [left, top, right, bottom] = candidate.pixels.map(u32::from);
        let block = |pixel: u32, axis: usize| (pixel.saturating_sub(place.in_region[axis]) / side) as usize;
        let rows = block(top, 1)..(block(bottom - 1, 1) + 1).min(place.blocks[1]);
        let columns = [block(left, 0), (block(right - 1, 0) + 1).min(place.blocks[0])];
        let per_block = 1.0 / side as f32;
        for row in rows {
            let y = (place.corner[1] + row as u32 * side) as f32;
            let [from, to] = candidate.span(y, y + side as f32).map(|x| (x - place.corner[0] as f32) * per_block);
            // `as` clamps, and makes 0 of NaN.
            let start = columns[0].max(from as usize);
            let end = columns[1].min(if to < 0.0 { 0 } else { to as usize + 1 });
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
        let mut new = [0.0f32; LANES];
        let mut what = [index; LANES];
        for lane in 0..LANES {
            let t = drawn.t(u[lane], v[lane]);
            new[lane] = if mask[lane] { t } else { f32::INFINITY };
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
        let mut any = 0u32;
        for lane in 0..LANES {
            // An empty sample has index 0: nothing ties with it.
            let closer = (new[lane] < t[lane]) | ((new[lane] == t[lane]) & (what[lane] < seen[lane]));
            t[lane] = if closer { new[lane] } else { t[lane] };
            seen[lane] = if closer { what[lane] } else { seen[lane] };
            any |= u32::from(closer);
        }
        if any != 0 {
            self.touched[row][column] = true;
            let mut most = [0.0f32; 4];
            for (lane, &t) in t.iter().enumerate() {
                most[lane % 4] = if t > most[lane % 4] { t } else { most[lane % 4] };
            }
            self.farthest[row][column] = most[0].max(most[1]).max(most[2].max(most[3]));
        }
    }
}
