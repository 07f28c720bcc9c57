//! What a crystal's file lists, its whole molecules, its cell and a supercell: `cargo run --release --example crystal -- data/quartz.cif`

use ballstick::crystal::{CellChoice, CrystalOptions, draw};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("data/quartz.cif"), PathBuf::from);
    let document = ballstick::import::read_path(&path, &Default::default())?;
    let record = document.records.first().ok_or("there is no crystal in it")?;
    if record.cell().is_none() {
        return Err(format!("{} states no unit cell", path.display()).into());
    }
    for (name, cell, supercell) in [
        ("as listed", CellChoice::Asym, [1; 3]),
        ("molecules", CellChoice::Molecule, [1; 3]),
        ("one cell", CellChoice::Full, [1; 3]),
        ("2 × 2 × 2 cells", CellChoice::Full, [2; 3]),
    ] {
        // Bonds are found on the way, across the faces of the cell as well.
        let drawn = draw(record.clone(), &CrystalOptions { cell, supercell, ..CrystalOptions::default() })?;
        let [atoms, bonds] = drawn.counts();
        println!("{name}: {atoms} atoms, {bonds} bonds, {} of them cut at the faces", drawn.stubs.len());
    }
    Ok(())
}
