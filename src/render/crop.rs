//! Which part of a picture shows anything: what is not background, by colour, or by opacity where that is transparent.
//!
//! Found without drawing the whole picture. The exact bounds of all balls and sticks, and what shows in a small picture,
//! grown by one of its pixels, hold everything. From each side of that the picture itself is then drawn in
//! narrow bands, up to the first that shows something. So the answer is that of the full picture, at any size.
//!
//! Limit: what is smaller than a pixel of the small picture and neither ball nor stick may be missed where it
//! stands apart from all else. (The ground's shadow is smooth.)

use super::bounds::{BoundsCamera, cylinder_rect, sphere_rect};
use super::frame::FrameConstants;
use super::outline::Outline;
use super::solids::{Cylinder, Sphere};
use super::{Image, Renderer, Settings, View};
use crate::error::Result;
use crate::scene::{Background, Region, Scene};
use glam::{DVec2, Vec2};
use rayon::prelude::*;

/// The small picture has an eighth of the pixels a side, but as many as these on its longer one: enough to see where
/// a shadow ends, and no more than a second's work. Chosen.
const SMALL_SIDE: std::ops::RangeInclusive<u32> = 256..=2048;

/// Differences in a channel, or opacities, of 1/255 or less are no sight.
const UNSEEN: u8 = 1;

/// Rows or columns of the first band, as wide as a tile of the CPU renderer; every further one is twice as wide.
const BAND: u32 = 32;

/// Pixels that a band has at most, if it has more than [`BAND`] rows or columns: 64 MiB.
const BAND_PIXELS: u32 = 1 << 24;

/// The smallest region of the whole picture (the view's own region is not asked) that holds all pixels that differ from
/// the background by more than 1/255 in a channel, or are more than 1/255 opaque if it is transparent. `None` if
/// none does. The renderer must hold the scene.
///
/// # Errors
/// What the renderer returns.
pub fn seen_region(
    renderer: &mut dyn Renderer,
    scene: &Scene,
    view: &View,
    settings: &Settings,
) -> Result<Option<Region>> {
    let background = scene.background;
    let small = small_view(view);
    let plain = Settings { ao: 0, shadow: false, ..*settings };
    let image = renderer.image(&small, &plain)?;
    let everything = Region { x: 0, y: 0, width: small.width, height: small.height };
    let outline = Outline::of(&FrameConstants::new(scene, view, settings));
    let mut bounds = solid_bounds(scene, view, outline.as_ref());
    // Here any difference counts: within a pixel of it may be a larger one.
    if let Some([left, top, right, bottom]) = seen_box(&image, background, 0, everything) {
        let scale = f64::from(view.height) / f64::from(small.height);
        let full = |x: f64, y: f64| {
            let from_center = DVec2::new(x - f64::from(small.width) * 0.5, y - f64::from(small.height) * 0.5);
            from_center * scale + DVec2::new(f64::from(view.width), f64::from(view.height)) * 0.5
        };
        bounds.add(full(f64::from(left) - 1.0, f64::from(top) - 1.0));
        bounds.add(full(f64::from(right) + 1.0, f64::from(bottom) + 1.0));
    }
    let Some(mut region) = bounds.region(view) else { return Ok(None) };
    for side in [Side::Top, Side::Bottom, Side::Left, Side::Right] {
        match side.trimmed(region, |band| {
            let part = View { region: Some(band), ..*view };
            Ok(seen_box(&renderer.image(&part, settings)?, background, UNSEEN, band))
        })? {
            Some(rest) => region = rest,
            None => return Ok(None),
        }
    }
    Ok(Some(region))
}

/// The same view in few pixels.
fn small_view(view: &View) -> View {
    let longer = view.width.max(view.height);
    let wanted = (longer / 8).clamp(*SMALL_SIDE.start(), *SMALL_SIDE.end()).min(longer);
    let scale = f64::from(wanted) / f64::from(longer);
    let height = (f64::from(view.height) * scale).round().max(1.0);
    // The camera fixes what the height shows; the width must hold all that the full picture does.
    let width = (f64::from(view.width) * height / f64::from(view.height)).ceil();
    View::new(view.camera, width as u32, height as u32)
}

/// A box in pixels of the full picture, empty at first.
struct PixelBox {
    low: DVec2,
    high: DVec2,
}

impl PixelBox {
    fn add(&mut self, point: DVec2) {
        self.low = self.low.min(point);
        self.high = self.high.max(point);
    }

    /// The pixels it touches; `None` if it is empty or beside the picture.
    fn region(&self, view: &View) -> Option<Region> {
        let size = DVec2::new(f64::from(view.width), f64::from(view.height));
        let (low, high) = (self.low.floor().max(DVec2::ZERO), self.high.ceil().min(size));
        (low.x < high.x && low.y < high.y).then_some(Region {
            x: low.x as u32,
            y: low.y as u32,
            width: (high.x - low.x) as u32,
            height: (high.y - low.y) as u32,
        })
    }
}

/// Bounds of all balls and sticks, lines included.
fn solid_bounds(scene: &Scene, view: &View, outline: Option<&Outline>) -> PixelBox {
    let view_from_world = view.camera.view_from_world();
    let grid = view.pixel_grid();
    let camera = BoundsCamera { orthographic: grid.orthographic, near: view.camera.near };
    let rects = scene.placements.par_iter().flat_map(|placement| {
        let view_from_block = view_from_world * placement.world_from_block;
        let block = &scene.blocks[placement.block];
        let spheres = block.spheres.par_iter().filter_map(move |instance| {
            let s = Sphere::new(instance, &view_from_block);
            let s = outline.map_or(s, |outline| outline.sphere(&s));
            sphere_rect(s.center, s.radius, &camera)
        });
        let cylinders = block.cylinders.par_iter().filter_map(move |instance| {
            let c = Cylinder::new(instance, &view_from_block)?;
            let c = outline.map_or(c, |outline| outline.cylinder(&c));
            let [a, b] = c.ends();
            cylinder_rect(a, b, c.radius, c.round(), &camera)
        });
        spheres.chain(cylinders)
    });
    let none = || (Vec2::INFINITY, Vec2::NEG_INFINITY);
    let around = |a: (Vec2, Vec2), b: (Vec2, Vec2)| (a.0.min(b.0), a.1.max(b.1));
    let (low, high) = rects.map(|rect| rect.upright()).reduce(none, around);
    let mut bounds = PixelBox { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };
    if low.cmple(high).all() {
        let px = |x: f32, y: f32| {
            let plane = DVec2::new(f64::from(x), -f64::from(y)); // the picture's y runs down
            plane / f64::from(grid.plane_per_px) + Vec2::from(grid.center_px).as_dvec2()
        };
        // A pixel for rounding.
        bounds.add(px(low.x, high.y) - 1.0);
        bounds.add(px(high.x, low.y) + 1.0);
    }
    bounds
}

/// Left, top, right and bottom (the last two exclusive) of what differs by more than `unseen`, in pixels of the picture that
/// `image` shows the region `at` of.
fn seen_box(image: &Image, background: Background, unseen: u8, at: Region) -> Option<[u32; 4]> {
    let is_seen = |pixel: &[u8]| match background {
        Background::Transparent => pixel[3] > unseen,
        Background::Color(color) => {
            pixel.iter().zip([color.r, color.g, color.b]).any(|(channel, under)| channel.abs_diff(under) > unseen)
        }
    };
    let rows = image.rgba.par_chunks_exact(image.width as usize * 4).enumerate().filter_map(|(y, row)| {
        let first = row.chunks_exact(4).position(is_seen)? as u32;
        let last = row.chunks_exact(4).rposition(is_seen)? as u32;
        Some([first, y as u32, last + 1, y as u32 + 1])
    });
    let around = |a: [u32; 4], b: [u32; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
    rows.reduce_with(around).map(|[l, t, r, b]| [l + at.x, t + at.y, r + at.x, b + at.y])
}

/// From where a region is made smaller.
#[derive(Debug, Clone, Copy)]
enum Side {
    Top,
    Bottom,
    Left,
    Right,
}

impl Side {
    /// The region without what is empty on this side; `None` if it is empty. `seen` gives the box of what a part of it shows.
    fn trimmed(
        self,
        region: Region,
        mut seen: impl FnMut(Region) -> Result<Option<[u32; 4]>>,
    ) -> Result<Option<Region>> {
        let (depth, across) = match self {
            Side::Top | Side::Bottom => (region.height, region.width),
            Side::Left | Side::Right => (region.width, region.height),
        };
        let (mut done, mut size) = (0, BAND);
        while done < depth {
            let size_now = size.min(depth - done);
            if let Some([left, top, right, bottom]) = seen(self.band(region, done, size_now))? {
                let empty = match self {
                    Side::Top => top - region.y,
                    Side::Bottom => region.y + region.height - bottom,
                    Side::Left => left - region.x,
                    Side::Right => region.x + region.width - right,
                };
                return Ok(Some(self.band(region, empty, depth - empty)));
            }
            done += size_now;
            size = (size * 2).min(BAND_PIXELS / across).max(BAND);
        }
        Ok(None)
    }

    /// The part of a region that starts so many pixels from this side.
    fn band(self, region: Region, from: u32, size: u32) -> Region {
        let Region { x, y, width, height } = region;
        match self {
            Side::Top => Region { y: y + from, height: size, ..region },
            Side::Bottom => Region { y: y + height - from - size, height: size, ..region },
            Side::Left => Region { x: x + from, width: size, ..region },
            Side::Right => Region { x: x + width - from - size, width: size, ..region },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Srgb8;
    use crate::render::cpu::CpuRenderer;
    use crate::scene::{Item, SceneOptions, Style};
    use crate::structure::{AtomRecord, Diagnostics, StructureBuilder};
    use std::sync::Arc;

    fn scene(points: &[[f64; 3]], options: &SceneOptions) -> Arc<Scene> {
        let mut builder = StructureBuilder::new();
        for &point in points {
            builder.push_atom(&AtomRecord { position: point.into(), ..AtomRecord::default() });
        }
        let structure = builder.build(&mut Diagnostics::default());
        Arc::new(Scene::new(&[Item::of(&structure)], options))
    }

    #[test]
    fn the_region_is_that_of_the_full_picture_at_any_size_on_any_background() {
        let points = [[0.0, 0.0, 0.0], [9.0, 4.0, 1.0], [-6.0, 3.0, -2.0]];
        let settings = Settings { samples: 4, ground_texels: 64, ao: 8, shadow: true };
        let color = |r, g, b| Background::Color(Srgb8::rgb(r, g, b));
        for background in [Background::Transparent, color(255, 255, 255), color(0, 0, 0), color(40, 90, 160)] {
            for (ground, style) in [(true, Style::BallAndStick), (false, Style::Wireframe)] {
                let scene = scene(&points, &SceneOptions { background, ground, style, ..SceneOptions::default() });
                let mut renderer = CpuRenderer::new();
                renderer.load(Arc::clone(&scene)).unwrap();
                for (width, height) in [(700, 300), (120, 333), (31, 17), (1, 900), (900, 1), (1, 1)] {
                    let view = View::new(scene.fitted_camera(width as f32 / height as f32), width, height);
                    let all = Region { x: 0, y: 0, width, height };
                    let whole = renderer.image(&view, &settings).unwrap();
                    let expected = seen_box(&whole, background, UNSEEN, all);
                    let found = seen_region(&mut renderer, &scene, &view, &settings).unwrap();
                    let found = found.map(|r| [r.x, r.y, r.x + r.width, r.y + r.height]);
                    assert_eq!(found, expected, "{background:?} {ground} {width}x{height}");
                    if width > 100 && height > 100 {
                        let [left, _, right, _] = found.unwrap();
                        assert!((width / 3..=width).contains(&(right - left)), "{found:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn an_empty_picture_shows_nothing() {
        let scene = Arc::new(Scene::from_blocks(vec![], vec![]));
        let mut renderer = CpuRenderer::new();
        renderer.load(Arc::clone(&scene)).unwrap();
        let view = View::new(scene.fitted_camera(1.0), 300, 300);
        assert_eq!(seen_region(&mut renderer, &scene, &view, &Settings::default()).unwrap(), None);
    }

    #[test]
    fn bands_go_on_until_something_shows_and_find_its_very_edge() {
        let region = Region { x: 10, y: 20, width: 500, height: 300 };
        let thing = [100, 200, 400, 201]; // left, top, right, bottom
        let mut bands = 0;
        let mut seen = |band: Region| {
            bands += 1;
            let part = [
                thing[0].max(band.x),
                thing[1].max(band.y),
                thing[2].min(band.x + band.width),
                thing[3].min(band.y + band.height),
            ];
            Ok((part[0] < part[2] && part[1] < part[3]).then_some(part))
        };
        let mut rest = region;
        for side in [Side::Top, Side::Bottom, Side::Left, Side::Right] {
            rest = side.trimmed(rest, &mut seen).unwrap().unwrap();
        }
        assert_eq!(rest, Region { x: 100, y: 200, width: 300, height: 1 });
        assert_eq!(Side::Left.trimmed(region, |_| Ok(None)).unwrap(), None);
        assert!(bands < 12, "{bands}");
    }
}
