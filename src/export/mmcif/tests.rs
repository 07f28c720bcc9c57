use super::*;
use crate::bonds::{self, BondOptions};
use crate::element::Element;
use crate::export::formats::StructureFormat;
use crate::export::tests::written;
use crate::import::{Document, ImportOptions, read_bytes};
use crate::structure::{
    AtomRecord, BondSource, Cell, ComponentBond, Diagnostics, SecondaryElement, StatedBonds, StructureBuilder, Symmetry,
};
use glam::DVec3;

fn text(records: &[Structure]) -> String {
    written(|out| write(records, out))
}

fn read(text: &str) -> Document {
    read_bytes(text.as_bytes(), "a.cif", &ImportOptions::default()).unwrap()
}

/// Residue, atom name, element.
type Atom<'a> = ((&'a str, i32, &'a str), &'a str, Element);

fn structure(atoms: &[Atom<'_>], bonds: &[(u32, u32, BondOrder, BondSource)]) -> Structure {
    let mut builder = StructureBuilder::new();
    builder.set_decimals(3);
    for (n, ((chain, number, residue), name, element)) in atoms.iter().enumerate() {
        builder.push_atom(&AtomRecord {
            element: *element,
            position: DVec3::new(n as f64 * 1.5, 0.0, -0.25),
            name,
            residue: Some((chain, *number, b' ', residue)),
            ..AtomRecord::default()
        });
    }
    for &(a, b, order, source) in bonds {
        builder.push_bond(Bond::new(a, b, order, source));
    }
    builder.build(&mut Diagnostics::default())
}

const FAR: BondSource = BondSource::Distance;

#[test]
fn everything_that_is_held_comes_back() {
    let mut builder = StructureBuilder::new();
    builder.set_title("It's a \"title\"");
    builder.set_decimals(2);
    builder.set_cell(Cell::from_parameters([10.0, 11.5, 7.25], [92.5, 101.25, 118.0]));
    builder.set_symmetry(Some(Symmetry {
        space_group: "P 21/c".to_owned(),
        operations: ["x,y,z", "-x,y+1/2,-z+1/2", "y-x,z,x-2/3"]
            .iter()
            .filter_map(|t| SymmetryOperation::from_triplet(t))
            .collect(),
    }));
    builder.push_secondary(SecondaryElement {
        helix: true,
        chain: "A b".to_owned(),
        first: (1, b' '),
        last: (9, b'C'),
    });
    builder.push_secondary(SecondaryElement {
        helix: false,
        chain: "A b".to_owned(),
        first: (11, b'A'),
        last: (12, b' '),
    });
    let atom = AtomRecord {
        element: Element::H,
        position: DVec3::new(-0.004, 12.5, 1e4),
        name: "H'\" 1",
        serial: Some(70),
        residue: Some(("A b", -3, b'Z', "_X")),
        flags: atom_flags::HETERO,
        altloc: b'\'',
        occupancy: 0.333,
        b_factor: 12.345,
        formal_charge: -1,
        isotope: 2,
        ..AtomRecord::default()
    };
    builder.push_atom(&atom);
    builder.push_atom(&AtomRecord {
        element: Element::DUMMY,
        serial: Some(80),
        name: "?",
        flags: atom_flags::PARTICLE,
        isotope: 0,
        altloc: b' ',
        ..atom
    });
    assert!(builder.push_frame(&[DVec3::ZERO, DVec3::splat(1.25)], None, ""));
    let want = builder.build(&mut Diagnostics::default());
    let document = read(&text(std::slice::from_ref(&want)));
    let got = &document.records[0];
    assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
    assert_eq!((got.title(), got.secondary(), got.symmetry()), (want.title(), want.secondary(), want.symmetry()));
    assert_eq!((got.elements(), got.frames().len()), (want.elements(), 2));
    let [one, other] = [got, &want].map(|s| [s.cell().unwrap().lengths(), s.cell().unwrap().angles_deg()].concat());
    assert!(one.iter().zip(&other).all(|(one, other)| (one - other).abs() < 1e-9));
    for i in 0..2 {
        let of = |s: &Structure| {
            let residue = s.residues()[s.residue_index(i).unwrap()];
            let names =
                (s.atom_name(i).to_owned(), s.name(residue.name).to_owned(), s.chains().next().map(str::to_owned));
            let numbers = (s.serial(i), residue.number, residue.insertion_code, s.altloc(i), s.flags(i));
            let values = (s.occupancy(i), s.b_factor(i), s.formal_charge(i), s.isotope(i));
            let positions: Vec<DVec3> = s.frames().iter().map(|frame| frame.positions.written(i)).collect();
            (names, numbers, values, positions)
        };
        assert_eq!(of(got), of(&want));
    }
}

#[test]
fn bonds_that_all_residues_of_a_name_have_stand_under_the_name() {
    let water = |n| [(("A", n, "HOH"), "O", Element::O), (("A", n, "HOH"), "H1", Element::H)];
    let atoms: Vec<Atom<'_>> = [water(1), water(2), water(3)].concat();
    let bond = |a, order| (a, a + 1, order, FAR);
    let single = BondOrder::Single;
    let all = structure(&atoms, &[bond(0, single), bond(2, single), bond(4, single)]);
    let written = text(std::slice::from_ref(&all));
    assert!(written.contains("\nHOH O H1 SING N\n") || written.contains("\nHOH H1 O SING N\n"), "{written}");
    assert!(!written.contains("_struct_conn"));
    // One of them has none, or another order: each bond for itself.
    for bonds in
        [vec![bond(0, single), bond(4, single)], vec![bond(0, single), bond(2, BondOrder::Double), bond(4, single)]]
    {
        let some = structure(&atoms, &bonds);
        let document = read(&text(std::slice::from_ref(&some)));
        let got: Vec<_> = document.records[0].bonds().iter().map(|bond| (bond.a, bond.b, bond.order, FAR)).collect();
        assert_eq!(got, bonds);
        assert!(document.records[0].components().is_empty());
    }
}

#[test]
fn links_are_written_by_their_kind_and_inferred_polymer_links_are_not() {
    let atoms = [
        (("A", 1, "CYS"), "SG", Element::S),
        (("A", 1, "CYS"), "C", Element::C),
        (("A", 2, "CYS"), "N", Element::N),
        (("A", 2, "CYS"), "SG", Element::S),
        (("B", 1, "ZN"), "ZN", Element::from_symbol("Zn").unwrap()),
    ];
    let bonds = [
        (0, 3, BondOrder::Single, BondSource::Link),
        (1, 2, BondOrder::Single, FAR),
        (1, 3, BondOrder::Double, BondSource::File),
    ];
    let mut record = structure(&atoms, &bonds);
    let mut list = record.bonds().to_vec();
    list.push(Bond { kind: BondKind::Coordination, ..Bond::new(3, 4, BondOrder::Unknown, FAR) });
    list.push(Bond { kind: BondKind::Hydrogen, ..Bond::new(0, 2, BondOrder::Unknown, BondSource::Link) });
    record = record.with_bonds(list);
    let written = text(std::slice::from_ref(&record));
    for word in ["disulf1 disulf", "covale1 covale", "metalc1 metalc", "hydrog1 hydrog", "\nmetalc ? ?\n"] {
        assert!(written.contains(word), "{word}\n{written}");
    }
    let document = read(&written);
    let got: Vec<_> = document.records[0].bonds().iter().map(|bond| (bond.a, bond.b, bond.kind, bond.order)).collect();
    let want = [
        (0, 2, BondKind::Hydrogen, BondOrder::Unknown),
        (0, 3, BondKind::Covalent, BondOrder::Single),
        (1, 3, BondKind::Covalent, BondOrder::Double),
        (3, 4, BondKind::Coordination, BondOrder::Unknown),
    ];
    assert_eq!(got, want);
}

#[test]
fn bonds_of_metals_keep_their_kinds() {
    // Of two nitrogens on iron one is bonded and one coordinates, as an SD file may say; a third in range does neither.
    let mut builder = StructureBuilder::new();
    for (symbol, at) in [
        ("Fe", [0.0; 3]),
        ("N", [2.0, 0.0, 0.0]),
        ("N", [0.0, 2.0, 0.0]),
        ("N", [0.0, 0.0, 2.3]),
        ("O", [-1.6, 0.0, 0.0]),
    ] {
        let element = Element::from_symbol(symbol).unwrap();
        builder.push_atom(&AtomRecord { element, position: glam::DVec3::from(at), ..AtomRecord::default() });
    }
    for atom in 3..5 {
        // A bond of its own, so that its names are known.
        builder.push_atom(&AtomRecord {
            element: Element::H,
            position: glam::DVec3::new(0.0, f64::from(atom), 3.0),
            ..AtomRecord::default()
        });
    }
    let listed = [
        Bond::new(0, 1, BondOrder::Single, BondSource::File),
        Bond { kind: BondKind::Coordination, ..Bond::new(0, 2, BondOrder::Unknown, BondSource::File) },
        Bond::new(0, 4, BondOrder::Double, BondSource::File),
        Bond::new(3, 5, BondOrder::Single, BondSource::File),
        Bond::new(3, 6, BondOrder::Single, BondSource::File),
    ];
    for bond in listed {
        builder.push_bond(bond);
    }
    builder.set_stated_bonds(StatedBonds::Complete);
    let record = builder.build(&mut Diagnostics::default());
    let document = read(&text(std::slice::from_ref(&record)));
    let back = bonds::assign(document.records[0].clone(), &BondOptions::default());
    let facts = |structure: &Structure| -> Vec<_> {
        structure.bonds().iter().map(|bond| (bond.a, bond.b, bond.kind, bond.order)).collect()
    };
    assert_eq!(facts(&back)[..3], facts(&record)[..3]);
    assert!(facts(&back).iter().all(|&(a, b, ..)| (a, b) != (0, 3)));
}

#[test]
fn bonds_of_atoms_that_cannot_be_told_are_named_as_lost() {
    let atoms = [(("A", 1, "X"), "C", Element::C), (("A", 1, "X"), "C", Element::C)];
    let record = structure(&atoms, &[(0, 1, BondOrder::Single, FAR)]);
    let format = StructureFormat::from_name("cif").unwrap();
    assert_eq!((format.name, format.holds_bonds()), ("mmcif", true));
    let losses = format.losses(std::slice::from_ref(&record));
    assert!(losses.iter().any(|loss| loss.contains("share their name")), "{losses:?}");
}

#[test]
fn a_molecule_without_residues_gets_names_for_its_bonds() {
    let mut builder = StructureBuilder::new();
    for element in [Element::C, Element::O, Element::O] {
        builder.push_atom(&AtomRecord { element, ..AtomRecord::default() });
    }
    builder.push_bond(Bond { aromatic: true, ..Bond::new(0, 1, BondOrder::Unknown, BondSource::File) });
    builder.push_bond(Bond::new(0, 2, BondOrder::Double, BondSource::File));
    builder.set_stated_bonds(StatedBonds::Complete);
    let record = builder.build(&mut Diagnostics::default());
    let format = StructureFormat::from_name("mmcif").unwrap();
    assert!(format.losses(std::slice::from_ref(&record)).is_empty());
    let document = read(&text(&[record.clone(), record]));
    assert_eq!(document.records.len(), 2);
    let back = &document.records[0];
    assert_eq!([0, 1, 2].map(|atom| back.atom_name(atom)), ["C1", "O1", "O2"]);
    let bond = |b: &str, order, aromatic| ComponentBond { a: "C1".to_owned(), b: b.to_owned(), order, aromatic };
    assert_eq!(back.components()[0].name, "UNL");
    assert_eq!(
        back.components()[0].bonds,
        [bond("O1", BondOrder::Unknown, true), bond("O2", BondOrder::Double, false)]
    );
}

#[test]
fn neighbours_with_equal_names_stay_apart() {
    let mut builder = StructureBuilder::new();
    for _ in 0..3 {
        builder.begin_residue("A", 1, b' ', "HOH");
        builder.push_residue_atom(&AtomRecord { element: Element::O, name: "O", ..AtomRecord::default() });
    }
    let record = builder.build(&mut Diagnostics::default());
    assert_eq!(read(&text(&[record])).records[0].residues().len(), 3);
}

#[test]
fn operations_are_written_as_they_are_read() {
    for text in ["x,y,z", "-x,y+1/2,-z", "x-y,-y,-z+1/3", "-z,-x+3/4,y-1/24", "x+0.1234,y,z"] {
        assert_eq!(triplet(&SymmetryOperation::from_triplet(text).unwrap()), text);
    }
}
