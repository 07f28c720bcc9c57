//! Frames of one molecule with the bonds of one of them: what a simulation means, whose bonds neither form nor break.
//!
//! The bonds, and with them the molecules, are found once. In each frame only positions and cell are new. Where a cell repeats the atoms, programs
//! write them wrapped into it, each by itself, so that bonds go across other faces in every frame. Which image of its partner
//! an atom is bonded to is told from the vector of the bond in the frame in which it was found, in fractions of the cell: the image is the
//! one that comes nearest to it. A bond may turn as it likes as long as the cell is more than some four bonds wide; in smaller cells,
//! of crystals, bonds keep their direction.
//!
//! Molecules that end are put together along their bonds from their first atoms on, and atoms keep their order. Of endless networks,
//! and where whole cells are asked for, the content is drawn as [`super::draw`] has it, and then atoms are another list in each frame.
//!
//! Hydrogen bonds, if asked for, are those of each frame; those across a face are left out.

use super::molecules::{self, Neighbours};
use super::{CellChoice, Copies, CrystalOptions, Drawn, fractional_positions, lattice, place, without_images};
use crate::bonds::{self, BondOptions};
use crate::error::{Error, Result};
use crate::stop::Stop;
use crate::structure::{Bond, Cell, Frame, Structure};
use glam::DVec3;
use std::sync::atomic::{AtomicU64, Ordering};

/// When the bonds of a molecule with several frames are found anew; the names are those of `--bonds-per-frame`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum BondsPerFrame {
    /// In each frame of a file that lists its atoms in each (a reaction in an XYZ file); once for the frames of a trajectory, whose bonds are those
    /// of the structure it belongs to.
    #[default]
    Auto,
    /// In each frame.
    Always,
    /// Once: those of the structure, or of the first frame.
    Never,
}

impl BondsPerFrame {
    /// All of them.
    pub const ALL: [BondsPerFrame; 3] = [BondsPerFrame::Auto, BondsPerFrame::Always, BondsPerFrame::Never];

    /// `auto`, `always` or `never`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            BondsPerFrame::Auto => "auto",
            BondsPerFrame::Always => "always",
            BondsPerFrame::Never => "never",
        }
    }

    /// The choice of a name; `None` for any other text.
    #[must_use]
    pub fn from_name(name: &str) -> Option<BondsPerFrame> {
        Self::ALL.into_iter().find(|choice| choice.name() == name)
    }

    /// Whether bonds are those of one frame, for the frames of a trajectory or of a file that lists its atoms in each.
    #[must_use]
    pub fn is_fixed(self, is_trajectory: bool) -> bool {
        match self {
            BondsPerFrame::Auto => is_trajectory,
            BondsPerFrame::Always => false,
            BondsPerFrame::Never => true,
        }
    }
}

/// A step from an atom to one bonded to it.
struct Branch {
    from: u32,
    to: u32,
    /// The vector in fractions of the cell.
    vector: DVec3,
}

/// A molecule whose bonds are known, ready for frames.
pub struct Fixed {
    /// As [`Drawn::kind`].
    kind: u64,
    structure: Structure,
    options: CrystalOptions,
    /// The vector of every bond in fractions of the cell; empty where no cell repeats the atoms.
    vectors: Vec<DVec3>,
    /// From the first atom of each molecule to all others, each once, outwards.
    branches: Vec<Branch>,
    is_endless: bool,
    lattice: Vec<bool>,
    copies: Option<Copies>,
}

impl Fixed {
    /// Finds the bonds in the structure's first frame, in which the symmetry of a crystal counts; frames have none.
    #[must_use]
    pub fn new(structure: Structure, options: &CrystalOptions) -> Fixed {
        Fixed::until(structure, options, &Stop::never())
    }

    /// The same unless it is given up.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    pub fn new_unless(structure: Structure, options: &CrystalOptions, stop: &Stop) -> Result<Fixed> {
        let fixed = Fixed::until(structure, options, stop);
        stop.check()?;
        Ok(fixed)
    }

    /// The same; if it is given up, with some of the bonds.
    fn until(structure: Structure, options: &CrystalOptions, stop: &Stop) -> Fixed {
        // One that is too large is drawn as listed: there is no frame of it that could be drawn.
        let copies = super::assembly(&structure, options).ok().flatten();
        let once = BondOptions { hydrogen_bonds: false, ..options.bonds };
        let structure = bonds::assign_until(structure, &once, stop).without_symmetry();
        let mut vectors = Vec::new();
        if let Some(cell) = structure.lattice(0) {
            let at = fractional_positions(&structure, cell);
            let image = |bond: &Bond| DVec3::from_array(bond.image.map(f64::from));
            let vector = |bond: &Bond| at[bond.b as usize] + image(bond) - at[bond.a as usize];
            vectors = structure.bonds().iter().map(vector).collect();
        }
        let neighbours = Neighbours::new(&structure);
        let is_endless =
            molecules::find(&neighbours, structure.atom_count()).iter().any(|molecule| molecule.is_endless);
        let branches = branches(&structure, &neighbours, &vectors);
        let lattice = lattice::atoms(&structure);
        /// The last number that was given.
        static LAST: AtomicU64 = AtomicU64::new(0);
        let kind = LAST.fetch_add(1, Ordering::Relaxed) + 1;
        Fixed { kind, structure, options: *options, vectors, branches, is_endless, lattice, copies }
    }

    /// What is drawn of a frame.
    ///
    /// # Errors
    /// [`Error::Input`] if the frame has another number of atoms, [`Error::Limit`] as [`super::draw`].
    pub fn draw(&self, mut frame: Frame) -> Result<Drawn> {
        let (atoms, there) = (self.structure.atom_count(), frame.positions.len());
        if atoms != there {
            return Err(Error::input(None, format!("the frame has {there} atoms, the molecule {atoms}")));
        }
        let supercell = self.options.supercell.iter().any(|&count| count > 1);
        let is_one = self.copies.is_some() || (!supercell && self.options.cell == CellChoice::Molecule);
        let is_whole = !self.is_endless && is_one;
        let cell = frame.cell;
        let structure = match (cell, is_whole) {
            (Some(cell), true) if self.structure.fits(&cell) => {
                self.join(&mut frame, &cell);
                self.joined(frame)
            }
            (Some(cell), false) if self.structure.fits(&cell) && self.copies.is_none() => {
                let structure = self.with_images(self.structure.with_frame(frame), &cell);
                let structure = self.with_hydrogen_bonds(structure);
                return place(structure, None, atoms, &self.options);
            }
            (_, _) if self.is_endless => without_images(self.structure.with_frame(frame)),
            _ => self.joined(frame),
        };
        let structure = without_images(self.with_hydrogen_bonds(structure));
        let (lattice, copies) = (self.lattice.clone(), self.copies.clone());
        Ok(Drawn { cell, lattice, copies, kind: self.kind, ..Drawn::plain(structure) })
    }

    /// The structure with a frame in which no bond goes to an image.
    fn joined(&self, frame: Frame) -> Structure {
        let structure = self.structure.with_frame(frame);
        if !structure.bonds().iter().any(Bond::is_periodic) {
            return structure;
        }
        let bonds = structure.bonds().iter().map(|bond| Bond { image: [0; 3], ..*bond }).collect();
        structure.with_bonds(bonds)
    }

    /// Moves atoms by whole cells to those that they are bonded to.
    fn join(&self, frame: &mut Frame, cell: &Cell) {
        let (to_fractional, from_fractional) = (cell.fractional_from_cartesian(), cell.cartesian_from_fractional());
        for &Branch { from, to, vector } in &self.branches {
            let way = frame.positions.get(to as usize) - frame.positions.get(from as usize);
            let cells = (vector - to_fractional * way).round();
            if cells != DVec3::ZERO && cells.is_finite() {
                frame.positions.shift(to as usize, from_fractional * cells);
            }
        }
    }

    /// The structure with the images that its bonds go to in its frame.
    fn with_images(&self, structure: Structure, cell: &Cell) -> Structure {
        let at = fractional_positions(&structure, cell);
        let image = |(index, bond): (usize, &Bond)| {
            let vector = self.vectors.get(index).copied().unwrap_or(DVec3::ZERO);
            let cells = (vector - (at[bond.b as usize] - at[bond.a as usize])).round();
            // A number of cells beyond a byte is no bond that could be drawn.
            Bond { image: cells.to_array().map(|count| count as i8), ..*bond }
        };
        let bonds = self.structure.bonds().iter().enumerate().map(image).collect();
        structure.with_bonds(bonds)
    }

    fn with_hydrogen_bonds(&self, structure: Structure) -> Structure {
        if self.options.bonds.hydrogen_bonds { bonds::with_hydrogen_bonds(structure) } else { structure }
    }
}

/// Steps that reach every atom of each molecule from its first.
fn branches(structure: &Structure, neighbours: &Neighbours, vectors: &[DVec3]) -> Vec<Branch> {
    let count = structure.atom_count();
    let mut is_reached = vec![false; count];
    let mut branches = Vec::new();
    for root in 0..count {
        if std::mem::replace(&mut is_reached[root], true) {
            continue;
        }
        let mut at = branches.len();
        let mut from = root as u32;
        loop {
            for (to, _, bond) in neighbours.of(from) {
                if !std::mem::replace(&mut is_reached[to as usize], true) {
                    let vector = vectors.get(bond as usize).copied().unwrap_or(DVec3::ZERO);
                    let is_forward = structure.bonds()[bond as usize].a == from;
                    branches.push(Branch { from, to, vector: if is_forward { vector } else { -vector } });
                }
            }
            let Some(next) = branches.get(at) else { break };
            from = next.to;
            at += 1;
        }
    }
    branches
}

#[cfg(test)]
#[path = "fixed_tests.rs"]
mod tests;
