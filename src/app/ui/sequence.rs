//! The chains by the letters of their residues: only the rows that are seen are made. What is selected is marked, and a click or a drag
//! over letters selects.

use crate::app::action::Action;
use crate::app::picking;
use crate::app::selecting::How;
use crate::app::state::State;
use crate::app::work::AtomKey;
use crate::bonds::residue_atoms;
use crate::crystal::Drawn;
use crate::select::{ResidueKind, one_letter, residue_kinds};
use egui::{Align2, Color32, FontId, Rect, RichText, ScrollArea, Sense, Ui};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

/// A residue of a chain: its layer, and its number among the residues of that.
type Place = (u32, usize);

/// What is drawn of a layer.
type Layer = (u32, Arc<Drawn>);

/// A chain, and where its residues are among all of the list.
struct Chain {
    name: String,
    residues: Range<usize>,
}

/// What the list keeps.
#[derive(Default)]
pub(super) struct Memory {
    /// What the chains are of.
    of: Vec<Layer>,
    chains: Vec<Chain>,
    residues: Vec<(Place, char)>,
    picked: Option<Arc<Vec<AtomKey>>>,
    /// The residues that picked atoms are of, and the last one.
    marked: HashSet<Place>,
    /// Where in the list a drag over letters began.
    from: Option<usize>,
}

/// Height of the list, of its rows and width of a letter and of the number before them, points.
const HEIGHT: f32 = 150.0;
const ROW: f32 = 18.0;
const LETTER: f32 = 11.5;
const NUMBER: f32 = 36.0;

impl Memory {
    /// Lists the chains of what is drawn.
    fn follow(&mut self, state: &State) {
        let drawn = &state.built.drawn;
        let is_same = |((a, one), (b, other)): (&Layer, &Layer)| a == b && Arc::ptr_eq(one, other);
        if self.of.len() == drawn.len() && self.of.iter().zip(drawn).all(is_same) {
            return;
        }
        *self = Memory { of: drawn.clone(), ..Memory::default() };
        for (layer, drawn) in drawn {
            let structure = &drawn.structure;
            let names: Vec<&str> = structure.chains().collect();
            let mut last = None;
            for (index, kind) in residue_kinds(structure).into_iter().enumerate() {
                if !matches!(kind, ResidueKind::Protein | ResidueKind::Nucleic) {
                    continue;
                }
                let residue = structure.residues()[index];
                let end = self.residues.len();
                if last != Some(residue.chain) {
                    let name = names.get(residue.chain as usize).map_or("", |name| name.trim());
                    let name = if name.is_empty() { "Chain".to_owned() } else { format!("Chain {name}") };
                    self.chains.push(Chain { name, residues: end..end });
                    last = Some(residue.chain);
                }
                self.residues.push(((*layer, index), one_letter(structure.name(residue.name)).unwrap_or('X')));
                if let Some(chain) = self.chains.last_mut() {
                    chain.residues.end += 1;
                }
            }
        }
    }

    /// Marks the residues of what is picked; whether that is news.
    fn mark(&mut self, state: &State) -> bool {
        let picked = &state.work.picked;
        if self.picked.as_ref().is_some_and(|old| Arc::ptr_eq(old, picked)) {
            return false;
        }
        self.marked = picked.iter().filter_map(|key| residue_of(state, *key)).collect();
        self.picked = Some(Arc::clone(picked));
        true
    }
}

fn residue_of(state: &State, key: AtomKey) -> Option<Place> {
    let drawn = picking::drawn(state, key.layer)?;
    Some((key.layer, drawn.structure.residue_index(drawn.own_atom(key.atom)?.1)?))
}

/// Whether there is a chain.
pub(super) fn has_any(state: &State, memory: &mut Memory) -> bool {
    memory.follow(state);
    !memory.chains.is_empty()
}

/// A row: the name of a chain, or some of its residues.
fn rows(chains: &[Chain], per_row: usize) -> Vec<(usize, Range<usize>)> {
    let mut rows = Vec::new();
    for (index, chain) in chains.iter().enumerate() {
        rows.push((index, 0..0));
        let starts = chain.residues.clone().step_by(per_row);
        rows.extend(starts.map(|start| (index, start..(start + per_row).min(chain.residues.end))));
    }
    rows
}

/// Shows the list.
pub(super) fn show(ui: &mut Ui, state: &State, memory: &mut Memory, actions: &mut Vec<Action>) {
    memory.follow(state);
    let is_news = memory.mark(state);
    let per_row = (((ui.available_width() - NUMBER - 14.0) / LETTER) as usize).clamp(5, 60) / 5 * 5;
    let rows = rows(&memory.chains, per_row);
    let mut area = ScrollArea::vertical()
        .min_scrolled_height(HEIGHT)
        .max_height(HEIGHT)
        .auto_shrink([false, true])
        .id_salt("sequence");
    let last = memory.picked.as_ref().filter(|_| is_news).and_then(|picked| residue_of(state, *picked.last()?));
    if let Some(at) = last.and_then(|place| memory.residues.iter().position(|(own, _)| *own == place))
        && let Some(row) = rows.iter().position(|(_, range)| range.contains(&at))
    {
        // What was picked in the picture comes into sight.
        area = area.vertical_scroll_offset((row as f32 * (ROW + ui.spacing().item_spacing.y) - HEIGHT * 0.4).max(0.0));
    }
    let mut over = None;
    let mut clicked = None;
    area.show_rows(ui, ROW, rows.len(), |ui, seen| {
        for (chain, range) in &rows[seen] {
            if range.is_empty() {
                name_row(ui, state, memory, *chain, actions);
                continue;
            }
            let (rect, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), ROW), Sense::hover());
            number(ui, memory, rect, range.start);
            for (column, at) in range.clone().enumerate() {
                let left = rect.left() + NUMBER + column as f32 * LETTER;
                let cell = Rect::from_min_size(egui::pos2(left, rect.top()), egui::vec2(LETTER, ROW));
                let response = letter(ui, memory, cell, at);
                if response.drag_started() {
                    memory.from = Some(at);
                }
                if ui.input(|input| input.pointer.latest_pos()).is_some_and(|pos| cell.contains(pos)) {
                    over = Some(at);
                }
                if response.clicked() {
                    clicked = Some(at);
                }
            }
        }
    });
    let adds = ui.input(|input| input.modifiers.shift || input.modifiers.command);
    if let Some(at) = clicked {
        memory.from = None;
        let is_marked = memory.marked.contains(&memory.residues[at].0);
        let keys = atoms(memory, at..at + 1);
        actions.push(Action::Choose(match (adds, is_marked) {
            (true, true) => {
                let gone: HashSet<AtomKey> = keys.into_iter().collect();
                How::These(state.work.picked.iter().copied().filter(|key| !gone.contains(key)).collect())
            }
            (true, false) => How::Also(keys),
            (false, _) => How::These(keys),
        }));
    } else if ui.input(|input| input.pointer.any_released())
        && let (Some(from), Some(to)) = (memory.from.take(), over)
    {
        let keys = atoms(memory, from.min(to)..from.max(to) + 1);
        actions.push(Action::Choose(if adds { How::Also(keys) } else { How::These(keys) }));
    }
}

/// The atoms of residues of the list.
fn atoms(memory: &Memory, range: Range<usize>) -> Vec<AtomKey> {
    let drawn: HashMap<u32, &Arc<Drawn>> = memory.of.iter().map(|(layer, drawn)| (*layer, drawn)).collect();
    let mut keys = Vec::new();
    for ((layer, residue), _) in memory.residues.get(range).unwrap_or_default() {
        let Some(drawn) = drawn.get(layer) else { continue };
        let own = residue_atoms(&drawn.structure, *residue);
        keys.extend(own.filter_map(|atom| Some(AtomKey { layer: *layer, atom: u32::try_from(atom).ok()? })));
    }
    keys
}

/// The name of a chain, which selects it.
fn name_row(ui: &mut Ui, state: &State, memory: &Memory, chain: usize, actions: &mut Vec<Action>) {
    let Chain { name, residues } = &memory.chains[chain];
    let layer = memory.residues.get(residues.start).map(|((layer, _), _)| *layer);
    let file = layer.filter(|_| state.work.layers.len() > 1).and_then(|id| state.work.layer(id));
    let text = match file {
        Some(layer) => format!("{name}, {} ({} residues)", layer.source.name(), residues.len()),
        None => format!("{name} ({} residues)", residues.len()),
    };
    let button = egui::Button::new(RichText::new(text).small().strong()).frame(false).min_size(egui::vec2(0.0, ROW));
    if ui.add(button).on_hover_text("Select the chain").clicked() {
        actions.push(Action::Choose(How::These(atoms(memory, residues.clone()))));
    }
}

/// The number of the first residue of a row.
fn number(ui: &Ui, memory: &Memory, rect: Rect, at: usize) {
    let ((layer, residue), _) = memory.residues[at];
    let Some((_, drawn)) = memory.of.iter().find(|(own, _)| *own == layer) else { return };
    let number = drawn.structure.residues()[residue].number.to_string();
    let place = egui::pos2(rect.left() + NUMBER - 8.0, rect.center().y);
    ui.painter().text(place, Align2::RIGHT_CENTER, number, FontId::proportional(10.0), ui.visuals().weak_text_color());
}

/// One letter.
fn letter(ui: &Ui, memory: &Memory, cell: Rect, at: usize) -> egui::Response {
    let (place, letter) = memory.residues[at];
    let response = ui.interact(cell, ui.scope_id().with(("letter", at)), Sense::click_and_drag());
    let name = || {
        let drawn = memory.of.iter().find(|(own, _)| *own == place.0).map(|(_, drawn)| drawn);
        drawn.map_or_else(String::new, |drawn| {
            let residue = drawn.structure.residues()[place.1];
            let code = Some(char::from(residue.insertion_code)).filter(|code| *code != ' ');
            let code = code.map(String::from).unwrap_or_default();
            format!("{} {}{code}", drawn.structure.name(residue.name), residue.number)
        })
    };
    let is_marked = memory.marked.contains(&place);
    response.widget_info(|| egui::WidgetInfo::selected(egui::accesskit::Role::Button, true, is_marked, name()));
    if is_marked {
        ui.painter().rect_filled(cell, 0.0, ui.visuals().selection.bg_fill);
    } else if response.hovered() {
        ui.painter().rect_filled(cell, 0.0, ui.visuals().widgets.hovered.weak_bg_fill);
    }
    let color: Color32 = if is_marked { ui.visuals().selection.stroke.color } else { ui.visuals().text_color() };
    ui.painter().text(cell.center(), Align2::CENTER_CENTER, letter, FontId::monospace(12.0), color);
    if response.hovered() { response.on_hover_text(name()) } else { response }
}
