//! The table of structure formats that can be written, and what each of them cannot hold.
//!
//! A format is one module with a `FORMAT`, and one line in [`FORMATS`]. It lists the [`Part`]s it holds; what a
//! structure has beyond them is named by [`StructureFormat::losses`].

use crate::element::Element;
use crate::error::{Error, Result};
use crate::structure::{Bond, BondKind, Structure, atom_flags};
use std::io::{self, Write};
use std::path::Path;

/// Every structure format that can be written.
pub static FORMATS: &[&StructureFormat] = &[
    &super::json::FORMAT,
    &super::cjson::FORMAT,
    &super::mmcif::FORMAT,
    &super::mol2::FORMAT,
    &super::pdb::FORMAT,
    &super::sdf::FORMAT,
    &super::sdf::FORMAT_V3000,
    &super::xyz::FORMAT,
    &super::xyz::FORMAT_EXTENDED,
];

/// A structure format that can be written.
#[derive(Debug)]
pub struct StructureFormat {
    /// The name `--to` takes.
    pub name: &'static str,
    /// The file name extensions, without the dot.
    pub extensions: &'static [&'static str],
    /// What it is, in a few words.
    pub description: &'static str,
    /// Whether all records and frames are written; else the first record, of which all frames are written if it
    /// [`holds`](StructureFormat::holds) [`Part::Frames`].
    pub all_frames: bool,
    /// What it holds beside elements and positions.
    pub holds: &'static [Part],
    /// What of a structure goes beyond the widths and ranges that the format has for what it holds, one phrase each.
    pub limits: fn(&Structure) -> Vec<&'static str>,
    /// Writes the records, or the first of them.
    pub write: fn(&[Structure], &mut dyn Write) -> io::Result<()>,
}

/// Something a structure may have beside elements and positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    /// Title.
    Title,
    /// Titles of frames other than the structure's.
    FrameTitles,
    /// Further frames.
    Frames,
    /// Covalent bonds inside what is listed, with their orders. An aromatic one has a Kekulé order, or a mark, or both:
    /// a format that holds bonds has a place for one of them, and each follows from the other.
    Bonds,
    /// What is a coordination bond.
    CoordinationBonds,
    /// What is a dative bond.
    DativeBonds,
    /// Hydrogen bonds; a format without a place for them leaves them out.
    HydrogenBonds,
    /// Bonds to periodic images; a format without a place for them leaves them out.
    PeriodicBonds,
    /// Stereo marks on bonds.
    BondStereo,
    /// Unit cell.
    Cell,
    /// Unit cells that change from frame to frame.
    FrameCells,
    /// The symbol of the space group.
    SpaceGroup,
    /// Symmetry operations.
    SymmetryOperations,
    /// Biological assemblies.
    Assemblies,
    /// Bonds inside residues by the names of their atoms.
    Components,
    /// Atom names.
    AtomNames,
    /// Serial numbers other than 1, 2, 3, ….
    Serials,
    /// Residues and chains.
    Residues,
    /// What is a hetero atom.
    AtomKinds,
    /// What is no atom at all: lone pairs, dummies, extra points.
    Particles,
    /// Alternate locations.
    Altlocs,
    /// Occupancies other than 1.
    Occupancies,
    /// Temperature factors.
    BFactors,
    /// Formal charges.
    FormalCharges,
    /// Partial charges.
    PartialCharges,
    /// Deuterium and tritium.
    HydrogenIsotopes,
    /// Any other isotopes.
    Isotopes,
    /// Radicals.
    Radicals,
    /// Helices and strands.
    Secondary,
    /// Vectors on atoms.
    Vectors,
    /// Data fields.
    Properties,
}

impl Part {
    /// All of them.
    pub const ALL: [Part; 31] = [
        Part::Title,
        Part::FrameTitles,
        Part::Frames,
        Part::Bonds,
        Part::CoordinationBonds,
        Part::DativeBonds,
        Part::HydrogenBonds,
        Part::PeriodicBonds,
        Part::BondStereo,
        Part::Cell,
        Part::FrameCells,
        Part::SpaceGroup,
        Part::SymmetryOperations,
        Part::Assemblies,
        Part::Components,
        Part::AtomNames,
        Part::Serials,
        Part::Residues,
        Part::AtomKinds,
        Part::Particles,
        Part::Altlocs,
        Part::Occupancies,
        Part::BFactors,
        Part::FormalCharges,
        Part::PartialCharges,
        Part::HydrogenIsotopes,
        Part::Isotopes,
        Part::Radicals,
        Part::Secondary,
        Part::Vectors,
        Part::Properties,
    ];

    /// Its name in a message, plural.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Part::Title => "titles",
            Part::FrameTitles => "titles of frames",
            Part::Frames => "further frames",
            Part::Bonds => "bonds",
            Part::CoordinationBonds => "marks of coordination bonds",
            Part::DativeBonds => "marks of dative bonds",
            Part::HydrogenBonds => "hydrogen bonds",
            Part::PeriodicBonds => "bonds to periodic images",
            Part::BondStereo => "stereo marks",
            Part::Cell => "unit cells",
            Part::FrameCells => "cells of further frames",
            Part::SpaceGroup => "space groups",
            Part::SymmetryOperations => "symmetry operations",
            Part::Assemblies => "biological assemblies",
            Part::Components => "lists of residues' bonds",
            Part::AtomNames => "atom names",
            Part::Serials => "serial numbers",
            Part::Residues => "residues and chains",
            Part::AtomKinds => "marks of hetero atoms",
            Part::Particles => "marks of what is no atom",
            Part::Altlocs => "alternate locations",
            Part::Occupancies => "occupancies",
            Part::BFactors => "temperature factors",
            Part::FormalCharges => "formal charges",
            Part::PartialCharges => "partial charges",
            Part::HydrogenIsotopes | Part::Isotopes => "isotopes",
            Part::Radicals => "radicals",
            Part::Secondary => "helices and strands",
            Part::Vectors => "vectors on atoms",
            Part::Properties => "data fields",
        }
    }

    /// Whether a structure has it.
    #[must_use]
    pub fn is_in(self, structure: &Structure) -> bool {
        let any = |test: &dyn Fn(usize) -> bool| (0..structure.atom_count()).any(test);
        let has_kind = |kind| structure.bonds().iter().any(|bond| bond.kind == kind && !bond.is_periodic());
        match self {
            Part::Title => !title(structure).is_empty(),
            Part::FrameTitles => {
                structure.frames().iter().any(|frame| !frame.title.is_empty() && frame.title != title(structure))
            }
            Part::Frames => structure.frames().len() > 1,
            Part::Bonds => structure.bonds().iter().any(|bond| !bond.is_periodic() && bond.kind != BondKind::Hydrogen),
            Part::CoordinationBonds => has_kind(BondKind::Coordination),
            Part::DativeBonds => has_kind(BondKind::Dative),
            Part::HydrogenBonds => has_kind(BondKind::Hydrogen),
            Part::PeriodicBonds => structure.bonds().iter().any(Bond::is_periodic),
            Part::BondStereo => !structure.bond_stereo().is_empty(),
            Part::Cell => structure.frames().iter().any(|frame| frame.cell.is_some()),
            Part::FrameCells => structure.frames().iter().any(|frame| frame.cell.as_ref() != structure.cell()),
            Part::SpaceGroup => structure.symmetry().is_some_and(|symmetry| !symmetry.space_group.is_empty()),
            Part::SymmetryOperations => structure.symmetry().is_some_and(|symmetry| !symmetry.operations.is_empty()),
            Part::Assemblies => !structure.assemblies().is_empty(),
            Part::Components => !structure.components().is_empty(),
            // The name of what has no element says of which sort it is, in place of a symbol.
            Part::AtomNames => {
                any(&|i| !structure.atom_name(i).is_empty() && structure.elements()[i] != Element::DUMMY)
            }
            Part::Serials => any(&|i| usize::try_from(structure.serial(i)) != Ok(i + 1)),
            Part::Residues => !structure.residues().is_empty(),
            Part::AtomKinds => any(&|i| structure.flags(i) & atom_flags::HETERO != 0),
            Part::Particles => any(&|i| structure.flags(i) & atom_flags::PARTICLE != 0),
            Part::Altlocs => structure.has_altlocs(),
            Part::Occupancies => any(&|i| structure.occupancy(i) != 1.0),
            Part::BFactors => any(&|i| structure.b_factor(i) != 0.0),
            Part::FormalCharges => any(&|i| structure.formal_charge(i) != 0),
            Part::PartialCharges => any(&|i| structure.partial_charge(i).is_some()),
            Part::HydrogenIsotopes => any(&|i| is_heavy_hydrogen(structure, i)),
            Part::Isotopes => any(&|i| structure.isotope(i) != 0 && !is_heavy_hydrogen(structure, i)),
            Part::Radicals => any(&|i| structure.radical(i) != 0),
            Part::Secondary => !structure.secondary().is_empty(),
            Part::Vectors => structure.frames().iter().any(|frame| !frame.vectors.is_empty()),
            Part::Properties => !structure.properties().is_empty(),
        }
    }
}

/// The title of the structure, or else of its first frame.
pub(super) fn title(structure: &Structure) -> &str {
    match structure.title() {
        "" => structure.frames().first().map_or("", |frame| &frame.title),
        title => title,
    }
}

/// For formats that hold what they hold whatever it is.
#[must_use]
pub fn no_limits(_structure: &Structure) -> Vec<&'static str> {
    Vec::new()
}

/// Whether the atom is deuterium or tritium.
pub(super) fn is_heavy_hydrogen(structure: &Structure, atom: usize) -> bool {
    matches!(structure.isotope(atom), 2 | 3) && structure.elements()[atom] == Element::H
}

/// The names of all formats, for people.
fn names() -> String {
    let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
    names.join(", ")
}

impl StructureFormat {
    /// The format of a name or extension, in any case.
    ///
    /// # Errors
    /// [`Error::Unsupported`] naming those there are.
    pub fn from_name(name: &str) -> Result<&'static StructureFormat> {
        let lower = name.to_ascii_lowercase();
        let found = FORMATS.iter().find(|format| format.name == lower || format.extensions.contains(&lower.as_str()));
        found.copied().ok_or_else(|| {
            Error::Unsupported(format!("cannot write structures as {name}; the formats are {}", names()))
        })
    }

    /// The format that the extension of a file name asks for.
    ///
    /// # Errors
    /// [`Error::Unsupported`] naming those there are.
    pub fn from_path(path: &Path) -> Result<&'static StructureFormat> {
        match path.extension() {
            Some(extension) => Self::from_name(&extension.to_string_lossy()),
            None => {
                let message = format!(
                    "{}: the name has no ending that says the format; give it one, or --to: for structures {}",
                    path.display(),
                    names()
                );
                Err(Error::Unsupported(message))
            }
        }
    }

    /// Whether bonds are written, so that they have to be found first.
    #[must_use]
    pub fn holds_bonds(&self) -> bool {
        self.holds.contains(&Part::Bonds)
    }

    /// What of these records does not get into the file, one sentence each; empty if nothing is lost.
    #[must_use]
    pub fn losses(&self, records: &[Structure]) -> Vec<String> {
        let mut losses = Vec::new();
        let mut written = records;
        if !self.all_frames && !records.is_empty() {
            let count = records.len();
            if count > 1 {
                losses.push(format!("only the first of {count} records is written; --record N chooses another"));
            }
            let frames = records[0].frames().len();
            if frames > 1 && !self.holds.contains(&Part::Frames) {
                losses.push(format!("only the first of {frames} frames is written; --frame N chooses another"));
            }
            written = &records[..1];
        }
        // Of frames that are not written nothing is to be said but that.
        let one_frame = !self.all_frames && !self.holds.contains(&Part::Frames);
        let unsaid =
            |part: &Part| *part == Part::Frames || (one_frame && matches!(part, Part::FrameTitles | Part::FrameCells));
        // A file that has one title has no place for those of further records.
        let other_titles = written.iter().any(|record| title(record) != title(&written[0]));
        let lost = |part: &Part| {
            let found = written.iter().any(|record| part.is_in(record)) || *part == Part::FrameTitles && other_titles;
            found && !self.holds.contains(part) && !unsaid(part)
        };
        let mut names: Vec<&str> = Part::ALL.iter().filter(|part| lost(part)).map(|part| part.name()).collect();
        names.dedup();
        if !names.is_empty() {
            losses.push(format!("{} has no place for these, left out: {}", self.name, names.join(", ")));
        }
        let mut phrases: Vec<&str> = written.iter().flat_map(|record| (self.limits)(record)).collect();
        phrases.sort_unstable();
        phrases.dedup();
        if !phrases.is_empty() {
            losses.push(format!("{} has too little room for these: {}", self.name, phrases.join("; ")));
        }
        losses
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, BondOrder, BondSource, Diagnostics, StructureBuilder};

    fn charged() -> Structure {
        let mut builder = StructureBuilder::new();
        builder.push_atom(&AtomRecord { element: Element::N, formal_charge: 1, isotope: 15, ..AtomRecord::default() });
        builder.push_atom(&AtomRecord { element: Element::H, isotope: 2, ..AtomRecord::default() });
        builder.push_bond(Bond::new(0, 1, BondOrder::Single, BondSource::File));
        builder.push_property("IC50", "3 nM");
        assert!(builder.push_frame(&[glam::DVec3::ZERO, glam::DVec3::X], None, ""));
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn what_a_format_cannot_hold_is_named() {
        let records = [charged(), charged()];
        let xyz = StructureFormat::from_name("xyz").unwrap().losses(&records);
        assert_eq!(xyz, ["xyz has no place for these, left out: bonds, formal charges, isotopes, data fields"]);
        let json = StructureFormat::from_name("JSON").unwrap().losses(&records);
        assert_eq!(json.len(), 3);
        assert!(json[0].contains("first of 2 records") && json[1].contains("first of 2 frames"));
        assert!(json[2].ends_with("left out: data fields"), "{json:?}");
    }

    #[test]
    fn nothing_lost_says_nothing() {
        let mut builder = StructureBuilder::new();
        builder.set_decimals(3);
        builder.push_atom(&AtomRecord { element: Element::H, ..AtomRecord::default() });
        let record = builder.build(&mut Diagnostics::default());
        for format in FORMATS {
            assert!(format.losses(std::slice::from_ref(&record)).is_empty(), "{}", format.name);
        }
    }

    #[test]
    fn unknown_names_are_errors_that_list_the_known_ones() {
        let error = StructureFormat::from_path(Path::new("a.docx")).unwrap_err().to_string();
        assert!(error.contains("docx") && error.contains("json, cjson"), "{error}");
        assert!(StructureFormat::from_path(Path::new("a")).unwrap_err().to_string().contains("--to"));
    }
}
