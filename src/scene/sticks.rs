//! Sticks of a bond: one, two or three, in the plane of the neighbours, inside the ring in a ring.
//!
//! A bond outside rings has its sticks side by side; a double or aromatic bond of a ring (up to
//! [`MAX_RING`] atoms) keeps one stick on the axis and gets a thinner, shorter one on the ring's inner side.
//! Where a bond is to be drawn as aromatic, that second stick is a row of dashes.
//! Sticks end inside the balls, so that no flat end shows and nothing is drawn twice; the inner stick of a ring ends free and round.

use super::dashes::dashes;
use super::instances::{Cap, CylinderInstance};
use crate::math::direction_or;
use crate::structure::{Bond, BondKind, BondOrder, ByAtom};
use glam::Vec3;
use std::collections::VecDeque;

/// Larger rings are drawn as chains: from nine atoms on "inside" no longer helps the eye.
const MAX_RING: usize = 8;

/// The partners of every atom, over the bonds for which `keep` holds.
pub(super) fn neighbours(atom_count: usize, bonds: &[Bond], keep: impl Fn(&Bond) -> bool) -> ByAtom<u32> {
    let ends = |bond: &Bond| [(bond.a, bond.b), (bond.b, bond.a)];
    ByAtom::new(atom_count, || bonds.iter().filter(|bond| keep(bond)).flat_map(ends))
}

/// One stick beside the axis of its bond.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Strand {
    /// Offset from the axis in ångström.
    offset: Vec3,
    /// Radius in ångström.
    radius: f32,
    /// How much each end is drawn back from its atom, beyond what the ball hides.
    shortened: f32,
    /// Whether it is a row of dashes.
    is_dashed: bool,
}

/// Everything a stick needs beside its bond.
pub(super) struct StickContext<'a> {
    pub(super) positions: &'a [Vec3],
    pub(super) neighbours: &'a ByAtom<u32>,
    /// Radius of the balls in ångström.
    pub(super) ball_radius: &'a (dyn Fn(u32) -> f32 + Sync),
    /// Radius of a single stick in ångström.
    pub(super) stick_radius: f32,
    /// Radius that the sticks of a multiple bond are proportioned by, in ångström.
    pub(super) multiple_radius: f32,
    /// Whether sticks without a ball to hide in need round ends.
    pub(super) round_ends: bool,
}

impl StickContext<'_> {
    /// The sticks of a bond whose far end is at `b`, written through `push`; a bond of zero length has none. The balls of its
    /// atoms are drawn, but for one that `b` is an image of. `ring` are the atoms of the [`ring`] that it is in.
    pub(super) fn sticks(
        &self,
        bond: &Bond,
        b: Vec3,
        ring: Option<&[u32]>,
        template: CylinderInstance,
        mut push: impl FnMut(CylinderInstance),
    ) {
        let a = self.positions[bond.a as usize];
        let axis = b - a;
        let length = axis.length();
        if length.is_nan() || length < 1e-6 {
            return;
        }
        let axis = axis / length;
        let single = Strand { offset: Vec3::ZERO, radius: self.stick_radius, shortened: 0.0, is_dashed: false };
        // Of a bond that goes to an image no ring is known.
        let is_there = b == self.positions[bond.b as usize];
        let (strands, count) = self.strands(bond, axis, single, ring.filter(|_| is_there));
        for strand in &strands[..count] {
            // Hidden in both balls by the same length, so that the colours meet in the middle of the bond.
            let reach = strand.offset.length() + strand.radius;
            let hidden = |atom: u32| {
                let radius = (self.ball_radius)(atom);
                0.9 * (radius * radius - reach * reach).max(0.0).sqrt()
            };
            let inset = (hidden(bond.a).min(hidden(bond.b)) + strand.shortened).min(0.45 * length);
            // An end that shows (no ball hides it) is round unless the stick merely meets the next one on the axis.
            let shows = |atom: u32| reach > (self.ball_radius)(atom) + 1e-4;
            let free = strand.shortened > 0.0;
            let cap = |atom: u32| if free || shows(atom) && self.round_ends { Cap::Round } else { Cap::Flat };
            let hides = |atom: u32, is_drawn: bool| u32::from(is_drawn && !free && !shows(atom));
            let [from, to] = [a + strand.offset + axis * inset, b + strand.offset - axis * inset];
            if strand.is_dashed {
                dashes(from, to, CylinderInstance { radius: strand.radius, ..template }, &mut push);
                continue;
            }
            push(CylinderInstance {
                a: from.to_array(),
                b: to.to_array(),
                radius: strand.radius,
                caps: CylinderInstance::pack_caps(cap(bond.a), cap(bond.b)),
                hidden: hides(bond.a, true) | hides(bond.b, is_there) << 1,
                ..template
            });
        }
    }

    fn strands(&self, bond: &Bond, axis: Vec3, single: Strand, ring: Option<&[u32]>) -> ([Strand; 4], usize) {
        let r = self.multiple_radius;
        if !is_multiple(bond) {
            return ([single; 4], 1);
        }
        let side = self.side(bond, axis);
        let beside = |offset: f32, radius: f32| Strand { offset: side * offset, radius, ..single };
        match bond.order {
            BondOrder::Triple => {
                let (gap, thin) = (1.25 * r, 0.5 * r);
                ([beside(-gap, thin), beside(0.0, thin), beside(gap, thin), single], 3)
            }
            BondOrder::Quadruple => {
                let other = axis.cross(side);
                let (gap, thin) = (0.8 * r, 0.45 * r);
                let corner = |u: f32, v: f32| Strand { offset: (side * u + other * v) * gap, radius: thin, ..single };
                ([corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)], 4)
            }
            _ => match ring.map(|ring| self.middle(ring)) {
                Some(center) => {
                    let middle = (self.positions[bond.a as usize] + self.positions[bond.b as usize]) * 0.5;
                    let inward = center - middle;
                    let inward = direction_or(inward - axis * inward.dot(axis), side);
                    // The inner stick is a chord of the ring's inside: drawn back by what keeps neighbours apart.
                    let (offset, is_dashed) = (inward * 1.75 * r, bond.aromatic);
                    let inner = Strand { offset, radius: 0.5 * r, shortened: 1.4 * r, is_dashed };
                    let main = Strand { radius: 0.8 * r, ..single };
                    ([main, inner, single, single], 2)
                }
                None => {
                    let (gap, thin) = (0.85 * r, 0.6 * r);
                    let second = Strand { is_dashed: bond.aromatic, ..beside(gap, thin) };
                    ([beside(-gap, thin), second, single, single], 2)
                }
            },
        }
    }

    /// The unit vector across the bond in the plane of its neighbours; any perpendicular where they say nothing
    /// (diatomics, straight chains without ends).
    fn side(&self, bond: &Bond, axis: Vec3) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for (end, other) in [(bond.a, bond.b), (bond.b, bond.a)] {
            self.add_sides(end, other, axis, &mut sum);
        }
        if sum == Vec3::ZERO {
            // A straight atom (allene, CO2, nitrile): take the plane at the far end of its other bond.
            for (end, other) in [(bond.a, bond.b), (bond.b, bond.a)] {
                for &next in self.neighbours.of(end as usize).iter().filter(|&&next| next != other) {
                    self.add_sides(next, end, axis, &mut sum);
                }
            }
            // Across consecutive double bonds the planes alternate by 90°.
            sum = axis.cross(sum);
        }
        direction_or(sum, axis.any_orthonormal_vector())
    }

    /// Adds the parts across `axis` of the directions from `end` to its neighbours but `other`, turned to agree in sign.
    fn add_sides(&self, end: u32, other: u32, axis: Vec3, sum: &mut Vec3) {
        let from = self.positions[end as usize];
        for &next in self.neighbours.of(end as usize).iter().filter(|&&next| next != other) {
            let direction = direction_or(self.positions[next as usize] - from, Vec3::ZERO);
            let across = direction - axis * direction.dot(axis);
            // Under 6° from straight the direction is noise.
            if across.length_squared() > 0.01 {
                *sum += if across.dot(*sum) < 0.0 { -across } else { across };
            }
        }
    }

    fn middle(&self, atoms: &[u32]) -> Vec3 {
        atoms.iter().map(|&atom| self.positions[atom as usize]).sum::<Vec3>() / atoms.len().max(1) as f32
    }
}

/// Whether a bond has several sticks.
pub(super) fn is_multiple(bond: &Bond) -> bool {
    bond.kind == BondKind::Covalent && (bond.aromatic || bond.order >= BondOrder::Double)
}

/// The atoms of the smallest ring (3 to [`MAX_RING`] atoms) that the bond is in.
pub(super) fn ring(neighbours: &ByAtom<u32>, bond: &Bond) -> Option<Box<[u32]>> {
    // Breadth first from one atom to the other without the bond itself; paths stay short, so lists beat maps.
    let mut reached: Vec<(u32, u32)> = vec![(bond.a, u32::MAX)]; // atom, index of the one before
    let mut queue: VecDeque<(u32, usize)> = VecDeque::from([(0, 1)]); // index into `reached`, atoms so far
    while let Some((at, atoms)) = queue.pop_front() {
        let atom = reached[at as usize].0;
        for &next in neighbours.of(atom as usize) {
            if atom == bond.a && next == bond.b || reached.iter().any(|&(seen, _)| seen == next) {
                continue;
            }
            if next == bond.b {
                let mut ring = vec![bond.b];
                let mut back = at;
                while back != u32::MAX {
                    ring.push(reached[back as usize].0);
                    back = reached[back as usize].1;
                }
                return Some(ring.into_boxed_slice());
            }
            // Bounded by what a ring of this size can reach: hubs of metal clusters would visit the whole cluster.
            if atoms + 1 < MAX_RING && reached.len() < 256 {
                reached.push((next, at));
                queue.push_back((reached.len() as u32 - 1, atoms + 1));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::BondSource;

    fn sticks_of(positions: &[Vec3], bonds: &[Bond], which: usize) -> Vec<CylinderInstance> {
        let neighbours = neighbours(positions.len(), bonds, |_| true);
        let context = StickContext {
            positions,
            neighbours: &neighbours,
            ball_radius: &|_| 0.4,
            stick_radius: 0.13,
            multiple_radius: 0.13,
            round_ends: false,
        };
        let mut sticks = Vec::new();
        let end = positions[bonds[which].b as usize];
        let ring = ring(&neighbours, &bonds[which]);
        context.sticks(&bonds[which], end, ring.as_deref(), bytemuck::Zeroable::zeroed(), |stick| sticks.push(stick));
        sticks
    }

    fn bond(a: u32, b: u32, order: BondOrder) -> Bond {
        Bond::new(a, b, order, BondSource::File)
    }

    fn offset(stick: &CylinderInstance, a: Vec3, b: Vec3) -> Vec3 {
        (Vec3::from(stick.a) + Vec3::from(stick.b) - a - b) * 0.5
    }

    #[test]
    fn a_double_bond_lies_in_the_plane_of_its_neighbours() {
        // Ethene in the xz plane.
        let p = [
            Vec3::new(-0.67, 0.0, 0.0),
            Vec3::new(0.67, 0.0, 0.0),
            Vec3::new(-1.24, 0.0, 0.93),
            Vec3::new(-1.24, 0.0, -0.93),
            Vec3::new(1.24, 0.0, 0.93),
        ];
        let bonds = [
            bond(0, 1, BondOrder::Double),
            bond(0, 2, BondOrder::Single),
            bond(0, 3, BondOrder::Single),
            bond(1, 4, BondOrder::Single),
        ];
        let sticks = sticks_of(&p, &bonds, 0);
        assert_eq!(sticks.len(), 2);
        for stick in &sticks {
            let offset = offset(stick, p[0], p[1]);
            assert!(offset.y.abs() < 1e-6 && offset.x.abs() < 1e-6 && offset.z.abs() > 0.05, "{offset}");
        }
        let gap = (Vec3::from(sticks[0].a) - Vec3::from(sticks[1].a)).length() - 2.0 * sticks[0].radius;
        assert!(gap > 0.03, "the sticks must not touch: {gap}");
    }

    #[test]
    fn in_a_ring_the_second_stick_is_inside() {
        let hexagon: Vec<Vec3> = (0..6)
            .map(|i| {
                let angle = i as f32 * std::f32::consts::TAU / 6.0;
                Vec3::new(1.39 * angle.cos(), 1.39 * angle.sin(), 0.0)
            })
            .collect();
        let mut bonds: Vec<Bond> = (0..6).map(|i| bond(i, (i + 1) % 6, BondOrder::Double)).collect();
        for which in 0..6 {
            let (a, b) = (hexagon[bonds[which].a as usize], hexagon[bonds[which].b as usize]);
            let sticks = sticks_of(&hexagon, &bonds, which);
            assert_eq!(sticks.len(), 2);
            assert!(offset(&sticks[0], a, b).length() < 1e-6);
            assert!(offset(&sticks[1], a, b).dot((a + b) * 0.5) < -0.1, "inside the ring");
        }
        bonds[0].aromatic = true;
        let sticks = sticks_of(&hexagon, &bonds, 0);
        let inner = |stick: &CylinderInstance| (stick.a[0] - stick.b[0]).hypot(stick.a[1] - stick.b[1]) < 0.4;
        assert!(sticks.len() >= 3 && !inner(&sticks[0]) && sticks[1..].iter().all(inner), "dashes inside");
    }

    #[test]
    fn triple_bonds_have_three_sticks_and_straight_molecules_work() {
        let p = [Vec3::ZERO, Vec3::X * 1.2, Vec3::X * 2.26, Vec3::NEG_X * 1.06];
        let bonds = [bond(0, 1, BondOrder::Triple), bond(1, 2, BondOrder::Single), bond(0, 3, BondOrder::Single)];
        let sticks = sticks_of(&p, &bonds, 0);
        assert_eq!(sticks.len(), 3);
        assert!(sticks.iter().all(|stick| stick.a.iter().all(|x| x.is_finite())));
    }

    #[test]
    fn allene_planes_are_perpendicular() {
        let p = [
            Vec3::ZERO,
            Vec3::X * 1.3,
            Vec3::NEG_X * 1.3,
            Vec3::new(1.85, 0.93, 0.0),
            Vec3::new(1.85, -0.93, 0.0),
            Vec3::new(-1.85, 0.0, 0.93),
            Vec3::new(-1.85, 0.0, -0.93),
        ];
        let bonds = [
            bond(0, 1, BondOrder::Double),
            bond(0, 2, BondOrder::Double),
            bond(1, 3, BondOrder::Single),
            bond(1, 4, BondOrder::Single),
            bond(2, 5, BondOrder::Single),
            bond(2, 6, BondOrder::Single),
        ];
        let first = offset(&sticks_of(&p, &bonds, 0)[0], p[0], p[1]);
        let second = offset(&sticks_of(&p, &bonds, 1)[0], p[0], p[2]);
        assert!(first.dot(second).abs() < 1e-6 && first.y.abs() > 0.05, "{first} {second}");
    }

    #[test]
    fn a_bond_of_zero_length_has_no_stick() {
        assert!(sticks_of(&[Vec3::ONE, Vec3::ONE], &[bond(0, 1, BondOrder::Double)], 0).is_empty());
    }
}
