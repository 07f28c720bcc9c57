//! Named molecules and their bonds.

use super::*;
use crate::element::Element;
use crate::structure::{AtomRecord, BondSource, Diagnostics, StructureBuilder, atom_flags};
use glam::DVec3;

type Site = (&'static str, [f64; 3]);

fn structure(sites: &[Site]) -> Structure {
    let mut builder = StructureBuilder::new();
    for &(symbol, position) in sites {
        push(&mut builder, symbol, position, AtomRecord::default());
    }
    builder.build(&mut Diagnostics::default())
}

fn push(builder: &mut StructureBuilder, symbol: &str, position: [f64; 3], record: AtomRecord<'_>) {
    let element = Element::from_symbol(symbol).unwrap_or(Element::DUMMY);
    builder.push_atom(&AtomRecord { element, position: DVec3::from(position), ..record });
}

fn pairs(structure: &Structure) -> Vec<(u32, u32)> {
    find(structure, 0, &BondOptions::default()).iter().map(|bond| (bond.a, bond.b)).collect()
}

fn pairs_of(sites: &[Site]) -> Vec<(u32, u32)> {
    pairs(&structure(sites))
}

fn kinds_of(sites: &[Site]) -> Vec<BondKind> {
    find(&structure(sites), 0, &BondOptions::default()).iter().map(|bond| bond.kind).collect()
}

/// `count` points on a circle about the z axis.
fn ring(symbol: &'static str, count: usize, radius: f64, z: f64) -> Vec<Site> {
    let angle = |i: usize| i as f64 * std::f64::consts::TAU / count as f64;
    (0..count).map(|i| (symbol, [radius * angle(i).cos(), radius * angle(i).sin(), z])).collect()
}

/// A number of points `step` apart in all directions, the two symbols in turn.
fn lattice(symbols: [&'static str; 2], edge: usize, step: f64) -> Vec<Site> {
    let index = |i: usize| [i % edge, i / edge % edge, i / edge / edge];
    let site = |[x, y, z]: [usize; 3]| (symbols[(x + y + z) % 2], [x, y, z].map(|along| along as f64 * step));
    (0..edge * edge * edge).map(|i| site(index(i))).collect()
}

const WATER: [Site; 3] = [("O", [0.0, 0.0, 0.0]), ("H", [0.757, 0.586, 0.0]), ("H", [-0.757, 0.586, 0.0])];

#[test]
fn water_has_two_bonds_and_a_hydrogen_bond_is_none() {
    assert_eq!(pairs_of(&WATER), [(0, 1), (0, 2)]);
    // The donor's hydrogen is 1.45 Å from the other oxygen, within reach: it has its own oxygen.
    let mut dimer = WATER.to_vec();
    dimer.extend([("O", [1.9, 1.47, 0.0]), ("H", [2.5, 1.2, 0.7]), ("H", [2.5, 1.2, -0.7])]);
    assert_eq!(pairs_of(&dimer), [(0, 1), (0, 2), (3, 4), (3, 5)]);
}

#[test]
fn benzene_has_twelve_bonds() {
    let mut benzene = ring("C", 6, 1.39, 0.0);
    benzene.extend(ring("H", 6, 2.48, 0.0));
    let mut expected: Vec<(u32, u32)> = (0..6).map(|i| (i.min((i + 1) % 6), i.max((i + 1) % 6))).collect();
    expected.extend((0..6).map(|i| (i, i + 6)));
    expected.sort_unstable();
    assert_eq!(pairs_of(&benzene), expected);
}

#[test]
fn hydrogens_bond_to_each_other_only_as_h2() {
    assert_eq!(pairs_of(&[("H", [0.0; 3]), ("H", [0.741, 0.0, 0.0])]), [(0, 1)]);
    assert!(pairs_of(&[("H", [0.0; 3]), ("H", [0.95, 0.0, 0.0])]).is_empty());
    let row: Vec<Site> = (0..4).map(|i| ("H", [f64::from(i) * 0.85 + f64::from(i / 2) * 0.02, 0.0, 0.0])).collect();
    assert_eq!(pairs_of(&row), [(0, 1), (2, 3)]);
}

#[test]
fn methane_with_a_hydrogen_contact_keeps_four_bonds() {
    let r = 0.629;
    let mut methane: Vec<Site> = vec![("C", [0.0; 3])];
    methane.extend([[r, r, r], [r, -r, -r], [-r, r, -r], [-r, -r, r]].map(|at| ("H", at)));
    methane.push(("H", [r + 0.5, r + 0.5, r])); // 0.71 Å from a hydrogen that has its carbon
    assert_eq!(pairs_of(&methane), [(0, 1), (0, 2), (0, 3), (0, 4)]);
}

#[test]
fn diborane_has_eight_bonds() {
    let mut diborane: Vec<Site> = vec![("B", [-0.885, 0.0, 0.0]), ("B", [0.885, 0.0, 0.0])];
    diborane.extend([("H", [0.0, 0.993, 0.0]), ("H", [0.0, -0.993, 0.0])]);
    for x in [-1.46, 1.46] {
        diborane.extend([("H", [x, 0.0, 1.04]), ("H", [x, 0.0, -1.04])]);
    }
    assert_eq!(pairs_of(&diborane), [(0, 2), (0, 3), (0, 4), (0, 5), (1, 2), (1, 3), (1, 6), (1, 7)]);
}

#[test]
fn an_icosahedral_carborane_keeps_its_cage() {
    // Twelve vertices of edge 1.77 Å, each with a hydrogen 1.1 Å further out: 30 edges and 12 hydrogens.
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut cage: Vec<Site> = Vec::new();
    for (i, (a, b)) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)].into_iter().enumerate() {
        for (axis, at) in [[0.0, a, b], [a, b, 0.0], [b, 0.0, a]].into_iter().enumerate() {
            let symbol = if i == 0 && axis < 2 { "C" } else { "B" };
            cage.push((symbol, at.map(|along| along * 0.885)));
        }
    }
    let hydrogens: Vec<Site> = cage.iter().map(|(_, at)| ("H", at.map(|along| along * (1.0 + 1.1 / 1.683)))).collect();
    cage.extend(hydrogens);
    assert_eq!(pairs_of(&cage).len(), 42);
}

#[test]
fn a_disulfide_is_a_bond() {
    let sites = [("C", [0.0, 1.8, 0.0]), ("S", [0.0; 3]), ("S", [2.05, 0.0, 0.0]), ("C", [2.05, 0.0, 1.8])];
    assert_eq!(pairs_of(&sites), [(0, 1), (1, 2), (2, 3)]);
}

#[test]
fn hypervalent_atoms_keep_all_their_bonds() {
    let octahedron = |centre, symbol, length: f64| -> Vec<Site> {
        let mut sites = vec![(centre, [0.0; 3])];
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut at = [0.0; 3];
                at[axis] = sign * length;
                sites.push((symbol, at));
            }
        }
        sites
    };
    for (centre, length) in [("S", 1.56), ("P", 1.60), ("Si", 1.69)] {
        assert_eq!(pairs_of(&octahedron(centre, "F", length)).len(), 6, "{centre}");
    }
    let r = 0.83;
    let mut perchlorate: Vec<Site> = vec![("Cl", [0.0; 3])];
    perchlorate.extend([[r, r, r], [r, -r, -r], [-r, r, -r], [-r, -r, r]].map(|at| ("O", at)));
    assert_eq!(pairs_of(&perchlorate).len(), 4);
}

#[test]
fn noble_gases_bond_only_where_compounds_are_known() {
    assert!(pairs_of(&[("Ar", [0.0; 3]), ("Ar", [1.5, 0.0, 0.0]), ("C", [0.0, 1.5, 0.0])]).is_empty());
    assert_eq!(pairs_of(&[("F", [-1.98, 0.0, 0.0]), ("Xe", [0.0; 3]), ("F", [1.98, 0.0, 0.0])]), [(0, 1), (1, 2)]);
    assert_eq!(pairs_of(&[("Kr", [0.0; 3]), ("F", [1.88, 0.0, 0.0])]), [(0, 1)]);
}

#[test]
fn what_carbon_cannot_hold_goes_longest_first() {
    // Bicyclo[1.1.1]pentane: the bridgeheads are 1.87 Å apart, within reach, and not bonded.
    let mut cage: Vec<Site> = vec![("C", [0.0, 0.0, 0.935]), ("C", [0.0, 0.0, -0.935])];
    cage.extend(ring("C", 3, 1.24, 0.0));
    cage.extend([("H", [0.0, 0.0, 2.03]), ("H", [0.0, 0.0, -2.03])]);
    assert_eq!(pairs_of(&cage), [(0, 2), (0, 3), (0, 4), (0, 5), (1, 2), (1, 3), (1, 4), (1, 6)]);
    // A fifth carbon at 1.9 Å.
    let r = 0.89;
    let mut neopentane: Vec<Site> = vec![("C", [0.0; 3])];
    neopentane.extend([[r, r, r], [r, -r, -r], [-r, r, -r], [-r, -r, r]].map(|at| ("C", at)));
    neopentane.push(("C", [1.9, 0.0, 0.0]));
    let at_centre = pairs_of(&neopentane).iter().filter(|pair| pair.0 == 0).count();
    assert_eq!(at_centre, 4);
    assert!(!pairs_of(&neopentane).contains(&(0, 5)));
}

#[test]
fn the_diagonal_of_a_sulfur_nitride_ring_is_no_bond() {
    let half = 1.65 * std::f64::consts::FRAC_1_SQRT_2;
    let ring = [("S", [half, 0.0, 0.0]), ("N", [0.0, half, 0.0]), ("S", [-half, 0.0, 0.0]), ("N", [0.0, -half, 0.0])];
    assert_eq!(pairs_of(&ring), [(0, 1), (0, 3), (1, 2), (2, 3)]);
}

#[test]
fn small_rings_and_white_phosphorus_are_whole() {
    assert_eq!(pairs_of(&ring("C", 3, 0.87, 0.0)).len(), 3);
    assert_eq!(pairs_of(&ring("C", 4, 1.09, 0.0)).len(), 4);
    let r = 0.78;
    assert_eq!(pairs_of(&[[r, r, r], [r, -r, -r], [-r, r, -r], [-r, -r, r]].map(|at| ("P", at))).len(), 6);
    // Thiirene by its lengths C=C 1.27 and C–S 1.83 Å.
    let sulfur = (1.83f64 * 1.83 - 0.635 * 0.635).sqrt();
    let thiirene = [("C", [-0.635, 0.0, 0.0]), ("C", [0.635, 0.0, 0.0]), ("S", [0.0, sulfur, 0.0])];
    assert_eq!(pairs_of(&thiirene).len(), 3);
}

#[test]
fn ferrocene_coordinates_ten_carbons() {
    let mut ferrocene: Vec<Site> = vec![("Fe", [0.0; 3])];
    for z in [-1.66, 1.66] {
        ferrocene.extend(ring("C", 5, 1.22, z));
        ferrocene.extend(ring("H", 5, 2.3, z));
    }
    let bonds = find(&structure(&ferrocene), 0, &BondOptions::default());
    let coordination = bonds.iter().filter(|bond| bond.kind == BondKind::Coordination);
    assert_eq!((bonds.len(), coordination.clone().count()), (30, 10));
    assert!(coordination.clone().all(|bond| bond.a == 0 && bond.order == BondOrder::Unknown));
}

#[test]
fn metals_bond_to_donors_not_to_what_is_behind_them() {
    // A chelating acetate on calcium: Ca–O 2.45 Å, the carbon at 2.8 Å is in range but no donor.
    let chelate = [
        ("Ca", [0.0; 3]),
        ("O", [1.1, 2.19, 0.0]),
        ("O", [-1.1, 2.19, 0.0]),
        ("C", [0.0, 2.8, 0.0]),
        ("C", [0.0, 4.3, 0.0]),
    ];
    assert_eq!(pairs_of(&chelate), [(0, 1), (0, 2), (1, 3), (2, 3), (3, 4)]);
    // Dioxygen end-on: the second oxygen is 2.6 Å away.
    let oxy = [("Fe", [0.0; 3]), ("O", [1.8, 0.0, 0.0]), ("O", [2.4, 1.05, 0.0])];
    assert_eq!(pairs_of(&oxy), [(0, 1), (1, 2)]);
    // Side-on peroxide keeps both, and a saturated carbon gives nothing.
    assert_eq!(pairs_of(&[("Ti", [0.0; 3]), ("O", [1.7, 0.73, 0.0]), ("O", [1.7, -0.73, 0.0])]).len(), 3);
    let mut contact: Vec<Site> = vec![("Na", [0.0, 0.0, -2.8]), ("C", [0.0; 3])];
    contact.extend([[0.6, 0.6, 0.6], [0.6, -0.6, -0.6], [-0.6, 0.6, -0.6], [-0.6, -0.6, 0.6]].map(|at| ("H", at)));
    assert!(pairs_of(&contact).iter().all(|pair| pair.0 != 0));
}

#[test]
fn two_coordinate_mercury_and_oxides_of_high_valence_are_covalent() {
    let hgcl2 = [("Cl", [-2.28, 0.0, 0.0]), ("Hg", [0.0; 3]), ("Cl", [2.28, 0.0, 0.0])];
    assert_eq!(pairs_of(&hgcl2), [(0, 1), (1, 2)]);
    assert_eq!(kinds_of(&hgcl2), [BondKind::Covalent; 2]);
    let r = 0.93;
    let mut permanganate: Vec<Site> = vec![("Mn", [0.0; 3])];
    permanganate.extend([[r, r, r], [r, -r, -r], [-r, r, -r], [-r, -r, r]].map(|at| ("O", at)));
    assert_eq!(kinds_of(&permanganate), [BondKind::Covalent; 4]);
    assert_eq!(kinds_of(&[("Sn", [0.0; 3]), ("C", [2.14, 0.0, 0.0])]), [BondKind::Covalent]);
}

#[test]
fn salts_and_metals_are_lattices() {
    assert_eq!(pairs_of(&[("Na", [0.0; 3]), ("Cl", [2.36, 0.0, 0.0])]), [(0, 1)]);
    let edges = 3 * 4 * 4 * 3; // of a 4 × 4 × 4 block
    for (symbols, step) in [(["Na", "Cl"], 2.82), (["Mg", "O"], 2.106), (["Pb", "S"], 2.968), (["K", "Br"], 3.3)] {
        let salt = lattice(symbols, 4, step);
        assert_eq!(pairs_of(&salt).len(), edges, "{symbols:?}");
        assert!(symbols[0] == "Pb" || kinds_of(&salt).iter().all(|&kind| kind == BondKind::Coordination));
    }
    let gold = [[0.0; 3], [2.04, 2.04, 0.0], [2.04, 0.0, 2.04], [0.0, 2.04, 2.04]].map(|at| ("Au", at));
    assert_eq!(pairs_of(&gold).len(), 6);
    assert_eq!(kinds_of(&gold), [BondKind::Covalent; 6]);
}

#[test]
fn gold_is_bonded_under_a_thiolate_and_titanium_is_not_under_an_oxide() {
    let bent = |metal, bridge, apart: f64, height| {
        pairs_of(&[(metal, [0.0; 3]), (metal, [apart, 0.0, 0.0]), (bridge, [apart / 2.0, height, 0.0])])
    };
    assert_eq!(bent("Au", "S", 3.1, 1.8), [(0, 1), (0, 2), (1, 2)]);
    assert_eq!(bent("Ti", "O", 3.57, 0.82), [(0, 2), (1, 2)]);
}

#[test]
fn an_iron_sulfur_cubane_has_no_iron_iron_sticks() {
    let (fe, s) = (0.96, 1.26);
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let mut cluster: Vec<Site> = corners.iter().map(|at| ("Fe", at.map(|along| along * fe))).collect();
    cluster.extend(corners.iter().map(|at| ("S", at.map(|along| -along * s))));
    let got = pairs_of(&cluster);
    assert_eq!(got.len(), 12);
    assert!(got.iter().all(|&(a, b)| a < 4 && b >= 4));
}

/// Atoms with residues: symbol, position, residue name, residue number, altloc.
fn residues(atoms: &[(&str, [f64; 3], &str, i32, u8)]) -> Structure {
    let mut builder = StructureBuilder::new();
    for &(symbol, position, name, number, altloc) in atoms {
        let record = AtomRecord { residue: Some(("A", number, b' ', name)), altloc, ..AtomRecord::default() };
        push(&mut builder, symbol, position, record);
    }
    builder.build(&mut Diagnostics::default())
}

#[test]
fn waters_stay_waters_and_ions_float() {
    let mut atoms = vec![("Na", [0.0; 3], "NA", 1, b' ')];
    for (i, at) in [[2.3, 0.0, 0.0], [-2.3, 0.0, 0.0], [0.0, 2.3, 0.0], [0.0, -2.3, 0.0]].into_iter().enumerate() {
        atoms.push(("O", at, "HOH", i as i32 + 2, b' '));
    }
    atoms.push(("C", [2.3, 1.3, 0.0], "LIG", 9, b' ')); // 1.3 Å from a water
    assert!(pairs(&residues(&atoms)).is_empty());
    // A zinc with two histidines floats, with three it bonds.
    let mut zinc = vec![("Zn", [0.0; 3], "ZN", 1, b' ')];
    zinc.extend([("N", [2.1, 0.0, 0.0], "HIS", 2, b' '), ("N", [-2.1, 0.0, 0.0], "HIS", 3, b' ')]);
    assert!(pairs(&residues(&zinc)).is_empty());
    zinc.push(("S", [0.0, 2.3, 0.0], "CYS", 4, b' '));
    let bonds = find(&residues(&zinc), 0, &BondOptions::default());
    assert_eq!(bonds.len(), 3);
    assert!(bonds.iter().all(|bond| bond.kind == BondKind::Coordination));
}

#[test]
fn a_salt_whose_atoms_are_residues_is_a_lattice() {
    let atoms: Vec<_> = lattice(["Na", "Cl"], 2, 2.82)
        .into_iter()
        .enumerate()
        .map(|(i, (symbol, at))| (symbol, at, symbol, i as i32, b' '))
        .collect();
    assert_eq!(pairs(&residues(&atoms)).len(), 12);
}

#[test]
fn alternate_locations_never_bond_to_each_other() {
    let atoms = [
        ("C", [0.0; 3], "ALA", 1, b' '),
        ("C", [1.5, 0.0, 0.0], "ALA", 1, b'A'),
        ("C", [0.5, 1.4, 0.0], "ALA", 1, b'B'),
        ("O", [2.0, 1.2, 0.0], "ALA", 1, b'A'),
        ("O", [1.7, 1.5, 0.0], "ALA", 1, b'B'),
    ];
    assert_eq!(pairs(&residues(&atoms)), [(0, 1), (0, 2), (1, 3), (2, 4)]);
}

#[test]
fn an_atom_bonds_to_every_alternate_location_of_its_partner() {
    // A peptide nitrogen after a residue of two conformers, whose carbons are 0.2 Å apart; both CA, and a carbon with
    // five partners of which four are there at once.
    let atoms = [
        ("N", [0.0; 3], "LEU", 2, b' '),
        ("C", [1.33, 0.1, 0.0], "GLU", 1, b'A'),
        ("C", [1.33, -0.1, 0.0], "GLU", 1, b'B'),
        ("C", [-0.7, 1.2, 0.0], "LEU", 2, b' '),
        ("C", [-0.7, 2.0, 1.2], "LEU", 2, b' '),
        ("O", [-1.9, 1.6, -0.6], "LEU", 2, b' '),
        ("C", [0.5, 2.0, -0.9], "LEU", 2, b'A'),
        ("C", [0.6, 2.1, -0.8], "LEU", 2, b'B'),
    ];
    assert_eq!(pairs(&residues(&atoms)), [(0, 1), (0, 2), (0, 3), (3, 4), (3, 5), (3, 6), (3, 7)]);
}

#[test]
fn particles_and_dummies_are_never_bonded() {
    let mut builder = StructureBuilder::new();
    push(&mut builder, "C", [0.0; 3], AtomRecord::default());
    push(&mut builder, "C", [1.5, 0.0, 0.0], AtomRecord { flags: atom_flags::PARTICLE, ..AtomRecord::default() });
    push(&mut builder, "?", [0.0, 1.5, 0.0], AtomRecord::default());
    assert!(pairs(&builder.build(&mut Diagnostics::default())).is_empty());
}

#[test]
fn atoms_at_one_place_are_not_bonded_and_cost_little() {
    assert!(pairs_of(&[("C", [0.0; 3]), ("C", [0.0; 3]), ("C", [0.1, 0.0, 0.0])]).is_empty());
    let mut pile = vec![("C", [1.0, 2.0, 3.0]); 100_000];
    pile.extend([("C", [50.0, 0.0, 0.0]), ("O", [51.2, 0.0, 0.0])]);
    assert_eq!(pairs_of(&pile), [(100_000, 100_001)]);
    // A cloud fifty times as dense as any matter.
    let mut seed = 7u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f64 / f64::from(1 << 24) * 20.0
    };
    let cloud: Vec<Site> = (0..40_000).map(|_| ("C", [noise(), noise(), noise()])).collect();
    assert!(pairs_of(&cloud).len() < 40_000);
}

#[test]
fn far_apart_molecules_both_have_their_bonds() {
    let far = [("C", [0.0; 3]), ("O", [1.2, 0.0, 0.0]), ("C", [1e6, 0.0, 0.0]), ("O", [1e6, 1.25, 0.0])];
    assert_eq!(pairs_of(&far), [(0, 1), (2, 3)]);
}

#[test]
fn no_atoms_and_no_such_frame_are_no_bonds() {
    assert!(pairs_of(&[]).is_empty());
    assert!(find(&structure(&WATER), 1, &BondOptions::default()).is_empty());
}

#[test]
fn strange_tolerances_are_taken_as_sane_ones() {
    for tolerance in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let options = BondOptions { tolerance, metal_tolerance: tolerance, ..BondOptions::default() };
        let bonds = find(&structure(&WATER), 0, &options).len();
        assert_eq!(bonds, if tolerance == f32::NEG_INFINITY { 0 } else { 2 });
    }
}

fn with_stated(sites: &[Site], stated: StatedBonds, bonds: &[(u32, u32, BondOrder)]) -> Structure {
    let mut builder = StructureBuilder::new();
    for &(symbol, position) in sites {
        push(&mut builder, symbol, position, AtomRecord::default());
    }
    for &(a, b, order) in bonds {
        builder.push_bond(Bond::new(a, b, order, BondSource::File));
    }
    builder.set_stated_bonds(stated);
    builder.build(&mut Diagnostics::default())
}

#[test]
fn modes_say_whose_word_counts() {
    // Too long for double bonds: distances give single ones.
    let chain: Vec<Site> = (0..4).map(|i| ("C", [f64::from(i) * 1.6, 0.0, 0.0])).collect();
    let stated = [(0, 1, BondOrder::Double), (0, 3, BondOrder::Single)];
    let found = |kind: StatedBonds, mode: BondMode| -> Vec<(u32, u32, u8, BondSource)> {
        let structure = with_stated(&chain, kind, &stated);
        let bonds = find(&structure, 0, &BondOptions { mode, ..BondOptions::default() });
        bonds.iter().map(|bond| (bond.a, bond.b, bond.order.number(), bond.source)).collect()
    };
    let (file, distance) = (BondSource::File, BondSource::Distance);
    let of_file = [(0, 1, 2, file), (0, 3, 1, file)];
    assert_eq!(found(StatedBonds::Complete, BondMode::Auto), of_file);
    assert_eq!(found(StatedBonds::Partial, BondMode::File), of_file);
    let all = [of_file[0], of_file[1], (1, 2, 1, distance), (2, 3, 1, distance)];
    assert_eq!(found(StatedBonds::Partial, BondMode::Auto), all);
    let perceived = [(0, 1, 1, distance), (1, 2, 1, distance), (2, 3, 1, distance)];
    assert_eq!(found(StatedBonds::Complete, BondMode::Perceive), perceived);
    assert!(found(StatedBonds::Complete, BondMode::None).is_empty());
    assert!(BondMode::ALL.iter().all(|&mode| BondMode::from_name(mode.name()) == Some(mode)));
    assert_eq!(BondMode::from_name("some"), None);
}

#[test]
fn a_stated_bond_uses_up_the_hydrogen_and_is_named_coordination_at_a_metal() {
    // The file bonds the hydrogen to the farther oxygen.
    let sites = [("O", [0.0; 3]), ("H", [1.0, 0.0, 0.0]), ("O", [2.3, 0.0, 0.0])];
    let structure = with_stated(&sites, StatedBonds::Partial, &[(1, 2, BondOrder::Single)]);
    assert_eq!(pairs(&structure), [(1, 2)]);
    let sites = [("Fe", [0.0; 3]), ("N", [3.5, 0.0, 0.0])];
    let bonds = with_stated(&sites, StatedBonds::Partial, &[(0, 1, BondOrder::Single)]);
    let bonds = find(&bonds, 0, &BondOptions::default());
    assert_eq!((bonds.len(), bonds[0].kind, bonds[0].order), (1, BondKind::Coordination, BondOrder::Single));
}

#[test]
fn the_order_of_the_atoms_and_a_turn_change_nothing() {
    let mut sites = ring("C", 6, 1.39, 0.0);
    sites.extend(ring("H", 6, 2.48, 0.0));
    sites.extend(lattice(["Na", "Cl"], 3, 2.82).into_iter().map(|(symbol, [x, y, z])| (symbol, [x + 9.0, y, z])));
    let count = sites.len();
    let expected = pairs_of(&sites);
    let order: Vec<usize> = (0..count).map(|i| i * 7 % count).collect();
    assert!(!count.is_multiple_of(7));
    let (sin, cos) = 0.7f64.sin_cos();
    let turned = |[x, y, z]: [f64; 3]| [x * cos - y * sin + 3.0, z - 40.0, -(x * sin + y * cos)];
    let shuffled: Vec<Site> = order.iter().map(|&i| (sites[i].0, turned(sites[i].1))).collect();
    let mut got: Vec<(u32, u32)> = pairs_of(&shuffled)
        .into_iter()
        .map(|(a, b)| (order[a as usize] as u32, order[b as usize] as u32))
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    got.sort_unstable();
    assert_eq!(got, expected);
}

#[test]
fn assign_gives_the_structure_its_bonds() {
    assert_eq!(assign(structure(&WATER), &BondOptions::default()).bonds().len(), 2);
}

#[test]
fn a_hydrogen_bond_that_the_file_states_is_there_once() {
    // Two waters, one giving its hydrogen to the other.
    let water =
        [("O", 0.0, 0.0), ("H", 0.96, 0.0), ("H", -0.24, 0.93), ("O", 2.9, 0.0), ("H", 3.2, 0.9), ("H", 3.2, -0.9)];
    let mut builder = StructureBuilder::new();
    for (symbol, x, y) in water {
        let element = Element::from_symbol(symbol).unwrap();
        builder.push_atom(&AtomRecord { element, position: DVec3::new(x, y, 0.0), ..AtomRecord::default() });
    }
    let stated = Bond { kind: BondKind::Hydrogen, ..Bond::new(1, 3, BondOrder::Unknown, BondSource::Link) };
    builder.push_bond(stated);
    builder.set_stated_bonds(StatedBonds::Partial);
    let structure = builder.build(&mut Diagnostics::default());
    let options = BondOptions { hydrogen_bonds: true, ..BondOptions::default() };
    let found = find(&structure, 0, &options);
    let hydrogen: Vec<&Bond> = found.iter().filter(|bond| bond.kind == BondKind::Hydrogen).collect();
    assert_eq!(hydrogen, [&stated]);
    assert_eq!(found.len(), 5);
}
