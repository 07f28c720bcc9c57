//! A frame in motion (1 sample, no ground, 1920×1080, read back) on whatever graphics adapter there is, with and without culling: milliseconds
//! of the best of some frames of an orbit, each a degree on. `-- ATOMS…` takes other sizes,
//! `-- downlevel` the limits of the weakest devices.

#![allow(clippy::expect_used, reason = "a bench that cannot draw has nothing to measure")]

mod common;

use ballstick::bonds::{BondOptions, assign};
use ballstick::render::gpu::{AdapterWish, Culling, GpuRenderer};
use ballstick::render::{Quality, Renderer, Settings, View};
use ballstick::scene::{Camera, Item, Projection, Scene, SceneOptions};
use std::sync::Arc;
use std::time::{Duration, Instant};

const WIDTH: u32 = 1920;
const HEIGHT: u32 = 1080;
/// Frames of an orbit: after two it is known what is seen.
const FRAMES: u32 = 7;

/// A tenth of the picture.
fn zoomed(camera: Camera) -> Camera {
    let projection = match camera.projection {
        Projection::Perspective { fov_y_rad } => Projection::Perspective { fov_y_rad: 0.1 * fov_y_rad },
        Projection::Orthographic { height } => Projection::Orthographic { height: 0.1 * height },
    };
    Camera { projection, ..camera }
}

fn best(renderer: &mut GpuRenderer, camera: Camera, settings: &Settings) -> Duration {
    let frame = |frame: u32| {
        let view = View::new(camera.turned((frame as f32).to_radians()), WIDTH, HEIGHT);
        let start = Instant::now();
        renderer.image(&view, settings).expect("a picture");
        start.elapsed()
    };
    (0..FRAMES).map(frame).skip(2).min().unwrap_or_default()
}

fn main() {
    let mut sizes: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    if sizes.is_empty() {
        sizes = common::SIZES.to_vec();
    }
    let is_weak = std::env::args().any(|word| word == "downlevel");
    let open = if is_weak { GpuRenderer::downlevel } else { GpuRenderer::new };
    let mut renderer = open(AdapterWish::Any).expect("an adapter");
    println!("{}", renderer.name());
    println!("atoms     view   none_ms frustum_ms full_ms");
    let settings = Settings { samples: 1, ..Quality::Draft.settings() };
    for size in sizes {
        let structure = assign(common::structure(size), &BondOptions::default());
        let options = SceneOptions { ground: false, ..SceneOptions::default() };
        let scene = Arc::new(Scene::new(&[Item::of(&structure)], &options));
        renderer.load(Arc::clone(&scene)).expect("a scene that fits");
        let whole = scene.fitted_camera(WIDTH as f32 / HEIGHT as f32);
        for (name, camera) in [("whole", whole), ("tenth", zoomed(whole))] {
            let times = [Culling::None, Culling::Frustum, Culling::Full].map(|culling| {
                renderer.set_culling(culling);
                best(&mut renderer, camera, &settings).as_secs_f64() * 1e3
            });
            println!("{size:<9} {name}  {:8.1} {:10.1} {:7.1}", times[0], times[1], times[2]);
        }
    }
}
