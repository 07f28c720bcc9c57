//! The command line: what is typed ([`args`], [`values`]) to what is done, one module a command.
//!
//! Results go to standard output, everything else to standard error. Exit status: 0 done (also with
//! warnings, and when the reader of standard output has gone), 1 some inputs failed, 2 the command line is wrong. `render` is the only module
//! that knows scenes and renderers.

mod animate;
mod apart;
pub mod args;
pub mod assembly;
pub mod atoms;
pub mod batch;
mod convert;
mod devices;
mod explain;
pub mod frames;
pub mod from;
mod info;
pub mod limits;
mod load;
pub mod manual;
mod memory;
pub mod opposite;
mod picture;
mod plan;
mod process;
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
use std::path::Path;

/// Exit status where inputs failed.
const FAILED: u8 = 1;
/// Exit status for a wrong command line.
const USAGE: u8 = 2;

/// The exit statuses, for the manual; `--help` has them in a line.
const STATUSES: &[(&str, &str)] = &[
    ("0", "All is done, perhaps with warnings, or the reader of standard output has gone."),
    ("1", "Some inputs failed, and the others are done; or the result could not be written."),
    ("2", "The command line is wrong. Nothing was done."),
    (
        "128 + N",
        "Ended by signal N, as the shell shows it: 130 is Ctrl+C, 143 kill, 137 kill -9, or no memory left in a container or the machine.",
    ),
];

/// The environment variables that count, for the manual.
const ENVIRONMENT: &[(&str, &str)] = &[
    ("RAYON_NUM_THREADS", "Threads to work with; one a core if it is not set."),
    (
        "BALLSTICK_SIMD",
        "The widest vector instructions of the CPU renderer: avx512, avx2 or baseline; what the machine has if it is not set. The picture is the same.",
    ),
    ("WGPU_BACKEND", "The interface to graphics devices: vulkan, gl, dx12 or metal."),
    ("XDG_CONFIG_HOME", "Where the window keeps its preferences (Linux); ~/.config if it is not set."),
];

/// For a program whose arguments are those of [`run`], before anything else: may begin it anew, with settings that the process
/// needs from its start.
pub fn settle() {
    process::spare_addresses();
    apart::allow();
    apart::follow_parent();
}

/// Runs the program with these arguments, the first being its own name, and gives the exit status.
#[must_use]
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    match process::on_stack_enough(|| begun(&arguments)) {
        Begun::Ended(status) => status,
        // Windows are opened on the first thread only.
        Begun::View(args, report) => ended(view::run(*args, &report), report),
    }
}

/// How far the work goes that any thread can do.
enum Begun {
    Ended(u8),
    View(Box<args::ViewArgs>, report::Report),
}

fn begun(arguments: &[OsString]) -> Begun {
    let mut report = report::Report::default();
    if apart::own_input().is_some() {
        report.mute();
    }
    let cli = match parsed(arguments, &report) {
        Ok(cli) => cli,
        Err(status) => return Begun::Ended(status),
    };
    if let Err(error) = memory::check_start() {
        report.fail_with(&error.to_string());
        return Begun::Ended(FAILED);
    }
    let command = cli.command.unwrap_or(Command::View(Box::new(cli.view)));
    let works = matches!(command, Command::Render(_) | Command::Info(_) | Command::Convert(_));
    // Of many files the next one would have to live with what the last ones left (a fourth more at the peak, no time gained).
    let is_one = matches!(&command, Command::Render(args) if args.files.len() == 1);
    if is_one && memory::process_bound().is_none() {
        process::keep_memory();
    }
    process::prepare(!(works && apart::is_tight()));
    if let Some(warning) = render::environment_warning().filter(|_| apart::own_input().is_none()) {
        report.line(&format!("ballstick: warning: {warning}"));
    }
    if !matches!(command, Command::Render(_)) {
        report.speak(); // there are warnings to come of its own input only
    }
    let done = match command {
        Command::View(args) => return Begun::View(args, report),
        Command::Render(args) => picture::run(&args, &mut report, &mut render::Drawer::new(args.renderer, args.limits)),
        Command::Info(args) => {
            info::run(&args, &mut report);
            Ok(())
        }
        Command::Convert(args) => convert::run(&args, &mut report),
        Command::Manual(args) => manual::run_manual(&args, &report),
        Command::Completions(args) => {
            manual::run_completions(&args, &report);
            Ok(())
        }
        Command::Devices => {
            devices::run(&render::devices(), &report);
            Ok(())
        }
    };
    Begun::Ended(ended(done, report))
}

/// The exit status; an error is one of usage.
fn ended(done: Result<(), String>, report: report::Report) -> u8 {
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
fn parsed(arguments: &[OsString], report: &report::Report) -> Result<Cli, u8> {
    let is_render = arguments.get(1).is_some_and(|word| word == "render");
    let mut path = from::named(arguments).filter(|_| is_render);
    let mut is_file = false;
    if path.is_none() {
        let cli = parse(arguments, report)?;
        // A session in place of a molecule means the same.
        path = match &cli.command {
            Some(Command::Render(args)) => match args.files.as_slice() {
                [file] if Session::is_at(file) => Some(file.clone()),
                _ => None,
            },
            Some(Command::Convert(args)) if args.session().is_some() => {
                return of_session(args, arguments, report);
            }
            _ => None,
        };
        is_file = true;
        if path.is_none() {
            return Ok(cli);
        }
    }
    let Some(path) = path else { return parse(arguments, report) };
    let session = session_at(&path, report)?;
    let mut cli = parse(&from::expanded(arguments, &session, |_| true), report)?;
    if let Some(Command::Render(args)) = &mut cli.command {
        if is_file {
            args.files.clear();
            args.from = Some(path.clone());
        }
        from::complete(args, arguments, (&path, &session), report).map_err(|message| failed(report, &message))?;
    }
    Ok(cli)
}

/// `convert` of a session: what `render` would draw of it, as a mesh.
fn of_session(args: &solid::ConvertArgs, arguments: &[OsString], report: &report::Report) -> Result<Cli, u8> {
    let Some((path, output)) = args.session() else { return parse(arguments, report) };
    let session = session_at(path, report)?;
    let mut as_picture = ["ballstick", "render", "-o", "-", "--to", "png", "--from"].map(OsString::from).to_vec();
    as_picture.push(path.into());
    let picture = parse(&from::expanded(&as_picture, &session, |_| true), report)?;
    let knows = |name: &str| solid::has_flag(name) && !solid::OF_PICTURES.contains(&name) && name != "focus";
    let mut cli = parse(&from::expanded(arguments, &session, knows), report)?;
    if let (Some(Command::Render(mut picture)), Some(Command::Convert(args))) = (picture.command, &mut cli.command) {
        from::complete(&mut picture, arguments, (path, &session), report)
            .map_err(|message| failed(report, &message))?;
        args.files = picture.files;
        args.output = Some(output.to_owned());
        args.look.camera = args.look.camera.or(picture.look.camera);
        args.origin = picture.origin;
    }
    Ok(cli)
}

/// What is typed; an exit status if it says nothing to do.
fn parse(arguments: &[OsString], report: &report::Report) -> Result<Cli, u8> {
    Cli::try_parse_from(arguments).map_err(|error| {
        let status = u8::try_from(error.exit_code()).unwrap_or(USAGE);
        // Help into a closed pipe is no failure; help that finds no room is.
        match error.print() {
            Err(error) if status == 0 && error.kind() != std::io::ErrorKind::BrokenPipe => {
                failed(report, &format!("cannot write -: {error}"))
            }
            _ => status,
        }
    })
}

fn failed(report: &report::Report, message: &str) -> u8 {
    report.fail_with(message);
    FAILED
}

fn session_at(path: &Path, report: &report::Report) -> Result<Session, u8> {
    Session::read(path).map_err(|error| match error {
        crate::Error::Io { .. } => failed(report, &error.to_string()),
        error => failed(report, &format!("{}: {error}", path.display())),
    })
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
