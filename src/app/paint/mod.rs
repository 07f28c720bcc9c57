//! Paints the user interface on the CPU: egui's triangles into the window's pixels, so that the window needs no GPU.
//!
//! egui gives lists of textured triangles with clip rectangles, colours premultiplied and blended as sRGB bytes. Nearly all of their
//! pixels are upright rectangles, plain (panels) or with a texture of the same scale (letters), which [`rect`] fills row by row; the rest,
//! rounded corners and soft edges, goes through [`triangle`]. Only what differs from the last frame is painted again ([`Painter::damage`]).
//!
//! Limits: textures are clamped at their edges, and minified without mipmaps; the interface has none that are repeated or far reduced.

mod blend;
mod damage;
mod rect;
mod texture;
mod triangle;

pub(super) use blend::pixel_of;
pub(super) use damage::PxRect;

use damage::Shape;
use egui::epaint::{ClippedPrimitive, Primitive};
use egui::{TextureId, TexturesDelta};
use std::collections::HashMap;
use texture::Texture;

/// Pixels to paint on: `0x00RRGGBB`, rows from the top.
pub(super) struct Canvas<'a> {
    pub(super) pixels: &'a mut [u32],
    pub(super) size: [usize; 2],
}

/// Holds egui's textures and what was painted last.
#[derive(Default)]
pub(super) struct Painter {
    textures: HashMap<TextureId, Texture>,
    shapes: Vec<Shape>,
    /// Whether a texture was replaced as a whole, so that all that shows it is to be painted again.
    replaced: bool,
}

impl Painter {
    /// Takes over new and changed textures; those to be freed are freed at once, so paint first what needs them.
    pub(super) fn update(&mut self, delta: &mut TexturesDelta) {
        for (id, changes) in delta.set.drain() {
            for change in changes {
                match (change.pos, self.textures.get_mut(&id)) {
                    (Some(at), Some(texture)) => texture.patch(at, &change.image),
                    (Some(_), None) => {}
                    (None, _) => {
                        self.replaced = true;
                        self.textures.insert(id, Texture::new(&change.image, change.options));
                    }
                }
            }
        }
        for id in delta.free.drain() {
            self.textures.remove(&id);
        }
    }

    /// What of the window differs from the frame of the last call, as rectangles that do not overlap.
    pub(super) fn damage(&mut self, primitives: &[ClippedPrimitive], scale: f32, size: [usize; 2]) -> Vec<PxRect> {
        let shapes: Vec<Shape> = primitives.iter().filter_map(|primitive| Shape::of(primitive, scale, size)).collect();
        let whole = PxRect { left: 0, top: 0, right: size[0], bottom: size[1] };
        let damage =
            if std::mem::take(&mut self.replaced) { vec![whole] } else { damage::between(&self.shapes, &shapes) };
        self.shapes = shapes;
        damage
    }

    /// Paints what of the primitives falls into a rectangle; what is behind them is there already.
    pub(super) fn paint(&self, canvas: &mut Canvas<'_>, within: PxRect, primitives: &[ClippedPrimitive], scale: f32) {
        for primitive in primitives {
            let Some(clip) = PxRect::of(primitive.clip_rect, scale, canvas.size).cut(within) else { continue };
            let Primitive::Mesh(mesh) = &primitive.primitive else { continue };
            let Some(texture) = self.textures.get(&mesh.texture_id) else { continue };
            let vertex = |&index: &u32| mesh.vertices.get(index as usize);
            let mut rest = &mesh.indices[..];
            while let [a, b, c, after @ ..] = rest {
                rest = after;
                // Two triangles of one upright rectangle follow one another.
                if let [d, e, f, after @ ..] = rest
                    && (d, e) == (c, b)
                    && let (Some(a), Some(b), Some(c), Some(f)) = (vertex(a), vertex(b), vertex(c), vertex(f))
                    && rect::fill(canvas, clip, [a, b, c, f], texture, scale)
                {
                    rest = after;
                    continue;
                }
                if let (Some(a), Some(b), Some(c)) = (vertex(a), vertex(b), vertex(c)) {
                    triangle::fill(canvas, clip, [a, b, c], texture, scale);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
