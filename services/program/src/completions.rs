//! The command `completions`: a script that lets a shell complete commands, options and closed words.

use std::io::{self, Write};

use clap::{Args, Command};
use clap_complete::Shell;

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// Shell that reads the script.
    shell: Shell,
}

/// Prints the script for a program.
///
/// # Errors
/// The output cannot be written.
pub fn run(args: &CompletionsArgs, program: &mut Command, out: &mut impl Write) -> io::Result<()> {
    // The generator panics if its output fails, so it writes into memory.
    let mut script = Vec::new();
    let name = program.get_name().to_owned();
    clap_complete::generate(args.shell, program, name, &mut script);
    out.write_all(&script)
}
