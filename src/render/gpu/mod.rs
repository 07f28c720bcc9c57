//! The GPU renderer: the picture of [`super::frame`], computed with wgpu. Held to [`super::cpu::reference`] by tests/suite/parity.rs.
//!
//! For each sample a geometry pass draws every primitive as a quad that bounds it tightly and intersects the pixel's ray
//! with it exactly, into one target of id, depth, normal and colour; a shade pass adds the sample's light to a sum; at the
//! end a resolve pass puts ground or background behind it and makes pixels. The light on the ground is a texture, found
//! once from the scene's distance field (see [`ground`]). [`passes`] lists them. What does not change from one picture to the
//! next is not made again: instances, pipelines, the field, the ground's map, the tubes of the light, targets.
//!
//! The path is the one for WebGL2-class devices: instanced vertex buffers, textures read by `textureLoad`, integer
//! targets, no compute, no storage buffers, no blending. Larger textures and buffers are used where the device has them, and where it
//! computes, what others hide is not drawn, and what is small not by quads ([`passes::cull`]); where it does not, the CPU leaves out what is not in the picture ([`clusters`]).
//! Pictures beyond a texture are drawn in tiles, with the same rays as the whole.
//!
//! Limits: on a device whose textures end at 2048 pixels the ground map has at most 2046 texels a side.

#![cfg_attr(not(feature = "window"), allow(dead_code, reason = "windows alone need some of it"))]

mod adapter;
pub mod clusters;
mod device;
mod draw;
mod gbuffer;
mod ground;
mod instances;
#[cfg(feature = "window")]
mod interface;
pub mod layout;
mod listed;
mod passes;
pub mod shaders;
mod sky;
mod targets;
#[cfg(feature = "window")]
mod window;

pub use adapter::{AdapterReport, AdapterWish, adapters};
pub use device::Work;
pub use instances::Culling;
#[cfg(feature = "window")]
pub use interface::UserInterface;
#[cfg(feature = "window")]
pub use window::{Accumulation, WindowSurface};

use super::frame::FrameConstants;
use super::lens::Lens;
use super::sky::directions;
use super::{GBuffer, Image, Renderer, Settings, SkyVisibility, View, overlay};
use crate::error::{Error, Result};
use crate::scene::{Region, Scene};
use device::{Gpu, view_of};
use draw::Draw;
use glam::Affine3A;
use ground::Ground;
use instances::Instances;
use passes::Passes;
use sky::Sky;
use std::sync::Arc;
use targets::{Targets, tiles};

/// Longest side of a tile: what every device has, and enough to keep it busy.
const TILE_SIDE: u32 = 8192;

/// Draws with wgpu.
#[derive(Debug)]
pub struct GpuRenderer {
    gpu: Gpu,
    passes: Passes,
    /// What the frame's uniform holds, and where the placements' stand; `None` before the first picture.
    written: Option<(FrameConstants, Affine3A)>,
    scene: Option<Arc<Scene>>,
    instances: Option<Instances>,
    ground: Ground,
    sky: Sky,
    culling: Culling,
    targets: Option<Targets>,
    /// Whether it was said that the light from afar does not fit; once a scene is enough.
    is_lack_said: bool,
    notices: Vec<String>,
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

    /// The same under the limits that all devices keep.
    ///
    /// # Errors
    /// [`Error::Gpu`] with what was tried and why it would not do.
    pub fn downlevel(wish: AdapterWish) -> Result<GpuRenderer> {
        GpuRenderer::open(wish, Some(&wgpu::Limits::downlevel_webgl2_defaults()))
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
        let instance = instance(wish, None)?;
        let (gpu, _) = Gpu::new(adapter::open(wish, &instance, None, limits)?);
        GpuRenderer::on(gpu)
    }

    fn on(gpu: Gpu) -> Result<GpuRenderer> {
        let passes = Passes::new(&gpu)?;
        let (ground, sky) = gpu.guard("making the light", || Ok((Ground::new(&gpu), Sky::new(&gpu, &passes))))?;
        let (written, scene, instances, targets) = (None, None, None, None);
        Ok(GpuRenderer {
            gpu,
            passes,
            written,
            scene,
            instances,
            ground,
            sky,
            culling: Culling::default(),
            targets,
            is_lack_said: false,
            notices: Vec::new(),
        })
    }

    /// What it runs on; `None` on the noop backend.
    #[must_use]
    pub fn adapter(&self) -> Option<&AdapterReport> {
        self.gpu.report.as_ref()
    }

    /// What was made on the device since the renderer is there: the same picture again makes next to nothing.
    #[must_use]
    pub fn work(&self) -> Work {
        self.gpu.work()
    }

    /// What is left out of what the device is asked to draw: by default all that can be. The pictures are the same: for measurements and tests.
    pub fn set_culling(&mut self, culling: Culling) {
        self.culling = culling;
    }

    /// Whether what others hide is left out: the device computes, and the scene has many balls or sticks that are not copied often.
    #[must_use]
    pub fn lists(&self) -> bool {
        self.instances.as_ref().map_or(self.gpu.can_cull(), |instances| !instances.listed(Culling::Full).is_empty())
    }

    /// Balls and sticks that the last sample drew by lists, for tests.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost.
    pub fn listed_instances(&self) -> Result<u64> {
        let Some(instances) = &self.instances else { return Ok(0) };
        let mut sum = 0;
        for listed in instances.listed(self.culling) {
            sum += listed.seen(&self.gpu)?;
        }
        Ok(sum)
    }

    /// Destroys the device, as a driver reset would: every later call is an error. For tests of the fall back to the CPU.
    pub fn lose_device(&self) {
        self.gpu.device.destroy();
    }

    /// Has the device be out of memory from now on: every later call gets the error that wgpu hands over then. For tests of the fall back to
    /// the CPU.
    pub fn exhaust_device(&self) {
        self.gpu.exhaust();
    }

    /// Asks the device for so many buffers of a gibibyte, in a scope as everything is; they are given back. For tests with more than there is.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device does not have them.
    #[cfg(test)]
    pub(crate) fn take_gibibytes(&self, count: usize) -> Result<()> {
        self.gpu.guard("filling the memory", || {
            let usage = wgpu::BufferUsages::VERTEX;
            let buffers: Vec<_> = (0..count).map(|_| self.gpu.empty_buffer("ballast", usage, 1 << 30)).collect();
            drop(buffers);
            Ok(())
        })
    }

    /// A renderer that draws nothing, and what destroys its device while something else has the renderer.
    #[cfg(test)]
    pub(crate) fn with_loss() -> Result<(GpuRenderer, impl Fn())> {
        let renderer = GpuRenderer::noop(&wgpu::Limits::downlevel_webgl2_defaults())?;
        let device = renderer.gpu.device.clone();
        Ok((renderer, move || device.destroy()))
    }

    /// The same with what uses its memory up.
    #[cfg(test)]
    pub(crate) fn with_exhaustion() -> Result<(GpuRenderer, impl Fn())> {
        let renderer = GpuRenderer::noop(&wgpu::Limits::downlevel_webgl2_defaults())?;
        let exhaust = renderer.gpu.exhausting();
        Ok((renderer, exhaust))
    }

    /// The loaded scene, or an empty one.
    fn scene(&self) -> Arc<Scene> {
        self.scene.clone().unwrap_or_else(|| Arc::new(Scene::from_blocks(Vec::new(), Vec::new())))
    }

    /// The constants of a picture; the ground's map fits the device.
    fn constants(&self, scene: &Scene, view: &View, settings: &Settings) -> FrameConstants {
        let max_texels = self.gpu.limits.max_texture_dimension_2d.saturating_sub(2);
        let settings = Settings { ground_texels: settings.ground_texels.min(max_texels), ..*settings };
        FrameConstants::new(scene, view, &settings)
    }

    /// Writes everything that depends on scene, camera and settings, but not on tile and sample, unless it is there.
    fn begin(&mut self, scene: &Scene, view: &View, settings: &Settings, outlines: bool) -> Result<FrameConstants> {
        let frame = self.constants(scene, view, settings);
        let frame = if outlines { frame } else { frame.without_outlines() };
        let wanted = (frame, view.camera.view_from_world());
        if self.written != Some(wanted) {
            self.gpu.guard("writing the frame", || {
                self.passes.frame.set(&self.gpu, &frame);
                if let Some(instances) = &self.instances {
                    instances.place(&self.gpu, scene, wanted.1);
                }
                Ok(())
            })?;
            self.written = Some(wanted);
        }
        Ok(frame)
    }

    /// The same with what lights a finished picture: the ground's map, and what hides the light from afar. In motion that is not
    /// asked, and kept for the picture at rest.
    fn begin_lit(&mut self, view: &View, settings: &Settings) -> Result<FrameConstants> {
        let scene = self.scene();
        let frame = self.begin(&scene, view, settings, true)?;
        if asks(settings) {
            let casters = self.ground.casters(&self.gpu, &self.passes, &scene)?;
            let place = (scene.bounds().center(), frame.key_in_world());
            self.sky.prepare(&self.gpu, &self.passes, casters, place, settings)?;
        }
        self.ground.prepare(&self.gpu, &self.passes, &scene, &frame, !asks(settings))?;
        Ok(frame)
    }

    /// Moves the camera to where sample `sample` of `samples` looks from, if the picture has a depth of field.
    fn aim(&self, (view, settings): (&View, &Settings), sample: u32, samples: u32) {
        let Some(scene) = &self.scene else { return };
        if let Some(lens) = Lens::of(scene, view) {
            self.set_view(scene, &lens.view(view, sample, samples), settings);
        }
    }

    /// Moves it back to the middle of the lens.
    fn aim_back(&self, (view, settings): (&View, &Settings)) {
        let Some(scene) = &self.scene else { return };
        if Lens::of(scene, view).is_some() {
            self.set_view(scene, view, settings);
        }
    }

    /// Writes what depends on the camera.
    fn set_view(&self, scene: &Scene, view: &View, settings: &Settings) {
        self.passes.frame.set(&self.gpu, &self.constants(scene, view, settings));
        if let Some(instances) = &self.instances {
            instances.place(&self.gpu, scene, view.camera.view_from_world());
        }
    }

    /// Writes the scene's text over a picture; labels need to ask what is seen.
    fn write(&mut self, image: &mut Image, scene: &Scene, view: &View, with_labels: bool) -> Result<()> {
        let asks = with_labels && !scene.overlay.labels.is_empty();
        let probe = if asks { Some(self.gbuffer(&overlay::probe_view(view, overlay::PROBE_SIDE))?) } else { None };
        overlay::write(image, scene, view, probe.as_ref());
        Ok(())
    }

    fn draw(&self, asks: bool) -> Draw<'_> {
        let (gpu, passes, instances) = (&self.gpu, &self.passes, self.instances.as_ref());
        Draw { gpu, passes, instances, culling: self.culling, sky: &self.sky, asks }
    }

    /// A texture for finished pixels, as large as the largest tile.
    fn picture(&self, tile: Option<&Region>) -> wgpu::Texture {
        let size = tile.map_or([1, 1], |tile| [tile.width, tile.height]);
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        self.gpu.texture("picture", size, layout::IMAGE_FORMAT, usage)
    }

    /// The tiles of a view and targets that all of them fit.
    fn tiles(&mut self, region: Region) -> Result<(Vec<Region>, Targets)> {
        let tiles = tiles(region, self.gpu.limits.max_texture_dimension_2d.min(TILE_SIDE));
        let size = tiles.first().map_or([1, 1], |tile| [tile.width, tile.height]);
        let targets = match self.targets.take().filter(|targets| targets.suits(size)) {
            Some(targets) => targets,
            None => Targets::new(&self.gpu, &self.passes, size)?,
        };
        Ok((tiles, targets))
    }
}

/// Whether any light from afar is asked for.
fn asks(settings: &Settings) -> bool {
    settings.ao > 0 || settings.shadow
}

fn instance(wish: AdapterWish, display: Option<adapter::Display>) -> Result<wgpu::Instance> {
    if wish == AdapterWish::Hardware {
        adapter::check_for_hardware()?;
    }
    adapter::instance(display).ok_or_else(|| Error::Gpu("this build has no graphics backend".to_owned()))
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
            (self.scene, self.instances, self.written) = (None, None, None);
            self.ground.clear();
            self.sky.clear();
            self.is_lack_said = false;
            self.instances = Some(Instances::new(&self.gpu, &self.passes, &scene)?);
        }
        self.scene = Some(scene);
        Ok(())
    }

    fn image(&mut self, view: &View, settings: &Settings) -> Result<Image> {
        let frame = self.begin_lit(view, settings)?;
        let region = view.region();
        let (tiles, targets) = self.tiles(region)?;
        let samples = settings.samples.clamp(1, 4096);
        let mut rgba = zeroed(region, 4)?;
        let draw = self.draw(asks(settings));
        self.gpu.guard("drawing", || {
            let picture = self.picture(tiles.first());
            let picture_view = view_of(&picture);
            let pipeline = self.passes.resolve.image();
            for &tile in &tiles {
                let aim = |sample| self.aim((view, settings), sample, samples);
                draw.samples(&targets, tile, [0, samples], samples, aim)?;
                self.aim_back((view, settings));
                let inputs = [&targets.sum_views[(samples % 2) as usize], self.ground.light(&frame)];
                draw.resolve(pipeline, &inputs, &picture_view, tile, samples);
                draw.read_back(&picture, 4, tile, |y, row| put(&mut rgba, 4, region, tile, y, row))?;
            }
            Ok(())
        })?;
        self.targets = Some(targets);
        if self.sky.take_lack() && !self.is_lack_said {
            self.is_lack_said = true;
            let largest = self.gpu.limits.max_texture_dimension_2d;
            self.notices.push(format!(
                "there is no ambient occlusion and no shadow on the molecule: the scene is too large for a graphics device whose textures \
                 have {largest} pixels a side; --renderer cpu draws both"
            ));
        }
        let mut image = Image { width: region.width, height: region.height, rgba };
        if let Some(scene) = self.scene.clone() {
            self.write(&mut image, &scene, view, true)?;
        }
        Ok(image)
    }

    fn take_notices(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notices)
    }

    fn gbuffer(&mut self, view: &View) -> Result<GBuffer> {
        let frame = self.begin(&self.scene(), view, &Settings::default(), false)?;
        let region = view.region();
        let (tiles, targets) = self.tiles(region)?;
        let mut texels: Vec<u8> = zeroed(region, 16)?;
        let draw = self.draw(false);
        self.gpu.guard("drawing surfaces", || {
            for &tile in &tiles {
                draw.surface(&targets, tile);
                draw.read_back(&targets.surface, 16, tile, |y, row| put(&mut texels, 16, region, tile, y, row))?;
            }
            Ok(())
        })?;
        self.targets = Some(targets);
        Ok(gbuffer::unpack(&frame, view, &texels))
    }

    fn sky_visibility(&mut self, view: &View, count: u32) -> Result<SkyVisibility> {
        let scene = self.scene();
        self.begin(&scene, view, &Settings::default(), false)?;
        let casters = self.ground.casters(&self.gpu, &self.passes, &scene)?;
        self.sky.hold(casters, scene.bounds().center());
        let region = view.region();
        let (tiles, targets) = self.tiles(region)?;
        let directions = directions(count.min(Settings::MOST_DIRECTIONS));
        let mut open = vec![1.0f32; zeroed(region, 4)?.len() / 4];
        let draw = self.draw(false);
        self.gpu.guard("asking the sky", || {
            for &tile in &tiles {
                let sum = draw.open_sky(&targets, tile, &directions)?;
                draw.read_back(sum, 16, tile, |y, row| {
                    let start = (tile.y - region.y + y) as usize * region.width as usize + (tile.x - region.x) as usize;
                    for (open, texel) in open[start..].iter_mut().zip(row.chunks_exact(16)) {
                        let [seen, all, ..]: [f32; 4] = bytemuck::pod_read_unaligned(texel);
                        *open = if all > 0.0 { seen / all } else { 1.0 };
                    }
                })?;
            }
            Ok(())
        })?;
        self.targets = Some(targets);
        Ok(SkyVisibility { width: region.width, height: region.height, open })
    }
}

/// Puts row `y` of a tile where it belongs among the texels of a region.
fn put(texels: &mut [u8], texel_bytes: usize, region: Region, tile: Region, y: u32, row: &[u8]) {
    let (x, y) = ((tile.x - region.x) as usize, (tile.y - region.y + y) as usize);
    let start = (y * region.width as usize + x) * texel_bytes;
    texels[start..start + row.len()].copy_from_slice(row);
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
