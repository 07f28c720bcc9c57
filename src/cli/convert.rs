//! `ballstick convert`: a structure in another format.

use super::args::ConvertArgs;
use super::load::{pick, read, with_bonds};
use super::report::Report;
use crate::error::Result;
use crate::export::atomic;
use crate::export::formats::StructureFormat;
use crate::structure::Structure;

/// An error is one of usage.
pub(super) fn run(args: &ConvertArgs, report: &mut Report) -> Result<(), String> {
    let format = match &args.to {
        Some(name) => StructureFormat::from_name(name),
        None if atomic::is_stdout(&args.output) => return Err("standard output needs --to FORMAT".to_owned()),
        None => StructureFormat::from_path(&args.output),
    };
    let format = format.map_err(|error| error.to_string())?;
    report.start(1);
    match super::guarded(|| convert(args, format, report)) {
        Err(error) if !atomic::is_broken_pipe(&error) => report.fail(&args.input, &error),
        _ => {}
    }
    Ok(())
}

fn convert(args: &ConvertArgs, format: &StructureFormat, report: &Report) -> Result<()> {
    let mut records: Vec<Structure> = pick(read(&args.input, report)?, &args.select)?;
    if format.holds_bonds() {
        // Those that are not written need none.
        let written = if format.all_frames { records.len() } else { 1 };
        let bonded = |(index, record)| if index < written { with_bonds(record, args.bonds) } else { record };
        records = records.into_iter().enumerate().map(bonded).collect();
    }
    for loss in format.losses(&records) {
        report.warn(&args.input, &loss);
    }
    atomic::write(&args.output, |out| (format.write)(&records, out))
}
