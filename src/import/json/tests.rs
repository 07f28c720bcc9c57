use crate::element::Element;
use crate::error::{Error, Result};
use crate::import::{Document, Format, ImportOptions, read_bytes};
use crate::structure::{
    BondKind, BondOrder, BondSource, BondStereo, Severity, StatedBonds, StereoMark, Structure, atom_flags,
};

fn read(text: &str) -> Result<Document> {
    read_bytes(text.as_bytes(), "", &ImportOptions::default())
}

fn one(text: &str) -> Structure {
    let document = read(text).unwrap();
    assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
    assert_eq!(document.records.len(), 1);
    document.records[0].clone()
}

#[test]
fn our_own_form_is_read_whole() {
    let text = r#"{"title": "a", "bonds": [{"atoms": [1, 0], "order": 2, "aromatic": true, "source": "dictionary"},
        {"atoms": [1, 2], "kind": "coordination"}], "cell": {"a": 5, "b": 6, "c": 7, "alpha": 90, "beta": 91, "gamma": 92},
        "atoms": [{"element": "C", "position": [0.125, -1e-3, 3], "charge": -1, "name": "C1", "residue": "LIG",
        "residue_number": 7, "chain": "A", "insertion_code": "B", "occupancy": 0.5, "isotope": 13, "hetero": true},
        {"element": 8, "position": [1, 0, 0], "charge": 0.25}, {"element": "Zn", "position": [2, 0, 0], "more": [{}]}]}"#;
    let molecule = one(text);
    assert_eq!(molecule.title(), "a");
    assert_eq!(molecule.elements(), [Element::C, Element::O, Element::from_z(30).unwrap()]);
    assert_eq!(molecule.positions().written(0).to_array(), [0.125, -0.001, 3.0]);
    assert_eq!(molecule.positions().decimals(), 3);
    assert_eq!((molecule.formal_charge(0), molecule.isotope(0), molecule.occupancy(0)), (-1, 13, 0.5));
    assert_eq!((molecule.atom_name(0), molecule.flags(0)), ("C1", atom_flags::HETERO));
    assert_eq!((molecule.residues()[0].number, molecule.residues()[0].insertion_code), (7, b'B'));
    assert_eq!(molecule.partial_charge(1), Some(0.25));
    let [double, metal] = molecule.bonds() else { panic!("two bonds expected") };
    assert_eq!((double.a, double.b, double.order, double.aromatic), (0, 1, BondOrder::Double, true));
    assert_eq!(double.source, BondSource::Dictionary);
    assert_eq!((metal.order, metal.kind), (BondOrder::Unknown, BondKind::Coordination));
    assert!((molecule.cell().unwrap().lengths()[2] - 7.0).abs() < 1e-12);
}

#[test]
fn an_empty_bond_list_is_a_list() {
    let atoms = r#""atoms": [{"element": "He", "position": [0, 0, 0]}]"#;
    assert_eq!(one(&format!("{{{atoms}}}")).stated_bonds(), StatedBonds::None);
    assert_eq!(one(&format!("{{{atoms}, \"bonds\": null}}")).stated_bonds(), StatedBonds::None);
    assert_eq!(one(&format!("{{{atoms}, \"bonds\": []}}")).stated_bonds(), StatedBonds::Complete);
}

#[test]
fn imolecule_is_known_by_its_locations() {
    let text = r#"{"atoms": [{"element": "H", "label": "H0", "location": [0, 0, 0]}, {"element": "H", "location": [0, 0, 0.7]}],
        "bonds": [{"atoms": [0, 1], "order": 1}], "unitcell": [[2, 0, 0], [0, 3, 0], [0, 0, 4]], "formula": "H2"}"#;
    let document = read(text).unwrap();
    assert_eq!(document.format, Format::ImoleculeJson);
    assert_eq!(document.records[0].cell().unwrap().lengths(), [2.0, 3.0, 4.0]);
    assert_eq!((document.records[0].atom_name(0), document.records[0].bonds().len()), ("H0", 1));
}

const CJSON: &str = r#"{"chemicalJson": 1, "name": "x", "atoms": {"elements": {"number": [6, 0]}, COORDS
    "formalCharges": [-1, 0], "labels": ["a", "b"]}, "bonds": {"connections": {"index": [0, 1]}, "order": [3]},
    "unitCell": {"a": 2, "b": 4, "c": 8, "alpha": 90, "beta": 90, "gamma": 90}, "partialCharges": {"Mulliken": [0.5, -0.5]}}"#;

#[test]
fn chemical_json_is_read_by_columns() {
    let molecule = one(&CJSON.replace("COORDS", r#""coords": {"3d": [0, 0, 0, 1.25, 0, 0]},"#));
    assert_eq!(molecule.elements(), [Element::C, Element::DUMMY]);
    assert_eq!((molecule.flags(1), molecule.formal_charge(0), molecule.atom_name(1)), (atom_flags::PARTICLE, -1, "b"));
    assert_eq!((molecule.bonds()[0].order, molecule.partial_charge(1)), (BondOrder::Triple, Some(-0.5)));
    assert_eq!((molecule.title(), molecule.positions().decimals()), ("x", 2));
}

#[test]
fn fractional_coordinates_and_sets_become_positions_and_frames() {
    let molecule = one(&CJSON.replace("COORDS", r#""coords": {"3dFractional": [0, 0, 0, 0.5, 0.25, 0.125]},"#));
    assert_eq!(molecule.positions().get(1).to_array(), [1.0, 1.0, 1.0]);
    let sets = r#""coords": {"3d": [0,0,0,1,0,0], "3dSets": [[0,0,0,1,0,0],[0,0,0,2,0,0],[0]]},"#;
    let document = read(&CJSON.replace("COORDS", sets)).unwrap();
    assert_eq!(document.frame_count(), 2);
    assert_eq!(document.diagnostics[0].severity, Severity::Error);
}

#[test]
fn contradictions_are_errors() {
    for (text, line) in [
        (CJSON.replace("COORDS", r#""coords": {"3d": [0, 0, 0, 1]},"#), None),
        (CJSON.replace("COORDS", ""), None),
        ("{\n\"atoms\": [{\"element\": \"C\"}]}".to_owned(), Some(2)),
        ("{\n\"atoms\":\n[{\"element\": \"C\", \"position\": [0, 1]}]}".to_owned(), Some(3)),
        ("{\"atoms\": [{\"element\": \"C\", \"position\": [0, 1e30, 0]}]}".to_owned(), Some(1)),
        ("{\"atoms\": []}".to_owned(), None),
        ("{\"atoms\": [\n".to_owned(), Some(2)),
        ("[]".to_owned(), Some(1)),
        ("{}".to_owned(), None),
    ] {
        let error = read(&text).unwrap_err();
        assert!(matches!(error, Error::Input { .. }) && error.line() == line, "{text}: {error:?}");
    }
}

#[test]
fn bonds_that_cannot_be_are_left_out() {
    let text = r#"{"atoms": [{"element": "H", "position": [0, 0, 0]}, {"element": "H", "position": [0, 0, 1]}],
        "bonds": [{"atoms": [0, 1000000]}, {"atoms": [-1, 0]}, {"atoms": [1, 1]}, {"atoms": [0, 1], "order": 1.5}]}"#;
    let document = read(text).unwrap();
    let bonds = document.records[0].bonds();
    assert!(bonds.len() == 1 && bonds[0].aromatic && bonds[0].order == BondOrder::Unknown);
    assert_eq!(document.diagnostics.iter().filter(|d| d.severity == Severity::Error).count(), 3);
}

#[test]
fn depth_is_limited_with_its_line() {
    let deep = format!("{{\n\"x\": {}", "[".repeat(200_000));
    let error = read(&deep).unwrap_err();
    assert!(matches!(error, Error::Limit { line: Some(2), .. }), "{error}");
}

#[test]
fn bonds_go_to_periodic_images() {
    let text = r#"{"atoms": [{"element": "Na", "position": [0, 0, 0]}, {"element": "Cl", "position": [2, 0, 0]}],
        "cell": {"a": 4, "b": 4, "c": 4},
        "bonds": [{"atoms": [0, 1]}, {"atoms": [1, 0], "image": [1, 0, 0]}, {"atoms": [0, 0], "image": [0, -1, 0]}]}"#;
    let molecule = one(text);
    let keys: Vec<_> = molecule.bonds().iter().map(crate::structure::Bond::key).collect();
    assert_eq!(keys, [(0, 0, [0, 1, 0]), (0, 1, [-1, 0, 0]), (0, 1, [0, 0, 0])]);
}

#[test]
fn qcschema_is_read_in_bohr() {
    let molecule = r#"{"symbols": ["O", "H", "H", "He"], "geometry": [0, 0, 0, 2, 0, 0, 0, 2, 0, 9, 9, 9],
        "connectivity": [[0, 1, 1.0], [0, 2, 1.5]], "real": [true, true, true, false], "mass_numbers": [16, 2, 1, 4],
        "atom_labels": ["", "a", "", ""], "molecular_charge": -1.0, "name": "water"}"#;
    for text in [molecule.to_owned(), format!("{{\"schema_name\": \"qcschema_input\", \"molecule\": {molecule}}}")] {
        let document = read(&text).unwrap();
        assert_eq!((document.format, document.diagnostics.len()), (Format::QcSchema, 0));
        let water = &document.records[0];
        assert!((water.positions().get(1).x - 1.058_354_421_088).abs() < 1e-12);
        assert_eq!((0..4).map(|atom| water.isotope(atom)).collect::<Vec<_>>(), [0, 2, 0, 0]);
        assert_eq!((water.flags(3), water.elements()[3]), (atom_flags::PARTICLE, Element::DUMMY));
        assert_eq!((water.atom_name(1), water.title()), ("Ha", "water"));
        assert!(water.bonds().len() == 2 && water.bonds()[1].aromatic);
        assert_eq!(water.properties(), [("molecular_charge".to_owned(), "-1".to_owned())]);
    }
    let nested =
        read(r#"{"symbols": ["H", "H"], "geometry": [[0, 0, 0], [0, 0, 1.4]], "connectivity": null}"#).unwrap();
    assert_eq!(nested.records[0].stated_bonds(), StatedBonds::None);
    assert!(read(r#"{"symbols": ["H"], "geometry": [0, 0]}"#).is_err());
}

#[test]
fn pubchem_compounds_are_records_and_conformers_frames() {
    let text = r#"{"PC_Compounds": [{"id": {"id": {"cid": 7}}, "atoms": {"aid": [3, 1, 2], "element": [6, 8, 255],
        "charge": [{"aid": 1, "value": -1}], "isotope": [{"aid": 3, "value": 13}], "radical": [{"aid": 3, "type": 2}]},
        "bonds": {"aid1": [1, 3], "aid2": [3, 2], "order": [2, 6]},
        "coords": [{"type": [1, 5], "aid": [1, 2, 3], "conformers": [{"x": [9, 9, 9], "y": [9, 9, 9]}]},
        {"type": [2, 5], "aid": [1, 2, 3], "conformers": [
        {"x": [1, 2, 3.25], "y": [0, 0, 0], "z": [0, 0, 0], "style": {"annotation": [5, 8], "aid1": [3, 1], "aid2": [1, 3]}},
        {"x": [4, 5, 6], "y": [0, 0, 0], "z": [0, 0, 1]}]}],
        "props": [{"urn": {"label": "IUPAC Name", "name": "Preferred"}, "value": {"sval": "oxo"}},
        {"urn": {"label": "Weight"}, "value": {"fval": 1.5}}]}, {"atoms": {"aid": [1], "element": [6]}, "coords": []}]}"#;
    let document = read(text).unwrap();
    assert_eq!((document.format, document.records.len(), document.frame_count()), (Format::PubChemJson, 1, 2));
    assert_eq!(document.diagnostics[0].severity, Severity::Error);
    let molecule = &document.records[0];
    assert_eq!(molecule.elements(), [Element::C, Element::O, Element::DUMMY]);
    assert_eq!((molecule.positions().get(0).x, molecule.frames()[1].positions.get(0).x), (3.25, 6.0));
    assert_eq!((molecule.formal_charge(1), molecule.isotope(0), molecule.radical(0)), (-1, 13, 2));
    assert_eq!((molecule.title(), molecule.properties().len()), ("oxo", 3));
    let [double, complex] = molecule.bonds() else { panic!("two bonds expected") };
    assert!(double.aromatic && double.order == BondOrder::Double && complex.kind == BondKind::Coordination);
    assert_eq!(molecule.bond_stereo(), [StereoMark { bond: 0, from: 0, stereo: BondStereo::Up }]);
}

#[test]
fn chemdoodle_drawings_are_scaled_and_models_are_not() {
    let drawing = r#"{"m": [{"a": [{"x": 0, "y": 0}, {"l": "O", "x": 20, "y": 20, "c": -1, "r": 1, "m": 18}],
        "b": [{"b": 0, "e": 1, "o": 2, "s": "ambiguous"}]}, {"a": []}, {"a": [{"l": "N", "x": 1, "y": 2, "z": 3}]}]}"#;
    let document = read(drawing).unwrap();
    assert_eq!((document.format, document.records.len()), (Format::ChemDoodleJson, 2));
    let [flat, model] = document.records.as_slice() else { panic!("two records expected") };
    assert_eq!(flat.elements(), [Element::C, Element::O]);
    assert!((flat.positions().get(1).length() - 1.5).abs() < 1e-12 && flat.positions().get(1).y < 0.0);
    assert_eq!((flat.formal_charge(1), flat.radical(1), flat.isotope(1)), (-1, 2, 18));
    assert_eq!(flat.bond_stereo()[0].stereo, BondStereo::CisTransEither);
    assert_eq!(model.positions().get(0).to_array(), [1.0, 2.0, 3.0]);
    let bare = one(r#"{"a": [{"x": 0, "y": 0}, {"x": 1.5, "y": 0}], "b": [{"b": 0, "e": 1}]}"#);
    assert_eq!((bare.positions().get(1).x, bare.bonds()[0].order), (1.5, BondOrder::Single));
    assert!(read(r#"{"m": []}"#).is_err());
    // Said once of all.
    let pair = r#"{"a": [{"x": 0, "y": 0}, {"x": 20, "y": 0}], "b": [{"b": 0, "e": 1}]}"#;
    let two = read(&format!(r#"{{"m": [{pair}, {pair}]}}"#)).unwrap();
    let said: Vec<&str> = two.diagnostics.iter().map(|diagnostic| diagnostic.message.as_str()).collect();
    assert_eq!(said, ["2 molecules are drawings; they are flat, with bonds scaled to 1.5 Å"]);
}
