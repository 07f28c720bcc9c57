//! The cell list: all pairs of atoms within reach, in time proportional to the atoms.
//!
//! Atoms are put into cubic cells no smaller than the longest bond and sorted by cell, row by row. Only occupied cells
//! are kept, so that empty space costs nothing: a protein and one stray atom a million ångström away take the
//! memory of their atoms. A cell's partners are the rest of its row and the four rows ahead of it (half of all
//! neighbours, so every pair comes once). Walking the cells in order, each of these rows is found by a finger that
//! only moves forwards; no cell is looked up. Bonds of metals are longer than all others: where metals are few, they
//! look around themselves in cells that suit the other atoms.
//!
//! Limit: a cell with more than [`MOST_IN_CELL`] atoms is left out, as otherwise a pile of n atoms has n² pairs.

use super::rules::PairTable;
use crate::element::Element;
use crate::stop::Stop;
use glam::Vec3;
use rayon::prelude::*;

/// More atoms than this in one cell are no matter: the cells are 2–5 Å wide, and in such there are 2 to 15 atoms of a
/// protein, salt or metal, or some 30 of twenty superposed models.
const MOST_IN_CELL: usize = 64;
/// Bits of a cell number for each axis.
const AXIS_BITS: u32 = 21;
/// Cells along an axis, less the margin of one on both sides that keeps neighbours from running into the next row.
const MOST_CELLS: f32 = ((1u32 << AXIS_BITS) - 4) as f32;
/// Metals look around themselves where they are fewer than one atom in this many.
const FEW_METALS: usize = 8;
/// Cells in one piece of work.
const CELLS_PER_TASK: usize = 16_384;
/// Atoms in one piece of work.
const ATOMS_PER_TASK: usize = 65_536;
/// Distances computed at once.
const LANES: usize = 8;
/// The rows ahead of a cell, as steps in y and z.
const ROWS_AHEAD: [(i64, i64); 4] = [(1, 0), (-1, 1), (0, 1), (1, 1)];

/// An atom in the order of the cells.
#[derive(Debug, Clone, Copy)]
struct Slot {
    position: Vec3,
    atom: u32,
}

/// An occupied cell: its number, and where its slots are.
#[derive(Debug, Clone, Copy)]
struct Cell {
    key: u64,
    start: u32,
    end: u32,
}

/// The atoms near a cell, coordinate by coordinate.
#[derive(Default)]
struct Near {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    slot: Vec<u32>,
}

impl Near {
    fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
        self.slot.clear();
    }

    /// Fills the last block with points that are near nothing.
    fn pad(&mut self) {
        let length = self.slot.len().next_multiple_of(LANES);
        self.x.resize(length, f32::INFINITY);
        self.y.resize(length, f32::INFINITY);
        self.z.resize(length, f32::INFINITY);
    }
}

/// Atoms sorted by cell.
pub(super) struct Grid<'a> {
    table: &'a PairTable,
    slots: Vec<Slot>,
    species: Vec<u8>,
    cells: Vec<Cell>,
    low: Vec3,
    inverse_edge: f32,
    /// Whether the cells are too small for the bonds of metals.
    metals_apart: bool,
}

impl<'a> Grid<'a> {
    /// Sorts the atoms for which `takes_part` holds and whose position is finite.
    pub(super) fn new(
        positions: &[Vec3],
        elements: &[Element],
        table: &'a PairTable,
        takes_part: impl Fn(usize) -> bool + Sync,
    ) -> Grid<'a> {
        let takes_part = |atom: usize| positions[atom].is_finite() && takes_part(atom);
        let taken: Vec<Slot> = (0..positions.len())
            .into_par_iter()
            .with_min_len(ATOMS_PER_TASK)
            .filter(|&atom| takes_part(atom))
            .map(|atom| Slot { position: positions[atom], atom: atom as u32 }) // a structure has fewer than 2^32 atoms
            .collect();
        let of_slot = |slot: &Slot| {
            let is_metal = elements[slot.atom as usize].is_metal();
            (usize::from(is_metal), slot.position, slot.position)
        };
        let (metals, low, high) = taken.par_iter().with_min_len(ATOMS_PER_TASK).map(of_slot).reduce(
            || (0, Vec3::INFINITY, Vec3::NEG_INFINITY),
            |one, other| (one.0 + other.0, one.1.min(other.1), one.2.max(other.2)),
        );
        let metals_apart = metals * FEW_METALS < taken.len();
        // Halved first, so that the difference of two large numbers cannot overflow.
        let extent = if taken.is_empty() { 0.0 } else { (high * 0.5 - low * 0.5).max_element() };
        // Two atoms within reach must lie in touching cells in spite of rounding: one in a thousand for the division,
        // and two units of the last place of the farthest coordinate for the subtraction.
        let edge = table.longest(!metals_apart).max(1.0) * 1.001 + extent * 8e-7;
        let edge = edge.max(extent / (0.5 * MOST_CELLS));
        let mut grid = Grid {
            table,
            slots: taken,
            species: Vec::new(),
            cells: Vec::new(),
            low,
            inverse_edge: edge.recip(),
            metals_apart,
        };
        grid.sort();
        let species = |slot: &Slot| table.species(elements[slot.atom as usize]);
        grid.species = grid.slots.par_iter().with_min_len(ATOMS_PER_TASK).map(species).collect();
        grid
    }

    /// The cell of a point along each axis, 1 and up.
    fn cell_of(&self, position: Vec3) -> [u64; 3] {
        // Halved, as the extent is; casting saturates, whatever the numbers are.
        let cell = (position * 0.5 - self.low * 0.5) * (2.0 * self.inverse_edge);
        [cell.x, cell.y, cell.z].map(|along| along.clamp(0.0, MOST_CELLS) as u64 + 1)
    }

    /// Sorts the slots by cell and fills the list of cells.
    fn sort(&mut self) {
        let slots = self.slots.par_iter().with_min_len(ATOMS_PER_TASK);
        let keys: Vec<u64> = slots.map(|slot| key(self.cell_of(slot.position))).collect();
        let mask = (1u64 << AXIS_BITS) - 1;
        let most = |one: [u64; 3], other: [u64; 3]| [0, 1, 2].map(|axis| one[axis].max(other[axis]));
        let along = |&key: &u64| [key & mask, (key >> AXIS_BITS) & mask, key >> (2 * AXIS_BITS)];
        let dims = keys.par_iter().with_min_len(ATOMS_PER_TASK).map(along).reduce(|| [0; 3], most);
        let volume = dims.iter().try_fold(1u64, |volume, &dim| volume.checked_mul(dim + 1)).unwrap_or(u64::MAX);
        let order: Vec<u32> = if volume <= 4 * keys.len() as u64 + 4096 {
            let row = |key: u64| {
                ((key >> (2 * AXIS_BITS)) * (dims[1] + 1) + ((key >> AXIS_BITS) & mask)) * (dims[0] + 1) + (key & mask)
            };
            counting_sort(&keys, volume as usize, |key| row(key) as usize)
        } else {
            radix_sort(&keys)
        };
        let mut start = 0;
        while start < order.len() {
            let key = keys[order[start] as usize];
            let length = order[start..].iter().take_while(|&&slot| keys[slot as usize] == key).count();
            if length <= MOST_IN_CELL {
                self.cells.push(Cell { key, start: start as u32, end: (start + length) as u32 });
            }
            start += length;
        }
        let slots = &self.slots;
        let sorted = order.par_iter().with_min_len(ATOMS_PER_TASK).map(|&slot| slots[slot as usize]).collect();
        self.slots = sorted;
    }

    /// What `make` gives for every pair of atoms not farther apart than their longest bond: lower atom index, higher,
    /// distance.
    pub(super) fn pairs<T: Send>(&self, make: impl Fn(u32, u32, f32) -> Option<T> + Sync) -> Vec<T> {
        let mut pieces = self.pieces_of_pairs(make, &Stop::never());
        if pieces.len() <= 1 {
            return pieces.pop().unwrap_or_default();
        }
        let mut all = Vec::with_capacity(pieces.iter().map(Vec::len).sum());
        all.extend(pieces.into_iter().flatten());
        all
    }

    /// The same in pieces as they were found, unless it is given up.
    pub(super) fn pieces_of_pairs<T: Send>(
        &self,
        make: impl Fn(u32, u32, f32) -> Option<T> + Sync,
        stop: &Stop,
    ) -> Vec<Vec<T>> {
        let tasks = self.cells.len().div_ceil(CELLS_PER_TASK);
        let of_task = |task: usize| {
            let first = task * CELLS_PER_TASK;
            let last = (first + CELLS_PER_TASK).min(self.cells.len());
            let mut out = Vec::new();
            if stop.is_set() {
                return out;
            }
            self.pairs_of_cells(first, last, &make, &mut out);
            if self.metals_apart {
                self.pairs_of_metals(first, last, &make, &mut out);
            }
            out
        };
        if tasks <= 1 {
            return (0..tasks).map(of_task).collect();
        }
        (0..tasks).into_par_iter().map(of_task).collect()
    }

    fn pairs_of_cells<T>(
        &self,
        first: usize,
        last: usize,
        make: &impl Fn(u32, u32, f32) -> Option<T>,
        out: &mut Vec<T>,
    ) {
        let mut fingers = ROWS_AHEAD.map(|(dy, dz)| {
            let low = self.cells.get(first).map_or(0, |cell| shifted(cell.key, dy, dz));
            self.cells.partition_point(|cell| cell.key < low)
        });
        let mut near = Near::default();
        for (at, cell) in self.cells.iter().enumerate().take(last).skip(first) {
            near.clear();
            self.gather(cell, &mut near);
            if let Some(next) = self.cells.get(at + 1).filter(|next| next.key == cell.key + 1) {
                self.gather(next, &mut near);
            }
            for (finger, (dy, dz)) in fingers.iter_mut().zip(ROWS_AHEAD) {
                let low = shifted(cell.key, dy, dz);
                while self.cells.get(*finger).is_some_and(|ahead| ahead.key < low) {
                    *finger += 1;
                }
                for partner in self.cells[*finger..].iter().take(3).take_while(|partner| partner.key <= low + 2) {
                    self.gather(partner, &mut near);
                }
            }
            self.meet(cell, &mut near, make, out);
        }
    }

    /// Adds the atoms of a cell to those that are near.
    fn gather(&self, cell: &Cell, near: &mut Near) {
        for i in cell.start as usize..cell.end as usize {
            let position = self.slots[i].position;
            near.x.push(position.x);
            near.y.push(position.y);
            near.z.push(position.z);
            near.slot.push(i as u32);
        }
    }

    /// Pairs of the atoms of a cell, which are the first of those that are near, with all of these.
    fn meet<T>(&self, cell: &Cell, near: &mut Near, make: &impl Fn(u32, u32, f32) -> Option<T>, out: &mut Vec<T>) {
        near.pad();
        for (first, i) in (cell.start as usize..cell.end as usize).enumerate() {
            let (slot, species) = (self.slots[i], self.species[i]);
            if self.metals_apart && self.table.is_metal(species) {
                continue;
            }
            let row = self.table.row(species);
            let reach_squared = self.table.reach(species).powi(2) * 1.000_01;
            let block = first / LANES;
            let blocks = near.x.chunks_exact(LANES).zip(near.y.chunks_exact(LANES)).zip(near.z.chunks_exact(LANES));
            for (block, ((x, y), z)) in blocks.enumerate().skip(block) {
                // All lanes at once: the compiler makes vector instructions of this.
                let mut squared = [0.0f32; LANES];
                let mut hits = 0u32;
                for lane in 0..LANES {
                    let (dx, dy, dz) =
                        (x[lane] - slot.position.x, y[lane] - slot.position.y, z[lane] - slot.position.z);
                    squared[lane] = dx * dx + dy * dy + dz * dz;
                    hits |= u32::from(squared[lane] <= reach_squared) << lane;
                }
                while hits != 0 {
                    let lane = hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    let at = block * LANES + lane;
                    if at <= first {
                        continue; // the atom itself, or a pair of the own cell that has been
                    }
                    let j = near.slot[at] as usize;
                    let (other, kind) = (self.slots[j].atom, self.species[j]);
                    if squared[lane] <= row[usize::from(kind)] && !(self.metals_apart && self.table.is_metal(kind)) {
                        out.extend(make(slot.atom.min(other), slot.atom.max(other), squared[lane].sqrt()));
                    }
                }
            }
        }
    }

    /// Pairs of the metals in some cells with all atoms around, those with further metals once.
    fn pairs_of_metals<T>(
        &self,
        first: usize,
        last: usize,
        make: &impl Fn(u32, u32, f32) -> Option<T>,
        out: &mut Vec<T>,
    ) {
        for i in self.cells[first..last].iter().flat_map(|cell| cell.start..cell.end) {
            let (slot, species) = (self.slots[i as usize], self.species[i as usize]);
            if !self.table.is_metal(species) {
                continue;
            }
            let row = self.table.row(species);
            // Slack for the rounding of the sums below.
            let far = slot.position.abs().max_element();
            let reach = self.table.reach(species) * 1.001 + far * 2.4e-7;
            let (low, high) = (self.cell_of(slot.position - reach), self.cell_of(slot.position + reach));
            for (z, y) in (low[2]..=high[2]).flat_map(|z| (low[1]..=high[1]).map(move |y| (z, y))) {
                let (from, to) = (key([low[0], y, z]), key([high[0], y, z]));
                let at = self.cells.partition_point(|cell| cell.key < from);
                for j in self.cells[at..].iter().take_while(|cell| cell.key <= to).flat_map(|cell| cell.start..cell.end)
                {
                    let (other, kind) = (self.slots[j as usize], self.species[j as usize]);
                    let squared = slot.position.distance_squared(other.position);
                    let is_first = !self.table.is_metal(kind) || slot.atom < other.atom;
                    if squared <= row[usize::from(kind)] && is_first {
                        out.extend(make(slot.atom.min(other.atom), slot.atom.max(other.atom), squared.sqrt()));
                    }
                }
            }
        }
    }
}

/// The number of a cell: in the order of z, y, x.
fn key([x, y, z]: [u64; 3]) -> u64 {
    (z << (2 * AXIS_BITS)) | (y << AXIS_BITS) | x
}

/// The first of the three cells beside a cell in another row. Cells start at 1 along every axis: nothing is borrowed.
fn shifted(key: u64, dy: i64, dz: i64) -> u64 {
    key.wrapping_add_signed((dz << (2 * AXIS_BITS)) + (dy << AXIS_BITS) - 1)
}

/// The numbers 0, 1, … in the order of their keys, equal ones as they were.
fn counting_sort(keys: &[u64], bins: usize, bin: impl Fn(u64) -> usize) -> Vec<u32> {
    let mut start = vec![0u32; bins + 1];
    for &key in keys {
        start[bin(key) + 1] += 1;
    }
    for i in 1..start.len() {
        start[i] += start[i - 1];
    }
    let mut order = vec![0u32; keys.len()];
    for (number, &key) in keys.iter().enumerate() {
        let slot = &mut start[bin(key)];
        order[*slot as usize] = number as u32;
        *slot += 1;
    }
    order
}

/// Bits of a digit of [`radix_sort`]: its counts stay in the nearest cache.
const DIGIT_BITS: u32 = 11;

/// The same for keys of any size: digit after digit, without those that are the same in all keys.
fn radix_sort(keys: &[u64]) -> Vec<u32> {
    let mut order: Vec<(u64, u32)> = keys.iter().zip(0..).map(|(&key, number)| (key, number)).collect();
    let first = keys.first().copied().unwrap_or(0);
    let mut varied = keys.iter().fold(0, |varied, key| varied | (key ^ first));
    let mut next = vec![(0, 0); keys.len()];
    while varied != 0 {
        let shift = varied.trailing_zeros();
        let mask = (1u64 << DIGIT_BITS) - 1;
        let digit = |key: u64| ((key >> shift) & mask) as usize;
        let mut start = [0u32; 1 << DIGIT_BITS];
        for &(key, _) in &order {
            start[digit(key)] += 1;
        }
        let mut sum = 0;
        for start in &mut start {
            sum += std::mem::replace(start, sum);
        }
        for &entry in &order {
            let slot = &mut start[digit(entry.0)];
            next[*slot as usize] = entry;
            *slot += 1;
        }
        std::mem::swap(&mut order, &mut next);
        varied &= !(mask << shift);
    }
    order.into_iter().map(|(_, number)| number).collect()
}

#[cfg(test)]
mod tests {
    use super::super::BondOptions;
    use super::*;

    fn noise(seed: &mut u64) -> f32 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 40) as f32 / (1u64 << 24) as f32
    }

    fn compare_with_all_pairs(positions: &[Vec3], symbols: &[&str]) {
        let elements: Vec<Element> =
            (0..positions.len()).map(|i| Element::from_symbol(symbols[i % symbols.len()]).unwrap()).collect();
        let table = PairTable::new(&elements, &BondOptions::default());
        let grid = Grid::new(positions, &elements, &table, |_| true);
        let mut got = grid.pairs(|a, b, _| Some((a, b)));
        got.sort_unstable();
        let mut expected = Vec::new();
        for i in 0..positions.len() {
            for j in i + 1..positions.len() {
                let limit = table.row(table.species(elements[i]))[usize::from(table.species(elements[j]))];
                if positions[i].distance_squared(positions[j]) <= limit {
                    expected.push((i as u32, j as u32));
                }
            }
        }
        assert!(!expected.is_empty());
        assert_eq!(got, expected);
    }

    #[test]
    fn dense_and_scattered_atoms_give_the_pairs_of_the_double_loop() {
        let mut seed = 1;
        let mut cloud = |count: usize, size: f32| -> Vec<Vec3> {
            (0..count).map(|_| Vec3::new(noise(&mut seed), noise(&mut seed), noise(&mut seed)) * size).collect()
        };
        let dense = cloud(1500, 22.0);
        compare_with_all_pairs(&dense, &["C", "H", "O", "N", "S"]);
        let few_metals =
            ["C", "C", "H", "H", "O", "N", "H", "K", "C", "O", "C", "C", "H", "H", "O", "N", "H", "S", "Fe"];
        compare_with_all_pairs(&dense, &few_metals);
        compare_with_all_pairs(&dense, &["Na", "Cl"]);
        let mut scattered = cloud(500, 12.0);
        scattered.extend(cloud(500, 12.0).iter().map(|point| *point + Vec3::new(9e4, -4e4, 2e3)));
        compare_with_all_pairs(&scattered, &["C", "N"]);
        compare_with_all_pairs(&scattered, &few_metals);
    }

    #[test]
    fn digits_sort_as_whole_keys_do_and_equal_ones_stay_in_order() {
        let mut seed = 7;
        for (count, shift) in [(0, 0), (1, 5), (3000, 40), (3000, 0)] {
            let keys: Vec<u64> =
                (0..count).map(|_| u64::from((noise(&mut seed) * 5e3) as u32 % 1500) << shift).collect();
            let mut expected: Vec<u32> = (0..count).collect();
            expected.sort_by_key(|&number| keys[number as usize]);
            assert_eq!(radix_sort(&keys), expected);
        }
    }

    #[test]
    fn numbers_at_the_ends_of_f32_are_harmless() {
        let elements = vec![Element::C; 6];
        let table = PairTable::new(&elements, &BondOptions::default());
        let far = f32::MAX;
        let points = [
            Vec3::splat(far),
            Vec3::splat(-far),
            Vec3::ZERO,
            Vec3::new(1.5, 0.0, 0.0),
            Vec3::NAN,
            Vec3::new(0.0, f32::INFINITY, 0.0),
        ];
        let pairs = Grid::new(&points, &elements, &table, |_| true).pairs(|a, b, _| Some((a, b)));
        assert_eq!(pairs, [(2, 3)]);
    }
}
