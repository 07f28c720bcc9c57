//! Residues by name: what the dictionary gives, and what it must not.

use super::super::{BondMode, BondOptions, find};
use crate::element::Element;
use crate::structure::{
    AtomRecord, Bond, BondKind, BondOrder, BondSource, ComponentBond, ComponentBonds, Diagnostics, StatedBonds,
    Structure, StructureBuilder,
};
use glam::DVec3;

/// Name, element, position, residue name, residue number, alternate location.
type Atom = (&'static str, &'static str, [f64; 3], &'static str, i32, u8);

fn builder(atoms: &[Atom]) -> StructureBuilder {
    let mut builder = StructureBuilder::new();
    for &(name, symbol, position, residue, number, altloc) in atoms {
        builder.push_atom(&AtomRecord {
            element: Element::from_symbol(symbol).unwrap_or(Element::DUMMY),
            position: DVec3::from(position),
            name,
            residue: Some(("A", number, b' ', residue)),
            altloc,
            ..AtomRecord::default()
        });
    }
    builder
}

fn structure(atoms: &[Atom]) -> Structure {
    builder(atoms).build(&mut Diagnostics::default())
}

fn bonds(structure: &Structure, mode: BondMode) -> Vec<Bond> {
    find(structure, 0, &BondOptions { mode, ..BondOptions::default() })
}

fn auto(atoms: &[Atom]) -> Vec<Bond> {
    bonds(&structure(atoms), BondMode::Auto)
}

fn pairs(bonds: &[Bond]) -> Vec<(u32, u32)> {
    bonds.iter().map(|bond| (bond.a, bond.b)).collect()
}

fn sources(bonds: &[Bond]) -> Vec<BondSource> {
    bonds.iter().map(|bond| bond.source).collect()
}

const GLYCINE: [Atom; 5] = [
    ("N", "N", [0.0, 0.0, 0.0], "GLY", 1, b' '),
    ("CA", "C", [1.458, 0.0, 0.0], "GLY", 1, b' '),
    ("C", "C", [2.009, 1.42, 0.0], "GLY", 1, b' '),
    ("O", "O", [1.251, 2.39, 0.0], "GLY", 1, b' '),
    ("N", "N", [3.332, 1.536, 0.0], "ALA", 2, b' '),
];

#[test]
fn orders_come_from_the_dictionary_and_residues_are_linked() {
    let got = auto(&GLYCINE);
    assert_eq!(pairs(&got), [(0, 1), (1, 2), (2, 3), (2, 4)]);
    let orders: Vec<_> = got.iter().map(|bond| bond.order.number()).collect();
    assert_eq!(orders, [1, 1, 2, 1]);
    assert_eq!(sources(&got), [BondSource::Dictionary; 4]);
    let perceived = bonds(&structure(&GLYCINE), BondMode::Perceive);
    assert_eq!(pairs(&perceived), pairs(&got));
    assert_eq!(sources(&perceived), [BondSource::Distance; 4]);
    assert!(bonds(&structure(&GLYCINE), BondMode::File).is_empty());
}

#[test]
fn a_gap_in_the_numbers_is_bridged_by_distance_alone() {
    let mut atoms = GLYCINE;
    atoms[4].4 = 7;
    assert_eq!(pairs(&auto(&atoms)).len(), 4);
    // 1.95 Å is a stretched peptide bond, but nothing where residues are left out between.
    atoms[4].2 = [3.955, 1.536, 0.0];
    assert_eq!(pairs(&auto(&atoms)).len(), 3);
    atoms[4].4 = 2;
    assert_eq!(pairs(&auto(&atoms)).len(), 4);
}

#[test]
fn residues_at_one_place_are_each_linked_to_the_next() {
    let mut atoms = GLYCINE.to_vec();
    atoms[4].5 = b'A';
    atoms.push(("N", "N", [3.332, 1.536, 0.1], "SER", 2, b'B'));
    let got = auto(&atoms);
    assert_eq!(pairs(&got), [(0, 1), (1, 2), (2, 3), (2, 4), (2, 5)]);
}

#[test]
fn nucleotides_are_linked_by_their_phosphates() {
    let atoms = [
        ("C3*", "C", [0.0, 0.0, 0.0], "A", 1, b' '),
        ("O3*", "O", [1.42, 0.0, 0.0], "A", 1, b' '),
        ("P", "P", [2.2, 1.4, 0.0], "C", 2, b' '),
        ("O1P", "O", [3.6, 1.2, 0.4], "C", 2, b' '),
    ];
    let got = auto(&atoms);
    assert_eq!(pairs(&got), [(0, 1), (1, 2), (2, 3)]);
    assert_eq!(sources(&got), [BondSource::Dictionary; 3]);
    assert_eq!(got[2].order, BondOrder::Double);
}

/// The ring of histidine.
fn imidazole(residue: &'static str) -> Vec<Atom> {
    [
        ("CB", "C", [-1.5, 0.0, 0.0]),
        ("CG", "C", [0.0, 0.0, 0.0]),
        ("ND1", "N", [0.81, 1.12, 0.0]),
        ("CD2", "C", [0.85, -1.06, 0.0]),
        ("CE1", "C", [2.07, 0.74, 0.0]),
        ("NE2", "N", [2.12, -0.62, 0.0]),
    ]
    .map(|(name, symbol, at)| (name, symbol, at, residue, 1, b' '))
    .to_vec()
}

#[test]
fn names_of_force_fields_mean_their_residues() {
    let double = |residue| {
        let got = auto(&imidazole(residue));
        assert_eq!(got.len(), 6, "{residue}");
        assert_eq!(got.iter().filter(|bond| bond.aromatic).count(), 5, "{residue}");
        let double: Vec<_> = got.iter().filter(|bond| bond.order == BondOrder::Double).collect();
        double.iter().map(|bond| (bond.a, bond.b)).collect::<Vec<_>>()
    };
    for residue in ["HIS", "HSE", "HIE", "HIP", "NHIE"] {
        assert_eq!(double(residue), [(1, 3), (2, 4)], "{residue}");
    }
    // The hydrogen is on ND1.
    for residue in ["HSD", "HID", "CHID"] {
        assert_eq!(double(residue), [(1, 3), (4, 5)], "{residue}");
    }
}

#[test]
fn a_molecule_that_has_the_name_of_another_is_bonded_by_distance() {
    for (residue, oxygen, hydrogens) in [("SOL", "OW", ["HW1", "HW2"]), ("TIP3", "OH2", ["H1", "H2"])] {
        let got = auto(&[
            (oxygen, "O", [0.0; 3], residue, 1, b' '),
            (hydrogens[0], "H", [0.757, 0.586, 0.0], residue, 1, b' '),
            (hydrogens[1], "H", [-0.757, 0.586, 0.0], residue, 1, b' '),
        ]);
        assert_eq!((pairs(&got), sources(&got)), (vec![(0, 1), (0, 2)], vec![BondSource::Dictionary; 2]), "{residue}");
    }
    // Ions: the dictionary has molecules of these names.
    for (name, symbol) in [("CLA", "Cl"), ("POT", "K"), ("SOD", "Na"), ("CAL", "Ca"), ("CES", "Cs")] {
        assert!(auto(&[(name, symbol, [0.0; 3], name, 1, b' ')]).is_empty());
    }
    // Glycerol of the dictionary is C1–C2–C3 with O1, O2, O3 on them; this is C2–C1–C3, its oxygens turned round.
    let other = [
        ("C2", "C", [0.0, 0.0, 0.0], "GOL", 1, b' '),
        ("C1", "C", [1.5, 0.0, 0.0], "GOL", 1, b' '),
        ("C3", "C", [3.0, 0.0, 0.0], "GOL", 1, b' '),
        ("O3", "O", [0.0, 1.4, 0.0], "GOL", 1, b' '),
        ("O2", "O", [1.5, -1.4, 0.0], "GOL", 1, b' '),
        ("O1", "O", [3.0, 1.4, 0.0], "GOL", 1, b' '),
    ];
    let got = auto(&other);
    assert_eq!(pairs(&got), [(0, 1), (0, 3), (1, 2), (1, 4), (2, 5)]);
    assert_eq!(sources(&got), [BondSource::Distance; 5]);
    // The name alone says nothing.
    let unlike = [("C9", "C", [0.0; 3], "GOL", 1, b' '), ("C8", "C", [1.5, 0.0, 0.0], "GOL", 1, b' ')];
    assert_eq!(sources(&auto(&unlike)), [BondSource::Distance]);
}

#[test]
fn hydrogens_of_other_names_find_their_atoms() {
    let mut atoms = GLYCINE[..4].to_vec();
    atoms.push(("1HA", "H", [1.8, -0.5, 0.9], "GLY", 1, b' '));
    atoms.push(("HQQ", "H", [1.8, -0.5, -0.9], "GLY", 1, b' '));
    let got = auto(&atoms);
    assert_eq!(pairs(&got), [(0, 1), (1, 2), (1, 4), (1, 5), (2, 3)]);
    let source = |b: u32| got.iter().find(|bond| bond.b == b).unwrap().source;
    assert_eq!((source(4), source(5)), (BondSource::Dictionary, BondSource::Distance));
}

#[test]
fn a_bond_longer_than_any_is_left_out_and_the_rest_stays() {
    // The oxygen is on the other side of a periodic box.
    let mut atoms = GLYCINE[..4].to_vec();
    atoms[3].2 = [1.251, -27.6, 0.0];
    assert_eq!(pairs(&auto(&atoms)), [(0, 1), (1, 2)]);
    // A side chain built without density.
    atoms[3].2 = [2.009, 3.62, 0.0];
    let got = auto(&atoms);
    assert_eq!(pairs(&got), [(0, 1), (1, 2), (2, 3)]);
    assert_eq!(got[2].order, BondOrder::Double);
}

#[test]
fn a_side_chain_out_of_shape_is_that_of_its_residue_where_the_backbone_is_sound() {
    // Lysine 65 of chain B of PDB entry 4HHB, by its distances along the chain.
    let mut atoms = GLYCINE[..4].to_vec();
    for atom in &mut atoms {
        atom.3 = "LYS";
    }
    for (name, symbol, z) in
        [("CB", "C", -1.8), ("CG", "C", -2.4), ("CD", "C", -4.9), ("CE", "C", -7.2), ("NZ", "N", -9.7)]
    {
        atoms.push((name, symbol, [1.458, 0.0, z], "LYS", 1, b' '));
    }
    let got = auto(&atoms);
    assert_eq!(pairs(&got), [(0, 1), (1, 2), (1, 4), (2, 3), (4, 5), (5, 6), (6, 7), (7, 8)]);
    assert!(got.iter().filter(|bond| bond.a >= 4).all(|bond| bond.order == BondOrder::Single));
    // Without a backbone it may be anything.
    atoms[0].2 = [-3.0, 0.0, 0.0];
    assert!(pairs(&auto(&atoms)).iter().all(|&(a, b)| b < 4 || (a, b) == (1, 4) || (a, b) == (4, 5)));
}

#[test]
fn alternate_locations_are_bonded_each_to_its_own() {
    let atoms = [
        ("CB", "C", [0.0; 3], "SER", 1, b' '),
        ("OG", "O", [1.42, 0.0, 0.0], "SER", 1, b'A'),
        ("OG", "O", [0.0, 1.42, 0.0], "SER", 1, b'B'),
        ("HG", "H", [1.7, 0.9, 0.0], "SER", 1, b'A'),
        ("HG", "H", [0.9, 1.7, 0.0], "SER", 1, b'B'),
    ];
    let got = auto(&atoms);
    assert_eq!(pairs(&got), [(0, 1), (0, 2), (1, 3), (2, 4)]);
    assert_eq!(sources(&got), [BondSource::Dictionary; 4]);
}

#[test]
fn two_atoms_of_one_name_are_left_to_the_distances() {
    // Five of the six other atoms have names of their own.
    let mut atoms = GLYCINE[..4].to_vec();
    atoms.push(("OXT", "O", [3.3, 1.6, 0.0], "GLY", 1, b' '));
    atoms.push(("H", "H", [-0.5, 0.85, 0.0], "GLY", 1, b' '));
    atoms.push(("H", "H", [-0.5, -0.85, 0.0], "GLY", 1, b' '));
    let got = auto(&atoms);
    assert_eq!(pairs(&got), [(0, 1), (0, 5), (0, 6), (1, 2), (2, 3), (2, 4)]);
    let by_distance = got.iter().filter(|bond| bond.source == BondSource::Distance);
    assert_eq!(by_distance.map(|bond| bond.b).collect::<Vec<_>>(), [5, 6]);
}

#[test]
fn what_the_file_says_of_a_residue_goes_first() {
    let own = |name: &str| ComponentBonds {
        name: name.to_owned(),
        bonds: vec![
            ComponentBond { a: "CA".to_owned(), b: "N".to_owned(), order: BondOrder::Triple, aromatic: false },
            ComponentBond { a: "CA".to_owned(), b: "C".to_owned(), order: BondOrder::Single, aromatic: true },
            ComponentBond { a: "C".to_owned(), b: "O".to_owned(), order: BondOrder::Single, aromatic: false },
        ],
    };
    let mut with_own = builder(&GLYCINE[..4]);
    with_own.push_component(own("GLY"));
    let structure = with_own.build(&mut Diagnostics::default());
    for mode in [BondMode::Auto, BondMode::File] {
        let got = bonds(&structure, mode);
        assert_eq!((pairs(&got), sources(&got)), (vec![(0, 1), (1, 2), (2, 3)], vec![BondSource::File; 3]));
        assert_eq!((got[0].order, got[1].aromatic, got[2].order), (BondOrder::Triple, true, BondOrder::Single));
    }
}

#[test]
fn conect_without_repeats_takes_the_order_of_the_dictionary() {
    let mut with_conect = builder(&GLYCINE[..4]);
    with_conect.set_stated_bonds(StatedBonds::Partial);
    with_conect.push_bond(Bond::new(2, 3, BondOrder::Single, BondSource::File));
    with_conect.push_bond(Bond::new(1, 2, BondOrder::Double, BondSource::File));
    with_conect.push_bond(Bond::new(0, 3, BondOrder::Single, BondSource::Link));
    let got = bonds(&with_conect.build(&mut Diagnostics::default()), BondMode::Auto);
    assert_eq!(pairs(&got), [(0, 1), (0, 3), (1, 2), (2, 3)]);
    let orders: Vec<_> = got.iter().map(|bond| bond.order.number()).collect();
    assert_eq!(orders, [1, 1, 2, 2]);
    let expected = [BondSource::Dictionary, BondSource::Link, BondSource::File, BondSource::File];
    assert_eq!(sources(&got), expected);
}

#[test]
fn metals_of_the_dictionary_coordinate_and_have_no_further_partners_in_their_residue() {
    // Fe–S 2.2 Å, Fe–Fe 2.7 Å, which is in range of a bond.
    let atoms = [
        ("FE1", "Fe", [1.35, 0.0, 0.0], "FES", 1, b' '),
        ("FE2", "Fe", [-1.35, 0.0, 0.0], "FES", 1, b' '),
        ("S1", "S", [0.0, 1.75, 0.0], "FES", 1, b' '),
        ("S2", "S", [0.0, -1.75, 0.0], "FES", 1, b' '),
        ("SG", "S", [2.6, 0.0, 1.9], "CYS", 2, b' '),
    ];
    let got = auto(&atoms);
    assert_eq!(pairs(&got), [(0, 2), (0, 3), (0, 4), (1, 2), (1, 3)]);
    assert!(got.iter().all(|bond| (bond.kind, bond.order) == (BondKind::Coordination, BondOrder::Unknown)));
    assert_eq!(got[2].source, BondSource::Distance);
}

#[test]
fn an_atom_with_all_its_partners_takes_no_contacts() {
    let mut atoms = vec![
        ("C", "C", [0.0; 3], "CO2", 1, b' '),
        ("O1", "O", [1.16, 0.0, 0.0], "CO2", 1, b' '),
        ("O2", "O", [-1.16, 0.0, 0.0], "CO2", 1, b' '),
        ("C1", "C", [0.0, 1.7, 0.0], "LIG", 2, b' '),
    ];
    assert_eq!(pairs(&auto(&atoms)), [(0, 1), (0, 2)]);
    assert!(bonds(&structure(&atoms), BondMode::Perceive).len() > 2);
    // What lacks a partner takes one: cystine, and a thioether of haem, whose vinyl lacks only hydrogens.
    atoms = vec![
        ("CB", "C", [0.0, 1.8, 0.0], "CYS", 1, b' '),
        ("SG", "S", [0.0; 3], "CYS", 1, b' '),
        ("SG", "S", [2.05, 0.0, 0.0], "CYS", 9, b' '),
        ("CB", "C", [2.05, 0.0, 1.8], "CYS", 9, b' '),
    ];
    let got = auto(&atoms);
    assert_eq!(pairs(&got), [(0, 1), (1, 2), (2, 3)]);
    assert_eq!(got[1].source, BondSource::Distance);
    for (apart, count) in [(1.82, 3), (2.15, 2)] {
        let thioether = [
            ("C3B", "C", [0.0, -1.45, 0.0], "HEM", 1, b' '),
            ("CAB", "C", [0.0; 3], "HEM", 1, b' '),
            ("CBB", "C", [0.0, 1.34, 0.0], "HEM", 1, b' '),
            ("SG", "S", [apart, 0.0, 0.0], "CYS", 2, b' '),
        ];
        assert_eq!(auto(&thioether).len(), count, "{apart}");
    }
}

#[test]
fn names_without_atoms_of_them_are_harmless() {
    assert!(auto(&[("", "C", [0.0; 3], "", 1, b' '), ("X", "?", [1.0, 0.0, 0.0], "UNX", 2, b' ')]).is_empty());
    let mut nameless = StructureBuilder::new();
    nameless.push_atom(&AtomRecord { residue: Some(("A", 1, b' ', "ALA")), ..AtomRecord::default() });
    assert!(bonds(&nameless.build(&mut Diagnostics::default()), BondMode::Auto).is_empty());
}
