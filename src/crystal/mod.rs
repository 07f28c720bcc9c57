//! Crystals: which copies of a periodic structure's atoms are drawn. Nothing here changes what was read.
//!
//! A file lists an asymmetric unit, or the atoms of one cell; what a chemist wants to see are whole molecules, or a cell
//! with all that is in it. [`draw`] takes the listed atoms, applies the symmetry, finds the bonds of the whole
//! periodic content, walks them (`molecules`) and places copies:
//!
//! - a molecule that ends is drawn whole, wherever the cell's faces cut it;
//! - a network that never ends (quartz, rock salt, a metal, a framework) is drawn as the content of the cell, its
//!   atoms on a face on all equivalent faces, and its bonds to what is outside cut at the faces.
//!
//! Of a molecule with many frames the bonds may be found once ([`Fixed`]).
//!
//! An assembly ([`CrystalOptions::assembly`]) is not copied: [`Drawn::copies`] says where its atoms stand. So it is with the cells of a large
//! supercell ([`INSTANCES_FROM`]) if no bond leaves the content of a cell. Where bonds cross the faces (networks, and whatever hydrogen bonds
//! join, if they are asked for) atoms are copied: a stick across a face has its ends in two copies. The content of one cell is copied as well: which
//! images of an atom on a special position are one, and which images of molecules are bonded, is known of the atoms alone.
//!
//! Limits: the order of atoms in what is drawn is the file's, copy by copy.

mod copies;
mod fixed;
mod lattice;
mod molecules;

pub use copies::{AssemblyId, Copies};
pub use fixed::{BondsPerFrame, Fixed};

use crate::bonds::{self, BondOptions};
use crate::error::{Error, Result};
use crate::stop::Stop;
use crate::structure::{Bond, BondKind, Cell, Structure, apply_symmetry};
use glam::{DVec3, IVec3};
use molecules::{Molecule, Neighbours};
use std::collections::{HashMap, HashSet};

/// What of a crystal is drawn; the names are those of `--cell`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum CellChoice {
    /// The atoms as the file lists them.
    Asym,
    /// The molecules that the listed atoms belong to, whole; of a network, what is in the cell.
    #[default]
    Molecule,
    /// All molecules whose middle is in the cell, whole; of a network, what is in the cell.
    Full,
}

impl CellChoice {
    /// All of them.
    pub const ALL: [CellChoice; 3] = [CellChoice::Asym, CellChoice::Molecule, CellChoice::Full];

    /// `asym`, `molecule` or `full`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            CellChoice::Asym => "asym",
            CellChoice::Molecule => "molecule",
            CellChoice::Full => "full",
        }
    }

    /// The choice of a name; `None` for any other text.
    #[must_use]
    pub fn from_name(name: &str) -> Option<CellChoice> {
        Self::ALL.into_iter().find(|choice| choice.name() == name)
    }
}

/// How a crystal is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrystalOptions {
    /// What is drawn. Default: [`CellChoice::Molecule`].
    pub cell: CellChoice,
    /// Cells along **a**, **b**, **c**. More than one of them turn [`CellChoice::Molecule`] into [`CellChoice::Full`]. Default: 1 × 1 × 1.
    pub supercell: [u32; 3],
    /// How bonds are found.
    pub bonds: BondOptions,
    /// In which of several frames they are found. Default: [`BondsPerFrame::Auto`].
    pub bonds_per_frame: BondsPerFrame,
    /// The assembly that is drawn of structures that have it, in place of what `cell` and `supercell` say. Default: none.
    pub assembly: Option<AssemblyId>,
    /// Most atoms drawn. Default: 50,000,000.
    pub most_atoms: usize,
}

impl Default for CrystalOptions {
    fn default() -> Self {
        CrystalOptions {
            cell: CellChoice::default(),
            supercell: [1; 3],
            bonds: BondOptions::default(),
            bonds_per_frame: BondsPerFrame::default(),
            assembly: None,
            most_atoms: 50_000_000,
        }
    }
}

/// A bond to an atom that is not drawn, as far as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stub {
    /// The bond: `a` is the atom it starts from, `b` a copy of the one it goes to, which stands elsewhere.
    pub bond: Bond,
    /// From `a` to where the partner would be, ångström.
    pub vector: DVec3,
    /// The part of the vector that is drawn, 0 to 1.
    pub part: f64,
}

/// What is drawn of a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// The atoms drawn, with the bonds among them; one frame.
    pub structure: Structure,
    /// Bonds cut at the faces of the cell.
    pub stubs: Vec<Stub>,
    /// The cell, or the box of all cells drawn, with a corner at the origin; `None` if there is none.
    pub cell: Option<Cell>,
    /// For every atom whether it is one of a lattice that coordination alone holds together, so that these bonds are
    /// drawn solid; empty if there are none.
    pub lattice: Vec<bool>,
    /// For every atom which one of the file it is, from 0; empty if all are as listed.
    pub listed: Vec<u32>,
    /// Whether the cell belongs in the picture: a network is drawn, or whole cells are asked for.
    pub is_cell_content: bool,
    /// Where the atoms stand, if that is not once where the structure has them.
    pub copies: Option<Copies>,
    /// Frames of one molecule that differ in their positions and cells alone have the same number, and nothing else has it; 0 for what is
    /// no such frame.
    pub kind: u64,
}

impl Drawn {
    /// A structure as it is.
    #[must_use]
    pub fn as_listed(structure: Structure) -> Drawn {
        let lattice = lattice::atoms(&structure);
        Drawn { lattice, ..Drawn::plain(structure) }
    }

    /// The same without looking for a lattice.
    fn plain(structure: Structure) -> Drawn {
        let cell = structure.cell().copied();
        let (stubs, lattice, listed) = (Vec::new(), Vec::new(), Vec::new());
        Drawn { structure, stubs, cell, lattice, listed, is_cell_content: false, copies: None, kind: 0 }
    }

    /// The copy and the atom in it of an atom of the picture: those of further copies are counted on behind those of the first.
    #[must_use]
    pub fn own_atom(&self, atom: u32) -> Option<(u32, usize)> {
        let count = u32::try_from(self.structure.atom_count()).ok()?;
        let copies = self.copies.as_ref().map_or(1, |copies| copies.operations.len());
        let copy = atom.checked_div(count)?;
        ((copy as usize) < copies).then_some((copy, (atom % count) as usize))
    }

    /// Where an atom of the picture is, in the coordinates of its file.
    #[must_use]
    pub fn position(&self, atom: u32) -> Option<DVec3> {
        let (copy, own) = self.own_atom(atom)?;
        let point = self.structure.positions().get(own);
        let copies = self.copies.as_ref();
        Some(copies.map_or(point, |copies| copies.operations[copy as usize].transform_point3(point)))
    }

    /// A box around all atoms in the picture, in the coordinates of the file; the low corner is above the high one if there are none.
    #[must_use]
    pub fn extent(&self) -> [DVec3; 2] {
        let positions = self.structure.positions();
        let ends = (0..positions.len())
            .map(|atom| positions.get(atom))
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)]);
        match &self.copies {
            Some(copies) if !positions.is_empty() => copies.extent(ends),
            _ => ends,
        }
    }

    /// Atoms and bonds in the picture, all copies counted.
    #[must_use]
    pub fn counts(&self) -> [usize; 2] {
        let (atoms, bonds) = (self.structure.atom_count(), self.structure.bonds());
        match &self.copies {
            Some(copies) => [copies.atom_count(atoms), copies.bond_count(bonds)],
            None => [atoms, bonds.len()],
        }
    }
}

/// How near a face an atom counts as on it, ångström: coordinates with three decimals in a cell of 30 Å are good to
/// 0.03 Å, and no two atoms are that close.
const ON_FACE: f64 = 0.1;

/// Atoms from which on the cells of a supercell are not copied, if they can be drawn as they are. Chosen: copies of fewer cost nothing that
/// one would notice, and each atom has a number of its own in the file's order, cell by cell.
pub const INSTANCES_FROM: usize = 100_000;

/// Finds the bonds of the first frame and what of the structure is drawn.
///
/// # Errors
/// [`Error::Limit`] if that would be more than [`CrystalOptions::most_atoms`].
pub fn draw(structure: Structure, options: &CrystalOptions) -> Result<Drawn> {
    draw_unless(structure, options, &Stop::never())
}

/// The same unless it is given up.
///
/// # Errors
/// As [`draw`], and [`Error::Stopped`].
pub fn draw_unless(structure: Structure, options: &CrystalOptions, stop: &Stop) -> Result<Drawn> {
    if let Some(copies) = assembly(&structure, options)? {
        let structure = without_images(bonds::assign_unless(structure, &options.bonds, stop)?);
        return Ok(Drawn { copies: Some(copies), ..Drawn::as_listed(structure) });
    }
    let (choice, _) = options.choice();
    let listed = structure.atom_count();
    let (structure, original) = match choice {
        CellChoice::Asym => (structure, None),
        // A protein is shown as its entry lists it, unless the crystal is asked for.
        CellChoice::Molecule if !structure.residues().is_empty() => (structure, None),
        CellChoice::Molecule | CellChoice::Full => apply_symmetry(structure, options.most_atoms)?,
    };
    let structure = bonds::assign_unless(structure, &options.bonds, stop)?;
    place(structure, original, listed, options)
}

/// The copies of the assembly that is asked for, if the structure has it.
fn assembly(structure: &Structure, options: &CrystalOptions) -> Result<Option<Copies>> {
    let Some(id) = options.assembly else { return Ok(None) };
    let Some(assembly) = structure.assembly(id.as_str()) else { return Ok(None) };
    let copies = Copies::of_assembly(assembly, structure.atom_count());
    let atoms = copies.atom_count(structure.atom_count());
    if atoms > options.most_atoms {
        let message = format!("assembly {id} has {atoms} atoms, more than {}; draw a smaller one", options.most_atoms);
        return Err(Error::limit(None, message));
    }
    Ok(Some(copies))
}

impl CrystalOptions {
    /// What is drawn, and how many cells.
    fn choice(&self) -> (CellChoice, [u32; 3]) {
        let supercell = self.supercell.map(|count| count.max(1));
        let is_several = supercell != [1; 3] && self.cell == CellChoice::Molecule;
        (if is_several { CellChoice::Full } else { self.cell }, supercell)
    }
}

/// What is drawn of a structure with its bonds, of whose atoms the first `listed` ones are those of the file, and `original` says which one of
/// these each is an image of.
fn place(structure: Structure, original: Option<Vec<u32>>, listed: usize, options: &CrystalOptions) -> Result<Drawn> {
    let (choice, supercell) = options.choice();
    let several = supercell != [1; 3];
    let is_cut = structure.bonds().iter().any(Bond::is_periodic);
    let Some(cell) = structure.lattice(0).copied() else {
        let listed = original.unwrap_or_default();
        return Ok(Drawn { listed, ..Drawn::as_listed(without_images(structure)) });
    };
    let is_as_listed = !is_cut && original.is_none() && choice != CellChoice::Full && !several;
    if is_as_listed {
        return Ok(Drawn::as_listed(structure));
    }
    let neighbours = Neighbours::new(&structure);
    let fractional = fractional_positions(&structure, &cell);
    let molecules = match choice {
        CellChoice::Asym => Vec::new(),
        _ => molecules::find(&neighbours, structure.atom_count()),
    };
    let is_network = molecules.iter().any(|molecule| molecule.is_endless);
    // The atoms of so many cells.
    let plan_of = |supercell: [u32; 3]| -> Result<Plan> {
        let mut plan = Plan::new(cell, supercell, options.most_atoms);
        if choice == CellChoice::Asym {
            plan.add((0..listed as u32).map(|atom| (atom, IVec3::ZERO)), &fractional, Edge::Open)?;
        }
        let mut seen: HashSet<Vec<u32>> = HashSet::new();
        for molecule in &molecules {
            if let (CellChoice::Molecule, false, Some(original)) = (choice, molecule.is_endless, &original) {
                // Of the images of a molecule the one with a listed atom is drawn; of two such, that are images of one
                // another since their atoms are listed here and there, the first.
                let mut kind: Vec<u32> = molecule.atoms.iter().map(|&(atom, _)| original[atom as usize]).collect();
                kind.sort_unstable();
                if molecule.atoms[0].0 as usize >= listed || !seen.insert(kind) {
                    continue;
                }
            }
            let (copies, edge) = copies(molecule, &fractional, &cell, choice);
            plan.add(copies.into_iter(), &fractional, edge)?;
        }
        plan.sort();
        Ok(plan)
    };
    let mut drawn = match several {
        true => match plan_of([1; 3])?.into_instances(supercell, &neighbours)? {
            Some((unit, copies)) => {
                let unit = unit.build(&structure, &neighbours, &fractional);
                Drawn { copies: Some(copies), cell: supercell_of(&cell, supercell), ..unit }
            }
            None => plan_of(supercell)?.build(&structure, &neighbours, &fractional),
        },
        false => plan_of(supercell)?.build(&structure, &neighbours, &fractional),
    };
    if let Some(original) = original {
        drawn.listed.iter_mut().for_each(|atom| *atom = original[*atom as usize]);
    }
    drawn.is_cell_content = is_network || several || choice == CellChoice::Full;
    Ok(drawn)
}

/// A molecule's atoms where they are drawn, and what happens at the faces.
fn copies(molecule: &Molecule, fractional: &[DVec3], cell: &Cell, choice: CellChoice) -> (Vec<(u32, IVec3)>, Edge) {
    if molecule.is_endless {
        let margin = face_margin(cell);
        let wrapped = |&(atom, _): &(u32, IVec3)| (atom, -(fractional[atom as usize] + margin).floor().as_ivec3());
        return (molecule.atoms.iter().map(wrapped).collect(), Edge::Repeated);
    }
    let mut atoms = molecule.atoms.clone();
    if choice == CellChoice::Full {
        let place = |&(atom, shift): &(u32, IVec3)| fractional[atom as usize] + shift.as_dvec3();
        let middle = atoms.iter().map(place).sum::<DVec3>() / atoms.len() as f64;
        let home = (middle + 1e-6).floor().as_ivec3();
        atoms.iter_mut().for_each(|(_, shift)| *shift -= home);
    }
    (atoms, Edge::Open)
}

/// [`ON_FACE`] in fractional coordinates.
fn face_margin(cell: &Cell) -> DVec3 {
    ON_FACE / cell.face_distances()
}

/// Whether atoms on a face are drawn on the opposite one, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Edge {
    Repeated,
    Open,
}

/// The copies to be drawn.
struct Plan {
    cell: Cell,
    supercell: [u32; 3],
    most_atoms: usize,
    /// Atom, and how many cells its copy is away from where the file has it.
    atoms: Vec<(u32, IVec3)>,
}

impl Plan {
    fn new(cell: Cell, supercell: [u32; 3], most_atoms: usize) -> Plan {
        Plan { cell, supercell, most_atoms, atoms: Vec::new() }
    }

    /// Brings the atoms in order, each once.
    fn sort(&mut self) {
        self.atoms.sort_unstable_by_key(|&(atom, shift)| (shift != IVec3::ZERO, shift.to_array(), atom));
        self.atoms.dedup();
    }

    /// This cell, and where it stands in a supercell, if that is so large that it should not be copied and no bond leaves it.
    fn into_instances(self, supercell: [u32; 3], neighbours: &Neighbours) -> Result<Option<(Plan, Copies)>> {
        let cells = supercell.iter().fold(1usize, |all, &count| all.saturating_mul(count as usize));
        if self.atoms.len().saturating_mul(cells) < INSTANCES_FROM {
            return Ok(None);
        }
        let all: HashSet<(u32, IVec3)> = self.atoms.iter().copied().collect();
        let stays = |&(atom, shift): &(u32, IVec3)| {
            neighbours.of(atom).all(|(other, step, _)| all.contains(&(other, shift + step)))
        };
        if !self.atoms.iter().all(stays) {
            return Ok(None);
        }
        check_room(self.atoms.len().saturating_mul(cells), supercell, self.most_atoms)?;
        let copies = Copies::of_cells(cells_of(supercell), self.cell.vectors());
        Ok(Some((self, copies)))
    }

    /// Adds these copies in every cell of the supercell.
    fn add(
        &mut self,
        copies: impl ExactSizeIterator<Item = (u32, IVec3)>,
        fractional: &[DVec3],
        edge: Edge,
    ) -> Result<()> {
        let cells = self.supercell.iter().fold(1usize, |all, &count| all.saturating_mul(count as usize));
        let wanted = self.atoms.len().saturating_add(copies.len().saturating_mul(cells));
        check_room(wanted, self.supercell, self.most_atoms)?;
        let margin = face_margin(&self.cell);
        let ends = DVec3::from_array(self.supercell.map(f64::from));
        for (atom, shift) in copies {
            for cell in cells_of(self.supercell) {
                let shift = shift + cell;
                self.atoms.push((atom, shift));
                if edge == Edge::Repeated {
                    let at = fractional[atom as usize] + shift.as_dvec3();
                    let on_face = at.abs().cmple(margin);
                    // The opposite faces of those it is on, and the edges and corners where they meet.
                    for which in 1..8u32 {
                        let step = |axis: usize| which >> axis & 1 == 1;
                        if (0..3).all(|axis| !step(axis) || on_face.test(axis)) {
                            let of = |axis: usize| if step(axis) { ends[axis] as i32 } else { 0 };
                            self.atoms.push((atom, shift + IVec3::new(of(0), of(1), of(2))));
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The structure of the copies, the bonds among them, and those that are cut.
    fn build(self, structure: &Structure, neighbours: &Neighbours, fractional: &[DVec3]) -> Drawn {
        let from_fractional = self.cell.cartesian_from_fractional();
        let [na, nb, nc] = self.supercell.map(f64::from);
        let whole = supercell_of(&self.cell, self.supercell);
        let sources: Vec<(u32, DVec3)> = (self.atoms.iter())
            .map(|&(atom, shift)| (atom, structure.positions().get(atom as usize) + from_fractional * shift.as_dvec3()))
            .collect();
        let index_of: HashMap<(u32, IVec3), u32> =
            self.atoms.iter().enumerate().map(|(index, &place)| (place, index as u32)).collect();
        let mut bonds = Vec::new();
        let mut stubs = Vec::new();
        for (from, &(atom, shift)) in self.atoms.iter().enumerate() {
            for (other, step, number) in neighbours.of(atom) {
                let bond = structure.bonds()[number as usize];
                let from = from as u32;
                if let Some(&to) = index_of.get(&(other, shift + step)) {
                    // Every bond is met from both of its ends.
                    if from < to {
                        bonds.push(Bond { a: from, b: to, image: [0; 3], ..bond });
                    }
                    continue;
                }
                let Some(&copy) = (index_of.get(&(other, shift))).or_else(|| index_of.get(&(other, IVec3::ZERO)))
                else {
                    continue;
                };
                let start = fractional[atom as usize] + shift.as_dvec3();
                let end = fractional[other as usize] + (shift + step).as_dvec3();
                let part = part_inside(start, end, DVec3::new(na, nb, nc), face_margin(&self.cell));
                if part > 0.0 {
                    let bond = Bond { a: from, b: copy, image: [0; 3], ..bond };
                    stubs.push(Stub { bond, vector: from_fractional * (end - start), part });
                }
            }
        }
        let mut lattice = lattice::atoms(structure);
        if !lattice.is_empty() {
            lattice = sources.iter().map(|&(atom, _)| lattice[atom as usize]).collect();
        }
        let listed = sources.iter().map(|&(atom, _)| atom).collect();
        let structure = structure.gather(&sources, whole).with_bonds(bonds);
        Drawn { structure, stubs, cell: whole, lattice, listed, is_cell_content: false, copies: None, kind: 0 }
    }
}

/// The box of all cells.
fn supercell_of(cell: &Cell, supercell: [u32; 3]) -> Option<Cell> {
    let [a, b, c] = cell.vectors();
    let [na, nb, nc] = supercell.map(f64::from);
    Cell::from_vectors(a * na, b * nb, c * nc)
}

fn check_room(wanted: usize, [a, b, c]: [u32; 3], most_atoms: usize) -> Result<()> {
    if wanted <= most_atoms {
        return Ok(());
    }
    let message = format!("{a}x{b}x{c} cells would be more than {most_atoms} atoms; ask for fewer with --supercell");
    Err(Error::limit(None, message))
}

/// The part of the way from a point to another up to where it leaves the box from 0 to `size`; half of the way from a
/// point outside, and nothing of one that leaves at once.
fn part_inside(start: DVec3, end: DVec3, size: DVec3, margin: DVec3) -> f64 {
    if start.cmplt(-margin).any() || start.cmpgt(size + margin).any() {
        return 0.5;
    }
    let way = end - start;
    let leaves = |axis: usize| match way[axis] {
        along if along > 0.0 => (size[axis] - start[axis]) / along,
        along if along < 0.0 => -start[axis] / along,
        _ => f64::INFINITY,
    };
    let part = leaves(0).min(leaves(1)).min(leaves(2));
    // An end this near the face would be a disc on the ball.
    if part * way.length() <= margin.max_element() { 0.0 } else { part.min(1.0) }
}

/// All cells of a supercell, from the origin.
fn cells_of([a, b, c]: [u32; 3]) -> impl Iterator<Item = IVec3> {
    let cell = move |i: u32, j: u32, k: u32| IVec3::new(i as i32, j as i32, k as i32);
    (0..a).flat_map(move |i| (0..b).flat_map(move |j| (0..c).map(move |k| cell(i, j, k))))
}

fn fractional_positions(structure: &Structure, cell: &Cell) -> Vec<DVec3> {
    let to_fractional = cell.fractional_from_cartesian();
    (0..structure.atom_count()).map(|atom| to_fractional * structure.positions().get(atom)).collect()
}

/// The structure without bonds to images, which have no place where nothing repeats.
fn without_images(structure: Structure) -> Structure {
    if !structure.bonds().iter().any(Bond::is_periodic) {
        return structure;
    }
    let bonds = structure.bonds().iter().copied().filter(|bond| !bond.is_periodic()).collect();
    structure.with_bonds(bonds)
}

/// Whether a bond holds a molecule together.
fn holds(bond: &Bond) -> bool {
    bond.kind != BondKind::Hydrogen
}

#[cfg(test)]
mod tests;
