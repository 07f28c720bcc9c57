//! The window, driven as a person would under a virtual display: Xvfb shows it, xdotool moves the mouse and types.
//!
//! Without those two programs the tests print SKIP; `BALLSTICK_WINDOW=require` or `BALLSTICK_GPU=require` (set where everything is
//! installed) makes that a failure.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

pub(crate) const BALLSTICK: &str = env!("CARGO_BIN_EXE_ballstick");

/// Ends a program when the test does, whichever way.
pub(crate) struct Running(pub(crate) Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts Xvfb on a display of its own choice; the reason if there is none.
fn virtual_display(framebuffer: &Path) -> Result<(Running, String), String> {
    use std::io::{BufRead, BufReader};
    let mut child = Command::new("Xvfb")
        // Without -noreset the server starts anew when its last client leaves: xdotool, while the program connects.
        .args(["-displayfd", "1", "-screen", "0", "1000x800x24", "-nolisten", "tcp", "-noreset"])
        // What is on the screen, as a file: XWD, see `care`.
        .arg("-fbdir")
        .arg(framebuffer)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| format!("Xvfb: {error}"))?;
    let stdout = child.stdout.take().ok_or("Xvfb: no output")?;
    let running = Running(child);
    let mut number = String::new();
    BufReader::new(stdout).read_line(&mut number).map_err(|error| format!("Xvfb: {error}"))?;
    match number.trim() {
        "" => Err("Xvfb did not start".to_owned()),
        number => Ok((running, format!(":{number}"))),
    }
}

/// A display whose picture is a file of this folder; `None` if there is none and none is required.
pub(crate) fn display(framebuffer: &Path) -> Option<(Running, String)> {
    let required = ["BALLSTICK_WINDOW", "BALLSTICK_GPU"]
        .into_iter()
        .any(|name| std::env::var(name).is_ok_and(|value| value == "require"));
    let has_xdotool = Command::new("xdotool").arg("version").output().is_ok();
    let display = if has_xdotool { virtual_display(framebuffer) } else { Err("xdotool is not installed".to_owned()) };
    display
        .inspect_err(|reason| {
            assert!(!required, "{reason}");
            println!("SKIP {reason}");
        })
        .ok()
}

/// Opens a window on a file, 400 × 300 pixels in the upper left corner, which is too narrow for the panel.
pub(crate) fn open(display: &str, file: &Path, folder: &Path, preferences: &Path) -> Running {
    let said = tempfile::NamedTempFile::new().unwrap();
    let mut window = Running(
        Command::new(BALLSTICK)
            .arg(file)
            .args(["--renderer", "cpu"])
            .env("DISPLAY", display)
            .env("XDG_CONFIG_HOME", preferences)
            .env_remove("WAYLAND_DISPLAY")
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(said.reopen().unwrap())
            .spawn()
            .unwrap(),
    );
    let started = Instant::now();
    let id = wait_for("the window", || {
        // A program that has ended, or that says why it waits, is worth more than the time-out.
        let ended = window.0.try_wait().unwrap();
        let is_late = started.elapsed() > Duration::from_secs(50);
        let text = || std::fs::read_to_string(said.path()).unwrap_or_default();
        assert!(ended.is_none() && !is_late, "no window, {ended:?}: {:?}", text());
        Some(xdotool(display, &["search", "--name", "ballstick"])).filter(|id| !id.is_empty())
    });
    xdotool(display, &["windowsize", "--sync", &id, "400", "300"]);
    xdotool(display, &["windowmove", &id, "0", "0"]);
    xdotool(display, &["windowfocus", &id]);
    xdotool(display, &["mousemove", "200", "150"]);
    window
}

pub(crate) fn xdotool(display: &str, arguments: &[&str]) -> String {
    let output = Command::new("xdotool").env("DISPLAY", display).args(arguments).output().unwrap();
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// Waits until `done` gives something.
pub(crate) fn wait_for<T>(what: &str, mut done: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(value) = done() {
            return value;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

pub(crate) fn pixels(path: &Path) -> (u32, u32, Vec<u8>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    (info.width, info.height, bytes)
}

/// Presses `s` and waits for the picture it saves.
pub(crate) fn screenshot(display: &str, path: PathBuf) -> (u32, u32, Vec<u8>) {
    xdotool(display, &["key", "s"]);
    wait_for("the screenshot", || path.exists().then_some(()));
    pixels(&path)
}

#[test]
fn the_window_shows_turns_zooms_and_saves_what_render_draws() {
    let (folder, preferences, framebuffer) =
        (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let Some((_xvfb, display)) = display(framebuffer.path()) else { return };
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/caffeine.sdf");
    let open = |file: &Path| open(&display, file, folder.path(), preferences.path());
    let mut window = open(&file);

    let first = wait_for("the new size", || {
        // The window learns its size when the event comes; pictures saved before it have the old one.
        let number = 1 + std::fs::read_dir(&folder).unwrap().count();
        let path = folder.path().join(format!("caffeine-{number}.png"));
        Some(screenshot(&display, path)).filter(|(width, height, _)| (*width, *height) == (400, 300))
    });
    let rendered = folder.path().join("rendered.png");
    let status = Command::new(BALLSTICK)
        .args(["render", "--renderer", "cpu", "--size", "400x300", "-o"])
        .arg(&rendered)
        .arg(&file)
        .status()
        .unwrap();
    assert!(status.success());
    assert!(pixels(&rendered) == first, "the screenshot is what render draws");
    std::fs::remove_file(&rendered).unwrap();

    let next = || folder.path().join(format!("caffeine-{}.png", 1 + std::fs::read_dir(&folder).unwrap().count()));
    let mut seen = vec![first.clone()];
    let mut changed = |what: &str, steps: &[&[&str]]| {
        for step in steps {
            xdotool(&display, step);
        }
        // What is shown follows soon, but how soon the machine decides.
        seen.push(wait_for(&format!("{what} to change the picture"), || {
            Some(screenshot(&display, next())).filter(|picture| !seen.contains(picture))
        }));
    };
    changed("a left drag", &[&["mousedown", "1"], &["mousemove", "260", "170"], &["mouseup", "1"]]);
    changed("a right drag", &[&["mousedown", "3"], &["mousemove", "230", "150"], &["mouseup", "3"]]);
    changed("the wheel", &[&["click", "--repeat", "3", "4"]]);
    changed("licorice", &[&["key", "2"]]);
    changed("space-filling", &[&["key", "3"]]);
    changed("wireframe", &[&["key", "4"]]);
    changed("no ground", &[&["key", "1"], &["key", "g"]]);
    changed("orthographic", &[&["key", "o"]]);
    for key in ["o", "g", "r"] {
        xdotool(&display, &["key", key]);
    }
    wait_for("reset to bring the first view back", || (screenshot(&display, next()) == first).then_some(()));

    // A session keeps style and view, and another window shows the same.
    changed("licorice from the side", &[&["key", "2"], &["key", "Left"], &["key", "Left"]]);
    let seen = seen.pop().unwrap();
    xdotool(&display, &["key", "ctrl+s"]);
    std::thread::sleep(Duration::from_millis(300));
    xdotool(&display, &["key", "Return"]);
    let session = folder.path().join("caffeine.ballstick.json");
    wait_for("the session", || session.exists().then_some(()));
    let quit = |window: &mut Running| {
        xdotool(&display, &["key", "q"]);
        wait_for("the end", || window.0.try_wait().unwrap())
    };
    assert!(quit(&mut window).success());
    let mut window = open(&session);
    let again = wait_for("the new size", || {
        let number = std::fs::read_dir(&folder).unwrap().count();
        let path = folder.path().join(format!("caffeine-{number}.png"));
        Some(screenshot(&display, path)).filter(|(width, height, _)| (*width, *height) == (400, 300))
    });
    // Numbers are written with all their digits, and the eye is found from them again.
    let differing = seen.2.iter().zip(&again.2).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(differing * 1000 < seen.2.len(), "{differing} of {} bytes differ", seen.2.len());
    assert!(quit(&mut window).success());
}

#[test]
fn without_a_display_the_render_command_is_named() {
    if !cfg!(all(unix, not(target_os = "macos"))) {
        println!("SKIP only X11 and Wayland know machines without a display");
        return;
    }
    let output = Command::new(BALLSTICK)
        .arg(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/benzene.xyz"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("no display") && message.contains("ballstick render"), "{message}");
    assert!(!message.contains(".rs"), "no source files: {message}");
}
