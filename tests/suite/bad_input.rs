//! Whatever the bytes are: no panic, on the whole way from bytes to bonds, scene and every structure format.
//!
//! Every molecule in `data/`, binary and compressed ones among them, and every seed below is cut at many points and has bytes changed; headers that promise
//! more than there is stand by themselves. A panic fails the test; results may be anything.

use ballstick::bonds::{self, BondOptions};
use ballstick::crystal::{self, CrystalOptions};
use ballstick::export::formats::FORMATS;
use ballstick::import::{Format, ImportOptions, read_bytes};
use ballstick::render::cpu::CpuRenderer;
use ballstick::render::{Renderer, Settings, View};
use ballstick::scene::{Item, Scene, SceneOptions};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads, and where that gives anything finds bonds, builds the scene and writes: odd structures break there.
fn go_the_whole_way(bytes: &[u8], name: &str, options: &ImportOptions) {
    let Ok(document) = read_bytes(bytes, name, options) else { return };
    // Of many records the first few are as odd as the rest.
    for record in document.records.into_iter().take(3) {
        let molecule = bonds::assign(record, &BondOptions::default());
        let scene = Scene::new(&[Item::of(&molecule)], &SceneOptions::default());
        assert!(scene.fitted_camera(1.5).eye.is_finite(), "{name}");
        for format in FORMATS {
            let records = std::slice::from_ref(&molecule);
            // A sink takes everything; what does not fit the columns of a format is an error of its own.
            let result = (format.write)(records, &mut std::io::sink());
            let refused = result.as_ref().is_err_and(|error| error.to_string().contains("does not fit"));
            assert!(result.is_ok() || refused, "{name} as {}: {result:?}", format.name);
            let _losses = format.losses(records);
        }
    }
}

/// Marsaglia's xorshift64 ("Xorshift RNGs", J. Stat. Soft. 8(14), 2003): the same changes on every machine.
struct Xorshift(u64);

impl Xorshift {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.next() % end.max(1) as u64).unwrap_or(0)
    }
}

/// One small file of each format, with most of what the format can say.
const SEEDS: [(&str, &str); 16] = [
    (
        "seed-macromolecule.cif",
        "data_seed\n_entry.id seed\n_cell.length_a 10\n_cell.length_b 11\n_cell.length_c 12\n_symmetry.space_group_name_H-M 'P 1'\n\
         loop_\n_struct_conn.conn_type_id\n_struct_conn.ptnr1_auth_asym_id\n_struct_conn.ptnr1_auth_seq_id\n\
         _struct_conn.ptnr1_label_atom_id\n_struct_conn.ptnr2_auth_asym_id\n_struct_conn.ptnr2_auth_seq_id\n\
         _struct_conn.ptnr2_label_atom_id\nmetalc A 1 SG A 3 ZN\nloop_\n_chem_comp_bond.comp_id\n_chem_comp_bond.atom_id_1\n\
         _chem_comp_bond.atom_id_2\n_chem_comp_bond.value_order\nCYS SG CB sing\n_struct_conf.conf_type_id HELX_P\n\
         _struct_conf.beg_auth_asym_id A\n_struct_conf.beg_auth_seq_id 1\n_struct_conf.end_auth_seq_id 3\nloop_\n\
         _atom_site.group_PDB\n_atom_site.id\n_atom_site.type_symbol\n_atom_site.auth_atom_id\n_atom_site.label_alt_id\n\
         _atom_site.auth_comp_id\n_atom_site.auth_asym_id\n_atom_site.label_seq_id\n_atom_site.auth_seq_id\n\
         _atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n_atom_site.occupancy\n_atom_site.pdbx_PDB_model_num\n\
         ATOM 1 S SG A CYS A 1 1 0.5 1.25 -2.0 0.5 1\nATOM 2 C \"C'B\" . CYS A 1 1 1.5 1.25 -2.0 1 1\n\
         HETATM 3 ZN ZN . ZN A . 3 2.5 1.25\n;-2.0\n;\n1 1\nATOM 1 S SG A CYS A 1 1 0.5 1.25 -3.0 0.5 2\n#\n",
    ),
    (
        "seed-crystal.cif",
        "#\\#CIF_1.1\ndata_seed\n_cell_length_a 5.0(1)\n_cell_length_b 6\n_cell_length_c 7\n_cell_angle_beta 100.5\n\
         _space_group_name_H-M_alt 'P 1 21 1'\nloop_\n_space_group_symop_operation_xyz\nx,y,z\n'-x, y+1/2, -z'\nloop_\n\
         _atom_site_label\n_atom_site_type_symbol\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\n\
         _atom_site_U_iso_or_equiv\n_atom_site_disorder_assembly\n_atom_site_disorder_group\n_atom_site_calc_flag\n\
         Fe1 Fe3+ 0.1(2) 0.25 0.5 0.02 . . d\nO1 O2- 0.3 0.25 0.5 0.02 A 1 d\nO2 O2- 0.3 0.35 0.5 ? A -2 dum\n",
    ),
    (
        "seed.pdb",
        "HEADER    TEST\nTITLE     TEST\nCRYST1   10.000   11.000   12.000  90.00  91.00  92.00 P 1           1\n\
         HELIX    1   1 SER A    1  GLY A    2  1                                   2\n\
         SSBOND   1 CYS A    1    CYS A    2                          1555   1555  2.03\n\
         LINK         SG  CYS A   1                ZN    ZN A   3     1555   1555  2.30\nMODEL        1\n\
         ATOM  99999  SG ACYS A   1A     11.104   6.134  -6.504  0.50 10.00           S1-\n\
         ATOM  A0000  SG  CYS A   2      12.104   6.134  -6.504  1.00 10.00           S\n\
         HETATM186a0 ZN    ZN A   3      13.104   6.134  -6.504  1.00 10.00\n\
         CONECT99999A0000A0000\nENDMDL\nMODEL        2\n\
         ATOM  99999  SG ACYS A   1A     11.104   6.134  -6.504  0.50 10.00           S1-\nENDMDL\nEND\n",
    ),
    (
        "seed.xyz",
        "2\nLattice=\"5 0 0 0 5 0 0 0 5\" Properties=species:S:1:pos:R:3:forces:R:3:ok:L:1 e=\"a b\"\n\
         C 0.0 0.0 0.0 1 2 3 T\nO 1.2 0.0 0.0 1 2 3 F\n2\nplain\n6 0.0D0 0 0 1 2 3\nO1 1.2 0 0 1 2 3\n",
    ),
    (
        "seed.sdf",
        "name\n prog\n\n  3  2  0  0  0  0  0  0  0  0999 V2000\n\
         \x20   0.0000    0.0000    0.0000 C   1  3  0  0  0  0\n\
         \x20   1.0000    0.0000    0.0000 R#  0  0  0  0  0  0\n\
         \x20   2.0000    0.0000    0.0000 D   0  4  0  0  0  0\n\
         \x20 1  2  2  3\n  2  3  4  1\nM  CHG  1   1  -1\nM  ISO  1   3   2\nA    1\nR\nM  END\n\
         > <X>\n1\n2\n\n$$$$\n",
    ),
    (
        "seed.json",
        r#"{"title":"t","atoms":[{"element":"C","position":[0,0.5,1e0],"charge":1,"residue":"A","chain":"é"},
        {"element":8,"position":[1,2,3],"name":"O1"}],"bonds":[{"atoms":[0,1],"order":1.5,"kind":"dative","source":"link"}],
        "cell":{"a":1,"b":2,"c":3,"alpha":90,"beta":90,"gamma":90}}"#,
    ),
    (
        "seed.cjson",
        r#"{"chemicalJson":1,"atoms":{"elements":{"number":[6,8]},"coords":{"3d":[0,0,0,1,0,0],
        "3dSets":[[0,0,0,1,0,0],[0,0,0,2,0,0]]},"formalCharges":[0,-1],"labels":["a","b"]},
        "bonds":{"connections":{"index":[0,1]},"order":[2]},"unitCell":{"cellVectors":[1,0,0,0,1,0,0,0,1]}}"#,
    ),
    (
        "seed-imolecule.json",
        r#"{"atoms":[{"element":"H","location":[0,0,0]},{"element":"H","location":[0,0,0.7]}],
        "bonds":[{"atoms":[0,1],"order":1}],"unitcell":[[1,0,0],[0,1,0],[0,0,1]]}"#,
    ),
    (
        "seed-v3000.sdf",
        "name\n prog\n\n  0  0  0     0  0            999 V3000\nM  V30 BEGIN CTAB\nM  V30 COUNTS 4 4 1 0 0\n\
         M  V30 BEGIN ATOM\nM  V30 1 C 0 0 0 0 CHG=-1 RAD=2 MASS=13\nM  V30 2 \"NOT[N,O]\" 1 0 0 0\n\
         M  V30 7 Fe 2 0 -\nM  V30 0 0 VAL=-1\nM  V30 4 * 3 0 0 0 RGROUPS=(1 1)\nM  V30 END ATOM\nM  V30 BEGIN BOND\n\
         M  V30 1 4 1 2 CFG=1\nM  V30 2 9 4 7 ENDPTS=(2 1 2) ATTACH=ALL\nM  V30 3 2 1 4 CFG=2\nM  V30 4 10 2 4\n\
         M  V30 END BOND\nM  V30 BEGIN SGROUP\nM  V30 1 DAT 0 ATOMS=(1 1) FIELDNAME=\"a b\"\nM  V30 END SGROUP\n\
         M  V30 END CTAB\nM  END\n> <X>\n1\n\n$$$$\n",
    ),
    (
        "seed.mol2",
        "# comment\n@<TRIPOS>MOLECULE\nname\n 4 4 2\nSMALL\nUSER_CHARGES\n\n@<TRIPOS>ATOM\n1 CA 0 0 0 C.3 1 ALA12 0.5\n\
         2 N 1 0 0 N.am 1 ALA12 \\\n-0.5 BACKBONE\n5 LP 2 0 0 LP 2 ****\n7 ZN 3 0 0 Zn 2 ZN-3A 2.0\n@<TRIPOS>BOND\n1 1 2 am\n\
         2 2 5 du\n3 2 7 un\n4 1 7 ar\n@<TRIPOS>SUBSTRUCTURE\n1 ALA12 1 RESIDUE 4 B ALA 1 ROOT\n2 ZN-3A 7 GROUP 4 C ZN\n\
         @<TRIPOS>UNITY_ATOM_ATTR\n7 1\ncharge 2\n@<TRIPOS>CRYSIN\n10 11 12 90 91 92 1 1\n@<TRIPOS>MOLECULE\nb\n1 0\nX\nY\n\
         @<TRIPOS>ATOM\n1 C1 0 0 0 ca\n",
    ),
    (
        "seed-qcschema.json",
        r#"{"schema_name":"qcschema_input","molecule":{"symbols":["O","H","He"],"geometry":[0,0,0,[1.5,0,0],0,2,0],
        "connectivity":[[0,1,1.5]],"real":[true,true,false],"mass_numbers":[18,2,4],"atom_labels":["","a",""],"name":"n"}}"#,
    ),
    (
        "seed-pubchem.json",
        r#"{"PC_Compounds":[{"id":{"id":{"cid":7}},"atoms":{"aid":[2,1],"element":[6,255],"charge":[{"aid":1,"value":-1}],
        "isotope":[{"aid":2,"value":13}],"radical":[{"aid":2,"type":2}]},"bonds":{"aid1":[1],"aid2":[2],"order":[6]},
        "coords":[{"type":[2],"aid":[1,2],"conformers":[{"x":[1,2],"y":[0,0],"z":[0,0],"style":{"annotation":[5],"aid1":[2],
        "aid2":[1]}},{"x":[1,3],"y":[0,0],"z":[0,0]}]}],"props":[{"urn":{"label":"IUPAC Name"},"value":{"sval":"x"}}]}]}"#,
    ),
    (
        "seed-chemdoodle.json",
        r#"{"m":[{"a":[{"x":0,"y":0},{"l":"O","x":20,"y":2e1,"z":0,"c":-1,"r":1,"m":18}],"b":[{"b":0,"e":1,"o":2,"s":"recessed"}]},
        {"a":[{"l":"Zz","x":1,"y":2,"z":3}]}],"s":[]}"#,
    ),
    (
        "POSCAR",
        "Ti O\n-62.0\n4.5 0 0\n0 4.5 0\n0 0 3.0\nTi_sv O/1a\n1 2\nSelective dynamics\nDirect\n0 0 0 T T F\n\
         0.3 0.3 0.0 F F F\n0.7 0.7 0.0\nLattice velocities and vectors\n1\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n\
         Cartesian\n0 0 0.1\n0 0 0\n0 0 1E-3\n",
    ),
    (
        "seed.cube",
        "water\ndensity\n-3 -1.0 -1.0 -1.0 1\n2 0.5 0 0\n2 0 0.5 0\n2 0 0 0.5\n8 8.0 0 0 0.2\n1 1.0 0 1.4 -0.9\n\
         0 0.0 0 -1.4 -0.9\n1 5\n1.0E-3 2.0 3.0 4.0 5.0 6.0\n7.0 8.0\n",
    ),
    (
        "seed.gro",
        "t= 0.0\n3\n99999SOL     OW99999   0.126   1.624   1.679  0.1227 -0.0580  0.0434\n\
         \x20   0ION     NA    0   0.190   1.661   1.747  0.8085  0.3191 -0.7791\n\
         \x20   1LYS    MNZ    1   0.177   1.568   1.613 -0.9045 -2.6469  1.3180\n\
         1.8 1.8 1.8 0 0 0.5 0 0.5 0.5\nt= 1.0\n1\n    1SOL     OW    1   0.126   1.624   1.679\n1 1 1\n",
    ),
];

/// Larger files are left out: each is read two hundred times.
const MAX_BYTES: u64 = 256 << 10;

fn data_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            data_files(&path, found);
        } else if entry.metadata().is_ok_and(|metadata| metadata.len() <= MAX_BYTES) {
            found.push(path);
        }
    }
    found.sort();
}

/// Atoms of the largest molecule that is drawn again and again.
const MOST_DRAWN: usize = 3000;

/// Draws what can be read into a small picture: nothing in it is no number.
fn draw(bytes: &[u8], name: &str, renderer: &mut CpuRenderer) {
    let Ok(document) = read_bytes(bytes, name, &ImportOptions::default()) else { return };
    let Some(record) = document.records.into_iter().next().filter(|record| record.atom_count() <= MOST_DRAWN) else {
        return;
    };
    let options = CrystalOptions { most_atoms: 2 * MOST_DRAWN, ..CrystalOptions::default() };
    let Ok(drawn) = crystal::draw(record, &options) else { return };
    let scene = Arc::new(Scene::new(&[Item::drawn(&drawn, None)], &SceneOptions::default()));
    let view = View::new(scene.fitted_camera(1.0), 64, 64);
    renderer.load(scene).unwrap();
    let settings = Settings { samples: 1, ground_texels: 64, ao: 8, shadow: true };
    assert_eq!(renderer.image(&view, &settings).unwrap().rgba.len(), 64 * 64 * 4);
    let surface = renderer.gbuffer(&view).unwrap();
    assert!(surface.depth.iter().all(|depth| !depth.is_nan() && *depth > 0.0), "{name}");
    assert!(surface.normal.iter().flatten().all(|part| part.is_finite() && part.abs() <= 1.001), "{name}");
    assert!(renderer.sky_visibility(&view, 4).unwrap().open.iter().all(|open| (0.0..=1.0).contains(open)), "{name}");
}

/// Cuts and changes a file in two hundred ways; draws one in ten.
fn torment(name: &str, bytes: &[u8]) {
    let options = ImportOptions::default();
    let mut renderer = CpuRenderer::new();
    for point in 0..100 {
        let part = &bytes[..bytes.len() * point / 100];
        go_the_whole_way(part, name, &options);
        if point % 10 == 9 {
            draw(part, name, &mut renderer);
        }
    }
    let mut random = Xorshift(0x9E37_79B9_7F4A_7C15);
    for round in 0..100 {
        let mut changed = bytes.to_vec();
        for _ in 0..=random.below(8) {
            let (at, bit) = (random.below(changed.len()), random.below(8));
            if let Some(byte) = changed.get_mut(at) {
                *byte ^= 1 << bit;
            }
        }
        go_the_whole_way(&changed, name, &options);
        if round % 10 == 0 {
            draw(&changed, name, &mut renderer);
        }
    }
}

#[test]
fn data_files_may_be_cut_and_changed_anywhere() {
    let mut files = Vec::new();
    data_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data"), &mut files);
    let mut tried = 0;
    for path in files {
        let bytes = std::fs::read(&path).expect("files in data/ can be read");
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if read_bytes(&bytes, &name, &ImportOptions::default()).is_ok() {
            torment(&name, &bytes);
            tried += 1;
        }
    }
    println!("tried {tried} files");
    assert!(tried > 0, "no file in data/ could be read");
}

#[test]
fn seeds_of_all_formats_may_be_cut_and_changed_anywhere() {
    let mut formats = std::collections::HashSet::new();
    for (name, text) in SEEDS {
        let document = read_bytes(text.as_bytes(), name, &ImportOptions::default()).expect(name);
        formats.insert(document.format);
        torment(name, text.as_bytes());
    }
    // BinaryCIF is no text: its seed is the file in `data/`.
    formats.insert(Format::BinaryCif);
    assert_eq!(formats.len(), Format::ALL.len(), "every format has a seed: {formats:?}");
}

#[test]
fn any_bytes_may_claim_any_format() {
    let mut random = Xorshift(42);
    for format in Format::ALL {
        let options = ImportOptions { format: Some(format), ..ImportOptions::default() };
        for length in [0, 1, 7, 80, 4000] {
            let bytes: Vec<u8> = (0..length).map(|_| random.next().to_le_bytes()[0]).collect();
            go_the_whole_way(&bytes, "", &options);
        }
        for (_, seed) in SEEDS {
            go_the_whole_way(seed.as_bytes(), "", &options);
        }
    }
}

#[test]
fn headers_that_promise_too_much_are_refused() {
    let deep = format!("{{\"x\":{}", "[".repeat(1_000_000));
    let cells = "{\"atoms\":{\"elements\":{\"number\":[1]},\"coords\":{\"3d\":[0,0]}}}";
    let columns = format!("1\nProperties=species:S:1:pos:R:3:x:R:{}\nC 0 0 0\n", u64::MAX);
    let line = format!("1\n\nC 0 0 0{}\n", " ".repeat(2 << 20));
    for text in [
        "4294967295\n\nC 0 0 0\n",
        "18446744073709551616\n\nC 0 0 0\n",
        "-1\n\nC 0 0 0\n",
        "0\n\n",
        "\n\n\n999999  0  0  0  0  0  0  0  0  0999 V2000\n",
        "\n\n\n999999  0  0  0  0999 V2000\n    0.0000    0.0000    0.0000 C\n",
        "\n\n\n -1 -1  0  0  0  0  0  0  0  0999 V2000\nM  END\n",
        "ATOM      1  C\n",
        "t\n4294967295\n    1SOL     OW    1   0.126   1.624   1.679\n",
        "x\n1.0\n4 0 0\n0 4 0\n0 0 4\nTi O\n1 99999999999\nDirect\n0 0 0\n",
        "\u{1}\u{1}\n-9223372036854775808 0 0 0\n2 1 0 0\n2 0 1 0\n2 0 0 1\n",
        "MODEL\nENDMDL\n",
        "{",
        "{\"atoms\":1}",
        "\0\0\0\0\0\0\0\0",
        &deep,
        cells,
        &line,
        "",
    ] {
        let result = read_bytes(text.as_bytes(), "x", &ImportOptions::default());
        assert!(result.is_err(), "{:?}", &text[..text.len().min(60)]);
    }
    let _any = read_bytes(columns.as_bytes(), "x.xyz", &ImportOptions::default());
}
