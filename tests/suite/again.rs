//! Pictures made again from what they say of themselves, sessions, and films, as a user makes them.

use crate::cli::{Case, METHANE, WATER};
use std::fs;

const TETRAHEDRON: &str =
    "v 0 0 1.5\nv 1.4 0 -0.5\nv -0.7 1.2 -0.5\nv -0.7 -1.2 -0.5\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n";
const FRAMES: &str = "2\n\nO 0 0 0\nH 1 0 0\n2\n\nO 0 0 0\nH 0 1 0\n2\n\nO 0 0 0\nH 0 0 1\n";

/// Draws with these flags, then again from the picture alone, and compares the files byte for byte.
fn is_made_again(case: &Case, extension: &str, files: &[&str], flags: &[&str]) {
    let first = format!("first.{extension}");
    let again = format!("again.{extension}");
    let line = [&["render"][..], files, &["-o", &first, "--renderer", "cpu"], flags].concat();
    case.run(&line).status(0);
    case.run(&["render", "--from", &first, "-o", &again]).status(0);
    assert!(fs::read(case.path(&first)).unwrap() == fs::read(case.path(&again)).unwrap(), "{flags:?}");
}

#[test]
fn a_picture_is_made_again_to_the_last_byte() {
    let case =
        Case::new(&[("water.xyz", WATER), ("methane.xyz", METHANE), ("frames.xyz", FRAMES), ("t.obj", TETRAHEDRON)]);
    fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/data/quartz.cif"), case.path("quartz.cif")).unwrap();
    let many = [
        "--size=61x47",
        "--dpi=144",
        "--region=3,5,50,37",
        "--samples=3",
        "--ao=7",
        "--style=licorice",
        "--color-by=chain",
        "--look=illustrative",
        "--outline=1.2345",
        "--outline-color=navy",
        "--fog=0.37",
        "--light=world",
        "--depth-of-field=11.7",
        "--focus=0.61",
        "--background=transparent",
        "--view=1,2,-3",
        "--label=element,index",
        "--label-size=2.3",
        "--legend",
        "--scale-bar",
        "--axes",
        "--measure=1,2",
        "--measure=2:1,1:1,2:2",
        "--overlay=t.obj",
        "--overlay-opacity=0.4",
        "--overlay-color=teal",
        "--hbonds",
        "--aromatic=kekule",
        "--altloc=all",
    ];
    is_made_again(&case, "png", &["water.xyz", "methane.xyz"], &many);
    let small = |flags: &[&'static str]| [&["--size=48x36", "--quality=draft"][..], flags].concat();
    is_made_again(&case, "png", &["frames.xyz"], &small(&["--frame=2", "--no-ground", "--projection=orthographic"]));
    is_made_again(&case, "png", &["frames.xyz"], &small(&["--record=all", "--bonds=perceive"]));
    let selections = ["--hide=index 1", "--style=element O=space-filling", "--color=element H=teal", "--no-ions"];
    is_made_again(&case, "png", &["water.xyz"], &small(&selections));
    is_made_again(&case, "jpg", &["sample:caffeine"], &small(&["--no-hydrogens", "--crop=auto,2"]));
    is_made_again(&case, "png", &["quartz.cif"], &small(&["--axis=111", "--supercell=2x1x1", "--no-cell-box"]));
    is_made_again(&case, "png", &["water.xyz"], &small(&["--channel=depth"]));
    is_made_again(&case, "png", &["water.xyz"], &["--size=8mmx6mm", "--dpi=100", "--look=dark", "--quality=draft"]);
    is_made_again(&case, "apng", &["water.xyz"], &small(&["--turntable=3", "--fps=10"]));
    is_made_again(&case, "apng", &["frames.xyz"], &small(&["--frames=1-3:2"]));
}

#[test]
fn other_flags_count_and_a_fitted_view_follows_them() {
    let case = Case::new(&[("water.xyz", WATER)]);
    let draw = |line: &str| case.run(&line.split(' ').collect::<Vec<_>>()).status(0);
    let same = |a: &str, b: &str| fs::read(case.path(a)).unwrap() == fs::read(case.path(b)).unwrap();
    draw("render water.xyz -o a.png --renderer cpu --size 40x30 --style licorice --quality draft --look dark");
    draw(
        "render --from a.png -o b.png --size 30x40 --style=wireframe --look studio --quality standard --samples 2 --view top",
    );
    draw(
        "render water.xyz -o c.png --renderer cpu --size 30x40 --style wireframe --quality standard --samples 2 --view top",
    );
    assert!(same("b.png", "c.png"));
    // Twice as large is the same view; another shape is fitted anew.
    for size in ["80x60", "60x80"] {
        draw(&format!("render --from a.png -o b.png --size {size}"));
        draw(&format!(
            "render water.xyz -o c.png --renderer cpu --size {size} --style licorice --quality draft --look dark"
        ));
        assert!(same("b.png", "c.png"), "{size}");
    }
    draw("render --from a.png -o b.png --projection orthographic --no-ground");
    draw(
        "render water.xyz -o c.png --renderer cpu --size 40x30 --style licorice --quality draft --look dark --projection orthographic --no-ground",
    );
    assert!(same("b.png", "c.png"));
}

#[test]
fn a_changed_file_is_an_error_and_a_moved_one_can_be_named() {
    let case = Case::new(&[("water.xyz", WATER)]);
    fs::create_dir(case.path("out")).unwrap();
    case.run(&["render", "water.xyz", "-o", "out/a.png", "--size=20x20", "--quality=draft"]).status(0);
    let again = ["render", "--from", "out/a.png", "-o", "b.png"];
    case.run(&again).status(0);
    let picture = fs::read(case.path("b.png")).unwrap();
    fs::write(case.path("water.xyz"), METHANE).unwrap();
    let sum = |text: &str| ballstick::session::sums::of_bytes(text.as_bytes());
    let error = case.run(&again).status(1).err();
    assert!(error.contains(&sum(WATER)) && error.contains(&sum(METHANE)) && error.contains("water.xyz"), "{error}");
    assert_eq!(fs::read(case.path("b.png")).unwrap(), picture, "nothing is written");
    let note = case.run(&["render", "water.xyz", "--from", "out/a.png", "-o", "b.png"]).status(0).err();
    assert!(note.contains("another file"), "{note}");
    fs::remove_file(case.path("water.xyz")).unwrap();
    let error = case.run(&again).status(1).err();
    assert!(error.contains("NEW/PLACE/water.xyz --from out/a.png"), "{error}");
    // Beside the picture it is found by its name and its sum, and nothing else is.
    fs::write(case.path("out/water.xyz"), METHANE).unwrap();
    case.run(&again).status(1);
    fs::write(case.path("out/water.xyz"), WATER).unwrap();
    fs::remove_file(case.path("b.png")).unwrap();
    case.run(&again).status(0);
    fs::create_dir(case.path("elsewhere")).unwrap();
    fs::rename(case.path("out/water.xyz"), case.path("elsewhere/w.xyz")).unwrap();
    assert_eq!(case.run(&["render", "elsewhere/w.xyz", "--from=out/a.png", "-o", "b.png"]).status(0).err(), "");
    for (name, says) in [("none.png", "none.png"), ("elsewhere/w.xyz", "no session")] {
        let error = case.run(&["render", "--from", name, "-o", "c.png"]).status(1).err();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn a_session_is_drawn_like_its_picture() {
    let case = Case::new(&[("water.xyz", WATER), ("frames.xyz", FRAMES), ("t.obj", TETRAHEDRON)]);
    let flags = ["--size=40x30", "--quality=draft", "--overlay=t.obj", "--renderer=cpu"];
    case.run(&[&["render", "water.xyz", "frames.xyz", "-o", "a.png"][..], &flags].concat()).status(0);
    // The session of the picture in a file of its own, with frames that no one flag can say.
    let mut session = ballstick::session::Session::read(&case.path("a.png")).unwrap();
    (session.picture, session.camera) = (None, None);
    session.files[1].frame = 3;
    session.write(&case.path("s.json")).unwrap();
    let size = ["--size=40x30", "--renderer=cpu"];
    case.run(&[&["render", "s.json", "-o", "b.png"][..], &size].concat()).status(0);
    case.run(&[&["render", "--from", "s.json", "-o", "c.png"][..], &size].concat()).status(0);
    let read = |name: &str| fs::read(case.path(name)).unwrap();
    assert!(read("b.png") == read("c.png") && read("b.png") != read("a.png"));
    session.files[1].frame = 1;
    session.write(&case.path("s.json")).unwrap();
    case.run(&[&["render", "s.json", "-o", "b.png"][..], &size].concat()).status(0);
    assert!(read("b.png") == read("a.png"));
    let error = case.run(&["render", "s.json", "water.xyz", "-o", "d.png"]).status(1).err();
    assert!(error.contains("session"), "{error}");
}

#[test]
fn samples_are_named_like_files_in_every_command() {
    let case = Case::new(&[]);
    let info = case.run(&["info", "sample:caffeine"]).status(0);
    assert!(info.out().contains("C8H10N4O2"), "{}", info.out());
    for output in ["a.json", "a.glb"] {
        case.run(&["convert", "sample:caffeine", output]).status(0);
    }
    case.run(&["render", "sample:caffeine", "-o", "a.png", "--size=16x12", "--quality=draft"]).status(0);
    assert_eq!(case.names(""), ["a.glb", "a.json", "a.png"]);
}

#[test]
fn a_session_becomes_the_mesh_of_what_it_shows() {
    let case = Case::new(&[("water.xyz", WATER), ("frames.xyz", FRAMES)]);
    let flags = ["--style=licorice", "--hide=index 3", "--color=element O=teal"];
    case.run(
        &[&["render", "water.xyz", "frames.xyz", "-o", "a.png", "--size=40x30", "--quality=draft"][..], &flags]
            .concat(),
    )
    .status(0);
    let mut session = ballstick::session::Session::read(&case.path("a.png")).unwrap();
    let read = |name: &str| fs::read(case.path(name)).unwrap();
    for format in ["glb", "obj", "ply"] {
        let [picture, plain] = ["picture", "plain"].map(|name| format!("{name}.{format}"));
        case.run(&["convert", "a.png", &picture]).status(0);
        case.run(&[&["convert", "water.xyz", "frames.xyz", "-o", &plain][..], &flags].concat()).status(0);
        let text = |name: &str| String::from_utf8_lossy(&read(name)).replace("picture.mtl", "plain.mtl");
        assert!(text(&picture) == text(&plain), "{format}");
    }
    // Frames that no one flag can say, a flag that counts more than the session, and the camera.
    session.files[1].frame = 3;
    session.write(&case.path("s.json")).unwrap();
    case.run(&["convert", "s.json", "-o", "third.ply"]).status(0);
    assert!(read("third.ply") != read("plain.ply"));
    case.run(&["convert", "s.json", "-o", "first.ply", "--frame=1"]).status(0);
    assert!(read("first.ply") == read("plain.ply"));
    case.run(&["convert", "a.png", "seen.ply", "--coordinates=picture"]).status(0);
    let camera = session.camera.clone().unwrap();
    let line = ["convert", "water.xyz", "frames.xyz", "-o", "asked.ply", "--coordinates=picture", "--camera", &camera];
    case.run(&[&line[..], &flags].concat()).status(0);
    assert!(read("seen.ply") == read("asked.ply"));
    let error = case.run(&["convert", "s.json", "x.cif"]).status(1).err();
    assert!(error.contains("s.json"), "{error}");
    // What is advised can be done.
    fs::write(case.path("water.xyz"), WATER.replace("0.117", "0.118")).unwrap();
    let error = case.run(&["convert", "a.png", "x.glb"]).status(1).err();
    assert!(error.contains("render water.xyz --from a.png -o NEW.png"), "{error}");
    assert!(error.contains("ballstick convert NEW.png -o OUT"), "{error}");
    fs::remove_file(case.path("water.xyz")).unwrap();
    assert!(case.run(&["convert", "s.json", "x.glb"]).status(1).err().contains("water.xyz"));
}

#[test]
fn films_show_turns_and_frames_and_say_what_they_cannot() {
    let case = Case::new(&[("water.xyz", WATER), ("frames.xyz", FRAMES)]);
    let small = ["--size=32x24", "--quality=draft"];
    let gif_frames = |name: &str| {
        let file = fs::File::open(case.path(name)).unwrap();
        let mut decoder = gif::DecodeOptions::new().read_info(file).unwrap();
        let mut count = 0;
        while decoder.read_next_frame().unwrap().is_some() {
            count += 1;
        }
        count
    };
    case.run(&[&["render", "water.xyz", "-o", "turn.gif", "--turntable=5"][..], &small].concat()).status(0);
    case.run(&[&["render", "frames.xyz", "-o", "play.gif", "--fps=10"][..], &small].concat()).status(0);
    case.run(&[&["render", "frames.xyz", "-o", "some.gif", "--frames=2-"][..], &small].concat()).status(0);
    case.run(&[&["render", "frames.xyz", "water.xyz", "-o", "out/", "--to=gif", "--turntable=2"][..], &small].concat())
        .status(0);
    assert_eq!((gif_frames("turn.gif"), gif_frames("play.gif"), gif_frames("some.gif")), (5, 3, 2));
    assert_eq!(case.names("out"), ["frames.gif", "water.gif"]);
    for (flags, says, status) in [
        (&["-o", "a.jpg", "--turntable"][..], ".gif", 2),
        (&["-o", "a.png", "--fps=5"], "films", 2),
        (&["-o", "a.gif", "--crop=auto"], "--region", 2),
        (&["-o", "a.gif", "--channel=depth"], "--channel", 2),
        (&["-o", "a.gif", "--frames=2-9"], "only 3 frames", 1),
    ] {
        let error = case.run(&[&["render", "frames.xyz"], flags, &small].concat()).status(status).err();
        assert!(error.contains(says), "{error}");
    }
    assert!(!case.path("a.gif").exists());
    let note = case.run(&[&["render", "water.xyz", "-o", "a.mp4", "--turntable=2"][..], &small].concat()).err();
    assert!(case.path("a.mp4").exists() || note.contains("ffmpeg"), "{note}");
}

#[test]
fn trajectories_are_filmed_and_made_again() {
    let case = Case::new(&[]);
    for name in ["box.gro", "water.xtc"] {
        fs::copy(format!("{}/data/trajectories/{name}", env!("CARGO_MANIFEST_DIR")), case.path(name)).unwrap();
    }
    let files = ["box.gro", "water.xtc"];
    let flags = ["--size=64x48", "--quality=draft"];
    is_made_again(&case, "png", &files, &[&flags[..], &["--frame=4", "--bonds-per-frame=always"]].concat());
    // A film's frame is the picture of that frame, seen by the camera of the film's first.
    let film = [&["render"][..], &files, &["-o", "film.apng", "--renderer=cpu"], &flags].concat();
    assert_eq!(case.run(&film).status(0).err(), "");
    let reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(case.path("film.apng")).unwrap()));
    let mut reader = reader.read_info().unwrap();
    assert_eq!(reader.info().animation_control().map(|control| control.num_frames), Some(6));
    let first = [&["render"][..], &files, &["-o", "first.png", "--renderer=cpu"], &flags].concat();
    case.run(&first).status(0);
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let mut frames = Vec::new();
    for _ in 0..6 {
        reader.next_frame(&mut pixels).unwrap();
        frames.push(pixels.clone());
    }
    let picture = png::Decoder::new(std::io::BufReader::new(fs::File::open(case.path("first.png")).unwrap()));
    let mut picture = picture.read_info().unwrap();
    let mut alone = vec![0; picture.output_buffer_size().unwrap()];
    picture.next_frame(&mut alone).unwrap();
    assert!(frames[0] == alone, "the first frame is not the picture of it");
    assert!(frames.windows(2).all(|pair| pair[0] != pair[1]), "the atoms move");
}
