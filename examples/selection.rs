//! Says which atoms a selection means, and draws them gold: `cargo run --release --example selection -- data/1crn.pdb "name SG"`

use ballstick::color::Srgb8;
use ballstick::export::{atomic, picture};
use ballstick::render::{Choice, Quality, View, select};
use ballstick::scene::{BySelection, Item, Scene, SceneOptions};
use ballstick::select::{Scope, Selection};
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let path = arguments.next().map_or_else(|| PathBuf::from("data/1crn.pdb"), PathBuf::from);
    let words = arguments.next().map_or_else(|| "name SG".to_owned(), |words| words.to_string_lossy().into_owned());
    let output = arguments.next().map_or_else(|| std::env::temp_dir().join("selection.png"), PathBuf::from);

    let document = ballstick::import::read_path(&path, &Default::default())?;
    let record = document.records.first().ok_or("there is no molecule in it")?;
    let molecule = ballstick::bonds::assign(record.clone(), &Default::default());

    let selection = Selection::parse(&words)?;
    let chosen = selection.atoms(Scope::of(&molecule));
    for atom in (0..molecule.atom_count()).filter(|&atom| chosen[atom]) {
        println!("{} {}", atom + 1, molecule.atom_name(atom));
    }

    let gold = Srgb8::rgb(0xff, 0xd7, 0x00);
    let by_selection = BySelection { colors: vec![(selection, gold)], ..BySelection::default() };
    let options = SceneOptions { by_selection, ..SceneOptions::default() };
    let scene = Arc::new(Scene::new(&[Item::of(&molecule)], &options));
    let view = View::new(scene.fitted_camera(4.0 / 3.0), 320, 240);
    let mut renderer = select(Choice::Auto)?.renderer;
    renderer.load(scene)?;
    let image = renderer.image(&view, &Quality::Draft.settings())?;
    let (content, format) = (picture::Content::Color(&image), picture::PictureFormat::Png);
    atomic::write(&output, |out| picture::write(content, format, &Default::default(), out))?;
    println!("{}", output.display());
    Ok(())
}
