//! A triangle mesh from another tool: molecular surfaces, cages, labels. It is no [`super::Structure`], but stands in the same
//! coordinates.
//!
//! Method: a [`MeshBuilder`] collects vertices and triangles of any number of parts; [`MeshBuilder::build`] leaves out
//! triangles that are none and gives every vertex a normal. Where a vertex states none it is the sum of the cross products of
//! the edges of all triangles at its *position* (so weighted by area): vertices that a file lists once for each material or
//! texture still make one smooth surface.
//! Limits: positions are f32 about the file's origin: good to 0.0005 Å at 5,000 Å.

use crate::color::Srgb8;
use glam::Vec3;
use std::collections::HashMap;

/// A triangle mesh. All lists of vertices have the same length; every triangle has an area and only vertices that are there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    colors: Vec<Srgb8>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Positions of the vertices, ångström, in the frame of the atoms' coordinates as their file gives them.
    #[must_use]
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Unit normals, one a vertex.
    #[must_use]
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Colours with opacity, one a vertex.
    #[must_use]
    pub fn colors(&self) -> &[Srgb8] {
        &self.colors
    }

    /// Triangles by the indices of their vertices.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The edges of all triangles, each once, as vertices that stand where it ends; in the order of the triangles. Vertices at
    /// the same position are one.
    #[must_use]
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let first = first_at_position(&self.positions);
        let mut seen = std::collections::HashSet::new();
        let mut edges = Vec::new();
        for &[a, b, c] in &self.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let ends = [first[from as usize], first[to as usize]];
                if seen.insert([ends[0].min(ends[1]), ends[0].max(ends[1])]) {
                    edges.push(ends);
                }
            }
        }
        edges
    }
}

/// Collects a [`Mesh`].
#[derive(Debug, Clone, Default)]
pub struct MeshBuilder {
    mesh: Mesh,
}

impl MeshBuilder {
    /// Adds a vertex and returns its index; `normal` need not have unit length.
    pub fn push_vertex(&mut self, position: Vec3, normal: Option<Vec3>, color: Srgb8) -> u32 {
        let index = self.mesh.positions.len();
        self.mesh.positions.push(position);
        self.mesh.normals.push(normal.and_then(Vec3::try_normalize).unwrap_or(Vec3::ZERO));
        self.mesh.colors.push(color);
        u32::try_from(index).unwrap_or(u32::MAX)
    }

    /// Adds a triangle.
    pub fn push_triangle(&mut self, vertices: [u32; 3]) {
        self.mesh.triangles.push(vertices);
    }

    /// Number of triangles so far.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// Number of vertices so far.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.mesh.positions.len()
    }

    /// Finishes. Triangles without area, or with vertices that are not there or not finite, are left out.
    #[must_use]
    pub fn build(self) -> Mesh {
        let Mesh { positions, mut normals, colors, mut triangles } = self.mesh;
        // The cross product of two edges: twice the area, along the normal.
        let area = |&[a, b, c]: &[u32; 3]| {
            let corner = |index: u32| positions.get(index as usize).copied();
            let (a, b, c) = (corner(a)?, corner(b)?, corner(c)?);
            let cross = (b - a).cross(c - a);
            cross.try_normalize().map(|_| cross)
        };
        triangles.retain(|triangle| area(triangle).is_some());
        if normals.contains(&Vec3::ZERO) {
            let first = first_at_position(&positions);
            let mut sums = vec![Vec3::ZERO; positions.len()];
            for triangle in &triangles {
                let cross = area(triangle).unwrap_or(Vec3::ZERO);
                for &vertex in triangle {
                    sums[first[vertex as usize] as usize] += cross;
                }
            }
            for (vertex, normal) in normals.iter_mut().enumerate().filter(|(_, normal)| **normal == Vec3::ZERO) {
                // A vertex of two sheets back to back, or of no triangle, has no direction of its own.
                *normal = sums[first[vertex] as usize].try_normalize().unwrap_or(Vec3::Z);
            }
        }
        Mesh { positions, normals, colors, triangles }
    }
}

/// For every vertex the first one that is at the same position.
fn first_at_position(positions: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    // Adding 0 makes −0 and 0 one number.
    let key = |position: &Vec3| (*position + 0.0).to_array().map(f32::to_bits);
    (0u32..).zip(positions).map(|(index, position)| *first.entry(key(position)).or_insert(index)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A roof over the x axis, its two slopes with vertices of their own; the second one twice as wide.
    fn roof() -> MeshBuilder {
        let mut builder = MeshBuilder::default();
        for [x, y, z] in
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, -1.0], [-0.0, 0.0, 0.0], [0.0, -2.0, -2.0], [1.0, -0.0, 0.0]]
        {
            builder.push_vertex(Vec3::new(x, y, z), None, Srgb8::WHITE);
        }
        builder.push_triangle([0, 1, 2]);
        builder.push_triangle([3, 4, 5]);
        builder
    }

    #[test]
    fn normals_are_those_of_all_triangles_at_a_position_by_their_area() {
        let mesh = roof().build();
        // The slopes' normals (0, 1, 1)/√2 and (0, −1, 1)/√2, the second one of twice the weight.
        let ridge = Vec3::new(0.0, -1.0, 3.0).normalize();
        for vertex in [0, 1, 3, 5] {
            assert!((mesh.normals()[vertex] - ridge).length() < 1e-6, "{vertex}: {}", mesh.normals()[vertex]);
        }
        assert!((mesh.normals()[2] - Vec3::new(0.0, 1.0, 1.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn stated_normals_stay() {
        let mut builder = roof();
        builder.push_vertex(Vec3::X, Some(Vec3::new(0.0, 3.0, 0.0)), Srgb8::WHITE);
        builder.push_triangle([0, 6, 2]);
        assert_eq!(builder.build().normals()[6], Vec3::Y);
    }

    #[test]
    fn an_edge_that_two_triangles_share_by_position_is_one() {
        assert_eq!(roof().build().edges(), [[0, 1], [1, 2], [2, 0], [0, 4], [4, 1]]);
    }

    #[test]
    fn what_is_no_triangle_is_left_out() {
        let mut builder = roof();
        builder.push_vertex(Vec3::NAN, None, Srgb8::WHITE);
        for triangle in [[0, 0, 1], [0, 1, 99], [0, 1, 6], [0, 3, 1], [u32::MAX, 1, 2]] {
            builder.push_triangle(triangle);
        }
        let mesh = builder.build();
        assert_eq!(mesh.triangles(), [[0, 1, 2], [3, 4, 5]]);
        assert!(mesh.normals().iter().all(|normal| normal.is_normalized()));
        assert_eq!(MeshBuilder::default().build(), Mesh::default());
    }
}
