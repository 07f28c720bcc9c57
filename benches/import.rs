//! Reading from memory, in bytes and atoms per second, for each format.

#![allow(clippy::expect_used, reason = "a bench that cannot read has nothing to measure")]

mod common;

use ballstick::import::{ImportOptions, read_bytes};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

/// A format's extension and what writes it.
type Writer = (&'static str, fn(usize) -> Vec<u8>);

fn import(c: &mut Criterion) {
    let formats: [Writer; 11] = [
        ("pdb", |size| common::written("pdb", size)),
        ("cif", |size| common::written("cif", size)),
        ("xyz", |size| common::written("xyz", size)),
        ("sdf", |size| common::written("sdf", size)),
        ("sdf-v3000", |size| common::written("sdf-v3000", size)),
        ("mol2", |size| common::written("mol2", size)),
        ("json", |size| common::written("json", size)),
        ("bcif", common::bcif::file),
        ("poscar", |size| common::poscar(size).into_bytes()),
        ("cube", |size| common::cube(size).into_bytes()),
        ("gro", |size| common::gro(size).into_bytes()),
    ];
    let options = ImportOptions::default();
    for (name, write) in formats {
        let mut group = c.benchmark_group(format!("import_{name}"));
        for size in common::SIZES {
            let text = write(size);
            let file = format!("bench.{name}");
            let read = || read_bytes(black_box(text.as_slice()), &file, &options).expect("a file without errors");
            assert_eq!(read().records.iter().map(|record| record.atom_count()).sum::<usize>(), size, "{name}");
            group.sample_size(if size > 100_000 { 10 } else { 20 });
            for (unit, throughput) in
                [("bytes", Throughput::Bytes(text.len() as u64)), ("atoms", Throughput::Elements(size as u64))]
            {
                group.throughput(throughput);
                group.bench_function(BenchmarkId::new(unit, size), |b| b.iter(read));
            }
        }
        group.finish();
    }
}

criterion_group!(benches, import);
criterion_main!(benches);
