//! The agent of one robot: between its driver and the broker.

use std::io::stdout;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use clap::{CommandFactory, Parser, Subcommand};
use tokio::runtime::Runtime;
use tokio::sync::watch;
use tracing_subscriber::EnvFilter;
use vibrissa_host::task;
use vibrissa_program::completions::{self, CompletionsArgs};
use vibrissa_program::log;
use vibrissa_program::log_filter::log_filter;
use vibrissa_program::signals::StopSignals;
use vibrissa_protocol::plain;
use vibrissa_robot::{Config, calibrate, discover, exposure, hub, monitor, preflight};

/// The agent of one robot with soft whiskers: keeps the MQTT contract for a driver that speaks lines of JSON.
#[derive(Debug, Parser)]
#[command(name = "vibrissa-robot", version)]
struct Arguments {
    /// Configuration of the robot, in TOML
    #[arg(long, global = true, env = "VIBRISSA_ROBOT_CONFIG", value_name = "FILE", default_value = "agent.toml")]
    config: PathBuf,
    /// Only check the configuration, and what it names on this machine
    #[arg(long)]
    check: bool,
    /// Log filter, such as info or vibrissa_robot=debug
    #[arg(long, env = "VIBRISSA_LOG", default_value = "info", value_parser = log_filter)]
    log: String,
    #[command(subcommand)]
    command: Option<Command>,
}

/// Commands other than running the agent.
#[derive(Debug, Subcommand)]
enum Command {
    /// Show the running agent: a line for each whisker, each second, with what to do
    Monitor {
        /// Show it once
        #[arg(long)]
        once: bool,
    },
    /// Measure gauges, slides, pressure sensors and valves step by step, and write agent.toml. End the agent first. The chambers
    /// stay below a fifth of pressure_max_mpa, and are empty at the end. A calibration that was stopped goes on.
    Calibrate {
        /// Whiskers such as left/0 instead of all
        whiskers: Vec<String>,
        /// Forget what a calibration that was stopped has found
        #[arg(long)]
        again: bool,
    },
    /// List the serial devices of this machine, and what speaks there
    Discover {
        /// Devices to listen at instead of all
        devices: Vec<PathBuf>,
    },
    /// Print a script with which a shell completes commands and options
    Completions(CompletionsArgs),
}

/// Why a program that is its own driver cannot be calibrated.
const NOT_REACHED: &str = "no driver can be reached, because [driver] names no way: the robot's program is the driver. End it, and \
    name a way to the boards for the calibration, such as serial; it has no effect on the program";

/// The agent of a robot in Python reads a file without a way to a driver; there is none to check.
fn checked(path: &Path) -> anyhow::Result<()> {
    let (mut config, is_driven) = Config::read_either(path).with_context(|| path.display().to_string())?;
    config.broker.transport()?;
    if is_driven {
        config.drivers.clear();
    }
    let problems = preflight::problems(&config);
    if !problems.is_empty() {
        anyhow::bail!("{}: {}", path.display(), problems.join("\n  "));
    }
    println!("{}: robot {} of fleet {} is well configured", path.display(), config.robot, config.fleet);
    if is_driven {
        println!(
            "warning: [driver] names no way, so that only a program that is the driver can use the file, such as one in Python: \
             vibrissa-robot itself does not start with it"
        );
    }
    preflight::remarks(&config).iter().for_each(|remark| println!("{remark}"));
    exposure::exposures(path, &config).iter().for_each(|exposure| println!("warning: {exposure}"));
    Ok(())
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let logged = log::start(EnvFilter::new(&arguments.log)).map_err(anyhow::Error::from);
    let Arguments { config, check, command, .. } = arguments;
    match logged.and_then(|()| started(&config, check, command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("vibrissa-robot: {}", plain::text(&format!("{problem:#}")));
            ExitCode::FAILURE
        }
    }
}

/// One thread: a robot has few messages, and each thread costs memory.
fn runtime() -> std::io::Result<Runtime> {
    tokio::runtime::Builder::new_current_thread().enable_all().max_blocking_threads(2).build()
}

fn started(path: &Path, is_check: bool, command: Option<Command>) -> anyhow::Result<()> {
    if let Some(Command::Discover { devices }) = command {
        runtime()?.block_on(discover::discover(devices));
        return Ok(());
    }
    if let Some(Command::Completions(shell)) = command {
        return Ok(completions::run(&shell, &mut Arguments::command(), &mut stdout())?);
    }
    if let Some(Command::Monitor { once }) = command {
        let (config, _) = Config::read_either(path).with_context(|| path.display().to_string())?;
        return runtime()?.block_on(monitor::watch(&config, once));
    }
    if is_check {
        return checked(path);
    }
    if matches!(command, Some(Command::Calibrate { .. })) && Config::read_either(path).is_ok_and(|(_, driven)| driven) {
        anyhow::bail!("{}: {NOT_REACHED}", path.display());
    }
    let config = Config::read(path).with_context(|| path.display().to_string())?;
    if let Some(Command::Calibrate { whiskers, again }) = command {
        let runtime = runtime()?;
        let outcome = runtime.block_on(calibrate::calibrate(&config, path, &whiskers, again));
        // A thread still waits for a line of the terminal.
        runtime.shutdown_background();
        return outcome;
    }
    exposure::warn(path, &config);
    runtime()?.block_on(async {
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
