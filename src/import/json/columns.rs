//! Chemical JSON: atoms and bonds as columns of numbers.
//!
//! Read are `atoms.elements.number` (or `symbol`), `atoms.coords.3d`, `3dFractional` (with `unitCell`), `3dSets`
//! (frames), `2d` where there is nothing else, `atoms.formalCharges`, `atoms.labels`, `bonds.connections.index`,
//! `bonds.order`, `partialCharges` (the first set), `unitCell` (`unit cell` in old files). Basis sets, orbitals,
//! spectra, vibrations, residues and layers are passed over.

use super::super::is_plausible;
use super::super::number::decimals_of;
use super::super::symbol::{LabelKind, read_label};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::structure::{AtomRecord, Cell, Diagnostics, StructureBuilder, atom_flags};
use glam::DVec3;
use serde::Deserialize;
use std::collections::BTreeMap;

pub(super) type PartialCharges = BTreeMap<String, Vec<f32>>;

/// The `atoms` object.
#[derive(Deserialize)]
pub(super) struct Columns {
    elements: Elements,
    #[serde(default)]
    coords: Coords,
    #[serde(rename = "formalCharges", default)]
    formal_charges: Vec<i64>,
    #[serde(default)]
    labels: Vec<String>,
}

#[derive(Deserialize)]
struct Elements {
    #[serde(default)]
    number: Vec<i64>,
    #[serde(default, alias = "symbols", alias = "type")]
    symbol: Vec<String>,
}

#[derive(Deserialize, Default)]
struct Coords {
    #[serde(rename = "3d")]
    cartesian: Option<Vec<f64>>,
    #[serde(rename = "3dFractional", alias = "3d fractional")]
    fractional: Option<Vec<f64>>,
    #[serde(rename = "3dSets", alias = "3d sets")]
    sets: Option<Vec<Vec<f64>>>,
    #[serde(rename = "2d")]
    flat: Option<Vec<f64>>,
}

impl Columns {
    pub(super) fn atom_count(&self) -> usize {
        if self.elements.number.is_empty() { self.elements.symbol.len() } else { self.elements.number.len() }
    }

    /// Atoms and frames.
    pub(super) fn build(
        self,
        cell: Option<Cell>,
        partial_charges: Option<PartialCharges>,
        diagnostics: &mut Diagnostics,
    ) -> Result<StructureBuilder> {
        let count = self.atom_count();
        if count == 0 {
            return Err(Error::input(None, "`atoms.elements.number` is empty"));
        }
        let (frames, decimals) = self.coords.frames(count, cell, diagnostics)?;
        let mut builder = StructureBuilder::new();
        builder.set_decimals(decimals);
        let fits = |length: usize, what: &str, diagnostics: &mut Diagnostics| {
            if length != 0 && length != count {
                diagnostics.warn(None, format!("{what} has {length} values for {count} atoms and is ignored"));
            }
            length == count
        };
        let has_charges = fits(self.formal_charges.len(), "`formalCharges`", diagnostics);
        let has_labels = fits(self.labels.len(), "`labels`", diagnostics);
        let partial: Option<Vec<f32>> = partial_charges
            .and_then(|sets| sets.into_values().next())
            .filter(|set| fits(set.len(), "`partialCharges`", diagnostics));
        let mut unknown = 0usize;
        for (atom, &position) in frames[0].iter().enumerate() {
            let label = match (self.elements.number.get(atom), self.elements.symbol.get(atom)) {
                (Some(number), _) => read_label(number.to_string().as_bytes()),
                (None, Some(symbol)) => read_label(symbol.as_bytes()),
                (None, None) => continue,
            };
            unknown += usize::from(label.element == Element::DUMMY && label.kind == LabelKind::Unknown);
            let charge = if has_charges { self.formal_charges[atom] } else { 0 };
            builder.push_atom(&AtomRecord {
                element: label.element,
                position,
                name: if has_labels { &self.labels[atom] } else { "" },
                flags: if label.particle { atom_flags::PARTICLE } else { 0 },
                formal_charge: i8::try_from(charge).unwrap_or(0),
                partial_charge: partial.as_ref().map(|set| set[atom]),
                isotope: label.isotope,
                ..AtomRecord::default()
            });
        }
        if unknown > 0 {
            diagnostics.warn(None, format!("{unknown} atoms have no known element and are kept without one"));
        }
        for frame in &frames[1..] {
            let _fits = builder.push_frame(frame, cell, ""); // lengths were checked
        }
        Ok(builder)
    }
}

impl Coords {
    /// The frames, at least one, each of `count` positions, and their decimals.
    fn frames(self, count: usize, cell: Option<Cell>, diagnostics: &mut Diagnostics) -> Result<(Vec<Vec<DVec3>>, u8)> {
        let mut decimals = 0;
        let mut points = |values: &[f64], what: &str| -> Result<Vec<DVec3>> {
            if values.len() != 3 * count {
                let found = values.len();
                let message = format!("`{what}` holds {found} numbers; {count} atoms need {}", 3 * count);
                return Err(Error::input(None, message));
            }
            decimals = decimals_of(values, decimals);
            let points: Vec<DVec3> = values.chunks_exact(3).map(DVec3::from_slice).collect();
            match points.iter().position(|&point| !is_plausible(point)) {
                Some(atom) => {
                    Err(Error::input(None, format!("the position {} of atom {atom} cannot be used", points[atom])))
                }
                None => Ok(points),
            }
        };
        // Sets hold all frames, the shown one among them.
        if let Some(sets) = self.sets.filter(|sets| !sets.is_empty()) {
            let mut frames = Vec::with_capacity(sets.len());
            for (index, set) in sets.iter().enumerate() {
                match points(set, "3dSets") {
                    Ok(frame) => frames.push(frame),
                    Err(Error::Input { message, .. }) if index > 0 => {
                        diagnostics.error(None, format!("coordinate set {} is left out: {message}", index + 1));
                    }
                    Err(error) => return Err(error),
                }
            }
            return Ok((frames, decimals));
        }
        if let Some(values) = self.cartesian.filter(|values| !values.is_empty()) {
            return Ok((vec![points(&values, "3d")?], decimals));
        }
        if let Some(values) = self.fractional.filter(|values| !values.is_empty()) {
            let Some(cell) = cell else {
                return Err(Error::input(None, "there are fractional coordinates, but no unit cell to place them in"));
            };
            let fractional = points(&values, "3dFractional")?;
            let matrix = cell.cartesian_from_fractional();
            let cartesian = fractional.iter().map(|&point| matrix * point).collect();
            // Computed numbers have all digits.
            return Ok((vec![cartesian], crate::structure::Positions::MAX_DECIMALS));
        }
        if let Some(values) = self.flat.filter(|values| values.len() == 2 * count) {
            diagnostics.warn(None, "there are 2D coordinates only; the molecule is flat");
            let spread: Vec<f64> = values.chunks_exact(2).flat_map(|pair| [pair[0], pair[1], 0.0]).collect();
            return Ok((vec![points(&spread, "2d")?], decimals));
        }
        Err(Error::input(None, "`atoms.coords` holds no coordinates (`3d`, `3dFractional` or `3dSets`)"))
    }
}

/// The `bonds` object.
#[derive(Deserialize)]
pub(super) struct BondColumns {
    #[serde(default)]
    connections: Connections,
    #[serde(default)]
    order: Vec<f64>,
}

#[derive(Deserialize, Default)]
struct Connections {
    #[serde(default)]
    index: Vec<i64>,
}

impl BondColumns {
    /// Pairs of atom indices with their orders.
    pub(super) fn bonds(&self, diagnostics: &mut Diagnostics) -> Vec<([i64; 2], Option<f64>)> {
        let index = &self.connections.index;
        if !index.len().is_multiple_of(2) {
            diagnostics.error(None, "`bonds.connections.index` holds an odd number of atoms; the last one is left out");
        }
        if !self.order.is_empty() && self.order.len() != index.len() / 2 {
            let (orders, bonds) = (self.order.len(), index.len() / 2);
            diagnostics.warn(None, format!("`bonds.order` has {orders} values for {bonds} bonds"));
        }
        let pairs = index.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
        pairs.enumerate().map(|(bond, pair)| (pair, self.order.get(bond).copied())).collect()
    }
}
