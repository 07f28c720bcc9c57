//! The window with a person's care: what is picked, measured and played, what is on the screen beside what is saved, files that change.
//! See [`super::window`] for how it is driven.

use super::window::{BALLSTICK, Running, display, open, pixels, screenshot, wait_for, xdotool};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

/// Folders for files, preferences and the screen.
fn folders() -> [tempfile::TempDir; 3] {
    [(); 3].map(|()| tempfile::tempdir().unwrap())
}

/// Saves pictures until one has the size of the window, which learns of it when the event comes.
fn first_picture(display: &str, folder: &Path, stem: &str) -> (PathBuf, (u32, u32, Vec<u8>)) {
    let mut number = 0;
    wait_for("the new size", || {
        number += 1;
        let path = folder.join(format!("{stem}-{number}.png"));
        let picture = screenshot(display, path.clone());
        ((picture.0, picture.1) == (400, 300)).then_some((path, picture))
    })
}

fn render(folder: &Path, arguments: &[&str]) {
    let status = Command::new(BALLSTICK).arg("render").args(arguments).current_dir(folder).status().unwrap();
    assert!(status.success(), "{arguments:?}");
}

/// The ids at the pixels of a picture of 400 × 300.
fn ids(folder: &Path, from: &str) -> Vec<u32> {
    render(folder, &["--from", from, "--channel", "id", "-o", "ids.npy"]);
    let bytes = std::fs::read(folder.join("ids.npy")).unwrap();
    let ids: Vec<u32> = bytes[bytes.len() - 400 * 300 * 4..]
        .chunks_exact(4)
        .map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]]))
        .collect();
    std::fs::remove_file(folder.join("ids.npy")).unwrap();
    ids
}

/// The middle of what is seen of an atom.
fn place(ids: &[u32], id: u32) -> [String; 2] {
    let seen: Vec<usize> = (0..ids.len()).filter(|&at| ids[at] == id).collect();
    assert!(seen.len() > 20, "atom {id} is seen");
    let mean = |of: &dyn Fn(usize) -> usize| seen.iter().map(|&at| of(at)).sum::<usize>() / seen.len();
    let (x, y) = (mean(&|at| at % 400), mean(&|at| at / 400));
    assert_eq!(ids[y * 400 + x], id);
    [x.to_string(), y.to_string()]
}

fn quit(display: &str, mut window: Running) {
    xdotool(display, &["key", "q"]);
    assert!(wait_for("the end", || window.0.try_wait().unwrap()).success());
}

#[test]
fn frames_play_atoms_are_measured_and_the_saved_picture_is_made_again() {
    let [folder, preferences, screen] = folders();
    let Some((_xvfb, display)) = display(screen.path()) else { return };
    let file = folder.path().join("ethane.xyz");
    std::fs::copy(data("ethane-rotation.xyz"), &file).unwrap();
    let window = open(&display, &file, folder.path(), preferences.path());
    let (path, first) = first_picture(&display, folder.path(), "ethane");
    let count = || {
        std::fs::read_dir(&folder)
            .unwrap()
            .filter(|entry| entry.as_ref().unwrap().path().extension().is_some_and(|e| e == "png"))
            .count()
    };
    let next = || folder.path().join(format!("ethane-{}.png", 1 + count()));
    let ids = ids(folder.path(), path.file_name().unwrap().to_str().unwrap());

    // Two atoms and their distance.
    for (id, shift) in [(1, false), (2, true)] {
        let [x, y] = place(&ids, id);
        xdotool(&display, &["mousemove", &x, &y]);
        match shift {
            true => xdotool(&display, &["keydown", "shift", "click", "1", "keyup", "shift"]),
            false => xdotool(&display, &["click", "1"]),
        };
        std::thread::sleep(Duration::from_millis(400)); // two clicks, not a double one
    }
    xdotool(&display, &["key", "m"]);
    std::thread::sleep(Duration::from_millis(200));
    let measured = screenshot(&display, next());
    assert!(measured != first, "the distance is in the picture");

    // Another frame, then some by themselves.
    xdotool(&display, &["key", "period"]);
    std::thread::sleep(Duration::from_millis(200));
    let stepped = screenshot(&display, next());
    assert!(stepped != measured, "the next frame is another picture");
    xdotool(&display, &["key", "space"]);
    std::thread::sleep(Duration::from_millis(600));
    xdotool(&display, &["key", "space"]);
    std::thread::sleep(Duration::from_millis(200));
    let last = next();
    let played = screenshot(&display, last.clone());

    // All of it is in the session.
    xdotool(&display, &["key", "ctrl+s"]);
    std::thread::sleep(Duration::from_millis(300));
    xdotool(&display, &["key", "Return"]);
    let session = folder.path().join("ethane.ballstick.json");
    wait_for("the session", || session.exists().then_some(()));
    let session = ballstick::session::Session::read(&session).unwrap();
    assert_eq!(session.measurements, [[[1, 1], [1, 2]]]);
    assert!(session.files[0].frame > 1, "frames were played");

    // What was saved says how it was made.
    let name = last.file_name().unwrap().to_str().unwrap();
    render(folder.path(), &["--from", name, "-o", "again.png"]);
    assert!(pixels(&folder.path().join("again.png")) == played, "to the last bit");
    std::fs::remove_file(folder.path().join("again.png")).unwrap();

    // A file that changes is shown as it is now.
    std::fs::copy(data("benzene.xyz"), &file).unwrap();
    wait_for("the changed file", || {
        std::thread::sleep(Duration::from_millis(500));
        (screenshot(&display, next()) != played).then_some(())
    });
    quit(&display, window);
}

/// The pixels in the upper left corner of the screen, which Xvfb keeps as a file: XWD, version 7 (X11/XWDFile.h), big-endian words.
fn on_screen(folder: &Path, [width, height]: [usize; 2]) -> Vec<[u8; 3]> {
    let bytes = std::fs::read(folder.join("Xvfb_screen0")).unwrap();
    let word = |index: usize| u32::from_be_bytes(bytes[index * 4..index * 4 + 4].try_into().unwrap()) as usize;
    let (header, bits, line, colors) = (word(0), word(11), word(12), word(19));
    assert_eq!((word(1), bits), (7, 32));
    let little_endian = word(7) == 0;
    let start = header + colors * 12;
    let pixel = |x: usize, y: usize| {
        let at = start + y * line + x * 4;
        let [a, b, c, d] = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
        if little_endian { [c, b, a] } else { [b, c, d] }
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
}

#[test]
fn the_screen_at_rest_is_the_picture_that_is_saved() {
    let [folder, preferences, screen] = folders();
    let Some((_xvfb, display)) = display(screen.path()) else { return };
    let window = open(&display, &data("caffeine.sdf"), folder.path(), preferences.path());
    let (path, (_, _, saved)) = first_picture(&display, folder.path(), "caffeine");
    let ids = ids(folder.path(), path.file_name().unwrap().to_str().unwrap());
    // Nothing is pointed at, and the notice of the saved picture goes by itself.
    xdotool(&display, &["mousemove", "900", "700"]);
    let covered: Vec<usize> = (0..ids.len()).filter(|&at| ids[at] != 0).collect();
    assert!(covered.len() > 5_000);
    let mut mean = f64::INFINITY;
    wait_for("the screen to be the picture", || {
        let shown = on_screen(screen.path(), [400, 300]);
        let off = |&at: &usize| (0..3).map(|c| f64::from(shown[at][c].abs_diff(saved[at * 3 + c]))).sum::<f64>() / 3.0;
        mean = covered.iter().map(off).sum::<f64>() / covered.len() as f64;
        (mean <= 1.0).then_some(())
    });
    println!("mean difference of the covered pixels: {mean} of 255");
    quit(&display, window);
}
