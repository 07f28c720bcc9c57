//! What a renderer hands back: a finished picture, or the visible surface behind it.

/// A picture: sRGB, 8 bits a channel, straight alpha, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels of red, green, blue, alpha.
    pub rgba: Vec<u8>,
}

/// The visible surface at the pixel centres, rows from the top. What is see-through is part of it from an opacity of a half on.
#[derive(Debug, Clone, PartialEq)]
pub struct GBuffer {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// What is seen: [`GBuffer::BACKGROUND`], [`GBuffer::GROUND`], or the id of an atom (1 + index) or bond
    /// (1 + number of atoms + index).
    pub id: Vec<u32>,
    /// Distance from the camera's plane along its view direction in ångström; infinity for the background.
    pub depth: Vec<f32>,
    /// Unit normal in view space (x right, y up, z to the viewer); zero for the background.
    pub normal: Vec<[f32; 3]>,
}

/// The part of the sky that the visible surface at each pixel centre sees, rows from the top: ambient occlusion as
/// [`super::sky`] defines it, over all of its directions and as it is, before a look makes light of it.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyVisibility {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// 0 (nothing) to 1 (all); 1 where there is no primitive, where the near plane cuts one, and where all directions are behind
    /// the surface.
    pub open: Vec<f32>,
}

impl GBuffer {
    /// Id where nothing is seen.
    pub const BACKGROUND: u32 = 0;
    /// Id of the ground plane.
    pub const GROUND: u32 = u32::MAX;

    /// An empty one, to be filled pixel by pixel.
    #[must_use]
    pub(super) fn with_capacity(width: u32, height: u32) -> GBuffer {
        let pixels = width as usize * height as usize;
        let (id, depth, normal) = (Vec::with_capacity(pixels), Vec::with_capacity(pixels), Vec::with_capacity(pixels));
        GBuffer { width, height, id, depth, normal }
    }

    /// Adds the next pixel.
    pub(super) fn push(&mut self, (id, depth, normal): (u32, f32, [f32; 3])) {
        self.id.push(id);
        self.depth.push(depth);
        self.normal.push(normal);
    }
}
