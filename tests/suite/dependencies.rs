//! What the program is built of: licences, the Rust that all of it needs, and no graphics where none is asked for. `deny.toml` says the same
//! to `cargo deny`, which knows of advisories as well.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// What cargo says, without asking a network; `None` if it cannot tell here.
fn cargo(arguments: &[&str]) -> Option<String> {
    let cargo = option_env!("CARGO").unwrap_or("cargo");
    let output = Command::new(cargo).args(arguments).arg("--offline").current_dir(env!("CARGO_MANIFEST_DIR")).output();
    match output {
        Ok(output) if output.status.success() => Some(String::from_utf8(output.stdout).unwrap()),
        failed => {
            println!("SKIP: cargo {arguments:?}: {failed:?}");
            None
        }
    }
}

/// The packages of the program itself, without those of its tests.
fn packages() -> Option<Vec<Value>> {
    let metadata: Value =
        serde_json::from_str(&cargo(&["metadata", "--format-version", "1", "--all-features"])?).unwrap();
    let packages = metadata["packages"].as_array().unwrap().clone();
    assert!(packages.len() > 100);
    Some(packages)
}

/// Whether one of the alternatives of an SPDX expression has only licences of the list.
fn allows(expression: &str, allowed: &[String]) -> bool {
    let whole = expression.replace('/', " OR ").replace(['(', ')'], " ");
    // `AND` binds first; the few expressions with brackets have them around alternatives, which must then all do.
    let strict = expression.contains('(');
    let mut alternatives = whole
        .split(" OR ")
        .map(|alternative| alternative.split(" AND ").all(|name| allowed.iter().any(|allowed| allowed == name.trim())));
    if strict { alternatives.all(|good| good) } else { alternatives.any(|good| good) }
}

#[test]
fn every_licence_lets_the_program_be_given_away() {
    let Some(packages) = packages() else { return };
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("deny.toml")).unwrap();
    let list = text.split("allow = [").nth(1).unwrap().split(']').next().unwrap();
    let allowed: Vec<String> = list.split('"').skip(1).step_by(2).map(str::to_owned).collect();
    assert!(allowed.len() > 5 && allows("MIT/Apache-2.0", &allowed) && !allows("MIT AND GPL-3.0-only", &allowed));
    for package in packages {
        let licence = package["license"].as_str().unwrap_or_default();
        assert!(allows(licence, &allowed), "{} {}: {licence:?}", package["name"], package["version"]);
    }
}

#[test]
fn no_dependency_needs_a_newer_rust_than_we_say() {
    let Some(packages) = packages() else { return };
    let number = |text: &str| -> Vec<u32> { text.split('.').map(|part| part.parse().unwrap()).collect() };
    let ours = number(env!("CARGO_PKG_RUST_VERSION"));
    for package in packages {
        if let Some(theirs) = package["rust_version"].as_str() {
            assert!(
                number(theirs).into_iter().take(2).le(ours.iter().copied().take(2)),
                "{} needs Rust {theirs}",
                package["name"]
            );
        }
    }
}

#[test]
fn without_its_features_the_library_has_neither_graphics_nor_windows() {
    let tree = |features: &[&str]| cargo(&[&["tree", "--edges", "normal", "--prefix", "none"][..], features].concat());
    let (Some(plain), Some(full)) = (tree(&["--no-default-features"]), tree(&[])) else { return };
    for name in ["wgpu", "winit", "egui", "softbuffer", "arboard", "naga"] {
        let has = |tree: &str| tree.lines().any(|line| line.split(' ').next() == Some(name));
        assert!(has(&full) && !has(&plain), "{name}");
    }
    println!("{} packages of {}", plain.lines().count(), full.lines().count());
}
