//! Atoms that come column by column, as a binary file has them.

use super::super::positions::Points;
use super::StructureBuilder;
use crate::element::Element;
use crate::structure::NameId;

/// What a file says about its atoms beside names and residues, one value an atom in each column. A column that says the
/// same as none would (all of it the default) is left out by [`StructureBuilder::set_columns`].
#[derive(Debug, Default)]
pub(crate) struct AtomColumns {
    pub(crate) points: Points,
    pub(crate) element: Vec<Element>,
    /// `None` if the file numbers no atoms.
    pub(crate) serial: Option<Vec<i32>>,
    pub(crate) flags: Vec<u8>,
    pub(crate) altloc: Vec<u8>,
    pub(crate) occupancy: Vec<f32>,
    pub(crate) b_factor: Vec<f32>,
    pub(crate) formal_charge: Vec<i8>,
    pub(crate) isotope: Vec<u16>,
}

/// A column, or nothing where nothing else than the default stands in it.
fn unless_default<T: PartialEq>(column: Vec<T>, default: T) -> Vec<T> {
    if column.iter().all(|value| *value == default) { Vec::new() } else { column }
}

impl StructureBuilder {
    /// Adds a residue and the names of its atoms, as ids of this builder's, to a builder whose atoms come last, by
    /// [`StructureBuilder::set_columns`].
    pub(crate) fn push_residue_names(
        &mut self,
        (chain, number, insertion_code, name): (&str, i32, u8, &str),
        atoms: usize,
        mut atom_name: impl FnMut(&mut StructureBuilder, usize) -> NameId,
    ) {
        let first = self.residue_of_atom.len();
        let index = u32::try_from(self.residues.len()).unwrap_or(u32::MAX);
        self.begin_residue_at(first, chain, number, insertion_code, name);
        self.residue_of_atom.resize(first + atoms, index);
        self.atom_name.reserve(atoms);
        for atom in 0..atoms {
            let name = atom_name(self, atom);
            self.atom_name.push(name);
        }
    }

    /// Gives the atoms, whose residues and names are there, all the rest.
    pub(crate) fn set_columns(&mut self, columns: AtomColumns) {
        let counted = |index: usize| i32::try_from(index + 1).unwrap_or(i32::MAX);
        let is_counted =
            |serials: &Vec<i32>| serials.iter().enumerate().all(|(index, &serial)| serial == counted(index));
        self.states_serials = columns.serial.is_some();
        self.serial = columns.serial.filter(|serials| !is_counted(serials)).unwrap_or_default();
        self.atom_name = unless_default(std::mem::take(&mut self.atom_name), NameId::default());
        self.points = columns.points;
        self.element = columns.element;
        self.flags = unless_default(columns.flags, 0);
        self.altloc = unless_default(columns.altloc, b' ');
        self.occupancy = unless_default(columns.occupancy, 1.0);
        self.b_factor = unless_default(columns.b_factor, 0.0);
        self.formal_charge = unless_default(columns.formal_charge, 0);
        self.isotope = unless_default(columns.isotope, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, Diagnostics};
    use glam::DVec3;

    #[test]
    fn atoms_by_column_are_atoms_one_by_one() {
        for odd in [false, true] {
            let record = |n: usize| AtomRecord {
                element: [Element::N, Element::C][n % 2],
                position: DVec3::splat(n as f64),
                name: ["N", "CA"][n % 2],
                serial: Some(n as i32 + 1 + i32::from(odd)),
                occupancy: if odd && n == 3 { 0.5 } else { 1.0 },
                formal_charge: i8::from(odd && n == 1),
                ..AtomRecord::default()
            };
            let mut one_by_one = StructureBuilder::new();
            for n in 0..6 {
                if n % 3 == 0 {
                    one_by_one.begin_residue("A", n as i32, b' ', "GLY");
                }
                one_by_one.push_residue_atom(&record(n));
            }
            let mut by_column = StructureBuilder::new();
            for first in [0, 3] {
                let name = |builder: &mut StructureBuilder, n: usize| {
                    let text = record(first + n).name;
                    builder.name_id(text.as_bytes())
                };
                by_column.push_residue_names(("A", first as i32, b' ', "GLY"), 3, name);
            }
            let mut points = Points::default();
            (0..6).for_each(|n| points.push(record(n).position));
            by_column.set_columns(AtomColumns {
                points,
                element: (0..6).map(|n| record(n).element).collect(),
                serial: Some((0..6).filter_map(|n| record(n).serial).collect()),
                flags: vec![0; 6],
                altloc: vec![b' '; 6],
                occupancy: (0..6).map(|n| record(n).occupancy).collect(),
                b_factor: vec![0.0; 6],
                formal_charge: (0..6).map(|n| record(n).formal_charge).collect(),
                isotope: vec![0; 6],
            });
            let [by_column, one_by_one] = [by_column, one_by_one].map(|b| b.build(&mut Diagnostics::default()));
            assert_eq!(by_column, one_by_one);
            assert_eq!(by_column.serial.is_empty(), !odd);
        }
    }
}
