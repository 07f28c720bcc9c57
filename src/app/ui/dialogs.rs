//! What is asked before something is opened or saved.

use super::parts::row;
use crate::app::action::Action;
use crate::app::commands::capital;
use crate::app::pictures;
use crate::app::state::State;
use crate::render::Quality;
use egui::{Align2, Context, Key, Response, TextEdit, Ui, Window};
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Shows those that are open.
pub(super) fn show(ctx: &Context, state: &mut State, actions: &mut Vec<Action>) {
    picture(ctx, state);
    super::film::show(ctx, state);
    let session = state.shown.session.take();
    state.shown.session = path(ctx, "Save session", "Save", session, |path| actions.push(Action::SaveSession(path)));
    let open = state.shown.open.take();
    state.shown.open = path(ctx, "Open", "Open", open, |path| actions.push(Action::Open(path)));
}

pub(super) fn window<R>(ctx: &Context, title: &str, content: impl FnOnce(&mut Ui) -> R) -> (Option<R>, bool) {
    let mut open = true;
    let shown = Window::new(title)
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, [0.0, -40.0])
        .show(ctx, content);
    (shown.and_then(|shown| shown.inner), open)
}

/// A path as text; whether it was finished with Enter.
pub(super) fn path_field(ui: &mut Ui, text: &mut String) -> bool {
    let response = ui.add(TextEdit::singleline(text).desired_width(340.0));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::TextInput, true, "File"));
    // Asked first: to take the focus again is not to have lost it.
    let entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    if !entered && ui.ctx().memory(|memory| memory.focused().is_none()) {
        response.request_focus();
    }
    entered
}

/// Asks for a path; the text while it is still being asked for.
fn path(ctx: &Context, title: &str, verb: &str, text: Option<String>, then: impl FnOnce(PathBuf)) -> Option<String> {
    let mut text = text?;
    let (finished, open) = window(ctx, title, |ui| {
        let entered = row(ui, "File", |ui| path_field(ui, &mut text));
        let clicked = ui.add_enabled(!text.trim().is_empty(), egui::Button::new(verb)).clicked();
        entered || clicked
    });
    if finished == Some(true) && !text.trim().is_empty() {
        then(PathBuf::from(text.trim()));
        return None;
    }
    open.then_some(text)
}

fn picture(ctx: &Context, state: &mut State) {
    let Some(mut dialog) = state.shown.picture.take() else { return };
    let [view_width, view_height] = state.view_px;
    let (save, open) = window(ctx, "Save picture", |ui| {
        let mut save = row(ui, "File", |ui| path_field(ui, &mut dialog.path));
        row(ui, "Size", |ui| {
            let [width, height] = size(ui, [&mut dialog.width, &mut dialog.height], MOST_SIDE);
            if dialog.keeps_shape && width.changed() {
                dialog.height = scaled(dialog.width, view_height, view_width);
            } else if dialog.keeps_shape && height.changed() {
                dialog.width = scaled(dialog.height, view_width, view_height);
            }
        });
        row(ui, "", |ui| {
            for (text, times) in [("As seen", 1), ("2×", 2), ("4×", 4)] {
                if ui.small_button(text).clicked() {
                    (dialog.width, dialog.height) = (view_width * times, view_height * times);
                }
            }
            ui.checkbox(&mut dialog.keeps_shape, "Shape of the window");
        });
        save |= ending(ui, &mut dialog.quality, &mut dialog.transparent);
        save
    });
    if save == Some(true) {
        pictures::save(state, &dialog);
    } else if open {
        state.shown.picture = Some(dialog);
    }
}

/// Width and height up to so many pixels.
pub(super) fn size(ui: &mut Ui, [width, height]: [&mut u32; 2], most: u32) -> [Response; 2] {
    let width = number(ui, width, 16..=most, "Width");
    ui.label("×");
    let height = number(ui, height, 16..=most, "Height");
    ui.label("pixels");
    [width, height]
}

/// A whole number with a name for who cannot see where it stands.
pub(super) fn number(ui: &mut Ui, value: &mut u32, range: RangeInclusive<u32>, name: &str) -> Response {
    let response = ui.add(egui::DragValue::new(value).range(range));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::SpinButton, true, name));
    response
}

/// What the dialogs of pictures and films end with; whether to save.
pub(super) fn ending(ui: &mut Ui, quality: &mut Quality, transparent: &mut bool) -> bool {
    row(ui, "Quality", |ui| {
        for of_all in Quality::ALL {
            ui.radio_value(quality, of_all, capital(of_all.name()));
        }
    });
    row(ui, "Background", |ui| ui.checkbox(transparent, "Transparent"));
    ui.add_space(4.0);
    ui.button("Save").clicked()
}

/// Pixels on a side of a saved picture, at most.
const MOST_SIDE: u32 = 16_384;

fn scaled(side: u32, other: u32, of: u32) -> u32 {
    let scaled = (f64::from(side) * f64::from(other) / f64::from(of.max(1))).round();
    (scaled as u32).clamp(16, MOST_SIDE)
}
