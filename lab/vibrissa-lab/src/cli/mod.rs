//! The command line of the laboratory.

mod bench_table;
pub mod calibrate;
pub mod check_robot;
pub mod demo;
pub mod evaluate;
pub mod paper;
pub mod replay;
pub mod simulate;
pub mod solve;
pub mod validate;

mod assistant;

use std::io::stdout;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use vibrissa::cli::Command as Service;

/// Supervisor for fleets of robots with soft whisker arrays, and its laboratory: demo, check of robots, replay, models.
#[derive(Debug, Parser)]
#[command(version, about, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a demonstration of half a minute: broker, supervisor, database and a simulated fleet in one process.
    Demo(demo::DemoArgs),
    /// Check rule by rule whether a robot conforms to the contract, in the place of its supervisor.
    CheckRobot(check_robot::CheckRobotArgs),
    /// Replay recorded traffic through the core: print every effect as a line of JSON, or compare two policies.
    Replay(replay::ReplayArgs),
    /// Run supervisors and robots in simulated time under drawn faults, and look for violated invariants.
    Simulate(simulate::SimulateArgs),
    /// Solve the model for the pressure at which one whisker feels like another.
    Solve(solve::SolveArgs),
    /// Print the paper's results beside the model's, and draw its curves.
    Paper(paper::PaperArgs),
    /// Evaluate the core on simulated whiskers whose true state is known.
    Evaluate(evaluate::EvaluateArgs),
    /// Fit a whisker's calibration to readings of a bench: pressure, strain, elongation, contacts.
    Calibrate(calibrate::CalibrateArgs),
    /// Compare readings of a bench with a calibration, and draw the paper's figures for the whisker.
    Validate(validate::ValidateArgs),
    #[command(flatten)]
    Service(Service),
}

/// Runs a command.
///
/// # Errors
/// The error for the user of the command.
pub fn run(cli: Cli) -> anyhow::Result<ExitCode> {
    let done = |()| ExitCode::SUCCESS;
    match cli.command {
        Command::Demo(args) => demo::run(args).map(|passed| if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE }),
        Command::CheckRobot(args) => check_robot::run(&args, &mut stdout()),
        Command::Replay(args) => replay::run(&args, &mut stdout().lock()).map(done),
        Command::Simulate(args) => simulate::run(&args, &mut stdout()),
        Command::Solve(args) => solve::run(&args, &mut stdout()),
        Command::Paper(args) => paper::run(&args, &mut stdout()).map(done),
        Command::Evaluate(args) => evaluate::run(&args, &mut stdout()).map(done),
        Command::Calibrate(args) => calibrate::run(&args, &mut stdout()).map(done),
        Command::Validate(args) => validate::run(&args, &mut stdout()),
        Command::Service(command) => command.run(&mut Cli::command()),
    }
}

#[cfg(test)]
mod tests {
    use clap::{Command, CommandFactory};
    use vibrissa_program::options::lenient;

    use super::Cli;

    fn options(command: &Command, seen: &mut u32) {
        for arg in command.get_arguments().filter(|arg| arg.get_action().takes_values() && !arg.is_positional()) {
            let name = format!("{} --{}", command.get_name(), arg.get_id());
            assert!(arg.is_allow_negative_numbers_set(), "{name}");
            assert!(arg.is_ignore_case_set(), "{name}");
            *seen += 1;
        }
        command.get_subcommands().for_each(|command| options(command, seen));
    }

    #[test]
    fn every_option_of_every_command_takes_numbers_below_zero_and_words_in_any_case() {
        let mut seen = 0;
        options(&lenient(Cli::command()), &mut seen);
        assert!(seen > 100, "{seen} options");
    }
}
