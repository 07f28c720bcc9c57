//! The interface: what egui shows of the state, and what of its input becomes actions.

mod atoms;
mod dialogs;
mod film;
mod frames;
mod help;
#[cfg(test)]
mod keys_tests;
mod notices;
mod palette;
mod panel;
#[cfg(test)]
mod panel_tests;
mod parts;
mod selecting;
mod sequence;
mod start;
#[cfg(test)]
mod tests;
pub(super) mod theme;
mod tip;
mod view;

use super::action::Action;
use super::commands;
use super::state::State;
use egui::{Event, Rect, Ui};

/// What the interface keeps from frame to frame that is nobody else's business.
#[derive(Default)]
pub(super) struct Memory {
    palette: palette::Memory,
    view: view::Memory,
    atoms: atoms::Memory,
    selecting: selecting::Memory,
    sequence: sequence::Memory,
}

/// A window narrower than this, in points, has no room for the panel.
const LEAST_FOR_PANEL: f32 = 620.0;

/// Shows everything; where the molecule is to be seen, in points. Actions are done before it returns.
pub(super) fn show(ui: &mut Ui, state: &mut State, memory: &mut Memory) -> Rect {
    let mut actions = Vec::new();
    keys(ui, state, &mut actions);
    theme::follow(ui.ctx(), state.preferences.theme);
    let is_empty = state.work.layers.is_empty() && state.loader.under_way().is_empty();
    if state.preferences.panel && !is_empty && ui.available_width() >= LEAST_FOR_PANEL {
        panel::show(ui, state, memory, &mut actions);
    }
    let rect = ui.available_rect_before_wrap();
    if is_empty {
        start::show(ui, state, &mut actions);
    } else {
        view::show(ui, state, &mut memory.view, &mut actions);
    }
    frames::show(ui, rect, state, &mut actions);
    notices::show(ui, rect, state, &mut actions);
    help::show(ui.ctx(), state, &mut actions);
    dialogs::show(ui.ctx(), state, &mut actions);
    palette::show(ui.ctx(), state, &mut memory.palette, &mut actions);
    // The field has seen it; an action may ask for it anew.
    state.shown.write_selection = false;
    for action in actions {
        state.apply(action);
    }
    state.dragging = std::mem::take(&mut memory.view.dragging);
    rect
}

/// Keys that no text field takes.
fn keys(ui: &Ui, state: &State, actions: &mut Vec<Action>) {
    // Asked before the input is: egui's context cannot be asked twice at once.
    let is_typing = ui.ctx().egui_wants_keyboard_input();
    let has_focus = ui.ctx().memory(|memory| memory.focused().is_some());
    // Text of a notice, say, that is marked is what is copied.
    let marked = |labels: &mut egui::text_selection::LabelSelectionState| labels.has_selection();
    let has_text = ui.ctx().with_plugin(marked).unwrap_or(false);
    let mut taken = Vec::new();
    ui.ctx().input(|input| {
        for event in &input.events {
            // Systems have keys of their own for copying; egui tells what they mean.
            if matches!(event, Event::Copy) && !is_typing && !has_text {
                taken.extend(commands::of_key(state, egui::Key::C, egui::Modifiers::COMMAND, false));
            }
            let Event::Key { key, pressed: true, repeat, modifiers, .. } = *event else { continue };
            let moves_focus = matches!(key, egui::Key::Space | egui::Key::Enter) && has_focus;
            let is_for_all = modifiers.command || key == egui::Key::Escape || key == egui::Key::F1;
            let edits = modifiers.command
                && matches!(
                    key,
                    egui::Key::A | egui::Key::Z | egui::Key::Y | egui::Key::W | egui::Key::K | egui::Key::Home
                );
            if (is_typing && (!is_for_all || edits)) || moves_focus {
                continue;
            }
            taken.extend(commands::of_key(state, key, modifiers, repeat));
        }
    });
    actions.append(&mut taken);
}
