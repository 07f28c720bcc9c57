//! `ballstick convert`: a structure in another format.

use super::args::ConvertArgs;
use super::assembly;
use super::load::{pick, read_as, with_bonds};
use super::report::Report;
use crate::error::Result;
use crate::export::atomic;
use crate::export::formats::StructureFormat;
use crate::import::Format;
use crate::select::Scope;
use crate::structure::Structure;

/// An error is one of usage.
pub(super) fn run(args: &ConvertArgs, report: &mut Report) -> Result<(), String> {
    let format = match &args.to {
        Some(name) => StructureFormat::from_name(name),
        None if atomic::is_stdout(&args.output) => return Err("standard output needs --to FORMAT".to_owned()),
        None => StructureFormat::from_path(&args.output),
    };
    let format = format.map_err(|error| error.to_string())?;
    let from = match &args.from {
        None => None,
        Some(name) => Some(Format::from_name(name).ok_or_else(|| {
            let names: Vec<&str> = Format::ALL.iter().map(|format| format.name()).collect();
            format!("--from {name} is no format that is read; they are {}", names.join(", "))
        })?),
    };
    report.start(1);
    match super::guarded(|| convert(args, from, format, report)) {
        Err(error) if !atomic::is_broken_pipe(&error) => report.fail(&args.input, &error),
        _ => {}
    }
    Ok(())
}

fn convert(args: &ConvertArgs, from: Option<Format>, format: &StructureFormat, report: &Report) -> Result<()> {
    let mut records: Vec<Structure> = pick(read_as(&args.input, from, report)?, &args.select)?;
    if format.holds_bonds() {
        // Those that are not written need none.
        let written = if format.all_frames { records.len() } else { 1 };
        let bonded = |(index, record)| if index < written { with_bonds(record, args.bonds) } else { record };
        records = records.into_iter().enumerate().map(bonded).collect();
    }
    if !(args.shown.show.is_empty() && args.shown.hide.is_empty()) {
        let mut has_found = vec![false; args.shown.show.len() + args.shown.hide.len()];
        let mut chosen = |record: &Structure| match format.holds_bonds() {
            true => record.subset(&wanted(record, args, &mut has_found)),
            // Selections ask for bonds all the same.
            false => record.subset(&wanted(&with_bonds(record.clone(), args.bonds), args, &mut has_found)),
        };
        records = records.iter().map(&mut chosen).collect();
        let flags =
            args.shown.show.iter().map(|one| ("show", one)).chain(args.shown.hide.iter().map(|one| ("hide", one)));
        for ((flag, selection), _) in flags.zip(has_found).filter(|(_, has_found)| !has_found) {
            report.warn(&args.input, &format!("--{flag} {selection}: there is no such atom"));
        }
    }
    records = assembly::written(records, args.assembly.assembly.0, (&args.input, report))?;
    for loss in format.losses(&records) {
        report.warn(&args.input, &loss);
    }
    atomic::write(&args.output, |out| (format.write)(&records, out))
}

/// Which atoms of a record are written; notes which selections find any.
fn wanted(record: &Structure, args: &ConvertArgs, has_found: &mut [bool]) -> Vec<bool> {
    let (shows, hides) = has_found.split_at_mut(args.shown.show.len());
    let mut wanted = vec![args.shown.show.is_empty(); record.atom_count()];
    for (selection, has_found) in args.shown.show.iter().zip(shows) {
        let atoms = selection.atoms(Scope::of(record));
        *has_found |= atoms.contains(&true);
        wanted.iter_mut().zip(atoms).for_each(|(wanted, is)| *wanted |= is);
    }
    for (selection, has_found) in args.shown.hide.iter().zip(hides) {
        let atoms = selection.atoms(Scope::of(record));
        *has_found |= atoms.contains(&true);
        wanted.iter_mut().zip(atoms).for_each(|(wanted, is)| *wanted &= !is);
    }
    wanted
}
