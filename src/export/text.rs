//! What the writers of text formats share: one-line titles, names for atoms without, positions as text, cells.

use super::tidy;
use crate::element::Element;
use crate::structure::{Bond, BondKind, Cell, Frame, Positions, Structure};
use glam::DVec3;
use std::io;

/// The text on one line, without blanks around.
pub(super) fn one_line(text: &str) -> String {
    text.split(|c: char| c.is_control()).collect::<Vec<_>>().join(" ").trim().to_owned()
}

/// The title of a frame, or else, where frames have none of their own, of its structure, on one line.
pub(super) fn frame_title(structure: &Structure, frame: &Frame) -> String {
    let own = structure.frames().first().is_some_and(|first| !first.title.is_empty());
    one_line(if own || !frame.title.is_empty() { &frame.title } else { structure.title() })
}

/// Names of all atoms; those without one get their element's symbol and a number, counted by element.
pub(super) struct AtomNames<'a> {
    structure: &'a Structure,
    counts: [u32; 256],
}

impl<'a> AtomNames<'a> {
    pub(super) fn new(structure: &'a Structure) -> AtomNames<'a> {
        AtomNames { structure, counts: [0; 256] }
    }

    /// The name of an atom; to be asked in their order.
    pub(super) fn next(&mut self, atom: usize) -> String {
        let element = self.structure.elements()[atom];
        let count = &mut self.counts[usize::from(element.z())];
        *count += 1;
        match self.structure.atom_name(atom) {
            "" => format!("{}{count}", element.symbol()),
            name => name.split(|c: char| c.is_whitespace() || c.is_control()).collect::<Vec<_>>().join("_"),
        }
    }
}

/// One position as text with the file's digits, no `-0`.
pub(super) struct Position {
    point: DVec3,
    decimals: u8,
}

impl Position {
    /// # Errors
    /// `InvalidData` for what is not a number.
    pub(super) fn new(positions: &Positions, atom: usize) -> io::Result<Position> {
        let point = positions.written(atom) + 0.0;
        if !point.is_finite() {
            return Err(invalid(format!("the position of atom {} is not a number", atom + 1)));
        }
        Ok(Position { point, decimals: positions.decimals() })
    }

    pub(super) fn point(&self) -> DVec3 {
        self.point
    }

    /// The three numbers, each with at least `at_least` decimals.
    pub(super) fn numbers(&self, at_least: u8) -> [String; 3] {
        self.point.to_array().map(|x| match self.decimals {
            Positions::MAX_DECIMALS => x.to_string(),
            decimals => format!("{x:.*}", usize::from(decimals.max(at_least))),
        })
    }
}

pub(super) fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message)
}

/// The bonds that a format without hydrogen bonds and periodic images writes.
pub(super) fn plain_bonds(structure: &Structure) -> impl Iterator<Item = &Bond> {
    structure.bonds().iter().filter(|bond| !bond.is_periodic() && bond.kind != BondKind::Hydrogen)
}

/// Whether one of the atoms of a bond is a metal.
pub(super) fn metals(structure: &Structure, bond: &Bond) -> usize {
    [bond.a, bond.b].iter().filter(|&&atom| structure.elements()[atom as usize].is_metal()).count()
}

/// The symbol, `D` and `T` for hydrogen's isotopes.
pub(super) fn symbol_with_isotope(structure: &Structure, atom: usize) -> &'static str {
    match (structure.elements()[atom], structure.isotope(atom)) {
        (Element::H, 2) => "D",
        (Element::H, 3) => "T",
        (element, _) => element.symbol(),
    }
}

/// Lengths and angles, without the rounding errors of their way through vectors.
pub(super) fn parameters(cell: &Cell) -> ([f64; 3], [f64; 3]) {
    (cell.lengths().map(tidy), cell.angles_deg().map(tidy))
}

/// Whether the vectors of a cell are those that lengths and angles give, to 1e-9 of the longest edge.
pub(super) fn is_standard(cell: &Cell) -> bool {
    let (lengths, angles) = parameters(cell);
    let tolerance = 1e-9 * lengths.into_iter().fold(0.0, f64::max);
    Cell::from_parameters(lengths, angles).is_some_and(|standard| {
        standard.vectors().iter().zip(cell.vectors()).all(|(&a, b)| (a - b).abs().max_element() <= tolerance)
    })
}

/// Whether a number is written whole with so many decimals.
pub(super) fn fits_decimals(value: f64, decimals: i32) -> bool {
    let scale = 10f64.powi(decimals);
    ((value * scale).round() / scale - value).abs() <= 1e-9 * value.abs().max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, Diagnostics, StructureBuilder};

    #[test]
    fn atoms_without_names_are_counted_by_element() {
        let mut builder = StructureBuilder::new();
        for (element, name) in [(Element::C, ""), (Element::O, ""), (Element::C, "A B"), (Element::C, "")] {
            builder.push_atom(&AtomRecord { element, name, ..AtomRecord::default() });
        }
        let structure = builder.build(&mut Diagnostics::default());
        let mut names = AtomNames::new(&structure);
        assert_eq!([0, 1, 2, 3].map(|atom| names.next(atom)), ["C1", "O1", "A_B", "C3"]);
    }

    #[test]
    fn cells_that_are_turned_are_not_standard() {
        let cell = Cell::from_parameters([4.0, 5.5, 6.0], [80.0, 95.0, 110.0]).unwrap();
        assert!(is_standard(&cell));
        let [a, b, c] = cell.vectors();
        assert!(!is_standard(&Cell::from_vectors(b, c, a).unwrap()));
        assert!(fits_decimals(1.25, 2) && !fits_decimals(1.255, 2));
    }
}
