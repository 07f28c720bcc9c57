use super::*;
use crate::bonds;
use crate::import;

fn structure(text: &str, name: &str) -> Structure {
    let document = import::read_bytes(text.as_bytes(), name, &Default::default()).unwrap();
    bonds::assign(document.records[0].clone(), &Default::default())
}

/// Ala-Gly with hydrogens on the first, a heme's iron with a water, a zinc, a free glycine as HETATM, sulfate's atoms.
fn protein() -> Structure {
    let lines = [
        "ATOM      1  N   ALA A  10       0.000   0.000   0.000  1.00 10.00           N  ",
        "ATOM      2  CA  ALA A  10       1.458   0.000   0.000  1.00 20.00           C  ",
        "ATOM      3  C   ALA A  10       2.009   1.420   0.000  1.00 30.00           C  ",
        "ATOM      4  O   ALA A  10       1.251   2.390   0.000  1.00 40.00           O  ",
        "ATOM      5  CB AALA A  10       1.988  -0.773  -1.199  0.60 10.00           C  ",
        "ATOM      6  HA  ALA A  10       1.800  -0.500   0.900  1.00 10.00           H  ",
        "ATOM      7  N   GLY A  11       3.330   1.540   0.000  1.00 10.00           N  ",
        "ATOM      8  CA  GLY A  11       3.970   2.850   0.000  1.00 10.00           C  ",
        "ATOM      9  C   GLY A  11       5.490   2.730   0.000  1.00 10.00           C  ",
        "ATOM     10  O   GLY A  11       6.070   1.640   0.000  1.00 10.00           O  ",
        "ATOM     11  N   SER A  11A     20.000   0.000   0.000  1.00 10.00           N  ",
        "ATOM     12  CA  SER a  -5      30.000   0.000   0.000  1.00 10.00           C  ",
        "HETATM   13 FE   HEM B   1      40.000   0.000   0.000  1.00 10.00          FE  ",
        "HETATM   14  O   HOH B   2      42.100   0.000   0.000  1.00 10.00           O  ",
        "HETATM   15 ZN    ZN B   3      60.000   0.000   0.000  1.00 10.00          ZN2+",
        "HETATM   16  N   GLY C   1      80.000   0.000   0.000  1.00 10.00           N  ",
        "HETATM   17  CA  GLY C   1      81.458   0.000   0.000  1.00 10.00           C  ",
        "HETATM   18  C   GLY C   1      82.009   1.420   0.000  1.00 10.00           C  ",
        "HETATM   19  S   SO4 C   2      99.000   0.000   0.000  1.00 10.00           S  ",
    ];
    structure(&(lines.join("\n") + "\nEND\n"), "a.pdb")
}

/// The numbers, from 1, of the atoms that a text selects.
fn selected(structure: &Structure, text: &str) -> Vec<usize> {
    let selection = Selection::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let atoms = selection.atoms(Scope::of(structure));
    assert_eq!(atoms.len(), structure.atom_count());
    (1..=atoms.len()).filter(|&number| atoms[number - 1]).collect()
}

#[test]
fn each_word_finds_its_atoms() {
    let protein = protein();
    for (text, expected) in [
        ("chain a", &[12][..]),
        ("chain A,B and element n", &[1, 7, 11]),
        ("chain a B C", &[12, 13, 14, 15, 16, 17, 18, 19]),
        ("residue 10", &[1, 2, 3, 4, 5, 6]),
        ("residue 11", &[7, 8, 9, 10, 11]),
        ("resi 11A", &[11]),
        ("residue -5", &[12]),
        ("residue -5-2 and hetero", &[13, 14, 16, 17, 18, 19]),
        ("resid 11A to 12", &[11]),
        ("residue 2:3 and chain B", &[14, 15]),
        ("residue < 0", &[12]),
        ("resname hem,ZN", &[13, 15]),
        ("resn S*", &[11, 12, 19]),
        ("name CB FE", &[5, 13]),
        ("name C?", &[2, 5, 8, 12, 17]),
        ("element iron zn", &[13, 15]),
        ("index 3-5,19", &[3, 4, 5, 19]),
        ("index >= 18", &[18, 19]),
        ("serial 2", &[2]),
        ("file 1 and index 1", &[1]),
        ("file 2", &[]),
        ("water", &[14]),
        ("ion", &[13, 15, 19]),
        ("ligand", &[16, 17, 18]),
        ("protein and not chain A", &[12]),
        ("metal", &[13, 15]),
        ("hydrogens", &[6]),
        ("backbone and residue 10", &[1, 2, 3, 4, 6]),
        ("sidechain", &[5]),
        ("altloc A", &[5]),
        ("altloc \"\" and residue 10", &[1, 2, 3, 4, 6]),
        ("bfactor > 20", &[3, 4]),
        ("occupancy < 1", &[5]),
        ("occupancy = 0.6", &[5]),
        ("charge != 0", &[15]),
        ("x > 90 | z < -1", &[5, 19]),
        ("within 2.1 of element Fe", &[13, 14]),
        ("around 2.1 of element Fe", &[14]),
        ("beyond 25 of index 1-10", &[13, 14, 15, 16, 17, 18, 19]),
        ("bonded to name N and chain A", &[2, 3, 8]),
        ("same residue as (within 1 of name CB)", &[1, 2, 3, 4, 5, 6]),
        ("byres index 13 or same chain as index 12", &[12, 13]),
        ("same molecule as index 9", &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]),
        ("not (all and !none)", &[]),
        ("NOT ALL OR INDEX 1", &[1]),
    ] {
        assert_eq!(selected(&protein, text), expected, "{text}");
    }
    assert_eq!(selected(&protein, "nucleic"), [0usize; 0]);
}

#[test]
fn not_binds_closer_than_and_and_and_than_or() {
    let protein = protein();
    assert_eq!(selected(&protein, "not water and chain B or index 1"), [1, 13, 15]);
    assert_eq!(selected(&protein, "index 1 or chain B and water"), [1, 14]);
    assert_eq!(selected(&protein, "within 3 of water and metal"), [13]);
}

#[test]
fn without_residues_molecules_are_ligands_and_copies_keep_their_numbers() {
    let xyz = structure("5\n\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\nNa 9 0 0\nC 20 0 0\n", "a.xyz");
    for (text, expected) in
        [("water", &[1, 2, 3][..]), ("ion", &[4]), ("ligand", &[5]), ("name O", &[1]), ("byres index 2", &[1, 2, 3])]
    {
        assert_eq!(selected(&xyz, text), expected, "{text}");
    }
    let scope = Scope { structure: &xyz, listed: &[0, 1, 2, 0, 1], file: 2 };
    assert_eq!(Selection::parse("file 2 and index 1").unwrap().atoms(scope), [true, false, false, true, false]);
    assert_eq!(Selection::parse("drawn 4").unwrap().atoms(scope), [false, false, false, true, false]);
}

#[test]
fn mistakes_are_shown_in_their_place_with_what_was_meant() {
    for (text, place, says) in [
        ("", 0, "expected what to select"),
        ("chain", 5, "expected a chain, such as A; the selection ends here"),
        ("chain A adn water", 8, "found adn; did you mean `and`?"),
        ("chain A water", 8, "did you mean `and water`?"),
        ("resnmae ALA", 0, "did you mean `resname`?"),
        ("residue ALA", 8, "did you mean `resname ALA`?"),
        ("ALA", 0, "did you mean `resname ALA`?"),
        ("water and", 9, "the selection ends here"),
        ("(water", 6, "closing parenthesis"),
        ("water)", 5, "closes none"),
        ("element Foo", 8, "Foo is no element"),
        ("within of ligand", 7, "a distance in ångström"),
        ("within 5 ligand", 9, "expected of"),
        ("within -5 of ligand", 7, "0 or more"),
        ("bfactor 30", 8, "expected <"),
        ("bfactor > much", 10, "found much"),
        ("bonded element Fe", 7, "expected to"),
        ("same atom as water", 5, "expected residue, chain or molecule"),
        ("same residue water", 13, "expected as"),
        ("index 9-3", 6, "did you mean `3-9`?"),
        ("chain A,", 8, "behind the comma"),
        ("chain 'A", 6, "not closed"),
        ("x < 1e999", 4, "expected a number"),
    ] {
        let error = Selection::parse(text).unwrap_err();
        assert_eq!(error.span.start, place, "{text}: {error}");
        assert!(error.to_string().contains(says), "{text}: {error}");
    }
    let error = Selection::parse("chain Ä adn wasser").unwrap_err().to_string();
    assert!(error.ends_with("\n  chain Ä adn wasser\n          ^^^"), "{error}");
    let deep = Selection::parse(&"(".repeat(100_000)).unwrap_err();
    assert!(deep.to_string().contains("inside one another") && deep.to_string().lines().all(|line| line.len() < 300));
    assert!(Selection::parse(&vec!["water"; 100_000].join(" or ")).is_ok());
}

#[test]
fn completions_are_what_the_grammar_and_the_structure_have() {
    let protein = protein();
    let scopes = [Scope::of(&protein)];
    let at = |text: &str| {
        let found = completions(text, text.len(), &scopes);
        (found.span.start, found.all.into_iter().map(|one| one.text).collect::<Vec<_>>())
    };
    assert_eq!(at("wat"), (0, vec!["water".into(), "waters".into()]));
    assert_eq!(at("chain "), (6, vec!["A".into(), "a".into(), "B".into(), "C".into()]));
    assert_eq!(at("chain A,"), (8, vec!["A".into(), "a".into(), "B".into(), "C".into()]));
    assert_eq!(at("chain A "), (8, vec!["and".into(), "or".into()]));
    assert_eq!(at("water and resname h"), (18, vec!["HEM".into(), "HOH".into()]));
    assert_eq!(at("element ").1[..2], ["C".to_owned(), "N".to_owned()]);
    assert_eq!(at("within 5 "), (9, vec!["of".into()]));
    assert_eq!(at("bonded "), (7, vec!["to".into()]));
    assert_eq!(at("same residue "), (13, vec!["as".into()]));
    assert_eq!(at("occupancy ").1[0], "<");
    assert_eq!(at("altloc "), (7, vec!["A".into()]));
    assert!(at("").1.len() > 30 && at("").1.iter().all(|text| !text.is_empty()));
    assert_eq!(at("wter and "), (9, vec![]));
    // In the middle of a text, and at no place at all.
    assert_eq!(completions("wat and metal", 3, &scopes).span, 0..3);
    assert_eq!(completions("ä", 1, &scopes).span, 0..0);
}

#[test]
fn picked_atoms_become_ranges_and_files_take_new_places() {
    let selection = Selection::of_numbers(2, &[1, 2, 3, 7, 9, 10], true);
    assert_eq!(selection.text(), "file 2 and index 1-3,7,9-10");
    assert_eq!(Selection::of_numbers(1, &[], true).text(), "none");
    assert_eq!(Selection::of_numbers(1, &[5], false).text(), "file 1 and drawn 5");
    let moved = |text: &str| {
        let new = |file: u32| (file != 1).then(|| file - 1);
        Selection::parse(text).unwrap().with_files(new).text().to_owned()
    };
    assert_eq!(moved("file 2 and index 1"), "file 1 and index 1");
    assert_eq!(moved("(FILE 1-3 and not model 1) or water"), "(file 1,2 and not none) or water");
    assert_eq!(moved("water"), "water");
    let any = Selection::any_of(&[selection, Selection::parse("water or metal").unwrap()]);
    assert_eq!(any.text(), "(file 2 and index 1-3,7,9-10) or (water or metal)");
}

#[test]
fn modified_and_renamed_residues_have_letters() {
    let letters: Vec<Option<char>> = ["ALA", "MSE", "HSD", "NALA", "DA5", "U", "HEM", "HOH"].map(one_letter).to_vec();
    assert_eq!(letters, [Some('A'), Some('M'), Some('H'), Some('A'), Some('A'), Some('U'), None, None]);
}
