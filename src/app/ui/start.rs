//! What stands in an empty window: how to open something.

use crate::app::action::Action;
use crate::app::state::State;
use crate::session::samples::SAMPLES;
use egui::{Align, Layout, RichText, ScrollArea, Ui, Vec2};

/// Width of the column, points.
const WIDTH: f32 = 460.0;

/// Shows the start page.
pub(super) fn show(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let rect = ui.available_rect_before_wrap();
    ui.painter().rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
    let width = WIDTH.min(rect.width() - 40.0).max(160.0);
    let column = egui::Rect::from_center_size(rect.center(), Vec2::new(width, rect.height() - 40.0));
    let mut child = ui.new_child(egui::UiBuilder::new().max_rect(column).layout(Layout::top_down(Align::Min)));
    ScrollArea::vertical().auto_shrink([false, false]).show(&mut child, |ui| {
        ui.add_space((rect.height() * 0.12).min(110.0));
        ui.label(RichText::new("ballstick").size(34.0).strong());
        ui.label(RichText::new("Molecules as balls and sticks").size(15.0).weak());
        ui.add_space(18.0);
        ui.horizontal(|ui| {
            let button = egui::Button::new(RichText::new("Open a file…").size(15.0)).min_size(Vec2::new(150.0, 36.0));
            if ui.add(button).clicked() {
                actions.push(Action::OpenDialog);
            }
            ui.add_space(6.0);
            ui.label(RichText::new("or drop one here: PDB, mmCIF, SDF, XYZ, MOL2, …").weak());
        });
        if !state.preferences.recent.is_empty() {
            ui.add_space(18.0);
            ui.label(RichText::new("Recent").strong());
            for path in &state.preferences.recent {
                let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
                ui.horizontal(|ui| {
                    if ui.link(name).on_hover_text(path.display().to_string()).clicked() {
                        actions.push(Action::Open(path.clone()));
                    }
                    let folder = path.parent().map(|folder| folder.display().to_string()).unwrap_or_default();
                    ui.add(egui::Label::new(RichText::new(folder).small().weak()).truncate());
                });
            }
        }
        ui.add_space(18.0);
        ui.label(RichText::new("Samples").strong());
        for (number, sample) in SAMPLES.iter().enumerate() {
            ui.horizontal(|ui| {
                if ui.link(sample.name).clicked() {
                    actions.push(Action::OpenSample(number));
                }
                ui.label(RichText::new(sample.says).weak());
            });
        }
        ui.add_space(18.0);
        ui.label(RichText::new("Ctrl+K lists all commands, ? all keys.").weak());
    });
}
