//! Every key of the table does in the window what the table says.

use super::tests::{App, harness, press};
use crate::app::action::Action;
use crate::app::commands::{Shortcut, commands};
use crate::app::state::State;
use crate::app::state::tests::opened;
use egui::{Key, Modifiers};
use egui_kittest::Harness;

/// What can be told of a state: all but times, and what is only of this run.
pub(super) fn told(state: &State) -> String {
    let (work, shown) = (&state.work, &state.shown);
    let frames: Vec<(usize, bool)> = work.layers.iter().map(|layer| (layer.frame, layer.visible)).collect();
    let picked: Vec<u32> = work.picked.iter().map(|key| key.atom).collect();
    let measured: Vec<Vec<u32>> =
        work.measurements.iter().map(|keys| keys.iter().map(|key| key.atom).collect()).collect();
    let open = [
        shown.palette,
        shown.keys,
        shown.picture.is_some(),
        shown.animation.is_some(),
        shown.session.is_some(),
        state.playing.on,
        state.measuring,
        state.preferences.panel,
    ];
    let under_way = (state.pictures.under_way.len(), state.pictures.is_copying, state.loader.under_way().len());
    format!(
        "{frames:?} {:?} {:?} {:?} {:?} {picked:?} {measured:?} {:?} {} {open:?} {under_way:?} {:?} {:?}",
        work.scene,
        work.crystal,
        work.cell_box,
        work.quality,
        work.camera,
        work.fitted,
        state.history.names(),
        state.requests.len()
    )
}

/// A molecule with frames, water's and all, of which something is picked, measured, hidden and undone: so that every command has something to do.
fn prepared() -> State {
    let mut state = opened(&["ethane-rotation.xyz"]);
    let layer = state.work.layers[0].id;
    let key = |atom| crate::app::work::AtomKey { layer, atom };
    state.apply(Action::Pick(Some(key(0))));
    state.apply(Action::PickAlso(key(1)));
    state.apply(Action::Measure);
    state.apply(Action::Pick(Some(key(2))));
    state.apply(Action::Step(3));
    state.apply(Action::Turn(1, 0));
    state.apply(Action::Perspective(false));
    state.apply(Action::Undo);
    state
}

fn modifiers(shortcut: Shortcut) -> Modifiers {
    let command = if shortcut.command { Modifiers::COMMAND } else { Modifiers::NONE };
    if shortcut.shift { command | Modifiers::SHIFT } else { command }
}

#[test]
fn every_key_does_what_its_command_does() {
    // What they do is not to be seen in the state, or not of what is open here.
    let unseen = ["Leave, stop, pick nothing", "Copy the command line of this picture", "Select by words"];
    let table = commands(&prepared());
    let keys: Vec<(Shortcut, &str, &Action)> =
        table.iter().flat_map(|c| c.keys.iter().map(move |key| (*key, c.title.as_str(), &c.action))).collect();
    assert!(keys.len() > 60, "{}", keys.len());
    let mut idle = Vec::new();
    for (shortcut, title, action) in keys {
        // These write files or wait for them; tests of their own press them.
        if matches!(action, Action::Screenshot | Action::Reload | Action::CopyPicture | Action::Play(_)) {
            continue;
        }
        let mut window: Harness<'_, App> = harness(prepared());
        let before = told(&window.state().state);
        let mut other: Harness<'_, App> = harness(prepared());
        other.state_mut().state.apply(action.clone());
        other.run_steps(5);
        // What a system sends for a question mark.
        let held = if shortcut.key == Key::Questionmark { Modifiers::SHIFT } else { modifiers(shortcut) };
        press(&mut window, held, shortcut.key);
        let after = told(&window.state().state);
        assert_eq!(after, told(&other.state().state), "{} is {title}", shortcut.text());
        if after == before && !unseen.contains(&title) {
            idle.push(format!("{}: {title}", shortcut.text()));
        }
    }
    // Without water, ions and the first of the frames there is nothing to see of these but the switch itself.
    assert!(idle.len() <= 3, "these change nothing: {idle:?}");
    println!("unseen here: {idle:?}");
}

#[test]
fn a_key_plays_and_escape_leaves_one_thing_after_the_other() {
    let mut window = harness(prepared());
    press(&mut window, Modifiers::NONE, Key::Space);
    assert!(window.state().state.playing.on);
    press(&mut window, Modifiers::NONE, Key::Space);
    assert!(!window.state().state.playing.on);
    press(&mut window, Modifiers::NONE, Key::F1);
    assert!(window.state().state.shown.keys && !window.state().state.work.picked.is_empty());
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(!window.state().state.shown.keys && !window.state().state.work.picked.is_empty());
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(window.state().state.work.picked.is_empty());
}
