//! Wavefront materials: of each the diffuse colour (`Kd`), its picture (`map_Kd`) and the opacity (`d`, or `Tr`, what it lacks to 1). Everything
//! else (highlights, other pictures, the options of `map_Kd`) is passed over.
//!
//! The format does not say in which colour space its numbers are; as in the programs that write and show it they are taken as sRGB.

use super::super::number::next_f64;
use super::super::text::{Lines, next_word};
use crate::color::Srgb8;
use std::collections::HashMap;

/// A material.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Material {
    /// [`super::UNCOLORED`] without `Kd`, but white under a picture.
    pub(super) color: Srgb8,
    has_color: bool,
    /// The name of its picture.
    pub(super) map: Option<String>,
}

/// Materials by name.
pub(super) fn read(text: &[u8], line_bytes: usize, materials: &mut HashMap<Vec<u8>, Material>) {
    let mut current = None;
    for line in Lines::new(text, line_bytes) {
        let Some((word, rest)) = next_word(line) else { continue };
        if word == b"newmtl" {
            current = Some(rest.trim_ascii().to_vec());
        }
        let Some(name) = &current else { continue };
        let material =
            materials.entry(name.clone()).or_insert(Material { color: super::UNCOLORED, has_color: false, map: None });
        let color = &mut material.color;
        match word {
            b"Kd" => {
                if let Some([r, g, b]) = color_of(rest) {
                    *color = Srgb8 { r, g, b, a: color.a };
                    material.has_color = true;
                }
            }
            b"map_Kd" => {
                material.map = map_name(rest);
                if !material.has_color && material.map.is_some() {
                    *color = Srgb8 { a: color.a, ..Srgb8::WHITE };
                }
            }
            b"d" => {
                // `d -halo 0.5`: thinner where it is seen at a slant; not told apart.
                let rest = rest.trim_ascii().strip_prefix(b"-halo").unwrap_or(rest);
                color.a = byte(rest).map_or(color.a, |(opacity, _)| opacity);
            }
            b"Tr" => color.a = byte(rest).map_or(color.a, |(clear, _)| 255 - clear),
            _ => {}
        }
    }
}

/// The name behind the options of a map: `-s 1 1 1 -clamp on name.png`. Names may have blanks.
fn map_name(rest: &[u8]) -> Option<String> {
    let mut rest = rest.trim_ascii();
    while rest.starts_with(b"-") {
        let (option, mut left) = next_word(rest)?;
        let most = if matches!(option, b"-o" | b"-s" | b"-t") {
            3
        } else if option == b"-mm" {
            2
        } else {
            1
        };
        for count in 0..most {
            let Some((word, after)) = next_word(left) else { break };
            // Of three numbers two may be left out.
            if count > 0 && next_f64(word).is_none_or(|(_, _, more)| !more.is_empty()) {
                break;
            }
            left = after;
        }
        rest = left.trim_ascii();
    }
    (!rest.is_empty()).then(|| String::from_utf8_lossy(rest).into_owned())
}

/// Three numbers, or one for all three.
fn color_of(rest: &[u8]) -> Option<[u8; 3]> {
    let (r, rest) = byte(rest)?;
    let Some((g, rest)) = byte(rest) else { return Some([r; 3]) };
    Some([r, g, byte(rest)?.0])
}

/// The next number, 0 to 1, as a byte.
fn byte(text: &[u8]) -> Option<(u8, &[u8])> {
    let (value, _, rest) = next_f64(text)?;
    value.is_finite().then(|| ((value.clamp(0.0, 1.0) * 255.0).round() as u8, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_opacities_of_materials() {
        let text = b"# no material yet\nKd 1 1 1\nnewmtl red glass\nKs 1 1 1\nKd 1 0 0.2\nd 0.5\n\nnewmtl clear\nTr 0.25\nKd 0.4\n\
                     newmtl bad\nKd spectral file.rfl\nd nan\nnewmtl halo\nd -halo 0.2\n";
        let mut materials = HashMap::new();
        read(text, 1000, &mut materials);
        let of = |name: &[u8]| materials.get(name).map(|material| material.color);
        assert_eq!(of(b"red glass"), Some(Srgb8 { r: 255, g: 0, b: 51, a: 128 }));
        assert_eq!(of(b"clear"), Some(Srgb8 { r: 102, g: 102, b: 102, a: 191 }));
        assert_eq!(of(b"bad"), Some(super::super::UNCOLORED));
        assert_eq!(of(b"halo").map(|color| color.a), Some(51));
        assert_eq!(materials.len(), 4);
    }

    #[test]
    fn pictures_of_materials_stand_behind_their_options() {
        for (line, name) in [
            ("map_Kd wood.png", Some("wood.png")),
            ("map_Kd -s 2 2 1 -clamp on my wood.png", Some("my wood.png")),
            ("map_Kd -o 0.5 wood.png", Some("wood.png")),
            ("map_Kd -mm 0 1 -blendu off wood.png", Some("wood.png")),
            ("map_Kd -clamp", None),
            ("map_Kd", None),
        ] {
            let mut materials = HashMap::new();
            read(format!("newmtl a\n{line}\nd 0.5\n").as_bytes(), 1000, &mut materials);
            let material = &materials[&b"a"[..]];
            assert_eq!(material.map.as_deref(), name, "{line}");
            let color = if name.is_some() { Srgb8::WHITE } else { super::super::UNCOLORED };
            assert_eq!(material.color, Srgb8 { a: 128, ..color });
        }
    }
}
