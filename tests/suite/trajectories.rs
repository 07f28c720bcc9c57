//! Trajectories: every flavour in `data/trajectories` against the truth beside it, whatever is cut off or changed, and the command line.

use ballstick::import::trajectory::{Input, Trajectory, TrajectoryFormat, inputs, read_input};
use ballstick::import::{ImportOptions, Limits, read_bytes};
use std::collections::BTreeMap;
use std::path::PathBuf;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/trajectories")
}

#[derive(serde::Deserialize)]
struct Truth {
    atoms: usize,
    frames: Vec<TruthFrame>,
}

#[derive(serde::Deserialize)]
struct TruthFrame {
    positions: Vec<[f64; 3]>,
    /// Lengths and angles.
    cell: Option<[f64; 6]>,
    time: Option<f64>,
}

fn truth() -> BTreeMap<String, Truth> {
    let text = std::fs::read(folder().join("truth.json")).unwrap();
    serde_json::from_slice(&text).unwrap()
}

fn check(name: &str, trajectory: &Trajectory, want: &Truth) {
    assert_eq!(trajectory.count_frames(|| true).unwrap(), want.frames.len(), "{name}");
    assert_eq!((trajectory.atom_count(), trajectory.problem()), (want.atoms, None), "{name}");
    // Any order.
    for number in (0..want.frames.len()).rev() {
        let (got, want) = (trajectory.frame(number).unwrap(), &want.frames[number]);
        assert_eq!(got.positions.len(), want.positions.len(), "{name}");
        for (atom, want) in want.positions.iter().enumerate() {
            let away = (got.positions.get(atom) - glam::DVec3::from(*want)).length();
            let scale = want.iter().fold(10.0f64, |most, x| most.max(x.abs()));
            assert!(away < 2e-6 * scale, "{name}, frame {number}, atom {atom}: {away} Å from the truth");
        }
        assert_eq!(got.cell.is_some(), want.cell.is_some(), "{name}");
        if let (Some(cell), Some(want)) = (got.cell, want.cell) {
            let got: Vec<f64> = cell.lengths().into_iter().chain(cell.angles_deg()).collect();
            let is_near = got.iter().zip(want).all(|(got, want)| (got - want).abs() < 2e-4);
            assert!(is_near, "{name}, frame {number}: cell {got:?}, expected {want:?}");
        }
        assert_eq!(got.time_ps.is_some(), want.time.is_some(), "{name}");
        assert_eq!(got.time_ps, trajectory.time_ps(number).unwrap());
        let away = got.time_ps.unwrap_or(0.0) - want.time.unwrap_or(0.0);
        assert!(away.abs() < 1e-4, "{name}, frame {number}: {away} ps from the truth");
    }
    assert!(trajectory.frame(want.frames.len()).is_err());
}

#[test]
fn every_flavour_is_read_as_others_read_it() {
    let truth = truth();
    assert!(truth.len() >= 12, "{} files", truth.len());
    for (name, want) in &truth {
        let path = folder().join(name);
        check(name, &Trajectory::open(&path, &Limits::default()).unwrap(), want);
        // The content decides, not the name.
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(TrajectoryFormat::of(&bytes).unwrap().name(), name.rsplit_once('.').unwrap().1);
        check(name, &Trajectory::of_bytes(bytes, "unnamed", &Limits::default()).unwrap(), want);
    }
}

#[test]
fn what_is_cut_off_keeps_the_frames_before() {
    for (name, want) in &truth() {
        let bytes = std::fs::read(folder().join(name)).unwrap();
        let mut most = 0;
        for end in 0..bytes.len() {
            let Ok(cut) = Trajectory::of_bytes(bytes[..end].to_vec(), name, &Limits::default()) else {
                assert_eq!(most, 0, "{name} of {end} bytes");
                continue;
            };
            let frames = cut.count_frames(|| true).unwrap();
            assert!(frames >= most && frames < want.frames.len() + 1, "{name} of {end} bytes: {frames} frames");
            // Where a frame has just ended nobody can know that there was another.
            let is_clean = frames > most;
            most = frames;
            for frame in 0..frames {
                let got = cut.frame(frame).unwrap();
                let away = got.positions.get(0) - glam::DVec3::from(want.frames[frame].positions[0]);
                assert!(away.length() < 0.1, "{name} of {end} bytes");
            }
            let is_whole = frames == want.frames.len();
            assert!(is_whole || is_clean || cut.problem().is_some() || name.ends_with("trr"), "{name} of {end} bytes");
        }
        // A frame without positions may follow the last one that counts.
        assert!(most + 1 >= want.frames.len(), "{name}: {most}");
    }
}

#[test]
fn no_change_of_a_byte_panics_or_takes_memory() {
    for name in truth().keys() {
        let whole = std::fs::read(folder().join(name)).unwrap();
        for at in 0..whole.len() {
            for change in [0xff, 0x80, 0x01] {
                let mut bytes = whole.clone();
                bytes[at] ^= change;
                let Ok(trajectory) = Trajectory::of_bytes(bytes, name, &Limits::default()) else { continue };
                let frames = trajectory.count_frames(|| true).unwrap();
                assert!(frames <= whole.len(), "{name}");
                for frame in 0..frames.min(3) {
                    if let Ok(frame) = trajectory.frame(frame) {
                        assert_eq!(frame.positions.len(), trajectory.atom_count());
                    }
                }
            }
        }
    }
}

#[test]
fn headers_that_promise_everything_get_nothing() {
    let mut xtc = std::fs::read(folder().join("water.xtc")).unwrap();
    for at in [4, 52] {
        xtc[at..at + 4].copy_from_slice(&199_999_999i32.to_be_bytes());
    }
    assert!(Trajectory::of_bytes(xtc.clone(), "a.xtc", &Limits::default()).is_err());
    let few = Limits { atoms: 1000, ..Limits::default() };
    assert!(Trajectory::of_bytes(xtc, "a.xtc", &few).unwrap_err().to_string().contains("limit `atoms`"));
    let mut dcd = std::fs::read(folder().join("xplor.dcd")).unwrap();
    let count = dcd.len() - 3 * 3 * (12 * 4 + 8) - 8;
    dcd[count..count + 4].copy_from_slice(&i32::MAX.to_le_bytes());
    let all = Limits { atoms: usize::MAX, ..Limits::default() };
    assert!(Trajectory::of_bytes(dcd, "a.dcd", &all).unwrap_err().to_string().contains("no frame"));
}

fn pair(structure: &str, trajectories: &[&str]) -> Input {
    let path = |name: &&str| folder().join(name);
    Input { structure: folder().join(structure), trajectories: trajectories.iter().map(path).collect() }
}

#[test]
fn a_structure_and_trajectories_are_one_molecule_with_their_frames() {
    let document = read_input(&pair("box.gro", &["water.xtc", "fine.xtc"]), &ImportOptions::default()).unwrap();
    document.trajectories[0].count_frames(|| true).unwrap();
    document.trajectories[1].count_frames(|| true).unwrap();
    assert_eq!((document.records.len(), document.frame_count()), (1, 10));
    let (first, last) = (document.at_frame(0).unwrap(), document.at_frame(9).unwrap());
    assert_eq!((last.atom_count(), last.atom_name(0), last.frames().len()), (48, "OW", 1));
    assert!((first.positions().get(0) - document.records[0].positions().get(0)).length() < 0.02);
    assert!(last.positions().get(0) != first.positions().get(0) && last.cell() != first.cell());
    assert_eq!([document.time_ps(1), document.time_ps(6)], [Some(3.5), Some(1.0)]);
    assert!(document.at_frame(10).unwrap_err().to_string().contains("frame 11 is asked for, but there are only 10"));
}

#[test]
fn what_does_not_go_together_is_said_with_names_and_counts() {
    let error = read_input(&pair("box.gro", &["few.xtc"]), &ImportOptions::default()).unwrap_err().to_string();
    for part in ["few.xtc has 9 atoms", "box.gro has 48 atoms"] {
        assert!(error.contains(part), "{error}");
    }
    let error = read_input(&pair("water.xtc", &[]), &ImportOptions::default()).unwrap_err().to_string();
    assert!(error.contains("trajectory (XTC)") && error.contains("ballstick STRUCTURE"), "{error}");
    let bytes = std::fs::read(folder().join("full.trr")).unwrap();
    assert!(read_bytes(&bytes, "", &ImportOptions::default()).unwrap_err().to_string().contains("trajectory (TRR)"));
    let error = read_input(&pair("box.gro", &["truth.json"]), &ImportOptions::default()).unwrap_err().to_string();
    assert!(error.contains("truth.json: this is no trajectory"), "{error}");
}

#[test]
fn files_are_grouped_by_what_they_are() {
    let paths = |names: &[&str]| -> Vec<PathBuf> { names.iter().map(|name| folder().join(name)).collect() };
    let got = inputs(&paths(&["box.gro", "water.xtc", "fine.xtc", "truth.json", "full.trr"]));
    assert_eq!(got, [pair("box.gro", &["water.xtc", "fine.xtc"]), pair("truth.json", &["full.trr"])]);
    let alone = inputs(&paths(&["water.xtc", "namd.dcd"]));
    assert_eq!(alone, [pair("water.xtc", &[]), pair("namd.dcd", &[])]);
    // What is not there is told by its name.
    assert_eq!(inputs(&paths(&["box.gro", "none.xtc"])).len(), 1);
}

/// A folder with a structure and its trajectories.
fn case() -> crate::cli::Case {
    let case = crate::cli::Case::new(&[]);
    for name in ["box.gro", "water.xtc", "few.xtc"] {
        std::fs::copy(folder().join(name), case.path(name)).unwrap();
    }
    case
}

#[test]
fn the_program_knows_a_structure_and_its_trajectory_as_one() {
    let case = case();
    let text = case.run(&["info", "box.gro", "water.xtc"]).status(0).out();
    assert!(text.contains("frames    6") && text.contains("water.xtc: 6 frames, 1 to 13.5 ps"), "{text}");
    let json = case.run(&["info", "--json", "box.gro", "water.xtc", "box.gro"]).status(0).out();
    let lines: Vec<serde_json::Value> = json.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((lines.len(), &lines[0]["frames"], &lines[1]["frames"]), (2, &6.into(), &1.into()));
    let said = &lines[0]["trajectories"][0];
    assert_eq!((&said["format"], &said["last_ps"]), (&"xtc".into(), &13.5.into()));
    assert!(lines[1].get("trajectories").is_none());
    // Cut off in its last frame.
    let bytes = std::fs::read(case.path("water.xtc")).unwrap();
    std::fs::write(case.path("cut.xtc"), &bytes[..bytes.len() - 5]).unwrap();
    let run = case.run(&["info", "box.gro", "cut.xtc"]).status(0);
    assert!(run.out().contains("cut.xtc: 5 frames"));
    assert!(
        run.err().contains("warning: cut.xtc: the file is cut off in frame 6; the 5 before it are there"),
        "{}",
        run.err()
    );
}

#[test]
fn a_frame_of_a_trajectory_is_drawn() {
    let case = case();
    let draw = |frame: &str, more: &[&str], name: &str| {
        let flags =
            ["render", "box.gro", "water.xtc", "-o", name, "--size", "64x48", "--quality", "draft", "--frame", frame];
        case.run(&[&flags[..], more].concat())
    };
    for (frame, name) in [("1", "a.png"), ("6", "b.png")] {
        let run = draw(frame, &[], name).status(0);
        assert_eq!(run.err(), "");
    }
    assert_ne!(std::fs::read(case.path("a.png")).unwrap(), std::fs::read(case.path("b.png")).unwrap());
    let atoms = |more: &[&str]| {
        let timings: serde_json::Value = serde_json::from_str(&draw("6", more, "c.png").status(0).err()).unwrap();
        (timings["atom_count"].clone(), timings["bond_count"].clone())
    };
    assert_eq!(atoms(&["--timings"]), (48.into(), 32.into()));
    assert_eq!(atoms(&["--timings", "--bonds-per-frame", "--cell", "asym"]).0, 48);
    let run = draw("7", &[], "d.png").status(1);
    assert!(run.err().contains("frame 7 is asked for, but there are only 6"), "{}", run.err());
    let run = case.run(&["render", "water.xtc", "-o", "e.png"]).status(1);
    assert!(run.err().contains("ballstick STRUCTURE water.xtc"), "{}", run.err());
    let run = case.run(&["render", "box.gro", "few.xtc", "-o", "e.png"]).status(1);
    assert!(run.err().contains("few.xtc has 9 atoms a frame, but box.gro has 48 atoms"), "{}", run.err());
}

/// Seconds and bytes a second for the files that `BALLSTICK_TRAJECTORIES` names, separated by colons:
/// `cargo test --release trajectories::speed -- --ignored --nocapture`.
#[test]
#[ignore = "measures, and has nothing to fail"]
fn speed() {
    let files = std::env::var("BALLSTICK_TRAJECTORIES").unwrap_or_default();
    for file in files.split(':').filter(|file| !file.is_empty()) {
        let started = std::time::Instant::now();
        let trajectory = Trajectory::open(file.as_ref(), &Limits::default()).unwrap();
        let frames = trajectory.count_frames(|| true).unwrap();
        let counted = started.elapsed().as_secs_f64();
        let started = std::time::Instant::now();
        let atoms: usize = (0..frames).map(|frame| trajectory.frame(frame).unwrap().positions.len()).sum();
        let seconds = started.elapsed().as_secs_f64();
        let megabytes = std::fs::metadata(file).unwrap().len() as f64 * 1e-6;
        println!(
            "{file}: {frames} frames counted in {counted:.4} s, read in {seconds:.3} s, {:.0} MB/s, {:.1} M atoms/s",
            megabytes / seconds,
            atoms as f64 * 1e-6 / seconds
        );
    }
}

/// What a frame costs beside decoding, for the structure and trajectory in `BALLSTICK_PLAY`, separated by a colon.
#[test]
#[ignore = "measures, and has nothing to fail"]
fn moving() {
    use ballstick::crystal::{self, CrystalOptions, Fixed};
    use ballstick::scene::{Item, Rig, Scene, SceneOptions};
    let Ok(files) = std::env::var("BALLSTICK_PLAY") else { return };
    let (structure, trajectory) = files.split_once(':').unwrap();
    let input = Input { structure: structure.into(), trajectories: vec![trajectory.into()] };
    let document = read_input(&input, &ImportOptions::default()).unwrap();
    let options = CrystalOptions::default();
    let fixed = Fixed::new(document.records[0].clone(), &options);
    let first = fixed.draw(document.trajectory_frame(0).unwrap()).unwrap();
    let rig = Rig::new(&[Item::drawn(&first, None)], &SceneOptions::default());
    let pose = Some(rig.scene(&[Item::drawn(&first, None)], &SceneOptions::default()).pose);
    let look = SceneOptions { pose, ..SceneOptions::default() };
    let mut seconds = [0.0; 5];
    let mut time = |which: usize, started: std::time::Instant| seconds[which] += started.elapsed().as_secs_f64();
    const FRAMES: usize = 20;
    for number in 0..FRAMES {
        let now = std::time::Instant::now;
        let started = now();
        let frame = document.trajectory_frame(number).unwrap();
        time(0, started);
        let started = now();
        let drawn = fixed.draw(frame).unwrap();
        time(1, started);
        let items = [Item::drawn(&drawn, None)];
        assert!(rig.fits(&items, &look));
        let started = now();
        let moved = rig.scene(&items, &look);
        time(2, started);
        let started = now();
        let anew = Scene::new(&items, &look);
        time(3, started);
        assert!(moved == anew);
        let structure = document.at_frame(number).unwrap();
        let started = now();
        crystal::draw(structure, &options).unwrap();
        time(4, started);
    }
    let ms = seconds.map(|seconds| format!("{:.2}", seconds * 1e3 / FRAMES as f64));
    println!(
        "ms a frame: decoded {}, put together {}, scene moved {}, scene anew {}, bonds anew {}",
        ms[0], ms[1], ms[2], ms[3], ms[4]
    );
}
