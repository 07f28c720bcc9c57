//! Triangle meshes laid over the molecules, in the coordinates of the atoms' files.

use super::instances::{Cap, CylinderInstance};
use super::shapes::TriangleInstance;
use super::{Block, SceneOptions};
use crate::color::Srgb8;
use crate::structure::Mesh;
use glam::{DVec3, Vec3};

/// Radius of a wire in mean lengths of the edges, and its least and most in ångström (chosen: a fine net on a dense surface, and a
/// cage of few long edges still thinner than a bond).
const WIRE: (f32, f32, f32) = (0.02, 0.008, 0.06);

/// The mesh as a block of its own, relative to `center`; everything has the id 1.
pub(super) fn block(mesh: &Mesh, center: DVec3, options: &SceneOptions) -> Block {
    let place = |vertex: u32| (mesh.positions()[vertex as usize].as_dvec3() - center).as_vec3();
    let opacity = options.overlay_opacity.unwrap_or(1.0).clamp(0.0, 1.0);
    let color = |vertex: u32| {
        let own = mesh.colors()[vertex as usize];
        let Srgb8 { r, g, b, a } =
            options.overlay_color.map_or(own, |color| Srgb8 { a: product(color.a, own.a), ..color });
        Srgb8 { r, g, b, a: (f32::from(a) * opacity).round() as u8 }
    };
    let mut block = Block { id_count: 1, ..Block::default() };
    if options.overlay_wireframe {
        let edges = mesh.edges();
        let length = |&[a, b]: &[u32; 2]| place(a).distance(place(b));
        let mean = edges.iter().map(length).sum::<f32>() / edges.len().max(1) as f32;
        let radius = (WIRE.0 * mean).clamp(WIRE.1, WIRE.2);
        block.cylinders = (edges.iter())
            .map(|&[a, b]| CylinderInstance {
                a: place(a).to_array(),
                radius,
                b: place(b).to_array(),
                id: 1,
                color_a: color(a),
                color_b: color(b),
                // Round ends meet at the vertices without gaps.
                caps: CylinderInstance::pack_caps(Cap::Round, Cap::Round),
                hidden: 0,
            })
            .collect();
    } else {
        let normal = |vertex: u32| -> Vec3 { mesh.normals()[vertex as usize] };
        block.triangles = (mesh.triangles().iter())
            .map(|triangle| TriangleInstance {
                corners: triangle.map(|vertex| place(vertex).to_array()),
                normals: triangle.map(|vertex| normal(vertex).to_array()),
                colors: triangle.map(color),
                id: 1,
                reserved: [0; 2],
            })
            .collect();
    }
    block
}

/// Of two opacities.
fn product(a: u8, b: u8) -> u8 {
    ((u16::from(a) * u16::from(b) + 127) / 255) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Item, Orientation, Scene};
    use crate::structure::MeshBuilder;
    use std::sync::Arc;

    /// A triangle whose corners are where the atoms of the test's file are.
    fn options() -> SceneOptions {
        let mut builder = MeshBuilder::default();
        for corner in [[5000.0, 0.0, 1.0], [5003.0, 0.0, 0.0], [5000.0, 4.0, 0.0], [5003.0, 4.0, 0.0]] {
            builder.push_vertex(corner.into(), None, Srgb8 { r: 255, g: 0, b: 0, a: 200 });
        }
        builder.push_triangle([0, 1, 2]);
        builder.push_triangle([1, 2, 3]);
        SceneOptions { overlay: vec![Arc::new(builder.build())], ..SceneOptions::default() }
    }

    fn scene(options: &SceneOptions) -> Scene {
        let text = b"3\n\nC 5000 0 1\nC 5003 0 0\nC 5000 4 0\n";
        let document = crate::import::read_bytes(text, "a.xyz", &Default::default()).unwrap();
        Scene::new(&[Item::of(&document.records[0])], options)
    }

    fn world(scene: &Scene, point: [f32; 3]) -> Vec3 {
        scene.placements[1].world_from_block.transform_point3(point.into())
    }

    #[test]
    fn a_mesh_lands_where_atoms_with_its_coordinates_land_however_the_scene_is_turned() {
        let along = Orientation::Along { direction: Vec3::new(1.0, 2.0, 3.0), up: Vec3::Y };
        for orientation in [Orientation::Auto, along] {
            let scene = scene(&SceneOptions { orientation, ..options() });
            let corners = scene.blocks[1].triangles[0].corners.map(|corner| world(&scene, corner));
            for (corner, (atom, _)) in corners.into_iter().zip(scene.world_spheres()) {
                assert!((corner - atom).length() < 2e-3, "{corner} {atom}");
            }
            assert!(scene.bounds().distance(corners[2]) == 0.0);
        }
    }

    #[test]
    fn colour_opacity_and_wires_are_as_asked_for() {
        let colors = |options: &SceneOptions| scene(options).blocks[1].triangles[0].colors;
        assert_eq!(colors(&options()), [Srgb8 { r: 255, g: 0, b: 0, a: 200 }; 3]);
        let blue = SceneOptions { overlay_color: Some(Srgb8::rgb(0, 0, 255)), overlay_opacity: Some(0.5), ..options() };
        assert_eq!(colors(&blue), [Srgb8 { r: 0, g: 0, b: 255, a: 100 }; 3]);
        let wires = scene(&SceneOptions { overlay_wireframe: true, ..options() });
        assert_eq!((wires.blocks[1].cylinders.len(), wires.blocks[1].triangles.len()), (5, 0));
        assert!(wires.blocks[1].cylinders.iter().all(|wire| wire.radius > 0.0 && wire.radius < 0.1));
    }

    #[test]
    fn all_of_a_mesh_is_in_the_picture() {
        let mut builder = MeshBuilder::default();
        for corner in [[0.0, 0.0, 0.0], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0]] {
            builder.push_vertex(corner.into(), None, Srgb8::WHITE);
        }
        builder.push_triangle([0, 1, 2]);
        let document = crate::import::read_bytes(b"1\n\nC 0 0 0\n", "a.xyz", &Default::default()).unwrap();
        for overlay_wireframe in [false, true] {
            let overlay = vec![Arc::new(builder.clone().build())];
            let options = SceneOptions { overlay, overlay_wireframe, ..SceneOptions::default() };
            let scene = Scene::new(&[Item::of(&document.records[0])], &options);
            let camera = scene.fitted_camera(1.0);
            let tip = camera.view_from_world().transform_point3(Vec3::new(40.0, 0.0, 0.0));
            let half = (0.5 * super::super::fit::FOV_Y_RAD).tan() * -tip.z;
            assert!(tip.x.abs() < half && tip.y.abs() < half, "{tip} {half}");
        }
    }
}
