//! Our bonds beside those of other toolkits, molecule by molecule.
//!
//! The corpus holds, in `good/bonds`, which bonds PyMOL, Open Babel and RDKit find in a file. A bond that more than half of
//! them have and we have not is *missing*; a covalent one of ours that none of them has is *extra*. Each of these must
//! belong to a class of which a rule, not a list of atoms, tells it; the classes, and why we hold ourselves right there:
//!
//! - **alternate locations**: the two atoms are alternatives of one another and never there at once. Toolkits that read
//!   all locations bond them because they are near.
//! - **1,3-contact**: both atoms are bonded to one and the same third by name (dictionary or file), or one of them lies on top of
//!   it: they are only near, in a side chain that is built out of shape.
//! - **long dictionary bond**: the names of residue and atoms say that there is a bond, and it is longer than the covalent
//!   radii and 0.45 Å, where the toolkits' distances end. A lysine built without density still has its NZ.
//! - **duplicate atoms**: a CONECT record names a serial number that several atoms have; which is meant cannot be known.
//!   We take the nearest, of equals the first, the toolkits the last.
//! - **metal**: which contacts of a metal are sticks is a matter of taste, and the tools differ most here; a missing one is
//!   counted, but not an error. In molecules without metals this class does not exist.
//! - **periodic image**: the bond goes across a face of the cell. The toolkits take no notice of the cell.
//!
//! Without a corpus the same table is made of the files of `data/` that list all their bonds: against the list stands what
//! is found from the positions alone.

use crate::files;
use ballstick::bonds::{self, BondMode, BondOptions};
use ballstick::import::{ImportOptions, read_path};
use ballstick::structure::{Bond, BondKind, BondSource, StatedBonds, Structure};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet, HashMap};

type Pair = (u32, u32);

/// Who else has looked for bonds, by their names in the corpus.
const TOOLKITS: [&str; 3] = ["pymol", "openbabel", "rdkit"];
/// Where the distances of the toolkits end: Open Babel's tolerance over the sum of the covalent radii, the widest of them.
const TOOLKITS_TOLERANCE: f32 = 0.45;
/// Nearer than this are two images of one atom, ångström.
const NEAREST: f32 = 0.4;
/// The part of the bonds that have to agree, either way.
const AGREEMENT: f64 = 0.995;

/// What one molecule came to.
#[derive(Default)]
struct Row {
    needed: usize,
    ours: usize,
    missing: Vec<(Pair, Option<&'static str>)>,
    extra: Vec<(Pair, Option<&'static str>)>,
    /// Bonds across the cell, which have no counterpart in a list of pairs.
    periodic: usize,
    has_metal: bool,
}

/// What rules need to know of a molecule and our bonds.
struct Ours<'a> {
    structure: &'a Structure,
    bonds: &'a [Bond],
    of_pair: HashMap<Pair, Bond>,
    around: Vec<Vec<u32>>,
    shared_serial: BTreeSet<i32>,
}

impl<'a> Ours<'a> {
    fn new(structure: &'a Structure, bonds: &'a [Bond]) -> Ours<'a> {
        let mut around = vec![Vec::new(); structure.atom_count()];
        let mut of_pair = HashMap::new();
        for bond in bonds.iter().filter(|bond| !bond.is_periodic() && bond.kind != BondKind::Hydrogen) {
            of_pair.insert((bond.a, bond.b), *bond);
            around[bond.a as usize].push(bond.b);
            around[bond.b as usize].push(bond.a);
        }
        let (mut seen, mut shared_serial) = (BTreeSet::new(), BTreeSet::new());
        for atom in 0..structure.atom_count() {
            if !seen.insert(structure.serial(atom)) {
                shared_serial.insert(structure.serial(atom));
            }
        }
        Ours { structure, bonds, of_pair, around, shared_serial }
    }

    fn is_metal(&self, (a, b): Pair) -> bool {
        [a, b].iter().any(|&atom| self.structure.elements()[atom as usize].is_metal())
    }

    fn length(&self, (a, b): Pair) -> f32 {
        let at = |atom: u32| self.structure.positions().get(atom as usize);
        at(a).distance(at(b)) as f32
    }

    fn are_alternatives(&self, (a, b): Pair) -> bool {
        let [one, other] = [a, b].map(|atom| self.structure.altloc(atom as usize));
        one != other && one != b' ' && other != b' '
    }

    fn share_a_serial(&self, (a, b): Pair) -> bool {
        [a, b].iter().any(|&atom| self.shared_serial.contains(&self.structure.serial(atom as usize)))
    }

    fn by_name(&self, one: u32, other: u32) -> bool {
        let bond = self.of_pair.get(&(one.min(other), one.max(other)));
        bond.is_some_and(|bond| bond.source != BondSource::Distance)
    }

    /// Why a bond of the toolkits is none of ours.
    fn why_missing(&self, pair: Pair) -> Option<&'static str> {
        let (a, b) = pair;
        // Of two atoms at one place only one has the bonds of both.
        let is_at = |one: u32, other: u32| self.by_name(one, other) || self.length((one, other)) < NEAREST;
        let is_between = |&third: &u32| third != a && third != b && is_at(a, third) && is_at(b, third);
        Some(match () {
            () if self.are_alternatives(pair) => "alternate locations",
            () if self.share_a_serial(pair) => "duplicate atoms",
            () if self.is_metal(pair) => "metal",
            () if self.bonds.iter().any(|bond| bond.is_periodic() && (bond.a, bond.b) == pair) => "periodic image",
            () if self.around[a as usize].iter().chain(&self.around[b as usize]).any(is_between) => "1,3-contact",
            () => return None,
        })
    }

    /// Why a bond of ours is none of the toolkits'.
    fn why_extra(&self, pair: Pair) -> Option<&'static str> {
        let radii: f32 =
            [pair.0, pair.1].iter().map(|&atom| self.structure.elements()[atom as usize].covalent_radius()).sum();
        let source = self.of_pair.get(&pair).map(|bond| bond.source);
        Some(match () {
            () if self.share_a_serial(pair) => "duplicate atoms",
            () if self.is_metal(pair) => "metal",
            () if source == Some(BondSource::Dictionary) && self.length(pair) > radii + TOOLKITS_TOLERANCE => {
                "long dictionary bond"
            }
            () => return None,
        })
    }

    fn label(&self, (a, b): Pair) -> String {
        let atom = |atom: u32| {
            let index = atom as usize;
            let residue = self.structure.residue_index(index).map(|index| self.structure.residues()[index]);
            let residue = residue
                .map_or(String::new(), |residue| format!("{}{}.", self.structure.name(residue.name), residue.number));
            let name = match self.structure.atom_name(index) {
                "" => format!("{}{atom}", self.structure.elements()[index]),
                name => name.to_owned(),
            };
            format!("{residue}{name}")
        };
        format!("{}–{} {:.2}", atom(a), atom(b), self.length((a, b)))
    }
}

/// Compares our bonds with those that are needed and those that are known to anyone.
fn compare(ours: &Ours<'_>, needed: &BTreeSet<Pair>, known: &BTreeSet<Pair>) -> Row {
    let missing = needed.iter().filter(|pair| !ours.of_pair.contains_key(pair));
    let mut extra: Vec<Pair> = (ours.of_pair.iter())
        .filter(|(pair, bond)| bond.kind == BondKind::Covalent && !known.contains(pair))
        .map(|(&pair, _)| pair)
        .collect();
    extra.sort_unstable();
    Row {
        needed: needed.len(),
        ours: ours.of_pair.values().filter(|bond| bond.kind == BondKind::Covalent).count(),
        missing: missing.map(|&pair| (pair, ours.why_missing(pair))).collect(),
        extra: extra.into_iter().map(|pair| (pair, ours.why_extra(pair))).collect(),
        periodic: ours.bonds.iter().filter(|bond| bond.is_periodic()).count(),
        has_metal: ours.structure.elements().iter().any(|element| element.is_metal()),
    }
}

/// The reasons of some pairs with their numbers, those without a reason by name.
fn reasons(ours: &Ours<'_>, pairs: &[(Pair, Option<&'static str>)]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let mut words = Vec::new();
    for (pair, why) in pairs {
        match why {
            Some(why) => *counts.entry(why).or_default() += 1,
            None => words.push(format!("UNEXPLAINED {}", ours.label(*pair))),
        }
    }
    words.extend(counts.into_iter().map(|(why, count)| format!("{count} {why}")));
    words.join(", ")
}

/// All rows, and what speaks against us.
#[derive(Default)]
struct Table {
    rows: usize,
    needed: usize,
    ours: usize,
    missing: usize,
    extra: usize,
    wrong: Vec<String>,
}

impl Table {
    fn head(title: &str) {
        println!(
            "\n{title}\n{:<48}{:>8}{:>8}{:>8}{:>8}{:>9}  why",
            "molecule", "needed", "ours", "missing", "extra", "periodic"
        );
    }

    fn add(&mut self, name: &str, ours: &Ours<'_>, row: &Row) {
        let why: Vec<String> = [("missing", &row.missing), ("extra", &row.extra)]
            .into_iter()
            .filter(|(_, pairs)| !pairs.is_empty())
            .map(|(what, pairs)| format!("{what}: {}", reasons(ours, pairs)))
            .collect();
        let (missing, extra) = (row.missing.len(), row.extra.len());
        println!(
            "{name:<48}{:>8}{:>8}{missing:>8}{extra:>8}{:>9}  {}",
            row.needed,
            row.ours,
            row.periodic,
            why.join("; ")
        );
        for (pair, why) in row.missing.iter().chain(&row.extra) {
            if why.is_none() || (*why == Some("metal") && !row.has_metal) {
                self.wrong.push(format!("{name}: {}", ours.label(*pair)));
            }
        }
        self.rows += 1;
        self.needed += row.needed;
        self.ours += row.ours;
        self.missing += missing;
        self.extra += extra;
    }

    fn judge(&self) {
        let part = |of: usize, bad: usize| 1.0 - bad as f64 / of.max(1) as f64;
        let (found, known) = (part(self.needed, self.missing), part(self.ours, self.extra));
        println!(
            "{} molecules: of {} bonds {} missing ({:.2} % found), of our {} {} extra ({:.2} % known to others)",
            self.rows,
            self.needed,
            self.missing,
            100.0 * found,
            self.ours,
            self.extra,
            100.0 * known
        );
        assert!(self.rows > 0 && self.needed > 0, "nothing was compared");
        assert!(self.wrong.is_empty(), "no class explains\n{}", self.wrong.join("\n"));
        assert!(found >= AGREEMENT && known >= AGREEMENT, "agreement below {AGREEMENT}");
    }
}

#[test]
fn our_bonds_are_those_of_the_toolkits_or_there_is_a_reason() {
    let Some(folder) = files::corpus("good") else { return };
    let mut lists: Vec<_> = std::fs::read_dir(folder.join("bonds")).unwrap().flatten().map(|e| e.path()).collect();
    lists.sort();
    Table::head("bonds that more than half of the toolkits find, and ours");
    let mut table = Table::default();
    for list in lists {
        let name = list.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let said: Value = serde_json::from_slice(&std::fs::read(&list).unwrap()).unwrap();
        let document = read_path(&folder.join(&name), &ImportOptions::default()).expect(&name);
        let structure = &document.records[0];
        let bonds = bonds::find(structure, 0, &BondOptions::default());
        let toolkits: Vec<BTreeSet<Pair>> = TOOLKITS.iter().filter_map(|&toolkit| pairs_of(&said[toolkit])).collect();
        let mut votes: BTreeMap<Pair, usize> = BTreeMap::new();
        for &pair in toolkits.iter().flatten() {
            *votes.entry(pair).or_default() += 1;
        }
        let most = |votes: usize| 2 * votes > toolkits.len();
        let needed = votes.iter().filter(|&(_, &votes)| most(votes)).map(|(&pair, _)| pair).collect();
        let known = votes.keys().copied().collect();
        let ours = Ours::new(structure, &bonds);
        table.add(&name, &ours, &compare(&ours, &needed, &known));
    }
    table.judge();
}

fn pairs_of(list: &Value) -> Option<BTreeSet<Pair>> {
    let number = |value: &Value| u32::try_from(value.as_u64()?).ok();
    let pair = |bond: &Value| {
        let (a, b) = (number(&bond[0])?, number(&bond[1])?);
        Some((a.min(b), a.max(b)))
    };
    list.as_array()?.iter().map(pair).collect()
}

#[test]
fn bonds_that_the_files_of_data_list_are_found_from_the_positions() {
    Table::head("bonds that files of data/ list, and ours from the positions alone");
    let mut table = Table::default();
    let mut paths: Vec<_> = std::fs::read_dir(files::data()).unwrap().flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let Ok(document) = read_path(&path, &ImportOptions::default()) else { continue };
        for (number, structure) in document.records.iter().enumerate() {
            if structure.stated_bonds() != StatedBonds::Complete {
                continue;
            }
            let bonds = bonds::find(structure, 0, &BondOptions { mode: BondMode::Perceive, ..BondOptions::default() });
            let listed: BTreeSet<Pair> = structure.bonds().iter().map(|bond| (bond.a, bond.b)).collect();
            let ours = Ours::new(structure, &bonds);
            table.add(&format!("{} {}", files::name(&path), number + 1), &ours, &compare(&ours, &listed, &listed));
        }
    }
    table.judge();
}
