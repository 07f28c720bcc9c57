//! Pictures in a window: the same samples, added up from frame to frame and shown as they come.

use super::adapter;
use super::device::{Gpu, view_of};
use super::ground::write_rows;
use super::interface::{PICTURE_FORMAT, Painter, UserInterface};
use super::layout::{IMAGE_FORMAT, TEXT_FORMAT};
use super::passes::resolve::ResolvePipeline;
use super::targets::Targets;
use super::{AdapterWish, GpuRenderer, asks, instance, put, zeroed};
use crate::error::{Error, Result};
use crate::render::frame::FrameConstants;
use crate::render::{Image, Settings, View};
use crate::scene::Region;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A picture that grows sample by sample.
#[derive(Debug, Default)]
pub struct Accumulation {
    /// Hold the sum of samples from frame to frame.
    targets: Option<(Targets, [u32; 2])>,
    /// What is written over it.
    text: Option<wgpu::TextureView>,
    /// Samples in the sum.
    done: u32,
    /// What they were drawn with.
    shown: Option<(View, FrameConstants)>,
}

/// What a [`GpuRenderer`] shows its pictures on.
#[derive(Debug)]
pub struct WindowSurface {
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    pipeline: ResolvePipeline,
    sum: Accumulation,
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
    pub fn for_window<W>(target: W, size_px: [u32; 2], wish: AdapterWish) -> Result<(GpuRenderer, WindowSurface)>
    where
        W: Into<wgpu::SurfaceTarget<'static>> + wgpu::wgt::WgpuHasDisplayHandle + Clone,
    {
        let instance = instance(wish, Some(Box::new(target.clone())))?;
        let surface = instance
            .create_surface(target)
            .map_err(|error| Error::Gpu(format!("the window cannot be drawn to: {error}")))?;
        let (gpu, adapter) = Gpu::new(adapter::open(wish, &instance, Some(&surface), None)?);
        let renderer = GpuRenderer::on(gpu)?;
        let configuration = configuration(&surface.get_capabilities(&adapter), size_px)?;
        let passes = &renderer.passes;
        let pipeline = passes.resolve.for_window(&renderer.gpu, &passes.frame, PICTURE_FORMAT)?;
        let painter = Painter::new(&renderer.gpu, configuration.format)?;
        let mut window = WindowSurface { surface, configuration, pipeline, sum: Accumulation::default(), painter };
        renderer.configure(&mut window, size_px)?;
        Ok((renderer, window))
    }

    /// Follows the window to a new size. The next [`GpuRenderer::present`] starts from sample 0.
    pub fn resize(&mut self, window: &mut WindowSurface, size_px: [u32; 2]) {
        window.sum = Accumulation::default();
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
        self.accumulate(&mut window.sum, view, settings, done, add)?;
        self.show(window, &over, done == 0 || add > 0)
    }

    /// Adds samples to a picture as [`GpuRenderer::present`] does, without showing it.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost or refuses.
    pub fn accumulate(
        &mut self,
        sum: &mut Accumulation,
        view: &View,
        settings: &Settings,
        done: u32,
        add: u32,
    ) -> Result<()> {
        let most = self.gpu.limits.max_texture_dimension_2d;
        let region = view.region();
        let size = [region.width.min(most), region.height.min(most)];
        let region = Region { width: size[0], height: size[1], ..region };
        let view = View { region: Some(region), ..*view };
        let text = match sum.text.take().filter(|_| done > 0) {
            Some(text) => text,
            None => self.text(&view, settings.samples > 1)?,
        };
        let frame = self.begin_lit(&view, settings)?;
        let (targets, done) = match sum.targets.take() {
            Some((targets, old)) if old == size => (targets, done),
            // Whatever was summed is gone.
            _ => (Targets::new(&self.gpu, &self.passes, size)?, 0),
        };
        let end = done.saturating_add(add.max(u32::from(done == 0)));
        let draw = self.draw(asks(settings));
        let total = settings.samples.max(end);
        self.gpu.guard("drawing", || {
            let aim = |sample| self.aim((&view, settings), sample, total);
            draw.samples(&targets, region, [done, end], total, aim)?;
            self.aim_back((&view, settings));
            Ok(())
        })?;
        *sum = Accumulation { targets: Some((targets, size)), text: Some(text), done: end, shown: Some((view, frame)) };
        Ok(())
    }

    /// Shows the picture, which may have changed, under the interface, if the window takes it.
    fn show(&self, window: &mut WindowSurface, over: &UserInterface<'_>, is_new: bool) -> Result<()> {
        let size = window.sum.targets.as_ref().map_or([1, 1], |(_, size)| *size);
        self.gpu.guard("finishing the picture", || {
            let (picture, is_blank) = window.painter.picture(&self.gpu, size);
            if is_blank || is_new {
                self.resolve(&window.sum, &window.pipeline, &picture, size);
            }
            Ok(())
        })?;
        let Some(texture) = self.acquire(window)? else { return Ok(()) };
        self.gpu.guard("showing the picture", || {
            let size = window.size_px();
            window.painter.paint(&self.gpu, &view_of(&texture.texture), size, over)?;
            self.gpu.queue.present(texture);
            Ok(())
        })
    }

    /// Draws the mean of an accumulation to a window's pipeline and target.
    fn resolve(
        &self,
        sum: &Accumulation,
        pipeline: &ResolvePipeline,
        target: &wgpu::TextureView,
        [width, height]: [u32; 2],
    ) {
        let (Some((targets, size)), Some(text), Some((view, frame))) = (&sum.targets, &sum.text, &sum.shown) else {
            return;
        };
        let region = Region { width: width.min(size[0]), height: height.min(size[1]), ..view.region() };
        let inputs = [&targets.sum_views[(sum.done % 2) as usize], self.ground.light(frame), text];
        self.draw(false).resolve(pipeline, &inputs, target, region, sum.done);
    }

    /// What a window shows of a picture, opaque.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost or refuses.
    pub fn shown(&self, sum: &Accumulation) -> Result<Image> {
        let [width, height] = sum.targets.as_ref().map_or([1, 1], |(_, size)| *size);
        let region = Region { x: 0, y: 0, width, height };
        let mut rgba = zeroed(region, 4)?;
        let pipeline = self.passes.resolve.for_window(&self.gpu, &self.passes.frame, IMAGE_FORMAT)?;
        self.gpu.guard("showing the picture", || {
            let picture = self.picture(Some(&region));
            self.resolve(sum, &pipeline, &view_of(&picture), [width, height]);
            self.draw(false).read_back(&picture, 4, region, |y, row| put(&mut rgba, 4, region, region, y, row))
        })?;
        Ok(Image { width, height, rgba })
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
