//! Bonds in atoms per second: from distances (atoms of no known residue), and from the dictionary (protein); and what it
//! takes to look components up.

#![allow(clippy::expect_used, reason = "without the file there is nothing to measure")]

mod common;

use ballstick::bonds::{BondMode, BondOptions, find};
use ballstick::structure::{AtomRecord, Diagnostics, Structure, StructureBuilder};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use std::hint::black_box;

/// Å between molecules: caffeine is 8 Å long.
const SPACING: f64 = 12.0;

/// Copies of caffeine side by side, about so many atoms: every bond order is to be found.
fn caffeine(count: usize) -> Structure {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/caffeine.sdf");
    let document = ballstick::import::read_path(&path, &ballstick::import::ImportOptions::default());
    let one = document.map(|mut document| document.records.remove(0)).expect("data/caffeine.sdf");
    let copies = count.div_ceil(one.atom_count());
    let edge = (copies as f64).cbrt().ceil() as usize;
    let mut builder = StructureBuilder::new();
    for copy in 0..copies {
        let shift = [copy % edge, copy / edge % edge, copy / edge / edge].map(|along| along as f64 * SPACING);
        for atom in 0..one.atom_count() {
            let position = one.positions().get(atom) + DVec3::from(shift);
            builder.push_atom(&AtomRecord { element: one.elements()[atom], position, ..AtomRecord::default() });
        }
    }
    builder.build(&mut Diagnostics::default())
}

fn bonds(c: &mut Criterion) {
    let mut group = c.benchmark_group("bonds");
    let perceive = BondOptions { mode: BondMode::Perceive, ..BondOptions::default() };
    for size in common::SIZES {
        let structure = common::structure(size);
        group.throughput(Throughput::Elements(size as u64));
        group.sample_size(if size > 100_000 { 10 } else { 20 });
        group.bench_function(BenchmarkId::new("distance", size), |b| {
            b.iter(|| find(black_box(&structure), 0, &BondOptions::default()));
        });
        let structure = common::protein(size);
        group.bench_function(BenchmarkId::new("dictionary", size), |b| {
            b.iter(|| find(black_box(&structure), 0, &BondOptions::default()));
        });
        let molecules = caffeine(size);
        group.throughput(Throughput::Elements(molecules.atom_count() as u64));
        group.bench_function(BenchmarkId::new("caffeine", size), |b| {
            b.iter(|| find(black_box(&molecules), 0, &perceive));
        });
    }
    group.finish();
}

criterion_group!(benches, bonds);
criterion_main!(benches);
