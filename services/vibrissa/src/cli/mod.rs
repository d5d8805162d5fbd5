//! The command line.

pub mod api;
pub mod backup;
pub mod bulk;
pub mod config;
pub mod contract;
pub mod decommission;
pub mod ending;
pub mod export;
pub mod mcp;
pub mod metrics;
pub mod progress;
pub mod record;
pub mod serve;
pub mod setpoint;
pub mod stop;
pub mod table;
pub mod token;
pub mod watch;
pub mod whiskers;
pub mod words;

use std::io::{stdin, stdout};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use vibrissa_program::completions;
use vibrissa_program::options::{decimal, lenient};

/// Exit code of a command that has worked, and whose answer is no.
pub const ANSWER_IS_NO: u8 = 3;

/// Supervisor for fleets of robots with soft whisker arrays.
#[derive(Debug, Parser)]
#[command(version, about, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// The commands of the service and of its operators.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the supervisor of one or more fleets.
    Run(config::ConfigArgs),
    /// Print the configuration in effect, each key with its source; passwords are hidden.
    Config(config::ConfigArgs),
    /// List the whiskers that a supervisor knows: length, health, pressure, compensator.
    Whiskers(whiskers::WhiskersArgs),
    /// List the compensations with their predicted and measured errors.
    Compensations(whiskers::CompensationsArgs),
    /// Set a whisker's pressure manually, or release the whisker to the supervisor again.
    Setpoint(setpoint::SetpointArgs),
    /// Decommission a robot that has left for good: its history stays.
    Decommission(decommission::DecommissionArgs),
    /// Hold, release, relearn or acknowledge all robots, whiskers or alarms that meet conditions.
    Bulk(bulk::BulkArgs),
    /// Create, list and revoke API tokens.
    Token(token::TokenArgs),
    /// Copy a SQLite database to a file while a supervisor uses it, and verify the copy.
    Backup(backup::BackupArgs),
    /// Export contacts, minutes, hours, decisions or errors to CSV or Parquet, or a recording to MCAP.
    Export(export::ExportArgs),
    /// Record MQTT traffic of robots and supervisors to a file for `replay`; publishes nothing.
    Record(record::RecordArgs),
    /// Print or write the MQTT contract for robot engineers: AsyncAPI 3.0 and JSON Schemas.
    Contract(contract::ContractArgs),
    /// Serve the reading operations of the API to an assistant: Model Context Protocol on standard input and output.
    Mcp(api::ConnectionArgs),
    /// Print the reference of all Prometheus metrics with labels and meaning, in Markdown.
    Metrics,
    /// Print a script with which a shell completes commands, options and words.
    Completions(completions::CompletionsArgs),
}

/// Parses the command line of a program. Ends the program after a message about a wrong one, or after `--help`.
#[must_use]
pub fn parse<C: CommandFactory + FromArgMatches>() -> C {
    let matches = lenient(C::command()).get_matches_from(std::env::args_os().map(decimal));
    C::from_arg_matches(&matches).unwrap_or_else(|problem| problem.format(&mut C::command()).exit())
}

/// Runs the program `vibrissa`.
///
/// # Errors
/// The error for the user of the command.
pub fn run(cli: Cli) -> anyhow::Result<ExitCode> {
    cli.command.run(&mut Cli::command())
}

impl Command {
    /// Runs the command; `program` is the whole command line, for completions.
    ///
    /// # Errors
    /// The error for the user of the command.
    pub fn run(self, program: &mut clap::Command) -> anyhow::Result<ExitCode> {
        let done = |()| ExitCode::SUCCESS;
        match self {
            Self::Run(args) => serve::run(&args).map(done),
            Self::Config(args) => config::run(&args, &mut stdout()).map(done),
            Self::Whiskers(args) => whiskers::whiskers(&args, &mut stdout()).map(done),
            Self::Compensations(args) => whiskers::compensations(&args, &mut stdout()).map(done),
            Self::Setpoint(args) => setpoint::run(&args, &mut stdout()),
            Self::Decommission(args) => decommission::run(&args, &mut stdout()).map(done),
            Self::Bulk(args) => bulk::run(&args, &mut stdout()),
            Self::Token(args) => token::run(&args, &mut stdout()).map(done),
            Self::Backup(args) => backup::run(&args, &mut stdout()).map(done),
            Self::Export(args) => export::run(&args, &mut stdout()).map(done),
            Self::Record(args) => record::run(&args).map(done),
            Self::Contract(args) => contract::run(&args, &mut stdout()).map(done),
            Self::Mcp(args) => mcp::run(&args, &mut stdin().lock(), &mut stdout()).map(done),
            Self::Metrics => metrics::run(&mut stdout()).map(done),
            Self::Completions(args) => Ok(completions::run(&args, program, &mut stdout()).map(done)?),
        }
    }
}
