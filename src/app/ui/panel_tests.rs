//! Every control of the panel changes what it names, and nothing else is needed to reach it.

use super::keys_tests::told;
use super::tests::{App, harness, steps};
use crate::app::commands::capital;
use crate::app::state::tests::opened;
use crate::scene::Aromatic;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

/// All that the panel can change.
fn all(harness: &Harness<'_, App>) -> String {
    let state = &harness.state().state;
    format!("{} {:?} {:?}", told(state), state.preferences, state.work.layers.len())
}

/// Does something, and expects that it changes something.
fn changes(harness: &mut Harness<'static, App>, what: &str, act: impl FnOnce(&mut Harness<'static, App>)) {
    let before = all(harness);
    act(harness);
    steps(harness);
    harness.state_mut().state.wait_for_files();
    steps(harness);
    assert!(all(harness) != before, "{what} changes nothing");
}

/// Chooses from a list.
fn choose(harness: &mut Harness<'static, App>, list: &str, entry: &str) {
    changes(harness, list, |harness| {
        harness.get_by_label(list).click_accesskit();
        steps(harness);
        harness.get_by_label(entry).click_accesskit();
    });
    let name = list.split(": ").next().unwrap();
    assert!(harness.query_by_label(&format!("{name}: {entry}")).is_some(), "{name} shows {entry}");
}

fn press(harness: &mut Harness<'static, App>, role: Role, label: &str) {
    changes(harness, label, |harness| harness.get_by_role_and_label(role, label).click_accesskit());
}

#[test]
fn every_control_changes_what_it_names() {
    let mut harness = harness(opened(&["quartz.cif"]));
    for section in ["Labels", "Bonds", "Window"] {
        harness.get_by_label(section).click_accesskit();
        steps(&mut harness);
    }
    let [.., kekule] = Aromatic::ALL;
    for (list, entry) in [
        ("Drawn as: Ball-and-stick", "Licorice".to_owned()),
        ("Colour by: Element", "Chain".to_owned()),
        ("Aromatic: Ring", capital(kekule.name())),
        ("Look: Studio", "Outline".to_owned()),
        ("Quality: Standard", "Draft".to_owned()),
        ("Content: Whole molecules", "Whole cell".to_owned()),
        ("From: All that is known", "By distance alone".to_owned()),
        ("Theme: System", "Dark".to_owned()),
        ("Mouse as in: ballstick", "PyMOL".to_owned()),
    ] {
        choose(&mut harness, list, &entry);
    }
    for switch in [
        "Transparent",
        "Ground",
        "Orthographic",
        "Hydrogens",
        "Water",
        "Hydrogen bonds",
        "Ions",
        "Legend",
        "Scale bar",
        "Axes",
        "Element",
        "Number",
        "Atom name",
        "Residue",
        "One stick from a metal to a ring",
        "Edges of the cell",
        "Read files again when they change",
        "quartz.cif",
        "quartz.cif",
    ] {
        press(&mut harness, Role::CheckBox, switch);
    }
    for button in ["All", "None", "Measure", "Copy command line", "Undo", "Redo", "Close quartz.cif"] {
        press(&mut harness, Role::Button, button);
    }
    assert!(harness.state().state.work.layers.is_empty());
}
