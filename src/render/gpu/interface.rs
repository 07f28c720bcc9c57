//! The user interface over the picture in a window: egui's own painter on the device that draws the molecule. The picture is a texture
//! among the others, laid down first.

use super::device::{Gpu, view_of};
use crate::error::{Error, Result};
use egui::epaint::{ClippedPrimitive, Mesh, Primitive};
use egui::{Color32, Rect, TextureId, TexturesDelta, pos2, vec2};
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};

/// What egui wants to be seen.
pub struct UserInterface<'a> {
    /// New and changed textures.
    pub textures: TexturesDelta,
    /// What is painted, in order.
    pub primitives: &'a [ClippedPrimitive],
    /// Pixels a point.
    pub pixels_per_point: f32,
    /// The upper left corner of the picture in the window, in pixels.
    pub place: [u32; 2],
}

/// The format in which the picture is kept for the interface: sRGB as it is written, which egui blends in.
pub(super) const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Paints pictures and the interface to a window.
pub(super) struct Painter {
    egui: Renderer,
    picture: Option<Picture>,
}

struct Picture {
    view: wgpu::TextureView,
    size: [u32; 2],
    id: TextureId,
}

impl std::fmt::Debug for Painter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Painter")
            .field("size", &self.picture.as_ref().map(|picture| picture.size))
            .finish_non_exhaustive()
    }
}

impl Painter {
    /// For a surface of this format.
    pub(super) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Result<Painter> {
        gpu.guard("building the interface's pipeline", || {
            let egui =
                Renderer::new(&gpu.device, format, RendererOptions { dithering: false, ..RendererOptions::default() });
            Ok(Painter { egui, picture: None })
        })
    }

    /// The texture that the picture is drawn into, of this size; whether it is a new one.
    pub(super) fn picture(&mut self, gpu: &Gpu, size: [u32; 2]) -> (wgpu::TextureView, bool) {
        if let Some(picture) = self.picture.as_ref().filter(|picture| picture.size == size) {
            return (picture.view.clone(), false);
        }
        if let Some(old) = self.picture.take() {
            self.egui.free_texture(&old.id);
        }
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let view = view_of(&gpu.texture("picture in the window", size, PICTURE_FORMAT, usage));
        let id = self.egui.register_native_texture(&gpu.device, &view, wgpu::FilterMode::Nearest);
        self.picture = Some(Picture { view: view.clone(), size, id });
        (view, true)
    }

    /// Takes new textures over; needed even where nothing is shown.
    pub(super) fn update(&mut self, gpu: &Gpu, textures: &mut TexturesDelta) {
        for (id, changes) in textures.set.drain() {
            for change in &changes {
                self.egui.update_texture(&gpu.device, &gpu.queue, id, change);
            }
        }
        for id in textures.free.drain() {
            self.egui.free_texture(&id);
        }
    }

    /// Paints the picture and the interface over it to a texture of the window.
    pub(super) fn paint(
        &mut self,
        gpu: &Gpu,
        target: &wgpu::TextureView,
        size: [u32; 2],
        over: &UserInterface<'_>,
    ) -> Result<()> {
        let screen = ScreenDescriptor { size_in_pixels: size, pixels_per_point: over.pixels_per_point };
        if !(screen.pixels_per_point > 0.0 && screen.pixels_per_point.is_finite()) {
            return Err(Error::Gpu("the interface has no scale".to_owned()));
        }
        let mut primitives = Vec::with_capacity(over.primitives.len() + 1);
        if let Some(picture) = &self.picture {
            let points = |px: u32| px as f32 / over.pixels_per_point;
            let corner = pos2(points(over.place[0]), points(over.place[1]));
            let rect = Rect::from_min_size(corner, vec2(points(picture.size[0]), points(picture.size[1])));
            let mut mesh = Mesh::with_texture(picture.id);
            mesh.add_rect_with_uv(rect, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
            primitives.push(ClippedPrimitive { clip_rect: rect, primitive: Primitive::Mesh(mesh) });
        }
        primitives.extend(over.primitives.iter().cloned());
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("interface") });
        let first = self.egui.update_buffers(&gpu.device, &gpu.queue, &mut encoder, &primitives, &screen);
        {
            let attachment = wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::WHITE), store: wgpu::StoreOp::Store },
            };
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("interface"),
                color_attachments: &[Some(attachment)],
                ..wgpu::RenderPassDescriptor::default()
            });
            self.egui.render(&mut pass.forget_lifetime(), &primitives, &screen);
        }
        gpu.queue.submit(first.into_iter().chain([encoder.finish()]));
        Ok(())
    }
}
