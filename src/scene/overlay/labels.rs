//! Labels of atoms and residues.

use crate::element::Element;
use crate::scene::build::Item;
use crate::scene::{Placement, SphereInstance};
use crate::structure::{Residue, Structure};
use glam::Vec3;
use std::fmt::Write;

/// What labels say. Element and number stand together (`C12`), the name before them with a blank (`CA 12`); residues have
/// labels of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LabelContent {
    /// The symbol of every atom's element.
    pub element: bool,
    /// The number of every atom in its file, from 1.
    pub index: bool,
    /// The name of every atom; the symbol of its element where the file gives no names.
    pub name: bool,
    /// Name and number of every residue (`GLY 12`), at its Cα or, without, in its middle.
    pub residue: bool,
}

/// A text that stands for something at a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// What it says.
    pub text: Box<str>,
    /// Where, world space.
    pub anchor: Vec3,
    /// First and last id of what it stands for: it is seen where one of them is, at the anchor.
    pub ids: [u32; 2],
    /// How far what it stands for reaches from the anchor to the viewer, in ångström.
    pub radius: f32,
}

/// Adds the labels of one item, whose atoms are these balls (in the order of their ids).
pub(super) fn of_item(
    item: &Item<'_>,
    placement: &Placement,
    spheres: &[SphereInstance],
    content: LabelContent,
    is_labelled: impl Fn(usize) -> bool,
    labels: &mut Vec<Label>,
) {
    // Before those of atoms, so that at a Cα the residue's stays.
    if content.residue {
        of_residues(item.structure, placement, spheres, &is_labelled, labels);
    }
    if !(content.element || content.index || content.name) {
        return;
    }
    let atoms = spheres.iter().filter_map(|sphere| Some((sphere, atom_of(item.structure, sphere)?)));
    let atoms = atoms.filter(|&(_, atom)| is_labelled(atom));
    labels.extend(atoms.map(|(sphere, atom)| {
        let id = placement.first_id.saturating_add(sphere.id);
        let number = item.listed.get(atom).map_or(atom, |&listed| listed as usize) + 1;
        Label {
            text: atom_text(item.structure, atom, number, content),
            anchor: placement.world_from_block.transform_point3(sphere.center.into()),
            ids: [id, id],
            radius: sphere.radius,
        }
    }));
}

/// The atom that a ball stands for.
pub(super) fn atom_of(structure: &Structure, sphere: &SphereInstance) -> Option<usize> {
    let atom = sphere.id.checked_sub(1)? as usize;
    (atom < structure.atom_count()).then_some(atom)
}

fn atom_text(structure: &Structure, atom: usize, number: usize, content: LabelContent) -> Box<str> {
    let symbol = structure.elements()[atom].symbol();
    let name = Some(structure.atom_name(atom).trim()).filter(|name| content.name && !name.is_empty());
    let mut text = name.unwrap_or_default().to_owned();
    if name.is_some() && (content.element || content.index) {
        text.push(' ');
    }
    if content.element || (content.name && name.is_none()) {
        text.push_str(symbol);
    }
    if content.index {
        // Writing to a String cannot fail.
        let _ = write!(text, "{number}");
    }
    text.into_boxed_str()
}

/// A residue of which any atom is to be labelled has its label.
fn of_residues(
    structure: &Structure,
    placement: &Placement,
    mut spheres: &[SphereInstance],
    is_labelled: impl Fn(usize) -> bool,
    labels: &mut Vec<Label>,
) {
    let residues = structure.residues();
    for (index, residue) in residues.iter().enumerate() {
        let end = residues.get(index + 1).map_or(u32::MAX, |next| next.first_atom);
        // Ids are 1 + atom, in order.
        let before = spheres.partition_point(|sphere| sphere.id <= residue.first_atom);
        let own = &spheres[before..];
        let (own, rest) = own.split_at(own.partition_point(|sphere| sphere.id <= end));
        spheres = rest;
        let (Some(first), Some(last)) = (own.first(), own.last()) else { continue };
        if !own.iter().any(|sphere| atom_of(structure, sphere).is_some_and(&is_labelled)) {
            continue;
        }
        let is_alpha = |sphere: &&SphereInstance| {
            atom_of(structure, sphere).is_some_and(|atom| {
                structure.elements()[atom] == Element::C && structure.atom_name(atom).trim() == "CA"
            })
        };
        let (middle, radius) = match own.iter().find(is_alpha) {
            Some(alpha) => (Vec3::from(alpha.center), alpha.radius),
            None => (own.iter().map(|sphere| Vec3::from(sphere.center)).sum::<Vec3>() / own.len() as f32, 0.0),
        };
        labels.push(Label {
            text: residue_text(structure, residue),
            anchor: placement.world_from_block.transform_point3(middle),
            ids: [first.id, last.id].map(|id| placement.first_id.saturating_add(id)),
            radius,
        });
    }
}

fn residue_text(structure: &Structure, residue: &Residue) -> Box<str> {
    let (name, code) = (structure.name(residue.name).trim(), char::from(residue.insertion_code));
    let text =
        format!("{name} {}{}", residue.number, if code.is_ascii_graphic() { code.to_string() } else { String::new() });
    text.trim().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{OverlayOptions, Scene, SceneOptions};
    use crate::structure::{AtomRecord, Diagnostics, StructureBuilder};
    use glam::DVec3;

    fn labels(structure: &Structure, content: LabelContent) -> Vec<(String, Vec3)> {
        let overlay = OverlayOptions { labels: content, ..OverlayOptions::default() };
        let orientation = crate::scene::Orientation::Along { direction: Vec3::NEG_Z, up: Vec3::Y };
        let options = SceneOptions { text: overlay, orientation, ..SceneOptions::default() };
        let scene = Scene::new(&[Item::of(structure)], &options);
        scene.overlay.labels.iter().map(|label| (label.text.to_string(), label.anchor)).collect()
    }

    fn texts(structure: &Structure, content: LabelContent) -> Vec<String> {
        labels(structure, content).into_iter().map(|(text, _)| text).collect()
    }

    const NONE: LabelContent = LabelContent { element: false, index: false, name: false, residue: false };

    fn peptide() -> Structure {
        let mut builder = StructureBuilder::new();
        for (element, name, x, residue) in [
            (Element::N, "N", 0.0, ("A", 12, b' ', "GLY")),
            (Element::C, "CA", 2.0, ("A", 12, b' ', "GLY")),
            (Element::from_symbol("Ca").unwrap(), "CA", 10.0, ("A", 13, b'B', "CA")),
            (Element::O, "O1", 20.0, ("B", -1, b' ', "SO4")),
            (Element::O, "O2", 24.0, ("B", -1, b' ', "SO4")),
        ] {
            let position = DVec3::new(x, 0.0, 0.0);
            builder.push_atom(&AtomRecord { element, name, position, residue: Some(residue), ..AtomRecord::default() });
        }
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn what_a_label_says() {
        let structure = peptide();
        assert_eq!(texts(&structure, NONE), [""; 0]);
        let both = LabelContent { element: true, index: true, ..NONE };
        assert_eq!(texts(&structure, both), ["N1", "C2", "Ca3", "O4", "O5"]);
        assert_eq!(texts(&structure, LabelContent { name: true, ..NONE }), ["N", "CA", "CA", "O1", "O2"]);
        assert_eq!(texts(&structure, LabelContent { name: true, ..both })[1], "CA C2");
        assert_eq!(texts(&structure, LabelContent { name: true, index: true, ..NONE })[3], "O1 4");
    }

    #[test]
    fn residues_are_labelled_at_their_alpha_carbon_or_in_their_middle() {
        let found = labels(&peptide(), LabelContent { residue: true, ..NONE });
        let texts: Vec<&str> = found.iter().map(|(text, _)| text.as_str()).collect();
        assert_eq!(texts, ["GLY 12", "CA 13B", "SO4 -1"]);
        // The scene's middle is at 12 Å.
        let x: Vec<f32> = found.iter().map(|(_, anchor)| anchor.x + 12.0).collect();
        for (x, expected) in x.iter().zip([2.0, 10.0, 22.0]) {
            assert!((x - expected).abs() < 1e-4, "{x} for {expected}");
        }
    }

    #[test]
    fn without_names_the_element_stands_in_and_copies_keep_the_number_of_the_file() {
        let mut builder = StructureBuilder::new();
        for x in [0.0, 3.0] {
            let position = DVec3::new(x, 0.0, 0.0);
            builder.push_atom(&AtomRecord { element: Element::CL, position, ..AtomRecord::default() });
        }
        let structure = builder.build(&mut Diagnostics::default());
        let content = LabelContent { name: true, index: true, ..NONE };
        assert_eq!(texts(&structure, content), ["Cl1", "Cl2"]);
        assert_eq!(texts(&structure, LabelContent { residue: true, ..NONE }), [""; 0]);
        let item = Item { listed: &[6, 6], ..Item::of(&structure) };
        let overlay = OverlayOptions { labels: content, ..OverlayOptions::default() };
        let scene = Scene::new(&[item], &SceneOptions { text: overlay, ..SceneOptions::default() });
        assert!(scene.overlay.labels.iter().all(|label| &*label.text == "Cl7"));
    }
}
