//! The ground's light on the device: the distance field as texels, and the map that is computed from it and kept.
//!
//! Where the field does not fit the device's textures (2048 texels a row; 1,000,000 balls and 1,000,000 sticks fit even
//! the smallest), the map is computed on the CPU by the same definition and uploaded: the same numbers either way.

use super::device::{Gpu, view_of};
use super::layout::{FIELD_FORMAT, FIELD_ROW, FieldConstants, GROUND_FORMAT};
use super::passes::Passes;
use crate::error::Result;
use crate::render::field::Field;
use crate::render::frame::FrameConstants;
use crate::render::solids::{Primitive, Solids};
use crate::render::tubes::Bounds;
use crate::scene::Scene;
use glam::Vec3;
use std::sync::Arc;

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
    maps: [Option<(FrameConstants, wgpu::TextureView)>; 2],
    /// Full light, bound where there is no ground.
    none: wgpu::TextureView,
}

impl Ground {
    pub(super) fn new(gpu: &Gpu) -> Ground {
        let none = gpu.texture("no ground", [1, 1], GROUND_FORMAT, wgpu::TextureUsages::TEXTURE_BINDING);
        Ground { field: None, maps: [None, None], none: view_of(&none) }
    }

    /// Forgets the scene.
    pub(super) fn clear(&mut self) {
        (self.field, self.maps) = (None, [None, None]);
    }

    /// The map of the last [`Ground::prepare`].
    pub(super) fn light(&self, frame: &FrameConstants) -> &wgpu::TextureView {
        let fits = |(made_for, _): &&(FrameConstants, wgpu::TextureView)| {
            frame.has_ground() && made_for.same_ground_map(frame)
        };
        self.maps.iter().flatten().find(fits).map_or(&self.none, |(_, view)| view)
    }

    /// The primitives on the device; `None` where they do not fit it.
    pub(super) fn casters(&mut self, gpu: &Gpu, passes: &Passes, scene: &Scene) -> Result<Option<&Casters>> {
        let field = self.take_field(gpu, passes, scene)?;
        Ok(match self.field.insert(field) {
            FieldHome::Device { casters, .. } => Some(casters),
            FieldHome::Host(_) => None,
        })
    }

    fn take_field(&mut self, gpu: &Gpu, passes: &Passes, scene: &Scene) -> Result<FieldHome> {
        match self.field.take() {
            Some(field) => Ok(field),
            None => gpu.guard("uploading the distance field", || Ok(FieldHome::new(gpu, passes, scene))),
        }
    }

    /// Makes the map of this frame unless it is there. The frame's uniform is written already.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        passes: &Passes,
        scene: &Scene,
        frame: &FrameConstants,
        in_motion: bool,
    ) -> Result<()> {
        let place = usize::from(in_motion);
        if !frame.has_ground() || self.maps[place].as_ref().is_some_and(|(old, _)| old.same_ground_map(frame)) {
            return Ok(());
        }
        self.maps[place] = None;
        let field = self.take_field(gpu, passes, scene)?;
        let size = frame.ground_grid().size;
        let made = gpu.guard("the ground map", || match &field {
            FieldHome::Device { group, .. } => passes.ground_map.draw(gpu, &passes.frame, group, size),
            FieldHome::Host(field) => Ok(upload(gpu, &field.ground_map(frame))),
        });
        self.field = Some(field);
        self.maps[place] = Some((*frame, made?));
        Ok(())
    }
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
        gpu.count(|work| work.bytes += part.len() as u64);
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
    fn new(gpu: &Gpu, passes: &Passes, scene: &Scene) -> FieldHome {
        let field = Field::new(scene);
        let hierarchy = field.hierarchy();
        let rows = |texels: usize| texels.div_ceil(FIELD_ROW as usize);
        let solids = field.solids();
        let rare = rare_count(solids);
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
        let opacities = hierarchy.highest(|index| solids.opacity(index as usize));
        let boxes =
            hierarchy.boxes.iter().zip(opacities).map(|(b, opacity)| pair(b.min, f32::from(opacity), b.max, 0.0));
        let boxes = texels(gpu, "field boxes", boxes);
        let primitives = packed(solids, &hierarchy.order);
        let primitives = texels(gpu, "field primitives", primitives.into_iter());
        let group = passes.ground_map.field(gpu, &constants, [&boxes, &primitives]);
        let bounds = Arc::new(Bounds::in_order(solids, &hierarchy.order));
        FieldHome::Device { group, casters: Casters { texels: primitives, bounds } }
    }
}

fn pair(a: Vec3, aw: f32, b: Vec3, bw: f32) -> [[f32; 4]; 2] {
    [a.extend(aw).to_array(), b.extend(bw).to_array()]
}

/// Twin of `RARE` in shaders/distance.wgsl.
const RARE: f32 = 1e30;

/// How many primitives take more texels than two.
fn rare_count(solids: &Solids) -> usize {
    if solids.see_through {
        return (0..solids.len()).filter(|&index| is_rare(solids, index)).count();
    }
    let open = solids.cylinders.iter().filter(|stick| stick.is_open()).count();
    open + solids.cones.len() + solids.tori.len() + solids.triangles.len()
}

fn is_rare(solids: &Solids, index: usize) -> bool {
    let is_plain = match solids.primitive(index) {
        Primitive::Sphere(_) => true,
        Primitive::Cylinder(i) => !solids.cylinders[i].is_open(),
        _ => false,
    };
    !is_plain || solids.opacity(index) < u8::MAX
}

/// Pairs of texels of all primitives in the hierarchy's order, then what the rare ones take more of: the packing that
/// shaders/field.wgsl and shaders/distance.wgsl describe.
fn packed(solids: &Solids, order: &[u32]) -> Vec<[[f32; 4]; 2]> {
    let mut pairs = Vec::with_capacity(order.len());
    let mut rest: Vec<[[f32; 4]; 2]> = Vec::new();
    for index in order.iter().map(|&index| index as usize) {
        if is_rare(solids, index) {
            let (kind, center, [a, b, c]) = rare(solids, index);
            let first = 2 * (order.len() + rest.len());
            let id = solids.id(index);
            let look = [(id & 0xffff) as f32, (id >> 16) as f32, f32::from(solids.opacity(index)), 0.0];
            rest.extend([[a, b], [c, look]]);
            pairs.push(pair(center, kind as f32 * RARE, Vec3::X * first as f32, 0.0));
            continue;
        }
        pairs.push(match solids.primitive(index) {
            Primitive::Cylinder(i) => {
                let stick = &solids.cylinders[i];
                let signed = |length: f32, round: bool| if round { -length } else { length };
                let [round_a, round_b] = stick.round();
                let (radius, half) = (signed(stick.radius, round_a), signed(stick.half_length, round_b));
                pair(stick.center, radius, stick.axis(), half)
            }
            _ => {
                let sphere = &solids.spheres[index];
                pair(sphere.center, -sphere.radius, Vec3::ZERO, 0.0)
            }
        });
    }
    pairs.extend(rest);
    pairs
}

/// Kind, centre and the other three texels of a rare primitive.
fn rare(solids: &Solids, index: usize) -> (u32, Vec3, [[f32; 4]; 3]) {
    let texels = |axis: Vec3, length: f32, x: f32, y: f32| [axis.extend(length).to_array(), [x, y, 0.0, 0.0], [0.0; 4]];
    match solids.primitive(index) {
        Primitive::Sphere(i) => {
            let sphere = &solids.spheres[i];
            (5, sphere.center, texels(Vec3::Y, 0.0, sphere.radius, 0.0))
        }
        Primitive::Cylinder(i) => {
            let stick = &solids.cylinders[i];
            (4, stick.center, texels(stick.axis(), stick.half_length, stick.radius, (stick.caps & 15) as f32))
        }
        Primitive::Cone(i) => {
            let cone = &solids.cones[i];
            (1, cone.center, texels(cone.axis(), cone.half_length, cone.radii[0], cone.radii[1]))
        }
        Primitive::Torus(i) => {
            let torus = &solids.tori[i];
            (2, torus.center, texels(torus.axis(), torus.ring_radius, torus.tube_radius, 0.0))
        }
        Primitive::Triangle(i) => {
            let triangle = &solids.triangles[i];
            (3, triangle.center, triangle.corners.map(|corner| corner.extend(0.0).to_array()))
        }
    }
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
