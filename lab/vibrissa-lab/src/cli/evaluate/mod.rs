//! `vibrissa-lab evaluate`: evaluates the core on simulated whiskers whose true state is known.

pub mod compensation;
pub mod detection;
pub mod health;
pub mod reality;

use std::io::Write;

use anyhow::Result;
use clap::{Args, Subcommand};

use vibrissa::cli::stop;

/// Arguments of `vibrissa-lab evaluate`.
#[derive(Debug, Args)]
pub struct EvaluateArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Delay of trim detection, compared with a CUSUM that knows the size of the cut.
    Detection(detection::DetectionArgs),
    /// Confusion matrix of simulated faults, trims among them.
    Health(health::HealthArgs),
    /// The paper's compensation experiment on plants that deviate from the model: open loop, closed loop, with gain.
    Compensation(compensation::CompensationArgs),
    /// Detection, false reports and compensation on whiskers that creep, age, warm up and wear, as real ones do.
    Reality(reality::RealityArgs),
}

/// Runs an evaluation.
///
/// # Errors
/// The output or a file cannot be written.
pub fn run(args: &EvaluateArgs, out: &mut dyn Write) -> Result<()> {
    stop::watch("the evaluation is incomplete, and nothing was written")?;
    match &args.what {
        What::Detection(args) => detection::run(args, out),
        What::Health(args) => health::run(args, out),
        What::Compensation(args) => compensation::run(args, out),
        What::Reality(args) => reality::run(args, out),
    }
}
