//! The program: [`ballstick::cli`] does the work.

use std::process::ExitCode;

fn main() -> ExitCode {
    ballstick::cli::settle();
    ExitCode::from(ballstick::cli::run(std::env::args_os()))
}
