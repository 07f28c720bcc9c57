//! Any triangle: soft edges, rounded corners, shadows.
//!
//! A pixel belongs to it if its centre is inside; where an edge is found in a row depends on the edge alone, so that two triangles that
//! share it neither leave a gap nor paint a pixel twice.

use super::blend::{modulated, over, packed};
use super::texture::Texture;
use super::{Canvas, PxRect};
use egui::epaint::{Vertex, WHITE_UV};

/// Where an edge crosses the row at height `y`.
fn crossing(a: [f32; 2], b: [f32; 2], y: f32) -> Option<f32> {
    let (a, b) = if (a[1], a[0]) <= (b[1], b[0]) { (a, b) } else { (b, a) };
    (a[1] <= y && y < b[1]).then(|| a[0] + (y - a[1]) * ((b[0] - a[0]) / (b[1] - a[1])))
}

/// Something that changes evenly over the triangle.
#[derive(Clone, Copy)]
struct Plane {
    base: f32,
    dx: f32,
    dy: f32,
}

impl Plane {
    fn at(self, x: f32, y: f32) -> f32 {
        self.base + self.dx * x + self.dy * y
    }
}

/// Fills a triangle.
pub(super) fn fill(canvas: &mut Canvas<'_>, clip: PxRect, corners: [&Vertex; 3], texture: &Texture, scale: f32) {
    let points = corners.map(|corner| [corner.pos.x * scale, corner.pos.y * scale]);
    if !points.iter().flatten().all(|x| x.is_finite()) {
        return;
    }
    let [p, q, r] = points;
    let area = (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]);
    if area == 0.0 {
        return;
    }
    let plane = |values: [f32; 3]| {
        let [a, b, c] = values;
        let dx = ((b - a) * (r[1] - p[1]) - (c - a) * (q[1] - p[1])) / area;
        let dy = ((c - a) * (q[0] - p[0]) - (b - a) * (r[0] - p[0])) / area;
        Plane { base: a - dx * p[0] - dy * p[1], dx, dy }
    };
    let colors = corners.map(|corner| packed(corner.color));
    let is_flat = colors == [colors[0]; 3];
    let is_plain = corners.iter().all(|corner| corner.uv == WHITE_UV);
    if is_flat && colors[0] == 0 {
        return;
    }
    let channels = [0, 8, 16, 24].map(|shift| plane(colors.map(|color| (color >> shift & 0xFF) as f32)));
    let uv = [plane(corners.map(|corner| corner.uv.x)), plane(corners.map(|corner| corner.uv.y))];
    let (low, high) = (p[1].min(q[1]).min(r[1]), p[1].max(q[1]).max(r[1]));
    let first = ((low - 0.5).ceil().max(0.0) as usize).max(clip.top);
    let last = ((high - 0.5).ceil().max(0.0) as usize).min(clip.bottom);
    for row in first..last {
        let y = row as f32 + 0.5;
        let crossings = [crossing(p, q, y), crossing(q, r, y), crossing(r, p, y)];
        let found = crossings.into_iter().flatten();
        let (left, right) = found.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, r), x| (l.min(x), r.max(x)));
        if left >= right {
            continue;
        }
        let start = ((left - 0.5).ceil().max(0.0) as usize).max(clip.left);
        let end = ((right - 0.5).ceil().max(0.0) as usize).min(clip.right);
        if start >= end {
            continue;
        }
        let pixels = &mut canvas.pixels[row * canvas.size[0] + start..row * canvas.size[0] + end];
        if is_flat && is_plain {
            if colors[0] >> 24 == 255 {
                pixels.fill(colors[0] & 0x00FF_FFFF);
            } else {
                pixels.iter_mut().for_each(|pixel| *pixel = over(colors[0], *pixel));
            }
            continue;
        }
        for (x, pixel) in (start..).zip(pixels) {
            let x = x as f32 + 0.5;
            let color = if is_flat {
                colors[0]
            } else {
                let byte = |index: usize| ((channels[index].at(x, y) + 0.5).clamp(0.0, 255.0)) as u32;
                byte(3) << 24 | byte(2) << 16 | byte(1) << 8 | byte(0)
            };
            let color = if is_plain { color } else { modulated(color, texture.at(uv[0].at(x, y), uv[1].at(x, y))) };
            if color != 0 {
                *pixel = over(color, *pixel);
            }
        }
    }
}
