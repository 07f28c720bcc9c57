use crate::element::Element;
use crate::error::{Error, Result};
use crate::import::collect::Records;
use crate::import::{Document, Format, ImportOptions, Limits, read_bytes};
use crate::structure::{Diagnostics, Severity, StatedBonds, atom_flags};
use glam::DVec3;
use proptest::prelude::*;

fn read(text: &str) -> Result<Document> {
    read_bytes(text.as_bytes(), "a.xyz", &ImportOptions { format: Some(Format::Xyz), ..ImportOptions::default() })
}

#[test]
fn a_plain_file_is_read_digit_for_digit() {
    let document = read("  3\n\nO 0.0 0.0 0.11730\nh 0 0.757200 -0.46920\n1\t0 -0.7572 -4.692D-01 \n\n \n").unwrap();
    let water = &document.records[0];
    assert_eq!(water.elements(), [Element::O, Element::H, Element::H]);
    assert_eq!(water.positions().decimals(), 6);
    assert_eq!(water.positions().written(2), DVec3::new(0.0, -0.7572, -0.4692));
    assert_eq!(water.stated_bonds(), StatedBonds::None);
    assert!(document.diagnostics.is_empty());
}

#[test]
fn frames_with_other_atoms_are_other_records() {
    let text = "1\na\nC 0 0 0\n1\nb\nC 0 0 1\n2\nc\nC 0 0 0\nO 0 0 1\n";
    let document = read(text).unwrap();
    let frames: Vec<usize> = document.records.iter().map(|record| record.frames().len()).collect();
    assert_eq!(frames, [2, 1]);
    assert_eq!(document.records[0].frames()[1].title, "b");
    assert_eq!(document.records[0].frames()[1].positions.get(0).z, 1.0);
}

#[test]
fn extended_columns_come_in_any_order() {
    let text = "2\nLattice=\"5 0 0 0 6 0 0 0 7\" Properties=forces:R:3:Z:I:1:tag:L:1:pos:R:3 energy=-1.5\n\
                0.1 0.2 0.3 8 T 1 2 3\n-1 0 1 1 F 4 5 6.5\n";
    let document = read(text).unwrap();
    let molecule = &document.records[0];
    assert_eq!(molecule.elements(), [Element::O, Element::H]);
    assert_eq!(molecule.positions().get(1), DVec3::new(4.0, 5.0, 6.5));
    assert_eq!(molecule.vectors()[0].name, "forces");
    assert_eq!(molecule.vectors()[0].vectors[1].to_array(), [-1.0, 0.0, 1.0]);
    assert_eq!(molecule.cell().unwrap().lengths(), [5.0, 6.0, 7.0]);
    assert_eq!(molecule.properties(), [("energy".to_owned(), "-1.5".to_owned())]);
}

#[test]
fn columns_behind_the_position_mean_what_xmol_means() {
    let vectors = &read("2\n\nC 0 0 0 1 2 3\nC 0 0 1 4 5 6\n").unwrap().records[0];
    assert_eq!(vectors.vectors()[0].vectors[1].to_array(), [4.0, 5.0, 6.0]);
    let charged = &read("1\n\nC 0 0 0 -0.5 1 2 3\n").unwrap().records[0];
    assert_eq!(charged.partial_charge(0), Some(-0.5));
    let mixed = &read("2\n\nC 0 0 0 1 2 3\nC 0 0 1 x\n").unwrap().records[0];
    assert!(mixed.vectors().is_empty() && mixed.atom_count() == 2);
}

#[test]
fn labels_are_kept_as_names() {
    let document = read("4\n\nC12 0 0 0\nOW 0 0 1\nXx 0 0 2\nC 0 0 3\n").unwrap();
    let molecule = &document.records[0];
    assert_eq!((0..4).map(|atom| molecule.atom_name(atom)).collect::<Vec<_>>(), ["C12", "OW", "Xx", ""]);
    assert_eq!(molecule.flags(2), atom_flags::PARTICLE);
    assert_eq!(document.diagnostics.len(), 1, "{:?}", document.diagnostics);
}

#[test]
fn a_cut_file_gives_its_sound_frames() {
    let document = read("1\n\nC 0 0 0\n2\n\nC 0 0 0\n").unwrap();
    assert_eq!(document.frame_count(), 1);
    assert_eq!(document.diagnostics[0].severity, Severity::Error);
    let error = read("2\n\nC 0 0 0\n").unwrap_err();
    assert!(error.to_string().contains("expected 2 atoms"), "{error}");
}

#[test]
fn reading_goes_on_behind_a_bad_frame() {
    for bad in ["3\n\nC 0 0 0\nC 0 0 1\n", "2\n\nC 0 0 0\nC 0 zero 0\n", "what is this\n", "1\n\nC 0 0 0\nC 0 0 0\n"] {
        let document = read(&format!("1\n\nN 0 0 0\n{bad}1\n\nO 0 0 0\n")).unwrap();
        assert_eq!(document.records.last().unwrap().elements(), [Element::O], "{bad:?}");
        assert!(document.diagnostics.iter().any(|d| d.severity == Severity::Error && d.line > Some(3)), "{bad:?}");
    }
}

#[test]
fn an_atom_nowhere_is_left_out_alone() {
    let document = read("3\n\nC 0 0 0 1 2 3\nC nan inf 0 4 5 6\nO 0 0 1e30 7 8 9\n").unwrap();
    assert_eq!(document.records[0].atom_count(), 1);
    assert_eq!(document.records[0].vectors()[0].vectors.len(), 1);
    assert_eq!(document.diagnostics[0].line, Some(4));
    assert!(read("1\n\nC nan nan nan\n").is_err());
}

#[test]
fn a_count_is_a_claim_not_a_fact() {
    for count in ["2147483647", "18446744073709551615", "99999999999999999999999"] {
        assert!(read(&format!("{count}\n\nC 0 0 0\n")).is_err());
    }
    let options =
        ImportOptions { limits: crate::import::Limits { atoms: 1, ..Default::default() }, ..ImportOptions::default() };
    let error = read_bytes(b"2\n\nC 0 0 0\nC 0 0 1\n", "", &options).unwrap_err();
    assert!(matches!(error, Error::Limit { .. }), "{error}");
    assert!(read("0\n\n").is_err());
}

/// Reads with so many threads, waves of so many bytes a thread, and parts of so many atoms.
fn in_waves(text: &str, threads: usize, bytes: usize, atoms: usize, limits: &Limits) -> Result<Document, String> {
    let mut diagnostics = Diagnostics::default();
    let mut records = Records::new(limits, &crate::stop::Stop::never());
    let waves = super::Waves { threads, least_bytes: bytes, part_atoms: atoms, tried: usize::MAX };
    super::read_in_waves(text.as_bytes(), waves, &mut records, &mut diagnostics)
        .and_then(|()| records.finish(Format::Xyz, diagnostics))
        .map_err(|error| error.to_string())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn waves_are_read_as_the_whole(
        frames in proptest::collection::vec((0usize..8, 0usize..6, proptest::collection::vec(0usize..40, 0..6)), 1..12),
    ) {
        let comments = ["", "a title", "Lattice=\"5 0 0 0 5 0 0 0 5\" Properties=species:S:1:pos:R:3:f:R:3 e=1", "Lattice=\"1\"", "3"];
        let atoms = ["C 0 0 0", "OW 1.25 0 3", "Xx 1 2 3", "C nan 0 0", "C 1 2 3 4 5 6", "C 1 2 3 0.5 4 5 6", "C 1 2", "Qz 1 2 3.123", ""];
        let mut text = String::new();
        for (count, comment, picks) in &frames {
            // The count is right but now and then.
            let said = if *count < 6 { picks.len() } else { *count };
            text += &format!("{said}\n{}\n", comments.get(*comment).unwrap_or(&""));
            // Mostly the same kind of atom in a frame.
            let usual = picks.first().map_or(0, |pick| pick % 6);
            for pick in picks {
                text += atoms[if *pick < atoms.len() { *pick } else { usual }];
                text += "\n";
            }
        }
        for limits in [Limits::default(), Limits { atoms: 3, ..Limits::default() }, Limits { line_bytes: 20, ..Limits::default() }] {
            let whole = in_waves(&text, 1, 1, 1, &limits);
            for (threads, bytes, atoms) in [(2, 1, 1), (3, 30, 2), (2, 200, 100)] {
                let parts = in_waves(&text, threads, bytes, atoms, &limits);
                prop_assert_eq!(&parts, &whole, "{} threads, {} bytes, {} atoms:\n{}", threads, bytes, atoms, &text);
            }
        }
    }
}
