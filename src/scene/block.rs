//! The balls and sticks of one structure: which atoms are drawn, how large, and what their bonds look like.

use super::aromatic::{self, Aromatic, Shown};
use super::chosen::Chosen;
use super::dashes::{dashes, is_dashed};
use super::haptic;
use super::instances::{Cap, CylinderInstance, SphereInstance};
use super::shapes::ConeInstance;
use super::sticks::{self, StickContext};
use super::style::Sizes;
use super::wedges::{self, Wedge};
use super::{Block, Item, SceneOptions, Style};
use crate::color::Srgb8;
use crate::crystal::Stub;
use crate::structure::{Bond, BondKind, BondOrder, ByAtom, atom_flags, joined};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Atoms or bonds that are drawn in one go. Chosen: 250 runs for a million.
const RUN: usize = 4096;

/// All of a structure's balls and sticks that its positions do not decide: which atoms are drawn, their radii and colours, who is bonded to whom, the rings.
/// It is the same in all frames with the same bonds, and most of the time of making a scene goes into it.
pub(super) struct Rig {
    /// Tells structures that differ in their positions alone from others; 0 for none.
    kind: u64,
    /// The bonds it was made for, of such a structure.
    bonds: Vec<Bond>,
    chosen: Chosen,
    sizes: Sizes,
    neighbours: ByAtom<u32>,
    radii: Vec<f32>,
    /// The ring that each bond with several sticks is in, by the index of the bond.
    ring_of_bond: Vec<(u32, Box<[u32]>)>,
    /// The rings with a ring inside.
    rings: aromatic::Rings,
    wedges: HashMap<u32, Wedge>,
    /// Whether there are metals with one stick to a ring, which are found by positions.
    has_groups: bool,
}

impl Rig {
    pub(super) fn new(item: &Item<'_>, options: &SceneOptions, chosen: Chosen) -> Rig {
        let structure = item.structure;
        let atom_count = structure.atom_count();
        let is_drawn = |bond: &Bond| is_drawn(&chosen, bond);
        let sizes = Sizes { ball: options.ball_scale, stick: options.stick_scale };
        let neighbours = sticks::neighbours(atom_count, structure.bonds(), is_drawn);
        let mut has_stub = vec![false; if item.stubs.is_empty() { 0 } else { atom_count }];
        for stub in item.stubs.iter().filter(|stub| is_drawn(&stub.bond)) {
            has_stub[stub.bond.a as usize] = true;
        }
        let radius_of = |atom: usize| {
            let bonded = !neighbours.of(atom).is_empty() || has_stub.get(atom).is_some_and(|&has| has);
            let radius = sizes.ball(chosen.style(atom), structure.elements()[atom], bonded);
            // Lone pairs and the like are drawn small, whatever the style.
            if structure.flags(atom) & atom_flags::PARTICLE == 0 { radius } else { radius.min(0.12) }
        };
        let radii = (0..atom_count).into_par_iter().with_min_len(4096).map(radius_of).collect();
        let rings = if options.aromatic == Aromatic::Ring {
            let radii = |atoms: &[u32]| {
                let style = atoms.iter().map(|&atom| chosen.style(atom as usize)).reduce(Style::thinner)?;
                let stick = sizes.stick(style, BondKind::Covalent)?;
                // Half of a stick of a double bond.
                Some([stick, 0.3 * stick.min(sizes.multiple(style))])
            };
            aromatic::rings(structure, &chosen.colors, radii, is_drawn)
        } else {
            aromatic::Rings::default()
        };
        let mut wedges = wedges::wedges(structure);
        wedges.retain(|&index, _| {
            let bond = &structure.bonds()[index as usize];
            is_drawn(bond) && bond.order == BondOrder::Single && bond.kind == BondKind::Covalent && !bond.aromatic
        });
        let ring_of = |(index, bond): (usize, &Bond)| {
            let drawn = options.aromatic.as_drawn(bond, rings.shown(index as u32));
            let is_wanted = is_drawn(bond) && sticks::is_multiple(&drawn);
            let style = chosen.bond_style(bond.a, bond.b);
            let has_sticks = sizes.stick(style, BondKind::Covalent).is_some();
            let ring = if is_wanted && has_sticks { sticks::ring(&neighbours, bond) } else { None };
            ring.map(|ring| (index as u32, ring))
        };
        let ring_of_bond = structure.bonds().par_iter().enumerate().with_min_len(4096).filter_map(ring_of).collect();
        Rig {
            kind: item.kind,
            bonds: if item.kind == 0 { Vec::new() } else { structure.bonds().to_vec() },
            ring_of_bond,
            chosen,
            sizes,
            neighbours,
            radii,
            rings,
            wedges,
            has_groups: options.haptic,
        }
    }

    /// What is drawn, and how.
    pub(super) fn chosen(&self) -> &Chosen {
        &self.chosen
    }

    /// Whether it is that of another frame's item, too, the options being the same.
    pub(super) fn fits(&self, item: &Item<'_>) -> bool {
        self.kind != 0
            && self.kind == item.kind
            && item.stubs.is_empty()
            && self.radii.len() == item.structure.atom_count()
            && self.bonds == item.structure.bonds()
    }

    /// The balls and sticks where the atoms are.
    pub(super) fn pose(&self, item: &Item<'_>, options: &SceneOptions) -> Block {
        let structure = item.structure;
        let positions = structure.positions().relative();
        let colors = &self.chosen.colors;
        let is_shown = |atom: u32| self.chosen.is_shown(atom as usize);
        let is_drawn = |bond: &Bond| is_drawn(&self.chosen, bond);
        let last = u32::try_from(structure.atom_count()).unwrap_or(u32::MAX);
        let radius_of = |atom: u32| self.radii[atom as usize];
        let balls = (0..last).step_by(RUN).collect::<Vec<u32>>().into_par_iter().map(|start| {
            let atoms = (start..last.min(start.saturating_add(RUN as u32))).filter(|&atom| is_shown(atom));
            let ball = |atom: u32| SphereInstance {
                center: positions[atom as usize].to_array(),
                radius: radius_of(atom),
                color: colors[atom as usize],
                id: atom + 1,
            };
            atoms.map(ball).collect()
        });
        let spheres: Vec<SphereInstance> = joined(balls.collect());
        let artist = Artist {
            chosen: &self.chosen,
            sizes: self.sizes,
            aromatic: options.aromatic,
            positions,
            colors,
            neighbours: &self.neighbours,
            ball_radius: &radius_of,
            lattice: item.lattice,
        };
        let groups = match self.has_groups {
            true => haptic::groups(structure, positions, &self.neighbours, is_drawn),
            false => Vec::new(),
        };
        let in_group: std::collections::HashSet<u32> =
            groups.iter().flat_map(|group| group.bonds.iter().copied()).collect();
        let id_of_bond = |index: u32| last.saturating_add(index).saturating_add(1);
        let is_stick =
            |index: u32, bond: &Bond| is_drawn(bond) && !in_group.contains(&index) && !self.wedges.contains_key(&index);
        let sticks = structure.bonds().par_chunks(RUN).enumerate().map(|(run, bonds)| {
            let mut sticks = Vec::with_capacity(bonds.len());
            for (index, bond) in ((run * RUN) as u32..).zip(bonds).filter(|&(index, bond)| is_stick(index, bond)) {
                let ring = self.ring_of_bond.binary_search_by_key(&index, |(bond, _)| *bond).ok();
                let ring = ring.map(|at| &*self.ring_of_bond[at].1);
                artist.bond(bond, self.rings.shown(index), ring, id_of_bond(index), |stick| sticks.push(stick));
            }
            sticks
        });
        let mut cylinders: Vec<CylinderInstance> = joined(sticks.collect());
        for group in &groups {
            artist.haptic(group, id_of_bond(group.bonds[0]), |stick| cylinders.push(stick));
        }
        let mut cones = Vec::new();
        let mut marked: Vec<_> = self.wedges.iter().map(|(&index, &wedge)| (index, wedge)).collect();
        marked.sort_unstable_by_key(|&(index, _)| index);
        for (index, wedge) in marked {
            let bond = &structure.bonds()[index as usize];
            artist.wedge(bond, wedge, id_of_bond(index), &mut cones, &mut cylinders);
        }
        let bond_count = u32::try_from(structure.bonds().len()).unwrap_or(u32::MAX);
        let stubs: Vec<&Stub> = item.stubs.iter().filter(|stub| is_drawn(&stub.bond)).collect();
        for (index, stub) in stubs.iter().enumerate() {
            artist.stub(stub, id_of_bond(bond_count.saturating_add(index as u32)), |stick| cylinders.push(stick));
        }
        let id_count = last.saturating_add(bond_count).saturating_add(u32::try_from(stubs.len()).unwrap_or(u32::MAX));
        let tori = self.rings.tori(positions, id_of_bond);
        Block { spheres, cylinders, cones, tori, id_count, ..Block::default() }
    }
}

/// Where nothing repeats in the picture, a bond to an image has no end.
fn is_drawn(chosen: &Chosen, bond: &Bond) -> bool {
    let is_shown = |atom: u32| chosen.is_shown(atom as usize);
    !bond.is_periodic() && is_shown(bond.a) && is_shown(bond.b)
}

/// Draws bonds.
struct Artist<'a> {
    chosen: &'a Chosen,
    sizes: Sizes,
    aromatic: Aromatic,
    positions: &'a [Vec3],
    colors: &'a [Srgb8],
    neighbours: &'a ByAtom<u32>,
    ball_radius: &'a (dyn Fn(u32) -> f32 + Sync),
    /// The atoms of lattices that coordination alone holds together; empty if there are none.
    lattice: &'a [bool],
}

impl Artist<'_> {
    fn style(&self, a: u32, b: u32) -> Style {
        self.chosen.bond_style(a, b)
    }

    /// `shown` says what shows that the bond is aromatic; `ring` are the atoms of the one that it is in, if it has several sticks.
    fn bond(&self, bond: &Bond, shown: Shown, ring: Option<&[u32]>, id: u32, push: impl FnMut(CylinderInstance)) {
        self.between(&self.aromatic.as_drawn(bond, shown), self.positions[bond.b as usize], ring, id, push);
    }

    /// A bond towards or away from the viewer.
    fn wedge(
        &self,
        bond: &Bond,
        wedge: Wedge,
        id: u32,
        cones: &mut Vec<ConeInstance>,
        cylinders: &mut Vec<CylinderInstance>,
    ) {
        let style = self.style(bond.a, bond.b);
        let Some(radius) = self.sizes.stick(style, BondKind::Covalent) else { return };
        let (narrow, wide) = if wedge.from == bond.b { (bond.b, bond.a) } else { (bond.a, bond.b) };
        let [from, to] = [narrow, wide].map(|atom| self.positions[atom as usize]);
        let wide_radius = wedges::wide_radius(style, radius);
        let length = from.distance(to);
        // As far as the balls hide the ends; no more than leaves something between them.
        let hidden = |atom: u32, own: f32| {
            let ball = (self.ball_radius)(atom);
            (0.9 * (ball * ball - own * own).max(0.0).sqrt()).min(0.45 * length) / length
        };
        if length.is_nan() || length < 1e-6 {
            return;
        }
        let ends = [from.lerp(to, hidden(narrow, 0.0)), to.lerp(from, hidden(wide, wide_radius))];
        let template = CylinderInstance {
            id,
            radius,
            color_a: self.colors[narrow as usize],
            color_b: self.colors[wide as usize],
            ..bytemuck::Zeroable::zeroed()
        };
        let push_disc = |disc| cylinders.push(disc);
        wedges::draw(ends, wide_radius, wedge.is_hashed, template, |cone| cones.push(cone), push_disc);
    }

    /// Whether a bond is drawn as dashes. Those of a lattice that coordination alone holds together are sticks.
    fn is_dashes(&self, bond: &Bond) -> bool {
        let is_lattice = |atom: u32| self.lattice.get(atom as usize).is_some_and(|&is| is);
        is_dashed(bond.kind) && !(is_lattice(bond.a) && is_lattice(bond.b))
    }

    /// The sticks of a bond whose far end is at `end`.
    fn between(&self, bond: &Bond, end: Vec3, ring: Option<&[u32]>, id: u32, push: impl FnMut(CylinderInstance)) {
        let is_solid = !self.is_dashes(bond);
        let kind = if is_solid { BondKind::Covalent } else { bond.kind };
        let style = self.style(bond.a, bond.b);
        let Some(stick_radius) = self.sizes.stick(style, kind) else { return };
        let template = CylinderInstance {
            id,
            radius: stick_radius,
            color_a: self.colors[bond.a as usize],
            color_b: self.colors[bond.b as usize],
            ..bytemuck::Zeroable::zeroed()
        };
        if !is_solid {
            self.dashed(self.positions[bond.a as usize], bond.a, end, Some(bond.b), template, push);
            return;
        }
        let context = StickContext {
            positions: self.positions,
            neighbours: self.neighbours,
            ball_radius: self.ball_radius,
            stick_radius,
            multiple_radius: stick_radius.min(self.sizes.multiple(style)),
            // Sticks that are scaled may be thicker than the balls.
            round_ends: style != Style::BallAndStick || self.sizes != Sizes::USUAL,
        };
        context.sticks(bond, end, ring, template, push);
    }

    /// Dashes between the surfaces of two balls, the second one where there is one.
    fn dashed(
        &self,
        from: Vec3,
        atom: u32,
        to: Vec3,
        other: Option<u32>,
        template: CylinderInstance,
        push: impl FnMut(CylinderInstance),
    ) {
        let way = to - from;
        let length = way.length();
        let hidden = |atom: u32| {
            let radius = (self.ball_radius)(atom);
            (radius * radius - template.radius * template.radius).max(0.0).sqrt()
        };
        let (start, end) = (hidden(atom), other.map_or(0.0, hidden));
        if length > start + end {
            dashes(from + way * (start / length), to - way * (end / length), template, push);
        }
    }

    /// A bond that ends at a face of the cell.
    fn stub(&self, stub: &Stub, id: u32, mut push: impl FnMut(CylinderInstance)) {
        let start = self.positions[stub.bond.a as usize];
        let vector = stub.vector.as_vec3();
        let length = vector.length();
        let along = vector / length.max(1e-6);
        let face = stub.part as f32 * length;
        if self.is_dashes(&stub.bond) {
            return self.dashed_stub(&stub.bond, start, along, [length, face], id, push);
        }
        // The ring that a cut bond is in is not whole.
        self.between(&self.aromatic.as_drawn(&stub.bond, Shown::default()), start + vector, None, id, |stick| {
            let [from, to] = [stick.a, stick.b].map(|p| (Vec3::from(p) - start).dot(along));
            if from >= face {
                return;
            }
            if to <= face {
                push(stick);
                return;
            }
            // Two pieces where the face is beyond the middle, in which the colours meet.
            let middle = 0.5 * (from + to);
            let point = |at: f32| (Vec3::from(stick.a) + along * (at - from)).to_array();
            let caps = CylinderInstance::pack_caps(Cap::Flat, Cap::Flat);
            let hidden = stick.hidden & 1;
            push(CylinderInstance { b: point(face.min(middle)), color_b: stick.color_a, caps, hidden, ..stick });
            if face > middle {
                let [a, b] = [point(middle), point(face)];
                push(CylinderInstance { a, b, color_a: stick.color_b, caps, hidden: 0, ..stick });
            }
        });
    }

    /// Dashes from a ball to where a bond of this length is cut: whole ones, the last of which ends there, each in the colour
    /// of the half of the bond that it is in.
    fn dashed_stub(
        &self,
        bond: &Bond,
        start: Vec3,
        along: Vec3,
        [length, face]: [f32; 2],
        id: u32,
        mut push: impl FnMut(CylinderInstance),
    ) {
        let Some(radius) = self.sizes.stick(self.style(bond.a, bond.b), bond.kind) else { return };
        let [near, far] = [bond.a, bond.b].map(|atom| self.colors[atom as usize]);
        let template = CylinderInstance { id, radius, color_a: near, color_b: near, ..bytemuck::Zeroable::zeroed() };
        self.dashed(start, bond.a, start + along * face, None, template, |dash| {
            let middle = (0.5 * (Vec3::from(dash.a) + Vec3::from(dash.b)) - start).dot(along);
            let color = if middle > 0.5 * length { far } else { near };
            push(CylinderInstance { color_a: color, color_b: color, ..dash });
        });
    }

    /// One row of dashes from a metal to the middle of what it holds.
    fn haptic(&self, group: &haptic::Group, id: u32, push: impl FnMut(CylinderInstance)) {
        let style = self.style(group.metal, group.atoms[0]);
        let Some(radius) = self.sizes.stick(style, BondKind::Coordination) else { return };
        let template = CylinderInstance {
            id,
            radius,
            color_a: self.colors[group.metal as usize],
            color_b: self.colors[group.atoms[0] as usize],
            ..bytemuck::Zeroable::zeroed()
        };
        self.dashed(self.positions[group.metal as usize], group.metal, group.middle, None, template, push);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, BondOrder, BondSource, Diagnostics, Structure, StructureBuilder};
    use glam::DVec3;

    fn build(item: &Item<'_>, options: &SceneOptions) -> Block {
        let (mut chosen, _) = crate::scene::chosen::choose(&[*item], options);
        Rig::new(item, options, chosen.remove(0)).pose(item, options)
    }

    fn pair(kind: BondKind) -> Structure {
        let mut builder = StructureBuilder::new();
        for (symbol, x) in [("Fe", 0.0), ("N", 2.0)] {
            let element = Element::from_symbol(symbol).unwrap();
            builder.push_atom(&AtomRecord { element, position: DVec3::new(x, 0.0, 0.0), ..AtomRecord::default() });
        }
        builder.push_bond(Bond { kind, ..Bond::new(0, 1, BondOrder::Single, BondSource::File) });
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn a_cut_row_of_dashes_has_whole_ones_up_to_the_face() {
        let structure = pair(BondKind::Hydrogen);
        for part in [0.4, 0.7] {
            let bond = structure.bonds()[0];
            let stubs = [Stub { bond, vector: DVec3::new(0.0, 2.9, 0.0), part }];
            let alone = structure.clone().with_bonds(Vec::new());
            let block = build(&Item { stubs: &stubs, ..Item::of(&alone) }, &SceneOptions::default());
            let lengths: Vec<f32> = block.cylinders.iter().map(|dash| dash.b[1] - dash.a[1]).collect();
            assert!(
                lengths.len() > 1 && lengths.iter().all(|length| (length - lengths[0]).abs() < 1e-4),
                "{lengths:?}"
            );
            let last = block.cylinders[lengths.len() - 1];
            assert!((f64::from(last.b[1]) - 2.9 * part).abs() < 1e-4);
            assert!(block.cylinders.iter().all(|dash| dash.color_a == dash.color_b));
            assert_eq!(last.color_a == block.cylinders[0].color_a, part < 0.5);
        }
    }

    #[test]
    fn what_is_no_shared_pair_is_dashed_between_the_balls() {
        let options = SceneOptions::default();
        for (kind, is_row) in [
            (BondKind::Covalent, false),
            (BondKind::Coordination, true),
            (BondKind::Dative, true),
            (BondKind::Hydrogen, true),
        ] {
            let structure = pair(kind);
            let block = build(&Item::of(&structure), &options);
            assert_eq!(block.cylinders.len() > 1, is_row, "{kind:?}");
            assert!(block.cylinders.iter().all(|stick| stick.id == 3 && stick.a[0] > 0.1 && stick.b[0] < 1.9));
        }
    }

    #[test]
    fn a_stub_ends_at_the_face_with_the_colours_of_its_bond() {
        let structure = pair(BondKind::Covalent).with_bonds(Vec::new());
        let bond = Bond::new(0, 1, BondOrder::Single, BondSource::Distance);
        for (part, pieces) in [(0.3, 1), (0.8, 2)] {
            let stubs = [Stub { bond, vector: DVec3::new(0.0, 2.0, 0.0), part }];
            let item = Item { stubs: &stubs, ..Item::of(&structure) };
            let block = build(&item, &SceneOptions::default());
            assert_eq!(block.cylinders.len(), pieces);
            assert!((block.cylinders[pieces - 1].b[1] - 2.0 * part as f32).abs() < 1e-5);
            assert_eq!(
                (block.cylinders[0].color_a, block.cylinders[0].color_b),
                (block.spheres[0].color, block.spheres[0].color)
            );
            assert!(block.cylinders.iter().all(|stick| stick.id == 3));
        }
    }
}
