//! The window over a long time: at rest, at many sizes, with many files, with a graphics device that goes away, and on Wayland.
//! See [`super::window`] for how it is driven.

use super::window::{BALLSTICK, Running, display, pixels, wait_for, xdotool};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

/// A window that tells at its end what it did.
struct Told {
    running: Running,
    said: PathBuf,
}

impl Told {
    fn open(folder: &Path, preferences: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Told {
        let said = folder.join("said.txt");
        let child = Command::new(BALLSTICK)
            .arg("view")
            .arg("--timings")
            .args(arguments)
            .env("XDG_CONFIG_HOME", preferences)
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .envs(environment.iter().copied())
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(std::fs::File::create(&said).unwrap())
            .spawn()
            .unwrap();
        Told { running: Running(child), said }
    }

    /// What it says when it has ended by itself.
    fn ended(mut self) -> serde_json::Value {
        assert!(wait_for("the end", || self.running.0.try_wait().unwrap()).success(), "{}", self.text());
        let text = self.text();
        let line = text.lines().find(|line| line.starts_with('{')).unwrap_or_else(|| panic!("no timings: {text}"));
        serde_json::from_str(line).unwrap()
    }

    fn text(&self) -> String {
        std::fs::read_to_string(&self.said).unwrap_or_default()
    }

    /// The file of `/proc` of this name.
    fn proc(&self, name: &str) -> String {
        std::fs::read_to_string(format!("/proc/{}/{name}", self.running.0.id())).unwrap()
    }

    /// Hundredths of a second that it has computed.
    fn ticks(&self) -> u64 {
        let stat = self.proc("stat");
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
        fields[11].parse::<u64>().unwrap() + fields[12].parse::<u64>().unwrap()
    }

    /// Kilobytes of memory that are its own.
    fn memory_kb(&self) -> i64 {
        let rollup = self.proc("smaps_rollup");
        let field = |name: &str| {
            let line = rollup.lines().find(|line| line.starts_with(name)).unwrap();
            line.split_whitespace().nth(1).unwrap().parse::<i64>().unwrap()
        };
        field("Private_Dirty:") + field("Swap:")
    }

    /// Waits until it computes nothing any more.
    fn rests(&self) {
        wait_for("rest", || {
            let before = self.ticks();
            std::thread::sleep(Duration::from_millis(700));
            (self.ticks() == before).then_some(())
        });
    }
}

/// Its window, small and in the upper left corner.
fn window_of(display: &str) -> String {
    let id = wait_for("the window", || {
        Some(xdotool(display, &["search", "--name", "ballstick"])).filter(|id| !id.is_empty())
    });
    xdotool(display, &["windowsize", "--sync", &id, "400", "300"]);
    xdotool(display, &["windowmove", &id, "0", "0"]);
    xdotool(display, &["windowfocus", &id]);
    id
}

fn is_linux() -> bool {
    let is_linux = cfg!(target_os = "linux");
    if !is_linux {
        println!("SKIP what a program computes and takes is read from /proc");
    }
    is_linux
}

#[test]
fn a_window_draws_nothing_at_rest_and_does_not_grow() {
    let [folder, preferences, screen] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let Some((_xvfb, display)) = display(screen.path()).filter(|_| is_linux()) else { return };
    let file = data("caffeine.sdf");
    let arguments = [file.to_str().unwrap(), "--renderer", "cpu"];
    let window = Told::open(folder.path(), preferences.path(), &arguments, &[("DISPLAY", &display)]);
    let id = window_of(&display);
    xdotool(&display, &["mousemove", "900", "700"]);

    window.rests();
    let before = window.ticks();
    std::thread::sleep(Duration::from_secs(3));
    let ticks = window.ticks() - before;
    // It looks once a second whether the file has changed.
    assert!(ticks <= 1, "{ticks} hundredths of a second computed in 3 s of rest");

    let resize = |times: usize| {
        let mut steps: Vec<String> = Vec::new();
        for step in 0..times {
            steps.extend(
                ["windowsize", &id, &format!("{}", 300 + step % 90), &format!("{}", 250 + step % 70), "sleep", "0.008"]
                    .map(str::to_owned),
            );
        }
        let steps: Vec<&str> = steps.iter().map(String::as_str).collect();
        xdotool(&display, &steps);
        window.rests();
        window.memory_kb()
    };
    // What an allocator sets aside for later comes with the first of them.
    let first = resize(200);
    let last = resize(1000);
    println!("1,000 resizes: {first} kB before, {last} kB after");
    assert!(last - first < 3000, "1,000 resizes: {first} kB before, {last} kB after");

    let reopen = |times: usize| {
        for _ in 0..times {
            xdotool(&display, &["key", "F5"]);
            std::thread::sleep(Duration::from_millis(40));
        }
        window.rests();
        window.memory_kb()
    };
    let first = reopen(30);
    let last = reopen(100);
    println!("100 times opened: {first} kB before, {last} kB after");
    assert!(last - first < 1500, "100 times opened: {first} kB before, {last} kB after");

    xdotool(&display, &["key", "q"]);
    let told = window.ended();
    assert_eq!(told["renderers"], serde_json::json!(["cpu"]));
    assert!(told["pictures_in_motion"].as_u64().unwrap() >= 100, "{told}");
}

#[test]
fn a_lost_device_leaves_the_window_to_the_cpu() {
    the_cpu_takes_over("BALLSTICK_LOSE_DEVICE");
}

#[test]
fn a_device_without_memory_leaves_the_window_to_the_cpu() {
    the_cpu_takes_over("BALLSTICK_EXHAUST_DEVICE");
}

/// At the twelfth picture of the device, at which this variable has it fail.
fn the_cpu_takes_over(variable: &str) {
    let [folder, preferences, screen] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let Some((_xvfb, display)) = display(screen.path()) else { return };
    let devices = Command::new(BALLSTICK).arg("devices").env("DISPLAY", &display).output().unwrap();
    if !String::from_utf8_lossy(&devices.stdout).contains("llvmpipe") {
        let required = std::env::var("BALLSTICK_GPU").is_ok_and(|value| value == "require");
        assert!(!required, "lavapipe is not installed");
        println!("SKIP without lavapipe there is no device to lose");
        return;
    }
    let file = data("caffeine.sdf");
    let arguments = [file.to_str().unwrap(), "--renderer", "gpu"];
    let environment = [("DISPLAY", display.as_str()), (variable, "12")];
    let window = Told::open(folder.path(), preferences.path(), &arguments, &environment);
    window_of(&display);
    // Until the twelfth picture, and some more.
    for step in 0..12 {
        xdotool(&display, &["key", if step % 2 == 0 { "Left" } else { "Up" }]);
        std::thread::sleep(Duration::from_millis(150));
    }
    // What was open still is.
    xdotool(&display, &["key", "s"]);
    let saved = folder.path().join("caffeine-1.png");
    wait_for("the picture", || saved.exists().then_some(()));
    let (_, _, bytes) = pixels(&saved);
    assert!(bytes.chunks_exact(3).filter(|pixel| pixel[0] < 100).count() > 500, "the molecule is in it");
    xdotool(&display, &["key", "q"]);
    let told = window.ended();
    assert_eq!(told["renderers"], serde_json::json!(["gpu", "cpu"]), "{told}");
}

/// A Wayland compositor without a screen, and the folder of its socket.
fn compositor(folder: &Path) -> Result<Child, String> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o700)).map_err(|error| error.to_string())?;
    let mut child = Command::new("weston")
        .args(["--backend=headless-backend.so", "--use-gl", "--socket=wayland-test", "--width=1000", "--height=800"])
        // The last for pictures of the screen; those of its other renderer lack what has no alpha, as our window.
        .args(["--idle-time=0", "--no-config", "--debug"])
        .env("XDG_RUNTIME_DIR", folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| format!("weston: {error}"))?;
    let started = Instant::now();
    while !folder.join("wayland-test").exists() {
        if started.elapsed() > Duration::from_secs(20) {
            let _ = child.kill();
            return Err("weston does not start".to_owned());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(child)
}

#[test]
fn on_wayland_the_window_shows_the_molecule_rests_and_ends_with_the_compositor() {
    let [folder, preferences, runtime] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let mut weston = match compositor(runtime.path()) {
        Ok(weston) if is_linux() => Running(weston),
        Ok(_) => return,
        // Not in every list of what is to be installed: a test of its own requires it.
        Err(reason) => {
            assert!(std::env::var("BALLSTICK_WAYLAND").is_err(), "{reason}");
            println!("SKIP {reason}");
            return;
        }
    };
    let environment = [("XDG_RUNTIME_DIR", runtime.path().to_str().unwrap()), ("WAYLAND_DISPLAY", "wayland-test")];
    let file = data("caffeine.sdf");
    let arguments = [file.to_str().unwrap(), "--renderer", "cpu"];
    let mut window = Told::open(folder.path(), preferences.path(), &arguments, &environment);
    std::thread::sleep(Duration::from_millis(500));
    window.rests();
    assert!(window.running.0.try_wait().unwrap().is_none(), "{}", window.text());
    let before = window.ticks();
    std::thread::sleep(Duration::from_secs(2));
    assert!(window.ticks() - before <= 1, "at rest");

    let shot = Command::new("weston-screenshooter")
        .envs(environment)
        .current_dir(folder.path())
        .output()
        .map(|output| output.status.success());
    if matches!(shot, Ok(true)) {
        let mut files = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
        let picture = files.find(|path| path.extension().is_some_and(|e| e == "png")).unwrap();
        let (width, height, bytes) = pixels(&picture);
        let channels = bytes.len() / (width as usize * height as usize);
        // Oxygens are red, nitrogens blue, as nothing in the interface or the compositor's desktop is.
        let count = |is: fn(&[u8]) -> bool| bytes.chunks_exact(channels).filter(|pixel| is(pixel)).count();
        let red = count(|p| p[0] > 150 && p[1] < 60 && p[2] < 60);
        let blue = count(|p| p[2] > 150 && p[0] < 90 && p[1] < 110);
        println!("on the screen: {red} red pixels, {blue} blue ones");
        assert!(red > 200 && blue > 200, "{red} red, {blue} blue");
    } else {
        println!("SKIP weston-screenshooter: {shot:?}");
    }
    weston.0.kill().unwrap();
    let status = wait_for("the end", || window.running.0.try_wait().unwrap());
    assert!(status.code().is_some_and(|code| code <= 1), "{status:?}: {}", window.text());
}
