//! `ballstick convert`: a structure in another format; scenes go to [`super::solid`].

use super::apart;
use super::assembly;
use super::atoms::ShowArgs;
use super::load::{pick, read_as, with_bonds};
use super::report::Report;
use super::solid::{self, ConvertArgs};
use crate::error::Result;
use crate::export::atomic;
use crate::export::formats::StructureFormat;
use crate::import::Format;
use crate::select::Scope;
use crate::structure::Structure;
use std::path::Path;

/// An error is one of usage.
pub(super) fn run(args: &ConvertArgs, report: &mut Report) -> Result<(), String> {
    let needs = "convert needs a file to write: ballstick convert FILE OUT, or FILE… -o OUT";
    let (files, output) = args.places().ok_or(needs)?;
    if files.iter().filter(|file| file.as_os_str() == "-").count() > 1 {
        return Err("- is given twice, but standard input can be read only once".to_owned());
    }
    let from = match &args.from {
        None => None,
        Some(name) => Some(Format::from_name(name).ok_or_else(|| {
            let names: Vec<&str> = Format::ALL.iter().map(|format| format.name()).collect();
            format!("--from {name} is no format that is read; they are {}", names.join(", "))
        })?),
    };
    if apart::is_wanted() {
        let inputs: Vec<&Path> = files.iter().chain(&args.look.overlay).map(|file| file.as_path()).collect();
        if let Err(error) = apart::run(0, &inputs, Some(output), report) {
            report.fail(files.first().map_or(output, |file| file.as_path()), &error);
        }
        return Ok(());
    }
    if let Some(format) = args.solid_format() {
        solid::run(args, (files, output), format, from, report);
        return Ok(());
    }
    let format = match &args.to {
        Some(name) => StructureFormat::from_name(name),
        None if atomic::is_stdout(output) => return Err("standard output needs --to FORMAT".to_owned()),
        None => StructureFormat::from_path(output),
    };
    let format = format.map_err(|error| format!("{error}; and for what would be drawn glb, gltf, obj, stl, ply"))?;
    let [input] = files else {
        let message = format!("{} holds one file's atoms, and these are {}: give one FILE", format.name, files.len());
        return Err(message);
    };
    if solid::asks_for_looks(&args.look, args.crystal, &args.solid) {
        let message =
            format!("{} holds atoms as they are listed: flags of look, crystal and mesh have no effect", format.name);
        report.warn(output, &message);
    }
    report.start(1);
    match super::guarded(|| convert(args, (input, output), (from, format), report)) {
        Err(error) if !atomic::is_broken_pipe(&error) => report.fail(input, &error),
        _ => {}
    }
    Ok(())
}

fn convert(
    args: &ConvertArgs,
    (input, output): (&Path, &Path),
    (from, format): (Option<Format>, &StructureFormat),
    report: &Report,
) -> Result<()> {
    let shown = &args.look.atoms.shown;
    let mut records: Vec<Structure> = pick(read_as(input, from, report)?, &args.select)?;
    if format.holds_bonds() {
        // Those that are not written need none.
        let written = if format.all_frames { records.len() } else { 1 };
        let bonded = |(index, record)| if index < written { with_bonds(record, args.bonds) } else { record };
        records = records.into_iter().enumerate().map(bonded).collect();
    }
    if !(shown.show.is_empty() && shown.hide.is_empty()) {
        let mut has_found = vec![false; shown.show.len() + shown.hide.len()];
        let mut chosen = |record: &Structure| match format.holds_bonds() {
            true => record.subset(&wanted(record, shown, &mut has_found)),
            // Selections ask for bonds all the same.
            false => record.subset(&wanted(&with_bonds(record.clone(), args.bonds), shown, &mut has_found)),
        };
        records = records.iter().map(&mut chosen).collect();
        let flags = shown.show.iter().map(|one| ("show", one)).chain(shown.hide.iter().map(|one| ("hide", one)));
        for ((flag, selection), _) in flags.zip(has_found).filter(|(_, has_found)| !has_found) {
            report.warn(input, &format!("--{flag} {selection}: there is no such atom"));
        }
    }
    records = assembly::written(records, args.crystal.assembly.assembly.0, (input, report))?;
    for loss in format.losses(&records) {
        report.warn(input, &loss);
    }
    atomic::write(output, |out| (format.write)(&records, out))
}

/// Which atoms of a record are written; notes which selections find any.
fn wanted(record: &Structure, shown: &ShowArgs, has_found: &mut [bool]) -> Vec<bool> {
    let (shows, hides) = has_found.split_at_mut(shown.show.len());
    let mut wanted = vec![shown.show.is_empty(); record.atom_count()];
    for (selection, has_found) in shown.show.iter().zip(shows) {
        let atoms = selection.atoms(Scope::of(record));
        *has_found |= atoms.contains(&true);
        wanted.iter_mut().zip(atoms).for_each(|(wanted, is)| *wanted |= is);
    }
    for (selection, has_found) in shown.hide.iter().zip(hides) {
        let atoms = selection.atoms(Scope::of(record));
        *has_found |= atoms.contains(&true);
        wanted.iter_mut().zip(atoms).for_each(|(wanted, is)| *wanted &= !is);
    }
    wanted
}
