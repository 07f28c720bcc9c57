//! The CPU renderer at 1920×1080: a frame in motion (1 sample, no ground), and a finished still.

#![allow(clippy::expect_used, reason = "a bench that cannot draw has nothing to measure")]

mod common;

use ballstick::bonds::{BondOptions, assign};
use ballstick::render::cpu::CpuRenderer;
use ballstick::render::{Quality, Renderer, Settings, View};
use ballstick::scene::{Item, Scene, SceneOptions};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::sync::Arc;

const WIDTH: u32 = 1920;
const HEIGHT: u32 = 1080;

fn scene(size: usize, ground: bool) -> Arc<Scene> {
    let structure = assign(common::structure(size), &BondOptions::default());
    Arc::new(Scene::new(&[Item::of(&structure)], &SceneOptions { ground, ..SceneOptions::default() }))
}

fn view(scene: &Scene) -> View {
    View::new(scene.fitted_camera(WIDTH as f32 / HEIGHT as f32), WIDTH, HEIGHT)
}

fn motion(c: &mut Criterion) {
    let mut group = c.benchmark_group("cpu_motion");
    for size in common::SIZES {
        let scene = scene(size, false);
        let view = view(&scene);
        let settings = Settings { samples: 1, ..Quality::Draft.settings() };
        let mut renderer = CpuRenderer::new();
        renderer.load(scene).expect("the CPU renderer takes any scene");
        group.throughput(Throughput::Elements(size as u64));
        group.sample_size(if size > 100_000 { 10 } else { 20 });
        group.bench_function(BenchmarkId::new("frame", size), |b| {
            b.iter(|| renderer.image(&view, &settings).expect("a picture"));
        });
    }
    group.finish();
}

fn still(c: &mut Criterion) {
    let mut group = c.benchmark_group("cpu_still");
    group.sample_size(10);
    let size = 10_000;
    let scene = scene(size, true);
    let view = view(&scene);
    group.throughput(Throughput::Elements(size as u64));
    // A renderer each time: the ground's map is part of a still.
    group.bench_function(BenchmarkId::new("standard", size), |b| {
        b.iter(|| {
            let mut renderer = CpuRenderer::new();
            renderer.load(Arc::clone(&scene)).expect("the CPU renderer takes any scene");
            renderer.image(&view, &Quality::Standard.settings()).expect("a picture")
        });
    });
    group.finish();
}

criterion_group!(benches, motion, still);
criterion_main!(benches);
