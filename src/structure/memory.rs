//! How much memory a structure takes.

use super::{Assembly, Bond, Frame, Structure};
use std::mem::size_of;

/// Bytes that a list has set aside.
fn list<T>(list: &Vec<T>) -> usize {
    list.capacity() * size_of::<T>()
}

impl Structure {
    /// Gives back what the columns have set aside for more atoms: they were read one by one, and grew by doubling. Large ones stay where
    /// they are.
    pub(super) fn shrink(&mut self) {
        self.element.shrink_to_fit();
        self.atom_name.shrink_to_fit();
        self.serial.shrink_to_fit();
        self.residue_of_atom.shrink_to_fit();
        self.flags.shrink_to_fit();
        self.altloc.shrink_to_fit();
        self.occupancy.shrink_to_fit();
        self.b_factor.shrink_to_fit();
        self.formal_charge.shrink_to_fit();
        self.partial_charge.shrink_to_fit();
        self.isotope.shrink_to_fit();
        self.radical.shrink_to_fit();
        self.residues.shrink_to_fit();
        self.bonds.shrink_to_fit();
    }

    /// Bytes on the heap that it has set aside, to a few for each text and table. What atoms and bonds take grows with their number
    /// and with the columns that the file has: a protein's atom and bond take some 55 bytes.
    ///
    /// ```
    /// let file = b"2\nhydrogen\nH 0 0 0\nH 0 0 0.74\n";
    /// let document = ballstick::import::read_bytes(file, "h2.xyz", &Default::default())?;
    /// assert!(document.records[0].memory() < 1000);
    /// # Ok::<(), ballstick::Error>(())
    /// ```
    #[must_use]
    pub fn memory(&self) -> usize {
        let atoms = list(&self.element)
            + list(&self.atom_name)
            + list(&self.serial)
            + list(&self.residue_of_atom)
            + list(&self.flags)
            + list(&self.altloc)
            + list(&self.occupancy)
            + list(&self.b_factor)
            + list(&self.formal_charge)
            + list(&self.partial_charge)
            + list(&self.isotope)
            + list(&self.radical);
        let frame = |frame: &Frame| {
            let vectors = frame.vectors.iter().map(|field| field.name.capacity() + list(&field.vectors)).sum::<usize>();
            size_of::<Frame>() + frame.positions.memory() + frame.title.capacity() + vectors
        };
        let assembly = |assembly: &Assembly| {
            let parts = assembly.parts.iter().map(|part| list(&part.atoms) + list(&part.operations)).sum::<usize>();
            size_of::<Assembly>()
                + assembly.id.capacity()
                + assembly.description.capacity()
                + list(&assembly.operations)
                + parts
        };
        let component = |component: &super::ComponentBonds| {
            let names = component.bonds.iter().map(|bond| bond.a.capacity() + bond.b.capacity()).sum::<usize>();
            component.name.capacity() + list(&component.bonds) + names
        };
        let texts = self.properties.iter().map(|(name, value)| name.capacity() + value.capacity()).sum::<usize>();
        atoms
            + list(&self.residues)
            + list(&self.chains)
            + self.bonds.capacity() * size_of::<Bond>()
            + list(&self.bond_stereo)
            + self.frames.iter().map(frame).sum::<usize>()
            + list(&self.secondary)
            + self.symmetry.as_ref().map_or(0, |symmetry| list(&symmetry.operations))
            + self.assemblies.iter().map(assembly).sum::<usize>()
            + self.components.iter().map(component).sum::<usize>()
            + self.names.memory()
            + self.title.capacity()
            + texts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, BondOrder, BondSource, Diagnostics, StructureBuilder};
    use glam::DVec3;

    /// The aim: at most 100 bytes an atom and bond, whatever a PDB file says of its atoms.
    #[test]
    fn an_atom_with_all_columns_of_a_pdb_file_and_a_bond_take_at_most_100_bytes() {
        assert!(size_of::<Bond>() <= 16, "{}", size_of::<Bond>());
        let mut builder = StructureBuilder::new();
        builder.set_decimals(3);
        const COUNT: u32 = 40_000;
        for number in 0..COUNT {
            let name = ["N", "CA", "C", "O"][number as usize % 4];
            builder.push_atom(&AtomRecord {
                position: DVec3::new(f64::from(number) * 0.1, 1.234, -5.678),
                name,
                serial: Some(number as i32 + 7),
                residue: Some(("A", (number / 8) as i32, b' ', "GLY")),
                flags: 1,
                altloc: b'A',
                occupancy: 0.5,
                b_factor: 12.34,
                formal_charge: 1,
                ..AtomRecord::default()
            });
        }
        let structure = builder.build(&mut Diagnostics::default());
        let bond = |atom| Bond::new(atom, atom + 1, BondOrder::Single, BondSource::Dictionary);
        let structure = structure.with_bonds((0..COUNT - 1).map(bond).collect());
        let each = structure.memory() as f64 / f64::from(COUNT);
        assert!((50.0..=60.0).contains(&each), "{each} bytes");
    }
}
