//! The dialog for films.

use super::dialogs::{ending, number, path_field, size, window};
use super::parts::row;
use crate::app::animations::{self, Dialog, Kind, MOST_FRAMES, MOST_SIDE};
use crate::app::state::State;
use crate::export::animation::{AnimationFormat, MOST_FPS};
use egui::accesskit::Role;
use egui::{Context, DragValue, Ui, WidgetInfo};
use std::path::Path;

/// Shows the dialog if it is open.
pub(super) fn show(ctx: &Context, state: &mut State) {
    let Some(mut dialog) = state.shown.animation.take() else { return };
    let frames = u32::try_from(state.work.frame_count()).unwrap_or(u32::MAX);
    let (save, open) = window(ctx, "Save animation", |ui| {
        let mut save = row(ui, "File", |ui| path_field(ui, &mut dialog.path));
        row(ui, "Format", |ui| {
            let format = AnimationFormat::from_path(Path::new(dialog.path.trim()));
            for (other, name) in AnimationFormat::ALL.into_iter().zip(["GIF", "APNG", "MP4"]) {
                if ui.radio(format == Some(other), name).clicked() {
                    dialog.set_format(other);
                }
            }
        });
        what(ui, &mut dialog, frames);
        row(ui, "Size", |ui| {
            size(ui, [&mut dialog.width, &mut dialog.height], MOST_SIDE);
        });
        row(ui, "Speed", |ui| {
            let drag = DragValue::new(&mut dialog.fps).range(0.1..=MOST_FPS).speed(0.2).max_decimals(2);
            ui.add(drag).widget_info(|| WidgetInfo::labeled(Role::SpinButton, true, "Frames a second"));
            let seconds = f64::from(dialog.frames()) / dialog.fps;
            ui.label(format!("frames a second: {} frames, {seconds:.1} s", dialog.frames()));
        });
        save |= ending(ui, &mut dialog.quality, &mut dialog.transparent);
        save
    });
    if save == Some(true) {
        animations::save(state, &dialog);
    } else if open {
        state.shown.animation = Some(dialog);
    }
}

/// A turn, or frames where there are several.
fn what(ui: &mut Ui, dialog: &mut Dialog, frames: u32) {
    row(ui, "Shows", |ui| {
        if ui.radio(matches!(dialog.kind, Kind::Turntable(_)), "Turntable").clicked() {
            dialog.kind = Kind::Turntable(100);
        }
        let plays = egui::RadioButton::new(matches!(dialog.kind, Kind::Frames { .. }), "Frames");
        if ui.add_enabled(frames > 1, plays).clicked() {
            dialog.kind = Kind::Frames { first: 1, last: frames, step: 1 };
        }
    });
    row(ui, "", |ui| match &mut dialog.kind {
        Kind::Turntable(count) => {
            number(ui, count, 2..=MOST_FRAMES, "Frames of a turn");
            ui.label("frames a turn");
        }
        Kind::Frames { first, last, step } => {
            number(ui, first, 1..=*last, "First frame");
            ui.label("to");
            number(ui, last, *first..=frames, "Last frame");
            ui.label("every");
            number(ui, step, 1..=frames, "Step");
        }
    });
}
