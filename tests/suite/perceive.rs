//! Listed bonds found again from the positions alone.
//!
//! Of every molecule of the SDF and MOL2 files of `data/` and the corpus the bonds are taken away, its atoms shuffled and
//! moved by normal noise of 0.03 Å, which is what the coordinates of a crystal structure are good for. What `--bonds perceive`
//! finds is compared with what the file lists: the pairs exactly, the orders after aromatic bonds were made alike in both
//! and up to the symmetry of the molecule (which oxygen of a carboxylate has the double bond is nobody's concern).
//!
//! Left out, with the reason printed: drawings (flat, with all bonds of one length, of impossible lengths, or with four
//! bonds of a carbon in the plane), records with dummies or with atoms at one place, and those so large that they are proteins.

use crate::files;
use ballstick::bonds::{self, BondMode, BondOptions};
use ballstick::element::Element;
use ballstick::import::{Format, ImportOptions, read_path};
use ballstick::structure::{
    AtomRecord, Bond, BondKind, BondOrder, Diagnostics, StatedBonds, Structure, StructureBuilder,
};
use glam::DVec3;
use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Standard deviation of the noise in each direction, ångström.
const NOISE: f64 = 0.03;
/// Every molecule is moved this many times anew.
const TIMES: u64 = 5;
/// No two atoms are nearer, ångström: H₂ has 0.74.
const NEAREST: f64 = 0.6;
/// Larger ones are left to the other tests.
const MOST_ATOMS: usize = 500;

/// SplitMix64 (Steele, Lea and Flood 2014): the same numbers everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The sum of twelve uniform numbers less 6 has the variance 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// The atoms in another order and moved; where each new atom was.
fn disturbed(structure: &Structure, random: &mut Random) -> (Structure, Vec<u32>) {
    let mut order: Vec<u32> = (0..structure.atom_count() as u32).collect();
    for last in (1..order.len()).rev() {
        order.swap(last, (random.next() % (last as u64 + 1)) as usize);
    }
    let moved = |&atom: &u32| {
        let noise = DVec3::from_array([0; 3].map(|_| NOISE * random.normal()));
        (atom, structure.positions().get(atom as usize) + noise)
    };
    let mut builder = StructureBuilder::new();
    builder.set_decimals(4);
    for (atom, position) in order.iter().map(moved) {
        let element = structure.elements()[atom as usize];
        builder.push_atom(&AtomRecord { element, position, ..AtomRecord::default() });
    }
    (builder.build(&mut Diagnostics::default()), order)
}

/// Why a record is not for this test.
fn unfit(structure: &Structure) -> Option<&'static str> {
    let positions: Vec<DVec3> = (0..structure.atom_count()).map(|atom| structure.positions().get(atom)).collect();
    let is_flat = positions.iter().all(|point| point.z == 0.0);
    let is_linear = positions.iter().all(|point| point.y == 0.0);
    let saturated = |atom: u32| {
        // A carbon with four partners is never flat.
        structure.bonds().iter().filter(|bond| bond.a == atom || bond.b == atom).count() >= 4
    };
    let length = |bond: &Bond| positions[bond.a as usize].distance(positions[bond.b as usize]);
    let lengths: Vec<f64> = structure.bonds().iter().map(length).collect();
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let overlap = || (1..positions.len()).any(|a| positions[..a].iter().any(|b| b.distance(positions[a]) < NEAREST));
    Some(match () {
        () if structure.bonds().is_empty() => "no bonds",
        () if structure.stated_bonds() != StatedBonds::Complete => "no list of all bonds",
        () if structure.atom_count() > MOST_ATOMS => "too large",
        () if structure.elements().contains(&Element::DUMMY) => "dummies",
        () if overlap() => "atoms at one place",
        () if is_flat && (0..positions.len() as u32).any(saturated) => "a drawing",
        () if is_flat && !is_linear && !structure.elements().contains(&Element::H) => "flat, without hydrogens",
        () if is_flat && lengths.len() > 2 && longest - shortest < 0.03 * longest => "a drawing",
        () if is_flat && !(1.0..1.8).contains(&(lengths.iter().sum::<f64>() / lengths.len() as f64)) => "a drawing",
        () => return None,
    })
}

/// What a bond counts as: aromatic, its order, or a metal's.
fn labels(structure: &Structure, bonds: &[Bond]) -> Vec<u8> {
    let mut aromatic: Vec<bool> = bonds.iter().map(|bond| bond.aromatic).collect();
    for bond in bonds::aromatic_rings(structure, bonds).concat() {
        aromatic[bond as usize] = true;
    }
    let metal = |atom: u32| structure.elements()[atom as usize].is_metal();
    (bonds.iter().zip(aromatic))
        .map(|(bond, aromatic)| match bond.order {
            _ if metal(bond.a) || metal(bond.b) || bond.kind != BondKind::Covalent => 9,
            _ if aromatic => 8,
            order => BondOrder::number(order),
        })
        .collect()
}

/// A number that molecules have in common that are the same up to the names of their atoms: refined by neighbours as Morgan
/// (J. Chem. Doc. 1965, 5, 107) does.
fn graph_key(elements: &[Element], bonds: &[(u32, u32, u8)]) -> Vec<u64> {
    let hash = |value: &dyn Fn(&mut DefaultHasher)| {
        let mut hasher = DefaultHasher::new();
        value(&mut hasher);
        hasher.finish()
    };
    let mut of_atom: Vec<u64> = elements.iter().map(|element| u64::from(element.z())).collect();
    for _ in 0..elements.len() / 2 + 2 {
        let mut around: Vec<Vec<(u64, u8)>> = vec![Vec::new(); elements.len()];
        for &(a, b, label) in bonds {
            around[a as usize].push((of_atom[b as usize], label));
            around[b as usize].push((of_atom[a as usize], label));
        }
        around.iter_mut().for_each(|around| around.sort_unstable());
        of_atom = (of_atom.iter().zip(&around)).map(|(own, around)| hash(&|h| (own, around).hash(h))).collect();
    }
    of_atom.sort_unstable();
    of_atom
}

#[derive(Default)]
struct Count {
    molecules: usize,
    connected: usize,
    ordered: usize,
    wrong: Vec<String>,
}

impl Count {
    fn add(&mut self, name: &str, structure: &Structure, random: &mut Random) {
        let listed = bonds::find(structure, 0, &BondOptions::default());
        let want: BTreeSet<(u32, u32)> = listed.iter().map(|bond| (bond.a, bond.b)).collect();
        let key = |of: &Structure, bonds: &[Bond]| {
            let labels = labels(of, bonds);
            let rows: Vec<(u32, u32, u8)> =
                bonds.iter().zip(labels).map(|(bond, label)| (bond.a, bond.b, label)).collect();
            graph_key(of.elements(), &rows)
        };
        let wanted = key(structure, &listed);
        for time in 0..TIMES {
            let (moved, was) = disturbed(structure, random);
            // With the charges that follow from the bonds.
            let moved = bonds::assign(moved, &BondOptions { mode: BondMode::Perceive, ..BondOptions::default() });
            let found = moved.bonds();
            let pairs: BTreeSet<(u32, u32)> = (found.iter())
                .map(|bond| (was[bond.a as usize], was[bond.b as usize]))
                .map(|(a, b)| (a.min(b), a.max(b)))
                .collect();
            self.molecules += 1;
            let named = |pair: Option<&(u32, u32)>| {
                pair.map(|&(a, b)| {
                    let element = |atom: u32| structure.elements()[atom as usize];
                    format!("{}{a}–{}{b}", element(a), element(b))
                })
            };
            if pairs != want {
                let (lost, new) = (named(want.difference(&pairs).next()), named(pairs.difference(&want).next()));
                self.wrong.push(format!("{name}, time {time}: pairs: lost {lost:?}, new {new:?}"));
                continue;
            }
            self.connected += 1;
            if key(&moved, found) == wanted {
                self.ordered += 1;
            } else {
                self.wrong.push(format!("{name}, time {time}: orders"));
            }
        }
    }
}

#[test]
fn listed_bonds_are_found_again_from_shuffled_and_moved_atoms() {
    let mut random = Random(2024);
    let (mut whole, mut heavy) = (Count::default(), Count::default());
    for path in files::molecules(8 << 20) {
        let Ok(document) = read_path(&path, &ImportOptions::default()) else { continue };
        if !matches!(document.format, Format::Sdf | Format::Mol2) {
            continue;
        }
        for (number, structure) in document.records.iter().enumerate() {
            let name = format!("{} {}", files::name(&path), number + 1);
            match unfit(structure) {
                Some(why) => println!("left out: {name}: {why}"),
                None if structure.elements().contains(&Element::H) => whole.add(&name, structure, &mut random),
                None => heavy.add(&name, structure, &mut random),
            }
        }
    }
    for (what, count) in [("with hydrogens", &whole), ("without", &heavy)] {
        println!(
            "{what}: {} molecules moved, pairs right {}, orders too {}",
            count.molecules, count.connected, count.ordered
        );
        println!("{}", count.wrong.join("\n"));
    }
    assert!(whole.molecules > 0, "nothing was compared");
    let is_enough = |count: usize, of: usize, part: f64| count as f64 >= part * of as f64;
    assert!(is_enough(whole.connected, whole.molecules, 0.995) && is_enough(heavy.connected, heavy.molecules, 0.97));
    assert!(is_enough(whole.ordered, whole.molecules, 0.97) && is_enough(heavy.ordered, heavy.molecules, 0.90));
}
