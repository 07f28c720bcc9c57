//! Rays of many points along one direction, and which of them something stands in the way of.
//!
//! The other way round than one asks for a ray: all points that ask are sorted into cells across the direction, and each
//! primitive asks the points under it, sixteen neighbours at a time, whether it hides the light from them: that needs no lists of primitives, and reads
//! what it asks from one place. A point that is hidden asks no more; where none of a patch of cells is left that something could hide, nothing is
//! looked at: of a large scene only what light reaches, however deep the rest is.
//!
//! Exact: each point is asked with its own place; the cells only say who is asked.

use super::behind::behind;
use super::bodies::{Axes, Places};
use super::clusters::{Cluster, Clusters, Leaf, Spans};
use super::lanes::{LANES, bits, low_of};
use super::simd::{Work, widest};
use crate::math::{max, min, whole};
use crate::render::solids::Solids;

// Stills of 100,000 and 1,000,000 atoms take the same time, within a noise of a seventh, with two to twelve points in a cell, with half and twice
// the widths, and with half the cells; patches of half the width take a fifth longer, of twice the width as long.

/// Least width of a patch in mean radii: a cluster covers some four to nine.
const PATCH: f32 = 10.0;

/// Points in a cell, if they were spread evenly over all.
const POINTS: f32 = 6.0;

/// Least width of a cell in mean radii.
const LEAST_WIDTH: f32 = 0.5;

/// Most width of a cell in mean radii.
const MOST_WIDTH: f32 = 4.0;

/// No more cells than so many for a point, however the scene is spread out.
const MOST_CELLS: f32 = 4.0;

/// So many points and fewer under a cluster ask its members, all sixteen at once; of more the members ask the points. A still of 1,000,000 atoms
/// takes as long with 16 and 48, and a twentieth longer with none.
const FEW: usize = 32;

/// Sixteen points along the axes of a direction, some of which ask.
#[derive(Clone, Copy)]
pub(super) struct Starts {
    pub(super) at: Places,
    /// Bits of those that ask.
    pub(super) asks: u32,
    /// Number of the first one.
    pub(super) first: u32,
}

/// Points along the axes of a direction, in the order in which they came.
pub(super) struct Gathered {
    starts: Vec<Starts>,
    /// How many ask.
    count: usize,
    /// Lowest and highest place along `right` and `up`.
    low: [f32; 2],
    high: [f32; 2],
}

impl Gathered {
    /// None yet; they will lie between these places along `right` and `up`, and take the room of others before.
    pub(super) fn new([low, high]: [[f32; 2]; 2], mut room: Vec<Starts>) -> Gathered {
        room.clear();
        Gathered { starts: room, count: 0, low, high }
    }

    /// The room they took.
    pub(super) fn into_room(self) -> Vec<Starts> {
        self.starts
    }

    /// Adds those that ask.
    #[inline(always)]
    pub(super) fn add(&mut self, starts: &Starts) {
        if starts.asks != 0 {
            self.count += starts.asks.count_ones() as usize;
            self.starts.push(*starts);
        }
    }
}

/// Room for the points of one direction after the other.
///
/// Points along the axes of a direction, sorted into cells. A hidden one has infinite height: nothing is above it any more.
#[derive(Default)]
pub(super) struct Rays {
    /// Of the first cell.
    corner: [f32; 2],
    per_angstrom: f32,
    /// Cells along `right` and `up`; rows are along `right`.
    size: [usize; 2],
    /// Where the points of each cell start; one more at the end.
    first: Vec<u32>,
    /// Cells of the points as they came.
    cells: Vec<[u32; LANES]>,
    /// After all points come sixteen hidden ones, so that as many can always be read; beyond, what was there before.
    x: Vec<f32>,
    y: Vec<f32>,
    height: Vec<f32>,
    /// The same as they were sorted: place, height, and the bits of the number.
    sorted: Vec<[f32; 4]>,
    /// A patch has `1 << patch` cells on a side.
    patch: u32,
    patches: [usize; 2],
    /// Not above the lowest point of each patch that is not hidden.
    lowest: Vec<f32>,
    /// Whether points of a patch were hidden since.
    is_stale: Vec<bool>,
}

/// A ball or stick as it looks along the direction.
struct Member {
    middle: [f32; 3],
    half: [f32; 3],
    /// See [`super::clusters::Seen::over`].
    over: f32,
    radius: f32,
}

/// Who hides the light: what the block of `clusters` has, seen along the direction as it looks from there.
pub(super) struct Hider<'a> {
    pub(super) clusters: &'a Clusters,
    pub(super) axes: Axes,
    /// Whether one of [`Clusters::others`] hides light at all.
    pub(super) counts: &'a (dyn Fn(usize) -> bool + 'a),
}

impl Rays {
    /// Takes these points in place of those before; what hides them has this mean radius.
    pub(super) fn set(&mut self, points: &Gathered, mean_radius: f32) {
        widest(Sort { rays: self, points, mean_radius });
    }

    /// Hides what lies in the shadow of these.
    pub(super) fn hide(&mut self, by: &Hider<'_>) {
        widest(Hide { rays: self, by });
    }

    /// Calls `see` with the numbers of those that nothing hides.
    pub(super) fn for_each_free(&self, mut see: impl FnMut(u32)) {
        for ([_, _, _, number], &height) in self.sorted.iter().zip(&self.height) {
            if height < f32::INFINITY {
                see(number.to_bits());
            }
        }
    }

    /// First and last cell along an axis that a stretch reaches into.
    #[inline(always)]
    fn cells(&self, axis: usize, low: f32, high: f32) -> [usize; 2] {
        let place = |x: f32| (max((x - self.corner[axis]) * self.per_angstrom, 0.0) as usize).min(self.size[axis] - 1);
        [place(low), place(high)]
    }

    /// Sorts by cells.
    #[inline(always)]
    fn sort(&mut self, points: &Gathered, mean_radius: f32) {
        let (count, low) = (points.count, points.low);
        let extent = [0, 1].map(|axis| max(points.high[axis] - low[axis], 1e-3));
        let each = 1.0 / count.max(1) as f32;
        let even = (extent[0] * extent[1] * POINTS * each).sqrt();
        let width = match mean_radius > 0.0 {
            true => even.clamp(LEAST_WIDTH * mean_radius, MOST_WIDTH * mean_radius),
            false => even,
        };
        // Nor too many cells, not even of a long thin scene.
        let width = max(width, (extent[0] * extent[1] * each / MOST_CELLS).sqrt());
        let width = max(width, max(extent[0], extent[1]) * each / MOST_CELLS);
        (self.corner, self.per_angstrom) = (low, 1.0 / width);
        self.size = extent.map(|extent| (extent * self.per_angstrom) as usize + 1);
        self.patch = (1..5).find(|&patch| width * (1 << patch) as f32 >= PATCH * mean_radius).unwrap_or(5);
        self.patches = self.size.map(|cells| (cells >> self.patch) + 1);
        self.first.clear();
        self.first.resize(self.size[0] * self.size[1] + 2, 0);
        self.cells.clear();
        for starts in &points.starts {
            let cells = self.cells_of(starts);
            let mut asks = starts.asks;
            while asks != 0 {
                let lane = asks.trailing_zeros() as usize % LANES;
                asks &= asks - 1;
                self.first[cells[lane] as usize + 2] += 1;
            }
            self.cells.push(cells);
        }
        let mut before = 0;
        for first in &mut self.first {
            before += *first;
            *first = before;
        }
        let room = count + LANES;
        for places in [&mut self.x, &mut self.y, &mut self.height] {
            places.resize(room.max(places.len()), 0.0);
        }
        self.sorted.resize(count, [0.0; 4]);
        self.height[count..room].fill(f32::INFINITY);
        for (starts, cells) in points.starts.iter().zip(&self.cells) {
            let mut asks = starts.asks;
            while asks != 0 {
                let lane = asks.trailing_zeros() as usize % LANES;
                asks &= asks - 1;
                // After this each cell's entry is where the next one's points start.
                let next = &mut self.first[cells[lane] as usize + 1];
                let at = *next as usize;
                *next += 1;
                // All of a point in one place: what is written all over the memory costs by the place.
                let number = f32::from_bits(starts.first + lane as u32);
                self.sorted[at] = [starts.at.x[lane], starts.at.y[lane], starts.at.height[lane], number];
            }
        }
        let places = self.x.iter_mut().zip(&mut self.y).zip(&mut self.height);
        for (((x, y), height), sorted) in places.zip(&self.sorted) {
            (*x, *y, *height) = (sorted[0], sorted[1], sorted[2]);
        }
        let patches = self.patches[0] * self.patches[1];
        self.lowest.clear();
        self.lowest.resize(patches, f32::NEG_INFINITY);
        self.is_stale.clear();
        self.is_stale.resize(patches, true);
    }

    /// The cells of some points.
    #[inline(always)]
    fn cells_of(&self, starts: &Starts) -> [u32; LANES] {
        let mut cells = [0; LANES];
        for (lane, cell) in cells.iter_mut().enumerate() {
            let column = (starts.at.x[lane] - self.corner[0]) * self.per_angstrom;
            let row = (starts.at.y[lane] - self.corner[1]) * self.per_angstrom;
            let column = min(max(column.floor(), 0.0), (self.size[0] - 1) as f32);
            let row = min(max(row.floor(), 0.0), (self.size[1] - 1) as f32);
            *cell = whole(row) * self.size[0] as u32 + whole(column);
        }
        cells
    }

    /// The lowest point under what lies here; infinite if nothing can be hidden.
    #[inline(always)]
    fn lowest_under(&mut self, [low_x, high_x]: [f32; 2], [low_y, high_y]: [f32; 2]) -> f32 {
        let end = [0, 1].map(|axis| self.corner[axis] + self.size[axis] as f32 / self.per_angstrom);
        if high_x < self.corner[0] || high_y < self.corner[1] || low_x > end[0] || low_y > end[1] {
            return f32::INFINITY;
        }
        let columns = self.cells(0, low_x, high_x).map(|cell| cell >> self.patch);
        let rows = self.cells(1, low_y, high_y).map(|cell| cell >> self.patch);
        let mut lowest = f32::INFINITY;
        for row in rows[0]..=rows[1] {
            for column in columns[0]..=columns[1] {
                let patch = row * self.patches[0] + column;
                if self.is_stale[patch] {
                    self.lowest[patch] = self.lowest_of(row, column);
                    self.is_stale[patch] = false;
                }
                lowest = min(self.lowest[patch], lowest);
            }
        }
        lowest
    }

    /// The lowest point of a patch.
    #[inline(always)]
    fn lowest_of(&self, row: usize, column: usize) -> f32 {
        let columns = [column << self.patch, ((column + 1) << self.patch).min(self.size[0])];
        let mut lowest = [f32::INFINITY; LANES];
        for row in row << self.patch..((row + 1) << self.patch).min(self.size[1]) {
            let [start, end] = columns.map(|column| self.first[row * self.size[0] + column] as usize);
            // Some points of the next cells with them: that only looks at more than need be.
            for at in (start..end).step_by(LANES) {
                let Some(heights) = self.height.get(at..).and_then(|h| h.first_chunk::<LANES>()) else { continue };
                for lane in 0..LANES {
                    lowest[lane] = min(heights[lane], lowest[lane]);
                }
            }
        }
        low_of(&lowest)
    }

    /// The points in some cells of a row.
    #[inline(always)]
    fn points(&self, row: usize, [left, right]: [usize; 2]) -> [usize; 2] {
        let row = row * self.size[0];
        [self.first[row + left] as usize, self.first[row + right + 1] as usize]
    }

    /// Hides what is under a cluster, which lies in this rectangle, below this height and above `lowest`.
    #[inline(always)]
    fn hide_under(&mut self, cluster: &Cluster, axes: &Axes, (rect, top, lowest): ([[f32; 2]; 2], f32, f32)) {
        let (mut under, mut count) = ([0u32; FEW], 0);
        let [columns, rows] = [0, 1].map(|axis| self.cells(axis, rect[axis][0], rect[axis][1]));
        for row in rows[0]..=rows[1] {
            let [start, end] = self.points(row, columns);
            for at in (start..end).step_by(LANES) {
                let Some(heights) = self.height.get(at..).and_then(|h| h.first_chunk::<LANES>()) else { continue };
                let mut low = bits(|lane| heights[lane] < top);
                if end - at < LANES {
                    low &= (1 << (end - at)) - 1;
                }
                if count + low.count_ones() as usize > FEW {
                    return self.hide_under_all(cluster, axes, lowest);
                }
                while low != 0 {
                    under[count] = at as u32 + low.trailing_zeros();
                    count += 1;
                    low &= low - 1;
                }
            }
        }
        if count > 0 {
            self.hide_few(cluster, axes, &under[..count]);
        }
    }

    /// Hides those of some points that are under the members of a cluster.
    #[inline(always)]
    fn hide_few(&mut self, cluster: &Cluster, axes: &Axes, points: &[u32]) {
        let (seen, squared) = (cluster.seen(axes), cluster.radius.map(|radius| radius * radius));
        for &point in points {
            let at = point as usize;
            let (x, y, height) = (self.x[at], self.y[at], self.height[at]);
            let hides = bits(|lane| {
                let (dx, dy) = (x - seen.middle[0][lane], y - seen.middle[1][lane]);
                let (hx, hy) = (seen.half[0][lane], seen.half[1][lane]);
                let nearest = min(max((dx * hx + dy * hy) * seen.over[lane], -1.0), 1.0);
                let (off_x, off_y) = (dx - nearest * hx, dy - nearest * hy);
                let is_near = off_x * off_x + off_y * off_y < squared[lane];
                is_near & (height < seen.middle[2][lane] + nearest * seen.half[2][lane])
            });
            if hides != 0 {
                self.height[at] = f32::INFINITY;
                let [column, row] =
                    [[x, 0.0], [y, 1.0]].map(|[place, axis]| self.cells(axis as usize, place, place)[0]);
                self.mark(row, [column; 2]);
            }
        }
    }

    /// Hides what is under the members of a cluster, where it lies above `lowest`.
    #[inline(always)]
    fn hide_under_all(&mut self, cluster: &Cluster, axes: &Axes, lowest: f32) {
        let seen = cluster.seen(axes);
        let (mut first, mut last, mut along_up) = ([0u32; LANES], [0u32; LANES], [0.0f32; LANES]);
        let (most, width) = (self.size.map(|cells| (cells - 1) as f32), 1.0 / self.per_angstrom);
        for lane in 0..LANES {
            let (y, up) = (seen.middle[1][lane] - self.corner[1], seen.half[1][lane]);
            let reach = up.abs() + cluster.radius[lane];
            let [bottom, top] = [y - reach, y + reach].map(|y| min(max((y * self.per_angstrom).floor(), 0.0), most[1]));
            (first[lane], last[lane]) = (whole(bottom), whole(top));
            // Along the axis, in halves of its length, for each ångström up.
            along_up[lane] = 1.0 / if up.abs() < 1e-6 { 1e-6f32 } else { up };
        }
        let mut rises = bits(|lane| seen.middle[2][lane] + seen.half[2][lane].abs() > lowest);
        let mut nth = 0;
        while rises != 0 {
            // The nth row of each member, and the columns of the part of its axis that comes near to it.
            let (mut left, mut right) = ([0u32; LANES], [0u32; LANES]);
            for lane in 0..LANES {
                let (x, radius) = (seen.middle[0][lane] - self.corner[0], cluster.radius[lane]);
                let bottom = (first[lane] + nth) as f32 * width - (seen.middle[1][lane] - self.corner[1]);
                let (a, b) = ((bottom - radius) * along_up[lane], (bottom + width + radius) * along_up[lane]);
                let (from, to) = (min(max(min(a, b), -1.0), 1.0), max(min(max(a, b), 1.0), -1.0));
                let (a, b) = (seen.half[0][lane] * from, seen.half[0][lane] * to);
                let (low, high) = (x + min(a, b) - radius, x + max(a, b) + radius);
                left[lane] = whole(min(max((low * self.per_angstrom).floor(), 0.0), most[0]));
                right[lane] = whole(min(max((high * self.per_angstrom).floor(), 0.0), most[0]));
            }
            let mut these = rises;
            while these != 0 {
                let lane = these.trailing_zeros() as usize % LANES;
                these &= these - 1;
                let member = Member {
                    middle: [seen.middle[0][lane], seen.middle[1][lane], seen.middle[2][lane]],
                    half: [seen.half[0][lane], seen.half[1][lane], seen.half[2][lane]],
                    over: seen.over[lane],
                    radius: cluster.radius[lane],
                };
                self.hide_in_row(&member, (first[lane] + nth) as usize, [left[lane] as usize, right[lane] as usize]);
            }
            nth += 1;
            rises &= bits(|lane| first[lane] + nth <= last[lane]);
        }
    }

    /// Hides what is under a ball or stick in some cells of a row.
    #[inline(always)]
    fn hide_in_row(&mut self, member: &Member, row: usize, columns: [usize; 2]) {
        let ([x, y, height], [hx, hy, rise]) = (member.middle, member.half);
        let squared = member.radius * member.radius;
        let [start, end] = self.points(row, columns);
        let mut hidden = 0;
        for at in (start..end).step_by(LANES) {
            let (Some(xs), Some(ys), Some(heights)) = (
                self.x.get(at..).and_then(|x| x.first_chunk::<LANES>()),
                self.y.get(at..).and_then(|y| y.first_chunk::<LANES>()),
                self.height.get_mut(at..).and_then(|h| h.first_chunk_mut::<LANES>()),
            ) else {
                return;
            };
            for lane in 0..LANES {
                let (dx, dy) = (xs[lane] - x, ys[lane] - y);
                let along = (dx * hx + dy * hy) * member.over;
                let nearest = min(max(along, -1.0), 1.0);
                let (off_x, off_y) = (dx - nearest * hx, dy - nearest * hy);
                let is_near = off_x * off_x + off_y * off_y < squared;
                let hides = is_near & (heights[lane] < height + nearest * rise);
                heights[lane] = if hides { f32::INFINITY } else { heights[lane] };
                hidden |= u32::from(hides);
            }
        }
        if hidden != 0 {
            self.mark(row, columns);
        }
    }

    /// Notes that points in some cells of a row were hidden.
    #[inline(always)]
    fn mark(&mut self, row: usize, [left, right]: [usize; 2]) {
        let row = (row >> self.patch) * self.patches[0];
        for column in left >> self.patch..=right >> self.patch {
            self.is_stale[row + column] = true;
        }
    }

    /// Hides what a primitive, asked by itself, hides of the points in a rectangle.
    #[inline(always)]
    fn hide_under_other(&mut self, others: &Solids, index: usize, axes: &Axes, rect: [[f32; 2]; 2]) {
        let [columns, rows] = [0, 1].map(|axis| self.cells(axis, rect[axis][0], rect[axis][1]));
        for row in rows[0]..=rows[1] {
            let [start, end] = self.points(row, columns);
            for at in (start..end).step_by(LANES) {
                let (mut position, mut free) = ([[0.0f32; LANES]; 3], [0u32; LANES]);
                for lane in 0..LANES.min(end - at) {
                    let height = self.height[at + lane];
                    if height < f32::INFINITY {
                        let place = axes.center + axes.right * self.x[at + lane] + axes.up * self.y[at + lane];
                        let place = place + axes.toward * height;
                        (position[0][lane], position[1][lane], position[2][lane]) = (place.x, place.y, place.z);
                        free[lane] = u32::MAX;
                    }
                }
                let asked = free;
                behind(others, index as u32, axes.toward, &position, &mut free);
                for lane in 0..LANES.min(end - at) {
                    if asked[lane] != 0 && free[lane] == 0 {
                        self.height[at + lane] = f32::INFINITY;
                    }
                }
            }
            self.mark(row, columns);
        }
    }
}

/// Points sorted into cells, as work for [`widest`].
struct Sort<'a> {
    rays: &'a mut Rays,
    points: &'a Gathered,
    mean_radius: f32,
}

impl Work for Sort<'_> {
    #[inline(always)]
    fn run(self) {
        self.rays.sort(self.points, self.mean_radius);
    }
}

/// What hides light, as work for [`widest`].
struct Hide<'a, 'b> {
    rays: &'a mut Rays,
    by: &'a Hider<'b>,
}

impl Work for Hide<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Hide { rays, by: Hider { clusters, axes, counts } } = self;
        let Some(top) = clusters.top() else { return };
        // Nodes whose boxes are still to be looked at.
        let mut waiting = vec![(top, 0usize)];
        while let Some((level, node)) = waiting.pop() {
            let Some((Spans { low, high, top }, mut left)) = clusters.spans(level, node, axes) else { continue };
            while left != 0 {
                let lane = left.trailing_zeros() as usize % LANES;
                left &= left - 1;
                let rect = [0, 1].map(|axis| [low[axis][lane], high[axis][lane]]);
                let lowest = rays.lowest_under(rect[0], rect[1]);
                if top[lane] <= lowest {
                    continue;
                }
                let child = node * LANES + lane;
                if level > 0 {
                    waiting.push((level - 1, child));
                    continue;
                }
                match clusters.leaf(child) {
                    Leaf::Cluster(cluster) => rays.hide_under(cluster, axes, (rect, top[lane], lowest)),
                    Leaf::Other(index) if counts(index) => rays.hide_under_other(clusters.others(), index, axes, rect),
                    Leaf::Other(_) => {}
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;
    use crate::render::cpu::intersect::primitive_t;
    use crate::render::sky::{across, directions};
    use crate::render::solids::Sphere;
    use crate::render::test_shapes::Random;
    use crate::render::test_solids::{Drawn, random_drawn};
    use crate::scene::Ray;
    use glam::{DVec3, Vec3};

    /// Balls, cones, rings and triangles all over a cube of 20 Å.
    fn some(seed: u64) -> Solids {
        let mut random = Random(seed);
        let mut solids = Solids::default();
        for i in 0..400 {
            let center = DVec3::from_array(std::array::from_fn(|_| random.between(-10.0, 10.0)));
            if i % 4 != 3 {
                solids.spheres.push(Sphere { center: center.as_vec3(), radius: random.between(0.2, 1.0) as f32 });
                solids.sphere_looks.push((crate::color::Srgb8::WHITE, i));
                continue;
            }
            match random_drawn(&mut random, i / 4 % 3, center) {
                Drawn::Cone(cone) => {
                    solids.cones.push(cone);
                    solids.cone_looks.push((crate::color::Srgb8::WHITE, i));
                }
                Drawn::Torus(torus) => {
                    solids.tori.push(torus);
                    solids.torus_looks.push((crate::color::Srgb8::WHITE, i));
                }
                Drawn::Triangle(triangle) => {
                    solids.triangles.push(triangle);
                    solids.triangle_looks.push(([crate::color::Srgb8::WHITE; 3], i));
                }
            }
        }
        solids
    }

    #[test]
    fn a_point_is_free_if_its_ray_meets_nothing() {
        let (solids, center) = (some(5), Vec3::new(1.0, -2.0, 0.5));
        let clusters = Clusters::new(&solids);
        assert!(clusters.others().len() > 90, "{}", clusters.others().len());
        let (mut random, mut rays) = (Random(6), Rays::default());
        let (mut free, mut hidden, mut differ) = (0, 0, 0);
        // Few points and many, so that cells are wide and narrow, in the room of those before.
        for (toward, count) in directions(24).into_iter().zip([40, 4000, 1, 700].into_iter().cycle()) {
            let [right, up] = across(toward);
            let axes = Axes { right, up, toward, center };
            // Outside of all balls, as is said to hold.
            let mut points = Vec::new();
            while points.len() < count {
                let p = Vec3::from_array(std::array::from_fn(|_| random.between(-12.0, 12.0) as f32));
                if solids.spheres.iter().all(|ball| ball.center.distance(p) > ball.radius + 1e-3) {
                    points.push(p);
                }
            }
            let bounds = Aabb { min: Vec3::splat(-12.0), max: Vec3::splat(12.0) };
            let mut gathered = Gathered::new(axes.extent(&bounds), Vec::new());
            for (packet, points) in points.chunks(LANES).enumerate() {
                let mut position = [[0.0; LANES]; 3];
                for (lane, p) in points.iter().enumerate() {
                    (position[0][lane], position[1][lane], position[2][lane]) = (p.x, p.y, p.z);
                }
                let (asks, first) = ((1 << points.len()) - 1, (packet * LANES) as u32);
                gathered.add(&Starts { at: axes.places(&position), asks, first });
            }
            rays.set(&gathered, clusters.mean_radius());
            rays.hide(&Hider { clusters: &clusters, axes, counts: &|_| true });
            let mut is_free = vec![false; count];
            rays.for_each_free(|number| is_free[number as usize] = true);
            for (p, is_free) in points.iter().zip(is_free) {
                let ray = Ray { origin: *p, direction: toward };
                let meets = (0..solids.len()).any(|index| primitive_t(&ray, &solids, index, 0.0).is_finite());
                (free, hidden) = (free + u32::from(is_free), hidden + u32::from(!is_free));
                differ += u32::from(meets == is_free);
            }
        }
        // At edges, by rounding.
        assert!(free > 5000 && hidden > 5000 && differ <= 3, "{free} {hidden} {differ}");
    }

    #[test]
    fn nobody_asks_and_nothing_hides() {
        let nothing = Clusters::new(&Solids::default());
        let axes = Axes { right: Vec3::X, up: Vec3::Y, toward: Vec3::Z, center: Vec3::ZERO };
        let mut rays = Rays::default();
        rays.set(&Gathered::new([[0.0; 2], [0.0; 2]], Vec::new()), 0.0);
        rays.hide(&Hider { clusters: &nothing, axes, counts: &|_| true });
        rays.for_each_free(|number| panic!("{number}"));
    }
}
