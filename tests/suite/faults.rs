//! What goes wrong around the program: full disks, signals, missing threads and memory, odd names and files. Each time it says what is wrong,
//! ends with the right status, and leaves no half file and no old one lost.
//!
//! The shell sets limits (`ulimit`) and sends signals (`kill`). What a machine or a user cannot do is skipped with a reason.

#![cfg(unix)]

use super::cli::{METHANE, WATER};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

const BALLSTICK: &str = env!("CARGO_BIN_EXE_ballstick");

/// Small and quick.
const QUICK: &str = "--renderer cpu --quality draft --size 64x48";

/// Long enough to be stopped in the middle: many seconds on any machine.
const LONG: &str = "--renderer cpu --quality high --samples 1024 --size 3000x2000";

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        fs::write(place.path("water.xyz"), WATER).unwrap();
        fs::write(place.path("methane.xyz"), METHANE).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A line of the shell, `ballstick` being this program.
    fn command(&self, line: &str) -> Command {
        let mut command = Command::new("sh");
        let folder = Path::new(BALLSTICK).parent().unwrap().display();
        command.env("PATH", format!("{folder}:{}", std::env::var("PATH").unwrap_or_default()));
        command.arg("-c").arg(line).current_dir(self.0.path()).stdin(Stdio::null());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn start(&self, line: &str) -> Child {
        self.command(line).spawn().unwrap()
    }

    #[track_caller]
    fn run(&self, line: &str, status: i32) -> Said {
        let output = self.command(line).output().unwrap();
        let said = Said(output);
        assert_eq!(said.0.status.code(), Some(status), "{line}\n{}", said.err());
        assert!(!said.err().contains("panicked"), "{line}\n{}", said.err());
        said
    }

    fn names(&self) -> Vec<OsString> {
        let mut names: Vec<OsString> = fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    }
}

struct Said(Output);

impl Said {
    fn err(&self) -> String {
        String::from_utf8_lossy(&self.0.stderr).into_owned()
    }

    #[track_caller]
    fn says(self, text: &str) -> Said {
        assert!(self.err().contains(text), "{text:?} is not in\n{}", self.err());
        self
    }
}

/// Whether a file is a whole PNG picture.
fn is_whole_png(path: &Path) -> bool {
    let Ok(bytes) = fs::read(path) else { return false };
    image::load_from_memory_with_format(&bytes, image::ImageFormat::Png).is_ok()
}

/// Numbers that look like chance, the same each time.
fn moments(count: u64, most_ms: u64) -> impl Iterator<Item = Duration> {
    (0..count).map(move |i| Duration::from_micros(i.wrapping_mul(0x9E37_79B9_7F4A_7C15) % (most_ms * 1000)))
}

#[test]
fn a_full_disk_is_an_error_of_every_command() {
    if fs::metadata("/dev/full").is_err() {
        println!("SKIP: there is no /dev/full");
        return;
    }
    let place = Place::new();
    for line in [
        "ballstick info water.xyz > /dev/full",
        "ballstick info --json water.xyz > /dev/full",
        "ballstick info --explain-bonds water.xyz > /dev/full",
        "ballstick convert water.xyz - --to json > /dev/full",
        "ballstick convert water.xyz /dev/full --to json",
        "ballstick render water.xyz -o /dev/full --size 64x48",
        "ballstick render water.xyz -o - --size 64x48 > /dev/full",
        "ballstick --help > /dev/full",
        "ballstick --version > /dev/full",
        "ballstick devices > /dev/full",
    ] {
        place.run(line, 1).says("cannot write").says("No space left");
    }
    // Nobody hears of the error, and it is one all the same.
    place.run("ballstick info none.pdb 2> /dev/full", 1);
}

#[test]
fn a_file_that_finds_no_room_leaves_the_old_one_and_nothing_else() {
    let place = Place::new();
    for name in ["a.png", "a.json", "a.gif", "a.npy", "a.obj", "a.glb"] {
        fs::write(place.path(name), "old").unwrap();
    }
    fs::write(place.path("a.mtl"), "# ballstick: old").unwrap();
    let before = place.names();
    // Blocks of 512 or 1024 bytes; the shell itself writes nothing.
    for (line, name) in [
        ("ulimit -f 4; ballstick render methane.xyz -o a.png --renderer cpu --size 800x600", "a.png"),
        ("ulimit -f 0; ballstick convert methane.xyz a.json", "a.json"),
        (
            "ulimit -f 4; ballstick render methane.xyz -o a.gif --turntable=3 --renderer cpu --quality draft --size 400x300",
            "a.gif",
        ),
        ("ulimit -f 16; ballstick convert methane.xyz -o a.obj", "a.obj"),
        ("ulimit -f 4; ballstick convert methane.xyz -o a.glb --compat", "a.glb"),
        ("ulimit -f 4; ballstick render methane.xyz -o a.npy --channel depth --renderer cpu --size 200x100", "a.npy"),
    ] {
        place.run(line, 1).says(name).says("File too large");
        assert_eq!(fs::read(place.path(name)).unwrap(), b"old", "{line}");
    }
    assert_eq!(fs::read(place.path("a.mtl")).unwrap(), b"# ballstick: old", "it belongs to the old a.obj");
    place
        .run("ulimit -f 4; ballstick render methane.xyz water.xyz -o ./ --renderer cpu --size 800x600", 1)
        .says("water.png");
    assert_eq!(place.names(), before);
}

#[test]
fn closed_streams_stop_nothing() {
    let place = Place::new();
    for closed in ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"] {
        place.run(&format!("ballstick render water.xyz -o a.png {QUICK} {closed}"), 0);
        assert!(is_whole_png(&place.path("a.png")));
        fs::remove_file(place.path("a.png")).unwrap();
        place.run(&format!("ballstick info water.xyz {closed}"), 0);
        place.run(&format!("ballstick info none.xyz {closed}"), 1);
        place.run(&format!("ballstick info - {closed}"), 1);
    }
}

#[test]
fn a_reader_that_has_enough_ends_the_work_quietly() {
    let place = Place::new();
    for line in [
        "ballstick render methane.xyz -o - --renderer cpu --size 600x400",
        "ballstick render methane.xyz -o - --to gif --turntable=3 --renderer cpu --quality draft --size 64x48",
        "ballstick render --help",
        "ballstick info --json $(for i in 0 1 2 3 4 5 6 7 8 9; do echo $(seq 200 | sed s/.*/water.xyz/); done)",
    ] {
        let status = place.run(&format!("{{ {line}; echo $? >&3; }} 3>status | head -c 10"), 0);
        assert_eq!(status.err(), "", "{line}");
        assert_eq!(fs::read_to_string(place.path("status")).unwrap(), "0\n", "{line}");
    }
}

/// Starts, sends the signal a moment later, and says how it ended.
fn interrupted(place: &Place, line: &str, signal: &str, after: Duration) -> std::process::ExitStatus {
    let mut child = place.start(&format!("exec {line}"));
    std::thread::sleep(after);
    let sent = Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status().unwrap();
    assert!(sent.success(), "it ended before it was told to: {line}");
    child.wait().unwrap()
}

#[test]
fn signals_end_pictures_batches_and_films_and_leave_nothing() {
    let place = Place::new();
    fs::create_dir(place.path("out")).unwrap();
    fs::write(place.path("a.png"), "old").unwrap();
    let before = place.names();
    let film = "--turntable=400 --renderer cpu --size 600x400";
    let mut lines = vec![
        format!("ballstick render methane.xyz -o a.png {LONG}"),
        format!("ballstick render methane.xyz water.xyz -o out/ {LONG}"),
        format!("ballstick render methane.xyz -o a.gif {film}"),
        format!("ballstick render methane.xyz -o a.apng {film}"),
    ];
    if Command::new("ffmpeg").arg("-version").output().is_ok() {
        lines.push(format!("ballstick render methane.xyz -o a.mp4 {film}"));
    }
    // Who runs the tests in the background of a script has them ignore Ctrl+C, and so do those whom they start.
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap_or("0");
    let is_ignored = u64::from_str_radix(mask.trim(), 16).is_ok_and(|mask| mask & 0b10 != 0);
    let first = if is_ignored { ("TERM", 15) } else { ("INT", 2) };
    for (line, (signal, number)) in lines.iter().zip([first, ("TERM", 15)].into_iter().cycle()) {
        let status = interrupted(&place, line, signal, Duration::from_millis(700));
        assert_eq!(status.signal(), Some(number), "{line}");
        assert_eq!(place.names(), before, "{line}");
        assert_eq!(fs::read_dir(place.path("out")).unwrap().count(), 0, "{line}");
        assert_eq!(fs::read(place.path("a.png")).unwrap(), b"old");
    }
}

#[test]
fn a_signal_that_the_parent_ignores_stays_ignored() {
    let place = Place::new();
    let line = "ballstick render methane.xyz -o a.png --renderer cpu --size 900x600 --samples 64";
    for signal in ["INT", "HUP"] {
        let child = place.start(&format!("trap '' {signal}; exec {line}"));
        std::thread::sleep(Duration::from_millis(150));
        drop(Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{signal}: {:?}", output.status);
        assert!(is_whole_png(&place.path("a.png")));
        fs::remove_file(place.path("a.png")).unwrap();
    }
}

#[test]
fn a_render_that_is_killed_leaves_a_whole_file_or_the_old_one() {
    let place = Place::new();
    for (index, after) in moments(24, 120).enumerate() {
        let is_batch = index % 2 == 1;
        fs::write(place.path("methane.png"), "old").unwrap();
        let out = if is_batch { "water.xyz -o ./" } else { "-o methane.png" };
        let line = format!("ballstick render methane.xyz {out} --renderer cpu --quality draft --size 300x200");
        let mut child = place.start(&format!("exec {line}"));
        std::thread::sleep(after);
        child.kill().unwrap();
        child.wait().unwrap();
        let is_old = fs::read(place.path("methane.png")).unwrap() == b"old";
        assert!(is_old || is_whole_png(&place.path("methane.png")), "a half picture after {after:?}");
        let second = place.path("water.png");
        assert!(!second.exists() || is_whole_png(&second), "a half picture after {after:?}");
        drop(fs::remove_file(second));
    }
}

/// Not a test: what the next one starts and kills.
#[test]
#[ignore = "saves sessions without end, for a test that kills it"]
fn saves_sessions_without_end() {
    let Some(path) = std::env::var_os("BALLSTICK_TEST_SESSION") else { return };
    let path = PathBuf::from(path);
    let mut session = session();
    for number in 0u32.. {
        session.ball_scale = 1.0 + (number % 7) as f32;
        session.write(&path).unwrap();
    }
}

fn session() -> ballstick::session::Session {
    ballstick::session::Session::of(&ballstick::session::Settings {
        scene: ballstick::scene::SceneOptions::default(),
        crystal: ballstick::crystal::CrystalOptions::default(),
        cell_box: None,
        quality: ballstick::render::Quality::default(),
        viewpoint: None,
    })
}

#[test]
fn a_session_whose_saving_is_killed_is_the_old_or_the_new_one() {
    let place = Place::new();
    let path = place.path("a.ballstick.json");
    session().write(&path).unwrap();
    for after in moments(24, 150) {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--ignored", "--exact", "faults::saves_sessions_without_end"])
            .env("BALLSTICK_TEST_SESSION", &path)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(after);
        child.kill().unwrap();
        child.wait().unwrap();
        let read = ballstick::session::Session::read(&path);
        assert!(read.is_ok(), "after {after:?}: {read:?}");
    }
}

/// The line as a user whom limits hold; root has none. `None` where that cannot be.
fn as_anyone(line: &str) -> Option<String> {
    let id = Command::new("id").arg("-u").output().ok()?;
    if id.stdout != b"0\n" {
        return Some(format!("sh -c '{line}'"));
    }
    let switch = "setpriv --reuid=65534 --regid=65534 --clear-groups --";
    let works = Command::new("sh").args(["-c", &format!("{switch} {BALLSTICK} --version")]).output();
    works.is_ok_and(|output| output.status.success()).then(|| format!("{switch} sh -c '{line}'"))
}

#[test]
fn without_threads_the_picture_is_the_same() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new();
    fs::set_permissions(&place.0, fs::Permissions::from_mode(0o777)).unwrap();
    // The same option has two names.
    let limit = "ulimit -u 0 2>/dev/null || ulimit -p 0";
    let line = "ballstick render methane.xyz -o one.ppm --renderer cpu --size 96x64";
    let Some(limited) = as_anyone(&format!("{limit}; exec {line}")) else {
        println!("SKIP: limits do not hold this user, and it cannot become another one");
        return;
    };
    place.run(&limited, 0);
    place.run("ballstick render methane.xyz -o all.ppm --renderer cpu --size 96x64", 0);
    assert!(fs::read(place.path("one.ppm")).unwrap() == fs::read(place.path("all.ppm")).unwrap());
    for command in
        ["info methane.xyz", "convert methane.xyz a.json", "render methane.xyz -o a.gif --turntable=2 --size 32x24"]
    {
        place.run(&as_anyone(&format!("{limit}; exec ballstick {command}")).unwrap(), 0);
    }
}

#[test]
fn any_number_of_threads_draws_the_same_bytes() {
    let place = Place::new();
    let mut first: Option<Vec<u8>> = None;
    for threads in ["1", "2", "7", "0", "many", "1000000000"] {
        place.run(
            &format!("RAYON_NUM_THREADS={threads} ballstick render methane.xyz -o a.png --renderer cpu --size 160x120"),
            0,
        );
        let bytes = fs::read(place.path("a.png")).unwrap();
        assert!(*first.get_or_insert_with(|| bytes.clone()) == bytes, "{threads} threads");
    }
}

/// The widths differ in how many lanes an instruction takes, and in nothing else: the tolerance is none.
#[test]
fn any_width_of_vectors_draws_the_same_bytes() {
    let place = Place::new();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/data");
    fs::copy(format!("{data}/1crn.pdb"), place.path("crambin.pdb")).unwrap();
    fs::copy(format!("{data}/benzene.xyz"), place.path("benzene.xyz")).unwrap();
    let level = |name: &str| {
        let said = place.run(&format!("BALLSTICK_SIMD={name} ballstick devices"), 0);
        let out = String::from_utf8(said.0.stdout).unwrap();
        out.lines().next().unwrap().rsplit(' ').next().unwrap().to_owned()
    };
    assert_eq!(level("baseline"), "baseline");
    let scenes = [
        "crambin.pdb --size 160x120",
        "crambin.pdb --size 160x120 --quality draft --projection orthographic --look outline",
        "crambin.pdb --size 160x120 --samples 4 --style space-filling --depth-of-field 9 --fog 0.5",
        "benzene.xyz --size 161x119 --background transparent --axes --light world",
        "benzene.xyz --size 96x64 --channel normal",
        "crambin.pdb --size 96x64 --channel ao",
    ];
    for scene in scenes {
        let draw = |level: &str| {
            let line = format!("BALLSTICK_SIMD={level} ballstick render {scene} -o {level}.png --renderer cpu");
            place.run(&line, 0);
            fs::read(place.path(&format!("{level}.png"))).unwrap()
        };
        let plain = draw("baseline");
        for name in ["avx2", "avx512"] {
            if level(name) == name {
                assert!(draw(name) == plain, "{scene} with {name}");
            } else {
                println!("SKIP: the machine has no {name}");
            }
        }
    }
}

#[test]
fn a_small_stack_is_enough() {
    let place = Place::new();
    for line in [
        format!("render methane.xyz -o a.png {QUICK}"),
        "info methane.xyz".to_owned(),
        "convert methane.xyz a.glb".to_owned(),
        "render --help".to_owned(),
    ] {
        place.run(&format!("ulimit -s 64 && ballstick {line}"), 0);
    }
}

#[test]
fn too_little_memory_is_said_before_it_is_used_up() {
    let place = Place::new();
    // Takes no room on the disk, and nothing is read of it.
    fs::File::create(place.path("large.xyz")).unwrap().set_len(3 << 30).unwrap();
    let limit = "ulimit -v 1000000 2>/dev/null || exit 77;";
    for line in [
        format!("{limit} ballstick info large.xyz"),
        format!("{limit} ballstick convert large.xyz a.json"),
        format!("{limit} ballstick render large.xyz -o a.png {QUICK}"),
        format!(
            "{limit} ballstick render methane.xyz -o a.webp --renderer cpu --quality draft --samples 1 --size 16000x16000"
        ),
    ] {
        place.run(&line, 1).says("MB of memory").says("ulimit -v");
    }
    assert!(!place.names().iter().any(|name| name.as_bytes().starts_with(b"a.")));
}

#[test]
fn names_of_any_bytes_are_read_written_and_printed_safely() {
    let place = Place::new();
    let names: [&[u8]; 12] = [
        b"with space.xyz",
        b"quo'te\"s.xyz",
        b"new\nline.xyz",
        b"\xff\xfe.xyz",
        b"\xfe\xff.xyz",
        b"esc\x1b[31m.xyz",
        b"-dash.xyz",
        b"{stem}.xyz",
        b"*.xyz",
        b"%n%s.xyz",
        "\u{202e}drawkcab.xyz".as_bytes(),
        b"a=b:c.xyz",
    ];
    let folder = tempfile::tempdir_in(place.0.path()).unwrap();
    let mut drawn = Vec::new();
    for name in names {
        let path = folder.path().join(OsStr::from_bytes(name));
        if fs::write(&path, WATER).is_err() {
            println!("SKIP: the file system refuses {name:?}");
            continue;
        }
        for command in [&["info"][..], &["info", "--json"]] {
            let output = Command::new(BALLSTICK).args(command).arg(&path).output().unwrap();
            assert!(output.status.success(), "{name:?}");
            assert!(!output.stdout.contains(&0x1b) && !output.stderr.contains(&0x1b), "{name:?} steers the terminal");
        }
        let missing = folder.path().join(OsStr::from_bytes(&[name, &b".none"[..]].concat()));
        let output = Command::new(BALLSTICK).arg("info").arg(missing).output().unwrap();
        assert!(output.status.code() == Some(1) && !output.stderr.contains(&0x1b), "{name:?}");
        drawn.push(path);
    }
    let pictures = place.path("pictures");
    let arguments = ["--renderer", "cpu", "--quality", "draft", "--size", "16x12", "-o"];
    let output =
        Command::new(BALLSTICK).arg("render").args(&drawn).args(arguments).arg(pictures.join("")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for path in &drawn {
        let mut name = path.file_stem().unwrap().as_bytes().to_vec();
        name.extend_from_slice(b".png");
        let picture = pictures.join(OsString::from_vec(name));
        assert!(is_whole_png(&picture), "{picture:?}");
        // Where the name is text, the picture knows what it was made of.
        if path.to_str().is_some() {
            let mut again = Command::new(BALLSTICK);
            again.args(["render", "--from"]).arg(&picture).args(["-o", "again.png"]).current_dir(place.0.path());
            let output = again.output().unwrap();
            assert!(output.status.success(), "{picture:?} {}", String::from_utf8_lossy(&output.stderr));
        }
    }
}

#[test]
fn what_is_no_file_of_a_molecule_is_said_to_be_that() {
    let place = Place::new();
    fs::write(place.path("empty.pdb"), "").unwrap();
    fs::create_dir(place.path("folder.pdb")).unwrap();
    let _socket = std::os::unix::net::UnixListener::bind(place.path("socket.pdb")).unwrap();
    for name in ["empty.pdb", "folder.pdb", "socket.pdb", "none.pdb", "/dev/null", "methane.xyz/x.pdb"] {
        for line in [
            format!("ballstick info {name}"),
            format!("ballstick convert {name} a.json"),
            format!("ballstick render {name} -o a.png {QUICK}"),
            format!("ballstick render methane.xyz --overlay {name} -o a.png {QUICK}"),
            format!("ballstick render --from {name} -o a.png"),
            format!("ballstick info methane.xyz {name}"),
        ] {
            place.run(&line, 1).says(name);
        }
    }
    // What never ends is no session.
    place.run("ballstick render --from /dev/zero -o a.png", 1).says("/dev/zero");
    assert!(!place.path("a.png").exists() && !place.path("a.json").exists());
}

#[test]
fn a_pipe_is_read_and_written_like_a_file() {
    let place = Place::new();
    if !Command::new("mkfifo").arg(place.path("pipe.xyz")).status().is_ok_and(|status| status.success()) {
        println!("SKIP: there is no mkfifo");
        return;
    }
    place.run("cat water.xyz > pipe.xyz & ballstick info pipe.xyz && wait", 0);
    place.run(&format!("cat water.xyz > pipe.xyz & ballstick render pipe.xyz -o a.png {QUICK} && wait"), 0);
    place.run("cat pipe.xyz > got & ballstick convert water.xyz pipe.xyz && wait", 0);
    assert!(fs::read_to_string(place.path("got")).unwrap().starts_with("3\nwater\n"));
}

#[test]
fn the_surroundings_do_not_matter() {
    let place = Place::new();
    for setting in [
        "env -i",
        "env -u HOME",
        "env HOME=/nonexistent XDG_CONFIG_HOME=/dev/null XDG_CACHE_HOME=/dev/null XDG_RUNTIME_DIR=/dev/null",
        "env LANG=C LC_ALL=C",
        "env LANG=de_DE.UTF-8 LC_ALL=de_DE.UTF-8",
        "env LC_ALL=tr_TR LC_NUMERIC=x",
        "env LC_ALL=///",
        "env TMPDIR=/nonexistent",
        "env COLUMNS=0 TERM=",
        "env RUST_BACKTRACE=full RUST_LOG=trace CLICOLOR_FORCE=1",
    ] {
        let said = place.run(&format!("{setting} {BALLSTICK} info water.xyz"), 0);
        assert_eq!((said.err().as_str(), said.0.stdout.starts_with(b"water.xyz: water\n")), ("", true), "{setting}");
        place.run(&format!("{setting} {BALLSTICK} render water.xyz -o a.png {QUICK}"), 0);
        place.run(&format!("{setting} {BALLSTICK} render --help"), 0);
        fs::remove_file(place.path("a.png")).unwrap();
    }
}

#[test]
fn a_folder_that_is_gone_is_said() {
    let place = Place::new();
    let line =
        format!("mkdir gone && cd gone && rmdir ../gone && ballstick render {}", place.path("water.xyz").display());
    place.run(&format!("{line} -o a.png {QUICK}"), 1).says("a.png");
}

#[test]
fn pictures_have_any_size_and_no_other() {
    let place = Place::new();
    for size in ["1x1", "1x2", "3x1", "1x5000", "5000x1", "33x31"] {
        for flags in
            ["", "--label element --legend --scale-bar --axes --outline 2 --depth-of-field 5 --samples 4 --crop auto"]
        {
            place.run(
                &format!("ballstick render water.xyz -o a.png --renderer cpu --quality draft --size {size} {flags}"),
                0,
            );
            assert!(is_whole_png(&place.path("a.png")), "{size} {flags}");
        }
    }
    for size in ["0x0", "0x5", "5x0", "32769x1", "1x32769", "99999999999999999999x1", "-1x5", "x", "1e3x5"] {
        place.run(&format!("ballstick render water.xyz -o b.png --size={size}"), 2);
    }
    assert!(!place.path("b.png").exists());
}

#[test]
fn a_file_that_changes_while_it_is_read_is_read_or_refused() {
    let place = Place::new();
    let atoms: String =
        (0..200_000).map(|i| format!("C {} {} {}\n", i % 60 * 2, i / 60 % 60 * 2, i / 3600 * 2)).collect();
    let text = format!("200000\nlarge\n{atoms}");
    for (index, after) in moments(12, 40).enumerate() {
        let path = place.path("large.xyz");
        fs::write(&path, &text).unwrap();
        let child = place.start("ballstick info large.xyz");
        std::thread::sleep(after);
        match index % 3 {
            0 => fs::File::options().write(true).open(&path).unwrap().set_len(100_000).unwrap(),
            1 => fs::remove_file(&path).unwrap(),
            _ => fs::write(&path, "1\nanother\nHe 0 0 0\n").unwrap(),
        }
        let output = child.wait_with_output().unwrap();
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 1)) && !err.contains("panicked"), "{:?} {err}", output.status);
    }
}

#[test]
fn help_tells_the_exit_statuses() {
    let help = Place::new().run("ballstick --help", 0);
    let help = String::from_utf8_lossy(&help.0.stdout).into_owned();
    assert!(help.contains("Exit status: 0 done") && help.contains("130"), "{help}");
}

#[test]
fn a_weak_device_or_none_draws_the_picture_and_says_who_did() {
    let place = Place::new();
    let draw = |flags: &str| {
        let line = format!("ballstick render methane.xyz -o a.png --size 64x48 --quality draft --timings {flags}");
        let said = place.run(&line, 0).err();
        assert!(is_whole_png(&place.path("a.png")), "{said}");
        said
    };
    let weak = draw("--renderer gpu --limits downlevel");
    let is_device = weak.contains("\"renderer\":\"gpu: ");
    assert!(is_device || weak.contains("the CPU renderer takes over"), "{weak}");
    // An interface that no machine of this kind has.
    let none = place.run(
        "WGPU_BACKEND=none ballstick render methane.xyz -o b.png --size 64x48 --quality draft --renderer gpu --timings",
        0,
    );
    assert!(
        none.err().contains("the CPU renderer takes over") && none.err().contains("\"renderer\":\"cpu\""),
        "{}",
        none.err()
    );
    assert!(draw("--renderer cpu --limits downlevel").contains("\"renderer\":\"cpu\""));
    // Drivers do not survive this.
    let line = "ballstick render methane.xyz -o c.png --size 64x48 --quality draft --renderer gpu";
    let little = place.run(&format!("ulimit -v 700000 2>/dev/null || exit 77; {line}"), 0).err();
    assert!(little.contains("ulimit -v") && little.contains("the CPU renderer takes over"), "{little}");
}
