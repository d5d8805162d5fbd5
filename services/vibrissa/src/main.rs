//! The `vibrissa` program.

use std::process::ExitCode;

use vibrissa::cli;

fn main() -> ExitCode {
    cli::ending::exit_code(cli::run(cli::parse()))
}
