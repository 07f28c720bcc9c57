use super::*;
use glam::Vec3;

fn read(bytes: &[u8], name: &str) -> Result<(Mesh, Vec<Diagnostic>)> {
    read_bytes(bytes, name, None, &ImportOptions::default())
}

/// A square of two triangles, as glTF with its numbers in `buffer`; 4 positions, 4 colours of bytes, 6 indices.
fn square() -> (String, Vec<u8>) {
    let mut buffer = Vec::new();
    for x in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].concat() {
        buffer.extend(x.to_le_bytes());
    }
    buffer.extend([255u8, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 0, 0, 255, 128]);
    for index in [0u16, 1, 2, 0, 2, 3] {
        buffer.extend(index.to_le_bytes());
    }
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"translation":[10,0,0],"children":[1]},
                 {"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,1,1]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1},"indices":2,"material":0}]}],
        "materials":[{"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.5]}}],
        "buffers":[{"byteLength":76 URI}],
        "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":16},
                       {"buffer":0,"byteOffset":64,"byteLength":12}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
                     {"bufferView":1,"componentType":5121,"normalized":true,"count":4,"type":"VEC4"},
                     {"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}]}"#;
    (json.to_owned(), buffer)
}

fn glb(json: &str, buffer: &[u8]) -> Vec<u8> {
    let mut json = json.replace("URI", "").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + buffer.len();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((length as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_slice()), (b"BIN\0", buffer)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

#[test]
fn an_obj_has_the_colours_of_its_materials_and_faces_of_any_size() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my colours.mtl"), "newmtl glass\nKd 0 0.5 1\nd 0.25\nnewmtl red\nKd 1 0 0\n")
        .unwrap();
    let obj = "# a cage\r\nmtllib my colours.mtl\r\no cage\r\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nvn 0 0 2\n\
               usemtl glass\nf 1//1 2//1 3//1 4//1\nusemtl red\nf -1 1 \\\n2\nusemtl glass\nf 2/7 3/8 5/9 # by texture\n";
    let path = folder.path().join("cage.obj");
    std::fs::write(&path, obj).unwrap();
    let (mesh, diagnostics) = read_path(&path, &ImportOptions::default()).unwrap();
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3], [4, 5, 6], [7, 8, 9]]);
    let glass = Srgb8 { r: 0, g: 128, b: 255, a: 64 };
    assert_eq!((mesh.colors()[0], mesh.colors()[5], mesh.colors()[9]), (glass, Srgb8::rgb(255, 0, 0), glass));
    assert_eq!(mesh.normals()[1], Vec3::Z);
    // Those of the red and the second glassy face are made.
    assert!(mesh.normals()[4..].iter().all(|normal| normal.is_normalized() && *normal != Vec3::Z));
    assert_eq!(mesh.positions()[9], Vec3::new(0.5, 0.5, 1.0));
    assert_eq!(mesh.edges().len(), 8, "five of the square and its diagonal, three to the tip");
}

#[test]
fn vertices_of_an_obj_may_have_colours_and_its_material_gives_them_opacity() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0\nf 1 2 3\n";
    let (mesh, _) = read(text.as_bytes(), "a.obj").unwrap();
    assert_eq!(mesh.colors(), [Srgb8::rgb(255, 0, 0), Srgb8::rgb(0, 255, 0), UNCOLORED]);
    let bytes = text.replace("1 0 0\nv 1", "255 128 0\nv 1");
    assert_eq!(read(bytes.as_bytes(), "a.obj").unwrap().0.colors()[0], Srgb8::rgb(255, 128, 0));
}

#[test]
fn what_an_obj_has_wrong_is_left_out_with_its_line() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 x 0\nv 1e99 0 0\nf 1 2 3\nf 1 2 9\nf 1 2 4\nf 1 b 2\nf 1 2\nf 0 1 2\nf 1//5 2 3\n\
                f -9 1 2\nf 99999999999999999999 1 2\nusemtl none\n";
    let (mesh, diagnostics) = read(text.as_bytes(), "a.obj").unwrap();
    assert_eq!(mesh.triangles(), [[0, 1, 2]]);
    let said: Vec<String> = diagnostics.iter().map(ToString::to_string).collect();
    assert!(
        said[0].starts_with("line 4: error: expected the three coordinates") && said[0].contains("(2 times"),
        "{said:?}"
    );
    assert!(said[1].contains("line 7: error: vertex 9 is not there: the file has 5 up to here"), "{said:?}");
    assert!(said[1].contains("(8 times"), "{said:?}");
}

#[test]
fn a_material_file_that_is_missing_or_elsewhere_costs_only_the_colours() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    for name in ["none.mtl", "../a.mtl", "/etc/hostname"] {
        std::fs::write(&path, format!("mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")).unwrap();
        let (mesh, diagnostics) = read_path(&path, &ImportOptions::default()).unwrap();
        assert_eq!((mesh.colors()[0], diagnostics.len(), diagnostics[0].line), (UNCOLORED, 1, Some(1)), "{name}");
    }
}

#[test]
fn a_gltf_stands_where_its_nodes_put_it_in_the_colours_of_vertices_and_material() {
    let (json, buffer) = square();
    let base64 = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &buffer);
    let inside = json.replace("URI", &format!(",\"uri\":\"data:application/octet-stream;base64,{base64}\""));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my buffer.bin"), &buffer).unwrap();
    let beside = folder.path().join("beside.gltf");
    std::fs::write(&beside, json.replace("URI", ",\"uri\":\"my%20buffer.bin\"")).unwrap();
    let meshes = [
        read(&glb(&json, &buffer), "a.glb").unwrap(),
        read(inside.as_bytes(), "a.gltf").unwrap(),
        read_path(&beside, &ImportOptions::default()).unwrap(),
    ];
    for (mesh, diagnostics) in &meshes {
        assert!(diagnostics.is_empty());
        // Twice as long along x, turned by 90° about z, moved by 10.
        let want = [[10.0, 0.0, 0.0], [10.0, 2.0, 0.0], [9.0, 2.0, 0.0], [9.0, 0.0, 0.0]].map(Vec3::from);
        assert!(mesh.positions().iter().zip(want).all(|(a, b)| (*a - b).length() < 1e-6), "{:?}", mesh.positions());
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.normals(), [Vec3::Z; 4]);
        assert_eq!(mesh.colors()[0], Srgb8 { r: 255, g: 0, b: 0, a: 128 });
        assert_eq!(mesh.colors()[3], Srgb8 { r: 0, g: 0, b: 255, a: 64 });
    }
}

/// A grid of the four colours of [`texture::tests::four_colors`] is what a square with a corner in the middle of each has.
const FOUR: [Srgb8; 4] =
    [Srgb8::rgb(0, 0, 255), Srgb8 { r: 255, g: 255, b: 255, a: 128 }, Srgb8::rgb(0, 255, 0), Srgb8::rgb(255, 0, 0)];

/// [`square`] with places in a picture in place of colours, in an image that is said by `IMAGE`.
fn pictured() -> (String, Vec<u8>) {
    let (json, mut buffer) = square();
    let json = json
        .replace("\"COLOR_0\":1", "\"TEXCOORD_0\":3")
        .replace("[1,1,1,0.5]}", "[1,1,1,1],\"baseColorTexture\":{\"index\":0 TRANSFORM}}")
        .replace("\"buffers\"", "\"textures\":[{\"source\":0}],\"images\":[{IMAGE}],\"buffers\"")
        .replace("\"byteLength\":12}]", "\"byteLength\":12},{\"buffer\":0,\"byteOffset\":76,\"byteLength\":32}PICTURE]")
        .replace(
            "\"type\":\"SCALAR\"}]",
            "\"type\":\"SCALAR\"},{\"bufferView\":3,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"}]",
        );
    for x in [[0.25f32, 0.75], [0.75, 0.75], [0.75, 0.25], [0.25, 0.25]].concat() {
        buffer.extend(x.to_le_bytes());
    }
    (json, buffer)
}

#[test]
fn a_gltf_has_the_colours_of_its_picture_wherever_that_is() {
    let (json, mut buffer) = pictured();
    let png = texture::tests::four_colors();
    let base64 = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &png);
    let place = buffer.len();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.png"), &png).unwrap();
    buffer.extend(&png);
    let view = format!(",{{\"buffer\":0,\"byteOffset\":{place},\"byteLength\":{}}}", png.len());
    for image in [
        "\"bufferView\":4,\"mimeType\":\"image/png\"".to_owned(),
        format!("\"uri\":\"data:image/png;base64,{base64}\""),
        "\"uri\":\"a%20b.png\"".to_owned(),
    ] {
        let json = json.replace("IMAGE", &image).replace("PICTURE", &view);
        let json =
            json.replace("TRANSFORM", "").replace("\"byteLength\":76", &format!("\"byteLength\":{}", buffer.len()));
        let path = folder.path().join("a.glb");
        std::fs::write(&path, glb(&json, &buffer)).unwrap();
        let (mesh, said) = read_path(&path, &ImportOptions::default()).unwrap();
        assert!(said.is_empty(), "{said:?}");
        assert_eq!(mesh.colors(), FOUR, "{image}");
        // Half a picture on and turned: the extension that many tools write.
        let moved = json.replace(
            "{\"index\":0 }",
            "{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.5,0],\"scale\":[1,1]}}}",
        );
        assert_ne!(moved, json);
        std::fs::write(&path, glb(&moved, &buffer)).unwrap();
        let (mesh, _) = read_path(&path, &ImportOptions::default()).unwrap();
        assert_eq!(mesh.colors(), [FOUR[1], FOUR[0], FOUR[3], FOUR[2]]);
    }
}

#[test]
fn a_picture_that_is_missing_broken_or_elsewhere_costs_only_itself() {
    let (json, buffer) = pictured();
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("mesh");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(folder.path().join("secret.png"), texture::tests::four_colors()).unwrap();
    std::fs::write(inner.join("broken.png"), &texture::tests::four_colors()[..50]).unwrap();
    for image in [
        "\"uri\":\"none.png\"",
        "\"uri\":\"broken.png\"",
        "\"uri\":\"../secret.png\"",
        "\"uri\":\"http://example.org/a.png\"",
        "\"uri\":\"data:image/png;base64,AAAA\"",
        "\"bufferView\":0,\"mimeType\":\"image/png\"",
        "\"bufferView\":99,\"mimeType\":\"image/png\"",
        "",
    ] {
        let json =
            json.replace("IMAGE", image).replace("PICTURE", "").replace("TRANSFORM", "").replace("76 URI", "108");
        let path = inner.join("a.glb");
        std::fs::write(&path, glb(&json, &buffer)).unwrap();
        let (mesh, said) = read_path(&path, &ImportOptions::default()).unwrap();
        assert_eq!(mesh.colors(), [Srgb8::WHITE; 4], "{image}");
        assert!(said.len() == 1 && said[0].message.contains("image 0 is left out"), "{said:?}");
    }
}

#[test]
fn an_obj_has_the_colours_of_its_materials_picture() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("sub/four.png"), texture::tests::four_colors()).unwrap();
    std::fs::write(
        folder.path().join("sub/a.mtl"),
        "newmtl a\nmap_Kd -clamp on four.png\nnewmtl b\nmap_Kd none.png\nKd 1 0 0\n",
    )
    .unwrap();
    let obj = "mtllib sub/a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.25 0.25\nvt 0.75 0.25\nvt 0.75 0.75\nvt 0.25 0.75\n\
               usemtl a\nf 1/1 2/2 3/3 4/4\nusemtl b\nf 1/1 2/2 3/3\n";
    let path = folder.path().join("a.obj");
    std::fs::write(&path, obj).unwrap();
    let (mesh, said) = read_path(&path, &ImportOptions::default()).unwrap();
    // Upwards here, downwards in glTF.
    assert_eq!(mesh.colors()[..4], FOUR);
    assert_eq!(mesh.colors()[4], Srgb8::rgb(255, 0, 0));
    assert!(said.len() == 1 && said[0].line == Some(12) && said[0].message.contains("none.png"), "{said:?}");
}

#[test]
fn instances_of_a_mesh_stand_where_they_should() {
    let (json, mut buffer) = square();
    let (t, r, s) = (
        [[0.0f32, 0.0, 0.0], [0.0, 0.0, 5.0]],
        [[0.0f32, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]],
        [[1.0f32; 3], [2.0; 3]],
    );
    let numbers = t.as_flattened().iter().chain(r.as_flattened()).chain(s.as_flattened());
    numbers.for_each(|x| buffer.extend(x.to_le_bytes()));
    let json = json
        .replace("\"mesh\":0,", "\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":3,\"ROTATION\":4,\"SCALE\":5}}},")
        .replace("\"scene\":0", "\"scene\":0,\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"]")
        .replace("\"byteLength\":12}]", "\"byteLength\":12},{\"buffer\":0,\"byteOffset\":76,\"byteLength\":24},{\"buffer\":0,\"byteOffset\":100,\"byteLength\":32},{\"buffer\":0,\"byteOffset\":132,\"byteLength\":24}]")
        .replace("\"type\":\"SCALAR\"}]", "\"type\":\"SCALAR\"},{\"bufferView\":3,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"},{\"bufferView\":4,\"componentType\":5126,\"count\":2,\"type\":\"VEC4\"},{\"bufferView\":5,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}]");
    let (mesh, _) = read(&glb(&json, &buffer), "a.glb").unwrap();
    assert_eq!(mesh.triangles().len(), 4);
    // The second: (1, 0, 0) twice as large, turned about y, 5 up; then the node: twice along x, turned about z, 10 on.
    assert!((mesh.positions()[5] - Vec3::new(10.0, -4.0, 5.0)).length() < 1e-5, "{:?}", mesh.positions());
    let uneven = json.replace("\"count\":2,\"type\":\"VEC4\"", "\"count\":1,\"type\":\"VEC4\"");
    assert!(read(&glb(&uneven, &buffer), "a.glb").unwrap_err().to_string().contains("different lengths"));
    let missing = json.replace("\"TRANSLATION\":3", "\"TRANSLATION\":\"x\"");
    assert!(read(&glb(&missing, &buffer), "a.glb").is_err());
}

#[test]
fn sparse_accessors_state_some_elements_and_leave_the_others_as_they_are() {
    let (json, mut buffer) = square();
    buffer.extend([2u8, 0, 0, 0]);
    [7.0f32, 8.0, 9.0].iter().for_each(|x| buffer.extend(x.to_le_bytes()));
    let sparse =
        "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":3,\"componentType\":5121},\"values\":{\"bufferView\":4}}";
    let json = json
        .replace("\"byteLength\":12}]", "\"byteLength\":12},{\"buffer\":0,\"byteOffset\":76,\"byteLength\":4},{\"buffer\":0,\"byteOffset\":80,\"byteLength\":12}]")
        .replace("\"scale\":[2,1,1]", "\"scale\":[1,1,1]")
        .replace("\"rotation\":[0,0,0.7071067811865476,0.7071067811865476],", "")
        .replace("\"translation\":[10,0,0],", "");
    let based = json.replace("\"type\":\"VEC3\"}", &format!("\"type\":\"VEC3\",{sparse}}}"));
    let (mesh, _) = read(&glb(&based, &buffer), "a.glb").unwrap();
    assert_eq!(mesh.positions()[1..3], [Vec3::X, Vec3::new(7.0, 8.0, 9.0)]);
    let bare = based.replace("{\"bufferView\":0,\"componentType\":5126", "{\"componentType\":5126");
    let error = read(&glb(&bare, &buffer), "a.glb").unwrap_err().to_string();
    assert!(error.contains("area"), "all others are at the origin: {error}");
    let huge = bare.replace("\"count\":4,\"type\":\"VEC3\"", "\"count\":99999999999,\"type\":\"VEC3\"");
    assert!(matches!(read(&glb(&huge, &buffer), "a.glb"), Err(Error::Limit { .. })));
}

#[test]
fn strips_and_fans_are_triangles_and_points_are_said_to_be_left_out() {
    let (json, buffer) = square();
    for (mode, want) in [(5, vec![[0, 1, 2], [1, 2, 0], [2, 0, 2], [0, 2, 3]]), (6, vec![[0, 1, 2], [0, 2, 3]])] {
        let json = json.replace("\"material\":0", &format!("\"mode\":{mode}"));
        let (mesh, _) = read(&glb(&json, &buffer), "").unwrap();
        let sound: Vec<[u32; 3]> = want.into_iter().filter(|[a, b, c]| a != b && b != c && a != c).collect();
        assert_eq!(mesh.triangles(), sound);
        assert_eq!(mesh.colors()[3].a, 128, "without a material the vertices' own opacity");
    }
    let points = json.replace("[{\"attributes\"", "[{\"mode\":0,\"attributes\":{\"POSITION\":0}},{\"attributes\"");
    let (_, diagnostics) = read(&glb(&points, &buffer), "").unwrap();
    assert!(diagnostics[0].message.contains("1 parts"), "{diagnostics:?}");
}

#[test]
fn what_a_gltf_has_wrong_is_an_error_that_says_what() {
    let (json, buffer) = square();
    let error = |from: &str, to: &str| {
        assert!(json.contains(from), "{from}");
        read(&glb(&json.replace(from, to), &buffer), "a.glb").unwrap_err().to_string()
    };
    for (from, to, says) in [
        ("\"version\":\"2.0\"", "\"version\":\"1.0\"", "version 1.0"),
        (
            "\"scene\":0",
            "\"scene\":0,\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]",
            "KHR_draco_mesh_compression",
        ),
        ("\"children\":[1]", "\"children\":[0]", "circle"),
        ("\"children\":[1]", "\"children\":[9]", "node 9"),
        ("\"mesh\":0", "\"mesh\":7", "mesh 7"),
        ("\"POSITION\":0", "\"POSITION\":77", "accessor 77"),
        ("\"POSITION\":0", "\"POSITION\":2", "3 to 4 components, found 1"),
        ("\"POSITION\":0,", "", "POSITION"),
        ("\"indices\":2", "\"indices\":0", "whole numbers"),
        ("\"count\":4,\"type\":\"VEC3\"", "\"count\":0,\"type\":\"VEC3\"", "vertex 0 is not there"),
        (
            "\"count\":4,\"type\":\"VEC3\"",
            "\"count\":18446744073709551615,\"type\":\"VEC3\"",
            "expected 18446744073709551615",
        ),
        ("\"byteLength\":48", "\"byteLength\":48,\"byteStride\":4", "elements"),
        ("\"byteOffset\":48", "\"byteOffset\":1e3", "JSON"),
        ("\"byteOffset\":48", "\"byteOffset\":4800", "beyond its buffer"),
        ("\"bufferView\":0", "\"bufferView\":5", "view is not there"),
        ("\"bufferView\":0,", "", "no buffer view"),
        ("URI", ",\"uri\":\"http://example.org/a.bin\"", "was not read from a folder"),
        ("URI", ",\"uri\":\"data:,abc\"", "base64"),
    ] {
        let message = error(from, to);
        assert!(message.contains(says), "{to}: {message}");
    }
}

#[test]
fn size_has_a_limit() {
    let options = ImportOptions { limits: Limits { triangles: 1, ..Limits::default() }, ..ImportOptions::default() };
    let (json, buffer) = square();
    for bytes in [glb(&json, &buffer), b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 1 1\nf 1 2 3 4\n".to_vec()] {
        assert!(matches!(read_bytes(&bytes, "a.obj", None, &options), Err(Error::Limit { .. })));
    }
}

#[test]
fn what_is_no_mesh_is_refused_with_what_it_should_be() {
    for (bytes, name) in [(&b"3\nwater\nO 0 0 0\n"[..], "water.xyz"), (b"", "a"), (b"HEADER  x", "1abc.pdb")] {
        let message = read(bytes, name).unwrap_err().to_string();
        assert!(message.contains("Wavefront OBJ") && message.contains("glTF"), "{message}");
    }
    assert!(read(b"v 0 0 0\nl 1 1\n", "a.obj").unwrap_err().to_string().contains("no triangles"));
    assert!(read(b"v 0 0 0\nf 1 1 1\n", "a.obj").unwrap_err().to_string().contains("area"));
}

/// Every cut and every changed byte: results may be anything but a panic.
#[test]
fn cut_and_changed_meshes_are_read_or_refused() {
    let (json, buffer) = square();
    let base64 = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &buffer);
    let inside = json.replace("URI", &format!(",\"uri\":\"data:;base64,{base64}\""));
    let obj = "mtllib a.mtl\no a\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nvn 0 0 1\nvt 0 0\nusemtl b\nf 1/1/1 2//1 3 \\\n 4\nf -1 -2 -3\n";
    for seed in [glb(&json, &buffer), inside.into_bytes(), obj.as_bytes().to_vec()] {
        assert!(read(&seed, "a").is_ok());
        let mut meshes = 0;
        for at in 0..seed.len() {
            meshes += usize::from(read(&seed[..at], "a.obj").is_ok());
            for change in [0x01, 0x10, 0x80, 0xff] {
                let mut bytes = seed.clone();
                bytes[at] ^= change;
                if let Ok((mesh, _)) = read(&bytes, "a.obj") {
                    meshes += 1;
                    let count = mesh.positions().len();
                    assert!(mesh.triangles().iter().flatten().all(|&vertex| (vertex as usize) < count));
                    let edges = mesh.edges();
                    assert!(edges.iter().flatten().all(|&vertex| mesh.positions()[vertex as usize].is_finite()));
                }
            }
        }
        assert!(meshes > 100, "most changes leave a mesh: {meshes}");
    }
}
