//! `ballstick view`: hands the files to the window.

use super::args::ViewArgs;
use super::report::Report;

#[cfg(feature = "window")]
pub(super) fn run(args: ViewArgs, report: &Report) -> Result<(), String> {
    let (mut files, mut drawn) = (Vec::new(), Vec::new());
    for file in &args.files {
        let read = || {
            // Of a file with several records the first is shown.
            let first = super::load::read(file, report)?.records.into_iter().next();
            first.map(|structure| super::load::drawn(structure, args.bonds, args.crystal)).transpose()
        };
        match super::guarded(read) {
            Ok(first) => {
                drawn.extend(first);
                files.push(file.clone());
            }
            Err(error) => report.fail(file, &error),
        }
    }
    if drawn.is_empty() {
        return Ok(()); // said above, file by file
    }
    let options = super::render::window_options(&args, &drawn, report);
    if let Err(error) = options.and_then(|options| crate::app::run(files, drawn, options)) {
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
