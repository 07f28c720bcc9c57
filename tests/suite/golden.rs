//! Golden pictures: small, one idea each, written only by the scalar CPU reference.
//!
//! `BALLSTICK_BLESS=1 cargo test --release golden` writes them anew and fails all the same, so that no run both
//! makes and accepts a picture. Look at them before you commit them.

use crate::scenes;
use ballstick::render::cpu::{CpuRenderer, reference};
use ballstick::render::{GBuffer, Image, Renderer, Settings};
use std::path::PathBuf;
use std::sync::Arc;

const SETTINGS: Settings = Settings { samples: 16, ground_texels: 96, ao: 0, shadow: false };
/// The reference must give the golden bytes; libm's `powf` may round the last bit of a channel otherwise elsewhere.
const TOLERANCE: u8 = 1;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

fn load(name: &str) -> Result<Image, String> {
    let path = folder().join(format!("{name}.png"));
    let file = std::fs::File::open(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().map_err(|e| e.to_string())?;
    let mut rgba = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgba).map_err(|e| e.to_string())?;
    if info.color_type != png::ColorType::Rgba {
        return Err(format!("{name}: not RGBA"));
    }
    Ok(Image { width: info.width, height: info.height, rgba })
}

fn save(name: &str, image: &Image) {
    let file = std::fs::File::create(folder().join(format!("{name}.png"))).unwrap();
    let mut encoder = png::Encoder::new(file, image.width, image.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_compression(png::Compression::High);
    encoder.write_header().unwrap().write_image_data(&image.rgba).unwrap();
}

/// The largest difference of any channel, alpha included; an error if the sizes differ.
fn compare(got: &Image, want: &Image) -> Result<u8, String> {
    if (got.width, got.height) != (want.width, want.height) || got.rgba.len() != want.rgba.len() || got.rgba.is_empty()
    {
        return Err(format!("{}×{} against {}×{}", got.width, got.height, want.width, want.height));
    }
    Ok(got.rgba.iter().zip(&want.rgba).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0))
}

#[test]
fn golden_pictures_are_what_the_reference_draws() {
    let bless = std::env::var_os("BALLSTICK_BLESS").is_some();
    let cases = scenes::all();
    assert!(cases.len() > 20);
    let mut wrong = Vec::new();
    for case in &cases {
        let got = reference::image(&case.scene, &case.view, &SETTINGS);
        if bless {
            save(case.name, &got);
            continue;
        }
        match load(case.name).and_then(|want| compare(&got, &want)) {
            Ok(difference) if difference <= TOLERANCE => {}
            Ok(difference) => {
                let path = std::env::temp_dir().join(format!("ballstick-golden-{}.png", case.name));
                wrong.push(format!("{}: differs by {difference}; see {}", case.name, path.display()));
                let file = std::fs::File::create(path).unwrap();
                let mut encoder = png::Encoder::new(file, got.width, got.height);
                encoder.set_color(png::ColorType::Rgba);
                encoder.write_header().unwrap().write_image_data(&got.rgba).unwrap();
            }
            Err(error) => wrong.push(format!("{}: {error}", case.name)),
        }
    }
    assert!(!bless, "golden pictures were written; look at them, then run without BALLSTICK_BLESS");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_golden_file_has_its_case() {
    let names: Vec<String> = scenes::all().iter().map(|case| format!("{}.png", case.name)).collect();
    for entry in std::fs::read_dir(folder()).unwrap().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        assert!(names.contains(&name), "tests/golden/{name} belongs to no case");
    }
}

#[test]
fn tiles_on_all_cores_see_what_the_reference_sees_to_the_bit() {
    for case in scenes::all() {
        let scene = Arc::new(case.scene);
        let mut renderer = CpuRenderer::new();
        renderer.load(Arc::clone(&scene)).unwrap();
        let tiles = renderer.image(&case.view, &SETTINGS).unwrap();
        // Colours are found from the place of the hit, not by solving again: a byte may be rounded the other way.
        let apart = compare(&tiles, &reference::image(&scene, &case.view, &SETTINGS));
        assert!(apart.as_ref().is_ok_and(|&most| most <= 1), "{}: {apart:?}", case.name);
        let (got, want) = (renderer.gbuffer(&case.view).unwrap(), reference::gbuffer(&scene, &case.view));
        assert_eq!(got, want, "{}", case.name);
    }
}

/// Light from afar is found by rays in the reference and through maps in the tiles: edges of shadows differ.
#[test]
fn tiles_finish_the_picture_as_the_reference_does() {
    let finished = Settings { ao: 64, shadow: true, ..SETTINGS };
    for name in ["molecule", "molecule_on_ground", "molecule_licorice", "molecule_space_filling", "placements"] {
        let case = scenes::all().into_iter().find(|case| case.name == name).unwrap();
        let scene = Arc::new(case.scene);
        let mut renderer = CpuRenderer::new();
        renderer.load(Arc::clone(&scene)).unwrap();
        let got = renderer.image(&case.view, &finished).unwrap();
        let want = reference::image(&scene, &case.view, &finished);
        let plain = reference::image(&scene, &case.view, &SETTINGS);
        let covered = renderer.gbuffer(&case.view).unwrap();
        let apart = |a: &Image, b: &Image| {
            let pixels = a
                .rgba
                .chunks(4)
                .zip(b.rgba.chunks(4))
                .zip(&covered.id)
                .filter(|(_, id)| !matches!(**id, GBuffer::BACKGROUND | GBuffer::GROUND));
            let each: Vec<u8> =
                pixels.map(|((a, b), _)| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap()).collect();
            let mean = each.iter().map(|&d| f64::from(d)).sum::<f64>() / each.len() as f64;
            (mean, each.iter().filter(|&&d| d <= 4).count() as f64 / each.len() as f64)
        };
        let (mean, share) = apart(&got, &want);
        println!("{name}: {mean:.3}/255 apart in the mean, {:.2} % within 4/255", 100.0 * share);
        assert!(mean <= 1.0 && share >= 0.999, "{name}: {mean} {share}");
        assert!(apart(&plain, &want).0 > 1.0, "{name}: without light from afar it is another picture");
    }
}

#[test]
fn regions_are_cut_out_of_the_whole_without_seams() {
    let case = scenes::all().into_iter().find(|case| case.name == "molecule_on_ground").unwrap();
    let mut renderer = CpuRenderer::new();
    renderer.load(Arc::new(case.scene)).unwrap();
    let mut view = case.view;
    (view.width, view.height) = (201, 143);
    let whole = renderer.image(&view, &SETTINGS).unwrap();
    for (x, y, width, height) in [(0, 0, 100, 71), (100, 0, 101, 71), (37, 40, 64, 103), (200, 142, 1, 1)] {
        view.region = Some(ballstick::scene::Region { x, y, width, height });
        let part = renderer.image(&view, &SETTINGS).unwrap();
        for row in 0..height {
            let start = (((y + row) * whole.width + x) * 4) as usize;
            let line = (row * width * 4) as usize;
            assert_eq!(part.rgba[line..line + width as usize * 4], whole.rgba[start..start + width as usize * 4]);
        }
    }
}

#[test]
fn a_transparent_picture_laid_on_white_is_the_white_one() {
    let case = |name: &str| scenes::all().into_iter().find(|case| case.name == name).unwrap();
    let (clear, white) = (case("molecule_transparent"), case("molecule_on_ground"));
    let laid = reference::image(&clear.scene, &clear.view, &SETTINGS);
    let want = reference::image(&white.scene, &white.view, &SETTINGS);
    let (mut shaded, mut compared) = (0, 0);
    for (got, want) in laid.rgba.chunks_exact(4).zip(want.rgba.chunks_exact(4)) {
        let alpha = i32::from(got[3]);
        let black = got[..3] == [0; 3];
        if alpha < 255 && black {
            // Ground alone, laid over white as image programs do it: in sRGB.
            compared += 1;
            shaded += i32::from(alpha > 25);
            let on_white = 255 - alpha;
            assert!((on_white - i32::from(want[0])).abs() <= 1, "{on_white} for {}", want[0]);
        }
    }
    assert!(compared > 4000 && shaded > 200, "{compared} pixels of ground, {shaded} in shadow");
}

#[test]
fn the_comparer_fails_when_it_should() {
    let image = |rgba: Vec<u8>| Image { width: 2, height: 1, rgba };
    let base = image(vec![10, 20, 30, 255, 40, 50, 60, 255]);
    assert_eq!(compare(&base, &base), Ok(0));
    let shifted = image(vec![40, 50, 60, 255, 10, 20, 30, 255]);
    assert!(compare(&shifted, &base).unwrap() > TOLERANCE);
    let alpha = image(vec![10, 20, 30, 0, 40, 50, 60, 255]);
    assert!(compare(&alpha, &base).unwrap() > TOLERANCE, "alpha counts");
    let other = Image { width: 1, height: 2, rgba: base.rgba.clone() };
    assert!(compare(&other, &base).is_err(), "size counts");
    let nothing = Image { width: 0, height: 0, rgba: vec![] };
    assert!(compare(&nothing, &nothing).is_err(), "nothing to compare is a failure");
    assert!(load("there is no such picture").is_err());
}
