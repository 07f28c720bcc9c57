//! A molecule as a mesh for other programs: `cargo run --release --example mesh -- data/1crn.pdb crambin.glb`
//!
//! The name's ending says the format: glb, gltf, obj, stl or ply.

use ballstick::export::solid::{SolidFormat, SolidOptions, Source, write};
use ballstick::scene::{Item, Scene, SceneOptions};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let input = arguments.next().unwrap_or_else(|| PathBuf::from("data/caffeine.sdf"));
    let output = arguments.next().unwrap_or_else(|| std::env::temp_dir().join("mesh.glb"));
    let format = SolidFormat::from_path(&output).ok_or("the output must end in glb, gltf, obj, stl or ply")?;

    let document = ballstick::import::read_path(&input, &Default::default())?;
    let record = document.records.first().ok_or("there is no molecule in it")?;
    let molecule = ballstick::bonds::assign(record.clone(), &Default::default());
    let scene = Scene::new(&[Item::of(&molecule)], &SceneOptions::default());

    // Half the usual tolerance: triangles within 0.002 Å of the true surfaces.
    let options = SolidOptions { tolerance: 0.002, ..SolidOptions::default() };
    let name = input.file_name().unwrap_or_default().to_string_lossy();
    let source = Source { name: &name, structure: &molecule };
    let written = write(format, &scene, &[source], &options, &output)?;
    println!("{}: {} triangles", output.display(), written.triangles);
    Ok(())
}
