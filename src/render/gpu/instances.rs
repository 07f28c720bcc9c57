//! The scene's primitives on the device: the instance bytes unchanged, each block once, and the placements' uniforms.

use super::device::Gpu;
use super::layout::{KINDS, PlacementConstants, VERTICES};
use super::passes::Passes;
use crate::error::{Error, Result};
use crate::scene::{Block, Scene};
use glam::Affine3A;

/// A vertex buffer is at most this long; longer lists are several buffers.
const CHUNK_BYTES: u64 = 64 << 20;

/// Instances of one kind in as many buffers as it takes.
#[derive(Debug, Default)]
struct Chunks(Vec<(wgpu::Buffer, u32)>);

impl Chunks {
    fn new<T: bytemuck::Pod>(gpu: &Gpu, label: &str, instances: &[T]) -> Chunks {
        let bytes = CHUNK_BYTES.min(gpu.limits.max_buffer_size);
        let per_chunk = (bytes as usize / size_of::<T>()).max(1);
        Chunks(
            instances
                .chunks(per_chunk)
                .map(|chunk| {
                    let buffer = gpu.buffer(label, wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(chunk));
                    gpu.queue.submit([]); // lets the staging memory go
                    (buffer, u32::try_from(chunk.len()).unwrap_or(u32::MAX))
                })
                .collect(),
        )
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, vertices: u32) {
        for (buffer, count) in &self.0 {
            pass.set_vertex_buffer(0, buffer.slice(..));
            pass.draw(0..vertices, 0..*count);
        }
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
    constants: wgpu::Buffer,
    /// Bytes from one placement's constants to the next.
    stride: u32,
    group: wgpu::BindGroup,
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
                    Chunks::new(gpu, "spheres", &block.spheres),
                    Chunks::new(gpu, "cylinders", &block.cylinders),
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
            Ok(Instances {
                blocks: scene.blocks.iter().map(upload).collect(),
                placed: scene.placements.iter().map(|placement| placement.block).collect(),
                constants,
                stride,
                group,
            })
        })
    }

    /// Moves all placements to the view space of a camera.
    pub(super) fn place(&self, gpu: &Gpu, scene: &Scene, view_from_world: Affine3A) {
        let mut bytes = vec![0u8; self.stride as usize * scene.placements.len()];
        for (placement, slot) in scene.placements.iter().zip(bytes.chunks_exact_mut(self.stride as usize)) {
            let view_from_block = view_from_world * placement.world_from_block;
            let constants = PlacementConstants::new(&view_from_block, placement.first_id);
            slot[..size_of::<PlacementConstants>()].copy_from_slice(bytemuck::bytes_of(&constants));
        }
        if !bytes.is_empty() {
            gpu.write(&self.constants, &bytes);
        }
    }

    /// Draws everything in the reference's order: all spheres, all cylinders and so on, each kind with its pipeline.
    pub(super) fn draw(&self, pipelines: &[wgpu::RenderPipeline; KINDS], pass: &mut wgpu::RenderPass<'_>) {
        for (kind, pipeline) in pipelines.iter().enumerate() {
            let drawn =
                || self.placed.iter().enumerate().filter(|(_, block)| !self.blocks[**block].0[kind].0.is_empty());
            if drawn().next().is_none() {
                continue;
            }
            pass.set_pipeline(pipeline);
            for (placement, &block) in drawn() {
                pass.set_bind_group(1, &self.group, &[placement as u32 * self.stride]);
                self.blocks[block].0[kind].draw(pass, VERTICES[kind]);
            }
        }
    }
}
