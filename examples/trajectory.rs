//! Follows the distance of two atoms through a trajectory:
//! `cargo run --release --example trajectory -- data/trajectories/box.gro data/trajectories/water.xtc 1 4`

use ballstick::import::trajectory::{Input, read_input};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let word = |index: usize, default: &str| arguments.get(index).map_or(default, String::as_str).to_owned();
    let input = Input {
        structure: PathBuf::from(word(0, "data/trajectories/box.gro")),
        trajectories: vec![PathBuf::from(word(1, "data/trajectories/water.xtc"))],
    };
    let (a, b): (usize, usize) = (word(2, "1").parse()?, word(3, "4").parse()?);
    let document = read_input(&input, &Default::default())?;
    // Frames are read from the disk one by one.
    for trajectory in &document.trajectories {
        trajectory.count_frames(|| true)?;
    }
    for number in 0..document.frame_count() {
        let frame = document.at_frame(number)?;
        if a == 0 || b == 0 || a.max(b) > frame.atom_count() {
            return Err(format!("atoms are numbered from 1 to {}", frame.atom_count()).into());
        }
        let distance = frame.positions().get(a - 1).distance(frame.positions().get(b - 1));
        println!("{:6} {distance:8.3} Å", number + 1);
    }
    Ok(())
}
