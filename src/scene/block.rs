//! The balls and sticks of one structure: which atoms are drawn, how large, and what their bonds look like.

use super::aromatic::{self, Aromatic};
use super::dashes::{dashes, is_dashed};
use super::haptic;
use super::instances::{Cap, CylinderInstance, SphereInstance};
use super::shapes::ConeInstance;
use super::sticks::{self, StickContext};
use super::wedges::{self, Wedge};
use super::{AltlocChoice, Block, Item, SceneOptions, Style};
use crate::bonds;
use crate::color::Srgb8;
use crate::crystal::Stub;
use crate::element::Element;
use crate::structure::{Bond, BondKind, BondOrder, ByAtom, Structure, atom_flags};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// All of a structure's balls and sticks that its positions do not decide: which atoms are drawn, their radii and colours, who is bonded to whom, the rings.
/// It is the same in all frames with the same bonds, and most of the time of making a scene goes into it.
pub(super) struct Rig {
    /// Tells structures that differ in their positions alone from others; 0 for none.
    kind: u64,
    /// The bonds it was made for, of such a structure.
    bonds: Vec<Bond>,
    shown: Option<Vec<bool>>,
    colors: Vec<Srgb8>,
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
    pub(super) fn new(item: &Item<'_>, options: &SceneOptions) -> Rig {
        let structure = item.structure;
        let atom_count = structure.atom_count();
        let shown = shown_atoms(structure, options);
        let is_drawn = |bond: &Bond| is_drawn(shown.as_deref(), bond);
        let colors = options.color_by.colors(structure);
        let neighbours = sticks::neighbours(atom_count, structure.bonds(), is_drawn);
        let mut has_stub = vec![false; if item.stubs.is_empty() { 0 } else { atom_count }];
        for stub in item.stubs.iter().filter(|stub| is_drawn(&stub.bond)) {
            has_stub[stub.bond.a as usize] = true;
        }
        let radius_of = |atom: usize| {
            let bonded = !neighbours.of(atom).is_empty() || has_stub.get(atom).is_some_and(|&has| has);
            let radius = options.style.atom_radius(structure.elements()[atom], bonded);
            // Lone pairs and the like are drawn small, whatever the style.
            if structure.flags(atom) & atom_flags::PARTICLE == 0 { radius } else { radius.min(0.12) }
        };
        let radii = (0..atom_count).into_par_iter().with_min_len(4096).map(radius_of).collect();
        let rings = match ring_radii(options) {
            Some(radii) => aromatic::rings(structure, &colors, radii, is_drawn),
            None => aromatic::Rings::default(),
        };
        let mut wedges = wedges::wedges(structure);
        wedges.retain(|&index, _| {
            let bond = &structure.bonds()[index as usize];
            is_drawn(bond) && bond.order == BondOrder::Single && bond.kind == BondKind::Covalent && !bond.aromatic
        });
        let ring_of = |(index, bond): (usize, &Bond)| {
            let has_ring = rings.has(index as u32);
            let is_wanted = is_drawn(bond) && sticks::is_multiple(&options.aromatic.as_drawn(bond, has_ring));
            let has_sticks = options.style.stick_radius(BondKind::Covalent).is_some();
            let ring = if is_wanted && has_sticks { sticks::ring(&neighbours, bond) } else { None };
            ring.map(|ring| (index as u32, ring))
        };
        let ring_of_bond = structure.bonds().par_iter().enumerate().with_min_len(4096).filter_map(ring_of).collect();
        Rig {
            kind: item.kind,
            bonds: if item.kind == 0 { Vec::new() } else { structure.bonds().to_vec() },
            ring_of_bond,
            shown,
            colors,
            neighbours,
            radii,
            rings,
            wedges,
            has_groups: options.haptic,
        }
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
        let is_shown = |atom: u32| self.shown.as_ref().is_none_or(|shown| shown[atom as usize]);
        let is_drawn = |bond: &Bond| is_drawn(self.shown.as_deref(), bond);
        let last = u32::try_from(structure.atom_count()).unwrap_or(u32::MAX);
        let radius_of = |atom: u32| self.radii[atom as usize];
        let spheres: Vec<SphereInstance> = (0..last)
            .into_par_iter()
            .with_min_len(4096)
            .filter(|&atom| is_shown(atom))
            .map(|atom| SphereInstance {
                center: positions[atom as usize].to_array(),
                radius: radius_of(atom),
                color: self.colors[atom as usize],
                id: atom + 1,
            })
            .collect();
        let artist = Artist {
            style: options.style,
            aromatic: options.aromatic,
            positions,
            colors: &self.colors,
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
        let mut cylinders: Vec<CylinderInstance> = (structure.bonds().par_iter().enumerate())
            .with_min_len(4096)
            .map(|(index, bond)| (index as u32, bond))
            .filter(|&(index, bond)| is_stick(index, bond))
            .flat_map_iter(|(index, bond)| {
                let mut sticks = Vec::new();
                let ring = self.ring_of_bond.binary_search_by_key(&index, |(bond, _)| *bond).ok();
                let ring = ring.map(|at| &*self.ring_of_bond[at].1);
                artist.bond(bond, self.rings.has(index), ring, id_of_bond(index), |stick| sticks.push(stick));
                sticks
            })
            .collect();
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
        let tori = ring_radii(options).map_or_else(Vec::new, |radii| self.rings.tori(positions, radii, id_of_bond));
        Block { spheres, cylinders, cones, tori, id_count, ..Block::default() }
    }
}

/// Where nothing repeats in the picture, a bond to an image has no end.
fn is_drawn(shown: Option<&[bool]>, bond: &Bond) -> bool {
    let is_shown = |atom: u32| shown.is_none_or(|shown| shown[atom as usize]);
    !bond.is_periodic() && is_shown(bond.a) && is_shown(bond.b)
}

/// Radii of a single stick and of the tube of the rings in rings; `None` where there are none.
fn ring_radii(options: &SceneOptions) -> Option<[f32; 2]> {
    let stick = options.style.stick_radius(BondKind::Covalent).filter(|_| options.aromatic == Aromatic::Ring)?;
    // Half of a stick of a double bond.
    Some([stick, 0.3 * stick.min(options.style.multiple_radius())])
}

/// Draws bonds.
struct Artist<'a> {
    style: Style,
    aromatic: Aromatic,
    positions: &'a [Vec3],
    colors: &'a [Srgb8],
    neighbours: &'a ByAtom<u32>,
    ball_radius: &'a (dyn Fn(u32) -> f32 + Sync),
    /// The atoms of lattices that coordination alone holds together; empty if there are none.
    lattice: &'a [bool],
}

impl Artist<'_> {
    /// `has_ring` says that a ring shows that the bond is aromatic; `ring` are the atoms of the one that it is in, if it has several sticks.
    fn bond(&self, bond: &Bond, has_ring: bool, ring: Option<&[u32]>, id: u32, push: impl FnMut(CylinderInstance)) {
        self.between(&self.aromatic.as_drawn(bond, has_ring), self.positions[bond.b as usize], ring, id, push);
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
        let Some(radius) = self.style.stick_radius(BondKind::Covalent) else { return };
        let (narrow, wide) = if wedge.from == bond.b { (bond.b, bond.a) } else { (bond.a, bond.b) };
        let [from, to] = [narrow, wide].map(|atom| self.positions[atom as usize]);
        let wide_radius = wedges::wide_radius(self.style, radius);
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
        let Some(stick_radius) = self.style.stick_radius(kind) else { return };
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
            multiple_radius: stick_radius.min(self.style.multiple_radius()),
            round_ends: self.style != Style::BallAndStick,
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
        self.between(&self.aromatic.as_drawn(&stub.bond, false), start + vector, None, id, |stick| {
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
        let Some(radius) = self.style.stick_radius(bond.kind) else { return };
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
        let Some(radius) = self.style.stick_radius(BondKind::Coordination) else { return };
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

/// Which atoms are drawn; `None` for all of them.
fn shown_atoms(structure: &Structure, options: &SceneOptions) -> Option<Vec<bool>> {
    let mut shown = chosen_altlocs(structure, options.altloc);
    if !options.water {
        let all = || vec![true; structure.atom_count()];
        let waters = bonds::waters(structure);
        shown.get_or_insert_with(all).iter_mut().zip(waters).for_each(|(shown, water)| *shown &= !water);
    }
    if !options.hydrogens {
        let all = || vec![true; structure.atom_count()];
        let elements = structure.elements();
        shown.get_or_insert_with(all).iter_mut().zip(elements).for_each(|(shown, &e)| *shown &= e != Element::H);
    }
    shown
}

/// Whether each atom is of the chosen alternate location; `None` if all are.
fn chosen_altlocs(structure: &Structure, choice: AltlocChoice) -> Option<Vec<bool>> {
    if choice == AltlocChoice::All || !structure.has_altlocs() {
        return None;
    }
    // One alternate a residue position: mixing them atom by atom would join halves of different conformers.
    let site = |atom: usize| {
        structure.residue_index(atom).map(|index| {
            let residue = structure.residues()[index];
            (residue.chain, residue.number, residue.insertion_code)
        })
    };
    let mut occupancy: HashMap<_, Vec<(u8, f64)>> = HashMap::new();
    for atom in (0..structure.atom_count()).filter(|&atom| structure.altloc(atom) != b' ') {
        let codes = occupancy.entry(site(atom)).or_default();
        let code = structure.altloc(atom);
        let weight = f64::from(structure.occupancy(atom));
        match codes.iter_mut().find(|(other, _)| *other == code) {
            Some((_, sum)) => *sum += weight,
            None => codes.push((code, weight)),
        }
    }
    let chosen: HashMap<_, u8> = occupancy
        .into_iter()
        .map(|(site, mut codes)| {
            codes.sort_by(|(code_a, sum_a), (code_b, sum_b)| sum_b.total_cmp(sum_a).then(code_a.cmp(code_b)));
            let wanted = codes.iter().map(|&(code, _)| code).find(|&code| choice == AltlocChoice::Code(code));
            (site, wanted.unwrap_or(codes[0].0))
        })
        .collect();
    let shown =
        |atom: usize| structure.altloc(atom) == b' ' || chosen.get(&site(atom)) == Some(&structure.altloc(atom));
    Some((0..structure.atom_count()).map(shown).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, BondOrder, BondSource, Diagnostics, StructureBuilder};
    use glam::DVec3;

    fn build(item: &Item<'_>, options: &SceneOptions) -> Block {
        Rig::new(item, options).pose(item, options)
    }

    fn altloc_structure() -> Structure {
        let mut builder = StructureBuilder::new();
        let residue = Some(("A", 7, b' ', "SER"));
        for (name, altloc, occupancy) in
            [("CA", b' ', 1.0), ("CB", b'A', 0.4), ("CB", b'B', 0.6), ("OG", b'A', 0.4), ("OG", b'B', 0.6)]
        {
            builder.push_atom(&AtomRecord {
                element: Element::C,
                name,
                altloc,
                occupancy,
                residue,
                ..AtomRecord::default()
            });
        }
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn one_alternate_location_is_drawn() {
        let structure = altloc_structure();
        let options = |altloc| SceneOptions { altloc, ..SceneOptions::default() };
        let shown = |altloc| shown_atoms(&structure, &options(altloc)).unwrap();
        assert_eq!(shown(AltlocChoice::Highest), [true, false, true, false, true]);
        assert_eq!(shown(AltlocChoice::Code(b'A')), [true, true, false, true, false]);
        assert_eq!(shown(AltlocChoice::Code(b'Z')), [true, false, true, false, true]);
        assert_eq!(shown_atoms(&structure, &options(AltlocChoice::All)), None);
    }

    #[test]
    fn water_and_hydrogens_can_be_left_out() {
        let text = b"8\n\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\nC 5 0 0\nH 6.09 0 0\nH 4.64 1.03 0\nH 4.64 -0.51 0.89\nH 4.64 -0.51 -0.89\n";
        let document = crate::import::read_bytes(text, "a.xyz", &Default::default()).unwrap();
        let structure = crate::bonds::assign(document.records[0].clone(), &Default::default());
        let shown = |hydrogens, water| {
            let options = SceneOptions { hydrogens, water, ..SceneOptions::default() };
            let shown = shown_atoms(&structure, &options).unwrap();
            (0..8).filter(|&atom| shown[atom]).collect::<Vec<_>>()
        };
        assert_eq!(shown(true, false), [3, 4, 5, 6, 7]);
        assert_eq!(shown(false, true), [0, 3]);
        assert_eq!(shown(false, false), [3]);
        let peptide = b"\
ATOM      1  CA  GLY A   1       0.000   0.000   0.000  1.00 10.00           C  \n\
HETATM    2  O   HOH A   2       9.000   0.000   0.000  1.00 10.00           O  \n";
        let document = crate::import::read_bytes(peptide, "a.pdb", &Default::default()).unwrap();
        assert_eq!(crate::bonds::waters(&document.records[0]), [false, true]);
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
