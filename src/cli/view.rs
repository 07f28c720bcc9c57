//! `ballstick view`: hands the files to the window.

use super::args::ViewArgs;
use super::report::Report;

#[cfg(feature = "window")]
pub(super) fn run(args: ViewArgs, report: &Report) -> Result<(), String> {
    let options = match super::guarded(|| super::render::window_options(&args, report)) {
        Ok(options) => options,
        Err(error) => {
            match args.files.first() {
                Some(file) => report.fail(file, &error),
                None => report.fail_with(&error.to_string()),
            }
            return Ok(());
        }
    };
    match crate::app::run(args.files, options) {
        // Said in the window, too; a script learns of it here.
        Ok(ended) => {
            ended.failures.iter().for_each(|failure| report.fail_with(failure));
            if let Some(timings) = ended.timings {
                report.line(&timings);
            }
        }
        Err(error) => report.fail_with(&error.to_string()),
    }
    Ok(())
}

#[cfg(not(feature = "window"))]
pub(super) fn run(args: ViewArgs, report: &Report) -> Result<(), String> {
    let file = args.files.first().map_or_else(|| "FILE".to_owned(), |file| file.to_string_lossy().into_owned());
    let instead = format!("ballstick render {file} -o picture.png");
    report.fail_with(&format!("this ballstick was built without the window; draw a picture instead: {instead}"));
    Ok(())
}
