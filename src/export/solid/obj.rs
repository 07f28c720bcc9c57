//! Wavefront OBJ, and an MTL file of the same name beside it with one material for every colour.
//!
//! An object (`o`) for every molecule and overlay, a group (`g`) for every residue, as in `A_GLY_12`, else for every kind of primitive. Overlays have the
//! colours of their vertices as six numbers behind `v`, which many programs read; then all vertices have, since some read them only so. The MTL file is written when the OBJ file is whole
//! and only its name is missing, so that a run that fails leaves both as they were. One that another program wrote is not replaced: its name was not
//! given, and other OBJ files may need it. To standard output goes the OBJ alone.

use super::pieces::Piece;
use super::{Model, Totals, names};
use crate::color::Srgb8;
use crate::error::Result;
use crate::export::atomic;
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// Digits behind the point for ångström: a tenth of the least error.
const DECIMALS: i32 = 5;

pub(super) fn write(model: &Model<'_>, totals: &Totals, path: &Path) -> Result<()> {
    let library = library_of(path);
    let name = library.as_deref().map(one_line).transpose()?;
    if let Some(library) = &library {
        check_library(library)?;
    }
    let unit = model.options.unit;
    let decimals = (DECIMALS - unit.per_angstrom().log10().round() as i32).max(0) as usize;
    let materials = materials(model).map_err(|error| crate::Error::Unsupported(error.to_string()))?;
    // Why the library could not be written: the error names it, not the OBJ.
    let mut of_library = None;
    let written = atomic::write(path, |out| {
        writeln!(
            out,
            "# ballstick: {} vertices, {} triangles; unit {}",
            totals.vertices,
            totals.triangles,
            unit.name()
        )?;
        if let Some(name) = name {
            writeln!(out, "mtllib {name}")?;
        }
        let mut has_surface = false;
        model.each_surface(|_, _| {
            has_surface = true;
            Ok(())
        })?;
        let mut writer = Writer { out: &mut *out, model, decimals, next: 1, object: None, group: None, material: None };
        model.each_piece(false, |placement, piece, mesh| {
            writer.head(placement, || group(model, placement, piece))?;
            writer.material(&material_name(piece.color))?;
            for &position in &mesh.positions {
                writer.vertex(piece.point(position), has_surface.then_some(piece.color))?;
            }
            for &normal in &mesh.normals {
                writer.normal(piece.normal(normal))?;
            }
            writer.faces(&mesh.triangles)?;
            writer.next += mesh.positions.len() as u64;
            Ok(())
        })?;
        model.each_surface(|placement, surface| {
            writer.head(placement, || "surface".to_owned())?;
            for (&position, &color) in surface.positions.iter().zip(&surface.colors) {
                writer.vertex(position, Some(color))?;
            }
            for &normal in &surface.normals {
                writer.normal(normal)?;
            }
            for triangle in &surface.triangles {
                let color = surface.colors[triangle[0] as usize];
                writer.material(&surface_material(placement, color.a))?;
                writer.faces(std::slice::from_ref(triangle))?;
            }
            writer.next += surface.positions.len() as u64;
            Ok(())
        })?;
        let Some(library) = &library else { return Ok(()) };
        // All of the OBJ is on the disk, and only its name is missing: now or never.
        out.flush()?;
        write_library(&materials, library).map_err(|error| {
            of_library = Some(error);
            io::ErrorKind::Other.into()
        })
    });
    match of_library {
        Some(error) => Err(error),
        None => written,
    }
}

/// The MTL file of an OBJ file; none of one that goes to a stream.
fn library_of(path: &Path) -> Option<PathBuf> {
    let has_name = !atomic::is_stdout(path) && !path.starts_with("/dev");
    has_name.then(|| path.with_extension("mtl"))
}

/// The name of the library as the OBJ file says it: in one line of UTF-8.
fn one_line(library: &Path) -> Result<&str> {
    let name = library.file_name().and_then(|name| name.to_str()).filter(|name| !name.contains(char::is_control));
    name.ok_or_else(|| {
        crate::Error::Unsupported(format!(
            "{}: an OBJ file cannot name its MTL file so; choose a name of letters that can be printed",
            library.display()
        ))
    })
}

/// Begins every MTL file that is written here.
const LIBRARY_MARK: &str = "# ballstick";

/// Refuses to replace an MTL file of another program: nobody has named it.
fn check_library(library: &Path) -> Result<()> {
    let mut begin = [0; LIBRARY_MARK.len()];
    let is_file = std::fs::metadata(library).is_ok_and(|metadata| metadata.is_file());
    let Some(mut file) = is_file.then(|| std::fs::File::open(library).ok()).flatten() else { return Ok(()) };
    if file.read_exact(&mut begin).is_ok() && begin == *LIBRARY_MARK.as_bytes() {
        return Ok(());
    }
    Err(crate::Error::Unsupported(format!(
        "{} is there, and ballstick did not write it; the colours of the OBJ file go there: give the OBJ another name, or move that file away",
        library.display()
    )))
}

fn write_library(materials: &BTreeMap<String, Srgb8>, library: &Path) -> Result<()> {
    atomic::write(library, |out| {
        writeln!(out, "{LIBRARY_MARK}: colours are sRGB")?;
        for (name, color) in materials {
            let [r, g, b, a] = [color.r, color.g, color.b, color.a].map(|byte| f64::from(byte) / 255.0);
            writeln!(out, "newmtl {name}\nKd {r:.4} {g:.4} {b:.4}\nKs 0.2 0.2 0.2\nNs 40\nd {a:.4}\nillum 2")?;
        }
        Ok(())
    })
}

/// Every colour by the name of its material.
fn materials(model: &Model<'_>) -> io::Result<BTreeMap<String, Srgb8>> {
    let mut materials = BTreeMap::new();
    model.each_piece(false, |_, piece, _| {
        materials.entry(material_name(piece.color)).or_insert(piece.color);
        Ok(())
    })?;
    model.each_surface(|placement, surface| {
        // For programs that do not read the colours of vertices: one that is in it.
        for color in &surface.colors {
            materials.entry(surface_material(placement, color.a)).or_insert(*color);
        }
        Ok(())
    })?;
    Ok(materials)
}

fn material_name(Srgb8 { r, g, b, a }: Srgb8) -> String {
    if a == 255 { format!("color_{r:02x}{g:02x}{b:02x}") } else { format!("color_{r:02x}{g:02x}{b:02x}{a:02x}") }
}

fn surface_material(placement: usize, alpha: u8) -> String {
    format!("surface_{}_{alpha:02x}", placement + 1)
}

fn group(model: &Model<'_>, placement: usize, piece: &Piece) -> String {
    let named = model.source(placement).and_then(|source| {
        let atom = names::atom_of(source.structure, piece.id)?;
        names::residue_name(source.structure, atom)
    });
    named.unwrap_or_else(|| piece.kind.name().to_owned())
}

struct Writer<'a, 'm> {
    out: &'a mut dyn Write,
    model: &'m Model<'m>,
    decimals: usize,
    /// The number of the next vertex and normal, from 1.
    next: u64,
    object: Option<usize>,
    group: Option<String>,
    material: Option<String>,
}

impl Writer<'_, '_> {
    /// Object and group, where they are others than before.
    fn head(&mut self, placement: usize, group: impl FnOnce() -> String) -> io::Result<()> {
        if self.object != Some(placement) {
            writeln!(self.out, "o {}", one_word(&self.model.placement_name(placement)))?;
            self.object = Some(placement);
            self.group = None;
        }
        let group = one_word(&group());
        if self.group.as_ref() != Some(&group) {
            writeln!(self.out, "g {group}")?;
            self.group = Some(group);
        }
        Ok(())
    }

    fn material(&mut self, name: &str) -> io::Result<()> {
        if self.material.as_deref() != Some(name) {
            writeln!(self.out, "usemtl {name}")?;
            self.material = Some(name.to_owned());
        }
        Ok(())
    }

    fn vertex(&mut self, point: Vec3, color: Option<Srgb8>) -> io::Result<()> {
        let DVec3 { x, y, z } = self.model.written(point);
        write!(self.out, "v {x:.0$} {y:.0$} {z:.0$}", self.decimals)?;
        if let Some(color) = color {
            let [r, g, b] = [color.r, color.g, color.b].map(|byte| f64::from(byte) / 255.0);
            write!(self.out, " {r:.4} {g:.4} {b:.4}")?;
        }
        writeln!(self.out)
    }

    fn normal(&mut self, normal: Vec3) -> io::Result<()> {
        writeln!(self.out, "vn {:.4} {:.4} {:.4}", normal.x, normal.y, normal.z)
    }

    fn faces(&mut self, triangles: &[[u32; 3]]) -> io::Result<()> {
        for triangle in triangles {
            let [a, b, c] = triangle.map(|vertex| self.next + u64::from(vertex));
            writeln!(self.out, "f {a}//{a} {b}//{b} {c}//{c}")?;
        }
        Ok(())
    }
}

/// Names in the format end at a blank.
fn one_word(text: &str) -> String {
    let word: String = text.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect();
    if word.is_empty() { "_".to_owned() } else { word }
}
