//! Group 0 of every pass: the constants of the picture and of the sample.

use super::{layout, uniform};
use crate::render::frame::FrameConstants;
use crate::render::gpu::clusters::Frustum;
use crate::render::gpu::device::Gpu;
use crate::render::gpu::layout::SampleConstants;
use crate::render::settings::sample_offset;
use crate::scene::Region;
use std::sync::{Mutex, PoisonError};

/// The constants on the device.
#[derive(Debug)]
pub(in crate::render::gpu) struct Frame {
    pub(super) layout: wgpu::BindGroupLayout,
    pub(super) group: wgpu::BindGroup,
    constants: wgpu::Buffer,
    sample: wgpu::Buffer,
    /// What the device has.
    written: Mutex<Option<FrameConstants>>,
}

impl Frame {
    pub(super) fn new(gpu: &Gpu) -> Frame {
        let layout = layout(
            gpu,
            "frame",
            &[
                uniform(gpu, 0, size_of::<FrameConstants>(), false),
                uniform(gpu, 1, size_of::<SampleConstants>(), false),
            ],
        );
        let buffer = |label, size: usize| gpu.empty_buffer(label, wgpu::BufferUsages::UNIFORM, size as u64);
        let constants = buffer("frame", size_of::<FrameConstants>());
        let sample = buffer("sample", size_of::<SampleConstants>());
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: constants.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: sample.as_entire_binding() },
            ],
        });
        Frame { layout, group, constants, sample, written: Mutex::default() }
    }

    pub(in crate::render::gpu) fn set(&self, gpu: &Gpu, constants: &FrameConstants) {
        gpu.write(&self.constants, bytemuck::bytes_of(constants));
        *self.written.lock().unwrap_or_else(PoisonError::into_inner) = Some(*constants);
    }

    /// What a part of the picture shows; `None` before the first picture.
    pub(super) fn frustum(&self, region: Region) -> Option<Frustum> {
        let written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        written.as_ref().map(|frame| Frustum::new(frame, region))
    }

    /// Whether there is ground in the picture.
    pub(super) fn has_ground(&self) -> bool {
        let written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        written.as_ref().is_none_or(|frame| frame.ground_color[3] > 0.5)
    }

    /// Sample `done` of `total` of a part of the picture.
    pub(in crate::render::gpu) fn set_sample(&self, gpu: &Gpu, region: Region, [done, total]: [u32; 2]) {
        let (offset, turn) = (sample_offset(done, total), SampleConstants::pack_turn(done, total));
        self.set_constants(gpu, region, SampleConstants { offset, done, turn, ..SampleConstants::default() });
    }

    /// These constants for a part of the picture.
    pub(in crate::render::gpu) fn set_constants(&self, gpu: &Gpu, region: Region, sample: SampleConstants) {
        let (origin, size) = ([region.x, region.y], [region.width, region.height]);
        gpu.write(&self.sample, bytemuck::bytes_of(&SampleConstants { origin, size, ..sample }));
    }
}
