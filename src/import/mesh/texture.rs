//! Pictures on meshes: the base colour of glTF materials and `map_Kd` of MTL, PNG or JPEG. A mesh has colours at its vertices and nowhere else, so that a
//! picture is read there: between vertices it is lost.
//!
//! Method: bilinear between the four nearest pixels in linear light, as glTF's sampler "linear"; beyond the picture repeated, mirrored or clamped.
//! Limits: 16,384 pixels a side, and [`MOST_BYTES`] for all pictures of a mesh unpacked; what is larger, or is no such picture, leaves
//! the material's own colour, and that is said.

use crate::color::linear_from_srgb;
use std::sync::LazyLock;

/// Bytes that all pictures of a mesh may take, unpacked (chosen: four of 8,192 × 8,192).
pub(super) const MOST_BYTES: u64 = 1 << 30;
/// Most pixels a side.
const MOST_SIDE: u32 = 16_384;

/// What lies beyond the edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

/// A picture.
#[derive(Debug)]
pub(super) struct Texture {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0)));

impl Texture {
    /// Unpacks a picture; `left` is what all may still take, and gets less.
    pub(super) fn decode(bytes: &[u8], left: &mut u64) -> Result<Texture, String> {
        use image::ImageFormat;
        let format = image::guess_format(bytes).ok();
        let Some(format @ (ImageFormat::Png | ImageFormat::Jpeg)) = format else {
            return Err("it is neither PNG nor JPEG".to_owned());
        };
        let mut reader = image::ImageReader::with_format(std::io::Cursor::new(bytes), format);
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MOST_SIDE);
        limits.max_image_height = Some(MOST_SIDE);
        // The picture as it is packed, and as 8 bits a channel.
        limits.max_alloc = Some(*left * 2);
        reader.limits(limits);
        let picture = reader.decode().map_err(|error| error.to_string())?;
        let rgba = picture.into_rgba8();
        let (width, height) = rgba.dimensions();
        let size = u64::from(width) * u64::from(height) * 4;
        if width == 0 || height == 0 {
            return Err("it has no pixels".to_owned());
        }
        *left = left.checked_sub(size).ok_or_else(|| format!("all pictures take more than {MOST_BYTES} bytes"))?;
        Ok(Texture { width, height, rgba: rgba.into_raw() })
    }

    /// Linear red, green and blue, and the opacity, at a place: 0 to 1 from left to right and from top to bottom.
    pub(super) fn sample(&self, [u, v]: [f32; 2], [wrap_u, wrap_v]: [Wrap; 2]) -> [f32; 4] {
        let axis = |at: f32, wrap: Wrap, size: u32| {
            let at = if at.is_finite() { at } else { 0.0 };
            // A place by its fraction first, so that large numbers keep their digits.
            let at = match wrap {
                Wrap::Repeat => at.rem_euclid(1.0),
                Wrap::Mirror => 1.0 - (at.rem_euclid(2.0) - 1.0).abs(),
                Wrap::Clamp => at.clamp(0.0, 1.0),
            };
            let pixel = at * size as f32 - 0.5;
            let first = pixel.floor();
            let last = size - 1;
            let next = |index: f32| match wrap {
                Wrap::Repeat if index < 0.0 => last,
                Wrap::Repeat if index > last as f32 => 0,
                _ => (index.max(0.0) as u32).min(last),
            };
            ([next(first), next(first + 1.0)], pixel - first)
        };
        let ([left, right], across) = axis(u, wrap_u, self.width);
        let ([top, bottom], down) = axis(v, wrap_v, self.height);
        let mut sum = [0.0; 4];
        for (x, y, weight) in [
            (left, top, (1.0 - across) * (1.0 - down)),
            (right, top, across * (1.0 - down)),
            (left, bottom, (1.0 - across) * down),
            (right, bottom, across * down),
        ] {
            let pixel = (y as usize * self.width as usize + x as usize) * 4;
            let bytes = self.rgba.get(pixel..pixel + 4).unwrap_or(&[255; 4]);
            for (channel, (sum, &byte)) in sum.iter_mut().zip(bytes).enumerate() {
                let value = if channel < 3 { LINEAR[usize::from(byte)] } else { f32::from(byte) / 255.0 };
                *sum += weight * value;
            }
        }
        sum
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A PNG of 2 × 2 pixels: red, green over blue, white at half opacity.
    pub(in crate::import::mesh) fn four_colors() -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
        encoder.set_color(png::ColorType::Rgba);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&[255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128]).unwrap();
        writer.finish().unwrap();
        bytes
    }

    #[test]
    fn pixels_are_where_they_should_be_and_go_on_beyond_the_edges() {
        let texture = Texture::decode(&four_colors(), &mut 1000).unwrap();
        let at = |u, v, wrap| texture.sample([u, v], [wrap; 2]);
        assert_eq!(at(0.25, 0.25, Wrap::Clamp), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(at(0.75, 0.25, Wrap::Repeat), [0.0, 1.0, 0.0, 1.0]);
        assert_eq!(at(-0.75, 1.75, Wrap::Repeat), [0.0, 0.0, 1.0, 1.0]);
        assert_eq!(at(0.5, 0.25, Wrap::Clamp), [0.5, 0.5, 0.0, 1.0]);
        assert_eq!(at(0.0, 0.25, Wrap::Repeat), [0.5, 0.5, 0.0, 1.0], "the right edge is beside the left one");
        assert_eq!(at(1.25, 0.25, Wrap::Mirror), [0.0, 1.0, 0.0, 1.0]);
        assert_eq!(at(9.0, -9.0, Wrap::Clamp), [0.0, 1.0, 0.0, 1.0]);
        assert!((at(0.75, 0.75, Wrap::Clamp)[3] - 128.0 / 255.0).abs() < 1e-6);
        for odd in [f32::NAN, f32::INFINITY, 1e30, -1e30] {
            for wrap in [Wrap::Clamp, Wrap::Repeat, Wrap::Mirror] {
                assert!(at(odd, odd, wrap).iter().all(|x| (0.0..=1.0).contains(x)));
            }
        }
    }

    #[test]
    fn what_is_no_picture_or_too_large_is_refused() {
        assert!(Texture::decode(b"GIF89a", &mut 1000).is_err());
        assert!(Texture::decode(&four_colors()[..40], &mut 1000).is_err());
        assert!(Texture::decode(&four_colors(), &mut 15).is_err());
        let mut left = 16;
        assert!(Texture::decode(&four_colors(), &mut left).is_ok() && left == 0);
    }
}
