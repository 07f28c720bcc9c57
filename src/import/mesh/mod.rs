//! Triangle meshes: surfaces, cages and labels that other tools made, to be laid over a molecule. Wavefront OBJ with its
//! materials (`obj`, `mtl`) and glTF 2.0, as JSON or binary (`gltf`, `gltf/accessor`).
//!
//! Positions are taken as ångström in the frame of the atoms' file (glTF says metres; tools that draw molecules write ångström).
//! Read are positions, normals, colours and opacity; base colour textures where the vertices are (`texture`). Files that a mesh names (materials, buffers,
//! pictures) are read only if they are in its own folder or below it, nothing from a network.
//!
//! Sources: the Wavefront "Object Files" and "Material Template Library" specifications as far as other tools write them, and
//! the Khronos glTF 2.0 specification (2021).

mod companion;
mod gltf;
mod mtl;
mod obj;
mod texture;

use super::text::shown;
use super::{ImportOptions, Limits, decompress, file, is_plausible, text, too_large};
use crate::color::Srgb8;
use crate::error::{Error, Result};
use crate::structure::{Diagnostic, Diagnostics, Mesh, MeshBuilder};
use companion::Folder;
use std::path::Path;

/// The colour of what has none: a light grey that stands out from a white background (chosen).
const UNCOLORED: Srgb8 = Srgb8::rgb(190, 190, 195);

/// What the readers share: the mesh so far, what was noticed, and what may be used.
struct Reading<'a> {
    mesh: MeshBuilder,
    diagnostics: Diagnostics,
    limits: &'a Limits,
    folder: Folder<'a>,
    /// Bytes that unpacked pictures may still take.
    picture_bytes: u64,
}

impl Reading<'_> {
    /// An error once there are too many triangles or vertices.
    fn check_size(&self, line: Option<u64>) -> Result<()> {
        let limit = self.limits.triangles;
        if self.mesh.triangle_count() > limit || self.mesh.vertex_count() / 3 > limit {
            return Err(Error::limit(line, format!("the mesh has more than {limit} triangles (limit `triangles`)")));
        }
        Ok(())
    }
}

/// Reads a mesh from a file.
///
/// # Errors
/// [`Error::Io`] if the file cannot be opened or read, else as [`read_bytes`].
pub fn read_path(path: &Path, options: &ImportOptions) -> Result<(Mesh, Vec<Diagnostic>)> {
    let limit = options.limits.decompressed_bytes;
    let io_error = |source| Error::Io { action: "read", path: path.to_owned(), source };
    let file = std::fs::File::open(path).map_err(io_error)?;
    let metadata = file.metadata().map_err(io_error)?;
    let (size, limit) = (metadata.len(), file::most_bytes(&metadata, limit));
    let bytes = file::read_all(file, size.min(limit), limit.saturating_add(1), &options.stop).map_err(io_error)?;
    options.stop.check()?;
    if bytes.len() as u64 > limit {
        return Err(too_large(limit));
    }
    let folder = match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
        None => Path::new("."),
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    read_bytes(&bytes, &name, Some(folder), options)
}

/// Reads a mesh that is in memory already. `name_hint` is its name: where the content leaves it open, `.obj` tells that it is
/// Wavefront OBJ. `folder` is where files that it names are looked for; `None` for nowhere.
///
/// ```
/// use ballstick::import::{ImportOptions, mesh};
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let (mesh, _) = mesh::read_bytes(text, "triangle.obj", None, &ImportOptions::default())?;
/// assert_eq!(mesh.triangles(), [[0, 1, 2]]);
/// # Ok::<(), ballstick::Error>(())
/// ```
///
/// # Errors
/// [`Error::Input`] if there is no mesh in the bytes, [`Error::Limit`] if one of [`Limits`] would be passed,
/// [`Error::Unsupported`] for what a glTF file needs and this program does not do (compressed meshes).
pub fn read_bytes(
    bytes: &[u8],
    name_hint: &str,
    folder: Option<&Path>,
    options: &ImportOptions,
) -> Result<(Mesh, Vec<Diagnostic>)> {
    let mut diagnostics = Diagnostics::default();
    let plain = decompress::decompress(bytes, &options.limits, &options.stop, &mut diagnostics)?;
    let folder = Folder::new(folder, &options.limits);
    let mut reading = Reading {
        mesh: MeshBuilder::default(),
        diagnostics,
        limits: &options.limits,
        folder,
        picture_bytes: texture::MOST_BYTES,
    };
    if plain.starts_with(gltf::MAGIC) || first_byte(&plain) == Some(b'{') {
        gltf::read(&plain, &mut reading)?;
    } else {
        let text = text::normalise(&plain, &mut reading.diagnostics);
        if !obj::is_obj(&text) && !has_extension(name_hint, "obj") {
            return Err(Error::input(
                1,
                format!(
                    "expected a triangle mesh, Wavefront OBJ (lines `v x y z` and `f 1 2 3`) or glTF, found {}; convert it to one of these",
                    match text.iter().position(|&byte| byte == b'\n').map_or(&text[..], |end| &text[..end]) {
                        [] => "nothing".to_owned(),
                        line => format!("\"{}\"", shown(line)),
                    }
                ),
            ));
        }
        obj::read(&text, &mut reading)?;
    }
    let triangles = reading.mesh.triangle_count();
    let mesh = reading.mesh.build();
    if mesh.triangles().is_empty() {
        let message = match triangles {
            0 => "the mesh has no triangles: expected faces (points and lines are not drawn)".to_owned(),
            some => format!("none of the mesh's {some} triangles has an area"),
        };
        return Err(Error::input(None, message));
    }
    Ok((mesh, reading.diagnostics.into_list()))
}

fn first_byte(bytes: &[u8]) -> Option<u8> {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start().first().copied()
}

fn has_extension(name: &str, extension: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let name = name.strip_suffix(".gz").or(name.strip_suffix(".zst")).unwrap_or(&name);
    name.rsplit_once('.').is_some_and(|(_, found)| found == extension)
}

#[cfg(test)]
mod tests;
