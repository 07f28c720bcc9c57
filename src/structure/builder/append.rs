//! Putting together what was read in parts, so that parts may be read at the same time.

use super::StructureBuilder;
use crate::structure::{NameId, Residue};

impl StructureBuilder {
    /// Adds the atoms and residues of `other` behind those here, as if they had been pushed one by one. With `joins`
    /// the first residue of `other` is the rest of the last one here. Of what else `other` holds (title, bonds, cell,
    /// frames, …) nothing is taken over.
    pub fn append(&mut self, other: StructureBuilder, joins: bool) {
        if self.element.is_empty() && self.residues.is_empty() && self.names == Default::default() {
            self.take_atoms(other);
            return;
        }
        let (before, added) = (self.element.len(), other.element.len());
        // In the order of their first use, which is the order one reader alone would have met them in.
        let names: Vec<NameId> = other.names.texts().map(|text| self.names.intern(text)).collect();
        let name = |id: NameId| names.get(id.index()).copied().unwrap_or_default();
        self.append_residues(&other, joins, &name);
        if !self.atom_name.is_empty() || !other.atom_name.is_empty() {
            self.atom_name.resize(before, NameId::default());
            self.atom_name.extend(other.atom_name.iter().map(|&id| name(id)));
            self.atom_name.resize(before + added, NameId::default());
        }
        self.append_serials(&other);
        self.element.extend_from_slice(&other.element);
        self.points.append(other.points);
        append_sparse(&mut self.flags, before, &other.flags, added, 0);
        append_sparse(&mut self.altloc, before, &other.altloc, added, b' ');
        append_sparse(&mut self.occupancy, before, &other.occupancy, added, 1.0);
        append_sparse(&mut self.b_factor, before, &other.b_factor, added, 0.0);
        append_sparse(&mut self.formal_charge, before, &other.formal_charge, added, 0);
        append_sparse(&mut self.partial_charge, before, &other.partial_charge, added, 0.0);
        append_sparse(&mut self.isotope, before, &other.isotope, added, 0);
        append_sparse(&mut self.radical, before, &other.radical, added, 0);
    }

    /// As [`StructureBuilder::append`]; the first residue of `other` is the rest of the last one here if it has the same
    /// chain, number, insertion code and name, as [`StructureBuilder::push_atom`] has it.
    pub fn append_runs(&mut self, other: StructureBuilder) {
        let joins = match (self.residues.last(), other.residues.first()) {
            (Some(last), Some(first)) => {
                let chain_of = |builder: &'_ StructureBuilder, residue: &Residue| {
                    let name = builder.chains.get(residue.chain as usize).copied().unwrap_or_default();
                    builder.names.get(name).to_owned()
                };
                last.number == first.number
                    && last.insertion_code == first.insertion_code
                    && self.names.get(last.name) == other.names.get(first.name)
                    && chain_of(self, last) == chain_of(&other, first)
            }
            _ => false,
        };
        self.append(other, joins);
    }

    /// The first part: its columns become the columns here.
    fn take_atoms(&mut self, other: StructureBuilder) {
        self.names = other.names;
        self.element = other.element;
        self.points = other.points;
        self.atom_name = other.atom_name;
        self.serial = other.serial;
        self.states_serials = other.states_serials;
        self.residue_of_atom = other.residue_of_atom;
        self.flags = other.flags;
        self.altloc = other.altloc;
        self.occupancy = other.occupancy;
        self.b_factor = other.b_factor;
        self.formal_charge = other.formal_charge;
        self.partial_charge = other.partial_charge;
        self.isotope = other.isotope;
        self.radical = other.radical;
        self.residues = other.residues;
        self.chains = other.chains;
        self.chain_indices = other.chain_indices;
    }

    fn append_residues(&mut self, other: &StructureBuilder, joins: bool, name: &impl Fn(NameId) -> NameId) {
        let before = self.element.len();
        if other.residues.is_empty() {
            if !self.residue_of_atom.is_empty() && !other.element.is_empty() {
                self.begin_residue("", 0, b' ', "");
                let last = u32::try_from(self.residues.len() - 1).unwrap_or(u32::MAX);
                self.residue_of_atom.resize(before + other.element.len(), last);
            }
            return;
        }
        self.name_atoms_without_residue(before);
        let joins = joins && !self.residues.is_empty();
        let first_atom = u32::try_from(before).unwrap_or(u32::MAX);
        let first_residue = u32::try_from(self.residues.len() - usize::from(joins)).unwrap_or(u32::MAX);
        for residue in other.residues.iter().skip(usize::from(joins)) {
            let chain = other.chains.get(residue.chain as usize).copied().unwrap_or_default();
            let chain = self.chain_index(name(chain));
            self.residues.push(Residue {
                name: name(residue.name),
                chain,
                first_atom: residue.first_atom.saturating_add(first_atom),
                ..*residue
            });
        }
        self.residue_of_atom.extend(other.residue_of_atom.iter().map(|&index| index.saturating_add(first_residue)));
    }

    /// Serial numbers are there only from the first one on that is not the atom's place, counted from 1.
    fn append_serials(&mut self, other: &StructureBuilder) {
        let (before, added) = (self.element.len(), other.element.len());
        let counted = |index: usize| i32::try_from(index + 1).unwrap_or(i32::MAX);
        // Without a column they are 1, 2, 3, … there, if that was said, else whatever counting on gives.
        let start = if other.states_serials { 0 } else { before };
        let serial = |index: usize| other.serial.get(index).copied().unwrap_or(counted(start + index));
        self.states_serials |= other.states_serials;
        let is_counted = (0..added).all(|index| serial(index) == counted(before + index));
        if self.serial.is_empty() && is_counted {
            return;
        }
        self.serial.extend((self.serial.len()..before).map(counted));
        self.serial.extend((0..added).map(serial));
    }
}

/// Appends to a column that exists only from the first value on that is not the default.
fn append_sparse<T: Copy>(column: &mut Vec<T>, before: usize, other: &[T], added: usize, default: T) {
    if !column.is_empty() || !other.is_empty() {
        column.resize(before, default);
        column.extend_from_slice(other);
        column.resize(before + added, default);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Element;
    use crate::structure::{AtomRecord, Diagnostics, Structure};

    /// Atom `n` of a file with residues of three atoms in two chains that come again, and odd values now and then.
    fn push(builder: &mut StructureBuilder, n: usize, serial_shift: i32) {
        let chain = ["A", "B", "A", "a long chain name"][n / 6 % 4];
        let (residue, begins) = (n / 3, n.is_multiple_of(3));
        if begins || builder.atom_count() == 0 {
            builder.begin_residue(chain, residue as i32, b' ', ["ALA", "GLY"][residue % 2]);
        }
        builder.push_residue_atom(&AtomRecord {
            element: Element::C,
            name: ["CA", "CB", "C"][n % 3],
            serial: Some(n as i32 + 1 + serial_shift),
            occupancy: if n == 17 { 0.5 } else { 1.0 },
            formal_charge: i8::from(n == 4),
            altloc: if n > 20 { b'A' } else { b' ' },
            ..AtomRecord::default()
        });
    }

    fn build(builder: StructureBuilder) -> Structure {
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn parts_put_together_are_the_whole() {
        for shift in [0, 7] {
            let mut whole = StructureBuilder::new();
            (0..30).for_each(|n| push(&mut whole, n, shift));
            let whole = build(whole);
            for cut in 0..30 {
                let (mut first, mut second, mut parts) = Default::default();
                (0..cut).for_each(|n| push(&mut first, n, shift));
                (cut..30).for_each(|n| push(&mut second, n, shift));
                StructureBuilder::append(&mut parts, first, false);
                parts.append(second, !cut.is_multiple_of(3));
                parts.set_decimals(14);
                assert_eq!(build(parts), whole, "cut at {cut}");
            }
        }
    }

    #[test]
    fn atoms_without_residues_stay_without() {
        let mut builder = StructureBuilder::new();
        for _ in 0..2 {
            let mut part = StructureBuilder::new();
            part.push_atom(&AtomRecord { element: Element::O, ..AtomRecord::default() });
            builder.append(part, false);
        }
        let structure = build(builder);
        assert_eq!((structure.atom_count(), structure.residues().len(), structure.serial(1)), (2, 0, 2));
        assert!(structure.serial.is_empty());
    }
}
