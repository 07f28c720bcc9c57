//! What every fuzz target does with its bytes: the whole way from a reader to a scene.

use ballstick::bonds::BondOptions;
use ballstick::crystal::{self, CrystalOptions};
use ballstick::export::json;
use ballstick::import::{Format, ImportOptions, Limits, read_bytes};
use ballstick::scene::{Item, Scene, SceneOptions};

/// Reads the bytes as `format` (`None`: as the program finds out), finds bonds, draws the crystal, builds the scene and
/// writes JSON. Anything but a panic, a hang or too much memory is right.
pub fn go(format: Option<Format>, bytes: &[u8]) {
    // Small limits keep the fuzzer on code, not on waiting.
    let limits = Limits { decompressed_bytes: 1 << 22, atoms: 20_000, records: 64, ..Limits::default() };
    let Ok(document) = read_bytes(bytes, "", &ImportOptions { format, limits }) else { return };
    for record in document.records.into_iter().take(2) {
        for frame in record.frames() {
            assert!(frame.positions.relative().iter().all(|position| position.is_finite()));
        }
        let options = CrystalOptions { most_atoms: 50_000, bonds: BondOptions::default(), ..CrystalOptions::default() };
        let Ok(drawn) = crystal::draw(record, &options) else { continue };
        let scene = Scene::new(&[Item::drawn(&drawn, None)], &SceneOptions::default());
        assert!(scene.fitted_camera(1.5).eye.is_finite());
        json::write(&drawn.structure, &mut std::io::sink()).expect("a sink takes everything");
    }
}
