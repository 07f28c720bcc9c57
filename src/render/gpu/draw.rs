//! From samples to sums and pixels: which passes run, in which order.

use super::device::Gpu;
use super::instances::{Culling, Instances};
use super::layout::SampleConstants;
use super::passes::Passes;
use super::passes::resolve::ResolvePipeline;
use super::passes::shade::Added;
use super::sky::Sky;
use super::targets::Targets;
use crate::error::{Error, Result};
use crate::scene::Region;
use glam::Vec3;
use std::collections::VecDeque;

/// Submissions that may be under way; a slow device is not buried in work that nobody may want any more.
const IN_FLIGHT: usize = 4;
/// Directions of the sky that are asked in one pass where all are: as many as a sample of a still asks.
const SKY_SHARE: usize = 4;

/// What all passes of a picture use.
pub(super) struct Draw<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) passes: &'a Passes,
    pub(super) instances: Option<&'a Instances>,
    pub(super) culling: Culling,
    pub(super) sky: &'a Sky,
    /// Whether the sky or the key light are asked what reaches a surface.
    pub(super) asks: bool,
}

impl Draw<'_> {
    /// One sample's visible surface.
    fn geometry(&self, encoder: &mut wgpu::CommandEncoder, targets: &Targets, region: Region) {
        self.passes.geometry.record(encoder, self.passes, (self.instances, self.culling), targets, region);
    }

    /// Adds to the sum what the shade pass finds of the surface.
    fn add(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        added: (Added, u32),
        sky: &wgpu::BindGroup,
        targets: &Targets,
        region: Region,
    ) {
        self.passes.shade.record(encoder, &self.passes.frame, added, sky, targets, region);
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
            let sky = self.sky.group(self.gpu, self.passes, self.asks, done);
            aim(done);
            self.passes.frame.set_sample(self.gpu, region, [done, total]);
            under_way.push_back(self.gpu.submit("sample", |encoder| {
                self.geometry(encoder, targets, region);
                self.add(encoder, (Added::Light { asks: self.asks }, done), &sky, targets, region);
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
        self.passes.frame.set_sample(self.gpu, region, [0, 1]);
        self.gpu.submit("surface", |encoder| self.geometry(encoder, targets, region));
    }

    /// The weights of the free and of all of these directions of the sky at the pixel centres; the sum that holds them.
    pub(super) fn open_sky<'a>(
        &self,
        targets: &'a Targets,
        region: Region,
        directions: &[Vec3],
    ) -> Result<&'a wgpu::Texture> {
        self.surface(targets, region);
        let mut done = 0;
        for share in directions.chunks(SKY_SHARE) {
            let sky = self.sky.of_directions(self.gpu, self.passes, share).ok_or_else(|| {
                let message = "what hides the sky does not fit the device's textures; --renderer cpu has room";
                Error::Gpu(message.to_owned())
            })?;
            // The centre's sample, whichever share of the directions it asks.
            let (offset, turn) = ([0.5; 2], SampleConstants::pack_turn(0, 1));
            let sample = SampleConstants { offset, done, turn, ..SampleConstants::default() };
            self.passes.frame.set_constants(self.gpu, region, sample);
            let submission =
                self.gpu.submit("sky", |encoder| self.add(encoder, (Added::Sky, done), &sky, targets, region));
            self.gpu.wait(&submission)?;
            done += 1;
        }
        Ok(&targets.sums[(done % 2) as usize])
    }

    /// The mean of `samples` into a target; the inputs are what the pipeline reads.
    pub(super) fn resolve(
        &self,
        pipeline: &ResolvePipeline,
        inputs: &[&wgpu::TextureView],
        target: &wgpu::TextureView,
        region: Region,
        samples: u32,
    ) -> wgpu::SubmissionIndex {
        self.passes.frame.set_sample(self.gpu, region, [samples, samples]);
        let inputs = pipeline.inputs(self.gpu, inputs);
        self.gpu.submit("resolve", |encoder| {
            pipeline.record(encoder, &self.passes.frame, &inputs, target, region);
        })
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
