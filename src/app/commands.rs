//! The one table of commands: what there is to do, under which name, by which key. The palette lists it, the help is made of it, and
//! keys are looked up in it.

use super::action::Action;
use super::mouse::Preset;
use super::preferences::Theme;
use super::selecting::{Deed, How};
use super::state::{AtEnd, State};
use crate::bonds::BondMode;
use crate::color::Srgb8;
use crate::crystal::{BondsPerFrame, CellChoice};
use crate::render::Quality;
use crate::scene::{Aromatic, Background, ColorBy, LabelContent, Look, Style};
use crate::session::samples::SAMPLES;
use egui::{Key, Modifiers};

/// A key with its modifiers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shortcut {
    pub(super) key: Key,
    /// Ctrl, or ⌘ on a Mac.
    pub(super) command: bool,
    pub(super) shift: bool,
}

impl Shortcut {
    /// As people write it.
    pub(super) fn text(self) -> String {
        let mut text = String::new();
        if self.command {
            text.push_str(if cfg!(target_os = "macos") { "⌘" } else { "Ctrl+" });
        }
        if self.shift {
            text.push_str("Shift+");
        }
        let name = match self.key {
            Key::Questionmark => "?",
            Key::ArrowLeft => "Left",
            Key::ArrowRight => "Right",
            Key::ArrowUp => "Up",
            Key::ArrowDown => "Down",
            Key::Plus => "+",
            Key::Minus => "-",
            Key::Escape => "Esc",
            Key::Comma => ",",
            Key::Period => ".",
            Key::Slash => "/",
            other => other.name(),
        };
        text.push_str(name);
        text
    }

    /// Whether a key that was pressed is this one. Keys whose character already needs Shift on some keyboards take it either way.
    fn matches(self, key: Key, modifiers: Modifiers) -> bool {
        let same = self.key == key || (self.key == Key::Plus && key == Key::Equals);
        let shift_is_part = matches!(key, Key::Questionmark | Key::Plus | Key::Equals);
        same && modifiers.command == self.command && !modifiers.alt && (shift_is_part || modifiers.shift == self.shift)
    }
}

const fn plain(key: Key) -> Shortcut {
    Shortcut { key, command: false, shift: false }
}

const fn shift(key: Key) -> Shortcut {
    Shortcut { key, command: false, shift: true }
}

const fn ctrl(key: Key) -> Shortcut {
    Shortcut { key, command: true, shift: false }
}

/// Something in the table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Command {
    pub(super) group: &'static str,
    pub(super) title: String,
    pub(super) keys: Vec<Shortcut>,
    pub(super) action: Action,
    /// Whether it is on, where it can be.
    pub(super) on: Option<bool>,
    /// Whether a key that is held down does it again and again.
    pub(super) repeats: bool,
}

/// The groups in the order of the help.
pub(super) const GROUPS: [&str; 7] =
    ["File", "View", "Look", "Molecule", "Selection and measuring", "Frames", "Window"];

struct Table<'a> {
    group: &'static str,
    commands: &'a mut Vec<Command>,
}

impl Table<'_> {
    fn add(&mut self, title: impl Into<String>, keys: &[Shortcut], action: Action) -> &mut Command {
        let command =
            Command { group: self.group, title: title.into(), keys: keys.to_vec(), action, on: None, repeats: false };
        self.commands.push(command);
        let last = self.commands.len() - 1;
        &mut self.commands[last]
    }

    /// Something that is on or off.
    fn switch(&mut self, title: &str, keys: &[Shortcut], on: bool, action: impl Fn(bool) -> Action) {
        self.add(title, keys, action(!on)).on = Some(on);
    }

    /// One of several.
    fn choice(&mut self, title: String, keys: &[Shortcut], is_chosen: bool, action: Action) {
        self.add(title, keys, action).on = Some(is_chosen);
    }

    fn repeating(&mut self, title: &str, key: Shortcut, action: Action) {
        self.add(title, &[key], action).repeats = true;
    }
}

/// All commands, with what is on now.
pub(super) fn commands(state: &State) -> Vec<Command> {
    let mut commands = Vec::with_capacity(150);
    file(Table { group: GROUPS[0], commands: &mut commands });
    view(Table { group: GROUPS[1], commands: &mut commands }, state);
    look(Table { group: GROUPS[2], commands: &mut commands }, state);
    molecule(Table { group: GROUPS[3], commands: &mut commands }, state);
    selection(Table { group: GROUPS[4], commands: &mut commands }, state);
    frames(Table { group: GROUPS[5], commands: &mut commands }, state);
    window(Table { group: GROUPS[6], commands: &mut commands }, state);
    commands
}

fn file(mut table: Table<'_>) {
    table.add("Open…", &[ctrl(Key::O)], Action::OpenDialog);
    table.add("Read files again", &[plain(Key::F5), ctrl(Key::R)], Action::Reload);
    table.add("Save picture at once", &[plain(Key::S)], Action::Screenshot);
    table.add("Save picture…", &[ctrl(Key::P)], Action::PictureDialog(true));
    let film = Shortcut { key: Key::P, command: true, shift: true };
    table.add("Save animation…", &[film], Action::AnimationDialog(true));
    table.add("Copy the picture", &[ctrl(Key::C)], Action::CopyPicture);
    table.add("Save session…", &[ctrl(Key::S)], Action::SessionDialog(true));
    let copy = Shortcut { key: Key::C, command: true, shift: true };
    table.add("Copy the command line of this picture", &[copy], Action::CopyCommand);
    table.add("Close all molecules", &[ctrl(Key::W)], Action::CloseAll);
    for (number, sample) in SAMPLES.iter().enumerate() {
        table.add(format!("Sample: {}", sample.name), &[], Action::OpenSample(number));
    }
    table.add("Quit", &[plain(Key::Q), ctrl(Key::Q)], Action::Quit);
}

fn view(mut table: Table<'_>, state: &State) {
    table.add("Reset the view", &[plain(Key::R), plain(Key::Home)], Action::ResetView);
    table.add("Centre on what is picked", &[plain(Key::C)], Action::Center);
    let perspective = state.work.scene.perspective;
    table.switch("Orthographic projection", &[plain(Key::O)], !perspective, |on| Action::Perspective(!on));
    table.repeating("Turn left", plain(Key::ArrowLeft), Action::Turn(-1, 0));
    table.repeating("Turn right", plain(Key::ArrowRight), Action::Turn(1, 0));
    table.repeating("Turn up", plain(Key::ArrowUp), Action::Turn(0, 1));
    table.repeating("Turn down", plain(Key::ArrowDown), Action::Turn(0, -1));
    table.repeating("Move left", shift(Key::ArrowLeft), Action::Move(-1, 0));
    table.repeating("Move right", shift(Key::ArrowRight), Action::Move(1, 0));
    table.repeating("Move up", shift(Key::ArrowUp), Action::Move(0, 1));
    table.repeating("Move down", shift(Key::ArrowDown), Action::Move(0, -1));
    table.repeating("Zoom in", plain(Key::Plus), Action::Zoom(1));
    table.repeating("Zoom out", plain(Key::Minus), Action::Zoom(-1));
}

/// A name with a capital letter.
pub(super) fn capital(name: &str) -> String {
    let mut characters = name.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

fn look(mut table: Table<'_>, state: &State) {
    let scene = &state.work.scene;
    for (style, key) in Style::ALL.into_iter().zip([Key::Num1, Key::Num2, Key::Num3, Key::Num4]) {
        table.choice(capital(style.name()), &[plain(key)], scene.style == style, Action::Style(style));
    }
    for by in ColorBy::ALL {
        table.choice(format!("Colour by {}", by.name()), &[], scene.color_by == by, Action::ColorBy(by));
    }
    for look in Look::ALL {
        table.choice(format!("Light: {}", look.name()), &[], scene.look == look, Action::Look(look));
    }
    table.switch("Ground", &[plain(Key::G)], scene.ground, Action::Ground);
    let transparent = scene.background == Background::Transparent;
    let opaque = Background::Color(scene.look.background());
    table.switch("Transparent background", &[plain(Key::T)], transparent, |on| {
        Action::Background(if on { Background::Transparent } else { opaque })
    });
    table.switch("Directions of the axes", &[plain(Key::A)], scene.axes, Action::Axes);
    table.switch("Legend of colours", &[plain(Key::L)], scene.text.legend, Action::Legend);
    table.switch("Scale bar", &[plain(Key::B)], scene.text.scale_bar, Action::ScaleBar);
    let labels = scene.text.labels;
    for (title, on, with) in [
        ("Label elements", labels.element, LabelContent { element: !labels.element, ..labels }),
        ("Label numbers", labels.index, LabelContent { index: !labels.index, ..labels }),
        ("Label atom names", labels.name, LabelContent { name: !labels.name, ..labels }),
        ("Label residues", labels.residue, LabelContent { residue: !labels.residue, ..labels }),
    ] {
        table.choice(title.to_owned(), &[], on, Action::Labels(with));
    }
    for quality in Quality::ALL {
        let title = format!("Quality: {}", quality.name());
        table.choice(title, &[], state.work.quality == quality, Action::Quality(quality));
    }
}

fn molecule(mut table: Table<'_>, state: &State) {
    let (scene, crystal) = (&state.work.scene, &state.work.crystal);
    table.switch("Hydrogens", &[plain(Key::H)], scene.hydrogens, Action::Hydrogens);
    table.switch("Water", &[plain(Key::W)], scene.water, Action::Water);
    table.switch("Ions", &[shift(Key::W)], scene.ions, Action::Ions);
    table.switch("Hydrogen bonds", &[shift(Key::H)], crystal.bonds.hydrogen_bonds, Action::HydrogenBonds);
    for aromatic in Aromatic::ALL {
        let title = format!("Aromatic bonds: {}", aromatic.name());
        table.choice(title, &[], scene.aromatic == aromatic, Action::Aromatic(aromatic));
    }
    table.switch("One stick from a metal to a ring", &[], scene.haptic, Action::Haptic);
    for mode in BondMode::ALL {
        table.choice(format!("Bonds: {}", mode.name()), &[], crystal.bonds.mode == mode, Action::Bonds(mode));
    }
    for when in BondsPerFrame::ALL {
        let title = format!("Bonds anew in each frame: {}", when.name());
        table.choice(title, &[], crystal.bonds_per_frame == when, Action::BondsPerFrame(when));
    }
    for cell in CellChoice::ALL {
        table.choice(format!("Crystal: {}", cell.name()), &[], crystal.cell == cell, Action::Cell(cell));
    }
    for n in 1..=3 {
        let counts = [n; 3];
        table.choice(format!("Supercell {n}×{n}×{n}"), &[], crystal.supercell == counts, Action::Supercell(counts));
    }
    let known = super::assemblies::known(state);
    for (id, words) in known.iter().filter(|_| known.len() > 1) {
        table.choice(format!("Assembly {words}"), &[], crystal.assembly == *id, Action::Assembly(*id));
    }
    table.switch("Edges of the cell", &[], state.work.cell_box == Some(true), |on| Action::CellBox(Some(on)));
}

fn selection(mut table: Table<'_>, state: &State) {
    table.add("Measure: keep it, or begin", &[plain(Key::M)], Action::Measure);
    table.add("Forget all measurements", &[shift(Key::M)], Action::ForgetMeasurements);
    table.switch("Clicks gather atoms to measure", &[], state.measuring, Action::Measuring);
    table.add("Pick all", &[ctrl(Key::A)], Action::PickAll);
    table.add("Pick nothing", &[shift(Key::A)], Action::PickNone);
    table.add("Pick the residue, the chain, all", &[plain(Key::E)], Action::PickMore);
    let choose = Action::Choose;
    table.add("Select by words", &[ctrl(Key::F), plain(Key::Slash)], choose(How::Write));
    table.add("Select what is not selected", &[ctrl(Key::I)], choose(How::Invert));
    table.add("Select what has bonds to it as well", &[shift(Key::E)], choose(How::Grow));
    for words in ["protein", "nucleic", "ligand", "water", "ion", "metal", "hydrogen", "backbone", "sidechain"] {
        table.add(format!("Select: {words}"), &[], choose(How::Words(words.to_owned())));
    }
    let deed = Action::OnPicked;
    table.add("Hide what is selected", &[plain(Key::X)], deed(Deed::Hide));
    table.add("Show only what is selected", &[shift(Key::X)], deed(Deed::ShowOnly));
    table.add("Show everything again", &[plain(Key::V)], deed(Deed::ShowAll));
    table.add("Label what is selected", &[shift(Key::L)], deed(Deed::Label));
    for style in Style::ALL {
        table.add(format!("Selected atoms: {}", style.name()), &[], deed(Deed::Style(style)));
    }
    for name in COLORS {
        if let Some(color) = Srgb8::parse(name) {
            table.add(format!("Selected atoms: {name}"), &[], deed(Deed::Color(color)));
        }
    }
    table.add("Take back all that selections say", &[], deed(Deed::ForgetAll));
}

/// Colours that the palette has for what is selected.
const COLORS: [&str; 9] = ["red", "orange", "gold", "green", "turquoise", "steelblue", "purple", "white", "grey"];

fn frames(mut table: Table<'_>, state: &State) {
    table.switch("Play", &[plain(Key::Space)], state.playing.on, Action::Play);
    table.repeating("Next frame", plain(Key::Period), Action::Step(1));
    table.repeating("Frame before", plain(Key::Comma), Action::Step(-1));
    table.add("First frame", &[ctrl(Key::Home)], Action::FirstFrame);
    table.add("Last frame", &[ctrl(Key::End)], Action::LastFrame);
    for what in AtEnd::ALL {
        let title = format!("At the last frame: {}", what.name().to_lowercase());
        table.choice(title, &[], state.playing.at_end == what, Action::AtEnd(what));
    }
}

fn window(mut table: Table<'_>, state: &State) {
    table.add("Undo", &[ctrl(Key::Z)], Action::Undo).repeats = true;
    let redo = Shortcut { key: Key::Z, command: true, shift: true };
    table.add("Redo", &[redo, ctrl(Key::Y)], Action::Redo).repeats = true;
    table.add("Commands…", &[ctrl(Key::K)], Action::Palette(true));
    table.switch("Keys and mouse", &[plain(Key::Questionmark), plain(Key::F1)], state.shown.keys, Action::Keys);
    table.switch("Panel", &[ctrl(Key::B)], state.preferences.panel, Action::Panel);
    table.switch("Read files again when they change", &[], state.preferences.reloads, Action::Reloads);
    for theme in Theme::ALL {
        let title = format!("Theme: {}", theme.name());
        table.choice(title, &[], state.preferences.theme == theme, Action::Theme(theme));
    }
    for preset in Preset::ALL {
        let title = format!("Mouse as in {}", preset.name());
        table.choice(title, &[], state.preferences.mouse == preset, Action::Mouse(preset));
    }
    table.add("Leave, stop, pick nothing", &[plain(Key::Escape)], Action::Escape);
}

/// What a key that was pressed does.
pub(super) fn of_key(state: &State, key: Key, modifiers: Modifiers, repeat: bool) -> Option<Action> {
    let is_it = |command: &Command| {
        (command.repeats || !repeat) && command.keys.iter().any(|shortcut| shortcut.matches(key, modifiers))
    };
    commands(state).into_iter().find(is_it).map(|command| command.action)
}

/// The commands whose title has all words of a text, those that begin with it first.
pub(super) fn found(state: &State, text: &str) -> Vec<Command> {
    let text = text.to_lowercase();
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut found: Vec<Command> = commands(state)
        .into_iter()
        .filter(|command| {
            let title = format!("{} {}", command.title, command.group).to_lowercase();
            words.iter().all(|word| title.contains(word))
        })
        .filter(|command| command.action != Action::Palette(true))
        .collect();
    found.sort_by_key(|command| !command.title.to_lowercase().starts_with(text.trim()));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::state::tests::state;

    #[test]
    fn no_key_has_two_meanings() {
        let commands = commands(&state());
        let mut keys: Vec<String> = commands.iter().flat_map(|c| &c.keys).map(|key| key.text()).collect();
        let count = keys.len();
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), count);
        assert!(commands.iter().all(|command| GROUPS.contains(&command.group) && !command.title.is_empty()));
    }

    #[test]
    fn keys_do_what_the_readme_says() {
        let state = state();
        let none = Modifiers::NONE;
        assert_eq!(of_key(&state, Key::R, none, false), Some(Action::ResetView));
        assert_eq!(of_key(&state, Key::Num3, none, false), Some(Action::Style(Style::SpaceFilling)));
        assert_eq!(of_key(&state, Key::K, Modifiers::COMMAND, false), Some(Action::Palette(true)));
        assert_eq!(of_key(&state, Key::Questionmark, Modifiers::SHIFT, false), Some(Action::Keys(true)));
        assert_eq!(of_key(&state, Key::Equals, none, false), Some(Action::Zoom(1)));
        assert_eq!(of_key(&state, Key::K, none, false), None);
        // Held down, a picture is saved once, and frames go on.
        assert_eq!(of_key(&state, Key::S, none, true), None);
        assert_eq!(of_key(&state, Key::Period, none, true), Some(Action::Step(1)));
    }

    #[test]
    fn the_palette_finds_by_words_in_any_order() {
        let state = state();
        let titles = |text: &str| found(&state, text).into_iter().map(|c| c.title).collect::<Vec<_>>();
        assert_eq!(titles("dark light"), ["Light: dark"]);
        assert_eq!(titles("ground")[0], "Ground");
        assert!(titles("").len() > 60 && titles("xyzzy").is_empty());
    }
}
