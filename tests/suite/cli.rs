//! The program itself, run in a folder of its own: output, exit status, standard input and output, what is left behind.

use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

pub(crate) const WATER: &str = "3\nwater\nO 0.000 0.000 0.117\nH 0.000 0.757 -0.470\nH 0.000 -0.757 -0.470\n";
pub(crate) const METHANE: &str =
    "5\nmethane\nC 0 0 0\nH 0.63 0.63 0.63\nH -0.63 -0.63 0.63\nH -0.63 0.63 -0.63\nH 0.63 -0.63 -0.63\n";
const TWO_FRAMES: &str = "1\nfirst\nAr 0 0 0\n1\nsecond\nAr 1 2 3\n";
const SALT: &str = "2\nLattice=\"4 0 0 0 4 0 0 0 4\" Properties=species:S:1:pos:R:3\nNa 0 0 0\nCl 2 0 0\n";
const PEPTIDE: &str = "\
ATOM      1  N   GLY A   1      -1.195   0.201  -0.206  1.00 10.00           N  \n\
ATOM      2  CA  GLY A   1       0.230   0.318  -0.502  1.00 10.00           C  \n\
ATOM      3  C   GLY A   1       1.059  -0.390   0.542  1.00 10.00           C  \n\
ATOM      4  O   GLY A   1       0.545  -0.975   1.499  1.00 10.00           O  \n\
HETATM    5  O   HOH B 101      10.000  10.000  10.000  1.00 10.00           O  \n\
END\n";

pub(crate) struct Case {
    folder: TempDir,
}

impl Case {
    pub(crate) fn new(files: &[(&str, &str)]) -> Case {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            fs::write(folder.path().join(name), text).unwrap();
        }
        Case { folder }
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Run {
        self.run_with_input(arguments, "")
    }

    fn run_with_input(&self, arguments: &[&str], input: &str) -> Run {
        let mut child = Command::new(env!("CARGO_BIN_EXE_ballstick"))
            .args(arguments)
            .current_dir(self.folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdin.take().unwrap().write_all(input.as_bytes())); // who does not read it may be gone
        Run(child.wait_with_output().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Names in the folder, hidden ones as well.
    pub(crate) fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

pub(crate) struct Run(Output);

impl Run {
    #[track_caller]
    pub(crate) fn status(self, expected: i32) -> Run {
        assert_eq!(self.0.status.code(), Some(expected), "\n{}\n{}", self.out(), self.err());
        self
    }

    pub(crate) fn out(&self) -> String {
        String::from_utf8_lossy(&self.0.stdout).into_owned()
    }

    pub(crate) fn err(&self) -> String {
        String::from_utf8_lossy(&self.0.stderr).into_owned()
    }

    #[track_caller]
    fn says(self, text: &str) -> Run {
        assert!(self.err().contains(text), "{text:?} is not in\n{}", self.err());
        self
    }

    fn objects(&self) -> Vec<Value> {
        self.out().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}

#[test]
fn info_json_has_exactly_the_promised_keys() {
    let case = Case::new(&[("water.xyz", WATER)]);
    let run = case.run(&["info", "water.xyz", "--json"]).status(0);
    let keys: Vec<&str> = vec![
        "path",
        "format",
        "title",
        "atoms",
        "bonds",
        "bond_orders",
        "elements",
        "formula",
        "chains",
        "residues",
        "frames",
        "cell",
        "diagnostics",
    ];
    let object = &run.objects()[0];
    let mut found: Vec<&str> = object.as_object().unwrap().keys().map(String::as_str).collect();
    let mut expected = keys.clone();
    found.sort_unstable();
    expected.sort_unstable();
    assert_eq!(found, expected);
    let expected = serde_json::json!({
        "path": "water.xyz", "format": "xyz", "title": "water", "atoms": 3, "bonds": 2,
        "bond_orders": {"1": 2, "2": 0, "3": 0, "aromatic": 0}, "elements": {"H": 2, "O": 1}, "formula": "H2O",
        "chains": 0, "residues": 0, "frames": 1, "cell": null, "diagnostics": []
    });
    assert_eq!(*object, expected);
    assert_eq!(run.err(), "");
}

#[test]
fn info_counts_chains_residues_frames_and_the_cell() {
    let case = Case::new(&[("p.pdb", PEPTIDE), ("two.xyz", TWO_FRAMES), ("salt.xyz", SALT)]);
    let objects = case.run(&["info", "--json", "p.pdb", "two.xyz", "salt.xyz"]).status(0).objects();
    assert_eq!((&objects[0]["chains"], &objects[0]["residues"]), (&2.into(), &2.into()));
    assert_eq!(objects[0]["formula"], "C2NO2");
    assert_eq!((&objects[1]["frames"], &objects[1]["atoms"]), (&2.into(), &1.into()));
    let cell = &objects[2]["cell"];
    assert_eq!((cell["a"].as_f64(), cell["gamma"].as_f64()), (Some(4.0), Some(90.0)));
}

#[test]
fn info_for_people_is_on_standard_output_and_warnings_are_not() {
    let case = Case::new(&[("water.xyz", WATER)]);
    let run = case.run(&["info", "water.xyz"]).status(0);
    assert!(run.out().starts_with("water.xyz: water\n"), "{}", run.out());
    assert!(run.out().contains("H2O") && run.out().contains("2 single"), "{}", run.out());
}

#[test]
fn one_bad_file_does_not_stop_info_and_has_a_line_of_its_own() {
    let case = Case::new(&[("bad.xyz", "this is no molecule\n"), ("water.xyz", WATER)]);
    let run = case.run(&["info", "--json", "bad.xyz", "none.xyz", "water.xyz"]).status(1).says("bad.xyz");
    let objects = run.objects();
    assert_eq!(objects.len(), 3);
    assert_eq!(objects[0]["path"], "bad.xyz");
    assert!(objects[0]["error"]["message"].is_string() && objects[0]["error"].get("line").is_some());
    assert!(objects[1]["error"]["message"].as_str().unwrap().contains("none.xyz"));
    assert_eq!(objects[2]["formula"], "H2O");
}

#[test]
fn standard_input_and_output_are_a_dash() {
    let case = Case::new(&[]);
    let info = case.run_with_input(&["info", "-", "--json"], WATER).status(0);
    assert_eq!((&info.objects()[0]["path"], &info.objects()[0]["atoms"]), (&"-".into(), &3.into()));
    let xyz = case.run_with_input(&["convert", "-", "-", "--to", "xyz"], WATER).status(0);
    assert!(xyz.out().starts_with("3\nwater\nO "), "{}", xyz.out());
    assert!(case.names("").is_empty());
}

#[test]
fn convert_writes_our_json_with_the_files_own_digits() {
    let case = Case::new(&[("water.xyz", WATER)]);
    let run = case.run(&["convert", "water.xyz", "water.json"]).status(0);
    assert_eq!((run.out(), run.err()), (String::new(), String::new()));
    assert!(case.read("water.json").contains("\"position\":[0.000,0.757,-0.470]"));
    let json: Value = serde_json::from_str(&case.read("water.json")).unwrap();
    assert_eq!(json["bonds"].as_array().unwrap().len(), 2);
    let expected = serde_json::json!(
        {"atoms": [0, 1], "order": 1, "kind": "covalent", "aromatic": false, "source": "distance"}
    );
    assert_eq!(json["bonds"][0], expected);
    assert_eq!(json["cell"], Value::Null);
    case.run(&["convert", "water.xyz", "none.json", "--bonds", "none"]).status(0);
    let json: Value = serde_json::from_str(&case.read("none.json")).unwrap();
    assert_eq!(json["bonds"], serde_json::json!([]));
}

#[test]
fn json_converts_back_to_the_same_molecule() {
    let case = Case::new(&[("p.pdb", PEPTIDE), ("salt.xyz", SALT)]);
    for name in ["p.pdb", "salt.xyz"] {
        case.run(&["convert", name, "one.json"]).status(0);
        case.run(&["convert", "one.json", "two.json"]).status(0);
        let read = |name: &str| -> Value { serde_json::from_str(&case.read(name)).unwrap() };
        let (one, two) = (read("one.json"), read("two.json"));
        for key in ["atoms", "bonds", "cell"] {
            assert_eq!(one[key], two[key], "{name} {key}");
        }
    }
}

#[test]
fn convert_writes_every_format_from_standard_input() {
    let case = Case::new(&[]);
    for name in ["a.sdf", "a.mol", "a.mol2", "a.pdb", "a.ent", "a.cjson", "a.extxyz", "a.xyz", "a.json"] {
        case.run_with_input(&["convert", "-", name], WATER).status(0);
        let info = case.run(&["info", "--json", name]).status(0);
        let object = &info.objects()[0];
        assert_eq!((&object["atoms"], &object["bonds"]), (&3.into(), &2.into()), "{name}");
    }
    let v3000 = case.run_with_input(&["convert", "-", "-", "--to", "sdf-v3000"], WATER).status(0);
    assert!(v3000.out().contains("M  V30 COUNTS 3 2 0 0 0"), "{}", v3000.out());
}

#[test]
fn convert_takes_records_and_the_format_of_its_input() {
    let case = Case::new(&[("two.xyz", "1\na\nHe 0 0 0\n1\nb\nNe 0 0 0\n")]);
    case.run(&["convert", "two.xyz", "all.sdf"]).status(0);
    case.run(&["convert", "two.xyz", "same.sdf", "--record", "all"]).status(0);
    assert_eq!(case.read("all.sdf"), case.read("same.sdf"));
    let molecules = case.run(&["convert", "all.sdf", "-", "--to", "mol2", "--from", "sdf"]).status(0);
    assert_eq!(molecules.out().matches("@<TRIPOS>MOLECULE").count(), 2);
    let second = case.run(&["convert", "all.sdf", "-", "--to", "xyz", "--record", "2"]).status(0);
    assert!(second.out().starts_with("1\nb\nNe "), "{}", second.out());
    case.run(&["convert", "all.sdf", "x.pdb", "--from", "docx"]).status(2).says("docx").says("mol2");
}

#[test]
fn what_does_not_fit_a_format_is_an_error_that_leaves_nothing() {
    let case = Case::new(&[("far.xyz", "1\n\nC 123456.5 0 0\n")]);
    case.run(&["convert", "far.xyz", "far.pdb"]).status(1).says("atom 1").says("does not fit");
    assert!(!case.path("far.pdb").exists());
    case.run(&["convert", "far.xyz", "far.sdf"]).status(0);
    assert!(case.read("far.sdf").contains("V3000"));
}

#[test]
fn convert_keeps_all_frames_or_says_that_it_does_not() {
    let case = Case::new(&[("two.xyz", TWO_FRAMES)]);
    case.run(&["convert", "two.xyz", "all.xyz"]).status(0);
    assert_eq!(case.read("all.xyz").lines().count(), 6);
    case.run(&["convert", "two.xyz", "second.xyz", "--frame", "2"]).status(0);
    assert!(case.read("second.xyz").starts_with("1\nsecond\n"));
    case.run(&["convert", "two.xyz", "first.json"]).status(0).says("only the first of 2 frames");
    case.run(&["convert", "two.xyz", "third.xyz", "--frame", "3"]).status(1).says("there are only 2");
    assert!(!case.path("third.xyz").exists());
}

#[test]
fn what_a_format_cannot_hold_is_warned_of() {
    let case = Case::new(&[("p.pdb", PEPTIDE)]);
    case.run(&["convert", "p.pdb", "p.xyz"]).status(0).says("residues and chains").says("temperature factors");
}

#[test]
fn a_failed_run_keeps_the_old_file_and_leaves_nothing() {
    let case = Case::new(&[("bad.xyz", "this is no molecule\n")]);
    fs::create_dir(case.path("out")).unwrap();
    fs::write(case.path("out/old.json"), "old").unwrap();
    fs::write(case.path("out/old.png"), "old").unwrap();
    case.run(&["convert", "bad.xyz", "out/old.json"]).status(1);
    case.run(&["render", "bad.xyz", "-o", "out/old.png"]).status(1);
    assert_eq!(case.names("out"), ["old.json", "old.png"]);
    assert_eq!((case.read("out/old.json"), case.read("out/old.png")), ("old".to_owned(), "old".to_owned()));
}

#[test]
fn a_folder_that_is_not_there_or_not_writable_is_an_error_of_that_output() {
    let case = Case::new(&[("water.xyz", WATER)]);
    case.run(&["convert", "water.xyz", "no/such/folder.json"]).status(1).says("there is no folder");
    fs::create_dir(case.path("closed")).unwrap();
    let mut permissions = fs::metadata(case.path("closed")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(case.path("closed"), permissions).unwrap();
    if fs::write(case.path("closed/probe"), "").is_ok() {
        println!("SKIP closed folder: this user may write everywhere");
        return;
    }
    case.run(&["convert", "water.xyz", "closed/a.json"]).status(1).says("closed/a.json");
}

#[cfg(unix)]
#[test]
fn special_files_are_written_directly() {
    let case = Case::new(&[("water.xyz", WATER)]);
    case.run(&["convert", "water.xyz", "/dev/null", "--to", "json"]).status(0);
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
    let run = case.run(&["convert", "water.xyz", "/dev/stdout", "--to", "xyz"]).status(0);
    assert!(run.out().starts_with("3\n"));
}

#[test]
fn wrong_command_lines_end_with_2_and_write_nothing() {
    let case = Case::new(&[("water.xyz", WATER)]);
    for arguments in [
        &["render", "water.xyz"][..],
        &["render", "-o", "a.png"],
        &["render", "water.xyz", "-o", "a.tiff"],
        &["render", "water.xyz", "-o", "a"],
        &["render", "water.xyz", "-o", "a.png", "--size", "big"],
        &["render", "water.xyz", "-o", "a.png", "--ao", "257"],
        &["render", "water.xyz", "-o", "a.png", "--region", "0,0,9999,1"],
        &["render", "water.xyz", "-o", "a.jpg", "--channel", "depth"],
        &["render", "water.xyz", "-o", "a.png", "--frame", "0"],
        &["render", "-", "-", "-o", "out/"],
        &["convert", "water.xyz"],
        &["convert", "water.xyz", "a.docx"],
        &["convert", "water.xyz", "-"],
        &["convert", "water.xyz", "a.json", "--to", "docx"],
        &["info"],
        &["info", "water.xyz", "--nonsense"],
        &["water.xyz", "--nonsense"],
    ] {
        let run = case.run(arguments);
        assert_eq!(run.0.status.code(), Some(2), "{arguments:?}\n{}", run.err());
        assert!(run.out().is_empty() && !run.err().is_empty(), "{arguments:?}");
    }
    // With a window, nothing at all opens one that shows how to open something.
    if !cfg!(feature = "window") {
        assert_eq!(case.run(&[]).0.status.code(), Some(2));
    }
    assert_eq!(case.names(""), ["water.xyz"]);
}

#[test]
fn unknown_extensions_are_named_with_the_known_ones() {
    let case = Case::new(&[("water.xyz", WATER)]);
    case.run(&["render", "water.xyz", "-o", "a.tiff"]).status(2).says(".tiff").says(".webp");
    case.run(&["convert", "water.xyz", "a.docx"]).status(2).says("docx").says("json, cjson");
}

#[test]
fn help_and_version_are_results() {
    let case = Case::new(&[]);
    for arguments in [&["--help"][..], &["render", "--help"], &["info", "-h"], &["--version"]] {
        let run = case.run(arguments).status(0);
        assert!(run.out().contains("ballstick") && run.err().is_empty(), "{arguments:?}");
    }
    let help = case.run(&["render", "--help"]).out();
    assert!(help.contains("near_angstrom") && help.contains("{stem}"), "{help}");
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let case = Case::new(&[("water.xyz", WATER)]);
    let mut arguments = vec!["info", "--json"];
    arguments.extend(std::iter::repeat_n("water.xyz", 2000)); // more than a pipe holds
    let mut child = Command::new(env!("CARGO_BIN_EXE_ballstick"))
        .args(arguments)
        .current_dir(case.folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let run = Run(child.wait_with_output().unwrap()).status(0);
    assert_eq!(run.err(), "");
}

/// Small and quick: what is drawn is tested elsewhere.
const QUICK: [&str; 5] = ["--renderer=cpu", "--quality=draft", "--size=64x48", "--no-ground", "--timings"];

fn render(case: &Case, arguments: &[&str]) -> Run {
    let all: Vec<&str> = ["render"].iter().chain(&QUICK).chain(arguments).copied().collect();
    case.run(&all)
}

fn png_size(path: &Path) -> (u32, u32) {
    let file = fs::read(path).unwrap();
    assert_eq!(&file[..8], b"\x89PNG\r\n\x1a\n");
    let word = |at: usize| u32::from_be_bytes(file[at..at + 4].try_into().unwrap());
    (word(16), word(20))
}

#[test]
fn a_batch_draws_one_picture_each_and_one_bad_file_does_not_stop_it() {
    let case = Case::new(&[("bad.xyz", "this is no molecule\n"), ("water.xyz", WATER), ("methane.xyz", METHANE)]);
    let run = render(&case, &["bad.xyz", "water.xyz", "methane.xyz", "-o", "new/"]).status(1).says("bad.xyz");
    assert_eq!(case.names("new"), ["methane.png", "water.png"]);
    assert_eq!(png_size(&case.path("new/water.png")), (64, 48));
    assert_eq!(run.out(), "");
    let timings: Vec<Value> = run
        .err()
        .lines()
        .filter(|line| line.starts_with('{'))
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(timings.len(), 2);
    for key in ["read", "bonds", "scene", "render", "encode", "total"] {
        assert!(timings[0][key].as_f64().is_some_and(|seconds| seconds >= 0.0), "{key}");
    }
    // Those of several files come as they are done.
    let of = |name: &str| timings.iter().find(|one| one["output"] == name).unwrap();
    let methane = of("new/methane.png");
    assert_eq!((&methane["atom_count"], &methane["bond_count"]), (&5.into(), &4.into()));
}

#[test]
fn all_formats_are_what_their_names_say() {
    let case = Case::new(&[("water.xyz", WATER)]);
    for (name, magic) in [
        ("a.png", &b"\x89PNG"[..]),
        ("a.jpg", b"\xFF\xD8\xFF"),
        ("a.webp", b"RIFF"),
        ("a.ppm", b"P6"),
        ("a.npy", b"\x93NUMPY"),
    ] {
        render(&case, &["water.xyz", "-o", name]).status(0);
        assert!(fs::read(case.path(name)).unwrap().starts_with(magic), "{name}");
    }
}

#[test]
fn a_region_is_that_part_of_the_full_picture() {
    let case = Case::new(&[("water.xyz", WATER)]);
    render(&case, &["water.xyz", "-o", "full.ppm"]).status(0);
    render(&case, &["water.xyz", "-o", "part.ppm", "--region", "10,20,30,8"]).status(0);
    let pixels = |name: &str, bytes: usize| {
        let file = fs::read(case.path(name)).unwrap();
        file[file.len() - bytes..].to_vec()
    };
    let (full, part) = (pixels("full.ppm", 64 * 48 * 3), pixels("part.ppm", 30 * 8 * 3));
    for y in 0..8 {
        let start = ((y + 20) * 64 + 10) * 3;
        assert_eq!(part[y * 90..(y + 1) * 90], full[start..start + 90], "row {y}");
    }
    assert!(full.iter().any(|&value| value != full[0]), "nothing is drawn");
}

#[test]
fn text_is_written_and_what_cannot_be_labelled_is_said() {
    let case = Case::new(&[("water.xyz", WATER), ("peptide.pdb", PEPTIDE)]);
    let flags = ["--size", "96x64", "--samples", "1", "--ao", "0"];
    let picture = |file: &str, more: &[&str]| {
        let arguments = [&["render", file, "-o", "out.ppm", "--renderer", "cpu"], &flags[..], more].concat();
        (case.run(&arguments).status(0).err(), fs::read(case.path("out.ppm")).unwrap())
    };
    let plain = picture("water.xyz", &[]);
    assert_eq!(plain, picture("water.xyz", &["--label", "none"]));
    for more in [&["--label", "element,index"][..], &["--label=name"], &["--legend"], &["--scale-bar"]] {
        let (said, bytes) = picture("water.xyz", more);
        assert!(said.is_empty() && bytes != plain.1, "{more:?}: {said}");
    }
    assert!(picture("water.xyz", &["--label", "residue"]).0.contains("the file gives no residues"));
    assert_eq!(picture("peptide.pdb", &["--label", "residue"]).0, "");
}

#[test]
fn pictures_and_channels_go_to_standard_output() {
    let case = Case::new(&[("water.xyz", WATER)]);
    let run = render(&case, &["water.xyz", "-o", "-"]).status(0);
    assert!(run.0.stdout.starts_with(b"\x89PNG"));
    let run = render(&case, &["water.xyz", "-o", "-", "--to", "npy", "--channel", "id"]).status(0);
    assert!(run.0.stdout.starts_with(b"\x93NUMPY"));
    let ids: Vec<u8> = run.0.stdout[run.0.stdout.len() - 64 * 48 * 4..].to_vec();
    let seen: std::collections::BTreeSet<u32> =
        ids.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
    assert!(seen.contains(&0) && seen.contains(&1) && seen.iter().all(|&id| id <= 5), "{seen:?}");
    assert_eq!(case.names(""), ["water.xyz"]);
}

#[test]
fn a_transparent_background_is_flattened_with_a_warning_where_the_format_has_none() {
    let case = Case::new(&[("water.xyz", WATER)]);
    render(&case, &["water.xyz", "-o", "a.jpg", "--background", "transparent"]).status(0).says("background is white");
}

#[test]
fn two_inputs_of_one_name_do_not_overwrite_each_other() {
    let case = Case::new(&[("water.xyz", WATER)]);
    fs::create_dir(case.path("other")).unwrap();
    fs::write(case.path("other/water.xyz"), METHANE).unwrap();
    let run = render(&case, &["water.xyz", "other/water.xyz", "-o", "{stem}.png"]).status(1).says("already");
    assert!(run.err().contains("\"atom_count\":3"), "{}", run.err());
    assert!(!run.err().contains("\"atom_count\":5"), "{}", run.err());
}

#[test]
fn an_axis_without_a_cell_is_an_error_that_says_what_to_do() {
    let case = Case::new(&[("water.xyz", WATER), ("salt.xyz", SALT)]);
    render(&case, &["water.xyz", "-o", "a.png", "--axis", "111"]).status(1).says("--view");
    render(&case, &["salt.xyz", "-o", "a.png", "--axis", "1,-1,0"]).status(0);
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    let case = Case::new(&[("methane.xyz", METHANE)]);
    let picture = || {
        render(&case, &["methane.xyz", "-o", "a.png"]).status(0);
        fs::read(case.path("a.png")).unwrap()
    };
    assert_eq!(picture(), picture());
}

#[test]
fn devices_says_what_auto_uses() {
    let run = Case::new(&[]).run(&["devices"]).status(0);
    assert!(run.out().contains("CPU renderer") && run.out().contains("--renderer auto uses"), "{}", run.out());
}

#[test]
fn records_side_by_side_stand_in_the_order_of_the_file() {
    // Each record is one atom, so ids 1 to 7 are the records: a row of four, a row of three. SD text: 4th line counts, then the atom.
    let record = |symbol: &str| {
        format!(
            "{symbol}\n\n\n  1  0  0  0  0  0  0  0  0  0999 V2000\n    0.0000    0.0000    0.0000 {symbol}   0  0\nM  END\n$$$$\n"
        )
    };
    let case = Case::new(&[("seven.sdf", &["C", "N", "O", "F", "P", "S", "B"].map(record).concat())]);
    let arguments = ["render", "seven.sdf", "--record", "all", "-o", "id.npy", "--channel", "id", "--size", "90x60"];
    assert_eq!(case.run(&[&arguments[..], &["--renderer", "cpu"]].concat()).0.status.code(), Some(0));
    let bytes = fs::read(case.path("id.npy")).unwrap();
    let ids: Vec<u32> =
        bytes[bytes.len() - 90 * 60 * 4..].chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect();
    let middle = |id: u32| {
        let columns: Vec<usize> = (0..ids.len()).filter(|&i| ids[i] == id).map(|i| i % 90).collect();
        assert!(!columns.is_empty(), "record {id} is not in the picture");
        columns.iter().sum::<usize>() / columns.len()
    };
    for row in [&[1, 2, 3, 4][..], &[5, 6, 7]] {
        let places: Vec<usize> = row.iter().map(|&id| middle(id)).collect();
        assert!(places.is_sorted_by(|a, b| a < b), "records {row:?} stand at {places:?}");
    }
}

/// Diamond, one cell.
const DIAMOND: &str = "8\nLattice=\"3.567 0 0 0 3.567 0 0 0 3.567\" Properties=species:S:1:pos:R:3\n\
C 0 0 0\nC 0 1.7835 1.7835\nC 1.7835 0 1.7835\nC 1.7835 1.7835 0\n\
C 0.89175 0.89175 0.89175\nC 0.89175 2.67525 2.67525\nC 2.67525 0.89175 2.67525\nC 2.67525 2.67525 0.89175\n";

#[test]
fn crystals_are_drawn_as_asked_and_listed_as_they_are() {
    let case = Case::new(&[("diamond.xyz", DIAMOND), ("water.xyz", "3\n\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n")]);
    let drawn = |flags: &[&str]| {
        let arguments = ["render", "diamond.xyz", "-o", "a.png", "--size", "40x30", "--renderer", "cpu", "--timings"];
        let run = case.run(&[&arguments[..], flags].concat()).status(0);
        let timings: serde_json::Value = serde_json::from_str(run.err().lines().last().unwrap()).unwrap();
        (timings["atom_count"].as_u64().unwrap(), timings["bond_count"].as_u64().unwrap())
    };
    assert_eq!(drawn(&[]), (18, 16));
    assert_eq!(drawn(&["--cell", "asym"]), (8, 7));
    assert_eq!(drawn(&["--supercell", "2x1x1"]), (31, 32));
    let run = case.run(&["info", "--json", "diamond.xyz"]).status(0);
    let info: serde_json::Value = serde_json::from_str(run.out().trim()).unwrap();
    assert_eq!((info["atoms"].as_u64(), info["bonds"].as_u64()), (Some(8), Some(16)));
    let run = case.run(&["render", "water.xyz", "-o", "b.png", "--size", "9x9", "--supercell", "2x1x1"]).status(0);
    assert!(run.err().contains("no unit cell"), "{}", run.err());
    case.run(&["render", "diamond.xyz", "-o", "c.png", "--supercell", "0x1x1"]).status(2);
}

#[test]
fn convert_writes_the_scene_as_a_mesh_with_the_flags_of_render() {
    let case = Case::new(&[("water.xyz", WATER), ("p.pdb", PEPTIDE), ("salt.xyz", SALT)]);
    for name in ["a.glb", "a.gltf", "a.obj", "a.ply"] {
        case.run(&["convert", "water.xyz", "p.pdb", "-o", name, "--style", "licorice", "--tolerance", "0.05"])
            .status(0);
        assert!(fs::metadata(case.path(name)).unwrap().len() > 1000, "{name}");
    }
    assert!(case.read("a.mtl").contains("newmtl color_"));
    let run = case.run(&["convert", "water.xyz", "water.stl"]).status(0);
    assert!(run.err().contains("the longest side is 100 mm"), "{}", run.err());
    case.run(&["convert", "water.xyz", "-", "--to", "obj"]).status(0);
    // What is drawn, and so what is written, is what the flags say.
    case.run(&["convert", "salt.xyz", "-o", "one.ply", "--cell", "asym", "--no-cell-box"]).status(0);
    case.run(&["convert", "salt.xyz", "-o", "eight.ply", "--supercell", "2x2x2"]).status(0);
    let size = |name: &str| fs::metadata(case.path(name)).unwrap().len();
    assert!(size("eight.ply") > 4 * size("one.ply"));
    case.run(&["convert", "p.pdb", "none.glb", "--show", "chain Q"]).status(1).says("nothing is drawn");
    assert!(!case.path("none.glb").exists());
    case.run(&["convert", "water.xyz", "a.stl", "--compat"]).status(0).says("--compat has no effect on stl");
    case.run(&["convert", "water.xyz", "a.xyz", "--style", "licorice"]).status(0).says("have no effect");
    case.run(&["convert", "water.xyz", "p.pdb", "-o", "a.json"]).status(2).says("give one FILE");
    case.run(&["convert", "water.xyz", "a.glb", "--tolerance", "0"]).status(2).says("0.0001 to 1");
    case.run(&["convert", "missing.xyz", "a2.glb"]).status(1).says("missing.xyz");
}

#[test]
fn an_unknown_colour_is_told_which_was_meant() {
    let case = Case::new(&[("water.xyz", WATER)]);
    let draw = |flags: &[&str]| {
        let start = ["render", "water.xyz", "-o", "a.png", "--size", "20x20", "--quality", "draft"];
        case.run(&[&start[..], flags].concat())
    };
    draw(&["--color", "element O=marine", "--background", "grey90"]).status(0);
    draw(&["--color", "element O=marin"]).status(2).says("did you mean marine?");
    draw(&["--background", "wite"]).status(2).says("did you mean white?");
    draw(&["--outline-color", "stealblue"]).status(2).says("did you mean steelblue?");
}

#[test]
fn what_has_no_effect_or_no_meaning_is_said() {
    let case = Case::new(&[("water.xyz", WATER)]);
    let mesh = |flags: &[&str]| case.run(&[&["convert", "water.xyz", "a.ply"][..], flags].concat()).status(0);
    mesh(&["--fog", "0.5", "--background=red"]).says("--fog, --background are for pictures");
    mesh(&["--look=dark"]).says("--look is for pictures and has no effect");
    assert_eq!(mesh(&["--style=licorice", "--projection=orthographic", "--no-ground"]).err(), "");
    let names = "json, cjson, mmcif, mol2, pdb, sdf, sdf-v3000, xyz, extxyz; and for what would be drawn glb";
    case.run(&["convert", "water.xyz", "b.xyz123"]).status(2).says("xyz123").says(names);
    case.run(&["convert", "water.xyz", "noending"]).status(2).says("noending").says("--to").says(names);
    let level = |name: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ballstick"));
        command.args(["info", "water.xyz"]).current_dir(case.path("")).env("BALLSTICK_SIMD", name);
        Run(command.output().unwrap()).status(0)
    };
    level("avx1024").says("BALLSTICK_SIMD=avx1024 is none of baseline, avx2, avx512");
    assert_eq!((level("baseline").err(), level("").err()), (String::new(), String::new()));
}

#[test]
fn colours_of_another_program_stay() {
    let case = Case::new(&[("water.xyz", WATER), ("house.mtl", "newmtl wall\n"), ("empty.mtl", "")]);
    for name in ["house", "empty"] {
        let run = case.run(&["convert", "water.xyz", "-o", &format!("{name}.obj")]).status(1);
        run.says(&format!("{name}.mtl is there, and ballstick did not write it"));
    }
    assert_eq!(case.read("house.mtl"), "newmtl wall\n");
    assert_eq!(case.names(""), ["empty.mtl", "house.mtl", "water.xyz"]);
    // Its own it replaces, as the OBJ file.
    case.run(&["convert", "water.xyz", "a.obj"]).status(0);
    let before = case.read("a.mtl");
    case.run(&["convert", "water.xyz", "a.obj", "--color=element O=teal"]).status(0);
    assert!(case.read("a.mtl") != before);
}

/// Lists that are broken in the middle of a line are hard to read.
#[test]
fn help_fits_a_terminal_of_80_columns() {
    for command in ["view", "render", "info", "convert", "devices", "manual", "completions", "--version"] {
        for help in ["-h", "--help"] {
            let arguments = if command == "--version" { vec![help] } else { vec![command, help] };
            let run = |columns: &str| {
                let mut line = Command::new(env!("CARGO_BIN_EXE_ballstick"));
                Run(line.args(&arguments).env("COLUMNS", columns).output().unwrap()).status(0).out()
            };
            let [narrow, wide] = ["80", "100"].map(run);
            assert!(narrow.lines().all(|line| line.chars().count() <= 80), "{arguments:?}");
            // What stands below the flags is laid out by hand: the terminal changes nothing.
            let below = |text: &str| text.rsplit_once("Examples:").map(|(_, below)| below.to_owned());
            assert_eq!(below(&narrow), below(&wide), "{arguments:?}");
        }
    }
}
