//! The scene's primitives on the device: the instance bytes unchanged, each block once, and the placements' uniforms.
//!
//! Many balls and sticks are put in the order of their [`super::clusters`], and what of them need not be drawn is left out: by lists of the
//! compute pass ([`super::listed`]), or by runs of clusters that the CPU finds in the picture. One may ask for neither.

use super::clusters::{ClusterBox, Frustum, MEMBERS, clusters};
use super::device::Gpu;
use super::layout::{KINDS, PlacementConstants, VERTICES};
use super::listed::Listed;
use super::passes::Passes;
use super::passes::geometry::{Geometry, Late};
use crate::error::{Error, Result};
use crate::math::Aabb;
use crate::scene::{Block, CylinderInstance, Scene, SphereInstance};
use glam::Affine3A;
use std::sync::{Mutex, PoisonError};

/// A vertex buffer is at most this long; longer lists are several buffers.
const CHUNK_BYTES: u64 = 64 << 20;

/// What is left out of what a device is asked to draw. The pictures are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Culling {
    /// Nothing.
    None,
    /// Clusters out of the picture.
    Frustum,
    /// Also what others hide, where the device can compute.
    #[default]
    Full,
}

/// Some instances of one kind.
#[derive(Debug)]
pub(super) struct Chunk {
    pub(super) buffer: wgpu::Buffer,
    pub(super) count: u32,
    /// Empty where all are drawn.
    pub(super) boxes: Vec<ClusterBox>,
    /// Bytes of an instance.
    size: u64,
}

/// Instances of one kind in as many buffers as it takes.
#[derive(Debug, Default)]
struct Chunks(Vec<Chunk>);

impl Chunks {
    fn new<T: bytemuck::Pod>(gpu: &Gpu, label: &str, instances: &[T]) -> Chunks {
        let parts = instances.chunks(per_chunk::<T>(gpu));
        Chunks(parts.map(|part| Chunk::new(gpu, label, part, Vec::new())).collect())
    }

    /// In clusters, if there are many.
    fn clustered<T: bytemuck::Pod + Sync>(
        gpu: &Gpu,
        label: &str,
        instances: &[T],
        bounds: impl Fn(&T) -> Aabb,
    ) -> Chunks {
        let around: Vec<Aabb> = instances.iter().map(bounds).collect();
        let Some((order, boxes)) = clusters(&around) else { return Chunks::new(gpu, label, instances) };
        drop(around);
        let per_chunk = per_chunk::<T>(gpu).next_multiple_of(MEMBERS) - MEMBERS;
        let chunk = |(part, boxes): (&[u32], &[ClusterBox])| {
            let part: Vec<T> = part.iter().map(|&index| instances[index as usize]).collect();
            Chunk::new(gpu, label, &part, boxes.to_vec())
        };
        let per_chunk = per_chunk.max(MEMBERS);
        Chunks(order.chunks(per_chunk).zip(boxes.chunks(per_chunk / MEMBERS)).map(chunk).collect())
    }
}

fn per_chunk<T>(gpu: &Gpu) -> usize {
    let bytes = CHUNK_BYTES.min(gpu.limits.max_buffer_size);
    (bytes as usize / size_of::<T>()).max(1)
}

impl Chunk {
    fn new<T: bytemuck::Pod>(gpu: &Gpu, label: &str, instances: &[T], boxes: Vec<ClusterBox>) -> Chunk {
        let is_listed = gpu.can_cull() && !boxes.is_empty();
        let storage = if is_listed { wgpu::BufferUsages::STORAGE } else { wgpu::BufferUsages::empty() };
        let buffer = gpu.buffer(label, wgpu::BufferUsages::VERTEX | storage, bytemuck::cast_slice(instances));
        gpu.queue.submit([]); // lets the staging memory go
        let count = u32::try_from(instances.len()).unwrap_or(u32::MAX);
        Chunk { buffer, count, boxes, size: size_of::<T>() as u64 }
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, vertices: u32, [start, end]: [u32; 2]) {
        // The start is the buffer's: not every device begins at another instance than the first.
        pass.set_vertex_buffer(0, self.buffer.slice(u64::from(start) * self.size..));
        pass.draw(0..vertices, 0..end - start);
    }
}

/// The primitives of a block by kind: spheres, cylinders, cones, tori, triangles.
#[derive(Debug)]
struct BlockBuffers([Chunks; KINDS]);

/// All blocks and placements of a scene.
#[derive(Debug)]
pub(super) struct Instances {
    blocks: Vec<BlockBuffers>,
    /// Block of each placement.
    placed: Vec<usize>,
    /// View from block of each placement, as the device has them.
    seen_from: Mutex<Vec<Affine3A>>,
    constants: wgpu::Buffer,
    /// Bytes from one placement's constants to the next.
    stride: u32,
    group: wgpu::BindGroup,
    /// What is drawn by lists.
    listed: Vec<Listed>,
}

impl Instances {
    /// Uploads a scene.
    pub(super) fn new(gpu: &Gpu, passes: &Passes, scene: &Scene) -> Result<Instances> {
        let alignment = gpu.limits.min_uniform_buffer_offset_alignment.max(1);
        let stride = (size_of::<PlacementConstants>() as u32).next_multiple_of(alignment);
        let size = u64::from(stride) * scene.placements.len().max(1) as u64;
        // Dynamic offsets are 32-bit.
        let limit = gpu.limits.max_buffer_size.min(u64::from(u32::MAX));
        if size > limit {
            let count = scene.placements.len();
            return Err(Error::Gpu(format!(
                "{count} placements take {size} bytes, the device's buffers hold {limit}; draw it with --renderer cpu"
            )));
        }
        gpu.guard("uploading the scene", || {
            let upload = |block: &Block| {
                BlockBuffers([
                    Chunks::clustered(gpu, "spheres", &block.spheres, SphereInstance::bounds),
                    Chunks::clustered(gpu, "cylinders", &block.cylinders, CylinderInstance::bounds),
                    Chunks::new(gpu, "cones", &block.cones),
                    Chunks::new(gpu, "tori", &block.tori),
                    Chunks::new(gpu, "triangles", &block.triangles),
                ])
            };
            let constants = gpu.empty_buffer("placements", wgpu::BufferUsages::UNIFORM, size);
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("placements"),
                layout: &passes.geometry.placement_layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: &constants,
                        offset: 0,
                        size: std::num::NonZeroU64::new(size_of::<PlacementConstants>() as u64),
                    }),
                }],
            });
            let mut instances = Instances {
                blocks: scene.blocks.iter().map(upload).collect(),
                placed: scene.placements.iter().map(|placement| placement.block).collect(),
                seen_from: Mutex::default(),
                constants,
                stride,
                group,
                listed: Vec::new(),
            };
            if let Some(cull) = &passes.cull {
                instances.listed = instances.lists(gpu, cull);
            }
            Ok(instances)
        })
    }

    /// Lists of what the placements draw of the clustered chunks. Of blocks with many copies none: they would take more memory than the
    /// instances.
    fn lists(&self, gpu: &Gpu, cull: &super::passes::cull::Cull) -> Vec<Listed> {
        let clustered = |&block: &usize| {
            let count = |chunks: &Chunks| chunks.0.iter().map(|chunk| u64::from(chunk.count)).sum::<u64>();
            self.blocks[block].0[..2].iter().map(count).sum::<u64>()
        };
        let once: u64 = (0..self.blocks.len()).map(|block| clustered(&block)).sum();
        let all: u64 = self.placed.iter().map(clustered).sum();
        if all > 2 * once {
            return Vec::new();
        }
        // Numbered as they are drawn.
        let mut listed: Vec<Listed> = Vec::new();
        for kind in 0..2 {
            for (placement, &block) in self.placed.iter().enumerate() {
                let chunks = self.blocks[block].0[kind].0.iter().enumerate();
                for (number, chunk) in chunks.filter(|(_, chunk)| !chunk.boxes.is_empty()) {
                    let first = listed.last().map_or(0, Listed::end);
                    listed.push(Listed::new(gpu, cull, [placement, kind, number], chunk, first));
                }
            }
        }
        listed
    }

    /// What is drawn by lists, if anything is.
    pub(super) fn listed(&self, culling: Culling) -> &[Listed] {
        if culling == Culling::Full { &self.listed } else { &[] }
    }

    /// Group 1 of what is drawn or asked of a placement, and its dynamic offset.
    pub(super) fn placement(&self, placement: usize) -> (&wgpu::BindGroup, [u32; 1]) {
        (&self.group, [placement as u32 * self.stride])
    }

    /// Moves all placements to the view space of a camera.
    pub(super) fn place(&self, gpu: &Gpu, scene: &Scene, view_from_world: Affine3A) {
        let mut bytes = vec![0u8; self.stride as usize * scene.placements.len()];
        let mut seen_from = Vec::with_capacity(scene.placements.len());
        for (placement, slot) in scene.placements.iter().zip(bytes.chunks_exact_mut(self.stride as usize)) {
            let view_from_block = view_from_world * placement.world_from_block;
            let constants = PlacementConstants::new(&view_from_block, placement.first_id);
            slot[..size_of::<PlacementConstants>()].copy_from_slice(bytemuck::bytes_of(&constants));
            seen_from.push(view_from_block);
        }
        *self.seen_from.lock().unwrap_or_else(PoisonError::into_inner) = seen_from;
        if !bytes.is_empty() {
            gpu.write(&self.constants, &bytes);
        }
    }

    /// Draws everything of some kinds, of what is `listed` what is in the lists, in the reference's order: all spheres, all cylinders and so
    /// on, each kind with its pipeline. Without a frustum nothing is left out.
    pub(super) fn draw(
        &self,
        geometry: &Geometry,
        pass: &mut wgpu::RenderPass<'_>,
        kinds: std::ops::Range<usize>,
        (frustum, listed): (Option<&Frustum>, &[Listed]),
    ) {
        let seen_from = self.seen_from.lock().unwrap_or_else(PoisonError::into_inner);
        for (kind, pipeline) in geometry.pipelines.iter().enumerate().filter(|(kind, _)| kinds.contains(kind)) {
            let mut is_set = false;
            for (placement, &block) in self.placed.iter().enumerate() {
                for chunk in &self.blocks[block].0[kind].0 {
                    let is_clustered = !chunk.boxes.is_empty();
                    if is_clustered && !listed.is_empty() {
                        continue;
                    }
                    let runs = match (frustum, seen_from.get(placement)) {
                        (Some(frustum), Some(from)) if is_clustered => frustum.runs(&chunk.boxes, chunk.count, from),
                        _ => vec![[0, chunk.count]],
                    };
                    if runs.is_empty() {
                        continue;
                    }
                    if !is_set {
                        pass.set_pipeline(pipeline);
                        is_set = true;
                    }
                    let (group, offset) = self.placement(placement);
                    pass.set_bind_group(1, group, &offset);
                    for run in runs {
                        chunk.draw(pass, VERTICES[kind], run);
                    }
                }
            }
            if let Some(pipelines) = &geometry.listed {
                self.draw_listed(pipelines, pass, kind, listed);
            }
        }
    }

    /// Draws what the lists of a kind hold.
    fn draw_listed(
        &self,
        pipelines: &[wgpu::RenderPipeline; 2],
        pass: &mut wgpu::RenderPass<'_>,
        kind: usize,
        listed: &[Listed],
    ) {
        self.each_listed((pipelines, kind), pass, listed, Listed::draw);
    }

    /// Draws what of the lists was found late, and shades what of them is small.
    pub(super) fn draw_late(
        &self,
        late: &Late,
        owners: &wgpu::BindGroup,
        pass: &mut wgpu::RenderPass<'_>,
        listed: &[Listed],
    ) {
        pass.set_bind_group(3, owners, &[]);
        for kind in 0..2 {
            self.each_listed((&late.listed, kind), pass, listed, Listed::draw);
            self.each_listed((&late.small, kind), pass, listed, Listed::draw_small);
        }
    }

    fn each_listed(
        &self,
        (pipelines, kind): (&[wgpu::RenderPipeline; 2], usize),
        pass: &mut wgpu::RenderPass<'_>,
        listed: &[Listed],
        draw: impl Fn(&Listed, &mut wgpu::RenderPass<'_>),
    ) {
        let Some(pipeline) = pipelines.get(kind) else { return };
        let mut of_kind = listed.iter().filter(|listed| listed.kind() == kind).peekable();
        if of_kind.peek().is_some() {
            pass.set_pipeline(pipeline);
        }
        for listed in of_kind {
            let (group, offset) = self.placement(listed.placement());
            pass.set_bind_group(1, group, &offset);
            draw(listed, pass);
        }
    }
}
