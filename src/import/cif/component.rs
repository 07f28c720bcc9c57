//! `_chem_comp_bond` and `_chem_comp_atom`: bonds inside residues by atom names, and the molecules of ligand files.
//!
//! A ligand file (an entry of the Chemical Component Dictionary, a restraint dictionary) has no `_atom_site`; each of
//! its components is a record. Its ideal coordinates are preferred, as they are whole and computed; else those of the
//! model it was taken from, else the plain `x`, `y`, `z` of restraint dictionaries. The title says which.

use super::label::{element_of_name, type_symbol};
use super::table::{Block, Category, Row, Table};
use crate::error::Result;
use crate::import::collect::Records;
use crate::import::text::{Repeated, shown};
use crate::structure::{
    AtomRecord, Bond, BondOrder, BondSource, ComponentBond, ComponentBonds, Diagnostics, StatedBonds, StructureBuilder,
};
use glam::DVec3;
use std::collections::HashMap;

/// Order and aromaticity of `value_order` (`sing`, `DOUB`, `arom`) or of the `type` of restraint dictionaries
/// (`single`, `aromatic`); `None` for what is neither.
pub(super) fn order_of(text: &str) -> Option<(BondOrder, bool)> {
    Some(match text.to_ascii_lowercase().as_str() {
        "sing" | "single" | "1" => (BondOrder::Single, false),
        "doub" | "double" | "2" => (BondOrder::Double, false),
        "trip" | "triple" | "3" => (BondOrder::Triple, false),
        "quad" | "quadruple" | "4" => (BondOrder::Quadruple, false),
        "arom" | "aromatic" | "aromat" => (BondOrder::Unknown, true),
        "delo" | "deloc" | "delocalized" | "pi" | "poly" | "metal" | "metalc" => (BondOrder::Unknown, false),
        _ => return None,
    })
}

/// The bonds inside residues that the block lists, by component, in the order they come.
pub(super) fn bonds(block: &impl Block, diagnostics: &mut Diagnostics) -> Vec<ComponentBonds> {
    let Some(table) = block.table(Category::ChemCompBond) else { return Vec::new() };
    let [component, a, b, order, kind, aromatic] =
        ["comp_id", "atom_id_1", "atom_id_2", "value_order", "type", "pdbx_aromatic_flag"]
            .map(|item| table.column(item));
    let mut components: Vec<ComponentBonds> = Vec::new();
    let mut by_name: HashMap<String, usize> = HashMap::new();
    let mut odd = Repeated::default();
    for index in 0..table.row_count() {
        let row = table.row(index);
        let (Some(a), Some(b)) = (row.text(a), row.text(b)) else { continue };
        // Ligand files may leave the component's name to the block's.
        let name = row.text(component).unwrap_or_default();
        let at = by_name.get(&*name).copied().unwrap_or_else(|| {
            by_name.insert(name.clone().into_owned(), components.len());
            components.push(ComponentBonds { name: name.clone().into_owned(), bonds: Vec::new() });
            components.len() - 1
        });
        let text = row.text(order).or_else(|| row.text(kind));
        let (order, is_aromatic) = match text.as_deref().map(|text| (text, order_of(text))) {
            Some((_, Some(order))) => order,
            Some((text, None)) => {
                let message = || format!("`{}` is no bond order; the bond is kept without one", shown(text.as_bytes()));
                odd.note(row.line().unwrap_or(0), message);
                (BondOrder::Unknown, false)
            }
            None => (BondOrder::Single, false),
        };
        let flagged = row.text(aromatic).is_some_and(|flag| flag.eq_ignore_ascii_case("y"));
        components[at].bonds.push(ComponentBond {
            a: a.into_owned(),
            b: b.into_owned(),
            order,
            aromatic: is_aromatic || flagged,
        });
    }
    odd.warn(diagnostics);
    components
}

/// Columns of one set of coordinates, and what they are.
const COORDINATES: [([&str; 3], &str); 3] = [
    (["pdbx_model_Cartn_x_ideal", "pdbx_model_Cartn_y_ideal", "pdbx_model_Cartn_z_ideal"], "ideal coordinates"),
    (["model_Cartn_x", "model_Cartn_y", "model_Cartn_z"], "model coordinates"),
    (["x", "y", "z"], "coordinates of the restraint dictionary"),
];

/// The components of a block without `_atom_site`, each a record; nothing for a block without any.
///
/// # Errors
/// A limit would be passed.
pub(super) fn read_ligands(block: &impl Block, records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let Some(table) = block.table(Category::ChemCompAtom) else { return Ok(()) };
    let component = table.column("comp_id");
    let sets = COORDINATES.map(|(items, _)| items.map(|item| table.column(item)));
    // Rows by component, in the order they come.
    let mut components: Vec<(String, Vec<usize>)> = Vec::new();
    let mut by_name: HashMap<String, usize> = HashMap::new();
    for index in 0..table.row_count() {
        let name = table.row(index).text(component).unwrap_or_default().into_owned();
        let at = *by_name.entry(name).or_insert_with_key(|name| {
            components.push((name.clone(), Vec::new()));
            components.len() - 1
        });
        components[at].1.push(index);
    }
    let bonds = bonds(block, diagnostics);
    let stated = block.table(Category::ChemCompBond).is_some();
    let bonds_of: HashMap<&str, &ComponentBonds> =
        bonds.iter().map(|component| (component.name.as_str(), component)).collect();
    for (name, rows) in &components {
        records.check_atoms(rows.len(), table.row(rows[0]).line().unwrap_or(0))?;
        let has = |index: usize, set: usize| sets[set].iter().all(|&column| table.row(index).number(column).is_some());
        let counts = [0, 1, 2].map(|set| rows.iter().filter(|&&index| has(index, set)).count());
        let most = counts.into_iter().max().unwrap_or(0);
        if most == 0 {
            let line = table.row(rows[0]).line();
            diagnostics
                .error(line, format!("the component {} is left out: it has no coordinates", shown(name.as_bytes())));
            continue;
        }
        // The first set with the most atoms.
        let set = counts.iter().position(|&count| count == most).unwrap_or(0);
        let ligand = Ligand { name, rows, columns: sets[set], coordinates: COORDINATES[set].1 };
        let mut builder = ligand.atoms(block, &table, diagnostics);
        if set == 1 {
            let message = format!(
                "{}: the ideal coordinates are missing or not whole; those of the model are used",
                shown(name.as_bytes())
            );
            diagnostics.warn(table.row(rows[0]).line(), message);
        }
        if stated {
            builder.set_stated_bonds(StatedBonds::Complete);
        }
        let list = bonds_of.get(name.as_str()).map_or(&[][..], |component| component.bonds.as_slice());
        push_bonds(&mut builder, name, list, &ligand, &table, diagnostics);
        records.push(builder.build(diagnostics));
    }
    Ok(())
}

struct Ligand<'l> {
    name: &'l str,
    rows: &'l [usize],
    columns: [super::table::Column; 3],
    /// What they are.
    coordinates: &'static str,
}

impl Ligand<'_> {
    /// Rows that have a position.
    fn positioned<'t>(&'t self, table: &'t impl Table) -> impl Iterator<Item = (usize, DVec3, u8)> + 't {
        self.rows.iter().filter_map(|&index| {
            let row = table.row(index);
            let [x, y, z] = self.columns.map(|column| row.number(column));
            let ((x, dx), (y, dy), (z, dz)) = (x?, y?, z?);
            let position = DVec3::new(x, y, z);
            crate::import::is_plausible(position).then_some((index, position, dx.max(dy).max(dz)))
        })
    }

    fn atoms(&self, block: &impl Block, table: &impl Table, diagnostics: &mut Diagnostics) -> StructureBuilder {
        let mut builder = StructureBuilder::new();
        builder.set_title(format!("{}, {}", title(block, self.name), self.coordinates));
        let name_column = table.column("atom_id");
        let [symbol, charge] = ["type_symbol", "charge"].map(|item| table.column(item));
        let (mut decimals, mut unknown) = (0, Repeated::default());
        for (index, position, more) in self.positioned(table) {
            let row = table.row(index);
            let name = row.text(name_column).unwrap_or_default();
            let meaning =
                row.text(symbol).and_then(|symbol| type_symbol(&symbol)).or_else(|| element_of_name(&name, self.name));
            if meaning.is_none() {
                let message =
                    || format!("no element is known for the atom {}; it is kept without one", shown(name.as_bytes()));
                unknown.note(row.line().unwrap_or(0), message);
            }
            let stated = row.integer(charge).and_then(|charge| i8::try_from(charge).ok());
            decimals = decimals.max(more);
            builder.push_atom(&AtomRecord {
                element: meaning.map(|meaning| meaning.element).unwrap_or_default(),
                position,
                name: &name,
                residue: Some(("", 1, b' ', self.name)),
                formal_charge: stated.or(meaning.map(|meaning| meaning.charge)).unwrap_or(0),
                isotope: meaning.map_or(0, |meaning| meaning.isotope),
                ..AtomRecord::default()
            });
        }
        unknown.warn(diagnostics);
        let missing = self.rows.len() - builder.atom_count();
        if missing > 0 {
            let line = table.row(self.rows[0]).line();
            diagnostics.error(
                line,
                format!("{missing} atoms of {} have no coordinates and are left out", shown(self.name.as_bytes())),
            );
        }
        builder.set_decimals(decimals);
        builder
    }
}

/// The component's full name with its code, or what there is of the two.
fn title(block: &impl Block, code: &str) -> String {
    let table = block.table(Category::ChemComp);
    let name = table.as_ref().and_then(|table| {
        let [id, name] = [table.column("id"), table.column("name")];
        let row = (0..table.row_count()).find(|&index| table.row(index).text(id).is_some_and(|id| id == code))?;
        Some(super::block::one_line(&table.row(row).text(name)?))
    });
    match (name, code) {
        (Some(name), "") => name,
        (Some(name), code) => format!("{name} ({code})"),
        (None, "") => block.name().into_owned(),
        (None, code) => code.to_owned(),
    }
}

fn push_bonds(
    builder: &mut StructureBuilder,
    name: &str,
    bonds: &[ComponentBond],
    ligand: &Ligand<'_>,
    table: &impl Table,
    diagnostics: &mut Diagnostics,
) {
    let column = table.column("atom_id");
    let names =
        ligand.positioned(table).filter_map(|(index, ..)| table.row(index).text(column).map(|name| name.into_owned()));
    let atoms: HashMap<String, u32> = names.zip(0u32..).collect();
    let mut missing = Repeated::default();
    for bond in bonds {
        let (Some(&a), Some(&b)) = (atoms.get(&bond.a), atoms.get(&bond.b)) else {
            missing.note(0, || {
                let pair = shown(format!("{}–{}", bond.a, bond.b).as_bytes());
                format!("{}: the bond {pair} names an atom that is not there and is left out", shown(name.as_bytes()))
            });
            continue;
        };
        builder.push_bond(Bond { aromatic: bond.aromatic, ..Bond::new(a, b, bond.order, BondSource::File) });
    }
    missing.warn(diagnostics);
}
