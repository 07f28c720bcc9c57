//! Symmetry: the content of a whole cell from the asymmetric unit that a file lists.

use super::{Bond, Cell, Structure, SymmetryOperation, atom_flags};
use crate::error::{Error, Result};
use glam::DVec3;
use std::collections::{HashMap, HashSet};

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
    let images = images(operations, &cell, &listed);
    let layers = alternatives(&structure, operations, &cell, &listed);
    let bonds = stated_bonds(structure.bonds(), operations, &cell, &images);
    let from_fractional = cell.cartesian_from_fractional();
    let sources: Vec<(u32, DVec3)> = (images.iter().enumerate())
        .map(|(index, &Image { atom, at, .. })| {
            // The listed atoms keep their digits.
            let point = if index < listed.len() { structure.positions().get(index) } else { from_fractional * at };
            (atom, point)
        })
        .collect();
    let mut whole = structure.gather(&sources, Some(cell)).with_bonds(bonds);
    whole.stated_bonds = structure.stated_bonds();
    if layers.iter().any(|&layer| layer > 0) {
        let code = |index: usize| {
            let is_disordered = whole.flags(index) & atom_flags::SYMMETRY_DISORDER != 0;
            match images[index].operation.map_or(0, |number| layers[number]) {
                layer if layer > 0 && is_disordered => b'a' + (layer - 1).min(25),
                _ => whole.altloc(index),
            }
        };
        let codes = (0..whole.atom_count()).map(code).collect();
        whole = whole.with_altlocs(codes);
    }
    Ok((whole, Some(images.into_iter().map(|image| image.atom).collect())))
}

/// An atom's image under an operation, or the atom itself.
#[derive(Debug, Clone, Copy)]
struct Image {
    atom: u32,
    /// Fractional coordinates.
    at: DVec3,
    /// `None` for the atom as listed.
    operation: Option<usize>,
}

/// The listed atoms, then the distinct images of them operation by operation, so that the atoms of a residue stay together.
fn images(operations: &[SymmetryOperation], cell: &Cell, listed: &[DVec3]) -> Vec<Image> {
    let mut images = Vec::with_capacity(listed.len().saturating_mul(operations.len()));
    images.extend((0u32..).zip(listed).map(|(atom, &at)| Image { atom, at, operation: None }));
    let mut places = Vec::with_capacity(operations.len() + 1);
    for (atom, &at) in (0u32..).zip(listed) {
        places.clear();
        places.push(at);
        for (number, operation) in operations.iter().enumerate() {
            let image = operation.apply(at);
            if places.iter().all(|&place| nearest(cell, place, image) > SAME) {
                places.push(image);
                images.push(Image { atom, at: image, operation: Some(number) });
            }
        }
    }
    images.sort_by_key(|image| image.operation);
    images
}

/// The bonds that the file states between the listed atoms, among all images.
fn stated_bonds(bonds: &[Bond], operations: &[SymmetryOperation], cell: &Cell, images: &[Image]) -> Vec<Bond> {
    if bonds.is_empty() {
        return Vec::new();
    }
    let bonded: HashSet<u32> = bonds.iter().flat_map(|bond| [bond.a, bond.b]).collect();
    let mut places: HashMap<u32, Vec<(u32, DVec3)>> = HashMap::new();
    for (index, image) in (0u32..).zip(images).filter(|(_, image)| bonded.contains(&image.atom)) {
        places.entry(image.atom).or_default().push((index, image.at));
    }
    // Where an image of an atom is: as which of all images, and how many cells from it.
    let place = |atom: u32, at: DVec3| {
        let found = places.get(&atom)?.iter().find(|(_, place)| nearest(cell, *place, at) <= SAME)?;
        Some((found.0, (at - found.1).round()))
    };
    let mut out = bonds.to_vec();
    for operation in operations {
        let copy = |bond: &Bond| {
            let [a, b] = [bond.a, bond.b].map(|atom| Some(operation.apply(places.get(&atom)?.first()?.1)));
            let ((a, a_cell), (b, b_cell)) = (place(bond.a, a?)?, place(bond.b, b?)?);
            let over = operation.rotation * DVec3::from_array(bond.image.map(f64::from));
            let [x, y, z] = (over + b_cell - a_cell).round().to_array();
            // Beyond the range of an i8 there is no bond.
            let image = [x, y, z].map(|step| (step.abs() <= 127.0).then_some(step as i8));
            Some(Bond { a, b, image: [image[0]?, image[1]?, image[2]?], ..*bond })
        };
        out.extend(bonds.iter().filter_map(copy));
    }
    out
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
