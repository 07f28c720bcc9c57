//! The GPU renderer: the picture of [`super::frame`], computed with wgpu. Held to [`super::cpu::reference`] by tests/suite/parity.rs.
//!
//! For each sample a geometry pass draws every primitive as a quad that bounds it tightly and intersects the pixel's ray
//! with it exactly, into one target of id, depth, normal and colour; a shade pass adds the sample's light to a sum; at the
//! end a resolve pass puts ground or background behind it and makes pixels. The light on the ground is a texture, found
//! once from the scene's distance field (see [`ground`]).
//!
//! The path is the one for WebGL2-class devices: instanced vertex buffers, textures read by `textureLoad`, integer
//! targets, no compute, no storage buffers, no blending. Larger textures and buffers are used where the device has them.
//! Pictures beyond a texture are drawn in tiles, with the same rays as the whole.
//!
//! Limits: on a device whose textures end at 2048 pixels the ground map has at most 2046 texels a side.

#![cfg_attr(not(feature = "window"), allow(dead_code, reason = "windows alone need some of it"))]

mod adapter;
mod device;
mod draw;
mod gbuffer;
mod ground;
mod instances;
#[cfg(feature = "window")]
mod interface;
pub mod layout;
mod pipelines;
pub mod shaders;
mod sky;
mod targets;
#[cfg(feature = "window")]
mod window;

pub use adapter::{AdapterReport, AdapterWish, adapters};
#[cfg(feature = "window")]
pub use interface::UserInterface;
#[cfg(feature = "window")]
pub use window::WindowSurface;

use super::frame::FrameConstants;
use super::{GBuffer, Image, Renderer, Settings, View, overlay};
use crate::error::{Error, Result};
use crate::scene::{Region, Scene};
use device::{Gpu, view_of};
use draw::Draw;
use ground::Ground;
use instances::Instances;
use pipelines::Pipelines;
use sky::Sky;
use std::sync::Arc;
use targets::{Targets, tiles};

/// Longest side of a tile: what every device has, and enough to keep it busy.
const TILE_SIDE: u32 = 8192;

/// Draws with wgpu.
#[derive(Debug)]
pub struct GpuRenderer {
    gpu: Gpu,
    pipelines: Pipelines,
    frame_buffer: wgpu::Buffer,
    sample_buffer: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    scene: Option<Arc<Scene>>,
    instances: Option<Instances>,
    ground: Ground,
    sky: Sky,
    targets: Option<Targets>,
}

impl GpuRenderer {
    /// A renderer on the best adapter that fulfils the wish.
    ///
    /// # Errors
    /// [`Error::Gpu`] with what was tried and why it would not do.
    pub fn new(wish: AdapterWish) -> Result<GpuRenderer> {
        GpuRenderer::open(wish, None)
    }

    /// The same under limits of one's own, to see that a smaller device would do.
    ///
    /// # Errors
    /// [`Error::Gpu`] with what was tried and why it would not do.
    pub fn with_limits(wish: AdapterWish, limits: &wgpu::Limits) -> Result<GpuRenderer> {
        GpuRenderer::open(wish, Some(limits))
    }

    /// A renderer on wgpu's `noop` backend, which checks every call and shader and draws nothing: for tests on machines
    /// without any adapter.
    ///
    /// # Errors
    /// [`Error::Gpu`] if a shader or a pipeline does not pass the checks under these limits.
    pub fn noop(limits: &wgpu::Limits) -> Result<GpuRenderer> {
        let (device, queue) = wgpu::Device::noop(&adapter::device_descriptor(limits.clone()));
        GpuRenderer::on(Gpu::of(device, queue, None))
    }

    fn open(wish: AdapterWish, limits: Option<&wgpu::Limits>) -> Result<GpuRenderer> {
        let instance = instance(wish)?;
        let (gpu, _) = Gpu::new(adapter::open(wish, &instance, None, limits)?);
        GpuRenderer::on(gpu)
    }

    fn on(gpu: Gpu) -> Result<GpuRenderer> {
        let pipelines = Pipelines::new(&gpu)?;
        let (frame_buffer, sample_buffer, frame_group, ground, sky) = gpu.guard("making the uniforms", || {
            let uniform = |label, size| gpu.empty_buffer(label, wgpu::BufferUsages::UNIFORM, size);
            let frame = uniform("frame", layout::FRAME_BYTES);
            let sample = uniform("sample", size_of::<layout::SampleConstants>() as u64);
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("frame"),
                layout: &pipelines.frame_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: sample.as_entire_binding() },
                ],
            });
            Ok((frame, sample, group, Ground::new(&gpu), Sky::new(&gpu, &pipelines)))
        })?;
        let (scene, instances, targets) = (None, None, None);
        Ok(GpuRenderer {
            gpu,
            pipelines,
            frame_buffer,
            sample_buffer,
            frame_group,
            scene,
            instances,
            ground,
            sky,
            targets,
        })
    }

    /// What it runs on; `None` on the noop backend.
    #[must_use]
    pub fn adapter(&self) -> Option<&AdapterReport> {
        self.gpu.report.as_ref()
    }

    /// Destroys the device, as a driver reset would: every later call is an error. For tests of the fall back to the CPU.
    pub fn lose_device(&self) {
        self.gpu.device.destroy();
    }

    /// Writes everything that depends on scene, camera and settings, but not on tile and sample.
    fn begin(&mut self, view: &View, settings: &Settings, with_light: bool) -> Result<FrameConstants> {
        let empty = || Arc::new(Scene::from_blocks(Vec::new(), Vec::new()));
        let scene = self.scene.clone().unwrap_or_else(empty);
        let max_texels = self.gpu.limits.max_texture_dimension_2d.saturating_sub(2);
        let settings = Settings { ground_texels: settings.ground_texels.min(max_texels), ..*settings };
        let frame = FrameConstants::new(&scene, view, &settings);
        let gpu = &self.gpu;
        // In motion nothing is asked, and the tubes of the picture at rest are kept.
        if with_light && asks(&settings) {
            let casters = self.ground.casters(gpu, &self.pipelines, &scene)?;
            let place = (scene.bounds().center(), frame.key_in_world());
            self.sky.prepare(gpu, &self.pipelines, casters, place, &settings)?;
        }
        gpu.guard("writing the frame", || {
            gpu.queue.write_buffer(&self.frame_buffer, 0, bytemuck::bytes_of(&frame));
            if let Some(instances) = &self.instances {
                instances.place(gpu, &scene, view.camera.view_from_world());
            }
            Ok(())
        })?;
        if with_light {
            self.ground.prepare(gpu, &self.pipelines, &self.frame_group, &scene, &frame)?;
        }
        Ok(frame)
    }

    /// Writes the scene's text over a picture; labels need to ask what is seen.
    fn write(&mut self, image: &mut Image, scene: &Scene, view: &View, with_labels: bool) -> Result<()> {
        let asks = with_labels && !scene.overlay.labels.is_empty();
        let probe = if asks { Some(self.gbuffer(&overlay::probe_view(view, overlay::PROBE_SIDE))?) } else { None };
        overlay::write(image, scene, view, probe.as_ref());
        Ok(())
    }

    fn draw(&self, settings: &Settings) -> Draw<'_> {
        Draw {
            sky: &self.sky,
            asks: asks(settings),
            gpu: &self.gpu,
            pipelines: &self.pipelines,
            frame_group: &self.frame_group,
            sample_buffer: &self.sample_buffer,
            instances: self.instances.as_ref(),
        }
    }

    /// The tiles of a view and targets that all of them fit.
    fn tiles(&mut self, region: Region) -> Result<(Vec<Region>, Targets)> {
        let tiles = tiles(region, self.gpu.limits.max_texture_dimension_2d.min(TILE_SIDE));
        let size = tiles.first().map_or([1, 1], |tile| [tile.width, tile.height]);
        let targets = match self.targets.take().filter(|targets| targets.suits(size)) {
            Some(targets) => targets,
            None => Targets::new(&self.gpu, &self.pipelines, size)?,
        };
        Ok((tiles, targets))
    }
}

/// Whether any light from afar is asked for.
fn asks(settings: &Settings) -> bool {
    settings.ao > 0 || settings.shadow
}

fn instance(wish: AdapterWish) -> Result<wgpu::Instance> {
    if wish == AdapterWish::Hardware {
        adapter::check_for_hardware()?;
    }
    adapter::instance().ok_or_else(|| Error::Gpu("this build has no graphics backend".to_owned()))
}

impl Renderer for GpuRenderer {
    fn name(&self) -> String {
        self.adapter().map_or_else(|| "gpu: noop".to_owned(), |report| format!("gpu: {report}"))
    }

    fn load(&mut self, scene: Arc<Scene>) -> Result<()> {
        let same = self
            .scene
            .as_ref()
            .is_some_and(|old| Arc::ptr_eq(&old.blocks, &scene.blocks) && old.placements == scene.placements);
        if !same || self.instances.is_none() {
            // The old one goes first: the two together may be more than the device holds.
            (self.scene, self.instances) = (None, None);
            self.ground.clear();
            self.sky.clear();
            self.instances = Some(Instances::new(&self.gpu, &self.pipelines, &scene)?);
        }
        self.scene = Some(scene);
        Ok(())
    }

    fn image(&mut self, view: &View, settings: &Settings) -> Result<Image> {
        let frame = self.begin(view, settings, true)?;
        let region = view.region();
        let (tiles, targets) = self.tiles(region)?;
        let samples = settings.samples.clamp(1, 4096);
        let mut rgba = zeroed(region, 4)?;
        let draw = self.draw(settings);
        self.gpu.guard("drawing", || {
            let size = tiles.first().map_or([1, 1], |tile| [tile.width, tile.height]);
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
            let picture = self.gpu.texture("picture", size, layout::IMAGE_FORMAT, usage);
            let picture_view = view_of(&picture);
            for &tile in &tiles {
                draw.samples(&targets, tile, [0, samples], samples)?;
                let inputs = [&targets.sums[(samples % 2) as usize], self.ground.light(&frame)];
                draw.resolve(
                    (&self.pipelines.resolve, &self.pipelines.resolve_layout),
                    &inputs,
                    &picture_view,
                    tile,
                    samples,
                );
                draw.read_back(&picture, 4, tile, |y, row| {
                    let (x, y) = ((tile.x - region.x) as usize, (tile.y - region.y + y) as usize);
                    let start = (y * region.width as usize + x) * 4;
                    rgba[start..start + row.len()].copy_from_slice(row);
                })?;
            }
            Ok(())
        })?;
        self.targets = Some(targets);
        let mut image = Image { width: region.width, height: region.height, rgba };
        if let Some(scene) = self.scene.clone() {
            self.write(&mut image, &scene, view, true)?;
        }
        Ok(image)
    }

    fn gbuffer(&mut self, view: &View) -> Result<GBuffer> {
        let frame = self.begin(view, &Settings::default(), false)?;
        let region = view.region();
        let (tiles, targets) = self.tiles(region)?;
        let mut texels: Vec<u8> = zeroed(region, 16)?;
        let draw = self.draw(&Settings::default());
        self.gpu.guard("drawing surfaces", || {
            for &tile in &tiles {
                draw.surface(&targets, tile);
                draw.read_back(&targets.surface, 16, tile, |y, row| {
                    let (x, y) = ((tile.x - region.x) as usize, (tile.y - region.y + y) as usize);
                    let start = (y * region.width as usize + x) * 16;
                    texels[start..start + row.len()].copy_from_slice(row);
                })?;
            }
            Ok(())
        })?;
        self.targets = Some(targets);
        Ok(gbuffer::unpack(&frame, view, &texels))
    }
}

/// Bytes for a region; an error, not an abort, if there is not that much memory.
fn zeroed(region: Region, bytes_a_pixel: usize) -> Result<Vec<u8>> {
    let bytes = (region.width as usize).checked_mul(region.height as usize).and_then(|n| n.checked_mul(bytes_a_pixel));
    let mut buffer = Vec::new();
    match bytes {
        Some(bytes) if buffer.try_reserve_exact(bytes).is_ok() => buffer.resize(bytes, 0),
        _ => {
            let (width, height) = (region.width, region.height);
            return Err(Error::Gpu(format!("a picture of {width} × {height} pixels does not fit into memory")));
        }
    }
    Ok(buffer)
}
