//! The command line: what is typed ([`args`], [`values`]) to what is done, one module a command.
//!
//! Results go to standard output, everything else to standard error. Exit status: 0 done (also with
//! warnings, and when the reader of standard output has gone), 1 some inputs failed, 2 the command line is wrong. `render` is the only module
//! that knows scenes and renderers.

pub mod args;
pub mod atoms;
mod convert;
mod devices;
mod explain;
mod info;
mod load;
mod picture;
mod plan;
mod render;
mod report;
pub mod size;
mod strips;
pub mod values;
mod view;

use args::{Cli, Command};
use clap::Parser;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Exit status for a wrong command line.
const USAGE: u8 = 2;

/// Runs the program with these arguments, the first being its own name, and gives the exit status.
#[must_use]
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            drop(error.print()); // help into a closed pipe is no failure
            return u8::try_from(error.exit_code()).unwrap_or(USAGE);
        }
    };
    let mut report = report::Report::default();
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
