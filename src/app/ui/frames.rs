//! The bar under a molecule of several frames: play, step, go to a frame.

use crate::app::action::Action;
use crate::app::state::{AtEnd, State};
use egui::{Align2, Area, Frame, Id, Rect, Ui, Vec2};

/// Width of the bar, points, where there is room.
const WIDTH: f32 = 620.0;

/// Shows the bar if anything has several frames.
pub(super) fn show(ui: &Ui, rect: Rect, state: &State, actions: &mut Vec<Action>) {
    let Some(layer) = state.work.layers.iter().max_by_key(|layer| layer.document.frame_count()) else { return };
    let count = layer.document.frame_count();
    if count < 2 {
        return;
    }
    let width = WIDTH.min(rect.width() - 40.0);
    Area::new(Id::unique("frames"))
        .fixed_pos(rect.center_bottom() - Vec2::new(0.0, 14.0))
        .pivot(Align2::CENTER_BOTTOM)
        .constrain_to(rect)
        .show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(width);
                ui.horizontal(|ui| {
                    let playing = state.playing;
                    let text = if playing.on { "Pause" } else { "Play" };
                    if ui.add(egui::Button::new(text).min_size(Vec2::new(52.0, 24.0))).on_hover_text("Space").clicked()
                    {
                        actions.push(Action::Play(!playing.on));
                    }
                    if ui.button("<").on_hover_text("Frame before (,)").clicked() {
                        actions.push(Action::Step(-1));
                    }
                    if ui.button(">").on_hover_text("Next frame (.)").clicked() {
                        actions.push(Action::Step(1));
                    }
                    let time = layer
                        .document
                        .time_ps(layer.frame)
                        .map_or_else(String::new, |time| format!("  {}", said(time)));
                    ui.spacing_mut().slider_width = (width - 310.0 - 7.0 * time.len() as f32).max(60.0);
                    let mut frame = layer.frame + 1;
                    let slider = ui.add(egui::Slider::new(&mut frame, 1..=count).show_value(false));
                    slider.widget_info(|| egui::WidgetInfo::slider(true, frame as f64, "Frame"));
                    if slider.changed() {
                        actions.push(Action::Frame(layer.id, frame - 1));
                    }
                    ui.label(format!("{} / {count}{time}", layer.frame + 1));
                    let mut speed = playing.speed;
                    let drag =
                        egui::DragValue::new(&mut speed).range(0.5..=60.0).speed(0.2).suffix(" /s").max_decimals(1);
                    let response = ui.add(drag).on_hover_text("Frames a second");
                    response.widget_info(|| egui::WidgetInfo::slider(true, f64::from(speed), "Frames a second"));
                    if response.changed() {
                        actions.push(Action::Speed(speed));
                    }
                    let chosen = playing.at_end;
                    let at_end = egui::ComboBox::from_id_salt("at end").width(66.0).selected_text(chosen.name());
                    let response = at_end.show_ui(ui, |ui| {
                        for what in AtEnd::ALL {
                            if ui.selectable_label(what == chosen, what.name()).clicked() {
                                actions.push(Action::AtEnd(what));
                            }
                        }
                    });
                    response.response.on_hover_text("At the last frame: stop, begin anew, or go back");
                });
            });
        });
}

/// A time as people say it.
fn said(time_ps: f64) -> String {
    let (time, unit) = match time_ps.abs() {
        long if long >= 1e4 => (time_ps * 1e-3, "ns"),
        short if short > 0.0 && short < 0.1 => (time_ps * 1e3, "fs"),
        _ => (time_ps, "ps"),
    };
    format!("{} {unit}", (time * 1e3).round() / 1e3)
}

#[cfg(test)]
mod tests {
    use super::said;

    #[test]
    fn times_have_the_unit_that_keeps_them_short() {
        let times = [0.0, 0.002, 2.5, 9999.0, 12_345.678_9, -3.0].map(said);
        assert_eq!(times, ["0 ps", "2 fs", "2.5 ps", "9999 ps", "12.346 ns", "-3 ps"]);
    }
}
