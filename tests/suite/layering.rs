//! The layers of the crate docs hold: a module imports only from layers before its own; files stay small.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Layers in order; a module may use its own and those of the layers before it, never a sibling of its own layer.
/// `scene` stands before `render`, which stands before `export`, and so on; `main.rs` and `lib.rs` may use all.
const LAYERS: &[&[&str]] = &[
    &["math", "color", "element", "error"],
    &["stop"],
    &["structure"],
    &["import", "bonds"],
    &["crystal"],
    &["select"],
    &["scene"],
    &["render"],
    &["export"],
    &["session"],
    &["cli", "app"],
];

/// Siblings that may use each other all the same, with the reason.
const ALLOWED: &[(&str, &str, &str)] = &[
    ("element", "color", "an element has a colour"),
    ("color", "error", "of a name that is no colour's it is said which was meant"),
    ("cli", "app", "`ballstick FILE` opens the window"),
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn files_under(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files.extend(files_under(&path, extension));
        } else if path.extension().is_some_and(|e| e == extension) {
            files.push(path);
        }
    }
    files
}

/// Code without line comments, so that docs may mention any module.
fn code_of(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The modules named after `prefix` (`crate::`), those in braces included.
fn modules_after(code: &str, prefix: &str) -> Vec<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        let rest = &code[at + prefix.len()..];
        if let Some(group) = rest.strip_prefix('{') {
            let mut depth = 0;
            let mut start = true;
            for (i, c) in group.char_indices() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 0 => break,
                    '}' => depth -= 1,
                    ',' if depth == 0 => start = true,
                    c if depth == 0 && start && c.is_alphabetic() => {
                        found.push(word(&group[i..]));
                        start = false;
                    }
                    _ => {}
                }
            }
        } else {
            found.push(word(rest));
        }
    }
    found
}

fn layer_of(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

/// What `user` may not do with `used`, if anything.
fn violation(user: &str, used: &str) -> bool {
    let (Some(from), Some(to)) = (layer_of(user), layer_of(used)) else { return false };
    let allowed = ALLOWED.iter().any(|(a, b, _)| (*a, *b) == (user, used));
    user != used && !allowed && to >= from
}

#[test]
fn modules_use_only_the_layers_before_their_own() {
    let src = root().join("src");
    let mut checked: BTreeMap<String, usize> = BTreeMap::new();
    let mut wrong = Vec::new();
    for file in files_under(&src, "rs") {
        let relative = file.strip_prefix(&src).unwrap();
        let first = relative.components().next().unwrap().as_os_str().to_string_lossy();
        let user = first.trim_end_matches(".rs").to_owned();
        if user == "lib" || user == "main" {
            continue;
        }
        assert!(layer_of(&user).is_some(), "src/{first} is in no layer: add it to the table and the crate docs");
        let code = code_of(&file);
        // Tests may read a file to have something to work on.
        let code = code.split("#[cfg(test)]").next().unwrap_or("");
        for used in modules_after(code, "crate::") {
            *checked.entry(user.clone()).or_default() += 1;
            if violation(&user, &used) {
                wrong.push(format!("{}: uses crate::{used}", relative.display()));
            }
        }
    }
    assert!(checked.len() >= 8 && checked.values().sum::<usize>() > 100, "too little was checked: {checked:?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_two_renderers_do_not_know_each_other_and_only_gpu_and_screen_know_wgpu() {
    let src = root().join("src");
    let mut seen = 0;
    for file in files_under(&src, "rs") {
        let relative = file.strip_prefix(&src).unwrap().to_string_lossy().replace('\\', "/");
        let code = code_of(&file);
        let uses = |what: &str| code.contains(what);
        if relative.starts_with("render/cpu/") {
            seen += 1;
            assert!(!uses("gpu::") && !uses("wgpu"), "{relative} knows the GPU renderer");
        } else if relative.starts_with("render/gpu/") {
            seen += 1;
            assert!(!uses("cpu::"), "{relative} knows the CPU renderer");
        } else {
            assert!(!uses("wgpu::"), "{relative} knows wgpu; that is for render/gpu");
        }
    }
    assert!(seen > 6, "the renderers were not found");
}

#[test]
fn files_stay_small() {
    let mut lines: Vec<(usize, PathBuf)> = Vec::new();
    for folder in ["src", "tests", "benches"] {
        for file in files_under(&root().join(folder), "rs") {
            lines.push((std::fs::read_to_string(&file).unwrap().lines().count(), file));
        }
    }
    lines.sort();
    let median = lines[lines.len() / 2].0;
    let (most, file) = lines.last().unwrap();
    assert!(*most <= 800, "{} has {most} lines; split it by idea", file.display());
    assert!(median <= 250, "the median file has {median} lines");
    let shaders = files_under(&root().join("shaders"), "wgsl");
    assert!(!shaders.is_empty());
    for file in shaders {
        let count = std::fs::read_to_string(&file).unwrap().lines().count();
        assert!(count <= 250, "{} has {count} lines", file.display());
    }
}

#[test]
fn the_check_itself_sees_violations() {
    assert!(violation("import", "bonds") && violation("scene", "render") && violation("structure", "import"));
    assert!(!violation("render", "scene") && !violation("cli", "export") && !violation("scene", "scene"));
    assert_eq!(modules_after("use crate::{a::{b, c}, d};\nuse crate::e::f;", "crate::"), ["a", "d", "e"]);
}
