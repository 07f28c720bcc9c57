//! Scenes as solid shapes for other programs: glTF 2.0 (GLB, and as JSON), Wavefront OBJ with MTL, STL for printing, PLY.
//!
//! What is written is what would be drawn: balls, two-coloured sticks, dashes, rings, wedges, arrows, cells and meshes, in their colours and opacities.
//! Ground, light, background and texts are the picture's and are not. [`SolidOptions::tolerance`] says how near the triangles are to the true
//! surfaces (`shape`); `pieces` cuts a scene into unit meshes and where they stand; one module each writes a format.
//!
//! - GLB and glTF (`gltf`): every mesh once, and where its instances stand (`EXT_mesh_gpu_instancing`), or for importers without that plain
//!   meshes ([`SolidOptions::compat`]); physically based materials; names of atoms and residues as extras.
//! - OBJ (`obj`): a group for each residue, materials in an MTL file beside it. Its colours are sRGB, as most programs read them; Blender takes
//!   them for linear and shows them paler (it shows GLB and PLY as they are).
//! - STL (`stl`): every primitive a closed shell, facing outwards. Shells overlap where sticks end in balls and are not united: slicers unite
//!   closed shells, by the rule that what is inside any of them is solid, and an exact union of thousands would change nothing in the print.
//! - PLY (`ply`): one mesh with a colour at each vertex.
//!
//! Coordinates are those of the molecules' files in ångström, so that a file can be laid over the same molecule; STL is in millimetres.
//! Everything is written as it is made: memory goes into the scene and, for glTF, some 80 bytes for each ball, stick or ring.
//!
//! Limits: a GLB file has at most 4 GiB, a glTF file here at most 1 GiB of numbers; more is refused before anything is written.

mod gltf;
mod names;
mod obj;
mod pieces;
mod ply;
mod shape;
mod stl;
#[cfg(test)]
mod tests;

use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::structure::Structure;
use glam::DVec3;
use pieces::{Cutter, Frame, Piece, Surface};
use shape::{Meshes, UnitMesh};
use std::io;
use std::path::Path;

/// The error of the triangles where nothing is said, ångström. Chosen by looking at caffeine and crambin filling a screen: at 0.01 Å balls and sticks
/// have corners, at 0.004 Å one has to look for them.
pub const TOLERANCE: f32 = 0.004;
/// The least and the largest error, ångström (chosen: finer than a printer, or a picture of a thousand pixels an ångström, shows; and coarser
/// than any atom is large).
pub const TOLERANCES: std::ops::RangeInclusive<f32> = 1e-4..=1.0;
/// How long the longest side of an STL model is if nothing is said, in millimetres (chosen: it fits on any printer's bed).
pub const PRINTED_MM: f64 = 100.0;

/// A format of solid shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SolidFormat {
    /// glTF 2.0, binary.
    Glb,
    /// glTF 2.0 as JSON with its numbers inside.
    Gltf,
    /// Wavefront OBJ, with an MTL file beside it.
    Obj,
    /// Binary STL.
    Stl,
    /// Binary PLY.
    Ply,
}

impl SolidFormat {
    /// All of them.
    pub const ALL: [SolidFormat; 5] =
        [SolidFormat::Glb, SolidFormat::Gltf, SolidFormat::Obj, SolidFormat::Stl, SolidFormat::Ply];

    /// Its name, which is its extension, too.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            SolidFormat::Glb => "glb",
            SolidFormat::Gltf => "gltf",
            SolidFormat::Obj => "obj",
            SolidFormat::Stl => "stl",
            SolidFormat::Ply => "ply",
        }
    }

    /// By name, in any case.
    #[must_use]
    pub fn from_name(name: &str) -> Option<SolidFormat> {
        SolidFormat::ALL.into_iter().find(|format| format.name().eq_ignore_ascii_case(name))
    }

    /// By the extension of a file; `None` if that is of no such format.
    #[must_use]
    pub fn from_path(path: &Path) -> Option<SolidFormat> {
        SolidFormat::from_name(path.extension()?.to_str()?)
    }
}

/// What one unit of the written coordinates is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// Ångström.
    #[default]
    Angstrom,
    /// Nanometres.
    Nanometre,
    /// Metres, as glTF has it.
    Metre,
}

impl Unit {
    /// All of them.
    pub const ALL: [Unit; 3] = [Unit::Angstrom, Unit::Nanometre, Unit::Metre];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Unit::Angstrom => "angstrom",
            Unit::Nanometre => "nanometre",
            Unit::Metre => "metre",
        }
    }

    /// By name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Unit> {
        Unit::ALL.into_iter().find(|unit| unit.name() == name)
    }

    /// How many of it an ångström is.
    #[must_use]
    pub fn per_angstrom(self) -> f64 {
        match self {
            Unit::Angstrom => 1.0,
            Unit::Nanometre => 0.1,
            Unit::Metre => 1e-10,
        }
    }
}

/// Which coordinates are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coordinates {
    /// Those of the molecules' files.
    #[default]
    File,
    /// Turned as the picture shows it, +Y up, the middle at 0.
    Picture,
}

impl Coordinates {
    /// By name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Coordinates> {
        match name {
            "file" => Some(Coordinates::File),
            "picture" => Some(Coordinates::Picture),
            _ => None,
        }
    }
}

/// How solids are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidOptions {
    /// How far triangles may be from the surface they stand for, ångström. Default: [`TOLERANCE`].
    pub tolerance: f32,
    /// The unit; STL is in millimetres. Default: ångström, as overlays are read.
    pub unit: Unit,
    /// Plain meshes in glTF, for importers that know no instances. Default: false.
    pub compat: bool,
    /// Millimetres an ångström is long in STL. Default: `None`, the longest side is [`PRINTED_MM`].
    pub mm_per_angstrom: Option<f64>,
    /// Which coordinates. Default: the file's.
    pub coordinates: Coordinates,
}

impl Default for SolidOptions {
    fn default() -> Self {
        SolidOptions {
            tolerance: TOLERANCE,
            unit: Unit::default(),
            compat: false,
            mm_per_angstrom: None,
            coordinates: Coordinates::default(),
        }
    }
}

/// A structure that the scene was made of.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// What it is called: the name of its file.
    pub name: &'a str,
    /// The structure.
    pub structure: &'a Structure,
}

/// What was written.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Written {
    /// Triangles that are seen, instances counted one by one.
    pub triangles: u64,
    /// Of STL: millimetres an ångström is long.
    pub mm_per_angstrom: Option<f64>,
    /// Of STL: the diameter of its thinnest stick or ring, millimetres.
    pub thinnest_mm: Option<f64>,
}

/// Writes a scene; `sources` are the structures of [`Scene::items`] in their order.
///
/// # Errors
/// [`Error::Input`] if there is nothing in the scene, [`Error::Unsupported`] for what the format has no room for, [`Error::Io`] for what the system
/// refuses.
pub fn write(
    format: SolidFormat,
    scene: &Scene,
    sources: &[Source<'_>],
    options: &SolidOptions,
    path: &Path,
) -> Result<Written> {
    let model = Model { scene, sources, options, frame: Frame::new(scene, options.coordinates) };
    let totals = model.totals(format == SolidFormat::Stl)?;
    if totals.triangles == 0 {
        return Err(Error::input(None, "nothing is drawn, so there is nothing to write"));
    }
    match format {
        SolidFormat::Glb => gltf::write(&model, &totals, true, path)?,
        SolidFormat::Gltf => gltf::write(&model, &totals, false, path)?,
        SolidFormat::Obj => obj::write(&model, &totals, path)?,
        SolidFormat::Ply => ply::write(&model, &totals, path)?,
        SolidFormat::Stl => return stl::write(&model, &totals, path),
    }
    Ok(Written { triangles: totals.triangles, ..Written::default() })
}

/// What the writers get.
struct Model<'a> {
    scene: &'a Scene,
    sources: &'a [Source<'a>],
    options: &'a SolidOptions,
    frame: Frame,
}

/// How much there is of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Totals {
    vertices: u64,
    triangles: u64,
    /// The least diameter of a stick or ring, ångström; infinite if there is none.
    thinnest: f32,
}

impl Model<'_> {
    /// Every piece with its mesh and the number of its placement, in one fixed order.
    fn each_piece(
        &self,
        closed: bool,
        mut visit: impl FnMut(usize, &Piece, &UnitMesh) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut cutter = Cutter::new(self.options, closed);
        let mut meshes = Meshes::default();
        for (index, placement) in self.scene.placements.iter().enumerate() {
            cutter.placement(self.scene, (&self.frame, placement), |piece| {
                visit(index, &piece, meshes.of(piece.shape))
            })?;
        }
        Ok(())
    }

    /// Every surface that is laid over.
    fn each_surface(&self, mut visit: impl FnMut(usize, &Surface) -> io::Result<()>) -> io::Result<()> {
        for (index, placement) in self.scene.placements.iter().enumerate() {
            if !self.scene.blocks[placement.block].triangles.is_empty() {
                visit(index, &Surface::of(self.scene, &self.frame, placement))?;
            }
        }
        Ok(())
    }

    fn totals(&self, closed: bool) -> Result<Totals> {
        let mut totals = Totals { thinnest: f32::INFINITY, ..Totals::default() };
        let mut cutter = Cutter::new(self.options, closed);
        for placement in &self.scene.placements {
            cutter.placement(self.scene, (&self.frame, placement), |piece| {
                let [vertices, triangles] = piece.shape.counts();
                totals.vertices += vertices;
                totals.triangles += triangles;
                let radius = match piece.shape {
                    shape::Shape::Tube(..) => piece.scale.x,
                    shape::Shape::Ring(_, _, part) => piece.scale.x * f32::from(part) / 65535.0,
                    _ => f32::INFINITY,
                };
                totals.thinnest = totals.thinnest.min(2.0 * radius);
                Ok::<(), Error>(())
            })?;
        }
        self.each_surface(|_, surface| {
            totals.vertices += surface.positions.len() as u64;
            totals.triangles += surface.triangles.len() as u64;
            Ok(())
        })
        .map_err(|error| Error::Unsupported(error.to_string()))?;
        Ok(totals)
    }

    /// A point of the model as it is written.
    fn written(&self, point: glam::Vec3) -> DVec3 {
        (point.as_dvec3() + self.frame.origin) * self.options.unit.per_angstrom()
    }
}

/// A number of bytes as one reads it.
fn gibibytes(bytes: u64) -> String {
    format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30))
}
