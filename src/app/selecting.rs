//! Selecting atoms by words, in rectangles and by bonds, and what is done with them.
//!
//! What is done is written down as a selection ([`crate::select`]), so that sessions and command lines have it: the words that the atoms
//! were selected by, if they were, else their numbers.

use super::picking;
use super::state::State;
use super::work::{AtomKey, Work};
use crate::color::Srgb8;
use crate::scene::{BySelection, Camera, Style};
use crate::select::{ParseError, Scope, Selection};
use crate::structure::BondKind;
use std::collections::HashMap;
use std::sync::Arc;

/// Ways to select.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum How {
    /// To begin to write a selection.
    Write,
    /// What these words say.
    Words(String),
    /// These atoms in place of what is selected.
    These(Vec<AtomKey>),
    /// These as well.
    Also(Vec<AtomKey>),
    /// All others.
    Invert,
    /// What they have bonds to as well.
    Grow,
}

/// What is done with selected atoms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Deed {
    Hide,
    ShowOnly,
    /// To show all atoms again, selected or not.
    ShowAll,
    Color(Srgb8),
    Style(Style),
    Label,
    /// To forget what selections of this flag say, by its number among them.
    Forget(&'static str, usize),
    ForgetAll,
}

impl Deed {
    /// Whether it is about selected atoms.
    fn needs_atoms(self) -> bool {
        !matches!(self, Deed::ShowAll | Deed::Forget(..) | Deed::ForgetAll)
    }
}

/// What is drawn of each file, with its place among all.
pub(super) fn scopes(state: &State) -> Vec<(u32, Scope<'_>)> {
    let place = |id: u32| state.work.layers.iter().position(|layer| layer.id == id);
    (state.built.drawn.iter())
        .filter_map(|(id, drawn)| {
            let file = u32::try_from(place(*id)? + 1).ok()?;
            Some((*id, Scope::drawn(drawn, file)))
        })
        .collect()
}

/// The atoms that words select.
pub(super) fn find(state: &State, text: &str) -> Result<(Selection, Vec<AtomKey>), ParseError> {
    let selection = Selection::parse(text)?;
    let mut keys = Vec::new();
    for (layer, scope) in scopes(state) {
        let atoms = selection.atoms(scope).into_iter().zip(0u32..).filter(|&(is, _)| is);
        keys.extend(atoms.map(|(_, atom)| AtomKey { layer, atom }));
    }
    Ok((selection, keys))
}

/// Selects.
pub(super) fn choose(state: &mut State, how: How) {
    match how {
        How::Write => {
            state.preferences.panel = true;
            state.shown.write_selection = true;
        }
        How::Words(text) => match find(state, &text) {
            Ok((selection, keys)) => {
                if keys.is_empty() {
                    state.say(format!("Nothing is selected: no atom is {selection}."));
                }
                state.measuring = false;
                state.work.picked = Arc::new(keys);
                state.work.picked_by = Some((Arc::clone(&state.work.picked), selection));
            }
            Err(error) => state.complain(error.to_string()),
        },
        How::These(keys) => state.work.picked = Arc::new(keys),
        How::Also(keys) => also(&mut state.work, keys),
        How::Invert => {
            let by = picked_by(&state.work).map(|selection| format!("not ({selection})"));
            match by {
                Some(text) => choose(state, How::Words(text)),
                None => {
                    let mut picked = state.work.picked.to_vec();
                    picked.sort_unstable();
                    let mut all = picking::keys(state, |_, _, _| true);
                    all.retain(|key| picked.binary_search(key).is_err());
                    state.work.picked = Arc::new(all);
                }
            }
        }
        How::Grow => {
            let mut new = Vec::new();
            for (layer, drawn) in &state.built.drawn {
                // Copy by copy.
                let mut picked: HashMap<u32, Vec<bool>> = HashMap::new();
                let count = drawn.structure.atom_count();
                for key in state.work.picked.iter().filter(|key| key.layer == *layer) {
                    if let Some((copy, own)) = drawn.own_atom(key.atom) {
                        picked.entry(copy).or_insert_with(|| vec![false; count])[own] = true;
                    }
                }
                for (copy, is_picked) in picked {
                    let before = copy * u32::try_from(count).unwrap_or(0);
                    for bond in drawn.structure.bonds().iter().filter(|bond| bond.kind != BondKind::Hydrogen) {
                        for (from, to) in [(bond.a, bond.b), (bond.b, bond.a)] {
                            if is_picked[from as usize] && !is_picked[to as usize] {
                                new.push(AtomKey { layer: *layer, atom: before + to });
                            }
                        }
                    }
                }
            }
            also(&mut state.work, new);
        }
    }
}

fn also(work: &mut Work, keys: Vec<AtomKey>) {
    let mut seen: std::collections::HashSet<AtomKey> = work.picked.iter().copied().collect();
    let new: Vec<AtomKey> = keys.into_iter().filter(|key| seen.insert(*key)).collect();
    if !new.is_empty() {
        Arc::make_mut(&mut work.picked).extend(new);
    }
}

/// The words that the selected atoms were selected by, if that is so.
pub(super) fn picked_by(work: &Work) -> Option<&Selection> {
    work.picked_by.as_ref().filter(|(picked, _)| Arc::ptr_eq(picked, &work.picked)).map(|(_, selection)| selection)
}

/// The selected atoms as a selection; `None` if there are none.
fn selection(state: &State) -> Option<Selection> {
    let work = &state.work;
    if work.picked.is_empty() {
        return None;
    }
    if let Some(selection) = picked_by(work) {
        return Some(selection.clone());
    }
    let mut by_layer: HashMap<u32, Vec<u32>> = HashMap::new();
    for key in work.picked.iter() {
        // What is said of an atom holds in all of its copies.
        let own = picking::drawn(state, key.layer).and_then(|drawn| drawn.own_atom(key.atom));
        let atom = own.map_or(key.atom, |(_, own)| u32::try_from(own).unwrap_or(u32::MAX));
        by_layer.entry(key.layer).or_default().push(atom.saturating_add(1));
    }
    let mut all = Vec::new();
    for (place, layer) in work.layers.iter().enumerate() {
        let Some(mut numbers) = by_layer.remove(&layer.id) else { continue };
        numbers.sort_unstable();
        numbers.dedup();
        // In a crystal several atoms have one number of the file.
        let by_index = picking::drawn(state, layer.id).is_none_or(|drawn| drawn.listed.is_empty());
        all.push(Selection::of_numbers(u32::try_from(place + 1).ok()?, &numbers, by_index));
    }
    Some(Selection::any_of(&all))
}

/// Does something with what is selected.
pub(super) fn act(state: &mut State, deed: Deed) {
    let selection = selection(state);
    if deed.needs_atoms() && selection.is_none() {
        return state.say("Nothing is selected: click atoms, or write a selection (Ctrl+F).");
    }
    let scene = &mut state.work.scene;
    let by = &mut scene.by_selection;
    match (deed, selection) {
        (Deed::Hide, Some(selection)) => {
            by.hide.retain(|other| *other != selection);
            by.hide.push(selection);
        }
        (Deed::ShowOnly, Some(selection)) => (by.show, by.hide) = (vec![selection], Vec::new()),
        (Deed::Color(color), Some(selection)) => {
            by.colors.retain(|(other, _)| *other != selection);
            by.colors.push((selection, color));
        }
        (Deed::Style(style), Some(selection)) => {
            by.styles.retain(|(other, _)| *other != selection);
            by.styles.push((selection, style));
        }
        (Deed::Label, Some(selection)) => {
            by.labels = vec![selection];
            let labels = &mut scene.text.labels;
            // Something to be seen, where labels say nothing yet.
            labels.name |= !(labels.element || labels.index || labels.residue);
        }
        (Deed::ShowAll, _) => (by.show, by.hide) = (Vec::new(), Vec::new()),
        (Deed::Forget(flag, number), _) => forget(by, flag, number),
        (Deed::ForgetAll, _) => *by = BySelection::default(),
        // Said above.
        (Deed::Hide | Deed::ShowOnly | Deed::Color(_) | Deed::Style(_) | Deed::Label, None) => {}
    }
}

fn forget(by: &mut BySelection, flag: &str, number: usize) {
    fn remove<T>(all: &mut Vec<T>, number: usize) {
        if number < all.len() {
            all.remove(number);
        }
    }
    match flag {
        "show" => remove(&mut by.show, number),
        "hide" => remove(&mut by.hide, number),
        "color" => remove(&mut by.colors, number),
        "style" => remove(&mut by.styles, number),
        _ => remove(&mut by.labels, number),
    }
}

/// Gives files of selections their new places after one came or went. What was said of atoms of a file that is closed goes with it.
pub(super) fn follow_files(before: &Work, work: &mut Work) {
    let same = before.layers.iter().map(|layer| layer.id).eq(work.layers.iter().map(|layer| layer.id));
    if same || work.scene.by_selection == BySelection::default() {
        return;
    }
    let place = |file: u32| {
        let id = before.layers.get(file.checked_sub(1)? as usize)?.id;
        let at = work.layers.iter().position(|layer| layer.id == id)?;
        u32::try_from(at + 1).ok()
    };
    let is_left = |selection: &Selection| !selection.text().starts_with("none and ");
    let mut by = work.scene.by_selection.map(|selection| selection.with_files(place));
    by.show.retain(is_left);
    by.hide.retain(is_left);
    by.labels.retain(is_left);
    by.colors.retain(|(selection, _)| is_left(selection));
    by.styles.retain(|(selection, _)| is_left(selection));
    work.scene.by_selection = by;
}

/// The atoms whose middle is in a rectangle of the picture, in pixels from its upper left corner, whatever is before them.
pub(super) fn in_rectangle(state: &State, [low, high]: [[f32; 2]; 2]) -> Vec<AtomKey> {
    let (scene, view) = (&state.built.scene, state.view());
    let camera: &Camera = &view.camera;
    let (view_from_world, grid) = (camera.view_from_world(), view.pixel_grid());
    let is_inside = |point: glam::Vec3| {
        let p = view_from_world.transform_point3(point);
        let per_angstrom = 1.0 / (grid.plane_per_px * if grid.orthographic { 1.0 } else { -p.z });
        let x = grid.center_px[0] + p.x * per_angstrom;
        let y = grid.center_px[1] - p.y * per_angstrom;
        -p.z > camera.near && (low[0]..=high[0]).contains(&x) && (low[1]..=high[1]).contains(&y)
    };
    let mut keys = Vec::new();
    for ((layer, _), ids) in state.built.drawn.iter().zip(&scene.items) {
        for placement in scene.placements.get(ids.placements.clone()).unwrap_or_default() {
            let before = ids.copy_of(placement).saturating_mul(ids.atoms);
            for ball in &scene.blocks[placement.block].spheres {
                let atom = ball.id.wrapping_sub(1);
                let is_atom = atom < ids.atoms;
                if is_atom && is_inside(placement.world_from_block.transform_point3(ball.center.into())) {
                    keys.push(AtomKey { layer: *layer, atom: before.saturating_add(atom) });
                }
            }
        }
    }
    keys
}
