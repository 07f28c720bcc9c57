//! What every fuzz target does with its bytes: the whole way from a reader to a scene.

use ballstick::bonds::BondOptions;
use ballstick::crystal::{self, CrystalOptions};
use ballstick::export::json;
use ballstick::import::{Format, ImportOptions, Limits, read_bytes};
use ballstick::render::cpu::CpuRenderer;
use ballstick::render::{Renderer, Settings, View};
use ballstick::scene::{Item, Scene, SceneOptions};
use ballstick::select::{Scope, Selection};
use ballstick::session::Session;
use ballstick::structure::Structure;
use std::cell::RefCell;
use std::sync::{Arc, LazyLock};

/// Reads the bytes as `format` (`None`: as the program finds out), finds bonds, draws the crystal, builds the scene and
/// writes JSON. Anything but a panic, a hang or too much memory is right.
pub fn go(format: Option<Format>, bytes: &[u8]) {
    // Small limits keep the fuzzer on code, not on waiting.
    let limits = Limits { decompressed_bytes: 1 << 22, atoms: 20_000, records: 64, ..Limits::default() };
    let Ok(document) = read_bytes(bytes, "", &ImportOptions { format, limits, ..Default::default() }) else { return };
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

/// As [`go`], whatever the bytes are, on to a picture of 64 × 64 pixels with all its light: every depth, normal and share of the sky is
/// a number.
pub fn draw(bytes: &[u8]) {
    thread_local!(static RENDERER: RefCell<CpuRenderer> = RefCell::new(CpuRenderer::new()));
    let limits = Limits { decompressed_bytes: 1 << 22, atoms: 2_000, records: 4, ..Limits::default() };
    let Ok(document) = read_bytes(bytes, "", &ImportOptions { limits, ..Default::default() }) else { return };
    let Some(record) = document.records.into_iter().next() else { return };
    let options = CrystalOptions { most_atoms: 5_000, ..CrystalOptions::default() };
    let Ok(drawn) = crystal::draw(record, &options) else { return };
    let scene = Arc::new(Scene::new(&[Item::drawn(&drawn, None)], &SceneOptions::default()));
    let view = View::new(scene.fitted_camera(1.0), 64, 64);
    RENDERER.with_borrow_mut(|renderer| {
        renderer.load(scene).expect("the CPU draws any scene");
        let settings = Settings { samples: 1, ground_texels: 64, ao: 8, shadow: true };
        let image = renderer.image(&view, &settings).expect("the CPU draws any scene");
        assert_eq!(image.rgba.len(), 64 * 64 * 4);
        let surface = renderer.gbuffer(&view).expect("the CPU draws any scene");
        assert!(surface.depth.iter().all(|depth| !depth.is_nan() && *depth > 0.0));
        assert!(surface.normal.iter().flatten().all(|part| part.is_finite() && part.abs() <= 1.001));
        let sky = renderer.sky_visibility(&view, 4).expect("the CPU asks any sky");
        assert!(sky.open.iter().all(|open| (0.0..=1.0).contains(open)));
    });
}

/// Reads a session; what is read has settings, and what is written of it is the same session.
pub fn session(bytes: &[u8]) {
    let Ok(session) = Session::parse(bytes, "/folder".as_ref()) else { return };
    session.settings().expect("what is read has settings");
    let (_, text) = session.text(None);
    if !text.is_empty() {
        Session::parse(text.as_bytes(), "/folder".as_ref()).expect("what is written is read");
    }
}

/// Reads a selection; what is written of it selects the same atoms.
pub fn selection(bytes: &[u8]) {
    static PEPTIDE: LazyLock<Structure> = LazyLock::new(|| {
        let text = include_bytes!("../../../data/1crn.pdb");
        let document = read_bytes(text, "1crn.pdb", &ImportOptions::default()).expect("crambin can be read");
        ballstick::bonds::assign(document.records[0].clone(), &BondOptions::default())
    });
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(selection) = Selection::parse(text) else { return };
    let atoms = selection.atoms(Scope::of(&PEPTIDE));
    assert_eq!(atoms.len(), PEPTIDE.atom_count());
    let again = Selection::parse(&selection.to_string()).expect("what is written is read");
    assert_eq!(again.atoms(Scope::of(&PEPTIDE)), atoms);
}
