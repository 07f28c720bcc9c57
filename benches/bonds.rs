//! Bonds in atoms per second: from distances (atoms of no known residue), and from the dictionary (protein); and what it
//! takes to look components up.

mod common;

use ballstick::bonds::{BondOptions, find};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

fn bonds(c: &mut Criterion) {
    let mut group = c.benchmark_group("bonds");
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
    }
    group.finish();
}

criterion_group!(benches, bonds);
criterion_main!(benches);
