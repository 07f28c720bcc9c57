use super::*;
use crate::app::pictures::Dialog;
use crate::app::selecting::{self, Deed, How};
use crate::color::Srgb8;
use crate::scene::{ColorBy, Look, Style};
use crate::select::Selection;
use std::path::PathBuf;

/// A state without a window.
pub(in crate::app) fn state() -> State {
    State::new(Options::default(), Preferences::default(), Arc::new(|| {}))
}

/// The same with files of `data/`.
pub(in crate::app) fn opened(names: &[&str]) -> State {
    let mut state = state();
    for name in names {
        state.apply(Action::Open(data(name)));
    }
    state.wait_for_files();
    settle(&mut state);
    assert!(state.notices.iter().all(|notice| !notice.is_error), "{:?}", state.notices);
    state
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

/// Waits until nothing is under way.
pub(in crate::app) fn settle(state: &mut State) {
    for _ in 0..2000 {
        state.poll();
        let draws =
            !state.pictures.under_way.is_empty() || !state.films.under_way.is_empty() || state.pictures.is_copying;
        if state.loader.under_way().is_empty() && !state.is_building() && !draws && state.opening.is_none() {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("something never ends");
}

fn key(state: &State, atom: u32) -> AtomKey {
    AtomKey { layer: state.work.layers[0].id, atom }
}

#[test]
fn a_file_opens_fitted_and_closes_to_nothing() {
    let mut state = opened(&["caffeine.sdf"]);
    assert_eq!(state.built.scene.sphere_count(), 24);
    assert!(state.work.fitted && state.work.scene.pose.is_some());
    assert_eq!(state.title(), "caffeine.sdf – ballstick");
    let camera = state.work.camera;
    state.set_view_px([400, 800]);
    assert_ne!(state.work.camera, camera, "a fitted view follows the window");
    state.apply(Action::CloseAll);
    assert_eq!((state.built.scene.sphere_count(), state.title().as_str()), (0, "ballstick"));
}

#[test]
fn files_keep_the_order_in_which_they_were_asked_for() {
    let state = opened(&["1crn.pdb", "caffeine.sdf", "benzene.xyz"]);
    let names: Vec<String> = state.work.layers.iter().map(|layer| layer.source.name()).collect();
    assert_eq!(names, ["1crn.pdb", "caffeine.sdf", "benzene.xyz"]);
}

#[test]
fn what_cannot_be_read_is_said_and_changes_nothing() {
    let mut state = opened(&["caffeine.sdf"]);
    let version = state.version;
    state.apply(Action::Open("/no/such/file.pdb".into()));
    state.wait_for_files();
    assert!(state.notices[0].is_error && state.notices[0].text.contains("/no/such/file.pdb"), "{:?}", state.notices);
    assert_eq!((state.work.layers.len(), state.version), (1, version));
}

#[test]
fn everything_can_be_undone_and_done_again() {
    let mut state = opened(&["caffeine.sdf"]);
    let pick = key(&state, 3);
    let also = key(&state, 5);
    let steps = [
        Action::Style(Style::Licorice),
        Action::ColorBy(ColorBy::Chain),
        Action::Look(Look::Dark),
        Action::Ground(false),
        Action::Hydrogens(false),
        Action::Pick(Some(pick)),
        Action::PickAlso(also),
        Action::Measure,
        Action::Perspective(false),
        Action::Center,
        Action::HydrogenBonds(true),
        Action::ShowLayer(state.work.layers[0].id, false),
        Action::CloseAll,
    ];
    let mut works = vec![state.work.clone()];
    for step in steps {
        state.apply(step.clone());
        assert!(state.work != works[works.len() - 1], "{step:?} changes something");
        works.push(state.work.clone());
    }
    for expected in works.iter().rev().skip(1) {
        state.apply(Action::Undo);
        assert!(state.work == *expected);
    }
    // The first step is the opening itself.
    state.apply(Action::Undo);
    assert!(state.work.layers.is_empty());
    state.apply(Action::Redo);
    for expected in &works[1..] {
        state.apply(Action::Redo);
        assert!(state.work == *expected);
    }
    let before = state.work.clone();
    state.apply(Action::Redo);
    assert!(state.work == before, "there is no more");
}

#[test]
fn a_drag_is_one_step_and_the_scene_is_not_made_anew_for_light() {
    let mut state = opened(&["caffeine.sdf"]);
    let blocks = Arc::clone(&state.built.scene.blocks);
    let start = state.work.clone();
    for _ in 0..10 {
        state.apply(Action::Turn(1, 0));
    }
    state.apply(Action::Look(Look::Soft));
    state.apply(Action::Ground(false));
    assert!(Arc::ptr_eq(&blocks, &state.built.scene.blocks));
    assert_eq!(state.built.scene.lighting, Look::Soft.lighting());
    for _ in 0..3 {
        state.apply(Action::Undo);
    }
    assert!(state.work == start);
    state.apply(Action::Style(Style::Wireframe));
    assert!(!Arc::ptr_eq(&blocks, &state.built.scene.blocks));
}

#[test]
fn what_is_hidden_does_not_move_what_is_shown() {
    let mut state = opened(&["caffeine.sdf", "benzene.xyz"]);
    let center = picking::ball(&state, key(&state, 0)).unwrap().0;
    let other = state.work.layers[1].id;
    state.apply(Action::ShowLayer(other, false));
    assert_eq!(state.built.scene.sphere_count(), 24);
    assert!(picking::ball(&state, key(&state, 0)).unwrap().0.distance(center) < 1e-4);
    assert_eq!(picking::ball(&state, AtomKey { layer: other, atom: 0 }), None);
}

#[test]
fn picks_grow_to_residues_chains_and_all() {
    let mut state = opened(&["1crn.pdb"]);
    state.apply(Action::Pick(Some(key(&state, 0))));
    let mut counts = vec![state.work.picked.len()];
    for _ in 0..2 {
        state.apply(Action::PickMore);
        counts.push(state.work.picked.len());
    }
    assert_eq!(counts, [1, 7, 327], "an atom, the first threonine, the only chain");
    state.apply(Action::Escape);
    assert!(state.work.picked.is_empty());
}

#[test]
fn two_atoms_are_measured_as_in_the_file_and_marked_in_the_scene() {
    let mut state = opened(&["caffeine.sdf"]);
    state.apply(Action::Measure);
    assert!(state.measuring);
    // While measuring plain clicks gather.
    state.apply(Action::Pick(Some(key(&state, 0))));
    state.apply(Action::Pick(Some(key(&state, 1))));
    state.apply(Action::Pick(None));
    let structure = &state.built.drawn[0].1.structure;
    let expected = structure.positions().get(0).distance(structure.positions().get(1));
    assert_eq!(picking::measure(&state, &state.work.picked), Some(format!("{expected:.3} Å")));
    state.apply(Action::Measure);
    assert!(state.measuring && state.work.picked.is_empty());
    assert_eq!(state.work.measurements.len(), 1);
    assert_eq!(state.built.scene.overlay.labels.len(), 1);
    state.apply(Action::ForgetMeasurements);
    assert!(state.built.scene.overlay.labels.is_empty());
}

#[test]
fn what_is_under_a_point_is_told_with_its_bonds() {
    let state = opened(&["1crn.pdb"]);
    let (heading, facts) = picking::about_atom(&state.built.drawn[0].1, 1).unwrap();
    let fact =
        |name: &str| facts.iter().filter(|(n, _)| n == name).map(|(_, value)| value.as_str()).collect::<Vec<_>>();
    assert_eq!(heading, "Carbon C");
    assert_eq!(
        (fact("Name"), fact("Residue"), fact("Chain"), fact("Number")),
        (vec!["CA"], vec!["THR 1"], vec!["A"], vec!["2"])
    );
    assert_eq!(fact("Position"), ["16.967  12.784  4.338 Å"]);
    assert_eq!(fact("Bond").len(), 3);
    assert!(fact("Bond")[0].starts_with("N of THR 1 in chain A: 1.4") && fact("Bond")[0].contains("dictionary"));
}

#[test]
fn an_assembly_is_chosen_picked_in_its_copies_and_undone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dimer.pdb");
    let mut text = "REMARK 350 BIOMOLECULE: 1\nREMARK 350 APPLY THE FOLLOWING TO CHAINS: A\n".to_owned();
    for (number, shift) in [(1, 0.0), (2, 20.0)] {
        for row in 1..=3 {
            let one = |column: i32| if column == row { 1.0 } else { 0.0 };
            let (x, y, z, along) = (one(1), one(2), one(3), if row == 1 { shift } else { 0.0 });
            text += &format!("REMARK 350   BIOMT{row} {number:>3}{x:>10.6}{y:>10.6}{z:>10.6}{along:>15.5}\n");
        }
    }
    for (serial, name, x) in [(1, "N  ", 0.0), (2, "CA ", 1.45), (3, "C  ", 2.9)] {
        let element = &name[..1];
        text += &format!(
            "ATOM  {serial:>5}  {name} GLY A   1    {x:>8.3}   0.000   0.000  1.00  0.00          {element:>2}\n"
        );
    }
    std::fs::write(&path, text + "END\n").unwrap();
    let mut state = state();
    state.apply(Action::Open(path));
    state.wait_for_files();
    settle(&mut state);
    assert_eq!((state.built.scene.sphere_count(), state.built.scene.placements.len()), (3, 1));
    assert_eq!(crate::app::assemblies::known(&state).len(), 2);
    let id = crate::crystal::AssemblyId::new("1");
    state.apply(Action::Assembly(id));
    settle(&mut state);
    assert_eq!((state.built.scene.sphere_count(), state.built.scene.placements.len()), (6, 2));
    // The second atom of the second copy, and with it its residue there.
    let there = key(&state, 4);
    let scene_id = picking::id_of(&state, there).unwrap();
    assert_eq!(picking::target(&state, scene_id), Some(picking::Target::Atom(there)));
    state.apply(Action::Pick(Some(there)));
    assert_eq!(picking::name_of(&state, there).as_deref(), Some("CA of GLY 1 in chain A, copy 2"));
    assert_eq!(picking::measure(&state, &[key(&state, 1), there]).as_deref(), Some("20.000 Å"));
    state.apply(Action::PickMore);
    assert_eq!(state.work.picked.iter().map(|key| key.atom).collect::<Vec<_>>(), [3, 4, 5]);
    assert!(crate::app::sessions::command_line(&state).unwrap().contains(" --assembly 1 "));
    // Without the assembly there is no such atom.
    state.apply(Action::Assembly(None));
    settle(&mut state);
    assert_eq!((state.built.scene.sphere_count(), state.work.picked.len()), (3, 0));
}

#[test]
fn frames_step_play_and_stop_at_the_end() {
    let mut state = opened(&["ethane-rotation.xyz"]);
    let count = state.work.frame_count();
    assert!(count > 2);
    let frame = |state: &State| state.work.layers[0].frame;
    state.apply(Action::Step(-1));
    assert_eq!(frame(&state), count - 1, "in a loop");
    state.apply(Action::AtEnd(AtEnd::Stop));
    state.apply(Action::Step(1));
    assert_eq!(frame(&state), count - 1);
    state.apply(Action::FirstFrame);
    state.apply(Action::Play(true));
    let mut now = Instant::now();
    for _ in 0..count + 2 {
        state.play(now);
        now += Duration::from_secs(1);
    }
    assert_eq!((frame(&state), state.playing.on), (count - 1, false));
}

#[test]
fn frames_go_back_the_way_they_came() {
    let mut state = opened(&["ethane-rotation.xyz"]);
    let count = state.work.frame_count();
    state.apply(Action::AtEnd(AtEnd::Bounce));
    state.apply(Action::Play(true));
    let mut now = Instant::now();
    let mut seen = vec![0];
    for _ in 0..2 * count {
        state.play(now);
        now += Duration::from_secs(1);
        seen.push(state.work.layers[0].frame);
    }
    assert_eq!(seen[..count], (0..count).collect::<Vec<_>>());
    assert_eq!(seen[count..2 * count - 1], (0..count - 1).rev().collect::<Vec<_>>());
    assert!(seen.windows(2).all(|pair| pair[0].abs_diff(pair[1]) == 1) && state.playing.on, "{seen:?}");
}

fn boxed(trajectories: &[&str]) -> Action {
    let path = |name: &&str| data("trajectories").join(name);
    let trajectories = trajectories.iter().map(path).collect();
    Action::OpenInput(crate::import::trajectory::Input { structure: path(&"box.gro"), trajectories })
}

#[test]
fn a_trajectory_plays_with_the_bonds_of_its_structure() {
    let mut state = self::state();
    state.apply(boxed(&["water.xtc"]));
    state.wait_for_files();
    settle(&mut state);
    assert!(state.notices.is_empty(), "{:?}", state.notices);
    assert_eq!(state.title(), "box.gro + water.xtc – ballstick");
    let started = Instant::now();
    while state.work.frame_count() < 6 {
        assert!(started.elapsed() < Duration::from_secs(20), "the frames are counted by and by");
        std::thread::sleep(Duration::from_millis(2));
    }
    let bonds = |state: &State| state.built.drawn[0].1.structure.bonds().to_vec();
    let (first, id) = (bonds(&state), state.work.layers[0].id);
    // Fifteen waters and carbon dioxide, all whole.
    assert_eq!(first.len(), 32);
    for frame in [3, 5, 0, 1] {
        state.apply(Action::Frame(id, frame));
        settle(&mut state);
        let structure = &state.built.drawn[0].1.structure;
        let at = |atom: u32| structure.positions().get(atom as usize);
        assert!(structure.bonds().iter().all(|bond| at(bond.a).distance(at(bond.b)) < 1.4), "frame {frame}");
        assert_eq!(bonds(&state), first);
        assert_eq!(structure.frames()[0].time_ps, Some(2.5 * frame as f64 + 1.0));
        // As if it had been made for this frame alone.
        let items: Vec<_> = state.built.drawn.iter().map(|(_, drawn)| crate::scene::Item::drawn(drawn, None)).collect();
        let anew = crate::scene::Scene::new(&items, &state.work.scene);
        assert!(anew.blocks == state.built.scene.blocks && anew.placements == state.built.scene.placements);
    }
    state.apply(Action::BondsPerFrame(crate::crystal::BondsPerFrame::Always));
    settle(&mut state);
    assert_eq!(state.built.drawn[0].1.kind, 0);
}

#[test]
fn a_trajectory_that_is_dropped_moves_what_was_opened_last() {
    let mut state = opened(&["trajectories/box.gro"]);
    state.apply(Action::Open(data("trajectories/water.xtc")));
    state.wait_for_files();
    settle(&mut state);
    assert_eq!((state.work.layers.len(), state.work.layers[0].document.trajectories.len()), (1, 1));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.json");
    state.apply(Action::Frame(state.work.layers[0].id, 4));
    state.apply(Action::SaveSession(path.clone()));
    let mut other = self::state();
    other.apply(Action::Open(path));
    other.wait_for_files();
    settle(&mut other);
    assert_eq!((other.work.layers[0].frame, &other.work.layers[0].source), (4, &state.work.layers[0].source));
    // One of other atoms changes nothing and says why.
    other.apply(Action::Open(data("trajectories/few.xtc")));
    other.wait_for_files();
    assert!(other.notices[0].text.contains("few.xtc has 9 atoms"), "{:?}", other.notices);
    assert_eq!(other.work.layers[0].source, state.work.layers[0].source);
    let mut alone = self::state();
    alone.apply(Action::Open(data("trajectories/few.xtc")));
    alone.wait_for_files();
    assert!(alone.notices[0].is_error && alone.notices[0].text.contains("give the structure before it"));
}

#[test]
fn a_session_brings_all_back_in_another_window() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.ballstick.json");
    let mut state = opened(&["1crn.pdb", "ethane-rotation.xyz"]);
    let ethane = state.work.layers[1].id;
    state.apply(Action::Frame(ethane, 4));
    state.apply(Action::Style(Style::Licorice));
    state.apply(Action::Pick(Some(key(&state, 10))));
    state.apply(Action::PickAlso(key(&state, 20)));
    state.apply(Action::Measure);
    state.apply(Action::Pick(Some(AtomKey { layer: ethane, atom: 2 })));
    state.apply(Action::Turn(3, 1));
    state.apply(Action::SaveSession(path.clone()));
    assert_eq!(state.notices.last().map(|notice| notice.is_error), Some(false));

    let mut other = self::state();
    other.apply(Action::Open(path));
    other.wait_for_files();
    settle(&mut other);
    assert!(other.notices.is_empty(), "{:?}", other.notices);
    assert_eq!(other.built.scene.overlay.labels, state.built.scene.overlay.labels);
    assert_eq!((other.work.layers[1].frame, other.work.scene.style), (4, Style::Licorice));
    assert_eq!((other.work.picked.len(), other.work.picked[0].atom), (1, 2));
    let (a, b) = (other.work.camera, state.work.camera);
    assert!(a.eye.distance(b.eye) < 1e-3 && a.world_from_view.abs_diff_eq(b.world_from_view, 1e-6));
    assert!(!other.work.fitted);
    other.apply(Action::Undo);
    assert!(other.work.layers.is_empty(), "opening a session is a step");
}

#[test]
fn a_session_whose_file_is_gone_leaves_everything_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let (file, path) = (folder.path().join("a.xyz"), folder.path().join("s.json"));
    std::fs::write(&file, "1\n\nO 0 0 0\n").unwrap();
    let mut state = self::state();
    state.apply(Action::Open(file.clone()));
    state.wait_for_files();
    state.apply(Action::SaveSession(path.clone()));
    std::fs::remove_file(file).unwrap();
    let mut state = opened(&["caffeine.sdf"]);
    state.apply(Action::Open(path));
    state.wait_for_files();
    settle(&mut state);
    assert_eq!(state.built.scene.sphere_count(), 24);
    let texts: Vec<&str> = state.notices.iter().map(|notice| notice.text.as_str()).collect();
    assert!(texts.iter().any(|text| text.contains("a.xyz")) && texts.iter().any(|text| text.contains("not opened")));
}

#[test]
fn a_file_that_changed_is_read_again_in_the_same_view() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.xyz");
    std::fs::write(&file, "2\n\nO 0 0 0\nO 3 0 0\n").unwrap();
    let mut state = self::state();
    state.apply(Action::Open(file.clone()));
    state.wait_for_files();
    state.apply(Action::Turn(2, 0));
    let camera = state.work.camera;
    std::fs::write(&file, "3\n\nO 0 0 0\nO 3 0 0\nO 0 3 0\n").unwrap();
    state.apply(Action::Reload);
    state.wait_for_files();
    assert_eq!((state.built.scene.sphere_count(), state.work.layers.len()), (3, 1));
    assert_eq!((state.work.camera.eye, state.work.camera.target), (camera.eye, camera.target));
}

#[test]
fn pictures_are_saved_as_they_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.png");
    let mut state = opened(&["benzene.xyz"]);
    state.set_view_px([96, 64]);
    let dialog = Dialog {
        path: path.display().to_string(),
        transparent: true,
        quality: crate::render::Quality::Draft,
        ..Dialog::new(&state)
    };
    assert_eq!((dialog.width, dialog.height), (96, 64));
    pictures::save(&mut state, &dialog);
    settle(&mut state);
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (96, 64, png::ColorType::Rgba));
    for (name, what) in [("p.txt", "png"), ("p.jpg", "transparent")] {
        state.notices.clear();
        pictures::save(&mut state, &Dialog { path: folder.path().join(name).display().to_string(), ..dialog.clone() });
        settle(&mut state);
        assert!(state.notices[0].is_error && state.notices[0].text.contains(what), "{:?}", state.notices);
    }
}

#[test]
fn a_session_keeps_samples_and_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, path) = (folder.path().join("m.obj"), folder.path().join("s.json"));
    std::fs::write(&mesh, "v 0 0 0\nv 3 0 0\nv 0 3 0\nf 1 2 3\n").unwrap();
    let read = crate::import::mesh::read_path(&mesh, &Default::default()).unwrap().0;
    let mut options = Options { overlay: vec![mesh.clone()], ..Options::default() };
    (options.scene.overlay, options.scene.overlay_opacity) = (vec![Arc::new(read)], Some(0.5));
    let mut state = State::new(options, Preferences::default(), Arc::new(|| {}));
    state.apply(Action::Open("sample:ferrocene".into()));
    state.wait_for_files();
    state.apply(Action::SaveSession(path.clone()));
    assert!(sessions::command_line(&state).unwrap().contains("render sample:ferrocene -o picture.png"));
    let mut other = self::state();
    other.apply(Action::Open(path.clone()));
    other.wait_for_files();
    settle(&mut other);
    assert!(other.notices.is_empty(), "{:?}", other.notices);
    assert_eq!(other.work.layers[0].source, state.work.layers[0].source);
    assert_eq!((&other.work.overlay, other.work.scene.overlay_opacity), (&state.work.overlay, Some(0.5)));
    assert_eq!(other.built.scene.bounds(), state.built.scene.bounds());
    std::fs::remove_file(mesh).unwrap();
    let mut none = self::state();
    none.apply(Action::Open(path));
    none.wait_for_files();
    settle(&mut none);
    assert!(none.work.layers.is_empty() && none.notices.iter().any(|notice| notice.text.contains("m.obj")));
}

#[test]
fn the_picture_for_the_clipboard_is_the_finished_one_of_the_view() {
    let mut state = opened(&["benzene.xyz"]);
    state.set_view_px([64, 48]);
    state.apply(Action::CopyPicture);
    settle(&mut state);
    let Some(Request::CopyImage(image)) = state.requests.pop() else { panic!("no picture") };
    let mut renderer = crate::render::select(crate::render::Choice::Auto).unwrap().renderer;
    renderer.load(Arc::clone(&state.built.scene)).unwrap();
    assert!(image == renderer.image(&state.view(), &state.fine(state.work.quality)).unwrap());
}

#[test]
fn the_command_line_draws_the_same_view() {
    let mut state = opened(&["caffeine.sdf"]);
    state.set_view_px([300, 200]);
    let fitted = sessions::command_line(&state).unwrap();
    assert!(fitted.contains(" --camera "), "the pose may have been kept from before: {fitted}");
    state.apply(Action::Turn(1, 1));
    state.apply(Action::Measuring(true));
    state.apply(Action::Pick(Some(key(&state, 0))));
    state.apply(Action::Pick(Some(key(&state, 4))));
    state.apply(Action::Measure);
    let line = sessions::command_line(&state).unwrap();
    assert!(line.contains("caffeine.sdf -o picture.png --size 300x200 --measure 1,5 --camera "), "{line}");
}

/// The atoms that are drawn, by their numbers from 1.
fn drawn(state: &State) -> Vec<u32> {
    state.built.scene.blocks[0].spheres.iter().map(|ball| ball.id).collect()
}

fn picked(state: &State) -> Vec<u32> {
    state.work.picked.iter().map(|key| key.atom + 1).collect()
}

fn words(text: &str) -> Action {
    Action::Choose(How::Words(text.to_owned()))
}

#[test]
fn selecting_by_words_inverts_grows_and_is_undone() {
    let mut state = opened(&["caffeine.sdf"]);
    state.apply(words("element O"));
    let oxygens = picked(&state);
    assert_eq!(oxygens.len(), 2);
    state.apply(Action::Choose(How::Grow));
    assert_eq!(picked(&state).len(), 4, "each has one neighbour");
    state.apply(Action::Undo);
    state.apply(Action::Choose(How::Invert));
    assert_eq!(picked(&state).len(), 22);
    state.apply(Action::Choose(How::Invert));
    assert_eq!(picked(&state), oxygens);
    // Of atoms that were clicked, too.
    state.apply(Action::Pick(Some(key(&state, 3))));
    state.apply(Action::Choose(How::Invert));
    assert!(picked(&state).len() == 23 && !picked(&state).contains(&4));
    state.apply(words("chian A"));
    assert!(state.notices.iter().any(|notice| notice.is_error && notice.text.contains("did you mean `chain`?")));
    assert_eq!(picked(&state).len(), 23, "nothing changes then");
}

#[test]
fn what_is_selected_is_hidden_shown_alone_coloured_and_styled() {
    let mut state = opened(&["caffeine.sdf"]);
    let all = drawn(&state).len();
    state.apply(Action::OnPicked(Deed::Hide));
    assert!(state.notices[0].text.contains("Nothing is selected"));
    state.apply(words("hydrogen"));
    state.apply(Action::OnPicked(Deed::Hide));
    assert_eq!(drawn(&state).len(), all - 10);
    state.apply(words("element N"));
    let red = Srgb8::rgb(255, 0, 0);
    state.apply(Action::OnPicked(Deed::Color(Srgb8::WHITE)));
    state.apply(Action::OnPicked(Deed::Color(red)));
    assert_eq!(state.work.scene.by_selection.colors.len(), 1, "a new colour takes the old one's place");
    state.apply(Action::OnPicked(Deed::ShowOnly));
    assert!(drawn(&state).len() == 4 && state.built.scene.blocks[0].spheres.iter().all(|ball| ball.color == red));
    state.apply(Action::OnPicked(Deed::ShowAll));
    assert_eq!(drawn(&state).len(), all);
    state.apply(Action::OnPicked(Deed::Style(Style::SpaceFilling)));
    let largest =
        |state: &State| state.built.scene.blocks[0].spheres.iter().map(|ball| ball.radius).fold(0.0, f32::max);
    assert!(largest(&state) > 1.5);
    state.apply(Action::OnPicked(Deed::Label));
    assert_eq!(state.built.scene.overlay.labels.len(), 4);
    state.apply(Action::OnPicked(Deed::Forget("style", 0)));
    assert!(largest(&state) < 1.0);
    state.apply(Action::OnPicked(Deed::ForgetAll));
    assert_eq!(state.work.scene.by_selection, Default::default());
    state.apply(Action::Undo);
    assert_eq!(state.work.scene.by_selection.colors, [(Selection::parse("element N").unwrap(), red)]);
}

#[test]
fn what_is_hidden_by_clicks_goes_by_number_into_sessions_and_command_lines() {
    let mut state = opened(&["caffeine.sdf", "benzene.xyz"]);
    let second = state.work.layers[1].id;
    state.apply(Action::Choose(How::These((0..3).chain([5]).map(|atom| AtomKey { layer: second, atom }).collect())));
    state.apply(Action::OnPicked(Deed::Hide));
    assert_eq!(state.built.scene.blocks[1].spheres.len(), 8);
    assert!(sessions::command_line(&state).unwrap().contains(" --hide 'file 2 and index 1-3,6' "));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.json");
    state.apply(Action::SaveSession(path.clone()));
    let first = state.work.layers[0].id;
    state.apply(Action::ShowLayer(first, false));
    assert!(sessions::command_line(&state).unwrap().contains(" --hide 'file 1 and index 1-3,6' "));
    state.apply(Action::Close(first));
    assert_eq!(state.work.scene.by_selection.hide[0].text(), "file 1 and index 1-3,6");
    assert_eq!(state.built.scene.blocks[0].spheres.len(), 8);
    state.apply(Action::Close(second));
    assert!(state.work.scene.by_selection.hide.is_empty(), "it goes with its file");
    let mut other = super::tests::state();
    other.apply(Action::Open(path));
    other.wait_for_files();
    settle(&mut other);
    assert_eq!(other.built.scene.blocks[1].spheres.len(), 8, "{:?}", other.notices);
}

#[test]
fn words_that_find_nothing_are_said_once() {
    let mut state = state();
    state.work.scene.by_selection.hide = vec![Selection::parse("chain Q").unwrap()];
    state.apply(Action::Open(data("caffeine.sdf")));
    state.wait_for_files();
    settle(&mut state);
    let says = |state: &State| state.notices.iter().filter(|notice| notice.text.contains("--hide chain Q")).count();
    assert_eq!(says(&state), 1);
    state.notices.clear();
    state.apply(Action::Style(Style::Licorice));
    assert_eq!(says(&state), 0);
}

#[test]
fn a_rectangle_over_everything_has_all_atoms() {
    let mut state = opened(&["caffeine.sdf"]);
    state.set_view_px([400, 300]);
    assert_eq!(selecting::in_rectangle(&state, [[0.0, 0.0], [400.0, 300.0]]).len(), 24);
    let left = selecting::in_rectangle(&state, [[0.0, 0.0], [200.0, 300.0]]).len();
    let right = selecting::in_rectangle(&state, [[200.0, 0.0], [400.0, 300.0]]).len();
    assert!(left > 4 && right > 4 && left + right == 24, "{left} {right}");
}

#[test]
fn escape_leaves_one_thing_at_a_time() {
    let mut state = opened(&["caffeine.sdf"]);
    state.apply(Action::Pick(Some(key(&state, 0))));
    state.apply(Action::Palette(true));
    state.apply(Action::Escape);
    assert!(!state.shown.palette && !state.work.picked.is_empty());
    state.apply(Action::Escape);
    assert!(state.work.picked.is_empty());
    state.apply(Action::Measure);
    state.apply(Action::Escape);
    assert!(!state.measuring);
}

#[test]
fn closed_molecules_do_not_heap_up() {
    let mut state = state();
    let mut documents = Vec::new();
    for _ in 0..100 {
        state.apply(Action::Open(data("caffeine.sdf")));
        state.wait_for_files();
        settle(&mut state);
        documents.push(Arc::downgrade(&state.work.layers[0].document));
        state.apply(Action::CloseAll);
    }
    settle(&mut state);
    let living = documents.iter().filter(|document| document.strong_count() > 0).count();
    assert!((2..=12).contains(&living), "{living}");
    state.apply(Action::Undo);
    assert_eq!(state.work.layers.len(), 1, "the last one comes back");
}
