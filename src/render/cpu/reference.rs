//! The reference: plain, scalar, single-threaded ray casting over one hierarchy. The only writer of golden pictures.

use super::intersect::{outlined_t, primitive_t};
use super::shader::Shader;
use crate::math::Aabb;
use crate::render::field::{Field, GroundMap};
use crate::render::frame::{FrameConstants, resolve};
use crate::render::hierarchy::Hierarchy;
use crate::render::image::{GBuffer, Image, SkyVisibility};
use crate::render::lens::Lens;
use crate::render::outline::{Outline, RIM};
use crate::render::settings::{Settings, View, sample_offset};
use crate::render::sky::{self, Reach, Turns};
use crate::render::solids::Solids;
use crate::scene::{PixelGrid, Ray, Scene};
use glam::{Vec3, Vec4};
use std::ops::Range;

/// The scene as the reference sees it.
struct Reference {
    solids: Solids,
    hierarchy: Hierarchy,
    outline: Option<Outline>,
    near: f32,
}

impl Reference {
    fn new(scene: &Scene, view: &View, frame: &FrameConstants) -> Reference {
        let solids = Solids::new(scene, view.camera.view_from_world());
        let outline = Outline::of(frame);
        let bounds = match &outline {
            Some(outline) => (0..solids.len()).map(|index| outline.box_of(&solids, index)).collect(),
            None => solids.bounds(),
        };
        Reference { hierarchy: Hierarchy::new(&bounds), solids, outline, near: view.camera.near }
    }

    /// The nearest primitive that is there in a sample (index and number of all), and its depth; of equals the first. An
    /// index with [`RIM`] is that of a primitive's outline.
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
                let hit = outlined_t(ray, &self.solids, self.outline.as_ref(), index, self.near);
                if hit < *best && self.solids.is_drawn(index as usize, sample, samples) {
                    *best = hit;
                }
            },
        );
        best.0.is_finite().then_some((best.1, best.0))
    }

    /// Whether nothing stands between a point and the sky in this direction, as far as a sample asks.
    fn is_free(&self, ray: &Ray, [sample, samples]: [u32; 2]) -> bool {
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
                *free &= t.is_infinite() || !self.solids.hides(index as usize, sample, samples);
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

    fn of(&self, reference: &Reference, ray: &Ray, t: f32, normal: Vec3, [sample, samples]: [u32; 2]) -> Reach {
        if t <= self.near {
            return self.unasked;
        }
        let origin = ray.origin + ray.direction * t + normal * sky::start_offset(t);
        let free = |direction| reference.is_free(&Ray { origin, direction }, [sample, samples]);
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
    let region = view.region();
    let samples = settings.samples.clamp(1, 4096);
    // The sum of what samples see, and how many see nothing.
    let mut sums = vec![(Vec4::ZERO, 0u32); region.width as usize * region.height as usize];
    match Lens::of(scene, view) {
        None => add_samples(scene, (view, settings), &frame, &ground_map, 0..samples, &mut sums),
        Some(lens) => {
            for sample in 0..samples {
                let view = lens.view(view, sample, samples);
                let frame = FrameConstants::new(scene, &view, settings);
                add_samples(scene, (&view, settings), &frame, &ground_map, sample..sample + 1, &mut sums);
            }
        }
    }
    let none = Solids::default();
    let shader = Shader::new(&frame, &none, &ground_map);
    let grid = view.pixel_grid();
    let mut rgba = Vec::with_capacity(sums.len() * 4);
    let mut sums = sums.into_iter();
    for_each_pixel(view, |x, y| {
        let (sum, unseen) = sums.next().unwrap_or_default();
        let backdrop = shader.backdrop(&grid.ray(grid.plane(x + 0.5, y + 0.5)));
        rgba.extend_from_slice(bytemuck::bytes_of(&resolve(sum + backdrop * unseen as f32, samples)));
    });
    Image { width: region.width, height: region.height, rgba }
}

/// Adds what these samples of each pixel see of the primitives.
fn add_samples(
    scene: &Scene,
    (view, settings): (&View, &Settings),
    frame: &FrameConstants,
    ground_map: &GroundMap,
    range: Range<u32>,
    sums: &mut [(Vec4, u32)],
) {
    let reference = Reference::new(scene, view, frame);
    let shader = Shader::new(frame, &reference.solids, ground_map);
    let grid: PixelGrid = view.pixel_grid();
    let samples = settings.samples.clamp(1, 4096);
    let reaches = Reaches::new(frame, view, settings);
    let mut sums = sums.iter_mut();
    for_each_pixel(view, |x, y| {
        let Some((sum, unseen)) = sums.next() else { return };
        for sample in range.clone() {
            let [dx, dy] = sample_offset(sample, samples);
            let ray = grid.ray(grid.plane(x + dx, y + dy));
            let nearest = reference.nearest(&ray, [sample, samples]);
            let Some((index, t)) = nearest.filter(|&(index, t)| shader.is_seen(&ray, index, t)) else {
                *unseen += 1;
                continue;
            };
            if index & RIM != 0 {
                *sum += shader.outline(&ray, t);
                continue;
            }
            let normal = shader.surface(&ray, index, t).normal;
            let reach = reaches.of(&reference, &ray, t, normal, [sample, samples]);
            *sum += shader.primitive(&ray, index, t, reach);
        }
    });
}

/// What is seen at the pixel centres.
#[must_use]
pub fn gbuffer(scene: &Scene, view: &View) -> GBuffer {
    let settings = Settings::default();
    let frame = FrameConstants::new(scene, view, &settings).without_outlines();
    let ground_map = GroundMap::none();
    let reference = Reference::new(scene, view, &frame);
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

/// How much of the sky the surface at the pixel centres sees, over so many directions.
#[must_use]
pub fn sky_visibility(scene: &Scene, view: &View, directions: u32) -> SkyVisibility {
    // The one sample of a pixel asks all of them.
    let settings = Settings { samples: 1, ao: directions, shadow: false, ..Settings::default() };
    let frame = FrameConstants::new(scene, view, &settings).without_outlines();
    let ground_map = GroundMap::none();
    let reference = Reference::new(scene, view, &frame);
    let shader = Shader::new(&frame, &reference.solids, &ground_map);
    let reaches = Reaches { unasked: Reach { open: 1.0, key: 1.0 }, ..Reaches::new(&frame, view, &settings) };
    let (grid, region) = (view.pixel_grid(), view.region());
    let mut open = Vec::with_capacity(region.width as usize * region.height as usize);
    for_each_pixel(view, |x, y| {
        let ray = grid.ray(grid.plane(x + 0.5, y + 0.5));
        let seen = reference.nearest(&ray, [0, 1]).filter(|&(index, t)| shader.is_seen(&ray, index, t));
        open.push(seen.map_or(1.0, |(index, t)| {
            let normal = shader.surface(&ray, index, t).normal;
            reaches.of(&reference, &ray, t, normal, [0, 1]).open
        }));
    });
    SkyVisibility { width: region.width, height: region.height, open }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Srgb8;
    use crate::render::cpu::intersect::primitive_normal;
    use crate::scene::{Block, Camera, Placement, Projection, SphereInstance};
    use glam::{Affine3A, Quat};

    /// A ball in a see-through shell, looked at from the front, and the light that reaches the ball's middle in the samples that see it.
    fn in_a_shell(opacity: u8, id: u32, samples: u32) -> Reach {
        let ball = SphereInstance { center: [0.0; 3], radius: 0.5, color: Srgb8::WHITE, id: 0 };
        let shell =
            SphereInstance { center: [0.1, 0.0, 0.0], radius: 1.5, color: Srgb8 { a: opacity, ..Srgb8::WHITE }, id };
        let block = Block { spheres: vec![ball, shell], id_count: id + 1, ..Block::default() };
        let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
        let scene = Scene::from_blocks(vec![block], vec![placement]);
        let projection = Projection::Orthographic { height: 4.0 };
        let eye = Vec3::new(0.0, 0.0, 9.0);
        let camera = Camera {
            eye,
            world_from_view: Quat::IDENTITY,
            projection,
            near: 0.1,
            far: 20.0,
            target: Vec3::ZERO,
            shift: [0.0; 2],
        };
        let view = View::new(camera, 8, 8);
        let settings = Settings { samples, ao: 64, shadow: true, ground_texels: 16 };
        let frame = FrameConstants::new(&scene, &view, &settings);
        let (reference, reaches) = (Reference::new(&scene, &view, &frame), Reaches::new(&frame, &view, &settings));
        let (grid, mut sum, mut seen) = (view.pixel_grid(), Reach { open: 0.0, key: 0.0 }, 0.0);
        for sample in 0..samples {
            // Up to the left, where the key light comes from.
            let ray = grid.ray(grid.plane(3.9, 3.9));
            if let Some((0, t)) = reference.nearest(&ray, [sample, samples]) {
                let normal = primitive_normal(&ray, &reference.solids, 0, view.camera.near, t);
                let reach = reaches.of(&reference, &ray, t, normal, [sample, samples]);
                (sum.open, sum.key, seen) = (sum.open + reach.open, sum.key + reach.key, seen + 1.0);
            }
        }
        Reach { open: sum.open / seen, key: sum.key / seen }
    }

    #[test]
    fn a_see_through_shell_takes_its_share_of_the_light_inside_of_it() {
        for (opacity, samples) in [(64, 16), (128, 16), (191, 16), (128, 64)] {
            let left = 1.0 - f32::from(opacity) / 255.0;
            let (mut mean, mut worst) = ([0.0f32; 2], 0.0f32);
            for id in 1..61 {
                let Reach { open, key } = in_a_shell(opacity, id, samples);
                mean = [mean[0] + open / 60.0, mean[1] + key / 60.0];
                worst = worst.max((key - left).abs());
            }
            println!("{opacity}, {samples} samples: {mean:?} of {left}, at most {worst} off");
            // Were it the samples in which the shell is not drawn that it does not hide light in, all of it would be left.
            assert!(mean.iter().all(|m| (m - left).abs() < 0.04) && worst < 0.3, "{opacity}: {mean:?} {worst}");
        }
        assert_eq!(in_a_shell(0, 1, 16), Reach { open: 1.0, key: 1.0 });
    }
}
