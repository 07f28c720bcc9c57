//! `ballstick view`: hands the files to the window.

use super::args::ViewArgs;
use super::report::Report;

#[cfg(feature = "window")]
pub(super) fn run(args: ViewArgs, report: &Report) -> Result<(), String> {
    let (mut files, mut structures) = (Vec::new(), Vec::new());
    for file in &args.files {
        match super::guarded(|| super::load::read(file, report)) {
            Ok(document) => {
                // Of a file with several records the first is shown.
                let first = document.records.into_iter().next();
                structures.extend(first.map(|structure| super::load::with_bonds(structure, args.bonds)));
                files.push(file.clone());
            }
            Err(error) => report.fail(file, &error),
        }
    }
    if structures.is_empty() {
        return Ok(()); // said above, file by file
    }
    let options = super::render::window_options(&args, &structures);
    if let Err(error) = options.and_then(|options| crate::app::run(files, structures, options)) {
        report.fail_with(&error.to_string());
    }
    Ok(())
}

#[cfg(not(feature = "window"))]
pub(super) fn run(args: ViewArgs, report: &Report) -> Result<(), String> {
    let file = args.files.first().map_or_else(String::new, |file| file.to_string_lossy().into_owned());
    let instead = format!("ballstick render {file} -o picture.png");
    report.fail_with(&format!("this ballstick was built without the window; draw a picture instead: {instead}"));
    Ok(())
}
