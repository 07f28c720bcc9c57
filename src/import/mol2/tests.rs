use crate::element::Element;
use crate::error::{Error, Result};
use crate::import::{Document, Format, ImportOptions, read_bytes};
use crate::structure::{BondKind, BondOrder, Severity, StatedBonds, Structure, atom_flags};

fn read(text: &str) -> Result<Document> {
    read_bytes(text.as_bytes(), "a.mol2", &ImportOptions { format: Some(Format::Mol2), ..ImportOptions::default() })
}

fn one(text: &str) -> Structure {
    let document = read(text).unwrap();
    assert_eq!(document.records.len(), 1, "{:?}", document.diagnostics);
    document.records[0].clone()
}

/// A molecule of these atom and bond lines, with more behind them.
fn mol2(atoms: &[&str], bonds: &[&str], more: &str) -> String {
    format!(
        "@<TRIPOS>MOLECULE\nname\n {} {} 1\nSMALL\nUSER_CHARGES\n\n\n@<TRIPOS>ATOM\n{}\n@<TRIPOS>BOND\n{}\n{more}",
        atoms.len(),
        bonds.len(),
        atoms.join("\n"),
        bonds.join("\n")
    )
}

#[test]
fn atoms_bonds_and_charges_are_read() {
    let atoms = ["1 C1 0.5 0 -1.25 C.ar 1 LIG7 0.25", "5 N1 1 0 0 N.am 1 \\\n LIG7 -0.5 BACKBONE|DICT"];
    let text = mol2(&atoms, &["1 5 1 \\\nam DICT"], "");
    let molecule = one(&text.replace("@<TRIPOS>BOND", "# a comment\n\n@<TRIPOS>BOND"));
    assert_eq!(molecule.title(), "name");
    assert_eq!(molecule.elements(), [Element::C, Element::N]);
    assert_eq!((molecule.atom_name(1), molecule.serial(1)), ("N1", 5));
    assert_eq!(molecule.positions().written(0).to_array(), [0.5, 0.0, -1.25]);
    assert_eq!((molecule.partial_charge(0), molecule.partial_charge(1)), (Some(0.25), Some(-0.5)));
    assert_eq!((molecule.residues()[0].number, molecule.name(molecule.residues()[0].name)), (7, "LIG"));
    assert_eq!(molecule.stated_bonds(), StatedBonds::Complete);
    assert_eq!(molecule.bonds()[0].order, BondOrder::Single);
    let none = one(&text.replace("USER_CHARGES", "NO_CHARGES"));
    assert_eq!(none.partial_charge(0), None);
}

#[test]
fn every_bond_type_has_its_meaning() {
    let atoms: Vec<String> =
        (1..=9).map(|n| format!("{n} A{n} {n} 0 0 {}", if n == 9 { "Zn" } else { "C.3" })).collect();
    let atoms: Vec<&str> = atoms.iter().map(String::as_str).collect();
    let bonds =
        ["1 1 2 1", "2 2 3 2", "3 3 4 3", "4 4 5 am", "5 5 6 AR", "6 6 7 du", "7 7 8 un", "8 8 1 nc", "9 8 9 1"];
    let molecule = one(&mol2(&atoms, &bonds, ""));
    let got: Vec<_> = molecule.bonds().iter().map(|bond| (bond.order.number(), bond.aromatic)).collect();
    let want = [(1, false), (2, false), (3, false), (1, false), (0, true), (0, false), (0, false), (0, false)];
    assert_eq!(got, want);
    assert_eq!(molecule.bonds()[7].kind, BondKind::Coordination);
}

#[test]
fn substructures_are_residues_of_chains() {
    let atoms = ["1 CA 0 0 0 C.3 1 ALA12", "2 O 1 0 0 O.3 2 HOH-2", "3 S 2 0 0 S.3 3 SO4", "4 O 3 0 0 O.3 4 SO49"];
    let more =
        "@<TRIPOS>SUBSTRUCTURE\n1 ALA12 1 RESIDUE 4 B ALA 1 ROOT\n4 SO49 4 GROUP 4 C SO4\n5 X\n@<TRIPOS>SET\nx\n";
    let molecule = one(&mol2(&atoms, &[], more));
    let got: Vec<_> = molecule.residues().iter().map(|r| (molecule.name(r.name), r.number)).collect();
    assert_eq!(got, [("ALA", 12), ("HOH", -2), ("SO", 4), ("SO4", 9)]);
    assert_eq!(molecule.chains().collect::<Vec<_>>(), ["B", "", "C"]);
}

#[test]
fn cells_and_formal_charges_come_from_their_sections() {
    let more = "@<TRIPOS>CRYSIN\n10 11.5 12 90 91 92 1 1\n@<TRIPOS>UNITY_ATOM_ATTR\n1 2\ncolor red\ncharge -1\n2 1\ncharge 2\n";
    let molecule = one(&mol2(&["1 O 0 0 0 O.co2", "2 Ca 3 0 0 Ca"], &[], more));
    assert_eq!((molecule.formal_charge(0), molecule.formal_charge(1)), (-1, 2));
    let cell = molecule.cell().unwrap();
    assert!((cell.lengths()[1] - 11.5).abs() < 1e-9 && (cell.angles_deg()[2] - 92.0).abs() < 1e-9);
}

#[test]
fn force_field_types_make_all_elements_come_from_names() {
    let molecule = one(&mol2(&["1 C1 0 0 0 ca 1 LIG", "2 CL1 1 0 0 cl 1 LIG", "3 O1 2 0 0 o 1 LIG"], &[], ""));
    assert_eq!(molecule.elements(), [Element::C, Element::CL, Element::O]);
    let dummies = one(&mol2(&["1 D1 0 0 0 Du", "2 L1 0 0 1 LP", "3 CA 0 0 2 Ca"], &[], ""));
    assert_eq!([0, 1, 2].map(|atom| dummies.flags(atom)), [atom_flags::PARTICLE, atom_flags::PARTICLE, 0]);
    assert_eq!(dummies.elements()[2].symbol(), "Ca");
}

#[test]
fn a_bad_molecule_does_not_take_the_others_with_it() {
    let good = mol2(&["1 C 0 0 0 C.3"], &[], "");
    let cut = good.replace(" 1 0 1\n", " 2 0 1\n");
    let torn = good.replace("0 0 0 C.3", "0 0");
    let document = read(&format!("{good}{cut}# between\n{torn}{good}")).unwrap();
    assert_eq!(document.records.len(), 2);
    assert_eq!(document.diagnostics.iter().filter(|d| d.severity == Severity::Error).count(), 2);
    for text in [cut, torn, good.replace(" 1 0 1\n", "counts\n"), mol2(&[], &[], "")] {
        assert!(matches!(read(&text).unwrap_err(), Error::Input { line: Some(_), .. }), "{text}");
    }
}

#[test]
fn bonds_to_nowhere_are_left_out() {
    let text = mol2(&["1 C 0 0 0 C.3", "2 C 1 0 0 C.3"], &["1 0 2 1", "2 1 1 1", "3 1 2 2", "4 2 1 1"], "");
    let document = read(&text).unwrap();
    assert_eq!(document.records[0].bonds().len(), 1);
    assert_eq!(document.records[0].bonds()[0].order, BondOrder::Double);
    assert_eq!(document.diagnostics.iter().filter(|d| d.severity == Severity::Error).count(), 1);
}
