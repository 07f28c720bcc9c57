//! The command line: what is typed ([`args`], [`values`]) to what is done, one module a command.
//!
//! Results go to standard output, everything else to standard error. Exit status: 0 done (also with
//! warnings, and when the reader of standard output has gone), 1 some inputs failed, 2 the command line is wrong. `render` is the only module
//! that knows scenes and renderers.

mod animate;
pub mod args;
pub mod atoms;
mod convert;
mod devices;
mod explain;
pub mod frames;
pub mod from;
mod info;
mod load;
mod picture;
mod plan;
mod record;
mod render;
mod report;
pub mod size;
pub mod solid;
mod strips;
pub mod values;
mod view;

use crate::session::Session;
use args::{Cli, Command};
use clap::Parser;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Exit status where inputs failed.
const FAILED: u8 = 1;
/// Exit status for a wrong command line.
const USAGE: u8 = 2;

/// Runs the program with these arguments, the first being its own name, and gives the exit status.
#[must_use]
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let mut report = report::Report::default();
    let cli = match parsed(arguments.into_iter().collect(), &report) {
        Ok(cli) => cli,
        Err(status) => return status,
    };
    let done = match cli.command.unwrap_or(Command::View(Box::new(cli.view))) {
        Command::View(args) => view::run(*args, &report),
        Command::Render(args) => picture::run(&args, &mut report, &mut render::Drawer::new(args.renderer)),
        Command::Info(args) => {
            info::run(&args, &mut report);
            Ok(())
        }
        Command::Convert(args) => convert::run(&args, &mut report),
        Command::Devices => {
            devices::run(&render::devices(), &report);
            Ok(())
        }
    };
    match done {
        Ok(()) => report.finish(),
        Err(message) => {
            report.fail_with(&message);
            report.line("Usage: ballstick --help");
            report.finish();
            USAGE
        }
    }
}

/// What is typed, with what `--from` adds to it; an exit status if it says nothing to do.
fn parsed(arguments: Vec<OsString>, report: &report::Report) -> Result<Cli, u8> {
    let parse = |arguments: &[OsString]| {
        Cli::try_parse_from(arguments).map_err(|error| {
            drop(error.print()); // help into a closed pipe is no failure
            u8::try_from(error.exit_code()).unwrap_or(USAGE)
        })
    };
    let is_render = arguments.get(1).is_some_and(|word| word == "render");
    let mut path = from::named(&arguments).filter(|_| is_render);
    let mut is_file = false;
    if path.is_none() {
        let cli = parse(&arguments)?;
        // A session in place of a molecule means the same.
        path = match &cli.command {
            Some(Command::Render(args)) => match args.files.as_slice() {
                [file] if Session::is_at(file) => Some(file.clone()),
                _ => None,
            },
            _ => None,
        };
        is_file = true;
        if path.is_none() {
            return Ok(cli);
        }
    }
    let Some(path) = path else { return parse(&arguments) };
    let failed = |message: String| {
        report.fail_with(&message);
        FAILED
    };
    let session = Session::read(&path).map_err(|error| match error {
        crate::Error::Io { .. } => failed(error.to_string()),
        error => failed(format!("{}: {error}", path.display())),
    })?;
    let mut cli = parse(&from::expanded(&arguments, &session))?;
    if let Some(Command::Render(args)) = &mut cli.command {
        if is_file {
            args.files.clear();
            args.from = Some(path.clone());
        }
        from::complete(args, &arguments, (&path, &session), report).map_err(failed)?;
    }
    Ok(cli)
}

/// Runs one input's work; a panic in it, which is a bug of ours, becomes an error like any other, so that it cannot
/// stop a batch. Its place in the code goes to standard error by Rust's own message.
fn guarded<T>(work: impl FnOnce() -> crate::Result<T>) -> crate::Result<T> {
    // Nothing that the closure leaves half done is used after a panic: files are written whole, the renderer is reset.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| {
        let text = payload.downcast_ref::<String>().cloned();
        let text = text.or_else(|| payload.downcast_ref::<&str>().map(|&text| text.to_owned()));
        let text = text.unwrap_or_else(|| "no message".to_owned());
        Err(crate::Error::Unsupported(format!("a bug in ballstick ({text}); please report it with the file")))
    })
}
