//! What of some clustered instances a sample draws, as bits and a list on the device: see shaders/cull.wgsl.

use super::clusters::MEMBERS;
use super::device::Gpu;
use super::instances::Chunk;
use super::passes::cull::Cull;
use crate::error::Result;

/// Words of a cluster's masks, and where those start of what was found: twins of `WORDS` and `FOUND` in shaders/members.wgsl.
const MASK_WORDS: usize = 6;
const FOUND: usize = 4;

/// The lists of a chunk of instances in one placement.
#[derive(Debug)]
pub(super) struct Listed {
    /// Placement, kind, number of the chunk in its block.
    place: [usize; 3],
    /// Clusters of the chunk.
    clusters: u32,
    list: wgpu::Buffer,
    arguments: wgpu::Buffer,
    masks: wgpu::Buffer,
    /// Number of the first instance among all that are listed.
    first: u32,
    count: u32,
    /// Group 2 of the passes that make the list.
    pub(super) cull_group: wgpu::BindGroup,
    /// Group 2 of the pass that draws it.
    draw_group: wgpu::BindGroup,
}

impl Listed {
    /// Of a chunk whose instances are numbered from `first`.
    pub(super) fn new(gpu: &Gpu, cull: &Cull, place: [usize; 3], chunk: &Chunk, first: u32) -> Listed {
        let clusters = chunk.boxes.len() as u64;
        let storage = wgpu::BufferUsages::STORAGE;
        let members = |index: usize| (chunk.count as usize).saturating_sub(index * MEMBERS).min(MEMBERS);
        let boxes: Vec<[[f32; 4]; 2]> = (chunk.boxes.iter().enumerate())
            .map(|(index, b)| [b.center.extend(members(index) as f32).to_array(), b.half.extend(0.0).to_array()])
            .collect();
        let boxes = gpu.buffer("cluster boxes", storage, bytemuck::cast_slice(&boxes));
        // Zeros: nothing was seen.
        let masks =
            gpu.empty_buffer("cluster masks", storage | wgpu::BufferUsages::COPY_SRC, 4 * MASK_WORDS as u64 * clusters);
        let starts = gpu.empty_buffer("cluster starts", storage, 4 * clusters);
        let list = gpu.empty_buffer("list", storage | wgpu::BufferUsages::VERTEX, 4 * u64::from(chunk.count));
        // As in shaders/members.wgsl.
        let words = [0, 0, 0, 0, 0, first, chunk.count, 0, 6, 0, 0, 0, 0, 0, 0, 0];
        let arguments = gpu.buffer("draw", storage | wgpu::BufferUsages::INDIRECT, bytemuck::bytes_of(&words));
        let cull_group = cull.group(gpu, [&chunk.buffer, &boxes, &masks, &starts, &list, &arguments]);
        let draw_group = cull.drawn_group(gpu, [&chunk.buffer, &arguments]);
        Listed {
            place,
            clusters: clusters as u32,
            list,
            arguments,
            masks,
            first,
            count: chunk.count,
            cull_group,
            draw_group,
        }
    }

    /// Number of the first instance after these.
    pub(super) fn end(&self) -> u32 {
        self.first.saturating_add(self.count)
    }

    /// Has no cluster wait to be visited, and no pixel to be shaded.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        for (word, words) in [(4, 1), (9, 1), (12, 4)] {
            encoder.clear_buffer(&self.arguments, 4 * word, Some(4 * words));
        }
    }

    pub(super) fn placement(&self) -> usize {
        self.place[0]
    }

    /// 0: spheres, 1: cylinders.
    pub(super) fn kind(&self) -> usize {
        self.place[1]
    }

    pub(super) fn clusters(&self) -> u32 {
        self.clusters
    }

    /// How many instances the last sample found to be seen.
    pub(super) fn seen(&self, gpu: &Gpu) -> Result<u64> {
        let copy = gpu.empty_buffer("masks read back", wgpu::BufferUsages::MAP_READ, self.masks.size());
        let submission = gpu.submit("masks", |encoder| {
            encoder.copy_buffer_to_buffer(&self.masks, 0, &copy, 0, self.masks.size());
        });
        let bytes = gpu.read(&copy, &submission)?;
        let words = bytes.chunks_exact(4 * MASK_WORDS).flat_map(|mask| &mask[4 * FOUND..]);
        Ok(words.map(|byte| u64::from(byte.count_ones())).sum())
    }

    /// Shades the pixels that its small instances have.
    pub(super) fn draw_small(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(2, &self.draw_group, &[]);
        pass.draw_indirect(&self.arguments, 4 * 8);
    }

    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(2, &self.draw_group, &[]);
        pass.set_vertex_buffer(0, self.list.slice(..));
        pass.draw_indirect(&self.arguments, 0);
    }
}
