//! glTF 2.0: the default scene of a `.gltf` (JSON, with buffers as data URIs or as files beside it) or `.glb` (JSON and one buffer
//! in one file). Node transforms, instances (`EXT_mesh_gpu_instancing`), base colour factors and textures (with `KHR_texture_transform`), `COLOR_0` and
//! the alpha mode are applied; skins, morph targets, cameras and lights are passed over.
//!
//! Only the JSON is left to a crate (`gltf-json`). Its companion `gltf` adds the reading of accessors and a validation, which panic
//! where an index or a count is wrong; here every index is looked up and every range checked (`accessor`).

mod accessor;
mod paint;

use super::Reading;
use crate::error::{Error, Result};
use accessor::Buffers;
use base64::Engine;
use glam::{DMat3, DMat4, DQuat, DVec3, Vec3};
use gltf_json::Root;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::scene::Node;
use gltf_json::validation::Checked;
use std::borrow::Cow;

/// How a binary file begins.
pub(super) const MAGIC: &[u8] = b"glTF";

/// Nodes within nodes that are followed: none of a drawing go deeper than a few; a circle has no end.
const MAX_DEPTH: usize = 64;
/// Nodes visited: each may stand under several parents (chosen).
const MAX_NODES: usize = 1_000_000;

/// By this a mesh has instances.
const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Extensions that files require and that are read, or whose lack changes no triangle: lights, and smaller numbers, which accessors read anyway.
const HARMLESS: [&str; 4] = [INSTANCING, "KHR_texture_transform", "KHR_lights_punctual", "KHR_mesh_quantization"];

pub(super) fn read(bytes: &[u8], reading: &mut Reading<'_>) -> Result<()> {
    let (json, binary) = if bytes.starts_with(MAGIC) { chunks(bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let root: Root = gltf_json::deserialize::from_slice(json).map_err(|error| {
        let line = (!bytes.starts_with(MAGIC)).then_some(error.line() as u64);
        Error::input(line, format!("the glTF JSON cannot be read: {error}"))
    })?;
    if root.asset.version.split('.').next() != Some("2") {
        let version = super::shown(root.asset.version.as_bytes());
        return Err(Error::Unsupported(format!("glTF version {version} is not read; export the mesh as glTF 2.0")));
    }
    let is_needed = |name: &&String| !HARMLESS.contains(&name.as_str()) && !name.starts_with("KHR_materials_");
    if let Some(name) = root.extensions_required.iter().find(is_needed) {
        let name = super::shown(name.as_bytes());
        return Err(Error::Unsupported(format!(
            "the glTF file needs the extension {name}, which is not read; export the mesh without it (no compression)"
        )));
    }
    let buffers = buffers(&root, binary, reading)?;
    let mut walk = Walk { root: &root, buffers, reading, pictures: paint::Pictures::default(), nodes: 0, skipped: 0 };
    let scene = root.scene.as_ref().and_then(|index| root.scenes.get(index.value())).or(root.scenes.first());
    match scene {
        Some(scene) => {
            for node in &scene.nodes {
                walk.node(node.value(), DMat4::IDENTITY, 0)?;
            }
        }
        // A library of meshes without a scene: each as it is.
        None => {
            for mesh in 0..root.meshes.len() {
                walk.mesh(mesh, DMat4::IDENTITY)?;
            }
        }
    }
    if walk.skipped > 0 {
        let message = format!("{} parts made of points or lines are not drawn", walk.skipped);
        walk.reading.diagnostics.warn(None, message);
    }
    Ok(())
}

/// The JSON and, if there is one, the buffer of a binary file.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>)> {
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let cut = || Error::input(None, "the binary glTF file ends too early: expected a header, JSON and a buffer");
    let version = word(4).ok_or_else(cut)?;
    if version != 2 {
        return Err(Error::Unsupported(format!("binary glTF version {version} is not read; export it as version 2")));
    }
    let chunk = |at: usize| -> Option<(u32, &[u8])> {
        let (length, kind) = (usize::try_from(word(at)?).ok()?, word(at.checked_add(4)?)?);
        let start = at.checked_add(8)?;
        Some((kind, bytes.get(start..start.checked_add(length)?)?))
    };
    let (kind, json) = chunk(12).ok_or_else(cut)?;
    if kind != u32::from_le_bytes(*b"JSON") {
        return Err(Error::input(None, "the binary glTF file does not begin with a JSON chunk"));
    }
    let binary = chunk(20 + json.len()).filter(|(kind, _)| *kind == u32::from_le_bytes(*b"BIN\0"));
    Ok((json, binary.map(|(_, binary)| binary)))
}

/// The bytes of all buffers: the file's own, data URIs, files beside it.
fn buffers<'a>(root: &Root, binary: Option<&'a [u8]>, reading: &Reading<'_>) -> Result<Buffers<'a>> {
    let mut buffers = Buffers::new(reading.limits.triangles.saturating_mul(3));
    for (index, buffer) in root.buffers.iter().enumerate() {
        let bytes: Cow<'a, [u8]> = match &buffer.uri {
            None if index == 0 => binary.unwrap_or_default().into(),
            None => (&[][..]).into(),
            Some(uri) => match uri.strip_prefix("data:") {
                Some(data) => data_uri(data)
                    .ok_or_else(|| Error::input(None, format!("buffer {index} is no base64 data URI")))?
                    .into(),
                None => reading.folder.read(&percent_decoded(uri))?.into(),
            },
        };
        buffers.push(bytes);
    }
    Ok(buffers)
}

fn data_uri(data: &str) -> Option<Vec<u8>> {
    let (head, text) = data.split_once(',')?;
    // Some writers leave the padding out.
    let engine = base64::engine::GeneralPurpose::new(
        &base64::alphabet::STANDARD,
        base64::engine::GeneralPurposeConfig::new()
            .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent),
    );
    head.ends_with(";base64").then(|| engine.decode(text.trim()).ok()).flatten()
}

/// `%20` as a blank; what is no such code stays.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, after @ ..] = rest {
        let code = (*first == b'%').then(|| after.get(..2)).flatten();
        let byte = code.and_then(|code| u8::from_str_radix(std::str::from_utf8(code).ok()?, 16).ok());
        bytes.push(byte.unwrap_or(*first));
        rest = if byte.is_some() { &after[2..] } else { after };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A walk over the nodes.
struct Walk<'a, 'b, 'c> {
    root: &'a Root,
    buffers: Buffers<'a>,
    reading: &'b mut Reading<'c>,
    pictures: paint::Pictures,
    nodes: usize,
    /// Parts that are no triangles.
    skipped: usize,
}

impl Walk<'_, '_, '_> {
    fn node(&mut self, index: usize, scene_from_parent: DMat4, depth: usize) -> Result<()> {
        let Some(node) = self.root.nodes.get(index) else {
            return Err(Error::input(None, format!("the glTF file names node {index}, which is not there")));
        };
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            let message =
                format!("the glTF nodes are more than {MAX_DEPTH} deep or {MAX_NODES} many; do they go in a circle?");
            return Err(Error::limit(None, message));
        }
        let scene_from_node = scene_from_parent * parent_from_node(node);
        if let Some(mesh) = &node.mesh {
            match self.instances(node)? {
                None => self.mesh(mesh.value(), scene_from_node)?,
                Some(instances) => {
                    for node_from_instance in instances {
                        self.mesh(mesh.value(), scene_from_node * node_from_instance)?;
                    }
                }
            }
        }
        for child in node.children.iter().flatten() {
            self.node(child.value(), scene_from_node, depth + 1)?;
        }
        Ok(())
    }

    /// Where the instances of a node's mesh stand; `None` if it has none. What is not stated is as usual.
    fn instances(&self, node: &Node) -> Result<Option<Vec<DMat4>>> {
        let extension = node.extensions.as_ref().and_then(|extensions| extensions.others.get(INSTANCING));
        let Some(attributes) = extension.and_then(|extension| extension.get("attributes")) else { return Ok(None) };
        let column = |name: &str, least: usize| match attributes.get(name) {
            None => Ok(None),
            Some(index) => {
                let index = index.as_u64().and_then(|index| usize::try_from(index).ok()).unwrap_or(usize::MAX);
                self.buffers.vectors(self.root, index, least).map(Some)
            }
        };
        let (translations, rotations, scales) =
            (column("TRANSLATION", 3)?, column("ROTATION", 4)?, column("SCALE", 3)?);
        let counts = [&translations, &rotations, &scales].map(|column| column.as_ref().map(Vec::len));
        let Some(count) = counts.into_iter().flatten().next() else { return Ok(None) };
        if counts.into_iter().flatten().any(|other| other != count) {
            return Err(Error::input(None, format!("{INSTANCING}: its columns have different lengths")));
        }
        let of = |column: &Option<Vec<[f32; 4]>>, index: usize| -> Option<[f64; 4]> {
            column.as_ref()?.get(index).map(|vector| vector.map(f64::from))
        };
        let matrix = |index: usize| {
            let [x, y, z, _] = of(&translations, index).unwrap_or([0.0; 4]);
            let [sx, sy, sz, _] = of(&scales, index).unwrap_or([1.0; 4]);
            let rotation = unit_rotation(of(&rotations, index).unwrap_or([0.0, 0.0, 0.0, 1.0]));
            DMat4::from_scale_rotation_translation(DVec3::new(sx, sy, sz), rotation, DVec3::new(x, y, z))
        };
        Ok(Some((0..count).map(matrix).collect()))
    }

    fn mesh(&mut self, index: usize, scene_from_mesh: DMat4) -> Result<()> {
        let Some(mesh) = self.root.meshes.get(index) else {
            return Err(Error::input(None, format!("the glTF file names mesh {index}, which is not there")));
        };
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let in_mesh = |error| match error {
                Error::Input { message, .. } => Error::input(None, format!("mesh {index}, part {number}: {message}")),
                other => other,
            };
            self.primitive(primitive, scene_from_mesh).map_err(in_mesh)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, scene_from_mesh: DMat4) -> Result<()> {
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
            _ => {
                self.skipped += 1;
                return Ok(());
            }
        };
        let find = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value());
        let Some(positions) = find(Semantic::Positions) else {
            return Err(Error::input(None, "expected the attribute POSITION, found none"));
        };
        let values = |accessor: usize, least: usize| self.buffers.vectors(self.root, accessor, least);
        let positions = values(positions, 3)?;
        let normals = find(Semantic::Normals).map(|index| values(index, 3)).transpose()?.unwrap_or_default();
        let colors = find(Semantic::Colors(0)).map(|index| values(index, 3)).transpose()?.unwrap_or_default();
        let indices =
            primitive.indices.as_ref().map(|index| self.buffers.indices(self.root, index.value())).transpose()?;
        let paint = paint::of(self.root, primitive, !colors.is_empty());
        let picture = match &paint.texture {
            Some(texture) => self.pictures.number(self.root, texture, &self.buffers, self.reading),
            None => None,
        };
        let places = match (&paint.texture, picture) {
            (Some(texture), Some(_)) => find(Semantic::TexCoords(texture.set))
                .map(|index| self.buffers.vectors(self.root, index, 2))
                .transpose()?
                .unwrap_or_default(),
            _ => Vec::new(),
        };
        let matrix = DMat3::from_mat4(scene_from_mesh);
        // Normals go with the inverse transposed, which for a flattened part there is none of.
        let turn = matrix.inverse().transpose();
        let first = u32::try_from(self.reading.mesh.vertex_count()).unwrap_or(u32::MAX);
        for (index, position) in positions.iter().enumerate() {
            let [x, y, z, _] = position.map(f64::from);
            let position = scene_from_mesh.transform_point3(DVec3::new(x, y, z));
            let position = if super::is_plausible(position) { position.as_vec3() } else { Vec3::NAN };
            let normal =
                normals.get(index).map(|&[x, y, z, _]| (turn * DVec3::from([x, y, z].map(f64::from))).as_vec3());
            let texel = (paint.texture.as_ref().zip(picture).zip(places.get(index)))
                .map(|((texture, picture), &[u, v, ..])| self.pictures.sample(picture, texture, [u, v]));
            self.reading.mesh.push_vertex(position, normal, paint.color(colors.get(index).copied(), texel));
        }
        let count = positions.len();
        let sequential = || (0..u32::try_from(count).unwrap_or(u32::MAX)).collect();
        let corners: Vec<u32> = indices.unwrap_or_else(sequential);
        if let Some(wrong) = corners.iter().find(|&&corner| corner as usize >= count) {
            return Err(Error::input(None, format!("vertex {wrong} is not there: the part has {count}")));
        }
        let mut push = |[a, b, c]: [u32; 3]| {
            self.reading.mesh.push_triangle([a, b, c].map(|corner| corner.saturating_add(first)));
        };
        match (mode, corners.as_slice()) {
            (Mode::TriangleStrip, corners) => corners.windows(3).for_each(|three| push([three[0], three[1], three[2]])),
            (Mode::TriangleFan, [hub, rim @ ..]) => rim.windows(2).for_each(|two| push([*hub, two[0], two[1]])),
            (_, corners) => corners.as_chunks().0.iter().for_each(|&three| push(three)),
        }
        self.reading.check_size(None)
    }
}

/// A matrix, or translation, rotation and scale.
fn parent_from_node(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
    let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
    let translation = node.translation.unwrap_or([0.0; 3]).map(f64::from);
    DMat4::from_scale_rotation_translation(scale.into(), unit_rotation(rotation), translation.into())
}

fn unit_rotation(xyzw: [f64; 4]) -> DQuat {
    let rotation = DQuat::from_array(xyzw);
    if rotation.length_squared() > 1e-12 { rotation.normalize() } else { DQuat::IDENTITY }
}
