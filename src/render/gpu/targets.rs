//! What a part of the picture is drawn into, and the tiles that pictures are cut into.

use super::device::{Gpu, view_of};
use super::layout::{DEPTH_FORMAT, SUM_FORMAT, SURFACE_FORMAT};
use super::passes::Passes;
use super::passes::pyramid::PyramidOf;
use crate::error::Result;
use crate::scene::Region;

/// Pixels of a tile at most: the targets take 52 bytes a pixel, and 8 more where the device computes, so 126 MB.
const TILE_PIXELS: u32 = 1 << 21;

/// Textures for one sample and the sum of samples.
#[derive(Debug)]
pub(super) struct Targets {
    size: [u32; 2],
    /// Id, depth, normal and colour of one sample.
    pub(super) surface: wgpu::Texture,
    pub(super) surface_view: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
    /// Over the depth, where the device computes.
    pub(super) pyramid: Option<PyramidOf>,
    /// The sum of `n` samples is in `sums[n % 2]`.
    pub(super) sums: [wgpu::Texture; 2],
    pub(super) sum_views: [wgpu::TextureView; 2],
    /// Surfaces and `sums[i]`, for the shade pass that writes the other.
    pub(super) shade_groups: [wgpu::BindGroup; 2],
}

impl Targets {
    pub(super) fn new(gpu: &Gpu, passes: &Passes, size: [u32; 2]) -> Result<Targets> {
        gpu.guard("making the picture's targets", || {
            let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
            let read = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
            let surface = gpu.texture("surfaces", size, SURFACE_FORMAT, drawn | read);
            let surface_view = view_of(&surface);
            let asked = passes.pyramid.as_ref().map_or(drawn, |_| drawn | wgpu::TextureUsages::TEXTURE_BINDING);
            let depth = view_of(&gpu.texture("depth", size, DEPTH_FORMAT, asked));
            let pyramid = passes.pyramid.as_ref().map(|pyramid| pyramid.over(gpu, &depth, size));
            let sums = ["even sum", "odd sum"].map(|label| gpu.texture(label, size, SUM_FORMAT, drawn | read));
            let sum_views = sums.each_ref().map(view_of);
            let shade_groups = sum_views.each_ref().map(|sum| passes.shade.inputs(gpu, &surface_view, sum));
            Ok(Targets { size, surface, surface_view, depth, pyramid, sums, sum_views, shade_groups })
        })
    }

    /// Whether a part of this size can be drawn here without wasting more than it uses.
    pub(super) fn suits(&self, [width, height]: [u32; 2]) -> bool {
        let area = |w: u32, h: u32| u64::from(w) * u64::from(h);
        width <= self.size[0]
            && height <= self.size[1]
            && area(self.size[0], self.size[1]) <= 2 * area(width, height).max(1 << 16)
    }
}

/// The tiles of a region, row by row: as few as the device's textures and memory in proportion allow.
pub(super) fn tiles(region: Region, max_side: u32) -> Vec<Region> {
    let width = region.width.min(max_side).clamp(1, TILE_PIXELS);
    let height = region.height.min(max_side).min((TILE_PIXELS / width).max(1)).max(1);
    let mut tiles = Vec::new();
    for y in (0..region.height).step_by(height as usize) {
        for x in (0..region.width).step_by(width as usize) {
            tiles.push(Region {
                x: region.x + x,
                y: region.y + y,
                width: width.min(region.width - x),
                height: height.min(region.height - y),
            });
        }
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_region_once_within_the_limits() {
        for (width, height, side) in
            [(1, 1, 2048), (1920, 1080, 2048), (5000, 3000, 2048), (70, 33, 16), (30000, 7, 8192)]
        {
            let region = Region { x: 5, y: 9, width, height };
            let tiles = tiles(region, side);
            let area: u64 = tiles.iter().map(|t| u64::from(t.width) * u64::from(t.height)).sum();
            assert_eq!(area, u64::from(width) * u64::from(height));
            for t in &tiles {
                assert!(t.width <= side && t.height <= side && t.width * t.height <= TILE_PIXELS);
                assert!(t.x >= 5 && t.y >= 9 && t.x + t.width <= 5 + width && t.y + t.height <= 9 + height);
            }
        }
        assert_eq!(tiles(Region { x: 0, y: 0, width: 1920, height: 1080 }, 2048).len(), 1);
    }
}
