//! mmCIF out and in again: every molecule of `data/` and the corpus, with all its bonds and with those its file states.

use crate::files;
use ballstick::bonds::{self, BondMode, BondOptions};
use ballstick::export::mmcif;
use ballstick::import::{ImportOptions, read_bytes, read_path};
use ballstick::structure::{Bond, BondKind, BondSource, StatedBonds, Structure};
use std::collections::{BTreeMap, BTreeSet};

/// Larger files are left out: each is written and read twice.
const MAX_BYTES: u64 = 3 << 20;

/// Covalent and coordination bonds by their atoms, those under residue names included.
fn pairs(structure: &Structure) -> BTreeMap<(u32, u32), (BondKind, u8, bool)> {
    let mut pairs = BTreeMap::new();
    let mut inferred = BTreeSet::new();
    for bond in structure.bonds().iter().filter(|bond| !bond.is_periodic()) {
        pairs.insert((bond.a, bond.b), (bond.kind, bond.order.number(), bond.aromatic));
        if bond.source == BondSource::Distance && bond.kind == BondKind::Covalent {
            inferred.insert((bond.a, bond.b));
        }
    }
    let residues = structure.residues();
    for (index, residue) in residues.iter().enumerate() {
        let until = residues.get(index + 1).map_or(structure.atom_count() as u32, |next| next.first_atom);
        let component = structure.components().iter().find(|component| component.name == structure.name(residue.name));
        for bond in component.map_or(&[][..], |component| &component.bonds) {
            let named = |name: &str| {
                let atoms = residue.first_atom..until;
                atoms.filter(|&atom| structure.atom_name(atom as usize) == name).collect::<Vec<_>>()
            };
            for a in named(&bond.a) {
                for b in named(&bond.b) {
                    let [one, other] = [a, b].map(|atom| structure.altloc(atom as usize));
                    if one == other || one == b' ' || other == b' ' {
                        let value = (BondKind::Covalent, bond.order.number(), bond.aromatic);
                        // What the file says of the residue's name is known better than what a distance says.
                        let pair = (a.min(b), a.max(b));
                        if !pairs.contains_key(&pair) || inferred.contains(&pair) {
                            pairs.insert(pair, value);
                        }
                    }
                }
            }
        }
    }
    pairs
}

fn is_polymer_link(structure: &Structure, bond: &Bond) -> bool {
    let name = |atom: u32| structure.atom_name(atom as usize);
    let names = BTreeSet::from([name(bond.a), name(bond.b)]);
    matches!(bond.source, BondSource::Distance | BondSource::Dictionary)
        && structure.residue_index(bond.a as usize) != structure.residue_index(bond.b as usize)
        && (names == BTreeSet::from(["C", "N"]) || names == BTreeSet::from(["O3'", "P"]))
}

/// Element, isotope, charge, serial number, altloc, flags, occupancy, B, and what they are called, by atom.
fn atom(s: &Structure, i: usize) -> String {
    let residue = s.residue_index(i).map(|index| {
        let residue = s.residues()[index];
        (index, s.chains().nth(residue.chain as usize), residue.number, residue.insertion_code, s.name(residue.name))
    });
    let positions: Vec<_> = s.frames().iter().map(|frame| (frame.positions.written(i) + 0.0).to_array()).collect();
    let isotope = if s.isotope(i) < 4 { s.isotope(i) } else { 0 };
    format!(
        "{} {isotope} {} {} {} {} {} {positions:?} {:?}",
        s.elements()[i],
        s.formal_charge(i),
        s.altloc(i),
        s.flags(i) & 3,
        s.occupancy(i),
        s.b_factor(i),
        residue.map(|residue| (residue, s.atom_name(i))),
    )
}

fn differences(name: &str, want: &Structure, got: &Structure, wrong: &mut Vec<String>) {
    if want.atom_count() != got.atom_count() || want.frames().len() != got.frames().len() {
        wrong.push(format!("{name}: other numbers of atoms or frames"));
        return;
    }
    // Structures without residues get one, and their atoms names.
    let bare = want.residues().is_empty();
    let of = |s: &Structure, i: usize| {
        let text = atom(s, i);
        if bare { text.rsplit_once(']').map_or(text.clone(), |(head, _)| head.to_owned()) } else { text }
    };
    // What has no residue name comes back as it is; a residue without a chain, too.
    if let Some(i) = (0..want.atom_count()).find(|&i| of(want, i) != of(got, i)) {
        wrong.push(format!("{name}: atom {i}: {} became {}", of(want, i), of(got, i)));
    }
    let cell = |s: &Structure| s.cell().map(|c| [c.lengths(), c.angles_deg()].concat()).unwrap_or_default();
    if cell(want).len() != cell(got).len() || cell(want).iter().zip(cell(got)).any(|(a, b)| (a - b).abs() > 1e-7) {
        wrong.push(format!("{name}: cell {:?} became {:?}", cell(want), cell(got)));
    }
    if want.secondary() != got.secondary() {
        wrong.push(format!("{name}: helices and strands"));
    }
    if (mmcif::FORMAT.limits)(want).iter().any(|phrase| phrase.contains("bonds")) {
        return; // said to be lost
    }
    let (mut all, found) = (pairs(want), pairs(got));
    for bond in want.bonds().iter().filter(|bond| is_polymer_link(want, bond)) {
        if !found.contains_key(&(bond.a, bond.b)) {
            all.remove(&(bond.a, bond.b));
        }
    }
    let differ = all.keys().chain(found.keys()).find(|pair| {
        let simple = |value: Option<&(BondKind, u8, bool)>| {
            value.map(|&(kind, order, aromatic)| match kind {
                BondKind::Covalent => (kind, order, aromatic),
                BondKind::Dative => (BondKind::Covalent, 1, false),
                kind => (kind, 0, false),
            })
        };
        simple(all.get(pair)) != simple(found.get(pair))
    });
    if let Some(pair) = differ {
        wrong.push(format!("{name}: bond {pair:?}: {:?} became {:?}", all.get(pair), found.get(pair)));
    }
}

/// The kinds of all bonds but hydrogen bonds and those to images, with the orders of the covalent ones.
fn kinds(structure: &Structure) -> BTreeMap<(u32, u32), (BondKind, u8)> {
    let kind = |bond: &Bond| match bond.kind {
        BondKind::Covalent => (bond.kind, bond.order.number()),
        // Which of the two it is, no row says.
        BondKind::Dative => (BondKind::Coordination, 0),
        kind => (kind, 0),
    };
    let bonds = structure.bonds().iter().filter(|bond| !bond.is_periodic() && bond.kind != BondKind::Hydrogen);
    bonds.map(|bond| ((bond.a, bond.b), kind(bond))).collect()
}

#[test]
fn complexes_of_metals_keep_the_kinds_of_their_bonds() {
    let (mut compared, mut wrong) = (0, Vec::new());
    for path in files::molecules(MAX_BYTES) {
        let Ok(document) = read_path(&path, &ImportOptions::default()) else { continue };
        for (number, record) in document.records.iter().enumerate() {
            if (mmcif::FORMAT.limits)(record).iter().any(|phrase| phrase.contains("without any partner")) {
                continue; // said to be lost
            }
            let has_metal = record.elements().iter().any(|element| element.is_metal());
            if record.stated_bonds() != StatedBonds::Complete || !has_metal || record.atom_count() > 2000 {
                continue;
            }
            let mut bytes = Vec::new();
            mmcif::write(std::slice::from_ref(record), &mut bytes).expect("a vector takes everything");
            let back = read_bytes(&bytes, "a.cif", &ImportOptions::default()).unwrap();
            let back = bonds::assign(back.records[0].clone(), &BondOptions::default());
            let (want, got) = (kinds(record), kinds(&back));
            let differ = want.keys().chain(got.keys()).find(|pair| want.get(pair) != got.get(pair));
            compared += 1;
            if let Some(pair) = differ {
                let name = files::name(&path);
                wrong.push(format!("{name} {number}: bond {pair:?}: {:?} became {:?}", want.get(pair), got.get(pair)));
            }
        }
    }
    println!("compared {compared} complexes");
    if compared == 0 {
        println!("SKIP: no complex of `data/` lists its bonds");
    }
    assert!(compared > 0 || files::corpus("good").is_none(), "nothing was compared");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_is_written_is_read_back() {
    let (mut compared, mut wrong) = (0, Vec::new());
    for path in files::molecules(MAX_BYTES) {
        let Ok(document) = read_path(&path, &ImportOptions::default()) else { continue };
        if document.records.iter().map(Structure::atom_count).sum::<usize>() > 60_000 {
            continue;
        }
        for mode in [BondMode::Auto, BondMode::File] {
            let name = format!("{} ({})", files::name(&path), mode.name());
            let options = BondOptions { mode, ..BondOptions::default() };
            let records: Vec<Structure> =
                document.records.iter().take(8).map(|record| bonds::assign(record.clone(), &options)).collect();
            let mut bytes = Vec::new();
            mmcif::write(&records, &mut bytes).expect("a vector takes everything");
            let back = read_bytes(&bytes, "a.cif", &ImportOptions::default()).expect(&name);
            if back.records.len() != records.len() {
                wrong.push(format!("{name}: {} records became {}", records.len(), back.records.len()));
                continue;
            }
            for (want, got) in records.iter().zip(&back.records) {
                differences(&name, want, got, &mut wrong);
                compared += 1;
            }
        }
    }
    println!("compared {compared} records");
    assert!(compared > 10, "too little was compared");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
