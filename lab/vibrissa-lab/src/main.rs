//! The `vibrissa-lab` program.

use std::process::ExitCode;

use vibrissa::cli::ending::exit_code;
use vibrissa::cli::parse;
use vibrissa_lab::cli;

fn main() -> ExitCode {
    exit_code(cli::run(parse()))
}
