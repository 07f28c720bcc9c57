//! Pictures of any size: strips, sides of 1 and 32,768, resolutions, crops.

use crate::cli::{Case, METHANE, WATER};
use ballstick::render::cpu::CpuRenderer;
use ballstick::render::{Image, Renderer, Settings, View};
use ballstick::scene::{Background, Item, Region, Scene, SceneOptions};
use std::fs;
use std::sync::Arc;

/// Crambin with its bonds.
fn crambin(options: &SceneOptions) -> Arc<Scene> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/1crn.pdb");
    let document = ballstick::import::read_path(&path, &Default::default()).unwrap();
    let molecule = ballstick::bonds::assign(document.records[0].clone(), &Default::default());
    Arc::new(Scene::new(&[Item::of(&molecule)], options))
}

#[test]
fn strips_and_pieces_are_the_whole_picture_byte_for_byte() {
    let settings = Settings { samples: 5, ground_texels: 200, ao: 16, shadow: true };
    for background in [Background::Transparent, SceneOptions::default().background] {
        let scene = crambin(&SceneOptions { background, ..SceneOptions::default() });
        let view = View::new(scene.fitted_camera(333.0 / 250.0), 333, 250);
        let draw = |region: Option<Region>| {
            let mut renderer = CpuRenderer::new(); // nothing is left from the strip before
            renderer.load(Arc::clone(&scene)).unwrap();
            renderer.image(&View { region, ..view }, &settings).unwrap()
        };
        let whole = draw(None);
        assert!(whole.rgba.chunks_exact(4).any(|pixel| pixel != &whole.rgba[..4]), "nothing is drawn");
        for rows in [32, 64, 7] {
            let mut kept = CpuRenderer::new();
            kept.load(Arc::clone(&scene)).unwrap();
            let mut strips = Image { rgba: Vec::new(), ..whole };
            for y in (0..250).step_by(rows as usize) {
                let region = Region { x: 0, y, width: 333, height: rows.min(250 - y) };
                strips.rgba.extend(kept.image(&View { region: Some(region), ..view }, &settings).unwrap().rgba);
            }
            assert!(strips == whole, "strips of {rows} rows on {background:?}");
        }
        let piece = Region { x: 101, y: 37, width: 77, height: 123 };
        for (row, line) in draw(Some(piece)).rgba.chunks_exact(77 * 4).enumerate() {
            let start = ((37 + row) * 333 + 101) * 4;
            assert!(line == &whole.rgba[start..start + 77 * 4], "row {row} on {background:?}");
        }
    }
}

const QUICK: [&str; 5] = ["--renderer=cpu", "--samples=1", "--ao=0", "--quality=draft", "--timings"];

fn draw(case: &Case, output: &str, flags: &[&str]) -> crate::cli::Run {
    let all = [&["render", "water.xyz", "-o", output], &QUICK[..], flags].concat();
    case.run(&all).status(0)
}

/// Width, height and pixels of a PPM file.
fn ppm(case: &Case, name: &str) -> (usize, usize, Vec<u8>) {
    let file = fs::read(case.path(name)).unwrap();
    let mut parts = file.splitn(4, |&byte| byte == b'\n' || byte == b' ');
    assert_eq!(parts.next(), Some(&b"P6"[..]));
    let mut number = || std::str::from_utf8(parts.next().unwrap()).unwrap().parse().unwrap();
    let (width, height) = (number(), number());
    let pixels = parts.next().unwrap().strip_prefix(b"255\n").unwrap().to_vec();
    assert_eq!(pixels.len(), width * height * 3);
    (width, height, pixels)
}

#[test]
fn a_picture_of_many_strips_is_its_regions_and_says_its_memory() {
    let case = Case::new(&[("water.xyz", WATER)]);
    // Two strips: the first of 2048 rows.
    let run = draw(&case, "full.ppm", &["--size=8192x2304"]);
    let (width, height, full) = ppm(&case, "full.ppm");
    assert_eq!((width, height), (8192, 2304));
    draw(&case, "part.ppm", &["--size=8192x2304", "--region=3000,1900,2000,300"]);
    let (_, _, part) = ppm(&case, "part.ppm");
    assert!(part.iter().any(|&value| value != part[0]), "nothing is drawn");
    for (row, line) in part.chunks_exact(2000 * 3).enumerate() {
        let start = ((1900 + row) * 8192 + 3000) * 3;
        assert!(line == &full[start..start + 2000 * 3], "row {row}");
    }
    let timings: serde_json::Value = serde_json::from_str(run.err().lines().last().unwrap()).unwrap();
    let seconds = |key: &str| timings[key].as_f64().unwrap();
    assert!(seconds("render") > 0.0 && seconds("encode") > 0.0);
    assert!(seconds("total") + 1e-6 >= seconds("render") + seconds("encode"));
}

fn png(case: &Case, name: &str) -> (png::Info<'static>, Vec<u8>) {
    let file = fs::File::open(case.path(name)).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut data).unwrap();
    reader.finish().unwrap();
    (reader.info().clone(), data)
}

#[test]
fn large_png_files_hold_the_pixels_that_ppm_files_hold() {
    let case = Case::new(&[("water.xyz", WATER)]);
    draw(&case, "a.ppm", &["--size=1100x17000"]);
    draw(&case, "a.png", &["--size=1100x17000"]);
    let (info, data) = png(&case, "a.png");
    assert_eq!((info.width, info.height, info.color_type), (1100, 17000, png::ColorType::Rgb));
    assert!(data == ppm(&case, "a.ppm").2);
}

#[test]
fn alpha_is_in_the_file_exactly_if_the_background_is_transparent() {
    let case = Case::new(&[("water.xyz", WATER)]);
    // From near enough, water fills the region: every pixel is opaque.
    let middle = ["--size=400x300", "--region=199,149,2,2", "--no-ground", "--style=space-filling"];
    draw(&case, "a.png", &[&middle[..], &["--background=transparent"]].concat());
    let (info, data) = png(&case, "a.png");
    assert_eq!(info.color_type, png::ColorType::Rgba);
    assert!(data.chunks_exact(4).all(|pixel| pixel[3] == 255), "the region is not full");
    draw(&case, "b.png", &middle);
    assert_eq!(png(&case, "b.png").0.color_type, png::ColorType::Rgb);
}

#[test]
fn sides_of_1_and_32768_work_and_larger_ones_are_refused_before_any_work() {
    let case = Case::new(&[("water.xyz", WATER)]);
    for (size, width, height) in [("1x1", 1, 1), ("1x32768", 1, 32768), ("32768x1", 32768, 1)] {
        for flags in [&[][..], &["--background=transparent", "--projection=orthographic"], &["--channel=depth"]] {
            let size = format!("--size={size}");
            draw(&case, "a.png", &[&[size.as_str()], flags].concat());
            let (info, _) = png(&case, "a.png");
            assert_eq!((info.width, info.height), (width, height));
        }
    }
    fs::remove_file(case.path("a.png")).unwrap();
    for size in ["32769x1", "1x32769", "100000x100000", "4m", "300cmx1cm"] {
        let run = case.run(&["render", "none.xyz", "-o", "a.png", "--size", size]).status(2);
        assert!(run.err().contains("32768") && !run.err().contains("none.xyz"), "{}", run.err());
    }
    assert_eq!(case.names(""), ["water.xyz"]);
}

#[test]
fn resolutions_are_in_png_and_jpeg_files_and_turn_lengths_into_pixels() {
    let case = Case::new(&[("water.xyz", WATER)]);
    let of = |flags: &[&str]| {
        draw(&case, "a.png", flags);
        let info = png(&case, "a.png").0;
        (info.width, info.height, info.pixel_dims.map(|dims| (dims.xppu, dims.yppu, dims.unit)))
    };
    let per_metre = |n| Some((n, n, png::Unit::Meter));
    assert_eq!(of(&["--size=40x30"]), (40, 30, None));
    assert_eq!(of(&["--size=40x30", "--dpi=600"]), (40, 30, per_metre(23622)));
    assert_eq!(of(&["--size=8mmx6mm"]), (94, 71, per_metre(11811)));
    assert_eq!(of(&["--size=1inx0.5in", "--dpi=100"]), (100, 50, per_metre(3937)));
    draw(&case, "a.jpg", &["--size=40x30", "--dpi=300"]);
    assert_eq!(fs::read(case.path("a.jpg")).unwrap()[13..18], [1, 1, 44, 1, 44]);
    let run = draw(&case, "a.webp", &["--size=40x30", "--dpi=300"]);
    assert!(run.err().contains("no place for the resolution"), "{}", run.err());
}

/// The box of what is not `background` in RGB pixels: left, top, right, bottom, the last two exclusive.
fn seen((width, _, pixels): &(usize, usize, Vec<u8>), background: [u8; 3]) -> [usize; 4] {
    let differs = |pixel: &[u8]| pixel.iter().zip(background).any(|(a, b)| a.abs_diff(b) > 1);
    let places =
        pixels.chunks_exact(3).enumerate().filter(|(_, pixel)| differs(pixel)).map(|(i, _)| (i % width, i / width));
    places
        .fold([usize::MAX, usize::MAX, 0, 0], |b, (x, y)| [b[0].min(x), b[1].min(y), b[2].max(x + 1), b[3].max(y + 1)])
}

#[test]
fn a_crop_is_that_part_of_the_picture_with_its_shadow_and_margin() {
    let case = Case::new(&[("water.xyz", METHANE)]);
    for (flags, background) in
        [(&[][..], [255; 3]), (&["--no-ground"], [255; 3]), (&["--background=#304050"], [0x30, 0x40, 0x50])]
    {
        let flags = [&["--size=900x400"][..], flags].concat();
        draw(&case, "full.ppm", &flags);
        draw(&case, "crop.ppm", &[&flags[..], &["--crop=auto,0"]].concat());
        let (full, (width, height, crop)) = (ppm(&case, "full.ppm"), ppm(&case, "crop.ppm"));
        let [left, top, right, bottom] = seen(&full, background);
        assert!(right - left < 800 && (width, height) == (right - left, bottom - top), "{flags:?}");
        for (row, line) in crop.chunks_exact(width * 3).enumerate() {
            let start = ((top + row) * 900 + left) * 3;
            assert!(line == &full.2[start..start + width * 3], "{flags:?} row {row}");
        }
        draw(&case, "wide.ppm", &[&flags[..], &["--crop=auto,10%"]].concat());
        let margin = (width.max(height) as f64 * 0.1).round() as usize;
        let (wide, high, _) = ppm(&case, "wide.ppm");
        assert_eq!(wide, (right + margin).min(900) - left.saturating_sub(margin));
        assert_eq!(high, (bottom + margin).min(400) - top.saturating_sub(margin));
    }
    // Channels are cut where the picture is.
    draw(&case, "crop.ppm", &["--size=900x400", "--crop=auto"]);
    draw(&case, "crop.png", &["--size=900x400", "--crop=auto", "--channel=id"]);
    let (info, (width, height, _)) = (png(&case, "crop.png").0, ppm(&case, "crop.ppm"));
    assert_eq!((info.width as usize, info.height as usize), (width, height));
}

#[test]
fn transparent_crops_keep_all_that_is_more_than_1_of_255_opaque() {
    let case = Case::new(&[("water.xyz", METHANE)]);
    let flags = ["--size=700x500", "--background=transparent"];
    draw(&case, "full.png", &flags);
    draw(&case, "crop.png", &[&flags[..], &["--crop=auto,0"]].concat());
    let alphas = |name: &str| {
        let (info, data) = png(&case, name);
        let over = data.chunks_exact(4).filter(|pixel| pixel[3] > 1).count();
        (info.width as usize, info.height as usize, over, data)
    };
    let (_, _, everything, _) = alphas("full.png");
    let (width, height, kept, data) = alphas("crop.png");
    assert!(everything == kept && everything > 1000 && width < 690);
    let visible = |x: usize, y: usize| data[(y * width + x) * 4 + 3] > 1;
    assert!((0..width).any(|x| visible(x, 0)) && (0..width).any(|x| visible(x, height - 1)));
    assert!((0..height).any(|y| visible(0, y)) && (0..height).any(|y| visible(width - 1, y)));
}
