//! Bonds across the faces of the unit cell.
//!
//! The atoms are wrapped into the cell and a shell of their images is laid around it, two bond lengths thick, so that
//! an atom at a face and its partners have all their neighbours. On these the bonds are found as on any molecule;
//! those of the atoms themselves are kept, each with the image it goes to. A bond that the file states without an
//! image goes to the nearest one if only that is of a bond's length.
//!
//! Limit: cells so small or flat that the shell would be many times larger than the structure are taken as if
//! they did not repeat ([`MOST_IMAGES`]).

use super::residues::Known;
use super::rules::{self, PairTable};
use super::{BondOptions, distance, hbonds};
use crate::stop::Stop;
use crate::structure::{Bond, Cell, Positions, Structure};
use glam::{DVec3, IVec3};

/// This many images are always affordable (one atom in a cell of 2.5 Å under a shell of 10 Å has 728); of a larger
/// structure, [`IMAGES_PER_ATOM`].
const MOST_IMAGES: usize = 20_000;
/// A cubic cell of 4 Å under a shell of 8 Å has 124 images an atom; larger structures have fewer.
const IMAGES_PER_ATOM: usize = 27;
/// A stated bond is across the cell only if it is longer than the sum of the covalent radii by this factor as it stands: then it is
/// no bond (those of the file are kept, but no chemist means three bond lengths).
const TOO_LONG: f64 = 2.0;

/// The bonds by distance of a frame that are not among the settled ones (sorted), those to periodic images with them, sorted.
pub(super) fn find(
    structure: &Structure,
    frame: usize,
    settled: &[Bond],
    known: &Known,
    options: &BondOptions,
    stop: &Stop,
) -> Vec<Bond> {
    let Some(positions) = structure.frames().get(frame).map(|frame| &frame.positions) else { return Vec::new() };
    let reach = f64::from(PairTable::new(structure.elements(), options).longest(true));
    let extended = structure.lattice(frame).and_then(|cell| Extended::new(structure, positions, cell, reach));
    match extended {
        Some(extended) => extended.find(settled, known, options, stop),
        None => distance::find(structure, positions.relative(), settled, known, options, stop),
    }
}

/// The hydrogen bonds of a frame whose atoms have these bonds, those to periodic images with them, sorted.
pub(super) fn hydrogen_bonds(structure: &Structure, frame: usize, bonds: &[Bond]) -> Vec<Bond> {
    let Some(positions) = structure.frames().get(frame).map(|frame| &frame.positions) else { return Vec::new() };
    let reach = f64::from(hbonds::LONGEST);
    match structure.lattice(frame).and_then(|cell| Extended::new(structure, positions, cell, reach)) {
        Some(extended) => {
            let everywhere = extended.settled_everywhere(bonds);
            extended.at_home(hbonds::find(&extended.all, extended.all.positions().relative(), &everywhere))
        }
        None => hbonds::find(structure, positions.relative(), bonds),
    }
}

/// The stated bonds, those that are far too long as they stand turned to the nearest image.
pub(super) fn with_images(structure: &Structure, frame: usize, stated: &[Bond]) -> Vec<Bond> {
    let mut bonds = stated.to_vec();
    let (Some(cell), Some(frame)) = (structure.lattice(frame), structure.frames().get(frame)) else { return bonds };
    let (to_fractional, from_fractional) = (cell.fractional_from_cartesian(), cell.cartesian_from_fractional());
    for bond in bonds.iter_mut().filter(|bond| !bond.is_periodic()) {
        let [a, b] = [bond.a, bond.b].map(|atom| structure.elements()[atom as usize]);
        let longest = TOO_LONG * f64::from(rules::radii(a, b));
        let vector = frame.positions.get(bond.b as usize) - frame.positions.get(bond.a as usize);
        if vector.length() <= longest {
            continue;
        }
        let shift = -(to_fractional * vector).round();
        if (vector + from_fractional * shift).length() <= longest {
            bond.image = image_of(shift.as_ivec3()).unwrap_or(bond.image);
        }
    }
    bonds.sort_by_key(Bond::key);
    bonds
}

/// A structure with the images around its cell.
struct Extended {
    /// The atoms, wrapped, then the images.
    all: Structure,
    atom_count: usize,
    /// How many cells each atom was from home.
    home: Vec<IVec3>,
    /// Atom and cell of each image.
    images: Vec<(u32, IVec3)>,
}

impl Extended {
    /// The images as far as two lengths `reach` from the cell; `None` if there would be too many.
    fn new(structure: &Structure, positions: &Positions, cell: &Cell, reach: f64) -> Option<Extended> {
        let atom_count = structure.atom_count();
        let (to_fractional, from_fractional) = (cell.fractional_from_cartesian(), cell.cartesian_from_fractional());
        let margin = 2.0 * reach / cell.face_distances();
        let mut home = Vec::with_capacity(atom_count);
        let mut sources = Vec::with_capacity(atom_count);
        let mut images = Vec::new();
        let most = MOST_IMAGES.max(IMAGES_PER_ATOM * atom_count);
        for atom in 0..atom_count {
            let fractional = to_fractional * positions.get(atom);
            let floor = fractional.floor();
            if floor.abs().max_element() > 1e6 || floor.is_nan() {
                return None; // no such file means a lattice
            }
            let wrapped = fractional - floor;
            let first = (-margin - wrapped).ceil().as_ivec3();
            let last = (DVec3::ONE + margin - wrapped).floor().as_ivec3();
            let count = (last - first + 1).as_i64vec3();
            let count = count.x.saturating_mul(count.y).saturating_mul(count.z);
            if usize::try_from(count).map_or(true, |count| images.len().saturating_add(count) > most) {
                return None;
            }
            for x in first.x..=last.x {
                for y in first.y..=last.y {
                    for z in first.z..=last.z {
                        let shift = IVec3::new(x, y, z);
                        if shift != IVec3::ZERO {
                            images.push((atom as u32, shift)); // a structure has fewer than 2^32 atoms
                        }
                    }
                }
            }
            home.push(floor.as_ivec3());
            sources.push((atom as u32, from_fractional * wrapped));
        }
        // Image by image, so that the atoms of a residue stay together.
        images.sort_unstable_by_key(|&(atom, shift)| (shift.to_array(), atom));
        for &(atom, shift) in &images {
            sources.push((atom, sources[atom as usize].1 + from_fractional * shift.as_dvec3()));
        }
        Some(Extended { all: structure.gather(&sources, None), atom_count, home, images })
    }

    /// Atom and cell of one of all.
    fn place(&self, index: u32) -> (u32, IVec3) {
        match (index as usize).checked_sub(self.atom_count) {
            Some(image) => self.images[image],
            None => (index, IVec3::ZERO),
        }
    }

    fn find(&self, settled: &[Bond], known: &Known, options: &BondOptions, stop: &Stop) -> Vec<Bond> {
        let settled = self.settled_everywhere(settled);
        let known = known.of_copies((0..self.all.atom_count() as u32).map(|index| self.place(index).0));
        self.at_home(distance::find(&self.all, self.all.positions().relative(), &settled, &known, options, stop))
    }

    /// The bonds of the atoms themselves, among those of all, each once.
    fn at_home(&self, found: Vec<Bond>) -> Vec<Bond> {
        let mut bonds: Vec<Bond> = (found.into_iter())
            .filter(|bond| (bond.a as usize) < self.atom_count)
            .filter_map(|bond| {
                let (b, shift) = self.place(bond.b);
                // From wrapped positions back to those of the file.
                let image = image_of(shift - self.home[b as usize] + self.home[bond.a as usize])?;
                Some(Bond { b, image, ..bond }.turned())
            })
            .collect();
        // A bond across a face is found from both of its ends.
        bonds.sort_unstable_by_key(Bond::key);
        bonds.dedup_by_key(|bond| bond.key());
        bonds
    }

    /// The settled bonds of the atoms and of all images, sorted.
    fn settled_everywhere(&self, settled: &[Bond]) -> Vec<Bond> {
        if settled.is_empty() {
            return Vec::new();
        }
        // The images of each atom, as numbers among all images.
        let mut first = vec![0u32; self.atom_count + 1];
        for &(atom, _) in &self.images {
            first[atom as usize + 1] += 1;
        }
        for atom in 0..self.atom_count {
            first[atom + 1] += first[atom];
        }
        let mut next = first.clone();
        let mut of_atom = vec![0u32; self.images.len()];
        for (image, &(atom, _)) in self.images.iter().enumerate() {
            let slot = &mut next[atom as usize];
            of_atom[*slot as usize] = image as u32;
            *slot += 1;
        }
        let copies = |atom: u32| {
            let images = &of_atom[first[atom as usize] as usize..first[atom as usize + 1] as usize];
            let copy = |&image: &u32| (self.images[image as usize].1, self.atom_count as u32 + image);
            std::iter::once((IVec3::ZERO, atom)).chain(images.iter().map(copy))
        };
        let has_none = |atom: u32| first[atom as usize] == first[atom as usize + 1];
        // Those among the atoms themselves are sorted as they are; they are most.
        let mut everywhere = Vec::with_capacity(settled.len() + settled.len() / 4);
        let mut of_images = Vec::new();
        for bond in settled {
            let [home_a, home_b] = [bond.a, bond.b].map(|atom| self.home[atom as usize]);
            let step = IVec3::from_array(bond.image.map(i32::from)) - home_a + home_b;
            let is_whole = step == IVec3::ZERO;
            if is_whole {
                everywhere.push(Bond { image: [0; 3], ..*bond }.turned());
                if has_none(bond.a) || has_none(bond.b) {
                    continue;
                }
            }
            for (shift, a) in copies(bond.a).skip(usize::from(is_whole)) {
                let partner = copies(bond.b).find(|&(other, _)| other == shift + step);
                of_images.extend(partner.map(|(_, b)| Bond { a, b, image: [0; 3], ..*bond }.turned()));
            }
        }
        of_images.sort_by_key(Bond::key);
        everywhere.extend(of_images);
        everywhere.sort_by_key(Bond::key); // finds the two sorted runs and merges them
        everywhere
    }
}

/// As a bond holds it; `None` for what is further than 127 cells away.
fn image_of(shift: IVec3) -> Option<[i8; 3]> {
    let [x, y, z] = shift.to_array().map(i8::try_from);
    Some([x.ok()?, y.ok()?, z.ok()?])
}

#[cfg(test)]
mod tests {
    use super::super::{BondOptions, assign, find};
    use crate::element::Element;
    use crate::structure::{
        AtomRecord, Bond, BondOrder, BondSource, Cell, Diagnostics, StatedBonds, Structure, StructureBuilder, Symmetry,
        SymmetryOperation,
    };
    use glam::DVec3;

    /// Atoms at fractional positions of a cubic cell.
    fn crystal(edge: f64, atoms: &[(&str, [f64; 3])]) -> StructureBuilder {
        let mut builder = StructureBuilder::new();
        for (symbol, at) in atoms {
            let element = Element::from_symbol(symbol).unwrap();
            builder.push_atom(&AtomRecord { element, position: DVec3::from(*at) * edge, ..AtomRecord::default() });
        }
        builder.set_cell(Cell::from_parameters([edge; 3], [90.0; 3]));
        builder
    }

    fn built(builder: StructureBuilder) -> Structure {
        builder.build(&mut Diagnostics::default())
    }

    fn degrees(structure: &Structure, bonds: &[Bond]) -> Vec<usize> {
        let ends = |atom: u32| bonds.iter().map(|bond| usize::from(bond.a == atom) + usize::from(bond.b == atom)).sum();
        (0..structure.atom_count() as u32).map(ends).collect()
    }

    #[test]
    fn every_atom_of_a_crystal_has_all_its_neighbours() {
        let face_centred = [[0.0, 0.0, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0]];
        let shifted = |by: f64| face_centred.map(|at| at.map(|x| x + by));
        let atoms = |symbol, at: [[f64; 3]; 4]| at.map(|at| (symbol, at));
        let diamond = [atoms("C", face_centred), atoms("C", shifted(0.25))].concat();
        let salt = [atoms("Na", face_centred), atoms("Cl", shifted(0.5))].concat();
        for (edge, atoms, neighbours) in
            [(3.567, diamond, 4), (5.64, salt, 6), (3.615, atoms("Cu", face_centred).to_vec(), 12)]
        {
            let structure = built(crystal(edge, &atoms));
            let bonds = find(&structure, 0, &BondOptions::default());
            assert_eq!(degrees(&structure, &bonds), vec![neighbours; atoms.len()], "{}", atoms[0].0);
            assert!(bonds.is_sorted_by_key(Bond::key));
        }
        // One atom in the cell: bonds to its own images.
        let polonium = built(crystal(3.359, &[("Po", [0.3, 0.4, 0.5])]));
        let bonds = find(&polonium, 0, &BondOptions::default());
        assert_eq!(bonds.iter().map(|bond| bond.image).collect::<Vec<_>>(), [[0, 0, 1], [0, 1, 0], [1, 0, 0]]);
    }

    #[test]
    fn images_are_those_of_the_listed_positions_wherever_they_are() {
        // Hydrogen fluoride across a face, listed wrapped, whole, and with one atom three cells away.
        for (hydrogen, image) in [(0.05, [1, 0, 0]), (1.05, [0, 0, 0]), (-2.95, [4, 0, 0])] {
            let structure = built(crystal(10.0, &[("F", [0.96, 0.5, 0.5]), ("H", [hydrogen, 0.5, 0.5])]));
            let bonds = find(&structure, 0, &BondOptions::default());
            assert_eq!(bonds.iter().map(|bond| (bond.a, bond.b, bond.image)).collect::<Vec<_>>(), [(0, 1, image)]);
        }
    }

    #[test]
    fn a_cell_that_is_a_placeholder_repeats_nothing() {
        let structure = built(crystal(1.0, &[("C", [0.0, 0.0, 0.0]), ("C", [1.5, 0.0, 0.0])]));
        let bonds = assign(structure, &BondOptions::default()).bonds().to_vec();
        assert_eq!(bonds, [Bond::new(0, 1, BondOrder::Single, BondSource::Distance)]);
    }

    #[test]
    fn a_flat_cell_costs_no_more_than_its_atoms() {
        let mut builder = crystal(10.0, &[("C", [0.0; 3])]);
        builder.set_cell(Cell::from_parameters([1e-3, 1e-3, 1e7], [90.0; 3]));
        assert!(find(&built(builder), 0, &BondOptions::default()).is_empty());
    }

    #[test]
    fn a_stated_bond_across_the_box_goes_to_the_nearest_image() {
        let mut builder = crystal(10.0, &[("O", [0.98, 0.5, 0.5]), ("H", [0.07, 0.5, 0.5]), ("H", [0.98, 0.6, 0.5])]);
        for hydrogen in [1, 2] {
            builder.push_bond(Bond::new(0, hydrogen, BondOrder::Single, BondSource::File));
        }
        builder.set_stated_bonds(StatedBonds::Complete);
        let bonds = find(&built(builder), 0, &BondOptions::default());
        assert_eq!(bonds.iter().map(|bond| bond.image).collect::<Vec<_>>(), [[1, 0, 0], [0, 0, 0]]);
    }

    #[test]
    fn hydrogen_bonds_go_across_faces() {
        // Two waters of a chain along x that never ends: each gives its hydrogen to the next, one of them in the next cell.
        let atoms = [
            ("O", [0.1, 0.5, 0.5]),
            ("H", [0.26, 0.5, 0.5]),
            ("H", [0.06, 0.655, 0.5]),
            ("O", [0.6, 0.5, 0.5]),
            ("H", [0.76, 0.5, 0.5]),
            ("H", [0.56, 0.655, 0.5]),
        ];
        let options = BondOptions { hydrogen_bonds: true, ..BondOptions::default() };
        let structure = built(crystal(6.0, &atoms));
        let bonds = find(&structure, 0, &options);
        let found = bonds.iter().filter(|bond| bond.kind == crate::structure::BondKind::Hydrogen);
        assert_eq!(
            found.map(|bond| (bond.a, bond.b, bond.image)).collect::<Vec<_>>(),
            [(0, 4, [-1, 0, 0]), (1, 3, [0, 0, 0])]
        );
        let explained = super::super::explain(&structure, 0, &options);
        let reasons = explained.iter().filter(|bond| bond.bond.kind == crate::structure::BondKind::Hydrogen);
        assert!(reasons.clone().all(|bond| bond.reason.contains("D···A 3.00 Å")), "{explained:?}");
        assert!(reasons.clone().all(|bond| bond.reason.contains("180°")) && reasons.count() == 2);
    }

    #[test]
    fn orders_and_charges_of_an_asymmetric_unit_are_those_of_the_crystal() {
        // Quartz: one silicon and one oxygen are listed (Levien, Prewitt and Weidner, Am. Mineral. 1980, 65, 920); silicon has
        // four oxygens and oxygen two silicons.
        let mut builder = StructureBuilder::new();
        let cell = Cell::from_parameters([4.916, 4.916, 5.4054], [90.0, 90.0, 120.0]).unwrap();
        for (symbol, at) in [("Si", [0.4697, 0.0, 0.0]), ("O", [0.4135, 0.2669, 0.1191])] {
            let position = cell.cartesian_from_fractional() * DVec3::from(at);
            let element = Element::from_symbol(symbol).unwrap();
            builder.push_atom(&AtomRecord { element, position, ..AtomRecord::default() });
        }
        builder.set_cell(Some(cell));
        let operations = ["x,y,z", "-y,x-y,z+2/3", "-x+y,-x,z+1/3", "x-y,-y,-z", "-x,-x+y,-z+1/3", "y,x,-z+2/3"];
        let operations = operations.iter().map(|text| SymmetryOperation::from_triplet(text).unwrap()).collect();
        builder.set_symmetry(Some(Symmetry { space_group: "P 32 2 1".to_owned(), operations }));
        let quartz = assign(built(builder), &BondOptions::default());
        assert_eq!(quartz.bonds(), [Bond::new(0, 1, BondOrder::Single, BondSource::Distance)]);
        assert!(!quartz.has_formal_charges());
    }
}
