use super::*;
use crate::import::collect::Records;
use crate::structure::Structure;
use proptest::prelude::*;

/// Rows as a loop, each value after a blank.
fn text_of(rows: &[String]) -> String {
    let items = [
        "group_PDB",
        "id",
        "type_symbol",
        "auth_atom_id",
        "auth_comp_id",
        "auth_asym_id",
        "auth_seq_id",
        "Cartn_x",
        "Cartn_y",
        "Cartn_z",
    ];
    let names: String = items.iter().map(|item| format!("_atom_site.{item}\n")).collect();
    format!("data_x\nloop_\n{names}{}#\n_entry.id x\n", rows.concat())
}

fn row(n: usize) -> String {
    let name = ["N", "CA", "\"O5'\"", "'C 1'"][n % 4];
    format!(
        "ATOM {} C {name} {} {} {} {}.5 -2.25 0.125\n",
        n + 1,
        ["ALA", "GLY"][n / 4 % 2],
        ["A", "B"][n / 40 % 2],
        n / 4,
        n % 7
    )
}

/// Reads the loop in parts of so many bytes, or (0) from top to bottom.
fn read(text: &str, part_bytes: usize) -> (Structure, Vec<String>) {
    let mut diagnostics = Diagnostics::default();
    let limits = Limits::default();
    let stop = Stop::never();
    let mut tokens = Tokens::new(text.as_bytes(), &stop);
    assert!(matches!(tokens.next(), Token::Data(b"x")));
    assert_eq!(tokens.next(), Token::Loop);
    let mut names = Vec::new();
    let start = loop {
        let before = tokens;
        match tokens.next() {
            Token::Name(name) => names.push(&name[b"_atom_site.".len()..]),
            _ => break before,
        }
    };
    let mut tokens = start;
    let columns = Columns::find(|item| find_item(&names, item)).unwrap();
    let mut sites = AtomSites::new(&limits);
    sites.begin(&columns, 0);
    tokens.skip_line_end();
    let mut reader = RowReader { columns: &columns, limits: &limits, values: vec![None; names.len()] };
    if part_bytes > 0 {
        reader.read_parts(&mut tokens, &mut sites, part_bytes).unwrap();
    }
    reader.read(&mut tokens, &mut sites, &mut diagnostics).unwrap();
    assert_eq!(tokens.next(), Token::Name(b"_entry.id"));
    assert_eq!(tokens.line as usize, text.lines().count());
    let mut records = Records::new(&limits, &crate::stop::Stop::never());
    let block = super::super::text::TextBlock::new(b"x");
    super::super::block::finish(&block, sites, &mut records, &mut diagnostics).unwrap();
    let document = records.finish(crate::import::Format::Mmcif, diagnostics).unwrap();
    let messages = document.diagnostics.iter().map(ToString::to_string).collect();
    (document.records.into_iter().next().unwrap(), messages)
}

#[test]
fn parts_give_exactly_what_reading_from_top_to_bottom_gives() {
    let mut rows: Vec<String> = (0..200).map(row).collect();
    // Without a position, with an unknown element: messages must come out the same, too.
    rows[70] = "ATOM 71 C CA ALA A 17 ? ? ?\n".to_owned();
    rows[120] = "HETATM 9999 Qq QQ1 XXX A 30 1 2 3\n".to_owned();
    let text = text_of(&rows);
    let whole = read(&text, 0);
    assert_eq!((whole.0.atom_count(), whole.0.residues().len(), whole.1.len()), (199, 51, 2));
    for part in [1, 30, 64, 1000, 1 << 20] {
        assert_eq!(read(&text, part), whole, "parts of {part} bytes");
    }
}

#[test]
fn rows_that_do_not_stand_one_a_line_are_read_all_the_same() {
    let plain: Vec<String> = (0..40).map(row).collect();
    let whole = read(&text_of(&plain), 0).0;
    let mut odd = plain.clone();
    odd[7] = odd[7].replacen("ALA", "\n ALA", 1).replacen("GLY", "\n GLY", 1);
    odd[20] = format!("{} {}", odd[20].trim_end(), odd[21]);
    odd[21] = "# loop_ comment\n\n".to_owned();
    odd[30] = odd[30].replacen(" C \"O5'\"", " C\n;O5'\n;\n", 1);
    let text = text_of(&odd);
    for part in [0, 1, 100, 1 << 20] {
        assert_eq!(read(&text, part).0, whole, "parts of {part} bytes");
    }
}

#[test]
fn lines_that_look_like_rows_inside_a_text_field_are_none() {
    let mut rows: Vec<String> = (0..40).map(row).collect();
    rows[10] = rows[10].replacen(" C \"O5'\"", &format!(" C\n;{}{}\n;\n", row(1), row(2)), 1);
    let text = text_of(&rows);
    let whole = read(&text, 0);
    assert_eq!(whole.0.atom_count(), 40);
    for part in [1, 100, 300] {
        assert_eq!(read(&text, part), whole, "parts of {part} bytes");
    }
}

proptest! {
    #[test]
    fn both_ways_to_split_a_line_agree(line in "[ \tab.?'\"#_;0-9lo]{0,60}", width in 1usize..8) {
        let text = format!("{line}\n................");
        let (mut quick, mut slow) = (vec![None; width], vec![None; width]);
        let quick_is = split_row(text.as_bytes(), 0, line.len(), &mut quick);
        let slow_is = split_slowly(line.as_bytes(), &mut slow);
        prop_assert_eq!(quick_is, slow_is);
        if slow_is {
            prop_assert_eq!(&quick, &slow);
            // And the tokens say the same.
            let stop = Stop::never();
            let mut tokens = Tokens::new(line.as_bytes(), &stop);
            for value in slow {
                prop_assert_eq!(tokens.next(), Token::Value(value));
            }
            prop_assert_eq!(tokens.next(), Token::End);
        }
    }
}
