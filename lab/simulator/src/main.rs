//! Runs a fleet of simulated robots against a broker until it is stopped.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use tracing_subscriber::EnvFilter;
use vibrissa_program::log_filter::log_filter;
use vibrissa_program::options::{decimal, lenient};
use vibrissa_program::signals::StopSignals;
use vibrissa_protocol::plain;
use vibrissa_simulator::board::{self, BoardPlan};
use vibrissa_simulator::load::{self, LoadPlan};
use vibrissa_simulator::scenario::Misbehaviour;
use vibrissa_simulator::{Authorities, Broker, Fleet, Scenario, password_in};

/// Simulated robots with soft whisker arrays, over MQTT 5.
#[derive(Debug, Parser)]
#[command(name = "vibrissa-simulator", version, subcommand_negates_reqs = true, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// Broker URL: mqtt://host[:1883], or mqtts://host[:8883] for TLS; the nodes of a cluster separated by commas
    #[arg(long, env = "VIBRISSA_MQTT_URL", default_value = "mqtt://127.0.0.1:1883", hide_env_values = true)]
    mqtt_url: String,
    /// User name of the robots; {fleet} and {robot} are replaced for each robot
    #[arg(long, env = "VIBRISSA_MQTT_USERNAME", value_name = "NAME", requires = "mqtt_password_file")]
    mqtt_username: Option<String>,
    /// File with the password of that user, the same for all robots
    #[arg(long, env = "VIBRISSA_MQTT_PASSWORD_FILE", value_name = "FILE", requires = "mqtt_username")]
    mqtt_password_file: Option<PathBuf>,
    /// PEM file of certificate authorities for the broker; default: those of the system
    #[arg(long, env = "VIBRISSA_MQTT_CA_FILE", value_name = "FILE")]
    mqtt_ca_file: Option<PathBuf>,
    /// Scenario to simulate, in TOML
    #[arg(long, env = "VIBRISSA_SCENARIO", value_name = "FILE", required = true)]
    scenario: Option<PathBuf>,
    /// File that keeps the true state of the robots (cuts, wear, faults) across restarts; created if missing
    #[arg(long, env = "VIBRISSA_STATE_FILE", value_name = "FILE")]
    state_file: Option<PathBuf>,
    /// Fault by which the robots break a rule of the contract, for tests of checkers; an unknown name lists all
    /// faults
    #[arg(long, value_name = "FAULT")]
    misbehave: Option<Misbehaviour>,
    /// Log filter, such as info or vibrissa_simulator=debug
    #[arg(long, env = "VIBRISSA_LOG", default_value = "info", value_parser = log_filter)]
    log: String,
}

/// Other commands.
#[derive(Debug, Subcommand)]
enum Command {
    /// Generate load: send contacts messages of many robots, as fast as possible or on a schedule, until all are
    /// receipted; then print the result as one line of JSON
    Load(LoadPlan),
    /// Simulate the board of one robot: its gauges and valves behind the interface of drivers, for `vibrissa-robot`
    Board(BoardPlan),
}

/// Parses a command line.
fn parsed(given: impl IntoIterator<Item = OsString>) -> Result<Arguments, clap::Error> {
    let matches = lenient(Arguments::command()).try_get_matches_from(given.into_iter().map(decimal))?;
    Arguments::from_arg_matches(&matches).map_err(|problem| problem.format(&mut Arguments::command()))
}

impl Arguments {
    fn broker(&self) -> anyhow::Result<Broker> {
        let mut broker = Broker::from_url(&self.mqtt_url)?;
        if let Some(path) = &self.mqtt_ca_file {
            anyhow::ensure!(broker.tls.is_some(), "--mqtt-ca-file requires mqtts:// in --mqtt-url");
            broker.tls = Some(Authorities::File(path.clone()));
        }
        if let (Some(user), Some(path)) = (&self.mqtt_username, &self.mqtt_password_file) {
            let password = password_in(path).context("--mqtt-password-file")?;
            broker.credentials = Some((user.clone(), password));
        }
        Ok(broker)
    }
}

fn main() -> ExitCode {
    let arguments = parsed(std::env::args_os()).unwrap_or_else(|problem| problem.exit());
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("vibrissa-simulator: {}", plain::text(&format!("{problem:#}")));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> anyhow::Result<()> {
    if let Some(Command::Board(plan)) = arguments.command {
        return tokio::runtime::Builder::new_current_thread().enable_all().build()?.block_on(board::run(plan));
    }
    if let Some(Command::Load(plan)) = arguments.command {
        // One thread, so that the generator takes as little CPU time as possible from the system under test.
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        println!("{}", serde_json::to_string(&runtime.block_on(load::run(plan, load::say_prepared))?)?);
        return Ok(());
    }
    tokio::runtime::Runtime::new()?.block_on(simulate(arguments))
}

async fn simulate(arguments: Arguments) -> anyhow::Result<()> {
    let broker = arguments.broker()?;
    vibrissa_program::log::start(EnvFilter::new(arguments.log))?;
    let scenario = arguments.scenario.as_ref().context("--scenario is missing")?;
    let path = scenario.display();
    let text = std::fs::read_to_string(scenario).with_context(|| format!("cannot read {path}"))?;
    let mut scenario = Scenario::from_toml_str(&text).with_context(|| format!("cannot simulate {path}"))?;

    if arguments.misbehave.is_some() {
        scenario.behaviour.misbehaviour = arguments.misbehave;
    }

    // Installed before the robots start, so that no signal is missed.
    let mut signals = StopSignals::install()?;
    let fleet = match &arguments.state_file {
        Some(path) => Fleet::resume(&scenario, &broker, path)?,
        None => Fleet::start(&scenario, &broker)?,
    };
    tracing::info!(fleet = %scenario.fleet, robots = fleet.robots().len(), ?broker, "running");
    signals.received().await;
    tracing::info!("stopping");
    fleet.stop().await;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arguments_of(given: &[&str]) -> Result<Arguments, String> {
        let given = ["vibrissa-simulator"].iter().chain(given).map(OsString::from);
        parsed(given).map_err(|problem| problem.to_string())
    }

    #[test]
    fn words_are_taken_in_any_case_and_numbers_with_exponents() {
        let arguments = arguments_of(&["--scenario", "x.toml", "--misbehave", "No-Receipt-Retry"]);
        let listed = arguments.expect_err("no such fault");
        let fault = listed.split_once("the faults are ").expect("the list").1.split(',').next().expect("a fault");
        let arguments = arguments_of(&["--scenario", "x.toml", "--misbehave", &fault.to_uppercase()]).expect("a fault");
        assert_eq!(arguments.misbehave.map(|one| one.to_string()).as_deref(), Some(fault));
        let arguments = arguments_of(&["load", "--rate", "1e-3", "--messages", "1e5", "--status-every-s", "5e-1"]);
        let Some(Command::Load(plan)) = arguments.expect("a load").command else { panic!("another command") };
        assert_eq!((plan.rate, plan.messages, plan.status_every_s), (Some(1e-3), 100_000, 0.5));
    }

    #[test]
    fn a_wrong_value_is_answered_with_the_permitted_ones() {
        for (given, range) in [
            (&["load", "--rate", "-0.01"][..], "must be a number above 0"),
            (&["load", "--rate", "-1e-3"], "must be a number above 0"),
            (&["load", "--status-every-s", "-1"], "must be a number from 0.1 to 10"),
            (&["load", "--patience-s", "soon"], "must be a number above 0"),
            (&["load", "--robots", "-5"], "must be a whole number from 1 to 10000"),
            (&["load", "--robots", "1e-3"], "must be a whole number from 1 to 10000"),
            (&["load", "--qos", "-1"], "[possible values: 0, 1]"),
            (&["--scenario", "x.toml", "--log", "blah=loud"], "the levels are off, error, warn, info, debug, trace"),
        ] {
            let problem = arguments_of(given).expect_err(range);
            assert!(problem.contains(range) && !problem.contains("unexpected argument"), "{given:?}: {problem}");
        }
    }
}
