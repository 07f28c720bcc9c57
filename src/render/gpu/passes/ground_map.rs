//! The light on the ground: the distance field asked at every texel of a map that is kept.

use super::frame::Frame;
use super::{FLOATS, fullscreen_pipeline, layout, texture, uniform};
use crate::error::Result;
use crate::render::gpu::device::{Gpu, view_of};
use crate::render::gpu::layout::{FieldConstants, GROUND_FORMAT};

/// Texels of one submission: small enough that a slow device finishes it well before its watchdog (2 s on Windows)
/// wakes. A texel asks the field seven times.
const TEXELS_A_SUBMISSION: u32 = 16_384;

/// The pipeline.
#[derive(Debug)]
pub(in crate::render::gpu) struct GroundMapPass {
    pipeline: wgpu::RenderPipeline,
    /// Group 1: the distance field.
    field_layout: wgpu::BindGroupLayout,
}

impl GroundMapPass {
    pub(super) fn new(gpu: &Gpu, frame: &Frame) -> Result<GroundMapPass> {
        let entries = [uniform(gpu, 0, size_of::<FieldConstants>(), false), texture(1, FLOATS), texture(2, FLOATS)];
        let field_layout = layout(gpu, "field", &entries);
        let shader = ["ground_map.wgsl", "fs_ground_map"];
        let pipeline = fullscreen_pipeline(gpu, frame, shader, GROUND_FORMAT, &[&field_layout], &[])?;
        Ok(GroundMapPass { pipeline, field_layout })
    }

    /// The field: its constants, boxes and primitives.
    pub(in crate::render::gpu) fn field(
        &self,
        gpu: &Gpu,
        constants: &wgpu::Buffer,
        [boxes, primitives]: [&wgpu::TextureView; 2],
    ) -> wgpu::BindGroup {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("field"),
            layout: &self.field_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: constants.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(boxes) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(primitives) },
            ],
        })
    }

    /// Draws a map, a few rows a submission.
    pub(in crate::render::gpu) fn draw(
        &self,
        gpu: &Gpu,
        frame: &Frame,
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
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, &frame.group, &[]);
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
}
