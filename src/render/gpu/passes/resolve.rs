//! From the sum of samples to pixels: the mean, over ground or background, for pictures or for a window.

use super::frame::Frame;
use super::{WORDS, fullscreen, fullscreen_pipeline, layout, texture, textures};
use crate::error::Result;
use crate::render::gpu::device::Gpu;
use crate::render::gpu::layout::IMAGE_FORMAT;
use crate::scene::Region;

/// The pipeline for pictures; windows have one of their own, for their format.
#[derive(Debug)]
pub(in crate::render::gpu) struct Resolve {
    image: ResolvePipeline,
    /// Group 1 of the pipeline of a window: the sum, the ground's light, the text.
    window_layout: wgpu::BindGroupLayout,
}

/// A pipeline and the layout of its group 1: the sum, the ground's light, and for windows the text.
#[derive(Debug, Clone)]
pub(in crate::render::gpu) struct ResolvePipeline {
    /// With ground, and without.
    pipelines: [wgpu::RenderPipeline; 2],
    layout: wgpu::BindGroupLayout,
}

impl Resolve {
    pub(super) fn new(gpu: &Gpu, frame: &Frame) -> Result<Resolve> {
        let image_layout = layout(gpu, "resolve", &[texture(0, WORDS), texture(1, WORDS)]);
        let window_layout = layout(gpu, "present", &[texture(0, WORDS), texture(1, WORDS), texture(2, WORDS)]);
        let image = ResolvePipeline::new(gpu, frame, "fs_resolve", IMAGE_FORMAT, image_layout)?;
        Ok(Resolve { image, window_layout })
    }

    /// The one for pictures.
    pub(in crate::render::gpu) fn image(&self) -> &ResolvePipeline {
        &self.image
    }

    /// One that writes to a window's surface of this format.
    pub(in crate::render::gpu) fn for_window(
        &self,
        gpu: &Gpu,
        frame: &Frame,
        format: wgpu::TextureFormat,
    ) -> Result<ResolvePipeline> {
        gpu.guard("building the window's pipeline", || {
            let entry = if format.is_srgb() { "fs_present_linear" } else { "fs_present" };
            ResolvePipeline::new(gpu, frame, entry, format, self.window_layout.clone())
        })
    }
}

impl ResolvePipeline {
    fn new(
        gpu: &Gpu,
        frame: &Frame,
        entry: &str,
        format: wgpu::TextureFormat,
        layout: wgpu::BindGroupLayout,
    ) -> Result<ResolvePipeline> {
        let of = |constants: &[(&str, f64)]| {
            fullscreen_pipeline(gpu, frame, ["resolve.wgsl", entry], format, &[&layout], constants)
        };
        Ok(ResolvePipeline { pipelines: [of(&[])?, of(&[("has_ground", 0.0)])?], layout })
    }

    /// What it reads, in the order of the layout.
    pub(in crate::render::gpu) fn inputs(&self, gpu: &Gpu, views: &[&wgpu::TextureView]) -> wgpu::BindGroup {
        textures(gpu, "resolve", &self.layout, views)
    }

    /// The frame's sample counts all samples of the sum.
    pub(in crate::render::gpu) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        inputs: &wgpu::BindGroup,
        target: &wgpu::TextureView,
        region: Region,
    ) {
        fullscreen(
            encoder,
            frame,
            ("resolve", &self.pipelines[usize::from(!frame.has_ground())]),
            &[inputs],
            target,
            region,
        );
    }
}
