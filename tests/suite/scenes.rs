//! Small scenes, one idea each, for golden pictures and for comparing renderers.

use ballstick::color::Srgb8;
use ballstick::crystal::{self, CrystalOptions, Drawn};
use ballstick::element::Element;
use ballstick::import::{ImportOptions, read_path};
use ballstick::render::View;
use ballstick::scene::{
    Background, Block, Camera, Cap, ConeInstance, CylinderInstance, DepthOfField, Item, Look, Placement, Projection,
    Region, Scene, SceneOptions, SphereInstance, Style, TorusInstance, TriangleInstance,
};
use ballstick::structure::{AtomRecord, Bond, BondOrder, BondSource, Diagnostics, Structure, StructureBuilder};
use glam::{Affine3A, DVec3, Quat, Vec3};

#[path = "shape_scenes.rs"]
mod shapes;

/// A scene and how it is looked at.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) scene: Scene,
    pub(crate) view: View,
}

const WIDTH: u32 = 128;
const HEIGHT: u32 = 96;

/// The molecules of `data/` by the names of their files, as they are drawn.
pub(crate) fn molecules() -> Vec<(String, Drawn)> {
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let mut files: Vec<_> = std::fs::read_dir(data).unwrap().map(|entry| entry.unwrap().path()).collect();
    // Notes, the schema and the dictionary are no molecules.
    let is_molecule = |name: &str| ![".md", ".schema.json", ".bin"].iter().any(|ending| name.ends_with(ending));
    files.retain(|path| path.is_file() && is_molecule(&path.to_string_lossy()));
    files.sort();
    assert!(files.len() > 5, "data/ is missing");
    let drawn = |path: &std::path::PathBuf| {
        let document = read_path(path, &ImportOptions::default()).unwrap();
        let drawn = crystal::draw(document.records[0].clone(), &CrystalOptions::default()).unwrap();
        (path.file_name().unwrap().to_string_lossy().into_owned(), drawn)
    };
    files.iter().map(drawn).collect()
}

fn sphere(center: Vec3, radius: f32, rgb: u32, id: u32) -> SphereInstance {
    SphereInstance { center: center.to_array(), radius, color: Srgb8::from_rgb_u32(rgb), id }
}

fn stick(a: Vec3, b: Vec3, radius: f32, caps: (Cap, Cap), id: u32) -> CylinderInstance {
    CylinderInstance {
        a: a.to_array(),
        radius,
        b: b.to_array(),
        id,
        color_a: Srgb8::from_rgb_u32(0x30_50_F8),
        color_b: Srgb8::from_rgb_u32(0xFF_8C_00),
        caps: CylinderInstance::pack_caps(caps.0, caps.1),
        hidden: 0,
    }
}

fn scene_of(spheres: Vec<SphereInstance>, cylinders: Vec<CylinderInstance>) -> Scene {
    let id_count = (spheres.len() + cylinders.len()) as u32;
    scene_of_block(Block { spheres, cylinders, id_count, ..Block::default() })
}

fn scene_of_block(block: Block) -> Scene {
    let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
    Scene::from_blocks(vec![block], vec![placement])
}

/// A camera on the z axis that looks at the origin.
fn camera(distance: f32, projection: Projection, near: f32) -> Camera {
    Camera {
        eye: Vec3::new(0.0, 0.0, distance),
        world_from_view: Quat::IDENTITY,
        projection,
        near,
        far: distance + 100.0,
        target: Vec3::ZERO,
        shift: [0.0; 2],
    }
}

fn perspective(fov_deg: f32) -> Projection {
    Projection::Perspective { fov_y_rad: fov_deg.to_radians() }
}

fn case(name: &'static str, scene: Scene, camera: Camera) -> Case {
    Case { name, scene, view: View::new(camera, WIDTH, HEIGHT) }
}

/// A molecule from elements, positions and bonds.
pub(crate) fn molecule(atoms: &[(u8, [f64; 3])], bonds: &[(u32, u32, u32)]) -> Structure {
    let mut builder = StructureBuilder::new();
    for &(z, position) in atoms {
        let element = Element::from_z(z).unwrap();
        builder.push_atom(&AtomRecord { element, position: DVec3::from(position), ..AtomRecord::default() });
    }
    for &(a, b, order) in bonds {
        builder.push_bond(Bond::new(a, b, BondOrder::from_number(order), BondSource::File));
    }
    builder.build(&mut Diagnostics::default())
}

/// Acrolein with a nitrile: single, double and triple bonds, hydrogens, oxygen, nitrogen.
pub(crate) fn small_molecule() -> Structure {
    molecule(
        &[
            (6, [0.0, 0.0, 0.0]),
            (6, [1.34, 0.0, 0.1]),
            (6, [2.1, 1.25, 0.0]),
            (8, [3.3, 1.25, 0.1]),
            (1, [1.55, 2.2, -0.1]),
            (1, [1.9, -0.93, 0.1]),
            (1, [-0.55, 0.93, 0.0]),
            (6, [-0.8, -1.2, -0.2]),
            (7, [-1.4, -2.2, -0.3]),
        ],
        &[(0, 1, 2), (1, 2, 1), (2, 3, 2), (2, 4, 1), (1, 5, 1), (0, 6, 1), (0, 7, 1), (7, 8, 3)],
    )
}

fn fitted(name: &'static str, options: &SceneOptions) -> Case {
    let structure = small_molecule();
    let scene = Scene::new(&[Item::of(&structure)], options);
    let view = View::new(scene.fitted_camera(WIDTH as f32 / HEIGHT as f32), WIDTH, HEIGHT);
    Case { name, scene, view }
}

/// All cases.
pub(crate) fn all() -> Vec<Case> {
    let flat = (Cap::Flat, Cap::Flat);
    let ball = |center, radius| scene_of(vec![sphere(center, radius, 0xC0_40_40, 1)], vec![]);
    let bare = SceneOptions { ground: false, ..SceneOptions::default() };
    let mut cases = vec![
        case("sphere_perspective", ball(Vec3::ZERO, 1.0), camera(5.0, perspective(30.0), 0.1)),
        case("sphere_orthographic", ball(Vec3::ZERO, 1.0), camera(5.0, Projection::Orthographic { height: 3.0 }, 0.1)),
        case("sphere_off_centre", ball(Vec3::new(4.2, 2.6, 0.0), 1.0), camera(4.0, perspective(80.0), 0.1)),
        case("sphere_camera_inside", ball(Vec3::ZERO, 10.0), camera(2.0, perspective(60.0), 0.1)),
        case("sphere_near_cut", ball(Vec3::ZERO, 1.0), camera(3.0, perspective(50.0), 2.4)),
        case("spheres_intersecting", two_balls(), camera(6.0, perspective(30.0), 0.1)),
        case("sticks_along_axes", axes(flat), camera(7.0, perspective(35.0), 0.1)),
        case("sticks_along_axes_orthographic", axes(flat), camera(7.0, Projection::Orthographic { height: 4.4 }, 0.1)),
        case("stick_at_camera", end_on(flat), camera(4.0, perspective(40.0), 0.1)),
        case("stick_at_camera_orthographic", end_on(flat), camera(4.0, Projection::Orthographic { height: 2.0 }, 0.1)),
        case("stick_near_cut", end_on(flat), camera(3.0, perspective(60.0), 2.2)),
        case("stick_camera_inside", thick_stick(), camera(0.5, perspective(60.0), 0.1)),
        case("sticks_round", axes((Cap::Round, Cap::Round)), camera(7.0, perspective(35.0), 0.1)),
        case("sticks_open", axes((Cap::None, Cap::None)), camera(7.0, perspective(35.0), 0.1)),
        case("sticks_mixed_caps", axes((Cap::Round, Cap::None)), camera(7.0, perspective(35.0), 0.1)),
        case("nothing", scene_of(vec![], vec![]), camera(5.0, perspective(30.0), 0.1)),
        case("zero_length_stick", zero_length(), camera(5.0, perspective(30.0), 0.1)),
        case("placements", placements(), camera(9.0, perspective(35.0), 0.1)),
        fitted("molecule", &bare),
        fitted("molecule_on_ground", &SceneOptions::default()),
        fitted("molecule_orthographic", &SceneOptions { perspective: false, ..SceneOptions::default() }),
        fitted("molecule_licorice", &SceneOptions { style: Style::Licorice, ..bare.clone() }),
        fitted("molecule_space_filling", &SceneOptions { style: Style::SpaceFilling, ..SceneOptions::default() }),
        fitted("molecule_wireframe", &SceneOptions { style: Style::Wireframe, ..bare.clone() }),
        fitted(
            "molecule_transparent",
            &SceneOptions { background: Background::Transparent, ..SceneOptions::default() },
        ),
        fitted(
            "molecule_dark",
            &SceneOptions { background: Background::Color(Srgb8::rgb(20, 24, 32)), ..SceneOptions::default() },
        ),
        fitted(
            "depth_of_field",
            &SceneOptions { depth_of_field: Some(DepthOfField { blur: 0.06, focus: 0.5 }), ..SceneOptions::default() },
        ),
        fogged(),
    ];
    for case in cases.iter_mut().filter(|case| ["fog", "sphere_camera_inside"].contains(&case.name)) {
        // Of their own: what looks have may change.
        case.scene.lighting.fog = 0.5;
    }
    let mut part = fitted("molecule_region", &SceneOptions::default());
    (part.view.width, part.view.height) = (512, 384);
    part.view.region = Some(Region { x: 170, y: 150, width: WIDTH, height: HEIGHT });
    cases.push(part);
    cases.extend(shapes::cases());
    cases.extend(outlined(&cases));
    cases
}

/// Lines around things: in the looks that have them, and broad ones around all kinds of primitives.
fn outlined(cases: &[Case]) -> Vec<Case> {
    let look = |name, look, style| fitted(name, &SceneOptions { look, style, ..SceneOptions::default() });
    let mut lined = vec![
        look("molecule_outline", Look::Outline, Style::BallAndStick),
        look("molecule_outline_licorice", Look::Outline, Style::Licorice),
        look("molecule_illustrative", Look::Illustrative, Style::SpaceFilling),
        case("outlines_of_crossing_sticks", crossing_sticks(), camera(6.0, perspective(30.0), 0.1)),
    ];
    for (name, of) in [
        ("outlines_of_all_primitives", "all_primitives_on_ground"),
        ("outlines_of_mixed_caps", "sticks_mixed_caps"),
        ("outlines_of_tori_orthographic", "tori_orthographic"),
        ("outlines_near_cut", "stick_near_cut"),
        ("outlines_see_through", "see_through_half"),
    ] {
        let found = cases.iter().find(|case| case.name == of).unwrap();
        lined.push(Case { name, scene: found.scene.clone(), view: found.view });
    }
    for case in &mut lined {
        // Wide enough to be seen in so few pixels.
        case.scene.lighting.outline.width = 0.012;
        case.scene.lighting.outline.color = Srgb8::rgb(16, 16, 48);
    }
    lined
}

/// A stick before another, and one that leaves a ball towards the viewer.
fn crossing_sticks() -> Scene {
    let flat = (Cap::Flat, Cap::Flat);
    let at = Vec3::new;
    scene_of(
        vec![sphere(at(-0.9, -0.5, 0.0), 0.45, 0xD0_D0_D0, 1)],
        vec![
            stick(at(-1.6, 0.9, -0.5), at(1.6, -0.2, -0.5), 0.15, flat, 2),
            stick(at(0.3, -1.3, 0.4), at(0.7, 1.3, 0.4), 0.15, flat, 3),
            stick(at(-0.9, -0.5, 0.0), at(-0.2, -0.7, 1.0), 0.15, flat, 4),
            stick(at(-0.9, -0.5, 0.0), at(-1.6, -0.9, -1.2), 0.15, flat, 5),
        ],
    )
}

fn two_balls() -> Scene {
    let balls = vec![
        sphere(Vec3::new(-0.5, 0.0, 0.0), 1.0, 0xFF_0D_0D, 1),
        sphere(Vec3::new(0.5, 0.2, 0.3), 0.8, 0x90_90_90, 2),
    ];
    scene_of(balls, vec![])
}

/// Six sticks from the origin along ±x ±y ±z, and one askew.
fn axes(caps: (Cap, Cap)) -> Scene {
    let directions = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z, Vec3::new(0.7, 0.7, 0.2)];
    let sticks =
        directions.iter().enumerate().map(|(i, &d)| stick(d * 0.5, d * 1.8, 0.25, caps, i as u32 + 1)).collect();
    scene_of(vec![], sticks)
}

fn end_on(caps: (Cap, Cap)) -> Scene {
    scene_of(vec![], vec![stick(Vec3::new(0.0, 0.0, -2.0), Vec3::Z, 0.4, caps, 1)])
}

fn thick_stick() -> Scene {
    scene_of(vec![], vec![stick(Vec3::NEG_X * 3.0, Vec3::X * 3.0, 2.0, (Cap::Flat, Cap::Flat), 1)])
}

fn zero_length() -> Scene {
    let nothing = stick(Vec3::ONE * 0.3, Vec3::ONE * 0.3, 0.3, (Cap::Round, Cap::Round), 2);
    scene_of(vec![sphere(Vec3::ZERO, 0.5, 0x3D_FF_00, 1)], vec![nothing])
}

/// One block placed three times, turned and mirrored.
fn placements() -> Scene {
    let block = Block {
        spheres: vec![sphere(Vec3::ZERO, 0.5, 0xFF_0D_0D, 1), sphere(Vec3::X, 0.3, 0xFF_FF_FF, 2)],
        cylinders: vec![stick(Vec3::ZERO, Vec3::X, 0.12, (Cap::Flat, Cap::Flat), 3)],
        id_count: 3,
        ..Block::default()
    };
    let mirrored = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let places = [
        Affine3A::from_translation(Vec3::new(-1.5, 1.0, 0.0)),
        Affine3A::from_translation(Vec3::new(1.0, 1.0, 0.0)) * Affine3A::from_rotation_z(2.0),
        Affine3A::from_translation(Vec3::new(0.0, -1.2, 0.5)) * mirrored,
    ];
    let placements = places
        .iter()
        .enumerate()
        .map(|(i, &world_from_block)| Placement { block: 0, world_from_block, first_id: 3 * i as u32 })
        .collect();
    Scene::from_blocks(vec![block], placements)
}

/// A row of balls 80 Å deep.
fn fogged() -> Case {
    let balls =
        (0..9).map(|i| sphere(Vec3::new(i as f32 * 6.0 - 24.0, 0.0, 40.0 - i as f32 * 10.0), 4.0, 0xFF_0D_0D, i + 1));
    case("fog", scene_of(balls.collect(), vec![]), camera(120.0, perspective(35.0), 1.0))
}

/// Light from afar takes sticks for granted whose caps lie in balls ([`CylinderInstance::hidden`]).
#[test]
fn caps_that_are_said_to_lie_in_balls_do() {
    let (mut hidden, mut ends_of_all) = (0, 0);
    for (name, drawn) in molecules() {
        for style in Style::ALL {
            let scene = Scene::new(&[Item::drawn(&drawn, None)], &SceneOptions { style, ..SceneOptions::default() });
            for block in scene.blocks.iter() {
                for stick in &block.cylinders {
                    ends_of_all += 2;
                    let ends = [Vec3::from(stick.a), Vec3::from(stick.b)];
                    let axis = (ends[1] - ends[0]).normalize();
                    for (_, end) in (0..).zip(ends).filter(|(bit, _)| stick.hidden >> bit & 1 != 0) {
                        hidden += 1;
                        // The point of the cap's edge that is farthest from the ball's centre.
                        let lies_in = |ball: &SphereInstance| {
                            let off = end - Vec3::from(ball.center);
                            let along = off.dot(axis);
                            along.hypot((off - axis * along).length() + stick.radius) <= ball.radius + 1e-3
                        };
                        assert!(block.spheres.iter().any(lies_in), "{name} {style:?}: {stick:?}");
                    }
                }
            }
        }
    }
    // Dashes and the inner sticks of rings have no ball.
    assert!(2 * hidden > ends_of_all, "{hidden} of {ends_of_all}");
}

#[test]
fn a_cage_has_its_kekule_form_and_a_lone_five_membered_ring_keeps_its_ring() {
    let counts = |name: &str| {
        let (_, drawn) = molecules().into_iter().find(|(file, _)| file == name).unwrap();
        let scene = Scene::new(&[Item::of(&drawn.structure)], &SceneOptions::default());
        (scene.cylinder_count(), scene.blocks.iter().map(|block| block.tori.len()).sum::<usize>())
    };
    // 60 single bonds, 30 double ones between six-membered rings.
    assert_eq!(counts("c60.xyz"), (60 + 2 * 30, 0));
    assert_eq!(counts("ferrocene.xyz").1, 2);
    // Of caffeine the five-membered ring; the other has two C=O.
    assert_eq!(counts("benzene.xyz").1, 1);
}
