use super::*;
use crate::app::action::Action;
use crate::app::state::tests::{settle, state};
use crate::app::work::Source;
use crate::import::{ImportOptions, read_bytes};
use crate::render::Quality;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

/// A long bar of atoms, denser than bonds.
fn bar(count: usize) -> String {
    let mut text = format!("{count}\n\n");
    for index in 0..count {
        let (x, y, z) = (index / 36, index / 6 % 6, index % 6);
        writeln!(text, "Ar {:.1} {:.1} {:.1}", 4.0 * x as f64, 4.0 * y as f64, 4.0 * z as f64).unwrap();
    }
    text
}

/// A file of its own that goes with the test.
struct File(PathBuf);

impl File {
    fn new(name: &str, text: &str) -> File {
        let path = std::env::temp_dir().join(format!("ballstick-preview-{}-{name}", std::process::id()));
        std::fs::write(&path, text).unwrap();
        File(path)
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A preview of every tenth atom.
fn preview(state: &State, load: u32, count: usize) -> Preview {
    let text = bar(count);
    let mut lines: Vec<&str> = text.lines().skip(2).step_by(10).collect();
    lines.extend(text.lines().last());
    let text = format!("{}\n\n{}\n", lines.len(), lines.join("\n"));
    let document = read_bytes(text.as_bytes(), "a.xyz", &ImportOptions::default()).unwrap();
    let glimpse = Glimpse { structure: document.records[0].clone(), about_atoms: count as u64 };
    Preview::of(load, &glimpse, &state.preview_options().unwrap_or_default())
}

/// A window with a preview of a file that is being read.
fn waiting(file: &File, count: usize) -> State {
    let mut state = state();
    state.apply(Action::Open(file.0.clone()));
    let load = state.loader.under_way()[0].id;
    let preview = preview(&state, load, count);
    state.show_preview(preview);
    assert!(state.preview.is_some());
    state
}

/// How far an eye has moved, as a part of its distance.
fn jump(from: Camera, to: Camera) -> f32 {
    from.eye.distance(to.eye) / from.eye.distance(from.target)
}

const COUNT: usize = 36_000;

#[test]
fn a_preview_is_seen_and_the_molecule_takes_its_place_without_a_jump() {
    let file = File::new("seen.xyz", &bar(COUNT));
    let mut state = waiting(&file, COUNT);
    assert_eq!(state.scene().sphere_count(), COUNT / 10 + 1);
    assert_eq!(state.fine(Quality::High), Quality::Draft.settings());
    assert_eq!(state.preview.as_ref().unwrap().says(), "Preview: 3,601 of about 36,000 atoms");
    let (camera, pose) = (state.work.camera, state.scene().pose);
    settle(&mut state);
    assert!(state.preview.is_none() && state.work.fitted);
    assert_eq!((state.scene().sphere_count(), state.built.scene.sphere_count()), (COUNT, COUNT));
    assert_eq!(state.built.scene.pose, pose);
    assert!(jump(camera, state.work.camera) < 0.02, "{}", jump(camera, state.work.camera));
    assert_ne!(state.fine(Quality::High), Quality::Draft.settings());
}

#[test]
fn whoever_has_turned_it_keeps_the_view() {
    let file = File::new("turned.xyz", &bar(COUNT));
    let mut state = waiting(&file, COUNT);
    state.apply(Action::Turn(2, 1));
    state.apply(Action::Zoom(3));
    let camera = state.work.camera;
    settle(&mut state);
    assert!(state.preview.is_none() && !state.work.fitted);
    assert_eq!((state.work.camera.eye, state.work.camera.target), (camera.eye, camera.target));
}

#[test]
fn a_preview_is_none_of_the_work() {
    let file = File::new("none.xyz", &bar(COUNT));
    let mut state = waiting(&file, COUNT);
    assert!(state.work.layers.is_empty() && state.work.scene.pose.is_none() && state.built.drawn.is_empty());
    // Nothing to undo, to pick, to select.
    state.apply(Action::Undo);
    assert!(state.preview.is_some());
    let [width, height] = state.view_px;
    let middle = [width as f32 / 2.0, height as f32 / 2.0];
    assert!(state.built.picker.pick(&state.view(), middle).is_none());
    state.apply(Action::PickAll);
    assert!(state.work.picked.is_empty());
    let session = crate::app::sessions::of_picture(&state);
    assert!(session.files.is_empty());
    settle(&mut state);
    // What is undone is the opening, and it leaves an empty window.
    state.apply(Action::Undo);
    settle(&mut state);
    assert_eq!((state.work.layers.len(), state.scene().sphere_count(), state.work.scene.pose), (0, 0, None));
}

#[test]
fn light_and_background_are_those_that_are_chosen() {
    let file = File::new("light.xyz", &bar(COUNT));
    let mut state = waiting(&file, COUNT);
    let version = state.version;
    state.apply(Action::Look(crate::scene::Look::Dark));
    assert!(state.version > version);
    assert_eq!(state.scene().background, state.work.scene.background);
    state.apply(Action::Ground(false));
    assert!(state.scene().ground.is_none());
    state.apply(Action::Perspective(false));
    state.apply(Action::ResetView);
    state.set_view_px([300, 700]);
    assert!(state.preview.is_some());
}

#[test]
fn giving_up_takes_it_away() {
    let file = File::new("cancel.xyz", &bar(COUNT));
    let mut state = waiting(&file, COUNT);
    state.apply(Action::Turn(2, 1));
    let version = state.version;
    state.apply(Action::Escape);
    assert!(state.preview.is_none() && state.loader.under_way().is_empty() && state.version > version);
    assert_eq!((state.scene().sphere_count(), state.work.fitted), (0, true));
    // One that comes too late is not shown, and neither is the file.
    let late = preview(&state, 1, COUNT);
    state.show_preview(late);
    std::thread::sleep(Duration::from_millis(50));
    settle(&mut state);
    assert!(state.preview.is_none() && state.work.layers.is_empty());
}

#[test]
fn nothing_is_kept_of_a_file_that_was_given_up() {
    let file = File::new("forgotten.xyz", &bar(COUNT));
    for pause in [0, 2, 5, 10, 20, 40, 80] {
        let mut state = state();
        state.apply(Action::Open(file.0.clone()));
        std::thread::sleep(Duration::from_millis(pause));
        state.apply(Action::Cancel);
        // The reader ends with the file, and is the last but these to know what makes scenes: the state, its loader, its builder.
        let maker = state.maker();
        for _ in 0..2000 {
            state.poll();
            if Arc::strong_count(&maker) <= 4 {
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        state.poll();
        assert_eq!((Arc::strong_count(&maker), maker.kept_count()), (4, 0), "{pause}");
    }
}

#[test]
fn giving_up_the_scene_takes_it_away_as_well() {
    let file = File::new("parts.xyz", &bar(COUNT));
    let mut state = waiting(&file, COUNT);
    state.wait_for_files();
    assert!(state.is_building() && state.preview.is_some(), "it stays until the molecule is to be seen");
    state.apply(Action::Cancel);
    assert!(state.preview.is_none());
}

#[test]
fn a_file_that_cannot_be_read_takes_its_preview_with_it() {
    let file = File::new("wrong.xyz", &bar(COUNT).replace("Ar 4.0", "Ar x"));
    let mut state = waiting(&file, COUNT);
    settle(&mut state);
    assert!(state.preview.is_none() && state.work.layers.is_empty() && state.work.fitted);
    assert_eq!(state.notices.iter().filter(|notice| notice.is_error).count(), 1);
}

#[test]
fn a_second_file_has_none_and_whatever_comes_first_is_shown() {
    let file = File::new("first.xyz", &bar(COUNT));
    let mut state = waiting(&file, COUNT);
    assert!(state.preview_options().is_none());
    let small = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/caffeine.sdf");
    state.apply(Action::Open(small));
    let second = state.loader.under_way().last().unwrap().id;
    let other = preview(&state, second, 720);
    let shown = Arc::clone(state.scene());
    state.show_preview(other);
    assert!(Arc::ptr_eq(&shown, state.scene()));
    settle(&mut state);
    assert!(state.preview.is_none());
    assert_eq!((state.work.layers.len(), state.scene().sphere_count()), (2, COUNT + 24));
}

#[test]
fn what_is_open_stays_until_the_next_file_is_there() {
    let mut state = crate::app::state::tests::opened(&["caffeine.sdf"]);
    assert!(state.preview_options().is_none());
    let file = File::new("next.xyz", &bar(COUNT));
    state.apply(Action::Open(file.0.clone()));
    let load = state.loader.under_way()[0].id;
    let next = preview(&state, load, COUNT);
    state.show_preview(next);
    assert!(state.preview.is_none());
    assert_eq!(state.scene().sphere_count(), 24);
    settle(&mut state);
}

#[test]
fn copies_have_no_preview() {
    let mut state = state();
    assert!(state.preview_options().is_some());
    state.apply(Action::Supercell([2, 1, 1]));
    assert!(state.preview_options().is_none());
}

#[test]
fn a_large_file_is_seen_before_it_is_read() {
    // The reader has a second's work.
    let count = 900_000;
    let file = File::new("large.xyz", &bar(count));
    let mut state = state();
    state.apply(Action::Open(file.0.clone()));
    let mut was_seen = false;
    for _ in 0..60_000 {
        state.poll();
        was_seen |= state.preview.is_some();
        if state.loader.under_way().is_empty() && !state.is_building() {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(was_seen && state.preview.is_none());
    assert_eq!(state.scene().sphere_count(), count);
    assert!(state.scene().bounds().size().max_element() > 99_000.0);
    assert!(matches!(&state.work.layers[0].source, Source::File(_)));
}
