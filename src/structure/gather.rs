//! A structure of chosen copies of another one's atoms: cell contents, supercells, whole molecules.

use super::{Cell, Frame, Positions, Residue, StatedBonds, Structure, VectorField};
use glam::DVec3;

impl Structure {
    /// One atom for each of `sources` (indices of atoms of this structure, in any order, any number of times; those that
    /// are not there are left out) at the position beside it, with all that is said about it. The result has one frame
    /// with this cell, and neither bonds nor symmetry; residues are runs of copies that belong to one residue.
    #[must_use]
    pub fn gather(&self, sources: &[(u32, DVec3)], cell: Option<Cell>) -> Structure {
        let sources: Vec<(usize, DVec3)> = (sources.iter())
            .map(|&(atom, point)| (atom as usize, point))
            .filter(|&(atom, _)| atom < self.atom_count())
            .collect();
        let points: Vec<DVec3> = sources.iter().map(|&(_, point)| point).collect();
        let (positions, _) = Positions::from_f64(&points, self.positions().decimals());
        let title = self.frames.first().map_or_else(String::new, |frame| frame.title.clone());
        let time_ps = self.frames.first().and_then(|frame| frame.time_ps);
        let mut residues: Vec<Residue> = Vec::new();
        let mut residue_of_atom = Vec::new();
        let mut last = None;
        for (index, &(atom, _)) in sources.iter().enumerate() {
            let Some(residue) = self.residue_index(atom) else { break };
            // The first atom of a residue starts a further copy of it.
            let first = self.residues[residue].first_atom as usize == atom;
            if last != Some(residue) || first {
                residues.push(Residue { first_atom: index as u32, ..self.residues[residue] });
                last = Some(residue);
            }
            residue_of_atom.push(residues.len() as u32 - 1);
        }
        fn column<T: Copy>(of: &[T], sources: &[(usize, DVec3)]) -> Vec<T> {
            if of.is_empty() { Vec::new() } else { sources.iter().map(|&(atom, _)| of[atom]).collect() }
        }
        let vectors = (self.vectors().iter())
            .map(|field| VectorField { name: field.name.clone(), vectors: column(&field.vectors, &sources) })
            .collect();
        Structure {
            title: self.title.clone(),
            names: self.names.clone(),
            element: column(&self.element, &sources),
            atom_name: column(&self.atom_name, &sources),
            serial: column(&self.serial, &sources),
            residue_of_atom,
            flags: column(&self.flags, &sources),
            altloc: column(&self.altloc, &sources),
            occupancy: column(&self.occupancy, &sources),
            b_factor: column(&self.b_factor, &sources),
            formal_charge: column(&self.formal_charge, &sources),
            partial_charge: column(&self.partial_charge, &sources),
            isotope: column(&self.isotope, &sources),
            radical: column(&self.radical, &sources),
            residues,
            chains: self.chains.clone(),
            bonds: Vec::new(),
            stated_bonds: StatedBonds::None,
            bond_stereo: Vec::new(),
            frames: vec![Frame { positions, cell, title, vectors, time_ps }],
            secondary: Vec::new(),
            symmetry: None,
            assemblies: Vec::new(),
            components: self.components.clone(),
            properties: self.properties.clone(),
        }
    }

    /// The same structure with these alternate locations, one an atom; a list of another length changes nothing.
    #[must_use]
    pub fn with_altlocs(mut self, altlocs: Vec<u8>) -> Structure {
        if altlocs.len() == self.atom_count() {
            self.altloc = altlocs;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, Diagnostics, StructureBuilder};

    #[test]
    fn copies_have_all_that_is_said_about_the_original() {
        let mut builder = StructureBuilder::new();
        for (element, number) in [(Element::N, 1), (Element::C, 1), (Element::O, 2)] {
            builder.push_atom(&AtomRecord {
                element,
                residue: Some(("A", number, b' ', "GLY")),
                occupancy: f32::from(element.z()),
                ..AtomRecord::default()
            });
        }
        let structure = builder.build(&mut Diagnostics::default());
        let at = |atom, x| (atom, DVec3::new(x, 0.0, 0.0));
        let copy = structure.gather(&[at(2, 0.0), at(0, 1.0), at(1, 2.0), at(0, 3.0), at(9, 4.0)], None);
        assert_eq!(copy.elements(), [Element::O, Element::N, Element::C, Element::N]);
        assert_eq!(copy.occupancy(3), 7.0);
        assert_eq!(copy.positions().get(2), DVec3::new(2.0, 0.0, 0.0));
        let starts: Vec<(i32, u32)> = copy.residues().iter().map(|r| (r.number, r.first_atom)).collect();
        assert_eq!(starts, [(2, 0), (1, 1), (1, 3)]);
    }
}
