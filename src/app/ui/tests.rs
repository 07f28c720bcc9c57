use super::Memory;
use crate::app::action::Action;
use crate::app::state::tests::{opened, state};
use crate::app::state::{Request, State};
use crate::scene::{Background, ColorBy, Style};
use egui::accesskit::Role;
use egui::{Key, Modifiers, PointerButton, Pos2, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

pub(super) struct App {
    pub(super) state: State,
    memory: Memory,
    view: Rect,
}

pub(super) fn harness(state: State) -> Harness<'static, App> {
    let app = App { state, memory: Memory::default(), view: Rect::NOTHING };
    let mut harness =
        Harness::builder().with_size([1200.0, 900.0]).with_max_steps(40).with_step_dt(0.02).build_ui_state(
            |ui, app: &mut App| {
                app.view = super::show(ui, &mut app.state, &mut app.memory);
                let size = [app.view.width() as u32, app.view.height() as u32];
                app.state.set_view_px(size);
            },
            app,
        );
    super::theme::set_up(&harness.ctx);
    steps(&mut harness);
    harness
}

/// A few frames: some things want to be shown for ever.
pub(super) fn steps(harness: &mut Harness<'_, App>) {
    harness.run_steps(4);
}

pub(super) fn press(harness: &mut Harness<'_, App>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    steps(harness);
}

/// Where an atom is on the screen.
fn place(harness: &Harness<'_, App>, atom: u32) -> Pos2 {
    let app = harness.state();
    let layer = app.state.work.layers[0].id;
    let key = crate::app::work::AtomKey { layer, atom };
    let (center, _) = crate::app::picking::ball(&app.state, key).unwrap();
    let view = app.state.view();
    let p = view.camera.view_from_world().transform_point3(center);
    let grid = view.pixel_grid();
    let x = grid.center_px[0] + p.x / -p.z / grid.plane_per_px;
    let y = grid.center_px[1] - p.y / -p.z / grid.plane_per_px;
    app.view.min + egui::vec2(x, y)
}

fn button(harness: &mut Harness<'_, App>, at: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) {
    harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
}

fn click(harness: &mut Harness<'_, App>, at: Pos2, modifiers: Modifiers) {
    harness.event(egui::Event::PointerMoved(at));
    steps(harness);
    harness.event(egui::Event::ModifiersChanged(modifiers));
    button(harness, at, PointerButton::Primary, true, modifiers);
    steps(harness);
    button(harness, at, PointerButton::Primary, false, modifiers);
    steps(harness);
    harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    // Longer than a double click.
    harness.run_steps(30);
}

fn drag(harness: &mut Harness<'_, App>, with: PointerButton) {
    let from = harness.state().view.center();
    harness.event(egui::Event::PointerMoved(from));
    button(harness, from, with, true, Modifiers::NONE);
    steps(harness);
    for step in 1..6 {
        harness.event(egui::Event::PointerMoved(from + egui::vec2(12.0 * step as f32, 5.0 * step as f32)));
        harness.step();
    }
    assert!(harness.state().state.dragging);
    button(harness, from + egui::vec2(60.0, 25.0), with, false, Modifiers::NONE);
    steps(harness);
    assert!(!harness.state().state.dragging);
}

#[test]
fn an_empty_window_says_how_to_open_something() {
    let mut harness = harness(state());
    assert!(harness.query_by_label("Open a file…").is_some());
    harness.get_by_label("Ferrocene").click();
    steps(&mut harness);
    harness.state_mut().state.wait_for_files();
    steps(&mut harness);
    assert_eq!(harness.state().state.work.layers.len(), 1);
    assert!(harness.query_by_label("Open a file…").is_none());
}

#[test]
fn the_panel_changes_style_colour_and_switches() {
    let mut harness = harness(opened(&["caffeine.sdf"]));
    harness.get_by_label("Drawn as: Ball-and-stick").click();
    steps(&mut harness);
    harness.get_by_label("Licorice").click();
    steps(&mut harness);
    assert_eq!(harness.state().state.work.scene.style, Style::Licorice);
    harness.get_by_label("Colour by: Element").click();
    steps(&mut harness);
    harness.get_by_label("Chain").click();
    steps(&mut harness);
    assert_eq!(harness.state().state.work.scene.color_by, ColorBy::Chain);
    for name in
        ["Ground", "Hydrogens", "Water", "Orthographic", "Axes", "Legend", "Scale bar", "Hydrogen bonds", "Transparent"]
    {
        let before = harness.state().state.work.clone();
        harness.get_by_role_and_label(Role::CheckBox, name).click();
        steps(&mut harness);
        assert!(harness.state().state.work != before, "{name}");
    }
    assert_eq!(harness.state().state.work.scene.background, Background::Transparent);
    for _ in 0..11 {
        harness.get_by_role_and_label(Role::Button, "Undo").click();
        steps(&mut harness);
    }
    assert_eq!(harness.state().state.work.scene.style, Style::BallAndStick);
}

#[test]
fn sections_that_are_closed_open() {
    let mut harness = harness(opened(&["quartz.cif"]));
    for (section, inside) in
        [("Labels", "Atom name"), ("Bonds", "One stick from a metal to a ring"), ("Window", "Copy command line")]
    {
        assert!(harness.query_by_label(inside).is_none(), "{inside}");
        // It may be below the fold.
        harness.get_by_label(section).click_accesskit();
        steps(&mut harness);
        assert!(harness.query_by_label(inside).is_some(), "{inside}");
    }
    assert!(harness.query_by_label("Content: Whole molecules").is_some(), "a crystal has its own section");
}

#[test]
fn keys_act_unless_something_is_typed() {
    let mut harness = harness(opened(&["caffeine.sdf"]));
    press(&mut harness, Modifiers::NONE, Key::Num3);
    assert_eq!(harness.state().state.work.scene.style, Style::SpaceFilling);
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(harness.state().state.work.scene.style, Style::BallAndStick);
    press(&mut harness, Modifiers::NONE, Key::ArrowLeft);
    assert!(!harness.state().state.work.fitted);
    press(&mut harness, Modifiers::NONE, Key::R);
    assert!(harness.state().state.work.fitted);
    press(&mut harness, Modifiers::COMMAND, Key::P);
    assert!(harness.state().state.shown.picture.is_some());
    press(&mut harness, Modifiers::NONE, Key::G);
    assert!(harness.state().state.work.scene.ground, "G is a letter of the file's name now");
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(harness.state().state.shown.picture.is_none());
    press(&mut harness, Modifiers::COMMAND, Key::B);
    assert!(harness.query_by_label("Picture…").is_none(), "the panel is gone");
}

#[test]
fn enter_in_a_dialog_saves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.json");
    let mut harness = harness(opened(&["caffeine.sdf"]));
    press(&mut harness, Modifiers::COMMAND, Key::S);
    harness.state_mut().state.shown.session = Some(path.display().to_string());
    steps(&mut harness);
    press(&mut harness, Modifiers::NONE, Key::Enter);
    assert!(path.exists() && harness.state().state.shown.session.is_none());
}

#[test]
fn the_help_lists_every_key() {
    let mut harness = harness(opened(&["caffeine.sdf"]));
    press(&mut harness, Modifiers::NONE, Key::F1);
    let commands = crate::app::commands::commands(&harness.state().state);
    for command in commands.iter().filter(|command| !command.keys.is_empty()) {
        assert!(harness.query_all_by_label(&command.title).next().is_some(), "{}", command.title);
    }
    press(&mut harness, Modifiers::NONE, Key::F1);
    assert!(!harness.state().state.shown.keys);
}

#[test]
fn the_palette_finds_chooses_and_does() {
    let mut harness = harness(opened(&["caffeine.sdf"]));
    press(&mut harness, Modifiers::COMMAND, Key::K);
    harness.event(egui::Event::Text("wire".to_owned()));
    steps(&mut harness);
    press(&mut harness, Modifiers::NONE, Key::Enter);
    assert_eq!(harness.state().state.work.scene.style, Style::Wireframe);
    assert!(!harness.state().state.shown.palette);
    press(&mut harness, Modifiers::COMMAND, Key::K);
    harness.event(egui::Event::Text("colour by".to_owned()));
    steps(&mut harness);
    press(&mut harness, Modifiers::NONE, Key::ArrowDown);
    press(&mut harness, Modifiers::NONE, Key::ArrowDown);
    press(&mut harness, Modifiers::NONE, Key::Enter);
    assert_eq!(harness.state().state.work.scene.color_by, ColorBy::Residue);
    press(&mut harness, Modifiers::COMMAND, Key::K);
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(!harness.state().state.shown.palette);
}

#[test]
fn buttons_turn_move_and_the_wheel_zooms() {
    let mut harness = harness(opened(&["caffeine.sdf"]));
    for with in [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle] {
        let before = harness.state().state.work.camera;
        drag(&mut harness, with);
        let after = harness.state().state.work.camera;
        assert_eq!(after.world_from_view != before.world_from_view, with == PointerButton::Primary, "{with:?}");
        assert_eq!(after.target != before.target, with != PointerButton::Primary, "{with:?}");
    }
    let before = harness.state().state.work.camera.angstrom_per_px(600);
    let center = harness.state().view.center();
    harness.event(egui::Event::PointerMoved(center));
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 2.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Unknown,
        modifiers: Modifiers::NONE,
    });
    steps(&mut harness);
    let zoomed = harness.state().state.work.camera.angstrom_per_px(600);
    assert!((before / zoomed - crate::app::navigate::ZOOM_PER_NOTCH.powi(2)).abs() < 0.01, "{before} {zoomed}");
}

#[test]
fn a_drag_between_two_frames_turns_as_a_slow_one_does() {
    let mut harness = harness(opened(&["caffeine.sdf"]));
    let before = harness.state().state.work.camera;
    let from = harness.state().view.center();
    let to = from + egui::vec2(40.0, 20.0);
    harness.event(egui::Event::PointerMoved(from));
    steps(&mut harness);
    // All at once, as they come while a frame takes long.
    button(&mut harness, from, PointerButton::Primary, true, Modifiers::NONE);
    harness.event(egui::Event::PointerMoved(to));
    button(&mut harness, to, PointerButton::Primary, false, Modifiers::NONE);
    steps(&mut harness);
    let after = harness.state().state.work.camera;
    assert!(after.world_from_view != before.world_from_view, "it turns");
    assert!(!harness.state().state.dragging && harness.state().state.work.picked.is_empty());
}

#[test]
fn clicks_pick_and_shift_adds_and_m_keeps_the_number() {
    let mut harness = harness(opened(&["benzene.xyz"]));
    let picked =
        |harness: &Harness<'_, App>| harness.state().state.work.picked.iter().map(|key| key.atom).collect::<Vec<_>>();
    let [first, second] = [0, 1].map(|atom| place(&harness, atom));
    click(&mut harness, first, Modifiers::NONE);
    assert_eq!(picked(&harness), [0]);
    click(&mut harness, second, Modifiers::NONE);
    assert_eq!(picked(&harness), [1]);
    click(&mut harness, first, Modifiers::SHIFT);
    assert_eq!(picked(&harness), [1, 0]);
    press(&mut harness, Modifiers::NONE, Key::M);
    assert_eq!(harness.state().state.work.measurements.len(), 1);
    assert!(harness.query_all_by_label_contains(" Å").next().is_some(), "the panel lists it");
    let corner = harness.state().view.min + egui::vec2(5.0, 5.0);
    click(&mut harness, second, Modifiers::NONE);
    click(&mut harness, corner, Modifiers::NONE);
    assert!(picked(&harness).is_empty());
}

#[test]
fn a_double_click_turns_about_the_atom() {
    let mut harness = harness(opened(&["benzene.xyz"]));
    let at = place(&harness, 2);
    harness.event(egui::Event::PointerMoved(at));
    steps(&mut harness);
    for pressed in [true, false, true, false] {
        button(&mut harness, at, PointerButton::Primary, pressed, Modifiers::NONE);
        harness.step();
    }
    steps(&mut harness);
    let app = harness.state();
    let key = crate::app::work::AtomKey { layer: app.state.work.layers[0].id, atom: 2 };
    let center = crate::app::picking::ball(&app.state, key).unwrap().0;
    assert!(app.state.work.camera.target.distance(center) < 1e-4);
}

#[test]
fn the_tip_says_what_is_under_the_pointer() {
    let mut harness = harness(opened(&["benzene.xyz"]));
    let at = place(&harness, 0);
    harness.event(egui::Event::PointerMoved(at));
    steps(&mut harness);
    std::thread::sleep(std::time::Duration::from_millis(300));
    steps(&mut harness);
    assert!(harness.query_by_label("Carbon C").is_some());
    assert!(harness.query_all_by_label_contains("Å, aromatic, by distance").next().is_some());
    // Not over a dialog.
    press(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    assert!(harness.query_by_label("Save animation").is_some() && harness.query_by_label("Carbon C").is_none());
}

#[test]
fn frames_have_a_bar() {
    let mut harness = harness(opened(&["ethane-rotation.xyz"]));
    harness.get_by_role_and_label(Role::Button, ">").click();
    steps(&mut harness);
    assert_eq!(harness.state().state.work.layers[0].frame, 1);
    press(&mut harness, Modifiers::NONE, Key::Space);
    assert!(harness.state().state.playing.on);
    harness.state_mut().state.apply(Action::Play(false));
    let other = self::harness(opened(&["caffeine.sdf"]));
    assert!(other.query_by_label(">").is_none());
}

#[test]
fn errors_can_be_copied_and_dismissed() {
    let mut harness = harness(opened(&["caffeine.sdf"]));
    harness.state_mut().state.complain("That went wrong.");
    steps(&mut harness);
    assert!(harness.query_by_label("That went wrong.").is_some());
    harness.get_by_label("Copy").click();
    steps(&mut harness);
    harness.get_by_label("Dismiss").click();
    steps(&mut harness);
    assert!(harness.query_by_label("That went wrong.").is_none());
}

#[test]
fn the_list_of_atoms_makes_only_the_rows_that_are_seen_and_picks() {
    let mut harness = harness(opened(&["1crn.pdb"]));
    // The panel is scrolled to what is below the fold.
    for section in ["Style", "Light", "Show", "Picked and measured"] {
        harness.get_by_label(section).click();
        steps(&mut harness);
    }
    harness.get_by_label("Atoms").click();
    harness.run_steps(20);
    let rows = harness.query_all_by_label_contains("in chain A").count();
    assert!((5..30).contains(&rows), "{rows}");
    harness.get_by_label_contains("2   CA of THR 1").click();
    steps(&mut harness);
    assert_eq!(harness.state().state.work.picked[0].atom, 1);
}

fn picked(harness: &Harness<'_, App>) -> Vec<u32> {
    harness.state().state.work.picked.iter().map(|key| key.atom).collect()
}

fn type_text(harness: &mut Harness<'_, App>, text: &str) {
    harness.event(egui::Event::Text(text.to_owned()));
    steps(harness);
}

#[test]
fn a_selection_is_written_completed_and_done_something_with() {
    let mut harness = harness(opened(&["caffeine.sdf"]));
    press(&mut harness, Modifiers::COMMAND, Key::F);
    type_text(&mut harness, "elem");
    press(&mut harness, Modifiers::NONE, Key::Tab);
    type_text(&mut harness, "o");
    assert!(harness.query_by_label_contains("2 atoms; Enter selects them").is_some());
    press(&mut harness, Modifiers::NONE, Key::Enter);
    assert_eq!(picked(&harness).len(), 2);
    assert!(harness.query_by_label("2 selected").is_some());
    let before = harness.state().state.built.scene.sphere_count();
    harness.get_by_role_and_label(Role::Button, "Hide").click();
    steps(&mut harness);
    assert_eq!(harness.state().state.built.scene.sphere_count(), before - 2);
    harness.get_by_role_and_label(Role::Button, "Take back: Without element o").click();
    steps(&mut harness);
    assert_eq!(harness.state().state.built.scene.sphere_count(), before);
}

#[test]
fn arrows_choose_a_completion_and_a_click_takes_one() {
    let mut harness = harness(opened(&["1crn.pdb"]));
    press(&mut harness, Modifiers::NONE, Key::Slash);
    type_text(&mut harness, "resname ");
    press(&mut harness, Modifiers::NONE, Key::ArrowDown);
    press(&mut harness, Modifiers::NONE, Key::ArrowDown);
    press(&mut harness, Modifiers::NONE, Key::Enter);
    type_text(&mut harness, "o");
    harness.get_by_role_and_label(Role::ListBoxOption, "or").click();
    steps(&mut harness);
    type_text(&mut harness, "resname tyr");
    press(&mut harness, Modifiers::NONE, Key::Enter);
    let selection = crate::app::selecting::picked_by(&harness.state().state.work).unwrap().to_string();
    assert_eq!(selection, "resname ARG or resname tyr");
}

#[test]
fn mistakes_are_told_under_the_field_with_what_was_meant() {
    let mut harness = harness(opened(&["1crn.pdb"]));
    press(&mut harness, Modifiers::COMMAND, Key::F);
    type_text(&mut harness, "resnmae CYS ");
    assert!(harness.query_by_label_contains("Expected what to select").is_some());
    harness.get_by_label("Did you mean resname?").click();
    steps(&mut harness);
    assert!(harness.query_by_label_contains("36 atoms").is_some());
}

#[test]
fn a_rectangle_with_shift_selects_what_is_in_it() {
    let mut harness = harness(opened(&["benzene.xyz"]));
    let camera = harness.state().state.work.camera;
    let [first, second] = [0, 1].map(|atom| place(&harness, atom));
    let area = Rect::from_two_pos(first, second).expand(6.0);
    harness.event(egui::Event::ModifiersChanged(Modifiers::SHIFT));
    harness.event(egui::Event::PointerMoved(area.min));
    steps(&mut harness);
    button(&mut harness, area.min, PointerButton::Primary, true, Modifiers::SHIFT);
    steps(&mut harness);
    for part in 1..=5 {
        harness.event(egui::Event::PointerMoved(area.min.lerp(area.max, part as f32 / 5.0)));
        harness.step();
    }
    assert!(!harness.state().state.dragging, "the picture rests");
    button(&mut harness, area.max, PointerButton::Primary, false, Modifiers::SHIFT);
    steps(&mut harness);
    let picked = picked(&harness);
    assert!(picked.contains(&0) && picked.contains(&1) && picked.len() < 12, "{picked:?}");
    assert!(harness.state().state.work.camera == camera);
}

#[test]
fn the_sequence_selects_and_shows_what_is_selected() {
    let mut harness = harness(opened(&["1crn.pdb"]));
    assert!(harness.query_by_label("Chain A (46 residues)").is_some());
    harness.get_by_label("THR 2").click_accesskit();
    steps(&mut harness);
    assert_eq!(picked(&harness), (7..14).collect::<Vec<u32>>());
    let layer = harness.state().state.work.layers[0].id;
    harness.state_mut().state.apply(Action::Pick(Some(crate::app::work::AtomKey { layer, atom: 15 })));
    steps(&mut harness);
    let is_on = |harness: &Harness<'_, App>, label: &str| {
        harness.get_by_label(label).accesskit_node().toggled().map(|toggled| toggled == egui::accesskit::Toggled::True)
    };
    assert_eq!(is_on(&harness, "CYS 3"), Some(true));
    assert_eq!(is_on(&harness, "THR 2"), Some(false));
}

#[test]
fn sizes_and_ions_have_their_places_in_the_panel() {
    let mut harness = harness(opened(&["caffeine.sdf"]));
    assert!(harness.query_by_label("Size of balls").is_some() && harness.query_by_label("Size of sticks").is_some());
    harness.get_by_role_and_label(Role::CheckBox, "Ions").click();
    steps(&mut harness);
    assert!(!harness.state().state.work.scene.ions);
    let before = harness.state().state.built.scene.blocks[0].spheres[0].radius;
    harness.state_mut().state.apply(Action::BallScale(2.0));
    assert!((harness.state().state.built.scene.blocks[0].spheres[0].radius / before - 2.0).abs() < 1e-5);
}

#[test]
fn a_film_is_asked_for_and_copying_means_the_picture() {
    let mut harness = harness(opened(&["ethane-rotation.xyz"]));
    press(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    assert!(harness.query_by_label("Save animation").is_some());
    harness.get_by_label("Turntable").click();
    steps(&mut harness);
    harness.get_by_label("APNG").click();
    steps(&mut harness);
    let dialog = harness.state().state.shown.animation.clone().unwrap();
    assert_eq!(dialog.kind, crate::app::animations::Kind::Turntable(100));
    assert!(dialog.path.ends_with(".apng"), "{}", dialog.path);
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(harness.query_by_label("Save animation").is_none());
    harness.event(egui::Event::Copy);
    steps(&mut harness);
    let is_asked = |state: &State| {
        state.pictures.is_copying || state.requests.iter().any(|request| matches!(request, Request::CopyImage(_)))
    };
    assert!(is_asked(&harness.state().state));
}
