//! What balls and sticks are called: atoms, residues and chains by the ids of their primitives.

use super::{Model, Source};
use crate::structure::Structure;
use serde_json::{Value, json};

impl Model<'_> {
    /// The structure that stands at a placement.
    pub(super) fn source(&self, placement: usize) -> Option<&Source<'_>> {
        let item = self.scene.items.iter().position(|ids| ids.placements.contains(&placement))?;
        self.sources.get(item)
    }

    /// What a placement is called: its file, or what it is.
    pub(super) fn placement_name(&self, placement: usize) -> String {
        let block = self.scene.placements.get(placement).map(|placement| &self.scene.blocks[placement.block]);
        match (self.source(placement), block) {
            (Some(source), _) => source.name.to_owned(),
            (None, Some(block)) if !block.triangles.is_empty() => format!("overlay {}", placement + 1),
            _ => format!("lines {}", placement + 1),
        }
    }
}

/// The atom that an id of a structure stands for; of a bond the first one.
pub(super) fn atom_of(structure: &Structure, id: u32) -> Option<usize> {
    let index = (id as usize).checked_sub(1)?;
    match index.checked_sub(structure.atom_count()) {
        None => Some(index),
        Some(bond) => structure.bonds().get(bond).map(|bond| bond.a as usize),
    }
}

/// Chain, name and number of the residue of an atom, as in `A_GLY_12`; `None` if it is in none.
pub(super) fn residue_name(structure: &Structure, atom: usize) -> Option<String> {
    let residue = structure.residues().get(structure.residue_index(atom)?)?;
    let chain = structure.chains().nth(residue.chain as usize).unwrap_or_default();
    let mut text = format!("{chain}_{}_{}", structure.name(residue.name), residue.number);
    if residue.insertion_code.is_ascii_graphic() {
        text.push(char::from(residue.insertion_code));
    }
    Some(text)
}

/// Everything about a structure's atoms, as lists in their order; residues by their places in the list of residues.
pub(super) fn extras(source: &Source<'_>) -> Value {
    let structure = source.structure;
    let atoms = 0..structure.atom_count();
    let chains: Vec<&str> = structure.chains().collect();
    let residue = |residue: &crate::structure::Residue| {
        let code = char::from(residue.insertion_code);
        let code = if code.is_ascii_graphic() { code.to_string() } else { String::new() };
        json!([chains.get(residue.chain as usize), structure.name(residue.name), residue.number, code])
    };
    let residues: Vec<Value> = structure.residues().iter().map(residue).collect();
    let residue_of: Vec<Option<usize>> = match residues.is_empty() {
        true => Vec::new(),
        false => atoms.clone().map(|atom| structure.residue_index(atom)).collect(),
    };
    json!({
        "file": source.name,
        "title": structure.title(),
        "ids": "1 + place of an atom; 1 + number of atoms + place of a bond",
        "elements": structure.elements().iter().map(|element| element.symbol()).collect::<Vec<_>>(),
        "names": atoms.map(|atom| structure.atom_name(atom)).collect::<Vec<_>>(),
        "residue_of_atom": residue_of,
        "residues": residues,
        "residue_fields": ["chain", "name", "number", "insertion_code"],
    })
}
