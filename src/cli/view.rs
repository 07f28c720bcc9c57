//! `ballstick view`: hands the files to the window.

use super::args::ViewArgs;
use super::report::Report;

#[cfg(feature = "window")]
pub(super) fn run(args: ViewArgs, report: &Report) -> Result<(), String> {
    let opened = super::render::window_options(&args).and_then(|options| crate::app::run(args.files, options));
    if let Err(error) = opened {
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
