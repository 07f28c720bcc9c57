//! Every example runs and prints what it promises. They are built by `cargo test`; where only this binary was built, they are skipped.

use std::path::PathBuf;
use std::process::Command;

/// What is in the output of each with no arguments.
const EXAMPLES: [(&str, &str); 9] = [
    ("bonds", "from file"),
    ("channels", "pixels"),
    ("crystal", "2 × 2 × 2 cells: "),
    ("film", "turn.gif"),
    ("many_files", "2 of 3 files"),
    ("mesh", " triangles"),
    ("picture", "picture.png by "),
    ("selection", "SG"),
    ("trajectory", "Å"),
];

#[test]
fn every_example_runs() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    // This is target/PROFILE/deps/suite-…; examples are in target/PROFILE/examples.
    let built = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("examples");
    let mut there: Vec<String> = std::fs::read_dir(root.join("examples"))
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    there.sort();
    assert_eq!(there, EXAMPLES.map(|(name, _)| name), "every example stands in the list of this test");
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (name, promised) in EXAMPLES {
        assert!(readme.contains(&format!("examples/{name}.rs")), "{name} is not in the README");
        let program = built.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
        if !program.exists() {
            println!("SKIP {name}: it was not built");
            continue;
        }
        let output = Command::new(program).current_dir(&root).env("TMPDIR", folder.path()).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && text.contains(promised), "{name}: {text}\n{said}");
    }
}
