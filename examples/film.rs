//! A film of a turn: `cargo run --release --example film -- data/caffeine.sdf turn.gif`

use ballstick::color::Srgb8;
use ballstick::export::animation::{AnimationFormat, AnimationOptions, write};
use ballstick::render::{Choice, Quality, View, select};
use ballstick::scene::{Item, Scene, SceneOptions};
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let input = arguments.next().unwrap_or_else(|| PathBuf::from("data/caffeine.sdf"));
    let output = arguments.next().unwrap_or_else(|| std::env::temp_dir().join("turn.gif"));

    let document = ballstick::import::read_path(&input, &Default::default())?;
    let record = document.records.first().ok_or("there is no molecule in it")?;
    let molecule = ballstick::bonds::assign(record.clone(), &Default::default());
    let scene = Arc::new(Scene::new(&[Item::of(&molecule)], &SceneOptions::default()));

    let (size, frames) = ((160, 120), 24);
    let camera = scene.turntable_camera(size.0 as f32 / size.1 as f32);
    let mut renderer = select(Choice::Auto)?.renderer;
    renderer.load(scene)?;
    let format = AnimationFormat::from_path(&output).ok_or("a film is .gif, .apng or .mp4")?;
    let options =
        AnimationOptions { size, frames, fps: 12.0, alpha: false, background: Srgb8::WHITE, texts: Vec::new() };
    write(&output, format, &options, &mut |frame| {
        let angle_rad = std::f32::consts::TAU * frame as f32 / frames as f32;
        let view = View::new(camera.turned(angle_rad), size.0, size.1);
        renderer.image(&view, &Quality::Draft.settings())
    })?;
    println!("{}", output.display());
    Ok(())
}
