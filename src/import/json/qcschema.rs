//! QCSchema: the molecules of MolSSI's quantum chemistry schema, in bohr.
//!
//! Read are a molecule by itself and the one inside an input or result (`molecule`, `final_molecule` of an optimisation
//! before its `initial_molecule`, `input_data.molecule`): `symbols`, `geometry` (flat or by atoms), `connectivity`
//! ([i, j, order], from 0; 1.5 is aromatic), `real` (false for ghost atoms, kept as particles), `mass_numbers`,
//! `atom_labels`, `molecular_charge` and `molecular_multiplicity` (as data fields), `name`. Other keys are passed over.
//!
//! Mass numbers that say no more than the natural mixture (programs fill in the commonest isotope) are left out.

use super::super::symbol::{LabelKind, read_label};
use super::super::{ANGSTROM_PER_BOHR, is_plausible};
use super::{PairBond, bond_of_order, push_pairs};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::structure::{AtomRecord, Diagnostics, Positions, StatedBonds, StructureBuilder, atom_flags};
use glam::DVec3;
use serde::Deserialize;

/// An input or a result.
#[derive(Deserialize)]
pub(super) struct Root {
    molecule: Option<Molecule>,
    final_molecule: Option<Molecule>,
    initial_molecule: Option<Molecule>,
    input_data: Option<Input>,
}

#[derive(Deserialize)]
struct Input {
    molecule: Option<Molecule>,
    initial_molecule: Option<Molecule>,
}

#[derive(Deserialize)]
pub(super) struct Molecule {
    #[serde(default)]
    symbols: Vec<String>,
    #[serde(default)]
    geometry: Vec<Coordinates>,
    connectivity: Option<Vec<(i64, i64, f64)>>,
    real: Option<Vec<bool>>,
    mass_numbers: Option<Vec<i64>>,
    atom_labels: Option<Vec<String>>,
    molecular_charge: Option<f64>,
    molecular_multiplicity: Option<f64>,
    name: Option<String>,
}

/// One coordinate, or those of an atom.
#[derive(Deserialize)]
#[serde(untagged)]
enum Coordinates {
    One(f64),
    Atom([f64; 3]),
}

impl Root {
    pub(super) fn build(self, diagnostics: &mut Diagnostics) -> Result<StructureBuilder> {
        let of_input = self.input_data.and_then(|input| input.molecule.or(input.initial_molecule));
        match self.molecule.or(self.final_molecule).or(self.initial_molecule).or(of_input) {
            Some(molecule) => molecule.build(diagnostics),
            None => Err(Error::input(None, "the QCSchema file has no `molecule`")),
        }
    }
}

impl Molecule {
    pub(super) fn build(self, diagnostics: &mut Diagnostics) -> Result<StructureBuilder> {
        let count = self.symbols.len();
        if count == 0 {
            return Err(Error::input(None, "the QCSchema molecule has no `symbols`"));
        }
        let mut numbers = Vec::with_capacity(3 * count);
        for item in self.geometry {
            match item {
                Coordinates::One(number) => numbers.push(number),
                Coordinates::Atom(point) => numbers.extend(point),
            }
        }
        if numbers.len() != 3 * count {
            let found = numbers.len();
            let message = format!("`geometry` holds {found} numbers; {count} symbols need {}", 3 * count);
            return Err(Error::input(None, message));
        }
        let mut builder = StructureBuilder::new();
        builder.set_decimals(Positions::MAX_DECIMALS); // computed numbers have all digits
        let mut fits = |length: Option<usize>, what: &str| {
            if let Some(found) = length.filter(|&length| length != count) {
                diagnostics.warn(None, format!("`{what}` has {found} values for {count} atoms and is ignored"));
            }
            length == Some(count)
        };
        let has_real = fits(self.real.as_ref().map(Vec::len), "real");
        let has_masses = fits(self.mass_numbers.as_ref().map(Vec::len), "mass_numbers");
        let has_labels = fits(self.atom_labels.as_ref().map(Vec::len), "atom_labels");
        let (real, masses) = (self.real.unwrap_or_default(), self.mass_numbers.unwrap_or_default());
        let labels = self.atom_labels.unwrap_or_default();
        let mut unknown = 0usize;
        for (atom, (symbol, point)) in self.symbols.iter().zip(numbers.chunks_exact(3)).enumerate() {
            let position = DVec3::from_slice(point) * ANGSTROM_PER_BOHR;
            if !is_plausible(position) {
                return Err(Error::input(None, format!("the position {position} of atom {atom} cannot be used")));
            }
            let label = read_label(symbol.as_bytes());
            unknown += usize::from(label.kind == LabelKind::Unknown);
            let ghost = has_real && !real[atom];
            let mass = if has_masses { masses[atom] } else { 0 };
            let suffix = if has_labels { labels[atom].as_str() } else { "" };
            // Labels are what distinguishes atoms of one symbol: `H` and `1` make `H1`.
            let name = if suffix.is_empty() && !ghost { String::new() } else { format!("{symbol}{suffix}") };
            builder.push_atom(&AtomRecord {
                element: if ghost { Element::DUMMY } else { label.element },
                position,
                name: &name,
                flags: if ghost || label.particle { atom_flags::PARTICLE } else { 0 },
                isotope: isotope(label.element, mass).unwrap_or(label.isotope),
                ..AtomRecord::default()
            });
        }
        if unknown > 0 {
            diagnostics.warn(None, format!("{unknown} atoms have no known element and are kept without one"));
        }
        if let Some(name) = self.name {
            builder.set_title(name);
        }
        for (name, value) in
            [("molecular_charge", self.molecular_charge), ("molecular_multiplicity", self.molecular_multiplicity)]
        {
            if let Some(value) = value {
                builder.push_property(name, value.to_string());
            }
        }
        if let Some(list) = self.connectivity {
            builder.set_stated_bonds(StatedBonds::Complete);
            let pairs = list.into_iter().map(|(a, b, order)| PairBond::new([a, b], bond_of_order(Some(order))));
            push_pairs(&mut builder, pairs, diagnostics);
        }
        Ok(builder)
    }
}

/// The mass number, if it is one that the natural mixture is not mostly made of. Weights of elements up to calcium lie
/// within 0.5 of their commonest isotope, those of the others within 2.4 (tellurium).
fn isotope(element: Element, mass_number: i64) -> Option<u16> {
    let mass_number = u16::try_from(mass_number).ok().filter(|&number| (1..=400).contains(&number))?;
    let apart = (f32::from(mass_number) - element.mass()).abs();
    let natural = if element.z() <= 20 { 0.75 } else { 2.5 };
    (apart > natural && element != Element::DUMMY).then_some(mass_number)
}
