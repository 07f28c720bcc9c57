//! NumPy's array format, version 1.0 (`numpy.lib.format`): magic, version, length of the header, a Python
//! dictionary padded with blanks to a multiple of 64 bytes, then the values in C order, little-endian. Shapes and types are
//! listed in [`super::picture`].

use super::picture::{Content, Layer};
use std::io::{self, Write};

/// Writes what comes before the values of an array of so many rows and columns.
pub(super) fn begin((width, height): (u32, u32), layer: Layer, out: &mut dyn Write) -> io::Result<()> {
    let (kind, last) = match layer {
        Layer::Color => ("|u1", ", 4"),
        Layer::Depth { .. } | Layer::Ao => ("<f4", ""),
        Layer::Normal => ("<f4", ", 3"),
        Layer::Id => ("<u4", ""),
    };
    write_header(kind, &format!("({height}, {width}{last})"), out)
}

/// Writes the values of the next rows.
pub(super) fn strip(content: Content<'_>, out: &mut dyn Write) -> io::Result<()> {
    match content {
        Content::Color(image) => out.write_all(&image.rgba),
        Content::Depth(buffer) => write_words(buffer.depth.iter().map(|x| x.to_le_bytes()), out),
        Content::Normal(buffer) => write_words(buffer.normal.iter().flatten().map(|x| x.to_le_bytes()), out),
        Content::Ao(sky) => write_words(sky.open.iter().map(|x| x.to_le_bytes()), out),
        Content::Id(buffer) => write_words(buffer.id.iter().map(|x| x.to_le_bytes()), out),
    }
}

fn write_header(kind: &str, shape: &str, out: &mut dyn Write) -> io::Result<()> {
    let dictionary = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let before = 10; // magic, version, length
    let total = (before + dictionary.len() + 1).next_multiple_of(64);
    let length = u16::try_from(total - before).map_err(io::Error::other)?;
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&length.to_le_bytes())?;
    writeln!(out, "{dictionary:<width$}", width = usize::from(length) - 1)
}

fn write_words(words: impl Iterator<Item = [u8; 4]>, out: &mut dyn Write) -> io::Result<()> {
    let mut buffer = Vec::with_capacity(1 << 16);
    for word in words {
        buffer.extend_from_slice(&word);
        if buffer.len() == 1 << 16 {
            out.write_all(&buffer)?;
            buffer.clear();
        }
    }
    out.write_all(&buffer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::image::{GBuffer, Image, SkyVisibility};

    fn array(content: Content<'_>) -> (String, Vec<u8>) {
        let mut bytes = Vec::new();
        begin(content.size(), content.layer(), &mut bytes).unwrap();
        strip(content, &mut bytes).unwrap();
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        assert_eq!(bytes[9 + length], b'\n');
        let header = String::from_utf8(bytes[10..10 + length].to_vec()).unwrap();
        (header.trim_end().to_owned(), bytes[10 + length..].to_vec())
    }

    #[test]
    fn types_and_shapes_are_rows_then_columns() {
        let buffer = GBuffer {
            width: 2,
            height: 1,
            id: vec![0x0102_0304, u32::MAX],
            depth: vec![1.5, f32::INFINITY],
            normal: vec![[1.0, 0.0, -1.0], [0.0; 3]],
        };
        let (header, data) = array(Content::Id(&buffer));
        assert_eq!(header, "{'descr': '<u4', 'fortran_order': False, 'shape': (1, 2), }");
        assert_eq!(data, [4, 3, 2, 1, 255, 255, 255, 255]);
        let (header, data) = array(Content::Depth(&buffer));
        assert!(header.contains("'<f4'") && header.contains("(1, 2)"));
        assert_eq!(data, [1.5f32.to_le_bytes(), f32::INFINITY.to_le_bytes()].concat());
        let (header, data) = array(Content::Normal(&buffer));
        assert!(header.contains("(1, 2, 3)"));
        assert_eq!((data.len(), &data[8..12]), (24, &(-1.0f32).to_le_bytes()[..]));
        let (header, data) = array(Content::Ao(&SkyVisibility { width: 1, height: 2, open: vec![0.25, 1.0] }));
        assert!(header.contains("'<f4'") && header.contains("(2, 1)"));
        assert_eq!(data, [0.25f32.to_le_bytes(), 1.0f32.to_le_bytes()].concat());
        let image = Image { width: 1, height: 2, rgba: (0..8).collect() };
        let (header, data) = array(Content::Color(&image));
        assert!(header.contains("'|u1'") && header.contains("(2, 1, 4)"));
        assert_eq!(data, image.rgba);
    }
}
