//! Binary STL (3D Systems, 1989) for printing: millimetres, every primitive a closed shell that faces outwards.
//!
//! The lowest corner is at 0, as the format asks for positive coordinates. Shells overlap and are not united; overlays are written as they are,
//! closed or not. The two bytes for attributes are 0.

use super::{Model, PRINTED_MM, Totals, Written};
use crate::error::{Error, Result};
use crate::export::atomic;
use glam::{DVec3, Vec3};
use std::io::{self, Write};
use std::path::Path;

pub(super) fn write(model: &Model<'_>, totals: &Totals, path: &Path) -> Result<Written> {
    let count = u32::try_from(totals.triangles).map_err(|_| {
        let message = format!(
            "STL has at most {} triangles, and these are {}; a larger --tolerance makes fewer",
            u32::MAX,
            totals.triangles
        );
        Error::Unsupported(message)
    })?;
    let (low, high) = bounds(model).map_err(|error| Error::Unsupported(error.to_string()))?;
    let longest = (high - low).max_element();
    let scale = model.options.mm_per_angstrom.unwrap_or_else(|| PRINTED_MM / longest.max(1e-3));
    atomic::write(path, |out| {
        let mut header = [b' '; 80];
        let text = b"ballstick, millimetres";
        header[..text.len()].copy_from_slice(text);
        out.write_all(&header)?;
        out.write_all(&count.to_le_bytes())?;
        let place = |point: Vec3| ((point.as_dvec3() - low) * scale).as_vec3();
        let mut points = Vec::new();
        model.each_piece(true, |_, piece, mesh| {
            piece.points(mesh, &mut points);
            points.iter_mut().for_each(|point| *point = place(*point));
            mesh.triangles.iter().try_for_each(|corners| triangle(out, corners.map(|corner| points[corner as usize])))
        })?;
        model.each_surface(|_, surface| {
            let corner = |vertex: u32| place(surface.positions[vertex as usize]);
            surface.triangles.iter().try_for_each(|corners| triangle(out, corners.map(corner)))
        })
    })?;
    Ok(Written {
        triangles: totals.triangles,
        mm_per_angstrom: Some(scale),
        thinnest_mm: totals.thinnest.is_finite().then(|| f64::from(totals.thinnest) * scale),
    })
}

fn triangle(out: &mut dyn Write, corners: [Vec3; 3]) -> io::Result<()> {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let mut bytes = [0; 50];
    for (slot, x) in bytes.chunks_exact_mut(4).zip([normal, a, b, c].map(|v| v.to_array()).as_flattened()) {
        slot.copy_from_slice(&x.to_le_bytes());
    }
    out.write_all(&bytes)
}

/// The box around what is written, in the model.
fn bounds(model: &Model<'_>) -> io::Result<(DVec3, DVec3)> {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let mut points = Vec::new();
    model.each_piece(true, |_, piece, mesh| {
        piece.points(mesh, &mut points);
        for point in &points {
            (low, high) = (low.min(*point), high.max(*point));
        }
        Ok(())
    })?;
    model.each_surface(|_, surface| {
        for point in &surface.positions {
            (low, high) = (low.min(*point), high.max(*point));
        }
        Ok(())
    })?;
    Ok((low.as_dvec3(), high.as_dvec3()))
}
