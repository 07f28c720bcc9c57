//! Adds one sample's light to the sum of samples, or its share of the sky alone.

use super::frame::Frame;
use super::{FLOATS, WORDS, fullscreen, fullscreen_pipeline, layout, texture, textures};
use crate::error::Result;
use crate::render::gpu::device::Gpu;
use crate::render::gpu::layout::SUM_FORMAT;
use crate::render::gpu::targets::Targets;
use crate::scene::Region;

/// What is added to the sum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::render::gpu) enum Added {
    /// Premultiplied linear colour, and how many samples saw a primitive; whether light from afar is asked for.
    Light {
        /// Sky or key light, of which the group has directions.
        asks: bool,
    },
    /// The weights of the directions of the sky that are free, and of all that were asked.
    Sky,
}

/// The pipelines.
#[derive(Debug)]
pub(in crate::render::gpu) struct Shade {
    light: wgpu::RenderPipeline,
    /// Without light from afar; without ground as well. On lavapipe a full-HD sample of an empty picture takes 370 ms of processor time with
    /// all of it and 90 ms without.
    plain: [wgpu::RenderPipeline; 2],
    sky: wgpu::RenderPipeline,
    /// Group 1: surfaces and the sum before.
    inputs_layout: wgpu::BindGroupLayout,
    /// Group 2: tubes and directions of the sky and of the key light, and the primitives.
    sky_layout: wgpu::BindGroupLayout,
}

impl Shade {
    pub(super) fn new(gpu: &Gpu, frame: &Frame) -> Result<Shade> {
        let inputs_layout = layout(gpu, "shade", &[texture(0, WORDS), texture(1, WORDS)]);
        let sky_layout = layout(
            gpu,
            "sky",
            &[texture(0, WORDS), texture(1, FLOATS), texture(2, WORDS), texture(3, FLOATS), texture(4, FLOATS)],
        );
        let adding = |entry, constants: &[(&str, f64)]| {
            let groups = [&inputs_layout, &sky_layout];
            fullscreen_pipeline(gpu, frame, ["shade_pass.wgsl", entry], SUM_FORMAT, &groups, constants)
        };
        let plain = [
            adding("fs_shade", &[("asks_light", 0.0)])?,
            adding("fs_shade", &[("asks_light", 0.0), ("has_ground", 0.0)])?,
        ];
        Ok(Shade { light: adding("fs_shade", &[])?, plain, sky: adding("fs_sky", &[])?, inputs_layout, sky_layout })
    }

    /// Surfaces and the sum that one sample reads.
    pub(in crate::render::gpu) fn inputs(
        &self,
        gpu: &Gpu,
        surface: &wgpu::TextureView,
        sum: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        textures(gpu, "shade", &self.inputs_layout, &[surface, sum])
    }

    /// What stands in the way of the light: words and directions of the sky, the same of the key light, and the primitives.
    pub(in crate::render::gpu) fn sky(&self, gpu: &Gpu, views: [&wgpu::TextureView; 5]) -> wgpu::BindGroup {
        textures(gpu, "sky", &self.sky_layout, &views)
    }

    /// Sample `done`: from `sums[done % 2]` to the other.
    pub(in crate::render::gpu) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        (added, done): (Added, u32),
        sky: &wgpu::BindGroup,
        targets: &Targets,
        region: Region,
    ) {
        let pipeline = match added {
            Added::Light { asks: true } => &self.light,
            Added::Light { asks: false } => &self.plain[usize::from(!frame.has_ground())],
            Added::Sky => &self.sky,
        };
        let from = (done % 2) as usize;
        let groups = [&targets.shade_groups[from], sky];
        fullscreen(encoder, frame, ("shade", pipeline), &groups, &targets.sum_views[1 - from], region);
    }
}
