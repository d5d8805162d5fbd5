//! The `vibrissa` program.

use std::process::ExitCode;

use clap::Parser;
use vibrissa::cli::{self, Cli};

fn main() -> ExitCode {
    match cli::run(Cli::parse()) {
        Ok(code) => code,
        Err(problem) => {
            eprintln!("vibrissa: {problem:#}");
            ExitCode::FAILURE
        }
    }
}
