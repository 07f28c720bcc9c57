//! From texels of the surface target to a [`GBuffer`], the ground added.

use super::layout::unpack_normal;
use crate::render::frame::{FrameConstants, ground_t};
use crate::render::{GBuffer, View};
use glam::Vec3;

/// Unpacks the texels of a view's region, read back as they are.
pub(super) fn unpack(frame: &FrameConstants, view: &View, texels: &[u8]) -> GBuffer {
    let region = view.region();
    let grid = view.pixel_grid();
    let world_from_view = frame.world_from_view();
    let up = Vec3::new(frame.up[0], frame.up[1], frame.up[2]).to_array();
    let mut buffer = GBuffer::with_capacity(region.width, region.height);
    for (i, bytes) in texels.chunks_exact(16).enumerate() {
        let [id, depth, normal, color]: [u32; 4] = bytemuck::pod_read_unaligned(bytes);
        let (x, y) = (i as u32 % region.width + region.x, i as u32 / region.width + region.y);
        let ray = grid.ray(grid.plane(x as f32 + 0.5, y as f32 + 0.5));
        let origin = world_from_view.transform_point3(ray.origin);
        let ground = ground_t(frame, origin, world_from_view.transform_vector3(ray.direction));
        let depth = f32::from_bits(depth);
        buffer.push(if color != 0 && depth <= ground {
            (id, depth, unpack_normal(normal).to_array())
        } else if ground.is_finite() {
            (GBuffer::GROUND, ground, up)
        } else {
            (GBuffer::BACKGROUND, f32::INFINITY, [0.0; 3])
        });
    }
    buffer
}
