use crate::element::Element;
use crate::error::{Error, Result};
use crate::import::{Document, Format, ImportOptions, read_bytes};
use crate::structure::{BondKind, BondOrder, BondStereo, Severity, StatedBonds, StereoMark, Structure, atom_flags};

fn read(text: &str) -> Result<Document> {
    read_bytes(text.as_bytes(), "a.sdf", &ImportOptions { format: Some(Format::Sdf), ..ImportOptions::default() })
}

fn one(text: &str) -> Structure {
    let document = read(text).unwrap();
    assert_eq!(document.records.len(), 1);
    document.records[0].clone()
}

/// A record of atoms given by symbol, mass difference, charge code and bonds given by a, b, type, stereo.
fn molfile(atoms: &[(&str, i32, i32)], bonds: &[[i32; 4]], properties: &str) -> String {
    let mut text =
        format!("name\n  program\ncomment\n{:3}{:3}  0  0  0  0  0  0  0  0999 V2000\n", atoms.len(), bonds.len());
    for (index, (symbol, mass, charge)) in atoms.iter().enumerate() {
        text += &format!("{:10.4}{:10.4}{:10.4} {symbol:<3}{mass:2}{charge:3}  0  0  0\n", index as f64, 0.5, -0.25);
    }
    for [a, b, kind, stereo] in bonds {
        text += &format!("{a:3}{b:3}{kind:3}{stereo:3}\n");
    }
    text + properties
}

const END: &str = "M  END\n";

#[test]
fn a_record_is_read_with_its_data() {
    let data = "M  END\n> <A NAME>\nline 1\nline 2\n\n>  25  <MELTING.POINT> (MD-1)\n179.0\n\n> <EMPTY>\n\n$$$$\n";
    let text = molfile(&[("C", 0, 0), ("O", 0, 5), ("Cl", 0, 0)], &[[1, 2, 2, 0], [1, 3, 1, 1]], data);
    let molecule = one(&text);
    assert_eq!(molecule.title(), "name");
    assert_eq!(molecule.elements(), [Element::C, Element::O, Element::CL]);
    assert_eq!(molecule.positions().written(2).to_array(), [2.0, 0.5, -0.25]);
    assert_eq!(molecule.formal_charge(1), -1);
    assert_eq!(molecule.bonds().iter().map(|bond| bond.order.number()).collect::<Vec<_>>(), [2, 1]);
    assert_eq!(molecule.bond_stereo(), [StereoMark { bond: 1, from: 0, stereo: BondStereo::Up }]);
    assert_eq!(molecule.stated_bonds(), StatedBonds::Complete);
    let properties: Vec<_> = molecule.properties().iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
    assert_eq!(properties, [("A NAME", "line 1\nline 2"), ("MELTING.POINT", "179.0"), ("EMPTY", "")]);
}

#[test]
fn property_lines_supersede_the_atom_block() {
    let atoms = [("N", 0, 3), ("O", 1, 5), ("C", 0, 4), ("D", 0, 0)];
    let plain = one(&molfile(&atoms, &[], END));
    assert_eq!((plain.formal_charge(0), plain.isotope(1), plain.radical(2), plain.isotope(3)), (1, 17, 2, 2));
    let lines = "M  CHG  1   3  -2\nM  RAD  1   1   3\nM  ISO  1   3  13\nM  END\n";
    let changed = one(&molfile(&atoms, &[], lines));
    let charges: Vec<i8> = (0..4).map(|atom| changed.formal_charge(atom)).collect();
    assert_eq!(charges, [0, 0, -2, 0]);
    assert_eq!((changed.radical(0), changed.radical(2)), (3, 0));
    assert_eq!((0..4).map(|atom| changed.isotope(atom)).collect::<Vec<_>>(), [0, 0, 13, 2]);
}

#[test]
fn bond_types_beyond_three_keep_their_meaning() {
    let text = molfile(&[("C", 0, 0), ("Fe", 0, 0), ("N", 0, 0)], &[[1, 3, 4, 0], [2, 3, 8, 0], [1, 2, 9, 0]], END);
    let molecule = one(&text);
    let bonds: Vec<_> = molecule.bonds().iter().map(|bond| (bond.order, bond.aromatic, bond.kind)).collect();
    let unknown = BondOrder::Unknown;
    assert_eq!(
        bonds,
        [
            (unknown, false, BondKind::Dative),
            (unknown, true, BondKind::Covalent),
            (unknown, false, BondKind::Coordination)
        ]
    );
}

#[test]
fn counts_of_three_digits_touch() {
    let atoms = vec![("C", 0, 0); 120];
    let bonds: Vec<[i32; 4]> = (1..120).map(|n| [n, n + 1, 1, 0]).collect();
    let molecule = one(&molfile(&atoms, &bonds, END));
    assert_eq!((molecule.atom_count(), molecule.bonds().len()), (120, 119));
}

#[test]
fn queries_and_groups_are_particles() {
    let molecule = one(&molfile(&[("R#", 0, 0), ("*", 0, 0), ("R1", 0, 0), ("Q", 0, 0), ("c", 0, 0)], &[], END));
    for atom in 0..4 {
        assert_eq!((molecule.elements()[atom], molecule.flags(atom)), (Element::DUMMY, atom_flags::PARTICLE), "{atom}");
    }
    assert_eq!((molecule.elements()[4], molecule.atom_name(0)), (Element::C, "R#"));
}

#[test]
fn a_bad_record_does_not_take_the_others_with_it() {
    let good = molfile(&[("C", 0, 0)], &[], "M  END\n$$$$\n");
    let bad = good.replace("    0.5000", "   zero   ");
    let cut = molfile(&[("C", 0, 0)], &[], "").replace("  1  0  0", "  2  0  0") + "M  END\n$$$$\n";
    let document = read(&format!("{good}{bad}{cut}{good}\r\n\r\n")).unwrap();
    assert_eq!(document.records.len(), 2);
    let lines: Vec<_> = document.diagnostics.iter().map(|d| (d.severity, d.line)).collect();
    assert_eq!(lines, [(Severity::Error, Some(12)), (Severity::Error, Some(20))]);
    assert!(read(&bad).is_err());
}

#[test]
fn bonds_to_nowhere_are_left_out() {
    let document =
        read(&molfile(&[("C", 0, 0), ("C", 0, 0)], &[[1, 900, 1, 0], [1, 1, 1, 0], [2, 1, 1, 0], [1, 2, 2, 0]], END))
            .unwrap();
    let bonds = document.records[0].bonds();
    assert_eq!((bonds.len(), bonds[0].order), (1, BondOrder::Single));
    assert!(document.diagnostics.iter().any(|d| d.severity == Severity::Error && d.line == Some(7)));
}

#[test]
fn loose_layouts_are_understood() {
    let text = "name\n\n2 1 0 0 0 0 0 0 0 0 999 V2000\n";
    let words = format!("{text} 0.0 0.0 0.0 C 0 0\n 1.2 0.0 0.0 O 0 0\n1 2 2 0\n");
    let molecule = one(&words.replace("name\n\n", "name\n\n\n"));
    assert_eq!((molecule.atom_count(), molecule.bonds()[0].order), (2, BondOrder::Double));
    let no_end = molfile(&[("C", 0, 0)], &[], "> <X>\n1\n\n$$$$\n");
    assert_eq!(one(&no_end).properties().len(), 1);
    let short_header = molfile(&[("C", 0, 0)], &[], END).replace("comment\n", "");
    assert_eq!(read(&short_header).unwrap().diagnostics.len(), 1);
    let no_break = molfile(&[("C", 0, 0)], &[], END).replace("  1  0  0", "  1\u{a0} 0  0");
    assert_eq!(one(&no_break).atom_count(), 1);
}

#[test]
fn an_alias_is_no_property() {
    let text = molfile(&[("C", 0, 0)], &[], "A    1\nM  END\nM  CHG  1   1   1\nM  END\n");
    assert_eq!(one(&text).formal_charge(0), 1);
}

/// A V3000 record of ATOM and BOND lines, with more behind the bonds.
fn v3000(atoms: &[&str], bonds: &[&str], more: &str) -> String {
    let mut text = format!(
        "name\n prog\n\n  0  0  0     0  0            999 V3000\nM  V30 BEGIN CTAB\nM  V30 COUNTS {} {} 0 0 0\n",
        atoms.len(),
        bonds.len()
    );
    text += "M  V30 BEGIN ATOM\n";
    for atom in atoms {
        text += &format!("M  V30 {atom}\n");
    }
    text += "M  V30 END ATOM\nM  V30 BEGIN BOND\n";
    for bond in bonds {
        text += &format!("M  V30 {bond}\n");
    }
    text + "M  V30 END BOND\n" + more + "M  V30 END CTAB\nM  END\n"
}

#[test]
fn a_v3000_record_is_read_with_its_keys_and_continuations() {
    let atoms = [
        "1 C 0.5 -1 2.125 0 CHG=-1 RAD=2 MASS=13 CFG=1",
        "2 \"NOT[N,O]\" 1 0 0 0",
        "3 [N, O] 2 0 0 0",
        "9 O 3 0 -\nM  V30 0 0 CHG=-\nM  V30 1",
        "5 R# 4 0 0 0 RGROUPS=(1 1)",
    ];
    let bonds = ["1 1 9 1 CFG=3", "2 2 1 2 CFG=2", "3 4 1 3", "4 10 3 5"];
    let more = "M  V30 BEGIN SGROUP\nM  V30 1 DAT 0 ATOMS=(1 1) FIELDNAME=\"BEGIN ATOM\"\nM  V30 END SGROUP\n\
                M  V30 BEGIN COLLECTION\nM  V30 MDLV30/STEABS ATOMS=(1 1)\nM  V30 END COLLECTION\n";
    let text = v3000(&atoms, &bonds, more) + "> <X>\n1\n\n$$$$\n";
    let molecule = one(&text);
    assert_eq!(molecule.title(), "name");
    assert_eq!(molecule.positions().written(0).to_array(), [0.5, -1.0, 2.125]);
    assert_eq!((molecule.formal_charge(0), molecule.radical(0), molecule.isotope(0)), (-1, 2, 13));
    assert_eq!((molecule.formal_charge(3), molecule.elements()[3]), (1, Element::O));
    assert!([1, 2, 4].iter().all(|&atom| molecule.flags(atom) == atom_flags::PARTICLE));
    assert_eq!(molecule.atom_name(1), "NOT[N,O]");
    let kinds: Vec<_> = molecule.bonds().iter().map(|b| (b.a, b.b, b.order.number(), b.aromatic, b.kind)).collect();
    let covalent = BondKind::Covalent;
    let want = [(0, 1, 2, false, covalent), (0, 2, 0, true, covalent), (0, 3, 1, false, covalent)];
    assert_eq!(kinds[..3], want);
    assert_eq!(kinds[3], (2, 4, 0, false, BondKind::Hydrogen));
    let marks = [
        StereoMark { bond: 2, from: 3, stereo: BondStereo::Down },
        StereoMark { bond: 0, from: 0, stereo: BondStereo::CisTransEither },
    ];
    assert_eq!(molecule.bond_stereo(), marks);
    assert_eq!(molecule.properties(), [("X".to_owned(), "1".to_owned())]);
}

#[test]
fn a_ligand_that_binds_as_a_whole_coordinates_with_each_atom() {
    let atoms = ["1 C 1 0 0 0", "2 C 0 1 0 0", "3 Fe 0 0 2 0", "4 * 0 0 0 0"];
    let molecule = one(&v3000(&atoms, &["1 2 1 2", "2 9 4 3 ENDPTS=(2 1 2) ATTACH=ALL"], ""));
    let pairs: Vec<_> = molecule.bonds().iter().map(|bond| (bond.a, bond.b, bond.kind)).collect();
    let coordination = BondKind::Coordination;
    assert_eq!(pairs, [(0, 1, BondKind::Covalent), (0, 2, coordination), (1, 2, coordination)]);
    let any = one(&v3000(&atoms, &["1 1 4 3 ENDPTS=(2 1 2) ATTACH=ANY"], ""));
    assert_eq!((any.bonds()[0].a, any.bonds()[0].b, any.bonds().len()), (2, 3, 1));
}

#[test]
fn versions_may_differ_from_record_to_record() {
    let old = molfile(&[("C", 0, 0)], &[], "M  END\n$$$$\n");
    let new = v3000(&["1 N 0 0 0 0"], &[], "") + "$$$$\n";
    let document = read(&format!("{old}{new}{old}")).unwrap();
    let elements: Vec<_> = document.records.iter().map(|record| record.elements()[0]).collect();
    assert_eq!(elements, [Element::C, Element::N, Element::C]);
}

#[test]
fn a_v3000_table_that_is_not_whole_is_an_error_with_its_line() {
    let whole = v3000(&["1 C 0 0 0 0", "2 C 1 0 0 0"], &["1 1 1 2"], "");
    for (text, line) in [
        (whole.replace("COUNTS 2", "COUNTS 3"), 15),
        (whole.replace("2 C 1 0 0 0", "2 C 1 zero 0 0"), 9),
        (whole.replace("2 C 1 0 0 0", "1 C 1 0 0 0"), 9),
        (whole.replace("1 1 1 2", "1 1 1"), 12),
        (whole.split("M  V30 END BOND").next().unwrap_or_default().to_owned(), 13),
        (v3000(&[], &[], ""), 12),
    ] {
        let error = read(&text).unwrap_err();
        assert_eq!(error.line(), Some(line), "{error}: {text}");
    }
    let document = read(&whole.replace("1 1 1 2", "1 1 1 7")).unwrap();
    assert!(document.records[0].bonds().is_empty() && document.diagnostics[0].severity == Severity::Error);
}
