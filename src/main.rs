//! The program: [`ballstick::cli`] does the work.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(ballstick::cli::run(std::env::args_os()))
}
