//! The agent of one robot: between its driver and the broker.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use tokio::sync::watch;
use tracing_subscriber::EnvFilter;
use vibrissa_host::task;
use vibrissa_program::log;
use vibrissa_program::log_filter::log_filter;
use vibrissa_program::signals::StopSignals;
use vibrissa_robot::{Config, exposure, hub};

/// The agent of one robot with soft whiskers: keeps the MQTT contract for a driver that speaks lines of JSON.
#[derive(Debug, Parser)]
#[command(name = "vibrissa-robot", version)]
struct Arguments {
    /// Configuration of the robot, in TOML
    #[arg(long, env = "VIBRISSA_ROBOT_CONFIG", value_name = "FILE", default_value = "agent.toml")]
    config: PathBuf,
    /// Only check the configuration
    #[arg(long)]
    check: bool,
    /// Log filter, such as info or vibrissa_robot=debug
    #[arg(long, env = "VIBRISSA_LOG", default_value = "info", value_parser = log_filter)]
    log: String,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let logged = log::start(EnvFilter::new(arguments.log)).map_err(anyhow::Error::from);
    match logged.and_then(|()| started(&arguments.config, arguments.check)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("vibrissa-robot: {problem:#}");
            ExitCode::FAILURE
        }
    }
}

fn started(path: &std::path::Path, is_check: bool) -> anyhow::Result<()> {
    use anyhow::Context;
    let config = Config::read(path).with_context(|| path.display().to_string())?;
    if is_check {
        config.broker.transport()?;
        println!("{}: robot {} of fleet {} is well configured", path.display(), config.robot, config.fleet);
        exposure::exposures(path, &config).iter().for_each(|exposure| println!("warning: {exposure}"));
        return Ok(());
    }
    exposure::warn(path, &config);
    // One thread: a robot has few messages, and each thread costs memory.
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().max_blocking_threads(2).build()?;
    runtime.block_on(async {
        // Installed before anything starts, so that no signal is missed.
        let mut signals = StopSignals::install()?;
        let (stop, stopping) = watch::channel(false);
        let running = task::spawn(hub::run(config, stopping));
        tokio::pin!(running);
        tokio::select! {
            ended = &mut running => return Ok(ended??),
            () = signals.received() => {}
        }
        let _ = stop.send(true);
        Ok(running.await??)
    })
}
