//! `vibrissa completions`: a script that lets a shell complete commands, options and closed words.

use std::io::Write;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

/// Arguments of `vibrissa completions`.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// Shell that reads the script.
    shell: Shell,
}

/// Prints the script.
///
/// # Errors
/// The output cannot be written.
pub fn run(args: &CompletionsArgs, out: &mut impl Write) -> anyhow::Result<()> {
    // The generator panics if its output fails, so it writes into memory.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut super::Cli::command(), "vibrissa", &mut script);
    Ok(out.write_all(&script)?)
}
