//! A structure of some of another one's atoms.

use super::{Frame, Positions, StereoMark, Structure, VectorField};
use glam::DVec3;

impl Structure {
    /// The atoms for which `keep` holds, in their order, with all that is said about them, in all frames, and the bonds among them.
    /// Atoms that `keep` is too short for are left out.
    #[must_use]
    pub fn subset(&self, keep: &[bool]) -> Structure {
        let kept: Vec<usize> = (0..self.atom_count()).filter(|&atom| keep.get(atom) == Some(&true)).collect();
        // A structure has fewer than 2^32 atoms.
        let sources: Vec<(u32, DVec3)> = kept.iter().map(|&atom| (atom as u32, self.positions().get(atom))).collect();
        let mut place = vec![u32::MAX; self.atom_count()];
        kept.iter().zip(0u32..).for_each(|(&atom, new)| place[atom] = new);
        let mut subset = self.gather(&sources, self.cell().copied());
        subset.frames = (self.frames.iter())
            .map(|frame| {
                let points: Vec<DVec3> = kept.iter().map(|&atom| frame.positions.get(atom)).collect();
                let vectors = (frame.vectors.iter())
                    .map(|field| VectorField {
                        name: field.name.clone(),
                        vectors: kept.iter().filter_map(|&atom| field.vectors.get(atom).copied()).collect(),
                    })
                    .collect();
                let (positions, _) = Positions::from_f64(&points, frame.positions.decimals());
                Frame { positions, cell: frame.cell, title: frame.title.clone(), time_ps: frame.time_ps, vectors }
            })
            .collect();
        let is_kept = |atom: u32| place[atom as usize] != u32::MAX;
        let (old, bonds) = (self.bonds.iter().zip(0u32..))
            .filter(|(bond, _)| is_kept(bond.a) && is_kept(bond.b))
            .map(|(bond, old)| {
                let mut bond = *bond;
                (bond.a, bond.b) = (place[bond.a as usize], place[bond.b as usize]);
                (old, bond)
            })
            .unzip::<u32, _, Vec<u32>, Vec<_>>();
        // Their order stays: places grow as the atoms do.
        subset.bonds = bonds;
        subset.bond_stereo = (self.bond_stereo.iter())
            .filter_map(|mark| {
                let bond = u32::try_from(old.binary_search(&mark.bond).ok()?).ok()?;
                Some(StereoMark { bond, from: place[mark.from as usize], ..*mark })
            })
            .collect();
        subset.stated_bonds = self.stated_bonds;
        subset.symmetry = self.symmetry.clone();
        subset.assemblies = self.assemblies.iter().map(|assembly| assembly.subset(&place)).collect();
        subset.secondary = self.secondary.clone();
        subset
    }
}

#[cfg(test)]
mod tests {
    use crate::structure::{
        AtomRecord, Bond, BondOrder, BondSource, BondStereo, Diagnostics, StereoMark, StructureBuilder,
    };
    use glam::DVec3;

    #[test]
    fn bonds_marks_and_residues_follow_the_atoms_that_stay() {
        let mut builder = StructureBuilder::new();
        for (number, x) in [(1, 0.0), (1, 1.0), (2, 2.0), (2, 3.0)] {
            let residue = Some(("A", number, b' ', "GLY"));
            builder.push_atom(&AtomRecord { position: DVec3::new(x, 0.5, 0.0), residue, ..AtomRecord::default() });
        }
        for (a, b) in [(0, 1), (1, 2), (2, 3)] {
            builder.push_bond(Bond::new(a, b, BondOrder::Double, BondSource::File));
        }
        let mut structure = builder.build(&mut Diagnostics::default());
        structure.bond_stereo = vec![
            StereoMark { bond: 1, from: 1, stereo: BondStereo::Up },
            StereoMark { bond: 2, from: 3, stereo: BondStereo::Down },
        ];
        let subset = structure.subset(&[false, false, true, true]);
        assert_eq!((subset.atom_count(), subset.positions().get(1)), (2, DVec3::new(3.0, 0.5, 0.0)));
        assert_eq!(subset.bonds().iter().map(|bond| (bond.a, bond.b)).collect::<Vec<_>>(), [(0, 1)]);
        assert_eq!(subset.bond_stereo(), [StereoMark { bond: 0, from: 1, stereo: BondStereo::Down }]);
        assert_eq!(subset.residues().iter().map(|r| (r.number, r.first_atom)).collect::<Vec<_>>(), [(2, 0)]);
        assert_eq!(structure.subset(&[true]).atom_count(), 1);
        assert_eq!(structure.subset(&[true; 4]), structure);
    }
}
