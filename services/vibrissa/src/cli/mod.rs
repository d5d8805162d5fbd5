//! The command line.

pub mod api;
pub mod backup;
pub mod calibrate;
pub mod check_robot;
pub mod config;
pub mod contract;
pub mod evaluate;
pub mod metrics;
pub mod paper;
pub mod record;
pub mod replay;
pub mod serve;
pub mod solve;
pub mod stop;
pub mod table;
pub mod token;
pub mod whiskers;

use std::io::stdout;
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
    Run(config::ConfigArgs),
    /// The configuration in effect: every key, with where its value came from. Passwords are hidden.
    Config(config::ConfigArgs),
    /// See the whole job in half a minute: broker, supervisor, database and a simulated fleet in one process.
    Demo(serve::DemoArgs),
    /// Every whisker that a supervisor knows: length, health, pressure, who serves it.
    Whiskers(whiskers::WhiskersArgs),
    /// The compensations that were decided, with predicted and measured error.
    Compensations(whiskers::CompensationsArgs),
    /// Set a whisker's pressure by hand, or let the supervisor set it again.
    Setpoint(whiskers::SetpointArgs),
    /// Who may use the API: make, list and revoke tokens.
    Token(token::TokenArgs),
    /// Copy a SQLite database into a file, while a supervisor works with it; the copy is checked.
    Backup(backup::BackupArgs),
    /// Write what robots and supervisors say into a file, for `replay`. Says nothing itself.
    Record(record::RecordArgs),
    /// Does this robot keep the contract? Tests it rule by rule, as its supervisor would talk to it.
    CheckRobot(check_robot::CheckRobotArgs),
    /// Recorded traffic through the core once more: every effect as a line of JSON, or two policies compared.
    Replay(replay::ReplayArgs),
    /// One question to the model: which pressure makes this whisker feel like that one?
    Solve(solve::SolveArgs),
    /// The paper's table beside ours, and its curves.
    Paper(paper::PaperArgs),
    /// How well it does, measured on simulated whiskers whose truth is known.
    Evaluate(evaluate::EvaluateArgs),
    /// A whisker's own calibration from measurements of its chamber.
    Calibrate(calibrate::CalibrateArgs),
    /// The MQTT contract for robots' engineers: AsyncAPI 3.0 and JSON Schemas.
    Contract(contract::ContractArgs),
    /// What Prometheus is told: every metric with its labels and its meaning, in Markdown.
    Metrics,
}

/// Runs a command.
///
/// # Errors
/// What went wrong, for the person who called it.
pub fn run(cli: Cli) -> anyhow::Result<ExitCode> {
    match cli.command {
        Command::Run(args) => serve::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Config(args) => config::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Demo(args) => {
            serve::demo(args).map(|passed| if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
        }
        Command::Whiskers(args) => whiskers::whiskers(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Compensations(args) => whiskers::compensations(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Setpoint(args) => whiskers::setpoint(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Token(args) => token::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Backup(args) => backup::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Record(args) => record::run(&args).map(|()| ExitCode::SUCCESS),
        Command::CheckRobot(args) => check_robot::run(&args, &mut stdout()),
        Command::Replay(args) => replay::run(&args, &mut stdout().lock()).map(|()| ExitCode::SUCCESS),
        Command::Solve(args) => solve::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Paper(args) => paper::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Evaluate(args) => evaluate::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Calibrate(args) => calibrate::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Metrics => metrics::run(&mut stdout()).map(|()| ExitCode::SUCCESS),
        Command::Contract(args) => contract::run(&args, &mut stdout()).map(|()| ExitCode::SUCCESS),
    }
}
