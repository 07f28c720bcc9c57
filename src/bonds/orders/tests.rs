//! Functional groups with and without hydrogens, from geometry alone.

use super::component::Component;
use super::solve::{Problem, Solver};
use super::*;
use crate::bonds::{BondMode, BondOptions, assign, find};
use crate::structure::{AtomRecord, Diagnostics, StatedBonds, StructureBuilder};
use glam::{DMat3, DVec3};

type Site = (&'static str, [f64; 3]);

fn structure(sites: &[Site]) -> Structure {
    let mut builder = StructureBuilder::new();
    for &(symbol, position) in sites {
        let element = Element::from_symbol(symbol).unwrap_or(Element::DUMMY);
        builder.push_atom(&AtomRecord { element, position: DVec3::from(position), ..AtomRecord::default() });
    }
    builder.build(&mut Diagnostics::default())
}

fn without_hydrogens(sites: &[Site]) -> Vec<Site> {
    sites.iter().copied().filter(|site| site.0 != "H").collect()
}

/// Bonds that are more than single or aromatic, as `C=O`, `N#N`, `C~C`, sorted.
fn multiple(structure: &Structure) -> Vec<String> {
    let name = |bond: &Bond| {
        let symbol = |atom: u32| structure.elements()[atom as usize].symbol();
        let (low, high) = (symbol(bond.a).min(symbol(bond.b)), symbol(bond.a).max(symbol(bond.b)));
        let sign = if bond.aromatic { "~" } else { ["?", "-", "=", "#", "$"][usize::from(bond.order.number())] };
        (sign != "-" && bond.kind == BondKind::Covalent).then(|| format!("{low}{sign}{high}"))
    };
    let mut names: Vec<String> = find(structure, 0, &BondOptions::default()).iter().filter_map(name).collect();
    names.sort();
    names
}

fn charges_of(sites: &[Site]) -> Vec<String> {
    let structure = assign(structure(sites), &BondOptions::default());
    let charge = |atom: usize| match structure.formal_charge(atom) {
        0 => None,
        charge => Some(format!("{}{charge:+}", structure.elements()[atom].symbol())),
    };
    let mut charges: Vec<String> = (0..structure.atom_count()).filter_map(charge).collect();
    charges.sort();
    charges
}

/// The same with and without hydrogens.
fn assert_multiple(sites: &[Site], expected: &[&str]) {
    assert_eq!(multiple(&structure(sites)), expected, "with hydrogens");
    assert_eq!(multiple(&structure(&without_hydrogens(sites))), expected, "without hydrogens");
}

/// A neighbour in the xy plane: `length` from a point, `angle` in degrees from the x axis.
fn beside(from: [f64; 3], length: f64, angle_deg: f64) -> [f64; 3] {
    let angle = angle_deg.to_radians();
    [from[0] + length * angle.cos(), from[1] + length * angle.sin(), from[2]]
}

/// A regular flat ring about the origin with atoms at `radius`, the first on the x axis.
fn ring(symbols: &[&'static str], radius: f64) -> Vec<Site> {
    let step = 360.0 / symbols.len() as f64;
    symbols.iter().enumerate().map(|(i, &symbol)| (symbol, beside([0.0; 3], radius, step * i as f64))).collect()
}

fn benzene() -> Vec<Site> {
    let mut sites = ring(&["C"; 6], 1.39);
    sites.extend(ring(&["H"; 6], 2.48));
    sites
}

/// A methyl group's three hydrogens on a carbon whose other bond points along `axis`.
fn methyl(carbon: [f64; 3], axis: DVec3) -> Vec<Site> {
    let axis = axis.normalize();
    let side = axis.any_orthonormal_vector();
    let third = axis.cross(side);
    (0..3)
        .map(|i| {
            let turn = f64::from(i) * 120f64.to_radians();
            let direction = -axis / 3.0 + (side * turn.cos() + third * turn.sin()) * (8f64.sqrt() / 3.0);
            ("H", (DVec3::from(carbon) + direction * 1.09).to_array())
        })
        .collect()
}

/// CH₃–X with X at the origin's place and the methyl at −x: carbon and hydrogens.
fn methyl_at_left(length: f64) -> Vec<Site> {
    let carbon = [-length, 0.0, 0.0];
    let mut sites = vec![("C", carbon)];
    sites.extend(methyl(carbon, DVec3::X));
    sites
}

#[test]
fn ethane_ethene_and_ethyne_differ() {
    let mut ethane = methyl_at_left(1.53);
    ethane.push(("C", [0.0; 3]));
    ethane.extend(methyl([0.0; 3], -DVec3::X));
    assert_multiple(&ethane, &[]);
    let mut ethene: Vec<Site> = vec![("C", [0.0; 3]), ("C", [1.33, 0.0, 0.0])];
    ethene.extend([121.5, -121.5].map(|angle| ("H", beside([0.0; 3], 1.09, angle))));
    ethene.extend([58.5, -58.5].map(|angle| ("H", beside([1.33, 0.0, 0.0], 1.09, angle))));
    assert_multiple(&ethene, &["C=C"]);
    let ethyne = [("C", [0.0; 3]), ("C", [1.2, 0.0, 0.0]), ("H", [-1.06, 0.0, 0.0]), ("H", [2.26, 0.0, 0.0])];
    assert_multiple(&ethyne, &["C#C"]);
}

#[test]
fn benzene_is_aromatic_in_a_kekule_form() {
    assert_multiple(&benzene(), &["C~C"; 6]);
    let bonds = find(&structure(&benzene()), 0, &BondOptions::default());
    assert_eq!(bonds.iter().filter(|bond| bond.order == BondOrder::Double).count(), 3);
}

#[test]
fn cyclohexane_is_not() {
    let chair: Vec<Site> = (0..6)
        .map(|i| {
            let [x, y, _] = beside([0.0; 3], 1.45, 60.0 * f64::from(i));
            ("C", [x, y, if i % 2 == 0 { 0.25 } else { -0.25 }])
        })
        .collect();
    assert_eq!(multiple(&structure(&chair)), [""; 0]);
}

#[test]
fn acetic_acid_and_acetate_have_one_carbonyl() {
    let mut acid = methyl_at_left(1.5);
    acid.extend([("C", [0.0; 3]), ("O", beside([0.0; 3], 1.21, 55.0)), ("O", beside([0.0; 3], 1.34, -57.0))]);
    let hydrogen = beside(beside([0.0; 3], 1.34, -57.0), 0.97, 17.0);
    acid.push(("H", hydrogen));
    assert_multiple(&acid, &["C=O"]);
    assert_eq!(charges_of(&acid), [""; 0]);
    let mut acetate = methyl_at_left(1.52);
    acetate.extend([("C", [0.0; 3]), ("O", beside([0.0; 3], 1.25, 62.0)), ("O", beside([0.0; 3], 1.25, -62.0))]);
    assert_multiple(&acetate, &["C=O"]);
    assert_eq!(charges_of(&acetate), ["O-1"]);
    assert_eq!(charges_of(&without_hydrogens(&acetate)), [""; 0]);
}

#[test]
fn amide_nitrile_and_ammonium() {
    let mut amide = methyl_at_left(1.51);
    let nitrogen = beside([0.0; 3], 1.34, -64.0);
    amide.extend([("C", [0.0; 3]), ("O", beside([0.0; 3], 1.23, 58.0)), ("N", nitrogen)]);
    amide.extend([("H", beside(nitrogen, 1.01, -4.0)), ("H", beside(nitrogen, 1.01, -124.0))]);
    assert_multiple(&amide, &["C=O"]);
    let mut nitrile = methyl_at_left(1.46);
    nitrile.extend([("C", [0.0; 3]), ("N", [1.16, 0.0, 0.0])]);
    assert_multiple(&nitrile, &["C#N"]);
    let mut ammonium = methyl_at_left(1.49);
    ammonium.push(("N", [0.0; 3]));
    ammonium.extend(methyl([0.0; 3], -DVec3::X));
    assert_multiple(&ammonium, &[]);
    assert_eq!(charges_of(&ammonium), ["N+1"]);
}

#[test]
fn nitro_is_charge_separated_with_and_without_hydrogens() {
    let mut nitro = methyl_at_left(1.49);
    nitro.extend([("N", [0.0; 3]), ("O", beside([0.0; 3], 1.22, 58.0)), ("O", beside([0.0; 3], 1.22, -58.0))]);
    assert_multiple(&nitro, &["N=O"]);
    assert_eq!(charges_of(&nitro), ["N+1", "O-1"]);
    assert_eq!(charges_of(&without_hydrogens(&nitro)), ["N+1", "O-1"]);
}

#[test]
fn azide_and_isocyanide() {
    let mut azide = methyl_at_left(1.47);
    let middle = beside([0.0; 3], 1.24, 62.0);
    azide.extend([("N", [0.0; 3]), ("N", middle), ("N", beside(middle, 1.13, 68.0))]);
    assert_multiple(&azide, &["N=N", "N=N"]);
    assert_eq!(charges_of(&azide), ["N+1", "N-1"]);
    let mut isocyanide = methyl_at_left(1.42);
    isocyanide.extend([("N", [0.0; 3]), ("C", [1.17, 0.0, 0.0])]);
    assert_eq!(multiple(&structure(&isocyanide)), ["C#N"]);
    assert_eq!(charges_of(&isocyanide), ["C-1", "N+1"]);
}

#[test]
fn sulfone_sulfoxide_thioether_and_sulfonium() {
    let tetrahedral = |length: f64, corner: usize| {
        let corner = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]][corner];
        corner.map(|along| along * length / 3f64.sqrt())
    };
    let around_sulfur = |methyls: &[usize], oxygens: &[usize]| {
        let mut sites: Vec<Site> = vec![("S", [0.0; 3])];
        for &corner in methyls {
            let carbon = tetrahedral(1.79, corner);
            sites.push(("C", carbon));
            sites.extend(methyl(carbon, -DVec3::from(carbon)));
        }
        sites.extend(oxygens.iter().map(|&corner| ("O", tetrahedral(1.46, corner))));
        sites
    };
    assert_multiple(&around_sulfur(&[0, 1], &[2, 3]), &["O=S", "O=S"]);
    assert_multiple(&around_sulfur(&[0, 1], &[2]), &["O=S"]);
    assert_multiple(&around_sulfur(&[0, 1], &[]), &[]);
    let sulfonium = around_sulfur(&[0, 1, 2], &[]);
    assert_multiple(&sulfonium, &[]);
    assert_eq!(charges_of(&sulfonium), ["S+1"]);
}

#[test]
fn phosphate_has_one_double_bond() {
    let corners = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
    let mut sites: Vec<Site> = vec![("P", [0.0; 3])];
    for (corner, length) in corners.into_iter().zip([1.6, 1.51, 1.51, 1.51]) {
        sites.push(("O", corner.map(|along| along * length / 3f64.sqrt())));
    }
    let oxygen = DVec3::from(sites[1].1);
    let carbon = (oxygen + DVec3::new(1.3, -0.3, 0.5).normalize() * 1.43).to_array();
    sites.push(("C", carbon));
    sites.extend(methyl(carbon, oxygen - DVec3::from(carbon)));
    assert_multiple(&sites, &["O=P"]);
    assert_eq!(charges_of(&sites), ["O-1", "O-1"]);
}

#[test]
fn guanidinium_has_one_double_bond_and_one_charge() {
    let mut sites: Vec<Site> = vec![("C", [0.0; 3])];
    for angle in [0.0, 120.0, 240.0] {
        let nitrogen = beside([0.0; 3], 1.33, angle);
        sites.push(("N", nitrogen));
        sites.extend([60.0, -60.0].map(|turn| ("H", beside(nitrogen, 1.01, angle + turn))));
    }
    assert_eq!(multiple(&structure(&sites)), ["C=N"]);
    assert_eq!(charges_of(&sites), ["N+1"]);
}

#[test]
fn pyridine_pyrrole_furan_and_thiophene_are_aromatic() {
    let mut pyridine = ring(&["N", "C", "C", "C", "C", "C"], 1.38);
    pyridine.extend(ring(&["H"; 6], 2.46).into_iter().skip(1));
    assert_multiple(&pyridine, &["C~C", "C~C", "C~C", "C~C", "C~N", "C~N"]);
    // C–C 1.37 and 1.42 Å, the fifth atom on the x axis: bonds of 1.37, 1.36 and 1.71 Å.
    for (symbol, x, has_hydrogen) in [("N", 1.12, true), ("O", 1.08, false), ("S", 1.54, false)] {
        let half = if symbol == "S" { 1.235 } else { 1.105 };
        let (near, far) = if symbol == "S" { (0.36, -0.95) } else { (0.32, -1.0) };
        let mut sites: Vec<Site> = vec![
            (symbol, [x, 0.0, 0.0]),
            ("C", [near, half, 0.0]),
            ("C", [far, 0.71, 0.0]),
            ("C", [far, -0.71, 0.0]),
            ("C", [near, -half, 0.0]),
        ];
        sites.extend([("H", [0.75, 2.09, 0.0]), ("H", [-1.83, 1.4, 0.0])]);
        sites.extend([("H", [-1.83, -1.4, 0.0]), ("H", [0.75, -2.09, 0.0])]);
        if has_hydrogen {
            sites.push(("H", [2.13, 0.0, 0.0]));
        }
        let hetero = format!("C~{symbol}");
        let mut expected = vec!["C~C", "C~C", "C~C", &hetero, &hetero];
        expected.sort_unstable();
        assert_multiple(&sites, &expected);
    }
}

#[test]
fn carbon_dioxide_and_dinitrogen_need_no_hydrogens() {
    let dioxide = [("C", [0.0; 3]), ("O", [1.16, 0.0, 0.0]), ("O", [-1.16, 0.0, 0.0])];
    assert_eq!(multiple(&structure(&dioxide)), ["C=O", "C=O"]);
    assert_eq!(multiple(&structure(&[("N", [0.0; 3]), ("N", [1.098, 0.0, 0.0])])), ["N#N"]);
    assert_eq!(multiple(&structure(&[("O", [0.0; 3]), ("O", [1.207, 0.0, 0.0])])), ["O=O"]);
    let monoxide = [("C", [0.0; 3]), ("O", [1.128, 0.0, 0.0])];
    assert_eq!(multiple(&structure(&monoxide)), ["C#O"]);
    assert_eq!(charges_of(&monoxide), ["C-1", "O+1"]);
}

#[test]
fn cyclopentadienide_on_a_metal_is_aromatic() {
    let mut sites: Vec<Site> = vec![("Fe", [0.0; 3])];
    for height in [1.66, -1.66] {
        sites.extend(ring(&["C"; 5], 1.2165).into_iter().map(|(symbol, [x, y, _])| (symbol, [x, y, height])));
        sites.extend(ring(&["H"; 5], 2.29).into_iter().map(|(symbol, [x, y, _])| (symbol, [x, y, height])));
    }
    assert_eq!(multiple(&structure(&sites)), ["C~C"; 10]);
    assert_eq!(charges_of(&sites), ["C-1", "C-1"]);
    // At 1.43 Å, between single and double, there are still two double bonds a ring.
    let bonds = find(&structure(&sites), 0, &BondOptions::default());
    assert_eq!(bonds.iter().filter(|bond| bond.order == BondOrder::Double).count(), 4);
}

#[test]
fn order_and_place_of_atoms_do_not_matter() {
    let mut molecule = methyl_at_left(1.51);
    let nitrogen = beside([0.0; 3], 1.34, -64.0);
    molecule.extend([("C", [0.0; 3]), ("O", beside([0.0; 3], 1.23, 58.0)), ("N", nitrogen)]);
    molecule.extend([("H", beside(nitrogen, 1.01, -4.0)), ("H", beside(nitrogen, 1.01, -124.0))]);
    let mut seed = 7u64;
    for _ in 0..50 {
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / (1u64 << 31) as f64
        };
        let rotation = DMat3::from_euler(glam::EulerRot::XYZ, random() * 6.0, random() * 6.0, random() * 6.0);
        let shift = DVec3::new(random(), random(), random()) * 100.0;
        let mut moved: Vec<Site> =
            molecule.iter().map(|&(symbol, at)| (symbol, (rotation * DVec3::from(at) + shift).to_array())).collect();
        for i in (1..moved.len()).rev() {
            moved.swap(i, (random() * (i + 1) as f64) as usize);
        }
        assert_multiple(&moved, &["C=O"]);
    }
}

#[test]
fn a_partial_list_of_single_bonds_is_open_and_one_with_a_double_bond_is_not() {
    let with_list = |orders: [BondOrder; 2]| {
        let sites = [("O", [1.16, 0.0, 0.0]), ("C", [0.0; 3]), ("O", [-1.16, 0.0, 0.0])];
        let mut builder = StructureBuilder::new();
        for (symbol, position) in sites {
            let element = Element::from_symbol(symbol).unwrap_or_default();
            builder.push_atom(&AtomRecord { element, position: DVec3::from(position), ..AtomRecord::default() });
        }
        builder.push_bond(Bond::new(0, 1, orders[0], BondSource::File));
        builder.push_bond(Bond::new(1, 2, orders[1], BondSource::File));
        builder.set_stated_bonds(StatedBonds::Partial);
        builder.build(&mut Diagnostics::default())
    };
    let orders = |structure: &Structure| -> Vec<BondOrder> {
        find(structure, 0, &BondOptions::default()).iter().map(|bond| bond.order).collect()
    };
    assert_eq!(orders(&with_list([BondOrder::Single; 2])), [BondOrder::Double; 2]);
    let stated = [BondOrder::Double, BondOrder::Single];
    assert_eq!(orders(&with_list(stated)), stated);
    let options = BondOptions { mode: BondMode::Perceive, ..BondOptions::default() };
    assert_eq!(find(&with_list(stated), 0, &options).iter().filter(|bond| bond.order == BondOrder::Double).count(), 2);
}

/// A patch of a honeycomb, `edge` × `edge` cells.
fn graphene(edge: usize) -> Vec<Site> {
    let length = 1.42;
    let row = 3f64.sqrt() * length;
    let cells = (0..edge * edge).map(|i| (i / edge, i % edge));
    cells
        .flat_map(|(i, j)| {
            let (x, y) = (1.5 * length * i as f64, row * (j as f64 + if i % 2 == 1 { 0.5 } else { 0.0 }));
            [("C", [x, y, 0.0]), ("C", [x + length, y, 0.0])]
        })
        .collect()
}

#[test]
fn sheets_of_thousands_of_atoms_are_solved_and_nearly_all_atoms_have_their_double_bond() {
    let sheet = structure(&graphene(40));
    let bonds = find(&sheet, 0, &BondOptions::default());
    let double = bonds.iter().filter(|bond| bond.order == BondOrder::Double).count();
    assert!(double * 2 > sheet.atom_count() * 96 / 100, "{double} of {}", sheet.atom_count() / 2);
    assert!(double * 2 <= sheet.atom_count());
    let mut doubles = vec![0; sheet.atom_count()];
    for bond in bonds.iter().filter(|bond| bond.order == BondOrder::Double) {
        doubles[bond.a as usize] += 1;
        doubles[bond.b as usize] += 1;
    }
    assert!(doubles.iter().all(|&count| count <= 1));
}

#[test]
fn atoms_in_a_heap_are_no_reason_to_hang() {
    let mut seed = 3u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / (1u64 << 31) as f64
    };
    let symbols = ["C", "N", "O", "S", "P", "C", "C", "Si"];
    let heap: Vec<Site> =
        (0..3000).map(|i| (symbols[i % 8], [random() * 25.0, random() * 25.0, random() * 25.0])).collect();
    let bonds = find(&structure(&heap), 0, &BondOptions::default());
    assert!(bonds.iter().all(|bond| bond.order != BondOrder::Unknown));
}

#[test]
fn the_score_of_a_choice_is_the_sum_of_its_features_costs_and_lengths() {
    let molecule = structure(&benzene());
    let bonds = find(&molecule, 0, &BondOptions::default());
    let graph = Graph::new(molecule.elements(), molecule.positions().relative(), &bonds, None);
    let rings = rings::find(&graph, |_| true, rings::LARGEST_RING, &Stop::never());
    let setup = Setup::new(graph, &rings, &|_| true, &|_| true);
    let mut component = Component::new(&setup);
    component.read(0, f32::INFINITY);
    let (mut problem, mut solver) = (Problem::default(), Solver::default());
    component.state_problem(&*MODEL, &mut problem);
    let chosen = solver.solve(&problem);
    struct Unweighted;
    impl features::Weights for Unweighted {
        fn weight(&self, _: u64) -> f32 {
            0.0
        }
    }
    let score = problem.score(chosen);
    component.state_problem(&Unweighted, &mut problem);
    let mut by_features = problem.score(chosen);
    component
        .features(chosen, &mut |feature, value| by_features += features::Weights::weight(&*MODEL, feature) * value);
    assert!((score - by_features).abs() < 1e-3 && score != 0.0, "{score} {by_features}");
}

/// Aromatic bonds without orders between elements, with the charges stated, as MOL2 and SDF give them.
fn kekule_orders(symbols: &[(&str, i8)], aromatic: &[(u32, u32)], single: &[(u32, u32)]) -> Vec<u8> {
    let mut builder = StructureBuilder::new();
    for &(symbol, formal_charge) in symbols {
        let element = Element::from_symbol(symbol).unwrap_or_default();
        builder.push_atom(&AtomRecord { element, formal_charge, ..AtomRecord::default() });
    }
    for &(a, b) in aromatic {
        builder.push_bond(Bond { aromatic: true, ..Bond::new(a, b, BondOrder::Unknown, BondSource::File) });
    }
    for &(a, b) in single {
        builder.push_bond(Bond::new(a, b, BondOrder::Single, BondSource::File));
    }
    builder.set_stated_bonds(StatedBonds::Complete);
    let structure = builder.build(&mut Diagnostics::default());
    let bonds = find(&structure, 0, &BondOptions::default());
    assert!(bonds.iter().zip(structure.bonds()).all(|(now, before)| now.aromatic == before.aromatic));
    let is_aromatic = |bond: &&Bond| aromatic.contains(&(bond.a, bond.b));
    bonds.iter().filter(is_aromatic).map(|bond| bond.order.number()).collect()
}

const RING_OF_FIVE: [(u32, u32); 5] = [(0, 1), (0, 4), (1, 2), (2, 3), (3, 4)];
const RING_OF_SIX: [(u32, u32); 6] = [(0, 1), (0, 5), (1, 2), (2, 3), (3, 4), (4, 5)];

#[test]
fn aromatic_bonds_of_a_file_get_a_kekule_form() {
    let doubles = |orders: &[u8]| orders.iter().filter(|&&order| order == 2).count();
    let benzene = kekule_orders(&[("C", 0); 6], &RING_OF_SIX, &[]);
    assert_eq!((benzene.len(), doubles(&benzene)), (6, 3));
    // Without hydrogens pyrrole's nitrogen keeps its lone pair: every carbon has its double bond so.
    let pyrrole = kekule_orders(&[("N", 0), ("C", 0), ("C", 0), ("C", 0), ("C", 0)], &RING_OF_FIVE, &[]);
    assert_eq!(pyrrole, [1, 1, 2, 1, 2]);
    let furan = kekule_orders(&[("O", 0), ("C", 0), ("C", 0), ("C", 0), ("C", 0)], &RING_OF_FIVE, &[]);
    assert_eq!(furan, [1, 1, 2, 1, 2]);
    // Methylpyridinium, its charge stated or not.
    for charge in [0, 1] {
        let mut atoms = vec![("N", charge)];
        atoms.extend([("C", 0); 6]);
        assert_eq!(doubles(&kekule_orders(&atoms, &RING_OF_SIX, &[(0, 6)])), 3, "{charge}");
    }
}

#[test]
fn charged_groups_that_mol2_calls_aromatic_get_orders() {
    let doubles = |orders: Vec<u8>| orders.iter().filter(|&&order| order == 2).count();
    assert_eq!(doubles(kekule_orders(&[("C", 0), ("O", 0), ("O", 0), ("C", 0)], &[(0, 1), (0, 2)], &[(0, 3)])), 1);
    let guanidinium = [("C", 0), ("N", 0), ("N", 0), ("N", 0), ("C", 0)];
    assert_eq!(doubles(kekule_orders(&guanidinium, &[(0, 1), (0, 2), (0, 3)], &[(3, 4)])), 1);
    let phosphate = [("P", 0), ("O", 0), ("O", 0), ("O", 0), ("O", 0)];
    assert_eq!(doubles(kekule_orders(&phosphate, &[(0, 1), (0, 2), (0, 3)], &[(0, 4)])), 1);
}

#[test]
fn what_has_no_kekule_form_gets_as_many_double_bonds_as_there_can_be() {
    let orders = kekule_orders(&[("C", 0); 5], &RING_OF_FIVE, &[]);
    assert_eq!(orders.iter().filter(|&&order| order == 2).count(), 2);
}

#[test]
fn aromatic_rings_of_a_written_kekule_form_are_found() {
    let rings = |symbols: &[&str], bonds: &[(u32, u32, BondOrder)]| {
        let mut builder = StructureBuilder::new();
        for symbol in symbols {
            let element = Element::from_symbol(symbol).unwrap_or_default();
            builder.push_atom(&AtomRecord { element, ..AtomRecord::default() });
        }
        for &(a, b, order) in bonds {
            builder.push_bond(Bond::new(a, b, order, BondSource::File));
        }
        let structure = builder.build(&mut Diagnostics::default());
        aromatic_rings(&structure, structure.bonds()).iter().map(Vec::len).collect::<Vec<_>>()
    };
    let (single, double) = (BondOrder::Single, BondOrder::Double);
    let six = [(0, 1, double), (1, 2, single), (2, 3, double), (3, 4, single), (4, 5, double), (0, 5, single)];
    assert_eq!(rings(&["C"; 6], &six), [6]);
    // Quinone: two carbonyls take the electrons away.
    let quinone = [
        (0, 1, double),
        (1, 2, single),
        (2, 3, single),
        (3, 4, double),
        (4, 5, single),
        (0, 5, single),
        (2, 6, double),
        (5, 7, double),
    ];
    assert_eq!(rings(&["C", "C", "C", "C", "C", "C", "O", "O"], &quinone), [0; 0]);
    // Cyclobutadiene has four electrons, azulene ten on its outline and not six in either ring.
    assert_eq!(rings(&["C"; 4], &[(0, 1, double), (1, 2, single), (2, 3, double), (0, 3, single)]), [0; 0]);
    let azulene = [
        (0, 1, double),
        (1, 2, single),
        (2, 3, double),
        (3, 4, single),
        (0, 4, single),
        (4, 5, double),
        (5, 6, single),
        (6, 7, double),
        (7, 8, single),
        (8, 9, double),
        (3, 9, single),
    ];
    assert_eq!(rings(&["C"; 10], &azulene), [10]);
}

/// Orders from distances: bonds as [`multiple`] names them, and the charges.
fn perceived(sites: &[Site]) -> (Vec<String>, Vec<String>) {
    (multiple(&structure(sites)), charges_of(sites))
}

/// The corners of a tetrahedron at these distances from an atom in the origin.
fn tetrahedron(center: &'static str, ends: &[(&'static str, f64)]) -> Vec<Site> {
    let corners = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
    let mut sites = vec![(center, [0.0; 3])];
    let at = |corner: [f64; 3], length: f64| corner.map(|along| along * length / 3f64.sqrt());
    sites.extend(corners.into_iter().zip(ends).map(|(corner, &(symbol, length))| (symbol, at(corner, length))));
    sites
}

/// Three neighbours at one distance, the central atom this far over their plane.
fn pyramid(center: &'static str, end: &'static str, length: f64, height: f64) -> Vec<Site> {
    let mut sites = vec![(center, [0.0, 0.0, height])];
    sites.extend(ring(&[end; 3], (length * length - height * height).sqrt()));
    sites
}

// Lengths of the ions in crystals, as textbooks give them (Greenwood and Earnshaw, Chemistry of the Elements).
#[test]
fn oxo_anions_with_equal_bonds_have_the_orders_of_their_lewis_formulas_and_their_charge() {
    for (center, length, double, charge) in [
        ("S", 1.49, 2, 2),
        ("P", 1.54, 1, 3),
        ("Cl", 1.44, 3, 1),
        ("Si", 1.63, 0, 4),
        ("Se", 1.64, 2, 2),
        ("As", 1.69, 1, 3),
        ("Mn", 1.63, 3, 1),
        ("Cr", 1.65, 2, 2),
        ("V", 1.71, 1, 3),
        ("W", 1.78, 2, 2),
        ("Mo", 1.77, 2, 2),
        ("Tc", 1.71, 3, 1),
        ("Os", 1.71, 4, 0),
    ] {
        let (orders, charges) = perceived(&tetrahedron(center, &[("O", length); 4]));
        assert_eq!((orders.len(), charges.len()), (double, charge), "{center}");
        assert!(charges.iter().all(|charge| charge == "O-1"), "{center}: {charges:?}");
    }
    for (center, length, height, double, charge) in
        [("S", 1.51, 0.53, 1, 2), ("S", 1.42, 0.0, 3, 0), ("Cl", 1.49, 0.55, 2, 1), ("P", 1.53, 0.5, 0, 3)]
    {
        let (orders, charges) = perceived(&pyramid(center, "O", length, height));
        assert_eq!((orders.len(), charges.len()), (double, charge), "{center}, {height} Å high");
    }
    assert_eq!(perceived(&pyramid("C", "O", 1.29, 0.0)).1, ["O-1"; 2]);
    assert_eq!(perceived(&pyramid("N", "O", 1.25, 0.0)).1, ["N+1", "O-1", "O-1"]);
}

#[test]
fn an_end_that_is_longer_than_the_others_has_a_hydrogen_that_is_not_listed() {
    let ends = |long: usize, short: f64, length: f64| -> [(&'static str, f64); 4] {
        std::array::from_fn(|i| ("O", if i < long { length } else { short }))
    };
    assert_eq!(perceived(&tetrahedron("S", &ends(1, 1.45, 1.57))).1, ["O-1"]);
    assert_eq!(perceived(&tetrahedron("P", &ends(2, 1.51, 1.57))).1, ["O-1"]);
    let (orders, charges) = perceived(&tetrahedron("P", &ends(3, 1.49, 1.57)));
    assert_eq!((orders, charges), (vec!["O=P".to_owned()], Vec::new()));
}

/// A metal in the origin with such diatomic ligands in the given directions.
fn on_metal(metal: &'static str, near: (&'static str, f64), far: (&'static str, f64), ways: &[[f64; 3]]) -> Vec<Site> {
    let mut sites = vec![(metal, [0.0; 3])];
    for way in ways {
        let unit = DVec3::from(*way).normalize();
        sites.push((near.0, (unit * near.1).to_array()));
        sites.push((far.0, (unit * (near.1 + far.1)).to_array()));
    }
    sites
}

#[test]
fn carbonyls_and_cyanides_have_triple_bonds_and_nitrosyls_those_of_their_angle() {
    let octahedron =
        [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let (orders, charges) = perceived(&on_metal("Mo", ("C", 2.06), ("O", 1.145), &octahedron));
    assert_eq!(orders, ["C#O"; 6]);
    assert_eq!(charges.iter().filter(|charge| *charge == "C-1").count(), 6);
    assert_eq!(perceived(&on_metal("Fe", ("C", 1.92), ("N", 1.16), &octahedron)).1, ["C-1"; 6]);
    assert_eq!(perceived(&on_metal("Ru", ("N", 1.93), ("N", 1.11), &octahedron[..1])).0, ["N#N"]);
    assert_eq!(perceived(&on_metal("Fe", ("N", 1.66), ("O", 1.13), &octahedron[..1])).0, ["N#O"]);
    let bent = [("Co", [0.0; 3]), ("N", [1.85, 0.0, 0.0]), ("O", [2.5, 0.95, 0.0])];
    assert_eq!(perceived(&bent).0, ["N=O"]);
    // Carbon monoxide between two metals has a ketone's bond.
    let bridge =
        [("Fe", [1.26, 0.0, 0.0]), ("Fe", [-1.26, 0.0, 0.0]), ("C", [0.0, 1.55, 0.0]), ("O", [0.0, 2.72, 0.0])];
    assert_eq!(perceived(&bridge).0, ["C=O"]);
}

#[test]
fn rings_and_cages_of_lone_pairs_are_not_aromatic() {
    for (symbol, radius) in [("P", 2.2), ("As", 2.42), ("S", 2.05)] {
        for size in 3..=6 {
            let radius = radius / 2.0 / (std::f64::consts::PI / size as f64).sin();
            assert_eq!(multiple(&structure(&ring(&vec![symbol; size], radius))), [""; 0], "{symbol}{size}");
        }
    }
    // White phosphorus: six bonds of 2.21 Å.
    let corners = tetrahedron("H", &[("P", 2.21 * 0.375f64.sqrt()); 4]);
    assert_eq!(multiple(&structure(&corners[1..])), [""; 0]);
}

#[test]
fn rings_that_a_charge_makes_aromatic_have_it() {
    for (size, length, charge) in [(3, 1.37, "C+1"), (5, 1.41, "C-1"), (7, 1.40, "C+1")] {
        let radius = length / 2.0 / (std::f64::consts::PI / size as f64).sin();
        let mut sites = ring(&vec!["C"; size], radius);
        sites.extend(ring(&vec!["H"; size], radius + 1.085));
        assert_eq!(perceived(&sites), (vec!["C~C".to_owned(); size], vec![charge.to_owned()]), "{size}");
    }
    // Ferrocene without its hydrogens.
    let rings =
        [1.66, -1.66].map(|height| ring(&["C"; 5], 1.21).into_iter().map(move |(c, [x, y, _])| (c, [x, y, height])));
    let mut ferrocene = vec![("Fe", [0.0; 3])];
    ferrocene.extend(rings.into_iter().flatten());
    assert_eq!(perceived(&ferrocene), (vec!["C~C".to_owned(); 10], vec!["C-1".to_owned(); 2]));
}

#[test]
fn ozone_triiodide_diborane_and_nitrogen_dioxide() {
    // Ozone 1.278 Å and 116.8°, nitrite 1.24 Å and 115°, nitrogen dioxide 1.19 Å and 134°.
    let bent = |center, length, angle: f64| {
        [(center, [0.0; 3]), ("O", beside([0.0; 3], length, 0.0)), ("O", beside([0.0; 3], length, angle))]
    };
    assert_eq!(perceived(&bent("O", 1.278, 116.8)), (vec!["O=O".to_owned()], vec!["O+1".to_owned(), "O-1".to_owned()]));
    assert_eq!(charges_of(&bent("N", 1.24, 115.0)), ["O-1"]);
    assert_eq!(charges_of(&bent("N", 1.19, 134.0)), [""; 0]);
    assert_eq!(charges_of(&[("I", [-2.92, 0.0, 0.0]), ("I", [0.0; 3]), ("I", [2.92, 0.0, 0.0])]), ["I-1"]);
    let mut diborane: Vec<Site> = vec![("B", [-0.885, 0.0, 0.0]), ("B", [0.885, 0.0, 0.0])];
    diborane.extend([("H", [0.0, 0.993, 0.0]), ("H", [0.0, -0.993, 0.0])]);
    for x in [-1.46, 1.46] {
        diborane.extend([("H", [x, 0.0, 1.04]), ("H", [x, 0.0, -1.04])]);
    }
    assert_eq!(charges_of(&diborane), [""; 0]);
}

#[test]
fn a_triple_bond_needs_a_line_and_a_length() {
    let butyne = |angle: f64, length: f64| {
        let [x, y, _] = beside([0.0; 3], 1.46, angle);
        [("C", [x, y, 0.0]), ("C", [0.0; 3]), ("C", [length, 0.0, 0.0]), ("C", [length + 1.46, 0.0, 0.0])]
    };
    assert_eq!(multiple(&structure(&butyne(180.0, 1.2))), ["C#C"]);
    assert_eq!(multiple(&structure(&butyne(168.0, 1.2))), ["C#C"]);
    for (angle, length) in [(140.0, 1.2), (180.0, 1.03)] {
        assert!(!multiple(&structure(&butyne(angle, length))).contains(&"C#C".to_owned()), "{angle} {length}");
    }
}
