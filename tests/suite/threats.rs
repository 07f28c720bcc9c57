//! The table of threats in the crate docs: every test that it names is there. And those threats that no other test is about.

use super::cli::{Case, METHANE, WATER};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Names of functions under `#[test]` (or proptest's macro) in a folder.
fn tests_in(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            tests_in(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let mut is_test = false;
            for line in text.lines().map(str::trim) {
                if line == "#[test]" {
                    is_test = true;
                } else if let Some(name) = line.strip_prefix("fn ").filter(|_| is_test) {
                    found.insert(name.split('(').next().unwrap().to_owned());
                    is_test = false;
                }
            }
        }
    }
}

#[test]
fn every_threat_has_a_test_that_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut tests = BTreeSet::new();
    tests_in(&root.join("src"), &mut tests);
    tests_in(&root.join("tests/suite"), &mut tests);
    assert!(tests.len() > 500, "only {} tests were found", tests.len());
    let table = fs::read_to_string(root.join("src/threats.md")).unwrap();
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with('|')).skip(2).collect();
    assert!(rows.len() > 20, "{} rows", rows.len());
    for row in rows {
        let last = row.trim_end_matches('|').rsplit('|').next().unwrap();
        let named: Vec<&str> = last.split('`').skip(1).step_by(2).collect();
        assert!(!named.is_empty(), "no test: {row}");
        for name in named {
            assert!(tests.contains(name), "{name} is no test: {row}");
        }
    }
}

#[cfg(unix)]
#[test]
fn devices_that_never_end_are_refused() {
    let case = Case::new(&[]);
    for arguments in [
        &["info", "/dev/zero"][..],
        &["convert", "/dev/zero", "a.json"],
        &["render", "/dev/zero", "-o", "a.png"],
        &["render", "--from", "/dev/zero", "-o", "a.png"],
        &["render", "sample:caffeine", "--overlay", "/dev/zero", "-o", "a.png", "--renderer", "cpu"],
    ] {
        let run = case.run(arguments).status(1);
        assert!(run.err().contains("/dev/zero"), "{}", run.err());
    }
    assert!(case.names("").is_empty());
}

/// To open a pipe that nobody writes to waits for ever.
#[cfg(unix)]
#[test]
fn pipes_that_files_name_are_not_waited_for() {
    let mesh = "mtllib pipe.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    let case = Case::new(&[("water.xyz", WATER), ("mesh.obj", mesh)]);
    let draw = ["-o", "a.png", "--size", "16x12", "--renderer", "cpu", "--quality", "draft"];
    case.run(&[&["render", "water.xyz"][..], &draw].concat()).status(0);
    case.run(&["convert", "a.png", "-o", "good.glb"]).status(0);
    let pipe =
        |name: &str| assert!(std::process::Command::new("mkfifo").arg(case.path(name)).status().unwrap().success());
    pipe("pipe.mtl");
    let run = case.run(&[&["render", "water.xyz", "--overlay", "mesh.obj"][..], &draw].concat());
    assert!(run.err().contains("pipe.mtl"), "{}", run.err());
    fs::remove_file(case.path("water.xyz")).unwrap();
    pipe("water.xyz");
    let run = case.run(&["render", "--from", "a.png", "-o", "b.png"]).status(1);
    assert!(run.err().contains("which is no file"), "{}", run.err());
}

#[test]
fn sessions_cannot_ask_for_what_flags_refuse() {
    let case = Case::new(&[("water.xyz", WATER), ("methane.xyz", METHANE)]);
    case.run(&["render", "water.xyz", "-o", "a.png", "--size", "16x12", "--renderer", "cpu"]).status(0);
    // What a picture says of itself is a session; the text chunk has it as it is.
    let bytes = fs::read(case.path("a.png")).unwrap();
    let start = bytes.windows(9).position(|window| window == b"{\"ballsti").unwrap();
    let length = u32::from_be_bytes(bytes[start - 26..start - 22].try_into().unwrap()) as usize;
    let text = &bytes[start..start + length - "ballstick-session\0".len()];
    let good: serde_json::Value = serde_json::from_slice(text).unwrap();
    let render = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut session = good.clone();
        change(&mut session);
        fs::write(case.path("s.json"), session.to_string()).unwrap();
        case.run(&["render", "s.json", "-o", "b.png"])
    };
    render(&|_| ()).status(0);
    fs::remove_file(case.path("b.png")).unwrap();
    let set = |path: &'static str, value: serde_json::Value| {
        move |session: &mut serde_json::Value| *session.pointer_mut(path).unwrap() = value.clone()
    };
    let many = serde_json::json!(vec![[[1, 1], [1, 2]]; 20_000]);
    for (path, value, status) in [
        ("/files/0/path", serde_json::json!("methane.xyz"), 1), // another file: another sum
        ("/files/0/path", serde_json::json!("/etc/passwd"), 1),
        ("/files/0/path", serde_json::json!("\u{1b}[31mred.xyz"), 1),
        ("/show", serde_json::json!(["(".repeat(50_000)]), 1),
        ("/show", serde_json::json!(["not ".repeat(50_000)]), 1),
        ("/supercell", serde_json::json!([4_000_000_000u32, 1, 1]), 1),
        ("/ball_scale", serde_json::json!(1e30), 1),
        ("/label_size", serde_json::json!(1e300), 1),
        ("/camera", serde_json::json!("nan,nan,nan"), 1),
        ("/background", serde_json::json!("white --output=elsewhere.png"), 1),
        ("/measurements", serde_json::json!([[[1, 4_294_967_295u32], [1, 1]]]), 1),
        ("/measurements", many, 1),
        ("/picture/size", serde_json::json!("99999999x99999999"), 2),
        ("/picture/samples", serde_json::json!(4_000_000_000u32), 2),
        ("/picture/turntable", serde_json::json!(4_000_000_000u32), 2),
    ] {
        let run = render(&set(path, value)).status(status);
        assert!(!run.err().contains('\u{1b}') && !run.err().contains("panicked"), "{path}: {}", run.err());
    }
    let deep = format!("{{\"ballstick_session\":1,\"files\":{}", "[".repeat(100_000));
    fs::write(case.path("s.json"), deep).unwrap();
    case.run(&["render", "--from", "s.json", "-o", "b.png"]).status(1);
    assert_eq!(case.names(""), ["a.png", "methane.xyz", "s.json", "water.xyz"]);
}
