//! The edges of a unit cell as thin sticks: **a** red, **b** green, **c** blue from the origin, the others grey.

use super::Block;
use super::instances::{Cap, CylinderInstance};
use crate::color::Srgb8;
use crate::structure::Cell;
use glam::{DVec3, Vec3};

/// Radius of an edge as a part of the longest one, and its least and most in ångström: thin beside sticks (0.13 Å), and
/// still seen in the picture of a large box.
const RADIUS: (f64, f64, f64) = (0.0015, 0.02, 0.15);
const GREY: Srgb8 = Srgb8::rgb(110, 110, 110);
/// Colours of **a**, **b** and **c**, and of x, y and z.
pub(super) const AXES: [Srgb8; 3] = [Srgb8::rgb(200, 40, 40), Srgb8::rgb(40, 150, 40), Srgb8::rgb(50, 80, 210)];

/// The twelve edges of a cell whose corner is at `corner`; all have the id 1.
pub(super) fn block(cell: &Cell, corner: Vec3) -> Block {
    let vectors = cell.vectors();
    let longest = cell.lengths().into_iter().fold(0.0, f64::max);
    let radius = (RADIUS.0 * longest).clamp(RADIUS.1, RADIUS.2) as f32;
    let mut cylinders = Vec::with_capacity(12);
    for axis in 0..3 {
        let (side, other) = (vectors[(axis + 1) % 3], vectors[(axis + 2) % 3]);
        for start in [DVec3::ZERO, side, other, side + other] {
            let from = corner + start.as_vec3();
            let color = if start == DVec3::ZERO { AXES[axis] } else { GREY };
            cylinders.push(CylinderInstance {
                a: from.to_array(),
                b: (from + vectors[axis].as_vec3()).to_array(),
                radius,
                id: 1,
                color_a: color,
                color_b: color,
                // Round ends meet at the corners without gaps.
                caps: CylinderInstance::pack_caps(Cap::Round, Cap::Round),
                hidden: 0,
            });
        }
    }
    Block { cylinders, id_count: 1, ..Block::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twelve_edges_meet_at_eight_corners() {
        let cell = Cell::from_parameters([3.0, 4.0, 5.0], [80.0, 95.0, 110.0]).unwrap();
        let block = block(&cell, Vec3::ONE);
        let mut corners: Vec<[i32; 3]> = (block.cylinders.iter())
            .flat_map(|edge| [edge.a, edge.b])
            .map(|p| p.map(|x| (x * 1000.0).round() as i32))
            .collect();
        corners.sort_unstable();
        assert_eq!(corners.len(), 24);
        corners.dedup();
        assert_eq!(corners.len(), 8);
        assert!(corners.contains(&[1000; 3]));
        assert_eq!(block.cylinders.iter().filter(|edge| edge.color_a != GREY).count(), 3);
    }
}
