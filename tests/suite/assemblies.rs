//! Assemblies: the picture of copies is the picture of copied atoms, on both renderers, and the program's way with them.

use crate::cli::Case;
use ballstick::bonds;
use ballstick::crystal::{self, AssemblyId, CrystalOptions, Drawn};
use ballstick::export::formats::StructureFormat;
use ballstick::render::cpu::{CpuRenderer, reference};
use ballstick::render::{GBuffer, Renderer, Settings, View};
use ballstick::scene::{Item, Pose, Scene, SceneOptions, Style};
use ballstick::structure::Structure;
use glam::{DVec3, Quat};
use std::sync::Arc;

/// Two residues in two chains with a disulfide between them, a zinc beside, and a water that no assembly has. Assembly 1 turns chain A and the
/// zinc about z three times and mirrors them, chain B only twice; assembly 2 is a product.
pub(crate) fn file() -> String {
    let atoms = [
        "ATOM 1 C CA CYS A A 1 4.0 0.0 0.0",
        "ATOM 2 C CB CYS A A 1 5.2 0.8 0.3",
        "ATOM 3 S SG CYS A A 1 6.6 0.1 1.2",
        "ATOM 4 S SG CYS B B 1 7.2 1.4 2.6",
        "ATOM 5 C CB CYS B B 1 8.8 0.9 3.2",
        "ATOM 6 C CA CYS B B 1 9.6 2.0 3.9",
        "HETATM 7 ZN ZN ZN C A . 4.0 -3.5 0.5",
        "HETATM 8 O O HOH D A . 20.0 20.0 20.0",
    ];
    let mut text = "data_ring\nloop_\n".to_owned();
    for item in [
        "group_PDB",
        "id",
        "type_symbol",
        "label_atom_id",
        "label_comp_id",
        "label_asym_id",
        "auth_asym_id",
        "label_seq_id",
        "Cartn_x",
        "Cartn_y",
        "Cartn_z",
    ] {
        text += &format!("_atom_site.{item}\n");
    }
    text += &atoms.join("\n");
    text += "\n#\nloop_\n_pdbx_struct_assembly_gen.assembly_id\n_pdbx_struct_assembly_gen.oper_expression\n\
             _pdbx_struct_assembly_gen.asym_id_list\n1 1-3,M A,C\n1 1,2 B\n2 (1,S)(1-3) A,B,C\n#\nloop_\n_pdbx_struct_oper_list.id\n";
    for row in 1..=3 {
        for column in 1..=3 {
            text += &format!("_pdbx_struct_oper_list.matrix[{row}][{column}]\n");
        }
        text += &format!("_pdbx_struct_oper_list.vector[{row}]\n");
    }
    let (c, s) = (-0.5, 3f64.sqrt() / 2.0);
    text += "1 1 0 0 0 0 1 0 0 0 0 1 0\n";
    text += &format!("2 {c} {} 0 0 {s} {c} 0 0 0 0 1 0\n3 {c} {s} 0 0 {} {c} 0 0 0 0 1 0\n", -s, -s);
    text + "M 1 0 0 0 0 1 0 0 0 0 -1 -6\nS 1 0 0 0 0 1 0 0 0 0 1 12.5\n#\n"
}

fn structure() -> Structure {
    let document = ballstick::import::read_bytes(file().as_bytes(), "ring.cif", &Default::default()).unwrap();
    assert!(document.diagnostics.is_empty(), "{:?}", document.diagnostics);
    document.records[0].clone()
}

fn options(style: Style) -> SceneOptions {
    let pose = Some(Pose { center: DVec3::ZERO, turn: Quat::from_rotation_x(-0.9), pitch_rad: 0.2 });
    SceneOptions { style, pose, ..SceneOptions::default() }
}

fn assembly(id: &str) -> Drawn {
    let options = CrystalOptions { assembly: AssemblyId::new(id), ..CrystalOptions::default() };
    crystal::draw(structure(), &options).unwrap()
}

/// Copies as placements, and the scene of the same atoms copied.
pub(crate) fn scenes(id: &str, style: Style) -> (Scene, Scene) {
    let drawn = assembly(id);
    let bonded = bonds::assign(structure(), &Default::default());
    let copied = bonded.assembled(bonded.assembly(id).unwrap());
    (Scene::new(&[Item::drawn(&drawn, None)], &options(style)), Scene::new(&[Item::of(&copied)], &options(style)))
}

#[test]
fn copies_are_the_picture_of_copied_atoms() {
    let settings = Settings { samples: 4, ground_texels: 96, ao: 16, shadow: true };
    for (id, style) in [("1", Style::BallAndStick), ("1", Style::Licorice), ("2", Style::BallAndStick)] {
        let (placed, copied) = scenes(id, style);
        assert!(placed.blocks.len() < placed.placements.len());
        assert_eq!((placed.sphere_count(), placed.cylinder_count()), (copied.sphere_count(), copied.cylinder_count()));
        assert!((placed.bounds().min - copied.bounds().min).abs().max_element() < 1e-4);
        let camera = copied.fitted_camera(1.5);
        assert!((placed.fitted_camera(1.5).eye - camera.eye).length() < 1e-2);
        let view = View::new(camera, 240, 160);
        let (got, want) = (reference::gbuffer(&placed, &view), reference::gbuffer(&copied, &view));
        let (mut covered, mut off) = (0, 0);
        for pixel in 0..want.id.len() {
            let [one, other] = [got.depth[pixel], want.depth[pixel]];
            off += usize::from(one != other && (one - other).abs().is_nan() | ((one - other).abs() > 1e-2));
            let is_item = |buffer: &GBuffer| !matches!(buffer.id[pixel], GBuffer::BACKGROUND | GBuffer::GROUND);
            covered += usize::from(is_item(&got) && is_item(&want));
        }
        assert!(off < 20, "{id} {style:?}: {off} depths");
        assert!(covered > 1000, "{covered}");
        let mut cpu = CpuRenderer::new();
        let pictures = [&placed, &copied].map(|scene| {
            cpu.load(Arc::new(scene.clone())).unwrap();
            [reference::image(scene, &view, &settings), cpu.image(&view, &settings).unwrap()]
        });
        for (how, (got, want)) in ["reference", "tiles"].iter().zip(pictures[0].iter().zip(&pictures[1])) {
            let apart = got.rgba.iter().zip(&want.rgba).map(|(a, b)| f64::from(a.abs_diff(*b)));
            let (sum, many) = apart.fold((0.0, 0usize), |(sum, many), d| (sum + d, many + usize::from(d > 8.0)));
            // Rounding moves a sample at an edge here and there.
            let mean = sum / got.rgba.len() as f64;
            assert!(mean < 0.1 && many < got.rgba.len() / 200, "{id} {style:?} {how}: {mean} {many}");
        }
    }
}

#[test]
fn ids_in_the_picture_tell_copy_and_atom() {
    let drawn = assembly("1");
    let (placed, _) = scenes("1", Style::SpaceFilling);
    let view = View::new(placed.fitted_camera(1.0), 160, 160);
    let mut copies = std::collections::BTreeSet::new();
    for id in reference::gbuffer(&placed, &view).id {
        if matches!(id, GBuffer::BACKGROUND | GBuffer::GROUND) {
            continue;
        }
        let (item, copy, own) = placed.item_of(id).unwrap();
        assert_eq!(item, 0);
        copies.insert(copy);
        // No copy of the water, and chain B only in the first two.
        assert_ne!(own, 7);
        assert!(!(3..6).contains(&own) || copy < 2, "atom {own} of copy {copy}");
        if own < 8 {
            let position = drawn.position(copy * 8 + own).unwrap();
            let there = placed.pose.turn * (position - placed.pose.center).as_vec3();
            assert!(placed.ball(id).unwrap().0.distance(there) < 1e-3);
        }
    }
    assert_eq!(copies.len(), 4, "{copies:?}");
    assert_eq!(drawn.counts(), [4 * 4 + 2 * 3, 2 * 4 + 2 * 2 + 2]);
}

#[cfg(feature = "gpu")]
#[test]
fn gpu_and_cpu_draw_the_same_assembly() {
    let Some(mut gpu) = crate::parity::gpu() else { return };
    for (id, style) in [("1", Style::BallAndStick), ("2", Style::SpaceFilling)] {
        let (placed, _) = scenes(id, style);
        let view = View::new(placed.fitted_camera(1.5), 300, 200);
        crate::parity::judge_whole(&mut gpu, "assembly", &Arc::new(placed), &view).unwrap();
    }
}

#[test]
fn large_supercells_of_whole_molecules_are_one_cell_and_its_places() {
    // Methane in a cell of 9 Å: 28³ cells are more than are copied.
    let text = "data_m\n_cell_length_a 9\n_cell_length_b 10\n_cell_length_c 11\n_cell_angle_alpha 90\n_cell_angle_beta 90\n\
        _cell_angle_gamma 100\nloop_\n_symmetry_equiv_pos_as_xyz\nx,y,z\nloop_\n_atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n\
        _atom_site_fract_z\nC1 0.02 0.5 0.5\nH1 0.12 0.5 0.5\nH2 -0.02 0.61 0.5\nH3 -0.02 0.45 0.59\nH4 -0.02 0.45 0.41\n";
    let read =
        || ballstick::import::read_bytes(text.as_bytes(), "m.cif", &Default::default()).unwrap().records[0].clone();
    let drawn = |supercell| crystal::draw(read(), &CrystalOptions { supercell, ..CrystalOptions::default() }).unwrap();
    let (few, many) = (drawn([3, 2, 2]), drawn([28, 28, 28]));
    assert!(few.copies.is_none() && few.structure.atom_count() == 60);
    assert_eq!((many.structure.atom_count(), many.stubs.len()), (5, 0));
    assert_eq!(many.counts(), [5 * 28 * 28 * 28, 4 * 28 * 28 * 28]);
    assert!(many.is_cell_content && (many.cell.unwrap().lengths()[2] - 308.0).abs() < 1e-6);
    // The same atoms in the same places as where they are copied.
    let place = |drawn: &Drawn, atom: u32| drawn.position(atom).unwrap();
    let copied: Vec<DVec3> = (0..60).map(|atom| place(&few, atom)).collect();
    for cell in 0..2 * 28 * 28u32 {
        let [i, j, k] = [cell / (28 * 28), cell / 28 % 28, cell % 28];
        if i < 3 && j < 2 && k < 2 {
            for own in 0..5 {
                let at = place(&many, cell * 5 + own);
                assert!(copied.iter().any(|other| other.distance(at) < 1e-4), "{at}");
            }
        }
    }
}

#[test]
fn assemblies_are_written_in_both_formats_of_the_pdb() {
    let structure = structure();
    for name in ["mmcif", "pdb"] {
        let format = StructureFormat::from_name(name).unwrap();
        let mut bytes = Vec::new();
        (format.write)(std::slice::from_ref(&structure), &mut bytes).unwrap();
        let read = ballstick::import::read_bytes(&bytes, &format!("a.{name}"), &Default::default()).unwrap();
        let got = read.records[0].assemblies();
        // The water shares its author's chain with the rest: assemblies without it are of parts of chains.
        assert_eq!(got.len(), 0, "{name}");
        assert!(format.losses(std::slice::from_ref(&structure)).iter().any(|loss| loss.contains("parts of chains")));
        let whole = structure.subset(&[true, true, true, true, true, true, true, false]);
        let mut bytes = Vec::new();
        (format.write)(std::slice::from_ref(&whole), &mut bytes).unwrap();
        let read = ballstick::import::read_bytes(&bytes, &format!("a.{name}"), &Default::default()).unwrap();
        let ids: Vec<(&str, usize)> =
            read.records[0].assemblies().iter().map(|one| (one.id.as_str(), one.atom_count(7))).collect();
        assert_eq!(ids, [("1", 22), ("2", 42)], "{}", String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn the_program_lists_draws_and_writes_assemblies() {
    let case = Case::new(&[("ring.cif", &file()), ("water.xyz", crate::cli::WATER)]);
    let info = case.run(&["info", "ring.cif"]).status(0).out();
    assert!(info.contains("1: 4 copies, 22 atoms; chains A, B"), "{info}");
    let json: serde_json::Value =
        serde_json::from_str(&case.run(&["info", "--json", "ring.cif"]).status(0).out()).unwrap();
    assert_eq!((&json["assemblies"][1]["id"], &json["assemblies"][1]["copies"]), (&"2".into(), &6.into()));
    case.run(&["convert", "ring.cif", "all.cif", "--assembly", "2"]).status(0);
    let json: serde_json::Value =
        serde_json::from_str(&case.run(&["info", "--json", "all.cif"]).status(0).out()).unwrap();
    assert_eq!((&json["atoms"], &json["chains"]), (&42.into(), &12.into()));
    let quick = ["--size", "64x48", "--quality", "draft", "--renderer", "cpu", "--timings"];
    let render = |more: &[&str]| case.run(&["render"].iter().chain(more).chain(&quick).copied().collect::<Vec<_>>());
    let said = render(&["ring.cif", "-o", "ring.png", "--assembly", "1"]).status(0).err();
    assert!(said.contains("\"atom_count\":22") && !said.contains("warning"), "{said}");
    let again = render(&["--from", "ring.png", "-o", "again.png"]).status(0);
    assert_eq!(
        std::fs::read(case.path("ring.png")).unwrap(),
        std::fs::read(case.path("again.png")).unwrap(),
        "{}",
        again.err()
    );
    let none = render(&["--from", "ring.png", "-o", "none.png", "--assembly", "none"]).status(0).err();
    assert!(none.contains("\"atom_count\":8"), "{none}");
    let wrong = render(&["ring.cif", "-o", "x.png", "--assembly", "7"]).status(1).err();
    assert!(wrong.contains("no assembly 7; the file has 1, 2"), "{wrong}");
    let without = render(&["water.xyz", "-o", "water.png", "--assembly", "1"]).status(0).err();
    assert!(without.contains("the file states no assemblies"), "{without}");
}
