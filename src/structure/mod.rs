//! The molecular model: everything a file said about a molecule, complete and immutable.
//!
//! A [`Structure`] is a structure of arrays. Importers fill one through a [`StructureBuilder`]; bond perception
//! adds bonds by [`Structure::with_bonds`]; nothing after that guesses. Lengths are ångström, angles degrees,
//! charges in units of the elementary charge. Columns a file does not have are empty and their accessors
//! give the stated default, so that an XYZ file does not pay for what only PDB files have.

mod assembly;
mod bond;
mod builder;
mod by_atom;
mod cell;
mod component;
mod diagnostic;
mod expand;
mod gather;
mod memory;
mod mesh;
mod names;
mod positions;
mod subset;
mod symmetry;

pub use assembly::{Assembly, AssemblyPart, is_rigid};
pub use bond::{Bond, BondKind, BondOrder, BondSource, StatedBonds};
pub(crate) use builder::AtomColumns;
pub use builder::{AtomRecord, StructureBuilder};
pub(crate) use by_atom::ByAtom;
pub use cell::Cell;
pub use component::{ComponentBond, ComponentBonds};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub(crate) use expand::apply_symmetry;
pub use mesh::{Mesh, MeshBuilder};
pub use names::{NameId, Names};
pub use positions::Positions;
pub(crate) use positions::{Points, joined};
pub use symmetry::{Symmetry, SymmetryOperation};

use crate::element::Element;

/// One set of atom positions: a model, a trajectory frame, or the only one.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Positions, one an atom, in the order of the atoms.
    pub positions: Positions,
    /// The unit cell of this frame, if the file states one.
    pub cell: Option<Cell>,
    /// The frame's comment or title, empty if there is none.
    pub title: String,
    /// Vectors on the atoms in this frame.
    pub vectors: Vec<VectorField>,
    /// The time of a simulation in picoseconds, if the file states one.
    pub time_ps: Option<f64>,
}

/// A contiguous run of atoms with the same chain, residue number, insertion code and residue name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Residue {
    /// Residue name (`ALA`), an index into [`Structure::names`].
    pub name: NameId,
    /// Residue number as the file gives it (author numbering in mmCIF).
    pub number: i32,
    /// Insertion code, `b' '` for none.
    pub insertion_code: u8,
    /// Index into [`Structure::chains`].
    pub chain: u32,
    /// The first atom; the run ends where the next residue starts.
    pub first_atom: u32,
}

/// What an atom is beside its element; bits of [`Structure::flags`].
pub mod atom_flags {
    /// The file lists the atom as a hetero atom (HETATM).
    pub const HETERO: u8 = 1;
    /// Not an atom: lone pair, dummy, Drude particle, centroid. Kept, drawn small, never bonded by distance.
    pub const PARTICLE: u8 = 2;
    /// One of several alternatives about a special position (a negative disorder group in a CIF): its own
    /// symmetry images are alternatives to it, and it bonds to none of them.
    pub const SYMMETRY_DISORDER: u8 = 4;
}

/// A helix or strand as the file states it, by residue numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SecondaryElement {
    /// `true` for a helix, `false` for a strand of a sheet.
    pub helix: bool,
    /// Chain identifier.
    pub chain: String,
    /// First residue number and insertion code.
    pub first: (i32, u8),
    /// Last residue number and insertion code.
    pub last: (i32, u8),
}

/// A vector on every atom: force, velocity, displacement.
#[derive(Debug, Clone, PartialEq)]
pub struct VectorField {
    /// The name in the file (`forces`, `velo`).
    pub name: String,
    /// One vector an atom, in the file's units.
    pub vectors: Vec<glam::Vec3>,
}

/// What a stereo mark on a bond of a 2D drawing says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BondStereo {
    /// Towards the viewer (wedge).
    Up,
    /// Away from the viewer (hash).
    Down,
    /// Either (wavy).
    Either,
    /// A double bond whose cis/trans geometry is not stated.
    CisTransEither,
}

/// A stereo mark on one bond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StereoMark {
    /// Index into [`Structure::bonds`].
    pub bond: u32,
    /// The atom that it starts from: the narrow end of a wedge, the stereo centre.
    pub from: u32,
    /// What it says.
    pub stereo: BondStereo,
}

/// A molecule, or whatever else one record of a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    pub(crate) title: String,
    pub(crate) names: Names,
    pub(crate) element: Vec<Element>,
    pub(crate) atom_name: Vec<NameId>,
    pub(crate) serial: Vec<i32>,
    pub(crate) residue_of_atom: Vec<u32>,
    pub(crate) flags: Vec<u8>,
    pub(crate) altloc: Vec<u8>,
    pub(crate) occupancy: Vec<f32>,
    pub(crate) b_factor: Vec<f32>,
    pub(crate) formal_charge: Vec<i8>,
    pub(crate) partial_charge: Vec<f32>,
    pub(crate) isotope: Vec<u16>,
    pub(crate) radical: Vec<u8>,
    pub(crate) residues: Vec<Residue>,
    pub(crate) chains: Vec<NameId>,
    pub(crate) bonds: Vec<Bond>,
    pub(crate) stated_bonds: StatedBonds,
    pub(crate) bond_stereo: Vec<StereoMark>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) secondary: Vec<SecondaryElement>,
    pub(crate) symmetry: Option<Symmetry>,
    pub(crate) assemblies: Vec<Assembly>,
    pub(crate) components: Vec<ComponentBonds>,
    pub(crate) properties: Vec<(String, String)>,
}

impl Structure {
    /// Number of atoms (particles that are no atoms included, all alternate locations counted).
    #[must_use]
    pub fn atom_count(&self) -> usize {
        self.element.len()
    }

    /// The title the file gives, or an empty string.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The elements, one an atom.
    #[must_use]
    pub fn elements(&self) -> &[Element] {
        &self.element
    }

    /// The text of an interned name.
    #[must_use]
    pub fn name(&self, id: NameId) -> &str {
        self.names.get(id)
    }

    /// The id of a name that something in the structure has.
    #[must_use]
    pub fn find_name(&self, text: &str) -> Option<NameId> {
        self.names.find(text)
    }

    /// Atom name (`CA`); an empty string if the file names no atoms.
    #[must_use]
    pub fn atom_name(&self, atom: usize) -> &str {
        self.atom_name.get(atom).map_or("", |&id| self.names.get(id))
    }

    /// The atom names, one an atom; empty if the file names no atoms.
    #[must_use]
    pub fn atom_names(&self) -> &[NameId] {
        &self.atom_name
    }

    /// The serial number in the file; the 1-based index if it has none.
    #[must_use]
    pub fn serial(&self, atom: usize) -> i32 {
        self.serial.get(atom).copied().unwrap_or(i32::try_from(atom + 1).unwrap_or(i32::MAX))
    }

    /// Index of the atom's residue in [`Structure::residues`]; `None` if the file has no residues.
    #[must_use]
    pub fn residue_index(&self, atom: usize) -> Option<usize> {
        self.residue_of_atom.get(atom).map(|&index| index as usize)
    }

    /// The residues in the order of their first atoms; empty if the file has none.
    #[must_use]
    pub fn residues(&self) -> &[Residue] {
        &self.residues
    }

    /// Chain identifiers, each once, in the order they appear.
    pub fn chains(&self) -> impl ExactSizeIterator<Item = &str> {
        self.chains.iter().map(|&id| self.names.get(id))
    }

    /// Bits of [`atom_flags`], 0 if the file has none.
    #[must_use]
    pub fn flags(&self, atom: usize) -> u8 {
        self.flags.get(atom).copied().unwrap_or(0)
    }

    /// Alternate location indicator, `b' '` for none.
    #[must_use]
    pub fn altloc(&self, atom: usize) -> u8 {
        self.altloc.get(atom).copied().unwrap_or(b' ')
    }

    /// Whether any atom has an alternate location indicator.
    #[must_use]
    pub fn has_altlocs(&self) -> bool {
        self.altloc.iter().any(|&code| code != b' ')
    }

    /// Occupancy, 1 if not stated.
    #[must_use]
    pub fn occupancy(&self, atom: usize) -> f32 {
        self.occupancy.get(atom).copied().unwrap_or(1.0)
    }

    /// Temperature factor B in Å², 0 if not stated.
    #[must_use]
    pub fn b_factor(&self, atom: usize) -> f32 {
        self.b_factor.get(atom).copied().unwrap_or(0.0)
    }

    /// Formal charge, 0 if not stated.
    #[must_use]
    pub fn formal_charge(&self, atom: usize) -> i8 {
        self.formal_charge.get(atom).copied().unwrap_or(0)
    }

    /// Partial charge, if the file states them.
    #[must_use]
    pub fn partial_charge(&self, atom: usize) -> Option<f32> {
        self.partial_charge.get(atom).copied()
    }

    /// Mass number, 0 for the natural mixture.
    #[must_use]
    pub fn isotope(&self, atom: usize) -> u16 {
        self.isotope.get(atom).copied().unwrap_or(0)
    }

    /// Radical as in MDL files: 0 none, 1 singlet, 2 doublet, 3 triplet.
    #[must_use]
    pub fn radical(&self, atom: usize) -> u8 {
        self.radical.get(atom).copied().unwrap_or(0)
    }

    /// The bonds: before perception those the file states, after it all of them. Sorted by
    /// [`Bond::key`], each as [`Bond::turned`] has it, no duplicates.
    #[must_use]
    pub fn bonds(&self) -> &[Bond] {
        &self.bonds
    }

    /// What the file's own bond list means.
    #[must_use]
    pub fn stated_bonds(&self) -> StatedBonds {
        self.stated_bonds
    }

    /// Stereo marks of a 2D drawing, in the file's order.
    #[must_use]
    pub fn bond_stereo(&self) -> &[StereoMark] {
        &self.bond_stereo
    }

    /// All frames; there is at least one.
    #[must_use]
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The positions of the first frame.
    #[must_use]
    pub fn positions(&self) -> &Positions {
        &self.frames[0].positions
    }

    /// The unit cell of the first frame.
    #[must_use]
    pub fn cell(&self) -> Option<&Cell> {
        self.frames[0].cell.as_ref()
    }

    /// The cell by whose vectors the listed atoms of a frame repeat, so that bonds go across its faces: `None` without a
    /// cell, where the atoms are an asymmetric unit that other operations repeat too, and where the cell is a mere
    /// placeholder (the 1 × 1 × 1 Å cell of NMR and microscopy entries).
    #[must_use]
    pub fn lattice(&self, frame: usize) -> Option<&Cell> {
        let is_p1 = |symmetry: &Symmetry| {
            let name: String = symmetry.space_group.split_whitespace().collect();
            symmetry.operations.len() <= 1 && (name.is_empty() || name.eq_ignore_ascii_case("P1"))
        };
        let cell = self.frames.get(frame)?.cell.as_ref()?;
        let repeats = self.symmetry.as_ref().is_none_or(is_p1);
        (repeats && self.fits(cell)).then_some(cell)
    }

    /// Whether a cell has room for the atoms, and is no mere placeholder.
    #[must_use]
    pub fn fits(&self, cell: &Cell) -> bool {
        /// Atoms in a cubic ångström. Diamond has 0.176, the densest of all matter at ordinary pressure; twice as many,
        /// for alternate locations, leave no doubt.
        const DENSEST: f64 = 0.36;
        self.atom_count() as f64 <= DENSEST * cell.volume()
    }

    /// The same structure as if its file stated no symmetry.
    #[must_use]
    pub fn without_symmetry(self) -> Structure {
        Structure { symmetry: None, ..self }
    }

    /// Helices and strands the file states.
    #[must_use]
    pub fn secondary(&self) -> &[SecondaryElement] {
        &self.secondary
    }

    /// The symmetry of the crystal, if the file states it.
    #[must_use]
    pub fn symmetry(&self) -> Option<&Symmetry> {
        self.symmetry.as_ref()
    }

    /// The bonds inside residues as the file itself lists them by atom names (`_chem_comp_bond`).
    #[must_use]
    pub fn components(&self) -> &[ComponentBonds] {
        &self.components
    }

    /// Vectors on atoms in the first frame.
    #[must_use]
    pub fn vectors(&self) -> &[VectorField] {
        &self.frames[0].vectors
    }

    /// Data fields (SDF) and other named texts of the file.
    #[must_use]
    pub fn properties(&self) -> &[(String, String)] {
        &self.properties
    }

    /// The same structure with these bonds in place of its own. They are turned ([`Bond::turned`]), sorted and made unique
    /// (the first of a pair stays); bonds of an atom to itself or to an atom that is not there are left out. Stereo marks
    /// follow their bonds, or go with them.
    #[must_use]
    pub fn with_bonds(mut self, bonds: Vec<Bond>) -> Structure {
        let old = std::mem::replace(&mut self.bonds, bond::normalise(bonds, self.element.len()));
        self.bonds.shrink_to_fit();
        let bonds = &self.bonds;
        self.bond_stereo = (self.bond_stereo.iter())
            .filter_map(|mark| {
                let marked = old.get(mark.bond as usize)?;
                let index = bonds.binary_search_by_key(&marked.key(), Bond::key).ok()?;
                Some(StereoMark { bond: u32::try_from(index).ok()?, ..*mark })
            })
            .collect();
        self
    }

    /// The same structure with these formal charges in place of its own, one an atom; a list of another length is none.
    #[must_use]
    pub fn with_formal_charges(mut self, charges: Vec<i8>) -> Structure {
        let is_stated = charges.len() == self.element.len() && charges.iter().any(|&charge| charge != 0);
        self.formal_charge = if is_stated { charges } else { Vec::new() };
        self
    }

    /// Whether any atom has a formal charge.
    #[must_use]
    pub fn has_formal_charges(&self) -> bool {
        self.formal_charge.iter().any(|&charge| charge != 0)
    }

    /// A copy with frame `index` as its first and only one, the others not copied; `None` if there is no such frame.
    #[must_use]
    pub fn at_frame(&self, index: usize) -> Option<Structure> {
        Some(self.with_frame(self.frames.get(index)?.clone()))
    }

    /// A copy with this frame in place of its own. A frame of another number of atoms is of another structure.
    #[must_use]
    pub fn with_frame(&self, frame: Frame) -> Structure {
        Structure {
            title: self.title.clone(),
            names: self.names.clone(),
            element: self.element.clone(),
            atom_name: self.atom_name.clone(),
            serial: self.serial.clone(),
            residue_of_atom: self.residue_of_atom.clone(),
            flags: self.flags.clone(),
            altloc: self.altloc.clone(),
            occupancy: self.occupancy.clone(),
            b_factor: self.b_factor.clone(),
            formal_charge: self.formal_charge.clone(),
            partial_charge: self.partial_charge.clone(),
            isotope: self.isotope.clone(),
            radical: self.radical.clone(),
            residues: self.residues.clone(),
            chains: self.chains.clone(),
            bonds: self.bonds.clone(),
            stated_bonds: self.stated_bonds,
            bond_stereo: self.bond_stereo.clone(),
            frames: vec![frame],
            secondary: self.secondary.clone(),
            symmetry: self.symmetry.clone(),
            assemblies: self.assemblies.clone(),
            components: self.components.clone(),
            properties: self.properties.clone(),
        }
    }

    /// The same structure with frame `index` as its first and only one; `None` if there is no such frame.
    #[must_use]
    pub fn with_only_frame(mut self, index: usize) -> Option<Structure> {
        if index >= self.frames.len() {
            return None;
        }
        let frame = self.frames.swap_remove(index);
        self.frames = vec![frame];
        Some(self)
    }
}
