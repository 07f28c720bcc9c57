//! ChemDoodle's JSON, <https://web.chemdoodle.com/docs/chemdoodle-json-format>: molecules in `m`, or one by itself, as
//! `a` (atoms: `l` symbol, carbon if it is missing, `x`, `y`, `z`, `c` charge, `m` mass number, `r` radical electrons)
//! and `b` (bonds: `b` and `e` the atoms by index, `o` order, 1 if it is missing, 1.5 aromatic; `s` stereo). Shapes are
//! passed over. Each molecule is a record.
//!
//! A drawing is in pixels with y downwards, a model in ångström. They are told apart by the bonds: a flat molecule whose
//! bonds are over 5 units long on average is a drawing, which is turned round and scaled to bonds of 1.5 Å.

use super::super::is_plausible;
use super::super::number::decimals_of;
use super::super::symbol::{LabelKind, read_label};
use super::{PairBond, bond_of_order, push_pairs};
use crate::error::{Error, Result};
use crate::structure::{AtomRecord, BondStereo, Diagnostics, Positions, StatedBonds, StructureBuilder, atom_flags};
use glam::DVec3;
use serde::Deserialize;

#[derive(Deserialize)]
pub(super) struct Root {
    m: Option<Vec<Molecule>>,
    a: Option<Vec<Atom>>,
    b: Option<Vec<BondOf>>,
}

#[derive(Deserialize)]
pub(super) struct Molecule {
    #[serde(default)]
    a: Vec<Atom>,
    #[serde(default)]
    b: Vec<BondOf>,
}

#[derive(Deserialize)]
struct Atom {
    l: Option<String>,
    x: f64,
    y: f64,
    #[serde(default)]
    z: f64,
    #[serde(default)]
    c: f64,
    #[serde(default)]
    m: f64,
    #[serde(default)]
    r: f64,
}

#[derive(Deserialize)]
struct BondOf {
    b: i64,
    e: i64,
    o: Option<f64>,
    s: Option<String>,
}

/// Mean length above which bonds are pixels: ChemDoodle draws them 20 long, and no molecule's mean is over 3 Å.
const LONGEST_MEAN: f64 = 5.0;
/// What a bond of a drawing becomes, in Å: about a carbon–carbon bond.
const DRAWN_BOND: f64 = 1.5;
/// ChemDoodle's standard bond, in pixels, for drawings of single atoms.
const DRAWN_PIXELS: f64 = 20.0;

impl Root {
    /// The molecules that have atoms.
    pub(super) fn molecules(self) -> impl Iterator<Item = Molecule> {
        let bare = self.a.map(|a| Molecule { a, b: self.b.unwrap_or_default() });
        self.m.into_iter().flatten().chain(bare).filter(|molecule| !molecule.a.is_empty())
    }
}

impl Molecule {
    pub(super) fn atom_count(&self) -> usize {
        self.a.len()
    }

    /// Å per unit in a drawing; `None` in a model.
    fn drawing_scale(&self) -> Option<f64> {
        if self.a.iter().any(|atom| atom.z != 0.0) {
            return None;
        }
        let at = |index: i64| usize::try_from(index).ok().and_then(|index| self.a.get(index));
        let length = |bond: &BondOf| at(bond.b).zip(at(bond.e)).map(|(a, b)| (a.x - b.x).hypot(a.y - b.y));
        let lengths: Vec<f64> = self.b.iter().filter_map(length).filter(|length| *length > 0.0).collect();
        if lengths.is_empty() {
            return Some(DRAWN_BOND / DRAWN_PIXELS);
        }
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        (mean > LONGEST_MEAN).then_some(DRAWN_BOND / mean)
    }

    /// Whether it is a drawing, which becomes a flat molecule.
    pub(super) fn is_drawing(&self) -> bool {
        self.drawing_scale().is_some()
    }

    pub(super) fn build(self, diagnostics: &mut Diagnostics) -> Result<StructureBuilder> {
        let scale = self.drawing_scale();
        let mut builder = StructureBuilder::new();
        let mut decimals = 0;
        let mut unknown = 0usize;
        for (index, atom) in self.a.iter().enumerate() {
            let position = match scale {
                Some(scale) => DVec3::new(atom.x, -atom.y, 0.0) * scale,
                None => DVec3::new(atom.x, atom.y, atom.z),
            };
            if !is_plausible(position) {
                return Err(Error::input(None, format!("the position {position} of atom {index} cannot be used")));
            }
            decimals = decimals_of(&[atom.x, atom.y, atom.z], decimals);
            let text = atom.l.as_deref().unwrap_or("C");
            let label = read_label(text.as_bytes());
            unknown += usize::from(label.kind == LabelKind::Unknown);
            let whole = |value: f64| if value.fract() == 0.0 && value.abs() <= 400.0 { value as i16 } else { 0 };
            let isotope = u16::try_from(whole(atom.m)).ok().filter(|&number| number > 0);
            builder.push_atom(&AtomRecord {
                element: label.element,
                position,
                name: if label.kind == LabelKind::Symbol && !label.particle { "" } else { text },
                flags: if label.particle { atom_flags::PARTICLE } else { 0 },
                formal_charge: i8::try_from(whole(atom.c)).unwrap_or(0),
                isotope: isotope.unwrap_or(label.isotope),
                // One unpaired electron is a doublet, two are a triplet.
                radical: match whole(atom.r) {
                    1 => 2,
                    2 => 3,
                    _ => 0,
                },
                ..AtomRecord::default()
            });
        }
        if unknown > 0 {
            diagnostics.warn(None, format!("{unknown} atoms have no known element and are kept without one"));
        }
        builder.set_decimals(if scale.is_some() { Positions::MAX_DECIMALS } else { decimals });
        builder.set_stated_bonds(StatedBonds::Complete);
        let pairs = self.b.iter().map(|bond| {
            let stereo = match bond.s.as_deref() {
                Some("protruding") => Some(BondStereo::Up),
                Some("recessed") => Some(BondStereo::Down),
                Some("ambiguous") if bond.o == Some(2.0) => Some(BondStereo::CisTransEither),
                Some("ambiguous") => Some(BondStereo::Either),
                _ => None,
            };
            PairBond { stereo, ..PairBond::new([bond.b, bond.e], bond_of_order(Some(bond.o.unwrap_or(1.0)))) }
        });
        push_pairs(&mut builder, pairs, diagnostics);
        Ok(builder)
    }
}
