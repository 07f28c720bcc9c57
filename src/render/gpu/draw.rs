//! Recording of the passes: geometry, shade, resolve.

use super::device::Gpu;
use super::instances::Instances;
use super::layout::SampleConstants;
use super::pipelines::Pipelines;
use super::sky::Sky;
use super::targets::Targets;
use crate::error::Result;
use crate::render::settings::sample_offset;
use crate::scene::Region;
use std::collections::VecDeque;

/// Submissions that may be under way; a slow device is not buried in work that nobody may want any more.
const IN_FLIGHT: usize = 4;

/// What all passes of a picture use.
pub(super) struct Draw<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) pipelines: &'a Pipelines,
    /// Group 0.
    pub(super) frame_group: &'a wgpu::BindGroup,
    /// The [`SampleConstants`] of group 0.
    pub(super) sample_buffer: &'a wgpu::Buffer,
    pub(super) instances: Option<&'a Instances>,
    pub(super) sky: &'a Sky,
    /// Whether the sky or the key light are asked what reaches a surface.
    pub(super) asks: bool,
}

pub(super) fn cleared(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
    }
}

pub(super) fn cleared_depth(view: &wgpu::TextureView) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
        stencil_ops: None,
    }
}

impl Draw<'_> {
    /// Sample `done` of `total`.
    fn set_sample(&self, region: Region, [done, total]: [u32; 2]) {
        let (origin, size) = ([region.x, region.y], [region.width, region.height]);
        let (offset, turn) = (sample_offset(done, total), SampleConstants::pack_turn(done, total));
        let constants = SampleConstants { origin, size, offset, done, turn };
        self.gpu.queue.write_buffer(self.sample_buffer, 0, bytemuck::bytes_of(&constants));
    }

    /// One sample's visible surface.
    fn geometry(&self, encoder: &mut wgpu::CommandEncoder, targets: &Targets, region: Region) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("geometry"),
            color_attachments: &[Some(cleared(&targets.surface_view))],
            depth_stencil_attachment: Some(cleared_depth(&targets.depth)),
            ..wgpu::RenderPassDescriptor::default()
        });
        set_part(&mut pass, region);
        pass.set_bind_group(0, self.frame_group, &[]);
        if let Some(instances) = self.instances {
            instances.draw(&self.pipelines.surfaces, &mut pass);
        }
    }

    /// A triangle over the part of the target that the region takes.
    fn fullscreen(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        groups: &[&wgpu::BindGroup],
        target: &wgpu::TextureView,
        region: Region,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("fullscreen"),
            color_attachments: &[Some(cleared(target))],
            ..wgpu::RenderPassDescriptor::default()
        });
        set_part(&mut pass, region);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, self.frame_group, &[]);
        for (index, group) in (1..).zip(groups) {
            pass.set_bind_group(index, *group, &[]);
        }
        pass.draw(0..3, 0..1);
    }

    /// Adds samples `first..end` of `total` to the sums. `aim` is called before each is drawn: it may move the camera.
    pub(super) fn samples(
        &self,
        targets: &Targets,
        region: Region,
        [first, end]: [u32; 2],
        total: u32,
        aim: impl Fn(u32),
    ) -> Result<()> {
        let mut under_way = VecDeque::new();
        // Tubes of one sample at a time are large.
        let in_flight = if self.asks && self.sky.is_split() { 1 } else { IN_FLIGHT };
        for done in first..end {
            let sky_group = self.sky.group(self.gpu, self.pipelines, self.asks, done);
            aim(done);
            self.set_sample(region, [done, total]);
            let from = (done % 2) as usize;
            under_way.push_back(self.gpu.submit("sample", |encoder| {
                self.geometry(encoder, targets, region);
                let (groups, target) = ([&targets.shade_groups[from], &sky_group], &targets.sums[1 - from]);
                self.fullscreen(encoder, &self.pipelines.shade, &groups, target, region);
            }));
            if under_way.len() > in_flight
                && let Some(oldest) = under_way.pop_front()
            {
                self.gpu.wait(&oldest)?;
            }
        }
        Ok(())
    }

    /// The surface at the pixel centres.
    pub(super) fn surface(&self, targets: &Targets, region: Region) {
        self.set_sample(region, [0, 1]);
        self.gpu.submit("surface", |encoder| self.geometry(encoder, targets, region));
    }

    /// Records the mean of `samples` into a target, with a resolve pipeline; the inputs are the sum, the ground's light and what
    /// else the pipeline's layout of group 1 has.
    pub(super) fn resolve(
        &self,
        (pipeline, layout): (&wgpu::RenderPipeline, &wgpu::BindGroupLayout),
        inputs: &[&wgpu::TextureView],
        target: &wgpu::TextureView,
        region: Region,
        samples: u32,
    ) -> wgpu::SubmissionIndex {
        self.set_sample(region, [samples, samples]);
        let entry =
            |(binding, &input)| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(input) };
        let entries: Vec<_> = (0..).zip(inputs).map(entry).collect();
        let label = Some("resolve");
        let group = self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout, entries: &entries });
        self.gpu.submit("resolve", |encoder| self.fullscreen(encoder, pipeline, &[&group], target, region))
    }

    /// Hands the rows of a texture's upper left part to `row`.
    pub(super) fn read_back(
        &self,
        texture: &wgpu::Texture,
        texel_bytes: u32,
        region: Region,
        mut row: impl FnMut(u32, &[u8]),
    ) -> Result<()> {
        let row_bytes = region.width * texel_bytes;
        let padded = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(padded) * u64::from(region.height);
        let buffer = self.gpu.empty_buffer("read back", wgpu::BufferUsages::MAP_READ, size);
        let submission = self.gpu.submit("read back", |encoder| {
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(padded),
                        rows_per_image: None,
                    },
                },
                wgpu::Extent3d { width: region.width, height: region.height, depth_or_array_layers: 1 },
            );
        });
        let bytes = self.gpu.read(&buffer, &submission)?;
        for (y, line) in bytes.chunks(padded as usize).enumerate() {
            row(y as u32, &line[..row_bytes as usize]);
        }
        Ok(())
    }
}

fn set_part(pass: &mut wgpu::RenderPass<'_>, region: Region) {
    pass.set_viewport(0.0, 0.0, region.width as f32, region.height as f32, 0.0, 1.0);
    pass.set_scissor_rect(0, 0, region.width, region.height);
}
