//! Residues and ligands of PDB and mmCIF entries beside the Chemical Component Dictionary.
//!
//! Of every residue whose name is a component and whose atoms are all of it, the bonds among its atoms must be those of the
//! component, order and aromaticity included, or one of these reasons must hold by rule:
//!
//! - the file itself states the bond with an order;
//! - one of the atoms is a metal and the dictionary has a single bond: it is coordination here, as everywhere;
//! - the bond is longer than any, or shorter than 0.4 Å: the atoms are not where their names say;
//! - the atoms are alternatives of each other.
//!
//! The dictionary is its text, not the packed form inside the program: `BALLSTICK_CCD` names it. Unset prints SKIP.

use crate::files;
use ballstick::bonds::{self, BondOptions};
use ballstick::element::Element;
use ballstick::import::{Format, ImportOptions, read_path};
use ballstick::structure::{Bond, BondKind, BondSource, Structure};
use std::collections::{BTreeMap, HashMap};
use std::io::Read;
use std::path::PathBuf;

/// Longer than the covalent radii by this much is no bond whatever the names say: 1.2 Å, and 0.45 Å for hydrogen.
const LONGEST_EXCESS: [f32; 2] = [1.2, 0.45];
/// Larger files are left out: one residue more tells nothing more.
const MAX_BYTES: u64 = 16 << 20;

/// Element by atom name, and order and aromaticity by the two names, the smaller first.
#[derive(Default)]
struct Component {
    elements: HashMap<String, Element>,
    bonds: HashMap<(String, String), (u8, bool)>,
}

fn dictionary() -> Option<HashMap<String, Component>> {
    let path = PathBuf::from(std::env::var_os("BALLSTICK_CCD")?);
    let bytes = std::fs::read(&path).unwrap();
    let mut text = String::new();
    if path.extension().is_some_and(|extension| extension == "zst") {
        ruzstd::decoding::StreamingDecoder::new(bytes.as_slice()).unwrap().read_to_string(&mut text).unwrap();
    } else {
        text = String::from_utf8(bytes).unwrap();
    }
    let mut components = HashMap::new();
    let mut lines = text.lines();
    while let Some(id) = lines.next().and_then(|line| line.strip_prefix('>')) {
        let (atoms, bonds) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
        let mut component = Component::default();
        let mut names = Vec::new();
        for atom in atoms.split(' ').filter(|atom| !atom.is_empty()) {
            let (name, symbol) = atom.split_once(':').unwrap();
            let symbol = symbol.split(':').next().unwrap_or_default();
            names.push(name.to_owned());
            component.elements.insert(name.to_owned(), Element::from_symbol(symbol).unwrap_or(Element::DUMMY));
        }
        for bond in bonds.split(' ').filter(|bond| !bond.is_empty()) {
            let (pair, order) = bond.split_once(':').unwrap();
            let (a, b) = pair.split_once('-').unwrap();
            let [a, b] = [a, b].map(|index| names[index.parse::<usize>().unwrap()].clone());
            let value = (order.trim_end_matches('*').parse().unwrap(), order.ends_with('*'));
            component.bonds.insert((a.clone().min(b.clone()), a.max(b)), value);
        }
        components.insert(id.to_owned(), component);
    }
    Some(components)
}

/// What came of all residues.
#[derive(Default)]
struct Counts {
    exact: usize,
    reasons: BTreeMap<&'static str, usize>,
    left_out: BTreeMap<&'static str, usize>,
    bonds: usize,
    wrong: Vec<String>,
}

impl Counts {
    fn residue(
        &mut self,
        file: &str,
        structure: &Structure,
        of_pair: &HashMap<(u32, u32), Bond>,
        residue: usize,
        component: &Component,
    ) {
        let residues = structure.residues();
        let first = residues[residue].first_atom;
        let end = residues.get(residue + 1).map_or(structure.atom_count() as u32, |next| next.first_atom);
        let known = |atom: u32| {
            let element = component.elements.get(structure.atom_name(atom as usize))?;
            (*element == structure.elements()[atom as usize] || *element == Element::DUMMY).then_some(())
        };
        let heavy = |atom: u32| structure.elements()[atom as usize] != Element::H;
        if (first..end).any(|atom| heavy(atom) && known(atom).is_none()) {
            *self.left_out.entry("atoms of other names").or_default() += 1;
            return;
        }
        let atoms: Vec<u32> = (first..end).filter(|&atom| known(atom).is_some()).collect();
        let place = |atom: u32| (structure.atom_name(atom as usize), structure.altloc(atom as usize));
        let mut places: Vec<_> = atoms.iter().map(|&atom| place(atom)).collect();
        places.sort_unstable();
        if places.windows(2).any(|pair| pair[0] == pair[1] || pair[0].0 == pair[1].0 && pair[0].1 == b' ') {
            *self.left_out.entry("atoms that share their name").or_default() += 1;
            return;
        }
        let mut is_exact = true;
        for (index, &a) in atoms.iter().enumerate() {
            for &b in &atoms[index + 1..] {
                let [one, other] = [a, b].map(|atom| structure.atom_name(atom as usize).to_owned());
                if one == other {
                    continue; // alternatives of one atom
                }
                let want =
                    component.bonds.get(&(one.clone().min(other.clone()), one.clone().max(other.clone()))).copied();
                let got = of_pair.get(&(a, b)).copied();
                if want.is_none() && got.is_none() {
                    continue;
                }
                self.bonds += 1;
                if got.map(|bond| (bond.order.number(), bond.aromatic)) == want
                    && got.is_none_or(|bond| bond.kind == BondKind::Covalent)
                {
                    continue;
                }
                is_exact = false;
                match reason(structure, (a, b), want, got) {
                    Some(reason) => *self.reasons.entry(reason).or_default() += 1,
                    None => {
                        let at = residues[residue];
                        let place = format!("{}{}", structure.name(at.name), at.number);
                        self.wrong.push(format!("{file}: {place} {one}–{other}: want {want:?}, got {got:?}"));
                    }
                }
            }
        }
        self.exact += usize::from(is_exact);
    }
}

/// Why a bond is not what the dictionary says.
fn reason(
    structure: &Structure,
    (a, b): (u32, u32),
    want: Option<(u8, bool)>,
    got: Option<Bond>,
) -> Option<&'static str> {
    let elements = [a, b].map(|atom| structure.elements()[atom as usize]);
    let [one, other] = [a, b].map(|atom| structure.altloc(atom as usize));
    let at = |atom: u32| structure.positions().get(atom as usize);
    let length = at(a).distance(at(b)) as f32;
    let longest = elements[0].covalent_radius()
        + elements[1].covalent_radius()
        + LONGEST_EXCESS[usize::from(elements.contains(&Element::H))];
    Some(match () {
        () if got.is_some_and(|bond| matches!(bond.source, BondSource::File | BondSource::Link)) => {
            "the file states it"
        }
        () if got.is_some_and(|bond| bond.kind == BondKind::Coordination)
            && want == Some((1, false))
            && elements.iter().any(|element| element.is_metal()) =>
        {
            "coordination of a metal"
        }
        () if got.is_none() && one != other && one != b' ' && other != b' ' => "alternatives",
        () if got.is_none() && (length > longest || length < 0.4) => "a length that is none of a bond",
        () => return None,
    })
}

#[test]
fn residues_of_entries_have_the_bonds_of_the_dictionary() {
    let Some(dictionary) = dictionary() else {
        println!("SKIP: BALLSTICK_CCD names no component dictionary");
        return;
    };
    let mut counts = Counts::default();
    let mut files_read = 0;
    for path in files::molecules(MAX_BYTES) {
        let Ok(document) = read_path(&path, &ImportOptions::default()) else { continue };
        let structure = &document.records[0];
        if !matches!(document.format, Format::Pdb | Format::Mmcif | Format::BinaryCif)
            || structure.residues().is_empty()
        {
            continue;
        }
        files_read += 1;
        let before = counts.wrong.len();
        let bonds = bonds::find(structure, 0, &BondOptions::default());
        let of_pair: HashMap<(u32, u32), Bond> = (bonds.iter())
            .filter(|bond| !bond.is_periodic() && bond.kind != BondKind::Hydrogen)
            .map(|bond| ((bond.a, bond.b), *bond))
            .collect();
        for (index, residue) in structure.residues().iter().enumerate() {
            match dictionary.get(structure.name(residue.name)) {
                Some(component) => counts.residue(&files::name(&path), structure, &of_pair, index, component),
                None => *counts.left_out.entry("no component of that name").or_default() += 1,
            }
        }
        if counts.wrong.len() > before {
            println!("{}: {} differ", files::name(&path), counts.wrong.len() - before);
        }
    }
    println!(
        "{files_read} files, {} components: {} residues exactly theirs, {} bonds compared",
        dictionary.len(),
        counts.exact,
        counts.bonds
    );
    println!("with a reason: {:?}; left out: {:?}", counts.reasons, counts.left_out);
    assert!(files_read > 0 && counts.bonds > 1000, "nothing was compared");
    let shown = counts.wrong.len().min(60);
    assert!(counts.wrong.is_empty(), "{} differ\n{}", counts.wrong.len(), counts.wrong[..shown].join("\n"));
}

#[test]
fn names_of_force_fields_are_what_they_mean() {
    let mut text = String::new();
    let mut serial = 0;
    let mut push = |name: &str, residue: &str, number: i32, [x, y, z]: [f64; 3]| {
        serial += 1;
        let name = if name.len() < 4 { format!(" {name:<3}") } else { name.to_owned() };
        text.push_str(&format!(
            "ATOM  {serial:>5} {name} {residue:<4}A{number:>4}    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00\n"
        ));
    };
    let ring: [(&str, [f64; 3]); 6] = [
        ("CB", [-1.5, 0.0, 0.0]),
        ("CG", [0.0, 0.0, 0.0]),
        ("ND1", [0.81, 1.12, 0.0]),
        ("CD2", [0.85, -1.06, 0.0]),
        ("CE1", [2.07, 0.74, 0.0]),
        ("NE2", [2.12, -0.62, 0.0]),
    ];
    let mut number = 0;
    let mut next = || {
        number += 1;
        (number, 8.0 * f64::from(number))
    };
    for residue in ["HSD", "HSE", "HSP", "HID", "HIE", "HIP"] {
        let (number, z) = next();
        ring.iter().for_each(|&(name, [x, y, _])| push(name, residue, number, [x, y, z]));
    }
    for (residue, oxygen, hydrogens) in
        [("SOL", "OW", ["HW1", "HW2"]), ("TIP3", "OH2", ["H1", "H2"]), ("WAT", "O", ["H1", "H2"])]
    {
        let (number, z) = next();
        push(oxygen, residue, number, [0.0, 0.0, z]);
        push(hydrogens[0], residue, number, [0.757, 0.586, z]);
        push(hydrogens[1], residue, number, [-0.757, 0.586, z]);
    }
    let disulfide = [next(), next()];
    for (side, (number, z)) in [(-1.0, disulfide[0]), (1.0, (disulfide[1].0, disulfide[0].1))] {
        push("CB", "CYX", number, [2.4 * side, 1.0, z]);
        push("SG", "CYX", number, [1.02 * side, 0.0, z]);
    }
    let ions = [("SOD", "Na"), ("CLA", "Cl"), ("POT", "K"), ("CAL", "Ca"), ("CES", "Cs"), ("NA+", "Na"), ("CL-", "Cl")];
    for (name, _) in ions {
        let (number, z) = next();
        push(name, name, number, [0.0, 0.0, z]);
    }
    let document = ballstick::import::read_bytes(text.as_bytes(), "a.pdb", &ImportOptions::default()).unwrap();
    let molecule = bonds::assign(document.records[0].clone(), &BondOptions::default());
    let of_residue = |residue: usize| {
        let inside = |bond: &&Bond| molecule.residue_index(bond.a as usize) == Some(residue);
        molecule.bonds().iter().filter(inside).copied().collect::<Vec<Bond>>()
    };
    for residue in 0..6 {
        let ring = of_residue(residue);
        let count = |test: &dyn Fn(&Bond) -> bool| ring.iter().filter(|bond| test(bond)).count();
        assert_eq!((ring.len(), count(&|bond| bond.aromatic), count(&|bond| bond.order.number() == 2)), (6, 5, 2));
    }
    for residue in 6..9 {
        assert_eq!(of_residue(residue).len(), 2, "water");
    }
    assert_eq!((of_residue(9).len(), of_residue(10).len()), (2, 1), "two halves of a cystine, and what joins them");
    for (residue, (name, symbol)) in (11..).zip(ions) {
        let atom = molecule.residues()[residue].first_atom as usize;
        assert_eq!(molecule.elements()[atom].symbol(), symbol, "{name}");
        assert!(of_residue(residue).is_empty(), "{name}");
    }
}
