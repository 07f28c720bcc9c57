//! What small balls and sticks leave in each pixel (see shaders/small.wgsl), and three levels over that and the depth buffer, each texel the
//! farthest of sixteen of the level below, for [`super::cull`]: whether anything hides what covers up to 256 pixels a side is asked of 25
//! texels at most. Wants a device that computes.

use super::{compute_pipeline, layout, module, storage};
use crate::error::Result;
use crate::render::gpu::device::Gpu;

/// The levels' pipelines, and the layout of depth buffer and levels.
#[derive(Debug)]
pub(in crate::render::gpu) struct Pyramid {
    levels: [wgpu::ComputePipeline; 3],
    /// Group 3: the depth buffer, pixels and levels.
    pub(super) layout: wgpu::BindGroupLayout,
    /// The same without the depth buffer, to write pixels.
    pub(super) pixels_layout: wgpu::BindGroupLayout,
    /// To read pixels in a draw.
    pub(super) owners_layout: wgpu::BindGroupLayout,
}

/// Words before those of the pixels, twin of `PIXELS` in shaders/hidden.wgsl.
const HEADER: u64 = 4;

/// A pyramid over one depth buffer.
#[derive(Debug)]
pub(in crate::render::gpu) struct PyramidOf {
    size: [u32; 2],
    buffer: wgpu::Buffer,
    pub(in crate::render::gpu) group: wgpu::BindGroup,
    pub(in crate::render::gpu) pixels_group: wgpu::BindGroup,
    pub(in crate::render::gpu) owners_group: wgpu::BindGroup,
}

impl PyramidOf {
    /// Has no pixel be anyone's.
    pub(in crate::render::gpu) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        let bytes = 8 * u64::from(self.size[0]) * u64::from(self.size[1]);
        encoder.clear_buffer(&self.buffer, 4 * HEADER, Some(bytes));
    }
}

impl Pyramid {
    pub(super) fn new(gpu: &Gpu) -> Result<Pyramid> {
        let compute = wgpu::ShaderStages::COMPUTE;
        let depth = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: compute,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Depth,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let layout = layout(gpu, "pyramid", &[depth, storage(1, compute, false)]);
        let module = module(gpu, "pyramid.wgsl")?;
        let groups = [None, None, None, Some(&layout)];
        let levels = ["level_1", "level_2", "level_3"].map(|entry| compute_pipeline(gpu, &module, entry, &groups));
        let pixels_layout = super::layout(gpu, "pixels", &[storage(1, compute, false)]);
        let owners_layout = super::layout(gpu, "owners", &[storage(1, wgpu::ShaderStages::FRAGMENT, true)]);
        Ok(Pyramid { levels, layout, pixels_layout, owners_layout })
    }

    /// Over a depth buffer of this size.
    pub(in crate::render::gpu) fn over(&self, gpu: &Gpu, depth: &wgpu::TextureView, size: [u32; 2]) -> PyramidOf {
        let texels: u64 = (1..=3).map(|level| sides(size, level).map(u64::from)).map(|[w, h]| w * h).sum();
        let pixels = 2 * u64::from(size[0]) * u64::from(size[1]);
        let buffer = gpu.empty_buffer("pyramid", wgpu::BufferUsages::STORAGE, 4 * (HEADER + pixels + texels));
        gpu.write(&buffer, bytemuck::bytes_of(&size));
        let entries = [
            wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(depth) },
            wgpu::BindGroupEntry { binding: 1, resource: buffer.as_entire_binding() },
        ];
        let group = |layout, entries| {
            let descriptor = wgpu::BindGroupDescriptor { label: Some("pyramid"), layout, entries };
            gpu.device.create_bind_group(&descriptor)
        };
        let groups = [
            group(&self.layout, &entries),
            group(&self.pixels_layout, &entries[1..]),
            group(&self.owners_layout, &entries[1..]),
        ];
        let [group, pixels_group, owners_group] = groups;
        PyramidOf { size, buffer, group, pixels_group, owners_group }
    }

    /// Makes the levels of what the depth buffer holds.
    pub(in crate::render::gpu) fn record(&self, encoder: &mut wgpu::CommandEncoder, over: &PyramidOf) {
        let descriptor = wgpu::ComputePassDescriptor { label: Some("pyramid"), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_bind_group(3, &over.group, &[]);
        for (level, pipeline) in (1..).zip(&self.levels) {
            let [width, height] = sides(over.size, level);
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        }
    }
}

/// Twin of the WGSL `level_size`.
fn sides(size: [u32; 2], level: u32) -> [u32; 2] {
    (0..level).fold(size, |size, _| size.map(|side| side.div_ceil(4)))
}
