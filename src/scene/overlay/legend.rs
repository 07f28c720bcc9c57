//! The legend: which colour is which element, chain or residue, of the atoms that are drawn.

use super::labels::atom_of;
use crate::color::Srgb8;
use crate::element::Element;
use crate::scene::chosen::Chosen;
use crate::scene::{ColorBy, SphereInstance};
use crate::select::Selection;
use crate::structure::{NameId, Structure};
use std::cmp::Ordering;
use std::collections::HashMap;

/// One colour and what has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LegendRow {
    /// The colour.
    pub color: Srgb8,
    /// Elements, chains or residues of this colour.
    pub names: Vec<String>,
}

/// What an atom is told apart by, inside its structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Key {
    Element(Element),
    Chain(u32),
    Residue(NameId),
    /// The number of the selection that gives the colour.
    Selection(usize),
}

/// The rows for these structures and their balls: elements in the order of formulas (Hill: carbon, hydrogen, then by
/// symbol), chains as they come in the files, residues by name; then what selections colour, in their order.
pub(super) fn rows<'a>(
    color_by: ColorBy,
    by_selection: &[(Selection, Srgb8)],
    drawn: impl Iterator<Item = (&'a Structure, &'a [SphereInstance], &'a Chosen)>,
) -> Vec<LegendRow> {
    let mut found: Vec<(u8, String, Srgb8)> = Vec::new();
    for (structure, spheres, chosen) in drawn {
        // Names are made once a structure, not once an atom.
        let mut seen: HashMap<Key, Srgb8> = HashMap::new();
        for sphere in spheres {
            let Some(atom) = atom_of(structure, sphere) else { continue };
            let key = chosen.recolored(atom).map_or_else(|| key_of(color_by, structure, atom), Key::Selection);
            if seen.insert(key, sphere.color).is_none() {
                let (rank, name) = match key {
                    Key::Selection(number) => {
                        let name = by_selection.get(number).map_or("", |(selection, _)| selection.text());
                        (BY_SELECTION.saturating_add(u8::try_from(number).unwrap_or(u8::MAX)), name.to_owned())
                    }
                    key => name_of(structure, key),
                };
                let entry = (rank, name, sphere.color);
                if !found.contains(&entry) {
                    found.push(entry);
                }
            }
        }
    }
    // Stable: chains stay in the order of the files. Atoms without residues, coloured by element, come last.
    found.sort_by(|a, b| {
        let by_name = || if matches!(a.0, CHAIN | BY_SELECTION..) { Ordering::Equal } else { a.1.cmp(&b.1) };
        a.0.cmp(&b.0).then_with(by_name)
    });
    let mut rows: Vec<LegendRow> = Vec::new();
    for (_, name, color) in found {
        match rows.iter_mut().find(|row| row.color == color) {
            Some(row) => row.names.push(name),
            None => rows.push(LegendRow { color, names: vec![name] }),
        }
    }
    rows
}

/// The rank of chains.
const CHAIN: u8 = 0;
/// That of what the first selection colours, behind all else; the others follow.
const BY_SELECTION: u8 = 5;

fn key_of(color_by: ColorBy, structure: &Structure, atom: usize) -> Key {
    let residue = structure.residue_index(atom).and_then(|index| structure.residues().get(index));
    match (color_by, residue) {
        (ColorBy::Chain, Some(residue)) => Key::Chain(residue.chain),
        (ColorBy::Residue, Some(residue)) => Key::Residue(residue.name),
        _ => Key::Element(structure.elements()[atom]),
    }
}

/// Rank and name.
fn name_of(structure: &Structure, key: Key) -> (u8, String) {
    let or_dash = |name: &str| if name.trim().is_empty() { "–".to_owned() } else { name.trim().to_owned() };
    match key {
        Key::Chain(chain) => (CHAIN, or_dash(structure.chains().nth(chain as usize).unwrap_or_default())),
        Key::Residue(name) => (1, or_dash(structure.name(name))),
        Key::Element(element) => {
            let rank = match element {
                Element::C => 2,
                Element::H => 3,
                _ => 4,
            };
            (rank, element.symbol().to_owned())
        }
        // Selections are named by their texts.
        Key::Selection(_) => (BY_SELECTION, String::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{AltlocChoice, Item, OverlayOptions, Scene, SceneOptions};
    use crate::structure::{AtomRecord, Diagnostics, StructureBuilder};
    use glam::DVec3;

    fn structure() -> Structure {
        let mut builder = StructureBuilder::new();
        let atoms = [
            (Element::from_symbol("Zn").unwrap(), ("B", 1, b' ', "ZN"), b' '),
            (Element::N, ("B", 2, b' ', "GLU"), b' '),
            (Element::H, ("A", 3, b' ', "ASP"), b' '),
            (Element::C, ("A", 3, b' ', "ASP"), b'A'),
            // Not drawn: the other location has no lower occupancy and comes first.
            (Element::S, ("A", 3, b' ', "ASP"), b'B'),
        ];
        for (index, (element, residue, altloc)) in atoms.into_iter().enumerate() {
            let position = DVec3::new(2.0 * index as f64, 0.0, 0.0);
            builder.push_atom(&AtomRecord {
                element,
                position,
                residue: Some(residue),
                altloc,
                ..AtomRecord::default()
            });
        }
        builder.build(&mut Diagnostics::default())
    }

    fn legend(color_by: ColorBy, altloc: AltlocChoice) -> Vec<String> {
        let overlay = OverlayOptions { legend: true, ..OverlayOptions::default() };
        let structure = structure();
        let options = SceneOptions { color_by, text: overlay, altloc, ..SceneOptions::default() };
        let scene = Scene::new(&[Item::of(&structure), Item::of(&structure)], &options);
        for row in &scene.overlay.legend {
            assert!(scene.blocks[0].spheres.iter().any(|sphere| sphere.color == row.color));
        }
        scene.overlay.legend.iter().map(|row| row.names.join(", ")).collect()
    }

    #[test]
    fn it_lists_exactly_what_is_drawn() {
        assert_eq!(legend(ColorBy::Element, AltlocChoice::Highest), ["C", "H", "N", "Zn"]);
        assert_eq!(legend(ColorBy::Element, AltlocChoice::All), ["C", "H", "N", "S", "Zn"]);
        assert_eq!(legend(ColorBy::Chain, AltlocChoice::Highest), ["B", "A"]);
        // Acids share a colour.
        assert_eq!(legend(ColorBy::Residue, AltlocChoice::Highest), ["ASP, GLU", "ZN"]);
    }
}
