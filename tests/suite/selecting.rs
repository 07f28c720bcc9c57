//! `--show`, `--hide`, `--color`, `--style`: what is drawn and written of what is selected, and how mistakes are told.

use crate::cli::{Case, WATER};
use std::collections::BTreeSet;

const SITE: &str = "\
ATOM      1  N   GLY A   1      -1.195   0.201  -0.206  1.00 10.00           N  \n\
ATOM      2  CA  GLY A   1       0.230   0.318  -0.502  1.00 10.00           C  \n\
ATOM      3  C   GLY A   1       1.059  -0.390   0.542  1.00 10.00           C  \n\
ATOM      4  O   GLY A   1       0.545  -0.975   1.499  1.00 10.00           O  \n\
HETATM    5  C1  LIG B   1       4.000   0.000   0.000  1.00 10.00           C  \n\
HETATM    6  O1  LIG B   1       5.200   0.000   0.000  1.00 10.00           O  \n\
HETATM    7  O   HOH B 101       8.000   2.000   0.000  1.00 10.00           O  \n\
END\n";

/// The ids of a picture: atoms from 1, then bonds.
fn ids(case: &Case, flags: &[&str]) -> BTreeSet<u32> {
    let mut line = vec![
        "render",
        "site.pdb",
        "-o",
        "ids.npy",
        "--channel",
        "id",
        "--size",
        "160x120",
        "--no-ground",
        "--view",
        "front",
    ];
    line.extend(flags);
    let run = case.run(&line).status(0);
    assert_eq!(run.err(), "", "{flags:?}");
    let file = std::fs::read(case.path("ids.npy")).unwrap();
    let body = &file[file.len() - 160 * 120 * 4..];
    body.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).filter(|&id| id > 0).collect()
}

#[test]
fn pictures_show_what_is_selected() {
    let case = Case::new(&[("site.pdb", SITE)]);
    let atoms = |flags: &[&str]| ids(&case, flags).into_iter().filter(|&id| id <= 7).collect::<Vec<u32>>();
    assert_eq!(atoms(&["--style=space-filling", "--show", "ligand"]), [5, 6]);
    assert_eq!(
        atoms(&["--style=space-filling", "--show", "chain A", "--show", "water", "--hide", "element O"]),
        [1, 2, 3]
    );
    assert_eq!(
        atoms(&["--show", "within 4 of ligand", "--hide", "protein", "--style", "all=space-filling"]),
        [5, 6, 7]
    );
}

#[test]
fn colours_and_styles_are_those_of_the_last_selection_and_stand_in_the_metadata() {
    let case = Case::new(&[("site.pdb", SITE)]);
    let render = |name: &str, flags: &[&str]| {
        let mut line = vec!["render", "site.pdb", "-o", name, "--size", "80x60", "--no-ground", "--look", "flat"];
        line.extend(flags);
        case.run(&line).status(0);
        std::fs::read(case.path(name)).unwrap()
    };
    let flags = ["--style", "space-filling", "--color", "all=red", "--color", "ligand=blue"];
    let ppm = render("a.ppm", &flags);
    let has = |is_it: &dyn Fn(&[u8]) -> bool| ppm[ppm.len() - 80 * 60 * 3..].chunks_exact(3).any(is_it);
    assert!(has(&|rgb| rgb[0] > 150 && rgb[2] < 60) && has(&|rgb| rgb[2] > 150 && rgb[0] < 60));
    assert!(!has(&|rgb| rgb[1] > rgb[0].max(rgb[2])));
    let png = render("a.png", &flags);
    let text = String::from_utf8_lossy(&png).into_owned();
    assert!(text.contains(r##""color":["all=#ff0000","ligand=#0000ff"]"##), "settings");
    assert!(render("b.ppm", &["--style", "ligand=space-filling"]) != render("c.ppm", &[]));
}

#[test]
fn convert_writes_what_is_selected_with_its_bonds() {
    let case = Case::new(&[("site.pdb", SITE), ("water.xyz", WATER)]);
    case.run(&["convert", "site.pdb", "ligand.json", "--show", "ligand"]).status(0);
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(case.path("ligand.json")).unwrap()).unwrap();
    assert_eq!((json["atoms"].as_array().unwrap().len(), &json["bonds"][0]["atoms"]), (2, &serde_json::json!([0, 1])));
    let run = case.run(&["convert", "water.xyz", "-", "--to", "xyz", "--hide", "bonded to element O"]).status(0);
    assert!(
        run.out().starts_with("1\n") && run.out().lines().count() == 3 && run.out().contains("\nO "),
        "{}",
        run.out()
    );
}

#[test]
fn what_selects_nothing_is_a_warning_and_what_is_no_selection_an_error_with_its_place() {
    let case = Case::new(&[("site.pdb", SITE)]);
    let run = case.run(&["render", "site.pdb", "-o", "a.png", "--size", "16x12", "--hide", "chain Q"]).status(0);
    assert!(run.err().contains("--hide chain Q: there is no such atom"), "{}", run.err());
    let run = case.run(&["convert", "site.pdb", "a.xyz", "--hide", "chain Q"]).status(0);
    assert!(run.err().contains("--hide chain Q: there is no such atom"), "{}", run.err());
    let run = case.run(&["render", "site.pdb", "-o", "b.png", "--show", "chain A adn water"]).status(2);
    assert!(run.err().contains("did you mean `and`?") && run.err().contains("\n          ^^^"), "{}", run.err());
    let run = case.run(&["render", "site.pdb", "-o", "b.png", "--color", "chain A"]).status(2);
    assert!(run.err().contains("chain A=steelblue"), "{}", run.err());
    let run = case.run(&["render", "--help"]).status(0);
    assert!(run.out().contains("within 5 of ligand") && run.out().contains("same residue as name SG"));
}
