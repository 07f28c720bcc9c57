//! Limits of memory (`ulimit -v`, `ulimit -d`): each input is done or refused in words, whatever the limit is.
//!
//! Below some limit the system cannot load the program at all; those are left out by asking for its version.

#![cfg(target_os = "linux")]

use super::cli::METHANE;
use std::fs;
use std::process::Command;

const BALLSTICK: &str = env!("CARGO_BIN_EXE_ballstick");

/// Runs a line of the shell under a limit in KiB; `None` where the limit cannot be set or the program cannot even be loaded.
fn under(option: &str, limit: u32, folder: &std::path::Path, line: &str) -> Option<(i32, String)> {
    let line = format!("ulimit {option} {limit} || exit 77; {BALLSTICK} --version > /dev/null || exit 77; {line}");
    let output = Command::new("sh").arg("-c").arg(&line).current_dir(folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let status = output.status.code().unwrap_or_else(|| panic!("{option} {limit}: {} {said}", output.status));
    (status != 77).then_some((status, said))
}

#[test]
fn every_limit_of_memory_that_is_enough_is_enough() {
    let folder = tempfile::tempdir().unwrap();
    let crambin = concat!(env!("CARGO_MANIFEST_DIR"), "/data/1crn.pdb");
    fs::copy(crambin, folder.path().join("crambin.pdb")).unwrap();
    fs::write(folder.path().join("methane.xyz"), METHANE).unwrap();
    let pictures = ["crambin", "methane"].map(|name| (name, folder.path().join(format!("out/{name}.png"))));
    // With light from afar, as it is drawn without flags.
    let line = format!("{BALLSTICK} render crambin.pdb methane.xyz -o out/ --renderer cpu --size 640x480");
    let [mut drawn, mut refused] = [0, 0];
    for (option, limits) in [("-v", [44_000, 140_000]), ("-d", [2_000, 90_000])] {
        let mut since = [None; 2];
        for limit in (limits[0]..=limits[1]).step_by(6_000) {
            drop(fs::remove_dir_all(folder.path().join("out")));
            let Some((status, said)) = under(option, limit, folder.path(), &line) else { continue };
            let what = format!("{option} {limit}: {said}");
            assert!(!said.contains("panicked") && !said.contains("memory allocation"), "{what}");
            for ((name, picture), since) in pictures.iter().zip(&mut since) {
                if picture.exists() {
                    since.get_or_insert(limit);
                    drawn += 1;
                } else {
                    let is_said = said.contains(name) || said.contains("any work needs");
                    assert!(is_said && said.contains(&format!("ulimit {option}")), "{what}");
                    assert_eq!(*since, None, "less was enough: {what}");
                    refused += 1;
                }
            }
            let is_all = pictures.iter().all(|(_, picture)| picture.exists());
            assert_eq!(status, i32::from(!is_all), "{what}");
        }
        if since == [None; 2] {
            println!("SKIP: {option} holds nobody here");
        }
    }
    assert!(drawn > 8 && refused > 0, "{drawn} {refused}");
}

/// What is drawn with little of everything is the same.
#[test]
fn a_picture_under_a_limit_is_the_same_to_the_last_byte() {
    let folder = tempfile::tempdir().unwrap();
    let crambin = concat!(env!("CARGO_MANIFEST_DIR"), "/data/1crn.pdb");
    let flags = "--renderer cpu --size 1400x900 --samples 16";
    let draw = |sparing: &str| {
        let line = format!("{BALLSTICK} render {crambin} -o a.ppm {flags}");
        let mut command = Command::new("sh");
        command.arg("-c").arg(&line).current_dir(folder.path());
        if !sparing.is_empty() {
            command.env("BALLSTICK_APART", sparing).env("RAYON_NUM_THREADS", "1");
        }
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        fs::read(folder.path().join("a.ppm")).unwrap()
    };
    let usual = draw("");
    assert!(draw("0") == usual && draw("0 sparing") == usual);
}

#[test]
fn what_is_said_under_a_limit_is_said_once() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("methane.xyz"), METHANE).unwrap();
    fs::write(folder.path().join("bad.xyz"), "no molecule\n").unwrap();
    let line = format!("{BALLSTICK} render methane.xyz bad.xyz -o out/ --to jpg --background transparent --size 32x24");
    let Some((status, limited)) = under("-v", 1_000_000, folder.path(), &line) else {
        println!("SKIP: limits cannot be set");
        return;
    };
    let output = Command::new("sh").arg("-c").arg(&line).current_dir(folder.path()).output().unwrap();
    let usual = String::from_utf8_lossy(&output.stderr).into_owned();
    // All but the seconds.
    let lines = |text: &str| -> Vec<String> {
        text.lines().map(|line| line.split(" in ").next().unwrap_or(line).to_owned()).collect()
    };
    assert_eq!((status, lines(&limited)), (1, lines(&usual)));
    let line = format!("{BALLSTICK} info methane.xyz bad.xyz --json; {BALLSTICK} convert methane.xyz bt.json");
    let (status, _) = under("-v", 1_000_000, folder.path(), &line).unwrap();
    assert!(status == 0 && folder.path().join("bt.json").exists());
}
