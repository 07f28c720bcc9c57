use super::column::Column;
use super::encoder::{Packer, Source, Step, Unit, category, column, data, file, texts};
use super::encoding::{Budget, Data, Problem};
use super::msgpack::Cursor;
use crate::import::{Document, Format, ImportOptions, Limits, read_bytes};
use crate::structure::Severity;
use crate::{Error, Result};
use glam::DVec3;
use proptest::prelude::*;

const BYTES_3: [Step; 1] = [Step::ByteArray(3)];

fn decoded<'a>(packed: &'a Packer, mask: Option<&'a Packer>, rows: usize) -> Result<Column<'a>, Problem> {
    let read = |packed: &'a Packer| Data::read(&mut Cursor::new(&packed.0)).expect("sound").expect("not nil");
    Column::decode(&read(packed), mask.map(read).as_ref(), rows, &Budget::new(1 << 30))
}

/// Every order of the encodings of whole numbers that has a meaning.
fn integer_chains() -> Vec<Vec<Step>> {
    let mut chains = Vec::new();
    for before in
        [&[][..], &[Step::Delta], &[Step::RunLength], &[Step::Delta, Step::RunLength], &[Step::RunLength, Step::Delta]]
    {
        let chain = |more: &[Step]| before.iter().chain(more).copied().collect::<Vec<_>>();
        chains.push(chain(&BYTES_3));
        for (bytes, kind) in [(1, 1), (2, 2)] {
            chains.push(chain(&[Step::Packing { bytes, unsigned: false }, Step::ByteArray(kind)]));
        }
        chains.push(chain(&[Step::Packing { bytes: 2, unsigned: false }, Step::RunLength, Step::ByteArray(3)]));
    }
    chains
}

proptest! {
    #[test]
    fn whole_numbers_survive_every_chain(
        mut values in proptest::collection::vec(-70_000i32..70_000, 0..60),
        runs in 0usize..5,
    ) {
        let copies = values.iter().flat_map(|&value| std::iter::repeat_n(value, runs + 1)).collect();
        values = copies;
        for chain in integer_chains() {
            let packed = data(&Source::Integers(values.clone()), &chain);
            let column = decoded(&packed, None, values.len()).unwrap();
            let got: Vec<i64> = (0..values.len()).map(|row| column.integer(row).unwrap()).collect();
            let want: Vec<i64> = values.iter().map(|&value| i64::from(value)).collect();
            prop_assert_eq!(got, want, "{:?}", chain);
        }
    }

    #[test]
    fn numbers_without_a_sign_survive_unsigned_packing(values in proptest::collection::vec(0i32..200_000, 0..60)) {
        for (bytes, kind) in [(1, 4), (2, 5)] {
            let chain = [Step::Packing { bytes, unsigned: true }, Step::ByteArray(kind)];
            let packed = data(&Source::Integers(values.clone()), &chain);
            let column = decoded(&packed, None, values.len()).unwrap();
            for (row, &value) in values.iter().enumerate() {
                prop_assert_eq!(column.integer(row), Some(i64::from(value)));
            }
        }
    }

    #[test]
    fn decimals_survive_fixed_point_and_floats(thousandths in proptest::collection::vec(-9_999_999i32..9_999_999, 1..60)) {
        let values: Vec<f64> = thousandths.iter().map(|&n| f64::from(n) / 1000.0).collect();
        for chain in [
            vec![Step::FixedPoint(1000.0), Step::Delta, Step::Packing { bytes: 2, unsigned: false }, Step::ByteArray(2)],
            vec![Step::FixedPoint(1000.0), Step::ByteArray(3)],
            vec![Step::ByteArray(33)],
            vec![Step::ByteArray(32)],
        ] {
            let packed = data(&Source::Floats(values.clone()), &chain);
            let column = decoded(&packed, None, values.len()).unwrap();
            for (row, &value) in values.iter().enumerate() {
                let (got, decimals) = column.number(row).unwrap();
                prop_assert!(got == value && decimals <= 3, "{} {} {} {:?}", got, value, decimals, chain);
            }
        }
    }

    #[test]
    fn quantised_numbers_are_near(values in proptest::collection::vec(-5.0f64..7.0, 1..60)) {
        let chain = [
            Step::Interval { min: -5.0, max: 7.0, steps: 121 },
            Step::Packing { bytes: 1, unsigned: true },
            Step::ByteArray(4),
        ];
        let packed = data(&Source::Floats(values.clone()), &chain);
        let column = decoded(&packed, None, values.len()).unwrap();
        for (row, &value) in values.iter().enumerate() {
            prop_assert!((column.number(row).unwrap().0 - value).abs() <= 0.05 + 1e-9);
        }
    }

    #[test]
    fn texts_and_masks_survive(rows in proptest::collection::vec((0usize..6, 0i32..3), 1..60)) {
        let all = ["CA", "O5'", "", "β-sheet", "𝛼 helix", "a longer text"];
        let values: Vec<Option<&str>> = rows.iter().map(|&(text, _)| all.get(text).copied()).collect();
        let mask = data(&Source::Integers(rows.iter().map(|row| row.1).collect()), &[Step::RunLength, Step::ByteArray(3)]);
        for unit in [Unit::Bytes, Unit::Characters, Unit::Utf16] {
            for index_steps in integer_chains() {
                let packed = texts(&values, &index_steps, &[Step::Delta, Step::ByteArray(3)], unit);
                let column = decoded(&packed, Some(&mask), rows.len()).unwrap();
                for (row, &(_, masked)) in rows.iter().enumerate() {
                    let want = values[row].filter(|_| masked == 0);
                    let got = column.text(row);
                    prop_assert_eq!(got.as_deref(), want);
                }
            }
        }
    }
}

#[test]
fn types_of_all_widths_are_read() {
    for (kind, value, want) in [
        (1, -1, -1),
        (4, 255, 255),
        (2, -2, -2),
        (5, 65_535, 65_535),
        (3, i32::MIN, i64::from(i32::MIN)),
        (6, -1, 4_294_967_295),
    ] {
        let packed = data(&Source::Integers(vec![value]), &[Step::ByteArray(kind)]);
        let column = decoded(&packed, None, 1).unwrap();
        assert_eq!((column.integer(0), column.number(0)), (Some(want), Some((want as f64, 0))), "type {kind}");
    }
}

#[test]
fn values_are_given_as_what_is_asked_for() {
    let numbers = data(&Source::Floats(vec![1.5, 2.0]), &[Step::FixedPoint(100.0), Step::ByteArray(3)]);
    let column = decoded(&numbers, None, 2).unwrap();
    assert_eq!((column.text(0).as_deref(), column.integer(0), column.integer(1)), (Some("1.50"), None, Some(2)));
    assert_eq!(column.number(5), None);
    let names = texts(&[Some("1.234(5)"), Some("7"), None], &BYTES_3, &BYTES_3, Unit::Bytes);
    let column = decoded(&names, None, 3).unwrap();
    assert_eq!((column.number(0), column.integer(1), column.text(2)), (Some((1.234, 3)), Some(7), None));
    let whole = data(&Source::Integers(vec![12]), &BYTES_3);
    assert_eq!(decoded(&whole, None, 1).unwrap().text(0).as_deref(), Some("12"));
}

#[test]
fn single_precision_numbers_are_the_decimals_they_were() {
    let values = vec![1.1, 0.123, -999.999];
    let packed = data(&Source::Floats(values.clone()), &[Step::ByteArray(32)]);
    let column = decoded(&packed, None, 3).unwrap();
    assert_eq!((0..3).map(|row| column.number(row).unwrap().0).collect::<Vec<_>>(), values);
}

#[test]
fn contradictions_are_problems() {
    let integers = |n: usize| Source::Integers((0..n as i32).collect());
    let wrong = |packed: &Packer, rows: usize, part: &str| match decoded(packed, None, rows) {
        Err(Problem::Wrong(why)) => assert!(why.contains(part), "{why}"),
        other => panic!("{other:?}, where `{part}` is wanted"),
    };
    wrong(&data(&integers(3), &BYTES_3), 4, "3 values in a table of 4 rows");
    wrong(&data(&integers(3), &[Step::Packing { bytes: 3, unsigned: false }, Step::ByteArray(3)]), 3, "3 bytes");
    // Steps that cannot follow one another.
    let mut odd = Packer::default();
    odd.map(2).text("data").bytes(&[0; 8]).text("encoding").array(2);
    odd.map(2).text("kind").text("ByteArray").text("type").number(3.0);
    odd.map(2).text("kind").text("ByteArray").text("type").number(3.0);
    wrong(&odd, 2, "ByteArray");
    let mut odd = Packer::default();
    odd.map(2).text("data").bytes(&[0; 8]).text("encoding").array(2);
    odd.map(3).text("kind").text("Delta").text("srcType").number(3.0).text("origin").number(0.0);
    odd.map(2).text("kind").text("ByteArray").text("type").number(33.0);
    wrong(&odd, 1, "whole numbers");
    let mut runs = Packer::default();
    runs.map(2).text("data").bytes(&[1, 0, 0, 0, 255, 255, 255, 255]).text("encoding").array(2);
    runs.map(2).text("kind").text("RunLength").text("srcSize").number(1.0);
    runs.map(2).text("kind").text("ByteArray").text("type").number(3.0);
    wrong(&runs, 1, "a run of -1");
    let mask = data(&Source::Integers(vec![3]), &BYTES_3);
    assert!(decoded(&data(&integers(1), &BYTES_3), Some(&mask), 1).is_err());
}

/// Atoms of two residues and two models, as a writer might give them.
fn atom_site() -> Packer {
    let bytes = |values: Vec<i32>| data(&Source::Integers(values), &[Step::RunLength, Step::ByteArray(3)]);
    let text = |values: [&str; 4]| texts(&values.map(Some), &[Step::Delta, Step::ByteArray(3)], &BYTES_3, Unit::Bytes);
    let float = |values: [f64; 4], factor: f64| {
        let chain =
            [Step::FixedPoint(factor), Step::Delta, Step::Packing { bytes: 2, unsigned: false }, Step::ByteArray(2)];
        data(&Source::Floats(values.to_vec()), &chain)
    };
    let columns = [
        column("group_PDB", &text(["ATOM", "HETATM", "ATOM", "HETATM"]), None),
        column("id", &bytes(vec![1, 2, 3, 4]), None),
        column("type_symbol", &text(["C", "ZN", "C", "ZN"]), None),
        column("label_atom_id", &text(["CA", "ZN", "CA", "ZN"]), None),
        column("label_comp_id", &text(["ALA", "ZN", "ALA", "ZN"]), None),
        column("auth_asym_id", &text(["A", "B", "A", "B"]), None),
        column("auth_seq_id", &bytes(vec![-5, 7, -5, 7]), None),
        column("Cartn_x", &float([1.234, -9.999, 1.235, -9.998], 1000.0), None),
        column("Cartn_y", &float([0.0, 55.5, 0.1, 55.6], 1000.0), None),
        column("Cartn_z", &float([-0.001, 3.0, -0.002, 3.1], 1000.0), None),
        column("B_iso_or_equiv", &float([20.25, 10.0, 20.25, 10.0], 100.0), None),
        column("pdbx_PDB_model_num", &bytes(vec![1, 1, 2, 2]), None),
    ];
    category("_atom_site", 4, &columns)
}

/// What a row of a usual table may say: places in lists of texts, and numbers.
type Said = (usize, usize, i32, usize, bool, bool, i32);

fn usual_columns(rows: &[Said], odd_symbol: bool) -> Vec<Packer> {
    let steps = [Step::Delta, Step::ByteArray(3)];
    let text = |value: &dyn Fn(&Said) -> Option<&'static str>| {
        texts(&rows.iter().map(value).collect::<Vec<_>>(), &steps, &BYTES_3, Unit::Bytes)
    };
    let whole = |value: &dyn Fn(&Said) -> i32| data(&Source::Integers(rows.iter().map(value).collect()), &BYTES_3);
    let float = |value: &dyn Fn(&Said) -> f64| {
        let chain = [Step::FixedPoint(1000.0), Step::Delta, Step::Packing { bytes: 2, unsigned: false }];
        data(&Source::Floats(rows.iter().map(value).collect()), &[&chain[..], &[Step::ByteArray(2)]].concat())
    };
    let mask = whole(&|said| i32::from(said.5) * 2);
    let symbols = ["C", "D", "ZN", if odd_symbol { "Qq" } else { "Fe3+" }];
    vec![
        column("group_PDB", &text(&|said| Some(["ATOM", "HETATM"][usize::from(said.4)])), None),
        column("id", &whole(&|said| said.2), None),
        column("type_symbol", &text(&|said| Some(symbols[said.0])), None),
        column("label_atom_id", &text(&|said| Some(["CA", "N", "O5'", "a long name"][said.0])), None),
        column("label_alt_id", &text(&|said| [None, Some("A")][usize::from(said.5)]), None),
        column("label_comp_id", &text(&|said| Some(["ALA", "GLY", "HOH"][said.1])), None),
        column("label_asym_id", &text(&|said| Some(["A", "B", "C"][said.3])), None),
        column("label_seq_id", &whole(&|said| said.6 + 1), Some(&mask)),
        column("pdbx_PDB_ins_code", &text(&|said| [None, Some("B")][usize::from(said.4 && said.5)]), None),
        column("Cartn_x", &float(&|said| f64::from(said.2) / 1000.0), None),
        column("Cartn_y", &float(&|said| f64::from(said.6) / 8.0), None),
        column("Cartn_z", &float(&|said| said.0 as f64), None),
        column("occupancy", &float(&|said| if said.5 { 0.5 } else { 1.0 }), None),
        column(
            "B_iso_or_equiv",
            &data(&Source::Floats(rows.iter().map(|said| f64::from(said.2)).collect()), &[Step::ByteArray(32)]),
            Some(&mask),
        ),
        column("pdbx_formal_charge", &whole(&|said| said.6 % 3), Some(&mask)),
        column("auth_seq_id", &whole(&|said| said.6), None),
        column("auth_asym_id", &text(&|said| Some(["A", "BB", "a long chain"][said.3])), None),
    ]
}

proptest! {
    #[test]
    fn columns_give_what_rows_give(
        runs in proptest::collection::vec(((0usize..4, 0usize..3, 1i32..50, 0usize..3), (any::<bool>(), any::<bool>(), 1i32..4), 1usize..4), 1..20),
        odd_symbol in any::<bool>(),
    ) {
        let one = |((a, b, c, d), (e, f, g), _): &_| (*a, *b, *c, *d, *e, *f, *g);
        let rows: Vec<Said> = runs.iter().flat_map(|run| std::iter::repeat_n(one(run), run.2)).collect();
        let mut columns = usual_columns(&rows, odd_symbol);
        let by_column = file(&[category("_atom_site", rows.len(), &columns)]);
        // A column that no usual table has, without a value: rows are read.
        let nothing = texts(&vec![None; rows.len()], &BYTES_3, &BYTES_3, Unit::Bytes);
        columns.push(column("calc_flag", &nothing, None));
        let by_row = file(&[category("_atom_site", rows.len(), &columns)]);
        let is_plain = |bytes: &[u8]| {
            let at = bytes.windows(10).position(|window| window == b"dataBlocks").unwrap() + 11;
            let context = super::Context::new(Budget::new(1 << 30), 100);
            let (block, _) = super::BinaryBlock::read(&mut Cursor::new(&bytes[at..]), &context);
            block.plain_sites(&Limits::default()).is_some()
        };
        let has_odd = odd_symbol && rows.iter().any(|said| said.0 == 3);
        prop_assert_eq!((is_plain(&by_column), is_plain(&by_row)), (!has_odd, false));
        let [by_column, by_row] = [by_column, by_row].map(|bytes| read(&bytes).unwrap());
        prop_assert_eq!(by_column, by_row);
    }
}

fn read(bytes: &[u8]) -> Result<Document> {
    read_bytes(bytes, "a.bcif", &ImportOptions::default())
}

#[test]
fn a_file_is_read_as_its_text_would_be() {
    let document = read(&file(&[atom_site()])).unwrap();
    assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
    let first = &document.records[0];
    assert_eq!((document.format, first.atom_count(), first.frames().len()), (Format::BinaryCif, 2, 2));
    assert_eq!(first.positions().written(1), DVec3::new(-9.999, 55.5, 3.0));
    assert_eq!(first.positions().decimals(), 3);
    assert_eq!((first.atom_name(0), first.elements()[1].symbol(), first.b_factor(0)), ("CA", "Zn", 20.25));
    assert_eq!((first.residues()[0].number, first.chains().collect::<Vec<_>>()), (-5, vec!["A", "B"]));
    assert_eq!(first.frames()[1].positions.written(0), DVec3::new(1.235, 0.1, -0.002));
}

#[test]
fn what_stands_around_the_atoms_is_read() {
    let numbers = |value: f64| data(&Source::Floats(vec![value]), &[Step::FixedPoint(100.0), Step::ByteArray(3)]);
    let names = ["length_a", "length_b", "length_c", "angle_alpha", "angle_beta", "angle_gamma"];
    let columns: Vec<Packer> = names
        .iter()
        .zip([10.0, 11.0, 12.5, 90.0, 90.0, 90.0])
        .map(|(name, value)| column(name, &numbers(value), None))
        .collect();
    let title = texts(&[Some("a test")], &BYTES_3, &BYTES_3, Unit::Bytes);
    let categories =
        [category("_cell", 1, &columns), category("_struct", 1, &[column("title", &title, None)]), atom_site()];
    let document = read(&file(&categories)).unwrap();
    let first = &document.records[0];
    assert_eq!((first.title(), first.cell().unwrap().lengths()), ("a test", [10.0, 11.0, 12.5]));
}

#[test]
fn a_column_that_is_wrong_is_named() {
    let mut bytes = file(&[atom_site()]);
    let at = bytes.windows(7).position(|window| window == b"Cartn_y").unwrap();
    let size = at + bytes[at..].windows(7).position(|window| window == b"srcSize").unwrap();
    bytes[size + 15] = 9;
    let error = read(&bytes).unwrap_err().to_string();
    assert!(error.contains("_atom_site.Cartn_y") && error.contains("for 9"), "{error}");
}

#[test]
fn a_cut_file_gives_its_whole_categories() {
    let cell =
        category("_cell", 1, &[column("length_a", &data(&Source::Floats(vec![5.0]), &[Step::ByteArray(33)]), None)]);
    let whole = file(&[atom_site(), cell]);
    let document = read(&whole[..whole.len() - 3]).unwrap();
    assert_eq!(document.records[0].atom_count(), 2);
    assert_eq!(document.diagnostics.last().map(|d| d.severity), Some(Severity::Error));
    for end in 0..whole.len() {
        let _any = read(&whole[..end]);
    }
}

#[test]
fn promises_cost_nothing() {
    let mut packer = Packer::default();
    packer.map(1).text("dataBlocks").0.extend([0xdd, 0xff, 0xff, 0xff, 0xff]);
    assert!(read(&packer.0).is_err());
    // Four billion rows of one run.
    for rows in [4_294_967_295u32, 1 << 30] {
        let mut run = Packer::default();
        let bytes: Vec<u8> = [1i32, i32::MAX].iter().flat_map(|value| value.to_le_bytes()).collect();
        run.map(2).text("data").bytes(&bytes).text("encoding").array(2);
        run.map(3)
            .text("kind")
            .text("RunLength")
            .text("srcType")
            .number(3.0)
            .text("srcSize")
            .number(f64::from(i32::MAX));
        run.map(2).text("kind").text("ByteArray").text("type").number(3.0);
        let columns = ["Cartn_x", "Cartn_y", "Cartn_z", "id"].map(|name| column(name, &run, None));
        assert!(read(&file(&[category("_atom_site", rows as usize, &columns)])).is_err());
        let columns = ["Cartn_x", "Cartn_y", "Cartn_z"].map(|name| column(name, &run, None));
        let result = read(&file(&[category("_atom_site", i32::MAX as usize, &columns)]));
        assert!(matches!(result, Err(Error::Limit { .. })), "{result:?}");
    }
    let options = ImportOptions { limits: Limits { atoms: 1, ..Limits::default() }, ..ImportOptions::default() };
    let result = read_bytes(&file(&[atom_site()]), "", &options);
    assert!(matches!(result, Err(Error::Limit { .. })));
}

#[test]
fn what_is_not_binary_cif_is_told() {
    for bytes in [&b""[..], b"\x80", b"\x81\xa1x\x01", b"data_x\n", b"\xc1", b"\x81\xaadataBlocks\x90"] {
        let options = ImportOptions { format: Some(Format::BinaryCif), ..ImportOptions::default() };
        assert!(read_bytes(bytes, "a.bcif", &options).is_err(), "{bytes:?}");
    }
    assert!(read(b"not at all").unwrap_err().to_string().contains("BinaryCIF"));
}
