//! All commands by name: type a few letters, choose with the arrows, Enter.

use crate::app::action::Action;
use crate::app::commands;
use crate::app::state::State;
use egui::{Align2, Context, Key, Modal, RichText, ScrollArea, TextEdit};

/// What was typed and which line is chosen.
#[derive(Default)]
pub(super) struct Memory {
    text: String,
    chosen: usize,
    was_open: bool,
}

/// Shows the palette.
pub(super) fn show(ctx: &Context, state: &State, memory: &mut Memory, actions: &mut Vec<Action>) {
    if !state.shown.palette {
        memory.was_open = false;
        return;
    }
    if !memory.was_open {
        *memory = Memory { was_open: true, ..Memory::default() };
    }
    // Before the text field sees them.
    let (up, down, enter) = ctx.input_mut(|input| {
        let mut pressed = |key| input.consume_key(egui::Modifiers::NONE, key);
        (pressed(Key::ArrowUp), pressed(Key::ArrowDown), pressed(Key::Enter))
    });
    let mut done = None;
    let area = Modal::default_area(egui::Id::unique("palette")).anchor(Align2::CENTER_TOP, [0.0, 70.0]);
    let modal = Modal::new(egui::Id::unique("palette")).area(area).show(ctx, |ui| {
        ui.set_width(460.0_f32.min(ctx.content_rect().width() - 40.0));
        let edit =
            TextEdit::singleline(&mut memory.text).hint_text("What do you want to do?").desired_width(f32::INFINITY);
        let response = ui.add(edit);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::TextInput, true, "Command"));
        response.request_focus();
        if response.changed() {
            memory.chosen = 0;
        }
        let found = commands::found(state, &memory.text);
        let last = found.len().saturating_sub(1);
        memory.chosen = match (up, down) {
            (true, _) => memory.chosen.saturating_sub(1),
            (_, true) => (memory.chosen + 1).min(last),
            _ => memory.chosen.min(last),
        };
        if enter {
            done = found.get(memory.chosen).map(|command| command.action.clone());
        }
        ui.add_space(4.0);
        let height = (ctx.content_rect().height() - 200.0).clamp(80.0, 380.0);
        ScrollArea::vertical().max_height(height).auto_shrink([false, true]).show(ui, |ui| {
            for (index, command) in found.iter().enumerate() {
                let keys: Vec<String> = command.keys.iter().map(|key| key.text()).collect();
                let title = match command.on {
                    Some(true) => format!("{}   (on)", command.title),
                    _ => command.title.clone(),
                };
                let button = egui::Button::selectable(index == memory.chosen, title)
                    .shortcut_text(RichText::new(keys.join(", ")).weak())
                    .min_size(egui::vec2(ui.available_width(), 24.0));
                let response = ui.add(button);
                if (up || down) && index == memory.chosen {
                    response.scroll_to_me(None);
                }
                if response.clicked() {
                    done = Some(command.action.clone());
                }
            }
            if found.is_empty() {
                ui.label(RichText::new("Nothing is called so.").weak());
            }
        });
    });
    if done.is_some() || modal.should_close() {
        actions.push(Action::Palette(false));
        actions.extend(done);
    }
}
