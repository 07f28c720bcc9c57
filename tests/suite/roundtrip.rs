//! What a writer writes, its reader reads back: for every structure format and every molecule in `data/` and the corpus.
//!
//! A structure is compared part by part: every [`Part`] that the format says it holds must come back, and of every
//! other part `losses` must have spoken. What a format rounds is compared to its digits.

use crate::files;
use ballstick::bonds::{self, BondOptions};
use ballstick::element::Element;
use ballstick::export::formats::{FORMATS, Part, StructureFormat};
use ballstick::import::{Format, ImportOptions, read_bytes, read_path};
use ballstick::structure::{Bond, BondKind, BondOrder, Frame, StatedBonds, Structure, SymmetryOperation, atom_flags};
use std::collections::{BTreeMap, BTreeSet};

/// Files over this size are left out: every one is written and read eight times.
const MAX_BYTES: u64 = 3 << 20;

/// The reader of a writer's files.
fn reader(format: &StructureFormat) -> Format {
    match format.name {
        "sdf-v3000" => Format::Sdf,
        "extxyz" => Format::Xyz,
        name => Format::from_name(name).unwrap_or_else(|| panic!("{name} is written but not read")),
    }
}

#[test]
fn what_is_written_is_read_back() {
    let mut wrong = Vec::new();
    let (mut files, mut compared) = (0, BTreeMap::new());
    for path in files::molecules(MAX_BYTES) {
        let Ok(document) = read_path(&path, &ImportOptions::default()) else { continue };
        // Of many records a few will do, and of many frames.
        let mut records = document.records;
        records.truncate(8);
        if records.iter().map(Structure::atom_count).sum::<usize>() > 60_000 {
            continue;
        }
        let options = BondOptions::default();
        let records: Vec<Structure> = records.into_iter().map(|record| bonds::assign(record, &options)).collect();
        files += 1;
        // mmCIF says its bonds by residue names and leaves links to the reader: `mmcif` compares it.
        for format in FORMATS.iter().filter(|format| format.name != "mmcif") {
            let name = format!("{} as {}", files::name(&path), format.name);
            let mut bytes = Vec::new();
            if let Err(error) = (format.write)(&records, &mut bytes) {
                assert!(error.to_string().contains("does not fit"), "{name}: {error}");
                continue;
            }
            *compared.entry(format.name).or_insert(0) += 1;
            let options = ImportOptions { format: Some(reader(format)), ..ImportOptions::default() };
            match read_bytes(&bytes, "", &options) {
                Err(error) => wrong.push(format!("{name}: {error}")),
                Ok(back) => {
                    let back: Vec<&Structure> = back.records.iter().collect();
                    for difference in differences(format, &records, &back) {
                        wrong.push(format!("{name}: {difference}"));
                    }
                }
            }
        }
    }
    println!("{files} files; compared {compared:?}");
    assert!(files > 10 && compared.len() + 1 == FORMATS.len(), "too little was compared: {files}, {compared:?}");
    assert!(wrong.is_empty(), "{} differences\n{}", wrong.len(), wrong[..wrong.len().min(60)].join("\n"));
}

/// All frames with the record each belongs to.
fn frames<'a>(records: impl IntoIterator<Item = &'a Structure>) -> Vec<(&'a Structure, &'a Frame)> {
    records.into_iter().flat_map(|record| record.frames().iter().map(move |frame| (record, frame))).collect()
}

fn differences(format: &StructureFormat, records: &[Structure], back: &[&Structure]) -> Vec<String> {
    let mut wrong = Vec::new();
    let written = if format.all_frames { records } else { &records[..1] };
    let mut wanted = frames(written);
    if !format.all_frames && !format.holds.contains(&Part::Frames) {
        wanted.truncate(1);
    }
    let found = frames(back.iter().copied());
    if wanted.len() != found.len() {
        return vec![format!("{} frames, want {}", found.len(), wanted.len())];
    }
    for (index, ((record, frame), (other, other_frame))) in wanted.iter().zip(&found).enumerate() {
        let first = std::ptr::eq(*frame, &record.frames()[0]);
        if record.atom_count() != other.atom_count() || record.elements() != other.elements() {
            wrong.push(format!("frame {index}: other elements"));
            continue;
        }
        compare_positions(format, frame, other_frame, index, &mut wrong);
        for part in format.holds {
            // What is said of a record is said with its first frame, but for formats whose frames are records.
            let ok = match part {
                Part::Cell if !first && !format.holds.contains(&Part::FrameCells) => true,
                Part::Title if !first || (index > 0 && !format.holds.contains(&Part::FrameTitles)) => true,
                _ if !first && record.frames().len() > 1 && !matches!(part, Part::Cell | Part::FrameTitles) => true,
                _ => same(*part, format, record, frame, other, other_frame),
            };
            if !ok {
                wrong.push(format!("frame {index}: {part:?}"));
            }
        }
    }
    wrong
}

fn compare_positions(format: &StructureFormat, want: &Frame, got: &Frame, index: usize, wrong: &mut Vec<String>) {
    let decimals = match format.name {
        "pdb" => 3,
        "sdf" => 4,
        _ => u8::MAX,
    };
    let tolerance = if want.positions.decimals() > decimals { 0.51 * 10f64.powi(-i32::from(decimals)) } else { 0.0 };
    let differs = (0..want.positions.len())
        .find(|&atom| (want.positions.written(atom) - got.positions.written(atom)).abs().max_element() > tolerance);
    if let Some(atom) = differs {
        let (want, got) = (want.positions.written(atom), got.positions.written(atom));
        wrong.push(format!("frame {index}: atom {atom} at {got}, want {want}"));
    }
}

fn squeezed(text: &str) -> String {
    text.split(|c: char| c.is_whitespace() || c.is_control())
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

fn title<'a>(structure: &'a Structure, frame: &'a Frame) -> &'a str {
    if structure.title().is_empty() { &frame.title } else { structure.title() }
}

/// Whether a part came back.
fn same(part: Part, format: &StructureFormat, a: &Structure, a_frame: &Frame, b: &Structure, b_frame: &Frame) -> bool {
    let atoms = 0..a.atom_count();
    let all = |test: &dyn Fn(usize) -> bool| atoms.clone().all(test);
    let limited = !(format.limits)(a).is_empty();
    let near = |a: f32, b: f32| (a - b).abs() <= if format.name == "pdb" { 0.0051 } else { 0.0 };
    match part {
        Part::Title => {
            // Records of the same atoms come back as frames of one in formats without records.
            let found = if b_frame.title.is_empty() { b.title() } else { &b_frame.title };
            squeezed(title(a, a_frame)) == squeezed(found)
        }
        Part::FrameTitles => {
            // Frames without any title of their own carry the structure's.
            let own = a.frames().iter().any(|frame| !frame.title.is_empty());
            !own || squeezed(&a_frame.title)
                == squeezed(if b_frame.title.is_empty() { b.title() } else { &b_frame.title })
        }
        Part::Frames => true, // their number was compared
        Part::Bonds => same_bonds(format, a, b),
        Part::CoordinationBonds => limited || kinds(a, BondKind::Coordination) == kinds(b, BondKind::Coordination),
        Part::DativeBonds => kinds(a, BondKind::Dative) == kinds(b, BondKind::Dative),
        Part::HydrogenBonds => kinds(a, BondKind::Hydrogen) == kinds(b, BondKind::Hydrogen),
        Part::PeriodicBonds => {
            let periodic =
                |s: &Structure| -> Vec<Bond> { s.bonds().iter().copied().filter(Bond::is_periodic).collect() };
            periodic(a) == periodic(b)
        }
        Part::BondStereo => {
            let marks = |s: &Structure| -> BTreeSet<(u32, u32, u32, String)> {
                let of = |mark: &ballstick::structure::StereoMark| {
                    let bond = s.bonds()[mark.bond as usize];
                    (bond.a, bond.b, mark.from, format!("{:?}", mark.stereo))
                };
                s.bond_stereo().iter().map(of).collect()
            };
            marks(a) == marks(b)
        }
        Part::Cell | Part::FrameCells => match (&a_frame.cell, &b_frame.cell) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                let tolerance = if format.name == "pdb" { 0.0051 } else { 1e-7 };
                let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance);
                close(a.lengths(), b.lengths()) && close(a.angles_deg(), b.angles_deg())
            }
            _ => false,
        },
        Part::SpaceGroup => {
            let group = |s: &Structure| s.symmetry().map(|symmetry| symmetry.space_group.clone());
            a.cell().is_none() || group(a).unwrap_or_default() == group(b).unwrap_or_default()
        }
        Part::SymmetryOperations => {
            let of = |s: &Structure| s.symmetry().map(|symmetry| symmetry.operations.clone()).unwrap_or_default();
            let (want, got) = (of(a), of(b));
            let tolerance = if format.name == "pdb" { 1e-3 } else { 0.0 };
            let same = |(a, b): (&SymmetryOperation, &SymmetryOperation)| {
                a.rotation == b.rotation && a.translation.abs_diff_eq(b.translation, tolerance)
            };
            a.cell().is_none() || (want.len() == got.len() && want.iter().zip(&got).all(same))
        }
        Part::Assemblies => {
            // Atoms with as many copies each; a few of them by the same motions.
            let of = |s: &Structure| -> Vec<(String, Vec<usize>)> {
                let copies = |one: &ballstick::structure::Assembly| {
                    let (sets, set_of) = one.sets(s.atom_count());
                    let each = set_of.iter().map(|&set| sets.get(set as usize).map_or(0, Vec::len)).collect();
                    (one.id.clone(), each)
                };
                s.assemblies().iter().map(copies).collect()
            };
            let operations = |s: &Structure| s.assemblies().iter().flat_map(|one| one.operations.clone()).collect();
            let (want, got): (Vec<glam::DAffine3>, Vec<glam::DAffine3>) = (operations(a), operations(b));
            let near = want.len() == got.len() && want.iter().zip(&got).all(|(a, b)| a.abs_diff_eq(*b, 1e-5));
            limited || (of(a) == of(b) && near)
        }
        Part::Components => a.components() == b.components(),
        Part::AtomNames => all(&|i| {
            let want = a.atom_name(i);
            let cut = format.name == "pdb" && want.len() > 4;
            want.is_empty() || cut || squeezed(want).replace(' ', "_") == squeezed(b.atom_name(i)).replace(' ', "_")
        }),
        Part::Serials => limited || !Part::Serials.is_in(a) || all(&|i| a.serial(i) == b.serial(i)),
        Part::Residues => a.residues().is_empty() || limited || all(&|i| residue(a, i) == residue(b, i)),
        Part::AtomKinds => {
            a.residues().is_empty() || all(&|i| a.flags(i) & atom_flags::HETERO == b.flags(i) & atom_flags::HETERO)
        }
        Part::Particles => all(&|i| {
            let particle = |s: &Structure| s.flags(i) & atom_flags::PARTICLE != 0;
            // What has no element and is no particle is one in formats that have no other word for it.
            particle(a) == particle(b) || (format.name != "json" && a.elements()[i] == Element::DUMMY && particle(b))
        }),
        Part::Altlocs => all(&|i| a.altloc(i) == b.altloc(i)),
        Part::Occupancies => all(&|i| near(a.occupancy(i), b.occupancy(i))),
        Part::BFactors => all(&|i| near(a.b_factor(i), b.b_factor(i))),
        Part::FormalCharges => all(&|i| a.formal_charge(i) == b.formal_charge(i)),
        Part::PartialCharges => all(&|i| a.partial_charge(i) == b.partial_charge(i)),
        Part::HydrogenIsotopes | Part::Isotopes => all(&|i| {
            (part == Part::HydrogenIsotopes) != (a.elements()[i] == Element::H) || a.isotope(i) == b.isotope(i)
        }),
        Part::Radicals => all(&|i| a.radical(i) == b.radical(i)),
        Part::Secondary => a.secondary() == b.secondary(),
        Part::Vectors => {
            a.vectors().len() == b.vectors().len()
                && a.vectors().iter().zip(b.vectors()).all(|(a, b)| a.vectors == b.vectors)
        }
        Part::Properties => a.properties().iter().all(|(name, value)| {
            let squeeze = |value: &str| {
                value.lines().map(str::trim_end).filter(|l| !l.trim().is_empty()).collect::<Vec<_>>().join("\n")
            };
            b.properties()
                .iter()
                .any(|(other, found)| squeezed(other) == squeezed(name) && squeeze(found) == squeeze(value))
        }),
    }
}

fn residue(s: &Structure, atom: usize) -> Option<(String, i32, u8, String)> {
    let residue = s.residues()[s.residue_index(atom)?];
    let name = match s.name(residue.name) {
        "" => "UNL",
        name => name,
    };
    let chain = s.chains().nth(residue.chain as usize).unwrap_or_default();
    Some((chain.to_owned(), residue.number, residue.insertion_code, name.to_owned()))
}

fn kinds(s: &Structure, kind: BondKind) -> BTreeSet<(u32, u32)> {
    let is_kind = |bond: &&Bond| bond.kind == kind && !bond.is_periodic();
    s.bonds().iter().filter(is_kind).map(|bond| (bond.a, bond.b)).collect()
}

/// Bonds other than hydrogen bonds and those to images, by their atoms.
fn by_atoms(s: &Structure) -> BTreeMap<(u32, u32), Bond> {
    let listed = |bond: &&Bond| !bond.is_periodic() && bond.kind != BondKind::Hydrogen;
    s.bonds().iter().filter(listed).map(|bond| ((bond.a, bond.b), *bond)).collect()
}

fn same_bonds(format: &StructureFormat, a: &Structure, b: &Structure) -> bool {
    let (want, got) = (by_atoms(a), by_atoms(b));
    if format.name == "pdb" {
        // CONECT says some of them, the residues' names the others.
        let listed = got.iter().all(|(pair, bond)| want.get(pair).is_some_and(|want| same_order(format, want, bond)));
        let hetero =
            |atom: u32| a.residue_index(atom as usize).is_none() || a.flags(atom as usize) & atom_flags::HETERO != 0;
        let said = |(first, second): (u32, u32)| got.contains_key(&(first, second)) || is_water(a, first);
        return listed
            && want.keys().all(|&(first, second)| !(hetero(first) || hetero(second)) || said((first, second)));
    }
    b.stated_bonds() == StatedBonds::Complete
        && want.len() == got.len()
        && want.iter().all(|(pair, want)| got.get(pair).is_some_and(|got| same_order(format, want, got)))
}

fn is_water(s: &Structure, atom: u32) -> bool {
    let name = s.residue_index(atom as usize).map(|index| s.name(s.residues()[index].name));
    name.is_some_and(|name| matches!(name, "HOH" | "DOD" | "WAT"))
}

/// Whether an order came back, where the format has a word for it.
fn same_order(format: &StructureFormat, want: &Bond, got: &Bond) -> bool {
    if want.kind != BondKind::Covalent {
        return true; // the kind is another part, and has no order
    }
    if format.name == "pdb" && got.kind == BondKind::Coordination {
        return true; // named as a limit
    }
    match (format.name, want.aromatic, want.order) {
        ("json", ..) => (want.order, want.aromatic) == (got.order, got.aromatic),
        ("mol2", true, _) => got.aromatic,
        ("pdb", _, BondOrder::Unknown) => got.order == BondOrder::Single,
        (_, true, BondOrder::Unknown) => got.aromatic,
        ("sdf" | "sdf-v3000", _, BondOrder::Quadruple) => got.order == BondOrder::Unknown,
        (_, _, order) => got.order == order,
    }
}
