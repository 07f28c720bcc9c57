//! Symmetry: the content of a whole cell from the asymmetric unit that a file lists.

use super::{Cell, Structure, SymmetryOperation, atom_flags};
use crate::error::{Error, Result};
use glam::DVec3;

/// Images of one atom nearer than this are one atom on a special position, ångström. Coordinates are good to 0.01 Å;
/// the nearest true neighbours are 0.74 Å apart (H₂).
const SAME: f64 = 0.3;
/// Images of a group that is disordered about a special position are alternatives where atoms come nearer than this,
/// ångström: no bond is shorter but those of hydrogen, whose atoms then overlap as well.
const OVERLAP: f64 = 0.95;

/// The structure with all atoms of the cell and without symmetry, the listed atoms first and where they were, and which
/// listed atom each one is; the structure as it is, and `None`, if nothing but the identity is known.
///
/// # Errors
/// [`Error::Limit`] if that would be more than `most_atoms`.
pub(crate) fn apply_symmetry(structure: Structure, most_atoms: usize) -> Result<(Structure, Option<Vec<u32>>)> {
    let operations = structure.symmetry().map_or(&[][..], |symmetry| &symmetry.operations);
    let Some(&cell) = structure.cell().filter(|_| operations.len() > 1) else { return Ok((structure, None)) };
    if structure.atom_count().saturating_mul(operations.len()) > most_atoms {
        let message = format!("the content of the cell would be more than {most_atoms} atoms; use --cell asym");
        return Err(Error::limit(None, message));
    }
    let to_fractional = cell.fractional_from_cartesian();
    let listed: Vec<DVec3> =
        (0..structure.atom_count()).map(|atom| to_fractional * structure.positions().get(atom)).collect();
    let mut images: Vec<(u32, DVec3)> = listed.iter().enumerate().map(|(atom, &at)| (atom as u32, at)).collect();
    let mut operation_of = vec![0usize; listed.len()];
    for (atom, &at) in listed.iter().enumerate() {
        let mut places = vec![at];
        for (number, operation) in operations.iter().enumerate() {
            let image = operation.apply(at);
            let image = image - image.floor();
            if places.iter().all(|&place| nearest(&cell, place, image) > SAME) {
                places.push(image);
                images.push((atom as u32, image));
                operation_of.push(number);
            }
        }
    }
    let layers = alternatives(&structure, operations, &cell, &listed);
    let from_fractional = cell.cartesian_from_fractional();
    let sources: Vec<(u32, DVec3)> = (images.iter().enumerate())
        .map(|(index, &(atom, at))| {
            // The listed atoms keep their digits.
            let point = if index < listed.len() { structure.positions().get(index) } else { from_fractional * at };
            (atom, point)
        })
        .collect();
    let mut whole = structure.gather(&sources, Some(cell));
    if layers.iter().any(|&layer| layer > 0) {
        let code = |index: usize| {
            let is_disordered = whole.flags(index) & atom_flags::SYMMETRY_DISORDER != 0;
            match layers[operation_of[index]] {
                layer if layer > 0 && is_disordered => b'a' + (layer - 1).min(25),
                _ => whole.altloc(index),
            }
        };
        let codes = (0..whole.atom_count()).map(code).collect();
        whole = whole.with_altlocs(codes);
    }
    Ok((whole, Some(images.into_iter().map(|(atom, _)| atom).collect())))
}

/// For each operation, which of the alternatives of the disordered groups it makes: 0 where its images are clear of those of
/// all earlier operations in 0, else the first that they are clear of.
fn alternatives(structure: &Structure, operations: &[SymmetryOperation], cell: &Cell, listed: &[DVec3]) -> Vec<u8> {
    let is_disordered = |atom: usize| structure.flags(atom) & atom_flags::SYMMETRY_DISORDER != 0;
    let group: Vec<DVec3> = (0..listed.len()).filter(|&atom| is_disordered(atom)).map(|atom| listed[atom]).collect();
    let mut layers: Vec<u8> = Vec::with_capacity(operations.len());
    for (number, operation) in operations.iter().enumerate() {
        let overlaps = |earlier: &SymmetryOperation| {
            group.iter().any(|&a| group.iter().any(|&b| nearest(cell, operation.apply(a), earlier.apply(b)) < OVERLAP))
        };
        let taken: Vec<u8> = (0..number).filter(|&earlier| overlaps(&operations[earlier])).map(|e| layers[e]).collect();
        layers.push((0..=u8::MAX).find(|layer| !taken.contains(layer)).unwrap_or(u8::MAX));
    }
    layers
}

/// Distance between a point and the nearest image of another, fractional coordinates to ångström, for distances small
/// beside the cell.
fn nearest(cell: &Cell, a: DVec3, b: DVec3) -> f64 {
    let difference = a - b;
    (cell.cartesian_from_fractional() * (difference - difference.round())).length()
}
