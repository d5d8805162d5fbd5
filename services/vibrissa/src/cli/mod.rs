//! The command line.

pub mod api;
pub mod backup;
pub mod bulk;
pub mod calibrate;
pub mod check_robot;
pub mod completions;
pub mod config;
pub mod contract;
pub mod decommission;
pub mod evaluate;
pub mod export;
pub mod metrics;
pub mod paper;
pub mod record;
pub mod replay;
pub mod serve;
pub mod setpoint;
pub mod solve;
pub mod stop;
pub mod table;
pub mod token;
pub mod watch;
pub mod whiskers;

mod assistant;
mod progress;
mod words;

use std::io::stdout;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use vibrissa_simulator::options::{decimal, lenient};

/// Exit code of a command that has worked, and whose answer is no.
pub const ANSWER_IS_NO: u8 = 3;

/// Supervisor for fleets of robots with soft whisker arrays.
#[derive(Debug, Parser)]
#[command(version, about, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the supervisor of one or more fleets.
    Run(config::ConfigArgs),
    /// Print the configuration in effect, each key with its source; passwords are hidden.
    Config(config::ConfigArgs),
    /// Run a demonstration of half a minute: broker, supervisor, database and a simulated fleet in one process.
    Demo(serve::DemoArgs),
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
    /// Check rule by rule whether a robot conforms to the contract, in the place of its supervisor.
    CheckRobot(check_robot::CheckRobotArgs),
    /// Replay recorded traffic through the core: print every effect as a line of JSON, or compare two policies.
    Replay(replay::ReplayArgs),
    /// Solve the model for the pressure at which one whisker feels like another.
    Solve(solve::SolveArgs),
    /// Print the paper's results beside the model's, and draw its curves.
    Paper(paper::PaperArgs),
    /// Evaluate the core on simulated whiskers whose true state is known.
    Evaluate(evaluate::EvaluateArgs),
    /// Fit a whisker's calibration to measurements of its chamber.
    Calibrate(calibrate::CalibrateArgs),
    /// Print or write the MQTT contract for robot engineers: AsyncAPI 3.0 and JSON Schemas.
    Contract(contract::ContractArgs),
    /// Print the reference of all Prometheus metrics with labels and meaning, in Markdown.
    Metrics,
    /// Print a script with which a shell completes commands, options and words.
    Completions(completions::CompletionsArgs),
}

/// Parses the command line. Ends the program after a message about a wrong one, or after `--help`.
#[must_use]
pub fn parse() -> Cli {
    let matches = lenient(Cli::command()).get_matches_from(std::env::args_os().map(decimal));
    Cli::from_arg_matches(&matches).unwrap_or_else(|problem| problem.format(&mut Cli::command()).exit())
}

/// Runs a command.
///
/// # Errors
/// The error for the user of the command.
pub fn run(cli: Cli) -> anyhow::Result<ExitCode> {
    match cli.command {
        Command::Run(args) => serve::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Config(args) => config::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Demo(args) => {
            serve::demo(args).map(|passed| if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
        }
        Command::Whiskers(args) => whiskers::whiskers(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Compensations(args) => whiskers::compensations(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Setpoint(args) => setpoint::run(&args, &mut stdout()),
        Command::Decommission(args) => decommission::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Bulk(args) => bulk::run(&args, &mut stdout()),
        Command::Token(args) => token::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Backup(args) => backup::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Export(args) => export::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Record(args) => record::run(&args).map(|()| ExitCode::SUCCESS),
        Command::CheckRobot(args) => check_robot::run(&args, &mut stdout()),
        Command::Replay(args) => replay::run(&args, &mut stdout().lock()).map(|()| ExitCode::SUCCESS),
        Command::Solve(args) => solve::run(&args, &mut stdout()),
        Command::Paper(args) => paper::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Evaluate(args) => evaluate::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Calibrate(args) => calibrate::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Completions(args) => completions::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Metrics => metrics::run(&mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Contract(args) => contract::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
    }
}
