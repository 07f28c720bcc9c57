use super::*;
use crate::element::Element;
use crate::structure::{
    AtomRecord, BondOrder, BondSource, Diagnostics, StatedBonds, StructureBuilder, Symmetry, SymmetryOperation,
};

/// Atoms at fractional positions of a cubic cell, and operations beside the identity.
fn crystal(edge: f64, atoms: &[(&str, [f64; 3])], operations: &[&str]) -> Structure {
    let mut builder = StructureBuilder::new();
    for (symbol, at) in atoms {
        let element = Element::from_symbol(symbol).unwrap();
        builder.push_atom(&AtomRecord { element, position: DVec3::from(*at) * edge, ..AtomRecord::default() });
    }
    builder.set_cell(Cell::from_parameters([edge; 3], [90.0; 3]));
    if !operations.is_empty() {
        let others = operations.iter().map(|text| SymmetryOperation::from_triplet(text).unwrap());
        let operations = std::iter::once(SymmetryOperation::IDENTITY).chain(others).collect();
        builder.set_symmetry(Some(Symmetry { space_group: "given".to_owned(), operations }));
    }
    builder.build(&mut Diagnostics::default())
}

fn drawn(structure: &Structure, cell: CellChoice, supercell: [u32; 3]) -> Drawn {
    draw(structure.clone(), &CrystalOptions { cell, supercell, ..CrystalOptions::default() }).unwrap()
}

/// Face-centred positions, shifted.
fn face_centred(symbol: &'static str, by: f64) -> Vec<(&'static str, [f64; 3])> {
    let at = [[0.0, 0.0, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0]];
    at.map(|at| (symbol, at.map(|x| x + by))).to_vec()
}

#[test]
fn a_molecule_cut_by_a_face_is_drawn_whole() {
    // Carbon dioxide across a corner: the oxygens come to the carbon, which is listed first.
    let co2 = crystal(6.0, &[("C", [0.02, 0.02, 0.5]), ("O", [0.21, 0.02, 0.5]), ("O", [0.83, 0.02, 0.5])], &[]);
    let whole = drawn(&co2, CellChoice::Molecule, [1; 3]);
    assert_eq!(whole.structure.bonds().len(), 2);
    assert!(whole.stubs.is_empty() && !whole.is_cell_content);
    let farthest = (0..3).map(|atom| (whole.structure.positions().get(atom) - DVec3::new(0.12, 0.12, 3.0)).length());
    assert!(farthest.fold(0.0, f64::max) < 1.2);
    // As listed, the bond ends at the face on both sides: 0.12 Å + 1.02 Å = the bond.
    let listed = drawn(&co2, CellChoice::Asym, [1; 3]);
    assert_eq!((listed.structure.bonds().len(), listed.stubs.len()), (1, 2));
    let lengths: f64 = listed.stubs.iter().map(|stub| stub.part * stub.vector.length()).sum();
    assert!((lengths - listed.stubs[0].vector.length()).abs() < 1e-9);
    // Two cells: two whole molecules.
    let two = drawn(&co2, CellChoice::Molecule, [2, 1, 1]);
    assert_eq!((two.structure.atom_count(), two.structure.bonds().len(), two.stubs.len()), (6, 4, 0));
    assert!((two.cell.unwrap().lengths()[0] - 12.0).abs() < 1e-12);
}

#[test]
fn symmetry_completes_a_molecule_and_merges_special_positions() {
    // Half a molecule of water about a twofold axis along z, its oxygen on the axis but for rounding.
    let half =
        crystal(8.0, &[("O", [0.0001, 0.0, 0.25]), ("H", [0.0945, 0.0, 0.3232])], &["-x,-y,z", "x,-y,-z", "-x,y,-z"]);
    let molecule = drawn(&half, CellChoice::Molecule, [1; 3]);
    assert_eq!(molecule.structure.elements(), [Element::O, Element::H, Element::H]);
    assert_eq!(molecule.listed, [0, 1, 1], "a copy knows which atom of the file it is");
    assert_eq!(molecule.structure.bonds().len(), 2);
    let full = drawn(&half, CellChoice::Full, [1; 3]);
    assert_eq!((full.structure.atom_count(), full.structure.bonds().len()), (6, 4));
    let listed = drawn(&half, CellChoice::Asym, [1; 3]);
    assert_eq!((listed.structure.atom_count(), listed.structure.bonds().len()), (2, 1));
}

#[test]
fn a_network_is_drawn_as_the_cell_with_atoms_on_all_equivalent_faces() {
    let salt = crystal(5.64, &[face_centred("Na", 0.0), face_centred("Cl", 0.5)].concat(), &[]);
    for (supercell, sodium, chlorine) in [([1, 1, 1], 14, 13), ([2, 1, 1], 23, 22)] {
        let cell = drawn(&salt, CellChoice::Molecule, supercell);
        let count = |symbol| {
            let element = Element::from_symbol(symbol).unwrap();
            cell.structure.elements().iter().filter(|&&other| other == element).count()
        };
        assert_eq!((count("Na"), count("Cl")), (sodium, chlorine), "{supercell:?}");
        assert!(cell.is_cell_content && cell.stubs.is_empty(), "{:?}", cell.stubs);
    }
    // 54 bonds: 12 edges and 3 axes through the middle, of two bonds each, and 6 faces of two lines of two.
    assert_eq!(drawn(&salt, CellChoice::Full, [1; 3]).structure.bonds().len(), 54);
    // Diamond: the atoms inside have all four bonds, those on faces one to the inside each.
    let diamond = crystal(3.567, &[face_centred("C", 0.0), face_centred("C", 0.25)].concat(), &[]);
    let cell = drawn(&diamond, CellChoice::Molecule, [1; 3]);
    assert_eq!((cell.structure.atom_count(), cell.structure.bonds().len(), cell.stubs.len()), (18, 16, 0));
}

#[test]
fn bonds_of_a_network_to_the_outside_end_at_the_faces() {
    // Polonium in the middle of its cubic cell: six half bonds.
    let polonium = crystal(3.359, &[("Po", [0.5, 0.5, 0.5])], &[]);
    let cell = drawn(&polonium, CellChoice::Molecule, [1; 3]);
    assert_eq!((cell.structure.atom_count(), cell.stubs.len()), (1, 6));
    assert!(cell.stubs.iter().all(|stub| (stub.part - 0.5).abs() < 1e-6));
    let two = drawn(&polonium, CellChoice::Molecule, [2, 1, 1]);
    assert_eq!((two.structure.bonds().len(), two.stubs.len()), (1, 10));
}

#[test]
fn disorder_about_a_special_position_gives_alternatives() {
    // A methyl carbon beside a mirror that its image overlaps with, and a chlorine clear of it.
    let mut builder = StructureBuilder::new();
    for (element, x, flags) in [(Element::C, 0.02, atom_flags()), (Element::CL, 0.3, 0)] {
        builder.push_atom(&AtomRecord {
            element,
            position: DVec3::new(x * 9.0, 2.0, 3.0),
            flags,
            altloc: if flags == 0 { b' ' } else { b'1' },
            ..AtomRecord::default()
        });
    }
    builder.set_cell(Cell::from_parameters([9.0; 3], [90.0; 3]));
    let operations = vec![SymmetryOperation::IDENTITY, SymmetryOperation::from_triplet("-x,y,z").unwrap()];
    builder.set_symmetry(Some(Symmetry { space_group: "P m".to_owned(), operations }));
    let full = drawn(&builder.build(&mut Diagnostics::default()), CellChoice::Full, [1; 3]);
    let mut codes: Vec<u8> = (0..full.structure.atom_count()).map(|atom| full.structure.altloc(atom)).collect();
    codes.sort_unstable();
    assert_eq!(codes, [b' ', b' ', b'1', b'a']);
    assert!(full.structure.bonds().is_empty());
}

fn atom_flags() -> u8 {
    crate::structure::atom_flags::SYMMETRY_DISORDER
}

#[test]
fn what_a_file_states_of_a_residue_holds_in_all_copies() {
    // Two atoms of a residue with a stated bond of 2.4 Å, which no distance would find, beside a twofold axis, and an ion on
    // the axis that is there once.
    let mut builder = StructureBuilder::new();
    for (element, at, number) in
        [(Element::S, [3.0, 2.0, 3.0], 1), (Element::S, [3.0, 2.0, 5.4], 1), (Element::CL, [0.0, 5.0, 0.0], 2)]
    {
        builder.push_atom(&AtomRecord {
            element,
            position: DVec3::from(at),
            residue: Some(("A", number, b' ', "XXX")),
            ..AtomRecord::default()
        });
    }
    builder.push_bond(Bond::new(0, 1, BondOrder::Single, BondSource::Link));
    builder.set_stated_bonds(StatedBonds::Partial);
    builder.set_cell(Cell::from_parameters([10.0; 3], [90.0; 3]));
    let operations = ["x,y,z", "-x,y,-z"].map(|text| SymmetryOperation::from_triplet(text).unwrap()).to_vec();
    builder.set_symmetry(Some(Symmetry { space_group: "P 1 2 1".to_owned(), operations }));
    let structure = builder.build(&mut Diagnostics::default());
    let full = drawn(&structure, CellChoice::Full, [1; 3]).structure;
    let residues: Vec<(i32, u32)> = full.residues().iter().map(|r| (r.number, r.first_atom)).collect();
    assert_eq!((full.atom_count(), full.bonds().len()), (5, 2), "{residues:?}");
    assert!(full.bonds().iter().all(|bond| bond.source == BondSource::Link));
    let length = |bond: &Bond| full.positions().get(bond.a as usize).distance(full.positions().get(bond.b as usize));
    assert!(full.bonds().iter().all(|bond| (length(bond) - 2.4).abs() < 1e-9));
    assert_eq!(drawn(&structure, CellChoice::Molecule, [1; 3]).structure.atom_count(), 3);
}

#[test]
fn more_atoms_than_the_limit_are_refused_with_what_to_do() {
    let salt = crystal(5.64, &face_centred("Na", 0.0), &[]);
    let options = CrystalOptions { supercell: [u32::MAX; 3], ..CrystalOptions::default() };
    let message = draw(salt, &options).unwrap_err().to_string();
    assert!(message.contains("--supercell"), "{message}");
}

#[test]
fn what_has_no_cell_is_drawn_as_it_is() {
    let mut builder = StructureBuilder::new();
    for x in [0.0, 0.74] {
        builder.push_atom(&AtomRecord {
            element: Element::H,
            position: DVec3::new(x, 0.0, 0.0),
            ..AtomRecord::default()
        });
    }
    let got = drawn(&builder.build(&mut Diagnostics::default()), CellChoice::Full, [3; 3]);
    assert_eq!((got.structure.bonds().len(), got.cell, got.is_cell_content), (1, None, false));
}
