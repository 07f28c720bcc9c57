//! The ground's light on the device: the distance field as texels, and the map that is computed from it and kept.
//!
//! Where the field does not fit the device's textures (2048 texels a row; 1,000,000 balls and 1,000,000 sticks fit even
//! the smallest), the map is computed on the CPU by the same definition and uploaded: the same numbers either way.

use super::device::{Gpu, view_of};
use super::layout::{FIELD_FORMAT, FIELD_ROW, FieldConstants, GROUND_FORMAT};
use super::pipelines::Pipelines;
use crate::error::Result;
use crate::render::field::Field;
use crate::render::frame::FrameConstants;
use crate::render::solids::{Primitive, Solids};
use crate::render::tubes::Bounds;
use crate::scene::Scene;
use glam::Vec3;
use std::sync::Arc;

/// Texels of one submission: small enough that a slow device finishes it well before its watchdog (2 s on Windows)
/// wakes. A texel asks the field seven times.
const TEXELS_A_SUBMISSION: u32 = 16_384;

/// The field of the loaded scene, wherever it can be asked.
#[derive(Debug)]
enum FieldHome {
    Device { group: wgpu::BindGroup, casters: Casters },
    Host(Box<Field>),
}

/// The field's primitives, which also hide the light from afar.
#[derive(Debug, Clone)]
pub(super) struct Casters {
    /// As shaders/field.wgsl describes.
    pub(super) texels: wgpu::TextureView,
    /// Numbered as in the texels.
    pub(super) bounds: Arc<Bounds>,
}

/// What the ground needs, kept from picture to picture.
#[derive(Debug)]
pub(super) struct Ground {
    field: Option<FieldHome>,
    map: Option<(FrameConstants, wgpu::TextureView)>,
    /// Full light, bound where there is no ground.
    none: wgpu::TextureView,
}

impl Ground {
    pub(super) fn new(gpu: &Gpu) -> Ground {
        let none = gpu.texture("no ground", [1, 1], GROUND_FORMAT, wgpu::TextureUsages::TEXTURE_BINDING);
        Ground { field: None, map: None, none: view_of(&none) }
    }

    /// Forgets the scene.
    pub(super) fn clear(&mut self) {
        (self.field, self.map) = (None, None);
    }

    /// The map of the last [`Ground::prepare`].
    pub(super) fn light(&self, frame: &FrameConstants) -> &wgpu::TextureView {
        match &self.map {
            Some((made_for, view)) if frame.has_ground() && made_for.same_ground_map(frame) => view,
            _ => &self.none,
        }
    }

    /// The primitives on the device; `None` where they do not fit it.
    pub(super) fn casters(&mut self, gpu: &Gpu, pipelines: &Pipelines, scene: &Scene) -> Result<Option<&Casters>> {
        let field = self.take_field(gpu, pipelines, scene)?;
        Ok(match self.field.insert(field) {
            FieldHome::Device { casters, .. } => Some(casters),
            FieldHome::Host(_) => None,
        })
    }

    fn take_field(&mut self, gpu: &Gpu, pipelines: &Pipelines, scene: &Scene) -> Result<FieldHome> {
        match self.field.take() {
            Some(field) => Ok(field),
            None => gpu.guard("uploading the distance field", || Ok(FieldHome::new(gpu, pipelines, scene))),
        }
    }

    /// Makes the map of this frame unless it is there. The frame's uniform is written already.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        pipelines: &Pipelines,
        frame_group: &wgpu::BindGroup,
        scene: &Scene,
        frame: &FrameConstants,
    ) -> Result<()> {
        if !frame.has_ground() || self.map.as_ref().is_some_and(|(old, _)| old.same_ground_map(frame)) {
            return Ok(());
        }
        self.map = None;
        let field = self.take_field(gpu, pipelines, scene)?;
        let size = frame.ground_grid().size;
        let made = gpu.guard("the ground map", || match &field {
            FieldHome::Device { group, .. } => draw(gpu, pipelines, frame_group, group, size),
            FieldHome::Host(field) => Ok(upload(gpu, &field.ground_map(frame))),
        });
        self.field = Some(field);
        self.map = Some((*frame, made?));
        Ok(())
    }
}

/// Draws the map, a few rows a submission.
fn draw(
    gpu: &Gpu,
    pipelines: &Pipelines,
    frame_group: &wgpu::BindGroup,
    field: &wgpu::BindGroup,
    [width, height]: [u32; 2],
) -> Result<wgpu::TextureView> {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let map = view_of(&gpu.texture("ground map", [width, height], GROUND_FORMAT, usage));
    let rows = (TEXELS_A_SUBMISSION / width.max(1)).max(1);
    let mut before: Option<wgpu::SubmissionIndex> = None;
    for first in (0..height).step_by(rows as usize) {
        let submission = gpu.submit("ground map", |encoder| {
            let load = if first == 0 { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("ground map"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &map,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
                })],
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(&pipelines.ground_map);
            pass.set_bind_group(0, frame_group, &[]);
            pass.set_bind_group(1, field, &[]);
            pass.set_scissor_rect(0, first, width, rows.min(height - first));
            pass.draw(0..3, 0..1);
        });
        // One in work, one in line.
        if let Some(before) = before.replace(submission) {
            gpu.wait(&before)?;
        }
    }
    Ok(map)
}

/// A map that was computed on the CPU.
fn upload(gpu: &Gpu, map: &crate::render::field::GroundMap) -> wgpu::TextureView {
    let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = gpu.texture("ground map", map.size, GROUND_FORMAT, usage);
    write_rows(gpu, &texture, 0, map.size, bytemuck::cast_slice(&map.texels));
    view_of(&texture)
}

/// Writes rows of a texture from `first` on, some megabytes at a time.
pub(super) fn write_rows(gpu: &Gpu, texture: &wgpu::Texture, first: u32, [width, height]: [u32; 2], bytes: &[u8]) {
    let row = bytes.len() / height.max(1) as usize;
    if row == 0 {
        return;
    }
    let rows = ((8 << 20) / row).max(1);
    for (index, part) in bytes.chunks(rows * row).enumerate() {
        let (y, height) = (first + (index * rows) as u32, (part.len() / row) as u32);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            part,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row as u32), rows_per_image: None },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        gpu.queue.submit([]);
    }
}

impl FieldHome {
    fn new(gpu: &Gpu, pipelines: &Pipelines, scene: &Scene) -> FieldHome {
        let field = Field::new(scene);
        let hierarchy = field.hierarchy();
        let rows = |texels: usize| texels.div_ceil(FIELD_ROW as usize);
        let solids = field.solids();
        let open = solids.cylinders.iter().filter(|stick| stick.is_open()).count();
        let rare = open + solids.cones.len() + solids.tori.len() + solids.triangles.len();
        let most = 2 * hierarchy.boxes.len().max(hierarchy.order.len() + 2 * rare);
        let limit = gpu.limits.max_texture_dimension_2d as usize;
        // Node numbers below 2^31, texel numbers that f32 holds, and levels as the shader's table holds them.
        let is_too_large = rows(most) > limit || (rare > 0 && most > 1 << 24);
        if is_too_large || hierarchy.levels.len() > 17 || FIELD_ROW as usize > limit {
            return FieldHome::Host(Box::new(field));
        }
        let mut levels = [0; 20];
        levels[..hierarchy.levels.len()].copy_from_slice(&hierarchy.levels);
        let counts = [hierarchy.depth() as u32, hierarchy.order.len() as u32, 0, 0];
        let constants = FieldConstants { levels, counts };
        let constants = gpu.buffer("field", wgpu::BufferUsages::UNIFORM, bytemuck::bytes_of(&constants));
        let boxes = texels(gpu, "field boxes", hierarchy.boxes.iter().map(|b| pair(b.min, 0.0, b.max, 0.0)));
        let primitives = packed(solids, &hierarchy.order);
        let primitives = texels(gpu, "field primitives", primitives.into_iter());
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("field"),
            layout: &pipelines.field_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: constants.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&boxes) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(&primitives) },
            ],
        });
        let bounds = Arc::new(Bounds::in_order(solids, &hierarchy.order));
        FieldHome::Device { group, casters: Casters { texels: primitives, bounds } }
    }
}

fn pair(a: Vec3, aw: f32, b: Vec3, bw: f32) -> [[f32; 4]; 2] {
    [a.extend(aw).to_array(), b.extend(bw).to_array()]
}

/// Twin of `RARE` in shaders/distance.wgsl.
const RARE: f32 = 1e30;

/// Pairs of texels of all primitives in the hierarchy's order, then what the rare ones take more of: the packing that
/// shaders/field.wgsl and shaders/distance.wgsl describe.
fn packed(solids: &Solids, order: &[u32]) -> Vec<[[f32; 4]; 2]> {
    let mut pairs = Vec::with_capacity(order.len());
    let mut rest: Vec<[[f32; 4]; 2]> = Vec::new();
    for &index in order {
        let mut more = |kind: u32, center: Vec3, [a, b, c]: [[f32; 4]; 3]| {
            let first = 2 * (order.len() + rest.len());
            rest.extend([[a, b], [c, [0.0; 4]]]);
            pair(center, kind as f32 * RARE, Vec3::X * first as f32, 0.0)
        };
        pairs.push(match solids.primitive(index as usize) {
            Primitive::Sphere(i) => {
                let sphere = &solids.spheres[i];
                pair(sphere.center, -sphere.radius, Vec3::ZERO, 0.0)
            }
            Primitive::Cylinder(i) if solids.cylinders[i].is_open() => {
                let stick = &solids.cylinders[i];
                let axis = stick.axis().extend(stick.half_length).to_array();
                more(4, stick.center, [axis, [stick.radius, (stick.caps & 15) as f32, 0.0, 0.0], [0.0; 4]])
            }
            Primitive::Cylinder(i) => {
                let stick = &solids.cylinders[i];
                let signed = |length: f32, round: bool| if round { -length } else { length };
                let [round_a, round_b] = stick.round();
                let (radius, half) = (signed(stick.radius, round_a), signed(stick.half_length, round_b));
                pair(stick.center, radius, stick.axis(), half)
            }
            Primitive::Cone(i) => {
                let cone = &solids.cones[i];
                let [a, b] = cone.radii;
                let axis = cone.axis().extend(cone.half_length).to_array();
                more(1, cone.center, [axis, [a, b, 0.0, 0.0], [0.0; 4]])
            }
            Primitive::Torus(i) => {
                let torus = &solids.tori[i];
                let axis = torus.axis().extend(torus.ring_radius).to_array();
                more(2, torus.center, [axis, [torus.tube_radius, 0.0, 0.0, 0.0], [0.0; 4]])
            }
            Primitive::Triangle(i) => {
                let triangle = &solids.triangles[i];
                more(3, triangle.center, triangle.corners.map(|corner| corner.extend(0.0).to_array()))
            }
        });
    }
    pairs.extend(rest);
    pairs
}

/// A texture of pairs of texels, row by row.
fn texels(gpu: &Gpu, label: &str, pairs: impl ExactSizeIterator<Item = [[f32; 4]; 2]>) -> wgpu::TextureView {
    let rows = (2 * pairs.len()).div_ceil(FIELD_ROW as usize).max(1);
    let mut data: Vec<[[f32; 4]; 2]> = Vec::with_capacity(rows * FIELD_ROW as usize / 2);
    data.extend(pairs);
    data.resize(rows * FIELD_ROW as usize / 2, [[0.0; 4]; 2]);
    let usage = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
    let size = [FIELD_ROW, rows as u32];
    let texture = gpu.texture(label, size, FIELD_FORMAT, usage);
    write_rows(gpu, &texture, 0, size, bytemuck::cast_slice(&data));
    view_of(&texture)
}
