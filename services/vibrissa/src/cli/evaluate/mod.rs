//! `vibrissa evaluate`: how well the core does, on simulated whiskers whose truth is known.

pub mod compensation;
pub mod detection;
pub mod health;

use std::io::Write;

use anyhow::Result;
use clap::{Args, Subcommand};

use super::stop;

/// Arguments of `vibrissa evaluate`.
#[derive(Debug, Args)]
pub struct EvaluateArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// How soon a trim is known, beside a CUSUM that is told its size.
    Detection(detection::DetectionArgs),
    /// What is wrong is called by its name: a confusion matrix of everything that is a trim and that is none.
    Health(health::HealthArgs),
    /// The paper's compensation experiment on plants that are not the model: open loop, closed loop, with gain.
    Compensation(compensation::CompensationArgs),
}

/// Runs an evaluation.
///
/// # Errors
/// Something cannot be written.
pub fn run(args: &EvaluateArgs, out: &mut dyn Write) -> Result<()> {
    stop::watch("nothing was evaluated to the end, and nothing is written")?;
    match &args.what {
        What::Detection(args) => detection::run(args, out),
        What::Health(args) => health::run(args, out),
        What::Compensation(args) => compensation::run(args, out),
    }
}
