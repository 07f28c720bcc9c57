//! Many pictures in one run of the program: shares, what is there already, failures, and the summary.

use crate::cli::{Case, METHANE, Run, WATER};
use std::fs;
use std::time::{Duration, SystemTime};

/// Twelve files, the third and the seventh broken.
fn case() -> (Case, Vec<String>) {
    let names: Vec<String> = (1..=12).map(|n| format!("m{n:02}.xyz")).collect();
    let text = |n: usize| match n {
        3 | 7 => "no molecule\n",
        n if n % 2 == 0 => WATER,
        _ => METHANE,
    };
    let files: Vec<(&str, &str)> = (1..).zip(&names).map(|(n, name)| (name.as_str(), text(n))).collect();
    (Case::new(&files), names)
}

fn run(case: &Case, names: &[String], more: &[&str]) -> Run {
    let mut line = vec!["render"];
    line.extend(names.iter().map(String::as_str));
    line.extend(["-o", "out/", "--size", "48x32", "--quality", "draft", "--renderer", "cpu"]);
    line.extend(more);
    case.run(&line)
}

#[test]
fn every_failure_is_named_once_and_the_summary_counts() {
    let (case, names) = case();
    let said = run(&case, &names, &[]).status(1).err();
    assert_eq!(case.names("out").len(), 10);
    for name in ["m03.xyz", "m07.xyz"] {
        assert_eq!(said.lines().filter(|line| line.contains(name)).count(), 1, "{said}");
    }
    assert!(said.lines().last().unwrap().starts_with("ballstick: 10 drawn, 0 skipped, 2 failed in "), "{said}");
    assert_eq!(said.lines().count(), 3, "{said}");
}

#[test]
fn pictures_of_a_batch_are_those_of_single_runs() {
    let (case, names) = case();
    let _ = run(&case, &names, &[]).status(1);
    for name in ["m01", "m02"] {
        let batch = fs::read(case.path(&format!("out/{name}.png"))).unwrap();
        let _ = run(&case, &[format!("{name}.xyz")], &[]).status(0);
        assert!(batch == fs::read(case.path(&format!("out/{name}.png"))).unwrap(), "{name}");
    }
}

#[test]
fn what_is_there_is_skipped_unless_its_file_is_newer() {
    let (case, names) = case();
    let _ = run(&case, &names, &[]).status(1);
    fs::remove_file(case.path("out/m05.png")).unwrap();
    fs::write(case.path("out/m06.png"), b"\x89PNG\r\n\x1a\n cut off in the middle").unwrap();
    let later = SystemTime::now() + Duration::from_secs(3600);
    fs::File::options().write(true).open(case.path("m08.xyz")).unwrap().set_modified(later).unwrap();
    let said = run(&case, &names, &["--skip-existing"]).status(1).err();
    assert!(said.contains("ballstick: 3 drawn, 7 skipped, 2 failed in "), "{said}");
    assert_eq!(case.names("out").len(), 10);
}

#[test]
fn shares_make_all_pictures_together_and_none_twice() {
    let (case, names) = case();
    let mut all = 0;
    for share in ["1/3", "2/3", "3/3"] {
        let _ = run(&case, &names, &["--shard", share]);
        let there = case.names("out").len();
        assert!(there - all >= 3, "{share}: {all} {there}");
        all = there;
    }
    assert_eq!(all, 10);
    let alone = case.run(&["render", "m01.xyz", "-o", "one.png", "--shard", "1/2"]).status(2).err();
    assert!(alone.contains("--shard needs one picture of each FILE"), "{alone}");
}
