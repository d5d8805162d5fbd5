//! The command line.

pub mod serve;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Supervisor for fleets of robots with soft whisker arrays.
#[derive(Debug, Parser)]
#[command(version, about, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Supervise a fleet: MQTT in, setpoints out, everything recorded.
    Run(Box<serve::RunArgs>),
    /// See the whole job in half a minute: broker, supervisor, database and a simulated fleet in one process.
    Demo(serve::DemoArgs),
}

/// Runs a command.
///
/// # Errors
/// What went wrong, for the person who called it.
pub fn run(cli: Cli) -> anyhow::Result<ExitCode> {
    match cli.command {
        Command::Run(args) => serve::run(*args).map(|()| ExitCode::SUCCESS),
        Command::Demo(args) => {
            serve::demo(args).map(|passed| if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
        }
    }
}
