//! What is under way and what there is to say, in the lower left corner of the view.

use crate::app::action::Action;
use crate::app::loader::{Load, Stage};
use crate::app::preview::Preview;
use crate::app::state::State;
use egui::{Align2, Area, Frame, Id, Rect, RichText, Ui, Vec2};

/// Seconds after which what is no error goes by itself.
const SHORT: f32 = 4.0;
/// Seconds that work takes before it is spoken of.
const SOON: f32 = 0.3;
/// Width of a notice, points.
const WIDTH: f32 = 380.0;

/// Shows what is under way, and notices.
pub(super) fn show(ui: &Ui, rect: Rect, state: &mut State, actions: &mut Vec<Action>) {
    let ctx = ui.ctx();
    state.notices.retain(|notice| notice.is_error || notice.since.elapsed().as_secs_f32() < SHORT);
    if state.notices.iter().any(|notice| !notice.is_error) {
        ctx.request_repaint_after_secs(0.5);
    }
    let is_busy = !state.loader.under_way().is_empty()
        || state.is_building()
        || !state.pictures.under_way.is_empty()
        || !state.films.under_way.is_empty();
    if state.notices.is_empty() && !is_busy {
        return;
    }
    let mut gone = None;
    Area::new(Id::unique("notices"))
        .fixed_pos(rect.left_bottom() + Vec2::new(14.0, -14.0))
        .pivot(Align2::LEFT_BOTTOM)
        .constrain_to(rect)
        .show(ctx, |ui| {
            for load in state.loader.under_way() {
                let preview = state.preview.as_ref().filter(|preview| preview.load == load.id);
                reading(ui, load, preview.map(Preview::says), actions);
            }
            if state.is_building() {
                let preview = state.preview.as_ref().map(Preview::says);
                busy(ui, "Making the picture's parts", preview, 0.8, Action::Cancel, actions);
            }
            if !state.pictures.under_way.is_empty() {
                plate(ui, |ui| {
                    ui.label("Drawing the picture to save…");
                });
            }
            for film in &state.films.under_way {
                let (done, total) = (film.done.load(std::sync::atomic::Ordering::Relaxed), film.total);
                let name = film.path.file_name().unwrap_or(film.path.as_os_str()).to_string_lossy();
                let text = format!("Drawing {name}: {done} of {total}");
                busy(ui, &text, None, done as f32 / total.max(1) as f32, Action::StopAnimations, actions);
            }
            for (index, notice) in state.notices.iter().enumerate() {
                plate(ui, |ui| {
                    let text = RichText::new(&notice.text);
                    let color = ui.visuals().error_fg_color;
                    ui.add(
                        egui::Label::new(if notice.is_error { text.color(color) } else { text })
                            .selectable(true)
                            .wrap(),
                    );
                    if notice.is_error {
                        ui.horizontal(|ui| {
                            if ui.small_button("Copy").clicked() {
                                ui.ctx().copy_text(notice.text.clone());
                            }
                            if ui.small_button("Dismiss").clicked() {
                                gone = Some(index);
                            }
                        });
                    }
                });
            }
        });
    if let Some(index) = gone {
        state.notices.remove(index);
    }
}

fn plate(ui: &mut Ui, content: impl FnOnce(&mut Ui)) {
    Frame::popup(ui.style()).show(ui, |ui| {
        ui.set_width(WIDTH);
        content(ui);
    });
}

fn reading(ui: &mut Ui, load: &Load, preview: Option<String>, actions: &mut Vec<Action>) {
    let name = load.source.name();
    let waited = load.started.elapsed().as_secs_f32();
    if waited < SOON && preview.is_none() {
        return ui.ctx().request_repaint_after_secs(SOON - waited);
    }
    let (text, part) = match load.stage() {
        Stage::Reading => (format!("Reading {name}"), 0.15),
        Stage::Bonds => (format!("Finding the bonds of {name}"), 0.5),
        Stage::Done => (format!("Read {name}"), 0.75),
    };
    busy(ui, &format!("{text}, {waited:.0} s"), preview, part, Action::Cancel, actions);
}

/// Something that takes long, how much of it is done, what there is to say beside, and what stops it. Of opening a file is known which of its steps are done, not how
/// long they take.
fn busy(ui: &mut Ui, text: &str, more: Option<String>, part: f32, stop: Action, actions: &mut Vec<Action>) {
    plate(ui, |ui| {
        ui.horizontal(|ui| {
            ui.label(text);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.small_button("Cancel").clicked() {
                    actions.push(stop);
                }
            });
        });
        ui.add(egui::ProgressBar::new(part).desired_height(6.0));
        if let Some(more) = more {
            ui.weak(more);
        }
    });
    // The seconds go on, and the stage changes without anybody's doing.
    ui.ctx().request_repaint_after_secs(0.2);
}
