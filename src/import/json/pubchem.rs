//! PubChem's JSON of compound records (`PC_Compounds`, and `PC_Substances` with compounds inside): the specification is
//! PubChem's data model, <https://pubchem.ncbi.nlm.nih.gov/pug_soap/docs/specifications.html> (`pcsubstance.asn`).
//!
//! Each compound is a record. Atoms are known by their `aid`; bonds by two of them and an order code (1–4; 5 dative,
//! 6 complex, 7 ionic, 255 unknown). Of several coordinate sets the three-dimensional one is taken, else the first; its
//! conformers are frames. Style annotations give wedges (5, 6), wavy (3) and crossed (1) bonds and aromatic ones (8).
//! Element codes above 118 (lone pair, R-group, dummy) are particles. Properties become data fields; the preferred IUPAC
//! name is the title.

use super::super::is_plausible;
use super::super::number::decimals_of;
use super::{PairBond, push_pairs};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::structure::{
    AtomRecord, Bond, BondKind, BondOrder, BondSource, BondStereo, Diagnostics, StatedBonds, StructureBuilder,
    atom_flags,
};
use glam::DVec3;
use serde::Deserialize;
use std::collections::HashMap;

#[derive(Deserialize)]
pub(super) struct Root {
    #[serde(rename = "PC_Compounds", default)]
    compounds: Vec<Compound>,
    #[serde(rename = "PC_Substances", default)]
    substances: Vec<Substance>,
}

#[derive(Deserialize)]
struct Substance {
    #[serde(default)]
    compound: Vec<Compound>,
}

#[derive(Deserialize)]
pub(super) struct Compound {
    id: Option<OuterId>,
    atoms: Option<Atoms>,
    bonds: Option<Bonds>,
    #[serde(default)]
    coords: Vec<Coords>,
    #[serde(default)]
    props: Vec<Property>,
}

#[derive(Deserialize)]
struct OuterId {
    id: Option<Id>,
}

#[derive(Deserialize)]
struct Id {
    cid: Option<i64>,
}

#[derive(Deserialize)]
struct Atoms {
    aid: Vec<i64>,
    #[serde(default)]
    element: Vec<i64>,
    #[serde(default)]
    charge: Vec<AtomValue>,
    #[serde(default)]
    isotope: Vec<AtomValue>,
    #[serde(default)]
    radical: Vec<AtomValue>,
}

#[derive(Deserialize)]
struct AtomValue {
    aid: i64,
    #[serde(alias = "type")]
    value: i64,
}

#[derive(Deserialize)]
struct Bonds {
    #[serde(default)]
    aid1: Vec<i64>,
    #[serde(default)]
    aid2: Vec<i64>,
    #[serde(default)]
    order: Vec<i64>,
}

#[derive(Deserialize)]
struct Coords {
    #[serde(rename = "type", default)]
    kind: Vec<i64>,
    #[serde(default)]
    aid: Vec<i64>,
    #[serde(default)]
    conformers: Vec<Conformer>,
}

#[derive(Deserialize)]
struct Conformer {
    #[serde(default)]
    x: Vec<f64>,
    #[serde(default)]
    y: Vec<f64>,
    #[serde(default)]
    z: Vec<f64>,
    style: Option<Style>,
}

#[derive(Deserialize)]
struct Style {
    #[serde(default)]
    annotation: Vec<i64>,
    #[serde(default)]
    aid1: Vec<i64>,
    #[serde(default)]
    aid2: Vec<i64>,
}

#[derive(Deserialize)]
struct Property {
    urn: Urn,
    value: Value,
}

#[derive(Deserialize)]
struct Urn {
    #[serde(default)]
    label: String,
    #[serde(default)]
    name: String,
}

#[derive(Deserialize)]
struct Value {
    sval: Option<String>,
    fval: Option<f64>,
    ival: Option<i64>,
}

impl Root {
    /// The compounds that have atoms, in their order.
    pub(super) fn compounds(self) -> impl Iterator<Item = Compound> {
        let inner = self.substances.into_iter().flat_map(|substance| substance.compound);
        self.compounds.into_iter().chain(inner.filter(|compound| compound.atoms.is_some()))
    }
}

impl Compound {
    pub(super) fn atom_count(&self) -> usize {
        self.atoms.as_ref().map_or(0, |atoms| atoms.aid.len())
    }

    pub(super) fn build(self, diagnostics: &mut Diagnostics) -> Result<StructureBuilder> {
        let Some(atoms) = self.atoms.filter(|atoms| !atoms.aid.is_empty()) else {
            return Err(Error::input(None, "the compound has no `atoms`"));
        };
        let count = atoms.aid.len();
        if atoms.element.len() != count {
            let found = atoms.element.len();
            return Err(Error::input(None, format!("`element` has {found} values for {count} `aid`")));
        }
        let mut indices = HashMap::with_capacity(count);
        for (index, &aid) in atoms.aid.iter().enumerate() {
            if indices.insert(aid, index).is_some() {
                return Err(Error::input(None, format!("two atoms have the `aid` {aid}")));
            }
        }
        // Code 2 is `threed` in the data model.
        let spatial = self.coords.iter().position(|coords| coords.kind.contains(&2)).unwrap_or(0);
        let Some(coords) = self.coords.into_iter().nth(spatial) else {
            return Err(Error::input(None, "the compound has no `coords`"));
        };
        let mut decimals = 0;
        let mut frames = Vec::with_capacity(coords.conformers.len());
        for conformer in &coords.conformers {
            decimals = [&conformer.x, &conformer.y, &conformer.z].iter().fold(decimals, |d, list| decimals_of(list, d));
            match conformer.points(&coords.aid, &indices, count) {
                Ok(points) => frames.push(points),
                Err(Error::Input { message, .. }) if !frames.is_empty() => {
                    diagnostics.error(None, format!("a conformer is left out: {message}"));
                }
                Err(error) => return Err(error),
            }
        }
        let Some(first) = frames.first() else {
            return Err(Error::input(None, "the compound has no `conformers`"));
        };
        if coords.conformers.first().is_some_and(|conformer| conformer.z.is_empty()) {
            diagnostics.warn(None, "there are 2D coordinates only; the molecule is flat");
        }
        let mut builder = StructureBuilder::new();
        builder.set_decimals(decimals);
        let of = |values: &[AtomValue]| -> HashMap<i64, i64> { values.iter().map(|v| (v.aid, v.value)).collect() };
        let (charges, isotopes, radicals) = (of(&atoms.charge), of(&atoms.isotope), of(&atoms.radical));
        let value = |values: &HashMap<i64, i64>, aid: i64| values.get(&aid).copied().unwrap_or(0);
        for ((&aid, &code), &position) in atoms.aid.iter().zip(&atoms.element).zip(first) {
            let element = u8::try_from(code).ok().and_then(Element::from_z);
            builder.push_atom(&AtomRecord {
                element: element.unwrap_or(Element::DUMMY),
                position,
                flags: if element.is_none() { atom_flags::PARTICLE } else { 0 },
                formal_charge: i8::try_from(value(&charges, aid)).unwrap_or(0),
                isotope: u16::try_from(value(&isotopes, aid)).unwrap_or(0),
                // 1 singlet, 2 doublet, 3 triplet as in MDL files; higher ones have no place.
                radical: u8::try_from(value(&radicals, aid)).ok().filter(|&kind| kind <= 3).unwrap_or(0),
                ..AtomRecord::default()
            });
        }
        for frame in frames.get(1..).unwrap_or_default() {
            let _fits = builder.push_frame(frame, None, ""); // lengths were checked
        }
        builder.set_stated_bonds(StatedBonds::Complete);
        let style = coords.conformers.into_iter().next().and_then(|conformer| conformer.style);
        if let Some(bonds) = self.bonds {
            push_bonds(&mut builder, &bonds, style.as_ref(), &indices, diagnostics);
        }
        describe(&mut builder, self.id.and_then(|outer| outer.id).and_then(|id| id.cid), self.props);
        Ok(builder)
    }
}

impl Conformer {
    /// Positions in the order of the atoms.
    fn points(&self, aids: &[i64], indices: &HashMap<i64, usize>, count: usize) -> Result<Vec<DVec3>> {
        let flat = self.z.is_empty();
        if aids.len() != count || self.x.len() != count || self.y.len() != count || !(flat || self.z.len() == count) {
            return Err(Error::input(None, format!("the coordinates are not those of {count} atoms")));
        }
        let mut points = vec![DVec3::NAN; count];
        for (at, aid) in aids.iter().enumerate() {
            let z = if flat { 0.0 } else { self.z[at] };
            if let Some(&index) = indices.get(aid) {
                points[index] = DVec3::new(self.x[at], self.y[at], z);
            }
        }
        match points.iter().position(|&point| !is_plausible(point)) {
            Some(atom) => Err(Error::input(None, format!("atom {atom} has no position that can be used"))),
            None => Ok(points),
        }
    }
}

fn push_bonds(
    builder: &mut StructureBuilder,
    bonds: &Bonds,
    style: Option<&Style>,
    indices: &HashMap<i64, usize>,
    diagnostics: &mut Diagnostics,
) {
    if bonds.aid1.len() != bonds.aid2.len() {
        diagnostics
            .error(None, "`aid1` and `aid2` of the bonds differ in length; those without a partner are left out");
    }
    let mut annotations: HashMap<(i64, i64), Vec<i64>> = HashMap::new();
    if let Some(style) = style {
        for ((&a, &b), &annotation) in style.aid1.iter().zip(&style.aid2).zip(&style.annotation) {
            annotations.entry((a, b)).or_default().push(annotation);
        }
    }
    let index = |aid: i64| indices.get(&aid).and_then(|&index| i64::try_from(index).ok()).unwrap_or(-1);
    let pairs = bonds.aid1.iter().zip(&bonds.aid2).enumerate().map(|(at, (&a, &b))| {
        let code = bonds.order.get(at).copied().unwrap_or(255);
        let (order, kind) = match code {
            1..=4 => (BondOrder::from_number(code as u32), BondKind::Covalent),
            5 => (BondOrder::Unknown, BondKind::Dative),
            6 => (BondOrder::Unknown, BondKind::Coordination),
            _ => (BondOrder::Unknown, BondKind::Covalent),
        };
        let notes = |pair| annotations.get(&pair).map_or(&[][..], Vec::as_slice);
        let aromatic = notes((a, b)).contains(&8) || notes((b, a)).contains(&8);
        let bond = Bond { kind, aromatic, ..Bond::new(0, 0, order, BondSource::File) };
        // A wedge begins at the first atom of its annotation, whichever way round the bond is listed.
        let stereo = |pair| {
            notes(pair).iter().find_map(|note| match note {
                5 => Some(BondStereo::Up),
                6 => Some(BondStereo::Down),
                3 => Some(BondStereo::Either),
                1 => Some(BondStereo::CisTransEither),
                _ => None,
            })
        };
        let (pair, stereo) = match stereo((b, a)) {
            Some(stereo) => ([index(b), index(a)], Some(stereo)),
            None => ([index(a), index(b)], stereo((a, b))),
        };
        PairBond { stereo, ..PairBond::new(pair, bond) }
    });
    push_pairs(builder, pairs, diagnostics);
}

/// Title and data fields.
fn describe(builder: &mut StructureBuilder, cid: Option<i64>, properties: Vec<Property>) {
    let mut title = None;
    if let Some(cid) = cid {
        builder.push_property("PUBCHEM_COMPOUND_CID", cid.to_string());
    }
    for Property { urn, value } in properties {
        let number = value.fval.map(|value| value.to_string()).or(value.ival.map(|value| value.to_string()));
        let Some(text) = value.sval.or(number) else { continue };
        if urn.label == "IUPAC Name" && (urn.name == "Preferred" || title.is_none()) {
            title = Some(text.clone());
        }
        let name = if urn.name.is_empty() { urn.label } else { format!("{} ({})", urn.label, urn.name) };
        builder.push_property(name, text);
    }
    if let Some(title) = title.or(cid.map(|cid| format!("CID {cid}"))) {
        builder.set_title(title);
    }
}
