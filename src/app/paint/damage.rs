//! Which parts of the window a new frame changes.

use egui::epaint::{ClippedPrimitive, Primitive};

/// A rectangle of pixels, the right and lower edge not included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::app) struct PxRect {
    pub(in crate::app) left: usize,
    pub(in crate::app) top: usize,
    pub(in crate::app) right: usize,
    pub(in crate::app) bottom: usize,
}

impl PxRect {
    /// The pixels that a rectangle in points covers; egui's clip rectangles are rounded so.
    pub(in crate::app) fn of(rect: egui::Rect, scale: f32, [width, height]: [usize; 2]) -> PxRect {
        let px = |x: f32, most: usize| ((x * scale).round().max(0.0) as usize).min(most);
        PxRect {
            left: px(rect.min.x, width),
            top: px(rect.min.y, height),
            right: px(rect.max.x, width),
            bottom: px(rect.max.y, height),
        }
    }

    /// The common part, if there is one.
    pub(in crate::app) fn cut(self, other: PxRect) -> Option<PxRect> {
        let cut = PxRect {
            left: self.left.max(other.left),
            top: self.top.max(other.top),
            right: self.right.min(other.right),
            bottom: self.bottom.min(other.bottom),
        };
        (cut.left < cut.right && cut.top < cut.bottom).then_some(cut)
    }

    /// The smallest one around both.
    fn around(self, other: PxRect) -> PxRect {
        PxRect {
            left: self.left.min(other.left),
            top: self.top.min(other.top),
            right: self.right.max(other.right),
            bottom: self.bottom.max(other.bottom),
        }
    }

    /// Adds a rectangle to a list of such that do not overlap, joining it with those it touches.
    pub(in crate::app) fn add_to(mut self, list: &mut Vec<PxRect>) {
        while let Some(index) = list.iter().position(|other| other.cut(self).is_some()) {
            self = self.around(list.swap_remove(index));
        }
        list.push(self);
    }
}

/// What a primitive covers and a number that tells its content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    bounds: PxRect,
    content: u64,
}

impl Shape {
    /// `None` for what covers nothing.
    pub(super) fn of(primitive: &ClippedPrimitive, scale: f32, size: [usize; 2]) -> Option<Shape> {
        let Primitive::Mesh(mesh) = &primitive.primitive else { return None };
        let clip = PxRect::of(primitive.clip_rect, scale, size);
        // Triangles reach pixels whose centres they cover; one more on each side is safe.
        let bounds = PxRect::of(mesh.calc_bounds().expand(1.0 / scale), scale, size).cut(clip)?;
        let mut content = u64::from(scale.to_bits());
        let mut mix =
            |word: u32| content = (content.rotate_left(5) ^ u64::from(word)).wrapping_mul(0x517c_c1b7_2722_0a95);
        bytemuck::cast_slice::<_, u32>(&mesh.vertices).iter().for_each(|&word| mix(word));
        mesh.indices.iter().for_each(|&index| mix(index));
        Some(Shape { bounds, content })
    }
}

/// Where two frames differ.
pub(super) fn between(old: &[Shape], new: &[Shape]) -> Vec<PxRect> {
    // The same in front and behind, as far as it goes, is on the screen; in between everything may lie over everything.
    let front = old.iter().zip(new).take_while(|(a, b)| a == b).count();
    let (old, new) = (&old[front..], &new[front..]);
    let mut damage = Vec::new();
    let is_kept = |shape: &Shape, others: &[Shape]| others.contains(shape);
    // A shape that is in both lists in the same order among those that are has not moved; where the order changed, all is painted.
    let kept = |list: &[Shape], others: &[Shape]| -> Vec<Shape> {
        list.iter().copied().filter(|shape| is_kept(shape, others)).collect()
    };
    let same_order = kept(old, new) == kept(new, old);
    for (list, others) in [(old, new), (new, old)] {
        for shape in list.iter().filter(|shape| !(same_order && is_kept(shape, others))) {
            shape.bounds.add_to(&mut damage);
        }
    }
    damage
}
