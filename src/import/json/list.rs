//! Atoms and bonds as lists of objects: our own JSON and imolecule's.
//!
//! Keys of an atom: `element` (symbol or atomic number, required), `position` ([x, y, z] in ångström, required;
//! `location` in imolecule); optional `name` (or `label`), `charge` (formal), `partial_charge`, `isotope` (mass number),
//! `radical` (0–3 as in MDL files), `serial`, `residue`, `residue_number`, `insertion_code`, `chain`, `altloc`,
//! `occupancy`, `b_factor`, `hetero` (true for HETATM), `particle` (true for dummies, lone pairs, extra points;
//! without it what the element says).
//!
//! Keys of a bond: `atoms` ([i, j], counted from 0, required); optional `order` (0–4; 1.5 is aromatic; without it the
//! order is unknown), `kind` (covalent, coordination, dative, hydrogen), `aromatic`, `source` (file, link, dictionary,
//! distance), `image` ([h, k, l], the cell vectors to add to atom j; [0, 0, 0]).

use super::super::is_plausible;
use super::super::number::decimals_of;
use super::super::symbol::{Label, LabelKind, read_label};
use super::bond_of_order;
use crate::error::{Error, Result};
use crate::structure::{AtomRecord, Bond, BondKind, BondSource, Diagnostics, StructureBuilder, atom_flags};
use glam::DVec3;
use serde::Deserialize;
use serde::de::{Deserializer, Error as _, SeqAccess, Visitor};
use std::borrow::Cow;

/// The atoms of a list.
pub(super) struct List {
    pub(super) builder: StructureBuilder,
    /// The positions are called `location`.
    pub(super) by_location: bool,
    decimals: u8,
    /// Index and symbol of the first atom without an element, and how many there are.
    unknown: Option<(usize, String)>,
    unknown_count: usize,
}

#[derive(Deserialize)]
struct JsonAtom<'a> {
    element: JsonElement,
    position: Option<[f64; 3]>,
    location: Option<[f64; 3]>,
    #[serde(borrow)]
    name: Option<Cow<'a, str>>,
    #[serde(borrow)]
    label: Option<Cow<'a, str>>,
    charge: Option<f64>,
    partial_charge: Option<f32>,
    isotope: Option<u16>,
    radical: Option<u8>,
    serial: Option<i32>,
    #[serde(borrow)]
    residue: Option<Cow<'a, str>>,
    residue_number: Option<i32>,
    #[serde(borrow)]
    insertion_code: Option<Cow<'a, str>>,
    #[serde(borrow)]
    chain: Option<Cow<'a, str>>,
    #[serde(borrow)]
    altloc: Option<Cow<'a, str>>,
    occupancy: Option<f32>,
    b_factor: Option<f32>,
    hetero: Option<bool>,
    particle: Option<bool>,
}

/// What `element` means, and its text where that says more than a symbol.
struct JsonElement {
    label: Label,
    text: Option<String>,
}

impl JsonElement {
    fn new(text: &str) -> JsonElement {
        let label = read_label(text.trim().as_bytes());
        JsonElement { label, text: (label.kind != LabelKind::Symbol).then(|| text.trim().to_owned()) }
    }
}

impl<'de> Deserialize<'de> for JsonElement {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<JsonElement, D::Error> {
        struct ElementVisitor;
        impl Visitor<'_> for ElementVisitor {
            type Value = JsonElement;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an element symbol or an atomic number")
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<JsonElement, E> {
                Ok(JsonElement::new(text))
            }

            fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<JsonElement, E> {
                Ok(JsonElement::new(&number.to_string()))
            }

            fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<JsonElement, E> {
                Ok(JsonElement::new(&number.to_string()))
            }
        }
        deserializer.deserialize_any(ElementVisitor)
    }
}

impl List {
    /// Reads the list straight into a builder.
    pub(super) fn read<'de, A: SeqAccess<'de>>(mut seq: A) -> Result<List, A::Error> {
        let mut list =
            List { builder: StructureBuilder::new(), by_location: false, decimals: 0, unknown: None, unknown_count: 0 };
        while let Some(atom) = seq.next_element::<JsonAtom<'de>>()? {
            list.push(&atom).map_err(A::Error::custom)?;
        }
        Ok(list)
    }

    fn push(&mut self, atom: &JsonAtom<'_>) -> Result<(), String> {
        let index = self.builder.atom_count();
        let label = atom.element.label;
        let text = atom.element.text.as_deref().unwrap_or("");
        self.by_location |= atom.position.is_none();
        let Some(position) = atom.position.or(atom.location) else {
            return Err(format!("atom {index} has no position"));
        };
        let point = DVec3::from_array(position);
        if !is_plausible(point) {
            return Err(format!("the position {point} of atom {index} cannot be used"));
        }
        self.decimals = decimals_of(&position, self.decimals);
        let particle = atom.particle.unwrap_or(label.particle);
        if matches!(label.kind, LabelKind::Unknown) && !particle {
            self.unknown.get_or_insert_with(|| (index, text.chars().take(20).collect()));
            self.unknown_count += 1;
        }
        let byte = |text: &Option<Cow<'_, str>>| text.as_deref().and_then(|text| text.bytes().next()).unwrap_or(b' ');
        let residue = (atom.residue.is_some() || atom.residue_number.is_some() || atom.chain.is_some()).then(|| {
            let (name, chain) = (atom.residue.as_deref(), atom.chain.as_deref());
            (chain.unwrap_or(""), atom.residue_number.unwrap_or(0), byte(&atom.insertion_code), name.unwrap_or(""))
        });
        // A charge that is no integer is a partial one.
        let formal = atom.charge.filter(|charge| charge.fract() == 0.0 && charge.abs() <= 100.0);
        let partial = atom.charge.filter(|_| formal.is_none()).map(|charge| charge as f32);
        let mut flags = 0;
        flags |= if atom.hetero == Some(true) { atom_flags::HETERO } else { 0 };
        flags |= if particle { atom_flags::PARTICLE } else { 0 };
        self.builder.push_atom(&AtomRecord {
            element: label.element,
            position: point,
            name: atom.name.as_deref().or(atom.label.as_deref()).unwrap_or(text),
            serial: atom.serial,
            residue,
            flags,
            altloc: byte(&atom.altloc),
            occupancy: atom.occupancy.unwrap_or(1.0),
            b_factor: atom.b_factor.unwrap_or(0.0),
            formal_charge: formal.unwrap_or(0.0) as i8,
            partial_charge: atom.partial_charge.or(partial),
            isotope: atom.isotope.unwrap_or(label.isotope),
            radical: atom.radical.unwrap_or(0),
        });
        Ok(())
    }

    /// The atoms, once all are read.
    pub(super) fn finish(mut self, diagnostics: &mut Diagnostics) -> Result<StructureBuilder> {
        if self.builder.atom_count() == 0 {
            return Err(Error::input(None, "the list of atoms is empty"));
        }
        if let Some((index, symbol)) = &self.unknown {
            let count = self.unknown_count;
            let message = format!("`{symbol}` of atom {index} is no element; kept without one ({count} such atoms)");
            diagnostics.warn(None, message);
        }
        self.builder.set_decimals(self.decimals);
        Ok(self.builder)
    }
}

/// A bond of a list.
#[derive(Deserialize)]
pub(super) struct JsonBond<'a> {
    pub(super) atoms: [i64; 2],
    order: Option<f64>,
    #[serde(borrow)]
    kind: Option<Cow<'a, str>>,
    aromatic: Option<bool>,
    image: Option<[i8; 3]>,
    #[serde(borrow)]
    source: Option<Cow<'a, str>>,
}

impl JsonBond<'_> {
    /// What the bond is; its atoms are still to be set.
    pub(super) fn bond(&self, index: usize, diagnostics: &mut Diagnostics) -> Bond {
        let mut bond = bond_of_order(self.order);
        bond.aromatic |= self.aromatic == Some(true);
        bond.image = self.image.unwrap_or_default();
        let odd = |what: &str, text: &str| {
            let text: String = text.chars().take(20).collect();
            format!("bond {index}: the {what} `{text}` is not known and ignored")
        };
        if let Some(text) = self.kind.as_deref() {
            match BondKind::from_name(text) {
                Some(kind) => bond.kind = kind,
                None => diagnostics.warn(None, odd("kind", text)),
            }
        }
        if let Some(text) = self.source.as_deref() {
            match BondSource::from_name(text) {
                Some(source) => bond.source = source,
                None => diagnostics.warn(None, odd("source", text)),
            }
        }
        bond
    }
}
