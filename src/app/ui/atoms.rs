//! The list of atoms: only the rows that are seen are made, so that a million costs nothing.

use super::panel::grouped;
use crate::app::action::Action;
use crate::app::picking;
use crate::app::state::State;
use crate::app::work::AtomKey;
use egui::{RichText, ScrollArea, Ui};
use std::collections::HashSet;
use std::sync::Arc;

/// What the list keeps: what is picked, looked up fast, and which atom it last went to.
#[derive(Default)]
pub(super) struct Memory {
    picked: Option<Arc<Vec<AtomKey>>>,
    set: HashSet<AtomKey>,
}

/// Height of the list and of its rows, points.
const HEIGHT: f32 = 220.0;
const ROW: f32 = 22.0;

/// Shows the list.
pub(super) fn show(ui: &mut Ui, state: &State, memory: &mut Memory, actions: &mut Vec<Action>) {
    let picked = &state.work.picked;
    let is_new = !memory.picked.as_ref().is_some_and(|old| Arc::ptr_eq(old, picked));
    if is_new {
        memory.set = picked.iter().copied().collect();
        memory.picked = Some(Arc::clone(picked));
    }
    let counts: Vec<usize> = state.built.drawn.iter().map(|(_, drawn)| drawn.structure.atom_count()).collect();
    let all: usize = counts.iter().sum();
    ui.label(RichText::new(format!("{} atoms", grouped(all))).weak());
    let mut area = ScrollArea::vertical().max_height(HEIGHT).auto_shrink([false, true]).id_salt("atoms");
    if let (true, Some(row)) = (is_new, picked.last().and_then(|&key| row_of(state, key))) {
        // What was picked in the picture comes into sight.
        area = area.vertical_scroll_offset((row as f32 * (ROW + ui.spacing().item_spacing.y) - HEIGHT * 0.4).max(0.0));
    }
    area.show_rows(ui, ROW, all, |ui, rows| {
        for row in rows {
            let Some((layer, drawn, atom)) = atom_of(state, row) else { continue };
            let key = AtomKey { layer, atom: u32::try_from(atom).unwrap_or(u32::MAX) };
            let text = format!("{}   {}", row + 1, picking::short_name(&drawn.structure, atom));
            let button = egui::Button::selectable(memory.set.contains(&key), text)
                .min_size(egui::vec2(ui.available_width(), ROW));
            let response = ui.add(button);
            if response.double_clicked() {
                actions.extend(picking::ball(state, key).map(|(center, _)| Action::CenterOn(center)));
            } else if response.clicked() {
                let adds = ui.input(|input| input.modifiers.shift || input.modifiers.command);
                actions.push(if adds { Action::PickAlso(key) } else { Action::Pick(Some(key)) });
            }
        }
    });
}

fn atom_of(state: &State, mut row: usize) -> Option<(u32, &Arc<crate::crystal::Drawn>, usize)> {
    for (layer, drawn) in &state.built.drawn {
        let count = drawn.structure.atom_count();
        if row < count {
            return Some((*layer, drawn, row));
        }
        row -= count;
    }
    None
}

fn row_of(state: &State, key: AtomKey) -> Option<usize> {
    let mut before = 0;
    for (layer, drawn) in &state.built.drawn {
        if *layer == key.layer {
            return Some(before + drawn.own_atom(key.atom)?.1);
        }
        before += drawn.structure.atom_count();
    }
    None
}
