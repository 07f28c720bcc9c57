//! What is said of an atom or bond under the pointer.

use crate::app::picking::{self, Target};
use crate::app::state::State;
use egui::{Area, Context, Frame, Grid, Id, Order, Pos2, Rect, RichText, Vec2};

/// Seconds that the pointer rests on something before it is told (chosen: longer than it takes to pass over).
pub(super) const DELAY: f32 = 0.25;

/// Shows it beside the pointer.
pub(super) fn show(ctx: &Context, state: &State, target: Target, at: Pos2, within: Rect) {
    let about = match target {
        Target::Atom(key) => picking::drawn(state, key.layer).and_then(|drawn| picking::about_atom(drawn, key.atom)),
        Target::Bond(layer, bond) => {
            picking::drawn(state, layer).and_then(|drawn| picking::about_bond(drawn, bond as usize))
        }
    };
    let Some((heading, facts)) = about else { return };
    Area::new(Id::unique("tip"))
        .order(Order::Tooltip)
        .fixed_pos(at + Vec2::new(16.0, 12.0))
        .constrain_to(within.shrink(4.0))
        .interactable(false)
        .show(ctx, |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_max_width(340.0);
                ui.label(RichText::new(heading).strong());
                Grid::new("facts").num_columns(2).spacing([10.0, 3.0]).show(ui, |ui| {
                    for (name, value) in facts {
                        ui.label(RichText::new(name).weak());
                        ui.label(value);
                        ui.end_row();
                    }
                });
            });
        });
}
