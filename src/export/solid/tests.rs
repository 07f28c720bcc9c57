//! Files read by readers that are not ours: the crates `gltf` and `tobj`; STL and PLY by their definitions.

use super::*;
use crate::color::Srgb8;
use crate::scene::{
    Block, Cap, ConeInstance, CylinderInstance, Item, Placement, SceneOptions, SphereInstance, TorusInstance,
    TriangleInstance, VectorChoice,
};
use glam::{Affine3A, Mat4, Quat, Vec3};
use std::collections::HashMap;
use std::f64::consts::PI;

const RED: Srgb8 = Srgb8::rgb(255, 0, 0);
const GLASS: Srgb8 = Srgb8 { r: 0, g: 128, b: 255, a: 64 };

/// One of each primitive, apart from one another, turned and moved.
fn scene() -> Scene {
    let block = Block {
        spheres: vec![SphereInstance { center: [0.0; 3], radius: 0.5, color: RED, id: 1 }],
        cylinders: vec![
            CylinderInstance {
                a: [2.0, 0.0, 0.0],
                radius: 0.1,
                b: [2.0, 3.0, 1.0],
                id: 2,
                color_a: RED,
                color_b: Srgb8::rgb(0, 0, 200),
                caps: CylinderInstance::pack_caps(Cap::Flat, Cap::Round),
                hidden: 0,
            },
            CylinderInstance {
                a: [3.0, 0.0, 0.0],
                radius: 0.2,
                b: [3.0, 0.0, -2.0],
                id: 3,
                color_a: GLASS,
                color_b: GLASS,
                caps: CylinderInstance::pack_caps(Cap::Flat, Cap::Flat),
                hidden: 0,
            },
        ],
        cones: vec![ConeInstance {
            a: [5.0, 0.0, 0.0],
            radius_a: 0.4,
            b: [5.0, 1.0, 0.0],
            radius_b: 0.0,
            color: RED,
            id: 4,
            reserved: [0; 2],
        }],
        tori: vec![TorusInstance {
            center: [0.0, 5.0, 0.0],
            ring_radius: 1.0,
            axis: [0.0, 0.6, 0.8],
            tube_radius: 0.1,
            color: RED,
            id: 5,
            reserved: [0; 2],
        }],
        triangles: vec![TriangleInstance {
            corners: [[9.0, 0.0, 0.0], [10.0, 0.0, 0.0], [9.0, 1.0, 0.0]],
            normals: [[0.0, 0.0, 1.0]; 3],
            colors: [RED, Srgb8::rgb(0, 255, 0), GLASS],
            id: 6,
            reserved: [0; 2],
        }],
        id_count: 6,
    };
    let turn = Quat::from_rotation_z(0.5) * Quat::from_rotation_x(1.0);
    let world_from_block = Affine3A::from_rotation_translation(turn, Vec3::new(1.0, 2.0, 3.0));
    let mut scene = Scene::from_blocks(vec![block], vec![Placement { block: 0, world_from_block, first_id: 0 }]);
    scene.pose.turn = turn;
    scene.pose.center = glam::DVec3::new(100.0, 0.0, 0.0);
    scene
}

/// What a file says, as triangles with a colour each.
#[derive(Debug, Default)]
struct Read {
    triangles: Vec<([Vec3; 3], [f32; 4])>,
}

impl Read {
    fn volume(&self) -> f64 {
        let of = |corners: &[Vec3; 3]| {
            let [a, b, c] = corners.map(|corner| corner.as_dvec3());
            a.dot(b.cross(c)) / 6.0
        };
        self.triangles.iter().map(|(corners, _)| of(corners)).sum()
    }

    fn bounds(&self) -> [Vec3; 2] {
        let corners = self.triangles.iter().flat_map(|(corners, _)| corners);
        corners.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], &p| [low.min(p), high.max(p)])
    }
}

/// By the crate `gltf`, whose validation the file passes; instances by the extension's words.
fn read_gltf(bytes: &[u8]) -> Read {
    use base64::Engine;
    let ::gltf::Gltf { document, blob } = ::gltf::Gltf::from_slice_without_validation(bytes).unwrap();
    // The crate knows the extension by no name: all else must be sound.
    let json = document.as_json();
    let mut errors = Vec::new();
    let no_extension = gltf_json::Root { extensions_required: Vec::new(), ..json.clone() };
    gltf_json::validation::Validate::validate(
        &no_extension,
        &no_extension,
        gltf_json::Path::new,
        &mut |path, error| {
            errors.push(format!("{}: {error:?}", path()));
        },
    );
    assert!(errors.is_empty(), "{errors:?}");
    let buffer = blob.unwrap_or_else(|| {
        let uri = json.buffers[0].uri.as_deref().unwrap();
        base64::engine::general_purpose::STANDARD.decode(uri.split_once(',').unwrap().1).unwrap()
    });
    assert_eq!(buffer.len() as u64, json.buffers[0].byte_length.0);
    let accessor = |index: u64| document.accessors().nth(index as usize).unwrap();
    let floats = |index: u64| -> Vec<Vec<f32>> {
        let accessor = accessor(index);
        let view = accessor.view().unwrap();
        let size = accessor.size();
        let bytes = &buffer[view.offset()..view.offset() + view.length()];
        let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
        bytes.chunks_exact(size).map(|one| one.chunks_exact(4).map(number).collect()).collect()
    };
    let mut read = Read::default();
    let mut stack: Vec<(::gltf::Node<'_>, Mat4)> =
        document.default_scene().unwrap().nodes().map(|node| (node, Mat4::IDENTITY)).collect();
    while let Some((node, from_parent)) = stack.pop() {
        let here = from_parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        stack.extend(node.children().map(|child| (child, here)));
        let Some(mesh) = node.mesh() else { continue };
        let instances = match node.extension_value("EXT_mesh_gpu_instancing") {
            None => vec![Mat4::IDENTITY],
            Some(value) => {
                let column = |name: &str| floats(value["attributes"][name].as_u64().unwrap());
                let (t, r, s) = (column("TRANSLATION"), column("ROTATION"), column("SCALE"));
                (0..t.len())
                    .map(|i| {
                        let [x, y, z, w] = r[i][..] else { panic!() };
                        let rotation = Quat::from_xyzw(x, y, z, w);
                        assert!((rotation.length() - 1.0).abs() < 1e-5);
                        let v = |numbers: &[f32]| Vec3::from_slice(numbers);
                        Mat4::from_scale_rotation_translation(v(&s[i]), rotation, v(&t[i]))
                    })
                    .collect()
            }
        };
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|_| Some(buffer.as_slice()));
            let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
            let normals: Vec<Vec3> = reader.read_normals().unwrap().map(Vec3::from).collect();
            let bounds = primitive.bounding_box();
            let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
            let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
            assert_eq!((Vec3::from(bounds.min), Vec3::from(bounds.max)), (low, high));
            let colors: Option<Vec<[f32; 4]>> = reader.read_colors(0).map(|all| all.into_rgba_f32().collect());
            let factor = primitive.material().pbr_metallic_roughness().base_color_factor();
            let is_blended = primitive.material().alpha_mode() == ::gltf::material::AlphaMode::Blend;
            let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
            for instance in &instances {
                for corner in corners.chunks_exact(3) {
                    let own = colors.as_ref().map_or([1.0; 4], |colors| colors[corner[0] as usize]);
                    let color = [0, 1, 2, 3].map(|i| own[i] * factor[i]);
                    assert_eq!(color[3] < 1.0, is_blended);
                    let at = [0, 1, 2].map(|i| (here * *instance).transform_point3(positions[corner[i] as usize]));
                    let faces = (positions[corner[1] as usize] - positions[corner[0] as usize])
                        .cross(positions[corner[2] as usize] - positions[corner[0] as usize]);
                    let mean: Vec3 = corner.iter().map(|&i| normals[i as usize]).sum();
                    assert!(faces.dot(mean) > 0.0, "a triangle faces inwards");
                    read.triangles.push((at, color));
                }
            }
        }
    }
    read
}

fn written(format: SolidFormat, scene: &Scene, options: &SolidOptions) -> (tempfile::TempDir, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("scene.{}", format.name()));
    let told = write(format, scene, &[], options, &path).unwrap();
    assert!(told.triangles > 0);
    let bytes = std::fs::read(&path).unwrap();
    (folder, bytes)
}

/// What the primitives of [`scene`] take up.
fn true_volume() -> f64 {
    let length = 10.0f64.sqrt();
    let half_ball = 2.0 / 3.0 * PI * 1e-3;
    4.0 / 3.0 * PI * 0.125 + PI * 0.01 * length + half_ball + PI * 0.04 * 2.0 + PI * 0.16 / 3.0 + 2.0 * PI * PI * 0.01
}

#[test]
fn glb_and_gltf_with_instances_or_plain_are_one_scene() {
    let scene = scene();
    let mut seen: Vec<Read> = Vec::new();
    for format in [SolidFormat::Glb, SolidFormat::Gltf] {
        for compat in [false, true] {
            let options = SolidOptions { compat, tolerance: 0.001, ..SolidOptions::default() };
            seen.push(read_gltf(&written(format, &scene, &options).1));
        }
    }
    for read in &seen {
        assert_eq!(read.triangles.len(), seen[0].triangles.len());
        let [low, high] = read.bounds();
        let [first_low, first_high] = seen[0].bounds();
        assert!((low - first_low).length() < 1e-4 && (high - first_high).length() < 1e-4);
    }
    // In the file's axes: the turn of the picture is undone, and its middle is at x = 100.
    let origin = Quat::from_rotation_z(0.5) * Quat::from_rotation_x(1.0);
    let moved = origin.inverse() * Vec3::new(1.0, 2.0, 3.0) + Vec3::new(100.0, 0.0, 0.0);
    let [low, high] = seen[0].bounds();
    assert!((low.x - (moved.x - 1.1)).abs() < 2e-3, "{low}");
    assert!(
        (high - (moved + Vec3::new(10.0, 5.0 + 0.8 + 0.1, 1.0 + 0.1))).abs().max_element() < 5e-3,
        "{high} {moved}"
    );
    let reds = seen[0].triangles.iter().filter(|(_, color)| *color == [1.0, 0.0, 0.0, 1.0]).count();
    let glassy = seen[0].triangles.iter().filter(|(_, color)| (color[3] - 64.0 / 255.0).abs() < 1e-4).count();
    assert!(reds > 100 && glassy > 10);
}

#[test]
fn a_gltf_says_its_unit_and_is_that_large() {
    let scene = scene();
    let angstrom = read_gltf(&written(SolidFormat::Glb, &scene, &SolidOptions::default()).1).bounds();
    let options = SolidOptions { unit: Unit::Nanometre, ..SolidOptions::default() };
    let bytes = written(SolidFormat::Gltf, &scene, &options).1;
    let nanometre = read_gltf(&bytes).bounds();
    assert!((angstrom[1] * 0.1 - nanometre[1]).length() < 1e-3);
    let json: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    assert_eq!(json["asset"]["extras"]["unit"], "nanometre");
    assert_eq!(json["asset"]["extras"]["metres_per_unit"], 1e-9);
    assert_eq!(json["extensionsRequired"], serde_json::json!(["EXT_mesh_gpu_instancing"]));
}

#[test]
fn names_of_atoms_and_residues_are_extras() {
    let text = b"ATOM      1  N   GLY A   1       0.000   0.000   0.000  1.00  0.00           N  \n\
                 ATOM      2  CA  GLY A   1       1.450   0.000   0.000  1.00  0.00           C  \n";
    let document = crate::import::read_bytes(text, "g.pdb", &Default::default()).unwrap();
    let molecule = crate::bonds::assign(document.records[0].clone(), &Default::default());
    let scene = Scene::new(&[Item::of(&molecule)], &SceneOptions::default());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("g.gltf");
    let source = Source { name: "g.pdb", structure: &molecule };
    write(SolidFormat::Gltf, &scene, &[source], &SolidOptions::default(), &path).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let nodes = json["nodes"].as_array().unwrap();
    let of = nodes.iter().find(|node| node["name"] == "g.pdb").unwrap();
    assert_eq!(of["extras"]["names"], serde_json::json!(["N", "CA"]));
    assert_eq!(of["extras"]["residues"][0], serde_json::json!(["A", "GLY", 1, ""]));
    let ids: Vec<u64> =
        nodes.iter().flat_map(|node| node["extras"]["ids"].as_array()).flatten().filter_map(|id| id.as_u64()).collect();
    // Two balls, and both halves of the stick between them.
    assert!([1, 2, 3].iter().all(|id| ids.contains(id)) && ids.len() == 4, "{ids:?}");
    let obj = folder.path().join("g.obj");
    write(SolidFormat::Obj, &scene, &[source], &SolidOptions::default(), &obj).unwrap();
    let text = std::fs::read_to_string(&obj).unwrap();
    assert!(text.contains("o g.pdb\ng A_GLY_1\n") && text.contains("mtllib g.mtl\n"), "{}", &text[..200]);
}

#[test]
fn an_obj_has_the_materials_and_place_that_its_reader_finds() {
    let scene = scene();
    let (folder, _) = written(SolidFormat::Obj, &scene, &SolidOptions::default());
    let glb = read_gltf(&written(SolidFormat::Glb, &scene, &SolidOptions::default()).1);
    let (models, materials) = tobj::load_obj(folder.path().join("scene.obj"), &tobj::LoadOptions::default()).unwrap();
    let materials = materials.unwrap();
    let count: usize = models.iter().map(|model| model.mesh.indices.len() / 3).sum();
    assert_eq!(count, glb.triangles.len());
    let corner = |model: &tobj::Model| {
        let points = model.mesh.positions.chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2]));
        points.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
    };
    let all =
        models.iter().map(corner).fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    assert!((all[1] - glb.bounds()[1]).length() < 1e-3);
    let glass = materials.iter().find(|material| material.name == "color_0080ff40").unwrap();
    assert!((glass.dissolve.unwrap() - 64.0 / 255.0).abs() < 1e-3 && glass.diffuse.unwrap()[2] == 1.0);
    let surface = models.iter().find(|model| model.name == "surface").unwrap();
    assert_eq!(surface.mesh.vertex_color[..6], [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let ball = models.iter().find(|model| model.name == "balls").unwrap();
    assert_eq!(ball.mesh.vertex_color[..3], [1.0, 0.0, 0.0]);
}

fn read_stl(bytes: &[u8]) -> Read {
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap());
    assert_eq!(bytes.len(), 84 + 50 * count as usize);
    let triangle = |bytes: &[u8]| {
        let x: Vec<f32> = bytes[12..48].chunks_exact(4).map(|x| f32::from_le_bytes(x.try_into().unwrap())).collect();
        ([Vec3::from_slice(&x), Vec3::from_slice(&x[3..]), Vec3::from_slice(&x[6..])], [1.0; 4])
    };
    Read { triangles: bytes[84..].chunks_exact(50).map(triangle).collect() }
}

#[test]
fn an_stl_is_closed_shells_of_the_true_volume_in_millimetres() {
    let mut scene = scene();
    let mut block = scene.blocks[0].clone();
    block.triangles.clear();
    scene.blocks = std::sync::Arc::new(vec![block]);
    let options = SolidOptions { tolerance: 0.0005, mm_per_angstrom: Some(10.0), ..SolidOptions::default() };
    let read = read_stl(&written(SolidFormat::Stl, &scene, &options).1);
    let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    for (corners, _) in &read.triangles {
        let key = |i: usize| (corners[i % 3] + 0.0).to_array().map(f32::to_bits);
        for i in 0..3 {
            *edges.entry([key(i), key(i + 1)]).or_default() += 1;
            *edges.entry([key(i + 1), key(i)]).or_default() -= 1;
        }
    }
    assert!(edges.values().all(|&sum| sum == 0));
    // The round end is a whole ball, half of it in the stick.
    let doubled = 2.0 / 3.0 * PI * 1e-3;
    let wanted = (true_volume() + doubled) * 1000.0;
    assert!((read.volume() / wanted - 1.0).abs() < 0.005, "{} {wanted}", read.volume());
    let [low, high] = read.bounds();
    assert!(low.abs().max_element() < 1e-4, "{low}");
    assert!((high.x - 10.0 * (5.4 + 1.1)).abs() < 0.1, "{high}");
    // As large as fits where nothing is said.
    let read = read_stl(&written(SolidFormat::Stl, &scene, &SolidOptions::default()).1);
    assert!((read.bounds()[1].max_element() - 100.0).abs() < 1e-3);
}

#[test]
fn a_ply_is_as_long_as_its_header_says_and_has_the_colours() {
    let scene = scene();
    let bytes = written(SolidFormat::Ply, &scene, &SolidOptions::default()).1;
    let end = memchr::memmem::find(&bytes, b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    let count = |name: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(&format!("element {name} "))).unwrap();
        line.parse().unwrap()
    };
    let (vertices, faces) = (count("vertex"), count("face"));
    assert_eq!(bytes.len(), end + 28 * vertices + 13 * faces);
    let vertex = |i: usize| &bytes[end + 28 * i..][..28];
    assert_eq!(vertex(0)[24..], [255, 0, 0, 255]);
    assert_eq!(vertex(vertices - 1)[24..], [0, 128, 255, 255], "the opacity is the first corner's");
    let faces = &bytes[end + 28 * vertices..];
    let largest = faces
        .chunks_exact(13)
        .flat_map(|face| face[1..].chunks_exact(4))
        .map(|x| u32::from_le_bytes(x.try_into().unwrap()));
    assert_eq!(largest.max(), Some(vertices as u32 - 1));
}

#[test]
fn what_is_not_there_cannot_be_written() {
    let empty = Scene::from_blocks(Vec::new(), Vec::new());
    let folder = tempfile::tempdir().unwrap();
    for format in SolidFormat::ALL {
        let path = folder.path().join(format.name());
        let error = write(format, &empty, &[], &SolidOptions::default(), &path).unwrap_err();
        assert!(error.to_string().contains("nothing is drawn") && !path.exists(), "{error}");
    }
}

#[test]
fn more_than_a_format_holds_is_refused_before_anything_is_written() {
    let ball = |i: usize| SphereInstance { center: [i as f32, 0.0, 0.0], radius: 1.7, color: RED, id: i as u32 + 1 };
    let block = Block { spheres: (0..20_000).map(ball).collect(), id_count: 20_000, ..Block::default() };
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    let scene = Scene::from_blocks(vec![block], vec![placement]);
    let options = SolidOptions { tolerance: 1e-4, compat: true, ..SolidOptions::default() };
    let folder = tempfile::tempdir().unwrap();
    for (format, says) in [(SolidFormat::Glb, "4 GiB"), (SolidFormat::Gltf, "1 GiB")] {
        let path = folder.path().join(format.name());
        let error = write(format, &scene, &[], &options, &path).unwrap_err().to_string();
        assert!(error.contains(says) && error.contains("--tolerance") && !path.exists(), "{error}");
    }
}

/// Drawn as a mesh, a molecule with rings, dashes, arrows, a cell and see-through parts looks as it does by its primitives.
#[test]
fn an_exported_scene_drawn_back_looks_like_the_scene() {
    use crate::render::{Choice, Quality, View, select};
    let text = b"12\nProperties=species:S:1:pos:R:3:forces:R:3 Lattice=\"9 0 0 0 9 0 0 0 9\"\n\
        C 0.000 1.396 0 0 0 1\nC 1.209 0.698 0 0 0 1\nC 1.209 -0.698 0 0 0.5 1\nC 0.000 -1.396 0 0 0 1\n\
        C -1.209 -0.698 0 0 0 1\nC -1.209 0.698 0 0 1 0\nH 0.000 2.479 0 0 0 0\nH 2.147 1.240 0 0 0 0\n\
        H 2.147 -1.240 0 0 0 0\nH 0.000 -2.479 0 0 0 0\nH -2.147 -1.240 0 0 0 0\nCl -2.716 1.568 0 0 0 0\n";
    let document = crate::import::read_bytes(text, "b.extxyz", &Default::default()).unwrap();
    let molecule = crate::bonds::assign(document.records[0].clone(), &Default::default());
    let options = SceneOptions { vectors: VectorChoice::from_name("auto"), ..SceneOptions::default() };
    let item = Item { cell_box: molecule.cell(), ..Item::of(&molecule) };
    let scene = Scene::new(&[item], &options);
    assert!(!scene.blocks[0].tori.is_empty() && !scene.blocks[0].cones.is_empty());
    let camera = scene.fitted_camera(1.25);
    let image = |scene: Scene| {
        let mut renderer = select(Choice::Cpu).unwrap().renderer;
        renderer.load(std::sync::Arc::new(scene)).unwrap();
        renderer.image(&View::new(camera, 250, 200), &Quality::Draft.settings()).unwrap()
    };
    let first = image(scene.clone());
    let folder = tempfile::tempdir().unwrap();
    for (name, compat) in [("a.glb", false), ("b.glb", true), ("c.gltf", false), ("d.obj", false)] {
        let path = folder.path().join(name);
        let solid = SolidOptions { compat, tolerance: 0.002, ..SolidOptions::default() };
        write(SolidFormat::from_path(&path).unwrap(), &scene, &[], &solid, &path).unwrap();
        let (mesh, said) = crate::import::mesh::read_path(&path, &Default::default()).unwrap();
        assert!(said.is_empty(), "{said:?}");
        let bare = molecule.subset(&vec![false; molecule.atom_count()]);
        let again = Scene::new(
            &[Item::of(&bare)],
            &SceneOptions {
                overlay: vec![std::sync::Arc::new(mesh)],
                pose: Some(scene.pose),
                ..SceneOptions::default()
            },
        );
        let again = image(again);
        // Over the pixels that either covers: not white in one of them.
        let pairs = first.rgba.chunks_exact(4).zip(again.rgba.chunks_exact(4));
        let covered = pairs.filter(|(a, b)| a.iter().chain(*b).any(|&x| x < 250));
        let (mut sum, mut count, mut far) = (0u64, 0u64, 0u64);
        for (a, b) in covered {
            let most = a.iter().zip(b).map(|(x, y)| x.abs_diff(*y)).max().unwrap();
            sum += u64::from(most);
            count += 1;
            far += u64::from(most > 40);
        }
        assert!(count > 2000, "{count}");
        assert!(sum < 6 * count, "{name}: mean difference {}", sum as f64 / count as f64);
        assert!(far * 20 < count, "{name}: {far} of {count} pixels are others");
    }
}
