//! Small things that the panel and dialogs are made of.

use crate::app::action::Action;
use egui::{Response, RichText, Ui};

/// A heading in small letters.
pub(super) fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(2.0);
    ui.label(RichText::new(text).strong());
}

/// A row of the panel: what it is called, then what it is set to, in a column.
pub(super) fn row<R>(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let width = LABEL_WIDTH;
        ui.allocate_ui_with_layout(egui::vec2(width, 24.0), egui::Layout::left_to_right(egui::Align::Center), |ui| {
            ui.set_min_width(width);
            ui.label(name);
        });
        content(ui)
    })
    .inner
}

/// Width of the column of names, points.
const LABEL_WIDTH: f32 = 86.0;

/// A switch; the action if it was turned.
pub(super) fn switch(ui: &mut Ui, name: &str, on: bool, action: impl Fn(bool) -> Action, actions: &mut Vec<Action>) {
    let mut value = on;
    if ui.checkbox(&mut value, name).changed() {
        actions.push(action(value));
    }
}

/// A switch: its name, whether it is on, and what it does.
pub(super) type Switch<'a> = (&'a str, bool, &'a dyn Fn(bool) -> Action);

/// Two switches side by side, in columns.
pub(super) fn switches(ui: &mut Ui, actions: &mut Vec<Action>, [left, right]: [Switch<'_>; 2]) {
    ui.horizontal(|ui| {
        let start = ui.cursor().left();
        switch(ui, left.0, left.1, left.2, actions);
        ui.add_space((start + COLUMN_WIDTH - ui.cursor().left()).max(0.0));
        switch(ui, right.0, right.1, right.2, actions);
    });
}

/// Width of one of two columns, points.
const COLUMN_WIDTH: f32 = 134.0;

/// One of several in a list that opens.
pub(super) fn choice<T: PartialEq + Copy>(
    ui: &mut Ui,
    name: &str,
    all: &[(T, String)],
    chosen: T,
    action: impl Fn(T) -> Action,
    actions: &mut Vec<Action>,
) {
    row(ui, name, |ui| {
        let shown = all.iter().find(|(value, _)| *value == chosen).map_or("", |(_, text)| text.as_str());
        let response = egui::ComboBox::from_id_salt(name).selected_text(shown).width(150.0).show_ui(ui, |ui| {
            for (value, text) in all {
                if ui.selectable_label(*value == chosen, text.as_str()).clicked() && *value != chosen {
                    actions.push(action(*value));
                }
            }
        });
        named(&response.response, name, shown);
    });
}

/// Gives a widget a name for screen readers and tests.
pub(super) fn named(response: &Response, name: &str, value: &str) {
    let text = format!("{name}: {value}");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, text.clone()));
}

/// A button with what its key is, in the tooltip.
pub(super) fn button(ui: &mut Ui, text: &str, tip: &str, action: Action, actions: &mut Vec<Action>) {
    if ui.button(text).on_hover_text(tip).clicked() {
        actions.push(action);
    }
}
