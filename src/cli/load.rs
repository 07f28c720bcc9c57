//! From a path to structures with bonds: reading, picking record and frame, finding bonds.

use super::args::{BondArgs, CellArg, CrystalArgs, Named, SelectArgs};
use super::assembly;
use super::report::Report;
use super::values::RecordChoice;
use crate::bonds::{self, BondMode, BondOptions};
use crate::crystal::{self, BondsPerFrame, CellChoice, CrystalOptions, Drawn, Fixed};
use crate::error::{Error, Result};
use crate::import::trajectory::{self, Input};
use crate::import::{Document, Format, ImportOptions};
use crate::session::{Session, samples};
use crate::structure::{Bond, BondKind, Frame, Structure};
use std::collections::HashMap;
use std::num::NonZeroU32;
use std::path::Path;
use std::time::Instant;

/// Seconds that loading took.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LoadSeconds {
    pub(super) read: f64,
    pub(super) bonds: f64,
}

/// Reads a file, of which the format may be said, and says what its reader noticed.
pub(super) fn read_as(path: &Path, format: Option<Format>, report: &Report) -> Result<Document> {
    super::memory::check_file(path)?;
    let document = match samples::read(path, &ImportOptions { format, ..ImportOptions::default() }) {
        Err(Error::Input { .. } | Error::Unsupported(_)) if Session::is_at(path) => {
            let message = "this is a session, or a picture with one: it is drawn alone, ballstick render FILE -o OUT, becomes a mesh, ballstick convert FILE OUT.glb, or is opened in the window";
            return Err(Error::Unsupported(message.to_owned()));
        }
        read => read?,
    };
    for diagnostic in &document.diagnostics {
        report.diagnostic(path, diagnostic);
    }
    Ok(document)
}

/// Reads a structure and opens its trajectories, and says what their readers noticed.
pub(super) fn read_input(input: &Input, report: &Report) -> Result<Document> {
    read_input_as(input, None, report)
}

/// As [`read_input`], of which the format may be said.
fn read_input_as(input: &Input, format: Option<Format>, report: &Report) -> Result<Document> {
    if input.trajectories.is_empty() {
        return read_as(&input.structure, format, report);
    }
    super::memory::check_file(&input.structure)?;
    let document = trajectory::read_input(input, &ImportOptions { format, ..ImportOptions::default() })?;
    for diagnostic in &document.diagnostics {
        report.diagnostic(&input.structure, diagnostic);
    }
    Ok(document)
}

/// What is drawn of a file, each structure with one frame and its bonds.
pub(super) fn load_for_picture(
    input: &Input,
    select: &SelectArgs,
    flags: (BondArgs, CrystalArgs),
    report: &Report,
    seconds: &mut LoadSeconds,
) -> Result<Vec<Drawn>> {
    load_as((input, None), select, flags, report, seconds)
}

/// As [`load_for_picture`] of a file of which the format may be said.
pub(super) fn load_as(
    (input, format): (&Input, Option<Format>),
    select: &SelectArgs,
    (bond_args, crystal_args): (BondArgs, CrystalArgs),
    report: &Report,
    seconds: &mut LoadSeconds,
) -> Result<Vec<Drawn>> {
    let options = crystal_options(bond_args, crystal_args);
    let started = Instant::now();
    let document = read_input_as(input, format, report)?;
    let parts = parts(&document, select, &options)?;
    let mut molecules = Molecules::new();
    add_molecules(&mut molecules, &document, &parts, &options)?;
    let format = document.format;
    // Its frames are no longer needed, and bonds take memory.
    drop(document);
    seconds.read += started.elapsed().as_secs_f64();
    let started = Instant::now();
    let drawn = draw(parts, &molecules, &options)?;
    warn_of_cells(&drawn, (&input.structure, format), crystal_args, report);
    seconds.bonds += started.elapsed().as_secs_f64();
    Ok(drawn)
}

/// Molecules whose bonds hold in all their frames, by their record.
pub(super) type Molecules = HashMap<usize, Fixed>;

/// What is to be drawn of a document.
enum Part {
    /// A structure with bonds of its own.
    Own(Box<Structure>),
    /// A frame of a molecule: its record, and where its atoms are.
    Frame(usize, Box<Frame>),
}

/// What is drawn of a document, one frame of many. The molecules are found once.
pub(super) fn drawn_of(
    document: &Document,
    select: &SelectArgs,
    options: &CrystalOptions,
    molecules: &mut Molecules,
) -> Result<Vec<Drawn>> {
    let parts = parts(document, select, options)?;
    add_molecules(molecules, document, &parts, options)?;
    draw(parts, molecules, options)
}

fn parts(document: &Document, select: &SelectArgs, options: &CrystalOptions) -> Result<Vec<Part>> {
    let select = match select {
        // One thing is drawn unless something is said.
        SelectArgs { frame: None, record: None } => &SelectArgs { frame: Some(NonZeroU32::MIN), record: None },
        select => select,
    };
    assembly::check(options.assembly, document.records.iter())?;
    let is_trajectory = !document.trajectories.is_empty();
    let is_fixed = document.has_frames() && options.bonds_per_frame.is_fixed(is_trajectory);
    let part = |(record, frame): (usize, Option<usize>)| {
        let frame = frame.unwrap_or(0);
        let structure = &document.records[record];
        let missing = || document.missing(frame);
        Ok(match (is_fixed, is_trajectory) {
            (true, true) => Part::Frame(record, Box::new(document.trajectory_frame(frame)?)),
            (true, false) => Part::Frame(record, Box::new(structure.frames().get(frame).cloned().ok_or_else(missing)?)),
            (false, true) => Part::Own(Box::new(document.at_frame(frame)?)),
            (false, false) => Part::Own(Box::new(structure.at_frame(frame).ok_or_else(missing)?)),
        })
    };
    chosen(document, select)?.into_iter().map(part).collect()
}

fn add_molecules(
    molecules: &mut Molecules,
    document: &Document,
    parts: &[Part],
    options: &CrystalOptions,
) -> Result<()> {
    for part in parts {
        if let Part::Frame(record, _) = part
            && !molecules.contains_key(record)
        {
            let first = document.records.get(*record).and_then(|structure| structure.at_frame(0));
            molecules.insert(*record, Fixed::new(first.ok_or_else(|| document.missing(0))?, options));
        }
    }
    Ok(())
}

fn draw(parts: Vec<Part>, molecules: &Molecules, options: &CrystalOptions) -> Result<Vec<Drawn>> {
    let drawn = |part: Part| match part {
        Part::Own(structure) => Some(crystal::draw(*structure, options)),
        Part::Frame(record, frame) => Some(molecules.get(&record)?.draw(*frame)),
    };
    parts.into_iter().filter_map(drawn).collect()
}

/// Says why cells are not drawn that were asked for.
pub(super) fn warn_of_cells(drawn: &[Drawn], (path, format): (&Path, Format), args: CrystalArgs, report: &Report) {
    assembly::warn_of_none(drawn, args.assembly.assembly.0, path, report);
    let is_asked = args.supercell.is_several() || args.cell == CellArg::Full;
    if drawn.iter().any(|drawn| drawn.copies.is_some() && !drawn.is_cell_content) && is_asked {
        report.warn(path, "--cell full and --supercell have no effect: an assembly is drawn");
        return;
    }
    if !is_asked || drawn.iter().any(|drawn| drawn.is_cell_content) {
        return;
    }
    let is_mmcif = matches!(format, Format::Mmcif | Format::BinaryCif);
    let why = match drawn.iter().any(|drawn| drawn.cell.is_some()) {
        true if is_mmcif => {
            "mmCIF files of proteins do not list the symmetry operations by which the atoms fill the cell; the entry's PDB \
             file does, in REMARK 290"
        }
        true => "the file lists no symmetry operations by which its atoms fill the cell, or the cell is a placeholder",
        false => "the file states no unit cell",
    };
    report.warn(path, &format!("--cell full and --supercell have no effect: {why}; the atoms are drawn as listed"));
}

/// The options that the flags of bonds and crystals stand for.
pub(super) fn crystal_options(bond_args: BondArgs, args: CrystalArgs) -> CrystalOptions {
    CrystalOptions {
        cell: CellChoice::from_name(&args.cell.name()).unwrap_or_default(),
        supercell: args.supercell.0,
        assembly: args.assembly.assembly.0,
        bonds: bond_options(bond_args),
        bonds_per_frame: BondsPerFrame::from_name(&args.bonds_per_frame.name()).unwrap_or_default(),
        ..CrystalOptions::default()
    }
}

/// The records, or the one, that is asked for; with a frame asked for, that frame alone.
pub(super) fn pick(document: Document, select: &SelectArgs) -> Result<Vec<Structure>> {
    let chosen = chosen(&document, select)?;
    let mut records: Vec<Option<Structure>> = document.records.into_iter().map(Some).collect();
    let part = |(record, frame): (usize, Option<usize>)| {
        let structure = records.get_mut(record).and_then(Option::take)?;
        match frame {
            Some(frame) => structure.with_only_frame(frame),
            None => Some(structure),
        }
    };
    Ok(chosen.into_iter().filter_map(part).collect())
}

/// Which records are asked for, and which frame of each, from 0; no frame where all are meant. All of them are there.
fn chosen(document: &Document, select: &SelectArgs) -> Result<Vec<(usize, Option<usize>)>> {
    let number = |n: NonZeroU32| usize::try_from(n.get()).unwrap_or(usize::MAX);
    let missing = |what: &str, asked: usize, there: usize| {
        Error::input(None, format!("{what} {asked} is asked for, but there are only {there}"))
    };
    let frame = select.frame.map(|frame| number(frame) - 1);
    let records = match select.record {
        Some(RecordChoice::Number(record)) => {
            let (record, count) = (number(record), document.records.len());
            if record > count {
                return Err(missing("record", record, count));
            }
            record - 1..record
        }
        _ => 0..document.records.len(),
    };
    if !document.trajectories.is_empty() {
        // Looks no further than the frame.
        document.check_frame(frame.unwrap_or(0))?;
        return Ok(vec![(0, frame)]);
    }
    match (select.record, frame) {
        (None, Some(frame)) => {
            let (record, own) = document.frame(frame).ok_or_else(|| document.missing(frame))?;
            Ok(vec![(record, Some(own))])
        }
        (_, None) => Ok(records.map(|record| (record, None)).collect()),
        (Some(_), Some(frame)) => {
            let with_frame = |record: usize| match document.records[record].frames().len() {
                there if frame < there => Ok((record, Some(frame))),
                there => Err(missing("frame", frame + 1, there)),
            };
            records.map(with_frame).collect()
        }
    }
}

/// The options that `--bonds` stands for.
pub(super) fn bond_options(args: BondArgs) -> BondOptions {
    BondOptions {
        mode: BondMode::from_name(&args.bonds.name()).unwrap_or_default(),
        hydrogen_bonds: args.hbonds,
        ..BondOptions::default()
    }
}

/// The structure with the bonds of its first frame.
pub(super) fn with_bonds(structure: Structure, args: BondArgs) -> Structure {
    bonds::assign(structure, &bond_options(args))
}

/// Covalent bonds by order 1, 2, 3 and aromatic; aromatic ones count only as that.
pub(super) fn count_orders(bonds: &[Bond]) -> [usize; 4] {
    let mut counts = [0; 4];
    for bond in bonds.iter().filter(|bond| bond.kind == BondKind::Covalent) {
        match (bond.aromatic, bond.order.number()) {
            (true, _) => counts[3] += 1,
            (false, order @ 1..=3) => counts[usize::from(order) - 1] += 1,
            _ => {}
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::BondsArg;
    use crate::structure::{BondOrder, BondSource};

    fn document() -> Document {
        let text = "1\n\nC 0 0 0\n1\n\nC 1 0 0\n1\n\nN 0 0 0\n";
        crate::import::read_bytes(text.as_bytes(), "a.xyz", &ImportOptions::default()).unwrap()
    }

    fn picked(record: Option<&str>, frame: Option<u32>) -> Result<Vec<(String, usize, f64)>> {
        let select = SelectArgs {
            record: record.map(|text| text.parse().unwrap()),
            frame: frame.map(|n| n.try_into().unwrap()),
        };
        let facts = |s: &Structure| (s.elements()[0].to_string(), s.frames().len(), s.positions().get(0).x);
        pick(document(), &select).map(|structures| structures.iter().map(facts).collect())
    }

    #[test]
    fn frames_count_through_the_file_and_within_a_record() {
        let carbon = |frames, x| ("C".to_owned(), frames, x);
        let nitrogen = || ("N".to_owned(), 1, 0.0);
        assert_eq!(picked(None, None).unwrap(), [carbon(2, 0.0), nitrogen()]);
        assert_eq!(picked(None, Some(2)).unwrap(), [carbon(1, 1.0)]);
        assert_eq!(picked(None, Some(3)).unwrap(), [nitrogen()]);
        assert_eq!(picked(Some("1"), None).unwrap(), [carbon(2, 0.0)]);
        assert_eq!(picked(Some("1"), Some(2)).unwrap(), [carbon(1, 1.0)]);
        assert_eq!(picked(Some("all"), Some(1)).unwrap(), [carbon(1, 0.0), nitrogen()]);
    }

    #[test]
    fn what_is_not_there_is_said_with_how_many_there_are() {
        assert!(picked(None, Some(4)).unwrap_err().to_string().contains("frame 4 is asked for, but there are only 3"));
        assert!(
            picked(Some("3"), None).unwrap_err().to_string().contains("record 3 is asked for, but there are only 2")
        );
        assert!(picked(Some("all"), Some(2)).is_err());
    }

    #[test]
    fn every_bond_mode_of_the_flag_is_one_of_the_library() {
        for (arg, mode) in [
            (BondsArg::Auto, BondMode::Auto),
            (BondsArg::File, BondMode::File),
            (BondsArg::Perceive, BondMode::Perceive),
            (BondsArg::None, BondMode::None),
        ] {
            assert_eq!(bond_options(BondArgs { bonds: arg, hbonds: false, no_hbonds: false }).mode, mode);
        }
    }

    #[test]
    fn each_covalent_bond_counts_once_and_others_not_at_all() {
        let bond = |order| Bond::new(0, 1, order, BondSource::File);
        let bonds = [
            bond(BondOrder::Single),
            bond(BondOrder::Single),
            bond(BondOrder::Triple),
            Bond { aromatic: true, ..bond(BondOrder::Double) },
            Bond { kind: BondKind::Coordination, ..bond(BondOrder::Single) },
            Bond { kind: BondKind::Hydrogen, ..bond(BondOrder::Unknown) },
            bond(BondOrder::Quadruple),
        ];
        assert_eq!(count_orders(&bonds), [2, 0, 1, 1]);
    }
}
