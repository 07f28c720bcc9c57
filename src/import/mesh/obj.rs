//! Wavefront OBJ: `v` (with colour, where six numbers are given), `vn`, `vt`, `f`, `usemtl`, `mtllib`. Faces of more than three corners
//! are fans. Pictures of materials are read at the vertices. `#` begins a comment, `\` at the end of a line goes on with the next one.
//!
//! Why no crate reads it: the usual one names no lines in its errors, stops at `Kd 0.5` with a panic, refuses the whole file for one
//! bad line, and mixes up colours and normals where only some vertices have them.
//! Limits: curves, free-form surfaces, lines and points are passed over.

use super::super::number::{next_f64, next_vector, parse_i64};
use super::super::text::{Lines, Repeated, next_word, normalise, shown, words};
use super::texture::{Texture, Wrap};
use super::{Reading, UNCOLORED, is_plausible, mtl};
use crate::color::Srgb8;
use crate::error::Result;
use glam::Vec3;
use std::collections::HashMap;

/// Bytes in which a line that only OBJ files have is looked for (chosen: more than any header of comments).
const LOOKED_AT: usize = 1 << 16;

/// Whether it reads like one: the first line that says anything is a vertex, a group, an object or a material.
pub(super) fn is_obj(text: &[u8]) -> bool {
    let text = &text[..text.len().min(LOOKED_AT)];
    let said = text.split(|&byte| byte == b'\n').map(|line| words(line).collect::<Vec<_>>());
    let first = said.into_iter().find(|words| words.first().is_some_and(|word| !word.starts_with(b"#")));
    first.is_some_and(|words| match (words[0], words.len()) {
        (b"mtllib" | b"usemtl", 2..) | (b"o" | b"g" | b"s", _) => true,
        (b"v" | b"vn", 4..) | (b"vt", 2..) => next_f64(words[1]).is_some(),
        _ => false,
    })
}

/// A corner of a face: vertex, normal and place in the picture (`u32::MAX` for none), and material.
type Corner = (u32, u32, u32, u32);

/// What a material does: its colour, and the number of its picture.
type Paint = (Srgb8, Option<usize>);

/// What has been read so far.
#[derive(Default)]
struct Lists {
    positions: Vec<Vec3>,
    /// Colours of the vertices from the first one on that has any.
    colors: Vec<Option<Srgb8>>,
    normals: Vec<Vec3>,
    /// Places in pictures, from their lower left corner.
    places: Vec<[f32; 2]>,
    /// Vertices of the mesh that stand for corners. A vertex of two materials or normals is two of these.
    corners: HashMap<Corner, u32>,
    materials: HashMap<Vec<u8>, mtl::Material>,
    /// Pictures that materials in use have, and their numbers by name; `None` for what could not be read.
    pictures: Vec<Texture>,
    picture_of: HashMap<String, Option<usize>>,
    /// What was in use, each once, and which of it is now.
    in_use: Vec<Option<Paint>>,
    number_of: HashMap<Option<Paint>, u32>,
    current: u32,
    bad_vertex: Repeated,
    bad_face: Repeated,
    no_material: Repeated,
}

pub(super) fn read(text: &[u8], reading: &mut Reading<'_>) -> Result<()> {
    let mut lists = Lists { in_use: vec![None], number_of: HashMap::from([(None, 0)]), ..Lists::default() };
    let mut lines = Lines::new(text, reading.limits.line_bytes);
    let mut joined = Vec::new();
    let mut face = Vec::new();
    while let Some(line) = lines.next() {
        let number = lines.number();
        let line = match line.strip_suffix(b"\\") {
            None => line,
            Some(start) => {
                joined.clear();
                joined.extend_from_slice(start);
                for more in lines.by_ref() {
                    let (part, goes_on) = more.strip_suffix(b"\\").map_or((more, false), |part| (part, true));
                    joined.push(b' ');
                    joined.extend_from_slice(part);
                    if !goes_on || joined.len() > reading.limits.line_bytes {
                        break;
                    }
                }
                &joined
            }
        };
        let Some((word, rest)) = next_word(line) else { continue };
        match word {
            b"v" => lists.vertex(rest, number),
            b"vn" => lists.normals.push(next_vector(rest).map_or(Vec3::ZERO, |(normal, _, _)| normal.as_vec3())),
            b"vt" => {
                let number = |rest| next_f64(rest).map_or((0.0, &[][..]), |(number, _, rest)| (number as f32, rest));
                let (u, rest) = number(rest);
                lists.places.push([u, number(rest).0]);
            }
            b"f" => {
                lists.face(rest, number, &mut face, reading);
                reading.check_size(Some(number))?;
            }
            b"mtllib" => lists.library(rest, number, reading),
            b"usemtl" => lists.material(rest.trim_ascii(), number, reading),
            _ => {}
        }
    }
    lines.check()?;
    lists.bad_vertex.error(&mut reading.diagnostics);
    lists.bad_face.error(&mut reading.diagnostics);
    lists.no_material.warn(&mut reading.diagnostics);
    Ok(())
}

impl Lists {
    fn vertex(&mut self, rest: &[u8], number: u64) {
        let vector = next_vector(rest).filter(|(position, _, _)| is_plausible(*position));
        let Some((position, _, rest)) = vector else {
            self.bad_vertex.note(number, || {
                format!(
                    "expected the three coordinates of a vertex, found \"{}\"; faces at it are left out",
                    shown(rest)
                )
            });
            // It keeps its number.
            self.positions.push(Vec3::NAN);
            return;
        };
        let mut more = [0.0; 3];
        let mut count = 0;
        let mut left = rest;
        while let (Some(slot), Some((value, _, after))) = (more.get_mut(count), next_f64(left)) {
            *slot = value;
            count += 1;
            left = after;
        }
        let color = (count == 3 && more.iter().all(|x| x.is_finite())).then(|| {
            // 0 to 1; some tools write bytes.
            let most = if more.iter().any(|&x| x > 1.0) { 255.0 } else { 1.0 };
            let [r, g, b] = more.map(|x| ((x / most).clamp(0.0, 1.0) * 255.0).round() as u8);
            Srgb8::rgb(r, g, b)
        });
        if color.is_some() || !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), None);
            self.colors.push(color);
        }
        // A fourth number is the weight of a rational curve: 1 in meshes.
        self.positions.push(position.as_vec3());
    }

    fn face(&mut self, rest: &[u8], number: u64, face: &mut Vec<Corner>, reading: &mut Reading<'_>) {
        face.clear();
        for word in words(rest).take_while(|word| !word.starts_with(b"#")) {
            match self.corner(word) {
                Ok(corner) => face.push(corner),
                Err(why) => {
                    self.bad_face.note(number, || format!("{why}; the face is left out"));
                    return;
                }
            }
        }
        let found = face.len();
        if found < 3 {
            self.bad_face
                .note(number, || format!("expected three or more corners of a face, found {found}; it is left out"));
            return;
        }
        let first = self.mesh_vertex(face[0], reading);
        for pair in face[1..].windows(2) {
            let [b, c] = [pair[0], pair[1]].map(|corner| self.mesh_vertex(corner, reading));
            reading.mesh.push_triangle([first, b, c]);
        }
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1, or back from the end by negative numbers.
    fn corner(&self, word: &[u8]) -> std::result::Result<Corner, String> {
        let mut parts = word.split(|&byte| byte == b'/');
        let index = |part: &[u8], count: usize, what: &str| {
            let stated = parse_i64(part)
                .ok_or_else(|| format!("expected a corner such as 7, 7/1 or 7//3, found \"{}\"", shown(word)))?;
            let count_i64 = i64::try_from(count).unwrap_or(i64::MAX);
            let from_zero = if stated < 0 { stated.checked_add(count_i64) } else { stated.checked_sub(1) };
            from_zero
                .filter(|index| (0..count_i64).contains(index))
                .and_then(|index| u32::try_from(index).ok())
                .ok_or_else(|| format!("{what} {stated} is not there: the file has {count} up to here"))
        };
        let vertex = index(parts.next().unwrap_or_default(), self.positions.len(), "vertex")?;
        if !self.positions[vertex as usize].is_finite() {
            return Err(format!("vertex {} has no position", vertex + 1));
        }
        let place = match parts.next() {
            // What is not shown need not be there: many files number what they leave out.
            Some(part) if !part.is_empty() && self.has_picture() => {
                index(part, self.places.len(), "place in the picture")?
            }
            _ => u32::MAX,
        };
        let normal = match parts.next() {
            None | Some(b"") => u32::MAX,
            Some(part) => index(part, self.normals.len(), "normal")?,
        };
        Ok((vertex, normal, place, self.current))
    }

    /// Whether the material in use has a picture.
    fn has_picture(&self) -> bool {
        matches!(self.in_use.get(self.current as usize), Some(Some((_, Some(_)))))
    }

    /// The vertex of the mesh for a corner.
    fn mesh_vertex(&mut self, corner: Corner, reading: &mut Reading<'_>) -> u32 {
        let (vertex, normal, place, material) = corner;
        *self.corners.entry(corner).or_insert_with(|| {
            let normal = self.normals.get(normal as usize).copied();
            let own = self.colors.get(vertex as usize).copied().flatten();
            let paint = self.in_use[material as usize];
            let color = match (paint, own) {
                (Some((material, _)), Some(own)) => Srgb8 { a: material.a, ..own },
                (material, own) => own.or(material.map(|(color, _)| color)).unwrap_or(UNCOLORED),
            };
            let picture = paint.and_then(|(_, picture)| self.pictures.get(picture?));
            let color = match (picture, self.places.get(place as usize)) {
                (Some(picture), Some(&[u, v])) => {
                    let [r, g, b, a] = picture.sample([u, 1.0 - v], [Wrap::Repeat; 2]);
                    let own = color.to_linear();
                    Srgb8::from_linear([r * own[0], g * own[1], b * own[2]], a * f32::from(color.a) / 255.0)
                }
                _ => color,
            };
            reading.mesh.push_vertex(self.positions[vertex as usize], normal, color)
        })
    }

    /// `mtllib`: one name with blanks, or several names.
    fn library(&mut self, rest: &[u8], number: u64, reading: &mut Reading<'_>) {
        let whole = String::from_utf8_lossy(rest.trim_ascii()).into_owned();
        let read = |name: &str| reading.folder.read(name).map(|bytes| (name.to_owned(), bytes));
        let libraries: Vec<_> = match read(&whole) {
            Err(_) if whole.contains(' ') => whole.split_whitespace().map(read).collect(),
            one => vec![one],
        };
        for library in libraries {
            match library {
                Ok((name, bytes)) => {
                    let text = normalise(&bytes, &mut reading.diagnostics);
                    let mut materials = HashMap::new();
                    mtl::read(&text, reading.limits.line_bytes, &mut materials);
                    // Pictures are named from where the materials are.
                    if let Some((folder, _)) = name.rsplit_once(['/', '\\']) {
                        for map in materials.values_mut().filter_map(|material| material.map.as_mut()) {
                            *map = format!("{folder}/{map}");
                        }
                    }
                    self.materials.extend(materials);
                }
                Err(why) => {
                    reading.diagnostics.warn(Some(number), format!("{why}; what has its materials is drawn grey"));
                }
            }
        }
    }

    fn material(&mut self, name: &[u8], number: u64, reading: &mut Reading<'_>) {
        let material = self.materials.get(name).cloned();
        if material.is_none() && !self.materials.is_empty() {
            self.no_material.note(number, || format!("there is no material \"{}\"; grey is taken", shown(name)));
        }
        let paint = material.map(|material| {
            let picture = material.map.and_then(|map| self.picture(map, number, reading));
            (material.color, picture)
        });
        let next = self.in_use.len() as u32;
        self.current = *self.number_of.entry(paint).or_insert(next);
        if self.current == next {
            self.in_use.push(paint);
        }
    }

    /// The number of the picture of a name, which is read if it was not yet.
    fn picture(&mut self, name: String, number: u64, reading: &mut Reading<'_>) -> Option<usize> {
        if let Some(&picture) = self.picture_of.get(&name) {
            return picture;
        }
        let read = reading.folder.read(&name).map_err(|error| error.to_string());
        let picture = match read.and_then(|bytes| Texture::decode(&bytes, &mut reading.picture_bytes)) {
            Ok(picture) => {
                self.pictures.push(picture);
                Some(self.pictures.len() - 1)
            }
            Err(why) => {
                let name = shown(name.as_bytes());
                let message = format!("the picture {name} is left out: {why}; the material's own colour is taken");
                reading.diagnostics.warn(Some(number), message);
                None
            }
        };
        self.picture_of.insert(name, picture);
        picture
    }
}
