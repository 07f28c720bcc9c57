//! All keys and what the mouse does, from the table of commands.

use crate::app::action::Action;
use crate::app::commands::{self, GROUPS};
use crate::app::state::State;
use egui::{Align2, Context, Grid, RichText, ScrollArea, Window};

/// Shows the keys.
pub(super) fn show(ctx: &Context, state: &State, actions: &mut Vec<Action>) {
    if !state.shown.keys {
        return;
    }
    let mut open = true;
    Window::new("Keys and mouse")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ctx, |ui| {
            let commands = commands::commands(state);
            let height = (ctx.content_rect().height() - 120.0).max(120.0);
            ScrollArea::vertical().min_scrolled_height(height).max_height(height).show(ui, |ui| {
                ui.columns(2, |columns| {
                    let preset = state.preferences.mouse;
                    columns[0].label(RichText::new("Mouse").strong());
                    Grid::new("mouse").num_columns(2).spacing([14.0, 4.0]).show(&mut columns[0], |ui| {
                        for (what, does) in preset.lines() {
                            ui.label(RichText::new(*what).weak());
                            ui.label(*does);
                            ui.end_row();
                        }
                    });
                    // Two columns of about the same length.
                    for (group, column) in GROUPS.into_iter().zip([0, 0, 1, 1, 1, 1, 1]) {
                        let ui = &mut columns[column];
                        ui.add_space(8.0);
                        ui.label(RichText::new(group).strong());
                        Grid::new(group).num_columns(2).spacing([14.0, 4.0]).show(ui, |ui| {
                            for command in commands.iter().filter(|c| c.group == group && !c.keys.is_empty()) {
                                let keys: Vec<String> = command.keys.iter().map(|key| key.text()).collect();
                                ui.label(RichText::new(keys.join(", ")).weak());
                                ui.label(&command.title);
                                ui.end_row();
                            }
                        });
                    }
                });
            });
        });
    if !open {
        actions.push(Action::Keys(false));
    }
}
