//! Reads a file and lists its bonds: `cargo run --release --example bonds -- data/caffeine.sdf`

use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("data/caffeine.sdf"), PathBuf::from);
    let document = ballstick::import::read_path(&path, &Default::default())?;
    for diagnostic in &document.diagnostics {
        eprintln!("{}: {diagnostic}", path.display());
    }
    let record = document.records.first().ok_or("there is no molecule in it")?;
    let molecule = ballstick::bonds::assign(record.clone(), &Default::default());
    let elements = molecule.elements();
    for bond in molecule.bonds() {
        let (a, b) = (bond.a as usize, bond.b as usize);
        let length = molecule.positions().get(a).distance(molecule.positions().get(b));
        println!(
            "{}{} - {}{}  {:?}{}, {length:.3} Å, from {}",
            elements[a],
            a + 1,
            elements[b],
            b + 1,
            bond.order,
            if bond.aromatic { " (aromatic)" } else { "" },
            bond.source.name()
        );
    }
    Ok(())
}
