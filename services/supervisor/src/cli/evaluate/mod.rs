//! `vibrissa evaluate`: how well the core does, on simulated whiskers whose truth is known.

pub mod compensation;

use std::io::Write;

use anyhow::Result;
use clap::{Args, Subcommand};

/// Arguments of `vibrissa evaluate`.
#[derive(Debug, Args)]
pub struct EvaluateArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// The paper's compensation experiment on plants that are not the model: open loop, closed loop, with gain.
    Compensation(compensation::CompensationArgs),
}

/// Runs an evaluation.
///
/// # Errors
/// Something cannot be written.
pub fn run(args: &EvaluateArgs, out: &mut dyn Write) -> Result<()> {
    match &args.what {
        What::Compensation(args) => compensation::run(args, out),
    }
}
