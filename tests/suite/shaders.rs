//! Shaders without a GPU: they resolve, they are valid, their bytes are the Rust bytes, and every pipeline builds under
//! the limits of WebGL2-class devices.

use ballstick::render::frame::FrameConstants;
use ballstick::render::gpu::layout::{
    CONE_ATTRIBUTES, CYLINDER_ATTRIBUTES, FieldConstants, PlacementConstants, SPHERE_ATTRIBUTES, SampleConstants,
    TORUS_ATTRIBUTES, TRIANGLE_ATTRIBUTES,
};
use ballstick::render::gpu::{Accumulation, GpuRenderer, shaders};
use ballstick::render::{Renderer, Settings, View};
use ballstick::scene::{ConeInstance, CylinderInstance, SphereInstance, TorusInstance, TriangleInstance};
use std::mem::offset_of;
use std::sync::Arc;
use wgpu::naga;

fn parsed(name: &str) -> naga::Module {
    let source = shaders::source(name).unwrap();
    naga::front::wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&source)))
}

#[test]
fn the_embedded_files_are_those_of_the_folder() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut there: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    there.sort();
    let embedded: Vec<&str> = shaders::FILES.iter().map(|(name, _)| *name).collect();
    assert!(!there.is_empty());
    assert_eq!(there, embedded);
}

#[test]
fn every_file_is_a_valid_module_with_its_imports() {
    assert!(!shaders::FILES.is_empty());
    for (name, _) in shaders::FILES {
        let module = parsed(name);
        let capabilities = naga::valid::Capabilities::empty();
        let checked = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities).validate(&module);
        assert!(checked.is_ok(), "{name}: {:?}", checked.unwrap_err());
        let has_entries = !module.entry_points.is_empty();
        let is_module = shaders::MODULES.contains(name) || *name == "fullscreen.wgsl";
        assert_eq!(has_entries, is_module, "{name}: modules are the files with entry points");
    }
}

#[test]
fn a_broken_shader_would_be_found() {
    let source = shaders::source("sphere.wgsl").unwrap();
    let broken = source.replacen("sphere.radius * sphere.radius", "sphere.radius * sphere.centre", 1);
    assert_ne!(source, broken);
    assert!(naga::front::wgsl::parse_str(&broken).is_err());
}

/// Names and offsets of the members of a WGSL struct, and its size.
fn members(module: &naga::Module, name: &str) -> (Vec<(String, u32)>, u32) {
    let (_, found) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).unwrap();
    let naga::TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no struct") };
    (members.iter().map(|member| (member.name.clone().unwrap(), member.offset)).collect(), *span)
}

macro_rules! assert_same_layout {
    ($file:literal, $type:ty, $name:literal, [$($member:ident $wgsl:literal),* $(,)?]) => {
        let (members, size) = members(&parsed($file), $name);
        let rust = vec![$(($wgsl.to_owned(), offset_of!($type, $member) as u32)),*];
        assert_eq!(members, rust);
        assert_eq!(size as usize, size_of::<$type>());
    };
}

#[test]
fn uniforms_have_the_same_bytes_in_rust_and_wgsl() {
    assert_same_layout!("common.wgsl", FrameConstants, "FrameConstants", [
        world_from_view "world_from_view", key "key", fill "fill", up "up", ambient "ambient",
        background "background", depth "depth", fog "fog", ground_color "ground_color", ground "ground",
        ground_center "ground_center", ground_map "ground_map", ground_map_size "ground_map_size",
        key_in_world "key_in_world", bounds_min "bounds_min", bounds_max "bounds_max", grid "grid", sky "sky",
        outline "outline", outline_color "outline_color",
    ]);
    assert_same_layout!("common.wgsl", SampleConstants, "SampleConstants", [
        origin "origin", size "size", offset "offset", done "done", turn "turn",
    ]);
    assert_same_layout!("field.wgsl", FieldConstants, "FieldConstants", [levels "levels", counts "counts"]);
    let (members, size) = members(&parsed("geometry.wgsl"), "PlacementConstants");
    let offsets: Vec<u32> = members.iter().map(|(_, offset)| *offset).collect();
    let column = |i: u32| offset_of!(PlacementConstants, columns) as u32 + 16 * i;
    assert_eq!(offsets, [column(0), column(1), column(2), column(3), offset_of!(PlacementConstants, first_id) as u32]);
    assert_eq!(size as usize, size_of::<PlacementConstants>());
}

/// Location and number of 32-bit components of each vertex input of an entry point.
fn inputs(file: &str, entry: &str) -> Vec<(u32, u32)> {
    let module = parsed(file);
    let entry = module.entry_points.iter().find(|e| e.name == entry).unwrap();
    let input = |argument: &naga::FunctionArgument| {
        let Some(naga::Binding::Location { location, .. }) = argument.binding else { return None };
        match module.types[argument.ty].inner {
            naga::TypeInner::Scalar(scalar) if scalar.width == 4 => Some((location, 1)),
            naga::TypeInner::Vector { size, scalar } if scalar.width == 4 => Some((location, size as u32)),
            ref other => panic!("{other:?}"),
        }
    };
    entry.function.arguments.iter().filter_map(input).collect()
}

#[test]
fn instance_attributes_are_the_fields_of_the_instances() {
    let seen = |attributes: &[wgpu::VertexAttribute]| -> Vec<(u32, u32, usize)> {
        attributes.iter().map(|a| (a.shader_location, a.format.size() as u32 / 4, a.offset as usize)).collect()
    };
    let spheres = seen(&SPHERE_ATTRIBUTES);
    assert_eq!(spheres, [(0, 4, offset_of!(SphereInstance, center)), (1, 2, offset_of!(SphereInstance, color)),]);
    assert_eq!(offset_of!(SphereInstance, radius), offset_of!(SphereInstance, center) + 12);
    assert_eq!(offset_of!(SphereInstance, id), offset_of!(SphereInstance, color) + 4);
    let cylinders = seen(&CYLINDER_ATTRIBUTES);
    assert_eq!(
        cylinders,
        [
            (0, 4, offset_of!(CylinderInstance, a)),
            (1, 3, offset_of!(CylinderInstance, b)),
            (2, 1, offset_of!(CylinderInstance, id)),
            (3, 3, offset_of!(CylinderInstance, color_a)),
        ]
    );
    assert_eq!(offset_of!(CylinderInstance, radius), offset_of!(CylinderInstance, a) + 12);
    assert_eq!(offset_of!(CylinderInstance, color_b), offset_of!(CylinderInstance, color_a) + 4);
    assert_eq!(offset_of!(CylinderInstance, caps), offset_of!(CylinderInstance, color_a) + 8);
    let shapes = |attributes: &[(u32, u32, usize)]| attributes.iter().map(|a| (a.0, a.1)).collect::<Vec<_>>();
    assert_eq!(inputs("sphere.wgsl", "vs_sphere"), shapes(&spheres));
    assert_eq!(inputs("cylinder.wgsl", "vs_cylinder"), shapes(&cylinders));
}

/// Location, number of 32-bit components and offset of each attribute.
fn fields(attributes: &[wgpu::VertexAttribute]) -> Vec<(u32, u32, usize)> {
    attributes.iter().map(|a| (a.shader_location, a.format.size() as u32 / 4, a.offset as usize)).collect()
}

#[test]
fn attributes_of_cones_tori_and_triangles_are_their_fields() {
    let cones = fields(&CONE_ATTRIBUTES);
    let of = [offset_of!(ConeInstance, a), offset_of!(ConeInstance, b), offset_of!(ConeInstance, color)];
    assert_eq!(cones, [(0, 4, of[0]), (1, 4, of[1]), (2, 2, of[2])]);
    assert_eq!(offset_of!(ConeInstance, radius_a), of[0] + 12);
    assert_eq!(offset_of!(ConeInstance, radius_b), of[1] + 12);
    assert_eq!(offset_of!(ConeInstance, id), of[2] + 4);
    let tori = fields(&TORUS_ATTRIBUTES);
    let of = [offset_of!(TorusInstance, center), offset_of!(TorusInstance, axis), offset_of!(TorusInstance, color)];
    assert_eq!(tori, [(0, 4, of[0]), (1, 4, of[1]), (2, 2, of[2])]);
    assert_eq!(offset_of!(TorusInstance, ring_radius), of[0] + 12);
    assert_eq!(offset_of!(TorusInstance, tube_radius), of[1] + 12);
    assert_eq!(offset_of!(TorusInstance, id), of[2] + 4);
    let triangles = fields(&TRIANGLE_ATTRIBUTES);
    let (corners, normals) = (offset_of!(TriangleInstance, corners), offset_of!(TriangleInstance, normals));
    let colors = offset_of!(TriangleInstance, colors);
    let rows =
        (0..3).map(|i| (i, 3, corners + 12 * i as usize)).chain((0..3).map(|i| (3 + i, 3, normals + 12 * i as usize)));
    assert_eq!(triangles, rows.chain([(6, 4, colors)]).collect::<Vec<_>>());
    assert_eq!(offset_of!(TriangleInstance, id), colors + 12);
    for (file, entry, attributes) in
        [("cone.wgsl", "vs_cone", cones), ("torus.wgsl", "vs_torus", tori), ("triangle.wgsl", "vs_triangle", triangles)]
    {
        assert_eq!(inputs(file, entry), attributes.iter().map(|a| (a.0, a.1)).collect::<Vec<_>>(), "{file}");
    }
}

#[test]
fn listed_instances_are_fetched_as_they_lie() {
    // By words of 8 bytes: as many as an instance has, the fields at those of the vertex attributes.
    let holds = |file: &str, part: &str| assert!(shaders::source(file).unwrap().contains(part), "{file}: {part}");
    assert_eq!(size_of::<SphereInstance>(), 3 * 8);
    assert_eq!(size_of::<CylinderInstance>(), 6 * 8);
    for file in ["cull.wgsl", "sphere_listed.wgsl"] {
        holds(file, "let first = 3u * number;");
    }
    for file in ["cull.wgsl", "cylinder_listed.wgsl"] {
        holds(file, "let first = 6u * number;");
    }
    assert_eq!(offset_of!(SphereInstance, color), 2 * 8);
    assert_eq!((offset_of!(CylinderInstance, b), offset_of!(CylinderInstance, id)), (2 * 8, 3 * 8 + 4));
    assert_eq!((offset_of!(CylinderInstance, color_a), offset_of!(CylinderInstance, caps)), (4 * 8, 5 * 8));
    for (file, entry) in [("sphere_listed.wgsl", "vs_sphere_listed"), ("cylinder_listed.wgsl", "vs_cylinder_listed")] {
        assert_eq!(inputs(file, entry), [(0, 1)]);
    }
}

#[test]
fn numbers_that_both_sides_hold_are_the_same() {
    let holds = |file: &str, line: String| assert!(shaders::source(file).unwrap().contains(&line), "{file}: {line}");
    let offset = ballstick::render::sky::START_OFFSET;
    holds("sky.wgsl", format!("const START_OFFSET: f32 = {offset:e};"));
    holds("cull.wgsl", format!("const MEMBERS: u32 = {}u;", ballstick::render::gpu::clusters::MEMBERS));
    holds("cull.wgsl", format!("const OUTLINED: f32 = {};", ballstick::render::gpu::clusters::OUTLINED));
    let far = |file| holds(file, "const FAR: u32 = 65535u;".to_owned());
    far("members.wgsl");
    far("owner.wgsl");
    holds("torus.wgsl", format!("const TORUS_PIECES: u32 = {}u;", ballstick::render::bounds::TORUS_PIECES));
}

/// Builds all pipelines on a device that checks everything and draws nothing, then makes every call of a picture.
fn draws_under(limits: &wgpu::Limits) {
    let mut renderer = GpuRenderer::noop(limits).unwrap();
    let cases = crate::scenes::all();
    let case = cases.iter().find(|case| case.name == "all_primitives_on_ground").unwrap();
    renderer.load(Arc::new(case.scene.clone())).unwrap();
    let settings = Settings { samples: 3, ground_texels: 2048, ao: 5, shadow: true };
    let image = renderer.image(&case.view, &settings).unwrap();
    assert_eq!((image.width, image.height), (case.view.width, case.view.height));
    // Beyond one texture: tiles.
    let wide = View::new(case.view.camera, limits.max_texture_dimension_2d.min(8192) + 70, 5);
    assert_eq!(renderer.image(&wide, &settings).unwrap().rgba.len() as u32, wide.width * 5 * 4);
    let pixels = case.view.width * case.view.height;
    assert_eq!(renderer.gbuffer(&case.view).unwrap().id.len() as u32, pixels);
    assert_eq!(renderer.sky_visibility(&case.view, 7).unwrap().open.len() as u32, pixels);
    let mut sum = Accumulation::default();
    for done in 0..3 {
        renderer.accumulate(&mut sum, &case.view, &settings, done, 1).unwrap();
    }
    assert_eq!(renderer.shown(&sum).unwrap().rgba.len() as u32, 4 * pixels);
}

#[test]
fn every_pipeline_and_pass_is_valid_under_default_limits() {
    draws_under(&wgpu::Limits::default());
}

#[test]
fn every_pipeline_and_pass_is_valid_under_webgl2_limits() {
    draws_under(&wgpu::Limits::downlevel_webgl2_defaults());
}

#[test]
fn limits_below_what_is_needed_are_an_error() {
    let limits = wgpu::Limits { max_bind_groups: 1, ..wgpu::Limits::downlevel_webgl2_defaults() };
    let error = GpuRenderer::noop(&limits).unwrap_err().to_string();
    assert!(error.starts_with("GPU: building the pipelines"), "{error}");
}
