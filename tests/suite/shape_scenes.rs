//! Scenes of cones, tori, meshes and see-through primitives.

use super::*;

fn cone(a: Vec3, b: Vec3, radii: [f32; 2], rgb: u32, id: u32) -> ConeInstance {
    let color = Srgb8::from_rgb_u32(rgb);
    let [radius_a, radius_b] = radii;
    ConeInstance { a: a.to_array(), radius_a, b: b.to_array(), radius_b, color, id, reserved: [0; 2] }
}

fn torus(center: Vec3, axis: Vec3, ring_radius: f32, tube_radius: f32, id: u32) -> TorusInstance {
    let axis = axis.normalize().to_array();
    let color = Srgb8::from_rgb_u32(0xE0_A0_20);
    TorusInstance { center: center.to_array(), ring_radius, axis, tube_radius, color, id, reserved: [0; 2] }
}

fn cones_of(cones: Vec<ConeInstance>) -> Scene {
    scene_of_block(Block { id_count: cones.len() as u32, cones, ..Block::default() })
}

fn tori_of(tori: Vec<TorusInstance>) -> Scene {
    scene_of_block(Block { id_count: tori.len() as u32, tori, ..Block::default() })
}

/// Arrowheads along ±x ±y ±z, or with both ends cut, one of them with equal radii.
fn star(ends: [f32; 2]) -> Scene {
    let directions = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z, Vec3::new(0.7, 0.7, 0.2)];
    let cones = directions.iter().enumerate().map(|(i, &d)| {
        let radii = if i == 6 { [0.25, 0.25] } else { ends };
        cone(d * 0.5, d * 1.8, radii, 0x20_80_C0 + 0x18 * i as u32, i as u32 + 1)
    });
    cones_of(cones.collect())
}

/// A bumpy ball of triangles with a colour at each corner.
fn mesh(center: Vec3, radius: f32, opacity: u8, id: u32) -> Vec<TriangleInstance> {
    let (rows, columns) = (8, 12);
    let normal = |row: i32, column: i32| {
        let up = std::f32::consts::PI * row as f32 / rows as f32;
        let around = std::f32::consts::TAU * column as f32 / columns as f32;
        Vec3::new(up.sin() * around.cos(), up.cos(), up.sin() * around.sin())
    };
    let corner = |(row, column): (i32, i32)| {
        let n = normal(row, column);
        let channel = |x: f32| (255.0 * (0.5 + 0.5 * x)) as u8;
        let color = Srgb8 { r: channel(n.x), g: channel(n.y), b: channel(n.z), a: opacity };
        (center + n * radius, n, color)
    };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let [a, b, c, d] = [(row, column), (row + 1, column), (row + 1, column + 1), (row, column + 1)].map(corner);
            for [p, q, r] in [[a, b, c], [a, c, d]] {
                triangles.push(TriangleInstance {
                    corners: [p.0, q.0, r.0].map(|p| p.to_array()),
                    normals: [p.1, q.1, r.1].map(|n| n.to_array()),
                    colors: [p.2, q.2, r.2],
                    id,
                    reserved: [0; 2],
                });
            }
        }
    }
    triangles
}

fn meshes_of(triangles: Vec<TriangleInstance>) -> Scene {
    scene_of_block(Block { id_count: 2, triangles, ..Block::default() })
}

/// A single triangle without normals, seen from its back.
fn flat_triangle() -> Scene {
    let corners = [[-1.0, -0.8, 0.3], [0.2, 0.9, -0.4], [1.2, -0.5, 0.0]];
    let colors = [0xFF_00_00, 0x00_FF_00, 0x00_00_FF].map(Srgb8::from_rgb_u32);
    meshes_of(vec![TriangleInstance { corners, normals: [[0.0; 3]; 3], colors, id: 1, reserved: [0; 2] }])
}

fn see_through(opacity: u8) -> Scene {
    let mut shell = sphere(Vec3::ZERO, 1.3, 0x40_80_F0, 1);
    shell.color.a = opacity;
    let flat = (Cap::Flat, Cap::Flat);
    let sticks = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(2..).map(|(d, id)| stick(-d, d * 1.8, 0.2, flat, id));
    scene_of(vec![shell], sticks.collect())
}

/// One of each kind, some of them see-through, over a ground.
fn everything() -> Scene {
    let mut block = Block {
        spheres: vec![sphere(Vec3::new(-1.8, 0.0, 0.0), 0.6, 0xFF_0D_0D, 1)],
        cylinders: vec![stick(Vec3::new(-1.8, 0.0, 0.0), Vec3::new(0.0, 0.0, 0.0), 0.2, (Cap::Flat, Cap::Round), 2)],
        cones: vec![cone(Vec3::ZERO, Vec3::new(0.4, 1.2, 0.2), [0.5, 0.1], 0x30_C0_40, 3)],
        tori: vec![torus(Vec3::new(1.2, 0.0, 0.4), Vec3::new(0.3, 1.0, 0.5), 0.7, 0.15, 4)],
        triangles: mesh(Vec3::new(0.6, -0.3, -1.2), 0.8, 255, 5),
        id_count: 7,
    };
    let mut faint = sphere(Vec3::new(-0.6, 0.6, 0.9), 0.5, 0x40_80_F0, 6);
    faint.color.a = 90;
    block.spheres.push(faint);
    let mut dense = torus(Vec3::new(-1.0, -0.4, 0.8), Vec3::X, 0.5, 0.2, 7);
    dense.color.a = 180;
    block.tori.push(dense);
    let mut scene = scene_of_block(block);
    scene.set_ground(true);
    scene
}

pub(super) fn cases() -> Vec<Case> {
    let straight = |name, scene| case(name, scene, camera(7.0, perspective(35.0), 0.1));
    let parallel = |name, scene| case(name, scene, camera(7.0, Projection::Orthographic { height: 4.4 }, 0.1));
    let rings = || {
        tori_of(vec![
            torus(Vec3::new(-1.6, 0.5, 0.0), Vec3::Z, 0.8, 0.2, 1),
            torus(Vec3::new(0.3, 0.5, 0.0), Vec3::X, 0.8, 0.2, 2),
            torus(Vec3::new(1.6, -0.6, 0.0), Vec3::Y, 0.8, 0.06, 3),
            torus(Vec3::new(-0.4, -1.2, 0.0), Vec3::new(0.4, 1.0, 0.5), 0.5, 0.3, 4),
        ])
    };
    let looked_down_on = |mut view: View| {
        view.camera.world_from_view = Quat::from_rotation_x(-0.35);
        view.camera.eye = view.camera.world_from_view * Vec3::new(0.0, 0.0, 8.0);
        view
    };
    let mut all = straight("all_primitives_on_ground", everything());
    all.view = looked_down_on(all.view);
    vec![
        straight("cones_pointed", star([0.35, 0.0])),
        straight("cones_truncated", star([0.15, 0.4])),
        parallel("cones_orthographic", star([0.35, 0.0])),
        case("cone_near_cut", star([0.5, 0.2]), camera(3.0, perspective(60.0), 2.2)),
        case(
            "cone_camera_inside",
            cones_of(vec![cone(Vec3::NEG_X * 3.0, Vec3::X * 3.0, [2.0, 1.0], 0x30_C0_40, 1)]),
            camera(0.5, perspective(60.0), 0.1),
        ),
        straight("tori", rings()),
        parallel("tori_orthographic", rings()),
        case("torus_near_cut", rings(), camera(3.0, perspective(70.0), 2.6)),
        case(
            "torus_camera_inside",
            tori_of(vec![torus(Vec3::X * 2.0, Vec3::Y, 2.0, 0.8, 1)]),
            camera(0.2, perspective(60.0), 0.1),
        ),
        straight("mesh", meshes_of(mesh(Vec3::ZERO, 1.5, 255, 1))),
        case("mesh_near_cut", meshes_of(mesh(Vec3::ZERO, 1.5, 255, 1)), camera(3.0, perspective(50.0), 2.4)),
        straight("triangle_from_behind", flat_triangle()),
        straight("see_through_half", see_through(128)),
        straight("see_through_faint", see_through(70)),
        straight("see_through_mesh", {
            let mut block = Block { triangles: mesh(Vec3::ZERO, 1.5, 150, 1), id_count: 2, ..Block::default() };
            block.spheres.push(sphere(Vec3::ZERO, 0.7, 0xFF_0D_0D, 2));
            scene_of_block(block)
        }),
        all,
    ]
}
