use super::super::{ImportOptions, read_bytes};
use crate::error::Error;
use crate::import::{Document, Format, Limits};
use crate::structure::{BondKind, BondOrder, Severity, StatedBonds, atom_flags};

fn read(text: &str) -> Document {
    read_bytes(text.as_bytes(), "a.cif", &ImportOptions::default()).unwrap()
}

fn refuse(text: &str) -> Error {
    read_bytes(text.as_bytes(), "a.cif", &ImportOptions::default()).unwrap_err()
}

/// A loop of `_atom_site` with these items.
fn sites(items: &str, rows: &str) -> String {
    let names: String = items.split(' ').map(|item| format!("_atom_site.{item}\n")).collect();
    format!("loop_\n{names}{rows}\n#\n")
}

const FULL: &str = "group_PDB id type_symbol label_atom_id label_alt_id label_comp_id label_asym_id label_seq_id \
                    pdbx_PDB_ins_code Cartn_x Cartn_y Cartn_z occupancy B_iso_or_equiv pdbx_formal_charge auth_seq_id \
                    auth_comp_id auth_asym_id auth_atom_id pdbx_PDB_model_num";

#[test]
fn a_row_says_everything_about_its_atom() {
    let rows = "HETATM 77 ZN ZN A ZN C . B 1.500 -2 3.25 0.50 12.5 2 301 ZN X ZN 1";
    let document = read(&format!("data_1ABC\n_struct.title 'A title'\n{}", sites(FULL, rows)));
    let structure = &document.records[0];
    assert_eq!((document.format, structure.title()), (Format::Mmcif, "A title"));
    assert_eq!((structure.elements()[0].symbol(), structure.atom_name(0), structure.serial(0)), ("Zn", "ZN", 77));
    let residue = structure.residues()[0];
    let names = (structure.name(residue.name), residue.number, residue.insertion_code, structure.chains().next());
    assert_eq!(names, ("ZN", 301, b'B', Some("X")));
    assert_eq!((structure.altloc(0), structure.occupancy(0), structure.b_factor(0)), (b'A', 0.5, 12.5));
    assert_eq!((structure.formal_charge(0), structure.flags(0)), (2, atom_flags::HETERO));
    assert_eq!(structure.positions().written(0), glam::DVec3::new(1.5, -2.0, 3.25));
    assert_eq!(structure.positions().decimals(), 3);
}

#[test]
fn columns_may_come_in_any_order_and_all_but_coordinates_may_lack() {
    let document = read(&format!("data_x\n{}", sites("Cartn_z Cartn_y Cartn_x", "3 2 1")));
    let structure = &document.records[0];
    assert_eq!(structure.positions().written(0), glam::DVec3::new(1.0, 2.0, 3.0));
    assert_eq!((structure.atom_count(), structure.residues().len()), (1, 0));
    // No type symbol: the name in its residue; no author's identifiers: the labels.
    let items = "Cartn_x Cartn_y Cartn_z label_atom_id label_comp_id label_asym_id label_seq_id";
    let document = read(&format!("data_x\n{}", sites(items, "0 0 0 CA ALA A 1\n3 0 0 CA CA B .")));
    let structure = &document.records[0];
    assert_eq!((structure.elements()[0].symbol(), structure.elements()[1].symbol()), ("C", "Ca"));
    assert_eq!((structure.residues()[0].number, structure.chains().collect::<Vec<_>>()), (1, vec!["A", "B"]));
}

#[test]
fn a_single_atom_may_stand_without_a_loop() {
    let text = "data_x\n_atom_site.type_symbol O\n_atom_site.Cartn_x 1\n_atom_site.Cartn_y 2\n_atom_site.Cartn_z 3\n";
    assert_eq!(read(text).records[0].elements()[0].symbol(), "O");
}

#[test]
fn label_identifiers_keep_neighbours_with_equal_numbers_apart() {
    let items = "Cartn_x Cartn_y Cartn_z type_symbol auth_atom_id auth_comp_id auth_asym_id auth_seq_id label_asym_id label_seq_id";
    let rows = "0 0 0 O O HOH A 1 W .\n3 0 0 O O HOH A 1 V .\n6 0 0 C C ALA A 2 A 2\n7 0 0 C C ALA A 2 A 3";
    assert_eq!(read(&format!("data_x\n{}", sites(items, rows))).records[0].residues().len(), 4);
    // Waters without any number: the name that comes again begins the next.
    let items = "Cartn_x Cartn_y Cartn_z type_symbol label_atom_id label_comp_id label_asym_id label_seq_id";
    let rows = "0 0 0 O O HOH W .\n0 0 1 H H1 HOH W .\n3 0 0 O O HOH W .\n6 0 0 O O HOH W .";
    assert_eq!(read(&format!("data_x\n{}", sites(items, rows))).records[0].residues().len(), 3);
}

#[test]
fn models_of_the_same_atoms_are_frames_and_others_records() {
    let items = "Cartn_x Cartn_y Cartn_z type_symbol pdbx_PDB_model_num";
    let document = read(&format!("data_x\n{}", sites(items, "0 0 0 C 1\n1 0 0 C 2\n0 0 0 N 7\n2 0 0 C 8")));
    assert_eq!((document.records.len(), document.frame_count()), (3, 4));
    // Rows of one model need not stand together.
    let document = read(&format!("data_x\n{}", sites(items, "0 0 0 C 1\n1 0 0 C 2\n0 0 2 N 1\n1 0 2 N 2")));
    assert_eq!((document.records.len(), document.frame_count()), (1, 2));
    assert_eq!(document.records[0].frames()[1].positions.written(1), glam::DVec3::new(1.0, 0.0, 2.0));
}

#[test]
fn blocks_with_atoms_are_records_and_texts_are_passed_over() {
    let items = "Cartn_x Cartn_y Cartn_z type_symbol";
    let text = format!(
        "data_global\n_publ_section_title\n;\nloop_\n_atom_site.x\n;\ndata_a\n{}data_b\nsave_frame\n_cell.length_a x\nsave_\n{}",
        sites(items, "0 0 0 C"),
        sites(items, "0 0 0 C")
    );
    let document = read(&text);
    assert_eq!((document.records.len(), document.records[1].title()), (2, "b"));
    assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
}

/// Two residues, one of them with two alternate locations, and what links them.
fn linked(conn: &str) -> Document {
    let rows = "\
        ATOM 1 S SG A CYS A 1 ? 0 0 0 0.5 0 ? 11 CYS X SG 1\nATOM 2 S SG B CYS A 1 ? 0 0 1 0.5 0 ? 11 CYS X SG 1\n\
        ATOM 3 S SG . CYS A 2 ? 2 0 0 1 0 ? 12 CYS X SG 1\nHETATM 4 ZN ZN . ZN B . ? 5 0 0 1 0 ? 1 ZN X ZN 1\n\
        HETATM 5 O O . HOH C . ? 7 0 0 1 0 ? 1 HOH X O 1";
    let ends = ["1", "2"].map(|n| {
        ["asym_id", "seq_id", "comp_id", "atom_id"].map(|item| format!("_struct_conn.ptnr{n}_label_{item}\n")).concat()
            + &format!("_struct_conn.pdbx_ptnr{n}_label_alt_id\n_struct_conn.ptnr{n}_auth_asym_id\n")
            + &format!("_struct_conn.ptnr{n}_auth_seq_id\n_struct_conn.ptnr{n}_symmetry\n")
    });
    let names = format!("loop_\n_struct_conn.conn_type_id\n{}_struct_conn.pdbx_value_order\n", ends.concat());
    read(&format!("data_x\n{names}{conn}\n{}", sites(FULL, rows)))
}

#[test]
fn links_are_bonds_of_their_kind_between_all_alternate_locations() {
    let document = linked(
        "disulf A 1 CYS SG ? X 11 1_555 A 2 CYS SG ? X 12 1_555 ?\n\
         metalc A 2 CYS SG ? X 12 1_555 B . ZN ZN ? X 1 1_555 ?\n\
         metalc B . ZN ZN ? X 1 2_555 C . HOH O ? X 1 2_555 ?\n\
         hydrog C . HOH O ? X 1 . A 1 CYS SG B X 11 . ?\n\
         saltbr C . HOH O ? X 1 . A 1 CYS SG B X 11 . ?",
    );
    let structure = &document.records[0];
    let got: Vec<_> = structure.bonds().iter().map(|bond| (bond.a, bond.b, bond.kind, bond.order)).collect();
    let want = [
        (0, 2, BondKind::Covalent, BondOrder::Single),
        (1, 2, BondKind::Covalent, BondOrder::Single),
        (1, 4, BondKind::Hydrogen, BondOrder::Unknown),
        (2, 3, BondKind::Coordination, BondOrder::Unknown),
        (3, 4, BondKind::Coordination, BondOrder::Unknown),
    ];
    assert_eq!(got, want);
    assert_eq!(structure.stated_bonds(), StatedBonds::Partial);
    assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
}

#[test]
fn links_may_name_residues_by_labels_alone_and_have_orders() {
    let document = linked("covale A 1 CYS SG A ? ? ? A 2 CYS SG ? ? ? ? doub");
    let bonds = document.records[0].bonds();
    assert_eq!((bonds.len(), bonds[0].a, bonds[0].b, bonds[0].order), (1, 0, 2, BondOrder::Double));
}

#[test]
fn links_to_symmetry_mates_and_to_nothing_are_left_out_with_a_word() {
    for (row, word) in [
        ("covale A 1 CYS SG A X 11 1_555 A 2 CYS SG ? X 12 3_655 ?", "symmetry mate"),
        ("covale A 1 CYS SG C X 11 1_555 A 2 CYS SG ? X 12 1_555 ?", "no atom SG of CYS X 11"),
        ("covale A 1 ALA SG A X 11 1_555 A 2 CYS SG ? X 12 1_555 ?", "no atom SG of ALA X 11"),
    ] {
        let document = linked(row);
        assert!(document.records[0].bonds().is_empty(), "{row}");
        let message = &document.diagnostics[0];
        assert!(message.line.is_some() && message.message.contains(word), "{row}: {message}");
    }
}

#[test]
fn bonds_of_residue_names_cell_symmetry_and_secondary_structure_are_kept() {
    let text = format!(
        "data_x\n_cell.length_a 10\n_cell.length_b 11.5\n_cell.length_c 12\n_cell.angle_alpha 90\n_cell.angle_beta 95\n\
         _cell.angle_gamma 90\n_symmetry.space_group_name_H-M 'P 1 21 1'\nloop_\n_chem_comp_bond.comp_id\n_chem_comp_bond.atom_id_1\n\
         _chem_comp_bond.atom_id_2\n_chem_comp_bond.value_order\n_chem_comp_bond.pdbx_aromatic_flag\nALA C O doub N\nPHE CG CD1 DOUB Y\n\
         ALA CA C SING N\nloop_\n_struct_conf.conf_type_id\n_struct_conf.beg_auth_asym_id\n_struct_conf.beg_auth_seq_id\n\
         _struct_conf.end_auth_seq_id\n_struct_conf.pdbx_end_PDB_ins_code\nHELX_P X 3 9 B\nTURN_P X 10 12 ?\n\
         _struct_sheet_range.beg_auth_asym_id X\n_struct_sheet_range.beg_auth_seq_id 20\n_struct_sheet_range.end_auth_seq_id 24\n{}",
        sites("Cartn_x Cartn_y Cartn_z type_symbol", "0 0 0 C")
    );
    let document = read(&text);
    let structure = &document.records[0];
    let components: Vec<_> = structure.components().iter().map(|c| (c.name.as_str(), c.bonds.len())).collect();
    assert_eq!(components, [("ALA", 2), ("PHE", 1)]);
    assert!(structure.components()[1].bonds[0].aromatic);
    assert_eq!(structure.components()[0].bonds[0].order, BondOrder::Double);
    assert_eq!(structure.cell().unwrap().lengths().map(|x| (x * 10.0).round()), [100.0, 115.0, 120.0]);
    assert_eq!(structure.symmetry().unwrap().space_group, "P 1 21 1");
    let secondary: Vec<_> = structure.secondary().iter().map(|s| (s.helix, s.first, s.last)).collect();
    assert_eq!(secondary, [(true, (3, b' '), (9, b'B')), (false, (20, b' '), (24, b' '))]);
}

const QUARTZ: &str = "data_quartz\n_chemical_name_mineral Quartz\n_cell_length_a 4.9137(5)\n_cell_length_b 4.9137(5)\n\
    _cell_length_c 5.4047(5)\n_cell_angle_alpha 90\n_cell_angle_beta 90\n_cell_angle_gamma 120\n\
    _symmetry_space_group_name_H-M 'P 32 2 1'\nloop_\n_symmetry_equiv_pos_site_id\n_symmetry_equiv_pos_as_xyz\n1 x,y,z\n\
    2 'y, x, -z'\nloop_\n_atom_site_label\n_atom_site_type_symbol\n_atom_site_fract_x\n_atom_site_fract_y\n\
    _atom_site_fract_z\n_atom_site_U_iso_or_equiv\n_atom_site_occupancy\n\
    Si1 Si4+ 0.4697(1) 0 0 0.01 1\nO1 O2- 0.4133(2) 0.2672(2) 0.1188(1) 0.0200(3) 0.5(1)\n\
    loop_\n_atom_site_aniso_label\n_atom_site_aniso_U_11\nSi1 0.01\n";

#[test]
fn a_small_molecule_file_is_read_with_cell_and_symmetry() {
    let document = read(QUARTZ);
    let structure = &document.records[0];
    assert_eq!((document.format, structure.title()), (Format::Cif, "Quartz"));
    assert_eq!((structure.atom_count(), structure.atom_name(1), structure.formal_charge(0)), (2, "O1", 4));
    let want = structure.cell().unwrap().cartesian_from_fractional() * glam::DVec3::new(0.4133, 0.2672, 0.1188);
    assert!((structure.positions().get(1) - want).length() < 1e-6);
    assert_eq!(structure.symmetry().unwrap().operations.len(), 2);
    assert!((structure.b_factor(1) - 8.0 * std::f32::consts::PI.powi(2) * 0.02).abs() < 1e-5);
    assert_eq!((structure.occupancy(1), structure.residues().len()), (0.5, 0));
    assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
}

#[test]
fn tables_beside_the_items_of_a_category_do_not_hide_them() {
    let bonds = "loop_\n_chemical_conn_bond_atom_1\n_chemical_conn_bond_atom_2\n1 2\n2 3\n";
    let document = read(&QUARTZ.replacen("_chemical_name", &format!("{bonds}_chemical_name"), 1));
    assert_eq!((document.records[0].title(), document.diagnostics.len()), ("Quartz", 0));
}

#[test]
fn missing_operations_are_the_identity_in_p1_and_a_warning_elsewhere() {
    let without: String = QUARTZ.replace("1 x,y,z\n2 'y, x, -z'\n", "1 ?\n");
    assert!(read(&without).diagnostics[0].message.contains("P 32 2 1"));
    let p1 = read(&without.replace("P 32 2 1", "P 1"));
    assert_eq!((p1.records[0].symmetry().unwrap().operations.len(), p1.diagnostics.len()), (1, 0));
    let odd = read(&QUARTZ.replace("'y, x, -z'", "nonsense"));
    assert!(odd.diagnostics[0].message.contains("nonsense"));
}

#[test]
fn fractions_without_a_cell_cannot_be_placed() {
    let error = refuse(&QUARTZ.replace("_cell_length_a", "_cell_x"));
    assert!(error.to_string().contains("unit cell"), "{error}");
}

#[test]
fn disorder_becomes_alternate_locations() {
    let text = "data_x\n_cell_length_a 10\n_cell_length_b 10\n_cell_length_c 10\n_space_group_name_H-M_alt 'P 1'\nloop_\n\
        _atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\n_atom_site_disorder_assembly\n\
        _atom_site_disorder_group\n_atom_site_calc_flag\nC1 0 0 0 . . d\nC2A 0 0 0.1 A 1 d\nC2B 0 0 0.2 A 2 d\n\
        O1 0.5 0.5 0.5 . -1 d\nCg1 0.5 0.5 0.6 . . dum\nO1W ? ? ? . . d\n";
    let document = read(text);
    let structure = &document.records[0];
    assert_eq!([0, 1, 2, 3].map(|atom| structure.altloc(atom)), [b' ', b'A', b'B', b'1']);
    assert_eq!((structure.flags(3), structure.flags(4)), (atom_flags::SYMMETRY_DISORDER, atom_flags::PARTICLE));
    assert_eq!(structure.atom_count(), 5);
    assert!(document.diagnostics[0].message.contains("O1W"), "{:?}", document.diagnostics);
}

const LIGAND: &str = "data_FOO\n_chem_comp.id FOO\n_chem_comp.name 'FOO ACID'\nloop_\n_chem_comp_atom.comp_id\n\
    _chem_comp_atom.atom_id\n_chem_comp_atom.type_symbol\n_chem_comp_atom.charge\n_chem_comp_atom.model_Cartn_x\n\
    _chem_comp_atom.model_Cartn_y\n_chem_comp_atom.model_Cartn_z\n_chem_comp_atom.pdbx_model_Cartn_x_ideal\n\
    _chem_comp_atom.pdbx_model_Cartn_y_ideal\n_chem_comp_atom.pdbx_model_Cartn_z_ideal\n\
    FOO C1 C 0 10 10 10 0.1 0.2 0.3\nFOO O1 O -1 11 10 10 1.1 0.2 0.3\nFOO O2 O 0 9 10 10 -1.1 0.2 IDEAL\n\
    loop_\n_chem_comp_bond.comp_id\n_chem_comp_bond.atom_id_1\n_chem_comp_bond.atom_id_2\n_chem_comp_bond.value_order\n\
    _chem_comp_bond.pdbx_aromatic_flag\nFOO C1 O1 SING N\nFOO C1 O2 DOUB Y\nFOO C1 X9 DOUB Y\n";

#[test]
fn ligand_files_are_molecules_with_their_own_bonds() {
    let document = read(&LIGAND.replace("IDEAL", "0.4"));
    let structure = &document.records[0];
    assert_eq!((document.format, structure.title()), (Format::Mmcif, "FOO ACID (FOO), ideal coordinates"));
    assert_eq!(structure.positions().get(0).x as f32, 0.1);
    assert_eq!((structure.formal_charge(1), structure.stated_bonds()), (-1, StatedBonds::Complete));
    let bonds: Vec<_> = structure.bonds().iter().map(|bond| (bond.a, bond.b, bond.order, bond.aromatic)).collect();
    assert_eq!(bonds, [(0, 1, BondOrder::Single, false), (0, 2, BondOrder::Double, true)]);
    assert!(document.diagnostics[0].message.contains("X9"));
    // The ideal coordinates are not whole.
    let model = read(&LIGAND.replace("IDEAL", "?"));
    assert_eq!(model.records[0].title(), "FOO ACID (FOO), model coordinates");
    assert_eq!(model.records[0].atom_count(), 3);
}

#[test]
fn a_file_cut_in_its_rows_keeps_the_whole_ones() {
    let rows = (0..20).map(|n| format!("C {n} 0 0")).collect::<Vec<_>>().join("\n");
    let text = format!("data_x\n{}", sites("type_symbol Cartn_x Cartn_y Cartn_z", &rows));
    let cut = text.find("15 0 0").unwrap() + 4;
    let document = read(&text[..cut]);
    assert_eq!(document.records[0].atom_count(), 15);
    let message = &document.diagnostics[0];
    assert_eq!((message.severity, message.line), (Severity::Error, Some(6 + 15 + 1)));
    assert!(message.message.contains("expected 4 values, found 3"), "{message}");
}

#[test]
fn rows_with_a_value_missing_or_too_many_are_refused_by_line() {
    let rows: Vec<String> = (0..20).map(|n| format!("C {n} 0 0")).collect();
    for odd in ["C 7 0", "C 7 0 0 0"] {
        let mut rows = rows.clone();
        rows[7] = odd.to_owned();
        let text = format!("data_x\n{}", sites("type_symbol Cartn_x Cartn_y Cartn_z", &rows.join("\n")));
        for text in [&text, text.trim_end_matches("#\n")] {
            assert_eq!(refuse(text).line(), Some(6 + 7 + 1), "{odd}");
        }
    }
}

#[test]
fn text_that_never_ends_is_named_by_its_line() {
    let error = refuse("data_x\n_a\n;never\nclosed\n");
    assert_eq!(error.line(), Some(3));
    // Behind the atoms only what follows is lost.
    let text = format!("data_x\n{}_a\n;never", sites("type_symbol Cartn_x Cartn_y Cartn_z", "C 0 0 0"));
    let document = read(&text);
    assert_eq!((document.records[0].atom_count(), document.diagnostics[0].severity), (1, Severity::Error));
}

#[test]
fn odd_files_say_what_is_odd() {
    for (text, word) in [
        (sites("type_symbol Cartn_x Cartn_y Cartn_z", "C 0 0 0"), "expected `data_`"),
        (
            format!("data_x\n_a b c\n{}", sites("type_symbol Cartn_x Cartn_y Cartn_z", "C 0 0 0")),
            "`c` belongs to no name",
        ),
        (format!("data_x\n_a\n{}", sites("type_symbol Cartn_x Cartn_y Cartn_z", "C 0 0 0")), "_a has no value"),
        (format!("data_x\n{}", sites("type_symbol Cartn_x Cartn_y Cartn_z", "C 0 0 0\nC ? 0 0")), "three coordinates"),
        (format!("data_x\n{}", sites("type_symbol Cartn_x Cartn_y Cartn_z", "Qq 0 0 0")), "type symbol `Qq`"),
    ] {
        let document = read(&text);
        let message = document.diagnostics.iter().find(|message| message.message.contains(word));
        assert!(message.is_some_and(|message| message.line.is_some()), "{word}: {:?}", document.diagnostics);
    }
    assert!(refuse("data_x\n_cell.length_a 1\n").to_string().contains("no atoms"));
}

#[test]
fn limits_hold() {
    let rows = vec!["C 0 0 0"; 20].join("\n");
    let text = format!("data_x\n{}", sites("type_symbol Cartn_x Cartn_y Cartn_z", &rows));
    let limits = Limits { atoms: 10, ..Limits::default() };
    let error =
        read_bytes(text.as_bytes(), "a.cif", &ImportOptions { limits, ..ImportOptions::default() }).unwrap_err();
    assert!(matches!(error, Error::Limit { line: Some(17), .. }), "{error}");
    let models: String = (0..20).map(|n| format!("C 0 0 {n} {n}\n")).collect();
    let text = format!("data_x\n{}", sites("type_symbol Cartn_x Cartn_y Cartn_z pdbx_PDB_model_num", &models));
    let limits = Limits { records: 5, ..Limits::default() };
    let document = read_bytes(text.as_bytes(), "a.cif", &ImportOptions { limits, ..ImportOptions::default() }).unwrap();
    assert_eq!((document.frame_count(), document.diagnostics.len()), (5, 1));
}
