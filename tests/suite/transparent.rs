//! Transparent pictures laid over a colour beside pictures drawn on that colour.
//!
//! Light adds up in linear space: there a see-through edge of the molecule has to agree with one drawn on the colour. Programs
//! lay pictures over one another in sRGB: the ground's shadow is made for that, and agrees there on colours whose
//! channels are 0 or 255, where the ground's shade is the white ground's.

use ballstick::color::{Srgb8, linear_from_srgb, srgb_from_linear};
use ballstick::render::cpu::CpuRenderer;
use ballstick::render::{Image, Renderer, Settings, View};
use ballstick::scene::{Background, Item, Scene, SceneOptions, Style};
use std::sync::Arc;

const COLORS: [Srgb8; 3] = [Srgb8::BLACK, Srgb8::WHITE, Srgb8::rgb(255, 0, 255)];
const TOLERANCE: u8 = 2;

/// Caffeine, small enough to have no fog.
fn picture(background: Background, ground: bool, style: Style) -> Image {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/caffeine.sdf");
    let document = ballstick::import::read_path(&path, &Default::default()).unwrap();
    let molecule = ballstick::bonds::assign(document.records[0].clone(), &Default::default());
    let options = SceneOptions { background, ground, style, ..SceneOptions::default() };
    let scene = Arc::new(Scene::new(&[Item::of(&molecule)], &options));
    let view = View::new(scene.fitted_camera(4.0 / 3.0), 320, 240);
    let mut renderer = CpuRenderer::new();
    renderer.load(scene).unwrap();
    renderer.image(&view, &Settings { samples: 16, ground_texels: 256, ao: 32, shadow: true }).unwrap()
}

/// The largest difference over the pixels that count, and how many those are.
fn largest(over: &Image, direct: &Image, mut laid: impl FnMut(&[u8]) -> Option<[u8; 3]>) -> (u8, usize) {
    assert_eq!(over.rgba.len(), direct.rgba.len());
    let (mut largest, mut count) = (0, 0);
    for (over, direct) in over.rgba.chunks_exact(4).zip(direct.rgba.chunks_exact(4)) {
        if let Some(laid) = laid(over) {
            largest = laid.iter().zip(direct).map(|(a, b)| a.abs_diff(*b)).fold(largest, u8::max);
            count += 1;
        }
    }
    (largest, count)
}

#[test]
fn edges_laid_over_a_colour_in_linear_light_are_those_drawn_on_it() {
    for style in [Style::BallAndStick, Style::Wireframe] {
        let over = picture(Background::Transparent, false, style);
        let edges = over.rgba.chunks_exact(4).filter(|pixel| (1..255).contains(&pixel[3])).count();
        assert!(edges > 1000, "{edges}");
        for color in COLORS {
            let under = [color.r, color.g, color.b];
            let direct = picture(Background::Color(color), false, style);
            let (difference, count) = largest(&over, &direct, |pixel| {
                // What is brighter than white is cut at white: for the edge alone or, drawn on a colour, with the colour.
                if pixel[3] < 255 && pixel[..3].contains(&255) && pixel[3] > 0 {
                    return None;
                }
                let alpha = f32::from(pixel[3]) / 255.0;
                Some(std::array::from_fn(|channel| {
                    let linear = |byte: u8| linear_from_srgb(f32::from(byte) / 255.0);
                    let sum = linear(pixel[channel]) * alpha + linear(under[channel]) * (1.0 - alpha);
                    (srgb_from_linear(sum) * 255.0).round() as u8
                }))
            });
            assert!(difference <= TOLERANCE && count > 320 * 240 - edges / 10, "{style:?} on {color}: {difference}");
        }
    }
}

#[test]
fn the_shadow_on_the_ground_laid_over_a_colour_as_programs_do_is_the_one_drawn_on_it() {
    let style = Style::BallAndStick;
    let over = picture(Background::Transparent, true, style);
    let alone = picture(Background::Transparent, false, style);
    for color in COLORS {
        let under = [color.r, color.g, color.b];
        let direct = picture(Background::Color(color), true, style);
        // Where there is nothing of the molecule.
        let mut molecule = alone.rgba.chunks_exact(4);
        let mut shaded = 0;
        let (difference, count) = largest(&over, &direct, |pixel| {
            if molecule.next().unwrap()[3] > 0 {
                return None;
            }
            assert_eq!(pixel[..3], [0; 3], "a shadow is black");
            shaded += usize::from(pixel[3] > 10);
            let left = 255 - u32::from(pixel[3]);
            Some(under.map(|byte| ((u32::from(byte) * left + 127) / 255) as u8))
        });
        assert!(shaded > 1000 && count > 20_000, "{shaded} of {count}");
        assert!(difference <= TOLERANCE, "{color}: {difference}");
    }
}

#[test]
fn what_is_opaque_is_the_same_on_any_background() {
    let style = Style::BallAndStick;
    let over = picture(Background::Transparent, true, style);
    for color in COLORS {
        let direct = picture(Background::Color(color), true, style);
        let opaque = |pixel: &[u8]| (pixel[3] == 255).then(|| [pixel[0], pixel[1], pixel[2]]);
        let (difference, count) = largest(&over, &direct, opaque);
        assert!(difference == 0 && count > 5000, "{color}: {difference} in {count}");
    }
}
