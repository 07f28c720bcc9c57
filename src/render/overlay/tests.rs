use super::draw::draw;
use super::font::Font;
use super::layout::{Layout, round_length};
use super::*;
use crate::element::Element;
use crate::render::cpu::CpuRenderer;
use crate::render::{Renderer, Settings};
use crate::scene::{Item, LabelContent, Orientation, Overlay, OverlayOptions, Region, SceneOptions};
use crate::structure::{AtomRecord, Diagnostics, Structure, StructureBuilder};
use glam::Vec3;
use std::sync::Arc;

fn atoms(of: &[(Element, [f64; 3])]) -> Structure {
    let mut builder = StructureBuilder::new();
    for &(element, position) in of {
        builder.push_atom(&AtomRecord { element, position: position.into(), ..AtomRecord::default() });
    }
    builder.build(&mut Diagnostics::default())
}

fn scene_of(structure: &Structure, background: Background) -> Scene {
    let labels = LabelContent { element: true, index: true, ..LabelContent::default() };
    let overlay = OverlayOptions { labels, legend: true, scale_bar: true, size: 2.0 };
    let orientation = Orientation::Along { direction: Vec3::NEG_Z, up: Vec3::Y };
    let options = SceneOptions { background, overlay, orientation, ground: false, ..SceneOptions::default() };
    Scene::new(&[Item::of(structure)], &options)
}

fn spread() -> Structure {
    atoms(&[
        (Element::C, [0.0, 0.0, 0.0]),
        (Element::N, [2.0, 1.0, 0.5]),
        (Element::O, [-2.0, 1.2, -0.5]),
        (Element::H, [0.3, -1.5, 0.2]),
        (Element::CL, [1.7, -1.1, 1.0]),
    ])
}

const PLAIN: Settings = Settings { samples: 2, ground_texels: 16, ao: 0, shadow: false };

fn layout_of(scene: &Scene, view: &View) -> Layout {
    let mut renderer = CpuRenderer::new();
    renderer.load(Arc::new(scene.clone())).unwrap();
    let probe = renderer.gbuffer(&probe_view(view, PROBE_SIDE)).unwrap();
    Layout::new(&scene.overlay, view, Some(&probe))
}

fn texts(scene: &Scene) -> Vec<String> {
    let view = View::new(scene.fitted_camera(1.5), 300, 200);
    let mut texts: Vec<String> = layout_of(scene, &view).lines.into_iter().map(|line| line.text).collect();
    texts.sort();
    texts
}

#[test]
fn parts_of_a_picture_are_cut_from_the_whole() {
    for background in [Background::Color(Srgb8::WHITE), Background::Transparent] {
        let scene = Arc::new(scene_of(&spread(), background));
        let view = View::new(scene.fitted_camera(1.5), 301, 203);
        let mut renderer = CpuRenderer::new();
        renderer.load(Arc::clone(&scene)).unwrap();
        let whole = renderer.image(&view, &PLAIN).unwrap();
        for (x, y, width, height) in
            [(0, 0, 150, 203), (150, 0, 151, 203), (0, 0, 301, 97), (0, 97, 301, 106), (140, 90, 9, 13)]
        {
            let region = Region { x, y, width, height };
            let part = renderer.image(&View { region: Some(region), ..view }, &PLAIN).unwrap();
            for row in 0..height {
                let start = (((y + row) * 301 + x) * 4) as usize;
                let of_part = (row * width * 4) as usize;
                let bytes = (width * 4) as usize;
                assert!(part.rgba[of_part..][..bytes] == whole.rgba[start..][..bytes], "{region}, row {row}");
            }
        }
    }
}

#[test]
fn the_layout_is_the_same_at_every_size() {
    let scene = scene_of(&spread(), Background::default());
    let camera = scene.fitted_camera(1.5);
    let small = layout_of(&scene, &View::new(camera, 60, 40));
    let large = layout_of(&scene, &View::new(camera, 12_000, 8_000));
    assert_eq!(small.lines.len(), large.lines.len());
    assert!(small.lines.len() > 5 + 5, "labels, legend and scale bar: {:?}", small.lines);
    for (a, b) in small.lines.iter().zip(&large.lines) {
        assert_eq!(a.text, b.text);
        assert!((a.at[0] - b.at[0]).abs() < 1e-6 && (a.at[1] - b.at[1]).abs() < 1e-6, "{a:?}\n{b:?}");
    }
}

#[test]
fn what_is_hidden_has_no_label() {
    // The oxygen stands behind the chlorine, the carbon beside it.
    let structure =
        atoms(&[(Element::CL, [0.0, 0.0, 3.0]), (Element::O, [0.0, 0.0, -3.0]), (Element::C, [3.0, 0.0, -3.0])]);
    assert_eq!(texts(&scene_of(&structure, Background::default()))[2..], ["C3", "Cl", "Cl1", "O"]);
}

#[test]
fn of_labels_that_would_overlap_the_nearest_is_drawn() {
    let structure =
        atoms(&[(Element::C, [0.0, 0.0, 0.0]), (Element::N, [0.1, 1.2, 1.0]), (Element::O, [9.0, 9.0, 0.0])]);
    let mut scene = scene_of(&structure, Background::default());
    let overlay = Arc::make_mut(&mut scene.overlay);
    (overlay.size, overlay.scale_bar) = (8.0, false);
    overlay.legend.clear();
    assert_eq!(texts(&scene), ["N2", "O3"]);
}

#[test]
fn nothing_lies_on_legend_and_scale_bar() {
    let scene = scene_of(&spread(), Background::default());
    let view = View::new(scene.fitted_camera(1.5), 300, 200);
    let layout = layout_of(&scene, &view);
    let boxes: Vec<[f64; 4]> = layout
        .lines
        .iter()
        .map(|line| [line.at[0], line.at[1] - 0.7 * layout.em, line.at[0] + line.width, line.at[1]])
        .collect();
    for (i, a) in boxes.iter().enumerate() {
        for b in &boxes[..i] {
            assert!(a[0] >= b[2] || b[0] >= a[2] || a[1] >= b[3] || b[1] >= a[3], "{a:?} {b:?}");
        }
    }
    assert_eq!((layout.discs.len(), layout.bars.len()), (5, 3));
}

#[test]
fn long_legends_are_cut_and_say_by_how_much() {
    let row =
        |n: u8| crate::scene::LegendRow { color: Srgb8::rgb(n, 0, 0), names: vec![format!("R{n}"), "twin".to_owned()] };
    let overlay = Overlay { legend: (0..30).map(row).collect(), ..Overlay::default() };
    let view = View::new(Scene::from_blocks(Vec::new(), Vec::new()).fitted_camera(1.5), 300, 200);
    let layout = Layout::new(&overlay, &view, None);
    assert_eq!((layout.discs.len(), layout.lines.len()), (11, 12));
    assert_eq!(layout.lines[0].text, "R0, twin");
    assert_eq!(layout.lines[11].text, "+ 38 more");
    assert!(layout.lines.windows(2).all(|pair| pair[0].at[1] < pair[1].at[1]), "downwards");
    let large = Layout::new(&Overlay { size: 5.0, ..overlay }, &view, None);
    assert!(large.lines.len() < 6 && large.lines.iter().all(|line| line.at[1] > 0.3));
}

#[test]
fn scale_bars_have_round_lengths() {
    let cases = [
        (0.07, 0.05),
        (0.9, 1.0),
        (1.3, 1.0),
        (1.5, 2.0),
        (3.0, 2.0),
        (3.3, 5.0),
        (6.0, 5.0),
        (8.0, 10.0),
        (180.0, 200.0),
        (400.0, 500.0),
    ];
    for (near, round) in cases {
        assert_eq!(round_length(near), Some(round), "{near}");
    }
    for none in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(round_length(none), None);
    }
}

#[test]
fn the_scale_bar_is_as_long_as_it_says() {
    // Two atoms 4 Å apart in the plane of the target, in both projections.
    let structure = atoms(&[(Element::C, [-2.0, 0.0, 0.0]), (Element::N, [2.0, 0.0, 0.0])]);
    let scene = scene_of(&structure, Background::default());
    let camera = scene.fitted_camera(1.5);
    for camera in [camera, camera.with_toggled_projection(0.4)] {
        let layout = layout_of(&scene, &View::new(camera, 600, 400));
        let label = |text: &str| {
            let line = layout.lines.iter().find(|line| line.text == text).unwrap();
            line.at[0] + 0.5 * line.width
        };
        let angstrom_per_height = 4.0 / (label("N2") - label("C1"));
        let bar = layout.bars[0];
        let length = (bar[2] - bar[0]) * angstrom_per_height;
        let said: f64 = layout
            .lines
            .iter()
            .find_map(|line| line.text.strip_suffix(" Å"))
            .and_then(|text| text.parse().ok())
            .unwrap();
        assert!((length / said - 1.0).abs() < 1e-3, "{length} for {said}");
        assert!((0.1..0.28).contains(&((bar[2] - bar[0]) / 1.5)), "about a sixth of the width");
    }
}

#[test]
fn text_on_nothing_laid_on_a_colour_is_text_on_that_colour() {
    let scene = scene_of(&spread(), Background::Transparent);
    let view = View::new(scene.fitted_camera(1.5), 240, 160);
    let layout = layout_of(&scene, &view);
    let blank = |color: [u8; 4]| Image { width: 240, height: 160, rgba: color.repeat(240 * 160) };
    for ink in [Ink::on(Background::Transparent), Ink::on(Background::Color(Srgb8::BLACK))] {
        let mut on_nothing = blank([0; 4]);
        draw(&mut on_nothing, &view, &layout, ink);
        assert!(on_nothing.rgba.chunks_exact(4).filter(|pixel| pixel[3] > 0 && pixel[3] < 255).count() > 500);
        for color in [[0, 0, 0, 255], [255, 255, 255, 255], [255, 0, 255, 255]] {
            let mut on_color = blank(color);
            draw(&mut on_color, &view, &layout, ink);
            for (pixel, expected) in on_nothing.rgba.chunks_exact(4).zip(on_color.rgba.chunks_exact(4)) {
                let alpha = f32::from(pixel[3]) / 255.0;
                for channel in 0..3 {
                    let laid = f32::from(pixel[channel]) * alpha + f32::from(color[channel]) * (1.0 - alpha);
                    assert!((laid - f32::from(expected[channel])).abs() <= 2.0, "{pixel:?} on {color:?}: {expected:?}");
                }
                assert_eq!(expected[3], 255);
            }
        }
    }
}

#[test]
fn ink_stands_out_from_the_background() {
    let text = |color| Ink::on(Background::Color(Srgb8::from_rgb_u32(color))).text.r;
    assert!(text(0xFF_FF_FF) < 50 && text(0x80_80_80) < 50 && text(0xFF_FF_00) < 50);
    assert!(text(0x00_00_00) > 200 && text(0x19_19_70) > 200 && text(0x80_00_00) > 200);
}

#[test]
fn strange_texts_and_anchors_do_no_harm() {
    let far = |anchor: Vec3| crate::scene::Label {
        text: "a\u{7}\n漢字 ".repeat(90).into(),
        anchor,
        ids: [1, 0],
        radius: 0.0,
    };
    let anchors = [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::splat(-1e30), Vec3::new(0.0, 0.0, 1e9)];
    let mut scene = scene_of(&spread(), Background::default());
    let overlay = Arc::make_mut(&mut scene.overlay);
    overlay.labels = anchors.map(far).to_vec();
    let camera = scene.fitted_camera(1.5);
    for size in [0.0, 1.0, 1e30, f32::NAN] {
        Arc::make_mut(&mut scene.overlay).size = size;
        for (width, height) in [(1, 1), (1, 300), (300, 1), (200, 100)] {
            let view = View::new(camera, width, height);
            let mut image = Image { width, height, rgba: vec![255; (width * height * 4) as usize] };
            let layout = layout_of(&scene, &view);
            assert!(layout.lines.iter().all(|line| line.text.chars().count() <= 90 && !line.text.contains('\n')));
            draw(&mut image, &view, &layout, Ink::on(Background::default()));
        }
    }
}

#[test]
fn accents_and_descenders_fit_into_a_lines_mask() {
    let font = Font::get().unwrap();
    for character in "ÅÇgj|½µΩÿ/@\u{17c}".chars() {
        let bounds = font.outlined(character, 1000.0, [0.0, 0.0]).unwrap().px_bounds();
        assert!(bounds.min.y > -1100.0 && bounds.max.y < 400.0, "{character} {bounds:?}");
    }
}
