use crate::element::Element;
use crate::error::Result;
use crate::import::collect::Records;
use crate::import::{Document, Format, ImportOptions, Limits, read_bytes};
use crate::structure::{BondKind, BondOrder, BondSource, Diagnostics, Severity, StatedBonds, Structure, atom_flags};
use proptest::prelude::*;

fn read(text: &str) -> Result<Document> {
    read_bytes(text.as_bytes(), "a.pdb", &ImportOptions { format: Some(Format::Pdb), ..ImportOptions::default() })
}

/// Reads in chunks of so many bytes, by so many threads.
fn in_chunks(text: &str, bytes: usize, threads: usize, limits: &Limits) -> Result<Document, String> {
    let mut diagnostics = Diagnostics::default();
    let mut records = Records::new(limits, &crate::stop::Stop::never());
    super::read_in_chunks(text.as_bytes(), bytes, threads, &mut records, &mut diagnostics)
        .and_then(|()| records.finish(Format::Pdb, diagnostics))
        .map_err(|error| error.to_string())
}

/// An atom line; `head` is columns 1 to 30.
fn atom(head: &str, x: f64, tail: &str) -> String {
    format!("{head:<30}{x:8.3}{:8.3}{:8.3}{tail}\n", 0.0, 0.0)
}

fn carbon(serial: &str, x: f64) -> String {
    atom(&format!("HETATM{serial:>5}  C1  LIG A   1"), x, "  1.00  0.00           C  ")
}

fn one(text: &str) -> Structure {
    let document = read(text).unwrap();
    assert_eq!(document.records.len(), 1);
    document.records[0].clone()
}

#[test]
fn a_full_line_is_read_to_its_end() {
    let line = "HETATM 1234 FE  BHEM C-142A    -12.345   6.700-100.001  0.50 37.25          FE3+\r\n";
    let molecule = one(line);
    assert_eq!(molecule.elements(), [Element::from_z(26).unwrap()]);
    assert_eq!((molecule.atom_name(0), molecule.altloc(0), molecule.serial(0)), ("FE", b'B', 1234));
    let residue = molecule.residues()[0];
    assert_eq!((molecule.name(residue.name), residue.number, residue.insertion_code), ("HEM", -142, b'A'));
    assert_eq!(molecule.chains().collect::<Vec<_>>(), ["C"]);
    assert_eq!(molecule.positions().written(0).to_array(), [-12.345, 6.7, -100.001]);
    assert_eq!((molecule.occupancy(0), molecule.b_factor(0), molecule.formal_charge(0)), (0.5, 37.25, 3));
    assert_eq!(molecule.flags(0), atom_flags::HETERO);
    assert_eq!(molecule.positions().decimals(), 3);
}

#[test]
fn short_lines_are_enough_with_coordinates() {
    let molecule = one("ATOM      1  CA  GLY A   1      11.104   6.134  -6.504");
    assert_eq!((molecule.occupancy(0), molecule.elements()[0]), (1.0, Element::C));
    assert!(read("ATOM      1  CA  GLY A   1      11.1\n").is_err());
}

#[test]
fn atoms_without_a_position_are_left_out_alone() {
    let bad = "ATOM      2  CA  GLY A   1         nan     inf********  1.00  0.00           C  \n";
    let document = read(&format!("{}{bad}{}", carbon("1", 0.0), carbon("3", 1.0))).unwrap();
    assert_eq!(document.records[0].atom_count(), 2);
    assert_eq!((document.diagnostics[0].severity, document.diagnostics[0].line), (Severity::Error, Some(2)));
}

#[test]
fn models_with_the_same_atoms_are_frames() {
    let model = |n: u32, x: f64| format!("MODEL     {n:4}\n{}{}ENDMDL\n", carbon("1", x), carbon("2", x + 1.0));
    let document =
        read(&format!("TITLE     TWO\nTITLE    2 LINES\n{}{}CONECT    1    2\nEND\n", model(1, 0.0), model(2, 5.0)))
            .unwrap();
    assert_eq!((document.records.len(), document.frame_count()), (1, 2));
    let molecule = &document.records[0];
    assert_eq!(molecule.title(), "TWO LINES");
    assert_eq!(molecule.frames()[1].positions.get(0).x, 5.0);
    assert_eq!(molecule.bonds().len(), 1);
    // ENDMDL alone, or END alone, separates as well.
    for end in ["ENDMDL\n", "END\n"] {
        let text = format!("{}{end}{}{end}", carbon("1", 0.0), carbon("1", 1.0));
        assert_eq!(read(&text).unwrap().frame_count(), 2, "{end}");
    }
    let other = format!("{}{}", model(1, 0.0), carbon("1", 0.0));
    assert_eq!(read(&other).unwrap().records.len(), 2);
}

#[test]
fn conect_repeated_one_way_is_an_order() {
    let atoms: String = (1..=4).map(|n| carbon(&n.to_string(), f64::from(n))).collect();
    let orders = |conect: &str| -> Vec<(u32, u32, BondOrder)> {
        let molecule = one(&format!("{atoms}{conect}"));
        assert_eq!(molecule.stated_bonds(), StatedBonds::Partial);
        molecule.bonds().iter().map(|bond| (bond.a, bond.b, bond.order)).collect()
    };
    assert_eq!(orders("CONECT    1    2\nCONECT    2    1\n"), [(0, 1, BondOrder::Single)]);
    assert_eq!(
        orders("CONECT    1    2    2\nCONECT    2    1    1    3\nCONECT    3    2    4    4    4\n"),
        [(0, 1, BondOrder::Double), (1, 2, BondOrder::Single), (2, 3, BondOrder::Triple)]
    );
    assert_eq!(one(&atoms).stated_bonds(), StatedBonds::None);
}

#[test]
fn conect_to_nothing_is_warned_of() {
    let document =
        read(&format!("{}CONECT    1   99\nCONECT    1   **\nCONECT    1    1\n", carbon("1", 0.0))).unwrap();
    assert!(document.records[0].bonds().is_empty());
    let lines: Vec<_> = document.diagnostics.iter().map(|d| d.line).collect();
    assert_eq!(lines, [Some(2), Some(3)]);
}

#[test]
fn shared_serials_bond_near_atoms() {
    let text: String = [("1", 0.0), ("2", 1.2), ("1", 50.0), ("2", 51.2)].map(|(n, x)| carbon(n, x)).concat();
    let molecule = one(&format!("{text}CONECT    1    2\nCONECT    1    2\nCONECT    2    1\n"));
    let pairs: Vec<_> = molecule.bonds().iter().map(|bond| (bond.a, bond.b, bond.order)).collect();
    assert_eq!(pairs, [(0, 1, BondOrder::Single), (2, 3, BondOrder::Single)]);
}

#[test]
fn overflowed_serials_are_followed() {
    let hybrid: String = [("99999", 0.0), ("A0000", 1.0)].map(|(n, x)| carbon(n, x)).concat();
    let molecule = one(&format!("{hybrid}CONECT99999A0000\n"));
    assert_eq!((molecule.serial(1), molecule.bonds().len()), (100_000, 1));
    let hexadecimal: String = [("99999", 0.0), ("186a0", 1.0)].map(|(n, x)| carbon(n, x)).concat();
    let molecule = one(&format!("{hexadecimal}CONECT99999186a0\n"));
    assert_eq!((molecule.serial(1), molecule.bonds().len()), (100_000, 1));
    let stars: String = [("99999", 0.0), ("*****", 1.0)].map(|(n, x)| carbon(n, x)).concat();
    assert_eq!(one(&stars).serial(1), 100_000);
    let wide = "ATOM  1234567 C1  LIG A   1       0.000   0.000   0.000\n";
    assert_eq!(one(&wide.replace("  1234567", "1234567 ")).serial(0), 1_234_567);
}

#[test]
fn links_find_their_atoms_by_name() {
    let metal = atom("HETATM    1 ZN    ZN A 201", 0.0, "  1.00  0.00          ZN  ");
    let text = format!(
        "SSBOND   1 CYS A    3    CYS A   40                          1555   1555  2.03  \n\
         LINK         NE2 HIS A  87                ZN    ZN A 201     1555   1555  2.14  \n\
         LINK         NE2 HIS A  87                ZN    ZN A 201     1555   2555  2.14  \n\
         LINK         NE2 HIS A  87                ZN    ZN A 999     1555   1555  2.14  \n\
         {metal}{}{}{}",
        atom("ATOM      2  NE2 HIS A  87", 2.0, "  1.00  0.00           N  "),
        atom("ATOM      3  SG  CYS A   3", 9.0, "  1.00  0.00           S  "),
        atom("ATOM      4  SG  CYS A  40", 11.0, "  1.00  0.00           S  "),
    );
    let document = read(&text).unwrap();
    let bonds = document.records[0].bonds();
    assert_eq!(bonds.len(), 2);
    assert_eq!((bonds[0].kind, bonds[0].source), (BondKind::Coordination, BondSource::Link));
    assert_eq!((bonds[1].a, bonds[1].b, bonds[1].order), (2, 3, BondOrder::Single));
    assert_eq!(document.diagnostics.len(), 2, "{:?}", document.diagnostics);
}

#[test]
fn placeholder_cells_are_no_cells() {
    let cell = |lengths: [f64; 3]| {
        let [a, b, c] = lengths;
        let line = format!("CRYST1{a:9.3}{b:9.3}{c:9.3}  90.00  99.34  90.00 P 1           1\n");
        one(&format!("{line}{}", carbon("1", 0.0))).cell().map(|cell| cell.lengths())
    };
    assert_eq!(cell([1.0; 3]), None);
    assert_eq!(cell([0.0; 3]), None);
    let got = cell([63.15, 83.59, 53.8]).unwrap();
    assert!((got[2] - 53.8).abs() < 1e-9);
}

#[test]
fn the_element_column_is_believed_where_it_can_be() {
    let symbol = |name: &str, residue: &str, column: &str| {
        let text =
            atom(&format!("ATOM      1 {name}{residue:>4} A   1"), 0.0, &format!("  1.00  0.00          {column}"));
        let document = read(&text).unwrap();
        (document.records[0].elements()[0].symbol(), document.diagnostics.len())
    };
    assert_eq!(symbol(" CA ", "ALA", " C"), ("C", 0));
    assert_eq!(symbol(" CA ", "ALA", "C "), ("C", 0));
    assert_eq!(symbol(" CA ", "ALA", "CA"), ("C", 1));
    assert_eq!(symbol("CA  ", " CA", "CA"), ("Ca", 0));
    assert_eq!(symbol(" CA ", "ALA", "  "), ("C", 1));
    assert_eq!(symbol(" CG ", "PHE", " A"), ("C", 1));
    assert_eq!(symbol(" X1 ", "LIG", " A"), ("X", 2));
    assert_eq!(symbol(" CA ", "ALA", "12"), ("C", 1));
}

#[test]
fn charges_in_all_their_spellings() {
    for (text, want) in
        [("2+", 2), ("1-", -1), ("+2", 2), ("-1", -1), ("+ ", 1), (" -", -1), ("  ", 0), ("12", 0), ("", 0)]
    {
        assert_eq!(super::fields::charge(text.as_bytes()), want, "{text:?}");
    }
}

#[test]
fn numbers_and_names_may_run_over_their_columns() {
    let molecule = one(&atom("ATOM      1  CL   CL A24245", 0.0, ""));
    assert_eq!(molecule.residues()[0].number, 24245);
    let molecule = one(&atom("ATOM      1  OH2 TIP3 2391", 0.0, ""));
    assert_eq!(molecule.name(molecule.residues()[0].name), "TIP3");
    let molecule = one(&atom("ATOM      1  CA  ALAAB   1", 0.0, ""));
    assert_eq!(molecule.chains().collect::<Vec<_>>(), ["AB"]);
}

#[test]
fn secondary_structure_is_kept() {
    let text = format!(
        "HELIX    1   1 SER A    4  GLY A   18A 1                                  15\n\
         SHEET    1   A 2 THR B 107  ARG B 110  0\n{}",
        carbon("1", 0.0)
    );
    let molecule = one(&text);
    let [helix, strand] = molecule.secondary() else { panic!("two elements expected") };
    assert!(helix.helix && helix.chain == "A" && (helix.first, helix.last) == ((4, b' '), (18, b'A')));
    assert!(!strand.helix && strand.chain == "B" && (strand.first.0, strand.last.0) == (107, 110));
}

#[test]
fn entries_one_after_another_keep_their_own_headers() {
    let entry = |title: &str, conect: &str| {
        format!("HEADER    X\nTITLE     {title}\n{}{}{conect}END\n", carbon("1", 0.0), carbon("2", 1.0))
    };
    let document =
        read(&format!("{}{}", entry("ONE", "CONECT    1    2\n"), entry("TWO", "").replace(" C1 ", " C9 "))).unwrap();
    let titles: Vec<_> = document.records.iter().map(Structure::title).collect();
    assert_eq!(titles, ["ONE", "TWO"]);
    assert_eq!(document.records[1].stated_bonds(), StatedBonds::None);
}

/// Lines of which files may be made in any order: atoms whose numbers go on in all the ways programs have, odd ones, and
/// records that begin and end models, bond atoms, or say something.
fn some_lines() -> Vec<String> {
    let mut lines: Vec<String> =
        ["99998", "99999", "A0000", "A0001", "186a0", "186a1", "*****", "    1", "    2", "1a2b3"]
            .iter()
            .map(|serial| carbon(serial, 1.5))
            .collect();
    for residue in ["9999", "A000", "2710", "2711", "  12", "x"] {
        lines.push(atom(&format!("ATOM     12  CA  ALA A{residue:>4}"), -3.25, "  1.00  0.00           C  "));
    }
    lines.push(atom("ATOM     13  CA  GLY A  13", 0.0, ""));
    lines.push(atom("ATOM     14  XX  ZZZ B  13", 0.0, "  1.00  0.00           Qq"));
    lines.push(atom("ATOM     15  CL  LIG", 12.0, "  0.50  3.00"));
    lines.extend(
        [
            "ATOM     16  C   LIG A   1       x.xxx   0.000   0.000\n",
            "ATOM     17  C   LIG A   1       1.0     2.0     3.12345\n",
            "TER\n",
            "ANISOU   17  C   LIG\n",
            "MODEL        1\n",
            "ENDMDL\n",
            "END\n",
            "HEADER    A\n",
            "TITLE     A TITLE\n",
            "CRYST1   10.000   11.000   12.000  90.00  90.00  90.00 P 1\n",
            "CRYST1   10.000   11.000\n",
            "CONECT    1    2\n",
            "CONECT99999A0000\n",
            "CONECT186a0186a1\n",
            "SSBOND   1 CYS A    1    CYS A    2\n",
            "HELIX    1   1 SER A    1  GLY A    2  1                                   2\n",
            "\n",
        ]
        .map(str::to_owned),
    );
    lines
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn chunks_are_read_as_the_whole(picks in proptest::collection::vec((0usize..40, 1usize..4), 1..50)) {
        let lines = some_lines();
        let text: String = picks.iter().flat_map(|&(pick, times)| lines.get(pick).map(|line| line.repeat(times))).collect();
        for limits in [
            Limits::default(),
            Limits { atoms: 5, ..Limits::default() },
            Limits { line_bytes: 60, ..Limits::default() },
            Limits { records: 2, ..Limits::default() },
        ] {
            let whole = in_chunks(&text, usize::MAX, 1, &limits);
            for (bytes, threads) in [(1, 1), (200, 1), (1, 4), (100, 4), (500, 2)] {
                let parts = in_chunks(&text, bytes, threads, &limits);
                prop_assert_eq!(&parts, &whole, "{} bytes, {} threads", bytes, threads);
            }
        }
    }
}
