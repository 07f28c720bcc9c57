//! What a residue of a name may be: its atoms by name, and their bonds.

use super::super::dictionary::{self, DictionaryBond};
use super::alias;
use crate::element::Element;
use crate::structure::{BondOrder, BondSource, ComponentBonds};
use std::collections::HashMap;

/// A residue as the dictionary or the file itself knows it.
#[derive(Debug, Clone)]
pub(super) struct Template {
    /// The id in the dictionary.
    pub(super) id: String,
    /// Who says so.
    pub(super) source: BondSource,
    pub(super) names: HashMap<Box<str>, u32>,
    /// Element of each atom; `None` where nothing is said of it.
    pub(super) elements: Vec<Option<Element>>,
    /// Whether each atom is a hydrogen; by its name where nothing is said of its element.
    pub(super) hydrogen: Vec<bool>,
    pub(super) bonds: Vec<DictionaryBond>,
}

/// The most bonds that a file's own component may have: more than any has, and they are numbered in 16 bits.
const MOST_OWN_BONDS: usize = 30_000;

/// All that a residue of this name may be: what the file says of it goes alone if it fits.
pub(super) fn candidates(name: &str, own: &[ComponentBonds], with_dictionary: bool) -> Vec<Template> {
    let mut out: Vec<Template> = own.iter().filter(|own| own.name == name).filter_map(of_file).collect();
    if with_dictionary {
        for id in alias::components(name) {
            out.extend(of_dictionary(id, name));
        }
        if !out.iter().any(|template| template.id == name && template.source == BondSource::Dictionary) {
            out.extend(of_dictionary(name, name));
        }
    }
    out
}

fn of_file(own: &ComponentBonds) -> Option<Template> {
    if own.bonds.len() > MOST_OWN_BONDS {
        return None;
    }
    let mut names: HashMap<Box<str>, u32> = HashMap::new();
    let mut bonds = Vec::with_capacity(own.bonds.len());
    for bond in &own.bonds {
        let [a, b] = [&bond.a, &bond.b].map(|name| {
            let next = names.len() as u32; // at most twice as many as bonds
            *names.entry(name.as_str().into()).or_insert(next) as u16
        });
        if a != b {
            bonds.push(DictionaryBond { a: a.min(b), b: a.max(b), order: bond.order, aromatic: bond.aromatic });
        }
    }
    let elements = vec![None; names.len()];
    let mut hydrogen = vec![false; names.len()];
    for (name, &number) in &names {
        hydrogen[number as usize] = name.trim_start_matches(|c: char| c.is_ascii_digit()).starts_with(['H', 'D']);
    }
    Some(Template { id: own.name.clone(), source: BondSource::File, names, elements, hydrogen, bonds })
}

fn of_dictionary(id: &str, residue: &str) -> Option<Template> {
    let component = dictionary::component(id)?;
    let mut names: HashMap<Box<str>, u32> = HashMap::with_capacity(component.atoms.len());
    for (number, atom) in component.atoms.iter().enumerate() {
        let length = atom.name.iter().position(|&byte| byte == 0).unwrap_or(atom.name.len());
        names.insert(std::str::from_utf8(&atom.name[..length]).ok()?.into(), number as u32); // at most 4096
    }
    let mut bonds = component.bonds.clone();
    if id == "HIS" && alias::is_delta_histidine(residue) {
        let [nd1, ce1, ne2] = ["ND1", "CE1", "NE2"].map(|name| names.get(name).copied());
        for bond in &mut bonds {
            let pair = [Some(u32::from(bond.a)), Some(u32::from(bond.b))];
            if pair.contains(&ce1) && pair.contains(&nd1) {
                bond.order = BondOrder::Single;
            } else if pair.contains(&ce1) && pair.contains(&ne2) {
                bond.order = BondOrder::Double;
            }
        }
    }
    // X stands for one of two elements, or for any.
    let element = |element: Element| (element != Element::DUMMY).then_some(element);
    let elements = component.atoms.iter().map(|atom| element(atom.element)).collect();
    let hydrogen = component.atoms.iter().map(|atom| atom.element == Element::H).collect();
    Some(Template { id: id.to_owned(), source: BondSource::Dictionary, names, elements, hydrogen, bonds })
}
