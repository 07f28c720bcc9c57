//! Crystals of proteins: drawn as listed, or with all that is in the cell where the file says how it repeats.

use crate::files;
use ballstick::bonds::{self, BondOptions};
use ballstick::crystal::{self, CellChoice, CrystalOptions};
use ballstick::export::{mmcif, pdb};
use ballstick::import::{ImportOptions, read_bytes, read_path};
use ballstick::structure::{BondSource, Structure};

fn first(name: &str) -> Structure {
    let document = read_path(&files::data().join(name), &ImportOptions::default()).unwrap();
    document.records[0].clone()
}

fn drawn(structure: &Structure, cell: CellChoice) -> Structure {
    let options = CrystalOptions { cell, ..CrystalOptions::default() };
    crystal::draw(structure.clone(), &options).unwrap().structure
}

#[test]
fn the_cell_of_a_protein_holds_a_whole_copy_for_each_operation_of_remark_290() {
    for (name, operations) in [("1crn.pdb", 2), ("19hc.pdb.gz", 2), ("3al1.pdb.gz", 2)] {
        let listed = first(name);
        assert_eq!(listed.symmetry().unwrap().operations.len(), operations, "{name}");
        let one = bonds::assign(listed.clone(), &BondOptions::default());
        let cell = drawn(&listed, CellChoice::Full);
        assert_eq!(cell.atom_count(), operations * listed.atom_count(), "{name}");
        // Of a residue the pieces that no bond joins, alternate locations of a water, may lie on opposite sides of the cell.
        assert!(cell.residues().len() >= operations * listed.residues().len(), "{name}");
        assert!(cell.residues().len() <= operations * (listed.residues().len() + 2), "{name}");
        // As many bonds of every source; a contact between copies may add some by distance.
        for source in [BondSource::File, BondSource::Link, BondSource::Dictionary] {
            let count = |structure: &Structure| structure.bonds().iter().filter(|bond| bond.source == source).count();
            assert_eq!(count(&cell), operations * count(&one), "{name} {source:?}");
        }
    }
}

#[test]
fn a_protein_is_drawn_as_listed_unless_its_crystal_is_asked_for() {
    for name in ["1crn.pdb", "19hc.pdb.gz", "5pti.cif.gz"] {
        let listed = first(name);
        let molecule = drawn(&listed, CellChoice::Molecule);
        assert_eq!(molecule.atom_count(), listed.atom_count(), "{name}");
        assert_eq!(molecule.bonds(), bonds::assign(listed, &BondOptions::default()).bonds(), "{name}");
    }
}

#[test]
fn operations_of_remark_290_are_written_and_read_again() {
    let listed = first("19hc.pdb.gz");
    let want = &listed.symmetry().unwrap().operations;
    for (name, write) in
        [("a.pdb", pdb::write as fn(&[Structure], &mut dyn std::io::Write) -> _), ("a.cif", mmcif::write)]
    {
        let mut bytes = Vec::new();
        write(std::slice::from_ref(&listed), &mut bytes).unwrap();
        let back = read_bytes(&bytes, name, &ImportOptions::default()).unwrap();
        assert_eq!(&back.records[0].symmetry().unwrap().operations, want, "{name}");
    }
}
