//! The reference: plain, scalar, single-threaded ray casting over one hierarchy. The only writer of golden pictures.

use super::intersect::primitive_t;
use super::shader::Shader;
use crate::math::Aabb;
use crate::render::field::{Field, GroundMap};
use crate::render::frame::{FrameConstants, resolve};
use crate::render::hierarchy::Hierarchy;
use crate::render::image::{GBuffer, Image};
use crate::render::settings::{Settings, View, sample_offset};
use crate::render::sky::{self, Reach, START_OFFSET, Turns};
use crate::render::solids::Solids;
use crate::scene::{PixelGrid, Ray, Scene};
use glam::{Vec3, Vec4};

/// The scene as the reference sees it.
struct Reference {
    solids: Solids,
    hierarchy: Hierarchy,
    near: f32,
}

impl Reference {
    fn new(scene: &Scene, view: &View) -> Reference {
        let solids = Solids::new(scene, view.camera.view_from_world());
        let hierarchy = Hierarchy::new(&solids.bounds());
        Reference { solids, hierarchy, near: view.camera.near }
    }

    /// The nearest primitive that is there in a sample (index and number of all), and its depth; of equals the first.
    fn nearest(&self, ray: &Ray, [sample, samples]: [u32; 2]) -> Option<(u32, f32)> {
        let inverse = ray.direction.recip();
        let mut best = (f32::INFINITY, u32::MAX);
        self.hierarchy.visit(
            &mut best,
            |best, b: &Aabb| {
                // The slack covers the rounding of the slab test: a box must not hide what it holds.
                let slack = 1e-5 * (b.min.abs().max(b.max.abs())).max_element();
                let (enter, leave) = b.grown(slack).slab(ray.origin, inverse)?;
                (leave >= self.near && enter <= best.0).then_some(enter)
            },
            |best, index| {
                let t = primitive_t(ray, &self.solids, index as usize, self.near);
                if (t, index) < *best && self.solids.is_drawn(index as usize, sample, samples) {
                    *best = (t, index);
                }
            },
        );
        best.0.is_finite().then_some((best.1, best.0))
    }

    /// Whether nothing stands between a point and the sky in this direction. What is hardly there hides nothing.
    fn is_free(&self, ray: &Ray) -> bool {
        let inverse = ray.direction.recip();
        let mut free = true;
        self.hierarchy.visit(
            &mut free,
            |free, b: &Aabb| {
                let slack = 1e-5 * (b.min.abs().max(b.max.abs())).max_element();
                let (enter, leave) = b.grown(slack).slab(ray.origin, inverse)?;
                (*free && leave >= 0.0).then_some(enter)
            },
            |free, index| {
                let t = primitive_t(ray, &self.solids, index as usize, 0.0);
                *free &= t.is_infinite() || !self.solids.is_drawn(index as usize, 0, 1);
            },
        );
        free
    }
}

/// What reaches surface points: rays in the directions that a sample asks.
struct Reaches {
    /// In view space.
    sky: Turns,
    key: Turns,
    unasked: Reach,
    near: f32,
}

impl Reaches {
    fn new(frame: &FrameConstants, view: &View, settings: &Settings) -> Reaches {
        let view_from_world = view.camera.view_from_world();
        let turned = |mut turns: Turns| {
            turns.directions.iter_mut().for_each(|d| *d = view_from_world.transform_vector3(*d));
            turns
        };
        let key =
            if settings.shadow { Turns::of_key(frame.key_in_world(), settings.samples) } else { Turns::default() };
        let sky = Turns::of_sky(settings.ao.min(Settings::MOST_DIRECTIONS), settings.samples);
        Reaches { sky: turned(sky), key: turned(key), unasked: frame.unasked(), near: view.camera.near }
    }

    fn of(&self, reference: &Reference, ray: &Ray, t: f32, normal: Vec3, sample: u32) -> Reach {
        if t <= self.near {
            return self.unasked;
        }
        let origin = ray.origin + ray.direction * t + normal * START_OFFSET;
        let free = |direction| reference.is_free(&Ray { origin, direction });
        sky::reach(normal, self.sky.of_sample(sample), self.key.of_sample(sample), self.unasked, free)
    }
}

/// Calls `pixel` for every pixel of the wanted region with its place in the full picture.
fn for_each_pixel(view: &View, mut pixel: impl FnMut(f32, f32)) {
    let region = view.region();
    for y in region.y..region.y + region.height {
        for x in region.x..region.x + region.width {
            pixel(x as f32, y as f32);
        }
    }
}

/// The finished picture.
#[must_use]
pub fn image(scene: &Scene, view: &View, settings: &Settings) -> Image {
    let frame = FrameConstants::new(scene, view, settings);
    let ground_map = Field::new(scene).ground_map(&frame);
    let reference = Reference::new(scene, view);
    let shader = Shader::new(&frame, &reference.solids, &ground_map);
    let grid: PixelGrid = view.pixel_grid();
    let region = view.region();
    let mut rgba = Vec::with_capacity(region.width as usize * region.height as usize * 4);
    let samples = settings.samples.clamp(1, 4096);
    let reaches = Reaches::new(&frame, view, settings);
    for_each_pixel(view, |x, y| {
        let backdrop = shader.backdrop(&grid.ray(grid.plane(x + 0.5, y + 0.5)));
        let mut sum = Vec4::ZERO;
        let mut unseen = 0u32;
        for sample in 0..samples {
            let [dx, dy] = sample_offset(sample, samples);
            let ray = grid.ray(grid.plane(x + dx, y + dy));
            let Some((index, t)) = reference.nearest(&ray, [sample, samples]).filter(|&(_, t)| shader.is_seen(&ray, t))
            else {
                unseen += 1;
                continue;
            };
            let normal = shader.surface(&ray, index, t).normal;
            let reach = reaches.of(&reference, &ray, t, normal, sample);
            sum += shader.primitive(&ray, index, t, reach);
        }
        let pixel = resolve(sum + backdrop * unseen as f32, samples);
        rgba.extend_from_slice(bytemuck::bytes_of(&pixel));
    });
    Image { width: region.width, height: region.height, rgba }
}

/// What is seen at the pixel centres.
#[must_use]
pub fn gbuffer(scene: &Scene, view: &View) -> GBuffer {
    let settings = Settings::default();
    let frame = FrameConstants::new(scene, view, &settings);
    let ground_map = GroundMap::none();
    let reference = Reference::new(scene, view);
    let shader = Shader::new(&frame, &reference.solids, &ground_map);
    let grid = view.pixel_grid();
    let region = view.region();
    let mut buffer = GBuffer::with_capacity(region.width, region.height);
    for_each_pixel(view, |x, y| {
        let ray = grid.ray(grid.plane(x + 0.5, y + 0.5));
        buffer.push(shader.facts(&ray, reference.nearest(&ray, [0, 1])));
    });
    buffer
}
