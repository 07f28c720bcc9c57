//! `ballstick view`: hands the files to the window.

use super::args::ViewArgs;
use super::report::Report;

#[cfg(feature = "window")]
pub(super) fn run(args: ViewArgs, report: &Report) -> Result<(), String> {
    if let Err(error) = crate::app::run(args.files, super::render::app_options(&args.look)) {
        report.fail_with(&error.to_string());
    }
    Ok(())
}

#[cfg(not(feature = "window"))]
pub(super) fn run(args: ViewArgs, report: &Report) -> Result<(), String> {
    let file = args.files.first().map_or_else(String::new, |file| file.to_string_lossy().into_owned());
    report.fail_with(&format!(
        "this ballstick was built without the window (feature `window`); draw a picture: ballstick render {file} -o picture.png"
    ));
    Ok(())
}
