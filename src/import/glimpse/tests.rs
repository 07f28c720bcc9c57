use super::sample::{Bytes, MOST_ATOMS};
use super::*;
use glam::DVec3;
use proptest::prelude::*;
use std::fmt::Write;

impl Bytes for Vec<u8> {
    fn len(&self) -> u64 {
        Vec::len(self) as u64
    }

    fn read(&self, offset: u64, bytes: &mut [u8]) -> Option<()> {
        let start = usize::try_from(offset).ok()?;
        bytes.copy_from_slice(self.get(start..start.checked_add(bytes.len())?)?);
        Some(())
    }
}

/// Enough atoms that blocks are read and not the whole.
const MANY: usize = 420_000;

/// An atom of a box of 200 × 100 × 50 Å about (50, 0, −25) that is filled layer by layer, as files are.
fn place(index: usize, count: usize) -> [f64; 3] {
    let part = |steps: usize| (index.wrapping_mul(7919) % steps) as f64 / (steps - 1) as f64;
    [-50.0 + 200.0 * index as f64 / (count - 1) as f64, -50.0 + 100.0 * part(1009), -50.0 + 50.0 * part(499)]
}

fn symbol(index: usize) -> &'static str {
    ["C", "N", "O", "H"][index % 4]
}

fn xyz(count: usize, comment: &str) -> String {
    let mut text = format!("{count}\n{comment}\n");
    for index in 0..count {
        let [x, y, z] = place(index, count);
        writeln!(text, "{} {x:.4} {y:.4} {z:.4}", symbol(index)).unwrap();
    }
    text
}

fn pdb(count: usize) -> String {
    let mut text = String::new();
    for index in 0..count {
        let ([x, y, z], serial) = (place(index, count), (index + 1) % 100_000);
        let (symbol, residue) = (symbol(index), index / 8 % 10_000);
        writeln!(text, "ATOM  {serial:>5}  {symbol:<3} ALA A{residue:>4}    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00          {symbol:>2}  ")
            .unwrap();
    }
    text
}

const NAMES: [&str; 8] =
    ["group_PDB", "id", "type_symbol", "label_atom_id", "Cartn_x", "Cartn_y", "Cartn_z", "pdbx_PDB_model_num"];

fn mmcif_head() -> String {
    let names: String = NAMES.iter().map(|name| format!("_atom_site.{name}\n")).collect();
    format!("data_test\n#\n_entry.id test\nloop_\n_atom_type.symbol\nC\nN\n#\nloop_\n{names}")
}

fn rows(count: usize, model: u32) -> String {
    let mut text = String::new();
    for index in 0..count {
        let ([x, y, z], symbol) = (place(index, count), symbol(index));
        let name = if index % 5 == 0 { "\"O5'\"" } else { "'C 1'" };
        writeln!(text, "ATOM {} {symbol} {name} {x:.3} {y:.3} {z:.3} {model}", index + 1).unwrap();
    }
    text
}

fn gro(count: usize) -> String {
    let mut text = format!("water, t= 0.0\n{count:>7}\n");
    for index in 0..count {
        let [x, y, z] = place(index, count).map(|x| x / 10.0);
        let number = (index + 1) % 100_000;
        writeln!(text, "{:>5}SOL  {:>5}{number:>5}{x:8.3}{y:8.3}{z:8.3}", number / 3, ["OW", "HW1", "HW2"][index % 3])
            .unwrap();
    }
    text + "  20.0 10.0 5.0\n"
}

fn glimpse(text: &str, name: &str) -> Option<Glimpse> {
    Glimpse::of(&text.as_bytes().to_vec(), name, None)
}

/// It agrees with the box of `place`, and the number of atoms.
fn check(text: &str, name: &str, count: usize) {
    let glimpse = glimpse(text, name).unwrap_or_else(|| panic!("{name} has a glimpse"));
    let off = glimpse.about_atoms as f64 / count as f64 - 1.0;
    assert!(off.abs() < 0.01, "{name}: {} of {count}", glimpse.about_atoms);
    let atoms = glimpse.structure.atom_count();
    assert!(atoms <= MOST_ATOMS && atoms >= count.min(MOST_ATOMS / 3), "{name}: {atoms}");
    let points: Vec<DVec3> = (0..atoms).map(|atom| glimpse.structure.positions().get(atom)).collect();
    let least = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let most = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let (true_least, true_most) = (DVec3::new(-50.0, -50.0, -50.0), DVec3::new(150.0, 50.0, 0.0));
    let off = (least - true_least).abs().max((most - true_most).abs());
    assert!(off.max_element() < 1.0, "{name}: {least} {most}");
    let symbols: std::collections::BTreeSet<&str> =
        glimpse.structure.elements().iter().map(|element| element.symbol()).collect();
    let wanted: &[&str] = if name.ends_with("gro") { &["H", "O"] } else { &["C", "H", "N", "O"] };
    assert_eq!(symbols.into_iter().collect::<Vec<_>>(), wanted, "{name}");
    // The middle is about as dense as either end; its lines are shorter.
    let middle = points.iter().filter(|point| (0.0..100.0).contains(&point.x)).count();
    assert!((middle as f64 / atoms as f64 - 0.5).abs() < 0.05, "{name}: {middle} of {atoms}");
    assert!(glimpse.structure.bonds().is_empty());
}

#[test]
fn a_glimpse_has_the_bounds_of_its_file() {
    check(&xyz(MANY, ""), "a.xyz", MANY);
    check(&pdb(MANY), "a.pdb", MANY);
    check(&(mmcif_head() + &rows(MANY, 1)), "a.cif", MANY);
    check(&gro(MANY), "a.gro", MANY);
}

#[test]
fn line_ends_of_other_systems_are_no_matter() {
    let crlf = |text: String| text.replace('\n', "\r\n");
    check(&crlf(xyz(MANY, "")), "a.xyz", MANY);
    check(&crlf(pdb(MANY)), "a.pdb", MANY);
    check(&crlf(mmcif_head() + &rows(MANY, 1)), "a.cif", MANY);
    check(&crlf(gro(MANY)), "a.gro", MANY);
}

#[test]
fn a_small_first_frame_is_read_whole() {
    let small = 1200;
    for frames in [2, 400] {
        check(&xyz(small, "").repeat(frames), "a.xyz", small);
        check(&gro(small).repeat(frames), "a.gro", small);
    }
    let glimpse = glimpse(&xyz(small, "").repeat(400), "a.xyz").unwrap();
    assert_eq!((glimpse.structure.atom_count(), glimpse.about_atoms), (small, small as u64));
}

#[test]
fn of_large_frames_the_first_counts() {
    let far = |text: String| text.replace("C ", "C 9");
    let two = xyz(MANY, "") + &far(xyz(MANY, ""));
    check(&two, "a.xyz", MANY);
    check(&(gro(MANY) + &gro(MANY)), "a.gro", MANY);
    // One frame more that is much smaller: it cannot be told from a frame that is cut.
    assert!(glimpse(&(xyz(MANY, "") + &xyz(MANY / 5, "")), "a.xyz").is_none());
}

#[test]
fn columns_of_extended_xyz_are_kept() {
    let comment = r#"Lattice="200 0 0 0 100 0 0 0 50" Properties=id:I:1:species:S:1:pos:R:3"#;
    let text = xyz(MANY, comment);
    let (head, body) = text.split_at(text.find(comment).unwrap() + comment.len() + 1);
    let body: String = body.lines().enumerate().map(|(index, line)| format!("{index} {line}\n")).collect();
    let text = head.to_owned() + &body;
    check(&text, "a.xyz", MANY);
    assert!(glimpse(&text, "a.xyz").unwrap().structure.cell().is_some());
}

#[test]
fn of_models_the_first_counts() {
    let model = |number: u32, text: &str| format!("MODEL     {number:>4}\n{text}ENDMDL\n");
    let moved = pdb(MANY).replace("A  10    ", "A  10   9");
    let header = "HEADER    TEST\nREMARK   2 A remark\n".to_owned();
    let text = header.clone() + &model(1, &pdb(MANY)) + &model(2, &moved) + "END\n";
    check(&text, "a.pdb", MANY);
    check(&(header + &model(1, &pdb(5000)).repeat(50) + "END\n"), "a.pdb", 5000);
    check(&(pdb(MANY) + "END\n" + &pdb(MANY)), "a.pdb", MANY);
    let two = mmcif_head() + &rows(MANY, 1) + &rows(MANY, 2).replace(" 2\n", "0 2\n");
    check(&two, "a.cif", MANY);
    check(&(mmcif_head() + &rows(4000, 1) + &rows(4000, 2)), "a.cif", 4000);
}

#[test]
fn what_follows_the_atoms_is_none() {
    let conect: String = (0..200_000).map(|index| format!("CONECT{:>5}{:>5}\n", index % 99_999, 1)).collect();
    check(&(pdb(MANY) + &conect + "END\n"), "a.pdb", MANY);
    check(&(pdb(MANY) + &conect), "a.pdb", MANY);
    let aniso: String = (0..MANY).map(|index| format!("{index} C 900.1 900.2 900.3 900.4 900.5\n")).collect();
    let more = "#\nloop_\n_atom_site_anisotrop.id\n_atom_site_anisotrop.type_symbol\n_atom_site_anisotrop.u\n";
    check(&(mmcif_head() + &rows(MANY, 1) + more + &aniso), "a.cif", MANY);
    let field: String =
        (0..MANY).map(|index| format!("this is line {index} of a text, and it is no row of atoms\n")).collect();
    let text = format!("{}{}#\n_citation.abstract\n;{field};\n", mmcif_head(), rows(MANY, 1));
    check(&text, "a.cif", MANY);
    // Before the atoms a text that looks like names.
    let prose = "data_test\n_citation.abstract\n;\nloop_\n_atom_site.id\nis how it begins\n;\n";
    let glimpse = glimpse(&(prose.to_owned() + &mmcif_head()[9..] + &rows(MANY, 1)), "a.cif");
    assert!(glimpse.is_none());
}

#[test]
fn rows_over_several_lines_are_passed_over() {
    let odd = "ATOM 0 C\n;C1\n;\n900.0 900.0\n900.0 1\n";
    let text: String = rows(MANY, 1).lines().enumerate().fold(mmcif_head(), |mut text, (index, line)| {
        if index % 50 == 25 {
            text += odd;
        }
        text += line;
        text.push('\n');
        text
    });
    check(&text, "a.cif", MANY);
}

#[test]
fn on_doubt_there_is_none() {
    for (name, text) in
        [("a.xyz", xyz(MANY, "")), ("a.gro", gro(MANY)), ("a.pdb", pdb(MANY)), ("a.cif", mmcif_head() + &rows(MANY, 1))]
    {
        let half = &text[..text.len() / 2];
        // Formats that state their number of atoms have too few.
        let is_there = glimpse(half, name).is_some();
        assert_eq!(is_there, matches!(name, "a.pdb" | "a.cif"), "{name}");
        for end in [0, 1, 10, 60, 300] {
            let _ = glimpse(&text[..end], name);
        }
        assert!(glimpse(&("\u{feff}".to_owned() + &text), name).is_none(), "{name}");
        let utf16: Vec<u8> = text[..200_000].encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert!(Glimpse::of(&utf16, name, None).is_none());
    }
    // A line among many that is no atom.
    let text = xyz(MANY, "");
    let broken: String = text
        .lines()
        .map(|line| if line.len() > 3 { format!("{} abc\n", &line[..5]) } else { format!("{line}\n") })
        .collect();
    assert!(glimpse(&broken, "a.xyz").is_none());
    for (name, text) in
        [("a.sdf", "\n\n\n  0  0  0  0  0  0  0  0  0  0999 V2000\nM  END\n"), ("a.json", "{}\n"), ("a.xyz", "0\n\n")]
    {
        assert!(glimpse(text, name).is_none(), "{name}");
    }
}

#[test]
fn late_is_never() {
    let past = Some(Instant::now() - Duration::from_secs(1));
    assert!(Glimpse::of(&xyz(MANY, "").into_bytes(), "a.xyz", past).is_none());
    assert!(Glimpse::of(&pdb(MANY).into_bytes(), "a.pdb", past).is_none());
}

#[test]
fn small_files_pipes_and_nothing_have_none() {
    let path = std::env::temp_dir().join(format!("ballstick-glimpse-{}.xyz", std::process::id()));
    std::fs::write(&path, xyz(1000, "")).unwrap();
    assert!(Glimpse::of_file(&path).is_none());
    std::fs::write(&path, xyz(600_000, "")).unwrap();
    let glimpse = Glimpse::of_file(&path);
    std::fs::remove_file(&path).unwrap();
    // Where the machine is busy, it may be late.
    assert!(glimpse.is_none_or(|glimpse| glimpse.about_atoms == 600_000));
    for path in ["-", "/dev/zero", "/no/such/file", "/"] {
        assert!(Glimpse::of_file(Path::new(path)).is_none());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn bytes_of_any_kind_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..3000), which in 0usize..5) {
        let before = ["3\n\n", "t\n5\n", "ATOM      1  N   ALA A   1      11.104   6.134  -6.504\n", "data_x\nloop_\n_atom_site.Cartn_x\n", ""][which];
        let name = ["a.xyz", "a.gro", "a.pdb", "a.cif", "a"][which];
        let _ = Glimpse::of(&[before.as_bytes(), &bytes].concat(), name, None);
    }

    #[test]
    fn damaged_files_never_panic(which in 0usize..4, cut in 0usize..4000, edits in proptest::collection::vec((0usize..4000, any::<u8>()), 0..20)) {
        let text = [xyz(80, ""), gro(60), pdb(50), mmcif_head() + &rows(60, 1)][which].clone();
        let mut bytes = text.into_bytes();
        for (at, byte) in edits {
            if let Some(slot) = bytes.get_mut(at) {
                *slot = byte;
            }
        }
        bytes.truncate(cut.max(1));
        if let Some(glimpse) = Glimpse::of(&bytes, ["a.xyz", "a.gro", "a.pdb", "a.cif"][which], None) {
            prop_assert!(glimpse.structure.atom_count() <= 1000);
        }
    }
}
