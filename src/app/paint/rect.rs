//! Upright rectangles: panels, and letters at the texture's own scale.

use super::blend::{modulated, over, packed};
use super::texture::Texture;
use super::{Canvas, PxRect};
use egui::epaint::{Vertex, WHITE_UV};

/// How far from a pixel's corner still counts as on it, pixels: egui rounds what it places, in f32.
const ON_PIXEL: f32 = 0.02;

/// Fills a rectangle given by its upper left, upper right, lower left and lower right corner; `false` where it is none, or not of the
/// kinds that are cheap, and nothing is done.
pub(super) fn fill(
    canvas: &mut Canvas<'_>,
    clip: PxRect,
    [a, b, c, d]: [&Vertex; 4],
    texture: &Texture,
    scale: f32,
) -> bool {
    let upright = a.pos.y == b.pos.y && c.pos.y == d.pos.y && a.pos.x == c.pos.x && b.pos.x == d.pos.x;
    let one_color = a.color == b.color && a.color == c.color && a.color == d.color;
    if !(upright && one_color && a.pos.x <= b.pos.x && a.pos.y <= c.pos.y) {
        return false;
    }
    let edges = [a.pos.x, a.pos.y, d.pos.x, d.pos.y].map(|edge| edge * scale);
    let color = packed(a.color);
    if [a, b, c, d].iter().all(|vertex| vertex.uv == WHITE_UV) {
        // As with triangles, pixels count by their centres.
        let [left, top, right, bottom] = edges.map(|edge| (edge - 0.5).ceil().max(0.0) as usize);
        if let Some(part) = (PxRect { left, top, right, bottom }).cut(clip) {
            plain(canvas, part, color);
        }
        return true;
    }
    let [left, top, right, bottom] = edges.map(f32::round);
    let on_pixels = edges.iter().zip([left, top, right, bottom]).all(|(edge, px)| (edge - px).abs() < ON_PIXEL);
    let [texture_width, texture_height] = texture.size().map(|side| side as f32);
    let texels = [a.uv.x * texture_width, a.uv.y * texture_height, d.uv.x * texture_width, d.uv.y * texture_height];
    let [u0, v0, u1, v1] = texels.map(f32::round);
    let on_texels = texels.iter().zip([u0, v0, u1, v1]).all(|(edge, texel)| (edge - texel).abs() < ON_PIXEL);
    let same_scale = u1 - u0 == right - left && v1 - v0 == bottom - top && u0 >= 0.0 && v0 >= 0.0;
    if !(on_pixels && on_texels && same_scale) {
        return false;
    }
    let whole = [left, top, right, bottom].map(|edge| edge.max(0.0) as usize);
    let whole = PxRect { left: whole[0], top: whole[1], right: whole[2], bottom: whole[3] };
    let Some(part) = whole.cut(clip) else { return true };
    // What of the texture is left of and above the part.
    let (skip_x, skip_y) = (part.left as f32 - left, part.top as f32 - top);
    for y in part.top..part.bottom {
        let v = (v0 + skip_y) as usize + (y - part.top);
        let Some(texels) = texture.row((u0 + skip_x) as usize, v, part.right - part.left) else { continue };
        let row = &mut canvas.pixels[y * canvas.size[0] + part.left..y * canvas.size[0] + part.right];
        for (pixel, &texel) in row.iter_mut().zip(texels) {
            if texel != 0 {
                *pixel = over(modulated(texel, color), *pixel);
            }
        }
    }
    true
}

fn plain(canvas: &mut Canvas<'_>, part: PxRect, color: u32) {
    if color == 0 {
        return;
    }
    for y in part.top..part.bottom {
        let row = &mut canvas.pixels[y * canvas.size[0] + part.left..y * canvas.size[0] + part.right];
        if color >> 24 == 255 {
            row.fill(color & 0x00FF_FFFF);
        } else {
            row.iter_mut().for_each(|pixel| *pixel = over(color, *pixel));
        }
    }
}
