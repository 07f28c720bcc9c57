//! How importers fill a [`Structure`]: atom by atom, then frames, then bonds.

mod append;
mod columns;

pub(crate) use columns::AtomColumns;

use super::names::RecentNames;
use super::positions::Points;
use super::{
    Bond, BondStereo, Cell, ComponentBonds, Diagnostics, Frame, NameId, Names, Positions, Residue, SecondaryElement,
    StatedBonds, StereoMark, Structure, Symmetry, VectorField, bond,
};
use crate::element::Element;
use glam::DVec3;
use std::collections::HashMap;

/// Everything a file can say about one atom. The default is an unnamed dummy at the origin with occupancy 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtomRecord<'a> {
    /// Element.
    pub element: Element,
    /// Position in ångström; it must be finite (importers refuse the rest with a message).
    pub position: DVec3,
    /// Atom name, without blanks around it.
    pub name: &'a str,
    /// Serial number, if the format has one.
    pub serial: Option<i32>,
    /// Chain, residue number, insertion code (`b' '` for none) and residue name, if the format has residues.
    pub residue: Option<(&'a str, i32, u8, &'a str)>,
    /// Bits of [`super::atom_flags`].
    pub flags: u8,
    /// Alternate location, `b' '` for none.
    pub altloc: u8,
    /// Occupancy.
    pub occupancy: f32,
    /// Temperature factor in Å².
    pub b_factor: f32,
    /// Formal charge.
    pub formal_charge: i8,
    /// Partial charge.
    pub partial_charge: Option<f32>,
    /// Mass number, 0 for the natural mixture.
    pub isotope: u16,
    /// Radical: 0 none, 1 singlet, 2 doublet, 3 triplet.
    pub radical: u8,
}

impl Default for AtomRecord<'_> {
    fn default() -> Self {
        AtomRecord {
            element: Element::DUMMY,
            position: DVec3::ZERO,
            name: "",
            serial: None,
            residue: None,
            flags: 0,
            altloc: b' ',
            occupancy: 1.0,
            b_factor: 0.0,
            formal_charge: 0,
            partial_charge: None,
            isotope: 0,
            radical: 0,
        }
    }
}

/// Fills a [`Structure`].
#[derive(Debug, Default)]
pub struct StructureBuilder {
    title: String,
    names: Names,
    recent: RecentNames,
    element: Vec<Element>,
    points: Points,
    atom_name: Vec<NameId>,
    serial: Vec<i32>,
    /// Whether any atom came with a serial number.
    states_serials: bool,
    residue_of_atom: Vec<u32>,
    flags: Vec<u8>,
    altloc: Vec<u8>,
    occupancy: Vec<f32>,
    b_factor: Vec<f32>,
    formal_charge: Vec<i8>,
    partial_charge: Vec<f32>,
    isotope: Vec<u16>,
    radical: Vec<u8>,
    residues: Vec<Residue>,
    chains: Vec<NameId>,
    /// Index into `chains` by name: a hostile file may have as many chains as atoms.
    chain_indices: HashMap<NameId, u32>,
    bonds: Vec<Bond>,
    stated_bonds: StatedBonds,
    bond_stereo: Vec<(u32, u32, BondStereo)>,
    cell: Option<Cell>,
    decimals: u8,
    more_frames: Vec<Frame>,
    frame_title: String,
    secondary: Vec<SecondaryElement>,
    symmetry: Option<Symmetry>,
    components: Vec<ComponentBonds>,
    vectors: Vec<VectorField>,
    properties: Vec<(String, String)>,
    digits_lost: bool,
}

/// Appends to a column that exists only from the first value on that is not the default.
fn push_sparse<T: Copy + PartialEq>(column: &mut Vec<T>, index: usize, value: T, default: T) {
    if !column.is_empty() || value != default {
        column.resize(index, default);
        column.push(value);
    }
}

impl StructureBuilder {
    /// An empty one. Until [`StructureBuilder::set_decimals`] says otherwise, no digit of a position is dropped.
    #[must_use]
    pub fn new() -> StructureBuilder {
        StructureBuilder { decimals: Positions::MAX_DECIMALS, ..StructureBuilder::default() }
    }

    /// Number of atoms so far.
    #[must_use]
    pub fn atom_count(&self) -> usize {
        self.element.len()
    }

    /// Sets the title.
    pub fn set_title(&mut self, title: impl Into<String>) {
        self.title = title.into();
    }

    /// Sets the number of decimals that positions of this file are written with.
    pub fn set_decimals(&mut self, decimals: u8) {
        self.decimals = decimals.min(Positions::MAX_DECIMALS);
    }

    /// Room for some more atoms of nothing but elements and positions.
    pub fn reserve_positions(&mut self, atoms: usize) {
        self.element.reserve(atoms);
        self.points.reserve(atoms);
    }

    /// Room for some more atoms with names and residues, so that the columns need not be moved as they grow.
    pub fn reserve(&mut self, atoms: usize) {
        self.reserve_positions(atoms);
        self.atom_name.reserve(atoms);
        self.residue_of_atom.reserve(atoms);
    }

    fn intern(&mut self, text: &str) -> NameId {
        self.recent.intern(&mut self.names, text.as_bytes())
    }

    /// The id of a name for [`StructureBuilder::push_named_atom`]; what is no UTF-8 in it becomes U+FFFD.
    #[inline]
    pub fn name_id(&mut self, text: &[u8]) -> NameId {
        if text.is_empty() { NameId::default() } else { self.recent.intern(&mut self.names, text) }
    }

    /// Adds an atom and returns its index. A residue that differs from the last atom's starts a new one.
    pub fn push_atom(&mut self, atom: &AtomRecord<'_>) -> u32 {
        let index = self.element.len();
        if let Some(residue) = atom.residue {
            self.push_residue(index, residue);
        } else if !self.residue_of_atom.is_empty() {
            self.push_residue(index, ("", 0, b' ', ""));
        }
        self.push_columns(index, atom)
    }

    /// Adds atoms of which nothing but element and position is known, as [`StructureBuilder::push_atom`] would.
    pub(crate) fn push_bare_atoms(&mut self, elements: &[Element], positions: &[DVec3]) {
        if self.has_only_positions() {
            self.element.extend_from_slice(elements);
            self.points.extend(positions);
            return;
        }
        for (&element, &position) in elements.iter().zip(positions) {
            self.push_atom(&AtomRecord { element, position, ..AtomRecord::default() });
        }
    }

    /// Whether no atom came with more than its element and position.
    fn has_only_positions(&self) -> bool {
        let StructureBuilder { atom_name, serial, residue_of_atom, flags, altloc, occupancy, b_factor, .. } = self;
        let StructureBuilder { formal_charge, partial_charge, isotope, radical, .. } = self;
        let named = !(atom_name.is_empty() && serial.is_empty() && residue_of_atom.is_empty());
        let valued = !(occupancy.is_empty() && b_factor.is_empty() && partial_charge.is_empty());
        let marked = !(flags.is_empty() && altloc.is_empty() && formal_charge.is_empty());
        !named && !valued && !marked && isotope.is_empty() && radical.is_empty()
    }

    /// Starts a residue for the atoms that [`StructureBuilder::push_residue_atom`] adds, even if it has the chain,
    /// number, insertion code and name of the last one.
    pub fn begin_residue(&mut self, chain: &str, number: i32, insertion_code: u8, name: &str) {
        let index = self.element.len();
        self.name_atoms_without_residue(index);
        self.begin_residue_at(index, chain, number, insertion_code, name);
    }

    fn begin_residue_at(&mut self, index: usize, chain: &str, number: i32, insertion_code: u8, name: &str) {
        let name = self.intern(name);
        let chain = self.intern(chain);
        let chain = self.chain_index(chain);
        let first_atom = u32::try_from(index).unwrap_or(u32::MAX);
        self.residues.push(Residue { name, number, insertion_code, chain, first_atom });
    }

    /// Adds an atom to the residue begun last, whatever [`AtomRecord::residue`] says, and returns its index.
    pub fn push_residue_atom(&mut self, atom: &AtomRecord<'_>) -> u32 {
        let index = self.element.len();
        if self.residues.is_empty() {
            self.begin_residue("", 0, b' ', "");
        }
        self.residue_of_atom.push(u32::try_from(self.residues.len() - 1).unwrap_or(u32::MAX));
        self.push_columns(index, atom)
    }

    /// As [`StructureBuilder::push_residue_atom`], its name given as an id of this builder's ([`StructureBuilder::name_id`]).
    #[inline]
    pub fn push_named_atom(&mut self, atom: &AtomRecord<'_>, name: NameId) -> u32 {
        let index = self.element.len();
        if self.residues.is_empty() {
            self.begin_residue("", 0, b' ', "");
        }
        self.residue_of_atom.push(u32::try_from(self.residues.len() - 1).unwrap_or(u32::MAX));
        if !self.atom_name.is_empty() || name != NameId::default() {
            self.atom_name.resize(index, NameId::default());
            self.atom_name.push(name);
        }
        self.push_values(index, atom)
    }

    fn push_columns(&mut self, index: usize, atom: &AtomRecord<'_>) -> u32 {
        if !self.atom_name.is_empty() || !atom.name.is_empty() {
            let name = self.intern(atom.name);
            self.atom_name.resize(index, NameId::default());
            self.atom_name.push(name);
        }
        self.push_values(index, atom)
    }

    #[inline]
    fn push_values(&mut self, index: usize, atom: &AtomRecord<'_>) -> u32 {
        self.element.push(atom.element);
        self.points.push(atom.position);
        let counted = i32::try_from(index + 1).unwrap_or(i32::MAX);
        self.states_serials |= atom.serial.is_some();
        if !self.serial.is_empty() || atom.serial.is_some_and(|serial| serial != counted) {
            while self.serial.len() < index {
                self.serial.push(i32::try_from(self.serial.len() + 1).unwrap_or(i32::MAX));
            }
            self.serial.push(atom.serial.unwrap_or(counted));
        }
        push_sparse(&mut self.flags, index, atom.flags, 0);
        push_sparse(&mut self.altloc, index, atom.altloc, b' ');
        push_sparse(&mut self.occupancy, index, atom.occupancy, 1.0);
        push_sparse(&mut self.b_factor, index, atom.b_factor, 0.0);
        push_sparse(&mut self.formal_charge, index, atom.formal_charge, 0);
        push_sparse(&mut self.isotope, index, atom.isotope, 0);
        push_sparse(&mut self.radical, index, atom.radical, 0);
        if !self.partial_charge.is_empty() || atom.partial_charge.is_some() {
            self.partial_charge.resize(index, 0.0);
            self.partial_charge.push(atom.partial_charge.unwrap_or(0.0));
        }
        u32::try_from(index).unwrap_or(u32::MAX)
    }

    fn push_residue(&mut self, index: usize, (chain, number, insertion_code, name): (&str, i32, u8, &str)) {
        self.enter_residue(chain.as_bytes(), number, insertion_code, name.as_bytes());
        debug_assert_eq!(self.residue_of_atom.len(), index);
        self.residue_of_atom.push(u32::try_from(self.residues.len() - 1).unwrap_or(u32::MAX));
    }

    /// Starts a residue for the atoms that follow, unless it is the last one: chain, number, insertion code and name
    /// tell. What is no UTF-8 in names becomes U+FFFD.
    pub fn enter_residue(&mut self, chain: &[u8], number: i32, insertion_code: u8, name: &[u8]) {
        let index = self.element.len();
        self.name_atoms_without_residue(index);
        let name = self.recent.intern(&mut self.names, name);
        let chain_name = self.recent.intern(&mut self.names, chain);
        let same = self.residues.last().is_some_and(|last| {
            last.name == name
                && last.number == number
                && last.insertion_code == insertion_code
                && self.chains[last.chain as usize] == chain_name
        });
        if !same {
            let chain = self.chain_index(chain_name);
            let first_atom = u32::try_from(index).unwrap_or(u32::MAX);
            self.residues.push(Residue { name, number, insertion_code, chain, first_atom });
        }
    }

    /// Before the first atom with a residue: the atoms without one form one unnamed residue.
    fn name_atoms_without_residue(&mut self, index: usize) {
        if self.residue_of_atom.len() < index {
            let unnamed = self.intern("");
            let chain = self.chain_index(unnamed);
            self.residues.push(Residue { name: unnamed, number: 0, insertion_code: b' ', chain, first_atom: 0 });
            self.residue_of_atom.resize(index, 0);
        }
    }

    fn chain_index(&mut self, chain: NameId) -> u32 {
        let last = self.residues.last().map(|residue| residue.chain);
        if let Some(index) = last.filter(|&index| self.chains[index as usize] == chain) {
            return index;
        }
        let next = u32::try_from(self.chains.len()).unwrap_or(u32::MAX);
        let index = *self.chain_indices.entry(chain).or_insert(next);
        if index == next {
            self.chains.push(chain);
        }
        index
    }

    /// Replaces every position of the first frame by `place(position)`; `false` as soon as one does not satisfy `is_sound`
    /// (fractional coordinates are placed once the cell is known).
    #[must_use]
    pub fn map_positions(&mut self, place: impl Fn(DVec3) -> DVec3, is_sound: impl Fn(DVec3) -> bool) -> bool {
        self.points.map(place, is_sound)
    }

    /// Replaces the formal charge of an atom (property lines come after the atoms in some formats).
    pub fn set_formal_charge(&mut self, atom: usize, charge: i8) {
        set_sparse(&mut self.formal_charge, self.element.len(), atom, charge, 0);
    }

    /// Replaces the isotope of an atom.
    pub fn set_isotope(&mut self, atom: usize, mass_number: u16) {
        set_sparse(&mut self.isotope, self.element.len(), atom, mass_number, 0);
    }

    /// Replaces the radical of an atom.
    pub fn set_radical(&mut self, atom: usize, radical: u8) {
        set_sparse(&mut self.radical, self.element.len(), atom, radical, 0);
    }

    /// Sets all formal charges back to 0 (a `M  CHG` line supersedes the charges of the atom block).
    pub fn clear_formal_charges(&mut self) {
        self.formal_charge.clear();
    }

    /// Adds a bond the file states. A bond of a pair that is there already, of an atom to itself, or to an atom
    /// that is not there is dropped at [`StructureBuilder::build`]; importers say so before.
    pub fn push_bond(&mut self, bond: Bond) {
        self.bonds.push(bond);
    }

    /// Adds a stereo mark for the bond from atom `from` (the narrow end of a wedge) to atom `to`.
    pub fn push_bond_stereo(&mut self, from: u32, to: u32, stereo: BondStereo) {
        self.bond_stereo.push((from, to, stereo));
    }

    /// Says what the bond list means for bonds it does not list. Default: [`StatedBonds::None`].
    pub fn set_stated_bonds(&mut self, stated: StatedBonds) {
        self.stated_bonds = stated;
    }

    /// Sets the unit cell of the first frame.
    pub fn set_cell(&mut self, cell: Option<Cell>) {
        self.cell = cell;
    }

    /// Sets the title of the first frame.
    pub fn set_frame_title(&mut self, title: impl Into<String>) {
        self.frame_title = title.into();
    }

    /// Adds a further frame. `points` has one position an atom; a frame of another length is refused with `false`.
    #[must_use]
    pub fn push_frame(&mut self, points: &[DVec3], cell: Option<Cell>, title: impl Into<String>) -> bool {
        if points.len() != self.element.len() {
            return false;
        }
        let (positions, lost) = Positions::from_f64(points, self.decimals);
        self.digits_lost |= lost;
        self.more_frames.push(Frame { positions, cell, title: title.into(), vectors: Vec::new(), time_ps: None });
        true
    }

    /// Adds a helix or strand.
    pub fn push_secondary(&mut self, element: SecondaryElement) {
        self.secondary.push(element);
    }

    /// Sets the symmetry of the crystal.
    pub fn set_symmetry(&mut self, symmetry: Option<Symmetry>) {
        self.symmetry = symmetry;
    }

    /// Adds the bonds inside residues of one name.
    pub fn push_component(&mut self, component: ComponentBonds) {
        self.components.push(component);
    }

    /// Adds a vector field to the first frame; one of another length than the atoms is refused with `false`.
    #[must_use]
    pub fn push_vectors(&mut self, field: VectorField) -> bool {
        let fits = field.vectors.len() == self.element.len();
        if fits {
            self.vectors.push(field);
        }
        fits
    }

    /// Adds a named text (an SDF data field).
    pub fn push_property(&mut self, name: impl Into<String>, value: impl Into<String>) {
        self.properties.push((name.into(), value.into()));
    }

    /// The elements so far; importers compare them to tell a further frame from another molecule.
    #[must_use]
    pub fn elements(&self) -> &[Element] {
        &self.element
    }

    /// Finishes. Digits that had to be dropped are warned of.
    #[must_use]
    pub fn build(self, diagnostics: &mut Diagnostics) -> Structure {
        let (positions, lost) = self.points.into_positions(self.decimals);
        if lost || self.digits_lost {
            let message = "positions have more digits than can be kept (atoms millions of ångström apart); the last ones are rounded";
            diagnostics.warn(None, message);
        }
        let (cell, title, vectors) = (self.cell, self.frame_title, self.vectors);
        let mut frames = vec![Frame { positions, cell, title, vectors, time_ps: None }];
        frames.extend(self.more_frames);
        let bonds = bond::normalise(self.bonds, self.element.len());
        let bond_stereo = self
            .bond_stereo
            .iter()
            .filter_map(|&(from, to, stereo)| {
                let key = (from.min(to), from.max(to), [0; 3]);
                let index = bonds.binary_search_by_key(&key, Bond::key).ok()?;
                Some(StereoMark { bond: u32::try_from(index).ok()?, from, stereo })
            })
            .collect();
        let mut structure = Structure {
            title: self.title,
            names: self.names,
            element: self.element,
            atom_name: self.atom_name,
            serial: self.serial,
            residue_of_atom: self.residue_of_atom,
            flags: self.flags,
            altloc: self.altloc,
            occupancy: self.occupancy,
            b_factor: self.b_factor,
            formal_charge: self.formal_charge,
            partial_charge: self.partial_charge,
            isotope: self.isotope,
            radical: self.radical,
            residues: self.residues,
            chains: self.chains,
            bonds,
            stated_bonds: self.stated_bonds,
            bond_stereo,
            frames,
            secondary: self.secondary,
            symmetry: self.symmetry,
            assemblies: Vec::new(),
            components: self.components,
            properties: self.properties,
        };
        structure.shrink();
        structure
    }
}

/// Sets one value of a column that exists only from the first value on that is not the default.
fn set_sparse<T: Copy + PartialEq>(column: &mut Vec<T>, atom_count: usize, atom: usize, value: T, default: T) {
    if atom < atom_count && (!column.is_empty() || value != default) {
        column.resize(atom_count, default);
        column[atom] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::super::BondSource;
    use super::*;
    use crate::structure::BondOrder;

    #[test]
    fn absent_columns_cost_nothing_and_read_as_defaults() {
        let mut builder = StructureBuilder::new();
        for _ in 0..3 {
            builder.push_atom(&AtomRecord { element: Element::C, ..AtomRecord::default() });
        }
        builder.push_atom(&AtomRecord {
            element: Element::O,
            occupancy: 0.5,
            serial: Some(77),
            ..AtomRecord::default()
        });
        builder.set_formal_charge(1, -1);
        let structure = builder.build(&mut Diagnostics::default());
        assert!(structure.altloc.is_empty() && structure.residue_of_atom.is_empty());
        assert_eq!((structure.occupancy(0), structure.occupancy(3)), (1.0, 0.5));
        assert_eq!((structure.serial(0), structure.serial(3)), (1, 77));
        assert_eq!((structure.formal_charge(1), structure.formal_charge(3)), (-1, 0));
        assert_eq!(structure.residue_index(0), None);
    }

    #[test]
    fn bare_atoms_are_atoms_without_anything_else() {
        for isotope in [0, 13] {
            let point = |n: usize| DVec3::splat(n as f64);
            let (mut one_by_one, mut at_once) = (StructureBuilder::new(), StructureBuilder::new());
            for builder in [&mut one_by_one, &mut at_once] {
                builder.push_atom(&AtomRecord { element: Element::C, isotope, ..AtomRecord::default() });
            }
            for n in 1..4 {
                one_by_one.push_atom(&AtomRecord { element: Element::O, position: point(n), ..AtomRecord::default() });
            }
            at_once.push_bare_atoms(&[Element::O; 3], &[point(1), point(2), point(3)]);
            let [one_by_one, at_once] = [one_by_one, at_once].map(|b| b.build(&mut Diagnostics::default()));
            assert_eq!((one_by_one.isotope(0), one_by_one.atom_count()), (isotope, 4));
            assert_eq!(one_by_one, at_once);
        }
    }

    #[test]
    fn residues_are_runs_and_chains_are_distinct() {
        let mut builder = StructureBuilder::new();
        for residue in [("A", 1, b' ', "ALA"), ("A", 1, b' ', "ALA"), ("B", 1, b' ', "ALA"), ("A", 2, b'A', "GLY")] {
            builder.push_atom(&AtomRecord { residue: Some(residue), ..AtomRecord::default() });
        }
        let structure = builder.build(&mut Diagnostics::default());
        assert_eq!(structure.residues().len(), 3);
        assert_eq!(structure.chains().collect::<Vec<_>>(), ["A", "B"]);
        assert_eq!(structure.residue_index(3), Some(2));
        assert_eq!(structure.residues()[2].first_atom, 3);
    }

    #[test]
    fn stereo_marks_follow_their_bonds() {
        let mut builder = StructureBuilder::new();
        for _ in 0..3 {
            builder.push_atom(&AtomRecord::default());
        }
        builder.push_bond(Bond::new(2, 1, BondOrder::Single, BondSource::File));
        builder.push_bond(Bond::new(0, 1, BondOrder::Single, BondSource::File));
        builder.push_bond_stereo(2, 1, BondStereo::Up);
        let structure = builder.build(&mut Diagnostics::default());
        let up = |bond| [StereoMark { bond, from: 2, stereo: BondStereo::Up }];
        assert_eq!(structure.bond_stereo(), up(1));
        let bond = |a, b| Bond::new(a, b, BondOrder::Single, BondSource::Distance);
        let more = structure.with_bonds(vec![bond(0, 1), bond(0, 2), bond(1, 2)]);
        assert_eq!(more.bond_stereo(), up(2));
        assert!(more.with_bonds(vec![bond(0, 1)]).bond_stereo().is_empty());
    }
}
