//! Reading that is given up: at any question, in any format, and soon.

use super::*;
use std::fmt::Write;

/// Files of `data/`, one of each format, packed and not.
const FILES: &[&str] = &[
    "1crn.pdb",
    "1crn.bcif",
    "1lcd.pdb.gz",
    "5pti.cif.gz",
    "c60.xyz",
    "ethane-rotation.xyz",
    "aspirin.sdf",
    "aspirin-v3000.sdf",
    "paracetamol.mol2",
    "paracetamol.json",
    "porphin.cjson",
    "tip4p.gro.zst",
    "nacl.poscar",
    "urea.cif",
    "water.cube",
];

fn stopping(stop: &Stop) -> ImportOptions {
    ImportOptions { stop: stop.clone(), ..ImportOptions::default() }
}

#[test]
fn a_flag_that_is_not_set_changes_nothing_and_one_that_is_leaves_nothing() {
    for name in FILES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
        let asked = Stop::at_question(usize::MAX);
        let document = read_path(&path, &stopping(&asked)).unwrap();
        assert!(document == read_path(&path, &ImportOptions::default()).unwrap(), "{name}");
        let questions = asked.questions();
        assert!(questions >= 3, "{name}: {questions}");
        for question in (1..=questions).step_by(1 + questions / 20) {
            let stop = Stop::at_question(question);
            let result = read_path(&path, &stopping(&stop));
            assert!(matches!(result, Err(Error::Stopped)), "{name}, question {question}: {result:?}");
            assert_eq!(stop.handles(), 1, "{name}");
        }
    }
}

/// So many atoms as text, after `head`, each as `atom` writes it.
fn text(atoms: usize, head: &str, atom: impl Fn(&mut String, usize, [f64; 3])) -> String {
    let mut text = head.to_owned();
    for index in 0..atoms {
        let along = |step: usize| (index / step % 50) as f64 * 2.0;
        atom(&mut text, index, [along(1), along(50), along(2500)]);
    }
    text
}

#[test]
fn large_texts_ask_every_few_thousand_lines() {
    const ATOMS: usize = 90_000;
    let xyz =
        text(ATOMS, &format!("{ATOMS}\n\n"), |text, _, [x, y, z]| writeln!(text, "Ar {x:.3} {y:.3} {z:.3}").unwrap());
    let pdb = text(ATOMS, "", |text, index, [x, y, z]| {
        let serial = index % 99_999 + 1;
        writeln!(text, "HETATM{serial:5} AR   AR  A   1    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00          AR").unwrap();
    });
    let gro = text(ATOMS, &format!("argon\n{ATOMS}\n"), |text, index, at| {
        let [x, y, z] = at.map(|along| along / 10.0);
        let number = (index + 1) % 100_000;
        writeln!(text, "{number:5}AR      AR{number:5}{x:8.3}{y:8.3}{z:8.3}").unwrap();
    }) + "20 20 20\n";
    let head = "data_x\nloop_\n_atom_site.group_PDB\n_atom_site.id\n_atom_site.type_symbol\n_atom_site.label_atom_id\n\
        _atom_site.label_comp_id\n_atom_site.label_asym_id\n_atom_site.label_seq_id\n_atom_site.Cartn_x\n\
        _atom_site.Cartn_y\n_atom_site.Cartn_z\n";
    let cif = text(ATOMS, head, |text, index, [x, y, z]| {
        writeln!(text, "HETATM {} AR AR AR A . {x} {y} {z}", index + 1).unwrap();
    });
    let head = "argon\n\n\n  0  0  0     0  0            999 V3000\nM  V30 BEGIN CTAB\n";
    let head = format!("{head}M  V30 COUNTS {ATOMS} 0 0 0 0\nM  V30 BEGIN ATOM\n");
    let sdf = text(ATOMS, &head, |text, index, [x, y, z]| {
        writeln!(text, "M  V30 {} Ar {x} {y} {z} 0", index + 1).unwrap();
    }) + "M  V30 END ATOM\nM  V30 END CTAB\nM  END\n$$$$\n";
    let head = format!("@<TRIPOS>MOLECULE\nargon\n{ATOMS} 0\nSMALL\nNO_CHARGES\n@<TRIPOS>ATOM\n");
    let mol2 = text(ATOMS, &head, |text, index, [x, y, z]| {
        writeln!(text, "{} AR{} {x} {y} {z} Ar", index + 1, index + 1).unwrap();
    });
    for (name, text) in
        [("a.xyz", xyz), ("a.pdb", pdb), ("a.gro", gro), ("a.cif", cif), ("a.sdf", sdf), ("a.mol2", mol2)]
    {
        let asked = Stop::at_question(usize::MAX);
        let document = read_bytes(text.as_bytes(), name, &stopping(&asked)).unwrap();
        assert_eq!(document.records[0].atom_count(), ATOMS, "{name}");
        let (questions, least) = (asked.questions(), ATOMS / 8 / text::LOOK_EVERY as usize);
        assert!(questions >= least, "{name}: {questions} questions, {least} wanted");
        let stop = Stop::at_question(questions / 2);
        let result = read_bytes(text.as_bytes(), name, &stopping(&stop));
        assert!(matches!(result, Err(Error::Stopped)), "{name}: {result:?}");
        let after = stop.questions() - questions / 2;
        // Every part of a wave that is under way may ask once more, and those who wait for them; and none reads further than to its next look.
        assert!(after <= 64 + 8 * rayon::current_num_threads(), "{name}: {after} more questions of {questions}");
    }
}
