//! Runs a fleet of simulated robots against a broker until it is told to stop.

use std::path::PathBuf;

use anyhow::Context;
use clap::Parser;
use tokio::signal::unix::{SignalKind, signal};
use tracing_subscriber::EnvFilter;
use vibrissa_simulator::{Broker, Fleet, Scenario};

/// A fleet of simulated robots with soft whisker arrays, over MQTT 5.
#[derive(Debug, Parser)]
#[command(name = "vibrissa-simulator", version)]
struct Arguments {
    /// The broker: mqtt://[user:password@]host[:port]
    #[arg(long, env = "VIBRISSA_MQTT_URL", default_value = "mqtt://127.0.0.1:1883", hide_env_values = true)]
    mqtt_url: String,
    /// What to simulate, in TOML
    #[arg(long, env = "VIBRISSA_SCENARIO", value_name = "FILE")]
    scenario: PathBuf,
    /// What to log, such as info or vibrissa_simulator=debug
    #[arg(long, env = "VIBRISSA_LOG", default_value = "info")]
    log: EnvFilter,
}

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    tracing_subscriber::fmt().with_env_filter(arguments.log).with_writer(std::io::stderr).init();
    let path = arguments.scenario.display();
    let text = std::fs::read_to_string(&arguments.scenario).with_context(|| format!("cannot read {path}"))?;
    let scenario = Scenario::from_toml_str(&text).with_context(|| format!("cannot simulate {path}"))?;
    let broker = Broker::from_url(&arguments.mqtt_url)?;

    // Before the robots start: a signal during the start is not missed.
    let mut terminated = signal(SignalKind::terminate())?;
    let fleet = Fleet::start(&scenario, &broker)?;
    tracing::info!(fleet = %scenario.fleet, robots = fleet.robots().len(), ?broker, "running");
    tokio::select! {
        _ = terminated.recv() => {}
        interrupted = tokio::signal::ctrl_c() => interrupted?,
    }
    tracing::info!("stopping");
    fleet.stop().await;
    Ok(())
}
