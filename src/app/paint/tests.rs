use super::*;
use egui::epaint::{Color32, ColorImage, ImageDelta, Mesh, Vertex, WHITE_UV};
use egui::{Rect, TextureOptions, pos2, vec2};

const RED: Color32 = Color32::from_rgb(255, 0, 0);

fn painter() -> Painter {
    let mut delta = TexturesDelta::default();
    // White in the corner, as egui has it, and a step of grey beside it.
    let image = ColorImage::new([2, 1], vec![Color32::WHITE, Color32::from_rgba_premultiplied(128, 128, 128, 128)]);
    delta.push(TextureId::default(), ImageDelta::full(image, TextureOptions::LINEAR));
    let mut painter = Painter::default();
    painter.update(&mut delta);
    painter
}

fn clipped(mesh: Mesh, clip: Rect) -> ClippedPrimitive {
    ClippedPrimitive { clip_rect: clip, primitive: Primitive::Mesh(mesh) }
}

fn everywhere() -> Rect {
    Rect::from_min_size(pos2(0.0, 0.0), vec2(100.0, 100.0))
}

const SIZE: [usize; 2] = [8, 6];
const ALL: PxRect = PxRect { left: 0, top: 0, right: 8, bottom: 6 };

fn painted(primitives: &[ClippedPrimitive], scale: f32) -> Vec<u32> {
    let mut pixels = vec![0x00FF_FFFF; 48];
    painter().paint(&mut Canvas { pixels: &mut pixels, size: SIZE }, ALL, primitives, scale);
    pixels
}

fn triangle(points: [[f32; 2]; 3], color: Color32) -> Mesh {
    let mut mesh = Mesh::default();
    for [x, y] in points {
        mesh.vertices.push(Vertex { pos: pos2(x, y), uv: WHITE_UV, color });
    }
    mesh.indices = vec![0, 1, 2];
    mesh
}

#[test]
fn rectangles_fill_the_pixels_whose_centres_they_cover_inside_their_clip() {
    let mut mesh = Mesh::default();
    mesh.add_colored_rect(Rect::from_min_max(pos2(1.0, 1.0), pos2(3.0, 2.0)), RED);
    let pixels = painted(&[clipped(mesh.clone(), everywhere())], 2.0);
    let red: Vec<usize> = (0..48).filter(|&i| pixels[i] == 0x00FF_0000).collect();
    assert_eq!(red, [18, 19, 20, 21, 26, 27, 28, 29], "2..6 × 2..4");
    let clip = Rect::from_min_max(pos2(2.0, 0.0), pos2(9.0, 1.5));
    let pixels = painted(&[clipped(mesh, clip)], 2.0);
    assert_eq!((0..48).filter(|&i| pixels[i] == 0x00FF_0000).collect::<Vec<_>>(), [20, 21]);
}

#[test]
fn triangles_that_share_an_edge_leave_no_gap_and_no_double_pixel() {
    let half = Color32::from_rgba_premultiplied(0, 0, 0, 128);
    for corner in [[5.3, 0.2], [7.9, 3.3], [6.5, 5.9]] {
        let [a, b, c] = [[0.3, 0.7], corner, [1.1, 5.6]];
        let d = [b[0] + c[0] - a[0], b[1] + c[1] - a[1]];
        let two = [triangle([a, b, c], half), triangle([c, d, b], half)].map(|mesh| clipped(mesh, everywhere()));
        let pixels = painted(&two, 1.0);
        assert!(pixels.iter().all(|&pixel| pixel == 0x00FF_FFFF || pixel == 0x007F_7F7F), "{pixels:x?}");
        let inside = |x: f32, y: f32| {
            let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
            let det = u[0] * v[1] - u[1] * v[0];
            let (px, py) = (x - a[0], y - a[1]);
            let (s, t) = ((px * v[1] - py * v[0]) / det, (u[0] * py - u[1] * px) / det);
            s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0
        };
        for (i, &pixel) in pixels.iter().enumerate() {
            let is_in = inside((i % 8) as f32 + 0.5, (i / 8) as f32 + 0.5);
            assert_eq!(pixel == 0x007F_7F7F, is_in, "{i}");
        }
    }
}

#[test]
fn colours_change_evenly_over_a_triangle() {
    let mut mesh = triangle([[0.0, 0.0], [8.0, 0.0], [0.0, 60.0]], Color32::BLACK);
    mesh.vertices[1].color = Color32::WHITE;
    let pixels = painted(&[clipped(mesh, everywhere())], 1.0);
    let grey: Vec<u32> = pixels[..7].iter().map(|pixel| pixel & 0xFF).collect();
    assert!(grey.windows(2).all(|pair| (30..=34).contains(&(pair[1] - pair[0]))), "{grey:?}");
}

#[test]
fn letters_are_copied_texel_by_texel_and_others_interpolated() {
    let texture_rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let glyph = |rect: Rect| {
        let mut mesh = Mesh::default();
        mesh.add_rect_with_uv(rect, texture_rect, RED);
        clipped(mesh, everywhere())
    };
    let pixels = painted(&[glyph(Rect::from_min_max(pos2(3.0, 2.0), pos2(5.0, 3.0)))], 1.0);
    assert_eq!(pixels[18..22], [0x00FF_FFFF, 0x00FF_0000, 0x00FF_7F7F, 0x00FF_FFFF]);
    let wide = painted(&[glyph(Rect::from_min_max(pos2(0.0, 2.0), pos2(8.0, 3.0)))], 1.0);
    let green: Vec<u32> = wide[16..24].iter().map(|pixel| pixel >> 8 & 0xFF).collect();
    assert!(green.windows(2).all(|pair| pair[0] <= pair[1]) && green[0] == 0 && green[7] == 0x7F, "{green:?}");
}

#[test]
fn only_what_changed_is_damaged() {
    let square = |x: f32, color: Color32| {
        let mut mesh = Mesh::default();
        mesh.add_colored_rect(Rect::from_min_size(pos2(x, 10.0), vec2(10.0, 10.0)), color);
        clipped(mesh, everywhere())
    };
    let size = [100, 100];
    let mut painter = painter();
    let rect = |left, right| PxRect { left, top: 9, right, bottom: 21 };
    assert_eq!(painter.damage(&[square(0.0, RED)], 1.0, size), [PxRect { left: 0, top: 0, right: 100, bottom: 100 }]);
    assert_eq!(painter.damage(&[square(0.0, RED)], 1.0, size), []);
    // A second one comes, changes its colour, moves a little, goes.
    assert_eq!(painter.damage(&[square(0.0, RED), square(50.0, RED)], 1.0, size), [rect(49, 61)]);
    let blue = Color32::BLUE;
    assert_eq!(painter.damage(&[square(0.0, RED), square(50.0, blue)], 1.0, size), [rect(49, 61)]);
    assert_eq!(painter.damage(&[square(0.0, RED), square(55.0, blue)], 1.0, size), [rect(49, 66)]);
    assert_eq!(painter.damage(&[square(55.0, blue)], 1.0, size), [rect(0, 11)]);
    // Two that change places may cover one another.
    painter.damage(&[square(0.0, RED), square(5.0, blue)], 1.0, size);
    assert_eq!(painter.damage(&[square(5.0, blue), square(0.0, RED)], 1.0, size), [rect(0, 16)]);
}

#[test]
fn broken_meshes_paint_nothing_and_do_no_harm() {
    let mut mesh = triangle([[f32::NAN, 0.0], [8.0, 0.0], [0.0, 6.0]], RED);
    mesh.indices.extend([0, 1, 99]);
    let far = triangle([[-1e9, -1e9], [1e9, -1e9], [0.0, -5.0]], RED);
    assert!(painted(&[clipped(mesh, everywhere()), clipped(far, everywhere())], 1.0).iter().all(|&p| p == 0x00FF_FFFF));
}
