//! The field that selects by words, with what can be written next, and what can be done with what is selected.

use super::panel::grouped;
use super::parts::button;
use super::theme;
use crate::app::action::Action;
use crate::app::build::Built;
use crate::app::commands::capital;
use crate::app::selecting::{self, Deed, How};
use crate::app::state::State;
use crate::color::Srgb8;
use crate::scene::Style;
use crate::select::{Completions, ParseError, Scope, Selection, completions};
use egui::text::{CCursor, CCursorRange, LayoutJob, TextFormat};
use egui::text_edit::TextEditState;
use egui::{Color32, FontSelection, Id, Key, Modifiers, RichText, Stroke, TextEdit, Ui};
use std::ops::Range;
use std::sync::Arc;

/// So many atoms, if they were counted, or what is wrong.
type Found = Result<Option<usize>, ParseError>;

/// What the field keeps from frame to frame.
pub(super) struct Memory {
    text: String,
    /// What was last asked, of which scene, and what was found.
    asked: Option<(String, Arc<Built>, Found)>,
    /// What can be written, at a place of which text.
    proposed: Option<(String, usize, Completions)>,
    /// Whether a press on one of these is not over yet.
    is_pressed: bool,
    /// Which of these the arrows have come to.
    chosen: Option<usize>,
    color: Srgb8,
}

impl Default for Memory {
    fn default() -> Memory {
        // Chosen: few elements have it, and it is seen on white and on black.
        let color = Srgb8::rgb(230, 60, 140);
        Memory { text: String::new(), asked: None, proposed: None, is_pressed: false, chosen: None, color }
    }
}

/// Atoms of up to so many are counted while a selection is being written (chosen: some 10 ms for the slowest ones, distances).
const MOST_COUNTED: usize = 100_000;
/// Completions that are shown at once.
const MOST_SHOWN: usize = 8;

/// Shows the field and the buttons.
pub(super) fn show(ui: &mut Ui, state: &State, memory: &mut Memory, actions: &mut Vec<Action>) {
    field(ui, state, memory, actions);
    let count = state.work.picked.len();
    ui.horizontal_wrapped(|ui| {
        button(ui, "All", "Select everything (Ctrl+A)", Action::PickAll, actions);
        button(ui, "Others", "Select what is not selected (Ctrl+I)", Action::Choose(How::Invert), actions);
        button(ui, "Grow", "What has bonds to it as well (Shift+E)", Action::Choose(How::Grow), actions);
    });
    if count > 0 {
        deeds(ui, state, memory, actions);
    }
    said(ui, state, actions);
}

/// The field, whether it is right, and what can be written next.
fn field(ui: &mut Ui, state: &State, memory: &mut Memory, actions: &mut Vec<Action>) {
    let id = Id::unique("selection");
    let has_focus = ui.memory(|of_ui| of_ui.has_focus(id));
    let proposed = memory.proposed.as_ref().filter(|_| has_focus).map_or(0, |(_, _, proposed)| proposed.all.len());
    let shown = proposed.min(MOST_SHOWN);
    // Before the text field sees them.
    let mut accepted = None;
    if shown > 0 {
        let (up, down, tab, enter) = ui.input_mut(|input| {
            let mut pressed = |key| input.consume_key(Modifiers::NONE, key);
            let (up, down, tab) = (pressed(Key::ArrowUp), pressed(Key::ArrowDown), pressed(Key::Tab));
            (up, down, tab, memory.chosen.is_some() && pressed(Key::Enter))
        });
        memory.chosen = match (memory.chosen, up, down) {
            (None, _, true) => Some(0),
            (Some(at), _, true) => Some((at + 1).min(shown - 1)),
            (Some(at), true, _) => at.checked_sub(1),
            (chosen, ..) => chosen,
        };
        if tab || enter {
            accepted = Some(memory.chosen.unwrap_or(0).min(shown - 1));
        }
    }
    let wrong = match &memory.asked {
        Some((text, _, Err(error))) if *text == memory.text => error.span.clone(),
        _ => 0..0,
    };
    let mut layouter = |ui: &Ui, buffer: &dyn egui::TextBuffer, _: f32| {
        let job = marked(ui, buffer.as_str(), wrong.clone());
        ui.ctx().fonts_mut(|fonts| fonts.layout_job(job))
    };
    let edit = TextEdit::singleline(&mut memory.text)
        .id(id)
        .hint_text("chain A and not water")
        .desired_width(f32::INFINITY)
        // Tab takes the first proposal.
        .lock_focus(true)
        .layouter(&mut layouter);
    let output = edit.show(ui);
    let response = output.response.response;
    response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::TextInput, true, "Selection"));
    if state.shown.write_selection {
        response.request_focus();
        response.scroll_to_me(None);
    }
    if response.changed() {
        memory.chosen = None;
    }
    let cursor = output.cursor_range.map_or(memory.text.chars().count(), |range| range.primary.index.0);
    let at = memory.text.char_indices().nth(cursor).map_or(memory.text.len(), |(at, _)| at);
    ask(state, memory, at, response.has_focus());
    if response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) && !memory.text.trim().is_empty() {
        actions.push(Action::Choose(How::Words(memory.text.clone())));
    }
    verdict(ui, memory, response.has_focus());
    if response.has_focus()
        && let Some((_, _, proposed)) = &memory.proposed
    {
        for (index, completion) in proposed.all.iter().take(MOST_SHOWN).enumerate() {
            let mut text = LayoutJob::default();
            let format = |color: Color32| TextFormat {
                font_id: FontSelection::Default.resolve(ui.style()),
                color,
                ..TextFormat::default()
            };
            text.append(&completion.text, 0.0, format(ui.visuals().text_color()));
            text.append(completion.help, 10.0, format(ui.visuals().weak_text_color()));
            text.wrap = egui::text::TextWrapping::truncate_at_width(ui.available_width() - 16.0);
            let line = egui::Button::selectable(memory.chosen == Some(index), text)
                .min_size(egui::vec2(ui.available_width(), 20.0));
            // By its text: once it is taken others stand there, and the end of the click is none on them.
            let line = ui.push_id(&completion.text, |ui| ui.add(line)).inner;
            line.widget_info(|| {
                egui::WidgetInfo::labeled(egui::accesskit::Role::ListBoxOption, true, &completion.text)
            });
            // A press takes the focus away before the click is one.
            if line.is_pointer_button_down_on() || line.clicked() {
                accepted = Some(index);
                memory.is_pressed = true;
            }
        }
    }
    if let Some(index) = accepted
        && let Some((_, _, proposed)) = memory.proposed.take()
        && let Some(completion) = proposed.all.get(index)
    {
        put(ui, memory, id, proposed.span, &completion.text);
        response.request_focus();
    }
    if memory.is_pressed {
        // The end of a click that is not on the field takes the focus from it.
        response.request_focus();
        memory.is_pressed = ui.input(|input| input.pointer.any_down());
    }
}

/// Puts a text in the place of another one, and the cursor behind it.
fn put(ui: &Ui, memory: &mut Memory, id: Id, span: Range<usize>, text: &str) {
    if memory.text.get(span.clone()).is_none() {
        return;
    }
    let is_last = span.end == memory.text.len();
    let text = if is_last { format!("{text} ") } else { text.to_owned() };
    let end = span.start + text.len();
    memory.text.replace_range(span, &text);
    memory.chosen = None;
    let cursor = CCursor::new(memory.text[..end].chars().count());
    let mut edit = TextEditState::load(ui.ctx(), id).unwrap_or_default();
    edit.cursor.set_char_range(Some(CCursorRange::one(cursor)));
    edit.store(ui.ctx(), id);
}

/// Asks the selection, and what can be written, if text, place or picture are new.
fn ask(state: &State, memory: &mut Memory, at: usize, has_focus: bool) {
    let text = memory.text.trim_end();
    let is_same =
        memory.asked.as_ref().is_some_and(|(old, of, _)| *old == memory.text && Arc::ptr_eq(of, &state.built));
    if !is_same && !text.is_empty() {
        let atoms: usize = state.built.drawn.iter().map(|(_, drawn)| drawn.structure.atom_count()).sum();
        let found = if atoms > MOST_COUNTED {
            Selection::parse(text).map(|_| None)
        } else {
            selecting::find(state, text).map(|(_, keys)| Some(keys.len()))
        };
        memory.asked = Some((memory.text.clone(), Arc::clone(&state.built), found));
    } else if text.is_empty() {
        memory.asked = None;
    }
    let is_same = memory.proposed.as_ref().is_some_and(|(old, place, _)| *old == memory.text && *place == at);
    if has_focus && !is_same {
        let scopes: Vec<Scope<'_>> = selecting::scopes(state).into_iter().map(|(_, scope)| scope).collect();
        memory.proposed = Some((memory.text.clone(), at, completions(&memory.text, at, &scopes)));
    }
}

/// How many atoms it is, or what is wrong.
fn verdict(ui: &mut Ui, memory: &mut Memory, has_focus: bool) {
    let mut replaced = None;
    match &memory.asked {
        None => {}
        Some((_, _, Ok(count))) => {
            let text = match count {
                None => "Enter selects".to_owned(),
                Some(0) => "No atom is so".to_owned(),
                Some(1) => "1 atom; Enter selects it".to_owned(),
                Some(count) => format!("{} atoms; Enter selects them", grouped(*count)),
            };
            ui.label(RichText::new(text).small().weak());
        }
        // It is still being written.
        Some((_, _, Err(error))) if error.span.is_empty() && has_focus => {
            ui.label(RichText::new(capital(&error.message)).small().weak());
        }
        Some((_, _, Err(error))) => {
            ui.label(RichText::new(capital(&error.message)).small().color(theme::wrong(ui)));
            if let Some(instead) = &error.instead
                && ui.small_button(format!("Did you mean {instead}?")).clicked()
            {
                replaced = Some((error.span.clone(), instead.clone()));
            }
        }
    }
    if let Some((span, instead)) = replaced
        && memory.text.get(span.clone()).is_some()
    {
        memory.text.replace_range(span, &instead);
    }
}

/// The text with what is wrong underlined.
fn marked(ui: &Ui, text: &str, wrong: Range<usize>) -> LayoutJob {
    let font_id = FontSelection::Default.resolve(ui.style());
    let format = TextFormat { font_id, color: ui.visuals().text_color(), ..TextFormat::default() };
    let underlined = TextFormat { underline: Stroke::new(1.5, theme::wrong(ui)), ..format.clone() };
    let mut job = LayoutJob::default();
    match (text.get(..wrong.start), text.get(wrong.clone()), text.get(wrong.end..)) {
        (Some(before), Some(middle), Some(after)) if !middle.is_empty() => {
            job.append(before, 0.0, format.clone());
            job.append(middle, 0.0, underlined);
            job.append(after, 0.0, format);
        }
        _ => job.append(text, 0.0, format),
    }
    job.wrap.max_width = f32::INFINITY;
    job
}

/// What can be done with what is selected.
fn deeds(ui: &mut Ui, state: &State, memory: &mut Memory, actions: &mut Vec<Action>) {
    ui.label(RichText::new(format!("{} selected", grouped(state.work.picked.len()))).strong());
    ui.horizontal_wrapped(|ui| {
        let mut deed = |ui: &mut Ui, text: &str, tip: &str, deed: Deed| {
            button(ui, text, tip, Action::OnPicked(deed), actions);
        };
        deed(ui, "Hide", "Do not draw it (X)", Deed::Hide);
        deed(ui, "Show only", "Draw nothing else (Shift+X)", Deed::ShowOnly);
        deed(ui, "Label", "Label only it (Shift+L)", Deed::Label);
    });
    ui.horizontal(|ui| {
        let mut rgb = [memory.color.r, memory.color.g, memory.color.b];
        let response = ui.color_edit_button_srgb(&mut rgb);
        super::parts::named(&response, "Colour of the selection", &memory.color.to_string());
        memory.color = Srgb8::rgb(rgb[0], rgb[1], rgb[2]);
        let asked = ui.button("Colour").on_hover_text("Give it this colour").clicked();
        if asked || response.changed() {
            actions.push(Action::OnPicked(Deed::Color(memory.color)));
        }
        let style = egui::ComboBox::from_id_salt("style of the selection").selected_text("Style").width(110.0);
        let response = style.show_ui(ui, |ui| {
            for style in Style::ALL {
                if ui.selectable_label(false, format!("{} there", capital(style.name()))).clicked() {
                    actions.push(Action::OnPicked(Deed::Style(style)));
                }
            }
        });
        super::parts::named(&response.response, "Style of the selection", "choose");
    });
}

/// What selections say of the picture, each with a cross to take it back.
fn said(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let by = &state.work.scene.by_selection;
    let mut line = |ui: &mut Ui, text: String, color: Option<Srgb8>, deed: Deed| {
        ui.horizontal(|ui| {
            let response = ui.small_button("×").on_hover_text("Take it back");
            let name = format!("Take back: {text}");
            response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Button, true, &name));
            if response.clicked() {
                actions.push(Action::OnPicked(deed));
            }
            if let Some(color) = color {
                let (rect, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), egui::Sense::hover());
                ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(color.r, color.g, color.b));
            }
            ui.add(egui::Label::new(RichText::new(&text).small()).truncate()).on_hover_text(&text);
        });
    };
    for (number, selection) in by.show.iter().enumerate() {
        line(ui, format!("Only {selection}"), None, Deed::Forget("show", number));
    }
    for (number, selection) in by.hide.iter().enumerate() {
        line(ui, format!("Without {selection}"), None, Deed::Forget("hide", number));
    }
    for (number, (selection, color)) in by.colors.iter().enumerate() {
        line(ui, selection.to_string(), Some(*color), Deed::Forget("color", number));
    }
    for (number, (selection, style)) in by.styles.iter().enumerate() {
        line(ui, format!("{}: {selection}", capital(style.name())), None, Deed::Forget("style", number));
    }
    for (number, selection) in by.labels.iter().enumerate() {
        line(ui, format!("Labels on {selection}"), None, Deed::Forget("label-only", number));
    }
    if by.all().nth(1).is_some() {
        button(ui, "Take all back", "Draw everything as usual", Action::OnPicked(Deed::ForgetAll), actions);
    }
}
