//! glTF 2.0 (Khronos, 2021): GLB, or JSON with its numbers inside as base64.
//!
//! The tree: a root that holds unit and place; below it a node for each molecule, cell or overlay, with the names of its atoms and residues as extras; below these
//! one node for all instances of one unit mesh in one colour, with `EXT_mesh_gpu_instancing` and the ids of what the instances stand for. The extension
//! is required: an importer without it would show one ball at the origin, and says so in place of that. Colours are the materials' and not
//! an instance attribute, since importers do not show those. Plain meshes have one part for each colour of a molecule.
//!
//! Memory: the pieces, the JSON, and one unit mesh of each kind; numbers are written as they are made.

mod pack;

use super::pieces::{Kind, Piece, Surface};
use super::shape::{Meshes, Shape};
use super::{Model, Totals, gibibytes, names};
use crate::color::Srgb8;
use crate::error::{Error, Result};
use crate::export::atomic;
use base64::Engine;
use glam::Vec3;
use gltf_json::extras::RawValue;
use gltf_json::material::{AlphaMode, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::scene::{Node, Scene as JsonScene};
use gltf_json::validation::Checked::Valid;
use gltf_json::{Asset, Buffer, Index, Material, Mesh, Root};
use pack::{Column, Numbers, Packer};
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};
use std::io::{self, Write};
use std::path::Path;

/// The extension by which a mesh has instances.
const INSTANCING: &str = "EXT_mesh_gpu_instancing";
/// How rough surfaces are: highlights about as wide as in our pictures (chosen by looking).
const ROUGHNESS: f32 = 0.5;
/// Most bytes of numbers in a JSON file (chosen: as text they are a third more, and readers hold both).
const MOST_IN_JSON: u64 = 1 << 30;

/// Pieces that become one mesh or the instances of one.
struct Group {
    placement: usize,
    color: Srgb8,
    kind: Kind,
    two_sided: bool,
    /// The mesh of the instances; `None` in plain meshes.
    shape: Option<Shape>,
    pieces: Vec<Piece>,
}

pub(super) fn write(model: &Model<'_>, totals: &Totals, is_binary: bool, path: &Path) -> Result<()> {
    if model.options.compat {
        // Positions, normals and corners: what is too large by far is known before it is made.
        check_size(is_binary, 24 * totals.vertices + 12 * totals.triangles)?;
    }
    let groups = groups(model);
    let mut surfaces: Vec<(usize, Surface)> = Vec::new();
    for (index, placement) in model.scene.placements.iter().enumerate() {
        if !model.scene.blocks[placement.block].triangles.is_empty() {
            surfaces.push((index, Surface::of(model.scene, &model.frame, placement)));
        }
    }
    let mut document = Document::new(model, &groups, &surfaces);
    document.build()?;
    let Document { mut root, packer, .. } = document;
    let length = packer.length();
    root.buffers.push(Buffer {
        byte_length: length.into(),
        name: None,
        uri: (!is_binary).then(|| format!("{DATA}{MARK}")),
        extensions: None,
        extras: None,
    });
    let mut json = gltf_json::serialize::to_vec(&root)
        .map_err(|error| Error::Unsupported(format!("the glTF JSON cannot be written down: {error}")))?;
    drop(root);
    let numbers = Numbers { groups: &groups, surfaces: &surfaces };
    if is_binary {
        json.resize(json.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + json.len() as u64 + 8 + length;
        check_size(true, total)?;
        atomic::write(path, |out| {
            out.write_all(b"glTF")?;
            for word in [2, total as u32, json.len() as u32] {
                out.write_all(&word.to_le_bytes())?;
            }
            out.write_all(b"JSON")?;
            out.write_all(&json)?;
            out.write_all(&(length as u32).to_le_bytes())?;
            out.write_all(b"BIN\0")?;
            packer.write(&numbers, out)
        })
    } else {
        check_size(false, length)?;
        let mark = memchr::memmem::find(&json, MARK.as_bytes()).unwrap_or(json.len());
        atomic::write(path, |out| {
            out.write_all(&json[..mark])?;
            let mut base64 = Base64 { out, pending: Vec::with_capacity(PIECE), text: String::new() };
            packer.write(&numbers, &mut base64)?;
            base64.finish()?;
            out.write_all(json.get(mark + MARK.len()..).unwrap_or_default())
        })
    }
}

/// How the only buffer of a JSON file begins, and what stands for its bytes until they are written. Nothing of a user's stands before it.
const DATA: &str = "data:application/octet-stream;base64,";
const MARK: &str = "@ballstick@";

/// An error for more bytes than a file of a kind has.
fn check_size(is_binary: bool, bytes: u64) -> Result<()> {
    match is_binary {
        true if bytes > u64::from(u32::MAX) => Err(too_large("GLB", bytes, "4 GiB")),
        false if bytes > MOST_IN_JSON => Err(too_large("glTF", bytes, "1 GiB here; GLB has up to 4")),
        _ => Ok(()),
    }
}

fn too_large(what: &str, bytes: u64, most: &str) -> Error {
    let message = format!(
        "the {what} file would have {}, and has at most {most}; a larger --tolerance makes it smaller, as do instances (no --compat)",
        gibibytes(bytes)
    );
    Error::Unsupported(message)
}

fn groups(model: &Model<'_>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let mut places: HashMap<(usize, Srgb8, bool, Option<Shape>), usize> = HashMap::new();
    let compat = model.options.compat;
    let visited = model.each_piece(false, |placement, piece, _| {
        let shape = (!compat).then_some(piece.shape);
        let two_sided = matches!(piece.shape, Shape::Tube(_, caps) if caps != [true; 2]);
        let place = *places.entry((placement, piece.color, two_sided, shape)).or_insert_with(|| {
            let (color, kind) = (piece.color, piece.kind);
            groups.push(Group { placement, color, kind, two_sided, shape, pieces: Vec::new() });
            groups.len() - 1
        });
        groups[place].pieces.push(*piece);
        Ok(())
    });
    debug_assert!(visited.is_ok());
    groups
}

/// The JSON while it is made.
struct Document<'a> {
    model: &'a Model<'a>,
    groups: &'a [Group],
    surfaces: &'a [(usize, Surface)],
    root: Root,
    packer: Packer,
    meshes: Meshes,
    /// Accessors of positions, normals and corners of a unit mesh.
    units: HashMap<Shape, [Index<gltf_json::Accessor>; 3]>,
    materials: HashMap<(Srgb8, bool), Index<Material>>,
    /// Meshes of a shape in a material, which several molecules share.
    shared: HashMap<(Shape, Srgb8, bool), Index<Mesh>>,
}

impl<'a> Document<'a> {
    fn new(model: &'a Model<'a>, groups: &'a [Group], surfaces: &'a [(usize, Surface)]) -> Document<'a> {
        let unit = model.options.unit;
        let asset = Asset {
            generator: Some(format!("ballstick {}", env!("CARGO_PKG_VERSION"))),
            extras: raw(&json!({
                "unit": unit.name(),
                "metres_per_unit": 1e-10 / unit.per_angstrom(),
                "tolerance_angstrom": model.options.tolerance,
            })),
            ..Asset::default()
        };
        Document {
            model,
            groups,
            surfaces,
            root: Root { asset, ..Root::default() },
            packer: Packer::default(),
            meshes: Meshes::default(),
            units: HashMap::new(),
            materials: HashMap::new(),
            shared: HashMap::new(),
        }
    }

    fn build(&mut self) -> Result<()> {
        let mut children: BTreeMap<usize, Vec<Index<Node>>> = BTreeMap::new();
        for (number, group) in self.groups.iter().enumerate() {
            let node = self.group(number, group)?;
            children.entry(group.placement).or_default().push(self.root.push(node));
        }
        for (number, (placement, surface)) in self.surfaces.iter().enumerate() {
            let mesh = self.surface(number, surface);
            let node = Node { mesh: Some(mesh), name: Some("surface".to_owned()), ..Node::default() };
            children.entry(*placement).or_default().push(self.root.push(node));
        }
        let mut placements = Vec::new();
        for (placement, children) in children {
            let node = Node {
                name: Some(self.model.placement_name(placement)),
                children: Some(children),
                extras: self.model.source(placement).and_then(|source| raw(&names::extras(source))),
                ..Node::default()
            };
            placements.push(self.root.push(node));
        }
        let unit = self.model.options.unit.per_angstrom();
        let root = Node {
            name: Some("ballstick".to_owned()),
            children: Some(placements),
            translation: Some((self.model.frame.origin * unit).as_vec3().to_array()),
            scale: (unit != 1.0).then_some([unit as f32; 3]),
            ..Node::default()
        };
        let root = self.root.push(root);
        let scene = JsonScene { extensions: None, extras: None, name: None, nodes: vec![root] };
        self.root.scene = Some(self.root.push(scene));
        self.root.accessors = std::mem::take(&mut self.packer.accessors);
        self.root.buffer_views = std::mem::take(&mut self.packer.views);
        if self.groups.iter().any(|group| group.shape.is_some()) {
            self.root.extensions_used.push(INSTANCING.to_owned());
            self.root.extensions_required.push(INSTANCING.to_owned());
        }
        Ok(())
    }

    fn group(&mut self, number: usize, group: &Group) -> Result<Node> {
        let color = group.color;
        let name = Some(match group.shape {
            Some(_) => format!("{} {color}", group.kind.name()),
            None => color.to_string(),
        });
        let Some(shape) = group.shape else {
            let mesh = self.baked(number, group)?;
            return Ok(Node { mesh: Some(mesh), name, ..Node::default() });
        };
        let mesh = match self.shared.get(&(shape, color, group.two_sided)) {
            Some(&mesh) => mesh,
            None => {
                let [positions, normals, corners] = self.unit(shape);
                let material = self.material(color, group.two_sided);
                let mesh = self.root.push(plain(name.clone(), positions, normals, corners, Some(material)));
                self.shared.insert((shape, color, group.two_sided), mesh);
                mesh
            }
        };
        let count = group.pieces.len() as u64;
        let translation = self.packer.vectors(Column::Translations(number), count, 3, None);
        let rotation = self.packer.vectors(Column::Rotations(number), count, 4, None);
        let scale = self.packer.vectors(Column::Scales(number), count, 3, None);
        let attributes = json!({
            "attributes": {
                "TRANSLATION": translation.value(),
                "ROTATION": rotation.value(),
                "SCALE": scale.value(),
            }
        });
        let others = serde_json::Map::from_iter([(INSTANCING.to_owned(), attributes)]);
        let ids: Vec<u32> = group.pieces.iter().map(|piece| piece.id).collect();
        Ok(Node {
            mesh: Some(mesh),
            name,
            extensions: Some(gltf_json::extensions::scene::Node { others }),
            extras: raw(&json!({ "kind": group.kind.name(), "ids": ids })),
            ..Node::default()
        })
    }

    fn unit(&mut self, shape: Shape) -> [Index<gltf_json::Accessor>; 3] {
        if let Some(&unit) = self.units.get(&shape) {
            return unit;
        }
        let mesh = self.meshes.of(shape);
        let (count, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
        let bounds = bounds(mesh.positions.iter().copied());
        let made = [
            self.packer.vertices(Column::UnitPositions(shape), count, 3, Some(bounds)),
            self.packer.vertices(Column::UnitNormals(shape), count, 3, None),
            self.packer.corners(Column::UnitCorners(shape), 3 * triangles, count),
        ];
        self.units.insert(shape, made);
        made
    }

    fn baked(&mut self, number: usize, group: &Group) -> Result<Index<Mesh>> {
        let counts = group.pieces.iter().map(|piece| piece.shape.counts());
        let [vertices, triangles] = counts.fold([0, 0], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
        if vertices >= u64::from(u32::MAX) {
            return Err(too_large("glTF", vertices * 24, "2³² vertices of one colour"));
        }
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for piece in &group.pieces {
            for &position in &self.meshes.of(piece.shape).positions {
                let point = piece.point(position);
                (low, high) = (low.min(point), high.max(point));
            }
        }
        let positions = self.packer.vertices(Column::Positions(number), vertices, 3, Some([low, high]));
        let normals = self.packer.vertices(Column::Normals(number), vertices, 3, None);
        let corners = self.packer.wide_corners(Column::Corners(number), 3 * triangles);
        let material = self.material(group.color, group.two_sided);
        let name = Some(group.color.to_string());
        Ok(self.root.push(plain(name, positions, normals, corners, Some(material))))
    }

    fn surface(&mut self, number: usize, surface: &Surface) -> Index<Mesh> {
        let count = surface.positions.len() as u64;
        let bounds = bounds(surface.positions.iter().copied());
        let positions = self.packer.vertices(Column::SurfacePositions(number), count, 3, Some(bounds));
        let normals = self.packer.vertices(Column::SurfaceNormals(number), count, 3, None);
        let colors = self.packer.colors(Column::SurfaceColors(number), count);
        let corners = self.packer.wide_corners(Column::SurfaceCorners(number), 3 * surface.triangles.len() as u64);
        let material = self.root.push(material(Srgb8::WHITE, true, surface.is_see_through()));
        let mut mesh = plain(Some("surface".to_owned()), positions, normals, corners, Some(material));
        for primitive in &mut mesh.primitives {
            primitive.attributes.insert(Valid(Semantic::Colors(0)), colors);
        }
        self.root.push(mesh)
    }

    fn material(&mut self, color: Srgb8, two_sided: bool) -> Index<Material> {
        let root = &mut self.root;
        *self
            .materials
            .entry((color, two_sided))
            .or_insert_with(|| root.push(material(color, two_sided, color.a < 255)))
    }
}

fn material(color: Srgb8, two_sided: bool, see_through: bool) -> Material {
    let [r, g, b] = color.to_linear();
    Material {
        name: Some(color.to_string()),
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor([r, g, b, f32::from(color.a) / 255.0]),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(ROUGHNESS),
            ..PbrMetallicRoughness::default()
        },
        alpha_mode: Valid(if see_through { AlphaMode::Blend } else { AlphaMode::Opaque }),
        double_sided: two_sided,
        ..Material::default()
    }
}

fn plain(
    name: Option<String>,
    positions: Index<gltf_json::Accessor>,
    normals: Index<gltf_json::Accessor>,
    corners: Index<gltf_json::Accessor>,
    material: Option<Index<Material>>,
) -> Mesh {
    let attributes = BTreeMap::from([(Valid(Semantic::Positions), positions), (Valid(Semantic::Normals), normals)]);
    let primitive = Primitive {
        attributes,
        extensions: None,
        extras: None,
        indices: Some(corners),
        material,
        mode: Valid(Mode::Triangles),
        targets: None,
    };
    Mesh { extensions: None, extras: None, name, primitives: vec![primitive], weights: None }
}

fn bounds(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    points.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], point| [low.min(point), high.max(point)])
}

fn raw(value: &Value) -> Option<Box<RawValue>> {
    RawValue::from_string(value.to_string()).ok()
}

/// Bytes that are gathered before they are turned into text: a multiple of 3, so that nothing is filled up in between.
const PIECE: usize = 3 << 14;

/// Writes base64 of what is written to it.
struct Base64<'a> {
    out: &'a mut dyn Write,
    pending: Vec<u8>,
    text: String,
}

impl Base64<'_> {
    fn push(&mut self) -> io::Result<()> {
        self.text.clear();
        base64::engine::general_purpose::STANDARD.encode_string(&self.pending, &mut self.text);
        self.pending.clear();
        self.out.write_all(self.text.as_bytes())
    }

    fn finish(mut self) -> io::Result<()> {
        self.push()
    }
}

impl Write for Base64<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(PIECE - self.pending.len());
        self.pending.extend_from_slice(&bytes[..taken]);
        if self.pending.len() == PIECE {
            self.push()?;
        }
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
