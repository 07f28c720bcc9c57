//! From a structure with bonds to a scene, and the hierarchy over it, in atoms per second.

mod common;

use ballstick::bonds::{BondOptions, assign};
use ballstick::render::field::Field;
use ballstick::render::hierarchy::Hierarchy;
use ballstick::render::solids::Solids;
use ballstick::scene::{Item, Scene, SceneOptions};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::Affine3A;
use std::hint::black_box;

fn scene(c: &mut Criterion) {
    let mut group = c.benchmark_group("scene");
    for size in common::SIZES {
        let structure = assign(common::structure(size), &BondOptions::default());
        let scene = Scene::new(&[Item::of(&structure)], &SceneOptions::default());
        let bounds = Solids::new(&scene, Affine3A::IDENTITY).bounds();
        group.throughput(Throughput::Elements(size as u64));
        group.sample_size(if size > 100_000 { 10 } else { 20 });
        group.bench_function(BenchmarkId::new("new", size), |b| {
            b.iter(|| Scene::new(&[Item::of(black_box(&structure))], &SceneOptions::default()));
        });
        group.bench_function(BenchmarkId::new("hierarchy", size), |b| b.iter(|| Hierarchy::new(black_box(&bounds))));
        group.bench_function(BenchmarkId::new("field", size), |b| b.iter(|| Field::new(black_box(&scene))));
    }
    group.finish();
}

criterion_group!(benches, scene);
criterion_main!(benches);
