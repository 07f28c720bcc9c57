//! Draws a file into a PNG: `cargo run --release --example picture -- data/caffeine.sdf caffeine.png`

use ballstick::export::atomic;
use ballstick::export::picture::{Content, PictureFormat, PictureOptions, write};
use ballstick::render::{Choice, Quality, View, select};
use ballstick::scene::{Background, Item, Scene, SceneOptions};
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let input = arguments.next().unwrap_or_else(|| PathBuf::from("data/caffeine.sdf"));
    let output = arguments.next().unwrap_or_else(|| std::env::temp_dir().join("picture.png"));

    let document = ballstick::import::read_path(&input, &Default::default())?;
    let record = document.records.first().ok_or("there is no molecule in it")?;
    let molecule = ballstick::bonds::assign(record.clone(), &Default::default());

    let options = SceneOptions { background: Background::Transparent, ..SceneOptions::default() };
    let scene = Arc::new(Scene::new(&[Item::of(&molecule)], &options));
    let (width, height) = (640, 480);
    let view = View::new(scene.fitted_camera(width as f32 / height as f32), width, height);

    // A real graphics card if there is one, else the CPU.
    let mut renderer = select(Choice::Auto)?.renderer;
    renderer.load(scene)?;
    let image = renderer.image(&view, &Quality::Standard.settings())?;

    let options = PictureOptions { alpha: true, ..PictureOptions::default() };
    atomic::write(&output, |out| write(Content::Color(&image), PictureFormat::Png, &options, out))?;
    println!("{} by {}", output.display(), renderer.name());
    Ok(())
}
