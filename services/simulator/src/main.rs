//! Runs a fleet of simulated robots against a broker until it is told to stop.

use std::io::{IsTerminal, stderr};
use std::path::PathBuf;

use anyhow::Context;
use clap::{Parser, Subcommand};
use tokio::signal::unix::{SignalKind, signal};
use tracing_subscriber::EnvFilter;
use vibrissa_simulator::load::{self, LoadPlan};
use vibrissa_simulator::scenario::Misbehaviour;
use vibrissa_simulator::{Authorities, Broker, Fleet, Scenario};

/// A fleet of simulated robots with soft whisker arrays, over MQTT 5.
#[derive(Debug, Parser)]
#[command(name = "vibrissa-simulator", version, subcommand_negates_reqs = true, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// The broker: mqtt://host[:1883], or mqtts://host[:8883] for TLS
    #[arg(long, env = "VIBRISSA_MQTT_URL", default_value = "mqtt://127.0.0.1:1883", hide_env_values = true)]
    mqtt_url: String,
    /// As whom robots connect; {fleet} and {robot} stand for each robot's
    #[arg(long, env = "VIBRISSA_MQTT_USERNAME", value_name = "NAME", requires = "mqtt_password_file")]
    mqtt_username: Option<String>,
    /// A file with the password for it, one for all robots
    #[arg(long, env = "VIBRISSA_MQTT_PASSWORD_FILE", value_name = "FILE", requires = "mqtt_username")]
    mqtt_password_file: Option<PathBuf>,
    /// PEM certificates of the authorities that the broker's may come from; the system's if left out
    #[arg(long, env = "VIBRISSA_MQTT_CA_FILE", value_name = "FILE")]
    mqtt_ca_file: Option<PathBuf>,
    /// What to simulate, in TOML
    #[arg(long, env = "VIBRISSA_SCENARIO", value_name = "FILE", required = true)]
    scenario: Option<PathBuf>,
    /// A file that keeps the truth about the robots over restarts: cuts, wear, faults. It is made if it is not there
    #[arg(long, env = "VIBRISSA_STATE_FILE", value_name = "FILE")]
    state_file: Option<PathBuf>,
    /// A rule of the contract that the robots break, to test what tests robots; a wrong name tells all that there are
    #[arg(long, value_name = "FAULT")]
    misbehave: Option<Misbehaviour>,
    /// What to log, such as info or vibrissa_simulator=debug
    #[arg(long, env = "VIBRISSA_LOG", default_value = "info")]
    log: EnvFilter,
}

/// What else it can do.
#[derive(Debug, Subcommand)]
enum Command {
    /// Makes load: contacts messages of many robots, as fast as they go or on a schedule, until all are receipted; then
    /// prints what came of it as one line of JSON
    Load(LoadPlan),
}

impl Arguments {
    fn broker(&self) -> anyhow::Result<Broker> {
        let mut broker = Broker::from_url(&self.mqtt_url)?;
        if let Some(path) = &self.mqtt_ca_file {
            anyhow::ensure!(broker.tls.is_some(), "--mqtt-ca-file is of no use without mqtts:// in --mqtt-url");
            broker.tls = Some(Authorities::File(path.clone()));
        }
        if let (Some(user), Some(path)) = (&self.mqtt_username, &self.mqtt_password_file) {
            let password = std::fs::read_to_string(path)
                .with_context(|| format!("--mqtt-password-file: cannot read {}", path.display()))?;
            // Editors end the last line.
            broker.credentials = Some((user.clone(), password.trim_end_matches(['\n', '\r']).to_owned()));
        }
        Ok(broker)
    }
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    if let Some(Command::Load(plan)) = arguments.command {
        // One thread: what the generator takes is taken from what it measures.
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        println!("{}", serde_json::to_string(&runtime.block_on(load::run(plan, load::say_prepared))?)?);
        return Ok(());
    }
    tokio::runtime::Runtime::new()?.block_on(simulate(arguments))
}

async fn simulate(arguments: Arguments) -> anyhow::Result<()> {
    let broker = arguments.broker()?;
    // Colours are for terminals, and for people who have not asked for none.
    let has_colours = stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|asked| asked.is_empty());
    tracing_subscriber::fmt().with_env_filter(arguments.log).with_writer(stderr).with_ansi(has_colours).init();
    let scenario = arguments.scenario.as_ref().context("--scenario is missing")?;
    let path = scenario.display();
    let text = std::fs::read_to_string(scenario).with_context(|| format!("cannot read {path}"))?;
    let mut scenario = Scenario::from_toml_str(&text).with_context(|| format!("cannot simulate {path}"))?;

    if arguments.misbehave.is_some() {
        scenario.behaviour.misbehaviour = arguments.misbehave;
    }

    // Before the robots start: a signal during the start is not missed.
    let mut terminated = signal(SignalKind::terminate())?;
    let fleet = match &arguments.state_file {
        Some(path) => Fleet::resume(&scenario, &broker, path)?,
        None => Fleet::start(&scenario, &broker)?,
    };
    tracing::info!(fleet = %scenario.fleet, robots = fleet.robots().len(), ?broker, "running");
    tokio::select! {
        _ = terminated.recv() => {}
        interrupted = tokio::signal::ctrl_c() => interrupted?,
    }
    tracing::info!("stopping");
    fleet.stop().await;
    Ok(())
}
