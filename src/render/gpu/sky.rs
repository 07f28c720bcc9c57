//! Depth maps from the directions of the sky and of the key light on the device: the twins of the CPU renderer's, drawn by
//! the geometry pass with a camera at infinity. `shaders/sky.wgsl` asks them.
//!
//! The sky's maps last as long as the scene, the key's as long as the light's direction.

use super::device::{Gpu, view_of};
use super::instances::Instances;
use super::layout::{DEPTH_FORMAT, FIELD_FORMAT, HEIGHT_FORMAT, SampleConstants};
use super::pipelines::Pipelines;
use crate::error::Result;
use crate::render::frame::FrameConstants;
use crate::render::settings::{Settings, View};
use crate::render::sky;
use crate::scene::{Camera, Projection, Scene};
use glam::{Mat3, Quat, Vec3};
use std::collections::VecDeque;

/// Texels of all maps of a light together (2 bytes each). Chosen: 128 MiB.
const MAX_TEXELS: f32 = 64.0 * 1024.0 * 1024.0;
/// No texel is finer, in ångström: a tenth of a stick's radius.
const MIN_TEXEL: f32 = 0.013;
/// Submissions that may be under way.
const IN_FLIGHT: usize = 4;

/// Maps from some directions.
#[derive(Debug)]
struct Maps {
    layers: wgpu::TextureView,
    directions: wgpu::TextureView,
}

/// What the shade pass asks.
#[derive(Debug)]
pub(super) struct Sky {
    sky: Option<(u32, Maps)>,
    key: Option<(Vec3, Maps)>,
    none: Maps,
    group: Option<wgpu::BindGroup>,
    frame: wgpu::Buffer,
    sample: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    idle: wgpu::BindGroup,
}

impl Sky {
    pub(super) fn new(gpu: &Gpu, pipelines: &Pipelines) -> Sky {
        let uniform = |label, size| gpu.empty_buffer(label, wgpu::BufferUsages::UNIFORM, size);
        let frame = uniform("map frame", super::layout::FRAME_BYTES);
        let sample = uniform("map sample", size_of::<SampleConstants>() as u64);
        let frame_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("map frame"),
            layout: &pipelines.frame_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: sample.as_entire_binding() },
            ],
        });
        let (layers, _) = layers(gpu, "no maps", 1, 1);
        let none = Maps { layers, directions: directions(gpu, &[], [0.0; 4], [0.0; 4]) };
        let idle = bind(gpu, pipelines, [&none, &none]);
        Sky { sky: None, key: None, none, group: None, frame, sample, frame_group, idle }
    }

    /// Forgets the scene.
    pub(super) fn clear(&mut self) {
        (self.sky, self.key, self.group) = (None, None, None);
    }

    /// Group 2 of the shade pass under these settings, after [`Sky::prepare`].
    pub(super) fn group(&self, settings: &Settings) -> &wgpu::BindGroup {
        let asked = settings.ao > 0 || settings.shadow;
        self.group.as_ref().filter(|_| asked).unwrap_or(&self.idle)
    }

    /// Makes the maps of these settings unless they are there. Moves the placements: the picture's are written after it.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        pipelines: &Pipelines,
        instances: Option<&Instances>,
        scene: &Scene,
        (frame, settings): (&FrameConstants, &Settings),
    ) -> Result<()> {
        // In motion nothing is asked, and the maps of the picture at rest are kept.
        let (Some(instances), true) = (instances, settings.ao > 0 || settings.shadow) else { return Ok(()) };
        let count = settings.ao.min(Settings::MOST_DIRECTIONS);
        if self.sky.as_ref().map_or(0, |(of, _)| *of) != count {
            (self.sky, self.group) = (None, None);
            if count > 0 {
                let maps = self.draw(gpu, pipelines, instances, scene, &sky::directions(count))?;
                self.sky = Some((count, maps));
            }
        }
        let key = frame.key_in_world();
        let wanted = settings.shadow.then_some(key);
        if self.key.as_ref().map(|(of, _)| *of) != wanted {
            (self.key, self.group) = (None, None);
            if settings.shadow {
                let maps = self.draw(gpu, pipelines, instances, scene, &sky::key_directions(key))?;
                self.key = Some((key, maps));
            }
        }
        if self.group.is_none() {
            let sky = self.sky.as_ref().map_or(&self.none, |(_, maps)| maps);
            let key = self.key.as_ref().map_or(&self.none, |(_, maps)| maps);
            self.group = Some(bind(gpu, pipelines, [sky, key]));
        }
        Ok(())
    }

    fn draw(
        &self,
        gpu: &Gpu,
        pipelines: &Pipelines,
        instances: &Instances,
        scene: &Scene,
        all: &[Vec3],
    ) -> Result<Maps> {
        let bounds = scene.bounds();
        let radius = (bounds.size().length() * 0.5).max(1e-3);
        let finest = (2.0 * radius / MIN_TEXEL).ceil();
        let side = (MAX_TEXELS / all.len() as f32).sqrt().min(finest).floor() as u32;
        let side = side.clamp(16, gpu.limits.max_texture_dimension_2d);
        // A texel of free border on each side.
        let texel = 2.0 * radius / (side - 2) as f32;
        gpu.guard("drawing the light's maps", || {
            let (view, texture) = layers(gpu, "maps", side, all.len() as u32);
            let depth =
                view_of(&gpu.texture("map depth", [side, side], DEPTH_FORMAT, wgpu::TextureUsages::RENDER_ATTACHMENT));
            let mut under_way = VecDeque::new();
            for (layer, &toward) in all.iter().enumerate() {
                let camera = camera(bounds.center(), radius, toward, side as f32 * texel);
                let settings = Settings { ground_texels: 16, ..Settings::default() };
                let frame = FrameConstants::new(scene, &View::new(camera, side, side), &settings);
                let (origin, size) = ([0, 0], [side, side]);
                let sample = SampleConstants { origin, size, offset: [0.5, 0.5], done: 0, turn: 0 };
                gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
                gpu.queue.write_buffer(&self.sample, 0, bytemuck::bytes_of(&sample));
                instances.place(gpu, scene, camera.view_from_world());
                let target = texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2),
                    base_array_layer: layer as u32,
                    array_layer_count: Some(1),
                    ..wgpu::TextureViewDescriptor::default()
                });
                under_way.push_back(gpu.submit("map", |encoder| {
                    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                        label: Some("map"),
                        color_attachments: &[Some(super::draw::cleared(&target))],
                        depth_stencil_attachment: Some(super::draw::cleared_depth(&depth)),
                        ..wgpu::RenderPassDescriptor::default()
                    });
                    pass.set_bind_group(0, &self.frame_group, &[]);
                    instances.draw(&pipelines.heights, &mut pass);
                }));
                if under_way.len() > IN_FLIGHT
                    && let Some(oldest) = under_way.pop_front()
                {
                    gpu.wait(&oldest)?;
                }
            }
            let steps = 65_534.0 / (2.0 * radius);
            let directions = directions(
                gpu,
                all,
                [all.len() as f32, side as f32, 1.0 / texel, 0.0],
                [steps, 1.0 + radius * steps, 0.0, 0.0],
            );
            Ok(Maps { layers: view, directions })
        })
    }
}

/// A camera far out towards the light, that sees the ball around the scene: depth runs over its diameter.
fn camera(center: Vec3, radius: f32, toward: Vec3, height: f32) -> Camera {
    let [right, up] = sky::across(toward);
    let near = radius;
    Camera {
        eye: center + toward * (radius + near),
        world_from_view: Quat::from_mat3(&Mat3::from_cols(right, up, toward)),
        projection: Projection::Orthographic { height },
        near,
        far: near + 2.0 * radius,
        target: center,
    }
}

fn layers(gpu: &Gpu, label: &str, side: u32, count: u32) -> (wgpu::TextureView, wgpu::Texture) {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: count },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: HEIGHT_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    });
    (view, texture)
}

/// Row 0 says how the maps are laid out, each other row holds a direction's axes.
fn directions(gpu: &Gpu, all: &[Vec3], size: [f32; 4], steps: [f32; 4]) -> wgpu::TextureView {
    let mut rows = vec![[size, steps, [0.0; 4]]];
    rows.extend(all.iter().map(|&toward| {
        let [right, up] = sky::across(toward);
        [right, up, toward].map(|axis| axis.extend(0.0).to_array())
    }));
    let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = gpu.texture("map directions", [3, rows.len() as u32], FIELD_FORMAT, usage);
    super::ground::write_rows(gpu, &texture, [3, rows.len() as u32], bytemuck::cast_slice(&rows));
    view_of(&texture)
}

fn bind(gpu: &Gpu, pipelines: &Pipelines, [sky, key]: [&Maps; 2]) -> wgpu::BindGroup {
    let entry = |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("sky"),
        layout: &pipelines.sky_layout,
        entries: &[entry(0, &sky.layers), entry(1, &sky.directions), entry(2, &key.layers), entry(3, &key.directions)],
    })
}
