//! Pictures in a window: the same samples, added up from frame to frame and shown as they come.

use super::adapter;
use super::device::{Gpu, view_of};
use super::ground::write_rows;
use super::interface::{PICTURE_FORMAT, Painter, UserInterface};
use super::layout::TEXT_FORMAT;
use super::targets::Targets;
use super::{AdapterWish, GpuRenderer, instance, zeroed};
use crate::error::{Error, Result};
use crate::render::{Image, Settings, View};
use crate::scene::Region;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a [`GpuRenderer`] shows its pictures on.
#[derive(Debug)]
pub struct WindowSurface {
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    pipeline: wgpu::RenderPipeline,
    /// Holds the sum of samples from frame to frame.
    targets: Option<(Targets, [u32; 2])>,
    /// What is written over the picture that is being summed.
    text: Option<wgpu::TextureView>,
    painter: Painter,
}

impl WindowSurface {
    /// Width and height in pixels.
    #[must_use]
    pub fn size_px(&self) -> [u32; 2] {
        [self.configuration.width, self.configuration.height]
    }
}

impl GpuRenderer {
    /// A renderer that can draw to a window, and the window's surface.
    ///
    /// # Errors
    /// [`Error::Gpu`] if no adapter that fulfils the wish can draw to the window, with what was tried.
    pub fn for_window(
        target: impl Into<wgpu::SurfaceTarget<'static>>,
        size_px: [u32; 2],
        wish: AdapterWish,
    ) -> Result<(GpuRenderer, WindowSurface)> {
        let instance = instance(wish)?;
        let surface = instance
            .create_surface(target)
            .map_err(|error| Error::Gpu(format!("the window cannot be drawn to: {error}")))?;
        let (gpu, adapter) = Gpu::new(adapter::open(wish, &instance, Some(&surface), None)?);
        let renderer = GpuRenderer::on(gpu)?;
        let configuration = configuration(&surface.get_capabilities(&adapter), size_px)?;
        let pipeline = renderer.pipelines.present(&renderer.gpu, PICTURE_FORMAT)?;
        let painter = Painter::new(&renderer.gpu, configuration.format)?;
        let mut window = WindowSurface { surface, configuration, pipeline, targets: None, text: None, painter };
        renderer.configure(&mut window, size_px)?;
        Ok((renderer, window))
    }

    /// Follows the window to a new size. The next [`GpuRenderer::present`] starts from sample 0.
    pub fn resize(&mut self, window: &mut WindowSurface, size_px: [u32; 2]) {
        (window.targets, window.text) = (None, None);
        // A refusal shows at the next present.
        if let Err(Error::Gpu(what)) = self.configure(window, size_px) {
            self.gpu.record(what);
        }
    }

    fn configure(&self, window: &mut WindowSurface, size_px: [u32; 2]) -> Result<()> {
        let most = self.gpu.limits.max_texture_dimension_2d;
        [window.configuration.width, window.configuration.height] = size_px.map(|side| side.clamp(1, most));
        self.gpu.guard("fitting the window's surface", || {
            window.surface.configure(&self.gpu.device, &window.configuration);
            Ok(())
        })
    }

    /// Adds samples `done..done + add` of the loaded scene to those summed for this view, and shows their mean with an interface over it.
    /// With `done` 0 the sum starts anew; anything that changes the picture must start it. Pictures of one
    /// sample, in motion, have no labels.
    ///
    /// A window that is hidden or too slow to take the picture is no error: the samples are summed, the next call shows them.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device or the surface is lost or refuses.
    pub fn present(
        &mut self,
        window: &mut WindowSurface,
        view: &View,
        settings: &Settings,
        done: u32,
        add: u32,
        mut over: UserInterface<'_>,
    ) -> Result<()> {
        // First of all: what egui sends it sends once.
        self.gpu.guard("taking the interface's textures over", || {
            window.painter.update(&self.gpu, &mut over.textures);
            Ok(())
        })?;
        let most = self.gpu.limits.max_texture_dimension_2d;
        let region = view.region();
        let size = [region.width.min(most), region.height.min(most)];
        let region = Region { width: size[0], height: size[1], ..region };
        let text = match window.text.take().filter(|_| done > 0) {
            Some(text) => text,
            None => self.text(&View { region: Some(region), ..*view }, settings.samples > 1)?,
        };
        let frame = self.begin(view, settings, true)?;
        let (targets, done) = match window.targets.take() {
            Some((targets, old)) if old == size => (targets, done),
            // Whatever was summed is gone.
            _ => (Targets::new(&self.gpu, &self.pipelines, size)?, 0),
        };
        let end = done.saturating_add(add.max(u32::from(done == 0)));
        let draw = self.draw(settings);
        self.gpu.guard("drawing", || draw.samples(&targets, region, [done, end], settings.samples.max(end)))?;
        self.gpu.guard("finishing the picture", || {
            let (picture, is_new) = window.painter.picture(&self.gpu, size);
            if is_new || end > done {
                let inputs = [&targets.sums[(end % 2) as usize], self.ground.light(&frame), &text];
                draw.resolve((&window.pipeline, &self.pipelines.present_layout), &inputs, &picture, region, end);
            }
            Ok(())
        })?;
        let shown = self.acquire(window)?;
        if let Some(texture) = shown {
            self.gpu.guard("showing the picture", || {
                let size = window.size_px();
                window.painter.paint(&self.gpu, &view_of(&texture.texture), size, &over)?;
                self.gpu.queue.present(texture);
                Ok(())
            })?;
        }
        window.targets = Some((targets, size));
        window.text = Some(text);
        Ok(())
    }

    /// What is written over a picture, as a texture of its size; one clear texel if that is nothing.
    fn text(&mut self, view: &View, with_labels: bool) -> Result<wgpu::TextureView> {
        let mut layer = Image { width: 1, height: 1, rgba: vec![0; 4] };
        if let Some(scene) = self.scene.clone().filter(|scene| !scene.overlay.is_empty()) {
            let region = view.region();
            layer = Image { width: region.width, height: region.height, rgba: zeroed(region, 4)? };
            self.write(&mut layer, &scene, view, with_labels)?;
        }
        self.gpu.guard("writing the text", || {
            let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
            let texture = self.gpu.texture("text", [layer.width, layer.height], TEXT_FORMAT, usage);
            write_rows(&self.gpu, &texture, 0, [layer.width, layer.height], &layer.rgba);
            Ok(view_of(&texture))
        })
    }

    /// The texture to show next; `None` if the window does not take one now.
    fn acquire(&self, window: &mut WindowSurface) -> Result<Option<wgpu::SurfaceTexture>> {
        // Outdated and lost surfaces are fitted again, once.
        for _ in 0..2 {
            // wgpu 30 panics where it finds the device lost.
            let got = self.gpu.guard("asking the window for a texture", || {
                catch_unwind(AssertUnwindSafe(|| window.surface.get_current_texture()))
                    .map_err(|_| Error::Gpu("the device was lost while drawing to the window".to_owned()))
            })?;
            match got {
                // Suboptimal is usable; a window that changes its size says so itself.
                wgpu::CurrentSurfaceTexture::Success(texture) | wgpu::CurrentSurfaceTexture::Suboptimal(texture) => {
                    return Ok(Some(texture));
                }
                wgpu::CurrentSurfaceTexture::Timeout | wgpu::CurrentSurfaceTexture::Occluded => return Ok(None),
                wgpu::CurrentSurfaceTexture::Outdated | wgpu::CurrentSurfaceTexture::Lost => {
                    let size = window.size_px();
                    self.configure(window, size)?;
                }
                wgpu::CurrentSurfaceTexture::Validation => break,
            }
        }
        Err(Error::Gpu("the window's surface is lost".to_owned()))
    }
}

/// How the surface is set up: 8 bits a channel, sRGB written by us where it can be, opaque, in step with the display.
fn configuration(able: &wgpu::SurfaceCapabilities, size_px: [u32; 2]) -> Result<wgpu::SurfaceConfiguration> {
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba8Unorm, Rgba8UnormSrgb};
    let wanted = [Bgra8Unorm, Rgba8Unorm, Bgra8UnormSrgb, Rgba8UnormSrgb];
    let format = wanted
        .into_iter()
        .find(|format| able.formats.contains(format))
        .ok_or_else(|| Error::Gpu(format!("the window offers no 8-bit colours, only {:?}", able.formats)))?;
    let alpha_mode = able.alpha_modes.iter().copied().find(|&mode| mode == wgpu::CompositeAlphaMode::Opaque);
    Ok(wgpu::SurfaceConfiguration {
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        format,
        color_space: wgpu::SurfaceColorSpace::Auto,
        width: size_px[0].max(1),
        height: size_px[1].max(1),
        desired_maximum_frame_latency: 2,
        present_mode: wgpu::PresentMode::AutoVsync,
        // Alpha is always 1, so that every other mode shows the same.
        alpha_mode: alpha_mode.unwrap_or(wgpu::CompositeAlphaMode::Auto),
        view_formats: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::TextureFormat::{Bgra8UnormSrgb, Rgba8Unorm, Rgba16Float};

    fn able(formats: Vec<wgpu::TextureFormat>) -> wgpu::SurfaceCapabilities {
        wgpu::SurfaceCapabilities { formats, ..wgpu::SurfaceCapabilities::default() }
    }

    #[test]
    fn surfaces_that_leave_srgb_to_us_come_first_and_sizes_are_never_zero() {
        let chosen = |formats| configuration(&able(formats), [0, 7]).map(|c| (c.format, c.width, c.height));
        assert_eq!(chosen(vec![Rgba16Float, Bgra8UnormSrgb, Rgba8Unorm]).unwrap(), (Rgba8Unorm, 1, 7));
        assert_eq!(chosen(vec![Rgba16Float, Bgra8UnormSrgb]).unwrap().0, Bgra8UnormSrgb);
        assert!(chosen(vec![Rgba16Float]).unwrap_err().to_string().contains("8-bit"));
    }
}
