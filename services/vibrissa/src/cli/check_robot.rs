//! `vibrissa check-robot`: does this robot keep the contract?

use std::io::Write;
use std::process::ExitCode;

use anyhow::{Context, bail};
use clap::Args;
use tokio::signal::unix::{SignalKind, signal};
use uuid::Uuid;
use vibrissa_protocol::{BootId, Name};

use super::config::ConfigArgs;
use super::serve::{log, runtime};
use crate::check::{CheckOptions, Outcome, Report, Timings, check};
use vibrissa_edge::ids::start_seed;
use vibrissa_supervisor::mqtt::{self, BrokerAddress, Connection, LinkState};

/// Arguments of `vibrissa check-robot`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
It talks to the robot as its supervisor would: no supervisor may own the fleet meanwhile, and none may be merely cut off. Somebody must touch \
whiskers during the check, or nothing is learned of contacts and receipts. Contacts of that time, and those that the robot \
kept, are receipted in part, and recorded nowhere.

Pressures stay within 0.01 MPa of the present setpoint of one whisker, which is put back at the end and on Ctrl-C. One setpoint is 0.001 MPa \
above the limit of the factsheet, for the robot to refuse; for limits below 0.2 MPa never above 0.2 MPa. It allows 0.002 MPa/s, and is called \
back at once if the robot takes it.

Epochs: a robot refuses what comes with a lower epoch than it has seen, until it starts again. The check uses the epoch of the last supervisor, \
which the broker retains, with higher versions; the next supervisor's epoch is higher, so that the robot obeys it at once. With an --epoch above \
that the robot must be restarted before it is supervised again.

The rules are in docs/contract-rules.md. The exit code is 0 only if none was broken.")]
pub struct CheckRobotArgs {
    /// The robot.
    #[arg(long, value_name = "NAME", value_parser = |text: &str| Name::robot(text))]
    robot: Name,
    /// The whisker to try setpoints on, as ARRAY/NUMBER; the first of its factsheet if left out.
    #[arg(long, value_name = "WHISKER", value_parser = whisker)]
    whisker: Option<(Name, u16)>,
    /// The epoch of those setpoints; the last supervisor's if left out.
    #[arg(long, value_name = "NUMBER")]
    epoch: Option<u64>,
    /// Look at a restart, too: the check says when to take the robot's power away.
    #[arg(long)]
    restart: bool,
    /// The report as one JSON object.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    config: ConfigArgs,
}

fn whisker(text: &str) -> Result<(Name, u16), String> {
    let bad = || "must be ARRAY/NUMBER, such as left/0".to_owned();
    let (array, number) = text.split_once('/').ok_or_else(bad)?;
    Ok((Name::new(array).map_err(|problem| problem.to_string())?, number.parse().map_err(|_| bad())?))
}

/// Checks a robot, and prints what was found.
///
/// # Errors
/// It cannot be checked: there is no broker, a supervisor owns the fleet, or the robot is not there.
pub fn run(args: &CheckRobotArgs, out: &mut impl Write) -> anyhow::Result<ExitCode> {
    let config = args.config.read()?;
    let Some(broker) = &config.broker else { bail!("say where the robot is: --broker mqtt://HOST:1883, or mqtt.url") };
    let [fleet] = &config.fleets[..] else { bail!("say which fleet the robot is of, and one only: --fleet") };
    log(&config.log);
    let options = CheckOptions {
        fleet: fleet.clone(),
        robot: args.robot.clone(),
        whisker: args.whisker.clone(),
        epoch: args.epoch,
        restart: args.restart,
        timings: Timings::default(),
    };
    let report = runtime()?.block_on(checked(broker, options))?;
    if args.json {
        serde_json::to_writer_pretty(&mut *out, &report)?;
        writeln!(out)?;
    } else {
        write!(out, "{report}")?;
    }
    out.flush()?;
    let is_whole = !report.is_interrupted;
    Ok(if is_whole && report.count(Outcome::Fail) == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

async fn checked(broker: &BrokerAddress, options: CheckOptions) -> anyhow::Result<Report> {
    let mark = format!("c{}", Uuid::new_v5(&Uuid::NAMESPACE_OID, &start_seed()).simple());
    let connection = Connection {
        broker: broker.clone(),
        prepared: mqtt::prepare(broker)?,
        fleet: options.fleet.clone(),
        boot_id: BootId::new(&mark).context("a name for the connection")?,
        epoch: 0,
        link: LinkState::default(),
    };
    let mut terminate = signal(SignalKind::terminate()).context("waiting for SIGTERM")?;
    let stop = async {
        tokio::select! {
            _ = tokio::signal::ctrl_c() => {}
            _ = terminate.recv() => {}
        }
        eprintln!("vibrissa: stopping; the pressure is put back first");
    };
    let (usual, most) = options.timings.expected(options.restart);
    let robot = &options.robot;
    eprintln!("vibrissa: checking {robot}: about {} s if all is well, {} s at most", usual.as_secs(), most.as_secs());
    check(&connection, options, &mut |progress| eprintln!("vibrissa: {progress}"), stop).await
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whisker_is_an_array_and_a_number() {
        assert_eq!(whisker("left/3"), Ok((Name::new("left").unwrap(), 3)));
        for bad in ["", "left", "left/", "/3", "left/-1", "left/65536", "left/1/2"] {
            assert!(whisker(bad).is_err(), "{bad}");
        }
    }
}
