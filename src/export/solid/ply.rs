//! Binary PLY (Turk, 1994), little-endian: one mesh with normal, colour and opacity at every vertex.

use super::{Model, Totals};
use crate::color::Srgb8;
use crate::error::{Error, Result};
use crate::export::atomic;
use glam::{DVec3, Vec3};
use std::io::{self, Write};
use std::path::Path;

pub(super) fn write(model: &Model<'_>, totals: &Totals, path: &Path) -> Result<()> {
    let [vertices, triangles] = [totals.vertices, totals.triangles];
    // Its indices are whole numbers with a sign.
    if vertices.max(triangles) > i32::MAX as u64 {
        let message = format!(
            "PLY has at most {} vertices, and these are {vertices}; a larger --tolerance makes fewer",
            i32::MAX
        );
        return Err(Error::Unsupported(message));
    }
    atomic::write(path, |out| {
        writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment ballstick")?;
        writeln!(out, "comment unit {}", model.options.unit.name())?;
        writeln!(out, "element vertex {vertices}")?;
        for name in ["x", "y", "z", "nx", "ny", "nz"] {
            writeln!(out, "property float {name}")?;
        }
        for name in ["red", "green", "blue", "alpha"] {
            writeln!(out, "property uchar {name}")?;
        }
        writeln!(out, "element face {triangles}\nproperty list uchar int vertex_indices\nend_header")?;
        model.each_piece(false, |_, piece, mesh| {
            for (&position, &normal) in mesh.positions.iter().zip(&mesh.normals) {
                vertex(out, model.written(piece.point(position)), piece.normal(normal), piece.color)?;
            }
            Ok(())
        })?;
        model.each_surface(|_, surface| {
            for ((&position, &normal), &color) in surface.positions.iter().zip(&surface.normals).zip(&surface.colors) {
                vertex(out, model.written(position), normal, color)?;
            }
            Ok(())
        })?;
        let mut first = 0u32;
        model.each_piece(false, |_, _, mesh| faces(out, &mesh.triangles, mesh.positions.len(), &mut first))?;
        model.each_surface(|_, surface| faces(out, &surface.triangles, surface.positions.len(), &mut first))
    })
}

fn vertex(out: &mut dyn Write, position: DVec3, normal: Vec3, color: Srgb8) -> io::Result<()> {
    let mut bytes = [0; 28];
    let numbers = [position.as_vec3(), normal].map(|v| v.to_array());
    for (slot, x) in bytes.chunks_exact_mut(4).zip(numbers.as_flattened()) {
        slot.copy_from_slice(&x.to_le_bytes());
    }
    bytes[24..].copy_from_slice(&[color.r, color.g, color.b, color.a]);
    out.write_all(&bytes)
}

fn faces(out: &mut dyn Write, triangles: &[[u32; 3]], vertices: usize, first: &mut u32) -> io::Result<()> {
    for triangle in triangles {
        let mut bytes = [3; 13];
        for (slot, vertex) in bytes[1..].chunks_exact_mut(4).zip(triangle) {
            slot.copy_from_slice(&(*first + vertex).to_le_bytes());
        }
        out.write_all(&bytes)?;
    }
    *first += vertices as u32;
    Ok(())
}
