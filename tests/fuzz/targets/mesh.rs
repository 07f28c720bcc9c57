#![no_main]

// OBJ, glTF or GLB, as the content says; a name that no content has makes everything else an OBJ.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let limits = ballstick::import::Limits { decompressed_bytes: 1 << 22, triangles: 100_000, ..Default::default() };
    let options = ballstick::import::ImportOptions { limits, ..Default::default() };
    if let Ok((mesh, _)) = ballstick::import::mesh::read_bytes(bytes, "a.obj", None, &options) {
        assert!(mesh.triangles().iter().flatten().all(|&vertex| mesh.positions()[vertex as usize].is_finite()));
        assert!(mesh.edges().len() <= 3 * mesh.triangles().len());
    }
});
