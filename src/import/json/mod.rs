//! JSON in six dialects, told apart by what is in them:
//!
//! - our own (`json`): `{"atoms":[{"element":"C","position":[x,y,z], …}], "bonds":[{"atoms":[i,j],"order":1, …}]}`,
//!   described in [`list`] and, as a JSON Schema, in `data/ballstick.schema.json`;
//! - imolecule (`imolecule`), the format of <https://github.com/patrickfuller/imolecule>: the same with `location` in
//!   place of `position` and `unitcell` as three vectors;
//! - Chemical JSON (`cjson`), as Avogadro 1.9x/2 writes it (versions 0 and 1): columns of numbers, described in [`columns`];
//! - QCSchema (`qcschema`, [`qcschema`]), PubChem's compounds (`pubchem`, [`pubchem`]), ChemDoodle (`chemdoodle`, [`chemdoodle`]).
//!
//! Unknown keys are ignored. A `bonds` key, even with an empty list, is the complete list of bonds; without the key
//! all bonds are to be found. A file is one record, in PubChem's and ChemDoodle's forms one a molecule; several coordinate
//! sets and conformers are frames.
//!
//! JSON is read straight into a structure, never into a tree of values. What is no JSON, and what contradicts itself
//! (coordinates that are not three an atom), is an error with its line; bonds that cannot be are left out.

mod chemdoodle;
mod columns;
mod list;
mod pubchem;
mod qcschema;

use super::collect::Records;
use super::{Format, Limits};
use crate::error::{Error, Result};
use crate::structure::{
    Bond, BondKind, BondOrder, BondSource, BondStereo, Cell, Diagnostics, StatedBonds, StructureBuilder,
};
use glam::DVec3;
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor, value::MapAccessDeserializer};

pub(super) fn read(
    text: &[u8],
    wanted: Option<Format>,
    records: &mut Records,
    diagnostics: &mut Diagnostics,
) -> Result<Format> {
    check_depth(text, records.limits())?;
    if !text.trim_ascii_start().starts_with(b"{") {
        return Err(Error::input(1, "expected a JSON object (`{`) that holds a molecule"));
    }
    let root: Root<'_> = serde_json::from_slice(text).map_err(|error| json_error(&error))?;
    let (format, mut builder) = match root.atoms {
        Some(Atoms::List(list)) => {
            let format = if list.by_location { Format::ImoleculeJson } else { Format::BallstickJson };
            records.check_atoms(list.builder.atom_count(), 1)?;
            (format, list.finish(diagnostics)?)
        }
        Some(Atoms::Columns(columns)) => {
            if root.chemical_json.is_none() {
                diagnostics.warn(None, "the key `chemicalJson` is missing; read as Chemical JSON all the same");
            }
            records.check_atoms(columns.atom_count(), 1)?;
            let cell = root.unit_cell.as_ref().and_then(JsonCell::cell);
            (Format::ChemicalJson, columns.build(cell, root.partial_charges, diagnostics)?)
        }
        None => {
            let format = read_other(text, &root, records, diagnostics)?;
            warn_of_wish(wanted, format, diagnostics);
            return Ok(format);
        }
    };
    warn_of_wish(wanted, format, diagnostics);
    let title = root.title.or(root.name).or(root.properties.and_then(|properties| properties.name));
    if let Some(Text::Text(title)) = title {
        builder.set_title(title);
    }
    for cell in [&root.cell, &root.unit_cell].into_iter().flatten() {
        match cell.cell() {
            Some(cell) => builder.set_cell(Some(cell)),
            None => diagnostics.warn(None, "the unit cell is left out: its vectors or lengths and angles span no cell"),
        }
    }
    if let Some(bonds) = root.bonds {
        builder.set_stated_bonds(StatedBonds::Complete);
        push_bonds(&mut builder, bonds, diagnostics);
    }
    records.push(builder.build(diagnostics));
    Ok(format)
}

/// All dialects at once.
#[derive(Deserialize)]
struct Root<'a> {
    atoms: Option<Atoms>,
    #[serde(borrow)]
    bonds: Option<Bonds<'a>>,
    title: Option<Text>,
    name: Option<Text>,
    properties: Option<Properties>,
    cell: Option<JsonCell>,
    #[serde(rename = "unitCell", alias = "unit cell", alias = "unitcell")]
    unit_cell: Option<JsonCell>,
    #[serde(rename = "chemicalJson", alias = "chemical json")]
    chemical_json: Option<IgnoredAny>,
    #[serde(rename = "partialCharges")]
    partial_charges: Option<columns::PartialCharges>,
    /// ChemDoodle.
    m: Option<IgnoredAny>,
    a: Option<IgnoredAny>,
    #[serde(rename = "PC_Compounds", alias = "PC_Substances")]
    pubchem: Option<IgnoredAny>,
    /// QCSchema.
    schema_name: Option<IgnoredAny>,
    symbols: Option<IgnoredAny>,
    molecule: Option<IgnoredAny>,
}

fn warn_of_wish(wanted: Option<Format>, format: Format, diagnostics: &mut Diagnostics) {
    if let Some(wanted) = wanted.filter(|&wanted| wanted != format) {
        diagnostics.warn(None, format!("{wanted} was asked for, but the file is {format} and is read as that"));
    }
}

/// The dialects without `atoms`, by a second walk over the text.
fn read_other(text: &[u8], root: &Root<'_>, records: &mut Records, diagnostics: &mut Diagnostics) -> Result<Format> {
    fn parse<'de, T: Deserialize<'de>>(text: &'de [u8]) -> Result<T> {
        serde_json::from_slice(text).map_err(|error| json_error(&error))
    }
    if root.pubchem.is_some() {
        for (index, compound) in parse::<pubchem::Root>(text)?.compounds().enumerate() {
            records.check_atoms(compound.atom_count(), 1)?;
            push_record(compound.build(diagnostics), index, records, diagnostics)?;
        }
        return none_is_an_error(Format::PubChemJson, records);
    }
    if root.m.is_some() || root.a.is_some() {
        let mut drawings = 0;
        for (index, molecule) in parse::<chemdoodle::Root>(text)?.molecules().enumerate() {
            records.check_atoms(molecule.atom_count(), 1)?;
            drawings += usize::from(molecule.is_drawing());
            push_record(molecule.build(diagnostics), index, records, diagnostics)?;
        }
        match drawings {
            0 => {}
            1 => diagnostics.warn(None, "the molecule is a drawing; it is flat, with bonds scaled to 1.5 Å"),
            _ => {
                let message = format!("{drawings} molecules are drawings; they are flat, with bonds scaled to 1.5 Å");
                diagnostics.warn(None, message);
            }
        }
        return none_is_an_error(Format::ChemDoodleJson, records);
    }
    if root.schema_name.is_some() || root.symbols.is_some() || root.molecule.is_some() {
        let builder = match root.symbols {
            Some(_) => parse::<qcschema::Molecule>(text)?.build(diagnostics)?,
            None => parse::<qcschema::Root>(text)?.build(diagnostics)?,
        };
        records.check_atoms(builder.atom_count(), 1)?;
        records.push(builder.build(diagnostics));
        return Ok(Format::QcSchema);
    }
    Err(Error::input(None, "the JSON has no `atoms`: it is no molecule in a form that is known"))
}

/// Adds one of several records; a bad one is an error only where it is the first.
fn push_record(
    built: Result<StructureBuilder>,
    index: usize,
    records: &mut Records,
    diagnostics: &mut Diagnostics,
) -> Result<()> {
    match built {
        Ok(builder) => records.push(builder.build(diagnostics)),
        Err(Error::Input { message, .. }) if index > 0 => {
            diagnostics.error(None, format!("molecule {} is left out: {message}", index + 1));
        }
        Err(error) => return Err(error),
    }
    Ok(())
}

fn none_is_an_error(format: Format, records: &Records) -> Result<Format> {
    if records.is_empty() {
        return Err(Error::input(None, format!("the {format} JSON holds no molecule with atoms")));
    }
    Ok(format)
}

#[derive(Deserialize)]
struct Properties {
    name: Option<Text>,
}

/// A text, or something else that is no title then.
#[derive(Deserialize)]
#[serde(untagged)]
enum Text {
    Text(String),
    Other(IgnoredAny),
}

enum Atoms {
    List(Box<list::List>),
    Columns(columns::Columns),
}

impl<'de> Deserialize<'de> for Atoms {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Atoms, D::Error> {
        struct AtomsVisitor;
        impl<'de> Visitor<'de> for AtomsVisitor {
            type Value = Atoms;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a list of atoms, or Chemical JSON's object of columns")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Atoms, A::Error> {
                list::List::read(seq).map(|list| Atoms::List(Box::new(list)))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Atoms, A::Error> {
                columns::Columns::deserialize(MapAccessDeserializer::new(map)).map(Atoms::Columns)
            }
        }
        deserializer.deserialize_any(AtomsVisitor)
    }
}

enum Bonds<'a> {
    List(Vec<list::JsonBond<'a>>),
    Columns(columns::BondColumns),
}

impl<'de: 'a, 'a> Deserialize<'de> for Bonds<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Bonds<'a>, D::Error> {
        struct BondsVisitor<'a>(std::marker::PhantomData<&'a ()>);
        impl<'de: 'a, 'a> Visitor<'de> for BondsVisitor<'a> {
            type Value = Bonds<'a>;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a list of bonds, or Chemical JSON's object of columns")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Bonds<'a>, A::Error> {
                let mut bonds = Vec::new();
                while let Some(bond) = seq.next_element()? {
                    bonds.push(bond);
                }
                Ok(Bonds::List(bonds))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Bonds<'a>, A::Error> {
                columns::BondColumns::deserialize(MapAccessDeserializer::new(map)).map(Bonds::Columns)
            }
        }
        deserializer.deserialize_any(BondsVisitor(std::marker::PhantomData))
    }
}

/// A unit cell as three vectors, nine numbers, or lengths and angles.
struct JsonCell(Option<Cell>);

impl JsonCell {
    fn cell(&self) -> Option<Cell> {
        self.0
    }
}

#[derive(Deserialize)]
struct CellObject {
    a: Option<f64>,
    b: Option<f64>,
    c: Option<f64>,
    alpha: Option<f64>,
    beta: Option<f64>,
    gamma: Option<f64>,
    vectors: Option<[[f64; 3]; 3]>,
    #[serde(rename = "cellVectors")]
    cell_vectors: Option<Vec<f64>>,
}

fn cell_of(vectors: [[f64; 3]; 3]) -> Option<Cell> {
    let [a, b, c] = vectors.map(DVec3::from_array);
    Cell::from_vectors(a, b, c)
}

impl CellObject {
    fn cell(&self) -> Option<Cell> {
        let nine = self.cell_vectors.as_deref().and_then(|list| <&[f64; 9]>::try_from(list).ok());
        let rows = nine.map(|n| [[n[0], n[1], n[2]], [n[3], n[4], n[5]], [n[6], n[7], n[8]]]);
        let angle = |angle: Option<f64>| angle.unwrap_or(90.0);
        let parameters = || {
            let lengths = [self.a?, self.b?, self.c?];
            Cell::from_parameters(lengths, [angle(self.alpha), angle(self.beta), angle(self.gamma)])
        };
        self.vectors.or(rows).and_then(cell_of).or_else(parameters)
    }
}

impl<'de> Deserialize<'de> for JsonCell {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<JsonCell, D::Error> {
        struct CellVisitor;
        impl<'de> Visitor<'de> for CellVisitor {
            type Value = JsonCell;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("three cell vectors, or an object with a, b, c, alpha, beta, gamma")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<JsonCell, A::Error> {
                let vectors: [[f64; 3]; 3] =
                    Deserialize::deserialize(serde::de::value::SeqAccessDeserializer::new(seq))?;
                Ok(JsonCell(cell_of(vectors)))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<JsonCell, A::Error> {
                let object = CellObject::deserialize(MapAccessDeserializer::new(map))?;
                Ok(JsonCell(object.cell()))
            }
        }
        deserializer.deserialize_any(CellVisitor)
    }
}

fn push_bonds(builder: &mut StructureBuilder, bonds: Bonds<'_>, diagnostics: &mut Diagnostics) {
    let pairs: Vec<PairBond> = match bonds {
        Bonds::List(list) => (list.iter().enumerate())
            .map(|(index, bond)| PairBond::new(bond.atoms, bond.bond(index, diagnostics)))
            .collect(),
        Bonds::Columns(columns) => (columns.bonds(diagnostics).into_iter())
            .map(|(atoms, order)| PairBond::new(atoms, bond_of_order(order)))
            .collect(),
    };
    push_pairs(builder, pairs, diagnostics);
}

/// A bond whose atoms are still to be checked.
struct PairBond {
    atoms: [i64; 2],
    /// What it is; its own atoms say nothing yet.
    bond: Bond,
    /// A stereo mark, from the first atom on.
    stereo: Option<BondStereo>,
}

impl PairBond {
    fn new(atoms: [i64; 2], bond: Bond) -> PairBond {
        PairBond { atoms, bond, stereo: None }
    }
}

/// Adds bonds, with a message for each that cannot be or is there already.
fn push_pairs(
    builder: &mut StructureBuilder,
    pairs: impl IntoIterator<Item = PairBond>,
    diagnostics: &mut Diagnostics,
) {
    let count = builder.atom_count();
    let mut seen = std::collections::HashSet::new();
    for (index, PairBond { atoms: [a, b], bond, stereo }) in pairs.into_iter().enumerate() {
        let atom = |atom: i64| u32::try_from(atom).ok().filter(|&atom| (atom as usize) < count);
        let (Some(first), Some(second)) = (atom(a).filter(|_| a != b || bond.is_periodic()), atom(b)) else {
            let message = format!(
                "bond {index} is left out: there is no pair of atoms {a}, {b} (the {count} atoms count from 0)"
            );
            diagnostics.error(None, message);
            continue;
        };
        let bond = Bond { a: first, b: second, ..bond }.turned();
        if !seen.insert(bond.key()) {
            diagnostics
                .warn(None, format!("bond {index} between atoms {a} and {b} is listed before; that one is used"));
        }
        builder.push_bond(bond);
        if let Some(stereo) = stereo {
            builder.push_bond_stereo(first, second, stereo);
        }
    }
}

/// A covalent bond of an order as JSON gives it: 1.5 is aromatic, `None`, 0 and all else unknown.
fn bond_of_order(order: Option<f64>) -> Bond {
    let number = order.filter(|order| order.fract() == 0.0 && (0.0..=4.0).contains(order));
    let mut bond = Bond::new(0, 0, BondOrder::from_number(number.unwrap_or(0.0) as u32), BondSource::File);
    bond.kind = BondKind::Covalent;
    bond.aromatic = order == Some(1.5);
    bond
}

/// Refuses nesting beyond the limit, with the line, before a parser may recurse.
fn check_depth(text: &[u8], limits: &Limits) -> Result<()> {
    let most = limits.json_depth.min(127);
    let (mut depth, mut in_string, mut line) = (0usize, false, 1u64);
    let mut bytes = text.iter();
    while let Some(&byte) = bytes.next() {
        match byte {
            b'"' => in_string = !in_string,
            b'\\' if in_string => {
                bytes.next();
            }
            b'\n' => line += 1,
            b'[' | b'{' if !in_string => {
                depth += 1;
                if depth > most {
                    return Err(Error::limit(
                        line,
                        format!("arrays and objects nest more than {most} deep (limit `json_depth`)"),
                    ));
                }
            }
            b']' | b'}' if !in_string => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    Ok(())
}

fn json_error(error: &serde_json::Error) -> Error {
    let text = error.to_string();
    let what = text.rsplit_once(" at line ").map_or(text.as_str(), |(what, _)| what);
    let column = error.column();
    let message = match error.classify() {
        serde_json::error::Category::Eof => "the JSON ends too early".to_owned(),
        serde_json::error::Category::Syntax => format!("this is no JSON: {what} (column {column})"),
        _ => format!("{what} (column {column})"),
    };
    Error::input((error.line() > 0).then_some(error.line() as u64), message)
}

#[cfg(test)]
mod tests;
