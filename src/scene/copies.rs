//! One structure in several places: its primitives once, in a block for all atoms that have the same places, and a placement for each of these.

use super::{Block, Placement};
use crate::crystal::Copies;
use crate::structure::Structure;
use glam::{Affine3A, DAffine3, DVec3};
use std::collections::HashMap;
use std::ops::Range;

/// What ids and placements of a scene are those of one of its structures.
///
/// Copy `c` of a structure has the ids from `first_id + c · id_count + 1` on: first all atoms, then the bonds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ItemIds {
    /// The id before those of the first copy.
    pub first_id: u32,
    /// How many ids one copy has.
    pub id_count: u32,
    /// Atoms of the structure, which come first.
    pub atoms: u32,
    /// How many copies there are; 1 for a structure that stands once.
    pub copies: u32,
    /// Its placements in [`super::Scene::placements`].
    pub placements: Range<usize>,
}

impl ItemIds {
    /// The copy and the number in it, from 0, of an id.
    #[must_use]
    pub fn own(&self, id: u32) -> Option<(u32, u32)> {
        let behind = id.checked_sub(self.first_id)?.checked_sub(1)?;
        let copy = behind.checked_div(self.id_count)?;
        (copy < self.copies).then_some((copy, behind % self.id_count))
    }

    /// The copy that a placement is.
    #[must_use]
    pub fn copy_of(&self, placement: &Placement) -> u32 {
        (placement.first_id.saturating_sub(self.first_id)).checked_div(self.id_count).unwrap_or(0)
    }

    /// The id of an atom. Atoms of further copies are counted on behind those of the first.
    #[must_use]
    pub fn id_of(&self, atom: u32) -> Option<u32> {
        let copy = atom.checked_div(self.atoms)?;
        let first = self.first_id.checked_add(copy.checked_mul(self.id_count)?)?;
        (copy < self.copies).then(|| first.checked_add(atom % self.atoms)?.checked_add(1)).flatten()
    }
}

/// The blocks of a structure, each with the numbers of the copies that it stands in.
pub(super) fn blocks(block: Block, structure: &Structure, copies: &Copies) -> Vec<(Block, Vec<u32>)> {
    if copies.set_of.is_empty() {
        return vec![(block, copies.common(0, 0))];
    }
    let bonds = structure.bonds();
    let atoms = structure.atom_count();
    let set_of = |id: u32| -> (u32, u32) {
        let own = id.saturating_sub(1) as usize;
        match own.checked_sub(atoms) {
            None => (copies.set_of(own as u32), copies.set_of(own as u32)),
            Some(bond) => bonds.get(bond).map_or((Copies::NOWHERE, Copies::NOWHERE), |bond| {
                let (a, b) = (copies.set_of(bond.a), copies.set_of(bond.b));
                (a.min(b), a.max(b))
            }),
        }
    };
    let Block { spheres, cylinders, cones, tori, triangles, id_count } = block;
    let mut blocks: Vec<(Block, Vec<u32>)> = Vec::new();
    let mut place_of: HashMap<(u32, u32), Option<usize>> = HashMap::new();
    let mut place = |id: u32, blocks: &mut Vec<(Block, Vec<u32>)>| {
        *place_of.entry(set_of(id)).or_insert_with_key(|&(a, b)| {
            let numbers = copies.common(a, b);
            if numbers.is_empty() {
                return None;
            }
            // Bonds between two sets may have the copies of one of them.
            let known = blocks.iter().position(|(_, others)| *others == numbers);
            Some(known.unwrap_or_else(|| {
                blocks.push((Block { id_count, ..Block::default() }, numbers));
                blocks.len() - 1
            }))
        })
    };
    macro_rules! sort {
        ($list:ident) => {
            for one in $list {
                if let Some(at) = place(one.id, &mut blocks) {
                    blocks[at].0.$list.push(one);
                }
            }
        };
    }
    sort!(spheres);
    sort!(cylinders);
    sort!(cones);
    sort!(tori);
    sort!(triangles);
    for (block, _) in &mut blocks {
        block.spheres.shrink_to_fit();
        block.cylinders.shrink_to_fit();
    }
    blocks
}

/// Where a copy stands in the world before its turn: `origin` is the point of the file that the block's coordinates count from, `shift` is
/// added in the end. In double precision as far as large numbers cancel.
pub(super) fn world_from_block(operation: &DAffine3, origin: DVec3, shift: DVec3) -> Affine3A {
    let translation = operation.transform_point3(origin) + shift;
    Affine3A::from_mat3_translation(operation.matrix3.as_mat3(), translation.as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::scene::{AtomPlace, Item, Measurement, Scene, SceneOptions};
    use crate::structure::{Assembly, AtomRecord, Bond, BondOrder, BondSource, Diagnostics, StructureBuilder};
    use glam::{DMat3, Vec3};

    /// C–O and N, 1,000 Å from the origin; C–O three times, the third mirrored, N where the first and the third are.
    fn drawn() -> crate::crystal::Drawn {
        let mut builder = StructureBuilder::new();
        for (element, x) in [(Element::C, 0.0), (Element::O, 1.2), (Element::N, 3.0), (Element::H, 9.0)] {
            let position = DVec3::new(1000.0 + x, 0.5, 0.25);
            builder.push_atom(&AtomRecord { element, position, ..AtomRecord::default() });
        }
        for (a, b) in [(0, 1), (1, 2)] {
            builder.push_bond(Bond::new(a, b, BondOrder::Single, BondSource::File));
        }
        let structure = builder.build(&mut Diagnostics::default());
        let shift = DAffine3::from_translation(DVec3::new(0.0, 7.0, 0.0));
        let mirror =
            DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)), translation: DVec3::Z * 10.0 };
        let mut assembly = Assembly::new("1", "");
        assembly.push(vec![0..2], &[DAffine3::IDENTITY, shift, mirror]);
        assembly.push(vec![2..3], &[DAffine3::IDENTITY, mirror]);
        let copies = Copies::of_assembly(&assembly, 4);
        crate::crystal::Drawn { copies: Some(copies), ..crate::crystal::Drawn::as_listed(structure) }
    }

    fn scene(options: &SceneOptions) -> Scene {
        let drawn = drawn();
        Scene::new(&[Item::drawn(&drawn, None), Item::of(&drawn.structure)], options)
    }

    #[test]
    fn each_primitive_is_in_one_block_and_stands_where_the_operations_put_it() {
        let scene = scene(&SceneOptions::default());
        // Atoms of the first set and the bond between them; N; and the bond from O to N with it.
        let blocks: Vec<_> = scene.blocks.iter().map(|b| (b.spheres.len(), b.cylinders.len())).collect();
        assert_eq!(blocks, [(2, 1), (1, 1), (4, 2)]);
        assert_eq!((scene.placements.len(), scene.sphere_count()), (6, 3 * 2 + 2 + 4));
        let ball = |item: u32, atom: u32| {
            let id = scene.id_of(AtomPlace { item, atom });
            id.and_then(|id| scene.ball(id)).map(|(center, _)| center)
        };
        let [c, o, n] = [0, 1, 2].map(|atom| ball(0, atom).unwrap());
        // Atoms of further copies are counted on, four a copy.
        assert!((ball(0, 4).unwrap().distance(c) - 7.0).abs() < 1e-3);
        assert_eq!((ball(0, 6), ball(0, 3), ball(0, 12)), (None, None, None));
        let [c3, o3, n3] = [8, 9, 10].map(|atom| ball(0, atom).unwrap());
        for (one, other) in [(c.distance(o), c3.distance(o3)), (o.distance(n), o3.distance(n3)), (9.5, c.distance(c3))]
        {
            assert!((one - other).abs() < 1e-3, "{one} {other}");
        }
        // The second item stands where the first copy does.
        assert!(ball(1, 1).unwrap().distance(o) < 1e-4);
        let all = scene.world_spheres().fold(crate::math::Aabb::EMPTY, |all, (center, radius)| {
            all.union(crate::math::Aabb::of_sphere(center, radius))
        });
        assert!(
            (scene.bounds().min - all.min).abs().max_element() < 1e-4 && scene.bounds().max.distance(all.max) < 1e-4
        );
    }

    #[test]
    fn copies_cost_a_placement_each_and_a_ball_with_its_stick_72_bytes() {
        let mut builder = StructureBuilder::new();
        const COUNT: u32 = 20_000;
        for number in 0..COUNT {
            let position = DVec3::new(f64::from(number) * 1.5, 0.0, 0.0);
            builder.push_atom(&AtomRecord { element: Element::C, position, ..AtomRecord::default() });
        }
        for atom in 1..COUNT {
            builder.push_bond(Bond::new(atom - 1, atom, BondOrder::Single, BondSource::File));
        }
        let structure = builder.build(&mut Diagnostics::default());
        let one = Scene::new(&[Item::of(&structure)], &SceneOptions::default());
        let mut assembly = Assembly::new("1", "");
        let turns: Vec<DAffine3> = (0..60).map(|n| DAffine3::from_rotation_x(f64::from(n) * 0.1)).collect();
        assembly.push(vec![0..COUNT], &turns);
        let copies = Copies::of_assembly(&assembly, COUNT as usize);
        let sixty = Scene::new(&[Item { copies: Some(&copies), ..Item::of(&structure) }], &SceneOptions::default());
        assert_eq!(sixty.sphere_count(), 60 * COUNT as usize);
        assert!(one.memory() <= 72 * COUNT as usize + 1000, "{}", one.memory());
        assert!(sixty.memory() <= one.memory() + 64 * 200, "{} {}", sixty.memory(), one.memory());
    }

    #[test]
    fn ids_tell_item_copy_and_what_it_is() {
        let scene = scene(&SceneOptions::default());
        // Four atoms and two bonds a copy.
        for (item, copy, own) in [(0, 0, 0), (0, 1, 5), (0, 2, 3), (1, 0, 4)] {
            let id = scene.items[item].first_id + copy * 6 + own + 1;
            assert_eq!(scene.item_of(id), Some((item, copy, own)));
        }
        assert_eq!((scene.items[1].first_id, scene.item_of(0), scene.item_of(25)), (18, None, None));
        let id = scene.id_of(AtomPlace { item: 0, atom: 9 }).unwrap();
        assert_eq!(scene.item_of(id), Some((0, 2, 1)));
        let halo = scene.halos(&[id], Vec3::Z, crate::color::Srgb8::WHITE);
        assert_eq!(Vec3::from(halo[0].center), scene.ball(id).unwrap().0);
    }

    #[test]
    fn labels_and_measurements_are_those_of_their_copies() {
        let text = crate::scene::OverlayOptions {
            labels: crate::scene::LabelContent { element: true, ..Default::default() },
            ..Default::default()
        };
        // From C of the first copy to C of the third: the mirror is 5 Å away.
        let atoms = [0, 8].map(|atom| AtomPlace { item: 0, atom }).to_vec();
        let options = SceneOptions { text, measurements: vec![Measurement { atoms }], ..SceneOptions::default() };
        let scene = scene(&options);
        let texts: Vec<&str> = scene.overlay.labels.iter().map(|label| &*label.text).collect();
        assert_eq!(texts, ["9.500 Å", "C", "O", "C", "O", "C", "O", "N", "N", "C", "O", "N", "H"]);
        let second = &scene.overlay.labels[3];
        assert_eq!(scene.ball(second.ids[0]).map(|(center, _)| center), Some(second.anchor));
        assert_eq!(scene.item_of(second.ids[0]), Some((0, 1, 0)));
    }
}
