//! The panel on the right: files, how things look, what is shown, crystal, selection, atoms.

use super::parts::{button, choice, heading, named, row, switch, switches};
use super::{Memory, atoms, selecting, sequence};
use crate::app::action::Action;
use crate::app::assemblies;
use crate::app::commands::capital;
use crate::app::picking;
use crate::app::state::State;
use crate::bonds::BondMode;
use crate::color::Srgb8;
use crate::crystal::{BondsPerFrame, CellChoice};
use crate::render::Quality;
use crate::scene::{Aromatic, Background, ColorBy, LabelContent, Look, Style};
use egui::{RichText, ScrollArea, Ui};

/// Width of the panel, points.
const WIDTH: f32 = 296.0;

/// Shows the panel.
pub(super) fn show(ui: &mut Ui, state: &State, memory: &mut Memory, actions: &mut Vec<Action>) {
    egui::Panel::right("panel").exact_size(WIDTH).resizable(false).show(ui, |ui| {
        ui.add_space(4.0);
        top(ui, state, actions);
        ui.separator();
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            files(ui, state, actions);
            section(ui, "Style", true, |ui| style(ui, state, actions));
            section(ui, "Light", true, |ui| light(ui, state, actions));
            section(ui, "Show", true, |ui| shown(ui, state, actions));
            section(ui, "Selection", true, |ui| selecting::show(ui, state, &mut memory.selecting, actions));
            section(ui, "Labels", false, |ui| labels(ui, state, actions));
            section(ui, "Bonds", false, |ui| bonds(ui, state, actions));
            if state.built.drawn.iter().any(|(_, drawn)| drawn.cell.is_some()) {
                section(ui, "Crystal", true, |ui| crystal(ui, state, actions));
            }
            section(ui, "Picked and measured", true, |ui| picked(ui, state, actions));
            if sequence::has_any(state, &mut memory.sequence) {
                section(ui, "Sequence", true, |ui| sequence::show(ui, state, &mut memory.sequence, actions));
            }
            section(ui, "Atoms", false, |ui| atoms::show(ui, state, &mut memory.atoms, actions));
            section(ui, "Window", false, |ui| window(ui, state, actions));
            ui.add_space(8.0);
        });
    });
}

fn section(ui: &mut Ui, name: &str, open: bool, content: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(RichText::new(name).strong()).default_open(open).show_unindented(ui, |ui| {
        ui.add_space(2.0);
        content(ui);
        ui.add_space(6.0);
    });
}

fn top(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        button(ui, "Open…", "Open a molecule or a session (Ctrl+O)", Action::OpenDialog, actions);
        button(ui, "Picture…", "Save a picture (Ctrl+P; S saves at once)", Action::PictureDialog(true), actions);
        button(ui, "Session…", "Save all of this to open it again (Ctrl+S)", Action::SessionDialog(true), actions);
    });
    ui.horizontal(|ui| {
        let [undo, redo] = state.history.names();
        let step = |ui: &mut Ui, text: &str, name: Option<&str>, key: &str| {
            let response = ui.add_enabled(name.is_some(), egui::Button::new(text));
            response.on_hover_text(format!("{text} {} ({key})", name.unwrap_or_default())).clicked()
        };
        if step(ui, "Undo", undo, "Ctrl+Z") {
            actions.push(Action::Undo);
        }
        if step(ui, "Redo", redo, "Ctrl+Shift+Z") {
            actions.push(Action::Redo);
        }
        button(ui, "Commands", "All commands by name (Ctrl+K)", Action::Palette(true), actions);
        button(ui, "?", "Keys and mouse (? or F1)", Action::Keys(true), actions);
    });
}

fn files(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    for layer in &state.work.layers {
        let name = layer.source.name();
        ui.horizontal(|ui| {
            let mut visible = layer.visible;
            let shown = ui.checkbox(&mut visible, "").on_hover_text("Show or hide");
            shown.widget_info(|| egui::WidgetInfo::selected(egui::accesskit::Role::CheckBox, true, visible, &name));
            if shown.changed() {
                actions.push(Action::ShowLayer(layer.id, visible));
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let close = ui.small_button("×").on_hover_text(format!("Close {name}"));
                if close.labelled(&format!("Close {name}")).clicked() {
                    actions.push(Action::Close(layer.id));
                }
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.add(egui::Label::new(RichText::new(&name).strong()).truncate());
                });
            });
        });
        let facts = facts(state, layer.id);
        if !facts.is_empty() {
            ui.label(RichText::new(facts).small().weak());
        }
    }
    ui.add_space(4.0);
}

/// What a molecule is, in a line.
fn facts(state: &State, layer: u32) -> String {
    let Some(drawn) = picking::drawn(state, layer) else { return String::new() };
    let structure = &drawn.structure;
    let counted = |count: usize, one: &str, many: &str| match count {
        1 => format!("1 {one}"),
        count => format!("{} {many}", grouped(count)),
    };
    let mut facts =
        vec![counted(structure.atom_count(), "atom", "atoms"), counted(structure.bonds().len(), "bond", "bonds")];
    if !structure.residues().is_empty() {
        facts.push(counted(structure.residues().len(), "residue", "residues"));
        facts.push(counted(structure.chains().len(), "chain", "chains"));
    }
    facts.join(", ")
}

/// A number in groups of three digits, with spaces that do not break.
pub(super) fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{a0}');
        }
        text.push(digit);
    }
    text
}

fn style(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let scene = &state.work.scene;
    let styles = Style::ALL.map(|style| (style, capital(style.name())));
    choice(ui, "Drawn as", &styles, scene.style, Action::Style, actions);
    let by = ColorBy::ALL.map(|by| (by, capital(by.name())));
    choice(ui, "Colour by", &by, scene.color_by, Action::ColorBy, actions);
    let aromatic = Aromatic::ALL.map(|how| (how, capital(how.name())));
    choice(ui, "Aromatic", &aromatic, scene.aromatic, Action::Aromatic, actions);
    for (name, times, action) in [
        ("Balls", scene.ball_scale, Action::BallScale as fn(f32) -> Action),
        ("Sticks", scene.stick_scale, Action::StickScale as fn(f32) -> Action),
    ] {
        row(ui, name, |ui| {
            // With the number beside it, as wide as the panel.
            ui.spacing_mut().slider_width = 110.0;
            let mut times = times;
            let slider = egui::Slider::new(&mut times, 0.25..=4.0).logarithmic(true).fixed_decimals(2);
            let response = ui.add(slider.clamping(egui::SliderClamping::Edits));
            response.widget_info(|| {
                egui::WidgetInfo::slider(true, f64::from(times), format!("Size of {}", name.to_lowercase()))
            });
            if response.changed() {
                actions.push(action(times));
            }
        });
    }
}

fn light(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let scene = &state.work.scene;
    let looks = Look::ALL.map(|look| (look, capital(look.name())));
    choice(ui, "Look", &looks, scene.look, Action::Look, actions);
    row(ui, "Background", |ui| {
        let transparent = scene.background == Background::Transparent;
        let color = match scene.background {
            Background::Color(color) => color,
            Background::Transparent => scene.look.background(),
        };
        let mut rgb = [color.r, color.g, color.b];
        let response = ui.add_enabled_ui(!transparent, |ui| ui.color_edit_button_srgb(&mut rgb)).inner;
        named(&response, "Background", &color.to_string());
        if response.changed() {
            actions.push(Action::Background(Background::Color(Srgb8::rgb(rgb[0], rgb[1], rgb[2]))));
        }
        switch(
            ui,
            "Transparent",
            transparent,
            |on| {
                Action::Background(if on {
                    Background::Transparent
                } else {
                    Background::Color(scene.look.background())
                })
            },
            actions,
        );
    });
    switches(
        ui,
        actions,
        [
            ("Ground", scene.ground, &Action::Ground),
            ("Orthographic", !scene.perspective, &|on| Action::Perspective(!on)),
        ],
    );
    let qualities = Quality::ALL.map(|quality| (quality, capital(quality.name())));
    choice(ui, "Quality", &qualities, state.work.quality, Action::Quality, actions);
}

fn shown(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let (scene, crystal) = (&state.work.scene, &state.work.crystal);
    switches(ui, actions, [("Hydrogens", scene.hydrogens, &Action::Hydrogens), ("Water", scene.water, &Action::Water)]);
    switches(
        ui,
        actions,
        [("Hydrogen bonds", crystal.bonds.hydrogen_bonds, &Action::HydrogenBonds), ("Ions", scene.ions, &Action::Ions)],
    );
    switches(
        ui,
        actions,
        [("Legend", scene.text.legend, &Action::Legend), ("Scale bar", scene.text.scale_bar, &Action::ScaleBar)],
    );
    switch(ui, "Axes", scene.axes, Action::Axes, actions);
}

fn labels(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let text = &state.work.scene.text;
    let labels = text.labels;
    switches(
        ui,
        actions,
        [
            ("Element", labels.element, &|on| Action::Labels(LabelContent { element: on, ..labels })),
            ("Number", labels.index, &|on| Action::Labels(LabelContent { index: on, ..labels })),
        ],
    );
    switches(
        ui,
        actions,
        [
            ("Atom name", labels.name, &|on| Action::Labels(LabelContent { name: on, ..labels })),
            ("Residue", labels.residue, &|on| Action::Labels(LabelContent { residue: on, ..labels })),
        ],
    );
    row(ui, "Size", |ui| {
        let mut size = text.size;
        let slider = egui::Slider::new(&mut size, 0.2..=5.0).logarithmic(true).fixed_decimals(1);
        let response = ui.add(slider);
        response.widget_info(|| egui::WidgetInfo::slider(true, f64::from(size), "Size of labels"));
        if response.changed() {
            actions.push(Action::LabelSize(size));
        }
    });
}

fn bonds(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let says = |mode: BondMode| match mode {
        BondMode::Auto => "All that is known",
        BondMode::File => "Of the file alone",
        BondMode::Perceive => "By distance alone",
        BondMode::None => "None",
    };
    let modes = BondMode::ALL.map(|mode| (mode, says(mode).to_owned()));
    choice(ui, "From", &modes, state.work.crystal.bonds.mode, Action::Bonds, actions);
    if state.work.frame_count() > 1 {
        let says = |when: BondsPerFrame| match when {
            BondsPerFrame::Auto => "Anew, but for trajectories",
            BondsPerFrame::Always => "Anew in each",
            BondsPerFrame::Never => "The same in all",
        };
        let whens = BondsPerFrame::ALL.map(|when| (when, says(when).to_owned()));
        choice(ui, "In frames", &whens, state.work.crystal.bonds_per_frame, Action::BondsPerFrame, actions);
    }
    switch(ui, "One stick from a metal to a ring", state.work.scene.haptic, Action::Haptic, actions);
}

fn crystal(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let crystal = &state.work.crystal;
    let says = |cell: CellChoice| match cell {
        CellChoice::Asym => "Atoms as listed",
        CellChoice::Molecule => "Whole molecules",
        CellChoice::Full => "Whole cell",
    };
    let cells = CellChoice::ALL.map(|cell| (cell, says(cell).to_owned()));
    choice(ui, "Content", &cells, crystal.cell, Action::Cell, actions);
    let known = assemblies::known(state);
    if known.len() > 1 {
        choice(ui, "Assembly", &known, crystal.assembly, Action::Assembly, actions);
    }
    row(ui, "Cells", |ui| {
        let mut counts = crystal.supercell;
        for (count, axis) in counts.iter_mut().zip(["a", "b", "c"]) {
            let response = ui.add(egui::DragValue::new(count).range(1..=20).speed(0.05).prefix(format!("{axis} ")));
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::accesskit::Role::SpinButton, true, format!("Cells along {axis}"))
            });
        }
        if counts != crystal.supercell {
            actions.push(Action::Supercell(counts));
        }
    });
    let is_automatic = state.built.drawn.iter().any(|(_, drawn)| drawn.is_cell_content);
    let on = state.work.cell_box.unwrap_or(is_automatic);
    switch(ui, "Edges of the cell", on, |on| Action::CellBox(Some(on)), actions);
}

/// Picked atoms that are listed.
const MOST_LISTED: usize = 6;

fn picked(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let picked = &state.work.picked;
    if picked.is_empty() {
        let text = if state.measuring {
            "Click two atoms for a distance, three for an angle, four for a dihedral."
        } else {
            "Click an atom to pick it, with Shift more of them."
        };
        ui.label(RichText::new(text).weak());
    }
    for key in picked.iter().take(MOST_LISTED) {
        if let Some(name) = picking::name_of(state, *key) {
            ui.label(name);
        }
    }
    if picked.len() > MOST_LISTED {
        ui.label(RichText::new(format!("and {} more", grouped(picked.len() - MOST_LISTED))).weak());
    }
    ui.horizontal(|ui| {
        if let Some(value) = picking::measure(state, picked) {
            ui.label(RichText::new(value).strong());
            button(ui, "Keep", "Show it in the picture (M)", Action::Measure, actions);
        } else {
            let toggle = egui::Button::new("Measure").selected(state.measuring);
            if ui.add(toggle).on_hover_text("Clicks gather atoms (M)").clicked() {
                actions.push(Action::Measuring(!state.measuring));
            }
        }
        if !picked.is_empty() {
            button(ui, "More", "The residue, the chain, all (E)", Action::PickMore, actions);
            button(ui, "Centre", "Turn about it (C)", Action::Center, actions);
            button(ui, "None", "Pick nothing (Esc)", Action::PickNone, actions);
        }
    });
    if state.work.measurements.is_empty() {
        return;
    }
    heading(ui, "Measured");
    for (index, atoms) in state.work.measurements.iter().enumerate() {
        ui.horizontal(|ui| {
            let value = picking::measure(state, atoms).unwrap_or_else(|| "–".to_owned());
            let names: Vec<String> = atoms.iter().filter_map(|&key| picking::name_of(state, key)).collect();
            ui.label(RichText::new(&value).strong()).on_hover_text(names.join(" – "));
            if ui.small_button("×").on_hover_text("Forget it").labelled(&format!("Forget {value}")).clicked() {
                actions.push(Action::ForgetMeasurement(index));
            }
        });
    }
}

fn window(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    use crate::app::{mouse::Preset, preferences::Theme};
    let themes = Theme::ALL.map(|theme| (theme, capital(theme.name())));
    choice(ui, "Theme", &themes, state.preferences.theme, Action::Theme, actions);
    let presets = Preset::ALL.map(|preset| (preset, preset.name().to_owned()));
    choice(ui, "Mouse as in", &presets, state.preferences.mouse, Action::Mouse, actions);
    switch(ui, "Read files again when they change", state.preferences.reloads, Action::Reloads, actions);
    button(
        ui,
        "Copy command line",
        "What draws this picture without a window (Ctrl+Shift+C)",
        Action::CopyCommand,
        actions,
    );
}

/// Names for what shows none.
trait Labelled {
    fn labelled(self, name: &str) -> Self;
}

impl Labelled for egui::Response {
    fn labelled(self, name: &str) -> Self {
        let kind = egui::accesskit::Role::Button;
        self.widget_info(|| egui::WidgetInfo::labeled(kind, true, name));
        self
    }
}
