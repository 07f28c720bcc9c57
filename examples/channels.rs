//! Asks which atom is seen at each pixel, and how far away: `cargo run --release --example channels -- data/caffeine.sdf`

use ballstick::render::{Choice, GBuffer, View, select};
use ballstick::scene::{Item, Scene, SceneOptions};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("data/caffeine.sdf"), PathBuf::from);
    let document = ballstick::import::read_path(&path, &Default::default())?;
    let record = document.records.first().ok_or("there is no molecule in it")?;
    let molecule = ballstick::bonds::assign(record.clone(), &Default::default());

    let scene = Arc::new(Scene::new(&[Item::of(&molecule)], &SceneOptions::default()));
    let view = View::new(scene.fitted_camera(4.0 / 3.0), 320, 240);
    let mut renderer = select(Choice::Cpu)?.renderer;
    renderer.load(scene)?;
    let surface = renderer.gbuffer(&view)?;

    // Ids are 1 + atom, then the bonds; the ground has one of its own.
    let mut seen: BTreeMap<u32, (usize, f32)> = BTreeMap::new();
    for (&id, &depth) in surface.id.iter().zip(&surface.depth) {
        if id != GBuffer::BACKGROUND && id != GBuffer::GROUND {
            let (pixels, nearest) = seen.entry(id).or_insert((0, f32::INFINITY));
            *pixels += 1;
            *nearest = nearest.min(depth);
        }
    }
    for (id, (pixels, nearest)) in seen {
        let atom = id as usize - 1;
        match molecule.elements().get(atom) {
            Some(element) => println!("{element}{}: {pixels} pixels, {nearest:.2} Å away", atom + 1),
            None => println!("bond {}: {pixels} pixels, {nearest:.2} Å away", atom + 1 - molecule.atom_count()),
        }
    }
    Ok(())
}
