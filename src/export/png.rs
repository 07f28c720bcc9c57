//! PNG: pictures with 8 bits a channel, depth, normals and ids with 16 (described in [`super::picture`]).

use super::picture::{Content, PictureOptions, opaque_rgb};
use ::png::{BitDepth, ColorType, Compression, Encoder, EncodingError, SrgbRenderingIntent};
use std::borrow::Cow;
use std::io::{self, Write};

pub(super) fn write(content: Content<'_>, options: &PictureOptions, out: &mut dyn Write) -> io::Result<()> {
    let mut texts = options.texts.clone();
    let (color, depth, data) = match content {
        Content::Color(image) => match opaque_rgb(image) {
            Some(rgb) => (ColorType::Rgb, BitDepth::Eight, Cow::from(rgb)),
            None => (ColorType::Rgba, BitDepth::Eight, Cow::from(&image.rgba)),
        },
        Content::Depth(buffer) => {
            let (near, far) = depth_range(&buffer.depth);
            texts.push(("near_angstrom".to_owned(), near.to_string()));
            texts.push(("far_angstrom".to_owned(), far.to_string()));
            let values = buffer.depth.iter().flat_map(|&depth| depth_value(depth, near, far).to_be_bytes());
            (ColorType::Grayscale, BitDepth::Sixteen, values.collect::<Vec<u8>>().into())
        }
        Content::Normal(buffer) => {
            let values = buffer.normal.iter().flat_map(|&normal| normal_value(normal)).flat_map(u16::to_be_bytes);
            (ColorType::Rgb, BitDepth::Sixteen, values.collect::<Vec<u8>>().into())
        }
        Content::Id(buffer) => {
            let values = buffer.id.iter().flat_map(|&id| [(id >> 16) as u16, id as u16, 0]).flat_map(u16::to_be_bytes);
            (ColorType::Rgb, BitDepth::Sixteen, values.collect::<Vec<u8>>().into())
        }
    };
    let (width, height) = content.size();
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(Compression::Fast);
    if matches!(content, Content::Color(_)) {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    }
    for (keyword, text) in texts {
        // tEXt holds Latin-1, which only ASCII is the same in; the rest goes into iTXt, which holds UTF-8.
        if text.is_ascii() {
            encoder.add_text_chunk(keyword, text).map_err(io_error)?;
        } else {
            encoder.add_itxt_chunk(keyword, text).map_err(io_error)?;
        }
    }
    let mut writer = encoder.write_header().map_err(io_error)?;
    writer.write_image_data(&data).map_err(io_error)?;
    writer.finish().map_err(io_error)
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// The smallest and largest depth that is not the background's; 0 and 0 if there is none.
fn depth_range(depths: &[f32]) -> (f32, f32) {
    let finite = depths.iter().copied().filter(|depth| depth.is_finite());
    finite
        .fold(None, |range: Option<(f32, f32)>, depth| {
            Some(range.map_or((depth, depth), |(near, far)| (near.min(depth), far.max(depth))))
        })
        .unwrap_or((0.0, 0.0))
}

fn depth_value(depth: f32, near: f32, far: f32) -> u16 {
    if !depth.is_finite() {
        return 0;
    }
    let (depth, near, far) = (f64::from(depth), f64::from(near), f64::from(far));
    let nearness = if far > near { (far - depth) / (far - near) } else { 1.0 };
    1 + (nearness * 65534.0).round() as u16
}

fn normal_value(normal: [f32; 3]) -> [u16; 3] {
    if normal == [0.0; 3] {
        return [0; 3];
    }
    normal.map(|x| ((x * 0.5 + 0.5) * 65535.0).round() as u16) // `as` clamps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::image::{GBuffer, Image};

    fn decode(content: Content<'_>, options: &PictureOptions) -> (::png::Info<'static>, Vec<u8>) {
        let mut file = Vec::new();
        write(content, options, &mut file).unwrap();
        let mut reader = ::png::Decoder::new(io::Cursor::new(file)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        (reader.info().clone(), data)
    }

    fn words(bytes: &[u8]) -> Vec<u16> {
        bytes.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()
    }

    fn buffer() -> GBuffer {
        GBuffer {
            width: 3,
            height: 1,
            id: vec![0, 70_000, GBuffer::GROUND],
            depth: vec![f32::INFINITY, 10.0, 20.0],
            normal: vec![[0.0; 3], [0.0, 0.0, 1.0], [-1.0, 1.0, 0.0]],
        }
    }

    #[test]
    fn opaque_pictures_are_rgb_and_see_through_ones_rgba_pixel_for_pixel() {
        let opaque = Image { width: 1, height: 2, rgba: vec![1, 2, 3, 255, 4, 5, 6, 255] };
        let (info, data) = decode(Content::Color(&opaque), &PictureOptions::default());
        assert_eq!((info.color_type, data), (ColorType::Rgb, vec![1, 2, 3, 4, 5, 6]));
        assert_eq!(info.srgb, Some(SrgbRenderingIntent::Perceptual));
        let clear = Image { width: 1, height: 2, rgba: vec![1, 2, 3, 0, 4, 5, 6, 255] };
        let (info, data) = decode(Content::Color(&clear), &PictureOptions::default());
        assert_eq!((info.color_type, data), (ColorType::Rgba, clear.rgba));
    }

    #[test]
    fn texts_come_back_in_any_script() {
        let texts = vec![("Software".into(), "ballstick".into()), ("Title".into(), "Koffein 咖啡因".into())];
        let options = PictureOptions { texts, ..PictureOptions::default() };
        let image = Image { width: 1, height: 1, rgba: vec![0; 4] };
        let (info, _) = decode(Content::Color(&image), &options);
        assert_eq!(info.uncompressed_latin1_text[0].text, "ballstick");
        assert_eq!(info.utf8_text[0].get_text().unwrap(), "Koffein 咖啡因");
    }

    #[test]
    fn depth_runs_from_near_65535_to_far_1_and_the_background_is_0() {
        let (info, data) = decode(Content::Depth(&buffer()), &PictureOptions::default());
        assert_eq!((info.color_type, info.bit_depth), (ColorType::Grayscale, BitDepth::Sixteen));
        assert_eq!(words(&data), [0, 65535, 1]);
        let texts: Vec<_> =
            info.uncompressed_latin1_text.iter().map(|t| (t.keyword.as_str(), t.text.as_str())).collect();
        assert_eq!(texts, [("near_angstrom", "10"), ("far_angstrom", "20")]);
        assert_eq!(depth_value(15.0, 10.0, 20.0), 32768);
        assert_eq!(depth_value(5.0, 5.0, 5.0), 65535);
        assert_eq!(depth_range(&[f32::INFINITY]), (0.0, 0.0));
    }

    #[test]
    fn normals_are_half_n_plus_half_and_ids_are_split_into_two_words() {
        let (_, data) = decode(Content::Normal(&buffer()), &PictureOptions::default());
        assert_eq!(words(&data), [0, 0, 0, 32768, 32768, 65535, 0, 65535, 32768]);
        let (_, data) = decode(Content::Id(&buffer()), &PictureOptions::default());
        assert_eq!(words(&data), [0, 0, 0, 1, 4464, 0, 65535, 65535, 0]);
    }
}
